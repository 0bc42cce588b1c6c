//! Writes attitude files as other programs do: one motion in every legal style of an AEM or a
//! table.
//!
//! The motion is `R(s) = R₀ exp(θ₁(s) a) exp(θ₂(s) b)` with `θ = Θ (3s² − 2s³)` and s from 0 to 1,
//! from rest to rest. Every attitude and rate is therefore known in closed form. Orbit frames, time
//! systems, Euler angles and quaternions are computed by formulas that are independent of the
//! library.

mod written;

pub use written::file;

use crate::Random;
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::FRAC_PI_2;

/// A motion from rest to rest.
#[derive(Clone, Debug)]
pub struct Motion {
    start: Matrix3,
    axes: [Vector3; 2],
    angles: [f64; 2],
    /// The duration \[s\].
    pub duration: f64,
}

impl Motion {
    /// Builds a motion of 20° to 170° about each of two axes, in whole seconds.
    pub fn random(random: &mut Random) -> Self {
        let angle = |random: &mut Random| random.within(20.0, 85.0).to_radians();
        Self {
            start: random.uniform_rotation(),
            axes: [random.direction(), random.direction()],
            angles: [angle(random), angle(random)],
            duration: (10 * (4 + random.below(30))) as f64,
        }
    }

    /// Returns the attitude, which maps body to reference, and the angular rate in body axes
    /// [rad/s].
    pub fn at(&self, time: f64) -> (Matrix3, Vector3) {
        let s = time / self.duration;
        let (part, slope) = (s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / self.duration);
        let [first, second] = [0, 1].map(|k| lie::exp(&(self.axes[k] * self.angles[k] * part)));
        let rate =
            self.axes[1] * self.angles[1] * slope + second.tr_mul(&(self.axes[0] * self.angles[0] * slope));
        (self.start * first * second, rate)
    }
}

/// The reference frame of the spec.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    Inertial,
    /// The frame of a circular orbit: x along the velocity, y along the orbit normal, z outward.
    Orbit,
}

/// The quantities in a row of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Quaternion,
    QuaternionAngvel,
    QuaternionDerivative,
    Euler([usize; 3]),
    EulerDerivative([usize; 3]),
    EulerAngvel([usize; 3]),
    Spin,
}

/// The style in which a file is written.
#[derive(Clone, Debug)]
pub struct Style {
    pub notation: Notation,
    pub kind: Kind,
    pub first_version: bool,
    /// True if frame A is the body frame.
    pub body_is_a: bool,
    /// True if attitudes map from A to B, as in every file of version 2.0. Version 1.0 also allows
    /// B to A.
    pub a_to_b: bool,
    pub scalar_first: bool,
    pub reference: &'static str,
    pub body: &'static str,
    /// True to name the frame of the rates by the keyword of the frame ("REF_FRAME_A" or
    /// "REF_FRAME_B"), false to name it by its own name.
    pub rate_by_keyword: bool,
    pub rate_in_a: bool,
    pub scale: &'static str,
    pub of_year: bool,
    pub decimals_of_time: usize,
    /// The number of decimals. Numbers with more than 12 decimals have an exponent.
    pub digits: usize,
    pub lower_keys: bool,
    pub lower_values: bool,
    pub line_end: &'static str,
    pub mark: bool,
    pub comments: bool,
    pub extra_keys: bool,
    /// The rows at which a block ends and the next one begins. The next block repeats the last row
    /// of the block before.
    pub blocks: Vec<usize>,
    /// True if the next block begins with the row after instead of repeating the last row.
    pub apart: bool,
    /// The number of rows after which quaternions change their sign.
    pub flips: usize,
    pub quote: char,
    pub prefix: &'static str,
    pub units: bool,
    pub wrapped: bool,
    pub separator: char,
    pub quoted: bool,
    pub index: bool,
    pub degrees: bool,
    /// The times of the rows \[s\].
    pub times: Vec<f64>,
}

/// The notation of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    Keywords,
    Xml,
    Table,
}

