//! Pointing request messages of CCSDS (PRM, 509.0-B-1 with corrigendum 1) in XML: the templates of
//! inertial pointing (4.2) and Sun pointing (4.3).
//!
//! The metadata of a segment define the form of its blocks; the data of the segment contain the
//! times and numbers of the blocks. The definition in the metadata states the axes between which
//! the phase angle is measured; if it does not, the roll is free. Blocks with other axes need
//! another segment.
//!
//! # Where is the standard ambiguous?
//!
//! - Metadata end with `STOP_TIME` (3.2.1.19) or with `END_TIME` (figure 3-1): both are read.
//! - The second of the `spherical` coordinates is the polar angle in table 3-10, but a declination
//!   in the example of table 4-2. It is read as an elevation, with a remark to the user. Vectors
//!   are written instead.
//! - Template 4-3 defines the frame of the spacecraft twice, once without a base: both forms are
//!   read.
//! - Annex F does not define an offset angle, and a plan stops at rest: offsets and rates must be
//!   zero.

use super::tree::{Part, angle};
use super::{LEAST_APART, Observation, PointingFile, Roll, Target, check_order};
use crate::epoch::{Epoch, Scale};
use crate::exchange::frames::{Meaning, meaning};
use crate::exchange::{Piece, Wrong, Xml, escaped};
use crate::export::ExportError;
use crate::spec::cut;
use roxmltree::Node;
use slewkit::Vector3;
use std::io::Write;

/// Name of a block with inertial pointing (template 4.2).
const INERTIAL: &str = "inertial";
/// Name of a block with Sun pointing (template 4.3).
const SUN: &str = "sunPointing";

/// Identifier of the message type in the attribute `id`.
const ID: &str = "CCSDS_PRM_VERS";
/// Version of the message type.
const VERSION: &str = "1.0";

/// Frames that a definition declares: the inertial base frame and the frame of the spacecraft.
#[derive(Clone, Copy, Debug)]
struct Frames<'t> {
    base: Piece<'t>,
    body: Piece<'t>,
}

/// Form of the blocks of a segment, as its metadata define it.
#[derive(Clone, Copy, Debug)]
struct Template<'t> {
    name: &'t str,
    /// Body axis and inertial axis between which the phase angle is measured; `None` if the roll is
    /// free.
    phase: Option<[Vector3; 2]>,
    /// True if blocks may have an offset angle.
    offset: bool,
    /// True if blocks may have an angular rate.
    rate: bool,
    /// Name of the orbit file that determines the direction to the Sun; `None` for inertial
    /// targets.
    orbit: Option<Piece<'t>>,
}

/// Reads a PRM from its root element.
pub(super) fn read<'t>(root: Node<'t, 't>) -> Result<PointingFile, Wrong> {
    let root = Part(root).only(&["id", "version"])?.is("id", ID)?.is("version", VERSION)?;
    let [header, body] = root.parts(["header", "body"])?;
    if let Some(header) = header {
        header.only(&[])?.all(&["COMMENT", "CREATION_DATE", "ORIGINATOR", "MESSAGE_ID"])?;
    }
    let body = root.needed(body, "body")?.only(&[])?;
    let mut file = PointingFile::default();
    for part in body.all(&["segment"])? {
        segment(part.only(&[])?, &mut file)?;
    }
    if file.observations.is_empty() {
        return body.name().wrong("the message has no block", "give a <block> in a <timeline>");
    }
    Ok(file)
}

