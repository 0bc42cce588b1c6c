//! The sweep compared with reference values and finite differences, and tested by the first-order
//! conditions.

use super::*;
use crate::Matrix3;
use crate::lie;
use crate::maneuver::objective::Weights;
use crate::maneuver::problem::{Motion, Scheme, State};
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame};
use crate::mechanics::body::{Body, Inertia};
use crate::mechanics::environment::{CentralGravity, GravityGradient, PointMass, UniformGravity};
use crate::numerics::factor::Factor;
use crate::testing::{
    Random, attitude_only, channel, graded, limited, matrix, moving_ends, reference, vector, weight,
    with_torques,
};
use serde_json::Value;

/// Returns the units of the state: scaled value times unit is the SI value.
fn state_units<const N: usize>(dynamics: &Dynamics) -> SVector<f64, N> {
    let units = dynamics.units;
    let translation = [units.length, units.linear_momentum()];
    SVector::from_fn(|row, _| {
        let pair = if N == 12 && row < 6 { translation } else { [1.0, units.momentum()] };
        pair[row % 6 / 3]
    })
}

fn to_si<const N: usize>(
    rows: &SVector<f64, N>,
    scaled: &SMatrix<f64, N, N>,
    columns: &SVector<f64, N>,
) -> SMatrix<f64, N, N> {
    SMatrix::from_diagonal(rows) * scaled * SMatrix::from_diagonal(&columns.map(|unit| 1.0 / unit))
}

/// Builds a problem from a case of min_energy_so3.json.
fn so3_case(case: &Value) -> Problem {
    let inertia = Inertia::new(matrix(&case["J"])).unwrap();
    let start = State::attitude(matrix(&case["R0"]), inertia.j_inverse() * vector::<3>(&case["Pi0"]));
    let end = State::attitude(matrix(&case["Rd"]), inertia.j_inverse() * vector::<3>(&case["Pid"]));
    let body = Body { inertia, mass: None };
    let problem = Problem::attitude(body, start, end, case["T"].as_f64().unwrap())
        .with_steps(case["N"].as_u64().unwrap() as usize)
        .with_scheme(Scheme::LieEuler);
    let problem = with_torques(problem, &matrix(&case["B"]), &matrix(&case["W"]));
    if case["potential"].as_str().unwrap().eq_ignore_ascii_case("free") {
        return problem;
    }
    problem.with_environment(pendulum(1.7, Vector3::new(0.1, -0.2, 0.9)))
}

fn pendulum(weight: f64, arm: Vector3) -> UniformGravity {
    UniformGravity::new(1.0, weight, Vector3::z(), arm).unwrap()
}

/// Returns `λ_{−1}` (scaled) from `λ_0` (SI), and `A_0ᵀ`, scaled.
fn before_first<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate_0: &SVector<f64, N>,
) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
    let scaled = costate_0.component_div(&bvp.dynamics.units.costate());
    let step = bvp.dynamics.transition::<N>(0, &bvp.start, &scaled).unwrap();
    (step.costate_before, step.linear.a.transpose())
}

#[test]
fn published_costates_solve_the_attitude_maneuvers() {
    for case in reference("min_energy_so3.json")["cases"].as_array().unwrap() {
        let bvp = BoundaryValueProblem::<6>::new(&so3_case(case), case["N"].as_u64().unwrap() as usize);
        let (costate, a_t) = before_first(&bvp, &vector(&case["lambda0"]));
        let (end, psi) = bvp.sweep_linearized(&costate).unwrap();
        assert!(end.error.amax() < 1e-13, "{}: {}", case["name"], end.error);
        let cost = end.cost * bvp.dynamics.units.cost;
        let expected = case["cost"].as_f64().unwrap();
        assert!((cost - expected).abs() < 1e-12 * expected, "{cost} {expected}");
        let psi = to_si(&state_units(&bvp.dynamics), &(psi * a_t), &bvp.dynamics.units.costate());
        let expected = matrix::<6, 6>(&case["Psi12"]);
        assert!((psi - expected).amax() < 1e-12 * expected.amax(), "{psi}{expected}");
    }
}

