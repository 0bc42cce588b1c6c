//! Random maneuvers of every kind, as specs in TOML.
//!
//! A spec depends on its index alone. The kinds take turns, so any 26 in a row hold each once; notations of
//! attitudes, units, schemes, paths and grids are drawn anew for each. All are valid specs of moderate size; a
//! few have no solution, on purpose.

#[path = "random.rs"]
pub mod random;

use random::Random;
use std::fmt::Write;

/// A maneuver as the planner reads it.
pub struct RandomSpec {
    /// What is special about it, as a file name.
    pub kind: &'static str,
    /// The spec in TOML.
    pub text: String,
}

/// A kind of maneuver, and what writes one.
type Kind = (&'static str, fn(&mut Draft));

/// The kinds, in turn.
const KINDS: [Kind; 26] = [
    ("rest_to_rest", |draft| draft.slew()),
    ("moving_ends", moving_ends),
    ("principal_axis", principal_axis),
    ("winding", winding),
    ("pendulum", pendulum),
    ("pendulum_reference_torques", pendulum_reference_torques),
    ("gravity_gradient", gravity_gradient),
    ("free_flyer", free_flyer),
    ("body_thrusters", body_thrusters),
    ("central_points", |draft| central_gravity(draft, true)),
    ("central_second_order", |draft| central_gravity(draft, false)),
    ("two_torques", two_torques),
    ("redundant_axes", redundant_axes),
    ("reference_torques", reference_torques),
    ("torque_limit", torque_limit),
    ("torque_norm_limit", torque_norm_limit),
    ("torque_rate_limit", torque_rate_limit),
    ("force_limits", force_limits),
    ("rate_limit", rate_limit),
    ("keep_out", keep_out),
    ("keep_in", keep_in),
    ("cones_in_orbit", cones_in_orbit),
    ("wheels", wheels),
    ("limited_pendulum", limited_pendulum),
    ("everything", everything),
    ("infeasible", infeasible),
];

/// The spec of this index.
pub fn random_spec(index: u64) -> RandomSpec {
    let (kind, build) = KINDS[(index % KINDS.len() as u64) as usize];
    let mut draft = Draft::new(index);
    build(&mut draft);
    draft.solver();
    RandomSpec { kind, text: draft.text(kind, index) }
}

/// The kinds of maneuvers whose inputs switch, in turn.
const SWITCHING_KINDS: [Kind; 8] = [
    ("minimum_time", |draft| switching(draft, "time", Inputs::Axes)),
    ("minimum_time_redundant_axes", |draft| switching(draft, "time", Inputs::RedundantAxes)),
    ("minimum_time_norm", |draft| switching(draft, "time", Inputs::Norm)),
    ("minimum_fuel", |draft| switching(draft, "fuel", Inputs::Axes)),
    ("minimum_fuel_thrusters", |draft| switching(draft, "fuel", Inputs::Thrusters)),
    ("minimum_fuel_norm", |draft| switching(draft, "fuel", Inputs::Norm)),
    ("minimum_fuel_price_of_time", |draft| switching(draft, "fuel and time", Inputs::Axes)),
    ("minimum_time_thrusters", |draft| switching(draft, "time", Inputs::Thrusters)),
];

/// The spec of this index among those of minimum time and fuel: a stream of its own, so that the other stays as it is.
// Each binary uses its own part.
#[allow(dead_code)]
pub fn random_switching_spec(index: u64) -> RandomSpec {
    let (kind, build) = SWITCHING_KINDS[(index % SWITCHING_KINDS.len() as u64) as usize];
    let mut draft = Draft::new(index ^ 0x0051_71c4);
    build(&mut draft);
    RandomSpec { kind, text: draft.text(kind, index) }
}

type Vector = [f64; 3];
/// Scalar first.
type Quaternion = [f64; 4];

/// A spec that is being written.
struct Draft {
    random: Random,
    /// Headers of tables and their lines, in the order of the text.
    tables: Vec<(&'static str, Vec<String>)>,
    /// Mean principal moment of inertia [kg·m²].
    inertia: f64,
    /// [s]
    duration: f64,
    start: Quaternion,
    end: Quaternion,
}

impl Draft {
    fn new(index: u64) -> Self {
        let mut random = Random::new(index.wrapping_mul(0xd134_2543_de82_ef95) ^ 10);
        let inertia = 10.0_f64.powf(random.within(-1.0, 3.0));
        let duration = 10.0_f64.powf(random.within(0.0, 2.0));
        let start = [1.0, 0.0, 0.0, 0.0];
        Self { random, tables: Vec::new(), inertia, duration, start, end: start }
    }

    // The text.

    /// Appends a table.
    fn open(&mut self, header: &'static str) {
        self.tables.push((header, Vec::new()));
    }

    /// Appends a line to the last table of this header, which is made where there is none.
    fn line(&mut self, header: &'static str, line: String) {
        if !self.tables.iter().any(|(name, _)| *name == header) {
            self.open(header);
        }
        let table = self.tables.iter_mut().rev().find(|(name, _)| *name == header);
        table.expect("it has just been made").1.push(line);
    }

    fn text(&self, kind: &str, index: u64) -> String {
        let mut text = format!("format = 1\nname = \"{kind} № {index}\"\n");
        for (header, lines) in &self.tables {
            write!(text, "\n{header}\n{}\n", lines.join("\n")).expect("a string grows");
        }
        text
    }

    // Small draws.

    fn chance(&mut self, part: f64) -> bool {
        self.random.unit() < part
    }

    fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        self.random.pick(choices)
    }

    fn vector(&mut self, size: f64) -> Vector {
        std::array::from_fn(|_| size * self.random.uniform())
    }

    /// Uniform on the unit sphere.
    fn direction(&mut self) -> Vector {
        loop {
            let v = self.vector(1.0);
            if (0.01..=1.0).contains(&dot(v, v)) {
                return scaled(v, 1.0 / dot(v, v).sqrt());
            }
        }
    }

    /// Any rotation in any notation: what it is, and its text.
    fn rotation(&mut self) -> (Quaternion, String) {
        const SEQUENCES: [&str; 12] =
            ["xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"];
        let (axis, angle) = (self.direction(), self.random.within(0.3, 3.1));
        let q = turn(axis, angle);
        let [w, x, y, z] = q;
        let degrees = self.chance(0.5);
        let unit = if degrees { "deg" } else { "rad" };
        let write = |angle: f64| if degrees { angle.to_degrees() } else { angle };
        match self.random.below(7) {
            0 => (q, format!("{{ quaternion_wxyz = {} }}", list(&[w, x, y, z]))),
            1 => (q, format!("{{ quaternion_xyzw = {} }}", list(&[x, y, z, w]))),
            2 => {
                let length = self.random.within(0.5, 2.0);
                (q, format!("{{ axis = {}, angle_{unit} = {} }}", list(&scaled(axis, length)), write(angle)))
            }
            3 => (q, format!("{{ rotation_vector_{unit} = {} }}", list(&scaled(axis, angle).map(write)))),
            4 => {
                let rows: Vec<String> = matrix(q).iter().map(|row| list(row)).collect();
                (q, format!("{{ matrix = [{}] }}", rows.join(", ")))
            }
            _ => {
                let sequence = self.pick(&SEQUENCES);
                let angles = self.vector(2.5);
                let turns = sequence.bytes().zip(angles).map(|(letter, angle)| {
                    turn(std::array::from_fn(|i| f64::from(u8::from(letter == b"xyz"[i]))), angle)
                });
                let q = turns.fold([1.0, 0.0, 0.0, 0.0], product);
                (q, format!("{{ euler_{sequence}_{unit} = {} }}", list(&angles.map(write))))
            }
        }
    }

    /// An angular velocity of `rate` [rad/s] in either unit.
    fn rate(&mut self, header: &'static str, rate: Vector) {
        let line = if self.chance(0.5) {
            format!("angular_velocity_rad_s = {}", list(&rate))
        } else {
            format!("angular_velocity_deg_s = {}", list(&rate.map(f64::to_degrees)))
        };
        self.line(header, line);
    }

    // The pieces of every spec.

    /// Ratios of principal moments that a body of positive density can have, of mean 1.
    fn moments(&mut self) -> Vector {
        let d: Vector = std::array::from_fn(|_| self.random.within(0.15, 1.0));
        let sum = 2.0 * (d[0] + d[1] + d[2]) / 3.0;
        [d[1] + d[2], d[2] + d[0], d[0] + d[1]].map(|moment| moment / sum)
    }

    /// The inertia, of mean `self.inertia`: three principal moments or a whole matrix.
    fn body(&mut self) {
        let moments = self.moments();
        let diagonal = scaled(moments, self.inertia);
        let line = if self.chance(0.4) {
            list(&diagonal)
        } else {
            let axes = matrix(turn(self.direction(), self.random.within(0.0, 3.0)));
            let entry = |row: usize, column: usize| -> f64 {
                // In one order for both sides of the diagonal.
                let (a, b) = (row.min(column), row.max(column));
                (0..3).map(|k| axes[a][k] * diagonal[k] * axes[b][k]).sum()
            };
            let rows: Vec<String> =
                (0..3).map(|row| list(&[entry(row, 0), entry(row, 1), entry(row, 2)])).collect();
            format!("[{}]", rows.join(", "))
        };
        self.line("[body]", format!("inertia_kg_m2 = {line}"));
    }

    /// Two attitudes.
    fn ends(&mut self) {
        let (start, text) = self.rotation();
        self.line("[start]", format!("attitude = {text}"));
        let (end, text) = self.rotation();
        self.line("[end]", format!("attitude = {text}"));
        (self.start, self.end) = (start, end);
    }

    /// Duration, grid and path.
    fn maneuver(&mut self) {
        let steps = 20 + self.random.below(131);
        self.line("[maneuver]", format!("duration_s = {}", self.duration));
        match self.random.below(4) {
            0 => self.line("[maneuver]", format!("step_s = {}", self.duration / steps as f64)),
            1 if steps > 100 => {}
            _ => self.line("[maneuver]", format!("steps = {steps}")),
        }
        if self.chance(0.3) {
            self.line("[maneuver]", "minimize = \"effort\"".into());
        }
        let path = self.pick(&["", "", "best", "shortest", "shortest", "long"]);
        if !path.is_empty() {
            self.line("[maneuver]", format!("path = \"{path}\""));
        }
    }

    /// A free body from rest to rest.
    fn slew(&mut self) {
        self.body();
        self.ends();
        self.maneuver();
    }

    /// The settings, each now and then. No limit of time: the answer would depend on the machine.
    fn solver(&mut self) {
        if self.chance(0.4) {
            let scheme = self.pick(&["lie_euler", "lie_euler", "lie_verlet"]);
            self.line("[solver]", format!("scheme = \"{scheme}\""));
        }
        if self.chance(0.15) {
            let tolerance = self.pick(&["1e-9", "1e-10", "1e-11"]);
            self.line("[solver]", format!("tolerance = {tolerance}"));
        }
        if self.chance(0.15) {
            let tolerance = self.pick(&["0.001", "0.1", "2"]);
            self.line("[solver]", format!("continuous_tolerance_deg = {tolerance}"));
        }
        if self.chance(0.15) {
            let count = 20 + self.random.below(60);
            self.line("[solver]", format!("max_iterations = {count}"));
        }
    }

    // Scales of the maneuver.

    /// Angle between start and end, the short way [rad].
    fn angle(&self) -> f64 {
        let [w, x, y, z] = product(conjugate(self.start), self.end);
        2.0 * (x * x + y * y + z * z).sqrt().atan2(w.abs())
    }

    /// Largest torque of the rotation about a fixed axis from rest to rest, mean inertia: 6 J θ/T² [N·m].
    fn peak_torque(&self) -> f64 {
        6.0 * self.inertia * self.angle() / self.duration.powi(2)
    }

    /// Largest rate of that rotation: 3/2 θ/T [rad/s].
    fn peak_rate(&self) -> f64 {
        1.5 * self.angle() / self.duration
    }

    /// A weight of `count` inputs: numbers, or a symmetric matrix whose diagonal dominates.
    fn weight(&mut self, count: usize) -> String {
        let diagonal: Vec<f64> = (0..count).map(|_| self.random.within(0.5, 3.0)).collect();
        if self.chance(0.5) {
            return list(&diagonal);
        }
        let beside = self.random.within(-0.1, 0.1);
        let entry = |row, column| if row == column { diagonal[row] } else { beside };
        let row = |row| list(&(0..count).map(|column| entry(row, column)).collect::<Vec<_>>());
        format!("[{}]", (0..count).map(row).collect::<Vec<_>>().join(", "))
    }

    /// One limit for all inputs, or one for each.
    fn limits(&mut self, limit: f64) -> String {
        if self.chance(0.5) {
            return format!("{limit}");
        }
        list(&std::array::from_fn::<f64, 3, _>(|_| limit * self.random.within(0.9, 1.3)))
    }

    /// A position or another vector of the whole body, at both ends.
    fn travel(&mut self, header: &'static str, position: Vector, velocity: Vector) {
        self.line(header, format!("position_m = {}", list(&position)));
        self.line(header, format!("velocity_m_s = {}", list(&velocity)));
    }

    /// Positions of a free body, `size` apart, at rest or not.
    fn travels(&mut self, size: f64) {
        let mass = self.inertia * self.random.within(1.0, 4.0);
        self.line("[body]", format!("mass_kg = {mass}"));
        for header in ["[start]", "[end]"] {
            let position = self.vector(size);
            let speed = if self.chance(0.5) { 0.0 } else { 0.5 * size / self.duration };
            let velocity = self.vector(speed);
            self.travel(header, position, velocity);
        }
    }

    /// A method that can hold limits of inputs alone.
    fn method(&mut self) {
        let method = self.pick(&["auto", "shooting", "scp"]);
        self.line("[solver]", format!("method = \"{method}\""));
    }

    /// A cone with a boresight that crosses it half way from start to end, or that it holds all the way.
    fn cone(&mut self, kind: &str) {
        let boresight = self.direction();
        let (start, end) = (rotated(self.start, boresight), rotated(self.end, boresight));
        let relative = product(conjugate(self.start), self.end);
        let relative = if relative[0] < 0.0 { relative.map(|part| -part) } else { relative };
        let angle = self.angle();
        let axis = scaled([relative[1], relative[2], relative[3]], 1.0 / (0.5 * angle).sin());
        let middle = rotated(product(self.start, turn(axis, 0.5 * angle)), boresight);
        let aside = turn(self.direction(), self.random.within(0.02, 0.2));
        let center = rotated(aside, middle);
        let away = |other| dot(center, other).clamp(-1.0, 1.0).acos().to_degrees();
        let margin = if self.chance(0.4) { 1.5 } else { 0.0 };
        let half_angle = if kind == "keep_in" {
            away(start).max(away(end)) + margin + self.random.within(3.0, 15.0)
        } else {
            (away(start).min(away(end)) - margin - 2.0).min(self.random.within(8.0, 30.0))
        };
        if !(1.0..170.0).contains(&half_angle) {
            return;
        }
        self.open("[[constraint]]");
        self.line("[[constraint]]", format!("kind = \"{kind}\""));
        if self.chance(0.5) {
            let name = format!("name = \"{kind} {}\"", self.tables.len());
            self.line("[[constraint]]", name);
        }
        let length = self.random.within(0.5, 2.0);
        self.line("[[constraint]]", format!("boresight_body = {}", list(&scaled(boresight, length))));
        let center = if self.chance(0.5) {
            format!("{{ vector = {} }}", list(&center))
        } else {
            let (ra, dec) = (center[1].atan2(center[0]).to_degrees(), center[2].asin().to_degrees());
            format!("{{ ra_deg = {ra}, dec_deg = {dec} }}")
        };
        let frame = self.pick(&["inertial", "reference"]);
        self.line("[[constraint]]", format!("direction_{frame} = {center}"));
        self.line("[[constraint]]", format!("half_angle_deg = {half_angle}"));
        if margin > 0.0 {
            self.line("[[constraint]]", format!("margin_deg = {margin}"));
        }
    }

    /// A limit of the rate, of its norm or about each axis [rad/s].
    fn rate_constraint(&mut self, limit: f64) {
        let unit = self.pick(&["rad", "deg"]);
        let limit = if unit == "deg" { limit.to_degrees() } else { limit };
        let limits = self.limits(limit);
        self.open("[[constraint]]");
        self.line("[[constraint]]", "kind = \"rate_limit\"".into());
        self.line("[[constraint]]", format!("angular_velocity_limit_{unit}_s = {limits}"));
    }
}

// The kinds.

fn moving_ends(draft: &mut Draft) {
    draft.slew();
    let size = 3.0 / draft.duration;
    for header in ["[start]", "[end]"] {
        let rate = draft.vector(size);
        draft.rate(header, rate);
    }
}

/// About one axis of a diagonal inertia, from any attitude.
fn principal_axis(draft: &mut Draft) {
    let diagonal = scaled(draft.moments(), draft.inertia);
    draft.line("[body]", format!("inertia_kg_m2 = {}", list(&diagonal)));
    let (_, text) = draft.rotation();
    draft.line("[start]", format!("attitude = {text}"));
    let axis = draft.pick(&["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]", "[0, 0, -2]"]);
    let angle = draft.pick(&["deg = 90", "deg = 180", "deg = 30", "rad = 2.5", "deg = 179.99"]);
    draft.line("[end]", format!("rotation_from_start = {{ axis = {axis}, angle_{angle} }}"));
    draft.maneuver();
}

/// A rotation that is taken as written, up to two turns.
fn winding(draft: &mut Draft) {
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

/// A body on a pivot: the mass center a fifth of the radius of gyration away, time of the order of a swing.
fn pendulum(draft: &mut Draft) {
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

fn pendulum_reference_torques(draft: &mut Draft) {
    pendulum(draft);
    reference_axes(draft);
}

fn limited_pendulum(draft: &mut Draft) {
    pendulum(draft);
    let part = draft.random.within(0.9, 2.0);
    let limit = format!("torque_norm_limit_n_m = {}", part * draft.peak_torque());
    draft.line("[actuators]", limit);
}

/// An orbit of any rate, a tenth to a whole radian of it; from rest against the turning frame or not.
fn gravity_gradient(draft: &mut Draft) {
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

fn cones_in_orbit(draft: &mut Draft) {
    gravity_gradient(draft);
    draft.cone("keep_out");
}

fn free_flyer(draft: &mut Draft) {
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

/// Forces along body axes; a dear rotation, so that both parts feel each other.
fn body_thrusters(draft: &mut Draft) {
    draft.slew();
    draft.travels(2.0);
    draft.line("[actuators]", "force_axes_body = [[1, 0, 0], [0, 1, 0], [0, 0.6, 0.8]]".into());
    let (torque, force) = (draft.weight(3), draft.weight(3));
    draft.line("[actuators]", format!("effort_weight = {torque}"));
    draft.line("[actuators]", format!("force_effort_weight = {force}"));
}

fn force_limits(draft: &mut Draft) {
    draft.inertia = 1.0;
    draft.duration = draft.random.within(2.0, 4.0);
    draft.slew();
    draft.line("[body]", "mass_kg = 2".into());
    for (header, position) in [("[start]", [0.0; 3]), ("[end]", [1.0, 0.3, -0.5])] {
        draft.travel(header, position, [0.0; 3]);
    }
    // Along the first axis 6 m x/T² without limits.
    let peak = 12.0 / draft.duration.powi(2);
    let line = match draft.random.below(3) {
        0 => format!("force_limit_n = {}", draft.limits(0.9 * peak)),
        1 => format!("force_norm_limit_n = {}", 0.95 * peak),
        _ => format!("force_rate_limit_n_per_s = {}", draft.limits(2.5 * peak / draft.duration)),
    };
    draft.line("[actuators]", line);
}

/// In units of the orbit: radius, rate and gravitational parameter near 1, or those of a low Earth orbit.
fn central_gravity(draft: &mut Draft, points: bool) {
    let (radius, parameter) = if draft.chance(0.7) { (1.0, 1.0) } else { (7.0e6, 3.986_004_418e14) };
    let rate = (parameter / f64::powi(radius, 3)).sqrt();
    draft.duration = draft.random.within(0.3, 1.8) / rate;
    let mass = if radius > 1.0 { 50.0 } else { 1.0 };
    let size = if radius > 1.0 { 1.0 } else { 0.1 };
    draft.line("[environment]", "kind = \"central_gravity\"".into());
    draft.line("[environment]", format!("gravitational_parameter_m3_s2 = {parameter}"));
    if points {
        // Two pairs of points on two axes, and their inertia.
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
    // Along a circle, the end a little aside.
    for (header, anomaly) in [("[start]", 0.0), ("[end]", rate * draft.duration)] {
        let (sin, cos) = f64::sin_cos(anomaly);
        let aside = draft.vector(if header == "[end]" { 0.1 } else { 0.0 });
        let position: Vector = [cos + aside[0], sin + aside[1], aside[2]];
        draft.travel(header, scaled(position, radius), scaled([-sin, cos, 0.0], radius * rate));
        let spin = draft.vector(rate);
        draft.rate(header, spin);
    }
}

fn two_torques(draft: &mut Draft) {
    draft.slew();
    let axes =
        draft.pick(&["[[1, 0, 0], [0, 1, 0]]", "[[0, 1, 0], [0, 0, 1]]", "[[1, 0, 0], [0, 0.6, 0.8]]"]);
    draft.line("[actuators]", format!("torque_axes_body = {axes}"));
    if draft.chance(0.5) {
        let weight = draft.weight(2);
        draft.line("[actuators]", format!("effort_weight = {weight}"));
    }
}

fn redundant_axes(draft: &mut Draft) {
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

fn reference_axes(draft: &mut Draft) {
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

fn reference_torques(draft: &mut Draft) {
    draft.slew();
    reference_axes(draft);
}

fn torque_limit(draft: &mut Draft) {
    draft.slew();
    let part = draft.random.within(0.65, 1.1);
    let limits = draft.limits(part * draft.peak_torque());
    draft.line("[actuators]", format!("torque_limit_n_m = {limits}"));
    draft.method();
}

fn torque_norm_limit(draft: &mut Draft) {
    draft.slew();
    let part = draft.random.within(0.75, 1.1);
    let line = format!("torque_norm_limit_n_m = {}", part * draft.peak_torque());
    draft.line("[actuators]", line);
    draft.method();
}

/// The rate of the torque of an unlimited rotation is 12 J θ/T³.
fn torque_rate_limit(draft: &mut Draft) {
    draft.slew();
    let part = draft.random.within(2.0, 6.0);
    let limits = draft.limits(part * draft.peak_torque() / draft.duration);
    draft.line("[actuators]", format!("torque_rate_limit_n_m_per_s = {limits}"));
    if draft.chance(0.3) {
        let limits = draft.limits(1.1 * draft.peak_torque());
        draft.line("[actuators]", format!("torque_limit_n_m = {limits}"));
    }
}

fn rate_limit(draft: &mut Draft) {
    draft.slew();
    let part = draft.random.within(0.8, 1.1);
    draft.rate_constraint(part * draft.peak_rate());
}

fn keep_out(draft: &mut Draft) {
    draft.slew();
    draft.cone("keep_out");
    if draft.chance(0.3) {
        draft.cone("keep_out");
    }
}

fn keep_in(draft: &mut Draft) {
    draft.slew();
    draft.cone("keep_in");
}

/// Three wheels along the axes or four in a pyramid.
fn wheels(draft: &mut Draft) {
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

/// Limits of the torque and of the rate, and a cone.
fn everything(draft: &mut Draft) {
    draft.slew();
    let limits = draft.limits(1.2 * draft.peak_torque());
    draft.line("[actuators]", format!("torque_limit_n_m = {limits}"));
    draft.rate_constraint(1.1 * draft.peak_rate());
    draft.cone("keep_out");
}

/// Too little torque, or too low a rate, for the time.
fn infeasible(draft: &mut Draft) {
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

/// What the inputs of a maneuver of minimum time or fuel are.
#[derive(Clone, Copy, PartialEq)]
enum Inputs {
    Axes,
    RedundantAxes,
    Norm,
    Thrusters,
}

/// From rest to rest or not, with torques that would do the turn about the eigenaxis in a part of the duration.
fn switching(draft: &mut Draft, minimized: &'static str, inputs: Inputs) {
    draft.body();
    draft.ends();
    let steps = 40 + draft.random.below(80);
    draft.line("[maneuver]", format!("steps = {steps}"));
    draft.line("[maneuver]", format!("minimize = \"{}\"", &minimized[..4]));
    // About the eigenaxis from rest to rest a torque τ takes 2 √(J θ/τ).
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

// Vectors and quaternions of their own: what checks the library must not share a slip with it.

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn scaled(v: Vector, factor: f64) -> Vector {
    v.map(|part| factor * part)
}

/// A turn about a unit axis.
fn turn(axis: Vector, angle: f64) -> Quaternion {
    let [x, y, z] = scaled(axis, (0.5 * angle).sin());
    [(0.5 * angle).cos(), x, y, z]
}

fn conjugate([w, x, y, z]: Quaternion) -> Quaternion {
    [w, -x, -y, -z]
}

fn product([a, b, c, d]: Quaternion, [w, x, y, z]: Quaternion) -> Quaternion {
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
}

fn rotated(q: Quaternion, [x, y, z]: Vector) -> Vector {
    let [_, x, y, z] = product(product(q, [0.0, x, y, z]), conjugate(q));
    [x, y, z]
}

fn matrix(q: Quaternion) -> [Vector; 3] {
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| rotated(q, axis));
    std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row]))
}

/// Numbers as a list of TOML.
fn list(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(|number| format!("{number}")).collect();
    format!("[{}]", numbers.join(", "))
}
