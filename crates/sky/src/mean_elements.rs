//! The mean elements of an orbit, as catalogues publish them.

/// Mean elements of SGP4, as two-line elements and orbit mean-elements messages (OMM) have them:
/// TEME, UTC.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanElements {
    /// The epoch: its year, the day of the year, from 1, and nanoseconds into the day.
    pub year: i32,
    /// The day of the year, from 1.
    pub day_of_year: u32,
    /// The time of the day \[ns\], below the length of a day.
    pub nanoseconds_of_day: u64,
    /// Revolutions a day, by Kozai.
    pub mean_motion: f64,
    /// The eccentricity, at least 0 and below 1.
    pub eccentricity: f64,
    /// The inclination \[deg\].
    pub inclination_deg: f64,
    /// Right ascension of the ascending node \[deg\].
    pub raan_deg: f64,
    /// The argument of perigee \[deg\].
    pub argument_of_perigee_deg: f64,
    /// The mean anomaly \[deg\].
    pub mean_anomaly_deg: f64,
    /// B*, per radius of the Earth.
    pub drag: f64,
}
