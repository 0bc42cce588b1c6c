//! Files for and from other programs: CCSDS attitude messages, SPICE kernels, STK, NumPy, MATLAB,
//! tables.
//!
//! Every format is written from one [`Record`], which has the trajectory, its names and its epoch.
//! The formats differ in the conventions of quaternions and rates. With the rotation `R` from body
//! to reference components and its quaternion `q`:
//!
//! | format | quaternion | order | rate |
//! |---|---|---|---|
//! | CCSDS, A = reference, B = body | `q` | scalar last | body axes, deg/s |
//! | STK `.a` | `q` | scalar last | body axes, deg/s |
//! | SPICE CK | `q*`: its C-matrix leads from reference to body | scalar first | reference axes, rad/s |
//! | 42 | `q` | scalar last | body axes, rad/s |
//! | Basilisk | modified Rodrigues parameters of `q` | | reference axes, rad/s |
//! | NumPy, MATLAB, Parquet, flight table | `q` | scalar first | body axes, rad/s |
//!
//! Rates describe the motion of the body relative to the reference frame: if this frame turns, its
//! rate is subtracted. Attitudes relative to an orbital frame are written in the axes of the named
//! frame ([`frames`]). Simulators support inertial frames only. If the reference frame turns, their
//! tables refer to this frame at time zero, which is inertial, and the rates are inertial. Numbers
//! have 17 significant digits and read back to the same bits.
//!
//! # Why are exchange formats written by hand?
//!
//! | what we write ourselves | kept library | why |
//! |---|---|---|
//! | AEM, APM (`ccsds.rs`, `xml.rs`, 200 lines) | ccsds-ndm 0.0.9 | rejects version 1.0, costs two minutes of build; Orekit reads ours in the tests |
//! | reader of AEM, OEM, OMM and APM (`reading/`) | the same | errors with line and remedy, direction and order of both versions; their XML by roxmltree |
//! | CK (`spice/`, 200 lines) | CSPICE, rsspice | a C library or a translation of all of it, for one segment; SPICE reads ours in the tests |
//! | `.npz` and its ZIP (110 lines) | ndarray-npy, zip | arrays of another crate and a compressor for a stored archive |
//! | `.mat` version 5 (60 lines) | none kept | |
//! | CRC-32 (5 lines) | crc32fast | a table of 256 numbers, once a file |
//! | STK, 42, Basilisk, flight table | none | text |
//! | epochs' fraction and second 60 | hifitime otherwise | `epoch.rs` |
//!
//! The crate `parquet` writes Parquet files, without any of its own features. It adds thirteen
//! crates to the 112 of the program (`cargo tree -e normal -p slewkit-cli --features parquet`). It
//! is therefore optional, and CSV and NumPy files hold the same table. A program without the
//! feature knows the format name, and its message states how to build the feature.

mod ccsds;
mod compared;
mod flight;
pub mod frames;
mod lacking;
mod matlab;
mod numpy;
mod numpy_reading;
#[cfg(feature = "parquet")]
pub(crate) mod parquet;
mod reading;
mod record;
mod simulators;
mod spice;
mod stk;
mod xml;

pub use ccsds::AemVersion;
pub use compared::{FileReport, judge_file};
pub(crate) use compared::{into_our_frame, of_our_body};
pub use lacking::Lacking;
pub use numpy::Arrays;
pub use numpy_reading::{Array, read_arrays};
pub use reading::{
    AttitudeTold, Attitudes, Between, Block, EphemerisAxes, Refined, Segment, read_attitudes,
    read_attitudes_at, read_ephemeris, read_mean_elements,
};
pub(crate) use reading::{Piece, Wrong, elements, whole_text};
pub use record::{Record, Tables};
pub(crate) use xml::{Xml, escaped};

use super::export::ExportError;
use slewkit::maneuver::Problem;
use std::io::Write;

