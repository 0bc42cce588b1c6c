//! What a plan minimises: the effort of its inputs.
//!
//! ```text
//! ∫ ½ uᵀWu dt ,    on the grid  Σ κ_k ½ u_kᵀWu_k
//! ```
//!
//! with the weights κ of the kicks ([`Grid::kick`](super::grid::Grid::kick)) and one block of `W` for each set of
//! actuators. Which inputs are optimal follows in `optimize/control_law`.

use nalgebra::{DMatrix, DVector};

/// Running cost `½ uᵀWu` of inputs under the weight `W`, m×m; in the unit of the weight, or scaled.
pub fn effort(weight: &DMatrix<f64>, inputs: &[f64]) -> f64 {
    let u = DVector::from_column_slice(inputs);
    0.5 * u.dot(&(weight * &u))
}
