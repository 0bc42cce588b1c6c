//! The discrete witness against reference vectors and closed forms.

use super::support::*;

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
        // Lie–Euler runs late by h/2: from rest to rest an error of second order, on the way there
        // one of first.
        assert!((order - 1.0).abs() < 0.1, "{name}: order {order}");
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
