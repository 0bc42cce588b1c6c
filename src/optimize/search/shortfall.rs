//! What a constrained maneuver lacks where no plan was found, in words: which constraints stay violated
//! where the search came nearest, and the shortest duration for which a plan was found.
//!
//! That is advice, not proof: the search is local.

use super::{Context, constrained};
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::Outcome;
use crate::optimize::methods::scp::Convex;
use crate::optimize::methods::scp::rows::Rows;

/// Durations tried, as multiples of the one asked for.
const STRETCHES: [f64; 5] = [1.1, 1.25, 1.5, 2.0, 3.0];
/// Halvings of the last gap.
const HALVINGS: usize = 3;
/// Violations below this, scaled, are not worth words.
const NOTICED: f64 = 1e-6;

/// What stays violated at the last iterate of the nearest miss, after so many subproblems.
pub(super) fn violated(convex: &Convex, rows: &Rows, subproblems: usize) -> String {
    let mut parts = Vec::new();
    let cut_short = convex.outcome == Outcome::IterationLimit;
    if cut_short {
        parts.push(format!("the limit of iterations came first, after {subproblems} subproblems"));
    }
    for (group, violation) in rows.groups.iter().zip(&convex.violations) {
        if *violation > NOTICED {
            // Cones are violated by an angle, limits by a share of themselves.
            parts.push(if group.is_angle {
                format!("\"{}\" stays violated by {:.3} deg", group.name, violation.to_degrees())
            } else {
                format!("{} stays exceeded by {:.2} %", group.name, 100.0 * violation)
            });
        }
    }
    let defect = convex.residuals.last().copied().unwrap_or(f64::NAN);
    let met = defect <= NOTICED;
    if !met {
        parts.push(if cut_short {
            "the path does not yet reach the end".into()
        } else {
            "no path within limits and constraints that reaches the end was found".into()
        });
    }
    if parts.is_empty() { "the search came near, and did not settle".into() } else { parts.join("; ") }
}

/// To four significant digits: a search is no better than that.
fn rounded_up(value: f64) -> f64 {
    // Not by a product with a power of ten, which is seldom exact: by the text that a spec would hold.
    let unit = 10_f64.powi(value.log10().floor() as i32 - 3);
    let text = format!("{:.3e}", (value / unit).ceil() * unit);
    text.parse().unwrap_or(value)
}

/// A longer duration \[s\] for which a plan exists on a coarse grid, within an eighth of the gap to one for
/// which none was found; in four digits.
pub(super) fn longer(problem: &Problem, context: &Context) -> Option<f64> {
    let solvable = |stretch: f64| {
        let mut problem = problem.clone();
        problem.duration *= stretch;
        problem.check().is_ok() && constrained::is_solvable(&problem, context)
    };
    let mut below = 1.0;
    for stretch in STRETCHES {
        if context.interrupt().is_some() {
            return None;
        }
        if solvable(stretch) {
            let mut above = stretch;
            for _ in 0..HALVINGS {
                let middle = 0.5 * (below + above);
                if solvable(middle) { above = middle } else { below = middle }
            }
            return Some(rounded_up(problem.duration * above));
        }
        below = stretch;
    }
    None
}
