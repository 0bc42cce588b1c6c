//! The order of both schemes, compared with the continuous optimum by an independent method.
//!
//! The continuous Pontryagin equations
//!
//! ```text
//! Ṙ = R S(Ω) ,  Π̇ = Π × Ω + M + u ,  u = −W⁻¹λ^Π
//! λ̇^R = λ^R × Ω − M_Rᵀ λ^Π ,   λ̇^Π = −J⁻¹λ^R − Ω × λ^Π − J⁻¹(λ^Π × Π) ,   ċ = ½ uᵀWu
//! ```
//!
//! are integrated by Verner's 9(8) pair and shot by Newton with differences.

use super::support::{full_body, solved, weighted};
use differential_equations::methods::ExplicitRungeKutta;
use differential_equations::prelude::*;
use nalgebra::{SMatrix, SVector};
use serde_json::Value;
use slewkit::maneuver::problem::{Path, Problem, Scheme, State};
use slewkit::mechanics::environment::{Pose, UniformGravity};
use slewkit::{Matrix3, Vector3, lie};

const WEIGHT: [f64; 3] = [1.0, 2.0, 0.5];

/// `[R by columns (9), Π, λ^R, λ^Π, cost]`.
type Y = [f64; 19];

struct Pontryagin<'a> {
    problem: &'a Problem,
}

fn part(y: &Y, at: usize) -> Vector3 {
    Vector3::new(y[at], y[at + 1], y[at + 2])
}

impl ODE<f64, Y> for Pontryagin<'_> {
    fn diff(&self, _: f64, y: &Y, dydt: &mut Y) {
        let inertia = &self.problem.body.inertia;
        let r = Matrix3::from_column_slice(&y[..9]);
        let (pi, zeta, p) = (part(y, 9), part(y, 12), part(y, 15));
        let omega = inertia.j_inverse() * pi;
        let pose = Pose { position: Vector3::zeros(), attitude: r };
        let field = &self.problem.environment;
        let u = -p.component_div(&Vector3::from(WEIGHT));
        let zeta_dot = zeta.cross(&omega) - field.gradient(&pose).rr.tr_mul(&p);
        let p_dot = -(inertia.j_inverse() * (zeta + p.cross(&pi))) - omega.cross(&p);
        dydt[..9].copy_from_slice((r * lie::hat(&omega)).as_slice());
        dydt[9..12].copy_from_slice((pi.cross(&omega) + field.wrench(&pose).moment + u).as_slice());
        dydt[12..15].copy_from_slice(zeta_dot.as_slice());
        dydt[15..18].copy_from_slice(p_dot.as_slice());
        dydt[18] = 0.5 * u.dot(&u.component_mul(&Vector3::from(WEIGHT)));
    }
}

/// The continuous optimum: cost, and the control at `nodes + 1` equidistant times.
struct Optimum {
    cost: f64,
    control: Vec<Vector3>,
}

impl Optimum {
    fn new(problem: &Problem, guess: &[f64], nodes: usize) -> Self {
        let mut lambda = SVector::<f64, 6>::from_row_slice(guess);
        for _ in 0..12 {
            let (error, _) = Self::shoot(problem, &lambda, 1);
            if error.amax() < 1e-12 {
                break;
            }
            let step = 1e-4;
            let slope = SMatrix::<f64, 6, 6>::from_fn(|row, column| {
                let at = |sign: f64| {
                    let mut moved = lambda;
                    moved[column] += sign * step;
                    Self::shoot(problem, &moved, 1).0[row]
                };
                (at(1.0) - at(-1.0)) / (2.0 * step)
            });
            lambda -= slope.lu().solve(&error).unwrap();
        }
        let (error, found) = Self::shoot(problem, &lambda, nodes);
        assert!(error.amax() < 1e-11, "{error}");
        found
    }

