//! README and `docs/` are true: commands print the output below them, specs are valid, links have
//! targets, lengths are kept.
//!
//! A fence ` ```console ` has commands after `$ ` and their output, ` ```sh ` commands alone. All
//! are run, in one folder for each document, which has `problems/` and the files of fences such as
//! ` ```toml maneuver.toml
//! `. The output may differ from the document as [`same_word`] allows. A picture beside the document
//! that a command writes is what the command draws, as [`same_picture`] compares. `BLESS=1 cargo
//! test --test it -- documents` writes the present output and pictures.

use evidence::ROOT;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Commands that no test can run, by how they begin.
const NOT_RUN: [(&str, &str); 6] = [
    ("cargo test", "it runs this test"),
    ("cargo install", "it writes into the home of who runs it"),
    ("cargo bench", "it compiles for minutes"),
    ("pip install", "it loads from the network"),
    ("maturin build", "it compiles for minutes"),
    ("chromium", "not every machine has it; `browser` opens pages where there is one"),
];

/// The beginning of commands that run the program from a clone.
const FROM_CLONE: &str = "cargo run --release -- ";

/// Returns the documents, from the top of the repository.
fn documents() -> Vec<PathBuf> {
    let top = Path::new(ROOT);
    let names =
        ["README.md", "DESIGN.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "python/README.md"];
    let mut found: Vec<_> = names.map(|n| top.join(n)).into();
    for folder in ["docs", "docs/guide", "crates/files", "crates/report", "crates/slew"] {
        let entries = fs::read_dir(top.join(folder)).unwrap().map(|entry| entry.unwrap().path());
        found.extend(entries.filter(|path| path.extension().is_some_and(|end| end == "md")));
    }
    found.sort();
    found
}

/// The text between two fences: lines `first..end` of a document.
struct Block {
    language: String,
    file: Option<String>,
    first: usize,
    end: usize,
}

fn blocks(lines: &[&str]) -> Vec<Block> {
    let mut found = Vec::new();
    let mut open: Option<Block> = None;
    for (number, line) in lines.iter().enumerate() {
        let Some(info) = line.strip_prefix("```") else { continue };
        match open.take() {
            Some(block) => found.push(Block { end: number, ..block }),
            None => {
                let mut words = info.split(' ').map(str::to_owned);
                let language = words.next().unwrap_or_default();
                open = Some(Block { language, file: words.next(), first: number + 1, end: number });
            }
        }
    }
    assert!(open.is_none(), "a fence is not closed");
    found
}

/// Returns a folder for the commands of a document.
fn folder(lines: &[&str], blocks: &[Block]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    copy(&Path::new(ROOT).join("problems"), &folder.path().join("problems"));
    for block in blocks {
        if let Some(name) = &block.file {
            fs::write(folder.path().join(name), lines[block.first..block.end].join("\n") + "\n").unwrap();
        }
    }
    folder
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let (from, to) = (entry.as_ref().unwrap().path(), to.join(entry.unwrap().file_name()));
        if from.is_dir() {
            copy(&from, &to);
        } else {
            fs::copy(from, to).unwrap();
        }
    }
}

/// Returns the reason why a command is not run; `None` if it is run.
fn not_run(command: &str) -> Option<&'static str> {
    NOT_RUN.iter().find(|(begin, _)| command.starts_with(begin)).map(|(_, reason)| *reason)
}

/// Returns the output of a command to a terminal, both streams in their order, and its exit code.
fn printed(command: &str, folder: &Path) -> (String, Option<i32>) {
    let program = Path::new(env!("CARGO_BIN_EXE_slew"));
    let path =
        format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap_or_default());
    let command = command.strip_prefix(FROM_CLONE).map_or(command.to_owned(), |rest| format!("slew {rest}"));
    let all = folder.join(".printed");
    // Both streams lead to one file, as they do to a terminal.
    let status = Command::new("sh")
        .args(["-c", &format!("{{ {command}\n}} > .printed 2>&1")])
        .env("PATH", path)
        .current_dir(folder)
        .status()
        .unwrap();
    (fs::read_to_string(all).unwrap(), status.code())
}

/// Returns whether two words are equal, or two figures that may differ from one machine to the
/// next: by one in the last printed digit, by 1e-12 of themselves, both below 1e-7, where round-off
/// decides, or `timed`, both times of computing.
fn same_word(expected: &str, found: &str, timed: bool) -> bool {
    let bare = |word: &str| {
        word.trim_matches(|c: char| !c.is_ascii_alphanumeric() && c != '-' && c != '+').to_owned()
    };
    let number = |word: &str| bare(word).parse::<f64>().ok();
    match (number(expected), number(found)) {
        _ if expected == found => true,
        (Some(a), Some(b)) => {
            timed
                || (a.abs() < 1e-7 && b.abs() < 1e-7)
                || (a - b).abs() <= (1.01 * last_digit(&bare(expected))).max(1e-12 * a.abs())
        }
        _ => false,
    }
}

