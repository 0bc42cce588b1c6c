//! Independent witnesses of a plan. They share no solver, sweep or derivative code with the planner.
//!
//! - The **discrete witness** propagates the plan's inputs through its own difference equations, the
//!   implicit one solved in another form than the planner's. It must meet the terminal conditions.
//! - The **continuous witness** follows the equations of motion, the torque held over each step of the plan: as a
//!   Taylor series, or with a method from another crate where forces depend on the pose. It notes where it is at the
//!   ends of a few windows of the plan.
//! - The **symplectic witness** propagates the same held torque over the windows with a Galerkin variational
//!   integrator of high order, and must end where the continuous one does, to round-off.
//! - The first two must describe one motion: over the windows, with that held torque and ever shorter steps, the first
//!   converges to the second at the order of the scheme, or to round-off.
//!
//! Over how many steps each ran stands in [`Verification::witnesses`].
//!
//! The witnesses start from the problem and the recorded inputs alone. The recorded attitudes, rates
//! and torques are compared with what they find.

mod accuracy;
mod attitudes;
mod compensated;
mod continuous;
mod course;
mod discrete;
mod implicit;
mod margins;
mod motion;
mod order;
pub mod propagation;
mod pulses;
mod rows;
mod series;
mod symplectic;
pub(crate) mod watch;
mod way;
mod wheels;
mod window;

pub use accuracy::{Accuracy, DEFAULT_ACCURACY_DEG};
pub use attitudes::{AttitudeReport, judge_attitudes};
pub use course::{Clearance, Course, course};
pub use margins::{ConeAngle, Margin, NodeMargins, cone_angles, margins_at_nodes, worst_violation};
pub use motion::Phase;
pub use rows::{cost, effort, margins, replay, swept};

use crate::maneuver::constraint::{Arc, Rule};
use crate::maneuver::problem::{Motion, Problem, ProblemError};
use crate::maneuver::solution::{TerminalError, Trajectory};
use crate::numerics::parallel;
use crate::propagate::plant::Plant;
use crate::{Vector3, lie};
use continuous::Continuous;
use discrete::Discrete;
use margins::Meter;
use motion::{InOrder, Inputs, Scale, judgeable};
use order::Stage;
use serde::{Deserialize, Serialize};
use std::sync::atomic::AtomicBool;
use thiserror::Error;
use watch::Watch;
use window::{Marks, Window};

/// What the witnesses found. All errors are at `t = T`, against the terminal conditions of the problem
/// unless the name says otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Verification {
    /// Discrete equations re-propagated with the exponential form: attitude error \[rad\].
    pub discrete_attitude_rad: f64,
    /// The same: momentum error, `|ΔΠ| T / J_mean`.
    pub discrete_momentum_relative: f64,
    /// The same on SE(3): position error over the unit of length.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub discrete_position_relative: Option<f64>,
    /// The same on SE(3): linear momentum error over mass · length / `T`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub discrete_linear_momentum_relative: Option<f64>,
    /// Continuous equations of motion, torque held over each step: attitude error \[rad\].
    pub continuous_attitude_rad: f64,
    /// The same: rate error [rad/s].
    pub continuous_rate_rad_s: f64,
    /// The same with the torque interpolated linearly over each step: attitude error \[rad\].
    pub interpolated_attitude_rad: f64,
    /// The same, interpolated: rate error [rad/s].
    pub interpolated_rate_rad_s: f64,
    /// The same, held, on SE(3): position error \[m\].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub continuous_position_m: Option<f64>,
    /// The same, held, on SE(3): velocity error [m/s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub continuous_velocity_m_s: Option<f64>,
    /// The symplectic witness, torque held over each step, from where the continuous one begins the last window:
    /// attitude error \[rad\]. `None` where it cannot judge, which [`Verification::witnesses`] says.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub symplectic_attitude_rad: Option<f64>,
    /// The same: rate error [rad/s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub symplectic_rate_rad_s: Option<f64>,
    /// The same on SE(3): position error \[m\].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub symplectic_position_m: Option<f64>,
    /// The same on SE(3): velocity error [m/s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub symplectic_velocity_m_s: Option<f64>,
    /// Largest scaled distance between the ends of the symplectic and the continuous witness in a window.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub symplectic_to_continuous: Option<f64>,
    /// Observed order at which the discrete witness, with the held torque at h, h/2, h/4, converges to
    /// the continuous one over the windows; `None` at round-off, or where it could not be computed.
    pub order: Option<f64>,
    /// Largest norm of the actuator torque at the nodes [N·m].
    pub peak_torque_n_m: f64,
    /// Largest norm of the angular velocity at the nodes [rad/s].
    pub peak_rate_rad_s: f64,
    /// Every limit and constraint with its smallest margin, in the order of the problem.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub margins: Vec<Margin>,
    /// Which witnesses ran, by what method, over how many steps of the plan.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub witnesses: Vec<Testimony>,
    /// Why a witness could not reach the end, if one could not; its numbers are then NaN.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub failure: Option<String>,
    /// Every check, with value, limit and verdict.
    pub checks: Vec<Check>,
}

