//! The bounds compared with brute-force minima and with plans, and proved from perturbed dual
//! vectors.

use super::*;
use crate::maneuver::problem::State;
use crate::maneuver::settings::Settings;
use crate::maneuver::solution::{Outcome, Solution};
use crate::mechanics::actuators::{Actuation, ActuatorSet, Wheels};
use crate::mechanics::body::{Body, Inertia};
use crate::mechanics::environment::UniformGravity;
use crate::optimize::search;
use crate::plan::Silent;
use crate::testing::{Random, full_inertia, matrix, reference, vector, with_torques};
use nalgebra::DMatrix;
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn bounded(problem: &Problem, relaxation: Relaxation) -> LowerBound {
    lower_bound(problem, &BoundSettings { relaxation, ..BoundSettings::default() }).unwrap()
}

fn planned(problem: &Problem) -> Solution {
    search::solve(problem, &Settings::discrete(), None, &mut Silent).unwrap()
}

/// Builds a rest-to-rest turn in three Lie–Euler steps with h = 1, so that the reference values are
/// twice the cost.
fn three_steps(inertia: Inertia, rotation: Vector3) -> Problem {
    let body = Body { inertia, mass: None };
    let end = State::at_rest(lie::exp(&rotation));
    Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 3.0)
        .with_steps(3)
        .with_scheme(Scheme::LieEuler)
}

fn spatial(file: &Value, case: &Value) -> Problem {
    let axis: Vector3 = vector(&file["so3"]["axis"]);
    let inertia = Inertia::new(matrix(&file["so3"]["J"])).unwrap();
    three_steps(inertia, axis.normalize() * number(&case["angle_deg"]).to_radians())
}

/// Builds a turn about a principal axis with moment of inertia 1 that is not a coordinate axis.
/// Torque acts about this axis only.
fn single_axis(case: &Value) -> Problem {
    let tilt = lie::exp(&Vector3::new(0.4, -0.3, 0.8));
    let j = tilt * Matrix3::from_diagonal(&Vector3::new(1.3, 0.9, 1.0)) * tilt.transpose();
    let axis = tilt.column(2).into_owned();
    let torque = ActuatorSet::new(vec![axis], AxisFrame::Body).unwrap();
    three_steps(Inertia::new(j).unwrap(), axis * number(&case["phi"]))
        .with_actuation(Actuation::torques(torque))
}

/// Rounding error of the reference values.
const PRINTED: f64 = 6e-9;

#[test]
fn single_axis_bounds_are_those_of_the_reference() {
    let file = reference("moment_relaxation.json");
    for case in file["single_axis"].as_array().unwrap() {
        let problem = single_axis(case);
        let minimum = number(&case["physical_minimum"]);
        for (key, relaxation, tolerance) in [
            ("shor", Relaxation::Shor, 1e-6),
            ("shor_branch", Relaxation::Branch, 1e-6),
            ("order2_branch", Relaxation::SecondOrder, 1e-4),
        ] {
            let value = 2.0 * bounded(&problem, relaxation).cost;
            assert!(value <= minimum + PRINTED, "{key} {value} above {minimum}");
            if let Some(expected) = case[key].as_f64() {
                assert!((value - expected).abs() < tolerance, "{key} {value} is not {expected}");
            }
        }
        let any = case["any_branch_minimum"].as_f64().unwrap_or(f64::INFINITY);
        assert!(2.0 * bounded(&problem, Relaxation::Shor).cost <= any + PRINTED);
        let localized = 2.0 * bounded(&problem, Relaxation::Localized).cost;
        assert!((localized - minimum).abs() < 1e-6, "{localized} is not {minimum}");
        assert!(localized <= minimum + PRINTED);
    }
}

#[test]
fn bounds_of_order_one_are_those_of_the_reference() {
    let file = reference("moment_relaxation.json");
    for case in file["so3"]["cases"].as_array().unwrap() {
        let problem = spatial(&file, case);
        let shor = bounded(&problem, Relaxation::Shor);
        assert!((2.0 * shor.cost - number(&case["shor"])).abs() < 1e-6, "{shor:?}");
        assert!(2.0 * shor.cost <= number(&case["any_branch_minimum"]) + PRINTED, "{shor:?}");
        assert_eq!(shor.coverage, Coverage::AnyBranch);
        // The relaxation has found the only non-physical minimum.
        assert!(shor.rank_one_defect.unwrap() < 1e-6);
        let branch = bounded(&problem, Relaxation::Branch);
        if let Some(expected) = case["order1_branch"].as_f64() {
            assert!((2.0 * branch.cost - expected).abs() < 1e-6, "{branch:?}");
        }
        assert!(2.0 * branch.cost <= number(&case["physical_minimum"]) + PRINTED);
        assert_eq!(branch.coverage, Coverage::PhysicalBranch);
        // The bound is loose, and the rank-one defect shows it.
        assert!(branch.rank_one_defect.unwrap() > 1e-2);
    }
}

