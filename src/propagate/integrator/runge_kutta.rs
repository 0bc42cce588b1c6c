//! Explicit Runge–Kutta methods on the nine elements of the rotation matrix, which are the usual
//! choice, for comparison.
//!
//! ```text
//! k_i = f(t + c_i h, y + h Σ_{j<i} a_ij k_j) ,   y⁺ = y + h Σ b_i k_i
//! ```
//! Nothing is conserved: the attitude leaves the group, and energy and momenta drift. If the
//! tableau has an embedded pair and a tolerance is given, a step is divided. Each part is shortened
//! until its estimated error, relative to the size of each quantity, is within the tolerance.

use super::ambient::{Ambient, largest};
use super::course::{Course, Method};
use super::tableau::Tableau;
use super::{Input, StepError};

/// Largest number of parts into which a step may be divided.
const MAX_PARTS: u32 = 1_000_000;

/// An explicit Runge–Kutta method with fixed steps or with error control.
#[derive(Clone, Debug)]
pub(super) struct RungeKutta {
    ambient: Ambient,
    tableau: Tableau,
    /// Allowed error per part; `None` if steps are not divided.
    tolerance: Option<f64>,
    /// Length of the part to try next \[s\].
    part: f64,
    stages: Vec<Vec<f64>>,
    /// The change from the start of the step to the start of the part.
    base: Vec<f64>,
    /// The change from the start of the step to a stage.
    y: Vec<f64>,
    scales: Vec<f64>,
}

impl RungeKutta {
    pub fn new(course: Course, tableau: Tableau, tolerance: Option<f64>) -> Self {
        let part = course.loads.step;
        let ambient = Ambient::new(course);
        let zero = vec![0.0; ambient.size];
        Self {
            tableau: tableau.checked(),
            tolerance,
            part,
            stages: vec![zero.clone(); tableau.c.len()],
            base: zero.clone(),
            y: zero.clone(),
            scales: zero,
            ambient,
        }
    }

    /// Computes the stages of a part that starts `from` \[s\] after the start of the step, and
    /// writes the change at its end to `y`.
    fn part(&mut self, from: f64, length: f64, inputs: &[Input]) {
        let step = self.ambient.course.loads.step;
        for i in 0..self.stages.len() {
            combine(&self.base, length, self.tableau.a[i], &self.stages, &mut self.y);
            let fraction = (from + self.tableau.c[i] * length) / step;
            self.ambient.rate(fraction, &self.y, inputs, &mut self.stages[i]);
        }
        combine(&self.base, length, self.tableau.b, &self.stages, &mut self.y);
    }

    fn adaptive(&mut self, tolerance: f64, error: &[f64], inputs: &[Input]) -> Result<(), StepError> {
        let step = self.ambient.course.loads.step;
        let give_up = StepError::GaveUp { step };
        let mut done = 0.0;
        for _ in 0..MAX_PARTS {
            let rest = step - done;
            let last = self.part >= 0.999 * rest;
            let length = if last { rest } else { self.part };
            self.part(done, length, inputs);
            self.ambient.error_scales(&self.y, tolerance, &mut self.scales);
            let stages = &self.stages;
            let errors = (0..self.y.len())
                .map(|index| length * error.iter().zip(stages).map(|(e, k)| e * k[index]).sum::<f64>());
            // A part so long that its numbers overflow is rejected like any other part that is too
            // long.
            let ratio = match largest(errors, &self.scales) / tolerance {
                ratio if ratio.is_finite() => ratio,
                _ => f64::MAX,
            };
            // The estimate is of order 7, so the error is proportional to h⁸.
            let factor = 0.9 * ratio.powf(-1.0 / f64::from(self.tableau.order));
            if ratio <= 1.0 {
                self.base.copy_from_slice(&self.y);
                if last {
                    // A last part that is shorter than the allowed length gives no estimate for the
                    // next part.
                    self.part = self.part.max(length * factor.clamp(0.2, 4.0)).min(step);
                    return Ok(());
                }
                done += length;
                self.part = length * factor.clamp(0.2, 4.0);
            } else {
                self.ambient.course.work.rejected += 1;
                self.part = length * factor.clamp(0.1, 0.9);
                if self.part < 1e-12 * step {
                    return Err(give_up);
                }
            }
        }
        Err(give_up)
    }
}

/// Computes `y = base + h Σ w_j k_j`.
fn combine(base: &[f64], h: f64, weights: &[f64], stages: &[Vec<f64>], y: &mut [f64]) {
    y.copy_from_slice(base);
    for (weight, stage) in weights.iter().zip(stages) {
        let weight = h * weight;
        // Half of the entries of Fehlberg's tableau are zero.
        if weight.abs() > 0.0 {
            y.iter_mut().zip(stage).for_each(|(y, k)| *y += weight * k);
        }
    }
}

impl Method for RungeKutta {
    fn advance(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        self.base.fill(0.0);
        match (self.tolerance, self.tableau.error) {
            (Some(tolerance), Some(error)) => self.adaptive(tolerance, error, inputs)?,
            _ => self.part(0.0, self.ambient.course.loads.step, inputs),
        }
        self.ambient.finish(&self.y)
    }

    fn course(&self) -> &Course {
        &self.ambient.course
    }
}