/// Which witness ran over how many steps of the plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Testimony {
    /// "discrete", "continuous, held torque", "continuous, linear torque", "order", "symplectic".
    pub witness: String,
    /// Its method; or why it does not judge.
    pub method: String,
    /// Steps of the plan it ran over: all, or those of the windows.
    pub steps: usize,
    /// In how many stretches.
    pub windows: usize,
}

/// One named check.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// What was checked.
    pub name: String,
    /// The value found.
    pub value: f64,
    /// The limit it was held against.
    pub limit: f64,
    /// Whether it holds.
    pub passed: bool,
}

/// Why a witness could not reach the end.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum WitnessError {
    /// The problem itself is unusable.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The recorded rows do not fit the problem.
    #[error("the plan has {found} {what}, the problem needs {expected}")]
    Rows {
        /// Which numbers.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// The scheme of a moving body knows inertial reference frames only.
    #[error("a body that moves cannot be judged in a turning reference frame")]
    TurningFrame,
    /// The implicit equation has no solution below 90° in a step.
    #[error(
        "at t = {time} s the body turns too far for one step of {step} s: the implicit equation has no physical solution"
    )]
    StepTooLong {
        /// Start of that step \[s\].
        time: f64,
        /// Its length \[s\].
        step: f64,
    },
    /// The times of the nodes do not rise.
    #[error("the step at t = {time} s has the length {step} s: it must be positive and finite")]
    Step {
        /// Start of that step \[s\].
        time: f64,
        /// Its length \[s\].
        step: f64,
    },
    /// The adaptive integrator gave up.
    #[error("at t = {time} s the continuous equations of motion could not be integrated to the tolerance")]
    Continuous {
        /// Start of that step of the plan \[s\].
        time: f64,
    },
    /// The caller asked to stop, or the time was over.
    #[error("the witnesses were stopped before they had finished")]
    Stopped,
    /// A number became NaN or infinite.
    #[error("at t = {time} s a number is no longer finite")]
    NotFinite {
        /// When \[s\].
        time: f64,
    },
}

/// Judges a plan for `problem` by all witnesses.
///
/// `tolerance` limits the scaled terminal error of the discrete witness, `continuous_tolerance` \[rad\] the attitude
/// error of the continuous one, and how far it may violate a cone. Whatever the numbers in `trajectory`, this
/// returns: what cannot be computed is NaN in a failed check, with the reason in [`Verification::failure`].
///
/// The checks, by name: `finite`, `discrete terminal`, `recorded states`, `total momentum` where wheels alone
/// turn the body, `constraints` where there are any
/// (the worst scaled violation at and between the nodes, against [`Margin::ROUND_OFF`]), `way round` where the problem
/// asks for one (1 where the path goes the other way), `inputs off or at a limit` and `shortest pulse` where there is a shortest
/// pulse (the part of it by which one is shorter), `order`
/// (`round-off` when the witnesses agree to round-off), `symplectic witness` where that one can judge,
/// `continuous terminal`, and `continuous pointing` where a tolerance is given and there are cones. Without a
/// tolerance the continuous motion may miss the end by a quarter of the angle that the body turns, or 5° where that is
/// less, and by 45° at most: beyond that the steps are too coarse to stand for a motion.
pub fn verify(
    problem: &Problem,
    trajectory: &Trajectory,
    tolerance: f64,
    continuous_tolerance: Option<f64>,
) -> Verification {
    verify_until(problem, trajectory, tolerance, continuous_tolerance, &|| false)
}

