//! The work of each method for the same mean energy error.
//!
//! Between two steps `log(work)` and `log(step)` are linear in `log(error)`: exact if both follow
//! powers of the step.

use super::run::Name;
use super::{IntegratorRun, Study};
use serde::{Deserialize, Serialize};

/// The kind of knowledge of the work at an error level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// Interpolated between two steps.
    Interpolated,
    /// The longest step is already better: at most this much.
    AtMost,
    /// The shortest step is still worse, or the method fails: at least this much.
    AtLeast,
}

/// The work that a method needs for a mean energy error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EqualError {
    /// The horizon \[s\].
    pub horizon_s: f64,
    /// The mean energy error `e_E`.
    pub energy_error: f64,
    /// Name of the method.
    #[serde(deserialize_with = "super::run::name")]
    pub method: Name,
    /// The meaning of the numbers below; for the step the bound is reversed.
    pub bound: Bound,
    /// The step \[s\]; `None` if no step brings the method to the horizon.
    pub step_s: Option<f64>,
    /// Evaluations of the potential.
    pub force_evaluations: Option<f64>,
    /// Time \[s\].
    pub time_s: Option<f64>,
    /// The meaning of the ratios; `None` if they are unknown.
    pub ratio_bound: Option<Bound>,
    /// The ratio of its evaluations to the evaluations of the first method.
    pub force_evaluation_ratio: Option<f64>,
    /// The ratio of its time to the time of the first method.
    pub time_ratio: Option<f64>,
}

/// The largest number of levels. Errors below the lowest level are round-off, and do not
/// characterise a method.
const LEVELS: usize = 5;
const LOWEST: f64 = 1e-13;

/// Returns round errors between the largest and the smallest error of the first method at the
/// longest horizon, largest first, thinned to a few. Empty if the first method has fewer than two
/// errors.
pub(super) fn levels(study: &Study, runs: &[IntegratorRun]) -> Vec<f64> {
    let (Some(first), Some(horizon)) = (study.kinds.first(), study.horizons.last()) else {
        return Vec::new();
    };
    let of =
        |run: &&IntegratorRun| run.method == first.name() && run.horizon_s.to_bits() == horizon.to_bits();
    let errors = runs.iter().filter(of).filter_map(error).filter(|error| *error > 0.0);
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for error in errors {
        (low, high) = (low.min(error), high.max(error));
    }
    let round = (-320..320).rev().flat_map(|power| [3, 1].map(|digit| format!("{digit}e{power}")));
    // The conversion from text gives the number nearest to 1e-5.
    let round = round.filter_map(|text| text.parse::<f64>().ok());
    let inside: Vec<f64> = round.filter(|level| *level >= LOWEST && (low..=high).contains(level)).collect();
    let stride = inside.len().div_ceil(LEVELS).max(1);
    inside.into_iter().step_by(stride).collect()
}

/// Returns all horizons, levels and methods.
pub(super) fn table(study: &Study, levels: &[f64], runs: &[IntegratorRun]) -> Vec<EqualError> {
    let mut table = Vec::new();
    for (&horizon, &level) in study.horizons.iter().flat_map(|t| levels.iter().map(move |e| (t, e))) {
        let rows: Vec<EqualError> = study
            .kinds
            .iter()
            .filter_map(|kind| {
                let of = |run: &&IntegratorRun| {
                    run.method == kind.name() && run.horizon_s.to_bits() == horizon.to_bits()
                };
                let runs: Vec<&IntegratorRun> = runs.iter().filter(of).collect();
                // The list is empty after an interruption.
                (!runs.is_empty()).then(|| at_level(&runs, kind.name(), horizon, level))
            })
            .collect();
        let Some(first) = rows.first().cloned() else { continue };
        table.extend(rows.into_iter().map(|row| row.relative_to(&first)));
    }
    table
}

fn error(run: &IntegratorRun) -> Option<f64> {
    run.errors.map(|errors| errors.energy_error_mean)
}

/// Returns the runs of one method to one horizon, longest step first.
fn at_level(runs: &[&IntegratorRun], method: &'static str, horizon_s: f64, level: f64) -> EqualError {
    let good = |run: &&IntegratorRun| error(run).is_some_and(|error| error <= level);
    // The longest step from which on all shorter ones are good: one accurate long step may be
    // chance.
    let good_from = runs.len() - runs.iter().rev().take_while(|run| good(run)).count();
    let row = |bound, numbers: Option<[f64; 3]>| EqualError {
        horizon_s,
        energy_error: level,
        method,
        bound,
        step_s: numbers.map(|n| n[0]),
        force_evaluations: numbers.map(|n| n[1]),
        time_s: numbers.map(|n| n[2]),
        ratio_bound: None,
        force_evaluation_ratio: None,
        time_ratio: None,
    };
    let numbers = |run: &IntegratorRun| [run.step_s, run.force_evaluations as f64, run.time_s];
    let Some(fine) = runs.get(good_from) else {
        let finest = runs.last().filter(|run| run.errors.is_some());
        return row(Bound::AtLeast, finest.map(|run| numbers(run)));
    };
    let coarse = good_from.checked_sub(1).map(|index| runs[index]);
    let Some((coarse, coarse_error)) = coarse.and_then(|run| Some((run, error(run)?))) else {
        return row(Bound::AtMost, Some(numbers(fine)));
    };
    let fine_error = error(fine).unwrap_or(level);
    // 0 at the coarse step, 1 at the fine one; an error of exactly zero is as good as the fine step
    // gets.
    let part = (coarse_error / level).ln() / (coarse_error / fine_error).ln();
    let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 1.0 };
    let (a, b) = (numbers(coarse), numbers(fine));
    let between = [0, 1, 2].map(|index| {
        // Zero work, such as the force evaluations of a free body, has no logarithm.
        if a[index] > 0.0 { a[index] * (b[index] / a[index]).powf(part) } else { b[index] }
    });
    row(Bound::Interpolated, Some(between))
}

impl EqualError {
    fn relative_to(mut self, first: &Self) -> Self {
        self.ratio_bound = match (self.bound, first.bound) {
            (own, Bound::Interpolated) => Some(own),
            (Bound::Interpolated | Bound::AtLeast, Bound::AtMost) => Some(Bound::AtLeast),
            (Bound::Interpolated | Bound::AtMost, Bound::AtLeast) => Some(Bound::AtMost),
            (Bound::AtMost, Bound::AtMost) | (Bound::AtLeast, Bound::AtLeast) => None,
        };
        if self.ratio_bound.is_some() {
            let over = |own: Option<f64>, first: Option<f64>| {
                own.zip(first).map(|(own, first)| own / first).filter(|ratio| ratio.is_finite())
            };
            self.force_evaluation_ratio = over(self.force_evaluations, first.force_evaluations);
            self.time_ratio = over(self.time_s, first.time_s);
        }
        self
    }
}
