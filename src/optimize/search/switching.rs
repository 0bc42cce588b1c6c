//! Minimum time and fuel: the search for the best extremal, and the discrete optimum on the grid of the plan.

pub(super) mod followed;
mod pulses;
mod record;

use super::context::Context;
use super::way::Follower;
use crate::lie;
use crate::maneuver::duration::Duration;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Path, Problem};
use crate::maneuver::settings::Method;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Landing, Optimality, Outcome, Rival, Rung, Sense, Solution};
use crate::maneuver::switching::{Structure, Switching, SwitchingArc};
use crate::numerics::figures::rounded_up;
use crate::optimize::landing::{Aim, Next};
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::switching::arcs::Arcs;
use crate::optimize::methods::switching::branches::Ask;
use crate::optimize::methods::switching::discretize::{arcs_on_grid, smooth_on_grid};
use crate::optimize::methods::switching::eigenaxis;
use crate::optimize::methods::switching::extremal::{Extremal, Law};
use crate::optimize::methods::switching::limit::{Found, Limit};
use crate::optimize::methods::switching::on_grid::OnGrid;
use crate::optimize::methods::switching::pulses::on_grid::{again, arcs_placed};
use crate::optimize::methods::switching::scaled::{Units, input_of, inputs, scaled};
use crate::optimize::methods::switching::search::search;
use crate::optimize::methods::switching::smooth::Smoothed;
use crate::optimize::methods::switching::tuning::grid::LEAST_STEPS;
use crate::optimize::methods::switching::work::Halt;
use record::{Planned, at_rest, record};

/// Attitudes this near, and rates in the unit of time, are the same.
const SAME: f64 = 1e-14;

/// Costs that differ by this part are those of two extremals.
const DISTINCT: f64 = 1e-6;

/// A plan of arcs on the grid costs more than its extremal by this part at most, as a rule: what `O(h²)` is on some ten steps an arc.
pub(super) const OF_THE_GRID: f64 = 1e-3;

/// Multiples of the shortest duration that are tried for one of least fuel.
const STRETCHES: [f64; 3] = [1.02, 1.1, 1.5];

/// Arcs shorter than this part of the duration are none.
const NO_ARC: f64 = 1e-10;

/// Solves a maneuver of minimum time or fuel. It must have been checked.
///
/// Up to a longest duration the plan takes all of the time or, where a second has a price or the body moves at an end, the
/// duration at which the Hamiltonian vanishes.
pub(super) fn solve(problem: &Problem, context: &Context) -> Solution {
    solve_by(problem, context, true, true)
}

/// The same as a path to begin from, which need not land.
pub(super) fn solve_discrete(problem: &Problem, context: &Context) -> Solution {
    solve_by(problem, context, true, false)
}

/// The same by the smoothed law alone, to compare.
pub(super) fn solve_smoothed(problem: &Problem, context: &Context) -> Solution {
    solve_by(problem, context, false, false)
}

/// With arcs at the limits, or without.
fn solve_by(problem: &Problem, context: &Context, arcs: bool, lands: bool) -> Solution {
    let once = |problem: &Problem| solve_once(problem, context, arcs, lands);
    match problem.duration.at_most() {
        Some(longest) => up_to(longest, problem, context, &once),
        None => once(problem),
    }
}

/// Least effort or fuel up to a longest duration: all of it or, where a second has a price or the body cannot wait, the
/// duration sought, whichever is cheaper. `once` solves for a given duration, or for one that is sought.
pub(super) fn up_to(
    longest: f64,
    problem: &Problem,
    context: &Context,
    once: &dyn Fn(&Problem) -> Solution,
) -> Solution {
    let price = problem.objective.given_time_price().unwrap_or(0.0);
    let of = |time_price| problem.objective.with_time_price(time_price);
    let mut all = once(&problem.clone().with_duration(longest).with_objective(of(None)));
    all.pay_for_time(price * longest);
    if context.interrupt().is_some() || problem.can_wait() && price == 0.0 {
        return all;
    }
    let sought = problem.clone().with_duration_at_most(longest).with_objective(of(Some(price)));
    let sought = once(&sought);
    let is_plan = |solution: &Solution| solution.outcome == Outcome::Converged;
    let stopped = matches!(sought.outcome, Outcome::Interrupted | Outcome::TimeLimit);
    // The grid's own duration too: it is off the continuous one by the square of the step.
    let within = sought.trajectory.time.last().is_some_and(|duration| *duration <= longest);
    let cheaper = is_plan(&sought) && within && !(is_plan(&all) && all.cost <= sought.cost);
    let chosen = if cheaper || stopped && !is_plan(&all) { sought } else { all };
    Solution { solve_time: context.began.elapsed().as_secs_f64(), ..chosen }
}

