//! Summary of a comparison of methods: a table and its conclusions.

use crate::summary::scheme;
use crate::{Console, Lines, Tone, headline, line};
use slewkit::maneuver::{Outcome, Problem};
use slewkit::numerics::figures::{counted, error, significant, time};
use slewkit::plan::Status;
use slewkit_files::spec::escape;
use slewkit_report::draw::table;
use slewkit_report::studies::methods::{
    ActiveNodes, Agreement, ByItself, Comparison, Contender, FromDuals, MethodRun, Standing, Verdict,
};

/// Returns the name of a method in tables.
pub fn name(method: Contender) -> &'static str {
    match method {
        Contender::Shooting => "shooting",
        Contender::Scp => "scp",
        Contender::ScpPolish => "scp + polish",
    }
}

fn standing(standing: Standing) -> &'static str {
    match standing {
        Standing::Ended(Status::Solved) => "solved",
        Standing::Converged => "converged",
        Standing::DoesNotApply => "does not apply",
        Standing::Ended(Status::Infeasible) => "infeasible",
        Standing::Ended(Status::NotConverged) => "not converged",
        Standing::Ended(Status::LimitReached) => "time limit",
        Standing::Ended(Status::VerificationFailed) => "verification failed",
        Standing::Ended(Status::Interrupted) => "interrupted",
    }
}

/// Returns the summary of a comparison.
pub fn lines(console: &Console, problem: &Problem, comparison: &Comparison) -> Vec<String> {
    let agreement = &comparison.agreement;
    let (verdict, tone) = match (comparison.status(), agreement.verdict) {
        (Status::Solved, Verdict::Agree) => ("the methods agree", Tone::Good),
        (Status::Solved, _) => ("solved by one method", Tone::Good),
        (Status::VerificationFailed, Verdict::Disagree) => ("the methods do not agree", Tone::Bad),
        (Status::VerificationFailed, _) => ("verification failed", Tone::Bad),
        (Status::Infeasible, _) => ("infeasible", Tone::Bad),
        (Status::NotConverged, _) => ("not converged", Tone::Bad),
        (Status::LimitReached, _) => ("limit reached", Tone::Bad),
        (Status::Interrupted, _) => ("interrupted", Tone::Note),
    };
    let scheme = scheme(problem.scheme);
    let grid = format!("{} {scheme} steps of {} s", problem.steps, significant(problem.step(), 3));
    let mut lines = vec![headline(console, &problem.name, verdict, tone), line("problem", &grid)];
    lines.extend(table(&rows(&comparison.methods), &[0, 1]).iter().map(|row| line("", row)));
    for run in &comparison.methods {
        if let Some(reason) = &run.reason {
            lines.line("", format!("{}: {}", name(run.method), escape(reason)));
        }
        if let Some(by_itself) = &run.by_itself {
            lines.line("", found_alone(run, by_itself));
        }
    }
    lines.extend(agreed(agreement));
    lines.extend(active(problem, comparison));
    lines
}

/// Describes the result that a method found independently, before it was started from the cheaper
/// plan of another method.
fn found_alone(run: &MethodRun, by_itself: &ByItself) -> String {
    let cost = by_itself.cost.map_or(String::new(), |cost| format!(", cost {}", significant(cost, 6)));
    format!(
        "{}: along the path of the cheapest result; without it {}{cost}",
        name(run.method),
        standing(by_itself.status)
    )
}

/// Returns the table of methods: a header, and one row for each method.
fn rows(runs: &[MethodRun]) -> Vec<Vec<String>> {
    let header = ["method", "", "cost", "terminal", "KKT", "subproblems", "Newton", "time"].map(String::from);
    let row = |run: &MethodRun| {
        let absent = || "–".to_string();
        let applies = run.status != Standing::DoesNotApply;
        vec![
            name(run.method).into(),
            standing(run.status).into(),
            run.cost.map_or_else(absent, |cost| significant(cost, 12)),
            run.terminal.map_or_else(absent, |terminal| error(terminal.largest())),
            run.stationarity.map_or_else(absent, error),
            run.subproblems.map_or_else(absent, |count| count.to_string()),
            if applies { run.newton_iterations.to_string() } else { absent() },
            if applies { time(run.solve_time_s) } else { absent() },
        ]
    };
    std::iter::once(header.to_vec()).chain(runs.iter().map(row)).collect()
}

fn agreed(agreement: &Agreement) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(cost) = agreement.cost {
        let text = match agreement.verdict {
            Verdict::Disagree => format!("differ by {} (relative)", error(cost)),
            _ => format!("agree to {} (relative)", error(cost)),
        };
        lines.line("costs", &text);
    }
    match (agreement.duals_before_polish, agreement.duals_after_polish, agreement.polish_change) {
        (None, None, None) => {}
        (None, None, Some(change)) => {
            lines.line("duals", format!("the polish changes them by {} of the largest", error(change)));
        }
        (before, after, _) => {
            let part =
                |value: Option<f64>, when: &str| value.map(|value| format!("{} {when} polish", error(value)));
            let parts: Vec<String> =
                [part(before, "before"), part(after, "after")].into_iter().flatten().collect();
            let text = format!("against the shooting's costates {}, of the largest", parts.join(", "));
            lines.line("duals", &text);
            if agreement.costates_unique == Some(false) {
                lines.line("", "a symmetry: costates are not unique and may differ");
            }
        }
    }
    if let Some(from_duals) = &agreement.from_duals {
        lines.line("from duals", started(from_duals));
    }
    lines
}

fn started(from_duals: &FromDuals) -> String {
    let course: Vec<String> = from_duals.residuals.iter().map(|residual| error(*residual)).collect();
    let course = course.join(" → ");
    match (from_duals.newton_steps, from_duals.outcome) {
        (Some(steps), _) => format!("the shooting needs {} ({course})", counted(steps, "Newton step")),
        (None, Outcome::Converged) => format!("the shooting converges ({course})"),
        (None, _) => format!("the shooting does not converge ({course})"),
    }
}

/// Returns the lines about active limits, according to the first method that reports them.
fn active(problem: &Problem, comparison: &Comparison) -> Vec<String> {
    let order = [Contender::ScpPolish, Contender::Shooting, Contender::Scp];
    let solved =
        |run: &&MethodRun| matches!(run.status, Standing::Ended(Status::Solved) | Standing::Converged);
    let told = order.iter().filter_map(|method| comparison.run(*method)).find(solved);
    let Some(run) = told.filter(|_| problem.is_constrained()) else { return Vec::new() };
    let nodes = |acting: &ActiveNodes| {
        let (first, last) = (acting.time_s.first(), acting.time_s.last());
        let span = first.zip(last).map_or(String::new(), |(first, last)| {
            format!(", from {} to {} s", significant(*first, 4), significant(*last, 4))
        });
        format!("{} at {}{span}", escape(&acting.name), counted(acting.time_s.len(), "node"))
    };
    let mut texts: Vec<String> = run.active.iter().map(nodes).collect();
    if texts.is_empty() {
        texts.push("no limit or constraint".into());
    }
    if let Some(differing) = comparison.agreement.active_nodes_that_differ {
        let text = match differing {
            0 => "shooting and SCP agree".into(),
            count => format!("shooting and SCP differ at {}", counted(count, "node")),
        };
        texts.push(text);
    }
    let mut lines = Vec::new();
    lines.lines("active", texts);
    lines
}
