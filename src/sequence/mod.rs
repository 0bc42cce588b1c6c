//! Several stops in one plan: attitudes and pointings, in a given order or in the best one.
//!
//! A leg leads from one stop to the next. Legs between given attitudes at rest are planned
//! independently. If a stop leaves a quantity free on which both of its legs depend (a roll, the
//! rate of a passage, the division of the total duration), the legs are planned together
//! (`together`). The best order of stops is found from the costs of the legs between all pairs
//! ([`order`]). Every rest-to-rest leg has a rigorous lower bound ([`leg_bound`]). The legs of a
//! spacecraft can be tabulated ([`table`]).

mod arrivals;
mod carried;
pub mod flown;
pub mod joined;
mod joint;
mod leg;
pub mod leg_bound;
mod legs;
pub mod order;
mod pairs;
mod rolls;
pub mod symmetry;
pub mod table;
mod together;
pub mod tracked;
mod windows;

pub use flown::WholeMotion;
pub use leg_bound::LegBound;
pub use symmetry::Symmetry;
pub use table::{Making, Quantity, SlewTable, TableError, TableOptions};
pub use tracked::Hold;

use crate::maneuver::aim::{Aim, AimError, AimRate, Ends};
use crate::maneuver::constraint::Direction;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{EndCondition, Problem, State};
use crate::maneuver::settings::Settings;
use crate::optimize::search::{Control, Observer, PlanError, Progress};
use crate::plan::{Plan, Status};
use crate::{Matrix3, Vector3};
use joined::{Flown, Joined};
use joint::Joint;
use legs::Legs;
use order::{Order, Visit};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use thiserror::Error;
use windows::Missed;

/// The attitude or pointing direction that a stop requires.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// An attitude, from body to reference axes.
    Attitude(Matrix3),
    /// A boresight points at a target.
    Aim(Aim),
}

impl Place {
    /// Returns `true` if the two places are equal, up to round-off of the attitudes.
    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Attitude(one), Self::Attitude(other)) => (one - other).amax() <= 8.0 * f64::EPSILON,
            (Self::Aim(one), Self::Aim(other)) => one == other,
            _ => false,
        }
    }
}

/// A stop of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// Name of the stop, used in messages and results.
    pub name: String,
    /// Attitude or pointing direction at the stop.
    pub place: Place,
    /// Settling time, hold and window of the stop.
    pub visit: Visit,
    /// Maximum angular rate \[rad/s\] at which the body passes without stopping; infinite without a
    /// maximum. `None` if the body stops.
    pub passing: Option<f64>,
}

impl Stop {
    /// Builds a stop at rest without a hold.
    pub fn at(name: &str, place: Place) -> Self {
        Self { name: name.into(), place, visit: Visit::PASSED, passing: None }
    }

    /// Sets the duration of the hold \[s\].
    pub fn held(mut self, hold: f64) -> Self {
        self.visit.hold = hold;
        self
    }

    /// Lets the body pass this stop without stopping, at a rate of at most `fastest` \[rad/s\].
    pub fn passed_at_most_at(self, fastest: f64) -> Self {
        Self { passing: Some(fastest), ..self }
    }
}

/// The order in which the stops are visited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ordering {
    /// The given order.
    Given,
    /// The best order, which the planner finds.
    Free,
    /// The best order in which the given last stop remains the last one.
    FreeBeforeLast,
}

/// A spacecraft, its start and its stops.
///
/// The objective of `craft` applies to the sum over all legs. Its duration is the total duration of
/// the sequence, including holds. Its start is the start of the first leg; its end is not used.
#[derive(Clone, Debug)]
pub struct Sequence {
    /// The spacecraft with its start, objective, limits and constraints.
    pub craft: Problem,
    /// The stops.
    pub stops: Vec<Stop>,
    /// The order in which the stops are visited.
    pub order: Ordering,
}