/// In a given duration, or in the best one of all.
fn solve_once(problem: &Problem, context: &Context, arcs: bool, lands: bool) -> Solution {
    let found = Extremals::of(problem, context, arcs)
        .map_or_else(|ended| *ended, |extremals| extremals.cheapest(lands));
    context.ladder.take();
    found
}

/// What a maneuver without its constraints comes to.
pub(super) struct Unconstrained {
    /// The cheapest plan, which need not land.
    pub cheapest: Solution,
    /// The cheapest that keeps the constraints too, made to land where that is asked for.
    pub within: Option<Solution>,
}

/// The plans of a maneuver without constraints: the cheapest, and the cheapest of those that are `kept`.
///
/// Mirror images and other extremals of one cost are plans of their own: one may keep what another does not.
pub(super) fn solve_unconstrained(
    problem: &Problem,
    context: &Context,
    kept: &dyn Fn(&Solution) -> bool,
) -> Unconstrained {
    let found = match Extremals::of(problem, context, true) {
        Err(ended) => Unconstrained { cheapest: *ended, within: None },
        Ok(extremals) => {
            let within = extremals.cheapest_kept(context.lands(), kept);
            Unconstrained { cheapest: extremals.cheapest(false), within }
        }
    };
    context.ladder.take();
    found
}

/// Whether a plan is dearer than its certificate and the grid account for.
pub(super) fn is_dear(plan: &Solution) -> bool {
    let least = plan.switching.as_ref().map_or(f64::NAN, |found| found.continuous_cost - found.gap);
    plan.cost > least * (1.0 + OF_THE_GRID)
}

/// The extremals of a maneuver, on their way to its grid.
struct Extremals<'a, 'c> {
    problem: &'a Problem,
    context: &'a Context<'c>,
    extremal: Extremal,
    units: Units,
    found: Found,
    unsolved: Solution,
}

impl<'a, 'c> Extremals<'a, 'c> {
    /// The search for them; what it ends with where there are none to take to the grid.
    fn of(problem: &'a Problem, context: &'a Context<'c>, arcs: bool) -> Result<Self, Box<Solution>> {
        let tolerance = context.settings.tolerance;
        let mut unsolved = Solution { method: Method::Shooting, ..Solution::unsolved(problem, tolerance) };
        let Some((extremal, units)) = scaled(problem).map(|(extremal, units)| {
            let halt = context.within(|budget| Halt::of(&budget.watch));
            (Extremal { halt, ..extremal }, units)
        }) else {
            unsolved.outcome = Outcome::NotFinite;
            return Err(unsolved.into());
        };
        let apart =
            lie::log(&extremal.end_attitude).norm() + (extremal.end_rate - extremal.start_rate).norm();
        let stays = match problem.path {
            Path::Long => false,
            Path::AsGiven(rotation) => rotation.norm() < SAME,
            Path::Best | Path::Shortest => true,
        };
        if apart < SAME && stays {
            let resting = problem.start.angular_velocity.norm() * units.time < SAME;
            match extremal.given_duration {
                None => return Err(at_rest(problem, unsolved, 0).into()),
                Some(_) if resting => return Err(at_rest(problem, unsolved, problem.steps).into()),
                Some(_) => {}
            }
        }
        let ask = Ask { path: problem.path, thoroughness: context.settings.search, arcs };
        context.enter(Rung::Smoothed, "best", 0);
        let found = search(&extremal, &ask, &|| context.interrupt().is_some());
        let report = |outcome, iterations| Report { outcome, iterations, residuals: Vec::new() };
        let smoothed = if found.branches == 0 { Outcome::Stalled } else { Outcome::Converged };
        context.note(Rung::Smoothed, "all", 0, report(smoothed, found.sweeps));
        if found.branches > 0 {
            let polished = if found.limits.is_empty() { Outcome::Stalled } else { Outcome::Converged };
            context.note(Rung::Switches, "all", 0, report(polished, found.newtons));
        }
        match context.interrupt() {
            Some(outcome) => Err(ended(unsolved, outcome, context).into()),
            None => Ok(Self { problem, context, extremal, units, found, unsolved }),
        }
    }

