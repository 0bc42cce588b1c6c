//! Rungs of the maneuver without limits: ballistic starts, continuation, the lifted Newton, random starts.

use super::ladder::Search;
use super::smooth_path;
use super::{continuation, starts};
use crate::Vector3;
use crate::maneuver::problem::Path;
use crate::maneuver::solution::Rung;
use crate::optimize::candidate::Candidate;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::lifted::LiftedNewton;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::shooting::newton::outcome_of;

/// Random starts tried when nothing else converges; half as many when all that did is a saddle, or for
/// the long way.
const RANDOM_STARTS: usize = 40;
/// Tolerance of the lifted Newton, which the shooting polishes.
pub(super) const LIFTED_TOLERANCE: f64 = 1e-10;

impl<const N: usize> Search<'_, '_, N> {
    /// Newton shooting from the ballistic starts.
    pub(super) fn ballistic(&mut self) {
        match self.problem.path {
            Path::Shortest => {
                self.shoot_ballistic(&[1.0]);
                if self.found.is_empty() {
                    self.shoot_ballistic(&[0.3]);
                }
            }
            _ => self.shoot_ballistic(&[1.0, 0.3]),
        }
    }

    fn shoot_ballistic(&mut self, fractions: &[f64]) {
        let steps = self.coarse.dynamics.grid.steps();
        match starts::ballistic(&self.coarse, &self.turns, fractions) {
            Ok(starts) => {
                for start in starts {
                    if self.stopped() {
                        return;
                    }
                    self.shoot(Rung::Newton, start);
                }
            }
            Err(error) => {
                self.context.note(Rung::Newton, "ballistic", steps, Report::failed(outcome_of(error)));
            }
        }
    }

    /// Continuation and the lifted Newton, for every sense.
    pub(super) fn senses(&mut self) {
        // The windings are rivals; only the senses, or what was asked for, are worth every rung.
        let best = matches!(self.problem.path, Path::Best);
        for turns in self.turns.clone().into_iter().filter(|turns| !best || *turns == 0 || *turns == -1) {
            let name = starts::name_of(turns);
            if !self.arrived.contains(&name) && !self.stopped() {
                self.continuation(turns);
            }
            // A smooth path leads elsewhere than a costate does: for the best, look there too.
            let missing = !self.arrived.contains(&name);
            if (missing || best) && !self.stopped() {
                self.lifted(turns, &Vector3::zeros(), missing);
            }
        }
    }

    /// The lifted Newton from bent paths.
    pub(super) fn bent_paths(&mut self) {
        for (index, axis) in [0, 1, 2, 0, 1, 2].into_iter().enumerate() {
            for turns in [0, -1] {
                if !self.stopped() {
                    let sign = if index < 3 { 1.0 } else { -1.0 };
                    self.lifted(turns, &(Vector3::ith(axis, sign)), false);
                }
            }
        }
    }

    fn continuation(&mut self, turns: i32) {
        let start = Candidate::of_costate::<N>(
            &starts::name_of(turns),
            &self.coarse.dynamics.grid,
            &nalgebra::SVector::zeros(),
        );
        let walk = continuation::InTarget { bvp: &self.coarse, turns };
        let attempt = self.attempt(Rung::Continuation, &walk, start);
        if attempt.converged() {
            self.shoot(Rung::Continuation, attempt.candidate);
        }
    }

    /// Lifted Newton from a smooth path; `stretch` it from a short horizon if that fails.
    fn lifted(&mut self, turns: i32, bump: &Vector3, stretch: bool) {
        let bent = if bump.amax() > 0.0 { ", bent path" } else { ", smooth path" };
        let name = format!("{}{bent}", starts::name_of(turns));
        let grid = &self.coarse.dynamics.grid;
        let start = Candidate::of_costate::<N>(&name, grid, &nalgebra::SVector::zeros());
        let newton = LiftedNewton { bvp: &self.coarse, tolerance: LIFTED_TOLERANCE };
        let mut attempt = match smooth_path::nodes(&self.coarse, turns, bump) {
            Ok(nodes) => self.attempt(Rung::Lifted, &newton, nodes.into_candidate(start.clone())),
            Err(error) => {
                let report = Report::failed(outcome_of(error));
                self.context.note(Rung::Lifted, &name, grid.steps(), report.clone());
                Attempt::of(start.clone(), report)
            }
        };
        if !attempt.converged() && stretch && !self.stopped() {
            let walk = continuation::InHorizon::<N> { problem: self.problem, turns };
            attempt = self.attempt(Rung::Horizon, &walk, start);
        }
        if attempt.converged() {
            self.shoot(Rung::Lifted, attempt.candidate);
        }
    }

    /// Deterministic random starts.
    pub(super) fn random(&mut self) {
        let Ok(starts) = starts::random(&self.coarse, self.problem.path) else { return };
        let count = if self.found.is_empty() { RANDOM_STARTS } else { RANDOM_STARTS / 2 };
        for start in starts.take(count) {
            if self.stopped() {
                return;
            }
            let before = self.found.len();
            self.shoot(Rung::MultiStart, start);
            if self.found.len() > before && self.settled() {
                return;
            }
        }
    }
}
