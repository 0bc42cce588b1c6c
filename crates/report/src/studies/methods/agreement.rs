//! The agreement of the answers.

use serde::Serialize;
use slewkit::maneuver::{Motion, Outcome, Problem, Rung, Settings, Solution};
use slewkit::optimize::discrete::step::Units;
use slewkit::optimize::search::{self, Guess, Observer, PlanError};
use std::collections::BTreeSet;

/// Whether the answers agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The costs of all solved runs are equal within [`Agreement::COST_TOLERANCE`].
    Agree,
    /// They are not: two extremals, or an error.
    Disagree,
    /// Fewer than two methods have an answer.
    NothingToCompare,
}

/// The agreement of the answers of shooting and SCP. A number is absent if one of the answers is.
///
/// Costates are compared at every node, in scaled units, relative to the largest, and only between
/// answers with one path. If the problem has a symmetry (a sensitivity matrix without full rank),
/// the costates of one extremal are not unique, and may differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Whether the costs agree.
    pub verdict: Verdict,
    /// Largest difference of costs between methods that solved, relative to the smallest.
    pub cost: Option<f64>,
    /// Duals of the convex iteration before polish against the shooting's costates.
    pub duals_before_polish: Option<f64>,
    /// The difference between the multipliers after polish and the shooting's costates.
    pub duals_after_polish: Option<f64>,
    /// The difference of the duals before polish and the multipliers after it.
    pub polish_change: Option<f64>,
    /// Whether the costates are unique: full rank of the shooting's sensitivity matrix.
    pub costates_unique: Option<bool>,
    /// Nodes at which one of shooting and polish has a limit active and the other has not.
    pub active_nodes_that_differ: Option<usize>,
    /// The shooting started from the duals.
    pub from_duals: Option<FromDuals>,
}

/// Newton shooting from `λ_0` of the convex iteration's duals, before polish.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FromDuals {
    /// The outcome.
    pub outcome: Outcome,
    /// The number of Newton steps until the scaled terminal error met the tolerance.
    pub newton_steps: Option<usize>,
    /// The scaled terminal error after each step, the first of the duals themselves.
    pub residuals: Vec<f64>,
}

impl Agreement {
    /// The relative difference below which two costs belong to one extremal.
    pub const COST_TOLERANCE: f64 = 1e-9;
    /// Costs below this share of the unit of cost (a turn by one radian) differ absolutely.
    const COST_FLOOR: f64 = 1e-6;
}

/// Compares the answers; `settings` are the settings of the shooting.
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

/// Returns `(largest − smallest)/smallest`, the denominator not below a small share of the unit of
/// cost.
fn spread(problem: &Problem, costs: &[f64]) -> f64 {
    let floor = Agreement::COST_FLOOR * Units::of(problem).cost;
    let smallest = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = costs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (largest - smallest) / smallest.abs().max(floor)
}

/// The largest angle between the attitudes of two answers with one extremal \[rad\]: far above
/// the error of a convex iteration, far below the difference of two extremals.
const SAME_PATH: f64 = 1e-3;

/// Returns whether two converged answers have the same cost and go the same way; two optima of
/// equal cost, as of a turn by 180°, are not one.
pub(super) fn same_extremal(problem: &Problem, a: &Solution, b: &Solution) -> bool {
    let angle = |(a, b): (&[f64; 4], &[f64; 4])| {
        let chord = |sign: f64| a.iter().zip(b).map(|(a, b)| (a - sign * b).powi(2)).sum::<f64>().sqrt();
        // |q − q'| = 2 sin(θ/4), whichever sign is nearer.
        4.0 * (0.5 * chord(1.0).min(chord(-1.0))).min(1.0).asin()
    };
    let (a_path, b_path) = (&a.trajectory.quaternion, &b.trajectory.quaternion);
    let apart = a_path.iter().zip(b_path).map(angle).fold(0.0, f64::max);
    spread(problem, &[a.cost, b.cost]) <= Agreement::COST_TOLERANCE
        && a_path.len() == b_path.len()
        && apart <= SAME_PATH
}

/// Returns whether the first answer is cheaper by more than costs of one extremal differ.
pub(super) fn cheaper(problem: &Problem, a: &Solution, b: &Solution) -> bool {
    a.cost < b.cost && spread(problem, &[a.cost, b.cost]) > Agreement::COST_TOLERANCE
}

/// Returns the largest difference of two histories of costates, scaled, relative to the largest of
/// the second.
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

/// Returns the nodes of every limit at which only one of the two has it acting.
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
