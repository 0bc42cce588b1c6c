//! Attitudes of other programs: AEM 1.0 and 2.0 as keywords and values, AEM 2.0 in XML, and tables.
//!
//! What is read is turned into our convention: body to reference, scalar first, rates in body axes in rad/s. Every
//! error has its line. A file is read whole before anything of it is used.

mod keywords;
mod message;
mod table;
mod xml;

use super::interpolation::{Row, linear};
use crate::epoch::Epoch;
use crate::spec::{Diagnostics, Finding, Source, Span};
use slewkit::{Vector3, lie};
use std::io::Read;

/// The largest file, in bytes.
const MAX_BYTES: u64 = 1 << 28;
/// How far the length of a quaternion may be from 1 by rounding: six digits were printed.
const UNIT_ROUNDING: f64 = 2e-6;

/// The latest time that a row may have, and less its sign the earliest \[s\].
const LATEST: f64 = 1e12;

/// Attitudes at moments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attitudes {
    /// Seconds from the first row, increasing.
    pub time: Vec<f64>,
    /// From body to reference, `[w, x, y, z]`, of length 1, of one sign along the rows.
    pub quaternion: Vec<[f64; 4]>,
    /// Angular velocity against the reference frame, body axes [rad/s]; empty where the file has none.
    pub rate: Vec<Vector3>,
    /// The moment of the first row, where the file says.
    pub epoch: Option<Epoch>,
    /// What the file calls the reference frame.
    pub reference_frame: Option<String>,
    /// What it calls the body frame.
    pub body_frame: Option<String>,
}

impl Attitudes {
    /// As many attitudes at equal distances in time, each on the rotation at one rate between its neighbours.
    pub fn evenly(&self) -> Vec<[f64; 4]> {
        let (count, end) = (self.time.len(), self.time.last().copied().unwrap_or(0.0));
        let mut low = 0;
        let row = |k: usize| Row {
            attitude: lie::rotation_from_quaternion(&self.quaternion[k]),
            rate: Vector3::zeros(),
        };
        (0..count)
            .map(|index| {
                let at = end * index as f64 / (count - 1) as f64;
                while low + 2 < count && self.time[low + 1] <= at {
                    low += 1;
                }
                let share = (at - self.time[low]) / (self.time[low + 1] - self.time[low]);
                lie::quaternion_from_rotation(&linear(&row(low), &row(low + 1), share))
            })
            .collect()
    }
}

/// Reads attitudes; what kind of file it is its first line says. `name` stands for it in messages.
///
/// # Errors
/// The first thing that is wrong, with its line.
pub fn read_attitudes(input: impl Read, name: &str) -> Result<Attitudes, Diagnostics> {
    let mut bytes = Vec::new();
    let whole = |reason: String, remedy: &str| {
        Diagnostics(vec![crate::spec::Diagnostic::about_file("E0150", name, reason, remedy)])
    };
    input
        .take(MAX_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| whole(format!("cannot read {name}: {error}"), "check the path"))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(whole(format!("the file is larger than {MAX_BYTES} bytes"), "give fewer rows"));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
        let mut found = whole(format!("line {line} is no text in UTF-8"), "give a text file: AEM or a table");
        found.0[0].line = line;
        found
    })?;
    let source = Source::new(name, text.strip_prefix('\u{feff}').unwrap_or(&text));
    read(&source.text)
        .map_err(|wrong| Diagnostics(vec![wrong.finding().resolve(std::slice::from_ref(&source))]))
}

fn read(text: &str) -> Result<Attitudes, Wrong> {
    let first = text.len() - text.trim_start().len();
    let start = &text[first..];
    if start.is_empty() {
        return wrong(0, 0, "the file is empty", "give an AEM, or a table with a head");
    }
    let rows = if start.starts_with('<') {
        xml::read(text)?
    } else if start.starts_with("CCSDS_") {
        keywords::read(text)?
    } else {
        table::read(text)?
    };
    rows.finish()
}

/// What is wrong, and where: bytes of the text.
#[derive(Debug)]
struct Wrong {
    span: (usize, usize),
    reason: String,
    remedy: String,
}

impl Wrong {
    fn finding(self) -> Finding {
        let (start, end) = self.span;
        // An empty span at the first byte would point nowhere.
        let span = Span { source: 0, start, end: end.max(start + 1) };
        Finding::error("E0151", span, self.reason, self.remedy)
    }
}

fn wrong<T>(
    at: usize,
    length: usize,
    reason: impl Into<String>,
    remedy: impl Into<String>,
) -> Result<T, Wrong> {
    Err(Wrong { span: (at, at + length), reason: reason.into(), remedy: remedy.into() })
}