    /// Those that last no longer than they may, the cheapest first. What is given has no bound.
    fn allowed(&self) -> impl Iterator<Item = &Limit> {
        let longest = self.problem.duration.at_most().filter(|_| self.extremal.given_duration.is_none());
        let lasts = |limit: &Limit| limit.duration() * self.units.time;
        self.found.limits.iter().filter(move |limit| longest.is_none_or(|longest| lasts(limit) <= longest))
    }

    /// The plan of one of them on the grid, where it goes the way that is asked for.
    fn planned(&self, limit: &Limit) -> Option<Planned> {
        let Self { problem, context, .. } = self;
        context.enter(Rung::Aligned, limit.name(), problem.steps);
        let plan = cheapest(problem, &self.extremal, &self.units, limit);
        let grid = plan.as_ref().map(|plan| (plan.iterations, plan.residual));
        noted(context, limit.name(), problem.steps, grid);
        plan.filter(|plan| follows(problem, plan))
    }

    /// The cheapest plan.
    fn cheapest(self, lands: bool) -> Solution {
        let Self { problem, context, extremal, units, found, .. } = &self;
        if let Some(shortest) = problem.shortest_pulse() {
            return pulses::solve(
                problem,
                (extremal, units),
                found,
                shortest,
                context,
                self.unsolved.clone(),
                lands,
            );
        }
        let mut chosen: Option<(Planned, &Limit)> = None;
        let arrives = |plan: &Planned| plan.terminal.largest() <= context.settings.tolerance;
        for limit in self.allowed() {
            // Extremals come cheapest first: the next is of use where the plan of the last is dearer than its grid accounts for, or
            // misses the end.
            let beats = |(plan, _): &(Planned, &Limit)| {
                !arrives(plan) || limit.cost(extremal) * units.cost() < plan.cost * (1.0 - OF_THE_GRID)
            };
            if !chosen.as_ref().is_none_or(beats) || context.interrupt().is_some() {
                break;
            }
            let better = |plan: &Planned, best: &Planned| {
                arrives(plan) && !arrives(best) || arrives(plan) == arrives(best) && plan.cost < best.cost
            };
            if let Some(plan) = self.planned(limit)
                && chosen.as_ref().is_none_or(|(best, _)| better(&plan, best))
            {
                chosen = Some((plan, limit));
            }
        }
        match chosen {
            Some((plan, limit)) => self.told(plan, limit, lands),
            None => self.without_plan(),
        }
    }

    /// The cheapest plan that is kept, with those for rivals that are kept as well.
    fn cheapest_kept(&self, lands: bool, kept: &dyn Fn(&Solution) -> bool) -> Option<Solution> {
        let stops = || self.context.interrupt().is_some();
        let plan = |limit: &Limit, lands: bool| {
            Some(self.told(self.planned(limit)?, limit, lands)).filter(|plan| kept(plan))
        };
        let mut limits = self.allowed().take_while(|_| !stops());
        let (limit, found) = limits.find_map(|limit| Some((limit, plan(limit, lands)?)))?;
        let dearer = limits.filter(|limit| plan(limit, false).is_some());
        let rivals = rivals(dearer.map(|limit| self.named(limit)), self.named(limit).1, found.sense);
        Some(Solution { rivals, ..found })
    }

    /// The name of an extremal, and what it costs.
    fn named(&self, limit: &Limit) -> (&'static str, f64) {
        (limit.name(), limit.cost(&self.extremal) * self.units.cost())
    }

