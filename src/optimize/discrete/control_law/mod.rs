//! The control law: the optimal inputs of an actuator set, as the Hamiltonian that they minimise.
//!
//! For a costate `q` in the axes of the set the optimal inputs minimise, at the running cost `l` of
//! the objective,
//!
//! ```text
//! u(q) = argmin l(u) + q·Bu  over the allowed u ,     K(q) = its value
//! K_q = B u(q) ,     S = −K_qq ≥ 0
//! ```
//!
//! so that state and costates move by the gradients of one `K`, and the linearisation is its
//! generalised Hessian: Newton on it is semismooth. A law is what K, its gradient and its Hessian
//! are:
//!
//! - `effort`: `l = ½ uᵀWu` without limits;
//! - `saturated`: the same within limits of the single inputs, or of the norm of what they give.

pub(crate) mod effort;
mod saturated;

use crate::maneuver::objective::Weighted;
use crate::{Matrix3, Vector3};
use effort::Effort;
use saturated::{Ball, Clipped};
pub use saturated::{Obstacle, obstacle};
use std::ops::Deref;

/// The law of one actuator set.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ControlLaw {
    /// Effort without limits.
    Effort(Effort),
    /// Effort, `|u_i| ≤ ū_i` under a diagonal weight.
    Size(Clipped),
    /// Effort, `|B u| ≤ ū`.
    Norm(Ball),
}

/// What the optimal inputs give and cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response {
    /// `K_q = B u`.
    pub output: Vector3,
    /// The running cost `l(u)`; `K = l + q·Bu`.
    pub cost: f64,
}

/// `K` of a law, by its derivatives; costates and outputs in the axes of the set.
pub(crate) trait Hamiltonian {
    /// `K_q`, and the running cost.
    fn response(&self, costate: &Vector3) -> Response;

    /// `S = −K_qq`, the generalised derivative of `−B u`.
    fn slope(&self, costate: &Vector3) -> Matrix3;

    /// How many times its limit the largest input would be without it.
    fn demand(&self, _: &Vector3) -> f64 {
        0.0
    }

    /// The multipliers of the limits: how fast `K` falls when a limit grows, `−∂K/∂ ln ū`.
    fn multipliers(&self, _: &Vector3) -> Vec<f64> {
        Vec::new()
    }

    /// How far the inputs are from their own projection after a step against the gradient: zero
    /// where the conditions of Karush, Kuhn and Tucker hold.
    fn projection_residual(&self, _: &Vector3) -> f64 {
        0.0
    }

    /// Appends the inputs themselves, in SI units, to `row`; `inputs` are those of the law.
    fn push_inputs(&self, inputs: &Weighted, costate: &Vector3, row: &mut Vec<f64>);
}

impl ControlLaw {
    /// The law of a set, in SI units: within its limits where they have a law, else without them.
    pub fn of(inputs: &Weighted) -> Self {
        let limits = inputs.set.limits();
        match (&limits.size, limits.norm) {
            _ if saturated::obstacle_of(inputs).is_some() => Self::Effort(Effort::of(inputs)),
            (Some(sizes), _) => Self::Size(Clipped::new(inputs, sizes)),
            (None, Some(limit)) => Self::Norm(Ball::new(&Effort::of(inputs), limit)),
            (None, None) => Self::Effort(Effort::of(inputs)),
        }
    }

    /// Whether limits are part of the law.
    pub fn is_limited(&self) -> bool {
        !matches!(self, Self::Effort(_))
    }

    /// The law in units in which `A` is `authority` times as large and an output of `output` is 1.
    pub fn scaled(&self, authority: f64, output: f64) -> Self {
        match self {
            Self::Effort(effort) => Self::Effort(Effort(effort.0 * authority)),
            Self::Size(clipped) => Self::Size(clipped.scaled(authority, output)),
            Self::Norm(ball) => Self::Norm(ball.scaled(authority, output)),
        }
    }

    /// The same law with every limit `factor` times as large.
    pub fn relaxed(&self, factor: f64) -> Self {
        match self {
            Self::Effort(_) => self.clone(),
            Self::Size(clipped) => Self::Size(clipped.relaxed(factor)),
            Self::Norm(ball) => Self::Norm(ball.relaxed(factor)),
        }
    }
}

/// A law is what its Hamiltonian is.
impl Deref for ControlLaw {
    type Target = dyn Hamiltonian;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Effort(effort) => effort,
            Self::Size(clipped) => clipped,
            Self::Norm(ball) => ball,
        }
    }
}

#[cfg(test)]
mod tests;
