//! Several stops in one plan: attitudes and pointings, in a given order or in the best one.
//!
//! A leg leads from one stop to the next. Legs between attitudes at rest are planned apart. Where a
//! stop leaves something free that both of its legs depend on (a roll, the rate of a passage, how a
//! total is split), they are planned together (`together`). The order comes from the times of all
//! pairs ([`order`]). Every leg from rest to rest has a proved lower bound ([`leg_bound`]), and all
//! legs of a spacecraft make a table ([`table`]).

mod carried;
pub mod joined;
mod joint;
mod leg;
pub mod leg_bound;
pub mod order;
mod pairs;
mod rolls;
pub mod symmetry;
pub mod table;
mod together;
mod windows;

pub use leg_bound::LegBound;
pub use symmetry::Symmetry;
pub use table::{Making, Quantity, SlewTable, TableError, TableOptions};

use crate::lie;
use crate::maneuver::aim::{Aim, AimError, AimRate, Ends};
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::{Settings, Target};
use crate::maneuver::solution::Outcome;
use crate::optimize::search::{Control, Observer, PlanError, Progress};
use crate::plan::{Guess, Plan, Status, plan};
use crate::{Matrix3, Vector3};
use joined::{Flown, Joined};
use joint::Joint;
use order::{Order, Visit};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use thiserror::Error;
use together::{Lasting, Together, Tuning, Whole};
use windows::Missed;

/// Where a stop is.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// An attitude, body → reference.
    Attitude(Matrix3),
    /// A boresight points at a target that stands still.
    Aim(Aim),
}

/// A stop of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// The name, for people.
    pub name: String,
    /// Where it is.
    pub place: Place,
    /// What happens there.
    pub visit: Visit,
    /// The bound of the rate \[rad/s\] at which the body passes without stopping, infinite without
    /// one; `None` where it stops.
    pub passing: Option<f64>,
}

impl Stop {
    /// Builds a stop at rest without a hold.
    pub fn at(name: &str, place: Place) -> Self {
        Self { name: name.into(), place, visit: Visit::PASSED, passing: None }
    }

    /// This stop with a hold \[s\].
    pub fn held(mut self, hold: f64) -> Self {
        self.visit.hold = hold;
        self
    }

    /// This stop passed at a rate of at most `fastest` \[rad/s\].
    pub fn passed_at_most_at(self, fastest: f64) -> Self {
        Self { passing: Some(fastest), ..self }
    }
}

/// Which order the stops have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ordering {
    /// The given one.
    Given,
    /// The best one.
    Free,
    /// The best one whose last stop stays last.
    FreeBeforeLast,
}

/// A spacecraft, its start and its stops.
///
/// The objective of `craft` counts over all legs. Its duration is that of the whole, holds included:
/// the legs share it. Its start is that of the first leg; its end is not used.
#[derive(Clone, Debug)]
pub struct Sequence {
    /// The maneuver without its ends.
    pub craft: Problem,
    /// The stops.
    pub stops: Vec<Stop>,
    /// Which order they have.
    pub order: Ordering,
}

/// Why a sequence cannot be planned.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SequenceError {
    /// A leg cannot be attempted.
    #[error("the leg to stop `{stop}`: {error}")]
    Leg {
        /// The stop at its end.
        stop: String,
        /// Why.
        error: PlanError,
    },
    /// A stop on a target has no state.
    #[error("stop `{stop}`: {error}")]
    Aim {
        /// The stop.
        stop: String,
        /// Why.
        error: AimError,
    },
    /// A sequence has what no sequence can have yet.
    #[error("{0}")]
    Unsupported(&'static str),
    /// The holds take the whole duration.
    #[error("the holds take {holds} s of the {total} s of the whole: give more time")]
    NoTime {
        /// What holds and settling take \[s\].
        holds: f64,
        /// The duration \[s\].
        total: f64,
    },
    /// No plan can keep windows: lower bounds of the legs prove it.
    #[error("no plan can keep the window of {stops}: the hold begins {late:.3} s late at least")]
    Windows {
        /// The stop, or both of which one has to wait for the other.
        stops: String,
        /// By how much \[s\].
        late: f64,
    },
    /// No plan was found for legs that are planned together.
    #[error("no plan was found for the legs to stop `{stop}`")]
    NoPlan {
        /// The stop at the end, or several.
        stop: String,
    },
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

/// A leg of a plan.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PlannedLeg {
    /// The maneuver, with the ends and the duration that were found.
    pub problem: Problem,
    /// Its plan.
    pub plan: Plan,
    /// The stop at its end, from 0.
    pub stop: usize,
    /// When it begins, in the time of the sequence \[s\].
    pub begins: f64,
    /// When the hold at its end begins and when it ends \[s\].
    pub holds: [f64; 2],
}

