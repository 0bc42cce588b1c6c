//! Events of a discrete optimum within limits: the times at which an input switches, or a limit
//! becomes active or inactive.
//!
//! A node of the grid represents the cell about it. Between two arcs, an input has cells with
//! values between those of the arcs. The switching time divides these cells so that the impulse is
//! preserved:
//!
//! ```text
//! t = t_L + Σ κ_k (u_k − u_R)/(u_L − u_R)
//! ```
//!
//! with the values `u_L`, `u_R` of the arcs on either side, the end `t_L` of the last cell of the
//! left arc, and the sum over the cells between. If a node is at the switch, its input is the mean
//! of both sides, and `t` is the time of that node. An input with a rate limit has steps in place
//! of cells, and rates in place of values. A cone that is touched within a step has its event
//! there; if it is touched at a node, the event is at the vertex of the parabola through the
//! neighbouring nodes.
//!
//! A row is active if it has a multiplier: at an optimum of the interior-point method the product
//! of multiplier and slack is the barrier parameter, and the smaller of the two is recorded as
//! zero.

use super::settings::ON_EVENTS;
use crate::lie;
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::model::{Model, step};
use crate::optimize::chain::rows::{Cone, What};
use crate::optimize::chain::{Chain, iterate};
use crate::optimize::discrete::candidate::Candidate;

/// State of an input at a node relative to its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Level {
    /// At a level, as a fraction of its limit: 1, −1, or 0 (off).
    At(f64),
    /// Between its limits.
    Within,
}

/// A cell of an input, which begins and ends at times that are fractions of the duration.
#[derive(Clone, Copy, Debug)]
struct Cell {
    from: f64,
    to: f64,
    at: f64,
    value: f64,
    level: Level,
    /// Multiplier of the input's limit, per unit of time, with the input as a fraction of its
    /// limit; zero if the input is between its limits.
    press: f64,
}

/// Event: a time, as a fraction of the duration, and the inputs that switch at it.
#[derive(Clone, Debug)]
pub(super) struct Event {
    pub at: f64,
    /// Number of equal steps of the coarsest grid that surround the event: 0 for a switch, 1 for a
    /// cone touched within a step, 2 for a cone touched at a node.
    pub about: usize,
    pub switches: Vec<Switch>,
}

/// Switch of one input from one level to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Switch {
    pub input: usize,
    /// Levels of the input before and after the switch, as fractions of its limit.
    pub levels: [f64; 2],
    /// Rate of the switching function at the switch, with the input as a fraction of its limit.
    pub slope: f64,
}

/// A discrete optimum with the data from which events are read.
pub(super) struct Read<'a> {
    chain: &'a Chain,
    iterate: Iterate,
    /// Times of the nodes, as fractions of the duration.
    nodes: Vec<f64>,
    /// Multipliers of all rows; zero for inactive rows.
    multipliers: &'a [f64],
    /// Limits of the inputs, scaled by the units of the duration found.
    bounds: Vec<f64>,
    /// Threshold, as a fraction of the limit, below which an input counts as off.
    off: f64,
}

impl<'a> Read<'a> {
    /// Prepares an optimum of the interior-point method for reading its events. `barrier` is its
    /// last barrier parameter.
    pub fn of(chain: &'a Chain, found: &'a Candidate, bounds: &[f64], barrier: f64) -> Self {
        let iterate = iterate(found);
        let (_, multipliers) = &found.multipliers;
        let grid = &chain.model.dynamics.grid;
        let nodes = (0..=grid.steps()).map(|node| grid.time(node) / grid.duration()).collect();
        let grown = iterate.stretch().powi(2);
        let bounds = bounds.iter().map(|bound| bound * grown).collect();
        Self { chain, multipliers, iterate, nodes, bounds, off: barrier.sqrt() }
    }

    fn model(&self) -> &Model {
        &self.chain.model
    }

    /// Returns the active rows of a stage: for each, the index of its group and the quantity that
    /// it bounds.
    fn acting(&self, stage: usize) -> impl Iterator<Item = (usize, &What)> {
        let range = self.chain.rows.range(stage);
        range
            .filter(|row| self.multipliers[*row] > 0.0)
            .map(|row| (self.chain.rows.rows[row].group, &self.chain.rows.rows[row].what))
    }

