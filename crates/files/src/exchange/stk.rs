//! STK attitude file: time from the epoch, quaternion scalar last, rate in body axes in deg/s.
//!
//! The quaternion turns the reference axes into the body axes: the numbers of ours.

use super::{Record, digits};
use crate::epoch::Scale;
use crate::export::ExportError;
use std::io::Write;

const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// Writes the file.
pub(super) fn write(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    // Epochs of such files are UTC, in the form of Gregorian dates that STK begins with.
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
    writeln!(output, "CentralBody {}", central_body(record.identity.center.as_deref()))?;
    writeln!(output, "CoordinateAxes {}\nAttitudeTimeQuatAngVels", record.identity.reference_frame())?;
    for k in 0..record.nodes() {
        let [w, x, y, z] = record.trajectory.quaternion[k];
        let rate = record.rate(k).map(f64::to_degrees);
        let row = [record.trajectory.time[k], x, y, z, w, rate.x, rate.y, rate.z].map(digits);
        writeln!(output, "{}", row.join(" "))?;
    }
    writeln!(output, "END Attitude")?;
    Ok(())
}

/// As STK writes it: `Earth`.
fn central_body(center: Option<&str>) -> String {
    let name = center.unwrap_or("EARTH");
    let (first, rest) = name.split_at(1);
    first.to_ascii_uppercase() + &rest.to_ascii_lowercase()
}