/// Returns one in the last digit of a figure.
fn last_digit(figure: &str) -> f64 {
    let (digits, power) = figure.split_once(['e', 'E']).unwrap_or((figure, "0"));
    let places = digits.split_once('.').map_or(0, |(_, places)| places.len() as i32);
    10f64.powi(power.parse::<i32>().unwrap_or(0) - places)
}

/// Returns whether the word after a figure makes it a time of computing: a unit of milliseconds or
/// less, or seconds in the lines of iterations, of the time of a batch and of compared objectives.
fn is_time(line: &str, unit: Option<&&str>) -> bool {
    let unit = unit.map_or("", |word| word.trim_end_matches([',', ';', '.']));
    let label = line.split_whitespace().next();
    matches!(unit, "ms" | "µs" | "ns")
        || (unit == "s" && matches!(label, Some("iterations" | "time" | "fuel" | "effort")))
        || (unit == "cases" && label == Some("time"))
}

fn same_line(expected: &str, found: &str) -> bool {
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let (a, b) = (words(expected), words(found));
    let (a, b): (Vec<&str>, Vec<&str>) = (a.iter().map(|w| &**w).collect(), b.iter().map(|w| &**w).collect());
    a.len() == b.len()
        && (0..a.len()).all(|i| {
            let times = is_time(expected, a.get(i + 1)) && is_time(found, b.get(i + 1));
            let unit = i > 0 && is_time(expected, Some(&a[i])) && is_time(found, Some(&b[i]));
            same_word(a[i], b[i], times) || unit
        })
}

fn same_text(expected: &[&str], found: &[&str]) -> bool {
    expected.len() == found.len() && expected.iter().zip(found).all(|(a, b)| same_line(a, b))
}

/// Returns whether two pictures are equal but for the hundredths of a pixel of their coordinates.
fn same_picture(expected: &str, found: &str) -> bool {
    fn parts(text: &str) -> impl Iterator<Item = &str> {
        text.split(|c: char| c.is_whitespace() || "\"',<>()".contains(c)).filter(|part| !part.is_empty())
    }
    parts(expected).count() == parts(found).count()
        && parts(expected).zip(parts(found)).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() <= 0.03,
            _ => a == b,
        })
}

/// Compares the pictures beside a document with the pictures of the same name that its commands
/// wrote, and returns the names of the pictures that differ.
fn pictures(document: &Path, folder: &Path, bless: bool) -> Vec<String> {
    let mut differences = Vec::new();
    for entry in fs::read_dir(document.parent().unwrap()).unwrap() {
        let kept = entry.unwrap().path();
        let drawn = folder.join(kept.file_name().unwrap());
        if kept.extension().is_none_or(|end| end != "svg") || !drawn.exists() {
            continue;
        }
        let [old, new] = [&kept, &drawn].map(|path| fs::read_to_string(path).unwrap());
        if !same_picture(&old, &new) {
            differences.push(format!("{} is not what its command draws", kept.display()));
            if bless {
                fs::write(kept, new).unwrap();
            }
        }
    }
    differences
}

/// Runs the commands of a console block. Returns its lines as they should be, and the differences.
fn console(lines: &[&str], folder: &Path) -> (Vec<String>, Vec<String>) {
    let (mut now, mut differences) = (Vec::new(), Vec::new());
    let mut rest = lines;
    while let Some((first, after)) = rest.split_first() {
        let command = first.strip_prefix("$ ").expect("a console block begins with `$ ` and a command");
        let expected = &after[..after.iter().position(|line| line.starts_with("$ ")).unwrap_or(after.len())];
        rest = &after[expected.len()..];
        now.push((*first).to_owned());
        if not_run(command).is_some() {
            now.extend(expected.iter().map(|line| (*line).to_owned()));
            continue;
        }
        let (text, _) = printed(command, folder);
        let found: Vec<_> = text.lines().map(str::trim_end).collect();
        if same_text(expected, &found) {
            now.extend(expected.iter().map(|line| (*line).to_owned()));
        } else {
            differences.push(format!(
                "$ {command}\n--- documented\n{}\n+++ printed\n{}",
                expected.join("\n"),
                found.join("\n")
            ));
            now.extend(found.iter().map(|line| (*line).to_owned()));
        }
    }
    (now, differences)
}

