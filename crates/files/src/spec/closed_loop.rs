//! Reading of `[feedback]`, `[uncertainty]`, `[plant]` and the chance constraints: the data for
//! simulated flights of a plan.

mod chances;
mod uncertain;

pub use chances::Chance;

use super::{Node, Section, Value, short, show, stops};
use serde_json::Map;
use slewkit::assured::{Feedback, Kept, Over};
use slewkit::closed_loop::Plant;
use slewkit::feedback::{Kind, RegulatorWeights, SwitchingGains};
use slewkit::maneuver::{Motion, Problem, Stepping};
use slewkit::mechanics::AxisFrame;
use slewkit::optimize::discrete::linear_plan::{PosedPlan, Unlinearised};
use slewkit::uncertainty::Uncertainty;

/// Feedback, uncertainty, plant model and chance constraints of a spec. A part is empty if the spec
/// does not have it.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ClosedLoop {
    /// Feedback gains that are requested along the plan.
    pub feedback: Option<Feedback>,
    /// Uncertain quantities with their distributions; `None` if the spec has no `[uncertainty]`.
    pub uncertainty: Option<Uncertainty>,
    /// Model of the actuators and the controller.
    pub plant: Plant,
    /// Chance constraints: the probabilities with which limits may be violated.
    pub chances: Vec<Chance>,
    /// Contents of the sections as they are written in the spec, by section name.
    written: Map<String, serde_json::Value>,
}

impl ClosedLoop {
    /// Returns the contents of the sections as they are written in the spec, by section name.
    pub(crate) fn written(&self) -> &Map<String, serde_json::Value> {
        &self.written
    }

    /// Returns the names of the sections that the spec has, such as "feedback".
    pub fn sections(&self) -> impl Iterator<Item = &str> {
        self.written.keys().map(String::as_str)
    }

    /// Returns the chance constraint of the limit `name` alone; `None` if it has only a joint one
    /// or none.
    pub fn asked(&self, name: &str) -> Option<&Chance> {
        self.chances.iter().find(|chance| !chance.is_joint && chance.limits.iter().any(|limit| limit == name))
    }

    /// Returns the uncertainty and the chance constraints, with which [`slewkit::assured::plan`]
    /// plans the maneuver. Returns `None` if the spec lacks either of them.
    pub fn kept(&self) -> Option<(&Uncertainty, Vec<Kept<'_>>)> {
        let uncertainty = self.uncertainty.as_ref().filter(|_| !self.chances.is_empty())?;
        let all = self.chances.iter().map(|chance| {
            let over = if chance.of_motion { Over::Motion(self.plant) } else { Over::Instant };
            let limits = chance.limits.iter().map(String::as_str).collect();
            Kept { limits, at_most: chance.at_most, over }
        });
        Some((uncertainty, all.collect()))
    }

    /// Returns whether the spec requests gains or covariances along the plan.
    pub fn is_asked(&self) -> bool {
        self.feedback.is_some() || self.uncertainty.is_some()
    }
}

/// Reads the sections, and adds the reserves of the limits to the maneuver. Errors are added to the
/// report.
pub(crate) fn read(root: &Section, tree: &Node, problem: &mut Problem) -> ClosedLoop {
    let sections = ["feedback", "uncertainty", "plant"];
    if let Some(section) = root.section("uncertainty")
        && let Some(cause) = unsuited(problem)
    {
        let remedy = "remove [uncertainty]: the plan itself does not need it";
        section.error_here("E0170", cause.to_string(), remedy);
    }
    let turns = PosedPlan::is_of(problem)
        && (problem.actuation.wheels.is_some() || problem.actuation.thrusters.is_some());
    if let (Some(section), true) = (root.section("feedback"), turns) {
        let remedy = "remove [feedback]: the plan itself does not need it";
        section.error_here("E0170", Unlinearised::Thrusters.to_string(), remedy);
    }
    let uncertainty = root.section("uncertainty").map(|section| uncertain::uncertainty(section, problem));
    let chances = chances::chances(root, problem, uncertainty.is_some());
    let has_stops = stops::has_stops(root);
    if has_stops && !chances.is_empty() {
        let reason = "chances of limits need a single maneuver, but this spec has stops";
        let remedy = "give margins instead of the chances, or plan each leg separately";
        root.error("E0172", "stop", reason, remedy);
    }
    chances::hold(root, problem);
    // Gains, ticks and covariances need equal steps, with which every constraint can be met. The
    // legs of a sequence are flown with their own steps.
    if !has_stops && problem.is_shaped() && (root.has("feedback") || root.has("uncertainty")) {
        problem.stepping = Stepping::Equal;
    }
    let mut written = Map::new();
    for name in sections {
        if let (true, Some(entry)) = (root.has(name), tree.entry(name)) {
            written.insert(name.into(), json(&entry.node));
        }
    }
    let feedback = root.section("feedback").and_then(|section| {
        if has_stops {
            return feedback_of_sequence(section, problem);
        }
        let (kind, every) = (feedback(section, problem, root.has("uncertainty")), every(section, problem));
        Some(Feedback { kind: kind?, every: every? })
    });
    let step = step(problem).filter(|_| !has_stops);
    ClosedLoop {
        feedback,
        uncertainty,
        plant: root.section("plant").map(|section| plant(section, step)).unwrap_or_default(),
        chances,
        written,
    }
}

