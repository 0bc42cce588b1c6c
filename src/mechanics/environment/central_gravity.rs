//! Gravity of a point at the origin on a body of point masses.
//!
//! The model is the dumbbell of the paper (3.8) with any number of points, and with one of its two
//! bodies held at the origin. For each point, in body axes, with `s = Rᵀx + ρ`:
//! ```text
//! U = −k/|s|      φ = −k s/|s|³      f = R φ      M = ρ × φ
//! K = ∂φ/∂s
//! F_x = R K Rᵀ    F_R = −R K S(ρ)    M_x = S(ρ) K Rᵀ    M_R = S(ρ) (S(φ) − K S(ρ))
//! ```
//! and with the costates `(λ, p)`, `b = p × ρ`, `c = Rᵀλ + b`,
//! `Γᵀ[λ; p] = Σ [R Kc; ρ × Kc + b × φ]`:
//! ```text
//! L = ∂(Kc)/∂s at fixed c
//! D = −L S(ρ) − K S(b)
//! 𝒯_xx = R L Rᵀ                      𝒯_xr = R D
//! 𝒯_rx = (S(ρ) L + S(b) K) Rᵀ        𝒯_rr = S(ρ) (S(Kc) + D) + S(b) (S(φ) − K S(ρ))
//! ```
//! The moment is summed over the arms `ρ`, not as `Rᵀx × Σφ`, which would lose a further factor
//! `|x|/|ρ|` of accuracy. The sum itself is still accurate only to `|x|/|ρ|` ulps. In orbit around
//! a planet, [`SecondOrderGravity`](super::SecondOrderGravity) is the better model.

use super::inverse_square::InverseSquare;
use super::{Blocks, Description, Environment, EnvironmentError, Pose, Symmetry, Wrench};
use crate::Vector3;
use crate::lie::hat;
use crate::mechanics::number::{finite, finite_vector, positive};

/// A point of a body in a central field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMass {
    /// `k = μ m` of this point: gravitational parameter of the centre times the mass of the point
    /// [N·m²].
    pub parameter: f64,
    /// Position `ρ` from the mass centre of the body, body axes \[m\].
    pub position: Vector3,
}

/// Exact gravity of a point at the origin on a rigid cloud of point masses.
///
/// The position of the pose is the position of the mass centre. Values are not finite if a point is
/// at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct CentralGravity {
    points: Vec<PointMass>,
    description: Description,
}

impl CentralGravity {
    /// Largest distance of the mass centre from the origin of the body axes, relative to the
    /// farthest point, that counts as round-off of the input.
    pub const OFF_CENTER: f64 = 1e-6;

    /// Builds the field on a body of these points.
    ///
    /// # Errors
    /// Returns an [`EnvironmentError`] if the list is empty, a position is not finite, a
    /// parameter is not a positive number, or the mass centre is not the origin of the body axes.
    pub fn new(points: Vec<PointMass>) -> Result<Self, EnvironmentError> {
        if points.is_empty() {
            return Err(EnvironmentError::NoPoints);
        }
        for point in &points {
            positive("parameter of a point mass", point.parameter)?;
            finite_vector("position of a point mass", point.position)?;
        }
        let total: f64 = points.iter().map(|point| point.parameter).sum();
        let center: Vector3 = points.iter().map(|point| point.parameter / total * point.position).sum();
        let farthest = points.iter().map(|point| point.position.amax()).fold(0.0, f64::max);
        finite("sum of the parameters of the point masses", total)?;
        if center.amax() > Self::OFF_CENTER * farthest {
            return Err(EnvironmentError::OffCenter { center: center.into() });
        }
        Ok(Self { points, description: Description::Custom })
    }

    /// Builds the field of gravitational parameter μ [m³/s²] on a body of points with these masses
    /// \[kg\] and positions (body axes, from the mass centre \[m\]).
    ///
    /// # Errors
    /// Returns the errors of [`CentralGravity::new`].
    pub fn of_masses(
        gravitational_parameter: f64,
        points: Vec<(f64, Vector3)>,
    ) -> Result<Self, EnvironmentError> {
        let point = |(mass, position): &(f64, Vector3)| PointMass {
            parameter: gravitational_parameter * mass,
            position: *position,
        };
        let field = Self::new(points.iter().map(point).collect())?;
        Ok(Self { description: Description::CentralGravity { gravitational_parameter, points }, ..field })
    }

    /// Returns the arm `ρ` of each point and its field, body axes.
    fn fields(&self, pose: &Pose) -> impl Iterator<Item = (&Vector3, InverseSquare)> {
        let y = pose.attitude.tr_mul(&pose.position);
        self.points
            .iter()
            .map(move |point| (&point.position, InverseSquare::new(point.parameter, &(y + point.position))))
    }
}

impl Environment for CentralGravity {
    fn potential(&self, pose: &Pose) -> f64 {
        self.fields(pose).map(|(_, field)| field.potential()).sum()
    }

    fn wrench(&self, pose: &Pose) -> Wrench {
        let mut sum = Wrench::zero();
        for (arm, field) in self.fields(pose) {
            let phi = field.force();
            sum.force += phi;
            sum.moment += arm.cross(&phi);
        }
        sum.force = pose.attitude * sum.force;
        sum
    }

    fn gradient(&self, pose: &Pose) -> Blocks {
        let mut sum = Blocks::zero();
        for (arm, field) in self.fields(pose) {
            let (k, rho) = (field.gradient(), hat(arm));
            let k_rho = k * rho;
            sum.xx += k;
            sum.xr -= k_rho;
            sum.rx += rho * k;
            sum.rr += rho * (hat(&field.force()) - k_rho);
        }
        sum.rotate_translations(&pose.attitude)
    }

    fn curvature(&self, pose: &Pose, costates: &Wrench) -> Blocks {
        let lambda = pose.attitude.tr_mul(&costates.force);
        let mut sum = Blocks::zero();
        for (arm, field) in self.fields(pose) {
            let b = costates.moment.cross(arm);
            let c = lambda + b;
            let (k, l) = (field.gradient(), field.curvature(&c));
            let (rho, kc, b) = (hat(arm), k * c, hat(&b));
            let d = -l * rho - k * b;
            sum.xx += l;
            sum.xr += d;
            sum.rx += rho * l + b * k;
            sum.rr += rho * (hat(&kc) + d) + b * (hat(&field.force()) - k * rho);
        }
        sum.rotate_translations(&pose.attitude)
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::Turns
    }

    fn describe(&self) -> Description {
        self.description.clone()
    }
}
