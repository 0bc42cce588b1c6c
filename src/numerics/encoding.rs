//! The encoding of all text that is read: UTF-8, with or without a byte order mark.

/// The reason why bytes are not text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoText {
    /// The bytes are UTF-16, as some programs on Windows save text.
    Utf16,
    /// The bytes are a binary file of the named kind.
    Binary(&'static str),
    /// The byte at this position is not part of a UTF-8 character.
    At(usize),
}

/// The first bytes of binary files, with the names of their kinds.
const BINARY: [(&[u8], &str); 9] = [
    (b"\x1f\x8b", "compressed by gzip"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"BZh", "compressed by bzip2"),
    (b"\xfd7zXZ\0", "compressed by xz"),
    (b"\x28\xb5\x2f\xfd", "compressed by zstd"),
    (b"\x1f\x9d", "compressed by compress"),
    (b"DAF/CK", "a SPICE C-kernel"),
    (b"DAF/", "a binary SPICE kernel"),
    (b"\x89HDF", "an HDF file"),
];

/// Returns the kind of a binary file according to its first bytes; `None` for text.
pub fn binary(bytes: &[u8]) -> Option<&'static str> {
    BINARY.iter().find(|(start, _)| bytes.starts_with(start)).map(|(_, kind)| *kind)
}

/// The byte order mark of UTF-8, which is ignored.
pub const MARK: &[u8] = b"\xef\xbb\xbf";

/// Returns whether a file with these first bytes is encoded in UTF-16: it has a UTF-16 byte order
/// mark, or every other byte is zero.
pub fn is_utf16(bytes: &[u8]) -> bool {
    /// The number of bytes that are checked.
    const FIRST: usize = 32;
    let zeros = |offset: usize| bytes.iter().skip(offset).step_by(2).take(FIRST).all(|byte| *byte == 0);
    bytes.starts_with(b"\xff\xfe")
        || bytes.starts_with(b"\xfe\xff")
        || (bytes.len() >= 4 && (zeros(0) != zeros(1)))
}

/// Returns the text of a file, without its byte order mark.
///
/// # Errors
/// Returns a [`NoText`] if the bytes are binary, in UTF-16, or not valid UTF-8.
pub fn text(bytes: &[u8]) -> Result<&str, NoText> {
    if let Some(kind) = binary(bytes) {
        return Err(NoText::Binary(kind));
    }
    if is_utf16(bytes) {
        return Err(NoText::Utf16);
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => Ok(text.strip_prefix('\u{feff}').unwrap_or(text)),
        Err(error) => Err(NoText::At(error.valid_up_to())),
    }
}

#[cfg(test)]
mod tests {
    use super::{NoText, text};

    #[test]
    fn marks_are_left_out_and_other_encodings_are_named() {
        assert_eq!(text(b"\xef\xbb\xbfa"), Ok("a"));
        assert_eq!(text("µ".as_bytes()), Ok("µ"));
        assert_eq!(text(b""), Ok(""));
        for utf16 in [&b"\xff\xfea\0"[..], b"\xfe\xff\0a", b"a\0b\0", b"\0a\0b"] {
            assert_eq!(text(utf16), Err(NoText::Utf16));
        }
        assert_eq!(text(b"ab\xe9"), Err(NoText::At(2)));
        assert_eq!(text(b"\x1f\x8b\x08\0"), Err(NoText::Binary("compressed by gzip")));
        assert_eq!(text(b"DAF/CK  \x02\0\0\0"), Err(NoText::Binary("a SPICE C-kernel")));
    }
}
