//! Charts of simulated and predicted flights of a plan: the deviations of a spacecraft that differs
//! from the model, with and without feedback, according to linear theory.

mod bands;

use super::boresight::boresights;
use super::charts::{shown, time_axis};
use super::summary::inputs::scale;
use super::words::Table;
use super::{Shown, Subject, line};
use crate::draw::{Axis, Chart, Curve, SkyRing};
use slewkit::mechanics::actuators::LimitKind;
use slewkit::numerics::figures::significant;
use slewkit::optimize::discrete::linear_plan::Matrix6;
use slewkit::uncertainty::chance::Chance;
use slewkit::uncertainty::{Covariance, Radius, Uncertainty};
use slewkit::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_6, TAU};

/// Largest number of nodes at which the pointing error is computed. Covariances vary smoothly along
/// a plan, so few nodes suffice.
const MOST_NODES: usize = 120;

/// Number of covariance ellipses that are drawn along a boresight track.
const RINGS: usize = 12;

/// Number of points with which an ellipse is drawn.
const AROUND: usize = 48;

/// Probabilities for which the chart shows a pointing error, each with its label.
const LEVELS: [(f64, &str); 3] = [(Radius::LEVEL, "99.73 %"), (0.9, "90 %"), (0.5, "50 %")];

/// Size at which an ellipse is visible on the map \[rad\]. All ellipses are enlarged by a power of
/// ten until the largest ellipse has this size.
const SEEN: f64 = 0.02;

/// Largest power of ten, as an exponent, by which ellipses are enlarged.
const MOST_ENLARGED: i32 = 3;

/// Returns the covariances of the closed loop and of the open loop, if they were computed, each
/// with the name of its loop.
fn loops<'a>(subject: &'a Subject) -> Vec<(&'static str, &'a Covariance)> {
    let Some(beside) = subject.beside() else { return Vec::new() };
    let closed = beside.closed.as_ref().map(|covariance| ("closed loop", covariance));
    let open = beside.open.as_ref().map(|covariance| ("open loop", covariance));
    closed.into_iter().chain(open).collect()
}

/// Returns the indices of at most `most + 1` of `count` nodes. They are evenly spread and include
/// the first and the last node.
fn some_nodes(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let last = count.saturating_sub(1);
    let parts = last.min(most).max(1);
    (0..=parts).map(move |part| part * last / parts).take(count)
}

/// Returns the covariance of the attitude in body axes \[rad²\], the upper left block of `state`.
fn of_attitude(state: &Matrix6) -> Matrix3 {
    state.fixed_view::<3, 3>(0, 0).into_owned()
}

/// Returns the charts of pointing errors, corrections and simulated flights.
pub(super) fn charts(subject: &Subject) -> Vec<Shown> {
    let linear = pointing(subject).into_iter().chain(corrections(subject));
    linear.chain(bands::charts(subject)).collect()
}

/// Returns the chart of the pointing error of each boresight, relative to its planned direction,
/// for fixed probabilities.
fn pointing(subject: &Subject) -> Option<Shown> {
    let (beside, loops) = (subject.beside()?, loops(subject));
    let boresights = boresights(subject);
    // For one boresight all probabilities are shown, for several boresights only the largest one.
    let levels = if boresights.len() == 1 { &LEVELS[..] } else { &LEVELS[..1] };
    let nodes: Vec<usize> = some_nodes(beside.linear.count() + 1, MOST_NODES).collect();
    let times: Vec<f64> = nodes.iter().map(|node| beside.linear.times()[*node]).collect();
    let mut curves: Vec<Curve> = Vec::new();
    for boresight in &boresights {
        for (name, covariance) in &loops {
            let radii: Vec<Radius> = nodes
                .iter()
                .map(|node| Radius::of(&boresight.vector, &of_attitude(&covariance.states[*node])))
                .collect();
            for (level, called) in levels {
                let name = if boresights.len() == 1 {
                    format!("{called}, {name}")
                } else {
                    format!("{name}\n{}", boresight.name)
                };
                let values = radii.iter().map(|radius| radius.at(*level).to_degrees());
                curves.push(line(name, curves.len(), &times, values));
            }
        }
    }
    if curves.is_empty() {
        return None;
    }
    let axis = Axis::logarithmic("angle from the plan, deg");
    let mut chart = Chart::new("Pointing errors", time_axis(), axis, curves);
    chart.subtitle = match &boresights[..] {
        [one] => format!("{}: within this angle with the stated probability", one.name),
        _ => format!("within this angle with {}", LEVELS[0].1),
    };
    Some(shown("pointing", chart, "of the linear motion near the plan"))
}

