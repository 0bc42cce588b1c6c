//! States of the chain and their tangent vectors.

use super::Model;
use crate::mechanics::environment::Pose;
use crate::numerics::compensated::Sum;
use crate::optimize::discrete::step::{Costate, Point};
use crate::{Matrix3, Vector3};
use nalgebra::DVector;

/// State of the chain, scaled. With wheels, `momentum` is the total momentum of body and wheels.
#[derive(Clone, Debug)]
pub(crate) struct ChainState {
    pub position: Vector3,
    pub linear_momentum: Vector3,
    pub attitude: Matrix3,
    pub momentum: Vector3,
    pub wheels: DVector<f64>,
    /// Duration as a multiple of the duration of the problem; 1 if the duration is fixed.
    pub stretch: f64,
}

impl ChainState {
    /// Converts a point of the planner to a state of the chain.
    pub fn of(point: &Point, wheels: DVector<f64>) -> Self {
        Self {
            position: point.position.value,
            linear_momentum: point.linear_momentum.value,
            attitude: point.attitude.value,
            momentum: point.momentum.value,
            wheels,
            stretch: 1.0,
        }
    }

    /// Converts a state from the units of the problem's duration to the units of a duration
    /// `stretch` times as long.
    pub(super) fn hastened(&self, stretch: f64) -> Self {
        let (linear_momentum, momentum) = (self.linear_momentum * stretch, self.momentum * stretch);
        Self { linear_momentum, momentum, wheels: &self.wheels * stretch, stretch, ..self.clone() }
    }

    /// Converts the state to a point of the planner.
    pub fn point(&self) -> Point {
        Point {
            position: Sum::new(self.position),
            linear_momentum: Sum::new(self.linear_momentum),
            attitude: Sum::new(self.attitude),
            momentum: Sum::new(self.momentum),
        }
    }

    /// Returns position and attitude.
    pub fn pose(&self) -> Pose {
        Pose { position: self.position, attitude: self.attitude }
    }
}

/// Returns the difference `a ⊖ b` in the tangent space at `b`.
pub fn difference(model: &Model, a: &ChainState, b: &ChainState) -> DVector<f64> {
    let mut out = DVector::zeros(model.n);
    let (zeta, pi) = (model.zeta(), model.pi());
    let blocks = a.point().minus(&b.point());
    if model.moves {
        out.rows_mut(0, 3).copy_from(&blocks.x);
        out.rows_mut(3, 3).copy_from(&blocks.gamma);
    }
    out.rows_mut(zeta, 3).copy_from(&blocks.zeta);
    out.rows_mut(pi, 3).copy_from(&blocks.pi);
    if model.wheels > 0 {
        out.rows_mut(6, model.wheels).copy_from(&(&a.wheels - &b.wheels));
    }
    if let Some(duration) = model.duration {
        out[duration] = (a.stretch / b.stretch).ln();
    }
    out
}

/// Returns the momenta of a state as a tangent vector.
pub(super) fn momenta(model: &Model, state: &ChainState) -> DVector<f64> {
    let mut momenta = DVector::zeros(model.n);
    if model.moves {
        momenta.rows_mut(3, 3).copy_from(&state.linear_momentum);
    }
    momenta.rows_mut(model.pi(), 3).copy_from(&state.momentum);
    momenta.rows_mut(6, model.wheels).copy_from(&state.wheels);
    momenta
}

/// Converts a costate vector of the chain to the blocks of the shooting's costate.
pub(crate) fn costate_blocks(model: &Model, costate: &DVector<f64>) -> Costate {
    let part = |row: usize| Vector3::new(costate[row], costate[row + 1], costate[row + 2]);
    let zero = Vector3::zeros();
    let (x, gamma) = if model.zeta() == 6 { (part(0), part(3)) } else { (zero, zero) };
    Costate { x, gamma, zeta: part(model.zeta()), pi: part(model.pi()) }
}
