//! Which way round a recorded path goes, told on the double cover of the rotations.
//!
//! A path of rotations lifts to a continuous path of unit quaternions. Two paths with equal ends are of one class if
//! their lifts, begun equal, end equal; if not, they end at opposite quaternions.

use super::motion::Inputs;
use super::rows::walk;
use super::verification::WitnessError;
use super::watch::Watch;
use crate::lie::{self, continued};
use crate::maneuver::problem::{Path, Problem};
use crate::maneuver::solution::Trajectory;
use crate::propagate::plant::Plant;
use crate::{Matrix3, Vector3};

/// Where the motion without inputs ends this close to opposite to the end of the path \[rad\], both ways are short.
const OPPOSITE: f64 = 1e-2;
/// Largest angle between neighbours of a lift \[rad\].
const PART: f64 = 0.1;

/// Whether the path goes as `problem` asks; `None` where any way will do, or both are equally long.
pub(super) fn goes_as_asked(
    plant: &Plant,
    problem: &Problem,
    trajectory: &Trajectory,
    watch: &Watch,
) -> Result<Option<bool>, WitnessError> {
    let start = &problem.start.attitude;
    let from = lie::quaternion_from_rotation(start);
    let path =
        trajectory.quaternion.iter().fold(from, |lift, quaternion| continued(Some(&lift), *quaternion));
    let Some(last) = trajectory.quaternion.last() else { return Ok(None) };
    let end = lie::rotation_from_quaternion(last);
    let short = match problem.path {
        Path::Best => return Ok(None),
        Path::AsGiven(rotation) => return Ok(Some(same(&path, &turned(from, start, &rotation)))),
        Path::Shortest => true,
        Path::Long => false,
    };
    // The shorter way is that from the end of the motion without inputs.
    let none = vec![0.0; trajectory.input.len()];
    let (mut lift, mut at) = (from, *start);
    walk(plant, &Inputs::new(problem, &none), Some(watch), |node| {
        at = node.attitude();
        lift = continued(Some(&lift), lie::quaternion_from_rotation(&at));
    })?;
    let rest = lie::minus(&end, &at);
    let told = rest.norm() < std::f64::consts::PI - OPPOSITE;
    Ok(told.then(|| same(&path, &turned(lift, &at, &rest)) == short))
}

/// The lift that begins with `lift` at `from` and goes on with `rotation` (body axes).
fn turned(lift: [f64; 4], from: &Matrix3, rotation: &Vector3) -> [f64; 4] {
    let parts = (rotation.norm() / PART).ceil().max(1.0);
    (1..=parts as usize).fold(lift, |lift, part| {
        let attitude = from * lie::exp(&(rotation * (part as f64 / parts)));
        continued(Some(&lift), lie::quaternion_from_rotation(&attitude))
    })
}

fn same(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() > 0.0
}
