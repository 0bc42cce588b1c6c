//! Reading of `[actuators]`: axes, weights, prices and limits of the inputs.

pub(crate) mod reach;
mod thrusters;
mod wheels;

use super::body::SMALLEST;
use super::{Limits, Section, escape, short, show};
use nalgebra::DMatrix;
use slewkit::maneuver::{Motion, Weighted, Weights};
use slewkit::mechanics::{Actuation, ActuatorSet, ActuatorSetError, AxisFrame};

/// Actuators with their effort weights, and the fuel price of each torque and force input. The
/// default price is 1.
pub(crate) struct Actuated {
    pub actuation: Actuation,
    pub weights: Weights,
    pub prices: Option<Vec<f64>>,
    pub force_prices: Option<Vec<f64>>,
}

/// Reads the actuators, the effort weights and the fuel prices. The default actuators depend on the
/// kind of motion, with or without translation.
pub(crate) fn actuated(section: Option<&Section>, motion: Motion) -> Option<Actuated> {
    let shortest_pulse = match section.filter(|section| section.has(SHORTEST_PULSE)) {
        Some(section) => Some(section.number(SHORTEST_PULSE)?),
        None => None,
    };
    let found = of_any_length(section, motion)?;
    let pulsing = |set: ActuatorSet| {
        let limits = slewkit::mechanics::actuators::Limits { shortest_pulse, ..set.limits().clone() };
        set.with_limits(limits).ok()
    };
    let Actuation { torque, force, wheels, thrusters } = found.actuation;
    // Thrusters that produce both force and torque have one set of inputs with two kinds of axes.
    let force = match force {
        Some(force) if thrusters.is_some() => Some(pulsing(force)?),
        force => force,
    };
    Some(Actuated { actuation: Actuation { torque: pulsing(torque)?, force, wheels, thrusters }, ..found })
}

/// Key of the minimum pulse width of the torque inputs \[s\].
pub(super) const SHORTEST_PULSE: &str = "shortest_pulse_s";

/// Reads the actuators, except for the minimum pulse width.
fn of_any_length(section: Option<&Section>, motion: Motion) -> Option<Actuated> {
    if let Some(section) = section.filter(|section| section.has("thruster")) {
        return thrusters::thrusters(section, motion);
    }
    let (actuation, weights) = actuation(section, motion)?;
    let forces = actuation.force.as_ref().map_or(0, ActuatorSet::count);
    let torques = actuation.torque.count();
    let priced = |key: &str, inputs: &str, count: usize| match section.filter(|section| section.has(key)) {
        Some(section) => prices(section, key, inputs, count).map(Some),
        None => Some(None),
    };
    let prices = priced("fuel_price", "torque", torques)?;
    let force_prices = priced("force_fuel_price", "force", forces)?;
    Some(Actuated { actuation, weights, prices, force_prices })
}

/// Reads the fuel prices of the `count` inputs of one kind, from a common price or from a list.
fn prices(section: &Section, key: &str, inputs: &str, count: usize) -> Option<Vec<f64>> {
    match section.limits(key)? {
        Limits::All(price) => Some(vec![price; count]),
        Limits::Each(prices) if prices.len() == count => Some(prices),
        Limits::Each(prices) => {
            let reason = format!(
                "`{key}` has values for {} {inputs} inputs, but the maneuver has {count}",
                prices.len()
            );
            section.refuse("E0026", key, reason, "give one price for each input, or one for all")
        }
    }
}

