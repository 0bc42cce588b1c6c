//! Work that each method needs for the same mean energy error.
//!
//! Between two steps, `log(work)` and `log(step)` are interpolated linearly in `log(error)`. The
//! interpolation is exact if work and error are powers of the step.

use super::run::Name;
use super::{IntegratorRun, Study};
use serde::{Deserialize, Serialize};

/// Kind of the value of the work at an error level: interpolated, or a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// The value is interpolated between two steps.
    Interpolated,
    /// The value is an upper bound, because the error is below the level even with the longest
    /// step.
    AtMost,
    /// The value is a lower bound, because the error is above the level even with the shortest
    /// step, or because the method fails.
    AtLeast,
}

/// The work that a method needs for a mean energy error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EqualError {
    /// Duration of the motion \[s\].
    pub horizon_s: f64,
    /// Mean energy error `e_E` for which the work is given.
    pub energy_error: f64,
    /// Name of the method whose work is given.
    #[serde(deserialize_with = "super::run::name")]
    pub method: Name,
    /// Kind of the values `force_evaluations` and `time_s`. If they are upper bounds, `step_s` is a
    /// lower bound, and vice versa.
    pub bound: Bound,
    /// Step with which the method has this error \[s\]; `None` if the method fails with every step.
    pub step_s: Option<f64>,
    /// The number of evaluations of the potential.
    pub force_evaluations: Option<f64>,
    /// Computing time that the method needs \[s\]; `None` if the method fails with every step.
    pub time_s: Option<f64>,
    /// Kind of the two ratios, interpolated or bounds; `None` if the ratios are unknown.
    pub ratio_bound: Option<Bound>,
    /// Number of evaluations of the potential, divided by the number that the first method needs.
    pub force_evaluation_ratio: Option<f64>,
    /// Computing time, divided by the computing time of the first method.
    pub time_ratio: Option<f64>,
}

/// Largest number of error levels.
const LEVELS: usize = 5;
/// Lowest error level. Smaller errors are round-off and do not characterise a method.
const LOWEST: f64 = 1e-13;

/// Returns a few error levels, in decreasing order. They are 1 or 3 times powers of ten, between
/// the smallest and the largest error of the first method over the longest horizon. The list is
/// empty if no such number lies between them.
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
    // The conversion from text gives the double nearest to a number such as 1e-5.
    let round = round.filter_map(|text| text.parse::<f64>().ok());
    let inside: Vec<f64> = round.filter(|level| *level >= LOWEST && (low..=high).contains(level)).collect();
    let stride = inside.len().div_ceil(LEVELS).max(1);
    inside.into_iter().step_by(stride).collect()
}

/// Returns the work of every method at every level and horizon.
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
                // After an interruption, a method may have no runs.
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

/// Returns the work with which a method has the energy error `level`. `runs` are the runs of the
/// method over one horizon, in the order of decreasing steps.
fn at_level(runs: &[&IntegratorRun], method: &'static str, horizon_s: f64, level: f64) -> EqualError {
    let good = |run: &&IntegratorRun| error(run).is_some_and(|error| error <= level);
    // From this index on, all shorter steps have an error below the level. A single longer step
    // with a small error may be chance.
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
    // The fraction is 0 at the coarse step and 1 at the fine step. It is also 1 if the level and
    // the error of the fine step are both zero, because the quotient is then NaN.
    let part = (coarse_error / level).ln() / (coarse_error / fine_error).ln();
    let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 1.0 };
    let (a, b) = (numbers(coarse), numbers(fine));
    let between = [0, 1, 2].map(|index| {
        // Zero work, such as the evaluations of the potential for a free body, has no logarithm.
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