/// Reads a segment and appends its observations to the file.
fn segment<'t>(part: Part<'t>, file: &mut PointingFile) -> Result<(), Wrong> {
    let [metadata, data] = part.parts(["metadata", "data"])?;
    let metadata = part.needed(metadata, "metadata")?.only(&[])?;
    let mut said: [Option<Part<'t>>; 6] = [None; 6];
    let names = ["OBJECT_NAME", "OBJECT_ID", "TIME_SYSTEM", "START_TIME", "STOP_TIME", "END_TIME"];
    let mut definitions = Vec::new();
    for inner in metadata.all(&[&names[..], &["COMMENT", "definition"]].concat())? {
        let name = inner.name();
        if name.text == "definition" {
            definitions.push(inner);
        }
        let Some(at) = names.iter().position(|known| *known == name.text) else { continue };
        if said[at].replace(inner.only(&[])?).is_some() {
            let reason = format!("<{}> occurs twice in the metadata", name.text);
            return name.wrong(reason, "give it once");
        }
    }
    let Some(data) = data.filter(|data| data.0.first_element_child().is_some()) else { return Ok(()) };
    let text = |at: usize| metadata.needed(said[at], names[at])?.text();
    one(&mut file.object, text(0)?, "the spacecraft")?;
    one(&mut file.object_id, text(1)?, "the spacecraft")?;
    let system = text(2)?;
    let Some(scale) = Scale::named(system.text) else {
        let reason = format!("the time system {} is not supported", cut(system.text, 20));
        return system.wrong(reason, "give times in UTC, TAI, TT, TDB or GPS");
    };
    if let (Some(stop), Some(_)) = (said[4], said[5]) {
        return stop.name().wrong("the metadata have both STOP_TIME and END_TIME", "give only STOP_TIME");
    }
    let stop = if said[5].is_some() { 5 } else { 4 };
    let (first, last) = (moment(text(3)?, scale)?, moment(text(stop)?, scale)?);

    let mut templates = Vec::new();
    let mut frames: Option<Frames<'t>> = None;
    for part in definitions {
        definition(part, &mut frames, &mut templates)?;
    }
    let Some(frames) = frames else {
        return metadata.name().wrong("the segment defines no frames", "add a <definition> with its frames");
    };
    one_frame(&mut file.reference_frame, frames.base)?;
    one_frame(&mut file.body_frame, frames.body)?;
    let timeline = data.only(&[])?.inner("timeline")?.only(&["frame"])?.is("frame", frames.body.text)?;
    for block in timeline.all(&["block"])? {
        let kind = block.only(&["ref", "name"])?.said("ref")?;
        let Some(template) = templates.iter().find(|template: &&Template<'_>| template.name == kind.text)
        else {
            let reason = format!("the block {} has no definition in its segment", cut(kind.text, 40));
            return kind.wrong(reason, format!("supported blocks are {INERTIAL} and {SUN}"));
        };
        let (next, at) = observation(block, template, frames, scale, file)?;
        if next.begin.since(&first) < 0.0 || next.end.since(&last) > 0.0 {
            let reason = "the block is not within START_TIME and STOP_TIME of its segment";
            return at.wrong(reason, "correct the metadata or the block");
        }
        check_order(file.observations.last(), &next, at)?;
        file.observations.push(next);
        if let Some(orbit) = template.orbit {
            file.orbit.get_or_insert_with(|| orbit.text.into());
        }
    }
    Ok(())
}

/// Stores a text on which all segments must agree; `of` describes it in messages.
fn one(kept: &mut Option<String>, said: Piece<'_>, of: &str) -> Result<(), Wrong> {
    match kept {
        Some(kept) if kept != said.text => {
            said.wrong(format!("{of} differs from the segment above"), "write a separate message for each")
        }
        _ => {
            *kept = Some(said.text.into());
            Ok(())
        }
    }
}

/// Stores the name of a frame on which all segments must agree.
fn one_frame(kept: &mut String, said: Piece<'_>) -> Result<(), Wrong> {
    let mut named = Some(std::mem::take(kept)).filter(|name| !name.is_empty());
    one(&mut named, said, "the frame")?;
    *kept = named.unwrap_or_default();
    Ok(())
}

/// Reads the definition in the metadata of a segment.
fn definition<'t>(
    part: Part<'t>,
    frames: &mut Option<Frames<'t>>,
    templates: &mut Vec<Template<'t>>,
) -> Result<(), Wrong> {
    let inner = part.only(&["name", "version"])?.all(&["frame", "block"])?;
    let (mut base, mut body): (Option<Piece<'t>>, Option<Piece<'t>>) = (None, None);
    let mut again = None;
    for frame in inner.iter().filter(|inner| inner.name().text == "frame") {
        frame.only(&["name", "baseFrame"])?.empty()?;
        let (name, of) = (frame.said("name")?, frame.said("baseFrame")?);
        match (of.text, base, body) {
            ("none", None, _) => base = Some(name),
            // Template 4-3 repeats the frame of the spacecraft.
            ("none", Some(_), _) if again.is_none() => again = Some(name),
            (of, Some(base), None) if of == base.text => body = Some(name),
            _ => {
                let frame = cut(name.text, 30);
                let reason = format!("unexpected frame {frame}: only two frames are supported");
                let remedy = "define one inertial frame, and the spacecraft frame with it as baseFrame";
                return name.wrong(reason, remedy);
            }
        }
    }
    let (Some(base), Some(body)) = (base, body) else {
        return part.name().wrong(
            "the definition lacks a frame",
            "define the inertial frame with baseFrame=\"none\", and the spacecraft frame on it",
        );
    };
    if let Some(again) = again.filter(|again| again.text != body.text) {
        return again.wrong(
            "two frames have baseFrame=\"none\"",
            "give baseFrame=\"none\" only for the inertial frame",
        );
    }
    if !matches!(meaning(base.text), Meaning::Inertial(_)) {
        let reason = format!("the frame {} is not known to be inertial", cut(base.text, 30));
        return base.wrong(reason, "give EME2000, GCRF or ICRF");
    }
    let own = Frames { base, body };
    let before = frames.get_or_insert(own);
    if (before.base.text, before.body.text) != (base.text, body.text) {
        return base
            .wrong("the pair of frames differs from the definition above", "define one pair of frames");
    }
    for block in inner.iter().filter(|inner| inner.name().text == "block") {
        let found = template(*block, own)?;
        if templates.iter().any(|known| known.name == found.name) {
            let reason = format!("the block {} is defined twice", found.name);
            return block.said("name")?.wrong(reason, "define it once");
        }
        templates.push(found);
    }
    Ok(())
}

/// Reads the definition of the form of a block.
fn template<'t>(block: Part<'t>, frames: Frames<'t>) -> Result<Template<'t>, Wrong> {
    let name = block.only(&["name"])?.said("name")?;
    if ![INERTIAL, SUN].contains(&name.text) {
        let reason = format!("the block {} is not supported", cut(name.text, 50));
        return name.wrong(
            reason,
            format!("supported blocks are {INERTIAL} (template 4.2) and {SUN} (template 4.3)"),
        );
    }
    let [start, end, attitude] = block.parts(["startEpoch", "endEpoch", "attitude"])?;
    local(block.needed(start, "startEpoch")?, "blockStart")?;
    local(block.needed(end, "endEpoch")?, "blockEnd")?;
    let attitude = block.needed(attitude, "attitude")?.only(&[])?;
    let [axis, target, phase, offset, rate] =
        attitude.parts(["frameDir", "baseFrameDir", "phaseAngle", "offsetAngle", "angularRate"])?;
    local(attitude.needed(axis, "frameDir")?, "boresight")?;
    let target = attitude.needed(target, "baseFrameDir")?;
    let orbit = if name.text == SUN {
        Some(sun(target)?)
    } else {
        local(target, "target")?;
        None
    };
    let axes = |part: Part<'t>, angle: &str| -> Result<[Vector3; 2], Wrong> {
        let [body, inertial, projected] = part.only(&[])?.parts(["frameDir", "baseFrameDir", "projAngle"])?;
        local(part.needed(projected, "projAngle")?, angle)?;
        let mut open = Vec::new();
        Ok([
            direction(part.needed(body, "frameDir")?, frames.body, &mut open)?,
            direction(part.needed(inertial, "baseFrameDir")?, frames.base, &mut open)?,
        ])
    };
    let phase = phase.map(|phase| axes(phase, "phaseAngle")).transpose()?;
    let offset = offset.map(|offset| axes(offset, "offsetAngle")).transpose()?.is_some();
    if let Some(rate) = rate {
        local(rate, "angularRate")?;
    }
    Ok(Template { name: name.text, phase, offset, rate: rate.is_some(), orbit })
}

