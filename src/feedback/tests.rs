//! Tests of gains against reference values, against forward sensitivities, and of the order of the
//! terminal miss.

mod poses;
mod wheels;

use super::*;
use crate::Vector3;
use crate::lie;
use crate::maneuver::grid::{Grid, Scheme};
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::Trajectory;
use crate::mechanics::environment::UniformGravity;
use crate::numerics::compensated::Sum;
use crate::optimize::discrete::linear_plan::Vector6;
use crate::optimize::discrete::linear_plan::ticks::{of_posed_ticks, of_ticks};
use crate::optimize::discrete::step::{Dynamics, Point};
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::testing::{Random, matrix, planned, planned_reference};

const WHOLE: Kind = Kind::Neighbouring { freeze: 0.0 };

fn gain(gains: &Gains, step: usize) -> Matrix3x6 {
    Matrix3x6::from_row_slice(gains.row(step))
}

fn near(found: &Matrix3x6, expected: &Matrix3x6, part: f64, what: &str) {
    let apart = (found - expected).amax() / expected.amax();
    assert!(apart <= part, "{what}: {apart:e}\n{found}\n{expected}");
}

#[test]
fn gains_are_those_of_the_references() {
    for name in ["g01_diag123_100", "g02_full_nonrest", "g03_xte_si"] {
        let (file, problem, plan) = planned_reference(name);
        let linear = LinearPlan::new(&problem, &plan, Timing::AtNodes).unwrap();
        for (kind, key) in [(WHOLE, "neighbouring_extremal"), (Kind::Tvlqr(None), "tvlqr")] {
            let gains = Gains::along(&linear, kind, false).unwrap();
            let expected = file[key]["K"].as_object().unwrap();
            assert_eq!(expected.len(), 6);
            for (step, rows) in expected {
                near(
                    &gain(&gains, step.parse().unwrap()),
                    &matrix(rows),
                    1e-9,
                    &format!("{name} {key} {step}"),
                );
            }
            if let Some(first) = &gains.first {
                let first = Matrix3x6::from_row_slice(first);
                near(&first, &matrix(&file[key]["K_first"]), 1e-9, &format!("{name} first"));
            }
        }
    }
}

/// Returns `∂z_N/∂z_0` or `∂z_N/∂λ_{−1}`, computed by the forward recursion.
fn forward(plan: &LinearPlan, of_state: bool) -> Matrix6 {
    let momenta = |block: Matrix3, weight: f64| {
        let mut out = Matrix6::zeros();
        out.fixed_view_mut::<3, 3>(3, 3).copy_from(&(block * weight));
        out
    };
    let authority = |step: usize| plan.steps()[step].stage.authority;
    let (mut z, mut costate) =
        if of_state { (plan.first(), Matrix6::zeros()) } else { (Matrix6::zeros(), Matrix6::identity()) };
    z -= momenta(authority(0), plan.half_kick(0)) * costate;
    for step in plan.steps() {
        costate = step.stage.a.transpose().try_inverse().unwrap() * (costate - step.stage.h * z);
        z = step.stage.a * z - momenta(step.stage.authority, step.stage.length) * costate;
    }
    plan.last() * z + momenta(authority(plan.count() - 1), plan.half_kick(1)) * costate
}

/// The forward sweep gives `δλ_{−1} = −Ψ₁₂⁻¹ Ψ₁₁ z_0`, an independent value of the first
/// correction, which is compared by its gradient in `u_0`.
#[test]
fn the_first_correction_is_that_of_the_forward_sensitivities() {
    for name in ["g01_diag123_100", "g02_full_nonrest", "g03_xte_si"] {
        let (_, problem, plan) = planned_reference(name);
        let linear = LinearPlan::new(&problem, &plan, Timing::AtNodes).unwrap();
        let gains = Gains::along(&linear, WHOLE, false).unwrap();
        let unit = linear.units().costate::<6>();
        let costate = Vector6::from_column_slice(&plan.costates[..6]).component_div(&unit);
        let (psi_11, psi_12) = (forward(&linear, true), forward(&linear, false));
        let swept =
            BoundaryValueProblem::<6>::new(&problem, problem.steps).sweep_linearized(&costate).unwrap().1;
        let apart = (psi_12 - swept).amax() / swept.amax();
        assert!(apart < 1e-12, "{name}: {apart:e}");
        let expected = -swept.try_inverse().unwrap() * psi_11;
        let found = gains.first.as_ref().map(|first| Matrix3x6::from_row_slice(first)).unwrap();
        // For unit weights u_0 = −λ^Π, so K_first = [δλ]_Π.
        let rows = Matrix3x6::from_fn(|row, column| {
            expected[(3 + row, column)] * unit[3 + row] / linear.unit(column)
        });
        near(&found, &rows, 1e-12, name);
    }
}

