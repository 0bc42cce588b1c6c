//! The map of the sphere of directions: boresight tracks, and the cones of the spec.

use super::boresight::{Boresight, body_axes, boresights};
use super::{MOST_POINTS, Shown, Subject, flight, moving};
use crate::draw::{Picture, Sky, SkyMark, SkyTrack};
use slewkit::{Matrix3, Vector3, lie};

/// Returns the attitudes at evenly spread nodes, including the first and the last node. Their
/// number is at most about [`MOST_POINTS`].
fn attitudes(quaternions: &[[f64; 4]]) -> Vec<Matrix3> {
    let stride = quaternions.len().div_ceil(MOST_POINTS).max(1);
    let last = quaternions.last().filter(|_| !(quaternions.len() - 1).is_multiple_of(stride));
    quaternions.iter().step_by(stride).chain(last).map(lie::rotation_from_quaternion).collect()
}

/// Returns the map of boresight tracks and cones.
pub(super) fn sky(subject: &Subject) -> Shown {
    let frame_rate = subject.problem.environment.frame_rate();
    let tracks = tracks(boresights(subject), &subject.trajectory().quaternion);
    let all = moving::all_cones(subject);
    let mut marks: Vec<SkyMark> =
        all.iter().map(|cone| SkyMark { name: String::new(), at: cone.axis }).collect();
    let moving = all.iter().any(|cone| !cone.way.is_empty());
    // In a failed plan the boresight may not reach its target, so the target is marked.
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
    let mut remark: String = match (all.is_empty(), moving) {
        (true, _) if subject.problem.aim().is_none() => {
            "the spec has no boresight: the chart shows the body axes".into()
        }
        (_, false) => String::new(),
        (_, true) => "moving cones are filled as at the start, dashed as at the end".into(),
    };
    if !rings.is_empty() {
        let and = if remark.is_empty() { "" } else { "; " };
        remark = format!("{remark}{and}{}", flight::told_of_rings(&rings, enlarged));
    }
    let sky = Sky {
        title: "Boresights on the sphere of directions".into(),
        subtitle: format!("in the {}, {kind}", subject.reference_frame()),
        whole: false,
        cones: all,
        discs: moving::discs(subject),
        tracks,
        rings,
        marks,
        angles: angles.map(String::from),
    };
    Shown { key: "sky", picture: Picture::Sky(sky), remark }
}

/// Returns the map of the whole sphere around the spacecraft with the Earth, the Moon, the Sun and
/// the target; `None` if their directions are unknown.
pub(super) fn around(subject: &Subject) -> Option<Shown> {
    subject.identity.scenery.as_ref()?;
    let Shown { picture: Picture::Sky(sky), .. } = sky(subject) else { return None };
    let whole = Sky { title: "All around".into(), whole: true, rings: Vec::new(), marks: Vec::new(), ..sky };
    let remark = "Earth, Moon and Sun during the motion: dashed at the start, filled at the end; Sun and Moon are \
     enlarged";
    Some(Shown { key: "around", picture: Picture::Sky(whole), remark: remark.into() })
}

/// Returns the tracks of body-fixed directions over the sphere.
fn tracks(boresights: impl IntoIterator<Item = Boresight>, quaternions: &[[f64; 4]]) -> Vec<SkyTrack> {
    let attitudes = attitudes(quaternions);
    let track = |(style, boresight): (usize, Boresight)| SkyTrack {
        name: boresight.name,
        style,
        points: attitudes.iter().map(|attitude| attitude * boresight.vector).collect(),
    };
    boresights.into_iter().enumerate().map(track).collect()
}

/// Returns the map with the tracks of the body axes, for a simulation.
pub(super) fn axes_on_sphere(quaternions: &[[f64; 4]]) -> Shown {
    let sky = Sky {
        title: "Body axes on the sphere of directions".into(),
        subtitle: "in the reference frame".into(),
        whole: false,
        cones: Vec::new(),
        discs: Vec::new(),
        tracks: tracks(body_axes(), quaternions),
        rings: Vec::new(),
        marks: Vec::new(),
        angles: ["longitude", "latitude"].map(String::from),
    };
    Shown { key: "sky", picture: Picture::Sky(sky), remark: String::new() }
}
