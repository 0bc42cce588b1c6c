//! Charts over time: inputs, angular rates, wheel momenta, positions, clearances and costates, with
//! their limits and the times at which the limits are active.

use super::summary::firings::{self, firings};
use super::summary::inputs::scale;
use super::{Shown, Subject, arcs, line};
use crate::draw::{Axis, Chart, Curve, Gantt, Level, Picture, Span};
use slewkit::Vector3;
use slewkit::maneuver::{Motion, Rule};
use slewkit::mechanics::actuators::{InputLimit, LimitKind};
use slewkit::numerics::figures::short;

/// Largest ratio of a limit to the largest value of the curves for which the limit is drawn as a
/// line. A higher limit is stated in the subtitle, because its line would make the curves look
/// flat.
const FAR: f64 = 3.0;

const AXES: [&str; 3] = ["x", "y", "z"];

pub(super) fn time_axis() -> Axis {
    Axis::linear("time, s")
}

pub(super) fn shown(key: &'static str, chart: Chart, remark: impl Into<String>) -> Shown {
    Shown { key, picture: Picture::Chart(chart), remark: remark.into() }
}

/// Returns the charts of angular rates, wheels, positions and clearances.
pub(super) fn of_motion(subject: &Subject) -> Vec<Shown> {
    let mut all = vec![rates(subject)];
    all.extend(wheels(subject));
    all.extend(translation(subject));
    all.extend(clearance(subject));
    all
}

/// Returns the chart of the torques and, if the maneuver has force inputs, of the forces.
pub(super) fn inputs(subject: &Subject) -> Vec<Shown> {
    let (problem, trajectory) = (subject.problem, subject.trajectory());
    let (actuation, count) = (&problem.actuation, trajectory.input_count);
    let forces = actuation.force.as_ref().map_or(0, |set| set.count());
    let channel = |of_force: bool| {
        let range = if of_force { 0..forces } else { forces..count };
        let several = range.len();
        let rows = |index: usize| (0..).step_by(count.max(1)).map(move |row| row + index);
        let mut curves: Vec<Curve> = range
            .clone()
            .enumerate()
            .map(|(style, index)| {
                let (scale, _) = scale(problem, subject.identity, index);
                let values = rows(index).map_while(|at| trajectory.input.get(at).map(|value| value / scale));
                subject.input_line(subject.input_name(index), style, values.collect())
            })
            .collect();
        let limits: Vec<InputLimit> = actuation.limits().filter(|limit| limit.of_force == of_force).collect();
        if let Some(norm) = limits.iter().find(|limit| limit.kind == LimitKind::Norm) {
            let output = |row: usize| norm.set.output(&trajectory.inputs(row)[norm.first..]);
            let rows = trajectory.input.len() / count.max(1);
            // If only the means of neighbouring rows act on the body, the norm of these means is
            // drawn.
            let means = problem.objective.switches() && rows == trajectory.time.len();
            let size =
                |row: usize| if means { 0.5 * (output(row) + output(row + 1)) } else { output(row) }.norm();
            let values = (0..rows.saturating_sub(usize::from(means))).map(size);
            curves.push(subject.input_line("norm", several, values.collect()));
        }
        let bounds = limits.iter().filter(|limit| matches!(limit.kind, LimitKind::Size | LimitKind::Norm));
        let bounds: Vec<(&str, Vec<f64>)> = bounds
            .map(|limit| {
                let scaled = |(index, bound): (usize, &f64)| match limit.kind {
                    LimitKind::Size => bound / scale(problem, subject.identity, limit.first + index).0,
                    _ => *bound,
                };
                let told_by_force = !limit.of_force && scale(problem, subject.identity, limit.first).1 == "N";
                let name = if told_by_force { "force limit" } else { limit.name };
                (name, limit.bounds.iter().enumerate().map(scaled).collect())
            })
            .collect();
        let bounds: Vec<(&str, &[f64])> = bounds.iter().map(|(name, bounds)| (*name, &bounds[..])).collect();
        let (title, unit) = if of_force { ("Forces", "N") } else { ("Torques", "N·m") };
        let one_sided = actuation.torque.limits().one_sided;
        let title = match (&actuation.wheels, one_sided) {
            (Some(_), _) if !of_force => "Torques of the wheels",
            (_, true) => "Thrusters",
            _ => title,
        };
        let unit = if of_force { unit } else { scale(problem, subject.identity, forces).1 };
        let mut chart = Chart::new(title, time_axis(), Axis::linear(format!("input, {unit}")), curves);
        within(&mut chart, &bounds, unit);
        chart.spans = limits
            .iter()
            .filter(|limit| limit.kind != LimitKind::WheelMomentum)
            .flat_map(|limit| active(subject, limit.name, "limit active"))
            .collect();
        if chart.spans.is_empty() {
            chart.spans = arcs::arcs(subject);
        }
        let key = if of_force { "forces" } else { "inputs" };
        shown(key, chart, "")
    };
    let torques = (forces < count).then(|| channel(false));
    torques.into_iter().chain((forces > 0).then(|| channel(true))).collect()
}