#[test]
fn the_localised_bound_is_the_physical_minimum() {
    let file = reference("moment_relaxation.json");
    for case in file["so3"]["cases"].as_array().unwrap() {
        let minimum = number(&case["physical_minimum"]);
        let bound = bounded(&spatial(&file, case), Relaxation::Localized);
        let value = 2.0 * bound.cost;
        assert!((value - minimum).abs() < 1e-6, "{value} is not {minimum}");
        assert!(value <= minimum + PRINTED);
        assert!(bound.rank_one_defect.unwrap() < 1e-6);
    }
}

#[test]
fn bounds_of_order_two_are_those_of_the_reference() {
    let file = reference("moment_relaxation.json");
    for case in file["so3"]["cases"].as_array().unwrap() {
        let Some(expected) = case["order2_branch"].as_f64() else { continue };
        let value = 2.0 * bounded(&spatial(&file, case), Relaxation::SecondOrder).cost;
        assert!((value - expected).abs() < 1e-4, "{value} is not {expected}");
        assert!(value <= number(&case["physical_minimum"]) + PRINTED);
    }
}

/// Returns a free body with random inertia, inputs, weight and moving ends.
fn random_problem(random: &mut Random, scheme: Scheme, steps: usize) -> Problem {
    // A set of point masses always has a physical inertia.
    let mut j_d = Matrix3::identity() * 0.05;
    for _ in 0..4 {
        let point = random.vector3();
        j_d += point * point.transpose();
    }
    let j = (Matrix3::identity() * j_d.trace() - j_d) * 10f64.powf(2.0 * random.uniform());
    let body = Body { inertia: Inertia::new(j).unwrap(), mass: None };
    let square = |random: &mut Random| Matrix3::from_fn(|_, _| random.uniform());
    let axes = Matrix3::identity() + 0.4 * square(random);
    let root = Matrix3::identity() + 0.4 * square(random);
    let duration = 2.0 * 10f64.powf(random.uniform());
    let mut rate = || random.vector3() * 0.2 / duration;
    let rates = [rate(), rate()];
    let start = State::attitude(random.rotation(), rates[0]);
    let turn = lie::exp(&(random.vector3() * 0.9));
    let end = State::attitude(lie::project_to_rotation(&(start.attitude * turn)), rates[1]);
    let problem = Problem::attitude(body, start, end, duration).with_scheme(scheme).with_steps(steps);
    with_torques(problem, &axes, &(root.transpose() * root))
}

#[test]
fn no_bound_exceeds_a_plan() {
    let mut random = Random(20_261_121);
    let (mut compared, mut tight) = (0, 0);
    for index in 0..200 {
        let (scheme, steps) = if index % 2 == 0 { (Scheme::LieEuler, 3) } else { (Scheme::LieVerlet, 2) };
        let problem = random_problem(&mut random, scheme, steps);
        let solution = planned(&problem);
        if solution.outcome != Outcome::Converged {
            continue;
        }
        compared += 1;
        let best = solution.rivals.iter().map(|rival| rival.cost).fold(solution.cost, f64::min);
        for known_cost in [None, Some(best)] {
            let bound =
                lower_bound(&problem, &BoundSettings { known_cost, ..BoundSettings::default() }).unwrap();
            assert!(bound.cost <= best * (1.0 + 1e-12), "case {index}: {} above {best}", bound.cost);
            assert_eq!(bound.coverage, Coverage::PhysicalBranch);
            if let Some(gap) = bound.gap {
                tight += usize::from(gap < 1e-6);
            }
        }
        // The conditions of the relaxations are nested, and therefore the bounds are ordered.
        let [shor, branch] = [Relaxation::Shor, Relaxation::Branch].map(|one| bounded(&problem, one).cost);
        assert!(shor <= branch * (1.0 + 1e-6) && branch <= best, "case {index}: {shor} {branch} {best}");
    }
    assert!(compared >= 195, "only {compared} plans to compare with");
    // The bounds must not be trivial.
    assert!(tight >= compared * 9 / 10, "tight in {tight} of {compared}");
}

