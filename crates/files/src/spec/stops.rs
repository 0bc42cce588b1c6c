//! `[[stop]]`: the stops of a sequence, and their order.

use super::attitude::{self, Use};
use super::{Section, constraint, escape, short, sky};
use slewkit::maneuver::{Aim, Constraint, EndCondition, Problem, ProblemError, Rule, State};
use slewkit::sequence::order::Visit;
use slewkit::sequence::{Ordering, Place, Sequence, Stop};
use slewkit::{Matrix3, Vector3};

/// The keys of a table that have no meaning beside stops, with the reason.
const ALONE: [(&str, &str); 4] = [
    ("feedback", "gains are of one maneuver"),
    ("uncertainty", "covariances are of one maneuver"),
    ("plant", "a plant flies one maneuver"),
    ("dispersion", "cases are of one maneuver"),
];

/// Returns whether a spec has stops.
pub(crate) fn has_stops(root: &Section) -> bool {
    root.knows("stop") && !root.list("stop").is_empty()
}

/// Reads all stops; `None` if the report has an error of one.
pub(crate) fn read(root: &Section, sky: &mut sky::Reading) -> Option<Vec<Stop>> {
    for (key, why) in ALONE {
        if root.has(key) {
            let reason = format!("{why}, and this spec has stops");
            root.error("E0029", key, reason, "remove it, or plan each leg by itself");
        }
    }
    let mut stops: Vec<Stop> = Vec::new();
    let mut all_read = true;
    for (index, section) in root.list("stop").iter().enumerate() {
        let name = name(section, index);
        let is_end = name == "end" && root.has("end");
        if is_end || stops.iter().any(|other| other.name == name) {
            let reason = format!("another stop is called \"{}\"", escape(&name));
            section.error("E0011", "name", reason, "give it another name: reports identify stops by theirs");
        }
        match stop(section, name, sky) {
            Some(stop) => stops.push(stop),
            None => all_read = false,
        }
    }
    all_read.then_some(stops)
}

/// Returns how long a sequence lasts at least, by its holds and the begins of its windows, and until
/// when its windows are open, both \[s\].
pub(crate) fn lasting(root: &Section) -> [f64; 2] {
    let mut rests = 0.0;
    let (mut least, mut open) = (0.0_f64, 0.0_f64);
    for stop in root.list("stop") {
        let time = |key: &str| if stop.has(key) { stop.number(key).unwrap_or(0.0) } else { 0.0 };
        rests += time("settling_s") + time("hold_s");
        let window = if stop.has("window_s") { stop.square("window_s") } else { None };
        let [from, until] = match window.as_ref().and_then(|pairs| pairs.first()).map(Vec::as_slice) {
            Some([from, until]) => [*from, *until],
            _ => [time("start_s"); 2],
        };
        (least, open) = (least.max(from + time("hold_s")), open.max(until));
    }
    [least.max(rests), open]
}

/// Returns the name of a stop, which is its number if it has none.
fn name(section: &Section, index: usize) -> String {
    section.word("name").map_or_else(|| (index + 1).to_string(), String::from)
}

/// Reads one stop.
fn stop(section: &Section, name: String, sky: &mut sky::Reading) -> Option<Stop> {
    let place = if section.has("point") {
        let aim = sky.aim(section, None)?;
        if let Err(error) = aim.check() {
            return section.refuse("E0078", "point", error.to_string(), "check the axes and the directions");
        }
        Place::Aim(aim)
    } else {
        if section.has("second") {
            let reason = "`second` needs `point`, which the stop does not have";
            return section.refuse("E0021", "second", reason, "remove the key, or give `point`");
        }
        let given = section.section("attitude")?;
        if given.has("file") {
            let reason = "the attitude of a stop is given by numbers, not by a file";
            return section.refuse("E0190", "attitude", reason, "give a quaternion or another notation");
        }
        Place::Attitude(attitude::rotation(given, Use::Attitude)?.matrix)
    };
    let time = |key: &str| if section.has(key) { section.number(key) } else { Some(0.0) };
    let (settling, hold) = (time("settling_s")?, time("hold_s")?);
    let (window, pinned) = if section.has("start_s") {
        ([section.number("start_s")?, f64::INFINITY], true)
    } else if section.has("window_s") {
        let pair = section.square("window_s")?;
        let [from, until] = <[f64; 2]>::try_from(pair.first()?.clone()).ok()?;
        if hold - (until - from) > Visit::ROUND_OFF * (from.abs() + hold) {
            let reason =
                format!("the window is {} s long, and the hold takes {} s", short(until - from), short(hold));
            return section.refuse("E0190", "window_s", reason, "shorten the hold, or widen the window");
        }
        ([from, until], false)
    } else {
        (Visit::PASSED.window, false)
    };
    let rate = section.angle("angular_velocity_limit_deg_s", "angular_velocity_limit_rad_s");
    let passes = section.flag("passing").unwrap_or(false);
    if let (Some(rate), false) = (rate, passes) {
        let reason = "the body stops here, so it has no rate that a bound could be of";
        return section.refuse("E0029", rate.key, reason, "add passing = true, or remove the key");
    }
    let passing = passes.then(|| {
        rate.map_or(f64::INFINITY, |rate| {
            if rate.key.ends_with("_deg_s") { rate.value.to_radians() } else { rate.value }
        })
    });
    Some(Stop { name, place, visit: Visit { settling, hold, window, pinned }, passing })
}

