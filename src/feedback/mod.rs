//! Gains along a plan. They keep a craft near the plan on it, and bring it to the end.
//!
//! ```text
//! u = u*_k − K_k z_k ,     z = [log(R*_kᵀ R); Π − Π*_k]
//! ```
//!
//! - [`Kind::Neighbouring`]: the neighbouring extremal. It is the correction of least cost among
//!     all corrections that bring the craft to the end to first order. A backward sweep of 6×6
//!     blocks computes it, with `Q = B S Bᵀ/h` and `S` the authority `B W⁻¹Bᵀ` of the inputs that
//!     are not at their limits:
//!
//!   ```text
//!   Λ_{N−1} = I ,  Z_N = −K₋⁻¹ Q/2 (torques at nodes, Lie–Verlet), else 0
//!   Z_k = A_k⁻¹ (Z_{k+1} + Q_k Λ_k) ,   P_k = Λ_k Z_k⁻¹ ,   K_k = W⁻¹Bᵀ (B_kᵀ P_k)/h ,   Λ_{k−1} = A_kᵀ Λ_k + H_k Z_k
//!   ```
//!
//!   With reaction wheels the stored momentum is a state too, `[ζ; δΠ; δμ]`. Its end is free,
//!   `λ^μ = 0`, because conservation determines it.
//!
//!   A torque that is held, or whose axes turn, also enters the second derivatives of its step.
//!   `A`, `H` and `K` then have the additional terms of `linear_plan::stage`.
//!
//!   The gains grow like `4/(T − t)` and `6/(T − t)²`; the last of them would answer the noise of
//!   sensors with all the torque there is, so they are held from [`Gains::frozen_from`] on.
//! - [`Kind::Tvlqr`]: the regulator of given weights, from the Riccati recursion.
//! - [`Kind::Switching`]: the same behind a correction of the switching times at the start
//!   ([`SwitchingGains`]).
//!
//! The landing law checks signs, orders and the index of every step: the miss of the corrected
//! motion falls with the square of the initial deviation from the plan (tests).

pub mod replan;
mod sweep;
mod switching;

pub use switching::{Arc, NotCorrected, Reversed, SwitchingGains};

use crate::Matrix3;
use crate::maneuver::duration::Duration;
use crate::maneuver::{Problem, Trajectory};
use crate::optimize::discrete::linear_plan::{
    LinearPlan, Matrix6, Matrix9, PosedPlan, Stage, Stages, Timing, Unlinearised, kick,
};
use crate::optimize::discrete::step::Units;
use nalgebra::{DMatrix, SMatrix};
use sweep::{Swept, neighbouring, regulator};
use thiserror::Error;

/// Three by six: torques by states.
type Matrix3x6 = SMatrix<f64, 3, 6>;

/// The design of gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// The neighbouring extremal, held over the last part of the plan.
    Neighbouring {
        /// Part of the steps over which gains are held, [`Kind::FREEZE`] by default. A smaller
        /// part improves the rate at the end, and costs torque due to noise.
        freeze: f64,
    },
    /// The regulator with these weights.
    Tvlqr(Option<RegulatorWeights>),
    /// Switching times corrected once, at the start, and then the regulator with these weights
    /// near the resulting motion.
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
    /// `e`: the weight of the end, relative to the weight of the whole duration.
    pub end: f64,
}

impl RegulatorWeights {
    /// The default weight of the end, relative to the duration.
    pub const END: f64 = 1000.0;

    /// Returns the weights of a sequence that lasts `whole` seconds: an error of a radian costs as
    /// much as the torque that turns the body by a radian in `leg` seconds, and at the end of a leg
    /// [`RegulatorWeights::END`] times as much as all along it.
    pub fn of_legs(problem: &Problem, leg: f64, whole: f64) -> Self {
        let cost = Units::of(&Problem { duration: Duration::Given(leg), ..problem.clone() }).cost;
        Self { attitude: cost / leg, rate: cost * leg, end: Self::END * leg / whole }
    }

    /// Returns the weights for which an error of a radian costs as much as the torque that turns
    /// the body by a radian in the duration.
    fn of<const N: usize, const C: usize>(stages: &[&Stage<N, C>]) -> [SMatrix<f64, N, N>; 2] {
        // In the solver's units the torque weight applies to all four; the weight of the force
        // applies to position and velocity.
        let authority = |first: usize| {
            let of = |stage: &&Stage<N, C>| {
                (first..first + 3).map(|row| stage.authority[(row, row)]).sum::<f64>() / 3.0
            };
            stages.iter().map(of).fold(0.0, f64::max)
        };
        let weights = [0, C - 3].map(|first| 1.0 / authority(first));
        let weight = |row: usize| weights[usize::from(row + 6 >= N)];
        let diagonal = |row: usize, column: usize| if row == column { weight(row) } else { 0.0 };
        let running = SMatrix::from_fn(diagonal);
        [running, running * Self::END]
    }

