//! The draft of a random spec, and functions that draw its parts.

use super::turns::{Quaternion, Vector, conjugate, dot, list, matrix, product, rotated, scaled, turn};
use crate::Random;
use std::fmt::Write;

/// A spec that is being written.
pub struct Draft {
    pub random: Random,
    /// The headers of tables and their lines, in the order of the text.
    pub tables: Vec<(&'static str, Vec<String>)>,
    /// The mean principal moment of inertia [kg·m²].
    pub inertia: f64,
    /// The duration of the maneuver [s].
    pub duration: f64,
    pub start: Quaternion,
    pub end: Quaternion,
}

impl Draft {
    pub fn new(index: u64) -> Self {
        let mut random = Random::new(index.wrapping_mul(0xd134_2543_de82_ef95) ^ 10);
        let inertia = 10.0_f64.powf(random.within(-1.0, 3.0));
        let duration = 10.0_f64.powf(random.within(0.0, 2.0));
        let start = [1.0, 0.0, 0.0, 0.0];
        Self { random, tables: Vec::new(), inertia, duration, start, end: start }
    }

    // The text.

    /// Appends a table.
    pub fn open(&mut self, header: &'static str) {
        self.tables.push((header, Vec::new()));
    }

    /// Appends a line to the last table with this header, and creates the table if needed.
    pub fn line(&mut self, header: &'static str, line: String) {
        if !self.tables.iter().any(|(name, _)| *name == header) {
            self.open(header);
        }
        let table = self.tables.iter_mut().rev().find(|(name, _)| *name == header);
        table.expect("it has just been made").1.push(line);
    }

    pub fn text(&self, kind: &str, index: u64) -> String {
        let mut text = format!("format = 1\nname = \"{kind} № {index}\"\n");
        for (header, lines) in &self.tables {
            write!(text, "\n{header}\n{}\n", lines.join("\n")).expect("a string grows");
        }
        text
    }

    // Small draws.

    pub fn chance(&mut self, part: f64) -> bool {
        self.random.unit() < part
    }

    pub fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        self.random.pick(choices)
    }

    pub fn vector(&mut self, size: f64) -> Vector {
        std::array::from_fn(|_| size * self.random.uniform())
    }

    /// Draws a direction uniform on the unit sphere.
    pub fn direction(&mut self) -> Vector {
        loop {
            let v = self.vector(1.0);
            if (0.01..=1.0).contains(&dot(v, v)) {
                return scaled(v, 1.0 / dot(v, v).sqrt());
            }
        }
    }

