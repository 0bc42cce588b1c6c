//! Lower bounds on differences of unknowns, and the elimination of unknowns by active bounds.

use nalgebra::{DMatrix, DVector, RowDVector};

/// Lower bound `x_b − x_a ≥ least` on the difference of two unknowns; an unknown whose index is
/// `None` counts as 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    pub a: Option<usize>,
    pub b: Option<usize>,
    pub least: f64,
}

impl Bound {
    /// Returns the slack of the bound: negative if it is violated.
    pub fn slack(&self, x: &DVector<f64>) -> f64 {
        self.b.map_or(0.0, |b| x[b]) - self.a.map_or(0.0, |a| x[a]) - self.least
    }

    /// Calls `into` with the index of each unknown in `x_b − x_a` and the derivative of this
    /// difference with respect to it, times `factor`.
    pub fn write(&self, factor: f64, mut into: impl FnMut(usize, f64)) {
        for (unknown, sign) in [(self.b, factor), (self.a, -factor)] {
            if let Some(unknown) = unknown {
                into(unknown, sign);
            }
        }
    }
}

/// Elimination of the dependent unknowns, `x = x₀ + G y` with the free unknowns `y`: the rows of
/// the active bounds in reduced echelon form. The entries of the rows are 0 and ±1, so the
/// dependent times follow from the free ones without round-off in the factors.
#[derive(Clone, Debug)]
pub(crate) struct Ties {
    unknowns: usize,
    /// Index of each dependent unknown with its row; the right-hand side comes after all unknowns.
    rows: Vec<(usize, RowDVector<f64>)>,
}

impl Ties {
    /// Returns the elimination of unknowns by the active bounds.
    pub fn of<'a>(unknowns: usize, acting: impl Iterator<Item = &'a Bound>) -> Self {
        let mut ties = Self { unknowns, rows: Vec::new() };
        acting.for_each(|bound| ties.add(bound));
        ties
    }

    /// Adds one active bound. A bound that is redundant or contradicts the others is ignored.
    pub fn add(&mut self, bound: &Bound) {
        let mut row = RowDVector::zeros(self.unknowns + 1);
        bound.write(1.0, |unknown, sign| row[unknown] += sign);
        row[self.unknowns] = bound.least;
        for (follows, other) in &self.rows {
            let part = row[*follows];
            row -= part * other;
        }
        // The last unknown in the row becomes the dependent one.
        let Some(follows) = (0..self.unknowns).rev().find(|unknown| row[*unknown].abs() > 0.5) else {
            return;
        };
        row /= row[follows];
        for (_, other) in &mut self.rows {
            let part = other[follows];
            *other -= part * &row;
        }
        self.rows.push((follows, row));
    }

    fn row(&self, unknown: usize) -> Option<&RowDVector<f64>> {
        self.rows.iter().find(|(follows, _)| *follows == unknown).map(|(_, row)| row)
    }

    /// Returns the matrix `G`, unknowns by free unknowns.
    pub fn matrix(&self) -> DMatrix<f64> {
        let free: Vec<usize> = (0..self.unknowns).filter(|unknown| self.row(*unknown).is_none()).collect();
        DMatrix::from_fn(self.unknowns, free.len(), |unknown, column| match self.row(unknown) {
            Some(row) => -row[free[column]],
            None => f64::from(free[column] == unknown),
        })
    }

    /// Returns `x` with the dependent unknowns recomputed from the free ones, so that the active
    /// bounds hold exactly.
    pub fn snapped(&self, x: &DVector<f64>) -> DVector<f64> {
        let of_free = |row: &RowDVector<f64>, follows: usize| -> f64 {
            (0..self.unknowns)
                .filter(|unknown| *unknown != follows)
                .map(|unknown| row[unknown] * x[unknown])
                .sum()
        };
        let mut snapped = x.clone();
        for (follows, row) in &self.rows {
            snapped[*follows] = row[self.unknowns] - of_free(row, *follows);
        }
        snapped
    }
}
