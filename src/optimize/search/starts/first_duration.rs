//! Initial duration of a search for the optimal duration: that of a turn about a fixed axis, or of
//! a translation along a line if it takes longer.

use crate::maneuver::problem::{Motion, Problem};
use crate::mechanics::actuators::{ActuatorSet, Limits};
use crate::{Matrix3, Vector3, lie};

/// Returns the optimal duration T of a minimum-effort turn about a fixed axis with the time weight
/// `price` \[s\]: the root of `18 (Jφ)² / T⁴ = w` for a turn through φ from rest to rest with time
/// weight w. The boundary rates are included. Returns the duration of a translation along a line if
/// it is longer. Infinite if time has no weight.
pub fn of_effort(problem: &Problem, price: f64) -> f64 {
    let lasting = |impulse: f64, change: f64, authority: &Matrix3| {
        let authority = authority.norm() / 3.0_f64.sqrt();
        let of_way = (18.0 * impulse * impulse / (authority * price)).powf(0.25);
        of_way.max(change / (2.0 * authority * price).sqrt())
    };
    let (start, end, weights) = (&problem.start, &problem.end, problem.objective.weights());
    let j = problem.body.inertia.j();
    let turn = lie::log(&start.attitude.tr_mul(&end.attitude));
    let momentum = (j * turn).norm().max(1e-3 * j.norm());
    let rates = (j * (start.angular_velocity - end.angular_velocity)).norm();
    let turning = lasting(momentum, rates, &weights.torque(&problem.actuation).authority);
    let mass = problem.body.mass.filter(|_| problem.motion == Motion::RigidBody);
    let flying = mass.zip(weights.force(&problem.actuation)).map_or(0.0, |(mass, force)| {
        let (way, speed) = (end.position - start.position, end.velocity - start.velocity);
        lasting(mass * way.norm(), mass * speed.norm(), &force.authority)
    });
    turning.max(flying)
}

/// Returns the approximate minimum time of a turn about a fixed axis, or of a translation along a
/// line if it takes longer \[s\].
pub fn of_time(problem: &Problem) -> f64 {
    let lasting = |way: &Vector3, least: f64, speeds: &Vector3, inertia: f64, set: &ActuatorSet| {
        let way_there = 2.0 * (way.norm().max(least) * inertia / given(set, way)).sqrt();
        way_there + speeds.norm() * inertia / given(set, speeds)
    };
    let (start, end, torque) = (&problem.start, &problem.end, &problem.actuation.torque);
    let of_body = |vector: &Vector3| torque.frame().of_body(&start.attitude, vector);
    let turn = of_body(&lie::minus(&end.attitude, &start.attitude));
    let rates = of_body(&(end.angular_velocity - start.angular_velocity));
    let turning = if problem.ends_in_any_attitude() {
        // By a torque along the change of momentum, however the body rotates meanwhile.
        let change = problem.body.inertia.j() * (end.angular_velocity - start.angular_velocity);
        change.norm() / given(torque, &of_body(&change))
    } else {
        lasting(&turn, 0.1, &rates, problem.body.inertia.j().norm(), torque)
    };
    let mass = problem.body.mass.filter(|_| problem.motion == Motion::RigidBody);
    let flying = mass.zip(problem.actuation.force.as_ref()).map_or(0.0, |(mass, force)| {
        let of_reference = |vector: &Vector3| force.frame().of_reference(&start.attitude, vector);
        let way = of_reference(&(end.position - start.position));
        lasting(&way, 0.0, &of_reference(&(end.velocity - start.velocity)), mass, force)
    });
    turning.max(flying)
}

/// Returns the approximate force or torque of an actuator set along and against a direction: the
/// limit of its weakest input or, if all contributing inputs together give much more, a part of
/// their sum.
fn given(set: &ActuatorSet, direction: &Vector3) -> f64 {
    let Limits { size, norm, one_sided, .. } = set.limits();
    let inputs = || set.axes().iter().zip(size.iter().flatten());
    // A thruster whose line of action passes through the mass centre gives no torque.
    let each = inputs().map(|(axis, bound)| axis.norm() * bound).chain(*norm);
    let weakest = each.filter(|bound| *bound > 0.0).fold(f64::INFINITY, f64::min);
    let along = |direction: &Vector3| -> f64 {
        let helps = |axis: &Vector3| {
            if *one_sided { axis.dot(direction).max(0.0) } else { axis.dot(direction).abs() }
        };
        inputs().map(|(axis, bound)| helps(axis) * bound).sum()
    };
    let unit = direction.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let together = along(&unit).min(along(&-unit)) / 3.0_f64.sqrt();
    weakest.max(together.min(norm.unwrap_or(f64::INFINITY)))
}
