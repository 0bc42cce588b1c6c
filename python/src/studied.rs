//! Verification of plans and attitudes with the witnesses, and comparisons of methods and
//! integrators.

use crate::failure::{self, detached};
use crate::maneuver::{self, Maneuver, Overrides, load};
use crate::planned::Planned;
use crate::watch::Watch;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::json;
use slewkit::propagate::integrator::Kind;
use slewkit::verify::DEFAULT_ACCURACY_DEG;
use slewkit_files::exchange::{judge_file, read_attitudes};
use slewkit_files::export::{ExportError, PlanFile};
use slewkit_files::spec::{Loaded, Spec};
use slewkit_report::studies::integrators::{Asked, Study, StudyError, StudyProgress};
use slewkit_report::studies::methods;
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::time::Instant;

/// Lets the witnesses check a plan against its own maneuver or against another one. Returns the
/// results as JSON, and an exception that was raised during the work.
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
    let (problem, settings, identity, closed_loop) = match loaded {
        Some(loaded) => (&loaded.problem, &loaded.settings, &loaded.identity, &loaded.closed_loop),
        None => (&planned.problem, &planned.settings, &planned.identity, &planned.closed_loop),
    };
    let (watch, began) = (Watch::new(progress), Instant::now());
    let (judged, watch) = detached(py, || {
        let watch = RefCell::new(watch);
        let stop = || {
            watch.borrow_mut().stops("witnesses", "", problem.steps as u64, began.elapsed().as_secs_f64(), "")
        };
        let judged = planned.file().judge(problem, settings, identity, closed_loop, &stop);
        (judged, watch.into_inner())
    })?;
    let judged = judged.map_err(|error| match error {
        // A plan whose arrays do not fit the maneuver fails the verification.
        error @ (ExportError::Trajectory(_) | ExportError::NoMotion) => {
            let remedy = "give the spec of the plan";
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
        "recorded": judged.recorded,
        "not_judged": judged.not_judged,
    });
    Ok((document.to_string(), watch.raised()))
}

/// Returns whether the bytes are a plan file. Otherwise they are an attitude message or a table of
/// attitudes.
#[pyfunction]
pub fn is_plan(bytes: &[u8]) -> bool {
    PlanFile::begins(bytes)
}

/// Checks attitudes and rates against a maneuver. `bytes` are the contents of an AEM or a table,
/// and `name` is the name of the file. Returns the results as JSON.
#[pyfunction]
pub fn verify_attitudes(
    py: Python<'_>,
    bytes: Vec<u8>,
    name: &str,
    maneuver: &Bound<'_, Maneuver>,
) -> PyResult<String> {
    let Loaded { problem, settings, identity, .. } = &maneuver.get().loaded;
    let found = read_attitudes(&bytes[..], name).map_err(|found| failure::spec(py, &found))?;
    let tolerance = settings.continuous_tolerance.unwrap_or(DEFAULT_ACCURACY_DEG.to_radians());
    let judged = detached(py, || judge_file(&found, name, problem, identity, tolerance))?;
    let judged = judged.map_err(|found| failure::spec(py, &found))?;
    let rows = &judged.attitudes;
    let document = json!({
        "status": if judged.passed() { "solved" } else { "verification_failed" },
        "name": problem.name,
        "steps": found.time.len() - 1,
        "verified": {
            "checks": rows.checks,
            "violations": rows.violations,
            "not_judged": judged.not_judged,
            "peak_torque_n_m": rows.peak_torque_n_m,
            "peak_torque_of_attitudes_n_m": rows.peak_torque_of_attitudes_n_m,
        },
        "differences": [],
        "recorded": [],
        "not_judged": judged.not_judged,
    });
    Ok(document.to_string())
}

/// Compares integrators on the motion of a simulation spec. Returns the study as JSON, its table as
/// text, and an exception that was raised during the work.
#[pyfunction]
#[pyo3(signature = (
    spec, overrides = None, integrators = vec![], steps = vec![], horizons = vec![], levels =
    vec![], progress = None
))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn compare_integrators(
    py: Python<'_>,
    spec: &Bound<'_, PyAny>,
    overrides: Overrides<'_>,
    integrators: Vec<String>,
    steps: Vec<f64>,
    horizons: Vec<f64>,
    levels: Vec<f64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Option<PyErr>)> {
    let simulation = match load(spec, &maneuver::overrides(&overrides)?)? {
        Ok(Spec::Simulation(loaded)) => loaded.simulation,
        Ok(Spec::Maneuver(_) | Spec::Sequence(_)) => {
            let reason =
                "this spec is a maneuver: compare_integrators() needs a simulation, compare() a maneuver";
            return Err(PyValueError::new_err(reason));
        }
        Err(found) => return Err(failure::spec(py, &found)),
    };
    let kinds = integrators.iter().map(|name| name.parse::<Kind>());
    let kinds = kinds.collect::<Result<_, _>>().map_err(|error| PyValueError::new_err(error.to_string()))?;
    let study = Study::of(&simulation, &Asked { kinds, steps, horizons, levels });
    let refused = |error: StudyError| PyValueError::new_err(error.to_string());
    study.check().map_err(refused)?;
    let (mut watch, began) = (Watch::new(progress), Instant::now());
    let (found, watch) = detached(py, || {
        let found = study.run(&simulation.system, &simulation.start, &mut |progress| {
            let StudyProgress { kind, step, .. } = progress;
            let steps = (simulation.duration / step).round() as u64;
            let stop = watch.stops("integrators", kind.name(), steps, began.elapsed().as_secs_f64(), "");
            if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        (found, watch)
    })?;
    let found = found.map_err(refused)?;
    let document = json!({
        "status": if found.interrupted { "interrupted" } else { "solved" },
        "name": simulation.name,
        "energy_scale_j": found.energy_scale_j,
        "levels": found.levels,
        "runs": found.runs,
        "equal_error": found.equal_error,
        "table": found.to_string(),
    });
    Ok((document.to_string(), watch.raised()))
}

/// Plans a maneuver with every method that applies. Returns the comparison as JSON, and an
/// exception that was raised during the work.
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
