//! Reading of archives written by [`Arrays`](super::Arrays), or by `numpy.savez` with the same
//! arrays: stored files of little-endian doubles.

use super::numpy::crc32;
use std::collections::BTreeMap;
use std::io::{self, Read};

/// Largest size of an archive that is read \[bytes\], which bounds the memory. No archive of this
/// program is larger.
const MOST: u64 = 64 << 20;

/// Shape and numbers of one array.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Lengths of the dimensions of the array.
    pub shape: Vec<usize>,
    /// Numbers of the array, row by row.
    pub numbers: Vec<f64>,
}

/// Reads all arrays of an archive and returns them by name.
///
/// # Errors
/// Returns an error if the input cannot be read or is larger than 64 MiB, if it is not an archive
/// of stored arrays of doubles, or if its checksums do not agree.
pub fn read_arrays(input: impl Read) -> io::Result<BTreeMap<String, Array>> {
    let mut bytes = Vec::new();
    input.take(MOST + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MOST {
        return Err(wrong("it is larger than 64 MiB"));
    }
    // The end record of the directory is the last record; in files of other programs, a comment may
    // follow it.
    let end = bytes.len().checked_sub(22).ok_or_else(|| wrong("it is not a ZIP archive"))?;
    let is_end = |at: &usize| bytes[*at..].starts_with(b"PK\x05\x06");
    let end = (end.saturating_sub(0xffff)..=end).rev().find(is_end);
    let end = end.ok_or_else(|| wrong("it is not a ZIP archive, or its end is missing"))?;
    let count = number::<2>(&bytes, end + 10)?;
    let mut at = number::<4>(&bytes, end + 16)?;
    let mut arrays = BTreeMap::new();
    for _ in 0..count {
        if slice(&bytes, at, 4)? != b"PK\x01\x02" {
            return Err(wrong("its directory is damaged"));
        }
        let [method, sum] = [number::<2>(&bytes, at + 10)?, number::<4>(&bytes, at + 16)?];
        let [packed, size] = [number::<4>(&bytes, at + 20)?, number::<4>(&bytes, at + 24)?];
        let [name, extra, comment] = [28, 30, 32].map(|place| number::<2>(&bytes, at + place));
        let (name_length, local) = (name?, number::<4>(&bytes, at + 42)?);
        let name = String::from_utf8_lossy(slice(&bytes, at + 46, name_length)?).into_owned();
        at += 46 + name_length + extra? + comment?;
        if method != 0 || packed != size {
            return Err(wrong("its files are compressed: write it with `numpy.savez`"));
        }
        let begin = local + 30 + number::<2>(&bytes, local + 26)? + number::<2>(&bytes, local + 28)?;
        let content = slice(&bytes, begin, size)?;
        if crc32(content) as usize != sum {
            return Err(wrong("a checksum is wrong: the file is damaged"));
        }
        if let Some(name) = name.strip_suffix(".npy") {
            arrays.insert(name.into(), array(content)?);
        }
    }
    Ok(arrays)
}

/// Reads one array file of format 1.0.
fn array(content: &[u8]) -> io::Result<Array> {
    if slice(content, 0, 8)? != b"\x93NUMPY\x01\x00" {
        return Err(wrong("an array is not in NumPy's format 1.0"));
    }
    let length = number::<2>(content, 8)?;
    let header = String::from_utf8_lossy(slice(content, 10, length)?).replace(' ', "");
    if !header.contains("'descr':'<f8'") || !header.contains("'fortran_order':False") {
        return Err(wrong("an array has other numbers than doubles in rows"));
    }
    let shape = header.split_once("'shape':(").and_then(|(_, rest)| rest.split_once(')'));
    let shape = shape.ok_or_else(|| wrong("an array has no shape"))?.0;
    let lengths = shape.split(',').filter(|part| !part.is_empty()).map(str::parse);
    let shape: Vec<usize> =
        lengths.collect::<Result<_, _>>().map_err(|_| wrong("an array has an unusable shape"))?;
    let numbers = slice(content, 10 + length, content.len().saturating_sub(10 + length))?;
    let count = shape.iter().try_fold(8_usize, |product, length| product.checked_mul(*length));
    if count != Some(numbers.len()) {
        return Err(wrong("an array is not as long as its shape"));
    }
    let double = |bytes: &[u8]| bytes.try_into().map_or(f64::NAN, f64::from_le_bytes);
    Ok(Array { shape, numbers: numbers.chunks_exact(8).map(double).collect() })
}

fn wrong(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

/// Returns `length` bytes from position `at`, or an error if they extend beyond the end of the
/// file.
fn slice(bytes: &[u8], at: usize, length: usize) -> io::Result<&[u8]> {
    let end = at.checked_add(length);
    end.and_then(|end| bytes.get(at..end)).ok_or_else(|| wrong("it is cut off"))
}

/// Reads a little-endian integer of N bytes at position `at`.
fn number<const N: usize>(bytes: &[u8], at: usize) -> io::Result<usize> {
    Ok(slice(bytes, at, N)?.iter().rev().fold(0, |value, byte| value << 8 | usize::from(*byte)))
}

#[cfg(test)]
mod tests {
    use super::super::Arrays;
    use super::*;

    fn archive() -> Vec<u8> {
        let mut bytes: Vec<u8> = Vec::new();
        let mut arrays = Arrays::new(&mut bytes);
        arrays.add("first", 2, 3, &[1.0, 2.0, 3.0, -4.0, 5.5, 1e-300]).unwrap();
        arrays.add("one", 1, 1, &[0.1]).unwrap();
        arrays.close().unwrap();
        bytes
    }

    #[test]
    fn arrays_survive_their_archive() {
        let arrays = read_arrays(&archive()[..]).unwrap();
        assert_eq!(arrays.len(), 2);
        assert_eq!(arrays["first"].shape, [2, 3]);
        assert_eq!(arrays["first"].numbers[3..], [-4.0, 5.5, 1e-300]);
        assert_eq!((&arrays["one"].shape[..], arrays["one"].numbers[0]), (&[1][..], 0.1));
    }

    /// A truncated or changed file causes neither a panic nor wrong numbers.
    #[test]
    fn damaged_archives_are_errors_or_unchanged() {
        let whole = archive();
        let expected = read_arrays(&whole[..]).unwrap();
        for end in 0..whole.len() {
            assert!(read_arrays(&whole[..end]).is_err(), "{end}");
        }
        for place in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[place] ^= 0x41;
            if let Ok(found) = read_arrays(&damaged[..]) {
                let known = found.iter().all(|(_, array)| expected.values().any(|other| other == array));
                assert!(known, "{place}");
            }
        }
    }
}
