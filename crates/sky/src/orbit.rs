//! Positions of a satellite: two-line elements by SGP4, a Keplerian orbit, one with the Earth's
//! flattening, a table.

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
/// The second zonal harmonic of the Earth.
const J2: f64 = 1.082_626_68e-3;

/// The largest difference between the epoch of a state and the epoch of the maneuver \[s\]. The
/// error of J2 is hundreds of kilometres after more time.
const OLDEST: f64 = 30.0 * 86_400.0;

/// The propagation of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// About a point mass.
    TwoBody,
    /// A motion about the flattened Earth, whose pole is the pole at the epoch.
    J2,
}

/// Osculating Keplerian elements, axes of the GCRS.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elements {
    /// The semi-major axis \[m\].
    pub semi_major_axis_m: f64,
    /// The eccentricity, below 1.
    pub eccentricity: f64,
    /// The inclination \[deg\].
    pub inclination_deg: f64,
    /// Right ascension of the ascending node \[deg\].
    pub raan_deg: f64,
    /// The argument of perigee \[deg\].
    pub argument_of_perigee_deg: f64,
    /// The true anomaly \[deg\].
    pub true_anomaly_deg: f64,
}

/// The reason why an orbit or a position on it does not exist.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum OrbitError {
    /// The two lines are not two-line elements.
    #[error("the two-line elements are wrong: {0}")]
    TwoLines(#[from] TwoLinesError),
    /// SGP4 refuses these elements.
    #[error("SGP4 refuses these elements: {0}")]
    MeanElements(String),
    /// SGP4 cannot go there: it decays, as a rule.
    #[error("SGP4 has no position {0:.0} s after the epoch: the orbit decays")]
    Decays(f64),
    /// The orbit is not an ellipse.
    #[error("the orbit is not an ellipse: {0}")]
    NoEllipse(&'static str),
    /// The perigee of the orbit is below the ground.
    #[error("the perigee is {0:.0} km below the ground")]
    Underground(f64),
    /// The epoch of a state is too far from the epoch of the maneuver.
    #[error("the epoch of the orbit is {0:.0} days from the epoch of the maneuver; at most 30 are allowed")]
    Old(f64),
    /// A table does not reach so far.
    #[error("the table of positions ends before {0:.1} s after the epoch")]
    Beyond(f64),
}

/// The orbit of a satellite: positions in the GCRS \[m\] at seconds after an epoch.
#[derive(Clone, Debug)]
pub struct Orbit {
    path: Path,
    /// The time from the epoch of the orbit to the epoch of the maneuver \[s\].
    ahead: f64,
    clock: Clock,
}

#[derive(Clone, Debug)]
enum Path {
    TwoLines(Arc<sgp4::Constants>),
    State { position: Vector3, velocity: Vector3, model: Model, pole: Vector3 },
    Table(Arc<Table>),
}

/// A table of positions, and their interpolation.
#[derive(Clone, Debug)]
pub struct Table {
    /// Seconds since the epoch of the maneuver, rising.
    pub time: Vec<f64>,
    /// The position at each time, GCRS \[m\].
    pub position: Vec<Vector3>,
    /// The velocity at each time \[m/s\]; only Hermite's polynomial uses it.
    pub velocity: Vec<Vector3>,
    /// The polynomial through the rows about a moment.
    pub between: Between,
}

/// The polynomial between the rows of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// A polynomial of this degree through positions.
    Lagrange(usize),
    /// A polynomial through positions and velocities. Each row gives two conditions, so the degree
    /// is this one or one more.
    Hermite(usize),
}

impl Between {
    /// Returns the number of rows that the polynomial uses.
    pub fn rows(self) -> usize {
        match self {
            Self::Lagrange(degree) => degree + 1,
            Self::Hermite(degree) => (degree + 1).div_ceil(2),
        }
    }
}