/// The plan of a sequence.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SequencePlan {
    /// The legs in the order in which they are flown.
    pub legs: Vec<PlannedLeg>,
    /// The order, with what is known of it: of pairs of stops alone.
    pub order: Option<Order>,
    /// The cost of all legs, in the unit of the objective.
    pub cost: f64,
    /// The end of the last hold \[s\].
    pub end: f64,
    /// By how much windows are missed, in all \[s\].
    pub late: f64,
}

impl SequencePlan {
    /// Returns whether every leg is solved and no window is missed, or why not: the status of the
    /// first leg that is not solved, which is the last one that was planned.
    pub fn status(&self) -> Status {
        let failed = self.legs.iter().map(|leg| leg.plan.status).find(|status| *status != Status::Solved);
        failed.unwrap_or(if self.late > 0.0 { Status::NotConverged } else { Status::Solved })
    }

    /// Returns the motion over all legs and the rests between them.
    pub fn joined(&self) -> Joined {
        Joined::of(self.legs.iter().map(|leg| Flown {
            path: &leg.plan.solution.trajectory,
            begins: leg.begins,
            until: leg.holds[1],
        }))
    }
}

impl Sequence {
    /// Plans all legs: the order, what joints leave free, and each leg as [`plan()`] plans it. A
    /// leg whose plan does not converge is the last one of the plan.
    ///
    /// # Errors
    /// [`SequenceError`] if legs that are planned together have no plan, or if a leg cannot be
    /// attempted.
    pub fn plan(
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
        let whole = self.together(&stops, settings, observer)?;
        let (mut time, mut late, mut cost) = (0.0, 0.0, 0.0);
        let (momentum, mut held) = (carried::momentum(&self.craft), None::<Vec<f64>>);
        let count = stops.len();
        let mut legs = Vec::with_capacity(count);
        for (number, (stop, leg)) in stops.into_iter().zip(whole.legs).enumerate() {
            let observer = &mut Part { observer, part: format!("leg {} of {count}", number + 1) };
            let told = |error| SequenceError::Leg { stop: self.stops[stop].name.clone(), error };
            let steps = self.craft.chooses_steps.then_some(self.craft.steps);
            let mut problem = leg.problem.clone();
            carried::carry(&mut problem, &momentum, held.as_deref());
            problem.name = format!("{}, leg to {}", self.craft.name, self.stops[stop].name);
            if let Some(steps) = steps {
                (problem.steps, problem.chooses_steps) = (steps, true);
            }
            let guess = Guess::of(&leg.solution, &leg.problem);
            let guess =
                (!problem.objective.switches() && problem.duration.known().is_some()).then_some(guess);
            let found = plan(&problem, settings, guess.as_ref(), observer).map_err(told)?;
            let wheels = problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len());
            let rows = &found.solution.trajectory.wheel_momentum;
            held = rows.len().checked_sub(wheels).map(|last| rows[last..].to_vec());
            let failed = found.solution.outcome != Outcome::Converged;
            let lasting = found.solution.trajectory.time.last().copied().unwrap_or(0.0);
            let visit = &self.stops[stop].visit;
            let (end, behind) = visit.after(time + lasting);
            let problem = found.solution.trajectory.completed(&problem);
            cost += found.solution.cost;
            let holds = [end - visit.hold, end];
            legs.push(PlannedLeg { problem, plan: found, stop, begins: time, holds });
            (time, late) = (end, late + behind);
            if failed {
                break;
            }
        }
        Ok(SequencePlan { legs, order, cost, end: time, late })
    }

    /// Finds the best order of the stops, by plans of all pairs ([`order`]); stops count from 1. Of effort
    /// and fuel its end is the sum of the weights of its legs.
    ///
    /// # Errors
    /// [`SequenceError`] if a leg cannot be attempted.
    pub fn best_order(
        &self,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Order, SequenceError> {
        self.check()?;
        pairs::ordered(self, settings, observer)
    }

    /// Checks what a sequence can have.
    ///
    /// # Errors
    /// [`SequenceError::Unsupported`] names what cannot be planned.
    pub fn check(&self) -> Result<(), SequenceError> {
        let craft = &self.craft;
        if !craft.is_free_turn() {
            return Err(SequenceError::Unsupported(
                "stops are of attitude maneuvers of a free body: plan each leg in a field by itself",
            ));
        }
        let moves = |stop: &Stop| matches!(&stop.place, Place::Aim(aim) if aim.moves(&Vector3::zeros()));
        if self.stops.iter().any(moves) {
            return Err(SequenceError::Unsupported(
                "a stop points at a target that moves: plan the leg to it by itself",
            ));
        }
        let shared = self.stops.iter().any(|stop| self.joint(stop).is_ok_and(|joint| joint.size() > 0));
        if shared && carried::momentum(craft) != Vector3::zeros() {
            return Err(SequenceError::Unsupported(
                "wheels that store momentum go with stops at rest whose attitude is given: give the roll",
            ));
        }
        let has_window = |stop: &Stop| stop.visit.window != Visit::PASSED.window;
        let all: Vec<usize> = (0..self.stops.len()).collect();
        let timed = matches!(craft.objective, Objective::Time) || self.pinned(&all).is_some();
        if !timed && self.stops.iter().any(has_window) {
            return Err(SequenceError::Unsupported(
                "windows go with least time: for effort and fuel give the begin of every hold, or none",
            ));
        }
        let passed = self.stops.iter().any(|stop| stop.passing.is_some());
        if passed && craft.actuation.wheels.is_some() {
            return Err(SequenceError::Unsupported(
                "a body with wheels stops at its stops: leave `passing` out",
            ));
        }
        Ok(())
    }

    /// Returns a stop as an end of two legs.
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

    /// Returns the maneuver of a leg, on steps that stay.
    fn leg(&self) -> Problem {
        let mut leg = self.craft.clone();
        leg.chooses_steps = false;
        leg
    }

    /// Returns how long the legs last, where every stop of an order begins at a time of its own \[s\].
    fn pinned(&self, stops: &[usize]) -> Option<Vec<f64>> {
        let mut time = 0.0;
        let lasting = |stop: &usize| {
            let Visit { settling, hold, window, pinned } = self.stops[*stop].visit;
            let leg = window[0] - settling - time;
            time = window[0] + hold;
            (pinned && leg > 0.0).then_some(leg)
        };
        let asked = !matches!(self.craft.objective, Objective::Time);
        stops.iter().map(lasting).collect::<Option<Vec<f64>>>().filter(|_| asked)
    }

    /// Returns what the legs share of the duration of the whole \[s\]; `None` where each finds its own.
    fn shared(&self) -> Result<Option<f64>, SequenceError> {
        let Some(total) = self.craft.duration.known() else { return Ok(None) };
        let holds = self.stops.iter().map(|stop| stop.visit.settling + stop.visit.hold).sum();
        if total > holds { Ok(Some(total - holds)) } else { Err(SequenceError::NoTime { holds, total }) }
    }

    /// Returns the power of the momentum of a leg that its cost is about proportional to.
    fn power(&self) -> f64 {
        match self.craft.objective {
            Objective::Time => 0.5,
            Objective::Fuel(_) => 1.0,
            _ => 2.0,
        }
    }

    /// Plans the legs of an order together, from two first states of the joints: those of legs that
    /// are the best one by one, and those of the best turns.
    fn together(
        &self,
        stops: &[usize],
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Whole, SequenceError> {
        let joints: Vec<Joint> =
            stops.iter().map(|stop| self.joint(&self.stops[*stop])).collect::<Result<_, _>>()?;
        let (craft, total, pinned) = (self.leg(), self.shared()?, self.pinned(stops));
        let inertia = craft.body.inertia.j();
        let share = |states: &[State]| -> Vec<f64> {
            if let Some(durations) = &pinned {
                return durations.clone();
            }
            let Some(total) = total else { return Vec::new() };
            let before = std::iter::once(&self.craft.start).chain(states);
            let weight = |(from, to): (&State, &State)| {
                let momentum = (inertia * lie::minus(&to.attitude, &from.attitude)).norm();
                // Of effort c/T³, whose best split is by the fourth roots; no leg is without time.
                momentum.powf(0.25 * self.power()).max(f64::EPSILON)
            };
            let weights: Vec<f64> = before.zip(states).map(weight).collect();
            let all: f64 = weights.iter().sum();
            weights.iter().map(|weight| total * weight / all).collect()
        };
        let together = Together {
            craft: &craft,
            start: self.craft.start,
            momentum: carried::momentum(&self.craft),
            joints: &joints,
            lasting: match &pinned {
                Some(durations) => Lasting::Given(durations),
                None => total.map_or(Lasting::Sought, Lasting::Shared),
            },
            settings,
            tuning: Tuning::default(),
        };
        let equal = share(&rolls::cheapest(&self.craft.start, &joints, inertia, self.power(), &[]));
        let of_turns = rolls::cheapest(&self.craft.start, &joints, inertia, self.power(), &equal);
        let observer = &mut Part { observer, part: "all legs together".into() };
        let mut firsts = vec![of_turns];
        if joints.iter().any(|joint| joint.size() > 0) {
            firsts.extend(self.one_by_one(stops, &joints, &equal, settings, observer)?);
        }
        let told = |error| SequenceError::Leg { stop: self.named(stops), error };
        let mut best: Option<Whole> = None;
        for states in firsts {
            let passed = self.passed(&joints, states, &equal);
            let first = together.unknowns(&passed, &share(&passed));
            let Some(whole) = together.planned(first, None, observer).map_err(told)? else { continue };
            let whole = together.improved(whole, observer).map_err(told)?;
            if best.as_ref().is_none_or(|best| whole.cost() < best.cost()) {
                best = Some(whole);
            }
        }
        best.ok_or_else(|| SequenceError::NoPlan { stop: self.named(stops) })
    }

    /// Returns the names of stops, for a message about all of them.
    fn named(&self, stops: &[usize]) -> String {
        stops.iter().map(|stop| self.stops[*stop].name.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// Returns the states of legs that are each the best to any roll of its end.
    fn one_by_one(
        &self,
        stops: &[usize],
        joints: &[Joint],
        durations: &[f64],
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Option<Vec<State>>, SequenceError> {
        let settings = Settings { target: Target::Discrete, ..settings.clone() };
        let (mut from, mut states) = (self.craft.start, Vec::with_capacity(stops.len()));
        for (index, (stop, joint)) in stops.iter().zip(joints).enumerate() {
            let stop = &self.stops[*stop];
            let state = match (&stop.place, joint) {
                (Place::Aim(aim), Joint::Roll(_) | Joint::PassingRoll { .. }) => {
                    let mut problem = Problem { start: from, ..self.leg() };
                    if let Some(duration) = durations.get(index) {
                        problem = problem.with_duration(*duration);
                    }
                    let problem = problem.with_aim_at_end(aim.clone().at_rest());
                    let told = |error| SequenceError::Leg { stop: stop.name.clone(), error };
                    let found = plan(&problem, &settings, None, observer).map_err(told)?;
                    let Some(last) = found.solution.trajectory.quaternion.last() else { return Ok(None) };
                    let attitude = lie::project_to_rotation(&lie::rotation_from_quaternion(last));
                    State::attitude(attitude, Vector3::zeros())
                }
                _ => joint.state(&vec![0.0; joint.size()]),
            };
            states.push(state);
            from = State { angular_velocity: Vector3::zeros(), ..state };
        }
        Ok(Some(states))
    }

    /// Returns states with the rates of a cubic through them where the body passes, if it is known
    /// how long the legs last.
    fn passed(&self, joints: &[Joint], mut states: Vec<State>, durations: &[f64]) -> Vec<State> {
        let attitudes: Vec<Matrix3> = std::iter::once(self.craft.start.attitude)
            .chain(states.iter().map(|state| state.attitude))
            .collect();
        for (index, joint) in joints.iter().enumerate() {
            let is_passed = matches!(joint, Joint::Passing { .. } | Joint::PassingRoll { .. });
            if let (true, Some(next), [before, after]) =
                (is_passed, attitudes.get(index + 2), durations.get(index..index + 2).unwrap_or(&[]))
            {
                let [from, at] = [attitudes[index], attitudes[index + 1]];
                let [come, gone] = [lie::minus(&at, &from) / *before, lie::minus(next, &at) / *after];
                states[index].angular_velocity = (come * *after + gone * *before) / (before + after);
            }
        }
        states
    }
}

#[cfg(test)]
mod tests;
