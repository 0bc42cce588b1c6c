//! Comparison of the values recorded in a plan file with the values that follow from its plan.
//!
//! The values under `terminal`, `verified` and `accuracy` are compared with the results of the
//! witnesses. Arcs, pulses, costates and active limits are compared with the rows of the
//! trajectory. [`NOT_JUDGED`] lists the values that only a new search could check.
//!
//! # Which parts of a plan file does `verify` check?
//!
//! The comparison covers all values that follow from the plan. The witnesses check the trajectory,
//! and `export/recorded.rs` checks every recorded value, key by key:
//!
//! - terminal errors;
//! - all of `verified`, with its checks, margins and witnesses, and `accuracy`;
//! - cost, duration, angle turned and direction of rotation;
//! - costates at the start;
//! - arcs and pulses.
//!
//! Values may differ by the round-off of a long motion; limits must be equal. Values that only a
//! new search could check (`NOT_JUDGED`) are reported as not checked. A test changes every number,
//! word and list in files of ten kinds; each change must be reported, unless its key is in
//! `NOT_JUDGED`. Names and the epoch do not affect the verdict. Differences from another spec are
//! reported. The spec in the file is the question and not a result, so it is not checked: a plan
//! may also satisfy the limits of another spec.

use super::PlanFile;
use crate::spec::Difference;
use serde::Serialize;
use serde_json::Value;
use slewkit::maneuver::{
    Duration, Fuel, Method, Objective, Problem, Structure, Switching, SwitchingArc, Trajectory,
};
use slewkit::mechanics::{InputLimit, LimitKind};
use slewkit::verify::{self, Accuracy, Verification};

/// Largest number of steps by which an arc on a uniform grid may be shifted relative to the arc in
/// continuous time. The middle of a longer arc belongs to both arcs.
const BESIDE: f64 = 4.0;

/// Keys of a plan file that are not checked, because they describe the search and its optimality.
pub const NOT_JUDGED: [&str; 21] = [
    "generator",
    "iterations",
    "solve_time_s",
    "start",
    "landing.misses",
    "chosen",
    "landing.drawn_in",
    "landing.cost_before",
    "optimality",
    "ladder",
    "convex",
    "interior_point",
    "active",
    "switching.gap",
    "switching.eigenaxis_s",
    "switching.smoothing",
    "switching.beside_optimum",
    "switching.singular_inputs",
    "switching.pulses.cost_without",
    "rivals",
    "trajectory.costates",
];

/// Relative and absolute tolerances on a recorded value. A value that another machine computed may
/// differ by the round-off of a long motion.
const TOLD: f64 = 1e-6;
const ROUND_OFF: f64 = 1e-9;
/// Tolerance on the recorded order of convergence, which is computed from errors near round-off.
const ORDER: f64 = 0.01;
/// Largest relative margin at which a limit counts as active. The motion may touch an active limit
/// at many times, and round-off decides which of these times is recorded.
const ACTS: f64 = 1e-6;