fn dumbbell(file: &Value) -> Problem {
    let inertia = Inertia::new(matrix(&file["J"])).unwrap();
    let masses = file["k"].as_array().unwrap();
    let points = file["rho"].as_array().unwrap().iter().zip(masses).map(|(position, parameter)| PointMass {
        parameter: parameter.as_f64().unwrap(),
        position: vector(position),
    });
    let gravity = CentralGravity::new(points.collect()).unwrap();
    let state = |x: &str, gamma: &str, r: &str, pi: &str| State {
        position: vector(&file[x]),
        velocity: vector(&file[gamma]),
        attitude: matrix(&file[r]),
        angular_velocity: inertia.j_inverse() * vector::<3>(&file[pi]),
    };
    let (start, end) = (state("x0", "gamma0", "R0", "Pi0"), state("xd", "gammad", "Rd", "Pid"));
    let body = Body { inertia: inertia.clone(), mass: Some(1.0) };
    Problem::rigid_body(body, start, end, file["T"].as_f64().unwrap())
        .with_steps(50)
        .with_scheme(Scheme::LieEuler)
        .with_environment(gravity)
}

#[test]
fn published_costates_solve_the_dumbbell_transfer() {
    let file = reference("min_energy_se3.json");
    let bvp = BoundaryValueProblem::<12>::new(&dumbbell(&file), 50);
    let (costate, a_t) = before_first(&bvp, &vector(&file["lambda0"]));
    let (end, psi) = bvp.sweep_linearized(&costate).unwrap();
    assert!(end.error.amax() < 2e-13, "{}", end.error);
    let cost = end.cost * bvp.dynamics.units.cost;
    assert!((cost - file["cost"].as_f64().unwrap()).abs() < 1e-14, "{cost}");
    let psi = to_si(&state_units(&bvp.dynamics), &(psi * a_t), &bvp.dynamics.units.costate());
    let expected = matrix::<12, 12>(&file["Psi12"]);
    assert!((psi - expected).amax() < 1e-11 * expected.amax(), "{:e}", (psi - expected).amax());
}

