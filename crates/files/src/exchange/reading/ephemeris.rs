//! Positions of a satellite, from an orbit ephemeris message of CCSDS (OEM 1.0 to 3.0, keywords and
//! values or XML).
//!
//! A row is a date, a position \[km\] and a velocity \[km/s\]; an acceleration may follow, and is
//! ignored. The segment names the interpolation polynomial: a Lagrange polynomial through the
//! positions, or, by default, a Hermite polynomial through positions and velocities. Linear
//! interpolation is rejected, because it does not follow an orbit. Covariances are ignored. Rows of
//! different segments are not combined.

mod xml;

use super::keywords::pair;
use super::message::date;
use super::{Piece, Wrong, lines, resolved, whole_text, wrong};
use crate::epoch::{Epoch, Scale};
use crate::exchange::frames::{Meaning, meaning};
use crate::spec::{Diagnostics, Source, cut};
use slewkit::{Matrix3, Vector3};
use slewkit_sky::Between;
use std::io::Read;

/// Degree of the polynomial if the segment does not state one. A Hermite polynomial of this degree
/// through rows one minute apart follows a low orbit within a micrometre.
const DEGREE: usize = 7;
/// Lowest degree that is accepted. From this degree, the second derivative of the interpolated
/// position is nearly continuous at the rows.
const LOWEST: usize = 3;
/// Highest degree that is accepted; polynomials of higher degree on a uniform grid oscillate.
const HIGHEST: usize = 25;

/// Axes in which the positions and velocities of a segment are given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EphemerisAxes {
    /// Inertial axes, with the rotation from components in these axes to components in the ICRF.
    Inertial(Matrix3),
    /// True equator and mean equinox of date (TEME).
    Teme,
    /// True equator and true equinox of date (TOD).
    TrueOfDate,
    /// Axes that turn with the Earth (ITRF).
    Earth,
}

/// Positions and velocities of a satellite over an interval of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// First and last time at which the positions may be used.
    pub span: [Epoch; 2],
    /// Times of the rows, in increasing order.
    pub moment: Vec<Epoch>,
    /// Position in each row, relative to the centre of the Earth \[m\]; `axes` names its axes.
    pub position: Vec<Vector3>,
    /// Velocity in each row, relative to the axes `axes`, which may rotate \[m/s\].
    pub velocity: Vec<Vector3>,
    /// Line number of each row, counted from 1.
    pub line: Vec<usize>,
    /// Axes of the positions and velocities.
    pub axes: EphemerisAxes,
    /// Interpolation method between the rows. Its degree does not require more rows than the
    /// segment has.
    pub between: Between,
}

/// Reads an OEM and returns its segments; `name` is the name of the file in messages.
///
/// # Errors
/// Returns the first error, with its line. A centre other than the Earth is an error, and so is a
/// frame other than ICRF, GCRF, EME2000, TOD, TEME and ITRF.
pub fn read_ephemeris(input: impl Read, name: &str) -> Result<Vec<Segment>, Diagnostics> {
    let text = whole_text(input, name, "an OEM")?;
    match segments(&text) {
        Err(wrong) => Err(resolved(wrong, name, text)),
        Ok(mut found) => {
            let source = Source::new(name, text);
            for line in found.iter_mut().flat_map(|segment| &mut segment.line) {
                *line = source.line_number(*line);
            }
            Ok(found)
        }
    }
}

/// Keys that the metadata of a segment may have, including keys that are ignored.
const KNOWN: [&str; 13] = [
    "OBJECT_NAME",
    "OBJECT_ID",
    "CENTER_NAME",
    "REF_FRAME",
    "REF_FRAME_EPOCH",
    "TIME_SYSTEM",
    "START_TIME",
    "USEABLE_START_TIME",
    "USEABLE_STOP_TIME",
    "STOP_TIME",
    "INTERPOLATION",
    "INTERPOLATION_DEGREE",
    "COMMENT",
];

/// Keys that may precede the first segment.
const HEADER: [&str; 4] = ["CREATION_DATE", "ORIGINATOR", "MESSAGE_ID", "CLASSIFICATION"];

/// Keys and values of the metadata that are being read.
type Keys<'t> = Vec<(&'static str, Piece<'t>)>;

