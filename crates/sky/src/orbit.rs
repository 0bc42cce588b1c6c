//! Orbits of satellites. An orbit is given by mean elements for SGP4 (such as two-line elements),
//! by a state that is propagated with or without the Earth's oblateness (J2), or by a table of
//! positions.

use crate::frames::{self, EARTH_RADIUS_M, Theory};
use crate::mean_elements::MeanElements;
use crate::time::Clock;
use crate::two_lines::{self, TwoLinesError};
use sgp4::chrono::{Datelike, Timelike};
use slewkit::numerics::polynomial;
use slewkit::{Matrix3, Vector3};
use std::sync::Arc;
use thiserror::Error;

/// Gravitational parameter of the Earth \[m³/s²\].
const MU: f64 = 3.986_004_418e14;
/// Second zonal harmonic J₂ of the Earth's gravity field.
const J2: f64 = 1.082_626_68e-3;

/// Largest time between the epoch of a state and the epoch of the maneuver \[s\]. After this time,
/// the error of the J2 model is hundreds of kilometres.
const OLDEST: f64 = 30.0 * 86_400.0;

/// Force model with which an osculating state is propagated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// Gravity of a point mass.
    TwoBody,
    /// Gravity of the oblate Earth (J₂). The pole of the Earth has a fixed direction, its direction
    /// at the epoch of the state.
    J2,
}

/// Osculating Keplerian elements of an orbit about the Earth. The angles refer to the axes of the
/// GCRS.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elements {
    /// Semi-major axis \[m\].
    pub semi_major_axis_m: f64,
    /// Eccentricity, at least 0 and less than 1.
    pub eccentricity: f64,
    /// Inclination \[deg\].
    pub inclination_deg: f64,
    /// Right ascension of the ascending node \[deg\].
    pub raan_deg: f64,
    /// Argument of perigee \[deg\].
    pub argument_of_perigee_deg: f64,
    /// True anomaly \[deg\].
    pub true_anomaly_deg: f64,
}

/// Reason why an orbit, or a position on it, cannot be computed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum OrbitError {
    /// The two lines are not valid two-line elements.
    #[error("the two-line elements are wrong: {0}")]
    TwoLines(#[from] TwoLinesError),
    /// SGP4 rejects these mean elements.
    #[error("SGP4 refuses these elements: {0}")]
    MeanElements(String),
    /// SGP4 yields no position at this time \[s\], which is counted from the epoch of the maneuver.
    /// The usual cause is that the orbit has decayed.
    #[error("SGP4 has no position {0:.0} s after the epoch: the orbit decays")]
    Decays(f64),
    /// The orbit is not an ellipse, for the reason given.
    #[error("the orbit is not an ellipse: {0}")]
    NoEllipse(&'static str),
    /// The perigee is below the surface of the Earth, at the given depth \[km\].
    #[error("the perigee is {0:.0} km below the ground")]
    Underground(f64),
    /// The epoch of the state is too far from the epoch of the maneuver. The number is the time
    /// between them \[days\].
    #[error("the epoch of the orbit is {0:.0} days from the epoch of the maneuver; at most 30 are allowed")]
    Old(f64),
    /// The table of positions does not cover this time \[s\], which is counted from the epoch of
    /// the maneuver.
    #[error("the table of positions does not extend to {0:.1} s after the epoch")]
    Beyond(f64),
}

/// Orbit of a satellite, which gives its position in GCRS axes \[m\] as a function of the time
/// after the epoch of the maneuver \[s\].
#[derive(Clone, Debug)]
pub struct Orbit {
    path: Path,
    /// Time from the epoch of the orbit to the epoch of the maneuver \[s\].
    ahead: f64,
    clock: Clock,
}

#[derive(Clone, Debug)]
enum Path {
    TwoLines(Arc<sgp4::Constants>),
    State { position: Vector3, velocity: Vector3, model: Model, pole: Vector3 },
    Table(Arc<Table>),
}

/// A table of positions, with the interpolation method between its rows.
#[derive(Clone, Debug)]
pub struct Table {
    /// Times of the rows in seconds after the epoch of the maneuver, in increasing order.
    pub time: Vec<f64>,
    /// Position in each row, in the axes of the GCRS \[m\].
    pub position: Vec<Vector3>,
    /// Velocity in each row, in the axes of the GCRS \[m/s\]. Only Hermite interpolation uses it.
    pub velocity: Vec<Vector3>,
    /// Interpolation method between the rows.
    pub between: Between,
}

/// Interpolation method between the rows of a table, with the degree of the polynomial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// Lagrange interpolation of the positions by a polynomial of this degree.
    Lagrange(usize),
    /// Hermite interpolation of positions and velocities by a polynomial of this degree. Each row
    /// gives two conditions, so an even degree is increased by one.
    Hermite(usize),
}