/// Returns the chart of the on-times of all thrusters, with one row for each thruster; `None` if
/// the maneuver has no thrusters.
pub(super) fn on_and_off(subject: &Subject) -> Option<Shown> {
    let (problem, solution, identity) = (subject.problem, &subject.plan.solution, subject.identity);
    let found = firings(problem, solution);
    if found.is_empty() {
        return None;
    }
    let first = problem.actuation.first_torque();
    let row = |input: usize| {
        let bars = found.iter().filter(|firing| firing.input == input);
        (subject.input_name(input), bars.map(|firing| [firing.from, firing.to]).collect())
    };
    let gantt = Gantt {
        title: "Thrusters on and off".into(),
        subtitle: "long stretches without thrust are left out".into(),
        end: *solution.trajectory.time.last()?,
        rows: (first..first + problem.actuation.torque.count()).map(row).collect(),
    };
    let remark = firings::told(problem, solution, identity).join("; ");
    Some(Shown { key: "firings", picture: Picture::Gantt(gantt), remark })
}

/// Returns the curves of the three components of a vector over time and, if `norm` is requested,
/// the curve of its norm.
pub(super) fn components(
    time: &[f64],
    vectors: &[Vector3],
    name: &str,
    factor: f64,
    norm: bool,
) -> Vec<Curve> {
    let component = |axis: usize| {
        let values = vectors.iter().map(move |vector| factor * vector[axis]);
        line(format!("{name}{}", AXES[axis]), axis, time, values)
    };
    let whole = || line(format!("|{}|", name.trim_end()), 7, time, vectors.iter().map(|v| factor * v.norm()));
    (0..3).map(component).chain(norm.then(whole)).collect()
}

fn rates(subject: &Subject) -> Shown {
    let (problem, trajectory) = (subject.problem, subject.trajectory());
    let degrees = 1.0_f64.to_degrees();
    let curves = components(&trajectory.time, &trajectory.angular_velocity, "Ω ", degrees, true);
    let mut chart = Chart::new("Angular velocity", time_axis(), Axis::linear("Ω, deg/s"), curves);
    let rules = problem.constraints.iter().filter_map(|constraint| match &constraint.rule {
        Rule::RateNorm(limit) => Some((constraint.name.as_str(), vec![degrees * limit])),
        Rule::RateAxes(limits) => {
            Some((constraint.name.as_str(), limits.iter().map(|limit| degrees * limit).collect()))
        }
        Rule::Pointing(_) => None,
    });
    let rules: Vec<(&str, Vec<f64>)> = rules.collect();
    let bounds: Vec<(&str, &[f64])> = rules.iter().map(|(name, limits)| (*name, &limits[..])).collect();
    within(&mut chart, &bounds, "deg/s");
    chart.spans = rules.iter().flat_map(|(name, _)| active(subject, name, "limit active")).collect();
    shown("rates", chart, "inertial, in body axes")
}

fn wheels(subject: &Subject) -> Option<Shown> {
    let trajectory = subject.trajectory();
    let wheels = subject.problem.actuation.wheels.as_ref()?;
    let count = wheels.momentum.len();
    // In a row of inputs, the wheels are last.
    let first = trajectory.input_count.saturating_sub(count);
    let curve = |wheel: usize| {
        let values = trajectory.wheel_momentum.iter().skip(wheel).step_by(count).copied();
        line(subject.input_name(first + wheel), wheel, &trajectory.time, values)
    };
    let curves = (0..count).map(curve).collect();
    let mut chart = Chart::new("Momentum of the wheels", time_axis(), Axis::linear("h, N·m·s"), curves);
    within(&mut chart, &[("wheel momentum limit", &wheels.momentum_limit)], "N·m·s");
    chart.spans = active(subject, "wheel momentum limit", "limit active");
    Some(shown("wheel_momentum", chart, ""))
}

fn translation(subject: &Subject) -> Vec<Shown> {
    if subject.problem.motion == Motion::Attitude {
        return Vec::new();
    }
    let trajectory = subject.trajectory();
    let chart = |key, title, name, unit: &str, vectors: &[Vector3]| {
        let curves = components(&trajectory.time, vectors, name, 1.0, false);
        shown(key, Chart::new(title, time_axis(), Axis::linear(unit), curves), subject.reference_frame())
    };
    vec![
        chart("position", "Position", "", "position, m", &trajectory.position),
        chart("velocity", "Velocity", "v ", "velocity, m/s", &trajectory.velocity),
    ]
}

