//! Reading of attitudes in all notations, including checks for common mistakes.

pub(super) mod from_file;

use super::{Section, Spot, short, show};
use crate::rounding::{ROTATION, SILENT};
use slewkit::lie::{exp, log, project_to_rotation, rotation_from_quaternion};
use slewkit::{Matrix3, Vector3};
use std::f64::consts::{PI, TAU};

/// A rotation as the spec gives it, with its position.
#[derive(Clone, Debug)]
pub(crate) struct Rotation {
    /// Rotation matrix. For an attitude, it maps body components to reference components; for a
    /// rotation from the start, it maps end body axes to start body axes.
    pub matrix: Matrix3,
    /// Rotation vector \[rad\]. It is the vector in the spec if the notation can express whole
    /// turns, otherwise the shortest rotation vector.
    pub vector: Vector3,
    /// Position of the attitude in the spec.
    pub spot: Spot,
    /// Key of the quaternion with the other order of components, if the quaternion is the identity
    /// in that order: `[0, 0, 0, ±1]` under wxyz, or `[±1, 0, 0, 0]` under xyzw.
    pub maybe_identity: Option<&'static str>,
}

/// Purpose of a rotation, which determines which angles are probably mistakes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Use {
    /// An attitude, for which whole turns have no effect.
    Attitude,
    /// A rotation from the start, in which whole turns count.
    Turn,
}

/// Largest deviation from orthogonality for which a matrix in a plan file is used unchanged. Such a
/// deviation is round-off.
const KEPT: f64 = 1e-6;

/// Reads the table of an attitude, which must contain exactly one notation.
pub(crate) fn rotation(section: &Section, purpose: Use) -> Option<Rotation> {
    let angle = |name: &str| name == "angle_deg" || name == "angle_rad";
    let mut names: Vec<&str> = Vec::new();
    for given in &section.given {
        // The keys of axis and angle are one notation, and so are the keys ra_deg, dec_deg and
        // roll_deg.
        let name = match given.name.as_str() {
            name if angle(name) => "axis",
            name if POINTED.contains(&name) => POINTED[0],
            name => name,
        };
        if section.knows(&given.name) && !names.contains(&name) {
            names.push(name);
        }
    }
    let name = match names[..] {
        [name] => name,
        [] if section.given.is_empty() => {
            let reason = "the rotation is empty";
            return section.refuse_here("E0021", reason, "add axis = [0, 0, 1], angle_deg = 90");
        }
        [] => return None,
        [first, second, ..] => {
            let reason = format!("the rotation is given twice, by `{first}` and by `{second}`");
            return section.refuse("E0028", second, reason, "give one notation");
        }
    };
    let rotation = |matrix, vector| Rotation { matrix, vector, spot: section.here(), maybe_identity: None };
    let vector = |vector: Vector3| rotation(exp(&vector), vector);
    let matrix = |matrix: Matrix3| rotation(matrix, log(&matrix));
    match name {
        "axis" => axis_angle(section, purpose).map(vector),
        "rotation_vector_rad" | "rotation_vector_deg" => {
            let given = section.vector(name)?;
            warn_unit(section, &[given.norm()], name, purpose);
            Some(vector(if name.ends_with("_deg") { given.map(f64::to_radians) } else { given }))
        }
        "matrix" => rotation_matrix(section).map(matrix),
        "file" => {
            let reason = "an attitude file can only give the attitude of [start] or [end] of a maneuver";
            section.refuse("E0029", name, reason, "write its numbers")
        }
        "mrp" => section.vector(name).map(|sigma| matrix(rodrigues(sigma, true))),
        "rodrigues" => section.vector(name).map(|vector| matrix(rodrigues(vector, false))),
        "ra_deg" => pointed(section).map(matrix),
        "quaternion_wxyz" | "quaternion_xyzw" => {
            let given = section.quaternion(name)?;
            let q = if name.ends_with("xyzw") { [given[3], given[0], given[1], given[2]] } else { given };
            let mut rotation = matrix(quaternion(section, q, name)?);
            let [w, x, y, z] = q.map(f64::abs);
            rotation.maybe_identity = match name {
                "quaternion_wxyz" if w + x + y == 0.0 => Some("quaternion_xyzw"),
                "quaternion_xyzw" if w + y + z == 0.0 => Some("quaternion_wxyz"),
                _ => None,
            };
            Some(rotation)
        }
        _ => euler(section, name, purpose),
    }
}

