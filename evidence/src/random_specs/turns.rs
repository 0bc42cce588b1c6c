//! Independent functions for vectors and quaternions, so that a check does not share a mistake with
//! the library.

pub type Vector = [f64; 3];
/// A quaternion, scalar first.
pub type Quaternion = [f64; 4];

pub fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub fn scaled(v: Vector, factor: f64) -> Vector {
    v.map(|part| factor * part)
}

/// Returns the quaternion of a turn by `angle` \[rad\] about a unit axis.
pub fn turn(axis: Vector, angle: f64) -> Quaternion {
    let [x, y, z] = scaled(axis, (0.5 * angle).sin());
    [(0.5 * angle).cos(), x, y, z]
}

pub fn conjugate([w, x, y, z]: Quaternion) -> Quaternion {
    [w, -x, -y, -z]
}

pub fn product([a, b, c, d]: Quaternion, [w, x, y, z]: Quaternion) -> Quaternion {
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
}

pub fn rotated(q: Quaternion, [x, y, z]: Vector) -> Vector {
    let [_, x, y, z] = product(product(q, [0.0, x, y, z]), conjugate(q));
    [x, y, z]
}

pub fn matrix(q: Quaternion) -> [Vector; 3] {
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| rotated(q, axis));
    std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row]))
}

/// Returns the numbers as a list of TOML.
pub fn list(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(|number| format!("{number}")).collect();
    format!("[{}]", numbers.join(", "))
}
