//! A row evaluated at an iterate, as a half space or a ball, with its derivatives.

use super::step::{Arc, rate as rate_at_node};
use crate::Vector3;
use crate::optimize::chain::model::{ChainState, Model};
use crate::optimize::chain::rows::{Cone, What};
use nalgebra::{DVector, Matrix3xX};

/// Value of a row at an iterate, with its derivatives with respect to the state and the inputs of
/// its stage. `next` is the derivative with respect to the inputs of the next stage.
#[derive(Clone, Debug)]
pub(crate) enum RowValue {
    /// Half space `c ≤ 0`.
    Half { c: f64, state: Option<DVector<f64>>, inputs: Option<DVector<f64>>, next: Option<DVector<f64>> },
    /// Ball `|v| ≤ 1`, with 3×n and 3×m derivatives.
    Ball { v: Vector3, state: Option<Matrix3xX<f64>>, inputs: Option<Matrix3xX<f64>> },
    /// No bound: the arc has no extremum inside, so the rows of its end nodes apply.
    Idle,
}

impl RowValue {
    /// Builds a half space with derivatives by the state and by the inputs of its own stage.
    fn half(c: f64, state: Option<DVector<f64>>, inputs: Option<DVector<f64>>) -> Self {
        Self::Half { c, state, inputs, next: None }
    }

    /// Returns the row with its limit multiplied by `by`: `c ≤ by − 1`, or `|v| ≤ by`. The
    /// derivatives do not include the derivative of the limit with respect to the duration.
    fn grown(self, by: f64) -> Self {
        match self {
            Self::Half { c, state, inputs, next } => Self::Half { c: c + 1.0 - by, state, inputs, next },
            Self::Ball { v, state, inputs } => {
                let of_limit = |slope: Matrix3xX<f64>| slope / by;
                Self::Ball { v: v / by, state: state.map(of_limit), inputs: inputs.map(of_limit) }
            }
            Self::Idle => Self::Idle,
        }
    }

    /// Returns the violation: positive if the row does not hold.
    pub fn violation(&self) -> f64 {
        match self {
            Self::Half { c, .. } => *c,
            Self::Ball { v, .. } => v.norm() - 1.0,
            Self::Idle => -1.0,
        }
    }
}

/// State, arc and inputs at which a row is evaluated.
pub(crate) struct Place<'a> {
    pub state: &'a ChainState,
    pub inputs: &'a [f64],
    pub next: &'a [f64],
    /// Arc that begins at the node; `None` at the last node, whose rows do not use it.
    pub arc: Option<&'a Arc>,
}

impl RowValue {
    /// Returns the derivatives of a smooth row with respect to the state, the inputs, and the
    /// inputs of the next stage.
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
    /// Evaluates the row at a place of stage `stage`.
    pub fn at(&self, model: &Model, stage: usize, place: &Place) -> RowValue {
        let row = self.of_stated(model, stage, place);
        let grows = model.duration.is_some() && self.growth() > 0;
        if grows { row.grown(place.state.stretch.powi(self.growth())) } else { row }
    }

    /// Evaluates the row with the limit for the duration of the problem.
    fn of_stated(&self, model: &Model, stage: usize, place: &Place) -> RowValue {
        let unit = |input: usize, value: f64| {
            let mut row = DVector::zeros(model.m);
            row[input] = value;
            Some(row)
        };
        match self {
            Self::InputSize { input, sign, limit } => {
                RowValue::half(sign * place.inputs[*input] / limit - 1.0, None, unit(*input, sign / limit))
            }
            Self::InputRate { input, sign, limit } => RowValue::Half {
                c: sign * (place.next[*input] - place.inputs[*input]) / limit - 1.0,
                state: None,
                inputs: unit(*input, -sign / limit),
                next: unit(*input, sign / limit),
            },
            Self::InputNorm { forces, limit } => {
                let (axes, first) = model.channel(*forces);
                let mut slope = Matrix3xX::zeros(model.m);
                for (index, axis) in axes.iter().enumerate() {
                    slope.set_column(first + index, &(axis / *limit));
                }
                let v = &slope * DVector::from_column_slice(place.inputs);
                RowValue::Ball { v, state: None, inputs: Some(slope) }
            }
            Self::RateNorm { arc, limit } => {
                let (rate, state, inputs) = rate(model, stage, place, *arc);
                let inputs = inputs.map(|slope| slope / *limit);
                RowValue::Ball { v: rate / *limit, state: Some(state / *limit), inputs }
            }
            Self::RateAxis { arc, axis, sign, limit } => {
                let (rate, state, inputs) = rate(model, stage, place, *arc);
                let row = |slope: &Matrix3xX<f64>| slope.row(*axis).transpose() * (sign / limit);
                RowValue::half(sign * rate[*axis] / limit - 1.0, Some(row(&state)), inputs.as_ref().map(row))
            }
            Self::Cone(cone) => cone.at(model, stage, place),
            Self::Wheel { wheel, sign, limit } => {
                let lag = model.lag(stage);
                let momentum = place.state.wheels[*wheel] + lag * place.inputs[model.forces + wheel];
                let mut state = DVector::zeros(model.n);
                state[6 + wheel] = sign / limit;
                let inputs = if lag > 0.0 { unit(model.forces + wheel, sign * lag / limit) } else { None };
                RowValue::half(sign * momentum / limit - 1.0, Some(state), inputs)
            }
            Self::Push { input, limit } => {
                RowValue::half(-place.inputs[*input] / limit, None, unit(*input, -1.0 / limit))
            }
            Self::Burn { .. } | Self::BurnOfNorm { .. } => RowValue::Idle,
        }
    }

    /// Returns whether the row is nonlinear.
    pub fn is_curved(&self) -> bool {
        matches!(self, Self::InputNorm { .. } | Self::RateNorm { .. } | Self::RateAxis { .. } | Self::Cone(_))
    }

    /// Returns whether the row belongs to an arc.
    pub fn is_of_arc(&self) -> bool {
        match self {
            Self::RateNorm { arc, .. } | Self::RateAxis { arc, .. } => *arc,
            Self::Cone(cone) => cone.is_of_arc(),
            _ => false,
        }
    }
}

impl Cone {
    /// Evaluates the cone's row at a place of stage `stage`.
    fn at(&self, model: &Model, stage: usize, place: &Place) -> RowValue {
        let along = place.arc.filter(|_| self.is_of_arc());
        let (attitude, stretch) = (&place.state.attitude, place.state.stretch);
        let Some(found) = self.met(model, stage, (attitude, stretch), along.map(|arc| &arc.turn), false)
        else {
            return RowValue::Idle;
        };
        let mut state = DVector::zeros(model.n);
        state.rows_mut(model.zeta(), 3).copy_from(&found.by_attitude);
        if let Some(arc) = along {
            state += arc.slope.tr_mul(&found.by_arc);
        }
        RowValue::half(found.c, Some(state), None)
    }
}

/// Returns the angular velocity at the node or on the arc, with its derivatives.
fn rate(
    model: &Model,
    stage: usize,
    place: &Place,
    arc: bool,
) -> (Vector3, Matrix3xX<f64>, Option<Matrix3xX<f64>>) {
    if let Some(arc) = place.arc.filter(|_| arc) {
        let h = model.dynamics.grid.step(stage);
        return (arc.turn / h, &arc.slope / h, None);
    }
    let (rate, state, inputs) = rate_at_node(model, stage, place.state, place.inputs);
    (rate, state, (model.lag(stage) > 0.0).then_some(inputs))
}
