//! Optimal attitude maneuvers of a rigid body, planned with Lie group variational integrators.
//!
//! # The problem
//!
//! ```text
//! minimise    ∫ ½ uᵀ W u dt
//! subject to  Ṙ = R S(Ω),   Π̇ = Π × Ω + M(R) + B u,   Π = J Ω
//!             (R, Π) given at t = 0 and at t = T
//! ```
//!
//! and the same on SE(3) with position `x` and linear momentum `γ`. It is discretised by a
//! variational integrator, so that the discrete optimality conditions are exact and the terminal
//! conditions are met to round-off.
//!
//! # Conventions, stated here and nowhere else
//!
//! - **Attitude** `R` maps body vectors to reference-frame vectors. The reference frame is inertial
//!   unless the environment turns it ([`environment::Environment::frame_rate`]).
//! - **Perturbations** act on the body side: `R exp S(ζ)`. `S(a) b = a × b`.
//! - **Angular velocity** `Ω` (inertial, also under a turning frame) and **momentum** `Π = JΩ` are in
//!   body axes; position `x`, velocity and linear momentum `γ = m ẋ` in the reference frame.
//! - **Costates** are left-trivialised and signed so that `u = −W⁻¹ Bᵀ λ^Π`.
//! - **Tangent vectors and costates** are ordered `[ζ, δΠ]` (`N = 6`) or `[δx, δγ, ζ, δΠ]` (`N = 12`):
//!   one pair (configuration, momentum) for the translation, one for the rotation.
//! - **Units** are SI and radians. Solvers work in units in which `T = 1` and the mean principal
//!   moment of inertia is 1.
//! - **Quaternions** are Hamilton, scalar first, `[w, x, y, z]`; `q` and `−q` are one attitude.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod actuation;
pub mod body;
pub mod dynamics;
pub mod environment;
pub mod export;
pub mod extremal;
pub mod lie;
mod lifted;
pub mod plan;
pub mod planner;
pub mod problem;
mod proof;
mod reachability;
pub mod settings;
mod shooting;
pub mod simulate;
pub mod solution;
pub mod spec;
#[cfg(test)]
mod testing;
pub mod verify;

/// A vector of three components.
pub type Vector3 = nalgebra::Vector3<f64>;
/// A 3×3 matrix.
pub type Matrix3 = nalgebra::Matrix3<f64>;
