//! Parsing of TOML text to a tree.

use super::tree::Number;
use super::{Entry, Finding, Node, Span, Value};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Largest accepted depth of nesting of a spec; a valid spec has at most four levels.
pub(crate) const MAX_DEPTH: usize = 32;

/// Largest number of duplicate keys that are reported.
const MAX_SYNTAX: usize = 20;
/// Text with which the messages of the crate `toml` about duplicate keys begin.
const DUPLICATE: &str = "duplicate key";

/// Parses a TOML document.
pub(crate) fn parse(text: &str) -> Result<Node, Vec<Finding>> {
    let (table, errors) = DeTable::parse_recoverable(text);
    let mut converter = Converter { source: 0, offset: 0, too_deep: None, graveyard: Vec::new() };
    let root = converter.node(0..text.len(), DeValue::Table(table.into_inner()), 0);
    let too_deep = converter.finish();
    // Each duplicate key is an independent error. Only the first of the other syntax errors is
    // reported, because the rest may follow from it.
    let duplicate = |error: &&toml::de::Error| error.message().starts_with(DUPLICATE);
    let duplicates = errors.iter().filter(duplicate).take(MAX_SYNTAX);
    let first = errors.iter().find(|error| !duplicate(error));
    let mut findings: Vec<_> = duplicates.chain(first).map(|error| syntax(text, error)).collect();
    if findings.is_empty()
        && let Some(span) = too_deep
    {
        findings.push(nesting(span));
    }
    if findings.is_empty() { Ok(root) } else { Err(findings) }
}

/// Parses the value of an override as TOML. Returns `None` if the text is not a TOML value.
pub(crate) fn parse_value(text: &str, source: usize, offset: usize) -> Option<Node> {
    let value = DeValue::parse(text).ok()?;
    let mut converter = Converter { source, offset, too_deep: None, graveyard: Vec::new() };
    let node = converter.node(value.span(), value.into_inner(), 0);
    converter.finish().is_none().then_some(node)
}

/// Creates the error that a spec is nested too deeply.
pub(crate) fn nesting(span: Span) -> Finding {
    let reason = format!("tables and lists are nested deeper than {MAX_DEPTH} levels");
    Finding::error("E0012", span, reason, "at most four levels are needed: look for an unclosed bracket")
}

/// Converter of the tree of the crate `toml`. It does not recurse deeper than [`MAX_DEPTH`] levels.
struct Converter<'i> {
    source: usize,
    offset: usize,
    too_deep: Option<Span>,
    /// Subtrees that are nested too deeply to be converted. They must be dropped without recursion,
    /// because dotted keys in inline tables can nest thousands of levels in a few kilobytes.
    graveyard: Vec<DeValue<'i>>,
}

impl<'i> Converter<'i> {
    fn span(&self, range: std::ops::Range<usize>) -> Span {
        Span { source: self.source, start: range.start + self.offset, end: range.end + self.offset }
    }

    fn node(&mut self, range: std::ops::Range<usize>, value: DeValue<'i>, depth: usize) -> Node {
        let span = self.span(range);
        if depth > MAX_DEPTH {
            self.too_deep.get_or_insert(span);
            self.graveyard.push(value);
            return Node { span, value: Value::Null };
        }
        let value = match value {
            DeValue::String(text) => Value::Text(text.into_owned()),
            DeValue::Integer(integer) if integer.radix() == 10 => {
                Value::Number(Number::decimal(integer.as_str()))
            }
            DeValue::Integer(integer) => Value::Number(Number::radix(integer.as_str(), integer.radix())),
            DeValue::Float(float) => Value::Number(Number::decimal(float.as_str())),
            DeValue::Boolean(value) => Value::Boolean(value),
            DeValue::Datetime(_) => Value::Date,
            DeValue::Array(items) => {
                Value::Array(items.into_iter().map(|item| self.spanned(item, depth + 1)).collect())
            }
            DeValue::Table(table) => {
                let mut entries = Vec::with_capacity(table.len());
                for (key, value) in table {
                    let key_span = self.span(key.span());
                    let node = self.spanned(value, depth + 1);
                    entries.push(Entry { key: key.into_inner().into_owned(), key_span, node });
                }
                // The crate `toml` sorts entries by name, but findings are reported in the order of
                // the file.
                entries.sort_by_key(|entry| entry.key_span.start);
                Value::Table(entries)
            }
        };
        Node { span, value }
    }