    /// Returns whether an input has a rate limit.
    fn has_rate(&self, input: usize) -> bool {
        let stage = self.model().first_input();
        self.chain.rows.range(stage).any(
            |row| matches!(&self.chain.rows.rows[row].what, What::InputRate { input: own, .. } if *own == input),
        )
    }

    /// Returns the level of an input at a node.
    pub fn level(&self, input: usize, node: usize) -> Level {
        let side = self.acting(node).find_map(|(_, what)| match what {
            What::InputSize { input: own, sign, .. } if *own == input => Some(*sign),
            _ => None,
        });
        match side {
            Some(sign) => Level::At(sign),
            None if self.iterate.inputs[node][input].abs() <= self.off * self.bounds[input] => Level::At(0.0),
            None => Level::Within,
        }
    }

    /// Returns the multiplier of an input's limit at a node, per unit of time and with the input as
    /// a fraction of its limit.
    fn press(&self, input: usize, node: usize) -> f64 {
        let kick = self.model().kick_weight(node);
        let own = self.chain.rows.range(node).filter(
            |row| matches!(self.chain.rows.rows[*row].what, What::InputSize { input: own, .. } if own == input),
        );
        let grown = self.iterate.stretch().powi(2);
        own.map(|row| self.multipliers[row] * grown / kick).sum()
    }

    /// Returns the level of an input's rate of change on the step after a node, relative to the
    /// rate limit.
    fn change(&self, input: usize, step: usize) -> Level {
        let side = self.acting(step).find_map(|(_, what)| match what {
            What::InputRate { input: own, sign, .. } if *own == input => Some(*sign),
            _ => None,
        });
        match (side, self.level(input, step), self.level(input, step + 1)) {
            (Some(sign), ..) => Level::At(sign),
            (None, Level::At(a), Level::At(b)) if a == b => Level::At(0.0),
            _ => Level::Within,
        }
    }

    /// Returns the possible levels of an input on an arc; for an input with a rate limit, those of
    /// its rate.
    fn levels(&self, input: usize) -> Vec<f64> {
        let one_sided = self.chain.rows.range(self.model().first_input()).any(
            |row| matches!(&self.chain.rows.rows[row].what, What::Push { input: own, .. } if *own == input),
        );
        match (self.has_rate(input), one_sided, &self.model().fuel) {
            (true, ..) => vec![-1.0, 0.0, 1.0],
            (false, true, _) => vec![0.0, 1.0],
            (false, false, Some(_)) => vec![-1.0, 0.0, 1.0],
            (false, false, None) => vec![-1.0, 1.0],
        }
    }

    /// Returns the cells of an input, with values as fractions of its limit.
    fn cells(&self, input: usize) -> Vec<Cell> {
        let (model, nodes) = (self.model(), &self.nodes);
        let value = |node: usize| self.iterate.inputs[node][input] / self.bounds[input];
        if !self.has_rate(input) {
            return self.about_nodes(|node| (value(node), self.level(input, node), self.press(input, node)));
        }
        let slope = |step: usize| (value(step + 1) - value(step)) / (nodes[step + 1] - nodes[step]);
        let steps = model.first_input()..model.steps;
        // If no step reaches the rate limit, the steepest step takes its place.
        let most = steps.clone().map(|step| slope(step).abs()).fold(f64::MIN_POSITIVE, f64::max);
        let cell = |step: usize| Cell {
            from: nodes[step],
            to: nodes[step + 1],
            at: 0.5 * (nodes[step] + nodes[step + 1]),
            value: slope(step) / most,
            level: self.change(input, step),
            press: 0.0,
        };
        steps.map(cell).collect()
    }

    /// Returns the cells about all nodes. `of` returns the value, the level and the multiplier at a
    /// node.
    fn about_nodes(&self, of: impl Fn(usize) -> (f64, Level, f64)) -> Vec<Cell> {
        let nodes = &self.nodes;
        let middle = |step: usize| 0.5 * (nodes[step] + nodes[step + 1]);
        let cell = |node: usize| {
            let (value, level, press) = of(node);
            let from = if node == 0 { nodes[0] } else { middle(node - 1) };
            let to = if node + 1 == nodes.len() { nodes[node] } else { middle(node) };
            Cell { from, to, at: nodes[node], value, level, press }
        };
        (self.model().first_input()..nodes.len()).map(cell).collect()
    }

