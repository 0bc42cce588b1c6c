//! Collection of the rows of an attitude file, in the convention of plan files.

use super::between::{Between, Block};
use super::{Attitudes, Number, Piece, Wrong, wrong};
use crate::rounding::{ROTATION, SILENT};
use crate::spec::{Diagnostic, Finding, Severity, Source, Span};
use slewkit::Vector3;
use slewkit::numerics::figures::{short, significant};
use slewkit::verify::Rounding;

/// Largest absolute value of the time of a row \[s\].
const LATEST: f64 = 1e12;
/// Largest relative difference between steps that count as equal. The times of equal steps have no
/// uncertainty.
const EQUAL: f64 = 1e-9;

/// A row as read from the file, before it becomes a row of [`Attitudes`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved {
    /// Attitude quaternion `[w, x, y, z]` from body to reference axes, not normalised yet.
    pub quaternion: [f64; 4],
    /// Angular velocity in body axes \[rad/s\]; `None` if the row has no rate.
    pub rate: Option<Vector3>,
    /// Uncertainty of the attitude \[rad\] and of the rate \[rad/s\] due to the printed digits.
    pub open: (f64, f64),
}

/// Rows that have been read so far.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub found: Attitudes,
    /// Byte position of each row.
    places: Vec<usize>,
    /// Byte position at which the file names the frames.
    pub named_at: Option<usize>,
    /// Interpolation method of the block that begins with the next row; `None` if no block begins
    /// with it.
    begins: Option<Between>,
    /// Name and number of the object whose attitude is given, as stated in the blocks.
    pub object: Option<[String; 2]>,
    /// Largest deviation of the length of a quaternion from 1, and the index of its row.
    defect: (f64, usize),
    /// Smallest uncertainty due to the printed digits in any row.
    open: Option<Rounding>,
    /// True if the two interpretations of the rates of AEM 1.0 differ in this file.
    two_readings: bool,
    /// Number of rows outside of the time span that the file calls usable.
    unusable: usize,
}

impl Rows {
    /// Adds a row at `time` \[s\], counted from any fixed time.
    pub fn add(&mut self, at: Piece<'_>, time: Number, row: Moved) -> Result<(), Wrong> {
        let Moved { quaternion, rate, open } = row;
        let length = quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
        let defect = (length - 1.0).abs();
        if defect.is_nan() || defect > ROTATION {
            let reason = format!("the quaternion has the length {}", significant(length, 8));
            return at.wrong(reason, "give unit quaternions, of length 1 to three digits");
        }
        let Number { value: time, half_unit } = time;
        if time.abs() > LATEST {
            let reason = format!("the time {time:e} s is more than 30 000 years away");
            return at.wrong(reason, "give times in seconds from near the first row");
        }
        let begins = self.begins.take();
        if let (Some(between), Some(last)) = (begins, self.found.time.last())
            && *last == time
        {
            let row = self.found.time.len() - 1;
            self.found.blocks.push(Block { first: row, last: row, between });
            return self.shared(at, quaternion.map(|part| part / length), open.0);
        }
        if let Some(before) = self.found.time.last().filter(|before| **before >= time) {
            let by = before - time;
            let reason = format!("this row is {by} s before the one above, or at the same time");
            return at.wrong(reason, "give times in strictly increasing order");
        }
        if !self.found.time.is_empty() && rate.is_some() == self.found.rate.is_empty() {
            return at.wrong("only some rows have rates", "give them in all rows, or in none");
        }
        let row = self.found.time.len();
        if begins.is_some() && row > 0 {
            self.found.breaks.push(row);
        }
        if let Some(between) = begins.or((row == 0).then_some(Between::Unsaid)) {
            self.found.blocks.push(Block { first: row, last: row, between });
        }
        if let Some(block) = self.found.blocks.last_mut() {
            block.last = row;
        }
        let same = self
            .found
            .quaternion
            .last()
            .map_or(1.0, |last| last.iter().zip(quaternion).map(|(a, b)| a * b).sum::<f64>());
        // A quaternion whose length is 1 within round-off is not changed.
        let scale = if defect < 4.0 * f64::EPSILON { 1.0 } else { length };
        let scale = if same < 0.0 { -scale } else { scale };
        if defect > self.defect.0 {
            self.defect = (defect, self.found.time.len());
        }
        let least = self.open.map_or([f64::INFINITY; 3], |open| [open.attitude, open.rate, open.time]);
        self.open = Some(Rounding {
            attitude: least[0].min(open.0),
            rate: least[1].min(open.1),
            time: least[2].min(half_unit),
        });
        self.found.time.push(time);
        self.found.quaternion.push(quaternion.map(|part| part / scale));
        self.found.rate.extend(rate);
        self.places.push(at.at);
        Ok(())
    }

    /// Checks the first row of a block whose time equals the time of the last row of the previous
    /// block. The two rows must have the same attitude; only one of them is stored.
    fn shared(&self, at: Piece<'_>, quaternion: [f64; 4], open: f64) -> Result<(), Wrong> {
        let before = self.found.quaternion.last().copied().unwrap_or_default();
        let same = before.iter().zip(quaternion).map(|(a, b)| a * b).sum::<f64>();
        let near = |(a, b): (&f64, f64)| (a - same.signum() * b).abs() <= SAME.max(open.min(ROTATION));
        if before.iter().zip(quaternion).all(near) {
            return Ok(());
        }
        at.wrong(
            "the block above ends at the same time in another attitude",
            "remove the jump: the motion of a body is continuous",
        )
    }

