//! A leg from one stop to the next, with the gradient of its cost.
//!
//! The minimum cost V of a leg depends on the states at its two ends and on its duration T. The
//! costates `λ` at the ends give the gradient with respect to these states, and the Hamiltonian H
//! is the derivative with respect to T. Subscript 0 denotes the start and T the end, L is the cost
//! per second, and `Π = JΩ`:
//!
//! ```text
//! dV = λ_0·(ζ_0, δΠ_0) − λ_T·(ζ_T, δΠ_T) + H dT ,    δΠ = J δΩ
//! H = λ^R·Ω + λ^Π·(Π × Ω + τ) + L
//! ```
//!
//! The attitude at each end changes by a rotation `ζ` in body axes, `R exp(ζ)`. For a minimum-time
//! or minimum-fuel leg, V is the cost of the continuous-time extremal. It is a smooth function of
//! the end states; the cost on a grid is not.
//!
//! With reaction wheels the costates belong to the attitude and to the total angular momentum
//! `G = JΩ + μ` in body axes, where `μ` is the momentum that the wheels store. The final value of
//! `μ` is free. Its costate `p` follows from the other costates along the leg:
//!
//! ```text
//! ṗ = −(λ̇^G + Ω × λ^G) ,     p_T = −λ^G_T
//! ```
//!
//! `R G` is constant over all legs. A change `δΩ` of the initial rate therefore changes `μ` by
//! `−J δΩ`, and a rotation `ζ` of the initial attitude changes both `G` and `μ` by `−ζ × G`:
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

/// The gradient of a leg's cost with respect to the state at one end, in body axes: per radian of a
/// rotation of the attitude, and per rad/s of the angular velocity.
pub type Slopes = [Vector3; 2];

/// The reason why a leg cannot be planned, which also ends the planning of the other legs.
#[derive(Clone, Debug)]
pub enum LegError {
    /// The planner rejects the maneuver or the settings of the leg.
    Plan(PlanError),
    /// The caller or the time limit stopped the search.
    Stopped(Status),
}

impl LegError {
    /// Converts this error to an error of the sequence. `stop` names the stop at which the leg
    /// ends.
    pub fn at(self, stop: impl Into<String>) -> SequenceError {
        match self {
            Self::Plan(error) => SequenceError::Leg { stop: stop.into(), error },
            Self::Stopped(status) => SequenceError::Stopped(status),
        }
    }
}

/// A leg of a sequence, with its plan and the derivatives of its cost.
#[derive(Clone, Debug)]
pub struct Leg {
    pub problem: Problem,
    pub solution: Solution,
    pub cost: f64,
    /// Gradients of the cost with respect to the start state and to the end state.
    pub slopes: [Slopes; 2],
    /// Derivative of the cost with respect to the duration, if the duration is given.
    pub by_duration: f64,
}

impl Leg {
    /// Plans the leg that `problem` describes. If `near` is given, the search starts from the plan
    /// of this similar leg. Returns `None` if no plan is found, or if a constraint is violated at
    /// the start or at the end.
    ///
    /// # Errors
    /// [`LegError`] if the planner rejects the leg, or if the search was stopped.
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

    /// Returns the duration of the leg \[s\].
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
        // The costate that multiplies the torque, and the total angular momentum in body axes.
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

/// Returns the costate, in body axes, of the wheel momentum at the start of a leg: a sum over the
/// steps, each evaluated in the body axes at the midpoint of the step. Returns `None` if the
/// trajectory has no costates.
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
