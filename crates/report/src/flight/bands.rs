//! Charts of simulated flights: percentiles of the pointing errors and of the commanded torques
//! over many cases.
//!
//! The charts compare these percentiles with linear theory. The number of cases is small enough for
//! a simulation while the page is made. The seed is fixed, so that the page is reproducible.

use super::{LEVELS, some_nodes};
use crate::boresight::boresights;
use crate::charts::{shown, time_axis, within};
use crate::draw::{Axis, Chart, Curve, Shape};
use crate::summary::inputs::scale;
use crate::{Shown, Subject, line};
use slewkit::Vector3;
use slewkit::closed_loop::{Flown, Moment, quantile};
use slewkit::lie;
use slewkit::maneuver::constraint::angle_between;
use slewkit::mechanics::actuators::LimitKind;
use slewkit::uncertainty::Radius;
use slewkit_files::flown::Runs;

/// Number of simulated cases. Of 1000 cases, two or three are expected outside of the 99.73 %
/// range.
const CASES: usize = 1000;

/// Largest number of simulated steps of all cases together; their simulation takes some seconds.
/// For long plans it reduces the number of cases.
const MOST_STEPS: usize = 2_000_000;

/// Smallest number of simulated cases.
const FEWEST: usize = 100;

/// The largest number of nodes at which percentiles of pointing errors are computed.
const NODES: usize = 24;

/// The largest number of steps at which percentiles of commands are computed.
const STEPS: usize = 240;

/// Seed of the random numbers, equal to the default seed of `slew fly`.
const SEED: u64 = 1;

/// Pointing errors and commands of all cases at selected nodes and steps.
struct Bands {
    name: &'static str,
    cases: usize,
    nodes: Vec<usize>,
    steps: Vec<usize>,
    /// Angles between the planned and the simulated direction \[rad\], for each boresight and node,
    /// sorted in increasing order over the cases.
    angles: Vec<Vec<Vec<f64>>>,
    /// Commands in SI units for each input and step, sorted in increasing order over the cases.
    commands: Vec<Vec<Vec<f64>>>,
}

/// Returns the charts of simulated flights; an empty list if the spec states no uncertainty.
pub(super) fn charts(subject: &Subject) -> Vec<Shown> {
    let Some(bands) = flown(subject) else { return Vec::new() };
    pointing(subject, &bands).into_iter().chain(commands(subject, &bands)).collect()
}

