//! Plan a rest-to-rest slew in a few lines: body, ends, duration; then read cost, proof and
//! torques.
//!
//! `cargo run --release --example plan_a_slew`

use slewkit::{Body, Inertia, Matrix3, Problem, Settings, Silent, State, Status, Vector3, lie, plan};

fn main() {
    let inertia = Inertia::new(Matrix3::new(120.0, 4.0, -3.0, 4.0, 100.0, 2.0, -3.0, 2.0, 80.0))
        .expect("a physical inertia");
    let body = Body { inertia, mass: None };
    let target = lie::exp(&Vector3::new(0.4, -0.8, 1.2));
    let (start, end) = (State::at_rest(Matrix3::identity()), State::at_rest(target));
    let problem = Problem::attitude(body, start, end, 60.0).with_steps(120);

    let plan = plan(&problem, &Settings::default(), None, &mut Silent).expect("a valid problem");

    let solution = &plan.solution;
    let verification = plan.verification.expect("a converged plan is judged");
    println!("status            {}", plan.status.name());
    println!("cost              {:.6} N²m²s", solution.cost);
    println!("first torque      {:.4?} N·m", solution.trajectory.torque[0].as_slice());
    println!("end, by solver    {:.1e}", solution.terminal.largest());
    println!("end, by witness   {:.1e}", verification.discrete().largest());
    println!("conjugate points  {:?}", solution.optimality.conjugate_points);

    assert_eq!(plan.status, Status::Solved);
    assert!(solution.terminal.largest() < 1e-12 && verification.discrete().largest() < 1e-12);
    assert_eq!(solution.optimality.conjugate_points, Some(0));
    // The double integrator about a fixed axis costs 6 J²θ²/T³: a bound of the right size.
    let eigenaxis = 6.0 * (120.0 * lie::log(&target).norm()).powi(2) / 60.0f64.powi(3);
    assert!(solution.cost < 1.1 * eigenaxis, "{} against {eigenaxis}", solution.cost);
}

#[test]
fn runs() {
    main();
}
