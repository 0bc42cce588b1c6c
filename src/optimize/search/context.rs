//! Data that all strategies share: settings, time limit, observer, and the record of the
//! strategies' runs.

use crate::maneuver::settings::{Settings, Target};
use crate::maneuver::solution::{Outcome, Rung, RungReport};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::sweep::Listener;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::{Attempt, Budget, Method, Run, Watch};
use crate::optimize::search::settings::SearchTuning;
use std::cell::{Cell, RefCell};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Progress of a solve, as reported to an observer.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress<'a> {
    /// The strategy that is running.
    pub rung: Rung,
    /// Name of the start from which the strategy proceeds.
    pub start: &'a str,
    /// Number of steps of the strategy's grid.
    pub steps: usize,
    /// Seconds since the solve began.
    pub elapsed: f64,
    /// The part of a sequence that is being planned, such as "leg 2 of 5"; empty for a single
    /// maneuver.
    pub part: &'a str,
}

/// Answer of an observer: continue or stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Continue the solve.
    Continue,
    /// Stop at the next iteration; the best iterate is kept.
    Stop,
}

/// Observes a solve, and can stop it.
pub trait Observer {
    /// Reports progress: called for every strategy and between iterations.
    fn on_progress(&mut self, _progress: &Progress) -> Control {
        Control::Continue
    }

    /// Returns a flag that is set when a stop is requested. The cone solver cannot call the
    /// observer, and polls only this flag between its iterations. On fine grids it runs on a
    /// separate thread. A stopped plan does not wait for this thread, which ends with its current
    /// iteration.
    fn stop_flag(&self) -> Option<Arc<AtomicBool>> {
        None
    }
}

/// An observer that never stops a solve.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}

/// Data that all strategies share: settings, time limit, observer, and the record of the
/// strategies' runs.
pub(crate) struct Context<'a> {
    pub settings: &'a Settings,
    pub tuning: SearchTuning,
    observer: RefCell<&'a mut dyn Observer>,
    pub began: Instant,
    at: RefCell<(Rung, String, usize)>,
    stopped: Cell<Option<Outcome>>,
    flag: Option<Arc<AtomicBool>>,
    pub ladder: RefCell<Vec<RungReport>>,
}

impl<'a> Context<'a> {
    pub fn new(settings: &'a Settings, observer: &'a mut dyn Observer) -> Self {
        Self {
            settings,
            tuning: SearchTuning::default(),
            flag: observer.stop_flag(),
            observer: RefCell::new(observer),
            began: Instant::now(),
            at: RefCell::new((Rung::Newton, "ballistic".into(), 0)),
            stopped: Cell::new(None),
            ladder: RefCell::default(),
        }
    }

    /// Returns whether the true motion of a plan must meet the end (landing).
    pub fn lands(&self) -> bool {
        self.settings.target == Target::Motion
    }

    /// Announces the strategy that now runs, for progress reports.
    pub fn enter(&self, rung: Rung, start: &str, steps: usize) {
        *self.at.borrow_mut() = (rung, start.into(), steps);
    }

    /// Returns the instant at which the time limit expires; `None` without a time limit.
    pub fn deadline(&self) -> Option<Instant> {
        self.settings.time_limit.and_then(|limit| self.began.checked_add(limit))
    }

    /// Records the report of a run of a strategy.
    pub fn note(&self, rung: Rung, start: &str, steps: usize, report: Report) {
        let Report { outcome, iterations, residuals } = report;
        let start = start.into();
        self.ladder.borrow_mut().push(RungReport { rung, start, steps, outcome, iterations, residuals });
    }

    /// Calls `work` with the number of iterations that the settings allow as its budget.
    pub fn within<T>(&self, work: impl FnOnce(&Budget) -> T) -> T {
        let interrupt = || self.interrupt();
        let watch = Watch { interrupt: &interrupt, deadline: self.deadline(), flag: self.flag.as_ref() };
        work(&Budget { iterations: self.settings.max_iterations, watch })
    }

    /// Improves a candidate by a method, and records the report.
    pub fn attempt(&self, rung: Rung, method: &impl Method, candidate: Candidate) -> Attempt {
        self.noted(rung, self.tried(rung, method, candidate))
    }

    /// Improves a candidate by a method, without recording the report.
    pub fn tried(&self, rung: Rung, method: &impl Method, candidate: Candidate) -> Attempt {
        self.enter(rung, &candidate.provenance.start, candidate.steps());
        self.within(|budget| method.improve(candidate, budget))
    }

    /// Records the reports of an attempt.
    pub fn noted(&self, rung: Rung, mut attempt: Attempt) -> Attempt {
        let Attempt { candidate, work, runs, .. } = &mut attempt;
        for Run { rung: own, steps, report } in runs {
            candidate.provenance.iterations += report.iterations;
            let start = &candidate.provenance.start;
            self.note(own.unwrap_or(rung), start, *steps, report.clone());
        }
        candidate.provenance.subproblems += work.subproblems;
        attempt
    }

    /// Returns the reason to stop; `None` to continue. Once a reason is returned, it does not
    /// change.
    pub fn interrupt(&self) -> Option<Outcome> {
        if self.stopped.get().is_none() {
            let elapsed = self.began.elapsed();
            let at = self.at.borrow();
            let progress =
                Progress { rung: at.0, start: &at.1, steps: at.2, elapsed: elapsed.as_secs_f64(), part: "" };
            if self.observer.borrow_mut().on_progress(&progress) == Control::Stop {
                self.stopped.set(Some(Outcome::Interrupted));
            } else if self.settings.time_limit.is_some_and(|limit| elapsed >= limit) {
                self.stopped.set(Some(Outcome::TimeLimit));
            }
        }
        self.stopped.get()
    }
}

impl Listener for Context<'_> {
    fn asks_to_stop(&self) -> bool {
        self.interrupt().is_some()
    }
}
