//! A leg from one stop to the next, with the slopes of its cost.
//!
//! The least cost V of a leg depends on its ends and on its duration T. The costates at the ends
//! are its slopes, and the Hamiltonian is that by the duration:
//!
//! ```text
//! dV = λ_0·(ζ_0, δΠ_0) − λ_T·(ζ_T, δΠ_T) + H dT ,    δΠ = J δΩ
//! H = λ^R·Ω + λ^Π·(Π × Ω + τ) + L
//! ```
//!
//! Both ends are in body axes, `R exp(ζ)`. A leg of least time or fuel counts with the cost of its
//! continuous extremal, which is smooth in its ends, as the cost on a grid is not.
//!
//! With reaction wheels the costates belong to the attitude and to the total angular momentum
//! `G = JΩ + μ`, body axes, of which the wheels store `μ`. The costate `p` of `μ`, whose end is
//! free, follows from them along the leg:
//!
//! ```text
//! ṗ = −(λ̇^G + Ω × λ^G) ,     p_T = −λ^G_T
//! ```
//!
//! `R G` is constant from leg to leg. A rate at the start changes `μ` by `−J δΩ`, and a turn changes
//! both `G` and `μ` by `−ζ × G`:
//!
//! ```text
//! dV = (λ^R + (λ^G + p) × G)·ζ_0 − p·J δΩ_0 + … ,     H = λ^R·Ω + λ^G·(G × Ω) − p·τ + L
//! ```
//!
//! A wheel that reaches its momentum limit within the leg adds multipliers to `p`, which are
//! neglected: the search for the joints then relies on the decrease of the cost alone.

use super::SequenceError;
use crate::maneuver::objective::effort;
use crate::maneuver::{Outcome, Problem, ProblemError, Settings, Solution, Target, Trajectory};
use crate::optimize::search::{self, Guess, Observer, PlanError};
use crate::plan::Status;
use crate::{Matrix3, Vector3, lie};

/// The slopes of a cost by the state at an end: by its turn and by its rate, body axes.
pub type Slopes = [Vector3; 2];

/// Why a leg has no plan, and others need none.
#[derive(Clone, Debug)]
pub enum LegError {
    /// It cannot be attempted.
    Plan(PlanError),
    /// The caller, or the time limit, stopped the search.
    Stopped(Status),
}

impl LegError {
    /// Returns the error of a sequence of which this is the leg to some stops.
    pub fn at(self, stop: impl Into<String>) -> SequenceError {
        match self {
            Self::Plan(error) => SequenceError::Leg { stop: stop.into(), error },
            Self::Stopped(status) => SequenceError::Stopped(status),
        }
    }
}

/// A leg and its plan.
#[derive(Clone, Debug)]
pub struct Leg {
    pub problem: Problem,
    pub solution: Solution,
    pub cost: f64,
    /// At the start and at the end.
    pub slopes: [Slopes; 2],
    /// By the duration, if that is given.
    pub by_duration: f64,
}

impl Leg {
    /// Plans a leg, from a neighbour of it if one is known; `None` if no plan is found, or if an end
    /// is in a cone.
    ///
    /// # Errors
    /// [`LegError`] if the leg cannot be attempted, or the search was stopped.
    pub fn of(
        problem: Problem,
        settings: &Settings,
        near: Option<&Self>,
        observer: &mut dyn Observer,
    ) -> Result<Option<Self>, LegError> {
        let settings = Settings { target: Target::Discrete, test_second_order: false, ..settings.clone() };
        let guess = near.map(|near| Guess::near(&near.solution, &near.problem));
        let solution = match search::without_arcs(&problem, &settings, guess.as_ref(), observer) {
            Err(PlanError::Problem(ProblemError::Violated { .. })) => return Ok(None),
            found => found.map_err(LegError::Plan)?,
        };
        match solution.outcome {
            Outcome::Converged => Ok(Self::planned(problem, solution)),
            Outcome::Interrupted => Err(LegError::Stopped(Status::Interrupted)),
            Outcome::TimeLimit => Err(LegError::Stopped(Status::LimitReached)),
            _ => Ok(None),
        }
    }

    /// Returns how long it lasts \[s\].
    pub fn lasting(&self) -> f64 {
        self.solution.trajectory.time.last().copied().unwrap_or(1.0)
    }

    fn planned(problem: Problem, solution: Solution) -> Option<Self> {
        let path = &solution.trajectory;
        let last = path.costates.len().checked_sub(6)?;
        let at = |first: usize| {
            let costate = |from: usize| Vector3::from_column_slice(&path.costates[from..from + 3]);
            [costate(first), costate(first + 3)]
        };
        let j = problem.body.inertia.j();
        let [of_start, of_end] = [at(0), at(last)];
        let rate = path.angular_velocity.first()?;
        // The costate of the torque, and the angular momentum that turns with the body.
        let (of_torque, carried) = match problem.actuation.wheels {
            Some(_) => (-of_stored(path)?, j * rate + problem.actuation.stored_momentum()),
            None => (of_start[1], j * rate),
        };
        let by_turn = match problem.actuation.wheels {
            Some(_) => of_start[0] + (of_start[1] - of_torque).cross(&carried),
            None => of_start[0],
        };
        let slopes = [[by_turn, j * of_torque], [-of_end[0], -(j * of_end[1])]];
        let torque = path.torque.first()?;
        let running = match problem.objective.fuel() {
            Some(fuel) => fuel.rate(&problem.actuation, path.inputs(0)),
            None => {
                let weighted = problem.objective.weights().torque(&problem.actuation);
                effort(&weighted.weight, path.inputs(0)) + problem.objective.time_price()
            }
        };
        let by_duration =
            of_start[0].dot(rate) + of_start[1].dot(&carried.cross(rate)) + of_torque.dot(torque) + running;
        let continuous = solution.switching.as_ref().map(|switching| switching.continuous_cost);
        let cost = continuous.filter(|cost| cost.is_finite()).unwrap_or(solution.cost);
        let finite = cost.is_finite() && slopes.iter().flatten().all(|slope| slope.amax().is_finite());
        finite.then_some(Self { problem, solution, cost, slopes, by_duration })
    }
}

/// Returns the costate of the momentum that wheels store at the start of a leg, body axes: the sum
/// over the steps, each in the axes of its middle.
fn of_stored(path: &Trajectory) -> Option<Vector3> {
    let costate =
        |node: usize| Some(Vector3::from_column_slice(path.costates.get(6 * node + 3..6 * node + 6)?));
    let attitudes: Vec<Matrix3> = path.quaternion.iter().map(lie::rotation_from_quaternion).collect();
    let mut stored = -costate(attitudes.len().checked_sub(1)?)?;
    for (node, pair) in attitudes.windows(2).enumerate() {
        let half = lie::exp(&(0.5 * lie::minus(&pair[1], &pair[0])));
        stored += half * costate(node + 1)? - half.tr_mul(&costate(node)?);
    }
    Some(stored)
}
