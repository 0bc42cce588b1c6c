//! The full body problem: n rigid bodies on SE(3)ⁿ that act on each other.
//!
//! ```text
//! m_i ẍ_i = f_i = −∂U/∂x_i      Π̇_i = Π_i × Ω_i + M_i      δU = −Σ_i (f_i·δx_i + M_i·ζ_i)
//! ```
//!
//! Forces `f_i` are in the reference frame and moments `M_i` in the axes of body i, as in section 3
//! of the survey by Leok (*An overview of Lie group variational integrators*).
//!
//! | potential | for | error |
//! |---|---|---|
//! | [`Dumbbells`] | spheres on rods | closed form |
//! | [`MutualGravity`] of [`Attractor::Cloud`] | any shape, as points | exact for the points |
//! | … of [`Attractor::Polyhedron`] with points or clouds | homogeneous solids | closed form |
//! | … of two [`Attractor::Polyhedron`] | homogeneous solids | `O((l/d)^{2n})`: Gauss points of one, exact field of the other |
//! | … with an [`Attractor::SecondOrder`] | small or distant bodies | force `O((l/r)³)` of itself, moment `O(l/r)` |
//!
//! Force and moment of each body derive from one energy that depends only on relative positions and
//! attitudes. Total force and total moment therefore vanish to round-off, whatever approximation of
//! the energy is used.
//!
//! ```
//! use slewkit::{Matrix3, Pose, Vector3, Wrench};
//! use slewkit::mechanics::full_body::{
//!     Attractor, HomogeneousPolyhedron, MutualGravity, Polyhedron, Potential,
//! };
//!
//! // Two octahedra of 2000 kg/m³, 3 Gauss points along each direction of a tetrahedron.
//! let solid = |size: f64| {
//!     let shape = Polyhedron::octahedron(&(size * Vector3::new(1.0, 0.8, 0.7)))?;
//!     Ok::<_, Box<dyn std::error::Error>>(Attractor::Polyhedron(HomogeneousPolyhedron::new(shape, 2000.0, 3)?))
//! };
//! let constant = slewkit::mechanics::full_body::GRAVITATIONAL_CONSTANT;
//! let gravity = MutualGravity::new(constant, vec![solid(500.0)?, solid(150.0)?])?;
//! let at = |x: f64, y: f64| Pose { position: Vector3::new(x, y, 0.0), attitude: Matrix3::identity() };
//! let mut wrenches = [Wrench::zero(); 2];
//! gravity.wrenches(&[at(0.0, 0.0), at(1200.0, 300.0)], &mut wrenches);
//! assert!((wrenches[0].force + wrenches[1].force).norm() < 1e-15 * wrenches[0].force.norm());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod attractor;
mod dumbbell;
mod error;
pub mod invariants;
mod lanes;
mod mutual_gravity;
mod pair;
mod point_cloud;
pub mod polyhedron;
pub mod relative;
mod second_order;

pub use attractor::Attractor;
pub use dumbbell::{Dumbbell, Dumbbells};
pub use error::FullBodyError;
pub use mutual_gravity::{GRAVITATIONAL_CONSTANT, MutualGravity, Threads};
pub use point_cloud::{MassPoint, PointCloud};
pub use polyhedron::{HomogeneousPolyhedron, Polyhedron};

use crate::mechanics::environment::{Blocks, Pose, Symmetry, Wrench};

/// A potential `U(x_1, R_1, …, x_n, R_n)` with its force and moment on each body.
pub trait Potential: std::fmt::Debug + Send + Sync {
    /// Returns the potential energy `U` \[J\].
    fn energy(&self, poses: &[Pose]) -> f64;

    /// Writes force (reference frame \[N\]) and moment (body axes \[N·m\]) on each body to
    /// `wrenches`, which has one row per pose.
    fn wrenches(&self, poses: &[Pose], wrenches: &mut [Wrench]);

    /// Writes the derivative of force and moment on body i with respect to `(δx, ζ)` of body j to
    /// `gradient[n i + j]`. Returns false and writes nothing if the potential does not provide it.
    ///
    /// The implicit methods converge quadratically with the gradient, and linearly without it.
    /// Default: not provided.
    fn gradient(&self, _poses: &[Pose], _gradient: &mut [Blocks]) -> bool {
        false
    }

    /// Returns whether force and moment depend on the poses. If they do not, as for inputs that are
    /// held in their own axes, the gradient is known to be zero. Default: true.
    fn depends_on_poses(&self) -> bool {
        true
    }

    /// Returns the symmetry of the potential, for reports. Default: no symmetry.
    fn symmetry(&self) -> Symmetry {
        Symmetry::None
    }
}

impl<P: Potential + ?Sized> Potential for &P {
    fn energy(&self, poses: &[Pose]) -> f64 {
        (**self).energy(poses)
    }

    fn wrenches(&self, poses: &[Pose], wrenches: &mut [Wrench]) {
        (**self).wrenches(poses, wrenches);
    }

    fn gradient(&self, poses: &[Pose], gradient: &mut [Blocks]) -> bool {
        (**self).gradient(poses, gradient)
    }

    fn depends_on_poses(&self) -> bool {
        (**self).depends_on_poses()
    }

    fn symmetry(&self) -> Symmetry {
        (**self).symmetry()
    }
}
