//! Continuation: from the uncontrolled motion to the target, and from a short horizon to the whole.

use super::Context;
use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::Outcome;
use crate::numerics::compensated::Sum;
use crate::optimize::methods::driver::{Report, run};
use crate::optimize::methods::lifted::{Lifted, Nodes};
use crate::optimize::methods::shooting::guess::wound;
use crate::optimize::methods::shooting::newton::{Newton, outcome_of};
use crate::optimize::methods::shooting::refine::failed;
use crate::optimize::search::geodesic;
use crate::optimize::step::{Point, StepError};
use crate::optimize::sweep::BoundaryValueProblem;
use nalgebra::SVector;

/// Residual to which an intermediate problem is solved.
const TOLERANCE: f64 = 1e-8;
/// Iterations granted to an intermediate problem: a good step needs three or four.
const ITERATIONS: usize = 12;
/// First and smallest step of the parameter.
const FIRST_STEP: f64 = 0.2;
const SMALLEST_STEP: f64 = 1.0 / 512.0;
/// The least tolerance of an intermediate problem.
const ROUND_OFF: f64 = 1e-13;

/// Walks a parameter from `from` to 1: `solve(s)` says whether the problem at `s` was solved, and in
/// how many iterations.
fn walk(
    context: &Context,
    from: f64,
    report: &mut Report,
    mut solve: impl FnMut(f64) -> Result<usize, usize>,
) -> bool {
    let (mut at, mut step) = (from, FIRST_STEP);
    while at < 1.0 {
        if let Some(outcome) = context.interrupt() {
            report.outcome = outcome;
            return false;
        }
        let next = (at + step).min(1.0);
        match solve(next) {
            Ok(iterations) => {
                report.iterations += iterations;
                at = next;
                if iterations <= ITERATIONS / 2 {
                    step *= 2.0;
                }
            }
            Err(iterations) => {
                report.iterations += iterations;
                step *= 0.25;
                if step < SMALLEST_STEP {
                    report.outcome = Outcome::Stalled;
                    return false;
                }
            }
        }
    }
    true
}

/// Continuation in the boundary data: the target moves from the ballistic end point to the real one,
/// the way round with `turns` more turns.
pub(crate) fn in_target<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    turns: i32,
    context: &Context,
) -> (Option<SVector<f64, N>>, Report) {
    let mut report = failed(Outcome::Converged);
    let ballistic = match bvp.ballistic_end() {
        Ok(point) => point,
        Err(error) => return (None, failed(outcome_of(error))),
    };
    let target = bvp.target;
    let relative = ballistic.attitude.value.tr_mul(&target.attitude.value);
    let way = wound(&lie::log(&relative), turns);
    let between = |s: f64| Point {
        position: Sum::new(ballistic.position.value.lerp(&target.position.value, s)),
        linear_momentum: Sum::new(ballistic.linear_momentum.value.lerp(&target.linear_momentum.value, s)),
        attitude: Sum::new(ballistic.attitude.value * lie::exp(&(way * s))),
        momentum: Sum::new(ballistic.momentum.value.lerp(&target.momentum.value, s)),
    };
    let mut solved = vec![(0.0, SVector::<f64, N>::zeros())];
    let reached = walk(context, 0.0, &mut report, |s| {
        let problem = bvp.with_target(between(s));
        let newton = Newton::new(&problem, TOLERANCE, predict(&solved, s), None).map_err(|_| 0usize)?;
        let (newton, run) = run(newton, ITERATIONS, &|| context.interrupt());
        if run.outcome != Outcome::Converged {
            return Err(run.iterations);
        }
        solved.push((s, newton.costate));
        Ok(run.iterations)
    });
    (reached.then(|| solved[solved.len() - 1].1), report)
}

/// Secant extrapolation of the last two solutions.
fn predict<const N: usize>(solved: &[(f64, SVector<f64, N>)], s: f64) -> SVector<f64, N> {
    let (s1, last) = solved[solved.len() - 1];
    if solved.len() < 2 {
        return last;
    }
    let (s0, before) = solved[solved.len() - 2];
    last + (last - before) * ((s - s1) / (s1 - s0))
}

