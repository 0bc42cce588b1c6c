//! Where a solve came to where it has no plan: why it stopped, its best iterate, what was tried.

use super::found::terminal;
use super::lines::Lines;
use slewkit::maneuver::{Method, Outcome, RungReport, Solution, TerminalError};
use slewkit::numerics::figures::{counted, error, significant};
use slewkit_files::spec::escape;

pub(super) fn stopped(solution: &Solution) -> &'static str {
    match solution.outcome {
        Outcome::Converged => "the terminal conditions are met",
        Outcome::IterationLimit => "the iteration limit was reached",
        Outcome::Stalled if solution.method == Method::Scp => {
            "no plan was found within the limits and constraints"
        }
        Outcome::Stalled => "no step reduces the terminal error any more",
        Outcome::StepTooLong => "the body turns too far in one step: the implicit equation has no solution",
        Outcome::NotFinite => "a number became NaN or infinite",
        Outcome::Singular => "the sensitivity matrix is singular: the costates do not steer the end state",
        Outcome::Infeasible => "proved infeasible: no plan exists",
        Outcome::TimeLimit => "the time limit was reached",
        Outcome::Interrupted => "interrupted; this is the best iterate",
    }
}

/// The terminal error of the best iterate, if one reached the end at all.
pub(super) fn best(error: &TerminalError) -> String {
    if error.largest().is_finite() { terminal(error) } else { "no iterate reached the end".into() }
}

/// How near the best iterate came to the end.
pub(super) fn nearest(error: &TerminalError) -> String {
    let attitude = error.attitude_rad.to_degrees();
    if !error.largest().is_finite() {
        return "no iterate reached the end".into();
    }
    let momentum = significant(100.0 * error.momentum_relative, 2);
    let told =
        format!("{} deg off, momentum by {momentum} % of mean inertia / duration", significant(attitude, 3));
    match error.position_relative {
        Some(position) => format!("{told}, position by {} %", significant(100.0 * position, 2)),
        None => told,
    }
}

fn ended(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Converged => "converged",
        Outcome::IterationLimit => "iteration limit",
        Outcome::Stalled => "stalled",
        Outcome::StepTooLong => "step too long",
        Outcome::NotFinite => "not finite",
        Outcome::Singular => "singular",
        Outcome::Infeasible => "infeasible",
        Outcome::TimeLimit => "time limit",
        Outcome::Interrupted => "interrupted",
    }
}

/// Runs of one rung, one after the other, beyond which they share a line; a file has them all.
const CROWD: usize = 8;

/// Everything tried, one line a run, a crowd of equal ones in one.
pub(super) fn ladder(rungs: &[RungReport]) -> Vec<String> {
    let texts = rungs
        .chunk_by(|a, b| a.rung == b.rung)
        .flat_map(|runs| if runs.len() > CROWD { vec![crowd(runs)] } else { runs.iter().map(run).collect() });
    let mut lines = Vec::new();
    lines.lines("ladder", texts.map(|text| text.trim_end().to_string()));
    lines
}

fn run(rung: &RungReport) -> String {
    let course = match (rung.residuals.first(), rung.residuals.last()) {
        (Some(first), Some(last)) => format!("{} → {}", error(*first), error(*last)),
        _ => String::new(),
    };
    let (name, start) = (rung.rung, escape(&rung.start));
    let (outcome, iterations) = (ended(rung.outcome), counted(rung.iterations, "iteration"));
    format!("{name:<15} {start:<9} {:>7} steps  {outcome:<15}  {iterations:>14}  {course}", rung.steps)
}

fn crowd(runs: &[RungReport]) -> String {
    let mut outcomes: Vec<(&str, usize)> = Vec::new();
    for rung in runs {
        match outcomes.iter_mut().find(|(name, _)| *name == ended(rung.outcome)) {
            Some((_, count)) => *count += 1,
            None => outcomes.push((ended(rung.outcome), 1)),
        }
    }
    let outcomes: Vec<_> = outcomes.iter().map(|(name, count)| format!("{count} {name}")).collect();
    let last = runs.iter().filter_map(|rung| rung.residuals.last());
    let best =
        last.copied().min_by(f64::total_cmp).map_or(String::new(), |best| format!(", best {}", error(best)));
    format!("{:<15} {} runs: {}{best}", runs[0].rung, runs.len(), outcomes.join(", "))
}
