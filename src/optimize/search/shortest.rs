//! The shortest duration within limits and constraints: SCP with the duration as an unknown (`methods/scp/model`).
//!
//! Time alone leaves choices: where one input is at its limit throughout, others may do this or that. A little effort in the
//! cost decides them, and keeps every subproblem and Newton matrix regular. On the requested grid its share is lowered
//! until the duration does not feel it: with a share ε the optimum is longer by `O(ε²)` where inputs are free on arcs, and
//! by nothing where each is at a limit but for as many as the terminal conditions ask for.
//!
//! Seeds are the paths of least effort without limits, that of minimum time under torque limits alone, straight and
//! bent, and their detours around the cones they cross. What is found is a local minimum; how far the shortest of
//! them is the shortest of all nobody knows.

use super::coarse::chain_steps;
use super::context::Context;
use super::detour::detours;
use super::ladder::{Ask, Search};
use super::switching;
use crate::Vector3;
use crate::lie;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Method;
use crate::maneuver::solution::{Outcome, Rung, Solution, Trajectory};
use crate::mechanics::actuators::LimitKind;
use crate::mechanics::environment::Pose;
use crate::optimize::candidate::Candidate;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::road::{Chain, ConvexIteration, path};
use std::f64::consts::PI;

/// Share of the effort in the cost while durations are compared, and how it is lowered for the one that is told.
pub(super) const SHARE: f64 = 1e-2;
const LAST_SHARES: [f64; 3] = [1e-3, 1e-4, 1e-6];
/// How far the path of minimum time is bent to either side \[rad\]: a turn about one axis is often a saddle.
const BENT: f64 = 0.5;
/// Durations of one plan with two shares of the effort differ by less, relative.
const NEAR: f64 = 0.01;
/// Most subproblems from one share to the next.
const FEW: usize = 12;

/// The shortest duration that was found.
pub(super) struct Shortest {
    /// In seconds.
    pub duration: f64,
    /// The plan of that duration, which the chain of it takes.
    pub attempt: Attempt,
    /// Longer ones, each a local minimum, on a coarse grid \[s\].
    pub rivals: Vec<(Attempt, f64)>,
}

/// Solves a maneuver of minimum time that more than torque limits shapes.
pub(super) fn solve(problem: &Problem, context: &Context) -> Solution {
    let bare = Problem {
        constraints: Vec::new(),
        actuation: problem.actuation.of_jumping_inputs(),
        ..problem.clone()
    };
    let quick = switching::solve(&bare, context);
    *context.ladder.borrow_mut() = quick.ladder.clone();
    if quick.trajectory.time.len() == 1 {
        // The body is where it should be.
        let stored = problem.actuation.wheels.iter().flat_map(|wheels| wheels.momentum.clone()).collect();
        let trajectory = Trajectory { wheel_momentum: stored, ..quick.trajectory };
        return Solution { trajectory, ..quick };
    }
    let unsolved = Solution::unsolved(problem, context.settings.tolerance);
    let stated = quick.trajectory.time.last().copied().unwrap_or_else(|| about(problem));
    let stated = Problem { objective: Objective::default(), duration: stated, ..problem.clone() };
    let mut solution = match (stated.check(), context.interrupt()) {
        (_, Some(stopped)) => Solution { outcome: stopped, ..unsolved },
        (Err(error), _) => Solution { shortfall: Some(error.to_string()), ..unsolved },
        (Ok(()), None) => of_stated(&stated, context, &quick.trajectory),
    };
    solution.ladder = context.ladder.take();
    solution.solve_time = context.began.elapsed().as_secs_f64();
    solution
}

/// The solution of minimum time, with the duration of `stated` as the unit of time.
fn of_stated(stated: &Problem, context: &Context, quick: &Trajectory) -> Solution {
    let last = ScpOptions::default().within(context.settings.max_iterations);
    let ask = Ask {
        shooting: false,
        convex: true,
        guess: None,
        along: None,
        last,
        advise: false,
        share: Some(SHARE),
    };
    let mut search = Search::<6>::new(stated, context, ask);
    let paths = bent(resampled(&search.chain(chain_steps(stated)), quick));
    let found = search.shortest(paths);
    let Some(Shortest { duration, attempt, rivals }) = found else {
        // The nearest miss has a duration of its own, which is none of a plan.
        let missed = search.failure.as_ref();
        return Solution {
            method: Method::Scp,
            outcome: context.interrupt().or(missed.map(|missed| missed.outcome)).unwrap_or(Outcome::Stalled),
            shortfall: missed.and_then(|missed| missed.shortfall.clone()),
            ..Solution::unsolved(stated, context.settings.tolerance)
        };
    };
    let planned = stated.clone().with_duration(duration);
    let written = Search::<6>::new(&planned, context, search.ask.clone());
    let mut solution = Solution::unsolved(&planned, context.settings.tolerance);
    written.write(&mut solution, &attempt);
    solution.cost = duration;
    solution.rivals =
        rivals.iter().map(|(rival, duration)| written.rival_of_cost(rival, *duration)).collect();
    written.held_to_all(solution)
}

