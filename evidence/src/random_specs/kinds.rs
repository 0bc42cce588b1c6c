//! The functions that draft the kinds of random maneuvers.

use super::draft::Draft;
use super::turns::{Vector, conjugate, dot, list, rotated, scaled};

pub fn moving_ends(draft: &mut Draft) {
    draft.slew();
    let size = 3.0 / draft.duration;
    for header in ["[start]", "[end]"] {
        let rate = draft.vector(size);
        draft.rate(header, rate);
    }
}

/// Drafts a turn about one axis of a diagonal inertia, from any attitude.
pub fn principal_axis(draft: &mut Draft) {
    let diagonal = scaled(draft.moments(), draft.inertia);
    draft.line("[body]", format!("inertia_kg_m2 = {}", list(&diagonal)));
    let (_, text) = draft.rotation();
    draft.line("[start]", format!("attitude = {text}"));
    let axis = draft.pick(&["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]", "[0, 0, -2]"]);
    let angle = draft.pick(&["deg = 90", "deg = 180", "deg = 30", "rad = 2.5", "deg = 179.99"]);
    draft.line("[end]", format!("rotation_from_start = {{ axis = {axis}, angle_{angle} }}"));
    draft.maneuver();
}

/// Drafts a rotation that is planned as written, up to two turns.
pub fn winding(draft: &mut Draft) {
    draft.body();
    let (_, text) = draft.rotation();
    draft.line("[start]", format!("attitude = {text}"));
    let (axis, angle) = (draft.direction(), draft.random.within(1.0, 10.0));
    let text = match draft.random.below(4) {
        0 => format!("{{ axis = {}, angle_deg = {} }}", list(&axis), angle.to_degrees()),
        1 => format!("{{ axis = {}, angle_rad = {angle} }}", list(&axis)),
        2 => format!("{{ rotation_vector_rad = {} }}", list(&scaled(axis, angle))),
        _ => format!("{{ rotation_vector_deg = {} }}", list(&scaled(axis, angle.to_degrees()))),
    };
    draft.line("[end]", format!("rotation_from_start = {text}"));
    draft.line("[maneuver]", format!("duration_s = {}", draft.duration));
    let steps = 60 + draft.random.below(80);
    draft.line("[maneuver]", format!("steps = {steps}"));
    if draft.chance(0.5) {
        draft.line("[maneuver]", "path = \"as_given\"".into());
    }
}

/// Drafts a pendulum whose mass center is a fifth of the radius of gyration from the pivot, for
/// about the duration of a swing.
pub fn pendulum(draft: &mut Draft) {
    let mass = draft.random.within(0.5, 20.0);
    let arm = scaled(draft.direction(), draft.random.within(0.02, 0.3));
    let swing = (draft.inertia / (mass * 9.81 * dot(arm, arm).sqrt())).sqrt();
    draft.duration = swing * draft.random.within(0.7, 3.0);
    draft.slew();
    let direction = draft.direction();
    draft.line("[environment]", "kind = \"uniform_gravity\"".into());
    draft.line("[environment]", format!("mass_kg = {mass}"));
    draft.line("[environment]", "gravity_m_s2 = 9.81".into());
    draft.line("[environment]", format!("direction = {}", list(&direction)));
    draft.line("[environment]", format!("pivot_to_mass_center_m = {}", list(&arm)));
    if draft.chance(0.4) {
        let size = 1.0 / draft.duration;
        let rate = draft.vector(size);
        draft.rate("[end]", rate);
    }
}

pub fn pendulum_reference_torques(draft: &mut Draft) {
    pendulum(draft);
    reference_axes(draft);
}

pub fn limited_pendulum(draft: &mut Draft) {
    pendulum(draft);
    let part = draft.random.within(0.9, 2.0);
    let limit = format!("torque_norm_limit_n_m = {}", part * draft.peak_torque());
    draft.line("[actuators]", limit);
}

/// Drafts a maneuver over 0.1 to 1 rad of an orbit of any rate, which starts at rest relative to
/// the orbit frame or with a rate.
pub fn gravity_gradient(draft: &mut Draft) {
    draft.slew();
    let rate = draft.random.within(0.1, 1.0) / draft.duration;
    draft.line("[environment]", "kind = \"gravity_gradient\"".into());
    draft.line("[environment]", format!("orbital_rate_rad_s = {rate}"));
    for (header, attitude) in [("[start]", draft.start), ("[end]", draft.end)] {
        let still = scaled(rotated(conjugate(attitude), [0.0, 1.0, 0.0]), rate);
        let size = if draft.chance(0.5) { 0.0 } else { rate };
        let more = draft.vector(size);
        draft.rate(header, std::array::from_fn(|i| still[i] + more[i]));
    }
}

