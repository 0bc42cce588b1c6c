//! The kick: environment and optimal inputs, integrated as the flow of one Hamiltonian.
//!
//! With the optimal inputs `u = −W⁻¹ Bᵀ p`, `p = (λ^γ, λ^Π)`, the kick at the new pose `q` is
//!
//! ```text
//! K(q, p) = p · (wrench(q)) − ½ pᵀ B(q) W⁻¹ B(q)ᵀ p
//! (γ, Π) += h K_p ,     (λ^x, λ^R) −= h K_q
//! ```
//!
//! `K_p` is the wrench (force and moment) plus `B u`. `K_q` is `Γᵀ p`, where `Γ = ∂wrench/∂q`, plus
//! a term due to the inputs if their axes rotate relative to the coordinates. For such inputs, let
//! `A = B₀ W⁻¹ B₀ᵀ` with the constant axes `B₀` in the frame in which they are fixed. Torques about
//! axes fixed in the reference frame, and forces along axes fixed in the body, are:
//!
//! ```text
//! torque fixed to the reference:  τ = −Rᵀ A R λ^Π            K_R = λ^Π × τ
//! force fixed to the body:        f = R φ,  φ = −A Rᵀλ^γ     K_R = φ × Rᵀλ^γ
//! ```
//!
//! Under limits the inputs' part of `K` is the minimum over the allowed inputs: `B u` is computed
//! by the saturated law, and its derivative replaces `−A` (`control_law::saturated`).
//!
//! # Why split a step into a drift and a kick?
//!
//! The drift is the free rigid body, the kick everything else: environment and inputs at the new
//! pose. The kick, lifted to the costates, is the flow of one Hamiltonian `K(q, p)`, so state and
//! costate move by its two gradients and the linearisation is its Hessian. Environment, actuators
//! fixed to the body and actuators fixed to the reference frame are three terms of one `K`. A new
//! force field or a new kind of actuator adds its own term and requires no change in the sweep, in
//! Newton's method or in the second-order test. The formulas for torques in reference axes, which
//! are long when written as a linearisation of the whole step, are short here.

use super::{Costate, Dynamics, Point, Sensitivity};
use crate::lie::hat;
use crate::mechanics::actuators::AxisFrame;
use crate::mechanics::environment::{Blocks, Pose, Wrench};
use crate::{Matrix3, Vector3};

/// Value of the kick and its gradient with respect to the pose, at one pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kick {
    /// Environment force plus actuator force.
    pub force: Vector3,
    /// Environment moment plus actuator torque.
    pub moment: Vector3,
    /// Gradient `K_x` with respect to the position.
    pub slope_x: Vector3,
    /// Gradient `K_R` with respect to the attitude.
    pub slope_r: Vector3,
    /// Running cost `½ uᵀ W u`.
    pub effort: f64,
}

/// The linearised kick: `K_pq`, `K_pp` and `K_qq` (`K_qp = K_pqᵀ`).
pub(crate) struct LinearKick {
    pp_force: Matrix3,
    pp_torque: Matrix3,
    /// `(K_pq, K_qq)`; `None` if both vanish: a free body with body-fixed torques and forces in
    /// reference axes.
    pub field: Option<(Blocks, Blocks)>,
}

impl Dynamics {
    /// Computes the kick at a pose.
    pub(crate) fn kick<const N: usize>(&self, pose: &Pose, costate: &Costate) -> Kick {
        if self.is_limited() {
            self.kick_of::<N, true>(pose, costate)
        } else {
            self.kick_of::<N, false>(pose, costate)
        }
    }

