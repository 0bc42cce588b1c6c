//! XML: the elements, attributes and comments that messages of CCSDS have. No entities of their own are expanded, no files are fetched.

use super::{Piece, Wrong, wrong};
use crate::spec::cut;

/// A kind of message, and what becomes of its elements.
pub(super) trait Message<'t> {
    /// The element that is the message, in `<ndm>` or alone.
    const ELEMENT: &'static str;
    /// What it is, for people.
    const KIND: &'static str;

    /// The message says its version.
    fn version(&mut self, number: Piece<'t>) -> Result<(), Wrong>;
    /// An element begins within those that are open.
    fn opened(&mut self, within: &Open<'t>, name: Piece<'t>, attributes: Piece<'t>) -> Result<(), Wrong>;
    /// An element has ended within those that are open.
    fn closed(&mut self, within: &Open<'t>, element: &Element<'t>) -> Result<(), Wrong>;
}

/// An element that has ended.
pub(super) struct Element<'t> {
    /// Its name where it begins, and where it ends.
    pub opened: Piece<'t>,
    pub closed: Piece<'t>,
    /// Its text, of one that has nothing else.
    pub value: Option<Piece<'t>>,
}

impl<'t> Element<'t> {
    /// Its text; empty where it has none.
    pub fn text(&self) -> Piece<'t> {
        self.value.unwrap_or(Piece { at: self.opened.at, text: "" })
    }
}

/// The elements that are open, the outermost first.
#[derive(Default)]
pub(super) struct Open<'t>(Vec<Piece<'t>>);

impl Open<'_> {
    /// Whether one of them has that name.
    pub fn has(&self, element: &str) -> bool {
        self.0.iter().any(|piece| piece.text == element)
    }
}

/// Reads a message from a text, element by element, and says where the last of them ends.
pub(super) fn read<'t, M: Message<'t>>(text: &'t str, message: &mut M) -> Result<Piece<'t>, Wrong> {
    let (mut tokens, mut open) = (Tokens::of(text), Open::default());
    let (mut said, mut last): (Option<(Piece, Piece)>, Piece) = (None, Piece { at: 0, text: "" });
    while let Some(token) = tokens.next()? {
        match token {
            Token::Open(name, attributes) => {
                if name.text == M::ELEMENT {
                    let Some(number) = attribute(attributes, "version") else {
                        return name.wrong("the message does not say its version", "write version=\"2.0\"");
                    };
                    message.version(number)?;
                } else if open.0.is_empty() && name.text != "ndm" {
                    let reason = format!("<{}> is no {}", cut(name.text, 30), M::KIND);
                    return name.wrong(reason, format!("give an <{}>", M::ELEMENT));
                }
                message.opened(&open, name, attributes)?;
                open.0.push(name);
                said = None;
            }
            Token::Text(piece) => {
                let Some(name) = open.0.last() else {
                    return piece.wrong("text outside of all elements", "remove it");
                };
                said = Some((*name, piece));
            }
            Token::Close(name) => {
                last = name;
                let opened = closed(&mut open.0, name)?;
                let value = said.take().filter(|(of, _)| of.at == opened.at).map(|(_, piece)| piece);
                message.closed(&open, &Element { opened, closed: name, value })?;
            }
        }
    }
    match open.0.last() {
        Some(name) => name.wrong(format!("<{}> is not closed", cut(name.text, 30)), "the file is cut off"),
        None => Ok(last),
    }
}

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
    /// Those of a text.
    fn of(text: &'t str) -> Self {
        Self { text, at: 0, closing: None }
    }

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
pub(super) fn attribute<'t>(of: Piece<'t>, name: &str) -> Option<Piece<'t>> {
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

/// The element that `name` closes, taken from those that are open.
fn closed<'t>(open: &mut Vec<Piece<'t>>, name: Piece<'t>) -> Result<Piece<'t>, Wrong> {
    let Some(opened) = open.pop() else {
        return name.wrong(format!("</{}> closes nothing", cut(name.text, 30)), "remove it");
    };
    if opened.text != name.text {
        let (found, wanted) = (cut(name.text, 30), cut(opened.text, 30));
        let reason = format!("</{found}> stands where <{wanted}> is to be closed");
        return name.wrong(reason, "close elements in the order in which they were opened");
    }
    Ok(opened)
}
