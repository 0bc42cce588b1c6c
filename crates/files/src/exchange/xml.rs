//! AEM 2.0 in XML (CCSDS 505.0-B, schema ndmxml 3.0), with the conventions of the keyword notation.

use super::{Record, digits};
use crate::export::ExportError;
use std::io::{self, Write};
use std::ops::RangeInclusive;

/// Writer of indented XML elements.
pub(crate) struct Xml<'o> {
    /// Stream to which the elements are written.
    pub output: &'o mut dyn Write,
}

impl Xml<'_> {
    /// Writes a line, indented for `depth` levels of enclosing elements.
    pub(crate) fn line(&mut self, depth: usize, text: &str) -> io::Result<()> {
        writeln!(self.output, "{:width$}{text}", "", width = 2 * depth)
    }

    /// Writes the element `name` with a text, indented for `depth` levels of enclosing elements.
    pub(crate) fn element(&mut self, depth: usize, name: &str, text: &str) -> io::Result<()> {
        self.line(depth, &format!("<{name}>{}</{name}>", escaped(text)))
    }
}

/// Escapes a text for an XML element or attribute.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Opening tag of the document, with its schema.
const OPENING: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
    <aem xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
    xsi:noNamespaceSchemaLocation=\"https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-3.0.0-master-3.0.xsd\" \
    id=\"CCSDS_AEM_VERS\" version=\"2.0\">";

/// Writes an attitude ephemeris message. Each smooth piece of the motion is a segment.
pub(super) fn write_aem(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    let mut xml = Xml { output };
    xml.line(0, OPENING)?;
    xml.line(1, "<header>")?;
    xml.element(2, "COMMENT", &record.name())?;
    for note in &record.notes {
        xml.element(2, "COMMENT", note)?;
    }
    xml.element(2, "CREATION_DATE", &record.created.calendar_text())?;
    xml.element(2, "ORIGINATOR", record.identity.originator.as_deref().unwrap_or("UNKNOWN"))?;
    xml.line(1, "</header>")?;
    xml.line(1, "<body>")?;
    record.pieces().try_for_each(|nodes| write_segment(record, nodes, &mut xml))?;
    xml.line(1, "</body>\n</aem>")?;
    Ok(())
}

/// Writes one segment of the message.
fn write_segment(
    record: &Record<'_>,
    nodes: RangeInclusive<usize>,
    xml: &mut Xml<'_>,
) -> Result<(), ExportError> {
    let (epoch, time, identity) = (record.epoch()?, &record.trajectory.time, &record.identity);
    let date = |k: usize| epoch.after(time[k]).calendar_text();
    let body_frame = identity.body_frame();
    xml.line(2, "<segment>\n      <metadata>")?;
    xml.element(4, "OBJECT_NAME", &record.object())?;
    xml.element(4, "OBJECT_ID", identity.object_id.as_deref().unwrap_or("UNKNOWN"))?;
    if let Some(center) = &identity.center {
        xml.element(4, "CENTER_NAME", center)?;
    }
    let (start, stop) = (date(*nodes.start()), date(*nodes.end()));
    for (name, text) in [
        ("REF_FRAME_A", identity.reference_frame()),
        ("REF_FRAME_B", body_frame),
        ("TIME_SYSTEM", epoch.scale().name()),
        ("START_TIME", &start),
        ("STOP_TIME", &stop),
        ("ATTITUDE_TYPE", "QUATERNION/ANGVEL"),
        ("ANGVEL_FRAME", body_frame),
        ("INTERPOLATION_METHOD", "HERMITE"),
        ("INTERPOLATION_DEGREE", "3"),
    ] {
        xml.element(4, name, text)?;
    }
    xml.line(3, "</metadata>\n      <data>")?;
    for k in nodes {
        let [w, x, y, z] = record.named_quaternion(k);
        let rate = record.rate(k).map(f64::to_degrees);
        xml.line(4, "<attitudeState>")?;
        xml.line(5, "<quaternionAngVel>")?;
        xml.element(6, "EPOCH", &date(k))?;
        xml.line(6, "<quaternion>")?;
        for (name, part) in [("Q1", x), ("Q2", y), ("Q3", z), ("QC", w)] {
            xml.element(7, name, &digits(part))?;
        }
        xml.line(6, "</quaternion>")?;
        xml.line(6, "<angVel>")?;
        for (axis, part) in ["X", "Y", "Z"].iter().zip(rate.iter()) {
            let name = format!("ANGVEL_{axis}");
            xml.line(7, &format!("<{name} units=\"deg/s\">{}</{name}>", digits(*part)))?;
        }
        xml.line(6, "</angVel>")?;
        xml.line(5, "</quaternionAngVel>")?;
        xml.line(4, "</attitudeState>")?;
    }
    xml.line(3, "</data>\n    </segment>")?;
    Ok(())
}