    /// Returns all events in order of time. Events that are close together are merged.
    pub fn events(&self) -> Vec<Event> {
        let apart = ON_EVENTS.apart;
        let mut events = Vec::new();
        for input in 0..self.model().m {
            // The quadratic pull acts on the value of an input at a node, so an input with a rate
            // limit has none.
            let drawn = !self.has_rate(input);
            let own = switches(&self.cells(input), &self.levels(input)).into_iter();
            events.extend(own.map(|(at, levels, slope)| {
                let switches = if drawn { vec![Switch { input, levels, slope }] } else { Vec::new() };
                Event { at, about: 0, switches }
            }));
        }
        let bare = |at: f64, about: usize| Event { at, about, switches: Vec::new() };
        events.extend(self.touches().into_iter().map(|(_, at, inside)| bare(at, if inside { 1 } else { 2 })));
        events.retain(|event| event.at > apart && event.at < 1.0 - apart);
        events.sort_by(|a, b| a.at.total_cmp(&b.at));
        let merged = events.chunk_by(|a, b| b.at - a.at <= apart).map(|same| Event {
            at: same.iter().map(|event| event.at).sum::<f64>() / same.len() as f64,
            about: same.iter().map(|event| event.about).min().unwrap_or(0),
            switches: same.iter().flat_map(|event| event.switches.clone()).collect(),
        });
        merged.collect()
    }

    /// Returns the points at which the motion touches a cone: the index of the cone's group, the
    /// time, and whether the cone is touched within a step.
    pub fn touches(&self) -> Vec<(usize, f64, bool)> {
        let (model, rows) = (self.model(), &self.chain.rows);
        let mut touched = Vec::new();
        for row in rows.range(1.min(model.steps)) {
            let What::Cone(cone) = &rows.rows[row].what else { continue };
            if cone.is_of_arc() || rows.rows[row].what.is_equation() {
                continue;
            }
            let acts = |stage: usize| {
                self.acting(stage).any(|(_, what)| match what {
                    What::Cone(own) => own.is_same_as(cone),
                    _ => false,
                })
            };
            let stages: Vec<usize> = (0..model.steps).filter(|stage| acts(*stage)).collect();
            for run in stages.chunk_by(|a, b| b - a == 1) {
                if run.len() > ON_EVENTS.cells {
                    continue;
                }
                let highest = run.iter().filter_map(|stage| self.highest(cone, *stage));
                let Some((stage, fraction, _)) = highest.max_by(|a, b| a.2.total_cmp(&b.2)) else { continue };
                let inside = fraction > ON_EVENTS.at_node && fraction < 1.0 - ON_EVENTS.at_node;
                let time = if inside {
                    self.nodes[stage] + fraction * (self.nodes[stage + 1] - self.nodes[stage])
                } else {
                    self.vertex(cone, stage + usize::from(fraction > 0.5))
                };
                touched.push((rows.rows[row].group, time, inside));
            }
        }
        touched
    }

    /// Returns the maximum of a cone's row on the step after a node: the stage, the fraction of the
    /// step, and the row's value.
    fn highest(&self, cone: &Cone, stage: usize) -> Option<(usize, f64, f64)> {
        let (model, state) = (self.model(), &self.iterate.states[stage]);
        let turn = lie::log(&step::drift(model, stage, state).ok()?.1);
        let at = cone.met(model, stage, (&state.attitude, state.stretch), Some(&turn), true)?;
        Some((stage, at.fraction, at.c))
    }

    /// Returns the time near a node at which the parabola through the values of a cone's row at
    /// this node and its neighbours has its maximum.
    fn vertex(&self, cone: &Cone, node: usize) -> f64 {
        let node = node.clamp(1, self.model().steps - 1);
        let value = |node: usize| {
            let state = &self.iterate.states[node];
            cone.value(self.model(), node, (&state.attitude, state.stretch), None)
        };
        let [before, at, after] = [node - 1, node, node + 1].map(value);
        match (before, at, after) {
            (Some(before), Some(at), Some(after)) => {
                vertex([node - 1, node, node + 1].map(|node| self.nodes[node]), [before, at, after])
            }
            _ => self.nodes[node],
        }
    }

