//! Calendar date and time, and instants at a given number of seconds after them.
//!
//! The library uses elapsed seconds. An epoch is the date of time zero in a named time scale. The
//! crate `hifitime` supplies leap seconds and time scales. An instant is stored as a whole second
//! and a fraction, so that a time with 12 decimals is accurate to a picosecond.
//!
//! # Why is the epoch not a part of the problem?
//!
//! A plan does not depend on the date. `Problem` has elapsed seconds; `Identity` (epoch and names)
//! is passed separately from the spec to the plan file and to exchange files. A time scale is
//! required, because UTC and TAI differ by 37 s. This module adds two things to `hifitime`: the
//! leap second 60, for which that crate has no name, and the fraction of a second as a double.
//! Nanoseconds would not suffice: one nanosecond at 1 rad/s is 1e-9 rad, and a plan is accurate to
//! 1e-12. Messages carry a creation date, in which two files differ; `SOURCE_DATE_EPOCH` fixes it.

use hifitime::{Duration, Epoch as Instant, TimeScale, Unit};
use std::fmt;
use thiserror::Error;

/// Time scale of a date, as named in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Coordinated universal time (UTC), with leap seconds.
    Utc,
    /// International atomic time (TAI).
    Tai,
    /// Terrestrial time (TT).
    Tt,
    /// Barycentric dynamical time (TDB).
    Tdb,
    /// GPS time.
    Gps,
}

impl Scale {
    const ALL: [Self; 5] = [Self::Utc, Self::Tai, Self::Tt, Self::Tdb, Self::Gps];

    /// Returns the name of the scale in specs and CCSDS messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Utc => "UTC",
            Self::Tai => "TAI",
            Self::Tt => "TT",
            Self::Tdb => "TDB",
            Self::Gps => "GPS",
        }
    }

    /// Returns the scale with this name, in upper or lower case.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scale| scale.name().eq_ignore_ascii_case(name))
    }

    fn of_hifitime(self) -> TimeScale {
        match self {
            Self::Utc => TimeScale::UTC,
            Self::Tai => TimeScale::TAI,
            Self::Tt => TimeScale::TT,
            Self::Tdb => TimeScale::TDB,
            Self::Gps => TimeScale::GPST,
        }
    }
}

/// Reason why a text is not accepted as an epoch.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum EpochError {
    /// The time scale is missing.
    #[error("the time scale is missing: UTC and TAI differ by 37 s")]
    NoScale,
    /// The time scale is not supported.
    #[error("the time scale {0} is unknown")]
    Scale(String),
    /// The text gives an offset from UTC, such as +02:00, which is not supported.
    #[error("an offset of {0} from UTC is not supported")]
    Offset(String),
    /// The text is not an ISO 8601 date with a time of day.
    #[error("this is not a date with a time of day, such as 2026-11-21T07:00:00.25")]
    Form,
    /// The date or the second does not exist, such as 30 February.
    #[error("this date does not exist")]
    Calendar,
}

/// A date and time of day in a time scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Epoch {
    /// The whole second that contains the epoch, in the scale of the epoch. It is stored in TAI, or
    /// in TDB if this is the scale of the epoch.
    second: Instant,
    /// Fraction of this second that has passed \[s\], at least 0 and less than 1.
    fraction: f64,
    scale: Scale,
}

/// Number of decimals with which seconds are written: a resolution of one picosecond.
const DECIMALS: usize = 12;

impl Epoch {
    /// Parses a date such as `2026-11-21T07:00:00.25 UTC`. Instead of the scale, a `Z` or the
    /// offset `+00:00` means UTC. A blank may replace the `T`; the blank before the scale may be
    /// omitted.
    ///
    /// # Errors
    /// Returns an error if the scale is missing or unknown, if the text is not a date, or if the
    /// date does not exist.
    pub fn parse(text: &str) -> Result<Self, EpochError> {
        let text = text.trim();
        // The scale is the last word. Without a blank before it, it begins at the first character
        // that can belong neither to a time of day nor to an offset.
        let clock = text.find(':').unwrap_or(text.len());
        let end = text[clock..]
            .find(|sign: char| !(sign.is_ascii_digit() || sign.is_whitespace() || ".:+-".contains(sign)))
            .map_or(text.len(), |at| clock + at);
        let (moment, name) = match text.rsplit_once(char::is_whitespace) {
            Some((moment, word)) if !word.contains(':') && !word.starts_with(['+', '-']) => {
                (moment.trim_end(), word)
            }
            _ => (&text[..end], &text[end..]),
        };
        if !name.is_empty() && !name.eq_ignore_ascii_case("Z") {
            let scale = Scale::named(name).ok_or_else(|| EpochError::Scale(name.into()))?;
            return Self::in_scale(moment, scale);
        }
        let clock = clock.min(moment.len());
        let offset = moment[clock..].find(['+', '-']).map(|at| clock + at);
        match offset {
            Some(at) if name.is_empty() => {
                let zero = moment[at + 1..].bytes().all(|byte| matches!(byte, b'0' | b':'));
                if zero {
                    Self::in_scale(&moment[..at], Scale::Utc)
                } else {
                    Err(EpochError::Offset(moment[at..].into()))
                }
            }
            _ if name.is_empty() => Err(EpochError::NoScale),
            _ => Self::in_scale(moment, Scale::Utc),
        }
    }

