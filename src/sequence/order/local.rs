//! Local search for the order of many stops. It starts from nearest neighbours, moves and reverses
//! runs of one to three stops (Or 1976), and reverses longer stretches (Croes 1958). The best order
//! is then perturbed by exchanges of two stretches (Martin, Otto and Felten 1991), with a fixed
//! seed.

use super::Stops;
use crate::numerics::random::Stream;

/// Length of the longest run of stops that is moved at once.
const LONGEST_RUN: usize = 3;

/// Number of perturbations without a better order after which the search ends. More of them
/// occasionally find a better order, and take proportionally longer (`evidence -- orders`).
const PATIENCE: u32 = 60;

/// Returns the best order that is found for the `free` stops, followed by the stop that must stay
/// last, if one must.
pub fn best(stops: &Stops, free: Vec<usize>) -> Vec<usize> {
    let search = Search { stops };
    let mut best = search.improved(search.nearest(free));
    let mut value = search.value(&best);
    let (mut idle, mut shakes) = (0, 0);
    while idle < PATIENCE {
        let next = search.improved(shaken(&best, shakes));
        let found = search.value(&next);
        shakes += 1;
        idle += 1;
        if found < value {
            (best, value, idle) = (next, found, 0);
        }
    }
    best.extend(stops.last);
    best
}

struct Search<'s, 'a> {
    stops: &'s Stops<'a>,
}

impl Search<'_, '_> {
    /// Returns the value of an order as a pair to be minimised: its delay first, then its end time.
    fn value(&self, order: &[usize]) -> (f64, f64) {
        let whole: Vec<usize> = order.iter().copied().chain(self.stops.last).collect();
        let (end, late) = self.stops.followed(&whole);
        (late, end)
    }

    /// Builds an order greedily: the next stop is the one whose hold ends first.
    fn nearest(&self, mut left: Vec<usize>) -> Vec<usize> {
        let (mut at, mut time, mut order) = (0, 0.0, Vec::with_capacity(left.len()));
        while !left.is_empty() {
            let done = |index: &usize| {
                let (end, late) = self.stops.visited(at, left[*index], time);
                (late, end)
            };
            let order_of = |a: &usize, b: &usize| {
                let (a, b) = (done(a), done(b));
                a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
            };
            let next = (0..left.len()).min_by(order_of).unwrap_or(0);
            let stop = left.swap_remove(next);
            time = self.stops.visited(at, stop, time).0;
            order.push(stop);
            at = stop;
        }
        order
    }

    /// Improves an order by local changes until no change makes it better.
    fn improved(&self, mut order: Vec<usize>) -> Vec<usize> {
        let mut value = self.value(&order);
        loop {
            let before = value;
            for next in neighbours(order.len()) {
                let changed = next.applied(&order);
                let found = self.value(&changed);
                if found < value {
                    (order, value) = (changed, found);
                }
            }
            if value >= before {
                return order;
            }
        }
    }
}

/// A local change of an order.
#[derive(Clone, Copy)]
enum Change {
    /// Reversal of the stops from the first index up to, but not including, the second.
    Turn(usize, usize),
    /// Move of a run: its first index, its length, its index in the remaining stops, and whether it
    /// is reversed.
    Move(usize, usize, usize, bool),
}

impl Change {
    fn applied(self, order: &[usize]) -> Vec<usize> {
        let mut changed = order.to_vec();
        match self {
            Self::Turn(from, to) => changed[from..to].reverse(),
            Self::Move(from, count, to, turned) => {
                let mut run: Vec<usize> = changed.drain(from..from + count).collect();
                if turned {
                    run.reverse();
                }
                changed.splice(to..to, run);
            }
        }
        changed
    }
}

/// Returns all local changes of an order of `count` stops.
fn neighbours(count: usize) -> impl Iterator<Item = Change> {
    let turns = (0..count).flat_map(move |from| (from + 2..=count).map(move |to| Change::Turn(from, to)));
    let moves = (1..=LONGEST_RUN.min(count.saturating_sub(1))).flat_map(move |run| {
        (0..=count - run).flat_map(move |from| {
            let places = (0..=count - run).filter(move |to| *to != from);
            places.flat_map(move |to| [false, true].map(|turned| Change::Move(from, run, to, turned)))
        })
    });
    turns.chain(moves)
}

/// Returns a perturbed order: cut at random into four pieces, with the two inner pieces exchanged.
fn shaken(order: &[usize], shake: u32) -> Vec<usize> {
    let count = order.len();
    let mut stream = Stream::new(0, 0, shake);
    let mut cut = || ((stream.unit() * (count + 1) as f64) as usize).min(count);
    let mut cuts = [cut(), cut(), cut()];
    cuts.sort_unstable();
    let [a, b, c] = cuts;
    [&order[..a], &order[b..c], &order[a..b], &order[c..]].concat()
}
