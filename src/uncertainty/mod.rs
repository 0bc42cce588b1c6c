//! The uncertainty of a craft propagated along a plan: covariances of attitude and rate, in open
//! loop and in closed loop.
//!
//! The linearised Lie group flow propagates an ellipsoid `{R* exp S(ζ), Π* + δΠ : zᵀP⁻¹z ≤ 1}`
//! (Lee, Sanyal, Leok, McClamroch, *Deterministic global attitude estimation*, 2006), and
//! covariances by the same matrices. The gains enter as `G = B K`. The torque has noise of
//! intensity `S_w`. The sensors have noise of covariance `R_s`, independent at each step. The
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
//! A constant parameter error acts in every step with the same sign. Treated as independent noise,
//! its effect would be underestimated several times. `optimize::discrete::linear_plan` defines
//! `E_k` and `C_k`.
//!
//! [`Bounded`] is the set-valued version for errors that are bounded and have no known
//! distribution: an ellipsoid that contains every motion near the plan, to first order. `⊕` is the
//! Minkowski sum of sets. The ellipsoid of least trace that contains the sum is
//!
//! ```text
//! {A_1} ⊕ … ⊕ {A_n} ⊂ {P} ,     P = (Σ √tr A_i) Σ A_i/√tr A_i
//! ```
//!
//! The size of covariances of independent noise grows like √k, while the size of sets grows like k,
//! because bounded errors need not average out.

pub mod chance;
mod flow;
mod pointing;

pub use pointing::Radius;

use crate::Matrix3;
use crate::feedback::Gains;
use crate::optimize::discrete::linear_plan::{LinearPlan, Matrix6, Parameter, Vector6};
use flow::Flow;

/// The uncertainty of a craft: one standard deviation of each error source, SI units, body axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uncertainty {
    /// Covariance of the initial error `[ζ; δΩ]`, true minus planned, rad and rad/s.
    pub start: Matrix6,
    /// The uncertain parameters, constant along the plan and independent of each other: name, kind
    /// and standard deviation of each.
    pub parameters: Vec<(String, Parameter, f64)>,
    /// Intensity of the torque noise, (N·m)²·s.
    pub torque_noise: Matrix3,
    /// Covariance of the measurement noise of `[ζ; δΩ]`, rad and rad/s, independent at each step.
    pub sensor_noise: Matrix6,
}

/// Covariances of state, rate and corrections along a plan.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Covariance {
    /// Covariance of the deviation `[ζ; δΠ]` at each node, rad and N·m·s. For torques at nodes they
    /// are the momenta after a full kick.
    pub states: Vec<Matrix6>,
    /// Covariance of the physical terminal error `[ζ; δΩ]`, true minus planned, rad and rad/s.
    pub end: Matrix6,
    /// The contribution of the parameters to [`Self::end`].
    pub end_of_parameters: Matrix6,
    /// Sensitivity `∂[ζ; δΩ]/∂p` of the terminal error to the parameters: one 6-vector per
    /// parameter.
    pub end_by_parameter: Vec<Vector6>,
    /// Covariance of the physical rate error `δΩ` at each node, true minus planned, (rad/s)². For
    /// torques at nodes they are the rates after a full kick.
    pub rates: Vec<Matrix3>,
    /// Covariance of the torque correction in each step, body axes, (N·m)².
    pub torque: Vec<Matrix3>,
    /// Standard deviation of the correction of each input in each step, SI; empty in open loop.
    pub inputs: Vec<Vec<f64>>,
    /// Standard deviation of the change of each input's correction from a step to the next, SI. The
    /// list has one entry fewer than the plan has steps; it is empty in open loop.
    pub input_changes: Vec<Vec<f64>>,
}

impl Covariance {
    /// Propagates the uncertainty along a plan: in closed loop with `gains`, in open loop without.
    pub fn along(plan: &LinearPlan, gains: Option<&Gains>, uncertainty: &Uncertainty) -> Self {
        if plan.has_wheels() {
            Flow::<9>::new(plan, gains, uncertainty).carry()
        } else {
            Flow::<6>::new(plan, gains, uncertainty).carry()
        }
    }

    /// Returns the standard deviations of the terminal attitude error \[rad\] and rate error
    /// [rad/s].
    pub fn end_sigma(&self) -> Vector6 {
        // `max` would turn NaN into zero.
        self.end.diagonal().map(|variance| if variance < 0.0 { 0.0 } else { variance.sqrt() })
    }

    /// Returns the fraction that each parameter contributes to the variance of each component of
    /// the terminal error.
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
/// each source of error stays within one deviation of [`Uncertainty`]. The initial error, the
/// sensor noise and the torque noise (its mean over a step) lie in their ellipsoids, and each
/// parameter in its interval.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Bounded {
    /// Matrix P of the ellipsoid for `[ζ; δΠ]` at each node, rad and N·m·s.
    pub states: Vec<Matrix6>,
    /// Matrix P of the ellipsoid for the physical terminal error `[ζ; δΩ]`, rad and rad/s.
    pub end: Matrix6,
}

impl Bounded {
    /// Propagates the sets along a plan with held torques: in closed loop with `gains`, in open
    /// loop without.
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
