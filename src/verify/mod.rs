//! Independent witnesses of a plan. They share no code for solvers, sweeps or derivatives with the
//! planner.
//!
//! - The **discrete witness** propagates the inputs of the plan through its difference equations.
//!   It solves the implicit equation in another form than the planner does. It must meet the
//!   terminal conditions.
//! - The **continuous witness** integrates the equations of motion with the torque held over each
//!   step of the plan. It uses a Taylor series, or a method from another crate if forces depend on
//!   the pose. It records its state at both ends of a few windows of the plan.
//! - The **symplectic witness** propagates the held torque over the windows with a Galerkin
//!   variational integrator of high order. It must reach the states of the continuous witness to
//!   round-off.
//! - The **order test** compares the discrete and the continuous witness. Over the windows, with
//!   the held torque and successively shorter steps, the discrete witness must converge to the
//!   continuous one at the order of the scheme, or agree to round-off.
//!
//! [`Verification::witnesses`] states the number of steps over which each witness ran.
//!
//! The witnesses start from the problem and the recorded inputs only. They compare the recorded
//! attitudes, rates and torques with their own results.

mod accuracy;
mod attitudes;
mod compensated;
mod continuous;
mod course;
mod discrete;
mod held;
mod implicit;
mod margins;
mod motion;
mod order;
pub mod propagation;
mod pulses;
mod rows;
mod series;
mod symplectic;
mod verification;
pub(crate) mod watch;
mod way;
mod wheels;
mod window;

pub use accuracy::{Accuracy, DEFAULT_ACCURACY_DEG};
pub use attitudes::{
    AttitudeReport, AttitudeRows, RATES_AGAINST_ATTITUDES, Rounding, in_turns, judge_attitudes,
};
pub use course::{Clearance, Course, course};
pub use margins::{ConeAngle, Margin, NodeMargins, cone_angles, margins_at_nodes, worst_violation};
pub use motion::Phase;
pub use rows::{cost, effort, margins, replay, swept};
pub use verification::{Check, Testimony, Verification, WitnessError};

use crate::maneuver::duration::Duration;
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::{Sense, TerminalError, Trajectory};
use crate::numerics::parallel;
use crate::{Vector3, lie};
use held::{OnWindows, Symplectic, continuous_end, held_witnesses};
use motion::{Inputs, Scale, judgeable};
use std::sync::atomic::AtomicBool;
use watch::Watch;

/// Verifies a plan for `problem` with all witnesses.
///
/// `tolerance` bounds the scaled terminal error of the discrete witness. A landed plan has a
/// recorded state as its discrete target, and `tolerance` bounds the error of recorded states.
/// `continuous_tolerance` \[rad\] bounds the attitude error of the continuous witness and its
/// violation of cones. The function returns for any numbers in `trajectory`. A quantity that cannot
/// be computed is NaN in a failed check, and [`Verification::failure`] states the reason.
///
/// The checks have these names:
/// - `finite`: number of recorded numbers that are not finite
/// - `discrete terminal`
/// - `duration`, if inputs switch and the duration is given; `longest duration`, if the duration
///   has an upper bound
/// - `recorded states`
/// - `recorded motion`, if a landed plan records the true motion
/// - `total momentum`, if only wheels turn the body
/// - `constraints`, if the problem has limits or constraints: the worst scaled violation at and
///   between the nodes, with the limit [`Margin::ROUND_OFF`]
/// - `way round`, if the problem requests a homotopy class: 1 if the path has the other one
/// - `inputs off or at a limit` and `shortest pulse`, if the maneuver has a minimum pulse width;
///   the second check has the fraction by which the shortest pulse falls short of this width
/// - `order`, or `round-off` if the witnesses agree to round-off
/// - `symplectic witness`, if this witness can check the plan
/// - `continuous terminal`
/// - `continuous state`, for a landed plan: terminal rate, position and velocity, scaled
/// - `continuous constraints`, if a continuous tolerance is given and the maneuver has rate limits
///   or cones: the worst violation by the continuous motion, in \[rad\] or as a fraction of the
///   rate limit
///
/// Without a continuous tolerance, the continuous motion may miss the terminal attitude by a
/// quarter of the angle that the body turns, where this bound is clamped to 5°–45°. A larger error
/// means that the steps are too coarse to represent a motion.
pub fn verify(
    problem: &Problem,
    trajectory: &Trajectory,
    tolerance: f64,
    continuous_tolerance: Option<f64>,
) -> Verification {
    verify_until(problem, trajectory, tolerance, continuous_tolerance, &|| false)
}