/// The part of the file to which a line belongs.
enum Place<'t> {
    Header,
    Metadata(Keys<'t>),
    Data(Started),
    Covariance(Started),
}

/// A segment whose rows are being read.
struct Started {
    /// The segment; until all rows are read, `line` holds byte positions in place of line numbers.
    segment: Segment,
    scale: Scale,
    /// True for Hermite interpolation, false for Lagrange interpolation.
    hermite: bool,
    /// Degree of interpolation that the segment states; `None` if it states none.
    degree: Option<usize>,
}

fn segments(text: &str) -> Result<Vec<Segment>, Wrong> {
    let mut lines = lines(text);
    let Some(first) = lines.next() else { return wrong(0, 1, "the file is empty", "give an OEM") };
    if first.text.starts_with('<') {
        return xml::segments(text);
    }
    let (key, version) = pair(first)?;
    if !key.is("CCSDS_OEM_VERS") {
        let reason = format!("the file is not an OEM: it begins with `{}`", cut(key.text, 30));
        return key.wrong(reason, "give an orbit ephemeris: CCSDS_OEM_VERS = 2.0");
    }
    check_version(version)?;
    let (mut place, mut found, mut last) = (Place::Header, Vec::new(), first);
    let mut object = None;
    for line in lines {
        last = line;
        if line.text.get(..7).is_some_and(|start| start.eq_ignore_ascii_case("COMMENT")) {
            continue;
        }
        place = match place {
            Place::Header if line.is("META_START") => Place::Metadata(Keys::new()),
            Place::Header => {
                let (key, _) = pair(line)?;
                if !HEADER.into_iter().any(|known| key.is(known)) {
                    let reason = format!("unknown key `{}` in the header of an OEM", cut(key.text, 40));
                    return key.wrong(reason, "write META_START before the metadata");
                }
                Place::Header
            }
            Place::Metadata(keys) if line.is("META_STOP") => Place::Data(started(&keys, line, &mut object)?),
            Place::Metadata(mut keys) => {
                let (key, value) = pair(line)?;
                add(&mut keys, key, value)?;
                Place::Metadata(keys)
            }
            Place::Data(started) if line.is("META_START") => {
                found.push(started.finish(line)?);
                Place::Metadata(Keys::new())
            }
            Place::Data(started) if line.is("COVARIANCE_START") => Place::Covariance(started),
            Place::Data(mut started) => {
                started.line(line)?;
                Place::Data(started)
            }
            Place::Covariance(started) if line.is("COVARIANCE_STOP") => Place::Data(started),
            Place::Covariance(started) => Place::Covariance(started),
        };
    }
    match place {
        Place::Data(started) => found.push(started.finish(last)?),
        Place::Header => return last.wrong("the file has no segment", "begin a segment with META_START"),
        Place::Metadata(_) => {
            return last.wrong("the metadata do not end", "META_STOP is missing: the file is cut off");
        }
        Place::Covariance(_) => {
            return last
                .wrong("the covariance does not end", "COVARIANCE_STOP is missing: the file is cut off");
        }
    }
    Ok(found)
}

fn check_version(version: Piece<'_>) -> Result<(), Wrong> {
    if ["1.0", "2.0", "3.0"].contains(&version.text) {
        return Ok(());
    }
    let reason = format!("version {} is not known", cut(version.text, 20));
    version.wrong(reason, "give an OEM of version 1.0, 2.0 or 3.0")
}

fn add<'t>(keys: &mut Keys<'t>, key: Piece<'t>, value: Piece<'t>) -> Result<(), Wrong> {
    let Some(name) = KNOWN.into_iter().find(|known| key.is(known)) else {
        let reason = format!("unknown key `{}` in the metadata of an OEM", cut(key.text, 40));
        return key.wrong(reason, "check the spelling");
    };
    if keys.iter().any(|(known, _)| *known == name) {
        return key.wrong(format!("`{name}` is given twice"), "give it once in a segment");
    }
    if value.text.is_empty() {
        return key.wrong(format!("`{name}` has no value"), "write KEY = value");
    }
    keys.push((name, value));
    Ok(())
}

/// Name and number of the object to which all segments of the file belong.
type Object<'t> = Option<[Piece<'t>; 2]>;

