//! Lines about the inputs: the name and the peak of each input in the unit of the input, and the
//! peak in percent of its limit.

use super::lines::{Lines, clipped, percent};
use slewkit::maneuver::{Fuel, Motion, Problem, Solution, Trajectory};
use slewkit::mechanics::actuators::{InputLimit, LimitKind};
use slewkit::mechanics::{ActuatorSet, AxisFrame};
use slewkit::numerics::figures::{short, significant};
use slewkit::verify::Margin;
use slewkit_files::identity::Identity;
use slewkit_files::spec::escape;

/// Largest number of inputs that a summary lists individually.
const MOST_TOLD: usize = 6;

/// Largest number of characters of the name of an input.
const NAME: usize = 10;

/// Returns the name of input `index`. It is the name in the spec or, if the spec gives no name, the
/// coordinate axis of the input, or its kind and number.
pub(crate) fn name(problem: &Problem, identity: &Identity, index: usize) -> String {
    if let Some(name) = identity.input(index) {
        return escape(name);
    }
    let actuation = &problem.actuation;
    let (set, number) = match (&actuation.force, index.checked_sub(actuation.first_torque())) {
        (Some(force), _) if actuation.thrusters.is_some() => (force, index),
        (Some(force), None) => (force, index),
        (_, number) => (&actuation.torque, number.unwrap_or(index)),
    };
    match (set.limits().one_sided, &actuation.wheels) {
        (true, _) => format!("T{}", number + 1),
        (_, Some(_)) => format!("W{}", number + 1),
        _ => axis(set, number).map_or_else(|| format!("u{}", number + 1), str::to_string),
    }
}

/// Returns the name of the coordinate axis along which an input acts; `None` if it acts in another
/// direction.
fn axis(set: &ActuatorSet, number: usize) -> Option<&'static str> {
    let axis = set.axes().get(number)?;
    let at = axis.iamax();
    let alone = axis.iter().filter(|value| **value != 0.0).count() == 1 && axis[at] > 0.0;
    alone.then(|| ["x", "y", "z"][at])
}

/// Returns the divisor that converts an input of the plan to the unit in which it is displayed, and
/// this unit. If the spec defines a thruster by its position and its force, the force is displayed.
pub(crate) fn scale(problem: &Problem, identity: &Identity, index: usize) -> (f64, &'static str) {
    if problem.actuation.thrusters.is_some() || index < problem.actuation.first_torque() {
        return (1.0, "N");
    }
    match identity.nozzles.get(index).filter(|_| identity.nozzles.len() == problem.actuation.count()) {
        Some(nozzle) => (nozzle.lever(), "N"),
        None => (1.0, "N·m"),
    }
}

/// Returns the unit of fuel if all inputs have the same kind and price, otherwise an empty text.
pub(crate) fn fuel_unit(problem: &Problem, identity: &Identity) -> &'static str {
    let Some(Fuel { prices, force_prices, .. }) = problem.objective.fuel() else { return "" };
    let ones = |prices: &Option<Vec<f64>>| prices.iter().flatten().all(|price| *price == 1.0);
    let by_force = identity.nozzles.len() == problem.actuation.count();
    let each = by_force && identity.nozzles.iter().all(|nozzle| nozzle.price == 1.0);
    match problem.motion {
        Motion::Attitude if each => "N·s",
        Motion::Attitude if ones(prices) => "N·m·s",
        Motion::RigidBody if problem.actuation.thrusters.is_some() && ones(force_prices) => "N·s",
        _ => "",
    }
}

/// Returns the lines about the peaks of all inputs and of the wheel momenta. `margins` are the
/// margins to all limits that the witness computed.
pub(super) fn told(
    problem: &Problem,
    trajectory: &Trajectory,
    margins: &[Margin],
    identity: &Identity,
) -> Vec<String> {
    let actuation = &problem.actuation;
    let first = actuation.first_torque();
    let mut lines = Vec::new();
    for channel in channels(problem) {
        lines.text(channel.label, channel.told(problem, trajectory, margins, identity));
    }
    if let Some(wheels) = &actuation.wheels {
        let count = wheels.momentum.len();
        let names: Vec<String> = (0..count).map(|wheel| name(problem, identity, first + wheel)).collect();
        let peaks = largest(&trajectory.wheel_momentum, 0..count, count);
        let limits =
            Some(&wheels.momentum_limit[..]).filter(|limits| limits.iter().any(|limit| limit.is_finite()));
        lines.text("momentum", peaks_told(&names, &peaks, limits, "N·m·s"));
    }
    lines
}

