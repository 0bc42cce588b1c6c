//! The implicit attitude equation `h S(Π) = F J_d − J_d Fᵀ` (2.1, 4.5), in Cayley form.
//!
//! With `F = cay(c)` and `g = hΠ` the equation is the polynomial (2.6)
//!
//! ```text
//! G(c) = g + g×c + (g·c) c − 2Jc = 0,     ∇G = S(g) + (g·c) I + c gᵀ − 2J
//! ```
//!
//! The physical solution, the one connected to `F = I`, turns less than 90° a step, `|c| < 1`. It
//! exists and is unique whenever `|J⁻¹g| < 1` (numerical evidence; the bound is sharp on the axes).

use crate::{Matrix3, Vector3};

/// Bound on the product of the two corrections of an iteration. The residual that remains,
/// `(g·δ₁) δ₂ + (g·δ₂) δ₁ + …`, is then below an ulp of `g`.
const LEFT: f64 = 5e-17;

/// The largest correction after which plain Newton stops. The convergence is quadratic: a
/// correction `Δ` leaves a relative error of about `|Δ|²`. The bound has a margin for
/// ill-conditioned inertias.
const LAST_CORRECTION: f64 = 2e-9;

/// Maximum number of iterations. Newton's method needs 2–3 in the survey by Leok. At 0.99 of the
/// bound on the step 6 were measured; after twice that number the solve fails.
const MAX_ITERATIONS: u32 = 12;

/// Solves for the Cayley vector `c` of one step. Returns `None` if no physical solution exists:
/// the step is too long for this momentum, or a number is not finite.
#[inline(always)]
pub(crate) fn solve(j: &Matrix3, j_inverse: &Matrix3, g: &Vector3) -> Option<Vector3> {
    solve_counting(j, j_inverse, g).map(|(c, _)| c)
}

/// Solves for the Cayley vector of one step as [`solve`] does, and also returns the number of
/// Newton iterations.
#[inline(always)]
pub(crate) fn solve_counting(j: &Matrix3, j_inverse: &Matrix3, g: &Vector3) -> Option<(Vector3, u32)> {
    // One pass of the fixed-point iteration c = ½J⁻¹(g + g×c + (g·c)c): error O(|c|³).
    let start = 0.5 * (j_inverse * g);
    let c = 0.5 * (j_inverse * (g + g.cross(&start) + start * g.dot(&start)));
    match chebyshev(j, g, c) {
        Some(root) => Some(root),
        None => from_plain_start(j, j_inverse, g),
    }
}

/// Solves as [`solve_counting`] does, starting from the guess `c`. Also returns `None` if the
/// iteration does not converge from this guess.
#[inline(always)]
pub(crate) fn solve_from(j: &Matrix3, g: &Vector3, c: Vector3) -> Option<(Vector3, u32)> {
    // A guess that is NaN fails at once.
    if c.x.is_nan() { None } else { chebyshev(j, g, c) }
}

/// Runs Newton's method with the second-order correction of Chebyshev. `G` is quadratic in `c`, so
/// the residual after a Newton correction `δ₁` is exactly `(g·δ₁) δ₁`, and `δ₂ = (−∇G)⁻¹ (g·δ₁) δ₁`
/// needs the same inverse. The iteration is of third order with one division, and most of the
/// additional work is done while the processor waits for this division.
#[inline(always)]
fn chebyshev(j: &Matrix3, g: &Vector3, mut c: Vector3) -> Option<(Vector3, u32)> {
    for iteration in 1..=MAX_ITERATIONS {
        let (residual, a) = equation(j, g, &c);
        let (c0, c1, c2) = (a.column(0), a.column(1), a.column(2));
        let (r0, r1, r2) = (c1.cross(&c2), c2.cross(&c0), c0.cross(&c1));
        let inverse = 1.0 / c0.dot(&r0);
        // δ₁ = q/det, δ₂ = q₂/det³.
        let q = Vector3::new(r0.dot(&residual), r1.dot(&residual), r2.dot(&residual));
        let bend = q * g.dot(&q);
        let q2 = Vector3::new(r0.dot(&bend), r1.dot(&bend), r2.dot(&bend));
        let (first, second) = (q * inverse, q2 * (inverse * inverse * inverse));
        c += first + second;
        if second.amax() * first.amax() <= LEFT {
            return (c.norm_squared() < 1.0).then_some((c, iteration));
        }
    }
    None
}

