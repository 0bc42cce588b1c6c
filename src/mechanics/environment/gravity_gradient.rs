//! Gravity gradient on a circular orbit, with the outward direction `o`.
//!
//! The moment follows (3.21), and `M_R` is the block of (4.14). `N(p)` is the derivative of
//! `M_Rᵀ p`.
//! ```text
//! G = Rᵀo     U = (3/2) n² G·JG     M = 3n² G × JG     M_R = 3n² (S(G)J − S(JG)) S(G)
//! y = J(G×p) − (JG)×p               N(p) = 3n² [−S(y) + S(G)(S(p)J − J S(p))] S(G)
//! ```

use super::error::direction;
use super::{Blocks, Description, Environment, EnvironmentError, Pose, Wrench};
use crate::lie::hat;
use crate::mechanics::body::{Inertia, principal_moments};
use crate::mechanics::number::{finite, not_negative};
use crate::{Matrix3, Vector3};

/// Gravity gradient on a circular orbit.
///
/// The attitude is relative to the local frame of the orbit, LVLH: `e₁` along the velocity, `e₂`
/// along the orbit normal, `e₃` radially outward. The frame turns with the rate `n e₂`.
#[derive(Clone, Debug, PartialEq)]
pub struct GravityGradient {
    /// Unit vector `o` from the attracting centre outward, reference frame.
    outward: Vector3,
    /// Rate of the reference frame, `n e₂` [rad/s].
    frame_rate: Vector3,
    /// Stiffness `3 n² J` [N·m], body axes.
    stiffness: Matrix3,
    description: Description,
}

impl GravityGradient {
    /// Builds the field on a body of `inertia` about its mass centre, on a circular orbit of rate
    /// `n` [rad/s]. The attitude is relative to LVLH.
    ///
    /// # Errors
    /// Returns an [`EnvironmentError`] if the rate is negative or not finite, or if `3n²J`
    /// overflows.
    pub fn new(orbital_rate: f64, inertia: &Inertia) -> Result<Self, EnvironmentError> {
        let fixed = Self::along_fixed_direction(orbital_rate, inertia, Vector3::z())?;
        let description = Description::GravityGradient { orbital_rate, inertia: *inertia.j() };
        Ok(Self { frame_rate: orbital_rate * Vector3::y(), description, ..fixed })
    }

    /// Builds the field with the fixed outward direction `outward` (reference frame, any length).
    /// The frame does not turn: an idealisation for maneuvers that are short compared with the
    /// orbit.
    ///
    /// # Errors
    /// Returns the errors of [`GravityGradient::new`], and an error if `outward` is the zero
    /// vector.
    pub fn along_fixed_direction(
        orbital_rate: f64,
        inertia: &Inertia,
        outward: Vector3,
    ) -> Result<Self, EnvironmentError> {
        let n = not_negative("orbital rate", orbital_rate)?;
        let stiffness = 3.0 * n * n * inertia.j();
        finite("orbital rate squared times inertia", stiffness.sum())?;
        Ok(Self {
            outward: direction("outward direction", outward)?,
            frame_rate: Vector3::zeros(),
            stiffness,
            description: Description::Custom,
        })
    }

    /// Returns the outward direction `G = Rᵀo` in body axes, and the vector `3n² JG`.
    fn outward_in_body(&self, pose: &Pose) -> (Vector3, Vector3) {
        let g = pose.attitude.tr_mul(&self.outward);
        (g, self.stiffness * g)
    }
}

impl Environment for GravityGradient {
    fn potential(&self, pose: &Pose) -> f64 {
        let (g, kg) = self.outward_in_body(pose);
        0.5 * g.dot(&kg)
    }

    fn wrench(&self, pose: &Pose) -> Wrench {
        let (g, kg) = self.outward_in_body(pose);
        Wrench { moment: g.cross(&kg), ..Wrench::zero() }
    }

    fn gradient(&self, pose: &Pose) -> Blocks {
        let (g, kg) = self.outward_in_body(pose);
        Blocks { rr: (hat(&g) * self.stiffness - hat(&kg)) * hat(&g), ..Blocks::zero() }
    }

    fn curvature(&self, pose: &Pose, costates: &Wrench) -> Blocks {
        let (g, kg) = self.outward_in_body(pose);
        let (k, p) = (&self.stiffness, &costates.moment);
        let y = k * g.cross(p) - kg.cross(p);
        let kp = k * hat(p);
        // S(p)J = −(J S(p))ᵀ
        Blocks { rr: -(hat(&y) + hat(&g) * (kp + kp.transpose())) * hat(&g), ..Blocks::zero() }
    }

    fn frame_rate(&self) -> Vector3 {
        self.frame_rate
    }

    /// Returns the bound `(3/2) n² (J₃ − J₁)` on the moment `|3n² G × JG|`, with the largest and
    /// the smallest principal moment of inertia.
    fn moment_bound(&self) -> Option<f64> {
        let principal = principal_moments(&self.stiffness);
        Some(0.5 * (principal[2] - principal[0]))
    }

    fn is_free(&self) -> bool {
        self.stiffness == Matrix3::zeros()
    }

    fn describe(&self) -> Description {
        self.description.clone()
    }
}
