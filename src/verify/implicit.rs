//! The implicit attitude equation of a step in its exponential form.
//!
//! ```text
//! h S(Π) = F J_d − J_d Fᵀ,  F = exp S(f)    ⇔    G(f) = A Jf + B f×(Jf) = hΠ              (2.3)
//! ∇G = A J + 2A' (Jf) fᵀ + 2B' (f×Jf) fᵀ + B {S(f) J − S(Jf)}                              (2.4)
//! A = sin t/t,  B = (1 − cos t)/t²,  t = |f|,  primes: d/d(t²)
//! ```
//!
//! Wheels that store the momentum μ add a term to the equation, which comes from the term `2 c·μ`
//! of the discrete Lagrangian. Here `c = K f`, with `K = tan(t/2)/t = B/A`, is the Cayley vector of
//! `F`:
//!
//! ```text
//! h S(Π + μ − (I + S(c) + c cᵀ) μ) = F J_d − J_d Fᵀ   ⇔   G(f) + K f×hμ + K² f (f·hμ) = hΠ
//! its derivative:  −K S(hμ) + 2K' (f×hμ) fᵀ + K² {(f·hμ) I + f hμᵀ} + 4KK' (f·hμ) f fᵀ
//! ```
//!
//! The planner solves the same equation with other code, through the Cayley map. The physical root
//! is the one that turns the body by less than 90° in a step (theory: `tr F > 1`); other roots are
//! rejected.

use crate::lie::hat;
use crate::mechanics::body::Inertia;
use crate::{Matrix3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Largest number of Newton iterations. 2 to 4 suffice below 0.6 rad; more are needed only near the
/// limit of existence.
const MAX_ITERATIONS: usize = 40;

/// Number of terms of the series. The first omitted term is below 1e-19 at `t = 1.7`, which is
/// beyond the physical root.
const TERMS: usize = 12;

/// Returns the coefficients of `Σ (−1)ᵏ xᵏ/(2k + offset)!`: `A` for offset 1, `B` for offset 2.
const fn series(offset: usize) -> [f64; TERMS] {
    let mut terms = [0.0; TERMS];
    let (mut k, mut term) = (0, if offset == 1 { 1.0 } else { 0.5 });
    while k < TERMS {
        terms[k] = term;
        k += 1;
        term /= -(((2 * k + offset - 1) * (2 * k + offset)) as f64);
    }
    terms
}

/// Number of terms that suffice if `t² < FEW_BELOW`: the first omitted term is below 1e-17 of the
/// sum.
const FEW: usize = 6;
const FEW_BELOW: f64 = 0.05;

/// Threshold on the bound `cond(J) e²` of the error after a Newton step, relative to f, for an
/// error e before the step. It is well below round-off.
const LEFT: f64 = 1e-17;
/// Angle per step \[rad\] up to which the bound is valid.
const BOUNDED: f64 = 0.3;

const A: [f64; TERMS] = series(1);
const B: [f64; TERMS] = series(2);

/// Returns the sum of a series and its derivative at `x`, with as many terms as `x` requires.
#[inline(always)]
fn horner(terms: &[f64; TERMS], x: f64) -> (f64, f64) {
    match terms.first_chunk::<FEW>() {
        Some(few) if x < FEW_BELOW => polynomial(few, x),
        _ => polynomial(terms, x),
    }
}

/// Returns a polynomial and its derivative at `x`. The number of terms is a constant, so that the
/// compiler unrolls the loop.
#[inline(always)]
fn polynomial<const K: usize>(terms: &[f64; K], x: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for term in terms.iter().rev() {
        slope = slope * x + value;
        value = value * x + term;
    }
    (value, slope)
}

/// Returns `matrix⁻¹ right` by Cramer's rule; not finite if the matrix is singular.
#[inline(always)]
fn cramer(matrix: &Matrix3, right: &Vector3) -> Vector3 {
    let [a, b, c] = [0, 1, 2].map(|column| Vector3::from(matrix.column(column)));
    let (across, along) = (b.cross(&c), right.cross(&a));
    Vector3::new(right.dot(&across), -along.dot(&c), along.dot(&b)) / a.dot(&across)
}

/// The implicit equation for one body, in units of its mean principal moment.
#[derive(Clone, Debug)]
pub(crate) struct Implicit {
    j: Matrix3,
    j_inverse: Matrix3,
    mean: f64,
    /// Upper bound of the condition number of the inertia.
    condition: f64,
}

impl Implicit {
    pub(crate) fn new(inertia: &Inertia) -> Self {
        let mean = inertia.mean();
        let condition = 9.0 * inertia.j().amax() * inertia.j_inverse().amax();
        Self { j: inertia.j() / mean, j_inverse: inertia.j_inverse() * mean, mean, condition }
    }

    /// Returns the rotation vector `f` of a step for `g = hΠ` and a wheel momentum of `spin = hμ`;
    /// `None` if no physical solution exists.
    pub(crate) fn solve(&self, g: &Vector3, spin: &Vector3) -> Option<Vector3> {
        let (g, spin) = (g / self.mean, spin / self.mean);
        let spins = spin != Vector3::zeros();
        if g == Vector3::zeros() {
            return Some(g);
        }
        let mut f = if spins {
            // The initial guess solves the linear equation; J plus a skew matrix is never singular.
            (self.j - 0.5 * hat(&spin)).lu().solve(&g)?
        } else {
            let f0 = self.j_inverse * g;
            self.j_inverse * (g - 0.5 * f0.cross(&g))
        };
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let jf = self.j * f;
            let fjf = f.cross(&jf);
            let x = f.norm_squared();
            let ((a, da), (b, db)) = (horner(&A, x), horner(&B, x));
            let mut residual = g - (a * jf + b * fjf);
            // The derivative, column by column: column i of S(f) J is f × J_i, column i of S(Jf) is
            // Jf × e_i.
            let bend = 2.0 * (da * jf + db * fjf);
            let column = |i: usize| {
                let column = Vector3::from(self.j.column(i));
                a * column + bend * f[i] + b * (f.cross(&column) - jf.cross(&Vector3::ith(i, 1.0)))
            };
            let mut slope = Matrix3::from_columns(&[0, 1, 2].map(column));
            if spins {
                let (k, dk) = (b / a, (db * a - b * da) / (a * a));
                let (across, along) = (f.cross(&spin), f.dot(&spin));
                residual -= k * across + k * k * along * f;
                slope += k * k * (along * Matrix3::identity() + f * spin.transpose()) - k * hat(&spin)
                    + (2.0 * dk * across + 4.0 * k * dk * along * f) * f.transpose();
            }
            let step = cramer(&slope, &residual);
            let change = step.norm();
            if !change.is_finite() {
                return None;
            }
            f += step;
            // At round-off the changes stop shrinking. If the inertia is ill-conditioned this
            // happens above 4 ulps of f, with an equally small residual.
            let size = g.amax().max(spin.norm() * f.norm());
            let stagnates = change >= 0.5 * last && residual.amax() <= 64.0 * f64::EPSILON * size;
            let norm = f.norm();
            let predicted = !spins && norm < BOUNDED && self.condition * change * change <= LEFT * norm;
            if change <= 4.0 * f64::EPSILON * norm || predicted || stagnates {
                return (norm < FRAC_PI_2).then_some(f);
            }
            // Beyond the physical root, series and equation have no meaning, so f is shortened.
            if norm > 1.6 {
                f *= 1.6 / norm;
            }
            last = change;
        }
        None
    }
}

