//! Orders of many stops: a nearest neighbour first, then runs of one to three stops moved and
//! turned round (Or 1976), stretches turned round (Croes 1958), and the best order shaken by
//! exchanges of two stretches (Martin, Otto and Felten 1991), with a fixed seed.

use super::Stops;
use crate::numerics::random::Stream;

/// The longest run of stops that is moved at a time.
const LONGEST_RUN: usize = 3;

/// Shakes without a better order after which the search ends: more of them find a better order now
/// and then, and take as much longer (`evidence -- orders`).
const PATIENCE: u32 = 60;

/// Returns the best order that is found of the `free` stops, with the last one behind them.
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
    /// What an order is judged by: lateness first, then its end.
    fn value(&self, order: &[usize]) -> (f64, f64) {
        let whole: Vec<usize> = order.iter().copied().chain(self.stops.last).collect();
        let (end, late) = self.stops.followed(&whole);
        (late, end)
    }

    /// Goes to the stop that is done first, again and again.
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

    /// Changes an order as long as that makes it better.
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

/// A change of an order.
#[derive(Clone, Copy)]
enum Change {
    /// The stops from one place up to another are turned round.
    Turn(usize, usize),
    /// So many stops from a place are moved to another place of what is left, turned round or not.
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

/// All changes of an order of so many stops.
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

/// An order whose two inner quarters have changed places.
fn shaken(order: &[usize], shake: u32) -> Vec<usize> {
    let count = order.len();
    let mut stream = Stream::new(0, 0, shake);
    let mut cut = || ((stream.unit() * (count + 1) as f64) as usize).min(count);
    let mut cuts = [cut(), cut(), cut()];
    cuts.sort_unstable();
    let [a, b, c] = cuts;
    [&order[..a], &order[b..c], &order[a..b], &order[c..]].concat()
}
