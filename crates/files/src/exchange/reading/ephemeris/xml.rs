//! OEM in XML (CCSDS 505.0-B): segments of metadata and state vectors.

use super::super::elements::{self, Element, Message, Open};
use super::super::{Piece, Wrong};
use super::{HEADER, Keys, Object, Segment, Started, add, check_version, started};
use crate::spec::cut;

/// Elements of a state vector with their units; the acceleration is ignored.
const STATE: [(&str, &str); 10] = [
    ("EPOCH", ""),
    ("X", "km"),
    ("Y", "km"),
    ("Z", "km"),
    ("X_DOT", "km/s"),
    ("Y_DOT", "km/s"),
    ("Z_DOT", "km/s"),
    ("X_DDOT", "km/s**2"),
    ("Y_DDOT", "km/s**2"),
    ("Z_DDOT", "km/s**2"),
];

/// Number of elements that every state vector must have: its date, position and velocity.
const NEEDED: usize = 7;

/// Segments read so far, and the segment that is being read.
#[derive(Default)]
struct Reading<'t> {
    /// True if an element `<oem>` has been read.
    begun: bool,
    keys: Keys<'t>,
    object: Object<'t>,
    segment: Option<Started>,
    /// Elements of the state vector that is being read, in the order of [`STATE`].
    state: [Option<Piece<'t>>; STATE.len()],
    found: Vec<Segment>,
}

/// Reads an OEM in XML and returns its segments.
pub(super) fn segments(text: &str) -> Result<Vec<Segment>, Wrong> {
    let document = elements::document(text)?;
    let mut reading = Reading::default();
    let last = elements::read(&document, &mut reading)?;
    if reading.found.is_empty() {
        return last.wrong("the file has no segment", "give a <segment>");
    }
    Ok(reading.found)
}

impl<'t> Message<'t> for Reading<'t> {
    const ELEMENT: &'static str = "oem";

    fn version(&mut self, number: Piece<'t>) -> Result<(), Wrong> {
        check_version(number)?;
        self.begun = true;
        Ok(())
    }

    fn opened(&mut self, within: &Open<'t>, name: Piece<'t>, unit: Option<Piece<'t>>) -> Result<(), Wrong> {
        match name.text {
            "metadata" => self.keys = Keys::new(),
            "stateVector" => self.state = Default::default(),
            _ => {}
        }
        if let (true, Some(unit)) = (within.has("stateVector"), unit) {
            let known = STATE.iter().find(|(state, _)| *state == name.text);
            if let Some((_, wanted)) = known.filter(|(_, wanted)| *wanted != unit.text) {
                let reason = format!("the unit {} of <{}> is not supported", cut(unit.text, 20), name.text);
                return unit.wrong(reason, format!("give it in {wanted}"));
            }
        }
        Ok(())
    }

    fn closed(&mut self, within: &Open<'t>, element: &Element<'t>) -> Result<(), Wrong> {
        let Element { name, value } = *element;
        match name.text {
            "metadata" => {
                if !self.begun {
                    return name.wrong("the element <oem> is missing", "give an <oem>");
                }
                self.segment = Some(started(&self.keys, name, &mut self.object)?);
            }
            "stateVector" => self.row(name)?,
            "segment" => {
                let Some(segment) = self.segment.take() else {
                    return name.wrong("a segment has no metadata", "give its <metadata>");
                };
                self.found.push(segment.finish(name)?);
            }
            "COMMENT" => {}
            _ if within.has("metadata") => add(&mut self.keys, name, element.text())?,
            _ if within.has("stateVector") => {
                let Some(at) = STATE.iter().position(|(state, _)| *state == name.text) else {
                    let reason = format!("unknown element <{}> of a state", cut(name.text, 30));
                    return name.wrong(reason, "a state has EPOCH, X, Y, Z, X_DOT, Y_DOT, Z_DOT");
                };
                if self.state[at].is_some() {
                    return name.wrong(format!("the state has <{}> twice", name.text), "give it once");
                }
                self.state[at] = value;
            }
            other if within.has("header") && !HEADER.contains(&other) => {
                let reason = format!("unknown element <{}> in the header of an OEM", cut(other, 40));
                return name.wrong(reason, "check the spelling");
            }
            _ => {}
        }
        Ok(())
    }
}

impl<'t> Reading<'t> {
    /// Adds the state vector that has been read as a row of the segment.
    fn row(&mut self, at: Piece<'t>) -> Result<(), Wrong> {
        if let Some(missing) = self.state[..NEEDED].iter().position(Option::is_none) {
            let reason = format!("the state has no <{}>", STATE[missing].0);
            return at.wrong(reason, "give a date, a position in km and a velocity in km/s");
        }
        self.state[NEEDED..].iter().flatten().try_for_each(|word| word.number().map(drop))?;
        let Some(segment) = &mut self.segment else {
            return at.wrong("the data come before the metadata", "put <metadata> before <data>");
        };
        let [Some(moment), Some(x), Some(y), Some(z), Some(u), Some(v), Some(w), ..] = self.state else {
            return Ok(());
        };
        segment.row(moment, [x, y, z], [u, v, w])
    }
}

