//! Rungs of the maneuver without limits: ballistic starts, descents on paths, the lifted Newton.
//!
//! All extremals are looked for on a coarse grid. Costs there are wrong by some percent at high rates and then rank
//! wrongly: every one that may be the cheapest is carried to the requested grid, and compared there.
//!
//! # How is the best way found?
//!
//! The lifted Newton is also what carries a minimum of an unstable body, where single shooting amplifies. On the requested
//! grid an extremal may satisfy all conditions at its nodes and still not be reached from λ₋₁, because round-off of the
//! costates grows along the way. Then the nodes are the plan: SCP takes their path, which is optimal already, and writes
//! states, inputs and multipliers of every step. Where the Newton stalls because the last of the authority leaves the problem
//! nearly singular, SCP goes on from the path of the minimum. An extremal of the coarse grid whose cost on the requested one
//! differs by more than 15 %, or whose nodes there are a radian off its path, was lost on the way (costs alone let one
//! extremal pass for another); its path is descended again there. The coarse grid resolves how fast a field may swing the
//! body, and not only the turn asked for: on 32 steps the cheapest plan of a stiff pendulum does not exist. No count of
//! starts makes the lowest cost found the global minimum: how often it is the best known is counted (`cargo run --release -p
//! evidence --bin families`).

use super::authority::{Authority, WIDENED};
use super::coarse::rough_grid;
use super::effort::Starts;
use super::ladder::Search;
use super::minima::{Minima, SAME_MINIMUM};
use super::way::Follower;
use super::{paths, starts};
use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::Path;
use crate::maneuver::settings::{Method, Thoroughness};
use crate::maneuver::solution::{Outcome, Rung, Sense, Solution};
use crate::optimize::candidate::Candidate;
use crate::optimize::methods::descent::Descent;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::lifted::LiftedNewton;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::road::path;
use crate::optimize::methods::shooting::newton::outcome_of;
use crate::optimize::step::{Dynamics, Point};
use crate::optimize::sweep::{BoundaryValueProblem, Node};

/// Tolerance of the lifted Newton, which the shooting polishes.
pub(super) const LIFTED_TOLERANCE: f64 = 1e-10;
/// What a descent on the coarse grid may leave of the cost, relative.
const DESCENT_TOLERANCE: f64 = 1e-9;
/// The same on the requested grid.
const FINE_TOLERANCE: f64 = 1e-14;
/// How much dearer than the cheapest on the coarse grid a minimum may be and still turn out the cheapest.
const MARGIN: f64 = 0.15;
/// A path that is farther from the one asked for goes another way round.
const ASTRAY: f64 = 1.0;
/// Most minima that are followed further.
const MOST_MINIMA: usize = 6;
/// Starts without a lower minimum after which a search that is half done ends, unless it is to be thorough.
const IDLE: usize = 20;
/// Costs of a minimum and of its extremal on one grid differ by less, relative.
const SAME_BRANCH: f64 = 1e-4;
/// The same where the last of a widened authority is taken away.
const NARROW: f64 = 0.02;
/// Most minima that authority is taken away from, counted level by level.
const MOST_BRANCHES: usize = 100;
/// Nodes of one extremal on two grids are nearer than this \[rad\]; on the coarsest they differ by up to 0.4.
const SAME_PATH: f64 = 1.0;
/// Saddles that are left, one after the other.
const MOST_SADDLES: usize = 3;
/// So many of the lowest minima are hopped from in turn, by so much \[rad\], and so many times the hops in vain at most.
const HOP_FROM: usize = 4;
const HOPS_BY: [f64; 2] = [0.4, 1.0];
const MOST_HOPS: usize = 10;
/// Most paths that the lifted Newton is tried on directly.
const MOST_LIFTED: usize = 2;
/// How much dearer than the cheapest on the coarse grid a minimum on a rougher one may be.
const ROUGH_MARGIN: f64 = 0.5;
/// How often the lifted Newton may take its iterations on the requested grid: the valley from the last authority to none is long.
const PATIENCE: usize = 4;
/// Levels through which a path goes on the requested grid.
const LAST_LEVELS: [usize; 3] = [2, 3, WIDENED.len() - 1];
/// Most steps of a descent or a lifted Newton on the requested grid: they keep the matrices of every step.
const MOST_STEPS: usize = 20_000;