impl Between {
    /// Returns the number of rows through which a polynomial passes.
    pub fn rows(self) -> usize {
        match self {
            Self::Lagrange(degree) => degree + 1,
            Self::Hermite(degree) => (degree + 1).div_ceil(2),
        }
    }
}

impl Table {
    /// Returns the interpolated position at `time` in GCRS axes \[m\]; `None` if the table does not
    /// cover this time.
    pub fn position(&self, time: f64) -> Option<Vector3> {
        // A time counts as inside of the table if it is outside by no more than the round-off of
        // sums of seconds.
        const ROUNDED: f64 = 1e-6;
        let (first, last) = (*self.time.first()?, *self.time.last()?);
        if !(first - ROUNDED..=last + ROUNDED).contains(&time) {
            return None;
        }
        let count = self.between.rows().min(self.time.len());
        let from = polynomial::about(&self.time, count, time);
        let rows = from..from + count;
        // Times are counted from the first row that is used, to preserve their digits.
        let nodes: Vec<f64> = self.time[rows.clone()].iter().map(|at| at - self.time[from]).collect();
        let of = |vectors: &[Vector3]| -> Vec<[f64; 3]> {
            vectors[rows.clone()].iter().map(|vector| (*vector).into()).collect()
        };
        let slopes = matches!(self.between, Between::Hermite(_)).then(|| of(&self.velocity));
        let found =
            polynomial::through(&nodes, &of(&self.position), slopes.as_deref(), time - self.time[from]);
        found.map(Vector3::from)
    }
}

impl Orbit {
    /// Creates an orbit from two-line elements, to be propagated by SGP4. `clock` is the epoch of
    /// the maneuver.
    ///
    /// # Errors
    /// [`OrbitError::TwoLines`] with the columns and the reason if the lines are invalid; otherwise
    /// the errors of [`Orbit::of_mean_elements`].
    pub fn of_two_lines(lines: [&str; 2], clock: Clock) -> Result<Self, OrbitError> {
        Self::of_mean_elements(&two_lines::read(lines)?, clock)
    }

