//! A plan with what is known of how it will be flown: gains, covariances, and chances that constraints keep.
//!
//! A constraint with a chance p keeps the distance that the closed loop needs, `θ − α ≥ Φ⁻¹(1 − p) σ`, with σ along the plan under
//! its own gains: the margin depends on the plan, and the plan on the margin. So it is iterated, each plan from the one before, until
//! both agree.

use crate::feedback::{Gains, Kind, NoGains};
use crate::maneuver::{Problem, Rule, Settings, Trajectory};
use crate::optimize::linear_plan::{LinearPlan, Unlinearised};
use crate::plan::{self, Guess, Observer, Plan, PlanError, Status};
use crate::uncertainty::chance::{Chance, normal_quantile};
use crate::uncertainty::{Covariance, Uncertainty};
use thiserror::Error;

/// What is known of a plan beside it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Beside {
    /// The motion beside the plan, to first order, of the torques that are held.
    pub linear: LinearPlan,
    /// Gains along it.
    pub gains: Option<Gains>,
    /// Covariance without gains.
    pub open: Option<Covariance>,
    /// Covariance under them.
    pub closed: Option<Covariance>,
    /// Chances of the cones under the gains, or without where there are none.
    pub chances: Vec<Chance>,
}

/// Why nothing is known of a plan beside it.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotKnown {
    /// The motion is not linearised.
    #[error("{0}")]
    Unlinearised(#[from] Unlinearised),
    /// There are no gains.
    #[error("{0}")]
    NoGains(#[from] NoGains),
}

impl Beside {
    /// Along a plan of `problem`, which is on the grid of the plan ([`Solution::on_grid`]).
    ///
    /// [`Solution::on_grid`]: crate::maneuver::Solution::on_grid
    ///
    /// # Errors
    /// [`NotKnown`].
    pub fn along(
        problem: &Problem,
        plan: &Trajectory,
        feedback: Option<Kind>,
        uncertainty: Option<&Uncertainty>,
    ) -> Result<Self, NotKnown> {
        let linear = LinearPlan::flown(problem, plan)?;
        let gains = feedback.map(|kind| Gains::along(&linear, kind, problem.switches())).transpose()?;
        let open = uncertainty.map(|uncertainty| Covariance::along(&linear, None, uncertainty));
        let closed = match (uncertainty, &gains) {
            (Some(uncertainty), Some(gains)) => Some(Covariance::along(&linear, Some(gains), uncertainty)),
            _ => None,
        };
        let acts = closed.as_ref().or(open.as_ref());
        let chances = acts.map_or(Vec::new(), |covariance| Chance::of_cones(problem, &linear, covariance));
        Ok(Self { linear, gains, open, closed, chances })
    }
}

/// A chance that a constraint is to keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept<'a> {
    /// Name of the constraint.
    pub constraint: &'a str,
    /// The chance of violating it at its worst instant, at most.
    pub at_most: f64,
}

/// What keeping chances took.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Margins {
    /// Margin of each constraint with a chance, in their order \[rad\].
    pub margins: Vec<f64>,
    /// Cost of the plan without margins.
    pub cost_without: f64,
    /// Plans until margins and covariances agreed.
    pub plans: usize,
    /// Whether they did; else the plan is the last of them.
    pub agreed: bool,
}

/// Margins that differ by less are one \[rad\]: a hundredth of what witnesses allow a cone.
const SAME_MARGIN: f64 = 1e-8;

/// Plans at most: margins settle by a factor of some tens a plan.
const MOST_PLANS: usize = 12;

/// Plans a maneuver of which some constraints keep a chance; also the maneuver with the margins that this takes.
///
/// # Errors
/// [`PlanError`], as of [`plan::plan`]: an end that is too near to a cone for its chance is one.
pub fn plan(
    problem: &Problem,
    settings: &Settings,
    feedback: Option<Kind>,
    uncertainty: &Uncertainty,
    chances: &[Kept],
    observer: &mut dyn Observer,
) -> Result<(Problem, Plan, Margins), PlanError> {
    let mut found = plan::plan(problem, settings, None, observer)?;
    let mut with = problem.clone();
    let mut margins = Margins { cost_without: found.solution.cost, plans: 1, ..Margins::default() };
    margins.margins = chances.iter().map(|kept| margin(&with, kept.constraint)).collect();
    while found.status == Status::Solved && margins.plans < MOST_PLANS {
        let on_grid = found.solution.on_grid(&with);
        let Ok(beside) = Beside::along(&on_grid, &found.solution.trajectory, feedback, Some(uncertainty))
        else {
            break;
        };
        let needed: Vec<f64> = chances.iter().map(|kept| needed(kept, &beside, problem)).collect();
        let apart = needed.iter().zip(&margins.margins).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if apart <= SAME_MARGIN {
            margins.agreed = true;
            break;
        }
        for (kept, needed) in chances.iter().zip(&needed) {
            set_margin(&mut with, kept.constraint, *needed);
        }
        let guess = Guess::of(&found.solution, &with);
        found = plan::plan(&with, settings, Some(&guess), observer)?;
        margins.margins = needed;
        margins.plans += 1;
    }
    Ok((with, found, margins))
}

/// The margin that a chance takes beside this plan, at least the one that is asked for.
fn needed(kept: &Kept, beside: &Beside, asked: &Problem) -> f64 {
    let least = margin(asked, kept.constraint);
    let chance = beside.chances.iter().find(|chance| chance.name == kept.constraint);
    chance.map_or(least, |chance| (normal_quantile(1.0 - kept.at_most) * chance.sigma).max(least))
}

fn margin(problem: &Problem, name: &str) -> f64 {
    let constraint = problem.constraints.iter().find(|constraint| constraint.name == name);
    match constraint.map(|constraint| &constraint.rule) {
        Some(Rule::Pointing(pointing)) => pointing.margin,
        _ => 0.0,
    }
}

fn set_margin(problem: &mut Problem, name: &str, margin: f64) {
    for constraint in &mut problem.constraints {
        if let (true, Rule::Pointing(pointing)) = (constraint.name == name, &mut constraint.rule) {
            pointing.margin = margin;
        }
    }
}

#[cfg(test)]
mod tests;
