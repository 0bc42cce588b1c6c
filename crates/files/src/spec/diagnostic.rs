//! Findings about a spec: errors and warnings with their position, reason and remedy.

use super::{Origin, Source, Span};
use serde::Serialize;
use std::fmt::{self, Write};

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// An error: the spec cannot be used.
    Error,
    /// A warning: the spec can be used, in the way that the reason states.
    Warning,
}

/// A finding about a spec.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diagnostic {
    /// Stable code of the finding, such as `E0040` or `W0040`.
    pub code: &'static str,
    /// Severity of the finding: error or warning.
    pub severity: Severity,
    /// Name of the file as the user wrote it, or `command line`.
    pub file: String,
    /// Line number, counted from 1.
    pub line: usize,
    /// Column in characters, counted from 1.
    pub column: usize,
    /// Path of the key, such as `maneuver.steps`; empty if the finding does not belong to a key.
    pub key: String,
    /// Text that caused the finding, shortened, with control characters escaped.
    pub text: String,
    /// Reason of the finding, including the numbers concerned.
    pub reason: String,
    /// Remedy for the finding.
    pub remedy: String,
    /// Line of the spec that is shown, with the position and the length of the mark below it, both
    /// in characters; `None` if no line is shown.
    #[serde(skip)]
    excerpt: Option<(String, usize, usize)>,
}

impl Diagnostic {
    /// Creates a finding about a whole file whose text was not read.
    pub(crate) fn about_file(code: &'static str, file: &str, reason: String, remedy: &str) -> Self {
        Self {
            code,
            severity: Severity::Error,
            file: escape(file),
            line: 1,
            column: 1,
            key: String::new(),
            text: String::new(),
            reason: escape_lines(&reason),
            remedy: escape_lines(remedy),
            excerpt: None,
        }
    }

    /// Creates an error about the text `text`, whose position in a file is `at`.
    pub(crate) fn in_text(code: &'static str, at: &Origin, text: &str, reason: String, remedy: &str) -> Self {
        let source = Source::new(at.file.as_str(), text).within(at.line, at.column);
        let span = Span { source: 0, start: 0, end: text.len() };
        Finding::error(code, span, reason, remedy).resolve(&[source])
    }

    /// Returns the finding as text: position, reason, the line of the spec with a mark below it,
    /// and the remedy.
    ///
    /// If `colour` is true, the text contains ANSI colour codes.
    pub fn render(&self, colour: bool) -> String {
        let (kind, paint) = match self.severity {
            Severity::Error => ("error", "\x1b[1;31m"),
            Severity::Warning => ("warning", "\x1b[1;33m"),
        };
        let (paint, bold, blue, reset) =
            if colour { (paint, "\x1b[1m", "\x1b[1;34m", "\x1b[0m") } else { ("", "", "", "") };
        let mut out = format!(
            "{}:{}:{}: {paint}{kind}[{}]{reset}{bold}: {}{reset}\n",
            self.file, self.line, self.column, self.code, self.reason
        );
        let number = self.line.to_string();
        if let Some((line, start, length)) = &self.excerpt {
            let gap = " ".repeat(number.len());
            // Writing to a `String` cannot fail.
            let _ = writeln!(out, " {blue}{number} |{reset} {line}");
            let _ = writeln!(
                out,
                " {gap} {blue}|{reset} {}{paint}{}{reset}",
                " ".repeat(*start),
                "^".repeat(*length)
            );
        }
        for (index, line) in self.remedy.lines().enumerate() {
            let label = if index == 0 { format!("{bold}help:{reset}") } else { "     ".into() };
            let _ = writeln!(out, " {label} {line}");
        }
        out
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.render(false))
    }
}

