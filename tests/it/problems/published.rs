//! `docs/published.md` is the table of published maneuvers: it has every spec with a published
//! cost.
//!
//! Each row is read from a spec, whose plan `maneuvers.rs` holds to these numbers.
//! `BLESS=1 cargo test --test it -- published` writes the table.

use super::maneuvers::files;
use slewkit::maneuver::Objective;
use slewkit_files::spec;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Returns the table of the specs, a row each.
fn table() -> String {
    let mut table =
        String::from("| maneuver | minimizes | published | ours | source |\n|---|---|---|---|---|\n");
    for path in files() {
        let loaded = spec::read(&path, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        let Some((expect, published)) = loaded.expect.as_ref().and_then(|one| Some((one, one.published?)))
        else {
            continue;
        };
        let ours = expect.continuous_cost.or(expect.cost).expect("a cost of ours");
        let what = match loaded.problem.objective {
            Objective::Time => "time [s]",
            Objective::Fuel(_) => "fuel",
            _ => "effort",
        };
        let link = path.strip_prefix(evidence::ROOT).map(Path::to_path_buf).unwrap_or_else(|_| {
            let path = path.canonicalize().expect("a file");
            path.strip_prefix(Path::new(evidence::ROOT).canonicalize().expect("a folder"))
                .expect("of the root")
                .into()
        });
        let source = expect.source.as_deref().expect("a source");
        let (name, link) = (&loaded.problem.name, link.display());
        writeln!(table, "| [{name}](../{link}) | {what} | {} | {} | {source} |", published.value, ours.value)
            .expect("text takes everything");
    }
    table
}

#[test]
fn the_table_of_published_maneuvers_is_that_of_the_specs() {
    let file = Path::new(evidence::ROOT).join("docs/published.md");
    let text = fs::read_to_string(&file).unwrap_or_default();
    let at = text.find("| maneuver |").unwrap_or(text.len());
    let told = format!("{}{}", &text[..at], table());
    if std::env::var("BLESS").is_ok() {
        fs::write(&file, told).expect("the document is written");
        return;
    }
    assert_eq!(text, told, "BLESS=1 writes the table");
}