pub fn cones_in_orbit(draft: &mut Draft) {
    gravity_gradient(draft);
    draft.cone("keep_out");
}

pub fn free_flyer(draft: &mut Draft) {
    draft.slew();
    draft.travels(2.0);
    if draft.chance(0.6) {
        let weight = draft.weight(3);
        draft.line("[actuators]", format!("force_effort_weight = {weight}"));
    }
    if draft.chance(0.2) {
        draft.line("[actuators]", "force_axes_reference = [[1, 0, 0], [0, 1, 0], [0, 0, 2]]".into());
    }
}

/// Drafts a body with forces along body axes and costly torques, so that translation and rotation
/// affect each other.
pub fn body_thrusters(draft: &mut Draft) {
    draft.slew();
    draft.travels(2.0);
    draft.line("[actuators]", "force_axes_body = [[1, 0, 0], [0, 1, 0], [0, 0.6, 0.8]]".into());
    let (torque, force) = (draft.weight(3), draft.weight(3));
    draft.line("[actuators]", format!("effort_weight = {torque}"));
    draft.line("[actuators]", format!("force_effort_weight = {force}"));
}

pub fn force_limits(draft: &mut Draft) {
    draft.inertia = 1.0;
    draft.duration = draft.random.within(2.0, 4.0);
    draft.slew();
    draft.line("[body]", "mass_kg = 2".into());
    for (header, position) in [("[start]", [0.0; 3]), ("[end]", [1.0, 0.3, -0.5])] {
        draft.travel(header, position, [0.0; 3]);
    }
    // The first axis needs 6 m x/T² without limits.
    let peak = 12.0 / draft.duration.powi(2);
    let line = match draft.random.below(3) {
        0 => format!("force_limit_n = {}", draft.limits(0.9 * peak)),
        1 => format!("force_norm_limit_n = {}", 0.95 * peak),
        _ => format!("force_rate_limit_n_per_s = {}", draft.limits(2.5 * peak / draft.duration)),
    };
    draft.line("[actuators]", line);
}

/// Drafts a maneuver in central gravity, with radius, rate and gravitational parameter near 1, or
/// as in a low Earth orbit.
pub fn central_gravity(draft: &mut Draft, points: bool) {
    let (radius, parameter) = if draft.chance(0.7) { (1.0, 1.0) } else { (7.0e6, 3.986_004_418e14) };
    let rate = (parameter / f64::powi(radius, 3)).sqrt();
    draft.duration = draft.random.within(0.3, 1.8) / rate;
    let mass = if radius > 1.0 { 50.0 } else { 1.0 };
    let size = if radius > 1.0 { 1.0 } else { 0.1 };
    draft.line("[environment]", "kind = \"central_gravity\"".into());
    draft.line("[environment]", format!("gravitational_parameter_m3_s2 = {parameter}"));
    if points {
        // The body consists of two pairs of point masses on two axes.
        let (a, b) = (size, 0.7 * size);
        let m = 0.25 * mass;
        let inertia = [2.0 * m * b * b, 2.0 * m * a * a, 2.0 * m * (a * a + b * b)];
        draft.line("[body]", format!("inertia_kg_m2 = {}", list(&inertia)));
        draft.line("[environment]", "body = \"points\"".into());
        let places = [[a, 0.0, 0.0], [-a, 0.0, 0.0], [0.0, b, 0.0], [0.0, -b, 0.0]];
        let places = places.map(|place| format!("{{ mass_kg = {m}, position_m = {} }}", list(&place)));
        draft.line("[environment]", format!("points = [{}]", places.join(", ")));
    } else {
        draft.inertia = mass * size * size;
        draft.body();
        draft.line("[environment]", "body = \"second_order\"".into());
    }
    draft.line("[body]", format!("mass_kg = {mass}"));
    draft.ends();
    draft.maneuver();
    // Both ends lie on a circular orbit, the end with a small offset.
    for (header, anomaly) in [("[start]", 0.0), ("[end]", rate * draft.duration)] {
        let (sin, cos) = f64::sin_cos(anomaly);
        let aside = draft.vector(if header == "[end]" { 0.1 } else { 0.0 });
        let position: Vector = [cos + aside[0], sin + aside[1], aside[2]];
        draft.travel(header, scaled(position, radius), scaled([-sin, cos, 0.0], radius * rate));
        let spin = draft.vector(rate);
        draft.rate(header, spin);
    }
}

