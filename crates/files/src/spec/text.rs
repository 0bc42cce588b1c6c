//! Reading of files as text, with checks of their size, kind and encoding.

use super::{Diagnostic, Diagnostics, Finding, MAX_BYTES, Source, Span, short};
use slewkit::numerics::encoding::{self, NoText};
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

fn refuse(code: &'static str, file: &str, reason: String, remedy: &str) -> Diagnostics {
    Diagnostics(vec![Diagnostic::about_file(code, file, reason, remedy)])
}

/// Reads the bytes of a file, or of a pipe, up to the size limit.
pub(super) fn from_file(path: &Path, name: &str) -> Result<Vec<u8>, Diagnostics> {
    let unreadable = |error: std::io::Error| {
        let remedy = "check the path; `slew init` writes a starter spec";
        refuse("E0015", name, format!("cannot read the spec: {error}"), remedy)
    };
    let metadata = fs::metadata(path).map_err(unreadable)?;
    let kind = metadata.file_type();
    if kind.is_dir() {
        return Err(refuse("E0014", name, "is a directory, not a file".into(), "name a file in it"));
    }
    if !kind.is_file() && !is_pipe(kind) {
        return Err(refuse("E0014", name, "is a device or a socket, not a file".into(), "name a file"));
    }
    let file = File::open(path).map_err(unreadable)?;
    from_stream(file, name, kind.is_file().then_some(metadata.len()))
}

#[cfg(unix)]
fn is_pipe(kind: fs::FileType) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&kind)
}

#[cfg(not(unix))]
fn is_pipe(_: fs::FileType) -> bool {
    false
}

/// Reads the bytes of a stream up to the size limit; `size` is its size, if it is known in advance.
pub(super) fn from_stream(reader: impl Read, name: &str, size: Option<u64>) -> Result<Vec<u8>, Diagnostics> {
    let remedy = "a spec holds one maneuver or one simulation; put a large shape into an OBJ file";
    let limit = MAX_BYTES as u64;
    if let Some(size) = size.filter(|size| *size > limit) {
        let megabytes = short(size as f64 / limit as f64);
        return Err(refuse(
            "E0004",
            name,
            format!("the spec is {megabytes} MiB, the limit is 1 MiB"),
            remedy,
        ));
    }
    let mut bytes = Vec::new();
    if let Err(error) = reader.take(limit + 1).read_to_end(&mut bytes) {
        return Err(refuse("E0015", name, format!("cannot read the spec: {error}"), "try again"));
    }
    too_large(&bytes, name)?;
    Ok(bytes)
}

fn too_large(bytes: &[u8], name: &str) -> Result<(), Diagnostics> {
    if bytes.len() > MAX_BYTES {
        let remedy = "a spec holds one maneuver or one simulation; put a large shape into an OBJ file";
        return Err(refuse("E0004", name, "the spec is larger than the limit of 1 MiB".into(), remedy));
    }
    Ok(())
}

/// Remedy for a file that is not in UTF-8.
const SAVE: &str = "save it as UTF-8";

/// Decodes the text of a spec. It must be UTF-8 without control characters; a byte order mark is
/// accepted.
pub(super) fn decode<'a>(bytes: &'a [u8], name: &str) -> Result<&'a str, Diagnostics> {
    too_large(bytes, name)?;
    let text = match encoding::text(bytes) {
        Ok(text) => text,
        Err(NoText::Utf16) => return Err(refuse("E0003", name, "the spec is in UTF-16".into(), SAVE)),
        Err(NoText::Binary(kind)) => {
            return Err(refuse(
                "E0002",
                name,
                format!("the file is not a text file: it is {kind}"),
                "name the text of the spec",
            ));
        }
        Err(NoText::At(at)) => {
            let reason = format!("byte 0x{:02x} at offset {at} is not UTF-8", bytes[at]);
            let mut finding = refuse("E0002", name, reason, "save the file as UTF-8");
            let good = std::str::from_utf8(&bytes[..at]).unwrap_or_default();
            (finding.0[0].line, finding.0[0].column) = Source::new(name, good).position(at);
            return Err(finding);
        }
    };
    let control = |c: char| c.is_ascii_control() && !matches!(c, '\t' | '\n' | '\r');
    if let Some((start, c)) = text.char_indices().find(|(_, c)| control(*c)) {
        let span = Span { source: 0, start, end: start + 1 };
        let reason = format!("control character U+{:04X}", u32::from(c));
        let finding = Finding::error("E0005", span, reason, "remove it");
        return Err(super::diagnostics(vec![finding], &[Source::new(name, text)]));
    }
    Ok(text)
}
