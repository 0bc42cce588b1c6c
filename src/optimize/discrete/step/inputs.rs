//! The optimal inputs in the scaled dynamics: their output, their cost, and their derivative with
//! respect to the costate.

use super::{Authority, ControlLaws, Costate, Dynamics};
use crate::mechanics::actuators::AxisFrame;
use crate::mechanics::environment::{Pose, Wrench};
use crate::optimize::discrete::control_law::ControlLaw;
use crate::{Matrix3, Vector3};
use nalgebra::SMatrix;

/// Ratio of the authorities about two axes above which the cost has narrow valleys.
const STIFF: f64 = 100.0;

impl Dynamics {
    /// Computes the actuator wrench of the optimal inputs for the costate `(λ^γ, λ^Π)`, and their
    /// effort, scaled.
    ///
    /// `LIMITED` is [`Dynamics::is_limited`] as a compile-time constant.
    #[inline(always)]
    pub(super) fn inputs<const N: usize, const LIMITED: bool>(
        &self,
        pose: &Pose,
        costate: &Costate,
    ) -> (Wrench, f64) {
        if LIMITED && let Some(laws) = &self.laws {
            return self.limited_inputs::<N>(laws, pose, costate);
        }
        let wrench = self.input_wrench::<N>(pose, costate);
        let mut effort = -0.5 * costate.pi.dot(&wrench.moment);
        if N == 12 {
            effort -= 0.5 * costate.gamma.dot(&wrench.force);
        }
        (wrench, effort)
    }

    /// Returns the output of the force set and of the torque set at the optimal inputs for a
    /// costate, each in the axes of its set, scaled.
    pub(crate) fn outputs(&self, pose: &Pose, costate: &Costate) -> (Vector3, Vector3) {
        let (gamma, pi) = self.in_input_axes(pose, costate);
        let Some(laws) = &self.laws else {
            return (-(self.force.matrix * gamma), -(self.torque.matrix * pi));
        };
        (laws.force.response(&gamma).output, laws.torque.response(&pi).output)
    }

    /// Rotates the costates `(λ^γ, λ^Π)` to the axes of the inputs.
    fn in_input_axes(&self, pose: &Pose, costate: &Costate) -> (Vector3, Vector3) {
        let r = &pose.attitude;
        let force = self.force.frame.of_reference(r, &costate.gamma);
        (force, self.torque.frame.of_body(r, &costate.pi))
    }

    /// Computes [`Dynamics::inputs`] under limits.
    #[inline(never)]
    fn limited_inputs<const N: usize>(
        &self,
        laws: &ControlLaws,
        pose: &Pose,
        costate: &Costate,
    ) -> (Wrench, f64) {
        let r = &pose.attitude;
        let (gamma, pi) = self.in_input_axes(pose, costate);
        let torque = laws.torque.response(&pi);
        let moment = self.torque.frame.to_body(r, &torque.output);
        if N == 6 {
            return (Wrench { force: Vector3::zeros(), moment }, torque.cost);
        }
        let force = laws.force.response(&gamma);
        let cost = torque.cost + force.cost;
        (Wrench { force: self.force.frame.to_reference(r, &force.output), moment }, cost)
    }

    /// Returns the derivative `−∂(B u)` of the output with respect to the costate, for forces and
    /// for torques, each in the axes of its set. Without limits these are the authorities.
    pub(super) fn input_slopes(&self, pose: &Pose, costate: &Costate) -> (Matrix3, Matrix3) {
        let Some(laws) = &self.laws else { return (self.force.matrix, self.torque.matrix) };
        let (gamma, pi) = self.in_input_axes(pose, costate);
        (laws.force.slope(&gamma), laws.torque.slope(&pi))
    }

    /// Returns the largest ratio of an unlimited optimal input to its limit.
    pub(crate) fn demand(&self, pose: &Pose, costate: &Costate) -> f64 {
        self.larger(pose, costate, |law, costate| law.demand(costate))
    }

    /// Returns the optimality error of limited inputs: the larger projection residual of forces and
    /// torques.
    pub(crate) fn input_residual(&self, pose: &Pose, costate: &Costate) -> f64 {
        self.larger(pose, costate, |law, costate| law.projection_residual(costate))
    }

    /// Returns the larger of the values of `of` for the force law and the torque law; 0 without
    /// limits.
    fn larger(&self, pose: &Pose, costate: &Costate, of: impl Fn(&ControlLaw, &Vector3) -> f64) -> f64 {
        let Some(laws) = &self.laws else { return 0.0 };
        let (gamma, pi) = self.in_input_axes(pose, costate);
        of(&laws.force, &gamma).max(of(&laws.torque, &pi))
    }

    /// Computes the wrench that the optimal inputs produce without limits.
    #[inline(always)]
    fn input_wrench<const N: usize>(&self, pose: &Pose, costate: &Costate) -> Wrench {
        let r = &pose.attitude;
        let moment = -self.torque.on_body(r, &costate.pi);
        let force = if N == 6 { Vector3::zeros() } else { -self.force.on_reference(r, &costate.gamma) };
        Wrench { force, moment }
    }
}

impl Authority {
    /// Multiplies a vector in body axes by the matrix.
    #[inline(always)]
    fn on_body(&self, r: &Matrix3, vector: &Vector3) -> Vector3 {
        // One branch serves both changes of axes: this is the innermost loop of a sweep.
        match self.frame {
            AxisFrame::Body => self.matrix * vector,
            AxisFrame::Reference => r.tr_mul(&(self.matrix * (r * vector))),
        }
    }