/// A piece of the text and where it begins.
#[derive(Clone, Copy, Debug)]
struct Piece<'t> {
    at: usize,
    text: &'t str,
}

impl<'t> Piece<'t> {
    /// Without blanks at its ends.
    fn trimmed(self) -> Self {
        let lead = self.text.len() - self.text.trim_start().len();
        Self { at: self.at + lead, text: self.text.trim() }
    }

    fn wrong<T>(self, reason: impl Into<String>, remedy: impl Into<String>) -> Result<T, Wrong> {
        wrong(self.at, self.text.len(), reason, remedy)
    }

    /// Words between blanks.
    fn words(self) -> Vec<Self> {
        let words = self.text.split_ascii_whitespace();
        words
            .map(|word| Self {
                at: self.at + word.as_ptr() as usize - self.text.as_ptr() as usize,
                text: word,
            })
            .collect()
    }

    /// A finite number.
    fn number(self) -> Result<f64, Wrong> {
        match self.text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => self.wrong("this number is not finite", "an attitude has finite numbers"),
            Err(_) => self.wrong(
                format!("`{}` is no number", crate::spec::cut(self.text, 30)),
                "write numbers with a point and an exponent, as in 1.5e-3",
            ),
        }
    }
}

/// Lines of a text with their places, blank ones left out.
fn lines(text: &str) -> impl Iterator<Item = Piece<'_>> {
    let pieces = text.split_inclusive('\n').scan(0, |at, line| {
        let piece = Piece { at: *at, text: line };
        *at += line.len();
        Some(piece.trimmed())
    });
    pieces.filter(|piece| !piece.text.is_empty())
}

/// Rows in our convention on their way into the result.
#[derive(Debug, Default)]
struct Rows {
    found: Attitudes,
    /// Where the last row stood.
    last: Option<usize>,
    /// Whether the next row is the first of its block.
    begins: bool,
}

impl Rows {
    /// Adds a row; `time` counts from anything.
    fn add(
        &mut self,
        at: Piece<'_>,
        time: f64,
        quaternion: [f64; 4],
        rate: Option<Vector3>,
    ) -> Result<(), Wrong> {
        let length = quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
        if (length - 1.0).abs() > UNIT_ROUNDING {
            let reason = format!("the quaternion has the length {length:.8}");
            return at.wrong(reason, "attitudes are unit quaternions, of length 1 to six digits");
        }
        if time.abs() > LATEST {
            let reason = format!("the time {time:e} s is more than 30 000 years away");
            return at.wrong(reason, "give times in seconds from near the first row");
        }
        let begins = std::mem::take(&mut self.begins);
        if begins && self.found.time.last() == Some(&time) {
            return self.shared(at, quaternion);
        }
        if let Some(before) = self.found.time.last().filter(|before| **before >= time) {
            let by = before - time;
            let reason = format!("this row is {by} s before the one above, or at the same time");
            return at.wrong(reason, "times increase strictly");
        }
        if !self.found.time.is_empty() && rate.is_some() == self.found.rate.is_empty() {
            return at.wrong("rates stand in some rows only", "give them in all rows, or in none");
        }
        let same = self
            .found
            .quaternion
            .last()
            .map_or(1.0, |last| last.iter().zip(quaternion).map(|(a, b)| a * b).sum::<f64>());
        // What has length 1 to round-off keeps its bits.
        let scale = if (length - 1.0).abs() < 4.0 * f64::EPSILON { 1.0 } else { length };
        let scale = if same < 0.0 { -scale } else { scale };
        self.found.time.push(time);
        self.found.quaternion.push(quaternion.map(|part| part / scale));
        self.found.rate.extend(rate);
        self.last = Some(at.at);
        Ok(())
    }

    /// The first row of a block at the time of the last one of the block above: the same attitude, and one row is enough.
    fn shared(&self, at: Piece<'_>, quaternion: [f64; 4]) -> Result<(), Wrong> {
        let before = self.found.quaternion.last().copied().unwrap_or_default();
        let same = before.iter().zip(quaternion).map(|(a, b)| a * b).sum::<f64>();
        let near = |(a, b): (&f64, f64)| (a - same.signum() * b).abs() <= UNIT_ROUNDING;
        if before.iter().zip(quaternion).all(near) {
            return Ok(());
        }
        at.wrong("the block above ends at the same time in another attitude", "a body turns without jumps")
    }

    fn finish(mut self) -> Result<Attitudes, Wrong> {
        if self.found.time.len() < 2 {
            let reason = format!("the file has {} rows of attitudes, two are needed", self.found.time.len());
            return wrong(self.last.unwrap_or(0), 1, reason, "give the attitude at the start and at the end");
        }
        let start = self.found.time[0];
        for time in &mut self.found.time {
            *time -= start;
        }
        Ok(self.found)
    }
}
