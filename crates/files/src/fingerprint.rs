//! Hash that identifies a batch, computed from all data that determine its results. The same hash
//! detects changes of a plan file.
//!
//! The hash is the 64-bit FNV-1a (Fowler, Noll, Vo; <http://www.isthe.com/chongo/tech/comp/fnv/>).
//! The hash of the standard library is not used, because it may change between releases. FNV-1a
//! detects mistakes, but does not protect against malicious changes.

use std::io::{self, Write};

/// State of a hash to which bytes can be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fingerprint(u64);

impl Fingerprint {
    /// Returns a hash that contains the version of the program, because plans of two versions may
    /// differ in the last bit.
    pub fn of_program() -> Self {
        Self(0xcbf2_9ce4_8422_2325).and(env!("CARGO_PKG_VERSION").as_bytes())
    }

    /// Adds a piece of data and its length. The length ensures that another division of the same
    /// bytes into pieces gives another hash.
    pub fn and(mut self, piece: &[u8]) -> Self {
        self.add(piece);
        self.add(&(piece.len() as u64).to_le_bytes());
        self
    }

    /// Appends bytes to the current piece. The hash does not depend on how the bytes are divided
    /// into calls.
    pub fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// Returns the hash as a hexadecimal text, the form in which files contain it.
    pub fn text(self) -> String {
        format!("{:016x}", self.0)
    }
}

/// Writing to the hash adds the written bytes.
impl Write for Fingerprint {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.add(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference values: the test vectors in `test_fnv.c` by the authors of the hash.
    #[test]
    fn hash_is_that_of_its_authors() {
        for (text, hash) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut found = Fingerprint(0xcbf2_9ce4_8422_2325);
            found.add(text.as_bytes());
            assert_eq!(found.0, hash, "{text}");
        }
    }
}
