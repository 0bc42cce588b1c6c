//! The motion beside a plan from tick to tick of a controller that holds a correction over several
//! steps.
//!
//! Step after step under one `v` is a step (`linear_plan::stage`): `z` and `δλ` between the two are
//! put into both.
//!
//! ```text
//! A = A₂A₁ ,     B = A₂B₁ + B₂ ,     H = H₁ + A₁ᵀH₂A₁ ,     N = N₁ + A₁ᵀM ,     M = H₂B₁ + N₂
//! V = V₁ + V₂A₁ + B₁ᵀH₂A₁ ,          U = U₁ + U₂ + V₂B₁ + B₁ᵀM
//! ```

use super::{LinearPlan, LinearStep, PosedPlan, Stage, Stages};
use nalgebra::SMatrix;

/// The motion beside a plan of held torques in ticks of `every` steps, the last of them shorter
/// where they are no divisor. Gains are designed along it; what parameters do stays with the steps.
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

/// The same of a plan of poses.
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

/// Steps under one correction, and which of them gives its authority: what an input can give over
/// the whole tick is what it can where the most of them are at their limits.
fn together<'a, const N: usize, const C: usize>(
    steps: impl Iterator<Item = &'a Stage<N, C>> + Clone,
) -> (Stage<N, C>, usize) {
    let authorities = steps.clone().map(|stage| stage.authority).enumerate();
    let least = authorities.min_by(|one, other| one.1.trace().total_cmp(&other.1.trace()));
    let (index, authority) = least.unwrap_or((0, SMatrix::zeros()));
    (Stage { authority, ..steps.fold(Stage::none(), |before, after| before.then(after)) }, index)
}
