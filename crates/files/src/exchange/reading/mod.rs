//! Readers of attitude files: AEM 1.0 and 2.0 in keyword notation and XML, APM, STK attitude files,
//! SPICE C-kernels and tables; and of orbit files: OEM and OMM.
//!
//! Values are converted to the convention of plan files: quaternions from body to reference, scalar
//! first, and rates in body axes \[rad/s\]. Every error states its line. A file is read completely
//! before any part of it is used. [`Attitudes::not_taken`] lists the statements of the file that
//! are not used. The result also has the blocks and time spans of the file, and the uncertainty due
//! to its printed digits.

mod between;
pub(crate) mod elements;
mod ephemeris;
mod kernel;
mod keywords;
mod layout;
mod mean_elements;
mod message;
mod parameters;
mod rows;
mod said;
mod stk;
mod table;
mod xml;

pub use between::{Between, Block, Refined};
pub use ephemeris::{EphemerisAxes, Segment, read_ephemeris};
pub use mean_elements::read_mean_elements;

use crate::epoch::Epoch;
use crate::spec::{Diagnostic, Diagnostics, Finding, Source, Span};
use rows::Rows;
use slewkit::lie::interpolation::{Row, linear};
use slewkit::numerics::encoding::{self, NoText};
use slewkit::verify::Rounding;
use slewkit::{Vector3, lie};
use std::io::Read;

/// Largest size of a file \[bytes\].
const MAX_BYTES: u64 = 1 << 28;

/// Attitudes of a body at increasing times, as read from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attitudes {
    /// Time of each row since the first row \[s\], in increasing order.
    pub time: Vec<f64>,
    /// Unit quaternion `[w, x, y, z]` of each row, from body to reference axes. The sign is chosen
    /// so that the quaternion is continuous along the rows.
    pub quaternion: Vec<[f64; 4]>,
    /// Angular velocity of each row relative to the reference frame, in body axes \[rad/s\]; empty
    /// if the file has no rates or their meaning is ambiguous.
    pub rate: Vec<Vector3>,
    /// Line number of each row, counted from 1.
    pub line: Vec<usize>,
    /// Blocks of the file, each with the interpolation method between its rows.
    pub blocks: Vec<Block>,
    /// Indices of the rows before which the motion must not be interpolated: first rows of a block
    /// that does not begin at the end of the previous block.
    pub breaks: Vec<usize>,
    /// Uncertainty due to the printed digits. The uncertainty of times is 0 if the steps are equal.
    pub rounding: Rounding,
    /// Half a unit of the last digit of the printed times \[s\].
    pub printed_time: f64,
    /// Time of the first row of a table without dates \[s\]; `None` for all other files.
    pub begins: Option<f64>,
    /// Epoch of the first row; `None` if the file does not state it.
    pub epoch: Option<Epoch>,
    /// Name of the reference frame; `None` if the file does not name it.
    pub reference_frame: Option<String>,
    /// Name of the body frame; `None` if the file does not name it.
    pub body_frame: Option<String>,
    /// Number of the line that names the frames, counted from 1; `None` if no line does.
    pub frames_line: Option<usize>,
    /// Statements of the file that were ignored, and assumptions of the reader, one sentence each,
    /// without the final period.
    pub not_taken: Vec<String>,
    /// Warnings about changes that the reader made, such as a normalised quaternion.
    pub warnings: Vec<Diagnostic>,
}

