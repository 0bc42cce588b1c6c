//! `[feedback]`, `[uncertainty]`, `[plant]` and the chances of constraints: what a plan is flown with.

use super::{Limits, Node, Section, Value, escape};
use serde_json::Map;
use slewkit::assured::{Kept, Over};
use slewkit::closed_loop::Plant;
use slewkit::feedback::{Kind, RegulatorWeights, SwitchingGains};
use slewkit::maneuver::{Motion, Problem};
use slewkit::mechanics::AxisFrame;
use slewkit::optimize::linear_plan::{Matrix6, Parameter, PosedPlan, Unlinearised, Vector6};
use slewkit::uncertainty::Uncertainty;
use slewkit::{Matrix3, Vector3};

/// What a plan is flown with; nothing where the spec says nothing.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ClosedLoop {
    /// Gains along the plan.
    pub feedback: Option<Kind>,
    /// What the craft differs by.
    pub uncertainty: Option<Uncertainty>,
    /// How its actuators follow.
    pub plant: Plant,
    /// What chances constraints leave.
    pub chances: Vec<Chance>,
    /// The sections as they stand in the spec.
    written: Map<String, serde_json::Value>,
}

/// The chance of violating a constraint.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Chance {
    /// Name of the constraint.
    pub constraint: String,
    /// The chance, at most.
    pub at_most: f64,
    /// Whether it is that of the whole motion; else that of the worst instant.
    pub of_motion: bool,
}

impl ClosedLoop {
    /// The sections by name, as they stand in the spec.
    pub(crate) fn written(&self) -> &Map<String, serde_json::Value> {
        &self.written
    }

    /// What is uncertain and the chances to keep, where constraints have some: such a maneuver is planned by
    /// [`slewkit::assured::plan`].
    pub fn kept(&self) -> Option<(&Uncertainty, Vec<Kept<'_>>)> {
        let uncertainty = self.uncertainty.as_ref().filter(|_| !self.chances.is_empty())?;
        let all = self.chances.iter().map(|chance| {
            let over = if chance.of_motion { Over::Motion(self.plant) } else { Over::Instant };
            Kept { constraint: &chance.constraint, at_most: chance.at_most, over }
        });
        Some((uncertainty, all.collect()))
    }

    /// Whether there is anything to tell along a plan.
    pub fn is_asked(&self) -> bool {
        self.feedback.is_some() || self.uncertainty.is_some()
    }
}

/// Reads the sections; what is wrong is in the report.
pub(crate) fn read(root: &Section, tree: &Node, problem: &Problem) -> ClosedLoop {
    let sections = ["feedback", "uncertainty", "plant"];
    if let Some(section) = root.section("uncertainty")
        && let Some(cause) = unsuited(problem)
    {
        let remedy = "take [uncertainty] away: the plan itself does not need it";
        section.error_here("E0170", cause.to_string(), remedy);
    }
    let turns = PosedPlan::is_of(problem)
        && (problem.actuation.wheels.is_some() || problem.actuation.thrusters.is_some());
    if let (Some(section), true) = (root.section("feedback"), turns) {
        let remedy = "take [feedback] away: the plan itself does not need it";
        section.error_here("E0170", Unlinearised::Thrusters.to_string(), remedy);
    }
    let uncertainty = root.section("uncertainty").map(|section| uncertainty(section, problem));
    let chances = chances(root, problem, uncertainty.is_some());
    let mut written = Map::new();
    for name in sections {
        if let (true, Some(entry)) = (root.has(name), tree.entry(name)) {
            written.insert(name.into(), json(&entry.node));
        }
    }
    ClosedLoop {
        feedback: root
            .section("feedback")
            .and_then(|section| feedback(section, problem, root.has("uncertainty"))),
        uncertainty,
        plant: root.section("plant").map(plant).unwrap_or_default(),
        chances,
        written,
    }
}

/// Why there is no linear motion beside a plan of the maneuver.
fn unsuited(problem: &Problem) -> Option<Unlinearised> {
    if problem.motion == Motion::RigidBody {
        return Some(Unlinearised::Translation);
    }
    (problem.actuation.torque.frame() == AxisFrame::Reference).then_some(Unlinearised::Frame)
}