    /// Returns the indices of the groups of the constraints that are active at every node between
    /// two times, including the limits of inputs with rate limits.
    pub fn held(&self, from: f64, to: f64) -> Vec<usize> {
        let rows = &self.chain.rows;
        let inside: Vec<usize> = (0..self.model().steps)
            .filter(|node| self.nodes[*node] > from && self.nodes[*node + 1] < to)
            .collect();
        let shapes = |what: &What| match what {
            What::RateNorm { .. } | What::RateAxis { .. } | What::Cone(_) | What::Wheel { .. } => true,
            What::InputSize { input, .. } => self.has_rate(*input),
            _ => false,
        };
        let acts =
            |stage: usize, group: usize| self.acting(stage).any(|(own, what)| own == group && shapes(what));
        let all = |group: &usize| !inside.is_empty() && inside.iter().all(|stage| acts(*stage, *group));
        (0..rows.groups.len()).filter(all).collect()
    }

    /// Returns the level of an input in the middle of an arc, and the level of its rate of change;
    /// zero without a rate limit.
    pub fn middle(&self, input: usize, from: f64, to: f64) -> (Level, Level) {
        let middle = 0.5 * (from + to);
        let after = self.nodes.partition_point(|node| *node <= middle).clamp(1, self.model().steps);
        let nearest =
            if middle - self.nodes[after - 1] < self.nodes[after] - middle { after - 1 } else { after };
        let change = if self.has_rate(input) { self.change(input, after - 1) } else { Level::At(0.0) };
        (self.level(input, nearest.max(self.model().first_input())), change)
    }

    /// Returns the mean of an input between two events, as a fraction of its limit. The input at
    /// the events is extrapolated from the nodes between them.
    pub fn mean(&self, input: usize, from: f64, to: f64) -> f64 {
        let nodes = &self.nodes;
        let near = |at: f64| {
            let after = nodes.partition_point(|node| *node < at).min(self.model().steps);
            if after > 0 && at - nodes[after - 1] < nodes[after] - at { after - 1 } else { after }
        };
        let (first, last) = (near(from), near(to));
        let value = |node: usize| self.iterate.inputs[node][input] / self.bounds[input];
        let continued = |at: usize, inner: usize, next: usize| {
            let slope = (value(next) - value(inner)) / (nodes[next] - nodes[inner]);
            value(inner) + slope * (nodes[at] - nodes[inner])
        };
        let ended = |node: usize| match node {
            _ if last < first + 3 => value(node),
            _ if node == first => continued(first, first + 1, first + 2),
            _ if node == last => continued(last, last - 1, last - 2),
            _ => value(node),
        };
        let piece = |node: usize| 0.5 * (ended(node) + ended(node + 1)) * (nodes[node + 1] - nodes[node]);
        (first..last).map(piece).sum::<f64>() / (nodes[last] - nodes[first])
    }

    /// Returns the value of an input at a time, as a fraction of its limit.
    pub fn value(&self, input: usize, at: f64) -> f64 {
        let after = self.nodes.partition_point(|node| *node <= at).clamp(1, self.model().steps);
        let value = |node: usize| self.iterate.inputs[node][input] / self.bounds[input];
        let part = (at - self.nodes[after - 1]) / (self.nodes[after] - self.nodes[after - 1]);
        value(after - 1) + (value(after) - value(after - 1)) * part.clamp(0.0, 1.0)
    }
}

/// Returns the time at which the parabola through three points has its maximum, limited to the
/// interval from the first to the last point.
fn vertex(times: [f64; 3], values: [f64; 3]) -> f64 {
    let slope = |i: usize| (values[i + 1] - values[i]) / (times[i + 1] - times[i]);
    let bend = (slope(1) - slope(0)) / (times[2] - times[0]);
    let at = 0.5 * (times[0] + times[1]) - 0.5 * slope(0) / bend;
    if bend < 0.0 { at.clamp(times[0], times[2]) } else { times[1] }
}

