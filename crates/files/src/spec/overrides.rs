//! Values of keys that are set outside of the spec file: by `--set`, by a cell of a table of cases,
//! or by a grid.

use super::{Finding, MAX_BYTES, Node, Origin, Source, Span, Spot, Value, cut, toml_text};

/// A key whose value is set outside of the spec file, as by `--set maneuver.steps=200`.
///
/// The value is parsed as a TOML value; if this fails, it is a text. A number in the path selects
/// an element of a list, counted from 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    path: String,
    value: String,
    origin: Option<Origin>,
}

/// Explanation of the notation of an override, for messages.
const WANTED: &str = "write key.path=value, for example maneuver.steps=200";

impl Override {
    /// Parses `key.path=value`.
    ///
    /// # Errors
    /// Returns a message for the user if the path or the value is invalid.
    pub fn parse(text: &str) -> Result<Self, String> {
        let Some((path, value)) = text.split_once('=') else {
            return Err(format!("`{}` has no `=`; {WANTED}", cut(text, 60)));
        };
        Self::new(path, value)
    }

    /// Creates an override that sets the key at the dotted path `path` to the value `value`.
    ///
    /// # Errors
    /// Returns a message for the user if the path or the value is invalid.
    pub fn new(path: &str, value: &str) -> Result<Self, String> {
        let path = path.trim();
        if path.split('.').any(|part| part.trim().is_empty()) {
            return Err(format!("`{}` is not a key path; {WANTED}", cut(path, 60)));
        }
        if path.split('.').count() > toml_text::MAX_DEPTH {
            return Err(format!("the key path is deeper than {}; {WANTED}", toml_text::MAX_DEPTH));
        }
        if path.len() + value.len() > MAX_BYTES {
            return Err("the value is larger than the limit of a spec".into());
        }
        Ok(Self { path: path.into(), value: value.trim().into(), origin: None })
    }

    /// Sets the position of the value that messages report.
    pub fn at(mut self, origin: Origin) -> Self {
        self.origin = Some(origin);
        self
    }

    /// Returns the dotted path of the key.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Returns the value as the user wrote it.
    pub fn value(&self) -> &str {
        &self.value
    }

    /// Returns the text that messages show, the byte index of the path in it (`None` if the text
    /// does not contain the path), and the byte index of the value.
    pub(super) fn source(&self) -> (Source, Option<usize>, usize) {
        const PREFIX: &str = "--set ";
        let Self { path, value, origin } = self;
        match origin {
            None => {
                let source = Source::new("command line", format!("{PREFIX}{path}={value}"));
                (source, Some(PREFIX.len()), PREFIX.len() + path.len() + 1)
            }
            Some(Origin { file, line, column }) => {
                (Source::new(file.as_str(), value.as_str()).within(*line, *column), None, 0)
            }
        }
    }
}

/// Parses a value as TOML; if this fails, the value is a text. `offset` is the byte index of the
/// value in the source.
pub(crate) fn typed(value: &str, source: usize, offset: usize) -> Node {
    toml_text::parse_value(value, source, offset).unwrap_or_else(|| Node {
        span: Span { source, start: offset, end: offset + value.len() },
        value: Value::Text(value.into()),
    })
}

/// Sets the values of the overrides in a tree. Each override is a separate source of text.
pub(super) fn apply(
    mut root: Node,
    overrides: &[Override],
    sources: &mut Vec<Source>,
) -> (Node, Vec<Finding>) {
    let mut findings = Vec::new();
    for given in overrides {
        let index = sources.len();
        let (source, path_at, value_at) = given.source();
        sources.push(source);
        let node = typed(&given.value, index, value_at);
        let shown = node.span;
        let mut start = path_at.unwrap_or_default();
        let mut keys = Vec::new();
        for part in given.path.split('.') {
            let whole = Span { source: index, start, end: start + part.len() };
            let span = if path_at.is_some() { whole } else { node.span };
            keys.push((part.trim().to_string(), span));
            start += part.len() + 1;
        }
        if let Err((span, reason)) = root.set(&keys, node) {
            let spot = Spot { span, key: given.path.clone() };
            let remedy = "set a key of a table, or an element that exists";
            findings.push(Finding::error_at("E0025", spot, reason, remedy));
            continue;
        }
        // A message about the table that contains the key, such as an attitude, shows the override.
        let inside = keys.len() > 2 && keys[keys.len() - 2].0.parse::<usize>().is_err();
        if inside && let Some(value) = root.at_mut(&keys[..keys.len() - 1]) {
            value.span = shown;
        }
    }
    (root, findings)
}
