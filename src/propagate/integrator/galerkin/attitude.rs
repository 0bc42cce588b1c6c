//! The stage equations of the attitude of one body, and their exact Jacobian.
//!
//! ```text
//! g_ν = ∂L_d/∂ξ_ν = h Σ b_i [ l'_ν(c_i) ∂T/∂v + l_ν(c_i) (∂T/∂ξ + J_r(ξ_i)ᵀ M_i) ]
//! P   = Π_0 + h Σ b_i exp S(ξ_i) M_i
//!
//! 0 = −g_ν  (ν < s)        0 = J_r(ξ_s) P − g_s                    then Π_1 = exp S(ξ_s)ᵀ P
//! ```
//! The last equation is the printed `J_r⁻¹ g_s − h Σ b_i exp S(ξ_i) M_i = Π_0` without its inverse.
//! Because `J_l⁻¹ = exp S(ξ)ᵀ J_r⁻¹`, the momentum at the end does not need `g_s`: it is the sum of
//! the old momentum and the impulses, rotated. The momentum balance is therefore exact to
//! round-off, whatever error the iteration leaves.

use super::convergence::relative;
use super::kinetic::Chart;
use super::linear::Dense;
use super::scheme::Scheme;
use crate::lie::hat;
use crate::{Matrix3, Vector3};
use std::f64::consts::PI;

/// The curve of one body's attitude over a step.
#[derive(Clone, Debug)]
pub(super) struct Arc {
    /// Control values `ξ_1 … ξ_s` of the curve.
    pub xi: Vec<Vector3>,
    /// The natural chart at each quadrature point.
    pub charts: Vec<Chart>,
    /// Impulse `h Σ b_i exp S(ξ_i) M_i` from the last evaluation of the equations.
    pub impulse: Vector3,
    /// Contributions of the quadrature points to the Jacobian.
    hessians: Vec<Hessian>,
}

/// Second derivatives of the action at a quadrature point, times its weight.
#[derive(Clone, Copy, Debug)]
struct Hessian {
    vv: Matrix3,
    v_xi: Matrix3,
    xi_xi: Matrix3,
    /// The negative derivative of `J_r(ξ_s) exp S(ξ) M` with respect to ξ, which enters only the
    /// last row.
    carried: Matrix3,
    /// For the current row of the Jacobian, derivatives with respect to the slope and to the value
    /// of the curve at the quadrature point.
    of_row: [Matrix3; 2],
}

/// The data of a body at the start of a step.
pub(super) struct Start {
    /// Inertia of the body.
    pub j: Matrix3,
    /// Length of the step.
    pub h: f64,
    /// Momentum `Π_0` at the start of the step.
    pub momentum: Vector3,
}

impl Arc {
    pub fn new(scheme: &Scheme) -> Self {
        let zero = Matrix3::zeros();
        let hessian = Hessian { vv: zero, v_xi: zero, xi_xi: zero, carried: zero, of_row: [zero; 2] };
        Self {
            xi: vec![Vector3::zeros(); scheme.degree],
            charts: vec![Chart::at(Vector3::zeros()); scheme.points.len()],
            impulse: Vector3::zeros(),
            hessians: vec![hessian; scheme.points.len()],
        }
    }

    /// Sets an initial curve from an angular velocity [rad/s] and a constant angular acceleration
    /// [rad/s²].
    pub fn constant_acceleration(&mut self, scheme: &Scheme, h: f64, rate: &Vector3, acceleration: &Vector3) {
        for (xi, d) in self.xi.iter_mut().zip(&scheme.times) {
            let t = h * d;
            *xi = rate * t + acceleration * (0.5 * t * t);
        }
    }

    /// Sets an initial curve by extrapolating the curve of the last step.
    pub fn extrapolate(&mut self, scheme: &Scheme) {
        let back = crate::lie::exp(&-self.xi[scheme.degree - 1]);
        // The charts serve as a buffer, because they are not needed until the next evaluation, and
        // there are at least as many as unknowns.
        for (chart, row) in self.charts.iter_mut().zip(&scheme.ahead) {
            chart.xi = crate::lie::log(&(back * crate::lie::exp(&combine(row, &self.xi))));
        }
        for (xi, chart) in self.xi.iter_mut().zip(&self.charts) {
            *xi = chart.xi;
        }
    }

    /// Computes the charts at the quadrature points of the curve.
    pub fn place(&mut self, scheme: &Scheme) {
        for (chart, values) in self.charts.iter_mut().zip(&scheme.values) {
            *chart = Chart::at(combine(values, &self.xi));
        }
    }

