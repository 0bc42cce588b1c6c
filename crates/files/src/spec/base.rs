//! A spec on which many cases are based.

use super::paths::{self, Place};
use super::shape::open;
use super::{
    Diagnostic, Diagnostics, Finding, Format, Node, Origin, Override, Source, Spec, Spot, Value, Wanted,
    diagnostics, folder_of, overrides, parse, text, typed, understand,
};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The spec of a maneuver or a sequence that is parsed once and read many times, with different
/// overrides each time.
#[derive(Clone, Debug)]
pub struct Base {
    name: String,
    folder: PathBuf,
    sources: Vec<Source>,
    root: Node,
    /// Contents of the files that the spec refers to.
    beside: Vec<String>,
}

impl Base {
    /// Parses the spec at `path`, with overrides that apply to all cases.
    ///
    /// # Errors
    /// Returns the errors of the file and its notation; [`Base::read`] checks the values of the
    /// keys.
    pub fn open(path: &Path, format: Format, overrides: &[Override]) -> Result<Self, Diagnostics> {
        let name = path.display().to_string();
        let bytes = text::from_file(path, &name)?;
        Self::new(text::decode(&bytes, &name)?, &name, folder_of(path), format, overrides)
    }

    /// Parses the spec from a stream such as standard input; `name` is its name in messages.
    ///
    /// # Errors
    /// Returns the errors of [`Base::open`].
    pub fn from_reader(
        reader: impl Read,
        name: &str,
        format: Format,
        overrides: &[Override],
    ) -> Result<Self, Diagnostics> {
        let bytes = text::from_stream(reader, name, None)?;
        Self::new(text::decode(&bytes, name)?, name, Path::new(""), format, overrides)
    }

    fn new(
        text: &str,
        name: &str,
        folder: &Path,
        format: Format,
        overrides: &[Override],
    ) -> Result<Self, Diagnostics> {
        let mut sources = vec![Source::new(name, text)];
        let root = parse(&sources[0], format).map_err(|findings| diagnostics(findings, &sources))?;
        let (root, findings) = overrides::apply(root, overrides, &mut sources);
        if !findings.is_empty() {
            return Err(diagnostics(findings, &sources));
        }
        let mut beside = Vec::new();
        read_beside(&root, folder, &mut beside);
        Ok(Self { name: name.into(), folder: folder.into(), sources, root, beside })
    }

    /// Returns the path of the spec as the user wrote it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns all texts on which the base depends: the spec, the overrides as written, and the
    /// contents of the orbit and attitude files to which the spec refers.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        let own = self.sources.iter().map(|source| source.text.as_str());
        own.chain(self.beside.iter().map(String::as_str))
    }

    /// Returns the paths of the files that the spec refers to; no output may replace them.
    pub fn files(&self) -> Vec<PathBuf> {
        files_named(&self.root, &self.folder)
    }

    /// Builds the maneuver or the sequence with further overrides.
    ///
    /// # Errors
    /// Returns all errors of the spec. If the spec is a simulation, this is an error.
    pub fn read(&self, overrides: &[Override]) -> Result<Spec, Diagnostics> {
        let mut sources = self.sources.clone();
        let (root, findings) = overrides::apply(self.root.clone(), overrides, &mut sources);
        understand(&root, findings, &sources, &self.name, &self.folder, Wanted::Planned)
    }

    /// Returns the base without `[dispersion]`, which the individual cases do not need.
    pub fn without_dispersion(mut self) -> Self {
        if let Value::Table(entries) = &mut self.root.value {
            entries.retain(|entry| entry.key != "dispersion");
        }
        self
    }

    /// Checks that specs can have the key `path`. `at` is the position at which the path is
    /// written; `None` means the command line.
    ///
    /// # Errors
    /// Returns an error that names the most similar key, if the key does not exist.
    pub fn check_key(&self, path: &str, at: Option<&Origin>) -> Result<(), Diagnostics> {
        self.key(path).map(drop).map_err(|(code, reason, remedy)| {
            let here = Origin { file: "command line".into(), line: 1, column: 1 };
            let found = Diagnostic::in_text(code, at.unwrap_or(&here), path, reason, &remedy);
            Diagnostics(vec![found])
        })
    }

    fn key(&self, path: &str) -> Result<Place, (&'static str, String, String)> {
        paths::place(&self.root, path)
    }

    /// Checks the type, shape and range of a value, independent of other keys. Contradictions
    /// between keys are reported when the case is read.
    ///
    /// # Errors
    /// Returns an error if the key does not exist, or if it cannot have this value.
    pub fn check_value(&self, given: &Override) -> Result<(), Diagnostics> {
        let key = match self.key(given.path()) {
            Ok(Place::Key(key)) => key,
            Ok(Place::Element) => return Ok(()),
            Err(_) => return self.check_key(given.path(), None),
        };
        let (source, _, value_at) = given.source();
        let finding = |(code, span, reason, remedy)| {
            Finding::error_at(code, Spot { span, key: given.path().into() }, reason, remedy)
        };
        let faults = paths::faults(key, &typed(given.value(), 0, value_at));
        let findings: Vec<Finding> = faults.into_iter().map(finding).collect();
        if findings.is_empty() { Ok(()) } else { Err(diagnostics(findings, &[source])) }
    }
}

/// Reads the contents of the orbit and attitude files to which a tree refers. A file that cannot be
/// read is skipped, because every case reports it.
fn read_beside(node: &Node, folder: &Path, found: &mut Vec<String>) {
    match &node.value {
        Value::Table(entries) => {
            for entry in entries {
                match &entry.node.value {
                    Value::Text(written) if NAMING.contains(&entry.key.as_str()) => {
                        let opened = open(written, folder, "a file").ok();
                        let text = opened.and_then(|(_, file)| std::io::read_to_string(file.take(MOST)).ok());
                        found.extend(text);
                    }
                    _ => read_beside(&entry.node, folder, found),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| read_beside(item, folder, found)),
        _ => {}
    }
}

/// Returns the paths of the orbit and attitude files to which a tree refers.
pub(super) fn files_named(node: &Node, folder: &Path) -> Vec<PathBuf> {
    match &node.value {
        Value::Table(entries) => entries
            .iter()
            .flat_map(|entry| match &entry.node.value {
                Value::Text(written) if NAMING.contains(&entry.key.as_str()) => vec![folder.join(written)],
                _ => files_named(&entry.node, folder),
            })
            .collect(),
        Value::Array(items) => items.iter().flat_map(|item| files_named(item, folder)).collect(),
        _ => Vec::new(),
    }
}

/// Keys whose value is the name of an orbit or attitude file.
const NAMING: [&str; 3] = ["oem", "omm", "file"];
/// Largest number of bytes that are read from a file. It equals the limit of the reader of orbits.
const MOST: u64 = 1 << 28;
