//! What commands tell in words on this console.

use super::advice::{advice, word};
use super::{Console, SpecArgs, Tone};
use slewkit::maneuver::{Problem, Settings};
use slewkit::plan::{Plan, Status};
use slewkit::verify::Verification;
use slewkit_files::export::Target;
use slewkit_files::identity::Identity;
use slewkit_files::spec::escape;
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
}

/// The summary of a plan, solved or not, with what to type next.
pub fn plan(console: &Console, args: &SpecArgs, told: &Told) -> String {
    let Told { problem, settings, plan, identity, verbose, file } = *told;
    let mut lines = summary::plan(console.colour, problem, settings, plan, identity);
    if verbose {
        lines.extend(summary::details(console.colour, problem, settings, plan, identity));
    }
    let advice = advice(args, problem, settings, plan);
    if advice.is_empty() && plan.status == Status::Solved {
        lines.push(line("next", &next(args, file, verbose)));
    }
    for text in &advice {
        lines.extend(tried(text));
    }
    lines.join("\n")
}

/// What to type next of a plan that is as it should be.
fn next(args: &SpecArgs, file: Option<&Path>, verbose: bool) -> String {
    let more = if verbose { "" } else { "; -v tells how it was found" };
    match file {
        Some(file) => {
            let name = word(&file.to_string_lossy());
            format!("slew report {name} -o plan.html{more}")
        }
        None => {
            let spec = word(&args.spec.to_string_lossy());
            let all = format!("slew plan {spec} -o plan.json{more}");
            let short = format!("add -o plan.json{more}");
            if all.chars().count() <= summary::TEXT { all } else { short }
        }
    }
}

/// A command to try: why stands behind it, or in a line of its own where both are too long for one.
fn tried(text: &str) -> Vec<String> {
    if text.chars().count() <= summary::TEXT {
        return vec![line("try", text)];
    }
    let (command, why) = text.split_once("   # ").unwrap_or(("", text));
    let mut lines = Vec::new();
    if !command.is_empty() {
        // To be copied, it is not broken.
        lines.push(line("try", command));
    }
    for part in summary::wrapped(why, summary::TEXT - 2) {
        let label = if lines.is_empty() { "try" } else { "" };
        let sign = if command.is_empty() { "" } else { "# " };
        lines.push(line(label, &format!("{sign}{part}")));
    }
    lines
}

/// Limits and verdicts of the witnesses, and every check that fails.
pub fn verified(console: &Console, judged: &Judged, verification: &Verification) -> Vec<String> {
    summary::verified(console.colour, judged, verification)
}
