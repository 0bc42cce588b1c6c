//! What the unit tests share: reference files and random numbers.

use crate::{Matrix3, Vector3};
use nalgebra::{SMatrix, SVector};
use serde_json::Value;

/// A file of tests/reference.
pub fn reference(name: &str) -> Value {
    let path = format!("{}/tests/reference/{name}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A JSON list of numbers as a vector.
pub fn vector<const N: usize>(value: &Value) -> SVector<f64, N> {
    SVector::from_fn(|row, _| value[row].as_f64().unwrap())
}

/// A JSON list of rows as a matrix.
pub fn matrix<const R: usize, const C: usize>(value: &Value) -> SMatrix<f64, R, C> {
    SMatrix::from_fn(|row, column| value[row][column].as_f64().unwrap())
}

/// The splitmix64 generator: small, with a stream that never changes.
pub struct Random(pub u64);

impl Random {
    /// Uniform in [−1, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 * 2.0f64.powi(-52) - 1.0
    }

    /// Components uniform in [−1, 1).
    pub fn vector3(&mut self) -> Vector3 {
        Vector3::from_fn(|_, _| self.uniform())
    }

    /// A rotation; not uniform on SO(3).
    pub fn rotation(&mut self) -> Matrix3 {
        crate::lie::exp(&(self.vector3() * 2.0))
    }
}
