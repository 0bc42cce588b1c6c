//! The witnesses against reference vectors and closed forms, and their verdict on right and wrong plans.

mod common;

use common::{Random, list, matrix3, number, numbers, reference, vector};
use nalgebra::DMatrix;
use slewkit::actuation::{Actuation, AxisFrame, Channel};
use slewkit::body::{Body, Inertia};
use slewkit::environment::{Blocks, Environment, Pose, Wrench};
use slewkit::problem::{Problem, Scheme, State};
use slewkit::simulate::Row;
use slewkit::simulate::witness::{Propagator, Settings as Propagation, propagate};
use slewkit::solution::Trajectory;
use slewkit::verify::{Verification, WitnessError, replay, verify};
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::PI;
use std::ops::ControlFlow;

const SCHEMES: [Scheme; 2] = [Scheme::LieEuler, Scheme::LieVerlet];
const PROPAGATORS: [Propagator; 2] = [Propagator::LieVerlet, Propagator::Verner98];

/// `U = −p·(Rᵀd)` (pendulum), `U = (n²·3/2) G·JG`, `G = Rᵀo` (gravity gradient along a fixed direction),
/// `U = −μm/|x|` (a point), all in a frame turning at `rate`. Written anew: the witnesses use only
/// potential, force and moment, and should not be tested with the environments that they will judge.
#[derive(Clone, Debug)]
struct Field {
    pendulum: (Vector3, Vector3),
    gradient: (f64, Vector3, Matrix3),
    point: f64,
    rate: Vector3,
}

impl Field {
    fn none() -> Self {
        Self {
            pendulum: (Vector3::zeros(), Vector3::z()),
            gradient: (0.0, Vector3::z(), Matrix3::zeros()),
            point: 0.0,
            rate: Vector3::zeros(),
        }
    }

    fn pendulum(moment: Vector3) -> Self {
        Self { pendulum: (moment, Vector3::z()), ..Self::none() }
    }
}

impl Environment for Field {
    fn potential(&self, pose: &Pose) -> f64 {
        let (p, d) = &self.pendulum;
        let (n2, o, j) = &self.gradient;
        let g = pose.attitude.transpose() * o;
        let point = if self.point > 0.0 { -self.point / pose.position.norm() } else { 0.0 };
        1.5 * n2 * g.dot(&(j * g)) - p.dot(&(pose.attitude.transpose() * d)) + point
    }
    fn wrench(&self, pose: &Pose) -> Wrench {
        let (p, d) = &self.pendulum;
        let (n2, o, j) = &self.gradient;
        let g = pose.attitude.transpose() * o;
        let moment = p.cross(&(pose.attitude.transpose() * d)) + 3.0 * n2 * g.cross(&(j * g));
        let point = -self.point * pose.position / pose.position.norm().powi(3);
        Wrench { force: if self.point > 0.0 { point } else { Vector3::zeros() }, moment }
    }
    fn gradient(&self, _: &Pose) -> Blocks {
        unreachable!("the witnesses use no derivative")
    }
    fn curvature(&self, _: &Pose, _: &Wrench) -> Blocks {
        unreachable!("the witnesses use no derivative")
    }
    fn frame_rate(&self) -> Vector3 {
        self.rate
    }
}

fn full_inertia() -> Matrix3 {
    Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)
}

fn body(j: Matrix3) -> Body {
    Body { inertia: Inertia::new(j).unwrap(), mass: None }
}

fn torques(b: Matrix3, frame: AxisFrame) -> Actuation {
    let axes = b.column_iter().map(Into::into).collect();
    Actuation::torques(Channel::new(axes, frame, DMatrix::identity(3, 3)).unwrap())
}

/// A moving start, an end that nothing aims at: for tests of the propagation alone.
fn ballistic(j: Matrix3, rate: Vector3, duration: f64) -> Problem {
    let start = State::attitude(lie::exp(&Vector3::new(0.4, -0.3, 0.5)), rate);
    Problem::attitude(body(j), start, State::at_rest(Matrix3::identity()), duration)
}

fn final_row(problem: &Problem, propagator: Propagator, steps: u64, inputs: Option<&[f64]>) -> Row {
    let mut last = None;
    let settings = Propagation { propagator, steps, stride: u64::MAX, inputs };
    propagate(problem, &settings, &mut |row: &Row| {
        last = Some(row.clone());
        ControlFlow::Continue(())
    })
    .unwrap();
    last.unwrap()
}

fn attitude_error(row: &Row, expected: &Matrix3) -> f64 {
    lie::log(&(expected.transpose() * lie::rotation_from_quaternion(&row.bodies[0].quaternion))).norm()
}

/// Smooth inputs of a few units.
fn smooth_inputs(problem: &Problem) -> Vec<f64> {
    let rows = problem.scheme.input_rows(problem.steps);
    let count = problem.actuation.count();
    let mut inputs = vec![];
    for row in 0..rows {
        let t = (row + problem.steps + 1 - rows) as f64 / problem.steps as f64;
        inputs.extend((0..count).map(|i| (1.0 + i as f64 + 3.0 * t).sin() * (2.0 - i as f64 * t)));
    }
    inputs
}