fn feedback(section: &Section, problem: &Problem, uncertain: bool) -> Option<Kind> {
    let has_wheels = problem.actuation.wheels.is_some();
    let default = if problem.switches() || has_wheels { "tvlqr" } else { "neighbouring" };
    let kind = if section.has("kind") { section.word("kind")? } else { default };
    let weights = ["attitude_weight", "rate_weight", "end_weight"];
    if kind == "neighbouring" {
        if problem.switches() {
            let reason = format!(
                "where {} is minimised inputs switch between their limits, and a neighbouring plan moves the switches",
                problem.objective.name()
            );
            return section.refuse("E0171", "kind", reason, "write kind = \"tvlqr\"");
        }
        if let Some(key) = weights.iter().find(|key| section.has(key)) {
            let reason = format!(
                "`{key}` is a weight of the regulator, and neighbouring gains have the cost of the plan"
            );
            return section.refuse("E0171", key, reason, "write kind = \"tvlqr\", or leave it out");
        }
        return Some(Kind::Neighbouring { freeze: section.number("freeze").unwrap_or(Kind::FREEZE) });
    }
    if kind == "switching" {
        if let Err(cause) = SwitchingGains::suits(problem) {
            return section.refuse("E0171", "kind", cause.to_string(), "write kind = \"tvlqr\"");
        }
        if uncertain {
            let reason = "switching times are corrected once, at the start: what that makes of covariances and flights is not known";
            let remedy = "write kind = \"tvlqr\", or take [uncertainty] away";
            return section.refuse("E0171", "kind", reason, remedy);
        }
    }
    if let (Some(key), true) =
        (weights.iter().find(|key| section.has(key)), problem.motion == Motion::RigidBody)
    {
        let reason = format!("`{key}` says nothing of position and velocity, which are to be regulated too");
        return section.refuse("E0171", key, reason, "leave it out: the regulator has weights by default");
    }
    if section.has("freeze") {
        let reason = "gains of the regulator do not grow without bound, and are not held";
        return section.refuse("E0171", "freeze", reason, "leave it out");
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
            let reason = "the weights of attitude and rate belong together";
            section.refuse_here("E0171", reason, "give both, or neither")
        }
    }
}

fn plant(section: &Section) -> Plant {
    let number = |key: &str| section.number(key).unwrap_or(0.0);
    Plant {
        lag: number("actuator_lag_s"),
        delay: number("delay_s"),
        quantum: number("torque_quantum_n_m"),
        tick: number("tick_s"),
        leads: section.word("feedforward") != Some("as_planned"),
        authority: section.number("authority").unwrap_or(1.0),
    }
}

/// Three deviations: one number for all, or three; zero where the key is absent.
fn three(section: Option<&Section>, key: &str, unit: f64) -> Vector3 {
    let Some((section, limits)) = section.and_then(|section| Some((section, section.limits(key)?))) else {
        return Vector3::zeros();
    };
    match limits {
        Limits::All(value) => Vector3::repeat(value * unit),
        Limits::Each(values) if values.len() == 3 => Vector3::from_column_slice(&values) * unit,
        Limits::Each(values) => {
            let reason = format!("has {} numbers, one for all axes or three are needed", values.len());
            section.error("E0026", key, reason, "write one number, or three");
            Vector3::zeros()
        }
    }
}

