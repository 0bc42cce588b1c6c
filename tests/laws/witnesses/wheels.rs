//! The witnesses with reaction wheels: closed forms, the discrete Lagrangian, conservation,
//! convergence.

use crate::evidence::Random;
use slewkit::maneuver::problem::{Problem, Scheme, State};
use slewkit::maneuver::solution::Trajectory;
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::{Blocks, Environment, Pose, Wrench};
use slewkit::propagate::simulate::SimulationRow;
use slewkit::verify::propagation::{Propagation, Propagator, propagate};
use slewkit::verify::{Verification, margins, replay, verify};
use slewkit::{Matrix3, Vector3, lie};
use std::ops::ControlFlow;

const SCHEMES: [Scheme; 2] = [Scheme::LieEuler, Scheme::LieVerlet];

fn full_inertia() -> Matrix3 {
    Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)
}

/// Returns a pyramid of four wheels with these momenta at the start.
fn pyramid(momentum: [f64; 4]) -> Actuation {
    let (c, s) = (35.0_f64.to_radians().cos(), 35.0_f64.to_radians().sin());
    let axes =
        [[c, 0.0, s], [0.0, c, s], [-c, 0.0, s], [0.0, -c, s]].map(|axis| Vector3::from_row_slice(&axis));
    let torque = ActuatorSet::new(axes.to_vec(), AxisFrame::Body).unwrap();
    let wheels = Wheels { momentum: momentum.to_vec(), momentum_limit: vec![f64::INFINITY; 4] };
    Actuation { wheels: Some(wheels), ..Actuation::torques(torque) }
}

fn problem(j: Matrix3, rate: Vector3, actuation: Actuation) -> Problem {
    let body = Body { inertia: Inertia::new(j).unwrap(), mass: None };
    let start = State::attitude(lie::exp(&Vector3::new(0.4, -0.3, 0.5)), rate);
    Problem::attitude(body, start, State::at_rest(Matrix3::identity()), 2.0)
        .with_actuation(actuation)
        .with_steps(40)
}

/// Returns a tumbling body whose wheels store several times its own momentum.
fn tumbling(scheme: Scheme) -> Problem {
    let actuation = pyramid([2.0, -1.0, 4.0, 3.0]);
    problem(full_inertia(), Vector3::new(0.3, -0.4, 0.6), actuation).with_scheme(scheme)
}

fn smooth_inputs(problem: &Problem) -> Vec<f64> {
    let rows = problem.scheme.input_rows(problem.steps);
    let count = problem.actuation.count();
    let input = |row: usize, i: usize| {
        let t = (row + problem.steps + 1 - rows) as f64 / problem.steps as f64;
        (1.0 + i as f64 + 3.0 * t).sin() * (2.0 - i as f64 * t)
    };
    (0..rows).flat_map(|row| (0..count).map(move |i| input(row, i))).collect()
}

/// Returns the same maneuver aimed at where its inputs lead, and the plan that leads there.
fn aimed(mut problem: Problem, inputs: &[f64]) -> (Problem, Trajectory) {
    let plan = replay(&problem, inputs).unwrap();
    let attitude = lie::rotation_from_quaternion(plan.quaternion.last().unwrap());
    problem.end = State::attitude(attitude, *plan.angular_velocity.last().unwrap());
    (problem, plan)
}

fn final_row(problem: &Problem, propagator: Propagator, steps: u64, inputs: Option<&[f64]>) -> SimulationRow {
    let mut last = None;
    let settings = Propagation { propagator, steps, stride: u64::MAX, inputs };
    propagate(problem, &settings, &mut |row: &SimulationRow| {
        last = Some(row.clone());
        ControlFlow::Continue(())
    })
    .unwrap();
    last.unwrap()
}

fn attitude_error(row: &SimulationRow, expected: &Matrix3) -> f64 {
    lie::log(&(expected.transpose() * lie::rotation_from_quaternion(&row.bodies[0].quaternion))).norm()
}

fn check(found: &Verification, name: &str) -> bool {
    let check = found.checks.iter().find(|check| check.name == name);
    check.unwrap_or_else(|| panic!("no check {name}: {found:#?}")).passed
}

