//! The comparison as text, for people.

use super::{Bound, EqualError, Run, WorkPrecision};
use crate::numerics::figures::{scientific as power, short};
use std::fmt;

impl fmt::Display for WorkPrecision {
    /// Two tables: every run, and the work at equal energy error.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "energy: mean and largest |E − E₀|, as a part of T₀ + |U₀| = {} J\n\
             RᵀR: mean ‖I − RᵀR‖; linear, angular: largest change of the momentum, as a part of the sum of those of \
             the bodies\n",
            short(self.energy_scale_j)
        )?;
        let mut horizon = None;
        for run in &self.in_order_of_horizons() {
            if horizon != Some(run.horizon_s.to_bits()) {
                horizon = Some(run.horizon_s.to_bits());
                writeln!(
                    f,
                    "over {} s\n  {:22} {:>10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>12} {:>12} {:>11}",
                    short(run.horizon_s),
                    "method",
                    "step, s",
                    "energy",
                    "largest",
                    "RᵀR",
                    "linear",
                    "angular",
                    "evaluations",
                    "iterations",
                    "time, s"
                )?;
            }
            writeln!(f, "  {}", line(run))?;
        }
        if self.equal_error.is_empty() {
            return Ok(());
        }
        let first = self.equal_error[0].method;
        writeln!(f, "\nat equal mean energy error, and relative to {first}")?;
        writeln!(
            f,
            "  {:>10} {:>8}  {:22} {:>11} {:>13} {:>8} {:>13} {:>8}",
            "horizon, s", "error", "method", "step, s", "evaluations", "ratio", "time, s", "ratio"
        )?;
        for (index, row) in self.equal_error.iter().enumerate() {
            let first_of_group = index == 0 || {
                let before = &self.equal_error[index - 1];
                before.horizon_s.to_bits() != row.horizon_s.to_bits()
                    || before.energy_error.to_bits() != row.energy_error.to_bits()
            };
            let group = match first_of_group {
                true => format!("{:>10} {:>8}", short(row.horizon_s), power(row.energy_error, 0)),
                false => format!("{:>19}", ""),
            };
            writeln!(f, "  {group}  {}", equal(row))?;
        }
        writeln!(f, "  interpolated between steps; ≤ and ≥: beyond the longest or the shortest")
    }
}

impl WorkPrecision {
    fn in_order_of_horizons(&self) -> Vec<&Run> {
        let mut runs: Vec<&Run> = self.runs.iter().collect();
        // Stable: methods and steps stay in their order.
        runs.sort_by(|a, b| a.horizon_s.total_cmp(&b.horizon_s));
        runs
    }
}

fn line(run: &Run) -> String {
    let Some(errors) = &run.errors else {
        let reason = run.failure.as_deref().unwrap_or_default();
        return format!("{:22} {:>10}  fails {reason}", run.method, short(run.step_s));
    };
    format!(
        "{:22} {:>10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>12} {:>12} {:>11}",
        run.method,
        short(run.step_s),
        power(errors.energy_error_mean, 1),
        power(errors.energy_error_max, 1),
        power(errors.orthogonality_error_mean, 1),
        power(errors.linear_momentum_error_max, 1),
        power(errors.angular_momentum_error_max, 1),
        run.force_evaluations,
        run.iterations,
        power(run.time_s, 3)
    )
}

fn equal(row: &EqualError) -> String {
    let sign = |bound: Option<Bound>| match bound {
        Some(Bound::AtMost) => "≤ ",
        Some(Bound::AtLeast) => "≥ ",
        Some(Bound::Interpolated) | None => "",
    };
    let value = |sign: &str, value: Option<f64>, print: &dyn Fn(f64) -> String| {
        value.map_or_else(|| "–".into(), |value| format!("{sign}{}", print(value)))
    };
    // A longer step is less work: its bound is the other way round.
    let of_step = match row.bound {
        Bound::AtMost => "≥ ",
        Bound::AtLeast => "< ",
        Bound::Interpolated => "",
    };
    let (of_work, of_ratio) = (sign(Some(row.bound)), sign(row.ratio_bound));
    format!(
        "{:22} {:>11} {:>13} {:>8} {:>13} {:>8}",
        row.method,
        value(of_step, row.step_s, &short),
        value(of_work, row.force_evaluations, &|x| format!("{x:.0}")),
        value(of_ratio, row.force_evaluation_ratio, &|x| format!("{x:.2}")),
        value(of_work, row.time_s, &|x| power(x, 3)),
        value(of_ratio, row.time_ratio, &|x| format!("{x:.2}")),
    )
}
