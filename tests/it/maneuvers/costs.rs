//! Published costs, through the library.

use super::support::{full_body, planned, rest_to_rest};
use serde_json::Value;
use slewkit::maneuver::problem::{Path, Problem, Scheme, State};
use slewkit::maneuver::settings::Settings;
use slewkit::maneuver::solution::Outcome;
use slewkit::optimize::search::solve;
use slewkit::plan::{Guess, Silent};
use slewkit::{Matrix3, Vector3, lie};

#[test]
fn rest_to_rest_costs_from_30_to_179_degrees_are_the_published_ones() {
    // Lie–Euler, N = 50, W = I.
    let published = [
        (30.0, 0.74856570),
        (60.0, 2.93602414),
        (90.0, 6.36913417),
        (120.0, 10.69296806),
        (150.0, 15.42862709),
        (170.0, 18.54042593),
        (179.0, 19.86272060),
    ];
    for (degrees, cost) in published {
        let problem = rest_to_rest(degrees).with_scheme(Scheme::LieEuler).with_path(Path::Shortest);
        let plan = planned(&problem);
        assert!((plan.solution.cost - cost).abs() < 6e-9, "{degrees}°: {}", plan.solution.cost);
        assert_eq!(plan.solution.optimality.conjugate_points, Some(0));
        let best = planned(&problem.with_path(Path::Best)).solution;
        assert!(best.cost <= cost + 6e-9, "{degrees}°");
    }
}

#[test]
fn the_published_windings_are_extremals_and_nothing_dearer_is_found() {
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reference/windings.json"))
            .unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    for case in file["cases"].as_array().unwrap() {
        let phi = Vector3::from_fn(|row, _| case["phi"][row].as_f64().unwrap());
        let degrees = case["angle_deg"].as_f64().unwrap();
        let end = State::at_rest(lie::exp(&phi));
        let problem = Problem::attitude(full_body(), State::at_rest(Matrix3::identity()), end, 2.0)
            .with_steps(50)
            .with_scheme(Scheme::LieEuler);
        let expected = case["cost"].as_f64().unwrap();
        let short = degrees > 0.0 && degrees < 180.0;

        // The published extremal itself, from its costates.
        let lambda_0: Vec<f64> = (0..6).map(|row| case["lambda0"][row].as_f64().unwrap()).collect();
        let solution =
            solve(&problem, &Settings::discrete(), Some(&Guess::costates(&lambda_0)), &mut Silent).unwrap();
        assert_eq!((solution.outcome, solution.start.as_str()), (Outcome::Converged, "guess"));
        let error = (solution.cost - expected).abs() / expected;
        assert!(error < 1e-12, "{degrees}°: {}, not {expected}", solution.cost);
        let negative = case["negative_eigenvalues"].as_u64().unwrap() as usize;
        assert_eq!(solution.optimality.conjugate_points, Some(negative), "{degrees}°");

        // A cold search finds that one, or a cheaper one that winds as much (−600° has one of
        // 437.1).
        let found = planned(&problem.clone().with_path(Path::AsGiven(phi))).solution;
        assert!(found.cost < expected * (1.0 + 1e-10), "{degrees}°: {}", found.cost);
        assert!(short || found.cost > 4.0 * 10.69296806, "{degrees}°: {}", found.cost);
        if short {
            for path in [Path::Shortest, Path::Best] {
                let found = planned(&problem.clone().with_path(path)).solution;
                assert!((found.cost - expected).abs() < 1e-10 * expected, "{path:?}: {}", found.cost);
            }
        }
    }
}
