//! Epoch of a maneuver, and time scales (TT, TAI, UT1) at a given number of seconds after it.
//!
//! A Julian date in a single double has a resolution of 40 µs, in which a satellite moves by 0.3 m.
//! Days and seconds are therefore stored separately, and elapsed SI seconds are added to the
//! seconds.

use hifitime::{Duration, Epoch, TimeScale};

/// Date of the last leap second that the program knows. Later leap seconds are assumed not to
/// occur.
pub const DATE_OF_LAST_LEAP_SECOND: &str = "2017-01-01";

const DAY: f64 = 86_400.0;

/// Epoch of a maneuver, stored as a time in TT.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Number of whole days of TT since J2000.0 (2000-01-01, noon).
    days: f64,
    /// Seconds of TT since noon of this day.
    seconds: f64,
    /// TAI − UTC at the epoch \[s\].
    leap: f64,
}

impl Clock {
    /// Creates the clock whose epoch is an instant of TAI, given by the whole seconds since
    /// 1900-01-01, midnight, and a fraction of a second.
    pub fn of_tai(seconds: i64, fraction: f64) -> Self {
        let whole = Epoch::from_tai_duration(Duration::from_seconds(seconds as f64));
        // Seconds from 1900-01-01, midnight, to 2000-01-01, noon. TT − TAI is 32.184 s.
        const CENTURY: i64 = 36_524 * 86_400 + 43_200;
        let since = seconds - CENTURY;
        let days = since.div_euclid(86_400);
        let seconds = since.rem_euclid(86_400) as f64 + fraction + 32.184;
        Self { days: days as f64, seconds, leap: whole.leap_seconds(true).unwrap_or(0.0) }
    }

    /// Creates the clock whose epoch is an instant of UTC; `date` is \[year, month, day\].
    ///
    /// Returns `None` if no such instant exists in the calendar.
    pub fn of_utc(date: [i32; 3], hours: u8, minutes: u8, seconds: u8, nanoseconds: u32) -> Option<Self> {
        let [year, month, day] = date;
        let (month, day) = (u8::try_from(month).ok()?, u8::try_from(day).ok()?);
        let at = Epoch::maybe_from_gregorian(
            year,
            month,
            day,
            hours,
            minutes,
            seconds,
            nanoseconds,
            TimeScale::UTC,
        );
        let tai = at.ok()?.to_tai_duration().total_nanoseconds();
        let whole = tai.div_euclid(1_000_000_000);
        let fraction = tai.rem_euclid(1_000_000_000) as f64 * 1e-9;
        Some(Self::of_tai(i64::try_from(whole).ok()?, fraction))
    }

    /// Returns a clock whose epoch is `seconds` later. The difference TAI − UTC is not changed.
    #[must_use]
    pub fn later(&self, seconds: f64) -> Self {
        Self { seconds: self.seconds + seconds, ..*self }
    }

    /// Returns the time from the epoch of `other` to the epoch of this clock \[s\].
    pub fn since(&self, other: &Self) -> f64 {
        (self.days - other.days) * DAY + (self.seconds - other.seconds)
    }

    /// Returns the time since J2000.0 in Julian centuries of TT, at `time` \[s\] after the epoch.
    /// The difference from TDB is at most 2 ms.
    pub(crate) fn centuries(&self, time: f64) -> f64 {
        (self.days + (self.seconds + time) / DAY) / 36_525.0
    }

    /// Returns the Julian date in TT at `time` \[s\] after the epoch, as a sum of two numbers.
    pub(crate) fn julian_tt(&self, time: f64) -> (f64, f64) {
        (2_451_545.0 + self.days, (self.seconds + time) / DAY)
    }

    /// Returns the days of UT1 since J2000.0 at `time` \[s\] after the epoch, as whole days and a
    /// fraction of a day.
    pub(crate) fn days_of_ut1(&self, time: f64, ut1_minus_utc: f64) -> (f64, f64) {
        (self.days, (self.seconds - 32.184 - self.leap + ut1_minus_utc + time) / DAY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_epoch_is_at_its_seconds() {
        let noon = Clock::of_utc([2000, 1, 1], 12, 0, 0, 0).unwrap();
        // TT − UTC was 64.184 s on 2000-01-01.
        assert_eq!((noon.days, noon.seconds, noon.leap), (0.0, 64.184, 32.0));
        let later = Clock::of_utc([2026, 11, 21], 7, 0, 0, 250_000_000).unwrap();
        assert_eq!(later.leap, 37.0);
        let next = Clock::of_utc([2026, 11, 22], 7, 0, 0, 0).unwrap();
        assert!((next.since(&later) - 86_399.75).abs() < 1e-9);
        // A leap second was inserted at the end of 2016-12-31.
        let [before, after] =
            [[2016, 12, 31], [2017, 1, 1]].map(|day| Clock::of_utc(day, 12, 0, 0, 0).unwrap());
        assert_eq!(after.since(&before), 86_401.0);
        assert_eq!(Clock::of_utc([2026, 13, 1], 0, 0, 0, 0), None);
    }
}