impl<const N: usize> Search<'_, '_, N> {
    /// The extremals without limits: those that Newton meets from the ballistic starts, and the minima that descents end at. The
    /// shorter and the longer way of a body that rests at both ends, and can do all, are each what Newton meets, unless the search is
    /// to be thorough.
    pub(super) fn extremals(&mut self) {
        self.ballistic();
        let sense = self.asked_for_a_sense().is_some();
        let wide = || Starts::of(self.problem, &self.coarse, self.context.settings.search).is_wide();
        if self.problem.path == Path::Best || !self.is_as_asked() || sense && wide() {
            self.descents();
        }
        self.carry_extremals();
    }

    /// What is left to try where the requested grid shows a saddle, the wrong way round or nothing at all.
    pub(super) fn look_further(&mut self, mut solution: Solution) -> Solution {
        for _ in 0..MOST_SADDLES {
            let saddle = self.found.first().filter(|_| !matches!(self.problem.path, Path::AsGiven(_)));
            let Some(saddle) = saddle.map(|saddle| saddle.candidate.clone()) else { break };
            if self.stopped() || self.satisfies(&solution) || !self.leave(&saddle) {
                break;
            }
            solution = self.conclude();
        }
        if !self.satisfies(&solution) && !self.descended && !self.stopped() {
            self.descents();
            self.carry_extremals();
            solution = self.conclude();
        }
        solution
    }

    /// Leaves a saddle of the requested grid for a minimum. Whether it led to another extremal.
    fn leave(&mut self, saddle: &Candidate) -> bool {
        if self.problem.steps > MOST_STEPS {
            return false;
        }
        let known = self.found.len();
        let path = match saddle.provenance.method {
            Method::Scp => Ok(paths::of_states(&self.fine, saddle)),
            _ => paths::of_extremal(&self.fine, saddle),
        };
        if let Ok(path) = path {
            self.descend_on_requested_grid(path);
        }
        self.found.len() > known
    }

    /// Whether an extremal on the coarse grid goes the way that was asked for.
    fn is_as_asked(&self) -> bool {
        match self.problem.path {
            // Told on the requested grid, where it costs nothing more.
            Path::Shortest | Path::Best => !self.pool.is_empty(),
            Path::Long | Path::AsGiven(_) => self.pool.iter().any(|found| self.astray(found) < ASTRAY),
        }
    }

    /// The sense that is asked for, where any path of it will do.
    fn asked_for_a_sense(&self) -> Option<Sense> {
        match self.problem.path {
            Path::Shortest => Some(Sense::Short),
            Path::Long => Some(Sense::Long),
            Path::Best | Path::AsGiven(_) => None,
        }
    }

    /// Whether a path is of that sense.
    fn is_of_the_sense(&self, path: &Candidate) -> bool {
        self.asked_for_a_sense().is_none_or(|asked| {
            let mut follower = Follower::new();
            path.states.iter().for_each(|node| follower.node(&node.attitude.value, Vector3::zeros(), 0.0));
            // Where the motion without inputs cannot be followed there is nothing to tell the senses by.
            follower.way(&self.coarse).map_or(true, |way| way.sense == asked)
        })
    }

