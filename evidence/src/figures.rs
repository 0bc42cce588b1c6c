//! Builds the page that shows the figures of the repository.

use crate::ROOT;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::PathBuf;
use toml::de::{DeTable, DeValue};

/// The keys of a figure. All keys except `unit` are required.
const KEYS: [&str; 6] = ["name", "law", "command", "value", "unit", "date"];

/// The largest number of characters of a row of the page.
const LONGEST_ROW: usize = 300;

/// Returns the path of the data, `evidence/figures.toml`.
pub fn data() -> PathBuf {
    [ROOT, "evidence", "figures.toml"].iter().collect()
}

/// Returns the path of the page, `docs/figures.md`.
pub fn page() -> PathBuf {
    [ROOT, "docs", "figures.md"].iter().collect()
}

/// Returns the text of the page for the given text of the data, with one table row for each figure.
///
/// # Errors
///
/// Returns an error in these cases:
/// - the text is not TOML
/// - a key is missing, unknown, or not a string
/// - two figures have the same name
/// - a law is not one sentence
/// - a date is not written as `2026-01-31`
/// - a row is longer than 300 characters
pub fn made(data: &str) -> Result<String, String> {
    let data = DeTable::parse(data).map_err(|error| format!("the data are not TOML: {error}"))?;
    let data = data.get_ref();
    let mut names = BTreeSet::new();
    let mut page = format!("# {}\n\n{}", text(data, "title")?, text(data, "introduction")?);
    for section in tables(data, "section")? {
        let _ = write!(page, "\n## {}\n\n", text(section, "title")?);
        if section.contains_key("text") {
            let _ = writeln!(page, "{}", text(section, "text")?);
        }
        page.push_str("| figure | law | command | value | date |\n|---|---|---|---|---|\n");
        for figure in tables(section, "figure")? {
            let row = row(figure)?;
            if !names.insert(text(figure, "name")?) {
                return Err(format!("two figures have this name: {row}"));
            }
            page.push_str(&row);
        }
    }
    let _ = write!(page, "\n{}", text(data, "end")?);
    Ok(page)
}

/// Returns the table row of a figure.
fn row(figure: &DeTable<'_>) -> Result<String, String> {
    let name = text(figure, "name")?;
    if let Some(key) = figure.keys().map(|key| key.get_ref()).find(|key| !KEYS.contains(&&***key)) {
        return Err(format!("{name}: the key `{key}` is unknown: known are {}", KEYS.join(", ")));
    }
    let (law, command) = (text(figure, "law")?, text(figure, "command")?);
    if !law.ends_with('.') || law.contains(". ") {
        return Err(format!("{name}: the law is not one sentence: {law}"));
    }
    let date = text(figure, "date")?;
    let shape: String = date.chars().map(|c| if c.is_ascii_digit() { '0' } else { c }).collect();
    if shape != "0000-00-00" {
        return Err(format!("{name}: write the date as 2026-01-31, and not {date}"));
    }
    let value = match figure.contains_key("unit") {
        true => format!("{} {}", text(figure, "value")?, text(figure, "unit")?),
        false => text(figure, "value")?.to_owned(),
    };
    let row = format!("| {name} | {law} | `{command}` | {value} | {date} |\n");
    // The line feed does not count.
    let length = row.chars().count() - 1;
    if length > LONGEST_ROW {
        return Err(format!("{name}: the row has {length} characters, and {LONGEST_ROW} are allowed"));
    }
    if row.matches('|').count() != 6 || row.matches('\n').count() != 1 {
        return Err(format!("{name}: a cell contains `|` or the end of a line"));
    }
    Ok(row)
}

/// Returns the string of a key.
pub(crate) fn text<'a>(table: &'a DeTable<'_>, key: &str) -> Result<&'a str, String> {
    let text = |key: &str| table.get(key).and_then(|value| value.get_ref().as_str());
    let name = text("name").or(text("title")).unwrap_or("the data");
    text(key).ok_or_else(|| format!("{name}: `{key}` is missing or no text"))
}

/// Returns the tables in the list of a key.
pub(crate) fn tables<'a, 'd>(table: &'a DeTable<'d>, key: &str) -> Result<Vec<&'a DeTable<'d>>, String> {
    let list = table.get(key).and_then(|value| value.get_ref().as_array());
    let list = list.ok_or_else(|| format!("`{key}` is no list"))?;
    let one = |value: &'a DeValue<'d>| value.as_table().ok_or_else(|| format!("`{key}` holds no table"));
    list.iter().map(|value| one(value.get_ref())).collect()
}
