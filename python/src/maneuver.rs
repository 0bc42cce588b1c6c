//! Reads specs from a file, a dictionary or text.

use crate::{failure, text};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use slewkit_files::spec::{self, Diagnostics, Format, Loaded, Override, Spec, SpecDocument};
use std::path::{Path, PathBuf};

/// Name of a dictionary in messages.
const DICTIONARY: &str = "dict";

/// Name of a maneuver whose dictionary does not state a name.
const UNNAMED: &str = "maneuver";

/// Overrides from Python, which are keys of the spec with their values; `None` if there are none.
pub type Overrides<'py> = Option<Bound<'py, PyMapping>>;

/// Converts overrides from Python to overrides of the library.
pub fn overrides(given: &Overrides<'_>) -> PyResult<Vec<Override>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    let one = |item: Bound<'_, PyAny>| {
        let (path, value): (String, Bound<'_, PyAny>) = item.extract()?;
        let text = format!("{path}={}", text::value_text(&value)?);
        Override::parse(&text).map_err(|reason| PyValueError::new_err(format!("overrides: {reason}")))
    };
    given.items()?.iter().map(one).collect()
}

/// Reads a spec of a maneuver or a simulation, given as a dictionary or as the path of a file.
pub fn load(given: &Bound<'_, PyAny>, overrides: &[Override]) -> PyResult<Result<Spec, Diagnostics>> {
    if let Ok(mapping) = given.cast::<PyMapping>() {
        let text = text::to_toml(mapping)?;
        return Ok(spec::load_from_str(&text, DICTIONARY, Path::new(""), Format::Toml, overrides));
    }
    let path: PathBuf = given.extract()?;
    Ok(spec::load(&path, Format::of(&path), overrides))
}

/// Source from which a spec was read, and from which it is read again with other overrides.
#[derive(Clone)]
enum Origin {
    /// A dictionary, converted to TOML text.
    Text(String),
    /// The path of a file.
    File(PathBuf),
}

/// A maneuver whose spec was read and checked.
#[pyclass(frozen, module = "slewkit._slewkit")]
pub struct Maneuver {
    pub loaded: Loaded,
    origin: Origin,
    overrides: Vec<Override>,
}

impl Maneuver {
    fn read(py: Python<'_>, origin: Origin, overrides: Vec<Override>) -> PyResult<Self> {
        // The reader of maneuvers returns an error for the spec of a simulation.
        let loaded = match &origin {
            Origin::Text(text) => spec::from_str(text, DICTIONARY, Format::Toml, &overrides),
            Origin::File(path) => spec::read(path, &overrides),
        };
        let mut loaded = loaded.map_err(|found| failure::spec(py, &found))?;
        // A maneuver without a name is named after its file, but a dictionary has no file.
        if matches!(origin, Origin::Text(_)) && loaded.problem.name == DICTIONARY {
            loaded.problem.name = UNNAMED.into();
        }
        loaded.problem.check().map_err(|error| failure::problem(py, &error))?;
        Ok(Self { loaded, origin, overrides })
    }
}

#[pymethods]
impl Maneuver {
    /// Reads a maneuver from a dictionary with the keys of a spec, or from a file.
    #[new]
    #[pyo3(signature = (spec, overrides = None))]
    fn new(py: Python<'_>, spec: &Bound<'_, PyAny>, overrides: Overrides<'_>) -> PyResult<Self> {
        let origin = match spec.cast::<PyMapping>() {
            Ok(mapping) => Origin::Text(text::to_toml(mapping)?),
            Err(_) => Origin::File(spec.extract()?),
        };
        Self::read(py, origin, self::overrides(&overrides)?)
    }

    /// Reads the spec again with additional overrides.
    #[pyo3(signature = (overrides = None))]
    fn again(&self, py: Python<'_>, overrides: Overrides<'_>) -> PyResult<Self> {
        let further = self::overrides(&overrides)?;
        Self::read(py, self.origin.clone(), [&self.overrides[..], &further[..]].concat())
    }

    /// Returns the name of the maneuver.
    #[getter]
    fn name(&self) -> &str {
        &self.loaded.problem.name
    }

    /// Returns the duration in seconds; `None` if it is free.
    #[getter]
    fn duration(&self) -> Option<f64> {
        self.loaded.problem.duration.known()
    }

    /// Returns the number of steps.
    #[getter]
    fn steps(&self) -> usize {
        self.loaded.problem.steps
    }

    /// Returns the rows of the inertia matrix in body axes [kg·m²].
    #[getter]
    fn inertia(&self) -> [[f64; 3]; 3] {
        // The matrix is symmetric, so its columns are its rows.
        (*self.loaded.problem.body.inertia.j()).into()
    }

    /// Returns the warnings of the spec.
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        failure::diagnostics(py, &self.loaded.warnings)
    }

    /// Returns the maneuver as JSON, with the keys of a spec in SI units.
    fn spec_json(&self) -> PyResult<String> {
        let Loaded { problem, settings, identity, .. } = &self.loaded;
        let document = SpecDocument::new(problem, settings);
        let document = document.map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(document.with_identity(identity).to_string())
    }
}

/// Returns all errors and warnings of the spec of a maneuver or a simulation.
#[pyfunction]
#[pyo3(signature = (spec, overrides = None))]
pub fn diagnose<'py>(
    py: Python<'py>,
    spec: &Bound<'py, PyAny>,
    overrides: Overrides<'py>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    match load(spec, &self::overrides(&overrides)?)? {
        Ok(Spec::Maneuver(loaded)) => {
            if let Err(error) = loaded.problem.check() {
                return Err(failure::problem(py, &error));
            }
            failure::diagnostics(py, &loaded.warnings)
        }
        Ok(Spec::Sequence(loaded)) => failure::diagnostics(py, &loaded.warnings),
        Ok(Spec::Simulation(loaded)) => failure::diagnostics(py, &loaded.warnings),
        Err(found) if found.is_io() => Err(failure::spec(py, &found)),
        Err(found) => failure::diagnostics(py, &found.0),
    }
}
