//! Continuation in the limits of the inputs.

use crate::maneuver::solution::Outcome;
use crate::optimize::discrete::step::StepError;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::continuation::{Pace, Step, follow};
use crate::optimize::methods::driver::{Interrupt, Report, run};
use crate::optimize::methods::lifted::Nodes;
use crate::optimize::methods::shooting::newton::Newton;
use nalgebra::SVector;

/// Residual to which an intermediate problem is solved.
const TOLERANCE: f64 = 1e-8;
/// Iterations granted to an intermediate problem: a good step needs three or four.
const ITERATIONS: usize = 12;
/// How far the parameter goes at once.
const PACE: Pace = Pace { first: 0.2, least: 1.0 / 512.0, most: 1.0, longer: 2.0, shorter: 0.25 };
/// The least tolerance of an intermediate problem.
const ROUND_OFF: f64 = 1e-13;

/// Follows an extremal from `solved = (s, λ_{−1})` to the problem at `s = 1`: how far that went.
fn extremals<'a, const N: usize>(
    solved: (f64, SVector<f64, N>),
    tolerance: f64,
    interrupt: Interrupt,
    problem: impl Fn(f64) -> BoundaryValueProblem<'a, N>,
) -> ((f64, SVector<f64, N>), Report) {
    let mut report = Report::failed(Outcome::Converged);
    let mut solved = vec![solved];
    let reached = follow(
        &PACE,
        0.0_f64,
        |at| *at >= 1.0,
        |at, step| {
            if let Some(outcome) = interrupt() {
                report.outcome = outcome;
                return Step::Stopped;
            }
            let next = (at + step).min(1.0);
            let problem = problem(next);
            let Ok(newton) = Newton::new(&problem, tolerance, predict(&solved, next), None) else {
                return Step::Failed;
            };
            let (newton, run) = run(newton, ITERATIONS, interrupt);
            report.iterations += run.iterations;
            if run.outcome != Outcome::Converged {
                return Step::Failed;
            }
            solved.push((next, newton.costate));
            Step::Solved { at: next, easily: run.iterations <= ITERATIONS / 2 }
        },
    );
    if reached.is_err() && report.outcome == Outcome::Converged {
        report.outcome = Outcome::Stalled;
    }
    (solved[solved.len() - 1], report)
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
pub(super) fn in_limits<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    from: &Wider<N>,
    interrupt: Interrupt,
) -> (Wider<N>, Report) {
    let factor = |s: f64| if s < 1.0 { from.factor.powf(1.0 - s) } else { 1.0 };
    // A small maneuver is not solved because its error is small.
    let tolerance = (TOLERANCE * from.costate.amax().min(1.0)).max(ROUND_OFF);
    let ((at, costate), report) =
        extremals((0.0, from.costate), tolerance, interrupt, |s| bvp.relaxed(factor(s)));
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