    /// Parses a date such as `2026-11-21T07:00:00.25`, or `2026-325T07:00:00.25` with the day of
    /// the year, in the scale `scale`. A final `Z` is ignored.
    ///
    /// # Errors
    /// Returns the errors of [`Epoch::parse`].
    pub fn in_scale(text: &str, scale: Scale) -> Result<Self, EpochError> {
        let (date, time) = text.trim().split_once(['T', 't', ' ']).ok_or(EpochError::Form)?;
        let time = time.strip_suffix(['Z', 'z']).unwrap_or(time).trim();
        let (clock, fraction) = match time.split_once('.') {
            Some((clock, digits)) => (clock, fraction(digits).ok_or(EpochError::Form)?),
            None => (time, 0.0),
        };
        let [hour, minute, second] = numbers(clock, ':', [2, 2, 2]).ok_or(EpochError::Form)?;
        let (year, month, day, days) = match numbers(date, '-', [4, 2, 2]) {
            Some([year, month, day]) => (year, month, day, 0),
            None => {
                let [year, of_year] = numbers(date, '-', [4, 3]).ok_or(EpochError::Form)?;
                let leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
                if of_year == 0 || of_year > 365 + u32::from(leap) {
                    return Err(EpochError::Calendar);
                }
                (year, 1, 1, of_year - 1)
            }
        };
        let small = |number: u32| u8::try_from(number).map_err(|_| EpochError::Calendar);
        let year = i32::try_from(year).map_err(|_| EpochError::Calendar)?;
        let in_scale = |scale: TimeScale, (hour, minute, second): (u8, u8, u8)| {
            Instant::maybe_from_gregorian(year, small(month)?, small(day)?, hour, minute, second, 0, scale)
                .map(|moment| moment + Unit::Day * i64::from(days))
                .map_err(|_| EpochError::Calendar)
        };
        if hour > 23 {
            return Err(EpochError::Calendar);
        }
        // `hifitime` has no number for second 60 of UTC, so the instant is computed as one second
        // after second 59.
        let leap = second == 60;
        let time = (small(hour)?, small(minute)?, small(second.min(59))?);
        let moment = in_scale(scale.of_hifitime(), time)?;
        let mut moment = moment.to_time_scale(Self::counted_in(scale));
        if leap {
            moment += Unit::Second * 1;
            let said = Self { second: moment, fraction: 0.0, scale };
            if scale != Scale::Utc || said.calendar(moment).5 != 60 {
                return Err(EpochError::Calendar);
            }
        }
        Ok(Self { second: moment, fraction, scale })
    }

    /// Creates the epoch, in UTC, that is `seconds` seconds after 1970-01-01T00:00:00 in Unix time.
    pub fn of_unix(seconds: u64) -> Self {
        let second = Instant::from_unix_seconds(seconds as f64).to_time_scale(TimeScale::TAI);
        Self { second, fraction: 0.0, scale: Scale::Utc }
    }

    /// Converts the epoch to another scale. Conversions between TDB and another scale are accurate
    /// to a nanosecond.
    pub fn in_other_scale(&self, scale: Scale) -> Self {
        let moment = self.second.to_time_scale(Self::counted_in(scale));
        // The whole seconds of two scales need not coincide (TT − TAI is 32.184 s), so the fraction
        // of the second may change.
        let past = moment.to_duration_in_time_scale(scale.of_hifitime()).total_nanoseconds();
        let past = past.rem_euclid(1_000_000_000) as i64;
        let whole = Self { second: moment - Unit::Nanosecond * past, fraction: 0.0, scale };
        whole.after(self.fraction + past as f64 * 1e-9)
    }

    /// Returns the scale in which the whole second is stored. Epochs in TDB use TDB, because its
    /// rate varies relative to the other scales; all other epochs use TAI.
    fn counted_in(scale: Scale) -> TimeScale {
        if scale == Scale::Tdb { TimeScale::TDB } else { TimeScale::TAI }
    }

    /// Returns the time scale of the epoch.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// Returns the fraction of the current second that has passed \[s\].
    pub(crate) fn fraction(&self) -> f64 {
        self.fraction
    }