    /// The solution that a plan is.
    fn told(&self, mut plan: Planned, limit: &Limit, lands: bool) -> Solution {
        let Self { problem, context, extremal, units, found, .. } = self;
        if let Some(aim) = Aim::asked(problem, context.settings).filter(|_| lands) {
            let afresh = |aimed: &Extremal| cheapest(problem, aimed, units, limit);
            plan = landed(aim, extremal, units, plan, &afresh, &|| context.interrupt().is_some());
        }
        if problem.objective.is_duration() {
            let eigenaxis = found.eigenaxis.or_else(|| eigenaxis::duration(extremal));
            plan.switching.eigenaxis_s = eigenaxis.map(|duration| duration * units.time);
        }
        let all = found.limits.iter().map(|limit| self.named(limit));
        let rivals = rivals(all, plan.switching.continuous_cost, plan.sense);
        finished(Solution { rivals, ..self.unsolved.clone() }, plan, context)
    }

    /// What there is to say where none has a plan.
    fn without_plan(self) -> Solution {
        let Self { problem, context, extremal, found, mut unsolved, .. } = self;
        if extremal.halt.is_raised() {
            let outcome = context.interrupt().unwrap_or(Outcome::Interrupted);
            return ended(unsolved, outcome, context);
        }
        let arcs = found.limits.iter().find_map(|limit| limit.arcs.as_ref());
        let arcs = arcs.map(|(arcs, _)| arcs.switches.len() + 1);
        if !shortest_told(problem, &found, context, &mut unsolved) {
            unsolved.shortfall = Some(match arcs {
                Some(arcs) if arcs * LEAST_STEPS > problem.steps => {
                    Shortfall::FewSteps { arcs, steps: arcs * LEAST_STEPS }
                }
                _ if found.branches == 0 => Shortfall::NoSmoothedExtremal,
                _ => Shortfall::NoDiscreteOptimum { steps: problem.steps },
            });
        }
        ended(unsolved, Outcome::Stalled, context)
    }
}

/// A plan whose true motion meets the end as nearly as corrections bring it: solved again, warm or else `afresh`, for the extremal
/// that ends where the discrete motion has to. What comes after somebody asks to stop is not corrected.
fn landed(
    mut aim: Aim,
    extremal: &Extremal,
    units: &Units,
    first: Planned,
    afresh: &dyn Fn(&Extremal) -> Option<Planned>,
    stops: &dyn Fn() -> bool,
) -> Planned {
    let problem = aim.problem();
    let cost_before = first.cost;
    let (mut plan, mut target, mut best) = (first, problem.end, None);
    loop {
        let next = aim.correct(&plan.trajectory);
        if next == Next::GiveUp && best.is_some() {
            break;
        }
        plan.trajectory.target = Some(target);
        plan.landing = Some(Landing { cost_before, ..aim.told() });
        if next != Next::Correct || stops() {
            return plan;
        }
        target = aim.target;
        let aimed = Extremal {
            end_attitude: problem.start.attitude.tr_mul(&target.attitude),
            end_rate: units.time * target.angular_velocity,
            ..extremal.clone()
        };
        let warm = again(&plan.grid, &aimed).and_then(|grid| {
            let mut warm = record(problem, &aimed, units, &grid)?;
            let Switching { beside_optimum, .. } = warm.switching;
            warm.switching = Switching { beside_optimum, ..plan.switching.clone() };
            let kept = pulses::told_again(problem, &mut warm);
            warm.start.clone_from(&plan.start);
            kept.then_some(warm)
        });
        let Some(solved) = warm.or_else(|| afresh(&aimed)) else {
            return plan;
        };
        best = Some(std::mem::replace(&mut plan, solved));
    }
    best.unwrap_or(plan)
}

/// The solution that a plan on its grid is.
fn finished(mut solution: Solution, plan: Planned, context: &Context) -> Solution {
    solution.steps = plan.trajectory.time.len() - 1;
    solution.step = plan.duration / solution.steps as f64;
    solution.cost = plan.cost;
    solution.iterations = plan.iterations;
    solution.terminal = plan.terminal;
    solution.optimality =
        Optimality { tested: true, stationarity: plan.residual, rank: 6, ..Optimality::UNTESTED };
    solution.sense = plan.sense;
    solution.turned_deg = plan.turned_deg;
    solution.start = plan.start;
    solution.trajectory = plan.trajectory;
    solution.landing = plan.landing;
    solution.switching = Some(plan.switching);
    let outcome =
        if solution.terminal.largest() <= solution.tolerance { Outcome::Converged } else { Outcome::Stalled };
    ended(solution, outcome, context)
}

