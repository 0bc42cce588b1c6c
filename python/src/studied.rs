//! Plans before the witnesses, and methods side by side.

use crate::failure::{self, detached};
use crate::maneuver::Maneuver;
use crate::planned::Planned;
use crate::watch::Watch;
use pyo3::prelude::*;
use serde_json::json;
use slewkit::files::export::ExportError;
use slewkit::studies::methods;
use std::cell::RefCell;
use std::time::Instant;

/// Has the witnesses judge a plan against its own maneuver, or another. Gives what they found as JSON, and what was raised
/// meanwhile.
#[pyfunction]
#[pyo3(signature = (planned, maneuver = None, progress = None))]
pub fn verify(
    py: Python<'_>,
    planned: &Bound<'_, Planned>,
    maneuver: Option<&Bound<'_, Maneuver>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Option<PyErr>)> {
    let planned = planned.get();
    let loaded = maneuver.map(|maneuver| &maneuver.get().loaded);
    let (problem, settings) = match loaded {
        Some(loaded) => (&loaded.problem, &loaded.settings),
        None => (&planned.problem, &planned.settings),
    };
    let (watch, began) = (Watch::new(progress), Instant::now());
    let (judged, watch) = detached(py, || {
        let watch = RefCell::new(watch);
        let stop =
            || watch.borrow_mut().stops("witnesses", "", problem.steps as u64, began.elapsed().as_secs_f64());
        let judged = planned.file().judge(problem, settings, &stop);
        (judged, watch.into_inner())
    })?;
    let judged = judged.map_err(|error| match error {
        // A plan whose arrays do not fit the maneuver has failed.
        ExportError::Trajectory(error) => {
            let remedy = "give the spec that the plan was made from";
            failure::coded(py, "VerificationFailed", "E0103", &error.to_string(), remedy)
        }
        other => failure::export(py, &other, "plan"),
    })?;
    let verification = &judged.verification;
    let status = if verification.passed() {
        "solved"
    } else if verification.was_stopped() {
        "interrupted"
    } else {
        "verification_failed"
    };
    let document = json!({
        "status": status,
        "name": judged.problem.name,
        "steps": judged.problem.steps,
        "verified": verification,
        "differences": judged.differences,
    });
    Ok((document.to_string(), watch.raised()))
}

/// Solves a maneuver by every method that applies. Gives them side by side as JSON, and what was raised meanwhile.
#[pyfunction]
#[pyo3(signature = (maneuver, progress = None))]
pub fn compare(
    py: Python<'_>,
    maneuver: &Bound<'_, Maneuver>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Option<PyErr>)> {
    let loaded = &maneuver.get().loaded;
    let mut watch = Watch::new(progress);
    let found = detached(py, || methods::compare(&loaded.problem, &loaded.settings, &mut watch))?;
    let found = found.map_err(|error| failure::plan(py, &error))?;
    let status = found.status();
    let document = json!({
        "status": status.name(),
        "exit_code": status.exit_code(),
        "name": loaded.problem.name,
        "methods": found.methods,
        "agreement": found.agreement,
    });
    Ok((document.to_string(), watch.raised()))
}
