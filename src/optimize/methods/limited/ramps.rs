//! What an input that changes at a limited rate does along a plan: when it holds a limit of its own, and which way it changes between.
//!
//! Nodes tell where it is at a limit; between these are ramps, each for as long as it takes at the limited rate, where the impulse is that
//! of the plan.

/// An input is at its limit within this part of it, and where it would be within a step at the limited rate: effort that is left in the
/// cost rounds off the corners.
const AT_LIMIT: f64 = 1e-3;

/// What an input does from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Course {
    /// It changes, up or down.
    Ramp(f64),
    /// It holds its limit on this side.
    Hold(f64),
}

/// Where an input is at a time.
#[derive(Clone, Copy)]
struct Knot {
    time: f64,
    value: f64,
    /// The node of it.
    node: usize,
}

/// The courses of an input with these values at nodes, as parts of its limit, each from a time on; `rate` is the limit of its rate in the
/// same units.
pub(crate) fn courses(values: &[f64], step: f64, rate: f64) -> Vec<(f64, Course)> {
    let mut knots = knots(values, step, AT_LIMIT.max(step * rate).min(0.5));
    let end = step * (values.len().max(1) - 1) as f64;
    for index in 1..knots.len() {
        let (before, after) = (knots[index - 1], knots[index]);
        let [starts, ends] = [index > 1, index + 1 < knots.len()];
        if before.value == after.value {
            continue;
        }
        let length = (after.value - before.value).abs() / rate;
        // A ramp between limits is where the impulse of its nodes is that of the plan; one that the start or the end cuts off ends or
        // begins there.
        let [from, to] = match (starts, ends) {
            (true, true) if is_limit(before.value) && is_limit(after.value) => {
                let between = &values[before.node..=after.node];
                let impulse = step * between.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).sum::<f64>();
                let [first, last] = [before.node, after.node].map(|node| node as f64 * step);
                let middle =
                    (impulse + before.value * first - after.value * last) / (before.value - after.value);
                [middle - 0.5 * length, middle + 0.5 * length]
            }
            (true, false) => [end - length, end],
            (false, true) => [0.0, length],
            _ => continue,
        };
        knots[index - 1].time = from.clamp(0.0, end);
        knots[index].time = to.clamp(0.0, end);
    }
    let mut courses: Vec<(f64, Course)> = Vec::new();
    for pair in knots.windows(2) {
        let course = if pair[0].value == pair[1].value && is_limit(pair[0].value) {
            Course::Hold(pair[0].value)
        } else {
            Course::Ramp(if pair[1].value < pair[0].value { -1.0 } else { 1.0 })
        };
        // What has no time left before the next is not there.
        if pair[1].time > pair[0].time && courses.last().is_none_or(|(_, last)| *last != course) {
            courses.push((pair[0].time, course));
        }
    }
    if let Some(first) = courses.first_mut() {
        first.0 = 0.0;
    }
    courses
}

fn is_limit(value: f64) -> bool {
    value.abs() == 1.0
}

/// Where an input begins and ends, begins and ends to hold a limit, and turns back between; it is at a limit within `near`.
fn knots(values: &[f64], step: f64, near: f64) -> Vec<Knot> {
    let rounded = |value: f64| if value.abs() > 1.0 - near { value.signum() } else { value };
    let at = |node: usize| Knot { time: node as f64 * step, value: rounded(values[node]), node };
    let mut knots: Vec<Knot> = Vec::new();
    for node in 0..values.len() {
        let knot = at(node);
        let ends = node == 0 || node + 1 == values.len();
        let turns = !ends && {
            let [before, after] = [at(node - 1).value, at(node + 1).value];
            let [rises, goes_on] = [knot.value - before, after - knot.value];
            // It turns back, or begins or ends to hold.
            rises * goes_on < 0.0 || is_limit(knot.value) && (rises == 0.0) != (goes_on == 0.0)
        };
        if ends || turns {
            knots.push(knot);
        }
    }
    knots
}

#[cfg(test)]
mod tests;