/// The same maneuver aimed at where its inputs lead, and the plan that leads there.
fn aimed(mut problem: Problem, inputs: &[f64]) -> (Problem, Trajectory) {
    let plan = replay(&problem, inputs).unwrap();
    problem.end = State {
        position: plan.position.last().copied().unwrap_or_default(),
        velocity: plan.velocity.last().copied().unwrap_or_default(),
        attitude: lie::rotation_from_quaternion(plan.quaternion.last().unwrap()),
        angular_velocity: *plan.angular_velocity.last().unwrap(),
    };
    (problem, plan)
}

fn check(found: &Verification, name: &str) -> bool {
    let check = found.checks.iter().find(|check| check.name == name);
    check.unwrap_or_else(|| panic!("no check {name}: {found:#?}")).passed
}

// ---- discrete witness -------------------------------------------------------------------------------

#[test]
fn discrete_witness_reproduces_the_reference_trajectories() {
    let file = reference("trajectories");
    let (j, h) = (matrix3(&file["J"]), number(&file["h"]));
    let u: Vec<Vec<f64>> = list(&file["u"]).iter().map(numbers).collect();
    let rho = vector(&file["pendulum"]["rho"]);
    let pendulum = Field::pendulum(number(&file["pendulum"]["mg"]) * rho);
    let gradient = (number(&file["gravity_gradient"]["n2"]), vector(&file["gravity_gradient"]["o"]), j);
    let fields = [
        ("free", Field::none()),
        ("pendulum", pendulum),
        ("gravity_gradient", Field { gradient, ..Field::none() }),
    ];
    for (name, field) in fields {
        for (scheme, key) in SCHEMES.into_iter().zip(["lie_euler", "velocity_verlet"]) {
            let body = body(j);
            let rate = body.inertia.j_inverse() * vector(&file["Pi0"]);
            let start = State::attitude(matrix3(&file["R0"]), rate);
            let problem = Problem::attitude(body, start, start, 5.0 * h)
                .with_environment(field.clone())
                .with_actuation(torques(matrix3(&file["B"]), AxisFrame::Body))
                .with_steps(5)
                .with_scheme(scheme);
            let rows = &u[u.len() - scheme.input_rows(5)..];
            let plan = replay(&problem, &rows.concat()).unwrap();
            for (k, expected) in list(&file["trajectories"][name][key]).iter().enumerate() {
                let attitude = lie::rotation_from_quaternion(&plan.quaternion[k]);
                let momentum = j * plan.angular_velocity[k];
                let errors = [
                    (attitude - matrix3(&expected["R"])).amax(),
                    (momentum - vector(&expected["Pi"])).amax(),
                ];
                assert!(errors.iter().all(|error| *error < 1e-14), "{name} {key} {k}: {errors:?}");
            }
        }
    }
}

#[test]
fn known_optimal_controls_end_at_their_targets() {
    let file = reference("min_energy_so3");
    for case in list(&file["cases"]) {
        let name = &case["name"];
        let body = body(matrix3(&case["J"]));
        let state = |r: &str, pi: &str| {
            State::attitude(matrix3(&case[r]), body.inertia.j_inverse() * vector(&case[pi]))
        };
        let (start, end) = (state("R0", "Pi0"), state("Rd", "Pid"));
        let mut problem = Problem::attitude(body.clone(), start, end, number(&case["T"]))
            .with_actuation(torques(matrix3(&case["B"]), AxisFrame::Body))
            .with_steps(number(&case["N"]) as usize)
            .with_scheme(Scheme::LieEuler);
        if case["potential"] != "Free" {
            problem = problem.with_environment(Field::pendulum(1.7 * Vector3::new(0.1, -0.2, 0.9)));
        }
        let inputs: Vec<f64> = list(&case["u"]).iter().flat_map(numbers).collect();
        let plan = replay(&problem, &inputs).unwrap();
        let found = verify(&problem, &plan, 1e-12, None);
        assert!(found.passed(), "{name}: {found:#?}");
        assert!(found.discrete().largest() < 1e-13, "{name}: {found:#?}");
        let order = found.order.unwrap();
        // Lie–Euler runs late by h/2, which from rest to rest is an error of second order only.
        let expected = if name == "free_moving_ends" { 1.0 } else { 2.0 };
        assert!((order - expected).abs() < 0.1, "{name}: order {order}");
        assert!(found.continuous_attitude_rad > 1e-4, "the two terminal errors are not the same");
    }
}

/// `J sin f = hΠ` about a principal axis: N steps turn by `N asin(hΩ)`, in closed form.
#[test]
fn a_million_steps_stay_within_a_few_ulps_of_the_closed_form() {
    let rate = Vector3::new(0.0, 0.0, 300.0);
    let start = State::attitude(Matrix3::identity(), rate);
    let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.5));
    let problem = Problem::attitude(body(inertia), start, start, 1.0);
    let steps = 1_000_000;
    let row = final_row(&problem, Propagator::LieVerlet, steps, None);
    let angle = steps as f64 * (300.0 / steps as f64).asin();
    let error = attitude_error(&row, &lie::exp(&Vector3::new(0.0, 0.0, angle)));
    // 48 turns: the angle itself is known to 6e-14.
    assert!(error < 3e-13, "{error:e}");
    assert!(
        (row.invariants.angular_momentum - Vector3::new(0.0, 0.0, 750.0)).norm() < 1e-12,
        "{}",
        row.invariants.angular_momentum
    );
}

