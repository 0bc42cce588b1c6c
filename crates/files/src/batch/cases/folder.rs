//! A folder of specs as a source of cases: each file is one case.

use super::{Fingerprint, MAX_CASES};
use crate::batch::error::shown;
use crate::batch::{BatchError, Case};
use crate::spec::{Base, Format, MAX_BYTES};
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

/// A folder of specs, with the file names of the specs in byte order.
#[derive(Debug)]
pub(super) struct Folder {
    path: PathBuf,
    names: Vec<String>,
    /// Paths of the files that the specs refer to.
    beside: Vec<PathBuf>,
}

impl Folder {
    /// Opens the folder `path` and finds its files that end in `.toml` or `.json`, in the byte
    /// order of their names. Returns the folder, and the hash `fingerprint` continued by the names
    /// and contents of the specs and of the orbit files to which the specs refer.
    pub fn open(path: &Path, mut fingerprint: Fingerprint) -> Result<(Self, Fingerprint), BatchError> {
        let unreadable = |error| BatchError::unreadable(path, &error);
        let mut names = Vec::new();
        for entry in fs::read_dir(path).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            let file = entry.path();
            let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
            if !matches!(ending.as_deref(), Some("toml" | "json")) || file.is_dir() {
                continue;
            }
            match entry.file_name().into_string() {
                Ok(name) => names.push(name),
                Err(_) => {
                    let reason = format!("{}: the name is not UTF-8", shown(&file));
                    return Err(BatchError::file("E0116", reason, "rename the file"));
                }
            }
        }
        if names.is_empty() {
            let reason = format!("{}: the folder holds no spec", shown(path));
            return Err(BatchError::file("E0116", reason, "give a folder of .toml or .json files"));
        }
        if names.len() as u64 > MAX_CASES {
            let reason = format!("{}: {} specs, the limit is {MAX_CASES}", shown(path), names.len());
            return Err(BatchError::file("E0034", reason, "use several folders"));
        }
        names.sort_unstable();
        let mut beside = Vec::new();
        for name in &names {
            let file = path.join(name);
            let mut content = Vec::new();
            // A file that is too long or unreadable is reported as the result of its case.
            if let Ok(input) = File::open(&file) {
                let _ = input.take(MAX_BYTES as u64 + 1).read_to_end(&mut content);
            }
            fingerprint = fingerprint.and(name.as_bytes()).and(&content);
            // An error of a spec is also reported as the result of its case.
            if let Ok(base) = Base::open(&file, Format::of(&file), &[]) {
                fingerprint =
                    base.texts().skip(1).fold(fingerprint, |found, text| found.and(text.as_bytes()));
                beside.extend(base.files());
            }
        }
        Ok((Self { path: path.into(), names, beside }, fingerprint))
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the paths of the files that the specs refer to.
    pub fn beside(&self) -> &[PathBuf] {
        &self.beside
    }

    pub fn count(&self) -> u64 {
        self.names.len() as u64
    }

    /// Returns the case with the number `number`, counted from 1, which must not exceed the number
    /// of specs.
    pub fn case(&self, number: u64) -> Case {
        let name = self.names[number as usize - 1].clone();
        Case { number, spec: Some(self.path.join(&name)), name: Some(name), set: Vec::new() }
    }
}
