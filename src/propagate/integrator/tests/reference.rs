//! Tests against values of one and five steps that were computed by other programs.

use super::*;
use crate::mechanics::environment::{Environment, Free, GravityGradient};

#[test]
fn five_controlled_steps_meet_the_reference() {
    let file = reference("trajectories.json");
    let (b, h) = (matrix::<3, 3>(&file["B"]), file["h"].as_f64().unwrap());
    let torques: Vec<Vector3> = file["u"].as_array().unwrap().iter().map(|u| b * vector::<3>(u)).collect();
    let o = vector::<3>(&file["gravity_gradient"]["o"]);
    let rate = file["gravity_gradient"]["n2"].as_f64().unwrap().sqrt();
    let gradient = GravityGradient::along_fixed_direction(rate, &full_inertia(), o).unwrap();
    let mg = file["pendulum"]["mg"].as_f64().unwrap();
    let gravity = UniformGravity::new(1.0, mg, Vector3::z(), vector(&file["pendulum"]["rho"])).unwrap();
    let fields: [(&str, Arc<dyn Environment>); 3] =
        [("free", Arc::new(Free)), ("pendulum", Arc::new(gravity)), ("gravity_gradient", Arc::new(gradient))];
    let kinds = [
        ("lie_euler", Kind::LieEuler),
        ("velocity_verlet", Kind::LieVerlet),
        ("velocity_verlet", Kind::LieVerletLagrangian),
    ];
    for (name, field) in fields {
        let system = System::single(attitude_body(), field).unwrap();
        let state = super::start(&system, &matrix(&file["R0"]), vector(&file["Pi0"]));
        for (key, kind) in kinds {
            let rows = file["trajectories"][name][key].as_array().unwrap();
            let mut method = method(kind, &system, &state, h);
            for (k, row) in rows.iter().enumerate() {
                if k > 0 {
                    let torque = |index: usize| Wrench { moment: torques[index], ..Wrench::zero() };
                    method.step(&[Input { start: torque(k - 1), end: torque(k) }]).unwrap();
                }
                let (pose, momentum) = (method.state().poses()[0], method.state().momenta()[0]);
                let error = (pose.attitude - matrix::<3, 3>(&row["R"])).amax();
                assert!(error < 1e-14, "{kind} {name} step {k}: R {error:e}");
                let error = (momentum.angular - vector::<3>(&row["Pi"])).amax();
                assert!(error < 1e-14, "{kind} {name} step {k}: Π {error:e}");
            }
        }
    }
}

#[test]
fn five_steps_of_two_dumbbells_meet_the_reference() {
    let file = reference("full_body.json");
    let system = dumbbells(3.0, 1.0).0;
    let rows = file["states"].as_array().unwrap();
    let inertias = file["J"].as_array().unwrap();
    for (body, j) in system.bodies().iter().zip(inertias) {
        assert!((body.inertia.j() - matrix::<3, 3>(j)).amax() < 1e-16);
    }
    let states = [0, 1].map(|body| State {
        position: vector(&rows[0]["x"][body]),
        velocity: vector::<3>(&rows[0]["gamma"][body]) / system.bodies()[body].mass.unwrap(),
        attitude: matrix(&rows[0]["R"][body]),
        angular_velocity: system.bodies()[body].inertia.j_inverse() * vector::<3>(&rows[0]["Pi"][body]),
    });
    let state = system.state(&states).unwrap();
    for kind in [Kind::LieVerlet, Kind::LieVerletLagrangian] {
        let mut method = method(kind, &system, &state, file["h"].as_f64().unwrap());
        for (k, row) in rows.iter().enumerate() {
            if k > 0 {
                method.step(&[]).unwrap();
            }
            let state = method.state();
            for body in 0..2 {
                let (pose, momentum) = (state.poses()[body], state.momenta()[body]);
                let errors = [
                    (pose.position - vector::<3>(&row["x"][body])).amax(),
                    (momentum.linear - vector::<3>(&row["gamma"][body])).amax(),
                    (pose.attitude - matrix::<3, 3>(&row["R"][body])).amax(),
                    (momentum.angular - vector::<3>(&row["Pi"][body])).amax(),
                ];
                assert!(errors.iter().all(|error| *error < 1e-13), "{kind} step {k}: {errors:?}");
            }
            let energy = system.invariants(state).energy - file["energies"][k].as_f64().unwrap();
            assert!(energy.abs() < 1e-13, "{kind} step {k}: energy {energy:e}");
            let momentum = system.invariants(state).angular_momentum;
            assert!((momentum - vector::<3>(&file["angular_momentum0"])).amax() < 1e-13);
        }
    }
}