    /// Multiplies a vector in reference axes by the matrix.
    #[inline(always)]
    fn on_reference(&self, r: &Matrix3, vector: &Vector3) -> Vector3 {
        match self.frame {
            AxisFrame::Reference => self.matrix * vector,
            AxisFrame::Body => r * (self.matrix * r.tr_mul(vector)),
        }
    }
}

/// Matrices derived from the authorities of the forces and of the torques, each in the axes of its
/// inputs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InputMatrices {
    force: Authority,
    torque: Authority,
}

impl InputMatrices {
    /// Inverts the control law: returns the costate `(λ^γ, λ^Π)` whose optimal inputs produce
    /// `wrench` at attitude `r`, as far as the axes allow. `self` must hold the inverse
    /// authorities.
    pub fn dual(&self, r: &Matrix3, wrench: &Wrench) -> (Vector3, Vector3) {
        (-self.force.on_reference(r, &wrench.force), -self.torque.on_body(r, &wrench.moment))
    }

    /// Returns `Ŵ = (B W⁻¹Bᵀ)⁻¹` at attitude `r`, in the axes of the momenta: 3×3, or 6×6 with
    /// forces before torques. `self` must hold the inverse authorities.
    pub fn weight<const D: usize>(&self, r: &Matrix3) -> SMatrix<f64, D, D> {
        let torque = match self.torque.frame {
            AxisFrame::Body => self.torque.matrix,
            AxisFrame::Reference => r.tr_mul(&(self.torque.matrix * r)),
        };
        let mut out = SMatrix::<f64, D, D>::zeros();
        out.view_mut((D - 3, D - 3), (3, 3)).copy_from(&torque);
        if D == 6 {
            let force = match self.force.frame {
                AxisFrame::Reference => self.force.matrix,
                AxisFrame::Body => r * self.force.matrix * r.transpose(),
            };
            out.view_mut((0, 0), (3, 3)).copy_from(&force);
        }
        out
    }

    /// Returns the traces of the matrices of forces and of torques.
    pub fn traces(&self) -> (f64, f64) {
        (self.force.matrix.trace(), self.torque.matrix.trace())
    }

    /// Returns the blocks of `G` for forces and torques at attitude `r`. `self` must hold the roots
    /// of the authorities.
    pub fn at(&self, r: &Matrix3) -> [Matrix3; 2] {
        let force = self.force.frame.to_reference(r, &self.force.matrix);
        [force, self.torque.frame.to_body(r, &self.torque.matrix)]
    }
}

impl Dynamics {
    /// Returns dynamics without limits and with additional authority about every axis: `ε` times
    /// the mean authority of the inputs. The minimum cost then bounds the true cost of the same
    /// branch from below.
    pub(crate) fn widened(&self, epsilon: f64) -> Self {
        let wider = |authority: &Authority| {
            let mean = authority.matrix.trace() / 3.0;
            let matrix = authority.matrix + Matrix3::from_diagonal_element(epsilon * mean);
            Authority { matrix, frame: authority.frame }
        };
        Self { torque: wider(&self.torque), force: wider(&self.force), laws: None, ..self.clone() }
    }

    /// Returns whether inputs exist about every axis, and along every axis if the body translates.
    pub(crate) fn has_all_axes(&self) -> bool {
        self.weight_condition() < 1e9
    }

    /// Returns whether the costs of inputs about different axes differ so much that the cost has
    /// narrow valleys.
    pub(crate) fn is_stiff(&self) -> bool {
        self.weight_condition() > STIFF
    }

    /// Returns whether inputs act about every axis with authorities of similar size.
    pub(crate) fn is_even(&self) -> bool {
        self.has_all_axes() && !self.is_stiff()
    }

    /// Returns the largest ratio of the principal authorities, of the forces or of the torques.
    pub(crate) fn weight_condition(&self) -> f64 {
        let condition = |authority: &Authority| {
            let values = authority.matrix.symmetric_eigenvalues();
            if values.max() > 0.0 { values.max() / values.min().max(0.0) } else { 1.0 }
        };
        condition(&self.torque).max(condition(&self.force))
    }

    /// Returns whether the inputs couple translation and rotation, as forces fixed in the body do.
    pub(crate) fn is_coupled(&self) -> bool {
        self.force.frame == AxisFrame::Body
    }

    /// Returns `G` with `G Gᵀ = B W⁻¹ Bᵀ`: the square root of the inputs' authority.
    pub(crate) fn input_root(&self) -> InputMatrices {
        self.of_authorities(|authority| {
            // A symmetric positive semidefinite matrix U Σ Vᵀ has U = V on its range.
            let svd = authority.svd(true, false);
            let roots = svd.singular_values.map(f64::sqrt);
            svd.u.unwrap_or_else(Matrix3::zeros) * Matrix3::from_diagonal(&roots)
        })
    }

    /// Returns the least-squares inverse of the inputs' authority.
    pub(crate) fn inverse_authority(&self) -> InputMatrices {
        self.of_authorities(|authority| {
            let svd = authority.svd(true, true);
            let threshold = 1e-9 * svd.singular_values.amax();
            svd.pseudo_inverse(threshold).unwrap_or_else(|_| Matrix3::zeros())
        })
    }

    fn of_authorities(&self, of: impl Fn(&Matrix3) -> Matrix3) -> InputMatrices {
        let of = |authority: &Authority| Authority { matrix: of(&authority.matrix), ..*authority };
        InputMatrices { force: of(&self.force), torque: of(&self.torque) }
    }
}
