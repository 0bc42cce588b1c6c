//! AEM in XML: the elements, attributes and comments that such files have. No entities of their own are expanded, no
//! files are fetched.

use super::message::{Block, Metadata, Version};
use super::rows::Rows;
use super::{Number, Piece, Wrong, wrong};
use crate::spec::cut;

/// An opening or closing tag, or text between two tags.
enum Token<'t> {
    Open(Piece<'t>, Piece<'t>),
    Close(Piece<'t>),
    Text(Piece<'t>),
}

/// The tokens of a document, in their order.
struct Tokens<'t> {
    text: &'t str,
    at: usize,
    /// The name of an element that closed itself.
    closing: Option<Piece<'t>>,
}

impl<'t> Tokens<'t> {
    /// The next token; none at the end.
    fn next(&mut self) -> Result<Option<Token<'t>>, Wrong> {
        if let Some(name) = self.closing.take() {
            return Ok(Some(Token::Close(name)));
        }
        loop {
            let rest = &self.text[self.at..];
            if rest.is_empty() {
                return Ok(None);
            }
            if !rest.starts_with('<') {
                let length = rest.find('<').unwrap_or(rest.len());
                let piece = Piece { at: self.at, text: &rest[..length] }.trimmed();
                self.at += length;
                if !piece.text.is_empty() {
                    return Ok(Some(Token::Text(piece)));
                }
                continue;
            }
            let skipped = [("<!--", "-->"), ("<?", "?>")].iter().find(|(start, _)| rest.starts_with(start));
            if let Some((_, end)) = skipped {
                let Some(length) = rest.find(end) else {
                    return wrong(
                        self.at,
                        4,
                        "this comment or instruction does not end",
                        "the file is cut off",
                    );
                };
                self.at += length + end.len();
                continue;
            }
            if rest.starts_with("<!") {
                return wrong(
                    self.at,
                    2,
                    "document types and raw text are not read",
                    "remove the declaration",
                );
            }
            let Some(length) = end_of_tag(rest) else {
                return wrong(self.at, 1, "this tag does not end", "the file is cut off, or a > is missing");
            };
            let (at, inner) = (self.at + 1, &rest[1..length]);
            self.at += length + 1;
            if let Some(name) = inner.strip_prefix('/') {
                return Ok(Some(Token::Close(local(Piece { at: at + 1, text: name }.trimmed()))));
            }
            let bare = inner.strip_suffix('/').unwrap_or(inner);
            let end = bare.find(|c: char| c.is_ascii_whitespace()).unwrap_or(bare.len());
            let name = Piece { at, text: &bare[..end] };
            if name.text.is_empty() {
                return name.wrong("a tag has no name", "write <NAME>");
            }
            let name = local(name);
            if bare.len() < inner.len() {
                self.closing = Some(name);
            }
            return Ok(Some(Token::Open(name, Piece { at: at + end, text: &bare[end..] })));
        }
    }
}

/// Where a tag ends: a `>` between quotes is of a value.
fn end_of_tag(tag: &str) -> Option<usize> {
    let mut quote = None;
    for (at, byte) in tag.bytes().enumerate() {
        match (quote, byte) {
            (None, b'>') => return Some(at),
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            _ => {}
        }
    }
    None
}

/// A name without the prefix of its namespace.
fn local(name: Piece<'_>) -> Piece<'_> {
    let at = name.text.find(':').map_or(0, |colon| colon + 1);
    Piece { at: name.at + at, text: &name.text[at..] }
}

/// The value of an attribute, between quotes of either kind, with blanks around the sign or without.
fn attribute<'t>(of: Piece<'t>, name: &str) -> Option<Piece<'t>> {
    let mut rest = of.text;
    loop {
        let sign = rest.find('=')?;
        let found = rest[..sign].trim();
        let after = rest[sign + 1..].trim_start();
        let quote = after.chars().next().filter(|quote| matches!(quote, '"' | '\''))?;
        let value = &after[1..];
        let end = value.find(quote)?;
        if found == name {
            let at = of.at + value.as_ptr() as usize - of.text.as_ptr() as usize;
            return Some(Piece { at, text: &value[..end] }.trimmed());
        }
        rest = &value[end + 1..];
    }
}

/// A row on its way.
#[derive(Default)]
struct Row<'t> {
    date: Option<Piece<'t>>,
    values: Vec<(&'t str, Number)>,
}

/// Units that numbers of an AEM may have.
const UNITS: [&str; 4] = ["deg", "deg/s", "1/s", "s"];

/// Names in version 1.0 of angles and rates by their place in the sequence, and the names that they have here.
const BY_PLACE: [(&str, &str, &str); 6] = [
    ("rotationAngles", "rotation1", "ANGLE_1"),
    ("rotationAngles", "rotation2", "ANGLE_2"),
    ("rotationAngles", "rotation3", "ANGLE_3"),
    ("rotationRates", "rotation1", "RATE_1"),
    ("rotationRates", "rotation2", "RATE_2"),
    ("rotationRates", "rotation3", "RATE_3"),
];

