//! Compares the results of two builds of `slew`, number by number.
//!
//! `cargo run --release -p evidence -- same_answers OLD NEW [COUNT] [--keep FOLDER]` plans every
//! maneuver of `problems/` and COUNT random specs (200 by default) with both binaries. The JSON of
//! NEW must have the status, the exit code and every value of the JSON of OLD, bit for bit. It may
//! have additional keys. FOLDER keeps the specs and the results of OLD for the next run. The
//! command ends with 1 if something differs.

use evidence::words::{Misuse, Words, parsed};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{fs, io, process, thread};

/// The intended differences: the key in OLD, with `*` for any index of a list, the change, and its
/// reason.
const CHANGED: &[(&str, Change, &str)] = &[
    ("solve_time_s", Change::Free, "a time of the machine"),
    ("generator", Change::Free, "the version of the program"),
    ("format", Change::Free, "plan files hold the spec that they answer: format 2"),
    ("outcome", Change::Renamed("unreachable", "infeasible"), "one word for what is proved"),
    ("problem", Change::Moved("spec"), "the maneuver in the notation of a spec"),
    ("problem.motion", Change::Free, "a spec has positions or not"),
    ("problem.inertia_kg_m2", Change::Free, "a diagonal of three where it is diagonal"),
    ("problem.mass_kg", Change::Moved("spec.body.mass_kg"), "as in a spec"),
    ("problem.environment", Change::Free, "the numbers of the spec, not what follows from them"),
    ("problem.torque", Change::Free, "axes, weights and limits in [actuators]"),
    ("problem.force", Change::Free, "axes, weights and limits in [actuators]"),
    ("problem.wheels", Change::Free, "one [[actuators.wheel]] each"),
    ("problem.constraints", Change::Free, "one [[constraint]] each"),
    ("problem.start.matrix", Change::Moved("spec.start.attitude.matrix"), "as in a spec"),
    ("problem.end.matrix", Change::Moved("spec.end.attitude.matrix"), "as in a spec"),
    ("problem.duration_s", Change::Moved("spec.maneuver.duration_s"), "as in a spec"),
    ("problem.path", Change::Moved("spec.maneuver.path"), "as in a spec"),
    ("problem.rotation_from_start_rad", Change::Moved("spec.end.rotation_from_start_rad"), "as in a spec"),
    ("settings", Change::Moved("spec.solver"), "as in a spec"),
    ("settings.continuous_tolerance_rad", Change::Free, "absent where it was null"),
    ("settings.time_limit_s", Change::Free, "absent where it was null"),
    ("verified.continuous_attitude_rad", Change::Free, "a Taylor series for free bodies"),
    ("verified.continuous_rate_rad_s", Change::Free, "the same"),
    ("verified.continuous_position_m", Change::Free, "the same"),
    ("verified.continuous_velocity_m_s", Change::Free, "the same"),
    ("verified.interpolated_attitude_rad", Change::Free, "the same"),
    ("verified.interpolated_rate_rad_s", Change::Free, "the same"),
    ("verified.margins.*.continuous_margin", Change::Free, "the same"),
    ("verified.symplectic_attitude_rad", Change::Free, "over windows"),
    ("verified.symplectic_rate_rad_s", Change::Free, "over windows"),
    ("verified.symplectic_position_m", Change::Free, "over windows"),
    ("verified.symplectic_velocity_m_s", Change::Free, "over windows"),
    ("verified.symplectic_to_continuous", Change::Free, "over windows"),
    ("verified.order", Change::Free, "over windows"),
    ("verified.checks.*.name", Change::Free, "order is seen where all was round-off"),
    ("verified.checks.*.value", Change::Free, "over windows"),
    ("verified.checks.*.limit", Change::Free, "over windows"),
];

/// The change of a key.
enum Change {
    /// The value is not compared.
    Free,
    /// The value is now under another key.
    Moved(&'static str),
    /// One word of the text differs.
    Renamed(&'static str, &'static str),
}

/// The number of a case, and the differences.
type Differences = (usize, Vec<String>);

/// Number of differences printed for one spec.
const SHOWN: usize = 5;
/// The number of plans that are made at a time.
const WORKERS: usize = 2;

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = words.rest();
    let keep = match arguments.iter().position(|argument| argument == "--keep") {
        Some(at) if at + 1 < arguments.len() => {
            Some(PathBuf::from(arguments.drain(at..at + 2).nth(1).unwrap()))
        }
        _ => None,
    };
    let (old, new, count) = match &arguments[..] {
        [old, new] => (old, new, 200),
        [old, new, count] => (old, new, parsed("number of cases", count)?),
        _ => return Err(Misuse::new("it takes OLD NEW [COUNT] [--keep FOLDER]").into()),
    };
    let scratch = tempfile::tempdir()?;
    let folder = keep.as_deref().unwrap_or(scratch.path());
    let (specs, answers) = (folder.join("specs"), folder.join("answers"));
    fs::create_dir_all(&specs)?;
    fs::create_dir_all(&answers)?;

