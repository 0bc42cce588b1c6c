//! Data that a maneuver lacks, and formats that the program cannot write.

use thiserror::Error;

/// Reason why a plan cannot be written in an output format.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Lacking {
    /// The format needs calendar times, but the spec has no epoch.
    #[error("this format needs calendar times, but the spec has no epoch")]
    Epoch,
    /// The reference frame turns with the orbit, but the spec does not name an orbital frame.
    #[error(
        "this format needs a name for the rotating orbit frame (e1 along the velocity, e2 along the orbit \
        normal, e3 outward), but the spec does not give one"
    )]
    FrameName,
    /// The reference frame turns with the orbit, but the format supports inertial frames only.
    #[error("the reference frame turns with the orbit, but this format supports only inertial frames")]
    InertialFrame,
    /// STK files do not support the reference frame of the spec.
    #[error(
        "attitude files of STK do not support the reference frame of the spec: they support ICRF \
        (GCRF) and J2000 (EME2000)"
    )]
    StkFrame,
    /// STK does not know the central body of the spec.
    #[error("STK needs the central body as one word, as in Earth or Mars: the center of the spec is not one")]
    StkCenter,
    /// The format needs the NAIF number of the spacecraft, which the spec does not have.
    #[error("SPICE kernels need the NAIF ID of the spacecraft, but the spec does not give `spice_id`")]
    SpiceId,
    /// SPICE does not support the reference frame of the spec.
    #[error(
        "SPICE does not support the reference frame of the spec: it supports J2000 (ICRF, EME2000), \
        B1950 and ECLIPJ2000"
    )]
    SpiceFrame,
    /// The tick does not divide the duration, or the spec gives no tick and the plan has unequal
    /// steps.
    #[error("the duration is not a whole number of ticks, or the steps of the plan are not equal")]
    Tick,
    /// This program was built without the feature `parquet`.
    #[error("this program was built without Parquet")]
    Parquet,
    /// The duration of the plan is zero, but the format needs a motion.
    #[error("this format needs a motion, but the duration of the plan is zero")]
    Duration,
    /// The plan has no inputs, but the format needs the torque of each step.
    #[error("this format needs the torque of each step, but the plan has no torque")]
    Inputs,
    /// The reference frame of the spec is not known to be inertial, as a pointing file requires.
    #[error("a pointing file needs an inertial reference frame: this one is not known to be inertial")]
    PointingFrame,
    /// A PTR needs complete attitudes, but an observation has a free roll or points at the Sun.
    #[error("a PTR needs complete attitudes, but an observation has a free roll or points at the Sun")]
    Roll,
    /// Observations overlap, leave no time for a slew, or do not define an attitude.
    #[error(
        "two observations overlap or leave no time for a slew, or an observation has no attitude: its axes \
        are parallel or are not unit vectors"
    )]
    Observations,
}

impl Lacking {
    /// Returns the stable code of the error.
    pub fn code(self) -> &'static str {
        match self {
            Self::Epoch => "E0140",
            Self::FrameName
            | Self::InertialFrame
            | Self::SpiceFrame
            | Self::StkFrame
            | Self::StkCenter
            | Self::PointingFrame => "E0141",
            Self::SpiceId => "E0142",
            Self::Duration | Self::Inputs | Self::Tick => "E0143",
            Self::Parquet => "E0144",
            Self::Roll | Self::Observations => "E0145",
        }
    }

    /// Returns the remedy for the error.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::Epoch => {
                "write epoch = \"2026-11-21T07:00:00 UTC\" into the spec, or give --set epoch='2026-11-21T07:00:00 UTC'"
            }
            Self::FrameName => {
                "write [names] reference_frame = \"LVLH\" (or VNC, VVLH, RTN, RSW, QSW, NTW, TNW): \
                attitudes are then written in its axes"
            }
            Self::InertialFrame => {
                "write .aem or .xml, in a frame of the orbit; tables for Basilisk and 42 use the \
                frame at the start, which does not turn"
            }
            Self::StkFrame => "write [names] reference_frame = \"J2000\" or \"ICRF\"",
            Self::StkCenter => "write [names] center = \"EARTH\"",
            Self::SpiceFrame => "write [names] reference_frame = \"J2000\"",
            Self::SpiceId => "write [names] spice_id = -125544, or give --set names.spice_id=-125544",
            Self::Tick => {
                "give --tick SECONDS so that the duration is a whole number of ticks, at most ten million; \
                where no tick fits, as in minimum time, plan again with minimize = \"effort\" and a longer \
                duration_s"
            }
            Self::Parquet => {
                "build it with `cargo install --path crates/slew --features parquet` in its sources, or \
                    write .csv or .npz"
            }
            Self::Duration => {
                "give another end or maneuver.duration_s, or write .json or .csv, which hold a \
                single instant"
            }
            Self::Inputs => "give a solved plan",
            Self::PointingFrame => "write [names] reference_frame = \"J2000\" or \"ICRF\"",
            Self::Roll => "plan the sequence, which finds the rolls, or write a PRM",
            Self::Observations => "correct the times and the axes of the observations",
        }
    }
}
