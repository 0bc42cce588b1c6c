//! The inertia of symmetric matrices, which is the number of eigenvalues of each sign, by
//! elimination (Sylvester's law).

use nalgebra::DMatrix;

/// Numbers of negative and of zero eigenvalues of a symmetric matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MatrixInertia {
    pub negative: usize,
    pub zero: usize,
}

impl MatrixInertia {
    /// Computes the inertia of a symmetric matrix, by `P A Pᵀ = L D Lᵀ` with pivots of one or two
    /// rows (Bunch and Parlett 1971). If no pivot exceeds `tolerance`, the remaining rows count
    /// as zero.
    pub fn of(mut a: DMatrix<f64>, tolerance: f64) -> Self {
        // This value balances the growth by one 2×2 pivot against the growth by two 1×1 pivots
        // (Bunch and Parlett).
        let alpha = (1.0 + 17f64.sqrt()) / 8.0;
        let n = a.nrows();
        let mut inertia = Self { negative: 0, zero: 0 };
        let mut at = 0;
        while at < n {
            let (mut largest, mut diagonal) = ((at, at), at);
            for column in at..n {
                for row in column..n {
                    if a[(row, column)].abs() > a[largest].abs() {
                        largest = (row, column);
                    }
                }
                if a[(column, column)].abs() > a[(diagonal, diagonal)].abs() {
                    diagonal = column;
                }
            }
            let pivots = a[largest].abs() > tolerance;
            if !pivots {
                inertia.zero += n - at;
                break;
            }
            if a[(diagonal, diagonal)].abs() >= alpha * a[largest].abs() {
                swap(&mut a, at, diagonal);
                let pivot = a[(at, at)];
                inertia.negative += usize::from(pivot < 0.0);
                for row in at + 1..n {
                    let factor = a[(row, at)] / pivot;
                    for column in at + 1..n {
                        a[(row, column)] -= factor * a[(at, column)];
                    }
                }
                at += 1;
            } else {
                let (row, column) = largest;
                swap(&mut a, at, column);
                swap(&mut a, at + 1, row);
                // The determinant of the 2×2 pivot is negative by its choice: one eigenvalue of
                // each sign.
                inertia.negative += 1;
                let (p, q, r) = (a[(at, at)], a[(at + 1, at)], a[(at + 1, at + 1)]);
                let determinant = p * r - q * q;
                for row in at + 2..n {
                    let (x, y) = (a[(row, at)], a[(row, at + 1)]);
                    let (u, v) = ((x * r - y * q) / determinant, (y * p - x * q) / determinant);
                    for column in at + 2..n {
                        a[(row, column)] -= u * a[(at, column)] + v * a[(at + 1, column)];
                    }
                }
                at += 2;
            }
        }
        inertia
    }
}

fn swap(a: &mut DMatrix<f64>, i: usize, j: usize) {
    a.swap_rows(i, j);
    a.swap_columns(i, j);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn inertia_is_that_of_the_eigenvalues() {
        let mut random = Random(5);
        for n in 2..=14 {
            for _ in 0..50 {
                let raw = DMatrix::from_fn(n, n, |_, _| random.uniform());
                // The matrix is indefinite, with some zero diagonals, so that both kinds of
                // pivots occur.
                let mut a = &raw + raw.transpose();
                for index in (0..n).step_by(2) {
                    a[(index, index)] = 0.0;
                }
                let negative = a.clone().symmetric_eigen().eigenvalues.iter().filter(|v| **v < 0.0).count();
                assert_eq!(MatrixInertia::of(a, 0.0), MatrixInertia { negative, zero: 0 });
                // The matrix has rank n − 1 and is negative semidefinite.
                let mut low = raw.columns(0, n - 1).into_owned();
                low = -&low * low.transpose();
                assert_eq!(MatrixInertia::of(low, 1e-12), MatrixInertia { negative: n - 1, zero: 1 });
            }
        }
    }
}