/// As [`verify`], unless `stop` says so: it is asked every few steps. What was stopped is not verified, and
/// [`Verification::was_stopped`].
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
        momentum_drift,
        goes_as_asked,
        violation,
        continuous_violation,
        comparison,
        apart_limit,
    } = judged;
    found.at_most("finite", rows::not_finite(trajectory) as f64, 0.0);
    found.at_most("discrete terminal", found.discrete().largest(), tolerance);
    if problem.switches() && !problem.seeks_duration() {
        let last = trajectory.time.last().copied().unwrap_or(f64::NAN);
        found.at_most("duration", (last / problem.duration - 1.0).abs(), RECORDED);
    }
    if let Some(longest) = problem.duration_at_most {
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
        // No pulse at all is none that is too short.
        let missing = if pulses.shortest == f64::INFINITY { 0.0 } else { 1.0 - pulses.shortest / asked };
        found.at_most("shortest pulse", missing, pulses::ROUND_OFF);
    }
    found.at_most("recorded states", recorded, RECORDED.max(10.0 * tolerance));
    if let Some(drift) = momentum_drift {
        found.at_most("total momentum", drift, RECORDED.max(10.0 * tolerance));
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
    if let Some(limit) = continuous_tolerance
        && points(problem)
    {
        found.at_most("continuous pointing", continuous_violation, limit);
    }
    found
}

/// Judges a plan of no duration: start and end must be one, and the plan be there.
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

/// Part of the angle turned by which the continuous motion may miss the end where no tolerance is given.
const MISSED: f64 = 0.25;

/// What that is at least and at most \[deg\].
const MISSED_LEAST_DEG: f64 = 5.0;
const MISSED_MOST_DEG: f64 = 45.0;

/// How far the continuous motion may miss the attitude of the end \[rad\] where no tolerance is given, if the body turns
/// by `turned` \[rad\] on its way.
fn miss_allowed(turned: f64) -> f64 {
    (MISSED * turned).clamp(MISSED_LEAST_DEG.to_radians(), MISSED_MOST_DEG.to_radians())
}

/// Scaled difference that recorded and re-propagated states may have: far above rounding, far below
/// what anyone would want to know.
const RECORDED: f64 = 1e-9;

/// What the checks need beside the numbers of a [`Verification`]; NaN and `None` where a witness failed.
struct Judged {
    /// Largest scaled difference between recorded and found states.
    recorded: f64,
    /// Drift of the total momentum in the recorded states, where wheels and nothing else turn the body.
    momentum_drift: Option<f64>,
    /// Whether the path goes round as asked, where one way is asked for.
    goes_as_asked: Option<bool>,
    /// Worst scaled violation of a limit or constraint.
    violation: f64,
    /// How far the continuous motion enters a keep-out cone or leaves a keep-in cone, at most \[rad\].
    continuous_violation: f64,
    comparison: Option<order::Comparison>,
    /// How far apart the ends of the symplectic and the continuous witness may be.
    apart_limit: f64,
}

impl Verification {
    /// Whether every check holds.
    pub fn passed(&self) -> bool {
        !self.checks.is_empty() && self.checks.iter().all(|check| check.passed)
    }

    /// Whether the witnesses were stopped before they had finished.
    pub fn was_stopped(&self) -> bool {
        self.failure.as_ref().is_some_and(|failure| *failure == WitnessError::Stopped.to_string())
    }

    /// Terminal error of the discrete witness.
    pub fn discrete(&self) -> TerminalError {
        TerminalError {
            attitude_rad: self.discrete_attitude_rad,
            momentum_relative: self.discrete_momentum_relative,
            position_relative: self.discrete_position_relative,
            linear_momentum_relative: self.discrete_linear_momentum_relative,
        }
    }

