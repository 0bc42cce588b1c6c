//! The equations of motion in the elements of the rotation matrices, for methods that do not use
//! the group structure.
//!
//! ```text
//! y = (R, Π, x, γ) per body, R as nine numbers; x and γ only where the body translates
//! Ṙ = R S(Ω) ,  Π̇ = Π × Ω + M ,  ẋ = γ/m ,  γ̇ = f ,  Ω = J⁻¹Π
//! ```
//! The methods compute the change of y since the start of the step. Rounding errors are then
//! relative to the change, and the sum of the changes is compensated, as in all methods.

use super::course::Course;
use super::{Input, StepError};
use crate::mechanics::body::Body;
use crate::mechanics::environment::{Pose, Wrench};
use crate::{Matrix3, Vector3, lie};

/// Number of components of a body that only rotates: attitude and angular momentum.
const TURNING: usize = 12;
/// Number of components of a body that translates, including position and linear momentum.
const MOVING: usize = 18;

/// Largest norm of the difference between two rotations: √8 if they are 180° apart.
const ROTATION_CHANGE: f64 = 2.0 * std::f64::consts::SQRT_2;

/// Largest change of angular momentum over a step to which errors are relative, expressed as the
/// turn of the body in this step \[rad\].
const MOST_TURNED: f64 = std::f64::consts::TAU;

/// Largest change of position over a step to which errors are relative, in units of the distance of
/// the farthest body from the origin.
const MOST_MOVED: f64 = 10.0;

/// The vector field of the equations, with the start of the step and buffers for one evaluation.
#[derive(Clone, Debug)]
pub(super) struct Ambient {
    pub course: Course,
    /// Total number of components.
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

    /// Computes the rate of change at the fraction `fraction` of the step, for a state changed by
    /// `y`.
    pub fn rate(&mut self, fraction: f64, y: &[f64], inputs: &[Input], out: &mut [f64]) {
        self.load(fraction, y, inputs);
        self.rate_under_load(y, out);
    }

    /// Evaluates the loads at the fraction `fraction` of the step, for a state changed by `y`.
    pub fn load(&mut self, fraction: f64, y: &[f64], inputs: &[Input]) {
        self.place(y);
        if !self.course.loads.is_free(inputs) {
            self.course.loads.total(fraction, &self.poses, inputs, &mut self.wrenches);
        }
    }

    /// Computes the poses of a state changed by `y` since the start of the step.
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

    /// Computes the rate of change of a state changed by `y`, under the forces and moments
    /// evaluated last.
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

    /// Ends a step by adding the change `y` to the state.
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

    /// Writes the scales to which errors are relative, one per component. The scale is 1 for
    /// attitudes. For other quantities it is the norm of the quantity or of its change over the
    /// step, whichever is larger. Very large changes count only up to [`MOST_TURNED`] and
    /// [`MOST_MOVED`], because any error would be small relative to an unbounded change.
    pub fn scales(&self, change: &[f64], out: &mut [f64]) {
        let h = self.course.loads.step;
        let farthest = self.course.state.poses().iter().map(|pose| pose.position.norm()).fold(0.0, f64::max);
        // If all bodies are at the origin, no length limits the scale of a change.
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

    /// Computes the scales of an error control, so that the fraction `tolerance` of a scale has an
    /// effect on a pose over the step. On a body that hardly turns, moments may have more round-off
    /// than a small fraction of the body's momentum.
    pub fn error_scales(&self, change: &[f64], tolerance: f64, out: &mut [f64]) {
        self.scales(change, out);
        // An error estimate is a sum of a dozen evaluations with weights above one.
        let least = 16.0 * f64::EPSILON / (tolerance * self.course.loads.step);
        let mut at = 0;
        for body in self.course.loads.system.bodies() {
            let floor = least * body.inertia.principal().min();
            out[at + 9..at + TURNING].iter_mut().for_each(|scale| *scale = scale.max(floor));
            at += if body.mass.is_some() { MOVING } else { TURNING };
        }
    }

    /// Returns the effect of `change` on the poses over a step: the largest turn \[rad\], or the
    /// largest shift relative to the distance of the farthest body.
    pub fn noticed(&self, change: &[f64]) -> f64 {
        let h = self.course.loads.step;
        let farthest = self.course.state.poses().iter().map(|pose| pose.position.norm()).fold(0.0, f64::max);
        // If all bodies are at the origin or none translates, any length is valid.
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

/// Returns the largest `|error|` relative to its scale; NaN if an error is NaN.
pub(super) fn largest(errors: impl Iterator<Item = f64>, scales: &[f64]) -> f64 {
    let mut worst = 0.0;
    for (error, scale) in errors.zip(scales) {
        let relative = error.abs() / scale;
        worst = if relative <= worst { worst } else { relative };
    }
    worst
}
