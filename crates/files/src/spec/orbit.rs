//! `[orbit]`, and the orbit of another satellite that is aimed at: two-line elements, Keplerian elements, a state, or an OEM.

use super::shape::open;
use super::{Section, cut, short};
use crate::epoch::Epoch;
use crate::exchange::{EphemerisAxes, Segment, read_ephemeris};
use slewkit_sky::{
    Clock, EarthRotation, Elements, Model, Orbit, earth_to_gcrs, teme_to_gcrs, true_of_date_to_gcrs,
};
use std::path::PathBuf;

/// Age of two-line elements from which a word is said \[days\]: they are off by 1 to 3 km a day.
const OLD: f64 = 3.0;

/// Of which at least one must be there.
const KINDS: [&str; 4] = ["tle", "oem", "position_m", "semi_major_axis_m"];

const KEPLERIAN: [&str; 5] =
    ["eccentricity", "inclination_deg", "raan_deg", "argument_of_perigee_deg", "true_anomaly_deg"];

/// All keys of an orbit.
pub(super) const KEYS: &[&str] = &[
    "tle",
    "oem",
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

/// When and beside what an orbit is read.
#[derive(Clone, Debug)]
pub(super) struct Around {
    /// When the maneuver begins.
    pub epoch: Epoch,
    /// The clock that starts then.
    pub clock: Clock,
    /// How the Earth turns.
    pub rotation: EarthRotation,
    /// How far ahead positions are needed \[s\].
    pub ahead: f64,
    /// The folder of the spec.
    pub folder: PathBuf,
}

/// The orbit that a table tells; `what` is its name in messages.
pub(super) fn orbit(section: &Section, what: &str, around: &Around) -> Option<Orbit> {
    let given: Vec<&str> = KINDS.into_iter().filter(|key| section.has(key)).collect();
    let state = section.has("position_m") || section.has("velocity_m_s");
    match given[..] {
        // Of [orbit] it has been said by the table of its keys.
        [first, second, ..] => {
            if section.path != "orbit" {
                let reason = format!("both `{first}` and `{second}` are given");
                section.error("E0028", second, reason, "give one of the two");
            }
            return None;
        }
        [] if section.path != "orbit" && !state => {
            let reason =
                format!("{what} needs `tle`, `oem`, `semi_major_axis_m`, or `position_m` and `velocity_m_s`");
            return section.refuse_here("E0021", reason, "add tle = [\"1 …\", \"2 …\"]");
        }
        _ => {}
    }
    let (lines, file) = (section.has("tle"), section.has("oem"));
    let of_others: Vec<&str> = match (lines || file, state) {
        (true, _) => [&KEPLERIAN[..], &["velocity_m_s", "epoch", "model"]].concat(),
        (false, true) => KEPLERIAN.to_vec(),
        (false, false) => Vec::new(),
    };
    if let Some(key) = of_others.into_iter().find(|key| section.has(key)) {
        let kind = match (lines, file) {
            (true, _) => "two-line elements",
            (_, true) => "a file",
            _ => "a position and a velocity",
        };
        let reason = format!("`{key}` is not used: the orbit is told by {kind}");
        return section.refuse("E0029", key, reason, "leave it out");
    }
    if lines {
        return two_lines(section, &section.texts("tle")?, around.clock);
    }
    if file {
        return of_file(section, around);
    }
    let model = if section.word("model") == Some("two_body") { Model::TwoBody } else { Model::J2 };
    let at = match section.word("epoch") {
        None if section.has("epoch") => return None,
        None => around.clock,
        Some(text) => match Epoch::parse(text) {
            Ok(epoch) => epoch.clock(),
            Err(error) => {
                let remedy = "write epoch = \"2026-11-21T07:00:00 UTC\"";
                return section.refuse("E0130", "epoch", format!("`epoch`: {error}"), remedy);
            }
        },
    };
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
    let [first, second] = lines else {
        let reason = format!("`tle` has {} lines, two-line elements have two", lines.len());
        return section.refuse("E0026", "tle", reason, "write [\"1 …\", \"2 …\"], without the title");
    };
    let orbit = Orbit::of_two_lines([first, second], clock);
    let remedy = "copy both lines with all their columns; the last digit of each is its checksum";
    let orbit = orbit.map_err(|error| section.error("E0076", "tle", error.to_string(), remedy)).ok()?;
    let days = orbit.age().abs() / 86_400.0;
    if days > OLD {
        let reason = format!(
            "the elements are {} days old: the satellite may be some kilometres elsewhere",
            short((days * 10.0).round() / 10.0)
        );
        section.warn("W0076", "tle", reason, "take newer ones; 1 km is 0.1 deg for a station 600 km away");
    }
    Some(orbit)
}

/// The orbit of an OEM: that of the first segment in which the whole maneuver lies.
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
            let (line, reason, remedy) = errors.0.into_iter().next().map_or_else(
                || (1, "it cannot be read".into(), "check it".into()),
                |error| (error.line, error.reason, error.remedy),
            );
            return section.refuse("E0092", "oem", format!("{shown}: line {line}: {reason}"), remedy);
        }
    };
    let (begin, end) = (around.epoch, around.epoch.after(around.ahead));
    let covers = |segment: &&Segment| {
        begin.since(&segment.span[0]) >= -ROUNDED && segment.span[1].since(&end) >= -ROUNDED
    };
    let Some(segment) = segments.iter().find(covers) else {
        let of = |segment: &Segment| format!("from {} to {}", segment.span[0], segment.span[1]);
        let mut spans: Vec<String> = segments.iter().take(SHOWN).map(of).collect();
        spans.extend((segments.len() > SHOWN).then(|| "in more segments".into()));
        let reason = format!(
            "{shown} has positions {}, none of them all the way from {begin} to {end}",
            spans.join(", ")
        );
        let remedy = "take a file of that span, or a shorter maneuver; one whose duration is sought needs duration_at_most_s";
        return section.refuse("E0076", "oem", reason, remedy);
    };
    let time: Vec<f64> = segment.moment.iter().map(|moment| moment.since(&begin)).collect();
    let axes = |time: f64| match segment.axes {
        EphemerisAxes::Inertial(matrix) => matrix,
        EphemerisAxes::Teme => teme_to_gcrs(&around.clock, time),
        EphemerisAxes::TrueOfDate => true_of_date_to_gcrs(&around.clock, time),
        EphemerisAxes::Earth => earth_to_gcrs(&around.clock, time, &around.rotation),
    };
    let position =
        time.iter().zip(&segment.position).map(|(time, position)| axes(*time) * position).collect();
    let made = Orbit::of_table(time, position, segment.degree, around.clock);
    made.map_err(|error| section.error("E0076", "oem", error.to_string(), "check the file")).ok()
}

/// Moments are equal to this \[s\]: sums of seconds in doubles.
const ROUNDED: f64 = 1e-6;
/// How many segments a message names.
const SHOWN: usize = 3;