fn uncertainty(section: &Section, problem: &Problem) -> Uncertainty {
    let degree = 1_f64.to_radians();
    let [start, inertia, alignment, actuators, sensor] =
        ["start", "inertia", "alignment", "actuators", "sensor"].map(|name| section.section(name));
    let variances = |of: Option<&Section>| {
        let (attitude, rate) =
            (three(of, "attitude_deg", degree), three(of, "angular_velocity_deg_s", degree));
        let both = Vector6::from_fn(|row, _| if row < 3 { attitude[row] } else { rate[row - 3] });
        Matrix6::from_diagonal(&both.component_mul(&both))
    };
    let axes = ["x", "y", "z"];
    let unit = |axis: usize| Vector3::from_fn(|row, _| f64::from(u8::from(row == axis)));
    let mut parameters: Vec<(String, Parameter, f64)> = Vec::new();
    let mut add = |name: String, parameter: Parameter, sigma: f64| {
        if sigma > 0.0 {
            parameters.push((name, parameter, sigma));
        }
    };
    let moments = three(inertia, "relative", 1.0);
    for axis in 0..3 {
        let mut delta = Matrix3::zeros();
        delta[(axis, axis)] = 1.0;
        let sigma = moments[axis] * problem.body.inertia.j()[(axis, axis)];
        add(format!("inertia {0}{0}", axes[axis]), Parameter::Inertia(delta), sigma);
    }
    let products = inertia.and_then(|section| section.number("products_kg_m2")).unwrap_or(0.0);
    for (row, column) in [(0, 1), (0, 2), (1, 2)] {
        let mut delta = Matrix3::zeros();
        delta[(row, column)] = 1.0;
        delta[(column, row)] = 1.0;
        add(format!("inertia {}{}", axes[row], axes[column]), Parameter::Inertia(delta), products);
    }
    let scale = actuators.and_then(|section| section.number("scale")).unwrap_or(0.0);
    for input in 0..problem.actuation.torque.count() {
        add(format!("scale of input {}", input + 1), Parameter::InputScale(input), scale);
    }
    let rate_scale = sensor.and_then(|section| section.number("scale")).unwrap_or(0.0);
    let turned = three(alignment, "actuators_deg", degree);
    let constant = three(actuators, "constant_n_m", 1.0);
    let seen = three(alignment, "sensor_deg", degree);
    let bias = three(sensor, "bias_deg_s", degree);
    for axis in 0..3 {
        let about = axes[axis];
        add(format!("actuators about {about}"), Parameter::ActuatorTurn(unit(axis)), turned[axis]);
        add(format!("torque {about}"), Parameter::ConstantTorque(unit(axis)), constant[axis]);
        add(format!("attitude sensor about {about}"), Parameter::SensorTurn(unit(axis)), seen[axis]);
        add(format!("scale of rate {about}"), Parameter::RateScale(axis), rate_scale);
        add(format!("bias of rate {about}"), Parameter::RateBias(unit(axis)), bias[axis]);
    }
    let noise = three(actuators, "noise_n_m_sqrt_s", 1.0);
    Uncertainty {
        start: variances(start),
        parameters,
        torque_noise: Matrix3::from_diagonal(&noise.component_mul(&noise)),
        sensor_noise: variances(sensor),
    }
}

/// The chances of constraints; each needs something uncertain.
fn chances(root: &Section, problem: &Problem, uncertain: bool) -> Vec<Chance> {
    let mut chances = Vec::new();
    for (section, constraint) in root.list("constraint").iter().zip(&problem.constraints) {
        let of_motion = section.has("chance_over") && section.word("chance_over") == Some("motion");
        if !section.has("chance") {
            if section.has("chance_over") {
                let reason = "it says when a chance holds, and there is none";
                section.error("E0172", "chance_over", reason, "add chance = 0.001, or leave it out");
            }
            continue;
        }
        let Some(at_most) = section.number("chance") else { continue };
        if !uncertain {
            let reason = format!("\"{}\" has a chance, and nothing is uncertain", escape(&constraint.name));
            section.error("E0172", "chance", reason, "add [uncertainty], or give margin_deg");
        }
        if of_motion && at_most < Over::LEAST {
            let reason =
                format!("the chance of a motion is counted in flights, and that of {at_most} takes too many");
            let remedy = format!("ask for {} or more, or for that of the worst instant", Over::LEAST);
            section.error("E0172", "chance", reason, remedy);
        }
        // In a spec that slew wrote the margin is the one that the chance took.
        if !section.keeps_rounding && (section.has("margin_deg") || section.has("margin_rad")) {
            let reason = "a chance and a margin: the larger of the two acts";
            section.warn("W0170", "chance", reason, "leave the margin out, unless it is for something else");
        }
        chances.push(Chance { constraint: constraint.name.clone(), at_most, of_motion });
    }
    chances
}

/// A value of the tree as JSON.
fn json(node: &Node) -> serde_json::Value {
    match &node.value {
        Value::Table(entries) => {
            entries.iter().map(|entry| (entry.key.clone(), json(&entry.node))).collect::<Map<_, _>>().into()
        }
        Value::Array(items) => items.iter().map(json).collect::<Vec<_>>().into(),
        Value::Text(text) => text.as_str().into(),
        Value::Number(number) => number.value.into(),
        Value::Boolean | Value::Date | Value::Null => serde_json::Value::Null,
    }
}
