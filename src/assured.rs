//! A plan with what is known of how it will be flown: gains, covariances, and chances that constraints keep.
//!
//! A constraint with a chance p keeps the distance that the closed loop needs, `θ − α ≥ Φ⁻¹(1 − p) σ`, with σ along the plan under
//! its own gains: the margin depends on the plan, and the plan on the margin. So it is iterated, each plan from the one before, until
//! both agree.
//!
//! That is the chance of an instant, to first order. The chance of violating a constraint at any time of the motion is more, and no
//! sum over instants, whose errors are one error: it is counted in flights of the closed loop (`closed_loop`), with the same random
//! numbers for every plan. A margin moves what is left of the constraint by itself, so the next margin is
//!
//! ```text
//! m ← m − q ,    q: what is left in the case than which the part p of the cases have less
//! ```

use crate::closed_loop::{Campaign, Flown, Lost, Plant, Proportion, quantile};
use crate::feedback::{Gains, Kind, NoGains, SwitchingGains};
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
    /// How long its arcs last from other starts, where that is corrected.
    pub switching: Option<SwitchingGains>,
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
        let switching = match feedback {
            // What the correction at the start makes of a covariance is not known.
            Some(Kind::Switching(_)) if uncertainty.is_some() => return Err(NoGains::MovedStart.into()),
            Some(Kind::Switching(_)) => Some(SwitchingGains::along(problem, plan)?),
            _ => None,
        };
        let open = uncertainty.map(|uncertainty| Covariance::along(&linear, None, uncertainty));
        let closed = match (uncertainty, &gains) {
            (Some(uncertainty), Some(gains)) => Some(Covariance::along(&linear, Some(gains), uncertainty)),
            _ => None,
        };
        let acts = closed.as_ref().or(open.as_ref());
        let chances = acts.map_or(Vec::new(), |covariance| Chance::of_cones(problem, &linear, covariance));
        Ok(Self { linear, gains, switching, open, closed, chances })
    }
}

/// A chance that a constraint is to keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept<'a> {
    /// Name of the constraint.
    pub constraint: &'a str,
    /// The chance of violating it, at most.
    pub at_most: f64,
    /// When.
    pub over: Over,
}

/// When a constraint may be violated with its chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Over {
    /// At the node of the largest chance, to first order.
    Instant,
    /// At any time of the motion, between the nodes too, in flights by this plant.
    Motion(Plant),
}

impl Over {
    /// The least chance of a motion that can be counted.
    pub const LEAST: f64 = 1e-4;

    /// Cases that violate a constraint with its chance, of those that are flown: the chance is known to a tenth.
    const VIOLATING: f64 = 100.0;

    /// Of long plans so many at least.
    const FEWEST: f64 = 20.0;

    /// Steps that are flown for a plan: some seconds.
    const STEPS: f64 = 2e7;

    /// Flights that count a chance along a plan of so many steps.
    fn flights(chance: f64, steps: usize) -> usize {
        let most = Self::STEPS / steps.max(1) as f64;
        (Self::VIOLATING / chance).min(most).max(Self::FEWEST / chance).ceil() as usize
    }
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
    /// Of each whose chance is that of a motion how many of the flights of the plan violate it.
    pub counted: Vec<Option<Proportion>>,
}

/// Margins that differ by less are one \[rad\]: a hundredth of what witnesses allow a cone.
const SAME_MARGIN: f64 = 1e-8;

/// Margins that were counted and differ by less than this part of a deviation are one: it changes a chance by some hundredths.
const SAME_COUNTED: f64 = 0.01;

/// Seed of the flights that are counted: not that of `slew fly`, which so judges the margin by other cases.
const SEED: u64 = 0x6368_616e_6365;

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
        let needed: Vec<Needed> =
            chances.iter().map(|kept| Needed::of(kept, &beside, &on_grid, problem, uncertainty)).collect();
        margins.counted = needed.iter().map(|needed| needed.counted).collect();
        let agrees = |(needed, margin): (&Needed, &f64)| (needed.margin - margin).abs() <= needed.same;
        if needed.iter().zip(&margins.margins).all(agrees) {
            margins.agreed = true;
            break;
        }
        let needed: Vec<f64> = needed.iter().map(|needed| needed.margin).collect();
        if !needed.iter().all(|margin| margin.is_finite()) {
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

/// The margin that a chance takes beside a plan, at least the one that is asked for.
struct Needed {
    margin: f64,
    /// Margins that differ by less are one.
    same: f64,
    counted: Option<Proportion>,
}

impl Needed {
    fn of(
        kept: &Kept,
        beside: &Beside,
        planned: &Problem,
        asked: &Problem,
        uncertainty: &Uncertainty,
    ) -> Self {
        let least = margin(asked, kept.constraint);
        let chance = beside.chances.iter().find(|chance| chance.name == kept.constraint);
        let sigma = chance.map_or(0.0, |chance| chance.sigma);
        let Over::Motion(plant) = kept.over else {
            let margin = (normal_quantile(1.0 - kept.at_most) * sigma).max(least);
            return Self { margin, same: SAME_MARGIN, counted: None };
        };
        let left = left(kept, beside, planned, uncertainty, plant);
        let violated = left.iter().filter(|left| **left < 0.0).count();
        Self {
            margin: (margin(planned, kept.constraint) - quantile(&left, kept.at_most)).max(least),
            same: (SAME_COUNTED * sigma).max(SAME_MARGIN),
            counted: Some(Proportion::new(violated as u64, left.len() as u64)),
        }
    }
}

/// What flights leave of a constraint without its margin, sorted; a case that was lost leaves nothing of it.
fn left(
    kept: &Kept,
    beside: &Beside,
    planned: &Problem,
    uncertainty: &Uncertainty,
    plant: Plant,
) -> Vec<f64> {
    /// Cases that are held at once.
    const CHUNK: usize = 8192;
    let named = |constraint: &crate::maneuver::Constraint| constraint.name == kept.constraint;
    let Some(index) = planned.constraints.iter().position(named) else { return Vec::new() };
    let gains = beside.gains.as_ref();
    let campaign = Campaign::new(planned, &beside.linear, gains, uncertainty, plant, SEED);
    let cases = Over::flights(kept.at_most, beside.linear.count());
    let room = |case: Result<Flown, Lost>| case.map_or(f64::NEG_INFINITY, |flown| flown.room[index]);
    let mut left: Vec<f64> = (0..cases)
        .step_by(CHUNK)
        .flat_map(|first| campaign.fly_all(first as u64, CHUNK.min(cases - first)))
        .map(room)
        .collect();
    left.sort_by(f64::total_cmp);
    left
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