    /// Creates an orbit from mean elements, to be propagated by SGP4. `clock` is the epoch of the
    /// maneuver.
    ///
    /// # Errors
    /// [`OrbitError::MeanElements`] if SGP4 rejects the elements, or if their epoch is not a date
    /// of the calendar.
    pub fn of_mean_elements(mean: &MeanElements, clock: Clock) -> Result<Self, OrbitError> {
        let wrong = |error: &dyn std::fmt::Display| OrbitError::MeanElements(error.to_string());
        let seconds = (mean.nanoseconds_of_day / 1_000_000_000) as u32;
        let nanoseconds = (mean.nanoseconds_of_day % 1_000_000_000) as u32;
        let [hour, minute, second] = [seconds / 3600, seconds / 60 % 60, seconds % 60];
        let date = sgp4::chrono::NaiveDate::from_yo_opt(mean.year, mean.day_of_year);
        let moment = date.and_then(|date| {
            // A time of day that is rounded up to 24 h belongs to the next day.
            let (date, hour) = if hour > 23 { (date.succ_opt()?, 0) } else { (date, hour) };
            date.and_hms_nano_opt(hour, minute, second, nanoseconds)
        });
        let datetime = moment.ok_or_else(|| wrong(&"their epoch is not a valid UTC time"))?;
        // The crate `sgp4` ignores leap seconds, so the epoch is converted through TAI.
        let date = [datetime.year(), datetime.month() as i32, datetime.day() as i32];
        let epoch = Clock::of_utc(date, datetime.hour() as u8, minute as u8, second as u8, nanoseconds);
        let epoch = epoch.ok_or_else(|| wrong(&"their epoch is not a valid UTC time"))?;
        let elements = sgp4::Elements {
            object_name: None,
            international_designator: None,
            norad_id: 0,
            classification: sgp4::Classification::Unclassified,
            datetime,
            mean_motion_dot: 0.0,
            mean_motion_ddot: 0.0,
            drag_term: mean.drag,
            element_set_number: 0,
            inclination: mean.inclination_deg,
            right_ascension: mean.raan_deg,
            eccentricity: mean.eccentricity,
            argument_of_perigee: mean.argument_of_perigee_deg,
            mean_anomaly: mean.mean_anomaly_deg,
            mean_motion: mean.mean_motion,
            revolution_number: 0,
            ephemeris_type: 0,
        };
        let constants =
            sgp4::Constants::from_elements_afspc_compatibility_mode(&elements).map_err(|e| wrong(&e))?;
        Ok(Self { path: Path::TwoLines(constants.into()), ahead: clock.since(&epoch), clock })
    }

    /// Creates an orbit from a position \[m\] and a velocity \[m/s\] at `epoch`, in the axes of the
    /// GCRS. `clock` is the epoch of the maneuver.
    ///
    /// # Errors
    /// [`OrbitError::NoEllipse`] if the state is not on an ellipse; [`OrbitError::Underground`] if
    /// the perigee is below the surface; [`OrbitError::Old`] if the epochs are more than 30 days
    /// apart.
    pub fn of_state(
        position: Vector3,
        velocity: Vector3,
        model: Model,
        epoch: Clock,
        clock: Clock,
    ) -> Result<Self, OrbitError> {
        let (r, energy) = (position.norm(), 0.5 * velocity.norm_squared() - MU / position.norm());
        if !(r > 0.0 && energy.is_finite()) {
            return Err(OrbitError::NoEllipse("position and velocity must be finite, and not zero"));
        }
        if energy >= 0.0 {
            return Err(OrbitError::NoEllipse("the velocity exceeds the escape velocity"));
        }
        let momentum = position.cross(&velocity).norm_squared();
        let axis = -0.5 * MU / energy;
        let eccentricity = (1.0 - momentum / (MU * axis)).max(0.0).sqrt();
        let below = EARTH_RADIUS_M - axis * (1.0 - eccentricity);
        if below > 0.0 {
            return Err(OrbitError::Underground(below / 1e3));
        }
        let ahead = clock.since(&epoch);
        let recent = ahead.abs() <= OLDEST;
        if !recent {
            return Err(OrbitError::Old(ahead / 86_400.0));
        }
        let pole = frames::intermediate(&epoch, 0.0, Theory::Series).row(2).transpose();
        // The state is propagated once to the epoch of the maneuver. Later calls then only
        // propagate over the time since this epoch.
        let (position, velocity) = match model {
            Model::TwoBody => kepler(&position, &velocity, ahead),
            Model::J2 => extrapolated(&position, &velocity, ahead, &pole),
        };
        Ok(Self { path: Path::State { position, velocity, model, pole }, ahead, clock })
    }