/// Returns the chart of three standard deviations of the correction of each input, and of the
/// margin of the planned input to its limit.
fn corrections(subject: &Subject) -> Option<Shown> {
    let beside = subject.beside()?;
    let closed = beside.closed.as_ref().filter(|closed| !closed.inputs.is_empty())?;
    let problem = subject.problem;
    let first = problem.actuation.first_torque();
    let count = closed.inputs[0].len();
    let times = &beside.linear.times()[..closed.inputs.len()];
    let unit_of = |input: usize| scale(problem, subject.identity, first + input);
    let deviation = |step: usize, input: usize| 3.0 * closed.inputs[step][input] / unit_of(input).0;
    let mut curves: Vec<Curve> = (0..count)
        .map(|input| {
            let values = (0..times.len()).map(|step| deviation(step, input));
            line(format!("3σ of {}", subject.input_name(first + input)), input, times, values)
        })
        .collect();
    let all = curves.iter().flat_map(|curve| curve.shape.points()).map(|point| point.1);
    // Where the planned input is at its limit, the curve follows the lower edge, because a
    // logarithmic axis does not contain zero.
    let least = 0.1 * all.filter(|value| *value > 0.0).fold(f64::INFINITY, f64::min);
    if !least.is_finite() {
        return None;
    }
    let mut at_the_bottom = false;
    for limit in problem.actuation.limits().filter(|limit| !limit.of_force) {
        let left = |name: String, bound: f64, of: &dyn Fn(usize) -> f64| -> (String, Vec<f64>) {
            (name, (0..times.len()).map(|step| bound - of(step)).collect())
        };
        let found: Vec<(String, Vec<f64>)> = match limit.kind {
            LimitKind::Size => (0..count)
                .zip(limit.bounds)
                .filter(|(_, bound)| bound.is_finite())
                .map(|(input, bound)| {
                    let factor = unit_of(input).0;
                    let name = format!("left to {}", subject.input_name(first + input));
                    let of = |step: usize| beside.linear.inputs(step)[input].abs() / factor;
                    left(name, bound / factor, &of)
                })
                .collect(),
            LimitKind::Norm => {
                let of = |step: usize| limit.set.output(beside.linear.inputs(step)).norm();
                limit.bounds.iter().map(|bound| left("left by the norm".into(), *bound, &of)).collect()
            }
            LimitKind::Rate | LimitKind::WheelMomentum => Vec::new(),
        };
        for (name, values) in found {
            at_the_bottom |= values.iter().any(|value| *value < least);
            // Unlike `f64::max`, the comparison preserves NaN.
            let values = values.into_iter().map(|value| if value < least { least } else { value });
            curves.push(line(name, curves.len(), times, values));
        }
    }
    let limited = curves.len() > count;
    let axis = Axis::logarithmic(format!("input, {}", unit_of(0).1));
    let mut chart = Chart::new("Corrections by the gains", time_axis(), axis, curves);
    chart.subtitle = match limited {
        true => "three standard deviations, and the room below the limits".into(),
        false => "three standard deviations; the inputs have no limits".into(),
    };
    let remark = if at_the_bottom { "the line is at the bottom where a limit leaves no room" } else { "" };
    Some(shown("corrections", chart, remark))
}

/// Returns the ellipses along the boresight tracks that contain the pointing error with a
/// probability of 99.73 %, and the factor by which they are drawn enlarged.
pub(super) fn rings(subject: &Subject) -> (Vec<SkyRing>, i32) {
    let Some(beside) = subject.beside() else { return (Vec::new(), 1) };
    // The radius, in standard deviations, of the circle that contains a two-dimensional normal
    // vector with probability `Radius::LEVEL`.
    let reach = (-2.0 * (1.0 - Radius::LEVEL).ln()).sqrt();
    let mut found = Vec::new();
    for (style, boresight) in boresights(subject).iter().enumerate() {
        for (name, covariance) in loops(subject) {
            for node in some_nodes(covariance.states.len(), RINGS) {
                let axes =
                    axes(&boresight.vector, &of_attitude(&covariance.states[node])).map(|axis| axis * reach);
                let size = axes[0].norm().max(axes[1].norm());
                // Linear theory is not valid for larger ellipses.
                if size > 0.0 && size <= FRAC_PI_6 {
                    let attitude = beside.linear.node(node).0;
                    found.push((style, name, attitude * boresight.vector, axes.map(|axis| attitude * axis)));
                }
            }
        }
    }
    let size = |axes: &[Vector3; 2]| axes[0].norm().max(axes[1].norm());
    let largest = found.iter().map(|(.., axes)| size(axes)).fold(0.0, f64::max);
    let powers = 0..=MOST_ENLARGED;
    let power = powers.clone().find(|power| largest * 10_f64.powi(*power) >= SEEN).unwrap_or(MOST_ENLARGED);
    let factor = 10_i32.pow(power.unsigned_abs());
    let ring = |(style, name, middle, axes): &(usize, &'static str, Vector3, [Vector3; 2])| {
        let at = |part: usize| {
            let (sin, cos) = (TAU * part as f64 / AROUND as f64).sin_cos();
            let aside = f64::from(factor) * (cos * axes[0] + sin * axes[1]);
            let angle = aside.norm();
            let along = if angle > 0.0 { angle.sin() / angle } else { 1.0 };
            angle.cos() * middle + along * aside
        };
        SkyRing { style: *style, filled: *name == "closed loop", points: (0..AROUND).map(at).collect() }
    };
    (found.iter().map(ring).collect(), factor)
}