#[test]
fn modified_scheme_meets_its_reference() {
    let file = reference("modified_scheme.json");
    for case in file["cases"].as_array().unwrap() {
        let mut setup = file.clone();
        setup["B"] = serde_json::json!([[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
        setup["N"] = case["N"].clone();
        setup["potential"] = case["potential"].clone();
        let problem = so3_case(&setup).with_scheme(Scheme::LieVerlet);
        let bvp = BoundaryValueProblem::<6>::new(&problem, problem.steps);
        let modified = &case["modified"];
        let units = bvp.dynamics.units;
        let costate = vector::<6>(&modified["lambda_minus1"]).component_div(&units.costate());
        let (end, psi) = bvp.sweep_linearized(&costate).unwrap();
        assert!(end.error.amax() < 1e-13, "{}", end.error);
        let (cost, expected) = (end.cost * units.cost, modified["cost"].as_f64().unwrap());
        assert!((cost - expected).abs() < 1e-12 * expected, "{cost} {expected}");
        let psi = to_si(&state_units(&bvp.dynamics), &psi, &units.costate());
        let expected = matrix::<6, 6>(&modified["Psi"]);
        assert!((psi - expected).amax() < 1e-12 * expected.amax());
    }
}

/// Returns problems that use every term: each environment, each kind of input axes, both schemes.
fn zoo() -> Vec<Problem> {
    let mut random = Random(7);
    let j = Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1);
    let inertia = Inertia::new(j).unwrap();
    let b = Matrix3::new(1.0, 0.1, 0.0, 0.0, 0.9, -0.2, 0.1, 0.0, 1.1);
    let w = Matrix3::new(1.0, 0.2, 0.0, 0.2, 2.0, 0.1, 0.0, 0.1, 0.5);
    let mut problems = Vec::new();
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        for frame in [AxisFrame::Body, AxisFrame::Reference] {
            let mut state = || State {
                position: Vector3::new(1.0, 0.2, -0.1) + 0.1 * random.vector3(),
                velocity: random.vector3(),
                attitude: random.rotation(),
                angular_velocity: random.vector3(),
            };
            let (start, end) = (state(), state());
            let body = Body { inertia: inertia.clone(), mass: Some(1.3) };
            let other = if frame == AxisFrame::Body { AxisFrame::Reference } else { AxisFrame::Body };
            let actuation = Actuation::torques_and_forces(channel(&b, frame), channel(&w, other));
            let weights =
                Weights { torque: Some(weight(&w)), force: Some(weight(&b.tr_mul(&b))), time_price: None };
            let base = Problem::rigid_body(body, start, end, 1.7)
                .with_actuation(actuation)
                .with_objective(weights)
                .with_steps(12)
                .with_scheme(scheme);
            let mut attitude = base.clone();
            attitude.motion = Motion::Attitude;
            attitude.actuation.force = None;
            problems.push(attitude.clone());
            problems.push(attitude.clone().with_environment(pendulum(1.7, Vector3::new(0.1, -0.2, 0.9))));
            problems.push(attitude.with_environment(GravityGradient::new(0.8, &inertia).unwrap()));
            let points =
                [(0.6, Vector3::new(0.3, 0.1, 0.02)), (0.9, Vector3::new(-0.2, -0.2 / 3.0, -0.04 / 3.0))];
            let points = points.map(|(parameter, position)| PointMass { parameter, position }).to_vec();
            problems.push(base.clone());
            problems.push(base.with_environment(CentralGravity::new(points).unwrap()));
        }
    }
    problems
}

/// Returns a uniform grid and a nonuniform grid.
fn grids(problem: &Problem) -> [Grid; 2] {
    [uniform(problem), graded(problem.scheme, problem.steps)]
}

fn uniform(problem: &Problem) -> Grid {
    Grid::uniform(problem.scheme, 1.0, problem.steps)
}

fn random_costate<const N: usize>(random: &mut Random) -> SVector<f64, N> {
    SVector::from_fn(|_, _| random.uniform())
}

/// Returns `−K_pp`, the derivative of the input output with respect to the costate, at every node.
fn slopes<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
) -> Vec<SMatrix<f64, N, N>> {
    let mut slopes = Vec::new();
    let push = |node: Node| {
        slopes.push(bvp.dynamics.linear_kick::<N>(&node.point.pose(), &node.costate).authority::<N>());
    };
    bvp.sweep_observed(costate, push).unwrap();
    slopes
}

/// Returns whether an input reaches or leaves its limit between two costates, where the sweep has a
/// kink.
fn kink_between<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    a: &SVector<f64, N>,
    b: &SVector<f64, N>,
) -> bool {
    let pairs = slopes(bvp, a).into_iter().zip(slopes(bvp, b));
    pairs.into_iter().any(|(a, b)| (a - b).amax() > 1e-2 * a.amax())
}

/// Compares the sensitivity with finite differences; returns the number of columns compared.
fn check_sensitivity<const N: usize>(problem: &Problem, grid: Grid, random: &mut Random) -> usize {
    let mut bvp = BoundaryValueProblem::<N>::on(problem, grid);
    let costate = random_costate::<N>(random);
    // The target is the end itself: δe = Ψ δλ there, because the logarithm is at its origin.
    let mut end_point = None;
    bvp.sweep_observed(&costate, |node| end_point = Some(node)).unwrap();
    bvp.terminal = TerminalCondition::State(end_point.unwrap().physical());
    let (end, psi) = bvp.sweep_linearized(&costate).unwrap();
    assert!(end.error.amax() < 1e-14);
    // Fourth-order differences: truncation error step⁴, round-off 1e-16/step.
    let step = 1e-4;
    let mut compared = 0;
    for column in 0..N {
        let at = |sign: f64| {
            let mut moved = costate;
            moved[column] += sign * step;
            (bvp.sweep(&moved).unwrap().error, moved)
        };
        let [(ahead, _), (behind, _), (far_ahead, first), (far_behind, last)] =
            [1.0, -1.0, 2.0, -2.0].map(at);
        if kink_between(&bvp, &first, &last) {
            continue;
        }
        compared += 1;
        let difference = ((ahead - behind) * 8.0 - (far_ahead - far_behind)) / (12.0 * step);
        let error = (difference - psi.column(column)).amax();
        assert!(
            error < 1e-10 * psi.amax(),
            "{:?} {:?} {:?} column {column}: {error:e} {:e}",
            problem.scheme,
            problem.environment,
            problem.actuation.torque.frame(),
            psi.amax()
        );
    }
    compared
}

