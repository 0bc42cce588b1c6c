//! Parsing and quoting of table cells according to RFC 4180, except that a quoted cell must end on
//! the line on which it begins. The separator is a comma, a semicolon or a tab. Any cell may be
//! quoted.

use std::borrow::Cow;

/// A table cell, without surrounding blanks and quotes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Cell<'t> {
    /// Text of the cell.
    pub text: Cow<'t, str>,
    /// Byte index at which the text of the cell begins, counted from the start of the line.
    pub start: usize,
}

/// Returns the separator of a table with the header line `head`: the first comma, semicolon or tab
/// outside of quotes; `None` if the line has none of these characters.
pub(crate) fn separator(head: &str) -> Option<char> {
    let outside = |sign: char| head.split('"').step_by(2).any(|part| part.contains(sign));
    [',', ';', '\t'].into_iter().find(|sign| outside(*sign))
}

/// Splits a line into cells at the character `separator`; if it is `None`, at blanks.
///
/// # Errors
/// Returns a description of the error if a quote is not closed or is in the wrong place.
pub(crate) fn cells(line: &str, separator: Option<char>) -> Result<Vec<Cell<'_>>, &'static str> {
    let parts = |sign: char| separator.map_or(sign.is_ascii_whitespace(), |separator| sign == separator);
    let blank = |sign: &char| *sign == ' ' || (*sign == '\t' && separator != Some('\t'));
    let mut found = Vec::new();
    let mut rest = line;
    loop {
        rest = rest.trim_start_matches(|sign| blank(&sign));
        if separator.is_none() && rest.is_empty() {
            return Ok(found);
        }
        let start = line.len() - rest.len();
        if let Some(quoted) = rest.strip_prefix('"') {
            let end = closing(quoted).ok_or("a quote is opened and not closed on its line")?;
            let inside = &quoted[..end];
            let text = if inside.contains('"') { inside.replace("\"\"", "\"").into() } else { inside.into() };
            found.push(Cell { text, start: start + 1 });
            rest = &quoted[end + 1..];
            let after = rest.trim_start_matches(|sign| blank(&sign));
            if separator.is_some() || after.is_empty() {
                rest = after;
            }
            if rest.chars().next().is_some_and(|sign| !parts(sign)) {
                return Err("a quoted cell is followed by more text before the next separator");
            }
        } else {
            let end = rest.find(parts).unwrap_or(rest.len());
            found.push(Cell { text: rest[..end].trim_end().into(), start });
            rest = &rest[end..];
        }
        match rest.chars().next() {
            None => return Ok(found),
            Some(sign) => rest = &rest[sign.len_utf8()..],
        }
    }
}

/// Formats a text as a cell of a comma-separated table for spreadsheets. The cell is quoted if
/// necessary, and a text that looks like a formula is marked as text. A line break becomes a blank,
/// because many readers treat every line as a row.
pub(crate) fn quoted(text: &str) -> String {
    let text = no_formula(&text.replace(['\r', '\n'], " ")).into_owned();
    if text.contains([',', '"', ';', '\t']) || text.trim() != text {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text
    }
}

/// Prefixes a text that looks like a formula with an apostrophe, which spreadsheets do not display.
/// Numbers are unchanged.
fn no_formula(text: &str) -> Cow<'_, str> {
    let begins = text.starts_with(['=', '+', '-', '@', '\t', '\r']);
    if begins && text.parse::<f64>().is_err() { format!("'{text}").into() } else { text.into() }
}

/// Returns the byte index of the quote that closes a quoted cell; a doubled quote belongs to the
/// text.
fn closing(quoted: &str) -> Option<usize> {
    let bytes = quoted.as_bytes();
    let mut at = 0;
    loop {
        at += bytes[at..].iter().position(|byte| *byte == b'"')?;
        if bytes.get(at + 1) != Some(&b'"') {
            return Some(at);
        }
        at += 2;
    }
}

#[cfg(test)]
mod tests {
    use super::{cells, no_formula, quoted, separator};

    #[test]
    fn no_cell_begins_as_a_formula() {
        for (text, cell) in [
            ("=1+1", "'=1+1"),
            ("@SUM(A1)", "'@SUM(A1)"),
            ("-x", "'-x"),
            ("-1.5e-3", "-1.5e-3"),
            ("+2", "+2"),
            ("a=b", "a=b"),
            ("", ""),
        ] {
            assert_eq!(no_formula(text), cell);
        }
        assert_eq!(quoted("=HYPERLINK(\"a\",1)\nb"), "\"'=HYPERLINK(\"\"a\"\",1) b\"");
    }

    #[test]
    fn cells_keep_their_places() {
        let read = |line: &str| -> Vec<(String, usize)> {
            let cells = cells(line, separator(line)).unwrap();
            cells.into_iter().map(|cell| (cell.text.into_owned(), cell.start)).collect()
        };
        let expected = |cells: &[(&str, usize)]| -> Vec<(String, usize)> {
            cells.iter().map(|(text, start)| (text.to_string(), *start)).collect()
        };
        assert_eq!(read("a, 2.5 ,\"[1, \"\"x\"\"]\""), expected(&[("a", 0), ("2.5", 3), ("[1, \"x\"]", 9)]));
        assert_eq!(read("a,,"), expected(&[("a", 0), ("", 2), ("", 3)]));
        assert_eq!(read("é,1"), expected(&[("é", 0), ("1", 3)]));
        assert_eq!(read("a;\"1,2\" ;3"), expected(&[("a", 0), ("1,2", 3), ("3", 9)]));
        assert_eq!(read("a\t\tb"), expected(&[("a", 0), ("", 2), ("b", 3)]));
        assert_eq!(read(" a  \"b\" c"), expected(&[("a", 1), ("b", 5), ("c", 8)]));
        for wrong in ["\"a", "\"a\"b,c", "\"a\"\"", "\""] {
            assert!(cells(wrong, Some(',')).is_err(), "{wrong}");
        }
    }
}