/// Claim: `G_kᵀ − G_k = −S(λ^R_{k−1})` in the attitude block, with `G_k = A_kᵀP_k + H_k`. The
/// Hessian of the cost to go is symmetric except for the curvature of the rotations.
#[test]
fn the_cost_to_go_has_a_symmetric_hessian() {
    for name in ["g01_diag123_100", "g02_full_nonrest", "g03_xte_si"] {
        let (_, problem, plan) = planned_reference(name);
        let linear = LinearPlan::new(&problem, &plan, Timing::AtNodes).unwrap();
        let gains = Gains::along(&linear, WHOLE, false).unwrap();
        let unit = linear.units().costate::<6>();
        for k in 0..linear.count() - 2 {
            let step = &linear.steps()[k];
            let g = step.stage.a.transpose() * gains.to_go[k] + step.stage.h;
            let costate = Vector6::from_column_slice(&plan.costates[6 * k..6 * k + 6]).component_div(&unit);
            let mut expected = Matrix6::zeros();
            let turn = -lie::hat(&costate.fixed_rows::<3>(0).into_owned());
            expected.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
            let apart = (g.transpose() - g - expected).amax() / g.amax();
            assert!(apart < 1e-13, "{name} {k}: {apart:e}");
        }
    }
}

/// Checks held torques, also in a force field, and held over one step or three. They act in the
/// drift of their step, and the costates follow the matrices of that step.
#[test]
fn the_cost_to_go_of_held_torques_has_a_symmetric_hessian() {
    let mut random = Random(23);
    for (kind, every) in [(0, 1), (2, 1), (3, 1), (0, 3), (3, 3)] {
        let problem = maneuver(&mut random, kind);
        let mut plan = planned(&problem);
        let linear = LinearPlan::new(&problem, &plan, Timing::Held).unwrap();
        let unit = linear.units().costate::<6>();
        let mut costates = vec![Vector6::from_fn(|_, _| random.uniform())];
        for step in linear.steps().iter().rev() {
            costates.push(step.stage.a.transpose() * costates.last().unwrap());
        }
        costates.reverse();
        plan.costates =
            costates.iter().flat_map(|costate| costate.component_mul(&unit).as_slice().to_vec()).collect();
        let linear = of_ticks(&LinearPlan::new(&problem, &plan, Timing::Held).unwrap(), every);
        let gains = Gains::along(&linear, WHOLE, false).unwrap();
        for (k, costate) in costates.iter().step_by(every).enumerate().take(linear.count() - 2) {
            let step = linear.steps()[k].stage.eliminated();
            let g = step.back * gains.to_go[k] + step.curvature;
            let mut expected = Matrix6::zeros();
            let turn = -lie::hat(&costate.fixed_rows::<3>(0).into_owned());
            expected.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
            let apart = (g.transpose() - g - expected).amax() / g.amax();
            assert!(apart < 1e-12, "{kind} {every} {k}: {apart:e}");
        }
    }
}

/// Propagation of the discrete motion under corrected inputs.
struct Loop<'a> {
    problem: &'a Problem,
    plan: &'a LinearPlan,
    gains: Option<&'a Gains>,
    dynamics: Dynamics,
    grid: Grid,
}

impl<'a> Loop<'a> {
    fn new(problem: &'a Problem, plan: &'a LinearPlan, gains: Option<&'a Gains>) -> Self {
        let grid = Grid::uniform(problem.scheme, 1.0, problem.steps);
        Self { problem, plan, gains, dynamics: Dynamics::on(problem, grid.clone()), grid }
    }

