//! Sparse matrices with a fixed pattern, whose values change in place: those of the cone solver,
//! with what it keeps to itself.
//!
//! `CscMatrix::new_from_triplets` sums duplicates in the order given and keeps explicit zeros, and
//! so does the solver where `input_sparse_dropzeros` is off: an entry that is zero today has its
//! place in the pattern tomorrow.
//!
//! # Why no sparse matrix of our own?
//!
//! The cone solver's keeps explicit zeros and sums duplicates in the order given, which is all that
//! a fixed pattern needs. Its products and the place of an entry are not public; those few lines
//! are ours (`convex/sparse.rs`).

/// A matrix in compressed sparse columns: sorted rows, no duplicates.
pub(crate) type Sparse = clarabel::algebra::CscMatrix<f64>;

/// What [`Sparse`] lacks in public.
pub(crate) trait SparseParts {
    /// The sum of `entries` = (row, column, value).
    fn of_entries(rows: usize, columns: usize, entries: &[(usize, usize, f64)]) -> Self;
    /// The entries as (row, column, value), column by column.
    fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_;
    /// Index into the values of the entry (row, column); `None` outside the pattern.
    fn slot(&self, row: usize, column: usize) -> Option<usize>;

    /// `out += Aᵀ z`.
    fn add_transposed_product(&self, z: &[f64], out: &mut [f64]) {
        self.entries().for_each(|(row, column, value)| out[column] += value * z[row]);
    }
}

impl SparseParts for Sparse {
    fn of_entries(rows: usize, columns: usize, entries: &[(usize, usize, f64)]) -> Self {
        let row = entries.iter().map(|entry| entry.0).collect();
        let column = entries.iter().map(|entry| entry.1).collect();
        Self::new_from_triplets(rows, columns, row, column, entries.iter().map(|entry| entry.2).collect())
    }

    fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let of_column = move |column: usize| self.colptr[column]..self.colptr[column + 1];
        let entry = move |column: usize| {
            of_column(column).map(move |slot| (self.rowval[slot], column, self.nzval[slot]))
        };
        (0..self.n).flat_map(entry)
    }

    fn slot(&self, row: usize, column: usize) -> Option<usize> {
        let range = *self.colptr.get(column)?..*self.colptr.get(column + 1)?;
        self.rowval[range.clone()].binary_search(&row).ok().map(|offset| range.start + offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triplets_are_sorted_summed_and_zeros_kept() {
        let matrix = Sparse::of_entries(3, 2, &[(2, 1, 5.0), (0, 0, 1.0), (2, 1, -2.0), (1, 1, 0.0)]);
        let entries: Vec<_> = matrix.entries().collect();
        assert_eq!(entries, [(0, 0, 1.0), (1, 1, 0.0), (2, 1, 3.0)]);
        assert_eq!(matrix.slot(1, 1), Some(1));
        assert_eq!(matrix.slot(1, 0), None);
        assert_eq!(matrix.slot(0, 7), None);
    }

    #[test]
    fn the_transposed_product_is_that_of_the_dense_matrix() {
        let matrix = Sparse::of_entries(2, 3, &[(0, 0, 1.0), (1, 0, 2.0), (1, 2, -3.0)]);
        let mut product = [1.0; 3];
        matrix.add_transposed_product(&[1.0, 10.0], &mut product);
        assert_eq!(product, [22.0, 1.0, -29.0]);
    }
}
