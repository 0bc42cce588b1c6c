//! Initial values of free rolls at the stops: the best rolls of a grid, judged by the turns of all
//! legs.
//!
//! A turn φ about a fixed axis needs the momentum `Jφ/T`. The cost of a leg is a power of its norm:
//! the square for minimum effort in a given time, the square root for minimum time, and the norm
//! itself for minimum fuel. Dynamic programming (Bellman) keeps the cheapest sequence to each roll
//! of each stop, so that the total work grows only with the number of pairs of rolls at
//! neighbouring stops.

use super::joint::Joint;
use crate::Matrix3;
use crate::lie;
use crate::maneuver::problem::State;

/// Number of rolls in the grid. Optima of neighbouring rolls are farther apart than its spacing
/// (`evidence -- dwells`).
const ROLLS: usize = 24;

/// Returns the states at the joints for the cheapest rolls of the grid, from a given start. Rolls
/// that `allowed` rejects are excluded, unless it rejects all rolls of a joint. `power` is the
/// exponent of the momentum in the cost of a leg, and `lasting` holds the known durations of the
/// first legs \[s\].
pub fn cheapest(
    start: &State,
    joints: &[Joint],
    allowed: &dyn Fn(&State) -> bool,
    (inertia, power): (&Matrix3, f64),
    lasting: &[f64],
) -> Vec<State> {
    let mut known: Vec<(f64, Vec<State>)> = vec![(0.0, vec![*start])];
    for (index, joint) in joints.iter().enumerate() {
        let duration = lasting.get(index).copied().unwrap_or(1.0);
        let price = |from: &State, to: &State| {
            let momentum = inertia * lie::minus(&to.attitude, &from.attitude) / duration;
            momentum.norm().powf(power) * if power > 1.0 { duration.recip() } else { 1.0 }
        };
        let way_to = |state: State| {
            let priced = known.iter().map(|(cost, way)| {
                let last = way.last().unwrap_or(start);
                (cost + price(last, &state), way)
            });
            let (cost, way) = priced.min_by(|a, b| a.0.total_cmp(&b.0))?;
            Some((cost, way.iter().copied().chain([state]).collect()))
        };
        let mut states = candidates(joint);
        if states.iter().any(allowed) {
            states.retain(allowed);
        }
        let next: Vec<_> = states.into_iter().filter_map(way_to).collect();
        known = next;
    }
    let best = known.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, way)| way[1..].to_vec()).unwrap_or_default()
}

/// Returns the candidate states at a joint of two legs: one for each roll of the grid, or the only
/// one if the joint has no free roll.
fn candidates(joint: &Joint) -> Vec<State> {
    let over =
        |within: f64| (0..ROLLS).map(move |index| within * (2.0 * (index as f64 + 0.5) / ROLLS as f64 - 1.0));
    match joint {
        Joint::Given(state) => vec![*state],
        Joint::Passing { at, .. } => vec![*at],
        Joint::Roll(ends) => over(ends.within()).map(|roll| joint.state(&[roll])).collect(),
        Joint::PassingRoll { ends, .. } => {
            over(ends.within()).map(|roll| joint.state(&[roll, 0.0, 0.0, 0.0])).collect()
        }
    }
}
