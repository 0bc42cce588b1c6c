//! Layout of the numbers that follow the date of a row, for all attitude types of AEM 1.0 and 2.0.
//!
//! The numbers describe the orientation of the frame Y relative to the frame X. A sequence of Euler
//! angles rotates the axes of X into the axes of Y. The first rotation has the first angle, so
//! `M = A₁(a₁) A₂(a₂) A₃(a₃)` converts components in Y to components in X, and the angular velocity
//! of Y relative to X is
//!
//! ```text
//! Ω = a₃' e₃ + A₃ᵀ (a₂' e₂ + A₂ᵀ a₁' e₁)      axes of Y
//! ```
//!
//! SPIN has the right ascension α and the declination δ of the spin axis, which is the z axis of Y,
//! and the angle φ about it: `M = Rz(α + 90°) Rx(90° − δ) Rz(φ)`. If X is the body frame, attitude
//! and rate are inverted: the attitude is `Mᵀ`, and the rate is `−M Ω` in the axes of X.
//!
//! Some programs read `QUATERNION/RATE` and `EULER_ANGLE/RATE` of version 1.0 as components of the
//! angular velocity in RATE_FRAME, others as derivatives of the angles of EULER_ROT_SEQ. If both
//! interpretations give the same angular velocity, it is used; otherwise the file has no rates.

use super::rows::Moved;
use super::{Number, Piece, Wrong};
use crate::spec::cut;
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::FRAC_PI_2;

/// Meaning of the numbers of a row that describe the attitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Attitude {
    /// The four components of a quaternion.
    Quaternion {
        /// True if the scalar component is first, false if it is last.
        scalar_first: bool,
    },
    /// Three Euler angles. Each array element is the index of a rotation axis, 0 for x to 2 for z.
    Euler([usize; 3]),
    /// The spin: three angles and a rate, followed by the given count of numbers that are ignored.
    Spin(usize),
}

/// Meaning of the numbers of a row that describe the rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rates {
    /// The row has no rate, or its rate is ignored.
    None,
    /// Time derivatives of the quaternion or of the Euler angles.
    Derivative,
    /// Components of the angular velocity of the frame Y relative to the frame X.
    Velocity(Axes),
    /// Rates of version 1.0. They are components in these axes, or derivatives of Euler angles in
    /// the given sequence.
    Old(Axes, Option<[usize; 3]>),
}

/// Frame in whose axes the components of an angular velocity are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axes {
    /// The frame X, relative to which the attitude is given.
    X,
    /// The frame Y, whose attitude is given.
    Y,
}

/// Layout of a row of an attitude file, without its date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub attitude: Attitude,
    pub rates: Rates,
    /// True if X is the body frame, so that attitude and rate must be inverted.
    pub inverse: bool,
}

/// A row, and the difference between the two interpretations of its rates \[rad/s\].
pub(super) struct Told {
    pub row: Moved,
    pub apart: f64,
}

const QUATERNION: [&str; 4] = ["Q1", "Q2", "Q3", "QC"];
const EULER: [&str; 3] = ["ANGLE_1", "ANGLE_2", "ANGLE_3"];
const SPIN: [&str; 4] = ["SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SPIN_ANGLE_VEL"];

impl Layout {
    /// Returns the number of values that follow the date of a row.
    pub fn count(&self) -> usize {
        let attitude = match self.attitude {
            Attitude::Quaternion { .. } => 4,
            Attitude::Euler(_) => 3,
            Attitude::Spin(more) => 4 + more,
        };
        attitude
            + match (self.rates, self.attitude) {
                (Rates::None, _) => 0,
                (Rates::Derivative, Attitude::Quaternion { .. }) => 4,
                _ => 3,
            }
    }