    /// Returns the epoch that is `seconds` seconds later.
    pub fn after(&self, seconds: f64) -> Self {
        let (mut whole, mut fraction) = (seconds.floor(), seconds - seconds.floor() + self.fraction);
        if fraction >= 1.0 {
            (whole, fraction) = (whole + 1.0, fraction - 1.0);
        }
        Self { second: self.second + Unit::Second * whole, fraction, scale: self.scale }
    }

    /// Returns the elapsed time from `other` to this epoch \[s\].
    pub fn since(&self, other: &Self) -> f64 {
        let whole: Duration = self.second.to_time_scale(other.second.time_scale) - other.second;
        whole.to_seconds() + (self.fraction - other.fraction)
    }

    /// Returns a clock with this epoch as time zero, for computing positions of celestial bodies.
    pub(crate) fn clock(&self) -> slewkit_sky::Clock {
        let nanoseconds = self.second.to_tai_duration().total_nanoseconds();
        let (whole, rest) = (nanoseconds.div_euclid(1_000_000_000), nanoseconds.rem_euclid(1_000_000_000));
        slewkit_sky::Clock::of_tai(i64::try_from(whole).unwrap_or(0), rest as f64 * 1e-9 + self.fraction)
    }

    /// Returns the seconds of terrestrial time since J2000.0, the count used by SPICE clock
    /// kernels.
    pub fn terrestrial_past_j2000(&self) -> f64 {
        self.second.to_tt_since_j2k().to_seconds() + self.fraction
    }

    /// Returns the date and time of day in the scale of the epoch, in the notation of CCSDS
    /// messages, with a resolution of one picosecond.
    pub fn calendar_text(&self) -> String {
        let mut digits = format!("{:.*}", DECIMALS, self.fraction);
        let mut second = self.second;
        // A fraction that rounds up to 1 becomes the next whole second.
        if digits.starts_with('1') {
            second += Unit::Second * 1;
            digits = format!("{:.*}", DECIMALS, 0.0);
        }
        let (year, month, day, hour, minute, second) = self.calendar(second);
        // At least three decimals are written, because many readers expect them.
        let digits = digits[1..].trim_end_matches('0');
        let digits = format!("{digits:0<4}");
        let digits = if digits.starts_with('.') { digits } else { ".000".into() };
        format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}{digits}")
    }

    /// Returns the year, month, day, hour, minute and second of the whole second `second`.
    fn calendar(&self, second: Instant) -> (i32, u8, u8, u8, u8, u8) {
        let scale = self.scale.of_hifitime();
        let of = |moment: Instant| {
            let (year, month, day, hour, minute, second, _) = moment.to_gregorian(scale);
            (year, month, day, hour, minute, second)
        };
        let said = of(second);
        if self.scale != Scale::Utc {
            return said;
        }
        // In the half minute that ends with a leap second, the conversion of `hifitime` from TAI to
        // UTC is early by one second; its conversion from UTC to TAI is right. A second that is not
        // the conversion of any UTC time is the leap second itself.
        let (year, month, day, hour, minute, named, _) = second.to_gregorian(scale);
        let Ok(utc) = Instant::maybe_from_gregorian(year, month, day, hour, minute, named, 0, scale) else {
            return said;
        };
        let late = utc + Unit::Second * 1;
        if utc == second {
            said
        } else if late == second {
            of(late)
        } else {
            (year, month, day, hour, minute, 60)
        }
    }
}

/// Writes the epoch in the notation of specs.
impl fmt::Display for Epoch {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} {}", self.calendar_text(), self.scale.name())
    }
}

/// Parses `N` whole numbers separated by the character `sign`. The numbers must have the numbers of
/// digits given in `digits`.
fn numbers<const N: usize>(text: &str, sign: char, digits: [usize; N]) -> Option<[u32; N]> {
    let parts: Vec<&str> = text.split(sign).collect();
    if parts.len() != N {
        return None;
    }
    let mut values = [0; N];
    for ((value, part), digits) in values.iter_mut().zip(parts).zip(digits) {
        if part.len() != digits || !part.bytes().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        *value = part.parse().ok()?;
    }
    Some(values)
}