/// Keys of an attitude that is given by the direction of the body x axis and the roll about it.
const POINTED: [&str; 3] = ["ra_deg", "dec_deg", "roll_deg"];

/// Returns `R = Rz(α) Ry(−δ) Rx(ρ)`, with the right ascension α and declination δ of the body x
/// axis and the roll ρ about it.
fn pointed(section: &Section) -> Option<Matrix3> {
    if let Some(missing) = POINTED.into_iter().find(|name| !section.has(name)) {
        let reason =
            format!("right ascension, declination and roll are needed together: `{missing}` is missing");
        return section.refuse_here("E0021", reason, format!("add {missing} = 0"));
    }
    let [ra, dec, roll] = POINTED.map(|name| section.number(name));
    let dec = dec?;
    if dec.abs() > 90.0 {
        let reason = format!("`dec_deg`: a declination of {} deg is outside -90 to 90 deg", show(dec));
        return section.refuse("E0074", "dec_deg", reason, "check the order and the unit of the angles");
    }
    let [ra, dec, roll] = [ra?, dec, roll?].map(f64::to_radians);
    Some(exp(&(Vector3::z() * ra)) * exp(&(Vector3::y() * -dec)) * exp(&(Vector3::x() * roll)))
}

/// Returns the rotation for the Rodrigues parameters `e tan(φ/2)`, or for the modified Rodrigues
/// parameters `e tan(φ/4)` if `modified` is true; e is the axis and φ the angle of the rotation.
fn rodrigues(vector: Vector3, modified: bool) -> Matrix3 {
    let length = vector.norm();
    let axis = if length > 0.0 { vector / length } else { return Matrix3::identity() };
    exp(&(axis * (if modified { 4.0 } else { 2.0 } * length.atan())))
}

fn axis_angle(section: &Section, purpose: Use) -> Option<Vector3> {
    let angles = ["angle_deg", "angle_rad"];
    let given: Vec<&str> = angles.into_iter().filter(|name| section.has(name)).collect();
    if !section.has("axis") {
        let reason = format!("`{}` needs an `axis`", given[0]);
        return section.refuse_here("E0021", reason, "add axis = [0, 0, 1]");
    }
    let name = match given[..] {
        [name] => name,
        [] => return section.refuse_here("E0021", "`axis` needs an angle", "add angle_deg = 90"),
        _ => {
            let reason = "both `angle_deg` and `angle_rad` are given";
            return section.refuse("E0028", "angle_rad", reason, "give only one of the two");
        }
    };
    let (axis, angle) = (section.vector("axis"), section.number(name));
    let size = axis?.amax();
    if size == 0.0 {
        let reason = "an axis of length zero has no direction";
        let remedy = "for the identity write axis = [0, 0, 1], angle_deg = 0";
        return section.refuse("E0054", "axis", reason, remedy);
    }
    // The axis is scaled first, so that squares of very large or small components neither overflow
    // nor underflow.
    let (axis, angle) = ((axis? / size).normalize(), angle?);
    warn_unit(section, &[angle], name, purpose);
    Some(axis * if name == "angle_deg" { angle.to_radians() } else { angle })
}

/// Converts a quaternion `[w, x, y, z]` to a rotation matrix. A norm that deviates from 1 by
/// rounding errors is corrected; a larger deviation is reported as an error.
fn quaternion(section: &Section, q: [f64; 4], name: &str) -> Option<Matrix3> {
    let size = q.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
    if size == 0.0 {
        let reason = "a quaternion of norm 0 is not a rotation";
        return section.refuse("E0050", name, reason, "the identity is w = 1");
    }
    let unit = q.map(|value| value / size);
    let norm = size * unit.iter().map(|value| value * value).sum::<f64>().sqrt();
    let defect = (norm - 1.0).abs();
    if defect > ROTATION {
        let reason = format!("the norm of the quaternion is {}, but must be 1", short(norm));
        let order = if name.ends_with("wxyz") { "w, x, y, z" } else { "x, y, z, w" };
        let remedy = format!("divide by the norm, or check the four numbers: {order}");
        return section.refuse("E0051", name, reason, remedy);
    }
    if defect > SILENT {
        let reason =
            format!("the norm of the quaternion differs from 1 by {}; it is normalised", short(defect));
        section.warn("W0051", name, reason, "write more digits to keep the attitude exactly");
    }
    Some(rotation_from_quaternion(&unit))
}

