//! Moving objects around the spacecraft in pictures: Earth, Moon, Sun, the target, and moving
//! cones.

use super::boresight::{boresights, cones};
use super::{MOST_POINTS, Shown, Subject};
use crate::draw::{ConeAsks, DiscKind, Ground, GroundTrack, Picture, SkyCone, SkyDisc};
use slewkit::maneuver::{Direction, Pointing, Side};
use slewkit::numerics::figures::significant;
use slewkit::{Vector3, lie};

/// Number of samples with which the motion of a disc or cone is stored; pages interpolate between
/// them.
const TIMES: usize = 61;

/// Returns times that are equally spaced over the trajectory \[s\].
fn times(subject: &Subject) -> Vec<f64> {
    let last = subject.trajectory().time.last().copied().unwrap_or(0.0);
    (0..TIMES).map(|k| last * k as f64 / (TIMES - 1) as f64).collect()
}

/// Returns the discs of Earth, Moon and Sun, and of a moving target of the maneuver.
pub(super) fn discs(subject: &Subject) -> Vec<SkyDisc> {
    let frame_rate = subject.problem.environment.frame_rate();
    let times = times(subject);
    let mut found: Vec<SkyDisc> = Vec::new();
    if let Some(scenery) = &subject.identity.scenery {
        let turned = |time: f64, direction: Vector3| lie::exp(&(frame_rate * -time)) * direction;
        let seen: Vec<_> = times.iter().map(|time| (*time, scenery.discs(*time))).collect();
        for index in 0..seen.first().map_or(0, |(_, discs)| discs.len()) {
            let way = seen.iter().map(|(time, discs)| {
                let disc = &discs[index];
                (turned(*time, disc.direction), disc.angular_radius)
            });
            let name = seen[0].1[index].name;
            let kind = match name {
                "Earth" => DiscKind::Earth,
                "Moon" => DiscKind::Moon,
                _ => DiscKind::Sun,
            };
            found.push(SkyDisc { name: name.into(), kind, way: way.collect() });
        }
    }
    if let Some(aim) = subject.problem.aim().filter(|aim| !aim.at.is_still(&frame_rate)) {
        let name = target_name(subject).unwrap_or("target").to_string();
        let way = times.iter().map(|time| (aim.at.at(*time, &frame_rate), 0.0)).collect();
        // A target that is already shown as a disc, such as the Moon, gets no second mark.
        if !found.iter().any(|disc| name.eq_ignore_ascii_case(&disc.name)) {
            found.push(SkyDisc { name, kind: DiscKind::Target, way });
        }
    }
    found
}

/// Returns the name of the target of the maneuver; `None` if it has no named target.
pub(super) fn target_name<'a>(subject: &Subject<'a>) -> Option<&'a str> {
    Some(subject.identity.scenery.as_ref()?.target.as_ref()?.name.as_str())
}

/// Returns a cone for pictures: its axis and half angle at the start, and its motion.
pub(super) fn cone(subject: &Subject, name: &str, pointing: &Pointing, direction: &Direction) -> SkyCone {
    let frame_rate = subject.problem.environment.frame_rate();
    let half = |time: f64| pointing.effective_half_angle() + direction.angular_radius(time);
    let at = |time: f64| (direction.at(time, &frame_rate), half(time));
    let way = if direction.is_still(&frame_rate) {
        Vec::new()
    } else {
        times(subject).into_iter().map(at).collect()
    };
    let last = subject.trajectory().time.last().copied().unwrap_or(0.0);
    let acts = pointing.during.given().map(|_| pointing.during.parts(0.0, last).collect());
    SkyCone {
        name: name.into(),
        axis: direction.at(0.0, &frame_rate),
        half_angle: half(0.0),
        asks: match pointing.side {
            Side::KeepOut => ConeAsks::KeepOut,
            Side::KeepIn => ConeAsks::KeepIn,
            Side::On { .. } => ConeAsks::HoldOn,
        },
        acts,
        when: when(pointing),
        way,
    }
}

/// Describes the times at which a cone is active; an empty text means always.
fn when(pointing: &Pointing) -> String {
    let Some(intervals) = pointing.during.given() else { return String::new() };
    let told = |[from, to]: &[f64; 2]| format!("from {} to {} s", significant(*from, 4), significant(*to, 4));
    if intervals.is_empty() {
        "never".into()
    } else {
        intervals.iter().map(told).collect::<Vec<_>>().join(", ")
    }
}

/// Returns the cones of all pointing constraints, one for each direction.
pub(super) fn all_cones(subject: &Subject) -> Vec<SkyCone> {
    let each = |(name, pointing): (&str, &Pointing)| -> Vec<SkyCone> {
        pointing.directions.iter().map(|direction| cone(subject, name, pointing, direction)).collect()
    };
    cones(subject).flat_map(each).collect()
}

/// Returns the map with the ground track of the spacecraft and the tracks of the points at which
/// its boresights meet the ground; `None` if the spec has no orbit.
pub(super) fn ground(subject: &Subject) -> Option<Shown> {
    let scenery = subject.identity.scenery.as_ref()?;
    scenery.spacecraft.as_ref()?;
    let trajectory = subject.trajectory();
    let stride = trajectory.time.len().div_ceil(MOST_POINTS).max(1);
    let frame_rate = subject.problem.environment.frame_rate();
    let rows: Vec<(f64, [f64; 4])> =
        trajectory.time.iter().copied().zip(trajectory.quaternion.iter().copied()).collect();
    let last = rows.last().filter(|_| !(rows.len() - 1).is_multiple_of(stride));
    let rows: Vec<&(f64, [f64; 4])> = rows.iter().step_by(stride).chain(last).collect();
    let seen = boresights(subject).into_iter().enumerate().map(|(style, boresight)| {
        let meets = |(time, quaternion): &&(f64, [f64; 4])| {
            let direction = lie::rotation_from_quaternion(quaternion) * boresight.vector;
            scenery.on_ground(&(lie::exp(&(frame_rate * *time)) * direction), *time)
        };
        let met: Vec<Option<[f64; 2]>> = rows.iter().map(meets).collect();
        let stretches = met.split(Option::is_none).filter(|stretch| stretch.len() > 1);
        let stretches = stretches.map(|stretch| stretch.iter().flatten().copied().collect());
        GroundTrack { name: boresight.name, style, stretches: stretches.collect() }
    });
    let mut tracks: Vec<GroundTrack> = seen.filter(|track| !track.stretches.is_empty()).collect();
    let below = rows.iter().filter_map(|(time, _)| scenery.below(*time)).collect();
    tracks.push(GroundTrack { name: "below the spacecraft".into(), style: 7, stretches: vec![below] });
    let places = scenery.target.as_ref().and_then(|target| {
        let [latitude, longitude, _] = target.station?;
        Some(("station".to_string(), [latitude, longitude]))
    });
    let ground = Ground {
        title: "On the ground".into(),
        subtitle: "intersections of the boresights with the ellipsoid of WGS 84".into(),
        tracks,
        places: places.into_iter().collect(),
    };
    Some(Shown { key: "ground", picture: Picture::Ground(ground), remark: String::new() })
}