fn actuation(section: Option<&Section>, motion: Motion) -> Option<(Actuation, Weights)> {
    let torque_names =
        [("torque_axes_body", AxisFrame::Body), ("torque_axes_reference", AxisFrame::Reference)];
    let force_names = [("force_axes_reference", AxisFrame::Reference), ("force_axes_body", AxisFrame::Body)];
    let Some(section) = section else {
        let force = (motion == Motion::RigidBody).then(|| ActuatorSet::three_axes(AxisFrame::Reference));
        let torque = ActuatorSet::three_axes(AxisFrame::Body);
        return Some((Actuation { force, ..Actuation::torques(torque) }, Weights::default()));
    };
    if section.has("wheel") {
        return wheels::wheels(section, motion);
    }
    let torque = channel(section, &torque_names, "effort_weight");
    let torque = limited(torque, section, &TORQUE_LIMITS);
    let force_keys = ["force_axes_reference", "force_axes_body", "force_effort_weight", "force_fuel_price"];
    if motion == Motion::Attitude {
        if let Some(key) = force_keys.into_iter().chain(FORCE_LIMITS).find(|key| section.has(key)) {
            let reason = format!("`{key}` is given, but the maneuver moves the attitude only");
            let remedy = "remove it, or give `position_m` and `velocity_m_s` in [start] and [end]";
            section.error("E0064", key, reason, remedy);
        }
        let (torque, weight) = torque?;
        return Some((Actuation::torques(torque), Weights { torque: weight, ..Weights::default() }));
    }
    let none = force_names.iter().any(|(name, _)| section.vectors(name).is_some_and(|axes| axes.is_empty()));
    if none {
        let orphan = ["force_effort_weight", "force_fuel_price"]
            .into_iter()
            .chain(FORCE_LIMITS)
            .find(|key| section.has(key));
        if let Some(key) = orphan {
            let reason = format!("`{key}` is given, but the list of force axes is empty");
            section.error("E0026", key, reason, "remove one of the two");
        }
        let (torque, weight) = torque?;
        return Some((Actuation::torques(torque), Weights { torque: weight, ..Weights::default() }));
    }
    let force = channel(section, &force_names, "force_effort_weight");
    let force = limited(force, section, &FORCE_LIMITS);
    let ((torque, torque_weight), (force, force_weight)) = (torque?, force?);
    let weights = Weights { torque: torque_weight, force: force_weight, time_price: None };
    Some((Actuation::torques_and_forces(torque, force), weights))
}

/// Keys of the limits on each torque, on the norm of the torque, and on the rate of each torque.
const TORQUE_LIMITS: [&str; 3] = ["torque_limit_n_m", "torque_norm_limit_n_m", "torque_rate_limit_n_m_per_s"];
const FORCE_LIMITS: [&str; 3] = ["force_limit_n", "force_norm_limit_n", "force_rate_limit_n_per_s"];

/// Inputs of one kind, torque or force, with their weight matrix if the spec has one.
type Channel = (ActuatorSet, Option<DMatrix<f64>>);

/// Largest deviation from unit length of the axis of an input whose limit is in N·m or N.
const UNIT_ROUNDING: f64 = 1e-3;

/// Adds the limits of the spec to a set of inputs. The keys are those of the limits on size, norm
/// and rate.
fn limited(channel: Option<Channel>, section: &Section, [size, norm, rate]: &[&str; 3]) -> Option<Channel> {
    // The keys are checked in any case, even if the axes are invalid.
    let (channel, weight) = channel?;
    let each = |name: &str| -> Option<Option<Vec<f64>>> {
        let Some(limits) = limits_of_each(section, name, channel.count())? else { return Some(None) };
        let mut lengths = channel.axes().iter().map(|axis| axis.norm());
        if let Some(index) = lengths.position(|length| (length - 1.0).abs() > UNIT_ROUNDING) {
            let length = short(channel.axes()[index].norm());
            let reason = format!(
                "`{name}`: axis {} has length {length}, so its input does not have the unit of the limit",
                index + 1
            );
            let remedy =
                "give an axis of length 1, and divide its `effort_weight` by the square of the length";
            return section.refuse("E0067", name, reason, remedy);
        }
        Some(Some(limits))
    };
    let (size_limits, rate_limits) = (each(size), each(rate));
    let norm = if section.has(norm) { Some(section.number(norm)?) } else { None };
    let limits = slewkit::mechanics::actuators::Limits {
        size: size_limits?,
        norm,
        rate: rate_limits?,
        ..Default::default()
    };
    channel
        .with_limits(limits)
        .map_err(|error| section.error_here("E0061", error.to_string(), "write positive limits"))
        .ok()
        .map(|channel| (channel, weight))
}

