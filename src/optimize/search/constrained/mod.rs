//! Maneuvers under limits and constraints: the convex road, from seeds that the shooting and geometry
//! give, on a coarse grid first.
//!
//! The relaxed maneuver, without limits, is solved by shooting for each sense. Where the best of those
//! meets every limit it is the answer. Otherwise each relaxed path, and its detours around the cones it
//! crosses, seeds a convex iteration on a coarse grid; the cheapest is carried to the requested grid.

mod report;
mod transfer;

use super::detour::{Seed, detours};
use super::{Context, Guess, ladder, options, shortfall};
use crate::lie;
use crate::maneuver::problem::{Motion, Path, Problem};
use crate::maneuver::settings::Method;
use crate::maneuver::solution::{ConvexWork, Outcome, Rival, Rung, RungReport, Sense, Solution, Trajectory};
use crate::mechanics::environment::Pose;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::scp::{
    self, Convex, Options, Watch, guess, iterate::Iterate, model::Model, rows::Rows,
};
use crate::optimize::step::Dynamics;
use crate::{Matrix3, Vector3};
use report::{rival, sense};
use std::f64::consts::TAU;
use transfer::transfer;

/// Steps of the coarse grid: enough for the angle per step and for cones between the nodes.
const COARSE_STEPS: usize = 24;
/// How many times finer the next grid is, where one leap to the requested one fails.
const LEAP: usize = 4;
/// Largest angle per step of the coarse grid \[rad\].
const COARSE_ANGLE: f64 = 0.3;
/// A converged maneuver on some grid.
struct Found {
    name: String,
    convex: Convex,
    cost: f64,
    /// Subproblems of this seed so far, and Newton iterations.
    subproblems: usize,
    newton: usize,
}