#[test]
#[cfg(unix)]
fn commands_print_what_stands_under_them() {
    let bless = std::env::var_os("BLESS").is_some();
    let mut all = Vec::new();
    let mut run = 0;
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        let lines: Vec<_> = text.lines().collect();
        let blocks = blocks(&lines);
        if !blocks.iter().any(|block| matches!(&*block.language, "console" | "sh")) {
            continue;
        }
        let folder = folder(&lines, &blocks);
        let mut now: Vec<String> = Vec::new();
        let mut copied = 0;
        for block in &blocks {
            let inside = &lines[block.first..block.end];
            if block.language == "console" {
                let (as_it_is, differences) = console(inside, folder.path());
                now.extend(lines[copied..block.first].iter().map(|line| (*line).to_owned()));
                now.extend(as_it_is);
                copied = block.end;
                run += inside.iter().filter(|line| line.starts_with("$ ")).count();
                all.extend(differences.into_iter().map(|said| format!("{}: {said}", document.display())));
            } else if block.language == "sh" {
                for command in inside.iter().filter(|line| not_run(line).is_none()) {
                    let (said, code) = printed(command, folder.path());
                    assert_eq!(code, Some(0), "{}: {command}\n{said}", document.display());
                    run += 1;
                }
            }
        }
        all.extend(pictures(&document, folder.path(), bless));
        now.extend(lines[copied..].iter().map(|line| (*line).to_owned()));
        if bless && now != lines {
            fs::write(&document, now.join("\n") + "\n").unwrap();
        }
    }
    assert!(run >= 15, "only {run} commands were found");
    assert!(bless || all.is_empty(), "{}\nwritten anew by BLESS=1", all.join("\n\n"));
}

#[test]
fn figures_of_other_machines_are_told_from_other_figures() {
    let same = |a: &str, b: &str| same_line(a, b);
    assert!(same("  iterations  11 over 48, 1.8 ms", "  iterations  11 over 48,   902.1 µs"));
    assert!(same("residual 7.4e-15", "residual 2.2e-16"));
    assert!(same("cost 15428.3 N", "cost 15428.4 N"));
    assert!(!same("cost 15428.3 N", "cost 15428.6 N"));
    assert!(!same("residual 7.4e-15", "residual 7.4e-5"));
    assert!(!same("steps of 0.600 s", "steps of 0.610 s"));
    assert!(!same("path short way", "path long way"));
    assert!(!same_text(&["a", "b"], &["a"]));
    let point = |x: f64| format!("<circle cx=\"{x}\" cy=\"2\"/><text>T1</text>");
    assert!(same_picture(&point(1.0), &point(1.01)));
    assert!(!same_picture(&point(1.0), &point(1.2)));
    assert!(!same_picture(&point(1.0), &point(1.0).replace("T1", "T2")));
}

/// A block that is a whole spec states its format.
#[test]
fn specs_are_read() {
    let mut read = 0;
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        let lines: Vec<_> = text.lines().collect();
        for block in blocks(&lines) {
            let spec = lines[block.first..block.end].join("\n");
            if block.language == "toml" && spec.contains("format = 1") {
                let folder = tempfile::tempdir().unwrap();
                fs::write(folder.path().join("spec.toml"), spec).unwrap();
                let (said, code) = printed("slew check spec.toml", folder.path());
                assert_eq!(code, Some(0), "{}, line {}: {said}", document.display(), block.first);
                read += 1;
            }
        }
    }
    assert!(read >= 4, "only {read} specs were found");
}

/// Links to files, and to headings within them; also the names of problems and of tests.
#[test]
fn links_and_names_lead_somewhere() {
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if target.starts_with("http") {
                continue;
            }
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let file = if file.is_empty() { document.clone() } else { document.parent().unwrap().join(file) };
            assert!(file.exists(), "{}: {target} leads nowhere", document.display());
            if !heading.is_empty() {
                let anchors = |text: &str| -> Vec<String> {
                    let headings = text.lines().filter_map(|line| line.strip_prefix('#'));
                    headings.map(|line| anchor(line.trim_start_matches('#').trim())).collect()
                };
                let known = anchors(&fs::read_to_string(&file).unwrap());
                assert!(known.iter().any(|a| a == heading), "{}: no heading {target}", document.display());
            }
        }
        for quoted in text.split('`').skip(1).step_by(2) {
            if let [folder, file, name] = quoted.split("::").collect::<Vec<_>>()[..] {
                let of = |tests| Path::new(ROOT).join(format!("tests/{tests}/{folder}/{file}.rs"));
                let file = if of("laws").exists() { of("laws") } else { of("it") };
                let text = fs::read_to_string(&file).unwrap_or_default();
                let is_test = !file.exists() || text.contains(&format!("fn {name}()"));
                assert!(is_test, "{}: no test {quoted}", document.display());
            }
            if let Some(name) = quoted.strip_prefix("problems/").filter(|name| name.ends_with(".toml")) {
                let file = Path::new(ROOT).join("problems").join(name);
                assert!(name.contains('*') || file.exists(), "{}: no problems/{name}", document.display());
            }
        }
    }
}

