//! Rungs of the maneuver without limits: ballistic starts, descents on paths, the lifted Newton.
//!
//! All extremals are looked for on a coarse grid. Costs there are wrong by some percent at high rates and then rank
//! wrongly: every one that may be the cheapest is carried to the requested grid, and compared there.

use super::effort::Starts;
use super::ladder::Search;
use super::{paths, starts};
use crate::lie;
use crate::maneuver::problem::Path;
use crate::maneuver::settings::Thoroughness;
use crate::maneuver::solution::Rung;
use crate::optimize::candidate::Candidate;
use crate::optimize::methods::descent::Descent;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::lifted::LiftedNewton;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::shooting::newton::outcome_of;
use crate::optimize::step::{Dynamics, Point};
use crate::optimize::sweep::BoundaryValueProblem;

/// Tolerance of the lifted Newton, which the shooting polishes.
pub(super) const LIFTED_TOLERANCE: f64 = 1e-10;
/// What a descent on the coarse grid may leave of the cost, relative.
const DESCENT_TOLERANCE: f64 = 1e-9;
/// The same on the requested grid.
const FINE_TOLERANCE: f64 = 1e-14;
/// Minima whose costs differ by less, relative, are one.
const SAME_MINIMUM: f64 = 1e-7;
/// Costs that differ by less, relative, are equal.
const EQUAL: f64 = 1e-9;
/// How much dearer than the cheapest on the coarse grid a minimum may be and still turn out the cheapest.
const MARGIN: f64 = 0.15;
/// A path that is farther from the one asked for goes another way round.
const ASTRAY: f64 = 1.0;
/// Most minima that are followed further.
const MOST_MINIMA: usize = 6;
/// Starts without a lower minimum after which a search that is half done ends, unless it is to be thorough.
const IDLE: usize = 20;
/// Most paths that the lifted Newton is tried on directly.
const MOST_LIFTED: usize = 2;
/// Authority about the axes without inputs, from the first descent to the last, relative to that of the others.
const WIDENED: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];
/// Most steps of a descent or a lifted Newton on the requested grid: they keep the matrices of every step.
const MOST_STEPS: usize = 20_000;

impl<const N: usize> Search<'_, '_, N> {
    /// The extremals without limits: those that Newton meets from the ballistic starts, and for the best way the
    /// minima that descents end at.
    pub(super) fn extremals(&mut self) {
        self.ballistic();
        if self.problem.path == Path::Best || !self.is_as_asked() {
            self.descents();
        }
        self.carry_extremals();
    }

    /// What is left to try where the requested grid shows a saddle, the wrong way round or nothing at all.
    pub(super) fn look_further(&mut self) {
        let saddle = self.found.first().filter(|_| !matches!(self.problem.path, Path::AsGiven(_)));
        if let Some(saddle) = saddle.map(|saddle| saddle.candidate.clone()) {
            self.leave(&saddle);
        }
        if !self.descended {
            self.descents();
            self.carry_extremals();
        }
    }

    /// Leaves a saddle of the requested grid for a minimum.
    fn leave(&mut self, saddle: &Candidate) {
        let fine = self.fine.clone();
        if self.problem.steps > MOST_STEPS || !fine.dynamics.has_all_axes() {
            return;
        }
        if let Ok(path) = paths::of_extremal(&fine, saddle) {
            let minimum = self.descended(&fine, &fine.dynamics, path, FINE_TOLERANCE);
            if minimum.converged() {
                self.shoot_fine(Rung::Descent, minimum.candidate);
            }
        }
    }

    /// Whether an extremal on the coarse grid goes the way that was asked for.
    fn is_as_asked(&self) -> bool {
        match self.problem.path {
            // Told on the requested grid, where it costs nothing more.
            Path::Shortest | Path::Best => !self.pool.is_empty(),
            Path::Long | Path::AsGiven(_) => self.pool.iter().any(|found| self.astray(found) < ASTRAY),
        }
    }

