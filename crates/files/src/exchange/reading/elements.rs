//! XML of messages of CCSDS, by the crate `roxmltree`: elements in the order of the text, each with
//! its place. Document types are refused, so a file cannot define entities, and no other files are
//! fetched.

use super::{Piece, Wrong, wrong};
use crate::spec::cut;
use roxmltree::{Document, Error, Node, ParsingOptions};

/// The largest number of nodes of a document: its tree needs less than 100 bytes for each.
const MOST_NODES: u32 = 1 << 22;

/// A kind of message, and the handling of its elements.
pub(super) trait Message<'t> {
    /// The element that is the message, in `<ndm>` or alone.
    const ELEMENT: &'static str;

    /// Is called when the message states its version.
    fn version(&mut self, number: Piece<'t>) -> Result<(), Wrong>;
    /// Is called when an element begins within the open elements.
    fn opened(&mut self, within: &Open<'t>, name: Piece<'t>, unit: Option<Piece<'t>>) -> Result<(), Wrong>;
    /// Is called when an element has ended within the open elements.
    fn closed(&mut self, within: &Open<'t>, element: &Element<'t>) -> Result<(), Wrong>;
}

/// An element that has ended.
pub(super) struct Element<'t> {
    /// The name in its start tag.
    pub name: Piece<'t>,
    /// The text of the element, if it contains only text.
    pub value: Option<Piece<'t>>,
}

impl<'t> Element<'t> {
    /// Returns the text of the element; empty if it has no text.
    pub fn text(&self) -> Piece<'t> {
        self.value.unwrap_or(Piece { at: self.name.at, text: "" })
    }
}

/// The elements that are open, the outermost first.
#[derive(Default)]
pub(super) struct Open<'t>(Vec<Piece<'t>>);

impl Open<'_> {
    /// Returns whether one of the open elements has that name.
    pub fn has(&self, element: &str) -> bool {
        self.0.iter().any(|piece| piece.text == element)
    }
}

/// The largest depth of nested elements: the reader searches each element among the elements around
/// it.
const DEEPEST: usize = 100;

/// Returns the tree of a text.
pub(crate) fn document(text: &str) -> Result<Document<'_>, Wrong> {
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).or_else(|error| {
        let place = error.pos();
        let start = text.split_inclusive('\n').take(place.row as usize - 1).map(str::len).sum::<usize>();
        let ahead = text[start..].chars().take(place.col as usize - 1).map(char::len_utf8).sum::<usize>();
        let at = start + ahead;
        match error {
            Error::UnexpectedCloseTag(wanted, found, _) => {
                let reason =
                    format!("</{}> stands where <{}> is to be closed", cut(&found, 30), cut(&wanted, 30));
                wrong(at, 1, reason, "close elements in the order in which they were opened")
            }
            Error::UnclosedRootNode | Error::UnexpectedEndOfStream => {
                let end = text.trim_end().len();
                wrong(end.saturating_sub(1), 1, "an element is not closed", "the file is cut off")
            }
            Error::DtdDetected => {
                wrong(0, 1, "document type declarations are not supported", "remove the <!DOCTYPE …>")
            }
            Error::NodesLimitReached => wrong(
                0,
                1,
                format!("the file has more than {MOST_NODES} elements, texts and comments"),
                "give fewer rows, or keywords and values",
            ),
            other => wrong(
                at,
                1,
                format!("this is not valid XML: {other}"),
                "check the tags; `&` is written `&amp;`",
            ),
        }
    })
}

/// Returns the name of an element and the place where it begins.
pub(crate) fn name<'t>(node: Node<'t, 't>) -> Piece<'t> {
    let (at, name) = (node.range().start + 1, node.tag_name().name());
    // A name may have a prefix.
    let source = &node.document().input_text()[at..];
    let prefix = source.find(name).filter(|found| *found > 0 && source[..*found].ends_with(':'));
    Piece { at: at + prefix.unwrap_or(0), text: name }
}

/// Returns the value of an attribute of an element.
pub(crate) fn attribute<'t>(node: Node<'t, 't>, name: &str) -> Option<Piece<'t>> {
    let found = node.attribute_node(name)?;
    Some(Piece { at: found.range_value().start, text: found.value() }.trimmed())
}

/// Returns the text of an element that has no other elements.
pub(crate) fn value<'t>(node: Node<'t, 't>) -> Result<Option<Piece<'t>>, Wrong> {
    if node.children().any(|child| child.is_element()) {
        return Ok(None);
    }
    let mut texts = node.children().filter(Node::is_text).filter_map(|text| {
        let piece = Piece { at: text.range().start, text: text.text()? }.trimmed();
        (!piece.text.is_empty()).then_some(piece)
    });
    let first = texts.next();
    match texts.next() {
        Some(second) => second.wrong("a comment is inside a value", "put it before the element"),
        None => Ok(first),
    }
}

/// Returns the elements that are messages of one kind: the document itself, or the messages in its
/// `<ndm>`.
pub(super) fn messages<'t>(document: &'t Document<'t>, element: &str) -> Result<Vec<Node<'t, 't>>, Wrong> {
    let root = document.root_element();
    let told = name(root);
    if told.text == element {
        return Ok(vec![root]);
    }
    if told.text != "ndm" {
        return told.wrong(
            format!("there is no <{element}>: the message is <{}>", cut(told.text, 30)),
            format!("give an <{element}>"),
        );
    }
    let within = || root.children().filter(Node::is_element).map(name);
    let found: Vec<_> =
        root.children().filter(|child| child.is_element() && name(*child).text == element).collect();
    if found.is_empty() {
        let mut others: Vec<String> = within().map(|piece| format!("<{}>", cut(piece.text, 30))).collect();
        others.dedup();
        others.truncate(3);
        let beside = if others.is_empty() { "nothing".into() } else { others.join(", ") };
        return told
            .wrong(format!("there is no <{element}>: <ndm> has {beside}"), format!("give an <{element}>"));
    }
    Ok(found)
}

/// Reads the messages of a kind from a document, element by element. Returns the place where the
/// last message begins.
pub(super) fn read<'t, M: Message<'t>>(
    document: &'t Document<'t>,
    message: &mut M,
) -> Result<Piece<'t>, Wrong> {
    let mut last = Piece { at: 0, text: "" };
    for root in messages(document, M::ELEMENT)? {
        last = name(root);
        let Some(number) = attribute(root, "version") else {
            return last.wrong("the message does not state its version", "write version=\"2.0\"");
        };
        message.version(number)?;
        let mut open = Open(vec![last]);
        // The loop walks the tree without recursion, so any depth is possible.
        let mut next = root.first_element_child();
        while let Some(node) = next {
            let piece = name(node);
            message.opened(&open, piece, attribute(node, "units"))?;
            if let Some(child) = node.first_element_child() {
                if open.0.len() > DEEPEST {
                    let reason = format!("elements are nested more than {DEEPEST} levels deep");
                    return piece.wrong(reason, "close each element where it ends");
                }
                open.0.push(piece);
                next = Some(child);
                continue;
            }
            message.closed(&open, &Element { name: piece, value: value(node)? })?;
            let mut ended = node;
            next = loop {
                if let Some(sibling) = ended.next_sibling_element() {
                    break Some(sibling);
                }
                let Some(parent) = ended.parent_element().filter(|parent| *parent != root) else {
                    break None;
                };
                open.0.pop();
                message.closed(&open, &Element { name: name(parent), value: None })?;
                ended = parent;
            };
        }
    }
    Ok(last)
}