#[cfg(test)]
mod tests {
    use super::super::{EphemerisAxes, read_ephemeris};
    use slewkit::Vector3;

    const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- by hand --><ndm><oem \
        id=\"CCSDS_OEM_VERS\" version=\"2.0\">\n\
        <header><CREATION_DATE>2026-11-21T00:00:00</CREATION_DATE><ORIGINATOR>TEST</ORIGINATOR></header>\n\
        <body><segment>\n<metadata>\
        <OBJECT_NAME>A &amp; B</OBJECT_NAME><OBJECT_ID>2026-001A</OBJECT_ID><CENTER_NAME>EARTH</CENTER_NAME>\
        <REF_FRAME>EME2000</REF_FRAME>\
        <TIME_SYSTEM>UTC</TIME_SYSTEM><START_TIME>2026-11-21T07:00:00</START_TIME><STOP_TIME>\
        2026-11-21T07:03:00</STOP_TIME>\
        <INTERPOLATION>LAGRANGE</INTERPOLATION><INTERPOLATION_DEGREE>3</INTERPOLATION_DEGREE></metadata>\n<data>\n";
    const TAIL: &str = "<covarianceMatrix><EPOCH>2026-11-21T07:00:00</EPOCH><CX_X>1</CX_X></covarianceMatrix>\
        </data></segment></body></oem></ndm>\n";

    fn state(minute: usize, position: [f64; 3]) -> String {
        let [x, y, z] = position;
        format!(
            "<stateVector><EPOCH>2026-11-21T07:0{minute}:00</EPOCH><X units=\"km\">{x}</X><Y \
                units=\"km\">{y}</Y><Z>{z}</Z>\
             <X_DOT units=\"km/s\">0</X_DOT><Y_DOT>7.5</Y_DOT><Z_DOT>0</Z_DOT></stateVector>\n"
        )
    }

    fn message() -> String {
        let rows = [[7000.0, 0.0, 0.0], [6990.0, 450.0, 0.0], [6960.0, 899.0, 0.0], [6910.0, 1345.0, 0.0]];
        let rows: String = rows.iter().enumerate().map(|(minute, row)| state(minute, *row)).collect();
        format!("{HEAD}{rows}{TAIL}")
    }

    #[test]
    fn a_message_in_xml_says_what_it_says_in_keywords() {
        let mut found = read_ephemeris(message().as_bytes(), "orbit.xml").unwrap();
        assert_eq!(found[0].line, [7, 8, 9, 10]);
        let keywords = "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-11-21T00:00:00\nORIGINATOR = TEST\n\
            META_START\nOBJECT_NAME = A & B\n\
            OBJECT_ID = 2026-001A\nCENTER_NAME = EARTH\nREF_FRAME = EME2000\nTIME_SYSTEM = UTC\n\
            START_TIME = 2026-11-21T07:00:00\n\
            STOP_TIME = 2026-11-21T07:03:00\nINTERPOLATION = LAGRANGE\nINTERPOLATION_DEGREE = 3\nMETA_STOP\n\
            2026-11-21T07:00:00 7000 0 0 0 7.5 0\n2026-11-21T07:01:00 6990 450 0 0 7.5 0\n\
            2026-11-21T07:02:00 6960 899 0 0 7.5 0\n2026-11-21T07:03:00 6910 1345 0 0 7.5 0\n";
        found[0].line = vec![15, 16, 17, 18];
        assert_eq!(found, read_ephemeris(keywords.as_bytes(), "orbit.oem").unwrap());
        assert_eq!(found[0].position[1], Vector3::new(6.99e6, 4.5e5, 0.0));
        assert!(matches!(found[0].axes, EphemerisAxes::Inertial(_)));
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (from, to, told) in [
            ("<oem id", "<opm id", "no <oem>: <ndm> has <opm>"),
            ("<ndm><oem", "<opm><oem", "no <oem>: the message is <opm>"),
            ("version=\"2.0\"", "version=\"7.0\"", "version 7.0"),
            ("<X units=\"km\">6990", "<X units=\"m\">6990", "the unit m of <X>"),
            ("<Y_DOT>7.5</Y_DOT>", "", "no <Y_DOT>"),
            ("<Z>0</Z>", "<Z>0</Z><Z>0</Z>", "<Z> twice"),
            ("<Z>0</Z>", "<Z>up</Z>", "up"),
            ("<REF_FRAME>EME2000</REF_FRAME>", "", "no `REF_FRAME`"),
            ("07:01:00</EPOCH><X", "06:01:00</EPOCH><X", "not after the one above"),
            ("</data>", "", "is expected"),
            ("</oem></ndm>", "</oem>", "is not closed"),
            ("<?xml version", "<!DOCTYPE ndm><?xml version", "document type declarations are not supported"),
            ("EARTH", "MOON", "not the Earth"),
        ] {
            let text = message().replacen(from, to, 1);
            let text = if from.starts_with("<oem") { text.replace("</oem>", "</opm>") } else { text };
            let text = if from == "<ndm><oem" { text.replace("</ndm>", "</opm>") } else { text };
            let found = read_ephemeris(text.as_bytes(), "orbit.xml").unwrap_err();
            assert!(found.0[0].reason.contains(told), "{to}: {}", found.0[0].reason);
        }
    }
}
