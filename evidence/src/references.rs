//! Reads reference files and their numbers, and computes differences of numbers.

use super::ROOT;
use serde_json::Value;
use slewkit::{Matrix3, Vector3};

/// Returns the reference file `tests/reference/<name>.json`.
pub fn reference(name: &str) -> Value {
    let path = format!("{ROOT}/tests/reference/{name}.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Returns the elements of a JSON array.
pub fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("not a list: {value}"))
}

/// Returns a JSON number.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

/// Returns the numbers of a JSON array.
pub fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(number).collect()
}

/// Returns a vector from a JSON array of three numbers.
pub fn vector(value: &Value) -> Vector3 {
    Vector3::from_column_slice(&numbers(value))
}

/// Returns a matrix from a JSON array of `R` rows of `C` numbers.
pub fn matrix<const R: usize, const C: usize>(value: &Value) -> nalgebra::SMatrix<f64, R, C> {
    let rows: Vec<f64> = list(value).iter().flat_map(numbers).collect();
    nalgebra::SMatrix::from_row_slice(&rows)
}

/// Returns a 3×3 matrix from a JSON array of rows.
pub fn matrix3(value: &Value) -> Matrix3 {
    matrix::<3, 3>(value)
}

/// Sorts the values and returns the upper median; NaN if there are no values.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Returns the largest absolute value; NaN if a number is NaN, which `amax` and `f64::max` would
/// ignore.
pub fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |max: f64, x| if x.abs() > max || x.is_nan() { x.abs() } else { max })
}

/// Returns the largest absolute difference between the elements of two matrices; NaN if either
/// matrix contains a NaN.
pub fn difference<const R: usize, const C: usize>(
    a: &nalgebra::SMatrix<f64, R, C>,
    b: &nalgebra::SMatrix<f64, R, C>,
) -> f64 {
    largest(&(a - b))
}
