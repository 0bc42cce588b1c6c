//! SCP against reference costs and the shooting.

use super::*;
use crate::maneuver::problem::Problem;
use crate::optimize::chain::first_iterate;
use crate::optimize::chain::rows::What;
use crate::optimize::chain::tests::{reference_slew, shot, straight};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn converge(problem: &Problem, options: &ScpOptions) -> (Model, Convex) {
    let model = Model::new(problem, problem.steps);
    let rows = LimitRows::of(problem, &model);
    let start = first_iterate::along(&model, &rows, &straight(&model), 1.0, &Watch::NONE);
    let convex = run(&model, &rows, start, None, options, &Watch::NONE).unwrap();
    (model, convex)
}

/// Nobody is asked within the cone solver, which looks at the flag.
#[test]
fn a_flag_stops_the_convex_iteration_inside_of_a_subproblem() {
    let problem = reference_slew(Some(0.75));
    let model = Model::new(&problem, problem.steps);
    let rows = LimitRows::of(&problem, &model);
    for set in [false, true] {
        let flag = Arc::new(AtomicBool::new(set));
        let watch = Watch { flag: Some(&flag), ..Watch::NONE };
        let start = first_iterate::along(&model, &rows, &straight(&model), 1.0, &watch);
        let convex = run(&model, &rows, start, None, &ScpOptions::default(), &watch).unwrap();
        let outcome = if set { Outcome::Interrupted } else { Outcome::Converged };
        assert_eq!(convex.outcome, outcome);
    }
}

/// A large cone program is not waited for, not even while the solver is being made.
#[cfg(feature = "threads")]
#[test]
fn a_stop_leaves_a_large_subproblem_to_itself() {
    let problem = reference_slew(None).with_steps(2_300);
    let model = Model::new(&problem, problem.steps);
    let rows = LimitRows::of(&problem, &model);
    let start = first_iterate::along(&model, &rows, &straight(&model), 1.0, &Watch::NONE);
    let at = start.evaluate(&model, &rows, Watch::NONE).unwrap();
    let curvature = vec![DMatrix::zeros(model.n, model.n); model.steps + 1];
    let weights =
        super::Weights { defect: 100.0, violation: vec![100.0; rows.groups.len()], radius: RADIUS.0 };
    for (outcome, failure) in [(Outcome::Interrupted, Failure::Stopped), (Outcome::TimeLimit, Failure::Time)]
    {
        let watch = Watch { interrupt: &|| Some(outcome), ..Watch::NONE };
        let mut subproblem = Subproblem::new(&model, &rows, 1e-6, watch);
        let left = subproblem.solve(&at, &curvature, &weights, None);
        assert_eq!(left.err(), Some(failure));
    }
}

/// Costs of theory.md, section 9 and 10, from another program.
#[test]
fn the_reference_costs_are_met_before_and_after_polish() {
    for (share, cost) in [(None, 16.389987441935), (Some(0.75), 16.718658565135), (Some(0.65), 18.0852435685)]
    {
        let problem = reference_slew(share);
        let (model, convex) = converge(
            &problem,
            &ScpOptions { polish_early: false, cone_tolerance: 1e-9, ..ScpOptions::default() },
        );
        let polished = convex.polished.as_ref().expect("polished");
        let unit = model.dynamics.units.cost;
        let before = convex.iterate.cost(&model) * unit;
        assert!((before - cost).abs() < 1e-9 * cost, "{before} before polish");
        assert!((polished.cost * unit - cost).abs() < 1e-10 * cost, "{}", polished.cost * unit);
        assert!(polished.residual < 1e-12, "residual {}", polished.residual);
        // The duals of the convex iteration are the costates.
        let scale = polished.multipliers.costates.iter().map(|costate| costate.amax()).fold(0.0, f64::max);
        let pairs = convex.multipliers.costates.iter().zip(&polished.multipliers.costates);
        let worst = pairs.map(|(dual, costate)| (dual - costate).amax()).fold(0.0, f64::max);
        assert!(worst < 1e-6 * scale, "duals are off by {}", worst / scale);
    }
}

