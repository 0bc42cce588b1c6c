//! The ladder of one start, and the comparison of all.
//!
//! Every start climbs: Newton shooting on a coarse grid, continuation in the boundary data, lifted
//! Newton from a smooth path, continuation in the horizon. What a rung finds is carried to the requested
//! grid (coarse to fine) and polished there by the shooting. Deterministic random starts come last, and
//! when all that was found is a saddle.

use super::record::{self, Way, record};
use super::{Context, continuation, geodesic};
use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::{Motion, Path, Problem, Scheme};
use crate::maneuver::solution::{Outcome, Rival, Rung, Sense, Solution};
use crate::numerics::factor::{Factor, effective};
use crate::optimize::methods::driver::{Iteration, run};
use crate::optimize::methods::shooting::guess::{self, Start};
use crate::optimize::methods::shooting::newton::{Newton, outcome_of};
use crate::optimize::methods::shooting::refine::{GridPoint, failed, refine, solve_grid};
use crate::optimize::second_order;
use crate::optimize::sweep::BoundaryValueProblem;
use nalgebra::SVector;
use std::f64::consts::{PI, TAU};

/// Fewest steps of a coarse grid.
const COARSE_STEPS: usize = 32;
/// Angle per step that a coarse grid aims at \[rad\].
const COARSE_ANGLE: f64 = 0.35;
/// Random starts tried when nothing else converges; half as many when all that did is a saddle, or for
/// the long way.
const RANDOM_STARTS: usize = 40;
/// Two extremals whose costates differ by less, relative, are one.
const SAME: f64 = 1e-6;

/// A converged extremal on the requested grid, or the best of what did not converge.
#[derive(Clone, Debug)]
pub(super) struct Found<const N: usize> {
    pub start: String,
    pub costate: SVector<f64, N>,
    pub cost: f64,
    pub residual: f64,
    pub outcome: Outcome,
    pub iterations: usize,
}

pub(super) struct Search<'a, 'c, const N: usize> {
    pub problem: &'a Problem,
    pub context: &'a Context<'c>,
    /// On the requested grid.
    pub fine: BoundaryValueProblem<N>,
    /// Where it is searched.
    coarse: BoundaryValueProblem<N>,
    pub found: Vec<Found<N>>,
    /// Extremals already met on the coarse grid.
    met: Vec<SVector<f64, N>>,
    /// Starts that have led to an extremal, new or known.
    arrived: Vec<String>,
    failure: Option<Found<N>>,
    /// What is lacking, in words, where no plan was found.
    pub shortfall: Option<String>,
}

/// Steps of the coarse grid: enough for the fastest rate that the way round suggests.
fn coarse_steps(problem: &Problem, turns: i32) -> usize {
    let rate =
        problem.start.angular_velocity.norm().max(problem.end.angular_velocity.norm()) * problem.duration;
    let relative = problem.start.attitude.tr_mul(&problem.end.attitude);
    let angle = (lie::log(&relative).norm() + TAU * f64::from(turns)).abs().max(TAU / 2.0);
    let needed = ((1.5 * angle + rate) / COARSE_ANGLE).ceil().min(problem.steps as f64) as usize;
    // Even, so that grids of 3/2 as many steps exist.
    needed.max(COARSE_STEPS).next_multiple_of(2)
}

/// The grid to search on: the coarse one where it is much cheaper than the requested one.
fn search_grid(problem: &Problem, turns: i32) -> usize {
    // Where inputs meet their limits, costates on two grids have no expansion in the step.
    if problem.actuation.is_limited() {
        return problem.steps;
    }
    let coarse = coarse_steps(problem, turns);
    // In a field the grids agree less: what is found on a coarse one may not be there on a finer.
    let worth = if problem.environment.is_free() { 2 } else { 4 };
    if worth * coarse <= problem.steps { coarse } else { problem.steps }
}

/// Solves a checked problem.
pub(super) fn solve<const N: usize>(problem: &Problem, context: &Context, guess: Option<&[f64]>) -> Solution {
    let turns = wanted_turns(problem);
    let mut search = Search::<N>::new(problem, context, &turns);
    if let Some(guess) = guess {
        search.try_guess(guess, "guess");
    }
    if guess.is_none() || search.found.is_empty() {
        if search.fine.dynamics.is_limited() {
            search.climb_limited(&turns);
        } else {
            search.climb(&turns);
        }
    }
    search.conclude()
}

/// Newton from a guess alone, on the requested grid, with no ladder behind it.
pub(super) fn polish<const N: usize>(
    problem: &Problem,
    context: &Context,
    guess: &[f64],
    start: &str,
) -> Solution {
    let mut search = Search::<N>::new(problem, context, &[0]);
    search.try_guess(guess, start);
    search.conclude()
}

