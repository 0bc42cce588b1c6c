//! Comparison of the minimum-time, minimum-fuel and minimum-effort plans of one maneuver, as text
//! and as JSON.

use super::{Args, GENERATOR, page};
use crate::plan::{Watcher, refusal};
use crate::{Console, Exit, Failure, Lines, Tone, headline, interrupt, line};
use slewkit::maneuver::Objective;
use slewkit::numerics::figures::{error, significant, time};
use slewkit::plan::Status;
use slewkit_files::spec::{Loaded, escape};
use slewkit_report::Motion;
use slewkit_report::draw::table;
use slewkit_report::studies::objectives::{ObjectiveRun, STRETCH, compare};
use slewkit_report::studies::ways::{self, WayRun};

/// Compares the objectives, prints the result, and writes the page.
pub fn run(args: &Args, loaded: &Loaded, console: &mut Console) -> Result<Exit, Failure> {
    let Loaded { problem, settings, identity, .. } = loaded;
    let target = args.target(&loaded.files)?;
    interrupt::watch();
    // For a minimum-time or minimum-fuel maneuver, the methods are compared first, unless only the
    // objectives are requested.
    let ways = (problem.switches() && !args.objectives)
        .then(|| ways::compare(problem, settings, &mut Watcher(console)).map_err(refusal))
        .transpose()?;
    let runs = compare(problem, settings, &mut Watcher(console)).map_err(refusal)?;
    let status = status(&runs);
    let (verdict, tone) = match status {
        Status::Solved => ("objectives compared", Tone::Good),
        Status::Interrupted => ("interrupted", Tone::Note),
        _ => ("no plan", Tone::Bad),
    };
    let mut lines = vec![headline(console, &problem.name, verdict, tone)];
    if let Some(ways) = &ways {
        lines.extend(table(&ways_told(ways), &[0, 1]).iter().map(|row| line("", row)));
        let reasons = ways.iter().filter_map(|run| Some((run.way, run.reason.as_ref()?)));
        for (way, reason) in reasons {
            lines.line("", format!("{}: {}", way.replace('_', " "), escape(reason)));
        }
        lines.push(String::new());
    }
    lines.extend(table(&rows(&runs), &[0, 1]).iter().map(|row| line("", row)));
    for run in &runs {
        if let Some(reason) = &run.reason {
            lines.line("", format!("{}: {}", run.minimises, escape(reason)));
        }
    }
    if problem.objective == Objective::Time {
        lines.line(
            "duration",
            format!("not given: effort and fuel have {STRETCH} times the shortest duration"),
        );
    } else if problem.duration.known().is_none() {
        lines.line("duration", "not given: effort and fuel have the duration that the price of time selects");
    }
    console.say(&lines.join("\n"));
    let document = document! {
        format: 1,
        generator: GENERATOR,
        compares: "objectives",
        status: status,
        exit_code: status.exit_code(),
        name: &problem.name,
        ways if some: ways.as_ref(),
        objectives: &runs,
    };
    args.report.print(&document)?;
    let motions = runs.iter().filter_map(|run| {
        let (name, trajectory) = (format!("least {}", run.minimises), run.trajectory.clone()?);
        Some(Motion { name, held: run.switches.is_some(), trajectory })
    });
    page(target.as_ref(), &document, (motions.collect(), &identity.inputs), Vec::new(), console)?;
    Ok(if status == Status::Solved { Exit::Solved } else { Exit::Plan(status) })
}

/// Returns the status of the comparison. It is the first status `Solved` or `Interrupted` among the
/// runs; if there is none, it is the status of the first run that could be planned.
fn status(runs: &[ObjectiveRun]) -> Status {
    let mut known = runs.iter().filter_map(|run| run.status);
    let first = known.clone().next().unwrap_or(Status::NotConverged);
    known.find(|status| matches!(status, Status::Solved | Status::Interrupted)).unwrap_or(first)
}

/// Returns the table of methods: a header, and one row for each method.
fn ways_told(runs: &[WayRun]) -> Vec<Vec<String>> {
    let header = ["way", "", "duration / s", "cost", "switches", "gap", "smoothing", "misses / deg", "time"];
    let row = |run: &WayRun| {
        let none = || "–".to_string();
        let number = |value: Option<f64>| value.map_or_else(none, |value| significant(value, 8));
        let small = |value: Option<f64>| value.map_or_else(none, error);
        vec![
            run.way.replace('_', " "),
            run.status.map_or("does not apply", Status::name).replace('_', " "),
            number(run.duration_s),
            number(run.cost),
            run.switches.map_or_else(none, |count| count.to_string()),
            small(run.gap),
            small(run.smoothing),
            small(run.continuous_miss_deg),
            run.status.map_or_else(none, |_| time(run.solve_time_s)),
        ]
    };
    std::iter::once(header.map(String::from).to_vec()).chain(runs.iter().map(row)).collect()
}

/// Returns the table of objectives: a header, and one row for each objective.
fn rows(runs: &[ObjectiveRun]) -> Vec<Vec<String>> {
    let header = ["least", "", "duration / s", "effort", "fuel", "switches", "gap", "time"].map(String::from);
    let row = |run: &ObjectiveRun| {
        let number =
            |value: Option<f64>| value.map_or_else(|| "–".to_string(), |value| significant(value, 8));
        vec![
            run.minimises.into(),
            run.status.map_or("does not apply", Status::name).replace('_', " "),
            number(run.duration_s),
            number(run.effort),
            number(run.fuel),
            run.switches.map_or_else(|| "–".to_string(), |count| count.to_string()),
            run.gap.map_or_else(|| "–".to_string(), error),
            run.status.map_or_else(|| "–".to_string(), |_| time(run.solve_time_s)),
        ]
    };
    std::iter::once(header.to_vec()).chain(runs.iter().map(row)).collect()
}