    let cases = cases(count)?;
    let next = AtomicUsize::new(0);
    let work = || -> io::Result<Vec<Differences>> {
        let mut differences = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some((name, text)) = cases.get(index) else { return Ok(differences) };
            let spec = specs.join(format!("{name}.toml"));
            let kept = answers.join(format!("{name}.json"));
            let known = fs::read_to_string(&spec).is_ok_and(|kept| kept == *text);
            if !known {
                fs::write(&spec, text)?;
            }
            let recorded = if known { fs::read_to_string(&kept).ok() } else { None };
            let expected = match recorded {
                Some(recorded) => recorded,
                None => {
                    let answer = answer(Path::new(old), &spec)?;
                    fs::write(&kept, &answer)?;
                    answer
                }
            };
            differences.push((index, compare(&expected, &answer(Path::new(new), &spec)?)));
        }
    };
    let found = thread::scope(|scope| -> io::Result<Vec<_>> {
        let workers: Vec<_> = (0..WORKERS).map(|_| scope.spawn(work)).collect();
        let mut found = Vec::new();
        for worker in workers {
            found.extend(worker.join().expect("no panic")?);
        }
        found.sort();
        Ok(found)
    })?;

    let mut different = 0;
    for (index, differences) in found.iter().filter(|(_, differences)| !differences.is_empty()) {
        different += 1;
        println!("{}: {} differences", cases[*index].0, differences.len());
        differences.iter().take(SHOWN).for_each(|difference| println!("    {difference}"));
    }
    println!("{} specs, {different} with other answers", found.len());
    process::exit(i32::from(different > 0));
}

/// Returns the names and texts of all specs: the maneuvers of `problems/`, then random ones.
fn cases(count: u64) -> io::Result<Vec<(String, String)>> {
    let mut cases = Vec::new();
    for entry in fs::read_dir(Path::new(evidence::ROOT).join("problems"))? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let text = fs::read_to_string(&path)?;
            if text.lines().any(|line| line.trim() == "[maneuver]") {
                let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                cases.push((name, text));
            }
        }
    }
    cases.sort();
    cases.extend((0..count).map(|index| {
        let spec = evidence::random_specs::random_spec(index);
        (format!("random_{index:03}_{}", spec.kind), spec.text)
    }));
    Ok(cases)
}

/// Plans a spec with a binary. Returns the exit code, a line feed, and the JSON.
fn answer(slew: &Path, spec: &Path) -> io::Result<String> {
    let mut command = Command::new(slew);
    command.arg("plan").arg(spec).args(["--format", "json", "--quiet"]);
    let output = command.stdin(Stdio::null()).stderr(Stdio::null()).output()?;
    let code = output.status.code().map_or("killed".into(), |code| code.to_string());
    Ok(format!("{code}\n{}", String::from_utf8_lossy(&output.stdout)))
}

/// Describes all differences between two results.
fn compare(old: &str, new: &str) -> Vec<String> {
    let parts = |answer: &str| {
        let (code, json) = answer.split_once('\n').unwrap_or((answer, ""));
        (code.to_string(), serde_json::from_str::<Value>(json))
    };
    let ((old_code, old), (new_code, new)) = (parts(old), parts(new));
    let mut differences = Vec::new();
    if old_code != new_code {
        differences.push(format!("exit code: {old_code}, now {new_code}"));
    }
    match (old, new) {
        (Ok(old), Ok(new)) => descend("", &old, &new, &new, &mut differences),
        (Err(_), Err(_)) => differences.push("no answer of either, is the spec valid?".into()),
        (Ok(_), Err(error)) => differences.push(format!("no answer any more: {error}")),
        (Err(_), Ok(_)) => differences.push("an answer where none was".into()),
    }
    differences
}

/// Compares `old` with `new` recursively. `path` is the key of `old`, and `root` is the whole new
/// result.
fn descend(path: &str, old: &Value, new: &Value, root: &Value, differences: &mut Vec<String>) {
    match (old, new) {
        (Value::Object(old), Value::Object(_)) => {
            for (key, old) in old {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                let new = match change(&path) {
                    Some(Change::Free) => continue,
                    Some(Change::Moved(to)) => to.split('.').try_fold(root, |value, key| value.get(key)),
                    Some(Change::Renamed(was, is))
                        if *old == **was && new.get(key).is_some_and(|new| *new == **is) =>
                    {
                        continue;
                    }
                    Some(Change::Renamed(..)) | None => new.get(key),
                };
                match new {
                    Some(new) => descend(&path, old, new, root, differences),
                    None => differences.push(format!("{path}: {}, now missing", short(old))),
                }
            }
        }
        (Value::Array(old), Value::Array(new)) => {
            if old.len() != new.len() {
                differences.push(format!("{path}: {} entries, now {}", old.len(), new.len()));
            }
            for (index, (old, new)) in old.iter().zip(new).enumerate() {
                descend(&format!("{path}.{index}"), old, new, root, differences);
            }
        }
        // The bits are compared, because −0 must differ from 0.
        (Value::Number(old), Value::Number(new))
            if old.as_f64().map(f64::to_bits) == new.as_f64().map(f64::to_bits) => {}
        _ if old == new && !old.is_number() => {}
        _ => differences.push(format!("{path}: {}, now {}", short(old), short(new))),
    }
}

/// Returns the intended change of a key; `None` if it must not change.
fn change(path: &str) -> Option<&'static Change> {
    let matches = |pattern: &str| {
        let (pattern, path): (Vec<_>, Vec<_>) = (pattern.split('.').collect(), path.split('.').collect());
        pattern.len() == path.len()
            && pattern.iter().zip(path).all(|(a, b)| *a == b || *a == "*" && b.parse::<usize>().is_ok())
    };
    CHANGED.iter().find(|(pattern, ..)| matches(pattern)).map(|(_, change, _)| change)
}

/// Formats a value in one line.
fn short(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() > 120 { text.chars().take(120).chain("…".chars()).collect() } else { text }
}