#[test]
fn a_million_tumbling_steps_conserve_spatial_momentum() {
    let problem = ballistic(full_inertia(), Vector3::new(30.0, -20.0, 45.0), 1.0);
    let first = problem.start.attitude * (full_inertia() * problem.start.angular_velocity);
    let row = final_row(&problem, Propagator::LieVerlet, 1_000_000, None);
    let error = (row.invariants.angular_momentum - first).norm() / first.norm();
    assert!(error < 2e-14, "{error:e}");
}

// ---- continuous witness -----------------------------------------------------------------------------

#[test]
fn continuous_steady_rotation_is_exact() {
    let axis = Vector3::new(0.0, 3.0, 0.0);
    let problem = ballistic(Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.5)), axis, 2.0);
    for steps in [1, 7, 1000] {
        let row = final_row(&problem, Propagator::Verner98, steps, None);
        let error = attitude_error(&row, &(problem.start.attitude * lie::exp(&(2.0 * axis))));
        assert!(error < 1e-14, "{steps}: {error:e}");
    }
}

/// `R(t) = exp(t S(L/a)) R₀ exp(t (1/c − 1/a) Π₃ S(e₃))` for `J = diag(a, a, c)`.
#[test]
fn continuous_axisymmetric_precession_is_exact() {
    let (a, c, t) = (2.0, 1.1, 3.0);
    let rate = Vector3::new(1.0, -0.7, 2.0);
    let problem = ballistic(Matrix3::from_diagonal(&Vector3::new(a, a, c)), rate, t);
    let start = problem.start.attitude;
    let spatial = start * Vector3::new(a * rate.x, a * rate.y, c * rate.z);
    let spin = Vector3::new(0.0, 0.0, t * (1.0 / c - 1.0 / a) * c * rate.z);
    let expected = lie::exp(&(t / a * spatial)) * start * lie::exp(&spin);
    for steps in [1, 10, 3000] {
        let row = final_row(&problem, Propagator::Verner98, steps, None);
        let error = attitude_error(&row, &expected);
        assert!(error < 5e-14, "{steps}: {error:e}");
        assert!((row.invariants.angular_momentum - spatial).norm() < 5e-14);
    }
}

#[test]
fn continuous_asymmetric_body_conserves_momentum_and_energy() {
    let problem = ballistic(full_inertia(), Vector3::new(1.0, -2.0, 1.5), 20.0);
    let mut first = None;
    let settings = Propagation { propagator: Propagator::Verner98, steps: 200, ..Propagation::default() };
    let mut rows = 0;
    propagate(&problem, &settings, &mut |row: &Row| {
        let first = first.get_or_insert_with(|| row.clone());
        assert!(
            (row.invariants.angular_momentum - first.invariants.angular_momentum).norm() < 1e-13,
            "t = {}",
            row.time
        );
        assert!((row.invariants.energy - first.invariants.energy).abs() < 1e-13, "t = {}", row.time);
        rows += 1;
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(rows, 201);
}

#[test]
fn constant_torque_turns_by_half_its_acceleration_times_time_squared() {
    let start = State::at_rest(Matrix3::identity());
    let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.5));
    let problem = Problem::attitude(body(inertia), start, start, 3.0);
    let expected = lie::exp(&Vector3::new(0.0, 0.5 * (0.8 / 2.0) * 9.0, 0.0));
    for steps in [1, 100] {
        let row = final_row(&problem, Propagator::Verner98, steps, Some(&[0.0, 0.8, 0.0]));
        assert!(attitude_error(&row, &expected) < 1e-14);
        assert!((row.bodies[0].angular_velocity.y - 1.2).abs() < 1e-14);
    }
}

/// A sphere of fixed attitude, seen from a frame that turns: `R(t) = exp(−t S(n)) R₀ exp(t S(Ω))`.
#[test]
fn turning_frame_turns_the_attitude_back() {
    let (n, rate) = (Vector3::new(0.2, 0.9, -0.1), Vector3::new(0.5, 0.3, -0.4));
    let problem =
        ballistic(2.0 * Matrix3::identity(), rate, 4.0).with_environment(Field { rate: n, ..Field::none() });
    let expected = lie::exp(&(-4.0 * n)) * problem.start.attitude * lie::exp(&(4.0 * rate));
    let row = final_row(&problem, Propagator::Verner98, 50, None);
    assert!(attitude_error(&row, &expected) < 1e-14);
    // Discrete: per step asin(h|Ω|) instead of h|Ω|, the frame exactly.
    let row = final_row(&problem, Propagator::LieVerlet, 50, None);
    let per_step = (0.08 * rate.norm()).asin() * rate.normalize();
    let expected = lie::exp(&(-4.0 * n)) * problem.start.attitude * lie::exp(&(50.0 * per_step));
    let error = attitude_error(&row, &expected);
    assert!(error < 1e-14, "{error:e}");
}