fn clearance(subject: &Subject) -> Option<Shown> {
    let course = subject.course().filter(|course| !course.clearances.is_empty())?;
    // A step has one value, which is drawn at its end.
    let time = &subject.trajectory().time[1..];
    let curves = course.clearances.iter().enumerate().flat_map(|(index, clearance)| {
        let curve = |what: &str, part: usize, values: &[f64]| {
            let name = format!("{what}\n{}", clearance.name);
            // A cone that is no longer active has an infinite clearance.
            let last = values.iter().rposition(|value| *value != f64::INFINITY).map_or(0, |last| last + 1);
            line(name, 2 * index + part, &time[..last], values[..last].iter().map(|value| value.to_degrees()))
        };
        [curve("true motion", 0, &clearance.continuous), curve("discrete motion", 1, &clearance.discrete)]
    });
    let axis = Axis::linear("angle to the cone, deg");
    let mut chart = Chart::new("Clearance of the cones", time_axis(), axis, curves.collect());
    chart.levels.push(Level { value: 0.0, label: "violated below".into() });
    let cones = course.clearances.iter();
    chart.spans = cones.flat_map(|clearance| active(subject, &clearance.name, "cone active")).collect();
    let remark = "the smallest clearance on each step, also between the nodes, with the margins of the spec; by \
     the witnesses: discrete motion, and continuous motion under the held torque";
    Some(shown("clearance", chart, remark))
}

/// Returns the charts of the costates; no chart if the plan has no costates.
pub(super) fn costates(subject: &Subject) -> Vec<Shown> {
    let (trajectory, dimension) = (subject.trajectory(), subject.problem.dimension());
    if trajectory.costates.is_empty() {
        return Vec::new();
    }
    let chart = |key, title: &str, symbol: &str, first: usize| {
        let component = |axis: usize| {
            let values = trajectory.costates.iter().skip(first + axis).step_by(dimension).copied();
            line(format!("{symbol} {}", AXES[axis]), axis, subject.input_times(), values)
        };
        let curves = (0..3).map(component).collect();
        shown(key, Chart::new(title, time_axis(), Axis::linear(format!("{symbol}, SI")), curves), "")
    };
    let rotation = dimension - 6;
    let mut all = vec![
        chart("costates_attitude", "Costates of the attitude", "λζ", rotation),
        chart("costates_momentum", "Costates of the angular momentum", "λΠ", rotation + 3),
    ];
    if rotation > 0 {
        all.push(chart("costates_position", "Costates of the position", "λx", 0));
        all.push(chart("costates_linear", "Costates of the linear momentum", "λγ", 3));
    }
    all
}

/// Draws a line at each bound and at its negative, with one label for equal bounds. Bounds that are
/// far outside of the curves are stated in the subtitle instead.
pub(super) fn within(chart: &mut Chart, bounds: &[(&str, &[f64])], unit: &str) {
    let points = chart.curves.iter().flat_map(|curve| curve.shape.points());
    let finite = points.map(|point| point.1).filter(|value| value.is_finite());
    let (low, high) =
        finite.fold((0.0, 0.0), |(low, high): (f64, f64), value| (low.min(value), high.max(value)));
    let reach = high.max(-low);
    let mut far = Vec::new();
    for (name, limits) in bounds {
        let mut limits: Vec<f64> = limits.iter().copied().filter(|limit| limit.is_finite()).collect();
        limits.sort_by(|a, b| b.total_cmp(a));
        limits.dedup();
        let (outside, shown): (Vec<f64>, Vec<f64>) =
            limits.into_iter().partition(|limit| *limit > FAR * reach);
        far.extend(outside.iter().map(|limit| format!("{name} {} {unit} is outside", short(*limit))));
        // Labels of neighbouring lines would overlap, so the label of the highest line lists all
        // limits.
        let all: Vec<String> = shown.iter().map(|limit| short(*limit)).collect();
        let mut label = format!("{name} {} {unit}", all.join(", "));
        for limit in shown {
            chart.levels.push(Level { value: limit, label: std::mem::take(&mut label) });
            if low < -0.3 * limit {
                chart.levels.push(Level { value: -limit, label: String::new() });
            }
        }
    }
    chart.subtitle = far.join(", ");
}

/// Returns the time spans in which the limit or constraint `name` is active. Consecutive active
/// nodes form one span.
fn active(subject: &Subject, name: &str, label: &str) -> Vec<Span> {
    let solution = &subject.plan.solution;
    let Some(active) = solution.active.iter().find(|active| active.name == name) else {
        return Vec::new();
    };
    let duration = solution.duration(subject.problem);
    let step = duration / subject.problem.steps as f64;
    let mut times: Vec<f64> = active.time_s.clone();
    times.sort_by(f64::total_cmp);
    let mut spans: Vec<Span> = Vec::new();
    for time in times {
        let (from, to) = ((time - 0.5 * step).max(0.0), (time + 0.5 * step).min(duration));
        match spans.last_mut() {
            // Active times are recorded at nodes and between nodes, half a step apart.
            Some(last) if time - last.to <= 1.01 * step => last.to = to,
            _ => spans.push(Span { from, to, label: label.into() }),
        }
    }
    spans
}
