//! Terminal states on a target, and the arrival time.
//!
//! The interior-point method finds the best terminal states (`free_end`): the roll about the
//! boresight is an unknown of its Newton steps, and so is the arrival time if the duration is free
//! and the target moves. The maneuver to the terminal state found is then solved as any to a given
//! end, with all its starts and homotopy classes.
//!
//! Switching inputs that are limited only by their own limits have their plan in continuous time.
//! Its best roll differs from the roll on a uniform grid by the square of the step, and is found
//! from there by the derivative of the minimum cost (`rolls`). For a moving target the arrival T is
//! the first time at which the quickest plan to the end *at that time* takes no longer, a root of
//! `T*(T) − T`. Both follow the extremals of one search by Newton on their arcs
//! (`switching/followed`).

use crate::maneuver::aim::{Aim, Ends};
use crate::maneuver::constraint::{Rule, Side};
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{EndCondition, Problem, ProblemError};
use crate::maneuver::settings::{Settings, Target, Thoroughness};
use crate::maneuver::solution::{Outcome, Rival, Sense, Solution, Trajectory};
use crate::optimize::landing::{MET, left};
use crate::optimize::search::context::Context;
use crate::optimize::search::halt::Halt;
use crate::optimize::search::outer::Inner;
use crate::optimize::search::outer::free_end::{self, FreeEnd, Reached};
use crate::optimize::search::outer::illinois::Illinois;
use crate::optimize::search::outer::rolls::{CLOSE, Rolls};
use crate::optimize::search::starts::GUESS;
use crate::optimize::search::switching::followed::Followed;
use crate::optimize::search::{Guess, Observer, PlanError};
use crate::{Matrix3, Vector3, lie};
use std::time::Instant;

/// Relative difference below which two arrival times are equal. The plan on its grid takes longer
/// than the continuous-time plan by more than this.
const NEAR: f64 = 1e-9;

/// Relative difference between the two arrival times from which the derivative of the delay with
/// respect to time is computed.
const APART: f64 = 1e-3;

/// Derivative of the delay with respect to the arrival time, for a target at rest: the duration of
/// the plan does not change.
const STANDS: f64 = -1.0;

/// Largest number of arrival times that are tried.
const MOST_TIMES: usize = 40;

/// First arrival time to try for switching inputs, as a fraction of the arrival time on a uniform
/// grid. The two arrival times differ by less than 2 %.
const BEFORE: f64 = 0.98;

/// Solves a maneuver that ends on a target.
pub fn solve_to(
    problem: &Problem,
    aim: &Aim,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
    inner: Inner,
) -> Result<Solution, PlanError> {
    let began = Instant::now();
    let mut search = OnTarget { problem, aim, settings, guess, near: None, began, observer, inner };
    let mut searched = search.best();
    if settings.target == Target::Motion
        && let Ok(found) = &searched
        && let Some((narrower, missed)) = drawn_in_at_end(problem, found)
        && let Some(other) = search.plan_to_end_of(&narrower)
        && other.outcome == Outcome::Converged
        && left(&other.on_grid(problem), &other.trajectory) < missed
    {
        searched = Ok(other);
    }
    let took = began.elapsed().as_secs_f64();
    match searched {
        Ok(solution) => Ok(Solution { solve_time: took, ..solution }),
        Err(Halt::Stopped(solution)) => Ok(Solution { solve_time: took, ..*solution }),
        Err(Halt::Refused(error)) => Err(error),
    }
}