    /// Returns the names of the numbers of a row in XML, in the order that [`Layout::read`]
    /// expects. For quaternions this is the layout of [`Layout::of_names`].
    pub fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<&'static str> = match self.attitude {
            Attitude::Quaternion { .. } => QUATERNION.to_vec(),
            Attitude::Euler(_) => EULER.to_vec(),
            Attitude::Spin(_) => SPIN.to_vec(),
        };
        names.extend_from_slice(match (self.rates, self.attitude) {
            (Rates::None, _) => &[],
            (Rates::Derivative, Attitude::Quaternion { .. }) => &["Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT"],
            (Rates::Derivative, _) => &["ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT"],
            (Rates::Velocity(_), _) => &["ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"],
            (Rates::Old(..), _) => &["RATE_1", "RATE_2", "RATE_3"],
        });
        names
    }

    /// Returns the layout of a row whose numbers are in the order of [`Layout::names`].
    pub fn of_names(mut self) -> Self {
        if let Attitude::Quaternion { scalar_first } = &mut self.attitude {
            *scalar_first = false;
        }
        if let Attitude::Spin(more) = &mut self.attitude {
            *more = 0;
        }
        self
    }

    /// Converts the numbers of a row, which must be as many as [`Layout::count`], to an attitude
    /// and a rate.
    pub fn read(&self, numbers: &[Number]) -> Told {
        let value = |k: usize| numbers[k].value;
        let vector = |k: usize| Vector3::new(value(k), value(k + 1), value(k + 2));
        // A zero is often printed with fewer digits. It counts only if all numbers are zero.
        let half_unit = |from: usize, to: usize| {
            let printed = numbers[from..to].iter().filter(|number| number.value != 0.0);
            let most = printed.map(|number| number.half_unit).fold(0.0, f64::max);
            if most > 0.0 {
                most
            } else {
                numbers[from..to].iter().map(|number| number.half_unit).fold(f64::INFINITY, f64::min)
            }
        };
        let degrees = |size: f64| size.to_radians();
        match self.attitude {
            Attitude::Quaternion { scalar_first } => {
                let [x, y, z, w] = if scalar_first { [1, 2, 3, 0] } else { [0, 1, 2, 3] }.map(value);
                let of_y = [w, x, y, z];
                let open = 4.0 * half_unit(0, 4);
                let (rate, apart, rate_open) = match self.rates {
                    Rates::None => (None, 0.0, 0.0),
                    Rates::Derivative => {
                        let [dx, dy, dz, dw] =
                            if scalar_first { [5, 6, 7, 4] } else { [4, 5, 6, 7] }.map(value);
                        // q̇ = ½ q ⊗ (0, Ω), solved for Ω.
                        let (vector, moved) = (Vector3::new(x, y, z), Vector3::new(dx, dy, dz));
                        let rate = 2.0 * (w * moved - dw * vector - vector.cross(&moved));
                        (Some(rate), 0.0, 4.0 * half_unit(4, 8))
                    }
                    Rates::Velocity(_) | Rates::Old(..) => {
                        let (rate, apart) = self.told(vector(4).map(f64::to_radians), &of_y);
                        (Some(rate), apart, degrees(2.0 * half_unit(4, 7)))
                    }
                };
                let quaternion = if self.inverse { [w, -x, -y, -z] } else { of_y };
                let rate = rate.map(|rate| self.of_body(rate, &of_y));
                Told { row: Moved { quaternion, rate, open: (open, rate_open) }, apart }
            }
            Attitude::Euler(axes) => {
                let angles = vector(0).map(f64::to_radians);
                let of_y = lie::quaternion_from_rotation(&euler(axes, &angles));
                let open = degrees(3.0 * half_unit(0, 3));
                let (rate, apart, rate_open) = match self.rates {
                    Rates::None => (None, 0.0, 0.0),
                    Rates::Derivative => {
                        let rate = euler_rate(axes, &angles, &vector(3).map(f64::to_radians));
                        (Some(rate), 0.0, degrees(3.0 * half_unit(3, 6)))
                    }
                    Rates::Velocity(_) | Rates::Old(..) => {
                        let (rate, apart) = self.told(vector(3).map(f64::to_radians), &of_y);
                        (Some(rate), apart, degrees(3.0 * half_unit(3, 6)))
                    }
                };
                let rate = rate.map(|rate| self.of_body(rate, &of_y));
                Told { row: Moved { quaternion: self.turned(of_y), rate, open: (open, rate_open) }, apart }
            }
            Attitude::Spin(_) => {
                let [alpha, delta, phase] = vector(0).map(f64::to_radians).into();
                let of_y = euler([2, 0, 2], &Vector3::new(alpha + FRAC_PI_2, FRAC_PI_2 - delta, phase));
                let quaternion = self.turned(lie::quaternion_from_rotation(&of_y));
                let open = (degrees(3.0 * half_unit(0, 3)), 0.0);
                Told { row: Moved { quaternion, rate: None, open }, apart: 0.0 }
            }
        }
    }

    fn turned(&self, [w, x, y, z]: [f64; 4]) -> [f64; 4] {
        if self.inverse { [w, -x, -y, -z] } else { [w, x, y, z] }
    }

    /// Converts the angular velocity of the frame Y relative to the frame X, in Y axes, to that of
    /// the body relative to the reference frame, in body axes. `of_y` is the quaternion that maps Y
    /// to X.
    fn of_body(&self, rate: Vector3, of_y: &[f64; 4]) -> Vector3 {
        if self.inverse { -(lie::rotation_from_quaternion(of_y) * rate) } else { rate }
    }

    /// Converts the three rate numbers of a row to an angular velocity in the axes of the frame Y.
    /// Also returns the difference between the two possible interpretations of the numbers
    /// \[rad/s\].
    fn told(&self, numbers: Vector3, of_y: &[f64; 4]) -> (Vector3, f64) {
        let in_y = |axes: Axes| match axes {
            Axes::Y => numbers,
            Axes::X => lie::rotation_from_quaternion(of_y).tr_mul(&numbers),
        };
        match self.rates {
            Rates::Velocity(axes) => (in_y(axes), 0.0),
            Rates::Old(axes, sequence) => {
                let Some(sequence) = sequence else { return (in_y(axes), f64::INFINITY) };
                let angles = angles_of(&lie::rotation_from_quaternion(of_y), sequence);
                let other = euler_rate(sequence, &angles, &numbers);
                (in_y(axes), (in_y(axes) - other).norm())
            }
            Rates::None | Rates::Derivative => (numbers, 0.0),
        }
    }
}