/// Returns the groups of inputs of a maneuver, torques before forces.
fn channels(problem: &Problem) -> Vec<Channel<'_>> {
    let actuation = &problem.actuation;
    let first = actuation.first_torque();
    let torques = Channel {
        label: match (&actuation.wheels, actuation.torque.limits().one_sided) {
            (Some(_), _) => "wheels",
            (None, true) => "thrusters",
            (None, false) => "torque",
        },
        set: &actuation.torque,
        range: first..first + actuation.torque.count(),
        of_force: actuation.thrusters.is_some(),
    };
    let force = actuation.force.as_ref().filter(|_| actuation.thrusters.is_none()).map(|set| Channel {
        label: "force",
        set,
        range: 0..set.count(),
        of_force: true,
    });
    [Some(torques), force].into_iter().flatten().collect()
}

/// Input whose peak is the highest in percent of its limit, or the largest input if no input is
/// limited.
pub(crate) struct Busiest {
    /// Kind of the input in the plural, such as "wheels".
    pub kind: &'static str,
    /// Name of the input in the summary.
    pub name: String,
    /// Peak of the input, in the unit `unit`.
    pub peak: f64,
    /// Unit of the peak and of the limit.
    pub unit: &'static str,
    /// Limit of the input, in the unit `unit`; `None` if it has no limit.
    pub limit: Option<f64>,
}

impl Busiest {
    fn of(
        kind: &'static str,
        names: &[String],
        peaks: &[f64],
        limits: Option<&[f64]>,
        unit: &'static str,
    ) -> Option<Self> {
        let part = |index: usize| limits.map_or(peaks[index], |limits| peaks[index] / limits[index]);
        let busiest = (0..peaks.len()).max_by(|a, b| part(*a).total_cmp(&part(*b)).then(b.cmp(a)))?;
        let limit = limits.map(|limits| limits[busiest]).filter(|limit| limit.is_finite());
        Some(Self { kind, name: names[busiest].clone(), peak: peaks[busiest], unit, limit })
    }
}

/// Returns, for the torques or thrusters and then for the forces, the input whose peak is the
/// highest in percent of its limit; finally the wheel with the highest momentum.
pub(crate) fn busiest(problem: &Problem, solution: &Solution, identity: &Identity) -> Vec<Busiest> {
    let (actuation, trajectory) = (&problem.actuation, &solution.trajectory);
    let first = actuation.first_torque();
    let mut found: Vec<Busiest> = channels(problem)
        .into_iter()
        .filter_map(|channel| {
            let (names, peaks, limits, unit) = channel.peaks(problem, trajectory, identity);
            Busiest::of(channel.label, &names, &peaks, limits.as_deref(), unit)
        })
        .collect();
    if let Some(wheels) = &actuation.wheels {
        let count = wheels.momentum.len();
        let names: Vec<String> = (0..count).map(|wheel| name(problem, identity, first + wheel)).collect();
        let peaks = largest(&trajectory.wheel_momentum, 0..count, count);
        found.extend(Busiest::of("wheel momentum", &names, &peaks, Some(&wheels.momentum_limit), "N·m·s"));
    }
    found
}

/// A group of inputs of one kind.
struct Channel<'a> {
    label: &'static str,
    set: &'a ActuatorSet,
    range: std::ops::Range<usize>,
    of_force: bool,
}

