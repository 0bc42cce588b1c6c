//! Statistics over the cases of a batch: counts, quantiles, extreme cases.
//!
//! The cost of each solved case is stored, in 8 bytes, because exact quantiles need all costs. All
//! other cases are only counted, except for the first case of each kind and the extreme cases.

use super::CaseResult;
use slewkit::maneuver::Proved;
use std::collections::BTreeMap;

/// Number of costliest cases that are stored, and number of cases stored for each status.
const KEPT: usize = 5;

/// Counts, costs and extreme cases of the results added so far.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Number of results that were added.
    pub cases: u64,
    /// Number of cases with each status, and the case numbers of the first few of these cases.
    pub statuses: BTreeMap<String, (u64, Vec<u64>)>,
    /// Number of cases with an invalid spec, sorted by the code of their first error; also the
    /// reason of the first case with this code.
    pub errors: BTreeMap<String, (u64, String)>,
    /// Number of solved cases for each degree of proof that the plan is an optimum.
    pub proofs: BTreeMap<Proved, u64>,
    /// Case with the largest gap, the first-order upper bound on the cost that a neighbouring plan
    /// can save.
    pub widest_gap: Option<Worst>,
    /// Number of solved cases whose plan turns the long way.
    pub long_way: u64,
    /// Costs of the solved cases, grouped by objective, because effort, time and fuel have
    /// different units.
    pub objectives: BTreeMap<String, Costs>,
    /// Solved case with the largest terminal attitude error of the continuous motion \[deg\].
    pub farthest: Option<Worst>,
}

/// Costs of the solved cases with one objective.
#[derive(Clone, Debug, Default)]
pub struct Costs {
    /// Cases with the highest costs, in decreasing order.
    pub costliest: Vec<Worst>,
    /// Case with the lowest cost.
    pub cheapest: Option<Worst>,
    /// All costs, in the order of the cases.
    pub all: Vec<f64>,
}

/// A case with an extreme value, and the settings that define the case.
#[derive(Clone, Debug, PartialEq)]
pub struct Worst {
    /// Extreme value of the case, such as its cost.
    pub value: f64,
    /// Number of the case.
    pub case: u64,
    /// Name of the case; `None` if it has no name.
    pub name: Option<String>,
    /// Keys that the case sets, as arguments of `--set`.
    pub set: Vec<String>,
}

/// Quantiles of the cost, by linear interpolation between the ordered values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantiles {
    /// Lowest cost.
    pub least: f64,
    /// 5 % quantile of the cost.
    pub low: f64,
    /// Median of the cost.
    pub median: f64,
    /// 95 % quantile of the cost.
    pub high: f64,
    /// 99 % quantile of the cost.
    pub highest: f64,
    /// Highest cost.
    pub largest: f64,
}

impl Tally {
    /// Adds a result to the statistics.
    pub fn add(&mut self, result: &CaseResult) {
        self.cases += 1;
        let (count, first) = self.statuses.entry(result.status.clone()).or_default();
        *count += 1;
        if first.len() < KEPT {
            first.push(result.case);
        }
        if let Some(error) = &result.error {
            let entry = self.errors.entry(error.code.clone());
            entry.or_insert_with(|| (0, error.reason.clone())).0 += 1;
        }
        if !result.is_solved() {
            return;
        }
        if let Some(proof) = result.proof {
            *self.proofs.entry(proof).or_default() += 1;
        }
        self.long_way += u64::from(result.sense == Some(slewkit::maneuver::Sense::Long));
        let worst = |value| Worst {
            value,
            case: result.case,
            name: result.name.clone(),
            set: result.settings().collect(),
        };
        if let Some(cost) = result.cost {
            let objective = result.objective.clone().unwrap_or_default();
            let costs = self.objectives.entry(objective).or_default();
            costs.all.push(cost);
            // Of cases with equal costs, the case with the lower number is listed first.
            let place = costs.costliest.partition_point(|other| other.value >= cost);
            if place < KEPT {
                costs.costliest.insert(place, worst(cost));
                costs.costliest.truncate(KEPT);
            }
            if costs.cheapest.as_ref().is_none_or(|least| cost < least.value) {
                costs.cheapest = Some(worst(cost));
            }
        }
        let wider = |gap: &f64| self.widest_gap.as_ref().is_none_or(|most| *gap > most.value);
        if let Some(gap) = result.gap.filter(wider) {
            self.widest_gap = Some(worst(gap));
        }
        let missed = result.verified.as_ref().and_then(|verdict| verdict.continuous_attitude_deg);
        if let Some(missed) =
            missed.filter(|missed| self.farthest.as_ref().is_none_or(|most| *missed > most.value))
        {
            self.farthest = Some(worst(missed));
        }
    }

