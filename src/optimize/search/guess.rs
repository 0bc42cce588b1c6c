//! What another plan suggests for this one.

use crate::maneuver::problem::Problem;
use crate::maneuver::solution::{Solution, Trajectory};
use crate::mechanics::environment::Pose;
use crate::optimize::chain::model::Model;
use crate::optimize::chain::path;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::{Dynamics, Point};
use crate::optimize::search::starts::GUESS;
use crate::{Vector3, lie};

/// A neighbour's plan to begin from: its costates for the shooting, its path for the chain.
///
/// [`crate::plan::plan()`] uses a guess as one more start beside its search, and reports the
/// cheapest plan. A guess that is [`alone`](Self::alone) replaces the search by shooting where it
/// leads to a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guess {
    /// As [`Solution::costates_0`] gives them, SI units; empty where there is a path alone.
    pub costates: Vec<f64>,
    /// Attitudes at evenly spaced nodes, as [`crate::maneuver::solution::Trajectory::quaternion`]
    /// has them; two at least, or none: then it guesses no path.
    pub quaternion: Vec<[f64; 4]>,
    /// Positions at the same nodes \[m\]; empty where the body does not move.
    pub position: Vec<Vector3>,
    /// Whether nothing else is searched where the costates lead to a plan, which may not be the
    /// cheapest.
    pub alone: bool,
    /// Whether everything else is searched too, as [`crate::plan::plan()`] sets it. The parts of a
    /// search set neither.
    #[doc(hidden)]
    pub beside: bool,
    /// When the path is at its nodes \[s\], where it is the plan of a search that is done, and
    /// empty elsewhere: what its end leaves free is then as this path has it, and nothing else is
    /// searched where the path leads to a plan.
    #[doc(hidden)]
    pub time: Vec<f64>,
}

impl Guess {
    /// Costates alone.
    pub fn costates(costates: &[f64]) -> Self {
        Self { costates: costates.to_vec(), ..Self::default() }
    }

    /// All that a solution of `problem` can suggest to its neighbours.
    pub fn of(solution: &Solution, problem: &Problem) -> Self {
        Self {
            costates: solution.costates_0(problem).to_vec(),
            quaternion: solution.trajectory.quaternion.clone(),
            position: solution.trajectory.position.clone(),
            ..Self::default()
        }
    }

    /// The plan of a neighbour, which is solved from alone.
    pub(crate) fn near(solution: &Solution, problem: &Problem) -> Self {
        Self { time: solution.trajectory.time.clone(), alone: true, ..Self::of(solution, problem) }
    }

    /// Returns the guess as one that replaces the search where it leads to a plan: quicker, but the
    /// plan may not be the cheapest.
    pub fn alone(self) -> Self {
        Self { alone: true, ..self }
    }

    /// Returns the guess as one more start beside the search, unless it is to be alone.
    pub(crate) fn beside_the_search(&self) -> Self {
        Self { beside: !self.alone, ..self.clone() }
    }

    /// The path of a plan on the chain of a maneuver in a stated duration.
    pub(super) fn of_plan(dynamics: &Dynamics, stated: f64, plan: &Candidate) -> Self {
        let poses = || plan.states.iter().map(Point::pose);
        Self {
            quaternion: poses().map(|pose| lie::quaternion_from_rotation(&pose.attitude)).collect(),
            position: poses().map(|pose| pose.position * dynamics.units.length).collect(),
            time: (0..=plan.steps()).map(|node| stated * plan.grid.time(node)).collect(),
            ..Self::default()
        }
    }

    /// The path of a solution, as that of a search that is done.
    pub(super) fn of_solution(plan: &Solution) -> Self {
        let Trajectory { time, quaternion, position, .. } = plan.trajectory.clone();
        Self { time, quaternion, position, ..Self::default() }
    }

    /// Whether it is the path of a search that is done.
    pub(super) fn is_known(&self) -> bool {
        !self.time.is_empty()
    }

    /// The path of a search that is done, as a motion.
    pub(super) fn motion(&self) -> Option<Trajectory> {
        let (time, quaternion, position) =
            (self.time.clone(), self.quaternion.clone(), self.position.clone());
        self.is_known().then(|| Trajectory { time, quaternion, position, ..Trajectory::default() })
    }

    /// Whether every number of the path is usable.
    pub(super) fn path_is_sound(&self) -> bool {
        let turns = |q: &[f64; 4]| q.iter().map(|part| part * part).sum::<f64>();
        let moves = self.position.is_empty() || self.position.len() == self.quaternion.len();
        moves
            && self.quaternion.len() != 1
            && self.quaternion.iter().all(|q| (turns(q) - 1.0).abs() < 1e-3)
            && self.position.iter().all(|x| x.iter().all(|part| part.is_finite()))
    }

    /// The path on the grid of `model`, turned and shifted bit by bit so that it has this
    /// maneuver's ends.
    pub(super) fn seed(&self, model: &Model) -> Option<Candidate> {
        let last = self.quaternion.len().checked_sub(1).filter(|last| *last > 0)?;
        let unit = model.dynamics.units.length;
        let node = |index: usize| Pose {
            position: self.position.get(index).map_or(model.start.position, |x| x / unit),
            attitude: lie::project_to_rotation(&lie::rotation_from_quaternion(&self.quaternion[index])),
        };
        let (first, end) = (node(0), node(last));
        let turn = model.start.attitude * first.attitude.transpose();
        // Where any attitude will do, that at the end of the path is as good as another.
        let is_given = model.given().contains(&model.zeta());
        let turn_left = lie::minus(&model.target.attitude, &(turn * end.attitude));
        let turn_left = if is_given { turn_left } else { Vector3::zeros() };
        let shift = model.start.position - first.position;
        let shift_left = model.target.position - (end.position + shift);
        let poses = (0..=model.steps).map(|stage| {
            let along = stage as f64 / model.steps as f64;
            let at = along * last as f64;
            let low = (at.floor() as usize).min(last - 1);
            let (a, b) = (node(low), node(low + 1));
            let share = at - low as f64;
            let between = a.attitude * lie::exp(&(lie::minus(&b.attitude, &a.attitude) * share));
            Pose {
                position: a.position + (b.position - a.position) * share + shift + shift_left * along,
                attitude: lie::project_to_rotation(&(turn * between * lie::exp(&(turn_left * along)))),
            }
        });
        Some(path(GUESS, &model.dynamics.grid, poses))
    }
}
