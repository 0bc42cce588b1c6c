//! NumPy archives: uncompressed ZIP archives with one array file for each quantity.

use super::Record;
use crate::export::{ExportError, table};
use std::io::{self, Write};

/// First bytes of an array file of format 1.0.
const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
/// Alignment of the end of a header \[bytes\].
const ALIGNMENT: usize = 64;

/// Writes each quantity of the trajectory as an array named after its key in plan files.
pub(super) fn write(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    let mut arrays = Arrays::new(output);
    for (key, rows, width, numbers) in table(record.trajectory) {
        arrays.add(key, rows, width, &numbers)?;
    }
    if let Some((width, numbers)) = record.gain_rows() {
        arrays.add("gains", numbers.len() / width.max(1), width, &numbers)?;
    }
    if let Some(numbers) = record.arc_rows() {
        arrays.add("arc_gains", numbers.len() / 7, 7, &numbers)?;
    }
    Ok(arrays.close()?)
}

/// An archive of named arrays that is being written, one array after the other.
pub struct Arrays<'o>(Archive<'o>);

impl<'o> Arrays<'o> {
    /// Begins an archive in the stream `output`.
    pub fn new(output: &'o mut dyn Write) -> Self {
        Self(Archive { output, written: 0, directory: Vec::new(), files: 0 })
    }

    /// Appends an array of `rows` rows of `width` numbers; a width of 1 gives a one-dimensional
    /// array.
    ///
    /// # Errors
    /// Returns an error if the stream fails, or if the archive exceeds 4 GiB.
    pub fn add(&mut self, name: &str, rows: usize, width: usize, numbers: &[f64]) -> io::Result<()> {
        self.0.add(&format!("{name}.npy"), &array(rows, width, numbers))
    }

    /// Writes the directory at the end of the archive.
    ///
    /// # Errors
    /// Returns the errors of the stream.
    pub fn close(self) -> io::Result<()> {
        self.0.close()
    }
}

/// Returns the bytes of an array file with rows of `width` numbers; a width of 1 gives a
/// one-dimensional array.
fn array(rows: usize, width: usize, numbers: &[f64]) -> Vec<u8> {
    let shape = if width == 1 { format!("({rows},)") } else { format!("({rows}, {width})") };
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    let bytes = MAGIC.len() + 2;
    let length = (bytes + header.len() + 1).next_multiple_of(ALIGNMENT) - bytes;
    header = format!("{header:<width$}\n", width = length - 1);
    let mut file = MAGIC.to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.into_bytes());
    file.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    file
}

/// A ZIP archive whose files are stored without compression.
struct Archive<'o> {
    output: &'o mut dyn Write,
    written: usize,
    directory: Vec<u8>,
    files: u16,
}

impl Archive<'_> {
    /// Appends a file to the archive.
    fn add(&mut self, name: &str, content: &[u8]) -> io::Result<()> {
        let fits = |value: usize| {
            u32::try_from(value).map_err(|_| io::Error::other("more than such an archive can hold, 4 GiB"))
        };
        let (size, at) = (fits(content.len())?, fits(self.written)?);
        // Version 2.0, no flags, no compression, and 1980-01-01, as in archives without dates.
        let mut about: Vec<u8> = [20_u16, 0, 0, 0, 0x21].into_iter().flat_map(u16::to_le_bytes).collect();
        about.extend([crc32(content), size, size].into_iter().flat_map(u32::to_le_bytes));
        about.extend([name.len() as u16, 0].into_iter().flat_map(u16::to_le_bytes));
        let local = [&b"PK\x03\x04"[..], &about, name.as_bytes()].concat();
        self.output.write_all(&local)?;
        self.output.write_all(content)?;
        self.written += local.len() + content.len();
        self.directory.extend([&b"PK\x01\x02\x14\x00"[..], &about, &[0; 10], &at.to_le_bytes()].concat());
        self.directory.extend(name.as_bytes());
        self.files += 1;
        Ok(())
    }

    /// Writes the directory at the end of the archive.
    fn close(self) -> io::Result<()> {
        self.output.write_all(&self.directory)?;
        let mut end = b"PK\x05\x06\0\0\0\0".to_vec();
        end.extend([self.files, self.files].into_iter().flat_map(u16::to_le_bytes));
        end.extend([self.directory.len() as u32, self.written as u32].into_iter().flat_map(u32::to_le_bytes));
        end.extend([0, 0]);
        self.output.write_all(&end)
    }
}

/// Returns the CRC-32 checksum (IEEE 802.3), which ZIP archives and flight tables use.
pub(super) fn crc32(bytes: &[u8]) -> u32 {
    const POLYNOMIAL: u32 = 0xedb8_8320;
    let mut table = [0_u32; 256];
    for (index, entry) in table.iter_mut().enumerate() {
        *entry =
            (0..8).fold(index as u32, |value, _| (value >> 1) ^ (POLYNOMIAL & (value & 1).wrapping_neg()));
    }
    !bytes.iter().fold(!0, |value, byte| (value >> 8) ^ table[usize::from(value as u8 ^ byte)])
}

#[cfg(test)]
mod tests {
    /// The check value for CRC-32/ISO-HDLC in the catalogue of parametrised CRC algorithms.
    #[test]
    fn checksum_is_that_of_the_catalogue() {
        assert_eq!(super::crc32(b"123456789"), 0xcbf4_3926);
    }
}
