//! A factorised N×N matrix, or its pseudo-inverse if a symmetry makes the matrix singular.

use nalgebra::{DMatrix, SMatrix, SVector};

/// The pivot size, relative to the size of its column, below which the SVD is used instead of LU.
const SUSPECT_PIVOT: f64 = 1e-8;
/// The relative size below which singular values count as zero because of a symmetry (theory:
/// 1e-17, compared with 1e-4 for the weakest actuated direction in the tests).
pub(crate) const RANK_TOLERANCE: f64 = 1e-9;

/// The inverse of a matrix as a linear operator.
#[derive(Clone, Debug)]
pub(crate) enum Factor<const N: usize> {
    /// LU factors with a permutation of the rows.
    Lu { lu: Box<SMatrix<f64, N, N>>, order: [usize; N] },
    /// The minimum-norm inverse of a rank-deficient matrix. One projection removes the redundant
    /// equations and fixes the undetermined unknowns.
    PseudoInverse(Box<SMatrix<f64, N, N>>),
}

impl<const N: usize> Factor<N> {
    /// Factorises a matrix of finite numbers.
    pub fn new(matrix: &SMatrix<f64, N, N>) -> Self {
        let mut lu = *matrix;
        let mut order: [usize; N] = std::array::from_fn(|row| row);
        let mut smallest = f64::INFINITY;
        let sizes = column_sizes(matrix);
        for pivot in 0..N {
            let size = |row: usize| lu[(row, pivot)].abs();
            let best = (pivot..N).fold(pivot, |best, row| if size(row) > size(best) { row } else { best });
            lu.swap_rows(pivot, best);
            order.swap(pivot, best);
            let relative = lu[(pivot, pivot)].abs() / sizes[pivot];
            smallest = if relative < smallest || relative.is_nan() { relative } else { smallest };
            if smallest <= SUSPECT_PIVOT || smallest.is_nan() {
                return Self::PseudoInverse(Box::new(pseudo_inverse(matrix)));
            }
            for row in pivot + 1..N {
                let factor = lu[(row, pivot)] / lu[(pivot, pivot)];
                lu[(row, pivot)] = factor;
                for column in pivot + 1..N {
                    lu[(row, column)] -= factor * lu[(pivot, column)];
                }
            }
        }
        Self::Lu { lu: Box::new(lu), order }
    }

    /// Returns `matrix⁻¹ b`, or the minimum-norm least-squares solution.
    pub fn solve(&self, b: &SVector<f64, N>) -> SVector<f64, N> {
        match self {
            Self::PseudoInverse(inverse) => **inverse * b,
            Self::Lu { lu, order } => {
                let mut x = SVector::from_fn(|row, _| b[order[row]]);
                for row in 0..N {
                    for column in 0..row {
                        x[row] -= lu[(row, column)] * x[column];
                    }
                }
                for row in (0..N).rev() {
                    for column in row + 1..N {
                        x[row] -= lu[(row, column)] * x[column];
                    }
                    x[row] /= lu[(row, row)];
                }
                x
            }
        }
    }
}

impl<const N: usize> Factor<N> {
    /// Returns `matrix⁻¹ b`, computed column by column.
    pub fn solve_matrix(&self, b: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
        let mut x = *b;
        for column in 0..N {
            x.set_column(column, &self.solve(&b.column(column).into_owned()));
        }
        x
    }

    /// Returns whether the matrix was singular within the tolerance of [`Factor::new`].
    pub fn is_singular(&self) -> bool {
        matches!(self, Self::PseudoInverse(_))
    }
}