/// Reads the limit of each of `count` inputs. Returns `Some(None)` if the key is absent, and `None`
/// after an error.
fn limits_of_each(section: &Section, name: &str, count: usize) -> Option<Option<Vec<f64>>> {
    if !section.has(name) {
        return Some(None);
    }
    match section.limits(name)? {
        Limits::All(limit) => Some(Some(vec![limit; count])),
        Limits::Each(limits) if limits.len() == count => Some(Some(limits)),
        Limits::Each(limits) => {
            let reason =
                format!("`{name}` has values for {} axes, but the maneuver has {count}", limits.len());
            let remedy = "give one limit for each axis, or one for all";
            section.refuse("E0026", name, reason, remedy)
        }
    }
}

/// Reads the inputs of one kind and their weight matrix. The axes are given under one of the two
/// keys of `names`; the first key is that of the default axes.
fn channel(section: &Section, names: &[(&str, AxisFrame); 2], weight_name: &str) -> Option<Channel> {
    let given = names.iter().find(|(name, _)| section.has(name));
    let (name, frame) = *given.unwrap_or(&names[0]);
    let default = ActuatorSet::three_axes(frame);
    let axes = if given.is_some() { section.vectors(name)? } else { default.axes().to_vec() };
    let count = axes.len();
    if count == 0 {
        let reason = "the list of torque axes is empty: no input turns the body";
        return section.refuse("E0026", name, reason, "give at least one axis");
    }
    let weight = if section.has(weight_name) {
        let rows = section.square(weight_name)?;
        if rows.len() != count {
            let reason =
                format!("`{weight_name}` has values for {} axes, but the maneuver has {count}", rows.len());
            return section.refuse("E0026", weight_name, reason, "give one weight for each axis");
        }
        Some(DMatrix::from_fn(count, count, |row, column| rows[row][column]))
    } else {
        None
    };
    // The later check of the weights would also reject a small weight, but its message would not
    // name the input.
    let diagonal = weight.as_ref().map(DMatrix::diagonal);
    let small = |(_, value): &(usize, &f64)| **value < SMALLEST;
    if let Some((index, value)) = diagonal.iter().flatten().enumerate().find(small) {
        let value = show(*value);
        let reason =
            format!("the weight of input {} is {value}: it must be at least {SMALLEST:e}", index + 1);
        return section.refuse("E0065", weight_name, reason, "give every input a positive weight");
    }
    if let Some(index) = axes.iter().position(|axis| axis.amax() < SMALLEST) {
        let reason = format!(
            "axis {} has length {}: it must be at least {SMALLEST:e}",
            index + 1,
            show(axes[index].norm())
        );
        let remedy = "give an axis of length 1, so that inputs are in N·m or N";
        return section.refuse("E0031", name, reason, remedy);
    }
    let channel = match ActuatorSet::new(axes, frame) {
        Ok(channel) => channel,
        Err(error) => {
            let (code, remedy) = match error {
                ActuatorSetError::Axis { .. } => ("E0054", "remove the axis, or give it a direction"),
                ActuatorSetError::Count { .. } => ("E0034", "use fewer axes"),
                ActuatorSetError::Limit { .. } => ("E0061", "remove the key for no limit"),
                ActuatorSetError::Position { .. } => ("E0061", "give every thruster a position"),
            };
            return section.refuse(code, name, error.to_string(), remedy);
        }
    };
    if let Err(error) = Weighted::new(&channel, weight.as_ref()) {
        let remedy = "write the same number on both sides of the diagonal, smaller than the diagonal";
        return section.refuse("E0065", weight_name, error.to_string(), remedy);
    }
    Some((channel, weight))
}

/// Returns the description of an actuator for messages, such as "wheel 2", followed by the name in
/// the spec if it has one.
fn called(kind: &str, section: &Section, index: usize) -> String {
    match section.word("name") {
        Some(name) => format!("{kind} {} \"{}\"", index + 1, escape(name)),
        None => format!("{kind} {}", index + 1),
    }
}
