//! Keys and values of messages for one time (OMM, OPM, APM), in keyword notation, XML or JSON.

use super::keywords::pair;
use super::{Piece, Wrong, elements, lines, wrong};
use crate::spec::cut;
use roxmltree::{Document, Node};

/// A key with its value and, if the message states it, the unit of the value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Said<'t> {
    pub key: Piece<'t>,
    pub value: Piece<'t>,
    pub unit: Option<Piece<'t>>,
    /// Number of the part of the message that contains the key. Every mark of a block begins a new
    /// part.
    pub part: usize,
}

/// The keys of a message, in the order of the file.
pub(super) type Keys<'t> = Vec<Said<'t>>;

/// Returns the keys of a file in keyword notation. Every message begins with the key `opening`,
/// such as `CCSDS_OMM_VERS`, and begins a new part. Lines that end with `_START` or `_STOP` also
/// begin a new part.
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
            let reason = format!("the file is not an {kind}: it begins with `{}`", cut(key.text, 30));
            return key.wrong(reason, format!("give an {kind}: {opening} = 2.0"));
        }
        if key.is(opening) {
            part += 1;
        }
        let (value, unit) = with_unit(value);
        found.push(Said { key, value, unit, part });
    }
    Ok(found)
}

/// Splits a value into the value itself and the unit in brackets that may follow it.
fn with_unit(value: Piece<'_>) -> (Piece<'_>, Option<Piece<'_>>) {
    let Some(inner) = value.text.strip_suffix(']') else { return (value, None) };
    let Some(open) = inner.rfind('[') else { return (value, None) };
    let unit = Piece { at: value.at + open + 1, text: &inner[open + 1..] }.trimmed();
    (Piece { at: value.at, text: &value.text[..open] }.trimmed(), Some(unit))
}

/// Returns the keys of the messages in an XML document: the elements that contain no other
/// elements. User-defined parameters are omitted, because their names may be those of other keys.
pub(super) fn of_xml<'t>(document: &'t Document<'t>, element: &str) -> Result<Keys<'t>, Wrong> {
    let mut found = Keys::new();
    let mut parents: Vec<Node<'_, '_>> = Vec::new();
    for message in elements::messages(document, element)? {
        let root = elements::name(message);
        let Some(version) = elements::attribute(message, "version") else {
            return root.wrong("the message does not state its version", "write version=\"2.0\"");
        };
        parents.push(message);
        found.push(Said { key: root, value: version, unit: None, part: parents.len() });
        let leaves = message.descendants().filter(|node| node.is_element() && *node != message);
        for leaf in leaves.filter(|node| node.first_element_child().is_none()) {
            let name = elements::name(leaf);
            if name.text == "COMMENT" || name.text == "USER_DEFINED" {
                continue;
            }
            let value = elements::value(leaf)?.unwrap_or(Piece { at: name.at, text: "" });
            let parent = leaf.parent_element().unwrap_or(message);
            if parents.last() != Some(&parent) {
                parents.push(parent);
            }
            let unit = elements::attribute(leaf, "units");
            found.push(Said { key: name, value, unit, part: parents.len() });
        }
    }
    Ok(found)
}

/// Returns the first key named `name` that has a value; `None` if no such key exists.
pub(super) fn get<'t>(keys: &Keys<'t>, name: &str) -> Option<Said<'t>> {
    keys.iter().find(|said| said.key.is(name) && !said.value.text.is_empty()).copied()
}

/// Returns the key `name` that belongs to the key `start`. It is in the same part or, if the part
/// does not contain it, is the last such key before `start`.
pub(super) fn near<'t>(keys: &Keys<'t>, start: &Said<'t>, name: &str) -> Option<Said<'t>> {
    let named = |said: &&Said<'_>| said.key.is(name) && !said.value.text.is_empty();
    let before = keys.iter().rfind(|said| said.key.at <= start.key.at && named(said));
    keys.iter().find(|said| said.part == start.part && named(said)).or(before).copied()
}

/// Checks that the file contains only one epoch, and therefore one message. The error lists the
/// names of the objects; `what` describes the contents of the messages.
pub(super) fn one_message(keys: &Keys<'_>, what: &str) -> Result<(), Wrong> {
    const NAMED: usize = 3;
    let epochs: Vec<_> = keys.iter().filter(|said| said.key.is("EPOCH")).collect();
    let [_, second, ..] = epochs[..] else { return Ok(()) };
    let names = epochs.iter().take(NAMED).map(|epoch| {
        let name = ["OBJECT_NAME", "NORAD_CAT_ID"].iter().find_map(|name| near(keys, epoch, name));
        name.map_or("without a name", |said| said.value.text)
    });
    let mut names = names.collect::<Vec<_>>().join(", ");
    if epochs.len() > NAMED {
        names.push_str(", …");
    }
    let reason = format!("the file has {} {what}: {}", epochs.len(), cut(&names, 100));
    second.key.wrong(reason, "leave that of one object and one epoch in the file")
}

/// Returns the key `name`, or an error if it does not exist.
pub(super) fn needed<'t>(keys: &Keys<'t>, name: &str) -> Result<Said<'t>, Wrong> {
    if let Some(found) = get(keys, name) {
        return Ok(found);
    }
    let last = keys.last().map_or(Piece { at: 0, text: "" }, |said| said.key);
    wrong(last.at, last.text.len(), format!("the message has no `{name}`"), format!("add {name} = …"))
}

/// Checks that no key is given twice within a part, and that each unit is the unit of its key.
pub(super) fn check(keys: &Keys<'_>, units: &[(&str, &[&str])]) -> Result<(), Wrong> {
    for (index, said) in keys.iter().enumerate() {
        let same = |before: &&Said<'_>| before.part == said.part && before.key.is(said.key.text);
        // The keys of a part are consecutive and few.
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
            let reason = format!("the unit {} of `{}` is not supported", cut(unit.text, 20), said.key.text);
            return unit.wrong(reason, format!("give it in {}", known.first().unwrap_or(&"its own")));
        }
    }
    Ok(())
}
