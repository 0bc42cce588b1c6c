//! Alternative sets of cones, at least one of which must hold at any time.
//!
//! A schedule of shifts states which set holds when. With a schedule, the sets are constraints that
//! are active at certain times. In every step of a plan one set has the largest clearance, and
//! these sets form the next schedule. The plan satisfies it too, so that the next plan costs no
//! more, and an active set is left as soon as another one holds. The iteration ends when no shift
//! changes. A moment between two shifts near which the motion touches a cone of either set is moved
//! separately, in both directions, as long as that costs less.
//!
//! Schedules are compared by the interior-point method, starting from the plan of the previous
//! schedule: first on the coarse grid, then the cheapest on the requested grid with smaller changes
//! of the moments. The maneuver with the cheapest schedule is then planned as any other, with that
//! plan as one initial path. The first schedules are those of the optima without the sets, and each
//! set for the whole duration.

use crate::maneuver::constraint::{Alternatives, Arc, Rule, Shift, Turns, on_arc};
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::{Formulation, Motion, Problem, ProblemError};
use crate::maneuver::settings::{Settings, Thoroughness};
use crate::maneuver::solution::{Outcome, Rung, Solution};
use crate::optimize::chain::{Chain, path};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point;
use crate::optimize::methods::interior_point::method::InteriorPoint;
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::context::Context;
use crate::optimize::search::found::Found;
use crate::optimize::search::given_duration::search_of;
use crate::optimize::search::ladder::{Ask, Search};
use crate::optimize::search::outer::free_end::Posed;
use crate::optimize::search::outer::{Inner, of_discrete_optima};
use crate::optimize::search::starts::detour::detours;
use crate::optimize::search::starts::transfer::transfer;
use crate::optimize::search::strategies::chains::{descend, distinct, optimised_near};
use crate::optimize::search::strategies::seeds;
use crate::optimize::search::{Guess, Observer, PlanError, check_for_no_guess, check_guess};
use crate::{Matrix3, lie};
use std::time::Instant;

/// Largest number of rounds that improve one schedule. The plan of each round satisfies the
/// schedule of the previous one. The rounds end early if the cost no longer decreases.
const MOST_ROUNDS: usize = 12;
/// Relative decrease of the cost from which a plan counts as cheaper.
const GAINED: f64 = 1e-7;
/// Clearance below which a plan touches a cone \[rad\].
const TOUCHING: f64 = 1e-6;
/// Changes of a shift time, as fractions of the duration: the first change on the coarse grid, the
/// first change on the requested grid, and the smallest change.
const MOVED: [f64; 3] = [0.1, 0.01, 5e-4];
/// Largest number of passes over all shift times. Eight halvings lead from the first to the
/// smallest change, and most passes gain nothing.
const MOST_PASSES: usize = 24;
/// Largest number of steps of the grid on which the shift times are finally optimised. The grid
/// changes these times by `O(h²)`, so more steps change them little.
const MOST_STEPS: usize = 200;
/// Time at which the last shift ends if the duration is free \[s\].
const FOR_GOOD: f64 = f64::MAX;

/// Shifts of every constraint with alternative sets: which set holds when.
type Schedule = Vec<Turns>;

