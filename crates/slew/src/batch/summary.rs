//! Summary of the results of a batch.

use super::Asked;
use super::progress::span;
use crate::advice::word;
use crate::summary::{headline, line};
use crate::{Console, Lines, Tone};
use slewkit::numerics::figures::significant;
use slewkit_files::batch::{Header, Kind, Shard, Tally};
use slewkit_files::spec::escape;
use slewkit_report::told_of_cases;
use std::path::PathBuf;

/// Data from which the summary of a batch is made.
pub struct Facts<'a> {
    pub asked: &'a Asked<'a>,
    pub header: &'a Header,
    pub shard: Shard,
    pub tally: &'a Tally,
    /// The number of results that the file contained before this run.
    pub done: u64,
    pub seconds: f64,
    pub threads: usize,
    pub output: Option<PathBuf>,
    pub stopped: bool,
    /// True if `--force` discarded the old contents of the file.
    pub forced: bool,
}

/// Returns the text of the summary.
pub fn text(console: &Console, facts: &Facts<'_>) -> String {
    let Facts { header, shard, tally, stopped, .. } = facts;
    let cases = shard.count(header.cases);
    let (verdict, tone) = match (stopped, tally.failed()) {
        (true, _) => (format!("interrupted, {} of {cases} cases done", tally.cases), Tone::Note),
        (false, 0) => (format!("all {cases} solved and verified"), Tone::Good),
        (false, _) => (format!("{} of {cases} solved and verified", tally.solved()), Tone::Note),
    };
    let kind = match header.kind {
        Kind::Table => "table of",
        Kind::Folder => "folder of",
        Kind::Sweep => "sweep of",
        Kind::MonteCarlo => "Monte Carlo of",
    };
    let part = if *shard == Shard::ALL { String::new() } else { format!(", shard {shard}") };
    let title = format!("{}, {kind} {} cases{part}", header.spec, header.cases);
    let mut lines = vec![headline(console, &title, &verdict, tone)];
    lines.extend(told_of_cases(tally));
    lines.extend(again(facts));
    let new = tally.cases - facts.done;
    if new > 0 {
        let rate = significant(new as f64 / facts.seconds.max(1e-6), 3);
        let threads = match facts.threads {
            1 => "one thread".to_string(),
            threads => format!("{threads} threads"),
        };
        lines.line("time", format!("{}, {rate} cases a second on {threads}", span(facts.seconds)));
    }
    if facts.done > 0 {
        lines.line("continued", format!("after {} cases that were there", facts.done));
    }
    if let Some(path) = facts.output.as_deref() {
        lines.line("wrote", escape(&path.to_string_lossy()));
    }
    if *stopped {
        let how = match facts.output.as_deref() {
            Some(path) if super::merge::is_csv(path) => {
                "a table cannot be continued: with -o FILE.jsonl this command can continue the run"
            }
            Some(_) if facts.forced => "this command without --force continues the run",
            Some(_) => "this command continues the run",
            None => "no results were kept: with -o FILE.jsonl this command can continue the run",
        };
        lines.line("resume", how);
    }
    lines.join("\n")
}

/// Returns the command that plans one case alone. It is the first failed case or, if no case
/// failed, the costliest case.
fn again(facts: &Facts<'_>) -> Option<String> {
    let failures = facts.tally.statuses.iter().filter(|(status, _)| *status != "solved");
    let failed = failures.filter_map(|(_, (_, first))| first.first().copied()).min();
    let costs = facts.tally.objectives.values().next();
    let costliest = costs.and_then(|costs| costs.costliest.first()).map(|worst| worst.case);
    let case = failed.or(costliest)?;
    let Asked { command, reading, spec, .. } = facts.asked;
    if spec.as_os_str() == "-" {
        // Input from stdin cannot be read again.
        return None;
    }
    let set: String = reading.set.iter().map(|set| format!(" --set {}", word(set))).collect();
    let input = reading.input.map_or(String::new(), |notation| format!(" --input {}", notation.name()));
    Some(line("again", &format!("{command}{input}{set} --case {case} -o plan.json")))
}
