//! Mean elements of a satellite, from an orbit mean-elements message of CCSDS (OMM 2.0 and 3.0) in
//! keyword notation, XML or JSON. JSON is read in the form used by catalogues, in which numbers may
//! be written as texts. Only SGP4 elements of satellites of the Earth are read, in TEME and UTC.
//! Satellite numbers may have any number of digits.

use super::message::date;
use super::said::{self, Keys, Said};
use super::{Piece, Wrong, elements, resolved, whole_text, wrong};
use crate::epoch::Scale;
use crate::spec::{Diagnostics, Node, Source, Value, cut, parse_json};
use slewkit_sky::MeanElements;
use std::io::Read;

/// Units that the standard requires for the keys that are used.
const UNITS: [(&str, &[&str]); 9] = [
    ("MEAN_MOTION", &["rev/day"]),
    ("SEMI_MAJOR_AXIS", &["km"]),
    ("INCLINATION", &["deg"]),
    ("RA_OF_ASC_NODE", &["deg"]),
    ("ARG_OF_PERICENTER", &["deg"]),
    ("MEAN_ANOMALY", &["deg"]),
    ("BSTAR", &["1/ER"]),
    ("MEAN_MOTION_DOT", &["rev/day**2"]),
    ("MEAN_MOTION_DDOT", &["rev/day**3"]),
];

/// Keys of the standard. User-defined keys and the elements of a covariance are not listed; they
/// are ignored.
const KNOWN: [&str; 39] = [
    "CCSDS_OMM_VERS",
    "omm",
    "CREATION_DATE",
    "ORIGINATOR",
    "MESSAGE_ID",
    "CLASSIFICATION",
    "OBJECT_NAME",
    "OBJECT_ID",
    "CENTER_NAME",
    "REF_FRAME",
    "REF_FRAME_EPOCH",
    "TIME_SYSTEM",
    "MEAN_ELEMENT_THEORY",
    "EPOCH",
    "SEMI_MAJOR_AXIS",
    "MEAN_MOTION",
    "ECCENTRICITY",
    "INCLINATION",
    "RA_OF_ASC_NODE",
    "ARG_OF_PERICENTER",
    "MEAN_ANOMALY",
    "GM",
    "MASS",
    "SOLAR_RAD_AREA",
    "SOLAR_RAD_COEFF",
    "DRAG_AREA",
    "DRAG_COEFF",
    "EPHEMERIS_TYPE",
    "CLASSIFICATION_TYPE",
    "NORAD_CAT_ID",
    "ELEMENT_SET_NO",
    "REV_AT_EPOCH",
    "BSTAR",
    "BTERM",
    "MEAN_MOTION_DOT",
    "MEAN_MOTION_DDOT",
    "AGOM",
    "COV_REF_FRAME",
    "SEMIMAJOR_AXIS",
];

/// Reads an OMM and returns its elements; `name` is the name of the file in messages.
///
/// # Errors
/// Returns the first error, with its line. Elements of a theory other than SGP4, or in a frame
/// other than TEME, are errors too.
pub fn read_mean_elements(input: impl Read, name: &str) -> Result<MeanElements, Diagnostics> {
    let text = whole_text(input, name, "an OMM")?;
    mean_elements(&text).map_err(|wrong| resolved(wrong, name, text))
}

fn mean_elements(text: &str) -> Result<MeanElements, Wrong> {
    let lead = text.len() - text.trim_start().len();
    match text[lead..].chars().next() {
        None => wrong(0, 1, "the file is empty", "give an OMM"),
        Some('<') => {
            let document = elements::document(text)?;
            taken(&said::of_xml(&document, "omm")?, true)
        }
        Some('[' | '{') => {
            let root =
                parse_json(&Source::new("", text)).map_err(|mut found| Wrong::of(found.swap_remove(0)))?;
            let (mut keys, mut parts) = (Keys::new(), 0);
            flatten(&root, text, &mut parts, &mut keys)?;
            taken(&keys, false)
        }
        Some('1' | '2') if text[lead..].chars().nth(1) == Some(' ') => {
            wrong(lead, 1, "these are two-line elements", "write their lines as tle = [\"1 …\", \"2 …\"]")
        }
        _ if text[lead..].starts_with("OBJECT_NAME,") => {
            wrong(lead, 11, "this is a table", "take the same elements as JSON, as XML or as keywords")
        }
        _ => taken(&said::of_keywords(text, "CCSDS_OMM_VERS", "OMM")?, true),
    }
}