/// Simulates flights of the plan, in closed loop if the plan has gains, otherwise in open loop.
/// Returns `None` if the spec states no uncertainty.
fn flown(subject: &Subject) -> Option<Bands> {
    let (beside, closed_loop) = (subject.beside()?, subject.closed_loop()?);
    let uncertainty = closed_loop.uncertainty.as_ref()?;
    let closed = beside.gains.is_some();
    let (problem, seed) = (subject.problem, SEED);
    let runs = Runs { problem, closed_loop, uncertainty, beside, marks: &[], seed, threads: None };
    let count = beside.linear.count();
    let nodes: Vec<usize> = some_nodes(count + 1, NODES).collect();
    let steps: Vec<usize> = some_nodes(count, STEPS).collect();
    let boresights: Vec<Vector3> = boresights(subject).iter().map(|boresight| boresight.vector).collect();
    let told = |_: Flown, moments: Vec<Moment>| {
        let angle = |boresight: &Vector3, node: usize| {
            let turned = lie::exp(&moments[node].beside.fixed_rows::<3>(0).into_owned());
            angle_between(&(turned * boresight), boresight)
        };
        let of = |boresight: &Vector3| nodes.iter().map(|node| angle(boresight, *node)).collect::<Vec<_>>();
        let angles: Vec<Vec<f64>> = boresights.iter().map(of).collect();
        let commands: Vec<Vec<f64>> = steps.iter().map(|step| moments[*step].commanded.clone()).collect();
        (angles, commands)
    };
    let cases = (MOST_STEPS / count.max(1)).clamp(FEWEST, CASES);
    let flown: Vec<_> = runs.campaign(closed).trace_all(0, cases, told).into_iter().flatten().collect();
    let inputs = problem.actuation.torque.count();
    let sorted = |values: &mut dyn Iterator<Item = f64>| {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let angles = |boresight: usize| {
        let at = |node: usize| sorted(&mut flown.iter().map(|(angles, _)| angles[boresight][node]));
        (0..nodes.len()).map(at).collect()
    };
    let commands = |input: usize| {
        let at = |step: usize| sorted(&mut flown.iter().map(|(_, commands)| commands[step][input]));
        (0..steps.len()).map(at).collect()
    };
    if flown.is_empty() {
        return None;
    }
    let angles = (0..boresights.len()).map(angles).collect();
    let commands = (0..inputs).map(commands).collect();
    Some(Bands { name: Runs::name(closed), cases: flown.len(), angles, commands, nodes, steps })
}

/// Returns the chart of the pointing error of each boresight. Marks show percentiles of the
/// simulated cases, and lines show linear theory.
fn pointing(subject: &Subject, bands: &Bands) -> Option<Shown> {
    let beside = subject.beside()?;
    let covariance = beside.closed.as_ref().or(beside.open.as_ref())?;
    let boresights = boresights(subject);
    let levels = if boresights.len() == 1 { &LEVELS[..] } else { &LEVELS[..1] };
    let times: Vec<f64> = bands.nodes.iter().map(|node| beside.linear.times()[*node]).collect();
    let (mut marked, mut lines) = (Vec::new(), Vec::new());
    for (boresight, angles) in boresights.iter().zip(&bands.angles) {
        let radii: Vec<Radius> = bands
            .nodes
            .iter()
            .map(|node| Radius::of(&boresight.vector, &super::of_attitude(&covariance.states[*node])))
            .collect();
        for (level, called) in levels {
            let style = marked.len();
            let called = if boresights.len() == 1 { *called } else { &boresight.name };
            let found = angles.iter().map(|angles| quantile(angles, *level).to_degrees());
            let points: Vec<(f64, f64)> = times.iter().copied().zip(found).collect();
            marked.push(Curve { name: format!("{called}, flown"), style, shape: Shape::Marked(points) });
            let values = radii.iter().map(|radius| radius.at(*level).to_degrees());
            lines.push(line(format!("{called}, linear"), style, &times, values));
        }
    }
    let curves: Vec<Curve> = marked.into_iter().chain(lines).collect();
    let axis = Axis::logarithmic("angle from the plan, deg");
    let mut chart = Chart::new("Pointing errors in flight", time_axis(), axis, curves);
    let of = match &boresights[..] {
        [one] => one.name.clone(),
        _ => LEVELS[0].1.into(),
    };
    chart.subtitle = format!("{of}: percentiles of {} cases, {}", bands.cases, bands.name);
    Some(shown("flown_pointing", chart, "marks: flights, as in slew fly; lines: linear theory"))
}

/// Returns the chart of the range that contains 99.73 % of the commands to each input.
fn commands(subject: &Subject, bands: &Bands) -> Option<Shown> {
    let (problem, linear) = (subject.problem, &subject.beside()?.linear);
    let first = problem.actuation.first_torque();
    let times: Vec<f64> = bands.steps.iter().map(|step| linear.times()[*step]).collect();
    let outside = 0.5 * (1.0 - Radius::LEVEL);
    let (mut lines, mut areas) = (Vec::new(), Vec::new());
    for (input, commands) in bands.commands.iter().enumerate() {
        let unit = scale(problem, subject.identity, first + input).0;
        let name = subject.input_name(first + input);
        let planned = bands.steps.iter().map(|step| linear.inputs(*step)[input] / unit);
        lines.push(line(name.clone(), input, &times, planned));
        let at = |values: &Vec<f64>, level: f64| quantile(values, level) / unit;
        let ends = commands.iter().map(|values| (at(values, outside), at(values, 1.0 - outside)));
        let points = times.iter().zip(ends).map(|(time, (low, high))| (*time, low, high)).collect();
        areas.push(Curve { name: format!("{name}: 99.73 %"), style: input, shape: Shape::Band(points) });
    }
    let unit = scale(problem, subject.identity, first).1;
    let curves: Vec<Curve> = lines.into_iter().chain(areas).collect();
    let mut chart =
        Chart::new("Commands in flight", time_axis(), Axis::linear(format!("input, {unit}")), curves);
    let sizes = problem.actuation.limits().filter(|limit| !limit.of_force && limit.kind == LimitKind::Size);
    let bounds: Vec<(&str, Vec<f64>)> = sizes
        .map(|limit| {
            let scaled =
                |(index, bound): (usize, &f64)| bound / scale(problem, subject.identity, first + index).0;
            (limit.name, limit.bounds.iter().enumerate().map(scaled).collect())
        })
        .collect();
    let bounds: Vec<(&str, &[f64])> = bounds.iter().map(|(name, bounds)| (*name, &bounds[..])).collect();
    within(&mut chart, &bounds, unit);
    let about = format!("the plan, and the range of 99.73 % of {} cases, {}", bands.cases, bands.name);
    chart.subtitle = if chart.subtitle.is_empty() { about } else { format!("{about}; {}", chart.subtitle) };
    Some(shown("flown_commands", chart, ""))
}
