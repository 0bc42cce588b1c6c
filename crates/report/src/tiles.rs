//! The headline figures of a page: a few quantities of a plan, each with its limit.

use super::Subject;
use super::boresight;
use super::summary::inputs::{Busiest, busiest, fuel_unit};
use slewkit::maneuver::{Motion, Objective, Outcome, Rule};
use slewkit::numerics::figures::{short, significant};
use slewkit::verify::{Margin, Verification};

/// A headline figure: a quantity with its value and a note.
pub(super) struct Tile {
    /// Name of the quantity that the figure states.
    pub name: String,
    /// Value of the quantity, as text with its unit.
    pub value: String,
    /// Note below the value: the value in percent of its limit, or the time at which it occurs.
    pub note: String,
}

/// Returns the headline figures of a plan: duration, angle turned, cost, the peaks of the angular
/// rate and of the inputs, and the smallest clearance to a cone. The list is empty if no plan
/// exists.
pub(super) fn tiles(subject: &Subject) -> Vec<Tile> {
    let (problem, solution) = (subject.problem, &subject.plan.solution);
    if solution.outcome != Outcome::Converged {
        return Vec::new();
    }
    let tile = |name: &str, value: String, note: String| Tile { name: name.into(), value, note };
    let duration = format!("{} s", short(solution.duration(problem)));
    let sought = if problem.seeks_duration() { "sought" } else { "given" };
    let mut all = vec![
        tile("duration", duration, sought.into()),
        tile("turn", format!("{:.1}°", solution.turned_deg), String::new()),
    ];
    let unit = match &problem.objective {
        Objective::Time => None,
        Objective::Fuel(_) => Some(fuel_unit(problem, subject.identity)),
        Objective::Effort(weights) if weights.torque.is_none() && problem.motion == Motion::Attitude => {
            Some("N²·m²·s")
        }
        Objective::Effort(_) => Some(""),
    };
    if let Some(unit) = unit {
        let value = format!("{} {unit}", significant(solution.cost, 4)).trim_end().to_string();
        all.push(tile(problem.objective.name(), value, "the least found".into()));
    }
    let Some(found) = subject.plan.verification.as_ref().filter(|found| !found.was_stopped()) else {
        return all;
    };
    all.push(tile(
        "peak rate",
        format!("{}°/s", significant(found.peak_rate_rad_s.to_degrees(), 3)),
        rate(subject, found),
    ));
    for Busiest { kind, name, peak, unit, limit } in busiest(problem, solution, subject.identity) {
        let value = format!("{} {unit}", significant(peak, 3));
        let part = |limit: f64| format!("{:.0} % of {} {unit}, {name}", 100.0 * peak / limit, short(limit));
        all.push(tile(&format!("peak {}", quantity(kind)), value, limit.map_or(name.clone(), part)));
    }
    all.extend(clearance(subject, found));
    all
}

/// Returns the name of the quantity that inputs of this kind produce.
fn quantity(kind: &str) -> &str {
    match kind {
        "wheels" => "wheel torque",
        "thrusters" => "thrust",
        other => other,
    }
}

/// Returns the largest angular rate in percent of its limit, for the rate limit with the smallest
/// margin; an empty text if the maneuver has no rate limit.
fn rate(subject: &Subject, found: &Verification) -> String {
    let limited = subject.problem.constraints.iter().filter_map(|constraint| {
        let bound = match &constraint.rule {
            Rule::RateNorm(limit) => *limit,
            Rule::RateAxes(limits) => limits.min(),
            Rule::Pointing(_) => return None,
        };
        let margin = found.margins.iter().find(|margin| margin.name == constraint.name)?;
        Some((bound.to_degrees(), margin.scaled))
    });
    let tightest = limited.min_by(|a, b| a.1.total_cmp(&b.1));
    tightest.map_or(String::new(), |(bound, scaled)| {
        format!("{:.0} % of {}°/s", 100.0 * (1.0 - scaled).max(0.0), short(bound))
    })
}

/// Returns the smallest clearance to a cone in the continuous motion; `None` if the maneuver has no
/// cones.
fn clearance(subject: &Subject, found: &Verification) -> Option<Tile> {
    let is_cone = |margin: &&Margin| {
        let rule = subject.problem.constraints.iter().find(|constraint| constraint.name == margin.name);
        rule.is_some_and(|constraint| matches!(constraint.rule, Rule::Pointing(_)))
    };
    let least = found.margins.iter().filter(is_cone).min_by(|a, b| a.met().total_cmp(&b.met()))?;
    let value = if least.met().abs() < 1e-3 { 0.0 } else { least.met() };
    let of = boresight::of_margin(subject.problem, subject.identity, least);
    let of = of.map_or(String::new(), |name| format!(" for {name}"));
    let note = format!("{}{of} at {} s", least.name, short(least.time_s));
    Some(Tile { name: "least clearance".into(), value: format!("{}°", significant(value, 3)), note })
}
