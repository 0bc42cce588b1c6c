//! Attitudes in every notation that a spec accepts.

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use slewkit::{Matrix3, lie};

/// The twelve sequences of intrinsic Euler angles. The sequence `zyx` means `R = Rz Ry Rx`.
pub const EULER_SEQUENCES: [&str; 12] =
    ["xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"];

/// An attitude in every notation of a spec, with the keys of a spec.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Notations {
    /// Unit quaternion with a nonnegative scalar part, scalar first.
    pub quaternion_wxyz: [f64; 4],
    /// The attitude quaternion, scalar last.
    pub quaternion_xyzw: [f64; 4],
    /// Rotation axis, as a unit vector.
    pub axis: [f64; 3],
    /// Rotation angle, from 0 to 180 \[deg\].
    pub angle_deg: f64,
    /// Rotation vector, the axis times the angle \[rad\].
    pub rotation_vector_rad: [f64; 3],
    /// Rotation matrix `R`, as three rows.
    pub matrix: [[f64; 3]; 3],
    /// Modified Rodrigues parameters of the shorter rotation, the axis times tan(angle/4).
    pub mrp: [f64; 3],
    /// Rodrigues parameters, the axis times tan(angle/2); `None` for a rotation by 180°.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rodrigues: Option<[f64; 3]>,
    /// Right ascension of the body x axis, from 0 to 360 \[deg\].
    pub ra_deg: f64,
    /// Declination of the body x axis \[deg\].
    pub dec_deg: f64,
    /// Roll about the body x axis, from −180 to 180 \[deg\]; `R = Rz(ra) Ry(−dec) Rx(roll)`.
    pub roll_deg: f64,
    /// Intrinsic Euler angles of every sequence \[deg\], with keys as in a spec.
    #[serde(flatten)]
    pub euler_deg: EulerAngles,
}

/// Euler angles \[deg\] of all sequences in the order of [`EULER_SEQUENCES`], serialised with the
/// keys `euler_xyz_deg`, `euler_xzy_deg` and so on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EulerAngles(pub [[f64; 3]; 12]);

impl Serialize for EulerAngles {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(12))?;
        for (sequence, angles) in EULER_SEQUENCES.iter().zip(&self.0) {
            map.serialize_entry(&format!("euler_{sequence}_deg"), angles)?;
        }
        map.end()
    }
}

impl From<&Matrix3> for Notations {
    fn from(rotation: &Matrix3) -> Self {
        let q = lie::quaternion_from_rotation(rotation);
        // Of the quaternions q and −q, the quaternion with a nonnegative scalar part is chosen, so
        // that equal attitudes have equal numbers. Adding 0 turns −0 into 0.
        let sign = if q[0] < 0.0 { -1.0 } else { 1.0 };
        let [w, x, y, z] = q.map(|part| sign * part + 0.0);
        let vector = lie::log(rotation);
        let angle = vector.norm();
        let axis = if angle > 0.0 { vector / angle } else { slewkit::Vector3::z() };
        let [ra, minus_dec, roll] = euler_angles(rotation, "zyx").map(f64::to_degrees);
        let of_half = |divisor: f64| [x, y, z].map(|part| part / divisor + 0.0);
        Self {
            mrp: of_half(1.0 + w),
            // Near 180°, Rodrigues parameters are omitted, because their digits would be round-off
            // only.
            rodrigues: (w > f64::EPSILON).then(|| of_half(w)),
            ra_deg: if ra < 0.0 { ra + 360.0 } else { ra + 0.0 },
            dec_deg: 0.0 - minus_dec,
            roll_deg: roll + 0.0,
            quaternion_wxyz: [w, x, y, z],
            quaternion_xyzw: [x, y, z, w],
            axis: axis.into(),
            angle_deg: angle.to_degrees(),
            rotation_vector_rad: vector.into(),
            matrix: rotation.transpose().into(),
            euler_deg: EulerAngles(
                EULER_SEQUENCES
                    .map(|sequence| euler_angles(rotation, sequence).map(|a| a.to_degrees() + 0.0)),
            ),
        }
    }
}

/// Returns the intrinsic Euler angles `(a, b, c)` \[rad\] with `R = R_i(a) R_j(b) R_k(c)`;
/// `sequence` is one of [`EULER_SEQUENCES`].
///
/// The angle `a` is computed from the column of `R` that does not depend on `c`. Then
/// `R_i(a)ᵀ R = R_j(b) R_k(c)`: row `j` gives `c`, and the same column gives `b`. At gimbal lock,
/// round-off determines `a`, and `c` compensates, so that the product is always `R`.
pub fn euler_angles(rotation: &Matrix3, sequence: &str) -> [f64; 3] {
    let axis = |index: usize| usize::from(sequence.as_bytes()[index] - b'x');
    let (i, j, last) = (axis(0), axis(1), axis(2));
    // `k` is the third axis of the triad (i, j, k), and s is its handedness.
    let k = 3 - i - j;
    let s = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
    let r = |row, column| rotation[(row, column)];
    let a: f64 = if last == i {
        // R e_i = cos b e_i + sin b (sin a e_j − s cos a e_k), with sin b ≥ 0.
        r(j, i).atan2(-s * r(k, i))
    } else {
        // R e_k = s sin b e_i + cos b (−s sin a e_j + cos a e_k), with cos b ≥ 0.
        (-s * r(j, k)).atan2(r(k, k))
    };
    let (sin, cos) = a.sin_cos();
    // Elements in rows j and k of R_i(a)ᵀ R.
    let m_j = |column| cos * r(j, column) + s * sin * r(k, column);
    let m_k = |column| cos * r(k, column) - s * sin * r(j, column);
    let (b, c) = if last == i {
        (f64::atan2(-s * m_k(i), r(i, i)), f64::atan2(-s * m_j(k), m_j(j)))
    } else {
        (f64::atan2(s * r(i, k), m_k(k)), f64::atan2(s * m_j(i), m_j(j)))
    };
    [a, b, c]
}