/// Tells the shortest duration, where that of a maneuver of fuel is too short.
fn shortest_told(problem: &Problem, found: &Found, context: &Context, solution: &mut Solution) -> bool {
    let quickest = problem.objective.fuel().and_then(|_| too_short(problem, found, context));
    let Some((shortest, longer)) = quickest else { return false };
    (solution.shortest, solution.longer) = (Some(shortest), longer);
    solution.shortfall = Some(Shortfall::TooShort { asked: problem.seconds(), shortest });
    true
}

/// The shortest duration of a maneuver of given duration that no extremal of fuel was found for, where that is longer,
/// and a duration for which one was found.
fn too_short(problem: &Problem, found: &Found, context: &Context) -> Option<(f64, Option<f64>)> {
    if found.branches > 0 || problem.seeks_duration() {
        return None;
    }
    let ask = Ask { path: problem.path, thoroughness: context.settings.search, arcs: true };
    let search = |problem: &Problem| {
        let (extremal, units) = scaled(problem)?;
        let found = search(&extremal, &ask, &|| context.interrupt().is_some());
        found.limits.first().map(|limit| limit.duration() * units.time)
    };
    let shortest =
        search(&Problem { objective: Objective::Time, duration: Duration::SOUGHT, ..problem.clone() })?;
    if shortest <= problem.seconds() {
        return None;
    }
    let mut durations = STRETCHES.into_iter().map(|stretch| rounded_up(stretch * shortest));
    let longer = durations.find(|duration| search(&problem.clone().with_duration(*duration)).is_some());
    Some((shortest, longer))
}

/// What is dearer than a plan of this cost, by its name and cost, each cost once: mirror images cost the same.
fn rivals<'a>(dearer: impl Iterator<Item = (&'a str, f64)>, cost: f64, sense: Sense) -> Vec<Rival> {
    let (mut rivals, mut last) = (Vec::new(), cost);
    for (start, cost) in dearer {
        if cost > last * (1.0 + DISTINCT) {
            let start = start.into();
            rivals.push(Rival { start, sense, cost, conjugate_points: None, turned_deg: f64::NAN });
            last = cost;
        }
    }
    rivals
}

/// Notes whether something has a place on the grid of a plan, as it was announced.
fn noted(context: &Context, name: &str, steps: usize, grid: Option<(usize, f64)>) {
    let outcome = if grid.is_some() { Outcome::Converged } else { Outcome::Stalled };
    let (iterations, residuals) = (grid.map_or(0, |grid| grid.0), grid.iter().map(|grid| grid.1).collect());
    context.note(Rung::Aligned, name, steps, Report { outcome, iterations, residuals });
}

fn ended(solution: Solution, outcome: Outcome, context: &Context) -> Solution {
    let (ladder, solve_time) = (context.ladder.borrow().clone(), context.began.elapsed().as_secs_f64());
    Solution { outcome, ladder, solve_time, ..solution }
}

/// The discrete optimum of the best arcs where they have room on the grid, or the nearest to it; otherwise that of the next looser
/// ones, or of the smoothed law if it is cheaper.
fn cheapest(problem: &Problem, extremal: &Extremal, units: &Units, limit: &Limit) -> Option<Planned> {
    let goes_on = || (!extremal.halt.is_raised()).then_some(());
    let aligned = |limit: &Limit| {
        let (arcs, _) = limit.arcs.as_ref()?;
        goes_on()?;
        // The discrete optimum may lack a pulse of the continuous one, or have its pulses in another order.
        let grid = arcs_on_grid(extremal, arcs, problem.steps)
            .or_else(|| arcs_placed(extremal, arcs, problem.steps))?;
        planned(problem, extremal, units, limit, grid, None)
    };
    if let Some(plan) = aligned(limit) {
        return Some(plan);
    }
    let looser = limit.loosened().find_map(|limit| aligned(&limit));
    let smooth = || {
        goes_on()?;
        let least = limit.smooth.epsilon;
        let from = |smooth: &Smoothed| smooth_on_grid(extremal, smooth, least, problem.steps);
        let (grid, epsilon) = from(&limit.smooth).or_else(|| from(&limit.branch))?;
        // Of the arcs that it takes the place of it is none.
        let limit = Limit { arcs: None, ..limit.clone() };
        planned(problem, extremal, units, &limit, grid, Some(epsilon))
    };
    let cheaper = |a: &Planned, b: &Planned| a.cost.total_cmp(&b.cost);
    looser.into_iter().chain(smooth()).min_by(cheaper)
}

