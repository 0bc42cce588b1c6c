//! Certificate: a proved lower bound from any dual vector.
//!
//! Every maneuver within the range has moments `|y_i| ≤ 1`, and its slack `s = b − A y` lies in the
//! cones. So the following holds for **any** `z`, whether from a converged solve or not, provided
//! that its components for the inequalities are nonnegative:
//!
//! ```text
//! cost = c_0 + qᵀy = c_0 + rᵀy − bᵀz + zᵀs ,    r = q + Aᵀz
//!      ≥ c_0 − bᵀz − Σ|r_i| + Σ_blocks min(0, λ_min(Z)) · tr_max
//! ```
//!
//! because `⟨Z, S⟩ ≥ λ_min(Z) tr S` for `S ⪰ 0`. The round-off of the sums is subtracted too.

use super::relaxation::MomentProgram;
use crate::optimize::convex::cone::Cone;
use crate::optimize::convex::sparse::SparseParts;
use nalgebra::{DMatrix, SymmetricEigen};

/// A proved bound, and the dual objective before its correction by the residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Proved {
    /// Proved bound: no maneuver in the range costs less.
    pub bound: f64,
    /// Dual objective `c_0 − bᵀz`.
    pub claimed: f64,
}

/// Computes the bound that `z` proves. With `with_cost` it bounds the cost; otherwise the cost is
/// replaced by zero, and a positive bound proves that the range contains no maneuver. Returns
/// `None` if a component of `z` is not finite.
pub(crate) fn prove(moments: &MomentProgram, z: &[f64], with_cost: bool) -> Option<Proved> {
    let program = &moments.program;
    if z.len() != program.bound.len() || !z.iter().all(|value| value.is_finite()) {
        return None;
    }
    let mut loss = 0.0;
    let mut traces = moments.traces.iter();
    let mut inside = Vec::with_capacity(z.len());
    for (cone, part) in program.parts(z) {
        match cone {
            Cone::Zero(_) => inside.extend(part),
            Cone::Nonnegative(_) => inside.extend(part.iter().map(|value| value.max(0.0))),
            Cone::SecondOrder(_) => return None,
            Cone::Semidefinite(n) => {
                loss += (-lowest_eigenvalue(&unpacked(part, n))).max(0.0) * traces.next()?;
                inside.extend(part);
            }
        }
    }
    let z = inside;
    let cost = if with_cost { 1.0 } else { 0.0 };
    let mut residual: Vec<f64> = program.linear.iter().map(|q| cost * q).collect();
    program.matrix.add_transposed_product(&z, &mut residual);
    loss += residual.iter().map(|value| value.abs()).sum::<f64>();

    let claimed = cost * moments.offset - program.bound.iter().zip(&z).map(|(b, z)| b * z).sum::<f64>();

    let products: f64 = program.matrix.entries().map(|(row, _, value)| (value * z[row]).abs()).sum();
    let bounds: f64 = program.bound.iter().zip(&z).map(|(b, z)| (b * z).abs()).sum();
    // Relative error of a sum: the error of its terms, each from about ten operations, and one ulp
    // per addition.
    let round_off = (128.0 + z.len() as f64) * f64::EPSILON;
    loss += round_off * (products + bounds + cost * moments.cost_magnitude);
    let bound = claimed - loss;
    bound.is_finite().then_some(Proved { bound, claimed })
}

/// Unpacks a symmetric matrix from its upper triangle with √2 on the off-diagonal entries.
pub(crate) fn unpacked(part: &[f64], n: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(n, n);
    let mut index = 0;
    for column in 0..n {
        for row in 0..=column {
            let value =
                if row == column { part[index] } else { part[index] * std::f64::consts::FRAC_1_SQRT_2 };
            matrix[(row, column)] = value;
            matrix[(column, row)] = value;
            index += 1;
        }
    }
    matrix
}

