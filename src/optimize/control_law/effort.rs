//! Least effort without limits: `l = ½ uᵀWu`.
//!
//! ```text
//! u = −W⁻¹Bᵀ q ,    K = −½ qᵀA q ,    K_q = −A q ,    S = A = B W⁻¹Bᵀ
//! ```

use super::{Hamiltonian, Response};
use crate::mechanics::actuators::ActuatorSet;
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, DVector};

/// The law of least effort: `A = B W⁻¹Bᵀ`, 3×3, in the axes of the set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Effort(pub Matrix3);

/// `W⁻¹Bᵀ`, m×3, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Gain(DMatrix<f64>);

impl Effort {
    /// That of a set, in SI units.
    pub fn of(set: &ActuatorSet) -> Self {
        Self(*set.authority())
    }
}

impl Gain {
    /// That of a set.
    pub fn of(set: &ActuatorSet) -> Self {
        Self(set.gain().clone())
    }

    /// The optimal inputs `u = −W⁻¹Bᵀ q`.
    pub fn inputs(&self, costate: &Vector3) -> DVector<f64> {
        -(&self.0 * costate)
    }
}

impl Hamiltonian for Effort {
    fn response(&self, costate: &Vector3) -> Response {
        let output = -(self.0 * costate);
        Response { output, cost: -0.5 * costate.dot(&output) }
    }

    fn slope(&self, _: &Vector3) -> Matrix3 {
        self.0
    }

    fn inputs(&self, _: &ActuatorSet, gain: &Gain, costate: &Vector3) -> DVector<f64> {
        gain.inputs(costate)
    }
}