/// The reason why a sequence cannot be planned.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SequenceError {
    /// The planner rejects the maneuver or the settings of a leg.
    #[error("the leg to stop `{stop}`: {error}")]
    Leg {
        /// Name of the stop at the end of the leg.
        stop: String,
        /// The error of the leg.
        error: PlanError,
    },
    /// The target of a stop does not determine a state of the body.
    #[error("stop `{stop}`: {error}")]
    Aim {
        /// Name of the stop.
        stop: String,
        /// The error of the pointing.
        error: AimError,
    },
    /// The sequence has a property that is not supported; the text names it.
    #[error("{0}")]
    Unsupported(&'static str),
    /// The holds leave no time for the legs.
    #[error("the holds take {holds} s of the total duration of {total} s: give more time")]
    NoTime {
        /// Sum of all holds and settling times \[s\].
        holds: f64,
        /// Total duration of the sequence \[s\].
        total: f64,
    },
    /// A hold ends after the time until which the targets and cones are known.
    #[error("targets and cones are known until {known} s, and the hold at stop `{stop}` ends at {end} s")]
    Beyond {
        /// Name of the stop.
        stop: String,
        /// End of the hold at this stop \[s\].
        end: f64,
        /// Time until which all targets and cones are known \[s\].
        known: f64,
    },
    /// No plan can keep the windows of these stops, as lower bounds on the legs prove.
    #[error("no plan can keep the window of {stops}: the hold begins at least {late:.3} s late")]
    Windows {
        /// Name of the stop, or names of two stops whose windows exclude each other.
        stops: String,
        /// Lower bound of the delay by which a hold begins too late \[s\].
        late: f64,
    },
    /// The caller or the time limit stopped the search before any leg had a final plan.
    #[error("the search was stopped before any leg had a plan")]
    Stopped(Status),
    /// No plan was found for legs that are planned together.
    #[error("no plan was found for the legs to stop `{stop}`")]
    NoPlan {
        /// Name of the stop at the end of the leg, or names of several stops.
        stop: String,
    },
}

impl SequenceError {
    /// Returns the status to report if planning failed; `None` if the sequence itself is invalid.
    pub fn status(&self) -> Option<Status> {
        match self {
            Self::Windows { .. } => Some(Status::Infeasible),
            Self::NoPlan { .. } => Some(Status::NotConverged),
            Self::Stopped(status) => Some(*status),
            Self::Leg { .. }
            | Self::Aim { .. }
            | Self::Unsupported(_)
            | Self::NoTime { .. }
            | Self::Beyond { .. } => None,
        }
    }
}

/// An observer that stops planning at the time limit of the whole sequence.
struct Limited<'a> {
    observer: &'a mut dyn Observer,
    /// The instant at which planning must end; `None` without a time limit.
    until: Option<Instant>,
    /// Whether the time limit stopped the planning.
    reached: bool,
}

impl Limited<'_> {
    /// Returns the status of a plan that stopped with the status `stopped`: an interruption by the
    /// time limit is reported as such.
    fn status(&self, stopped: Status) -> Status {
        if self.reached && stopped == Status::Interrupted { Status::LimitReached } else { stopped }
    }
}

impl Observer for Limited<'_> {
    fn on_progress(&mut self, progress: &Progress) -> Control {
        self.reached |= self.until.is_some_and(|until| Instant::now() >= until);
        if self.reached { Control::Stop } else { self.observer.on_progress(progress) }
    }

    fn stop_flag(&self) -> Option<Arc<AtomicBool>> {
        self.observer.stop_flag()
    }
}

/// An observer of the part of a sequence that is planned.
struct Part<'a> {
    observer: &'a mut dyn Observer,
    part: String,
}

impl Observer for Part<'_> {
    fn on_progress(&mut self, progress: &Progress) -> Control {
        self.observer.on_progress(&Progress { part: &self.part, ..progress.clone() })
    }

    fn stop_flag(&self) -> Option<Arc<AtomicBool>> {
        self.observer.stop_flag()
    }
}

