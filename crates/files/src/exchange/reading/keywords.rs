//! AEM in the keyword notation (`KEY = value`).

use super::message::{Metadata, Version};
use super::rows::Rows;
use super::{Piece, Wrong, lines, wrong};
use crate::spec::cut;

/// Keys that may precede the first block.
const HEADER: [&str; 4] = ["CREATION_DATE", "ORIGINATOR", "MESSAGE_ID", "CLASSIFICATION"];

/// The part of the file to which a line belongs.
enum Place<'t> {
    Header,
    Metadata(Metadata<'t>),
    Between(super::message::Block),
    Data(super::message::Block),
}

/// Reads an AEM in the keyword notation and returns its rows.
pub(super) fn read(text: &str) -> Result<Rows, Wrong> {
    let mut lines = lines(text).peekable();
    let Some(first) = lines.next() else { return wrong(0, 1, "the file is empty", "give an AEM") };
    let (key, value) = pair(first)?;
    if !key.is("CCSDS_AEM_VERS") {
        let reason = format!("the file is not an AEM: it begins with `{}`", cut(key.text, 30));
        return key.wrong(reason, "give an attitude ephemeris: CCSDS_AEM_VERS = 2.0");
    }
    let version = Version::of(value)?;
    let (mut place, mut rows, mut last) = (Place::Header, Rows::default(), first);
    let mut seen = Vec::new();
    for line in lines {
        last = line;
        if line.text.get(..7).is_some_and(|start| start.eq_ignore_ascii_case("COMMENT")) {
            continue;
        }
        let mark =
            ["META_START", "META_STOP", "DATA_START", "DATA_STOP"].into_iter().find(|mark| line.is(mark));
        place = match (place, mark.unwrap_or(line.text)) {
            (Place::Header, "META_START") => {
                if let Some(key) = ["CREATION_DATE", "ORIGINATOR"].iter().find(|key| !seen.contains(*key)) {
                    return line.wrong(format!("the header has no `{key}`"), format!("add {key} = …"));
                }
                Place::Metadata(Metadata::default())
            }
            (Place::Header, _) if !rows.found.time.is_empty() => {
                return line.wrong("after data only another META_START may follow", "remove the line");
            }
            (Place::Header, _) => {
                let (key, _) = pair(line)?;
                let Some(known) = HEADER.into_iter().find(|known| key.is(known)) else {
                    let reason = format!("unknown key `{}` in the header of an AEM", cut(key.text, 40));
                    return key.wrong(reason, "write META_START before the metadata");
                };
                seen.push(known);
                Place::Header
            }
            (Place::Metadata(keys), "META_STOP") => {
                let block = keys.block(version, line)?;
                block.begin(line, &mut rows)?;
                Place::Between(block)
            }
            (Place::Metadata(mut keys), _) => {
                let (key, value) = pair(line)?;
                keys.add(key, value)?;
                Place::Metadata(keys)
            }
            (Place::Between(block), "DATA_START") => Place::Data(block),
            (Place::Between(_), _) => {
                return line
                    .wrong("DATA_START is needed here", "put the data between DATA_START and DATA_STOP");
            }
            (Place::Data(_), "DATA_STOP") => Place::Header,
            (Place::Data(block), _) => {
                let words = line.words();
                let numbers = words[1..].iter().map(|word| word.number()).collect::<Result<Vec<_>, _>>()?;
                block.row(line, words[0], &numbers, &mut rows)?;
                Place::Data(block)
            }
        };
    }
    match place {
        Place::Header => Ok(rows),
        Place::Metadata(_) => {
            last.wrong("the metadata do not end", "META_STOP is missing: the file is cut off")
        }
        Place::Between(_) => {
            last.wrong("the block has no data", "DATA_START is missing: the file is cut off")
        }
        Place::Data(_) => last.wrong("the data do not end", "DATA_STOP is missing: the file is cut off"),
    }
}

/// Splits a line `KEY = value` into its key and its value.
pub(super) fn pair(line: Piece<'_>) -> Result<(Piece<'_>, Piece<'_>), Wrong> {
    match line.text.find('=') {
        Some(sign) if sign > 0 => Ok((
            Piece { at: line.at, text: &line.text[..sign] }.trimmed(),
            Piece { at: line.at + sign + 1, text: &line.text[sign + 1..] }.trimmed(),
        )),
        _ => line
            .wrong(format!("`{}` is not of the form KEY = value", cut(line.text, 40)), "write KEY = value"),
    }
}