/// Verifies as [`verify`] does, but aborts when `stop`, which is polled every few steps, returns
/// true. An aborted verification reports [`Verification::was_stopped`], and the plan does not count
/// as verified.
pub fn verify_until(
    problem: &Problem,
    trajectory: &Trajectory,
    tolerance: f64,
    continuous_tolerance: Option<f64>,
    stop: &dyn Fn() -> bool,
) -> Verification {
    if problem.seeks_duration() && trajectory.time.len() == 1 {
        return at_rest(problem, trajectory, tolerance);
    }
    let stopped = AtomicBool::new(false);
    let watch = Watch::new(&stopped, stop);
    let mut found = Verification::unknown(problem.motion);
    let mut judged = Judged {
        recorded: f64::NAN,
        flown: None,
        continuous_state: f64::NAN,
        momentum_drift: None,
        goes_as_asked: None,
        violation: f64::NAN,
        continuous_violation: f64::NAN,
        comparison: None,
        apart_limit: 0.0,
    };
    if let Err(error) = found.witness(problem, trajectory, &watch, &mut judged) {
        found.failure = Some(error.to_string());
    }
    let Judged {
        recorded,
        flown,
        continuous_state,
        momentum_drift,
        goes_as_asked,
        violation,
        continuous_violation,
        comparison,
        apart_limit,
    } = judged;
    found.at_most("finite", rows::not_finite(trajectory) as f64, 0.0);
    // The discrete target of a landed plan is the recorded end of its discrete motion.
    let on_record = RECORDED.max(10.0 * tolerance);
    let terminal = if trajectory.target.is_some() { on_record } else { tolerance };
    found.at_most("discrete terminal", found.discrete().largest(), terminal);
    if let (true, Duration::Given(duration)) = (problem.switches(), problem.duration) {
        let last = trajectory.time.last().copied().unwrap_or(f64::NAN);
        found.at_most("duration", (last / duration - 1.0).abs(), RECORDED);
    }
    if let Some(longest) = problem.duration.at_most() {
        let last = trajectory.time.last().copied().unwrap_or(f64::NAN);
        found.at_most("longest duration", last / longest - 1.0, RECORDED);
    }
    if let Some(asked) = problem.shortest_pulse()
        && problem.switches()
    {
        let pulses = match rows::fit(problem, trajectory) {
            Ok(()) => pulses::found(problem, trajectory),
            Err(_) => pulses::UNKNOWN,
        };
        found.at_most("inputs off or at a limit", pulses.between, pulses::AT_LIMIT);
        // A plan without pulses cannot have a pulse that is too short.
        let missing = if pulses.shortest == f64::INFINITY { 0.0 } else { 1.0 - pulses.shortest / asked };
        found.at_most("shortest pulse", missing, pulses::ROUND_OFF);
    }
    found.at_most("recorded states", recorded, on_record);
    if trajectory.target.is_some() {
        found.at_most("recorded motion", flown.unwrap_or(f64::NAN), FLOWN);
    }
    if let Some(drift) = momentum_drift {
        let limit = if trajectory.target.is_some() { FLOWN } else { on_record };
        found.at_most("total momentum", drift, limit);
    }
    if let Some(as_asked) = goes_as_asked {
        found.at_most("way round", f64::from(u8::from(!as_asked)), 0.0);
    }
    if problem.is_constrained() {
        found.at_most("constraints", violation, Margin::ROUND_OFF);
    }
    match &comparison {
        Some(comparison) if comparison.passed && comparison.order.is_none() => {
            let finest = comparison.errors.last().copied().unwrap_or(f64::NAN);
            found.at_most("round-off", finest, comparison.floor);
        }
        _ => found.checks.push(Check {
            name: "order".into(),
            value: found.order.unwrap_or(f64::NAN),
            limit: f64::from(problem.scheme.order()) - order::SLACK,
            passed: comparison.is_some_and(|comparison| comparison.passed),
        }),
    }
    if let Some(apart) = found.symplectic_to_continuous {
        found.at_most("symplectic witness", apart, apart_limit);
    }
    let wide = continuous_tolerance.unwrap_or_else(|| miss_allowed(rows::turned(trajectory)));
    found.at_most("continuous terminal", found.continuous_attitude_rad, wide);
    // The discrete motion meets its own target. Only the true motion must meet the terminal rate,
    // position and velocity.
    if trajectory.target.is_some() {
        found.at_most("continuous state", continuous_state, wide);
    }
    if let Some(limit) = continuous_tolerance
        && !problem.constraints.is_empty()
    {
        found.at_most("continuous constraints", continuous_violation, limit);
    }
    found
}

