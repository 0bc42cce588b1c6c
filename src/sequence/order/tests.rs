use super::{Order, Proof, Stops, Visit, bound, local};
use crate::numerics::random::Stream;

/// Minimum times of all legs between six attitudes \[s\], planned by another program. By symmetry
/// the lower half equals the upper half.
const TIMES: [[f64; 6]; 6] = [
    [0.0, 14.969738728151052, 16.86409504618363, 11.05698424331468, 17.013680880913284, 15.517619864853009],
    [0.0, 0.0, 17.57792341774401, 14.528176371182912, 16.834504605822094, 19.243122318788345],
    [0.0, 17.577923417744035, 0.0, 16.365242424709876, 18.130975047797126, 16.146866229018993],
    [0.0, 14.528176371182912, 16.36524242470987, 0.0, 16.23223360678989, 17.20955715915052],
    [0.0, 16.834504605822094, 18.130975047797126, 16.23223358850242, 0.0, 18.17564525495798],
    [0.0, 19.24312231878837, 16.146866229018993, 17.209557473722516, 18.17564525495798, 0.0],
];

/// Minimum efforts of the legs of a similar body in one second.
const EFFORTS: [[f64; 6]; 6] = [
    [0.0, 17.314115075244665, 44.697869536007815, 4.5347788943589, 42.448564172145396, 20.63076626110254],
    [17.314115075244665, 0.0, 56.89939313089223, 27.103366768093494, 26.314299224346144, 47.293124080960965],
    [44.697869536007815, 56.89939313089223, 0.0, 30.305324739975067, 24.18534449991719, 35.06450048059968],
    [4.5347788943589, 27.103366768093494, 30.305324739975067, 0.0, 31.70261766957562, 40.07723937465937],
    [42.448564172145396, 26.314299224346144, 24.18534449991719, 31.70261766957562, 0.0, 53.894581246816216],
    [20.63076626110254, 47.293124080960965, 35.06450048059968, 40.07723937465937, 53.894581246816216, 0.0],
];

fn ordered(legs: &[Vec<f64>], visits: &[Visit], last: Option<usize>) -> Order {
    let leg = |from: usize, to: usize, _: f64| legs[from][to];
    let least = |from: usize, to: usize| legs[from][to];
    Stops { visits, leg: &leg, least: &least, last }.best_order()
}

fn rows(table: &[[f64; 6]; 6]) -> Vec<Vec<f64>> {
    table.iter().map(|row| row.to_vec()).collect()
}

/// Returns all orders of `count` stops.
fn all_orders(count: usize) -> Vec<Vec<usize>> {
    if count == 0 {
        return vec![Vec::new()];
    }
    let shorter = all_orders(count - 1);
    let with = |order: &Vec<usize>| {
        (0..=order.len())
            .map(|place| {
                let mut longer = order.clone();
                longer.insert(place, count);
                longer
            })
            .collect::<Vec<_>>()
    };
    shorter.iter().flat_map(with).collect()
}

/// Returns durations of legs between random points of a plane, which differ between the two
/// directions.
fn random_legs(case: u64, count: usize) -> Vec<Vec<f64>> {
    let mut stream = Stream::new(7, case, 0);
    let points: Vec<[f64; 2]> = (0..=count).map(|_| [stream.unit(), stream.unit()]).collect();
    let leg = |a: &[f64; 2], b: &[f64; 2]| {
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        10.0 * x.hypot(y) + 0.3 * (x - a[1]).abs()
    };
    points.iter().map(|a| points.iter().map(|b| leg(a, b)).collect()).collect()
}

/// A hold that exactly fills its window counts as kept despite round-off: 0.3 − 0.2 is below 0.1.
#[test]
fn a_hold_that_fills_its_window_is_not_late() {
    let visit = Visit { hold: 0.2, window: [0.1, 0.3], ..Visit::PASSED };
    assert_eq!(visit.after(0.0).1, 0.0);
    assert!((visit.after(0.15).1 - 0.05).abs() < 1e-12);
}

#[test]
fn five_stops_are_visited_in_the_best_of_all_orders() {
    let found = ordered(&rows(&TIMES), &[Visit::PASSED; 5], None);
    assert_eq!((found.stops, found.proof), (vec![3, 1, 4, 2, 5], Proof::AllOrders));
    assert!((found.end - 76.697_506_497_135_8).abs() < 1e-9);
}

#[test]
fn effort_orders_stops_by_the_fourth_roots_of_its_legs() {
    let weights: Vec<Vec<f64>> =
        EFFORTS.iter().map(|row| row.iter().map(|cost| cost.powf(0.25)).collect()).collect();
    let found = ordered(&weights, &[Visit::PASSED; 5], None);
    assert_eq!(found.stops, [3, 1, 4, 2, 5]);
    let split = |leg: f64| 30.0 * leg / found.end;
    assert!((split(weights[0][3]) - 4.107988118103805).abs() < 1e-9);
    assert!((split(weights[2][5]) - 6.850260131965072).abs() < 1e-9);
    let cost = found.end.powi(4) / 30.0_f64.powi(3);
    assert!((cost / 0.47770595624872747 - 1.0).abs() < 1e-12);
}