#[test]
fn turning_gravity_gradient_conserves_jacobis_integral() {
    let field = Field { gradient: (1.0, Vector3::z(), full_inertia()), rate: Vector3::y(), ..Field::none() };
    let problem = ballistic(full_inertia(), Vector3::new(0.3, 1.2, -0.4), 6.0).with_environment(field);
    let mut first = None;
    let settings = Propagation { propagator: Propagator::Verner98, steps: 60, ..Propagation::default() };
    propagate(&problem, &settings, &mut |row: &Row| {
        let drift = row.invariants.energy - *first.get_or_insert(row.invariants.energy);
        assert!(drift.abs() < 1e-13, "t = {}: {drift:e}", row.time);
        ControlFlow::Continue(())
    })
    .unwrap();
}

/// A point mass on a circular orbit, in metres and kilograms, and back after one period.
#[test]
fn continuous_circular_orbit_closes() {
    let (mu, radius, mass) = (3.986e14_f64, 7.0e6_f64, 500.0);
    let speed = (mu / radius).sqrt();
    let mut start = State::at_rest(Matrix3::identity());
    start.position.x = radius;
    start.velocity.y = speed;
    let body = Body { inertia: Inertia::new(100.0 * full_inertia()).unwrap(), mass: Some(mass) };
    let period = 2.0 * PI * radius / speed;
    let problem = Problem::rigid_body(body, start, start, period)
        .with_environment(Field { point: mu * mass, ..Field::none() });
    for steps in [20, 1000] {
        let row = final_row(&problem, Propagator::Verner98, steps, None);
        let errors = [
            (row.bodies[0].position - start.position).norm() / radius,
            (row.bodies[0].velocity - start.velocity).norm() / speed,
        ];
        assert!(errors.iter().all(|error| *error < 1e-13), "{steps}: {errors:?}");
        assert!((row.invariants.angular_momentum.z / (mass * radius * speed) - 1.0).abs() < 1e-14);
    }
}

/// A thruster fixed in the body pushes where the body points: `x = ½ (F/m) t²` along `R F`.
#[test]
fn body_fixed_forces_turn_with_the_body() {
    let start = State::at_rest(lie::exp(&Vector3::new(0.4, -0.3, 0.5)));
    let body = Body { inertia: Inertia::new(full_inertia()).unwrap(), mass: Some(2.0) };
    let mut problem = Problem::rigid_body(body, start, start, 3.0);
    let force = Vector3::new(0.5, -0.2, 0.3);
    for frame in [AxisFrame::Body, AxisFrame::Reference] {
        problem.actuation.force = Some(Channel::three_axes(frame));
        let pushed = if frame == AxisFrame::Body { start.attitude * force } else { force };
        for propagator in PROPAGATORS {
            let row = final_row(&problem, propagator, 10, Some(&[force.x, force.y, force.z, 0.0, 0.0, 0.0]));
            assert!(
                (row.bodies[0].position - 0.5 * 9.0 / 2.0 * pushed).norm() < 1e-14,
                "{frame:?} {propagator:?}"
            );
            assert!((row.bodies[0].velocity - 3.0 / 2.0 * pushed).norm() < 1e-14);
        }
    }
}

/// A torque about a horizontal reference axis leaves the vertical momentum of a pendulum alone.
#[test]
fn reference_frame_torques_leave_the_vertical_momentum() {
    let mut problem = ballistic(full_inertia(), Vector3::new(0.3, -0.4, 0.6), 2.0)
        .with_environment(Field::pendulum(Vector3::new(0.2, -0.3, 1.5)))
        .with_actuation(torques(Matrix3::identity(), AxisFrame::Reference));
    let vertical = (problem.start.attitude * (full_inertia() * problem.start.angular_velocity)).z;
    for propagator in PROPAGATORS {
        let row = final_row(&problem, propagator, 200, Some(&[1.0, -0.7, 0.0]));
        assert!((row.invariants.angular_momentum.z - vertical).abs() < 1e-13, "{propagator:?}");
    }
    for scheme in SCHEMES {
        problem.scheme = scheme;
        let mut inputs = smooth_inputs(&problem);
        inputs.chunks_mut(3).for_each(|row| row[2] = 0.0);
        let plan = replay(&problem, &inputs).unwrap();
        for (q, rate) in plan.quaternion.iter().zip(&plan.angular_velocity) {
            let momentum = lie::rotation_from_quaternion(q) * (full_inertia() * rate);
            assert!((momentum.z - vertical).abs() < 1e-13);
        }
        let torque =
            lie::rotation_from_quaternion(plan.quaternion.last().unwrap()) * plan.torque.last().unwrap();
        assert!((torque - Vector3::from_row_slice(&inputs[inputs.len() - 3..])).norm() < 1e-14);
    }
}

// ---- the two together -------------------------------------------------------------------------------

