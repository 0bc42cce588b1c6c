//! A maneuver of minimum time in scaled units, and the inputs that minimise its Hamiltonian.
//!
//! Every input has the range `v ∈ [−1, 1]` about the middle of its limits, along an axis that has its half range for
//! length. The Hamiltonian is least at `v_j = −sign(s_j)` with the switching function `s_j = a_j·e`; smoothed,
//!
//! ```text
//! min over v of  s v + ε (1 − √(1 − v²))  =  ε − √(s² + ε²) ,      v = −s/√(s² + ε²)
//! ```
//!
//! and under a limit U of the norm of the torque `τ = −U e/√(|e|² + ε²)`. The added cost is not negative, so a smooth
//! extremal is a feasible maneuver, and longer than the optimum by no more than `∫ Σ ε (1 − √(1 − v²)) dt`, to first order.

use crate::{Matrix3, Vector3};

/// What limits the torque.
#[derive(Clone, Debug)]
pub(crate) enum Law {
    /// Inputs in `[−1, 1]` along these axes.
    Inputs(Vec<Vector3>),
    /// The norm of the torque.
    Norm(f64),
}

/// The least Hamiltonian over the torque.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response {
    /// The torque that makes it least.
    pub torque: Vector3,
    /// `G = −∂τ/∂e`.
    pub stiffness: Matrix3,
    /// `e·τ` and what smoothing adds.
    pub minimum: f64,
}

/// A maneuver of minimum time, scaled: from the identity.
#[derive(Clone, Debug)]
pub(crate) struct Extremal {
    pub j: Matrix3,
    pub j_inverse: Matrix3,
    pub law: Law,
    /// Torque of all inputs in the middle of their limits.
    pub middle: Vector3,
    pub start_rate: Vector3,
    pub end_rate: Vector3,
    pub end_attitude: Matrix3,
}

/// What is added to the switching functions, in units of ε, to tip a path from one branch to another: a constant and a
/// linear part for each component of the costate.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bias {
    pub constant: Vector3,
    pub linear: Vector3,
}

impl Bias {
    pub fn at(&self, fraction: f64) -> Vector3 {
        self.constant + (2.0 * fraction - 1.0) * self.linear
    }
}

impl Extremal {
    /// The same maneuver for another inertia.
    pub fn with_inertia(&self, j: Matrix3, rate_factor: f64) -> Option<Self> {
        Some(Self {
            j,
            j_inverse: j.try_inverse()?,
            start_rate: rate_factor * self.start_rate,
            end_rate: rate_factor * self.end_rate,
            ..self.clone()
        })
    }

    /// The smoothed law at the costate `e`, moved by `ε` times `bias`.
    #[inline(always)]
    pub fn smooth(&self, e: &Vector3, epsilon: f64, bias: &Vector3) -> Response {
        let e2 = epsilon * epsilon;
        let (mut torque, mut stiffness) = (self.middle, Matrix3::zeros());
        let mut minimum = e.dot(&self.middle);
        match &self.law {
            Law::Inputs(axes) => {
                for axis in axes {
                    let s = axis.dot(e) + epsilon * axis.dot(bias);
                    let root = (s * s + e2).sqrt();
                    let v = -s / root;
                    torque += v * axis;
                    minimum += epsilon - root;
                    stiffness += (e2 / (root * root * root)) * (axis * axis.transpose());
                }
            }
            Law::Norm(limit) => {
                let s = e + epsilon * bias;
                let root = (s.norm_squared() + e2).sqrt();
                torque -= (limit / root) * s;
                minimum += limit * (epsilon - root);
                stiffness += (limit / root) * (Matrix3::identity() - s * s.transpose() / (root * root));
            }
        }
        Response { torque, stiffness, minimum }
    }

    /// The torque of inputs at their limits, given by their signs.
    pub fn bang(&self, signs: &[f64]) -> Vector3 {
        let Law::Inputs(axes) = &self.law else { return self.middle };
        axes.iter().zip(signs).fold(self.middle, |sum, (axis, sign)| sum + *sign * axis)
    }

    /// The axes of the inputs; none under a limit of the norm.
    pub fn axes(&self) -> &[Vector3] {
        match &self.law {
            Law::Inputs(axes) => axes,
            Law::Norm(_) => &[],
        }
    }
}

impl Extremal {
    /// The least `e·τ` that the limits allow.
    pub fn least(&self, e: &Vector3) -> f64 {
        let least = match &self.law {
            Law::Inputs(axes) => axes.iter().map(|axis| axis.dot(e).abs()).sum(),
            Law::Norm(limit) => limit * e.norm(),
        };
        e.dot(&self.middle) - least
    }

    /// A torque that does not answer to the costate.
    pub fn held(&self, torque: &Vector3) -> Response {
        Response { torque: *torque, stiffness: Matrix3::zeros(), minimum: 0.0 }
    }
}
