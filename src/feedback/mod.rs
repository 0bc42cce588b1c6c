//! Feedback gains along a plan. They keep a craft that starts near the plan close to it, and bring
//! it to the end.
//!
//! ```text
//! u = u*_k − K_k z_k ,     z = [log(R*_kᵀ R); Π − Π*_k]
//! ```
//!
//! - [`Kind::Neighbouring`]: the gains of the neighbouring extremal, the correction of least cost
//!   among all corrections that bring the craft to the end to first order. A backward sweep of 6×6
//!   blocks computes them, with `Q = B S Bᵀ/h` and `S` the authority `B W⁻¹Bᵀ` of the inputs that
//!   are not at their limits:
//!
//!   ```text
//!   Λ_{N−1} = I ,  Z_N = −K₋⁻¹ Q/2 (torques at nodes, Lie–Verlet), else 0
//!   Z_k = A_k⁻¹ (Z_{k+1} + Q_k Λ_k) ,   P_k = Λ_k Z_k⁻¹ ,   K_k = W⁻¹Bᵀ (B_kᵀ P_k)/h ,   Λ_{k−1} = A_kᵀ Λ_k + H_k Z_k
//!   ```
//!
//!   With reaction wheels the stored momentum is a state too, `[ζ; δΠ; δμ]`. Its terminal value
//!   is free, `λ^μ = 0`, because conservation of momentum determines it.
//!
//!   A torque that is held, or whose axes turn, also enters the second derivatives of its step.
//!   `A`, `H` and `K` then have the additional terms of `linear_plan::stage`.
//!
//!   The gains grow like `4/(T − t)` and `6/(T − t)²` towards the end. There they would amplify
//!   sensor noise to the full torque, so they are constant from step [`Gains::frozen_from`] on.
//! - [`Kind::Tvlqr`]: the time-varying linear-quadratic regulator of given weights, from the
//!   Riccati recursion.
//! - [`Kind::Switching`]: this regulator, after the switching times have been corrected once at the
//!   start ([`SwitchingGains`]).
//!
//! The tests check signs, orders and step indices by the terminal miss of the corrected motion: it
//! falls with the square of the initial deviation from the plan.

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

/// Matrix that maps a state (six components) to a torque (three components).
type Matrix3x6 = SMatrix<f64, 3, 6>;

/// The design method of feedback gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Gains of the neighbouring extremal, held constant over the last part of the plan.
    Neighbouring {
        /// Fraction of the steps, counted from the end, over which the gains are held constant; by
        /// default [`Kind::FREEZE`]. A smaller fraction reduces the rate error at the end, and
        /// costs more torque due to sensor noise.
        freeze: f64,
    },
    /// Time-varying linear-quadratic regulator with these weights; `None` selects default weights.
    Tvlqr(Option<RegulatorWeights>),
    /// Switching times that are corrected once, at the start, and then a regulator with these
    /// weights about the corrected motion; `None` selects default weights.
    Switching(Option<RegulatorWeights>),
}

impl Kind {
    /// Default fraction of the steps over which neighbouring gains are held constant. If it is
    /// positive, at least four steps are held.
    pub const FREEZE: f64 = 0.15;
    const LEAST_FROZEN: usize = 4;
}

/// Weights of a regulator with the cost
/// `∫ (a |ζ|² + b |δΩ|² + δuᵀW δu) dt + e T (a |ζ|² + b |δΩ|²)`, where `ζ` is the attitude error,
/// `δΩ` the rate error, `δu` the correction and `T` the duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegulatorWeights {
    /// Weight `a` of the attitude error, in the unit of the cost per s·rad².
    pub attitude: f64,
    /// Weight `b` of the rate error, in the unit of the cost per s·(rad/s)².
    pub rate: f64,
    /// Factor `e` of the terminal weight, relative to the running weights times the duration.
    pub end: f64,
}

impl RegulatorWeights {
    /// Default factor of the terminal weight, relative to the running weights times the duration.
    pub const END: f64 = 1000.0;

    /// Returns the regulator weights for a sequence that lasts `whole` seconds, with legs of `leg`
    /// seconds. A constant attitude error of one radian costs as much as the torque that turns the
    /// body by one radian in `leg` seconds. At the end of a leg, an error costs
    /// [`RegulatorWeights::END`] times as much as a constant error along the whole leg.
    pub fn of_legs(problem: &Problem, leg: f64, whole: f64) -> Self {
        let cost = Units::of(&Problem { duration: Duration::Given(leg), ..problem.clone() }).cost;
        Self { attitude: cost / leg, rate: cost * leg, end: Self::END * leg / whole }
    }

