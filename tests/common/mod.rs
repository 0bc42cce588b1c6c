//! Reference files and random inputs for the tests.

// Each test binary uses its own part.
#![allow(dead_code)]

use serde_json::Value;
use slewkit::{Matrix3, Vector3, lie};

/// The reference file `tests/reference/<name>.json`.
pub fn reference(name: &str) -> Value {
    let path = format!("{}/tests/reference/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The elements of an array.
pub fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("not a list: {value}"))
}

/// A number.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

/// A flat list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(number).collect()
}

/// Three numbers.
pub fn vector(value: &Value) -> Vector3 {
    Vector3::from_column_slice(&numbers(value))
}

/// `R` rows of `C` numbers.
pub fn matrix<const R: usize, const C: usize>(value: &Value) -> nalgebra::SMatrix<f64, R, C> {
    let rows: Vec<f64> = list(value).iter().flat_map(numbers).collect();
    nalgebra::SMatrix::from_row_slice(&rows)
}

/// Three rows of three numbers.
pub fn matrix3(value: &Value) -> Matrix3 {
    matrix::<3, 3>(value)
}

/// Largest magnitude of some numbers; NaN if one is, which `amax` and `f64::max` would swallow.
pub fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |max: f64, x| if x.abs() > max || x.is_nan() { x.abs() } else { max })
}

/// Largest difference between the elements of two matrices; NaN if there is one in either.
pub fn difference<const R: usize, const C: usize>(
    a: &nalgebra::SMatrix<f64, R, C>,
    b: &nalgebra::SMatrix<f64, R, C>,
) -> f64 {
    largest(&(a - b))
}

/// SplitMix64 (Steele, Lea, Flood 2014): a stream that never changes under the tests.
pub struct Random(u64);

impl Random {
    /// The stream of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [−1, 1).
    pub fn uniform(&mut self) -> f64 {
        // The upper 53 bits, so that every value is exact.
        (self.bits() >> 11) as f64 * 2.0_f64.powi(-52) - 1.0
    }

    /// Uniform in the cube [−1, 1)³.
    pub fn vector(&mut self) -> Vector3 {
        Vector3::from_fn(|_, _| self.uniform())
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vector3 {
        loop {
            let v = self.vector();
            if (0.01..=1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }

    /// A rotation of any angle about any axis.
    pub fn rotation(&mut self) -> Matrix3 {
        lie::exp(&(self.direction() * (std::f64::consts::PI * self.uniform())))
    }
}
