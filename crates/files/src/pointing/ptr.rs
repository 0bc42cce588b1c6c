//! ESA's pointing timeline requests (PTR, `.ptx`) in resolved form: observations with inertial
//! targets, and slews between them.
//!
//! ```text
//! prm := body/segment/data/timeline[@frame="SC"]/block+
//! block := @ref="OBS" startTime endTime attitude [metadata]  |  @ref="SLEW" (empty)
//! attitude[@ref="inertial"] := boresight phaseAngle target
//! boresight := @ref NAME  or  @frame="SC" x y z
//! target := @frame="EME2000" (lon lat with @units="deg"|"rad"  or  x y z)
//! phaseAngle[@ref="align"] := SCAxis[@frame="SC"] x y z, inertialAxis[@frame="EME2000"] x y z
//! ```
//!
//! Times are in UTC, with whole seconds or three decimals, because OSVE 2.9.0 rejects all other
//! notations. OSVE also rejects a slew before the first or after the last observation, two
//! consecutive slews, and observations without a gap between them. It accepts `nan` as a number,
//! which this reader rejects.

use super::tree::{Part, angle};
use super::{LEAST_APART, Observation, PointingFile, Roll, Target, check_order, unit};
use crate::epoch::{Epoch, EpochError, Scale};
use crate::exchange::{Lacking, Piece, Wrong, Xml};
use crate::export::ExportError;
use crate::spec::cut;
use roxmltree::Node;
use slewkit::{Vector3, lie};
use std::io::Write;

/// Name of the inertial frame in which targets are given.
const INERTIAL: &str = "EME2000";
/// Name of the body frame of the spacecraft.
const BODY: &str = "SC";

/// Names of the boresights that every mission has, which are the body axes.
const AXES: [&str; 3] = ["SC_Xaxis", "SC_Yaxis", "SC_Zaxis"];

/// Reads a PTR from its root element.
pub(super) fn read<'t>(root: Node<'t, 't>) -> Result<PointingFile, Wrong> {
    let body = Part(root).only(&[])?.inner("body")?.only(&[])?;
    let data = body.inner("segment")?.only(&[])?.inner("data")?.only(&[])?;
    let timeline = data.inner("timeline")?.only(&["frame"])?.is("frame", BODY)?;
    let mut found =
        PointingFile { reference_frame: INERTIAL.into(), body_frame: BODY.into(), ..PointingFile::default() };
    let mut slew: Option<Part<'t>> = None;
    for block in timeline.all(&["block"])? {
        let kind = block.only(&["ref"])?.said("ref")?;
        match kind.text {
            "OBS" => {
                let begin = observation(block, &mut found)?;
                let (next, before) = match &found.observations[..] {
                    [.., before, next] => (next, before),
                    _ => continue,
                };
                if next.begin.since(&before.end) <= 0.0 {
                    return begin.wrong(
                        "the block begins when the block above ends",
                        "leave time for a slew between them",
                    );
                }
                slew = None;
            }
            "SLEW" => {
                block.empty()?;
                if found.observations.is_empty() || slew.is_some() {
                    return kind
                        .wrong("no observation precedes this slew", "put it between two observations");
                }
                slew = Some(block);
            }
            other => {
                let reason = format!("blocks of the kind {} are not supported", cut(other, 30));
                return kind.wrong(reason, "resolve the timeline to observations (OBS) and slews (SLEW)");
            }
        }
    }
    if let Some(last) = slew {
        return last.name().wrong("no observation follows this slew", "put it between two observations");
    }
    if found.observations.is_empty() {
        return timeline.name().wrong("the timeline has no observation", "give a block of the kind OBS");
    }
    Ok(found)
}

