//! Plans with flight data: feedback gains, covariances, and chances of exceeding limits.
//!
//! If a limit may be exceeded with the chance p, the plan keeps the distance that the closed loop
//! needs from it: `room ≥ z σ`, `z = Φ⁻¹(1 − p)`, with σ along the plan under its own gains. The
//! distance is a margin of a cone, or a reserve of a rate, of the torque of each input, or of its
//! rate of change. The margin depends on the plan, and the plan on the margin. Both are iterated
//! until they agree, and each plan is warm-started from the last one.
//!
//! This is the chance at an instant, to first order. The chance of exceeding a limit at any time of
//! the motion is larger. It is not a sum over instants, because their errors are correlated.
//! Simulated flights of the closed loop count it (`closed_loop`), with equal random numbers for
//! every plan. Several limits may have a joint chance that any of them is exceeded. They then share
//! one z, as if each were equally likely to be exceeded at its worst instant. A margin shifts the
//! distance to its own limit, so the next z is
//!
//! ```text
//! z ← z − q ,    q: the p-quantile, over the cases, of the distance left to the limits, in σ
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

/// The design of feedback gains, and the time between two corrections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedback {
    /// The design method of the gains.
    pub kind: Kind,
    /// Time between two measurements \[s\], a whole number of steps. A correction is held over this
    /// time. 0 selects one step.
    pub every: f64,
}

impl From<Kind> for Feedback {
    fn from(kind: Kind) -> Self {
        Self { kind, every: 0.0 }
    }
}

/// The data for the flight of a plan: its linearised motion, gains, covariances and chances.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Beside {
    /// The motion linearised about the plan, under torques held over each step.
    pub linear: LinearPlan,
    /// Feedback gains along the plan; `None` if no feedback was requested.
    pub gains: Option<Gains>,
    /// Corrections of the arc lengths for another start; `None` unless the switching times are
    /// corrected at the start.
    pub switching: Option<SwitchingGains>,
    /// Covariance in open loop (without gains); `None` without an uncertainty.
    pub open: Option<Covariance>,
    /// Covariance in closed loop (with the gains); `None` without gains or without an uncertainty.
    pub closed: Option<Covariance>,
    /// The chances of violating each constraint, in closed loop if there are gains. The chances of
    /// exceeding each torque limit follow, if there are gains.
    pub chances: Vec<Chance>,
}

/// The reason why gains or covariances along a plan cannot be computed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotKnown {
    /// The motion could not be linearised about the plan.
    #[error("{0}")]
    Unlinearised(#[from] Unlinearised),
    /// No gains exist for this plan.
    #[error("{0}")]
    NoGains(#[from] NoGains),
    /// The requested time between two corrections is not a whole number of steps of the plan, or
    /// the grid of the plan is not uniform.
    #[error(
        "a tick of {every} s is not a whole number of the {steps} steps of this plan, which last \
        {duration} s"
    )]
    Tick {
        /// The requested time between two corrections \[s\], as text.
        every: String,
        /// Number of steps of the plan.
        steps: usize,
        /// Duration of the plan \[s\], as text.
        duration: String,
    },
}

impl Beside {
    /// Computes the flight data of a plan of `problem`. The problem must have the grid of the plan
    /// ([`Solution::on_grid`]).
    ///
    /// [`Solution::on_grid`]: crate::maneuver::Solution::on_grid
    ///
    /// # Errors
    /// [`NotKnown`] if gains or covariances cannot be computed for this plan.
    pub fn along(
        problem: &Problem,
        plan: &Trajectory,
        feedback: Option<Feedback>,
        uncertainty: Option<&Uncertainty>,
    ) -> Result<Self, NotKnown> {
        // The corrections may use the part of the input limits that the plan reserves.
        let linear = LinearPlan::flown(&problem.of_craft(), plan)?;
        Self::near(problem, plan, linear, feedback, uncertainty)
    }

    /// Computes the flight data of a recorded motion of `problem`. The record holds one row of
    /// inputs over each of its steps ([`Stepping::Recorded`]). The gains bring the craft back to
    /// the motion at its end and at the nodes `stops`, in ascending order.
    ///
    /// [`Stepping::Recorded`]: crate::maneuver::Stepping::Recorded
    ///
    /// # Errors
    /// [`NotKnown`] if gains or covariances cannot be computed for this motion.
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
            // The effect of the correction at the start on the covariance is unknown.
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
    /// Returns this feedback, with `weights` for a regulator for which no weights were given.
    #[must_use]
    pub fn with_default_weights(self, weights: RegulatorWeights) -> Self {
        let kind = match self.kind {
            Kind::Tvlqr(None) => Kind::Tvlqr(Some(weights)),
            kind => kind,
        };
        Self { kind, ..self }
    }

    /// Fraction of a step by which a tick may deviate from a whole number of steps.
    const WHOLE: f64 = 1e-6;

    /// Returns the number of steps between two corrections, for a plan whose nodes are at `times`
    /// \[s\].
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

    /// Designs gains for plans whose covariance is not available: the body translates, or torques
    /// are fixed in the reference frame ([`PosedPlan::is_of`]).
    ///
    /// # Errors
    /// [`NotKnown`] if the plan cannot be linearised or no gains exist.
    pub fn along_pose(&self, problem: &Problem, plan: &Trajectory) -> Result<Gains, NotKnown> {
        let linear = PosedPlan::flown(&problem.of_craft(), plan)?;
        let every = self.steps(&plan.time)?;
        let gains = Gains::along_pose(&of_posed_ticks(&linear, every), self.kind, problem.switches())?;
        Ok(gains.held_over(every, linear.count()))
    }
}