/// Returns a lower bound on all eigenvalues of a symmetric matrix.
///
/// It is the computed smallest eigenvalue, lowered until `A − λI` has a Cholesky factor: then
/// `A − λI` is positive semidefinite up to an error of `(n + 1) ε tr`, which is subtracted too
/// (Demmel; Rump 2006).
pub(crate) fn lowest_eigenvalue(matrix: &DMatrix<f64>) -> f64 {
    let n = matrix.nrows();
    let norm = matrix.norm();
    if norm == 0.0 {
        return 0.0;
    }
    let safe = -norm;
    let computed = eigenvalues(matrix).and_then(|values| values.last().copied());
    let Some(computed) = computed.filter(|value| value.is_finite()) else { return safe };
    let unit = (n as f64 + 1.0) * f64::EPSILON;
    let mut margin = unit * norm;
    while margin < norm {
        let lambda = computed - margin;
        let shifted = matrix - DMatrix::identity(n, n) * lambda;
        let trace = shifted.trace().abs();
        if shifted.cholesky().is_some() {
            return (lambda - 2.0 * unit * trace).max(safe);
        }
        margin *= 4.0;
    }
    safe
}

/// Returns the ratio of the second largest to the largest eigenvalue of a positive semidefinite
/// matrix: zero for rank one.
pub(crate) fn rank_one_defect(matrix: &DMatrix<f64>) -> f64 {
    match eigenvalues(matrix).as_deref() {
        None => f64::NAN,
        Some([first, second, ..]) => second / first,
        Some(_) => 0.0,
    }
}

/// Computes the eigenvalues of a symmetric matrix, the largest first; `None` if the iteration does
/// not converge.
fn eigenvalues(matrix: &DMatrix<f64>) -> Option<Vec<f64>> {
    let eigen = SymmetricEigen::try_new(matrix.clone(), f64::EPSILON, 100 * matrix.nrows() + 1000)?;
    let mut values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::convex::cone::Program;
    use crate::optimize::convex::sparse::Sparse;

    /// Minimises `2 − y` over one moment `0 ≤ y ≤ 1`, with the cone row `s = y`: the minimum is 1.
    fn one_moment(cone: Cone) -> MomentProgram {
        MomentProgram {
            program: Program {
                quadratic: Sparse::zeros((1, 1)),
                linear: vec![-1.0],
                matrix: Sparse::of_entries(1, 1, &[(0, 0, -1.0)]),
                bound: vec![0.0],
                cones: vec![cone],
            },
            offset: 2.0,
            cost_magnitude: 3.0,
            traces: vec![1.0],
            moment_matrices: 1,
        }
    }

    #[test]
    fn each_way_to_claim_too_much_is_corrected() {
        for cone in [Cone::Nonnegative(1), Cone::Semidefinite(1)] {
            // z = −1 leaves no residual and claims 2 by a multiplier of the wrong sign; z = 0
            // claims 2 by a residual.
            for z in [-1.0, 0.0, -0.5, 3.0] {
                let proof = prove(&one_moment(cone), &[z], true).unwrap();
                assert!((proof.claimed - 2.0).abs() < 1e-15);
                assert!(proof.bound <= 1.0, "{cone:?} z {z}: {}", proof.bound);
            }
            let best = prove(&one_moment(cone), &[0.0], true).unwrap().bound;
            assert!(best > 1.0 - 1e-12, "{best}");
        }
    }

    #[test]
    fn packing_keeps_the_inner_product() {
        let root = std::f64::consts::SQRT_2;
        let matrix = unpacked(&[1.0, 2.0 * root, 3.0], 2);
        assert!((matrix - nalgebra::dmatrix![1.0, 2.0; 2.0, 3.0]).amax() < 1e-15);
        assert!(rank_one_defect(&nalgebra::dmatrix![1.0, 1.0; 1.0, 1.0]) < 1e-15);
        assert!((rank_one_defect(&nalgebra::dmatrix![2.0, 0.0; 0.0, 1.0]) - 0.5).abs() < 1e-15);
    }
}