/// Builds a rest-to-rest turn through `degrees` in two seconds.
fn rest_to_rest(degrees: f64, scheme: Scheme, steps: usize) -> Problem {
    let axis = Vector3::new(1.0, 2.0, -0.5).normalize();
    let mut problem = three_steps(full_inertia(), axis * degrees.to_radians());
    problem = problem.with_duration(2.0);
    problem.with_scheme(scheme).with_steps(steps)
}

#[test]
fn a_chain_of_several_cliques_proves_a_plan_globally_optimal() {
    for (scheme, steps) in [(Scheme::LieEuler, 4), (Scheme::LieEuler, 5), (Scheme::LieVerlet, 4)] {
        let problem = rest_to_rest(60.0, scheme, steps);
        let best = planned(&problem).cost;
        let bound = bounded(&problem, Relaxation::Localized);
        let gap = 1.0 - bound.cost / best;
        assert!((0.0..1e-6).contains(&gap), "{scheme:?} {steps}: gap {gap}");
        assert!(bound.rank_one_defect.unwrap() < 1e-6);
    }
}

#[test]
fn a_loose_bound_says_so_and_a_known_cost_tightens_it() {
    let problem = rest_to_rest(120.0, Scheme::LieVerlet, 4);
    let known = planned(&problem).cost;
    let without = bounded(&problem, Relaxation::Localized);
    let settings = BoundSettings { known_cost: Some(known), ..BoundSettings::default() };
    let with = lower_bound(&problem, &settings).unwrap();
    assert_eq!(with.coverage, Coverage::PhysicalBranch);
    assert!(without.cost < with.cost && with.cost < known, "{} {} {known}", without.cost, with.cost);
    let gap = with.gap.unwrap();
    assert!((gap - (known - with.cost) / known).abs() < 1e-12 && (1e-3..0.05).contains(&gap), "{gap}");
    // The relaxation mixes two maneuvers instead of finding one.
    assert!(with.rank_one_defect.unwrap() > 1e-2);
}

/// Returns the attitudes of a plan as matrices.
fn attitudes(solution: &Solution) -> Vec<Matrix3> {
    solution.trajectory.quaternion.iter().map(lie::rotation_from_quaternion).collect()
}

#[test]
fn a_plan_has_its_cost_in_the_polynomials_and_meets_every_condition() {
    let mut random = Random(99);
    for (scheme, steps) in [
        (Scheme::LieEuler, 2),
        (Scheme::LieEuler, 3),
        (Scheme::LieEuler, 4),
        (Scheme::LieEuler, 7),
        (Scheme::LieVerlet, 2),
        (Scheme::LieVerlet, 3),
        (Scheme::LieVerlet, 6),
    ] {
        let problem = random_problem(&mut random, scheme, steps);
        let solution = planned(&problem);
        assert_eq!(solution.outcome, Outcome::Converged);
        let settings = BoundSettings { known_cost: Some(solution.cost), ..BoundSettings::default() };
        let setup = Setup::new(&problem, &settings).unwrap();
        let chain = Chain::new(&setup.data);
        let path = attitudes(&solution);
        let fixed = usize::from(scheme == Scheme::LieEuler);
        let count = steps - fixed;
        // F_1 … F_M, then R_3 … R_{M−1} from the start of the free steps.
        let mut rotations: Vec<Matrix3> =
            (0..count).map(|k| path[fixed + k].transpose() * path[fixed + k + 1]).collect();
        for (angle, f) in setup.step_angles[fixed..].iter().zip(&rotations) {
            assert!(lie::log(f).norm() <= *angle, "{} beyond {angle}", lie::log(f).norm());
        }
        rotations.extend((2..count.max(3) - 1).map(|k| path[fixed].transpose() * path[fixed + k]));
        let quaternions: Vec<[f64; 4]> = rotations.iter().map(lie::quaternion_from_rotation).collect();
        let cost = setup.unit * chain.cost.value(&chain.ring, &quaternions);
        assert!((cost / solution.cost - 1.0).abs() < 1e-10, "{steps} steps: {cost} is not {}", solution.cost);
        for relation in &chain.relations {
            assert!(relation.value(&chain.ring, &quaternions).abs() < 1e-11);
        }
        for limit in &chain.limits {
            let value = limit.polynomial.value(&chain.ring, &quaternions);
            assert!((-1e-12..=1.0 + 1e-12).contains(&value), "{value}");
        }
    }
}

