//! Helper functions of the planner's tests.

use slewkit::maneuver::objective::Weights;
use slewkit::maneuver::problem::{Problem, State};
use slewkit::maneuver::settings::Settings;
use slewkit::maneuver::solution::{Outcome, Solution};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::optimize::search::solve;
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};

/// Returns the full inertia of the reference files.
pub fn full_inertia() -> Inertia {
    Inertia::new(Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)).unwrap()
}

pub fn full_body() -> Body {
    Body { inertia: full_inertia(), mass: None }
}

/// Returns diagonal weights of three torques.
pub fn weighted(weight: [f64; 3]) -> Weights {
    Weights::of_torques(nalgebra::DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(&weight)))
}

/// Returns a slew from rest to rest about (1, 2, −0.5) in 2 s.
pub fn rest_to_rest(degrees: f64) -> Problem {
    let axis = Vector3::new(1.0, 2.0, -0.5).normalize();
    let end = State::at_rest(lie::exp(&(axis * degrees.to_radians())));
    Problem::attitude(full_body(), State::at_rest(Matrix3::identity()), end, 2.0).with_steps(50)
}

/// Returns a solve that must converge.
pub fn solved(problem: &Problem) -> Solution {
    let solution = solve(problem, &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!(solution.outcome, Outcome::Converged, "{:?}", solution.ladder);
    assert!(solution.terminal.largest() <= 1e-12);
    solution
}

/// Returns a plan that must be solved and verified.
pub fn planned(problem: &Problem) -> Plan {
    let plan = plan(problem, &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!(plan.status, Status::Solved, "{:?} {:?}", plan.solution.ladder, plan.verification);
    plan
}

/// Asserts that `a` and `b` agree to `limit`, relative to the largest of `b`.
pub fn assert_close(name: &str, a: &[f64], b: &[f64], limit: f64) {
    assert_eq!(a.len(), b.len(), "{name}");
    let size = b.iter().fold(0.0f64, |size, value| size.max(value.abs()));
    let error = a.iter().zip(b).fold(0.0f64, |error, (x, y)| error.max((x - y).abs()));
    assert!(error <= limit * size, "{name}: {:e}", error / size);
}

/// Returns the cost on ever finer grids, extrapolated: the scheme is of second order, in even
/// powers.
pub fn extrapolated(problem: &Problem, steps: usize) -> f64 {
    let cost = |steps: usize| {
        let found =
            plan(&problem.clone().with_steps(steps), &Settings::discrete(), None, &mut Silent).unwrap();
        assert_eq!(found.status, Status::Solved, "{:?} {:?}", found.verification, found.solution.shortfall);
        assert!(found.solution.terminal.largest() < 1e-12);
        println!(
            "{steps} steps: {:.12}, stationary to {:.1e}, rivals {:?}",
            found.solution.cost,
            found.solution.optimality.stationarity,
            found.solution.rivals.iter().map(|rival| rival.cost).collect::<Vec<_>>()
        );
        found.solution.cost
    };
    let [a, b, c] = [1, 2, 4].map(|times| cost(times * steps));
    let [first, second] = [(4.0 * b - a) / 3.0, (4.0 * c - b) / 3.0];
    (16.0 * second - first) / 15.0
}
