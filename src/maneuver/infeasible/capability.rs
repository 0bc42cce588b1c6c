//! The bounds that follow from the limits of a problem: torque, its rate of change, angular
//! velocity, momentum in wheels.

use super::envelope::{Means, Motion, Stored};
use super::outputs::Outputs;
use crate::lie;
use crate::maneuver::constraint::Rule;
use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::{ActuatorSet, AxisFrame};
use crate::{Matrix3, Vector3};

/// The relative excess up to which a plan still counts as within its limits.
pub(super) const SLACK: f64 = 1e-8;

/// Returns the largest norm of the output of a set of actuators: the norm limit, or the output at
/// the corner of the input limits if that is smaller.
pub(crate) fn strongest(channel: &ActuatorSet) -> f64 {
    let limits = channel.limits();
    together(channel, limits.size.as_ref()).min(limits.norm.unwrap_or(f64::INFINITY))
}

/// Returns the largest norm of a weighted sum of the axes of a set, with each weight within its
/// limit; infinity if `limits` is `None`.
fn together(channel: &ActuatorSet, limits: Option<&Vec<f64>>) -> f64 {
    limits.map_or(f64::INFINITY, |limits| Outputs::new(channel.axes(), limits.iter().copied()).largest())
}

/// Returns the bounds on torque, rate and stored momentum of a problem, each increased by the
/// relative excess `SLACK` that a plan may have.
pub(super) fn means(problem: &Problem) -> Means {
    let torque = &problem.actuation.torque;
    // A torque fixed to a frame that turns changes in space without changing its inputs.
    let usable = torque.frame() == AxisFrame::Body || standing(problem);
    let slope = together(torque, torque.limits().rate.as_ref().filter(|_| usable));
    let storage = together(torque, problem.actuation.wheels.as_ref().map(|wheels| &wheels.momentum_limit));
    Means {
        torque: strongest(torque) * (1.0 + SLACK),
        field: problem.environment.moment_bound().unwrap_or(f64::INFINITY),
        slope: slope * (1.0 + SLACK),
        rate: fastest(problem, None),
        rate_growth: 1.0,
        storage: storage * (1.0 + SLACK),
    }
}

/// Returns the largest `|S(b) Ω|` that the limits of the angular velocity allow, for a body axis b,
/// or the largest `|Ω|` without an axis \[rad/s\].
pub(super) fn fastest(problem: &Problem, axis: Option<&Vector3>) -> f64 {
    let speed = |rate: &Vector3| axis.map_or(rate.norm(), |axis| axis.cross(rate).norm());
    let limit = |rule: &Rule| match rule {
        Rule::RateNorm(limit) => *limit,
        // A convex function is largest at a corner; opposite corners have equal values.
        Rule::RateAxes(w) => [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
            .into_iter()
            .map(|(y, z)| speed(&Vector3::new(w.x, y * w.y, z * w.z)))
            .fold(0.0, f64::max),
        Rule::Pointing(_) => f64::INFINITY,
    };
    let limits = problem.constraints.iter().map(|constraint| limit(&constraint.rule));
    limits.fold(f64::INFINITY, f64::min) * (1.0 + SLACK)
}

/// The boundary states in inertial space, for a maneuver of `duration` \[s\].
pub(super) struct Ends {
    /// Attitudes, body → inertial.
    pub attitude: [Matrix3; 2],
    /// Momenta `Π`, body axes [N·m·s].
    pub momentum: [Vector3; 2],
}

impl Ends {
    pub(super) fn of(problem: &Problem, duration: f64) -> Self {
        let frame = lie::exp(&(problem.environment.frame_rate() * duration));
        let j = problem.body.inertia.j();
        Self {
            attitude: [problem.start.attitude, frame * problem.end.attitude],
            momentum: [j * problem.start.angular_velocity, j * problem.end.angular_velocity],
        }
    }

    /// Returns the momentum in inertial axes at an end.
    pub(super) fn spatial_momentum(&self, end: usize) -> Vector3 {
        self.attitude[end] * self.momentum[end]
    }
}

/// Returns whether only the actuators turn the body.
pub(super) fn isolated(problem: &Problem) -> bool {
    problem.environment.moment_bound() == Some(0.0)
}

/// Returns whether the reference frame is at rest. In a turning frame the target in inertial space
/// depends on the duration.
pub(super) fn standing(problem: &Problem) -> bool {
    problem.environment.frame_rate() == Vector3::zeros()
}

/// Returns the size of the total momentum of an isolated body with wheels, and the momenta of the
/// wheels at both ends, body axes [N·m·s].
pub(super) fn held(problem: &Problem, ends: &Ends) -> (f64, [Vector3; 2]) {
    let stored = problem.actuation.stored_momentum();
    let total = ends.attitude[0] * (ends.momentum[0] + stored);
    (total.norm(), [stored, ends.attitude[1].tr_mul(&total) - ends.momentum[1]])
}

/// Returns the moments of inertia, boundary momenta and boundary speeds that the envelope needs.
pub(super) fn motion(problem: &Problem, ends: &Ends) -> Motion {
    let inertia = &problem.body.inertia;
    let principal = inertia.principal();
    let speed = |momentum: &Vector3| momentum.dot(&(inertia.j_inverse() * momentum)).max(0.0).sqrt();
    let wheels = problem.actuation.wheels.as_ref().map(|_| {
        let (total, stored) = held(problem, ends);
        let [start, end] = stored.map(|stored| stored.norm());
        if isolated(problem) {
            Stored { total, stored: [start, end] }
        } else {
            Stored { total: f64::INFINITY, stored: [start, f64::INFINITY] }
        }
    });
    Motion {
        moments: [principal[0], principal[2]],
        momentum: ends.momentum.map(|momentum| momentum.norm()),
        speed: ends.momentum.each_ref().map(speed),
        wheels,
    }
}
