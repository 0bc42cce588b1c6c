//! What every rung shares: settings, the clock, the observer, the record of what was tried.

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

/// What an observer of a solve is told.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress<'a> {
    /// The rung at work.
    pub rung: Rung,
    /// The start it works on.
    pub start: &'a str,
    /// Steps of its grid.
    pub steps: usize,
    /// Seconds since the solve began.
    pub elapsed: f64,
    /// The part of a sequence that is planned, such as "leg 2 of 5"; empty for one maneuver.
    pub part: &'a str,
}

/// Whether to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Go on.
    Continue,
    /// Stop at the next iteration; the best iterate is kept.
    Stop,
}

/// Watches a solve, and may stop it.
pub trait Observer {
    /// Called at every rung and between iterations.
    fn on_progress(&mut self, _progress: &Progress) -> Control {
        Control::Continue
    }

    /// A flag that is set where somebody asks to stop. Inside the cone solver nobody can be called:
    /// between its iterations it looks at this flag alone. On fine grids it works on a thread of
    /// its own, which a plan that is stopped leaves behind: it ends with the iteration under way.
    fn stop_flag(&self) -> Option<Arc<AtomicBool>> {
        None
    }
}

/// Nobody watches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}

/// What every rung shares: settings, the clock, the observer, the record of what was tried.
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

    /// Whether plans are to land.
    pub fn lands(&self) -> bool {
        self.settings.target == Target::Motion
    }

    /// Announces a rung.
    pub fn enter(&self, rung: Rung, start: &str, steps: usize) {
        *self.at.borrow_mut() = (rung, start.into(), steps);
    }

    /// When the time limit is over.
    pub fn deadline(&self) -> Option<Instant> {
        self.settings.time_limit.and_then(|limit| self.began.checked_add(limit))
    }

    /// Notes how a run of a rung went.
    pub fn note(&self, rung: Rung, start: &str, steps: usize, report: Report) {
        let Report { outcome, iterations, residuals } = report;
        let start = start.into();
        self.ladder.borrow_mut().push(RungReport { rung, start, steps, outcome, iterations, residuals });
    }

    /// Hands a budget to `work`, with as many iterations as the settings allow.
    pub fn within<T>(&self, work: impl FnOnce(&Budget) -> T) -> T {
        let interrupt = || self.interrupt();
        let watch = Watch { interrupt: &interrupt, deadline: self.deadline(), flag: self.flag.as_ref() };
        work(&Budget { iterations: self.settings.max_iterations, watch })
    }

    /// Has a method improve a candidate, and notes how that went.
    pub fn attempt(&self, rung: Rung, method: &impl Method, candidate: Candidate) -> Attempt {
        self.noted(rung, self.tried(rung, method, candidate))
    }

    /// Has a method improve a candidate.
    pub fn tried(&self, rung: Rung, method: &impl Method, candidate: Candidate) -> Attempt {
        self.enter(rung, &candidate.provenance.start, candidate.steps());
        self.within(|budget| method.improve(candidate, budget))
    }

    /// Notes how a try went.
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

    /// Whether something asks to stop; sticky.
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
