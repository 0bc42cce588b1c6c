//! Gains along a plan: what keeps a craft that is beside it on it, and brings it to the end.
//!
//! ```text
//! u = u*_k − K_k z_k ,     z = [log(R*_kᵀ R); Π − Π*_k]
//! ```
//!
//! - [`Kind::Neighbouring`]: the neighbouring extremal. Of all corrections that bring the craft to the end to first order,
//!   those of least cost: the plan's own problem, solved beside it. A backward sweep of 6×6 blocks, with `Q = B S Bᵀ/h`, `S` the
//!   authority `B W⁻¹Bᵀ` of the inputs that are not at their limits:
//!
//!   ```text
//!   Λ_{N−1} = I ,  Z_N = −K₋⁻¹ Q/2 (torques at nodes, Lie–Verlet), else 0
//!   Z_k = A_k⁻¹ (Z_{k+1} + Q_k Λ_k) ,   P_k = Λ_k Z_k⁻¹ ,   K_k = W⁻¹Bᵀ (B_kᵀ P_k)/h ,   Λ_{k−1} = A_kᵀ Λ_k + H_k Z_k
//!   ```
//!
//!   The gains grow like `4/(T − t)` and `6/(T − t)²`; the last of them would answer the noise of sensors with all the torque
//!   there is, so they are held from [`Gains::frozen_from`] on.
//! - [`Kind::Tvlqr`]: the regulator of given weights, from the Riccati recursion.
//! - [`Kind::Switching`]: the same behind a correction of the switching times at the start ([`SwitchingGains`]).
//!
//! Signs, orders and the index of every step are held by the landing law: what the corrected motion misses falls with the square
//! of what it began beside the plan (tests).

pub mod replan;
mod switching;

pub use switching::{Arc, NotCorrected, Reversed, SwitchingGains};

use crate::Matrix3;
use crate::optimize::linear_plan::{LinearPlan, LinearStep, Matrix6, Timing, Vector6, kick};
use nalgebra::{DMatrix, SMatrix};
use thiserror::Error;

/// Three by six: torques by states.
type Matrix3x6 = SMatrix<f64, 3, 6>;

/// How gains are designed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// The neighbouring extremal, held over the last part of the plan.
    Neighbouring {
        /// Part of the steps over which gains are held, [`Kind::FREEZE`] by default: what less of it gains at the end in rate, it
        /// loses in torque that answers noise.
        freeze: f64,
    },
    /// The regulator of these weights.
    Tvlqr(Option<RegulatorWeights>),
    /// Of inputs that switch: their switching times once, at the start, and then the regulator of these weights beside the motion that
    /// this leads to.
    Switching(Option<RegulatorWeights>),
}

impl Kind {
    /// Part of the steps over which neighbouring gains are held, at least four steps.
    pub const FREEZE: f64 = 0.15;
    const LEAST_FROZEN: usize = 4;
}

/// Weights of a regulator `∫ (a |ζ|² + b |δΩ|² + δuᵀW δu) dt + e T (a |ζ|² + b |δΩ|²)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegulatorWeights {
    /// `a`, of the attitude error, in the unit of the cost over s·rad².
    pub attitude: f64,
    /// `b`, of the error of the rate, in the unit of the cost over s·(rad/s)².
    pub rate: f64,
    /// `e`: how many times what the whole duration weighs the end does.
    pub end: f64,
}

impl RegulatorWeights {
    /// How many times the duration the end weighs, where that is not given.
    pub const END: f64 = 1000.0;

    /// Weights under which a torque that turns the body by a radian in the duration costs what being a radian off does.
    fn of(plan: &LinearPlan) -> [Vector6; 2] {
        // In the solver's units all four are one weight: that of the torque.
        let authority = plan.steps().iter().map(|step| step.authority.trace() / 3.0).fold(0.0, f64::max);
        let running = Vector6::repeat(1.0 / authority);
        [running, running * Self::END]
    }

    /// Weights of the state, running and at the end, in the solver's units.
    fn scaled(&self, plan: &LinearPlan) -> [Matrix6; 2] {
        let units = plan.units();
        let per = units.time / units.cost;
        let inverse = plan.momentum_of_rate().try_inverse().unwrap_or_else(Matrix3::identity);
        let mut running = Matrix6::identity() * (self.attitude * per);
        running.fixed_view_mut::<3, 3>(3, 3).copy_from(&(inverse.transpose() * inverse * (self.rate * per)));
        [running, running * self.end]
    }
}

