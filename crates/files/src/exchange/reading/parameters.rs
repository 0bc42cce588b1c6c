//! One attitude, by an attitude parameter message of CCSDS (APM 1.0 and 2.0): keywords and values
//! or XML, a quaternion or Euler angles.

use super::layout::{Attitude, Layout, Rates, sequence};
use super::message::{body_is_a, date, half_second};
use super::said::{self, Keys, Said};
use super::{Number, Piece, Wrong, elements};
use crate::epoch::{Epoch, Scale};
use crate::spec::cut;

/// An attitude at a moment.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    pub moment: Epoch,
    /// The uncertainty of the moment from its digits \[s\].
    pub open: f64,
    /// The attitude from body to reference, `[w, x, y, z]`, whose length is as exact as its digits.
    pub quaternion: [f64; 4],
    pub reference_frame: String,
    pub body_frame: String,
    /// The place of the quaternion.
    pub at: usize,
}

const UNITS: [(&str, &[&str]); 3] = [("ANGLE_1", &["deg"]), ("ANGLE_2", &["deg"]), ("ANGLE_3", &["deg"])];

/// Reads the message.
pub(super) fn read(text: &str) -> Result<Parameters, Wrong> {
    if text.trim_start().starts_with('<') {
        let document = elements::document(text)?;
        return parameters(&said::of_xml(&document, "apm")?);
    }
    parameters(&said::of_keywords(text, "CCSDS_APM_VERS", "APM")?)
}

fn parameters(keys: &Keys<'_>) -> Result<Parameters, Wrong> {
    let version = keys[0].value;
    if !["1.0", "2.0"].contains(&version.text) {
        let reason = format!("version {} is not known", cut(version.text, 20));
        return version.wrong(reason, "give an APM of version 1.0 or 2.0");
    }
    said::check(keys, &UNITS)?;
    let needed = |name: &str| said::needed(keys, name);
    let scale = needed("TIME_SYSTEM")?.value;
    let Some(scale) = Scale::named(scale.text) else {
        let reason = format!("the time system {} is not known here", cut(scale.text, 20));
        return scale.wrong(reason, "give UTC, TAI, TT, TDB or GPS");
    };
    let written = needed("EPOCH")?.value;
    let moment = date(written, scale)?;
    // The keys of the part that has the attitude. All keys of version 1.0 belong to one part, and
    // have a letter before their names.
    let start =
        said::get(keys, "Q1").or_else(|| said::get(keys, "ANGLE_1")).or_else(|| said::get(keys, "X_ANGLE"));
    let Some(start) = start else {
        return keys[0]
            .key
            .wrong("the message has no quaternion and no Euler angles", "give a QUAT_START … QUAT_STOP");
    };
    // XML has an element for the numbers within the part that has the frames.
    let near = |name: &str| -> Option<Said<'_>> {
        let named = |said: &&Said<'_>| said.key.is(name);
        let before = keys.iter().rfind(|said| said.key.at <= start.key.at && named(said));
        keys.iter().find(|said| said.part == start.part && named(said)).or(before).copied()
    };
    let of = |names: &[&str]| -> Result<Said<'_>, Wrong> {
        names.iter().find_map(|name| near(name)).map_or_else(
            || {
                start
                    .key
                    .wrong(format!("the attitude has no `{}`", names[0]), format!("add {} = …", names[0]))
            },
            Ok,
        )
    };
    let number = |name: &str| -> Result<Number, Wrong> { of(&[name])?.value.number() };
    let (a, b) = (
        of(&["REF_FRAME_A", "Q_FRAME_A", "EULER_FRAME_A"])?.value,
        of(&["REF_FRAME_B", "Q_FRAME_B", "EULER_FRAME_B"])?.value,
    );
    let to_b = match ["Q_DIR", "EULER_DIR"].iter().find_map(|name| near(name)).map(|said| said.value) {
        None => true,
        Some(way) if way.is("A2B") => true,
        Some(way) if way.is("B2A") => false,
        Some(way) => return way.wrong("a direction is A2B or B2A", "write Q_DIR = A2B"),
    };
    let (body_is_a, _) = body_is_a(a, b)?;
    let (attitude, numbers) = if start.key.is("Q1") {
        let numbers = ["Q1", "Q2", "Q3", "QC"].map(number);
        (Attitude::Quaternion { scalar_first: false }, numbers.into_iter().collect::<Result<Vec<_>, _>>()?)
    } else {
        let order: Piece<'_> = of(&["EULER_ROT_SEQ"])?.value;
        if !start.key.is("ANGLE_1") {
            return start.key.wrong("Euler angles of version 1.0 are not read", "give a quaternion");
        }
        let numbers = ["ANGLE_1", "ANGLE_2", "ANGLE_3"].map(number);
        (Attitude::Euler(sequence(order)?), numbers.into_iter().collect::<Result<Vec<_>, _>>()?)
    };
    let layout = Layout { attitude, rates: Rates::None, inverse: body_is_a == to_b };
    let (reference, body) = if body_is_a { (b, a) } else { (a, b) };
    Ok(Parameters {
        moment,
        open: half_second(written.text),
        quaternion: layout.read(&numbers).row.quaternion,
        reference_frame: reference.text.into(),
        body_frame: body.text.into(),
        at: start.key.at,
    })
}
