//! Rungs under limits and constraints: SCP, from seeds that the shooting and geometry give, on a coarse grid first.
//!
//! The relaxed maneuver, without limits, is solved by shooting for each sense. Where the best of those
//! meets every limit it is the answer. Otherwise each relaxed path, and its detours around the cones it
//! crosses, seeds a convex iteration on a coarse grid; the cheapest is carried to the requested grid.
//!
//! # Which road does a limited maneuver take?
//!
//! Where only the inputs are limited, by size or by norm, the shooting goes first: from each extremal without limits, Newton
//! goes on with the saturated law (`control_law/saturated`), which costs nothing but a clamp in the kick, and brings costates
//! to round-off and a count of conjugate points. That count comes from the inertia of the accessory problem, because the
//! sensitivity matrix loses rank while all inputs are at their limits. Where the shooting finds nothing, and for all other
//! limits, SCP is taken.
//!
//! There the maneuver without limits is solved first, by shooting, for each sense. If the cheapest of those meets every limit
//! it is the answer. Otherwise each of these paths, and its detours to either side of every cone that it crosses, is a seed
//! of the convex iteration (`scp/`) on a coarse grid. The cheapest result is carried to the requested grid in one leap by
//! Newton alone where that works; where it does not, over grids four times finer each, with the convex iteration behind
//! Newton. The path between the coarse nodes is smooth, and inputs at their limits are those that the interpolated costates
//! ask for. Because limits only make a maneuver costlier, a sense whose path without limits costs more than what is already
//! found is not tried, unless wheels store momentum at the start: without it the body would move otherwise. A guess brings
//! its path as one more seed, the first.

use super::any_attitude;
use super::cheapest::{Cheapest, SHARE};
use super::coarse::chain_steps;
use super::detour::detours;
use super::effort::Starts;
use super::ladder::{Ask, Search, same};
use super::paths;
use super::transfer::{Interpolant, transfer};
use super::way::Follower;
use crate::Vector3;
use crate::lie;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Path, Problem};
use crate::maneuver::settings::{Method, Thoroughness};
use crate::maneuver::solution::{Outcome, Rung, Sense, Solution, Trajectory};
use crate::mechanics::environment::Pose;
use crate::numerics::figures::rounded_up;
use crate::optimize::candidate::{Candidate, Provenance};
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::model::Goal;
use crate::optimize::methods::scp::road::{ActiveSetNewton, Chain, ConvexIteration, path};
use crate::optimize::step::{Dynamics, Point};
use crate::optimize::sweep::BoundaryValueProblem;

/// How many times finer the next grid is, where one leap to the requested one fails.
const LEAP: usize = 4;
/// A violation on the coarse grid that spares the fine solve of the relaxed maneuver.
const CLEAR_VIOLATION: f64 = 0.05;
/// Costs of one plan on two grids differ by less, relative.
const NEAR: f64 = 0.05;
/// How far the coarse costs of two plans may lie apart, relative, for both to be carried to the fine grid, and how many are.
const CLOSE: f64 = 0.02;
const CARRIED: usize = 3;
/// Durations tried for advice, as multiples of the shortest one found: next to it a plan without a guess is hard to find.
const STRETCHES: [f64; 8] = [1.0, 1.01, 1.03, 1.1, 1.25, 1.5, 2.0, 3.0];

/// What may carry a solution to a finer grid.
#[derive(Clone, Copy)]
struct Roads {
    newton: bool,
    convex: bool,
}

impl<const N: usize> Search<'_, '_, N> {
    /// SCP, as the only road or as the last resort: there its miss says more where something is limited, and that
    /// of the shooting where nothing is.
    pub(super) fn scp(&mut self) {
        let missed = self.failure.take();
        self.scp_from_seeds();
        if self.may_be_too_short() {
            self.scp_from_the_shortest();
        }
        if self.ask.shooting && self.found.is_empty() && !self.problem.is_constrained() {
            self.failure = missed;
        }
    }

