//! What a maneuver ends on: how far it is, how fast it goes by, and by how much a plan that ends at rest would miss.

use slewkit::maneuver::constraint::angle_between;
use slewkit::maneuver::{Problem, Solution};
use slewkit::numerics::figures::significant;
use slewkit_files::identity::Identity;
use slewkit_files::spec::escape;

/// The lines; none where the end is not on a target that moves.
pub(super) fn told(problem: &Problem, solution: &Solution, identity: &Identity) -> Vec<String> {
    let frame_rate = problem.environment.frame_rate();
    let Some(aim) = problem.aim().filter(|aim| !aim.at.is_still(&frame_rate)) else { return Vec::new() };
    let time = solution.duration(problem);
    let seen = aim.at.in_space(time, &frame_rate);
    let scenery = identity.scenery.as_ref();
    let target = scenery.and_then(|scenery| scenery.target.as_ref());
    let name = target.map_or("the target".into(), |target| escape(&target.name));
    let far = match (scenery.and_then(|scenery| scenery.station_at(time)), target) {
        (Some([range, elevation]), _) => {
            let height = significant(elevation.to_degrees(), 3);
            format!(", {} km, {height} deg high", significant(range / 1e3, 4))
        }
        (None, Some(target)) => {
            target.unit_m.zip(aim.at.distance(time)).map_or_else(String::new, |(unit, length)| {
                format!(", {} km", significant(unit * length / 1e3, 4))
            })
        }
        (None, None) => String::new(),
    };
    let rate = significant(seen.rate.norm().to_degrees(), 3);
    let before = aim.at.in_space(0.0, &frame_rate).direction;
    let moved = angle_between(&before, &seen.direction).to_degrees();
    let mut lines = vec![format!("{name}{far}, turns at {rate} deg/s")];
    // A second after the end, against the stars: what stands still there stays behind.
    let missed =
        angle_between(&seen.direction, &aim.at.in_space(time + 1.0, &frame_rate).direction).to_degrees();
    lines.push(format!(
        "at rest: {} deg off a second later; aimed at 0 s: {} deg off",
        significant(missed, 2),
        significant(moved, 3)
    ));
    lines
}
