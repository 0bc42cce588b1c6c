//! The 3D pendulum: a body on a fixed pivot in a uniform field.
//!
//! The moment follows (3.21), and `M_R` is the block of (4.14). `N(p)` is the derivative of
//! `M_Rᵀ p`.
//! ```text
//! G = Rᵀd     U = −m g d·Rρ     M = m g ρ × G
//! M_R = m g S(ρ) S(G)           N(p) = −m g S(ρ×p) S(G)
//! ```

use super::error::direction;
use super::{Blocks, Description, Environment, EnvironmentError, Pose, Symmetry, Wrench};
use crate::Vector3;
use crate::lie::hat;
use crate::mechanics::number::{finite_vector, not_negative, positive};

/// Uniform gravity on a body that turns about a fixed pivot: the 3D pendulum.
///
/// The inertia of the body must be the inertia about the pivot.
#[derive(Clone, Debug, PartialEq)]
pub struct UniformGravity {
    /// Unit vector `d` of the direction of gravity, reference frame.
    direction: Vector3,
    /// Weight times arm, `m g ρ`, body axes [N·m].
    weight_arm: Vector3,
    /// The arguments of the constructor.
    description: Description,
}

impl UniformGravity {
    /// Builds the field of the acceleration `gravity` [m/s²] along `direction_of_fall` (reference
    /// frame, any length) on a body of `mass` \[kg\]. `pivot_to_mass_center` is the arm ρ, body
    /// axes \[m\].
    ///
    /// # Errors
    /// Returns an [`EnvironmentError`] that names a number that is not finite, a mass that is not
    /// positive, a negative gravity, or a direction of length zero.
    pub fn new(
        mass: f64,
        gravity: f64,
        direction_of_fall: Vector3,
        pivot_to_mass_center: Vector3,
    ) -> Result<Self, EnvironmentError> {
        let weight = positive("mass", mass)? * not_negative("gravity", gravity)?;
        let arm = finite_vector("pivot to mass center", pivot_to_mass_center)?;
        Ok(Self {
            direction: direction("direction of gravity", direction_of_fall)?,
            weight_arm: finite_vector("mass times gravity times arm", weight * arm)?,
            description: Description::UniformGravity {
                mass,
                gravity,
                direction: direction_of_fall,
                pivot_to_mass_center,
            },
        })
    }

    /// Returns `G = Rᵀd`, the direction of gravity in body axes.
    fn direction_in_body(&self, pose: &Pose) -> Vector3 {
        pose.attitude.tr_mul(&self.direction)
    }
}

impl Environment for UniformGravity {
    fn potential(&self, pose: &Pose) -> f64 {
        -self.weight_arm.dot(&self.direction_in_body(pose))
    }

    fn wrench(&self, pose: &Pose) -> Wrench {
        Wrench { moment: self.weight_arm.cross(&self.direction_in_body(pose)), ..Wrench::zero() }
    }

    fn gradient(&self, pose: &Pose) -> Blocks {
        let g = self.direction_in_body(pose);
        Blocks { rr: hat(&self.weight_arm) * hat(&g), ..Blocks::zero() }
    }

    fn curvature(&self, pose: &Pose, costates: &Wrench) -> Blocks {
        let g = self.direction_in_body(pose);
        Blocks { rr: hat(&costates.moment.cross(&self.weight_arm)) * hat(&g), ..Blocks::zero() }
    }

    /// Returns the bound `m g |ρ|` on the moment `|m g ρ × G|`.
    fn moment_bound(&self) -> Option<f64> {
        Some(self.weight_arm.norm())
    }

    fn is_free(&self) -> bool {
        self.weight_arm == Vector3::zeros()
    }

    fn symmetry(&self) -> Symmetry {
        if self.is_free() { Symmetry::All } else { Symmetry::About(self.direction) }
    }

    fn describe(&self) -> Description {
        self.description.clone()
    }
}
