//! Landing: shifts the discrete target by the miss of the true motion, until the true motion meets
//! the end of the maneuver.
//!
//! The inputs of a plan are held over its steps. The discrete motion meets its target to round-off,
//! but the true motion under the same inputs misses it by `O(h²)` (`O(h)` for Lie–Euler). The
//! defect correction
//!
//! ```text
//! d_0 = end ,     d_{i+1} = d_i ⊕ (end ⊖ Φ(u(d_i)))
//! ```
//!
//! Here `u(d)` are the inputs of the discrete optimum for the target d, and Φ(u) is the end of the
//! true motion under the inputs u ([`crate::flight`]). The fixed point is the required plan. The
//! iteration contracts by a factor `O(h²)`, the relative difference between the sensitivities of
//! the discrete and the true motion. The plan remains an extremal of the discrete problem for the
//! shifted target. Constraints on rates and pointing are tightened in the same loop by the amount
//! by which the true motion violates them.
//!
//! A minimum-time plan to a moving target ends at the target's state at the time of arrival. The
//! `end` of the correction is then the state at the plan's own duration ([`Problem::end_after`]).
//! The state aimed at is that of the time at which the delay of the plan vanishes, computed with
//! the slope of the delay that the search has found. This applies also to the discrete motion if
//! plans are not landed.
//!
//! Each formulation uses the warm start that its unknowns allow: the shooting a Newton step on the
//! first costate (`shooting`), the chain its own method started near the plan (`chain`), arcs
//! Newton's method on costates and arc lengths (`search::switching`).

mod chain;
mod shooting;

pub(crate) use chain::{Landed, land_chain};
pub(crate) use shooting::land_costate;

use crate::Vector3;
use crate::flight::{Excess, Flight, Held};
use crate::lie;
use crate::maneuver::constraint::{Constraint, Pointing, Rule, Side};
use crate::maneuver::problem::{Motion, Problem, State};
use crate::maneuver::settings::{Settings, Target};
use crate::maneuver::solution::{Landing, Trajectory};

/// Miss below which a motion counts as landed, scaled: angles in radians, rates in radians per
/// duration. It is far below the tolerance of the witnesses and far above round-off.
pub(crate) const LANDED: f64 = 1e-9;

/// Largest number of corrections. If a correction does not halve the miss, the plan needs more
/// steps, not more corrections.
pub(crate) const MOST_CORRECTIONS: usize = 16;
const SHRUNK: f64 = 0.5;

/// Reserve by which a constraint is tightened beyond its violation \[rad, or relative to the
/// limit\]; the true motion must keep half of it. The reserve is needed because the search for
/// extrema approximates the motion piecewise by rotations about one axis, which is accurate to
/// about 1e-8.
const ROOM: f64 = 1e-7;

/// Miss or violation up to which a plan counts as landed, scaled. It is far below the requested
/// tolerance, and far above the difference between two integrations of the same motion.
pub(crate) const MET: f64 = 1e-6;

/// Returns the larger of the miss of the true motion at the end and its largest constraint
/// violation, scaled; not finite if the motion cannot be integrated.
pub(crate) fn left(problem: &Problem, plan: &Trajectory) -> f64 {
    let Some(duration) = plan.time.last().copied() else { return f64::NAN };
    let mut aim = Aim::of(problem);
    let Some((flown, excess)) = aim.flown(&Flight::of_plan(problem, plan)) else { return f64::NAN };
    let miss = largest(&aim.miss(&flown, duration));
    excess
        .into_iter()
        .fold(miss, |worst, excess| if excess > worst || excess.is_nan() { excess } else { worst })
}

/// State of the landing corrections: shifted target, tightened constraints and the misses so far.
#[derive(Clone, Debug)]
pub(crate) struct Aim<'a> {
    problem: &'a Problem,
    /// The true motion; `None` if the discrete motion itself must meet a moving target.
    flight: Option<Flight<'a>>,
    settled: bool,
    /// Miss below which the motion counts as landed, scaled.
    least: f64,
    /// Target of the discrete problem, shifted by the corrections.
    pub target: State,
    /// Time for which the position of the moving target is taken \[s\]; NaN if the target does not
    /// move.
    time: f64,
    /// Amount by which each constraint is tightened \[rad, or relative to the limit\].
    pub drawn_in: Vec<f64>,
    /// Misses before each correction and after the last one, scaled.
    misses: Vec<f64>,
    /// Smallest miss or violation of the true motion so far, scaled.
    best: f64,
}