/// All findings about a spec that has errors, in the order of the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl Diagnostics {
    /// Returns true if the spec or a file to which it refers could not be read, and false if the
    /// contents of the spec have errors.
    pub fn is_io(&self) -> bool {
        self.0.iter().any(|finding| {
            matches!(finding.code, "E0014" | "E0015" | "E0150" | "E0151" | "E0152" | "E0154" | "E0155")
        })
    }

    /// Returns all findings as text, in order, followed by the number of errors.
    pub fn render(&self, colour: bool) -> String {
        let mut out = String::new();
        for finding in &self.0 {
            out.push_str(&finding.render(colour));
            out.push('\n');
        }
        let count = |severity| self.0.iter().filter(|finding| finding.severity == severity).count();
        let several = |count, word| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
        let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
        out.push_str(&several(errors, "error"));
        if warnings > 0 {
            let _ = write!(out, ", {}", several(warnings, "warning"));
        }
        out.push('\n');
        out
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.render(false))
    }
}

impl std::error::Error for Diagnostics {}

/// Returns `text` with control characters escaped, so that they have no effect on a terminal.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        // Unicode does not classify these characters as control characters, but they break a line,
        // reorder it, or are invisible.
        let hidden = matches!(c, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}');
        if c.is_control() || hidden {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    out
}

/// Escapes control characters in a text of several lines, because it may quote input.
pub fn escape_lines(text: &str) -> String {
    text.split('\n').map(escape).collect::<Vec<_>>().join("\n")
}

/// Returns `text` with control characters escaped, truncated to `limit` characters.
pub(crate) fn cut(text: &str, limit: usize) -> String {
    let mut kept: String = text.chars().take(limit).collect();
    if kept.len() < text.len() {
        kept.push('…');
    }
    escape(&kept)
}

/// Largest number of characters of a line in an excerpt.
const EXCERPT: usize = 100;
const LEAD: usize = 60;

/// Returns the part of a line around `span`, escaped and truncated to [`EXCERPT`] characters, with
/// the position and length of the mark.
fn excerpt(source: &Source, line: usize, span: Span) -> (String, usize, usize) {
    let (text, start) = source.line(line);
    let offset = source.boundary(span.start).saturating_sub(start).min(text.len());
    let end = source.boundary(span.end).saturating_sub(start).clamp(offset, text.len());
    let lead = text[..offset].chars().count();
    let skipped = lead.saturating_sub(LEAD);
    let clean = |text: &str| escape(&text.replace('\t', " "));
    let before: String = text[..offset].chars().skip(skipped).collect();
    let before = if skipped > 0 { format!("…{}", clean(&before)) } else { clean(&before) };
    let room = EXCERPT - lead.min(LEAD);
    let marked: String = text[offset..end].chars().take(room).collect();
    let marked = clean(&marked);
    let rest = text[offset..end].chars().count().min(room);
    let after = &text[end..];
    let after = if rest < room { cut(&after.replace('\t', " "), room - rest) } else { "…".into() };
    let shown = format!("{before}{marked}{after}");
    (shown.trim_end().to_string(), before.chars().count(), marked.chars().count().max(1))
}

/// Position of a finding: the span of the text and the path of the key.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spot {
    pub span: Span,
    pub key: String,
}

/// A finding whose line and column have not been computed yet.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Finding {
    pub severity: Severity,
    pub code: &'static str,
    pub spot: Spot,
    pub reason: String,
    pub remedy: String,
}

impl Finding {
    /// Creates an error at a position in the text that does not belong to a key.
    pub fn error(
        code: &'static str,
        span: Span,
        reason: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::error_at(code, Spot { span, key: String::new() }, reason, remedy)
    }

    /// Creates an error at the position of a key.
    pub fn error_at(
        code: &'static str,
        spot: Spot,
        reason: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { severity: Severity::Error, code, spot, reason: reason.into(), remedy: remedy.into() }
    }

    pub fn resolve(self, sources: &[Source]) -> Diagnostic {
        let span = self.spot.span;
        let source = &sources[span.source];
        let (line_of_text, column) = source.position(span.start);
        let (line, column) = source.in_file(line_of_text, column);
        Diagnostic {
            code: self.code,
            severity: self.severity,
            file: escape(&source.name),
            line,
            column,
            key: escape(&self.spot.key),
            text: cut(source.slice(span), 60),
            reason: escape_lines(&self.reason),
            remedy: escape_lines(&self.remedy),
            // A finding about the whole file has no line to show.
            excerpt: (span != Span::default()).then(|| excerpt(source, line_of_text, span)),
        }
    }
}
