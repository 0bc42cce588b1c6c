//! C-kernels of SPICE with segments of type 3, with or without rates, for a single structure.
//!
//! The C-matrix maps reference components to body components. The quaternion of the file is
//! therefore the conjugate of the quaternion in plan files, scalar first. Rates are in reference
//! axes. Between rows, SPICE rotates about a fixed axis at a constant rate. Times are clock ticks.
//! A C-kernel states neither the length of a tick nor the zero of the clock; they are read from the
//! comment area if this program wrote the kernel.

use super::between::Between;
use super::rows::{Moved, Rows};
use super::{Number, Piece, Wrong, wrong};
use crate::epoch::Epoch;
use crate::exchange::spice::FRAMES;
use slewkit::{Vector3, lie};

/// Length of a record of the file \[bytes\].
const RECORD: usize = 1024;
/// Length of a number of the file \[bytes\].
const WORD: usize = 8;
/// Largest number of summary records that are read.
const MOST_RECORDS: usize = 1 << 16;

/// Text by which the comment area of a kernel of this program states the unit of its clock.
const CLOCK: &str = "one tick is a microsecond of TT";
/// Text that precedes the epoch of time zero in the comment area of a kernel of this program.
const EPOCH: &str = "Epoch: ";
/// Length of a clock tick of a kernel of this program \[s\].
const TICK: f64 = 1e-6;

/// Bytes of a file, with their byte order.
struct Bytes<'b> {
    all: &'b [u8],
    little: bool,
}

impl Bytes<'_> {
    fn word<const N: usize>(&self, at: usize) -> Option<[u8; N]> {
        let mut word: [u8; N] = self.all.get(at..at.checked_add(N)?)?.try_into().ok()?;
        if !self.little {
            word.reverse();
        }
        Some(word)
    }

    fn number(&self, at: usize) -> Option<f64> {
        self.word(at).map(f64::from_le_bytes)
    }

    /// Reads a nonnegative integer of four bytes at byte `at`.
    fn count(&self, at: usize) -> Option<usize> {
        self.word(at).and_then(|word| usize::try_from(i32::from_le_bytes(word)).ok())
    }

    fn integer(&self, at: usize) -> Option<i32> {
        self.word(at).map(i32::from_le_bytes)
    }

    /// Returns the text of the comment area, which lies between the file record and the summary
    /// record number `first_summary`.
    fn comments(&self, first_summary: usize) -> String {
        let records = self.all.chunks(RECORD).skip(1).take(first_summary.saturating_sub(2));
        let bytes = records.flat_map(|record| record.iter().take(1000));
        bytes
            .take_while(|byte| **byte != 4)
            .map(|byte| if *byte == 0 { '\n' } else { char::from(*byte) })
            .collect()
    }
}

/// Summary of a segment: its structure, frame and type, whether it has rates, and the first and
/// last word of its array, counted from 1.
struct Summary {
    structure: i32,
    frame: i32,
    kind: i32,
    rates: bool,
    words: [usize; 2],
}

/// Reads a C-kernel and returns its rows.
pub(super) fn read(bytes: &[u8]) -> Result<Rows, Wrong> {
    let cut_off = || Wrong {
        span: (0, 0),
        reason: "the data of the kernel are incomplete".into(),
        remedy: "the file is cut off".into(),
    };
    let little = bytes.get(88..96).is_some_and(|order| order == b"LTL-IEEE");
    if !little && bytes.get(88..96).is_none_or(|order| order != b"BIG-IEEE") {
        return wrong(0, 0, "the kernel does not state its byte order", "write it again with a SPICE tool");
    }
    let file = Bytes { all: bytes, little };
    let first = file.count(76).ok_or_else(cut_off)?;
    let comments = file.comments(first);
    let epoch = comments.lines().find_map(|line| Epoch::parse(line.strip_prefix(EPOCH)?).ok());
    let Some(epoch) = epoch.filter(|_| comments.contains(CLOCK)) else {
        return wrong(
            0,
            0,
            "times of a C-kernel are ticks of a clock, and the kernel does not state the tick length",
            "write the attitudes as an AEM or a table",
        );
    };
    let summaries = summaries(&file, first).ok_or_else(cut_off)?;
    let Some(one) = summaries.first() else {
        return wrong(0, 0, "the kernel has no segment", "give a C-kernel with attitudes");
    };
    if let Some(other) =
        summaries.iter().find(|other| other.structure != one.structure || other.frame != one.frame)
    {
        let reason = format!("the kernel has the structures {} and {}", one.structure, other.structure);
        return wrong(0, 0, reason, "give one kernel for each of them, against one frame");
    }
    let mut rows = Rows::default();
    let frame = FRAMES.iter().find(|(number, _)| *number == one.frame);
    rows.found.reference_frame = Some(frame.map_or_else(
        || format!("the frame of SPICE with the number {}", one.frame),
        |(_, name)| (*name).into(),
    ));
    for summary in &summaries {
        if summary.kind != 3 {
            let reason = format!("segments of type {} are not supported", summary.kind);
            return wrong(0, 0, reason, "write the attitudes as type 3, as an AEM or as a table");
        }
        segment(&file, summary, &mut rows).ok_or_else(cut_off)??;
    }
    let begins = rows.found.time.first().copied().unwrap_or(0.0);
    rows.found.epoch = Some(epoch.after(begins));
    Ok(rows)
}

