//! Tests of the lifted Newton method where shooting fails, and where both must agree.

use super::*;
use crate::maneuver::problem::{Problem, Scheme, State};
use crate::mechanics::body::Body;
use crate::mechanics::environment::UniformGravity;
use crate::optimize::methods::descent::Descent;
use crate::optimize::methods::driver::{Report, run};
use crate::optimize::methods::shooting::newton::Newton;
use crate::optimize::search::starts::paths;
use crate::testing::{full_inertia, matrix, reference, vector, with_torques};
use serde_json::Value;

fn solved<const N: usize>(bvp: &BoundaryValueProblem<N>) -> (Nodes<N>, Report) {
    let path = paths::smooth(bvp, "short".into(), &paths::rotation(bvp, 0), paths::straight);
    let (dynamics, start, target) = (&bvp.dynamics, &bvp.start, bvp.terminal.target());
    let inverse = Descent { dynamics, start, target, translates: N == 12, tolerance: 0.0, known: &[] };
    let lifted = Lifted::new(bvp, 1e-12, Nodes::of(&inverse.lifted(path).unwrap())).unwrap();
    let (lifted, report) = run(lifted, 30, &|| None);
    assert_eq!(report.outcome, Outcome::Converged, "{:?}", report.residuals);
    (lifted.nodes, report)
}

fn pendulum(file: &Value) -> UniformGravity {
    UniformGravity::new(1.0, file["mg"].as_f64().unwrap(), Vector3::z(), vector(&file["rho"])).unwrap()
}

#[test]
fn the_unstable_pendulum_is_solved_in_a_few_iterations() {
    let file = reference("unstable_pendulum.json");
    let body = Body { inertia: full_inertia(), mass: None };
    let end = State::at_rest(lie::exp(&vector::<3>(&file["phi"])));
    let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 2.0)
        .with_steps(50)
        .with_scheme(Scheme::LieEuler)
        .with_environment(pendulum(&file));
    let bvp = BoundaryValueProblem::<6>::new(&problem, 50);
    let (nodes, report) = solved(&bvp);
    assert!(report.iterations <= 7, "{} {:?}", report.iterations, report.residuals);
    let units = bvp.dynamics.units;
    let mut cost = 0.0;
    for (k, expected) in file["lambda_all"].as_array().unwrap().iter().enumerate() {
        let expected = vector::<6>(expected);
        let costate = nodes.costates[k + 1].component_mul(&units.costate());
        let error = (costate - expected).amax() / expected.amax();
        assert!(error < 1e-9, "λ_{k}: {error:e}");
        cost += 0.5 * problem.step() * costate.fixed_rows::<3>(3).norm_squared();
    }
    let expected = file["cost"].as_f64().unwrap();
    assert!((cost - expected).abs() < 1e-11 * expected, "{cost}");
}

#[test]
fn lifted_newton_and_shooting_find_the_same_extremals_of_both_schemes() {
    let file = reference("modified_scheme.json");
    for case in file["cases"].as_array().unwrap() {
        for (scheme, key, first) in
            [(Scheme::LieEuler, "lie_euler", "lambda0"), (Scheme::LieVerlet, "modified", "lambda_minus1")]
        {
            let inertia = full_inertia();
            let state = |r: &str, pi: &str| {
                State::attitude(matrix(&file[r]), inertia.j_inverse() * vector::<3>(&file[pi]))
            };
            let (start, end) = (state("R0", "Pi0"), state("Rd", "Pid"));
            let body = Body { inertia: inertia.clone(), mass: None };
            let mut problem = Problem::attitude(body, start, end, file["T"].as_f64().unwrap())
                .with_steps(case["N"].as_u64().unwrap() as usize)
                .with_scheme(scheme);
            problem = with_torques(problem, &Matrix3::identity(), &matrix(&file["W"]));
            if case["potential"] == "pendulum" {
                problem = problem.with_environment(pendulum(&file["pendulum"]));
            }
            let bvp = BoundaryValueProblem::<6>::new(&problem, problem.steps);
            let (nodes, _) = solved(&bvp);
            let index = usize::from(scheme == Scheme::LieEuler);
            let costate = nodes.costates[index].component_mul(&bvp.dynamics.units.costate());
            let expected = vector::<6>(&case[key][first]);
            let error = (costate - expected).amax() / expected.amax();
            assert!(error < 1e-11, "{scheme:?} {} {}: {error:e}", case["potential"], case["N"]);

            let newton = Newton::new(&bvp, 1e-13, SVector::zeros(), None).unwrap();
            let (newton, report) = run(newton, 30, &|| None);
            assert_eq!(report.outcome, Outcome::Converged);
            let error = (newton.costate - nodes.costates[0]).amax() / newton.costate.amax();
            assert!(error < 1e-11, "{scheme:?}: {error:e}");
        }
    }
}