    /// Returns the weights of the state, running and at the end, in the solver's units.
    fn scaled(&self, units: &Units, momentum_of_rate: &Matrix3) -> [Matrix6; 2] {
        let per = units.time / units.cost;
        let inverse = momentum_of_rate.try_inverse().unwrap_or_else(Matrix3::identity);
        let mut running = Matrix6::identity() * (self.attitude * per);
        running.fixed_view_mut::<3, 3>(3, 3).copy_from(&(inverse.transpose() * inverse * (self.rate * per)));
        [running, running * self.end]
    }
}

/// The reason for which no gains exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NoGains {
    /// Inputs that switch have no neighbouring extremal of continuous gains.
    #[error(
        "neighbouring gains do not exist if inputs switch between their limits: a neighbour has \
        other switching times"
    )]
    Switching,
    /// The inputs that are not at their limits cannot bring the craft to the end from every
    /// neighbour of the start.
    #[error("the inputs that are not at their limits along the plan cannot correct every error of its start")]
    Unreachable,
    /// The arcs of the plan do not have lengths that a start can change.
    #[error("no lengths of its arcs depend on its start: {0}")]
    Arcs(&'static str),
    /// Weights of attitude and rate alone, for a body that translates.
    #[error("weights of attitude and rate alone do not weigh position and velocity: weigh these too")]
    Weights,
    /// Covariances are requested for a motion whose switches are moved at the start.
    #[error("the covariance of a motion whose switching times are corrected at the start is unknown")]
    MovedStart,
    /// The motion near the plan is unknown.
    #[error(transparent)]
    Plan(#[from] Unlinearised),
    /// A number is not finite.
    #[error("a gain is not finite")]
    NotFinite,
}

/// Gains along a plan.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Gains {
    /// The design of the gains.
    pub kind: Kind,
    /// The time at which a correction acts.
    pub timing: Timing,
    /// Number of inputs m.
    pub inputs: usize,
    /// The first step whose gains repeat the gains of the step before it, held to the end; the
    /// number of steps if no gains repeat.
    pub frozen_from: usize,
    /// Steps from one measurement to the next; a correction is held over them. These steps have
    /// equal rows.
    pub every: usize,
    /// The number n of components of `z`: 6; 9 for neighbouring gains of wheels, `[ζ; δΠ; δμ]`
    /// with the momentum of the wheels, body axes; 12 for bodies that translate,
    /// `[δx; δγ; ζ; δΠ]`.
    pub states: usize,
    /// `K_k`, m×n a step, row-major: SI input for each rad and N·m·s, m and N·s.
    pub rows: Vec<f64>,
    /// The correction of the first input, m×6, if half a kick opens the maneuver (torques at
    /// nodes, neighbouring).
    pub first: Option<Vec<f64>>,
    /// `P_k` of the cost to go, scaled, one a step; in the order of `rows`, empty for frozen steps.
    pub(crate) to_go: Vec<Matrix6>,
}

impl Gains {
    /// Designs the regulator of default weights along a plan of `problem`, for the true motion
    /// under the inputs of the plan, held over its steps. An error of a radian weighs as much as
    /// the torque that turns the body by a radian in the duration.
    ///
    /// # Errors
    /// [`NoGains`]: the trajectory is not of this problem, or the body translates.
    pub fn regulator(problem: &Problem, plan: &Trajectory) -> Result<Self, NoGains> {
        let linear = LinearPlan::flown(problem, plan)?;
        Self::along(&linear, Kind::Tvlqr(None), problem.objective.switches())
    }

    /// Designs the gains of the neighbouring extremal along a plan of `problem`, for the true
    /// motion under the inputs of the plan, held over its steps: the craft follows the cheapest
    /// motion from its present state. The gains of the last steps repeat the gains of the step
    /// before.
    ///
    /// # Errors
    /// [`NoGains`]: also for plans whose inputs switch, or are at their limits for too long.
    pub fn neighbouring(problem: &Problem, plan: &Trajectory) -> Result<Self, NoGains> {
        let linear = LinearPlan::flown(problem, plan)?;
        Self::along(&linear, Kind::Neighbouring { freeze: Kind::FREEZE }, problem.objective.switches())
    }

