//! Counts the lines of code and the numeric constants of the planner and of all crates.
//!
//! `cargo run --release -p evidence -- size [FOLDER]` counts the sources of a checkout, this one if
//! no folder is given. Another commit is counted in its own worktree.
//!
//! - A line of code is neither blank nor a comment. Tests do not count: items under `#[cfg(test)]`,
//!   files whose name is `tests.rs` or ends with `_tests.rs` or `testing.rs`, and files in a folder
//!   `tests`.
//! - A constant of `src/optimize` is a named constant of numbers (an array counts once), a default
//!   of settings, or a number with a decimal point or an exponent in a function. The numbers 0, 1,
//!   2 and ½ do not count. Whole numbers in functions are mostly dimensions, and do not count
//!   either.

use evidence::ROOT;
use evidence::words::Words;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

/// The types of constants that hold numbers.
const NUMERIC: [&str; 7] = ["f64", "usize", "i32", "u32", "u64", "Vector3", "Pace"];

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let root = words.take().map_or_else(|| PathBuf::from(ROOT), PathBuf::from);
    words.end()?;
    let of = |folder: &str| Size::of(&root.join(folder));
    let (optimize, library, crates) = (of("src/optimize")?, of("src")?, of("crates")?);
    let all = library.lines + crates.lines;
    println!("src/optimize     {:6} lines, {} constants", optimize.lines, optimize.constants());
    println!("                 {:6} named, {} other numbers", optimize.named, optimize.literals);
    println!("src and crates   {all:6} lines");
    Ok(())
}

/// The counts of a folder.
#[derive(Clone, Copy, Default)]
struct Size {
    lines: usize,
    named: usize,
    literals: usize,
}

impl Size {
    /// Counts the sources in a folder and its subfolders.
    fn of(folder: &Path) -> Result<Self, Box<dyn Error>> {
        let mut size = Self::default();
        for entry in fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let of_tests =
                ["tests.rs", "testing.rs", "tests"].contains(&&*name) || name.ends_with("_tests.rs");
            if of_tests || name == "target" {
                continue;
            }
            if path.is_dir() {
                size.add(Self::of(&path)?);
            } else if name.ends_with(".rs") {
                size.add(Self::of_text(&fs::read_to_string(&path)?));
            }
        }
        Ok(size)
    }

    /// Counts the text of a source file.
    fn of_text(text: &str) -> Self {
        let (mut size, mut lines) = (Self::default(), text.lines().peekable());
        // These variables are true if the line belongs to a named constant that is counted, or to
        // defaults of settings.
        let (mut within_named, mut defaults) = (false, false);
        while let Some(line) = lines.next() {
            let code = code_of(line);
            if code.trim() == "#[cfg(test)]" {
                skip_item(&mut lines);
                continue;
            }
            if code.trim().is_empty() {
                continue;
            }
            size.lines += 1;
            if names_constant(&code) && NUMERIC.iter().any(|name| code.contains(name)) {
                size.named += 1;
                within_named = true;
            }
            defaults = code.starts_with("impl Default for") || defaults && code != "}";
            if !within_named {
                size.literals += numbers(&code, defaults);
            }
            within_named &= !code.contains(';') || code.trim_end().ends_with(['[', '(', '{', ',', '=']);
        }
        size
    }

    fn add(&mut self, other: Self) {
        self.lines += other.lines;
        self.named += other.named;
        self.literals += other.literals;
    }

    fn constants(&self) -> usize {
        self.named + self.literals
    }
}

/// Returns whether a line begins with a named constant. A const parameter of a generic item does
/// not count.
fn names_constant(code: &str) -> bool {
    let Some((before, after)) = code.split_once("const ") else { return false };
    let visibility = before.trim();
    let is_visibility = visibility.starts_with("pub(") && visibility.ends_with(')');
    (visibility.is_empty() || visibility == "pub" || is_visibility)
        && after.contains(": ")
        && !after.starts_with("fn ")
}

/// Skips the item after an attribute.
fn skip_item<'a>(lines: &mut impl Iterator<Item = &'a str>) {
    let mut depth = 0_usize;
    for line in lines {
        let code = code_of(line);
        depth += code.matches('{').count();
        depth = depth.saturating_sub(code.matches('}').count());
        let ends = code.contains('}') || code.trim_end().ends_with(';');
        if depth == 0 && ends && !code.trim_start().starts_with('#') {
            return;
        }
    }
}

/// Returns a line without comments and string contents.
fn code_of(line: &str) -> String {
    let (mut code, mut in_text, mut before) = (String::new(), false, ' ');
    for at in line.chars() {
        if at == '"' && before != '\\' {
            in_text = !in_text;
        } else if !in_text {
            code.push(at);
        }
        if code.ends_with("//") {
            code.truncate(code.len() - 2);
            break;
        }
        before = at;
    }
    code
}

/// Returns the number of numeric literals in a line, except 0, 1, 2 and ½. Whole numbers count only
/// if `whole` is true.
fn numbers(code: &str, whole: bool) -> usize {
    let of_number = |at: char| at.is_ascii_alphanumeric() || at == '.' || at == '_' || at == '-';
    let is_counted = |word: &&str| {
        let word = word.trim_start_matches(['-', '.']);
        let Ok(number) = word.trim_end_matches("_f64").replace('_', "").parse::<f64>() else { return false };
        let is_number =
            word.starts_with(|at: char| at.is_ascii_digit()) && (whole || word.contains(['.', 'e']));
        is_number && ![0.0, 0.5, 1.0, 2.0].contains(&number.abs())
    };
    code.split(|at: char| !of_number(at)).filter(is_counted).count()
}
