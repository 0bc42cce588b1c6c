//! Summary of the gains, the uncertainty and the simulated flights of a plan.

use super::lines::Lines;
use super::{Tone, headline};
use slewkit::Vector3;
use slewkit::assured::Beside;
use slewkit::closed_loop::Flown;
use slewkit::feedback::{Gains, Kind, SwitchingGains};
use slewkit::maneuver::{Problem, Rule};
use slewkit::mechanics::LimitKind;
use slewkit::numerics::figures::{counted, significant};
use slewkit::uncertainty::{Covariance, Radius, Uncertainty};
use slewkit_files::flown::{HeldRecord, LoopRecord, MarginsRecord, RunRecord, boresights};
use slewkit_files::spec::{ClosedLoop, escape};

/// Probability below which the summary states that the value is extrapolated from the tail of the
/// normal distribution.
const SAMPLED: f64 = 1e-4;

/// Probability below which the summary only states that the probability is smaller, because values
/// so far in the tail of the normal distribution are meaningless.
const NEGLIGIBLE: f64 = 1e-12;

/// Returns the lines about the gains, the uncertainty and the violation probabilities of a plan,
/// according to linear theory.
pub fn beside(
    problem: &Problem,
    closed_loop: &ClosedLoop,
    beside: &Beside,
    margins: Option<&MarginsRecord>,
) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(gains) = &beside.gains {
        lines.extend(self::gains(gains, beside.linear.times()));
        if let Some(text) = beside.switching.as_ref().map(|switching| reach(problem, switching)) {
            lines.text("", text);
        }
    }
    if let Some(open) = &beside.open {
        let text = uncertain(problem, open, beside.closed.as_ref());
        lines.text("uncertain", text);
    }
    if let (Some(closed), Some(uncertainty)) = (&beside.closed, &closed_loop.uncertainty)
        && let Some(text) = largest_share(closed, uncertainty)
    {
        lines.text("", text);
    }
    // If the spec has a chance constraint for the limit, its probability is reported instead.
    let limit = problem.actuation.limit_name(LimitKind::Size, false);
    let is_asked = closed_loop.chances.iter().any(|chance| chance.limits.iter().any(|name| name == limit));
    if beside.gains.is_some()
        && !is_asked
        && let Some(closed) = &beside.closed
        && let Some(text) = demand(problem, beside, closed)
    {
        lines.text("", text);
    }
    lines.texts("chance", chances(problem, closed_loop, beside));
    if let Some(margins) = margins {
        lines.text("margin", kept(margins));
    }
    lines
}

/// Returns the violation probability of each constraint and of each limit with a chance constraint,
/// followed by the joint probabilities.
fn chances(problem: &Problem, closed_loop: &ClosedLoop, beside: &Beside) -> Vec<String> {
    let is_constraint = |name: &str| problem.constraints.iter().any(|constraint| constraint.name == name);
    let shared =
        |name: &str| closed_loop.chances.iter().any(|chance| chance.limits.iter().any(|limit| limit == name));
    let told = beside.chances.iter().filter(|chance| is_constraint(&chance.name) || shared(&chance.name));
    let mut texts: Vec<String> = told
        .map(|chance| {
            let of = closed_loop.asked(&chance.name).map_or(String::new(), |asked| {
                format!(", requested at most {}{}", significant(asked.at_most, 2), when(asked))
            });
            let (name, largest) = (escape(&chance.name), chance.largest());
            if largest < NEGLIGIBLE {
                return format!("{name}: below {NEGLIGIBLE:e} at all times{of}");
            }
            let tail = if largest < SAMPLED { " (from the tail of the normal distribution)" } else { "" };
            let at = significant(beside.linear.times()[chance.worst().node], 3);
            format!("{name}: {} at its worst, {at} s{of}{tail}", significant(largest, 2))
        })
        .collect();
    texts.extend(closed_loop.chances.iter().filter(|chance| chance.is_joint).map(|chance| {
        let names = escape(&chance.limits.join(", "));
        format!("any of {names}: requested at most {} over the motion", significant(chance.at_most, 2))
    }));
    texts
}

