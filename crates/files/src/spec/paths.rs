//! Dotted paths of keys, as in `--set` and in the header of a table of cases.

use super::check::elsewhere;
use super::keys::{Key, Kind, ROOT};
use super::suggest::nearest;
use super::tree::Entry;
use super::values::{self, Fault};
use super::{Node, Value, cut};

/// Item of a spec to which a path refers.
pub(super) enum Place {
    /// A key of the spec.
    Key(&'static Key),
    /// An element of a list that is the value of a key.
    Element,
}

/// Returns the item to which `path` refers in the spec of a maneuver with the tree `root`.
/// Otherwise returns the code, the reason and the remedy of the error.
pub(super) fn place(root: &Node, path: &str) -> Result<Place, (&'static str, String, String)> {
    let (mut table, mut node, mut above) = (&ROOT, Some(root), String::new());
    let mut parts = path.split('.').map(str::trim).peekable();
    while let Some(part) = parts.next() {
        let Some(key) = table.key(part) else {
            let what = if above.is_empty() { "the spec".into() } else { format!("[{above}]") };
            let reason = format!("unknown key `{}` in {what}", cut(part, 60));
            let remedy = match nearest(part, table.keys.iter().map(|key| key.name)) {
                Some(known) if above.is_empty() => format!("did you mean `{known}`?"),
                Some(known) => format!("did you mean `{above}.{known}`?"),
                None => elsewhere(part, table, &ROOT),
            };
            return Err(("E0020", reason, remedy));
        };
        if !above.is_empty() {
            above.push('.');
        }
        above.push_str(part);
        node = node.and_then(|node| node.entry(part)).map(|Entry { node, .. }| node);
        let Some(inner) = key.kind.table() else {
            return element(parts.peek().copied(), node, key, &above);
        };
        if parts.peek().is_none() {
            return Ok(Place::Key(key));
        }
        if let Kind::List(..) = key.kind {
            let index = parts.next().unwrap_or_default();
            let count = match node.map(|node| &node.value) {
                Some(Value::Array(items)) => items.len(),
                _ => 0,
            };
            if index.parse::<usize>().ok().filter(|index| *index < count).is_none() {
                return Err(no_element(&above, count, index));
            }
            node = match node.map(|node| &node.value) {
                Some(Value::Array(items)) => index.parse::<usize>().ok().and_then(|index| items.get(index)),
                _ => None,
            };
            above.push('.');
            above.push_str(index);
            if parts.peek().is_none() {
                return Ok(Place::Element);
            }
        }
        table = inner;
    }
    Err(("E0020", "the path is empty".into(), "name a key of the spec".into()))
}

fn no_element(path: &str, count: usize, index: &str) -> (&'static str, String, String) {
    let reason = format!("`{path}` has {count} elements: `{}` is not one of them", cut(index, 60));
    ("E0025", reason, "elements are counted from 0".into())
}

/// Resolves the rest of a path after a key whose value is not a table.
fn element(
    rest: Option<&str>,
    node: Option<&Node>,
    key: &'static Key,
    path: &str,
) -> Result<Place, (&'static str, String, String)> {
    match rest {
        None => Ok(Place::Key(key)),
        Some(index) => {
            let count = match node.map(|node| &node.value) {
                Some(Value::Array(items)) => Some(items.len()),
                _ => None,
            };
            let is_list = count.is_some();
            match (count, index.parse::<usize>()) {
                (Some(count), Ok(index)) if index < count => return Ok(Place::Element),
                (Some(count), Ok(_)) => return Err(no_element(path, count, index)),
                _ => {}
            }
            let reason = format!("`{}` would be inside `{path}`, which is not a table", cut(index, 60));
            let remedy =
                if is_list { "elements of a list are counted from 0" } else { "give the key itself" };
            Err(("E0025", reason, remedy.into()))
        }
    }
}

/// Returns the errors of the value `node` of a key that do not depend on other keys.
pub(super) fn faults(key: &'static Key, node: &Node) -> Vec<Fault> {
    match key.kind {
        Kind::Table(_) | Kind::List(..) | Kind::Directions | Kind::Targets => vec![],
        kind => {
            let faults = values::read(kind, node).err().unwrap_or_default();
            let named = |mut fault: Fault| {
                if !fault.2.contains(&format!("`{}`", key.name)) {
                    fault.2 = format!("`{}`: {}", key.name, fault.2);
                }
                fault
            };
            faults.into_iter().take(3).map(named).collect()
        }
    }
}
