//! Minimum time and minimum fuel: the search for the best extremal, and the discrete optimum on the
//! grid of the plan.

pub(super) mod followed;
mod pulses;
mod record;

use crate::maneuver::duration::Duration;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Path, Problem};
use crate::maneuver::settings::Method;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Landing, Outcome, Rival, Rung, Sense, Solution};
use crate::maneuver::switching::{Structure, Switching, SwitchingArc};
use crate::numerics::figures::rounded_up;
use crate::optimize::landing::{Aim, Next};
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::switching::arcs::Arcs;
use crate::optimize::methods::switching::branches::SearchRequest;
use crate::optimize::methods::switching::discretize::{arcs_on_grid, smooth_on_grid};
use crate::optimize::methods::switching::eigenaxis;
use crate::optimize::methods::switching::extremal::{Extremal, TorqueLimit};
use crate::optimize::methods::switching::flow::Node;
use crate::optimize::methods::switching::grid_step::Torque;
use crate::optimize::methods::switching::limit::{BranchEnd, BranchEnds};
use crate::optimize::methods::switching::on_grid::OnGrid;
use crate::optimize::methods::switching::pulses::on_grid::arcs_placed;
use crate::optimize::methods::switching::scaled::{ExtremalUnits, input_of, inputs, scaled};
use crate::optimize::methods::switching::search::search;
use crate::optimize::methods::switching::sequence::Step;
use crate::optimize::methods::switching::smooth::Smoothed;
use crate::optimize::methods::switching::tuning::grid::LEAST_STEPS;
use crate::optimize::methods::switching::work::{StopRequest, Work};
use crate::optimize::search::context::Context;
use crate::optimize::search::way::Follower;
use crate::{Vector3, lie};
use record::{Planned, untold};

/// Distance below which two attitudes \[rad\], or two rates in radians per unit of time, are equal.
const SAME: f64 = 1e-14;

/// Relative cost difference above which two extremals are different.
const DISTINCT: f64 = 1e-6;

/// Largest relative amount by which a bang-bang plan on the grid usually costs more than its
/// extremal in continuous time: the `O(h²)` term on some ten steps per arc.
pub(super) const OF_THE_GRID: f64 = 1e-3;

/// Durations that are tried for a minimum-fuel plan, as multiples of the shortest duration.
const STRETCHES: [f64; 3] = [1.02, 1.1, 1.5];

/// Length, as a fraction of the duration, below which an arc is omitted.
const NO_ARC: f64 = 1e-10;

/// Solves a minimum-time or minimum-fuel maneuver, which must have been checked.
///
/// If the duration has an upper bound, the plan takes all of it or, if time has a weight or the
/// body moves at an end, the duration at which the Hamiltonian vanishes.
pub(super) fn solve(problem: &Problem, context: &Context) -> Solution {
    solve_by(problem, context, true, true)
}

/// Solves for a plan that serves as an initial path, so that its true motion need not meet the
/// target.
pub(super) fn solve_discrete(problem: &Problem, context: &Context) -> Solution {
    solve_by(problem, context, true, false)
}

/// Solves by the smoothed law alone, without switching times, for comparison.
pub(super) fn solve_smoothed(problem: &Problem, context: &Context) -> Solution {
    solve_by(problem, context, false, false)
}

/// Solves the maneuver: by bang-bang arcs if `arcs` is true, otherwise by the smoothed law alone.
/// If `lands` is true, the true motion of the plan must also meet the target.
fn solve_by(problem: &Problem, context: &Context, arcs: bool, lands: bool) -> Solution {
    let once = |problem: &Problem| {
        let found = Extremals::of(problem, context, arcs)
            .map_or_else(|ended| *ended, |extremals| extremals.cheapest(lands));
        context.ladder.take();
        found
    };
    match problem.duration.at_most() {
        Some(longest) => up_to(longest, problem, context, &once),
        None => once(problem),
    }
}

