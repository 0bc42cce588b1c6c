//! The import law of `DESIGN.md` ("What may import what?"), compared with the `use` lines and paths
//! of all crates.
//!
//! A file imports the files that define the names it uses. A re-exported name counts for the file
//! that defines it. A whole module counts for its own file and for all names that it re-exports.
//! Test modules may import anything.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The names of the crates, and the folders of their sources.
const CRATES: [(&str, &str); 5] = [
    ("slewkit", "src"),
    ("slewkit_files", "crates/files/src"),
    ("slewkit_sky", "crates/sky/src"),
    ("slewkit_report", "crates/report/src"),
    ("slewkit_cli", "crates/slew/src"),
];

/// A path by wings, `["lie", "exp"]`, without the crate of the wing.
type Name = Vec<String>;
/// The files by the path of their module; files of tests are left out.
type Modules = BTreeMap<Name, Module>;

/// Returns the path by wings of a path within a crate.
fn by_wings(of: &str, path: &[String]) -> Name {
    let wing = match (of, path.first().map(String::as_str)) {
        ("slewkit", _) | ("slewkit_files", Some("batch")) | ("slewkit_report", Some("draw" | "studies")) => {
            None
        }
        ("slewkit_files", _) => Some("files"),
        ("slewkit_sky", _) => Some("sky"),
        ("slewkit_report", _) => Some("report"),
        _ => Some("cli"),
    };
    wing.map(String::from).into_iter().chain(path.iter().cloned()).collect()
}

/// One file.
struct Module {
    file: String,
    /// The names that it uses, as absolute paths.
    uses: Vec<Name>,
    /// The names that it re-exports: the new name, and the original one.
    passes_on: Vec<(String, Name)>,
    /// Every word of its code.
    words: Vec<String>,
}

/// Crate, file and text of every module.
type Sources = BTreeMap<Name, (&'static str, String, String)>;

/// Collects every file of a crate below a folder, with its path as `wing::path::of::the::file`.
fn files(of: &'static str, root: &Path, folder: &Path, found: &mut Sources) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(of, root, &path, found);
            continue;
        }
        let file = path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
        let left_out = ["main.rs", "tests.rs", "testing.rs"].iter().any(|end| file.ends_with(end))
            || file.contains("/tests/");
        if let (Some(stem), false) = (file.strip_suffix(".rs"), left_out) {
            let parts = stem.split('/').filter(|part| !["mod", "lib", "main"].contains(part));
            let name = by_wings(of, &parts.map(String::from).collect::<Vec<_>>());
            found.entry(name).or_insert((of, path.display().to_string(), fs::read_to_string(&path).unwrap()));
        }
    }
}

/// Returns the words and signs of the code, without comments and without items under
/// `#[cfg(test)]`.
fn tokens(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let lines = code.lines().map(|line| line.split("//").next().unwrap());
    let mut tokens: Vec<String> = vec![];
    let mut word = false;
    for sign in lines.flat_map(|line| line.chars().chain(['\n'])) {
        let in_word = sign.is_alphanumeric() || sign == '_';
        let colons = sign == ':' && tokens.last().is_some_and(|last| last == ":");
        match tokens.last_mut() {
            Some(last) if (in_word && word) || colons => last.push(sign),
            _ if !sign.is_whitespace() => tokens.push(sign.into()),
            _ => {}
        }
        word = in_word;
    }
    tokens
}

/// Returns the paths that begin at token `at`, with braces multiplied out, each with the name it
/// gets; and where they end.
fn paths(tokens: &[String], mut at: usize, prefix: &[String], found: &mut Vec<(String, Name)>) -> usize {
    let mut path = prefix.to_vec();
    loop {
        let token = tokens[at].as_str();
        if token == "{" {
            at += 1;
            while tokens[at] != "}" {
                at = paths(tokens, at, &path, found);
                at += usize::from(tokens[at] == ",");
            }
            return at + 1;
        }
        path.extend((token != "self" || path.is_empty()).then(|| token.to_string()));
        if tokens[at + 1] == "::" && tokens[at + 2] != "<" {
            at += 2;
            continue;
        }
        let renamed = tokens[at + 1] == "as";
        let name = if renamed { &tokens[at + 2] } else { path.last().unwrap_or(&tokens[at]) };
        found.push((name.clone(), path.clone()));
        return at + if renamed { 3 } else { 1 };
    }
}