impl<const N: usize> Search<'_, '_, N> {
    /// The shortest of the locally minimal durations that SCP finds along `paths`, which are on its coarse grid, and along
    /// those of least effort without limits.
    pub(super) fn shortest(&mut self, mut paths: Vec<Candidate>) -> Option<Shortest> {
        let coarse = self.chain(chain_steps(self.problem));
        paths.extend(self.unlimited_paths(&coarse));
        for path in paths {
            for seed in detours(self.problem, &coarse.model.dynamics.frame_rate(), path) {
                if !self.stopped() {
                    self.descend(&coarse, seed);
                }
            }
        }
        self.carry(&coarse);
        let stated = self.problem.duration;
        let mut found = std::mem::take(&mut self.found).into_iter();
        let first = found.next().filter(|first| first.candidate.steps() == self.problem.steps)?;
        let first = self.sharpened(first);
        let duration = stated * first.candidate.grid.duration();
        let chain = self.chain(self.problem.steps);
        let attempt = chain.of_given_duration(first, self.problem.duration);
        let rivals = found.map(|rival| {
            let duration = stated * rival.candidate.grid.duration();
            (rival, duration)
        });
        Some(Shortest { duration, attempt, rivals: rivals.collect() })
    }

    /// A plan on the requested grid with less and less effort in its cost, as far as that goes. Other limits begin to act
    /// from share to share: a convex subproblem finds them sooner than Newton does.
    fn sharpened(&self, mut found: Attempt) -> Attempt {
        let options = self.ask.last.clone().within(FEW);
        for share in LAST_SHARES {
            let chain = Chain::seeking(self.problem, self.problem.steps, share);
            let convex = ConvexIteration { chain: &chain, options: &options };
            let next = self.attempt(Rung::Scp, &convex, found.candidate.clone());
            let [before, after] = [&found, &next].map(|attempt| attempt.candidate.grid.duration());
            if !(next.converged() && (before - after).abs() <= NEAR * before) {
                break;
            }
            found = next;
        }
        found
    }
}

/// The path of a plan of minimum time on the grid of a chain; none where there is no plan.
fn resampled(chain: &Chain, quick: &Trajectory) -> Vec<Candidate> {
    let Some(duration) = quick.time.last() else { return Vec::new() };
    let grid = &chain.model.dynamics.grid;
    let pose = |node: usize| {
        let time = duration * grid.time(node);
        let after = quick.time.partition_point(|at| *at <= time).clamp(1, quick.time.len() - 1);
        let [from, to] = [after - 1, after].map(|row| lie::rotation_from_quaternion(&quick.quaternion[row]));
        let part = (time - quick.time[after - 1]) / (quick.time[after] - quick.time[after - 1]);
        let turn = lie::minus(&to, &from) * part.clamp(0.0, 1.0);
        Pose { position: chain.model.start.position, attitude: from * lie::exp(&turn) }
    };
    vec![path("minimum time", grid, (0..=grid.steps()).map(pose))]
}

/// Paths, and the same bent to either side about each reference axis.
fn bent(paths: Vec<Candidate>) -> Vec<Candidate> {
    let sides = [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().flat_map(|axis| [axis, -axis]);
    let bends: Vec<Vector3> = sides.map(|side| side * BENT).collect();
    let bend = |straight: &Candidate, turn: &Vector3| {
        let poses = straight.states.iter().enumerate().map(|(node, point)| {
            let part = (PI * node as f64 / straight.steps() as f64).sin();
            Pose { attitude: lie::exp(&(turn * part)) * point.attitude.value, ..point.pose() }
        });
        let name = format!("{}, bent", straight.provenance.start);
        path(&name, &straight.grid, poses)
    };
    let turned =
        paths.iter().flat_map(|path| bends.iter().map(move |turn| bend(path, turn))).collect::<Vec<_>>();
    paths.into_iter().chain(turned).collect()
}

/// About how long a turn about a fixed axis takes \[s\].
fn about(problem: &Problem) -> f64 {
    let limits =
        problem.actuation.limits().filter(|limit| matches!(limit.kind, LimitKind::Size | LimitKind::Norm));
    let bound = limits.flat_map(|limit| limit.bounds.iter().copied()).fold(f64::INFINITY, f64::min);
    let inertia = problem.body.inertia.j().norm();
    let turn = lie::minus(&problem.end.attitude, &problem.start.attitude).norm().max(0.1);
    let rates = (problem.end.angular_velocity - problem.start.angular_velocity).norm();
    2.0 * (turn * inertia / bound).sqrt() + rates * inertia / bound
}
