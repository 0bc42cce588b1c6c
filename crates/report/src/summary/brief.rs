//! Summary for the users of a plan: the angle, the duration, the cost, the margins to every limit,
//! and the terminal error of the continuous motion. It has about a dozen lines of eighty columns;
//! [`super::details`] describes the work of the solver.

use super::found::rotation_beside_path;
use super::inputs;
use super::lines::{Lines, clipped, percent, rows};
use super::stopped::{nearest, stopped};
use super::verified::failures;
use super::{firings, fixed_axis, target};
use crate::boresight;
use slewkit::maneuver::{
    Motion, Objective, Outcome, Path, Problem, Proved, Rule, SecondOrder, Sense, Settings, Shift, Solution,
    Structure, Turns,
};
use slewkit::numerics::figures::{counted, short, significant};
use slewkit::plan::Plan;
use slewkit::verify::{Accuracy, Margin, Verification};
use slewkit_files::identity::Identity;
use slewkit_files::spec::escape;

/// Largest number of lines of a summary, including its headline and the suggested next command.
const MOST_LINES: usize = 12;

/// Number of lines of a summary that are not in its body: the headline and the suggested next
/// command.
const AROUND: usize = 2;

/// Largest relative difference between two costs that count as equal. Costs are printed to a tenth
/// of a percent.
const SAME: f64 = 5e-4;

/// Gap below which the summary does not report the gap, in percent of the cost.
const LEAST_GAP: f64 = 1e-3;

/// Largest clearance at which the boresight counts as touching the cone \[deg\].
const LITTLE: f64 = 1e-3;

/// Returns the lines below the headline, without the line that suggests the next command.
pub(super) fn brief(problem: &Problem, settings: &Settings, plan: &Plan, identity: &Identity) -> Vec<String> {
    let solution = &plan.solution;
    let problem = &solution.on_grid(problem);
    if solution.outcome != Outcome::Converged {
        return unsolved(solution);
    }
    let mut lines = Vec::new();
    lines.text("slew", slew(problem, solution));
    lines.text("cost", cost(problem, solution, identity));
    lines.texts("in turns", turns(problem, solution));
    let mut last = Vec::new();
    last.text("proof", proof(problem, solution));
    let mut others = Vec::new();
    others.texts("also found", also(problem, solution));
    let Some(found) = &plan.verification else {
        lines.extend(last);
        return lines;
    };
    if found.was_stopped() {
        lines.lines("check", found.failure.iter().map(|failure| escape(failure)));
        lines.extend(last);
        return lines;
    }
    lines.texts("arrives", arrives(problem, settings, found));
    let before = rows(&lines);
    lines.texts("target", target::told(problem, solution, identity));
    // The lines about the target do not reduce the number of lines for cones.
    let aimed = rows(&lines) - before;
    lines.extend(inputs::told(problem, &solution.trajectory, &found.margins, identity));
    lines.texts("firing", firings::told(problem, solution, identity));
    lines.text("rate", rate(problem, found));
    let failed = failures(false, found);
    let failed_nothing = failed.is_empty();
    if !failed_nothing {
        last = failed;
    }
    // Rivals are reported only if enough lines are left.
    if failed_nothing && AROUND + rows(&lines) + rows(&last) + rows(&others) < MOST_LINES + aimed {
        last.extend(others);
    }
    let room = (MOST_LINES + aimed).saturating_sub(AROUND + rows(&lines) + rows(&last)).max(1);
    lines.texts("clearance", clearances(problem, solution, found, identity, room));
    lines.extend(last);
    lines
}

/// Returns the lines that state why no plan was found.
fn unsolved(solution: &Solution) -> Vec<String> {
    let mut lines = Vec::new();
    let reason = match &solution.infeasible {
        Some(proof) => {
            lines.text("because", escape(&proof.reason));
            return lines;
        }
        None => stopped(solution),
    };
    lines.text("stopped", reason);
    lines.texts("missing", solution.shortfall.iter().map(|told| escape(&told.to_string())));
    lines.line("nearest", nearest(&solution.terminal));
    if !solution.ladder.is_empty() {
        let count = counted(solution.ladder.len(), "attempt");
        lines.line("tried", format!("{count}, which -v lists"));
    }
    lines
}