/// Free, pendulum, turning gravity gradient; torques in the body and in the reference frame; SE(3) with
/// forces in either frame.
fn assortment() -> Vec<(&'static str, Problem)> {
    let free = ballistic(full_inertia(), Vector3::new(0.3, -0.4, 0.6), 2.0).with_steps(80);
    let pendulum = free.clone().with_environment(Field::pendulum(Vector3::new(0.2, -0.3, 1.5)));
    let turning =
        Field { gradient: (1.0, Vector3::z(), full_inertia()), rate: Vector3::y(), ..Field::none() };
    let mut cases = vec![
        ("free", free.clone()),
        ("pendulum", pendulum.clone()),
        ("reference torques", pendulum.with_actuation(torques(Matrix3::identity(), AxisFrame::Reference))),
        ("turning", free.clone().with_environment(turning)),
        (
            "turning, reference torques",
            free.with_environment(Field { rate: Vector3::new(0.3, 0.9, 0.2), ..Field::none() })
                .with_actuation(torques(full_inertia(), AxisFrame::Reference)),
        ),
    ];
    for frame in [AxisFrame::Body, AxisFrame::Reference] {
        let mut start = State::attitude(lie::exp(&Vector3::x()), Vector3::new(0.3, -0.4, 0.6));
        start.position = Vector3::new(1.0, 0.0, 0.1);
        start.velocity = Vector3::new(0.0, 1.0, 0.2);
        let body = Body { inertia: Inertia::new(full_inertia()).unwrap(), mass: Some(1.3) };
        let mut problem = Problem::rigid_body(body, start, start, 2.0)
            .with_environment(Field { point: 1.3, ..Field::pendulum(Vector3::new(0.2, -0.3, 1.5)) })
            .with_steps(80);
        problem.actuation.force = Some(Channel::three_axes(frame));
        cases.push((if frame == AxisFrame::Body { "body force" } else { "reference force" }, problem));
    }
    cases
}

#[test]
fn held_torques_converge_at_the_order_of_the_scheme() {
    for (name, problem) in assortment() {
        for scheme in SCHEMES {
            let problem = problem.clone().with_scheme(scheme);
            let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
            let found = verify(&problem, &plan, 1e-12, None);
            assert!(found.passed(), "{name} {scheme:?}: {found:#?}");
            let (order, expected) = (found.order.unwrap(), f64::from(scheme.order()));
            assert!((order - expected).abs() < 0.15, "{name} {scheme:?}: order {order}");
        }
    }
}

/// Two exact integrators of unlike kinds: another crate's Runge–Kutta pair on quaternions, and a variational
/// method in rotation vectors. Plans of 80 steps, of 8 whose steps it divides, and of 2000.
#[test]
fn the_symplectic_witness_ends_where_the_continuous_one_does() {
    for (name, problem) in assortment() {
        for (scheme, steps) in [(SCHEMES[0], 80), (SCHEMES[1], 80), (SCHEMES[1], 8), (SCHEMES[1], 2000)] {
            let problem = problem.clone().with_scheme(scheme).with_steps(steps);
            let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
            let found = verify(&problem, &plan, 1e-12, None);
            assert!(check(&found, "symplectic witness"), "{name} {scheme:?} {steps}: {found:#?}");
            let apart = found.symplectic_to_continuous.unwrap();
            assert!(apart < 1e-12, "{name} {scheme:?} {steps}: {apart:e}");
            let near = |a: Option<f64>, b: Option<f64>| (a.unwrap() - b.unwrap()).abs() < 1e-11;
            assert!(near(found.symplectic_attitude_rad, Some(found.continuous_attitude_rad)));
            assert!(near(found.symplectic_rate_rad_s, Some(found.continuous_rate_rad_s)));
            assert_eq!(found.symplectic_position_m.is_some(), found.continuous_position_m.is_some());
            if found.symplectic_position_m.is_some() {
                assert!(near(found.symplectic_position_m, found.continuous_position_m));
                assert!(near(found.symplectic_velocity_m_s, found.continuous_velocity_m_s));
            }
        }
    }
}

/// What the planner's equations mean and what acts differs: a field whose force is no function of the pose. The
/// witnesses evaluate it at other places and other times.
#[test]
fn witnesses_that_see_different_fields_do_not_agree() {
    #[derive(Debug, Default)]
    struct Fickle(std::sync::atomic::AtomicU64);
    impl Environment for Fickle {
        fn potential(&self, _: &Pose) -> f64 {
            0.0
        }
        fn wrench(&self, _: &Pose) -> Wrench {
            let calls = self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            Wrench { force: Vector3::zeros(), moment: Vector3::x() * (1e-6 * (calls / 1000 % 7) as f64) }
        }
        fn gradient(&self, _: &Pose) -> Blocks {
            unreachable!("the witnesses use no derivative")
        }
        fn curvature(&self, _: &Pose, _: &Wrench) -> Blocks {
            unreachable!("the witnesses use no derivative")
        }
    }
    let (problem, plan) = good();
    let found = verify(&problem.with_environment(Fickle::default()), &plan, 1e-3, None);
    assert!(!check(&found, "symplectic witness"), "{found:#?}");
}