/// Returns `B h` of a node.
fn stored(problem: &Problem, plan: &Trajectory, node: usize) -> Vector3 {
    let count = problem.actuation.count();
    problem.actuation.torque.output(&plan.wheel_momentum[node * count..(node + 1) * count])
}

fn attitude(plan: &Trajectory, node: usize) -> Matrix3 {
    lie::rotation_from_quaternion(&plan.quaternion[node])
}

// ---- the discrete equations
// -------------------------------------------------------------------------

/// The momenta at both ends of a step are the derivatives of the discrete Lagrangian
/// `L_d = (1/h) tr[(I − F) J_d] + 2 c·μ`, `F = cay(c)`: differences of L_d alone, no formula of
/// ours.
#[test]
fn momenta_are_the_derivatives_of_the_discrete_lagrangian() {
    let j = full_inertia();
    let j_d = 0.5 * j.trace() * Matrix3::identity() - j;
    let problem = tumbling(Scheme::LieEuler);
    let h = problem.step();
    let plan = replay(&problem, &smooth_inputs(&problem)).unwrap();
    let lagrangian = |from: &Matrix3, to: &Matrix3, mu: &Vector3| {
        let f = from.transpose() * to;
        ((Matrix3::identity() - f) * j_d).trace() / h + 2.0 * lie::cayley_inverse(&f).dot(mu)
    };
    // Fourth-order central differences along R exp(ε S(e)).
    let derivative = |value: &dyn Fn(&Matrix3) -> f64| {
        Vector3::from_fn(|axis, _| {
            let mut direction = Vector3::zeros();
            direction[axis] = 1e-3;
            let at = |part: f64| value(&lie::exp(&(part * direction)));
            (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / 12e-3
        })
    };
    for k in 0..problem.steps {
        let (from, to) = (attitude(&plan, k), attitude(&plan, k + 1));
        let mu = stored(&problem, &plan, k);
        let left = -derivative(&|turn| lagrangian(&(from * turn), &to, &mu));
        let total = j * plan.angular_velocity[k] + mu;
        assert!((left - total).norm() < 1e-9, "{k}: {left} {total}");
        // The momentum that arrives at the next node leaves it: the kick of the wheels does not
        // change the total.
        let right = derivative(&|turn| lagrangian(&from, &(to * turn), &mu));
        let total = j * plan.angular_velocity[k + 1] + stored(&problem, &plan, k + 1);
        assert!((right - total).norm() < 1e-9, "{k}: {right} {total}");
    }
}

/// Lie–Verlet is Lie–Euler between half kicks: the torque `a_i u_i` for the body, `−u_i` for the
/// wheel.
#[test]
fn verlet_is_euler_conjugated_by_half_kicks() {
    let verlet = tumbling(Scheme::LieVerlet);
    let h = verlet.step();
    let inputs = smooth_inputs(&verlet);
    let plan = replay(&verlet, &inputs).unwrap();
    let mut euler = verlet.clone().with_scheme(Scheme::LieEuler);
    let first = Vector3::from(verlet.actuation.torque.output(&inputs[..4]));
    euler.start.angular_velocity += 0.5 * h * (euler.body.inertia.j_inverse() * first);
    for (momentum, input) in euler.actuation.wheels.as_mut().unwrap().momentum.iter_mut().zip(&inputs) {
        *momentum -= 0.5 * h * input;
    }
    let conjugate = replay(&euler, &inputs[4..]).unwrap();
    for k in 1..=verlet.steps {
        assert!((attitude(&plan, k) - attitude(&conjugate, k)).amax() < 1e-14);
        let kick = verlet.actuation.torque.output(&inputs[4 * k..4 * k + 4]);
        let momentum = full_inertia() * conjugate.angular_velocity[k] - 0.5 * h * kick;
        assert!((full_inertia() * plan.angular_velocity[k] - momentum).norm() < 1e-13);
        for wheel in 0..4 {
            let (a, b) = (plan.wheel_momentum[4 * k + wheel], conjugate.wheel_momentum[4 * k + wheel]);
            assert!((a - b - 0.5 * h * inputs[4 * k + wheel]).abs() < 1e-13);
        }
    }
}

#[test]
fn total_momentum_in_space_is_conserved_to_round_off() {
    for scheme in SCHEMES {
        let problem = tumbling(scheme).with_steps(400);
        let plan = replay(&problem, &smooth_inputs(&problem)).unwrap();
        let total = |node: usize| {
            attitude(&plan, node)
                * (full_inertia() * plan.angular_velocity[node] + stored(&problem, &plan, node))
        };
        let first = total(0);
        let drift = (0..=problem.steps).map(|node| (total(node) - first).norm()).fold(0.0, f64::max);
        assert!(drift < 2e-14 * first.norm(), "{scheme:?}: {drift:e}");
    }
    for propagator in [Propagator::LieVerlet, Propagator::Verner98] {
        let problem = tumbling(Scheme::LieVerlet);
        let inputs = [0.5, -0.8, 0.3, 1.1];
        let first = final_row(&problem, propagator, 1, None).invariants.angular_momentum;
        let row = final_row(&problem, propagator, 100_000, Some(&inputs));
        assert!(
            (row.invariants.angular_momentum - first).norm() < 1e-13,
            "{propagator:?}: {}",
            row.invariants.angular_momentum - first
        );
        let spent = 2.0 * problem.actuation.torque.output(&inputs);
        let expected = problem.actuation.stored_momentum() - spent;
        assert!((row.bodies[0].stored_momentum - expected).norm() < 1e-13, "{propagator:?}");
    }
}

/// Wheels at rest that are not driven change no bit of the motion.
#[test]
fn wheels_at_rest_change_nothing() {
    for scheme in SCHEMES {
        let with =
            problem(full_inertia(), Vector3::new(0.3, -0.4, 0.6), pyramid([0.0; 4])).with_scheme(scheme);
        let mut without = with.clone();
        without.actuation.wheels = None;
        let zero = vec![0.0; 4 * scheme.input_rows(40)];
        let (a, b) = (replay(&with, &zero).unwrap(), replay(&without, &zero).unwrap());
        assert_eq!((&a.quaternion, &a.angular_velocity), (&b.quaternion, &b.angular_velocity));
        assert_eq!(a.wheel_momentum, vec![0.0; 4 * 41]);
        assert!(b.wheel_momentum.is_empty());
    }
    for propagator in [Propagator::LieVerlet, Propagator::Verner98] {
        let with = problem(full_inertia(), Vector3::new(0.3, -0.4, 0.6), pyramid([0.0; 4]));
        let mut without = with.clone();
        without.actuation.wheels = None;
        assert_eq!(final_row(&with, propagator, 30, None), final_row(&without, propagator, 30, None));
    }
}

/// In a turn about one principal axis from rest, the stored momentum has no gyroscopic effect:
/// wheels act like plain torques.
#[test]
fn one_axis_from_rest_is_the_plain_body() {
    let j = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.5));
    let mut with = problem(j, Vector3::zeros(), pyramid([0.0; 4]));
    let torque = ActuatorSet::new(vec![Vector3::y()], AxisFrame::Body).unwrap();
    let wheels = Wheels { momentum: vec![0.0], momentum_limit: vec![10.0] };
    with.actuation = Actuation { wheels: Some(wheels), ..Actuation::torques(torque) };
    let row = final_row(&with, Propagator::Verner98, 10, Some(&[0.8]));
    let expected = with.start.attitude * lie::exp(&Vector3::new(0.0, 0.5 * (0.8 / 2.0) * 4.0, 0.0));
    assert!(attitude_error(&row, &expected) < 1e-14);
    assert!((row.bodies[0].stored_momentum - Vector3::new(0.0, -1.6, 0.0)).norm() < 1e-14);
}