    fn spanned(&mut self, value: Spanned<DeValue<'i>>, depth: usize) -> Node {
        self.node(value.span(), value.into_inner(), depth)
    }

    /// Drops, without recursion, the subtrees that are nested too deeply. Returns the position of
    /// the first of them; `None` if there are none.
    fn finish(mut self) -> Option<Span> {
        while let Some(value) = self.graveyard.pop() {
            match value {
                DeValue::Array(items) => self.graveyard.extend(items.into_iter().map(Spanned::into_inner)),
                DeValue::Table(table) => {
                    self.graveyard.extend(table.into_iter().map(|(_, v)| v.into_inner()))
                }
                _ => {}
            }
        }
        self.too_deep
    }
}

/// Converts a syntax error of the crate `toml` to an error with a message of this program.
fn syntax(text: &str, error: &toml::de::Error) -> Finding {
    let range = error.span().unwrap_or(0..0);
    let span = Span { source: 0, start: range.start, end: range.end };
    let message = error.message();
    if message.contains("recursion limit") {
        return nesting(span);
    }
    let finding = |code, reason: String, remedy: &str| Finding::error(code, span, reason, remedy);
    if message.starts_with(DUPLICATE) {
        let key = text.get(range.clone()).unwrap_or_default();
        let first = first_set(text, range.start, key);
        let first = first.map_or(String::new(), |line| format!(", first on line {line}"));
        let reason = format!("`{}` is set twice{first}", super::diagnostic::cut(key, 60));
        return finding("E0011", reason, "remove one of the two");
    }
    const VALUE: &str =
        "write `key = value`: a number such as 0.3, a list such as [0, 0, 1], or text in quotes";
    if message.starts_with("string values must be quoted") {
        // The crate `toml` reports a missing value as an unquoted string of length zero.
        let word = text.get(range).unwrap_or_default().trim();
        return if word.is_empty() {
            finding("E0010", "not valid TOML: the value is missing".into(), VALUE)
        } else {
            let word = super::diagnostic::cut(word, 40);
            let remedy = format!("put text between quotes: \"{word}\"");
            let reason = format!("not valid TOML: {word} is neither a number nor text in quotes");
            finding("E0010", reason, &remedy)
        };
    }
    let remedy = if message.starts_with("unclosed table") {
        "close the table header with `]`"
    } else if message.contains("string") {
        "write text between two quotes \" on one line"
    } else if message.starts_with("unexpected key or value") {
        "write one `key = value` per line"
    } else if message.starts_with("key with no value") || message.starts_with("missing value") {
        VALUE
    } else if message.contains("array") {
        "put commas between the elements of a list and close it with `]`"
    } else {
        "see https://toml.io for the notation, or start from the template of `slew init`"
    };
    finding("E0010", format!("not valid TOML: {message}"), remedy)
}

/// Returns the number of the line, before the byte `at`, in which `key` was set for the first time
/// in the same table, or the line of the table's header.
///
/// The crate `toml` does not report this position, so it is searched for in the text. The result
/// only supplements a message, so it may be `None`.
fn first_set(text: &str, at: usize, key: &str) -> Option<usize> {
    if key.is_empty() {
        return None;
    }
    let before = text.get(..at)?;
    let start_of_line = before.rfind('\n').map_or(0, |newline| newline + 1);
    let header = before[start_of_line..].trim_start().starts_with('[');
    let lines: Vec<&str> = before[..start_of_line].lines().collect();
    for (index, line) in lines.iter().enumerate().rev() {
        let line = line.trim_start();
        if header {
            let name = line.strip_prefix('[').map(|rest| rest.trim_start_matches('['));
            if name.and_then(|name| name.trim_start().strip_prefix(key)).is_some_and(ends_name) {
                return Some(index + 1);
            }
        } else if line.strip_prefix(key).is_some_and(ends_name) {
            return Some(index + 1);
        } else if line.starts_with('[') {
            return None;
        }
    }
    None
}

/// Returns whether the text `rest`, which follows a key, shows that the key has ended.
fn ends_name(rest: &str) -> bool {
    matches!(rest.trim_start().chars().next(), Some('=' | ']' | '.'))
}