    fn unknown(motion: Motion) -> Self {
        let on_se3 = (motion == Motion::RigidBody).then_some(f64::NAN);
        Self {
            discrete_attitude_rad: f64::NAN,
            discrete_momentum_relative: f64::NAN,
            discrete_position_relative: on_se3,
            discrete_linear_momentum_relative: on_se3,
            continuous_attitude_rad: f64::NAN,
            continuous_rate_rad_s: f64::NAN,
            interpolated_attitude_rad: f64::NAN,
            interpolated_rate_rad_s: f64::NAN,
            continuous_position_m: on_se3,
            continuous_velocity_m_s: on_se3,
            peak_torque_n_m: f64::NAN,
            peak_rate_rad_s: f64::NAN,
            ..Self::default()
        }
    }

    /// A check that holds when `value ≤ limit`; NaN never does.
    fn at_most(&mut self, name: &str, value: f64, limit: f64) {
        self.checks.push(Check { name: name.into(), value, limit, passed: value <= limit });
    }

    fn ran(&mut self, witness: &str, method: impl Into<String>, steps: usize, windows: usize) {
        self.witnesses.push(Testimony { witness: witness.into(), method: method.into(), steps, windows });
    }

    /// The witnesses, two at a time; the findings of those that came to an end stay.
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
        // A motion without inputs that cannot be followed tells no way.
        judged.goes_as_asked = way::goes_as_asked(&plant, problem, trajectory, watch).unwrap_or(None);
        let isolated = plant.free && problem.actuation.wheels.is_some();
        judged.momentum_drift = isolated.then(|| rows::momentum_drift(&plant, trajectory));
        let start = Phase::of(problem, &problem.start);
        let target = Phase::of(problem, &problem.end);
        let scale = Scale::of(problem);
        let steps = problem.steps;

        // Neither half knows of the other, so that the bits are the same on one thread and on two.
        let replayed = |watch: &Watch| {
            let replayed = rows::compare(&plant, &inputs, trajectory, watch);
            (replayed, continuous_end(&plant, &start, &inputs, watch))
        };
        let held = |watch: &Watch| held_witnesses(&plant, &inputs, &start, watch);
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
        let error = scale.distance(&replayed.end, &target, problem.motion);
        self.discrete_attitude_rad = error.attitude_rad;
        self.discrete_momentum_relative = error.momentum_relative;
        self.discrete_position_relative = error.position_relative;
        self.discrete_linear_momentum_relative = error.linear_momentum_relative;

