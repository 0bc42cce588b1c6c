//! The exact order of stops, by dynamic programming over the sets of visited stops.

use super::Stops;

/// Returns the order of the `free` stops, followed by a given last stop, that ends earliest among
/// all orders that keep their windows; `None` if no order keeps them.
pub fn best(stops: &Stops, free: &[usize]) -> Option<Vec<usize>> {
    let count = free.len();
    if count == 0 {
        let order: Vec<usize> = stops.last.into_iter().collect();
        return (stops.followed(&order).1 == 0.0).then_some(order);
    }
    // The earliest end of the hold at a stop, for each set of visited stops and each last stop of
    // the set.
    let mut earliest = vec![f64::INFINITY; count << count];
    let mut before = vec![u8::MAX; count << count];
    let place = |set: usize, last: usize| set * count + last;
    let mut reach = |earliest: &mut [f64], from: Option<(usize, usize)>, to: usize| {
        let (set, at, time) =
            from.map_or((0, 0, 0.0), |(set, last)| (set, free[last], earliest[place(set, last)]));
        if set >> to & 1 == 1 || !time.is_finite() {
            return;
        }
        let (end, late) = stops.visited(at, free[to], time);
        let next = place(set | 1 << to, to);
        if late == 0.0 && end < earliest[next] {
            earliest[next] = end;
            before[next] = from.map_or(u8::MAX, |(_, last)| last as u8);
        }
    };
    (0..count).for_each(|to| reach(&mut earliest, None, to));
    for set in 1..(1_usize << count) {
        for last in (0..count).filter(|last| set >> last & 1 == 1) {
            (0..count).for_each(|to| reach(&mut earliest, Some((set, last)), to));
        }
    }
    let all = (1 << count) - 1;
    let end = |last: &usize| {
        let time = earliest[place(all, *last)];
        match stops.last {
            Some(stop) if time.is_finite() => {
                let (end, late) = stops.visited(free[*last], stop, time);
                if late == 0.0 { end } else { f64::INFINITY }
            }
            _ => time,
        }
    };
    let ended = (0..count).filter(|last| end(last).is_finite());
    let mut last = ended.min_by(|a, b| end(a).total_cmp(&end(b)))?;
    let (mut set, mut order) = (all, Vec::with_capacity(count + 1));
    order.extend(stops.last);
    loop {
        order.push(free[last]);
        let previous = before[place(set, last)];
        set &= !(1 << last);
        if previous == u8::MAX {
            break;
        }
        last = usize::from(previous);
    }
    order.reverse();
    Some(order)
}
