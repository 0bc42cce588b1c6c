//! The matrices of a step compared with files of reference values, computed by another program.

use crate::Vector3;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Problem, Scheme, State};
use crate::mechanics::body::{Body, Inertia};
use crate::mechanics::environment::{
    CentralGravity, GravityGradient, PointMass, Pose, UniformGravity, Wrench,
};
use crate::optimize::discrete::step::{Costate, Dynamics, Linearization};
use crate::testing::{matrix, reference, vector, weight, with_torques};
use nalgebra::{SMatrix, SVector};
use serde_json::Value;

const STEPS: usize = 20;

/// Returns the SI units of states and of costates.
fn units<const N: usize>(dynamics: &Dynamics) -> (SVector<f64, N>, SVector<f64, N>) {
    let units = dynamics.units;
    let translation = [units.length, units.linear_momentum()];
    let state = SVector::from_fn(|row, _| {
        let pair = if N == 12 && row < 6 { translation } else { [1.0, units.momentum()] };
        pair[row % 6 / 3]
    });
    (state, units.costate())
}

/// Converts the rows and columns of `matrix` to SI units.
fn si<const N: usize>(
    rows: &SVector<f64, N>,
    scaled: &SMatrix<f64, N, N>,
    columns: &SVector<f64, N>,
) -> SMatrix<f64, N, N> {
    SMatrix::from_diagonal(rows) * scaled * SMatrix::from_diagonal(&columns.map(|unit| 1.0 / unit))
}

fn close<const R: usize, const C: usize>(
    name: &str,
    found: &SMatrix<f64, R, C>,
    expected: &SMatrix<f64, R, C>,
    limit: f64,
) {
    let error = (found - expected).amax() / expected.amax().max(1.0);
    assert!(error <= limit, "{name}: {error:e}");
}

/// Builds a problem of the case's kind that starts at its state (R, Π).
fn problem(file: &Value, case: &Value) -> Problem {
    let inertia = Inertia::new(matrix(&file["J"])).unwrap();
    let state = State::attitude(matrix(&case["R"]), inertia.j_inverse() * vector::<3>(&case["Pi"]));
    let body = Body { inertia: inertia.clone(), mass: None };
    let duration = file["h"].as_f64().unwrap() * STEPS as f64;
    let problem =
        Problem::attitude(body, state, state, duration).with_steps(STEPS).with_scheme(Scheme::LieEuler);
    let problem = with_torques(problem, &matrix(&file["B"]), &matrix(&file["W"]));
    // The force fields of the file are those of trajectories.json.
    let fields = reference("trajectories.json");
    match case["potential"].as_str().unwrap() {
        "free" => problem,
        "pendulum" => {
            let (weight, arm) =
                (fields["pendulum"]["mg"].as_f64().unwrap(), vector(&fields["pendulum"]["rho"]));
            problem.with_environment(UniformGravity::new(1.0, weight, Vector3::z(), arm).unwrap())
        }
        "gravity_gradient" => {
            let field = &fields["gravity_gradient"];
            let (rate, outward) = (field["n2"].as_f64().unwrap().sqrt(), vector(&field["o"]));
            problem.with_environment(GravityGradient::along_fixed_direction(rate, &inertia, outward).unwrap())
        }
        other => panic!("unknown potential {other}"),
    }
}