/// A file format of another program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// CCSDS attitude ephemeris message (AEM) in keyword notation.
    Aem(AemVersion),
    /// CCSDS attitude ephemeris message (AEM), version 2, in XML.
    AemXml,
    /// CCSDS attitude parameter message (APM): initial state, inertia and the torque of every step.
    Apm,
    /// Attitude file of STK.
    Stk,
    /// C-kernel of SPICE: binary, type 3.
    Ck,
    /// Clock kernel that belongs to the SPICE C-kernel.
    Sclk,
    /// Frame kernel that belongs to the SPICE C-kernel.
    Fk,
    /// Archive of NumPy arrays.
    Npz,
    /// MATLAB file of version 5.
    Mat,
    /// Parquet table with the columns of CSV; requires the feature `parquet`.
    Parquet,
    /// Waypoint table for Basilisk.
    Basilisk,
    /// Table for the simulator 42: time, quaternion, rate.
    FortyTwo,
    /// Table for on-board use, with equal ticks, a checksum and the interpolation error.
    Flight,
}

impl Format {
    /// Checks that the maneuver has all data that the format requires.
    ///
    /// # Errors
    /// Returns the first missing item.
    pub fn check(self, record: &Record<'_>) -> Result<(), Lacking> {
        let (identity, spice) = (&record.identity, matches!(self, Self::Ck | Self::Sclk | Self::Fk));
        let ccsds = matches!(self, Self::Aem(_) | Self::AemXml | Self::Apm);
        let dated = ccsds || matches!(self, Self::Stk | Self::Ck | Self::Sclk);
        if dated && identity.epoch.is_none() {
            return Err(Lacking::Epoch);
        }
        let framed = ccsds || matches!(self, Self::Stk | Self::Ck);
        if framed && record.turns() {
            if !ccsds {
                return Err(Lacking::InertialFrame);
            }
            if record.axes().is_none() {
                return Err(Lacking::FrameName);
            }
        }
        if self == Self::Stk {
            stk::axes(identity).ok_or(Lacking::StkFrame)?;
            stk::central_body(identity.center.as_deref()).ok_or(Lacking::StkCenter)?;
        }
        if self == Self::Parquet && !cfg!(feature = "parquet") {
            return Err(Lacking::Parquet);
        }
        if spice && identity.spice_id.is_none() {
            return Err(Lacking::SpiceId);
        }
        if self == Self::Ck && spice::inertial_frame(identity).is_none() {
            return Err(Lacking::SpiceFrame);
        }
        Ok(())
    }

    /// Writes the record in this format.
    ///
    /// # Errors
    /// Returns an error if data that the format requires are missing, if a number is not finite, or
    /// if the stream fails.
    pub fn write(self, record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
        self.check(record)?;
        record.check_finite()?;
        match self {
            Self::Aem(version) => ccsds::write_aem(record, version, output),
            Self::AemXml => xml::write_aem(record, output),
            Self::Apm => ccsds::write_apm(record, output),
            Self::Stk => stk::write(record, output),
            Self::Ck => spice::write_ck(record, output),
            Self::Sclk => spice::write_sclk(record, output),
            Self::Fk => spice::write_fk(record, output),
            Self::Npz => numpy::write(record, output),
            Self::Mat => matlab::write(record, output),
            #[cfg(feature = "parquet")]
            Self::Parquet => parquet::write_trajectory(record, output),
            #[cfg(not(feature = "parquet"))]
            Self::Parquet => Err(Lacking::Parquet.into()),
            Self::Basilisk => simulators::write_basilisk(record, output),
            Self::FortyTwo => simulators::write_42(record, output),
            Self::Flight => flight::write(record, output),
        }?;
        Ok(output.flush()?)
    }
}

/// Formats a number with 17 significant digits, which read back to the same bits.
fn digits(value: f64) -> String {
    format!("{value:.16e}")
}

/// Returns the six independent elements of the inertia \[kg·m²\], with their names in CCSDS
/// messages.
fn six_of_inertia(problem: &Problem) -> [(&'static str, f64); 6] {
    let j = problem.body.inertia.j();
    [
        ("IXX", j[(0, 0)]),
        ("IYY", j[(1, 1)]),
        ("IZZ", j[(2, 2)]),
        ("IXY", j[(0, 1)]),
        ("IXZ", j[(0, 2)]),
        ("IYZ", j[(1, 2)]),
    ]
}

impl From<std::fmt::Error> for ExportError {
    fn from(error: std::fmt::Error) -> Self {
        Self::Io(std::io::Error::other(error))
    }
}
