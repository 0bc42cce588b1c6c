//! A state of the motion, and small changes of it.

use crate::{Matrix3, Vector3, lie};
use nalgebra::SVector;

/// Most wheels that a maneuver of arcs may have.
pub(crate) const MOST_WHEELS: usize = 6;

/// Most inputs that change at limited rates.
pub(crate) const MOST_RAMPS: usize = 6;

const NUMBERS: usize = 15 + MOST_WHEELS + MOST_RAMPS;

/// Of a change, as many less one: of the quaternion's four numbers three are free, and what was burnt stands apart.
pub(crate) const CHANGES: usize = NUMBERS - 2;

/// Numbers of a state: quaternion, angular velocity, what was burnt, position, velocity, time, what wheels store,
/// what inputs give that change at limited rates.
pub(crate) type Numbers = SVector<f64, NUMBERS>;

/// A change of a state: turn and rate in body axes, position, velocity, time, what wheels store, what
/// inputs give that change at limited rates.
pub(crate) type Change = SVector<f64, CHANGES>;

/// Where numbers of a state that are changed as they are begin, among its numbers and among those of a change.
pub(crate) const PLAIN: [usize; 2] = [8, 6];

/// Where parts of a change begin.
pub(crate) mod at {
    pub(crate) const RATE: usize = 3;
    pub(crate) const POSITION: usize = 6;
    pub(crate) const VELOCITY: usize = 9;
    pub(crate) const TIME: usize = 12;
    pub(crate) const WHEELS: usize = 13;
    pub(crate) const RAMPS: usize = WHEELS + super::MOST_WHEELS;
}

/// Half of what a state is disturbed by to difference the flow: what is left of it is its square, and round-off over it.
pub(crate) const DISTURBANCE: f64 = 3e-5;

/// Attitude, angular velocity in body axes, what was burnt, position and velocity in the reference frame, the time, the momenta of the
/// wheels, and inputs that change at limited rates, scaled. What a maneuver has nothing of stays zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State(pub Numbers);

impl State {
    pub fn of(attitude: &Matrix3, rate: &Vector3) -> Self {
        let mut numbers = Numbers::zeros();
        numbers.fixed_rows_mut::<4>(0).copy_from_slice(&lie::quaternion_from_rotation(attitude));
        numbers.fixed_rows_mut::<3>(4).copy_from(rate);
        Self(numbers)
    }

    /// The same elsewhere, and moving.
    #[must_use]
    pub fn moving(mut self, position: &Vector3, velocity: &Vector3) -> Self {
        self.0.fixed_rows_mut::<3>(8).copy_from(position);
        self.0.fixed_rows_mut::<3>(11).copy_from(velocity);
        self
    }

    /// The same with what wheels store.
    #[must_use]
    pub fn storing(mut self, momenta: impl Iterator<Item = f64>) -> Self {
        for (own, momentum) in self.0.iter_mut().skip(15).zip(momenta) {
            *own = momentum;
        }
        self
    }

    /// The same at a time.
    #[must_use]
    pub fn at_time(mut self, time: f64) -> Self {
        self.0[14] = time;
        self
    }

    pub fn rate(&self) -> Vector3 {
        self.0.fixed_rows::<3>(4).into()
    }

    pub fn burnt(&self) -> f64 {
        self.0[7]
    }

    pub fn position(&self) -> Vector3 {
        self.0.fixed_rows::<3>(8).into()
    }

    pub fn velocity(&self) -> Vector3 {
        self.0.fixed_rows::<3>(11).into()
    }

    pub fn time(&self) -> f64 {
        self.0[14]
    }

    /// What a wheel stores.
    pub fn stored(&self, wheel: usize) -> f64 {
        self.0[15 + wheel]
    }

    /// With what inputs give that change at limited rates, as parts of their limits.
    #[must_use]
    pub fn giving(mut self, inputs: &[f64]) -> Self {
        for (own, input) in self.0.iter_mut().skip(15 + MOST_WHEELS).zip(inputs) {
            *own = *input;
        }
        self
    }

