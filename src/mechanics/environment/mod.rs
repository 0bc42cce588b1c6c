//! The forces and torques on the body that its actuators do not produce.
//!
//! An environment returns force and moment at a pose, their derivatives, and the contracted second
//! derivatives that the costate sensitivities need. A new environment needs a file that implements
//! [`Environment`], and a line in the list of the derivative tests.

mod central_gravity;
mod error;
mod gravity_gradient;
mod inverse_square;
mod second_order_gravity;
mod uniform_gravity;

pub use central_gravity::{CentralGravity, PointMass};
pub use error::EnvironmentError;
pub use gravity_gradient::GravityGradient;
pub use second_order_gravity::SecondOrderGravity;
pub use uniform_gravity::UniformGravity;

use crate::lie::Rotation;
use crate::{Matrix3, Vector3};
use std::fmt::Debug;

/// The position of the mass centre and the attitude of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position `x`, reference frame \[m\]; zero if only the attitude moves.
    pub position: Vector3,
    /// Attitude `R`, body → reference.
    pub attitude: Matrix3,
}

impl Pose {
    /// Builds a pose from a position, reference frame \[m\], and an attitude: a rotation of
    /// nalgebra or a matrix.
    ///
    /// ```
    /// # use slewkit::{Pose, Vector3};
    /// let quarter_turn = nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2);
    /// let pose = Pose::new(Vector3::new(7e6, 0.0, 0.0), quarter_turn);
    /// assert!((pose.attitude * Vector3::x() - Vector3::y()).norm() < 1e-15);
    /// ```
    pub fn new(position: Vector3, attitude: impl Into<Rotation>) -> Self {
        let rotation: Rotation = attitude.into();
        Self { position, attitude: *rotation.matrix() }
    }
}

/// A force and a moment, or a pair of costates `(λ^γ, λ^Π)` that is dual to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench {
    /// Force `f = −∂U/∂x`, reference frame \[N\].
    pub force: Vector3,
    /// Moment `M`, body axes [N·m], with `dU = −f·δx − M·ζ`.
    pub moment: Vector3,
}

impl Wrench {
    /// Returns a wrench of zero force and zero moment.
    pub fn zero() -> Self {
        Self { force: Vector3::zeros(), moment: Vector3::zeros() }
    }
}

/// A linear map from a displacement `(δx, ζ)` to a pair (translation, rotation), in 3×3 blocks.
///
/// If the map is a gradient, then `δf = xx δx + xr ζ` and `δM = rx δx + rr ζ` (4.13–4.14).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocks {
    /// Translation part per translation (`F_x` in a gradient).
    pub xx: Matrix3,
    /// Translation part per rotation (`F_R`).
    pub xr: Matrix3,
    /// Rotation part per translation (`M_x`).
    pub rx: Matrix3,
    /// Rotation part per rotation (`M_R`).
    pub rr: Matrix3,
}

impl Blocks {
    /// Builds the zero map.
    pub fn zero() -> Self {
        Self { xx: Matrix3::zeros(), xr: Matrix3::zeros(), rx: Matrix3::zeros(), rr: Matrix3::zeros() }
    }

    /// Returns the map multiplied by `by`.
    pub(crate) fn scaled(&self, by: f64) -> Self {
        Self { xx: self.xx * by, xr: self.xr * by, rx: self.rx * by, rr: self.rr * by }
    }

    /// Converts a map with translations in body axes to one with translations in the reference
    /// frame.
    fn rotate_translations(&self, attitude: &Matrix3) -> Self {
        let transposed = attitude.transpose();
        Self {
            xx: attitude * self.xx * transposed,
            xr: attitude * self.xr,
            rx: self.rx * transposed,
            rr: self.rr,
        }
    }
}