/// Solves a maneuver with alternative sets of cones.
pub fn solve(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
    inner: Inner,
) -> Result<Solution, PlanError> {
    if Formulation::of(problem) != Formulation::Extremal || problem.duration.known().is_none() {
        check_for_no_guess(guess)?;
    }
    check_guess(problem, guess)?;
    let began = Instant::now();
    let scheduled = match problem.motion {
        Motion::Attitude => scheduled::<6>(problem, settings, guess, observer),
        Motion::RigidBody => scheduled::<12>(problem, settings, guess, observer),
    };
    let mut within = |schedule: &Schedule, guess: Option<&Guess>| {
        let given = problem.in_turns(schedule);
        let remaining = settings.time_limit.map(|limit| limit.saturating_sub(began.elapsed()));
        let settings = Settings { time_limit: remaining, ..settings.clone() };
        let told =
            |found| Solution { turns: schedule.clone(), solve_time: began.elapsed().as_secs_f64(), ..found };
        inner(&given, &settings, guess, observer).map(told)
    };
    let or_unsolved = |found: Result<Solution, PlanError>| match found {
        // The schedule, and not the maneuver, contradicts a boundary state.
        Err(PlanError::Problem(ProblemError::Violated { .. })) => {
            Ok(Solution::unsolved(problem, settings.tolerance))
        }
        found => found,
    };
    let ended = |found: &Solution| {
        matches!(found.outcome, Outcome::Converged | Outcome::Interrupted | Outcome::TimeLimit)
    };
    let mut failed = None;
    for (schedule, guess) in &scheduled {
        let found = or_unsolved(within(schedule, Some(guess)))?;
        if ended(&found) {
            return Ok(found);
        }
        failed = failed.or(Some(found));
    }
    // A boundary state that a constraint forbids is infeasible without the sets too.
    let free = within(&never(problem), guess)?;
    if free.outcome != Outcome::Converged {
        return Ok(free);
    }
    let roomiest = roomiest(problem, &Followed::recorded(problem, &free));
    let found = or_unsolved(within(&roomiest, guess))?;
    if ended(&found) {
        return Ok(found);
    }
    // That one schedule has no plan does not prove that all schedules are infeasible.
    let failed = failed.unwrap_or(found);
    let outcome = if failed.infeasible.is_some() { Outcome::Stalled } else { failed.outcome };
    Ok(Solution { outcome, infeasible: None, ..failed })
}

/// Returns the schedule without shifts, in which none of the sets holds at any time.
fn never(problem: &Problem) -> Schedule {
    problem.alternatives.iter().map(|of| Turns { of: of.clone(), shifts: Vec::new() }).collect()
}

/// Returns the schedules that have plans on the chain, the cheapest first, each with the path of
/// its plan.
fn scheduled<const N: usize>(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
) -> Vec<(Schedule, Guess)> {
    let settings = of_discrete_optima(settings);
    let context = Context::new(&settings, observer);
    let ends = problem.aim().and_then(|aim| {
        let ends = problem.ends_on(aim, problem.duration.known().unwrap_or(0.0)).ok()?;
        Some((aim, ends))
    });
    let on = ends.as_ref().map(|(aim, ends)| (*aim, ends));
    let Some(posed) = Posed::of(problem, on).filter(|_| problem.aim().is_none() == on.is_none()) else {
        return Vec::new();
    };
    let search = search_of::<N>(&posed.faced[0], &context, posed.ask(&settings));
    let known = InTurns { problem, search: &search }.found(&posed, guess);
    let path = |Turned { schedule, attempt }: Turned| {
        (schedule, Guess::of_plan(&search.fine.dynamics, search.problem.seconds(), &attempt.candidate))
    };
    known.into_iter().map(path).collect()
}

/// A schedule and its plan on the chain.
#[derive(Clone)]
struct Turned {
    schedule: Schedule,
    attempt: Attempt,
}

impl Turned {
    /// Returns whether the plan is cheaper than the plan of `other`.
    fn gains(&self, other: &Self) -> bool {
        self.attempt.cost < other.attempt.cost * (1.0 - GAINED)
    }
}

/// Sorts schedules by the estimated cost of their optimum, the cheapest first.
fn sorted(mut turned: Vec<Turned>) -> Vec<Turned> {
    turned.sort_by(|a, b| a.attempt.foreseen().total_cmp(&b.attempt.foreseen()));
    turned
}

/// A search for the cheapest schedule.
struct InTurns<'s, 'a, 'c, const N: usize> {
    problem: &'s Problem,
    /// Search for the maneuver with a given duration as the unit of time.
    search: &'s Search<'a, 'c, N>,
}