    /// Designs gains along a plan.
    ///
    /// # Errors
    /// [`NoGains`]: the neighbouring extremal needs inputs that are not at their limits.
    pub fn along(plan: &LinearPlan, kind: Kind, switches: bool) -> Result<Self, NoGains> {
        match kind {
            Kind::Neighbouring { .. } if switches => Err(NoGains::Switching),
            Kind::Neighbouring { freeze } if plan.has_wheels() => Self::of_wheels(plan, kind, freeze),
            Kind::Neighbouring { freeze } => {
                let end = end_of(plan)?;
                let swept = neighbouring(plan.count(), |k| &plan.steps()[k].stage, end, freeze)?;
                let first = (plan.half_kick(0) > 0.0).then(|| first_costate(plan, &swept.to_go[0], 0));
                let first = first.map(|first| first.fixed_view::<3, 6>(3, 0).into_owned());
                Self::new(plan, kind, swept, first)
            }
            Kind::Tvlqr(weights) | Kind::Switching(weights) => {
                let stages: Vec<_> = plan.steps().iter().map(|step| &step.stage).collect();
                let weights = match weights {
                    Some(weights) => weights.scaled(plan.units(), &plan.momentum_of_rate()),
                    None => RegulatorWeights::of(&stages),
                };
                let swept = regulator(stages.len(), |k| stages[k], weights, plan.stops());
                Self::new(plan, kind, swept, None)
            }
        }
    }

    /// Computes the neighbouring extremal with wheels: their momentum is a state next to `z`, and
    /// conservation determines its end.
    fn of_wheels(plan: &LinearPlan, kind: Kind, freeze: f64) -> Result<Self, NoGains> {
        let (mut left, mut costates) = (Matrix9::zeros(), Matrix9::identity());
        left.fixed_view_mut::<3, 3>(6, 6).fill_with_identity();
        costates.fixed_view_mut::<3, 3>(6, 6).fill(0.0);
        let stages: Vec<_> = plan.steps().iter().filter_map(|step| step.with_wheels.as_deref()).collect();
        let swept = neighbouring(stages.len(), |k| stages[k], (left, costates), freeze)?;
        Self::new(plan, kind, swept, None)
    }

    /// Designs gains along a plan of a body that translates, or whose torques are fixed in the
    /// reference frame.
    ///
    /// # Errors
    /// [`NoGains`], as of [`Gains::along`]; also where weights of attitude and rate are given for a
    /// body that translates.
    pub fn along_pose(plan: &PosedPlan, kind: Kind, switches: bool) -> Result<Self, NoGains> {
        match &plan.stages {
            Stages::Attitude(stages) => {
                let scaled =
                    |weights: RegulatorWeights| Ok(weights.scaled(&plan.units, &plan.momentum_of_rate));
                Self::posed(plan, stages, kind, switches, scaled)
            }
            Stages::Pose(stages) => Self::posed(plan, stages, kind, switches, |_| Err(NoGains::Weights)),
        }
    }

    fn posed<const N: usize, const C: usize>(
        plan: &PosedPlan,
        stages: &[Stage<N, C>],
        kind: Kind,
        switches: bool,
        scaled: impl Fn(RegulatorWeights) -> Result<[SMatrix<f64, N, N>; 2], NoGains>,
    ) -> Result<Self, NoGains> {
        let swept = match kind {
            Kind::Neighbouring { .. } if switches => return Err(NoGains::Switching),
            Kind::Neighbouring { freeze } => {
                let end = (SMatrix::zeros(), SMatrix::identity());
                neighbouring(stages.len(), |k| &stages[k], end, freeze)?
            }
            Kind::Tvlqr(weights) | Kind::Switching(weights) => {
                let each: Vec<_> = stages.iter().collect();
                let weights = weights.map_or_else(|| Ok(RegulatorWeights::of(&each)), scaled)?;
                regulator(stages.len(), |k| &stages[k], weights, &[])
            }
        };
        let rows = si_rows(&swept, |k| &plan.to_inputs[k], |column| plan.unit(column))?;
        let (inputs, frozen_from) = (plan.to_inputs[0].nrows(), swept.frozen_from);
        let (timing, to_go) = (Timing::Held, Vec::new());
        Ok(Self { kind, timing, inputs, states: N, frozen_from, every: 1, rows, first: None, to_go })
    }

    /// Builds the gains from the sweep of a plan with torques.
    fn new<const N: usize>(
        plan: &LinearPlan,
        kind: Kind,
        swept: Swept<N, 3>,
        first: Option<Matrix3x6>,
    ) -> Result<Self, NoGains> {
        let to_inputs = |k: usize| &plan.steps()[k].to_inputs;
        let rows = si_rows(&swept, to_inputs, |column| plan.unit(column))?;
        let first = first.map(|dual| si_row(to_inputs(0), &dual, |column| plan.unit(column)));
        let to_go = swept.to_go.iter().map(|p| p.fixed_view::<6, 6>(0, 0).into_owned()).collect();
        let (inputs, frozen_from, timing) = (plan.axes().ncols(), swept.frozen_from, plan.timing());
        Ok(Self { kind, timing, inputs, states: N, frozen_from, every: 1, rows, first, to_go })
    }

