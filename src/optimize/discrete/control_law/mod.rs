//! The control law: the optimal inputs of an actuator set, derived from the minimised Hamiltonian.
//!
//! For a costate `q` in the axes of the set and the running cost `l` of the objective, the optimal
//! inputs minimise
//!
//! ```text
//! u(q) = argmin l(u) + q·Bu  over the allowed u ,     K(q) = its value
//! K_q = B u(q) ,     S = −K_qq ≥ 0
//! ```
//!
//! so that state and costates move by the gradients of one `K`, and the linearisation is its
//! generalised Hessian: Newton's method on it is semismooth. A law is defined by K, its gradient
//! and its Hessian:
//!
//! - `effort`: `l = ½ uᵀWu` without limits;
//! - `saturated`: `l = ½ uᵀWu` with a limit on each input, or on the norm of the output `Bu`.

pub(crate) mod effort;
mod saturated;

use crate::maneuver::objective::Weighted;
use crate::{Matrix3, Vector3};
use effort::Effort;
use saturated::{Ball, Clipped};
pub use saturated::{Obstacle, obstacle};
use std::ops::Deref;

/// Control law of one actuator set.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ControlLaw {
    /// Minimum effort without limits.
    Effort(Effort),
    /// Minimum effort with `|u_i| ≤ ū_i` and a diagonal weight.
    Size(Clipped),
    /// Minimum effort with `|B u| ≤ ū`.
    Norm(Ball),
}

/// Output and running cost of the optimal inputs for one costate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response {
    /// Output of the optimal inputs, `K_q = B u`.
    pub output: Vector3,
    /// Running cost `l(u)` of the optimal inputs; `K = l + q·Bu`.
    pub cost: f64,
}

/// The minimised Hamiltonian `K` of a control law and its derivatives. Costates and outputs are in
/// the axes of the actuator set.
pub(crate) trait Hamiltonian {
    /// Returns the output `K_q` and the running cost of the optimal inputs.
    fn response(&self, costate: &Vector3) -> Response;

    /// Returns `S = −K_qq`, the generalised derivative of `−B u` with respect to the costate `q`.
    fn slope(&self, costate: &Vector3) -> Matrix3;

    /// Returns the largest ratio of an unlimited optimal input to its limit; 0 if the law has no
    /// limits.
    fn demand(&self, _: &Vector3) -> f64 {
        0.0
    }

    /// Returns the multipliers of the limits, `−∂K/∂ ln ū`: the decrease of `K` per relative
    /// increase of each limit.
    fn multipliers(&self, _: &Vector3) -> Vec<f64> {
        Vec::new()
    }

    /// Returns the distance between the inputs and their projected gradient step, which is zero if
    /// the KKT conditions hold.
    fn projection_residual(&self, _: &Vector3) -> f64 {
        0.0
    }

    /// Appends the optimal inputs in SI units to `row`; `inputs` is the weighted set of this law.
    fn push_inputs(&self, inputs: &Weighted, costate: &Vector3, row: &mut Vec<f64>);
}

impl ControlLaw {
    /// Builds the law of an actuator set in SI units. Limits without a closed-form law are left
    /// out.
    pub fn of(inputs: &Weighted) -> Self {
        let limits = inputs.set.limits();
        match (&limits.size, limits.norm) {
            _ if saturated::obstacle_of(inputs).is_some() => Self::Effort(Effort::of(inputs)),
            (Some(sizes), _) => Self::Size(Clipped::new(inputs, sizes)),
            (None, Some(limit)) => Self::Norm(Ball::new(&Effort::of(inputs), limit)),
            (None, None) => Self::Effort(Effort::of(inputs)),
        }
    }

    /// Returns whether the law contains limits.
    pub fn is_limited(&self) -> bool {
        !matches!(self, Self::Effort(_))
    }

    /// Returns the law in units in which the authority `A` is `authority` times as large and an
    /// output of the size `output` is 1.
    pub fn scaled(&self, authority: f64, output: f64) -> Self {
        match self {
            Self::Effort(effort) => Self::Effort(Effort(effort.0 * authority)),
            Self::Size(clipped) => Self::Size(clipped.scaled(authority, output)),
            Self::Norm(ball) => Self::Norm(ball.scaled(authority, output)),
        }
    }

    /// Returns the law with every limit multiplied by `factor`.
    pub fn relaxed(&self, factor: f64) -> Self {
        match self {
            Self::Effort(_) => self.clone(),
            Self::Size(clipped) => Self::Size(clipped.relaxed(factor)),
            Self::Norm(ball) => Self::Norm(ball.relaxed(factor)),
        }
    }
}

/// Gives access to the Hamiltonian, which defines the law.
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
