//! The full body problem: n rigid bodies on SE(3)ⁿ that act on each other.
//!
//! ```text
//! m_i ẍ_i = f_i = −∂U/∂x_i      Π̇_i = Π_i × Ω_i + M_i      δU = −Σ_i (f_i·δx_i + M_i·ζ_i)
//! ```
//!
//! Forces `f_i` are in the reference frame, moments `M_i` in the axes of body i, as in the survey's
//! section 3.

mod dumbbell;
mod error;
pub mod invariants;
mod lanes;
mod mutual_gravity;
mod point_cloud;
mod relative;
mod second_order;

pub use dumbbell::{Dumbbell, Dumbbells};
pub use error::FullBodyError;
pub use mutual_gravity::{Attractor, GRAVITATIONAL_CONSTANT, MutualGravity, Threads};
pub use point_cloud::{MassPoint, PointCloud};

use crate::environment::{Blocks, Pose, Wrench};

/// A potential `U(x_1, R_1, …, x_n, R_n)` and what it exerts on each body.
pub trait Potential: std::fmt::Debug + Send + Sync {
    /// `U` \[J\].
    fn energy(&self, poses: &[Pose]) -> f64;

    /// Force (reference frame \[N\]) and moment (body axes \[N·m\]) on each body, written over `wrenches`, which
    /// has one row per pose.
    fn wrenches(&self, poses: &[Pose], wrenches: &mut [Wrench]);

    /// Derivative of force and moment on body i with respect to `(δx, ζ)` of body j, written over
    /// `gradient[n i + j]`; false, and nothing written, where the potential does not offer it.
    ///
    /// The implicit methods converge quadratically with it, linearly without. Default: not offered.
    fn gradient(&self, _poses: &[Pose], _gradient: &mut [Blocks]) -> bool {
        false
    }
}