    /// Returns the default running and terminal weights of the state. An attitude error of one
    /// radian costs as much as the torque that turns the body by one radian in the duration.
    fn of<const N: usize, const C: usize>(stages: &[&Stage<N, C>]) -> [SMatrix<f64, N, N>; 2] {
        // The weight of the torque applies to attitude and momentum, and the weight of the force to
        // position and velocity, all in the solver's units.
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

    /// Returns the running and the terminal weight of the state, in the solver's units.
    fn scaled(&self, units: &Units, momentum_of_rate: &Matrix3) -> [Matrix6; 2] {
        let per = units.time / units.cost;
        let inverse = momentum_of_rate.try_inverse().unwrap_or_else(Matrix3::identity);
        let mut running = Matrix6::identity() * (self.attitude * per);
        running.fixed_view_mut::<3, 3>(3, 3).copy_from(&(inverse.transpose() * inverse * (self.rate * per)));
        [running, running * self.end]
    }
}

/// The reason why no gains exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NoGains {
    /// The plan is bang-bang. Its neighbouring extremals have other switching times, so no
    /// continuous gains exist.
    #[error(
        "neighbouring gains do not exist if inputs switch between their limits: a neighbour has \
        other switching times"
    )]
    Switching,
    /// The inputs that are not at their limits cannot bring the craft to the end from every
    /// neighbouring start.
    #[error("the inputs that are not at their limits along the plan cannot correct every error of its start")]
    Unreachable,
    /// The lengths of the plan's arcs cannot be corrected for another start; the text names the
    /// reason.
    #[error("its arcs cannot be corrected for errors at the start: {0}")]
    Arcs(&'static str),
    /// Weights of attitude and rate alone were given for a body that also translates.
    #[error("the weights cover only attitude and rate: give weights of position and velocity too")]
    Weights,
    /// A covariance is requested for a motion whose switching times are corrected at the start.
    #[error("the covariance of a motion whose switching times are corrected at the start is unknown")]
    MovedStart,
    /// The motion about the plan could not be linearised.
    #[error(transparent)]
    Plan(#[from] Unlinearised),
    /// A gain is not finite.
    #[error("a gain is not finite")]
    NotFinite,
}

/// Feedback gains along a plan.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Gains {
    /// The design method of the gains.
    pub kind: Kind,
    /// Whether a correction is held over a step or acts as an impulse at a node.
    pub timing: Timing,
    /// Number m of inputs.
    pub inputs: usize,
    /// Index of the step from which the gains are constant: all steps from it to the end repeat the
    /// gains of the step before it. Equals the number of steps if no gains repeat.
    pub frozen_from: usize,
    /// Number of steps between two measurements. A correction is held over these steps, so their
    /// rows are equal.
    pub every: usize,
    /// Number n of components of the deviation `z`:
    /// - 6: `[ζ; δΠ]`, attitude and angular momentum;
    /// - 9: `[ζ; δΠ; δμ]`, neighbouring gains with wheels, whose momentum μ is in body axes;
    /// - 12: `[δx; δγ; ζ; δΠ]`, for bodies that translate.
    pub states: usize,
    /// The gain matrices `K_k` of all steps, one m×n block per step, row-major. Units: the SI unit
    /// of the input, per rad, N·m·s, m or N·s.
    pub rows: Vec<f64>,
    /// The gain of the first input, m×6. `None` unless the gains are neighbouring gains of a
    /// maneuver that begins with a half kick (torques at nodes).
    pub first: Option<Vec<f64>>,
    /// The matrices `P_k` of the quadratic cost to go, scaled, one per step in the order of `rows`.
    /// Empty for frozen steps.
    pub(crate) to_go: Vec<Matrix6>,
}

impl Gains {
    /// Designs the regulator with default weights along a plan of `problem`. It applies to the true
    /// motion under the inputs of the plan, held over its steps. An attitude error of one radian
    /// has the same weight as the torque that turns the body by one radian in the duration.
    ///
    /// # Errors
    /// [`NoGains`] if the trajectory does not belong to this problem, or if the body translates.
    pub fn regulator(problem: &Problem, plan: &Trajectory) -> Result<Self, NoGains> {
        let linear = LinearPlan::flown(problem, plan)?;
        Self::along(&linear, Kind::Tvlqr(None), problem.objective.switches())
    }