/// Why there are no gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NoGains {
    /// Inputs that switch have no neighbouring extremal of continuous gains.
    #[error(
        "inputs that switch between their limits leave nothing to correct with: a neighbouring plan moves the switches"
    )]
    Switching,
    /// Wheels drive the body.
    #[error("the neighbouring extremal of wheels has their momenta as states: the regulator knows them")]
    Wheels,
    /// The inputs that are not at their limits cannot bring the craft to the end from everywhere beside the start.
    #[error(
        "the inputs that are not at their limits along the plan cannot bring every error beside its start to the end"
    )]
    Unreachable,
    /// The arcs of the plan are not those that a start moves.
    #[error("no arcs of it are moved by its start: {0}")]
    Arcs(&'static str),
    /// A number is not finite.
    #[error("a gain is not finite")]
    NotFinite,
}

/// Gains along a plan.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Gains {
    /// How they were designed.
    pub kind: Kind,
    /// When a correction acts.
    pub timing: Timing,
    /// Number of inputs m.
    pub inputs: usize,
    /// The first step whose gains are those of the step before it, held to the end; the number of steps where none are.
    pub frozen_from: usize,
    /// `K_k`, m×6 a step, row-major: SI input for each rad and N·m·s.
    pub rows: Vec<f64>,
    /// What the first input corrects, m×6, where half a kick opens the maneuver (torques at nodes, neighbouring).
    pub first: Option<Vec<f64>>,
    /// `P_k` of the cost to go, scaled, one a step; in the order of `rows`, empty for frozen steps.
    pub(crate) to_go: Vec<Matrix6>,
}

impl Gains {
    /// Designs gains along a plan.
    ///
    /// # Errors
    /// [`NoGains`]: the neighbouring extremal needs inputs that are not at their limits.
    pub fn along(plan: &LinearPlan, kind: Kind, switches: bool) -> Result<Self, NoGains> {
        let torques = match kind {
            Kind::Neighbouring { .. } if switches => return Err(NoGains::Switching),
            Kind::Neighbouring { .. } if plan.has_wheels() => return Err(NoGains::Wheels),
            Kind::Neighbouring { freeze } => Sweep::neighbouring(plan, freeze)?,
            Kind::Tvlqr(weights) | Kind::Switching(weights) => Sweep::regulator(plan, weights),
        };
        let inputs = plan.axes().ncols();
        let si = |step: &LinearStep, dual: &Matrix3x6| -> Vec<f64> {
            let gain = &step.to_inputs * DMatrix::from_column_slice(3, 6, dual.as_slice());
            (0..inputs * 6).map(|index| gain[(index / 6, index % 6)] / plan.unit(index % 6)).collect()
        };
        let mut rows = Vec::with_capacity(plan.count() * inputs * 6);
        for (k, step) in plan.steps().iter().enumerate() {
            if k < torques.frozen_from {
                rows.extend(si(step, &torques.duals[k]));
            } else {
                let before = rows.len() - inputs * 6;
                rows.extend_from_within(before..);
            }
        }
        if !rows.iter().all(|value| value.is_finite()) {
            return Err(NoGains::NotFinite);
        }
        let first = torques.first.as_ref().map(|dual| si(&plan.steps()[0], dual));
        let Sweep { frozen_from, to_go, .. } = torques;
        Ok(Self { kind, timing: plan.timing(), inputs, frozen_from, rows, first, to_go })
    }

    /// `K_k`, row-major.
    pub fn row(&self, step: usize) -> &[f64] {
        &self.rows[step * self.inputs * 6..(step + 1) * self.inputs * 6]
    }

    /// `K_k z`: what is taken from each input, for `z` in rad and N·m·s.
    pub fn correction<'a>(&'a self, step: usize, z: &'a Vector6) -> impl Iterator<Item = f64> + 'a {
        self.row(step).chunks_exact(6).map(move |row| row.iter().zip(z.iter()).map(|(k, z)| k * z).sum())
    }

    /// `B K_k`, 3×6, in the solver's units: scaled torques for a scaled `z`.
    pub(crate) fn torque(&self, plan: &LinearPlan, step: usize) -> Matrix3x6 {
        let gain = DMatrix::from_row_slice(self.inputs, 6, self.row(step));
        let si = plan.axes() * gain;
        Matrix3x6::from_fn(|row, column| si[(row, column)] * plan.unit(column) / plan.units().torque())
    }
}

/// What a backward sweep gives: `S⁻¹`-free duals `(1/h) B_kᵀ P_k` of each step.
struct Sweep {
    duals: Vec<Matrix3x6>,
    first: Option<Matrix3x6>,
    frozen_from: usize,
    to_go: Vec<Matrix6>,
}

/// Singular values of Z below this part of the largest are directions that no input reaches.
const UNREACHED: f64 = 1e-11;

