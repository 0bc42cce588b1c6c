//! Least effort where the duration is sought: a second has a price, or the duration a bound.
//!
//! For a given duration the cost is `J(T) = E(T) + w T` with the least effort `E` and the price `w`, or none. Its
//! derivative is exact on the grid: the mean of the discrete Hamiltonians, which are the derivatives of the discrete
//! action by the length of each step,
//!
//! ```text
//! 𝓗_k = ½(ℓ_k + ℓ_{k+1}) + λ^ζ·ζ' + λ^Π·[(FᵀΠ̂)×ξ' + ½Fᵀτ_k + ½τ_{k+1} + h M_R(R_{k+1}) ζ'] ,   ℓ = ½uᵀWu
//! Π̂  = Π_k + (h/2) τ_k ,   ξ' = Fᵀ E⁻¹ (Π̂ + (h/2) τ_k) ,   E = tr(F J_d) I − F J_d ,   ζ' = ξ' − R_{k+1}ᵀ ω
//! ```
//!
//! with the rate ω of the reference frame, `R_{k+1} = exp(−h S(ω)) R_k F`, all torques in τ, λ the recorded costates
//! (after the whole kick at the end of the step, half of which is the next step's: hence `h M_R` and not half of it),
//! and `M_R` the derivative of the torques by the attitude. `E'` is about `−3E/T` from rest to rest, so the secant
//! runs in the logarithms of `T` and `−E'`, where that is a straight line.
//!
//! # How is the duration of least effort found?
//!
//! By the derivative of the cost with respect to it, which is exact on the grid: the mean of the discrete Hamiltonians, plus
//! the price. A search for a given duration stands inside (`optimize/search/duration.rs`), with all its starts and senses, so
//! that nothing of it had to learn of a free duration; outside runs regula falsi in the logarithms of `T` and `−E'`, straight
//! lines from rest to rest, from three first durations. Only a root at which the derivative goes from negative to positive
//! counts, a minimum in the duration; a bend where two extremals change places is concave and never one. A Newton on costates
//! and duration together would save some of these solves and would need a search of its own. What depends on the step
//! otherwise than by its length (rate limits, wheels, cones) goes the road of minimum time, with the duration as a state and
//! the effort as `Σ κ ½uᵀWu / s³` in its units; a limit that never acts leads both roads to one plan. A price beyond what the
//! limits can do has no such root: the plan is then the shortest that has one. A frame that turns adds its own turn to that
//! of a step. Flights go that road too. A problem keeps `NaN` as its duration; `Problem::with_found_duration` is the same on
//! the grid of its plan.
//!
//! With a bound in place of a price (`duration_at_most_s`) all of the time is an answer where more of it would pay; from rest
//! to rest it always is. A body that coasts comes by its target again and again, and every time is a minimum of its own:
//! eighths of the bound are looked at, and every change of sign between them. Fuel knows the derivative as the Hamiltonian:
//! the plan of all the time is compared with the one whose Hamiltonian vanishes. A key of its own beside `duration_s`, and
//! not a table within it, leaves every key one kind of value.

use super::halt::Halt;
use super::illinois::Illinois;
use super::{Observer, PlanError};
use crate::maneuver::objective::{Objective, effort};
use crate::maneuver::problem::{Motion, Problem};
use crate::maneuver::settings::{Method, Settings};
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Outcome, Solution};
use crate::mechanics::actuators::AxisFrame;
use crate::mechanics::drift_equation;
use crate::mechanics::environment::Pose;
use crate::{Matrix3, Vector3, lie};
use std::time::Instant;

/// Derivatives of the cost below this part of the price, or of that at the longest duration, are zero.
const STATIONARY: f64 = 1e-13;
const MOST_ITERATIONS: usize = 60;
/// A duration that has a plan is the shortest where one shorter by this part has none.
const EDGE: f64 = 1e-4;
/// Starts, as multiples of the duration of a turn about a fixed axis, and the longest way to either side.
const STARTS: [f64; 3] = [1.0, 0.4, 2.5];
const LONGEST_WAY: f64 = 64.0;
/// Parts of the longest duration that are looked at.
const PARTS: usize = 8;