#[test]
fn a_perturbed_dual_vector_still_proves_a_bound() {
    let file = reference("moment_relaxation.json");
    let case = &file["so3"]["cases"][0];
    let minimum = number(&case["physical_minimum"]);
    let problem = spatial(&file, case);
    let setup = Setup::new(&problem, &BoundSettings::default()).unwrap();
    let moments = relaxation::build(&Chain::new(&setup.data), Relaxation::Localized).unwrap();
    let settings = ConeSettings { regularization: 1e-7, ..ConeSettings::default() };
    let answer = ConeSolver::new(moments.program.clone(), &settings).unwrap().solve();
    let z = &answer.step().unwrap().z;
    let value = |proved: f64| 2.0 * setup.unit * proved;
    let mut random = Random(5);
    let mut misled = 0;
    for exponent in -10..1 {
        for _ in 0..20 {
            let size = 10f64.powi(exponent);
            let noisy: Vec<f64> = z.iter().map(|z| z + size * random.uniform()).collect();
            let proof = prove(&moments, &noisy, true).unwrap();
            assert!(value(proof.bound) <= minimum + PRINTED, "noise {size}: {}", value(proof.bound));
            misled += usize::from(value(proof.claimed) > minimum + 1e-3);
            // The loss is proportional to the noise.
            assert!(value(proof.bound) > minimum - 1e4 * size - 1e-6, "noise {size}: {}", value(proof.bound));
        }
    }
    // Without the correction some of these bounds would have been false.
    assert!(misled > 10, "{misled}");
    // Two perturbations, each handled by one correction alone. The entry of the constant does not
    // affect any residual; a scaled vector keeps every block positive semidefinite.
    let place = moments.program.cones.iter().take_while(|cone| !matches!(cone, Cone::Semidefinite(_)));
    let constant = place.map(|cone| cone.rows()).sum::<usize>();
    let mut raised = z.clone();
    raised[constant] -= 5.0;
    let shrunk: Vec<f64> = z.iter().map(|z| 0.9 * z).collect();
    for attack in [&raised, &shrunk] {
        let proof = prove(&moments, attack, true).unwrap();
        assert!(value(proof.claimed) > minimum + 0.01, "not an attack: {}", value(proof.claimed));
        assert!(value(proof.bound) <= minimum + PRINTED, "{}", value(proof.bound));
    }
    // Any finite vector proves a true bound; NaN proves nothing.
    let wild: Vec<f64> = z.iter().map(|_| 1e6 * random.uniform()).collect();
    assert!(prove(&moments, &wild, true).unwrap().bound < 0.0);
    assert!(prove(&moments, &vec![f64::NAN; z.len()], true).is_none());
    assert!(prove(&moments, &z[1..], true).is_none());
}

#[test]
fn the_correction_holds_for_a_solver_that_stops_early() {
    let file = reference("moment_relaxation.json");
    let case = &file["so3"]["cases"][1];
    for tolerance in [9e-3, 1e-3, 1e-5] {
        let settings = BoundSettings { tolerance, ..BoundSettings::default() };
        let bound = lower_bound(&spatial(&file, case), &settings).unwrap();
        assert!(2.0 * bound.cost <= number(&case["physical_minimum"]) + PRINTED, "{bound:?}");
    }
}

#[test]
fn no_eigenvalue_is_below_its_bound() {
    let mut random = Random(11);
    for n in [1, 2, 5, 20] {
        for lowest in [-1.0, -1e-9, 0.0, 1e-9, 0.5] {
            let mixed = DMatrix::from_fn(n, n, |_, _| random.uniform());
            let q = mixed.qr().q();
            let spectrum = DMatrix::from_fn(n, n, |i, j| if i == j { lowest + i as f64 } else { 0.0 });
            let matrix = &q * spectrum * q.transpose();
            let matrix = 0.5 * (&matrix + matrix.transpose());
            let bound = certificate::lowest_eigenvalue(&matrix);
            assert!(bound <= lowest && bound > lowest - 1e-10 * n as f64, "{bound} for {lowest}");
        }
    }
}

#[test]
fn a_turn_that_no_step_can_make_is_proved_impossible() {
    // The only free step of Lie–Euler would have to turn 120°.
    let one = three_steps(full_inertia(), Vector3::new(0.0, 0.0, 120f64.to_radians())).with_steps(2);
    let bound = bounded(&one, Relaxation::Localized);
    assert!(bound.cost.is_infinite() && bound.solver == SolverEnd::NothingFree, "{bound:?}");
    // Two free steps of at most 30° cannot turn 100°.
    let two = three_steps(full_inertia(), Vector3::new(0.0, 0.0, 100f64.to_radians()));
    let settings = BoundSettings { max_step_angle: 30f64.to_radians(), ..BoundSettings::default() };
    let bound = lower_bound(&two, &settings).unwrap();
    assert!(bound.cost.is_infinite() && bound.solver == SolverEnd::Infeasible, "{bound:?}");
    assert_eq!(bound.coverage, Coverage::WithinAngles);
    // Two steps of at most 51° can turn 100°.
    let settings = BoundSettings { max_step_angle: 51f64.to_radians(), ..BoundSettings::default() };
    assert!(lower_bound(&two, &settings).unwrap().cost.is_finite());
    // With one free step of 60° only one maneuver exists, so its cost is the bound.
    let one = three_steps(full_inertia(), Vector3::new(0.0, 0.0, 1.0)).with_steps(2);
    let cost = planned(&one).cost;
    let bound = bounded(&one, Relaxation::Localized).cost;
    assert!(bound <= cost && bound > cost * (1.0 - 1e-9), "{bound} {cost}");
}