    /// Computes the kick at a pose. `LIMITED` is [`Dynamics::is_limited`] as a compile-time
    /// constant, so that a loop over all steps tests it only once.
    #[inline(always)]
    pub(crate) fn kick_of<const N: usize, const LIMITED: bool>(
        &self,
        pose: &Pose,
        costate: &Costate,
    ) -> Kick {
        let (input, effort) = self.inputs::<N, LIMITED>(pose, costate);
        let zero = Vector3::zeros();
        let mut kick =
            Kick { force: input.force, moment: input.moment, slope_x: zero, slope_r: zero, effort };
        if self.torque.frame == AxisFrame::Reference {
            kick.slope_r += costate.pi.cross(&input.moment);
        }
        if N == 12 && self.force.frame == AxisFrame::Body {
            let r = &pose.attitude;
            kick.slope_r += r.tr_mul(&input.force).cross(&r.tr_mul(&costate.gamma));
        }
        if let Some(environment) = &self.environment {
            let wrench = self.wrench(environment.as_ref(), pose);
            let gradient = self.gradient(environment.as_ref(), pose);
            kick.moment += wrench.moment;
            kick.slope_r += gradient.rr.tr_mul(&costate.pi);
            if N == 12 {
                kick.force += wrench.force;
                kick.slope_r += gradient.xr.tr_mul(&costate.gamma);
                kick.slope_x += gradient.xx.tr_mul(&costate.gamma) + gradient.rx.tr_mul(&costate.pi);
            }
        }
        kick
    }

    /// Applies the forces and torques of environment and inputs to the momenta. The gradient, which
    /// only the costate needs, is not computed.
    #[inline(always)]
    pub(crate) fn bare_kick<const N: usize>(&self, point: &mut Point, weight: f64, input: &Wrench) {
        let mut wrench = *input;
        if let Some(environment) = &self.environment {
            let field = self.wrench(environment.as_ref(), &point.pose());
            wrench.moment += field.moment;
            wrench.force += field.force;
        }
        point.momentum.add(&(wrench.moment * weight));
        if N == 12 {
            point.linear_momentum.add(&(wrench.force * weight));
        }
    }

    /// Computes the wrench of a kick under inputs that exert `input` (force in reference axes,
    /// moment in body axes), and its gradient `K_pq` at fixed inputs. The gradient is the sum of
    /// the gradient of the environment and the gradient due to input axes that rotate relative to
    /// the coordinates.
    pub(crate) fn kick_of_inputs(&self, pose: &Pose, input: &Wrench) -> (Wrench, Blocks) {
        let (mut wrench, mut gradient) = self.field(pose);
        wrench.moment += input.moment;
        wrench.force += input.force;
        if self.torque.frame == AxisFrame::Reference {
            // δ(Rᵀv) = S(Rᵀv) ζ.
            gradient.rr += hat(&input.moment);
        }
        if self.force.frame == AxisFrame::Body {
            // δ(Rφ) = −R S(φ) ζ.
            gradient.xr -= hat(&input.force) * pose.attitude;
        }
        (wrench, gradient)
    }

    /// Linearises the kick at a pose.
    pub(crate) fn linear_kick<const N: usize>(&self, pose: &Pose, costate: &Costate) -> LinearKick {
        let turning =
            self.torque.frame == AxisFrame::Reference || (N == 12 && self.force.frame == AxisFrame::Body);
        if self.environment.is_none() && !turning && !self.is_limited() {
            let (pp_force, pp_torque) = (-self.force.matrix, -self.torque.matrix);
            return LinearKick { pp_force, pp_torque, field: None };
        }
        self.field_kick::<N>(pose, costate)
    }

    /// Linearises the kick for an environment, for limited inputs, or for inputs whose axes rotate
    /// relative to the coordinates.
    #[inline(never)]
    fn field_kick<const N: usize>(&self, pose: &Pose, costate: &Costate) -> LinearKick {
        let r = &pose.attitude;
        let r_t = r.transpose();
        let (mut pq, mut qq) = (Blocks::zero(), Blocks::zero());
        let (input, _) = self.inputs::<N, true>(pose, costate);
        let (force, torque) = self.input_slopes(pose, costate);
        let (mut pp_force, mut pp_torque) = (-force, -torque);
        if let Some(environment) = &self.environment {
            pq = self.gradient(environment.as_ref(), pose);
            let costates = Wrench { force: costate.gamma, moment: costate.pi };
            qq = self.curvature(environment.as_ref(), pose, &costates);
        }
        if self.torque.frame == AxisFrame::Reference {
            // τ = Rᵀ φ(R p), δφ = −A δ(R p), a = Rᵀ A R: δτ = −a δp + (S(τ) + a S(p)) ζ.
            let a = r_t * torque * r;
            let p = &costate.pi;
            let turn = hat(&input.moment) + a * hat(p);
            pp_torque = -a;
            pq.rr += turn;
            qq.rr += hat(p) * turn;
        }
        if N == 12 && self.force.frame == AxisFrame::Body {
            // δρ = Rᵀδλ + S(ρ)ζ, δφ = −A δρ, δf = R (δφ − S(φ)ζ), δ(φ×ρ) = −S(ρ)δφ + S(φ)δρ.
            let a = &force;
            let rho = r_t * costate.gamma;
            let phi = r_t * input.force;
            pp_force = -(r * a * r_t);
            pq.xr += r * (-(a * hat(&rho)) - hat(&phi));
            qq.rr += hat(&rho) * a * hat(&rho) + hat(&phi) * hat(&rho);
        }
        LinearKick { pp_force, pp_torque, field: Some((pq, qq)) }
    }
}

