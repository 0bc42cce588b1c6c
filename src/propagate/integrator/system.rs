//! The bodies of a simulation and the forces on them: n rigid bodies, a potential, and actuator
//! inputs.

use super::state::SystemState;
use crate::lie::Rotation;
use crate::maneuver::problem::State;
use crate::mechanics::body::Body;
use crate::mechanics::environment::{Blocks, Environment, Pose, Symmetry, Wrench};
use crate::mechanics::full_body::Potential;
use crate::mechanics::full_body::invariants::{self, Momentum};
use crate::{Matrix3, Vector3, lie};
use std::sync::Arc;
use thiserror::Error;

/// A system of n rigid bodies, and the potential that acts on and between them.
///
/// A body without a mass rotates only. Its position is part of the poses that the potential
/// receives, and does not change.
///
/// ```
/// use slewkit::{Body, Inertia, State, UniformGravity, Vector3, lie};
/// use slewkit::propagate::integrator::{ErrorControl, Kind, System};
/// use std::sync::Arc;
///
/// let body = Body { inertia: Inertia::diagonal(Vector3::new(0.13, 0.28, 0.17))?, mass: None };
/// let gravity = UniformGravity::new(1.0, 9.81, Vector3::z(), Vector3::new(0.0, 0.0, 0.3))?;
/// let pendulum = System::single(body, Arc::new(gravity))?;
/// let start = State::attitude(lie::exp(&Vector3::new(1.0, 0.2, 0.0)), Vector3::new(0.1, 0.2, 3.0));
/// let start = pendulum.state(&[start])?;
/// let before = pendulum.invariants(&start);
///
/// let mut verlet = Kind::LieVerlet.start(&pendulum, &start, 1e-3, &ErrorControl::default())?;
/// for _ in 0..1000 {
///     verlet.step(&[])?;
/// }
/// let after = pendulum.invariants(verlet.state());
/// assert!((after.energy - before.energy).abs() < 1e-5);
/// assert!((after.angular_momentum.z - before.angular_momentum.z).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct System {
    bodies: Vec<Body>,
    potential: Option<Arc<dyn Potential>>,
    /// Angular velocity `n` of the reference frame in its own axes [rad/s].
    frame_rate: Vector3,
}

/// The reason why bodies and states do not form a valid system.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SystemError {
    /// The system has no bodies.
    #[error("a system needs at least one body")]
    Empty,
    /// The mass of a body is not positive, or not finite.
    #[error("body {body}: the mass is {mass} kg: it must be positive; remove it if the body only turns")]
    Mass {
        /// Number of the body, from 1.
        body: usize,
        /// The mass given \[kg\].
        mass: f64,
    },
    /// The number of states differs from the number of bodies.
    #[error("{states} states for {bodies} bodies; give one for each")]
    Count {
        /// Number of bodies in the system.
        bodies: usize,
        /// Number of states given.
        states: usize,
    },
    /// A number in a state is NaN or infinite.
    #[error("body {body}: a number of its state is not finite")]
    NotFinite {
        /// Number of the body, from 1.
        body: usize,
    },
    /// An attitude is not a rotation.
    #[error("body {body}: its attitude differs from a rotation by {error:.1e}: at most 1e-9 is accepted")]
    Attitude {
        /// Number of the body, from 1.
        body: usize,
        /// Largest element of `|RᵀR − I|`; 2 for a reflection.
        error: f64,
    },
    /// The step is not a positive number.
    #[error("the step is {step} s: it must be positive and finite")]
    Step {
        /// The step given \[s\].
        step: f64,
    },
    /// No Galerkin method has this degree.
    #[error("no Galerkin method has the degree {degree}: the degrees are 1 to 6")]
    Degree {
        /// The degree given.
        degree: usize,
    },
    /// The tolerance is outside its range.
    #[error("the tolerance is {tolerance:e}: it must be between 1e-14, the limit of round-off, and 0.1")]
    Tolerance {
        /// The tolerance given.
        tolerance: f64,
    },
}

/// The actuator output on one body during a step, linear in time between the ends of the step.
///
/// Held inputs have equal ends. Forces are in the reference frame, moments in body axes. Methods
/// that use the output at one end only state this.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// The output at the start of the step.
    pub start: Wrench,
    /// The output at the end of the step.
    pub end: Wrench,
}