/// Next action of the landing loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// The true motion meets the end and keeps the constraints.
    Landed,
    /// Solve again for the current target and constraints.
    Correct,
    /// A further correction would not reduce the miss.
    GiveUp,
}

impl<'a> Aim<'a> {
    /// Starts the landing corrections: the true motion must meet the end of the maneuver.
    pub fn of(problem: &'a Problem) -> Self {
        Self {
            flight: Some(Flight::new(problem)),
            problem,
            settled: false,
            least: LANDED,
            target: problem.end,
            time: problem.met().map_or(f64::NAN, |meeting| meeting.time),
            drawn_in: vec![0.0; problem.constraints.len()],
            misses: Vec::new(),
            best: f64::INFINITY,
        }
    }

    /// Starts corrections of the motion that `settings` require to meet the end: the true motion,
    /// or the discrete motion to a moving target. Returns `None` if a discrete motion needs no
    /// correction.
    pub fn asked(problem: &'a Problem, settings: &Settings) -> Option<Self> {
        let aim = Self::of(problem);
        match settings.target {
            Target::Motion => Some(aim),
            Target::Discrete => {
                problem.met().map(|_| Self { flight: None, least: settings.tolerance, ..aim })
            }
        }
    }

    /// Returns the end state of a plan's motion, true or discrete, and its constraint violations.
    fn ended(&mut self, plan: &Trajectory) -> Option<(State, Vec<f64>)> {
        if self.flight.is_some() {
            return self.flown(&Flight::of_plan(self.problem, plan));
        }
        let angular_velocity = *plan.angular_velocity.last()?;
        let attitude = lie::project_to_rotation(&lie::rotation_from_quaternion(plan.quaternion.last()?));
        Some((State { attitude, angular_velocity, ..self.problem.end }, Vec::new()))
    }

    /// Returns the end state and the constraint violations of the true motion under held inputs;
    /// `None` if the motion cannot be integrated.
    fn flown(&mut self, steps: &[(Held, f64)]) -> Option<(State, Vec<f64>)> {
        let flight = self.flight.as_mut()?;
        if !self.settled {
            flight.settle(steps);
            self.settled = true;
        }
        let mut excess = Excess::of(self.problem);
        let end = flight.fly(steps, excess.as_mut())?;
        let mut worst = excess.map_or_else(Vec::new, |excess| excess.worst);
        // A constraint that holds a boresight on a cone cannot be tightened: the witnesses report
        // the deviation.
        for (worst, constraint) in worst.iter_mut().zip(&self.problem.constraints) {
            if is_held_on(constraint) {
                *worst = f64::NEG_INFINITY;
            }
        }
        Some((end, worst))
    }

    /// Returns the miss of the true motion: the scaled difference `[x, γ, ζ, Π]` between the
    /// required and the actual end.
    fn miss(&self, flown: &State, duration: f64) -> [Vector3; 4] {
        let (end, inertia) = (self.problem.end_after(duration), &self.problem.body.inertia);
        let length = length(self.problem, duration);
        let rate = flown.angular_velocity - end.angular_velocity;
        [
            (flown.position - end.position) / length,
            (flown.velocity - end.velocity) * (duration / length),
            if self.problem.ends_in_any_attitude() {
                Vector3::zeros()
            } else {
                lie::minus(&flown.attitude, &end.attitude)
            },
            inertia.j() * rate * (duration / inertia.mean()),
        ]
    }

