//! Sentences and tables of a report: the proof of optimality, the checks, the margins, the rivals.

use super::Subject;
use super::arcs;
use super::boresight;
use super::summary::firings::{Firing, firings, listed};
use super::summary::inputs::scale;
use crate::draw::Span;
use slewkit::maneuver::{ContinuousGap, Outcome, Path, Proved, SecondOrder, Sense, Structure, Switching};
use slewkit::numerics::figures::{error, significant};
use slewkit::plan::Status;
use slewkit::verify::{Margin, Verification};

/// A table of a page, with its heading and its rows.
pub(super) struct Table {
    pub title: &'static str,
    pub head: Vec<&'static str>,
    pub rows: Vec<Vec<String>>,
    pub remark: &'static str,
}

/// Returns sentences on what is proved about the plan, the most important first.
pub(super) fn proved(subject: &Subject) -> Vec<String> {
    let solution = &subject.plan.solution;
    let mut told = Vec::new();
    match subject.plan.status {
        Status::Infeasible => {
            let reason = solution.infeasible.as_ref().map_or("", |proof| &proof.reason);
            told.push(format!("No plan exists, and this is proved: {reason}."));
            return told;
        }
        _ if solution.outcome != Outcome::Converged => {
            told.push("Nothing is proved: no extremal was found, but one may exist.".into());
            told.extend(solution.shortfall.iter().map(|text| format!("Nearest: {text}.")));
            return told;
        }
        Status::Solved => told.push("Every check of the independent witnesses passes.".into()),
        Status::VerificationFailed => {
            told.push("A witness disagrees: do not use the plan. See the checks.".into());
        }
        _ => told.push("The verification of the plan is incomplete.".into()),
    }
    if let Some(found) = &subject.plan.verification {
        told.extend(witnessed(found, solution.trajectory.target.is_some()));
    }
    told.extend(solution.switching.as_ref().and_then(extremal));
    let work = solution.interior.as_ref().filter(|_| solution.switching.is_none());
    told.extend(work.and_then(|work| work.continuous_gap.as_ref()).map(between_nodes));
    told.push(minimum(subject));
    told
}

/// Describes the first-order optimality certificate of a plan that consists of arcs; `None` if it
/// has no certificate.
fn extremal(switching: &Switching) -> Option<String> {
    let gap = error(100.0 * switching.gap / switching.continuous_cost);
    match switching.structure {
        Structure::Rest => None,
        Structure::AlongLimits => Some(
            "The continuous extremal meets the maximum principle: every input is always at the limit \
            that its switching function selects, or holds an active constraint."
                .into(),
        ),
        Structure::BangBang | Structure::BangOffBang => Some(
            "The continuous extremal meets the maximum principle: every input is always at the limit \
            that its switching function selects."
                .into(),
        ),
        Structure::Singular if !switching.arcs.is_empty() => Some(
            "The continuous extremal meets the maximum principle: every input is at the limit that its \
            switching function selects, or within its limits where that is zero, and has its mean there."
                .into(),
        ),
        Structure::TruncatedChattering | Structure::Singular => Some(format!(
            "The continuous extremal meets the maximum principle except on singular arcs, which are \
            replaced by pulses or smoothed: a gain of {gap} % of the cost is possible, to first \
            order."
        )),
        Structure::Pulses => Some(format!(
            "Every input is off or at a limit, in pulses of at least the requested length. No nearby \
            pulse times cost less. Without a minimum pulse width the cost is {:.2} % less.",
            100.0 * switching.gap / switching.continuous_cost
        )),
        Structure::Norm => Some(format!(
            "The torque of the continuous extremal follows the maximum principle: a gain of {gap} % \
            of the cost is possible, to first order."
        )),
    }
}

/// Describes the optimality gap of a plan on a uniform grid with respect to the continuous problem,
/// and states whether the optimum is unique.
fn between_nodes(found: &ContinuousGap) -> String {
    let saved = format!(
        "The costates of the grid, taken between its nodes, show that a neighbouring plan whose inputs \
        switch at any time costs at most {} less, to first order.",
        error(found.gap)
    );
    if found.undetermined.is_empty() {
        return saved;
    }
    format!("{saved} To first order the cost does not depend on some inputs: the optimum need not be unique.")
}

