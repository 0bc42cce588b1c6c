//! Summaries that commands print on the console.

use super::advice::{advice, word};
use super::{Console, SpecArgs, Tone};
use slewkit::assured::Beside;
use slewkit::feedback::Gains;
use slewkit::maneuver::{Problem, Settings};
use slewkit::plan::{Plan, Status};
use slewkit::verify::Verification;
use slewkit_files::export::Target;
use slewkit_files::flown::MarginsRecord;
use slewkit_files::identity::Identity;
use slewkit_files::spec::{ClosedLoop, escape};
use slewkit_report::summary;
pub use slewkit_report::summary::{Judged, Lines, line, scheme};
use std::path::Path;

/// Returns the headline of a summary, with the name on the left and the verdict on the right.
pub fn headline(console: &Console, name: &str, verdict: &str, tone: Tone) -> String {
    summary::headline(console.colour, name, verdict, tone)
}

/// Prints the last line of a summary, which states the name of the written file.
pub fn wrote(console: &mut Console, target: &Target) {
    console.say(&line("wrote", &escape(&target.path().to_string_lossy())));
}

/// Data from which the summary of `slew plan` is made.
pub struct Told<'a> {
    pub problem: &'a Problem,
    pub settings: &'a Settings,
    pub plan: &'a Plan,
    pub identity: &'a Identity,
    /// True if the summary includes the details of the search.
    pub verbose: bool,
    /// Path of the plan file that will be written; `None` if none will be written.
    pub file: Option<&'a Path>,
    /// Gains along the plan, if no covariances were computed.
    pub gains: Option<&'a Gains>,
    /// Gains, covariances and probabilities of violation along the plan; `None` if the spec does
    /// not request them.
    pub beside: Option<(&'a ClosedLoop, &'a Beside)>,
    /// Margins for the chance constraints; `None` if the spec has none. They exist even if no plan
    /// was found.
    pub margins: Option<&'a MarginsRecord>,
    /// Label and text about the plan given by `--guess` or `--warm`: how it was used, or why it was
    /// not used.
    pub begun: Option<(&'a str, &'a str)>,
}

/// Returns the summary of a plan, solved or not, with a suggestion for the next command.
pub fn plan(console: &Console, args: &SpecArgs, told: &Told) -> String {
    let Told { problem, settings, plan, identity, verbose, file, beside, margins, gains, begun } = *told;
    let mut lines = summary::plan(console.colour, problem, settings, plan, identity);
    if verbose {
        lines.extend(summary::details(console.colour, problem, settings, plan, identity));
    }
    if let Some((label, text)) = begun {
        lines.text(label, escape(text));
    }
    let times = &plan.solution.trajectory.time;
    lines.extend(gains.iter().flat_map(|gains| summary::flown::gains(gains, times)));
    if let Some((closed_loop, beside)) = beside {
        lines.extend(summary::flown::beside(problem, closed_loop, beside, margins));
    } else if let Some(margins) = margins {
        lines.text("margin", summary::flown::kept(margins));
    }
    let advice = advice(args, problem, settings, plan);
    if advice.is_empty() && plan.status == Status::Solved {
        let uncertain = beside.is_some_and(|(_, beside)| beside.open.is_some());
        lines.push(line("next", &next(args, file, verbose, uncertain)));
    }
    for text in &advice {
        lines.extend(tried(text));
    }
    lines.join("\n")
}

/// Returns the suggestion for the next command after a solved plan. `file` is the path of the plan
/// file that will be written; `uncertain` is true if the spec states an uncertainty.
pub fn next(args: &SpecArgs, file: Option<&Path>, verbose: bool, uncertain: bool) -> String {
    let more = if verbose { "" } else { "; -v reports how it was found" };
    if let Some(file) = file {
        let name = word(&file.to_string_lossy());
        if uncertain {
            return format!("slew fly {name}{more}");
        }
        return format!("slew report {name} -o plan.html{more}");
    }
    let spec = word(&args.spec.to_string_lossy());
    let command = format!("slew plan {spec} -o plan.json");
    if command.chars().count() + more.chars().count() <= summary::TEXT {
        format!("{command}{more}")
    } else {
        format!(
            "-o plan.json writes it, --report plan.html shows it{}",
            if verbose { "" } else { "; more: -v" }
        )
    }
}

/// Formats a suggested command as lines. If the command with its reason is too long for a line, it
/// continues on the next line in the notation of a shell.
fn tried(text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    if text.chars().count() <= summary::TEXT {
        lines.line("try", text);
        return lines;
    }
    let Some((command, why)) = text.split_once("   # ") else {
        lines.text("try", text);
        return lines;
    };
    if command.chars().count() <= summary::TEXT {
        lines.line("try", command);
    } else {
        // Line breaks precede options, so that an option and its value remain on one line.
        let mut parts: Vec<String> = Vec::new();
        for (index, part) in command.split(" --set ").enumerate() {
            let set = if index == 0 { part.to_string() } else { format!("--set {part}") };
            match parts.last_mut() {
                Some(last) if last.chars().count() + set.chars().count() + 3 <= summary::TEXT => {
                    last.push_str(&format!(" {set}"));
                }
                Some(_) => parts.push(format!("  {set}")),
                None => parts.push(set),
            }
        }
        let last = parts.len() - 1;
        let told = parts.iter().enumerate();
        lines.lines(
            "try",
            told.map(|(index, part)| if index == last { part.clone() } else { format!("{part} \\") }),
        );
    }
    lines.lines("", summary::wrapped(why, summary::TEXT - 2).iter().map(|part| format!("# {part}")));
    lines
}

/// Returns the lines about margins and about the results of the witnesses, including every failed
/// check.
pub fn verified(console: &Console, judged: &Judged, verification: &Verification) -> Vec<String> {
    summary::verified(console.colour, judged, verification)
}