    /// Creates an orbit from osculating elements at `epoch`. `clock` is the epoch of the maneuver.
    ///
    /// # Errors
    /// Returns the errors of [`Orbit::of_state`]; [`OrbitError::NoEllipse`] also if the semi-major
    /// axis or the eccentricity is out of range.
    pub fn of_elements(
        elements: &Elements,
        model: Model,
        epoch: Clock,
        clock: Clock,
    ) -> Result<Self, OrbitError> {
        let Elements { semi_major_axis_m: a, eccentricity: e, .. } = *elements;
        if !(a > 0.0 && a.is_finite() && (0.0..1.0).contains(&e)) {
            return Err(OrbitError::NoEllipse(
                "the semi-major axis must be positive, the eccentricity from 0 to below 1",
            ));
        }
        let about = |axis: Vector3, degrees: f64| slewkit::lie::exp(&(axis * degrees.to_radians()));
        let (x, z) = (Vector3::x(), Vector3::z());
        let plane: Matrix3 = about(z, elements.raan_deg)
            * about(x, elements.inclination_deg)
            * about(z, elements.argument_of_perigee_deg);
        let (sin, cos) = elements.true_anomaly_deg.to_radians().sin_cos();
        let parameter = a * (1.0 - e * e);
        let position = plane * Vector3::new(cos, sin, 0.0) * (parameter / (1.0 + e * cos));
        let velocity = plane * Vector3::new(-sin, e + cos, 0.0) * (MU / parameter).sqrt();
        Self::of_state(position, velocity, model, epoch, clock)
    }

    /// Creates an orbit from a table of positions. `clock` is the epoch of the maneuver.
    ///
    /// # Errors
    /// [`OrbitError::Beyond`] if the table has fewer rows than the interpolation needs, if its
    /// columns differ in length, or if its times do not increase.
    pub fn of_table(table: Table, clock: Clock) -> Result<Self, OrbitError> {
        let Table { time, position, velocity, between } = &table;
        let rises = time.windows(2).all(|pair| pair[1] > pair[0]);
        let short = time.len() < between.rows();
        if time.len() != position.len() || time.len() != velocity.len() || short || !rises {
            return Err(OrbitError::Beyond(0.0));
        }
        Ok(Self { path: Path::Table(table.into()), ahead: 0.0, clock })
    }

    /// Returns whether the orbit is given by a table of positions, and so has no orbital elements.
    pub fn is_table(&self) -> bool {
        matches!(self.path, Path::Table(_))
    }

    /// Returns the time from the epoch of the elements or the state to the epoch of the maneuver
    /// \[s\]; 0 for a table.
    pub fn age(&self) -> f64 {
        self.ahead
    }

    /// Returns the position at `time` \[s\] after the epoch of the maneuver, in the axes of the
    /// GCRS \[m\].
    ///
    /// # Errors
    /// [`OrbitError::Decays`] if SGP4 yields no position; [`OrbitError::Beyond`] outside of a
    /// table.
    pub fn position(&self, time: f64) -> Result<Vector3, OrbitError> {
        self.position_by(time, Theory::Series)
    }

    pub(crate) fn position_by(&self, time: f64, theory: Theory) -> Result<Vector3, OrbitError> {
        match &self.path {
            Path::TwoLines(constants) => {
                let at = sgp4::MinutesSinceEpoch((self.ahead + time) / 60.0);
                let found = constants.propagate_afspc_compatibility_mode(at);
                let found = found.map_err(|_| OrbitError::Decays(time))?;
                let position = Vector3::from(found.position) * 1e3;
                if !position.iter().all(|x| x.is_finite()) || position.norm() < EARTH_RADIUS_M {
                    return Err(OrbitError::Decays(time));
                }
                Ok(frames::from_teme(&self.clock, time, theory) * position)
            }
            Path::State { position, velocity, model: Model::TwoBody, .. } => {
                Ok(kepler(position, velocity, time).0)
            }
            Path::State { position, velocity, model: Model::J2, pole } => {
                Ok(extrapolated(position, velocity, time, pole).0)
            }
            Path::Table(table) => table.position(time).ok_or(OrbitError::Beyond(time)),
        }
    }

