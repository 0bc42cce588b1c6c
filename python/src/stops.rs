//! Planning of sequences of stops.

use crate::failure::{self, detached};
use crate::maneuver::{self, Overrides, load};
use crate::planned::Planned;
use crate::watch::Watch;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use slewkit::sequence::joined::Joined;
use slewkit::sequence::{SequenceError, SequencePlan};
use slewkit_files::exchange::Tables;
use slewkit_files::export::{ExportError, SequenceFile, Target};
use slewkit_files::formats::Format;
use slewkit_files::spec::{ClosedLoop, LoadedSequence, Spec};
use slewkit_report::{sequence_page, summary};
use std::path::PathBuf;

/// A sequence and its plan.
#[pyclass(frozen, module = "slewkit._slewkit")]
pub struct PlannedSequence {
    loaded: LoadedSequence,
    plan: SequencePlan,
    joined: Joined,
}

/// Plans a sequence. Also returns an exception that was raised during the work.
#[pyfunction]
#[pyo3(signature = (spec, overrides = None, progress = None))]
pub fn plan_sequence(
    py: Python<'_>,
    spec: &Bound<'_, PyAny>,
    overrides: Overrides<'_>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(PlannedSequence, Option<PyErr>)> {
    let read = load(spec, &maneuver::overrides(&overrides)?)?;
    let loaded = match read.map_err(|found| failure::spec(py, &found))? {
        Spec::Sequence(loaded) => *loaded,
        _ => {
            let reason = "this spec has no stops: plan() plans it; or add [[stop]]";
            return Err(PyValueError::new_err(reason));
        }
    };
    let mut watch = Watch::new(progress);
    let found = detached(py, || loaded.sequence.plan(&loaded.settings, &mut watch))?;
    let raised = watch.raised();
    let plan = match (found, raised) {
        (Err(_), Some(raised)) => return Err(raised),
        (Err(error), None) => return Err(refused(py, &error)),
        (Ok(plan), raised) => (plan, raised),
    };
    let (plan, raised) = plan;
    let joined = plan.joined();
    Ok((PlannedSequence { loaded, plan, joined }, raised))
}

/// Builds the exception for a sequence without a plan.
fn refused(py: Python<'_>, error: &SequenceError) -> PyErr {
    let (class, code) = match error {
        SequenceError::Windows { .. } => ("Infeasible", "E0191"),
        SequenceError::NoPlan { .. } | SequenceError::Stopped(_) => ("NotSolved", "E0191"),
        _ => ("NotSolved", "E0190"),
    };
    failure::coded(py, class, code, &error.to_string(), "change the stops accordingly")
}

impl PlannedSequence {
    /// Returns the contents of the plan file of the sequence.
    pub(crate) fn file(&self) -> SequenceFile<'_> {
        SequenceFile::new(&self.loaded, &self.plan)
    }
}

#[pymethods]
impl PlannedSequence {
    /// Returns the contents of the plan file without its legs, as JSON.
    fn record_json(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || serde_json::to_string(&self.file().record))?
            .map_err(|error| failure::export(py, &error.into(), "plan"))
    }

    /// Returns the plan of each leg.
    fn legs(&self) -> Vec<Planned> {
        let LoadedSequence { settings, identity, .. } = &self.loaded;
        let planned = |leg: &slewkit::sequence::PlannedLeg| {
            let problem = leg.plan.solution.on_grid(&leg.problem);
            Planned::of(problem, settings.clone(), identity.clone(), ClosedLoop::default(), leg.plan.clone())
        };
        self.plan.legs.iter().map(planned).collect()
    }

    /// Returns the motion of the hold at each stop; `None` for a stop at which the body rests.
    fn holds(&self) -> Vec<Option<Planned>> {
        let LoadedSequence { settings, identity, .. } = &self.loaded;
        let planned = |hold: &slewkit::sequence::Hold| {
            let problem = hold.plan.solution.on_grid(&hold.problem);
            Planned::of(problem, settings.clone(), identity.clone(), ClosedLoop::default(), hold.plan.clone())
        };
        self.plan.legs.iter().map(|leg| leg.hold.as_ref().map(planned)).collect()
    }

    /// Returns the number of values in a row of inputs.
    #[getter]
    fn input_count(&self) -> usize {
        self.joined.path.input_count
    }

    /// Returns a quantity of the motion of the whole sequence, row after row; `None` for an unknown
    /// name.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyArray1<f64>>> {
        let of = &self.joined.path;
        let flat = |rows: &[slewkit::Vector3]| rows.iter().flatten().copied().collect();
        let numbers = match name {
            "time" => of.time.clone(),
            "quaternion_wxyz" => of.quaternion.clone().into_flattened(),
            "angular_velocity" => flat(&of.angular_velocity),
            "held_input" => of.input.clone(),
            "held_torque" => flat(&of.torque),
            "wheel_momentum" => of.wheel_momentum.clone(),
            _ => return None,
        };
        Some(PyArray1::from_vec(py, numbers))
    }

    /// Writes the plan to a file, completely or not at all. The ending of the file selects the
    /// format.
    #[pyo3(signature = (path, overwrite = false))]
    fn save(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<()> {
        let ending = path.extension().map_or(String::new(), |ending| ending.to_string_lossy().into_owned());
        let format = Format::of_ending(&ending).ok_or_else(|| {
            let reason = format!("no format has the ending {ending:?}");
            failure::coded(py, "FileError", "E0105", &reason, "save it as .json, .csv, .aem or .npz")
        })?;
        let name = path.to_string_lossy().into_owned();
        let LoadedSequence { sequence, identity, .. } = &self.loaded;
        let written = detached(py, || {
            Target::new(&path, overwrite).map_err(ExportError::from).and_then(|target| {
                let (file, tables) = (self.file(), Tables::default());
                target.write(|output| format.write_sequence(&file, &sequence.craft, identity, tables, output))
            })
        })?;
        written.map_err(|error| failure::export(py, &error, &name))
    }

    /// Returns the HTML page of the sequence.
    fn page(&self, py: Python<'_>, euler: &str) -> PyResult<String> {
        let euler = failure::sequence(euler)?;
        detached(py, || sequence_page(&self.file(), &self.loaded, euler))
    }

    /// Returns the summary that `slew plan` prints.
    fn summary(&self) -> String {
        summary::sequence::sequence(false, &self.file(), &self.loaded).join("\n")
    }
}
