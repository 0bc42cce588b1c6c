//! What the boresights see: their tracks on the sphere of directions, with the cones of the spec.

use super::boresight::{Boresight, body_axes, boresights, cones};
use super::{MOST_POINTS, Shown, Subject, flight};
use crate::draw::{Picture, Sky, SkyCone, SkyMark, SkyTrack};
use slewkit::maneuver::{Direction, Side};
use slewkit::{Matrix3, Vector3, lie};

/// The attitudes of some nodes, at most [`MOST_POINTS`], both ends included.
fn attitudes(quaternions: &[[f64; 4]]) -> Vec<Matrix3> {
    let stride = quaternions.len().div_ceil(MOST_POINTS).max(1);
    let last = quaternions.last().filter(|_| !(quaternions.len() - 1).is_multiple_of(stride));
    quaternions.iter().step_by(stride).chain(last).map(lie::rotation_from_quaternion).collect()
}

/// The map.
pub(super) fn sky(subject: &Subject) -> Shown {
    let frame_rate = subject.problem.environment.frame_rate();
    let tracks = tracks(boresights(subject), &subject.trajectory().quaternion);
    let mut discs = Vec::new();
    let mut marks = Vec::new();
    let mut moving = false;
    for (name, pointing) in cones(subject) {
        for direction in &pointing.directions {
            moving |= moves(direction, &frame_rate);
            discs.push(SkyCone {
                name: name.into(),
                axis: direction.at(0.0, &frame_rate),
                half_angle: pointing.effective_half_angle() + direction.angular_radius(0.0),
                inside_forbidden: pointing.side == Side::KeepOut,
            });
            marks.push(SkyMark { name: String::new(), at: direction.at(0.0, &frame_rate) });
        }
    }
    // Where the end asked for is, the track may not be: a plan that failed.
    for (track, boresight) in tracks.iter().zip(boresights(subject)) {
        let target = subject.problem.end.attitude * boresight.vector;
        let ends = track.points.last().map_or(f64::INFINITY, |end| (end - target).norm());
        if ends > 0.02 {
            marks.push(SkyMark { name: "target".into(), at: target });
        }
    }
    let inertial = frame_rate == Vector3::zeros();
    let angles = if inertial { ["right ascension", "declination"] } else { ["longitude", "latitude"] };
    let kind = if inertial { "inertial" } else { "which turns" };
    let (rings, enlarged) = flight::rings(subject);
    let mut remark: String = match (discs.is_empty(), moving) {
        (true, _) => "the spec has no boresight: the body axes are shown".into(),
        (false, false) => String::new(),
        (false, true) => "some directions move here: their cones stand as at the start".into(),
    };
    if !rings.is_empty() {
        let and = if remark.is_empty() { "" } else { "; " };
        remark = format!("{remark}{and}{}", flight::told_of_rings(&rings, enlarged));
    }
    let sky = Sky {
        title: "Boresights on the sphere of directions".into(),
        subtitle: format!("in the {}, {kind}", subject.reference_frame()),
        cones: discs,
        tracks,
        rings,
        marks,
        angles: angles.map(String::from),
    };
    Shown { key: "sky", picture: Picture::Sky(sky), remark }
}

/// The ways of some directions of a body.
fn tracks(boresights: impl IntoIterator<Item = Boresight>, quaternions: &[[f64; 4]]) -> Vec<SkyTrack> {
    let attitudes = attitudes(quaternions);
    let track = |(style, boresight): (usize, Boresight)| SkyTrack {
        name: boresight.name,
        style,
        points: attitudes.iter().map(|attitude| attitude * boresight.vector).collect(),
    };
    boresights.into_iter().enumerate().map(track).collect()
}

/// The ways of the axes of a body that nothing is asked of.
pub(super) fn axes_on_sphere(quaternions: &[[f64; 4]]) -> Shown {
    let sky = Sky {
        title: "Body axes on the sphere of directions".into(),
        subtitle: "in the reference frame".into(),
        cones: Vec::new(),
        tracks: tracks(body_axes(), quaternions),
        rings: Vec::new(),
        marks: Vec::new(),
        angles: ["longitude", "latitude"].map(String::from),
    };
    Shown { key: "sky", picture: Picture::Sky(sky), remark: String::new() }
}

/// Whether a direction moves in the reference frame.
pub(super) fn moves(direction: &Direction, frame_rate: &Vector3) -> bool {
    !direction.is_still(frame_rate)
}
