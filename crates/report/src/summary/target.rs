//! Lines about a moving target: its distance, its rate, and the pointing error of a plan that
//! ignores its motion.

use slewkit::maneuver::constraint::angle_between;
use slewkit::maneuver::{Problem, Solution};
use slewkit::numerics::figures::significant;
use slewkit_files::identity::Identity;
use slewkit_files::spec::escape;

/// Describes the target, its rate relative to the stars \[deg/s\], and the angle by which it moves
/// during the maneuver. If the body ends at rest, states that its pointing error grows at the rate
/// of the target. Returns an empty list if the end is not on a moving target.
pub(super) fn told(problem: &Problem, solution: &Solution, identity: &Identity) -> Vec<String> {
    let frame_rate = problem.environment.frame_rate();
    let Some(aim) = problem.aim().filter(|aim| !aim.at.is_still(&frame_rate)) else { return Vec::new() };
    let time = solution.duration(problem);
    let seen = aim.at.in_space(time, &frame_rate);
    let scenery = identity.scenery.as_ref();
    let target = scenery.and_then(|scenery| scenery.target.as_ref());
    let far = match (scenery.and_then(|scenery| scenery.station_at(time)), target) {
        (Some([range, elevation]), _) => {
            let height = significant(elevation.to_degrees(), 3);
            format!("{} km, {height} deg high, ", significant(range / 1e3, 4))
        }
        (None, Some(target)) => {
            target.unit_m.zip(aim.at.distance(time)).map_or_else(String::new, |(unit, length)| {
                format!("{} km, ", significant(unit * length / 1e3, 4))
            })
        }
        (None, None) => String::new(),
    };
    let rate = significant(seen.rate.norm().to_degrees(), 3);
    let before = aim.at.in_space(0.0, &frame_rate).direction;
    let moved = angle_between(&before, &seen.direction).to_degrees();
    let name = target.map(|target| escape(&target.name));
    let name = match (identity.boresight(&aim.boresight).map(|boresight| escape(&boresight)), name) {
        (Some(boresight), Some(name)) => format!("{boresight} on {name}, "),
        (Some(name), None) | (None, Some(name)) => format!("{name}, "),
        (None, None) => String::new(),
    };
    let moved = significant(moved, 3);
    vec![format!("{name}{far}turns at {rate} deg/s; aimed at 0 s: {moved} deg off")]
}