impl Input {
    /// Builds an input with a constant wrench throughout the step.
    pub fn held(wrench: Wrench) -> Self {
        Self { start: wrench, end: wrench }
    }

    /// Returns the output at the fraction `fraction` of the step.
    pub fn at(&self, fraction: f64) -> Wrench {
        let mix = |a: &Vector3, b: &Vector3| a * (1.0 - fraction) + b * fraction;
        Wrench {
            force: mix(&self.start.force, &self.end.force),
            moment: mix(&self.start.moment, &self.end.moment),
        }
    }
}

/// Quantities that an exact motion without inputs conserves, and the deviation of the attitudes
/// from rotations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Invariants {
    /// Kinetic plus potential energy \[J\]. In a rotating frame `n · Σ(x×γ + RΠ)` is subtracted:
    /// the result is Jacobi's integral, which a field fixed in this frame conserves.
    pub energy: f64,
    /// Linear momentum `Σγ`, reference frame [N·s]. It is conserved if the potential depends only
    /// on differences of positions.
    pub linear_momentum: Vector3,
    /// Angular momentum `Σ(x×γ + RΠ)` about the origin, reference frame [N·m·s]. Its component
    /// along an axis of symmetry of the potential is conserved.
    pub angular_momentum: Vector3,
    /// Largest `‖I − RᵀR‖` (Frobenius norm) over all bodies.
    pub orthogonality: f64,
}

impl System {
    /// Builds a system of bodies under a potential; `None` for free bodies.
    ///
    /// # Errors
    /// [`SystemError::Empty`] without bodies, or [`SystemError::Mass`] for an invalid mass.
    pub fn new(bodies: Vec<Body>, potential: Option<Arc<dyn Potential>>) -> Result<Self, SystemError> {
        if bodies.is_empty() {
            return Err(SystemError::Empty);
        }
        for (index, body) in bodies.iter().enumerate() {
            if let Some(mass) = body.mass.filter(|mass| !(*mass > 0.0 && mass.is_finite())) {
                return Err(SystemError::Mass { body: index + 1, mass });
            }
        }
        Ok(Self { bodies, potential, frame_rate: Vector3::zeros() })
    }

    /// Builds a system of one body in an environment, whose frame may rotate. A body with a mass
    /// also translates.
    ///
    /// # Errors
    /// [`SystemError::Mass`] for an invalid mass.
    pub fn single(body: Body, environment: Arc<dyn Environment>) -> Result<Self, SystemError> {
        let frame_rate = environment.frame_rate();
        let potential = (!environment.is_free())
            .then(|| Arc::new(EnvironmentPotential { environment }) as Arc<dyn Potential>);
        Self::turning(vec![body], potential, frame_rate)
    }

    /// Builds a system of bodies under a potential in a rotating reference frame.
    pub(crate) fn turning(
        bodies: Vec<Body>,
        potential: Option<Arc<dyn Potential>>,
        frame_rate: Vector3,
    ) -> Result<Self, SystemError> {
        Ok(Self { frame_rate, ..Self::new(bodies, potential)? })
    }

    /// Sets the angular velocity of the reference frame, in its own axes [rad/s]. The potential is
    /// fixed in this frame, and states are relative to it.
    #[must_use]
    pub fn with_frame_rate(self, frame_rate: Vector3) -> Self {
        Self { frame_rate, ..self }
    }

    /// Returns the bodies of the system.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the potential; `None` for free bodies.
    pub fn potential(&self) -> Option<&dyn Potential> {
        self.potential.as_deref()
    }

    /// Returns the angular velocity of the reference frame in its own axes [rad/s]; zero for an
    /// inertial frame.
    pub fn frame_rate(&self) -> Vector3 {
        self.frame_rate
    }

