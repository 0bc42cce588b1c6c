//! The compiled part of the Python package `slewkit`. It reads specs, and returns plans and arrays.
//!
//! The package itself, with its classes and their documentation, is Python (`slewkit/`); this
//! crate calls the library and returns numbers. Every function that computes lets other threads
//! of Python run.
//!
//! # Where does the Python package stand?
//!
//! No other crate depends on the package, as with the program: `python/` is a separate crate of the
//! workspace, and uses only public items of the other crates. Plain `cargo` commands omit it,
//! because no other crate needs Python to be compiled; `.ci/run` names it. It links the library
//! with the default features. Code that the program and the package share is in the library:
//! formats (`files/formats`), the summary of a plan (`report/summary`), the check of a plan file
//! (`files/export/judged`).
//!
//! The compiled part is thin: it reads specs, calls the library without the interpreter's lock, and
//! passes numbers on in memory that becomes the array's. Classes, docstrings and exceptions are
//! written in Python, where a user reads them and where SciPy, pandas and matplotlib are available.
//! Arrays are made on first use, and are writable: SciPy's compiled functions need writable arrays.
//! A panic becomes the exception `InternalError`.
//!
//! # How does the wheel bring the program?
//!
//! `slewkit_cli::run` takes arguments, returns an exit code, and is all that `main` of the binary
//! calls. The compiled part of the package, which contains the library anyway, exposes it, and the
//! entry point `slew` of the wheel calls it. The wheel therefore needs no second binary. The entry
//! point returns Ctrl-C to the system before the program starts, because Python would only record
//! it.
//!
//! # Why does a dictionary become TOML text?
//!
//! A dictionary is read like every other spec: by the same reader, with the same checks, codes and
//! remedies, and the key of every error. TOML is used rather than JSON because it has words for NaN
//! and infinity, which the reader then refuses by key, and because `to_toml` shows it.
//! `python/bench/overhead.py` prints the cost of writing and reading; a caller who plans one
//! maneuver many times reads a `Problem` once.
//!
//! # How does Python hear Ctrl-C?
//!
//! The library calls the observer between iterations, and every 4096 steps. The observer checks
//! Python's signals at most twenty times a second, because taking the lock of a busy interpreter
//! can cost as much as a plan. It then also calls the caller's progress function.

#![forbid(unsafe_code)]

mod failure;
mod flown;
mod maneuver;
mod planned;
mod program;
mod simulated;
mod stops;
mod studied;
mod table;
mod text;
mod watch;

use pyo3::prelude::*;

#[pymodule]
mod _slewkit {
    use super::*;
    #[pymodule_export]
    use crate::flown::fly;
    #[pymodule_export]
    use crate::maneuver::{Maneuver, diagnose};
    #[pymodule_export]
    use crate::planned::{Planned, plan, read_plan, write_page};
    #[pymodule_export]
    use crate::program::run_program;
    #[pymodule_export]
    use crate::simulated::{simulate, simulation_report};
    #[pymodule_export]
    use crate::stops::{PlannedSequence, plan_sequence};
    #[pymodule_export]
    use crate::studied::{compare, compare_integrators, is_plan, verify, verify_attitudes};
    #[pymodule_export]
    use crate::table::Table;
    #[pymodule_export]
    use crate::text::to_toml;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
