//! `[body]` and `[actuators]`.

use super::diagnostic::Spot;
use super::quantity::{self as q, short, show};
use super::section::{Report, Section};
use crate::actuation::{Actuation, AxisFrame, Channel, ChannelError};
use crate::body::{Inertia, InertiaError};
use crate::problem::Motion;
use nalgebra::DMatrix;

/// Asymmetry that needs no warning: the last digit of an entry.
const SILENT_ASYMMETRY: f64 = 1e-15;
/// Smallest principal moment [kg·m²], weight and axis length: the products of the solvers stay in range.
const SMALLEST: f64 = 1e-30;
/// A body thinner than this [kg/m³] inside its radius of gyration has its inertia in other units.
const THINNEST: f64 = 1e-5;

/// The inertia, checked.
pub(crate) fn inertia(body: &Section<'_>, report: &mut Report) -> Option<Inertia> {
    let name = "inertia_kg_m2";
    let matrix = body.matrix(name)?;
    let spot = body.spot(name);
    let inertia = match Inertia::new(matrix) {
        Ok(inertia) => inertia,
        Err(error) => {
            let (code, reason, remedy) = refusal(&error);
            report.error(code, spot, reason, remedy);
            return None;
        }
    };
    let smallest = inertia.principal()[0];
    if smallest < SMALLEST {
        let reason = format!(
            "the smallest principal moment, {} kg·m², is outside the range of an inertia, {SMALLEST:e} to {:e} kg·m²",
            short(smallest),
            q::INERTIA.largest
        );
        report.error("E0031", spot, reason, "check the exponent and the unit");
        return None;
    }
    let asymmetry = (matrix - matrix.transpose()).amax() / matrix.amax();
    if asymmetry > SILENT_ASYMMETRY {
        let reason = format!(
            "the inertia is not quite symmetric, by {} of its size; it is averaged",
            short(asymmetry)
        );
        report.warn("W0040", spot.clone(), reason, "write the same number on both sides of the diagonal");
    }
    if inertia.is_degenerate() {
        let p = inertia.principal();
        let reason = format!(
            "the principal moments {}, {}, {} are those of a flat plate or a thin rod",
            short(p[0]),
            short(p[1]),
            short(p[2])
        );
        let remedy = "nothing to do if that is meant; a step may then turn at most 0.5 rad";
        report.warn("W0042", spot, reason, remedy);
    }
    Some(inertia)
}

/// An inertia that is none, in words.
fn refusal(error: &InertiaError) -> (&'static str, String, &'static str) {
    match error {
        InertiaError::NotSymmetric { row, column, upper, lower } => (
            "E0040",
            format!(
                "the inertia is not symmetric: row {row} column {column} is {}, row {column} column {row} is {}",
                show(*upper),
                show(*lower)
            ),
            "write the same number on both sides of the diagonal",
        ),
        InertiaError::NotPositive { smallest } => (
            "E0041",
            format!("the smallest principal moment of inertia is {}, it must be positive", short(*smallest)),
            "check the diagonal, and the signs of the products of inertia: tensor signs, Jxy = −∫xy dm",
        ),
        InertiaError::Triangle { principal: [a, b, c] } => (
            "E0042",
            format!(
                "no body has the principal moments {}, {}, {}: the largest exceeds the sum of the others, {}",
                short(*a),
                short(*b),
                short(*c),
                short(a + b)
            ),
            "check the moments and the signs of the products of inertia: tensor signs, Jxy = −∫xy dm",
        ),
        InertiaError::IllConditioned { ratio } => (
            "E0045",
            format!(
                "the principal moments differ by a factor of {}, at most {:e} is accepted",
                short(*ratio),
                Inertia::CONDITION
            ),
            "give the thin axis a realistic moment",
        ),
        InertiaError::NotFinite => ("E0030", "the inertia is not finite".into(), "write finite numbers"),
    }
}

/// Warns of an inertia that does not go with the mass, as from g·cm² taken for kg·m².
pub(crate) fn warn_density(body: &Section<'_>, inertia: &Inertia, mass: f64, report: &mut Report) {
    let radius = (inertia.mean() / mass).sqrt();
    let density = mass / radius.powi(3);
    if density < THINNEST {
        let reason =
            format!("{} kg with this inertia spread over {} m: very thin", show(mass), short(radius));
        let spot = body.spot("inertia_kg_m2");
        report.warn("W0043", spot, reason, "is the inertia in g·cm²? 1 g·cm² is 1e-7 kg·m²");
    }
}

