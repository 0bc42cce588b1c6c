//! SCP against reference costs and the shooting.

use super::*;
use crate::maneuver::problem::Problem;
use crate::optimize::chain::reference::newton::newton;
use crate::optimize::chain::tests::{reference_slew, shot, straight};
use crate::optimize::chain::{Chain, first_iterate, path};
use crate::optimize::methods::method::{Budget, Method};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn converge(problem: &Problem, options: &ScpOptions) -> (Model, Convex) {
    let model = Model::new(problem, problem.steps);
    let rows = LimitRows::of(problem, &model);
    let start = first_iterate::along(&model, &rows, &straight(&model), 1.0, &Watch::NONE);
    let convex = run(&model, &rows, start, options, &Watch::NONE).unwrap();
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
        let convex = run(&model, &rows, start, &ScpOptions::default(), &watch).unwrap();
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
    let weights =
        super::Weights { defect: 100.0, violation: vec![100.0; rows.groups.len()], radius: RADIUS.0 };
    for (outcome, failure) in [(Outcome::Interrupted, Failure::Stopped), (Outcome::TimeLimit, Failure::Time)]
    {
        let watch = Watch { interrupt: &|| Some(outcome), ..Watch::NONE };
        let mut subproblem = Subproblem::new(&model, &rows, 1e-6, watch);
        let left = subproblem.solve(&at, &weights, None);
        assert_eq!(left.err(), Some(failure));
    }
}

/// Costs of theory.md, section 9 and 10, from another program. The duals of the convex iteration are
/// the costates, which Newton on the set of acting rows finds from there, and the interior point ends
/// the digits after few subproblems.
#[test]
fn the_reference_costs_are_met_before_and_after_polish() {
    for (share, cost) in [(None, 16.389987441935), (Some(0.75), 16.718658565135), (Some(0.65), 18.0852435685)]
    {
        let problem = reference_slew(share);
        let (model, convex) = converge(&problem, &ScpOptions::unpolished());
        let unit = model.dynamics.units.cost;
        let before = convex.iterate.cost(&model) * unit;
        assert!((before - cost).abs() < 1e-9 * cost, "{before} before polish");
        let rows = LimitRows::of(&problem, &model);
        let newton = newton(&model, &rows, &convex.iterate, &convex.multipliers).expect("near");
        assert!((newton.cost * unit - cost).abs() < 1e-10 * cost, "{}", newton.cost * unit);
        assert!(newton.residual < 1e-12, "residual {}", newton.residual);
        let scale = newton.multipliers.costates.iter().map(|costate| costate.amax()).fold(0.0, f64::max);
        let pairs = convex.multipliers.costates.iter().zip(&newton.multipliers.costates);
        let worst = pairs.map(|(dual, costate)| (dual - costate).amax()).fold(0.0, f64::max);
        assert!(worst < 1e-6 * scale, "duals are off by {}", worst / scale);

        let chain = Chain::new(&problem, problem.steps);
        let poses = straight(&chain.model).into_iter();
        let path = path("short", &chain.model.dynamics.grid, poses);
        let method = method::ConvexIteration { chain: &chain, options: &ScpOptions::default() };
        let polished = method.improve(path, &Budget { iterations: 100, watch: Watch::NONE });
        assert!(polished.converged() && (polished.cost * unit - cost).abs() < 1e-10 * cost);
        assert!(polished.stationarity < 1e-11, "{:.1e}", polished.stationarity);
        assert!(polished.work.subproblems <= 12, "{}", polished.work.subproblems);
    }
}

#[test]
fn without_limits_the_duals_are_the_costates_of_the_shooting() {
    let problem = reference_slew(None);
    let (model, convex) = converge(&problem, &ScpOptions::unpolished());
    let solution = shot(&problem);
    let units = model.dynamics.units.costate::<6>();
    let all = &solution.trajectory.costates;
    let scale = all.iter().map(|costate| costate.abs()).fold(0.0, f64::max);
    for row in 0..problem.steps {
        let shot = nalgebra::SVector::<f64, 6>::from_row_slice(&all[6 * row..][..6]);
        let dual = &convex.multipliers.costates[row + 1];
        let dual = nalgebra::SVector::<f64, 6>::from_column_slice(dual.as_slice()).component_mul(&units);
        let difference = (shot - dual).amax();
        assert!(difference < 1e-6 * scale, "row {row}: {difference:.1e}");
    }
}
