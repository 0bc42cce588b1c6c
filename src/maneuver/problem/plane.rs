//! Maneuvers in which no input moves the body out of a plane.
//!
//! If only its inputs act on a body, and they turn it about one principal axis `n` alone, the
//! rotations about `n` are an invariant set of the dynamics: `J n = λ n` makes `Π × Ω = 0`, and
//! `R n` is constant. If thrusters also push the body normal to `n`, the mass centre stays in the
//! plane normal to `n`. A maneuver whose ends lie in this set needs inputs only in both directions
//! of a subspace, not of the whole space.

use super::{EndCondition, Motion, Path, Problem};
use crate::Vector3;

/// The relative tolerance with which vectors count as parallel or normal: rounding of a spec.
const ASIDE: f64 = 1e-9;

impl Problem {
    /// Returns the principal axis, in body axes, about which the whole motion is a pure rotation;
    /// `None` otherwise. All inputs turn the body about this axis, thrusters push normal to it, the
    /// start and end states have no other rotation or motion, and nothing else acts on the body.
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
