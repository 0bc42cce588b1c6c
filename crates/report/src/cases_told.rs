//! Summary of the results of a batch.

use super::summary::Lines;
use slewkit::maneuver::Proved;
use slewkit::numerics::figures::{error, rounded, short, significant};
use slewkit_files::batch::{Tally, Worst};
use slewkit_files::spec::escape;

/// Returns the lines of the summary of a batch: quantiles of the cost, the largest terminal error
/// of the continuous motion, the numbers of proofs and failures, and the cheapest and costliest
/// cases.
pub fn told_of_cases(tally: &Tally) -> Vec<String> {
    let mut lines = Vec::new();
    // Effort, time and fuel have different units, so the costs of each objective have separate
    // lines.
    let several = tally.objectives.len() > 1;
    for (objective, costs) in &tally.objectives {
        let Some(found) = costs.quantiles() else { continue };
        let number = |value: f64| rounded(value, 6);
        let of = if several { format!("{objective}: ") } else { String::new() };
        lines.line(
            "cost",
            format!(
                "{of}median {}, 5 % {}, 95 % {}, 99 % {}",
                number(found.median),
                number(found.low),
                number(found.high),
                number(found.highest)
            ),
        );
        lines.line("", format!("from {} to {}", number(found.least), number(found.largest)));
    }
    if let Some(worst) = &tally.farthest {
        let missed = significant(worst.value, 3);
        lines.line("continuous", format!("the motion misses by at most {missed} deg, in {}", named(worst)));
    }
    let proofs = Proved::ALL.into_iter().filter_map(|proof| Some((proof, tally.proofs.get(&proof)?)));
    lines.lines("proof", proofs.map(|(proof, count)| format!("{count} {}", plural(proof, *count))));
    if let Some(widest) = tally.widest_gap.as_ref().filter(|widest| widest.value > 0.0) {
        let gap = error(widest.value);
        lines.line(
            "gap",
            format!("neighbouring plans save at most {gap}, to first order, in {}", named(widest)),
        );
    }
    if tally.long_way > 0 {
        lines.line("path", format!("{} of the solved cases go the long way round", tally.long_way));
    }
    let failures = tally.statuses.iter().filter(|(status, _)| *status != "solved");
    lines.lines(
        "failed",
        failures.map(|(status, (count, first))| {
            let list: Vec<String> = first.iter().map(u64::to_string).collect();
            let more = if *count > first.len() as u64 { ", …" } else { "" };
            format!("{count} {}: case {}{more}", status.replace('_', " "), list.join(", "))
        }),
    );
    let errors = tally.errors.iter();
    lines.lines(
        "bad specs",
        errors.map(|(code, (count, reason))| format!("{count} × {code}, first: {}", escape(reason))),
    );
    for (objective, costs) in &tally.objectives {
        let what = if several { objective } else { "cost" };
        let told = |worst: &Worst| format!("{}, {what} {}", named(worst), rounded(worst.value, 6));
        lines.lines("cheapest", costs.cheapest.iter().map(told));
        lines.lines("costliest", costs.costliest.iter().take(3).map(told));
    }
    lines
}

/// Returns the name of a degree of proof, in the plural unless `count` is 1.
fn plural(proof: Proved, count: u64) -> &'static str {
    match proof {
        _ if count == 1 => proof.words(),
        Proved::Feasible => "feasible, no optima",
        Proved::Saddle => "saddles, no minima",
        Proved::Extremal => "extremals, not known to be minima",
        Proved::FirstOrder => "local minima to first order",
        Proved::Minimum => "local minima",
        Proved::Global => "global minima",
    }
}

/// Describes a case: its number, its name and a few of its overrides.
fn named(worst: &Worst) -> String {
    const SHOWN: usize = 3;
    let mut text = format!("case {}", worst.case);
    if let Some(name) = &worst.name {
        text.push_str(&format!(" “{}”", escape(name)));
    }
    let set: Vec<String> = worst.set.iter().take(SHOWN).map(|set| brief(set)).collect();
    if !set.is_empty() {
        let more = if worst.set.len() > SHOWN { ", …" } else { "" };
        text.push_str(&format!(" ({}{more})", escape(&set.join(", "))));
    }
    text
}

/// Returns the text `key=value` of an override, with its numbers rounded to a few digits.
fn brief(set: &str) -> String {
    let (key, value) = set.split_once('=').unwrap_or(("", set));
    let part = |part: &str| {
        let (word, sign) = part.split_at(part.trim_end_matches(SEPARATORS).len());
        let word = word.parse::<f64>().map_or(word.to_string(), short);
        format!("{word}{sign}")
    };
    let text: String = value.split_inclusive(SEPARATORS).map(part).collect();
    match text.char_indices().nth(LONGEST) {
        Some((at, _)) => format!("{key}={}…", &text[..at]),
        None => format!("{key}={text}"),
    }
}

/// The characters that separate the numbers of a value.
const SEPARATORS: [char; 6] = [',', '[', ']', '{', '}', ' '];
/// The largest number of characters of a value that a summary shows.
const LONGEST: usize = 60;
