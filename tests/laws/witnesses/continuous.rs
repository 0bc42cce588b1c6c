//! The continuous witness against closed forms and invariants.

use super::support::*;

/// Returns all pairs of a number of steps and an exact propagator.
fn each<const K: usize>(steps: [u64; K]) -> impl Iterator<Item = (u64, Propagator)> {
    steps.into_iter().flat_map(|steps| EXACT.map(|propagator| (steps, propagator)))
}

#[test]
fn continuous_steady_rotation_is_exact() {
    let axis = Vector3::new(0.0, 3.0, 0.0);
    let problem = ballistic(Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.5)), axis, 2.0);
    for (steps, propagator) in each([1, 7, 1000]) {
        let row = final_row(&problem, propagator, steps, None);
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
    for (steps, propagator) in each([1, 10, 3000]) {
        let row = final_row(&problem, propagator, steps, None);
        let error = attitude_error(&row, &expected);
        assert!(error < 5e-14, "{steps}: {error:e}");
        assert!((row.invariants.angular_momentum - spatial).norm() < 5e-14);
    }
}

#[test]
fn continuous_asymmetric_body_conserves_momentum_and_energy() {
    let problem = ballistic(full_inertia(), Vector3::new(1.0, -2.0, 1.5), 20.0);
    for propagator in EXACT {
        let mut first = None;
        let settings = Propagation { propagator, steps: 200, ..Propagation::default() };
        let mut rows = 0;
        propagate(&problem, &settings, &mut |row: &SimulationRow| {
            let first = first.get_or_insert_with(|| row.clone());
            assert!(
                (row.invariants.angular_momentum - first.invariants.angular_momentum).norm() < 1e-13,
                "{propagator:?} t = {}",
                row.time
            );
            let gain = row.invariants.energy - first.invariants.energy;
            assert!(gain.abs() < 1e-13, "{propagator:?} t = {}", row.time);
            rows += 1;
            ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!(rows, 201);
    }
}

#[test]
fn constant_torque_turns_by_half_its_acceleration_times_time_squared() {
    let start = State::at_rest(Matrix3::identity());
    let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.5));
    let problem = Problem::attitude(body(inertia), start, start, 3.0);
    let expected = lie::exp(&Vector3::new(0.0, 0.5 * (0.8 / 2.0) * 9.0, 0.0));
    for (steps, propagator) in each([1, 10, 100]) {
        let row = final_row(&problem, propagator, steps, Some(&[0.0, 0.8, 0.0]));
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
    for propagator in EXACT {
        let row = final_row(&problem, propagator, 50, None);
        assert!(attitude_error(&row, &expected) < 1e-14, "{propagator:?}");
    }
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
    propagate(&problem, &settings, &mut |row: &SimulationRow| {
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
    for (steps, propagator) in each([20, 1000]) {
        let row = final_row(&problem, propagator, steps, None);
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
        problem.actuation.force = Some(ActuatorSet::three_axes(frame));
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