/// Returns one line for each group of alternative constraints, which states the set that holds and
/// until which time.
fn turns(problem: &Problem, solution: &Solution) -> Vec<String> {
    let end = solution.duration(problem);
    let told = solution.turns.iter().map(|Turns { of, shifts }| {
        let shift = |shift: &Shift| {
            let set = of.sets[shift.set].join("\" and \"");
            if shift.to < end {
                format!("\"{set}\" until {} s", short(shift.to))
            } else {
                format!("\"{set}\"")
            }
        };
        let held: Vec<String> = shifts.iter().filter(|shift| shift.from < end).map(shift).collect();
        escape(&format!("{}: {}", of.name, held.join(", then ")))
    });
    told.collect()
}

/// Returns the line about the slew: its angle, the short or long way, its duration and the number
/// of steps.
fn slew(problem: &Problem, solution: &Solution) -> String {
    let round = way(problem, solution.sense);
    let (turned, duration) = (solution.turned_deg, short(solution.duration(problem)));
    let moved = match problem.motion {
        Motion::Attitude => String::new(),
        Motion::RigidBody => {
            let way = (problem.end.position - problem.start.position).norm();
            format!(" and {} m on", short(way))
        }
    };
    let timed = problem.objective == Objective::Time;
    let sought = if problem.seeks_duration() && !timed { " (sought)" } else { "" };
    let steps = counted(solution.steps, "step");
    match rotation_beside_path(problem, solution) {
        Some(rotation) => {
            // The duration follows the words for the way, so the word "round" is omitted.
            let way = round.trim_end_matches(" round");
            format!("{rotation:.1} deg{moved}, {way} by {turned:.1} deg, in {duration} s{sought}, {steps}")
        }
        None => format!("{turned:.1} deg{moved}, {round}, in {duration} s{sought}, {steps}"),
    }
}

/// Returns the line about the cost: its value with the unit, and its ratio to the cost of a
/// fixed-axis slew.
fn cost(problem: &Problem, solution: &Solution, identity: &Identity) -> String {
    let (what, unit) = match &problem.objective {
        Objective::Time => ("minimum time", "s"),
        Objective::Fuel(_) => ("minimum fuel", inputs::fuel_unit(problem, identity)),
        Objective::Effort(weights) => {
            let plain = weights.torque.is_none() && problem.motion == Motion::Attitude;
            // If the effort has weights, its unit depends on them and is not stated.
            ("minimum effort", if plain { "N²·m²·s" } else { "" })
        }
    };
    let value = significant(solution.cost, 6);
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let price = problem.objective.given_time_price();
    let timed = price.map_or(String::new(), |_| ", with the price of time".into());
    let mut text = format!("{value}{unit}, {what}{timed}");
    if matches!(problem.path, Path::Best | Path::Shortest) {
        text.push_str(&against(problem, solution));
    }
    text
}

/// Compares the cost with the cost of a fixed-axis slew. Returns an empty text if the latter is
/// unknown.
fn against(problem: &Problem, solution: &Solution) -> String {
    let Some(fixed) = fixed_axis::cost(problem, solution) else { return String::new() };
    let part = solution.cost / fixed - 1.0;
    // The minimum-time fixed-axis slew respects the limits, but the minimum-effort fixed-axis slew
    // is computed without limits.
    let free = problem.objective != Objective::Time && problem.is_constrained();
    let limits = if free { " without limits" } else { "" };
    match part {
        part if !part.is_finite() => String::new(),
        part if part.abs() < SAME => format!("; equal to a fixed-axis turn{limits}"),
        part => {
            let word = if part > 0.0 { "above" } else { "below" };
            format!("; {} % {word} a fixed-axis turn{limits}", significant(100.0 * part.abs(), 2))
        }
    }
}