/// Lifted Newton on one grid from a smooth path.
pub(crate) fn lifted<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    nodes: Result<Nodes<N>, StepError>,
    tolerance: f64,
    iterations: usize,
    context: &Context,
) -> (Option<Nodes<N>>, Report) {
    let lifted = match nodes.and_then(|nodes| Lifted::new(bvp, tolerance, nodes)) {
        Ok(lifted) => lifted,
        Err(error) => return (None, failed(outcome_of(error))),
    };
    let (lifted, report) = run(lifted, iterations, &|| context.interrupt());
    ((report.outcome == Outcome::Converged).then_some(lifted.nodes), report)
}

/// Continuation in the horizon with the lifted Newton: a short maneuver hardly feels its environment
/// and its boundary rates; it is stretched to the whole.
pub(crate) fn in_horizon<const N: usize>(
    problem: &Problem,
    steps: usize,
    turns: i32,
    context: &Context,
) -> (Option<Nodes<N>>, Report) {
    let mut report = failed(Outcome::Converged);
    let at = |s: f64| {
        let mut shorter = problem.clone();
        shorter.duration *= s;
        BoundaryValueProblem::<N>::new(&shorter, steps)
    };
    let from = 0.2;
    let first = at(from);
    let (nodes, first_report) =
        lifted(&first, geodesic::nodes(&first, turns, &Vector3::zeros()), TOLERANCE, 2 * ITERATIONS, context);
    report.iterations += first_report.iterations;
    let Some(mut nodes) = nodes else {
        report.outcome = first_report.outcome;
        return (None, report);
    };
    let reached = walk(context, from, &mut report, |s| {
        let bvp = at(s);
        let (next, run) = lifted(&bvp, Ok(nodes.clone()), TOLERANCE, ITERATIONS, context);
        match next {
            Some(next) => {
                nodes = next;
                Ok(run.iterations)
            }
            None => Err(run.iterations),
        }
    });
    (reached.then_some(nodes), report)
}

/// An extremal within limits that are wider than the true ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wider<const N: usize> {
    /// Its costate.
    pub costate: SVector<f64, N>,
    /// How many times as large as the true limits those are that it keeps.
    pub factor: f64,
}

/// Continuation in the limits of the inputs: drawn in from those that an extremal keeps, in equal ratios,
/// to the true ones; how far that went.
///
/// Where limits become too tight for any maneuver, costates grow without bound: the walk stops short of
/// there, and begun anew it takes shorter steps.
pub(crate) fn in_limits<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    from: &Wider<N>,
    context: &Context,
) -> (Wider<N>, Report) {
    let factor = |s: f64| if s < 1.0 { from.factor.powf(1.0 - s) } else { 1.0 };
    // A small maneuver is not solved because its error is small.
    let tolerance = (TOLERANCE * from.costate.amax().min(1.0)).max(ROUND_OFF);
    let mut report = failed(Outcome::Converged);
    let mut solved = vec![(0.0, from.costate)];
    walk(context, 0.0, &mut report, |s| {
        let problem = bvp.relaxed(factor(s));
        let newton = Newton::new(&problem, tolerance, predict(&solved, s), None).map_err(|_| 0usize)?;
        let (newton, run) = run(newton, ITERATIONS, &|| context.interrupt());
        if run.outcome != Outcome::Converged {
            return Err(run.iterations);
        }
        solved.push((s, newton.costate));
        Ok(run.iterations)
    });
    let (at, costate) = solved[solved.len() - 1];
    (Wider { costate, factor: factor(at) }, report)
}

/// The nodes of the extremal from `costate`.
pub(crate) fn nodes_of<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
) -> Result<Nodes<N>, StepError> {
    let mut nodes = Nodes { points: Vec::new(), costates: Vec::new() };
    bvp.sweep_observed(costate, |node| {
        nodes.points.push(node.point);
        nodes.costates.push(node.costate.to_vector());
    })?;
    Ok(nodes)
}