/// A leg of the plan of a sequence.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PlannedLeg {
    /// The maneuver of the leg, with the end states and the duration that the planner chose.
    pub problem: Problem,
    /// The plan of the leg.
    pub plan: Plan,
    /// Index of the stop at the end of the leg, in the list of stops of the sequence.
    pub stop: usize,
    /// Start time of the leg in the sequence \[s\].
    pub begins: f64,
    /// Start and end time in the sequence of the hold after the leg \[s\].
    pub holds: [f64; 2],
    /// The motion from the arrival to the end of the hold, if the target or a cone moves. `None` if
    /// the body rests.
    pub hold: Option<Hold>,
}

impl PlannedLeg {
    /// Returns the status of the leg; if the leg is solved, the status of its hold.
    fn status(&self) -> Status {
        match (&self.hold, self.plan.status) {
            (Some(hold), Status::Solved) => hold.plan.status,
            (_, status) => status,
        }
    }
}

/// The plan of a sequence.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SequencePlan {
    /// The legs in the order in which they are flown.
    pub legs: Vec<PlannedLeg>,
    /// The order that was found from the legs between all pairs of stops; `None` if no order was
    /// searched for.
    pub order: Option<Order>,
    /// Sum of the costs of all legs, in the unit of the objective.
    pub cost: f64,
    /// The end of the last hold \[s\].
    pub end: f64,
    /// Sum of the delays past the windows of all stops \[s\].
    pub late: f64,
    /// Status of the search if it stopped before the last stop; `None` if it did not stop early.
    pub cut: Option<Status>,
}

impl SequencePlan {
    /// Returns the status of the plan: solved if every leg is solved and no window is missed.
    /// Otherwise it gives the reason, such as the status of the leg that is not solved, which is
    /// the last planned leg.
    pub fn status(&self) -> Status {
        let failed = self.legs.iter().map(PlannedLeg::status).find(|status| *status != Status::Solved);
        failed.or(self.cut).unwrap_or(if self.late > 0.0 { Status::NotConverged } else { Status::Solved })
    }

    /// Replaces each status in this plan (of the search, the legs and the holds) by the value that
    /// the function `status` returns for it.
    fn with_stopped(mut self, status: impl Fn(Status) -> Status) -> Self {
        self.cut = self.cut.map(&status);
        for leg in &mut self.legs {
            leg.plan.status = status(leg.plan.status);
            if let Some(hold) = &mut leg.hold {
                hold.plan.status = status(hold.plan.status);
            }
        }
        self
    }

    /// Returns the motion over all legs and the holds and rests between them.
    pub fn joined(&self) -> Joined {
        Joined::of(self.legs.iter().map(|leg| Flown {
            path: &leg.plan.solution.trajectory,
            begins: leg.begins,
            hold: leg.hold.as_ref().map(|hold| &hold.plan.solution.trajectory),
            until: leg.holds[1],
        }))
    }
}