/// Consecutive cells of one arc, either all at one level or all between limits.
struct Run<'a> {
    cells: &'a [Cell],
    /// Indices of the cells that do not belong to a switch.
    settled: std::ops::Range<usize>,
}

impl Run<'_> {
    /// Returns the value of the input on the arc, extrapolated to the time `at`.
    fn value(&self, first: usize, at: f64) -> f64 {
        let inside = &self.cells[self.settled.clone()];
        if let Level::At(level) = inside[0].level {
            return level;
        }
        if inside.len() == 1 {
            return inside[0].value;
        }
        let [a, b] = if first == 0 {
            [&inside[0], &inside[1]]
        } else {
            [&inside[inside.len() - 2], &inside[inside.len() - 1]]
        };
        a.value + (b.value - a.value) * (at - a.at) / (b.at - a.at)
    }

    /// Returns the rate of the switching function at a switch at the time `at`, from its zero there
    /// and its value at the nearest cell at a limit.
    fn slope(&self, first: usize, at: f64) -> f64 {
        let inside = &self.cells[self.settled.clone()];
        let cell = if first == 0 { &inside[0] } else { &inside[inside.len() - 1] };
        cell.press / (cell.at - at).abs().max(0.5 * (cell.to - cell.from))
    }
}

/// Returns the switches of an input with the possible levels `levels`: for each, the time, the
/// levels before and after, and the rate of the switching function. Pulses that are too short are
/// ignored.
fn switches(cells: &[Cell], levels: &[f64]) -> Vec<(f64, [f64; 2], f64)> {
    let mut runs: Vec<(usize, Run)> = Vec::new();
    let mut first = 0;
    for own in cells.chunk_by(|a, b| a.level == b.level) {
        let last = first + own.len();
        let within = own[0].level == Level::Within;
        // The outermost cells between limits belong to the adjacent switches.
        let begin = usize::from(within && first > 0);
        let end = own.len() - usize::from(within && last < cells.len());
        if !within || own.len() >= ON_EVENTS.cells {
            runs.push((first, Run { cells: own, settled: begin..end }));
        }
        first = last;
    }
    let mut found = Vec::new();
    let pulse = |cells: &[Cell], beside: &Run| {
        pulse(cells, beside, levels).filter(|(width, ..)| *width > ON_EVENTS.apart)
    };
    let (Some((first, opening)), Some((last, closing))) = (runs.first(), runs.last()) else { return found };
    // A pulse shorter than its cells, at the start or the end.
    let before = &cells[..first + opening.settled.start];
    let after = &cells[last + closing.settled.end..];
    if let Some((width, _, levels)) = pulse(before, opening) {
        let at = cells[0].from + width;
        found.push((at, [levels[1], levels[0]], opening.slope(0, at)));
    }
    if let Some((width, _, levels)) = pulse(after, closing) {
        let at = cells[cells.len() - 1].to - width;
        found.push((at, levels, closing.slope(1, at)));
    }
    for pair in runs.windows(2) {
        let ((left_first, left), (right_first, right)) = (&pair[0], &pair[1]);
        let (last, next) = (left_first + left.settled.end - 1, right_first + right.settled.start);
        let bounds = [cells[last].to, cells[next].from];
        let middle = 0.5 * (bounds[0] + bounds[1]);
        let jump = left.value(1, middle) - right.value(0, middle);
        let between = &cells[last + 1..next];
        if jump.abs() < ON_EVENTS.same_level {
            if let Some((width, at, levels)) = pulse(between, left) {
                let [from, to] = [at - 0.5 * width, at + 0.5 * width];
                found.push((from, levels, left.slope(1, from)));
                found.push((to, [levels[1], levels[0]], right.slope(0, to)));
            }
            continue;
        }
        let mut at = bounds[0];
        for cell in between {
            let [l, r] = [left.value(1, cell.at), right.value(0, cell.at)];
            at += (cell.to - cell.from) * (cell.value - r) / (l - r);
        }
        let at = at.clamp(cells[last].from, cells[next].to);
        let slopes = [left.slope(1, at), right.slope(0, at)];
        let known = slopes.iter().filter(|slope| **slope > 0.0).count().max(1);
        let slope = slopes.iter().sum::<f64>() / known as f64;
        found.push((at, [left.value(1, at), right.value(0, at)], slope));
    }
    found
}

