//! The closest approach of a boresight to a direction between two nodes.

use crate::{Matrix3, Vector3, lie};

/// Value of a boresight constraint on one arc, `sign (w(τ)·R exp(τ S(f)) b − cos α(τ))`, where τ is
/// the fraction of the arc, R the attitude at its start, f its rotation vector and b the boresight.
/// The direction `w(τ)` moves, in reference axes at the start of the arc, if it is fixed in space
/// and the frame rotates. The half angle `α` of the cone changes linearly.
pub(super) struct BoresightArc {
    pub attitude: Matrix3,
    pub boresight: Vector3,
    pub direction: Vector3,
    pub turn: Vector3,
    pub arc: Vector3,
    pub sign: f64,
    /// Half angle of the cone at the start of the arc, and its increase over the arc \[rad\].
    pub cone: [f64; 2],
}

impl BoresightArc {
    /// Returns the half angle of the cone at a fraction of the arc \[rad\].
    pub fn half_angle(&self, fraction: f64) -> f64 {
        self.cone[0] + fraction * self.cone[1]
    }

    /// Returns the constraint value at a fraction of the arc, and its derivative with respect to
    /// the rotation ζ of the attitude at that point.
    pub fn at(&self, fraction: f64) -> (f64, Vector3) {
        let attitude = self.attitude * lie::exp(&(self.arc * fraction));
        let direction = lie::exp(&(self.turn * fraction)) * self.direction;
        let seen = attitude.tr_mul(&direction);
        let value = self.boresight.dot(&seen) - self.half_angle(fraction).cos();
        (self.sign * value, self.boresight.cross(&seen) * self.sign)
    }

    /// Returns the change of the constraint value at a fraction of the arc when the direction is
    /// rotated by the rotation vector `turned`.
    pub fn along(&self, fraction: f64, turned: &Vector3) -> f64 {
        let boresight = self.attitude * (lie::exp(&(self.arc * fraction)) * self.boresight);
        let direction = lie::exp(&(self.turn * fraction)) * self.direction;
        self.sign * boresight.dot(&turned.cross(&direction))
    }

    /// Returns the first and second derivatives of the constraint value with respect to the
    /// fraction of the arc.
    fn slopes(&self, fraction: f64) -> (f64, f64) {
        let attitude = self.attitude * lie::exp(&(self.arc * fraction));
        let w = lie::exp(&(self.turn * fraction)) * self.direction;
        let (w1, w2) = (self.turn.cross(&w), self.turn.cross(&self.turn.cross(&w)));
        let b1 = self.arc.cross(&self.boresight);
        let (p, p1, p2) = (attitude * self.boresight, attitude * b1, attitude * self.arc.cross(&b1));
        let ((sine, cosine), growth) = (self.half_angle(fraction).sin_cos(), self.cone[1]);
        let first = w1.dot(&p) + w.dot(&p1) + sine * growth;
        let second = w2.dot(&p) + 2.0 * w1.dot(&p1) + w.dot(&p2) + cosine * growth * growth;
        (self.sign * first, self.sign * second)
    }

    /// Returns the first derivative of the constraint value with respect to the fraction of the
    /// arc.
    pub fn slope(&self, fraction: f64) -> f64 {
        self.slopes(fraction).0
    }

    /// Returns the fraction within an interval at which the constraint value is largest; `None` if
    /// this fraction is an end of the arc, where the row of the node applies.
    pub fn extremum(&self, within: [f64; 2]) -> Option<f64> {
        Some(self.highest(within)).filter(|at| *at > 0.0 && *at < 1.0)
    }

    /// Returns the fraction in the interval `[low, high]` at which the constraint value is largest.
    /// An arc turns far less than half a turn, so the derivative changes its sign at most once.
    pub fn highest(&self, [low, high]: [f64; 2]) -> f64 {
        if self.turn == Vector3::zeros() && self.cone[1] == 0.0 {
            self.highest_of_standing(low, high)
        } else {
            self.highest_of_moving(low, high)
        }
    }