    /// Adds a Newton correction. Returns its size relative to the curve, which is not finite if the
    /// curve has left the chart.
    pub fn correct(&mut self, correction: &[f64]) -> f64 {
        let (mut change, mut size) = (0.0, 0.0);
        for (xi, delta) in self.xi.iter_mut().zip(correction.chunks_exact(3)) {
            let delta = Vector3::from_column_slice(delta);
            *xi += delta;
            change += delta.norm_squared();
            size += xi.norm_squared();
            if xi.norm_squared() >= PI * PI {
                return f64::NAN;
            }
        }
        relative(change.sqrt(), size.sqrt())
    }

    /// Computes the right-hand sides of the equations under the moments `M_i`, and stores the
    /// impulse.
    pub fn residual(
        &mut self,
        scheme: &Scheme,
        Start { j, h, momentum }: &Start,
        moments: impl Fn(usize) -> Vector3,
        out: &mut [f64],
        mut jacobian: Option<(&mut Dense, usize)>,
    ) {
        let s = scheme.degree;
        let end = Chart::at(self.xi[s - 1]);
        out.fill(0.0);
        self.impulse = Vector3::zeros();
        for (i, chart) in self.charts.iter().enumerate() {
            let (values, slopes, weight) = (&scheme.values[i], &scheme.slopes[i], h * scheme.weights[i]);
            let kinetic = chart.kinetic(j, *h, &combine(slopes, &self.xi));
            let moment = moments(i);
            let turned = moment + chart.turn() * moment;
            self.impulse += weight * turned;
            let by_xi = kinetic.by_xi + chart.j_r.tr_mul(&moment);
            for nu in 0..s {
                let g = (kinetic.by_v * slopes[nu] + by_xi * values[nu]) * weight;
                for (out, g) in out[3 * nu..].iter_mut().zip(&g) {
                    *out -= g;
                }
            }
            if jacobian.is_none() {
                continue;
            }
            // δ(exp S(ξ) M) = −exp S(ξ) S(M) J_r δξ
            let turn = hat(&moment) * chart.j_r;
            let hessian = &mut self.hessians[i];
            hessian.vv = kinetic.vv * weight;
            hessian.v_xi = kinetic.v_xi * weight;
            hessian.xi_xi = (kinetic.xi_xi + chart.transposed_directional(&moment)) * weight;
            hessian.carried = end.j_r * (turn + chart.turn() * turn) * weight;
        }
        if let Some((matrix, offset)) = &mut jacobian {
            self.add_hessians(scheme, matrix, *offset);
        }
        let carried = momentum + self.impulse;
        for (out, value) in out[3 * (s - 1)..].iter_mut().zip(&(end.j_r * carried)) {
            *out += value;
        }
        if let Some((matrix, offset)) = jacobian {
            let last = offset + 3 * (s - 1);
            matrix.add(last, last, &-end.directional(&carried));
        }
    }

    /// Adds the contributions of the quadrature points to the Jacobian, block by block.
    fn add_hessians(&mut self, scheme: &Scheme, matrix: &mut Dense, offset: usize) {
        let (s, Scheme { slopes, values, .. }) = (scheme.degree, scheme);
        for nu in 0..s {
            for (i, hessian) in self.hessians.iter_mut().enumerate() {
                let (Hessian { vv, v_xi, xi_xi, .. }, slope, value) =
                    (*hessian, slopes[i][nu], values[i][nu]);
                hessian.of_row = [vv * slope + v_xi.transpose() * value, v_xi * slope + xi_xi * value];
            }
            for mu in 0..s {
                let (row, column) = (offset + 3 * nu, offset + 3 * mu);
                let mut sum = matrix.block(row, column);
                for (i, hessian) in self.hessians.iter().enumerate() {
                    let [by_slope, by_value] = &hessian.of_row;
                    let mut block = by_slope * slopes[i][mu] + by_value * values[i][mu];
                    if nu == s - 1 {
                        block += hessian.carried * values[i][mu];
                    }
                    sum += block;
                }
                matrix.put(row, column, &sum);
            }
        }
    }
}

/// Returns the linear combination `Σ w_ν ξ_ν`.
pub(super) fn combine(weights: &[f64], vectors: &[Vector3]) -> Vector3 {
    weights.iter().zip(vectors).map(|(weight, vector)| vector * *weight).sum()
}
