//! Conversion of failures of the library to exceptions of the package, whose classes are defined in
//! Python (`slewkit/_errors.py`).

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use slewkit::assured::NotKept;
use slewkit::maneuver::ProblemError;
use slewkit::plan::PlanError;
use slewkit_files::export::{EULER_SEQUENCES, ExportError};
use slewkit_files::spec::{Diagnostic, Diagnostics};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Creates an exception of the class `class` with the arguments `arguments`.
fn raised<'py>(py: Python<'py>, class: &str, arguments: impl pyo3::call::PyCallArgs<'py>) -> PyErr {
    let made = py.import("slewkit._errors").and_then(|errors| errors.getattr(class)?.call1(arguments));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Creates an exception of the class `class` with a code, a reason and a remedy.
pub fn coded(py: Python<'_>, class: &str, code: &str, reason: &str, remedy: &str) -> PyErr {
    raised(py, class, (code, reason, remedy))
}

/// Builds the exception for a spec that cannot be read or used.
pub fn spec(py: Python<'_>, found: &Diagnostics) -> PyErr {
    if found.is_io() {
        let first = found.0.first();
        let text = |part: fn(&Diagnostic) -> &str| first.map_or("", part).to_owned();
        let reason = format!("{}: {}", text(|found| &found.file), text(|found| &found.reason));
        return coded(py, "FileError", &text(|found| found.code), &reason, &text(|found| &found.remedy));
    }
    match diagnostics(py, &found.0) {
        Ok(list) => raised(py, "SpecError", (found.to_string(), list)),
        Err(error) => error,
    }
}

/// Returns the diagnostics as dictionaries.
pub fn diagnostics<'py>(py: Python<'py>, found: &[Diagnostic]) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let dictionary = |found: &Diagnostic| {
        let keys = PyDict::new(py);
        let severity = match found.severity {
            slewkit_files::spec::Severity::Error => "error",
            slewkit_files::spec::Severity::Warning => "warning",
        };
        keys.set_item("code", found.code)?;
        keys.set_item("severity", severity)?;
        keys.set_item("file", &found.file)?;
        keys.set_item("line", found.line)?;
        keys.set_item("column", found.column)?;
        keys.set_item("key", &found.key)?;
        keys.set_item("text", &found.text)?;
        keys.set_item("reason", &found.reason)?;
        keys.set_item("remedy", &found.remedy)?;
        keys.set_item("rendered", found.to_string())?;
        Ok(keys)
    };
    found.iter().map(dictionary).collect()
}

/// Builds the exception for a spec whose keys are valid but contradict each other.
pub fn problem(py: Python<'_>, error: &ProblemError) -> PyErr {
    let (code, remedy) = match error {
        ProblemError::StepTooLong { steps, .. } => {
            ("E0120", format!("set `maneuver.steps` to {steps} or more"))
        }
        _ => ("E0121", "change the spec accordingly".into()),
    };
    refused(py, code, &error.to_string(), &remedy)
}

fn refused(py: Python<'_>, code: &str, reason: &str, remedy: &str) -> PyErr {
    let keys = PyDict::new(py);
    let filled = [("code", code), ("reason", reason), ("remedy", remedy), ("severity", "error")]
        .iter()
        .try_for_each(|(key, text)| keys.set_item(key, text));
    match filled {
        Ok(()) => {
            raised(py, "SpecError", (format!("error[{code}]: {reason}\n help: {remedy}\n"), vec![keys]))
        }
        Err(error) => error,
    }
}

/// Builds the exception for a problem that the planner rejects.
pub fn plan(py: Python<'_>, error: &PlanError) -> PyErr {
    match error {
        PlanError::Problem(error) => problem(py, error),
        PlanError::Guess { .. } | PlanError::GuessPath => {
            coded(py, "FileError", "E0103", &error.to_string(), "give another plan as the guess")
        }
        other => refused(py, "E0121", &other.to_string(), "change the spec accordingly"),
    }
}

/// Creates the exception for chance constraints that no plan was found to satisfy.
pub fn kept(py: Python<'_>, error: &NotKept) -> PyErr {
    match error {
        NotKept::Plan(error) => plan(py, error),
        other => refused(
            py,
            "E0172",
            &other.to_string(),
            "allow a larger chance or a larger limit, or reduce the uncertainty",
        ),
    }
}

/// Creates the exception for the file `name`, which could not be read or written.
pub fn export(py: Python<'_>, error: &ExportError, name: &str) -> PyErr {
    let (code, reason, remedy) = match error {
        ExportError::File(error @ slewkit_files::export::FileError::Exists { .. }) => {
            (error.code(), error.to_string(), "pass overwrite=True to replace it")
        }
        ExportError::File(error) => (error.code(), error.to_string(), error.remedy()),
        ExportError::Lacking(lacking) => {
            return refused(py, lacking.code(), &lacking.to_string(), lacking.remedy());
        }
        other => {
            let remedy = "give a plan file, as Plan.save or `slew plan SPEC -o FILE` writes it";
            (other.code(), format!("{name}: {other}"), remedy)
        }
    };
    coded(py, "FileError", code, &reason, remedy)
}

/// Returns the sequence of Euler angles with the name `name`. Raises ValueError if the name is
/// unknown.
pub fn sequence(name: &str) -> PyResult<&'static str> {
    let found = EULER_SEQUENCES.into_iter().find(|known| *known == name);
    found.ok_or_else(|| {
        let known = EULER_SEQUENCES.join(", ");
        PyValueError::new_err(format!("euler: no sequence is called {name:?}; the sequences are {known}"))
    })
}

/// Calls `work` without holding the interpreter's lock, and returns its result. If `work` panics
/// because of a bug, a Python exception is raised.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(|panic| {
        let said = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let said = said.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        let reason = format!("the program panicked: {said}");
        coded(py, "InternalError", "internal", &reason, "this is a bug: report it with the spec")
    })
}
