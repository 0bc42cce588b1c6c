//! The equations of motion in the entries of the rotation matrices, for methods that do not use the
//! group.
//!
//! ```text
//! y = (R, Π, x, γ) per body, R as nine numbers; x and γ only where the body translates
//! Ṙ = R S(Ω) ,  Π̇ = Π × Ω + M ,  ẋ = γ/m ,  γ̇ = f ,  Ω = J⁻¹Π
//! ```
//! Methods work with the change of y since the start of the step: its rounding is then relative to
//! the change, and the sum of the changes is compensated like everywhere.

use super::course::Course;
use super::{Input, StepError};
use crate::mechanics::body::Body;
use crate::mechanics::environment::{Pose, Wrench};
use crate::{Matrix3, Vector3, lie};

/// The number of entries for each body: attitude and momentum, and position and linear momentum if
/// the body translates.
const TURNING: usize = 12;
const MOVING: usize = 18;

/// The largest norm of the difference of two rotations: √8, if they are 180° apart.
const ROTATION_CHANGE: f64 = 2.0 * std::f64::consts::SQRT_2;

/// Largest gain of momentum over a step that errors are relative to, in turns of the body over that
/// step \[rad\].
const MOST_TURNED: f64 = std::f64::consts::TAU;

/// Largest change of position over a step that errors are relative to, in distances of the farthest
/// body from the origin.
const MOST_MOVED: f64 = 10.0;

/// The vector field, with the step's start and the buffers of one evaluation.
#[derive(Clone, Debug)]
pub(super) struct Ambient {
    pub course: Course,
    /// Numbers in all.
    pub size: usize,
    poses: Vec<Pose>,
    wrenches: Vec<Wrench>,
}

fn vector(y: &[f64]) -> Vector3 {
    Vector3::from_column_slice(&y[..3])
}

impl Ambient {
    pub fn new(course: Course) -> Self {
        let numbers = |body: &Body| if body.mass.is_some() { MOVING } else { TURNING };
        Self {
            size: course.loads.system.bodies().iter().map(numbers).sum(),
            poses: course.state.poses().to_vec(),
            wrenches: vec![Wrench::zero(); course.count()],
            course,
        }
    }

    /// Computes the rate of change at `fraction` of the step, where the state has changed by `y`.
    pub fn rate(&mut self, fraction: f64, y: &[f64], inputs: &[Input], out: &mut [f64]) {
        self.load(fraction, y, inputs);
        self.rate_under_load(y, out);
    }

    /// Evaluates the loads at `fraction` of the step, with the state changed by `y`.
    pub fn load(&mut self, fraction: f64, y: &[f64], inputs: &[Input]) {
        self.place(y);
        if !self.course.loads.is_free(inputs) {
            self.course.loads.total(fraction, &self.poses, inputs, &mut self.wrenches);
        }
    }

    /// Computes the poses of the state changed by `y`.
    fn place(&mut self, y: &[f64]) {
        let mut at = 0;
        for (body, pose) in self.poses.iter_mut().enumerate() {
            let start = self.course.state.poses()[body];
            pose.attitude = start.attitude + Matrix3::from_column_slice(&y[at..at + 9]);
            at += TURNING;
            if self.course.loads.system.bodies()[body].mass.is_some() {
                pose.position = start.position + vector(&y[at..]);
                at += MOVING - TURNING;
            }
        }
    }

    /// Computes the rate of change of the state changed by `y`, under the last evaluated forces and
    /// moments.
    pub fn rate_under_load(&mut self, y: &[f64], out: &mut [f64]) {
        self.place(y);
        let mut at = 0;
        for (index, body) in self.course.loads.system.bodies().iter().enumerate() {
            let start = self.course.state.momenta()[index];
            let wrench = self.wrenches[index];
            let momentum = start.angular + vector(&y[at + 9..]);
            let rate = body.inertia.j_inverse() * momentum;
            let attitude_rate = self.poses[index].attitude * lie::hat(&rate);
            out[at..at + 9].copy_from_slice(attitude_rate.as_slice());
            out[at + 9..at + 12].copy_from_slice((momentum.cross(&rate) + wrench.moment).as_slice());
            at += TURNING;
            if let Some(mass) = body.mass {
                let velocity = (start.linear + vector(&y[at + 3..])) / mass;
                out[at..at + 3].copy_from_slice(velocity.as_slice());
                out[at + 3..at + 6].copy_from_slice(wrench.force.as_slice());
                at += MOVING - TURNING;
            }
        }
    }