impl Attitudes {
    /// Returns as many attitudes as the file has rows, at uniformly spaced times. They are
    /// interpolated by rotation at a constant rate between the neighbouring rows.
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

/// Reads attitudes from a file. The first bytes determine the kind of the file; `name` is the name
/// of the file in messages.
///
/// # Errors
/// Returns the first error, with its line.
pub fn read_attitudes(input: impl Read, name: &str) -> Result<Attitudes, Diagnostics> {
    let bytes = whole(input, name)?;
    if bytes.starts_with(KERNEL) {
        return kernel::read(&bytes)
            .and_then(|rows| rows.finish(&Source::new(name, "")))
            .map_err(|wrong| resolved(wrong, name, String::new()));
    }
    let source = Source::new(name, text_of(&bytes, name, "an AEM, an attitude file of STK or a table")?);
    read(&source.text)
        .and_then(|rows| rows.finish(&source))
        .map_err(|wrong| Diagnostics(vec![wrong.finding().resolve(std::slice::from_ref(&source))]))
}

/// First bytes of every C-kernel.
const KERNEL: &[u8] = b"DAF/CK";

/// An attitude that a file states for one time.
#[derive(Clone, Debug)]
pub struct AttitudeTold {
    /// Unit quaternion `[w, x, y, z]` from body to reference axes.
    pub quaternion: [f64; 4],
    /// Name of the reference frame; `None` if the file does not name it.
    pub reference_frame: Option<String>,
    /// Name of the body frame; `None` if the file does not name it.
    pub body_frame: Option<String>,
    /// Statements of the file that were ignored, and assumptions of the reader, as in
    /// [`Attitudes::not_taken`].
    pub not_taken: Vec<String>,
}

/// Reads the attitudes at the time `seconds` \[s\] after `epoch`. An APM may state several
/// attitudes, relative to different frames, but only for one time, which must be the requested
/// time. Any other file gives one attitude, interpolated by the method of the file. Tables without
/// dates count their times from `epoch`. `name` is the name of the file in messages.
///
/// # Errors
/// Returns the first error of the file, with its line, or an error if the file has no attitude at
/// this time.
pub fn read_attitudes_at(
    input: impl Read,
    name: &str,
    epoch: Option<Epoch>,
    seconds: f64,
) -> Result<Vec<AttitudeTold>, Diagnostics> {
    let bytes = whole(input, name)?;
    let told = |reason: String, remedy: &str| {
        Diagnostics(vec![Diagnostic::about_file("E0151", name, reason, remedy)])
    };
    let no_epoch = || {
        told(
            "the attitudes of the file are dated, but the spec has no epoch".into(),
            "add epoch = \"2026-11-21T07:00:00 UTC\" at the top",
        )
    };
    if let Ok(text) = encoding::text(&bytes)
        && kind(text).is_some_and(|kind| kind.eq_ignore_ascii_case("APM"))
    {
        let refused = |wrong| resolved(wrong, name, text.into());
        let found = parameters::read(text).map_err(refused)?;
        let wanted = epoch.ok_or_else(no_epoch)?.after(seconds);
        if let Some(one) =
            found.iter().find(|one| one.moment.since(&wanted).abs() > one.open.max(SAME_MOMENT))
        {
            let reason = format!("the attitude is for {}, but {wanted} is needed", one.moment);
            return Err(told(reason, "set the epoch of the spec to that time"));
        }
        return found.into_iter().map(|one| one.told().map_err(refused)).collect();
    }
    let found = read_attitudes(&bytes[..], name)?;
    let time = match (found.epoch, found.begins) {
        (Some(first), _) => epoch.ok_or_else(no_epoch)?.after(seconds).since(&first),
        (None, begins) => seconds - begins.unwrap_or(0.0),
    };
    let last = found.time.last().copied().unwrap_or(0.0);
    // A time may lie outside of the rows by the resolution of the printed times or by the
    // round-off of a sum of seconds.
    let inside = if time.abs() <= found.printed_time.max(SAME_MOMENT) { 0.0 } else { time };
    let inside = if (inside - last).abs() <= found.printed_time.max(SAME_MOMENT) { last } else { inside };
    let Some(quaternion) = found.at(inside) else {
        let reason =
            format!("the file has no attitude {time:.3} s after its first row; it has some for {last:.3} s");
        return Err(told(reason, "use a file that covers this time"));
    };
    let normalised = found.warnings.into_iter().map(|warning| warning.reason);
    Ok(vec![AttitudeTold {
        quaternion,
        reference_frame: found.reference_frame,
        body_frame: found.body_frame,
        not_taken: found.not_taken.into_iter().chain(normalised).collect(),
    }])
}

/// Largest difference of two times that count as equal \[s\]. It allows for the round-off of sums
/// of seconds.
const SAME_MOMENT: f64 = 1e-6;

/// Reads all bytes of a file, whose size is limited.
fn whole(input: impl Read, name: &str) -> Result<Vec<u8>, Diagnostics> {
    let mut bytes = Vec::new();
    let refused = |reason: String, remedy: &str| {
        Diagnostics(vec![Diagnostic::about_file("E0150", name, reason, remedy)])
    };
    input
        .take(MAX_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| refused(format!("cannot read {name}: {error}"), "check the path"))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(refused(format!("the file is larger than {MAX_BYTES} bytes"), "give fewer rows"));
    }
    Ok(bytes)
}