// ---- the continuous equations
// -----------------------------------------------------------------------

/// A sphere with momentum μ in its wheels: `jΩ̇ = μ × Ω`, so Ω turns about μ at |μ|/j, in body
/// axes, and `R(t) = exp(t S(H/j)) R₀ exp(−t S(μ/j))` with the total momentum H, inertial axes.
#[test]
fn continuous_spherical_gyrostat_is_exact() {
    let (size, rate, t) = (1.7, Vector3::new(0.5, -0.7, 0.4), 2.0);
    let problem = problem(size * Matrix3::identity(), rate, pyramid([2.0, -1.0, 4.0, 3.0]));
    let mu = problem.actuation.stored_momentum();
    let total = problem.start.attitude * (size * rate + mu);
    let expected = lie::exp(&(t / size * total)) * problem.start.attitude * lie::exp(&(-t / size * mu));
    for steps in [1, 10, 1000] {
        let row = final_row(&problem, Propagator::Verner98, steps, None);
        assert!(attitude_error(&row, &expected) < 1e-13, "{steps}: {:e}", attitude_error(&row, &expected));
        let turned = lie::exp(&(t / size * mu)) * rate;
        assert!((row.bodies[0].angular_velocity - turned).norm() < 1e-13);
    }
    // The discrete witness converges to the same end at second order.
    let errors = [100, 200, 400]
        .map(|steps| attitude_error(&final_row(&problem, Propagator::LieVerlet, steps, None), &expected));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.1, "{errors:?}");
    }
}