impl Table {
    /// Returns the position at a time; `None` outside of the table.
    pub fn position(&self, time: f64) -> Option<Vector3> {
        // A time outside of the table by no more than the round-off of sums of seconds counts as
        // inside.
        const ROUNDED: f64 = 1e-6;
        let (first, last) = (*self.time.first()?, *self.time.last()?);
        if !(first - ROUNDED..=last + ROUNDED).contains(&time) {
            return None;
        }
        let count = self.between.rows().min(self.time.len());
        let from = polynomial::about(&self.time, count, time);
        let rows = from..from + count;
        // Differences from the first row, so that no digits are lost in nodes far from zero.
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
    /// Creates an orbit by SGP4 from two-line elements; `clock` is the epoch of the maneuver.
    ///
    /// # Errors
    /// [`OrbitError::TwoLines`] with the columns and the reason; [`OrbitError::MeanElements`].
    pub fn of_two_lines(lines: [&str; 2], clock: Clock) -> Result<Self, OrbitError> {
        Self::of_mean_elements(&two_lines::read(lines)?, clock)
    }

    /// Creates an orbit by SGP4 from mean elements; `clock` is the epoch of the maneuver.
    ///
    /// # Errors
    /// [`OrbitError::MeanElements`] of elements that are no orbit, or of an epoch that the calendar
    /// does not have.
    pub fn of_mean_elements(mean: &MeanElements, clock: Clock) -> Result<Self, OrbitError> {
        let wrong = |error: &dyn std::fmt::Display| OrbitError::MeanElements(error.to_string());
        let seconds = (mean.nanoseconds_of_day / 1_000_000_000) as u32;
        let nanoseconds = (mean.nanoseconds_of_day % 1_000_000_000) as u32;
        let [hour, minute, second] = [seconds / 3600, seconds / 60 % 60, seconds % 60];
        let date = sgp4::chrono::NaiveDate::from_yo_opt(mean.year, mean.day_of_year);
        let moment = date.and_then(|date| {
            // A time that rounds up to the end of a day is the beginning of the next day.
            let (date, hour) = if hour > 23 { (date.succ_opt()?, 0) } else { (date, hour) };
            date.and_hms_nano_opt(hour, minute, second, nanoseconds)
        });
        let datetime = moment.ok_or_else(|| wrong(&"their epoch is no moment of UTC"))?;
        // The crate counts without leap seconds, so the epoch is converted through TAI.
        let date = [datetime.year(), datetime.month() as i32, datetime.day() as i32];
        let epoch = Clock::of_utc(date, datetime.hour() as u8, minute as u8, second as u8, nanoseconds);
        let epoch = epoch.ok_or_else(|| wrong(&"their epoch is no moment of UTC"))?;
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

    /// Creates an orbit from a state with its own epoch, GCRS \[m\], \[m/s\].
    ///
    /// # Errors
    /// [`OrbitError::NoEllipse`], [`OrbitError::Underground`].
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
        // Once to the epoch of the maneuver, so that positions take as long as the maneuver does.
        let (position, velocity) = match model {
            Model::TwoBody => kepler(&position, &velocity, ahead),
            Model::J2 => extrapolated(&position, &velocity, ahead, &pole),
        };
        Ok(Self { path: Path::State { position, velocity, model, pole }, ahead, clock })
    }

    /// Creates an orbit from osculating elements with their own epoch.
    ///
    /// # Errors
    /// As [`Orbit::of_state`].
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

    /// Creates an orbit from a table.
    ///
    /// # Errors
    /// [`OrbitError::Beyond`] if the table has fewer rows than the polynomial needs, or if its
    /// times do not increase.
    pub fn of_table(table: Table, clock: Clock) -> Result<Self, OrbitError> {
        let Table { time, position, velocity, between } = &table;
        let rises = time.windows(2).all(|pair| pair[1] > pair[0]);
        let short = time.len() < between.rows();
        if time.len() != position.len() || time.len() != velocity.len() || short || !rises {
            return Err(OrbitError::Beyond(0.0));
        }
        Ok(Self { path: Path::Table(table.into()), ahead: 0.0, clock })
    }

    /// Returns whether it is a table, which has no elements.
    pub fn is_table(&self) -> bool {
        matches!(self.path, Path::Table(_))
    }

    /// Returns the age of the elements at the epoch of the maneuver \[s\]; 0 for a table.
    pub fn age(&self) -> f64 {
        self.ahead
    }

    /// Returns the position at `time` \[s\] after the epoch of the maneuver, GCRS \[m\].
    ///
    /// # Errors
    /// [`OrbitError::Decays`], [`OrbitError::Beyond`].
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

    /// Returns one revolution about a point mass from the state at the epoch \[s\].
    ///
    /// # Errors
    /// As [`Orbit::position`].
    pub fn period(&self) -> Result<f64, OrbitError> {
        const STEP: f64 = 1.0;
        let at = |time: f64| self.position(time);
        let (before, here, after) = (at(0.0)?, at(STEP)?, at(2.0 * STEP)?);
        let velocity = (after - before) / (2.0 * STEP);
        let axis = 1.0 / (2.0 / here.norm() - velocity.norm_squared() / MU);
        Ok(std::f64::consts::TAU * (axis.powi(3) / MU).sqrt())
    }
}

/// Returns the position and velocity at `time` \[s\] after the given ones, about a point mass, GCRS
/// \[m\], \[m/s\]. Also returns the distance \[m\] by which the flattening of the Earth may shift
/// the position. `None` if the orbit is not an ellipse.
pub fn two_body(position: &Vector3, velocity: &Vector3, time: f64) -> Option<((Vector3, Vector3), f64)> {
    let r = position.norm();
    let energy = 0.5 * velocity.norm_squared() - MU / r;
    if !(r > 0.0 && energy < 0.0) {
        return None;
    }
    let flattening = 1.5 * J2 * MU * (EARTH_RADIUS_M / (r * r)).powi(2);
    Some((kepler(position, velocity, time), flattening * time * time))
}

/// Propagates a state along an ellipse by the difference of the eccentric anomalies.
fn kepler(position: &Vector3, velocity: &Vector3, time: f64) -> (Vector3, Vector3) {
    let r = position.norm();
    let axis = 1.0 / (2.0 / r - velocity.norm_squared() / MU);
    let n = (MU / axis.powi(3)).sqrt();
    let cosine = 1.0 - r / axis;
    let sine = position.dot(velocity) / (MU * axis).sqrt();
    let turns = (n * time / std::f64::consts::TAU).trunc();
    let mean = n * time - turns * std::f64::consts::TAU;
    // x − e cos E₀ sin x + e sin E₀ (1 − cos x) = M.
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

/// Propagates a state about the flattened Earth: steps of a minute, by extrapolated midpoints of
/// order sixteen.
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
            // Neville's scheme in the square of the step.
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

    /// A propagation from a state to the state some seconds later.
    type Onward<'a> = dyn Fn((Vector3, Vector3), f64) -> (Vector3, Vector3) + 'a;

    /// An orbit does not depend on the state along it from which it is propagated.
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
        // The flattening moves the satellite by kilometres in that time.
        assert!((onward[0]((r, v), 9000.0).0 - onward[1]((r, v), 9000.0).0).norm() > 1e3);
    }

    /// Polynomials of degree 7 between rows a minute apart.
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