/// Reads an observation and appends it to the file. Returns the text of its start time, for
/// messages.
fn observation<'t>(block: Part<'t>, file: &mut PointingFile) -> Result<Piece<'t>, Wrong> {
    let [start, end, attitude, metadata] = block.parts(["startTime", "endTime", "attitude", "metadata"])?;
    let start = block.needed(start, "startTime")?.only(&[])?.text()?;
    let end = block.needed(end, "endTime")?.only(&[])?.text()?;
    let attitude = block.needed(attitude, "attitude")?.only(&["ref"])?.is("ref", "inertial")?;
    let [boresight, phase, target] = attitude.parts(["boresight", "phaseAngle", "target"])?;
    let axis = attitude.needed(boresight, "boresight")?;
    let boresight = boresight_of(axis)?;
    let aim = attitude.needed(target, "target")?;
    let target = target_of(aim)?;
    let phase = attitude.needed(phase, "phaseAngle")?.only(&["ref"])?.is("ref", "align")?;
    let [body, inertial] = phase.parts(["SCAxis", "inertialAxis"])?;
    let (body, inertial) = (phase.needed(body, "SCAxis")?, phase.needed(inertial, "inertialAxis")?);
    let body_axis = cartesian(body.only(&["frame"])?.is("frame", BODY)?)?;
    let inertial_axis = cartesian(inertial.only(&["frame"])?.is("frame", INERTIAL)?)?;
    for (axis, other, part, beside) in
        [(body_axis, boresight, body, "boresight"), (inertial_axis, target, inertial, "target")]
    {
        if axis.cross(&other).norm() <= LEAST_APART {
            let reason = format!("<{}> is parallel to the {beside}: it defines no roll", part.name().text);
            return part.name().wrong(reason, "give another axis");
        }
    }
    let next = Observation {
        name: metadata.map(|metadata| comment(metadata, file)).transpose()?.flatten(),
        begin: moment(start)?,
        end: moment(end)?,
        boresight,
        target: Target::Inertial(target),
        roll: Roll::Referred { body_axis, inertial_axis, angle: 0.0 },
    };
    check_order(file.observations.last(), &next, start)?;
    file.observations.push(next);
    Ok(start)
}

/// Note to the user that most of the metadata are ignored.
const METADATA: &str = "<metadata> names an observation by its first <comment>; the rest is left out";

/// Returns the first comment of the metadata, which is the name of the observation.
fn comment(metadata: Part<'_>, file: &mut PointingFile) -> Result<Option<String>, Wrong> {
    let mut parts = metadata.0.children().filter(Node::is_element).map(Part);
    let comment = parts.find(|part| part.name().text == "comment");
    if metadata.0.children().filter(Node::is_element).count() > usize::from(comment.is_some())
        && file.not_taken.is_empty()
    {
        file.not_taken.push(METADATA.into());
    }
    comment.map(|comment| comment.text().map(|text| text.text.to_string())).transpose()
}

/// Reads a boresight, as a unit vector in body axes.
fn boresight_of(part: Part<'_>) -> Result<Vector3, Wrong> {
    let Some(name) = part.attribute("ref") else {
        return cartesian(part.only(&["frame"])?.is("frame", BODY)?);
    };
    part.only(&["ref"])?.empty()?;
    let Some(axis) = AXES.iter().position(|axis| *axis == name.text) else {
        let reason = format!("the boresight {} is defined nowhere in the file", cut(name.text, 40));
        let remedy = format!("give {}, or <boresight frame=\"SC\"> with x, y and z", AXES.join(", "));
        return name.wrong(reason, remedy);
    };
    Ok(Vector3::ith(axis, 1.0))
}

/// Reads a target, as a unit vector in inertial axes.
fn target_of(part: Part<'_>) -> Result<Vector3, Wrong> {
    part.only(&["frame"])?.is("frame", INERTIAL)?;
    let spherical = part.0.children().any(|child| child.has_tag_name("lon") || child.has_tag_name("lat"));
    if !spherical {
        return cartesian(part);
    }
    let [lon, lat] = part.parts(["lon", "lat"])?;
    let angle_of = |found: Option<Part<'_>>, name: &str, most: f64| {
        let found = part.needed(found, name)?.only(&["units"])?;
        angle(found.text()?, found.said("units")?, most)
    };
    part.spherical(angle_of(lon, "lon", 360.0)?, angle_of(lat, "lat", 90.0)?)
}

/// Reads the components x, y and z of a vector, and returns the unit vector along it.
fn cartesian(part: Part<'_>) -> Result<Vector3, Wrong> {
    let names = ["x", "y", "z"];
    let mut components = [0.0; 3];
    for ((found, name), component) in part.parts(names)?.into_iter().zip(names).zip(&mut components) {
        *component = part.needed(found, name)?.only(&[])?.text()?.number()?.value;
    }
    part.direction(components)
}

/// Parses a time in UTC.
fn moment(text: Piece<'_>) -> Result<Epoch, Wrong> {
    let (form, remedy) =
        ("times are UTC as 2032-12-26T10:15:31 or 2032-12-26T10:15:31.250", "write it in that form");
    let is = |pattern: &str| {
        let mut signs = pattern.bytes();
        let fits = |byte: u8| match signs.next() {
            Some(b'0') => byte.is_ascii_digit(),
            sign => sign == Some(byte),
        };
        text.text.len() == pattern.len() && text.text.bytes().all(fits)
    };
    if !is("0000-00-00T00:00:00") && !is("0000-00-00T00:00:00.000") {
        return text.wrong(format!("{} is not a time of a PTR: {form}", cut(text.text, 40)), remedy);
    }
    Epoch::in_scale(text.text, Scale::Utc).or_else(|error: EpochError| text.wrong(error.to_string(), remedy))
}