/// Checks that an element declares the block parameter `name` and gives no value for it.
fn local(part: Part<'_>, name: &str) -> Result<(), Wrong> {
    part.only(&["localName"])?.is("localName", name)?.empty()
}

/// Reads the definition of the direction to the Sun. Returns the name of the orbit file from which
/// the direction is computed.
fn sun(part: Part<'_>) -> Result<Piece<'_>, Wrong> {
    let [origin, target] = part.only(&[])?.parts(["origin", "target"])?;
    let orbit = part.needed(origin, "origin")?.only(&[])?.inner("orbitFile")?.only(&[])?.text()?;
    let body = part.needed(target, "target")?.only(&[])?.inner("orbit")?.only(&["name"])?;
    let body = body.inner("ephObject")?.only(&[])?.text()?;
    if !body.is("SUN") {
        let reason = format!("the target {} of {SUN} is not the Sun", cut(body.text, 30));
        return body.wrong(reason, "write SUN");
    }
    Ok(orbit)
}

/// Reads a block as an observation. Also returns the text of its start time, for messages.
fn observation<'t>(
    block: Part<'t>,
    template: &Template<'t>,
    frames: Frames<'t>,
    scale: Scale,
    file: &mut PointingFile,
) -> Result<(Observation, Piece<'t>), Wrong> {
    let names = ["blockStart", "blockEnd", "boresight", "target", "phaseAngle", "offsetAngle", "angularRate"];
    let [start, end, axis, aim, phase, offset, rate] = block.parts(names)?;
    let epoch = |part: Option<Part<'t>>, name| {
        let part = block.needed(part, name)?.only(&["format"])?;
        Ok::<_, Wrong>((moment(part.text()?, scale)?, part.text()?))
    };
    let ((begin, at), (end, _)) = (epoch(start, names[0])?, epoch(end, names[1])?);
    let boresight_part = block.needed(axis, "boresight")?;
    let boresight = direction(boresight_part, frames.body, &mut file.not_taken)?;
    let target = match (template.orbit, aim) {
        (Some(_), None) => Target::Sun,
        (Some(_), Some(aim)) => {
            return aim
                .name()
                .wrong(format!("<target> in a block {SUN}, whose target is the Sun"), "remove it");
        }
        (None, aim) => {
            let aim = block.needed(aim, "target")?;
            Target::Inertial(direction(aim, frames.base, &mut file.not_taken)?)
        }
    };
    for (part, defined, name) in
        [(offset, template.offset, "offsetAngle"), (rate, template.rate, "angularRate")]
    {
        let Some(part) = part else { continue };
        let value = part.only(&["units"])?.text()?;
        if !defined {
            return part.name().wrong(format!("<{name}> is not in the definition of the block"), "define it");
        }
        if value.number()?.value != 0.0 {
            let reason = format!("<{name}> of {} is not supported: it must be zero", cut(value.text, 30));
            return value.wrong(reason, "give the direction of the target itself, and a spacecraft at rest");
        }
    }
    let roll = match (template.phase, phase) {
        (None, None) => Roll::Free,
        (Some(_), None) => {
            let reason = "the block has no <phaseAngle>, but its definition has one";
            return block
                .name()
                .wrong(reason, "add it; or remove it from the definition, which makes the roll free");
        }
        (None, Some(phase)) => {
            return phase.name().wrong("<phaseAngle> is not in the definition of the block", "define it");
        }
        (Some([body_axis, inertial_axis]), Some(phase)) => {
            let angle = angle(phase.only(&["units"])?.text()?, unit(phase), 360.0)?;
            let parallel = |axis: &Vector3, other: &Vector3| axis.cross(other).norm() <= LEAST_APART;
            let target_parallel = match &target {
                Target::Inertial(target) => parallel(&inertial_axis, target),
                Target::Sun => false,
            };
            if parallel(&body_axis, &boresight) || target_parallel {
                let reason = "an axis of the phase angle is parallel to the boresight or the target";
                return phase.name().wrong(reason, "define the phase angle by other axes");
            }
            Roll::Referred { body_axis, inertial_axis, angle }
        }
    };
    let name = block.attribute("name").map(|name| name.text.to_string());
    Ok((Observation { name, begin, end, boresight, target, roll }, at))
}