impl<const N: usize> InTurns<'_, '_, '_, N> {
    /// Returns the schedules that have plans, the cheapest first.
    fn found(&self, posed: &Posed, guess: Option<&Guess>) -> Vec<Turned> {
        let Self { search, .. } = self;
        let steps = posed.steps();
        let mut best = self.first(posed, guess);
        let few = search.context.tuning.carried;
        best.truncate(few);
        let better = |turned: Turned, by: f64| self.moved(self.improved(turned), by);
        let mut best = sorted(best.into_iter().map(|turned| better(turned, MOVED[0])).collect());
        let fine = search.problem.steps.min(MOST_STEPS);
        if let Some(cheapest) = best.first_mut().filter(|_| fine > steps)
            && let Some(finer) = self.on(fine, cheapest)
        {
            *cheapest = better(finer, MOVED[1]);
        }
        best
    }

    /// Returns plans of the first schedules on the coarse grid, the cheapest first. If an optimum
    /// without the sets satisfies the schedule read from it, no further optima are tried.
    fn first(&self, posed: &Posed, guess: Option<&Guess>) -> Vec<Turned> {
        let Self { problem, search } = self;
        let (steps, one, few) = (posed.steps(), search.context.tuning.one, search.context.tuning.carried);
        let without = search.problem.in_turns(&never(problem));
        let mut found = Found::default();
        {
            let search = search.of(&without, search.ask.clone());
            let chain = search.chain(steps);
            let guessed = guess.and_then(|guess| guess.seed(&chain.model));
            let paths = guessed.into_iter().chain(posed.paths(&search, &chain));
            for seed in paths.flat_map(|path| detours(&without, path)) {
                descend(&search, &mut found, &chain, seed);
            }
        }
        let (mut turned, grid) = (Vec::new(), Grid::uniform(problem.scheme, 1.0, steps));
        for free in distinct(found.take_plans(), one).into_iter().take(few) {
            let followed = self.followed(&free);
            let roomiest = roomiest(problem, &followed);
            if followed.keeps(problem, &roomiest) {
                turned.push(Turned { schedule: roomiest, attempt: free });
                break;
            }
            let poses = free.candidate.states.iter().map(Point::pose);
            let own = [path(&free.candidate.provenance.start, &grid, poses)];
            for schedule in all_along(problem, roomiest) {
                let given = search.problem.in_turns(&schedule);
                let mut attempts = self.along(&given, search.ask.clone(), &own, followed.seconds());
                // A long path may not converge to a free end although it converges to a given end.
                // The plan to the given end is then the initial guess for the free end.
                for faced in posed.faced.iter().filter(|_| !problem.ends_in_any_attitude()) {
                    let given = faced.in_turns(&schedule);
                    if attempts.is_empty() && given.check().is_ok() {
                        let ask = Ask { family: None, ..search.ask.clone() };
                        let paths = seeds::of(&search.of(&given, ask.clone()), steps, Thoroughness::Quick);
                        attempts = self.along(&given, ask, &paths, followed.seconds());
                    }
                }
                let turn = |attempt| Turned { schedule: schedule.clone(), attempt };
                turned.extend(attempts.into_iter().map(turn));
            }
        }
        let mut turned = sorted(turned);
        turned.dedup_by(|b, a| b.attempt.foreseen() <= a.attempt.foreseen() * (1.0 + one));
        turned
    }

    /// Returns the plans of a maneuver near the first path that leads to any, including detours
    /// around the cones that this path violates.
    fn along(&self, given: &Problem, ask: Ask, paths: &[Candidate], seconds: f64) -> Vec<Attempt> {
        let search = self.search.of(given, ask);
        let (lasting, mut found) = (given.clone().lasting(seconds), Found::default());
        for path in paths {
            let chain = search.chain(path.steps());
            for seed in detours(&lasting, path.clone()) {
                descend(&search, &mut found, &chain, seed);
            }
            if found.is_done() {
                break;
            }
        }
        distinct(found.take_plans(), search.context.tuning.one)
    }

    /// Returns the motion of a plan.
    fn followed(&self, plan: &Attempt) -> Followed {
        Followed::planned(self.search.problem, &plan.candidate)
    }

    /// Returns the plan of a schedule near another plan on the same grid; `None` if the method does
    /// not converge.
    fn near(&self, schedule: Schedule, from: &Candidate) -> Option<Turned> {
        let Search { problem, context, ask, .. } = self.search;
        let given = problem.in_turns(&schedule);
        let chain = match &ask.goal {
            None => Chain::new(&given, from.steps()),
            Some(goal) => Chain::with_goal(&given, from.steps(), goal),
        };
        let tuning = Tuning::near();
        let method = InteriorPoint { family: ask.family, ..InteriorPoint::of(&chain, &tuning) };
        let attempt = context.attempt(Rung::InteriorPoint, &method, from.clone());
        attempt.converged().then_some(Turned { schedule, attempt })
    }

    /// Returns the plan of a schedule on a grid with another number of steps.
    fn on(&self, steps: usize, Turned { schedule, attempt }: &Turned) -> Option<Turned> {
        let given = self.search.problem.in_turns(schedule);
        let search = self.search.of(&given, self.search.ask.clone());
        let chains = [attempt.candidate.steps(), steps].map(|steps| search.chain(steps));
        let start = transfer([&chains[0], &chains[1]], &attempt.candidate);
        let attempt = optimised_near(&search, &chains[1], start);
        attempt.converged().then(|| Turned { schedule: schedule.clone(), attempt })
    }

    /// Improves a schedule repeatedly. The next schedule consists of the sets with the largest
    /// clearance along the plan of the previous schedule.
    fn improved(&self, mut best: Turned) -> Turned {
        for _ in 0..MOST_ROUNDS {
            let next = roomiest(self.problem, &self.followed(&best.attempt));
            match self.near(next, &best.attempt.candidate).filter(|found| found.gains(&best)) {
                Some(found) => best = found,
                None => break,
            }
        }
        best
    }

    /// Moves each time between two shifts, at first by the fraction `first` of the duration, as
    /// long as that reduces the cost.
    fn moved(&self, mut best: Turned, first: f64) -> Turned {
        let mut by = first;
        for _ in 0..MOST_PASSES {
            if by <= MOVED[2] {
                break;
            }
            let mut gained = false;
            for of in 0..best.schedule.len() {
                for after in 1..best.schedule[of].shifts.len() {
                    let followed = self.followed(&best.attempt);
                    if !followed.is_caught(self.problem, &best.schedule[of], after) {
                        continue;
                    }
                    let moved = [by, -by].into_iter().find_map(|step| {
                        let mut schedule = best.schedule.clone();
                        let shifts = &mut schedule[of].shifts;
                        let moment = shifts[after].from + step * followed.seconds();
                        let [least, most] = [shifts[after - 1].from, shifts[after].to];
                        (moment > least && moment < most).then_some(())?;
                        (shifts[after - 1].to, shifts[after].from) = (moment, moment);
                        self.near(schedule, &best.attempt.candidate).filter(|found| found.gains(&best))
                    });
                    if let Some(moved) = moved {
                        (best, gained) = (moved, true);
                    }
                }
            }
            if !gained {
                by *= 0.5;
            }
        }
        best
    }
}

