//! Gaussian elimination with partial pivoting for band matrices, as in the linear systems of
//! chains.

/// Square band matrix that is factored once, in place.
pub(crate) struct Banded {
    size: usize,
    /// Number of diagonals below and above the main one.
    half: usize,
    /// Elements by rows: row i holds columns `i − half … i + 2 half`, with room for the fill-in of
    /// pivoting.
    rows: Vec<f64>,
    /// Index after the last nonzero column of each row: most rows end well inside the band.
    ends: Vec<usize>,
}

impl Banded {
    /// Builds a zero matrix with `half` diagonals on both sides.
    pub fn new(size: usize, half: usize) -> Self {
        Self { size, half, rows: vec![0.0; size * (3 * half + 1)], ends: (1..=size).collect() }
    }

    fn width(&self) -> usize {
        3 * self.half + 1
    }

    /// Adds to an element; it must lie in the band.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        debug_assert!(row.abs_diff(column) <= self.half);
        let width = self.width();
        self.rows[row * width + column + self.half - row] += value;
        self.ends[row] = self.ends[row].max(column + 1);
    }

    /// Solves `A x = b` and stores the solution in `b`. Returns `false` if the matrix is singular
    /// to working precision.
    pub fn solve(mut self, b: &mut [f64]) -> bool {
        let (size, half, width) = (self.size, self.half, self.width());
        let mut largest = 0.0f64;
        for values in self.rows.chunks_exact(width) {
            largest = values.iter().fold(largest, |largest, value| largest.max(value.abs()));
        }
        let negligible = largest * f64::EPSILON * 1e-4;
        for k in 0..size {
            let below = (k + half).min(size - 1);
            // The element (row, k) is stored at column k + half − row of its row.
            let mut pivot = k;
            let mut best = self.rows[k * width + half].abs();
            for row in k + 1..=below {
                let value = self.rows[row * width + k + half - row].abs();
                if value > best {
                    (pivot, best) = (row, value);
                }
            }
            let usable = best > negligible;
            if !usable {
                return false;
            }
            if pivot != k {
                let count = self.ends[k].max(self.ends[pivot]) - k;
                let (upper, lower) = self.rows.split_at_mut(pivot * width);
                let first = &mut upper[k * width + half..][..count];
                let second = &mut lower[k + half - pivot..][..count];
                first.swap_with_slice(second);
                b.swap(k, pivot);
                self.ends.swap(k, pivot);
            }
            let count = self.ends[k] - k;
            let (done, rest) = self.rows.split_at_mut((k + 1) * width);
            let source = &done[k * width + half..][..count];
            let inverse = 1.0 / source[0];
            for row in k + 1..=below {
                let target = &mut rest[(row - k - 1) * width + k + half - row..][..count];
                let factor = target[0] * inverse;
                if factor != 0.0 {
                    for (target, source) in target.iter_mut().zip(source) {
                        *target -= factor * source;
                    }
                    b[row] -= factor * b[k];
                    self.ends[row] = self.ends[row].max(self.ends[k]);
                }
            }
        }
        for k in (0..size).rev() {
            let row = &self.rows[k * width + half..][..self.ends[k] - k];
            let mut sum = b[k];
            for (value, x) in row[1..].iter().zip(&b[k + 1..]) {
                sum -= value * x;
            }
            b[k] = sum / row[0];
        }
        b.iter().all(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn a_band_solves_as_a_full_matrix_does() {
        let mut random = Random(7);
        for (size, half) in [(1, 0), (5, 1), (30, 4), (40, 11), (6, 9)] {
            let mut band = Banded::new(size, half);
            let mut full = DMatrix::zeros(size, size);
            for row in 0..size {
                for column in row.saturating_sub(half)..(row + half + 1).min(size) {
                    // A weak diagonal forces pivoting.
                    let value = if row == column { 1e-3 } else { 1.0 } * random.uniform();
                    band.add(row, column, value);
                    full[(row, column)] = value;
                }
            }
            let x = DVector::from_fn(size, |_, _| random.uniform());
            let mut b = &full * &x;
            assert!(band.solve(b.as_mut_slice()));
            let condition = full.svd(false, false).singular_values;
            let bound = 1e-13 * condition.max() / condition.min();
            assert!((b - x).amax() <= bound, "size {size}, half band {half}");
        }
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        let mut band = Banded::new(3, 1);
        for (row, column, value) in [(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0)] {
            band.add(row, column, value);
        }
        assert!(!band.solve(&mut [1.0, 2.0, 3.0]));
    }
}
