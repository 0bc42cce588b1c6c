//! Reading of `[[stop]]`: the stops of a sequence and their order.

use super::attitude::{self, Use};
use super::{Section, constraint, cut, escape, names, short, sky};
use crate::epoch::Epoch;
use slewkit::maneuver::{Aim, Constraint, EndCondition, Problem, ProblemError, Rule, State};
use slewkit::numerics::figures::counted;
use slewkit::sequence::order::Visit;
use slewkit::sequence::{Ordering, Place, Sequence, Stop};
use slewkit::{Matrix3, Vector3};

/// Keys that cannot be combined with stops, each with the reason.
const ALONE: [(&str, &str); 1] = [("dispersion", "cases need a single maneuver")];

/// Returns whether the spec has stops, so that it describes a sequence.
pub(crate) fn has_stops(root: &Section) -> bool {
    root.knows("stop") && !root.list("stop").is_empty()
}

/// Reads all stops; `None` if one of them has an error.
pub(crate) fn read(root: &Section, sky: &mut sky::Reading) -> Option<Vec<Stop>> {
    for (key, why) in ALONE {
        if root.has(key) {
            let reason = format!("{why}, but this spec has stops");
            root.error("E0029", key, reason, "remove it, or plan each leg separately");
        }
    }
    let mut stops: Vec<Stop> = Vec::new();
    let mut all_read = true;
    for (index, section) in root.list("stop").iter().enumerate() {
        let name = name(section, index);
        let is_end = name == "end" && root.has("end");
        if is_end || stops.iter().any(|other| other.name == name) {
            let reason = format!("the name \"{}\" is already used by another stop", escape(&name));
            section.error("E0011", "name", reason, "give it another name: reports identify stops by name");
        }
        match stop(section, name, sky) {
            Some(stop) => stops.push(stop),
            None => all_read = false,
        }
    }
    all_read.then_some(stops)
}

/// Returns the shortest possible duration of a sequence, according to its holds and the starts of
/// its windows, and the time at which the last window ends, both in seconds.
pub(crate) fn lasting(root: &Section, epoch: Option<Epoch>) -> [f64; 2] {
    let mut rests = 0.0;
    let (mut least, mut open) = (0.0_f64, 0.0_f64);
    for stop in root.list("stop") {
        let time = |key: &str| if stop.has(key) { stop.number(key).unwrap_or(0.0) } else { 0.0 };
        rests += time("settling_s") + time("hold_s");
        let Ok(Some(Opening { window: [from, until], pinned, .. })) = opening(stop, epoch) else { continue };
        let until = if pinned { from } else { until };
        (least, open) = (least.max(from + time("hold_s")), open.max(until));
    }
    [least.max(rests), open]
}

/// Time interval in which a hold must take place.
struct Opening {
    /// Key under which the spec states the interval.
    key: &'static str,
    /// Interval that must contain the hold \[s\].
    window: [f64; 2],
    /// True if the hold must begin at the start of the interval.
    pinned: bool,
}

/// Code, key, reason and remedy of the error of a window; `None` if the error has been reported.
type Fault = Option<(&'static str, &'static str, String, String)>;

/// Returns the time interval of the hold at a stop; `None` if the spec does not state one. Dates
/// are converted to seconds after `epoch`.
fn opening(stop: &Section, epoch: Option<Epoch>) -> Result<Option<Opening>, Fault> {
    const WINDOW: &str = "window";
    const START: &str = "start";
    // Converts a date to seconds after the epoch. A date before the epoch is an error.
    let seconds = |key: &'static str, text: &str| {
        let wrong =
            |(reason, remedy)| Some(("E0130", key, format!("{reason}: \"{}\"", cut(text, 60)), remedy));
        let date = names::date(key, text).map_err(wrong)?;
        Ok::<_, Fault>(date.since(&epoch.ok_or(None)?))
    };
    let past = |key: &'static str, text: &str, time: f64| {
        let reason = format!(
            "`{key}`: {} is {} s before the `epoch`, at which the sequence begins",
            escape(text),
            short(-time)
        );
        Some(("E0079", key, reason, "give a later date, or an earlier `epoch`".to_string()))
    };
    let opening = |key, window, pinned| Ok(Some(Opening { key, window, pinned }));
    if stop.has(START) {
        let text = stop.word(START).ok_or(None)?;
        let from = seconds(START, text)?;
        return if from < 0.0 {
            Err(past(START, text, from))
        } else {
            opening(START, [from, f64::INFINITY], true)
        };
    }
    if stop.has(WINDOW) {
        let texts = stop.texts(WINDOW).ok_or(None)?;
        let [first, last] = &texts[..] else {
            let reason =
                format!("`window` has {}: an interval is [from, until]", counted(texts.len(), "date"));
            let remedy = "write window = [\"2026-11-21T07:05:00 UTC\", \"2026-11-21T07:15:00 UTC\"]";
            return Err(Some(("E0026", WINDOW, reason, remedy.into())));
        };
        let (from, until) = (seconds(WINDOW, first)?, seconds(WINDOW, last)?);
        if until < from {
            let reason = format!(
                "`window`: {} is before {}: an interval is [from, until]",
                escape(last),
                escape(first)
            );
            return Err(Some(("E0079", WINDOW, reason, "swap the two dates".into())));
        }
        return if until < 0.0 {
            Err(past(WINDOW, last, until))
        } else {
            opening(WINDOW, [from, until], false)
        };
    }
    if stop.has("start_s") {
        let from = stop.number("start_s").ok_or(None)?;
        return opening("start_s", [from, f64::INFINITY], true);
    }
    if stop.has("window_s") {
        let pairs = stop.square("window_s").ok_or(None)?;
        let pair = pairs.first().and_then(|pair| <[f64; 2]>::try_from(&pair[..]).ok());
        return opening("window_s", pair.ok_or(None)?, false);
    }
    Ok(None)
}

