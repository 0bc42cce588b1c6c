//! Lookup of values in slew-time tables.

use crate::failure;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use slewkit::sequence::SlewTable;
use slewkit::{Matrix3, lie};
use slewkit_files::table::{TableFileError, read_npz};
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

/// A slew-time table in memory.
#[pyclass(frozen, module = "slewkit._slewkit")]
pub struct Table(SlewTable);

/// Splits a flat array into quaternions `[w, x, y, z]`.
fn quaternions(flat: &PyReadonlyArray1<'_, f64>) -> PyResult<Vec<[f64; 4]>> {
    let flat = flat.as_slice()?;
    let rows = flat.chunks_exact(4);
    if !rows.remainder().is_empty() {
        return Err(PyValueError::new_err("quaternions have four numbers each"));
    }
    Ok(rows.map(|row| [row[0], row[1], row[2], row[3]]).collect())
}

#[pymethods]
impl Table {
    /// Reads an `.npz` archive that `slew table` wrote.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let remedy = "give an .npz that `slew table SPEC -o FILE.npz` wrote";
        let unusable = |code: &str, error: &TableFileError| {
            failure::coded(py, "FileError", code, &format!("{}: {error}", path.display()), remedy)
        };
        let file = File::open(&path).map_err(|error| unusable("E0090", &error.into()))?;
        read_npz(BufReader::new(file)).map(Self).map_err(|error| unusable("E0180", &error))
    }

    /// Returns the slew time or effort between two attitudes, given as quaternions `[w, x, y, z]`.
    fn one(&self, first: [f64; 4], second: [f64; 4]) -> f64 {
        self.0.between(&first, &second)
    }

    /// Returns the slew time or effort between corresponding quaternions of two flat arrays of
    /// equal length.
    fn between<'py>(
        &self,
        py: Python<'py>,
        first: PyReadonlyArray1<'py, f64>,
        second: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (first, second) = (quaternions(&first)?, quaternions(&second)?);
        let values = |(a, b): (&[f64; 4], &[f64; 4])| self.0.between(a, b);
        let found = failure::detached(py, || first.iter().zip(&second).map(values).collect())?;
        Ok(PyArray1::from_vec(py, found))
    }

    /// Returns the rigorous lower bounds between corresponding quaternions of two flat arrays.
    fn bound<'py>(
        &self,
        py: Python<'py>,
        first: PyReadonlyArray1<'py, f64>,
        second: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        of_turns(py, &first, &second, |turn| self.0.bound(turn))
    }

    /// Returns the durations of turns about fixed axes between corresponding quaternions of two flat
    /// arrays; NaN if the table does not have them.
    fn fixed_axis<'py>(
        &self,
        py: Python<'py>,
        first: PyReadonlyArray1<'py, f64>,
        second: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        of_turns(py, &first, &second, |turn| self.0.fixed_axis(turn).unwrap_or(f64::NAN))
    }

    /// Returns the slew times or efforts between all pairs of quaternions in a flat array, row
    /// after row.
    fn matrix<'py>(
        &self,
        py: Python<'py>,
        attitudes: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let attitudes = quaternions(&attitudes)?;
        let found = failure::detached(py, || self.0.matrix(&attitudes))?;
        Ok(PyArray1::from_vec(py, found))
    }

    /// Returns the properties of the table as a dictionary.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let nodes = self.0.nodes();
        let keys = PyDict::new(py);
        keys.set_item("quantity", nodes.quantity.name())?;
        keys.set_item("settling_s", nodes.settling_s)?;
        keys.set_item("duration_s", nodes.duration_s)?;
        keys.set_item("scales", nodes.scales)?;
        keys.set_item("planned", nodes.planned)?;
        keys.set_item("symmetry", nodes.maps.len())?;
        let errors = PyDict::new(py);
        errors.set_item("turns", nodes.errors.count)?;
        errors.set_item("median", nodes.errors.median)?;
        errors.set_item("percent_99", nodes.errors.most)?;
        errors.set_item("lowest", nodes.errors.lowest)?;
        errors.set_item("highest", nodes.errors.highest)?;
        errors.set_item("bound", nodes.errors.bound)?;
        keys.set_item("errors", errors)?;
        Ok(keys)
    }
}

/// Returns the values of a function of the turns between corresponding quaternions of two flat
/// arrays; NaN for turns that are not finite.
fn of_turns<'py>(
    py: Python<'py>,
    first: &PyReadonlyArray1<'py, f64>,
    second: &PyReadonlyArray1<'py, f64>,
    value: impl Fn(&Matrix3) -> f64 + Send + Sync,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (first, second) = (quaternions(first)?, quaternions(second)?);
    let of_pair = |(a, b): (&[f64; 4], &[f64; 4])| {
        let turn = lie::rotation_from_quaternion(a).transpose() * lie::rotation_from_quaternion(b);
        if turn.iter().all(|part| part.is_finite()) { value(&turn) } else { f64::NAN }
    };
    let found = failure::detached(py, || first.iter().zip(&second).map(of_pair).collect())?;
    Ok(PyArray1::from_vec(py, found))
}