    /// Returns the states before each drift and the physical terminal state, scaled, for a start
    /// that deviates by `z_0` from the plan. `planned` is the result for `z_0 = 0`.
    fn fly(&self, recorded: &Trajectory, z: &Vector6, planned: Option<&[Point]>) -> Vec<Point> {
        let units = self.plan.units();
        let set = &self.problem.actuation.torque;
        let first_row = self.problem.scheme.first_input();
        let row = |node: usize| recorded.inputs(node - first_row).to_vec();
        let torque = |inputs: &[f64]| set.output(inputs) / units.torque();
        let mut point = self.dynamics.point(&self.problem.start);
        let turn = lie::exp(&z.fixed_rows::<3>(0).into_owned());
        point.attitude = Sum::new(point.attitude.value * turn);
        point.momentum = Sum::new(point.momentum.value + z.fixed_rows::<3>(3));
        let kick = |point: &mut Point, weight: f64, inputs: &[f64]| {
            let wrench =
                crate::mechanics::environment::Wrench { force: Vector3::zeros(), moment: torque(inputs) };
            self.dynamics.bare_kick::<6>(point, weight, &wrench);
        };
        let correct = |inputs: &mut Vec<f64>, gain: &[f64], z: &Vector6| {
            for (input, row) in inputs.iter_mut().zip(gain.chunks_exact(6)) {
                let z = Vector6::from_fn(|index, _| z[index] * self.plan.unit(index));
                *input -= row.iter().zip(z.iter()).map(|(k, z)| k * z).sum::<f64>();
            }
        };
        if first_row == 0 {
            let mut inputs = row(0);
            if let Some(first) = self.gains.and_then(|gains| gains.first.as_ref()) {
                correct(&mut inputs, first, z);
            }
            kick(&mut point, self.grid.kick(0), &inputs);
        }
        let mut points = vec![point];
        let mut last = Vec::new();
        for k in 0..self.problem.steps {
            let mut inputs = row(k + 1);
            if let (Some(gains), Some(planned)) = (self.gains, planned) {
                let z = point.minus(&planned[k]).to_vector::<6>();
                correct(&mut inputs, gains.row(k), &z);
            }
            self.dynamics.drift::<6>(k, &mut point).unwrap();
            kick(&mut point, self.grid.full_kick(k + 1), &inputs);
            points.push(point);
            last = inputs;
        }
        kick(&mut point, self.grid.kick(self.problem.steps) - self.grid.full_kick(self.problem.steps), &last);
        points.push(point);
        points
    }

    /// Returns the largest component of the scaled terminal error.
    fn miss(&self, recorded: &Trajectory, z: &Vector6, planned: &[Point]) -> f64 {
        let flown = self.fly(recorded, z, Some(planned));
        let end = |points: &[Point]| *points.last().unwrap();
        end(&flown).minus(&end(planned)).to_vector::<6>().norm()
    }
}

/// Returns a random maneuver of one of five kinds: either scheme, full inertia, skewed inputs with
/// a full weight matrix, a force field, or limited torques.
pub(super) fn maneuver(random: &mut Random, kind: usize) -> Problem {
    use crate::maneuver::objective::Weights;
    use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits};
    let body = crate::testing::full_inertia();
    let body = crate::mechanics::body::Body { inertia: body, mass: None };
    let mut state = |size: f64| crate::maneuver::State {
        angular_velocity: random.vector3() * size,
        ..crate::maneuver::State::at_rest(random.rotation())
    };
    let (start, end) = (state(0.3), state(0.3));
    let problem = Problem::attitude(body, start, end, 4.0).with_steps(50);
    match kind {
        1 => problem.with_scheme(Scheme::LieEuler),
        2 => {
            let axes = Matrix3::identity() + 0.3 * Matrix3::from_fn(|_, _| random.uniform());
            let weight = Matrix3::new(1.0, 0.2, 0.0, 0.2, 2.0, 0.1, 0.0, 0.1, 0.5);
            let torque = crate::testing::channel(&axes, AxisFrame::Body);
            problem
                .with_actuation(Actuation::torques(torque))
                .with_objective(Weights::of_torques(crate::testing::weight(&weight)))
        }
        3 => problem.with_environment(
            UniformGravity::new(1.0, 0.4, -Vector3::z(), Vector3::new(0.3, 0.1, -0.6)).unwrap(),
        ),
        4 => {
            // The limits are nine tenths of the largest inputs of the unconstrained plan.
            let free = planned(&problem);
            let most = (0..free.torque.len())
                .flat_map(|row| free.inputs(row).to_vec())
                .fold(0.0, |m: f64, u| m.max(u.abs()));
            let limits = Limits { size: Some(vec![0.9 * most; 3]), ..Limits::default() };
            let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
            problem.with_actuation(Actuation::torques(torques))
        }
        _ => problem,
    }
}

