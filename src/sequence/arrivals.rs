//! When legs end whose durations are parts of a given whole: of least effort or fuel.
//!
//! The end t_i of leg i is its unknown, so that windows are bounds of single unknowns. After a leg
//! the body settles and holds for r_i, and the next leg lasts `t_{i+1} − t_i − r_i`. A hold begins
//! and ends within its window, and no leg of positive duration skips what comes before or after it:
//!
//! ```text
//! from_i − settling_i ≤ t_i ≤ until_i − hold_i − settling_i ,    t_i + r_i ≤ t_{i+1}
//! ```
//!
//! To arrive before a window opens gains nothing: the body would rest for what the leg can use.

use super::order::Visit;
use super::{Sequence, SequenceError};
use crate::maneuver::objective::Objective;

/// Bounds of the end of a leg \[s\]; equal where it is given.
pub type Bounds = [f64; 2];

/// Returns whether the end of a leg is given.
pub fn is_given([from, until]: Bounds) -> bool {
    from >= until
}

impl Sequence {
    /// Returns the bounds of the ends of all legs to stops in their order; `None` where each leg finds
    /// its own duration.
    ///
    /// # Errors
    /// [`SequenceError::NoTime`] if the holds take the whole, and [`SequenceError::Windows`] if
    /// windows leave a leg no time.
    pub(super) fn arrivals(&self, stops: &[usize]) -> Result<Option<Vec<Bounds>>, SequenceError> {
        let visit = |stop: &usize| self.stops[*stop].visit;
        let Some(last) = stops.last().map(visit) else { return Ok(None) };
        let total = self.shared()?.and(self.craft.duration.known());
        if matches!(self.craft.objective, Objective::Time) || !last.pinned && total.is_none() {
            return Ok(None);
        }
        let mut bounds: Vec<Bounds> = stops.iter().map(|stop| visit(stop).arrival()).collect();
        if let (Some(end), false) = (bounds.last_mut(), last.pinned) {
            let whole = total.map_or(f64::INFINITY, |total| total - last.rest());
            *end = [end[1].min(whole); 2];
        }
        let rests: Vec<f64> = stops.iter().map(|stop| visit(stop).rest()).collect();
        narrow(0.0, &mut bounds, &rests);
        for (stop, [from, until]) in stops.iter().zip(&bounds) {
            let late = from - until;
            if late > Visit::ROUND_OFF * from.abs() {
                return Err(SequenceError::Windows { stops: self.named(&[*stop]), late });
            }
        }
        Ok(Some(bounds))
    }
}

/// Narrows bounds to what those before and after them leave.
fn narrow(begins: f64, bounds: &mut [Bounds], rests: &[f64]) {
    let mut earliest = begins;
    for (bound, rest) in bounds.iter_mut().zip(rests) {
        bound[0] = bound[0].max(earliest);
        earliest = bound[0] + rest;
    }
    let mut latest = f64::INFINITY;
    for (bound, rest) in bounds.iter_mut().zip(rests).rev() {
        bound[1] = bound[1].min(latest - rest);
        latest = bound[1];
    }
}

/// Returns ends of legs within their bounds that share the time as weights ask for, as far as the
/// bounds allow: the end that misses its bound by most is moved there, and divides the others.
pub fn split(begins: f64, bounds: &[Bounds], rests: &[f64], weights: &[f64]) -> Vec<f64> {
    let mut bounds = bounds.to_vec();
    loop {
        narrow(begins, &mut bounds, rests);
        let ends = shared(begins, &bounds, rests, weights);
        let missed = |index: usize| {
            let [from, until] = bounds[index];
            (from - ends[index]).max(ends[index] - until)
        };
        let open = (0..bounds.len()).filter(|index| !is_given(bounds[*index]));
        match open.max_by(|a, b| missed(*a).total_cmp(&missed(*b))) {
            Some(worst) if missed(worst) > 0.0 => {
                let [from, until] = bounds[worst];
                bounds[worst] = [ends[worst].clamp(from, until); 2];
            }
            _ => return ends,
        }
    }
}

/// Returns the ends of legs that share the time between given ends by their weights.
fn shared(begins: f64, bounds: &[Bounds], rests: &[f64], weights: &[f64]) -> Vec<f64> {
    let mut ends = Vec::with_capacity(bounds.len());
    let mut time = begins;
    while ends.len() < bounds.len() {
        let first = ends.len();
        let next = (first..bounds.len()).find(|index| is_given(bounds[*index]));
        let last = next.unwrap_or(bounds.len() - 1);
        let rest: f64 = rests[first..last].iter().sum();
        let (left, all) = (bounds[last][1] - time - rest, weights[first..=last].iter().sum::<f64>());
        for index in first..last {
            ends.push(time + left * weights[index] / all);
            time = ends[index] + rests[index];
        }
        ends.push(bounds[last][1]);
        time = bounds[last][1] + rests[last];
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three legs of equal weights in 12 s, with rests of 1 s: each has 10/3 s, unless a window says
    /// otherwise.
    #[test]
    fn the_time_is_split_within_windows() {
        let (free, rests, weights) = ([f64::NEG_INFINITY, f64::INFINITY], [1.0, 1.0, 0.0], [1.0; 3]);
        let third = 10.0 / 3.0;
        let is = |bounds: [Bounds; 3], known: [f64; 3]| {
            let found = split(0.0, &bounds, &rests, &weights);
            assert!(found.iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} {known:?}");
        };
        is([free, free, [12.0; 2]], [third, 2.0 * third + 1.0, 12.0]);
        // The first hold begins no later than after 2 s, and 8 s are left for two legs.
        is([[0.0, 2.0], free, [12.0; 2]], [2.0, 7.0, 12.0]);
        // The second one begins no earlier than after 9 s: the first leg has half of 8 s.
        is([free, [9.0, 20.0], [12.0; 2]], [4.0, 9.0, 12.0]);
        // Both bounds act.
        is([[5.0, 5.0], [9.5, 20.0], [12.0; 2]], [5.0, 9.5, 12.0]);
    }
}
