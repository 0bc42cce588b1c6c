//! The kinetic energy in the natural chart, with its first and second derivatives.
//!
//! ```text
//! R = R_0 exp S(ξ) ,   Ω = J_r(ξ) v/h ,   v = dξ/dτ ,   p = JΩ ,   T = ½ Ω·JΩ
//! ∂T/∂v = J_rᵀp/h          ∂T/∂ξ = Dᵀp/h           D = D(ξ, v) = ∂(J_r v)/∂ξ
//! T_vv = J_rᵀ J J_r/h²     T_vξ = (J_rᵀ J D/h + ∂(J_rᵀp)/∂ξ)/h     ∂(J_r(ξ)ᵀp)/∂ξ = −D(−ξ, p)
//! T_ξξ = (Dᵀ J D/h + ∂²(p·J_r v)/∂ξ²)/h
//! ```
//! (Section 2.2, with the corrections for the left-trivialised derivative: J_r instead of J_l, 1/h
//! in Ω, and a term in D.)

use crate::lie::{Second, hat, skew_polynomial};
use crate::{Matrix3, Vector3};

/// The natural chart at ξ: exponential, right Jacobian and its derivatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chart {
    pub xi: Vector3,
    /// Right Jacobian `J_r(ξ)`.
    pub j_r: Matrix3,
    kernels: Second,
}

/// Kinetic energy at one point of a curve: its gradient and Hessian with respect to (v, ξ).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kinetic {
    pub by_v: Vector3,
    pub by_xi: Vector3,
    pub vv: Matrix3,
    /// Mixed second derivative `∂(∂T/∂v)/∂ξ`; the other mixed block is its transpose.
    pub v_xi: Matrix3,
    pub xi_xi: Matrix3,
}

impl Chart {
    pub fn at(xi: Vector3) -> Self {
        let kernels = Second::at(xi.norm_squared());
        let j_r = Matrix3::identity() + skew_polynomial(-kernels.b, kernels.c, &xi);
        Self { xi, j_r, kernels }
    }

    /// Returns the rotation of the chart minus the identity, `exp S(ξ) − I`, with
    /// `sin t/t = 1 − t² C`.
    pub fn turn(&self) -> Matrix3 {
        let a = 1.0 - self.xi.norm_squared() * self.kernels.c;
        skew_polynomial(a, self.kernels.b, &self.xi)
    }

    /// Returns the derivative `D(ξ, v) = ∂(J_r(ξ) v)/∂ξ` of the right Jacobian times `v`.
    pub fn directional(&self, v: &Vector3) -> Matrix3 {
        self.derivative(&self.xi, v)
    }

    /// Returns the derivative `∂(J_r(ξ)ᵀ p)/∂ξ = −D(−ξ, p)` of the transposed right Jacobian times
    /// `p`.
    pub fn transposed_directional(&self, p: &Vector3) -> Matrix3 {
        -self.derivative(&-self.xi, p)
    }

    fn derivative(&self, f: &Vector3, v: &Vector3) -> Matrix3 {
        let Second { b, c, b_prime, c_prime, .. } = self.kernels;
        let fv = f.cross(v);
        let along = 2.0 * (c_prime * f.cross(&fv) - b_prime * fv - c * v);
        let mut d = b * hat(v) + along * f.transpose() + c * (f * v.transpose());
        d += Matrix3::from_diagonal_element(c * f.dot(v));
        d
    }

    /// Returns the second derivative `∂²(p·J_r(ξ)v)/∂ξ²`, where `p·J_r(ξ)v = p·v − B ξ·w + C γ`
    /// with `w = v×p` and `γ = (p·ξ)(ξ·v) − (p·v) t²`.
    fn curvature(&self, p: &Vector3, v: &Vector3) -> Matrix3 {
        let Second { b_prime, c, c_prime, b_second, c_second, .. } = self.kernels;
        let xi = &self.xi;
        let w = v.cross(p);
        let (beta, p_xi, v_xi, pv) = (xi.dot(&w), p.dot(xi), v.dot(xi), p.dot(v));
        let gamma = p_xi * v_xi - pv * xi.norm_squared();
        let slope = p * v_xi + v * p_xi - xi * (2.0 * pv);
        // Half of each symmetric sum; the transpose below completes it.
        let along =
            slope * (2.0 * c_prime) - w * (2.0 * b_prime) + xi * (2.0 * (c_second * gamma - b_second * beta));
        let half = along * xi.transpose() + c * (p * v.transpose());
        let diagonal = 2.0 * (c_prime * gamma - b_prime * beta - c * pv);
        half + half.transpose() + Matrix3::from_diagonal_element(diagonal)
    }

    /// Returns the derivatives of the kinetic energy of a body with inertia `j` and velocity
    /// `v = dξ/dτ`, for a step of length `h`.
    pub fn kinetic(&self, j: &Matrix3, h: f64, v: &Vector3) -> Kinetic {
        let p = j * (self.j_r * v) / h;
        let d = self.directional(v);
        let (j_jr, j_d) = (j * self.j_r / h, j * d / h);
        Kinetic {
            by_v: self.j_r.tr_mul(&p) / h,
            by_xi: d.tr_mul(&p) / h,
            vv: self.j_r.tr_mul(&j_jr) / h,
            v_xi: (self.j_r.tr_mul(&j_d) + self.transposed_directional(&p)) / h,
            xi_xi: (d.tr_mul(&j_d) + self.curvature(&p, v)) / h,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lie;
    use crate::testing::{Random, full_inertia};

    /// Compares every derivative with central differences of the next lower one, on both sides of
    /// the switches between series and closed forms.
    #[test]
    fn derivatives_agree_with_finite_differences() {
        let mut random = Random(5);
        let (j, h, step) = (*full_inertia().j(), 0.3, 1e-5);
        for size in [1e-3, 0.5, 1.5, 4.0] {
            let (xi, v) = (random.vector3() * size, random.vector3());
            let at = |xi: Vector3, v: Vector3| Chart::at(xi).kinetic(&j, h, &v);
            let exact = at(xi, v);
            let energy = |xi: &Vector3, v: &Vector3| {
                let rate = lie::right_jacobian(xi) * v / h;
                0.5 * rate.dot(&(j * rate))
            };
            for i in 0..3 {
                let e = Vector3::ith(i, step);
                let per = 0.5 / step;
                let slope = (energy(&xi, &(v + e)) - energy(&xi, &(v - e))) * per;
                assert!((slope - exact.by_v[i]).abs() < 1e-8, "by v: {slope} {}", exact.by_v[i]);
                let slope = (energy(&(xi + e), &v) - energy(&(xi - e), &v)) * per;
                assert!((slope - exact.by_xi[i]).abs() < 1e-8, "by ξ: {slope} {}", exact.by_xi[i]);
                let (up, down) = (at(xi, v + e), at(xi, v - e));
                assert!(((up.by_v - down.by_v) * per - exact.vv.column(i)).amax() < 1e-8);
                assert!(((up.by_xi - down.by_xi) * per - exact.v_xi.transpose().column(i)).amax() < 1e-8);
                let (up, down) = (at(xi + e, v), at(xi - e, v));
                assert!(((up.by_v - down.by_v) * per - exact.v_xi.column(i)).amax() < 1e-8);
                assert!(((up.by_xi - down.by_xi) * per - exact.xi_xi.column(i)).amax() < 1e-8);
            }
            let chart = Chart::at(xi);
            assert!((chart.turn() - lie::exp_minus_identity(&xi)).amax() < 4e-16);
            assert!((chart.j_r - lie::right_jacobian(&xi)).amax() < 4e-16);
        }
    }
}