/// What has been read.
#[derive(Default)]
struct Reading<'t> {
    rows: Rows,
    open: Vec<Piece<'t>>,
    said: Option<(Piece<'t>, Piece<'t>)>,
    version: Option<Version>,
    keys: Metadata<'t>,
    block: Option<Block>,
    row: Row<'t>,
}

/// Reads the file.
pub(super) fn read(text: &str) -> Result<Rows, Wrong> {
    let mut tokens = Tokens { text, at: 0, closing: None };
    let mut reading = Reading::default();
    while let Some(token) = tokens.next()? {
        match token {
            Token::Open(name, attributes) => reading.open(name, attributes)?,
            Token::Text(piece) => {
                let Some(name) = reading.open.last() else {
                    return piece.wrong("text outside of all elements", "remove it");
                };
                reading.said = Some((*name, piece));
            }
            Token::Close(name) => reading.close(name)?,
        }
    }
    match reading.open.last() {
        Some(name) => name.wrong(format!("<{}> is not closed", cut(name.text, 30)), "the file is cut off"),
        None => Ok(reading.rows),
    }
}

impl<'t> Reading<'t> {
    fn open(&mut self, name: Piece<'t>, attributes: Piece<'t>) -> Result<(), Wrong> {
        match name.text {
            "aem" => {
                let Some(number) = attribute(attributes, "version") else {
                    return name.wrong("the message does not say its version", "write version=\"2.0\"");
                };
                self.version = Some(Version::of(number)?);
            }
            "metadata" => self.keys = Metadata::default(),
            "attitudeState" => self.row = Row::default(),
            _ if self.open.is_empty() && name.text != "ndm" => {
                return name
                    .wrong(format!("<{}> is no attitude ephemeris", cut(name.text, 30)), "give an <aem>");
            }
            _ => {}
        }
        if let Some(unit) = attribute(attributes, "units").filter(|unit| !UNITS.contains(&unit.text)) {
            return unit.wrong(
                format!("the unit {} is not known here", cut(unit.text, 20)),
                "angles are in deg, rates in deg/s",
            );
        }
        self.open.push(name);
        self.said = None;
        Ok(())
    }

    fn close(&mut self, name: Piece<'t>) -> Result<(), Wrong> {
        let Some(opened) = self.open.pop() else {
            return name.wrong(format!("</{}> closes nothing", cut(name.text, 30)), "remove it");
        };
        if opened.text != name.text {
            let (found, wanted) = (cut(name.text, 30), cut(opened.text, 30));
            let reason = format!("</{found}> stands where <{wanted}> is to be closed");
            return name.wrong(reason, "close elements in the order in which they were opened");
        }
        let value = self.said.take().filter(|(of, _)| of.at == opened.at).map(|(_, piece)| piece);
        let inside = |element: &str| self.open.iter().any(|piece| piece.text == element);
        match name.text {
            "metadata" => {
                let version =
                    self.version.map_or_else(|| name.wrong("there is no <aem>", "give an <aem>"), Ok)?;
                let read = self.keys.block(version, name)?;
                read.begin(name, &mut self.rows)?;
                self.block = Some(read);
            }
            "attitudeState" => {
                let Some(block) = &self.block else {
                    return name.wrong("data before any metadata", "put <metadata> before <data>");
                };
                finish(&self.row, block, opened, &mut self.rows)?;
            }
            _ if inside("metadata") => {
                self.keys.add(opened, value.unwrap_or(Piece { at: opened.at, text: "" }))?;
            }
            "EPOCH" if inside("attitudeState") => self.row.date = value,
            "COMMENT" => {}
            _ if inside("attitudeState") => {
                if let Some(value) = value {
                    let place = BY_PLACE.iter().find(|(of, at, _)| opened.text == *at && inside(of));
                    let name = place.map_or(opened.text, |(_, _, name)| name);
                    self.row.values.push((name, value.number()?));
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// Adds the row.
fn finish(row: &Row<'_>, block: &Block, at: Piece<'_>, rows: &mut Rows) -> Result<(), Wrong> {
    let Some(moment) = row.date else {
        return at.wrong("the state has no <EPOCH>", "give the date of every state");
    };
    let names = block.layout.names();
    let mut numbers = Vec::with_capacity(names.len());
    for name in names {
        let mut found = row.values.iter().filter(|(key, _)| *key == name);
        match (found.next(), found.next()) {
            (Some((_, value)), None) => numbers.push(*value),
            (None, _) => {
                return at.wrong(format!("the state has no <{name}>"), "give what ATTITUDE_TYPE says");
            }
            (Some(_), Some(_)) => return at.wrong(format!("the state has <{name}> twice"), "give it once"),
        }
    }
    block.named_row(at, moment, &numbers, rows)
}