/// Halving the plan's own step: mean and linear torque of Verlet and the held torque of Lie–Euler lead the
/// continuous motion to the discrete end at the order of the scheme (theory, section 3).
#[test]
fn continuous_terminal_error_falls_at_the_order_of_the_scheme() {
    for (name, problem) in assortment() {
        for scheme in SCHEMES {
            let found = [160, 320].map(|steps| {
                let problem = problem.clone().with_scheme(scheme).with_steps(steps);
                let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
                verify(&problem, &plan, 1e-12, None)
            });
            let [a, b] = &found;
            let held = (a.continuous_attitude_rad / b.continuous_attitude_rad).log2();
            let linear = (a.interpolated_attitude_rad / b.interpolated_attitude_rad).log2();
            let expected = f64::from(scheme.order());
            assert!((held - expected).abs() < 0.15, "{name} {scheme:?}: held {held}");
            assert!((linear - expected).abs() < 0.15, "{name} {scheme:?}: linear {linear}");
        }
    }
}

#[test]
fn verdict_does_not_depend_on_the_units() {
    // XTE: thousands of kg·m², minutes, 50 N·m; and a cubesat of grams.
    for (size, duration) in [(5000.0, 60.0), (1e-3, 60.0), (1e-3, 1e6), (1e20, 1e-6)] {
        let rate = 2.0 / duration * Vector3::new(0.3, -0.4, 0.6);
        let problem = ballistic(size * full_inertia(), rate, duration).with_steps(200);
        let unit = 4.0 * size / (duration * duration);
        let inputs: Vec<f64> = smooth_inputs(&problem).iter().map(|u| u * unit).collect();
        let (problem, plan) = aimed(problem, &inputs);
        let found = verify(&problem, &plan, 1e-12, Some(0.01));
        assert!(found.passed(), "{size} {duration}: {found:#?}");
        assert!((found.order.unwrap() - 2.0).abs() < 0.1);
    }
}

#[test]
fn coarse_plans_are_judged_on_finer_levels() {
    let mut random = Random::new(7);
    for steps in [4, 6, 8, 10, 14] {
        for scheme in SCHEMES {
            let rate = 1.5 * random.vector();
            let problem = ballistic(full_inertia(), rate, 1.6).with_steps(steps).with_scheme(scheme);
            let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
            let found = verify(&problem, &plan, 1e-12, None);
            assert!(found.passed(), "{steps} {scheme:?} {rate}: {found:#?}");
        }
    }
}

#[test]
fn a_body_left_alone_agrees_to_round_off() {
    let start = State::at_rest(lie::exp(&Vector3::new(0.4, -0.3, 0.5)));
    let problem = Problem::attitude(body(full_inertia()), start, start, 10.0);
    let (problem, plan) = aimed(problem.clone(), &vec![0.0; 303]);
    let found = verify(&problem, &plan, 1e-12, Some(1e-9));
    assert!(found.passed(), "{found:#?}");
    assert_eq!(found.order, None);
    assert!(check(&found, "round-off"));
}

/// Upright and left alone, a pendulum multiplies its round-off by a hundred thousand: no order is to be
/// seen, and no disagreement either.
#[test]
fn amplified_round_off_is_round_off() {
    let start = State::at_rest(lie::exp(&Vector3::new(0.4, -0.3, 0.5)));
    let upright = -1.7 * (start.attitude.transpose() * Vector3::z());
    let mut errors = vec![];
    for duration in [10.0, 14.0, 18.0] {
        let problem = Problem::attitude(body(full_inertia()), start, start, duration)
            .with_environment(Field::pendulum(upright));
        let (problem, plan) = aimed(problem.clone(), &vec![0.0; 303]);
        let found = verify(&problem, &plan, 1e-12, None);
        assert!(check(&found, "round-off"), "{found:#?}");
        errors.push(found.checks.iter().find(|check| check.name == "round-off").unwrap().value);
    }
    assert!(errors.iter().any(|error| *error > 1e-11), "nothing was amplified: {errors:?}");
}

// ---- wrong plans ------------------------------------------------------------------------------------

fn good() -> (Problem, Trajectory) {
    let problem = ballistic(full_inertia(), Vector3::new(0.3, -0.4, 0.6), 2.0).with_steps(50);
    aimed(problem.clone(), &smooth_inputs(&problem))
}

#[test]
fn wrong_inputs_fail_the_discrete_terminal_check() {
    let (problem, plan) = good();
    assert!(verify(&problem, &plan, 1e-12, None).passed());
    let mut flipped = plan.clone();
    flipped.input.iter_mut().for_each(|u| *u = -*u);
    let mut nudged = plan.clone();
    nudged.input[61] += 1e-6;
    let right = verify(&problem, &plan, 1e-12, None).symplectic_attitude_rad.unwrap();
    for (nudge, seen) in [(1e-6, 1e-9), (1.0, 1e-3)] {
        let mut wrong = plan.clone();
        wrong.input[61] += nudge;
        let wrong = verify(&problem, &wrong, 1e-12, None).symplectic_attitude_rad.unwrap();
        assert!((wrong - right).abs() > seen, "{nudge}: {right:e} {wrong:e}");
    }
    let mut nudged_little = plan;
    nudged_little.input[61] += 1e-9;
    for wrong in [flipped, nudged, nudged_little] {
        let found = verify(&problem, &wrong, 1e-12, None);
        assert!(!check(&found, "discrete terminal"), "{found:#?}");
        assert!(!found.passed());
        // The witness of other equations sees the same.
        let apart = (found.symplectic_attitude_rad.unwrap() - found.continuous_attitude_rad).abs();
        assert!(apart < 1e-12, "{found:#?}");
    }
}