        let held = held?;
        self.ran("continuous, held torque", held.method, steps, 1);
        for (margin, continuous) in self.margins.iter_mut().zip(&held.margins) {
            margin.continuous_margin = Some(continuous.margin).filter(|margin| !margin.is_nan());
        }
        judged.continuous_violation = worst_violation(
            &held.margins.into_iter().filter(|margin| margin.unit == "deg").collect::<Vec<_>>(),
        );
        let missed = |end: &Phase| {
            let moves = |error: Vector3| plant.moves.then(|| error.norm());
            (
                scale.distance(end, &target, problem.motion).attitude_rad,
                (end.angular_velocity(problem) - problem.end.angular_velocity).norm(),
                moves(end.position - problem.end.position),
                moves(end.velocity(problem) - problem.end.velocity),
            )
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

/// Steps from which a second thread takes less time than waking it.
const WORTH_A_THREAD: usize = 400;

/// What the witnesses of the held torque find.
struct Held {
    method: &'static str,
    end: Phase,
    /// Margins of rates and cones of the continuous motion, where there are constraints.
    margins: Vec<Margin>,
    windows: Result<OnWindows, WitnessError>,
}

/// What the witnesses find on the windows.
struct OnWindows {
    /// Steps of the plan, and number of windows.
    steps: usize,
    windows: usize,
    /// Or why that witness does not judge.
    symplectic: Result<Symplectic, &'static str>,
    order: order::Comparison,
}

/// What the symplectic witness finds.
struct Symplectic {
    /// End of the last window, which is that of the plan.
    end: Phase,
    order: usize,
    apart: f64,
    limit: f64,
}

/// The continuous witness under the held torque, and those that start from where it has been.
fn held_witnesses(
    plant: &Plant,
    inputs: &Inputs,
    start: &Phase,
    watch: &Watch,
) -> Result<Held, WitnessError> {
    let Passage { end, method, margins, windows } = held_end(plant, inputs, start, watch)?;
    let stage = Stage { plant, inputs, windows: &windows, watch: *watch };
    let on_windows = || {
        let mut symplectic = Err("has not run");
        for finer in symplectic::FINER {
            let next = match symplectic::ends(plant, inputs, &windows, finer, watch)? {
                Err(why) => Err(why),
                Ok((ends, order)) => {
                    let (apart, limit) = stage.agreement(&ends)?;
                    // There is a window wherever there is a step.
                    Ok(Symplectic { end: ends[ends.len() - 1], order, apart, limit })
                }
            };
            // Too many finer steps say nothing that the coarser ones have not said.
            if next.is_err() && symplectic.is_ok() {
                break;
            }
            let agrees = next.as_ref().is_ok_and(|found: &Symplectic| found.apart <= found.limit);
            symplectic = next;
            if agrees || matches!(&symplectic, Err(why) if *why != symplectic::NO_CONVERGENCE) {
                break;
            }
        }
        let order = stage.compare()?;
        Ok(OnWindows { steps: stage.steps(), windows: windows.len(), symplectic, order })
    };
    let windows = on_windows();
    Ok(Held { method, end, margins, windows })
}

/// Whether the problem has cones.
fn points(problem: &Problem) -> bool {
    problem.constraints.iter().any(|constraint| matches!(constraint.rule, Rule::Pointing(_)))
}

/// Pieces of a step between which the continuous motion is taken for a rotation about one axis: it strays from
/// that by the square of their length, a small part of what the discrete motion strays by (`tests/it/witnesses/margins.rs`).
const PIECES: usize = 8;

/// What the continuous witness has passed.
struct Passage {
    end: Phase,
    method: &'static str,
    margins: Vec<Margin>,
    windows: Vec<Window>,
}

/// End of the continuous motion under the held torque and its method, its margins of rates and cones where there are
/// constraints, and where it was at the ends of each window.
fn held_end(plant: &Plant, inputs: &Inputs, start: &Phase, watch: &Watch) -> Result<Passage, WitnessError> {
    let problem = plant.problem;
    let mut body = Continuous::new(plant, start);
    let mut marks = Marks::new(problem, &inputs.grid, start);
    let pieces = if problem.constraints.is_empty() { 1 } else { PIECES };
    let piece = problem.step() / pieces as f64;
    let mut meter = (pieces > 1).then(|| Meter::every(piece, problem));
    if let Some(meter) = &mut meter {
        meter.rate(0.0, &problem.start.angular_velocity);
    }
    marks.pass(0, &body);
    let mut outputs = InOrder::new(inputs);
    for k in 0..problem.steps {
        watch.step(k)?;
        let held = outputs.held(k);
        let Some(meter) = &mut meter else {
            body.advance(inputs.grid.after(k), inputs.grid.step(k), &held, &held)?;
            marks.pass(k + 1, &body);
            continue;
        };
        for index in pieces * k..pieces * (k + 1) {
            let (time, before) = (index as f64 * piece, body.inertial_attitude());
            body.advance(time, piece, &held, &held)?;
            let turn = lie::minus(&body.inertial_attitude(), &before);
            meter.arc(time, &Arc { start: before, turn });
            meter.rate(time + piece, &body.phase(time + piece).angular_velocity(problem));
        }
        marks.pass(k + 1, &body);
    }
    let margins = meter.map_or_else(Vec::new, |meter| meter.margins());
    let (end, method) = (body.phase(problem.duration), body.method());
    Ok(Passage { end, method, margins, windows: marks.windows() })
}

/// End of the continuous motion under the torque that is linear between the rows of the plan.
fn continuous_end(
    plant: &Plant,
    start: &Phase,
    inputs: &Inputs,
    watch: &Watch,
) -> Result<Phase, WitnessError> {
    let problem = plant.problem;
    let mut body = Continuous::new(plant, start);
    let mut outputs = InOrder::new(inputs);
    for k in 0..problem.steps {
        watch.step(k)?;
        let (from, to) = outputs.ends(k);
        body.advance(inputs.grid.after(k), inputs.grid.step(k), &from, &to)?;
    }
    Ok(body.phase(problem.duration))
}
