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
//! under limits on inputs and rates and under keep-out and keep-in cones. The inputs `u` may be the
//! torques of reaction wheels. On SE(3) the problem also has the position `x` and the linear
//! momentum `γ`. A variational integrator discretises the problem, so that the discrete optimality
//! conditions are exact and the terminal conditions hold to round-off.
//!
//! # A body and two attitudes
//!
//! A [`Problem`] describes the body, the start, the end and the duration. [`plan()`] solves it,
//! in every requested homotopy class, and independent witnesses judge the result:
//!
//! ```
//! use slewkit::{Body, Inertia, Matrix3, Problem, Settings, Silent, State, Status, Vector3, lie, plan};
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
//! let first_torque = plan.solution.trajectory.torque[0]; // N·m, body axes
//! # assert!(first_torque.norm() > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Plan`] has the [`Solution`] with its [`Trajectory`], the [`Verification`] by the witnesses,
//! and a [`Status`]. A solver that fails returns a status and not an error; only a problem that
//! cannot be attempted is an error ([`PlanError`]). [`Settings`] select the method, tolerance and
//! time limit. They also select the motion that meets the end: the true motion under the held
//! inputs, by default, or the discrete motion, as in published plans ([`Target`]).
//!
//! # A constraint
//!
//! Limits of the inputs belong to the [`ActuatorSet`]. A [`Constraint`] limits where the body may
//! point or how fast it may turn. The verdict has a margin for each of them, at the nodes and on
//! the arcs between nodes:
//!
//! ```
//! # use slewkit::{Body, Inertia, Matrix3, Problem, Settings, Silent, State, Status, Vector3, lie, plan};
//! use slewkit::{Actuation, ActuatorSet, AxisFrame, Constraint, Direction, Limits, Pointing, Rule, Side};
//!
//! # let body = Body { inertia: Inertia::diagonal(Vector3::new(12.0, 10.0, 8.0))?, mass: None };
//! # let start = State::at_rest(Matrix3::identity());
//! # let end = State::at_rest(lie::exp(&Vector3::new(0.0, 0.0, 1.5)));
//! let limits = Limits { size: Some(vec![0.2; 3]), ..Limits::default() };
//! let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
//! let sun = Direction::Fixed(Vector3::new(1.0, 1.0, 0.6).normalize());
//! let cone = Pointing::new(Side::KeepOut, vec![Vector3::x()], vec![sun], 30.0_f64.to_radians());
//! let problem = Problem::attitude(body, start, end, 60.0)
//!     .with_actuation(Actuation::torques(torques))
//!     .with_constraint(Constraint { name: "Sun".into(), rule: Rule::Pointing(cone) });
//!
//! let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
//! assert_eq!(plan.status, Status::Solved);
//! assert!(plan.verification.unwrap().margins.iter().all(|margin| margin.holds()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! If a proof shows that no plan exists, the status is [`Status::Infeasible`], and
//! [`Solution::infeasible`] has the reason:
//!
//! ```
//! # use slewkit::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits, Matrix3, Problem, Settings, Silent};
//! # use slewkit::{State, Status, Vector3, lie, plan};
//! # let body = Body { inertia: Inertia::diagonal(Vector3::new(12.0, 10.0, 8.0))?, mass: None };
//! # let start = State::at_rest(Matrix3::identity());
//! # let end = State::at_rest(lie::exp(&Vector3::new(0.0, 0.0, 1.5)));
//! let limits = Limits { norm: Some(0.01), ..Limits::default() };
//! let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
//! let problem = Problem::attitude(body, start, end, 20.0).with_actuation(Actuation::torques(torques));
//!
//! let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
//! assert_eq!(plan.status, Status::Infeasible);
//! let proof = plan.solution.infeasible.expect("what is called infeasible is proved");
//! assert!(proof.duration_lower_bound.is_some_and(|seconds| seconds > 60.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Wheels, thrusters and targets
//!
//! [`Actuation::of_wheels`] describes reaction wheels by their axes, torque limits and momenta. An
//! [`Aim`] ends a maneuver with a boresight on a direction, which may move; the plan chooses the
//! roll of lowest cost. In this example four wheels turn a telescope to a star:
//!
//! ```
//! # use slewkit::{Body, Inertia, Matrix3, Problem, Settings, Silent, State, Status, Vector3, plan};
//! use slewkit::{Actuation, Aim, Direction, Wheels};
//!
//! # let body = Body { inertia: Inertia::diagonal(Vector3::new(12.0, 10.0, 8.0))?, mass: None };
//! # let start = State::at_rest(Matrix3::identity());
//! let axes = [[0.8, 0.0], [0.0, 0.8], [-0.8, 0.0], [0.0, -0.8]].map(|[x, y]| Vector3::new(x, y, 0.6));
//! let wheels = Wheels { momentum: vec![0.0; 4], momentum_limit: vec![1.0; 4] };
//! let star = Direction::Fixed(Vector3::new(1.0, 2.0, 2.0) / 3.0);
//! let problem = Problem::attitude(body, start, start, 60.0)
//!     .with_actuation(Actuation::of_wheels(axes.to_vec(), vec![0.05; 4], wheels)?)
//!     .with_aim_at_end(Aim::new(Vector3::z(), star).at_rest());
//!
//! let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
//! assert_eq!(plan.status, Status::Solved);
//! // The body's z axis ends on the star: the third column of the attitude.
//! let [w, x, y, z] = *plan.solution.trajectory.quaternion.last().unwrap();
//! let boresight = 2.0 * Vector3::new(x * z + w * y, y * z - w * x, w * w + z * z - 0.5);
//! assert!((boresight - Vector3::new(1.0, 2.0, 2.0) / 3.0).norm() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Thrusters push to one side only. For a body that only rotates, the inputs are their torques,
//! position × force. For a body that also translates, [`Actuation::of_thrusters`] takes positions
//! and directions. In this example six thrusters of 1 N on the faces of a cube turn the body with
//! minimum fuel:
//!
//! ```
//! # use slewkit::{Body, Inertia, Matrix3, Settings, Silent, State, Status, Vector3, lie, plan};
//! use slewkit::{Actuation, ActuatorSet, AxisFrame, Limits, Problem};
//!
//! # let body = Body { inertia: Inertia::diagonal(Vector3::new(12.0, 10.0, 8.0))?, mass: None };
//! # let start = State::at_rest(Matrix3::identity());
//! # let end = State::at_rest(lie::exp(&Vector3::new(0.3, -0.5, 0.8)));
//! let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
//! let places = [0.5 * y, -0.5 * y, 0.5 * z, -0.5 * z, 0.5 * x, -0.5 * x];
//! let torques = places.iter().zip([z, z, x, x, y, y]).map(|(place, force)| place.cross(&force));
//! let limits = Limits { size: Some(vec![1.0; 6]), one_sided: true, ..Limits::default() };
//! let set = ActuatorSet::new(torques.collect(), AxisFrame::Body)?.with_limits(limits)?;
//! let problem = Problem::minimum_fuel(body, start, end, 30.0).with_actuation(Actuation::torques(set));
//!
//! let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
//! assert_eq!(plan.status, Status::Solved);
//! // Every thruster is off or on, and the cost is the sum of all impulses, N·s.
//! assert!(plan.solution.cost > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A user-defined field
//!
//! The crate has [`UniformGravity`], [`GravityGradient`], [`CentralGravity`] and
//! [`SecondOrderGravity`]. Any other potential implements [`Environment`]: its energy, its force
//! and moment, and two derivatives. In this example a spring pulls the body axis `a` towards the
//! direction `b`, with `U = −k b·Ra`:
//!
//! ```
//! use slewkit::{Blocks, Environment, Pose, Vector3, Wrench, lie};
//! # use slewkit::{Body, Inertia, Matrix3, Problem, Settings, Silent, State, Status, plan};
//!
//! #[derive(Debug)]
//! struct Spring { stiffness: f64, axis: Vector3, direction: Vector3 }
//!
//! impl Environment for Spring {
//!     fn potential(&self, pose: &Pose) -> f64 {
//!         -self.stiffness * self.direction.dot(&(pose.attitude * self.axis))
//!     }
//!     fn wrench(&self, pose: &Pose) -> Wrench {
//!         let seen = pose.attitude.tr_mul(&self.direction);
//!         Wrench { moment: self.stiffness * self.axis.cross(&seen), ..Wrench::zero() }
//!     }
//!     fn gradient(&self, pose: &Pose) -> Blocks {
//!         let seen = pose.attitude.tr_mul(&self.direction);
//!         Blocks { rr: self.stiffness * lie::hat(&self.axis) * lie::hat(&seen), ..Blocks::zero() }
//!     }
//!     fn curvature(&self, pose: &Pose, costates: &Wrench) -> Blocks {
//!         let seen = pose.attitude.tr_mul(&self.direction);
//!         let turned = costates.moment.cross(&self.axis);
//!         Blocks { rr: self.stiffness * lie::hat(&turned) * lie::hat(&seen), ..Blocks::zero() }
//!     }
//! }
//!
//! # let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 1.6, 1.1))?, mass: None };
//! # let start = State::at_rest(Matrix3::identity());
//! # let end = State::at_rest(lie::exp(&Vector3::new(0.0, 1.5, 0.5)));
//! let spring = Spring { stiffness: 0.8, axis: Vector3::z(), direction: Vector3::x() };
//! let problem = Problem::attitude(body, start, end, 2.0).with_environment(spring);
//! # let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
//! # assert_eq!(plan.status, Status::Solved);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `examples/own_environment.rs` checks such derivatives by finite differences.
//!
//! # An observer
//!
//! [`Silent`] observes nothing. An [`Observer`] receives the progress of a solve and may stop it:
//!
//! ```
//! use slewkit::{Control, Observer, Progress};
//! # use slewkit::{Body, Inertia, Matrix3, Problem, Settings, State, Status, Vector3, lie, plan};
//!
//! struct Patience { calls: usize }
//!
//! impl Observer for Patience {
//!     fn on_progress(&mut self, progress: &Progress) -> Control {
//!         println!("{} from {}, {:.3} s", progress.rung, progress.start, progress.elapsed);
//!         self.calls -= 1;
//!         if self.calls == 0 { Control::Stop } else { Control::Continue }
//!     }
//! }
//!
//! # let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 1.6, 1.1))?, mass: None };
//! # let start = State::at_rest(Matrix3::identity());
//! # let end = State::at_rest(lie::exp(&Vector3::new(1.0, 2.0, -0.5)));
//! # let problem = Problem::attitude(body, start, end, 2.0);
//! let plan = plan(&problem, &Settings::default(), None, &mut Patience { calls: 3 })?;
//! assert_eq!(plan.status, Status::Interrupted);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Beyond a plan
//!
//! [`Gains`] give the torque correction that brings a body back to the plan after a deviation:
//!
//! ```
//! # use slewkit::{Body, Inertia, Matrix3, Problem, Settings, Silent, State, Status, Vector3, lie, plan};
//! use slewkit::Gains;
//!
//! # let body = Body { inertia: Inertia::diagonal(Vector3::new(12.0, 10.0, 8.0))?, mass: None };
//! # let start = State::at_rest(Matrix3::identity());
//! # let end = State::at_rest(lie::exp(&Vector3::new(0.4, -0.8, 1.2)));
//! let problem = Problem::attitude(body, start, end, 60.0).with_steps(100);
//! let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
//!
//! let gains = Gains::regulator(&problem, &plan.solution.trajectory)?;
//! // The error z = [ζ; δΠ] at the tenth step, rad and N·m·s in body axes: a torque against it.
//! let error = [0.01, 0.0, 0.0, 0.0, 0.0, 0.0];
//! let torque: Vec<f64> = gains.correction(10, &error).map(|correction| -correction).collect();
//! assert!(torque[0] < 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Replanner`] finds the neighbouring plan from another start in microseconds. A [`Guess`]
//! starts the search for a similar maneuver from a plan. [`verify()`] verifies any recorded
//! trajectory. A [`Simulation`] propagates a motion without optimisation. The crates
//! `slewkit-files` and `slewkit-report` read and write spec files, plan files and reports; the
//! crate `slewkit-cli` is the program `slew`:
//!
//! ```text
//! spec file ──▶ slewkit_files::spec ──▶ Problem, Settings ──▶ plan() ──▶ Plan ──▶ slewkit_files::export
//! ```
//!
//! A path at the root of the crate is stable. Modules that the documentation hides serve the
//! sibling crates and may change with any version. They contain the errors of constructors; each
//! message states which number is wrong, and why.
//!
//! # Features
//!
//! By default all features are off, and the crate solves and verifies. `threads` sums mutual
//! gravity on several threads and tests a plan on two, `wide` uses the widest registers of the
//! machine, `argmin` runs Newton iterations with the library of that name, and `sdp` adds global
//! lower bounds. No feature changes a bit of a result. The program `slew` uses the first three.
//!
//! # What this crate does not do
//!
//! The crate does not model flexible bodies. It does not prove global minima: a plan without
//! conjugate points is a local minimum. It has no ephemerides and no estimation: gains use a
//! measured attitude and rate.
//!
//! # Conventions
//!
//! `slew help conventions` prints the conventions of specs and files.
//!
//! - **Attitude** `R` maps body vectors to reference-frame vectors. The reference frame is inertial
//!   unless the environment rotates it ([`Environment::frame_rate`]).
//! - **Perturbations** act on the body side: `R exp S(ζ)`. `S(a) b = a × b`.
//! - **Angular velocity** `Ω` (inertial, also under a turning frame) and **momentum** `Π = JΩ` are
//!   in body axes; position `x`, velocity and linear momentum `γ = m ẋ` in the reference frame.
//! - **Costates** are left-trivialised and signed so that `u = −W⁻¹ Bᵀ λ^Π`.
//! - **Tangent vectors and costates** are ordered `[ζ, δΠ]` (`N = 6`) or `[δx, δγ, ζ, δΠ]`
//!   (`N = 12`): one pair (configuration, momentum) for the translation, one for the rotation.
//! - **Units** are SI and radians. Solvers work in units in which `T = 1` and the mean principal
//!   moment of inertia is 1.
//! - **Quaternions** are Hamilton, scalar first, `[w, x, y, z]`; `q` and `−q` are one attitude.
//! - **Numbers of equations**, such as (4.13), refer to Leok, *An overview of Lie group
//!   variational integrators and their applications to optimal control*. Other sources are
//!   named where they are used.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[doc(hidden)]
pub mod assured;
#[doc(hidden)]
pub mod closed_loop;
#[doc(hidden)]
pub mod feedback;
mod flight;
pub mod lie;
#[doc(hidden)]
pub mod maneuver;
#[doc(hidden)]
pub mod mechanics;
#[doc(hidden)]
pub mod numerics;
#[doc(hidden)]
pub mod optimize;
#[doc(hidden)]
pub mod plan;
#[doc(hidden)]
pub mod propagate;
#[doc(hidden)]
pub mod sequence;
#[cfg(test)]
mod testing;
#[doc(hidden)]
pub mod uncertainty;
#[doc(hidden)]
pub mod verify;

pub use feedback::Gains;
pub use lie::Rotation;
pub use maneuver::{
    Aim, Constraint, Direction, Duration, Fuel, Method, Motion, Objective, Outcome, Path, Pointing, Problem,
    Rule, Rung, Scheme, Settings, Side, Solution, State, Target, Thoroughness, Trajectory, Weights,
};
pub use mechanics::environment::{Blocks, Pose, Wrench};
pub use mechanics::{
    Actuation, ActuatorSet, AxisFrame, Body, CentralGravity, Environment, GravityGradient, Inertia, Limits,
    SecondOrderGravity, UniformGravity, Wheels,
};
pub use plan::{Control, Guess, Observer, Plan, PlanError, Progress, Replanner, Silent, Status, plan};
pub use propagate::simulate::Simulation;
pub use verify::{Verification, verify};

/// A nalgebra vector of three components of double precision, such as an angular velocity, a
/// torque or a direction.
pub type Vector3 = nalgebra::Vector3<f64>;
/// A 3×3 nalgebra matrix of double precision, such as an attitude, an inertia or a weight.
pub type Matrix3 = nalgebra::Matrix3<f64>;