/// Describes the terminal error of the continuous motion.
fn arrives(problem: &Problem, settings: &Settings, found: &Verification) -> Vec<String> {
    let off = |value: f64, unit: &str| match value {
        value if value.is_finite() => format!("{} {unit}", significant(value, 2)),
        _ => format!("? {unit}"),
    };
    let rate = off(found.continuous_rate_rad_s.to_degrees(), "deg/s");
    let open = problem.ends_in_any_attitude();
    let attitude = off(found.continuous_attitude_rad.to_degrees(), "deg");
    let mut lines = Vec::new();
    if let (Some(position), Some(velocity)) = (found.continuous_position_m, found.continuous_velocity_m_s) {
        let (position, velocity) = (off(position, "m"), off(velocity, "m/s"));
        let attitude = if open { String::new() } else { format!("{attitude}, ") };
        lines.push(format!("{attitude}{rate}, {position} and {velocity} off, in the true motion"));
    } else if open {
        lines.push(format!("{rate} off, in the true motion"));
    } else {
        lines.push(format!("{attitude} and {rate} off, in the true motion"));
    }
    let accuracy = Accuracy::of(found, problem, settings.continuous_limit());
    let missed = accuracy.continuous_attitude_deg;
    if missed > accuracy.wanted_deg {
        let wanted = short(accuracy.wanted_deg);
        lines.push(match accuracy.steps {
            Some(steps) => format!("more than {wanted} deg: {steps} steps would suffice"),
            None => format!("more than {wanted} deg, for any number of steps"),
        });
    }
    lines
}

/// Returns the line about the largest angular rate and its limit. If the rate is limited, it is the
/// rate of the continuous motion.
fn rate(problem: &Problem, found: &Verification) -> String {
    let peak = format!("{} deg/s", significant(found.peak_rate_rad_s.to_degrees(), 3));
    let limits = problem.constraints.iter().filter(|limit| !matches!(limit.rule, Rule::Pointing(_)));
    let told: Vec<String> = limits
        .filter_map(|limit| {
            let margin = found.margins.iter().find(|margin| margin.name == limit.name)?;
            let bound = match (&limit.rule, margin.at.strip_prefix("axis ")) {
                (Rule::RateNorm(limit), _) => *limit,
                (Rule::RateAxes(limits), axis) => {
                    let axis = ["x", "y", "z"].iter().position(|name| Some(*name) == axis);
                    limits[axis.unwrap_or(0)]
                }
                (Rule::Pointing(_), _) => return None,
            };
            let bound = bound.to_degrees();
            let part = percent(1.0 - margin.met() / bound);
            let axis =
                if margin.at.is_empty() { String::new() } else { format!(" about {}", &margin.at[5..]) };
            Some(format!("{part} of {}{axis} at {} s", short(bound), short(margin.time_s)))
        })
        .collect();
    if told.is_empty() { format!("{peak} at most") } else { format!("{peak} at most; {}", told.join(", ")) }
}

/// Returns at most `room` lines about clearances, in increasing order. The smallest clearance is
/// always reported.
fn clearances(
    problem: &Problem,
    solution: &Solution,
    found: &Verification,
    identity: &Identity,
    room: usize,
) -> Vec<String> {
    let is_cone = |margin: &&Margin| {
        let rule = problem.constraints.iter().find(|constraint| constraint.name == margin.name);
        rule.is_some_and(|constraint| matches!(constraint.rule, Rule::Pointing(_)))
    };
    let mut cones: Vec<&Margin> = found.margins.iter().filter(is_cone).collect();
    cones.sort_by(|a, b| a.met().total_cmp(&b.met()));
    let told = |margin: &&Margin| {
        let left = margin.met();
        let name = clipped(&escape(&margin.name), 30);
        let name = match boresight::of_margin(problem, identity, margin) {
            Some(boresight) => format!("{name} ({})", clipped(&escape(&boresight), 30)),
            None => name,
        };
        let along =
            solution.active.iter().any(|active| active.name == margin.name && active.time_s.len() > 1);
        let at = format!("at {} s", short(margin.time_s));
        match left {
            left if left < 0.0 => format!("{name}: {} deg too near {at}", significant(-left, 2)),
            left => {
                // A cone that was tightened for the continuous motion is touched only within the
                // tolerance of the tightening.
                let spare = if left < LITTLE {
                    format!("less than {LITTLE} deg")
                } else {
                    format!("{} deg", significant(left, 3))
                };
                let along = if along { ", along the cone" } else { "" };
                format!("{name}: {spare} to spare{along} {at}")
            }
        }
    };
    if cones.len() <= room {
        return cones.iter().map(told).collect();
    }
    let mut lines: Vec<String> = cones.iter().take(room.saturating_sub(1).max(1)).map(told).collect();
    if lines.len() < room {
        lines.push(format!("{} more with more clearance", counted(cones.len() - lines.len(), "cone")));
    }
    lines
}

