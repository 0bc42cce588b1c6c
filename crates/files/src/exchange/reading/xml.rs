//! AEM in XML: the elements, attributes and comments that such files have. No entities of their own are expanded, no
//! files are fetched.

use super::message::{Block, Metadata, Version, date};
use super::{Piece, Rows, Wrong, wrong};
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
            let Some(length) = rest.find('>') else {
                return wrong(self.at, 1, "this tag does not end", "the file is cut off, or a > is missing");
            };
            let (at, inner) = (self.at + 1, &rest[1..length]);
            self.at += length + 1;
            if let Some(name) = inner.strip_prefix('/') {
                return Ok(Some(Token::Close(Piece { at: at + 1, text: name }.trimmed())));
            }
            let bare = inner.strip_suffix('/').unwrap_or(inner);
            let end = bare.find(|c: char| c.is_ascii_whitespace()).unwrap_or(bare.len());
            let name = Piece { at, text: &bare[..end] };
            if name.text.is_empty() {
                return name.wrong("a tag has no name", "write <NAME>");
            }
            if bare.len() < inner.len() {
                self.closing = Some(name);
            }
            return Ok(Some(Token::Open(name, Piece { at: at + end, text: &bare[end..] })));
        }
    }
}

/// The value of an attribute.
fn attribute<'t>(of: Piece<'t>, name: &str) -> Option<Piece<'t>> {
    let at = of.text.find(&format!("{name}=\""))? + name.len() + 2;
    let end = of.text[at..].find('"')?;
    Some(Piece { at: of.at + at, text: &of.text[at..at + end] })
}

/// A row on its way.
#[derive(Default)]
struct Row<'t> {
    date: Option<Piece<'t>>,
    values: Vec<(&'t str, f64)>,
}

/// Reads the file.
pub(super) fn read(text: &str) -> Result<Rows, Wrong> {
    let mut tokens = Tokens { text, at: 0, closing: None };
    let mut rows = Rows::default();
    let mut open: Vec<Piece<'_>> = Vec::new();
    let mut said: Option<(Piece<'_>, Piece<'_>)> = None;
    let (mut version, mut keys, mut block, mut row) = (None, Metadata::default(), None, Row::default());
    while let Some(token) = tokens.next()? {
        match token {
            Token::Open(name, attributes) => {
                match name.text {
                    "aem" => {
                        let Some(number) = attribute(attributes, "version") else {
                            return name
                                .wrong("the message does not say its version", "write version=\"2.0\"");
                        };
                        version = Some(Version::of(number)?);
                    }
                    "metadata" => keys = Metadata::default(),
                    "attitudeState" => row = Row::default(),
                    _ if open.is_empty() && name.text != "ndm" => {
                        return name.wrong(
                            format!("<{}> is no attitude ephemeris", cut(name.text, 30)),
                            "give an <aem>",
                        );
                    }
                    _ => {}
                }
                if let Some(unit) =
                    attribute(attributes, "units").filter(|unit| !["deg/s", "1/s"].contains(&unit.text))
                {
                    return unit.wrong(
                        format!("the unit {} is not known here", cut(unit.text, 20)),
                        "rates are in deg/s",
                    );
                }
                open.push(name);
                said = None;
            }
            Token::Text(piece) => {
                let Some(name) = open.last() else {
                    return piece.wrong("text outside of all elements", "remove it");
                };
                said = Some((*name, piece));
            }
            Token::Close(name) => {
                let Some(opened) = open.pop() else {
                    return name.wrong(format!("</{}> closes nothing", cut(name.text, 30)), "remove it");
                };
                if opened.text != name.text {
                    let reason = format!(
                        "</{}> stands where <{}> is to be closed",
                        cut(name.text, 30),
                        cut(opened.text, 30)
                    );
                    return name.wrong(reason, "close elements in the order in which they were opened");
                }
                let value = said.take().filter(|(of, _)| of.at == opened.at).map(|(_, piece)| piece);
                let inside = |element: &str| open.iter().any(|piece| piece.text == element);
                match name.text {
                    "metadata" => {
                        let version =
                            version.map_or_else(|| name.wrong("there is no <aem>", "give an <aem>"), Ok)?;
                        let read: Block = keys.block(version, name)?;
                        read.begin(name, &mut rows)?;
                        block = Some(read);
                    }
                    "attitudeState" => {
                        let Some(block) = &block else {
                            return name.wrong("data before any metadata", "put <metadata> before <data>");
                        };
                        finish(&row, block, opened, &mut rows)?;
                    }
                    _ if inside("metadata") => {
                        keys.add(opened, value.unwrap_or(Piece { at: opened.at, text: "" }))?;
                    }
                    "EPOCH" if inside("attitudeState") => row.date = value,
                    _ if inside("attitudeState") => {
                        if let Some(value) = value {
                            row.values.push((opened.text, value.number()?));
                        }
                    }
                    _ => {}
                }
            }
        }
    }
    match open.last() {
        Some(name) => name.wrong(format!("<{}> is not closed", cut(name.text, 30)), "the file is cut off"),
        None => Ok(rows),
    }
}

/// Adds the row.
fn finish(row: &Row<'_>, block: &Block, at: Piece<'_>, rows: &mut Rows) -> Result<(), Wrong> {
    let Some(moment) = row.date else {
        return at.wrong("the state has no <EPOCH>", "give the date of every state");
    };
    let names: &[&str] = match block.kind.count() {
        4 => &["Q1", "Q2", "Q3", "QC"],
        8 => &["Q1", "Q2", "Q3", "QC", "Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT"],
        _ => &["Q1", "Q2", "Q3", "QC", "ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"],
    };
    let mut numbers = Vec::with_capacity(names.len());
    for name in names {
        let mut found = row.values.iter().filter(|(key, _)| key == name);
        match (found.next(), found.next()) {
            (Some((_, value)), None) => numbers.push(*value),
            (None, _) => {
                return at.wrong(format!("the state has no <{name}>"), "give what ATTITUDE_TYPE says");
            }
            (Some(_), Some(_)) => return at.wrong(format!("the state has <{name}> twice"), "give it once"),
        }
    }
    block.row(at, date(moment, block.scale)?, &numbers, rows)
}