    /// Newton shooting from the ballistic starts.
    fn ballistic(&mut self) {
        for fraction in [1.0, 0.3] {
            let steps = self.coarse.dynamics.grid.steps();
            let turns: Vec<i32> = self.turns.iter().copied().filter(|turns| !self.arrived(*turns)).collect();
            match starts::ballistic(&self.coarse, &turns, fraction) {
                Ok(starts) => {
                    for start in starts {
                        if !self.stopped() {
                            self.shoot(Rung::Newton, start);
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
        let wide = self.descends_on(&coarse.dynamics, 0);
        let mut minima: Vec<Attempt> = Vec::new();
        let starts = Starts::of(self.problem, &coarse, self.context.settings.search);
        if self.pool.is_empty() || self.problem.path != Path::Best || !coarse.dynamics.has_all_axes() {
            self.lift(&coarse, starts.paths(&coarse));
        }
        let known: Vec<Candidate> =
            self.pool.iter().filter_map(|found| paths::of_extremal(&coarse, &found.candidate).ok()).collect();
        let all: Vec<Candidate> = known.into_iter().chain(starts.paths(&coarse)).collect();
        let (most, patient) = (all.len(), self.context.settings.search == Thoroughness::Thorough);
        let (mut best, mut idle) = (f64::INFINITY, 0);
        for (done, start) in all.into_iter().enumerate() {
            if self.stopped() || (!patient && idle >= IDLE && 2 * done >= most) {
                break;
            }
            let minimum = self.descended(&coarse, &wide, start, DESCENT_TOLERANCE);
            idle += 1;
            if minimum.converged() && minimum.cost < best * (1.0 - SAME_MINIMUM) {
                (best, idle) = (minimum.cost, 0);
            }
            let known =
                |other: &&mut Attempt| (other.cost - minimum.cost).abs() <= SAME_MINIMUM * minimum.cost;
            match minima.iter_mut().find(known) {
                _ if !minimum.converged() => {}
                Some(known) if !is_better(&minimum, known) => {}
                Some(known) => *known = minimum,
                None => minima.push(minimum),
            }
        }
        minima.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = self.problem.path == Path::Best && coarse.dynamics.has_all_axes();
        let margin = if best { MARGIN } else { f64::INFINITY };
        let enough = minima.first().map_or(f64::INFINITY, |best| best.cost * (1.0 + margin));
        let minima = minima.into_iter().take_while(|minimum| minimum.cost <= enough).take(MOST_MINIMA);
        for minimum in minima.collect::<Vec<_>>() {
            if !self.stopped() {
                self.arrive(&coarse, minimum);
            }
        }
    }

    /// Extremals that the lifted Newton finds from the first of the paths, saddles among them.
    fn lift(&mut self, coarse: &BoundaryValueProblem<N>, paths: Vec<Candidate>) {
        let (start, target) = (&coarse.start, coarse.terminal.target());
        let dynamics = self.descends_on(&coarse.dynamics, 0);
        let descent = Descent { dynamics: &dynamics, start, target, translates: N == 12, tolerance: 0.0 };
        for path in paths.into_iter().take(MOST_LIFTED) {
            if self.stopped() {
                return;
            }
            if let Some(nodes) = descent.lifted(path) {
                self.lift_nodes(coarse, nodes);
            }
        }
    }

    /// The dynamics on which a descent works: with a little authority about the axes without inputs.
    fn descends_on(&self, dynamics: &Dynamics, level: usize) -> Dynamics {
        if dynamics.has_all_axes() { dynamics.clone() } else { dynamics.widened(WIDENED[level]) }
    }

    /// A descent from a path, on dynamics that may have more authority than those of `bvp`.
    fn descended(
        &self,
        bvp: &BoundaryValueProblem<N>,
        dynamics: &Dynamics,
        start: Candidate,
        tolerance: f64,
    ) -> Attempt {
        let (start_point, target) = (&bvp.start, bvp.terminal.target());
        let descent = Descent { dynamics, start: start_point, target, translates: N == 12, tolerance };
        self.attempt(Rung::Descent, &descent, start)
    }

    /// From a minimum on the coarse grid to an extremal there: by the shooting, which an unstable body may forbid, else
    /// by the lifted Newton.
    fn arrive(&mut self, coarse: &BoundaryValueProblem<N>, mut minimum: Attempt) {
        if !coarse.dynamics.has_all_axes() {
            self.lift_nodes(coarse, minimum.candidate.clone());
            for level in 1..WIDENED.len() {
                let narrower = self.descends_on(&coarse.dynamics, level);
                minimum = self.descended(coarse, &narrower, minimum.candidate, DESCENT_TOLERANCE);
            }
        } else if self.shoot(Rung::Descent, minimum.candidate.clone()) {
            return;
        }
        if !self.lift_nodes(coarse, minimum.candidate.clone()) {
            self.lost.push(minimum.candidate);
        }
    }

    /// The lifted Newton from states and costates of all nodes, then the shooting.
    fn lift_nodes(&mut self, coarse: &BoundaryValueProblem<N>, nodes: Candidate) -> bool {
        let newton = LiftedNewton { bvp: coarse, tolerance: LIFTED_TOLERANCE };
        let lifted = self.attempt(Rung::Lifted, &newton, nodes);
        lifted.converged() && self.shoot(Rung::Lifted, lifted.candidate)
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
                let path = extremal.candidate.clone();
                if !self.finish(extremal.candidate)
                    && let Ok(path) = paths::of_extremal(&self.coarse, &path)
                {
                    self.lost.push(path);
                }
            } else {
                self.rivals.push(extremal);
            }
        }
        if self.found.is_empty() {
            self.on_requested_grid();
        }
    }

    /// The paths that were lost on the way to the requested grid, descended there.
    fn on_requested_grid(&mut self) {
        if self.problem.steps > MOST_STEPS {
            return;
        }
        let fine = self.fine.clone();
        for path in std::mem::take(&mut self.lost) {
            if self.stopped() || !self.found.is_empty() {
                return;
            }
            let start = paths::on_grid(&fine, &path);
            let wide = self.descends_on(&fine.dynamics, WIDENED.len() - 1);
            let minimum = self.descended(&fine, &wide, start, FINE_TOLERANCE);
            if self.shoot_fine(Rung::Descent, minimum.candidate.clone()) {
                continue;
            }
            let newton = LiftedNewton { bvp: &fine, tolerance: LIFTED_TOLERANCE };
            let lifted = self.attempt(Rung::Lifted, &newton, minimum.candidate);
            if lifted.converged() {
                self.shoot_fine(Rung::Lifted, lifted.candidate);
            }
        }
    }
}

/// Whether a minimum is to be taken instead of another of the same cost: a lower cost, or where a symmetry gives many
/// of one cost, less turning.
fn is_better(minimum: &Attempt, other: &Attempt) -> bool {
    let difference = (minimum.cost - other.cost) / other.cost.abs().max(f64::MIN_POSITIVE);
    if difference.abs() > EQUAL {
        difference < 0.0
    } else {
        turned(&minimum.candidate) < turned(&other.candidate)
    }
}

/// The angle that a path turns by, from node to node \[rad\].
fn turned(path: &Candidate) -> f64 {
    let step = |pair: &[Point]| lie::minus(&pair[1].attitude.value, &pair[0].attitude.value).norm();
    path.states.windows(2).map(step).sum()
}
