//! The higher-order discrete Euler–Poincaré equations: a Galerkin method reduced by the rotational
//! symmetry.
//!
//! The Lagrangian of a free body does not depend on its attitude, so the stage equations involve
//! `Π` only:
//! ```text
//! g_ν(ξ) = 0 (ν < s) ,   J_r⁻¹(ξ_s) g_s(ξ) = Π_0 ,   F = exp S(ξ_s) ,   Π_1 = FᵀΠ_0
//! ```
//! The attitude follows afterwards from `R_1 = R_0 F`.

use super::attitude::{Arc, Start};
use super::convergence::{Convergence, MAX_ITERATIONS, Next};
use super::linear::Dense;
use super::scheme::{DEGREES, Quadrature, Scheme};
use crate::mechanics::body::Inertia;
use crate::propagate::integrator::{StepError, SystemError};
use crate::{Matrix3, Vector3, lie};

/// The reduced integrator for one free body.
///
/// ```
/// use slewkit::{Inertia, Vector3};
/// use slewkit::propagate::integrator::{EulerPoincare, Quadrature};
///
/// let inertia = Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5))?;
/// let mut body = EulerPoincare::new(&inertia, 4, Quadrature::Gauss, 0.1)?;
/// let start = Vector3::new(0.1, 2.0, 0.3);
/// let mut momentum = start;
/// for _ in 0..100 {
///     momentum = body.step(&momentum)?.momentum;
/// }
/// let energy = |p: &Vector3| 0.5 * p.dot(&(inertia.j_inverse() * p));
/// assert!((energy(&momentum) - energy(&start)).abs() < 1e-11);
/// assert!((momentum.norm() - start.norm()).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct EulerPoincare {
    scheme: Scheme,
    j: Matrix3,
    j_inverse: Matrix3,
    step: f64,
    /// The step `h` divided by the mean principal moment.
    scale: f64,
    arc: Arc,
    matrix: Dense,
    right: Vec<f64>,
}

/// The result of one step of the reduced integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReducedStep {
    /// Rotation of the step minus the identity, `F − I`, for `R_1 = R_0 + R_0 (F − I)`.
    pub turn: Matrix3,
    /// Momentum `Π_1` at the end of the step, body axes [N·m·s].
    pub momentum: Vector3,
    /// Number of Newton iterations.
    pub iterations: u32,
}

impl EulerPoincare {
    /// Builds the integrator with curves of degree 1 to 6 and steps of `step` \[s\]. Its order is
    /// twice the degree.
    ///
    /// # Errors
    /// [`SystemError::Degree`] for another degree, [`SystemError::Step`] if the step is not
    /// positive.
    pub fn new(
        inertia: &Inertia,
        degree: usize,
        quadrature: Quadrature,
        step: f64,
    ) -> Result<Self, SystemError> {
        if !DEGREES.contains(&degree) {
            return Err(SystemError::Degree { degree });
        }
        if !(step > 0.0 && step.is_finite()) {
            return Err(SystemError::Step { step });
        }
        let scheme = Scheme::new(degree, quadrature);
        // The inertia is stored in units of the mean principal moment.
        let mean = inertia.mean();
        Ok(Self {
            j: inertia.j() / mean,
            j_inverse: inertia.j_inverse() * mean,
            step,
            scale: step / mean,
            arc: Arc::new(&scheme),
            matrix: Dense::new(3 * degree),
            right: vec![0.0; 3 * degree],
            scheme,
        })
    }

    /// Advances the body momentum `Π` [N·m·s] by one step.
    ///
    /// # Errors
    /// [`StepError::NotConverged`] if the step is too long, [`StepError::NotFinite`] if the
    /// momentum is not finite or too large.
    pub fn step(&mut self, momentum: &Vector3) -> Result<ReducedStep, StepError> {
        // In these units `hΠ` is the momentum for a step of length one.
        let g = momentum * self.scale;
        if !g.iter().all(|value| value.is_finite()) {
            return Err(StepError::NotFinite);
        }
        let s = self.scheme.degree;
        let start = Start { j: self.j, h: 1.0, momentum: g };
        let rate = self.j_inverse * g;
        let acceleration = self.j_inverse * g.cross(&rate);
        self.arc.constant_acceleration(&self.scheme, 1.0, &rate, &acceleration);
        let mut convergence = Convergence::new(true);
        for iterations in 1..=MAX_ITERATIONS {
            self.arc.place(&self.scheme);
            self.matrix.clear();
            let none = |_| Vector3::zeros();
            let jacobian = Some((&mut self.matrix, 0));
            self.arc.residual(&self.scheme, &start, none, &mut self.right, jacobian);
            self.matrix.solve(&mut self.right);
            match convergence.after(self.arc.correct(&self.right)) {
                Next::Iterate => {}
                Next::Done => {
                    let turn = lie::exp_minus_identity(&self.arc.xi[s - 1]);
                    return Ok(ReducedStep { turn, momentum: momentum + turn.tr_mul(momentum), iterations });
                }
                Next::GiveUp => break,
            }
        }
        Err(StepError::NotConverged { step: self.step, iterations: MAX_ITERATIONS })
    }
}