/// What is known of one duration.
#[derive(Clone)]
struct Known {
    duration: f64,
    solution: Solution,
    /// `J'(T)`.
    slope: f64,
    /// Its size relative to the price; 0 where the cost need not be stationary.
    stationarity: f64,
}

impl Known {
    fn cost(&self, price: f64) -> f64 {
        self.solution.cost + price * self.duration
    }
}

/// A duration that has a plan, or none.
type At<'a> = dyn FnMut(f64) -> Result<Option<Known>, Halt> + 'a;

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
    let mut unsolved: Option<Box<Solution>> = None;
    let mut shortest: Option<Known> = None;
    let mut at = |duration: f64| -> Result<Option<Known>, Halt> {
        let remaining = settings.time_limit.map(|limit| limit.saturating_sub(began.elapsed()));
        // The shooting alone: what it cannot do within the limits is too short, and the interior point would search for long.
        let settings = Settings { time_limit: remaining, method: Method::Shooting, ..settings.clone() };
        let given = problem.clone().lasting(duration);
        if given.check().is_err() {
            // Boundary rates that turn too far in a step of such a length.
            return Ok(None);
        }
        let solution = solve(&given, &settings, observer)?;
        match solution.outcome {
            Outcome::Converged => {}
            Outcome::TimeLimit | Outcome::Interrupted => return Err(Halt::Stopped(Box::new(solution))),
            _ => {
                unsolved = Some(Box::new(solution));
                return Ok(None);
            }
        }
        let slope = price + effort_slope(problem, duration, &solution);
        let known = Known { duration, solution, slope, stationarity: 0.0 };
        if shortest.as_ref().is_none_or(|shortest| duration < shortest.duration) {
            shortest = Some(known.clone());
        }
        Ok(slope.is_finite().then_some(known))
    };
    let (first, longest) = (about_a_fixed_axis(problem, price), problem.duration.at_most());
    let mut keep = |found: Known| {
        if best.as_ref().is_none_or(|best| found.cost(price) < best.cost(price)) {
            best = Some(found);
        }
    };
    let searched = match longest {
        Some(longest) => up_to(longest, price, problem.can_wait(), &mut at, &mut keep),
        None => STARTS.iter().try_for_each(|start| {
            stationary(start * first, f64::INFINITY, price, &mut at)?.into_iter().for_each(&mut keep);
            Ok(())
        }),
    };
    let stopped = match searched {
        Ok(()) => None,
        Err(Halt::Refused(error)) => return Err(error),
        // What was found before stands.
        Err(Halt::Stopped(solution)) => Some(solution),
    };
    let elapsed = began.elapsed().as_secs_f64();
    // Where less time pays at all that have a plan, the shortest is the best: the limits leave nothing shorter.
    let at_the_edge = |shortest: Known| {
        let solution = Solution { shortest: Some(shortest.duration), ..shortest.solution };
        Known { solution, ..shortest }
    };
    let edge = shortest.filter(|shortest| stopped.is_none() && shortest.slope > 0.0).map(at_the_edge);
    let Some(Known { duration, solution, stationarity, .. }) = best.or(edge) else {
        if let Some(stopped) = stopped {
            return Ok(Solution { solve_time: elapsed, ..*stopped });
        }
        let unsolved =
            unsolved.map_or_else(|| Solution::unsolved(problem, settings.tolerance), |solution| *solution);
        let shortfall = match longest {
            Some(longest) => Shortfall::NoneWithin { longest },
            None => Shortfall::NoWorthwhile { from: first / LONGEST_WAY, to: first * LONGEST_WAY },
        };
        let (outcome, shortfall) = (Outcome::Stalled, Some(shortfall));
        return Ok(Solution { outcome, shortfall, solve_time: elapsed, ..unsolved });
    };
    let mut solution = Solution { solve_time: elapsed, ..solution };
    solution.pay_for_time(price * duration);
    solution.optimality.stationarity = solution.optimality.stationarity.max(stationarity);
    Ok(solution)
}

