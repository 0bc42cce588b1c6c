//! SPICE kernels of a plan: a C-kernel of type 3 with rates, and its clock and frame kernels.
//!
//! The C-matrix of SPICE maps reference components to body components. The quaternion in the kernel
//! is therefore the conjugate of the quaternion in plan files, scalar first. Rates are in reference
//! axes \[rad/s\]. The clock counts microseconds of terrestrial time from the epoch of the
//! maneuver. The structure number is the number of the spacecraft times 1000; SPICE derives the
//! number of the clock from it.

mod daf;

use super::{Lacking, Record, digits};
use crate::export::ExportError;
use crate::identity::Identity;
use daf::{Daf, Segment};
use slewkit::lie;
use std::io::Write;

/// Number of clock ticks per second.
const TICKS: f64 = 1e6;
/// Type of the segment: pointing with rates, interpolated by rotation about a fixed axis.
const TYPE: i32 = 3;
/// Number of array entries between two entries of the directory of the array.
const DIRECTORY: usize = 100;

/// Inertial frames that are written and read, each with its SPICE number and name.
pub(super) const FRAMES: [(i32, &str); 3] = [(1, "J2000"), (2, "B1950"), (17, "ECLIPJ2000")];

/// Returns the SPICE number of the reference frame; `None` if SPICE does not have the frame. In
/// SPICE, ICRF and J2000 are the same frame.
pub(super) fn inertial_frame(identity: &Identity) -> Option<i32> {
    let name = match identity.reference_frame() {
        "ICRF" | "EME2000" => "J2000",
        other => other,
    };
    FRAMES.iter().find(|(_, known)| *known == name).map(|(number, _)| *number)
}

fn number(record: &Record<'_>) -> Result<i32, Lacking> {
    record.identity.spice_id.ok_or(Lacking::SpiceId)
}

/// Writes the attitudes and rates as a SPICE C-kernel of type 3.
pub(super) fn write_ck(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    let number = number(record)?;
    let frame = inertial_frame(&record.identity).ok_or(Lacking::SpiceFrame)?;
    let ticks: Vec<f64> = record.trajectory.time.iter().map(|time| time * TICKS).collect();
    // The array consists of the attitudes with rates, the times, every hundredth time, the start of
    // the only interpolation interval, and the numbers of intervals and rows.
    let mut numbers = Vec::with_capacity(9 * ticks.len());
    for (k, quaternion) in record.trajectory.quaternion.iter().enumerate() {
        let [w, x, y, z] = *quaternion;
        let rate = lie::rotation_from_quaternion(quaternion) * record.rate(k);
        numbers.extend([w, -x, -y, -z, rate.x, rate.y, rate.z]);
    }
    numbers.extend(&ticks);
    numbers.extend((1..=(ticks.len() - 1) / DIRECTORY).map(|entry| ticks[entry * DIRECTORY - 1]));
    numbers.push(ticks[0]);
    numbers.extend([1.0, ticks.len() as f64]);
    let comment = comment(record, number)?;
    let segment = Segment {
        name: record.name(),
        bounds: [ticks[0], ticks[ticks.len() - 1]],
        integers: [number * 1000, frame, TYPE, 1],
        numbers,
    };
    Ok(Daf { kind: "CK", name: record.name(), comment, segment }.write(output)?)
}

/// Returns the lines of the comment area: object and maneuver, remarks, structure, clock and epoch.
fn comment(record: &Record<'_>, number: i32) -> Result<Vec<String>, ExportError> {
    let mut lines = vec![format!("Attitude of {}: {}", record.object(), record.name())];
    lines.extend(record.notes.iter().cloned());
    lines.push(format!("Structure {}, clock {number}: one tick is a microsecond of TT", number * 1000));
    lines.push(
        "Between the rows SPICE turns about one axis at one rate: more steps interpolate better.".into(),
    );
    lines.push(format!("Epoch: {}", record.epoch()?));
    Ok(lines)
}

/// Writes the SPICE clock kernel, which defines the clock of the C-kernel.
pub(super) fn write_sclk(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    let (number, epoch) = (number(record)?, record.epoch()?);
    let clock = number.unsigned_abs();
    let calendar = epoch.in_other_scale(crate::epoch::Scale::Tt).calendar_text();
    writeln!(output, "KPL/SCLK\n\nClock of {}: microseconds of TT from {epoch}.\n", record.object())?;
    writeln!(output, "\\begindata\n\nSCLK_KERNEL_ID = ( @{} )", calendar.replace('T', "/"))?;
    writeln!(output, "SCLK_DATA_TYPE_{clock} = ( 1 )\nSCLK01_TIME_SYSTEM_{clock} = ( 2 )")?;
    writeln!(output, "SCLK01_N_FIELDS_{clock} = ( 2 )\nSCLK01_MODULI_{clock} = ( 4294967296 1000000 )")?;
    writeln!(output, "SCLK01_OFFSETS_{clock} = ( 0 0 )\nSCLK01_OUTPUT_DELIM_{clock} = ( 1 )")?;
    writeln!(output, "SCLK_PARTITION_START_{clock} = ( 0.0 )")?;
    writeln!(output, "SCLK_PARTITION_END_{clock} = ( 4.2949672959999990E+15 )")?;
    let start = digits(epoch.terrestrial_past_j2000());
    writeln!(output, "SCLK01_COEFFICIENTS_{clock} = ( 0.0 {start} 1.0 )\n\n\\begintext")?;
    Ok(())
}

/// Writes the SPICE frame kernel, which defines the body frame.
pub(super) fn write_fk(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    let number = number(record)?;
    let (frame, name) = (number * 1000, record.identity.body_frame());
    writeln!(output, "KPL/FK\n\nThe body frame of {}.\n\n\\begindata\n", record.object())?;
    writeln!(output, "FRAME_{name} = {frame}\nFRAME_{frame}_NAME = '{name}'\nFRAME_{frame}_CLASS = 3")?;
    writeln!(output, "FRAME_{frame}_CLASS_ID = {frame}\nFRAME_{frame}_CENTER = {number}")?;
    writeln!(output, "CK_{frame}_SCLK = {number}\nCK_{frame}_SPK = {number}")?;
    writeln!(output, "NAIF_BODY_NAME += ( '{}' )\nNAIF_BODY_CODE += ( {number} )", record.object())?;
    writeln!(output, "\n\\begintext")?;
    Ok(())
}
