//! Constant inputs of a maneuver, as part of what acts on its body at a pose.
//!
//! Axes fixed in the reference frame give a torque `Rᵀ B u` that turns with the body, axes fixed in the body a force
//! `R B u`: evaluated where the field is, such inputs are exact in every method.

use crate::maneuver::problem::Problem;
use crate::mechanics::environment::{Environment, Pose, Wrench};
use crate::mechanics::full_body::Potential;
use crate::verify::{Output, Plant};
use std::sync::Arc;

/// The field of a maneuver and its actuators under constant inputs.
#[derive(Debug)]
pub(super) struct Held {
    problem: Problem,
    output: Output,
    environment: Arc<dyn Environment>,
}

impl Held {
    /// `inputs`: one per input of the problem.
    pub fn new(problem: &Problem, inputs: &[f64]) -> Self {
        Self {
            problem: problem.clone(),
            output: Output::of(problem, inputs),
            environment: Arc::clone(&problem.environment),
        }
    }
}

impl Potential for Held {
    /// That of the field: what the actuators do is work, not potential energy.
    fn energy(&self, poses: &[Pose]) -> f64 {
        self.environment.potential(&poses[0])
    }

    fn wrenches(&self, poses: &[Pose], wrenches: &mut [Wrench]) {
        let plant = Plant::new(&self.problem);
        let (field, inputs) = (plant.field(&poses[0]), plant.actuators(&poses[0].attitude, &self.output));
        wrenches[0] = Wrench { force: field.force + inputs.force, moment: field.moment + inputs.moment };
    }
}