    /// Builds the gains that were designed along ticks of `every` steps for a plan of `count`
    /// steps, over which each correction is held.
    pub(crate) fn held_over(self, every: usize, count: usize) -> Self {
        let rows = (0..count).flat_map(|step| self.row(step / every).iter().copied()).collect();
        Self { every, rows, frozen_from: (self.frozen_from * every).min(count), to_go: Vec::new(), ..self }
    }

    /// Returns `K_k`, row-major.
    pub fn row(&self, step: usize) -> &[f64] {
        let width = self.inputs * self.states;
        &self.rows[step * width..(step + 1) * width]
    }

    /// Returns `K_k z`, which is subtracted from each input, for a `z` with [`Gains::states`]
    /// numbers, SI.
    pub fn correction<'a>(&'a self, step: usize, z: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.row(step)
            .chunks_exact(self.states)
            .map(move |row| row.iter().zip(z.iter()).map(|(k, z)| k * z).sum())
    }

    /// Returns `B K_k` in the solver's units, 3×N: scaled torques for a scaled `z`, with N = 9 if
    /// `z` includes the momentum of wheels.
    pub(crate) fn torque<const N: usize>(&self, plan: &LinearPlan, step: usize) -> SMatrix<f64, 3, N> {
        let gain = DMatrix::from_row_slice(self.inputs, self.states, self.row(step));
        let si = plan.axes() * gain;
        let states = self.states;
        let scaled = |row: usize, column: usize| {
            let gain = if column < states { si[(row, column)] } else { 0.0 };
            gain * plan.unit(column) / plan.units().torque()
        };
        SMatrix::from_fn(scaled)
    }
}

/// Returns `K` of a step, SI, row-major, from its dual.
fn si_row<const N: usize, const C: usize>(
    to_inputs: &DMatrix<f64>,
    dual: &SMatrix<f64, C, N>,
    unit: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let gain = to_inputs * DMatrix::from_column_slice(C, N, dual.as_slice());
    (0..gain.nrows() * N).map(|index| gain[(index / N, index % N)] / unit(index % N)).collect()
}

/// Returns the rows of all steps in SI units; frozen rows repeat the step before.
fn si_rows<'a, const N: usize, const C: usize>(
    swept: &Swept<N, C>,
    to_inputs: impl Fn(usize) -> &'a DMatrix<f64>,
    unit: impl Fn(usize) -> f64,
) -> Result<Vec<f64>, NoGains> {
    let mut rows = Vec::new();
    for (k, dual) in swept.duals.iter().enumerate() {
        if k < swept.frozen_from {
            rows.extend(si_row(to_inputs(k), dual, &unit));
        } else {
            let before = rows.len() - to_inputs(k).nrows() * N;
            rows.extend_from_within(before..);
        }
    }
    if rows.iter().all(|value| value.is_finite()) { Ok(rows) } else { Err(NoGains::NotFinite) }
}

/// Returns the free part of the end states of a plan with torques, and the costates at the end:
/// `Z_N = −K₋⁻¹ Q/2` if half a kick follows.
fn end_of(plan: &LinearPlan) -> Result<(Matrix6, Matrix6), NoGains> {
    let mut z = Matrix6::zeros();
    let half = plan.half_kick(1);
    if half > 0.0 {
        let authority = plan.steps()[plan.count() - 1].stage.authority;
        z.fixed_view_mut::<3, 3>(3, 3).copy_from(&(half * authority));
        z = -(plan.last().try_inverse().ok_or(NoGains::NotFinite)? * z);
    }
    Ok((z, Matrix6::identity()))
}

/// Returns `∂λ_{k−1}/∂z` of a motion that begins at node `k` of a plan whose cost to go has `P_k`,
/// scaled: 6×6, `z` physical.
///
/// ```text
/// G = A_kᵀ P_k + H_k ,             δλ_{k−1} = (I + G Q/2)⁻¹ G K₊ z ,
/// K₊ = [[I, 0], [w ∂M/∂R, I]] ,    Q/2 = [0, 0; 0, w S]
/// ```
///
/// with the weight `w` of the half kick at the start of the motion, 0 if the maneuver has no half
/// kick. It is NaN if `I + G Q/2` is singular.
fn first_costate(plan: &LinearPlan, to_go: &Matrix6, node: usize) -> Matrix6 {
    let step = &plan.steps()[node];
    let g = step.stage.a.transpose() * to_go + step.stage.h;
    let weight = plan.half_kick(0);
    let mut half = Matrix6::zeros();
    let authority = plan.steps()[node.saturating_sub(1)].stage.authority;
    half.fixed_view_mut::<3, 3>(3, 3).copy_from(&(weight * authority));
    let opened = (Matrix6::identity() + g * half).try_inverse();
    opened.unwrap_or_else(|| Matrix6::repeat(f64::NAN)) * g * kick(&(weight * plan.field_gradient(node)))
}

#[cfg(test)]
mod tests;