    /// Ends a step over which the state has changed by `y`.
    pub fn finish(&mut self, y: &[f64]) -> Result<(), StepError> {
        let mut at = 0;
        for (index, body) in self.course.loads.system.bodies().iter().enumerate() {
            self.course.state.add_attitude(index, &Matrix3::from_column_slice(&y[at..at + 9]));
            self.course.state.add_angular(index, &vector(&y[at + 9..]));
            at += TURNING;
            if body.mass.is_some() {
                self.course.state.add_position(index, &vector(&y[at..]));
                self.course.state.add_linear(index, &vector(&y[at + 3..]));
                at += MOVING - TURNING;
            }
        }
        self.course.turn_frame();
        self.course.finish()
    }

    /// Writes the sizes to which errors are relative, one for each number: 1 for attitudes, and
    /// otherwise the norm of the quantity or its change over the step, whichever is larger. A
    /// change that no step resolves counts only up to [`MOST_TURNED`] and [`MOST_MOVED`], because
    /// any error is small relative to a change without bound.
    pub fn scales(&self, change: &[f64], out: &mut [f64]) {
        let h = self.course.loads.step;
        let farthest = self.course.state.poses().iter().map(|pose| pose.position.norm()).fold(0.0, f64::max);
        // All bodies at the origin: there is no length to hold a change against.
        let shift = if farthest > 0.0 { MOST_MOVED * farthest } else { f64::MAX };
        let (mut at, mut fill) = (0, |at: &mut usize, count: usize, start: f64, most: f64| {
            let norm = change[*at..*at + count].iter().map(|value| value * value).sum::<f64>().sqrt();
            let size = start.max(norm.min(most));
            // If the system is at rest without load, any scale is valid.
            let scale = if size > 0.0 { size } else { 1.0 };
            out[*at..*at + count].fill(scale);
            *at += count;
        });
        for (index, body) in self.course.loads.system.bodies().iter().enumerate() {
            let (pose, momentum) = (self.course.state.poses()[index], self.course.state.momenta()[index]);
            fill(&mut at, 9, 1.0, ROTATION_CHANGE);
            fill(&mut at, 3, momentum.angular.norm(), MOST_TURNED / h * body.inertia.principal().max());
            if let Some(mass) = body.mass {
                fill(&mut at, 3, pose.position.norm(), shift);
                fill(&mut at, 3, momentum.linear.norm(), (shift / h * mass).min(f64::MAX));
            }
        }
    }

    /// Computes the scales of an error control, so that the part `tolerance` of a scale has an
    /// effect on a pose over the step. The moments on a body that hardly turns carry more
    /// round-off than a small part of its momentum.
    pub fn error_scales(&self, change: &[f64], tolerance: f64, out: &mut [f64]) {
        self.scales(change, out);
        // An estimate is a sum of a dozen evaluations with weights above one.
        let least = 16.0 * f64::EPSILON / (tolerance * self.course.loads.step);
        let mut at = 0;
        for body in self.course.loads.system.bodies() {
            let floor = least * body.inertia.principal().min();
            out[at + 9..at + TURNING].iter_mut().for_each(|scale| *scale = scale.max(floor));
            at += if body.mass.is_some() { MOVING } else { TURNING };
        }
    }

    /// Returns the effect of `change` on the poses over a step: the largest turn [rad], or shift
    /// relative to the farthest body.
    pub fn noticed(&self, change: &[f64]) -> f64 {
        let h = self.course.loads.step;
        let farthest = self.course.state.poses().iter().map(|pose| pose.position.norm()).fold(0.0, f64::max);
        // All bodies at the origin, or none that moves: any length will do.
        let length = if farthest > 0.0 { farthest } else { 1.0 };
        let (mut at, mut worst) = (0, 0.0_f64);
        for body in self.course.loads.system.bodies() {
            let turn = Matrix3::from_column_slice(&change[at..at + 9]).norm();
            let kick = h * (body.inertia.j_inverse() * vector(&change[at + 9..])).norm();
            worst = worst.max(turn).max(kick);
            at += TURNING;
            if let Some(mass) = body.mass {
                let (shift, kick) =
                    (vector(&change[at..]).norm(), h * vector(&change[at + 3..]).norm() / mass);
                worst = worst.max(shift / length).max(kick / length);
                at += MOVING - TURNING;
            }
        }
        worst
    }
}

/// Returns the largest `|error|` relative to `scales`; NaN stays.
pub(super) fn largest(errors: impl Iterator<Item = f64>, scales: &[f64]) -> f64 {
    let mut worst = 0.0;
    for (error, scale) in errors.zip(scales) {
        let relative = error.abs() / scale;
        worst = if relative <= worst { worst } else { relative };
    }
    worst
}