#[test]
fn a_bound_scales_as_the_cost_does() {
    let file = reference("moment_relaxation.json");
    let problem = spatial(&file, &file["so3"]["cases"][1]);
    let plain = bounded(&problem, Relaxation::Localized).cost;
    let mut scaled = problem.clone();
    scaled.body.inertia = Inertia::new(problem.body.inertia.j() * 4000.0).unwrap();
    scaled.duration = (50.0 * scaled.seconds()).into();
    let ratio = bounded(&scaled, Relaxation::Localized).cost / plain;
    assert!((ratio / (4000f64.powi(2) / 50f64.powi(3)) - 1.0).abs() < 1e-6, "{ratio}");
}

#[test]
fn what_is_not_covered_is_refused_by_name() {
    let base = three_steps(full_inertia(), Vector3::new(0.0, 0.0, 1.0));
    let settings = BoundSettings::default();
    let refused = |problem: &Problem| match lower_bound(problem, &settings) {
        Err(BoundError::NotCovered(reason)) => reason,
        other => panic!("{other:?}"),
    };
    let field = UniformGravity::new(1.0, 9.81, Vector3::z(), Vector3::new(0.0, 0.0, 0.1)).unwrap();
    assert!(refused(&base.clone().with_environment(field)).contains("field"));
    let mut moving = base.clone();
    moving.motion = Motion::RigidBody;
    moving.body.mass = Some(1.0);
    assert!(refused(&moving).contains("translates"));
    assert!(refused(&base.clone().with_any_attitude_at_end()).contains("any attitude"));
    let torques = |axes: Vec<Vector3>, frame| Actuation::torques(ActuatorSet::new(axes, frame).unwrap());
    let two = torques(vec![Vector3::x(), Vector3::y()], AxisFrame::Body);
    assert!(refused(&base.clone().with_actuation(two)).contains("two axes"));
    let one = torques(vec![Vector3::x()], AxisFrame::Body);
    assert!(refused(&base.clone().with_actuation(one)).contains("not about it"));
    let skew = torques(vec![Vector3::x(), Vector3::y(), 2.0 * Vector3::z()], AxisFrame::Reference);
    assert!(refused(&base.clone().with_actuation(skew)).contains("reference frame"));
    let mut wheels = base.clone();
    wheels.actuation.wheels = Some(Wheels { momentum: vec![0.0; 3], momentum_limit: vec![f64::INFINITY; 3] });
    assert!(refused(&wheels).contains("wheels"));
    let long = base.clone().with_steps(MAX_STEPS + 1);
    assert!(matches!(lower_bound(&long, &settings), Err(BoundError::TooManySteps { .. })));
    let second = BoundSettings { relaxation: Relaxation::SecondOrder, ..settings.clone() };
    let four = base.clone().with_steps(4);
    assert!(matches!(lower_bound(&four, &second), Err(BoundError::TooManySteps { limit: 3, .. })));
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let spoiled = [
            BoundSettings { known_cost: Some(bad), ..settings.clone() },
            BoundSettings { max_step_angle: bad, ..settings.clone() },
            BoundSettings { tolerance: bad, ..settings.clone() },
        ];
        for settings in spoiled {
            assert!(matches!(lower_bound(&base, &settings), Err(BoundError::Setting { .. })));
        }
    }
    // More inputs than axes, and reference-frame axes of equal cost, are covered.
    let four_inputs =
        torques(vec![Vector3::x(), Vector3::y(), Vector3::z(), Vector3::new(0.5, 0.5, 0.5)], AxisFrame::Body);
    for actuation in [four_inputs, Actuation::torques(ActuatorSet::three_axes(AxisFrame::Reference))] {
        let problem = base.clone().with_actuation(actuation);
        let (bound, cost) = (bounded(&problem, Relaxation::Localized).cost, planned(&problem).cost);
        assert!(bound <= cost && bound > 0.999_999 * cost, "{bound} {cost}");
    }
}
