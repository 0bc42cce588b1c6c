//! Page of a simulation: its motion, and the conservation of energy and momentum.

use super::attitude::{euler_chart, quaternion_chart};
use super::body::motion;
use super::charts::{components, shown, time_axis};
use super::page::{Content, Words, written};
use super::sphere::axes_on_sphere;
use super::summary::Tone;
use super::{Shown, line};
use crate::draw::{Axis, Chart, Curve};
use serde_json::Value;
use slewkit::Vector3;
use slewkit::numerics::figures::{error, short};
use slewkit_files::export::{BodyRows, SimulationFile};

/// Returns the page of a simulation, from the document of `slew simulate --format json`.
/// `sequence` is the sequence of the Euler angles, one of
/// [`slewkit_files::export::EULER_SEQUENCES`].
pub fn simulation_page(file: &SimulationFile, sequence: &str) -> String {
    let rows = &file.trajectory;
    let shown = simulation_pictures(file, sequence);
    let cube: [Vector3; 8] = std::array::from_fn(|index| {
        Vector3::from_fn(|axis, _| if index >> axis & 1 == 0 { -0.8 } else { 0.8 })
    });
    // The motion is animated only if the simulation has a single body.
    let body = match &rows.bodies[..] {
        [one] if !rows.time_s.is_empty() => {
            motion(&rows.time_s, &one.quaternion_wxyz, &vectors(&one.position_m), &cube)
        }
        _ => Value::Null,
    };
    written(&Content {
        name: &file.name,
        words: &words(file),
        tiles: Vec::new(),
        proved: vec![
            "No optimum is claimed: a simulation only propagates its bodies. Conserved quantities \
            are compared with their initial values."
                .into(),
        ],
        shown,
        missing: Vec::new(),
        grouped: None,
        tables: Vec::new(),
        body,
        nodes: rows.time_s.len(),
    })
}

/// Returns the text at the top of the page: the method, the steps and the largest errors.
fn words(file: &SimulationFile) -> Words {
    let label = |label: &str, text: String| (label.to_string(), text);
    let mut summary = vec![
        label("integrator", file.integrator.clone()),
        label(
            "steps",
            format!("{} of {} s, {} s in all", file.steps, short(file.step_s), short(file.duration_s)),
        ),
    ];
    let errors = file.errors.iter().filter_map(|(key, value)| Some((key, value.as_f64()?)));
    for (index, (key, value)) in errors.enumerate() {
        let name = if index == 0 { "largest errors" } else { "" };
        summary.push(label(name, format!("{key} {}", error(value))));
    }
    let tone = if file.status == "simulated" { Tone::Good } else { Tone::Note };
    Words { verdict: file.status.replace('_', " "), tone, summary, details: Vec::new() }
}

fn vectors(rows: &[[f64; 3]]) -> Vec<Vector3> {
    rows.iter().map(|row| Vector3::from(*row)).collect()
}

/// Returns the pictures of a simulation: the motion of each body, followed by the conserved
/// quantities of all bodies. `sequence` is the sequence of the Euler angles, which are shown for a
/// single body.
pub fn simulation_pictures(file: &SimulationFile, sequence: &str) -> Vec<Shown> {
    let rows = &file.trajectory;
    let time = &rows.time_s;
    if time.is_empty() {
        return Vec::new();
    }
    let prefix = |body: &BodyRows, symbol: &str| match rows.bodies.len() {
        1 => symbol.to_string(),
        _ => format!("{} {symbol}", body.name),
    };
    let of_bodies = |symbol: &str, factor: f64, of: fn(&BodyRows) -> &Vec<[f64; 3]>| -> Vec<Curve> {
        let curves = rows
            .bodies
            .iter()
            .flat_map(|body| components(time, &vectors(of(body)), &prefix(body, symbol), factor, false));
        curves.enumerate().map(|(style, curve)| Curve { style, ..curve }).collect()
    };
    let degrees = 1.0_f64.to_degrees();
    let rates = of_bodies("Ω ", degrees, |body| &body.angular_velocity_rad_s);
    let rates = Chart::new("Angular velocity", time_axis(), Axis::linear("Ω, deg/s"), rates);
    let mut all = Vec::new();
    if let [body] = &rows.bodies[..] {
        all.push(axes_on_sphere(&body.quaternion_wxyz));
    }
    all.push(shown("rates", rates, "inertial, in body axes"));
    if rows.bodies.iter().any(|body| !body.position_m.is_empty()) {
        let curves = of_bodies("", 1.0, |body| &body.position_m);
        let chart = Chart::new("Position", time_axis(), Axis::linear("position, m"), curves);
        all.push(shown("position", chart, ""));
    }
    if let [body] = &rows.bodies[..] {
        all.push(euler_chart(time, &body.quaternion_wxyz, sequence));
        all.push(quaternion_chart(time, &body.quaternion_wxyz));
    }
    all.extend(kept(file));
    all
}

/// Returns the charts of the conserved quantities: the errors of energy and angular momentum
/// relative to their initial values, and the orthogonality error of `RᵀR = I`.
fn kept(file: &SimulationFile) -> [Shown; 3] {
    let rows = &file.trajectory;
    let time = &rows.time_s;
    let chart = |key, title: &str, name: &str, label: &str, values: &mut dyn Iterator<Item = f64>| {
        let curves = vec![line(name, 0, time, values)];
        shown(key, Chart::new(title, time_axis(), Axis::linear(label), curves), "")
    };
    let energy = rows.energy_j[0];
    let momenta = vectors(&rows.angular_momentum_n_m_s);
    [
        chart("energy", "Energy", "E − E₀", "E − E₀, J", &mut rows.energy_j.iter().map(|now| now - energy)),
        chart(
            "angular_momentum",
            "Angular momentum in inertial axes",
            "|L − L₀|",
            "|L − L₀|, N·m·s",
            &mut momenta.iter().map(|now| (now - momenta[0]).norm()),
        ),
        chart(
            "orthogonality",
            "Attitude matrices",
            "‖I − RᵀR‖",
            "‖I − RᵀR‖",
            &mut rows.orthogonality_error.iter().copied(),
        ),
    ]
}
