//! Summary of a solve without a plan: the reason why it ended, its best iterate, and all attempts.

use super::found::terminal;
use super::lines::Lines;
use slewkit::maneuver::{Outcome, Problem, RungReport, Solution, TerminalError};
use slewkit::numerics::figures::{about, counted, error, short, significant};
use slewkit_files::spec::escape;

pub(super) fn stopped(solution: &Solution) -> &'static str {
    match solution.outcome {
        Outcome::Converged => "the terminal conditions are met",
        Outcome::IterationLimit => "the iteration limit was reached",
        Outcome::Stalled if solution.method.is_on_equal_steps() => {
            "no plan was found within the limits and constraints"
        }
        Outcome::Stalled => "no step reduces the terminal error any more",
        Outcome::StepTooLong => "the body turns too far in one step: the implicit equation has no solution",
        Outcome::NotFinite => "a number became NaN or infinite",
        Outcome::Singular => "the sensitivity matrix is singular: the costates do not control the end state",
        Outcome::Infeasible => "proved infeasible: no plan exists",
        Outcome::TimeLimit => "the time limit was reached",
        Outcome::Interrupted => "interrupted; this is the best iterate",
    }
}

/// Describes the terminal error of the best iterate. If the error is not finite, states that no
/// iterate reached the end.
pub(super) fn best(error: &TerminalError) -> String {
    if error.largest().is_finite() { terminal(error) } else { "no iterate reached the end".into() }
}

/// Returns remedies for a solve without a plan, the most promising remedy first.
pub fn remedies(problem: &Problem, solution: &Solution) -> Vec<String> {
    let key = if problem.duration.at_most().is_some() { "duration_at_most_s" } else { "duration_s" };
    let mut told = Vec::new();
    let proof = solution.infeasible.as_ref();
    let bound = proof.and_then(|proof| proof.duration_lower_bound);
    if let Some(longer) = solution.longer {
        let longer = short(longer);
        told.push(match (proof, bound) {
            (None, _) => format!("{key} = {longer}, for which there is a plan"),
            (Some(_), None) => format!("{key} = {longer}, enough for a turn about a fixed axis"),
            (Some(_), Some(bound)) => format!(
                "{key} = {longer}, enough for a turn about a fixed axis; no plan is shorter than {} s",
                about(bound)
            ),
        });
    } else if let Some(bound) = bound {
        let bound = about(bound);
        told.push(format!("{key} above {bound}: no plan is shorter than that, and a plan may need more"));
    }
    match solution.outcome {
        Outcome::Converged | Outcome::Interrupted => {}
        Outcome::Infeasible => {
            told.push(
                "changes of the quantities in the reason; or other torque axes, terminal rates or \
             attitudes"
                    .into(),
            );
        }
        Outcome::TimeLimit => told.push("more time to search, solver.time_limit_s; or fewer steps".into()),
        Outcome::IterationLimit => told.push("more solver.max_iterations, or more maneuver.steps".into()),
        Outcome::StepTooLong => told.push("more maneuver.steps".into()),
        Outcome::Singular => {
            told.push("other torque axes, or rates at the end that the present axes can reach".into())
        }
        Outcome::Stalled | Outcome::NotFinite => {
            told.push("more steps, larger limits, or solver.search = \"thorough\"".into());
        }
    }
    told
}

/// Describes the terminal error of the best iterate, which was the nearest to the target.
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

/// Largest number of consecutive runs of one strategy that are listed individually; more runs share
/// a line. The plan file lists all runs.
const CROWD: usize = 8;

/// Lists the attempts, with one line for each run or for several consecutive runs of one strategy.
pub(super) fn ladder(rungs: &[RungReport]) -> Vec<String> {
    let texts = rungs
        .chunk_by(|a, b| a.rung == b.rung)
        .flat_map(|runs| if runs.len() > CROWD { vec![crowd(runs)] } else { runs.iter().map(run).collect() });
    let mut lines = Vec::new();
    lines.lines("attempts", texts.map(|text| text.trim_end().to_string()));
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
