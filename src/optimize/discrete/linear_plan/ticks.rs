//! The linearised motion near a plan between the ticks of a controller that holds a correction over
//! several steps.
//!
//! Consecutive steps under one correction `v` form one step (`linear_plan::stage`): the
//! intermediate `z` and `δλ` are eliminated.
//!
//! ```text
//! A = A₂A₁ ,     B = A₂B₁ + B₂ ,     H = H₁ + A₁ᵀH₂A₁ ,     N = N₁ + A₁ᵀM ,     M = H₂B₁ + N₂
//! V = V₁ + V₂A₁ + B₁ᵀH₂A₁ ,          U = U₁ + U₂ + V₂B₁ + B₁ᵀM
//! ```

use super::{LinearPlan, LinearStep, PosedPlan, Stage, Stages};
use nalgebra::SMatrix;

/// Returns a linearised plan whose torques are held over ticks of `every` steps. The last tick is
/// shorter if `every` does not divide the number of steps. Gains are designed on the ticks; the
/// effect of parameters is still computed on the steps.
pub(crate) fn of_ticks(plan: &LinearPlan, every: usize) -> LinearPlan {
    let firsts = || (0..plan.count()).step_by(every.max(1)).chain([plan.count()]);
    LinearPlan {
        steps: plan.steps.chunks(every.max(1)).map(of_tick).collect(),
        times: firsts().map(|node| plan.times[node]).collect(),
        nodes: firsts().map(|node| plan.nodes[node]).collect(),
        stored: firsts().filter_map(|node| plan.stored.get(node).copied()).collect(),
        stops: plan.stops.iter().map(|node| node.div_ceil(every.max(1))).collect(),
        ..plan.clone()
    }
}

/// Returns the linearised plan of position and attitude, with corrections held over ticks of
/// `every` steps.
pub(crate) fn of_posed_ticks(plan: &PosedPlan, every: usize) -> PosedPlan {
    fn of<const N: usize, const C: usize>(
        stages: &[Stage<N, C>],
        every: usize,
    ) -> (Vec<Stage<N, C>>, Vec<usize>) {
        stages
            .chunks(every)
            .enumerate()
            .map(|(tick, steps)| {
                let (stage, least) = together(steps.iter());
                (stage, tick * every + least)
            })
            .unzip()
    }
    let (stages, least) = match &plan.stages {
        Stages::Attitude(stages) => {
            let (stages, least) = of(stages, every.max(1));
            (Stages::Attitude(stages), least)
        }
        Stages::Pose(stages) => {
            let (stages, least) = of(stages, every.max(1));
            (Stages::Pose(stages), least)
        }
    };
    let to_inputs = least.iter().map(|step| plan.to_inputs[*step].clone()).collect();
    PosedPlan { stages, to_inputs, ..plan.clone() }
}

fn of_tick(steps: &[LinearStep]) -> LinearStep {
    let (mut stage, least) = together(steps.iter().map(|step| &step.stage));
    let of_wheels = || steps.iter().filter_map(|step| step.with_wheels.as_deref());
    let with_wheels = of_wheels().next().map(|_| Box::new(together(of_wheels()).0));
    if let Some(with_wheels) = &with_wheels {
        stage.given_by_wheels(with_wheels);
    }
    LinearStep { stage, with_wheels, ..steps[least].clone() }
}

/// Composes the steps under one correction. Returns the composed step, and the index of the step
/// with the smallest authority. Its authority is used for the whole tick, because most inputs are
/// at their limits in that step.
fn together<'a, const N: usize, const C: usize>(
    steps: impl Iterator<Item = &'a Stage<N, C>> + Clone,
) -> (Stage<N, C>, usize) {
    let authorities = steps.clone().map(|stage| stage.authority).enumerate();
    let least = authorities.min_by(|one, other| one.1.trace().total_cmp(&other.1.trace()));
    let (index, authority) = least.unwrap_or((0, SMatrix::zeros()));
    (Stage { authority, ..steps.fold(Stage::none(), |before, after| before.then(after)) }, index)
}
