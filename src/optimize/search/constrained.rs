//! Rungs under limits and constraints: SCP, from seeds that the shooting and geometry give, on a coarse grid first.
//!
//! The relaxed maneuver, without limits, is solved by shooting for each sense. Where the best of those
//! meets every limit it is the answer. Otherwise each relaxed path, and its detours around the cones it
//! crosses, seeds a convex iteration on a coarse grid; the cheapest is carried to the requested grid.

use super::coarse::{SCP, coarse_steps};
use super::detour::detours;
use super::ladder::{Ask, Search};
use super::paths;
use super::transfer::transfer;
use super::way::Follower;
use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::{Path, Problem};
use crate::maneuver::settings::Method;
use crate::maneuver::solution::{Outcome, Rung, Sense, Solution, Trajectory};
use crate::mechanics::environment::Pose;
use crate::numerics::figures::rounded_up;
use crate::optimize::candidate::Candidate;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::model::Model;
use crate::optimize::methods::scp::road::{ActiveSetNewton, Chain, ConvexIteration, path};
use crate::optimize::step::{Dynamics, Point};
use crate::optimize::sweep::BoundaryValueProblem;

/// How many times finer the next grid is, where one leap to the requested one fails.
const LEAP: usize = 4;
/// A violation on the coarse grid that spares the fine solve of the relaxed maneuver.
const CLEAR_VIOLATION: f64 = 0.05;
/// Costs of one plan on two grids differ by less, relative.
const NEAR: f64 = 0.05;
/// Durations tried, as multiples of the one asked for.
const STRETCHES: [f64; 5] = [1.1, 1.25, 1.5, 2.0, 3.0];
/// Halvings of the last gap.
const HALVINGS: usize = 3;

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
        if self.ask.shooting && self.found.is_empty() && !self.problem.is_constrained() {
            self.failure = missed;
        }
    }

    /// SCP from all seeds; leaves the winner on the requested grid, before its rivals on the coarse one.
    fn scp_from_seeds(&mut self) {
        let problem = self.problem;
        if let Some(trajectory) = self.ask.along {
            let fine = Chain::new(problem, problem.steps);
            let seed = along("given path", trajectory, &fine.model.dynamics);
            self.descend(&fine, seed);
            return self.carry(&fine);
        }
        let relaxed = relaxed(problem);
        let coarse = Chain::new(problem, chain_steps(problem));
        let mut seeds = self.relaxed_paths(&relaxed, &coarse);
        if self.context.settings.method == Method::Auto
            && let Some(answer) = self.unlimited(&relaxed, &seeds)
        {
            self.answer = Some(answer);
            return;
        }
        if seeds.is_empty() {
            seeds.push((0.0, straight(&coarse.model)));
        }
        if let Some(guess) = self.ask.guess
            && let Some(seed) = guess.seed(&coarse.model)
            && self.as_asked(&seed)
        {
            self.descend(&coarse, seed);
        }
        for (cost, seed) in seeds {
            // Without what its wheels store a body moves otherwise: that cost bounds nothing.
            let bounds = problem.actuation.stored_momentum() == Vector3::zeros();
            let hopeless = bounds && self.found.iter().any(|found| found.cost < cost);
            if hopeless || self.stopped() {
                continue;
            }
            for seed in detours(problem, &coarse.model.dynamics.frame_rate(), seed) {
                self.descend(&coarse, seed);
            }
        }
        self.carry(&coarse);
    }

    /// Whether SCP finds a plan on the coarse grid.
    fn finds_any(mut self) -> bool {
        let coarse = Chain::new(self.problem, chain_steps(self.problem));
        for (_, seed) in self.relaxed_paths(&relaxed(self.problem), &coarse) {
            for seed in detours(self.problem, &coarse.model.dynamics.frame_rate(), seed) {
                if self.found.is_empty() && !self.stopped() {
                    self.descend(&coarse, seed);
                }
            }
        }
        !self.found.is_empty()
    }

    /// The extremals of the relaxed maneuver, with their scaled costs, cheapest first: limits only make them costlier.
    fn relaxed_paths(&self, relaxed: &Problem, coarse: &Chain) -> Vec<(f64, Candidate)> {
        let asked = relaxed.clone().with_steps(coarse.model.steps);
        let mut search = Search::<N>::new(&asked, self.context, self.ask.of_relaxed());
        search.climb();
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

    /// The shooting's solution of a problem without limits.
    fn shot(&self, relaxed: &Problem) -> Solution {
        let mut search = Search::<N>::new(relaxed, self.context, self.ask.of_relaxed());
        search.climb();
        search.conclude()
    }

    /// The relaxed solution, where it meets every limit as it is.
    fn unlimited(&self, relaxed: &Problem, seeds: &[(f64, Candidate)]) -> Option<Solution> {
        let problem = self.problem;
        let (_, seed) = seeds.first().filter(|_| problem.actuation.wheels.is_none())?;
        // A clear violation on the coarse grid spares the fine solve.
        let coarse = Chain::new(problem, seed.steps());
        if coarse.worst_violation(&coarse.opened(seed))? > CLEAR_VIOLATION {
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
    fn descend(&mut self, chain: &Chain, seed: Candidate) {
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
    fn carry(&mut self, coarse: &Chain) {
        self.found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        if coarse.model.steps == self.problem.steps {
            return;
        }
        let found = std::mem::take(&mut self.found);
        let fine = Chain::new(self.problem, self.problem.steps);
        for (index, cheapest) in found.iter().enumerate() {
            if self.stopped() {
                return;
            }
            let winner = self
                .refine(coarse, &fine, cheapest, Roads { newton: true, convex: false })
                .or_else(|| self.refine_by_and_by(coarse, &fine, cheapest));
            if let Some(winner) = winner {
                self.found.push(winner);
                let rivals = found.into_iter().enumerate().filter(|(other, _)| *other != index);
                self.found.extend(rivals.map(|(_, rival)| rival));
                return;
            }
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
            let next = Chain::new(self.problem, steps);
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

    /// Whether a path goes the way round that the problem asks for.
    fn as_asked(&self, seed: &Candidate) -> bool {
        let sense = || {
            let mut path = Follower::new();
            seed.states.iter().for_each(|point| path.node(&point.attitude.value, Vector3::zeros(), 0.0));
            path.way(&self.fine).map_or(Sense::Short, |way| way.sense)
        };
        match self.problem.path {
            Path::Best | Path::AsGiven(_) => true,
            Path::Shortest => sense() == Sense::Short,
            Path::Long => sense() == Sense::Long,
        }
    }

    /// A longer duration \[s\] for which a plan exists on a coarse grid, within an eighth of the gap to one for
    /// which none was found; in four digits. That is advice, not proof: the search is local.
    pub(super) fn longer(&self) -> Option<f64> {
        let solvable = |stretch: f64| {
            let mut problem = self.problem.clone();
            problem.duration *= stretch;
            if problem.check().is_err() {
                return false;
            }
            let last = ScpOptions::default().within(self.context.settings.max_iterations);
            let ask = Ask { shooting: false, convex: true, guess: None, along: None, last, advise: false };
            // What was tried for advice is no rung of this maneuver's ladder.
            let noted = self.context.ladder.borrow().len();
            let solvable = Search::<N>::new(&problem, self.context, ask).finds_any();
            self.context.ladder.borrow_mut().truncate(noted);
            solvable
        };
        let mut below = 1.0;
        for stretch in STRETCHES {
            if self.stopped() {
                return None;
            }
            if solvable(stretch) {
                let mut above = stretch;
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (below + above);
                    if solvable(middle) { above = middle } else { below = middle }
                }
                // A search is no better than four digits.
                return Some(rounded_up(self.problem.duration * above));
            }
            below = stretch;
        }
        None
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

/// Steps of the coarse grid of SCP.
fn chain_steps(problem: &Problem) -> usize {
    let angle = lie::minus(&problem.end.attitude, &problem.start.attitude).norm();
    coarse_steps(problem, angle, &SCP)
}

/// The path of a recorded trajectory.
fn along(start: &str, trajectory: &Trajectory, dynamics: &Dynamics) -> Candidate {
    let pose = |(index, quaternion): (usize, &[f64; 4])| Pose {
        position: trajectory.position.get(index).map_or(Vector3::zeros(), |x| x / dynamics.units.length),
        attitude: lie::project_to_rotation(&lie::rotation_from_quaternion(quaternion)),
    };
    path(start, &dynamics.grid, trajectory.quaternion.iter().enumerate().map(pose))
}

/// The cubic along the shortest rotation.
fn straight(model: &Model) -> Candidate {
    let relative = lie::minus(&model.target.attitude, &model.start.attitude);
    let pose = |stage: usize| {
        let t = stage as f64 * model.h;
        let along = 3.0 * t * t - 2.0 * t * t * t;
        Pose {
            position: model.start.position + (model.target.position - model.start.position) * along,
            attitude: model.start.attitude * lie::exp(&(relative * along)),
        }
    };
    path("straight", &model.dynamics.grid, (0..=model.steps).map(pose))
}