/// Returns a pulse that is shorter than its cells, next to an arc at a level: its width, its
/// centre, and the levels of arc and pulse.
fn pulse(cells: &[Cell], beside: &Run, levels: &[f64]) -> Option<(f64, f64, [f64; 2])> {
    let Level::At(base) = beside.cells[0].level else { return None };
    let off = |cell: &Cell| (cell.to - cell.from) * (cell.value - base);
    let impulse: f64 = cells.iter().map(off).sum();
    let beyond = |level: &&f64| (**level - base) * impulse > 0.0;
    let nearest = |a: &&f64, b: &&f64| (*a - base).abs().total_cmp(&(*b - base).abs());
    let level = levels.iter().filter(beyond).min_by(nearest)?;
    let at = cells.iter().map(|cell| off(cell) * cell.at).sum::<f64>() / impulse;
    Some((impulse / (level - base), at, [base, *level]))
}

#[cfg(test)]
mod tests {
    use super::{Cell, Level, switches, vertex};

    /// Returns cells of length 0.1 with the given values. Cells with the values ±1 and 0 are at
    /// these levels.
    fn cells(values: &[f64]) -> Vec<Cell> {
        let cell = |(index, value): (usize, &f64)| {
            let from = 0.1 * index as f64;
            let level = if value.abs() == 1.0 || *value == 0.0 { Level::At(*value) } else { Level::Within };
            Cell { from, to: from + 0.1, at: from + 0.05, value: *value, level, press: value.abs() }
        };
        values.iter().enumerate().map(cell).collect()
    }

    fn times(values: &[f64], levels: &[f64]) -> Vec<f64> {
        switches(&cells(values), levels).into_iter().map(|(at, ..)| at).collect()
    }

    fn are(found: &[f64], expected: &[f64]) {
        let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near && found.len() == expected.len(), "{found:?} {expected:?}");
    }

    #[test]
    fn a_switch_divides_its_cells_so_that_the_impulse_is_kept() {
        are(&times(&[1.0, 1.0, 0.0, 0.0], &[-1.0, 0.0, 1.0]), &[0.2]);
        are(&times(&[1.0, 1.0, 0.25, -1.0, -1.0], &[-1.0, 1.0]), &[0.2 + 0.1 * 1.25 / 2.0]);
        // Two cells between the arcs, the second without impulse.
        are(&times(&[1.0, 1.0, 0.5, 1e-9, 0.0, 0.0], &[-1.0, 0.0, 1.0]), &[0.25 + 1e-10]);
    }

    #[test]
    fn a_pulse_within_a_cell_has_its_impulse_and_its_middle() {
        are(&times(&[0.0, 0.0, -0.4, 0.0, 0.0], &[-1.0, 0.0, 1.0]), &[0.23, 0.27]);
        are(&times(&[0.6, 0.0, 0.0], &[-1.0, 0.0, 1.0]), &[0.06]);
        are(&times(&[1.0, 1.0, 0.6], &[-1.0, 1.0]), &[0.28]);
        // A pulse shorter than the threshold is ignored.
        are(&times(&[0.0, 0.0, -1e-5, 0.0, 0.0], &[-1.0, 0.0, 1.0]), &[]);
    }

    #[test]
    fn what_is_within_its_limits_is_continued_to_its_ends() {
        // The input goes from 1 to a ramp through 0.5 and 0.4, whose value at the switch is 0.6. The
        // cell at the switch has the mean, 0.8.
        are(&times(&[1.0, 1.0, 0.8, 0.5, 0.4, 0.3, 0.3], &[-1.0, 1.0]), &[0.25]);
    }

    #[test]
    fn a_parabola_is_highest_at_its_vertex() {
        let parabola = |t: f64| 1.0 - (t - 0.37).powi(2);
        let times = [0.2, 0.3, 0.6];
        assert!((vertex(times, times.map(parabola)) - 0.37).abs() < 1e-14);
        assert_eq!(vertex(times, times.map(|t| -parabola(t))), 0.3);
    }
}
