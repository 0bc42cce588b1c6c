//! Reading of `[[actuators.thruster]]`: one-sided (unidirectional) thrusters.
//!
//! If only the attitude is planned, the input of a thruster is its torque about the center of mass
//! \[N·m\]. The limit on this input is the torque limit of the spec, or the force limit times the
//! lever arm. The fuel price is converted in the same way. If the body also translates, the input
//! is the force of the thruster \[N\], which accelerates and rotates the body.

use super::{Actuated, FORCE_LIMITS, SMALLEST, TORQUE_LIMITS, called};
use crate::spec::{Section, short};
use slewkit::Vector3;
use slewkit::maneuver::{Motion, Weights};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Limits};

/// A thruster as defined in the spec.
struct Thruster {
    /// Position relative to the center of mass \[m\]; `None` for a thruster that is defined by its
    /// torque.
    position: Option<Vector3>,
    /// Direction of the force, or axis of the torque, as a unit vector in body axes.
    axis: Vector3,
    /// Largest force \[N\] or torque \[N·m\].
    limit: f64,
    /// Fuel price of the thruster per unit of force or torque and second.
    price: f64,
}

/// Smallest lever arm with which a thruster produces a torque, as a fraction of the distance from
/// the center of mass.
const NO_LEVER: f64 = 1e-9;

/// Reads the thrusters, and returns their inputs with the fuel price of each input.
pub(super) fn thrusters(section: &Section, motion: Motion) -> Option<Actuated> {
    let others = ["wheel", "torque_axes_body", "torque_axes_reference", "effort_weight", "fuel_price"];
    let forces = ["force_axes_reference", "force_axes_body", "force_effort_weight", "force_fuel_price"];
    let others = others.into_iter().chain(TORQUE_LIMITS).chain(forces).chain(FORCE_LIMITS);
    let mut good = true;
    for key in others.filter(|key| section.has(key)) {
        let reason = format!("both `thruster` and `{key}` are given: each thruster is an input by itself");
        section.error("E0028", key, reason, "give only one of the two");
        good = false;
    }
    let sections = section.list("thruster");
    if section.is_empty_list("thruster") {
        let reason = "the list of thrusters is empty: no input turns the body";
        let few = if motion == Motion::RigidBody { "seven" } else { "four" };
        section.error("E0026", "thruster", reason, format!("give {few} thrusters or more, or torque axes"));
    }
    if sections.is_empty() {
        return None;
    }
    let of_motion = |(index, section): (usize, &Section)| {
        let thruster = read(section, index)?;
        match (motion, thruster.position) {
            (Motion::Attitude, Some(position)) => turning(section, index, &thruster, position),
            (Motion::RigidBody, None) => {
                let reason = format!(
                    "{} has only a torque, but the body translates: its force is needed too",
                    called("thruster", section, index)
                );
                let remedy = "give position_m, force_direction_body and force_limit_n; or remove the \
                    positions of [start] and [end]";
                section.refuse("E0064", "torque_axis_body", reason, remedy)
            }
            _ => Some(thruster),
        }
    };
    let read: Vec<_> = sections.iter().enumerate().map(of_motion).collect();
    let thrusters: Vec<Thruster> = read.into_iter().collect::<Option<_>>()?;
    let size = Some(thrusters.iter().map(|thruster| thruster.limit).collect());
    let limits = Limits { size, one_sided: true, ..Limits::default() };
    let axes = thrusters.iter().map(|thruster| thruster.axis).collect();
    let actuation = if motion == Motion::RigidBody {
        let positions = thrusters.iter().filter_map(|thruster| thruster.position).collect();
        Actuation::of_thrusters(positions, axes, limits)
    } else {
        ActuatorSet::new(axes, AxisFrame::Body)
            .and_then(|set| set.with_limits(limits))
            .map(Actuation::torques)
    };
    let actuation = match actuation {
        Ok(actuation) => actuation,
        Err(error) => {
            let remedy = "check the numbers of the thrusters";
            return section.refuse("E0061", "thruster", error.to_string(), remedy);
        }
    };
    let given = Some(thrusters.iter().map(|thruster| thruster.price).collect());
    let (prices, force_prices) = if motion == Motion::RigidBody { (None, given) } else { (given, None) };
    good.then_some(Actuated { actuation, weights: Weights::default(), prices, force_prices })
}

/// Converts a thruster at `position` that is defined by its force to a thruster that is defined by
/// its torque.
fn turning(section: &Section, index: usize, thruster: &Thruster, position: Vector3) -> Option<Thruster> {
    let torque = position.cross(&thruster.axis);
    let lever = torque.norm();
    if lever <= NO_LEVER * position.norm() || lever < SMALLEST {
        let reason = format!(
            "{} pushes through the mass center, with a lever of {} m: it has no torque",
            called("thruster", section, index),
            short(lever)
        );
        return section.refuse(
            "E0054",
            "force_direction_body",
            reason,
            "remove the thruster, or check its position",
        );
    }
    let (limit, price) = (thruster.limit * lever, thruster.price / lever);
    Some(Thruster { position: None, axis: torque / lever, limit, price })
}

fn read(section: &Section, index: usize) -> Option<Thruster> {
    let price = if section.has("fuel_price") { section.number("fuel_price") } else { Some(1.0) };
    let by_torque = section.has("torque_axis_body");
    let (needed, others) = if by_torque {
        (["torque_axis_body", "torque_limit_n_m"], ["position_m", "force_direction_body", "force_limit_n"])
    } else {
        (["position_m", "force_limit_n"], ["torque_limit_n_m"; 3])
    };
    if let Some(key) = others.into_iter().find(|key| section.has(key)) {
        let reason = format!(
            "{}: `{key}` cannot be combined with `{}`",
            called("thruster", section, index),
            needed[0]
        );
        let remedy = "give torque_axis_body and torque_limit_n_m, or position_m, force_direction_body and \
            force_limit_n";
        return section.refuse("E0028", key, reason, remedy);
    }
    let all_needed = needed.into_iter().chain((!by_torque).then_some("force_direction_body"));
    for key in all_needed {
        if !section.has(key) {
            let reason = format!("{} needs `{key}`", called("thruster", section, index));
            let sample = match key {
                "position_m" => "add position_m = [0.5, 0, 0.2], from the mass center",
                "force_direction_body" => {
                    "add force_direction_body = [0, 1, 0], the direction of the force on the body"
                }
                "force_limit_n" => "add force_limit_n = 1",
                _ => "add torque_limit_n_m = 0.5",
            };
            return section.refuse_here("E0021", reason, sample);
        }
    }
    let direction = |key: &str| {
        let vector = section.vector(key)?;
        if vector.amax() < SMALLEST {
            let reason = format!(
                "`{key}` of {} has length zero, so it has no direction",
                called("thruster", section, index)
            );
            return section.refuse("E0054", key, reason, "give it a direction, or remove the thruster");
        }
        Some(section.unit(vector))
    };
    if by_torque {
        let axis = direction("torque_axis_body")?;
        return Some(Thruster {
            position: None,
            axis,
            limit: section.number("torque_limit_n_m")?,
            price: price?,
        });
    }
    let (position, axis) = (section.vector("position_m")?, direction("force_direction_body")?);
    Some(Thruster { position: Some(position), axis, limit: section.number("force_limit_n")?, price: price? })
}
