//! A hash that identifies a batch by all data that determine its results, and shows whether a plan
//! file was changed.
//!
//! FNV-1a of 64 bits (Fowler, Noll, Vo; <http://www.isthe.com/chongo/tech/comp/fnv/>), because the
//! one of the standard library may change between releases. It guards against mistakes, not against
//! malice.

use std::io::{self, Write};

/// A running hash.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fingerprint(u64);

impl Fingerprint {
    /// Returns the hash of this version of the program: another version may plan another last
    /// bit.
    pub fn of_program() -> Self {
        Self(0xcbf2_9ce4_8422_2325).and(env!("CARGO_PKG_VERSION").as_bytes())
    }

    /// Adds a piece; the boundaries of the pieces count.
    pub fn and(mut self, piece: &[u8]) -> Self {
        self.add(piece);
        self.add(&(piece.len() as u64).to_le_bytes());
        self
    }

    /// Adds bytes of a piece; the places where pieces end have no effect.
    pub fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// Returns the text of the hash in files.
    pub fn text(self) -> String {
        format!("{:016x}", self.0)
    }
}

/// Every byte that is written is added.
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

    /// Test vectors of the authors' `test_fnv.c`.
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
