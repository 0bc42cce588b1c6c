//! MacCullagh's second-order gravity on a body of mass `m` and inertia `J`, with the attracting
//! centre at the origin.
//!
//! ```text
//! U = −μm/|x| + u(y),   y = Rᵀx = r e,   u(y) = −(μ/2r³) (tr J − 3 e·Je)
//! ```
//! The first term moves the mass centre alone. The second term depends on the position `y` of the
//! mass centre in body axes. With `δy = Rᵀδx + S(y) ζ`, the chain rule therefore gives all
//! quantities from the derivatives `a = ∇u`, `H = ∇²u`, `T = ∂(Hq)/∂y`:
//! ```text
//! f = −R a         M = y × a
//! F_x = −R H Rᵀ    F_R = R (S(a) − H S(y))    M_x = F_Rᵀ    M_R = (S(y) H − S(a)) S(y)
//! ```
//! With the costates `(λ, p)`, `b = Rᵀλ`, `q = b + y × p` (the δy of the variation (λ, p)) and
//! `w = Hq − a × p`:
//! ```text
//! Γᵀ[λ; p] = [−R w;  y × w − a × b],      δw = V δy + H S(b) ζ,   V = T + S(p) H − H S(p)
//! 𝒯_xx = −R V Rᵀ     𝒯_xr = R (S(w) − V S(y) − H S(b))     𝒯_rx = 𝒯_xrᵀ
//! 𝒯_rr = (S(y) V − S(w) + S(b) H) S(y) + (S(y) H − S(a)) S(b)
//! ```
//! The derivatives of `u`, with `j = Je`, `c = e·j`, `τ = tr J`, `σ = e·q`:
//! ```text
//! a = (3μ/2r⁴) [(τ − 5c) e + 2j]
//! H = (3μ/2r⁵) [(τ − 5c) I + 2J − 10 (j eᵀ + e jᵀ) + 5 (7c − τ) e eᵀ]
//! T = (15μ/2r⁶) [ ((7c − τ) σ − 2 j·q) I − 2σ J + (7c − τ)(q eᵀ + e qᵀ) − 2 (Jq eᵀ + e (Jq)ᵀ)
//!                − 2 (q jᵀ + j qᵀ) + 14σ (j eᵀ + e jᵀ) + (7 (τ − 9c) σ + 14 j·q) e eᵀ ]
//! ```

use super::inverse_square::{InverseSquare, symmetric};
use super::{Blocks, Description, Environment, EnvironmentError, Pose, Symmetry, Wrench};
use crate::lie::hat;
use crate::mechanics::body::Inertia;
use crate::mechanics::number::{finite, positive};
use crate::{Matrix3, Vector3};

/// Gravity of a point at the origin on an extended body, to second order in size over distance.
///
/// Relative to the exact field, the force has an error of O((l/r)³) and the moment an error of
/// O(l/r). For bodies symmetric under `ρ → −ρ` both errors are one order smaller. All values are
/// infinite at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct SecondOrderGravity {
    /// Gravitational parameter times mass, `μ m` [N·m²].
    monopole: f64,
    /// The matrix `(3/2) μ J` [N·m⁴], body axes.
    quadrupole: Matrix3,
    /// The arguments of the constructor.
    description: Description,
}

impl SecondOrderGravity {
    /// Builds the field of gravitational parameter μ [m³/s²] on a body of `mass` \[kg\] and
    /// `inertia` about its mass centre.
    ///
    /// # Errors
    /// Returns an [`EnvironmentError`] if the parameter or the mass is not a positive number, or if
    /// the product of the parameter with the mass or with the inertia overflows.
    pub fn new(gravitational_parameter: f64, mass: f64, inertia: &Inertia) -> Result<Self, EnvironmentError> {
        let mu = positive("gravitational parameter", gravitational_parameter)?;
        let monopole = finite("gravitational parameter times mass", mu * positive("mass", mass)?)?;
        let quadrupole = 1.5 * mu * inertia.j();
        finite("gravitational parameter times inertia", quadrupole.sum())?;
        let description =
            Description::SecondOrderGravity { gravitational_parameter, mass, inertia: *inertia.j() };
        Ok(Self { monopole, quadrupole, description })
    }

