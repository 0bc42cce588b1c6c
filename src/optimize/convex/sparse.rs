//! Sparse matrices with a fixed sparsity pattern and variable values: the type of the cone solver,
//! with operations that the solver does not make public.
//!
//! `CscMatrix::new_from_triplets` sums duplicates in the order given and keeps explicit zeros. The
//! solver keeps them too if `input_sparse_dropzeros` is off, so an entry that is zero now keeps its
//! place in the pattern for later values.
//!
//! # Why no sparse matrix type of our own?
//!
//! The type of the cone solver keeps explicit zeros and sums duplicates in the order given, which
//! is all that a fixed pattern needs. Its products and the position of an entry are not public;
//! these few lines are implemented here (`convex/sparse.rs`).

/// A matrix in compressed sparse columns: sorted rows, no duplicates.
pub(crate) type Sparse = clarabel::algebra::CscMatrix<f64>;

/// Operations on [`Sparse`] that the solver does not make public.
pub(crate) trait SparseParts {
    /// Builds a matrix from `entries` = (row, column, value), summing duplicates.
    fn of_entries(rows: usize, columns: usize, entries: &[(usize, usize, f64)]) -> Self;
    /// Returns the entries as (row, column, value), column by column.
    fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_;
    /// Returns the position of the entry (row, column) among the values; `None` outside the
    /// pattern.
    fn slot(&self, row: usize, column: usize) -> Option<usize>;

    /// Adds a product with the transpose: `out += Aᵀ z`.
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
