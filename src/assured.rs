//! A plan with data for its flight: gains, covariances, and chances of limits.
//!
//! A limit with a chance p keeps the room that the closed loop needs, `room ≥ z σ`,
//! `z = Φ⁻¹(1 − p)`, with σ along the plan under its own gains. The room is a margin of a cone, or
//! a reserve of a rate, of the torque of each input, or of its rate of change. The margin depends
//! on the plan, and the plan on the margin. Both are iterated, each plan starting from the last
//! one, until they agree.
//!
//! This is the chance at an instant, to first order. The chance of exceeding a limit at any time
//! of the motion is larger. It is not a sum over instants, because their errors are correlated:
//! it is counted in flights of the closed loop (`closed_loop`), with equal random numbers for
//! every plan. Several limits may have a joint chance that any of them is exceeded. They then
//! have one z, as if each were equally likely at its worst instant. A margin shifts the distance
//! to its own limit, so the next z is
//!
//! ```text
//! z ← z − q ,    q: the quantile p, over the cases, of the room within the limits, in σ
//! ```

mod group;
mod limit;

use crate::closed_loop::{Plant, Proportion};
use crate::feedback::{Gains, Kind, NoGains, RegulatorWeights, SwitchingGains};
use crate::maneuver::{Problem, Settings, Trajectory};
use crate::numerics::figures::significant;
use crate::optimize::discrete::linear_plan::ticks::{of_posed_ticks, of_ticks};
use crate::optimize::discrete::linear_plan::{LinearPlan, PosedPlan, Unlinearised};
use crate::plan::{self, Guess, Observer, Plan, PlanError, Status};
use crate::uncertainty::chance::{Chance, Quantity};
use crate::uncertainty::{Covariance, Uncertainty};
use group::{Flights, Group, Needed};
use limit::Limit;
use thiserror::Error;

/// Gains, and the time between two corrections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedback {
    /// The design of the gains.
    pub kind: Kind,
    /// Time between two measurements, a whole number of steps, over which a correction is held
    /// \[s\]; 0: the step.
    pub every: f64,
}

impl From<Kind> for Feedback {
    fn from(kind: Kind) -> Self {
        Self { kind, every: 0.0 }
    }
}

/// The quantities near a plan: gains, covariances and chances.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Beside {
    /// The motion near the plan, to first order, under held torques.
    pub linear: LinearPlan,
    /// Gains along the plan.
    pub gains: Option<Gains>,
    /// The lengths of its arcs from other starts, if the start is corrected.
    pub switching: Option<SwitchingGains>,
    /// Covariance without gains.
    pub open: Option<Covariance>,
    /// Covariance with the gains.
    pub closed: Option<Covariance>,
    /// The chances of the constraints, with gains if the plan has any; then the chances of the
    /// limits of the torques, with gains.
    pub chances: Vec<Chance>,
}

/// The reason for which no gains or covariances near a plan are known.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotKnown {
    /// The motion is not linearised.
    #[error("{0}")]
    Unlinearised(#[from] Unlinearised),
    /// No gains exist.
    #[error("{0}")]
    NoGains(#[from] NoGains),
    /// A tick of the loop is not a whole number of equal steps.
    #[error(
        "a tick of {every} s is not a whole number of the {steps} steps of this plan, which last \
        {duration} s"
    )]
    Tick {
        /// The tick.
        every: String,
        /// Number of steps.
        steps: usize,
        /// The duration of all steps together.
        duration: String,
    },
}

impl Beside {
    /// Computes the quantities near a plan of `problem`, which must be on the grid of the plan
    /// ([`Solution::on_grid`]).
    ///
    /// [`Solution::on_grid`]: crate::maneuver::Solution::on_grid
    ///
    /// # Errors
    /// [`NotKnown`].
    pub fn along(
        problem: &Problem,
        plan: &Trajectory,
        feedback: Option<Feedback>,
        uncertainty: Option<&Uncertainty>,
    ) -> Result<Self, NotKnown> {
        // The corrections may use the reserve that the plan holds of the limits of the inputs.
        let linear = LinearPlan::flown(&problem.of_craft(), plan)?;
        Self::near(problem, plan, linear, feedback, uncertainty)
    }

    /// Computes the quantities near a recorded motion of `problem`, which holds one row of inputs
    /// over each of its steps ([`Stepping::Recorded`]). The craft has to meet it at its end and at
    /// `stops`, nodes in ascending order.
    ///
    /// [`Stepping::Recorded`]: crate::maneuver::Stepping::Recorded
    ///
    /// # Errors
    /// [`NotKnown`].
    pub fn along_motion(
        problem: &Problem,
        motion: &Trajectory,
        stops: Vec<usize>,
        feedback: Option<Feedback>,
        uncertainty: Option<&Uncertainty>,
    ) -> Result<Self, NotKnown> {
        let linear = LinearPlan::recorded(&problem.of_craft(), motion, stops)?;
        Self::near(problem, motion, linear, feedback, uncertainty)
    }

