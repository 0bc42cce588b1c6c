//! Bounds of differences of unknowns, and how those that act tie unknowns together.

use nalgebra::{DMatrix, DVector, RowDVector};

/// `x_b − x_a ≥ least`; an absent unknown counts as 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    pub a: Option<usize>,
    pub b: Option<usize>,
    pub least: f64,
}

impl Bound {
    /// Returns by how much it is kept, or violated where that is negative.
    pub fn slack(&self, x: &DVector<f64>) -> f64 {
        self.b.map_or(0.0, |b| x[b]) - self.a.map_or(0.0, |a| x[a]) - self.least
    }

    /// Writes its slope, times a factor, into one row or column for each unknown.
    pub fn write(&self, factor: f64, mut into: impl FnMut(usize, f64)) {
        for (unknown, sign) in [(self.b, factor), (self.a, -factor)] {
            if let Some(unknown) = unknown {
                into(unknown, sign);
            }
        }
    }
}

/// How unknowns follow from those that are free, `x = x₀ + G y`: the rows of the bounds that act,
/// in reduced echelon form. Their entries are 0 and ±1, so that times that hang on others do so to
/// the last bit.
#[derive(Clone, Debug)]
pub(crate) struct Ties {
    unknowns: usize,
    /// What follows, and its row with the right side after all unknowns.
    rows: Vec<(usize, RowDVector<f64>)>,
}

impl Ties {
    /// Returns those of bounds that act.
    pub fn of<'a>(unknowns: usize, acting: impl Iterator<Item = &'a Bound>) -> Self {
        let mut ties = Self { unknowns, rows: Vec::new() };
        acting.for_each(|bound| ties.add(bound));
        ties
    }

    /// Adds one more; what the others say already, or deny, is left out.
    pub fn add(&mut self, bound: &Bound) {
        let mut row = RowDVector::zeros(self.unknowns + 1);
        bound.write(1.0, |unknown, sign| row[unknown] += sign);
        row[self.unknowns] = bound.least;
        for (follows, other) in &self.rows {
            let part = row[*follows];
            row -= part * other;
        }
        // The last one follows.
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

    /// Returns `G`.
    pub fn matrix(&self) -> DMatrix<f64> {
        let free: Vec<usize> = (0..self.unknowns).filter(|unknown| self.row(*unknown).is_none()).collect();
        DMatrix::from_fn(self.unknowns, free.len(), |unknown, column| match self.row(unknown) {
            Some(row) => -row[free[column]],
            None => f64::from(free[column] == unknown),
        })
    }

    /// Returns unknowns that follow as they should from those given ones that are free.
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
