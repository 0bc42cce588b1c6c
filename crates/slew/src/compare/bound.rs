//! The global lower bound of `slew compare --bound`.

use crate::Failure;
#[cfg(feature = "sdp")]
use crate::{Lines, line, summary::scheme};
use slewkit::maneuver::{Problem, Settings};
#[cfg(feature = "sdp")]
use slewkit::numerics::figures::{error, significant, time};
use slewkit::plan::Observer;
#[cfg(feature = "sdp")]
use slewkit_report::studies::methods::{Global, global};

/// A global lower bound, or the reason why it cannot be computed, as lines of the summary and as
/// JSON.
pub struct Bound {
    /// Lines of the summary that describe the bound.
    pub lines: Vec<String>,
    /// Value of the key `bound` in the JSON document: the numbers of the bound, or its `reason`.
    pub document: serde_json::Value,
}

/// Returns an error if the program was built without the feature `sdp`, which computes the bound.
pub fn available() -> Result<(), Failure> {
    if cfg!(feature = "sdp") {
        return Ok(());
    }
    Err(Failure::Usage(
        "--bound needs semidefinite programs, and this `slew` was built without them: build it with \
        `cargo install --path crates/slew --features sdp`, which links the system's OpenBLAS \
        (Debian, Ubuntu: `apt-get install libopenblas-dev`)"
            .into(),
    ))
}

/// Returns the error of [`available`], because this build cannot compute the bound.
#[cfg(not(feature = "sdp"))]
pub fn bound(_: &Problem, _: &Settings, _: Option<usize>, _: &mut dyn Observer) -> Result<Bound, Failure> {
    available()?;
    Err(Failure::Internal("a bound without semidefinite programs".into()))
}

/// Computes the global lower bound of `problem` on a grid of `steps` steps, a plan on this grid,
/// and the gap between them.
#[cfg(feature = "sdp")]
pub fn bound(
    problem: &Problem,
    settings: &Settings,
    steps: Option<usize>,
    observer: &mut dyn Observer,
) -> Result<Bound, Failure> {
    match global(problem, settings, steps, observer) {
        Ok(found) => {
            let document =
                serde_json::to_value(&found).map_err(|error| Failure::Internal(error.to_string()))?;
            Ok(Bound { lines: lines(problem, &found), document })
        }
        Err(reason) => {
            let reason = reason.to_string();
            let lines = vec![line("bound", &reason)];
            Ok(Bound { lines, document: serde_json::json!({ "reason": reason }) })
        }
    }
}

#[cfg(feature = "sdp")]
fn lines(problem: &Problem, found: &Global) -> Vec<String> {
    let scheme = scheme(problem.scheme);
    let grid = if found.same_grid {
        "this discrete problem".into()
    } else {
        format!("this maneuver on {} {scheme} steps, another discrete problem", found.steps)
    };
    let numbers = format!(
        "no maneuver of any homotopy class costs less than {}; the plan there costs {}",
        significant(found.lower_bound, 10),
        significant(found.cost, 10)
    );
    let mut lines = vec![line("bound", &format!("of {grid}")), line("", &numbers)];
    lines.line("", format!("gap {} of the cost   {}", error(found.gap), time(found.solve_time_s)));
    if let Some(cost) = found.cost_without_limits {
        let (cost, gap) = (significant(cost, 10), error(found.gap_without_limits));
        let text = format!("the bound ignores limits: the plan without them costs {cost}, gap {gap}");
        lines.line("", &text);
    }
    let verdict = match (found.tight, found.cost_without_limits.is_some()) {
        (true, false) => "the plan there is globally optimal within the gap",
        (true, true) => "without limits the plan there is globally optimal within its gap",
        (false, _) => {
            "loose: a cheaper maneuver may exist, or the relaxation is not tight; the gap does not decide"
        }
    };
    lines.line("", verdict);
    lines
}
