//! Exit codes of the program, and the failures that cause them.

use super::Console;
use super::console;
use serde::Serialize;
use slewkit::plan::Status;
use slewkit_files::batch::BatchError;
use slewkit_files::exchange::Lacking;
use slewkit_files::export::{ExportError, FileError, write_document};
use slewkit_files::spec::{Diagnostics, escape};
use std::path::Path;

/// Exit codes of the program. For a plan, its [`Status`] determines the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// The command succeeded.
    Solved,
    /// The program failed because of a bug.
    Internal,
    /// The arguments on the command line are invalid.
    Usage,
    /// The spec has errors.
    SpecInvalid,
    /// The search ended without a solved plan.
    Plan(Status),
    /// A file could not be read or written.
    File,
    /// A simulation produced a number that is not finite.
    NotFinite,
    /// The batch is complete, but some of its cases failed.
    CasesFailed,
}

impl Exit {
    /// Returns the number of the exit code.
    pub fn code(self) -> u8 {
        match self {
            Self::Solved => 0,
            Self::Internal => 1,
            Self::Usage => 2,
            Self::SpecInvalid => 3,
            Self::Plan(status) => status.exit_code(),
            Self::File => 8,
            Self::NotFinite | Self::CasesFailed => 9,
        }
    }

    /// Returns the status, as a word, that corresponds to the exit code.
    pub fn status(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Internal => "internal_error",
            Self::Usage => "usage_error",
            Self::SpecInvalid => "spec_invalid",
            Self::Plan(status) => status.name(),
            Self::File => "file_error",
            Self::NotFinite => "not_finite",
            Self::CasesFailed => "cases_failed",
        }
    }
}

/// Reason why a command failed.
#[derive(Debug)]
pub enum Failure {
    /// The spec has errors.
    Spec(Diagnostics),
    /// A file, stdin or stdout could not be read or written, or its contents are invalid.
    File(Message),
    /// The problem or the settings contradict each other, although each value of the spec is valid.
    Problem(Message),
    /// The arguments contradict each other.
    Usage(String),
    /// The arguments request an output that the program cannot produce.
    Output(Message),
    /// The command ended without a plan. The status of the search determines the exit code.
    Plan(Status, Message),
    /// The program has a bug; the input of the user is not the cause.
    Internal(String),
}

/// A message with a stable code. It does not refer to a line of a spec.
#[derive(Clone, Debug, Serialize)]
pub struct Message {
    /// Stable code of the message.
    pub code: &'static str,
    /// Reason of the failure.
    pub reason: String,
    /// Remedy for the failure.
    pub remedy: String,
}

impl Message {
    pub fn new(code: &'static str, reason: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { code, reason: reason.into(), remedy: remedy.into() }
    }
}

impl Failure {
    /// Creates the failure that an input file cannot be opened or read.
    pub fn unreadable(path: &Path, error: &std::io::Error) -> Self {
        let path = path.to_string_lossy();
        let reason = format!("cannot read {}: {error}", escape(&path));
        Self::File(Message::new("E0090", reason, "check the path"))
    }

    /// Creates the failure that the contents of an input file are invalid.
    pub fn unusable(path: &Path, error: &ExportError) -> Self {
        if let ExportError::Io(error) = error {
            return Self::unreadable(path, error);
        }
        let is_spec = path.extension().is_some_and(|ending| ending == "toml");
        let path = escape(&path.to_string_lossy());
        if is_spec && matches!(error, ExportError::Json(_)) {
            let reason = format!("{path}: not a plan file, but a spec");
            let remedy = format!("plan it first: `slew plan {path} -o plan.json`");
            return Self::File(Message::new(error.code(), reason, remedy));
        }
        Self::File(Message::new(error.code(), format!("{path}: {error}"), error.remedy()))
    }

    fn exit(&self) -> Exit {
        match self {
            Self::Spec(diagnostics) if diagnostics.is_io() => Exit::File,
            Self::Spec(_) | Self::Problem(_) => Exit::SpecInvalid,
            Self::File(_) => Exit::File,
            Self::Usage(_) | Self::Output(_) => Exit::Usage,
            Self::Plan(status, _) => Exit::Plan(*status),
            Self::Internal(_) => Exit::Internal,
        }
    }

    /// Reports the failure of the command `name` to the user as text and, if `json` is true, also
    /// as a JSON document on stdout. Returns the exit code.
    pub fn report(&self, console: &mut Console, json: bool, name: &str) -> Exit {
        let exit = self.exit();
        match self {
            Self::Spec(diagnostics) => console.plain_error(&diagnostics.render(console.colour)),
            Self::File(message) | Self::Problem(message) | Self::Output(message) | Self::Plan(_, message) => {
                console.error(message.code, &message.reason, &message.remedy);
            }
            Self::Usage(reason) => console.error("usage", reason, &format!("see `slew {name} --help`")),
            Self::Internal(reason) => {
                console.error("internal", reason, "this is a bug: report it with the spec");
            }
        }
        if json {
            // If stdout itself caused the failure, the document cannot be written.
            let _ = console::to_stdout(|output| write_document(&self.document(exit), output));
        }
        exit
    }

    fn document(&self, exit: Exit) -> impl Serialize {
        let (diagnostics, error) = match self {
            Self::Spec(diagnostics) => (Some(diagnostics), None),
            Self::File(message) | Self::Problem(message) | Self::Output(message) | Self::Plan(_, message) => {
                (None, Some(message))
            }
            Self::Usage(_) | Self::Internal(_) => (None, None),
        };
        document! {
            status: exit.status(), exit_code: exit.code(), error if some: error, diagnostics if some: diagnostics,
        }
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::File(Message::new(error.code(), error.to_string(), error.remedy()))
    }
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::File(error) => error.into(),
            ExportError::Io(error) => {
                let reason = format!("writing to stdout failed: {error}");
                Self::File(Message::new("E0097", reason, "free some space, or give a file with `-o`"))
            }
            ExportError::Lacking(lacking) => {
                let message = Message::new(lacking.code(), lacking.to_string(), lacking.remedy());
                // If the program was built without a feature, this is not an error of the spec.
                if lacking == Lacking::Parquet { Self::Output(message) } else { Self::Problem(message) }
            }
            other => Self::Internal(other.to_string()),
        }
    }
}

impl From<BatchError> for Failure {
    fn from(error: BatchError) -> Self {
        let message = |code, reason, remedy| Message { code, reason, remedy };
        match error {
            BatchError::Spec(found) => Self::Spec(found),
            BatchError::Argument { code, reason, remedy } => Self::Output(message(code, reason, remedy)),
            BatchError::File { code, reason, remedy } => Self::File(message(code, reason, remedy)),
            closed @ BatchError::Closed => Self::Internal(closed.to_string()),
        }
    }
}

impl From<Diagnostics> for Failure {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Spec(diagnostics)
    }
}
