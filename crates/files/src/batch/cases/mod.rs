//! Sources of cases: a table, a folder, a grid or random draws. Each case has a number, an optional
//! name and the keys that it sets.

mod draws;
mod folder;
mod grid;
mod rows;
mod table;

pub use grid::Axis;

use super::{BatchError, Case, Header, Kind, Shard};
use crate::fingerprint::Fingerprint;
use crate::spec::{Base, Diagnostics, Format, MOST_CASES, Override, Spec, escape, read_planned};
use draws::Draws;
use folder::Folder;
use grid::Grid;
use std::path::{Path, PathBuf};
use table::Table;

/// Largest number of cases of one batch. It bounds the memory, because the summary stores several
/// bytes for each case.
pub const MAX_CASES: u64 = MOST_CASES as u64;

/// A source of cases, which determines their number and order.
#[derive(Debug)]
enum Source {
    Table(Table),
    Folder(Folder),
    Grid(Grid),
    Draws(Draws),
}

/// A batch: a base spec with the cases that change it, or a folder of specs.
#[derive(Debug)]
pub struct Batch {
    base: Option<Base>,
    /// Keys that are set in every case of a folder, in addition to the spec of the case.
    overrides: Vec<Override>,
    source: Source,
    /// Header of the file of results of the whole batch, without a shard.
    header: Header,
}

/// Iterator over cases in increasing order of their numbers.
pub type Stream<'a> = Box<dyn Iterator<Item = Result<Case, BatchError>> + Send + 'a>;

impl Batch {
    /// Creates a batch with one case for each row of the comma-separated table at `path`. The
    /// header of the table has dotted keys of the spec. A column `name` gives the names of the
    /// cases. An empty cell leaves the key at its value in the spec.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, if a key does not exist in a spec, or if a row,
    /// a value or a name is invalid; the position in the table is stated.
    pub fn of_table(base: Base, path: &Path) -> Result<Self, BatchError> {
        let (table, cases, fingerprint) = Table::open(path, &base, of_base(&base))?;
        let keys = table.keys();
        Self::new(Some(base), Vec::new(), Source::Table(table), Kind::Table, cases, keys, fingerprint)
    }

    /// Creates a batch with one case for each spec in the folder at `path`, in the order of their
    /// names. `overrides` are set in every case.
    ///
    /// # Errors
    /// Returns an error if the folder or one of its files cannot be read.
    pub fn of_folder(path: &Path, overrides: Vec<Override>) -> Result<Self, BatchError> {
        let set = overrides.iter().flat_map(|set| [set.path(), set.value()]);
        let begun = set.fold(Fingerprint::of_program(), |found, text| found.and(text.as_bytes()));
        let (folder, fingerprint) = Folder::open(path, begun)?;
        let cases = folder.count();
        Self::new(None, overrides, Source::Folder(folder), Kind::Folder, cases, vec![], fingerprint)
    }

    /// Creates a batch with one case for each point of a grid. The first axis changes slowest, the
    /// last axis fastest.
    ///
    /// # Errors
    /// Returns an error if a key is unknown, if a value is invalid, or if the grid has too many
    /// points.
    pub fn of_grid(base: Base, axes: Vec<Axis>) -> Result<Self, BatchError> {
        let grid = Grid::new(axes, &base)?;
        let keys = grid.keys();
        let texts = grid.texts().fold(of_base(&base), |found, text| found.and(text.as_bytes()));
        let cases = grid.count();
        Self::new(Some(base), Vec::new(), Source::Grid(grid), Kind::Sweep, cases, keys, texts)
    }

    /// Creates a batch with one case for each draw of the `[dispersion]` of the spec.
    ///
    /// # Errors
    /// Returns an error if the spec or its dispersion is invalid.
    pub fn of_dispersion(base: Base) -> Result<Self, BatchError> {
        let maneuver = base.read(&[])?.maneuver();
        let Some(dispersion) = maneuver.and_then(|loaded| loaded.dispersion) else {
            let reason = format!("{}: the spec has no [dispersion]", escape(base.name()));
            let remedy =
                "add [dispersion] with seed, cases and [[dispersion.vary]], as `slew help monte-carlo` shows";
            return Err(BatchError::argument("E0160", reason, remedy));
        };
        let (fingerprint, cases, draws) = (of_base(&base), dispersion.cases, Draws(dispersion));
        let (base, keys) = (base.without_dispersion(), draws.keys());
        Self::new(Some(base), Vec::new(), Source::Draws(draws), Kind::MonteCarlo, cases, keys, fingerprint)
    }

