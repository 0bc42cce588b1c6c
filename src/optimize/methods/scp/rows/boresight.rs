//! Where a boresight comes nearest to a direction between two nodes.

use crate::{Matrix3, Vector3, lie};

/// A boresight on one arc, `sign (w(τ)·R exp(τ S(f)) b − cos α(τ))`, where the direction turns in the reference
/// frame's axes if it is fixed to that frame, and the half angle `α` of the cone grows at one rate.
pub(super) struct BoresightArc {
    pub attitude: Matrix3,
    pub boresight: Vector3,
    pub direction: Vector3,
    pub turn: Vector3,
    pub arc: Vector3,
    pub sign: f64,
    /// Half angle of the cone at the start of the arc, and what it grows by over the arc \[rad\].
    pub cone: [f64; 2],
}

impl BoresightArc {
    /// Half angle of the cone at a fraction of the arc \[rad\].
    pub fn half_angle(&self, fraction: f64) -> f64 {
        self.cone[0] + fraction * self.cone[1]
    }

    /// Value at a fraction of the arc, and derivative with respect to ζ there.
    pub fn at(&self, fraction: f64) -> (f64, Vector3) {
        let attitude = self.attitude * lie::exp(&(self.arc * fraction));
        let direction = lie::exp(&(self.turn * fraction)) * self.direction;
        let seen = attitude.tr_mul(&direction);
        let value = self.boresight.dot(&seen) - self.half_angle(fraction).cos();
        (self.sign * value, self.boresight.cross(&seen) * self.sign)
    }

    /// Change of the value at a fraction of the arc as the direction is turned by a rotation vector.
    pub fn along(&self, fraction: f64, turned: &Vector3) -> f64 {
        let boresight = self.attitude * (lie::exp(&(self.arc * fraction)) * self.boresight);
        let direction = lie::exp(&(self.turn * fraction)) * self.direction;
        self.sign * boresight.dot(&turned.cross(&direction))
    }

    /// First and second derivative along the arc.
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

    /// First derivative along the arc.
    pub fn slope(&self, fraction: f64) -> f64 {
        self.slopes(fraction).0
    }

    /// Where between two fractions of the arc the value is largest; `None` where that is at an end of the arc, whose node tells it.
    pub fn extremum(&self, within: [f64; 2]) -> Option<f64> {
        Some(self.highest(within)).filter(|at| *at > 0.0 && *at < 1.0)
    }

    /// Where between two fractions of the arc the value is largest. An arc turns far less than half a turn, so the slope changes its
    /// sign once at most.
    pub fn highest(&self, [mut low, mut high]: [f64; 2]) -> f64 {
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
}
