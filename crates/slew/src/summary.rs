//! What commands tell in words on this console.

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

/// The first line: name to the left, verdict to the right.
pub fn headline(console: &Console, name: &str, verdict: &str, tone: Tone) -> String {
    summary::headline(console.colour, name, verdict, tone)
}

/// The closing line of a summary.
pub fn wrote(console: &mut Console, target: &Target) {
    console.say(&line("wrote", &escape(&target.path().to_string_lossy())));
}

/// What `slew plan` tells of a plan, and where it goes.
pub struct Told<'a> {
    pub problem: &'a Problem,
    pub settings: &'a Settings,
    pub plan: &'a Plan,
    pub identity: &'a Identity,
    /// How it was found as well.
    pub verbose: bool,
    /// The plan file that will be written.
    pub file: Option<&'a Path>,
    /// Gains alone, where nothing else is known beside it.
    pub gains: Option<&'a Gains>,
    /// What is known of it beside it, as the spec asks.
    pub beside: Option<(&'a ClosedLoop, &'a Beside)>,
    /// What keeping chances took, where some are asked, also of a plan that is not solved.
    pub margins: Option<&'a MarginsRecord>,
    /// How it was begun from another plan, or why that was left: a label and a text.
    pub begun: Option<(&'a str, &'a str)>,
}

/// The summary of a plan, solved or not, with what to type next.
pub fn plan(console: &Console, args: &SpecArgs, told: &Told) -> String {
    let Told { problem, settings, plan, identity, verbose, file, beside, margins, gains, begun } = *told;
    let mut lines = summary::plan(console.colour, problem, settings, plan, identity);
    if verbose {
        lines.extend(summary::details(console.colour, problem, settings, plan, identity));
    }
    if let Some((label, text)) = begun {
        lines.lines(label, summary::wrapped(&escape(text), summary::TEXT));
    }
    let times = &plan.solution.trajectory.time;
    lines.extend(gains.iter().flat_map(|gains| summary::flown::gains(gains, times)));
    if let Some((closed_loop, beside)) = beside {
        lines.extend(summary::flown::beside(problem, closed_loop, beside, margins));
    } else if let Some(margins) = margins {
        lines.lines("margin", summary::wrapped(&summary::flown::kept(margins), summary::TEXT));
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

/// What to type next of a plan that is as it should be.
fn next(args: &SpecArgs, file: Option<&Path>, verbose: bool, uncertain: bool) -> String {
    let more = if verbose { "" } else { "; -v tells how it was found" };
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

/// A command to try. Where it is too long for a line it goes on in the next, as a shell reads it, and so does why.
fn tried(text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    if text.chars().count() <= summary::TEXT {
        lines.line("try", text);
        return lines;
    }
    let Some((command, why)) = text.split_once("   # ") else {
        lines.lines("try", summary::wrapped(text, summary::TEXT));
        return lines;
    };
    if command.chars().count() <= summary::TEXT {
        lines.line("try", command);
    } else {
        // Before an option, so that its value stays beside it.
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

/// Limits and verdicts of the witnesses, and every check that fails.
pub fn verified(console: &Console, judged: &Judged, verification: &Verification) -> Vec<String> {
    summary::verified(console.colour, judged, verification)
}