    fn center(&self, pose: &Pose) -> Center<'_> {
        let monopole = InverseSquare::new(self.monopole, &pose.attitude.tr_mul(&pose.position));
        let (r, e) = (monopole.r, monopole.e);
        let j = self.quadrupole * e;
        Center { jj: &self.quadrupole, tau: self.quadrupole.trace(), c: e.dot(&j), r, e, j, monopole }
    }
}

/// Quantities of the attracting centre in body axes. `J` is replaced by `(3/2) μ J` in all of them.
struct Center<'a> {
    jj: &'a Matrix3,
    tau: f64,
    r: f64,
    e: Vector3,
    j: Vector3,
    c: f64,
    monopole: InverseSquare,
}

impl Center<'_> {
    /// Returns the second-order potential `u`.
    fn potential(&self) -> f64 {
        (3.0 * self.c - self.tau) / (3.0 * self.r.powi(3))
    }

    /// Returns the gradient `a = ∇u`.
    fn slope(&self) -> Vector3 {
        ((self.tau - 5.0 * self.c) * self.e + 2.0 * self.j) / self.r.powi(4)
    }

    /// Returns the moment `y × a = (2/r³) e × Je`.
    fn moment(&self) -> Vector3 {
        2.0 * self.e.cross(&self.j) / self.r.powi(3)
    }

    /// Returns the Hessian `H = ∇²u`.
    fn hessian(&self) -> Matrix3 {
        let Self { jj, tau, r, e, j, c, .. } = self;
        ((tau - 5.0 * c) * Matrix3::identity() + 2.0 * *jj - 10.0 * symmetric(j, e)
            + 5.0 * (7.0 * c - tau) * e * e.transpose())
            / r.powi(5)
    }

    /// Returns the third derivative `T = ∂(Hq)/∂y` for a constant `q`.
    fn third(&self, q: &Vector3) -> Matrix3 {
        let Self { jj, tau, r, e, j, c, .. } = self;
        let (sigma, jq, middle) = (e.dot(q), j.dot(q), 7.0 * c - tau);
        5.0 / r.powi(6)
            * ((middle * sigma - 2.0 * jq) * Matrix3::identity() - 2.0 * sigma * *jj
                + middle * symmetric(q, e)
                - 2.0 * symmetric(&(*jj * q), e)
                - 2.0 * symmetric(q, j)
                + 14.0 * sigma * symmetric(j, e)
                + (7.0 * (tau - 9.0 * c) * sigma + 14.0 * jq) * e * e.transpose())
    }
}

impl Environment for SecondOrderGravity {
    fn potential(&self, pose: &Pose) -> f64 {
        let center = self.center(pose);
        center.monopole.potential() + center.potential()
    }

    fn wrench(&self, pose: &Pose) -> Wrench {
        let center = self.center(pose);
        Wrench { force: pose.attitude * (center.monopole.force() - center.slope()), moment: center.moment() }
    }

    fn gradient(&self, pose: &Pose) -> Blocks {
        let center = self.center(pose);
        let (a, h, y) = (hat(&center.slope()), center.hessian(), hat(&(center.r * center.e)));
        let xr = a - h * y;
        let rx = xr.transpose();
        let xx = center.monopole.gradient() - h;
        Blocks { xx, xr, rx, rr: rx * y }.rotate_translations(&pose.attitude)
    }

    fn curvature(&self, pose: &Pose, costates: &Wrench) -> Blocks {
        let center = self.center(pose);
        let (a, h, y, p) = (center.slope(), center.hessian(), center.r * center.e, &costates.moment);
        let b = pose.attitude.tr_mul(&costates.force);
        let q = b + y.cross(p);
        let w = h * q - a.cross(p);
        let hp = h * hat(p);
        // S(p)H = −(H S(p))ᵀ
        let v = center.third(&q) - hp - hp.transpose();
        let xx = center.monopole.curvature(&b) - v;
        let (a, b, w, y) = (hat(&a), hat(&b), hat(&w), hat(&y));
        let xr = w - v * y - h * b;
        let rx = xr.transpose();
        Blocks { xx, xr, rx, rr: rx * y + (y * h - a) * b }.rotate_translations(&pose.attitude)
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::Turns
    }

    fn describe(&self) -> Description {
        self.description.clone()
    }
}