pub fn two_torques(draft: &mut Draft) {
    draft.slew();
    let axes =
        draft.pick(&["[[1, 0, 0], [0, 1, 0]]", "[[0, 1, 0], [0, 0, 1]]", "[[1, 0, 0], [0, 0.6, 0.8]]"]);
    draft.line("[actuators]", format!("torque_axes_body = {axes}"));
    if draft.chance(0.5) {
        let weight = draft.weight(2);
        draft.line("[actuators]", format!("effort_weight = {weight}"));
    }
}

pub fn redundant_axes(draft: &mut Draft) {
    draft.slew();
    let axes = "[[0.8, 0, 0.6], [0, 0.8, 0.6], [-0.8, 0, 0.6], [0, -0.8, 0.6]]";
    draft.line("[actuators]", format!("torque_axes_body = {axes}"));
    let weight = draft.weight(4);
    draft.line("[actuators]", format!("effort_weight = {weight}"));
    if draft.chance(0.3) {
        let limit = draft.peak_torque() * draft.random.within(0.35, 0.6);
        draft.line("[actuators]", format!("torque_limit_n_m = {limit}"));
    }
}

pub fn reference_axes(draft: &mut Draft) {
    let axes = draft.pick(&[
        "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]",
        "[[1, 0, 0], [0, 0.6, 0.8], [0, -0.8, 0.6]]",
        "[[1, 0, 0], [0, 2, 0], [0.3, 0, 1]]",
    ]);
    draft.line("[actuators]", format!("torque_axes_reference = {axes}"));
    if draft.chance(0.5) {
        let weight = draft.weight(3);
        draft.line("[actuators]", format!("effort_weight = {weight}"));
    }
}

pub fn reference_torques(draft: &mut Draft) {
    draft.slew();
    reference_axes(draft);
}

pub fn torque_limit(draft: &mut Draft) {
    draft.slew();
    let part = draft.random.within(0.65, 1.1);
    let limits = draft.limits(part * draft.peak_torque());
    draft.line("[actuators]", format!("torque_limit_n_m = {limits}"));
    draft.method();
}

pub fn torque_norm_limit(draft: &mut Draft) {
    draft.slew();
    let part = draft.random.within(0.75, 1.1);
    let line = format!("torque_norm_limit_n_m = {}", part * draft.peak_torque());
    draft.line("[actuators]", line);
    draft.method();
}

/// Drafts a limit on the rate of torque, relative to 12 J θ/T³, the rate of torque of the rotation
/// without a limit.
pub fn torque_rate_limit(draft: &mut Draft) {
    draft.slew();
    let part = draft.random.within(2.0, 6.0);
    let limits = draft.limits(part * draft.peak_torque() / draft.duration);
    draft.line("[actuators]", format!("torque_rate_limit_n_m_per_s = {limits}"));
    if draft.chance(0.3) {
        let limits = draft.limits(1.1 * draft.peak_torque());
        draft.line("[actuators]", format!("torque_limit_n_m = {limits}"));
    }
}

pub fn rate_limit(draft: &mut Draft) {
    draft.slew();
    let part = draft.random.within(0.8, 1.1);
    draft.rate_constraint(part * draft.peak_rate());
}

pub fn keep_out(draft: &mut Draft) {
    draft.slew();
    draft.cone("keep_out");
    if draft.chance(0.3) {
        draft.cone("keep_out");
    }
}

pub fn keep_in(draft: &mut Draft) {
    draft.slew();
    draft.cone("keep_in");
}

/// Drafts three wheels along the axes or four in a pyramid.
pub fn wheels(draft: &mut Draft) {
    draft.slew();
    let axes: &[&str] = if draft.chance(0.5) {
        &["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"]
    } else {
        &["[0.8, 0, 0.6]", "[0, 0.8, 0.6]", "[-0.8, 0, 0.6]", "[0, -0.8, 0.6]"]
    };
    let momentum = draft.inertia * draft.peak_rate();
    let (torque_limited, momentum_limited) = (draft.chance(0.5), draft.chance(0.7));
    for (index, axis) in axes.iter().enumerate() {
        draft.open("[[actuators.wheel]]");
        draft.line("[[actuators.wheel]]", format!("axis_body = {axis}"));
        if torque_limited {
            let limit = draft.peak_torque() * draft.random.within(0.9, 1.2);
            draft.line("[[actuators.wheel]]", format!("torque_limit_n_m = {limit}"));
        }
        if momentum_limited {
            let limit = momentum * draft.random.within(0.9, 1.4);
            draft.line("[[actuators.wheel]]", format!("momentum_limit_n_m_s = {limit}"));
        }
        if draft.chance(0.6) {
            let stored = momentum * 0.3 * draft.random.uniform();
            draft.line("[[actuators.wheel]]", format!("momentum_n_m_s = {stored}"));
        }
        if draft.chance(0.4) {
            let weight = draft.random.within(0.5, 3.0);
            draft.line("[[actuators.wheel]]", format!("effort_weight = {weight}"));
        }
        if draft.chance(0.5) {
            draft.line("[[actuators.wheel]]", format!("name = \"wheel {}\"", index + 1));
        }
    }
}