    /// Returns the period of the Keplerian orbit through the state at the epoch of the
    /// maneuver \[s\].
    ///
    /// # Errors
    /// Returns the errors of [`Orbit::position`].
    pub fn period(&self) -> Result<f64, OrbitError> {
        const STEP: f64 = 1.0;
        let at = |time: f64| self.position(time);
        let (before, here, after) = (at(0.0)?, at(STEP)?, at(2.0 * STEP)?);
        let velocity = (after - before) / (2.0 * STEP);
        let axis = 1.0 / (2.0 / here.norm() - velocity.norm_squared() / MU);
        Ok(std::f64::consts::TAU * (axis.powi(3) / MU).sqrt())
    }
}

/// Propagates a position \[m\] and a velocity \[m/s\] by `time` \[s\] under the gravity of a point
/// mass, in GCRS axes. Returns the propagated state, and an estimate of the change of position that
/// the Earth's oblateness causes \[m\]. Returns `None` if the orbit is not an ellipse.
pub fn two_body(position: &Vector3, velocity: &Vector3, time: f64) -> Option<((Vector3, Vector3), f64)> {
    let r = position.norm();
    let energy = 0.5 * velocity.norm_squared() - MU / r;
    if !(r > 0.0 && energy < 0.0) {
        return None;
    }
    let flattening = 1.5 * J2 * MU * (EARTH_RADIUS_M / (r * r)).powi(2);
    Some((kepler(position, velocity, time), flattening * time * time))
}

/// Propagates a state by `time` \[s\] along a Keplerian ellipse. The unknown x of Kepler's equation
/// is the change of the eccentric anomaly.
fn kepler(position: &Vector3, velocity: &Vector3, time: f64) -> (Vector3, Vector3) {
    let r = position.norm();
    let axis = 1.0 / (2.0 / r - velocity.norm_squared() / MU);
    let n = (MU / axis.powi(3)).sqrt();
    let cosine = 1.0 - r / axis;
    let sine = position.dot(velocity) / (MU * axis).sqrt();
    let turns = (n * time / std::f64::consts::TAU).trunc();
    let mean = n * time - turns * std::f64::consts::TAU;
    // Kepler's equation for the change x: x − e cos E₀ sin x + e sin E₀ (1 − cos x) = M.
    let mut x = mean;
    for _ in 0..50 {
        let value = x - cosine * x.sin() + sine * (1.0 - x.cos()) - mean;
        let slope = 1.0 - cosine * x.cos() + sine * x.sin();
        let step = value / slope;
        x -= step.clamp(-1.0, 1.0);
        if step.abs() <= 1e-15 * (1.0 + x.abs()) {
            break;
        }
    }
    let f = 1.0 - axis / r * (1.0 - x.cos());
    let g = (mean - (x - x.sin())) / n;
    let there = position * f + velocity * g;
    let far = there.norm();
    let (f_rate, g_rate) = (-(MU * axis).sqrt() / (far * r) * x.sin(), 1.0 - axis / far * (1.0 - x.cos()));
    (there, position * f_rate + velocity * g_rate)
}

