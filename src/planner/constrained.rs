//! Maneuvers under limits and constraints: the convex road, from seeds that the shooting and geometry
//! give, on a coarse grid first.
//!
//! The relaxed maneuver, without limits, is solved by shooting for each sense. Where the best of those
//! meets every limit it is the answer. Otherwise each relaxed path, and its detours around the cones it
//! crosses, seeds a convex iteration on a coarse grid; the cheapest is carried to the requested grid.

use super::detour::{Seed, detours};
use super::{Context, Guess, ladder, options, record, shortfall};
use crate::dynamics::Dynamics;
use crate::environment::Pose;
use crate::extremal::Extremal;
use crate::lie;
use crate::problem::{Motion, Path, Problem};
use crate::scp::{
    self, Convex, Multipliers, Options, Watch, guess,
    iterate::Iterate,
    model::{Model, State},
    rows::Rows,
};
use crate::settings::Method;
use crate::shooting::driver::Report;
use crate::solution::{
    ActiveConstraint, ConvexWork, Optimality, Outcome, Rival, RungReport, Sense, Solution, TerminalError,
    Trajectory,
};
use crate::{Matrix3, Vector3};
use nalgebra::DVector;
use std::f64::consts::TAU;

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
        let hopeless = search.found.iter().any(|found| found.cost < cost);
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

/// A path with continuous rates through the nodes of a coarse one: cubics of Hermite on each step, in the
/// rotation vector from its first node.
struct Interpolant<'a> {
    nodes: &'a [State],
    /// From each node to the next: rotation vector, and distance.
    turns: Vec<Vector3>,
    ways: Vec<Vector3>,
}

impl<'a> Interpolant<'a> {
    fn of(nodes: &'a [State]) -> Self {
        let turns = nodes.windows(2).map(|pair| lie::log(&pair[0].attitude.tr_mul(&pair[1].attitude)));
        let ways = nodes.windows(2).map(|pair| pair[1].position - pair[0].position);
        Self { nodes, turns: turns.collect(), ways: ways.collect() }
    }

    /// The pose at a share of the step that begins at node `low`.
    fn at(&self, low: usize, share: f64) -> Pose {
        let node = &self.nodes[low];
        let turn = cubic(&self.turns, low, share);
        Pose {
            position: node.position + cubic(&self.ways, low, share),
            attitude: lie::project_to_rotation(&(node.attitude * lie::exp(&turn))),
        }
    }
}

