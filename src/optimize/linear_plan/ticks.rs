//! The motion beside a plan from tick to tick of a controller that holds a correction over several steps.
//!
//! ```text
//! A = A_{n−1} … A_0 ,     B = Σ A_{n−1} … A_{j+1} B_j ,     H = Σ Φ_jᵀ H_j Φ_j ,  Φ_j = A_{j−1} … A_0
//! ```
//!
//! The curvature of what the correction does within the tick is left out of `H`: it changes which gains are the cheapest, not where they
//! lead.

use super::{LinearPlan, LinearStep, Matrix6, Matrix6x3};

/// The motion beside a plan of held torques in ticks of `every` steps, the last of them shorter where they are no divisor. Gains are
/// designed along it; what parameters do stays with the steps.
pub(crate) fn of_ticks(plan: &LinearPlan, every: usize) -> LinearPlan {
    let ticks = plan.steps.chunks(every.max(1));
    let steps = ticks.clone().map(of_tick).collect();
    let firsts = || (0..plan.count()).step_by(every.max(1)).chain([plan.count()]);
    LinearPlan {
        steps,
        times: firsts().map(|node| plan.times[node]).collect(),
        nodes: firsts().map(|node| plan.nodes[node]).collect(),
        ..plan.clone()
    }
}

fn of_tick(steps: &[LinearStep]) -> LinearStep {
    let (mut a, mut b, mut h) = (Matrix6::identity(), Matrix6x3::zeros(), Matrix6::zeros());
    for step in steps {
        h += a.transpose() * step.h * a;
        b = step.a * b + step.b;
        a = step.a * a;
    }
    // What an input can give over the whole tick: where the most of them are at their limits.
    let authority = |step: &&LinearStep| step.authority.trace();
    let least = steps.iter().min_by(|one, other| authority(one).total_cmp(&authority(other)));
    let least = least.unwrap_or(&steps[0]);
    LinearStep { a, b, h, length: steps.iter().map(|step| step.length).sum(), ..least.clone() }
}