    /// Designs the gains of the neighbouring extremal along a plan of `problem`: the craft follows
    /// the cheapest motion from its present state to the end. They apply to the true motion under
    /// the inputs of the plan, held over its steps. The last steps repeat the gains of the step
    /// before them.
    ///
    /// # Errors
    /// [`NoGains`], also for bang-bang plans and for plans whose inputs stay at their limits too
    /// long.
    pub fn neighbouring(problem: &Problem, plan: &Trajectory) -> Result<Self, NoGains> {
        let linear = LinearPlan::flown(problem, plan)?;
        Self::along(&linear, Kind::Neighbouring { freeze: Kind::FREEZE }, problem.objective.switches())
    }

    /// Designs gains of the given kind along a linearised plan. `switches` states whether the plan
    /// is bang-bang.
    ///
    /// # Errors
    /// [`NoGains`]. The neighbouring extremal requires inputs that are not at their limits.
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

    /// Computes the neighbouring extremal with wheels. The wheel momentum is a state in addition to
    /// `z`, and conservation of momentum determines its terminal value.
    fn of_wheels(plan: &LinearPlan, kind: Kind, freeze: f64) -> Result<Self, NoGains> {
        let (mut left, mut costates) = (Matrix9::zeros(), Matrix9::identity());
        left.fixed_view_mut::<3, 3>(6, 6).fill_with_identity();
        costates.fixed_view_mut::<3, 3>(6, 6).fill(0.0);
        let stages: Vec<_> = plan.steps().iter().filter_map(|step| step.with_wheels.as_deref()).collect();
        let swept = neighbouring(stages.len(), |k| stages[k], (left, costates), freeze)?;
        Self::new(plan, kind, swept, None)
    }

    /// Designs gains along the plan of a body that translates, or whose torques are fixed in the
    /// reference frame.
    ///
    /// # Errors
    /// [`NoGains`], as [`Gains::along`] returns it; also if weights of attitude and rate are given
    /// for a body that translates.
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

    /// Builds the gains from the backward sweep along a plan of torques.
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

    /// Expands gains that were designed for ticks of `every` steps to a plan of `count` steps, with
    /// each correction held over its tick.
    pub(crate) fn held_over(self, every: usize, count: usize) -> Self {
        let rows = (0..count).flat_map(|step| self.row(step / every).iter().copied()).collect();
        Self { every, rows, frozen_from: (self.frozen_from * every).min(count), to_go: Vec::new(), ..self }
    }

    /// Returns the gain matrix `K_k` of a step, m×n, row-major.
    pub fn row(&self, step: usize) -> &[f64] {
        let width = self.inputs * self.states;
        &self.rows[step * width..(step + 1) * width]
    }

    /// Returns the correction `K_k z` of each input in SI units, which the caller subtracts from
    /// the planned input. The deviation `z` has [`Gains::states`] components in SI units.
    pub fn correction<'a>(&'a self, step: usize, z: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.row(step)
            .chunks_exact(self.states)
            .map(move |row| row.iter().zip(z.iter()).map(|(k, z)| k * z).sum())
    }

    /// Returns `B K_k` in the solver's units, a 3×N matrix from the scaled deviation `z` to the
    /// scaled torque. N is 9 if `z` includes the momentum of wheels.
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

/// Returns the gain matrix `K` of a step in SI units, row-major. `dual` is the step's matrix from
/// the backward sweep, `to_inputs` maps it to inputs, and `unit` returns the SI value of the scaled
/// unit of a component of the deviation.
fn si_row<const N: usize, const C: usize>(
    to_inputs: &DMatrix<f64>,
    dual: &SMatrix<f64, C, N>,
    unit: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let gain = to_inputs * DMatrix::from_column_slice(C, N, dual.as_slice());
    (0..gain.nrows() * N).map(|index| gain[(index / N, index % N)] / unit(index % N)).collect()
}

/// Returns the gain matrices of all steps in SI units; frozen steps repeat the gains of the step
/// before them.
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

/// Returns the terminal values of the backward sweep along a plan of torques: the free part of the
/// terminal states, `Z_N = −K₋⁻¹ Q/2` if a half kick ends the maneuver and 0 otherwise, and the
/// terminal costates.
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

/// Returns the derivative `∂λ_{k−1}/∂z` of the first costate of a motion that begins at node `k` of
/// the plan: a scaled 6×6 matrix, with the physical deviation `z`. `P_k` is the matrix of the
/// plan's cost to go.
///
/// ```text
/// G = A_kᵀ P_k + H_k ,             δλ_{k−1} = (I + G Q/2)⁻¹ G K₊ z ,
/// K₊ = [[I, 0], [w ∂M/∂R, I]] ,    Q/2 = [0, 0; 0, w S]
/// ```
///
/// Here `w` is the weight of the half kick that opens the motion, 0 if the maneuver has no half
/// kick. The matrix is NaN if `I + G Q/2` is singular.
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
