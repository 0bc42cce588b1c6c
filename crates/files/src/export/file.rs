//! Output files that are either complete or absent.

use super::ExportError;
use crate::spec::escape;
use std::fs;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use tempfile::NamedTempFile;
use thiserror::Error;

/// Reason why an output file was rejected or could not be written. A partly written file is always
/// removed.
#[derive(Debug, Error)]
pub enum FileError {
    /// The folder of the output does not exist.
    #[error("the folder {folder} of the output {path} does not exist")]
    FolderMissing {
        /// Path of the folder.
        folder: String,
        /// Path of the output, as the user wrote it.
        path: String,
    },
    /// The path of the folder of the output leads to a file.
    #[error("{folder}, the folder of the output {path}, is a file")]
    FolderIsFile {
        /// Path of the folder.
        folder: String,
        /// Path of the output, as the user wrote it.
        path: String,
    },
    /// No file can be created in the folder.
    #[error("cannot create a file in {folder}: {reason}")]
    NotWritable {
        /// Path of the folder.
        folder: String,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// Writing failed before the end of the file, usually because the disk is full.
    #[error("writing {path} failed, no part is kept: {reason}")]
    Write {
        /// Path of the output, as the user wrote it.
        path: String,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// The output file exists already.
    #[error("{path} exists")]
    Exists {
        /// Path of the output, as the user wrote it.
        path: String,
    },
    /// The output file exists and is write-protected.
    #[error("{path} is write-protected")]
    Protected {
        /// Path of the output, as the user wrote it.
        path: String,
    },
    /// The name cannot be used for an output file.
    #[error("{path} cannot be an output file: {reason}")]
    Name {
        /// Path of the output, converted to text.
        path: String,
        /// Reason why the name is not accepted.
        reason: &'static str,
    },
    /// The output would replace an input file.
    #[error("the output {path} is also an input")]
    IsInput {
        /// Path of the output, as the user wrote it.
        path: String,
    },
}

impl FileError {
    /// Returns the stable code of the error.
    pub fn code(&self) -> &'static str {
        match self {
            Self::FolderMissing { .. } | Self::FolderIsFile { .. } => "E0095",
            Self::NotWritable { .. } | Self::Protected { .. } => "E0096",
            Self::Write { .. } => "E0097",
            Self::Exists { .. } => "E0098",
            Self::Name { .. } => "E0099",
            Self::IsInput { .. } => "E0100",
        }
    }

    /// Returns the remedy for the error.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::FolderMissing { .. } => "create it first",
            Self::FolderIsFile { .. } => "choose another folder",
            Self::NotWritable { .. } => "choose another folder, or change its permissions",
            Self::Write { .. } => "free some space, or choose another folder",
            Self::Protected { .. } => "choose another name, or change the permissions",
            Self::Exists { .. } => "give `--force` to replace it",
            Self::Name { .. } | Self::IsInput { .. } => "choose another name",
        }
    }
}

/// Checks that an output file or folder is not the input `input`. Symbolic links and different
/// notations of the same path are recognised.
///
/// # Errors
/// Returns [`FileError::IsInput`] if the paths lead to the same file.
pub fn distinct(output: &Path, input: &Path) -> Result<(), FileError> {
    match (fs::canonicalize(output), fs::canonicalize(input)) {
        (Ok(found), Ok(input)) if found == input => Err(FileError::IsInput { path: shown(output) }),
        _ => Ok(()),
    }
}

/// An output file. Its path is checked before the work begins; the file is written after the work.
#[derive(Clone, Debug)]
pub struct Target {
    path: PathBuf,
    folder: PathBuf,
    force: bool,
}

