//! The firings of thrusters: the start and length of each firing, and their total impulse.

use super::inputs;
use slewkit::maneuver::{Problem, Solution};
use slewkit::numerics::figures::{short, significant};
use slewkit::{Vector3, lie};
use slewkit_files::identity::Identity;

/// Fraction of the largest force of a thruster below which the thruster counts as off.
const OFF: f64 = 0.01;

/// An interval in which one thruster is on without interruption.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Firing {
    /// Index of the thruster that fires.
    pub input: usize,
    /// The start of the firing \[s\].
    pub from: f64,
    /// The end of the firing \[s\].
    pub to: f64,
}

impl Firing {
    /// Returns the length of the firing \[s\].
    pub fn length(&self) -> f64 {
        self.to - self.from
    }
}

/// Returns all firings, sorted by thruster and time. The list is empty unless the inputs are
/// one-sided.
///
/// The firings of a plan that consists of arcs are exact, because the switching times are nodes of
/// its grid.
pub(crate) fn firings(problem: &Problem, solution: &Solution) -> Vec<Firing> {
    let set = &problem.actuation.torque;
    let Some(sizes) = set.limits().size.as_ref().filter(|_| set.limits().one_sided) else {
        return Vec::new();
    };
    let trajectory = &solution.trajectory;
    let first = problem.actuation.first_torque();
    let mut found = Vec::new();
    for (number, size) in sizes.iter().enumerate() {
        let input = first + number;
        let rows = trajectory.input.iter().skip(input).step_by(trajectory.input_count.max(1));
        let mut open: Option<Firing> = None;
        for ((from, to), value) in stretches(problem, &trajectory.time).into_iter().zip(rows) {
            let on = *value > OFF * size;
            match &mut open {
                Some(firing) if on => firing.to = to,
                Some(firing) => {
                    found.push(*firing);
                    open = None;
                }
                None if on => open = Some(Firing { input, from, to }),
                None => {}
            }
        }
        found.extend(open);
    }
    found
}

/// Returns the time interval in which each row of inputs acts \[s\]. It is a step if inputs are
/// held over steps, otherwise the interval around the node of the row.
fn stretches(problem: &Problem, time: &[f64]) -> Vec<(f64, f64)> {
    if problem.switches() && !problem.is_shaped() {
        return time.windows(2).map(|ends| (ends[0], ends[1])).collect();
    }
    let middle = |a: usize, b: usize| 0.5 * (time[a] + time[b]);
    let last = time.len().saturating_sub(1);
    (0..time.len())
        .map(|node| (middle(node.saturating_sub(1), node), middle(node, (node + 1).min(last))))
        .collect()
}

/// Returns the net impulse of all thrusters in reference axes, `∫ R Σ f d dt`, and the sum of the
/// impulses of the single thrusters, both in N·s. Returns `None` if the forces are unknown.
pub(crate) fn impulse(problem: &Problem, solution: &Solution, identity: &Identity) -> Option<(Vector3, f64)> {
    let trajectory = &solution.trajectory;
    let count = problem.actuation.count();
    let directions: Vec<Vector3> = match (&problem.actuation.thrusters, &problem.actuation.force) {
        (Some(_), Some(force)) => force.axes().to_vec(),
        _ if identity.nozzles.len() == count => {
            identity.nozzles.iter().map(|nozzle| nozzle.direction).collect()
        }
        _ => return None,
    };
    let (mut net, mut all) = (Vector3::zeros(), 0.0);
    for (row, (from, to)) in stretches(problem, &trajectory.time).into_iter().enumerate() {
        let Some(inputs) = trajectory.input.get(row * count..(row + 1) * count) else { break };
        let forces =
            inputs.iter().enumerate().map(|(input, value)| value / inputs::scale(problem, identity, input).0);
        let pushed: Vector3 =
            forces.clone().zip(&directions).map(|(force, direction)| direction * force).sum();
        // The body rotates during the step, so the mean of the attitudes at its ends is used.
        let at = |node: usize| {
            let node = node.min(trajectory.quaternion.len() - 1);
            lie::rotation_from_quaternion(&trajectory.quaternion[node]) * pushed
        };
        let turned =
            if problem.switches() && !problem.is_shaped() { 0.5 * (at(row) + at(row + 1)) } else { at(row) };
        net += turned * (to - from);
        all += forces.sum::<f64>() * (to - from);
    }
    Some((net, all))
}

/// Fraction of the sum of all impulses below which a component of the net impulse counts as
/// round-off.
const NONE: f64 = 1e-9;

/// Formats the components of the net impulse with their unit. `all` is the sum of the impulses of
/// the single thrusters \[N·s\].
fn vector(vector: &Vector3, all: f64) -> String {
    let part = |part: f64| if part.abs() <= NONE * all { "0".into() } else { significant(part, 3) };
    let [x, y, z] = [vector.x, vector.y, vector.z].map(part);
    format!("({x}, {y}, {z}) N·s")
}

/// Describes the firings in one or two lines; an empty list if the maneuver has no thrusters.
pub(crate) fn told(problem: &Problem, solution: &Solution, identity: &Identity) -> Vec<String> {
    let found = firings(problem, solution);
    if found.is_empty() {
        return Vec::new();
    }
    let shortest = found.iter().min_by(|a, b| a.length().total_cmp(&b.length()));
    let shortest = shortest.map_or(String::new(), |firing| {
        let name = inputs::name(problem, identity, firing.input);
        format!("the shortest {} s ({name})", short(firing.length()))
    });
    let plural = if found.len() == 1 { "firing" } else { "firings" };
    let mut lines = vec![format!("{} {plural}, {shortest}", found.len())];
    if let Some((net, all)) = impulse(problem, solution, identity) {
        lines.push(format!("push {} net of {} N·s", vector(&net, all), significant(all, 3)));
    }
    lines
}

/// Returns one line for each thruster with its on-times, such as `T4 on 0.000–2.653 s, 5.1–6 s`.
pub(crate) fn times(problem: &Problem, solution: &Solution, identity: &Identity) -> Vec<String> {
    let found = firings(problem, solution);
    let of = found.chunk_by(|a, b| a.input == b.input);
    of.map(|firings| {
        let name = inputs::name(problem, identity, firings[0].input);
        format!("{name} on {} s", listed(firings).join(", "))
    })
    .collect()
}

/// Formats the start and the end of each firing \[s\].
pub(crate) fn listed(firings: &[Firing]) -> Vec<String> {
    firings.iter().map(|firing| format!("{:.3}–{:.3}", firing.from, firing.to)).collect()
}