/// Turns to try, in order.
fn wanted_turns(problem: &Problem) -> Vec<i32> {
    match problem.path {
        Path::Best => vec![0, -1, 1, -2],
        Path::Shortest => vec![0],
        Path::Long => vec![-1],
        Path::AsGiven(rotation) => vec![turns_as_given(problem, &rotation)],
    }
}

/// How many turns the given rotation is away from the shortest one between the boundary attitudes. It only
/// names the start; which extremal is the given one is decided by its own rotation.
fn turns_as_given(problem: &Problem, rotation: &Vector3) -> i32 {
    let relative = problem.start.attitude.tr_mul(&problem.end.attitude);
    let short = lie::log(&relative);
    // A rotation by 370° is 10° and one turn; one by −350° about the same axis is 10° less one turn.
    let axis = if short.norm() > 1e-12 { short / short.norm() } else { Vector3::x() };
    let along = rotation.norm() * rotation.dot(&axis).signum();
    ((along - short.norm()) / TAU).round() as i32
}

impl<'a, 'c, const N: usize> Search<'a, 'c, N> {
    pub fn new(problem: &'a Problem, context: &'a Context<'c>, turns: &[i32]) -> Self {
        let most = turns.iter().copied().max_by_key(|turns| turns.abs()).unwrap_or(0);
        let fine = BoundaryValueProblem::<N>::new(problem, problem.steps);
        let coarse = BoundaryValueProblem::<N>::new(problem, search_grid(problem, most));
        let (found, met, arrived) = (Vec::new(), Vec::new(), Vec::new());
        Self { problem, context, fine, coarse, found, met, arrived, failure: None, shortfall: None }
    }

    pub fn stopped(&self) -> bool {
        self.context.interrupt().is_some()
    }

    /// All starts, rung by rung.
    pub fn climb(&mut self, turns: &[i32]) {
        let fractions: &[f64] = if self.problem.path == Path::Shortest { &[1.0] } else { &[1.0, 0.3] };
        self.newton(turns, fractions);
        if self.problem.path == Path::Shortest && self.found.is_empty() {
            self.newton(turns, &[0.3]);
        }
        // The windings are rivals; only the senses, or what was asked for, are worth every rung.
        let best = matches!(self.problem.path, Path::Best);
        for &turns in turns.iter().filter(|turns| !best || **turns == 0 || **turns == -1) {
            let name = guess::name_of(turns);
            if !self.arrived.contains(&name) && !self.stopped() {
                self.continuation(turns);
            }
            // A smooth path leads elsewhere than a costate does: for the best, look there too.
            let missing = !self.arrived.contains(&name);
            if (missing || best) && !self.stopped() {
                self.lifted(turns, &Vector3::zeros(), missing);
            }
        }
        // A field, or a body that translates too, has extremals beside the straight ways.
        let rich = self.problem.motion == Motion::RigidBody || !self.problem.environment.is_free();
        if best && rich {
            for (index, axis) in [0, 1, 2, 0, 1, 2].into_iter().enumerate() {
                for turns in [0, -1] {
                    if !self.stopped() {
                        let sign = if index < 3 { 1.0 } else { -1.0 };
                        self.lifted(turns, &(Vector3::ith(axis, sign)), false);
                    }
                }
            }
        }
        if !self.settled() && !self.stopped() {
            self.random();
        }
    }

    /// Whether there is no reason to look further. A saddle has something cheaper near it.
    fn settled(&mut self) -> bool {
        self.rank();
        let Some(best) = self.found.first() else { return false };
        match self.problem.path {
            Path::AsGiven(_) | Path::Shortest => true,
            // The long way has many extremals, and no single start leads to the cheapest of them.
            Path::Long => false,
            Path::Best => second_order::conjugate_points(&self.coarse, &best.costate) == Some(0),
        }
    }

    fn try_guess(&mut self, guess: &[f64], start: &str) {
        self.context.enter(Rung::Guess, start, self.problem.steps);
        let scaled =
            SVector::<f64, N>::from_row_slice(guess).component_div(&self.fine.dynamics.units.costate());
        let costate = match self.problem.scheme {
            Scheme::LieVerlet => Ok(scaled),
            // A Lie–Euler guess is λ_0.
            Scheme::LieEuler => self
                .fine
                .dynamics
                .transition::<N>(0, &self.fine.start, &scaled)
                .map(|transition| transition.costate_before),
        };
        let tolerance = self.context.settings.tolerance;
        let newton = costate.and_then(|costate| Newton::new(&self.fine, tolerance, costate, None));
        match newton {
            Ok(newton) => {
                let limit = self.context.settings.max_iterations;
                let (newton, report) = run(newton, limit, &|| self.context.interrupt());
                self.context.note(self.problem.steps, &report);
                let (outcome, iterations) = (report.outcome, report.iterations);
                self.keep(start, newton.costate, newton.end.cost, newton.residual(), outcome, iterations);
            }
            Err(error) => self.context.note(self.problem.steps, &failed(outcome_of(error))),
        }
    }