    /// SCP from all seeds; leaves the winner on the requested grid, before its rivals on the coarse one.
    fn scp_from_seeds(&mut self) {
        let problem = self.problem;
        if let Some(trajectory) = self.ask.along {
            let fine = self.chain(problem.steps);
            let seed = along("given path", trajectory, &fine.model.dynamics);
            self.descend(&fine, seed);
            return self.carry(&fine);
        }
        let relaxed = relaxed(problem);
        let coarse = self.chain(chain_steps(problem));
        let mut seeds = self.relaxed_paths(&relaxed, &coarse);
        if self.context.settings.method == Method::Auto
            && !problem.ends_in_any_attitude()
            && let Some(answer) = self.unlimited(&relaxed, &seeds)
        {
            self.answer = Some(answer);
            return;
        }
        if seeds.is_empty() {
            seeds.push((0.0, paths::shortest_way(&coarse.model)));
        }
        if let Some(guess) = self.ask.guess
            && let Some(seed) = guess.seed(&coarse.model)
            && self.as_asked(&seed)
        {
            self.descend(&coarse, seed);
        }
        // Without what its wheels store a body moves otherwise: those costs bound nothing, and the best plan may lie near none
        // of those paths.
        let bounds = problem.actuation.stored_momentum() == Vector3::zeros();
        for (cost, seed) in seeds {
            let cheaper = |found: &Attempt| found.cost < cost && self.goes_round_as_asked(&found.candidate);
            let hopeless = bounds && self.found.iter().any(cheaper);
            if hopeless || self.stopped() {
                continue;
            }
            for seed in detours(problem, &coarse.model.dynamics.frame_rate(), seed) {
                self.descend(&coarse, seed);
            }
        }
        // From rest to rest with torques about all axes the extremals without limits, and their detours, are enough as a rule.
        let asked = self.found.iter().any(|found| self.goes_round_as_asked(&found.candidate));
        let simple = bounds && asked && problem.can_wait() && self.fine.dynamics.has_all_axes();
        match self.context.settings.search {
            Thoroughness::Thorough => self.scp_from_paths(Starts::all(), &relaxed, &coarse),
            Thoroughness::Default if !simple => {
                self.scp_from_paths(Starts::bent_ways(asked), &relaxed, &coarse)
            }
            Thoroughness::Default | Thoroughness::Quick => {}
        }
        // What goes the other way round is told where nothing goes as asked.
        let mut found = std::mem::take(&mut self.found);
        if found.iter().any(|found| self.goes_round_as_asked(&found.candidate)) {
            found.retain(|found| self.goes_round_as_asked(&found.candidate));
        }
        self.found = found;
        self.carry(&coarse);
    }

    /// SCP from the paths that descents of the relaxed maneuver start from, bent and random ones among them: optima within
    /// limits need not lie near any extremal without them.
    fn scp_from_paths(&mut self, starts: Starts, relaxed: &Problem, coarse: &Chain) {
        let grid = &coarse.model.dynamics.grid;
        let bvp = BoundaryValueProblem::<N>::new(relaxed, coarse.model.steps);
        for start in starts.paths(&bvp) {
            let seed = path(&start.provenance.start, grid, start.states.iter().map(Point::pose));
            for seed in detours(self.problem, &coarse.model.dynamics.frame_rate(), seed) {
                if self.stopped() {
                    return;
                }
                self.descend(coarse, seed);
            }
        }
    }

    /// The chain of the maneuver on `steps` steps, with the duration that it states or the one that is sought.
    pub(super) fn chain(&self, steps: usize) -> Chain {
        match &self.ask.goal {
            None => Chain::new(self.problem, steps),
            Some(goal) => Chain::with_goal(self.problem, steps, goal),
        }
    }

    /// The same chain where the duration is the one that is stated: its rows are those of the chain that seeks it.
    pub(super) fn chain_of_given_duration(&self, steps: usize) -> Chain {
        match self.ask.goal.as_ref().and_then(Goal::in_given_duration) {
            None => Chain::new(self.problem, steps),
            Some(goal) => Chain::with_goal(self.problem, steps, &goal),
        }
    }

    /// The extremals of the maneuver without limits, as paths on a coarse grid.
    pub(super) fn unlimited_paths(&self, coarse: &Chain) -> Vec<Candidate> {
        let seeds = self.relaxed_paths(&relaxed(self.problem), coarse);
        if seeds.is_empty() {
            return vec![paths::shortest_way(&coarse.model)];
        }
        seeds.into_iter().map(|(_, seed)| seed).collect()
    }

