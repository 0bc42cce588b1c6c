//! Maneuvers that no input takes out of a plane.
//!
//! Where nothing acts on a body but its inputs, the turns about one principal axis `n` are an invariant set of the dynamics if the inputs
//! turn about `n` alone: `J n = λ n` makes `Π × Ω = 0`, and `R n` stays where it is. Of thrusters that push the body across `n` as well
//! the mass center stays in the plane across it. A maneuver whose ends lie in that set needs of its inputs no more than both senses of
//! whatever they give: that their outputs are a subspace, not a whole space.

use super::{EndCondition, Motion, Path, Problem};
use crate::Vector3;

/// What vectors that are to be parallel or normal may have the other way, as a part of their lengths: rounding of a spec.
const ASIDE: f64 = 1e-9;

impl Problem {
    /// The principal axis, in body axes, about which the body does nothing but turn: all inputs turn it about that, thrusters push it
    /// across that, the maneuver begins and ends so, and nothing else acts.
    pub(super) fn stays_in_plane(&self) -> Option<Vector3> {
        let (1, Some(axis)) = self.actuation.torque.rank() else { return None };
        let along = |vector: &Vector3| vector.cross(&axis).norm() <= ASIDE * vector.norm();
        let (start, end) = (&self.start, &self.end);
        let normal = start.attitude * axis;
        let turns = self.environment.is_free()
            && self.environment.frame_rate() == Vector3::zeros()
            && self.actuation.wheels.is_none()
            && matches!(self.end_condition, EndCondition::State | EndCondition::Met(_))
            && along(&(self.body.inertia.j() * axis))
            && along(&start.angular_velocity)
            && along(&end.angular_velocity)
            && (end.attitude * axis - normal).norm() <= ASIDE
            && !matches!(self.path, Path::AsGiven(turn) if !along(&turn));
        let pushing = self.actuation.force.as_ref().filter(|_| self.motion == Motion::RigidBody);
        let pushing = pushing.filter(|_| self.actuation.thrusters.is_some());
        let stays = pushing.is_none_or(|force| {
            let across = |vector: &Vector3, axis: &Vector3| vector.dot(axis).abs() <= ASIDE * vector.norm();
            let moved = [end.position - start.position, start.velocity, end.velocity];
            force.axes().iter().all(|push| across(push, &axis))
                && moved.iter().all(|vector| across(vector, &normal))
        });
        (turns && stays).then_some(axis)
    }
}