/// Parses the digits after the decimal point of a second.
fn fraction(digits: &str) -> Option<f64> {
    if digits.is_empty() || digits.len() > 30 || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let value: f64 = format!("0.{digits}").parse().ok()?;
    // Thirty digits 9 round to 1, which is not a fraction of a second.
    (value < 1.0).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::{Epoch, EpochError};

    fn epoch(text: &str) -> Epoch {
        Epoch::parse(text).unwrap()
    }

    #[test]
    fn what_is_read_is_written() {
        for text in [
            "2026-11-21T07:00:00.000 UTC",
            "2026-11-21T07:00:00.250 TAI",
            "2024-02-29T23:59:59.123456789012 TT",
            "1999-12-31T00:00:00.000 TDB",
            "2000-01-01T12:00:00.000 GPS",
            "2016-12-31T23:59:60.500 UTC",
        ] {
            assert_eq!(epoch(text).to_string(), text);
        }
        assert_eq!(epoch("2026-11-21T07:00:00Z").to_string(), "2026-11-21T07:00:00.000 UTC");
        assert_eq!(epoch("2024-060T00:00:00 UTC").to_string(), "2024-02-29T00:00:00.000 UTC");
        for text in [
            "2026-11-21T07:00:00+00:00",
            "2026-11-21T07:00:00-0000",
            "2026-11-21 07:00:00 UTC",
            "2026-11-21T07:00:00UTC",
            "2026-11-21t07:00:00z",
            "2026-11-21T07:00:00 utc",
        ] {
            assert_eq!(epoch(text).to_string(), "2026-11-21T07:00:00.000 UTC", "{text}");
        }
    }

    /// At the leap second of 2016, UTC has 23:59:60 between 23:59:59 and midnight; TAI runs
    /// uniformly.
    #[test]
    fn a_leap_second_has_its_place() {
        let start = epoch("2016-12-31T23:59:59.5 UTC");
        let texts = [0.0, 0.5, 1.25, 1.5, 2.5].map(|seconds| start.after(seconds).calendar_text());
        let expected = [
            "2016-12-31T23:59:59.500",
            "2016-12-31T23:59:60.000",
            "2016-12-31T23:59:60.750",
            "2017-01-01T00:00:00.000",
            "2017-01-01T00:00:01.000",
        ];
        assert_eq!(texts, expected);
        for (text, seconds) in expected.iter().zip([0.0, 0.5, 1.25, 1.5, 2.5]) {
            assert_eq!(epoch(&format!("{text} UTC")).since(&start), seconds, "{text}");
        }
        // According to IERS Bulletin C 52, TAI − UTC is 36 s before the leap second and 37 s after.
        assert_eq!(start.since(&epoch("2017-01-01T00:00:35.5 TAI")), 0.0);
        assert_eq!(epoch("2017-01-01T00:00:01 UTC").since(&epoch("2017-01-01T00:00:38 TAI")), 0.0);
    }

    #[test]
    fn scales_are_apart_as_published() {
        let at = |scale: &str| epoch(&format!("2026-11-21T07:00:00 {scale}"));
        // TT is TAI + 32.184 s, GPS is TAI − 19 s.
        assert_eq!(at("TAI").since(&at("TT")), 32.184);
        assert_eq!(at("GPS").since(&at("TAI")), 19.0);
        assert_eq!(at("UTC").since(&at("TAI")), 37.0);
        // J2000 is 2000-01-01T12:00:00 TT.
        assert_eq!(epoch("2000-01-01T12:00:01.5 TT").terrestrial_past_j2000(), 1.5);
    }

    #[test]
    fn times_come_back_to_a_picosecond() {
        let start = epoch("2026-11-21T07:00:00.1 UTC");
        for seconds in [0.0, 1e-12, 0.3, 1.0 / 3.0, 59.9, 1234.5678901234, 86_400.7] {
            let text = start.after(seconds).to_string();
            let back = epoch(&text).since(&start);
            assert!(
                (back - seconds).abs() < 1e-12 * (1.0 + seconds.abs() / 10.0),
                "{text}: {back} {seconds}"
            );
        }
    }

    #[test]
    fn what_is_no_moment_is_told() {
        assert_eq!(Epoch::parse("2026-11-21T07:00:00"), Err(EpochError::NoScale));
        assert_eq!(Epoch::parse("2026-11-21T07:00:00 UT1"), Err(EpochError::Scale("UT1".into())));
        assert_eq!(Epoch::parse("2026-11-21T07:00:00+01:00"), Err(EpochError::Offset("+01:00".into())));
        for text in
            ["", "UTC", "2026-11-21 UTC", "2026-11-21T7:00:00 UTC", "2026-11-21T07:00:00.x UTC", "-T: UTC"]
        {
            assert!(matches!(Epoch::parse(text), Err(EpochError::Form | EpochError::NoScale)), "{text}");
        }
        for text in [
            "2026-02-30T00:00:00",
            "2026-13-01T00:00:00",
            "2026-11-21T24:00:00",
            "2026-11-21T07:00:60",
            "2025-366T00:00:00",
        ] {
            assert_eq!(Epoch::parse(&format!("{text} UTC")), Err(EpochError::Calendar), "{text}");
        }
        assert_eq!(Epoch::parse("2016-12-31T23:59:60 TAI"), Err(EpochError::Calendar));
    }
}
