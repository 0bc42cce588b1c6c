//! The excess of the true motion over rates and cones.

use crate::maneuver::constraint::{Arc, Constraint, Rule, on_arc};
use crate::maneuver::problem::Problem;
use crate::{Matrix3, Vector3, lie};

/// The worst that a motion exceeds each constraint by.
#[derive(Clone, Debug)]
pub(crate) struct Excess<'a> {
    constraints: &'a [Constraint],
    frame_rate: Vector3,
    /// The worst violation of each constraint: \[rad\] for a cone, a part of the limit for a rate;
    /// negative if it holds with room.
    pub worst: Vec<f64>,
}

impl<'a> Excess<'a> {
    /// The number of pieces of a step; the motion on each piece is treated as a rotation about one
    /// axis.
    pub const PIECES: usize = 8;

    /// Builds the check for the constraints of a maneuver; `None` without constraints.
    pub fn of(problem: &'a Problem) -> Option<Self> {
        let constraints = &problem.constraints[..];
        (!constraints.is_empty()).then(|| Self::beside(constraints, problem.environment.frame_rate()))
    }

    /// Returns limits for the constraints in another form, for example without their margins.
    pub fn beside(constraints: &'a [Constraint], frame_rate: Vector3) -> Self {
        Self { constraints, frame_rate, worst: vec![f64::NEG_INFINITY; constraints.len()] }
    }

    /// Compares a rate with the limits, body axes [rad/s].
    pub(super) fn rate(&mut self, rate: &Vector3) {
        for (constraint, worst) in self.constraints.iter().zip(&mut self.worst) {
            let share = match &constraint.rule {
                Rule::RateNorm(limit) => rate.norm() / limit - 1.0,
                Rule::RateAxes(limits) => rate.component_div(limits).amax() - 1.0,
                Rule::Pointing(_) => continue,
            };
            *worst = worst.max(share);
        }
    }

    /// Compares a piece of `step` \[s\] from `time` with the cones, between two attitudes, body →
    /// inertial.
    pub(super) fn piece(&mut self, time: f64, step: f64, before: &Matrix3, after: &Matrix3) {
        let arc = Arc { start: *before, turn: lie::minus(after, before) };
        let travel = arc.turn.norm();
        for (constraint, worst) in self.constraints.iter().zip(&mut self.worst) {
            let Rule::Pointing(pointing) = &constraint.rule else { continue };
            for (boresight, direction) in pointing.pairs() {
                let target = on_arc(direction, time, step, &self.frame_rate);
                // Too far away to come nearer than ever before: no extremum needed.
                if travel + target.travel()
                    - pointing.room_beside(arc.angle(boresight, &target, 0.0), target.radius)
                    < *worst
                {
                    continue;
                }
                let least = pointing.least_room(&arc, boresight, &target, [time, step]);
                *worst = least.map_or(*worst, |(_, room)| worst.max(-room));
            }
        }
    }
}