/// Reads the text of a file. `what` describes the expected contents in messages.
pub(crate) fn whole_text(input: impl Read, name: &str, what: &str) -> Result<String, Diagnostics> {
    text_of(&whole(input, name)?, name, what)
}

fn text_of(bytes: &[u8], name: &str, what: &str) -> Result<String, Diagnostics> {
    let refused = |code, reason: String, remedy: &str| {
        Diagnostics(vec![Diagnostic::about_file(code, name, reason, remedy)])
    };
    encoding::text(bytes).map(Into::into).map_err(|why| match why {
        NoText::Utf16 => refused("E0003", "the file is in UTF-16".into(), "save it as UTF-8"),
        NoText::Binary(kind) => {
            let packed = kind.starts_with("compressed") || kind.starts_with("an archive");
            let remedy = if packed { "unpack it first".to_string() } else { format!("give {what}") };
            refused("E0150", format!("the file is not a text file: it is {kind}"), &remedy)
        }
        NoText::At(at) => {
            let line = bytes[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
            let remedy = format!("save the file as UTF-8; it must be {what}");
            let mut found = refused("E0150", format!("line {line} is not UTF-8 text"), &remedy);
            found.0[0].line = line;
            found
        }
    })
}

/// Creates the diagnostics for an error in a text, with its line.
fn resolved(wrong: Wrong, name: &str, text: String) -> Diagnostics {
    Diagnostics(vec![wrong.finding().resolve(&[Source::new(name, text)])])
}

/// Returns the kind of the CCSDS message with which a text begins, such as `AEM`. It is found from
/// the first key, or from the first XML element other than `<ndm>`.
fn kind(text: &str) -> Option<&str> {
    let start = text.trim_start();
    if start.get(..6).is_some_and(|start| start.eq_ignore_ascii_case("CCSDS_")) {
        return start[6..].get(..3);
    }
    if !start.starts_with('<') {
        return None;
    }
    let names = start.split('<').skip(1).filter_map(|tag| {
        let name = tag.split(|sign: char| sign.is_whitespace() || sign == '>' || sign == '/').next()?;
        let name = name.rsplit(':').next()?;
        (!name.is_empty() && !name.starts_with(['?', '!'])).then_some(name)
    });
    names.take(2).find(|name| !name.eq_ignore_ascii_case("ndm"))
}

/// CCSDS messages that contain no attitudes or are not supported, each with a description and a
/// remedy.
const OTHERS: [(&str, &str, &str); 8] = [
    (
        "APM",
        "an attitude parameter message (APM): it has only one attitude, but a motion is needed",
        "give an AEM; or use it as [start] attitude = { file = \"…\" }",
    ),
    ("ACM", "an attitude comprehensive message (ACM): it is not supported", "write the attitudes as an AEM"),
    ("OPM", "an orbit parameter message (OPM): it has no attitudes", "give an AEM"),
    (
        "OEM",
        "an orbit ephemeris message (OEM): it has no attitudes",
        "give an AEM; an OEM is [orbit] oem = \"…\"",
    ),
    (
        "OMM",
        "an orbit mean-elements message (OMM): it has no attitudes",
        "give an AEM; an OMM is [orbit] omm = \"…\"",
    ),
    ("OCM", "an orbit comprehensive message (OCM): it is not supported", "give an AEM"),
    ("CDM", "a conjunction data message (CDM): it has no attitudes", "give an AEM"),
    ("TDM", "a tracking data message (TDM): it has no attitudes", "give an AEM"),
];

fn read(text: &str) -> Result<Rows, Wrong> {
    let first = text.len() - text.trim_start().len();
    let start = &text[first..];
    if start.is_empty() {
        return wrong(0, 0, "the file is empty", "give an AEM, or a table with a header");
    }
    let kind = kind(text);
    let other = OTHERS.iter().find(|(name, ..)| kind.is_some_and(|kind| kind.eq_ignore_ascii_case(name)));
    // An `<ndm>` may contain an `<aem>` after another message.
    if let Some((_, what, remedy)) = other.filter(|_| !start.contains("<aem") && !start.contains(":aem")) {
        let at = kind.map_or(first, |kind| kind.as_ptr() as usize - text.as_ptr() as usize);
        return wrong(at, 3, format!("this is {what}"), *remedy);
    }
    if start.starts_with('<') {
        xml::read(text)
    } else if kind.is_some() {
        keywords::read(text)
    } else if stk::begins(start) {
        stk::read(text)
    } else {
        table::read(text)
    }
}

/// An error at a position in the text, which is a range of bytes.
#[derive(Debug)]
pub(crate) struct Wrong {
    span: (usize, usize),
    reason: String,
    remedy: String,
}

impl Wrong {
    /// Converts a finding in the text to an error at the position of the finding.
    fn of(found: Finding) -> Self {
        let Span { start, end, .. } = found.spot.span;
        Self { span: (start, end), reason: found.reason, remedy: found.remedy }
    }

    fn finding(self) -> Finding {
        self.coded("E0151")
    }

    /// Converts the error to a finding with the error code `code`.
    pub(crate) fn coded(self, code: &'static str) -> Finding {
        let (start, end) = self.span;
        // The span must not be empty, because an empty span at the first byte has no position.
        let span = Span { source: 0, start, end: end.max(start + 1) };
        Finding::error(code, span, self.reason, self.remedy)
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

/// A number of a file, with half a unit of its last printed digit.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Number {
    /// Value of the number.
    pub value: f64,
    half_unit: f64,
}

/// A piece of the text, with its position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece<'t> {
    /// Byte position at which the piece begins.
    pub at: usize,
    /// Text of the piece.
    pub text: &'t str,
}

impl<'t> Piece<'t> {
    /// Returns the piece without leading and trailing blanks.
    pub(crate) fn trimmed(self) -> Self {
        let lead = self.text.len() - self.text.trim_start().len();
        Self { at: self.at + lead, text: self.text.trim() }
    }

    /// Returns whether the piece equals `word`, ignoring upper and lower case.
    pub(crate) fn is(self, word: &str) -> bool {
        self.text.eq_ignore_ascii_case(word)
    }

    /// Returns an error at the position of the piece.
    pub(crate) fn wrong<T>(self, reason: impl Into<String>, remedy: impl Into<String>) -> Result<T, Wrong> {
        wrong(self.at, self.text.len(), reason, remedy)
    }

    /// Splits the piece at blanks into words.
    pub(crate) fn words(self) -> Vec<Self> {
        let words = self.text.split_ascii_whitespace();
        words
            .map(|word| Self {
                at: self.at + word.as_ptr() as usize - self.text.as_ptr() as usize,
                text: word,
            })
            .collect()
    }

    /// Parses the piece as a finite number.
    pub(crate) fn number(self) -> Result<Number, Wrong> {
        match self.text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Number { value, half_unit: half_unit(self.text) }),
            Ok(_) => self.wrong("this number is not finite", "give finite numbers"),
            Err(_) => self.wrong(
                format!("`{}` is not a number", crate::spec::cut(self.text, 30)),
                "write numbers with a point and an exponent, as in 1.5e-3",
            ),
        }
    }
}

