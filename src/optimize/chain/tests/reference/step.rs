//! Step, opening kick and angular velocity of the chain, with their matrices.

use crate::lie::{self, hat};
use crate::optimize::chain::model::step::{add_gradient, drift, kick, kicked};
use crate::optimize::chain::model::{ChainState, Model};
use crate::optimize::discrete::step::StepError;
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, DVector, Matrix3xX};

/// One step and its matrices for a given duration: `z⁺ = A z + B δu`.
pub(crate) struct Step {
    pub end: ChainState,
    pub a: DMatrix<f64>,
    pub b: DMatrix<f64>,
    pub arc: Arc,
}

/// Rotation of the body during one step.
pub(crate) struct Arc {
    /// Rotation vector, `log F`.
    pub turn: Vector3,
    /// Derivative of the rotation vector with respect to the state before the step, 3×n.
    pub slope: Matrix3xX<f64>,
}

/// Opening kick: the state `y_0` and its derivative with respect to `u_0`, n×m.
pub(crate) struct Opening {
    pub end: ChainState,
    pub by_inputs: DMatrix<f64>,
}

/// Computes the opening kick of a maneuver that takes `stretch` times the duration of the problem.
pub fn opening(model: &Model, stretch: f64, inputs: &[f64]) -> Opening {
    let (start, weight) = (model.start_in(stretch), model.kick_weight(0));
    let kick = kick(model, &start, inputs);
    let end = kicked(model, &start, &kick, inputs, weight);
    Opening { end, by_inputs: kick.inputs * weight }
}

/// Computes step k: from `y_k` under `u_{k+1}` to `y_{k+1}`.
pub fn step(model: &Model, stage: usize, state: &ChainState, inputs: &[f64]) -> Result<Step, StepError> {
    let (zeta, pi) = (model.zeta(), model.pi());
    let (mut end, f) = drift(model, stage, state)?;
    let turn = turned(model, stage, state)?;
    // z' = A0 z: ζ' = Fᵀζ + ξ and δΠ' = FᵀδΠ + S(Π')ξ, where ξ is the rotation of the arc itself.
    let mut a = DMatrix::identity(model.n, model.n);
    a.rows_mut(zeta, 3).copy_from(&turn);
    a.view_mut((zeta, zeta), (3, 3)).copy_from(&f.transpose());
    a.rows_mut(pi, 3).copy_from(&(hat(&end.momentum) * &turn));
    let mut block = a.view_mut((pi, pi), (3, 3));
    block += f.transpose();
    if model.moves {
        let h = model.dynamics.grid.step(stage);
        (0..3).for_each(|axis| a[(axis, axis + 3)] = h);
    }
    let weight = model.kick_weight(stage + 1);
    let kick = kick(model, &end, inputs);
    add_gradient(model, &mut a, &kick.gradient, weight);
    end = kicked(model, &end, &kick, inputs, weight);
    Ok(Step { end, a, b: kick.inputs * weight, arc: Arc::of(&f, turn) })
}

/// Returns the derivative of `ξ`, with `δF = F S(ξ)`, with respect to the state before a drift,
/// 3×n.
fn turned(model: &Model, stage: usize, state: &ChainState) -> Result<Matrix3xX<f64>, StepError> {
    let mut turn = Matrix3xX::zeros(model.n);
    let mut by_momentum = turn.view_mut((0, model.pi()), (3, 3));
    if model.wheels == 0 {
        let drift = model.dynamics.drift::<12>(stage, &mut state.point())?;
        let e = model.dynamics.drift_matrix(&drift);
        by_momentum.copy_from(&model.dynamics.drift_block(&drift, &e));
        return Ok(turn);
    }
    let carried = model.wheel_momentum(&state.wheels);
    let drift = model.dynamics.gyrostat_drift(stage, &state.momentum, &carried)?;
    by_momentum.copy_from(&drift.by_momentum);
    turn.view_mut((0, 6), (3, model.wheels)).copy_from(&(drift.by_wheels * &model.wheel_axes));
    Ok(turn)
}

/// Returns the physical angular velocity at stage k, and its derivatives with respect to state and
/// inputs.
pub fn rate(
    model: &Model,
    stage: usize,
    state: &ChainState,
    inputs: &[f64],
) -> (Vector3, Matrix3xX<f64>, Matrix3xX<f64>) {
    let (zeta, pi, lag) = (model.zeta(), model.pi(), model.lag(stage));
    let kick = kick(model, state, inputs);
    let physical = kicked(model, state, &kick, inputs, -lag);
    let momentum = physical.momentum - model.wheel_momentum(&physical.wheels);
    let mut by_state = Matrix3xX::zeros(model.n);
    by_state.view_mut((0, pi), (3, 3)).fill_with_identity();
    by_state.view_mut((0, zeta), (3, 3)).copy_from(&(kick.gradient.rr * -lag));
    if model.moves {
        by_state.view_mut((0, 0), (3, 3)).copy_from(&(kick.gradient.rx * -lag));
    }
    let mut by_inputs: Matrix3xX<f64> = kick.inputs.fixed_rows::<3>(pi) * -lag;
    if model.wheels > 0 {
        by_state.view_mut((0, 6), (3, model.wheels)).copy_from(&-&model.wheel_axes);
        let mut of_wheels = by_inputs.columns_mut(model.forces, model.wheels);
        of_wheels -= &model.wheel_axes * lag;
    }
    let inverse = &model.dynamics.j_inverse;
    (inverse * momentum, inverse * by_state, inverse * by_inputs)
}

impl Arc {
    /// Returns the arc of a relative attitude `f` whose derivative is `turn`.
    fn of(f: &Matrix3, turn: Matrix3xX<f64>) -> Self {
        let arc = lie::log(f);
        Self { turn: arc, slope: lie::right_jacobian_inverse(&arc) * turn }
    }
}

/// Computes `state ⊕ z` without a change of the duration.
pub fn moved(model: &Model, state: &ChainState, z: &DVector<f64>) -> ChainState {
    let part = |row: usize| Vector3::new(z[row], z[row + 1], z[row + 2]);
    let mut out = state.clone();
    if model.moves {
        out.position += part(0);
        out.linear_momentum += part(3);
    }
    out.attitude = lie::project_to_rotation(&(state.attitude * lie::exp(&part(model.zeta()))));
    out.momentum += part(model.pi());
    if model.wheels > 0 {
        out.wheels += z.rows(6, model.wheels);
    }
    out
}

/// Returns the size of the change of one state, measured by its rotation \[rad\].
pub fn length(model: &Model, z: &DVector<f64>) -> f64 {
    z.rows(model.zeta(), 3).norm()
}

/// Returns `κ_k W`, the Hessian of the effort with respect to the inputs of a stage, in a fixed
/// duration. Lie–Euler has no `u_0`, so there any positive weight serves to keep it constant.
pub fn input_weight(model: &Model, stage: usize) -> DMatrix<f64> {
    let weight = model.kick_weight(stage);
    if weight > 0.0 { &model.weight * weight } else { DMatrix::identity(model.m, model.m) }
}
