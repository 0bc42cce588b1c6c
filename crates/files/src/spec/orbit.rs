//! Reading of `[orbit]` and of the orbit of a targeted satellite. An orbit is given by two-line
//! elements, an OMM, Keplerian elements, a state, or an OEM.

mod table;

use super::shape::open;
use super::{Diagnostics, Section, cut, names, short};
use crate::epoch::Epoch;
use crate::exchange::{EphemerisAxes, Segment, read_ephemeris, read_mean_elements};
use slewkit::Vector3;
use slewkit::numerics::figures::significant;
use slewkit_sky::{
    Clock, EarthRotation, Elements, Model, Orbit, Table, earth_to_gcrs, teme_to_gcrs, true_of_date_to_gcrs,
};
use std::path::PathBuf;

/// Age above which mean elements cause a warning \[days\].
const OLD: f64 = 3.0;
/// Lower and upper estimate of the daily growth of the position error of mean elements \[km\].
const OFF_A_DAY: [f64; 2] = [1.0, 3.0];
/// Default age above which mean elements are rejected \[days\]. At this age, an error of 10 % in
/// the drag leads to a position error of a hundred kilometres.
const OLDEST: f64 = 30.0;

/// Keys that define an orbit; exactly one of them must be given.
const KINDS: [&str; 5] = ["tle", "omm", "oem", "position_m", "semi_major_axis_m"];

const KEPLERIAN: [&str; 5] =
    ["eccentricity", "inclination_deg", "raan_deg", "argument_of_perigee_deg", "true_anomaly_deg"];

/// All keys that the table of an orbit may have.
pub(super) const KEYS: &[&str] = &[
    "tle",
    "omm",
    "oem",
    "oldest_days",
    "semi_major_axis_m",
    "eccentricity",
    "inclination_deg",
    "raan_deg",
    "argument_of_perigee_deg",
    "true_anomaly_deg",
    "position_m",
    "velocity_m_s",
    "epoch",
    "model",
];

/// Data of the maneuver that are needed to read an orbit.
#[derive(Clone, Debug)]
pub(super) struct Around {
    /// Epoch at which the maneuver begins.
    pub epoch: Epoch,
    /// Clock whose time zero is the epoch of the maneuver.
    pub clock: Clock,
    /// Orientation of the Earth: UT1 − UTC and polar motion.
    pub rotation: EarthRotation,
    /// Time after the epoch until which positions are needed \[s\].
    pub ahead: f64,
    /// Folder of the spec, to which relative paths refer.
    pub folder: PathBuf,
}

/// Reads the orbit in the table `section`, which messages call `what`.
pub(super) fn orbit(section: &Section, what: &str, around: &Around) -> Option<Orbit> {
    let given: Vec<&str> = KINDS.into_iter().filter(|key| section.has(key)).collect();
    let state = section.has("position_m") || section.has("velocity_m_s");
    match given[..] {
        // For [orbit], the first pass has already reported the conflict.
        [first, second, ..] => {
            if section.path != "orbit" {
                let reason = format!("both `{first}` and `{second}` are given");
                section.error("E0028", second, reason, "give only one of the two");
            }
            return None;
        }
        [] if section.path != "orbit" && !state => {
            let reason = format!(
                "{what} needs `tle`, `omm`, `oem`, `semi_major_axis_m`, or `position_m` and `velocity_m_s`"
            );
            return section.refuse_here("E0021", reason, "add tle = [\"1 …\", \"2 …\"]");
        }
        _ => {}
    }
    let (lines, mean, file) = (section.has("tle"), section.has("omm"), section.has("oem"));
    let mut of_others: Vec<&str> = match (lines || mean || file, state) {
        (true, _) => [&KEPLERIAN[..], &["velocity_m_s", "epoch", "model"]].concat(),
        (false, true) => KEPLERIAN.to_vec(),
        (false, false) => Vec::new(),
    };
    if !(lines || mean) {
        of_others.push("oldest_days");
    }
    if let Some(key) = of_others.into_iter().find(|key| section.has(key)) {
        let kind = match (lines, mean || file, state) {
            (true, ..) => "two-line elements",
            (_, true, _) => "a file",
            (.., true) => "a position and a velocity",
            _ => "Keplerian elements",
        };
        let reason = format!("`{key}` is not used: the orbit is given by {kind}");
        return section.refuse("E0029", key, reason, "remove the key");
    }
    if lines {
        return two_lines(section, &section.texts("tle")?, around.clock);
    }
    if mean {
        return of_mean_elements(section, around);
    }
    if file {
        return of_file(section, around);
    }
    let model = if section.word("model") == Some("two_body") { Model::TwoBody } else { Model::J2 };
    let at = if section.has("epoch") { names::epoch(section)?.clock() } else { around.clock };
    let needs = |name: &str, sample: &str| {
        if !section.has(name) {
            let reason = format!("{what} needs `{name}`");
            return section.refuse_here::<()>("E0021", reason, format!("add {name} = {sample}"));
        }
        Some(())
    };
    let made = if state {
        needs("position_m", "[7000000, 0, 0]").and(needs("velocity_m_s", "[0, 7500, 0]"))?;
        let (position, velocity) = (section.vector("position_m")?, section.vector("velocity_m_s")?);
        Orbit::of_state(position, velocity, model, at, around.clock)
    } else {
        needs("semi_major_axis_m", "6928137")?;
        let angle = |name: &str| if section.has(name) { section.number(name) } else { Some(0.0) };
        let elements = Elements {
            semi_major_axis_m: section.number("semi_major_axis_m")?,
            eccentricity: angle("eccentricity")?,
            inclination_deg: angle("inclination_deg")?,
            raan_deg: angle("raan_deg")?,
            argument_of_perigee_deg: angle("argument_of_perigee_deg")?,
            true_anomaly_deg: angle("true_anomaly_deg")?,
        };
        Orbit::of_elements(&elements, model, at, around.clock)
    };
    made.map_err(|error| section.error_here("E0076", error.to_string(), "check the numbers and their units"))
        .ok()
}

