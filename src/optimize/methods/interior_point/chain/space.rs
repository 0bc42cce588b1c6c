//! Work space for the derivatives of one stage.

use super::super::program::Shape;
use crate::{Matrix3, Vector3};

/// Work space of one stage, with `y` the state after the kick and `z` the unknowns of the stage.
#[derive(Default)]
pub(super) struct Space {
    pub inputs: Vec<f64>,
    pub wheels: Vec<f64>,
    /// Derivative of the drift with respect to `y`, n×n, column by column.
    pub drift: Vec<f64>,
    /// Derivative of the drift's rotation with respect to `y`.
    pub turn: Vec<Vector3>,
    /// Derivative of the drift's arc `log F` with respect to `y`.
    pub arc: Vec<Vector3>,
    /// Derivative of the physical rate with respect to `z`.
    pub rate: Vec<Vector3>,
    /// Elements (row, value) of the kick's derivative `Y`, column by column.
    pub kick: Vec<(usize, f64)>,
    /// Index in `kick` of the first element of each column.
    pub kick_first: Vec<usize>,
    /// Derivative of the arc `log F` with respect to `z`.
    pub arc_by_z: Vec<Vector3>,
    /// Matrix `Φ` of the second derivatives of the drift.
    pub phi: Vec<f64>,
    /// Matrix `Φ Y`, the second derivatives of the drift times the derivative of the kick.
    pub phi_kick: Vec<f64>,
    /// Costate `λ⁺` between kick and drift.
    pub after: Vec<f64>,
}

impl Space {
    pub fn of(shape: &Shape, inputs: usize) -> Self {
        let (n, z) = (shape.n, shape.z());
        Self {
            inputs: vec![0.0; inputs],
            wheels: vec![0.0; n],
            drift: vec![0.0; n * n],
            turn: vec![Vector3::zeros(); n],
            arc: vec![Vector3::zeros(); n],
            rate: vec![Vector3::zeros(); z],
            kick: Vec::with_capacity(z * 7),
            kick_first: Vec::with_capacity(z + 1),
            phi: vec![0.0; n * n],
            phi_kick: vec![0.0; n * z],
            arc_by_z: vec![Vector3::zeros(); z],
            after: vec![0.0; n],
        }
    }

    /// Returns the columns of `Y`.
    pub fn columns(&self) -> impl Iterator<Item = &[(usize, f64)]> {
        self.kick_first.windows(2).map(|pair| &self.kick[pair[0]..pair[1]])
    }
}

/// Adds `value` to the elements `(i, j)` and `(j, i)` of a symmetric matrix.
pub(super) fn both(matrix: &mut [f64], size: usize, i: usize, j: usize, value: f64) {
    matrix[i * size + j] += value;
    if i != j {
        matrix[j * size + i] += value;
    }
}

/// Adds the symmetric part of a 3×3 block to a symmetric matrix, as its diagonal block from index
/// `at` on.
pub(super) fn add_symmetric(matrix: &mut [f64], size: usize, at: usize, block: &Matrix3) {
    for i in 0..3 {
        for j in 0..3 {
            matrix[(at + j) * size + at + i] += 0.5 * (block[(i, j)] + block[(j, i)]);
        }
    }
}

/// Adds the second derivative of a limit with respect to the logarithm of the duration.
pub(super) fn bend_limit(curvature: &mut [f64], z: usize, duration: Option<usize>, value: f64) {
    if let Some(d) = duration {
        curvature[d * z + d] += value;
    }
}