/// The way within a step, from the ways of all: rates at the nodes are means of the two steps beside them.
fn cubic(ways: &[Vector3], low: usize, share: f64) -> Vector3 {
    let way = ways[low];
    let before = if low > 0 { 0.5 * (ways[low - 1] + way) } else { way };
    let after = ways.get(low + 1).map_or(way, |next| 0.5 * (way + next));
    // At the ends the rate goes on as inside.
    let before = if low > 0 { before } else { 2.0 * way - after };
    let after = if low + 1 < ways.len() { after } else { 2.0 * way - before };
    let (s, s2, s3) = (share, share * share, share * share * share);
    way * (3.0 * s2 - 2.0 * s3) + before * (s3 - 2.0 * s2 + s) + after * (s3 - s2)
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
    let evaluated = iterate.evaluate(model, &Rows::of(problem, model)).ok()?;
    Some(evaluated.rows.iter().map(|value| value.violation()).fold(f64::NEG_INFINITY, f64::max))
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
        self.context.enter("scp", &seed.name, model.steps);
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
        self.context.enter("scp", name, steps);
        self.context.note(steps, &report);
        if let Some(polished) = convex.polished.as_ref().filter(|polished| polished.iterations > 0) {
            let residuals = vec![convex.residuals.last().copied().unwrap_or(f64::NAN), polished.residual];
            let report = Report { outcome: Outcome::Converged, iterations: polished.iterations, residuals };
            self.context.enter("polish", name, steps);
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
                    .refine(coarse, &fine, &rows, &candidate, false)
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
        while LEAP * last.steps < fine.steps {
            let model = Model::new(self.problem, LEAP * last.steps);
            let rows = Rows::of(self.problem, &model);
            found = self.refine(&last, &model, &rows, &found, true)?;
            last = model;
        }
        self.refine(&last, fine, rows, &found, true)
    }

    /// A coarse solution carried to a finer grid: by Newton's method, or, if `convex`, by the convex iteration
    /// where that fails.
    fn refine(
        &mut self,
        coarse: &Model,
        fine: &Model,
        rows: &Rows,
        found: &Found,
        convex: bool,
    ) -> Option<Found> {
        let polished = found.convex.polished.as_ref()?;
        let ratio = coarse.steps as f64 / fine.steps as f64;
        let between = |stage: usize| {
            let at = (stage as f64 * ratio).min(coarse.steps as f64);
            let low = (at.floor() as usize).min(coarse.steps - 1);
            (low, at - low as f64)
        };
        let states = &polished.iterate.states;
        let smooth = Interpolant::of(states);
        let poses: Vec<Pose> = (0..=fine.steps)
            .map(|stage| {
                let (low, share) = between(stage);
                smooth.at(low, share)
            })
            .collect();
        let mut start = guess::along(fine, rows, &poses);
        for (stage, state) in start.states.iter_mut().enumerate() {
            let (low, share) = between(stage);
            state.wheels = &states[low].wheels * (1.0 - share) + &states[low + 1].wheels * share;
        }
        // Inputs of the coarse solution are smoother than those of its piecewise path.
        for stage in fine.first_input()..=fine.steps {
            let (low, share) = between(stage);
            let low = low.max(coarse.first_input());
            let (a, b) =
                (&polished.iterate.inputs[low], &polished.iterate.inputs[(low + 1).min(coarse.steps)]);
            start.inputs[stage] = a.iter().zip(b).map(|(a, b)| a + (b - a) * share).collect();
        }
        let costates: Vec<DVector<f64>> = (0..=fine.steps)
            .map(|stage| {
                let (low, share) = between(stage);
                let (a, b) = (&polished.multipliers.costates[low], &polished.multipliers.costates[low + 1]);
                a + (b - a) * share
            })
            .collect();
        let multipliers = Multipliers {
            costates,
            terminal: polished.multipliers.terminal.clone(),
            rows: self.carried(coarse, fine, rows, &polished.multipliers.rows),
        };
        self.context.enter("scp", &found.name, fine.steps);
        let interrupt = || self.context.interrupt();
        let watch = Watch { interrupt: &interrupt, deadline: self.context.deadline() };
        let near = |convex: &Convex| (convex.cost() - found.cost).abs() <= 0.05 * found.cost;
        let early = options(self.context.settings);
        let options = if fine.steps == self.problem.steps { self.last } else { &early };
        // Newton finds the active set of a near grid by itself as a rule.
        let newton = if options.polish {
            scp::polished_only(fine, rows, &start, &multipliers, options, &watch).filter(near)
        } else {
            None
        };
        let convex = match newton {
            Some(convex) => convex,
            None if convex => scp::run(fine, rows, start, Some(multipliers), options, &watch)?,
            None => return None,
        };
        self.note(fine.steps, &found.name, &convex);
        let (name, spent) = (found.name.clone(), (found.subproblems, found.newton));
        self.keep(fine, name, convex, spent);
        self.found.pop()
    }

    /// Multipliers of the rows on the fine grid from those on the coarse one: of the same row at the nearest
    /// stage, in proportion to the step.
    fn carried(&self, coarse: &Model, fine: &Model, rows: &Rows, multipliers: &[f64]) -> Vec<f64> {
        let coarse_rows = Rows::of(self.problem, coarse);
        let slices = |rows: &Rows, steps: usize| -> Vec<std::ops::Range<usize>> {
            let first = |stage: usize| rows.rows.partition_point(|row| row.stage < stage);
            (0..=steps).map(|stage| first(stage)..first(stage + 1)).collect()
        };
        let from = slices(&coarse_rows, coarse.steps);
        let ratio = coarse.steps as f64 / fine.steps as f64;
        let mut out = vec![0.0; rows.rows.len()];
        for (stage, slice) in slices(rows, fine.steps).into_iter().enumerate() {
            let near = from[(stage as f64 * ratio).round() as usize].clone();
            if near.len() == slice.len() {
                for (to, from) in slice.zip(near) {
                    out[to] = ratio * multipliers[from];
                }
            }
        }
        out
    }

    /// Everything that is told of a converged maneuver.
    fn fill(&self, solution: &mut Solution, model: &Model, rows: &Rows, found: Found) {
        let Some(polished) = &found.convex.polished else { return };
        solution.outcome = Outcome::Converged;
        solution.start = found.name.clone();
        solution.iterations = found.subproblems + found.newton;
        solution.convex = Some(ConvexWork { subproblems: found.subproblems, ..self.work });
        self.write(solution, model, &polished.iterate, &polished.multipliers.costates);
        solution.optimality = Optimality {
            stationarity: polished.residual,
            conjugate_points: scp::second_order::descents(
                model,
                rows,
                &polished.iterate,
                &polished.multipliers,
                &Watch { interrupt: &|| self.context.interrupt(), deadline: None },
            ),
            rank: model.terminal_count(),
            condition: f64::NAN,
        };
        solution.active = rows
            .groups
            .iter()
            .enumerate()
            .filter_map(|(group, named)| {
                let acting = rows.rows.iter().zip(&polished.multipliers.rows);
                let acting = acting.filter(|(row, multiplier)| row.group == group && **multiplier > 0.0);
                let (time_s, multiplier): (Vec<f64>, Vec<f64>) = acting
                    .map(|(row, multiplier)| (row.stage as f64 * self.problem.step(), *multiplier))
                    .unzip();
                (!time_s.is_empty()).then(|| ActiveConstraint {
                    name: named.name.clone(),
                    time_s,
                    multiplier,
                })
            })
            .collect();
    }

    /// The trajectory of an iterate in SI units, with its cost and terminal error.
    fn write(&self, solution: &mut Solution, model: &Model, iterate: &Iterate, costates: &[DVector<f64>]) {
        let Ok(replayed) = iterate.replayed(model) else { return };
        solution.cost = iterate.cost(model) * model.dynamics.units.cost;
        let (error, _) = model.terminal(&replayed.states[model.steps]);
        let norm = |row: usize| error.rows(row, 3).norm();
        let moves = model.terminal_count() == 12;
        solution.terminal = TerminalError {
            attitude_rad: norm(model.zeta()),
            momentum_relative: norm(model.pi()),
            position_relative: moves.then(|| norm(0)),
            linear_momentum_relative: moves.then(|| norm(3)),
        };
        solution.trajectory = scp::record::trajectory(self.problem, model, &replayed, costates);
        let attitudes: Vec<Matrix3> = replayed.states.iter().map(|state| state.attitude).collect();
        solution.sense = sense(self.problem, &attitudes);
        solution.turned_deg = turned_deg(model, &replayed);
    }
}

