//! Minima found by descents, without duplicates.

use crate::lie;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point;
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::found::SAME_COST;

/// Relative cost difference below which two minima are the same.
pub const SAME_MINIMUM: f64 = 1e-7;

/// Minima with different costs, the cheapest first.
#[derive(Default)]
pub struct Minima(pub Vec<Attempt>);

impl Minima {
    /// Adds the result of a descent. Returns its index if it is a new minimum; `None` otherwise.
    pub fn add(&mut self, minimum: Attempt) -> Option<usize> {
        if !minimum.converged() {
            return None;
        }
        let same = |other: &&mut Attempt| (other.cost - minimum.cost).abs() <= SAME_MINIMUM * minimum.cost;
        if let Some(known) = self.0.iter_mut().find(same) {
            if is_better(&minimum, known) {
                *known = minimum;
            }
            return None;
        }
        let place = self.0.partition_point(|other| other.cost < minimum.cost);
        self.0.insert(place, minimum);
        Some(place)
    }
}

/// Returns whether a minimum replaces another of equal cost. It does if it costs slightly less or,
/// where a symmetry gives many minima of equal cost, if it turns less.
fn is_better(minimum: &Attempt, other: &Attempt) -> bool {
    let difference = (minimum.cost - other.cost) / other.cost.abs().max(f64::MIN_POSITIVE);
    if difference.abs() > SAME_COST {
        difference < 0.0
    } else {
        turned(&minimum.candidate) < turned(&other.candidate)
    }
}

/// Returns the angle through which a path turns, summed from node to node \[rad\].
fn turned(path: &Candidate) -> f64 {
    let step = |pair: &[Point]| lie::minus(&pair[1].attitude.value, &pair[0].attitude.value).norm();
    path.states.windows(2).map(step).sum()
}
