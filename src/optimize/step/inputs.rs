//! The optimal inputs in the scaled dynamics: what they exert, what they cost, how they answer a costate.

use super::{Authority, ControlLaws, Costate, Dynamics};
use crate::mechanics::actuators::AxisFrame;
use crate::mechanics::environment::{Pose, Wrench};
use crate::optimize::control_law::{ControlLaw, Response};
use crate::{Matrix3, Vector3};

impl Dynamics {
    /// Actuator wrench at the optimal inputs for the costate `(λ^γ, λ^Π)`, and their effort, scaled.
    ///
    /// `LIMITED` is [`Dynamics::is_limited`], known to the compiler.
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

    /// The costates `(λ^γ, λ^Π)` in the axes of the inputs.
    fn in_input_axes(&self, pose: &Pose, costate: &Costate) -> (Vector3, Vector3) {
        let r = &pose.attitude;
        let force = match self.force.frame {
            AxisFrame::Reference => costate.gamma,
            AxisFrame::Body => r.tr_mul(&costate.gamma),
        };
        let torque = match self.torque.frame {
            AxisFrame::Body => costate.pi,
            AxisFrame::Reference => r * costate.pi,
        };
        (force, torque)
    }

    /// [`Dynamics::inputs`] under limits.
    #[inline(never)]
    fn limited_inputs<const N: usize>(
        &self,
        laws: &ControlLaws,
        pose: &Pose,
        costate: &Costate,
    ) -> (Wrench, f64) {
        let r = &pose.attitude;
        let respond = |law: &Option<ControlLaw>, authority: &Authority, costate: &Vector3| match law {
            Some(law) => law.response(costate),
            None => {
                let output = -(authority.matrix * costate);
                Response { output, effort: -0.5 * costate.dot(&output) }
            }
        };
        let (gamma, pi) = self.in_input_axes(pose, costate);
        let torque = respond(&laws.torque, &self.torque, &pi);
        let moment = match self.torque.frame {
            AxisFrame::Body => torque.output,
            AxisFrame::Reference => r.tr_mul(&torque.output),
        };
        if N == 6 {
            return (Wrench { force: Vector3::zeros(), moment }, torque.effort);
        }
        let force = respond(&laws.force, &self.force, &gamma);
        let effort = torque.effort + force.effort;
        let force = match self.force.frame {
            AxisFrame::Reference => force.output,
            AxisFrame::Body => r * force.output,
        };
        (Wrench { force, moment }, effort)
    }

    /// What the inputs answer to a change of the costate, in their own axes: `−∂(B u)` for forces and
    /// torques. Without limits the authorities.
    pub(super) fn input_slopes(&self, pose: &Pose, costate: &Costate) -> (Matrix3, Matrix3) {
        let Some(laws) = &self.laws else { return (self.force.matrix, self.torque.matrix) };
        let (gamma, pi) = self.in_input_axes(pose, costate);
        let slope = |law: &Option<ControlLaw>, authority: &Authority, costate: &Vector3| {
            law.as_ref().map_or(authority.matrix, |law| law.slope(costate))
        };
        (slope(&laws.force, &self.force, &gamma), slope(&laws.torque, &self.torque, &pi))
    }

    /// How many times its limit the most demanded input would be without it.
    pub(crate) fn demand(&self, pose: &Pose, costate: &Costate) -> f64 {
        let Some(laws) = &self.laws else { return 0.0 };
        let (gamma, pi) = self.in_input_axes(pose, costate);
        let demand =
            |law: &Option<ControlLaw>, costate: &Vector3| law.as_ref().map_or(0.0, |law| law.demand(costate));
        demand(&laws.force, &gamma).max(demand(&laws.torque, &pi))
    }

    /// How far limited inputs are from optimal: the larger projection residual of the two channels.
    pub(crate) fn input_residual(&self, pose: &Pose, costate: &Costate) -> f64 {
        let Some(laws) = &self.laws else { return 0.0 };
        let (gamma, pi) = self.in_input_axes(pose, costate);
        let residual = |law: &Option<ControlLaw>, costate: &Vector3| {
            law.as_ref().map_or(0.0, |law| law.projection_residual(costate))
        };
        residual(&laws.force, &gamma).max(residual(&laws.torque, &pi))
    }