    /// Computes [`BoresightArc::highest`] for a fixed direction, for which the derivative is `α cos
    /// θτ + β sin θτ/θ`.
    fn highest_of_standing(&self, low: f64, high: f64) -> f64 {
        let seen = self.attitude.tr_mul(&self.direction) * self.sign;
        let (across, angle) = (self.arc.cross(&self.boresight), self.arc.norm());
        let (first, second) = (seen.dot(&across), seen.dot(&self.arc.cross(&across)));
        let slope = |fraction: f64| {
            let (sin, cos) = (angle * fraction).sin_cos();
            first * angle * cos + second * sin
        };
        if slope(low) <= 0.0 {
            low
        } else if slope(high) >= 0.0 {
            high
        } else {
            ((first * angle).atan2(-second) / angle).max(low).min(high)
        }
    }

    fn highest_of_moving(&self, mut low: f64, mut high: f64) -> f64 {
        if self.slope(low) <= 0.0 {
            return low;
        }
        if self.slope(high) >= 0.0 {
            return high;
        }
        let mut at = 0.5 * (low + high);
        for _ in 0..60 {
            let (first, second) = self.slopes(at);
            if first > 0.0 {
                low = at
            } else {
                high = at
            }
            let newton = at - first / second;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - at).abs() <= 1e-15 {
                return next;
            }
            at = next;
        }
        at
    }

    /// Returns the second derivatives of the constraint value at a fraction of the arc, with
    /// respect to the rotation of the attitude and to the rotation vector of the arc. If `highest`,
    /// these are the second derivatives of the maximum over the arc, whose fraction changes too.
    pub fn bend(&self, fraction: f64, highest: bool) -> Bend {
        let (b, a) = (&self.boresight, &self.arc);
        let turned = lie::exp(&(a * fraction));
        let direction = if self.turn == Vector3::zeros() {
            self.direction
        } else {
            lie::exp(&(self.turn * fraction)) * self.direction
        };
        // Boresight and direction in the body axes at the beginning of the arc, and the direction
        // in the body axes at the fraction.
        let (p, w) = (turned * b, self.attitude.tr_mul(&direction));
        let v = turned.tr_mul(&w);
        let along = lie::right_jacobian(&(a * fraction)) * fraction;
        let slope = b.cross(&v);
        let outer = w * p.transpose();
        let attitude = (outer + outer.transpose()) * 0.5 - Matrix3::identity() * w.dot(&p);
        let mixed = columns(&along, |column| w.cross(&(turned * b.cross(column))));
        let arc = along.tr_mul(&columns(&along, |column| b.cross(&v.cross(column))))
            - lie::right_jacobian_directional(&(a * -fraction), &slope) * (fraction * fraction);
        let mut out = Bend { attitude, mixed, arc: (arc + arc.transpose()) * 0.5 };
        let second = self.slopes(fraction).1 * self.sign;
        if highest && second * self.sign < 0.0 {
            // Second derivative of the maximum over τ of a function c(y, τ): c_yy − c_yτ c_τy/c_ττ.
            let moved = self.attitude.tr_mul(&self.turn.cross(&direction));
            let by_attitude = (turned * a.cross(b)).cross(&w) + p.cross(&moved);
            let by_arc = turned * slope + along.tr_mul(&b.cross(&(turned.tr_mul(&moved) - a.cross(&v))));
            out.attitude -= by_attitude * by_attitude.transpose() / second;
            out.mixed -= by_attitude * by_arc.transpose() / second;
            out.arc -= by_arc * by_arc.transpose() / second;
        }
        Bend { attitude: out.attitude * self.sign, mixed: out.mixed * self.sign, arc: out.arc * self.sign }
    }
}

/// Second derivatives of a boresight's constraint value: with respect to the rotation of the
/// attitude, mixed (attitude by rows, arc by columns), and with respect to the rotation vector of
/// the arc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend {
    pub attitude: Matrix3,
    pub mixed: Matrix3,
    pub arc: Matrix3,
}

impl Bend {
    pub fn scaled(&self, by: f64) -> Self {
        Self { attitude: self.attitude * by, mixed: self.mixed * by, arc: self.arc * by }
    }
}

fn columns(of: &Matrix3, to: impl Fn(&Vector3) -> Vector3) -> Matrix3 {
    Matrix3::from_columns(&[0, 1, 2].map(|i| to(&of.column(i).into_owned())))
}
