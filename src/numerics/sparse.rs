//! Sparse matrices with a fixed pattern, whose values change in place.

/// A matrix in compressed sparse columns: sorted rows, no duplicates, zeros kept where they were given.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sparse {
    rows: usize,
    columns: usize,
    /// Where each column starts in `row` and `values`, length `columns + 1`.
    pub start: Vec<usize>,
    pub row: Vec<usize>,
    /// The entries, column by column. [`Sparse::slot`] finds one.
    pub values: Vec<f64>,
}

impl Sparse {
    /// The sum of `entries` = (row, column, value). A zero keeps its place in the pattern, so that it may become
    /// something else later.
    ///
    /// # Panics
    /// When an entry is outside the matrix: the builder is wrong, not its data.
    pub fn from_triplets(rows: usize, columns: usize, entries: &[(usize, usize, f64)]) -> Self {
        let mut order: Vec<usize> = (0..entries.len()).collect();
        order.sort_by_key(|&index| (entries[index].1, entries[index].0));
        let mut matrix =
            Self { rows, columns, start: vec![0; columns + 1], row: Vec::new(), values: Vec::new() };
        let mut last = None;
        for index in order {
            let (row, column, value) = entries[index];
            assert!(row < rows && column < columns, "entry ({row}, {column}) is outside {rows}x{columns}");
            if last == Some((row, column)) {
                *matrix.values.last_mut().expect("a duplicate follows an entry") += value;
            } else {
                matrix.row.push(row);
                matrix.values.push(value);
                matrix.start[column + 1] += 1;
                last = Some((row, column));
            }
        }
        for column in 0..columns {
            matrix.start[column + 1] += matrix.start[column];
        }
        matrix
    }

    /// A matrix without entries.
    #[cfg(feature = "sdp")]
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self::from_triplets(rows, columns, &[])
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Index into `values` of the entry (row, column); `None` outside the pattern.
    pub fn slot(&self, row: usize, column: usize) -> Option<usize> {
        let range = *self.start.get(column)?..*self.start.get(column + 1)?;
        self.row[range.clone()].binary_search(&row).ok().map(|offset| range.start + offset)
    }

    /// Whether `other` has entries in the same places.
    pub fn same_pattern(&self, other: &Self) -> bool {
        self.rows == other.rows
            && self.columns == other.columns
            && self.start == other.start
            && self.row == other.row
    }

    /// The entries as (row, column, value), column by column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.columns).flat_map(move |column| {
            (self.start[column]..self.start[column + 1])
                .map(move |slot| (self.row[slot], column, self.values[slot]))
        })
    }

    /// `out += A x`.
    pub fn add_product(&self, x: &[f64], out: &mut [f64]) {
        for (row, column, value) in self.entries() {
            out[row] += value * x[column];
        }
    }

    /// `out += Aᵀ z`.
    pub fn add_transposed_product(&self, z: &[f64], out: &mut [f64]) {
        for (row, column, value) in self.entries() {
            out[column] += value * z[row];
        }
    }

    /// `out += P x` of the symmetric matrix of which this is the upper triangle.
    pub fn add_symmetric_product(&self, x: &[f64], out: &mut [f64]) {
        for (row, column, value) in self.entries() {
            out[row] += value * x[column];
            if row != column {
                out[column] += value * x[row];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triplets_are_sorted_summed_and_zeros_kept() {
        let matrix = Sparse::from_triplets(3, 2, &[(2, 1, 5.0), (0, 0, 1.0), (2, 1, -2.0), (1, 1, 0.0)]);
        let entries: Vec<_> = matrix.entries().collect();
        assert_eq!(entries, [(0, 0, 1.0), (1, 1, 0.0), (2, 1, 3.0)]);
        assert_eq!(matrix.slot(1, 1), Some(1));
        assert_eq!(matrix.slot(1, 0), None);
        assert_eq!(matrix.slot(0, 7), None);
    }

    #[test]
    fn products_are_those_of_the_dense_matrix() {
        let matrix = Sparse::from_triplets(2, 3, &[(0, 0, 1.0), (1, 0, 2.0), (1, 2, -3.0)]);
        let (mut forward, mut backward) = ([0.0; 2], [1.0; 3]);
        matrix.add_product(&[1.0, 10.0, 100.0], &mut forward);
        matrix.add_transposed_product(&[1.0, 10.0], &mut backward);
        assert_eq!(forward, [1.0, -298.0]);
        assert_eq!(backward, [22.0, 1.0, -29.0]);
        let upper = Sparse::from_triplets(2, 2, &[(0, 0, 2.0), (0, 1, 3.0), (1, 1, 5.0)]);
        let mut product = [0.0; 2];
        upper.add_symmetric_product(&[1.0, 10.0], &mut product);
        assert_eq!(product, [32.0, 53.0]);
    }
}
