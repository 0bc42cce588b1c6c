//! XML messages of CCSDS, parsed by the crate `roxmltree`: the elements in the order of the text,
//! each with its position. Document type declarations are rejected, so a file cannot define
//! entities. No other files are fetched.

use super::{Piece, Wrong, wrong};
use crate::spec::cut;
use roxmltree::{Document, Error, Node, ParsingOptions};

/// Largest number of nodes of a document. The tree needs less than 100 bytes for each node.
const MOST_NODES: u32 = 1 << 22;

/// Handler of the elements of one kind of message.
pub(super) trait Message<'t> {
    /// Name of the element that holds the message. It is the document itself or is contained in
    /// `<ndm>`.
    const ELEMENT: &'static str;

    /// Handles the version number of the message.
    fn version(&mut self, number: Piece<'t>) -> Result<(), Wrong>;
    /// Handles the start of the element `name`, which is nested in the elements `within`.
    fn opened(&mut self, within: &Open<'t>, name: Piece<'t>, unit: Option<Piece<'t>>) -> Result<(), Wrong>;
    /// Handles the end of `element`, which is nested in the elements `within`.
    fn closed(&mut self, within: &Open<'t>, element: &Element<'t>) -> Result<(), Wrong>;
}

/// An element whose end has been read.
pub(super) struct Element<'t> {
    /// Name of the element, at its position in the start tag.
    pub name: Piece<'t>,
    /// Text of the element; `None` if the element contains other elements or no text.
    pub value: Option<Piece<'t>>,
}

impl<'t> Element<'t> {
    /// Returns the text of the element, or an empty text if it has none.
    pub fn text(&self) -> Piece<'t> {
        self.value.unwrap_or(Piece { at: self.name.at, text: "" })
    }
}

/// Names of the elements that have begun but not ended, the outermost first.
#[derive(Default)]
pub(super) struct Open<'t>(Vec<Piece<'t>>);

impl Open<'_> {
    /// Returns whether one of these elements has the name `element`.
    pub fn has(&self, element: &str) -> bool {
        self.0.iter().any(|piece| piece.text == element)
    }
}

/// Largest depth of nested elements. It bounds the time, because the reader searches the enclosing
/// elements of every element.
const DEEPEST: usize = 100;

/// Parses a text and returns its XML tree.
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
                    format!("</{}> is found where </{}> is expected", cut(&found, 30), cut(&wanted, 30));
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

/// Returns the name of an element, without a prefix, and its position in the text.
pub(crate) fn name<'t>(node: Node<'t, 't>) -> Piece<'t> {
    let (at, name) = (node.range().start + 1, node.tag_name().name());
    // The name may have a namespace prefix.
    let source = &node.document().input_text()[at..];
    let prefix = source.find(name).filter(|found| *found > 0 && source[..*found].ends_with(':'));
    Piece { at: at + prefix.unwrap_or(0), text: name }
}

/// Returns the value of the attribute `name` of an element; `None` if the element lacks it.
pub(crate) fn attribute<'t>(node: Node<'t, 't>, name: &str) -> Option<Piece<'t>> {
    let found = node.attribute_node(name)?;
    Some(Piece { at: found.range_value().start, text: found.value() }.trimmed())
}

/// Returns the text of an element; `None` if the element contains other elements or no text.
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

/// Returns the messages of one kind, whose element is named `element`: the document itself, or the
/// children of its element `<ndm>`.
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

/// Passes all elements of the messages of one kind to the handler `message`. Returns the name of
/// the last message element, at its position in the text.
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
        // The loop visits the tree without recursion, so a deep tree cannot overflow the stack.
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