/// Describes the gains along a plan. `times` are the times of its nodes \[s\].
pub fn gains(gains: &Gains, times: &[f64]) -> Vec<String> {
    let steps = times.len() - 1;
    let every = if gains.every > 1 {
        format!(" every {} s", significant(times[gains.every], 3))
    } else {
        String::new()
    };
    let of = if gains.states == 12 { " of the pose" } else { "" };
    let text = match gains.kind {
        Kind::Neighbouring { .. } if gains.frozen_from < steps => {
            let held = steps + 1 - gains.frozen_from;
            format!("neighbouring gains{of}{every}, held over the last {held} of {steps} steps")
        }
        Kind::Neighbouring { .. } => format!("neighbouring gains{of}{every} to the end"),
        Kind::Tvlqr(_) => format!("regulator{of}{every} along the plan"),
        Kind::Switching(_) => {
            "switching times corrected at the start, then a regulator along the plan".into()
        }
    };
    let mut lines = Vec::new();
    lines.text("feedback", text);
    lines
}

/// Describes the smallest attitude error and the smallest rate error at the start for which the
/// corrected duration of an arc becomes zero.
fn reach(problem: &Problem, switching: &SwitchingGains) -> String {
    let reach = switching.reach();
    let least = |range: std::ops::Range<usize>| {
        let all = range.map(|column| (reach[column], column));
        all.min_by(|a, b| a.0.0.total_cmp(&b.0.0)).unwrap_or(((f64::INFINITY, 0), 0))
    };
    let axis = |column: usize| ["x", "y", "z"][column % 3];
    let ((turn, first), of_turn) = least(0..3);
    // The error is converted from a momentum to a rate about each axis separately.
    let by_rate = |axis: usize| {
        let momentum = problem.body.inertia.j().column(axis).into_owned();
        let least = |(index, arc): (usize, &slewkit::feedback::Arc)| {
            let row = switching.row(index);
            (arc.length / (row[3] * momentum.x + row[4] * momentum.y + row[5] * momentum.z).abs(), index)
        };
        let all = switching.arcs.iter().enumerate().map(least);
        all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
    };
    let rates = (0..3).map(|axis| (by_rate(axis), axis));
    let ((rate, second), of_rate) =
        rates.min_by(|a, b| a.0.0.total_cmp(&b.0.0)).unwrap_or(((f64::INFINITY, 0), 0));
    let and = if first == second { String::new() } else { format!(", or arc {},", second + 1) };
    format!(
        "errors of {} deg about {}, or {} deg/s about {}, would make arc {}{and} shorter than zero: \
        plan again if they occur",
        significant(turn.to_degrees(), 2),
        axis(of_turn),
        significant(rate.to_degrees(), 2),
        axis(of_rate),
        first + 1,
    )
}

/// Returns a phrase for a probability over the whole motion; empty for the probability at the worst
/// instant.
fn when(asked: &slewkit_files::spec::Chance) -> &'static str {
    if asked.of_motion { " over the motion" } else { "" }
}

fn radii(problem: &Problem, covariance: &Covariance) -> f64 {
    let of_attitude = covariance.end.fixed_view::<3, 3>(0, 0).into_owned();
    boresights(problem).iter().map(|boresight| Radius::of(boresight, &of_attitude).within).fold(0.0, f64::max)
}

/// Describes the 99.73 % range of the pointing error at the end, in open and in closed loop.
fn uncertain(problem: &Problem, open: &Covariance, closed: Option<&Covariance>) -> String {
    let of = |covariance: &Covariance| significant(radii(problem, covariance).to_degrees(), 3);
    match closed {
        Some(closed) => {
            format!("boresights end within {} deg with gains (99.73 %), {} deg without", of(closed), of(open))
        }
        None => format!("boresights end within {} deg (99.73 %), without gains", of(open)),
    }
}

