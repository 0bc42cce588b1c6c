//! The best order of stops, by the times or costs of all legs between them.
//!
//! A leg from stop i to stop j that begins at time t takes `T_ij(t)`. At a stop the body settles,
//! waits until its window opens, and holds. The end of the last hold is minimised. Up to
//! [`MOST_EXACT`] stops the order is exact (dynamic programming over the sets of visited stops,
//! Held and Karp 1962; Bellman 1962), and beyond that it is the best that a local search finds,
//! with a proved lower bound. The exactness needs that an earlier arrival never hurts, which holds
//! where one may wait at a stop.
//!
//! Times that were *found* order the legs: no order is better with these legs. They prove nothing
//! about the legs themselves.
//!
//! Least effort without limits in a total time T is a case of this. A leg from rest to rest costs
//! `c/T_i³`, so the best split has `T_i ∝ c_i^{1/4}`, and all legs together cost
//! `(Σ c_i^{1/4})⁴/T³`: the weights of the legs are `c_i^{1/4}`, and no stop has a window.

mod bound;
mod exact;
mod local;
#[cfg(test)]
mod tests;

/// The most stops, besides the start and a last one that is given, whose order is exact: sixteen
/// would take 17 MB and twice the time.
pub const MOST_EXACT: usize = 15;

/// What happens at a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// The rest before the hold \[s\].
    pub settling: f64,
    /// The hold \[s\].
    pub hold: f64,
    /// The earliest begin of the hold and its latest end \[s\].
    pub window: [f64; 2],
    /// Whether the hold begins when the window opens, and not later.
    pub pinned: bool,
}

impl Visit {
    /// A stop without a window, nor a hold.
    pub const PASSED: Self =
        Self { settling: 0.0, hold: 0.0, window: [f64::NEG_INFINITY, f64::INFINITY], pinned: false };

    /// The round-off of sums of times, as a part of them: a hold that fills its window is not late.
    pub const ROUND_OFF: f64 = 1e-12;

    /// Returns how long the body rests here at least \[s\].
    pub fn rest(&self) -> f64 {
        self.settling + self.hold
    }

    /// Returns the latest begin of the hold \[s\].
    fn latest(&self) -> f64 {
        if self.pinned { self.window[0] } else { self.window[1] - self.hold }
    }

    /// Returns the earliest arrival after which the body need not wait, and the latest one that is in
    /// time, both \[s\].
    pub fn arrival(&self) -> [f64; 2] {
        [self.window[0] - self.settling, self.latest() - self.settling]
    }

    /// Returns the end of the hold after an arrival \[s\], and by how much it is late \[s\].
    pub fn after(&self, arrival: f64) -> (f64, f64) {
        let begin = (arrival + self.settling).max(self.window[0]);
        let late = begin - self.latest();
        let is_late = late > Self::ROUND_OFF * (begin.abs() + self.hold);
        (begin + self.hold, if is_late { late } else { 0.0 })
    }
}

/// Stops to be ordered; stop 0 is the start.
pub struct Stops<'a> {
    /// All stops but the start, from 1.
    pub visits: &'a [Visit],
    /// Returns how long a leg takes \[s\], or what it weighs: from a stop, to a stop, and the time
    /// at which it begins. The end of a leg must not be earlier where it begins later.
    pub leg: &'a dyn Fn(usize, usize, f64) -> f64,
    /// Returns the least that the leg takes at any time.
    pub least: &'a dyn Fn(usize, usize) -> f64,
    /// The stop that stays last.
    pub last: Option<usize>,
}

/// What is known of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proof {
    /// No order of these legs ends earlier.
    AllOrders,
    /// The lower bound is proved; the order is the best that was found.
    LowerBound,
    /// Legs depend on when they begin, and are known at the times of the orders that were tried:
    /// the order is the best of these.
    None,
}

/// An order of stops.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Order {
    /// The stops, without the start.
    pub stops: Vec<usize>,
    /// The end of the last hold \[s\].
    pub end: f64,
    /// By how much windows are missed, in all \[s\]: zero for an order that keeps them.
    pub late: f64,
    /// No order ends earlier than this \[s\].
    pub bound: f64,
    /// What is known.
    pub proof: Proof,
}

impl Order {
    /// Returns by how much the order may end later than the best one, relative.
    pub fn gap(&self) -> f64 {
        if self.end > 0.0 { ((self.end - self.bound) / self.end).max(0.0) } else { 0.0 }
    }
}

impl Stops<'_> {
    /// Finds the best order. If no order keeps all windows, it is one that misses them by little.
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

    /// Returns the stops whose order is free.
    fn free(&self) -> Vec<usize> {
        (1..=self.visits.len()).filter(|stop| Some(*stop) != self.last).collect()
    }

    /// Returns the end of a stop whose leg begins at a time, and by how much it is late.
    fn visited(&self, from: usize, to: usize, time: f64) -> (f64, f64) {
        self.visits[to - 1].after(time + (self.leg)(from, to, time))
    }

    /// Returns the end of an order and by how much its stops are late, in all \[s\].
    pub fn followed(&self, stops: &[usize]) -> (f64, f64) {
        let (mut at, mut time, mut late) = (0, 0.0, 0.0);
        for stop in stops {
            let (end, behind) = self.visited(at, *stop, time);
            (at, time, late) = (*stop, end, late + behind);
        }
        (time, late)
    }
}