/// Returns the name of a stop, or its number if it has no name.
fn name(section: &Section, index: usize) -> String {
    section.word("name").map_or_else(|| (index + 1).to_string(), String::from)
}

/// Reads a stop, whose name is `name`.
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
            let reason = "an attitude file is not supported for a stop";
            return section.refuse("E0190", "attitude", reason, "give a quaternion or another notation");
        }
        Place::Attitude(attitude::rotation(given, Use::Attitude)?.matrix)
    };
    let time = |key: &str| if section.has(key) { section.number(key) } else { Some(0.0) };
    let (settling, hold) = (time("settling_s")?, time("hold_s")?);
    let dated = ["window", "start"].into_iter().find(|key| section.has(key));
    let epoch = match dated {
        Some(key) => Some(sky.epoch(section, key)?),
        None => None,
    };
    let (window, pinned) = match opening(section, epoch) {
        Ok(Some(Opening { key, window: [from, until], pinned })) => {
            if hold - (until - from) > Visit::ROUND_OFF * (from.abs() + hold) {
                let [length, hold] = [until - from, hold].map(short);
                let reason = format!("the window is {length} s long, but the hold takes {hold} s");
                return section.refuse("E0190", key, reason, "shorten the hold, or widen the window");
            }
            ([from, until], pinned)
        }
        Ok(None) => (Visit::PASSED.window, false),
        Err(fault) => {
            let (code, key, reason, remedy) = fault?;
            return section.refuse(code, key, reason, remedy);
        }
    };
    let rate = section.angle("angular_velocity_limit_deg_s", "angular_velocity_limit_rad_s");
    let passes = section.flag("passing").unwrap_or(false);
    if let (Some(rate), false) = (rate, passes) {
        let reason = "the body is at rest here, so a bound on its rate has no effect";
        return section.refuse("E0029", rate.key, reason, "add passing = true, or remove the key");
    }
    let passing = passes.then(|| {
        rate.map_or(f64::INFINITY, |rate| {
            if rate.key.ends_with("_deg_s") { rate.value.to_radians() } else { rate.value }
        })
    });
    Some(Stop { name, place, visit: Visit { settling, hold, window, pinned }, passing })
}

/// Reads the order of the stops. The stop that must remain last is moved to the end of the list.
/// `with_end` is true if `[end]` is the last stop.
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
        let reason = format!("no stop has the name \"{}\"", escape(name));
        return maneuver.refuse("E0021", "last", reason, "give the `name` of a [[stop]]");
    };
    let last = stops.remove(index);
    stops.push(last);
    Some(Ordering::FreeBeforeLast)
}

/// Reports an error if the spec has an order of stops but no stops.
pub(crate) fn refuse_order(maneuver: &Section) -> Option<()> {
    for key in ["order", "last"] {
        if maneuver.has(key) {
            let reason = format!("`{key}` needs stops, but the spec has none");
            return maneuver.refuse("E0021", key, reason, "add [[stop]], or remove the key");
        }
    }
    Some(())
}

/// Returns an attitude in which the boresight points at the target; `None` if the target moves.
fn pointing(aim: &Aim, sequence: &Sequence) -> Option<Matrix3> {
    let zero = Vector3::zeros();
    let ends = aim.ends(0.0, &sequence.craft.start.attitude, &zero).ok();
    ends.filter(|_| !aim.moves(&zero)).map(|ends| ends.at(0.0).0)
}

/// Returns whether a constraint consists of cones for the boresight `boresight` only.
fn is_of(constraint: &Constraint, boresight: &Vector3) -> bool {
    matches!(&constraint.rule, Rule::Pointing(cone) if cone.boresights == [*boresight])
}

/// Reports the stops that violate a constraint, and contents of the spec that sequences do not
/// support. Returns true if nothing was reported.
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
                // Constraints on other boresights depend on the roll and are not checked here.
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
        let remedy = "change the spec accordingly, or plan each leg separately";
        root.error("E0190", "stop", escape(&error.to_string()), remedy);
        sound = false;
    }
    sound
}
