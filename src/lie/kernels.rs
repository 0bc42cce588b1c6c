//! Coefficients of the maps on SO(3), as functions of `t² = |f|²` for a rotation vector `f`.
//!
//! ```text
//! A = sin t/t      B = (1 − cos t)/t²      C = (t − sin t)/t³      primes: d/d(t²)
//! A' = (t cos t − sin t)/(2t³)             B' = (t sin t − 2(1 − cos t))/(2t⁴)
//! C' = (3 sin t − 2t − t cos t)/(2t⁵)      g = (1 − (t/2) cot(t/2))/t²
//! A'' = (3 sin t − 3t cos t − t² sin t)/(4t⁵)
//! ```
//!
//! The closed forms of `C` and of the derivatives cancel for small `t`. Their Taylor series
//! converge everywhere and are used up to just beyond π, above which the closed forms are accurate.
//! `t²` may underflow to zero.

/// The value of `t²` below which the series is used, and above which the closed form. The closed
/// form of `C'` still loses a digit at `t = 2`, and nothing at π.
pub(super) const SWITCH: f64 = 10.0;

/// The number of terms of each series: at the switch the first omitted term is below 1e-18 of the
/// sum.
const TERMS: usize = 16;

/// Returns the Taylor coefficients of the derivative of order `derivative` of
/// `Σ (−1)ᵏ xᵏ/(2k + offset)!` with respect to `x`.
const fn taylor(offset: usize, derivative: usize) -> [f64; TERMS] {
    let mut coefficients = [0.0; TERMS];
    let (mut factorial, mut n) = (1.0, 1);
    while n <= offset {
        factorial *= n as f64;
        n += 1;
    }
    let (mut k, mut sign) = (0, 1.0);
    while k < TERMS + derivative {
        if k >= derivative {
            let (mut falling, mut m) = (1.0, k - derivative + 1);
            while m <= k {
                falling *= m as f64;
                m += 1;
            }
            coefficients[k - derivative] = sign * falling / factorial;
        }
        sign = -sign;
        factorial *= (n * (n + 1)) as f64;
        n += 2;
        k += 1;
    }
    coefficients
}

const B: [f64; TERMS] = taylor(2, 0);
const C: [f64; TERMS] = taylor(3, 0);
const A_PRIME: [f64; TERMS] = taylor(1, 1);
const A_SECOND: [f64; TERMS] = taylor(1, 2);
const B_PRIME: [f64; TERMS] = taylor(2, 1);
const C_PRIME: [f64; TERMS] = taylor(3, 1);
const B_SECOND: [f64; TERMS] = taylor(2, 2);
const C_SECOND: [f64; TERMS] = taylor(3, 2);

const SECOND: [[f64; TERMS]; 6] = [B, C, B_PRIME, C_PRIME, B_SECOND, C_SECOND];

/// The number of terms that suffice for `x < 1`, where the first omitted term is below 1e-17.
const FEW: usize = 9;

/// Returns the polynomial `Σ cₖ xᵏ`.
fn horner(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Returns the coefficient `A = sin t/t`.
pub(super) fn a(t2: f64) -> f64 {
    let t = t2.sqrt();
    // This also guards the division: below the threshold, 1 − t²/6 rounds to 1.
    if t < 1e-8 { 1.0 } else { t.sin() / t }
}

/// Returns the coefficient `B = (1 − cos t)/t² = ½ (sin(t/2)/(t/2))²`.
pub(super) fn b(t2: f64) -> f64 {
    0.5 * a(0.25 * t2).powi(2)
}

/// Returns the series below the switch, and the closed form as a function of `t` above.
fn switched(series: &[f64], t2: f64, closed: impl Fn(f64) -> f64) -> f64 {
    if t2 < SWITCH { horner(series, t2) } else { closed(t2.sqrt()) }
}

/// Returns the coefficient `C = (t − sin t)/t³`.
pub(super) fn c(t2: f64) -> f64 {
    switched(&C, t2, |t| (t - t.sin()) / (t * t2))
}

/// Returns the coefficient `A' = (t cos t − sin t)/(2t³)`.
pub(super) fn a_prime(t2: f64) -> f64 {
    switched(&A_PRIME, t2, |t| (t * t.cos() - t.sin()) / (2.0 * t * t2))
}

/// Returns the coefficient `B' = (t sin t − 2(1 − cos t))/(2t⁴)`.
pub(super) fn b_prime(t2: f64) -> f64 {
    switched(&B_PRIME, t2, |t| (t * t.sin() - 2.0 * (1.0 - t.cos())) / (2.0 * t2 * t2))
}

/// Returns the coefficient `C' = (3 sin t − 2t − t cos t)/(2t⁵)`.
pub(super) fn c_prime(t2: f64) -> f64 {
    switched(&C_PRIME, t2, |t| (3.0 * t.sin() - t * (2.0 + t.cos())) / (2.0 * t * t2 * t2))
}

/// Returns the coefficient `g = (1 − (t/2) cot(t/2))/t² = −A'(t/2)/(2 A(t/2))`. The second form has
/// no cancellation.
///
/// The result is infinite at `t = 2π`.
pub(super) fn g(t2: f64) -> f64 {
    -0.5 * a_prime(0.25 * t2) / a(0.25 * t2)
}

/// Returns `A''`, the second derivative of `A` with respect to `t²`.
fn a_second(t2: f64) -> f64 {
    switched(&A_SECOND, t2, |t| ((3.0 - t2) * t.sin() - 3.0 * t * t.cos()) / (4.0 * t * t2 * t2))
}

/// Returns the derivative `g' = dg/d(t²) = ⅛ ((A'/A)² − A''/A)`, with `A` and its derivatives at
/// `t/2`.
pub(super) fn g_prime(t2: f64) -> f64 {
    let quarter = 0.25 * t2;
    let (a, first) = (a(quarter), a_prime(quarter));
    0.125 * (first * first / a - a_second(quarter)) / a
}

/// `B`, `C` and their first two derivatives with respect to `t²`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Second {
    pub b: f64,
    pub c: f64,
    pub b_prime: f64,
    pub c_prime: f64,
    pub b_second: f64,
    pub c_second: f64,
}

