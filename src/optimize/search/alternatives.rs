//! Sets of cones that hold in turns.
//!
//! Which set holds when is a schedule of shifts. With a schedule the sets are constraints that act at times, and the maneuver is planned
//! as any other. Along its plan every step has a set that has the most room, and those sets are the next schedule: the plan holds it
//! too, so no next plan need be dearer, and a set that presses is left as soon as another holds. That ends where no shift changes. A
//! moment at which one set ends to hold and another begins, between which the path is caught, is moved by itself, to either side, as long
//! as that costs less.
//!
//! First schedules are that of the maneuver without the sets, and every set all along.

use super::halt::Halt;
use super::{Guess, Observer, PlanError, without_arcs};
use crate::lie;
use crate::maneuver::constraint::{Alternatives, Arc, Rule, Shift, Turns, on_arc};
use crate::maneuver::problem::{Formulation, Problem, ProblemError};
use crate::maneuver::settings::{Settings, Thoroughness};
use crate::maneuver::solution::{Outcome, Solution, Trajectory};
use std::time::Instant;

/// Plans on the way from one schedule: each holds what the one before held, and costs that fall end sooner.
const MOST_ROUNDS: usize = 12;
/// Part of the cost that is a gain.
const GAINED: f64 = 1e-7;
/// Room that is none, as a plan has of a cone that it touches \[rad\].
const TOUCHING: f64 = 1e-6;
/// Parts of the duration by which a moment is moved at first, and at last.
const MOVED: [f64; 2] = [0.1, 5e-4];
/// Passes over all moments: eight halvings lead from the first to the last of these parts, and most gain nothing.
const MOST_PASSES: usize = 24;
/// A shift of a plan whose duration is not known lasts until then \[s\].
const FOR_GOOD: f64 = f64::MAX;

/// Which set of each of the alternatives holds when.
type Schedule = Vec<Turns>;

/// Solves a maneuver with alternatives.
pub(super) fn solve(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    let mut search = InTurns { problem, settings, guess, observer, began: Instant::now() };
    let found = match search.best() {
        Ok(found) => found,
        Err(Halt::Stopped(found)) => *found,
        Err(Halt::Refused(error)) => return Err(error),
    };
    Ok(Solution { solve_time: search.began.elapsed().as_secs_f64(), ..found })
}

struct InTurns<'a> {
    problem: &'a Problem,
    settings: &'a Settings,
    guess: Option<&'a Guess>,
    observer: &'a mut dyn Observer,
    began: Instant,
}

