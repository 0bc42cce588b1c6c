//! A row at an iterate: a half space, a ball or a kink, with its derivatives.

use super::super::model::Model;
use crate::Vector3;
use nalgebra::{DVector, Matrix3xX};

/// A row at an iterate. `next` is the derivative with respect to the inputs of the stage after.
#[derive(Clone, Debug)]
pub(crate) enum RowValue {
    /// `c ≤ 0`.
    Half { c: f64, state: Option<DVector<f64>>, inputs: Option<DVector<f64>>, next: Option<DVector<f64>> },
    /// `|v| ≤ 1`, 3×n and 3×m derivatives.
    Ball { v: Vector3, state: Option<Matrix3xX<f64>>, inputs: Option<Matrix3xX<f64>> },
    /// `v`, or a component of it, where the cost has a kink.
    Kink { v: f64, state: Option<DVector<f64>>, inputs: DVector<f64> },
    /// The arc has no extremum of its own: its ends bound it.
    Idle,
}

impl RowValue {
    /// A half space by the state, and by the inputs of its own stage.
    pub(super) fn half(c: f64, state: Option<DVector<f64>>, inputs: Option<DVector<f64>>) -> Self {
        Self::Half { c, state, inputs, next: None }
    }

    /// The same with a limit that grows as `s^power`: `c ≤ s^power − 1`, or `|v| ≤ s^power`.
    pub(super) fn grown(self, model: &Model, duration: usize, stretch: f64, power: i32) -> Self {
        let (limit, slope) = (stretch.powi(power), f64::from(power));
        match self {
            Self::Half { c, state, inputs, next } => {
                let mut state = state.unwrap_or_else(|| DVector::zeros(model.n));
                state[duration] -= slope * limit;
                Self::Half { c: c + 1.0 - limit, state: Some(state), inputs, next }
            }
            Self::Ball { v, state, inputs } => {
                let v = v / limit;
                let mut state = state.map_or_else(|| Matrix3xX::zeros(model.n), |state| state / limit);
                let mut column = state.column_mut(duration);
                column -= v * slope;
                Self::Ball { v, state: Some(state), inputs: inputs.map(|inputs| inputs / limit) }
            }
            Self::Kink { .. } | Self::Idle => self,
        }
    }

    /// The violation: positive where the row does not hold.
    pub fn violation(&self) -> f64 {
        match self {
            Self::Half { c, .. } => *c,
            Self::Ball { v, .. } => v.norm() - 1.0,
            Self::Kink { .. } | Self::Idle => -1.0,
        }
    }

    /// Derivatives with respect to the state, the inputs, and those of the stage after, of a row that is smooth.
    pub fn slopes(&self) -> [Option<&DVector<f64>>; 3] {
        match self {
            Self::Half { state, inputs, next, .. } => [state.as_ref(), inputs.as_ref(), next.as_ref()],
            Self::Kink { state, inputs, .. } => [state.as_ref(), Some(inputs), None],
            Self::Ball { .. } | Self::Idle => [None; 3],
        }
    }

    /// `v` of a kink.
    pub fn kinked(&self) -> f64 {
        if let Self::Kink { v, .. } = self { *v } else { 0.0 }
    }

    /// The row as `c ≤ 0` with a smooth `c`: a ball as `(|v|² − 1)/2`.
    pub fn smooth(&self) -> Self {
        match self {
            Self::Ball { v, state, inputs } => {
                let row = |slope: &Matrix3xX<f64>| slope.tr_mul(v);
                Self::half(0.5 * (v.norm_squared() - 1.0), state.as_ref().map(row), inputs.as_ref().map(row))
            }
            other => other.clone(),
        }
    }
}