impl Target {
    /// Checks the name, the folder and the existence of the file. If `force` is true, an existing
    /// regular file may be replaced unless it is write-protected. If the path is a symbolic link to
    /// a file, this file is replaced and the link is kept.
    ///
    /// # Errors
    /// Returns a [`FileError`] if the output cannot be written to this path.
    pub fn new(path: impl Into<PathBuf>, force: bool) -> Result<Self, FileError> {
        let mut path = path.into();
        let shown = shown(&path);
        if let Some(reason) = unusable_name(&path) {
            return Err(FileError::Name { path: shown, reason });
        }
        let mut folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
            _ => PathBuf::from("."),
        };
        if folder.exists() && !folder.is_dir() {
            return Err(FileError::FolderIsFile { folder: self::shown(&folder), path: shown });
        }
        if !folder.is_dir() {
            return Err(FileError::FolderMissing { folder: self::shown(&folder), path: shown });
        }
        // A dangling symbolic link also occupies the name, so `exists()` does not suffice.
        if let Ok(metadata) = fs::symlink_metadata(&path) {
            let regular = fs::metadata(&path).map_or(metadata.is_symlink(), |target| target.is_file());
            if !regular {
                let reason = "a folder, device or pipe has this name";
                return Err(FileError::Name { path: shown, reason });
            }
            // Errors that `--force` does not avoid are reported first.
            if metadata.is_symlink() {
                path = fs::canonicalize(&path).map_err(|_| FileError::Name {
                    path: shown.clone(),
                    reason: "it is a symbolic link to a missing file",
                })?;
                folder = path.parent().map_or(folder, Path::to_path_buf);
            }
            if fs::metadata(&path).is_ok_and(|metadata| metadata.permissions().readonly()) {
                return Err(FileError::Protected { path: shown });
            }
            if !force {
                return Err(FileError::Exists { path: shown });
            }
        }
        // Many causes may prevent a new file in a folder, so a file is created as a test.
        let refused = |reason| FileError::NotWritable { folder: self::shown(&folder), reason };
        let (_listed, temporary) = temporary_in(&folder).map_err(refused)?;
        drop(temporary);
        Ok(Self { path, folder, force })
    }

    /// Returns the path of the output as the user wrote it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Checks that the output is not the file `input`. Symbolic links and different notations of
    /// the same path are recognised.
    ///
    /// # Errors
    /// Returns [`FileError::IsInput`] if the paths lead to the same file.
    pub fn distinct_from(&self, input: &Path) -> Result<(), FileError> {
        distinct(&self.path, input)
    }

    /// Writes the output to a temporary file in the same folder, flushes it to the disk, and
    /// renames it.
    ///
    /// # Errors
    /// Returns the error of `content`, or a [`FileError`]; no new file then remains in the folder.
    pub fn write(
        &self,
        content: impl FnOnce(&mut dyn Write) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        let create = |reason| FileError::NotWritable { folder: shown(&self.folder), reason };
        let write = |reason| FileError::Write { path: shown(&self.path), reason };
        sweep(&self.folder);
        let (_listed, mut temporary) = temporary_in(&self.folder).map_err(create)?;
        let mut buffer = BufWriter::new(temporary.as_file_mut());
        content(&mut buffer).map_err(|error| match error {
            ExportError::Io(reason) => write(reason).into(),
            other => other,
        })?;
        buffer.flush().map_err(write)?;
        drop(buffer);
        if let Ok(old) = fs::metadata(&self.path) {
            temporary.as_file().set_permissions(old.permissions()).map_err(write)?;
        }
        temporary.as_file().sync_all().map_err(write)?;
        let renamed = if self.force {
            temporary.persist(&self.path)
        } else {
            // This call also fails if another process has created the file in the meantime.
            temporary.persist_noclobber(&self.path)
        };
        renamed.map_err(|error| match error.error.kind() {
            ErrorKind::AlreadyExists => FileError::Exists { path: shown(&self.path) },
            _ => write(error.error),
        })?;
        // The folder is flushed, so that the new name is stored on the disk. Some systems do not
        // support this; the contents of the file are on the disk in any case.
        if let Ok(folder) = fs::File::open(&self.folder) {
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

/// Prefix of the names of temporary files; random letters and digits follow it.
const PREFIX: &str = ".slew-";
const RANDOM: usize = 6;

/// Creates a temporary file. Its path is in the list `TEMPORARY` until the file is renamed or
/// removed.
fn temporary_in(folder: &Path) -> std::io::Result<(Listed<'static>, NamedTempFile)> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).rand_bytes(RANDOM);
    #[cfg(unix)]
    {
        // The file gets the default permissions of the system. The default of the crate would make
        // it unreadable for other users.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    Listed::new(&TEMPORARY, || builder.tempfile_in(folder))
}

/// Age after which a temporary file counts as abandoned; writing a file takes far less time.
const ABANDONED: Duration = Duration::from_secs(86_400);

/// Removes the temporary files in `folder` that killed programs have left behind.
fn sweep(folder: &Path) {
    let is_ours = |name: &str| {
        let random = name.strip_prefix(PREFIX).filter(|random| random.len() == RANDOM);
        random.is_some_and(|random| random.bytes().all(|byte| byte.is_ascii_alphanumeric()))
    };
    // A file that cannot be listed or removed is left, which is harmless.
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let old = |metadata: fs::Metadata| {
            let age = metadata.modified().ok().and_then(|modified| modified.elapsed().ok());
            metadata.is_file() && age.is_some_and(|age| age > ABANDONED)
        };
        if entry.file_name().to_str().is_some_and(is_ours) && entry.metadata().is_ok_and(old) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// A list of file paths that is shared by all threads.
type List = Mutex<Vec<PathBuf>>;

/// Paths of the temporary files of this process.
static TEMPORARY: List = Mutex::new(Vec::new());

/// Removes the temporary files of all outputs that are being written, and prevents new temporary
/// files. The program must end immediately afterwards, without unwinding: a second call, or any
/// further output, blocks forever.
pub fn remove_temporaries() {
    remove_all(&TEMPORARY);
}

fn remove_all(list: &List) {
    let listed = list.lock().unwrap_or_else(PoisonError::into_inner);
    for path in listed.iter() {
        // The file may already have been removed.
        let _ = fs::remove_file(path);
    }
    // The lock is never released, because another thread could still create a file before the
    // program ends.
    std::mem::forget(listed);
}

/// A path that is in the list of temporary files as long as this value exists.
struct Listed<'a> {
    path: PathBuf,
    list: &'a List,
}

impl<'a> Listed<'a> {
    /// Creates a file and adds its path to the list while the list is locked.
    fn new(
        list: &'a List,
        make: impl FnOnce() -> std::io::Result<NamedTempFile>,
    ) -> std::io::Result<(Self, NamedTempFile)> {
        let mut listed = list.lock().unwrap_or_else(PoisonError::into_inner);
        let file = make()?;
        let path = file.path().to_path_buf();
        listed.push(path.clone());
        Ok((Self { path, list }, file))
    }
}

impl Drop for Listed<'_> {
    fn drop(&mut self) {
        self.list.lock().unwrap_or_else(PoisonError::into_inner).retain(|path| *path != self.path);
    }
}

/// Returns the reason why `path` must not name an output file, on this system or on a system to
/// which the file may be copied; `None` if it is a valid name.
fn unusable_name(path: &Path) -> Option<&'static str> {
    let text = path.to_string_lossy();
    if text.is_empty() {
        return Some("it is empty");
    }
    if text.chars().any(char::is_control) {
        return Some("it holds control characters");
    }
    // Such a path may lead to an open file of another program, or to the stream for messages.
    if ["/dev/std", "/dev/fd/", "/proc/"].iter().any(|start| text.starts_with(start)) {
        return Some("it names a stream of a process, or a file of the system; `-o -` is stdout");
    }
    let Some(name) = path.file_name().filter(|_| !text.ends_with(['/', std::path::MAIN_SEPARATOR])) else {
        return Some("it names a folder");
    };
    let name = name.to_string_lossy();
    if name.len() > 255 {
        return Some("its name is longer than 255 bytes");
    }
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_ascii_uppercase();
    let numbered =
        |prefix: &str| stem.strip_prefix(prefix).is_some_and(|rest| matches!(rest.as_bytes(), [b'1'..=b'9']));
    if matches!(stem.as_str(), "CON" | "PRN" | "AUX" | "NUL") || numbered("COM") || numbered("LPT") {
        return Some("Windows reserves this name for a device");
    }
    None
}

fn shown(path: &Path) -> String {
    escape(&path.to_string_lossy())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_temporary_file_is_removed_however_early_the_program_ends_and_none_is_made_after() {
        let folder = tempfile::tempdir().unwrap();
        let list = List::default();
        let (listed, file) = Listed::new(&list, || {
            let file = tempfile::Builder::new().tempfile_in(folder.path());
            // A thread that ends the program now waits until the file is in the list.
            assert!(list.try_lock().is_err());
            file
        })
        .unwrap();
        remove_all(&list);
        assert!(!file.path().exists());
        // Another thread that writes a file would wait here until the program ends.
        assert!(list.try_lock().is_err());
        std::mem::forget(listed);
    }
}
