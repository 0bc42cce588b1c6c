//! What commands tell in words on this console.

use super::advice::advice;
use super::{Console, SpecArgs, Tone};
use slewkit::maneuver::{Problem, Settings};
use slewkit::plan::Plan;
use slewkit::verify::Verification;
use slewkit_files::export::Target;
use slewkit_files::identity::Identity;
use slewkit_files::spec::escape;
use slewkit_report::summary;
pub use slewkit_report::summary::{Judged, Lines, line, scheme};

/// The first line: name to the left, verdict to the right.
pub fn headline(console: &Console, name: &str, verdict: &str, tone: Tone) -> String {
    summary::headline(console.colour, name, verdict, tone)
}

/// The closing line of a summary.
pub fn wrote(console: &mut Console, target: &Target) {
    console.say(&line("wrote", &escape(&target.path().to_string_lossy())));
}

/// The summary of a plan, solved or not, with what to try next.
pub fn plan(
    console: &Console,
    args: &SpecArgs,
    problem: &Problem,
    settings: &Settings,
    plan: &Plan,
    identity: &Identity,
) -> String {
    let mut lines = summary::plan(console.colour, problem, settings, plan, identity);
    lines.extend(advice(args, problem, settings, plan).iter().map(|text| line("try", text)));
    lines.join("\n")
}

/// Limits and verdicts of the witnesses, and every check that fails.
pub fn verified(console: &Console, judged: &Judged, verification: &Verification) -> Vec<String> {
    summary::verified(console.colour, judged, verification)
}