/// Solves a minimum-effort or minimum-fuel maneuver with the upper bound `longest` on the duration
/// \[s\]. The plan takes the duration `longest` or, if time has a weight or the body cannot wait, the
/// optimal duration, whichever is cheaper. `once` solves for a given or a free duration.
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
    // The duration on the grid must be within the bound too. It differs from the continuous one by
    // the square of the step.
    let within = sought.trajectory.time.last().is_some_and(|duration| *duration <= longest);
    let cheaper = is_plan(&sought) && within && !(is_plan(&all) && all.cost <= sought.cost);
    let chosen = if cheaper || stopped && !is_plan(&all) { sought } else { all };
    Solution { solve_time: context.began.elapsed().as_secs_f64(), ..chosen }
}

/// Plans of a maneuver without its constraints.
pub(super) struct Unconstrained {
    /// The cheapest plan. Its true motion need not meet the target.
    pub cheapest: Solution,
    /// The cheapest plan that also satisfies the constraints, landed if required.
    pub within: Option<Solution>,
}

/// Solves a maneuver without constraints: returns the cheapest plan, and the cheapest plan for
/// which `kept` is true.
///
/// Symmetric maneuvers and other extremals of equal cost are separate plans: one may satisfy
/// constraints that another violates.
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

/// Returns whether a plan costs more than its certificate and the grid explain, so that a cheaper
/// plan may exist.
pub(super) fn is_dear(plan: &Solution) -> bool {
    let least = plan.switching.as_ref().map_or(f64::NAN, |found| found.continuous_cost - found.gap);
    plan.cost > least * (1.0 + OF_THE_GRID)
}

/// Extremals of a maneuver, to be placed on its grid.
struct Extremals<'a, 'c> {
    of: Scaled<'a>,
    context: &'a Context<'c>,
    found: BranchEnds,
    unsolved: Solution,
}

impl<'a, 'c> Extremals<'a, 'c> {
    /// Searches for the extremals. The error is the final solution, if there are no extremals to
    /// place on the grid.
    fn of(problem: &'a Problem, context: &'a Context<'c>, arcs: bool) -> Result<Self, Box<Solution>> {
        let tolerance = context.settings.tolerance;
        let mut unsolved = Solution { method: Method::Shooting, ..Solution::unsolved(problem, tolerance) };
        let Some(of) = Scaled::of(problem, context) else {
            unsolved.outcome = Outcome::NotFinite;
            return Err(unsolved.into());
        };
        let extremal = &of.extremal;
        let apart =
            lie::log(&extremal.end_attitude).norm() + (extremal.end_rate - extremal.start_rate).norm();
        let stays = match problem.path {
            Path::Long => false,
            Path::AsGiven(rotation) => rotation.norm() < SAME,
            Path::Best | Path::Shortest => true,
        };
        if apart < SAME && stays {
            let stays = extremal.given_duration.is_none() || extremal.start_rate.norm() < SAME;
            if let Some(plan) = stays.then(|| of.at_rest()).flatten() {
                return Err(finished(plan, Vec::new(), context).into());
            }
        }
        context.enter(Rung::Smoothed, "best", 0);
        let (found, sweeps, newtons) = of.searched(context, arcs);
        let note = |rung, any: bool, iterations| {
            let outcome = if any { Outcome::Converged } else { Outcome::Stalled };
            context.note(rung, "all", 0, Report { outcome, iterations, residuals: Vec::new() });
        };
        note(Rung::Smoothed, found.branches > 0, sweeps);
        if found.branches > 0 {
            note(Rung::Switches, !found.limits.is_empty(), newtons);
        }
        match context.interrupt() {
            Some(outcome) => Err(ended(unsolved, outcome, context).into()),
            None => Ok(Self { of, context, found, unsolved }),
        }
    }