/// Describes the proof of optimality, in the words of [`Proved`].
pub(super) fn proof(problem: &Problem, solution: &Solution) -> String {
    let Some(proved) = solution.proved(problem) else { return String::new() };
    let words = proved.words();
    let others = "others may cost less";
    match proved {
        Proved::Global => format!("{words}: the body is already in its end attitude"),
        Proved::Feasible => {
            format!("{words}: the arcs meet the end, and the optimum of this grid was not found")
        }
        Proved::Saddle if matches!(problem.path, Path::AsGiven(_)) => {
            format!("{words}: another rotation than the given one costs less")
        }
        Proved::Saddle => format!("{words}: the cost decreases in a direction, and no better plan was found"),
        Proved::Extremal if solution.optimality.second_order() == SecondOrder::NotTested => {
            format!("{words}: not tested, as requested; {others}")
        }
        Proved::Extremal | Proved::Minimum => format!("{words}; {others}"),
        Proved::FirstOrder => format!("{words}{}; {others}", neighbours(solution)),
    }
}

/// Describes the gap of a local minimum: the cost that neighbouring plans can save, to first order.
fn neighbours(solution: &Solution) -> String {
    let Some(switching) = &solution.switching else { return String::new() };
    if switching.structure == Structure::Pulses {
        let without = switching.pulses.map_or(f64::NAN, |pulses| pulses.cost_without);
        let more = 100.0 * (switching.continuous_cost / without - 1.0);
        return format!(", {} % above the best found without a minimum pulse width", significant(more, 2));
    }
    match 100.0 * solution.gap_part() {
        small if small < LEAST_GAP => String::new(),
        part => format!(", within {} % of its neighbours", significant(part, 2)),
    }
}

/// Returns the phrase for the homotopy class of a path: "the short way" or "the long way".
fn way(problem: &Problem, sense: Sense) -> &'static str {
    match sense {
        _ if problem.ends_in_any_attitude() => "to an attitude chosen by the plan",
        _ if problem.aim().is_some_and(|aim| aim.has_roll()) => "to a roll chosen by the plan",
        Sense::Short => "the short way round",
        Sense::Long => "the long way round",
    }
}

/// Describes the other extremals that the search found; `None` if it found none.
fn also(problem: &Problem, solution: &Solution) -> Option<String> {
    let best = solution.landing.as_ref().map_or(solution.cost, |landing| landing.cost_before);
    let nearest = solution.rivals.first()?;
    let round = way(problem, nearest.sense);
    // Switching times alone do not determine the path.
    let way = if solution.switching.is_some() && !problem.is_shaped() {
        "another way".into()
    } else {
        format!("{:.1} deg, {round}", nearest.turned_deg)
    };
    let unit = match problem.objective {
        Objective::Time => " s",
        _ => "",
    };
    let cost = format!("{}{unit}", significant(nearest.cost, 4));
    let against = match nearest.cost / best {
        // If the plan has zero cost, the cost of a rival cannot be given as a ratio, and its value
        // is stated.
        part if !part.is_finite() => format!("at {cost}"),
        part if part >= 10.0 => format!("at {} times the cost ({cost})", significant(part, 3)),
        part if part > 1.0 + SAME => format!("at {} % more ({cost})", significant(100.0 * (part - 1.0), 2)),
        part if part < 1.0 - SAME => format!("at {} % less ({cost})", significant(100.0 * (1.0 - part), 2)),
        _ => format!("at nearly the same cost ({cost})"),
    };
    let others = match solution.rivals.len() - 1 {
        0 => String::new(),
        more => format!("; {more} more"),
    };
    Some(format!("{way} {against}{others}"))
}
