//! Estimate of the memory of a solve, before it begins.
//!
//! A plan holds the states, costates and inputs of all its nodes at once, and the witnesses need as
//! much again. The interior-point method also holds its workspace, which is proportional to the
//! square of the number of unknowns of a stage. SCP holds its cone program with the factors.
//!
//! # How does a plan know what memory it takes?
//!
//! For the interior-point method, by counting what its parts allocate for a step; for all else, by
//! a measured rule: a number of bytes per step, for each unknown and each row of a limit.
//! `slew check` reports two figures if the interior-point method may follow shooting. If even the
//! smaller figure exceeds the available memory (free memory, its group, `ulimit -v`), the plan is
//! refused with exit code 6 and the number of steps that would fit; if only the larger one does, a
//! warning is printed. `cargo run --release -p evidence -- memory` compares both with measurements
//! of plans. An allocation that nevertheless fails also ends with exit code 6: the standard library
//! aborts, and the handler of that signal exits with this code. The words of the message are the
//! library's ("memory allocation of … bytes failed"), because there is no unsafe code. Where a
//! system promises more memory than it has, its out-of-memory killer acts first; the estimate
//! serves for this case.

use crate::maneuver::objective::Fuel;
use crate::maneuver::problem::{Formulation, Problem};
use crate::maneuver::settings::{Method, Settings};
use crate::maneuver::{Motion, Rule};
use crate::mechanics::actuators::{ActuatorSet, LimitKind};
use crate::optimize::chain::rows::LimitRow;
use crate::optimize::discrete::control_law;

/// Memory of the program itself, its threads and small grids \[bytes\].
const BASE: f64 = 12e6;
/// Memory of the program for a search by the interior-point method or SCP, with coarse grids
/// \[bytes\].
const CHAIN_BASE: f64 = 17e6;
/// Memory of a plan per step, for attitude alone \[bytes\].
const NODE: f64 = 200.0;
/// Memory of a plan per step, for attitude and position \[bytes\].
const NODE_WITH_POSITION: f64 = 650.0;
/// Memory of the cone program and its factors per step \[bytes\]: for each unknown of a stage, and
/// for each row of a limit.
const CONVEX: [f64; 2] = [2500.0, 1500.0];

/// Memory of a floating-point number \[bytes\].
const NUMBER: f64 = 8.0;
/// Numbers that the interior-point method holds for each unknown of a stage: points, multipliers,
/// residuals, steps, and the best of each.
const OF_UNKNOWN: f64 = 18.0;
/// Numbers that the interior-point method holds for each row: multipliers, residuals, slacks,
/// steps, and the best of each.
const OF_ROW: f64 = 28.0;
/// Numbers that the plan and its landing hold, for each stage and for each row.
const OF_PLAN: [f64; 2] = [360.0, 20.0];
/// Numbers that each stage holds regardless of its size: the attitude, three times, and the
/// allocations of a step.
const OF_STAGE: f64 = 80.0;

/// Estimated peak memory of a plan \[bytes\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakMemory {
    /// Memory that the plan takes in most cases \[bytes\].
    pub likely: f64,
    /// Memory that the plan may take if shooting alone does not find it \[bytes\].
    pub most: f64,
}

impl PeakMemory {
    /// Estimates the peak memory of planning and verifying a maneuver.
    pub fn of(problem: &Problem, settings: &Settings) -> Self {
        let steps = problem.steps as f64;
        let moves = problem.motion == Motion::RigidBody;
        let nodes = steps * if moves { NODE_WITH_POSITION } else { NODE };
        let plain = BASE + nodes;
        let formulation = Formulation::of(&problem.clone().planned_by(settings.method));
        let shooting = formulation != Formulation::Chain
            && !settings.method.is_on_equal_steps()
            && control_law::obstacle(problem).is_none();
        let rescued = settings.method == Method::Auto && problem.is_constrained();
        if formulation == Formulation::Switching || shooting && !rescued {
            return Self { likely: plain, most: plain };
        }
        if settings.method == Method::Scp {
            let unknowns = state(problem) + problem.actuation.count() as f64;
            let rows = limits(problem) + constraints(problem);
            let likely = CHAIN_BASE + nodes + steps * (CONVEX[0] * unknowns + CONVEX[1] * rows);
            return Self { likely, most: likely };
        }
        let chain = CHAIN_BASE + nodes + steps * of_interior_point(problem, formulation);
        Self { likely: if shooting { plain } else { chain }, most: chain }
    }