/// The actuators, with the defaults that go with the motion.
pub(crate) fn actuation(
    section: Option<&Section<'_>>,
    motion: Motion,
    report: &mut Report,
) -> Option<Actuation> {
    let torque_names =
        [("torque_axes_body", AxisFrame::Body), ("torque_axes_reference", AxisFrame::Reference)];
    let force_names = [("force_axes_reference", AxisFrame::Reference), ("force_axes_body", AxisFrame::Body)];
    let Some(section) = section else {
        let force = (motion == Motion::RigidBody).then(|| Channel::three_axes(AxisFrame::Reference));
        return Some(Actuation { torque: Channel::three_axes(AxisFrame::Body), force, wheels: None });
    };
    let torque = channel(section, &torque_names, "effort_weight", report);
    let force_keys = ["force_axes_reference", "force_axes_body", "force_effort_weight"];
    if motion == Motion::Attitude {
        if let Some(key) = force_keys.into_iter().find(|key| section.has(key)) {
            let reason = format!("`{key}` is given, but the maneuver moves the attitude only");
            let remedy = "remove it, or give `position_m` and `velocity_m_s` in [start] and [end]";
            report.error("E0064", section.spot(key), reason, remedy);
        }
        return Some(Actuation::torques(torque?));
    }
    let none = force_names.iter().any(|(name, _)| section.axes(name).is_some_and(|axes| axes.is_empty()));
    if none {
        if section.has("force_effort_weight") {
            let reason = "a weight of forces is given, but the list of force axes is empty".to_string();
            report.error("E0026", section.spot("force_effort_weight"), reason, "remove one of the two");
        }
        return Some(Actuation::torques(torque?));
    }
    let force = channel(section, &force_names, "force_effort_weight", report);
    Some(Actuation { torque: torque?, force: Some(force?), wheels: None })
}

/// Inputs of one kind: axes under one of two names (the first is the default), and their weight.
fn channel(
    section: &Section<'_>,
    names: &[(&str, AxisFrame); 2],
    weight_name: &str,
    report: &mut Report,
) -> Option<Channel> {
    let given = names.iter().find(|(name, _)| section.has(name));
    let (name, frame) = *given.unwrap_or(&names[0]);
    let default = Channel::three_axes(frame);
    let axes = if given.is_some() { section.axes(name)? } else { default.axes().to_vec() };
    let count = axes.len();
    if count == 0 {
        let reason = "the list of torque axes is empty: nothing turns the body".to_string();
        report.error("E0026", section.spot(name), reason, "give at least one axis");
        return None;
    }
    let weight = if section.has(weight_name) {
        let rows = section.weight(weight_name)?;
        if rows.len() != count {
            let reason = format!("`{weight_name}` is for {} axes, there are {count}", rows.len());
            report.error("E0026", section.spot(weight_name), reason, "give one weight per axis");
            return None;
        }
        DMatrix::from_fn(count, count, |row, column| rows[row][column])
    } else {
        DMatrix::identity(count, count)
    };
    // Channel would refuse it too, without saying which.
    if let Some(index) = (0..count).find(|index| weight[(*index, *index)] < SMALLEST) {
        let value = show(weight[(index, index)]);
        let reason =
            format!("the weight of input {} is {value}, it must be at least {SMALLEST:e}", index + 1);
        report.error("E0065", section.spot(weight_name), reason, "every input must cost something");
        return None;
    }
    if let Some(index) = axes.iter().position(|axis| axis.amax() < SMALLEST) {
        let reason = format!(
            "axis {} has length {}, at least {SMALLEST:e} is needed",
            index + 1,
            show(axes[index].norm())
        );
        report.error("E0031", section.spot(name), reason, "an axis of length 1 makes inputs in N·m or N");
        return None;
    }
    match Channel::new(axes, frame, weight) {
        Ok(channel) => Some(channel),
        Err(error) => {
            let at = |name| -> Spot { section.spot(name) };
            let (code, spot, remedy) = match error {
                ChannelError::Axis { .. } => {
                    ("E0054", at(name), "leave the axis out, or give it a direction")
                }
                ChannelError::Count { .. } => ("E0034", at(name), "use fewer axes"),
                ChannelError::WeightShape { .. } => ("E0026", at(weight_name), "give one weight per axis"),
                ChannelError::Limit { .. } => ("E0061", at(name), "leave the limit out where there is none"),
                ChannelError::Weight => (
                    "E0065",
                    at(weight_name),
                    "write the same number on both sides of the diagonal, smaller than the diagonal",
                ),
            };
            report.error(code, spot, error.to_string(), remedy);
            None
        }
    }
}