/// Claim: the motion without inputs has the attitudes of the sweep with zero costate, in every
/// field, frame and scheme; a free body at rest has only one attitude.
#[test]
fn a_coast_is_the_sweep_without_costates() {
    fn largest_difference<const N: usize>(problem: &Problem) -> f64 {
        let bvp = BoundaryValueProblem::<N>::new(problem, problem.steps);
        let (mut swept, mut coasted) = (Vec::new(), Vec::new());
        bvp.sweep_observed(&SVector::zeros(), |node| swept.push(node.point.attitude.value)).unwrap();
        bvp.coast(|attitude| coasted.push(*attitude)).unwrap();
        let nodes = if bvp.dynamics.stands(&bvp.start) { 1 } else { problem.steps + 1 };
        assert_eq!(coasted.len(), nodes, "{problem:?}");
        coasted.resize(problem.steps + 1, coasted[0]);
        swept.iter().zip(&coasted).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
    }
    for problem in zoo() {
        let attitude = attitude_only(problem.clone());
        let mut resting = attitude.clone();
        resting.start.angular_velocity = Vector3::zeros();
        let found = [&attitude, &resting].map(largest_difference::<6>);
        assert!(found.iter().all(|found| *found < 1e-14), "{found:?}: {attitude:?}");
        if problem.motion == Motion::RigidBody {
            assert!(largest_difference::<12>(&problem) < 1e-14, "{problem:?}");
        }
    }
}

#[test]
fn sensitivity_is_the_derivative_of_the_sweep() {
    let mut random = Random(11);
    for problem in zoo() {
        // The same costates on both grids.
        let seed = random.0;
        for grid in grids(&problem) {
            random = Random(seed);
            let compared = match problem.motion {
                Motion::Attitude => check_sensitivity::<6>(&problem, grid, &mut random),
                Motion::RigidBody => check_sensitivity::<12>(&problem, grid, &mut random),
            };
            assert_eq!(compared, problem.dimension());
        }
    }
}

/// Returns the problems of the zoo with active limits.
fn limited_zoo() -> Vec<Problem> {
    let mut random = Random(19);
    let mut within = |problem: &Problem, norm: bool| {
        let part = 0.6 + 0.3 * random.uniform();
        match problem.motion {
            Motion::Attitude => limited(problem, &random_costate::<6>(&mut random), norm, part),
            Motion::RigidBody => limited(problem, &random_costate::<12>(&mut random), norm, part),
        }
    };
    zoo().iter().flat_map(|problem| [false, true].map(|norm| within(problem, norm))).collect()
}

#[test]
fn sensitivity_under_limits_is_the_derivative_of_the_sweep_away_from_kinks() {
    let mut random = Random(21);
    let (mut compared, mut columns) = (0, 0);
    for problem in limited_zoo() {
        compared += match problem.motion {
            Motion::Attitude => check_sensitivity::<6>(&problem, uniform(&problem), &mut random),
            Motion::RigidBody => check_sensitivity::<12>(&problem, uniform(&problem), &mut random),
        };
        columns += problem.dimension();
    }
    assert!(10 * compared > 9 * columns, "{compared} of {columns}");
}

