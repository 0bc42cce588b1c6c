//! The animated body of a page: a box with the proportions of the inertia, and its poses at the
//! times of a trajectory.

use super::boresight::{Boresight, body_axes, boresights};
use super::document::{cone, disc, numbers, vector};
use super::moving;
use super::{MOST_POINTS, Subject};
use serde_json::{Value, json};
use slewkit::Vector3;
use slewkit::maneuver::Motion;

/// Smallest drawn length of an edge of the box, as a fraction of its longest edge.
const THINNEST: f64 = 0.04;

/// Returns the body and its motion as data for the script of the page; `null` if the plan has no
/// trajectory.
pub(super) fn body(subject: &Subject) -> Value {
    let (problem, trajectory) = (subject.problem, subject.trajectory());
    if trajectory.time.is_empty() {
        return Value::Null;
    }
    let mut body = motion(&trajectory.time, &trajectory.quaternion, &trajectory.position, &corners(subject));
    let boresights: Vec<Value> = boresights(subject).iter().map(named).collect();
    body["boresights"] = boresights.into();
    body["cones"] = moving::all_cones(subject).iter().map(cone).collect();
    body["discs"] = moving::discs(subject).iter().map(disc).collect();
    body["attracted"] = (problem.motion == Motion::RigidBody && !problem.environment.is_free()).into();
    body
}

fn named(boresight: &Boresight) -> Value {
    json!({ "name": boresight.name, "vector": vector(&boresight.vector) })
}

/// Returns the motion of a box as data for the script of the page. `corners` are its vertices in
/// body axes; the body axes are shown as boresights. `positions` is empty for a body that does not
/// translate.
pub(super) fn motion(
    time: &[f64],
    quaternions: &[[f64; 4]],
    positions: &[Vector3],
    corners: &[Vector3; 8],
) -> Value {
    let count = time.len();
    let stride = count.div_ceil(MOST_POINTS).max(1);
    let last = (!(count - 1).is_multiple_of(stride)).then_some(count - 1);
    let nodes: Vec<usize> = (0..count).step_by(stride).chain(last).collect();
    let attitudes: Vec<Value> = nodes.iter().map(|node| numbers(quaternions[*node].into_iter(), 7)).collect();
    let places = nodes.iter().filter_map(|node| positions.get(*node));
    json!({
        "time": numbers(nodes.iter().map(|node| time[*node]), 9),
        "quaternion": attitudes,
        "position": places.map(|place| numbers(place.iter().copied(), 7)).collect::<Vec<_>>(),
        "corners": corners.iter().map(vector).collect::<Vec<_>>(),
        "boresights": body_axes().iter().map(named).collect::<Vec<_>>(),
        "cones": [],
        "discs": [],
        "attracted": false,
    })
}

/// Returns the vertices of the homogeneous box that has the principal moments of the body, in body
/// axes, scaled so that the longest half edge is 1.
///
/// `J₁ = m (b² + c²)/3` and so on for half edges a, b, c, hence `a² ∝ J₂ + J₃ − J₁`.
fn corners(subject: &Subject) -> [Vector3; 8] {
    let eigen = subject.problem.body.inertia.j().symmetric_eigen();
    let sum = eigen.eigenvalues.sum();
    let edges = eigen.eigenvalues.map(|moment| (sum - 2.0 * moment).max(0.0).sqrt());
    let longest = edges.amax();
    let edges = edges.map(|edge| (edge / longest).max(THINNEST));
    std::array::from_fn(|index| {
        let sign = |axis: usize| if index >> axis & 1 == 0 { -1.0 } else { 1.0 };
        eigen.eigenvectors * Vector3::from_fn(|axis, _| sign(axis) * edges[axis])
    })
}
