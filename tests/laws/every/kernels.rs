//! Laws, derivatives and reference vectors of the SO(3) kernels.

use crate::evidence::{Random, difference, list, matrix3, reference, vector};
use num_dual::DualSVec64;
use slewkit::lie::*;
use slewkit::{Matrix3, Vector3};
use std::f64::consts::PI;

const EPS: f64 = f64::EPSILON;

/// Returns the angles \[rad\] at which every law holds: zero, the smallest, both sides of every
/// switch (the guards at 1e-9 and 1e-8, of the angle and its half; the quaternion changes its pivot
/// between π/2 and 2π/3), generic ones, and π from below. The switch of the series, √10, is in
/// [`long_angles`].
fn angles() -> Vec<f64> {
    let mut angles = vec![
        0.0, 1e-300, 1e-200, 1e-154, 1e-100, 1e-20, 1e-12, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 0.1, 0.5, 1.0, 2.5,
    ];
    for switch in [1e-8, 2e-9, 2e-8, 2.0 * PI / 3.0, PI / 2.0] {
        angles.extend([switch * (1.0 - 1e-15), switch, switch * (1.0 + 1e-15)]);
    }
    angles.extend([1e-3, 1e-6, 1e-9, 1e-12, 1e-13].map(|gap| PI - gap));
    angles
}

/// Returns the angles beyond π, where the exponential and its Jacobians still serve.
fn long_angles() -> Vec<f64> {
    let switch = 10.0_f64.sqrt();
    vec![PI, switch.next_down(), switch, switch.next_up(), 3.5, 4.0, 5.0, 6.0]
}

/// Returns every angle about the coordinate axes and about twenty random ones.
fn rotation_vectors(angles: &[f64]) -> Vec<Vector3> {
    let mut random = Random::new(1);
    let axes: Vec<Vector3> = [Vector3::x(), Vector3::y(), Vector3::z()]
        .into_iter()
        .chain((0..20).map(|_| random.direction()))
        .collect();
    angles.iter().flat_map(|angle| axes.iter().map(move |axis| axis * *angle)).collect()
}

fn all_angles() -> Vec<f64> {
    [angles(), long_angles()].concat()
}

/// Returns the norm without underflow.
fn norm(v: &Vector3) -> f64 {
    let scale = v.amax();
    if scale == 0.0 { 0.0 } else { (v / scale).norm() * scale }
}

#[track_caller]
fn assert_close(a: &Matrix3, b: &Matrix3, tolerance: f64, what: &str) {
    let error = difference(a, b);
    assert!(error <= tolerance, "{what}: off by {error:e}\n{a}{b}");
}

/// The distance between two matrices, and its bound by round-off.
type Defect = (f64, f64);

