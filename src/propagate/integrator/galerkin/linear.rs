//! A small dense linear system, solved in reusable buffers.

/// A row-major square matrix, and in-place solution by elimination with partial pivoting.
#[derive(Clone, Debug, Default)]
pub(super) struct Dense {
    size: usize,
    rows: Vec<f64>,
}

impl Dense {
    pub fn new(size: usize) -> Self {
        Self { size, rows: vec![0.0; size * size] }
    }

    pub fn clear(&mut self) {
        self.rows.fill(0.0);
    }

    /// Adds a 3×3 block whose first element is at (`row`, `column`).
    pub fn add(&mut self, row: usize, column: usize, block: &crate::Matrix3) {
        for i in 0..3 {
            let start = (row + i) * self.size + column;
            for (j, value) in self.rows[start..start + 3].iter_mut().enumerate() {
                *value += block[(i, j)];
            }
        }
    }

    /// Returns the 3×3 block whose first element is at (`row`, `column`).
    pub fn block(&self, row: usize, column: usize) -> crate::Matrix3 {
        let row = |i: usize| &self.rows[(row + i) * self.size + column..][..3];
        let [a, b, c] = [row(0), row(1), row(2)];
        crate::Matrix3::new(a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2])
    }

    /// Overwrites the 3×3 block whose first element is at (`row`, `column`).
    pub fn put(&mut self, row: usize, column: usize, block: &crate::Matrix3) {
        for i in 0..3 {
            let start = (row + i) * self.size + column;
            self.rows[start..start + 3].copy_from_slice(&[block[(i, 0)], block[(i, 1)], block[(i, 2)]]);
        }
    }

    /// Solves `A x = b`: `b` receives the solution, and the elements of `A` are destroyed. If the
    /// matrix is singular, the result is not finite.
    pub fn solve(&mut self, b: &mut [f64]) {
        let n = self.size;
        // Rows have different units (angular and linear momentum), so pivots are comparable only
        // after scaling.
        for (row, b) in self.rows.chunks_exact_mut(n).zip(b.iter_mut()) {
            let largest = row.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
            let scale = 1.0 / largest;
            row.iter_mut().for_each(|value| *value *= scale);
            *b *= scale;
        }
        for k in 0..n {
            let mut pivot = k;
            for i in k + 1..n {
                if self.rows[i * n + k].abs() > self.rows[pivot * n + k].abs() {
                    pivot = i;
                }
            }
            let (head, tail) = self.rows.split_at_mut((k + 1) * n);
            let lead = &mut head[k * n..];
            if pivot > k {
                lead.swap_with_slice(&mut tail[(pivot - k - 1) * n..(pivot - k) * n]);
                b.swap(k, pivot);
            }
            let inverse = 1.0 / lead[k];
            for (i, row) in tail.chunks_exact_mut(n).enumerate() {
                let factor = row[k] * inverse;
                for (value, above) in row[k + 1..].iter_mut().zip(&lead[k + 1..]) {
                    *value -= factor * above;
                }
                b[k + 1 + i] -= factor * b[k];
            }
        }
        for k in (0..n).rev() {
            let row = &self.rows[k * n..(k + 1) * n];
            let sum: f64 = row[k + 1..].iter().zip(&b[k + 1..]).map(|(a, x)| a * x).sum();
            b[k] = (b[k] - sum) / row[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn badly_scaled_rows_are_solved_and_a_singular_matrix_is_not_finite() {
        let (n, mut random) = (9, Random(3));
        let mut matrix = Dense::new(n);
        for (index, value) in matrix.rows.iter_mut().enumerate() {
            *value = random.uniform() * if index / n > 5 { 1e12 } else { 1e-6 };
        }
        let x: Vec<f64> = (0..n).map(|_| random.uniform()).collect();
        let product = |row: &[f64]| -> f64 { row.iter().zip(&x).map(|(a, x)| a * x).sum() };
        let mut b: Vec<f64> = matrix.rows.chunks_exact(n).map(product).collect();
        matrix.solve(&mut b);
        for (found, expected) in b.iter().zip(&x) {
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
        let mut b = vec![1.0; n];
        Dense::new(n).solve(&mut b);
        assert!(b.iter().any(|value| !value.is_finite()));
    }
}