/// If wheels keep their spin, the kinetic energy of the body is conserved too.
#[test]
fn gyrostat_left_alone_conserves_energy() {
    let problem = tumbling(Scheme::LieVerlet);
    let first = 0.5 * problem.start.angular_velocity.dot(&(full_inertia() * problem.start.angular_velocity));
    let row = final_row(&problem, Propagator::Verner98, 100, None);
    assert!((row.invariants.energy - first).abs() < 1e-13, "{:e}", row.invariants.energy - first);
    let row = final_row(&problem, Propagator::LieVerlet, 1000, None);
    assert!((row.invariants.energy - first).abs() < 1e-3 && (row.invariants.energy - first).abs() > 1e-12);
}

// ---- the two together
// -------------------------------------------------------------------------------

/// A pendulum in a turning frame, which combines wheels, field and frame.
#[derive(Clone, Debug)]
struct Swinging(Vector3);

impl Environment for Swinging {
    fn potential(&self, pose: &Pose) -> f64 {
        -Vector3::new(0.2, -0.3, 1.5).dot(&(pose.attitude.transpose() * Vector3::z()))
    }
    fn wrench(&self, pose: &Pose) -> Wrench {
        let moment = Vector3::new(0.2, -0.3, 1.5).cross(&(pose.attitude.transpose() * Vector3::z()));
        Wrench { force: Vector3::zeros(), moment }
    }
    fn gradient(&self, _: &Pose) -> Blocks {
        unreachable!("the witnesses use no derivative")
    }
    fn curvature(&self, _: &Pose, _: &Wrench) -> Blocks {
        unreachable!("the witnesses use no derivative")
    }
    fn frame_rate(&self) -> Vector3 {
        self.0
    }
}

#[test]
fn driven_wheels_converge_at_the_order_of_the_scheme() {
    for scheme in SCHEMES {
        let free = tumbling(scheme);
        let swinging = free.clone().with_environment(Swinging(Vector3::zeros()));
        let turning = free.clone().with_environment(Swinging(Vector3::new(0.1, 0.5, -0.2)));
        for (name, problem) in [("free", free), ("swinging", swinging), ("turning", turning)] {
            let (problem, plan) =
                aimed(problem.clone().with_steps(100), &smooth_inputs(&problem.with_steps(100)));
            let found = verify(&problem, &plan, 1e-12, None);
            assert!(found.passed(), "{name} {scheme:?}: {found:#?}");
            let (order, expected) = (found.order.unwrap(), f64::from(scheme.order()));
            assert!((order - expected).abs() < 0.15, "{name} {scheme:?}: order {order}");
            let conserved = found.checks.iter().any(|check| check.name == "total momentum");
            assert_eq!(conserved, name == "free", "{name}");
        }
    }
}

/// The end of the continuous motion under the torques of a plan converges at second order as the
/// plan's step is halved.
#[test]
fn continuous_terminal_error_falls_at_second_order() {
    let found = [160, 320].map(|steps| {
        let problem = tumbling(Scheme::LieVerlet).with_steps(steps);
        let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
        verify(&problem, &plan, 1e-12, None)
    });
    let [a, b] = &found;
    let held = (a.continuous_attitude_rad / b.continuous_attitude_rad).log2();
    let linear = (a.interpolated_attitude_rad / b.interpolated_attitude_rad).log2();
    assert!((held - 2.0).abs() < 0.1 && (linear - 2.0).abs() < 0.1, "{held} {linear}");
}