/// Applies `matrix⁻¹` to the first `count` columns of `right`, in place and in arrays of fixed
/// size. If the matrix is singular within the tolerance of [`Factor::new`], it returns false, and
/// `right` has no meaning.
#[inline]
pub(crate) fn eliminate<const N: usize, const M: usize>(
    matrix: &SMatrix<f64, N, N>,
    right: &mut [[f64; M]; N],
    count: usize,
) -> bool {
    let mut rows: [[f64; N]; N] =
        std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]));
    let mut sizes = [0.0f64; N];
    for row in &rows {
        for (size, value) in sizes.iter_mut().zip(row) {
            *size = size.max(value.abs());
        }
    }
    let largest = sizes.iter().fold(0.0, |largest: f64, size| largest.max(*size));
    for size in &mut sizes {
        *size = column_size(*size, largest);
    }
    for pivot in 0..N {
        let mut best = pivot;
        for row in pivot + 1..N {
            if rows[row][pivot].abs() > rows[best][pivot].abs() {
                best = row;
            }
        }
        rows.swap(pivot, best);
        right.swap(pivot, best);
        let relative = rows[pivot][pivot].abs() / sizes[pivot];
        if relative <= SUSPECT_PIVOT || relative.is_nan() {
            return false;
        }
        let (lead, lead_right, inverse) = (rows[pivot], right[pivot], 1.0 / rows[pivot][pivot]);
        for row in pivot + 1..N {
            let factor = rows[row][pivot] * inverse;
            for (value, above) in rows[row][pivot + 1..].iter_mut().zip(&lead[pivot + 1..]) {
                *value -= factor * above;
            }
            for (value, above) in right[row][..count].iter_mut().zip(&lead_right[..count]) {
                *value -= factor * above;
            }
        }
    }
    for row in (0..N).rev() {
        let mut solution = right[row];
        for below in row + 1..N {
            for (value, known) in solution[..count].iter_mut().zip(&right[below][..count]) {
                *value -= rows[row][below] * known;
            }
        }
        let inverse = 1.0 / rows[row][row];
        solution[..count].iter_mut().for_each(|value| *value *= inverse);
        right[row] = solution;
    }
    true
}

/// Returns the pseudo-inverse. Columns are first scaled to unit size, so that the rank does not
/// depend on units.
fn pseudo_inverse<const N: usize>(matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let sizes = column_sizes(matrix);
    let scaled = DMatrix::from_fn(N, N, |row, column| matrix[(row, column)] / sizes[column]);
    let Some(svd) = scaled.try_svd(true, true, f64::EPSILON, 1000) else {
        return SMatrix::zeros();
    };
    let threshold = RANK_TOLERANCE * svd.singular_values.amax();
    let Ok(inverse) = svd.pseudo_inverse(threshold) else {
        return SMatrix::zeros();
    };
    SMatrix::from_fn(|row, column| inverse[(row, column)] / sizes[row])
}

/// Returns the part of a costate that has an effect through `psi`: its projection on the row space.
pub(crate) fn effective<const N: usize>(
    psi: &SMatrix<f64, N, N>,
    costate: &SVector<f64, N>,
) -> SVector<f64, N> {
    match Factor::new(psi) {
        Factor::Lu { .. } => *costate,
        Factor::PseudoInverse(inverse) => *inverse * (psi * costate),
    }
}

/// Returns the sizes of the columns. A column that consists only of round-off gets the size of the
/// largest column, so that scaling does not turn it into a direction.
fn column_sizes<const N: usize>(matrix: &SMatrix<f64, N, N>) -> [f64; N] {
    let size = |column: &[f64; N]| column.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
    let sizes = matrix.data.0.each_ref().map(size);
    let largest = sizes.iter().fold(0.0, |largest: f64, size| largest.max(*size));
    sizes.map(|size| column_size(size, largest))
}

fn column_size(size: f64, largest: f64) -> f64 {
    if size > RANK_TOLERANCE * largest { size } else { largest.max(f64::MIN_POSITIVE) }
}

/// Returns the numerical rank, and the ratio of the largest to the smallest singular value within
/// this rank.
pub(crate) fn rank_and_condition<const N: usize>(matrix: &SMatrix<f64, N, N>) -> (usize, f64) {
    let values = singular_values(matrix);
    let largest = values[0];
    let rank = values.iter().filter(|value| **value > RANK_TOLERANCE * largest).count();
    let condition = if rank == 0 { f64::INFINITY } else { largest / values[rank - 1] };
    (rank, condition)
}

/// Returns the singular values in descending order; zeros if the matrix is not finite.
fn singular_values<const N: usize>(matrix: &SMatrix<f64, N, N>) -> Vec<f64> {
    let dynamic = DMatrix::from_fn(N, N, |row, column| matrix[(row, column)]);
    if !dynamic.iter().all(|value| value.is_finite()) {
        return vec![0.0; N];
    }
    let Some(svd) = dynamic.try_svd(false, false, f64::EPSILON, 1000) else { return vec![0.0; N] };
    let mut values: Vec<f64> = svd.singular_values.iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    values
}