/// Returns the recorded values that differ from the recomputed values. In each difference, the
/// value of the file is first.
pub(super) fn differences(
    file: &PlanFile<'_>,
    found: &Verification,
    problem: &Problem,
    continuous: Option<f64>,
) -> Vec<Difference> {
    let mut apart = Apart { found: Vec::new(), problem, trajectory: &file.trajectory.0 };
    let (terminal, discrete) = (&file.terminal, found.discrete());
    apart.near("terminal.attitude_rad", Some(terminal.attitude_rad), Some(discrete.attitude_rad));
    apart.near(
        "terminal.momentum_relative",
        Some(terminal.momentum_relative),
        Some(discrete.momentum_relative),
    );
    apart.near("terminal.position_relative", terminal.position_relative, discrete.position_relative);
    let linear = [terminal, &discrete].map(|error| error.linear_momentum_relative);
    apart.near("terminal.linear_momentum_relative", linear[0], linear[1]);
    if let Some(told) = &file.verified {
        apart.trees("verified", &tree(told), &tree(found));
        // `accuracy` is a function of the values that have been compared, so it must be equal to
        // the last bit.
        apart.exactly("accuracy", &file.accuracy, &Some(Accuracy::of(told, problem, continuous)));
    }
    let held = file.spec.as_ref().and_then(|spec| spec.read("the plan's spec", &[]).ok());
    if let Some(held) = held {
        apart.exactly("name", &file.name, &held.problem.name);
        if file.steps > 0 {
            apart.exactly("steps", &file.steps, &held.problem.steps);
        }
    }
    let first = &file.trajectory.0.costates;
    apart.exactly("costates_0", &file.costates_0, &first[..problem.dimension().min(first.len())].to_vec());
    match (&file.landing, file.trajectory.0.target) {
        (Some(landing), _) => {
            let corrections = landing.misses.len().saturating_sub(1);
            apart.exactly("landing.corrections", &landing.corrections, &corrections);
        }
        (None, Some(_)) => apart.tell("landing", &Value::Null, &"a target that was shifted"),
        (None, None) => {}
    }
    if ![Method::Shooting, Method::Scp, Method::InteriorPoint]
        .iter()
        .any(|method| method.name() == file.method)
    {
        apart.tell("method", &file.method, &"shooting, scp or interior_point");
    }
    match &file.switching {
        Some(switching) => apart.switching(switching),
        None if problem.switches() => apart.tell("switching", &Value::Null, &"inputs that switch"),
        None => {}
    }
    apart.found
}

fn tree(of: &impl Serialize) -> Value {
    serde_json::to_value(of).unwrap_or_default()
}

fn near(told: f64, found: f64) -> bool {
    told.is_nan() && found.is_nan() || (told - found).abs() <= ROUND_OFF + TOLD * found.abs()
}

/// Differences that have been found, with the data for the comparison.
struct Apart<'a> {
    found: Vec<Difference>,
    problem: &'a Problem,
    trajectory: &'a Trajectory,
}