/// Returns the path by wings of a path written in `module` of a crate; `None` for a name outside of
/// our crates.
fn absolute(path: &[String], of: &str, module: &[String], all: &BTreeSet<Name>) -> Option<Name> {
    let child = [module, &path[..1]].concat();
    Some(match path[0].as_str() {
        "crate" => by_wings(of, &path[1..]),
        name if CRATES.iter().any(|(known, _)| *known == name) => by_wings(name, &path[1..]),
        "self" => [module, &path[1..]].concat(),
        "super" => {
            let up = path.iter().take_while(|part| *part == "super").count();
            [&module[..module.len() - up], &path[up..]].concat()
        }
        _ if all.contains(&child) => [module, path].concat(),
        _ => return None,
    })
}

fn read() -> Modules {
    let mut sources = Sources::new();
    for (of, folder) in CRATES {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
        files(of, &root, &root, &mut sources);
    }
    let names: BTreeSet<Name> = sources.keys().cloned().collect();
    let module = |(name, (of, file, text)): (Name, (&'static str, String, String))| {
        let words = tokens(&text);
        let mut module = Module { file, uses: vec![], passes_on: vec![], words: words.clone() };
        let mut at = 0;
        while at + 2 < words.len() {
            let is_use = words[at] == "use";
            // `pub(in path)` imports nothing.
            let scope = at > 1 && words[at - 1] == "in" && words[at - 2] == "(";
            let starts = is_use || (words[at + 1] == "::" && !scope && (at == 0 || words[at - 1] != "::"));
            if !starts {
                at += 1;
                continue;
            }
            let mut found = vec![];
            let public = is_use && at > 0 && (words[at - 1] == "pub" || words[at - 1] == ")");
            at = paths(&words, at + usize::from(is_use), &[], &mut found);
            for (short, path) in found {
                match absolute(&path, of, &name, &names) {
                    Some(path) if public => module.passes_on.push((short, path)),
                    Some(path) => module.uses.push(path),
                    None => {}
                }
            }
        }
        (name, module)
    };
    sources.into_iter().map(module).collect()
}

/// Returns the modules whose files define the item at `path`.
fn defined(modules: &Modules, path: &[String], depth: usize) -> BTreeSet<Name> {
    let inner = (0..=path.len()).rev().find(|length| modules.contains_key(&path[..*length])).unwrap();
    let (name, rest) = path.split_at(inner);
    let passed_on = |(short, from): &&(String, Name)| {
        from.as_slice() != path && (rest.is_empty() || rest[0] == "*" || rest[0] == *short || short == "*")
    };
    let found: Vec<_> = modules[name].passes_on.iter().filter(passed_on).collect();
    let further = found.iter().filter(|_| depth > 0).flat_map(|(_, from)| defined(modules, from, depth - 1));
    let mut all: BTreeSet<Name> = further.collect();
    if found.is_empty() || rest.is_empty() {
        all.insert(name.to_vec());
    }
    all
}

/// Returns the arrows from each module to the modules whose files it imports. A re-export counts if
/// its module uses the name once more.
fn arrows(modules: &Modules) -> BTreeMap<&Name, BTreeSet<Name>> {
    let of = |(name, module): (&'_ Name, &Module)| {
        let own = module
            .passes_on
            .iter()
            .filter(|(short, _)| module.words.iter().filter(|word| *word == short).count() > 1);
        let paths = module.uses.iter().chain(own.map(|(_, path)| path));
        paths.flat_map(|path| defined(modules, path, 9)).filter(|to| to != name && !to.is_empty()).collect()
    };
    modules.iter().map(|entry| (entry.0, of(entry))).collect()
}

/// Returns the table of DESIGN.md with the permitted imports of each wing.
fn law() -> BTreeMap<String, BTreeSet<String>> {
    let design = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../DESIGN.md")).unwrap();
    let section = design.split("### What may import what?").nth(1).unwrap().split("\n#").next().unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    let names =
        |cell: &str| -> Vec<String> { cell.split('`').skip(1).step_by(2).map(String::from).collect() };
    rows.map(|row| row.split('|').collect::<Vec<_>>())
        .map(|cells| (names(cells[1])[0].clone(), names(cells[2]).into_iter().collect()))
        .collect()
}

#[test]
fn wings_import_only_what_the_table_of_the_design_allows() {
    let (modules, law) = (read(), law());
    for (name, module) in modules.iter().filter(|(name, _)| !name.is_empty()) {
        let allowed =
            law.get(&name[0]).unwrap_or_else(|| panic!("{} is of no wing in DESIGN.md", module.file));
        let paths = module.uses.iter().chain(module.passes_on.iter().map(|(_, path)| path));
        for path in paths.filter(|path| !path.is_empty() && modules.contains_key(&path[..1])) {
            let holds = path[0] == name[0] || allowed.contains(&path[0]);
            assert!(holds, "{} imports {}, which DESIGN.md does not allow", module.file, path.join("::"));
        }
    }
    for wing in law.keys() {
        assert!(
            modules.contains_key(std::slice::from_ref(wing)),
            "{wing} is in the table of DESIGN.md, not in src"
        );
    }
}

/// No circle exists, neither directly nor through other files. A module and the modules inside it
/// may import each other: a module defines the items that its folder shares.
#[test]
fn no_files_import_each_other_in_a_circle() {
    let modules = read();
    let arrows = arrows(&modules);
    let onward = |from: &Name| -> Vec<&Name> {
        let apart = |to: &&Name| !to.starts_with(from) && !from.starts_with(to);
        arrows[from].iter().filter(apart).collect()
    };
    for start in modules.keys() {
        let mut ways: BTreeMap<&Name, String> = BTreeMap::from([(start, modules[start].file.clone())]);
        let mut open = vec![start];
        while let Some(name) = open.pop() {
            for to in onward(name) {
                let way = format!("{} → {}", ways[name], modules[to].file);
                assert!(to != start, "a circle: {way}");
                if !ways.contains_key(to) {
                    ways.insert(to, way);
                    open.push(to);
                }
            }
        }
    }
}

/// The witnesses do not share the solver, the sweeps or the form of the implicit equation with the
/// planner.
#[test]
fn verify_reaches_nothing_of_the_optimiser_by_any_detour() {
    let modules = read();
    let arrows = arrows(&modules);
    let mut ways: BTreeMap<Name, String> = BTreeMap::new();
    let mut open: Vec<Name> =
        modules.keys().filter(|name| name.first().is_some_and(|wing| wing == "verify")).cloned().collect();
    open.iter().for_each(|name| drop(ways.insert(name.clone(), modules[name].file.clone())));
    while let Some(name) = open.pop() {
        for to in arrows[&name].iter() {
            if !ways.contains_key(to) {
                let way = format!("{} → {}", ways[&name], modules[to].file);
                let forbidden = to[0] == "optimize" || to.join("::") == "mechanics::drift_equation";
                assert!(!forbidden, "verify reaches it: {way}");
                ways.insert(to.clone(), way);
                open.push(to.clone());
            }
        }
    }
}

/// Types of the optimiser whose methods are still spread over files, a piece of the theory in each.
const SPREAD: [&str; 1] = ["Extremal"];

/// Returns the types to which a file gives inherent methods, not methods of a trait.
fn types_with_methods(words: &[String]) -> BTreeSet<String> {
    let is_item = |at: usize| at == 0 || ["}", ";", "]", "{"].contains(&words[at - 1].as_str());
    let of_item = |at: usize| -> Option<String> {
        let (mut depth, mut name) = (0, None);
        for next in at + 1.. {
            match words[next].as_str() {
                "<" => depth += 1,
                ">" if words[next - 1] != "-" => depth -= 1,
                "for" if depth == 0 => return None,
                "{" | "where" => return name,
                word if depth == 0 && word.starts_with(char::is_uppercase) => {
                    name = name.or(Some(word.into()))
                }
                _ => {}
            }
        }
        None
    };
    (0..words.len()).filter(|at| words[*at] == "impl" && is_item(*at)).filter_map(of_item).collect()
}

/// The abilities of a type, and the functions that may write to it, stand in one file, or in the
/// folder of the module that defines it.
#[test]
fn a_type_of_the_optimiser_has_its_methods_in_one_place() {
    let modules = read();
    let is_defined = |name: &Name, of: &str| {
        let kinds = ["struct", "enum"];
        modules[name].words.windows(2).any(|pair| kinds.contains(&pair[0].as_str()) && pair[1] == of)
    };
    let owner = |name: &Name, of: &str| -> Name {
        let used = modules[name].uses.iter().filter(|path| path.last().is_some_and(|last| last == of));
        let places = used.flat_map(|path| defined(&modules, path, 9));
        [name.clone()].into_iter().chain(places).find(|place| is_defined(place, of)).unwrap_or(name.clone())
    };
    let mut files: BTreeMap<(Name, String), Vec<&str>> = BTreeMap::new();
    for (name, module) in
        modules.iter().filter(|(name, _)| name.first().is_some_and(|wing| wing == "optimize"))
    {
        for of in types_with_methods(&module.words) {
            let owner = owner(name, &of);
            let place = if name.starts_with(&owner) { &modules[&owner].file } else { &module.file };
            let places: &mut Vec<&str> = files.entry((owner, of)).or_default();
            if !places.contains(&place.as_str()) {
                places.push(place);
            }
        }
    }
    assert!(files.len() > 50, "{files:?}");
    let spread: Vec<_> = files.iter().filter(|(_, files)| files.len() > 1).collect();
    for ((_, of), files) in &spread {
        assert!(SPREAD.contains(&of.as_str()), "{of} has methods in several files: {files:?}");
    }
    for of in SPREAD {
        assert!(
            spread.iter().any(|((_, spread), _)| spread == of),
            "{of} has its methods in one file: leave it out"
        );
    }
}

/// Returns the names that the documentation of a file shows as its own: declared or passed on in
/// public, and not hidden.
fn shown(file: &str) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    let tokens = tokens(&fs::read_to_string(path).unwrap());
    let (mut names, mut hidden) = (vec![], false);
    for (at, token) in tokens.iter().enumerate() {
        match token.as_str() {
            "hidden" if at > 1 && tokens[at - 2] == "doc" => hidden = true,
            ";" | "}" => hidden = false,
            "pub" if hidden || tokens[at + 1] == "(" => {}
            "pub" if tokens[at + 1] == "use" => {
                let mut found = vec![];
                paths(&tokens, at + 2, &[], &mut found);
                names.extend(found.into_iter().map(|(name, _)| name));
            }
            "pub" => names.push(tokens[at + 2].clone()),
            _ => {}
        }
    }
    names
}

