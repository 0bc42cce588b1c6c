//! Formatting of the comparison as text.

use super::{Bound, EqualError, IntegratorRun, WorkPrecision};
use crate::draw::table;
use crate::studies::clock::THREAD_TIME_S;
use slewkit::numerics::figures::{scientific, short};
use std::fmt;

impl fmt::Display for WorkPrecision {
    /// Writes a table of the runs over each horizon, and a table of the work at equal energy error.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "energy: mean and largest |E − E₀|, as a part of T₀ + |U₀| = {} J\n\
             RᵀR: mean ‖I − RᵀR‖; linear, angular: largest change of the momentum, as a part of the sum of those of \
             the bodies\n",
            short(self.energy_scale_j)
        )?;
        let mut runs: Vec<&IntegratorRun> = self.runs.iter().collect();
        // The sort is stable, so methods and steps keep their order.
        runs.sort_by(|a, b| a.horizon_s.total_cmp(&b.horizon_s));
        for runs in runs.chunk_by(|a, b| a.horizon_s.to_bits() == b.horizon_s.to_bits()) {
            writeln!(f, "over {} s", short(runs[0].horizon_s))?;
            write(f, RUNS, runs.iter().map(|run| run_row(run)).collect(), &[0])?;
        }
        let Some(first) = self.equal_error.first() else { return Ok(()) };
        writeln!(f, "\nat equal mean energy error, and relative to {}", first.method)?;
        write(f, EQUAL, self.equal_error.iter().map(equal_row).collect(), &[2])?;
        writeln!(f, "  interpolated between steps; ≤ and ≥: beyond the longest or the shortest")
    }
}

/// Headings of the columns of the table of runs.
pub const RUNS: &[&str] = &[
    "method",
    "step, s",
    "energy",
    "largest",
    "RᵀR",
    "linear",
    "angular",
    "evaluations",
    "iterations",
    THREAD_TIME_S,
];
/// Headings of the columns of the table of the work at equal error.
pub const EQUAL: &[&str] =
    &["horizon, s", "error", "method", "step, s", "evaluations", "ratio", THREAD_TIME_S, "ratio"];

fn write(f: &mut fmt::Formatter<'_>, header: &[&str], rows: Vec<Vec<String>>, left: &[usize]) -> fmt::Result {
    let header = header.iter().map(|name| name.to_string()).collect();
    let rows: Vec<_> = std::iter::once(header).chain(rows).collect();
    table(&rows, left).iter().try_for_each(|line| writeln!(f, "  {line}"))
}

/// Returns the cells of the row of a run. The row of a failed run has three cells, of which the
/// last is the reason.
pub fn run_row(run: &IntegratorRun) -> Vec<String> {
    let mut row = vec![run.method.to_string(), short(run.step_s)];
    match &run.errors {
        Some(errors) => row.extend([
            scientific(errors.energy_error_mean, 1),
            scientific(errors.energy_error_max, 1),
            scientific(errors.orthogonality_error_mean, 1),
            scientific(errors.linear_momentum_error_max, 1),
            scientific(errors.angular_momentum_error_max, 1),
            run.force_evaluations.to_string(),
            run.iterations.to_string(),
            scientific(run.time_s, 3),
        ]),
        None => row.push(format!("fails {}", run.failure.as_deref().unwrap_or_default())),
    }
    row
}

/// Returns the cells of the work at an error level.
pub fn equal_row(row: &EqualError) -> Vec<String> {
    let sign = |bound: Option<Bound>| match bound {
        Some(Bound::AtMost) => "≤ ",
        Some(Bound::AtLeast) => "≥ ",
        Some(Bound::Interpolated) | None => "",
    };
    // A longer step needs less work, so an upper bound on the work is a lower bound on the step,
    // and vice versa.
    let of_step = match row.bound {
        Bound::AtMost => "≥ ",
        Bound::AtLeast => "< ",
        Bound::Interpolated => "",
    };
    let (of_work, of_ratio) = (sign(Some(row.bound)), sign(row.ratio_bound));
    let value = |sign: &str, value: Option<f64>, print: &dyn Fn(f64) -> String| {
        value.map_or_else(|| "–".into(), |value| format!("{sign}{}", print(value)))
    };
    let ratio = |x: f64| format!("{x:.2}");
    vec![
        short(row.horizon_s),
        scientific(row.energy_error, 0),
        row.method.into(),
        value(of_step, row.step_s, &short),
        value(of_work, row.force_evaluations, &|x| format!("{x:.0}")),
        value(of_ratio, row.force_evaluation_ratio, &ratio),
        value(of_work, row.time_s, &|x| scientific(x, 3)),
        value(of_ratio, row.time_ratio, &ratio),
    ]
}
