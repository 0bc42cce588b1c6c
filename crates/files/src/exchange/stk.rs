//! STK attitude files: time since the epoch, quaternion with the scalar last, rate in body
//! axes \[deg/s\].
//!
//! The quaternion describes the rotation from the reference axes to the body axes, and has the same
//! components as in plan files.

use super::{Lacking, Record, digits};
use crate::epoch::Scale;
use crate::export::ExportError;
use crate::identity::Identity;
use std::io::Write;

const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// Writes the trajectory as an STK attitude file.
pub(super) fn write(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    // STK expects the epoch as a Gregorian date in UTC.
    let epoch = record.epoch()?.in_other_scale(Scale::Utc);
    let text = epoch.calendar_text();
    let (date, clock) = text.split_once('T').unwrap_or((&text, ""));
    let parts: Vec<&str> = date.split('-').collect();
    let month = parts.get(1).and_then(|month| month.parse::<usize>().ok()).unwrap_or(1);
    let (year, day) = (parts.first().unwrap_or(&""), parts.get(2).unwrap_or(&"").trim_start_matches('0'));
    writeln!(output, "stk.v.11.0\n# {}", record.name())?;
    for note in &record.notes {
        writeln!(output, "# {note}")?;
    }
    writeln!(output, "BEGIN Attitude\nScenarioEpoch {day} {} {year} {clock}", MONTHS[(month - 1) % 12])?;
    writeln!(output, "NumberOfAttitudePoints {}", record.nodes())?;
    writeln!(output, "BlockingFactor 20\nInterpolationOrder 1")?;
    let center = central_body(record.identity.center.as_deref()).ok_or(Lacking::StkCenter)?;
    let axes = axes(&record.identity).ok_or(Lacking::StkFrame)?;
    writeln!(output, "CentralBody {center}\nCoordinateAxes {axes}\nAttitudeTimeQuatAngVels")?;
    for k in 0..record.nodes() {
        let [w, x, y, z] = record.trajectory.quaternion[k];
        let rate = record.rate(k).map(f64::to_degrees);
        let row = [record.trajectory.time[k], x, y, z, w, rate.x, rate.y, rate.z].map(digits);
        writeln!(output, "{}", row.join(" "))?;
    }
    writeln!(output, "END Attitude")?;
    Ok(())
}

/// Returns the name of the central body in the spelling of STK, such as `Earth`; `None` if the name
/// is absent or is not a single word.
pub(super) fn central_body(center: Option<&str>) -> Option<String> {
    let name = center.unwrap_or("EARTH");
    let (first, rest) = name.split_at_checked(1)?;
    let is_word = name.bytes().all(|byte| byte.is_ascii_alphabetic());
    is_word.then(|| first.to_ascii_uppercase() + &rest.to_ascii_lowercase())
}

/// Returns the STK name of the axes of the reference frame; `None` if STK does not have these axes.
pub(super) fn axes(identity: &Identity) -> Option<&'static str> {
    let name = identity.reference_frame();
    let is = |of: &[&str]| of.iter().any(|known| name.eq_ignore_ascii_case(known));
    if is(&["ICRF", "GCRF"]) {
        Some("ICRF")
    } else if is(&["J2000", "EME2000"]) {
        Some("J2000")
    } else {
        None
    }
}
