//! The checksum of a plan file: a hash of all its values.
//!
//! The witnesses judge everything that follows from the motion. Costates, gains, covariances,
//! conjugate points and rivals do not follow from it, so only a checksum shows that one of their
//! figures was changed. It covers values and not their notation: a program that writes the same
//! numbers with other digits, blanks or order of keys keeps it. `solve_time_s` is left out, because
//! it differs between two runs.

use crate::fingerprint::Fingerprint;
use serde::{Deserialize, Serialize};
use serde_json::ser::Formatter;
use std::io::{self, Write};

/// The relation of a plan file to its checksum.
///
/// It is no content of the plan, so all of its values are equal.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(from = "Option<String>")]
pub enum Seal {
    /// The plan was not read from a file.
    Made,
    /// The file has no checksum.
    #[default]
    Missing,
    /// The checksum, before it is compared.
    Read(String),
    /// Another program or version wrote the file, or its spec was removed: no checksum can be judged.
    Foreign,
    /// The contents are unchanged since the file was written.
    Intact,
    /// A value was changed after the file was written, or the checksum was removed.
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
    /// Returns the checksum as it was read, if the file has one.
    pub(super) fn text(&self) -> &str {
        if let Self::Read(text) = self { text } else { "" }
    }

    /// Compares the checksum that was read with the contents `file`; `own` states whether this
    /// version of the program wrote them all.
    pub(super) fn compared(&self, file: &impl Serialize, own: bool) -> Self {
        match self {
            Self::Read(_) | Self::Missing if !own => Self::Foreign,
            Self::Read(told) if checksum(file).is_ok_and(|found| found == *told) => Self::Intact,
            Self::Read(_) | Self::Missing => Self::Broken,
            other => other.clone(),
        }
    }
}

/// A plan file with its checksum as the last key.
#[derive(Serialize)]
pub(super) struct Sealed<'a, T: Serialize> {
    #[serde(flatten)]
    file: &'a T,
    checksum: String,
}

impl<'a, T: Serialize> Sealed<'a, T> {
    /// Adds the checksum to a file.
    ///
    /// # Errors
    /// A trajectory that is not finite.
    pub fn new(file: &'a T) -> Result<Self, serde_json::Error> {
        Ok(Self { file, checksum: checksum(file)? })
    }

    /// Returns the checksum.
    pub fn checksum(&self) -> &str {
        &self.checksum
    }
}

/// Returns the checksum of all values of a document.
///
/// # Errors
/// A trajectory that is not finite.
pub(super) fn checksum(file: &impl Serialize) -> Result<String, serde_json::Error> {
    let mut hash = Fingerprint::of_program();
    file.serialize(&mut serde_json::Serializer::with_formatter(&mut hash, Values::default()))?;
    Ok(hash.text())
}

/// The key of the file that the checksum does not cover.
const FREE: &str = "solve_time_s";

/// Writes numbers as the bits of an `f64`, which is quicker than digits, and independent of them.
#[derive(Default)]
struct Values {
    depth: usize,
    /// A key of the outer level is being written.
    key: bool,
    /// The value is one that the checksum does not cover.
    free: bool,
}

impl Formatter for Values {
    fn write_f64<W: Write + ?Sized>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        // Adding zero makes −0 zero, because some programs do not distinguish the two.
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