/// Propagates a state by `time` \[s\] about the oblate Earth, in steps of a minute. Each step uses
/// the midpoint rule with Richardson extrapolation to order sixteen.
fn extrapolated(position: &Vector3, velocity: &Vector3, time: f64, pole: &Vector3) -> (Vector3, Vector3) {
    const STEP: f64 = 60.0;
    const STAGES: usize = 8;
    let acceleration = |r: &Vector3| {
        let (square, along) = (r.norm_squared(), r.dot(pole));
        let central = -MU / (square * square.sqrt());
        let ratio = EARTH_RADIUS_M * EARTH_RADIUS_M / square;
        let flat = 1.5 * J2 * ratio;
        (r * (1.0 + flat * (1.0 - 5.0 * along * along / square)) + pole * (2.0 * flat * along)) * central
    };
    let count = (time.abs() / STEP).ceil().max(1.0);
    let step = time / count;
    let (mut r, mut v) = (*position, *velocity);
    for _ in 0..count as usize {
        let mut table: Vec<(Vector3, Vector3)> = Vec::with_capacity(STAGES);
        for stage in 1..=STAGES {
            let parts = 2 * stage;
            let h = step / parts as f64;
            let (mut before, mut here) = ((r, v), (r + v * h, v + acceleration(&r) * h));
            for _ in 1..parts {
                let next = (before.0 + here.1 * (2.0 * h), before.1 + acceleration(&here.0) * (2.0 * h));
                (before, here) = (here, next);
            }
            let last = acceleration(&here.0);
            let mut value = ((before.0 + here.0 + here.1 * h) * 0.5, (before.1 + here.1 + last * h) * 0.5);
            // Neville's algorithm extrapolates in the square of the step.
            for column in 1..stage {
                let ratio = (stage as f64 / (stage - column) as f64).powi(2);
                let left = table[column - 1];
                let next = (
                    value.0 + (value.0 - left.0) / (ratio - 1.0),
                    value.1 + (value.1 - left.1) / (ratio - 1.0),
                );
                table[column - 1] = value;
                value = next;
            }
            table.push(value);
        }
        if let Some(found) = table.last() {
            (r, v) = *found;
        }
    }
    (r, v)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Function that propagates a state, given as position and velocity, by a time in seconds.
    type Onward<'a> = dyn Fn((Vector3, Vector3), f64) -> (Vector3, Vector3) + 'a;

    /// Propagation over two successive intervals agrees with propagation over their sum. Backward
    /// propagation returns to the initial state.
    #[test]
    fn an_orbit_goes_on_from_each_of_its_states() {
        let (r, v) = (Vector3::new(7.1e6, 1e5, -3e5), Vector3::new(-100.0, 5.2e3, 5.6e3));
        let pole = Vector3::new(0.0, 0.6, 0.8);
        let onward: [&Onward<'_>; 2] =
            [&|(r, v), time| kepler(&r, &v, time), &|(r, v), time| extrapolated(&r, &v, time, &pole)];
        for along in onward {
            let direct = along((r, v), 9000.0);
            let by_parts = along(along((r, v), 3700.0), 5300.0);
            let back = along(direct, -9000.0);
            assert!((direct.0 - by_parts.0).norm() < 1e-3, "{}", (direct.0 - by_parts.0).norm());
            assert!((back.0 - r).norm() < 1e-3 && (back.1 - v).norm() < 1e-6);
            let (before, after) = (along((r, v), 8999.5).0, along((r, v), 9000.5).0);
            assert!((after - before - direct.1).norm() < 1e-3);
        }
        // The oblateness changes the position by kilometres in this time.
        assert!((onward[0]((r, v), 9000.0).0 - onward[1]((r, v), 9000.0).0).norm() > 1e3);
    }

    /// Tests the interpolation of degree 7 between rows that are one minute apart.
    #[test]
    fn a_table_is_met_between_its_rows() {
        let (r, v) = (Vector3::new(7e6, 0.0, 0.0), Vector3::new(0.0, 7.5e3, 1e3));
        let clock = Clock::of_utc([2026, 11, 21], 7, 0, 0, 0).unwrap();
        for between in [Between::Lagrange(7), Between::Hermite(7)] {
            let time: Vec<f64> = (0..20).map(|row| 60.0 * f64::from(row)).collect();
            let (position, velocity) = time.iter().map(|t| kepler(&r, &v, *t)).unzip();
            let orbit = Orbit::of_table(Table { time, position, velocity, between }, clock).unwrap();
            for t in [0.0, 31.0, 570.0, 1139.9, 1140.0] {
                let off = (orbit.position(t).unwrap() - kepler(&r, &v, t).0).norm();
                assert!(off < 1e-3, "{t} {off:.1e}");
            }
            assert_eq!(orbit.position(1140.1), Err(OrbitError::Beyond(1140.1)));
        }
    }
}