/// How long a turn about a fixed axis takes under unit weights: the root of `18 (Jφ)² / T⁴ = w`, for the rates as well; or a
/// flight along a line, where that is longer. Infinite without a price.
pub(super) fn about_a_fixed_axis(problem: &Problem, price: f64) -> f64 {
    let lasting = |impulse: f64, change: f64, authority: &Matrix3| {
        let authority = authority.norm() / 3.0_f64.sqrt();
        let of_way = (18.0 * impulse * impulse / (authority * price)).powf(0.25);
        of_way.max(change / (2.0 * authority * price).sqrt())
    };
    let (start, end, weights) = (&problem.start, &problem.end, problem.objective.weights());
    let j = problem.body.inertia.j();
    let turn = lie::log(&start.attitude.tr_mul(&end.attitude));
    let momentum = (j * turn).norm().max(1e-3 * j.norm());
    let rates = (j * (start.angular_velocity - end.angular_velocity)).norm();
    let turning = lasting(momentum, rates, &weights.torque(&problem.actuation).authority);
    let mass = problem.body.mass.filter(|_| problem.motion == Motion::RigidBody);
    let flying = mass.zip(weights.force(&problem.actuation)).map_or(0.0, |(mass, force)| {
        let (way, speed) = (end.position - start.position, end.velocity - start.velocity);
        lasting(mass * way.norm(), mass * speed.norm(), &force.authority)
    });
    turning.max(flying)
}

/// Minima up to the longest duration: where the slope changes its sign between neighbouring parts of it, and all of it. A
/// body that coasts has many, one for each time that it comes by its target.
fn up_to(
    longest: f64,
    price: f64,
    can_wait: bool,
    at: &mut At<'_>,
    keep: &mut dyn FnMut(Known),
) -> Result<(), Halt> {
    // Effort only falls with the duration where the body can wait: from rest to rest `E ∝ T⁻³`.
    let parts = if can_wait { 1 } else { PARTS };
    let mut before: Option<Known> = None;
    for part in 1..=parts {
        let known = at(longest * part as f64 / parts as f64)?;
        let found = match (&before, &known) {
            (Some(low), Some(high)) if low.slope < 0.0 && high.slope > 0.0 => {
                between(low.clone(), high.clone(), price, at)?
            }
            // Nothing shorter is known: from here on down.
            (None, Some(high)) if high.slope > 0.0 => stationary(high.duration, longest, price, at)?,
            (_, Some(all)) if part == parts && all.slope <= 0.0 => Some(all.clone()),
            _ => None,
        };
        found.into_iter().for_each(&mut *keep);
        before = known;
    }
    Ok(())
}

/// A minimum, looked for from `start` on, up to the longest duration.
fn stationary(start: f64, longest: f64, price: f64, at: &mut At<'_>) -> Result<Option<Known>, Halt> {
    match bracket(start, longest, at)? {
        Some((low, high)) => between(low, high, price, at),
        None => Ok(None),
    }
}

/// A duration at which the slope goes from negative to positive: a minimum.
fn between(mut low: Known, mut high: Known, price: f64, at: &mut At<'_>) -> Result<Option<Known>, Halt> {
    // What slopes are compared with.
    let scale = if price > 0.0 { price } else { low.slope.abs().max(high.slope.abs()) };
    let relative = |known: Known| Known { stationarity: known.slope.abs() / scale, ..known };
    // In the logarithms, where deviations are straight lines.
    let mut illinois = Illinois::new([deviation(&low, scale), deviation(&high, scale)]);
    for _ in 0..MOST_ITERATIONS {
        let next = low.duration * (high.duration / low.duration).powf(illinois.part());
        if !(next > low.duration && next < high.duration) {
            break;
        }
        let Some(next) = at(next)? else { return Ok(None) };
        if next.slope.abs() <= STATIONARY * scale {
            return Ok(Some(relative(next)));
        }
        let moved = usize::from(next.slope > 0.0);
        illinois.moved(moved, deviation(&next, scale));
        *[&mut low, &mut high][moved] = next;
    }
    Ok(Some(relative(if low.slope.abs() < high.slope.abs() { low } else { high })))
}

