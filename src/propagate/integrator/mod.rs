//! Integrators for n rigid bodies on SE(3)ⁿ, behind one trait.
//!
//! ```text
//! Ṙ_i = R_i S(Ω_i)     Π̇_i = Π_i × Ω_i + M_i      Π_i = J_i Ω_i
//! ẋ_i = γ_i/m_i        γ̇_i = f_i
//! ```
//!
//! A [`System`] describes the bodies and the forces on them, a [`SystemState`] their poses and
//! momenta. A [`Kind`] names a method and starts it. The resulting [`Integrator`] owns its state
//! and buffers and steps:
//!
//! ```text
//! Kind::start(&System, &SystemState, h) ──▶ dyn Integrator: step, state, facts, work
//! ```
//!
//! The variational methods come from a discrete Lagrangian `L_d ≈ ∫ L dt` over a step. They are
//! therefore symplectic, conserve the momentum of every symmetry to round-off, and have a bounded
//! energy error.
//!
//! A reference frame that rotates at a constant rate requires one more factor in each step of every
//! method. Within a step the methods use fixed inertial axes, which coincide with the axes of the
//! frame at the start of the step. At the end of the step `exp(−h S(n))` transforms all quantities
//! to the frame.

mod adaptive;
mod ambient;
mod course;
mod drift;
mod drift_and_kick;
mod galerkin;
mod implicit;
mod implicit_midpoint;
mod kind;
mod lagrangian_verlet;
mod lie_group_rk;
mod runge_kutta;
mod state;
mod system;
mod tableau;
#[cfg(test)]
mod tests;

pub use crate::mechanics::full_body::invariants::Momentum;
pub(crate) use galerkin::Galerkin;
pub use galerkin::{EulerPoincare, Quadrature, ReducedStep};
pub use implicit::AttitudeEquation;
pub use kind::{ErrorControl, Kind, UnknownKind};
pub use state::SystemState;
pub use system::{Input, Invariants, System, SystemError};

use crate::numerics::figures;
use thiserror::Error;

/// A running integration: it owns the state and advances it by steps of one length.
///
/// ```
/// # use slewkit::{Body, Inertia, Matrix3, State, Vector3};
/// # use slewkit::propagate::integrator::{ErrorControl, Kind, System};
/// let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5))?, mass: None };
/// let system = System::new(vec![body], None)?;
/// let start = system.state(&[State::attitude(Matrix3::identity(), Vector3::new(0.01, 1.0, 0.0))])?;
/// for kind in Kind::all() {
///     let mut method = kind.start(&system, &start, 0.01, &ErrorControl::default())?;
///     method.step(&[])?;
///     println!("{}: {:?} {:?}", kind.name(), method.facts(), method.work());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Integrator: Send {
    /// Advances all bodies by one step under the potential and `inputs`. The slice contains one
    /// input for each body, or is empty. Inputs beyond the number of bodies are ignored.
    ///
    /// # Errors
    /// A [`StepError`], after which the method must not be stepped again. [`StepError::TooLong`]
    /// leaves the state unchanged; the other errors may leave it partly advanced.
    fn step(&mut self, inputs: &[Input]) -> Result<(), StepError>;

    /// Returns the state after the steps made so far.
    fn state(&self) -> &SystemState;

    /// Returns the theoretical properties of the method.
    fn facts(&self) -> Facts;

    /// Returns the work of the steps made so far.
    fn work(&self) -> Work;
}

/// The theoretical properties of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facts {
    /// Order of convergence.
    pub order: u32,
    /// Whether a step needs no iteration that involves the potential. (The implicit attitude
    /// equation of a Lie–Verlet step involves one body only, so that method counts as explicit.)
    pub explicit: bool,
    /// Whether the map from step to step is symplectic.
    pub symplectic: bool,
    /// Whether the momentum of every symmetry of the potential is conserved to round-off.
    pub preserves_momentum: bool,
    /// Whether attitudes stay rotations to round-off, or to the tolerance of an inner iteration.
    pub preserves_group: bool,
    /// Number of evaluations of the potential per step; `None` if iterations or error control
    /// determine it.
    pub force_evaluations: Option<u32>,
}

impl Facts {
    /// The properties of Lie–Verlet. Other methods replace those fields in which they differ.
    pub(crate) const VARIATIONAL: Self = Self {
        order: 2,
        explicit: true,
        symplectic: true,
        preserves_momentum: true,
        preserves_group: true,
        force_evaluations: Some(1),
    };
}

/// The work of the steps made so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Number of steps made.
    pub steps: u64,
    /// Number of evaluations of the potential, including evaluations at the start. One evaluation
    /// covers all bodies.
    pub force_evaluations: u64,
    /// Number of Newton or fixed-point iterations, summed over the bodies if each body has its own.
    pub iterations: u64,
    /// Number of steps that an error control has rejected.
    pub rejected: u64,
}

/// The reason why a step failed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StepError {
    /// The implicit attitude equation has no physical solution, because the step is too long.
    #[error(
        "step {} s is too long for body {body}: h|J⁻¹Π| is {turn:.3}, and a step must turn the body \
        by less than 90°; use a step of {} s or less",
        figures::rounded(*step, 4),
        figures::rounded(step * 0.5 / turn, 4)
    )]
    TooLong {
        /// Number of the body, from 1.
        body: usize,
        /// Length of the step \[s\].
        step: f64,
        /// Turn of the body in the step, `h|J⁻¹Π|` \[rad\].
        turn: f64,
    },
    /// An iteration for the equations of the whole step did not converge.
    #[error(
        "the equations of a step of {} s did not converge in {iterations} iterations; shorten the step",
        figures::rounded(*step, 4)
    )]
    NotConverged {
        /// Length of the step \[s\].
        step: f64,
        /// Number of iterations made.
        iterations: u32,
    },
    /// The error control requires steps that are too short to make progress, or too many of them.
    #[error(
        "the error control failed within a step of {} s; increase the tolerance or look for a collision",
        figures::rounded(*step, 4)
    )]
    GaveUp {
        /// Length of the step \[s\].
        step: f64,
    },
    /// A number of the state became NaN or infinite.
    #[error("the step gives numbers that are not finite; look for a collision, or shorten the step")]
    NotFinite,
}
