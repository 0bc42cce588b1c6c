//! A lower bound on the end time of all orders: spanning trees with prices at the stops (Held and
//! Karp 1970).
//!
//! An order is a path from the start. A dummy stop between its last stop and the start closes it to
//! a tour. A tour is a spanning tree of the stops plus the two edges of the dummy, in which every
//! stop has two edges. Each stop has a price that is added to the length of each of its edges;
//! twice the sum of all prices is subtracted from the result. This changes the length of no tour,
//! so for any prices the shortest such tree is a lower bound for all tours. The prices are updated
//! along the subgradient, which is the number of edges of a stop minus two.

use super::Stops;

/// Number of subgradient steps. More steps hardly raise the bound (`evidence -- orders`).
const STEPS: usize = 400;

/// Returns a lower bound of the end time of all orders \[s\].
pub fn of(stops: &Stops) -> f64 {
    let count = stops.visits.len() + 1;
    let at_stops: f64 = stops.visits.iter().map(super::Visit::rest).sum();
    let opens = |visit: &super::Visit| visit.window[0] + visit.hold;
    let latest = stops.visits.iter().map(opens).fold(f64::NEG_INFINITY, f64::max);
    // Edges of a tree have no direction, so an edge has the shorter duration of the two legs.
    let leg = |a: usize, b: usize| {
        let [there, back] = [(a, b), (b, a)].map(|(from, to)| (stops.least)(from, to));
        if a == 0 {
            there
        } else if b == 0 {
            back
        } else {
            there.min(back)
        }
    };
    let legs: Vec<f64> = (0..count * count).map(|pair| leg(pair / count, pair % count)).collect();
    let mut prices = vec![0.0; count];
    let (mut best, mut step) = (0.0_f64, 0.0);
    for index in 0..STEPS {
        let Tree { cost, edges } = tree(&legs, &prices, stops.last);
        best = best.max(cost);
        let norm: f64 = edges.iter().map(|edges| (edges - 2.0) * (edges - 2.0)).sum();
        if norm == 0.0 {
            break;
        }
        if index == 0 {
            step = cost / count as f64;
        }
        // The step length decreases from about the mean leg to zero, so that the prices converge.
        let length = step * (1.0 - index as f64 / STEPS as f64).powi(2) / norm.sqrt();
        prices.iter_mut().zip(&edges).for_each(|(price, edges)| *price += length * (edges - 2.0));
    }
    (best + at_stops).max(latest)
}

/// The shortest tree with the two edges of the dummy: its length minus twice the sum of the prices,
/// and the number of edges of each stop.
struct Tree {
    cost: f64,
    edges: Vec<f64>,
}

fn tree(legs: &[f64], prices: &[f64], last: Option<usize>) -> Tree {
    let count = prices.len();
    let priced = |a: usize, b: usize| legs[a * count + b] + prices[a] + prices[b];
    let (mut edges, mut cost) = (vec![0.0; count], 0.0);
    // Prim's algorithm: for each stop outside the tree, the nearest stop inside.
    let mut nearest: Vec<(f64, usize)> = (0..count).map(|stop| (priced(0, stop), 0)).collect();
    let mut inside = vec![false; count];
    inside[0] = true;
    for _ in 1..count {
        let outside = (0..count).filter(|stop| !inside[*stop]);
        let Some(next) = outside.min_by(|a, b| nearest[*a].0.total_cmp(&nearest[*b].0)) else { break };
        let (length, from) = nearest[next];
        cost += length;
        edges[from] += 1.0;
        edges[next] += 1.0;
        inside[next] = true;
        for stop in 0..count {
            if !inside[stop] && priced(next, stop) < nearest[stop].0 {
                nearest[stop] = (priced(next, stop), next);
            }
        }
    }
    // The dummy has an edge to the start and an edge to the last stop.
    let of_dummy = |stop: &usize| prices[*stop];
    let cheapest = (1..count).min_by(|a, b| of_dummy(a).total_cmp(&of_dummy(b)));
    for stop in [Some(0), last.or(cheapest)].into_iter().flatten() {
        cost += prices[stop];
        edges[stop] += 1.0;
    }
    Tree { cost: cost - 2.0 * prices.iter().sum::<f64>(), edges }
}
