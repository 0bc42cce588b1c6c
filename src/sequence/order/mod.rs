//! Search for the best order of stops, given the durations or costs of all legs between them.
//!
//! A leg from stop i to stop j that begins at time t lasts `T_ij(t)`. At a stop the body settles,
//! waits until the window opens, and holds. The search minimises the end of the last hold. For up
//! to [`MOST_EXACT`] stops the order is exact (dynamic programming over the sets of visited stops,
//! Held and Karp 1962; Bellman 1962). For more stops it is the best order that a local search
//! finds, with a proved lower bound. Exactness requires that an earlier arrival never delays the
//! end. This holds because the body may wait at a stop.
//!
//! The search uses the durations of plans that were found. Its result is that no order of these
//! legs is better. It proves nothing about the legs themselves.
//!
//! Minimum effort without limits in a total time T is a special case. A leg from rest to rest costs
//! `c/T_i³`, so the best split of the time has `T_i ∝ c_i^{1/4}`, and all legs together cost
//! `(Σ c_i^{1/4})⁴/T³`. The weights of the legs are then `c_i^{1/4}`, and no stop has a window.

mod bound;
mod exact;
mod local;
#[cfg(test)]
mod tests;

/// Largest number of stops whose order is found exactly, not counting the start and a given last
/// stop. Sixteen stops would take 17 MB and twice the time.
pub const MOST_EXACT: usize = 15;

/// The times of a visit to a stop: settling, hold and window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// Time from the arrival to the start of the hold in which the body settles \[s\].
    pub settling: f64,
    /// Duration of the hold \[s\].
    pub hold: f64,
    /// The window: earliest start and latest end of the hold \[s\].
    pub window: [f64; 2],
    /// Whether the hold must begin exactly when the window opens.
    pub pinned: bool,
}

impl Visit {
    /// The visit to a stop that has neither a window nor a hold.
    pub const PASSED: Self =
        Self { settling: 0.0, hold: 0.0, window: [f64::NEG_INFINITY, f64::INFINITY], pinned: false };

    /// Relative round-off of sums of times, within which a hold that fills its window is not late.
    pub const ROUND_OFF: f64 = 1e-12;

    /// Returns the shortest time that the body rests at the stop \[s\].
    pub fn rest(&self) -> f64 {
        self.settling + self.hold
    }

    /// Returns the latest start of the hold \[s\].
    fn latest(&self) -> f64 {
        if self.pinned { self.window[0] } else { self.window[1] - self.hold }
    }

    /// Returns two arrival times \[s\]: the earliest from which the body need not wait, and the
    /// latest that keeps the window.
    pub fn arrival(&self) -> [f64; 2] {
        [self.window[0] - self.settling, self.latest() - self.settling]
    }

    /// Returns the end of the hold for an arrival at this time \[s\], and the delay past the window
    /// \[s\], zero if the window is kept.
    pub fn after(&self, arrival: f64) -> (f64, f64) {
        let begin = (arrival + self.settling).max(self.window[0]);
        let late = begin - self.latest();
        let is_late = late > Self::ROUND_OFF * (begin.abs() + self.hold);
        (begin + self.hold, if is_late { late } else { 0.0 })
    }
}

/// The stops to be ordered, with the durations of their legs. Index 0 is the start.
pub struct Stops<'a> {
    /// The visits to all stops in the order of their indices 1, 2, …, without the start.
    pub visits: &'a [Visit],
    /// The duration \[s\] or the weight of a leg, as a function of the index of its first stop, the
    /// index of its second stop, and its start time \[s\]. A leg that begins later must not end
    /// earlier.
    pub leg: &'a dyn Fn(usize, usize, f64) -> f64,
    /// The smallest duration or weight of a leg over all start times.
    pub least: &'a dyn Fn(usize, usize) -> f64,
    /// Index of the stop that must stay last; `None` if all stops may be reordered.
    pub last: Option<usize>,
}

/// The evidence that an order of stops is the best one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proof {
    /// No order of these legs ends earlier.
    AllOrders,
    /// The order is the best that was found; the lower bound on all orders is proved.
    LowerBound,
    /// The durations of legs depend on their start times, and are known only for the orders that
    /// were tried. The order is the best of these.
    None,
}

/// An order of stops, with its end time and the evidence for it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Order {
    /// Indices of the stops in the order of the visit, from 1, without the start.
    pub stops: Vec<usize>,
    /// End of the last hold \[s\].
    pub end: f64,
    /// Sum of the delays past the ends of windows \[s\]; zero if the order keeps all windows.
    pub late: f64,
    /// Lower bound \[s\]: no order ends earlier.
    pub bound: f64,
    /// The evidence that this order is the best one.
    pub proof: Proof,
}

impl Order {
    /// Returns the relative optimality gap: the largest fraction of its end time by which the order
    /// may end later than the best one.
    pub fn gap(&self) -> f64 {
        if self.end > 0.0 { ((self.end - self.bound) / self.end).max(0.0) } else { 0.0 }
    }
}

impl Stops<'_> {
    /// Finds the best order of the stops. If no order keeps all windows, it is an order with small
    /// delays.
    pub fn best_order(&self) -> Order {
        let free = self.free();
        let exact = if free.len() <= MOST_EXACT { exact::best(self, &free) } else { None };
        if let Some(stops) = exact {
            let (end, late) = self.followed(&stops);
            return Order { stops, end, late, bound: end, proof: Proof::AllOrders };
        }
        let stops = local::best(self, free);
        let (end, late) = self.followed(&stops);
        let bound = bound::of(self).min(end);
        Order { stops, end, late, bound, proof: Proof::LowerBound }
    }

    /// Returns the indices of the stops that may be reordered.
    fn free(&self) -> Vec<usize> {
        (1..=self.visits.len()).filter(|stop| Some(*stop) != self.last).collect()
    }

    /// Returns the end of the hold at a stop whose leg begins at `time`, and its delay, both \[s\].
    fn visited(&self, from: usize, to: usize, time: f64) -> (f64, f64) {
        self.visits[to - 1].after(time + (self.leg)(from, to, time))
    }

    /// Returns the end of an order and the sum of its delays, both \[s\].
    pub fn followed(&self, stops: &[usize]) -> (f64, f64) {
        let (mut at, mut time, mut late) = (0, 0.0, 0.0);
        for stop in stops {
            let (end, behind) = self.visited(at, *stop, time);
            (at, time, late) = (*stop, end, late + behind);
        }
        (time, late)
    }
}
