//! The uncertainty of a craft, propagated along a plan: covariances of attitude and rate, in open
//! loop and with gains.
//!
//! The linearised Lie group flow propagates an ellipsoid `{R* exp S(ζ), Π* + δΠ : zᵀP⁻¹z ≤ 1}`
//! (Lee, Sanyal, Leok, McClamroch, *Deterministic global attitude estimation*, 2006), and
//! covariances by the same matrices. Let the gains be `G = B K`. The torque has noise of
//! intensity `S_w`, the sensors have noise of covariance `R_s`, independent at each step, and the
//! parameters `p` are constant over the steps:
//!
//! ```text
//! z_{k+1} = A_k z_k − B_k G_k (z_k + C_k p + ν_k) + E_k p + B_k η_k ,      cov η = S_w/h
//! P = P_noise + S_k Σ_p S_kᵀ ,      S_{k+1} = (A − B G) S_k + E_k − B G C_k
//! ```
//!
//! A correction that is held over several steps uses the measurement before the first of them.
//! Within such a tick
//!
//! ```text
//! z_j = Φ_j z_0 − Ψ_j (ν + C p) + w_j ,      Φ_{j+1} = A_j Φ_j − B_j G ,   Φ_0 = I ,
//! Ψ_{j+1} = A_j Ψ_j + B_j G ,   Ψ_0 = 0
//! ```
//!
//! A constant error of a parameter acts at every step with one sign. Treated as independent noise
//! it would appear several times too small. `optimize::discrete::linear_plan` defines `E_k` and
//! `C_k`.
//!
//! [`Bounded`] is the set-valued version for errors that stay within bounds and have no
//! distribution: an ellipsoid that contains every motion near the plan, to first order. Sets add
//! up as `⊕`. The ellipsoid of least trace about the sum is
//!
//! ```text
//! {A_1} ⊕ … ⊕ {A_n} ⊂ {P} ,     P = (Σ √tr A_i) Σ A_i/√tr A_i
//! ```
//!
//! Covariances of independent noise grow like √k, and sets grow like k, because bounds do not
//! average out.

pub mod chance;
mod flow;
mod pointing;

pub use pointing::Radius;

use crate::Matrix3;
use crate::feedback::Gains;
use crate::optimize::discrete::linear_plan::{LinearPlan, Matrix6, Parameter, Vector6};
use flow::Flow;

/// The uncertainty of a craft: one standard deviation each, SI units, body axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uncertainty {
    /// Covariance of the start, `[ζ; δΩ]`, rad and rad/s: true minus planned.
    pub start: Matrix6,
    /// The parameters that are constant along the plan, independent of each other: the name, the
    /// kind, and the deviation of each.
    pub parameters: Vec<(String, Parameter, f64)>,
    /// Intensity of the noise of the torque, (N·m)²·s.
    pub torque_noise: Matrix3,
    /// The covariance of the measurement noise of `[ζ; δΩ]`, independent at each step.
    pub sensor_noise: Matrix6,
}

/// Covariance along a plan.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Covariance {
    /// The covariance of `[ζ; δΠ]`, rad and N·m·s, at each node; for torques at nodes, of the
    /// momenta after a full kick.
    pub states: Vec<Matrix6>,
    /// The covariance of the physical `[ζ; δΩ]` at the end, rad and rad/s: true minus planned.
    pub end: Matrix6,
    /// The part of [`Self::end`] that the parameters cause.
    pub end_of_parameters: Matrix6,
    /// `∂[ζ; δΩ]/∂p` at the end, 6 numbers a parameter.
    pub end_by_parameter: Vec<Vector6>,
    /// The covariance of the physical `δΩ` at each node, (rad/s)²: true minus planned; for
    /// torques at nodes, of the rates after a full kick.
    pub rates: Vec<Matrix3>,
    /// The covariance of the correction of the torque, body axes, (N·m)², for each step.
    pub torque: Vec<Matrix3>,
    /// Standard deviation of the correction of each input, SI, for each step; empty open loop.
    pub inputs: Vec<Vec<f64>>,
    /// Standard deviation of the change of the correction of each input from a step to the next,
    /// SI, one fewer than steps; empty open loop.
    pub input_changes: Vec<Vec<f64>>,
}

impl Covariance {
    /// Propagates the uncertainty along a plan, with `gains` for the closed loop.
    pub fn along(plan: &LinearPlan, gains: Option<&Gains>, uncertainty: &Uncertainty) -> Self {
        if plan.has_wheels() {
            Flow::<9>::new(plan, gains, uncertainty).carry()
        } else {
            Flow::<6>::new(plan, gains, uncertainty).carry()
        }
    }

    /// Returns the standard deviations of attitude \[rad\] and rate [rad/s] at the end.
    pub fn end_sigma(&self) -> Vector6 {
        // `max` would make a zero of NaN.
        self.end.diagonal().map(|variance| if variance < 0.0 { 0.0 } else { variance.sqrt() })
    }

    /// Returns the part of the variance of each number at the end that each parameter causes.
    pub fn shares(&self, uncertainty: &Uncertainty) -> Vec<(String, Vector6)> {
        let share = |(column, (name, _, sigma)): (&Vector6, &(String, Parameter, f64))| {
            let part = Vector6::from_fn(|row, _| {
                let all = self.end[(row, row)];
                if all > 0.0 { (column[row] * sigma).powi(2) / all } else { 0.0 }
            });
            (name.clone(), part)
        };
        self.end_by_parameter.iter().zip(&uncertainty.parameters).map(share).collect()
    }
}

/// Ellipsoids `{z : zᵀP⁻¹z ≤ 1}` along a plan that contain every motion near it, to first order, if
/// each source of error is anywhere within one deviation of [`Uncertainty`]. Start and noise are
/// within their ellipsoids (noise of the torque as its mean over a step), and each parameter is in
/// its interval.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Bounded {
    /// P of `[ζ; δΠ]`, rad and N·m·s, at each node.
    pub states: Vec<Matrix6>,
    /// P of the physical `[ζ; δΩ]` at the end, rad and rad/s.
    pub end: Matrix6,
}

impl Bounded {
    /// Carries the sets along a plan whose torques are held; `gains` where the loop is closed.
    pub fn along(plan: &LinearPlan, gains: Option<&Gains>, uncertainty: &Uncertainty) -> Self {
        if plan.has_wheels() {
            Flow::<9>::new(plan, gains, uncertainty).bound()
        } else {
            Flow::<6>::new(plan, gains, uncertainty).bound()
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
