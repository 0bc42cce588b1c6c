//! The common data of all methods: the loads on the bodies, the state, and counts of the work.

use super::system::Loads;
use super::{Facts, Input, Integrator, StepError, System, SystemState, Work};

/// An integration in progress.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    pub loads: Loads,
    pub state: SystemState,
    pub work: Work,
    facts: Facts,
}

/// A method that advances a course. It is an [`Integrator`] with the state of the course.
pub(crate) trait Method: Send {
    /// Advances the state by one step, and counts the step at its end.
    fn advance(&mut self, inputs: &[Input]) -> Result<(), StepError>;

    fn course(&self) -> &Course;
}

impl Course {
    pub fn new(system: &System, state: &SystemState, step: f64, facts: Facts) -> Self {
        Self { loads: Loads::new(system, step), state: state.clone(), work: Work::default(), facts }
    }

    /// Returns the number of bodies.
    pub fn count(&self) -> usize {
        self.state.poses().len()
    }

    /// Transforms the state to the axes of the reference frame at the end of a step.
    pub fn turn_frame(&mut self) {
        if let Some(turn) = self.loads.frame_turn() {
            self.state.turn_frame(self.loads.system.bodies(), &turn);
        }
    }

    /// Counts a step, and reports an error if a number of the state is not finite.
    pub fn finish(&mut self) -> Result<(), StepError> {
        self.work.steps += 1;
        if self.state.is_finite() { Ok(()) } else { Err(StepError::NotFinite) }
    }
}

impl<M: Method> Integrator for M {
    fn step(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        self.advance(inputs)
    }

    fn state(&self) -> &SystemState {
        &self.course().state
    }

    fn facts(&self) -> Facts {
        self.course().facts
    }

    fn work(&self) -> Work {
        let Course { loads, work, .. } = self.course();
        Work { force_evaluations: loads.evaluations, ..*work }
    }
}
