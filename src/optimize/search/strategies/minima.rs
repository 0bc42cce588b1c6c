//! The minima that descents have ended at, each once.

use crate::lie;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point;
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::found::SAME_COST;

/// Minima whose costs differ by less, relative, are one.
pub const SAME_MINIMUM: f64 = 1e-7;

/// Minima of different costs, cheapest first.
#[derive(Default)]
pub struct Minima(pub Vec<Attempt>);

impl Minima {
    /// Adds what a descent has ended at. Its place, where it is a minimum that was not known.
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

/// Whether a minimum is to be taken instead of another of the same cost: a lower cost, or where a
/// symmetry gives many of one cost, less turning.
fn is_better(minimum: &Attempt, other: &Attempt) -> bool {
    let difference = (minimum.cost - other.cost) / other.cost.abs().max(f64::MIN_POSITIVE);
    if difference.abs() > SAME_COST {
        difference < 0.0
    } else {
        turned(&minimum.candidate) < turned(&other.candidate)
    }
}

/// The angle that a path turns by, from node to node \[rad\].
fn turned(path: &Candidate) -> f64 {
    let step = |pair: &[Point]| lie::minus(&pair[1].attitude.value, &pair[0].attitude.value).norm();
    path.states.windows(2).map(step).sum()
}
