//! Initial iterates, built from a path of poses by computing the momenta and inputs that follow it.

use super::iterate::Iterate;
use super::model::{ChainState, Model};
use super::rows::{LimitRows, What};
use crate::Vector3;
use crate::lie::vee;
use crate::mechanics::environment::Pose;
use crate::optimize::chain::model::{state, step};
use crate::optimize::methods::method::Watch;
use nalgebra::{DMatrix, DVector};

/// Returns the iterate that follows `poses` (one per node, scaled) in `stretch` times the duration
/// of the problem, as far as the input limits allow. The impulse that the limits do not allow
/// remains as defects of the momenta. After a stop request the remaining inputs are zero.
pub(crate) fn along(model: &Model, rows: &LimitRows, poses: &[Pose], stretch: f64, watch: &Watch) -> Iterate {
    let states = states_along(model, poses, stretch);
    let mut stopped = false;
    let of_stage = |stage: usize| {
        stopped = stopped || watch.stopped_at(stage);
        if stopped { vec![0.0; model.m] } else { inputs(model, rows, &states, stage) }
    };
    let inputs = (0..=model.steps).map(of_stage).collect();
    Iterate { states, inputs }
}

/// Returns the states of a body that follows `poses` (one per node, scaled) in `stretch` times the
/// duration of the problem. With wheels, the total momentum is conserved: the wheels store the
/// difference between the total momentum and the body's momentum.
pub(crate) fn states_along(model: &Model, poses: &[Pose], stretch: f64) -> Vec<ChainState> {
    let j_d = &model.dynamics.j_d;
    let mut states: Vec<ChainState> = Vec::with_capacity(poses.len());
    let (axes, first) = model.channel(false);
    let axes = DMatrix::from_fn(3, model.m - first, |row, column| axes[column][row]);
    let to_wheels = axes.clone().pseudo_inverse(1e-12).unwrap_or_else(|_| axes.transpose());
    let (start, target) = (model.start_in(stretch), model.target_in(stretch));
    let in_space = start.attitude * start.momentum;
    for (stage, pose) in poses.iter().enumerate() {
        let mut state = target.clone();
        (state.position, state.attitude) = (pose.position, pose.attitude);
        if let Some(next) = poses.get(stage + 1) {
            // The step equation `h S(Π) = F J_d − J_d Fᵀ` gives the momentum Π explicitly from the
            // rotation F.
            let h = model.dynamics.grid.step(stage);
            let f = pose.attitude.tr_mul(&step::unturned(model, stage, &next.attitude, stretch));
            state.momentum = vee(&(f * j_d - j_d * f.transpose())) / h;
            state.linear_momentum = (next.position - pose.position) / h;
        }
        if model.wheels > 0 {
            let total = pose.attitude.tr_mul(&in_space);
            let carried = total - state.momentum - model.wheel_momentum(&start.wheels);
            state.wheels = &start.wheels + &to_wheels * DVector::from_column_slice(carried.as_slice());
            state.momentum = total;
        }
        states.push(state);
    }
    states
}

/// Returns the minimum-effort inputs that remove the defect of the momenta in the step into
/// `stage`, clipped to the input limits.
fn inputs(model: &Model, rows: &LimitRows, states: &[ChainState], stage: usize) -> Vec<f64> {
    let zero = vec![0.0; model.m];
    if stage < model.first_input() {
        return zero;
    }
    let end = match stage.checked_sub(1) {
        None => step::opening(model, states[0].stretch, &zero),
        Some(before) => match step::step(model, before, &states[before], &zero) {
            Ok(end) => end,
            Err(_) => return zero,
        },
    };
    let slope = step::by_inputs(model, stage, &end);
    let lack = state::difference(model, &states[stage], &end);
    // Without a positive definite effort weight, the inputs of minimum norm are used.
    let price = model.weight.clone().cholesky().map(|factor| factor.solve(&slope.transpose()));
    let price = price.unwrap_or_else(|| slope.transpose());
    let authority = &slope * &price;
    let threshold = 1e-10 * authority.amax();
    let Ok(inverse) = authority.pseudo_inverse(threshold) else { return zero };
    let mut inputs: Vec<f64> = (price * (inverse * lack)).iter().copied().collect();
    let squared = states[stage].stretch * states[stage].stretch;
    for row in &rows.rows[rows.range(stage)] {
        match row.what {
            What::InputSize { input, limit, .. } => {
                inputs[input] = inputs[input].clamp(-limit * squared, limit * squared)
            }
            What::Push { input, .. } => inputs[input] = inputs[input].max(0.0),
            What::InputNorm { forces, limit } => {
                let limit = limit * squared;
                let (axes, first) = model.channel(forces);
                let output: Vector3 =
                    axes.iter().zip(&inputs[first..]).map(|(axis, input)| axis * *input).sum();
                let size = output.norm();
                if size > limit {
                    inputs[first..first + axes.len()].iter_mut().for_each(|input| *input *= limit / size);
                }
            }
            _ => {}
        }
    }
    inputs
}
