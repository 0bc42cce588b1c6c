//! CCSDS attitude messages in the keyword notation: AEM 1.0 and 2.0, APM 2.0 (CCSDS 504.0-B-1 and
//! 504.0-B-2).
//!
//! REF_FRAME_A is the reference frame and REF_FRAME_B the body frame. The attitude of B as seen
//! from A has a quaternion with the same components as in plan files, scalar last. Rates are those
//! of the body, in body axes, in deg/s. AEM 1.0 is written with the derivative of the quaternion
//! instead of rates, because readers interpret its QUATERNION/RATE in two ways.
//!
//! # Where does an AEM start a new block?
//!
//! A new block starts at every node at which an input switches. The standard forbids interpolation
//! across blocks, and a cubic across a switching time has an error due to the jump of the
//! acceleration. Adjacent blocks share the node between them, so that both arcs can be interpolated
//! to their ends. The reader of this program uses the shared row once, and rejects two different
//! attitudes at one time. A plan with smoothed inputs has no arcs and is one block.
//!
//! # Why is AEM 1.0 written with derivatives of the quaternion?
//!
//! Some readers interpret `QUATERNION/RATE` of version 1.0 as body rates, others (Orekit) as Euler
//! angle rates. The derivative is unambiguous, and readers can compute the rate from it. Such rates
//! are ignored when an AEM 1.0 is read.

use super::{Record, digits, six_of_inertia};
use crate::export::ExportError;
use std::io::Write;
use std::ops::RangeInclusive;

/// Version of a CCSDS attitude ephemeris message (AEM).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AemVersion {
    /// Version 1.0 of the AEM (CCSDS 504.0-B-1), for older programs.
    One,
    /// Version 2.0 of the AEM (CCSDS 504.0-B-2).
    Two,
}

type Written = Result<(), ExportError>;

/// Writes the keys with which every message begins; `first` is the key with the version.
fn header(record: &Record<'_>, first: &str, output: &mut dyn Write) -> Written {
    writeln!(output, "{first}")?;
    writeln!(output, "COMMENT {}", record.name())?;
    for note in &record.notes {
        writeln!(output, "COMMENT {note}")?;
    }
    writeln!(output, "CREATION_DATE = {}", record.created.calendar_text())?;
    writeln!(output, "ORIGINATOR = {}\n", record.identity.originator.as_deref().unwrap_or("UNKNOWN"))?;
    Ok(())
}

/// Writes the name, the identifier and the central body of the object.
fn object(record: &Record<'_>, output: &mut dyn Write) -> Written {
    writeln!(output, "OBJECT_NAME = {}", record.object())?;
    writeln!(output, "OBJECT_ID = {}", record.identity.object_id.as_deref().unwrap_or("UNKNOWN"))?;
    if let Some(center) = &record.identity.center {
        writeln!(output, "CENTER_NAME = {center}")?;
    }
    Ok(())
}

/// Writes the names of the reference frame (A) and of the body frame (B).
fn frames(record: &Record<'_>, output: &mut dyn Write) -> Written {
    writeln!(output, "REF_FRAME_A = {}", record.identity.reference_frame())?;
    writeln!(output, "REF_FRAME_B = {}", record.identity.body_frame())?;
    Ok(())
}

/// Writes an attitude ephemeris message. Each smooth piece of the motion is a block of metadata and
/// data, because readers must not interpolate across blocks. Two adjacent blocks share the node
/// between them.
pub(super) fn write_aem(record: &Record<'_>, version: AemVersion, output: &mut dyn Write) -> Written {
    let number = if version == AemVersion::One { "1.0" } else { "2.0" };
    header(record, &format!("CCSDS_AEM_VERS = {number}"), output)?;
    record.pieces().try_for_each(|nodes| write_block(record, version, nodes, output))
}