impl Kick {
    /// Applies the kick: adds `weight` times force and moment to the momenta, and subtracts `h`
    /// times the gradients from the costates.
    #[inline(always)]
    pub fn apply<const N: usize>(&self, point: &mut Point, costate: &mut Costate, weight: f64, h: f64) {
        point.momentum.add(&(self.moment * weight));
        costate.zeta -= self.slope_r * h;
        if N == 12 {
            point.linear_momentum.add(&(self.force * weight));
            costate.x -= self.slope_x * h;
        }
    }
}

impl LinearKick {
    /// Applies the linearised kick to the derivatives of state and costate. The derivatives of the
    /// momenta change with the factor `weight`, those of the costates with the factor `h`.
    #[inline(always)]
    pub fn apply<const N: usize>(&self, columns: &mut Sensitivity<N>, weight: f64, h: f64) {
        columns.pi += weight * (&self.pp_torque * &columns.costate_pi);
        if N == 12 {
            columns.gamma += weight * (&self.pp_force * &columns.costate_gamma);
        }
        let Some((pq, qq)) = &self.field else { return };
        columns.pi += weight * (&pq.rr * &columns.zeta);
        columns.costate_zeta -= h * (&qq.rr * &columns.zeta);
        columns.costate_zeta -= h * (&pq.rr.transpose() * &columns.costate_pi);
        if N == 12 {
            columns.pi += weight * (&pq.rx * &columns.x);
            columns.gamma += weight * (&pq.xx * &columns.x + &pq.xr * &columns.zeta);
            columns.costate_zeta -= h * (&qq.rx * &columns.x + &pq.xr.transpose() * &columns.costate_gamma);
            columns.costate_x -= h * (&qq.xx * &columns.x + &qq.xr * &columns.zeta);
            columns.costate_x -=
                h * (&pq.xx.transpose() * &columns.costate_gamma + &pq.rx.transpose() * &columns.costate_pi);
        }
    }

    /// Computes `K_qq z` from the state part of `columns`; the result is in the costate part.
    pub fn curvature<const N: usize>(&self, columns: &Sensitivity<N>) -> Sensitivity<N> {
        let mut out = Sensitivity::zero();
        let Some((_, qq)) = &self.field else { return out };
        out.costate_zeta = &qq.rr * &columns.zeta;
        if N == 12 {
            out.costate_zeta += &qq.rx * &columns.x;
            out.costate_x = &qq.xx * &columns.x + &qq.xr * &columns.zeta;
        }
        out
    }

    /// Returns `K_pq`, with momentum rows and configuration columns, N×N.
    pub fn gradient<const N: usize>(&self) -> nalgebra::SMatrix<f64, N, N> {
        let mut out = nalgebra::SMatrix::<f64, N, N>::zeros();
        let Some((pq, _)) = &self.field else { return out };
        out.view_mut((N - 3, N - 6), (3, 3)).copy_from(&pq.rr);
        if N == 12 {
            out.view_mut((3, 0), (3, 3)).copy_from(&pq.xx);
            out.view_mut((3, N - 6), (3, 3)).copy_from(&pq.xr);
            out.view_mut((N - 3, 0), (3, 3)).copy_from(&pq.rx);
        }
        out
    }

    /// Returns `−K_pp`, the block of `Q/h`, N×N.
    pub fn authority<const N: usize>(&self) -> nalgebra::SMatrix<f64, N, N> {
        let mut out = nalgebra::SMatrix::<f64, N, N>::zeros();
        out.view_mut((N - 3, N - 3), (3, 3)).copy_from(&-self.pp_torque);
        if N == 12 {
            out.view_mut((3, 3), (3, 3)).copy_from(&-self.pp_force);
        }
        out
    }
}
