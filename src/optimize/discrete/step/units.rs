//! The units of the solvers: duration 1, mean principal moment of inertia 1, mass 1.

use crate::Matrix3;
use crate::maneuver::problem::{Motion, Problem, State};
use nalgebra::SVector;

/// Units in which every quantity of a maneuver is of order one, whatever the spacecraft.
///
/// Translation has its own unit of length. It is coupled to the units of the rotation only by
/// force, moment and cost, and these are converted where they are evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Unit of time `T` \[s\].
    pub time: f64,
    /// Unit of inertia `tr(J)/3` [kg·m²].
    pub inertia: f64,
    /// Unit of mass \[kg\].
    pub mass: f64,
    /// Unit of length \[m\].
    pub length: f64,
    /// Unit of cost: the cost of a turn by one radian, or of a shift by one unit of length if that
    /// is higher.
    pub cost: f64,
}

impl Units {
    /// Derives the units of a maneuver.
    pub fn of(problem: &Problem) -> Self {
        let time = problem.seconds();
        let inertia = problem.body.inertia.mean();
        let mass = problem.body.mass.unwrap_or(1.0);
        let length = match problem.motion {
            Motion::Attitude => 1.0,
            Motion::RigidBody => {
                let size = |state: &State| state.position.norm().max(state.velocity.norm() * time);
                let largest = size(&problem.start).max(size(&problem.end));
                if largest > 0.0 { largest } else { 1.0 }
            }
        };
        // The larger of the costs of a turn by one radian and of a shift by one unit of length is
        // the scale of the costates.
        let price =
            |momentum: f64, authority: &Matrix3| momentum / time * momentum / (authority.trace() / 3.0);
        let weights = problem.objective.weights();
        let turn = price(inertia / time, &weights.torque(&problem.actuation).authority);
        let shift = match (weights.force(&problem.actuation), problem.motion) {
            (Some(force), Motion::RigidBody) => price(mass * length / time, &force.authority),
            _ => 0.0,
        };
        Self { time, inertia, mass, length, cost: turn.max(shift) }
    }

    /// Returns the unit of angular momentum [N·m·s].
    pub fn momentum(&self) -> f64 {
        self.inertia / self.time
    }

    /// Returns the unit of linear momentum [N·s].
    pub fn linear_momentum(&self) -> f64 {
        self.mass * self.length / self.time
    }

    /// Returns the unit of torque [N·m].
    pub fn torque(&self) -> f64 {
        self.inertia / self.time / self.time
    }

    /// Returns the unit of force \[N\].
    pub fn force(&self) -> f64 {
        self.mass * self.length / self.time / self.time
    }

    /// Returns the units of the N components of a costate: cost over the unit of the conjugate
    /// state.
    pub fn costate<const N: usize>(&self) -> SVector<f64, N> {
        let rotation = [self.cost, self.cost / self.momentum()];
        let translation = [self.cost / self.length, self.cost / self.linear_momentum()];
        SVector::from_fn(|row, _| {
            let pair = if N == 12 && row < 6 { translation } else { rotation };
            pair[row % 6 / 3]
        })
    }
}