#[test]
fn a_plan_for_another_body_field_or_target_fails() {
    let (problem, plan) = good();
    let mut other = problem.clone();
    other.body.inertia = Inertia::new(full_inertia() * 1.001).unwrap();
    let mut target = problem.clone();
    target.end.attitude *= lie::exp(&Vector3::new(1e-9, 0.0, 0.0));
    let field = problem.clone().with_environment(Field::pendulum(Vector3::new(0.0, 0.0, 1e-6)));
    for wrong in [other, target, field] {
        assert!(!check(&verify(&wrong, &plan, 1e-12, None), "discrete terminal"));
    }
    // The sign of the field's moment.
    let p = Vector3::new(0.2, -0.3, 1.5);
    let swung = ballistic(full_inertia(), Vector3::zeros(), 2.0).with_environment(Field::pendulum(p));
    let (swung, plan) = aimed(swung.clone(), &smooth_inputs(&swung));
    assert!(verify(&swung, &plan, 1e-12, None).passed());
    let upside_down = swung.with_environment(Field::pendulum(-p));
    assert!(!verify(&upside_down, &plan, 1e-12, None).passed());
}

#[test]
fn recorded_states_that_are_not_the_motion_fail() {
    let (problem, plan) = good();
    let spoil: [fn(&mut Trajectory); 5] = [
        |plan| plan.time[20] += 1e-6,
        |plan| plan.quaternion[20] = [1.0, 0.0, 0.0, 0.0],
        |plan| plan.angular_velocity[20].x += 1e-6,
        |plan| plan.torque[20].z += 1e-6,
        |plan| plan.quaternion[20].iter_mut().for_each(|part| *part *= 1.001),
    ];
    for spoil in spoil {
        let mut wrong = plan.clone();
        spoil(&mut wrong);
        let found = verify(&problem, &wrong, 1e-12, None);
        assert!(check(&found, "discrete terminal") && !check(&found, "recorded states"), "{found:#?}");
    }
    let mut same = plan;
    same.quaternion[20].iter_mut().for_each(|part| *part = -*part);
    assert!(verify(&problem, &same, 1e-12, None).passed(), "q and −q are one attitude");
}

#[test]
fn nan_and_infinity_fail_wherever_they_stand() {
    let (problem, plan) = good();
    let spoil: [fn(&mut Trajectory, f64); 6] = [
        |plan, bad| plan.input[17] = bad,
        |plan, bad| plan.time[3] = bad,
        |plan, bad| plan.quaternion[3][1] = bad,
        |plan, bad| plan.angular_velocity[3].x = bad,
        |plan, bad| plan.torque[3].x = bad,
        |plan, bad| plan.costates.push(bad),
    ];
    for (index, spoil) in spoil.into_iter().enumerate() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut wrong = plan.clone();
            spoil(&mut wrong, bad);
            let found = verify(&problem, &wrong, 1e-12, None);
            assert!(!check(&found, "finite") && !found.passed(), "{index} {bad}: {found:#?}");
            let states = (1..=4).contains(&index);
            assert!(!states || !check(&found, "recorded states"), "{index} {bad}: {found:#?}");
        }
    }
    let mut nan_input = plan.clone();
    nan_input.input[17] = f64::NAN;
    let found = verify(&problem, &nan_input, 1e-12, Some(1.0));
    for name in ["finite", "discrete terminal", "recorded states", "order", "continuous terminal"] {
        assert!(!check(&found, name), "{name}");
    }
    assert!(found.failure.unwrap().contains("no longer finite"));
    let huge = verify(&problem, &Trajectory { input: vec![1e300; plan.input.len()], ..plan }, 1e-12, None);
    assert!(!huge.passed());
}

#[test]
fn missing_and_surplus_rows_fail() {
    let (problem, plan) = good();
    let spoil: [fn(&mut Trajectory); 9] = [
        |plan| plan.input.truncate(plan.input.len() - 1),
        |plan| plan.input.extend([0.0; 3]),
        |plan| plan.input_count = 2,
        |plan| plan.time.truncate(plan.time.len() - 1),
        |plan| plan.quaternion.truncate(plan.quaternion.len() - 1),
        |plan| plan.angular_velocity.push(Vector3::zeros()),
        |plan| plan.torque.truncate(plan.torque.len() - 1),
        |plan| plan.position.push(Vector3::zeros()),
        |plan| *plan = Trajectory::default(),
    ];
    for (index, spoil) in spoil.into_iter().enumerate() {
        let mut wrong = plan.clone();
        spoil(&mut wrong);
        let found = verify(&problem, &wrong, 1e-12, None);
        assert!(!found.passed() && found.failure.is_some(), "{index}: {found:#?}");
    }
    assert!(matches!(replay(&problem, &[0.0; 7]), Err(WitnessError::Rows { found: 7, .. })));
}