/// If the spanning-tree bound equals the best order, as for these times, the gap is zero.
#[test]
fn the_bound_of_five_stops_is_their_best_order() {
    let leg = |from: usize, to: usize, _: f64| TIMES[from][to].max(TIMES[to][from]);
    let least = |from: usize, to: usize| leg(from, to, 0.0);
    let stops = Stops { visits: &[Visit::PASSED; 5], leg: &leg, least: &least, last: None };
    let bound = bound::of(&stops);
    assert!(bound <= 76.697_506_5 && bound > 76.69, "{bound}");
}

#[test]
fn orders_with_holds_windows_and_a_last_stop_are_those_of_brute_force() {
    for case in 0..60 {
        let count = 2 + (case % 5) as usize;
        let legs = random_legs(case, count);
        let mut stream = Stream::new(8, case, 0);
        let visits: Vec<Visit> = (0..count)
            .map(|_| {
                let opens = if stream.unit() < 0.3 { 30.0 * stream.unit() } else { f64::NEG_INFINITY };
                let closes = if stream.unit() < 0.3 { 20.0 + 40.0 * stream.unit() } else { f64::INFINITY };
                let window = [opens, closes];
                Visit { settling: stream.unit(), hold: 3.0 * stream.unit(), window, pinned: false }
            })
            .collect();
        let last = (case % 3 == 0).then_some(count);
        let leg = |from: usize, to: usize, _: f64| legs[from][to];
        let least = |from: usize, to: usize| legs[from][to];
        let stops = Stops { visits: &visits, leg: &leg, least: &least, last };
        let ends =
            all_orders(count).into_iter().filter(|order| last.is_none_or(|last| order.ends_with(&[last])));
        let best = ends
            .filter_map(|order| {
                let (end, late) = stops.followed(&order);
                (late == 0.0).then_some(end)
            })
            .fold(f64::INFINITY, f64::min);
        let found = stops.best_order();
        if best.is_finite() {
            assert_eq!((found.late, found.proof), (0.0, Proof::AllOrders), "case {case}");
            assert!((found.end - best).abs() < 1e-12, "case {case}: {} {best}", found.end);
        } else {
            assert!(found.late > 0.0, "case {case}");
        }
    }
}

/// A leg that takes longer if it begins later changes the best order.
#[test]
fn times_that_depend_on_the_beginning_are_followed() {
    // The leg to stop 1 takes 1 s if it begins before t = 1.5, and 9 s later; the leg to stop 2
    // always takes 2 s.
    let leg = |_: usize, to: usize, time: f64| if to == 1 && time > 1.5 { 9.0 } else { to as f64 };
    let least = |_: usize, to: usize| to as f64;
    let found = Stops { visits: &[Visit::PASSED; 2], leg: &leg, least: &least, last: None }.best_order();
    assert_eq!((found.stops, found.end), (vec![1, 2], 3.0));
}

#[test]
fn a_hold_that_begins_at_a_time_waits_for_it() {
    let pinned = Visit { hold: 2.0, window: [10.0, f64::INFINITY], pinned: true, ..Visit::PASSED };
    assert_eq!(pinned.after(3.0), (12.0, 0.0));
    assert_eq!(pinned.after(11.0), (13.0, 1.0));
}

/// For up to fifteen stops the exact order is known, so the result of the local search for ten can
/// be checked.
#[test]
fn the_local_search_finds_the_best_of_ten_stops_and_bounds_hold() {
    for case in 0..12 {
        let legs = random_legs(100 + case, 10);
        let leg = |from: usize, to: usize, _: f64| legs[from][to];
        let least = |from: usize, to: usize| legs[from][to];
        let stops = Stops { visits: &[Visit::PASSED; 10], leg: &leg, least: &least, last: None };
        let exact = stops.best_order();
        let found = stops.followed(&local::best(&stops, (1..=10).collect())).0;
        let bound = bound::of(&stops);
        assert!((found - exact.end).abs() < 1e-9, "case {case}: {found} {}", exact.end);
        assert!(bound <= exact.end + 1e-9 && bound > 0.85 * exact.end, "case {case}: {bound} {}", exact.end);
    }
}

#[test]
fn forty_stops_have_an_order_with_a_proved_gap() {
    let legs = random_legs(1, 40);
    let found = ordered(&legs, &[Visit::PASSED; 40], Some(17));
    assert_eq!((found.proof, found.stops.last()), (Proof::LowerBound, Some(&17)));
    let mut visited = found.stops.clone();
    visited.sort_unstable();
    assert_eq!(visited, Vec::from_iter(1..=40));
    assert!((0.0..0.15).contains(&found.gap()), "{}", found.gap());
}

#[test]
fn no_stop_and_one_stop_are_orders_too() {
    assert_eq!(ordered(&[vec![0.0]], &[], None).stops, [0; 0]);
    assert_eq!(ordered(&[vec![0.0, 4.0], vec![4.0, 0.0]], &[Visit::PASSED], Some(1)).stops, [1]);
}