impl InTurns<'_> {
    fn best(&mut self) -> Result<Solution, Halt> {
        let never = |of: &Alternatives| Turns { of: of.clone(), shifts: Vec::new() };
        let none: Schedule = self.problem.alternatives.iter().map(never).collect();
        // What no plan can do without the sets it cannot with them.
        let free = self.plan(&none, None)?;
        if free.outcome != Outcome::Converged {
            return Ok(free);
        }
        let roomiest = self.along(&free.trajectory);
        let end = self.problem.duration.known().unwrap_or(FOR_GOOD);
        let mut first = vec![roomiest.clone()];
        for (index, of) in self.problem.alternatives.iter().enumerate() {
            for set in 0..of.sets.len() {
                let mut all_along = roomiest.clone();
                all_along[index].shifts = vec![Shift { set, from: 0.0, to: end }];
                first.push(all_along);
            }
        }
        let (mut best, mut failed): (Option<Solution>, Option<Solution>) = (None, None);
        for schedule in first {
            let found = self.improved(schedule, &free)?;
            if found.outcome == Outcome::Converged && found.cost <= free.cost * (1.0 + GAINED) {
                // Nothing costs less than without the sets.
                return Ok(found);
            }
            if found.outcome != Outcome::Converged {
                failed = failed.or(Some(found));
            } else if best.as_ref().is_none_or(|best| found.cost < best.cost * (1.0 - GAINED)) {
                best = Some(found);
            }
        }
        match best {
            Some(best) => self.moved(best),
            // That one schedule has no plan does not prove that none has.
            None => Ok(failed.map_or(free, |failed| Solution {
                outcome: if failed.infeasible.is_some() { Outcome::Stalled } else { failed.outcome },
                infeasible: None,
                ..failed
            })),
        }
    }

    /// Plans by a schedule, from another plan where its path can be a start.
    fn plan(&mut self, schedule: &Schedule, from: Option<&Solution>) -> Result<Solution, Halt> {
        self.planned(schedule, from, self.settings.search)
    }

    /// Plans by a schedule from the plan of one that hardly differs.
    fn plan_near(&mut self, schedule: &Schedule, from: &Solution) -> Result<Solution, Halt> {
        self.planned(schedule, Some(from), Thoroughness::Quick)
    }

    fn planned(
        &mut self,
        schedule: &Schedule,
        from: Option<&Solution>,
        search: Thoroughness,
    ) -> Result<Solution, Halt> {
        let problem = self.problem.in_turns(schedule);
        let remaining = self.settings.time_limit.map(|limit| limit.saturating_sub(self.began.elapsed()));
        let settings = Settings { time_limit: remaining, search, ..self.settings.clone() };
        let takes_one = Formulation::of(&problem) == Formulation::Extremal && problem.aim().is_none();
        let own = from.filter(|_| takes_one).map(|from| Guess::of(from, &problem));
        let guess = own.as_ref().or(self.guess);
        let found = match without_arcs(&problem, &settings, guess, self.observer) {
            // The schedule and not the maneuver is at odds with an end.
            Err(PlanError::Problem(ProblemError::Violated { .. })) => {
                return Ok(Solution::unsolved(&problem, self.settings.tolerance));
            }
            found => found?,
        };
        let found = Solution { turns: schedule.clone(), ..found };
        match found.outcome {
            Outcome::Interrupted | Outcome::TimeLimit => Err(Halt::Stopped(Box::new(found))),
            _ => Ok(found),
        }
    }

    /// The plan that a schedule leads to, each next one by the sets that have the most room along the one before.
    fn improved(&mut self, mut schedule: Schedule, free: &Solution) -> Result<Solution, Halt> {
        let mut best = self.plan(&schedule, Some(free))?;
        for _ in 0..MOST_ROUNDS {
            if best.outcome != Outcome::Converged {
                break;
            }
            let next = self.along(&best.trajectory);
            if next == schedule {
                break;
            }
            schedule = next;
            let found = self.plan(&schedule, Some(&best))?;
            let gains = found.outcome == Outcome::Converged && found.cost < best.cost * (1.0 - GAINED);
            if !gains {
                break;
            }
            best = found;
        }
        Ok(best)
    }

    /// The plan with each moment between two shifts moved as long as that costs less.
    fn moved(&mut self, mut best: Solution) -> Result<Solution, Halt> {
        let Some(duration) = best.trajectory.time.last().copied() else { return Ok(best) };
        let mut by = MOVED[0];
        for _ in 0..MOST_PASSES {
            if by <= MOVED[1] {
                break;
            }
            let mut gained = false;
            for of in 0..best.turns.len() {
                for after in 1..best.turns[of].shifts.len() {
                    if !self.is_caught(&best, of, after) {
                        continue;
                    }
                    for step in [by, -by] {
                        let mut schedule = best.turns.clone();
                        let shifts = &mut schedule[of].shifts;
                        let moment = shifts[after].from + step * duration;
                        let [least, most] = [shifts[after - 1].from, shifts[after].to];
                        if !(moment > least && moment < most) {
                            continue;
                        }
                        (shifts[after - 1].to, shifts[after].from) = (moment, moment);
                        let from = best.clone();
                        let found = self.plan_near(&schedule, &from)?;
                        if found.outcome == Outcome::Converged && found.cost < best.cost * (1.0 - GAINED) {
                            (best, gained) = (found, true);
                            break;
                        }
                    }
                }
            }
            if !gained {
                by *= 0.5;
            }
        }
        Ok(best)
    }

    /// Whether a plan has no room of the one set before a moment, and of the other after it.
    fn is_caught(&self, plan: &Solution, of: usize, after: usize) -> bool {
        let Turns { of: alternatives, shifts } = &plan.turns[of];
        let ([before, next], time) = ([shifts[after - 1], shifts[after]], &plan.trajectory.time);
        let at = time.partition_point(|time| *time < next.from).clamp(1, time.len() - 1);
        [at - 1, at].into_iter().filter(|step| step + 1 < time.len()).any(|step| {
            let room = |set: usize| self.room(alternatives, set, &plan.trajectory, step);
            room(before.set) < TOUCHING || room(next.set) < TOUCHING
        })
    }

    /// Of each of the alternatives the set that has the most room in each step of a plan.
    fn along(&self, plan: &Trajectory) -> Schedule {
        let steps = plan.time.len().saturating_sub(1);
        let of = |alternatives: &Alternatives| {
            let rooms = |step: usize| -> Vec<f64> {
                (0..alternatives.sets.len()).map(|set| self.room(alternatives, set, plan, step)).collect()
            };
            let mut shifts: Vec<Shift> = Vec::new();
            for step in 0..steps {
                let rooms = rooms(step);
                let most = (0..rooms.len()).max_by(|a, b| rooms[*a].total_cmp(&rooms[*b])).unwrap_or(0);
                match shifts.last_mut() {
                    Some(shift) if shift.set == most => {}
                    last => {
                        if let Some(last) = last {
                            last.to = plan.time[step];
                        }
                        shifts.push(Shift { set: most, from: plan.time[step], to: FOR_GOOD });
                    }
                }
            }
            if let (Some(last), Some(duration)) = (shifts.last_mut(), self.problem.duration.known()) {
                last.to = duration;
            }
            Turns { of: alternatives.clone(), shifts }
        };
        self.problem.alternatives.iter().map(of).collect()
    }

    /// The least room that the cones of a set leave in a step of a plan \[rad\].
    fn room(&self, alternatives: &Alternatives, set: usize, plan: &Trajectory, step: usize) -> f64 {
        let frame_rate = self.problem.environment.frame_rate();
        let [from, to] = [step, step + 1].map(|node| {
            let attitude = lie::rotation_from_quaternion(&plan.quaternion[node]);
            // Bodies turn in inertial space.
            lie::exp(&(frame_rate * plan.time[node])) * attitude
        });
        let arc = Arc { start: from, turn: lie::minus(&to, &from) };
        let (time, length) = (plan.time[step], plan.time[step + 1] - plan.time[step]);
        let members = alternatives.sets[set].iter();
        let cones = members.filter_map(|name| {
            let named = self.problem.constraints.iter().find(|one| one.name == *name)?;
            if let Rule::Pointing(cone) = &named.rule { Some(cone) } else { None }
        });
        let rooms = cones.flat_map(|cone| {
            cone.pairs().filter_map(move |(boresight, direction)| {
                let target = on_arc(direction, time, length, &frame_rate);
                Some(cone.least_room(&arc, boresight, &target, [time, length])?.1)
            })
        });
        rooms.fold(f64::INFINITY, f64::min)
    }
}
