//! Continuation in the limits of the inputs.

use crate::maneuver::solution::Outcome;
use crate::optimize::methods::driver::{Interrupt, Report, run};
use crate::optimize::methods::lifted::Nodes;
use crate::optimize::methods::shooting::newton::Newton;
use crate::optimize::step::StepError;
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
    interrupt: Interrupt,
    from: f64,
    report: &mut Report,
    mut solve: impl FnMut(f64) -> Result<usize, usize>,
) {
    let (mut at, mut step) = (from, FIRST_STEP);
    while at < 1.0 {
        if let Some(outcome) = interrupt() {
            report.outcome = outcome;
            return;
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
                    return;
                }
            }
        }
    }
}

/// Follows an extremal from `solved = (s, λ_{−1})` to the problem at `s = 1`: how far that went.
fn follow<'a, const N: usize>(
    solved: (f64, SVector<f64, N>),
    tolerance: f64,
    interrupt: Interrupt,
    problem: impl Fn(f64) -> BoundaryValueProblem<'a, N>,
) -> ((f64, SVector<f64, N>), Report) {
    let mut report = Report::failed(Outcome::Converged);
    let mut solved = vec![solved];
    walk(interrupt, 0.0, &mut report, |s| {
        let problem = problem(s);
        let newton = Newton::new(&problem, tolerance, predict(&solved, s), None).map_err(|_| 0usize)?;
        let (newton, run) = run(newton, ITERATIONS, interrupt);
        if run.outcome != Outcome::Converged {
            return Err(run.iterations);
        }
        solved.push((s, newton.costate));
        Ok(run.iterations)
    });
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
        follow((0.0, from.costate), tolerance, interrupt, |s| bvp.relaxed(factor(s)));
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