/// Describes the results of the witnesses, one line each. The continuous motion is first if `lands`
/// is true, otherwise the discrete motion.
fn witnessed(found: &Verification, lands: bool) -> Vec<String> {
    let mut told = Vec::new();
    if lands {
        told.push(format!(
            "The true motion under the recorded inputs, held over each step, ends {} deg from the \
            requested attitude, by an integrator that is independent of the planner.",
            significant(found.continuous_attitude_rad.to_degrees(), 3)
        ));
    }
    let target = if lands { "the target that was shifted for it" } else { "the requested attitude" };
    told.push(format!(
        "The discrete motion under the recorded inputs, propagated by other equations than the \
        planner's, ends {} rad from {target}.",
        error(found.discrete_attitude_rad)
    ));
    if found.continuous_attitude_rad.is_finite() && !lands {
        told.push(format!(
            "The continuous motion under these inputs, held over each step, ends {} deg from it. \
            This is the error of the discretisation; more steps reduce it.",
            significant(found.continuous_attitude_rad.to_degrees(), 3)
        ));
    }
    let held = found.margins.iter().filter(|margin| margin.holds()).count();
    if !found.margins.is_empty() {
        told.push(if held == found.margins.len() {
            let motion = if lands && found.passed() {
                "The true motion, like the discrete one,"
            } else {
                "The discrete motion"
            };
            format!("{motion} keeps {}, at the nodes and between them.", all_of(held))
        } else {
            format!("The discrete motion keeps {held} of {} limits and constraints.", found.margins.len())
        });
    }
    told
}

fn all_of(count: usize) -> String {
    if count == 1 {
        "its one limit or constraint".into()
    } else {
        format!("all {count} limits and constraints")
    }
}

/// Returns the sentence that states what is proved about the optimality of the plan.
fn minimum(subject: &Subject) -> String {
    let solution = &subject.plan.solution;
    let Some(proved) = solution.proved(subject.problem) else { return String::new() };
    let what = format!("The plan is {}", proved.words());
    let given = matches!(subject.problem.path, Path::AsGiven(_));
    match proved {
        Proved::Global => format!("{what}: the body is already where it should be."),
        Proved::Minimum | Proved::FirstOrder => format!(
            "{what}: no neighbouring plan costs less, {}. No proof shows that it is the cheapest of all: \
            rivals are the other plans that the search found.",
            if proved == Proved::Minimum { "to second order" } else { "except for the gap" }
        ),
        Proved::Extremal if solution.optimality.second_order() == SecondOrder::NotTested => {
            format!("{what}: this was not tested, as the spec requests.")
        }
        Proved::Extremal => format!("{what}: the test is undecided."),
        Proved::Saddle if given => format!(
            "{what}: the cost decreases in some direction. It is kept because the spec gives the rotation."
        ),
        Proved::Saddle => {
            format!("{what}: the cost decreases in some direction, and no cheaper plan was found there.")
        }
        Proved::Feasible => format!("{what}: the optimum of this grid was not found."),
    }
}

/// Returns the tables of checks, margins, rivals, thruster firings and arcs. A table that would be
/// empty is omitted.
pub(super) fn tables(subject: &Subject) -> Vec<Table> {
    let mut tables = vec![firings_told(subject), arcs_told(subject), rivals(subject)];
    if let Some(found) = &subject.plan.verification {
        if !found.margins.is_empty() {
            tables.push(margins(subject, found));
        }
        tables.push(checks(found));
    }
    tables.retain(|table| !table.rows.is_empty());
    tables
}

/// Returns the table of the on-times of each thruster.
fn firings_told(subject: &Subject) -> Table {
    let found = firings(subject.problem, &subject.plan.solution);
    let row = |firings: &[Firing]| {
        let on: f64 = firings.iter().map(Firing::length).sum();
        let shortest = firings.iter().map(Firing::length).fold(f64::INFINITY, f64::min);
        vec![
            subject.input_name(firings[0].input),
            listed(firings).join(", "),
            firings.len().to_string(),
            significant(on, 4),
            significant(shortest, 4),
        ]
    };
    Table {
        title: "Firings",
        head: vec!["thruster", "on, s", "firings", "on in all, s", "shortest, s"],
        rows: found.chunk_by(|a, b| a.input == b.input).map(row).collect(),
        remark: "Thrusters without a row stay off.",
    }
}