impl Apart<'_> {
    fn tell(&mut self, key: &str, told: &impl Serialize, found: &impl Serialize) {
        let [first, second] = [tree(told), tree(found)].map(|value| value.to_string());
        self.found.push(Difference { key: key.into(), first, second });
    }

    fn exactly<T: Serialize + PartialEq>(&mut self, key: &str, told: &T, found: &T) {
        let [first, second] = [tree(told), tree(found)];
        // NaN becomes null in both trees.
        if first != second {
            self.tell(key, &first, &second);
        }
    }

    fn near(&mut self, key: &str, told: Option<f64>, found: Option<f64>) {
        let same = match (told, found) {
            (Some(told), Some(found)) => near(told, found),
            (told, found) => told.is_none() && found.is_none(),
        };
        if !same {
            self.tell(key, &told, &found);
        }
    }

    /// Compares every number and every text of two JSON trees.
    fn trees(&mut self, key: &str, told: &Value, found: &Value) {
        let last = key.rsplit('.').next().unwrap_or_default();
        match (told, found) {
            (Value::Number(first), Value::Number(second)) => {
                let [told_value, found_value] =
                    [first, second].map(|number| number.as_f64().unwrap_or(f64::NAN));
                let same = match last {
                    "order" => (told_value - found_value).abs() <= ORDER,
                    // The limit of a check does not depend on the motion and may be as small as
                    // round-off, so only a relative tolerance applies.
                    "limit" => (told_value - found_value).abs() <= TOLD * found_value.abs(),
                    _ => near(told_value, found_value),
                };
                if !same {
                    self.tell(key, told, found);
                }
            }
            (Value::Array(first), Value::Array(second)) => {
                if first.len() != second.len() {
                    let count = |of: usize| format!("{of} entries");
                    self.tell(key, &count(first.len()), &count(second.len()));
                }
                for (index, (first, second)) in first.iter().zip(second).enumerate() {
                    self.trees(&format!("{key}.{index}"), first, second);
                }
            }
            (Value::Object(first), Value::Object(second)) => {
                let acts =
                    second.get("scaled").and_then(Value::as_f64).is_some_and(|scaled| scaled.abs() <= ACTS);
                let of_order = second.get("name").and_then(Value::as_str) == Some("order");
                for name in first.keys().chain(second.keys().filter(|name| !first.contains_key(*name))) {
                    let [told, found] = [first, second].map(|map| map.get(name).cloned().unwrap_or_default());
                    let under = format!("{key}.{name}");
                    match name.as_str() {
                        "value" if of_order => self.order(&under, &told, &found),
                        "time_s" if acts && self.acts_at(second, &told) => {}
                        "at" if acts && is_one_of(&told, &found) => {}
                        _ => self.trees(&under, &told, &found),
                    }
                }
            }
            _ if told == found => {}
            _ => self.tell(key, told, found),
        }
    }

    fn order(&mut self, key: &str, told: &Value, found: &Value) {
        match (told.as_f64(), found.as_f64()) {
            (Some(first), Some(second)) if (first - second).abs() <= ORDER => {}
            (None, None) => {}
            _ => self.tell(key, told, found),
        }
    }

    /// Returns whether the limit of the active margin `margin` is also active at the node with the
    /// recorded time `time`.
    fn acts_at(&self, margin: &serde_json::Map<String, Value>, time: &Value) -> bool {
        let (Some(name), Some(time)) = (margin.get("name").and_then(Value::as_str), time.as_f64()) else {
            return false;
        };
        self.margin_at(name, time).is_some_and(|(value, largest)| value.abs() <= ACTS * largest)
    }

    /// Returns the margin of the limit `name` at the node with the time `time` \[s\], and the
    /// largest absolute margin over all nodes; `None` if no node has this time.
    fn margin_at(&self, name: &str, time: f64) -> Option<(f64, f64)> {
        let (problem, trajectory) = (self.problem, self.trajectory);
        let rows = problem.input_rows();
        let node = trajectory.time.iter().position(|at| near(time, *at))?;
        let inputs = |node: usize| (node < rows).then_some(node);
        let margins = verify::margins_at_nodes(problem, trajectory, inputs);
        let values = &margins.iter().find(|margin| margin.name == name)?.values;
        let largest = values
            .iter()
            .filter(|value| value.is_finite())
            .fold(0.0, |largest: f64, value| largest.max(value.abs()));
        Some((values[node], largest))
    }

    /// Compares the recorded arcs with the rows of the plan, and the values that follow from the
    /// arcs.
    fn switching(&mut self, told: &Switching) {
        if matches!(told.structure, Structure::BangBang | Structure::BangOffBang | Structure::AlongLimits) {
            // For arcs found from a plan on a uniform grid, the recorded gap is a numerical
            // residual and need not be exactly zero.
            let most = if self.problem.is_shaped() { TOLD * told.continuous_cost.abs() } else { 0.0 };
            if !(0.0..=most).contains(&told.gap) {
                self.tell("switching.gap", &told.gap, &0.0);
            }
        }
        if told.pulses.is_none() && self.problem.shortest_pulse().is_some() && self.problem.switches() {
            self.tell("switching.pulses", &Value::Null, &"pulses of a shortest length");
        }
        if told.arcs.is_empty() && told.smoothing.is_none() && told.structure != Structure::Rest {
            self.tell("switching.arcs", &told.arcs, &"inputs that are not smoothed");
        }
        if let Some(pulses) = told.pulses {
            let (count, shortest) = self.pulses();
            self.exactly("switching.pulses.count", &pulses.count, &count);
            self.near("switching.pulses.shortest_s", Some(pulses.shortest_s), Some(shortest));
            self.near("switching.gap", Some(told.gap), Some(told.continuous_cost - pulses.cost_without));
        }
        let Some(last) = told.arcs.last() else {
            // If the inputs are smoothed, the extremal in continuous time is not in the file.
            if let Duration::Given(duration) = self.problem.duration {
                let told = Some(told.continuous_duration_s);
                self.near("switching.continuous_duration_s", told, Some(duration));
            }
            return;
        };
        self.near("switching.continuous_duration_s", Some(told.continuous_duration_s), Some(last.end_s));
        let mut before = 0.0;
        for (index, arc) in told.arcs.iter().enumerate() {
            self.near(&format!("switching.arcs.{index}.start_s"), Some(arc.start_s), Some(before));
            before = arc.end_s;
        }
        self.constraints_of(told);
        // An arc with a saturated norm has no inputs in the file, because their direction changes.
        // The same applies to an arc along a constraint.
        let count = self.trajectory.input_count;
        let actuation = &self.problem.actuation;
        let turns =
            Fuel::is_of_norm(&actuation.torque) || actuation.force.as_ref().is_some_and(Fuel::is_of_norm);
        let held = |arc: &SwitchingArc| arc.input.is_empty() && (turns || !arc.holds.is_empty());
        let constant = told.arcs.iter().all(|arc| arc.input.len() == count || held(arc));
        if told.structure == Structure::Norm {
            return;
        }
        if !constant {
            self.tell("switching.arcs", &"arcs of other inputs", &self.trajectory.input_count);
            return;
        }
        // Inputs that share a norm limit switch together.
        let switches: usize = if turns {
            told.arcs.len() - 1
        } else {
            told.arcs.windows(2).map(|pair| pair[0].switches_to(&pair[1])).sum()
        };
        self.exactly("switching.switches", &told.switches, &switches);
        let whole = told.arcs.iter().all(|arc| arc.input.len() == count);
        if whole || self.problem.objective == Objective::Time {
            let cost = if whole { self.cost_of(&told.arcs) } else { last.end_s };
            self.near("switching.continuous_cost", Some(told.continuous_cost), Some(cost));
        }
        self.inputs_of(told);
    }

    /// Checks that each constraint named by an arc is a constraint of the maneuver, and that the
    /// recorded structure agrees with the arcs that follow constraints.
    fn constraints_of(&mut self, told: &Switching) {
        let known = |name: &String| {
            let constrained = self.problem.constraints.iter().any(|constraint| constraint.name == *name);
            // If the rates of the inputs are limited, the limits on the actuator outputs can also
            // be active along an arc.
            let of_state = |limit: &InputLimit| match limit.kind {
                LimitKind::WheelMomentum => true,
                LimitKind::Size => limit.set.limits().rate.is_some(),
                LimitKind::Norm | LimitKind::Rate => false,
            };
            let mut limits = self.problem.actuation.limits().filter(of_state);
            constrained || limits.any(|limit| limit.name == *name)
        };
        let unknown: Vec<String> = told
            .arcs
            .iter()
            .flat_map(|arc| arc.holds.iter().chain(&arc.touches))
            .filter(|name| !known(name))
            .cloned()
            .collect();
        for name in unknown {
            self.tell("switching.arcs", &name, &"constraints of the maneuver");
        }
        let held = told.arcs.iter().any(|arc| !arc.holds.is_empty());
        let chatters = told.structure == Structure::TruncatedChattering;
        if !chatters && held != (told.structure == Structure::AlongLimits) {
            self.tell("switching.structure", &told.structure, &"that of its arcs");
        }
    }

    /// Returns the cost of arcs whose inputs are recorded: the fuel, or the duration for minimum
    /// time.
    fn cost_of(&self, arcs: &[SwitchingArc]) -> f64 {
        let Some(fuel) = self.problem.objective.fuel() else {
            return arcs.last().map_or(0.0, |last| last.end_s);
        };
        arcs.iter()
            .map(|arc| (arc.end_s - arc.start_s) * fuel.rate(&self.problem.actuation, &arc.input))
            .sum()
    }

    /// Checks the inputs of every arc: the plan must have these inputs in the middle of the arc, or
    /// within a step of its ends. The switching times of the plan differ from the switching times
    /// of the arcs by the discretisation error.
    fn inputs_of(&mut self, told: &Switching) {
        // On a uniform grid, the inputs at the nodes are an optimum of the discrete problem; on the
        // arcs, the inputs are at their limits.
        let beside = self.problem.is_shaped();
        let times = &self.trajectory.time;
        let whole = times.last().copied().unwrap_or(f64::NAN) / told.continuous_duration_s;
        let steps = if beside { BESIDE } else { 1.0 };
        for (index, arc) in told.arcs.iter().enumerate() {
            let row_at = |time: f64| times.partition_point(|node| *node <= time * whole).max(1) - 1;
            let middle = 0.5 * (arc.start_s + arc.end_s);
            let row = row_at(middle);
            let Some(after) = times.get(row + 1) else { continue };
            // The plan may have no step within an arc that is shorter than a step, and arcs of
            // another grid are shifted.
            let elsewhere = steps * (after - times[row]) / whole;
            if arc.end_s - arc.start_s <= elsewhere || arc.input_at(middle).is_empty() {
                continue;
            }
            let same = |row: usize, arc: &SwitchingArc| {
                let Some(after) = times.get(row + 1) else { return false };
                let held = self.trajectory.inputs(row);
                let middle = (0.5 * (times[row] + after) / whole).max(arc.start_s).min(arc.end_s);
                let input = arc.input_at(middle);
                (0..held.len().min(input.len())).all(|index| {
                    let meanwhile = arc.change.get(index).map_or(0.0, |change| change.abs() * elsewhere);
                    // On a uniform grid, a chattering input may lie between its limits.
                    beside && told.singular_inputs.contains(&index)
                        || near(input[index], held[index])
                        || (input[index] - held[index]).abs() <= meanwhile
                })
            };
            // On a uniform grid, the inputs belong to the nodes. The next row is not compared,
            // because it may agree by chance if the inputs change linearly.
            let mut around = row_at(arc.start_s - elsewhere)..=row_at(arc.end_s + elsewhere);
            let neighbours = [index.checked_sub(1), Some(index + 1)].into_iter().flatten();
            let mut neighbours = neighbours.filter_map(|other| told.arcs.get(other));
            let mut shifted = || neighbours.any(|other| same(row, other)) && around.any(|row| same(row, arc));
            if !same(row, arc) && (beside || !shifted()) {
                let held = self.trajectory.inputs(row);
                self.tell(&format!("switching.arcs.{index}.input"), &arc.input_at(middle), &held);
            }
        }
    }

    /// Returns the number of pulses of all inputs, and the duration of the shortest pulse \[s\].
    fn pulses(&self) -> (usize, f64) {
        let (times, count) = (&self.trajectory.time, self.trajectory.input_count);
        let (mut pulses, mut shortest) = (0, f64::INFINITY);
        for input in 0..count {
            let mut on: Option<(bool, f64)> = None;
            let rows =
                times.windows(2).enumerate().map(|(row, ends)| (self.trajectory.inputs(row)[input], ends[0]));
            let end = times.last().map(|end| (0.0, *end));
            for (value, time) in rows.chain(end) {
                let side = (value != 0.0).then_some(value > 0.0);
                if side != on.map(|(side, _)| side) {
                    if let Some((_, since)) = on {
                        pulses += 1;
                        shortest = f64::min(shortest, time - since);
                    }
                    on = side.map(|side| (side, time));
                }
            }
        }
        (pulses, shortest)
    }
}

/// Returns whether two texts are equal except for their digits, such as "input 2" and "input 1".
fn is_one_of(told: &Value, found: &Value) -> bool {
    let form = |value: &Value| {
        value
            .as_str()
            .map(|text| text.split(|c: char| c.is_ascii_digit()).map(String::from).collect::<Vec<_>>())
    };
    told == found || form(told).is_some_and(|told| Some(told) == form(found))
}