/// Returns a schedule, and its variants in which one set holds for the whole duration.
fn all_along(problem: &Problem, schedule: Schedule) -> Vec<Schedule> {
    let end = problem.duration.known().unwrap_or(FOR_GOOD);
    let mut all = vec![schedule.clone()];
    for (index, of) in problem.alternatives.iter().enumerate() {
        for set in 0..of.sets.len() {
            let mut other = schedule.clone();
            other[index].shifts = vec![Shift { set, from: 0.0, to: end }];
            all.push(other);
        }
    }
    all
}

/// Attitudes of a motion at its nodes, relative to inertial space.
struct Followed {
    time: Vec<f64>,
    attitude: Vec<Matrix3>,
}

impl Followed {
    /// Returns the motion of a plan on the chain of a maneuver with a stated duration.
    fn planned(problem: &Problem, plan: &Candidate) -> Self {
        let time = (0..=plan.steps()).map(|node| problem.seconds() * plan.grid.time(node)).collect();
        Self::of(problem, time, plan.states.iter().map(|state| state.attitude.value))
    }

    /// Returns the motion of a solution.
    fn recorded(problem: &Problem, plan: &Solution) -> Self {
        let attitudes = plan.trajectory.quaternion.iter().map(lie::rotation_from_quaternion);
        Self::of(problem, plan.trajectory.time.clone(), attitudes)
    }