#[test]
fn one_step_and_its_matrices_meet_the_reference() {
    let file = reference("linearisation.json");
    for case in file["cases"].as_array().unwrap() {
        let problem = problem(&file, case);
        let dynamics = Dynamics::new(&problem, STEPS);
        let (state, costate) = units::<6>(&dynamics);
        let start = dynamics.point(&problem.start);
        let lambda: SVector<f64, 6> = vector::<6>(&case["lam"]).component_div(&costate);
        let step = dynamics.transition::<6>(0, &start, &lambda).unwrap();
        let Linearization { a, h, q } = &step.linear;
        let mut drifted = start;
        let drift = dynamics.drift::<6>(0, &mut drifted).unwrap();
        close("F", &drift.f, &matrix(&case["F"]), 1e-13);
        let a_si = si(&state, a, &state);
        close("A", &a_si, &matrix(&case["A"]), 1e-13);
        close("B", &a_si.fixed_view::<3, 3>(0, 3).into_owned(), &matrix(&case["Bk"]), 1e-13);
        close("A⁻¹", &a_si.try_inverse().unwrap(), &matrix(&case["A_inv"]), 1e-13);
        close("H", &si(&costate, h, &state), &matrix(&case["H_with_lam"]), 1e-13);
        let before = step.costate_before.component_mul(&costate);
        close("Aᵀλ", &before, &vector(&case["At_lam"]), 1e-13);
        let weights = problem.objective.weights();
        let pi = vector::<3>(&case["lam"].as_array().unwrap()[3..].into());
        let inputs = -(weights.torque(&problem.actuation).gain * pi);
        close("u", &Vector3::from_column_slice(inputs.as_slice()), &vector(&case["u_next"]), 1e-13);

        // M_R and N(p) at the new attitude.
        let pose = Pose { position: Vector3::zeros(), attitude: drifted.attitude.value };
        close("M_R", &problem.environment.gradient(&pose).rr, &matrix(&case["MR"]), 1e-13);
        let p = Vector3::new(
            case["lam"][3].as_f64().unwrap(),
            case["lam"][4].as_f64().unwrap(),
            case["lam"][5].as_f64().unwrap(),
        );
        let dual = Wrench { force: Vector3::zeros(), moment: p };
        close("N", &problem.environment.curvature(&pose, &dual).rr, &matrix(&case["N_p"]), 1e-13);
        let c = a_si.fixed_view::<3, 3>(3, 3)
            - problem.step() * matrix::<3, 3>(&case["MR"]) * matrix::<3, 3>(&case["Bk"]);
        close("C", &c, &matrix(&case["C"]), 1e-13);

        // The end of the step, and the blocks that couple it to the next step.
        close("R⁺", &step.end.attitude.value, &matrix(&case["R1"]), 1e-13);
        let momentum = step.end.momentum.value * dynamics.units.momentum();
        close("Π⁺", &momentum, &vector(&case["Pi1"]), 1e-13);
        let next_lambda = vector::<6>(&case["lam1"]).component_div(&costate);
        let next = dynamics.transition::<6>(0, &step.end, &next_lambda).unwrap();
        close("λ of λ⁺", &next.costate_before, &lambda, 1e-13);
        let mut after = step.end;
        let drift = dynamics.drift::<6>(0, &mut after).unwrap();
        let e = dynamics.drift_matrix(&drift);
        let mut forward = drift.costate::<6>(&e, &Costate::from_vector(&lambda));
        let kick = dynamics.kick::<6>(&after.pose(), &forward);
        kick.apply::<6>(&mut after, &mut forward, dynamics.grid.step(0), dynamics.grid.step(0));
        close("λ⁺ of λ", &forward.to_vector(), &next_lambda, 1e-13);
        close("H⁺", &si(&costate, &next.linear.h, &state), &matrix(&case["H1_with_lam1"]), 1e-13);
        let back = next.linear.a.try_inverse().unwrap().transpose();
        close("A12", &si(&state, &-q, &costate), &matrix(&case["A12"]), 1e-13);
        let a21 = -back * next.linear.h * a;
        close("A21", &si(&costate, &a21, &state), &matrix(&case["A21"]), 1e-13);
        let a22 = back * (SMatrix::<f64, 6, 6>::identity() + next.linear.h * q);
        close("A22", &si(&costate, &a22, &costate), &matrix(&case["A22"]), 1e-13);
    }
}

#[test]
fn one_step_of_a_dumbbell_in_orbit_meets_the_reference() {
    let file = reference("min_energy_se3.json");
    let point = &file["linearisation"];
    let inertia = Inertia::new(matrix(&file["J"])).unwrap();
    let masses = file["k"].as_array().unwrap();
    let points = file["rho"].as_array().unwrap().iter().zip(masses);
    let points = points
        .map(|(place, k)| PointMass { parameter: k.as_f64().unwrap(), position: vector(place) })
        .collect();
    let state = State {
        position: vector(&point["x"]),
        velocity: vector(&point["gamma"]),
        attitude: matrix(&point["R"]),
        angular_velocity: inertia.j_inverse() * vector::<3>(&point["Pi"]),
    };
    let body = Body { inertia, mass: Some(1.0) };
    let mut problem = Problem::rigid_body(body, state, state, file["T"].as_f64().unwrap())
        .with_steps(50)
        .with_scheme(Scheme::LieEuler)
        .with_environment(CentralGravity::new(points).unwrap());
    let Objective::Effort(weights) = &mut problem.objective else { unreachable!("effort") };
    weights.force = Some(weight(&matrix(&file["Wf"])));
    let dynamics = Dynamics::new(&problem, 50);
    let (state, costate) = units::<12>(&dynamics);
    let lambda = vector::<12>(&point["lam"]).component_div(&costate);
    let step = dynamics.transition::<12>(0, &dynamics.point(&problem.start), &lambda).unwrap();
    let a = si(&state, &step.linear.a, &state);
    close("A", &a, &matrix(&point["A"]), 1e-12);
    close("A⁻¹", &a.try_inverse().unwrap(), &matrix(&point["A_inv"]), 1e-12);
    close("H", &si(&costate, &step.linear.h, &state), &matrix(&point["H"]), 1e-12);
}
