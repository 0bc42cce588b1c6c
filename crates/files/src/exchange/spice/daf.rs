//! Array files of SPICE (DAF): records of 1024 bytes, written little-endian with one segment.
//!
//! ```text
//! file record | comments | summaries | names | numbers …
//! ```

use std::io::{self, Write};

/// Size of a record \[bytes\].
const RECORD: usize = 1024;
/// Number of characters in a comment record.
const COMMENT: usize = 1000;
/// Byte string that a file transfer in text mode damages, so that readers can detect such a
/// transfer.
const TRANSFER: &[u8] = b"FTPSTR:\r:\n:\r\n:\r\0:\x81:\x10\xce:ENDFTP";
/// Position of the string [`TRANSFER`] in the file record \[bytes\].
const TRANSFER_AT: usize = 699;
/// Number of doubles and number of integers in the summary of a segment.
const SUMMARY: (i32, i32) = (2, 6);
/// Number of characters in the name of a segment, equal to the size of its summary in bytes.
const NAME: usize = 40;

/// A segment of the file: one array with its summary.
pub(super) struct Segment {
    /// Name of the segment.
    pub name: String,
    /// First and last time of the array \[clock ticks\].
    pub bounds: [f64; 2],
    /// Numbers of the structure, of the reference frame and of the segment type; then 1 if the
    /// segment has rates, 0 if it has none.
    pub integers: [i32; 4],
    /// Contents of the array, as doubles.
    pub numbers: Vec<f64>,
}

/// An array file with one segment.
pub(super) struct Daf {
    /// Kind of the file, such as "CK".
    pub kind: &'static str,
    /// Internal name of the file.
    pub name: String,
    /// Lines of the comment area.
    pub comment: Vec<String>,
    pub segment: Segment,
}

impl Daf {
    /// Writes the whole file.
    pub fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        let comments = self.comments();
        // Records, and words of eight bytes, are numbered from 1.
        let summaries = 2 + comments.len() / RECORD;
        let begin = (summaries + 1) * RECORD / 8 + 1;
        let end = begin + self.segment.numbers.len() - 1;
        let word = |value: usize| {
            i32::try_from(value)
                .map_err(|_| io::Error::other("the motion has more numbers than a C-kernel can hold"))
        };
        let (summary_record, begin, end, free) = (word(summaries)?, word(begin)?, word(end)?, word(end + 1)?);

        let mut file = vec![0; RECORD];
        put(&mut file, 0, format!("{:<8}", format!("DAF/{}", self.kind)).as_bytes());
        put(&mut file, 8, &SUMMARY.0.to_le_bytes());
        put(&mut file, 12, &SUMMARY.1.to_le_bytes());
        put(&mut file, 16, padded(&self.name, 60).as_bytes());
        put(&mut file, 76, &summary_record.to_le_bytes());
        put(&mut file, 80, &summary_record.to_le_bytes());
        put(&mut file, 84, &free.to_le_bytes());
        put(&mut file, 88, b"LTL-IEEE");
        put(&mut file, TRANSFER_AT, TRANSFER);
        output.write_all(&file)?;
        output.write_all(&comments)?;

        // The only summary record has no predecessor and no successor, and contains one summary.
        let mut summary: Vec<u8> =
            [0.0, 0.0, 1.0].into_iter().chain(self.segment.bounds).flat_map(f64::to_le_bytes).collect();
        let integers = self.segment.integers.into_iter().chain([begin, end]);
        summary.extend(integers.flat_map(i32::to_le_bytes));
        summary.resize(RECORD, 0);
        output.write_all(&summary)?;
        output.write_all(padded(&padded(&self.segment.name, NAME), RECORD).as_bytes())?;

        for number in &self.segment.numbers {
            output.write_all(&number.to_le_bytes())?;
        }
        // The last record is padded to its full length.
        let over = self.segment.numbers.len() * 8 % RECORD;
        output.write_all(&vec![0; (RECORD - over) % RECORD])
    }

    /// Returns the comment area: lines separated by NUL and terminated by EOT, in records of 1000
    /// characters.
    fn comments(&self) -> Vec<u8> {
        let mut text: Vec<u8> = Vec::new();
        for line in &self.comment {
            text.extend(line.bytes().map(|byte| if byte.is_ascii_graphic() { byte } else { b' ' }));
            text.push(0);
        }
        text.push(4);
        let mut records = Vec::new();
        for piece in text.chunks(COMMENT) {
            let at = records.len();
            records.resize(at + RECORD, 0);
            put(&mut records, at, piece);
        }
        records
    }
}

fn put(bytes: &mut [u8], at: usize, what: &[u8]) {
    bytes[at..at + what.len()].copy_from_slice(what);
}

/// Returns the ASCII characters of a text, truncated or padded with blanks to `width` characters.
fn padded(text: &str, width: usize) -> String {
    let ascii = text.chars().filter(char::is_ascii).take(width).collect::<String>();
    format!("{ascii:<width$}")
}