/// Tightens the cones on whose edge a plan that does not land ends, by the miss of its true motion.
/// Returns the tightened maneuver and the miss; `None` if the plan lands, or does not end on the
/// edge of a cone.
///
/// A landing shifts the end of the discrete motion. On the edge of a cone no shift is possible, but
/// at another roll it is. The cones are therefore tightened.
fn drawn_in_at_end(problem: &Problem, found: &Solution) -> Option<(Problem, f64)> {
    if found.outcome != Outcome::Converged {
        return None;
    }
    let ended = found.on_grid(problem);
    let missed = left(&ended, &found.trajectory);
    if !(missed > MET && missed.is_finite()) {
        return None;
    }
    let draw_in = |problem: &mut Problem, is_drawn_in: &dyn Fn(&str) -> bool| {
        for constraint in &mut problem.constraints {
            if let Rule::Pointing(cone) = &mut constraint.rule
                && !matches!(cone.side, Side::On { .. })
                && is_drawn_in(&constraint.name)
            {
                cone.margin += missed;
            }
        }
    };
    let lasting = found.trajectory.time.last().copied()?;
    let mut all = Problem { end_condition: EndCondition::State, ..ended.lasting(lasting) };
    draw_in(&mut all, &|_| true);
    let at_end = |error| match error {
        ProblemError::Violated { end: "end", name, .. } => Some(name),
        _ => None,
    };
    let edges: Vec<String> = all.violations().filter_map(at_end).collect();
    let mut narrower = problem.clone();
    draw_in(&mut narrower, &|name| edges.iter().any(|edge| edge == name));
    (!edges.is_empty()).then_some((narrower, missed))
}

/// A search for the best terminal state on a target.
struct OnTarget<'a> {
    problem: &'a Problem,
    aim: &'a Aim,
    settings: &'a Settings,
    /// Guess that is used in addition to the search, for a given duration.
    guess: Option<&'a Guess>,
    /// The extremal that was the quickest to the previous terminal state.
    near: Option<Followed>,
    began: Instant,
    observer: &'a mut dyn Observer,
    inner: Inner<'a>,
}

