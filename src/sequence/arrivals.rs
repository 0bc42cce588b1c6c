//! End times of the legs of minimum-effort and minimum-fuel sequences, whose total duration is
//! given.
//!
//! The unknown of leg i is its end time t_i, so that windows are bounds on single unknowns. After a
//! leg the body settles and holds for r_i, and the next leg lasts `t_{i+1} − t_i − r_i`. A hold
//! begins and ends within its window, and every leg begins after the hold before it and ends before
//! the next one:
//!
//! ```text
//! from_i − settling_i ≤ t_i ≤ until_i − hold_i − settling_i ,    t_i + r_i ≤ t_{i+1}
//! ```
//!
//! An arrival before the window opens has no advantage: the body would rest for a time that the leg
//! could use.

use super::order::Visit;
use super::{Sequence, SequenceError};
use crate::maneuver::objective::Objective;

/// Lower and upper bound of the end time of a leg \[s\]; they are equal if the end time is given.
pub type Bounds = [f64; 2];

/// Returns whether the end time of a leg is given.
pub fn is_given([from, until]: Bounds) -> bool {
    from >= until
}

impl Sequence {
    /// Returns the bounds of the end times of all legs, for stops in this order. Returns `None` if
    /// each leg finds its own duration.
    ///
    /// # Errors
    /// [`SequenceError::NoTime`] if the holds take the whole duration, and
    /// [`SequenceError::Windows`] if the windows leave no time for a leg.
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

/// Narrows each bound by the bounds of the legs before and after it.
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

/// Returns end times that divide the total time among the legs in proportion to `weights`, as far
/// as the bounds allow. The end time that violates its bound most is fixed at the bound; the other
/// legs then share the remaining time.
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

/// Returns the end times of legs that share the time between given end times in proportion to their
/// weights.
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

    /// Three legs of equal weights in 12 s, with rests of 1 s: each leg lasts 10/3 s unless a
    /// window prevents it.
    #[test]
    fn the_time_is_split_within_windows() {
        let (free, rests, weights) = ([f64::NEG_INFINITY, f64::INFINITY], [1.0, 1.0, 0.0], [1.0; 3]);
        let third = 10.0 / 3.0;
        let is = |bounds: [Bounds; 3], known: [f64; 3]| {
            let found = split(0.0, &bounds, &rests, &weights);
            assert!(found.iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} {known:?}");
        };
        is([free, free, [12.0; 2]], [third, 2.0 * third + 1.0, 12.0]);
        // The first hold begins at 2 s at the latest; the other two legs share 8 s.
        is([[0.0, 2.0], free, [12.0; 2]], [2.0, 7.0, 12.0]);
        // The second hold begins at 9 s at the earliest; the first two legs share 8 s.
        is([free, [9.0, 20.0], [12.0; 2]], [4.0, 9.0, 12.0]);
        // Both bounds are active.
        is([[5.0, 5.0], [9.5, 20.0], [12.0; 2]], [5.0, 9.5, 12.0]);
    }
}
