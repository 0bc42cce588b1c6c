//! Linear equations that may have many solutions, or no exact solution.

use nalgebra::{DMatrix, DVector};

/// Returns the minimum-norm least-squares solution of `A x = b`. Singular values below the fraction
/// `none` of the largest one count as zero. Returns `None` if there are no equations, or if a
/// number is not finite.
pub(crate) fn shortest(a: &DMatrix<f64>, b: &DVector<f64>, none: f64) -> Option<DVector<f64>> {
    if a.is_empty() {
        return None;
    }
    let svd = a.clone().svd(true, true);
    svd.solve(b, none * svd.singular_values.max()).ok()
}