/// The sensitivity of a chain of transitions equals that of the sweep: `A`, `H`, `Q` and the
/// vectorised blocks are the same linearisation. With a free terminal attitude the terminal error
/// and its derivative contain a costate: Newton's method converges, and no nearby attitude costs
/// less.
#[test]
fn a_free_attitude_exchanges_its_equations_for_those_of_the_costate() {
    let mut random = Random(91);
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        for frame in [AxisFrame::Body, AxisFrame::Reference] {
            let mut problem =
                attitude_only(moving_ends(&mut random, frame)).with_scheme(scheme).with_steps(40);
            problem.start.angular_velocity *= 0.2;
            problem.end.angular_velocity *= 0.2;
            let problem = problem.with_environment(pendulum(0.5, Vector3::new(0.1, -0.2, 0.9)));
            let mut bvp = BoundaryValueProblem::<6>::new(&problem, problem.steps);
            bvp.terminal = TerminalCondition::AttitudeFree(*bvp.terminal.target());
            let mut costate = SVector::zeros();
            for _ in 0..8 {
                let (end, slope) = bvp.sweep_linearized(&costate).unwrap();
                let along: SVector<f64, 6> = random_costate(&mut random);
                let at = |step: f64| bvp.sweep(&(costate + along * step)).unwrap().error;
                let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
                assert!((slope * along - difference).amax() < 1e-7 * slope.amax(), "{difference}");
                costate -= Factor::new(&slope).solve(&end.error);
            }
            let free = bvp.sweep(&costate).unwrap();
            assert!(free.residual() < 1e-13, "{}", free.residual());
            let mut end = bvp.start;
            bvp.sweep_observed(&costate, |node| end = node.physical()).unwrap();
            for axis in 0..3 {
                let cost = |angle: f64| {
                    let mut near = end;
                    near.attitude.value *= lie::exp(&Vector3::ith(axis, angle));
                    let given =
                        BoundaryValueProblem { terminal: TerminalCondition::State(near), ..bvp.clone() };
                    let mut costate = costate;
                    for _ in 0..6 {
                        let (end, psi) = given.sweep_linearized(&costate).unwrap();
                        costate -= Factor::new(&psi).solve(&end.error);
                    }
                    given.sweep(&costate).unwrap().cost
                };
                let (ahead, behind) = (cost(1e-3), cost(-1e-3));
                assert!(ahead > free.cost && behind > free.cost, "{ahead} {behind} {}", free.cost);
            }
        }
    }
}

fn check_matrices<const N: usize>(problem: &Problem, grid: Grid, random: &mut Random) {
    let bvp = BoundaryValueProblem::<N>::on(problem, grid);
    let first = random_costate::<N>(random);
    let (mut nodes, mut psi_from_nodes) = (Vec::new(), SMatrix::<f64, N, N>::zeros());
    bvp.sweep_observed(&first, |node| nodes.push(node)).unwrap();
    let mut costate_columns = SMatrix::<f64, N, N>::identity();
    let dynamics = &bvp.dynamics;
    if problem.scheme == Scheme::LieVerlet {
        let linear = dynamics.linear_kick::<N>(&nodes[0].point.pose(), &nodes[0].costate);
        psi_from_nodes = -linear.authority::<N>() * dynamics.grid.kick(0);
    }
    let mut watched = Vec::new();
    bvp.sweep_conjugate(&first, |step| watched.push(step.columns.state())).unwrap();
    for (k, pair) in nodes.windows(2).enumerate() {
        let costate = pair[1].costate.to_vector::<N>();
        let step = dynamics.transition::<N>(pair[0].index, &pair[0].point, &costate).unwrap();
        let before = pair[0].costate.to_vector::<N>();
        assert!((step.costate_before - before).amax() < 1e-13 * before.amax().max(1.0));
        let Linear { a, h, q } = step.linear;
        costate_columns = Factor::new(&a.transpose()).solve_matrix(&(costate_columns - h * psi_from_nodes));
        psi_from_nodes = a * psi_from_nodes - q * costate_columns;
        let error = (psi_from_nodes - watched[k]).amax();
        assert!(error < 1e-11 * watched[k].amax().max(1.0), "{problem:?} {k}: {error:e}");
    }
}