/// Returns the homotopy class of a recorded path, short or long. The two classes are distinguished
/// by the motion without inputs. Returns `None` if both classes are equally long, if this motion
/// cannot be propagated, or if `stop` returns true.
#[must_use]
pub fn sense(problem: &Problem, trajectory: &Trajectory, stop: &dyn Fn() -> bool) -> Option<Sense> {
    let stopped = AtomicBool::new(false);
    rows::fit(problem, trajectory).ok()?;
    let flown = problem.clone().with_duration(rows::grid(problem, trajectory).ok()?.duration());
    let plant = judgeable(&flown).ok()?;
    way::sense(&plant, &flown, trajectory, &Watch::new(&stopped, stop)).ok()?
}

/// Verifies a plan of zero duration: the start, the end and the recorded state must be equal.
fn at_rest(problem: &Problem, trajectory: &Trajectory, tolerance: f64) -> Verification {
    let mut found = Verification::unknown(problem.motion);
    let second = problem.clone().with_duration(1.0);
    let (scale, motion) = (Scale::of(&second), problem.motion);
    let [start, end] = [&problem.start, &problem.end].map(|state| Phase::of(problem, state));
    let error = scale.distance(&start, &end, motion);
    let recorded = trajectory.quaternion.first().zip(trajectory.angular_velocity.first());
    let recorded = recorded.map_or(f64::NAN, |(quaternion, rate)| {
        let momentum = problem.body.inertia.j() * rate;
        let phase = Phase { attitude: lie::rotation_from_quaternion(quaternion), momentum, ..start };
        scale.distance(&phase, &start, motion).largest().max(trajectory.time[0].abs())
    });
    found.discrete_attitude_rad = error.attitude_rad;
    found.discrete_momentum_relative = error.momentum_relative;
    found.continuous_attitude_rad = error.attitude_rad;
    found.continuous_rate_rad_s = (end.angular_velocity(problem) - start.angular_velocity(problem)).norm();
    found.interpolated_attitude_rad = error.attitude_rad;
    found.interpolated_rate_rad_s = found.continuous_rate_rad_s;
    found.peak_torque_n_m = 0.0;
    found.peak_rate_rad_s = problem.start.angular_velocity.norm();
    found.at_most("finite", rows::not_finite(trajectory) as f64, 0.0);
    found.at_most("discrete terminal", error.largest(), tolerance);
    found.at_most("recorded states", recorded, RECORDED.max(10.0 * tolerance));
    found
}

/// Fraction of the angle turned by which the continuous motion may miss the terminal attitude if no
/// tolerance is given.
const MISSED: f64 = 0.25;

/// Smallest value of this bound \[deg\].
const MISSED_LEAST_DEG: f64 = 5.0;
/// Largest value of this bound \[deg\].
const MISSED_MOST_DEG: f64 = 45.0;