/// Parses a sequence of Euler axes such as `ZYX` or `321`.
pub(super) fn sequence(piece: Piece<'_>) -> Result<[usize; 3], Wrong> {
    let axis = |byte: u8| match byte.to_ascii_uppercase() {
        b'X' | b'1' => Some(0),
        b'Y' | b'2' => Some(1),
        b'Z' | b'3' => Some(2),
        _ => None,
    };
    let axes: Vec<usize> = piece.text.bytes().filter_map(axis).collect();
    match axes[..] {
        [first, second, third] if piece.text.len() == 3 && first != second && second != third => {
            Ok([first, second, third])
        }
        _ => piece.wrong(
            format!("{} is not a sequence of three axes", cut(piece.text, 20)),
            "write EULER_ROT_SEQ = ZYX, or 321 in version 1.0: neighbours differ",
        ),
    }
}

fn about(axis: usize, angle: f64) -> Matrix3 {
    let mut vector = Vector3::zeros();
    vector[axis] = angle;
    lie::exp(&vector)
}

fn euler(axes: [usize; 3], angles: &Vector3) -> Matrix3 {
    about(axes[0], angles[0]) * about(axes[1], angles[1]) * about(axes[2], angles[2])
}

fn euler_rate(axes: [usize; 3], angles: &Vector3, rates: &Vector3) -> Vector3 {
    let mut rate = Vector3::zeros();
    for k in 0..3 {
        // The rate due to the previous angles is converted to the axes after rotation `k`.
        rate = about(axes[k], angles[k]).tr_mul(&rate);
        rate[axes[k]] += rates[k];
    }
    rate
}

/// Returns the Euler angles \[rad\] of a rotation in the sequence `axes`.
fn angles_of(rotation: &Matrix3, axes: [usize; 3]) -> Vector3 {
    let name: String = axes.iter().map(|axis| ["x", "y", "z"][*axis]).collect();
    crate::export::euler_angles(rotation, &name).into()
}

#[cfg(test)]
mod tests {
    use super::{angles_of, euler, euler_rate};
    use slewkit::{Vector3, lie};

    /// The angular velocity equals the numerical derivative of the rotation.
    #[test]
    fn rates_of_angles_are_those_of_the_rotation() {
        let (angles, rates) = (Vector3::new(0.3, -0.7, 1.1), Vector3::new(0.2, 0.5, -0.4));
        for axes in [[2, 1, 0], [0, 1, 2], [2, 0, 2], [1, 2, 0]] {
            let step = 1e-5;
            let at = |time: f64| euler(axes, &(angles + time * rates));
            let moved = lie::minus(&at(step), &at(-step)) / (2.0 * step);
            let expected = at(-step).tr_mul(&at(0.0)).tr_mul(&moved);
            assert!((euler_rate(axes, &angles, &rates) - expected).amax() < 1e-9, "{axes:?}");
            let found = angles_of(&at(0.0), axes);
            assert!((euler(axes, &found) - at(0.0)).amax() < 1e-14);
        }
    }
}