/// Returns `exp S(f) − I` without the cancellation that a later subtraction of `I` would cause.
pub(crate) fn exp_minus_identity(f: &Vector3) -> Matrix3 {
    let x = f.norm_squared();
    let s = hat(f);
    let square = f * f.transpose() - Matrix3::from_diagonal_element(x);
    horner(&A, x).0 * s + horner(&B, x).0 * square
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(value: &serde_json::Value) -> Vec<f64> {
        match value {
            serde_json::Value::Array(items) => items.iter().flat_map(numbers).collect(),
            number => vec![number.as_f64().unwrap()],
        }
    }

    /// Tests every inertia and angle of the reference file, up to 0.9999 of the limit of existence.
    #[test]
    fn exponential_form_finds_the_reference_rotations() {
        let text = include_str!("../../tests/reference/implicit.json");
        let reference: serde_json::Value = serde_json::from_str(text).unwrap();
        let cases = reference["cases"].as_array().unwrap();
        assert!(cases.len() > 30);
        for (index, case) in cases.iter().enumerate() {
            let j = Matrix3::from_row_slice(&numbers(&case["J"]));
            let h = case["h"].as_f64().unwrap();
            let momentum = Vector3::from_row_slice(&numbers(&case["Pi"]));
            let expected = Vector3::from_row_slice(&numbers(&case["f"]));
            let rotation = Matrix3::from_row_slice(&numbers(&case["F"]));
            let f =
                Implicit::new(&Inertia::new(j).unwrap()).solve(&(h * momentum), &Vector3::zeros()).unwrap();
            // At the limit of existence the derivative is nearly singular, which halves the number
            // of digits.
            let tolerance = if expected.norm() > 1.5 { 1e-6 } else { 1e-14 };
            assert!((f - expected).norm() <= tolerance * expected.norm(), "case {index}: {f} {expected}");
            let error = (exp_minus_identity(&f) + Matrix3::identity() - rotation).amax();
            assert!(error <= tolerance.max(1e-15), "case {index}: {error:e}");
        }
    }

    /// Of the roots of the implicit attitude equation, only the one with a rotation below 90° per
    /// step is physical. If the momentum is too large for such a root, `solve` returns `None`.
    #[test]
    fn beyond_the_limit_of_existence_there_is_no_rotation() {
        let implicit = Implicit::new(&Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5)).unwrap());
        let solve = |g: Vector3| implicit.solve(&g, &Vector3::zeros());
        assert!(solve(Vector3::new(0.0, 0.0, 2.499)).is_some());
        for g in [2.51, 3.0, 10.0, 1e3, 1e300] {
            assert_eq!(solve(Vector3::new(0.0, 0.0, g)), None, "{g}");
            assert_eq!(solve(g * Vector3::new(0.6, 0.5, 0.7)), None, "{g}");
        }
        assert_eq!(solve(Vector3::new(0.0, f64::NAN, 0.1)), None);
        assert_eq!(solve(Vector3::zeros()), Some(Vector3::zeros()));
    }

    /// Tiny steps keep their relative accuracy: `f → J⁻¹g`, and adding `I` does not remove the
    /// increment.
    #[test]
    fn tiny_steps_keep_all_digits() {
        let implicit = Implicit::new(&Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5)).unwrap());
        for size in [1e-300, 1e-30, 1e-12] {
            let f = implicit.solve(&(size * Vector3::new(0.3, -0.4, 0.5)), &Vector3::zeros()).unwrap();
            let expected = size * Vector3::new(0.3, -0.2, 0.2);
            assert!((f - expected).amax() <= 1e-11 * size, "{size:e}: {f}");
            assert!((exp_minus_identity(&f)[(1, 0)] - f.z).abs() <= 1e-11 * size);
        }
    }

    /// Tests wheels about a principal axis with the scalar equation
    /// `J sin t + (1 + tan²(t/2)) hμ = hH`. The wheel momenta have any size and sign, and may be
    /// much larger than the momentum of the body. The equation itself is tested in all directions.
    #[test]
    fn wheels_on_a_principal_axis_are_a_scalar_equation() {
        let j = Vector3::new(1.0, 2.0, 2.5);
        let implicit = Implicit::new(&Inertia::diagonal(j).unwrap());
        for spin in [1e-12, -0.3, 0.7, 4.0, -1e3] {
            for angle in [1e-9, 0.1, -0.4, 0.9] {
                let t: f64 = angle;
                let g = 2.0 * t.sin() + (t / 2.0).tan().powi(2) * spin;
                let solved = implicit.solve(&Vector3::new(0.0, g, 0.0), &Vector3::new(0.0, spin, 0.0));
                let monotone = 2.0 * t.cos() + (t / 2.0).tan() / (t / 2.0).cos().powi(2) * spin > 0.0;
                // Beyond the turning point of the scalar equation the angle is not the physical
                // solution.
                if monotone && spin.abs() < 100.0 {
                    let f = solved.unwrap_or_else(|| panic!("{spin} {angle}"));
                    assert!(
                        (f - Vector3::new(0.0, t, 0.0)).amax() <= 1e-14 * t.abs().max(1e-2),
                        "{spin} {angle}: {f}"
                    );
                }
            }
        }
        let j = Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1);
        let implicit = Implicit::new(&Inertia::new(j).unwrap());
        let j_d = 0.5 * j.trace() * Matrix3::identity() - j;
        for (g, spin) in [
            (Vector3::new(0.3, -0.5, 0.2), Vector3::new(0.2, 0.1, -0.4)),
            (Vector3::new(0.3, -0.5, 0.2), Vector3::new(2.0, -5.0, 3.0)),
            (Vector3::new(0.01, 0.02, -0.03), Vector3::new(-200.0, 50.0, 30.0)),
        ] {
            let f = implicit.solve(&g, &spin).unwrap();
            let turn = exp_minus_identity(&f) + Matrix3::identity();
            let c = crate::lie::cayley_inverse(&turn);
            let left = g - (c.cross(&spin) + c * c.dot(&spin));
            let skew = turn * j_d - j_d * turn.transpose();
            let error = (hat(&left) - skew).amax();
            assert!(error <= 1e-15 * (1.0 + spin.norm() * f.norm()) * 4.0, "{g} {spin}: {error:e}");
        }
    }
}