    /// The lowest cost of some attempts that go as asked.
    fn lowest<'x>(&self, attempts: impl Iterator<Item = &'x Attempt>) -> f64 {
        let right = attempts.filter(|attempt| self.astray(attempt) < ASTRAY);
        right.map(|attempt| attempt.cost).fold(f64::INFINITY, f64::min)
    }

    /// Newton shooting from the ballistic starts.
    fn ballistic(&mut self) {
        for fraction in [1.0, 0.3] {
            let steps = self.coarse.dynamics.grid.steps();
            let turns: Vec<i32> = self.turns.iter().copied().filter(|turns| !self.arrived(*turns)).collect();
            if turns.is_empty() {
                return;
            }
            match starts::ballistic(&self.coarse, &turns, fraction) {
                Ok(starts) => {
                    for start in starts {
                        if !self.stopped() {
                            let _ = self.shoot(Rung::Newton, start);
                        }
                    }
                }
                Err(error) => {
                    self.context.note(Rung::Newton, "ballistic", steps, Report::failed(outcome_of(error)));
                }
            }
        }
    }

    /// Whether the start with these turns has led to an extremal.
    fn arrived(&self, turns: i32) -> bool {
        self.arrived.contains(&starts::name_of(turns))
    }

    /// Descents from all starts; the cheapest minima, made extremals of the coarse grid.
    fn descents(&mut self) {
        self.descended = true;
        let coarse = self.coarse.clone();
        let starts = Starts::of(self.problem, &coarse, self.context.settings.search);
        let authority = Authority::of(&coarse.dynamics);
        let given = matches!(self.problem.path, Path::AsGiven(_));
        let nothing = self.lowest(self.pool.iter()).is_infinite();
        if given || nothing || authority == Authority::Missing {
            self.lift(&coarse, starts.paths(&coarse));
        }
        let mut minima = Minima::default();
        if authority == Authority::Even {
            minima = self.minima(&coarse, &starts, 0);
        } else {
            let rough = self.fine.on_steps(rough_grid(self.problem, &coarse)).heard_by(self.context);
            let last = authority.levels().len() - 1;
            let wide = authority == Authority::Missing || starts.hops > 0;
            let levels = [(0, wide), (last, authority == Authority::Uneven)];
            let mut open = Vec::new();
            for (level, _) in levels.into_iter().filter(|(_, wanted)| *wanted) {
                let minima = self.minima(&rough, &starts, level).0;
                open.extend(minima.into_iter().map(|minimum| (level, minimum)));
            }
            self.narrow(&coarse, open, &mut minima);
        }
        let margin = if given { f64::INFINITY } else { MARGIN };
        let enough = minima.0.first().map_or(f64::INFINITY, |best| best.cost * (1.0 + margin));
        for minimum in minima.0.into_iter().take_while(|minimum| minimum.cost <= enough).take(MOST_MINIMA) {
            if !self.stopped() {
                self.arrive(&coarse, minimum);
            }
        }
    }

    /// What descents from all starts end at, with the authority of a level.
    fn minima(&self, coarse: &BoundaryValueProblem<N>, starts: &Starts, level: usize) -> Minima {
        let wide = self.descends_on(&coarse.dynamics, level);
        let mut minima = Minima::default();
        let known = self.pool.iter().filter_map(|found| {
            let path = paths::of_extremal(&self.coarse, &found.candidate).ok()?;
            Some(if path.steps() == coarse.dynamics.grid.steps() {
                path
            } else {
                paths::on_grid(coarse, &path)
            })
        });
        let all = known.chain(starts.paths(coarse)).filter(|path| self.is_of_the_sense(path));
        let all: Vec<Candidate> = all.collect();
        let most = all.len();
        let patient = self.context.settings.search == Thoroughness::Thorough || starts.hops > 0;
        let mut idle = 0;
        for (done, start) in all.into_iter().enumerate() {
            if self.stopped() || (!patient && idle >= IDLE && 2 * done >= most) {
                break;
            }
            let minimum = self.descended(coarse, &wide, start, DESCENT_TOLERANCE, &minima.0);
            let place = self.is_of_the_sense(&minimum.candidate).then(|| minima.add(minimum)).flatten();
            idle = if place == Some(0) { 0 } else { idle + 1 };
        }
        self.hop(coarse, &wide, &mut minima, starts.hops);
        minima
    }

    /// Hops from the lowest minima to others near them: bent at random, and descended again. Where minima are many the
    /// lowest lie side by side, and are met sooner from one another than from afar.
    fn hop(&self, coarse: &BoundaryValueProblem<N>, wide: &Dynamics, minima: &mut Minima, patience: usize) {
        let mut bends = paths::Bends::new();
        let (mut idle, mut hops) = (0, 0);
        while idle < patience && hops < MOST_HOPS * patience && !self.stopped() {
            let Some(from) = minima.0.get(hops % HOP_FROM.min(minima.0.len().max(1))) else { return };
            let by = HOPS_BY[hops / HOP_FROM % HOPS_BY.len()];
            let start = paths::bent_at_random(coarse, &from.candidate, &mut bends, by);
            let minimum = self.descended(coarse, wide, start, DESCENT_TOLERANCE, &minima.0);
            let place = self.is_of_the_sense(&minimum.candidate).then(|| minima.add(minimum)).flatten();
            idle = if place.is_some_and(|place| place < HOP_FROM) { 0 } else { idle + 1 };
            hops += 1;
        }
    }

    /// Extremals that the lifted Newton finds from the first of the paths, saddles among them.
    fn lift(&mut self, coarse: &BoundaryValueProblem<N>, paths: Vec<Candidate>) {
        let (start, target) = (&coarse.start, coarse.terminal.target());
        let level = if coarse.dynamics.has_all_axes() { usize::MAX } else { 0 };
        let dynamics = self.descends_on(&coarse.dynamics, level);
        let (tolerance, known) = (0.0, &[][..]);
        let descent = Descent { dynamics: &dynamics, start, target, translates: N == 12, tolerance, known };
        for path in paths.into_iter().take(MOST_LIFTED) {
            if self.stopped() {
                return;
            }
            if let Some(nodes) = descent.lifted(path) {
                let _ = self.lift_nodes(coarse, nodes);
            }
        }
    }

    /// The dynamics on which a descent works at a level.
    fn descends_on(&self, dynamics: &Dynamics, level: usize) -> Dynamics {
        let levels = Authority::of(dynamics).levels();
        match levels[level.min(levels.len() - 1)] {
            0.0 => dynamics.clone(),
            more => dynamics.widened(more),
        }
    }

    /// A descent from a path, on dynamics that may have more authority than those of `bvp`; it ends where it runs into
    /// one of the `known` minima of the same dynamics.
    fn descended(
        &self,
        bvp: &BoundaryValueProblem<N>,
        dynamics: &Dynamics,
        start: Candidate,
        tolerance: f64,
        known: &[Attempt],
    ) -> Attempt {
        let (start_point, target) = (&bvp.start, bvp.terminal.target());
        let translates = N == 12;
        let descent = Descent { dynamics, start: start_point, target, translates, tolerance, known };
        self.attempt(Rung::Descent, &descent, start)
    }

    /// From a minimum on the coarse grid to its extremal there: by the shooting, which an unstable body may forbid, else
    /// by the lifted Newton.
    fn arrive(&mut self, coarse: &BoundaryValueProblem<N>, minimum: Attempt) {
        let near = |cost: f64| (cost - minimum.cost).abs() <= SAME_BRANCH * minimum.cost;
        let (path, rung) = (&minimum.candidate, Rung::Descent);
        if !self.shoot(rung, path.clone()).is_some_and(near)
            && !self.lift_nodes(coarse, path.clone()).is_some_and(near)
        {
            self.lost.push(minimum);
        }
    }

    /// Follows minima of a widened authority to the true one, always the lowest first: authority that is taken away only
    /// makes a branch dearer, so none that is dearer than what was found needs to be followed. Those of a rougher grid are
    /// carried to the coarse one first. With some authority about every axis `ended` takes what this ends at.
    fn narrow(
        &mut self,
        coarse: &BoundaryValueProblem<N>,
        mut open: Vec<(usize, Attempt)>,
        ended: &mut Minima,
    ) {
        let authority = Authority::of(&coarse.dynamics);
        let last = authority.levels().len() - 1;
        let given = matches!(self.problem.path, Path::AsGiven(_));
        for _ in 0..MOST_BRANCHES {
            let lowest = open.iter().enumerate().min_by(|(_, (_, a)), (_, (_, b))| a.cost.total_cmp(&b.cost));
            let Some(lowest) = lowest.map(|(index, _)| index) else { return };
            if self.stopped() {
                return;
            }
            let (level, minimum) = open.swap_remove(lowest);
            let rough = minimum.candidate.steps() != coarse.dynamics.grid.steps();
            let margin = if rough { ROUGH_MARGIN } else { MARGIN };
            let found =
                ended.0.first().map_or(f64::INFINITY, |best| best.cost).min(self.lowest(self.pool.iter()));
            if !given && minimum.cost > found * (1.0 + margin) {
                continue;
            }
            // With little left to take away the true extremal is within Newton's reach.
            let near = |cost: f64| (cost - minimum.cost).abs() <= NARROW * cost;
            if authority == Authority::Missing
                && !rough
                && level > 0
                && self.lift_nodes(coarse, minimum.candidate.clone()).is_some_and(near)
            {
                continue;
            }
            if level == last && !rough {
                // A valley too long for one descent is followed further on the requested grid.
                if authority == Authority::Missing || !minimum.converged() {
                    self.lost.push(minimum);
                } else {
                    ended.add(minimum);
                }
                continue;
            }
            let (level, start) = if rough {
                (level, paths::on_grid(coarse, &minimum.candidate))
            } else {
                (level + 1, minimum.candidate)
            };
            let wide = self.descends_on(&coarse.dynamics, level);
            let next = self.descended(coarse, &wide, start, DESCENT_TOLERANCE, &[]);
            let same = |(at, other): &(usize, Attempt)| {
                *at == level
                    && other.candidate.steps() == next.candidate.steps()
                    && (other.cost - next.cost).abs() <= SAME_MINIMUM * next.cost
            };
            if !open.iter().any(same) && next.cost.is_finite() && self.is_of_the_sense(&next.candidate) {
                open.push((level, next));
            }
        }
    }

    /// The lifted Newton from states and costates of all nodes, then the shooting. The cost of the extremal.
    fn lift_nodes(&mut self, coarse: &BoundaryValueProblem<N>, nodes: Candidate) -> Option<f64> {
        let newton = LiftedNewton { bvp: coarse, tolerance: LIFTED_TOLERANCE, patience: 1 };
        let lifted = self.attempt(Rung::Lifted, &newton, nodes);
        if lifted.converged() { self.shoot(Rung::Lifted, lifted.candidate) } else { None }
    }

    /// Carries the extremals that may be the best to the requested grid; the others stay rivals.
    fn carry_extremals(&mut self) {
        let pool = std::mem::take(&mut self.pool);
        let pool = self.ranked(pool);
        let enough = pool.first().map_or(0.0, |best| best.cost * (1.0 + MARGIN));
        // Newton alone finds one extremal of a way round, descents find several.
        let several = self.problem.path == Path::Best || self.descended;
        for extremal in pool {
            let near = extremal.cost <= enough || self.coarse.dynamics.grid.steps() == self.problem.steps;
            let hopeful = several && near && self.found.len() < MOST_MINIMA;
            if !self.stopped() && (hopeful || self.found.is_empty()) {
                let path = paths::of_extremal(&self.coarse, &extremal.candidate).ok();
                let near = |found: &Attempt| is_near(found, extremal.cost, path.as_ref());
                if !self.finish(extremal.candidate.clone(), near)
                    && let Some(candidate) = path
                {
                    self.lost.push(Attempt { candidate, ..extremal });
                }
            } else {
                self.rivals.push(extremal);
            }
        }
        self.on_requested_grid();
    }

    /// The paths that were lost on the way to the requested grid, descended there where they may still be the best.
    fn on_requested_grid(&mut self) {
        let mut lost = std::mem::take(&mut self.lost);
        if self.problem.steps > MOST_STEPS {
            return;
        }
        lost.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        for Attempt { candidate, cost, .. } in lost {
            let found = self.lowest(self.found.iter());
            let beaten = cost > found * (1.0 + MARGIN) || matches!(self.problem.path, Path::AsGiven(_));
            if self.stopped() || (beaten && found.is_finite()) {
                return;
            }
            self.descend_on_requested_grid(paths::on_grid(&self.fine, &candidate));
        }
    }

    /// From a path on the requested grid to a minimum there, and to its extremal.
    fn descend_on_requested_grid(&mut self, path: Candidate) {
        let fine = self.fine.clone();
        let all = fine.dynamics.has_all_axes();
        let levels = if all { &[usize::MAX][..] } else { &LAST_LEVELS };
        let mut minimum = Attempt::failed(path, Outcome::Stalled);
        for level in levels {
            let wide = self.descends_on(&fine.dynamics, *level);
            minimum = self.descended(&fine, &wide, minimum.candidate, FINE_TOLERANCE, &[]);
        }
        let within = if all { SAME_BRANCH } else { NARROW };
        let near = |cost: f64| (cost - minimum.cost).abs() <= within * minimum.cost;
        if all && self.shoot_fine(Rung::Descent, minimum.candidate.clone()).is_some_and(near) {
            return;
        }
        let newton = LiftedNewton { bvp: &fine, tolerance: LIFTED_TOLERANCE, patience: PATIENCE };
        let lifted = self.attempt(Rung::Lifted, &newton, minimum.candidate.clone());
        if lifted.converged() {
            if !self.shoot_fine(Rung::Lifted, lifted.candidate.clone()).is_some_and(near) {
                self.replay(&lifted.candidate);
            }
        } else if !all {
            // What is singular without the last of the authority stops a Newton on all nodes, and SCP by its trust region not.
            self.replay(&minimum.candidate);
        }
    }

    /// An extremal of the requested grid that the shooting cannot follow from its start, where round-off of the costates
    /// grows along the way: as a plan of SCP, which holds the states of all nodes. Or what SCP makes of a path.
    fn replay(&mut self, nodes: &Candidate) {
        if self.ask.convex && !self.stopped() {
            let chain = self.chain(self.problem.steps);
            let name = &nodes.provenance.start;
            self.descend(
                &chain,
                path(name, &chain.model.dynamics.grid, nodes.states.iter().map(Point::pose)),
            );
        }
    }
}

/// Whether what an extremal of the cost was carried to is the same one: on another grid it costs some percent more or less, and
/// where the nodes are kept they lie along its path. By its cost alone another one within that could pass for it.
fn is_near(found: &Attempt, cost: f64, path: Option<&Candidate>) -> bool {
    let along = |path: &Candidate, nodes: &[Node]| {
        let (few, many) = (path.steps(), nodes.len() - 1);
        path.states.iter().enumerate().all(|(index, state)| {
            let other = &nodes[(index * many + few / 2) / few].point;
            lie::minus(&other.attitude.value, &state.attitude.value).norm() < SAME_PATH
        })
    };
    let kept = path.zip(found.swept.as_ref());
    (found.cost - cost).abs() <= MARGIN * cost && kept.is_none_or(|(path, swept)| along(path, &swept.nodes))
}
