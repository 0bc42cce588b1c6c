//! The state of all bodies, stored as compensated sums.
//!
//! # Why does the attitude update need care in a steady rotation?
//!
//! A steady rotation repeats the same `F`, so the rounding errors of its elements add up instead of
//! averaging out. The update therefore multiplies only by factors that change with `R`, and
//! computes the remaining scalar to an ulp of its small part.

use super::{Momentum, StepError};
use crate::mechanics::body::Body;
use crate::mechanics::environment::{Pose, Wrench};
use crate::numerics::compensated::compensated_add;
use crate::{Matrix3, Vector3, lie};

/// The poses and momenta of all bodies, each with the round-off that its sum has lost so far.
///
/// The methods add many small increments, so the sums are compensated (Kahan). Naive updates lose
/// four digits of orthogonality and momentum over 10⁶ steps of a steady rotation.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemState {
    poses: Vec<Pose>,
    momenta: Vec<Momentum>,
    /// Compensation of the poses: the excess that was added.
    pose_excess: Vec<Pose>,
    momentum_excess: Vec<Momentum>,
}

impl SystemState {
    /// Builds a state from one pose and one momentum for each body. The numbers are not checked
    /// here; [`System::check`](super::System::check) and the start of every method check them.
    pub fn new(poses: Vec<Pose>, momenta: Vec<Momentum>) -> Self {
        let none = Pose { position: Vector3::zeros(), attitude: Matrix3::zeros() };
        let at_rest = Momentum { linear: Vector3::zeros(), angular: Vector3::zeros() };
        let (pose_excess, momentum_excess) = (vec![none; poses.len()], vec![at_rest; momenta.len()]);
        Self { poses, momenta, pose_excess, momentum_excess }
    }

    /// Returns the position and attitude of each body.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// Returns the momenta of each body.
    pub fn momenta(&self) -> &[Momentum] {
        &self.momenta
    }

    /// Returns whether all numbers of the state are finite.
    pub fn is_finite(&self) -> bool {
        // A sum is finite only if all terms are. Very large finite terms may overflow together, but
        // such states are useless too.
        let pose = |pose: &Pose| pose.position.sum() + pose.attitude.sum();
        let momentum = |momentum: &Momentum| momentum.linear.sum() + momentum.angular.sum();
        let poses: f64 = self.poses.iter().map(pose).sum();
        (poses + self.momenta.iter().map(momentum).sum::<f64>()).is_finite()
    }

    #[inline(always)]
    pub(crate) fn add_position(&mut self, body: usize, increment: &Vector3) {
        compensated_add(&mut self.poses[body].position, &mut self.pose_excess[body].position, increment);
    }

    #[inline(always)]
    pub(crate) fn add_attitude(&mut self, body: usize, increment: &Matrix3) {
        compensated_add(&mut self.poses[body].attitude, &mut self.pose_excess[body].attitude, increment);
    }

    /// Turns a body by `F = cay(c)`: `R⁺ = R + a (W + W S(c))`, with `W = R S(c)` and
    /// `a = 2/(1 + |c|²)`.
    ///
    /// A steady rotation repeats the same `F`, so the rounding errors of its elements would add up.
    /// Here every product has a factor that changes with `R`, and `a` is computed as
    /// `2 − 2|c|²/(1 + |c|²)`, which is accurate to an ulp of the small part. The remaining error
    /// is a random walk.
    #[inline(always)]
    pub(crate) fn turn_attitude(&mut self, body: usize, c: &Vector3) {
        let attitude = &self.poses[body].attitude;
        let times = |m: &Matrix3| {
            let (x, y, z) = (m.column(0), m.column(1), m.column(2));
            Matrix3::from_columns(&[y * c.z - z * c.y, z * c.x - x * c.z, x * c.y - y * c.x])
        };
        let once = times(attitude);
        let sum = once + times(&once);
        let square = c.norm_squared();
        self.add_attitude(body, &(sum * 2.0 - sum * (2.0 * square / (1.0 + square))));
    }

    #[inline(always)]
    pub(crate) fn add_linear(&mut self, body: usize, increment: &Vector3) {
        compensated_add(&mut self.momenta[body].linear, &mut self.momentum_excess[body].linear, increment);
    }

    #[inline(always)]
    pub(crate) fn add_angular(&mut self, body: usize, increment: &Vector3) {
        compensated_add(&mut self.momenta[body].angular, &mut self.momentum_excess[body].angular, increment);
    }

    /// Adds the impulse `weight · wrench` of each body to its momenta; `weight` is in \[s\].
    #[inline(always)]
    pub(crate) fn kick(
        &mut self,
        bodies: &[Body],
        weight: f64,
        wrenches: &[Wrench],
    ) -> Result<(), StepError> {
        let mut check = 0.0;
        for (index, (body, wrench)) in bodies.iter().zip(wrenches).enumerate() {
            self.add_angular(index, &(weight * wrench.moment));
            check += wrench.moment.sum();
            if body.mass.is_some() {
                self.add_linear(index, &(weight * wrench.force));
                check += wrench.force.sum();
            }
        }
        if check.is_finite() { Ok(()) } else { Err(StepError::NotFinite) }
    }

    /// Rotates all quantities that are given in the reference frame by `exp S(f)`. The position of
    /// a body that only rotates is fixed in that frame and does not change.
    pub(crate) fn turn_frame(&mut self, bodies: &[Body], f: &Vector3) {
        let turn = lie::exp_minus_identity(f);
        for (index, body) in bodies.iter().enumerate() {
            let (pose, linear) = (self.poses[index], self.momenta[index].linear);
            self.add_attitude(index, &(turn * pose.attitude));
            if body.mass.is_some() {
                self.add_position(index, &(turn * pose.position));
                self.add_linear(index, &(turn * linear));
            }
        }
    }

    /// Sets the momenta of one body.
    pub(crate) fn set_momentum(&mut self, body: usize, momentum: Momentum) {
        self.momenta[body] = momentum;
        self.momentum_excess[body] = Momentum { linear: Vector3::zeros(), angular: Vector3::zeros() };
    }
}

/// Returns `Fᵀp − p` for the rotation `F` with the Cayley vector `c`: `a (S(c)² − S(c)) p`,
/// `a = 2/(1 + |c|²)`.
#[inline(always)]
pub(super) fn carried(c: &Vector3, p: &Vector3) -> Vector3 {
    let w = c.cross(p);
    (c.cross(&w) - w) * (2.0 / (1.0 + c.norm_squared()))
}
