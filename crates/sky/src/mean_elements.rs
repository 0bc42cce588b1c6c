//! Mean orbital elements, as published in catalogues.

/// Mean elements for SGP4, as contained in two-line elements and in orbit mean-elements messages
/// (OMM). The frame is TEME; the time scale is UTC.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanElements {
    /// Year of the epoch.
    pub year: i32,
    /// Day of the year of the epoch, counted from 1.
    pub day_of_year: u32,
    /// Time of day of the epoch \[ns\].
    pub nanoseconds_of_day: u64,
    /// Mean motion in the definition of Kozai \[revolutions per day\].
    pub mean_motion: f64,
    /// Eccentricity, at least 0 and less than 1.
    pub eccentricity: f64,
    /// Inclination \[deg\].
    pub inclination_deg: f64,
    /// Right ascension of the ascending node \[deg\].
    pub raan_deg: f64,
    /// Argument of perigee \[deg\].
    pub argument_of_perigee_deg: f64,
    /// Mean anomaly \[deg\].
    pub mean_anomaly_deg: f64,
    /// Drag term B* \[1/Earth radius\].
    pub drag: f64,
}