/// The terminal miss of a corrected motion falls with the square of the initial deviation from the
/// plan: the slope is 2.00 ± 0.1 between 1e-2 and 1e-3.
#[test]
fn neighbouring_gains_land_to_second_order() {
    let mut random = Random(42);
    let mut slopes = Vec::new();
    for case in 0..100 {
        let problem = maneuver(&mut random, case % 5);
        let plan = planned(&problem);
        let linear = LinearPlan::new(&problem, &plan, Timing::AtNodes).unwrap();
        let gains = Gains::along(&linear, WHOLE, false).unwrap();
        let direction = Vector6::from_fn(|_, _| random.uniform()).normalize();
        let flown = Loop::new(&problem, &linear, Some(&gains));
        let planned = Loop::new(&problem, &linear, None).fly(&plan, &Vector6::zeros(), None);
        // A change of the active limits has an effect of first order over its duration, which is
        // too small to show here.
        let miss = |size: f64| flown.miss(&plan, &(direction * size), &planned);
        slopes.push(((miss(1e-2) / miss(1e-3)).log10(), case % 5, miss(1e-3)));
    }
    for (slope, kind, miss) in &slopes {
        assert!((slope - 2.0).abs() <= 0.1, "kind {kind}: slope {slope:.3}, {miss:.1e}");
    }
}

/// Gains with a wrong sign, or the gains of the next step, give an error of slope 1 instead of 2.
/// This shows that the test can fail.
#[test]
fn the_landing_law_sees_a_wrong_sign_and_a_wrong_index() {
    let mut random = Random(7);
    let problem = maneuver(&mut random, 0);
    let plan = planned(&problem);
    let linear = LinearPlan::new(&problem, &plan, Timing::AtNodes).unwrap();
    let gains = Gains::along(&linear, WHOLE, false).unwrap();
    let planned = Loop::new(&problem, &linear, None).fly(&plan, &Vector6::zeros(), None);
    let direction = Vector6::from_fn(|_, _| random.uniform()).normalize();
    let slope = |gains: &Gains| {
        let flown = Loop::new(&problem, &linear, Some(gains));
        let miss = |size: f64| flown.miss(&plan, &(direction * size), &planned);
        (miss(1e-4) / miss(1e-5)).log10()
    };
    let mut turned = gains.clone();
    turned.rows.iter_mut().skip(3).step_by(6).for_each(|value| *value = -*value);
    let mut shifted = gains.clone();
    shifted.rows.rotate_left(18);
    for wrong in [turned, shifted] {
        let slope = slope(&wrong);
        assert!((slope - 1.0).abs() < 0.1, "{slope}");
    }
}

/// The held model is the derivative of the true motion to the order of the scheme: with half the
/// step the difference is a quarter.
#[test]
fn the_held_model_is_the_derivative_of_the_true_motion() {
    use crate::flight::Flight;
    let mut random = Random(3);
    for kind in [0, 2, 3] {
        let problem = maneuver(&mut random, kind);
        let apart = |steps: usize| {
            let problem = problem.clone().with_steps(steps);
            let plan = planned(&problem);
            let recorded = Flight::recorded(&problem, &plan).unwrap();
            let linear = LinearPlan::new(&problem, &recorded, Timing::Held).unwrap();
            let product =
                linear.steps().iter().fold(Matrix6::identity(), |product, step| step.stage.a * product);
            let held = Flight::of_plan(&problem, &recorded);
            let end = |z: &Vector6| {
                let mut start = problem.start;
                start.attitude *= lie::exp(&z.fixed_rows::<3>(0).into_owned());
                let momentum = z.fixed_rows::<3>(3) * linear.units().momentum();
                start.angular_velocity += problem.body.inertia.j_inverse() * momentum;
                let moved = Problem { start, ..problem.clone() };
                let mut flight = Flight::new(&moved);
                flight.settle(&held);
                flight.fly(&held, None).unwrap()
            };
            let mut worst: f64 = 0.0;
            for column in 0..6 {
                let size = 1e-5;
                let mut z = Vector6::zeros();
                z[column] = size;
                let (plus, minus) = (end(&z), end(&-z));
                let turn = lie::minus(&plus.attitude, &recorded_end(&recorded))
                    - lie::minus(&minus.attitude, &recorded_end(&recorded));
                let rate = problem.body.inertia.j() * (plus.angular_velocity - minus.angular_velocity)
                    / linear.units().momentum();
                let found = Vector6::new(turn.x, turn.y, turn.z, rate.x, rate.y, rate.z) / (2.0 * size);
                worst = worst.max((found - product.column(column)).amax());
            }
            worst
        };
        let (coarse, fine) = (apart(40), apart(80));
        let order = (coarse / fine).log2();
        assert!((1.7..2.5).contains(&order) && fine < 2e-2, "kind {kind}: {coarse:e}, {fine:e}");
    }
}