/// Returns the summaries of all segments. They are stored in a chain of records, which begins with
/// record number `first`. Returns `None` if the chain is damaged.
fn summaries(file: &Bytes<'_>, first: usize) -> Option<Vec<Summary>> {
    const SUMMARY: usize = 5;
    let (mut found, mut record) = (Vec::new(), first);
    for _ in 0..MOST_RECORDS {
        if record == 0 {
            return Some(found);
        }
        let at = (record - 1).checked_mul(RECORD)?;
        let (next, count) = (file.number(at)?, file.number(at + 2 * WORD)?);
        // A record has room for at most 25 summaries.
        if !(0.0..=25.0).contains(&count) {
            return None;
        }
        for k in 0..count as usize {
            let at = at + (3 + SUMMARY * k + 2) * WORD;
            found.push(Summary {
                structure: file.integer(at)?,
                frame: file.integer(at + 4)?,
                kind: file.integer(at + 8)?,
                rates: file.integer(at + 12)? == 1,
                words: [file.count(at + 16)?, file.count(at + 20)?],
            });
        }
        record = if (0.0..1e9).contains(&next) { next as usize } else { return None };
    }
    None
}

/// Adds the rows of a segment. Returns `None` if the file is shorter than the summary of the
/// segment states.
fn segment(file: &Bytes<'_>, summary: &Summary, rows: &mut Rows) -> Option<Result<(), Wrong>> {
    let [begin, end] = summary.words.map(|word| word.wrapping_sub(1).wrapping_mul(WORD));
    let of = |number: f64| (0.0..1e9).contains(&number).then_some(number as usize);
    let count = of(file.number(end)?)?;
    let intervals = of(file.number(end.checked_sub(WORD)?)?)?;
    let width = if summary.rates { 7 } else { 4 };
    let times = begin.checked_add(count.checked_mul(width * WORD)?)?;
    // The times are followed by every hundredth time, the starts of the interpolation intervals,
    // and every hundredth start.
    let starts = times.checked_add((count + count.saturating_sub(1) / 100) * WORD)?;
    let start_of = |k: usize| file.number(starts + k * WORD);
    let mut interval = 0;
    for k in 0..count {
        let at = begin + k * width * WORD;
        let tick = file.number(times + k * WORD)?;
        let [w, x, y, z] = [0, 1, 2, 3].map(|part| file.number(at + part * WORD));
        let quaternion = [w?, -x?, -y?, -z?];
        if interval < intervals && start_of(interval)? <= tick {
            rows.begin(Between::OneRate);
            interval += 1;
        }
        let rate = if summary.rates {
            let [x, y, z] = [4, 5, 6].map(|part| file.number(at + part * WORD));
            Some(lie::rotation_from_quaternion(&quaternion).tr_mul(&Vector3::new(x?, y?, z?)))
        } else {
            None
        };
        let moved = Moved { quaternion, rate, open: (0.0, 0.0) };
        // A kernel has no lines, so errors point to the beginning of the file.
        let here = Piece { at: 0, text: "" };
        if let Err(wrong) = rows.add(here, Number { value: tick * TICK, half_unit: 0.0 }, moved) {
            return Some(Err(wrong));
        }
    }
    Some(Ok(()))
}