/// The names of inertial frames that equal ICRF to a hundredth of a degree; the names of orbit
/// frames with their axes, as rows in the orbit frame of slewkit; the sequences of Euler angles.
const INERTIAL: [&str; 5] = ["ICRF", "GCRF", "EME2000", "J2000", "ICRF3"];
const ORBIT: [(&str, [[f64; 3]; 3]); 5] = [
    ("LVLH", [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]),
    ("RTN", [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    ("RSW_ROTATING", [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    ("QSW", [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    ("TNW", [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
];
const SEQUENCES: [[usize; 3]; 12] = [
    [2, 1, 0],
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [1, 0, 2],
    [2, 0, 2],
    [2, 1, 2],
    [0, 1, 0],
    [0, 2, 0],
    [1, 0, 1],
    [1, 2, 1],
];

impl Style {
    /// Draws any legal style for this motion.
    pub fn random(random: &mut Random, motion: &Motion, frame: Frame) -> Self {
        let notation = random.pick(&[Notation::Keywords, Notation::Keywords, Notation::Xml, Notation::Table]);
        let first_version = notation != Notation::Table && random.unit() < 0.3;
        let sequence = random.pick(&SEQUENCES);
        let kind = match notation {
            Notation::Table => random.pick(&[Kind::Quaternion, Kind::QuaternionAngvel]),
            _ if first_version => random.pick(&[
                Kind::Quaternion,
                Kind::QuaternionDerivative,
                Kind::Euler(sequence),
                Kind::Spin,
            ]),
            _ => random.pick(&[
                Kind::Quaternion,
                Kind::QuaternionAngvel,
                Kind::QuaternionAngvel,
                Kind::QuaternionDerivative,
                Kind::Euler(sequence),
                Kind::EulerDerivative(sequence),
                Kind::EulerAngvel(sequence),
                Kind::Spin,
            ]),
        };
        let step = random.pick(&[0.5, 1.0, 2.0, 5.0]);
        let count = (motion.duration / step).round() as usize;
        let mut times: Vec<f64> = (0..=count).map(|k| k as f64 * step).collect();
        if random.unit() < 0.2 {
            // Uneven rows, to a tenth of a second.
            for time in &mut times[1..count] {
                *time += (random.within(-0.3, 0.3) * step * 10.0).round() / 10.0;
            }
        }
        let blocks = if notation != Notation::Table && random.unit() < 0.3 {
            vec![1 + random.below(count / 2), count / 2 + 1 + random.below(count / 2 - 1)]
        } else {
            Vec::new()
        };
        let reference = match frame {
            Frame::Inertial => random.pick(&INERTIAL),
            Frame::Orbit => random.pick(&ORBIT).0,
        };
        let body_is_a = random.coin();
        Self {
            notation,
            kind,
            first_version,
            body_is_a,
            a_to_b: !first_version || random.coin(),
            scalar_first: first_version && notation == Notation::Keywords && random.coin(),
            reference,
            body: "SC_BODY_1",
            rate_by_keyword: random.coin(),
            rate_in_a: random.coin(),
            scale: random.pick(&["UTC", "UTC", "TAI", "TT", "GPS", "TDB"]),
            of_year: random.unit() < 0.25,
            decimals_of_time: random.pick(&[1, 3, 6, 9]),
            digits: random.pick(&[6, 8, 9, 12, 16]),
            lower_keys: random.unit() < 0.15,
            lower_values: random.unit() < 0.15,
            line_end: if random.unit() < 0.25 { "\r\n" } else { "\n" },
            mark: random.unit() < 0.15,
            comments: random.coin(),
            extra_keys: random.coin(),
            blocks,
            apart: false,
            flips: if random.unit() < 0.3 { 2 + random.below(5) } else { usize::MAX },
            quote: if random.unit() < 0.3 { '\'' } else { '"' },
            prefix: if random.unit() < 0.3 { "n:" } else { "" },
            units: random.coin(),
            wrapped: random.unit() < 0.3,
            separator: random.pick(&[',', ';', '\t', ' ']),
            quoted: random.unit() < 0.3,
            index: random.unit() < 0.3,
            degrees: random.coin(),
            times,
        }
    }

    /// Returns whether the rows have rates that the reader uses.
    pub fn has_rates(&self) -> bool {
        !matches!(self.kind, Kind::Quaternion | Kind::Euler(_) | Kind::Spin)
    }
}

/// A row before it is written: the attitude and rate of frame Y relative to frame X. Faults are
/// planted here.
#[derive(Clone, Debug)]
pub struct Row {
    /// The time from the epoch \[s\].
    pub time: f64,
    /// The axes of Y, in components of X.
    pub attitude: Matrix3,
    /// The angular rate of Y relative to X, in axes of Y [rad/s].
    pub rate: Vector3,
    /// A change that is applied to the written numbers; `None` for no change.
    pub tampered: Option<fn(&mut [f64])>,
}

/// Returns the rows of a motion for the given style.
pub fn rows(motion: &Motion, style: &Style) -> Vec<Row> {
    // The components are converted to the file's reference frame; a table names no frame and uses
    // the frame of the spec.
    let theirs = ORBIT.iter().find(|(name, _)| *name == style.reference && style.notation != Notation::Table);
    let to_theirs =
        theirs.map_or(Matrix3::identity(), |(_, rows)| Matrix3::from_fn(|row, column| rows[row][column]));
    // Y is the body if the attitudes map to the body.
    let y_is_body = style.a_to_b != style.body_is_a;
    style
        .times
        .iter()
        .map(|&time| {
            let (attitude, rate) = motion.at(time);
            let attitude = to_theirs * attitude;
            let (attitude, rate) = if y_is_body || style.notation == Notation::Table {
                (attitude, rate)
            } else {
                (attitude.transpose(), -(attitude * rate))
            };
            Row { time, attitude, rate, tampered: None }
        })
        .collect()
}

/// Returns the offset of a time scale from UTC on 2026-11-21, 07:00 \[s\]. TAI − UTC is 37 s; TDB −
/// TT is the usual series of two terms.
fn ahead(scale: &str) -> f64 {
    let anomaly = (357.53 + 0.985_600_28 * 9821.79_f64).to_radians();
    match scale {
        "TAI" => 37.0,
        "TT" => 69.184,
        "GPS" => 18.0,
        "TDB" => 69.184 + 0.001_657 * anomaly.sin() + 0.000_022 * (2.0 * anomaly).sin(),
        _ => 0.0,
    }
}

/// Formats the time 2026-11-21, 07:00 UTC plus `time` seconds as the style requires.
fn date(style: &Style, time: f64) -> String {
    let decimals = style.decimals_of_time;
    let unit = 10_f64.powi(decimals as i32);
    let past = ((7.0 * 3600.0 + time + ahead(style.scale)) * unit).round() / unit;
    let (whole, part) = (past.floor(), past - past.floor());
    let seconds = whole as u64;
    let part = (part * unit).round() as u64;
    let day = if style.of_year { "2026-325" } else { "2026-11-21" };
    format!("{day}T{:02}:{:02}:{:02}.{part:0decimals$}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

/// Formats a number with the digits of the style.
fn number(style: &Style, value: f64) -> String {
    let digits = style.digits;
    if digits > 12 { format!("{value:.digits$e}") } else { format!("{value:.digits$}") }
}

/// Returns the quaternion of an attitude, scalar last.
fn quaternion(attitude: &Matrix3) -> [f64; 4] {
    let [w, x, y, z] = lie::quaternion_from_rotation(attitude);
    [x, y, z, w]
}

fn about(axis: usize, angle: f64) -> Matrix3 {
    let (sin, cos) = angle.sin_cos();
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut turn = Matrix3::identity();
    (turn[(i, i)], turn[(j, j)], turn[(i, j)], turn[(j, i)]) = (cos, cos, -sin, sin);
    turn
}

/// Returns the Euler angles a with `M = A₁(a₁) A₂(a₂) A₃(a₃)`, from the elements of M.
fn euler(attitude: &Matrix3, axes: [usize; 3]) -> Vector3 {
    let [i, j, k] = axes;
    // The sign is 1 if the axes are in cyclic order (x, y, z), otherwise −1.
    let sign = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
    let m = |row: usize, column: usize| attitude[(row, column)];
    let (second, third) = if i == k {
        // M_ii = cos a₂; the last row and column of the third axis determine the rest.
        let other = 3 - i - j;
        let second = m(i, i).clamp(-1.0, 1.0).acos();
        (second, m(i, j).atan2(sign * m(i, other)))
    } else {
        ((sign * m(i, k)).clamp(-1.0, 1.0).asin(), (-sign * m(i, j)).atan2(m(i, i)))
    };
    // The rotation that remains is the first one.
    let first = attitude * about(k, third).transpose() * about(j, second).transpose();
    let (p, q) = ((i + 1) % 3, (i + 2) % 3);
    Vector3::new(first[(q, p)].atan2(first[(p, p)]), second, third)
}

/// Returns the time derivatives of Euler angles a. They solve `J(a) a' = rate`.
fn euler_derivative(angles: &Vector3, axes: [usize; 3], rate: &Vector3) -> Vector3 {
    let [i, j, k] = axes;
    let (third, second) = (about(k, angles[2]), about(j, angles[1]));
    let unit = |axis: usize| Vector3::ith(axis, 1.0);
    let columns =
        Matrix3::from_columns(&[third.tr_mul(&second.tr_mul(&unit(i))), third.tr_mul(&unit(j)), unit(k)]);
    columns.try_inverse().map_or(Vector3::repeat(f64::NAN), |inverse| inverse * rate)
}

/// Returns the numbers of a row in the order of the keywords. Quaternions are scalar last.
fn numbers(style: &Style, row: &Row, index: usize) -> Vec<f64> {
    let (x_is_a, degrees) = (style.a_to_b, |vector: Vector3| vector.map(f64::to_degrees));
    let velocity = || {
        // Frame X is frame A if attitudes map from A to B.
        let in_x = style.rate_in_a == x_is_a;
        degrees(if in_x { row.attitude * row.rate } else { row.rate })
    };
    let sign = if index % style.flips == style.flips - 1 { -1.0 } else { 1.0 };
    let quaternion = || quaternion(&row.attitude).map(|part| sign * part);
    let mut found: Vec<f64> = match style.kind {
        Kind::Quaternion => quaternion().into(),
        Kind::QuaternionAngvel if style.notation == Notation::Table => {
            let rate = if style.degrees { degrees(row.rate) } else { row.rate };
            quaternion().into_iter().chain(rate.iter().copied()).collect()
        }
        Kind::QuaternionAngvel => quaternion().into_iter().chain(velocity().iter().copied()).collect(),
        Kind::QuaternionDerivative => {
            // q̇ = ½ q ⊗ (0, Ω).
            let [x, y, z, w] = quaternion();
            let (vector, rate) = (Vector3::new(x, y, z), row.rate);
            let moved = 0.5 * (w * rate + vector.cross(&rate));
            let last = -0.5 * vector.dot(&rate);
            [x, y, z, w].into_iter().chain(moved.iter().copied()).chain([last]).collect()
        }
        Kind::Euler(axes) => degrees(euler(&row.attitude, axes)).iter().copied().collect(),
        Kind::EulerDerivative(axes) => {
            let angles = euler(&row.attitude, axes);
            let moved = euler_derivative(&angles, axes, &row.rate);
            degrees(angles).iter().chain(degrees(moved).iter()).copied().collect()
        }
        Kind::EulerAngvel(axes) => {
            degrees(euler(&row.attitude, axes)).iter().chain(velocity().iter()).copied().collect()
        }
        Kind::Spin => {
            let angles = euler(&row.attitude, [2, 0, 2]);
            let pole = [angles[0] - FRAC_PI_2, FRAC_PI_2 - angles[1], angles[2]];
            pole.into_iter().map(f64::to_degrees).chain([row.rate.z.to_degrees()]).collect()
        }
    };
    if let Some(tamper) = row.tampered {
        tamper(&mut found);
    }
    found
}