/// Returns the allowed terminal attitude error \[rad\] of the continuous motion if no tolerance is
/// given and the body turns by `turned` \[rad\].
fn miss_allowed(turned: f64) -> f64 {
    (MISSED * turned).clamp(MISSED_LEAST_DEG.to_radians(), MISSED_MOST_DEG.to_radians())
}

/// Accepted scaled difference between recorded and propagated states. It is far above round-off and
/// far below any relevant error.
const RECORDED: f64 = 1e-9;

/// Accepted scaled difference between the recorded true motion of a landed plan and the witness,
/// after many turns.
const FLOWN: f64 = 1e-6;

/// The numbers that the checks need in addition to a [`Verification`]; NaN or `None` if a witness
/// failed.
struct Judged {
    /// Largest scaled difference between recorded and propagated states.
    recorded: f64,
    /// Scaled error of the recorded true motion; `None` if the plan does not record it.
    flown: Option<f64>,
    /// Largest terminal error of the continuous motion in rate, position and velocity, scaled.
    continuous_state: f64,
    /// Drift of the total momentum over the recorded states; `None` unless only wheels turn the
    /// body.
    momentum_drift: Option<f64>,
    /// Whether the path has the requested homotopy class; `None` if no class is requested.
    goes_as_asked: Option<bool>,
    /// Worst scaled violation of a limit or constraint by the discrete motion.
    violation: f64,
    /// Worst violation of a constraint by the continuous motion: \[rad\], or a fraction of the rate
    /// limit.
    continuous_violation: f64,
    comparison: Option<order::Comparison>,
    /// Allowed distance between the ends of the symplectic and the continuous witness.
    apart_limit: f64,
}