impl Sweep {
    fn neighbouring(plan: &LinearPlan, freeze: f64) -> Result<Self, NoGains> {
        let count = plan.count();
        let held =
            if freeze > 0.0 { Kind::LEAST_FROZEN.max((freeze * count as f64).round() as usize) } else { 0 };
        // The gain of step N − held is the last that is designed; that of the first step always is.
        let frozen_from = (count + 1).saturating_sub(held).clamp(1, count);
        let quadratic = |step: &LinearStep| step.b * (step.authority / step.length) * step.b.transpose();
        let mut dual = Matrix6::identity();
        let mut z = Matrix6::zeros();
        let half = plan.half_kick(1);
        if half > 0.0 {
            let mut end = Matrix6::zeros();
            end.fixed_view_mut::<3, 3>(3, 3).copy_from(&(half * plan.steps()[count - 1].authority));
            let before = plan.last().try_inverse().ok_or(NoGains::NotFinite)?;
            z = -(before * end);
        }
        let mut duals = vec![Matrix3x6::zeros(); count];
        let mut to_go = vec![Matrix6::zeros(); count];
        for (k, step) in plan.steps().iter().enumerate().rev() {
            let before = step.a.try_inverse().ok_or(NoGains::NotFinite)?;
            z = before * (z + quadratic(step) * dual);
            if k < frozen_from {
                let (inverse, all) = inverse_of(&z).ok_or(NoGains::Unreachable)?;
                if k == 0 && !all {
                    return Err(NoGains::Unreachable);
                }
                let p = dual * inverse;
                duals[k] = step.b.transpose() * p / step.length;
                to_go[k] = p;
            }
            dual = step.a.transpose() * dual + step.h * z;
            let size = z.amax().max(dual.amax());
            if !(size > 0.0 && size.is_finite()) {
                return Err(NoGains::NotFinite);
            }
            z /= size;
            dual /= size;
        }
        let first = (plan.half_kick(0) > 0.0)
            .then(|| first_costate(plan, &to_go[0], 0).fixed_view::<3, 6>(3, 0).into_owned());
        Ok(Self { duals, first, frozen_from, to_go })
    }

    fn regulator(plan: &LinearPlan, weights: Option<RegulatorWeights>) -> Self {
        let [running, end] = match weights {
            Some(weights) => weights.scaled(plan),
            None => RegulatorWeights::of(plan).map(|diagonal| Matrix6::from_diagonal(&diagonal)),
        };
        let mut p = end;
        let mut duals = vec![Matrix3x6::zeros(); plan.count()];
        let mut to_go = duals.iter().map(|_| Matrix6::zeros()).collect::<Vec<_>>();
        for (k, step) in plan.steps().iter().enumerate().rev() {
            // K = (hW + B̄ᵀP B̄)⁻¹ B̄ᵀP A, by its torque: S (hI + B̄ᵀP B̄ S)⁻¹ B̄ᵀP A.
            let b_p = step.b.transpose() * p;
            let inner = Matrix3::from_diagonal_element(step.length) + b_p * step.b * step.authority;
            let dual = inner.try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN)) * b_p * step.a;
            let closed = step.a - step.b * (step.authority * dual);
            p = running * step.length + step.a.transpose() * p * closed;
            p = 0.5 * (p + p.transpose());
            duals[k] = dual;
            to_go[k] = p;
        }
        Self { duals, first: None, frozen_from: plan.count(), to_go }
    }
}

/// `∂λ_{k−1}/∂z` of a motion that begins at node `k` of a plan whose cost to go has `P_k`, scaled: 6×6, `z` physical.
///
/// ```text
/// G = A_kᵀ P_k + H_k ,     δλ_{k−1} = (I + G Q/2)⁻¹ G K₊ z ,     K₊ = [[I, 0], [w ∂M/∂R, I]] ,     Q/2 = [0, 0; 0, w S]
/// ```
///
/// with the weight `w` of the half kick that opens it, 0 where there is none. NaN where `I + G Q/2` has no inverse.
fn first_costate(plan: &LinearPlan, to_go: &Matrix6, node: usize) -> Matrix6 {
    let step = &plan.steps()[node];
    let g = step.a.transpose() * to_go + step.h;
    let weight = plan.half_kick(0);
    let mut half = Matrix6::zeros();
    let authority = plan.steps()[node.saturating_sub(1)].authority;
    half.fixed_view_mut::<3, 3>(3, 3).copy_from(&(weight * authority));
    let opened = (Matrix6::identity() + g * half).try_inverse();
    opened.unwrap_or_else(|| Matrix6::repeat(f64::NAN)) * g * kick(&(weight * plan.field_gradient(node)))
}

/// `Z⁻¹`, and whether it is that of all six numbers; else the least-squares inverse, because inputs that are at their limits, or
/// a last kick, cannot meet them all.
fn inverse_of(z: &Matrix6) -> Option<(Matrix6, bool)> {
    if !z.iter().all(|value| value.is_finite()) {
        return None;
    }
    let svd = z.svd(true, true);
    let largest = svd.singular_values.max();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    if svd.singular_values.min() >= UNREACHED * largest {
        return z.try_inverse().map(|inverse| (inverse, true));
    }
    svd.pseudo_inverse(UNREACHED * largest).ok().map(|inverse| (inverse, false))
}

#[cfg(test)]
mod tests;