    /// Returns the number of cases whose plan the witnesses have verified.
    pub fn solved(&self) -> u64 {
        self.statuses.get("solved").map_or(0, |(count, _)| *count)
    }

    /// Returns the number of cases without a verified plan.
    pub fn failed(&self) -> u64 {
        self.cases - self.solved()
    }
}

impl Costs {
    /// Returns the quantiles of the costs; `None` if no case was solved.
    pub fn quantiles(&self) -> Option<Quantiles> {
        let mut sorted = self.all.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let (least, largest) = (*sorted.first()?, *sorted.last()?);
        let at = |part: f64| quantile(&sorted, part);
        Some(Quantiles { least, low: at(0.05), median: at(0.5), high: at(0.95), highest: at(0.99), largest })
    }
}

/// Returns the quantile at the fraction `part` (0 to 1) of at least one sorted value. It is
/// definition 7 of Hyndman and Fan, *Sample Quantiles in Statistical Packages*, 1996, the default
/// of NumPy and R.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    let place = part * (sorted.len() - 1) as f64;
    let (below, between) = (place.floor() as usize, place.fract());
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] * (1.0 - between) + sorted[above] * between
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference values: `numpy.quantile([1, 2, 4, 8, 16], [0, 0.05, 0.5, 0.95, 0.99, 1])` of NumPy
    /// 2.4.6.
    #[test]
    fn quantiles_are_those_of_numpy() {
        let sorted = [1.0, 2.0, 4.0, 8.0, 16.0];
        for (part, expected) in
            [(0.0, 1.0), (0.05, 1.2), (0.5, 4.0), (0.95, 14.4), (0.99, 15.68), (1.0, 16.0)]
        {
            assert!((quantile(&sorted, part) - expected).abs() < 1e-14, "{part}");
        }
        assert_eq!(quantile(&[3.0], 0.99), 3.0);
    }

    #[test]
    fn costliest_are_the_highest_and_the_first_among_equals() {
        let mut tally = Tally::default();
        for (case, cost) in [3.0, 9.0, 1.0, 9.0, 4.0, 5.0, 6.0, 2.0].into_iter().enumerate() {
            let case = case as u64 + 1;
            tally.add(&CaseResult {
                case,
                status: "solved".into(),
                objective: Some("effort".into()),
                cost: Some(cost),
                ..CaseResult::default()
            });
        }
        tally.add(&CaseResult {
            case: 9,
            status: "infeasible".into(),
            exit_code: 4,
            ..CaseResult::default()
        });
        let costs = tally.objectives["effort"].clone();
        let kept: Vec<(u64, f64)> = costs.costliest.iter().map(|worst| (worst.case, worst.value)).collect();
        assert_eq!(costs.cheapest.as_ref().map(|least| least.case), Some(3));
        // Costs are compared only between cases with the same objective.
        let fast = CaseResult {
            case: 10,
            objective: Some("time".into()),
            cost: Some(99.0),
            ..CaseResult::default()
        };
        tally.add(&CaseResult { status: "solved".into(), ..fast });
        assert_eq!(tally.objectives["time"].costliest.len(), 1);
        assert_eq!(tally.objectives["effort"].costliest[0].value, 9.0);
        assert_eq!(kept, [(2, 9.0), (4, 9.0), (7, 6.0), (6, 5.0), (5, 4.0)]);
        assert_eq!(
            (tally.solved(), tally.failed(), tally.statuses["infeasible"].clone()),
            (9, 1, (1, vec![9]))
        );
    }
}