fn two_lines(section: &Section, lines: &[String], clock: Clock) -> Option<Orbit> {
    // A line that precedes the two lines is the name of the satellite.
    let (first, second) = match lines {
        [first, second] => (first, second),
        [name, first, second] if !name.starts_with("1 ") => (first, second),
        _ => {
            let reason = format!("`tle` has {} lines, but two-line elements have two", lines.len());
            return section.refuse("E0026", "tle", reason, "write [\"1 …\", \"2 …\"]");
        }
    };
    let orbit = Orbit::of_two_lines([first, second], clock);
    let remedy = "copy both lines with all their columns and blanks; the last digit of each is its checksum";
    let orbit = orbit.map_err(|error| section.error("E0076", "tle", error.to_string(), remedy)).ok()?;
    recent(section, "tle", orbit)
}

/// Reads the orbit from an OMM file.
fn of_mean_elements(section: &Section, around: &Around) -> Option<Orbit> {
    let written = section.word("omm")?;
    let (path, file) = match open(written, &around.folder, "an orbit mean-elements message") {
        Ok(opened) => opened,
        Err((code, reason, remedy)) => return section.refuse(code, "omm", reason, remedy),
    };
    let shown = cut(&path.to_string_lossy(), 200);
    let mean =
        read_mean_elements(file, &shown).map_err(|errors| unread(section, "omm", &shown, errors)).ok()?;
    let made = Orbit::of_mean_elements(&mean, around.clock);
    let remedy = "check the numbers and their units";
    let orbit = made.map_err(|error| section.error("E0076", "omm", error.to_string(), remedy)).ok()?;
    recent(section, "omm", orbit)
}

/// Reports the first error of the file that the key `key` names.
fn unread(section: &Section, key: &str, shown: &str, errors: Diagnostics) {
    let (line, reason, remedy) = errors.0.into_iter().next().map_or_else(
        || (1, "it cannot be read".into(), "check it".into()),
        |error| (error.line, error.reason, error.remedy),
    );
    section.error("E0092", key, format!("{shown}: line {line}: {reason}"), remedy);
}

/// Checks the age of the mean elements of an orbit. Above [`OLD`] days it causes a warning; above
/// the limit of the spec, or [`OLDEST`] days, an error.
fn recent(section: &Section, key: &str, orbit: Orbit) -> Option<Orbit> {
    let days = orbit.age().abs() / 86_400.0;
    let most = if section.has("oldest_days") { section.number("oldest_days")? } else { OLDEST };
    let rounded = short((days * 10.0).round() / 10.0);
    let than = if orbit.age() < 0.0 { "newer than the epoch" } else { "old" };
    if days > most {
        let reason = format!(
            "the elements are {rounded} days {than}, but the limit is {}: the satellite may be anywhere on \
             its orbit",
            short(most)
        );
        let remedy = format!("use elements of that date; oldest_days = {} accepts these", short(days.ceil()));
        return section.refuse("E0076", key, reason, remedy);
    }
    if days > OLD {
        let [least, most] = OFF_A_DAY.map(|off| short((off * days).round()));
        let reason = format!(
            "the elements are {rounded} days {than}: the error of the position may be {least} to {most} km"
        );
        section.warn("W0076", key, reason, "use newer elements: from a station 600 km away, 1 km is 0.1 deg");
    }
    Some(orbit)
}