/// An upper bound on the chance of exceeding one or several limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept<'a> {
    /// Names of constraints, and of torque limits as reports call them ("torque limit"). Each limit
    /// keeps the bound if it refers to an instant; all limits together keep it if it refers to the
    /// motion.
    pub limits: Vec<&'a str>,
    /// Largest allowed chance of exceeding the limit, or any of several limits.
    pub at_most: f64,
    /// The times to which the chance refers: each instant, or the whole motion.
    pub over: Over,
}

/// The times to which a chance refers: each instant, or the whole motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Over {
    /// The chance at the worst node, to first order.
    Instant,
    /// The chance of exceeding a limit at any time of the motion, also between the nodes. It is
    /// counted in simulated flights with this plant.
    Motion(Plant),
}

impl Over {
    /// The smallest chance over a whole motion that can be estimated from simulated flights.
    pub const LEAST: f64 = 1e-4;

    /// Desired number of simulated flights with a violation. The relative statistical error of the
    /// counted chance is then about a tenth.
    const VIOLATING: f64 = 100.0;

    /// Smallest expected number of flights with a violation, for plans of many steps.
    const FEWEST: f64 = 20.0;

    /// Maximum total number of steps in all simulated flights of a plan; they take a few seconds.
    const STEPS: f64 = 2e7;

    /// Returns the number of simulated flights from which `chance` is counted, for a plan with
    /// `steps` steps.
    fn flights(chance: f64, steps: usize) -> usize {
        let most = Self::STEPS / steps.max(1) as f64;
        (Self::VIOLATING / chance).min(most).max(Self::FEWEST / chance).ceil() as usize
    }
}

/// The reserve of a limit: the part of it that a plan leaves unused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Held {
    /// The name of the limit.
    pub name: String,
    /// The physical quantity that is limited.
    pub quantity: Quantity,
    /// The reserve of each part of the limit, SI. A cone and a norm have one part; other limits
    /// have one part per component or input.
    pub parts: Vec<f64>,
    /// The limit of the craft for each part, SI; infinite for a cone.
    pub bounds: Vec<f64>,
}

/// The result of the iteration over plans and their margins.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Margins {
    /// The reserve of each limit that has a chance, in the order of the chances.
    pub held: Vec<Held>,
    /// Cost of the plan that keeps no margins.
    pub cost_without: f64,
    /// Number of plans computed.
    pub plans: usize,
    /// True if margins and covariances are consistent at the end of the iteration. If false, the
    /// returned plan is the last one computed.
    pub agreed: bool,
    /// The counted proportion of flights that exceed a limit, for each chance; `None` for chances
    /// at an instant.
    pub counted: Vec<Option<Proportion>>,
}

/// The reason why chances cannot be kept.
#[derive(Clone, Debug, Error)]
pub enum NotKept {
    /// Planning is impossible without margins, or with the margins that the chances require.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// No constraint and no torque limit has this name.
    #[error("no constraint or torque limit is called \"{0}\"")]
    Unknown(String),
    /// The reserve that the chance requires is not smaller than the limit.
    #[error("\"{name}\" is {bound} {unit}, and corrections need {needed} {unit} of it{part}")]
    Reserve {
        /// Name of the limit.
        name: String,
        /// The component or input to which the reserve belongs, in words.
        part: String,
        /// Value of the limit, as text.
        bound: String,
        /// Required reserve, as text.
        needed: String,
        /// The unit of limit and reserve.
        unit: &'static str,
    },
}

/// Maximum number of plans. Each plan reduces the error of the margins by a factor of a few tens,
/// and flights are counted two or three times.
const MOST_PLANS: usize = 24;

/// Number of plans after which margins can only grow. If two instants alternate as the worst one,
/// the larger of their margins is then kept.
const TURNS: usize = 12;

/// Plans a maneuver with chance constraints. Returns the maneuver with the margins that the chances
/// need, its plan, and the result of the iteration.
///
/// # Errors
/// [`NotKept`]: the errors of [`plan::plan`], an end that is too near to a limit for its chance, or
/// a reserve that would use up the whole limit.
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
            // Flights are counted only after margins and standard deviations agree for one plan.
            // From then on the distances in the flights change with the margins.
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
        // The limits hardly change, so the plan for the last limits is a warm start for the next
        // ones.
        let guess = Guess::of(&found.solution, &with).alone();
        found = plan::plan(&with, settings, Some(&guess), observer)?;
        margins.plans += 1;
    }
    let limits = groups.iter().flat_map(|group| &group.limits);
    margins.held = limits.map(|limit| limit.told(&with, &craft)).collect();
    Ok((with, found, margins))
}

/// Sets the reserve of a limit of a maneuver: the part of the limit that plans must leave unused.
/// `held` has one value for each part of the limit, SI; 0 for no reserve.
///
/// # Errors
/// [`NotKept`] if no limit has this name, or if a reserve is not smaller than its limit.
pub fn hold(problem: &mut Problem, name: &str, held: &[f64]) -> Result<(), NotKept> {
    let craft = problem.of_craft();
    let limit = Limit::named(&craft, name).ok_or_else(|| NotKept::Unknown(name.into()))?;
    limit.check(&craft, held)?;
    limit.hold(problem, &craft, held);
    Ok(())
}

#[cfg(test)]
mod tests;
