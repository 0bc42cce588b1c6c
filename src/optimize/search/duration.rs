//! Least effort where a second has a price and the duration is sought.
//!
//! For a given duration the cost is `J(T) = E(T) + w T` with the least effort `E`. Its derivative is exact on the grid: the
//! mean of the discrete Hamiltonians, which are the derivatives of the discrete action by the length of each step,
//!
//! ```text
//! 𝓗_k = ½(ℓ_k + ℓ_{k+1}) + λ^ζ·ξ' + λ^Π·[(FᵀΠ̂)×ξ' + ½Fᵀτ_k + ½τ_{k+1} + (h/2) M_R(R_{k+1}) ξ'] ,   ℓ = ½uᵀWu
//! Π̂  = Π_k + (h/2) τ_k ,   ξ' = Fᵀ E⁻¹ (Π̂ + (h/2) τ_k) ,   E = tr(F J_d) I − F J_d
//! ```
//!
//! with all torques in τ, and λ the costates after the step. `E'` is about `−3E/T` from rest to rest, so the secant runs in
//! the logarithms of `T` and `−E'`, where that is a straight line.

use super::{Observer, PlanError};
use crate::maneuver::objective::{Objective, Weights, effort};
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::{Method, Settings};
use crate::maneuver::solution::{Outcome, Solution};
use crate::mechanics::drift_equation;
use crate::mechanics::environment::Pose;
use crate::numerics::figures::short;
use crate::{Matrix3, Vector3, lie};
use std::time::Instant;

/// Derivatives of the cost below this part of the price are zero.
const STATIONARY: f64 = 1e-13;
const MOST_ITERATIONS: usize = 60;
/// Starts, as multiples of the duration of a turn about a fixed axis, and the longest way to either side.
const STARTS: [f64; 3] = [1.0, 0.4, 2.5];
const LONGEST_WAY: f64 = 64.0;

/// What is known of one duration.
struct Known {
    duration: f64,
    solution: Solution,
    /// `J'(T)`.
    slope: f64,
}

/// Solves a maneuver of given duration.
type Solve<'a> = dyn FnMut(&Problem, &Settings, &mut dyn Observer) -> Result<Solution, PlanError> + 'a;

/// Solves a maneuver of least effort and time. `solve` solves it for a given duration.
pub(super) fn solve(
    problem: &Problem,
    settings: &Settings,
    observer: &mut dyn Observer,
    solve: &mut Solve<'_>,
) -> Result<Solution, PlanError> {
    let began = Instant::now();
    let price = problem.objective.time_price();
    let mut best: Option<Known> = None;
    let mut stopped: Option<Solution> = None;
    let mut at = |duration: f64| -> Result<Option<Known>, PlanError> {
        let remaining = settings.time_limit.map(|limit| limit.saturating_sub(began.elapsed()));
        // The shooting alone: what it cannot do within the limits is too short, and SCP would search for long.
        let settings = Settings { time_limit: remaining, method: Method::Shooting, ..settings.clone() };
        let given = problem.clone().with_duration(duration);
        if given.check().is_err() {
            // Boundary rates that turn too far in a step of such a length.
            return Ok(None);
        }
        let solution = solve(&given, &settings, observer)?;
        if solution.outcome != Outcome::Converged {
            stopped = Some(solution);
            return Ok(None);
        }
        let slope = price + effort_slope(problem, duration, &solution);
        Ok(slope.is_finite().then_some(Known { duration, solution, slope }))
    };
    let first = about_a_fixed_axis(problem, price);
    for start in STARTS {
        let Some(found) = stationary(start * first, price, &mut at)? else { continue };
        let cost = |known: &Known| known.solution.cost + price * known.duration;
        if best.as_ref().is_none_or(|best| cost(&found) < cost(best)) {
            best = Some(found);
        }
    }
    let elapsed = began.elapsed().as_secs_f64();
    let Some(Known { duration, solution, slope }) = best else {
        let unsolved = stopped.unwrap_or_else(|| Solution::unsolved(problem, settings.tolerance));
        let outcome = match unsolved.outcome {
            Outcome::TimeLimit | Outcome::Interrupted => unsolved.outcome,
            _ => Outcome::Stalled,
        };
        let shortfall = format!(
            "no duration from {} s to {} s was found at which a second is worth its price",
            short(first / LONGEST_WAY),
            short(first * LONGEST_WAY)
        );
        return Ok(Solution { outcome, shortfall: Some(shortfall), solve_time: elapsed, ..unsolved });
    };
    let mut solution = Solution { solve_time: elapsed, ..solution };
    solution.cost += price * duration;
    for rival in &mut solution.rivals {
        rival.cost += price * duration;
    }
    solution.optimality.stationarity = solution.optimality.stationarity.max(slope.abs() / price);
    Ok(solution)
}

