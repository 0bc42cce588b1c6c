//! Attitude tables for the simulators Basilisk and 42.
//!
//! - Basilisk's `waypointReference` reads one row for each waypoint: time, modified Rodrigues
//!   parameters σ_RN, and the angular velocity and acceleration in reference axes (the default of
//!   Basilisk). σ is the axis times tan(φ/4) of the shorter rotation.
//! - 42 reads the time, the quaternion of the body relative to the reference frame, scalar last,
//!   and the rate in body axes.
//!
//! Both programs call their frame N and treat it as inertial. If the reference frame of the
//! maneuver turns, N is this frame at time zero.

use super::{Record, digits};
use crate::export::ExportError;
use slewkit::{Vector3, lie};
use std::io::Write;

/// Writes the waypoints for Basilisk as comma-separated values, after one header line.
pub(super) fn write_basilisk(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    writeln!(
        output,
        "time_s,sigma_RN_1,sigma_RN_2,sigma_RN_3,omega_RN_N_1_rad_s,omega_RN_N_2_rad_s,omega_RN_N_3_rad_s,\
         domega_RN_N_1_rad_s2,domega_RN_N_2_rad_s2,domega_RN_N_3_rad_s2"
    )?;
    let time = &record.trajectory.time;
    let rows: Vec<([f64; 4], Vector3)> = (0..record.nodes()).map(|k| record.inertial(k)).collect();
    let rates: Vec<Vector3> =
        rows.iter().map(|(quaternion, rate)| lie::rotation_from_quaternion(quaternion) * rate).collect();
    for (k, ([w, x, y, z], _)) in rows.into_iter().enumerate() {
        let sign = if w < 0.0 { -1.0 } else { 1.0 };
        let sigma = sign * Vector3::new(x, y, z) / (1.0 + w.abs());
        // The acceleration at a node is the difference of the rates at the neighbouring nodes,
        // divided by the time between them.
        let (before, after) = (k.saturating_sub(1), (k + 1).min(time.len() - 1));
        let acceleration = (rates[after] - rates[before]) / (time[after] - time[before]);
        let numbers = [sigma, rates[k], acceleration];
        let cells: Vec<String> =
            numbers.iter().flat_map(|vector| vector.iter().map(|part| digits(*part))).collect();
        writeln!(output, "{},{}", digits(time[k]), cells.join(","))?;
    }
    Ok(())
}

/// Writes the table for the simulator 42: numbers separated by blanks, without a header.
pub(super) fn write_42(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    for k in 0..record.nodes() {
        let ([w, x, y, z], rate) = record.inertial(k);
        let row = [record.trajectory.time[k], x, y, z, w, rate.x, rate.y, rate.z];
        writeln!(output, "{}", row.map(digits).join(" "))?;
    }
    Ok(())
}
