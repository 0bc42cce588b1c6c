//! The kick and the drift of the chain.

use super::{ChainState, Model};
use crate::lie;
use crate::mechanics::environment::{Blocks, Wrench};
use crate::optimize::discrete::step::StepError;
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, DVector};

/// Kick at one pose: it adds the wrench, times the weight κ of the kick, to the momenta. The
/// derivatives here do not include κ.
pub(in crate::optimize::chain) struct Kick {
    wrench: Wrench,
    /// Part of the wrench that the environment exerts.
    field: Wrench,
    pub gradient: Blocks,
    /// Derivative of the momenta with respect to the inputs, n×m.
    pub inputs: DMatrix<f64>,
}

/// Computes the kick at a state under `inputs`.
pub(in crate::optimize::chain) fn kick(model: &Model, state: &ChainState, inputs: &[f64]) -> Kick {
    let (pose, squared) = (state.pose(), state.stretch * state.stretch);
    let r = &pose.attitude;
    let mut columns = DMatrix::zeros(model.n, model.m);
    let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
    for (index, axis) in model.torque.axes().iter().enumerate() {
        let input = model.first_torque + index;
        let axis = model.torque.frame().to_body(r, axis);
        torque += axis * inputs[input];
        if model.wheels > 0 {
            columns[(6 + index, input)] = -1.0;
        } else {
            columns.view_mut((model.pi(), input), (3, 1)).copy_from(&axis);
        }
    }
    if let Some(set) = &model.force {
        for (input, axis) in set.axes().iter().enumerate() {
            let axis = set.frame().to_reference(r, axis);
            force += axis * inputs[input];
            columns.view_mut((3, input), (3, 1)).copy_from(&axis);
        }
    }
    // Wheels exchange momentum with the body: the total momentum does not change.
    let given = Wrench { force, moment: if model.wheels > 0 { Vector3::zeros() } else { torque } };
    let in_stated_units = Wrench { force: given.force / squared, moment: given.moment / squared };
    let (wrench, gradient) = model.dynamics.kick_of_inputs(&pose, &in_stated_units);
    let wrench = Wrench { force: wrench.force * squared, moment: wrench.moment * squared };
    let gradient = gradient.scaled(squared);
    let field = Wrench { force: wrench.force - given.force, moment: wrench.moment - given.moment };
    Kick { wrench, field, gradient, inputs: columns }
}

/// Converts the costate of a stage to the convention of the shooting, in which every kick is a full
/// kick. The costate changes only at the end of a Lie–Verlet chain, whose last kick is a half kick:
/// `λ ← (I − ½h G)ᵀ λ`.
pub fn after_full_kick(
    model: &Model,
    stage: usize,
    state: &ChainState,
    inputs: &[f64],
    costate: &DVector<f64>,
) -> DVector<f64> {
    if stage < model.steps || !model.dynamics.grid.has_half_kicks() {
        return costate.clone();
    }
    let mut rest = DMatrix::identity(model.n, model.n);
    let kick = kick(model, state, inputs);
    add_gradient(model, &mut rest, &kick.gradient, -model.kick_weight(stage));
    rest.tr_mul(costate)
}

/// Returns the state before the kick of a stage, from the state after it.
pub fn before_kick(model: &Model, stage: usize, after: &ChainState, inputs: &[f64]) -> ChainState {
    kicked(model, after, &kick(model, after, inputs), inputs, -model.kick_weight(stage))
}

/// Returns the state after the kick of a stage, from the state before it.
pub fn after_kick(model: &Model, stage: usize, before: &ChainState, inputs: &[f64]) -> ChainState {
    kicked(model, before, &kick(model, before, inputs), inputs, model.kick_weight(stage))
}

/// Returns the costate after the kick of a stage, `(I + κG)⁻ᵀ λ`, from the costate λ before the
/// kick. G is the gradient of the kick and κ its weight.
pub fn costate_after_kick(
    model: &Model,
    stage: usize,
    before: &ChainState,
    inputs: &[f64],
    costate: &DVector<f64>,
) -> DVector<f64> {
    let (kick, weight) = (kick(model, before, inputs), model.kick_weight(stage));
    let mut back = DMatrix::identity(model.n, model.n);
    add_gradient(model, &mut back, &kick.gradient, -weight);
    let mut out = back.tr_mul(costate);
    if let Some(duration) = model.duration {
        // The wrench of the environment scales with `s²`.
        let (pi, field) = (model.pi(), &kick.field);
        let mut slope = costate.fixed_rows::<3>(pi).dot(&field.moment);
        if model.moves {
            slope += costate.fixed_rows::<3>(3).dot(&field.force);
        }
        out[duration] -= 2.0 * weight * slope;
    }
    out
}

/// Applies a kick with weight `weight` to a state.
pub(in crate::optimize::chain) fn kicked(
    model: &Model,
    state: &ChainState,
    kick: &Kick,
    inputs: &[f64],
    weight: f64,
) -> ChainState {
    let mut out = state.clone();
    out.momentum += kick.wrench.moment * weight;
    if model.moves {
        out.linear_momentum += kick.wrench.force * weight;
    }
    for wheel in 0..model.wheels {
        out.wheels[wheel] -= inputs[model.forces + wheel] * weight;
    }
    out
}