/// Appends the keys and values of a JSON tree to `keys`. The tree may contain lists and nested
/// objects; every object is a separate part.
fn flatten<'t>(node: &'t Node, text: &'t str, parts: &mut usize, keys: &mut Keys<'t>) -> Result<(), Wrong> {
    let at = node.span.start;
    match &node.value {
        Value::Array(list) if list.is_empty() => {
            wrong(at, 1, "the list has no elements", "give one satellite")
        }
        Value::Array(list) => list.iter().try_for_each(|node| flatten(node, text, parts, keys)),
        Value::Table(entries) => {
            let part = *parts;
            *parts += 1;
            entries.iter().try_for_each(|entry| {
                let written = entry.node.span;
                let value = match &entry.node.value {
                    Value::Table(_) | Value::Array(_) => {
                        return flatten(&entry.node, text, parts, keys);
                    }
                    Value::Null => return Ok(()),
                    Value::Text(word) => word,
                    _ => &text[written.start..written.end],
                };
                keys.push(Said {
                    key: Piece { at: entry.key_span.start, text: &entry.key },
                    value: Piece { at: written.start, text: value }.trimmed(),
                    unit: None,
                    part,
                });
                Ok(())
            })
        }
        _ => wrong(at, 1, "this is not a JSON object", "give the elements as an object with the keys of OMM"),
    }
}

/// Returns true for a key of the standard and for a key that is ignored: a user-defined key, or an
/// element of a covariance such as `CX_DOT_Y`.
fn known(key: Piece<'_>) -> bool {
    let upper = key.text.to_ascii_uppercase();
    let of_covariance = |rest: &str| {
        let mut axes = rest.split('_').filter(|word| *word != "DOT");
        axes.by_ref().take(2).filter(|axis| ["X", "Y", "Z"].contains(axis)).count() == 2
            && axes.next().is_none()
    };
    KNOWN.iter().any(|known| key.is(known))
        || upper.starts_with("USER_DEFINED_")
        || upper.strip_prefix('C').is_some_and(of_covariance)
}