/// A law of the kernels: its name, the angles at which it holds, and its defect at a rotation
/// vector.
struct Law(&'static str, fn() -> Vec<f64>, fn(&Vector3) -> Defect);

const ONE: fn() -> Matrix3 = Matrix3::identity;

/// Every law of one rotation vector. A new law is one line here.
const LAWS: [Law; 21] = [
    Law("log exp f = f", angles, |f| (norm(&(log(&exp(f)) - f)), 5.0 * EPS * norm(f))),
    Law("exp(f)ᵀ exp(f) = 1", all_angles, |f| {
        (difference(&(exp(f).transpose() * exp(f)), &ONE()), 8.0 * EPS)
    }),
    Law("det exp(f) = 1", all_angles, |f| ((exp(f).determinant() - 1.0).abs(), 8.0 * EPS)),
    Law("exp(f) f = f", all_angles, |f| (norm(&(exp(f) * f - f)), 6.0 * EPS * norm(f))),
    // J⁻¹ grows like 1/(2π − t).
    Law("J_r J_r⁻¹ = 1", all_angles, |f| {
        (difference(&(right_jacobian(f) * right_jacobian_inverse(f)), &ONE()), inverse_round_off(f))
    }),
    Law("J_l J_l⁻¹ = 1", all_angles, |f| {
        (difference(&(left_jacobian(f) * left_jacobian_inverse(f)), &ONE()), inverse_round_off(f))
    }),
    Law("J_l(f) = J_r(−f)", all_angles, |f| (difference(&left_jacobian(f), &right_jacobian(&-f)), 0.0)),
    Law("J_l = J_rᵀ", all_angles, |f| (difference(&left_jacobian(f), &right_jacobian(f).transpose()), 0.0)),
    Law("J_l = exp J_r", all_angles, |f| {
        (difference(&left_jacobian(f), &(exp(f) * right_jacobian(f))), 6.0 * EPS)
    }),
    Law("J_l⁻¹(f) = J_r⁻¹(−f)", all_angles, |f| {
        (difference(&left_jacobian_inverse(f), &right_jacobian_inverse(&-f)), 0.0)
    }),
    Law("J_l⁻¹ = J_r⁻ᵀ", all_angles, |f| {
        (difference(&left_jacobian_inverse(f), &right_jacobian_inverse(f).transpose()), 0.0)
    }),
    Law("J_l f = f", all_angles, |f| (norm(&(left_jacobian(f) * f - f)), 6.0 * EPS * norm(f))),
    Law(
        "D(0, v) = ½ S(v)",
        || vec![0.0, 1e-300, 1e-154, 1e-17],
        |f| {
            let v = Vector3::new(0.3, -0.7, 0.2);
            (difference(&right_jacobian_directional(f, &v), &(0.5 * hat(&v))), EPS)
        },
    ),
    Law("cay(tan(t/2) f/t) = exp f", angles, |f| {
        let half_tangent = f * if norm(f) < 1e-9 { 0.5 } else { (0.5 * norm(f)).tan() / norm(f) };
        (difference(&cayley(&half_tangent), &exp(f)), 8.0 * EPS)
    }),
    // The vector t/2 of a rotation near π grows without bound, and with it the condition: 1 + |f|².
    Law("cay⁻¹ cay f = f", cayley_sizes, |f| {
        let condition = 1.0 + norm(f).powi(2);
        (norm(&(cayley_inverse(&cayley(f)) - f)), 4.0 * EPS * norm(f) * condition.sqrt())
    }),
    // F − I = 2 S(f) (I − S(f))⁻¹: multiplied out, no cancellation on either side.
    Law(
        "(cay f − 1)(1 − S) = 2 S",
        || vec![1e-300, 1e-154, 1e-20, 1e-8, 1e-3, 0.3, 1.0, 3.0],
        |f| {
            let left = cayley_minus_identity(f) * (ONE() - hat(f));
            (difference(&left, &(2.0 * hat(f))), 4.0 * EPS * norm(f) * (1.0 + norm(f)))
        },
    ),
    Law("|q(R)| = 1", up_to_pi, |f| {
        let q = quaternion_from_rotation(&exp(f));
        ((q.iter().map(|part| part * part).sum::<f64>() - 1.0).abs(), 4.0 * EPS)
    }),
    Law("R(q(R)) = R", up_to_pi, |f| (of_multiple(f, 1.0), 8.0 * EPS)),
    Law("R(−q) = R(q)", up_to_pi, |f| (of_multiple(f, -1.0), 8.0 * EPS)),
    Law("R(5 q) = R(q)", up_to_pi, |f| (of_multiple(f, 5.0), 8.0 * EPS)),
    Law("|w| = |cos(t/2)|", up_to_pi, |f| {
        let q = quaternion_from_rotation(&exp(f));
        ((q[0].abs() - (0.5 * norm(f)).cos().abs()).abs(), 4.0 * EPS)
    }),
];

fn up_to_pi() -> Vec<f64> {
    [angles(), vec![PI]].concat()
}

fn cayley_sizes() -> Vec<f64> {
    vec![0.0, 1e-300, 1e-154, 1e-20, 1e-8, 1e-3, 0.3, 0.57735, 0.57736, 1.0, 1.7321, 3.0, 100.0]
}

fn inverse_round_off(f: &Vector3) -> f64 {
    6.0 * EPS * right_jacobian_inverse(f).amax().max(1.0)
}

/// Returns the distance of the rotation of a multiple of the quaternion of `exp f` from `exp f`.
fn of_multiple(f: &Vector3, factor: f64) -> f64 {
    let r = exp(f);
    difference(&rotation_from_quaternion(&quaternion_from_rotation(&r).map(|part| factor * part)), &r)
}

#[test]
fn every_law_holds_at_every_angle() {
    for Law(name, angles, defect) in &LAWS {
        for f in rotation_vectors(&angles()) {
            let (error, bound) = defect(&f);
            assert!(error <= bound, "{name} at {f:?}: off by {error:e}, round-off is {bound:e}");
        }
    }
}

/// The sign of w at π is round-off.
#[test]
fn vector_part_of_a_quaternion_is_half_the_rotation_vector_within_the_sine() {
    for f in rotation_vectors(&angles()).into_iter().filter(|f| norm(f) < PI) {
        let q = quaternion_from_rotation(&exp(&f));
        let half = 0.5 * norm(&f);
        let v = Vector3::new(q[1], q[2], q[3]) * q[0].signum();
        let sinc = if half < 1e-9 { 1.0 } else { half.sin() / half };
        assert!(norm(&(v - 0.5 * sinc * f)) <= 4.0 * EPS * norm(&f), "{v:?} for {f:?}");
    }
}

#[test]
fn hat_is_the_cross_product_and_vee_its_inverse() {
    let mut random = Random::new(2);
    for _ in 0..100 {
        let (a, b) = (random.vector(), random.vector());
        assert_eq!(hat(&a) * b, a.cross(&b));
        assert_eq!(vee(&hat(&a)), a);
        let symmetric = b * b.transpose();
        assert!((vee(&(hat(&a) + symmetric)) - a).amax() <= 2.0 * EPS, "vee takes the skew part");
    }
}

#[test]
fn exp_inverts_log() {
    let mut random = Random::new(3);
    for _ in 0..1000 {
        let r = random.rotation();
        assert_close(&exp(&log(&r)), &r, 8.0 * EPS, "exp log R");
    }
}

#[test]
fn log_of_a_half_turn_has_its_first_component_positive() {
    let mut random = Random::new(4);
    let mut axes = vec![
        Vector3::x(),
        Vector3::y(),
        Vector3::z(),
        Vector3::new(0.0, 0.6, -0.8),
        Vector3::new(1e-3, -1.0, 0.5).normalize(),
    ];
    axes.extend((0..200).map(|_| random.direction()));
    for axis in axes {
        let first = axis.iter().copied().find(|component| *component != 0.0).unwrap_or(1.0);
        let expected = axis * (PI * first.signum());
        for sign in [1.0, -1.0] {
            let found = log(&exp(&(axis * (PI * sign))));
            assert!((found - expected).norm() <= 6.0 * EPS * PI, "axis {axis:?}: {found:?}");
        }
        let exact = 2.0 * axis * axis.transpose() - Matrix3::identity();
        assert!((log(&exact) - expected).norm() <= 6.0 * EPS * PI, "symmetric R about {axis:?}");
    }
    // A first component of the size of round-off does not decide the sign.
    let almost = log(&rotation_from_quaternion(&[-1e-17, 1e-17, -0.6, -0.8]));
    assert!((almost - PI * Vector3::new(0.0, 0.6, 0.8)).norm() <= 6.0 * EPS * PI, "{almost:?}");
}

/// Returns `exp S(f)` in dual numbers, by the plain formula, which is accurate for angles that are
/// not small.
fn dual_exp(f: &nalgebra::SVector<DualSVec64<3>, 3>) -> nalgebra::SMatrix<DualSVec64<3>, 3, 3> {
    use num_dual::DualNum;
    let t = f.dot(f).sqrt();
    let s = f.cross_matrix();
    nalgebra::SMatrix::identity() + s * (t.sin() / t) + s * s * ((-t.cos() + 1.0) / (t * t))
}

/// Returns `J_r(f)` in dual numbers.
fn dual_right_jacobian(f: &nalgebra::SVector<DualSVec64<3>, 3>) -> nalgebra::SMatrix<DualSVec64<3>, 3, 3> {
    use num_dual::DualNum;
    let t = f.dot(f).sqrt();
    let s = f.cross_matrix();
    nalgebra::SMatrix::identity() - s * ((-t.cos() + 1.0) / (t * t)) + s * s * ((t - t.sin()) / t.powi(3))
}

/// Generic arguments for derivatives in dual numbers, angles 1 to 6.
fn generic_arguments() -> Vec<(Vector3, Vector3)> {
    let mut random = Random::new(5);
    (0..200).map(|i| (random.direction() * (1.0 + 0.025 * i as f64), random.vector())).collect()
}

#[test]
fn right_jacobian_is_the_body_side_derivative_of_exp() {
    for (f, _) in generic_arguments() {
        let dual = dual_exp(&nalgebra::SVector::from_fn(|i, _| DualSVec64::from_re(f[i]).derivative(i)));
        for i in 0..3 {
            let along = dual.map(|entry| entry.eps.unwrap_generic(nalgebra::Const::<3>, nalgebra::U1)[i]);
            let body = vee(&(exp(&f).transpose() * along));
            let error = (body - right_jacobian(&f).column(i)).amax();
            assert!(error <= 2e-15, "column {i} at {f:?}: {error:e}");
        }
    }
}

#[test]
fn directional_derivative_of_the_right_jacobian_agrees_with_dual_numbers() {
    for (f, v) in generic_arguments() {
        let dual =
            dual_right_jacobian(&nalgebra::SVector::from_fn(|i, _| DualSVec64::from_re(f[i]).derivative(i)));
        let image = dual * v.map(DualSVec64::from_re);
        let expected =
            Matrix3::from_fn(|i, j| image[i].eps.unwrap_generic(nalgebra::Const::<3>, nalgebra::U1)[j]);
        assert_close(&right_jacobian_directional(&f, &v), &expected, 4e-15, "D(f, v)");
    }
}

#[test]
fn cayley_solves_its_defining_equation() {
    let mut random = Random::new(6);
    for _ in 0..200 {
        let s = hat(&(2.0 * random.vector()));
        let one = Matrix3::identity();
        assert_close(&(cayley(&vee(&s)) * (one - s)), &(one + s), 2e-15, "cay(f) (I − S) = I + S");
    }
}

#[test]
fn projection_finds_the_nearest_rotation() {
    let mut random = Random::new(7);
    for size in [0.0, 1e-15, 1e-10, 1e-6, 1e-3, 0.1] {
        for _ in 0..50 {
            let r = random.rotation();
            assert_close(&project_to_rotation(&r), &r, 8.0 * EPS, "a rotation stays");
            // R P with P symmetric positive definite has the polar factor R.
            let a = Matrix3::from_fn(|_, _| random.uniform());
            let stretched = r * (Matrix3::identity() + size * (a + a.transpose()));
            let found = project_to_rotation(&stretched);
            assert_close(&found, &r, 8.0 * EPS, "polar factor");
            assert_close(&(found.transpose() * found), &Matrix3::identity(), 6.0 * EPS, "orthogonal");
        }
    }
}

#[test]
fn kernels_of_what_is_not_a_number_return() {
    let nan = Vector3::new(f64::NAN, 0.0, 1.0);
    let matrix = Matrix3::from_element(f64::NAN);
    assert!(exp(&nan).iter().any(|x| x.is_nan()));
    assert!(log(&matrix).iter().all(|x| x.is_nan()));
    assert!(cayley_inverse(&matrix).iter().all(|x| x.is_nan()));
    assert!(project_to_rotation(&matrix).iter().all(|x| x.is_nan()));
    assert!(!project_to_rotation(&Matrix3::zeros()).iter().any(|x| x.is_finite()));
}

#[test]
fn kernels_agree_with_the_reference_vectors() {
    let file = reference("so3");
    for case in list(&file["cases"]) {
        let f = vector(&case["f"]);
        assert_close(&exp(&f), &matrix3(&case["exp"]), 1e-15, "exp");
        let error = norm(&(log(&exp(&f)) - vector(&case["log_of_exp"])));
        assert!(error <= 1e-15 * norm(&f), "log at {f:?}: {error:e}");
        assert_close(&right_jacobian(&f), &matrix3(&case["Jr"]), 1e-15, "J_r");
        assert_close(&right_jacobian_inverse(&f), &matrix3(&case["Jr_inv"]), 2e-15, "J_r⁻¹");
        assert_close(&cayley(&f), &matrix3(&case["cay"]), 1e-15, "cay");
        let d = right_jacobian_directional(&f, &vector(&case["v"]));
        assert_close(&d, &matrix3(&case["dJr_v"]), 1e-15, "D(f, v)");
    }
}

#[test]
fn log_agrees_with_the_reference_half_turns() {
    let file = reference("so3");
    let cases = list(&file["angle_pi"]);
    assert_eq!(cases.len(), 5);
    for case in cases {
        let (found, expected) = (log(&matrix3(&case["R"])), vector(&case["log_up_to_sign"]));
        let error = (found - expected).norm().min((found + expected).norm());
        assert!(error <= 2e-15, "{expected:?}: {found:?}");
        let first = found.iter().find(|component| **component != 0.0);
        assert!(first.is_some_and(|component| *component > 0.0), "sign of {found:?}");
    }
}

/// `b exp S(a ⊖ b) = a`, for rotations from any constructor.
#[test]
fn differences_of_rotations_lead_from_one_to_the_other() {
    let mut random = Random::new(31);
    for _ in 0..200 {
        let (a, b) = (Rotation::exp(&(2.0 * random.vector())), Rotation::exp(&(2.0 * random.vector())));
        assert_close((b * Rotation::exp(&a.minus(&b))).matrix(), a.matrix(), 1e-14, "b exp(a ⊖ b)");
        assert_eq!(a.minus(&b), (b.inverse() * a).log());
        // The same turn, seen from either end.
        assert!(norm(&(a.minus(&b) + b.minus(&a))) < 1e-13);
        let (quaternion, rotation) = (nalgebra::UnitQuaternion::from(a), nalgebra::Rotation3::from(a));
        assert!(norm(&Rotation::from(quaternion).minus(&a)) < 1e-14);
        assert_eq!(Rotation::from(rotation), a);
        assert!(norm(&Rotation::from_quaternion(&a.quaternion().map(|part| -3.0 * part)).minus(&a)) < 1e-14);
    }
}

#[test]
fn what_is_no_rotation_is_refused() {
    let turn = exp(&Vector3::new(0.3, -1.0, 0.2));
    assert_eq!(Rotation::new(turn).unwrap().matrix(), &turn);
    assert!((Rotation::new(1.1 * turn).unwrap_err().defect - 0.21 * 3.0_f64.sqrt()).abs() < 1e-14);
    assert_eq!(Rotation::new(-turn).unwrap_err().defect, 2.0);
    assert!(Rotation::new(turn * f64::NAN).unwrap_err().defect.is_nan());
}