    fn near(
        problem: &Problem,
        plan: &Trajectory,
        linear: LinearPlan,
        feedback: Option<Feedback>,
        uncertainty: Option<&Uncertainty>,
    ) -> Result<Self, NotKnown> {
        let gains = feedback.map(|feedback| feedback.along(&linear, problem)).transpose()?;
        let switching = match feedback.map(|feedback| feedback.kind) {
            // The effect of the correction at the start on a covariance is unknown.
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
        let of = |covariance| {
            let mut chances = Chance::of_constraints(problem, &linear, covariance);
            chances.extend(Chance::of_limits(problem, &linear, covariance));
            chances
        };
        let chances = acts.map_or(Vec::new(), of);
        Ok(Self { linear, gains, switching, open, closed, chances })
    }
}

impl Feedback {
    /// Returns this feedback with `weights` for a regulator without weights of its own.
    #[must_use]
    pub fn with_default_weights(self, weights: RegulatorWeights) -> Self {
        let kind = match self.kind {
            Kind::Tvlqr(None) => Kind::Tvlqr(Some(weights)),
            kind => kind,
        };
        Self { kind, ..self }
    }

    /// The part of a step by which a tick may differ from a whole number of steps.
    const WHOLE: f64 = 1e-6;

    /// Returns the number of steps in a tick, for a plan with these nodes \[s\].
    fn steps(&self, times: &[f64]) -> Result<usize, NotKnown> {
        let (duration, count) = (times[times.len() - 1], times.len() - 1);
        let step = duration / count as f64;
        if self.every <= 0.0 {
            return Ok(1);
        }
        let steps = (self.every / step).round();
        let equal = times.windows(2).all(|ends| (ends[1] - ends[0] - step).abs() <= Self::WHOLE * step);
        let whole = (self.every / step - steps).abs() <= Self::WHOLE * steps;
        if !(equal && whole && steps <= count as f64) {
            let [every, duration] = [self.every, duration].map(|time| significant(time, 6));
            return Err(NotKnown::Tick { every, steps: count, duration });
        }
        Ok(steps as usize)
    }

    fn along(&self, linear: &LinearPlan, problem: &Problem) -> Result<Gains, NotKnown> {
        let every = self.steps(linear.times())?;
        if every == 1 {
            return Ok(Gains::along(linear, self.kind, problem.switches())?);
        }
        let gains = Gains::along(&of_ticks(linear, every), self.kind, problem.switches())?;
        Ok(gains.held_over(every, linear.count()))
    }

    /// Designs gains along a plan without a covariance: for a body that translates, or with
    /// torques fixed in the reference frame ([`PosedPlan::is_of`]).
    ///
    /// # Errors
    /// [`NotKnown`].
    pub fn along_pose(&self, problem: &Problem, plan: &Trajectory) -> Result<Gains, NotKnown> {
        let linear = PosedPlan::flown(&problem.of_craft(), plan)?;
        let every = self.steps(&plan.time)?;
        let gains = Gains::along_pose(&of_posed_ticks(&linear, every), self.kind, problem.switches())?;
        Ok(gains.held_over(every, linear.count()))
    }
}

/// A chance that limits are to keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept<'a> {
    /// Names of constraints, and of limits of the torques as reports call them ("torque limit").
    /// Over an instant each keeps the chance, over a motion all together.
    pub limits: Vec<&'a str>,
    /// Largest chance allowed of exceeding the limit, or any of several limits.
    pub at_most: f64,
    /// The time to which the chance refers.
    pub over: Over,
}

/// The time to which a chance refers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Over {
    /// The chance at the node with the largest chance, to first order.
    Instant,
    /// The chance at any time of the motion, also between the nodes, counted in flights with this
    /// plant.
    Motion(Plant),
}

impl Over {
    /// The least chance of a motion that can be counted.
    pub const LEAST: f64 = 1e-4;

    /// Number of flown cases that are expected to violate a constraint. This number gives the
    /// chance to a tenth.
    const VIOLATING: f64 = 100.0;

    /// The least number of violations that the flights of long plans should count.
    const FEWEST: f64 = 20.0;

    /// The number of steps that are flown for a plan: some seconds.
    const STEPS: f64 = 2e7;

    /// Returns the number of flights that count a chance along a plan of this many steps.
    fn flights(chance: f64, steps: usize) -> usize {
        let most = Self::STEPS / steps.max(1) as f64;
        (Self::VIOLATING / chance).min(most).max(Self::FEWEST / chance).ceil() as usize
    }
}

/// The part of a limit that a plan holds in reserve.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Held {
    /// The name of the limit.
    pub name: String,
    /// The limited quantity.
    pub quantity: Quantity,
    /// The reserve: one number for a cone or a norm, else one for each component or input, SI.
    pub parts: Vec<f64>,
    /// The limits of the craft for each part; infinite for a cone.
    pub bounds: Vec<f64>,
}

/// The result of the iteration of margins.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Margins {
    /// The reserve of each limit with a chance, in their order.
    pub held: Vec<Held>,
    /// Cost of the plan without margins.
    pub cost_without: f64,
    /// Plans until margins and covariances agreed.
    pub plans: usize,
    /// Whether margins and covariances agreed. If not, the plan is the last of [`Margins::plans`].
    pub agreed: bool,
    /// For each chance over the motion: the proportion of flights that exceed a limit.
    pub counted: Vec<Option<Proportion>>,
}