    /// Adds a note about a statement that is not used, unless the list already has the note.
    pub fn note(&mut self, text: String) {
        if !self.found.not_taken.contains(&text) {
            self.found.not_taken.push(text);
        }
    }

    /// Begins a block, whose first row is the next row.
    pub fn begin(&mut self, between: Between) {
        self.begins = Some(between);
    }

    /// Excludes the rates of the file, because their two interpretations differ in this row.
    pub fn leave_rates_out(&mut self) {
        self.two_readings = true;
    }

    /// Counts the next row as outside of the time span that the file calls usable.
    pub fn unusable(&mut self) {
        self.unusable += 1;
    }

    /// Returns the attitudes, with a warning if quaternions were normalised.
    pub fn finish(mut self, source: &Source) -> Result<Attitudes, Wrong> {
        let count = self.found.time.len();
        if count < 2 {
            let reason = format!("the number of attitudes is {count}, but at least two are needed");
            let place = self.places.last().copied().unwrap_or(0);
            return wrong(place, 1, reason, "give the attitude at the start and at the end");
        }
        let start = self.found.time[0];
        for time in &mut self.found.time {
            *time -= start;
        }
        if self.found.begins.is_some() {
            self.found.begins = Some(start);
        }
        self.found.frames_line = self.named_at.map(|place| source.line_number(place));
        self.found.line = self.places.iter().map(|place| source.line_number(*place)).collect();
        if let Some(open) = self.open {
            self.found.rounding = self.rounding(open);
            self.found.printed_time = open.time;
        }
        if self.two_readings {
            self.found.rate.clear();
            self.note(
                "rates of the file: RATE of version 1.0 is read as angular velocity by some and as rates of \
                    Euler angles by others, and here the two differ"
                    .into(),
            );
        }
        if self.unusable > 0 {
            let rows = if self.unusable == 1 { "1 row".into() } else { format!("{} rows", self.unusable) };
            self.note(format!("whether {rows} may be used: outside of the usable span that the file names"));
        }
        self.settle_between();
        let (defect, row) = self.defect;
        if defect > SILENT {
            self.found.warnings.push(normalised(defect, self.places[row], source));
        }
        Ok(self.found)
    }

    /// Discards the interpolation method of a block if the block has too few rows or no rates for
    /// it.
    fn settle_between(&mut self) {
        let mut notes = Vec::new();
        for block in &mut self.found.blocks {
            let count = block.last - block.first + 1;
            let why = match block.between {
                Between::Hermite(_) if self.found.rate.is_empty() => {
                    "INTERPOLATION_METHOD HERMITE needs rates, and the file has no supported rates"
                        .to_string()
                }
                Between::Lagrange(degree) | Between::Hermite(degree) if count < block.between.rows() => {
                    format!(
                        "INTERPOLATION_DEGREE {degree} needs {} rows, but a block has {count}",
                        block.between.rows()
                    )
                }
                _ => continue,
            };
            block.between = Between::Unsaid;
            notes.push(format!("the motion between rows that the file declares: {why}; judged at one rate"));
        }
        notes.into_iter().for_each(|note| self.note(note));
    }

    /// Returns the uncertainty due to the printed digits, given the smallest uncertainty `open` in
    /// any row. For attitudes it is limited by the deviations of the quaternions from unit length.
    /// For times it is 0 if the steps are equal.
    fn rounding(&self, open: Rounding) -> Rounding {
        let time = &self.found.time;
        let mean = time[time.len() - 1] / (time.len() - 1) as f64;
        let equal = time.windows(2).all(|pair| (pair[1] - pair[0] - mean).abs() <= EQUAL * mean);
        // Rounded components change the length of a quaternion. Exact components such as 0.6 and
        // 0.8 have few digits but no uncertainty.
        let attitude = open.attitude.min(SHOWN * self.defect.0 + SHOWN * f64::EPSILON);
        Rounding { attitude, rate: open.rate, time: if equal { 0.0 } else { open.time } }
    }
}

/// Upper bound on the ratio of the rotation angle due to rounding to the largest deviation from
/// unit length, over many quaternions.
const SHOWN: f64 = 16.0;
/// Largest difference between quaternion components of one attitude if the number of digits is
/// unknown; it corresponds to six digits.
const SAME: f64 = 2e-6;

/// Returns the warning that the quaternions of the file were normalised. `defect` is the largest
/// deviation from unit length, at byte `place`.
fn normalised(defect: f64, place: usize, source: &Source) -> Diagnostic {
    let end = source.text[place..].find('\n').map_or(source.text.len(), |end| place + end);
    let reason = format!(
        "the length of this quaternion differs from 1 by {}, more than that of any other; all are normalised",
        short(defect)
    );
    let remedy = "write more digits to keep the attitudes as meant";
    let mut finding = Finding::error("W0051", Span { source: 0, start: place, end }, reason, remedy);
    finding.severity = Severity::Warning;
    finding.resolve(std::slice::from_ref(source))
}