/// Returns the commands of `evidence` by their files; its index must have each of them.
fn counts() -> Vec<String> {
    let folder = Path::new(ROOT).join("evidence/src/commands");
    let mut files: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .filter_map(|entry| Some(entry.unwrap().file_name().to_str()?.strip_suffix(".rs")?.to_string()))
        .filter(|name| name != "mod")
        .collect();
    files.sort();
    let text = fs::read_to_string(folder.join("mod.rs")).unwrap();
    let (_, rest) = text.rsplit_once("commands! {").unwrap();
    let index: Vec<_> = rest.split('}').next().unwrap().split_whitespace().collect();
    assert_eq!(index, files, "the index of evidence/src/commands/mod.rs");
    files
}

/// Collects the texts that may have a command that prints a figure.
fn texts(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if name == ".ci" || !(name.starts_with('.') || name == "target") {
                texts(&path, found);
            }
        } else if ["rs", "md", "py", "toml"].iter().any(|end| name.ends_with(end)) || name == "run" {
            found.push(path);
        }
    }
}

/// Every command of `evidence` and every benchmark that a text names exists, and the index of
/// `evidence` has all commands.
#[test]
fn what_measures_is_there() {
    let (commands, mut files, mut seen) = (counts(), Vec::new(), 0);
    texts(Path::new(ROOT), &mut files);
    let word =
        |rest: &str| -> String { rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect() };
    let own = Path::new(ROOT).join("crates/slew/../../tests/it/documents.rs").canonicalize().unwrap();
    files.retain(|file| file.canonicalize().unwrap() != own);
    for file in files {
        // A command may continue in the next line of a comment.
        let text = String::from_utf8_lossy(&fs::read(&file).unwrap()).into_owned();
        let unmarked = |line: &str| line.trim_start_matches([' ', '/', '!']).to_owned();
        let text = text.lines().map(unmarked).collect::<Vec<_>>().join(" ");
        for start in ["-p evidence -- ", "-p evidence --features sdp -- ", "debug/evidence ", "`… -- "] {
            // Placeholders are in capitals.
            for name in text.split(start).skip(1).map(word).filter(|name| name.to_lowercase() == *name) {
                let is_there = commands.contains(&name) || name == "help";
                assert!(is_there, "{}: {start}{name}: no such command", file.display());
                seen += 1;
            }
        }
        for name in text.split("-p benches --bench ").skip(1).map(word) {
            let bench = Path::new(ROOT).join(format!("evidence/benches/{name}.rs"));
            assert!(bench.exists(), "{}: no benchmark {name}", file.display());
        }
        for gone in ["-p evidence --bin ", "-p evidence --bench "] {
            assert!(!text.contains(gone), "{}: {gone}", file.display());
        }
    }
    assert!(seen > 80, "only {seen} commands were found");
}

/// Returns the anchor of a heading in links.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase();
    kept.chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

#[test]
fn documents_are_as_short_as_promised() {
    let read = |name: &str| fs::read_to_string(Path::new(ROOT).join(name)).unwrap();
    assert!(read("README.md").lines().count() <= 150);
    assert!(read("CHANGELOG.md").lines().count() <= 20);
    assert!(read("DESIGN.md").len() <= 35_000);
}

#[test]
fn the_page_of_figures_is_made_from_their_data() {
    let data = fs::read_to_string(evidence::figures::data()).unwrap();
    let page = fs::read_to_string(evidence::figures::page()).unwrap();
    let made = evidence::figures::made(&data).unwrap();
    assert!(page == made, "cargo run -p evidence -- figures writes docs/figures.md");
    assert!(page.matches("\n| ").count() > 300);
}