/// Describes the ellipses on the map, as a remark below it.
pub(super) fn told_of_rings(rings: &[SkyRing], factor: i32) -> String {
    let what = match (rings.iter().any(|ring| ring.filled), rings.iter().any(|ring| !ring.filled)) {
        (true, true) => "99.73 % ellipses: filled under the gains, outlined without",
        (true, false) => "99.73 % ellipses, under the gains",
        (false, true) => "99.73 % ellipses, without gains",
        (false, false) => return String::new(),
    };
    if factor > 1 { format!("{what}; enlarged {factor} times") } else { what.into() }
}

/// Returns the two semi-axes of the one-sigma ellipse of a boresight, in body axes \[rad\].
fn axes(boresight: &Vector3, covariance: &Matrix3) -> [Vector3; 2] {
    let lever = slewkit::lie::hat(boresight);
    let eigen = (lever * covariance * lever.transpose()).symmetric_eigen();
    let mut all = [0, 1, 2].map(|column| {
        let sigma = eigen.eigenvalues[column].max(0.0).sqrt();
        sigma * eigen.eigenvectors.column(column)
    });
    all.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    [all[0], all[1]]
}

/// Returns the table that compares the terminal errors of the open loop and the closed loop.
pub(super) fn table(subject: &Subject) -> Option<Table> {
    let beside = subject.beside()?;
    let uncertainty = subject.closed_loop()?.uncertainty.as_ref()?;
    let mut loops = loops(subject);
    loops.reverse();
    if loops.is_empty() {
        return None;
    }
    let head = [""].into_iter().chain(loops.iter().map(|(name, _)| *name)).collect();
    let row = |label: String, cell: &dyn Fn(&Covariance) -> String| {
        let cells = loops.iter().map(|(_, covariance)| cell(covariance));
        [label].into_iter().chain(cells).collect::<Vec<String>>()
    };
    let mut rows = Vec::new();
    for (index, label) in
        ["attitude at the end about x, y, z: 1σ, deg", "rate at the end: 1σ, deg/s"].into_iter().enumerate()
    {
        let cell = |covariance: &Covariance| {
            let sigma = covariance.end_sigma();
            let three = [0, 1, 2].map(|axis| significant(sigma[3 * index + axis].to_degrees(), 3));
            three.join(", ")
        };
        rows.push(row(label.into(), &cell));
    }
    for boresight in boresights(subject) {
        let cell = |covariance: &Covariance| {
            let radius = Radius::of(&boresight.vector, &of_attitude(&covariance.end));
            significant(radius.within.to_degrees(), 3)
        };
        rows.push(row(
            format!("{}: pointing error at the end with probability 99.73 %, deg", boresight.name),
            &cell,
        ));
    }
    let chances: Vec<Vec<Chance>> = loops
        .iter()
        .map(|(_, covariance)| {
            let mut chances = Chance::of_constraints(subject.problem, &beside.linear, covariance);
            chances.extend(Chance::of_limits(subject.problem, &beside.linear, covariance));
            chances
        })
        .collect();
    let longest = chances.iter().max_by_key(|chances| chances.len())?;
    for (index, chance) in longest.iter().enumerate() {
        let when = |of_motion: bool| if of_motion { " over the motion" } else { "" };
        let asked = subject.closed_loop()?.asked(&chance.name).map_or(String::new(), |asked| {
            format!(", requested at most {}{}", significant(asked.at_most, 2), when(asked.of_motion))
        });
        // Without corrections, the open loop has no probability that corrections exceed a limit.
        let cell = |chances: &Vec<Chance>| {
            let Some(chance) = chances.get(index) else { return "–".into() };
            let at = significant(beside.linear.times()[chance.worst().node], 3);
            format!("{} at {at} s", significant(chance.largest(), 2))
        };
        let label = format!("{}: chance of a violation, at the worst instant{asked}", chance.name);
        rows.push([label].into_iter().chain(chances.iter().map(cell)).collect());
    }
    for (first, label) in [(0, "attitude"), (3, "rate")] {
        let cell = |covariance: &Covariance| largest_share(covariance, uncertainty, first);
        rows.push(row(format!("most of the variance of the {label} at the end"), &cell));
    }
    let remark = "To first order in the uncertainty. The chance holds for one instant; errors of neighbouring \
     instants are correlated.";
    Some(Table { title: "In flight", head, rows, remark })
}

/// Returns the uncertain parameter that contributes most to the sum of three variances at the end.
/// The variances are in the rows `first` to `first + 2` of the covariance.
fn largest_share(covariance: &Covariance, uncertainty: &Uncertainty, first: usize) -> String {
    let all: f64 = (first..first + 3).map(|row| covariance.end[(row, row)]).sum();
    let squares =
        covariance.end_by_parameter.iter().map(|column| column.fixed_rows::<3>(first).norm_squared());
    let parts = squares
        .zip(&uncertainty.parameters)
        .map(|(square, (name, _, sigma))| (name.as_str(), square * sigma * sigma / all));
    let largest = parts.filter(|(_, part)| *part > 0.0).max_by(|a, b| a.1.total_cmp(&b.1));
    largest.map_or("—".into(), |(name, part)| format!("{name}, {} %", significant(100.0 * part, 2)))
}

#[cfg(test)]
mod tests;