    /// Returns the extremals within the upper bound on a free duration, the cheapest first. A given
    /// duration has no bound.
    fn allowed(&self) -> impl Iterator<Item = &BranchEnd> {
        let Scaled { problem, extremal, units } = &self.of;
        let longest = problem.duration.at_most().filter(|_| extremal.given_duration.is_none());
        let lasts = |limit: &BranchEnd| limit.duration() * units.time;
        self.found.limits.iter().filter(move |limit| longest.is_none_or(|longest| lasts(limit) <= longest))
    }

    /// Returns the plan of an extremal on the grid; `None` if the extremal has no plan or the plan
    /// is not in the requested homotopy class.
    fn planned(&self, limit: &BranchEnd) -> Option<Planned> {
        let Self { of, context, .. } = self;
        context.enter(Rung::Aligned, limit.name(), of.problem.steps);
        let plan = of.cheapest(limit);
        noted(context, limit.name(), of.problem.steps, plan.as_ref().map(|plan| &plan.grid));
        plan.filter(|plan| of.follows(plan))
    }

    /// Returns the cheapest plan of all extremals as a solution.
    fn cheapest(self, lands: bool) -> Solution {
        let context = self.context;
        if let Some(shortest) = self.of.problem.shortest_pulse() {
            return self.pulsed(shortest, lands);
        }
        let mut chosen: Option<(Planned, &BranchEnd)> = None;
        let arrives = |plan: &Planned| plan.error() <= context.settings.tolerance;
        for limit in self.allowed() {
            // The extremals are sorted by cost. The next one is needed only if the plan of the last
            // one costs more than its grid explains, or misses the end.
            let beats = |(plan, _): &(Planned, &BranchEnd)| {
                !arrives(plan) || self.named(limit).1 < plan.solution.cost * (1.0 - OF_THE_GRID)
            };
            if !chosen.as_ref().is_none_or(beats) || context.interrupt().is_some() {
                break;
            }
            let better = |plan: &Planned, best: &Planned| {
                let cheaper = plan.solution.cost < best.solution.cost;
                arrives(plan) && !arrives(best) || arrives(plan) == arrives(best) && cheaper
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

    /// Returns the cheapest plan for which `kept` is true, with other such plans as rivals.
    fn cheapest_kept(&self, lands: bool, kept: &dyn Fn(&Solution) -> bool) -> Option<Solution> {
        let stops = || self.context.interrupt().is_some();
        let plan = |limit: &BranchEnd, lands: bool| {
            Some(self.told(self.planned(limit)?, limit, lands)).filter(|plan| kept(plan))
        };
        let mut limits = self.allowed().take_while(|_| !stops());
        let (limit, found) = limits.find_map(|limit| Some((limit, plan(limit, lands)?)))?;
        let dearer = limits.filter(|limit| plan(limit, false).is_some());
        let rivals = rivals(dearer.map(|limit| self.named(limit)), self.named(limit).1, found.sense);
        Some(Solution { rivals, ..found })
    }

    /// Returns the name of an extremal and its cost.
    fn named(&self, limit: &BranchEnd) -> (&'static str, f64) {
        (limit.name(), limit.cost(&self.of.extremal) * self.of.units.cost())
    }

    /// Completes a plan to a solution.
    fn told(&self, mut plan: Planned, limit: &BranchEnd, lands: bool) -> Solution {
        let Self { of, context, found, .. } = self;
        if lands {
            plan = of.landed(plan, &|aimed| aimed.cheapest(limit), context);
        }
        if of.problem.objective.is_duration() {
            let eigenaxis = found.eigenaxis.or_else(|| eigenaxis::duration(&of.extremal));
            plan.switching.eigenaxis_s = eigenaxis.map(|duration| duration * of.units.time);
        }
        let all = found.limits.iter().map(|limit| self.named(limit));
        let rivals = rivals(all, plan.switching.continuous_cost, plan.solution.sense);
        finished(plan, rivals, context)
    }

    /// Returns the solution for the case that no extremal has a plan; it contains the reason.
    fn without_plan(self) -> Solution {
        let Self { of: Scaled { problem, extremal, .. }, context, found, mut unsolved } = self;
        if extremal.halt.is_raised() {
            let outcome = context.interrupt().unwrap_or(Outcome::Interrupted);
            return ended(unsolved, outcome, context);
        }
        let arcs = found.limits.iter().find_map(|limit| limit.arcs.as_ref());
        let arcs = arcs.map(|found| found.arcs.switches.len() + 1);
        unsolved.shortfall = Some(match (too_short(problem, &found, context), arcs) {
            (Some((shortest, longer)), _) => {
                (unsolved.shortest, unsolved.longer) = (Some(shortest), longer);
                Shortfall::TooShort { asked: problem.seconds(), shortest }
            }
            (None, Some(arcs)) if arcs * LEAST_STEPS > problem.steps => {
                Shortfall::FewSteps { arcs, steps: arcs * LEAST_STEPS }
            }
            _ if found.branches == 0 => Shortfall::NoSmoothedExtremal,
            _ => Shortfall::NoDiscreteOptimum { steps: problem.steps },
        });
        ended(unsolved, Outcome::Stalled, context)
    }
}

/// A maneuver and its extremal problem in scaled units.
struct Scaled<'a> {
    problem: &'a Problem,
    extremal: Extremal,
    units: ExtremalUnits,
}

impl<'a> Scaled<'a> {
    /// Scales a maneuver; `None` if the torques do not span the space or a number is out of range.
    fn of(problem: &'a Problem, context: &Context) -> Option<Self> {
        let (extremal, units) = scaled(problem)?;
        let halt = context.within(|budget| StopRequest::of(&budget.watch));
        Some(Self { problem, extremal: Extremal { halt, ..extremal }, units })
    }

    /// Searches for the best extremals. Also returns the number of sweeps over smoothed problems
    /// and the number of Newton solutions for switching times.
    fn searched(&self, context: &Context, arcs: bool) -> (BranchEnds, usize, usize) {
        let ask = SearchRequest { path: self.problem.path, thoroughness: context.settings.search, arcs };
        context.within(|budget| {
            let work = Work::of(budget.watch);
            (search(&self.extremal, &ask, &work), work.sweeps.get(), work.newtons.get())
        })
    }

    /// Returns the plan of a body that is already at its terminal state; `None` if it is not. The
    /// plan has no steps or, for a given duration, all steps without input.
    fn at_rest(&self) -> Option<Planned> {
        let (none, first) = (Vector3::zeros(), Node::at_start(&self.extremal, Vector3::zeros()));
        let given = self.extremal.given_duration;
        let (count, duration) = given.map_or((0, 0.0), |given| (self.problem.steps, given));
        let torque = Torque::Arc(Extremal::holding(&none, 0.0));
        let steps = vec![Step { arc: 0, part: 1.0 / count as f64, torque }; count];
        let off = vec![vec![-1.0; self.extremal.switching_count()]];
        let still = OnGrid::new(none, vec![duration], steps, off, vec![first; count + 1]);
        let still = OnGrid { torques: vec![none; count], residual: 0.0, ..still };
        let mut plan = self.record(&still)?;
        plan.solution.start = "rest".into();
        let continuous_duration_s = duration * self.units.time;
        plan.switching =
            Switching { continuous_duration_s, continuous_cost: 0.0, gap: 0.0, ..untold(Structure::Rest) };
        Some(plan)
    }

    /// Lands a plan if that is required: corrects it until the miss of its true motion decreases no
    /// more. Each correction solves for the extremal with a corrected discrete target, with a warm
    /// start or, if that fails, `afresh`. A stop request ends the corrections.
    fn landed(
        &self,
        first: Planned,
        afresh: &dyn Fn(&Self) -> Option<Planned>,
        context: &Context,
    ) -> Planned {
        let Self { problem, extremal, units } = self;
        let Some(mut aim) = Aim::asked(problem, context.settings) else { return first };
        let cost_before = first.solution.cost;
        let (mut plan, mut target, mut best) = (first, problem.end, None);
        loop {
            let next = aim.correct(&plan.solution.trajectory);
            if next == Next::GiveUp && best.is_some() {
                break;
            }
            plan.solution.trajectory.target = Some(target);
            plan.solution.landing = Some(Landing { cost_before, ..aim.told() });
            if next != Next::Correct || context.interrupt().is_some() {
                return plan;
            }
            target = aim.target;
            let aimed = Extremal {
                end_attitude: problem.start.attitude.tr_mul(&target.attitude),
                end_rate: units.time * target.angular_velocity,
                ..extremal.clone()
            };
            let aimed = Self { extremal: aimed, ..*self };
            let warm = plan.grid.again(&aimed.extremal).and_then(|grid| {
                let mut warm = aimed.record(&grid)?;
                let Switching { beside_optimum, .. } = warm.switching;
                warm.switching = Switching { beside_optimum, ..plan.switching.clone() };
                let kept = pulses::told_again(problem, &mut warm);
                warm.solution.start.clone_from(&plan.solution.start);
                kept.then_some(warm)
            });
            let Some(solved) = warm.or_else(|| afresh(&aimed)) else {
                return plan;
            };
            best = Some(std::mem::replace(&mut plan, solved));
        }
        best.unwrap_or(plan)
    }

    /// Returns the discrete optimum of the best arcs, or the plan nearest to it, if the arcs fit
    /// the grid. Otherwise returns the bang-bang plan with a larger gap, or the plan of the
    /// smoothed law if it is cheaper.
    fn cheapest(&self, limit: &BranchEnd) -> Option<Planned> {
        let Self { problem, extremal, .. } = self;
        let goes_on = || (!extremal.halt.is_raised()).then_some(());
        let aligned = |limit: &BranchEnd| {
            let arcs = &limit.arcs.as_ref()?.arcs;
            goes_on()?;
            // The discrete optimum may lack a pulse of the continuous one, or have its pulses in
            // another order.
            let grid = arcs_on_grid(extremal, arcs, problem.steps)
                .or_else(|| arcs_placed(extremal, arcs, problem.steps))?;
            self.planned(limit, &grid, None)
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
            // The arcs that the smoothed plan replaces are not reported.
            self.planned(&BranchEnd { arcs: None, ..limit.clone() }, &grid, Some(epsilon))
        };
        let cheaper = |a: &Planned, b: &Planned| a.solution.cost.total_cmp(&b.solution.cost);
        looser.into_iter().chain(smooth()).min_by(cheaper)
    }

    /// Returns the plan of an extremal on its grid; `smoothing` is the smoothing parameter ε if the
    /// inputs are smoothed on the grid.
    fn planned(&self, limit: &BranchEnd, grid: &OnGrid, smoothing: Option<f64>) -> Option<Planned> {
        let Self { problem, extremal, units } = self;
        let mut recorded = self.record(grid)?;
        recorded.solution.start = limit.name().into();
        let switching = &mut recorded.switching;
        switching.smoothing = smoothing;
        switching.continuous_duration_s = limit.duration() * units.time;
        switching.continuous_cost = limit.cost(extremal) * units.cost();
        if let Some(found) = &limit.arcs {
            let exact = found.is_exact(extremal);
            switching.structure = match (exact, problem.objective.fuel()) {
                (true, None) => Structure::BangBang,
                (true, Some(_)) => Structure::BangOffBang,
                (false, _) => Structure::TruncatedChattering,
            };
            switching.gap = found.gap * units.cost();
            switching.switches = found.arcs.switches.len();
            if !exact && !extremal.axes().is_empty() {
                let inputs = found.singular().into_iter().map(|level| input_of(problem, level));
                switching.singular_inputs = inputs.collect();
                switching.singular_inputs.dedup();
            }
            switching.arcs = self.told(&found.arcs);
        } else {
            // The gap is a sum of terms that are nonnegative up to round-off.
            let gap = limit.smooth.gap(extremal) * units.cost();
            switching.gap = if gap < 0.0 { 0.0 } else { gap };
            let norm = matches!(extremal.law, TorqueLimit::Norm(_)) && !extremal.counts_fuel();
            switching.structure = if norm { Structure::Norm } else { Structure::Singular };
        }
        Some(recorded)
    }

    /// Returns the arcs with the inputs of the maneuver and with times in seconds. Switches that
    /// coincide within round-off have equal times and no arc between them.
    fn told(&self, arcs: &Arcs) -> Vec<SwitchingArc> {
        let Self { problem, extremal, units } = self;
        let least = NO_ARC * arcs.duration * units.time;
        let arc = |(_, start, end, signs): (_, f64, f64, Vec<f64>)| {
            let input = match (extremal.axes(), extremal.on_arc(&signs).held()) {
                (_, None) => Vec::new(),
                ([], Some(_)) => vec![0.0; problem.actuation.count()],
                (_, Some(_)) => inputs(problem, &signs),
            };
            let (start_s, end_s) = (start * units.time, end * units.time);
            let (holds, change, touches) = (Vec::new(), Vec::new(), Vec::new());
            SwitchingArc { start_s, end_s, input, holds, change, touches }
        };
        let mut told: Vec<SwitchingArc> = arcs.arcs().into_iter().map(arc).collect();
        told.retain(|arc| arc.end_s - arc.start_s > least);
        for index in 1..told.len() {
            told[index].start_s = told[index - 1].end_s;
        }
        told
    }

    /// Returns whether a plan is in the requested homotopy class.
    fn follows(&self, plan: &Planned) -> bool {
        match self.problem.path {
            Path::Best => true,
            Path::Shortest => plan.solution.sense == Sense::Short,
            Path::Long => plan.solution.sense == Sense::Long,
            Path::AsGiven(vector) => {
                let begun = Follower::begun(&self.problem.start.attitude);
                begun.turned_by(&vector).is_on_the_sheet_of(&plan.path)
            }
        }
    }
}

/// Completes a plan on its grid to a solution.
fn finished(plan: Planned, rivals: Vec<Rival>, context: &Context) -> Solution {
    let tolerance = context.settings.tolerance;
    let outcome = if plan.error() <= tolerance { Outcome::Converged } else { Outcome::Stalled };
    let (method, switching) = (Method::Shooting, Some(plan.switching));
    ended(Solution { method, tolerance, rivals, switching, ..plan.solution }, outcome, context)
}

/// Returns the shortest duration of a maneuver \[s\], and a longer duration for which a
/// minimum-fuel extremal was found, if any. `None` if the maneuver has an extremal or if its
/// duration is not too short.
fn too_short(problem: &Problem, found: &BranchEnds, context: &Context) -> Option<(f64, Option<f64>)> {
    if found.branches > 0 || problem.seeks_duration() || problem.objective.fuel().is_none() {
        return None;
    }
    let search = |problem: &Problem| {
        let of = Scaled::of(problem, context)?;
        of.searched(context, true).0.limits.first().map(|limit| limit.duration() * of.units.time)
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

/// Returns the rivals that cost more than a plan with the cost `cost`. Of rivals with equal costs
/// only one is returned, because mirrored maneuvers cost the same.
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

/// Records whether the arcs have a discrete optimum on the grid of the plan.
fn noted(context: &Context, name: &str, steps: usize, grid: Option<&OnGrid>) {
    let outcome = if grid.is_some() { Outcome::Converged } else { Outcome::Stalled };
    let iterations = grid.map_or(0, |grid| grid.iterations);
    let residuals = grid.iter().map(|grid| grid.residual).collect();
    context.note(Rung::Aligned, name, steps, Report { outcome, iterations, residuals });
}

fn ended(solution: Solution, outcome: Outcome, context: &Context) -> Solution {
    let (ladder, solve_time) = (context.ladder.borrow().clone(), context.began.elapsed().as_secs_f64());
    Solution { outcome, ladder, solve_time, ..solution }
}