    /// Plans of least effort within all limits along paths on the coarse grid, cheapest first: states and inputs to begin
    /// from.
    pub(super) fn effort_paths(&self, paths: &[Candidate]) -> Vec<Candidate> {
        let mut search = Search::<N>::new(self.problem, self.context, self.ask_of_trial(None));
        let coarse = search.chain(chain_steps(self.problem));
        for path in paths {
            for seed in detours(self.problem, &coarse.model.dynamics.frame_rate(), path.clone()) {
                if !search.stopped() {
                    search.descend(&coarse, seed);
                }
            }
        }
        search.found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let of_effort = |Attempt { candidate, .. }: Attempt| Candidate {
            costates: Vec::new(),
            multipliers: Default::default(),
            provenance: Provenance {
                start: format!("least effort, {}", candidate.provenance.start),
                ..candidate.provenance
            },
            ..candidate
        };
        search.found.into_iter().map(of_effort).collect()
    }

    /// Whether SCP finds a plan on the coarse grid that goes round as asked.
    fn finds_any(mut self) -> bool {
        let coarse = Chain::new(self.problem, chain_steps(self.problem));
        for (_, seed) in self.relaxed_paths(&relaxed(self.problem), &coarse) {
            for seed in detours(self.problem, &coarse.model.dynamics.frame_rate(), seed) {
                if self.stopped() {
                    return false;
                }
                self.descend(&coarse, seed);
                if self.found.last().is_some_and(|found| self.goes_round_as_asked(&found.candidate)) {
                    return true;
                }
            }
        }
        false
    }

    /// The extremals of the relaxed maneuver, with their scaled costs, cheapest first: limits only make them costlier.
    fn relaxed_paths(&self, relaxed: &Problem, coarse: &Chain) -> Vec<(f64, Candidate)> {
        if self.problem.ends_in_any_attitude() {
            let paths = any_attitude::paths(self.problem, &coarse.model, self.context.settings.search);
            return paths.into_iter().map(|path| (0.0, path)).collect();
        }
        let asked = relaxed.clone().with_steps(coarse.model.steps);
        let mut search = Search::<N>::new(&asked, self.context, self.ask.of_relaxed());
        search.climb_far();
        search.rank();
        let seed = |found: &Attempt, bvp: &BoundaryValueProblem<N>| {
            let extremal = paths::of_extremal(bvp, &found.candidate).ok()?;
            let poses = paths::on_grid(&search.fine, &extremal).states;
            let name = &found.candidate.provenance.start;
            Some((found.cost, path(name, &search.fine.dynamics.grid, poses.iter().map(Point::pose))))
        };
        let found = search.found.iter().filter_map(|found| seed(found, &search.fine));
        let rivals = search.rivals.iter().filter_map(|rival| seed(rival, &search.coarse));
        let mut seeds: Vec<(f64, Candidate)> = found.chain(rivals).collect();
        seeds.sort_by(|a, b| a.0.total_cmp(&b.0));
        seeds
    }

    /// The solution of the problem without limits: the shooting's, or where torques about an axis are missing and that may
    /// arrive nowhere, SCP's.
    fn shot(&self, relaxed: &Problem) -> Solution {
        let convex = self.problem.is_constrained() && !self.fine.dynamics.has_all_axes();
        let ask = Ask { convex, last: ScpOptions::default(), ..self.ask.of_relaxed() };
        let mut search = Search::<N>::new(relaxed, self.context, ask);
        search.climb_far()
    }

    /// The relaxed solution, where it meets every limit as it is.
    fn unlimited(&self, relaxed: &Problem, seeds: &[(f64, Candidate)]) -> Option<Solution> {
        let problem = self.problem;
        let (_, seed) = seeds.first().filter(|_| problem.actuation.wheels.is_none())?;
        // A clear violation on the coarse grid spares the fine solve, where there is but one best path.
        let coarse = Chain::new(problem, seed.steps());
        if self.fine.dynamics.has_all_axes()
            && coarse.worst_violation(&coarse.opened(seed))? > CLEAR_VIOLATION
        {
            return None;
        }
        let solution = self.shot(relaxed);
        if solution.outcome != Outcome::Converged {
            return None;
        }
        let fine = Chain::new(problem, problem.steps);
        let path = along("short", &solution.trajectory, &fine.model.dynamics);
        let first = fine.model.first_input();
        let mut candidate = fine.opened(&path);
        for stage in first..=problem.steps {
            let inputs = solution.trajectory.inputs(stage - first);
            candidate.inputs[stage] =
                inputs.iter().zip(&fine.model.input_unit).map(|(u, unit)| u / unit).collect();
        }
        if fine.worst_violation(&candidate)? > 0.0 {
            return None;
        }
        // The rivals are those of the relaxed maneuver: nobody knows whether they keep within the limits.
        Some(Solution { rivals: Vec::new(), ..solution })
    }

