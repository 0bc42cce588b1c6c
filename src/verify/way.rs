//! The homotopy class of a recorded path, determined on the double cover of the rotations.
//!
//! A path of rotations lifts to a continuous path of unit quaternions. Let two paths have equal
//! ends, and let their lifts begin equal. They belong to the same homotopy class if the lifts end
//! equal; otherwise the lifts end at opposite quaternions.

use super::motion::Inputs;
use super::rows::walk;
use super::verification::WitnessError;
use super::watch::Watch;
use crate::lie::{self, continued};
use crate::maneuver::problem::{Path, Problem};
use crate::maneuver::solution::{Sense, Trajectory};
use crate::propagate::plant::Plant;
use crate::{Matrix3, Vector3};

/// If the end of the motion without inputs is opposite to the end of the path within this angle
/// \[rad\], both classes count as short.
const OPPOSITE: f64 = 1e-2;
/// Largest angle between neighbouring attitudes of a lift \[rad\].
const PART: f64 = 0.1;

/// Returns whether the path has the homotopy class that `problem` requests; `None` if no class is
/// requested, or if both classes are equally long.
pub(super) fn goes_as_asked(
    plant: &Plant,
    problem: &Problem,
    trajectory: &Trajectory,
    watch: &Watch,
) -> Result<Option<bool>, WitnessError> {
    let is_short = match problem.path {
        Path::Best => return Ok(None),
        Path::AsGiven(rotation) => {
            let start = &problem.start.attitude;
            let asked = turned(lie::quaternion_from_rotation(start), start, &rotation);
            return Ok(lifted(problem, trajectory).map(|path| same(&path, &asked)));
        }
        Path::Shortest => true,
        Path::Long => false,
    };
    Ok(sense(plant, problem, trajectory, watch)?.map(|sense| (sense == Sense::Short) == is_short))
}

/// Returns the homotopy class of the path; `None` if both classes are equally long, or if the
/// trajectory is empty.
pub(super) fn sense(
    plant: &Plant,
    problem: &Problem,
    trajectory: &Trajectory,
    watch: &Watch,
) -> Result<Option<Sense>, WitnessError> {
    let Some((path, last)) = lifted(problem, trajectory).zip(trajectory.quaternion.last()) else {
        return Ok(None);
    };
    // The short class is determined from the end of the motion without inputs.
    let none = vec![0.0; trajectory.input.len()];
    let mut at = problem.start.attitude;
    let mut lift = lie::quaternion_from_rotation(&at);
    walk(plant, &Inputs::new(problem, &none), Some(watch), |node| {
        at = node.attitude();
        lift = continued(Some(&lift), lie::quaternion_from_rotation(&at));
    })?;
    let rest = lie::minus(&lie::rotation_from_quaternion(last), &at);
    let told = rest.norm() < std::f64::consts::PI - OPPOSITE;
    let is_short = || same(&path, &turned(lift, &at, &rest));
    Ok(told.then(|| if is_short() { Sense::Short } else { Sense::Long }))
}

/// Returns the end of the lift of the recorded path; `None` if the trajectory is empty.
fn lifted(problem: &Problem, trajectory: &Trajectory) -> Option<[f64; 4]> {
    trajectory.quaternion.last()?;
    let from = lie::quaternion_from_rotation(&problem.start.attitude);
    Some(trajectory.quaternion.iter().fold(from, |lift, quaternion| continued(Some(&lift), *quaternion)))
}

/// Returns the end of the lift that starts at `lift` and follows `rotation` (body axes) from the
/// attitude `from`.
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
