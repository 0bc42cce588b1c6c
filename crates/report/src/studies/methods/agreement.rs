//! Agreement of the results of different methods.

use serde::Serialize;
use slewkit::maneuver::{Motion, Outcome, Problem, Rung, Settings, Solution};
use slewkit::optimize::discrete::step::Units;
use slewkit::optimize::search::{self, Guess, Observer, PlanError};
use std::collections::BTreeSet;

/// Verdict on whether the results of the methods agree.
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

/// Agreement of the results of shooting and SCP. A number is `None` if one of the two results is
/// missing.
///
/// Costates are compared if both results follow the same path. They are compared at every node, in
/// scaled units, and the difference is divided by the largest costate. If the problem has a
/// symmetry, the sensitivity matrix is rank-deficient. The costates of an extremal are then not
/// unique and may differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Verdict on whether the costs of the methods agree.
    pub verdict: Verdict,
    /// Largest difference between the costs of the methods that solved the problem, as a fraction
    /// of the smallest cost.
    pub cost: Option<f64>,
    /// Difference between the costates of shooting and the duals of SCP before the final
    /// interior-point solve.
    pub duals_before_polish: Option<f64>,
    /// Difference between the costates of shooting and the multipliers of SCP after the final
    /// interior-point solve.
    pub duals_after_polish: Option<f64>,
    /// Difference between the duals of SCP before the final interior-point solve and the
    /// multipliers after it.
    pub polish_change: Option<f64>,
    /// True if the costates are unique, because the sensitivity matrix of shooting has full rank.
    pub costates_unique: Option<bool>,
    /// Number of nodes at which a limit is active in the result of shooting but not after the final
    /// interior-point solve, or vice versa.
    pub active_nodes_that_differ: Option<usize>,
    /// The result of shooting that starts from the duals of SCP.
    pub from_duals: Option<FromDuals>,
}

/// Result of Newton shooting that starts from the costates `λ_0` given by the duals of SCP before
/// the final interior-point solve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FromDuals {
    /// Outcome of the shooting method.
    pub outcome: Outcome,
    /// The number of Newton steps until the scaled terminal error met the tolerance.
    pub newton_steps: Option<usize>,
    /// Scaled terminal error after each Newton step. The first value is the error before the first
    /// step.
    pub residuals: Vec<f64>,
}

impl Agreement {
    /// Largest relative difference between two costs of the same extremal.
    pub const COST_TOLERANCE: f64 = 1e-9;
    /// Fraction of the unit of cost (the cost of a turn by one radian) below which a difference
    /// between costs is divided by this fraction instead of the cost.
    const COST_FLOOR: f64 = 1e-6;
}

/// Compares the results of the methods. `settings` are the settings of shooting.
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

/// Returns the relative difference `(largest − smallest)/smallest` of the costs. The denominator is
/// at least [`Agreement::COST_FLOOR`] times the unit of cost.
fn spread(problem: &Problem, costs: &[f64]) -> f64 {
    let floor = Agreement::COST_FLOOR * Units::of(problem).cost;
    let smallest = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = costs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (largest - smallest) / smallest.abs().max(floor)
}

/// Largest angle between the attitudes of two results that count as the same path \[rad\]. It is
/// far above the error of SCP, and far below the angle between two extremals.
const SAME_PATH: f64 = 1e-3;

/// Returns whether two converged results have the same cost and follow the same path. Two different
/// optima of equal cost, as for a turn by 180°, are not the same extremal.
pub(super) fn same_extremal(problem: &Problem, a: &Solution, b: &Solution) -> bool {
    let angle = |(a, b): (&[f64; 4], &[f64; 4])| {
        let chord = |sign: f64| a.iter().zip(b).map(|(a, b)| (a - sign * b).powi(2)).sum::<f64>().sqrt();
        // |q − q'| = 2 sin(θ/4), where the sign of q' is chosen to be nearer to q.
        4.0 * (0.5 * chord(1.0).min(chord(-1.0))).min(1.0).asin()
    };
    let (a_path, b_path) = (&a.trajectory.quaternion, &b.trajectory.quaternion);
    let apart = a_path.iter().zip(b_path).map(angle).fold(0.0, f64::max);
    spread(problem, &[a.cost, b.cost]) <= Agreement::COST_TOLERANCE
        && a_path.len() == b_path.len()
        && apart <= SAME_PATH
}

/// Returns whether the cost of the first result is lower by more than the tolerance for the same
/// extremal.
pub(super) fn cheaper(problem: &Problem, a: &Solution, b: &Solution) -> bool {
    a.cost < b.cost && spread(problem, &[a.cost, b.cost]) > Agreement::COST_TOLERANCE
}

/// Returns the largest difference between two histories of costates in scaled units, divided by the
/// largest costate of the second history.
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
