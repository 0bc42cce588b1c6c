//! Lines of a summary: their labels, headline and colours.

use slewkit::numerics::figures::significant;
use slewkit_files::spec::escape;

/// Number of characters of the headline, which contains the name and the verdict.
const WIDTH: usize = 76;

/// Number of characters that precede the text of a labelled line.
const LABELLED: usize = 13;

/// Number of characters available for the text of a labelled line in a terminal of 80 columns.
pub const TEXT: usize = 80 - LABELLED - 1;

/// Breaks `text` between words into lines of at most `width` characters. A longer word has its own
/// line.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(last) if last.chars().count() + 1 + word.chars().count() <= width => {
                last.push(' ');
                last.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines.retain(|line| !line.trim().is_empty());
    lines
}

/// Returns a labelled line of a summary.
pub fn line(label: &str, text: &str) -> String {
    format!("  {label:<11} {text}")
}

/// Returns the label and the text of an entry of a summary, and removes the line breaks of the
/// text.
pub fn parts(entry: &str) -> (String, String) {
    let split = entry.char_indices().nth(LABELLED).map_or(entry.len(), |(at, _)| at);
    let (label, text) = entry.split_at(split);
    (label.trim().into(), text.lines().map(str::trim).collect::<Vec<_>>().join(" "))
}

/// Returns the number of lines that all entries occupy in a terminal.
pub(super) fn rows(entries: &[String]) -> usize {
    entries.iter().map(|entry| entry.lines().count()).sum()
}

/// A summary that is being built from entries, each with a label and a text. Most entries are one
/// line.
pub trait Lines {
    /// Adds a labelled line.
    fn line(&mut self, label: &str, text: impl AsRef<str>);

    /// Adds one line for each text. Only the first line has the label.
    fn lines<T: AsRef<str>>(&mut self, label: &str, texts: impl IntoIterator<Item = T>) {
        for (index, text) in texts.into_iter().enumerate() {
            self.line(if index == 0 { label } else { "" }, text);
        }
    }

    /// Adds a labelled text as one entry, broken into lines between words. Adds nothing if the text
    /// is empty.
    fn text(&mut self, label: &str, text: impl AsRef<str>) {
        let broken = wrapped(text.as_ref(), TEXT);
        if !broken.is_empty() {
            self.line(label, broken.join(&format!("\n{:width$}", "", width = LABELLED + 1)));
        }
    }

    /// Adds each text as one entry. Only the first entry has the label.
    fn texts<T: AsRef<str>>(&mut self, label: &str, texts: impl IntoIterator<Item = T>) {
        for (index, text) in texts.into_iter().enumerate() {
            self.text(if index == 0 { label } else { "" }, text);
        }
    }
}

impl Lines for Vec<String> {
    fn line(&mut self, label: &str, text: impl AsRef<str>) {
        self.push(line(label, text.as_ref()));
    }
}

/// Meaning of a text, which determines its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// A good outcome, shown in green.
    Good,
    /// A bad outcome, shown in red.
    Bad,
    /// A remark, shown in yellow.
    Note,
}

/// Returns `text` in the colour of its tone, for a terminal that has colours.
pub fn paint(colour: bool, tone: Tone, text: &str) -> String {
    let code = match tone {
        Tone::Good => "1;32",
        Tone::Bad => "1;31",
        Tone::Note => "1;33",
    };
    if colour { format!("\x1b[{code}m{text}\x1b[0m") } else { text.into() }
}

/// Returns the headline, with the name on the left and the verdict on the right.
pub fn headline(colour: bool, name: &str, verdict: &str, tone: Tone) -> String {
    let name = escape(name);
    let gap = WIDTH.saturating_sub(name.chars().count() + verdict.chars().count()).max(2);
    format!("{name}{}{}", " ".repeat(gap), paint(colour, tone, verdict))
}

/// Formats a fraction in percent. A fraction above 1 is never shown as 100 %.
pub(super) fn percent(part: f64) -> String {
    match 100.0 * part {
        percent if (percent - 100.0).abs() <= 1e-4 => "100 %".into(),
        percent => format!("{} %", significant(percent, 3).trim_end_matches(".0")),
    }
}

/// Truncates `text` to at most `most` characters.
pub(super) fn clipped(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.into();
    }
    let kept: String = text.chars().take(most.saturating_sub(1)).collect();
    format!("{kept}…")
}

#[cfg(test)]
mod tests {
    use super::{Lines, TEXT, parts, rows};

    #[test]
    fn a_text_in_several_lines_has_its_words_back_without_them() {
        let text = "a local minimum to first order, within 0.0123 % of its neighbours; others may cost less";
        let mut lines = Vec::new();
        lines.texts("clearance", [text, "Sun: 46.6 deg"]);
        lines.text("target", "");
        assert_eq!((lines.len(), rows(&lines)), (2, 3));
        assert!(lines[0].lines().all(|line| line.chars().count() <= 14 + TEXT), "{}", lines[0]);
        assert_eq!(parts(&lines[0]), ("clearance".to_string(), text.to_string()));
        assert_eq!(parts(&lines[1]), (String::new(), "Sun: 46.6 deg".to_string()));
    }
}
