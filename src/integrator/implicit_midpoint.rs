//! The implicit midpoint rule on the nine numbers of an attitude (SRK), by fixed-point iteration.
//!
//! ```text
//! y⁺ = y + h f((y + y⁺)/2)
//! ```
//! It keeps quadratic invariants, hence `RᵀR = I` to the tolerance of the iteration, but it is not symplectic
//! in these variables and loses the angular momentum of several bodies.

use super::ambient::{Ambient, largest};
use super::{Facts, Input, Integrator, StepError, System, SystemState, Work};

/// Largest change of the last iteration, relative to the size of each quantity.
const TOLERANCE: f64 = 1e-13;

/// The error shrinks by about h|f'|/2 an iteration; ten do at the usual steps.
const MAX_ITERATIONS: u32 = 200;

/// The implicit midpoint rule.
#[derive(Clone, Debug)]
pub(super) struct ImplicitMidpoint {
    ambient: Ambient,
    change: Vec<f64>,
    middle: Vec<f64>,
    rate: Vec<f64>,
    scales: Vec<f64>,
    work: Work,
}

impl ImplicitMidpoint {
    pub fn new(system: &System, state: &SystemState, step: f64) -> Self {
        let ambient = Ambient::new(system, state, step);
        let zero = vec![0.0; ambient.size];
        Self {
            change: zero.clone(),
            middle: zero.clone(),
            rate: zero.clone(),
            scales: zero,
            ambient,
            work: Work::default(),
        }
    }

    pub fn facts() -> Facts {
        Facts {
            order: 2,
            explicit: false,
            symplectic: false,
            preserves_momentum: false,
            preserves_group: true,
            force_evaluations: None,
        }
    }
}

impl Integrator for ImplicitMidpoint {
    fn step(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        let h = self.ambient.loads.step;
        self.change.fill(0.0);
        for iteration in 1..=MAX_ITERATIONS {
            self.middle.iter_mut().zip(&self.change).for_each(|(middle, change)| *middle = 0.5 * change);
            self.ambient.rate(0.5, &self.middle, inputs, &mut self.rate);
            self.work.iterations += 1;
            self.ambient.scales(&self.change, &mut self.scales);
            let corrections = self.rate.iter().zip(&self.change).map(|(rate, change)| h * rate - change);
            let correction = largest(corrections, &self.scales);
            self.change.iter_mut().zip(&self.rate).for_each(|(change, rate)| *change = h * rate);
            if !correction.is_finite() {
                return Err(StepError::NotFinite);
            }
            if correction <= TOLERANCE {
                self.ambient.add(&self.change);
                self.ambient.turn_frame();
                self.work.steps += 1;
                return Ok(());
            }
            if iteration == MAX_ITERATIONS {
                break;
            }
        }
        Err(StepError::NotConverged { step: h, iterations: MAX_ITERATIONS })
    }

    fn state(&self) -> &SystemState {
        &self.ambient.state
    }

    fn facts(&self) -> Facts {
        Self::facts()
    }

    fn work(&self) -> Work {
        Work { force_evaluations: self.ambient.loads.evaluations, ..self.work }
    }
}