/// How long a turn about a fixed axis takes under unit weights: the root of `18 (Jφ)² / T⁴ = w`, for the rates as well.
fn about_a_fixed_axis(problem: &Problem, price: f64) -> f64 {
    let j = problem.body.inertia.j();
    let turn = lie::log(&problem.start.attitude.tr_mul(&problem.end.attitude));
    let weighted = problem.objective.weights().torque(&problem.actuation);
    let authority = weighted.authority.norm() / 3.0_f64.sqrt();
    let momentum = (j * turn).norm().max(1e-3 * j.norm());
    let rates = (j * (problem.start.angular_velocity - problem.end.angular_velocity)).norm();
    let of_turn = (18.0 * momentum * momentum / (authority * price)).powf(0.25);
    let of_rates = rates / (2.0 * authority * price).sqrt();
    of_turn.max(of_rates)
}

/// A duration at which the slope goes from negative to positive, from `start` on: a minimum.
fn stationary(
    start: f64,
    price: f64,
    at: &mut dyn FnMut(f64) -> Result<Option<Known>, PlanError>,
) -> Result<Option<Known>, PlanError> {
    let Some((mut low, mut high)) = bracket(start, at)? else { return Ok(None) };
    // Regula falsi that halves the weight of an end which stays (Illinois), in the logarithms.
    let mut weights = [deviation(&low, price), deviation(&high, price)];
    let mut last_moved = None;
    for _ in 0..MOST_ITERATIONS {
        let part = weights[0] / (weights[0] - weights[1]);
        let next = low.duration * (high.duration / low.duration).powf(part);
        if !(next > low.duration && next < high.duration) {
            break;
        }
        let Some(next) = at(next)? else { return Ok(None) };
        if next.slope.abs() <= STATIONARY * price {
            return Ok(Some(next));
        }
        let moved = usize::from(next.slope > 0.0);
        if last_moved == Some(moved) {
            weights[1 - moved] *= 0.5;
        }
        (weights[moved], last_moved) = (deviation(&next, price), Some(moved));
        *[&mut low, &mut high][moved] = next;
    }
    Ok(Some(if low.slope.abs() < high.slope.abs() { low } else { high }))
}

/// Two durations, at the shorter of which more time pays and at the longer less. Limits may leave no plan: then a duration
/// counts as too short.
fn bracket(
    start: f64,
    at: &mut dyn FnMut(f64) -> Result<Option<Known>, PlanError>,
) -> Result<Option<(Known, Known)>, PlanError> {
    let (mut low, mut high): (Option<Known>, Option<Known>) = (None, None);
    let (mut duration, mut too_short) = (start, None);
    for _ in 0..MOST_ITERATIONS {
        match at(duration)? {
            None => too_short = Some(duration),
            Some(known) if known.slope < 0.0 => low = Some(known),
            Some(known) => high = Some(known),
        }
        duration = match (&low, &high, too_short) {
            (Some(_), Some(_), _) => return Ok(low.zip(high)),
            (_, None, _) => 2.0 * duration,
            (None, Some(high), None) => 0.5 * high.duration,
            (None, Some(high), Some(short)) => (short * high.duration).sqrt(),
        };
        if !(start / LONGEST_WAY..=start * LONGEST_WAY).contains(&duration) {
            break;
        }
    }
    Ok(None)
}

/// `ln(−E'/w)`: positive where more time pays. Where effort grows with the duration, a negative number.
fn deviation(known: &Known, price: f64) -> f64 {
    const WRONG_SIDE: f64 = -2.0;
    (-known.slope / price).ln_1p().max(WRONG_SIDE)
}

/// `E'(T)`: the mean discrete Hamiltonian of a solution.
fn effort_slope(problem: &Problem, duration: f64, solution: &Solution) -> f64 {
    let Objective::Effort(weights) = &problem.objective else { return f64::NAN };
    let trajectory = &solution.trajectory;
    let steps = trajectory.time.len().saturating_sub(1);
    let body = &problem.body.inertia;
    let h = duration / steps as f64;
    let node = |k: usize| {
        let attitude = lie::rotation_from_quaternion(&trajectory.quaternion[k]);
        let pose = Pose { position: Vector3::zeros(), attitude };
        let torque = problem.environment.wrench(&pose).moment + trajectory.torque[k];
        (
            attitude,
            torque,
            problem.environment.gradient(&pose).rr,
            running(problem, weights, trajectory.inputs(k)),
        )
    };
    let mut from = node(0);
    let mut sum = 0.0;
    for k in 0..steps {
        let to = node(k + 1);
        let costate =
            |first: usize| Vector3::from_column_slice(&trajectory.costates[6 * (k + 1) + first..][..3]);
        let (zeta, pi) = (costate(0), costate(3));
        let f = from.0.tr_mul(&to.0);
        let kicked = body.j() * trajectory.angular_velocity[k] + 0.5 * h * from.1;
        let e = (f * body.j_d()).trace() * Matrix3::identity() - f * body.j_d();
        let xi = f.tr_mul(&drift_equation::solve3(&e, &(kicked + 0.5 * h * from.1)));
        let pull = f.tr_mul(&kicked).cross(&xi) + 0.5 * (f.tr_mul(&from.1) + to.1) + 0.5 * h * to.2 * xi;
        sum += 0.5 * (from.3 + to.3) + zeta.dot(&xi) + pi.dot(&pull);
        from = to;
    }
    sum / steps as f64
}

/// `½uᵀWu`.
fn running(problem: &Problem, weights: &Weights, inputs: &[f64]) -> f64 {
    effort(&weights.torque(&problem.actuation).weight, inputs)
}