/// Reads the orbit from the first segment of an OEM file that covers the whole maneuver.
fn of_file(section: &Section, around: &Around) -> Option<Orbit> {
    let written = section.word("oem")?;
    let (path, file) = match open(written, &around.folder, "an orbit ephemeris message") {
        Ok(opened) => opened,
        Err((code, reason, remedy)) => return section.refuse(code, "oem", reason, remedy),
    };
    let shown = cut(&path.to_string_lossy(), 200);
    let segments = match read_ephemeris(file, &shown) {
        Ok(segments) => segments,
        Err(errors) => {
            unread(section, "oem", &shown, errors);
            return None;
        }
    };
    let (begin, end) = (around.epoch, around.epoch.after(around.ahead));
    let covers = |segment: &&Segment| {
        begin.since(&segment.span[0]) >= -ROUNDED && segment.span[1].since(&end) >= -ROUNDED
    };
    let mut covering = segments.iter().filter(covers);
    let Some(segment) = covering.next() else {
        let of = |segment: &Segment| format!("from {} to {}", segment.span[0], segment.span[1]);
        let mut spans: Vec<String> = segments.iter().take(SHOWN).map(of).collect();
        spans.extend((segments.len() > SHOWN).then(|| "in more segments".into()));
        let reason = format!(
            "{shown} has positions {}, none of them all the way from {begin} to {end}",
            spans.join(", ")
        );
        let remedy = "take a file of that span, or a shorter maneuver; one whose duration is sought needs \
            duration_at_most_s";
        return section.refuse("E0076", "oem", reason, remedy);
    };
    let table = tabulated(segment, around);
    for other in covering {
        let told = tabulated(other, around);
        let apart = [0.0, around.ahead].map(|time| {
            let [here, there] = [&table, &told].map(|table| table.position(time).unwrap_or_default());
            (here - there).norm()
        });
        let apart = apart[0].max(apart[1]);
        if apart > ONE_ORBIT {
            let reason = format!(
                "{shown}: the segments that begin at lines {} and {} both cover the maneuver, {} km apart",
                segment.line[0],
                other.line[0],
                significant(apart / 1e3, 3)
            );
            let remedy = "leave one of them in the file, or state in USEABLE_START_TIME and \
                USEABLE_STOP_TIME where each holds";
            return section.refuse("E0076", "oem", reason, remedy);
        }
    }
    if let Err((line, reason, remedy)) = table::check(section, &table, &segment.line, around.ahead, &shown) {
        return section.refuse("E0076", "oem", format!("{shown}: line {line}: {reason}"), remedy);
    }
    let made = Orbit::of_table(table, around.clock);
    made.map_err(|error| section.error("E0076", "oem", error.to_string(), "check the file")).ok()
}

/// Returns the rows of a segment with components in GCRS axes. Times are counted from the epoch of
/// the maneuver.
fn tabulated(segment: &Segment, around: &Around) -> Table {
    let time: Vec<f64> = segment.moment.iter().map(|moment| moment.since(&around.epoch)).collect();
    let (clock, rotation) = (&around.clock, &around.rotation);
    let axes = |time: f64| match segment.axes {
        EphemerisAxes::Inertial(matrix) => matrix,
        EphemerisAxes::Teme => teme_to_gcrs(clock, time),
        EphemerisAxes::TrueOfDate => true_of_date_to_gcrs(clock, time),
        EphemerisAxes::Earth => earth_to_gcrs(clock, time, rotation),
    };
    // In Earth-fixed axes, the rotation of the axes contributes to the velocity. The axes of date
    // turn by 8e-12 rad/s, which is negligible.
    let turning = |time: f64, position: &Vector3| match segment.axes {
        EphemerisAxes::Earth => {
            (earth_to_gcrs(clock, time + 1.0, rotation) - earth_to_gcrs(clock, time - 1.0, rotation))
                * position
                / 2.0
        }
        _ => Vector3::zeros(),
    };
    let rows = || time.iter().zip(segment.position.iter().zip(&segment.velocity));
    let velocity = rows()
        .map(|(time, (position, velocity))| axes(*time) * velocity + turning(*time, position))
        .collect();
    let position = rows().map(|(time, (position, _))| axes(*time) * position).collect();
    Table { time, position, velocity, between: segment.between }
}

/// Largest distance between the positions of two segments that count as the same orbit \[m\].
const ONE_ORBIT: f64 = 10.0;
/// Largest difference between two times that count as equal \[s\]. It allows for rounding of sums
/// of seconds.
const ROUNDED: f64 = 1e-6;
/// Largest number of segments that a message lists.
const SHOWN: usize = 3;