    /// Integrates the true motion of a plan, shifts the target by its miss, and tightens the
    /// constraints by its violations.
    pub fn correct(&mut self, plan: &Trajectory) -> Next {
        let Some(duration) = plan.time.last().copied() else { return Next::GiveUp };
        let Some((flown, excess)) = self.ended(plan) else { return Next::GiveUp };
        let miss = largest(&self.miss(&flown, duration));
        let exceeded = excess.iter().fold(0.0, |worst: f64, excess| worst.max(excess + 0.5 * ROOM));
        // Written so that NaN counts as a violation.
        let kept = excess.iter().all(|excess| excess + 0.5 * ROOM <= 0.0);
        self.misses.push(miss);
        let left = miss.max(exceeded);
        if miss <= self.least && kept {
            self.best = left;
            return Next::Landed;
        }
        // The first correction to a moving target only measures the delay of the plan; the later
        // corrections remove it.
        let told = 1 + usize::from(self.problem.met().is_some());
        let stuck = left.is_nan() || self.misses.len() > told && left > SHRUNK * self.best;
        if stuck || self.misses.len() > MOST_CORRECTIONS {
            return Next::GiveUp;
        }
        self.best = left;
        self.shift(&flown, duration);
        for (drawn_in, excess) in self.drawn_in.iter_mut().zip(excess) {
            if excess + 0.5 * ROOM > 0.0 {
                *drawn_in += excess + ROOM;
            }
        }
        Next::Correct
    }

    /// Shifts the target by the negative of the miss.
    fn shift(&mut self, flown: &State, duration: f64) {
        if let Some(meeting) = self.problem.met().filter(|_| self.flight.is_none() || self.misses.len() > 1) {
            self.time = meeting.next(self.time, duration);
        }
        let end = self.problem.end_after(self.time);
        let target = &mut self.target;
        if !self.problem.ends_in_any_attitude() {
            let turn = lie::exp(&lie::minus(&end.attitude, &flown.attitude));
            target.attitude = lie::project_to_rotation(&(target.attitude * turn));
        }
        target.angular_velocity += end.angular_velocity - flown.angular_velocity;
        target.position += end.position - flown.position;
        target.velocity += end.velocity - flown.velocity;
    }

    /// Returns the maneuver with the shifted end and the tightened constraints; `None` if a
    /// tightened constraint is not valid.
    pub fn drawn_in(&self) -> Option<Problem> {
        let mut problem = Problem { end: self.target, ..self.problem.clone() };
        for (Constraint { rule, .. }, by) in problem.constraints.iter_mut().zip(&self.drawn_in) {
            match rule {
                Rule::Pointing(pointing) => pointing.margin += by,
                Rule::RateNorm(limit) => *limit *= 1.0 - by,
                Rule::RateAxes(limits) => *limits *= 1.0 - by,
            }
        }
        let usable = problem.constraints.iter().all(|constraint| constraint.check().is_ok());
        usable.then_some(problem)
    }

    /// Returns whether the constraints differ from those of the maneuver, because one is tightened
    /// or because one holds the boresight on a cone and depends on the end.
    pub fn changes_constraints(&self) -> bool {
        self.drawn_in.iter().any(|by| *by > 0.0) || self.problem.constraints.iter().any(is_held_on)
    }

    /// Returns the report of the landing corrections.
    pub fn told(&self) -> Landing {
        let named = self.problem.constraints.iter().zip(&self.drawn_in).filter(|(_, by)| **by > 0.0);
        Landing {
            corrections: self.misses.len().saturating_sub(1),
            misses: self.misses.clone(),
            cost_before: f64::NAN,
            drawn_in: named.map(|(constraint, by)| (constraint.name.clone(), *by)).collect(),
        }
    }
}

/// Returns whether the constraint holds a boresight on a cone.
fn is_held_on(constraint: &Constraint) -> bool {
    matches!(constraint.rule, Rule::Pointing(Pointing { side: Side::On { .. }, .. }))
}

/// Returns the unit of length of a maneuver \[m\].
fn length(problem: &Problem, duration: f64) -> f64 {
    if problem.motion == Motion::Attitude {
        return 1.0;
    }
    let size = |state: &State| state.position.norm().max(state.velocity.norm() * duration);
    let largest = size(&problem.start).max(size(&problem.end));
    if largest > 0.0 { largest } else { 1.0 }
}

fn largest(blocks: &[Vector3; 4]) -> f64 {
    blocks.iter().map(|block| block.norm()).fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}