    /// Newton shooting from the ballistic starts, on the coarse grid.
    fn newton(&mut self, turns: &[i32], fractions: &[f64]) {
        let starts = guess::ballistic(&self.coarse, turns, fractions);
        let starts = match starts {
            Ok(starts) => starts,
            Err(error) => {
                self.context.enter(Rung::Newton, "ballistic", self.coarse.dynamics.grid.steps());
                self.context.note(self.coarse.dynamics.grid.steps(), &failed(outcome_of(error)));
                return;
            }
        };
        for start in starts {
            if self.stopped() {
                return;
            }
            self.shoot(Rung::Newton, start, 0);
        }
    }

    /// Newton shooting on the coarse grid from one start, then to the fine grid.
    fn shoot(&mut self, rung: Rung, start: Start<N>, spent: usize) -> bool {
        let steps = self.coarse.dynamics.grid.steps();
        self.context.enter(rung, &start.name, steps);
        let settings = self.context.settings;
        let interrupt = || self.context.interrupt();
        let (grid, report) = solve_grid(&self.coarse, start.costate, None, true, settings, &interrupt);
        self.context.note(steps, &report);
        let spent = spent + report.iterations;
        match grid {
            Some(grid) => self.finish(&start.name, grid, spent),
            None => false,
        }
    }

    /// Carries a coarse extremal to the requested grid, unless it is known already.
    fn finish(&mut self, start: &str, grid: GridPoint<N>, spent: usize) -> bool {
        // Under a symmetry costates of one extremal differ by what has no effect: leave that out.
        let effective = grid.psi.map_or(grid.costate, |psi| effective(&psi, &grid.costate));
        let scale = effective.amax().max(1.0);
        if self.met.iter().any(|met| (met - effective).amax() < SAME * scale) {
            self.arrived.push(start.into());
            return true;
        }
        self.met.push(effective);
        self.context.enter(Rung::CoarseToFine, start, self.problem.steps);
        let interrupt = || self.context.interrupt();
        let refined = refine(self.problem, &self.fine, grid, self.context.settings, &interrupt);
        let mut iterations = spent;
        for (steps, report) in &refined.reports {
            self.context.note(*steps, report);
            iterations += report.iterations;
        }
        self.keep(start, refined.costate, refined.cost, refined.residual, refined.outcome, iterations);
        refined.outcome == Outcome::Converged
    }

    pub fn keep(
        &mut self,
        start: &str,
        costate: SVector<f64, N>,
        cost: f64,
        residual: f64,
        outcome: Outcome,
        iterations: usize,
    ) {
        let found = Found { start: start.into(), costate, cost, residual, outcome, iterations };
        if outcome == Outcome::Converged {
            self.arrived.push(start.into());
            let same = |other: &Found<N>| {
                (other.costate - found.costate).amax() < SAME * other.costate.amax().max(1.0)
            };
            if !self.found.iter().any(same) {
                self.found.push(found);
            }
        } else if self.failure.as_ref().is_none_or(|failure| residual < failure.residual) {
            self.failure = Some(found);
        }
    }

    fn continuation(&mut self, turns: i32) {
        let name = guess::name_of(turns);
        let steps = self.coarse.dynamics.grid.steps();
        self.context.enter(Rung::Continuation, &name, steps);
        let (costate, report) = continuation::in_target(&self.coarse, turns, self.context);
        self.context.note(steps, &report);
        if let Some(costate) = costate {
            self.shoot(Rung::Continuation, Start { name, costate }, report.iterations);
        }
    }

    /// Lifted Newton from a smooth path; `stretch` it from a short horizon if that fails.
    fn lifted(&mut self, turns: i32, bump: &Vector3, stretch: bool) {
        let bent = if bump.amax() > 0.0 { ", bent path" } else { ", smooth path" };
        let name = format!("{}{bent}", guess::name_of(turns));
        let steps = self.coarse.dynamics.grid.steps();
        self.context.enter(Rung::Lifted, &name, steps);
        let limit = self.context.settings.max_iterations;
        let nodes = geodesic::nodes(&self.coarse, turns, bump);
        let (mut nodes, mut report) = continuation::lifted(&self.coarse, nodes, 1e-10, limit, self.context);
        self.context.note(steps, &report);
        if nodes.is_none() && stretch && !self.stopped() {
            self.context.enter(Rung::Horizon, &name, steps);
            (nodes, report) = continuation::in_horizon(self.problem, steps, turns, self.context);
            self.context.note(steps, &report);
        }
        if let Some(nodes) = nodes {
            let start = Start { name, costate: nodes.costates[0] };
            self.shoot(Rung::Lifted, start, report.iterations);
        }
    }

