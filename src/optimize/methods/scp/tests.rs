//! Comparison of SCP with reference costs and with shooting.

use super::*;
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::tests::reference::newton::newton;
use crate::optimize::chain::tests::{reference_slew, shot, straight};
use crate::optimize::chain::{Chain, Multipliers, first_iterate, path};
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::{Budget, Method};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Returns the initial iterate along the fixed-axis path.
fn start(chain: &Chain, watch: &Watch) -> Iterate {
    first_iterate::along(&chain.model, &chain.rows, &straight(&chain.model), 1.0, watch)
}

fn converge(chain: &Chain, options: &ScpOptions, watch: &Watch) -> (Convex, Iterate, Multipliers) {
    let start = start(chain, watch);
    let program = ChainProgram::of(&chain.model, &chain.rows, None, &start, &Tuning::default());
    let mut point = Point::of(program.shape());
    program.point(&start, &mut point);
    let convex = run(&program, point, options, watch).unwrap();
    let (iterate, multipliers) = program.found(&convex.point, &convex.duals, &convex.values.rows);
    (convex, iterate, multipliers)
}

/// No observer is polled within the cone solver, which reads only the flag.
#[test]
fn a_flag_stops_the_convex_iteration_inside_of_a_subproblem() {
    let problem = reference_slew(Some(0.75));
    let chain = Chain::new(&problem, problem.steps);
    for set in [false, true] {
        let flag = Arc::new(AtomicBool::new(set));
        let watch = Watch { flag: Some(&flag), ..Watch::NONE };
        let (convex, ..) = converge(&chain, &ScpOptions::default(), &watch);
        let outcome = if set { Outcome::Interrupted } else { Outcome::Converged };
        assert_eq!(convex.outcome, outcome);
    }
}

/// After a stop the iteration does not wait for a large cone program, not even during the setup of
/// its solver.
#[cfg(feature = "threads")]
#[test]
fn a_stop_leaves_a_large_subproblem_to_itself() {
    let problem = reference_slew(None).with_steps(2_300);
    let chain = Chain::new(&problem, problem.steps);
    let start = start(&chain, &Watch::NONE);
    let program = ChainProgram::of(&chain.model, &chain.rows, None, &start, &Tuning::default());
    let (mut point, mut at) = (Point::of(program.shape()), Derivatives::of(program.shape()));
    program.point(&start, &mut point);
    assert!(program.derivatives(&point, &Duals::of(program.shape()), &mut at));
    let weights = Weights { defect: 100.0, violation: Vec::new(), radius: RADIUS.0 };
    for (outcome, failure) in [(Outcome::Interrupted, Failure::Stopped), (Outcome::TimeLimit, Failure::Time)]
    {
        let watch = Watch { interrupt: &|| Some(outcome), ..Watch::NONE };
        let left = Subproblem::new(&program, 1e-6, watch).solve(&at, &weights, None);
        assert_eq!(left.err(), Some(failure));
    }
}

/// Claim: the costs of the reference slew are those that another program found. The duals of the
/// convex iteration are the costates that Newton's method on the active set finds from there, and
/// the interior-point method refines the plan after few subproblems.
#[test]
fn the_reference_costs_are_met_before_and_after_polish() {
    for (share, cost) in [(None, 16.389987441935), (Some(0.75), 16.718658565135), (Some(0.65), 18.0852435685)]
    {
        let problem = reference_slew(share);
        let chain = Chain::new(&problem, problem.steps);
        let (model, rows) = (&chain.model, &chain.rows);
        let (_, iterate, multipliers) = converge(&chain, &ScpOptions::unpolished(), &Watch::NONE);
        let unit = model.dynamics.units.cost;
        let before = iterate.cost(model) * unit;
        assert!((before - cost).abs() < 1e-9 * cost, "{before} before polish");
        let newton = newton(model, rows, &iterate, &multipliers).expect("near");
        assert!((newton.cost * unit - cost).abs() < 1e-10 * cost, "{}", newton.cost * unit);
        assert!(newton.residual < 1e-12, "residual {}", newton.residual);
        let scale = newton.multipliers.costates.iter().map(|costate| costate.amax()).fold(0.0, f64::max);
        let pairs = multipliers.costates.iter().zip(&newton.multipliers.costates);
        let worst = pairs.map(|(dual, costate)| (dual - costate).amax()).fold(0.0, f64::max);
        assert!(worst < 1e-6 * scale, "duals are off by {}", worst / scale);

        let path = path("short", &model.dynamics.grid, straight(model).into_iter());
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
    let chain = Chain::new(&problem, problem.steps);
    let (_, _, multipliers) = converge(&chain, &ScpOptions::unpolished(), &Watch::NONE);
    let solution = shot(&problem);
    let units = chain.model.dynamics.units.costate::<6>();
    let all = &solution.trajectory.costates;
    let scale = all.iter().map(|costate| costate.abs()).fold(0.0, f64::max);
    for row in 0..problem.steps {
        let shot = nalgebra::SVector::<f64, 6>::from_row_slice(&all[6 * row..][..6]);
        let dual = &multipliers.costates[row + 1];
        let dual = nalgebra::SVector::<f64, 6>::from_column_slice(dual.as_slice()).component_mul(&units);
        let difference = (shot - dual).amax();
        assert!(difference < 1e-6 * scale, "row {row}: {difference:.1e}");
    }
}