/// Writes one block of the ephemeris.
fn write_block(
    record: &Record<'_>,
    version: AemVersion,
    nodes: RangeInclusive<usize>,
    output: &mut dyn Write,
) -> Written {
    let (epoch, time) = (record.epoch()?, &record.trajectory.time);
    let date = |k: usize| epoch.after(time[k]).calendar_text();
    let apart = if *nodes.start() > 0 { "\n" } else { "" };
    writeln!(output, "{apart}META_START")?;
    object(record, output)?;
    frames(record, output)?;
    if version == AemVersion::One {
        writeln!(output, "ATTITUDE_DIR = A2B")?;
    }
    writeln!(output, "TIME_SYSTEM = {}", epoch.scale().name())?;
    writeln!(output, "START_TIME = {}\nSTOP_TIME = {}", date(*nodes.start()), date(*nodes.end()))?;
    match version {
        AemVersion::One => writeln!(output, "ATTITUDE_TYPE = QUATERNION/DERIVATIVE\nQUATERNION_TYPE = LAST")?,
        AemVersion::Two => {
            let body = record.identity.body_frame();
            writeln!(output, "ATTITUDE_TYPE = QUATERNION/ANGVEL\nANGVEL_FRAME = {body}")?;
        }
    }
    writeln!(output, "INTERPOLATION_METHOD = HERMITE\nINTERPOLATION_DEGREE = 3\nMETA_STOP\n\nDATA_START")?;
    for k in nodes {
        let [w, x, y, z] = record.named_quaternion(k);
        let rate = record.rate(k);
        let of_rate = match version {
            AemVersion::Two => (rate.map(f64::to_degrees)).iter().map(|part| digits(*part)).collect(),
            AemVersion::One => {
                // q̇ = ½ q ⊗ (0, Ω), scalar last.
                let vector = slewkit::Vector3::new(x, y, z);
                let moved = 0.5 * (w * rate + vector.cross(&rate));
                let parts = [moved.x, moved.y, moved.z, -0.5 * vector.dot(&rate)];
                parts.map(digits).to_vec()
            }
        };
        let attitude = [x, y, z, w].map(digits).join(" ");
        writeln!(output, "{} {attitude} {}", date(k), of_rate.join(" "))?;
    }
    writeln!(output, "DATA_STOP")?;
    Ok(())
}

/// Writes an attitude parameter message: attitude, rate and inertia at the start, and the torque of
/// each step of the plan, which is constant over the step.
pub(super) fn write_apm(record: &Record<'_>, output: &mut dyn Write) -> Written {
    header(record, "CCSDS_APM_VERS = 2.0", output)?;
    let (epoch, time) = (record.epoch()?, &record.trajectory.time);
    if record.trajectory.torque.len() + 1 < time.len() {
        return Err(super::Lacking::Inputs.into());
    }
    // Unlike an AEM, this message has no META_START and META_STOP (504.0-B-2, figure G-1).
    object(record, output)?;
    writeln!(output, "TIME_SYSTEM = {}\n", epoch.scale().name())?;
    writeln!(output, "EPOCH = {}\n\nQUAT_START", epoch.after(time[0]).calendar_text())?;
    frames(record, output)?;
    let [w, x, y, z] = record.named_quaternion(0);
    for (name, part) in [("Q1", x), ("Q2", y), ("Q3", z), ("QC", w)] {
        writeln!(output, "{name} = {}", digits(part))?;
    }
    writeln!(output, "QUAT_STOP\n\nANGVEL_START")?;
    frames(record, output)?;
    let body = record.identity.body_frame();
    writeln!(output, "ANGVEL_FRAME = {body}")?;
    let rate = record.rate(0).map(f64::to_degrees);
    for (name, part) in ["ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"].iter().zip(rate.iter()) {
        writeln!(output, "{name} = {} [deg/s]", digits(*part))?;
    }
    writeln!(output, "ANGVEL_STOP\n\nINERTIA_START\nINERTIA_REF_FRAME = {body}")?;
    for (name, value) in six_of_inertia(record.problem) {
        writeln!(output, "{name} = {} [kg*m**2]", digits(value))?;
    }
    writeln!(output, "INERTIA_STOP")?;
    for k in 0..time.len() - 1 {
        let torque = record.trajectory.held_torque(k);
        writeln!(output, "\nMAN_START\nMAN_EPOCH_START = {}", epoch.after(time[k]).calendar_text())?;
        writeln!(output, "MAN_DURATION = {} [s]\nMAN_REF_FRAME = {body}", digits(time[k + 1] - time[k]))?;
        for (name, part) in ["MAN_TOR_X", "MAN_TOR_Y", "MAN_TOR_Z"].iter().zip(torque.iter()) {
            writeln!(output, "{name} = {} [N*m]", digits(*part))?;
        }
        writeln!(output, "MAN_STOP")?;
    }
    Ok(())
}