/// Reads the order of stops, of which one that stays last is moved to the end of the list.
/// `with_end` tells whether [end] is the last of them.
pub(crate) fn order(maneuver: &Section, stops: &mut Vec<Stop>, with_end: bool) -> Option<Ordering> {
    let free = maneuver.word("order") == Some("free");
    if !maneuver.has("last") {
        return Some(match (free, with_end) {
            (false, _) => Ordering::Given,
            (true, false) => Ordering::Free,
            (true, true) => Ordering::FreeBeforeLast,
        });
    }
    if !free || with_end {
        let reason =
            if free { "[end] stays last already" } else { "the order is given, and with it the last stop" };
        return maneuver.refuse(
            "E0028",
            "last",
            reason,
            "remove `last`; or write order = \"free\" with stops alone",
        );
    }
    let name = maneuver.word("last")?;
    let Some(index) = stops.iter().position(|stop| stop.name == name) else {
        let reason = format!("no stop is called \"{}\"", escape(name));
        return maneuver.refuse("E0021", "last", reason, "give the `name` of a [[stop]]");
    };
    let last = stops.remove(index);
    stops.push(last);
    Some(Ordering::FreeBeforeLast)
}

/// Refuses the order of stops where there are none.
pub(crate) fn refuse_order(maneuver: &Section) -> Option<()> {
    for key in ["order", "last"] {
        if maneuver.has(key) {
            let reason = format!("`{key}` needs stops, and the spec has none");
            return maneuver.refuse("E0021", key, reason, "add [[stop]], or remove the key");
        }
    }
    Some(())
}

/// Returns an attitude in which a boresight points at a target that stands still.
fn pointing(aim: &Aim, sequence: &Sequence) -> Option<Matrix3> {
    let zero = Vector3::zeros();
    let ends = aim.ends(0.0, &sequence.craft.start.attitude, &zero).ok();
    ends.filter(|_| !aim.moves(&zero)).map(|ends| ends.at(0.0).0)
}

/// Returns whether a constraint is of cones for one boresight alone.
fn is_of(constraint: &Constraint, boresight: &Vector3) -> bool {
    matches!(&constraint.rule, Rule::Pointing(cone) if cone.boresights == [*boresight])
}

/// Reports the stops that violate a constraint, and what sequences cannot have; returns whether
/// there is none.
pub(crate) fn check(root: &Section, sequence: &Sequence) -> bool {
    let mut sound = true;
    for (index, section) in root.list("stop").iter().enumerate() {
        let name = name(section, index);
        let Some(stop) = sequence.stops.iter().find(|stop| stop.name == name) else { continue };
        let there = |attitude: Matrix3| Problem {
            end: State::attitude(attitude, Vector3::zeros()),
            end_condition: EndCondition::State,
            ..sequence.craft.clone()
        };
        let (key, there) = match &stop.place {
            Place::Attitude(attitude) => ("attitude", there(*attitude)),
            Place::Aim(aim) => {
                // Where the axis that points is in a cone, no roll helps.
                let Some(attitude) = pointing(aim, sequence) else { continue };
                let mut there = there(attitude);
                there.constraints.retain(|constraint| !aim.has_roll() || is_of(constraint, &aim.boresight));
                ("point", there)
            }
        };
        for error in there.violations() {
            let ProblemError::Violated { end: "end", name: constraint, found } = error else { continue };
            let (code, remedy) = constraint::violated(&there, &constraint, "stop");
            let reason = format!("stop \"{}\" violates \"{}\": {found}", escape(&name), escape(&constraint));
            section.error(code, key, reason, remedy);
            sound = false;
        }
    }
    if let Err(error) = sequence.check() {
        let remedy = "change the spec accordingly, or plan each leg by itself";
        root.error("E0190", "stop", escape(&error.to_string()), remedy);
        sound = false;
    }
    sound
}