    fn new(
        base: Option<Base>,
        overrides: Vec<Override>,
        source: Source,
        kind: Kind,
        cases: u64,
        keys: Vec<String>,
        fingerprint: Fingerprint,
    ) -> Result<Self, BatchError> {
        let path = match (&base, &source) {
            (Some(base), _) => Path::new(base.name()),
            (None, Source::Folder(folder)) => folder.path(),
            (None, _) => Path::new(""),
        };
        let spec =
            path.file_name().map_or(path.to_string_lossy(), |name| name.to_string_lossy()).into_owned();
        let header = Header {
            slew_results: Header::FORMAT,
            generator: concat!("slewkit ", env!("CARGO_PKG_VERSION")).into(),
            kind,
            spec,
            cases,
            keys,
            fingerprint: fingerprint.text(),
            times: false,
            shard: None,
        };
        Ok(Self { base, overrides, source, header })
    }

    /// Returns the paths of the files that the specs of the cases refer to; no output may replace
    /// them.
    pub fn files(&self) -> Vec<PathBuf> {
        match (&self.base, &self.source) {
            (Some(base), _) => base.files(),
            (None, Source::Folder(folder)) => folder.beside().to_vec(),
            (None, _) => Vec::new(),
        }
    }

    /// Returns the number of cases of the whole batch.
    pub fn count(&self) -> u64 {
        self.header.cases
    }

    /// Returns the header for the file of results of `shard`; `times` is true if the result lines
    /// hold wall times.
    pub fn header(&self, shard: Shard, times: bool) -> Header {
        Header { shard: (shard != Shard::ALL).then_some(shard), times, ..self.header.clone() }
    }

    /// Returns the cases of `shard` in order, skipping the first `done` cases.
    ///
    /// # Errors
    /// Returns an error if the table cannot be read again.
    pub fn stream(&self, shard: Shard, done: u64) -> Result<Stream<'_>, BatchError> {
        let left = (done..shard.count(self.count())).map(move |place| shard.case(place));
        Ok(match &self.source {
            Source::Grid(grid) => Box::new(left.map(|number| Ok(grid.case(number)))),
            Source::Draws(draws) => Box::new(left.map(|number| draws.case(number))),
            Source::Folder(folder) => Box::new(left.map(|number| Ok(folder.case(number)))),
            Source::Table(table) => {
                let first = shard.case(done);
                let wanted = move |case: &Result<Case, BatchError>| {
                    case.as_ref().map_or(true, |case| case.number >= first && shard.has(case.number))
                };
                Box::new(table.cases()?.filter(wanted))
            }
        })
    }

    /// Returns the case with the number `number`, counted from 1.
    ///
    /// # Errors
    /// Returns an error if the batch has no case with this number.
    pub fn case(&self, number: u64) -> Result<Case, BatchError> {
        let none = || {
            let reason = format!("--case: case {number} does not exist");
            BatchError::argument("E0111", reason, format!("cases are numbered from 1 to {}", self.count()))
        };
        if number == 0 || number > self.count() {
            return Err(none());
        }
        self.stream(Shard::ALL, number - 1)?.next().unwrap_or_else(|| Err(none()))
    }

    /// Reads the spec of a case after setting the keys of the case.
    ///
    /// # Errors
    /// Returns all errors of the spec of the case.
    pub fn read(&self, case: &Case) -> Result<Spec, Diagnostics> {
        match (&self.base, &case.spec) {
            (Some(base), None) => base.read(&case.set),
            (_, Some(path)) => read_planned(path, Format::of(path), &self.overrides),
            // Unreachable: a batch has a base spec, or a spec for each case.
            (None, None) => Err(Diagnostics(Vec::new())),
        }
    }
}

fn of_base(base: &Base) -> Fingerprint {
    base.texts().fold(Fingerprint::of_program(), |found, text| found.and(text.as_bytes()))
}

/// Checks that no key occurs twice in the list, and that no key is nested in another key of the
/// list.
fn check_distinct(keys: &[String], what: &str) -> Result<(), BatchError> {
    for (index, key) in keys.iter().enumerate() {
        let inside = |other: &&String| **other == *key || other.starts_with(&format!("{key}."));
        let mut others = keys[..index].iter().chain(&keys[index + 1..]);
        if let Some(other) = others.find(inside) {
            let reason = if other == key {
                format!("{what}: `{key}` is set twice")
            } else {
                format!("{what}: `{key}` also sets `{other}`, which is set separately")
            };
            return Err(BatchError::argument("E0011", reason, "set each key once"));
        }
    }
    Ok(())
}