/// What a limit is on its grid; with ε where the inputs are smoothed there.
fn planned(
    problem: &Problem,
    extremal: &Extremal,
    units: &Units,
    limit: &Limit,
    grid: OnGrid,
    smoothing: Option<f64>,
) -> Option<Planned> {
    let arcs = limit.arcs.as_ref();
    let mut recorded = record(problem, extremal, units, &grid)?;
    recorded.switching.smoothing = smoothing;
    recorded.switching.continuous_duration_s = limit.duration() * units.time;
    recorded.switching.continuous_cost = limit.cost(extremal) * units.cost();
    recorded.start = limit.name().into();
    let switching = &mut recorded.switching;
    if let Some((arcs, certificate)) = arcs {
        let exact = limit.is_exact(extremal);
        switching.structure = match (exact, problem.objective.fuel()) {
            (true, None) => Structure::BangBang,
            (true, Some(_)) => Structure::BangOffBang,
            (false, _) => Structure::TruncatedChattering,
        };
        switching.gap = certificate.gap * units.cost();
        switching.switches = arcs.switches.len();
        if !exact && !extremal.axes().is_empty() {
            let inputs = certificate.singular().into_iter().map(|level| input_of(problem, level));
            switching.singular_inputs = inputs.collect();
            switching.singular_inputs.dedup();
        }
        switching.arcs = told(problem, extremal, units, arcs);
    } else {
        // A sum of terms that are not negative but for round-off.
        let gap = limit.smooth.gap(extremal) * units.cost();
        switching.gap = if gap < 0.0 { 0.0 } else { gap };
        let norm = matches!(extremal.law, Law::Norm(_)) && !extremal.counts_fuel();
        switching.structure = if norm { Structure::Norm } else { Structure::Singular };
    }
    Some(recorded)
}

/// Arcs with the inputs of the maneuver, in seconds. Inputs that switch together do so at one time: what round-off leaves
/// between them is no arc.
fn told(problem: &Problem, extremal: &Extremal, units: &Units, arcs: &Arcs) -> Vec<SwitchingArc> {
    let least = NO_ARC * arcs.duration * units.time;
    let arc = |(_, start, end, signs): (_, f64, f64, Vec<f64>)| {
        let input = match (extremal.axes(), extremal.on_arc(&signs).held()) {
            (_, None) => Vec::new(),
            ([], Some(_)) => vec![0.0; problem.actuation.count()],
            (_, Some(_)) => inputs(problem, &signs),
        };
        SwitchingArc {
            start_s: start * units.time,
            end_s: end * units.time,
            input,
            holds: Vec::new(),
            change: Vec::new(),
            touches: Vec::new(),
        }
    };
    let mut told: Vec<SwitchingArc> = arcs.arcs().into_iter().map(arc).collect();
    told.retain(|arc| arc.end_s - arc.start_s > least);
    for index in 1..told.len() {
        told[index].start_s = told[index - 1].end_s;
    }
    told
}

/// Whether a plan goes the way that is asked for.
fn follows(problem: &Problem, plan: &Planned) -> bool {
    match problem.path {
        Path::Best => true,
        Path::Shortest => plan.sense == Sense::Short,
        Path::Long => plan.sense == Sense::Long,
        Path::AsGiven(vector) => {
            Follower::begun(&problem.start.attitude).turned_by(&vector).is_on_the_sheet_of(&plan.path)
        }
    }
}
