//! The program `slew`, for users of the package without Rust.

use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs `slew` with these arguments, the name of the program first; gives its exit code.
///
/// The program writes to the streams of the process and takes over its signals.
#[pyfunction]
pub fn run_program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| slewkit_cli::run(arguments))
}