    fn of(problem: &Problem, time: Vec<f64>, attitudes: impl Iterator<Item = Matrix3>) -> Self {
        let frame_rate = problem.environment.frame_rate();
        let turned = |(attitude, time): (Matrix3, &f64)| lie::exp(&(frame_rate * *time)) * attitude;
        Self { attitude: attitudes.zip(&time).map(turned).collect(), time }
    }

    /// Returns the duration \[s\].
    fn seconds(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0)
    }

    /// Returns the smallest clearance to the cones of a set during a step \[rad\].
    fn room(&self, problem: &Problem, members: &[String], step: usize) -> f64 {
        let [start, to] = [step, step + 1].map(|node| self.attitude[node]);
        let arc = Arc { start, turn: lie::minus(&to, &start) };
        let (time, length) = (self.time[step], self.time[step + 1] - self.time[step]);
        let frame_rate = problem.environment.frame_rate();
        let cones = members.iter().filter_map(|name| {
            let named = problem.constraints.iter().find(|one| one.name == *name)?;
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

    /// Returns whether the motion satisfies a schedule.
    fn keeps(&self, problem: &Problem, schedule: &Schedule) -> bool {
        let holds = |turns: &Turns, step: usize| {
            let acts = |shift: &&Shift| shift.from <= self.time[step] && self.time[step] < shift.to;
            let set = turns.shifts.iter().find(acts).map(|shift| &turns.of.sets[shift.set]);
            set.is_some_and(|set| self.room(problem, set, step) >= 0.0)
        };
        let steps = self.time.len().saturating_sub(1);
        schedule.iter().all(|turns| (0..steps).all(|step| holds(turns, step)))
    }

    /// Returns whether the motion, near the time between two shifts, touches a cone of the set
    /// before or of the set after this time.
    fn is_caught(&self, problem: &Problem, Turns { of, shifts }: &Turns, after: usize) -> bool {
        let [before, next] = [&shifts[after - 1], &shifts[after]];
        let at = self.time.partition_point(|time| *time < next.from).clamp(1, self.time.len() - 1);
        [at - 1, at].into_iter().filter(|step| step + 1 < self.time.len()).any(|step| {
            [before, next].iter().any(|shift| self.room(problem, &of.sets[shift.set], step) < TOUCHING)
        })
    }
}

/// Returns the schedule of the sets with the largest clearance in each step of a motion.
fn roomiest(problem: &Problem, motion: &Followed) -> Schedule {
    let of = |alternatives: &Alternatives| {
        let mut shifts: Vec<Shift> = Vec::new();
        for step in 0..motion.time.len().saturating_sub(1) {
            let room = |set: &usize| motion.room(problem, &alternatives.sets[*set], step);
            let most = (0..alternatives.sets.len()).max_by(|a, b| room(a).total_cmp(&room(b))).unwrap_or(0);
            if shifts.last().is_none_or(|shift| shift.set != most) {
                shifts.iter_mut().last().into_iter().for_each(|last| last.to = motion.time[step]);
                shifts.push(Shift { set: most, from: motion.time[step], to: FOR_GOOD });
            }
        }
        if let (Some(last), Some(duration)) = (shifts.last_mut(), problem.duration.known()) {
            last.to = duration;
        }
        Turns { of: alternatives.clone(), shifts }
    };
    problem.alternatives.iter().map(of).collect()
}
