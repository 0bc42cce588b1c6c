//! A second way to an optimum of a chain, which shares the chain's first derivatives alone with the
//! product: the matrix of all conditions on a set of acting rows, with differences for second
//! derivatives, and Newton on that set. Tests compare the interior point and its counts with it.

mod banded;
pub(crate) mod curvature;
pub(crate) mod kkt;
pub(crate) mod newton;

use super::iterate::{Evaluated, Iterate};
use super::rows::{RowValue, What};
use crate::optimize::discrete::step::StepError;
use crate::optimize::methods::method::Watch;
use nalgebra::{DVector, Matrix3xX};

impl Evaluated<'_> {
    /// Evaluates the same chain at another iterate.
    pub fn elsewhere(&self, iterate: &Iterate) -> Result<Self, StepError> {
        iterate.evaluate(self.model, self.limits, Watch::NONE)
    }

    /// Returns the same with smooth rows: balls as half spaces.
    pub fn smooth(mut self) -> Self {
        self.rows.iter_mut().for_each(|value| *value = value.smooth());
        self
    }
}

impl RowValue {
    /// Returns the derivatives of a smooth row by the state, the inputs, and those of the stage after.
    pub fn slopes(&self) -> [Option<&DVector<f64>>; 3] {
        match self {
            Self::Half { state, inputs, next, .. } => [state.as_ref(), inputs.as_ref(), next.as_ref()],
            Self::Ball { .. } | Self::Idle => [None; 3],
        }
    }

    /// Returns the row as `c ≤ 0` with a smooth `c`: a ball as `(|v|² − 1)/2`.
    pub fn smooth(&self) -> Self {
        let Self::Ball { v, state, inputs } = self else { return self.clone() };
        let row = |slope: &Matrix3xX<f64>| slope.tr_mul(v);
        let (state, inputs) = (state.as_ref().map(row), inputs.as_ref().map(row));
        Self::Half { c: 0.5 * (v.norm_squared() - 1.0), state, inputs, next: None }
    }
}

impl What {
    /// Returns whether it is not linear.
    pub fn is_curved(&self) -> bool {
        matches!(self, Self::InputNorm { .. } | Self::RateNorm { .. } | Self::RateAxis { .. } | Self::Cone(_))
    }

    /// Returns whether it is one of an arc.
    pub fn is_of_arc(&self) -> bool {
        match self {
            Self::RateNorm { arc, .. } | Self::RateAxis { arc, .. } => *arc,
            Self::Cone(cone) => cone.is_of_arc(),
            _ => false,
        }
    }
}