#[test]
fn continuous_tolerance_is_its_own_check() {
    let (problem, plan) = good();
    let found = verify(&problem, &plan, 1e-12, Some(1e-6));
    assert!(!check(&found, "continuous terminal") && check(&found, "order"), "{found:#?}");
    assert!(verify(&problem, &plan, 1e-12, Some(0.1)).passed());
}

#[test]
fn steps_too_long_and_bad_problems_are_failures_with_reasons() {
    let (mut problem, plan) = good();
    let kicked = Trajectory { input: plan.input.iter().map(|u| 1000.0 * u).collect(), ..plan.clone() };
    let found = verify(&problem, &kicked, 1e-12, None);
    assert!(found.failure.as_ref().unwrap().contains("one step"), "{found:#?}");
    assert!(!found.passed());
    problem.duration = f64::NAN;
    let found = verify(&problem, &plan, 1e-12, None);
    assert!(!found.passed() && found.failure.unwrap().contains("duration"));
    problem.duration = 2.0;
    problem.steps = 0;
    let found = verify(&problem, &plan, 1e-12, None);
    assert!(!found.passed() && found.failure.unwrap().contains("steps"));
}

#[test]
fn a_field_without_a_value_ends_the_simulation_with_its_time() {
    let problem = ballistic(full_inertia(), Vector3::new(0.3, -0.4, 0.6), 2.0)
        .with_environment(Field::pendulum(Vector3::repeat(f64::NAN)));
    let run = |propagator| {
        let settings = Propagation { propagator, ..Propagation::default() };
        propagate(&problem, &settings, &mut |_: &Row| ControlFlow::Continue(()))
    };
    assert_eq!(run(Propagator::Verner98), Err(WitnessError::Continuous { time: 0.0 }));
    assert!(matches!(run(Propagator::LieVerlet), Err(WitnessError::NotFinite { .. })));
}

#[test]
fn simulation_hands_out_the_rows_asked_for() {
    let problem = ballistic(full_inertia(), Vector3::new(0.3, -0.4, 0.6), 2.0);
    for propagator in PROPAGATORS {
        let mut times = vec![];
        let settings = Propagation { propagator, steps: 10, stride: 4, inputs: None };
        propagate(&problem, &settings, &mut |row: &Row| {
            times.push(row.time);
            ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!(times, [0.0, 0.8, 1.6, 2.0]);
        let mut rows = 0;
        propagate(&problem, &settings, &mut |_: &Row| {
            rows += 1;
            if rows < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })
        .unwrap();
        assert_eq!(rows, 2, "stops when told");
    }
    let settings = Propagation { inputs: Some(&[1.0]), ..Propagation::default() };
    assert!(matches!(
        propagate(&problem, &settings, &mut |_: &Row| ControlFlow::Continue(())),
        Err(WitnessError::Rows { .. })
    ));
}

/// A field that is no function of the pose: its moment depends on how often it was asked.
#[test]
fn witnesses_that_disagree_fail_the_order_check() {
    #[derive(Debug, Default)]
    struct Drifting(std::sync::atomic::AtomicU64);
    impl Environment for Drifting {
        fn potential(&self, _: &Pose) -> f64 {
            0.0
        }
        fn wrench(&self, _: &Pose) -> Wrench {
            let calls = self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            Wrench { force: Vector3::zeros(), moment: Vector3::new(1e-4 * (calls as f64).sqrt(), 0.0, 0.0) }
        }
        fn gradient(&self, _: &Pose) -> Blocks {
            Blocks::zero()
        }
        fn curvature(&self, _: &Pose, _: &Wrench) -> Blocks {
            Blocks::zero()
        }
    }
    let (problem, plan) = good();
    let found = verify(&problem.with_environment(Drifting::default()), &plan, 1e-1, None);
    assert!(check(&found, "discrete terminal") && !check(&found, "order"), "{found:#?}");
}

/// Plates and rods, principal moments up to a factor of 1e8 apart, axes askew.
#[test]
fn degenerate_bodies_are_judged_like_others() {
    let tilt = lie::exp(&Vector3::new(0.4, -0.3, 0.5));
    for (moments, steps) in [([1.0, 1.0, 2.0], 80), ([1e-4, 1.0, 1.0], 400), ([1e-8, 1.0, 1.0], 400)] {
        let j = tilt * Matrix3::from_diagonal(&Vector3::from(moments)) * tilt.transpose();
        // Inputs across the thin axis: about it they would spin the rod up beyond any step.
        let across = torques(tilt, AxisFrame::Body).torque.axes()[1..].to_vec();
        let channel = Channel::new(across, AxisFrame::Body, DMatrix::identity(2, 2)).unwrap();
        for scheme in SCHEMES {
            let problem = ballistic(0.5 * (j + j.transpose()), Vector3::zeros(), 2.0)
                .with_actuation(Actuation::torques(channel.clone()))
                .with_steps(steps)
                .with_scheme(scheme);
            let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
            let found = verify(&problem, &plan, 1e-7, None);
            assert!(found.passed(), "{moments:?} {scheme:?}: {found:#?}");
        }
    }
}
