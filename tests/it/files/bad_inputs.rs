//! One file for each mistake, named after the mistake, with the expected message.

use super::{BASE, bad, good};
use slewkit_files::spec::{self, Format, Severity};
use std::fs;
use std::path::{Path, PathBuf};

pub fn files() -> Vec<PathBuf> {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/bad_inputs");
    let tables = fs::read_dir(top).unwrap().map(|entry| entry.unwrap().path());
    let files = tables.flat_map(|table| fs::read_dir(table).unwrap().map(|entry| entry.unwrap().path()));
    let mut files: Vec<_> =
        files.filter(|path| path.extension().is_some_and(|ext| ext == "toml" || ext == "json")).collect();
    files.sort();
    files
}

/// Removes the folder of the file from a text, because it differs between machines.
fn without_folder(said: &str, path: &Path) -> String {
    said.replace(&format!("{}/", path.parent().unwrap().display()), "")
}

/// Returns the errors or the warnings that the user reads about a file.
fn reading(path: &Path) -> String {
    match spec::load(path, Format::of(path), &[]) {
        Ok(spec) => {
            let warnings: Vec<String> =
                spec.warnings().iter().map(|warning| format!("{warning}\n")).collect();
            format!("{}accepted\n", without_folder(&warnings.concat(), path))
        }
        Err(errors) => without_folder(&errors.to_string(), path),
    }
}

/// `UPDATE_EXPECTED=1 cargo test --test it -- bad_inputs` writes the new texts for review after a
/// deliberate change.
#[test]
fn each_file_says_what_is_wrong_and_what_to_do() {
    let mut different = Vec::new();
    for path in files() {
        let name = path.file_name().unwrap().to_str().unwrap();
        let expected_path = path.with_file_name(format!("{name}.txt"));
        let said = reading(&path);
        if std::env::var_os("UPDATE_EXPECTED").is_some() {
            fs::write(&expected_path, &said).unwrap();
        }
        let expected = fs::read_to_string(&expected_path).unwrap_or_default();
        if said != expected {
            different.push(format!("--- {name}, expected:\n{expected}--- said:\n{said}"));
        }
    }
    assert!(different.is_empty(), "{}", different.join("\n"));
}

#[test]
fn no_message_holds_a_control_character() {
    for path in files() {
        let said = reading(&path);
        assert!(said.chars().all(|c| c == '\n' || !c.is_control()), "{}: {said:?}", path.display());
    }
}

#[test]
fn wrong_override_is_shown_as_typed() {
    let errors = bad(BASE, &["maneuver.steps=1", "solver.tolerance = 1e-20", "maneuver.path=fast"]);
    let expected = "\
command line:1:22: error[E0033]: `steps`: 1 is too few: a plan needs at least 2 steps
 1 | --set maneuver.steps=1
   |                      ^
 help: write 100, or remove the key for an automatic choice

command line:1:24: error[E0036]: a tolerance of 1e-20 is below 4e-15, the limit of double precision here
 1 | --set solver.tolerance=1e-20
   |                        ^^^^^
 help: write 1e-12, or remove the key

command line:1:21: error[E0020]: `path`: \"fast\" is not one of \"best\", \"shortest\", \"long\", \"as_given\"
 1 | --set maneuver.path=fast
   |                     ^^^^
 help: write one of \"best\", \"shortest\", \"long\", \"as_given\"

3 errors
";
    assert_eq!(errors.to_string(), expected);
}

#[test]
fn override_into_a_number_says_what_stands_in_the_way() {
    let errors = bad(BASE, &["maneuver.steps.count=3"]);
    assert_eq!(errors.0[0].code, "E0025");
    assert_eq!(errors.0[0].reason, "`count` would be inside a number, which is not a table");
    let errors = bad(BASE, &["end.attitude.euler_zyx_deg.3=1"]);
    assert_eq!(errors.0[0].reason, "a list of 3 has no element `3`");
}

#[test]
fn finding_serialises_with_its_place() {
    let errors = bad(&BASE.replace("duration_s = 60", "duration_s = -60"), &[]);
    let expected = serde_json::json!([{
        "code": "E0032", "severity": "error", "file": "test.toml", "line": 13, "column": 14,
        "key": "maneuver.duration_s", "text": "-60",
        "reason": "`duration_s`: a time of -60 s is impossible: it must be positive",
        "remedy": "write a positive number",
    }]);
    assert_eq!(serde_json::to_value(&errors).unwrap(), expected);
}

#[test]
fn colour_only_on_request() {
    let errors = bad(&BASE.replace("duration_s = 60", "duration_s = -60"), &[]);
    assert!(errors.render(true).contains("\x1b[1;31merror[E0032]\x1b[0m"));
    assert!(!errors.render(false).contains('\x1b'));
}

#[test]
fn nonsense_without_end_gives_a_hundred_findings() {
    let many: String = (0..20_000).map(|index| format!("colour_{index} = 1\n")).collect();
    let errors = bad(&format!("{BASE}{many}"), &[]);
    assert_eq!(errors.0.len(), 100);
    let duplicates: String = (0..20_000).map(|_| "steps = 1\n").collect();
    let errors = bad(&format!("{BASE}{duplicates}"), &[]);
    assert!(errors.0.len() <= 100 && errors.0.iter().all(|finding| finding.code == "E0011"));
}

#[test]
fn every_accepted_file_has_a_warning_and_every_other_an_error() {
    for path in files() {
        let severity = match spec::load(&path, Format::of(&path), &[]) {
            Ok(spec) => spec.warnings().first().map(|finding| finding.severity),
            Err(errors) => {
                errors.0.iter().map(|finding| finding.severity).find(|severity| *severity == Severity::Error)
            }
        };
        assert!(severity.is_some(), "{}", path.display());
    }
    good(BASE, &[]);
}