use crate::optimize::discrete::step::Linearization as Linear;

#[test]
fn matrices_and_lanes_are_one_linearisation() {
    let mut random = Random(13);
    for problem in zoo().into_iter().chain(limited_zoo()) {
        for grid in grids(&problem) {
            match problem.motion {
                Motion::Attitude => check_matrices::<6>(&problem, grid, &mut random),
                Motion::RigidBody => check_matrices::<12>(&problem, grid, &mut random),
            }
        }
    }
}

fn check_equal_lengths<const N: usize>(problem: &Problem, random: &mut Random) {
    let costate = random_costate::<N>(random);
    let sweep = |grid| BoundaryValueProblem::<N>::on(problem, grid).sweep_linearized(&costate).unwrap();
    let lengths = Grid::of_lengths(problem.scheme, &vec![1.0; problem.steps]).unwrap().with_duration(1.0);
    let ((end, psi), (end_own, psi_own)) = (sweep(uniform(problem)), sweep(lengths));
    assert!((end.error - end_own.error).amax() < 1e-13, "{problem:?}");
    assert!((end.cost - end_own.cost).abs() < 1e-13 * end.cost, "{problem:?}");
    assert!((psi - psi_own).amax() < 1e-12 * psi.amax(), "{problem:?}");
}

#[test]
fn lengths_that_are_equal_make_the_uniform_grid() {
    let mut random = Random(17);
    for problem in zoo().into_iter().chain(limited_zoo()) {
        match problem.motion {
            Motion::Attitude => check_equal_lengths::<6>(&problem, &mut random),
            Motion::RigidBody => check_equal_lengths::<12>(&problem, &mut random),
        }
    }
}

/// Returns the cost of a solved maneuver on a grid, by Newton's method from zero costates.
fn solved_cost<const N: usize>(problem: &Problem, grid: Grid) -> f64 {
    let bvp = BoundaryValueProblem::<N>::on(problem, grid);
    let mut costate = SVector::zeros();
    for _ in 0..12 {
        let (end, psi) = bvp.sweep_linearized(&costate).unwrap();
        costate -= Factor::new(&psi).solve(&end.error);
    }
    let end = bvp.sweep(&costate).unwrap();
    assert!(end.error.amax() < 1e-12, "{}", end.error);
    end.cost
}

#[test]
fn costs_on_smoothly_graded_grids_have_the_order_of_the_scheme() {
    let inertia = Inertia::new(Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)).unwrap();
    let start = State::attitude(Matrix3::identity(), Vector3::new(0.1, -0.3, 0.2));
    let end = State::attitude(lie::exp(&Vector3::new(0.4, 0.5, -0.3)), Vector3::new(-0.2, 0.1, 0.1));
    let body = Body { inertia: inertia.clone(), mass: None };
    // A force field, and a reference frame that rotates by a different angle on each step.
    let problem = Problem::attitude(body, start, end, 1.7)
        .with_environment(GravityGradient::new(0.4, &inertia).unwrap())
        .with_actuation(Actuation::torques(ActuatorSet::three_axes(AxisFrame::Reference)));
    for (scheme, order) in [(Scheme::LieEuler, 1), (Scheme::LieVerlet, 2)] {
        let cost = |steps: usize| solved_cost::<6>(&problem, graded(scheme, steps));
        let fine = solved_cost::<6>(&problem, Grid::uniform(Scheme::LieVerlet, 1.0, 4000));
        let errors = [20, 40, 80, 160].map(|steps| (cost(steps) - fine).abs());
        for pair in errors.windows(2) {
            let seen = (pair[0] / pair[1]).log2();
            assert!((seen - f64::from(order)).abs() < 0.2, "{scheme:?} {errors:?}");
        }
    }
}
