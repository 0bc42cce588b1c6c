//! A row at an iterate: a half space or a ball, with its derivatives.

use crate::Vector3;
use nalgebra::{DVector, Matrix3xX};

/// A row at an iterate. `next` is the derivative with respect to the inputs of the stage after.
#[derive(Clone, Debug)]
pub(crate) enum RowValue {
    /// `c ≤ 0`.
    Half { c: f64, state: Option<DVector<f64>>, inputs: Option<DVector<f64>>, next: Option<DVector<f64>> },
    /// `|v| ≤ 1`, 3×n and 3×m derivatives.
    Ball { v: Vector3, state: Option<Matrix3xX<f64>>, inputs: Option<Matrix3xX<f64>> },
    /// Nothing is bounded: the ends of an arc without an extremum of its own bound it.
    Idle,
}

impl RowValue {
    /// A half space by the state, and by the inputs of its own stage.
    pub(super) fn half(c: f64, state: Option<DVector<f64>>, inputs: Option<DVector<f64>>) -> Self {
        Self::Half { c, state, inputs, next: None }
    }

    /// The same with a limit that is so many times as large: `c ≤ by − 1`, or `|v| ≤ by`. Its growth with the duration is in no
    /// derivative here.
    pub(super) fn grown(self, by: f64) -> Self {
        match self {
            Self::Half { c, state, inputs, next } => Self::Half { c: c + 1.0 - by, state, inputs, next },
            Self::Ball { v, state, inputs } => {
                let of_limit = |slope: Matrix3xX<f64>| slope / by;
                Self::Ball { v: v / by, state: state.map(of_limit), inputs: inputs.map(of_limit) }
            }
            Self::Idle => Self::Idle,
        }
    }

    /// The violation: positive where the row does not hold.
    pub fn violation(&self) -> f64 {
        match self {
            Self::Half { c, .. } => *c,
            Self::Ball { v, .. } => v.norm() - 1.0,
            Self::Idle => -1.0,
        }
    }
}
