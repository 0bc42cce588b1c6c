//! The compiled part of the Python package `slewkit`: specs in, plans and arrays out.
//!
//! The package itself, with its classes and their documentation, is Python (`slewkit/`); what stands here calls the library
//! and hands over numbers. Every function that computes lets other threads of Python run meanwhile.

#![forbid(unsafe_code)]

mod failure;
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
