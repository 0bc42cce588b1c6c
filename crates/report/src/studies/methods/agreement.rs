//! Measures how well the results of the methods agree.

use serde::Serialize;
use slewkit::maneuver::{Motion, Outcome, Problem, Rung, Settings, Solution};
use slewkit::optimize::discrete::step::Units;
use slewkit::optimize::search::{self, Guess, Observer, PlanError};
use std::collections::BTreeSet;

/// The verdict on the agreement of the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The costs of all solved runs are equal within [`Agreement::COST_TOLERANCE`].
    Agree,
    /// The costs differ: the methods found different extremals, or one of them has an error.
    Disagree,
    /// Fewer than two methods have a result.
    NothingToCompare,
}

/// The agreement of the results of shooting and SCP. A number is `None` if one of the results is
/// missing.
///
/// Costates are compared at every node, in scaled units and relative to the largest costate, if
/// both results have the same path. If the problem has a symmetry (a rank-deficient sensitivity
/// matrix), the costates of an extremal are not unique and may differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// The verdict on the costs.
    pub verdict: Verdict,
    /// The largest difference between the costs of methods that solved the problem, relative to the
    /// smallest cost.
    pub cost: Option<f64>,
    /// The difference between the duals of the convex iteration, before the final interior-point
    /// solve, and the costates of shooting.
    pub duals_before_polish: Option<f64>,
    /// The difference between the multipliers after the final interior-point solve and the costates
    /// of shooting.
    pub duals_after_polish: Option<f64>,
    /// The difference between the duals before the final interior-point solve and the multipliers
    /// after it.
    pub polish_change: Option<f64>,
    /// True if the costates are unique, because the sensitivity matrix of shooting has full rank.
    pub costates_unique: Option<bool>,
    /// The number of nodes at which a limit is active in only one of the results of shooting and of
    /// the final interior-point solve.
    pub active_nodes_that_differ: Option<usize>,
    /// The result of shooting that starts from the duals of SCP.
    pub from_duals: Option<FromDuals>,
}

/// The result of Newton shooting from `λ_0` of the convex iteration's duals, before the final
/// interior-point solve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FromDuals {
    /// The outcome of shooting.
    pub outcome: Outcome,
    /// The number of Newton steps until the scaled terminal error met the tolerance.
    pub newton_steps: Option<usize>,
    /// The scaled terminal error after each Newton step. The first value belongs to the duals
    /// themselves.
    pub residuals: Vec<f64>,
}

impl Agreement {
    /// The relative difference below which two costs belong to one extremal.
    pub const COST_TOLERANCE: f64 = 1e-9;
    /// The fraction of the unit of cost (a turn by one radian) below which differences between
    /// costs are absolute, not relative.
    const COST_FLOOR: f64 = 1e-6;
}

/// Compares the results. `settings` are the settings of shooting.
pub(super) fn of(
    problem: &Problem,
    settings: &Settings,
    shooting: Option<&Solution>,
    unpolished: &Solution,
    polished: &Solution,
    observer: &mut dyn Observer,
) -> Result<Agreement, PlanError> {
    let converged = |solution: &&Solution| solution.outcome == Outcome::Converged;
    let shooting = shooting.filter(converged);
    let unpolished = Some(unpolished).filter(converged);
    let polished = Some(polished).filter(converged);

    let costs: Vec<f64> =
        [shooting, unpolished, polished].into_iter().flatten().map(|solution| solution.cost).collect();
    let cost = (costs.len() > 1).then(|| spread(problem, &costs));
    let verdict = match cost {
        Some(cost) if cost <= Agreement::COST_TOLERANCE => Verdict::Agree,
        Some(_) => Verdict::Disagree,
        None => Verdict::NothingToCompare,
    };
    let same = |a: Option<&Solution>, b: Option<&Solution>| {
        let (a, b) = (a?, b?);
        same_extremal(problem, a, b)
            .then(|| distance(problem, &a.trajectory.costates, &b.trajectory.costates))
    };
    let from_duals = match (shooting, unpolished) {
        (Some(_), Some(duals)) => Some(from_duals(problem, settings, duals, observer)?),
        _ => None,
    };
    Ok(Agreement {
        verdict,
        cost,
        duals_before_polish: same(unpolished, shooting),
        duals_after_polish: same(polished, shooting),
        polish_change: same(unpolished, polished),
        costates_unique: shooting.map(|shot| shot.optimality.rank == problem.dimension()),
        active_nodes_that_differ: shooting.zip(polished).map(|(a, b)| differing(problem, a, b)),
        from_duals,
    })
}

