//! Chart of the convergence. It shows the residuals of the solver runs that led to the plan or, if
//! no plan was found, of the runs with the smallest residuals.

use super::charts::shown;
use super::{Shown, Subject};
use crate::draw::{Axis, Chart, Curve, Shape};
use slewkit::maneuver::{Outcome, RungReport};

/// Largest number of solver runs that the chart shows.
const RUNS: usize = 6;

/// Returns the chart of the residuals; `None` if no iteration ran.
pub(super) fn chart(subject: &Subject) -> Option<Shown> {
    let solution = &subject.plan.solution;
    let drawable = |rung: &&RungReport| rung.residuals.iter().any(|residual| *residual > 0.0);
    let runs: Vec<&RungReport> = solution.ladder.iter().filter(drawable).collect();
    let won = |rung: &&&RungReport| rung.start == solution.start && rung.outcome == Outcome::Converged;
    let mut shown_runs: Vec<&RungReport> = runs.iter().filter(won).copied().collect();
    let solved = solution.outcome == Outcome::Converged && !shown_runs.is_empty();
    if !solved {
        shown_runs = runs;
        let last = |rung: &RungReport| {
            let last = rung.residuals.last().copied().unwrap_or(f64::INFINITY);
            if last.is_finite() { last } else { f64::INFINITY }
        };
        shown_runs.sort_by(|a, b| last(a).total_cmp(&last(b)));
    }
    let first = shown_runs.len().saturating_sub(RUNS);
    let drawn = if solved { &shown_runs[first..] } else { &shown_runs[..shown_runs.len().min(RUNS)] };
    if drawn.is_empty() {
        return None;
    }
    let mut before = 0.0;
    let curves = drawn.iter().enumerate().map(|(style, rung)| {
        let points: Vec<(f64, f64)> =
            rung.residuals.iter().enumerate().map(|(k, residual)| (before + k as f64, *residual)).collect();
        // The runs that led to the plan are drawn one after the other; the runs of a failed search
        // start at the same abscissa.
        before += if solved { points.len().saturating_sub(1) as f64 } else { 0.0 };
        let from = if rung.start.is_empty() { String::new() } else { format!(", {}", rung.start) };
        let name = format!("{}\n{} steps{from}", rung.rung.name().replace('_', " "), rung.steps);
        Curve { name, style, shape: Shape::Marked(points) }
    });
    let curves = curves.collect();
    let chart =
        Chart::new("Convergence", Axis::linear("iteration"), Axis::logarithmic("scaled residual"), curves);
    let remark = if solved {
        "the runs that led to the plan, in order, on each grid"
    } else {
        "the nearest runs, side by side"
    };
    Some(shown("convergence", chart, remark))
}