/// Returns the residual `G(c)` of the equation, and its negative derivative `−∇G`.
#[inline(always)]
fn equation(j: &Matrix3, g: &Vector3, c: &Vector3) -> (Vector3, Matrix3) {
    let gc = g.dot(c);
    let residual = g + g.cross(c) + c * gc - 2.0 * (j * c);
    let mut a = 2.0 * j - c * g.transpose();
    a[(0, 0)] -= gc;
    a[(1, 1)] -= gc;
    a[(2, 2)] -= gc;
    a[(0, 1)] += g.z;
    a[(1, 0)] -= g.z;
    a[(0, 2)] -= g.y;
    a[(2, 0)] += g.y;
    a[(1, 2)] += g.x;
    a[(2, 1)] -= g.x;
    (residual, a)
}

/// Solves a large step of a thin rod or plate, for which the fixed-point iteration diverges.
/// Newton's method then converges from `c = ½J⁻¹g`, without a pass of that iteration. The function
/// is not inlined, so that the common path is short and stays in registers.
#[cold]
#[inline(never)]
fn from_plain_start(j: &Matrix3, j_inverse: &Matrix3, g: &Vector3) -> Option<(Vector3, u32)> {
    newton(j, g, 0.5 * (j_inverse * g))
}

/// Runs Newton's method, without the correction of Chebyshev, from the start `c`.
pub(crate) fn newton(j: &Matrix3, g: &Vector3, mut c: Vector3) -> Option<(Vector3, u32)> {
    for iteration in 1..=MAX_ITERATIONS {
        let (residual, a) = equation(j, g, &c);
        let correction = solve3(&a, &residual);
        c += correction;
        if correction.amax() <= LAST_CORRECTION {
            return (c.norm_squared() < 1.0).then_some((c, iteration));
        }
    }
    None
}

/// Returns `a⁻¹ b` by cofactors. A singular matrix gives infinities, which the checks of the
/// callers reject.
#[inline(always)]
pub(crate) fn solve3(a: &Matrix3, b: &Vector3) -> Vector3 {
    let (c0, c1, c2) = (a.column(0), a.column(1), a.column(2));
    let c12 = c1.cross(&c2);
    let inverse_determinant = 1.0 / c0.dot(&c12);
    Vector3::new(b.dot(&c12), c0.dot(&b.cross(&c2)), c0.dot(&c1.cross(b))) * inverse_determinant
}

/// Returns the inverse `a⁻¹` by cofactors.
#[inline(always)]
pub(crate) fn inverse3(a: &Matrix3) -> Matrix3 {
    let (c0, c1, c2) = (a.column(0), a.column(1), a.column(2));
    let (r0, r1, r2) = (c1.cross(&c2), c2.cross(&c0), c0.cross(&c1));
    let inverse_determinant = 1.0 / c0.dot(&r0);
    Matrix3::from_rows(&[r0.transpose(), r1.transpose(), r2.transpose()]) * inverse_determinant
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_the_bound_there_is_no_solution() {
        let j = Matrix3::from_diagonal(&Vector3::new(2.0, 1.6, 1.1));
        let j_inverse = j.try_inverse().unwrap();
        for (factor, solvable) in [(0.999, true), (1.001, false)] {
            let g = Vector3::new(0.0, 0.0, 1.1 * factor);
            assert_eq!(solve(&j, &j_inverse, &g).is_some(), solvable);
        }
        assert!(solve(&j, &j_inverse, &Vector3::repeat(f64::NAN)).is_none());
    }
}