    /// Returns the largest number of steps whose plan likely fits into `room` \[bytes\], rounded to
    /// two digits; `None` if not even the smallest number of steps fits.
    pub fn steps_within(problem: &Problem, settings: &Settings, room: f64) -> Option<usize> {
        let base = Self::of(&Problem { steps: 0, ..problem.clone() }, settings).likely;
        let per_step = (Self::of(problem, settings).likely - base) / problem.steps as f64;
        let steps = ((room - base) / per_step).floor();
        if steps < Problem::MIN_STEPS as f64 {
            return None;
        }
        let unit = 10_usize.pow((steps.log10() as u32).saturating_sub(1));
        Some(steps as usize / unit * unit)
    }
}

/// Returns the memory that the interior-point method allocates for a step \[bytes\]: the plan, the
/// chain with its rows, and the workspace. For minimum time or fuel the optimum on half of the
/// steps is also computed.
fn of_interior_point(problem: &Problem, formulation: Formulation) -> f64 {
    let (inputs, given) = (problem.actuation.count() as f64, state(problem));
    let changes = problem.actuation.limits().any(|limit| limit.kind == LimitKind::Rate);
    let sought = formulation == Formulation::Chain && problem.objective.counts_time();
    let n = given + f64::from(sought) + if changes { inputs } else { 0.0 };
    let m = inputs + burning(problem).map(lanes).sum::<usize>() as f64;
    let (z, ends) = (n + m, if problem.motion == Motion::RigidBody { 12.0 } else { 8.0 });
    let (limits, constraints) = (limits(problem), constraints(problem));
    let rows = limits + constraints;
    // Memory for two Hessians and a step, for the matrices P, W and U, and for vectors.
    let solver = NUMBER * (2.0 * z * z + n * z + (n + m) * (n + ends) + m * m + OF_UNKNOWN * z + OF_STAGE)
        // Derivatives of rows with their indices: a limit depends on few unknowns, a constraint on
        // all.
        + NUMBER * OF_ROW * rows + (NUMBER + 2.0) * (3.0 * limits + z * constraints);
    let [of_stage, of_row] = OF_PLAN;
    let plan = NUMBER * (given + 3.0 * inputs + OF_STAGE + of_stage + of_row * rows);
    let solvers = if problem.objective.switches() { 1.5 * solver } else { solver };
    plan + size_of::<LimitRow>() as f64 * rows + solvers
}

/// Returns the number of components of a state, for a fixed duration.
fn state(problem: &Problem) -> f64 {
    let wheels = problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len());
    if problem.motion == Motion::RigidBody { 12.0 } else { 6.0 + wheels as f64 }
}

/// Returns the number of rows of the actuator limits at one step.
fn limits(problem: &Problem) -> f64 {
    let of_limits = problem.actuation.limits().map(|limit| match limit.kind {
        LimitKind::Norm => 1,
        _ => 2 * limit.bounds.iter().filter(|bound| bound.is_finite()).count(),
    });
    // Fuel-burning inputs have a lower bound of zero in each direction.
    let of_fuel = burning(problem).map(|set| set.count() + lanes(set));
    of_limits.chain(of_fuel).sum::<usize>() as f64
}

/// Returns the number of rows of the constraints of one step, at the node and on the arc.
fn constraints(problem: &Problem) -> f64 {
    let of_constraints = problem.constraints.iter().map(|constraint| match &constraint.rule {
        Rule::RateNorm(_) => 2,
        Rule::RateAxes(_) => 12,
        Rule::Pointing(pointing) => 2 * pointing.pairs().count(),
    });
    of_constraints.sum::<usize>() as f64
}

/// Returns the actuator sets whose fuel is counted.
fn burning(problem: &Problem) -> impl Iterator<Item = &ActuatorSet> {
    let torque = Some(&problem.actuation.torque).filter(|_| problem.actuation.thrusters.is_none());
    let burning = [torque, problem.actuation.force.as_ref()];
    burning.into_iter().flatten().filter(|_| problem.objective.fuel().is_some())
}