#[test]
fn early_polish_finds_the_same_point_in_few_subproblems() {
    for share in [None, Some(0.75), Some(0.65)] {
        let problem = reference_slew(share);
        let (_, late) = converge(
            &problem,
            &ScpOptions { polish_early: false, cone_tolerance: 1e-9, ..ScpOptions::default() },
        );
        let (_, early) = converge(&problem, &ScpOptions::default());
        let (late_cost, early_cost) = (late.polished.unwrap().cost, early.polished.unwrap().cost);
        assert!((late_cost - early_cost).abs() < 1e-12 * late_cost);
        assert!(early.subproblems <= 6, "{}", early.subproblems);
    }
}

/// Claim: where Newton ends the digits the first subproblem takes fewer iterations, and the way leads to the same point.
#[test]
fn subproblems_that_newton_ends_are_solved_roughly() {
    for share in [Some(0.75), Some(0.65)] {
        let problem = reference_slew(share);
        let (ended, alone) = (ScpOptions::default(), ScpOptions { polish: false, ..ScpOptions::default() });
        let [rough, sharp] =
            [&ended, &alone].map(|options| converge(&problem, &options.clone().within(1)).1.cone_iterations);
        assert!(rough < sharp, "{rough} {sharp}");
        let [rough, sharp] =
            [&ended, &alone].map(|options| converge(&problem, options).1.polished.expect("an optimum").cost);
        assert!((rough - sharp).abs() < 1e-5 * sharp, "{rough} {sharp}");
    }
}

#[test]
fn without_limits_the_multipliers_are_the_costates_of_the_shooting() {
    let problem = reference_slew(None);
    let (model, convex) = converge(&problem, &ScpOptions::default());
    let polished = convex.polished.unwrap();
    let solution = shot(&problem);
    let units = model.dynamics.units.costate::<6>();
    for row in 0..problem.steps {
        let shot = nalgebra::SVector::<f64, 6>::from_row_slice(&solution.trajectory.costates[6 * row..][..6]);
        let dual = &polished.multipliers.costates[row + 1];
        let difference =
            shot.component_div(&units) - nalgebra::SVector::<f64, 6>::from_column_slice(dual.as_slice());
        assert!(difference.amax() < 1e-11, "row {row}: {:.1e}", difference.amax());
    }
}

/// Where rows of how fast inputs change follow each other, and their arcs are taken for longer than they are, the rows
/// contradict each other.
#[test]
fn rows_that_contradict_each_other_are_sorted_out() {
    let mut problem = reference_slew(Some(0.75)).with_steps(250);
    let mut limits = problem.actuation.torque.limits().clone();
    limits.rate = limits.size.as_ref().map(|sizes| sizes.iter().map(|size| 3.0 * size / 2.0).collect());
    problem.actuation.torque = problem.actuation.torque.with_limits(limits).unwrap();
    let (model, convex) = converge(&problem, &ScpOptions::default());
    let solved = convex.polished.expect("polished");
    let rows = LimitRows::of(&problem, &model);
    let acts: Vec<bool> = solved.multipliers.rows.iter().map(|multiplier| *multiplier > 0.0).collect();
    let largest = solved.multipliers.rows.iter().fold(0.0f64, |largest, value| largest.max(*value));
    let by_stage = rows.range(problem.steps / 2).len();
    for longer in [1, 3] {
        let mut multipliers = solved.multipliers.clone();
        for (row, limit) in rows.rows.iter().enumerate() {
            let beside = |offset: usize| {
                let before = row.checked_sub(offset * by_stage).is_some_and(|before| acts[before]);
                before || acts.get(row + offset * by_stage) == Some(&true)
            };
            let is_rate = matches!(limit.what, What::InputRate { .. });
            if is_rate && !acts[row] && (1..=longer).any(beside) {
                multipliers.rows[row] = 0.05 * largest;
            }
        }
        let options = ScpOptions::default();
        let polished =
            |told| polish(&model, &rows, &solved.iterate, &multipliers, &options, told, &Watch::NONE);
        assert!(polished(Told::Roughly).is_none(), "{longer} rows say nothing of the wide proximal term");
        let found = polished(Told::Settled).expect("sorted out");
        assert!(found.residual < 1e-12 && (found.cost - solved.cost).abs() < 1e-12 * solved.cost);
    }
}
