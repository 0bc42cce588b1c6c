//! The costates of a plan as guess for its neighbour: a sweep over durations with a few iterations
//! each, because no more is searched.
//!
//! `cargo run --release --example guess_and_sweep`

use slewkit::{Body, Guess, Inertia, Matrix3, Problem, Settings, Silent, State, Status, Vector3, lie, plan};

fn main() {
    let inertia = Inertia::diagonal(Vector3::new(120.0, 100.0, 80.0)).expect("a physical inertia");
    let body = Body { inertia, mass: None };
    let end = State::at_rest(lie::exp(&Vector3::new(0.4, -0.8, 1.2)));
    let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 60.0);
    let settings = Settings::default();

    let mut guess: Option<Guess> = None;
    let mut products = Vec::new();
    println!("duration  cost        cost·T³      start  iterations");
    for duration in [60.0, 63.0, 66.0, 69.0, 72.0] {
        let problem = problem.clone().with_duration(duration);
        let plan = plan(&problem, &settings, guess.as_ref(), &mut Silent).expect("a valid problem");
        let solution = &plan.solution;
        let product = solution.cost * duration.powi(3);
        println!(
            "{duration:>8}  {:.8}  {product:.4}  {:>5}  {:>10}",
            solution.cost, solution.start, solution.iterations
        );
        assert_eq!(plan.status, Status::Solved);
        assert!(guess.is_none() || solution.start == "guess");
        products.push(product);
        guess = Some(Guess::of(solution, &problem).alone());
    }
    // Time only scales the motion from rest to rest: the cost falls with the cube of the duration.
    assert!(products.iter().all(|product| (product / products[0] - 1.0).abs() < 1e-10));
}

#[test]
fn runs() {
    main();
}