    fn shoot(problem: &Problem, lambda: &SVector<f64, 6>, nodes: usize) -> (SVector<f64, 6>, Self) {
        let j = problem.body.inertia.j();
        let mut y = [0.0; 19];
        y[..9].copy_from_slice(problem.start.attitude.as_slice());
        y[9..12].copy_from_slice((j * problem.start.angular_velocity).as_slice());
        y[12..18].copy_from_slice(lambda.as_slice());
        let control = |y: &Y| -part(y, 15).component_div(&Vector3::from(WEIGHT));
        let mut controls = vec![control(&y)];
        let h = problem.seconds() / nodes as f64;
        for _ in 0..nodes {
            let system = Pontryagin { problem };
            let method = ExplicitRungeKutta::rkv988e().rtol(1e-13).atol(1e-13);
            y = *IVP::ode(&system, 0.0, h, y).method(method).solve().unwrap().y.last().unwrap();
            controls.push(control(&y));
        }
        let r = Matrix3::from_column_slice(&y[..9]);
        let turn = lie::log(&problem.end.attitude.tr_mul(&r));
        let momentum = part(&y, 9) - j * problem.end.angular_velocity;
        let error = SVector::from_iterator(turn.iter().chain(momentum.iter()).copied());
        (error, Self { cost: y[18], control: controls })
    }
}

/// Returns the maneuver of modified_scheme.json: both ends move.
fn moving_ends(file: &Value, field: &str) -> Problem {
    let vector = |value: &Value| Vector3::from_fn(|row, _| value[row].as_f64().unwrap());
    let matrix = |value: &Value| Matrix3::from_fn(|row, column| value[row][column].as_f64().unwrap());
    let body = full_body();
    let state =
        |r: &str, pi: &str| State::attitude(matrix(&file[r]), body.inertia.j_inverse() * vector(&file[pi]));
    let (start, end) = (state("R0", "Pi0"), state("Rd", "Pid"));
    let problem = Problem::attitude(body.clone(), start, end, file["T"].as_f64().unwrap())
        .with_objective(weighted(WEIGHT))
        .with_path(Path::Shortest);
    if field == "free" {
        return problem;
    }
    let (weight, arm) = (file["pendulum"]["mg"].as_f64().unwrap(), vector(&file["pendulum"]["rho"]));
    problem.with_environment(UniformGravity::new(1.0, weight, Vector3::z(), arm).unwrap())
}

/// Returns the slope of `log error` over `log h` between the first and the last grid.
fn slope(errors: &[f64], steps: &[usize]) -> f64 {
    let last = errors.len() - 1;
    (errors[0] / errors[last]).ln() / (steps[last] as f64 / steps[0] as f64).ln()
}

#[test]
fn cost_and_control_converge_at_the_order_of_the_scheme() {
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/reference/modified_scheme.json"
    ))
    .unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    // Grids fine enough for the leading term to rule (the first-order term of the pendulum's cost
    // is small) and coarse enough to stay above round-off.
    let grids = [(Scheme::LieEuler, 1.0, [1280, 2560, 5120]), (Scheme::LieVerlet, 2.0, [80, 160, 320])];
    const NODES: usize = 5120;
    for (field, published) in [("free", 6.448306071999), ("pendulum", 6.394265178994)] {
        let problem = moving_ends(&file, field);
        let guess = solved(&problem.clone().with_steps(NODES));
        let optimum = Optimum::new(&problem, guess.costates_0(&problem), NODES);
        assert!((optimum.cost - published).abs() < 2e-11, "{field}: {}", optimum.cost);
        for (scheme, order, steps) in grids {
            let (mut costs, mut controls) = (Vec::new(), Vec::new());
            for count in steps {
                let solution = solved(&problem.clone().with_steps(count).with_scheme(scheme));
                costs.push((solution.cost - optimum.cost).abs());
                let first = count + 1 - scheme.input_rows(count);
                let rows = (first..=count).map(|node| {
                    let expected = optimum.control[node * NODES / count];
                    let input = Vector3::from_column_slice(solution.trajectory.inputs(node - first));
                    (input - expected).amax()
                });
                controls.push(rows.fold(0.0, f64::max));
            }
            for (name, errors) in [("cost", &costs), ("control", &controls)] {
                let found = slope(errors, &steps);
                assert!((found - order).abs() < 0.1, "{field} {scheme:?} {name}: {found} {errors:?}");
            }
        }
    }
}
