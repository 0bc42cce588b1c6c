//! The statements of messages of one moment (OMM, OPM, APM): keys with values, by keywords, in XML
//! or in JSON.

use super::keywords::pair;
use super::{Piece, Wrong, elements, lines, wrong};
use crate::spec::cut;
use roxmltree::{Document, Node};

/// A key, its value, and the unit that stands with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Said<'t> {
    pub key: Piece<'t>,
    pub value: Piece<'t>,
    pub unit: Option<Piece<'t>>,
    /// The number of the part that contains the key: each mark of a block begins a new part.
    pub part: usize,
}

/// The keys of a message in their order.
pub(super) type Keys<'t> = Vec<Said<'t>>;

/// Returns the keys of a message in keywords and values; `opening` is `CCSDS_OMM_VERS` or alike.
/// Lines that end with `_START` or `_STOP` mark its parts.
pub(super) fn of_keywords<'t>(text: &'t str, opening: &str, kind: &str) -> Result<Keys<'t>, Wrong> {
    let mut found = Keys::new();
    let mut part = 0;
    for line in lines(text) {
        if line.text.get(..7).is_some_and(|start| start.eq_ignore_ascii_case("COMMENT")) {
            continue;
        }
        if !line.text.contains('=') && (line.text.ends_with("_START") || line.text.ends_with("_STOP")) {
            part += 1;
            continue;
        }
        let (key, value) = pair(line)?;
        if found.is_empty() && !key.is(opening) {
            let reason = format!("`{}` begins a message other than an {kind}", cut(key.text, 30));
            return key.wrong(reason, format!("give an {kind}: {opening} = 2.0"));
        }
        if found.len() > 1 && key.is(opening) {
            return key.wrong(format!("the file has more than one {kind}"), "leave one of them in the file");
        }
        let (value, unit) = with_unit(value);
        found.push(Said { key, value, unit, part });
    }
    Ok(found)
}

/// Returns the unit behind a value, between brackets.
fn with_unit(value: Piece<'_>) -> (Piece<'_>, Option<Piece<'_>>) {
    let Some(inner) = value.text.strip_suffix(']') else { return (value, None) };
    let Some(open) = inner.rfind('[') else { return (value, None) };
    let unit = Piece { at: value.at + open + 1, text: &inner[open + 1..] }.trimmed();
    (Piece { at: value.at, text: &value.text[..open] }.trimmed(), Some(unit))
}

/// Returns the keys of a message in XML: elements that contain no others. An element that is named
/// by `parameter` has its value for a name.
pub(super) fn of_xml<'t>(document: &'t Document<'t>, element: &str) -> Result<Keys<'t>, Wrong> {
    let messages = elements::messages(document, element)?;
    let [message] = messages[..] else {
        let reason = format!("the file has {} messages <{element}>", messages.len());
        return elements::name(messages[1]).wrong(reason, "leave one of them in the file");
    };
    let mut found = Keys::new();
    let root = elements::name(message);
    let Some(version) = elements::attribute(message, "version") else {
        return root.wrong("the message does not state its version", "write version=\"2.0\"");
    };
    found.push(Said { key: root, value: version, unit: None, part: 0 });
    let leaves = message.descendants().filter(|node| node.is_element() && *node != message);
    let mut parents: Vec<Node<'_, '_>> = Vec::new();
    for leaf in leaves.filter(|node| node.first_element_child().is_none()) {
        let name = elements::name(leaf);
        if name.text == "COMMENT" {
            continue;
        }
        let value = elements::value(leaf)?.unwrap_or(Piece { at: name.at, text: "" });
        let parent = leaf.parent_element().unwrap_or(message);
        if parents.last() != Some(&parent) {
            parents.push(parent);
        }
        let key = elements::attribute(leaf, "parameter").unwrap_or(name);
        let unit = elements::attribute(leaf, "units");
        found.push(Said { key, value, unit, part: parents.len() });
    }
    Ok(found)
}

/// Returns one of several keys.
pub(super) fn get<'t>(keys: &Keys<'t>, name: &str) -> Option<Said<'t>> {
    keys.iter().find(|said| said.key.is(name) && !said.value.text.is_empty()).copied()
}

/// Returns a required key.
pub(super) fn needed<'t>(keys: &Keys<'t>, name: &str) -> Result<Said<'t>, Wrong> {
    if let Some(found) = get(keys, name) {
        return Ok(found);
    }
    let last = keys.last().map_or(Piece { at: 0, text: "" }, |said| said.key);
    wrong(last.at, last.text.len(), format!("the message has no `{name}`"), format!("add {name} = …"))
}

/// Refuses a key that is given twice within a part, or in a unit that is not the unit of the key.
pub(super) fn check(keys: &Keys<'_>, units: &[(&str, &[&str])]) -> Result<(), Wrong> {
    for (index, said) in keys.iter().enumerate() {
        let same = |before: &&Said<'_>| before.part == said.part && before.key.is(said.key.text);
        // Parts are short, and the keys of a part are consecutive.
        if keys[..index]
            .iter()
            .rev()
            .take_while(|before| before.part == said.part)
            .any(|before| same(&before))
        {
            return said.key.wrong(format!("`{}` is given twice", cut(said.key.text, 40)), "give it once");
        }
        let (Some(unit), Some((_, known))) = (said.unit, units.iter().find(|(key, _)| said.key.is(key)))
        else {
            continue;
        };
        if !known.iter().any(|known| unit.is(known)) {
            let reason = format!("the unit {} of `{}` is not read", cut(unit.text, 20), said.key.text);
            return unit.wrong(reason, format!("give it in {}", known.first().unwrap_or(&"its own")));
        }
    }
    Ok(())
}