    /// Builds the state of all bodies from the position, velocity, attitude and angular velocity of
    /// each body.
    ///
    /// # Errors
    /// [`SystemError::Count`], [`SystemError::NotFinite`], or [`SystemError::Attitude`] if an
    /// attitude is not a rotation.
    pub fn state(&self, states: &[State]) -> Result<SystemState, SystemError> {
        if states.len() != self.bodies.len() {
            return Err(SystemError::Count { bodies: self.bodies.len(), states: states.len() });
        }
        let mut poses = Vec::with_capacity(states.len());
        let mut momenta = Vec::with_capacity(states.len());
        for (body, state) in self.bodies.iter().zip(states) {
            let State { position, velocity, attitude, angular_velocity } = *state;
            poses.push(Pose { position, attitude });
            momenta.push(Momentum {
                linear: velocity * body.mass.unwrap_or(0.0),
                angular: body.inertia.j() * angular_velocity,
            });
        }
        let state = SystemState::new(poses, momenta);
        self.check(&state)?;
        Ok(state)
    }

    /// Checks that `state` fits this system: the number of bodies, finite numbers, and rotations.
    ///
    /// # Errors
    /// [`SystemError::Count`], [`SystemError::NotFinite`], or [`SystemError::Attitude`] if an
    /// attitude is not a rotation.
    pub fn check(&self, state: &SystemState) -> Result<(), SystemError> {
        let (bodies, states) = (self.bodies.len(), state.poses().len());
        if states != bodies || state.momenta().len() != bodies {
            return Err(SystemError::Count { bodies, states });
        }
        for (index, (pose, momentum)) in state.poses().iter().zip(state.momenta()).enumerate() {
            let body = index + 1;
            let vectors = [&pose.position, &momentum.linear, &momentum.angular];
            if !vectors.into_iter().flatten().chain(pose.attitude.iter()).all(|value| value.is_finite()) {
                return Err(SystemError::NotFinite { body });
            }
            let error = Rotation::from(pose.attitude).defect();
            if error > 1e-9 {
                return Err(SystemError::Attitude { body, error });
            }
        }
        Ok(())
    }

    /// Returns the symmetry of the potential, which determines the conserved momenta.
    pub fn symmetry(&self) -> Symmetry {
        self.potential.as_ref().map_or(Symmetry::All, |potential| potential.symmetry())
    }

    /// Returns the energy, momenta and orthogonality error of a state.
    pub fn invariants(&self, state: &SystemState) -> Invariants {
        let (poses, momenta) = (state.poses(), state.momenta());
        let potential = self.potential.as_ref().map_or(0.0, |potential| potential.energy(poses));
        let angular_momentum = invariants::angular_momentum(poses, momenta);
        let kinetic = invariants::kinetic_energy(&self.bodies, momenta);
        let mut worst = 0.0_f64;
        for error in poses.iter().map(|pose| lie::orthogonality(&pose.attitude)) {
            // A NaN value stays in this comparison.
            worst = if error <= worst { worst } else { error };
        }
        Invariants {
            energy: kinetic + potential - self.frame_rate.dot(&angular_momentum),
            linear_momentum: invariants::linear_momentum(momenta),
            angular_momentum,
            orthogonality: worst,
        }
    }
}

/// Adapts an environment to the potential of a system with one body.
#[derive(Clone, Debug)]
struct EnvironmentPotential {
    environment: Arc<dyn Environment>,
}

impl Potential for EnvironmentPotential {
    fn energy(&self, poses: &[Pose]) -> f64 {
        self.environment.potential(&poses[0])
    }

    fn wrenches(&self, poses: &[Pose], wrenches: &mut [Wrench]) {
        wrenches[0] = self.environment.wrench(&poses[0]);
    }

    fn gradient(&self, poses: &[Pose], gradient: &mut [Blocks]) -> bool {
        gradient[0] = self.environment.gradient(&poses[0]);
        true
    }

    fn symmetry(&self) -> Symmetry {
        self.environment.symmetry()
    }
}

/// The loads on all bodies within a step, with a count of the evaluations.
///
/// Within a step the methods use fixed inertial axes, which coincide with the axes of the reference
/// frame at the start of the step. The potential is fixed in the reference frame. Poses are
/// therefore transformed to the rotated frame, and the resulting forces back.
#[derive(Clone, Debug)]
pub(crate) struct Loads {
    pub system: System,
    pub step: f64,
    /// Number of evaluations of the potential so far.
    pub evaluations: u64,
    turned: Vec<Pose>,
}