impl OnTarget<'_> {
    /// Returns the plan to the best terminal state.
    fn best(&mut self) -> Result<Solution, Halt> {
        match (self.problem.duration.known(), self.problem.duration.at_most()) {
            (Some(duration), _) => self.in_time(duration),
            (None, _) if !self.moves() => self.in_time(0.0),
            (None, Some(longest)) => self.up_to(longest),
            (None, None) => self.moving(),
        }
    }

    /// Returns whether the target moves.
    fn moves(&self) -> bool {
        self.aim.moves(&self.problem.environment.frame_rate())
    }

    /// Returns the plan of this maneuver to the terminal state that is the best one of the maneuver
    /// `narrower`, whose constraints are tighter; `None` if no plan is found.
    fn plan_to_end_of(&mut self, narrower: &Problem) -> Option<Solution> {
        let settings = Settings { target: Target::Discrete, ..self.settings() };
        let other =
            OnTarget { problem: narrower, settings: &settings, near: None, observer: self.observer, ..*self };
        let other = { other }.best().ok().filter(|other| other.outcome == Outcome::Converged)?;
        let guess = Guess::near(&other, narrower);
        let time = other.trajectory.time.last().copied()?;
        let last = lie::rotation_from_quaternion(other.trajectory.quaternion.last()?);
        let attitude = lie::project_to_rotation(&last);
        let known = self.problem.duration.known();
        if known.is_none() && self.moves() {
            return self.meeting((time, &attitude, STANDS), Some(&guess)).ok();
        }
        let ends = self.ends_at(known.unwrap_or(0.0)).ok()?;
        self.plan(&self.problem.facing(&ends, ends.nearest(&attitude)), Some(&guess)).ok()
    }

    /// Returns the terminal states on the target at a time.
    fn ends_at(&self, time: f64) -> Result<Ends, PlanError> {
        let ends = self.problem.ends_on(self.aim, time);
        ends.map_err(|error| ProblemError::from(error).into())
    }

    /// Returns the settings with the remaining time as the time limit.
    fn settings(&self) -> Settings {
        let left = self.settings.time_limit.map(|limit| limit.saturating_sub(self.began.elapsed()));
        Settings { time_limit: left, ..self.settings.clone() }
    }

    /// Returns the best terminal states that the interior-point method finds on the steps of
    /// `problem`. The search is near the end of the motion `known`, or near the end of the plan
    /// from which the search begins, if either exists.
    fn free_end(&mut self, problem: &Problem, ends: &Ends, known: Option<&Trajectory>) -> FreeEnd {
        if let Some(reached) = self.begun_from().filter(|_| known.is_none()) {
            return FreeEnd { reached: vec![reached], stopped: None };
        }
        free_end::found(problem, (self.aim, ends), known, &self.settings(), self.observer)
    }

    /// Returns the plan to the best terminal state at one time.
    fn in_time(&mut self, time: f64) -> Result<Solution, Halt> {
        let ends = self.ends_at(time)?;
        if !ends.has_roll() {
            return self.plan(&self.problem.facing(&ends, 0.0), None);
        }
        let is_guess = self.guess.is_some_and(|guess| !guess.is_known());
        let of_guess = self.guessed().filter(|_| is_guess).map(|attitude| ends.nearest(&attitude));
        if let Some(roll) = of_guess.filter(|_| self.guess.is_some_and(|guess| guess.alone)) {
            return self.plan(&self.problem.facing(&ends, roll), None);
        }
        let (mut problem, mut before): (_, Option<Solution>) = (self.problem.clone(), None);
        loop {
            // If a plan has chosen the number of steps, the end is searched for near that plan.
            let motion = before.as_ref().map(|plan| &plan.trajectory);
            let FreeEnd { reached, .. } = self.free_end(&problem, &ends, motion);
            let by_arcs = problem.switches() && problem.start.angular_velocity == Vector3::zeros();
            let reached = if by_arcs { self.by_arcs(&problem, &ends, reached)? } else { reached };
            let roll = reached.first().map_or(0.0, |best| ends.nearest(&best.attitude));
            let known = reached.first().and_then(|best| best.known.as_ref());
            let mut found = self.plan(&problem.facing(&ends, roll), known)?;
            if let Some(roll) = of_guess {
                let other = self.plan(&problem.facing(&ends, roll), None)?;
                let is_plan = |plan: &Solution| plan.outcome == Outcome::Converged;
                if is_plan(&other) && !(is_plan(&found) && found.cost <= other.cost) {
                    found = other;
                }
            }
            // The number of steps was chosen for the plan to the previous roll.
            let again = before.is_none()
                && problem.chooses_steps
                && found.outcome == Outcome::Converged
                && found.steps != problem.steps;
            if again {
                problem = problem.planned_by(found.method).with_steps(found.steps);
                before = Some(found);
                continue;
            }
            let lands = |plan: &Solution| {
                let flown = plan.on_grid(self.problem);
                plan.outcome == Outcome::Converged && left(&flown, &plan.trajectory) <= MET
            };
            // A plan to nearly the same roll may land although this one does not.
            let kept = before.take_if(|before| lands(before) && !lands(&found));
            let chosen = found.chosen.or(before.and_then(|before| before.chosen));
            return Ok(with_rivals(kept.unwrap_or(Solution { chosen, ..found }), &reached));
        }
    }

    /// Returns the attitude at which the path of the guess ends, if it has one.
    fn guessed(&self) -> Option<Matrix3> {
        let last = self.guess?.quaternion.last()?;
        Some(lie::project_to_rotation(&lie::rotation_from_quaternion(last)))
    }

    /// Returns the terminal state of the plan from which the search begins, if it begins from one.
    fn begun_from(&self) -> Option<Reached> {
        let (time, attitude, known) = (*self.guess?.time.last()?, self.guessed()?, self.guess.cloned());
        let rival = Rival::new(GUESS, Sense::Short, f64::NAN, f64::NAN);
        Some(Reached { time, attitude, rival, known })
    }

    /// Solves the maneuver to a given terminal state. `known` is the plan that found this state,
    /// used as the start.
    fn plan(&mut self, given: &Problem, known: Option<&Guess>) -> Result<Solution, Halt> {
        Ok((self.inner)(given, &self.settings(), known.or(self.guess), self.observer)?)
    }

    /// Returns the terminal states with their rolls optimised in continuous time, the cheapest
    /// first.
    fn by_arcs(
        &mut self,
        problem: &Problem,
        ends: &Ends,
        mut reached: Vec<Reached>,
    ) -> Result<Vec<Reached>, Halt> {
        let settings = self.settings();
        let context = Context::new(&settings, self.observer);
        let rolls = Rolls { problem, ends, context: &context };
        let best = reached.first().map_or(f64::NAN, |best| best.rival.cost);
        for end in reached.iter_mut().filter(|end| end.rival.cost <= best * (1.0 + CLOSE)) {
            if let Some(best) = rolls.lowest(ends.nearest(&end.attitude))? {
                end.attitude = ends.at(best.roll).0;
                end.rival.cost = best.cost;
            }
        }
        reached.sort_by(|a, b| a.rival.cost.total_cmp(&b.rival.cost));
        Ok(reached)
    }

    /// Returns the plan for an upper bound on the duration: the better of the plan with the whole
    /// duration and the plan with the optimal duration.
    fn up_to(&mut self, longest: f64) -> Result<Solution, Halt> {
        let price = self.problem.objective.given_time_price().unwrap_or(0.0);
        let priced = |time_price| {
            self.problem.clone().with_objective(self.problem.objective.with_time_price(time_price))
        };
        let all = priced(None).lasting(longest);
        let mut all =
            OnTarget { problem: &all, near: None, observer: self.observer, ..*self }.in_time(longest)?;
        all.pay_for_time(price * longest);
        let sought = priced(Some(price));
        let sought = OnTarget { problem: &sought, near: None, observer: self.observer, ..*self }.moving()?;
        let is_plan = |solution: &Solution| solution.outcome == Outcome::Converged;
        let within = sought.trajectory.time.last().is_some_and(|duration| *duration <= longest);
        let cheaper = is_plan(&sought) && within && !(is_plan(&all) && all.cost <= sought.cost);
        Ok(if cheaper { sought } else { all })
    }

    /// Returns the plan to a moving target with the optimal duration.
    fn moving(&mut self) -> Result<Solution, Halt> {
        let ends = self.ends_at(0.0)?;
        let FreeEnd { reached, stopped } = self.free_end(self.problem, &ends, None);
        let Some(best) = reached.first() else {
            let unsolved = Solution::unsolved(self.problem, self.settings.tolerance);
            return Ok(Solution { outcome: stopped.unwrap_or(Outcome::Stalled), ..unsolved });
        };
        let found = match self.problem.objective {
            Objective::Time if self.problem.switches() => self.quickest(best)?,
            Objective::Time => self.meeting((best.time, &best.attitude, STANDS), best.known.as_ref())?,
            _ => self.in_best_time(best)?,
        };
        Ok(with_rivals(found, &reached))
    }

    /// Returns the minimum-effort or minimum-fuel plan to the position of the target at the optimal
    /// time.
    fn in_best_time(&mut self, best: &Reached) -> Result<Solution, Halt> {
        let ends = self.ends_at(best.time)?;
        let priced = self.problem.objective.time_price() * best.time;
        let given = self.problem.facing(&ends, ends.nearest(&best.attitude)).lasting(best.time);
        let mut found = self.plan(&given, best.known.as_ref())?;
        found.pay_for_time(priced);
        Ok(found)
    }

    /// Returns the plan that meets the moving target. `time` is the first estimate of the arrival
    /// time, and `slope` the derivative of the delay with respect to time.
    fn meeting(
        &mut self,
        (time, attitude, slope): (f64, &Matrix3, f64),
        known: Option<&Guess>,
    ) -> Result<Solution, Halt> {
        let meeting = self.problem.meeting(self.aim, attitude, time, slope).map_err(ProblemError::from);
        self.plan(&meeting.map_err(PlanError::from)?, known)
    }

    /// Returns the minimum-time plan with switching inputs, starting from the plan on a uniform
    /// grid. It computes the arrival time for the roll of that plan, then the best roll at this
    /// time, then the arrival time for this roll. The arrival time depends on the roll to second
    /// order.
    fn quickest(&mut self, best: &Reached) -> Result<Solution, Halt> {
        let time = self.arrival(best.time, &best.attitude)?;
        let ends = self.ends_at(time)?;
        let quick = self.quick();
        let context = Context::new(&quick, self.observer);
        let rolls = Rolls { problem: self.problem, ends: &ends, context: &context };
        let found = rolls.lowest(ends.nearest(&best.attitude))?;
        let attitude = found.map_or(best.attitude, |found| ends.at(found.roll).0);
        let time = self.arrival(time, &attitude)?;
        let mut slope = STANDS;
        let later = time * (1.0 + APART);
        if let Some(now) = self.late(time, &attitude)?
            && let Some(then) = self.late(later, &attitude)?
        {
            slope = (then - now) / (later - time);
        }
        self.meeting((time, &attitude, if slope < 0.0 { slope } else { STANDS }), None)
    }

    /// Returns the first time, near or after `time`, at which the target can be reached: the
    /// quickest plan to the roll of `attitude` takes no longer than this time.
    fn arrival(&mut self, time: f64, attitude: &Matrix3) -> Result<f64, Halt> {
        let mut late = |time: f64| self.late(time, attitude);
        for first in [BEFORE * time, 0.0] {
            if let Some([from, to]) = first_reached(first, &mut late)? {
                return root(from, to, NEAR, &mut late);
            }
        }
        Ok(time)
    }

    /// Returns the delay of the quickest plan to the roll of `attitude`, for the target at `time`
    /// \[s\]; `None` if no plan is found.
    fn late(&mut self, time: f64, attitude: &Matrix3) -> Result<Option<f64>, Halt> {
        let ends = self.ends_at(time)?;
        let given = self.problem.facing(&ends, ends.nearest(attitude));
        let quick = self.quick();
        let context = Context::new(&quick, self.observer);
        let led = self.near.as_ref().and_then(|near| near.led(&given, &context));
        let found = match led {
            Some(led) => Some(led),
            None => Followed::all(&given, &context, 0.0)?.into_iter().next(),
        };
        let Some(found) = found else { return Ok(None) };
        let late = found.duration - time;
        self.near = Some(found);
        Ok(Some(late))
    }

    /// Returns the settings for plans that are only compared with each other.
    fn quick(&self) -> Settings {
        Settings { search: Thoroughness::Quick, ..self.settings() }
    }
}