/// The description of a field in a file: the arguments of its constructor, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Description {
    /// No field, as for [`Free`].
    Free,
    /// A field built by [`UniformGravity::new`].
    UniformGravity {
        /// Mass \[kg\].
        mass: f64,
        /// Acceleration of gravity [m/s²].
        gravity: f64,
        /// The direction of gravity, reference frame, any length.
        direction: Vector3,
        /// The vector from the pivot to the mass centre, body axes \[m\].
        pivot_to_mass_center: Vector3,
    },
    /// A field built by [`GravityGradient::new`].
    GravityGradient {
        /// Orbital rate [rad/s].
        orbital_rate: f64,
        /// Inertia about the mass centre [kg·m²], body axes.
        inertia: Matrix3,
    },
    /// A field built by [`CentralGravity::of_masses`].
    CentralGravity {
        /// Gravitational parameter μ [m³/s²].
        gravitational_parameter: f64,
        /// Mass \[kg\] and position of each point, body axes from the mass centre \[m\].
        points: Vec<(f64, Vector3)>,
    },
    /// A field built by [`SecondOrderGravity::new`].
    SecondOrderGravity {
        /// Gravitational parameter μ [m³/s²].
        gravitational_parameter: f64,
        /// Mass \[kg\].
        mass: f64,
        /// Inertia about the mass centre [kg·m²], body axes.
        inertia: Matrix3,
    },
    /// Any other field, such as a user-defined one, for which a spec has no notation.
    Custom,
}

/// The motions that leave a potential unchanged, and hence the conserved momenta.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Symmetry {
    /// No known symmetry: nothing is conserved.
    None,
    /// Rotations about this unit vector (reference frame) through the origin. They conserve the
    /// component of the angular momentum along the vector.
    About(Vector3),
    /// All rotations about the origin. They conserve the angular momentum.
    Turns,
    /// All rotations and translations. They conserve angular and linear momentum.
    All,
}

/// A potential `U(x, R)` whose field acts on the body.
///
/// With `δR = R S(ζ)`, a field provides `dU = −f·δx − M·ζ`, the derivative `Γ` of force and moment,
/// and the second derivative contracted with costates. The latter makes costates exact derivatives
/// of the cost. All values must be finite at every pose of the motion; otherwise a solve ends with
/// [`Outcome::NotFinite`](crate::Outcome::NotFinite). A wrong derivative causes slow or failing
/// convergence, and a failed verdict; compare derivatives with finite differences
/// (`examples/own_environment.rs`).
pub trait Environment: Debug + Send + Sync {
    /// Returns the potential energy `U` \[J\].
    fn potential(&self, pose: &Pose) -> f64;

    /// Returns the force `f`, reference frame \[N\], and moment `M`, body axes [N·m], at a pose.
    fn wrench(&self, pose: &Pose) -> Wrench;

    /// Returns the derivative `Γ` of force and moment with respect to `(δx, ζ)`: four 3×3 blocks
    /// [N/m, N/rad, N, N·m/rad] (4.13–4.14).
    fn gradient(&self, pose: &Pose) -> Blocks;

    /// Returns the derivative `𝒯` of `Γᵀ [λ^γ; λ^Π]` with respect to `(δx, ζ)`, for constant
    /// costates `λ`: four 3×3 blocks. Each block has the unit of `Γ` times the unit of the
    /// costates, per m or rad.
    fn curvature(&self, pose: &Pose, costates: &Wrench) -> Blocks;

    /// Returns the angular velocity of the reference frame, in its own axes [rad/s]; zero for an
    /// inertial frame. Default: zero.
    fn frame_rate(&self) -> Vector3 {
        Vector3::zeros()
    }

    /// Returns an upper bound on `|M|` over all poses [N·m]; `None` if no bound exists or is known.
    /// Default: `None`.
    ///
    /// Proofs that a maneuver is infeasible add the bound to the torque limit.
    fn moment_bound(&self) -> Option<f64> {
        None
    }

    /// Returns whether no force or moment acts, so that the solvers may omit every evaluation.
    fn is_free(&self) -> bool {
        false
    }

    /// Returns the symmetry of the field, for reports. Default: full symmetry for a free body,
    /// otherwise none.
    fn symmetry(&self) -> Symmetry {
        if self.is_free() { Symmetry::All } else { Symmetry::None }
    }

    /// Returns the description of the field for specs and plan files. Default:
    /// [`Description::Custom`].
    fn describe(&self) -> Description {
        Description::Custom
    }
}

/// The free rigid body: no field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Free;

impl Environment for Free {
    fn potential(&self, _: &Pose) -> f64 {
        0.0
    }
    fn wrench(&self, _: &Pose) -> Wrench {
        Wrench::zero()
    }
    fn gradient(&self, _: &Pose) -> Blocks {
        Blocks::zero()
    }
    fn curvature(&self, _: &Pose, _: &Wrench) -> Blocks {
        Blocks::zero()
    }
    fn moment_bound(&self) -> Option<f64> {
        Some(0.0)
    }
    fn is_free(&self) -> bool {
        true
    }
    fn describe(&self) -> Description {
        Description::Free
    }
}