    /// Actuator wrench at the optimal inputs without limits.
    fn input_wrench<const N: usize>(&self, pose: &Pose, costate: &Costate) -> Wrench {
        let r = &pose.attitude;
        let moment = match self.torque.frame {
            AxisFrame::Body => -(self.torque.matrix * costate.pi),
            AxisFrame::Reference => -r.tr_mul(&(self.torque.matrix * (r * costate.pi))),
        };
        let force = match self.force.frame {
            _ if N == 6 => Vector3::zeros(),
            AxisFrame::Reference => -(self.force.matrix * costate.gamma),
            AxisFrame::Body => -(r * (self.force.matrix * r.tr_mul(&costate.gamma))),
        };
        Wrench { force, moment }
    }
}

/// The least-squares inverse of both authorities: which costates call for a given wrench.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InverseAuthority {
    force: Authority,
    torque: Authority,
}

impl InverseAuthority {
    /// `(λ^γ, λ^Π)` whose optimal inputs give `wrench` at attitude `r`, as far as the axes reach.
    pub fn dual(&self, r: &Matrix3, wrench: &Wrench) -> (Vector3, Vector3) {
        let force = match self.force.frame {
            AxisFrame::Reference => self.force.matrix * wrench.force,
            AxisFrame::Body => r * (self.force.matrix * r.tr_mul(&wrench.force)),
        };
        let torque = match self.torque.frame {
            AxisFrame::Body => self.torque.matrix * wrench.moment,
            AxisFrame::Reference => r.tr_mul(&(self.torque.matrix * (r * wrench.moment))),
        };
        (-force, -torque)
    }
}

/// `G` with `G Gᵀ = B W⁻¹ Bᵀ`, for torques and forces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InputRoot {
    force: Authority,
    torque: Authority,
}

impl InputRoot {
    /// `G` at attitude `r`, N×N with the blocks of the momenta filled.
    pub fn at<const N: usize>(&self, r: &Matrix3) -> nalgebra::SMatrix<f64, N, N> {
        let mut out = nalgebra::SMatrix::<f64, N, N>::zeros();
        let torque = match self.torque.frame {
            AxisFrame::Body => self.torque.matrix,
            AxisFrame::Reference => r.tr_mul(&self.torque.matrix),
        };
        out.view_mut((N - 3, N - 3), (3, 3)).copy_from(&torque);
        if N == 12 {
            let force = match self.force.frame {
                AxisFrame::Reference => self.force.matrix,
                AxisFrame::Body => r * self.force.matrix,
            };
            out.view_mut((3, 3), (3, 3)).copy_from(&force);
        }
        out
    }
}

impl Dynamics {
    /// The square root of the inputs' authority.
    pub(crate) fn input_root(&self) -> InputRoot {
        let root = |authority: &Authority| {
            // For a symmetric positive semidefinite matrix U Σ Vᵀ has U = V on its range.
            let svd = authority.matrix.svd(true, false);
            let roots = svd.singular_values.map(f64::sqrt);
            let u = svd.u.unwrap_or_else(Matrix3::zeros);
            Authority { matrix: u * Matrix3::from_diagonal(&roots), frame: authority.frame }
        };
        InputRoot { force: root(&self.force), torque: root(&self.torque) }
    }

    /// The least-squares inverse of the inputs' authority.
    pub(crate) fn inverse_authority(&self) -> InverseAuthority {
        let invert = |authority: &Authority| {
            let svd = authority.matrix.svd(true, true);
            let threshold = 1e-9 * svd.singular_values.amax();
            let matrix = svd.pseudo_inverse(threshold).unwrap_or_else(|_| Matrix3::zeros());
            Authority { matrix, frame: authority.frame }
        };
        InverseAuthority { force: invert(&self.force), torque: invert(&self.torque) }
    }
}
