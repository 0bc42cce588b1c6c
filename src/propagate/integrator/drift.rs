//! The drift of one body: a step of the free rigid body, from the implicit attitude equation.
//!
//! ```text
//! h S(p) = F J_d − J_d Fᵀ ,   R⁺ = R F                                                   (3.24, 3.26)
//! ```

use super::StepError;
use super::implicit::AttitudeEquation;
use crate::Vector3;
use crate::mechanics::body::Body;
use crate::mechanics::drift_equation::solve_from;

/// The implicit attitude equation of one body, solved step after step.
#[derive(Clone, Debug)]
pub(super) struct Rotor {
    equation: AttitudeEquation,
    step: f64,
    /// Cayley vector of the last step; NaN before the first step.
    last: Vector3,
    /// Cayley vector of the step before the last one; NaN if that step does not exist.
    before: Vector3,
}

impl Rotor {
    pub fn of(bodies: &[Body], step: f64) -> Vec<Self> {
        let none = Vector3::repeat(f64::NAN);
        let rotor = |body: &Body| {
            let equation = AttitudeEquation::new(&body.inertia, step);
            Self { equation, step, last: none, before: none }
        };
        bodies.iter().map(rotor).collect()
    }

    /// Returns the Cayley vector `c` of the step's rotation `F = cay(c)` for the momentum `p`, and
    /// adds the number of iterations to `iterations`.
    ///
    /// Linear extrapolation of the last two solutions gives the initial guess. It is as accurate,
    /// `O(h³)`, as one pass of the fixed-point iteration, and does not depend on the momentum. If
    /// the iteration does not converge from it, the equation is solved without it.
    #[inline(always)]
    pub fn turn(&mut self, body: usize, p: &Vector3, iterations: &mut u64) -> Result<Vector3, StepError> {
        let g = self.equation.scale * p;
        let guess = 2.0 * self.last - self.before;
        let (c, count) = match solve_from(&self.equation.j, &g, guess) {
            Some(root) => root,
            None => self.afresh(body, p)?,
        };
        (self.before, self.last) = (self.last, c);
        *iterations += u64::from(count);
        Ok(c)
    }

    #[cold]
    #[inline(never)]
    fn afresh(&self, body: usize, p: &Vector3) -> Result<(Vector3, u32), StepError> {
        self.equation.solve(p).ok_or_else(|| {
            let turn = (self.equation.j_inverse * (self.equation.scale * p)).norm();
            if turn.is_finite() {
                StepError::TooLong { body: body + 1, step: self.step, turn }
            } else {
                StepError::NotFinite
            }
        })
    }
}