/// Drafts limits of the torque and of the rate, and a cone.
pub fn everything(draft: &mut Draft) {
    draft.slew();
    let limits = draft.limits(1.2 * draft.peak_torque());
    draft.line("[actuators]", format!("torque_limit_n_m = {limits}"));
    draft.rate_constraint(1.1 * draft.peak_rate());
    draft.cone("keep_out");
}

/// Drafts a maneuver whose torque or rate limit is too low for its duration.
pub fn infeasible(draft: &mut Draft) {
    draft.slew();
    let part = draft.random.within(0.1, 0.5);
    if draft.chance(0.5) {
        let line = format!("torque_norm_limit_n_m = {}", part * draft.peak_torque());
        draft.line("[actuators]", line);
    } else {
        let limit = part * draft.peak_rate();
        draft.rate_constraint(limit);
    }
}

/// The inputs of a minimum-time or minimum-fuel maneuver.
#[derive(Clone, Copy, PartialEq)]
pub enum Inputs {
    Axes,
    RedundantAxes,
    Norm,
    Thrusters,
}

/// Drafts a minimum-time or minimum-fuel maneuver, from rest to rest or between rates. The torques
/// suffice for the turn about the eigenaxis in a part of the duration.
pub fn switching(draft: &mut Draft, minimized: &'static str, inputs: Inputs) {
    draft.body();
    draft.ends();
    let steps = 40 + draft.random.below(80);
    draft.line("[maneuver]", format!("steps = {steps}"));
    draft.line("[maneuver]", format!("minimize = \"{}\"", &minimized[..4]));
    // A rest-to-rest turn about the eigenaxis with the torque τ takes 2 √(J θ/τ).
    let torque = 4.0 * draft.inertia * draft.angle().max(0.2) / draft.duration.powi(2);
    let spare = draft.random.within(2.0, 8.0);
    match minimized {
        "fuel" => draft.line("[maneuver]", format!("duration_s = {}", draft.duration)),
        "fuel and time" => {
            let price = torque * draft.random.within(0.2, 2.0);
            draft.line("[maneuver]", format!("time_price_per_s = {price}"));
        }
        _ => {}
    }
    let path = draft.pick(&["", "", "best", "shortest"]);
    if !path.is_empty() {
        draft.line("[maneuver]", format!("path = \"{path}\""));
    }
    if draft.chance(0.4) {
        let size = 0.3 / draft.duration;
        for header in ["[start]", "[end]"] {
            let rate = draft.vector(size);
            draft.rate(header, rate);
        }
    }
    let limit = spare * torque;
    let prices = minimized != "time" && draft.chance(0.5);
    match inputs {
        Inputs::Thrusters => {
            for octant in 0..8 {
                let sign = |bit: usize| if octant >> bit & 1 == 0 { 1.0 } else { -1.0 };
                let axis: Vector = std::array::from_fn(|bit| sign(bit) * draft.random.within(0.4, 0.7));
                let header = "[[actuators.thruster]]";
                draft.open(header);
                draft.line(header, format!("torque_axis_body = {}", list(&axis)));
                let limit = limit * draft.random.within(0.5, 1.0);
                draft.line(header, format!("torque_limit_n_m = {limit}"));
                if prices {
                    let price = draft.random.within(0.5, 2.0);
                    draft.line(header, format!("fuel_price = {price}"));
                }
            }
        }
        Inputs::Norm => draft.line("[actuators]", format!("torque_norm_limit_n_m = {limit}")),
        Inputs::Axes | Inputs::RedundantAxes => {
            let count = if inputs == Inputs::RedundantAxes { 4 } else { 3 };
            if count == 4 {
                let axes = "[[0.8, 0, 0.6], [0, 0.8, 0.6], [-0.8, 0, 0.6], [0, -0.8, 0.6]]";
                draft.line("[actuators]", format!("torque_axes_body = {axes}"));
            }
            let limits: Vec<f64> = (0..count).map(|_| limit * draft.random.within(0.7, 1.4)).collect();
            draft.line("[actuators]", format!("torque_limit_n_m = {}", list(&limits)));
            if prices {
                let prices: Vec<f64> = (0..count).map(|_| draft.random.within(0.5, 2.0)).collect();
                draft.line("[actuators]", format!("fuel_price = {}", list(&prices)));
            }
        }
    }
}
