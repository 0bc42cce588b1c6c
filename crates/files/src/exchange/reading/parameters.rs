//! Attitudes at one time, from an attitude parameter message of CCSDS (APM 1.0 and 2.0), in keyword
//! notation or XML, as quaternions or Euler angles.

use super::layout::{Attitude, Layout, Rates, sequence};
use super::message::{body_is_a, date, half_second};
use super::said::{self, Keys, Said};
use super::{AttitudeTold, Number, Piece, Wrong, elements, wrong};
use crate::epoch::{Epoch, Scale};
use crate::rounding::{ROTATION, SILENT};
use crate::spec::cut;
use slewkit::numerics::figures::short;

/// An attitude of the message, with its time.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    pub moment: Epoch,
    /// Uncertainty of the time due to its printed digits \[s\].
    pub open: f64,
    /// Attitude quaternion `[w, x, y, z]` from body to reference axes, which is not normalised yet.
    pub quaternion: [f64; 4],
    pub reference_frame: String,
    pub body_frame: String,
    /// Byte position of the attitude, for messages.
    pub at: usize,
}

impl Parameters {
    /// Returns the attitude with a normalised quaternion.
    pub fn told(self) -> Result<AttitudeTold, Wrong> {
        let length = self.quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
        let defect = (length - 1.0).abs();
        if defect > ROTATION || defect.is_nan() {
            let reason = format!("the quaternion has the length {}", short(length));
            return wrong(self.at, 2, reason, "give unit quaternions");
        }
        let normalised = (defect > SILENT).then(|| {
            format!("the length of the quaternion differs from 1 by {}: it is normalised", short(defect))
        });
        Ok(AttitudeTold {
            quaternion: self.quaternion.map(|part| part / length),
            reference_frame: Some(self.reference_frame),
            body_frame: Some(self.body_frame),
            not_taken: normalised.into_iter().collect(),
        })
    }
}

const UNITS: [(&str, &[&str]); 3] = [("ANGLE_1", &["deg"]), ("ANGLE_2", &["deg"]), ("ANGLE_3", &["deg"])];

/// Reads all attitudes of an APM, one for each quaternion and each set of Euler angles.
pub(super) fn read(text: &str) -> Result<Vec<Parameters>, Wrong> {
    if text.trim_start().starts_with('<') {
        let document = elements::document(text)?;
        return parameters(&said::of_xml(&document, "apm")?);
    }
    parameters(&said::of_keywords(text, "CCSDS_APM_VERS", "APM")?)
}

fn parameters(keys: &Keys<'_>) -> Result<Vec<Parameters>, Wrong> {
    let version = keys[0].value;
    if !["1.0", "2.0"].contains(&version.text) {
        let reason = format!("version {} is not known", cut(version.text, 20));
        return version.wrong(reason, "give an APM of version 1.0 or 2.0");
    }
    said::check(keys, &UNITS)?;
    said::one_message(keys, "messages with attitudes")?;
    let needed = |name: &str| said::needed(keys, name);
    let scale = needed("TIME_SYSTEM")?.value;
    let Some(scale) = Scale::named(scale.text) else {
        let reason = format!("the time system {} is not supported", cut(scale.text, 20));
        return scale.wrong(reason, "give UTC, TAI, TT, TDB or GPS");
    };
    let written = needed("EPOCH")?.value;
    let moment = date(written, scale)?;
    // Quaternions precede Euler angles in the result.
    let of = |name: &'static str| keys.iter().filter(move |said| said.key.is(name));
    let mut starts: Vec<_> = of("Q1").chain(of("ANGLE_1")).collect();
    if starts.is_empty() {
        let Some(angle) = of("X_ANGLE").next() else {
            return keys[0]
                .key
                .wrong("the message has no quaternion and no Euler angles", "give a QUAT_START … QUAT_STOP");
        };
        return angle.key.wrong("Euler angles of version 1.0 are not supported", "give a quaternion");
    }
    // A message may also state the orientation of two spacecraft frames relative to each other. It
    // is not an attitude of the spacecraft.
    if starts.len() > 1 {
        starts.retain(|start| frames(keys, start).is_ok_and(|[a, b]| body_is_a(a, b).is_ok()));
    }
    if starts.is_empty() {
        return keys[0].key.wrong(
            "the message has no attitude of the spacecraft relative to a reference frame",
            "give the attitude of the body relative to a reference frame",
        );
    }
    let open = half_second(written.text);
    starts.into_iter().map(|start| attitude(keys, start, moment, open)).collect()
}

/// Returns the first key of `names` that exists for the attitude whose first key is `start`.
fn near<'t>(keys: &Keys<'t>, start: &Said<'t>, names: &[&str]) -> Result<Said<'t>, Wrong> {
    names.iter().find_map(|name| said::near(keys, start, name)).map_or_else(
        || start.key.wrong(format!("the attitude has no `{}`", names[0]), format!("add {} = …", names[0])),
        Ok,
    )
}

/// Returns the frames A and B of the attitude whose first key is `start`. In version 1.0, the names
/// of these keys begin with `Q_`.
fn frames<'t>(keys: &Keys<'t>, start: &Said<'t>) -> Result<[Piece<'t>; 2], Wrong> {
    let frame = |name: &str, old: &str| near(keys, start, &[name, old]).map(|said| said.value);
    Ok([frame("REF_FRAME_A", "Q_FRAME_A")?, frame("REF_FRAME_B", "Q_FRAME_B")?])
}

/// Returns the attitude whose first key is `start`.
fn attitude<'t>(keys: &Keys<'t>, start: &Said<'t>, moment: Epoch, open: f64) -> Result<Parameters, Wrong> {
    let number = |name: &str| -> Result<Number, Wrong> { near(keys, start, &[name])?.value.number() };
    let [a, b] = frames(keys, start)?;
    let to_b = match said::near(keys, start, "Q_DIR").map(|said| said.value) {
        None => true,
        Some(way) if way.is("A2B") => true,
        Some(way) if way.is("B2A") => false,
        Some(way) => return way.wrong("the direction must be A2B or B2A", "write Q_DIR = A2B"),
    };
    let (body_is_a, _) = body_is_a(a, b)?;
    let (attitude, numbers) = if start.key.is("Q1") {
        let numbers = ["Q1", "Q2", "Q3", "QC"].map(number);
        (Attitude::Quaternion { scalar_first: false }, numbers.into_iter().collect::<Result<Vec<_>, _>>()?)
    } else {
        let order = near(keys, start, &["EULER_ROT_SEQ"])?.value;
        let numbers = ["ANGLE_1", "ANGLE_2", "ANGLE_3"].map(number);
        (Attitude::Euler(sequence(order)?), numbers.into_iter().collect::<Result<Vec<_>, _>>()?)
    };
    let layout = Layout { attitude, rates: Rates::None, inverse: body_is_a == to_b };
    let (reference, body) = if body_is_a { (b, a) } else { (a, b) };
    Ok(Parameters {
        moment,
        open,
        quaternion: layout.read(&numbers).row.quaternion,
        reference_frame: reference.text.into(),
        body_frame: body.text.into(),
        at: start.key.at,
    })
}
