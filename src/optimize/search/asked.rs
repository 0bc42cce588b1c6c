//! The way round that is asked for, and how far what was found is from it.
//!
//! # When does a saddle stand, and when the wrong way round?
//!
//! A plan by `best`, `shortest` or `long` that has a conjugate point on the requested grid is descended from there, up to
//! three times in a row; only where that finds nothing lower does the saddle stand, and the summary, the status and
//! `second_order` in the plan file say so. `shortest` and `long` are each the cheapest of their sense: from rest to rest,
//! where a body can do all, that is what Newton meets first, elsewhere starts of that sense are descended from as for `best`.
//! `as_given` is taken as written, saddle or not, since a lower plan of its class may turn less; only where torques about an
//! axis are missing does a rotation of less than half a turn, from rest to rest, mean no more than `shortest`. A plan that
//! goes round in the other class of rotations than was asked for is not solved: the solution says which way the nearest one
//! goes. Classes are told on the double cover, against the motion without inputs.

use super::ladder::{Search, held_to};
use super::way::{Follower, Way};
use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::Path;
use crate::maneuver::settings::Method as Road;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Outcome, Sense, Solution};
use crate::optimize::candidate::Candidate;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::model::Model;
use crate::optimize::methods::scp::road::body_rates;
use crate::optimize::sweep::BoundaryValueProblem;
use std::f64::consts::TAU;

/// An extremal of one grid that ends so near its target on another \[rad\] goes the same way there.
const NEAR: f64 = 0.2;
/// How much farther from a rotation that is given all paths of the other class are than those of its own: more turns than a
/// path has.
const OTHER_CLASS: f64 = 1e6;

impl<'a, const N: usize> Search<'a, '_, N> {
    /// Whether a solution goes the way that was asked for, and no cheaper one is near it. A rotation that is given
    /// is taken as written: that may be a saddle. So may be what is not to be tested.
    pub fn satisfies(&self, solution: &Solution) -> bool {
        let untested = !self.context.settings.test_second_order;
        let minimal = untested || solution.optimality.conjugate_points == Some(0);
        let given = matches!(self.problem.path, Path::AsGiven(_));
        solution.outcome == Outcome::Converged && (minimal || given) && self.goes_as_asked(solution)
    }

    pub fn goes_as_asked(&self, solution: &Solution) -> bool {
        self.asked_sense().is_none_or(|sense| sense == solution.sense)
    }

    /// The sense that was asked for.
    pub fn asked_sense(&self) -> Option<Sense> {
        match self.problem.path {
            Path::Best => None,
            Path::Shortest => Some(Sense::Short),
            Path::Long => Some(Sense::Long),
            Path::AsGiven(rotation) => {
                let mut path = Follower::new();
                let parts = (rotation.norm() / 0.1).ceil().max(1.0);
                for part in 0..=parts as usize {
                    let turned = lie::exp(&(rotation * (part as f64 / parts)));
                    path.node(&(self.problem.start.attitude * turned), Vector3::zeros(), 0.0);
                }
                path.way(&self.coarse).ok().map(|way| way.sense)
            }
        }
    }

    /// A solution that counts as converged only if it goes the way round that was asked for.
    pub fn held_to_its_way(&self, mut solution: Solution) -> Solution {
        if solution.outcome == Outcome::Converged && !self.goes_as_asked(&solution) {
            let (short, turned_deg) = (solution.sense == Sense::Short, solution.turned_deg);
            solution.outcome = Outcome::Stalled;
            solution.shortfall = Some(Shortfall::OtherWay { short, turned_deg });
        }
        solution
    }

    /// A solution that counts as converged only where it goes the way that was asked for, and ends where it should.
    pub fn held_to_all(&self, solution: Solution) -> Solution {
        held_to(self.context.settings.tolerance, self.held_to_its_way(solution))
    }

    /// The grid that an extremal is told on: the coarse one, unless its costates lead elsewhere there.
    pub fn told_on(&self, candidate: &Candidate) -> &BoundaryValueProblem<'a, N> {
        let [coarse, fine] = [&self.coarse, &self.fine].map(|bvp| bvp.dynamics.grid.steps());
        let is_fine = candidate.steps() == fine && fine != coarse;
        let near = || {
            Follower::of(&self.coarse, &candidate.costate()).is_ok_and(|path| path.miss(&self.coarse) < NEAR)
        };
        if is_fine && !near() { &self.fine } else { &self.coarse }
    }

    /// How a candidate goes round.
    pub fn way(&self, candidate: &Candidate) -> Way {
        let way = match candidate.provenance.method {
            Road::Scp => {
                let mut path = Follower::new();
                let model = Model::new(self.problem, candidate.steps());
                for (attitude, rate) in body_rates(&model, candidate) {
                    path.node(&attitude, rate, model.h);
                }
                Ok(path.way_or_short(&self.fine))
            }
            _ => {
                let bvp = self.told_on(candidate);
                Follower::of(bvp, &candidate.costate()).map(|path| path.way_or_short(bvp))
            }
        };
        let (turned_deg, rotation) = (f64::NAN, Vector3::repeat(f64::NAN));
        way.unwrap_or(Way { sense: Sense::Short, turned_deg, rotation })
    }

    /// How far a path is from what was asked for: the wrong sense, or another rotation than the given.
    pub fn astray(&self, found: &Attempt) -> f64 {
        let way = || self.way(&found.candidate);
        match self.problem.path {
            Path::Best => 0.0,
            Path::Shortest => f64::from(u8::from(way().sense != Sense::Short)),
            Path::Long => f64::from(u8::from(way().sense != Sense::Long)),
            // In full turns, to a thousandth; a path of the other class is another way whatever it turns by.
            Path::AsGiven(rotation) => {
                let way = way();
                let other = self.asked_sense().is_some_and(|sense| sense != way.sense);
                f64::from(u8::from(other)) * OTHER_CLASS
                    + ((way.rotation - rotation).norm() / TAU * 1e3).round() / 1e3
            }
        }
    }

    /// The nearest to what was asked for first, of these the lowest cost.
    pub fn ranked(&self, found: Vec<Attempt>) -> Vec<Attempt> {
        let several = found.len() > 1;
        let mut keyed: Vec<(f64, Attempt)> =
            found.into_iter().map(|found| (if several { self.astray(&found) } else { 0.0 }, found)).collect();
        keyed.sort_by(|(a, x), (b, y)| a.total_cmp(b).then(x.cost.total_cmp(&y.cost)));
        keyed.into_iter().map(|(_, found)| found).collect()
    }

    /// Puts the winner first.
    pub fn rank(&mut self) {
        let found = std::mem::take(&mut self.found);
        self.found = self.ranked(found);
    }
}