#[test]
fn verdict_does_not_depend_on_the_units() {
    for (size, duration) in [(5000.0, 60.0), (1e-3, 60.0), (1e-3, 1e6)] {
        let momentum = [2.0, -1.0, 4.0, 3.0].map(|h| h * 2.0 * size / duration);
        let rate = 2.0 / duration * Vector3::new(0.3, -0.4, 0.6);
        let mut problem = problem(size * full_inertia(), rate, pyramid(momentum)).with_steps(200);
        problem.duration = duration.into();
        let unit = 4.0 * size / (duration * duration);
        let inputs: Vec<f64> = smooth_inputs(&problem).iter().map(|u| u * unit).collect();
        let (problem, plan) = aimed(problem, &inputs);
        let found = verify(&problem, &plan, 1e-12, None);
        assert!(found.passed(), "{size} {duration}: {found:#?}");
    }
}

// ---- limits and wrong plans
// -------------------------------------------------------------------------

#[test]
fn wheel_margins_are_those_of_the_rows() {
    for scheme in SCHEMES {
        let mut problem = tumbling(scheme);
        let limits = [2.5, 3.0, f64::INFINITY, 3.6];
        problem.actuation.wheels.as_mut().unwrap().momentum_limit = limits.to_vec();
        let size = Limits { size: Some(vec![2.5, 2.0, 3.0, 4.0]), ..Limits::default() };
        problem.actuation.torque = problem.actuation.torque.with_limits(size).unwrap();
        let inputs = smooth_inputs(&problem);
        let plan = replay(&problem, &inputs).unwrap();
        let found = margins(&problem, &inputs).unwrap();
        let names: Vec<&str> = found.iter().map(|margin| margin.name.as_str()).collect();
        assert_eq!(names, ["wheel torque limit", "wheel momentum limit"]);
        let scaled = plan.wheel_momentum.iter().enumerate().map(|(at, h)| 1.0 - h.abs() / limits[at % 4]);
        let expected = scaled.fold(f64::INFINITY, f64::min);
        assert!((found[1].scaled - expected).abs() < 1e-12, "{found:#?} {expected}");
        assert!(found[1].unit == "N·m·s" && found[1].at.starts_with("wheel "), "{found:#?}");
    }
}

#[test]
fn recorded_wheels_that_are_not_the_motion_fail() {
    let problem = tumbling(Scheme::LieVerlet);
    let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
    assert!(verify(&problem, &plan, 1e-12, None).passed());
    let mut nudged = plan.clone();
    nudged.wheel_momentum[17] += 1e-6;
    let found = verify(&problem, &nudged, 1e-12, None);
    assert!(!check(&found, "recorded states") && !check(&found, "total momentum"), "{found:#?}");
    for bad in [f64::NAN, f64::INFINITY] {
        let mut wrong = plan.clone();
        wrong.wheel_momentum[17] = bad;
        let found = verify(&problem, &wrong, 1e-12, None);
        for name in ["finite", "recorded states", "total momentum"] {
            assert!(!check(&found, name), "{bad} {name}");
        }
    }
    let mut short = plan.clone();
    short.wheel_momentum.pop();
    assert!(verify(&problem, &short, 1e-12, None).failure.unwrap().contains("wheel momenta"));
    // The same inputs without wheels, or from wheels that turn otherwise, lead elsewhere.
    let mut otherwise = problem.clone();
    otherwise.actuation.wheels.as_mut().unwrap().momentum[0] += 1e-6;
    assert!(!check(&verify(&otherwise, &plan, 1e-12, None), "discrete terminal"));
}

/// Random bodies, wheels and torques: no step fails, and every plan passes the witnesses.
#[test]
fn random_gyrostats_are_judged() {
    let mut random = Random::new(5);
    for case in 0..40 {
        let moments = Vector3::from_fn(|_, _| 1.0 + 0.3 * random.uniform());
        let axes = random.rotation();
        let j = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
        let momentum = [0; 4].map(|_| 10.0_f64.powf(random.uniform()) * random.uniform());
        let mut problem =
            problem(0.5 * (j + j.transpose()), random.vector(), pyramid(momentum)).with_steps(200);
        problem.scheme = SCHEMES[case % 2];
        let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
        let found = verify(&problem, &plan, 1e-12, None);
        assert!(found.passed(), "{case}: {found:#?}");
    }
}
