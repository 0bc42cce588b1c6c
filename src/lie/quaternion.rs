//! Hamilton quaternions `[w, x, y, z]` of rotations, body → reference, and the rotation nearest to
//! a matrix.

use super::skew::{skew_polynomial, twice_vee};
use crate::{Matrix3, Vector3};

/// Returns the unit quaternion `[w, x, y, z]` of a rotation; its largest component is positive.
///
/// The method is Shepperd's. `q` and `−q` are the same rotation; the caller must choose the sign
/// that is continuous along a trajectory.
pub fn quaternion_from_rotation(rotation: &Matrix3) -> [f64; 4] {
    let q = shepperd(rotation);
    let norm = q.iter().map(|component| component * component).sum::<f64>().sqrt();
    q.map(|component| component / norm)
}

/// Returns the quaternion by Shepperd's method, which divides by the largest of the four
/// components, whose square is at least ¼. The quaternion is unit to round-off if the matrix is
/// orthogonal to round-off.
pub(super) fn shepperd(r: &Matrix3) -> [f64; 4] {
    let skew = twice_vee(r);
    let (d, trace) = (r.diagonal(), r.trace());
    // 4w² = 1 + tr, 4x² = 1 + r₁₁ − r₂₂ − r₃₃, …
    let i = d.imax();
    if trace >= d[i] {
        let twice_w = (1.0 + trace).sqrt();
        let v = skew / (2.0 * twice_w);
        [0.5 * twice_w, v.x, v.y, v.z]
    } else {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let twice_largest = (1.0 + d[i] - d[j] - d[k]).sqrt();
        let scale = 0.5 / twice_largest;
        let mut q = [skew[i] * scale, 0.0, 0.0, 0.0];
        q[1 + i] = 0.5 * twice_largest;
        q[1 + j] = (r[(i, j)] + r[(j, i)]) * scale;
        q[1 + k] = (r[(i, k)] + r[(k, i)]) * scale;
        q
    }
}

/// Returns `quaternion` or its negative, whichever is nearer to the quaternion `before`. Without
/// `before` it returns `quaternion`.
pub(crate) fn continued(before: Option<&[f64; 4]>, quaternion: [f64; 4]) -> [f64; 4] {
    let dot = |before: &[f64; 4]| before.iter().zip(&quaternion).map(|(a, b)| a * b).sum::<f64>();
    if before.is_some_and(|before| dot(before) < 0.0) { quaternion.map(|part| -part) } else { quaternion }
}

/// Returns the rotation matrix of a quaternion `[w, v]`: `I + 2 (w S(v) + S(v)²)/(w² + |v|²)`.
///
/// The quaternion need not be a unit quaternion. The zero quaternion gives NaN.
pub fn rotation_from_quaternion(quaternion: &[f64; 4]) -> Matrix3 {
    let [w, x, y, z] = *quaternion;
    let v = Vector3::new(x, y, z);
    let b = 2.0 / (w * w + v.norm_squared());
    Matrix3::identity() + skew_polynomial(w * b, b, &v)
}

/// Returns the rotation nearest to a nearly orthogonal matrix: its polar factor, by Newton's
/// iteration `X ← ½ (X + X⁻ᵀ)`.
///
/// It serves for input with rounding errors or few digits. The iteration converges for every matrix
/// of positive determinant that is not nearly singular. A negative determinant gives a reflection,
/// and a singular or non-finite matrix gives values that are not finite.
pub fn project_to_rotation(matrix: &Matrix3) -> Matrix3 {
    // The convergence is quadratic near the result: five iterations from an error of one percent.
    // The rest is a margin for badly scaled matrices.
    const MAX_ITERATIONS: usize = 40;
    let mut x = *matrix;
    for _ in 0..MAX_ITERATIONS {
        let correction = 0.5 * (inverse_transpose(&x) - x);
        x += correction;
        // The remaining error is half of the square of the correction.
        if correction.amax() < 1e-9 {
            break;
        }
    }
    x
}

/// Returns `X⁻ᵀ`: the matrix of cofactors divided by the determinant.
fn inverse_transpose(x: &Matrix3) -> Matrix3 {
    let (a, b, c) = (x.column(0), x.column(1), x.column(2));
    let bc = b.cross(&c);
    Matrix3::from_columns(&[bc, c.cross(&a), a.cross(&b)]) / a.dot(&bc)
}
