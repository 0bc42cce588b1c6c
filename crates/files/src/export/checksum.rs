//! Checksum of a plan file: a hash of all its values.
//!
//! The witnesses check everything that follows from the motion. Costates, gains, covariances,
//! conjugate points and rivals do not follow from the motion, so only a checksum reveals a change
//! of their values. The checksum covers the values but not their notation: it remains valid if a
//! program writes the same numbers with other digits, blanks or order of keys. It does not cover
//! `solve_time_s`, which differs between two runs.

use crate::fingerprint::Fingerprint;
use serde::{Deserialize, Serialize};
use serde_json::ser::Formatter;
use std::io::{self, Write};

/// Result of checking a plan against the checksum of its file.
///
/// This result is not a part of the plan, so any two results compare as equal.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(from = "Option<String>")]
pub enum Seal {
    /// The plan was computed, so it has no file.
    Made,
    /// The file has no checksum.
    #[default]
    Missing,
    /// The checksum of the file, which has not been checked yet.
    Read(String),
    /// The checksum cannot be checked: another program or another version wrote the file, or the
    /// spec was removed from the file.
    Foreign,
    /// The checksum agrees with the contents, which are unchanged since the file was written.
    Intact,
    /// The checksum does not agree with the contents, or is missing from a file that this version
    /// wrote. A value was changed or the checksum was removed.
    Broken,
}

impl PartialEq for Seal {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl From<Option<String>> for Seal {
    fn from(text: Option<String>) -> Self {
        text.map_or(Self::Missing, Self::Read)
    }
}

impl Seal {
    /// Returns the checksum that was read from the file; an empty text if the file has none.
    pub(super) fn text(&self) -> &str {
        if let Self::Read(text) = self { text } else { "" }
    }

    /// Compares the checksum that was read with the checksum of the contents `file`. `own` is true
    /// if this version of the program wrote the whole file.
    pub(super) fn compared(&self, file: &impl Serialize, own: bool) -> Self {
        match self {
            Self::Read(_) | Self::Missing if !own => Self::Foreign,
            Self::Read(told) if checksum(file).is_ok_and(|found| found == *told) => Self::Intact,
            Self::Read(_) | Self::Missing => Self::Broken,
            other => other.clone(),
        }
    }
}

/// A plan file that is serialised with its checksum as the last key.
#[derive(Serialize)]
pub(super) struct Sealed<'a, T: Serialize> {
    #[serde(flatten)]
    file: &'a T,
    checksum: String,
}

impl<'a, T: Serialize> Sealed<'a, T> {
    /// Computes the checksum of the contents of a file, which is added when the file is written.
    ///
    /// # Errors
    /// Returns an error if the trajectory has a number that is not finite.
    pub fn new(file: &'a T) -> Result<Self, serde_json::Error> {
        Ok(Self { file, checksum: checksum(file)? })
    }

    /// Returns the checksum as text.
    pub fn checksum(&self) -> &str {
        &self.checksum
    }
}

/// Computes the checksum of all values of a document.
///
/// # Errors
/// Returns an error if the trajectory has a number that is not finite.
pub(super) fn checksum(file: &impl Serialize) -> Result<String, serde_json::Error> {
    let mut hash = Fingerprint::of_program();
    file.serialize(&mut serde_json::Serializer::with_formatter(&mut hash, Values::default()))?;
    Ok(hash.text())
}

/// Key of the value that the checksum does not cover.
const FREE: &str = "solve_time_s";

/// JSON formatter that writes each number as the bits of an `f64`. The bits do not depend on the
/// decimal notation and are faster to compute than digits.
#[derive(Default)]
struct Values {
    depth: usize,
    /// True while a key of the outermost object is being written.
    key: bool,
    /// True while a value that the checksum does not cover is being written.
    free: bool,
}

impl Formatter for Values {
    fn write_f64<W: Write + ?Sized>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        // Adding zero turns −0 into 0, because some programs do not distinguish the two.
        let value = if self.free { 0.0 } else { value + 0.0 };
        writer.write_all(&value.to_bits().to_le_bytes())
    }

    fn write_u64<W: Write + ?Sized>(&mut self, writer: &mut W, value: u64) -> io::Result<()> {
        self.write_f64(writer, value as f64)
    }

    fn write_i64<W: Write + ?Sized>(&mut self, writer: &mut W, value: i64) -> io::Result<()> {
        self.write_f64(writer, value as f64)
    }

    fn begin_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"{")
    }

    fn end_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        writer.write_all(b"}")
    }

    fn begin_object_key<W: Write + ?Sized>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.key = self.depth == 1;
        if first { Ok(()) } else { writer.write_all(b",") }
    }

    fn end_object_key<W: Write + ?Sized>(&mut self, _: &mut W) -> io::Result<()> {
        self.key = false;
        Ok(())
    }

    fn write_string_fragment<W: Write + ?Sized>(&mut self, writer: &mut W, text: &str) -> io::Result<()> {
        if self.key {
            self.free = text == FREE;
        }
        writer.write_all(text.as_bytes())
    }
}