/// Returns half a unit of the last printed digit of a number.
fn half_unit(text: &str) -> f64 {
    let (mantissa, exponent) = match text.find(['e', 'E']) {
        Some(at) => (&text[..at], text[at + 1..].parse::<i32>().unwrap_or(0)),
        None => (text, 0),
    };
    let decimals = mantissa.find('.').map_or(0, |point| mantissa.len() - point - 1);
    let decimals = i32::try_from(decimals).unwrap_or(i32::MAX);
    0.5 * 10_f64.powi(exponent.saturating_sub(decimals))
}

/// Returns the lines of a text that are not blank, with their positions.
fn lines(text: &str) -> impl Iterator<Item = Piece<'_>> {
    let pieces = text.split_inclusive('\n').scan(0, |at, line| {
        let piece = Piece { at: *at, text: line };
        *at += line.len();
        Some(piece.trimmed())
    });
    pieces.filter(|piece| !piece.text.is_empty())
}

#[cfg(test)]
mod tests {
    use super::half_unit;

    #[test]
    fn the_last_digit_of_a_number_has_its_size() {
        for (text, half) in
            [("0.02060", 5e-6), ("1", 0.5), ("2.6862511e+002", 5e-6), ("-1.5E-3", 5e-5), ("12.", 0.5)]
        {
            assert!((half_unit(text) / half - 1.0).abs() < 1e-12, "{text}");
        }
    }
}
