//! SPICE's array files (DAF): records of 1024 bytes, here little-endian with one segment.
//!
//! ```text
//! file record | comments | summaries | names | numbers …
//! ```

use std::io::{self, Write};

/// Bytes of a record.
const RECORD: usize = 1024;
/// Characters of a comment record.
const COMMENT: usize = 1000;
/// A string that a transfer in text mode damages, which reveals such a transfer.
const TRANSFER: &[u8] = b"FTPSTR:\r:\n:\r\n:\r\0:\x81:\x10\xce:ENDFTP";
/// The position of that string in the file record.
const TRANSFER_AT: usize = 699;
/// Numbers and integers of a summary.
const SUMMARY: (i32, i32) = (2, 6);
/// The number of characters in the name of a segment: the words of a summary.
const NAME: usize = 40;

/// One array with its summary.
pub(super) struct Segment {
    /// Name of the array.
    pub name: String,
    /// First and last time.
    pub bounds: [f64; 2],
    /// Structure, reference frame, type, and whether the segment has rates.
    pub integers: [i32; 4],
    /// The array.
    pub numbers: Vec<f64>,
}

/// A file of one segment.
pub(super) struct Daf {
    /// "CK" and the like.
    pub kind: &'static str,
    /// The internal name.
    pub name: String,
    /// Lines of comments.
    pub comment: Vec<String>,
    pub segment: Segment,
}

impl Daf {
    /// Writes the file.
    pub fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        let comments = self.comments();
        // Records count from 1, words (of eight bytes) too.
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

        // No next, no previous record of summaries, one summary.
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
        // The last record is whole.
        let over = self.segment.numbers.len() * 8 % RECORD;
        output.write_all(&vec![0; (RECORD - over) % RECORD])
    }

    /// Returns the comment area: lines parted by NUL, the last followed by EOT, in records of 1000
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

/// Returns ASCII with exactly `width` characters.
fn padded(text: &str, width: usize) -> String {
    let ascii = text.chars().filter(char::is_ascii).take(width).collect::<String>();
    format!("{ascii:<width$}")
}