/// Returns the mean elements that the keys describe. If `message` is true, all keys that the
/// standard requires must exist. A record of a catalogue may lack the keys whose values are common
/// to all records.
fn taken(keys: &Keys<'_>, message: bool) -> Result<MeanElements, Wrong> {
    said::check(keys, &UNITS)?;
    said::one_message(keys, "sets of elements")?;
    let needed = |name: &str| said::needed(keys, name);
    if message {
        let version = keys[0].value;
        if !["1.0", "2.0", "3.0"].contains(&version.text) {
            let reason = format!("version {} is not known", cut(version.text, 20));
            return version.wrong(reason, "give an OMM of version 2.0 or 3.0");
        }
        // In XML, names of elements that contain other elements begin with a lower-case letter.
        let xml = keys[0].key.text == "omm";
        let container = |key: Piece<'_>| xml && key.text.starts_with(|sign: char| sign.is_lowercase());
        if let Some(said) = keys.iter().find(|said| !known(said.key) && !container(said.key)) {
            let reason = format!("unknown key `{}` in an OMM", cut(said.key.text, 40));
            return said.key.wrong(reason, "check the spelling");
        }
        for name in ["CENTER_NAME", "REF_FRAME", "TIME_SYSTEM", "MEAN_ELEMENT_THEORY"] {
            needed(name)?;
        }
    }
    let word = |name: &str| said::get(keys, name).map(|said| said.value);
    if let Some(theory) = word("MEAN_ELEMENT_THEORY")
        .filter(|theory| !theory.is("SGP4") && !theory.is("SGP/SGP4") && !theory.is("SGP"))
    {
        let reason = format!("the theory {} is not supported", cut(theory.text, 30));
        return theory.wrong(reason, "give elements of SGP4, or an OEM of the orbit");
    }
    if let Some(kind) = word("EPHEMERIS_TYPE").filter(|kind| kind.text == "4") {
        return kind.wrong(
            "ephemeris type 4 (SGP4-XP) is not supported, because its formulas are not public",
            "give elements of ephemeris type 0 (SGP4)",
        );
    }
    if let Some(centre) = word("CENTER_NAME").filter(|centre| !centre.is("EARTH")) {
        let reason = format!("the centre is {}, not the Earth", cut(centre.text, 30));
        return centre.wrong(reason, "give elements about CENTER_NAME = EARTH");
    }
    let teme = |frame: &Piece<'_>| ["TEME", "TEMEOFDATE", "TEME_OF_DATE"].iter().any(|known| frame.is(known));
    if let Some(frame) = word("REF_FRAME").filter(|frame| !teme(frame)) {
        let reason = format!("the frame {} is not the frame of SGP4", cut(frame.text, 30));
        return frame.wrong(reason, "give elements in REF_FRAME = TEME");
    }
    let scale = match word("TIME_SYSTEM") {
        None => Scale::Utc,
        Some(scale) => match Scale::named(scale.text) {
            Some(scale) => scale,
            None => {
                let reason = format!("the time system {} is not supported", cut(scale.text, 20));
                return scale.wrong(reason, "give UTC, TAI, TT, TDB or GPS");
            }
        },
    };
    let number = |name: &str, inside: fn(&f64) -> bool, range: &str| -> Result<f64, Wrong> {
        let value = needed(name)?.value;
        let found = value.number()?.value;
        if inside(&found) {
            return Ok(found);
        }
        let reason = format!("`{name}` is {}: it is {range}", cut(value.text, 20));
        value.wrong(reason, "check the number and its unit")
    };
    if word("MEAN_MOTION").is_none() && word("SEMI_MAJOR_AXIS").is_some() {
        return needed("SEMI_MAJOR_AXIS")?
            .key
            .wrong("SGP4 takes a mean motion, not a semi-major axis", "give MEAN_MOTION in rev/day");
    }
    let angle = |name: &str| number(name, |angle| (-360.0..=360.0).contains(angle), "from -360 to 360 deg");
    let moment = date(needed("EPOCH")?.value, scale)?;
    let (year, day_of_year, nanoseconds_of_day) = day_of(&moment.in_other_scale(Scale::Utc).calendar_text());
    Ok(MeanElements {
        year,
        day_of_year,
        nanoseconds_of_day,
        mean_motion: number("MEAN_MOTION", |n| *n > 0.0 && *n < 20.0, "above 0 and below 20 rev/day")?,
        eccentricity: number("ECCENTRICITY", |e| (0.0..1.0).contains(e), "from 0 to below 1")?,
        inclination_deg: number("INCLINATION", |i| (0.0..=180.0).contains(i), "from 0 to 180 deg")?,
        raan_deg: angle("RA_OF_ASC_NODE")?,
        argument_of_perigee_deg: angle("ARG_OF_PERICENTER")?,
        mean_anomaly_deg: angle("MEAN_ANOMALY")?,
        drag: number("BSTAR", |drag| drag.abs() < 1e3, "between -1000 and 1000 per radius of the Earth")?,
    })
}