/// Returns the step of the plan \[s\]; `None` if the spec does not determine it.
fn step(problem: &Problem) -> Option<f64> {
    let duration = problem.duration.known().filter(|_| !problem.chooses_steps && !problem.switches())?;
    Some(duration / problem.steps as f64)
}

/// Largest relative deviation of a ratio of times from a whole number.
const WHOLE: f64 = 1e-6;

fn is_whole(number: f64) -> bool {
    number >= 1.0 - WHOLE && (number - number.round()).abs() <= WHOLE * number
}

/// Returns the interval between two corrections of the controller \[s\]; 0 stands for the step of
/// the plan. Returns `None` after an error was reported.
fn every(section: &Section, problem: &Problem) -> Option<f64> {
    if !section.has("every_s") {
        return Some(0.0);
    }
    let every = section.number("every_s")?;
    let Some(duration) = problem.duration.known().filter(|_| !problem.switches()) else {
        let reason =
            "`every_s` must be a whole number of steps, but the duration is free, so the step is unknown";
        return section.refuse("E0176", "every_s", reason, "remove the key, to measure in every step");
    };
    if let Some(step) = step(problem) {
        if is_whole(every / step) && every <= duration * (1.0 + WHOLE) {
            return Some(every);
        }
        let reason = format!("{} s is not a whole number of steps of {} s", show(every), show(step));
        return section.refuse("E0176", "every_s", reason, remedy_of(every, duration));
    }
    let reason = "`every_s` must be a whole number of steps, but the plan chooses the number of steps";
    section.refuse("E0176", "every_s", reason, remedy_of(every, duration))
}

/// Returns the remedy that proposes a number of steps, about a hundred, with which the interval
/// `every` \[s\] is a whole number of steps.
fn remedy_of(every: f64, duration: f64) -> String {
    /// Default number of steps of a plan.
    const STEPS: f64 = 100.0;
    let ticks = duration / every;
    if !is_whole(ticks) {
        return format!("give a tick so that {} s is a whole number of ticks", show(duration));
    }
    let ticks = ticks.round();
    format!(
        "write maneuver.steps = {}, which are {} for each tick",
        (STEPS / ticks).ceil() * ticks,
        (STEPS / ticks).ceil()
    )
}

/// Returns the reason why the motion of this maneuver cannot be linearised; `None` if it can.
fn unsuited(problem: &Problem) -> Option<Unlinearised> {
    if problem.motion == Motion::RigidBody {
        return Some(Unlinearised::Translation);
    }
    (problem.actuation.torque.frame() == AxisFrame::Reference).then_some(Unlinearised::Frame)
}

/// Reads the feedback of a sequence, which is one regulator along all legs and holds.
fn feedback_of_sequence(section: &Section, problem: &Problem) -> Option<Feedback> {
    if section.has("kind") && section.word("kind")? != "tvlqr" {
        let reason = "gains of this kind are not supported for a sequence: it needs a regulator";
        return section.refuse("E0171", "kind", reason, "write kind = \"tvlqr\", or remove the key");
    }
    if section.has("every_s") {
        let reason = "`every_s` is not supported for a sequence, because each leg has another step";
        return section.refuse("E0176", "every_s", reason, "remove the key, to measure in every step");
    }
    let flown = Problem { stepping: Stepping::Recorded, ..problem.clone() };
    Some(Feedback::from(feedback(section, &flown, false)?))
}