impl Sequence {
    /// Plans the sequence: finds the order and the free quantities at the stops, then plans each
    /// leg with [`plan()`]. If a leg does not converge, it is the last leg of the plan.
    ///
    /// # Errors
    /// [`SequenceError`] if no plan is found for legs that are planned together, or if the planner
    /// rejects a leg.
    pub fn plan(
        &self,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<SequencePlan, SequenceError> {
        // The time limit applies to the whole sequence, so the legs have no time limit.
        let until = settings.time_limit.and_then(|limit| Instant::now().checked_add(limit));
        let settings = &Settings { time_limit: None, ..settings.clone() };
        let mut limited = Limited { observer, until, reached: false };
        let found = self.planned(settings, &mut limited);
        found.map(|plan| plan.with_stopped(|status| limited.status(status))).map_err(|error| match error {
            SequenceError::Stopped(status) => SequenceError::Stopped(limited.status(status)),
            error => error,
        })
    }

    fn planned(
        &self,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<SequencePlan, SequenceError> {
        self.check()?;
        if let Some(Missed { stops, late }) = windows::missed(self) {
            let names: Vec<String> =
                stops.iter().map(|stop| format!("`{}`", self.stops[*stop].name)).collect();
            return Err(SequenceError::Windows { stops: names.join(" or that of "), late });
        }
        let order = match self.order {
            Ordering::Given => None,
            Ordering::Free | Ordering::FreeBeforeLast => Some(self.best_order(settings, observer)?),
        };
        let stops: Vec<usize> = match &order {
            None => (0..self.stops.len()).collect(),
            Some(order) => order.stops.iter().map(|stop| stop - 1).collect(),
        };
        let Legs { planned, cost, time, late, cut, .. } = Legs::planned(self, settings, &stops, observer)?;
        Ok(SequencePlan { legs: planned, order, cost, end: time, late, cut })
    }

    /// Finds the best order of the stops from plans of the legs between all pairs ([`order`]). In
    /// the result the stops are numbered from 1. For minimum effort and fuel its `end` is the sum
    /// of the weights of its legs.
    ///
    /// # Errors
    /// [`SequenceError`] if the planner rejects a leg.
    pub fn best_order(
        &self,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Order, SequenceError> {
        self.check()?;
        pairs::ordered(self, settings, observer)
    }

    /// Checks that the sequence has only supported properties.
    ///
    /// # Errors
    /// [`SequenceError::Unsupported`] names a property that is not supported.
    pub fn check(&self) -> Result<(), SequenceError> {
        let craft = &self.craft;
        if !craft.is_free_turn() {
            return Err(SequenceError::Unsupported(
                "stops need an attitude maneuver of a free body: plan each leg in a field separately",
            ));
        }
        let passes_here = self.order == Ordering::Given
            && self.stops.first().is_some_and(|first| {
                let is_at_start = Place::Attitude(craft.start.attitude).is(&first.place);
                first.passing.is_some() && is_at_start && craft.start.angular_velocity == Vector3::zeros()
            });
        if passes_here {
            return Err(SequenceError::Unsupported(
                "the first stop is passed, and the body rests there at the start: remove that stop",
            ));
        }
        let moving = self.stops.iter().any(tracked::moves);
        if moving && self.stops.iter().any(|stop| tracked::moves(stop) && stop.passing.is_some()) {
            return Err(SequenceError::Unsupported(
                "a moving target cannot be passed: remove `passing`, or hold the target for a while",
            ));
        }
        if moving && craft.shortest_pulse().is_some() {
            return Err(SequenceError::Unsupported(
                "pulses cannot hold a body on a moving target: remove the minimum pulse width",
            ));
        }
        if !matches!(craft.objective, Objective::Time) {
            self.check_timed()?;
        }
        Ok(())
    }

    /// Checks the properties that depend on the start times of holds, for minimum effort and fuel.
    fn check_timed(&self) -> Result<(), SequenceError> {
        let begins = |stop: &Stop| stop.visit.pinned;
        let all_begin = self.stops.iter().all(begins);
        let mut alone = self.stops.iter().enumerate().filter(|(_, stop)| tracked::moves(stop));
        let is_timed =
            alone.all(|(index, stop)| begins(stop) && (index == 0 || begins(&self.stops[index - 1])));
        if !is_timed && !all_begin {
            return Err(SequenceError::Unsupported(
                "for minimum effort or fuel, a moving target needs the time at which its hold begins: give \
                `start_s` \
                 of that stop, and of the stop before it",
            ));
        }
        let has_window = self.stops.iter().any(|stop| stop.visit.window != Visit::PASSED.window);
        if has_window && !all_begin && self.order != Ordering::Given {
            return Err(SequenceError::Unsupported(
                "windows for minimum effort or fuel need a given order: remove `order`, or give `start_s` of \
                 every stop",
            ));
        }
        if has_window && !all_begin && self.craft.duration.known().is_none() {
            return Err(SequenceError::Unsupported(
                "windows for minimum effort or fuel need the total duration: give `duration_s`, or \
                 `start_s` of every stop",
            ));
        }
        Ok(())
    }

    /// Returns the time \[s\] until which all targets and cones are known.
    fn known_until(&self) -> f64 {
        let aims = self.stops.iter().filter_map(|stop| match &stop.place {
            Place::Aim(aim) => Some(aim),
            Place::Attitude(_) => None,
        });
        let targets = aims.flat_map(Aim::directions).map(Direction::known_until);
        targets.fold(self.craft.known_until(), f64::min)
    }

    /// Returns the state at a stop, with its free parameters, that the adjacent legs share.
    fn joint(&self, stop: &Stop) -> Result<Joint, SequenceError> {
        let ends = |aim: &Aim| -> Result<Ends, SequenceError> {
            let aim = Aim { rate: AimRate::Zero, ..aim.clone() };
            aim.ends(0.0, &self.craft.start.attitude, &Vector3::zeros())
                .map_err(|error| SequenceError::Aim { stop: stop.name.clone(), error })
        };
        Ok(match (&stop.place, stop.passing) {
            (Place::Attitude(attitude), None) => Joint::Given(State::attitude(*attitude, Vector3::zeros())),
            (Place::Attitude(attitude), Some(fastest)) => {
                Joint::Passing { at: State::attitude(*attitude, Vector3::zeros()), fastest }
            }
            (Place::Aim(aim), passing) => match (ends(aim)?, passing) {
                (ends, None) if ends.has_roll() => Joint::Roll(ends),
                (ends, None) => Joint::Given(Joint::Roll(ends).state(&[0.0])),
                (ends, Some(fastest)) => Joint::PassingRoll { ends, fastest },
            },
        })
    }

    /// Returns `true` if the body stays at rest from one stop to the next: the two stops require
    /// the same attitude or pointing, and the body stops at both.
    fn stays(&self, stop: usize, next: usize) -> bool {
        let rests = |stop: &Stop| stop.passing.is_none() && !tracked::moves(stop);
        let [stop, next] = [&self.stops[stop], &self.stops[next]];
        rests(stop) && rests(next) && stop.place.is(&next.place)
    }

    /// Returns `true` if the stop and the state are at rest and have the same attitude.
    fn is_at(&self, stop: usize, state: &State) -> bool {
        let stop = &self.stops[stop];
        let here = Place::Attitude(state.attitude).is(&stop.place);
        here && stop.passing.is_none() && state.angular_velocity == Vector3::zeros()
    }

    /// Returns the names of stops, for a message about all of them.
    fn named(&self, stops: &[usize]) -> String {
        stops.iter().map(|stop| self.stops[*stop].name.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// Returns the maneuver from which the legs are made, with a fixed number of steps.
    fn leg(&self) -> Problem {
        let mut leg = self.craft.clone();
        leg.chooses_steps = false;
        // No leg uses the end condition of the craft.
        leg.end_condition = EndCondition::State;
        leg
    }

    /// Returns the time \[s\] that the legs share: the total duration minus the holds and settling
    /// times. Returns `None` if the planner finds the duration of each leg independently.
    fn shared(&self) -> Result<Option<f64>, SequenceError> {
        let Some(total) = self.craft.duration.known() else { return Ok(None) };
        let holds = self.stops.iter().map(|stop| stop.visit.rest()).sum();
        if total > holds { Ok(Some(total - holds)) } else { Err(SequenceError::NoTime { holds, total }) }
    }

    /// Returns the exponent p of the approximate cost of a leg, `|J φ|ᵖ` with the rotation vector φ
    /// of the turn.
    fn power(&self) -> f64 {
        match self.craft.objective {
            Objective::Time => 0.5,
            Objective::Fuel(_) => 1.0,
            _ => 2.0,
        }
    }
}

#[cfg(test)]
mod tests;