/// A path known before the search.
pub(super) enum Hint<'a> {
    None,
    /// Begin from its path as well, and first.
    Also(&'a Guess),
    /// A trajectory on the requested grid to begin from, instead of all other paths.
    Only(&'a Trajectory),
}

impl<'a> Hint<'a> {
    pub fn of(guess: Option<&'a Guess>) -> Self {
        guess.map_or(Self::None, Self::Also)
    }
}

/// Solves a checked problem by the convex road; `last` says what ends it on the requested grid.
pub(super) fn solve(problem: &Problem, context: &Context, last: &Options, hint: Hint) -> Solution {
    let relaxed = relaxed(problem);
    let coarse = coarse_steps(problem);
    let model = Model::new(problem, coarse);
    let rows = Rows::of(problem, &model);
    let mut search = Search {
        problem,
        context,
        last,
        rungs: Vec::new(),
        found: Vec::new(),
        work: ConvexWork::default(),
        best_failure: None,
    };
    if let Hint::Only(trajectory) = hint {
        let fine = Model::new(problem, problem.steps);
        let seed = Seed { name: "given path".into(), poses: poses(trajectory, &fine.dynamics) };
        search.descend(&fine, &Rows::of(problem, &fine), seed);
        return search.conclude(&fine);
    }
    let mut seeds = search.relaxed_paths(&relaxed, coarse);
    if context.settings.method == Method::Auto
        && let Some(best) = search.unlimited(&relaxed, &seeds)
    {
        return best;
    }
    if seeds.is_empty() {
        seeds.push((0.0, Seed { name: "straight".into(), poses: straight(&model) }));
    }
    if let Hint::Also(guess) = hint
        && let Some(seed) = guess.seed(&model)
        && as_asked(problem, &seed)
    {
        search.descend(&model, &rows, seed);
    }
    for (cost, seed) in seeds {
        // Without what its wheels store a body moves otherwise: that cost bounds nothing.
        let bounds = problem.actuation.stored_momentum() == Vector3::zeros();
        let hopeless = bounds && search.found.iter().any(|found| found.cost < cost);
        if hopeless || context.interrupt().is_some() {
            continue;
        }
        for seed in detours(problem, &model.dynamics.frame_rate(), seed) {
            search.descend(&model, &rows, seed);
        }
    }
    search.conclude(&model)
}

/// Whether a plan is found on the coarse grid.
pub(super) fn is_solvable(problem: &Problem, context: &Context) -> bool {
    let coarse = coarse_steps(problem);
    let model = Model::new(problem, coarse);
    let rows = Rows::of(problem, &model);
    let options = options(context.settings);
    let mut search = Search {
        problem,
        context,
        last: &options,
        rungs: Vec::new(),
        found: Vec::new(),
        work: ConvexWork::default(),
        best_failure: None,
    };
    for (_, seed) in search.relaxed_paths(&relaxed(problem), coarse) {
        for seed in detours(problem, &model.dynamics.frame_rate(), seed) {
            if search.found.is_empty() && context.interrupt().is_none() {
                search.descend(&model, &rows, seed);
            }
        }
    }
    // What was tried for advice is no rung of this maneuver's ladder.
    context.ladder.take();
    !search.found.is_empty()
}

/// The maneuver without limits, constraints and wheels.
fn relaxed(problem: &Problem) -> Problem {
    let mut relaxed = problem.clone();
    relaxed.constraints.clear();
    relaxed.actuation = problem.actuation.without_limits();
    relaxed
}

/// The shooting on a problem without limits.
fn shoot(problem: &Problem, context: &Context) -> Solution {
    match problem.motion {
        Motion::Attitude => ladder::solve::<6>(problem, context, None),
        Motion::RigidBody => ladder::solve::<12>(problem, context, None),
    }
}

/// Poses of a recorded trajectory, scaled.
fn poses(trajectory: &Trajectory, dynamics: &Dynamics) -> Vec<Pose> {
    let pose = |(index, quaternion): (usize, &[f64; 4])| Pose {
        position: trajectory.position.get(index).map_or(Vector3::zeros(), |x| x / dynamics.units.length),
        attitude: lie::project_to_rotation(&lie::rotation_from_quaternion(quaternion)),
    };
    trajectory.quaternion.iter().enumerate().map(pose).collect()
}

/// The cubic along the shortest rotation.
fn straight(model: &Model) -> Vec<Pose> {
    let relative = lie::log(&model.start.attitude.tr_mul(&model.target.attitude));
    let pose = |stage: usize| {
        let t = stage as f64 * model.h;
        let along = 3.0 * t * t - 2.0 * t * t * t;
        Pose {
            position: model.start.position + (model.target.position - model.start.position) * along,
            attitude: model.start.attitude * lie::exp(&(relative * along)),
        }
    };
    (0..=model.steps).map(pose).collect()
}

fn coarse_steps(problem: &Problem) -> usize {
    let rate = problem.start.angular_velocity.norm().max(problem.end.angular_velocity.norm());
    let relative = problem.start.attitude.tr_mul(&problem.end.attitude);
    let angle = lie::log(&relative).norm();
    // The fastest moment of a rest-to-rest slew is 1.5 times its mean rate.
    let needed = ((1.5 * angle + rate * problem.duration) / COARSE_ANGLE).ceil();
    let coarse = (needed.min(1e6) as usize).max(COARSE_STEPS).next_multiple_of(2);
    if 3 * coarse <= 2 * problem.steps { coarse } else { problem.steps }
}

/// The worst violation of all rows at an iterate.
fn worst(problem: &Problem, model: &Model, iterate: &Iterate) -> Option<f64> {
    let rows = Rows::of(problem, model);
    let evaluated = iterate.evaluate(model, &rows).ok()?;
    Some(evaluated.rows.iter().map(|value| value.violation()).fold(f64::NEG_INFINITY, f64::max))
}

/// What may carry a solution to a finer grid.
#[derive(Clone, Copy)]
struct Roads {
    newton: bool,
    convex: bool,
}

struct Search<'a, 'c> {
    problem: &'a Problem,
    context: &'a Context<'c>,
    /// How the iteration on the requested grid ends.
    last: &'a Options,
    rungs: Vec<RungReport>,
    found: Vec<Found>,
    work: ConvexWork,
    /// The nearest miss: its size, its name, its grid and where it ended.
    best_failure: Option<(f64, String, Model, Convex)>,
}

impl Search<'_, '_> {
    /// The relaxed maneuver in each sense asked for, with its scaled cost, cheapest first: limits only make
    /// it dearer.
    fn relaxed_paths(&mut self, relaxed: &Problem, coarse: usize) -> Vec<(f64, Seed)> {
        let relative = lie::log(&relaxed.start.attitude.tr_mul(&relaxed.end.attitude));
        // The long way about the same axis; its cheapest winding is looked for only where that is asked.
        let back = relative * (1.0 - TAU / relative.norm().max(1e-6));
        let senses = match relaxed.path {
            Path::Best => vec![("short", Path::Shortest), ("long", Path::AsGiven(back))],
            Path::Shortest => vec![("short", Path::Shortest)],
            Path::Long => vec![("long", Path::Long)],
            Path::AsGiven(rotation) => vec![("as given", Path::AsGiven(rotation))],
        };
        let mut seeds = Vec::new();
        for (name, path) in senses {
            let asked = relaxed.clone().with_steps(coarse).with_path(path);
            let mut solution = shoot(&asked, self.context);
            self.rungs.append(&mut solution.ladder);
            if solution.outcome == Outcome::Converged {
                let dynamics = Dynamics::new(&asked, coarse);
                let poses = poses(&solution.trajectory, &dynamics);
                seeds.push((solution.cost / dynamics.units.cost, Seed { name: name.into(), poses }));
            }
        }
        seeds.sort_by(|a, b| a.0.total_cmp(&b.0));
        seeds
    }

    /// The relaxed solution, where it meets every limit as it is.
    fn unlimited(&mut self, relaxed: &Problem, seeds: &[(f64, Seed)]) -> Option<Solution> {
        let problem = self.problem;
        let (_, seed) = seeds.first().filter(|_| problem.actuation.wheels.is_none())?;
        // A clear violation on the coarse grid spares the fine solve.
        let coarse = Model::new(problem, seed.poses.len() - 1);
        if worst(problem, &coarse, &guess::along(&coarse, &Rows::default(), &seed.poses))? > 0.05 {
            return None;
        }
        let mut solution = shoot(relaxed, self.context);
        self.rungs.append(&mut solution.ladder);
        if solution.outcome != Outcome::Converged {
            return None;
        }
        let model = Model::new(problem, problem.steps);
        let mut iterate =
            guess::along(&model, &Rows::default(), &poses(&solution.trajectory, &model.dynamics));
        let first = model.first_input();
        for stage in first..=problem.steps {
            let inputs = solution.trajectory.inputs(stage - first);
            iterate.inputs[stage] = inputs.iter().zip(&model.input_unit).map(|(u, unit)| u / unit).collect();
        }
        if worst(problem, &model, &iterate)? > 0.0 {
            return None;
        }
        solution.ladder = std::mem::take(&mut self.rungs);
        // Those of the relaxed maneuver: nobody knows whether they keep within the limits.
        solution.rivals.clear();
        solution.solve_time = self.context.began.elapsed().as_secs_f64();
        Some(solution)
    }

    /// One convex iteration from a seed.
    fn descend(&mut self, model: &Model, rows: &Rows, seed: Seed) {
        let start = guess::along(model, rows, &seed.poses);
        self.context.enter(Rung::Scp, &seed.name, model.steps);
        let interrupt = || self.context.interrupt();
        let watch = Watch { interrupt: &interrupt, deadline: self.context.deadline() };
        let early = options(self.context.settings);
        let options = if model.steps == self.problem.steps { self.last } else { &early };
        let Some(convex) = scp::run(model, rows, start, None, options, &watch) else {
            return;
        };
        self.note(model.steps, &seed.name, &convex);
        self.keep(model, seed.name, convex, (0, 0));
    }

    fn note(&mut self, steps: usize, name: &str, convex: &Convex) {
        self.work.all_subproblems += convex.subproblems;
        self.work.cone_iterations += convex.cone_iterations;
        self.work.cone_seconds += convex.cone_seconds;
        let report = Report {
            outcome: convex.outcome,
            iterations: convex.subproblems,
            residuals: convex.residuals.clone(),
        };
        self.context.enter(Rung::Scp, name, steps);
        self.context.note(steps, &report);
        if let Some(polished) = convex.polished.as_ref().filter(|polished| polished.iterations > 0) {
            let residuals = vec![convex.residuals.last().copied().unwrap_or(f64::NAN), polished.residual];
            let report = Report { outcome: Outcome::Converged, iterations: polished.iterations, residuals };
            self.context.enter(Rung::Polish, name, steps);
            self.context.note(steps, &report);
        }
    }

    fn keep(&mut self, model: &Model, name: String, convex: Convex, spent: (usize, usize)) {
        let newton = spent.1 + convex.polished.as_ref().map_or(0, |polished| polished.iterations);
        let subproblems = spent.0 + convex.subproblems;
        match &convex.polished {
            Some(polished) => {
                let cost = polished.cost;
                let same = |found: &Found| (found.cost - cost).abs() <= 1e-9 * cost.abs().max(1e-12);
                if !self.found.iter().any(same) {
                    self.found.push(Found { name, convex, cost, subproblems, newton });
                }
                self.found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            }
            None => {
                let miss = convex.miss();
                if self.best_failure.as_ref().is_none_or(|failure| miss < failure.0) {
                    self.best_failure = Some((miss, name, model.clone(), convex));
                }
            }
        }
    }

    /// Carries the cheapest to the requested grid and records it.
    fn conclude(mut self, coarse: &Model) -> Solution {
        let problem = self.problem;
        let unsolved = Solution::unsolved(problem, self.context.settings.tolerance);
        let mut solution = Solution { method: Method::Scp, ..unsolved };
        let found = std::mem::take(&mut self.found);
        let unit = coarse.dynamics.units.cost;
        let rivals: Vec<Rival> = found.iter().map(|found| rival(problem, coarse, found, unit)).collect();
        let fine = Model::new(problem, problem.steps);
        let rows = Rows::of(problem, &fine);
        let mut winner = None;
        if coarse.steps == problem.steps {
            winner = found.into_iter().next();
        } else {
            for candidate in found {
                if self.context.interrupt().is_some() {
                    break;
                }
                winner = self
                    .refine(coarse, &fine, &rows, &candidate, Roads { newton: true, convex: false })
                    .or_else(|| self.refine_by_and_by(coarse, &fine, &rows, candidate));
                if winner.is_some() {
                    break;
                }
            }
        }
        // The solver's own time, without the second-order test.
        solution.solve_time = self.context.began.elapsed().as_secs_f64();
        match winner {
            Some(found) => {
                solution.rivals = rivals.into_iter().filter(|rival| rival.start != found.name).collect();
                self.fill(&mut solution, &fine, &rows, found);
            }
            None => {
                if let Some((_, name, model, convex)) = self.best_failure.take() {
                    solution.outcome = convex.outcome;
                    solution.start = name;
                    solution.iterations = convex.subproblems;
                    let rows = Rows::of(problem, &model);
                    solution.shortfall = Some(shortfall::violated(&convex, &rows, solution.iterations));
                    if model.steps == problem.steps {
                        self.write(&mut solution, &model, &convex.iterate, &convex.multipliers.costates);
                    }
                }
                if solution.outcome == Outcome::Converged {
                    solution.outcome = Outcome::Stalled;
                }
                if let Some(stopped) = self.context.interrupt() {
                    solution.outcome = stopped;
                }
            }
        }
        self.rungs.append(&mut self.context.ladder.take());
        solution.ladder = self.rungs;
        solution
    }

    /// A coarse solution carried to the fine grid over grids between, where Newton's method did not find the
    /// active set of the fine one in one leap.
    fn refine_by_and_by(&mut self, coarse: &Model, fine: &Model, rows: &Rows, found: Found) -> Option<Found> {
        let (mut last, mut found) = (coarse.clone(), found);
        // Newton's leap from the coarse grid itself has failed.
        let mut roads = Roads { newton: false, convex: true };
        while 2 * LEAP * last.steps <= fine.steps {
            roads.newton = true;
            let model = Model::new(self.problem, LEAP * last.steps);
            let rows = Rows::of(self.problem, &model);
            found = self.refine(&last, &model, &rows, &found, roads)?;
            last = model;
        }
        self.refine(&last, fine, rows, &found, roads)
    }

    /// A coarse solution carried to a finer grid: by Newton's method, or by the convex iteration where that fails.
    fn refine(
        &mut self,
        coarse: &Model,
        fine: &Model,
        rows: &Rows,
        found: &Found,
        roads: Roads,
    ) -> Option<Found> {
        let polished = found.convex.polished.as_ref()?;
        let (start, multipliers) = transfer(self.problem, [coarse, fine], rows, polished);
        self.context.enter(Rung::Scp, &found.name, fine.steps);
        let interrupt = || self.context.interrupt();
        let watch = Watch { interrupt: &interrupt, deadline: self.context.deadline() };
        let near = |convex: &Convex| (convex.cost() - found.cost).abs() <= 0.05 * found.cost;
        let early = options(self.context.settings);
        let options = if fine.steps == self.problem.steps { self.last } else { &early };
        // Newton finds the active set of a near grid by itself as a rule.
        let newton = if roads.newton && options.polish {
            scp::polished_only(fine, rows, &start, &multipliers, options, &watch).filter(near)
        } else {
            None
        };
        let convex = match newton {
            Some(convex) => convex,
            None if roads.convex => scp::run(fine, rows, start, Some(multipliers), options, &watch)?,
            None => return None,
        };
        self.note(fine.steps, &found.name, &convex);
        let (name, spent) = (found.name.clone(), (found.subproblems, found.newton));
        self.keep(fine, name, convex, spent);
        self.found.pop()
    }
}

/// Whether a path goes the way round that the problem asks for.
fn as_asked(problem: &Problem, seed: &Seed) -> bool {
    let attitudes: Vec<Matrix3> = seed.poses.iter().map(|pose| pose.attitude).collect();
    match problem.path {
        Path::Best | Path::AsGiven(_) => true,
        Path::Shortest => sense(problem, &attitudes) == Sense::Short,
        Path::Long => sense(problem, &attitudes) == Sense::Long,
    }
}