/// Describes the uncertain quantity that contributes most to the variance of the attitude at the
/// end.
fn largest_share(covariance: &Covariance, uncertainty: &Uncertainty) -> Option<String> {
    let all: f64 = (0..3).map(|row| covariance.end[(row, row)]).sum();
    let of_parameters: f64 = (0..3).map(|row| covariance.end_of_parameters[(row, row)]).sum();
    let share = |(column, (name, _, sigma)): (
        &slewkit::optimize::discrete::linear_plan::Vector6,
        &(String, _, f64),
    )| {
        let part = column.fixed_rows::<3>(0).norm_squared() * sigma * sigma / all;
        (name.clone(), part)
    };
    let mut shares: Vec<(String, f64)> =
        covariance.end_by_parameter.iter().zip(&uncertainty.parameters).map(share).collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let (name, part) = shares.first().filter(|(_, part)| part.is_finite() && *part > 0.0)?;
    Some(format!(
        "{} of its variance is from constant errors, most from {} ({})",
        percent(of_parameters / all),
        escape(name),
        percent(*part)
    ))
}

fn percent(part: f64) -> String {
    format!("{} %", significant(100.0 * part, 2))
}

/// Compares three standard deviations of the largest correction with the margin of the planned
/// input to its limit.
fn demand(problem: &Problem, beside: &Beside, closed: &Covariance) -> Option<String> {
    let craft = problem.of_craft();
    let sizes = craft.actuation.torque.limits().size.as_ref()?;
    let mut worst = (0.0, 0, 0);
    for (step, sigmas) in closed.inputs.iter().enumerate() {
        for (input, sigma) in sigmas.iter().enumerate() {
            let left = (sizes[input] - beside.linear.inputs(step)[input].abs()).max(f64::MIN_POSITIVE);
            let part = 3.0 * sigma / left;
            if part > worst.0 {
                worst = (part, step, input);
            }
        }
    }
    let (part, step, input) = worst;
    let at = significant(beside.linear.times()[step], 3);
    (part > 1.0).then(|| {
        format!(
            "input {} has less reserve than three deviations of its correction, at {at} s: increase \
            the reserve, or plan with smaller limits",
            input + 1
        )
    })
}

/// Formats the margin to a limit as one number, or as the smallest and the largest of several
/// numbers.
fn held(of: &HeldRecord) -> String {
    let number = |number: f64| significant(number, 4);
    let range = |numbers: &[f64]| {
        let (least, most) =
            numbers.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), number| {
                (least.min(*number), most.max(*number))
            });
        if number(least) == number(most) {
            number(most)
        } else {
            format!("{} to {}", number(least), number(most))
        }
    };
    let limit = if of.limit.is_empty() { String::new() } else { format!(" of {}", range(&of.limit)) };
    format!("{} {}{limit} {}", escape(&of.name), range(&of.held), of.unit)
}

/// Describes the margins and reserves that the plan keeps for its chance constraints.
pub fn kept(margins: &MarginsRecord) -> String {
    let flown = margins.counted.iter().map(|(name, counted)| {
        let [low, high] = counted.interval.map(percent);
        format!(
            "; {} of the flights violate {} at any time, {low} to {high}",
            percent(counted.part),
            escape(name)
        )
    });
    let flown: String = flown.collect();
    let agreed = if margins.agreed { "" } else { "; margins and covariances have not converged yet" };
    format!(
        "{} for the requested chances, found in {}; without them the cost is {}{flown}{agreed}",
        margins.held.iter().map(held).collect::<Vec<_>>().join(", "),
        counted(margins.plans, "plan"),
        significant(margins.cost_without, 6)
    )
}

