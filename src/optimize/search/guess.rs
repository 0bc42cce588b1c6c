//! Initial guess for a plan, from another plan.

use crate::maneuver::problem::Problem;
use crate::maneuver::solution::{Solution, Trajectory};
use crate::mechanics::environment::Pose;
use crate::optimize::chain::model::Model;
use crate::optimize::chain::path;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::{Dynamics, Point};
use crate::optimize::search::starts::GUESS;
use crate::{Vector3, lie};

/// An initial guess from a neighbouring plan: its costates for shooting, its path for the
/// interior-point method.
///
/// [`crate::plan::plan()`] uses a guess as one more start in addition to its search, and reports
/// the cheapest plan. A guess that is [`alone`](Self::alone) replaces the search if shooting
/// converges from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guess {
    /// Costates in the form of [`Solution::costates_0`], SI units; empty for a path without
    /// costates.
    pub costates: Vec<f64>,
    /// Attitudes at evenly spaced nodes, in the form of
    /// [`crate::maneuver::solution::Trajectory::quaternion`]; at least two, or empty if the guess
    /// has no path.
    pub quaternion: Vec<[f64; 4]>,
    /// Positions at the same nodes \[m\]; empty if the body does not translate.
    pub position: Vec<Vector3>,
    /// True if the search is skipped when shooting from the costates leads to a plan. This plan may
    /// not be the cheapest.
    pub alone: bool,
    /// True if the whole search also runs, as set by [`crate::plan::plan()`]. Searches that are
    /// parts of another search set neither flag.
    #[doc(hidden)]
    pub beside: bool,
    /// Times of the nodes of the path \[s\], if the path is the plan of a finished search;
    /// otherwise empty. A free terminal state is then fixed as on this path, and the search is
    /// skipped if the path leads to a plan.
    #[doc(hidden)]
    pub time: Vec<f64>,
}

impl Guess {
    /// Creates a guess from costates, without a path.
    pub fn costates(costates: &[f64]) -> Self {
        Self { costates: costates.to_vec(), ..Self::default() }
    }

    /// Creates a guess from the costates and the path of a solution of `problem`.
    pub fn of(solution: &Solution, problem: &Problem) -> Self {
        Self {
            costates: solution.costates_0(problem).to_vec(),
            quaternion: solution.trajectory.quaternion.clone(),
            position: solution.trajectory.position.clone(),
            ..Self::default()
        }
    }

    /// Creates a guess from the plan of a neighbouring maneuver. The guess replaces the search if
    /// it leads to a plan.
    pub(crate) fn near(solution: &Solution, problem: &Problem) -> Self {
        Self { time: solution.trajectory.time.clone(), alone: true, ..Self::of(solution, problem) }
    }

    /// Makes the guess replace the search if it leads to a plan. This is quicker, but the plan may
    /// not be the cheapest.
    pub fn alone(self) -> Self {
        Self { alone: true, ..self }
    }

    /// Makes the guess one more start in addition to the search, unless it replaces the search.
    pub(crate) fn beside_the_search(&self) -> Self {
        Self { beside: !self.alone, ..self.clone() }
    }

    /// Creates a guess from the path of a plan on a chain. `stated` is the duration of the chain's
    /// maneuver \[s\].
    pub(super) fn of_plan(dynamics: &Dynamics, stated: f64, plan: &Candidate) -> Self {
        let poses = || plan.states.iter().map(Point::pose);
        Self {
            quaternion: poses().map(|pose| lie::quaternion_from_rotation(&pose.attitude)).collect(),
            position: poses().map(|pose| pose.position * dynamics.units.length).collect(),
            time: (0..=plan.steps()).map(|node| stated * plan.grid.time(node)).collect(),
            ..Self::default()
        }
    }

    /// Creates a guess from the path of a solution, marked as the plan of a finished search.
    pub(super) fn of_solution(plan: &Solution) -> Self {
        let Trajectory { time, quaternion, position, .. } = plan.trajectory.clone();
        Self { time, quaternion, position, ..Self::default() }
    }

    /// Returns whether the path is the plan of a finished search.
    pub(super) fn is_known(&self) -> bool {
        !self.time.is_empty()
    }

    /// Returns the path as a motion if it is the plan of a finished search; `None` otherwise.
    pub(super) fn motion(&self) -> Option<Trajectory> {
        let (time, quaternion, position) =
            (self.time.clone(), self.quaternion.clone(), self.position.clone());
        self.is_known().then(|| Trajectory { time, quaternion, position, ..Trajectory::default() })
    }

    /// Returns whether the path has valid quaternions and positions.
    pub(super) fn path_is_sound(&self) -> bool {
        let turns = |q: &[f64; 4]| q.iter().map(|part| part * part).sum::<f64>();
        let moves = self.position.is_empty() || self.position.len() == self.quaternion.len();
        moves
            && self.quaternion.len() != 1
            && self.quaternion.iter().all(|q| (turns(q) - 1.0).abs() < 1e-3)
            && self.position.iter().all(|x| x.iter().all(|part| part.is_finite()))
    }

    /// Returns the path on the grid of `model`. Its attitudes and positions are shifted gradually
    /// so that it meets the boundary states of this maneuver.
    pub(super) fn seed(&self, model: &Model) -> Option<Candidate> {
        let last = self.quaternion.len().checked_sub(1).filter(|last| *last > 0)?;
        let unit = model.dynamics.units.length;
        let node = |index: usize| Pose {
            position: self.position.get(index).map_or(model.start.position, |x| x / unit),
            attitude: lie::project_to_rotation(&lie::rotation_from_quaternion(&self.quaternion[index])),
        };
        let (first, end) = (node(0), node(last));
        let turn = model.start.attitude * first.attitude.transpose();
        // For a free terminal attitude, the end of the path is kept.
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