    /// What an input gives that changes at a limited rate, as a part of its limit.
    pub fn given(&self, ramp: usize) -> f64 {
        self.0[15 + MOST_WHEELS + ramp]
    }

    /// A vector of the reference frame in body axes.
    pub fn in_body_axes(&self, vector: &Vector3) -> Vector3 {
        let (w, q) = (self.0[0], Vector3::new(self.0[1], self.0[2], self.0[3]));
        let across = 2.0 * vector.cross(&q);
        vector + w * across + across.cross(&q)
    }

    /// A vector of body axes in those of the reference frame.
    pub fn in_reference_axes(&self, vector: &Vector3) -> Vector3 {
        let (w, q) = (self.0[0], Vector3::new(self.0[1], self.0[2], self.0[3]));
        let across = 2.0 * q.cross(vector);
        vector + w * across + q.cross(&across)
    }

    /// Body → reference.
    pub fn attitude(&self) -> Matrix3 {
        lie::rotation_from_quaternion(&[self.0[0], self.0[1], self.0[2], self.0[3]])
    }

    /// Relative to another, body axes.
    pub fn minus(&self, other: &Self) -> Change {
        let (a, b) = (&other.0, &self.0);
        let (va, vb) = (Vector3::new(a[1], a[2], a[3]), Vector3::new(b[1], b[2], b[3]));
        let scalar = a[0] * b[0] + va.dot(&vb);
        let vector = a[0] * vb - b[0] * va - va.cross(&vb);
        let turn = if scalar < 0.0 { -2.0 } else { 2.0 } * vector;
        let mut change = Change::zeros();
        change.fixed_rows_mut::<3>(0).copy_from(&turn);
        change.fixed_rows_mut::<3>(at::RATE).copy_from(&(self.rate() - other.rate()));
        let [of_numbers, of_change] = PLAIN;
        for index in 0..CHANGES - of_change {
            change[of_change + index] = b[of_numbers + index] - a[of_numbers + index];
        }
        change
    }

    /// Disturbed by a small change.
    pub fn plus(&self, change: &Change) -> Self {
        let half: Vector3 = 0.5 * change.fixed_rows::<3>(0);
        let q = &self.0;
        let v = Vector3::new(q[1], q[2], q[3]);
        let w = q[0] - v.dot(&half);
        let v = v + q[0] * half + v.cross(&half);
        let size = (w * w + v.norm_squared()).sqrt();
        let mut numbers = self.0;
        for (number, part) in numbers.iter_mut().zip([w, v.x, v.y, v.z]) {
            *number = part / size;
        }
        for index in 0..3 {
            numbers[4 + index] += change[at::RATE + index];
        }
        let [of_numbers, of_change] = PLAIN;
        for index in 0..CHANGES - of_change {
            numbers[of_numbers + index] += change[of_change + index];
        }
        Self(numbers)
    }

    /// The derivative of its first `used` numbers where it changes so, per unit of time, and burns so much.
    pub fn along(&self, change: &Change, burning: f64, used: usize, derivative: &mut Numbers) {
        let turning = Vector3::new(change[0], change[1], change[2]);
        let v = Vector3::new(self.0[1], self.0[2], self.0[3]);
        let turned = 0.5 * (self.0[0] * turning + v.cross(&turning));
        let first =
            [-0.5 * v.dot(&turning), turned.x, turned.y, turned.z, change[3], change[4], change[5], burning];
        let [of_numbers, of_change] = PLAIN;
        let derivative = derivative.as_mut_slice();
        derivative[..of_numbers].copy_from_slice(&first);
        derivative[of_numbers..used]
            .copy_from_slice(&change.as_slice()[of_change..of_change + used - of_numbers]);
    }

    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|number| number.is_finite())
    }

    /// The derivative of a function of it by changes.
    pub fn gradient(&self, of: &dyn Fn(&Self) -> f64) -> Change {
        Change::from_fn(|row, _| {
            let disturbed = |size: f64| of(&self.plus(&Change::ith(row, size)));
            (disturbed(DISTURBANCE) - disturbed(-DISTURBANCE)) / (2.0 * DISTURBANCE)
        })
    }
}
