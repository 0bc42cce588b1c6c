//! Violations of rate limits and cones by the true motion.

use crate::maneuver::constraint::{Arc, Constraint, Rule, on_arc};
use crate::maneuver::problem::Problem;
use crate::{Matrix3, Vector3, lie};

/// The worst violation of each constraint by a motion.
#[derive(Clone, Debug)]
pub(crate) struct Excess<'a> {
    constraints: &'a [Constraint],
    frame_rate: Vector3,
    /// Worst violation of each constraint: \[rad\] for a cone, a fraction of the limit for a rate.
    /// A negative value is the remaining distance from the constraint.
    pub worst: Vec<f64>,
}

impl<'a> Excess<'a> {
    /// Number of pieces into which a step is divided; the motion on each piece is treated as a
    /// rotation about a fixed axis.
    pub const PIECES: usize = 8;

    /// Builds the check of the constraints of a maneuver; `None` if the maneuver has no
    /// constraints.
    pub fn of(problem: &'a Problem) -> Option<Self> {
        let constraints = &problem.constraints[..];
        (!constraints.is_empty()).then(|| Self::beside(constraints, problem.environment.frame_rate()))
    }

    /// Builds the check of other constraints, for example the constraints without their margins.
    pub fn beside(constraints: &'a [Constraint], frame_rate: Vector3) -> Self {
        Self { constraints, frame_rate, worst: vec![f64::NEG_INFINITY; constraints.len()] }
    }

    /// Compares an angular velocity (body axes, [rad/s]) with the rate limits.
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

    /// Compares a piece of the motion with the cones. The piece begins at `time`, lasts `step`
    /// \[s\], and leads from attitude `before` to `after` (body to inertial).
    pub(super) fn piece(&mut self, time: f64, step: f64, before: &Matrix3, after: &Matrix3) {
        let arc = Arc { start: *before, turn: lie::minus(after, before) };
        let travel = arc.turn.norm();
        for (constraint, worst) in self.constraints.iter().zip(&mut self.worst) {
            let Rule::Pointing(pointing) = &constraint.rule else { continue };
            for (boresight, direction) in pointing.pairs() {
                let target = on_arc(direction, time, step, &self.frame_rate);
                // This pair stays farther from the cone than the worst so far; no extremum is
                // needed.
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