#[test]
fn wrong_figures_are_refused() {
    let data = |figure: &str| {
        let texts = "title = \"T\"\nintroduction = \"I\"\nend = \"E\"\n[[section]]\ntitle = \"S\"\n";
        format!("{texts}[[section.figure]]\n{figure}\n")
    };
    let right = "name = \"n\"\nlaw = \"All.\"\ncommand = \"c\"\nvalue = \"1\"\ndate = \"2026-11-25\"";
    let made = |figure: &str| evidence::figures::made(&data(figure));
    assert!(made(right).unwrap().contains("\n| n | All. | `c` | 1 | 2026-11-25 |\n"));
    let twice = format!("{right}\n[[section.figure]]\n{right}");
    let long = right.replace("All", &"a".repeat(300));
    for (wrong, said) in [
        (right.replace("value = \"1\"\n", ""), "`value` is missing"),
        (right.replace("value", "number"), "`number` is unknown"),
        (right.replace("All.", "All. Some."), "not one sentence"),
        (right.replace("2026-11-25", "yesterday"), "write the date as"),
        (right.replace("\"c\"", "\"c | d\""), "contains `|`"),
        (long, "300 are allowed"),
        (twice, "two figures"),
    ] {
        let error = made(&wrong).unwrap_err();
        assert!(error.contains(said), "{wrong}\n{error}");
    }
}

#[test]
fn the_page_of_validation_is_made_from_its_claims() {
    let [claims, figures, page] =
        [evidence::validation::data(), evidence::figures::data(), evidence::validation::page()]
            .map(|path| fs::read_to_string(path).unwrap());
    let made = evidence::validation::made(&claims, &figures).unwrap();
    assert!(page == made, "cargo run -p evidence -- validation writes docs/validation.md");
    assert!(page.matches("\n| ").count() > 60);
}

/// A maneuver that is added makes the figure old.
#[test]
fn the_figure_of_best_known_plans_counts_all_of_them() {
    let data = fs::read_to_string(evidence::figures::data()).unwrap();
    let figure = data.split("[[section.figure]]").find(|figure| figure.contains("\nname = \"Best known\"\n"));
    let maneuvers = fs::read_dir(Path::new(evidence::ROOT).join("evidence/best_known")).unwrap().count();
    assert!(
        figure.unwrap().contains(&format!("\nunit = \"of {maneuvers}\"\n")),
        "evidence -- best_known: {maneuvers}"
    );
}

#[test]
fn claims_without_a_test_are_refused() {
    let figures = "[[section]]\n[[section.figure]]\nname = \"n\"\ncommand = \"c\"\nvalue = \"1\"\n\
        date = \"2026-11-25\"";
    let made = |claim: &str| {
        let texts = "title = \"T\"\nintroduction = \"I\"\nend = \"E\"\n[[section]]\ntitle = \"S\"\n";
        evidence::validation::made(&format!("{texts}[[section.claim]]\n{claim}\n"), figures)
    };
    let right = "claim = \"It holds.\"\nagainst = \"a\"\ntest = \"it::documents::claims_without_a_test_are_refused\"\n\
        value = \"below 1e-77\"";
    // The bound 1e-77 belongs to this test.
    let row = "\n| It holds. | a | `cargo test --test it -- documents::claims_without_a_test_are_refused` | \
        below 1e-77 | each commit |\n";
    assert!(made(right).unwrap().contains(row));
    let counted = "claim = \"It holds.\"\nagainst = \"a\"\nfigure = \"n\"";
    assert!(made(counted).unwrap().contains("\n| It holds. | a | `c` | 1 | 2026-11-25 |\n"));
    for (wrong, said) in [
        (right.replace("1e-77", &["1e-7", "8"].concat()), "does not stand in"),
        (right.replace("claims_without", "claims_within"), "no test"),
        (right.replace("documents::claims_without_a_test_are_refused", "documents::same_word"), "is no test"),
        (right.replace("it::documents", "it::documents2"), "no test"),
        (right.replace("It holds.", "It holds"), "not one sentence"),
        (right.replace("against", "beside"), "`beside` is unknown"),
        (format!("{right}\n[[section.claim]]\n{right}"), "two claims"),
        (right.replace("\"a\"", "\"a | b\""), "contains `|`"),
        (counted.replace("\"n\"", "\"m\""), "no figure"),
    ] {
        let error = made(&wrong).unwrap_err();
        assert!(error.contains(said), "{wrong}\n{error}");
    }
}

/// The program shows them by `slew help`, so they lie in its crate.
#[test]
#[cfg(unix)]
fn glossary_and_conventions_are_those_of_the_program() {
    for topic in ["glossary", "conventions"] {
        let page = fs::read_to_string(Path::new(ROOT).join(format!("docs/{topic}.md"))).unwrap();
        let (shown, code) = printed(&format!("slew help {topic}"), tempfile::tempdir().unwrap().path());
        assert_eq!(code, Some(0));
        assert!(page == shown, "copy crates/slew/src/{topic}.md to docs/{topic}.md");
    }
}
