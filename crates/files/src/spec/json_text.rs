//! Parsing of JSON text to a tree: strict JSON, without comments and trailing commas.
//!
//! # Why is jsonc-parser used?
//!
//! It reports the byte range of every value, which serde_json does not. Its extensions, comments
//! and trailing commas, are disabled.

use super::toml_text::{MAX_DEPTH, nesting};
use super::tree::Number;
use super::{Entry, Finding, Node, Source, Span, Spot, Value, cut};
use jsonc_parser::common::{Range, Ranged};
use jsonc_parser::errors::ParseErrorKind;
use jsonc_parser::{CollectOptions, ParseOptions, ast, parse_to_ast};

/// Parses a JSON document.
pub(crate) fn parse(source: &Source) -> Result<Node, Vec<Finding>> {
    let text = &source.text;
    if let Some(at) = too_deep(text) {
        return Err(vec![nesting(Span { source: 0, start: at, end: at + 1 })]);
    }
    let strict = ParseOptions {
        allow_comments: false,
        allow_loose_object_property_names: false,
        allow_trailing_commas: false,
        allow_missing_commas: false,
        allow_single_quoted_strings: false,
        allow_hexadecimal_numbers: false,
        allow_unary_plus_numbers: false,
    };
    let parsed = parse_to_ast(text, &CollectOptions::default(), &strict);
    let value = match parsed {
        Ok(parsed) => parsed.value,
        Err(error) => return Err(vec![syntax(error.kind(), span(error.range()), source)]),
    };
    let mut duplicates = Vec::new();
    let root = match value {
        Some(value) => node(value, source, &mut duplicates),
        None => Node { span: Span::default(), value: Value::Table(Vec::new()) },
    };
    if duplicates.is_empty() { Ok(root) } else { Err(duplicates) }
}

fn span(range: Range) -> Span {
    Span { source: 0, start: range.start, end: range.end }
}

/// Returns the first byte position at which brackets outside of strings are nested too deeply. The
/// check precedes parsing, because the parser is recursive.
fn too_deep(text: &str) -> Option<usize> {
    let (mut depth, mut quoted, mut escaped) = (0_usize, false, false);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if quoted => escaped = true,
            b'"' => quoted = !quoted,
            b'[' | b'{' if !quoted => {
                depth += 1;
                if depth > MAX_DEPTH {
                    return Some(at);
                }
            }
            b']' | b'}' if !quoted => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    None
}

fn node(value: ast::Value<'_>, source: &Source, duplicates: &mut Vec<Finding>) -> Node {
    let at = span(value.range());
    let value = match value {
        ast::Value::StringLit(text) => Value::Text(text.value.into_owned()),
        ast::Value::NumberLit(number) => Value::Number(Number::decimal(number.value)),
        ast::Value::BooleanLit(value) => Value::Boolean(value.value),
        ast::Value::NullKeyword(_) => Value::Null,
        ast::Value::Array(array) => {
            Value::Array(array.elements.into_iter().map(|item| node(item, source, duplicates)).collect())
        }
        ast::Value::Object(object) => {
            let mut entries: Vec<Entry> = Vec::with_capacity(object.properties.len());
            for property in object.properties {
                let key_span = span(property.name.range());
                let key = property.name.into_string();
                let node = node(property.value, source, duplicates);
                entries.push(Entry { key, key_span, node });
            }
            // Sorting the entries by name finds duplicates without comparing all pairs. Afterwards,
            // the order of the file is restored.
            entries.sort_by(|a, b| (&a.key, a.key_span.start).cmp(&(&b.key, b.key_span.start)));
            for pair in entries.windows(2).filter(|pair| pair[0].key == pair[1].key) {
                let (first, second) = (&pair[0], &pair[1]);
                let line = source.line_number(first.key_span.start);
                let reason = format!("`{}` is set twice, first on line {line}", cut(&second.key, 60));
                let spot = Spot { span: second.key_span, key: second.key.clone() };
                duplicates.push(Finding::error_at("E0011", spot, reason, "keep one of the two"));
            }
            entries.sort_by_key(|entry| entry.key_span.start);
            Value::Table(entries)
        }
    };
    Node { span: at, value }
}

/// Converts a syntax error of the parser to an error with a message of this program.
fn syntax(kind: &ParseErrorKind, span: Span, source: &Source) -> Finding {
    let word = source.slice(span);
    let not_finite = ["NaN", "Infinity"].iter().any(|name| word.trim_start_matches('-').starts_with(name));
    let remedy = match kind {
        _ if not_finite => "JSON has no such number; write a finite one",
        ParseErrorKind::CommentsNotAllowed => "JSON has no comments; TOML has: `# …`",
        ParseErrorKind::TrailingCommasNotAllowed => "remove the comma after the last element",
        ParseErrorKind::ExpectedComma => "put a comma between the elements",
        ParseErrorKind::UnterminatedArray => "close the list with `]`",
        ParseErrorKind::UnterminatedObject => "close the object with `}`",
        ParseErrorKind::UnexpectedWord | ParseErrorKind::ExpectedStringObjectProperty => {
            "put names and text between quotes \""
        }
        _ => "write plain JSON, or TOML, which is easier to write",
    };
    let mut message = kind.to_string();
    if let Some(first) = message.get_mut(..1) {
        first.make_ascii_lowercase();
    }
    if matches!(kind, ParseErrorKind::NestingDepthExceeded) {
        return nesting(span);
    }
    Finding::error("E0010", span, format!("not valid JSON: {}", cut(&message, 120)), remedy)
}