    /// One convex iteration from a seed.
    pub(super) fn descend(&mut self, chain: &Chain, seed: Candidate) {
        let options = self.options(chain);
        let attempt = self.attempt(Rung::Scp, &ConvexIteration { chain, options: &options }, seed);
        self.keep(attempt);
    }

    /// How the iteration ends on the grid of a chain.
    fn options(&self, chain: &Chain) -> ScpOptions {
        if chain.model.steps == self.problem.steps {
            self.ask.last.clone()
        } else {
            ScpOptions::default().within(self.context.settings.max_iterations)
        }
    }

    /// Carries the cheapest to the requested grid.
    pub(super) fn carry(&mut self, coarse: &Chain) {
        self.found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        if coarse.model.steps == self.problem.steps {
            return;
        }
        let found = std::mem::take(&mut self.found);
        let fine = self.chain(self.problem.steps);
        let (mut carried, mut rivals) = (Vec::<Attempt>::new(), Vec::new());
        for (index, cheapest) in found.iter().enumerate() {
            // On the fine grid the order of costs may be another.
            let close = |first: &Attempt| {
                carried.len() < CARRIED && cheapest.cost <= first.cost + CLOSE * first.cost.abs()
            };
            if self.stopped() || !carried.first().is_none_or(close) {
                rivals.extend_from_slice(&found[index..]);
                break;
            }
            let attempt = self
                .refine(coarse, &fine, cheapest, Roads { newton: true, convex: false })
                .or_else(|| self.refine_by_and_by(coarse, &fine, cheapest));
            match attempt {
                Some(attempt) if carried.iter().any(|other| same::<N>(other, &attempt)) => {}
                Some(attempt) => carried.push(attempt),
                None => rivals.push(cheapest.clone()),
            }
        }
        if !carried.is_empty() {
            carried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            self.found = carried;
            self.found.extend(rivals);
        }
    }

    /// A coarse solution carried to the fine grid over grids between, where Newton's method did not find the
    /// active set of the fine one in one leap.
    fn refine_by_and_by(&mut self, coarse: &Chain, fine: &Chain, found: &Attempt) -> Option<Attempt> {
        let between = grids_between(coarse.model.steps, fine.model.steps);
        // Newton's leap from the coarse grid itself has failed.
        let mut roads = Roads { newton: !between.is_empty(), convex: true };
        let mut last: Option<(Chain, Attempt)> = None;
        for steps in between {
            let (chain, found) = last.as_ref().map_or((coarse, found), |(chain, found)| (chain, found));
            let next = self.chain(steps);
            let refined = self.refine(chain, &next, found, roads)?;
            last = Some((next, refined));
            roads.newton = true;
        }
        let (chain, found) = last.as_ref().map_or((coarse, found), |(chain, found)| (chain, found));
        self.refine(chain, fine, found, roads)
    }

    /// A coarse solution carried to a finer grid: by Newton's method, or by the convex iteration where that fails.
    fn refine(&mut self, coarse: &Chain, fine: &Chain, found: &Attempt, roads: Roads) -> Option<Attempt> {
        let start = transfer([coarse, fine], &found.candidate);
        let options = self.options(fine);
        let near = |attempt: &Attempt| (attempt.cost - found.cost).abs() <= NEAR * found.cost;
        // Newton finds the active set of a near grid by itself as a rule.
        let newton = (roads.newton && options.polish).then(|| {
            let newton = ActiveSetNewton { chain: fine, options: &options };
            self.tried(Rung::Scp, &newton, start.clone())
        });
        let attempt = match newton.filter(near) {
            Some(attempt) => self.noted(Rung::Scp, attempt),
            None if roads.convex => {
                self.attempt(Rung::Scp, &ConvexIteration { chain: fine, options: &options }, start)
            }
            None => return None,
        };
        if attempt.converged() {
            self.add_work(&attempt);
            return Some(attempt);
        }
        self.keep(attempt);
        None
    }

    /// Whether a guess goes the way round that the problem asks for; one may well lead to the rotation that is given.
    fn as_asked(&self, seed: &Candidate) -> bool {
        matches!(self.problem.path, Path::AsGiven(_)) || self.goes_round_as_asked(seed)
    }

    /// Whether a path goes the way round that the problem asks for.
    fn goes_round_as_asked(&self, path: &Candidate) -> bool {
        let sense = || {
            let mut follower = Follower::new();
            path.states.iter().for_each(|point| follower.node(&point.attitude.value, Vector3::zeros(), 0.0));
            follower.way(&self.fine).map_or(Sense::Short, |way| way.sense)
        };
        self.asked_sense().is_none_or(|asked| asked == sense())
    }