/// Returns the table of the arcs of the extremal in continuous time. It has no rows if the plan has
/// no arcs.
fn arcs_told(subject: &Subject) -> Table {
    let switching = subject.plan.solution.switching.as_ref();
    let arcs = switching.map_or(&[][..], |switching| &switching.arcs);
    let row = |(index, span): (usize, Span)| {
        let arc = &arcs[index];
        let ends = arc.input_at(arc.end_s);
        let named = |(input, value): (usize, &f64)| {
            let (scale, _) = scale(subject.problem, subject.identity, input);
            let [first, last] = [*value, ends[input]].map(|value| significant(value / scale, 4));
            let told = if first == last { first } else { format!("{first} to {last}") };
            (*value != 0.0 || ends[input] != 0.0).then(|| format!("{} {told}", subject.input_name(input)))
        };
        let inputs: Vec<String> = arc.input.iter().enumerate().filter_map(named).collect();
        let inputs = match inputs.is_empty() {
            true if span.label == "coast" => "all off".into(),
            true if !arc.holds.is_empty() => format!("along {}", arc.holds.join(", ")),
            true => "full norm, turns".into(),
            false => inputs.join(", "),
        };
        let number = |value: f64| significant(value, 8);
        let length = significant(span.to - span.from, 5);
        vec![(index + 1).to_string(), span.label, number(span.from), number(span.to), length, inputs]
    };
    let unit = match scale(subject.problem, subject.identity, 0).1 {
        "N" => "inputs, N",
        _ => "inputs, N·m",
    };
    let spans = if arcs.is_empty() { Vec::new() } else { arcs::arcs(subject) };
    Table {
        title: "Arcs",
        head: vec!["arc", "", "from, s", "to, s", "length, s", unit],
        rows: spans.into_iter().enumerate().map(row).collect(),
        remark: "These are arcs of the continuous extremal. The plan is the optimum of its own grid, and \
         differs by the square of the step.",
    }
}

fn rivals(subject: &Subject) -> Table {
    let solution = &subject.plan.solution;
    let open = subject.problem.ends_in_any_attitude();
    let way = |sense: Sense| match sense {
        _ if open => "any",
        Sense::Short => "short",
        Sense::Long => "long",
    };
    let points = |points: Option<usize>| points.map_or("not counted".into(), |count| count.to_string());
    let row = |what: &str, start: &str, sense, turned, cost: f64, count| {
        let cells = [what, start, way(sense), &significant(turned, 4), &significant(cost, 6), &points(count)];
        cells.map(String::from).to_vec()
    };
    let mut rows = Vec::new();
    if solution.outcome == Outcome::Converged {
        let count = solution.optimality.conjugate_points;
        rows.push(row(
            "this plan",
            &solution.start,
            solution.sense,
            solution.turned_deg,
            solution.cost,
            count,
        ));
        let rival = |rival: &slewkit::maneuver::Rival| {
            row("rival", &rival.start, rival.sense, rival.turned_deg, rival.cost, rival.conjugate_points)
        };
        rows.extend(solution.rivals.iter().map(rival));
    }
    Table {
        title: "Rivals",
        head: vec![
            "",
            "found from",
            "way round",
            "turned, deg",
            "cost",
            "directions of decrease (conjugate points)",
        ],
        rows,
        remark: "Other extremals of these ends that the search found; more may exist.",
    }
}

fn margins(subject: &Subject, found: &Verification) -> Table {
    let row = |margin: &Margin| {
        let is_zero = margin.scaled.abs() <= Margin::ROUND_OFF;
        let discrete = || if is_zero { "0".into() } else { significant(margin.margin, 3) };
        let discrete = margin.continuous_margin.map_or(String::new(), |_| discrete());
        let verdict = if margin.holds() { "holds" } else { "violated" };
        vec![
            margin.name.clone(),
            verdict.into(),
            significant(margin.met(), 3),
            discrete,
            margin.unit.clone(),
            significant(margin.time_s, 4),
            named(subject, margin),
        ]
    };
    Table {
        title: "Margins",
        head: vec!["limit or constraint", "", "margin", "discrete motion", "unit", "least at, s", "of"],
        rows: found.margins.iter().map(row).collect(),
        remark: "Negative means violated. The margin is that of the true motion under the held inputs; that of \
         the discrete motion differs by the error of the discretisation.",
    }
}

/// Returns the name of a limited quantity, in which an input or boresight has its name in the spec,
/// if it has one.
fn named(subject: &Subject, margin: &Margin) -> String {
    if let Some(input) = margin.input(subject.problem) {
        return subject.input_name(input);
    }
    boresight::of_margin(subject.problem, subject.identity, margin).unwrap_or_else(|| margin.at.clone())
}

fn checks(found: &Verification) -> Table {
    let row = |check: &slewkit::verify::Check| {
        let verdict = if check.passed { "✓ holds" } else { "✗ fails" };
        vec![check.name.clone(), verdict.into(), significant(check.value, 3), significant(check.limit, 3)]
    };
    Table {
        title: "Checks of the witnesses",
        head: vec!["check", "", "value", "limit"],
        rows: found.checks.iter().map(row).collect(),
        remark: "The order of convergence must be at least its limit, every other value at most its limit. \
         Angles are in radians.",
    }
}