/// Two durations, at the shorter of which more time pays and at the longer less. Limits may leave no plan: then a duration
/// counts as too short, and where less time pays down to the shortest that has one there are no such two.
fn bracket(start: f64, longest: f64, at: &mut At<'_>) -> Result<Option<(Known, Known)>, Halt> {
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
            (_, None, _) if duration >= longest => break,
            (_, None, _) => (2.0 * duration).min(longest),
            (None, Some(high), None) => 0.5 * high.duration,
            (None, Some(high), Some(short)) if high.duration <= short * (1.0 + EDGE) => break,
            (None, Some(high), Some(short)) => (short * high.duration).sqrt(),
        };
        if !(start / LONGEST_WAY..=start * LONGEST_WAY).contains(&duration) {
            break;
        }
    }
    Ok(None)
}

/// `ln(−E'/w)` where the scale is the price `w`: positive where more time pays. Where effort grows with the duration, a
/// negative number.
fn deviation(known: &Known, scale: f64) -> f64 {
    const WRONG_SIDE: f64 = -2.0;
    (-known.slope / scale).ln_1p().max(WRONG_SIDE)
}

/// What a node has to do with the steps beside it.
struct Node {
    attitude: Matrix3,
    torque: Vector3,
    /// Derivative of the torque by the attitude, `M_R`.
    gradient: Matrix3,
    /// `ℓ = ½uᵀWu`.
    running: f64,
}

/// `E'(T)`: the mean discrete Hamiltonian of a solution.
fn effort_slope(problem: &Problem, duration: f64, solution: &Solution) -> f64 {
    let Objective::Effort(weights) = &problem.objective else { return f64::NAN };
    let weight = weights.torque(&problem.actuation).weight;
    let turning = problem.actuation.torque.frame() == AxisFrame::Reference;
    let trajectory = &solution.trajectory;
    let steps = trajectory.time.len().saturating_sub(1);
    let body = &problem.body.inertia;
    let h = duration / steps as f64;
    let frame_rate = problem.environment.frame_rate();
    let frame_turn = lie::exp(&(h * frame_rate));
    let node = |k: usize| {
        let attitude = lie::rotation_from_quaternion(&trajectory.quaternion[k]);
        let pose = Pose { position: Vector3::zeros(), attitude };
        let held = trajectory.torque[k];
        // Torques about axes of the reference frame turn backwards in the body: δ(Rᵀt) = (Rᵀt) × ξ for δR = R ξ̂.
        let of_actuators = if turning { lie::hat(&held) } else { Matrix3::zeros() };
        Node {
            attitude,
            torque: problem.environment.wrench(&pose).moment + held,
            gradient: problem.environment.gradient(&pose).rr + of_actuators,
            running: effort(&weight, trajectory.inputs(k)),
        }
    };
    let mut from = node(0);
    let mut sum = 0.0;
    for k in 0..steps {
        let to = node(k + 1);
        let costate =
            |first: usize| Vector3::from_column_slice(&trajectory.costates[6 * (k + 1) + first..][..3]);
        let (zeta, pi) = (costate(0), costate(3));
        let f = from.attitude.tr_mul(&(frame_turn * to.attitude));
        let kicked = body.j() * trajectory.angular_velocity[k] + 0.5 * h * from.torque;
        let e = (f * body.j_d()).trace() * Matrix3::identity() - f * body.j_d();
        let xi = f.tr_mul(&drift_equation::solve3(&e, &(kicked + 0.5 * h * from.torque)));
        let torques = 0.5 * (f.tr_mul(&from.torque) + to.torque);
        // The attitude relative to the frame, which turns away meanwhile.
        let turn = xi - to.attitude.tr_mul(&frame_rate);
        let pull = f.tr_mul(&kicked).cross(&xi) + torques + h * to.gradient * turn;
        sum += 0.5 * (from.running + to.running) + zeta.dot(&turn) + pi.dot(&pull);
        from = to;
    }
    sum / steps as f64
}
