//! Reading of `[[actuators.wheel]]`: reaction wheels, which produce the torque inputs.

use super::{SMALLEST, TORQUE_LIMITS, called, limits_of_each};
use crate::spec::{Section, short, show};
use nalgebra::{DMatrix, DVector};
use slewkit::Vector3;
use slewkit::maneuver::{BOUNDARY_ROUNDING, Motion, Weighted, Weights};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};

/// A wheel as defined in the spec.
struct Wheel {
    axis: Vector3,
    torque_limit: Option<f64>,
    momentum_limit: f64,
    momentum: f64,
    weight: f64,
}

/// Largest deviation of an axis from unit length for which no warning is given. An axis with four
/// digits, each with a rounding error of at most 5e-5, deviates by at most 9e-5.
const SILENT: f64 = 1e-4;

/// Reads the wheels. Returns their torques as actuators, with the effort weights.
pub(super) fn wheels(section: &Section, motion: Motion) -> Option<(Actuation, Weights)> {
    let others = ["torque_axes_body", "torque_axes_reference", "effort_weight"];
    let [size, norm, rate] = TORQUE_LIMITS;
    let others = others.into_iter().chain([size, norm]).filter(|key| section.has(key));
    let mut good = true;
    for key in others {
        let reason = format!("both `wheel` and `{key}` are given: each wheel is a torque input by itself");
        let remedy = match key {
            "effort_weight" => "write `effort_weight` in each [[actuators.wheel]]",
            "torque_limit_n_m" => "write `torque_limit_n_m` in each [[actuators.wheel]]",
            _ => "give only one of the two",
        };
        section.error("E0028", key, reason, remedy);
        good = false;
    }
    if motion == Motion::RigidBody {
        let reason = "reaction wheels need a maneuver without translation, but positions are given";
        let remedy = "remove the positions and velocities of [start] and [end], or use torque axes";
        return section.refuse("E0064", "wheel", reason, remedy);
    }
    let forces = ["force_axes_reference", "force_axes_body", "force_effort_weight"];
    if let Some(key) = forces.into_iter().chain(super::FORCE_LIMITS).find(|key| section.has(key)) {
        let reason = format!("`{key}` is given, but the maneuver moves the attitude only");
        section.error("E0064", key, reason, "remove it");
        good = false;
    }
    let sections = section.list("wheel");
    if section.is_empty_list("wheel") {
        let reason = "the list of wheels is empty: no input turns the body";
        section.error("E0026", "wheel", reason, "give three wheels or more, or torque axes");
    }
    if sections.is_empty() {
        return None;
    }
    let wheels: Vec<_> = sections.iter().enumerate().map(|(index, wheel)| read(wheel, index)).collect();
    let wheels: Vec<Wheel> = wheels.into_iter().collect::<Option<_>>()?;
    let (size, rate) = (torque_limits(&wheels, sections), limits_of_each(section, rate, wheels.len()));
    let (size, rate) = (size?, rate?);
    let weight = DMatrix::from_diagonal(&DVector::from_iterator(
        wheels.len(),
        wheels.iter().map(|wheel| wheel.weight),
    ));
    let axes = wheels.iter().map(|wheel| wheel.axis).collect();
    let channel = ActuatorSet::new(axes, AxisFrame::Body);
    let channel = channel.and_then(|channel| channel.with_limits(Limits { size, rate, ..Limits::default() }));
    let checked = channel.map_err(|error| error.to_string()).and_then(|channel| {
        Weighted::new(&channel, Some(&weight)).map_err(|error| error.to_string())?;
        Ok(channel)
    });
    let torque = match checked {
        Ok(channel) => channel,
        Err(reason) => {
            return section.refuse("E0062", "wheel", reason, "check the numbers of the wheels");
        }
    };
    let (rank, blind) = torque.rank();
    if let Some(axis) = blind {
        let vector = axis.map(|part| (part * 1e3).round() / 1e3 + 0.0);
        let what = if rank == 2 { "no torque about" } else { "torque only about" };
        let reason = format!("rank {rank}: {what} ({}, {}, {})", vector.x, vector.y, vector.z);
        let remedy = match (wheels.len(), rank) {
            (..3, _) => "give three wheels or more",
            (_, 2) => "tilt a wheel out of the plane of the others",
            _ => "give two wheels other axes, not in one plane",
        };
        let reason = format!("the wheel axes have {reason}");
        return section.refuse("E0062", "wheel", reason, remedy);
    }
    let column = |value: fn(&Wheel) -> f64| wheels.iter().map(value).collect();
    let wheels = Wheels {
        momentum: column(|wheel| wheel.momentum),
        momentum_limit: column(|wheel| wheel.momentum_limit),
    };
    let actuation = Actuation { wheels: Some(wheels), ..Actuation::torques(torque) };
    good.then_some((actuation, Weights::of_torques(weight)))
}