/// Returns the number of inputs that the interior-point method adds to a set whose fuel is counted:
/// its norm, or the opposite direction of each input.
fn lanes(set: &ActuatorSet) -> usize {
    if Fuel::is_of_norm(set) {
        1
    } else if set.limits().one_sided {
        0
    } else {
        set.count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maneuver::constraint::{Constraint, Direction, Pointing, Side};
    use crate::maneuver::objective::Objective;
    use crate::mechanics::actuators::{Actuation, AxisFrame, Limits, Wheels};
    use crate::testing::{Random, attitude_only, moving_ends};
    use crate::{Duration, Vector3};

    #[test]
    fn the_steps_that_are_said_to_fit_do_and_not_many_more_would() {
        let problem = attitude_only(moving_ends(&mut Random(1), AxisFrame::Body));
        let settings = Settings::default();
        let of = |steps: f64| PeakMemory::of(&problem.clone().with_steps(steps as usize), &settings).likely;
        for room in [2e7, 1e8, 4.5e9] {
            let steps = PeakMemory::steps_within(&problem, &settings, room).unwrap() as f64;
            assert!(of(steps) <= room && of(1.11 * steps) > room, "{steps} steps in {room} bytes");
        }
        assert_eq!(PeakMemory::steps_within(&problem, &settings, BASE), None);
    }

    /// Measured: peak resident memory of the program on Linux, as the growth from 2,000 to 6,000
    /// steps of the named plans of `problems/`, divided by the number of added steps.
    #[test]
    fn the_interior_point_is_said_to_take_what_it_takes() {
        let plain = || attitude_only(moving_ends(&mut Random(1), AxisFrame::Body));
        let ruled = |rule: Rule| plain().with_constraint(Constraint { name: "limit".into(), rule });
        let torques = |limits: Limits| {
            let set = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
            plain().with_actuation(Actuation::torques(set)).with_objective(Objective::default())
        };
        let sized = |count: usize| Limits { size: Some(vec![1.0; count]), ..Limits::default() };
        let wheeled = |count: usize| {
            let axes = (0..count).map(|index| Vector3::new(1.0, index as f64, 1.0).normalize()).collect();
            let set = ActuatorSet::new(axes, AxisFrame::Body).unwrap().with_limits(sized(count)).unwrap();
            let mut actuation = Actuation::torques(set);
            actuation.wheels = Some(Wheels { momentum: vec![0.0; count], momentum_limit: vec![1.0; count] });
            plain().with_actuation(actuation).with_objective(Objective::default())
        };
        let cone =
            Pointing::new(Side::KeepOut, vec![Vector3::x()], vec![Direction::Fixed(Vector3::z())], 0.2);
        let fastest =
            |problem: Problem| problem.with_objective(Objective::Time).with_duration(Duration::SOUGHT);
        let rate = Constraint { name: "rate".into(), rule: Rule::RateNorm(1.0) };
        let rates = Limits { rate: Some(vec![1.0; 3]), ..sized(3) };
        let cases = [
            ("limited_rate", ruled(Rule::RateNorm(1.0)), 9_160.0),
            ("limited_rate_axes", ruled(Rule::RateAxes(Vector3::repeat(1.0))), 15_251.0),
            ("limited_torque_rate", torques(rates), 17_064.0),
            ("keep_out_small", ruled(Rule::Pointing(cone)), 9_403.0),
            ("wheels_pyramid", wheeled(4), 21_589.0),
            ("shortest_rate", fastest(torques(sized(3)).with_constraint(rate)), 16_223.0),
            ("minimum_fuel_wheels", wheeled(3).with_objective(Objective::Fuel(Fuel::default())), 24_919.0),
        ];
        for (name, problem, measured) in cases {
            let of = |steps: usize| PeakMemory::of(&problem.clone().with_steps(steps), &Settings::default());
            let [from, to] = [2_000, 6_000].map(of);
            assert_eq!(from.likely, from.most, "{name}");
            let said = (to.likely - from.likely) / 4_000.0;
            assert!((1.0..1.5).contains(&(said / measured)), "{name}: {said:.0} of {measured:.0}");
        }
        // A cone program takes several times as much; measured from 500 to 2,000 steps.
        let settings = Settings { method: Method::Scp, ..Settings::default() };
        for (problem, measured) in [(ruled(Rule::RateNorm(1.0)), 23_342.0), (wheeled(4), 55_342.0)] {
            let of = |steps: usize| PeakMemory::of(&problem.clone().with_steps(steps), &settings).most;
            let said = (of(2_000) - of(500)) / 1_500.0;
            assert!((1.0..1.5).contains(&(said / measured)), "SCP: {said:.0} of {measured:.0}");
        }
    }
}