impl Channel<'_> {
    /// Returns the names of a group of inputs, their peaks, their limits, and the unit.
    fn peaks(
        &self,
        problem: &Problem,
        trajectory: &Trajectory,
        identity: &Identity,
    ) -> (Vec<String>, Vec<f64>, Option<Vec<f64>>, &'static str) {
        let scales: Vec<(f64, &str)> =
            self.range.clone().map(|input| scale(problem, identity, input)).collect();
        let by = |values: &[f64]| -> Vec<f64> {
            values.iter().zip(&scales).map(|(value, (scale, _))| value / scale).collect()
        };
        let peaks = by(&largest(&trajectory.input, self.range.clone(), trajectory.input_count));
        let names: Vec<String> = self.range.clone().map(|input| name(problem, identity, input)).collect();
        let limits = self.set.limits().size.as_deref().map(by);
        (names, peaks, limits, scales.first().map_or("", |(_, unit)| unit))
    }

    fn told(
        &self,
        problem: &Problem,
        trajectory: &Trajectory,
        margins: &[Margin],
        identity: &Identity,
    ) -> String {
        let (names, peaks, limits, unit) = self.peaks(problem, trajectory, identity);
        let mut text = peaks_told(&names, &peaks, limits.as_deref(), unit);
        if self.set.frame() == AxisFrame::Reference {
            text.push_str(", reference axes");
        }
        // Limits that apply to the group as a whole: on its norm, and on its rate of change.
        let of_whole = |limit: &InputLimit| {
            limit.of_force == self.of_force && matches!(limit.kind, LimitKind::Norm | LimitKind::Rate)
        };
        for limit in problem.actuation.limits().filter(of_whole) {
            let Some(margin) = margins.iter().find(|margin| margin.name == limit.name) else {
                continue;
            };
            let part = percent(1.0 - rounded(margin));
            match limit.kind {
                LimitKind::Norm => {
                    text.push_str(&format!("; norm {part} of {} {}", short(limit.bounds[0]), limit.unit()));
                }
                _ => text.push_str(&format!("; change {part} of its limit")),
            }
        }
        text
    }
}

/// Returns the relative margin to a limit, in which round-off of either sign is replaced by zero.
fn rounded(margin: &Margin) -> f64 {
    if margin.scaled.abs() <= Margin::ROUND_OFF { 0.0 } else { margin.scaled }
}

/// Returns the largest absolute value of each column in `range`. `rows` contains rows of `count`
/// numbers each.
fn largest(rows: &[f64], range: std::ops::Range<usize>, count: usize) -> Vec<f64> {
    let mut peaks = vec![0.0_f64; range.len()];
    for row in rows.chunks_exact(count.max(1)) {
        for (peak, value) in peaks.iter_mut().zip(&row[range.clone()]) {
            *peak = peak.max(value.abs());
        }
    }
    peaks
}

/// Formats peaks with their names, and the highest peak in percent of its limit.
fn peaks_told(names: &[String], peaks: &[f64], limits: Option<&[f64]>, unit: &str) -> String {
    let mut order: Vec<usize> = (0..peaks.len()).collect();
    // Percentages are compared only in the digits that the optimum determines. If several inputs
    // are at their limits, the first of them is therefore chosen on every machine.
    let part = |index: usize| {
        let part = limits.map_or(peaks[index], |limits| peaks[index] / limits[index]);
        (part * 1e9).round() * 1e-9
    };
    let shown = if peaks.len() > MOST_TOLD {
        order.sort_by(|a, b| part(*b).total_cmp(&part(*a)).then(a.cmp(b)));
        &order[..MOST_TOLD / 2]
    } else {
        &order[..]
    };
    let one = |index: &usize| format!("{} {}", clipped(&names[*index], NAME), significant(peaks[*index], 3));
    let mut text = shown.iter().map(one).collect::<Vec<_>>().join("  ");
    text.push_str(&format!(" {unit}"));
    if shown.len() < peaks.len() {
        text.push_str(&format!(" (largest of {})", peaks.len()));
    }
    let Some(limits) = limits else { return text };
    let Some(worst) = (0..peaks.len()).max_by(|a, b| part(*a).total_cmp(&part(*b))) else { return text };
    let alike = limits.windows(2).all(|pair| (pair[0] - pair[1]).abs() <= 1e-12 * pair[0].abs());
    let of = if alike || peaks.len() == 1 {
        short(limits[worst])
    } else {
        format!("{} ({})", short(limits[worst]), clipped(&names[worst], NAME))
    };
    text.push_str(&format!("; {} of {of}", percent(rounded_part(part(worst)))));
    text
}

/// Returns a fraction of a limit; a value that differs from 1 only by round-off is replaced by 1.
fn rounded_part(part: f64) -> f64 {
    if (part - 1.0).abs() <= Margin::ROUND_OFF { 1.0 } else { part }
}
