//! Limits that share a chance: the number of standard deviations that they keep, from the normal
//! distribution or from flights.

use super::limit::Limit;
use super::{Beside, Kept, NotKept, Over};
use crate::closed_loop::{Campaign, Flown, Lost, Plant, Proportion, quantile};
use crate::maneuver::Problem;
use crate::uncertainty::Uncertainty;
use crate::uncertainty::chance::{Quantity, normal_quantile};

/// Seed of the simulated flights from which chances are counted. It differs from the seed of `slew
/// fly`, so `slew fly` tests the margins with other cases.
const SEED: u64 = 0x6368_616e_6365;

/// Tolerance, in standard deviations, within which counted margins count as equal. It changes a
/// chance by a few per cent of its value.
const SAME_COUNTED: f64 = 0.01;

/// Tolerance, in standard deviations, within which reserves count as equal. It changes a chance by
/// less than a thousandth of its value.
const SAME_RESERVE: f64 = 1e-4;

/// Tolerance within which margins of cones count as equal \[rad\]: a hundredth of the error that
/// the witnesses allow at a cone.
const SAME_MARGIN: f64 = 1e-8;

/// Limits with a common chance.
pub(super) struct Group {
    pub limits: Vec<Limit>,
    at_most: f64,
    over: Over,
    /// The number of standard deviations that each limit keeps.
    z: f64,
    pub counted: Option<Proportion>,
}

/// The reserve that a chance requires at a limit; at least the reserve that the spec requests.
pub(super) struct Needed {
    pub margins: Vec<f64>,
    /// Tolerance within which two reserves count as equal, for each component or input.
    same: Vec<f64>,
}

impl Needed {
    /// Returns whether the required reserves equal the reserves `held`. If `grown` is true, returns
    /// whether no required reserve exceeds the reserve held.
    pub fn is(&self, held: &[f64], grown: bool) -> bool {
        let parts = self.margins.iter().zip(held).zip(&self.same);
        parts.into_iter().all(|((needed, held), same)| {
            let beyond = needed - held;
            (if grown { beyond } else { beyond.abs() }) <= *same
        })
    }
}

impl Group {
    pub fn of(kept: &Kept, craft: &Problem) -> Result<Self, NotKept> {
        let named = |name: &&str| Limit::named(craft, name).ok_or_else(|| NotKept::Unknown((*name).into()));
        // For a chance over the motion this is the number of standard deviations of the first
        // flights.
        let z = normal_quantile(1.0 - kept.at_most);
        let limits = kept.limits.iter().map(named).collect::<Result<_, _>>()?;
        Ok(Self { limits, at_most: kept.at_most, over: kept.over, z, counted: None })
    }

    pub fn needed(&self, limit: &Limit, beside: &Beside, asked: &Problem) -> Needed {
        let least = limit.held(asked);
        let sigmas = sigmas(limit, beside, least.len());
        let same = |sigma: &f64| match (self.over, limit.quantity(asked)) {
            (Over::Motion(_), _) => (SAME_COUNTED * sigma).max(SAME_MARGIN),
            (Over::Instant, Quantity::Angle) => SAME_MARGIN,
            (Over::Instant, _) => SAME_RESERVE * sigma,
        };
        Needed {
            margins: sigmas.iter().zip(&least).map(|(sigma, least)| (self.z * sigma).max(*least)).collect(),
            same: sigmas.iter().map(same).collect(),
        }
    }
}

/// Returns, for each component or input of `limit`, the standard deviation of the limited quantity
/// at the instant at which its chance of exceeding the limit is largest; 0 if this deviation is
/// unknown.
fn sigmas(limit: &Limit, beside: &Beside, parts: usize) -> Vec<f64> {
    let chance = beside.chances.iter().find(|chance| chance.name == limit.name);
    let sigma = |part: usize| Some(chance?.parts.get(part)?.sigma);
    (0..parts).map(|part| sigma(part).unwrap_or(0.0)).collect()
}

/// The simulated flights of a plan from which chances of exceeding limits are counted.
pub(super) struct Flights<'a> {
    pub beside: &'a Beside,
    pub planned: &'a Problem,
    pub craft: &'a Problem,
    pub uncertainty: &'a Uncertainty,
}

impl Flights<'_> {
    /// Number of flights whose results are held in memory at once.
    const CHUNK: usize = 8192;

    /// Counts the fraction of flights that exceed a limit, for each group whose chance refers to
    /// the motion. Then sets the number of standard deviations that the limits of the group must
    /// keep.
    pub fn count(&self, groups: &mut [Group]) {
        for group in groups {
            let Over::Motion(plant) = group.over else { continue };
            let left = self.left(group, plant);
            let exceeded = left.iter().filter(|left| **left < 0.0).count();
            group.counted = Some(Proportion::new(exceeded as u64, left.len() as u64));
            group.z = (group.z - quantile(&left, group.at_most)).max(0.0);
        }
    }

    /// Returns, for every flight, the smallest distance from the limits of a group, in standard
    /// deviations. The distances are in ascending order; minus infinity stands for a flight without
    /// a result.
    fn left(&self, group: &Group, plant: Plant) -> Vec<f64> {
        let gains = self.beside.gains.as_ref();
        let mut watched = Vec::new();
        let mut limits = Vec::new();
        for limit in &group.limits {
            let parts = limit.bounds(self.craft).len();
            limits.push((limit, watched.len(), sigmas(limit, self.beside, parts)));
            watched.extend(limit.watched(self.craft));
        }
        let campaign = Campaign::new(self.planned, &self.beside.linear, gains, self.uncertainty, plant, SEED)
            .with_constraints(watched);
        let cases = Over::flights(group.at_most, self.beside.linear.count());
        let least = |flown: Flown| {
            let of = |(limit, first, sigmas): &(&Limit, usize, Vec<f64>)| {
                let rooms = limit.room(self.craft, &flown, *first);
                rooms
                    .iter()
                    .zip(sigmas)
                    .map(|(room, sigma)| in_deviations(*room, *sigma))
                    .fold(f64::INFINITY, f64::min)
            };
            limits.iter().map(of).fold(f64::INFINITY, f64::min)
        };
        let left = |case: Result<Flown, Lost>| case.map_or(f64::NEG_INFINITY, least);
        let mut left: Vec<f64> = (0..cases)
            .step_by(Self::CHUNK)
            .flat_map(|first| campaign.fly_all(first as u64, Self::CHUNK.min(cases - first)))
            .map(left)
            .collect();
        left.sort_by(f64::total_cmp);
        left
    }
}

/// Returns the distance `room` from a limit, in units of the standard deviation `sigma`. Without
/// uncertainty (`sigma` = 0) the distance is infinite, because the plan itself keeps its limits.
fn in_deviations(room: f64, sigma: f64) -> f64 {
    if sigma > 0.0 { room / sigma } else { f64::INFINITY }
}