/// Returns the unit of an angle: the unit that the element states, or the degree if it states none
/// (annex D).
fn unit(part: Part<'_>) -> Piece<'_> {
    part.attribute("units").filter(|unit| !unit.text.is_empty()).unwrap_or(Piece { at: 0, text: "deg" })
}

/// Reads a direction in the frame `frame`, as a unit vector. Assumptions are appended to `open`.
fn direction(part: Part<'_>, frame: Piece<'_>, open: &mut Vec<String>) -> Result<Vector3, Wrong> {
    part.only(&["frame", "coord", "units"])?.is("frame", frame.text)?;
    let text = part.text()?;
    let words = text.words();
    let coord = part.attribute("coord").unwrap_or(Piece { at: 0, text: "cartesian" });
    let (first, second, count) = match coord.text {
        "cartesian" => (None, None, 3),
        "spherical" | "raDec" => (words.first(), words.get(1), 2),
        other => {
            let reason = format!("coordinates of the kind {} are not supported", cut(other, 20));
            return coord.wrong(reason, "give cartesian, spherical or raDec");
        }
    };
    if words.len() != count {
        let reason = format!("{} numbers, where {} has {count}", words.len(), coord.text);
        return text.wrong(reason, "separate the numbers by blanks");
    }
    if let (Some(about), Some(towards)) = (first, second) {
        let note = "spherical coordinates are read as azimuth and elevation (509.0-B-1, table 4-2), not as \
            azimuth and polar angle (table 3-10)";
        if coord.text == "spherical" && !open.iter().any(|known| known == note) {
            open.push(note.into());
        }
        return part.spherical(angle(*about, unit(part), 360.0)?, angle(*towards, unit(part), 90.0)?);
    }
    if let Some(unit) = part.attribute("units").filter(|unit| !["", "-", "none"].contains(&unit.text)) {
        return unit.wrong("cartesian coordinates have no unit", "write units=\"\"");
    }
    let mut components = [0.0; 3];
    for (component, word) in components.iter_mut().zip(words) {
        *component = word.number()?.value;
    }
    part.direction(components)
}

/// Parses a time: a calendar date, or a year and a day of the year, followed by the time of day.
fn moment(text: Piece<'_>, scale: Scale) -> Result<Epoch, Wrong> {
    // In the standard, whole seconds end with a decimal point.
    let said = text.text.strip_suffix('.').unwrap_or(text.text);
    Epoch::in_scale(said, scale)
        .or_else(|error| text.wrong(error.to_string(), "write it as 2032-12-26T10:15:31.000"))
}

/// Returns the properties of an observation that its segment defines: whether the target is the
/// Sun, and the axes of the roll. Consecutive observations with equal properties share a segment.
fn shared(observation: &Observation) -> (bool, Option<[Vector3; 2]>) {
    let sun = observation.target == Target::Sun;
    match observation.roll {
        Roll::Free => (sun, None),
        Roll::Referred { body_axis, inertial_axis, .. } => (sun, Some([body_axis, inertial_axis])),
    }
}

impl PointingFile {
    /// Writes a PRM, with template 4.2 for inertial targets and template 4.3 for the Sun. A free
    /// roll is written without a phase angle. All times are in the time scale of the first
    /// observation.
    ///
    /// # Errors
    /// Returns an error if an observation cannot be written, or if the stream fails.
    pub fn write_prm(
        &self,
        created: &Epoch,
        originator: &str,
        output: &mut dyn Write,
    ) -> Result<(), ExportError> {
        self.check()?;
        if !matches!(meaning(&self.reference_frame), Meaning::Inertial(_)) {
            return Err(crate::exchange::Lacking::PointingFrame.into());
        }
        let mut xml = Xml { output };
        xml.line(0, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
        xml.line(0, &format!("<prm id=\"{ID}\" version=\"{VERSION}\">\n  <header>"))?;
        xml.element(2, "CREATION_DATE", &created.calendar_text())?;
        xml.element(2, "ORIGINATOR", originator)?;
        xml.line(1, "</header>\n  <body>")?;
        for observations in self.observations.chunk_by(|one, next| shared(one) == shared(next)) {
            self.write_segment(observations, &mut xml)?;
        }
        xml.line(1, "</body>\n</prm>")?;
        Ok(xml.output.flush()?)
    }

    /// Writes a segment with observations that share a target type and the axes of the roll.
    fn write_segment(&self, observations: &[Observation], xml: &mut Xml<'_>) -> Result<(), ExportError> {
        let ([first, ..], [.., last]) = (observations, observations) else { return Ok(()) };
        let scale = self.observations[0].begin.scale();
        let date = |moment: &Epoch| moment.in_other_scale(scale).calendar_text();
        let (sun, phase) = shared(first);
        let kind = if sun { SUN } else { INERTIAL };
        let (base, body) = (escaped(&self.reference_frame), escaped(&self.body_frame));
        xml.line(2, "<segment>\n      <metadata>")?;
        let unknown = |name: &Option<String>| name.clone().unwrap_or("UNKNOWN".into());
        for (name, text) in [
            ("OBJECT_NAME", unknown(&self.object)),
            ("OBJECT_ID", unknown(&self.object_id)),
            ("TIME_SYSTEM", scale.name().into()),
            ("START_TIME", date(&first.begin)),
            ("STOP_TIME", date(&last.end)),
        ] {
            xml.element(4, name, &text)?;
        }
        xml.line(4, "<definition name=\"slewkit\" version=\"1.0\">")?;
        xml.line(5, &format!("<frame baseFrame=\"none\" name=\"{base}\"/>"))?;
        xml.line(5, &format!("<frame baseFrame=\"{base}\" name=\"{body}\"/>"))?;
        xml.line(5, &format!("<block name=\"{kind}\">"))?;
        xml.line(
            6,
            "<startEpoch localName=\"blockStart\"/>\n            <endEpoch localName=\"blockEnd\"/>",
        )?;
        xml.line(6, "<attitude>\n              <frameDir localName=\"boresight\"/>")?;
        if sun {
            let orbit = self.orbit.as_deref().unwrap_or("-");
            xml.line(7, "<baseFrameDir>\n                <origin>")?;
            xml.element(9, "orbitFile", orbit)?;
            xml.line(8, "</origin>\n                <target>")?;
            xml.line(9, "<orbit name=\"Sun\"><ephObject>SUN</ephObject></orbit>")?;
            xml.line(8, "</target>\n              </baseFrameDir>")?;
        } else {
            xml.line(7, "<baseFrameDir localName=\"target\"/>")?;
        }
        if let Some([axis, reference]) = phase {
            xml.line(7, "<phaseAngle>")?;
            vector(xml, 8, "frameDir", &body, &axis)?;
            vector(xml, 8, "baseFrameDir", &base, &reference)?;
            xml.line(8, "<projAngle localName=\"phaseAngle\"/>\n              </phaseAngle>")?;
        }
        xml.line(6, "</attitude>\n          </block>\n        </definition>\n      </metadata>")?;
        xml.line(3, &format!("<data>\n        <timeline frame=\"{body}\">"))?;
        for observation in observations {
            let name = observation.name.as_deref().map(|name| format!(" name=\"{}\"", escaped(name)));
            xml.line(5, &format!("<block{} ref=\"{kind}\">", name.unwrap_or_default()))?;
            xml.element(6, "blockStart", &date(&observation.begin))?;
            xml.element(6, "blockEnd", &date(&observation.end))?;
            vector(xml, 6, "boresight", &body, &observation.boresight)?;
            if let Target::Inertial(target) = &observation.target {
                vector(xml, 6, "target", &base, target)?;
            }
            if let Roll::Referred { angle, .. } = observation.roll {
                xml.line(6, &format!("<phaseAngle units=\"rad\">{angle}</phaseAngle>"))?;
            }
            xml.line(5, "</block>")?;
        }
        xml.line(4, "</timeline>\n      </data>\n    </segment>")?;
        Ok(())
    }
}

/// Writes a vector with enough digits to read back to the same bits.
fn vector(xml: &mut Xml<'_>, depth: usize, name: &str, frame: &str, of: &Vector3) -> std::io::Result<()> {
    let [x, y, z] = [of.x, of.y, of.z];
    let opening = format!("<{name} frame=\"{frame}\" coord=\"cartesian\" units=\"\">");
    xml.line(depth, &format!("{opening}{x} {y} {z}</{name}>"))
}
