//! The drift of one body: a step of the free rigid body, from the implicit attitude equation.
//!
//! ```text
//! h S(p) = F J_d − J_d Fᵀ ,   R⁺ = R F                                                   (3.24, 3.26)
//! ```

use super::StepError;
use crate::body::Body;
use crate::dynamics::implicit::solve_counting;
use crate::{Matrix3, Vector3, lie};

/// One body as the implicit equation sees it, in units of its mean principal moment.
#[derive(Clone, Debug)]
pub(super) struct Rotor {
    j: Matrix3,
    j_inverse: Matrix3,
    step: f64,
    /// `h` over the mean principal moment.
    scale: f64,
}

impl Rotor {
    pub fn of(bodies: &[Body], step: f64) -> Vec<Self> {
        let rotor = |body: &Body| {
            let mean = body.inertia.mean();
            Self {
                j: body.inertia.j() / mean,
                j_inverse: body.inertia.j_inverse() * mean,
                step,
                scale: step / mean,
            }
        };
        bodies.iter().map(rotor).collect()
    }

    /// The Cayley vector of the step's rotation `F = cay(c)`, for momentum `p`; Newton
    /// iterations are added to `iterations`.
    #[inline(always)]
    pub fn turn(&self, body: usize, p: &Vector3, iterations: &mut u64) -> Result<Vector3, StepError> {
        let g = self.scale * p;
        match solve_counting(&self.j, &self.j_inverse, &g) {
            Some((c, newton)) => {
                *iterations += u64::from(newton);
                Ok(c)
            }
            None => Err(self.failure(body, &g)),
        }
    }

    #[cold]
    fn failure(&self, body: usize, g: &Vector3) -> StepError {
        let turn = (self.j_inverse * g).norm();
        if turn.is_finite() {
            StepError::TooLong { body: body + 1, step: self.step, turn }
        } else {
            StepError::NotFinite
        }
    }
}

/// `F − I` and `Fᵀp − p` of the rotation with Cayley vector `c`.
#[inline(always)]
pub(super) fn increments(c: &Vector3, p: &Vector3) -> (Matrix3, Vector3) {
    let turn = lie::cayley_minus_identity(c);
    (turn, turn.tr_mul(p))
}
