//! Tree of a spec in TOML or JSON, with the contents of the text and the position of every key and
//! value.

use super::{Span, cut};

/// A value with its position.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub span: Span,
    pub value: Value,
}

/// A value of a spec, without interpretation.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Table(Vec<Entry>),
    Array(Vec<Node>),
    Text(String),
    Number(Number),
    Boolean(bool),
    Date,
    Null,
}

/// A number as the user wrote it, with its floating-point value and its interpretation as an
/// integer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number {
    pub value: f64,
    pub integer: Integer,
}

/// Result of the attempt to interpret a number as an integer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Integer {
    Exact(i64),
    TooLarge,
    Fraction,
}

/// A key with its value.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub key: String,
    pub key_span: Span,
    pub node: Node,
}

impl Number {
    /// Parses a decimal literal of JSON, or of TOML without underscores.
    pub fn decimal(text: &str) -> Self {
        let value: f64 = text.parse().unwrap_or(f64::NAN);
        let whole = text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'-' || byte == b'+');
        let integer = match text.parse() {
            Ok(integer) => Integer::Exact(integer),
            Err(_) if whole => Integer::TooLarge,
            // 1000.0 and 1e3 count as integers, as in JSON. A floating-point number above 2⁵³ does
            // not identify a single integer.
            Err(_) if value.fract() == 0.0 && value.abs() < 9e15 => Integer::Exact(value as i64),
            Err(_) if value.fract() == 0.0 => Integer::TooLarge,
            Err(_) => Integer::Fraction,
        };
        Self { value, integer }
    }

    /// Parses an integer literal with the base `radix`.
    pub fn radix(digits: &str, radix: u32) -> Self {
        match i64::from_str_radix(digits, radix) {
            Ok(integer) => Self { value: integer as f64, integer: Integer::Exact(integer) },
            Err(_) => {
                let value = digits
                    .chars()
                    .filter_map(|c| c.to_digit(radix))
                    .fold(0.0, |value, digit| value * f64::from(radix) + f64::from(digit));
                Self { value, integer: Integer::TooLarge }
            }
        }
    }
}

impl Value {
    /// Returns a name for the kind of the value, for messages such as "found a table".
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Table(_) => "a table",
            Self::Array(_) => "a list",
            Self::Text(_) => "a string",
            Self::Number(_) => "a number",
            Self::Boolean(_) => "true or false",
            Self::Date => "a date",
            Self::Null => "null",
        }
    }
}

impl Node {
    /// Returns the entries of a table, or an empty list for any other value.
    pub fn entries(&self) -> &[Entry] {
        match &self.value {
            Value::Table(entries) => entries,
            _ => &[],
        }
    }

    /// Returns the entry with the key `key`; `None` if the node is not a table or lacks the key.
    pub fn entry(&self, key: &str) -> Option<&Entry> {
        self.entries().iter().find(|entry| entry.key == key)
    }

    /// Returns the node to which `path` leads from this node; `None` if it does not exist.
    pub fn at_mut(&mut self, path: &[(String, Span)]) -> Option<&mut Self> {
        path.iter().try_fold(self, |node, (key, _)| match &mut node.value {
            Value::Table(entries) => {
                entries.iter_mut().find(|entry| entry.key == *key).map(|entry| &mut entry.node)
            }
            Value::Array(items) => items.get_mut(key.parse::<usize>().ok()?),
            _ => None,
        })
    }

    /// Sets the node to which `path` leads from this node to `value`, and creates missing tables. A
    /// number in the path selects an element of a list, counted from 0. If a node on the path
    /// prevents this, the error contains its position and a description.
    pub fn set(&mut self, path: &[(String, Span)], value: Node) -> Result<(), (Span, String)> {
        let Some(((key, key_span), rest)) = path.split_first() else {
            *self = value;
            return Ok(());
        };
        match &mut self.value {
            Value::Table(entries) => {
                let index = entries.iter().position(|entry| entry.key == *key).unwrap_or_else(|| {
                    let node = Node { span: *key_span, value: Value::Table(Vec::new()) };
                    entries.push(Entry { key: key.clone(), key_span: *key_span, node });
                    entries.len() - 1
                });
                if rest.is_empty() {
                    entries[index].key_span = *key_span;
                }
                entries[index].node.set(rest, value)
            }
            Value::Array(items) => {
                let count = items.len();
                match key.parse::<usize>().ok().and_then(|index| items.get_mut(index)) {
                    Some(item) => item.set(rest, value),
                    None => Err((*key_span, format!("a list of {count} has no element `{}`", cut(key, 60)))),
                }
            }
            other => Err((
                *key_span,
                format!("`{}` would be inside {}, which is not a table", cut(key, 60), other.kind()),
            )),
        }
    }
}
