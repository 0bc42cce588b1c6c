//! Coefficients of the maps on SO(3), as functions of `t² = |f|²`.
//!
//! ```text
//! A = sin t/t      B = (1 − cos t)/t²      C = (t − sin t)/t³      primes: d/d(t²)
//! A' = (t cos t − sin t)/(2t³)             B' = (t sin t − 2(1 − cos t))/(2t⁴)
//! C' = (3 sin t − 2t − t cos t)/(2t⁵)      g = (1 − (t/2) cot(t/2))/t²
//! ```
//!
//! The closed forms of `C` and the primes cancel for small `t`; their Taylor series are entire and
//! serve up to just beyond π, from where the closed forms lose nothing. `t²` may underflow to zero.

/// Series below, closed form above. `C'` still loses a digit at `t = 2` and nothing at π.
pub(super) const SWITCH: f64 = 10.0;

/// Terms of each series: the first one left out is below 1e-18 of the sum at the switch.
const TERMS: usize = 16;

/// Taylor coefficients of `Σ (−1)ᵏ xᵏ/(2k + offset)!`, or of its derivative with respect to `x`.
const fn taylor(offset: usize, derivative: bool) -> [f64; TERMS] {
    let mut coefficients = [0.0; TERMS];
    let (mut factorial, mut n) = (1.0, 1);
    while n <= offset {
        factorial *= n as f64;
        n += 1;
    }
    let (mut k, mut sign) = (0, 1.0);
    while k <= TERMS {
        if derivative && k > 0 {
            coefficients[k - 1] = sign * k as f64 / factorial;
        } else if !derivative && k < TERMS {
            coefficients[k] = sign / factorial;
        }
        sign = -sign;
        factorial *= (n * (n + 1)) as f64;
        n += 2;
        k += 1;
    }
    coefficients
}

const C: [f64; TERMS] = taylor(3, false);
const A_PRIME: [f64; TERMS] = taylor(1, true);
const B_PRIME: [f64; TERMS] = taylor(2, true);
const C_PRIME: [f64; TERMS] = taylor(3, true);

/// `Σ cₖ xᵏ`.
fn horner(coefficients: &[f64; TERMS], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// `A = sin t/t`.
pub(super) fn a(t2: f64) -> f64 {
    let t = t2.sqrt();
    // Also guards the division: below this, 1 − t²/6 rounds to 1.
    if t < 1e-8 { 1.0 } else { t.sin() / t }
}

/// `B = (1 − cos t)/t² = ½ (sin(t/2)/(t/2))²`.
pub(super) fn b(t2: f64) -> f64 {
    0.5 * a(0.25 * t2).powi(2)
}

/// `C = (t − sin t)/t³`.
pub(super) fn c(t2: f64) -> f64 {
    if t2 < SWITCH {
        horner(&C, t2)
    } else {
        let t = t2.sqrt();
        (t - t.sin()) / (t * t2)
    }
}

/// `A' = (t cos t − sin t)/(2t³)`.
pub(super) fn a_prime(t2: f64) -> f64 {
    if t2 < SWITCH {
        horner(&A_PRIME, t2)
    } else {
        let t = t2.sqrt();
        (t * t.cos() - t.sin()) / (2.0 * t * t2)
    }
}

/// `B' = (t sin t − 2(1 − cos t))/(2t⁴)`.
pub(super) fn b_prime(t2: f64) -> f64 {
    if t2 < SWITCH {
        horner(&B_PRIME, t2)
    } else {
        let t = t2.sqrt();
        (t * t.sin() - 2.0 * (1.0 - t.cos())) / (2.0 * t2 * t2)
    }
}

/// `C' = (3 sin t − 2t − t cos t)/(2t⁵)`.
pub(super) fn c_prime(t2: f64) -> f64 {
    if t2 < SWITCH {
        horner(&C_PRIME, t2)
    } else {
        let t = t2.sqrt();
        (3.0 * t.sin() - t * (2.0 + t.cos())) / (2.0 * t * t2 * t2)
    }
}

/// `g = (1 − (t/2) cot(t/2))/t² = −A'(t/2)/(2 A(t/2))`, the second form free of cancellation.
///
/// Infinite at `t = 2π`.
pub(super) fn g(t2: f64) -> f64 {
    -0.5 * a_prime(0.25 * t2) / a(0.25 * t2)
}