/// The mean torque of the first step differs between plans from neighbouring starts. The gains of
/// this step for the true motion equal this difference to second order in the step, in a force
/// field and for torques in axes that rotate relative to the body. Costates taken half a kick
/// beyond the nodes would leave an error of first order.
#[test]
fn gains_in_fields_are_of_second_order() {
    use crate::flight::Flight;
    use crate::mechanics::actuators::AxisFrame;
    use crate::optimize::discrete::linear_plan::PosedPlan;
    use crate::testing::{attitude_only, moving_ends};
    let mut random = Random(19);
    let in_field = maneuver(&mut random, 3);
    let turning =
        attitude_only(moving_ends(&mut random, AxisFrame::Reference)).with_scheme(Scheme::LieVerlet);
    for (problem, posed) in [(in_field, false), (turning, true)] {
        let apart = |steps: usize| {
            let problem = problem.clone().with_steps(steps);
            let plan = planned(&problem);
            let recorded = Flight::recorded(&problem, &plan).unwrap();
            let first = |gains: Gains| Matrix3x6::from_row_slice(gains.row(0));
            let [right, beyond] = if posed {
                [PosedPlan::flown(&problem, &plan), PosedPlan::new(&problem, &recorded)]
                    .map(|linear| first(Gains::along_pose(&linear.unwrap(), WHOLE, false).unwrap()))
            } else {
                [LinearPlan::flown(&problem, &plan), LinearPlan::new(&problem, &recorded, Timing::Held)]
                    .map(|linear| first(Gains::along(&linear.unwrap(), WHOLE, false).unwrap()))
            };
            let mean = |z: &Vector6| {
                let mut start = problem.start;
                start.attitude = lie::project_to_rotation(
                    &(start.attitude * lie::exp(&z.fixed_rows::<3>(0).into_owned())),
                );
                start.angular_velocity += problem.body.inertia.j_inverse() * z.fixed_rows::<3>(3);
                let plan = planned(&Problem { start, ..problem.clone() });
                let row = |index: usize| Vector3::from_column_slice(plan.inputs(index));
                0.5 * (row(0) + row(1))
            };
            let mut expected = Matrix3x6::zeros();
            for column in 0..6 {
                let mut z = Vector6::zeros();
                z[column] = 1e-4;
                expected.set_column(column, &((mean(&-z) - mean(&z)) / 2e-4));
            }
            [right, beyond].map(|found| (found - expected).amax() / expected.amax())
        };
        let [coarse, middle, fine] = [60, 120, 240].map(apart);
        println!("{coarse:?} {middle:?} {fine:?} of the largest gain");
        let order = |which: usize| {
            [(coarse, middle), (middle, fine)].map(|(long, short)| (long[which] / short[which]).log2())
        };
        assert!(order(0).iter().all(|order| (1.8..2.3).contains(order)), "{:?}", order(0));
        assert!(order(1).iter().all(|order| (0.8..1.5).contains(order)), "{:?}", order(1));
    }
}

fn recorded_end(plan: &Trajectory) -> Matrix3 {
    lie::rotation_from_quaternion(plan.quaternion.last().unwrap())
}

#[test]
fn what_cannot_be_corrected_is_said() {
    use crate::maneuver::objective::Objective;
    let mut random = Random(5);
    let problem = maneuver(&mut random, 0);
    let plan = planned(&problem);
    let linear = LinearPlan::new(&problem, &plan, Timing::Held).unwrap();
    assert_eq!(Gains::along(&linear, WHOLE, true), Err(NoGains::Switching));
    let translating = Problem { motion: crate::maneuver::problem::Motion::RigidBody, ..problem.clone() };
    let refused = |problem: &Problem, plan: &Trajectory| {
        LinearPlan::new(problem, plan, Timing::AtNodes).map(|_| ()).unwrap_err()
    };
    use crate::optimize::discrete::linear_plan::Unlinearised;
    assert_eq!(refused(&translating, &plan), Unlinearised::Translation);
    assert_eq!(refused(&problem, &Trajectory::default()), Unlinearised::Trajectory);
    let fuel = Problem { objective: Objective::Fuel(Default::default()), ..problem.clone() };
    assert_eq!(refused(&fuel, &plan), Unlinearised::Switching);
    // A torque about one axis only cannot bring the body back.
    let mut weak = problem.clone();
    weak.actuation = crate::mechanics::actuators::Actuation::torques(
        crate::mechanics::actuators::ActuatorSet::new(
            vec![Vector3::x()],
            crate::mechanics::actuators::AxisFrame::Body,
        )
        .unwrap(),
    );
    let mut along = plan.clone();
    along.input = along.input.chunks(3).map(|row| row[0]).collect();
    along.input_count = 1;
    let linear = LinearPlan::new(&weak, &along, Timing::Held).unwrap();
    let found = Gains::along(&linear, WHOLE, false);
    assert!(found.is_ok() || matches!(found, Err(NoGains::Unreachable)), "{found:?}");
}