/// All modules except `lie` are hidden, so that a name has one path; the functions of `lie` count
/// as well.
#[test]
fn the_facade_is_small_and_has_each_name_once() {
    let [root, lie] = ["src/lib.rs", "src/lie/mod.rs"].map(shown);
    let all: Vec<&String> = root.iter().chain(&lie).collect();
    for expected in ["Problem", "plan", "Environment", "Vector3", "lie", "exp"] {
        assert!(all.iter().any(|name| *name == expected), "{expected} is not shown: {all:?}");
    }
    assert!(all.len() <= 60, "{} names: {all:?}", all.len());
    let mut once = BTreeSet::new();
    assert!(all.iter().all(|name| **name != "*" && once.insert(*name)), "a name twice, or a glob: {all:?}");
    let modules = ["maneuver", "mechanics", "numerics", "optimize", "propagate"];
    assert!(
        modules.iter().all(|module| !root.iter().any(|name| name == module)),
        "a module is shown: {root:?}"
    );
}

/// Every file of the crates is searched for doc comments and the items below them, except for the
/// files of the optimiser, whose items are its own.
#[test]
fn what_is_public_is_described_by_its_own_subject() {
    let mut sources = Sources::new();
    for (of, folder) in CRATES {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
        files(of, &root, &root, &mut sources);
    }
    let mut described = 0;
    for (name, (_, file, text)) in &sources {
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        let in_comment = |at: usize| lines.get(at).is_some_and(|line| line.starts_with("///"));
        for first in (0..lines.len()).filter(|at| in_comment(*at) && (*at == 0 || !in_comment(at - 1))) {
            let below = |line: &&&str| !line.starts_with("///") && !line.starts_with("#[");
            let item = lines[first..].iter().find(below).copied().unwrap_or_default();
            let is_variant = item.starts_with(|sign: char| sign.is_uppercase());
            if item.starts_with("pub ") || is_variant {
                described += 1;
                let borrowed = lines[first].starts_with("/// The same") && name[0] != "optimize";
                assert!(!borrowed, "{file}:{}: {}", first + 1, lines[first]);
            }
        }
    }
    assert!(described > 1000, "{described}");
}