/// Multiplies `A` by a kick: `A ← (I + κ G) A`, with the gradient G of the kick and `weight` as κ.
/// Only the momentum rows change.
pub(in crate::optimize::chain) fn add_gradient(
    model: &Model,
    matrix: &mut DMatrix<f64>,
    gradient: &Blocks,
    weight: f64,
) {
    let (zeta, pi) = (model.zeta(), model.pi());
    let rotation = matrix.rows(zeta, 3).into_owned();
    let mut to_momentum = gradient.rr * &rotation;
    if model.moves {
        let shift = matrix.rows(0, 3).into_owned();
        to_momentum += gradient.rx * &shift;
        let to_force = gradient.xx * &shift + gradient.xr * &rotation;
        let mut rows = matrix.rows_mut(3, 3);
        rows += to_force * weight;
    }
    let mut rows = matrix.rows_mut(pi, 3);
    rows += to_momentum * weight;
}

/// Returns the state after the opening kick of a maneuver that takes `stretch` times the duration
/// of the problem.
pub fn opening(model: &Model, stretch: f64, inputs: &[f64]) -> ChainState {
    after_kick(model, 0, &model.start_in(stretch), inputs)
}

/// Computes step k: from `y_k` under `u_{k+1}` to `y_{k+1}`.
pub fn step(
    model: &Model,
    stage: usize,
    state: &ChainState,
    inputs: &[f64],
) -> Result<ChainState, StepError> {
    Ok(after_kick(model, stage + 1, &drift(model, stage, state)?.0, inputs))
}

/// Returns the derivative of the state of a stage with respect to its inputs, n×m.
pub fn by_inputs(model: &Model, stage: usize, state: &ChainState) -> DMatrix<f64> {
    kick(model, state, &vec![0.0; model.m]).inputs * model.kick_weight(stage)
}

/// Computes the drift of step k. Returns the state between drift and kick, and the relative
/// attitude `F`.
pub fn drift(model: &Model, stage: usize, state: &ChainState) -> Result<(ChainState, Matrix3), StepError> {
    if model.wheels == 0 {
        let mut point = state.point();
        let drift = model.dynamics.drift::<12>(stage, &mut point)?;
        let attitude = hastened_frame(model, stage, state.stretch) * point.attitude.value;
        let end = ChainState::of(&point, state.wheels.clone());
        return Ok((ChainState { attitude, stretch: state.stretch, ..end }, drift.f));
    }
    let carried = model.wheel_momentum(&state.wheels);
    let drift = model.dynamics.gyrostat_drift(stage, &state.momentum, &carried)?;
    let attitude = model.dynamics.turned(stage, &(state.attitude * drift.f));
    let attitude = hastened_frame(model, stage, state.stretch) * attitude;
    let end = ChainState { attitude, momentum: drift.momentum_after, ..state.clone() };
    Ok((end, drift.f))
}

/// Returns the rotation vector by which the reference frame turns over the duration of the problem,
/// in axes of that frame.
pub fn frame_rate(model: &Model) -> Vector3 {
    model.dynamics.frame_rate()
}

/// Returns the difference between the rotation of a rotating reference frame on step k in the
/// problem's duration and that in a duration `stretch` times as long.
fn hastened_frame(model: &Model, stage: usize, stretch: f64) -> Matrix3 {
    if stretch == 1.0 || frame_rate(model) == Vector3::zeros() {
        return Matrix3::identity();
    }
    lie::exp(&(frame_rate(model) * (model.dynamics.grid.step(stage) * (1.0 - stretch))))
}

/// Removes the rotation of the reference frame over step k from the attitude at its end; the result
/// is `R_k F_k`.
pub fn unturned(model: &Model, stage: usize, attitude: &Matrix3, stretch: f64) -> Matrix3 {
    model.dynamics.unturned(stage, &hastened_frame(model, stage, stretch).tr_mul(attitude))
}

/// Returns the physical state at stage k.
pub fn physical(model: &Model, stage: usize, state: &ChainState, inputs: &[f64]) -> ChainState {
    if stage == 0 {
        return model.start_in(state.stretch);
    }
    let kick = kick(model, state, inputs);
    kicked(model, state, &kick, inputs, -model.lag(stage))
}

/// Returns the actuator force (reference frame) and torque (body axes) at a state, scaled.
pub fn output(model: &Model, state: &ChainState, inputs: &[f64]) -> Wrench {
    let (forces, torques) = (&inputs[..model.forces], &inputs[model.first_torque..]);
    let r = &state.attitude;
    let force = model.force.as_ref().map(|set| set.frame().to_reference(r, &set.output(forces)));
    Wrench {
        force: force.unwrap_or_else(Vector3::zeros),
        moment: model.torque.frame().to_body(r, &model.torque.output(torques)),
    }
}