/// A maneuver that was found, as one of several.
fn rival(problem: &Problem, model: &Model, found: &Found, unit: f64) -> Rival {
    let iterate = found.convex.polished.as_ref().map_or(&found.convex.iterate, |polished| &polished.iterate);
    let attitudes: Vec<Matrix3> = iterate.states.iter().map(|state| state.attitude).collect();
    Rival {
        sense: sense(problem, &attitudes),
        start: found.name.clone(),
        cost: found.cost * unit,
        conjugate_points: None,
        turned_deg: turned_deg(model, iterate),
    }
}

/// Total angle turned, inertial \[deg\].
fn turned_deg(model: &Model, iterate: &Iterate) -> f64 {
    let rates: Vec<f64> = (0..=model.steps)
        .map(|stage| {
            let physical = model.physical(stage, &iterate.states[stage], &iterate.inputs[stage]);
            let carried = model.wheel_momentum(&physical.wheels);
            (model.dynamics.j_inverse * (physical.momentum - carried)).norm()
        })
        .collect();
    let sum: f64 = rates.windows(2).map(|pair| 0.5 * model.h * (pair[0] + pair[1])).sum();
    sum.to_degrees()
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

/// The sense of a path of attitudes; the straight one where it cannot be told.
fn sense(problem: &Problem, attitudes: &[Matrix3]) -> Sense {
    let relaxed = relaxed(problem);
    let sense = match problem.motion {
        Motion::Attitude => record::sense_of::<6>(&Extremal::new(&relaxed, problem.steps), attitudes),
        Motion::RigidBody => record::sense_of::<12>(&Extremal::new(&relaxed, problem.steps), attitudes),
    };
    sense.unwrap_or(Sense::Short)
}