    /// Draws a rotation, and returns it with its text in a random notation.
    pub fn rotation(&mut self) -> (Quaternion, String) {
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

    /// Writes the angular velocity `rate` [rad/s] in one of the two units.
    pub fn rate(&mut self, header: &'static str, rate: Vector) {
        let line = if self.chance(0.5) {
            format!("angular_velocity_rad_s = {}", list(&rate))
        } else {
            format!("angular_velocity_deg_s = {}", list(&rate.map(f64::to_degrees)))
        };
        self.line(header, line);
    }

    // The pieces of every spec.

    /// Draws principal moments that a body of positive density can have, relative to their mean.
    pub fn moments(&mut self) -> Vector {
        let d: Vector = std::array::from_fn(|_| self.random.within(0.15, 1.0));
        let sum = 2.0 * (d[0] + d[1] + d[2]) / 3.0;
        [d[1] + d[2], d[2] + d[0], d[0] + d[1]].map(|moment| moment / sum)
    }

    /// Writes an inertia with the mean moment `self.inertia`, as three principal moments or as a
    /// matrix.
    pub fn body(&mut self) {
        let moments = self.moments();
        let diagonal = scaled(moments, self.inertia);
        let line = if self.chance(0.4) {
            list(&diagonal)
        } else {
            let axes = matrix(turn(self.direction(), self.random.within(0.0, 3.0)));
            let entry = |row: usize, column: usize| -> f64 {
                // Both sides of the diagonal use the same entry.
                let (a, b) = (row.min(column), row.max(column));
                (0..3).map(|k| axes[a][k] * diagonal[k] * axes[b][k]).sum()
            };
            let rows: Vec<String> =
                (0..3).map(|row| list(&[entry(row, 0), entry(row, 1), entry(row, 2)])).collect();
            format!("[{}]", rows.join(", "))
        };
        self.line("[body]", format!("inertia_kg_m2 = {line}"));
    }

    /// Writes the attitudes of start and end.
    pub fn ends(&mut self) {
        let (start, text) = self.rotation();
        self.line("[start]", format!("attitude = {text}"));
        let (end, text) = self.rotation();
        self.line("[end]", format!("attitude = {text}"));
        (self.start, self.end) = (start, end);
    }

    /// Writes the duration, the grid and the path.
    pub fn maneuver(&mut self) {
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

    /// Writes a rest-to-rest slew of a free body.
    pub fn slew(&mut self) {
        self.body();
        self.ends();
        self.maneuver();
    }

    /// Writes some random settings. A time limit is not among them, because the answer would then
    /// depend on the machine.
    pub fn solver(&mut self) {
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

    /// Returns the angle between start and end, the short way [rad].
    pub fn angle(&self) -> f64 {
        let [w, x, y, z] = product(conjugate(self.start), self.end);
        2.0 * (x * x + y * y + z * z).sqrt().atan2(w.abs())
    }

    /// Returns the largest torque of a minimum-effort rest-to-rest turn about a fixed axis, with
    /// the mean inertia J: 6 J θ/T² [N·m].
    pub fn peak_torque(&self) -> f64 {
        6.0 * self.inertia * self.angle() / self.duration.powi(2)
    }

    /// Returns the largest rate of a minimum-effort rest-to-rest turn about a fixed axis: 3/2 θ/T
    /// [rad/s].
    pub fn peak_rate(&self) -> f64 {
        1.5 * self.angle() / self.duration
    }

    /// Draws the weight of `count` inputs: numbers, or a symmetric matrix whose diagonal dominates.
    pub fn weight(&mut self, count: usize) -> String {
        let diagonal: Vec<f64> = (0..count).map(|_| self.random.within(0.5, 3.0)).collect();
        if self.chance(0.5) {
            return list(&diagonal);
        }
        let beside = self.random.within(-0.1, 0.1);
        let entry = |row, column| if row == column { diagonal[row] } else { beside };
        let row = |row| list(&(0..count).map(|column| entry(row, column)).collect::<Vec<_>>());
        format!("[{}]", (0..count).map(row).collect::<Vec<_>>().join(", "))
    }

    /// Draws one limit for all inputs, or one limit for each input.
    pub fn limits(&mut self, limit: f64) -> String {
        if self.chance(0.5) {
            return format!("{limit}");
        }
        list(&std::array::from_fn::<f64, 3, _>(|_| limit * self.random.within(0.9, 1.3)))
    }

    /// Writes position and velocity under one of the two headers, start or end.
    pub fn travel(&mut self, header: &'static str, position: Vector, velocity: Vector) {
        self.line(header, format!("position_m = {}", list(&position)));
        self.line(header, format!("velocity_m_s = {}", list(&velocity)));
    }

    /// Writes positions of a free body at start and end, at the distance `size`, with or without
    /// velocities.
    pub fn travels(&mut self, size: f64) {
        let mass = self.inertia * self.random.within(1.0, 4.0);
        self.line("[body]", format!("mass_kg = {mass}"));
        for header in ["[start]", "[end]"] {
            let position = self.vector(size);
            let speed = if self.chance(0.5) { 0.0 } else { 0.5 * size / self.duration };
            let velocity = self.vector(speed);
            self.travel(header, position, velocity);
        }
    }

    /// Writes a method that supports limits on the inputs only.
    pub fn method(&mut self) {
        let method = self.pick(&["auto", "shooting", "scp"]);
        self.line("[solver]", format!("method = \"{method}\""));
    }

    /// Adds a cone of the given kind. The boresight crosses a keep-out cone half way from start to
    /// end; a keep-in cone contains the boresight on the whole path.
    pub fn cone(&mut self, kind: &str) {
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

    /// Writes a limit on the norm of the angular rate or on the rate about each axis [rad/s].
    pub fn rate_constraint(&mut self, limit: f64) {
        let unit = self.pick(&["rad", "deg"]);
        let limit = if unit == "deg" { limit.to_degrees() } else { limit };
        let limits = self.limits(limit);
        self.open("[[constraint]]");
        self.line("[[constraint]]", "kind = \"rate_limit\"".into());
        self.line("[[constraint]]", format!("angular_velocity_limit_{unit}_s = {limits}"));
    }
}
