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
//! under limits on inputs and rates, keep-out and keep-in cones, driven by torques or reaction wheels,
//! and the same on SE(3) with position `x` and linear momentum `γ`. It is discretised by a
//! variational integrator, so that the discrete optimality conditions are exact and the terminal
//! conditions are met to round-off.
//!
//! # In fifteen lines
//!
//! ```
//! use slewkit::{lie, Matrix3, Vector3};
//! use slewkit::maneuver::{Problem, Settings, State};
//! use slewkit::mechanics::{Body, Inertia};
//! use slewkit::plan::{plan, Silent, Status};
//!
//! let body = Body { inertia: Inertia::diagonal(Vector3::new(120.0, 100.0, 80.0))?, mass: None };
//! let start = State::at_rest(Matrix3::identity());
//! let end = State::at_rest(lie::exp(&Vector3::new(0.4, -0.8, 1.2)));
//! let problem = Problem::attitude(body, start, end, 60.0).with_steps(200);
//!
//! let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
//! assert_eq!(plan.status, Status::Solved);
//! assert!(plan.solution.terminal.largest() < 1e-12);
//! assert_eq!(plan.solution.optimality.conjugate_points, Some(0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How the main types relate
//!
//! ```text
//! spec file ──▶ slewkit_files::spec ──▶ Problem, Settings ──▶ plan::plan ──▶ Plan ──▶ slewkit_files::export
//!                                        │                                    │
//!              Body, Environment, Actuation, State × 2         Solution, Verification, Status
//! ```
//!
//! A caller builds a [`maneuver::problem::Problem`] in SI units and [`maneuver::settings::Settings`], or has the crate
//! `slewkit-files` read both from a spec. [`plan::plan`] solves
//! ([`optimize::search::solve`] gives a [`maneuver::solution::Solution`] with its [`maneuver::solution::Outcome`])
//! and has [`verify::verify`] judge the result; [`plan::Status`] says what became of it. A field of the caller's own
//! implements [`mechanics::environment::Environment`]. How a solver stopped is a value; only what cannot be computed at
//! all is an error.
//!
//! With [`maneuver::Target::Motion`] a plan lands: the discrete target is shifted until the true motion under the held
//! inputs meets the end ([`maneuver::Landing`] tells how). By default the discrete motion meets it, as in what is
//! published, and the true one ends beside it by the error of the discretisation.
//!
//! ```text
//! spec file ──▶ slewkit_files::spec ──▶ simulate::Simulation ──▶ rows
//!                               │
//!            integrator::{System, SystemState, Kind}, full_body::Potential
//! ```
//!
//! [`propagate::simulate`] propagates bodies without optimisation, one or many, by any [`propagate::integrator`],
//! under an environment or their mutual gravity ([`mechanics::full_body`]).
//!
//! # Features
//!
//! None is on by default: the crate solves and verifies. `threads` adds the sum of mutual gravity over several threads and
//! the tests of a plan on two, `wide` the widest registers of the machine, `argmin` the driver of that name for Newton
//! iterations, `sdp` global lower bounds (`optimize::lower_bound`). None of them changes a result by a bit; the program
//! takes the first three. Files, reports and the program are the crates `slewkit-files`, `slewkit-report` and
//! `slewkit-cli`.
//!
//! # What this crate does not do
//!
//! No flexible bodies. No claim of a global minimum: no conjugate point means a local one. No ephemerides, no
//! estimation, no control in the loop.
//!
//! # Conventions, stated here and nowhere else
//!
//! - **Attitude** `R` maps body vectors to reference-frame vectors. The reference frame is inertial
//!   unless the environment turns it ([`mechanics::environment::Environment::frame_rate`]).
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

mod flight;
pub mod lie;
pub mod maneuver;
pub mod mechanics;
pub mod numerics;
pub mod optimize;
pub mod plan;
pub mod propagate;
#[cfg(test)]
mod testing;
pub mod verify;

/// A vector of three components.
pub type Vector3 = nalgebra::Vector3<f64>;
/// A 3×3 matrix.
pub type Matrix3 = nalgebra::Matrix3<f64>;
