//! Builds the page that shows how each claim of the repository was checked.

use crate::ROOT;
use crate::figures::{tables, text};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use toml::de::DeTable;

/// The keys of a claim that a test checks, and the keys of a claim that a figure shows.
const BY_TEST: [&str; 4] = ["claim", "against", "test", "value"];
const BY_FIGURE: [&str; 3] = ["claim", "against", "figure"];

/// The text in the column "date" for a claim that a test checks.
const EACH_COMMIT: &str = "each commit";

/// Returns the path of the data, `evidence/validation.toml`.
pub fn data() -> PathBuf {
    [ROOT, "evidence", "validation.toml"].iter().collect()
}

/// Returns the path of the page, `docs/validation.md`.
pub fn page() -> PathBuf {
    [ROOT, "docs", "validation.md"].iter().collect()
}

/// Returns the text of the page for the given texts of the claims and of the figures, with one
/// table row for each claim.
///
/// # Errors
///
/// Returns an error in these cases:
/// - a text is not TOML
/// - a key is missing, unknown, or not a string
/// - a claim is not one sentence, or occurs twice
/// - a test or a figure does not exist, or a number in `value` is not in the test
/// - a cell contains `|`
pub fn made(claims: &str, figures: &str) -> Result<String, String> {
    let claims = DeTable::parse(claims).map_err(|error| format!("the claims are not TOML: {error}"))?;
    let claims = claims.get_ref();
    let figures = DeTable::parse(figures).map_err(|error| format!("the figures are not TOML: {error}"))?;
    let mut named = BTreeMap::new();
    for section in tables(figures.get_ref(), "section")? {
        for figure in tables(section, "figure")? {
            named.insert(text(figure, "name")?, figure);
        }
    }
    let mut known = BTreeSet::new();
    let mut page = format!("# {}\n\n{}", text(claims, "title")?, text(claims, "introduction")?);
    for section in tables(claims, "section")? {
        let _ = write!(page, "\n## {}\n\n", text(section, "title")?);
        page.push_str("| claim | against | command | value | date |\n|---|---|---|---|---|\n");
        for claim in tables(section, "claim")? {
            let sentence = text(claim, "claim")?;
            if !sentence.ends_with('.') || sentence.contains(". ") {
                return Err(format!("not one sentence: {sentence}"));
            }
            if !known.insert(sentence) {
                return Err(format!("two claims say: {sentence}"));
            }
            let row = row(claim, &named).map_err(|error| format!("{sentence} {error}"))?;
            if row.matches('|').count() != 6 || row.matches('\n').count() != 1 {
                return Err(format!("{sentence} A cell contains `|` or the end of a line"));
            }
            page.push_str(&row);
        }
    }
    let _ = write!(page, "\n{}", text(claims, "end")?);
    Ok(page)
}

/// Returns the table row of a claim.
fn row(claim: &DeTable<'_>, figures: &BTreeMap<&str, &DeTable<'_>>) -> Result<String, String> {
    let by_figure = claim.contains_key("figure");
    let keys: &[&str] = if by_figure { &BY_FIGURE } else { &BY_TEST };
    if let Some(key) = claim.keys().map(|key| key.get_ref()).find(|key| !keys.contains(&&***key)) {
        return Err(format!("the key `{key}` is unknown: known are {}", keys.join(", ")));
    }
    let (sentence, against) = (text(claim, "claim")?, text(claim, "against")?);
    if by_figure {
        let name = text(claim, "figure")?;
        let figure = figures.get(name).ok_or_else(|| format!("no figure is called `{name}`"))?;
        let unit = if figure.contains_key("unit") { text(figure, "unit")? } else { "" };
        let (command, value, date) =
            (text(figure, "command")?, text(figure, "value")?, text(figure, "date")?);
        let value = format!("{value} {unit}");
        return Ok(format!("| {sentence} | {against} | `{command}` | {} | {date} |\n", value.trim_end()));
    }
    let (test, value) = (text(claim, "test")?, text(claim, "value")?);
    let test = Test::find(test)?;
    if let Some(number) = numbers(value).find(|number| !has_number(&test.body, number)) {
        return Err(format!("{number} does not stand in {}", test.command));
    }
    Ok(format!("| {sentence} | {against} | `{}` | {value} | {EACH_COMMIT} |\n", test.command))
}

/// A test that was found in the sources.
struct Test {
    command: String,
    /// The source text of the test function.
    body: String,
}

impl Test {
    /// Finds a test by its path, as `laws::witnesses::discrete::NAME`, `it::documents::NAME`,
    /// `allocation::NAME` or `tests/exchange/test_exchange.py::NAME`.
    fn find(path: &str) -> Result<Self, String> {
        let lost = || format!("no test {path}");
        let (place, name) = path.rsplit_once("::").ok_or_else(lost)?;
        let of_python = place.ends_with(".py");
        let (file, command) = match place.split_once("::") {
            _ if place.starts_with("python/") => (place.to_owned(), format!("pytest {place} -k {name}")),
            _ if of_python => (place.to_owned(), format!("python {place} target/debug/slew {name}")),
            Some((binary, modules)) => {
                let file = format!("tests/{binary}/{}.rs", modules.replace("::", "/"));
                (file, format!("cargo test --test {binary} -- {modules}::{name}"))
            }
            None => (format!("tests/{place}.rs"), format!("cargo test --test {place} -- {name}")),
        };
        let source = fs::read_to_string([ROOT, &file].iter().collect::<PathBuf>())
            .map_err(|error| format!("{}: {file}: {error}", lost()))?;
        let (head, end) = if of_python { ("def", "\ndef ") } else { ("fn", "\n}") };
        let (before, rest) = source.split_once(&format!("{head} {name}(")).ok_or_else(lost)?;
        // The attributes of a function stand above it without a blank line.
        let attributes = before.rsplit("\n\n").next().unwrap_or_default();
        if !of_python && !attributes.contains("#[test]") {
            return Err(format!("{path} is no test"));
        }
        let body = rest.split(end).next().unwrap_or_default().to_owned();
        Ok(Self { command, body })
    }
}

/// Returns the words of a text that begin with a digit.
fn numbers(text: &str) -> impl Iterator<Item = &str> {
    text.split([' ', ',']).filter(|word| word.starts_with(|c: char| c.is_ascii_digit()))
}

/// Returns whether a text contains a number as a whole, not only as part of a longer number.
fn has_number(text: &str, number: &str) -> bool {
    let inside = |c: char| c.is_ascii_alphanumeric() || c == '.';
    text.match_indices(number).any(|(at, _)| {
        !text[..at].ends_with(inside) && !text[at + number.len()..].starts_with(|c: char| c.is_ascii_digit())
    })
}