impl Loads {
    pub fn new(system: &System, step: f64) -> Self {
        let turns = system.frame_rate != Vector3::zeros();
        let still = Pose { position: Vector3::zeros(), attitude: Matrix3::identity() };
        let turned = if turns { vec![still; system.bodies.len()] } else { Vec::new() };
        Self { system: system.clone(), step, evaluations: 0, turned }
    }

    /// Returns whether all bodies are free: no potential and no inputs.
    pub fn is_free(&self, inputs: &[Input]) -> bool {
        self.system.potential.is_none() && inputs.is_empty()
    }

    /// Returns the rotation vector that transforms all quantities to the axes of the frame at the
    /// end of a step; `None` if the frame is inertial.
    pub fn frame_turn(&self) -> Option<Vector3> {
        (!self.turned.is_empty()).then(|| self.system.frame_rate * -self.step)
    }

    /// Evaluates the wrenches of the potential at a node.
    pub fn field(&mut self, poses: &[Pose], wrenches: &mut [Wrench]) {
        let Some(potential) = &self.system.potential else {
            wrenches.fill(Wrench::zero());
            return;
        };
        self.evaluations += 1;
        potential.wrenches(poses, wrenches);
    }

    /// Evaluates the gradient of the potential at the fraction `fraction` of the step, as n×n
    /// blocks. Poses and forces are in the axes that [`Self::total`] uses.
    ///
    /// # Panics
    /// Panics if the system has no potential, or if the potential does not provide its gradient.
    pub fn gradient(&mut self, fraction: f64, poses: &[Pose], gradient: &mut [Blocks]) {
        let potential = self.system.potential.clone().expect("a potential");
        let Some(turn) = self.frame_turn() else {
            assert!(potential.gradient(poses, gradient), "a potential that once gave its gradient gives it");
            return;
        };
        let frame = lie::exp(&(turn * fraction));
        self.turn_poses(&frame, poses);
        assert!(
            potential.gradient(&self.turned, gradient),
            "a potential that once gave its gradient gives it"
        );
        let turns = |body: &Body| body.mass.is_some();
        for (row, blocks) in gradient.chunks_exact_mut(poses.len()).enumerate() {
            for (block, column) in blocks.iter_mut().zip(&self.system.bodies) {
                if turns(&self.system.bodies[row]) {
                    block.xr = frame.tr_mul(&block.xr);
                    block.xx = frame.tr_mul(&block.xx);
                }
                if turns(column) {
                    block.rx *= frame;
                    block.xx *= frame;
                }
            }
        }
    }

    /// Transforms poses from the axes at the start of the step to the rotated frame.
    fn turn_poses(&mut self, frame: &Matrix3, poses: &[Pose]) {
        for ((turned, pose), body) in self.turned.iter_mut().zip(poses).zip(&self.system.bodies) {
            let position = if body.mass.is_some() { frame * pose.position } else { pose.position };
            *turned = Pose { position, attitude: frame * pose.attitude };
        }
    }

    /// Evaluates potential and inputs at the fraction `fraction` of the step. Poses and forces are
    /// in the axes at the start of the step.
    pub fn total(&mut self, fraction: f64, poses: &[Pose], inputs: &[Input], wrenches: &mut [Wrench]) {
        let Some(turn) = self.frame_turn() else {
            self.field(poses, wrenches);
            add_inputs(inputs, fraction, wrenches);
            return;
        };
        let frame = lie::exp(&(turn * fraction));
        self.turn_poses(&frame, poses);
        let turned = std::mem::take(&mut self.turned);
        self.field(&turned, wrenches);
        self.turned = turned;
        add_inputs(inputs, fraction, wrenches);
        for wrench in wrenches {
            wrench.force = frame.tr_mul(&wrench.force);
        }
    }
}

/// Adds the actuator outputs at the fraction `fraction` of the step to the wrenches.
pub(crate) fn add_inputs(inputs: &[Input], fraction: f64, wrenches: &mut [Wrench]) {
    for (wrench, input) in wrenches.iter_mut().zip(inputs) {
        let input = input.at(fraction);
        wrench.force += input.force;
        wrench.moment += input.moment;
    }
}