/// Creates a segment without rows from its metadata. `end` is the position at which the metadata
/// end, for messages.
fn started<'t>(keys: &Keys<'t>, end: Piece<'t>, object: &mut Object<'t>) -> Result<Started, Wrong> {
    let get = |name: &str| keys.iter().find(|(key, _)| *key == name).map(|(_, value)| *value);
    let here = ["OBJECT_NAME", "OBJECT_ID"].map(|name| get(name).unwrap_or(Piece { at: end.at, text: "" }));
    let above = *object.get_or_insert(here);
    if let Some((one, other)) = here.iter().zip(above).find(|(one, other)| !one.is(other.text)) {
        let (one, other) = (cut(one.text, 40), cut(other.text, 40));
        let reason = format!("this segment is of {one}, the one above of {other}");
        return here[0].wrong(reason, "give one file for each object");
    }
    let needed = |name: &str| {
        get(name).map_or_else(
            || end.wrong(format!("the metadata have no `{name}`"), format!("add {name} = …")),
            Ok,
        )
    };
    let centre = needed("CENTER_NAME")?;
    if !centre.is("EARTH") {
        let reason = format!("the centre is {}, not the Earth", cut(centre.text, 30));
        return centre.wrong(reason, "give positions relative to the Earth: CENTER_NAME = EARTH");
    }
    let scale = needed("TIME_SYSTEM")?;
    let Some(scale) = Scale::named(scale.text) else {
        let reason = format!("the time system {} is not supported", cut(scale.text, 20));
        return scale.wrong(reason, "give UTC, TAI, TT, TDB or GPS");
    };
    let axes = axes(needed("REF_FRAME")?, get("REF_FRAME_EPOCH"))?;
    let of = |name: &str, instead: Piece<'_>| date(get(name).unwrap_or(instead), scale);
    let (start, stop) = (needed("START_TIME")?, needed("STOP_TIME")?);
    date(start, scale).and(date(stop, scale))?;
    let span = [of("USEABLE_START_TIME", start)?, of("USEABLE_STOP_TIME", stop)?];
    if span[1].since(&span[0]) < 0.0 {
        return stop.wrong("the span ends before it begins", "swap the two times");
    }
    let named = match get("INTERPOLATION_DEGREE") {
        None => None,
        Some(piece) => {
            let degree = piece.number()?.value;
            if degree.fract() != 0.0 || !(LOWEST as f64..=HIGHEST as f64).contains(&degree) {
                let reason = format!("the interpolation degree {} is not supported", cut(piece.text, 20));
                return piece.wrong(reason, format!("give a whole number from {LOWEST} to {HIGHEST}"));
            }
            Some(degree as usize)
        }
    };
    let hermite = match get("INTERPOLATION") {
        None => named.is_none(),
        Some(how) if how.is("LAGRANGE") => false,
        Some(how) if how.is("HERMITE") => true,
        Some(how) => {
            let reason = format!("the interpolation {} between rows is not supported", cut(how.text, 30));
            return how.wrong(reason, "give LAGRANGE or HERMITE");
        }
    };
    let segment = Segment {
        span,
        moment: Vec::new(),
        position: Vec::new(),
        velocity: Vec::new(),
        line: Vec::new(),
        axes,
        between: Between::Lagrange(0),
    };
    Ok(Started { segment, scale, hermite, degree: named })
}

fn axes(frame: Piece<'_>, of_date: Option<Piece<'_>>) -> Result<EphemerisAxes, Wrong> {
    let axes = match meaning(frame.text) {
        Meaning::Inertial(matrix) => return Ok(EphemerisAxes::Inertial(matrix)),
        _ if frame.is("TEME") => EphemerisAxes::Teme,
        _ if frame.is("TOD") => EphemerisAxes::TrueOfDate,
        _ if frame.text.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("ITRF")) => {
            EphemerisAxes::Earth
        }
        _ => {
            let reason = format!("positions in the frame {} are not supported", cut(frame.text, 30));
            return frame.wrong(reason, "give them in ICRF, GCRF, EME2000, TOD, TEME or ITRF");
        }
    };
    match of_date {
        None => Ok(axes),
        Some(date) => date
            .wrong("a frame frozen at an epoch is not supported", "give positions in ICRF, GCRF or EME2000"),
    }
}