impl Second {
    /// Evaluates all values at `t²`. The closed forms are the derivatives of `B'` and `C'`.
    pub fn at(t2: f64) -> Self {
        if t2 < 1.0 {
            return Self::series(&SECOND, FEW, t2);
        }
        if t2 < SWITCH {
            return Self::series(&SECOND, TERMS, t2);
        }
        let t = t2.sqrt();
        let (sin, cos) = t.sin_cos();
        let n = t * sin - 2.0 * (1.0 - cos);
        let p = 3.0 * sin - t * (2.0 + cos);
        Self {
            b: b(t2),
            c: c(t2),
            b_prime: b_prime(t2),
            c_prime: c_prime(t2),
            b_second: ((t * cos - sin) / (4.0 * t) - n / t2) / (t2 * t2),
            c_second: (n - 5.0 * p / t) / (4.0 * t2 * t2 * t2),
        }
    }

    fn series(coefficients: &[[f64; TERMS]; 6], terms: usize, t2: f64) -> Self {
        let [b, c, b_prime, c_prime, b_second, c_second] =
            coefficients.each_ref().map(|all| horner(&all[..terms], t2));
        Self { b, c, b_prime, c_prime, b_second, c_second }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of `t²`, A, B, C, A', B', C' and g, from the closed forms at 60 digits (1700 at
    /// 1e-300) with mpmath 1.3.0.
    #[rustfmt::skip]
    const VALUES: [(f64, [f64; 7]); 12] = [
        (0.0, [
            1.0, 0.5, 0.16666666666666666, -0.16666666666666666,
            -0.041666666666666664, -0.008333333333333333, 0.08333333333333333,
        ]),
        (1e-300, [
            1.0, 0.5, 0.16666666666666666, -0.16666666666666666,
            -0.041666666666666664, -0.008333333333333333, 0.08333333333333333,
        ]),
        (1e-16, [
            1.0, 0.5, 0.16666666666666666, -0.16666666666666666,
            -0.041666666666666664, -0.008333333333333333, 0.08333333333333333,
        ]),
        (1e-08, [
            0.9999999983333333, 0.49999999958333335, 0.16666666658333332, -0.1666666665,
            -0.04166666663888889, -0.008333333329365079, 0.08333333334722222,
        ]),
        (0.01, [
            0.9983341664682815, 0.4995834721974234, 0.1665833531718477, -0.16650005951278785,
            -0.04163889632826289, -0.008329365905984456, 0.08334722552992746,
        ]),
        (1.0, [
            0.8414709848078965, 0.4596976941318603, 0.1585290151921035, -0.1505843394698784,
            -0.03896220172791203, -0.0079446757222251, 0.08475613914377404,
        ]),
        (4.0, [
            0.45464871341284085, 0.3540367091367856, 0.1363378216467898, -0.1088494437449979,
            -0.03167808810759129, -0.0068720944754479705, 0.08947684601641732,
        ]),
        (9.869604401089358, [
            3.174035784072652e-17, 0.20264236728467555, 0.10132118364233778, -0.05066059182116889,
            -0.020531964509368672, -0.005132991127342168, 0.10132118364233778,
        ]),
        (9.999999999999998, [
            -0.006540706968938552, 0.19997860728793262, 0.10065407069689387, -0.049662268295519375,
            -0.020324896077240195, -0.005099180240137451, 0.10163535166527118,
        ]),
        (10.0, [
            -0.0065407069689386406, 0.1999786072879326, 0.10065407069689386, -0.04966226829551936,
            -0.020324896077240192, -0.00509918024013745, 0.10163535166527118,
        ]),
        (16.0, [
            -0.18920062382698205, 0.10335272630397574, 0.07432503898918638, -0.014513843657394682,
            -0.012372064888591675, -0.003738199708236981, 0.11970719429503572,
        ]),
        (30.0, [
            -0.13172645569509123, 0.010252696280208405, 0.037724215189836374, 0.013735759454813984,
            -0.002537197470925134, -0.001715332488155012, 0.24746636412344408,
        ]),
    ];

    #[test]
    fn every_coefficient_is_accurate_to_three_ulps_on_both_sides_of_the_switch() {
        for (t2, expected) in VALUES {
            let computed = [a(t2), b(t2), c(t2), a_prime(t2), b_prime(t2), c_prime(t2), g(t2)];
            for ((name, value), reference) in
                ["A", "B", "C", "A'", "B'", "C'", "g"].iter().zip(computed).zip(expected)
            {
                // A vanishes at π. The error there is the rounding of t itself: an ulp of π times
                // the slope.
                let scale = if *name == "A" { reference.abs().max(1.0) } else { reference.abs() };
                let ulps = (value - reference).abs() / (scale * f64::EPSILON);
                assert!(ulps <= 3.0, "{name}({t2}) = {value}, not {reference}: {ulps} ulps");
            }
        }
    }

    /// Compares `g'` with central differences of `g`, and checks its limit at zero.
    #[test]
    fn the_derivative_of_g_is_that_of_its_differences() {
        assert!((g_prime(0.0) - 1.0 / 720.0).abs() < 1e-18);
        for t2 in [0.01, 1.0, 4.0, 9.9, 16.0, 30.0] {
            let step = 1e-4 * t2;
            let found = (g(t2 + step) - g(t2 - step)) / (2.0 * step);
            assert!((g_prime(t2) / found - 1.0).abs() < 1e-6, "{t2}: {} {found}", g_prime(t2));
        }
    }

    #[test]
    fn the_branches_meet_at_the_switch() {
        let below = SWITCH.next_down();
        for f in [c, a_prime, a_second, b_prime, c_prime] {
            assert!((f(below) - f(SWITCH)).abs() <= 3.0 * f64::EPSILON * f(SWITCH).abs());
        }
    }

    /// Values of `t²`, B'' and C'', from their series at 80 digits with mpmath 1.3.0.
    #[rustfmt::skip]
    const SECONDS: [(f64, [f64; 2]); 10] = [
        (1e-16, [0.002777777777777778, 0.0003968253968253968]),
        (1e-8, [0.0027777777762896826, 0.0003968253966600529]),
        (0.01, [0.002776290013185763, 0.0003966600829693714]),
        (0.9999999, [0.0026322337351168275, 0.0003805884432010007]),
        (1.0, [0.0026322337208848612, 0.00038058844160673215]),
        (4.0, [0.0022328635856709088, 0.0003352980337060702]),
        (9.999999, [0.0015818658945889164, 0.0002585502675716528]),
        (10.0, [0.00158186580067207, 0.00025855025617235294]),
        (16.0, [0.0010929504967803754, 0.0001974666766435385]),
        (30.0, [0.00039807582230857536, 0.00010065774949749875]),
    ];

    #[test]
    fn second_derivatives_are_accurate_and_agree_with_the_single_coefficients() {
        for (t2, [b_second, c_second]) in SECONDS {
            let all = Second::at(t2);
            // The closed forms lose a digit or two just above the switch. This is sufficient,
            // because they are used in a Newton iteration.
            let limit = if t2 < SWITCH { 1e-15 } else { 2e-13 };
            assert!((all.b_second - b_second).abs() <= limit * b_second, "B''({t2}) = {}", all.b_second);
            assert!((all.c_second - c_second).abs() <= limit * c_second, "C''({t2}) = {}", all.c_second);
            let pairs =
                [(all.b, b(t2)), (all.c, c(t2)), (all.b_prime, b_prime(t2)), (all.c_prime, c_prime(t2))];
            for (left, right) in pairs {
                assert!((left - right).abs() <= 4.0 * f64::EPSILON * right.abs(), "{t2}: {left} {right}");
            }
        }
    }
}