fn feedback(section: &Section, problem: &Problem, uncertain: bool) -> Option<Kind> {
    let has_wheels = problem.actuation.wheels.is_some();
    let default = if problem.switches() || has_wheels { "tvlqr" } else { "neighbouring" };
    let kind = if section.has("kind") { section.word("kind")? } else { default };
    let weights = ["attitude_weight", "rate_weight", "end_weight"];
    if kind == "neighbouring" {
        if problem.switches() {
            let reason = format!(
                "if the objective is {}, inputs switch between their limits: neighbouring gains do \
                not exist, because a neighbour has other switching times",
                problem.objective.name()
            );
            return section.refuse("E0171", "kind", reason, "write kind = \"tvlqr\"");
        }
        if let Some(key) = weights.iter().find(|key| section.has(key)) {
            let reason = format!(
                "`{key}` is a weight of the regulator, but neighbouring gains use the cost of the plan"
            );
            return section.refuse("E0171", key, reason, "write kind = \"tvlqr\", or remove the key");
        }
        return Some(Kind::Neighbouring { freeze: section.number("freeze").unwrap_or(Kind::FREEZE) });
    }
    if kind == "switching" {
        if let Err(cause) = SwitchingGains::suits(problem) {
            return section.refuse("E0171", "kind", cause.to_string(), "write kind = \"tvlqr\"");
        }
        if uncertain {
            let reason = "switching times are corrected once, at the start: their covariances and flights are not \
             supported";
            let remedy = "write kind = \"tvlqr\", or remove [uncertainty]";
            return section.refuse("E0171", "kind", reason, remedy);
        }
    }
    if let (Some(key), true) =
        (weights.iter().find(|key| section.has(key)), problem.motion == Motion::RigidBody)
    {
        let reason = format!("`{key}` does not weight position and velocity, which the regulator also needs");
        return section.refuse("E0171", key, reason, "remove the key: the regulator has default weights");
    }
    if section.has("freeze") {
        let reason = "`freeze` has no effect: only neighbouring gains are frozen";
        return section.refuse("E0171", "freeze", reason, "remove the key");
    }
    let of = |weights| if kind == "switching" { Kind::Switching(weights) } else { Kind::Tvlqr(weights) };
    let given = weights.map(|key| section.number(key));
    match given {
        [None, None, None] => Some(of(None)),
        [Some(attitude), Some(rate), end] => {
            let end = end.unwrap_or(RegulatorWeights::END);
            Some(of(Some(RegulatorWeights { attitude, rate, end })))
        }
        _ => {
            let reason = "only one of `attitude_weight` and `rate_weight` is given";
            section.refuse_here("E0171", reason, "give both weights, or neither")
        }
    }
}

/// Reads the plant model; `step` is the step of the plan \[s\], if the spec determines it.
fn plant(section: &Section, step: Option<f64>) -> Plant {
    let number = |key: &str| section.number(key).unwrap_or(0.0);
    let tick = number("tick_s");
    if let (true, Some(step)) = (tick > 0.0, step)
        && !is_whole(step / tick)
    {
        let reason = format!("a step of {} s is not a whole number of ticks of {} s", show(step), show(tick));
        let remedy = if tick > step {
            "remove it; for a controller with a longer period write [feedback] every_s".into()
        } else {
            format!("write tick_s = {}, or change the steps", short(step / (step / tick).ceil()))
        };
        section.error("E0176", "tick_s", reason, remedy);
    }
    Plant {
        lag: number("actuator_lag_s"),
        delay: number("delay_s"),
        quantum: number("torque_quantum_n_m"),
        tick,
        leads: section.word("feedforward") != Some("as_planned"),
        authority: section.number("authority").unwrap_or(1.0),
    }
}

/// Converts a value of the tree to JSON.
fn json(node: &Node) -> serde_json::Value {
    match &node.value {
        Value::Table(entries) => {
            entries.iter().map(|entry| (entry.key.clone(), json(&entry.node))).collect::<Map<_, _>>().into()
        }
        Value::Array(items) => items.iter().map(json).collect::<Vec<_>>().into(),
        Value::Text(text) => text.as_str().into(),
        Value::Number(number) => number.value.into(),
        Value::Boolean(value) => (*value).into(),
        Value::Date | Value::Null => serde_json::Value::Null,
    }
}