/// Returns the year, the day of the year, and the time of day in nanoseconds of a date such as
/// `2026-11-21T07:00:00.25`.
fn day_of(text: &str) -> (i32, u32, u64) {
    let (date, clock) = text.split_once('T').unwrap_or((text, ""));
    let numbers: Vec<u32> = date.split('-').filter_map(|part| part.parse().ok()).collect();
    let [year, month, day] = numbers[..] else { return (0, 0, 0) };
    let leap = u32::from(year % 4 == 0 && (year % 100 != 0 || year % 400 == 0));
    const BEFORE: [u32; 12] = [0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334];
    let before = BEFORE[(month as usize + 11) % 12] + if month > 2 { leap } else { 0 };
    let (whole, part) = clock.split_once('.').unwrap_or((clock, "0"));
    let seconds =
        whole.split(':').filter_map(|part| part.parse::<u64>().ok()).fold(0, |sum, part| 60 * sum + part);
    let nanoseconds = (format!("0.{part}").parse::<f64>().unwrap_or(0.0) * 1e9).round() as u64;
    (year as i32, before + day, seconds * 1_000_000_000 + nanoseconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEYWORDS: &str = "CCSDS_OMM_VERS = 2.0\nCREATION_DATE = 2026-11-20T13:00:00\nORIGINATOR = TEST\n\
        OBJECT_NAME = SAMPLE\n\
        OBJECT_ID = 2020-001A\nCENTER_NAME = EARTH\nREF_FRAME = TEME\nTIME_SYSTEM = UTC\nMEAN_ELEMENT_THEORY = SGP4\n\
        COMMENT elements\nEPOCH = 2026-324T12:00:00.000\nMEAN_MOTION = 14.9 [rev/day]\nECCENTRICITY = .0012\n\
        INCLINATION = 97.8 [deg]\n\
        RA_OF_ASC_NODE = 200.1\nARG_OF_PERICENTER = 90.2\nMEAN_ANOMALY = 270.1\nEPHEMERIS_TYPE = 0\n\
        CLASSIFICATION_TYPE = U\n\
        NORAD_CAT_ID = 799999999\nELEMENT_SET_NO = 999\nREV_AT_EPOCH = 1\nBSTAR = 2e-05\nMEAN_MOTION_DOT = 1e-06\n\
        MEAN_MOTION_DDOT = 0\nUSER_DEFINED_X = 3\n";
    const XML: &str = "<?xml version=\"1.0\"?><ndm xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\
        <omm id=\"CCSDS_OMM_VERS\" version=\"2.0\">\
        <header><CREATION_DATE/><ORIGINATOR/></header><body><segment><metadata><OBJECT_NAME>A&amp;B</OBJECT_NAME>\
        <OBJECT_ID>2020-001A</OBJECT_ID><CENTER_NAME>EARTH</CENTER_NAME><REF_FRAME>TEME</REF_FRAME>\
        <TIME_SYSTEM>UTC</TIME_SYSTEM>\
        <MEAN_ELEMENT_THEORY>SGP4</MEAN_ELEMENT_THEORY></metadata><data><meanElements><EPOCH>\
        2026-11-20T12:00:00.000000</EPOCH>\
        <MEAN_MOTION units=\"rev/day\">14.9</MEAN_MOTION><ECCENTRICITY>.0012</ECCENTRICITY><INCLINATION>97.8\
        </INCLINATION>\
        <RA_OF_ASC_NODE>200.1</RA_OF_ASC_NODE><ARG_OF_PERICENTER>90.2</ARG_OF_PERICENTER><MEAN_ANOMALY>270.1\
        </MEAN_ANOMALY>\
        </meanElements><tleParameters><EPHEMERIS_TYPE>0</EPHEMERIS_TYPE><NORAD_CAT_ID>100001</NORAD_CAT_ID>\
        <BSTAR>0.2E-4</BSTAR>\
        </tleParameters><userDefinedParameters><USER_DEFINED parameter=\"X\">3</USER_DEFINED></userDefinedParameters>\
        </data></segment></body></omm></ndm>";
    const NUMBERS: &str = "{\"OBJECT_NAME\":\"SAMPLE\",\"EPOCH\":\"2026-11-20T12:00:00.000000\",\
        \"MEAN_MOTION\":14.9,\"ECCENTRICITY\":0.0012,\"INCLINATION\":97.8,\"RA_OF_ASC_NODE\":200.1,\
        \"ARG_OF_PERICENTER\":90.2,\"MEAN_ANOMALY\":270.1,\"EPHEMERIS_TYPE\":0,\"NORAD_CAT_ID\":123456789,\
        \"BSTAR\":2e-05,\"DECAY_DATE\":null}";

    fn of(text: &str) -> MeanElements {
        read_mean_elements(text.as_bytes(), "x").unwrap_or_else(|errors| panic!("{errors}\n{text}"))
    }

    #[test]
    fn all_notations_say_the_same_elements() {
        let found = of(KEYWORDS);
        assert_eq!(
            (found.year, found.day_of_year, found.nanoseconds_of_day),
            (2026, 324, 43_200_000_000_000)
        );
        assert_eq!((found.mean_motion, found.eccentricity, found.drag), (14.9, 0.0012, 2e-5));
        let texts =
            NUMBERS.replace("14.9", "\"14.9\"").replace("2e-05", "\"0.00002000\"").replace(":0,", ":\"0\",");
        let nested = format!("{{\"omm\": {{\"header\": {{}}, \"data\": {NUMBERS}}}}}");
        let tai = KEYWORDS.replace("UTC", "TAI").replace("12:00:00.000", "12:00:37.000");
        for text in [XML, NUMBERS, &format!("[{NUMBERS}]"), &texts, &nested, &tai] {
            assert_eq!(of(text), found, "{text}");
        }
    }

    /// The 21 elements of a covariance and user-defined keys are ignored, whatever their names are.
    #[test]
    fn covariances_and_keys_of_users_are_passed_over() {
        let axes = ["X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT"];
        let each = |open: fn(&str) -> String, close: fn(&str) -> String| -> String {
            let pairs = (0..6).flat_map(|row| (0..=row).map(move |column| (axes[row], axes[column])));
            let names = pairs.map(|(row, column)| format!("C{row}_{column}"));
            names.map(|name| format!("{}1{}", open(&name), close(&name))).collect()
        };
        let lines = each(|name| format!("{name} = "), |_| "\n".into());
        let found = of(&format!("{KEYWORDS}COV_REF_FRAME = RTN\n{lines}USER_DEFINED_BSTAR = 7\n"));
        let elements = each(|name| format!("<{name}>"), |name| format!("</{name}>"));
        let matrix = format!("<covarianceMatrix>{elements}</covarianceMatrix><userDefinedParameters>");
        let theirs = "<USER_DEFINED parameter=\"BSTAR\">7</USER_DEFINED>".repeat(2);
        let text = XML.replace("<userDefinedParameters>", &format!("{matrix}{theirs}"));
        assert_eq!(of(&text), found);
        assert_eq!(found.drag, 2e-5);
        for (from, to) in [("CX_X", "CX_W"), ("CX_X", "CX"), ("CX_X", "CX_X_X")] {
            let wrong = format!("{KEYWORDS}{lines}").replacen(from, to, 1);
            let said = read_mean_elements(wrong.as_bytes(), "x").unwrap_err().0[0].reason.clone();
            assert!(said.contains("unknown key"), "{to}: {said}");
        }
        let without = text.replace("<BSTAR>0.2E-4</BSTAR>", "");
        let said = read_mean_elements(without.as_bytes(), "x").unwrap_err().0[0].reason.clone();
        assert!(said.contains("no `BSTAR`"), "{said}");
    }

    #[test]
    fn what_is_no_orbit_of_sgp4_is_refused_with_its_line() {
        for (text, from, to, told) in [
            (KEYWORDS, "= SGP4", "= SGP4-XP", "the theory SGP4-XP"),
            (KEYWORDS, "= SGP4", "= DSST", "the theory DSST"),
            (KEYWORDS, "EPHEMERIS_TYPE = 0", "EPHEMERIS_TYPE = 4", "SGP4-XP"),
            (KEYWORDS, "= EARTH", "= MARS", "not the Earth"),
            (KEYWORDS, "= TEME", "= EME2000", "EME2000 is not the frame of SGP4"),
            (KEYWORDS, "[deg]", "[rad]", "the unit rad of `INCLINATION`"),
            (KEYWORDS, "BSTAR = 2e-05\n", "", "no `BSTAR`"),
            (KEYWORDS, "TIME_SYSTEM = UTC\n", "", "no `TIME_SYSTEM`"),
            (KEYWORDS, "= .0012", "= 1.2", "from 0 to below 1"),
            (KEYWORDS, "270.1", "361", "from -360 to 360 deg"),
            (KEYWORDS, "14.9 ", "0 ", "above 0 and below 20 rev/day"),
            (KEYWORDS, "MEAN_MOTION = 14.9 [rev/day]", "SEMI_MAJOR_AXIS = 7000", "takes a mean motion"),
            (KEYWORDS, "MEAN_ANOMALY = 270.1", "MEAN_ANOMALY = 270.1\nMEAN_ANOMALY = 1", "given twice"),
            (KEYWORDS, "MEAN_ANOMALY", "MEAN_ANOMLY", "unknown key `MEAN_ANOMLY`"),
            (KEYWORDS, "VERS = 2.0", "VERS = 7.0", "version 7.0"),
            (KEYWORDS, "CCSDS_OMM", "CCSDS_OPM", "the file is not an OMM"),
            (KEYWORDS, "2026-324T12", "2026-367T12", "this date does not exist"),
            (XML, "rev/day", "rad/s", "the unit rad/s"),
            (XML, "<omm", "<opm", "XML"),
            (XML, "<EPHEMERIS_TYPE>0</EPHEMERIS_TYPE>", "<EPHEMERIS_TYP>4</EPHEMERIS_TYP>", "unknown key"),
            (XML, "<BSTAR>0.2E-4</BSTAR>", "", "no `BSTAR`"),
            (NUMBERS, "14.9", "\"fast\"", "`fast` is not a number"),
            (NUMBERS, "\"BSTAR\":2e-05,", "", "no `BSTAR`"),
            (NUMBERS, "\"BSTAR\":2e-05,", "\"BSTAR\":2e-05,\"BSTAR\":7,", "`BSTAR` is set twice"),
            (NUMBERS, "}", "", "not valid JSON"),
        ] {
            let wrong = text.replacen(from, to, 1);
            let told = if told == "XML" { "is expected" } else { told };
            let found = read_mean_elements(wrong.as_bytes(), "x").unwrap_err();
            assert!(found.0[0].reason.contains(told), "{to}: {}", found.0[0].reason);
        }
        let other = NUMBERS.replace("SAMPLE", "OTHER");
        let message = XML.split("<omm").nth(1).unwrap().split("</ndm>").next().unwrap();
        let segment = XML.split("<body>").nth(1).unwrap().split("</body>").next().unwrap();
        for (two, told) in [
            (format!("[{NUMBERS},{other}]"), "2 sets of elements: SAMPLE, OTHER"),
            (format!("{{\"first\":{NUMBERS},\"second\":{other}}}"), "2 sets of elements: SAMPLE, OTHER"),
            (format!("{{\"omms\":[{NUMBERS},[{other}]]}}"), "2 sets of elements: SAMPLE, OTHER"),
            (format!("{{\"omms\":[{NUMBERS},{{\"data\":{other}}}]}}"), "2 sets of elements: SAMPLE, OTHER"),
            (
                format!("{KEYWORDS}{}", KEYWORDS.replace("SAMPLE", "OTHER")),
                "2 sets of elements: SAMPLE, OTHER",
            ),
            (
                XML.replace("</ndm>", &format!("<omm{}</ndm>", message.replace("A&amp;B", "C"))),
                "2 sets of elements: A&B, C",
            ),
            (XML.replace("</segment>", &format!("</segment>{segment}")), "2 sets of elements: A&B, A&B"),
        ] {
            let found = read_mean_elements(two.as_bytes(), "x").unwrap_err();
            assert!(found.0[0].reason.contains(told), "{}", found.0[0].reason);
        }
    }
}
