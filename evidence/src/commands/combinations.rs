//! Plans all combinations of ends, inputs, limits and objectives on 40 steps: which are planned and
//! how long that takes, and which are refused.
//!
//! `cargo run --release -p evidence -- combinations [SECONDS [WORD]]` plans each combination within
//! SECONDS (10 by default). It prints the tables of `docs/combinations.md`, and all differences
//! from that page. A WORD limits the run to cells whose end or input contains it; the other cells
//! are copied from the page.
//!
//! The command ends with 1 if a cell of the page is wrong.

use evidence::ROOT;
use evidence::combinations::{Became, Combination, ENDS, INPUTS, LIMITS, OBJECTIVES, cell};
use evidence::words::Words;
use slewkit::plan::Status;

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let most = words.number("seconds", 10.0)?;
    let word = words.take().unwrap_or_default();
    words.end()?;
    let page = std::fs::read_to_string(format!("{ROOT}/docs/combinations.md"))?;
    let mut wrong = Vec::new();
    for (objective, _) in OBJECTIVES {
        println!("\n## {objective}\n");
        println!("| end | limits | {} |", INPUTS.map(|(name, _)| name).join(" | "));
        println!("|---|---|{}", "---|".repeat(INPUTS.len()));
        for (end, _) in ENDS {
            for (limit, _) in LIMITS {
                let of = |(input, _)| Combination { objective, end, limit, input };
                let found = INPUTS.map(|input| {
                    let asked = end.contains(&word) || input.0.contains(&word);
                    let told = cell(&page, of(input)).filter(|_| !asked);
                    told.unwrap_or_else(|| shown(&of(input).became(most)))
                });
                println!("| {end} | {limit} | {} |", found.join(" | "));
                for (input, found) in INPUTS.into_iter().zip(found) {
                    let told = cell(&page, of(input)).unwrap_or_default();
                    if !agree(&told, &found) {
                        wrong.push(format!("{:?}: the page says {told}, found {found}", of(input)));
                    }
                }
            }
        }
    }
    println!("\n{} cells differ from docs/combinations.md", wrong.len());
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n").into()) }
}

/// Returns the text of the table's cell for a result.
fn shown(of: &Became) -> String {
    match of {
        Became::Planned(time) if *time < 0.1 => "< 0.1 s".into(),
        Became::Planned(time) if *time < 1.0 => "< 1 s".into(),
        Became::Planned(_) => "< 10 s".into(),
        Became::Slow(_, Status::VerificationFailed) => "more steps".into(),
        Became::Slow(time, status) => format!("slow ({time:.0} s, {status:?})"),
        Became::Refused(code) => format!("no: {code}"),
    }
}

/// Returns whether a result agrees with the cell of the page. A quicker plan agrees. A plan in the
/// next slower class of times agrees too, because the machine may be slower.
fn agree(told: &str, found: &str) -> bool {
    const TIMES: [&str; 5] = ["< 0.1 s", "< 1 s", "< 10 s", "more steps", "slow"];
    let time = |text: &str| TIMES.iter().position(|time| text.starts_with(time));
    match (time(told), time(found)) {
        (Some(told), Some(found)) => found <= told + 1,
        (None, None) => told == found,
        _ => false,
    }
}
