//! First rolls at stops whose roll is free: the best of a grid of rolls, by the turns of all legs.
//!
//! A turn φ about a fixed axis has the momentum `Jφ/T`, whose size is what a leg costs: its square
//! of effort in a given time, its root of time, itself of fuel. Stop after stop the cheapest way to
//! each roll is kept (Bellman), so that the grid of all stops costs what its pairs do.

use super::joint::Joint;
use crate::Matrix3;
use crate::lie;
use crate::maneuver::problem::State;

/// Rolls of a grid: optima of neighbouring rolls are wider apart (`evidence -- dwells`).
const ROLLS: usize = 24;

/// Returns the states at the joints for the cheapest rolls of the grid, from a start; at each of them
/// a body is `allowed` to be, if it is at any. `power` is that of the momentum which a leg costs, and
/// `lasting` what the legs last, as far as they are known.
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

/// Returns the states of a joint over the grid of rolls.
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