/// Describes the result of one simulated flight.
pub fn case(
    problem: &Problem,
    uncertainty: &Uncertainty,
    case: u64,
    closed: bool,
    flown: &Flown,
) -> Vec<String> {
    let mut lines = Vec::new();
    let name = if closed { "closed loop" } else { "open loop" };
    let turn: Vector3 = flown.end.fixed_rows::<3>(0).into_owned();
    let rate: Vector3 = flown.end.fixed_rows::<3>(3).into_owned();
    lines.line(
        "case",
        format!(
            "{case}, {name}: ends {} deg and {} deg/s from the plan",
            significant(turn.norm().to_degrees(), 3),
            significant(rate.norm().to_degrees(), 3)
        ),
    );
    let drawn = uncertainty.parameters.iter().zip(&flown.parameters);
    let drawn: Vec<String> =
        drawn.map(|((name, ..), value)| format!("{} {}", escape(name), significant(*value, 3))).collect();
    lines.text("drawn", drawn.join(", "));
    for (constraint, room) in problem.constraints.iter().zip(&flown.room) {
        let unit = if matches!(constraint.rule, Rule::Pointing(_)) {
            format!("{} deg", significant(room.to_degrees(), 3))
        } else {
            format!("{} of the limit", percent(*room))
        };
        lines.line("room", format!("{}: {unit}", escape(&constraint.name)));
    }
    lines
}

/// Describes the results of many simulated flights.
pub fn runs(colour: bool, record: &RunRecord) -> Vec<String> {
    let lost: usize = record.loops.iter().map(|one| one.lost).sum();
    let verdict = format!("{} flown", counted(record.cases, "case"));
    let tone = if lost == 0 { Tone::Good } else { Tone::Bad };
    let mut lines = vec![headline(colour, &escape(&record.name), &verdict, tone)];
    for one in &record.loops {
        lines.texts(&one.name, told(one));
    }
    lines
}

fn told(one: &LoopRecord) -> Vec<String> {
    let end = &one.end;
    let [half, ninety, _, most] = end.angle_quantiles_deg.map(|angle| significant(angle, 3));
    let mut lines = vec![format!(
        "attitude off by {half} deg in the median, {ninety} in 90 %, {most} in 99.73 % of the cases"
    )];
    let most = |values: &[f64; 3]| values.iter().copied().fold(0.0, f64::max);
    lines.push(format!(
        "deviation {} deg and {} deg/s about the worst axes, {} and {} by linear theory",
        significant(most(&end.attitude_sigma_deg), 3),
        significant(most(&end.rate_sigma_deg_s), 3),
        significant(most(&end.attitude_sigma_linear_deg), 3),
        significant(most(&end.rate_sigma_linear_deg_s), 3),
    ));
    lines.push(format!(
        "{} inside the 99.73 % ellipsoid{}",
        percent(end.inside_9973.part),
        end.eigenvalues.map_or(String::new(), |[least, largest]| format!(
            ", variances {} to {} times the linear",
            significant(least, 3),
            significant(largest, 3)
        ))
    ));
    lines.extend(one.stops.iter().map(|mark| {
        let [half, _, _, most] = mark.angle_quantiles_deg.map(|angle| significant(angle, 3));
        format!(
            "{}, {} at {} s: off by {half} deg in the median, {most} in 99.73 % of the cases",
            escape(&mark.stop),
            mark.event,
            significant(mark.time_s, 6)
        )
    }));
    for cone in end.constraints.iter().chain(&end.limits) {
        let violated = match cone.violated.count {
            0 => {
                format!("violated in no flight, below {} at 95 %", significant(cone.violated.interval[1], 2))
            }
            count => format!(
                "violated in {} ({}, {} to {})",
                counted(count as usize, "flight"),
                percent(cone.violated.part),
                percent(cone.violated.interval[0]),
                percent(cone.violated.interval[1])
            ),
        };
        lines.push(format!("{}: {violated}", escape(&cone.name)));
    }
    if one.saturated > 0.0 {
        lines.push(format!("the commands saturate at limits on {} of the steps", percent(one.saturated)));
    }
    if one.rejected_inertias > 0 {
        lines.push(format!("{} drawn inertias were impossible and were drawn again", one.rejected_inertias));
    }
    if one.lost > 0 {
        lines.push(format!("{} cases lost: they turn too fast to be propagated", counted(one.lost, "case")));
    }
    lines
}
