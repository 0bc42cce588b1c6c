//! The compiled part of the Python package `slewkit`: specs in, plans and arrays out.
//!
//! The package itself, with its classes and their documentation, is Python (`slewkit/`); what
//! stands here calls the library and hands over numbers. Every function that computes lets other
//! threads of Python run meanwhile.
//!
//! # Where does the Python package stand?
//!
//! Above everything, as the program does: `python/` is a crate of its own in the workspace, and
//! uses public items of the other crates alone. Plain `cargo` commands leave it out, because
//! nothing else needs Python to be compiled; `.ci/run` names it. It links the library with the
//! default features. What the program and the package both need stands in the library: formats
//! (`files/formats`), the words of a plan (`report/summary`), the judgement of a plan file
//! (`files/export/judged`).
//!
//! The compiled part is thin: it reads specs, calls the library without the interpreter's lock, and
//! hands numbers over in memory that becomes the array's. Classes, docstrings and exceptions are
//! Python, where a user reads them and where SciPy, pandas and matplotlib are. Arrays are made when
//! they are first asked for, and can be written to: SciPy's compiled functions take no others. A
//! panic would be an exception, `InternalError`.
//!
//! # How does the wheel bring the program?
//!
//! `slewkit_cli::run` takes arguments and gives an exit code, and is all that `main` of the binary
//! calls. The compiled part of the package, which has the library anyway, exposes it, and the entry
//! point `slew` of the wheel calls that. So there is one program, which needs no second binary in
//! the wheel. Before it starts, the entry point gives Ctrl-C back to the system: Python would only
//! note it.
//!
//! # Why does a dictionary become TOML text?
//!
//! So that it goes the one way of all specs: the same reader, checks, codes and remedies, with the
//! key of every mistake. TOML rather than JSON because it has words for NaN and infinity, which the
//! reader then refuses by key, and because it is what `to_toml` shows. What writing and reading
//! take is printed by `python/bench/overhead.py`; who plans one maneuver many times reads a
//! `Problem` once.
//!
//! # How does Python hear Ctrl-C?
//!
//! The observer that the library asks between iterations, and every 4096 steps, looks at Python's
//! signals twenty times a second at most: to take the lock of a busy interpreter can cost as much
//! as a plan. The caller's function of progress is called then as well.

#![forbid(unsafe_code)]

mod failure;
mod flown;
mod maneuver;
mod planned;
mod program;
mod simulated;
mod studied;
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
    use crate::studied::{compare, compare_integrators, is_plan, verify, verify_attitudes};
    #[pymodule_export]
    use crate::text::to_toml;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