fn read(section: &Section, index: usize) -> Option<Wheel> {
    let axis = axis(section, index);
    let or = |name: &str, absent: f64| if section.has(name) { section.number(name) } else { Some(absent) };
    let momentum_limit = or("momentum_limit_n_m_s", f64::INFINITY);
    let (momentum, weight) = (or("momentum_n_m_s", 0.0), or("effort_weight", 1.0));
    let torque_limit =
        if section.has("torque_limit_n_m") { Some(section.number("torque_limit_n_m")?) } else { None };
    let (momentum, momentum_limit) = (momentum?, momentum_limit?);
    if momentum.abs() > momentum_limit * (1.0 + BOUNDARY_ROUNDING) {
        let reason = format!(
            "{} starts with {} N·m·s, but its limit is {} N·m·s",
            called("wheel", section, index),
            show(momentum),
            show(momentum_limit)
        );
        let remedy = "unload the wheel first, or check the sign and the unit";
        return section.refuse("E0063", "momentum_n_m_s", reason, remedy);
    }
    Some(Wheel { axis: axis?, torque_limit, momentum_limit, momentum, weight: weight? })
}

/// Reads the spin axis of the wheel and scales it to unit length.
fn axis(section: &Section, index: usize) -> Option<Vector3> {
    let axis = section.vector("axis_body")?;
    let size = axis.amax();
    if size < SMALLEST {
        let reason = format!(
            "the axis of {} has length zero, so it has no direction",
            called("wheel", section, index)
        );
        return section.refuse(
            "E0054",
            "axis_body",
            reason,
            "remove the wheel, or give its axis a direction",
        );
    }
    let length = size * (axis / size).norm();
    if (length - 1.0).abs() > SILENT {
        let reason = format!(
            "the axis of {} has length {}; it is scaled to 1, so that torque and momentum are those \
            of the wheel",
            called("wheel", section, index),
            short(length)
        );
        section.warn(
            "W0062",
            "axis_body",
            reason,
            "give a vector of length 1; no action is needed if only the direction matters",
        );
    }
    Some(section.unit(axis))
}

/// Returns the torque limits of all wheels, or `Some(None)` if no wheel has a limit. If only some
/// wheels have a limit, reports an error and returns `None`.
fn torque_limits(wheels: &[Wheel], sections: &[Section]) -> Option<Option<Vec<f64>>> {
    let limits: Vec<f64> = wheels.iter().filter_map(|wheel| wheel.torque_limit).collect();
    if limits.is_empty() {
        return Some(None);
    }
    let missing = wheels.iter().position(|wheel| wheel.torque_limit.is_none());
    let Some(index) = missing else { return Some(Some(limits)) };
    let wheel = called("wheel", &sections[index], index);
    let reason = format!("{wheel} has no `torque_limit_n_m`, but others have");
    let largest = limits.into_iter().fold(0.0, f64::max);
    let remedy = format!(
        "give every wheel a limit, such as torque_limit_n_m = {}, or give no wheel a limit",
        show(largest)
    );
    sections[index].refuse_here("E0021", reason, remedy)
}
