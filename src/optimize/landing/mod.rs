//! Landing: the discrete target is shifted by what the true motion misses, until that meets the end
//! of the maneuver.
//!
//! The inputs of a plan are held over its steps. Under them the true motion ends `O(h²)` beside the
//! discrete one (`O(h)` for Lie–Euler), which meets its target to round-off. The defect correction
//!
//! ```text
//! d_0 = end ,     d_{i+1} = d_i ⊕ (end ⊖ Φ(u(d_i)))
//! ```
//!
//! with the inputs `u(d)` of the discrete optimum for the target d and the end Φ of the true motion
//! under them ([`crate::flight`]) has the plan wanted as its fixed point, and contracts by the
//! relative difference of the two sensitivities, `O(h²)`. It remains an extremal of the discrete
//! problem, of the shifted target. Constraints on rates and pointing are drawn in by what the true
//! motion exceeds them, in the same loop.
//!
//! A plan of least time to a target that moves ends where that is when the plan arrives. Its `end`
//! is that of the plan's own duration ([`Problem::end_after`]), and what is aimed at that of the
//! root of how late the plan is, by the slope that the search has seen; of the discrete motion too,
//! where plans are not to land.
//!
//! Each formulation has the warm solve that its unknowns give it: the shooting a Newton step on the
//! first costate (`shooting`), the chain its own method from near the plan (`chain`), arcs Newton
//! on costates and lengths (`search::switching`).

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

/// A miss that is none, scaled: radians, and rates over a radian in the duration. Far below what a
/// witness is asked for, far above round-off.
pub(crate) const LANDED: f64 = 1e-9;

/// Most corrections. Where one does not take away half of the miss more steps are needed, and no
/// more corrections.
pub(crate) const MOST_CORRECTIONS: usize = 16;
const SHRUNK: f64 = 0.5;

/// By how much more than what the true motion exceeds a constraint is drawn in, and what it must
/// keep \[rad, or a part of the limit\]: the pieces between which extrema are looked for are
/// rotations about one axis to some 1e-8.
const ROOM: f64 = 1e-7;

/// What a plan that lands misses or exceeds at most, scaled: far below what it is asked for, and
/// far above what two flows of the same motion differ by.
pub(crate) const MET: f64 = 1e-6;

/// What the true motion of a plan misses at the end or exceeds on its way, the larger, scaled; not
/// finite where it cannot be followed.
pub(crate) fn left(problem: &Problem, plan: &Trajectory) -> f64 {
    let Some(duration) = plan.time.last().copied() else { return f64::NAN };
    let mut aim = Aim::of(problem);
    let Some((flown, excess)) = aim.flown(&Flight::of_plan(problem, plan)) else { return f64::NAN };
    let miss = largest(&aim.miss(&flown, duration));
    excess
        .into_iter()
        .fold(miss, |worst, excess| if excess > worst || excess.is_nan() { excess } else { worst })
}

/// Where corrections stand.
#[derive(Clone, Debug)]
pub(crate) struct Aim<'a> {
    problem: &'a Problem,
    /// The true motion; `None` where the discrete one is to be at its end when it arrives there.
    flight: Option<Flight<'a>>,
    settled: bool,
    /// A miss that is none.
    least: f64,
    /// The end that the discrete problem has.
    pub target: State,
    /// When the end that is aimed at is that of the maneuver \[s\], where it moves on with the
    /// duration.
    time: f64,
    /// By how much each constraint is drawn in.
    pub drawn_in: Vec<f64>,
    /// What was missed before each correction, and in the end, scaled.
    misses: Vec<f64>,
    /// What the true motion under the best inputs so far still misses or exceeds.
    best: f64,
}

/// What is to be done next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// The true motion lands.
    Landed,
    /// Solve again for the target and constraints that are aimed at now.
    Correct,
    /// No correction brings it nearer.
    GiveUp,
}

impl<'a> Aim<'a> {
    /// Of the true motion at the end of a maneuver.
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

    /// Of the motion that `settings` ask to be at the end of a maneuver; `None` where it is there
    /// already.
    pub fn asked(problem: &'a Problem, settings: &Settings) -> Option<Self> {
        let aim = Self::of(problem);
        match settings.target {
            Target::Motion => Some(aim),
            Target::Discrete => {
                problem.met().map(|_| Self { flight: None, least: settings.tolerance, ..aim })
            }
        }
    }

    /// Where a plan ends, and what it exceeds.
    fn ended(&mut self, plan: &Trajectory) -> Option<(State, Vec<f64>)> {
        if self.flight.is_some() {
            return self.flown(&Flight::of_plan(self.problem, plan));
        }
        let angular_velocity = *plan.angular_velocity.last()?;
        let attitude = lie::project_to_rotation(&lie::rotation_from_quaternion(plan.quaternion.last()?));
        Some((State { attitude, angular_velocity, ..self.problem.end }, Vec::new()))
    }

    /// Where the true motion ends, and what it exceeds.
    fn flown(&mut self, steps: &[(Held, f64)]) -> Option<(State, Vec<f64>)> {
        let flight = self.flight.as_mut()?;
        if !self.settled {
            flight.settle(steps);
            self.settled = true;
        }
        let mut excess = Excess::of(self.problem);
        let end = flight.fly(steps, excess.as_mut())?;
        let mut worst = excess.map_or_else(Vec::new, |excess| excess.worst);
        // What is held on a cone cannot be drawn in: the witnesses tell by how much it strays.
        for (worst, constraint) in worst.iter_mut().zip(&self.problem.constraints) {
            if is_held_on(constraint) {
                *worst = f64::NEG_INFINITY;
            }
        }
        Some((end, worst))
    }

    /// What the true motion misses at the end, scaled: `[x, γ, ζ, Π]` from the end to where it is.
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

    /// Flies a recorded plan and shifts the target and the constraints by what it misses.
    pub fn correct(&mut self, plan: &Trajectory) -> Next {
        let Some(duration) = plan.time.last().copied() else { return Next::GiveUp };
        let Some((flown, excess)) = self.ended(plan) else { return Next::GiveUp };
        let miss = largest(&self.miss(&flown, duration));
        let exceeded = excess.iter().fold(0.0, |worst: f64, excess| worst.max(excess + 0.5 * ROOM));
        // Written so that what is not a number is not kept.
        let kept = excess.iter().all(|excess| excess + 0.5 * ROOM <= 0.0);
        self.misses.push(miss);
        let left = miss.max(exceeded);
        if miss <= self.least && kept {
            self.best = left;
            return Next::Landed;
        }
        // The first correction to what moves tells how late the plan is, and only the next ones
        // make up for it.
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

    /// Shifts the target by what was missed.
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

    /// The maneuver to the end that is aimed at, with its constraints drawn in; `None` where they
    /// leave nothing or the ends do not hold them.
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

    /// Whether constraints are others than those of the maneuver: one is drawn in, or leads to the
    /// end that is aimed at.
    pub fn changes_constraints(&self) -> bool {
        self.drawn_in.iter().any(|by| *by > 0.0) || self.problem.constraints.iter().any(is_held_on)
    }

    /// What there is to tell of the corrections of a plan.
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

/// Whether it holds a boresight on a cone.
fn is_held_on(constraint: &Constraint) -> bool {
    matches!(constraint.rule, Rule::Pointing(Pointing { side: Side::On { .. }, .. }))
}

/// The unit of length of a maneuver \[m\].
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