/// Adds the other terminal states in `reached` to the rivals of a plan.
fn with_rivals(mut found: Solution, reached: &[Reached]) -> Solution {
    found.rivals.extend(reached.iter().skip(1).map(|end| end.rival.clone()));
    found.rivals.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    found
}

/// An arrival time and the delay of the plan for it \[s\].
type Late = [f64; 2];

/// Returns the first interval, from `time` on, with a late plan at its start and no late plan at
/// its end, and the delay at both ends; `None` if the plan at `time` is not late or if none is
/// found.
fn first_reached(
    mut time: f64,
    late: &mut dyn FnMut(f64) -> Result<Option<f64>, Halt>,
) -> Result<Option<[Late; 2]>, Halt> {
    let Some(mut delay) = late(time)?.filter(|delay| *delay > 0.0) else { return Ok(None) };
    for _ in 0..MOST_TIMES {
        // The plan arrives after `time` by the delay; the target has moved by then.
        let next = time + delay;
        let Some(then) = late(next)? else { return Ok(None) };
        if then <= 0.0 {
            return Ok(Some([[time, delay], [next, then]]));
        }
        (time, delay) = (next, then);
    }
    Ok(None)
}

/// Returns a root of the delay between two times, up to a relative tolerance.
fn root(
    mut low: Late,
    mut high: Late,
    width: f64,
    late: &mut dyn FnMut(f64) -> Result<Option<f64>, Halt>,
) -> Result<f64, Halt> {
    let mut illinois = Illinois::new([low[1], high[1]]);
    for _ in 0..MOST_TIMES {
        let next = low[0] + illinois.part() * (high[0] - low[0]);
        if !(next > low[0] && next < high[0]) || high[0] - low[0] <= width * high[0] {
            break;
        }
        let Some(delay) = late(next)? else { break };
        if delay.abs() <= width * next {
            return Ok(next);
        }
        let moved = usize::from(delay <= 0.0);
        illinois.moved(moved, delay);
        *[&mut low, &mut high][moved] = [next, delay];
    }
    Ok(high[0])
}
