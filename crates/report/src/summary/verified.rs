//! Lines about the results of the witnesses.

use super::lines::{Lines, Tone, line, paint};
use slewkit::maneuver::{ActiveConstraint, Problem, Trajectory};
use slewkit::numerics::figures::{counted, error, significant, told_apart};
use slewkit::verify::{Margin, Testimony, Verification};
use slewkit_files::identity::Identity;
use slewkit_files::spec::escape;

/// A plan that the witnesses have judged, with the data for describing it.
pub struct Judged<'a> {
    /// Maneuver to which the plan belongs.
    pub problem: &'a Problem,
    /// Names of the inputs and frames.
    pub identity: &'a Identity,
    /// Trajectory of the plan.
    pub trajectory: &'a Trajectory,
    /// Limits that are active according to the solver; `None` if active limits are not shown.
    pub active: Option<&'a [ActiveConstraint]>,
}

/// Returns the lines about the margins, about the results of the witnesses, and about every failed
/// check.
pub fn verified(colour: bool, judged: &Judged, verification: &Verification) -> Vec<String> {
    if verification.was_stopped() {
        // If the witnesses failed, their results are NaN.
        return verification.failure.iter().map(|failure| line("witness", &escape(failure))).collect();
    }
    let mut peaks = format!(
        "peak torque (norm) {} N·m   peak rate {} deg/s",
        significant(verification.peak_torque_n_m, 3),
        significant(verification.peak_rate_rad_s.to_degrees(), 3)
    );
    if judged.problem.actuation.wheels.is_some() {
        let momenta = judged.trajectory.wheel_momentum.iter().map(|momentum| momentum.abs());
        let peak = momenta.fold(0.0, f64::max);
        peaks.push_str(&format!("   peak wheel momentum {} N·m·s", significant(peak, 3)));
    }
    let mut lines = vec![line("limits", &peaks)];
    let name = |margin: &Margin| escape(&margin.name);
    let width = verification.margins.iter().map(|margin| name(margin).chars().count()).max().unwrap_or(0);
    for margin in &verification.margins {
        let text = format!("{:<width$}  {}", name(margin), self::margin(colour, judged, margin));
        lines.line("", &text);
    }
    let missed = verification.continuous_attitude_rad;
    // A plan of zero duration has no motion that a witness could propagate.
    if let Some(ran) = ran(verification, "continuous, held torque") {
        let mut continuous = format!(
            "continuous witness, {}, torque held over each step: attitude {} rad ({} deg)",
            ran.method,
            error(missed),
            significant(missed.to_degrees(), 2)
        );
        if let Some(position) = verification.continuous_position_m {
            continuous.push_str(&format!(", position {} m", error(position)));
        }
        lines.line("verified", &continuous);
    }
    if let Some(symplectic) = ran(verification, "symplectic") {
        let text = match verification.symplectic_to_continuous {
            Some(apart) => format!("{}, {} from the continuous one", symplectic.method, error(apart)),
            None => symplectic.method.clone(),
        };
        lines.line("", format!("symplectic witness{}: {text}", over(symplectic, judged)));
    }
    if let Some(order) = ran(verification, "order") {
        let found = verification.order.map_or("round-off".into(), |order| significant(order, 3));
        let text = format!("order of convergence{}: {found}, {}", over(order, judged), order.method);
        lines.line("", &text);
    }
    if let Some(failure) = &verification.failure {
        lines.line("witness", escape(failure));
    }
    lines.extend(failures(colour, verification));
    lines
}

/// Returns a line for every failed check, with its value and its limit.
pub(super) fn failures(colour: bool, verification: &Verification) -> Vec<String> {
    let mut lines = Vec::new();
    for check in verification.checks.iter().filter(|check| !check.passed) {
        let label = paint(colour, Tone::Bad, &escape(&check.name));
        let figure = |value: f64, digits: usize| match check.name.as_str() {
            "continuous terminal" => {
                format!("{} deg", significant(value.to_degrees(), digits))
            }
            _ => significant(value, digits),
        };
        let [value, limit] = told_apart([check.value, check.limit], 3, figure);
        lines.line("failed", format!("{label}: {value}, limit {limit}"));
        if check.name == "continuous terminal" && check.value > check.limit {
            lines.lines(
                "",
                ["the steps are too coarse: the motion under this torque ends", "elsewhere; use more steps"],
            );
        }
    }
    lines
}

/// Returns the record of the witness `witness`, even if it could not judge the plan; `None` if it
/// was not called.
fn ran<'a>(verification: &'a Verification, witness: &str) -> Option<&'a Testimony> {
    verification.witnesses.iter().find(|ran| ran.witness == witness)
}

/// Describes the part of the plan over which a witness ran; empty if it ran over the whole plan.
fn over(ran: &Testimony, judged: &Judged) -> String {
    if ran.windows <= 1 {
        return String::new();
    }
    format!(" over {} of {} steps in {} windows", ran.steps, judged.problem.steps, ran.windows)
}

/// Describes the margin of the continuous motion to one limit, the time at which it is smallest,
/// and whether this time is between two nodes.
fn margin(colour: bool, judged: &Judged, margin: &Margin) -> String {
    let active = judged.active.and_then(|all| all.iter().find(|active| active.name == margin.name));
    let touched = judged.active.is_none() && margin.scaled.abs() <= Margin::ROUND_OFF;
    let state = match active {
        _ if !margin.holds() => paint(colour, Tone::Bad, "violated, "),
        Some(active) => format!("active at {}, ", counted(moments(active), "node")),
        None if touched => "active, ".into(),
        None => String::new(),
    };
    let is_between = judged.problem.duration.known().is_some_and(|duration| {
        let steps = margin.time_s / (duration / judged.problem.steps as f64);
        (steps - steps.round()).abs() > 1e-6
    });
    let between = if is_between { ", between nodes" } else { "" };
    let name = margin.input(judged.problem).and_then(|input| judged.identity.input(input));
    let at = name.unwrap_or(&margin.at);
    let at = if at.is_empty() { String::new() } else { format!(", {}", escape(at)) };
    let (value, time) = (significant(margin.met(), 3), significant(margin.time_s, 4));
    // The continuous motion may exceed an active limit by the discretisation error.
    let noticed = -Margin::ROUND_OFF.to_degrees();
    let beyond = margin.continuous_margin.is_some_and(|continuous| continuous < noticed) && margin.holds();
    let overstepped = if beyond { "; the discrete motion keeps the limit" } else { "" };
    format!("{state}margin {value} {} at {time} s{between}{at}{overstepped}", margin.unit)
}

/// Returns the number of different times at which a constraint is active. Several inputs that are
/// at a limit at the same time count once.
fn moments(active: &ActiveConstraint) -> usize {
    let mut times: Vec<u64> = active.time_s.iter().map(|time| time.to_bits()).collect();
    times.sort_unstable();
    times.dedup();
    times.len()
}