    /// Whether nothing was found, the search was not cut short, and the duration can be sought.
    pub(super) fn may_be_too_short(&self) -> bool {
        let cut_short =
            self.failure.as_ref().is_some_and(|failure| failure.outcome == Outcome::IterationLimit);
        let searched = self.found.is_empty() && self.answer.is_none() && !cut_short && !self.stopped();
        searched && self.ask.advise && self.problem.is_constrained()
    }

    /// SCP from the plan of the shortest duration that it finds: a plan that is quicker than the maneuver asks for is on a
    /// way that the seeds have missed.
    pub(super) fn scp_from_the_shortest(&mut self) {
        let ask = self.ask_of_trial(Some(Goal { objective: Objective::Time, share: SHARE }));
        let mut search = Search::<N>::new(self.problem, self.context, ask);
        let paths = search.unlimited_paths(&search.chain(chain_steps(self.problem)));
        let Some(Cheapest { duration, attempt, .. }) = search.cheapest(paths) else { return };
        self.shortest = Some(duration);
        if duration > self.problem.seconds() {
            return;
        }
        let coarse = self.chain(chain_steps(self.problem));
        let nodes = Interpolant::of(attempt.candidate.states.iter().map(Point::pose).collect());
        let ratio = attempt.candidate.steps() as f64 / coarse.model.steps as f64;
        let pose = |node: usize| {
            let at = node as f64 * ratio;
            let low = (at.floor() as usize).min(attempt.candidate.steps() - 1);
            nodes.at(low, at - low as f64)
        };
        let grid = &coarse.model.dynamics.grid;
        let missed = self.failure.take();
        self.descend(&coarse, path("shortest", grid, (0..=grid.steps()).map(pose)));
        self.carry(&coarse);
        self.failure = missed.or(self.failure.take());
    }

    /// What is asked of a search whose answer is not that of this maneuver.
    fn ask_of_trial(&self, goal: Option<Goal>) -> Ask<'static> {
        Ask::of_goal(goal, self.context.settings)
    }

    /// A longer duration \[s\], in four digits, for which a plan is found on a coarse grid without a guess: the shortest one
    /// found, or not much longer. That is advice, not proof: the search is local.
    pub(super) fn longer(&self) -> Option<f64> {
        let found = |duration: &f64| {
            let problem = self.problem.clone().lasting(*duration);
            // What was tried for advice is no rung of this maneuver's ladder.
            let noted = self.context.ladder.borrow().len();
            let found = problem.check().is_ok()
                && Search::<N>::new(&problem, self.context, self.ask_of_trial(None)).finds_any();
            self.context.ladder.borrow_mut().truncate(noted);
            found
        };
        let from = self.shortest.unwrap_or(0.0).max(self.problem.seconds());
        let durations = STRETCHES.into_iter().map(|stretch| rounded_up(stretch * from));
        durations
            .filter(|duration| *duration > self.problem.seconds())
            .find(|longer| !self.stopped() && found(longer))
    }
}

/// The maneuver without limits, constraints and wheels.
fn relaxed(problem: &Problem) -> Problem {
    let mut relaxed = problem.clone();
    relaxed.constraints.clear();
    relaxed.actuation = problem.actuation.without_limits();
    relaxed
}

/// Grids between, each so many times finer than the one before: the nodes of one are nodes of the next wherever the
/// requested number divides, so that what acts at a node acts there again.
fn grids_between(coarse: usize, fine: usize) -> Vec<usize> {
    let parts = std::iter::successors(Some(LEAP), |parts| parts.checked_mul(LEAP));
    let mut grids: Vec<usize> =
        parts.map(|parts| fine.div_ceil(parts)).take_while(|steps| *steps >= 2 * coarse).collect();
    grids.reverse();
    grids
}

/// The path of a recorded trajectory.
pub(super) fn along(start: &str, trajectory: &Trajectory, dynamics: &Dynamics) -> Candidate {
    let pose = |(index, quaternion): (usize, &[f64; 4])| Pose {
        position: trajectory.position.get(index).map_or(Vector3::zeros(), |x| x / dynamics.units.length),
        attitude: lie::project_to_rotation(&lie::rotation_from_quaternion(quaternion)),
    };
    path(start, &dynamics.grid, trajectory.quaternion.iter().enumerate().map(pose))
}