impl PointingFile {
    /// Writes a resolved PTR: observations with their attitudes, and a slew between any two of
    /// them. Times are written in milliseconds. The start of an observation is rounded up and its
    /// end down, so that the observation lies within the hold of the plan.
    ///
    /// # Errors
    /// Returns [`Lacking::Roll`] if an observation has a free roll or points at the Sun;
    /// [`Observation::in_attitude`] removes both causes. Returns [`Lacking::PointingFrame`] if the
    /// reference frame is not inertial, and [`Lacking::Observations`] if an observation cannot be
    /// written or leaves no time for a slew. Also returns the errors of the stream.
    pub fn write_ptr(&self, output: &mut dyn Write) -> Result<(), ExportError> {
        self.check()?;
        let file = self.in_frame(INERTIAL).ok_or(Lacking::PointingFrame)?;
        let mut xml = Xml { output };
        xml.line(0, "<prm>\n  <body>\n    <segment>\n      <data>\n        <timeline frame=\"SC\">")?;
        let mut before: Option<&Epoch> = None;
        for observation in &file.observations {
            let (Target::Inertial(target), Roll::Referred { body_axis, inertial_axis, angle }) =
                (observation.target, observation.roll)
            else {
                return Err(Lacking::Roll.into());
            };
            let touches = before.is_some_and(|end| observation.begin.since(end) <= 0.0);
            if touches || observation.lasting() < SHORTEST {
                return Err(Lacking::Observations.into());
            }
            if before.replace(&observation.end).is_some() {
                xml.line(5, "<block ref=\"SLEW\"/>")?;
            }
            let inertial_axis =
                if angle == 0.0 { inertial_axis } else { lie::exp(&(angle * target)) * inertial_axis };
            let inertial_axis = unit(inertial_axis).unwrap_or(inertial_axis);
            xml.line(5, "<block ref=\"OBS\">")?;
            xml.element(6, "startTime", &milliseconds(&observation.begin, f64::ceil))?;
            xml.element(6, "endTime", &milliseconds(&observation.end, f64::floor))?;
            xml.line(6, "<attitude ref=\"inertial\">")?;
            vector(&mut xml, 7, "boresight frame=\"SC\"", &observation.boresight)?;
            xml.line(7, "<phaseAngle ref=\"align\">")?;
            vector(&mut xml, 8, "SCAxis frame=\"SC\"", &body_axis)?;
            vector(&mut xml, 8, "inertialAxis frame=\"EME2000\"", &inertial_axis)?;
            xml.line(7, "</phaseAngle>")?;
            vector(&mut xml, 7, "target frame=\"EME2000\"", &target)?;
            xml.line(6, "</attitude>")?;
            if let Some(name) = &observation.name {
                xml.line(6, "<metadata>")?;
                xml.element(7, "comment", name)?;
                xml.line(6, "</metadata>")?;
            }
            xml.line(5, "</block>")?;
        }
        xml.line(0, "        </timeline>\n      </data>\n    </segment>\n  </body>\n</prm>")?;
        Ok(xml.output.flush()?)
    }
}

/// Writes a vector with enough digits to read back to the same bits.
fn vector(xml: &mut Xml<'_>, depth: usize, opening: &str, vector: &Vector3) -> Result<(), ExportError> {
    let name = opening.split(' ').next().unwrap_or(opening);
    let [x, y, z] = [vector.x, vector.y, vector.z];
    Ok(xml.line(depth, &format!("<{opening}><x>{x}</x><y>{y}</y><z>{z}</z></{name}>"))?)
}

/// Shortest duration of an observation that is written \[s\]. Rounding shortens an observation by
/// less than a millisecond at either end.
const SHORTEST: f64 = 3e-3;

/// Largest deviation from a whole number of milliseconds that counts as round-off \[ms\]. It is one
/// nanosecond, the rounding error of sums of seconds over days.
const WHOLE: f64 = 1e-6;

/// Returns a time in UTC with three decimals; `round` rounds the time in milliseconds.
fn milliseconds(moment: &Epoch, round: impl Fn(f64) -> f64) -> String {
    let utc = moment.in_other_scale(Scale::Utc);
    let past = utc.fraction() * 1e3;
    let whole = if (past - past.round()).abs() < WHOLE { past.round() } else { round(past) };
    utc.after((whole - past) * 1e-3).calendar_text()
}