    /// Deterministic random starts: random way rounds from the ballistic end.
    fn random(&mut self) {
        let Ok((end, psi)) = self.coarse.sweep_linearized(&SVector::zeros()) else { return };
        let factor = Factor::new(&psi);
        let short = end.error.fixed_rows::<3>(N - 6).into_owned();
        // The long way is looked for around itself, anything else everywhere.
        let (around, spread) = match self.problem.path {
            Path::Long => (guess::wound(&short, -1), 0.5 * PI),
            _ => (short, TAU),
        };
        let mut state = 0x5EED_u64;
        let mut uniform = move || {
            // A linear congruential step, its high bits: starts need to be spread, not random.
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / 2.0f64.powi(52) - 1.0
        };
        let starts = if self.found.is_empty() { RANDOM_STARTS } else { RANDOM_STARTS / 2 };
        for index in 0..starts {
            if self.stopped() {
                return;
            }
            let mut error = end.error;
            error.fixed_rows_mut::<3>(N - 6).copy_from(&around);
            for row in 0..N {
                error[row] += spread * uniform() * if row >= N - 6 { 1.0 } else { 0.2 };
            }
            let costate = factor.solve(&error) * (-0.5 * (1.0 + uniform()));
            let start = Start { name: format!("random {}", index + 1), costate };
            let before = self.found.len();
            self.shoot(Rung::MultiStart, start, 0);
            if self.found.len() > before && self.settled() {
                return;
            }
        }
    }

    /// How a path goes round, as far as the coarse grid tells.
    fn way(&self, found: &Found<N>) -> Way {
        record::way_round(&self.coarse, &found.costate).unwrap_or(Way {
            sense: Sense::Short,
            turned_deg: f64::NAN,
            rotation: Vector3::repeat(f64::NAN),
        })
    }

    /// How far a path is from what was asked for: the wrong sense, or another rotation than the given.
    fn astray(&self, found: &Found<N>) -> f64 {
        match self.problem.path {
            Path::Best => 0.0,
            Path::Shortest => f64::from(u8::from(self.way(found).sense != Sense::Short)),
            Path::Long => f64::from(u8::from(self.way(found).sense != Sense::Long)),
            // Half a turn at a time: extremals of one winding differ by less, windings by more.
            Path::AsGiven(rotation) => ((self.way(found).rotation - rotation).norm() / PI).floor(),
        }
    }

    /// Puts the winner first: the nearest to what was asked for, of these the lowest cost.
    pub fn rank(&mut self) {
        let found = std::mem::take(&mut self.found);
        let several = found.len() > 1;
        let mut keyed: Vec<(f64, Found<N>)> =
            found.into_iter().map(|found| (if several { self.astray(&found) } else { 0.0 }, found)).collect();
        keyed.sort_by(|(a, x), (b, y)| a.total_cmp(b).then(x.cost.total_cmp(&y.cost)));
        self.found = keyed.into_iter().map(|(_, found)| found).collect();
    }

    /// Chooses among what was found, and writes the solution.
    fn conclude(mut self) -> Solution {
        self.rank();
        let solve_time = self.context.began.elapsed().as_secs_f64();
        let winner = self.found.first().or(self.failure.as_ref());
        let cost_unit = self.fine.dynamics.units.cost;
        let rivals = self.found.iter().skip(1).map(|rival| {
            let Way { sense, turned_deg, .. } = self.way(rival);
            let conjugate_points = second_order::conjugate_points(&self.coarse, &rival.costate);
            let (start, cost) = (rival.start.clone(), rival.cost * cost_unit);
            Rival { start, sense, cost, conjugate_points, turned_deg }
        });
        let rivals = rivals.collect();
        let ladder = self.context.ladder.take();
        let unsolved = Solution::unsolved(self.problem, self.context.settings.tolerance);
        let shortfall = self.shortfall;
        let mut solution = Solution { ladder, rivals, solve_time, shortfall, ..unsolved };
        if let Some(winner) = winner {
            solution.outcome = winner.outcome;
            solution.start = winner.start.clone();
            solution.iterations = winner.iterations;
            if let Ok(recorded) = record(self.problem, &self.fine, &winner.costate) {
                solution.cost = recorded.end.cost * cost_unit;
                solution.terminal = record::terminal_error(&recorded.end.error);
                solution.sense = recorded.way.sense;
                solution.turned_deg = recorded.way.turned_deg;
                solution.trajectory = recorded.trajectory;
                solution.active = recorded.active;
                solution.optimality = second_order::optimality(&self.fine, &winner.costate);
            }
        }
        if let Some(stopped) = self.context.interrupt()
            && solution.outcome != Outcome::Converged
        {
            solution.outcome = stopped;
        }
        solution
    }
}
