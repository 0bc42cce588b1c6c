//! The minimum-effort law without limits: `l = ½ uᵀWu`.
//!
//! ```text
//! u = −W⁻¹Bᵀ q ,    K = −½ qᵀA q ,    K_q = −A q ,    S = A = B W⁻¹Bᵀ
//! ```

use super::{Hamiltonian, Response};
use crate::maneuver::objective::Weighted;
use crate::{Matrix3, Vector3};

/// Minimum-effort law, represented by the authority `A = B W⁻¹Bᵀ`, 3×3, in the axes of the set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Effort(pub Matrix3);

impl Effort {
    /// Builds the law of an actuator set in SI units.
    pub fn of(inputs: &Weighted) -> Self {
        Self(inputs.authority)
    }
}

/// Returns the optimal inputs `u = −W⁻¹Bᵀ q` without limits.
pub(super) fn unlimited(inputs: &Weighted, costate: &Vector3) -> impl Iterator<Item = f64> {
    inputs.gain.row_iter().map(|row| -(row[0] * costate.x + row[1] * costate.y + row[2] * costate.z))
}

impl Hamiltonian for Effort {
    fn response(&self, costate: &Vector3) -> Response {
        let output = -(self.0 * costate);
        Response { output, cost: -0.5 * costate.dot(&output) }
    }

    fn slope(&self, _: &Vector3) -> Matrix3 {
        self.0
    }

    fn push_inputs(&self, inputs: &Weighted, costate: &Vector3, row: &mut Vec<f64>) {
        unlimited(inputs, costate).for_each(|input| row.push(input));
    }
}