impl Verification {
    /// Runs the witnesses, two at a time, and records the results of those that finish.
    fn witness(
        &mut self,
        problem: &Problem,
        trajectory: &Trajectory,
        watch: &Watch,
        judged: &mut Judged,
    ) -> Result<(), WitnessError> {
        problem.check_numbers()?;
        rows::fit(problem, trajectory)?;
        let grid = rows::grid(problem, trajectory)?;
        let flown = problem.clone().with_duration(grid.duration());
        let problem = &flown;
        let plant = judgeable(problem)?;
        let inputs = Inputs::on(problem, grid, &trajectory.input);
        // The homotopy class is unknown if the motion without inputs cannot be propagated.
        judged.goes_as_asked = way::goes_as_asked(&plant, problem, trajectory, watch).unwrap_or(None);
        let isolated = plant.free && problem.actuation.wheels.is_some();
        judged.momentum_drift = isolated.then(|| rows::momentum_drift(&plant, trajectory));
        let start = Phase::of(problem, &problem.start);
        let target = Phase::of(problem, &problem.end);
        let scale = Scale::of(problem);
        let steps = problem.steps;

        // The two halves are independent, so one thread and two threads give bit-identical results.
        let replayed = |watch: &Watch| {
            let replayed = rows::compare(&plant, &inputs, trajectory, watch);
            (replayed, continuous_end(&plant, &start, &inputs, watch))
        };
        let flown = trajectory.target.is_some().then_some(trajectory);
        let held = |watch: &Watch| held_witnesses(&plant, &inputs, &start, flown, watch);
        let ((replayed, interpolated), held) = if steps >= WORTH_A_THREAD && parallel::threads() > 1 {
            let noted = watch.noted();
            parallel::both(|| replayed(watch), || held(&Watch::of(noted)), || watch.ask())
        } else {
            (replayed(watch), held(watch))
        };

        let replayed = replayed?;
        self.ran("discrete", format!("{}, exponential form", problem.scheme.name()), steps, 1);
        judged.recorded = replayed.recorded;
        judged.violation = worst_violation(&replayed.margins);
        self.peak_torque_n_m = replayed.peak_torque;
        self.peak_rate_rad_s = replayed.peak_rate;
        self.margins = replayed.margins;
        let aimed = trajectory.target.map_or(target, |end| Phase::of(problem, &end));
        let error = scale.distance(&replayed.end, &aimed, problem.motion);
        self.discrete_attitude_rad = error.attitude_rad;
        self.discrete_momentum_relative = error.momentum_relative;
        self.discrete_position_relative = error.position_relative;
        self.discrete_linear_momentum_relative = error.linear_momentum_relative;

        let held = held?;
        self.ran("continuous, held torque", held.method, steps, 1);
        for margin in &mut self.margins {
            let continuous = held.margins.iter().find(|continuous| continuous.name == margin.name);
            margin.continuous_margin = continuous.map(|found| found.margin).filter(|margin| !margin.is_nan());
        }
        judged.flown = flown.map(|_| held.recorded);
        let limits = problem.actuation.limits().count().min(held.margins.len());
        judged.continuous_violation = worst_violation(&held.margins[limits..]);
        let missed = |end: &Phase| {
            let moves = |error: Vector3| plant.moves.then(|| error.norm());
            (
                scale.distance(end, &target, problem.motion).attitude_rad,
                (end.angular_velocity(problem) - problem.end.angular_velocity).norm(),
                moves(end.position - problem.end.position),
                moves(end.velocity(problem) - problem.end.velocity),
            )
        };
        judged.continuous_state = {
            let error = scale.distance(&held.end, &target, problem.motion);
            TerminalError { attitude_rad: 0.0, ..error }.largest()
        };
        let (attitude, rate, position, velocity) = missed(&held.end);
        (self.continuous_attitude_rad, self.continuous_rate_rad_s) = (attitude, rate);
        (self.continuous_position_m, self.continuous_velocity_m_s) = (position, velocity);

        let interpolated = interpolated?;
        self.ran("continuous, linear torque", held.method, steps, 1);
        (self.interpolated_attitude_rad, self.interpolated_rate_rad_s, ..) = missed(&interpolated);

        let OnWindows { steps, windows, symplectic, order } = held.windows?;
        match symplectic {
            Ok(Symplectic { end, order, apart, limit }) => {
                self.ran("symplectic", format!("Galerkin of order {order}"), steps, windows);
                let (attitude, rate, position, velocity) = missed(&end);
                (self.symplectic_attitude_rad, self.symplectic_rate_rad_s) = (Some(attitude), Some(rate));
                (self.symplectic_position_m, self.symplectic_velocity_m_s) = (position, velocity);
                self.symplectic_to_continuous = Some(apart);
                judged.apart_limit = limit;
            }
            Err(why) => self.ran("symplectic", why, 0, 0),
        }
        let finest = 1 << (order.errors.len() - 1);
        let down_to = if finest == 1 { "h".into() } else { format!("h to h/{finest}") };
        self.ran("order", format!("{} at {down_to}", problem.scheme.name()), steps, windows);
        self.order = order.order;
        judged.comparison = Some(order);
        Ok(())
    }
}

/// Smallest number of steps for which a second thread saves more time than it costs.
const WORTH_A_THREAD: usize = 400;

/// Returns the end of the continuous witness from the start of the maneuver, under outputs held
/// over steps of given lengths. Tests compare other flows with this result.
#[cfg(test)]
pub(crate) fn continuous_flow(
    plant: &crate::propagate::plant::Plant,
    steps: impl Iterator<Item = (crate::propagate::plant::Output, f64)>,
) -> crate::maneuver::State {
    let problem = plant.problem;
    let mut body = continuous::Continuous::new(plant, &Phase::of(problem, &problem.start));
    let mut time = 0.0;
    for (output, step) in steps {
        body.advance(time, step, &output, &output).unwrap();
        time += step;
    }
    let end = body.phase(time);
    crate::maneuver::State {
        position: end.position,
        velocity: end.velocity(problem),
        attitude: end.attitude,
        angular_velocity: end.angular_velocity(problem),
    }
}