/// Reads a rotation matrix. Deviations from orthogonality by rounding errors are corrected; larger
/// deviations are reported as an error.
fn rotation_matrix(section: &Section) -> Option<Matrix3> {
    let matrix = section.matrix("matrix")?;
    let residual = if matrix.amax() > 2.0 {
        matrix.amax().powi(2)
    } else {
        (matrix.transpose() * matrix - Matrix3::identity()).amax()
    };
    // A row of length 1 + ε has the squared length 1 + 2ε to first order.
    let limit = 2.0 * ROTATION;
    if residual > limit {
        let reason = format!(
            "the matrix is not a rotation: RᵀR differs from the identity by {}, and at most {limit} \
            is accepted as rounding",
            short(residual)
        );
        let remedy = "its rows must be orthogonal and of length 1; write all digits";
        return section.refuse("E0055", "matrix", reason, remedy);
    }
    if matrix.determinant() < 0.0 {
        let reason = "the matrix has determinant −1: a reflection, not a rotation";
        let remedy = "check the sign of one row, or the handedness of the axes";
        return section.refuse("E0056", "matrix", reason, remedy);
    }
    if residual > 2.0 * SILENT {
        let reason =
            format!("RᵀR differs from the identity by {}; the nearest rotation is used", short(residual));
        section.warn("W0051", "matrix", reason, "write more digits to keep the attitude exactly");
    }
    Some(if section.keeps_rounding && residual <= KEPT { matrix } else { project_to_rotation(&matrix) })
}

fn euler(section: &Section, name: &str, purpose: Use) -> Option<Rotation> {
    let given = section.vector(name)?;
    warn_unit(section, given.as_slice(), name, purpose);
    let angles = if name.ends_with("_deg") { given.map(f64::to_radians) } else { given };
    let axes = name.bytes().skip("euler_".len()).take(3).map(|letter| match letter {
        b'x' | b'1' => Vector3::x(),
        b'y' | b'2' => Vector3::y(),
        _ => Vector3::z(),
    });
    let turns: Vec<Vector3> = axes.zip(angles.iter()).map(|(axis, angle)| axis * *angle).collect();
    let matrix = turns.iter().fold(Matrix3::identity(), |matrix, turn| matrix * exp(turn));
    let turning: Vec<&Vector3> = turns.iter().filter(|turn| turn.amax() != 0.0).collect();
    let vector = match turning[..] {
        [turn] => *turn,
        _ => {
            let whole = purpose == Use::Turn && angles.iter().any(|angle| angle.abs() > PI * 1.000001);
            let vector = log(&matrix);
            if whole {
                let reason = format!(
                    "three Euler angles do not determine the number of turns; the rotation of {}° is used",
                    short(vector.norm().to_degrees())
                );
                let remedy = "write axis and angle_deg for a turn of more than 180°";
                section.warn("W0057", name, reason, remedy);
            }
            vector
        }
    };
    Some(Rotation { matrix, vector, spot: section.here(), maybe_identity: None })
}

/// Warns if angles in degrees look like radians, or angles in radians like degrees: they are round
/// numbers in the other unit.
fn warn_unit(section: &Section, angles: &[f64], name: &str, purpose: Use) {
    const ROUND: [f64; 9] = [PI / 6.0, PI / 4.0, PI / 3.0, PI / 2.0, TAU / 3.0, 0.75 * PI, PI, 1.5 * PI, TAU];
    let nonzero: Vec<f64> = angles.iter().map(|angle| angle.abs()).filter(|angle| *angle > 0.0).collect();
    let Some(first) = nonzero.first() else { return };
    if name.ends_with("_deg") {
        let round = |angle: &f64| ROUND.iter().any(|round| (angle - round).abs() < 1e-3 * round);
        if nonzero.iter().all(round) {
            let reason = format!("{}° is a small angle, and a round number in radians", show(*first));
            section.warn("W0058", name, reason, format!("meant {}?", name.replace("_deg", "_rad")));
        }
    } else {
        let large = |angle: &f64| match purpose {
            Use::Attitude => *angle > TAU * 1.001,
            Use::Turn => *angle >= 20.0 && angle.fract() == 0.0,
        };
        if let Some(angle) = nonzero.iter().find(|angle| large(angle)) {
            let turns = short(angle / TAU);
            let reason = format!("{} rad are {turns} full turns", show(*angle));
            section.warn("W0058", name, reason, format!("meant {}?", name.replace("_rad", "_deg")));
        }
    }
}
