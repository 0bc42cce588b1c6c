//! The program `slew`, for users of the package without Rust.

use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs `slew` and returns its exit code. The first argument is the name of the program.
///
/// The program writes to the streams of the process and takes over its signals.
#[pyfunction]
pub fn run_program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| slewkit_cli::run(arguments))
}