/// Returns `(largest − smallest)/smallest` of the costs. The denominator is at least a small
/// fraction of the unit of cost.
fn spread(problem: &Problem, costs: &[f64]) -> f64 {
    let floor = Agreement::COST_FLOOR * Units::of(problem).cost;
    let smallest = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = costs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (largest - smallest) / smallest.abs().max(floor)
}

/// The largest angle between the attitudes of two results for the same extremal \[rad\]. It is far
/// above the error of a convex iteration, and far below the difference between two extremals.
const SAME_PATH: f64 = 1e-3;

/// Returns whether two converged results have the same cost and the same path. Two different optima
/// of equal cost, as for a turn by 180°, do not count as the same extremal.
pub(super) fn same_extremal(problem: &Problem, a: &Solution, b: &Solution) -> bool {
    let angle = |(a, b): (&[f64; 4], &[f64; 4])| {
        let chord = |sign: f64| a.iter().zip(b).map(|(a, b)| (a - sign * b).powi(2)).sum::<f64>().sqrt();
        // |q − q'| = 2 sin(θ/4), for the sign of q' that is nearer to q.
        4.0 * (0.5 * chord(1.0).min(chord(-1.0))).min(1.0).asin()
    };
    let (a_path, b_path) = (&a.trajectory.quaternion, &b.trajectory.quaternion);
    let apart = a_path.iter().zip(b_path).map(angle).fold(0.0, f64::max);
    spread(problem, &[a.cost, b.cost]) <= Agreement::COST_TOLERANCE
        && a_path.len() == b_path.len()
        && apart <= SAME_PATH
}

/// Returns whether the first result is cheaper by more than the tolerance for one extremal.
pub(super) fn cheaper(problem: &Problem, a: &Solution, b: &Solution) -> bool {
    a.cost < b.cost && spread(problem, &[a.cost, b.cost]) > Agreement::COST_TOLERANCE
}

/// Returns the largest difference between two histories of costates, in scaled units and relative
/// to the largest costate of the second.
fn distance(problem: &Problem, first: &[f64], second: &[f64]) -> f64 {
    let units = Units::of(problem);
    let scale: Vec<f64> = match problem.motion {
        Motion::Attitude => units.costate::<6>().iter().copied().collect(),
        Motion::RigidBody => units.costate::<12>().iter().copied().collect(),
    };
    if first.len() != second.len() || first.is_empty() {
        return f64::NAN;
    }
    let scaled = |(index, value): (usize, f64)| (value / scale[index % scale.len()]).abs();
    let largest = |values: &mut dyn Iterator<Item = f64>| values.enumerate().map(scaled).fold(0.0, f64::max);
    let difference = largest(&mut first.iter().zip(second).map(|(a, b)| a - b));
    difference / largest(&mut second.iter().copied()).max(Agreement::COST_FLOOR)
}

/// Returns the number of nodes at which a limit is active in only one of the two results, summed
/// over all limits.
fn differing(problem: &Problem, first: &Solution, second: &Solution) -> usize {
    let nodes = |solution: &Solution| -> BTreeSet<(String, usize)> {
        let step = problem.step();
        let of = |active: &slewkit::maneuver::solution::ActiveConstraint| {
            let name = active.name.clone();
            let nodes = active.time_s.iter().map(move |time| (time / step).round() as usize);
            nodes.map(|node| (name.clone(), node)).collect::<Vec<_>>()
        };
        solution.active.iter().flat_map(of).collect()
    };
    nodes(first).symmetric_difference(&nodes(second)).count()
}

fn from_duals(
    problem: &Problem,
    settings: &Settings,
    duals: &Solution,
    observer: &mut dyn Observer,
) -> Result<FromDuals, PlanError> {
    let solution =
        search::solve(problem, settings, Some(&Guess::costates(duals.costates_0(problem))), observer)?;
    let guess = solution.ladder.iter().find(|rung| rung.rung == Rung::Guess);
    let (outcome, residuals) =
        guess.map_or((solution.outcome, Vec::new()), |rung| (rung.outcome, rung.residuals.clone()));
    let newton_steps = residuals.iter().position(|residual| *residual <= settings.tolerance);
    Ok(FromDuals { outcome, newton_steps, residuals })
}