/// The reason for which chances cannot be kept.
#[derive(Clone, Debug, Error)]
pub enum NotKept {
    /// A plan without margins, or with those that the chances take, cannot be attempted.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// No limit has this name.
    #[error("no constraint and no limit of the torques is called \"{0}\"")]
    Unknown(String),
    /// The requested reserve of a limit exceeds the limit.
    #[error("\"{name}\" is {bound} {unit}, and corrections need {needed} {unit} of it{part}")]
    Reserve {
        /// Name of the limit.
        name: String,
        /// The component or input, in words.
        part: String,
        /// Value of the limit.
        bound: String,
        /// The required reserve.
        needed: String,
        /// The unit of the reserve and of the limit.
        unit: &'static str,
    },
}

/// Plans at most: margins settle by a factor of some tens a plan, and flights count them two or
/// three times.
const MOST_PLANS: usize = 24;

/// Plans after which margins only grow: where two instants take turns as the worst, the larger of
/// their margins is kept.
const TURNS: usize = 12;

/// Plans a maneuver with chance constraints. Also returns the maneuver with the margins that the
/// chances need.
///
/// # Errors
/// [`NotKept`]: the errors of [`plan::plan`], an end that is too near to a limit for its chance, or
/// a chance that needs more than the whole limit.
pub fn plan(
    problem: &Problem,
    settings: &Settings,
    feedback: Option<Feedback>,
    uncertainty: &Uncertainty,
    chances: &[Kept],
    observer: &mut dyn Observer,
) -> Result<(Problem, Plan, Margins), NotKept> {
    let craft = problem.of_craft();
    let mut groups = chances.iter().map(|kept| Group::of(kept, &craft)).collect::<Result<Vec<_>, _>>()?;
    let mut found = plan::plan(problem, settings, None, observer)?;
    let mut with = problem.clone();
    let mut margins = Margins { cost_without: found.solution.cost, plans: 1, ..Margins::default() };
    while found.status == Status::Solved && margins.plans < MOST_PLANS {
        let on_grid = found.solution.on_grid(&with);
        let Ok(beside) = Beside::along(&on_grid, &found.solution.trajectory, feedback, Some(uncertainty))
        else {
            break;
        };
        let grown = margins.plans >= TURNS;
        let all_needed = |groups: &[Group]| -> Vec<Needed> {
            let of = |group: &Group| -> Vec<Needed> {
                group.limits.iter().map(|limit| group.needed(limit, &beside, problem)).collect()
            };
            groups.iter().flat_map(of).collect()
        };
        let agree = |groups: &[Group], needed: &[Needed]| {
            let limits = groups.iter().flat_map(|group| &group.limits);
            limits.zip(needed).all(|(limit, needed)| needed.is(&limit.held(&with), grown))
        };
        let mut needed = all_needed(&groups);
        if agree(&groups, &needed) {
            // Flights are counted once margins and deviations belong to one plan. The remaining
            // room then moves with the margins.
            Flights { beside: &beside, planned: &on_grid, craft: &craft, uncertainty }.count(&mut groups);
            margins.counted = groups.iter().map(|group| group.counted).collect();
            needed = all_needed(&groups);
            if agree(&groups, &needed) {
                margins.agreed = true;
                break;
            }
        }
        if !needed.iter().flat_map(|needed| &needed.margins).all(|margin| margin.is_finite()) {
            break;
        }
        for (limit, needed) in groups.iter().flat_map(|group| &group.limits).zip(&needed) {
            let mut wanted = needed.margins.clone();
            if grown {
                wanted
                    .iter_mut()
                    .zip(limit.held(&with))
                    .for_each(|(wanted, held)| *wanted = wanted.max(held));
            }
            limit.check(&craft, &wanted)?;
            limit.hold(&mut with, &craft, &wanted);
        }
        // The limits hardly change: the plan for the last limits leads to the plan for the next
        // ones.
        let guess = Guess::of(&found.solution, &with).alone();
        found = plan::plan(&with, settings, Some(&guess), observer)?;
        margins.plans += 1;
    }
    let limits = groups.iter().flat_map(|group| &group.limits);
    margins.held = limits.map(|limit| limit.told(&with, &craft)).collect();
    Ok((with, found, margins))
}

/// Replaces the reserve of a limit in a maneuver: `held` has a number for each part, SI, 0 for no
/// reserve.
///
/// # Errors
/// Returns [`NotKept`] if the limit does not exist, or is smaller than the reserve.
pub fn hold(problem: &mut Problem, name: &str, held: &[f64]) -> Result<(), NotKept> {
    let craft = problem.of_craft();
    let limit = Limit::named(&craft, name).ok_or_else(|| NotKept::Unknown(name.into()))?;
    limit.check(&craft, held)?;
    limit.hold(problem, &craft, held);
    Ok(())
}

#[cfg(test)]
mod tests;
