//! The discrete Riccati condition of one step, `I + Gᵀ Λ Z⁻¹ G`, in arrays of fixed size, and the
//! number of its negative eigenvalues.
//!
//! G has columns only for the momenta, half as many as there are states, so `Z⁻¹` is applied only
//! to these columns.

use crate::Matrix3;
use crate::numerics::factor::eliminate;
use nalgebra::SMatrix;
use std::array;

/// Largest number of columns of the input root G: 6 on SE(3), of which SO(3) uses half.
pub(super) const MOST: usize = 6;

/// Returns the row of the state on which column `column` of G acts; `γ` comes before `Π`.
fn row_of<const N: usize>(column: usize) -> usize {
    if N == 12 && column < 3 { 3 + column } else { N - 3 + column % 3 }
}

/// Counts the negative eigenvalues of the Riccati condition; `None` if Z is singular to the
/// tolerance of [`crate::numerics::factor::Factor`].
pub(super) fn negative<const N: usize>(
    z: &SMatrix<f64, N, N>,
    dual: &SMatrix<f64, N, N>,
    root: &[Matrix3; 2],
) -> Option<usize> {
    let half = N / 2;
    let g = |row: usize, column: usize| match (row / 3, column / 3) {
        _ if row >= half || column >= half => 0.0,
        (a, b) if a != b => 0.0,
        (0, 0) if N == 12 => root[0][(row, column)],
        _ => root[1][(row % 3, column % 3)],
    };
    let mut columns = [[0.0; MOST]; N];
    for row in 0..half {
        columns[row_of::<N>(row)] = array::from_fn(|column| if column < half { g(row, column) } else { 0.0 });
    }
    if !eliminate::<N, MOST>(z, &mut columns, N / 2) {
        return None;
    }
    let mut dual_columns = [[0.0; MOST]; MOST];
    for (row, out) in dual_columns.iter_mut().enumerate().take(half) {
        for (index, columns) in columns.iter().enumerate() {
            let factor = dual[(row_of::<N>(row), index)];
            for (out, column) in out.iter_mut().zip(columns).take(half) {
                *out += factor * column;
            }
        }
    }
    let form = array::from_fn(|row| {
        array::from_fn(|column| {
            let sum: f64 = (0..half).map(|index| g(index, row) * dual_columns[index][column]).sum();
            sum + if row == column { 1.0 } else { 0.0 }
        })
    });
    Some(negative_pivots(form, half))
}

/// Counts the negative eigenvalues of the symmetric part of a matrix: the negative pivots of
/// `L D Lᵀ` (Sylvester's law).
fn negative_pivots(form: [[f64; MOST]; MOST], size: usize) -> usize {
    let mut a: [[f64; MOST]; MOST] =
        array::from_fn(|row| array::from_fn(|column| (form[row][column] + form[column][row]) * 0.5));
    let mut negative = 0;
    for pivot in 0..size {
        let lead = a[pivot];
        negative += usize::from(lead[pivot] < 0.0);
        for row in &mut a[pivot + 1..size] {
            let factor = row[pivot] / lead[pivot];
            for (value, above) in row[pivot + 1..size].iter_mut().zip(&lead[pivot + 1..size]) {
                *value -= factor * above;
            }
        }
    }
    negative
}
