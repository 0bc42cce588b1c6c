//! The implicit midpoint rule on the nine elements of the rotation matrix (SRK), solved by two
//! nested fixed-point iterations.
//!
//! ```text
//! y⁺ = y + h f((y + y⁺)/2)
//! ```
//! The rule conserves quadratic invariants, and thus `RᵀR = I` to the tolerance of the iteration.
//! It is not symplectic in these variables, and does not conserve the angular momentum of several
//! bodies.
//!
//! The inner iteration keeps forces and moments fixed. It reduces the error by a factor of about
//! `h|Ω|/2`, which is slow if bodies turn far in a step. The outer iteration evaluates the
//! potential and reduces the error by a factor of about `h²|f'|/4`. A single iteration for both
//! needs 75 evaluations of the potential for a step of 1.4 rad; two nested iterations need a dozen.

use super::ambient::{Ambient, largest};
use super::course::{Course, Method};
use super::{Input, StepError};

/// Tolerance on the change in the last iteration, relative to the size of each quantity.
///
/// A quantity may be so small that its own round-off exceeds the tolerance. For example, the
/// momentum of a body that hardly turns comes from moments in which large forces cancel. The
/// iteration therefore also ends if its changes stop shrinking (Hairer, Lubich, Wanner, VIII.6.2)
/// and their effect on the poses is within the tolerance.
const TOLERANCE: f64 = 1e-13;

/// Tolerance of the inner iteration, as a fraction of the last change of the outer iteration.
const INNER: f64 = 1e-2;

/// Largest number of iterations; ten suffice for usual steps.
const MAX_ITERATIONS: u32 = 200;

/// The implicit midpoint rule, with buffers for one step.
#[derive(Clone, Debug)]
pub(super) struct ImplicitMidpoint {
    ambient: Ambient,
    change: Vec<f64>,
    /// The change of the state before an outer iteration.
    before: Vec<f64>,
    middle: Vec<f64>,
    rate: Vec<f64>,
    correction: Vec<f64>,
    scales: Vec<f64>,
}

impl ImplicitMidpoint {
    pub fn new(course: Course) -> Self {
        let ambient = Ambient::new(course);
        let zero = vec![0.0; ambient.size];
        Self {
            change: zero.clone(),
            before: zero.clone(),
            middle: zero.clone(),
            rate: zero.clone(),
            correction: zero.clone(),
            scales: zero,
            ambient,
        }
    }

    fn middle(&mut self) {
        self.middle.iter_mut().zip(&self.change).for_each(|(middle, change)| *middle = 0.5 * change);
    }

    /// Solves for the change under the forces and moments evaluated last, until an iteration
    /// changes the poses by no more than `goal`, or no longer improves.
    fn solve_under_load(&mut self, goal: f64) {
        let h = self.ambient.course.loads.step;
        let mut noticed = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            self.middle();
            self.ambient.rate_under_load(&self.middle, &mut self.rate);
            self.ambient.course.work.iterations += 1;
            for ((correction, change), rate) in
                self.correction.iter_mut().zip(&mut self.change).zip(&self.rate)
            {
                *correction = h * rate - *change;
                *change = h * rate;
            }
            let before = std::mem::replace(&mut noticed, self.ambient.noticed(&self.correction));
            if noticed <= goal || noticed >= before {
                return;
            }
        }
    }
}

impl Method for ImplicitMidpoint {
    fn advance(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        self.change.fill(0.0);
        let mut noticed = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            self.before.copy_from_slice(&self.change);
            self.middle();
            self.ambient.load(0.5, &self.middle, inputs);
            self.solve_under_load(INNER * noticed);
            self.ambient.scales(&self.change, &mut self.scales);
            for ((correction, now), before) in self.correction.iter_mut().zip(&self.change).zip(&self.before)
            {
                *correction = now - before;
            }
            let relative = largest(self.correction.iter().copied(), &self.scales);
            if !relative.is_finite() {
                return Err(StepError::NotFinite);
            }
            let before = std::mem::replace(&mut noticed, self.ambient.noticed(&self.correction));
            let at_round_off = noticed <= TOLERANCE && noticed >= before;
            if relative <= TOLERANCE || at_round_off {
                return self.ambient.finish(&self.change);
            }
        }
        Err(StepError::NotConverged { step: self.ambient.course.loads.step, iterations: MAX_ITERATIONS })
    }

    fn course(&self) -> &Course {
        &self.ambient.course
    }
}