impl Started {
    /// Reads a row of the keyword notation.
    fn line(&mut self, line: Piece<'_>) -> Result<(), Wrong> {
        let words = line.words();
        if ![7, 10].contains(&words.len()) {
            let reason = format!("a row has {} words", words.len());
            return line.wrong(reason, "give a date, a position in km and a velocity in km/s");
        }
        words[7..].iter().try_for_each(|word| word.number().map(drop))?;
        self.row(words[0], [words[1], words[2], words[3]], [words[4], words[5], words[6]])
    }

    /// Reads a row: its date, position \[km\] and velocity \[km/s\].
    fn row(
        &mut self,
        moment: Piece<'_>,
        position: [Piece<'_>; 3],
        velocity: [Piece<'_>; 3],
    ) -> Result<(), Wrong> {
        let (at, first) = (moment, position[0]);
        let moment = date(at, self.scale)?;
        if self.segment.moment.last().is_some_and(|before| moment.since(before) <= 0.0) {
            return at
                .wrong("this row is not after the one above", "give times in strictly increasing order");
        }
        let in_metres = |words: [Piece<'_>; 3]| {
            let [x, y, z] = words.map(|word| word.number());
            Ok(Vector3::new(x?.value, y?.value, z?.value) * 1e3)
        };
        let (position, velocity) = (in_metres(position)?, in_metres(velocity)?);
        if position.norm() < LEAST {
            let reason = "this position is inside the Earth";
            return first.wrong(reason, "give positions relative to the centre of the Earth in km");
        }
        self.segment.moment.push(moment);
        self.segment.position.push(position);
        self.segment.velocity.push(velocity);
        self.segment.line.push(at.at);
        Ok(())
    }

    /// Returns the segment with its interpolation method. `end` is the position at which its rows
    /// end, for messages.
    fn finish(self, end: Piece<'_>) -> Result<Segment, Wrong> {
        let Self { mut segment, hermite, degree, .. } = self;
        let count = segment.moment.len();
        let (most, of) = if hermite {
            ((2 * count).saturating_sub(1), Between::Hermite as fn(usize) -> Between)
        } else {
            (count.saturating_sub(1), Between::Lagrange as fn(usize) -> Between)
        };
        let wanted = degree.unwrap_or(DEGREE.min(most)).max(LOWEST);
        segment.between = of(wanted);
        if count < segment.between.rows() {
            let reason = format!(
                "a segment of {count} rows: a polynomial of degree {wanted} needs {}",
                segment.between.rows()
            );
            return end.wrong(reason, "give more rows, or a lower INTERPOLATION_DEGREE");
        }
        // The span in which positions may be used must not extend beyond the rows.
        let [first, last] = [segment.moment[0], segment.moment[count - 1]];
        if first.since(&segment.span[0]) > 0.0 {
            segment.span[0] = first;
        }
        if last.since(&segment.span[1]) < 0.0 {
            segment.span[1] = last;
        }
        Ok(segment)
    }
}

/// Smallest distance of a position from the centre of the Earth \[m\]: the polar radius of the
/// Earth.
const LEAST: f64 = 6_356_752.0;

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-11-21T00:00:00\nORIGINATOR = TEST\n";
    const META: &str = "META_START\nOBJECT_NAME = A\nOBJECT_ID = 2026-001A\nCENTER_NAME = EARTH\nREF_FRAME = EME2000\n\
        TIME_SYSTEM = UTC\nSTART_TIME = 2026-11-21T07:00:00\nSTOP_TIME = 2026-11-21T07:03:00\nMETA_STOP\n";
    const ROWS: &str = "2026-11-21T07:00:00 7000 0 0 0 7.5 0\n2026-11-21T07:01:00 6990 450 0 0 7.5 0\n\
        2026-11-21T07:02:00 6960 899 0 0 7.5 0 0 0 0\n2026-11-21T07:03:00 6910 1345 0 0 7.5 0\n";

    fn reason(text: &str) -> String {
        read_ephemeris(text.as_bytes(), "orbit.oem").unwrap_err().0[0].reason.clone()
    }

    #[test]
    fn segments_stay_apart_and_covariances_are_passed_over() {
        let covariance = "COVARIANCE_START\nEPOCH = 2026-11-21T07:00:00\n1.0\nCOVARIANCE_STOP\n";
        let text = format!("{HEAD}{META}COMMENT rows\n{ROWS}{covariance}{META}{ROWS}");
        let found = read_ephemeris(text.as_bytes(), "orbit.oem").unwrap();
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].moment.len(), found[0].between), (4, Between::Hermite(7)));
        assert_eq!((found[0].line[2], found[0].velocity[2]), (16, Vector3::new(0.0, 7.5e3, 0.0)));
        assert_eq!(found[1].position[1], Vector3::new(6.99e6, 4.5e5, 0.0));
        assert_eq!(found[0].span[1].since(&found[0].span[0]), 180.0);
        // The frame bias between EME2000 and ICRF is 23 milliarcseconds.
        let EphemerisAxes::Inertial(bias) = found[0].axes else { panic!("inertial") };
        let angle = slewkit::lie::log(&bias).norm().to_degrees() * 3.6e6;
        assert!((angle - 23.1).abs() < 0.1, "{angle}");
    }

    #[test]
    fn segments_of_two_objects_are_refused() {
        for (from, to) in [("NAME = A", "NAME = B"), ("ID = 2026-001A", "ID = 2026-002A")] {
            let text = format!("{HEAD}{META}{ROWS}{}{ROWS}", META.replace(from, to));
            let said = reason(&text);
            assert!(said.starts_with("this segment is of "), "{said}");
        }
        let text = format!("{HEAD}{META}{ROWS}{}{ROWS}", META.replace("NAME = A", "NAME = a"));
        assert_eq!(read_ephemeris(text.as_bytes(), "orbit.oem").unwrap().len(), 2);
    }

    #[test]
    fn a_useable_span_and_a_degree_are_taken() {
        let more = "USEABLE_START_TIME = 2026-11-21T07:00:10\nINTERPOLATION_DEGREE = 3\nMETA_STOP";
        let found =
            read_ephemeris(format!("{HEAD}{}{ROWS}", META.replace("META_STOP", more)).as_bytes(), "a")
                .unwrap();
        assert_eq!(found[0].between, Between::Lagrange(3));
        assert_eq!(found[0].span[0].since(&found[0].moment[0]), 10.0);
        let more = "INTERPOLATION = HERMITE\nINTERPOLATION_DEGREE = 9\nMETA_STOP";
        assert!(
            reason(&format!("{HEAD}{}{ROWS}", META.replace("META_STOP", more))).contains("degree 9 needs 5")
        );
        let more = more.replace('9', "7");
        let found =
            read_ephemeris(format!("{HEAD}{}{ROWS}", META.replace("META_STOP", &more)).as_bytes(), "a");
        assert_eq!(found.unwrap()[0].between, Between::Hermite(7));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let with = |from: &str, to: &str| reason(&format!("{HEAD}{META}{ROWS}").replace(from, to));
        for (from, to, told) in [
            ("EARTH", "MARS BARYCENTER", "not the Earth"),
            ("EME2000", "GTOD", "GTOD are not supported"),
            ("EME2000", "TEME\nREF_FRAME_EPOCH = 2026-11-21T00:00:00", "frozen"),
            ("= UTC", "= UT1", "UT1 is not supported"),
            ("OEM_VERS = 2.0", "OEM_VERS = 9.0", "version 9.0"),
            ("CCSDS_OEM", "CCSDS_AEM", "the file is not an OEM"),
            ("07:01:00 6990", "06:01:00 6990", "not after the one above"),
            ("6990 450 0", "6990 450", "a row has 6 words"),
            ("6990", "nan", "not finite"),
            ("7000 0 0", "7 0 0", "inside the Earth"),
            ("META_STOP\n", "", "is not of the form KEY = value"),
            ("META_STOP\n", "INTERPOLATION = LINEAR\nMETA_STOP\n", "interpolation LINEAR"),
            ("META_STOP\n", "INTERPOLATION_DEGREE = 3.5\nMETA_STOP\n", "degree 3.5"),
            ("META_STOP\n", "INTERPOLATION_DEGREE = 4\nMETA_STOP\n", "degree 4 needs 5"),
            ("REF_FRAME = EME2000\n", "", "no `REF_FRAME`"),
            ("STOP_TIME = 2026", "STOP_TIME = 2025", "ends before it begins"),
        ] {
            let said = with(from, to);
            assert!(said.contains(told), "{to}: {said}");
        }
        assert!(reason(HEAD).contains("no segment"));
    }
}
