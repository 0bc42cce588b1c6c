//! A state of the motion, and small changes of it.

use crate::{Matrix3, Vector3, lie};
use nalgebra::{SVector, Vector6};

/// Numbers of a state: quaternion, angular velocity, what was burnt.
pub(crate) type Numbers = SVector<f64, 8>;

/// Half of what a state is disturbed by to difference the flow: what is left of it is its square, and round-off over it.
pub(crate) const DISTURBANCE: f64 = 3e-5;

/// Attitude relative to the start, angular velocity in body axes, and what was burnt, scaled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State(pub Numbers);

impl State {
    pub fn of(attitude: &Matrix3, rate: &Vector3) -> Self {
        let [w, x, y, z] = lie::quaternion_from_rotation(attitude);
        Self(Numbers::from([w, x, y, z, rate.x, rate.y, rate.z, 0.0]))
    }

    pub fn rate(&self) -> Vector3 {
        self.0.fixed_rows::<3>(4).into()
    }

    pub fn burnt(&self) -> f64 {
        self.0[7]
    }

    /// A vector of the axes of the start in those of the body.
    pub fn in_body_axes(&self, vector: &Vector3) -> Vector3 {
        let (w, q) = (self.0[0], Vector3::new(self.0[1], self.0[2], self.0[3]));
        let across = 2.0 * vector.cross(&q);
        vector + w * across + across.cross(&q)
    }

    /// Attitude and rate relative to others, body axes.
    pub fn minus(&self, other: &Self) -> Vector6<f64> {
        let (a, b) = (&other.0, &self.0);
        let (va, vb) = (Vector3::new(a[1], a[2], a[3]), Vector3::new(b[1], b[2], b[3]));
        let scalar = a[0] * b[0] + va.dot(&vb);
        let vector = a[0] * vb - b[0] * va - va.cross(&vb);
        let turn = if scalar < 0.0 { -2.0 } else { 2.0 } * vector;
        let rate = self.rate() - other.rate();
        Vector6::new(turn.x, turn.y, turn.z, rate.x, rate.y, rate.z)
    }

    /// Disturbed by a small turn and a change of the rate, body axes.
    pub fn plus(&self, change: &Vector6<f64>) -> Self {
        let half = 0.5 * change.fixed_rows::<3>(0);
        let q = &self.0;
        let v = Vector3::new(q[1], q[2], q[3]);
        let w = q[0] - v.dot(&half);
        let v = v + q[0] * half + v.cross(&half);
        let size = (w * w + v.norm_squared()).sqrt();
        let rate = self.rate() + change.fixed_rows::<3>(3);
        Self(Numbers::from([w / size, v.x / size, v.y / size, v.z / size, rate.x, rate.y, rate.z, q[7]]))
    }

    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|number| number.is_finite())
    }

    /// The derivative of a function of it by turn and rate.
    pub fn gradient(&self, of: &dyn Fn(&Self) -> f64) -> Vector6<f64> {
        Vector6::from_fn(|row, _| {
            let disturbed = |size: f64| of(&self.plus(&Vector6::ith(row, size)));
            (disturbed(DISTURBANCE) - disturbed(-DISTURBANCE)) / (2.0 * DISTURBANCE)
        })
    }
}
