//! The degree and the quadrature rule of a Galerkin method, with the values of its basis at the
//! quadrature points.

use std::ops::RangeInclusive;

/// The available degrees of the curves.
pub const DEGREES: RangeInclusive<usize> = 1..=6;

/// The quadrature rule for the action of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quadrature {
    /// The s Gauss points, exact to degree 2s − 1.
    Gauss,
    /// The s + 1 Lobatto points, including both ends of the step, exact to degree 2s − 1.
    Lobatto,
}

/// A Galerkin scheme: polynomials of degree s through the s + 1 Lobatto points of a step, with a
/// quadrature rule.
///
/// `l_ν`, ν = 1…s, are the Lagrange polynomials of all control times except the first. The
/// displacement at the first control time is zero.
#[derive(Clone, Debug)]
pub(crate) struct Scheme {
    /// Degree s of the polynomials.
    pub degree: usize,
    /// Control times `d_1 … d_s` as fractions of the step; the last one is 1.
    pub times: Vec<f64>,
    /// Quadrature points `c_i` on [0, 1].
    pub points: Vec<f64>,
    /// Quadrature weights `b_i` on [0, 1].
    pub weights: Vec<f64>,
    /// Values `l_ν(c_i)` of the basis, one row per quadrature point.
    pub values: Vec<Vec<f64>>,
    /// Slopes `l'_ν(c_i)` of the basis, one row per quadrature point.
    pub slopes: Vec<Vec<f64>>,
    /// Values `l_μ(1 + d_ν)`, which extrapolate a curve to the next step.
    pub ahead: Vec<Vec<f64>>,
}

impl Scheme {
    /// Builds the scheme of a degree, with its quadrature rule and its basis.
    ///
    /// # Panics
    /// Panics for a degree outside [`DEGREES`], or if rule and basis do not pass their check.
    pub fn new(degree: usize, quadrature: Quadrature) -> Self {
        assert!(DEGREES.contains(&degree), "degree {degree}");
        let (controls, lobatto_weights) = lobatto(degree + 1);
        let (points, weights) = match quadrature {
            Quadrature::Gauss => gauss(degree),
            Quadrature::Lobatto => (controls.clone(), lobatto_weights),
        };
        for power in 0..2 * degree {
            let moment: f64 = points.iter().zip(&weights).map(|(c, b)| b * c.powi(power as i32)).sum();
            assert!((moment * (power + 1) as f64 - 1.0).abs() < 1e-14, "moment {power} of the quadrature");
        }
        let rows = |at: &[f64], slope: bool| -> Vec<Vec<f64>> {
            let row = |t: &f64| {
                let basis = (1..=degree).map(|index| lagrange(&controls, index, *t));
                basis.map(|(value, derivative)| if slope { derivative } else { value }).collect()
            };
            at.iter().map(row).collect()
        };
        let times = controls[1..].to_vec();
        let next: Vec<f64> = times.iter().map(|d| 1.0 + d).collect();
        Self {
            degree,
            values: rows(&points, false),
            slopes: rows(&points, true),
            ahead: rows(&next, false),
            times,
            points,
            weights,
        }
    }
}

/// Returns the `index`-th Lagrange polynomial of `nodes` at `t`, and its derivative.
fn lagrange(nodes: &[f64], index: usize, t: f64) -> (f64, f64) {
    let (mut value, mut slope) = (1.0, 0.0);
    for (other, node) in nodes.iter().enumerate() {
        if other != index {
            let width = nodes[index] - node;
            slope = slope * (t - node) / width + value / width;
            value *= (t - node) / width;
        }
    }
    (value, slope)
}

/// Returns the Legendre polynomials `P_n` and `P_{n−1}` at `x`.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut p, mut before) = (1.0, 0.0);
    for k in 0..n {
        (p, before) = (((2 * k + 1) as f64 * x * p - k as f64 * before) / (k + 1) as f64, p);
    }
    (p, before)
}

/// Returns Gauss's rule with n points on [0, 1], from the zeros of `P_n`; weights
/// `2/((1 − x²) P_n'²)`.
fn gauss(n: usize) -> (Vec<f64>, Vec<f64>) {
    let rule = (0..n).map(|i| {
        let mut x = -((i as f64 + 0.75) / (n as f64 + 0.5) * std::f64::consts::PI).cos();
        let mut slope = 1.0;
        // Newton's method from Tricomi's guess converges in three or four iterations; further ones
        // have no effect.
        for _ in 0..10 {
            let (p, before) = legendre(n, x);
            slope = n as f64 * (before - x * p) / (1.0 - x * x);
            x -= p / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    });
    rule.unzip()
}

/// Returns Lobatto's rule with n ≥ 2 points on [0, 1], from ±1 and the zeros of `P'_{n−1}`; weights
/// `2/(n(n−1) P_{n−1}²)`.
fn lobatto(n: usize) -> (Vec<f64>, Vec<f64>) {
    let m = n - 1;
    let rule = (0..n).map(|i| {
        let mut x = -(std::f64::consts::PI * i as f64 / m as f64).cos();
        if i > 0 && i < m {
            for _ in 0..10 {
                // (1 − x²) P' = m (P_{m−1} − x P_m),  ((1 − x²) P')' = −m(m+1) P
                let (p, before) = legendre(m, x);
                x += (before - x * p) / ((m + 1) as f64 * p);
            }
        }
        let (p, _) = legendre(m, x);
        (0.5 * (1.0 + x), 1.0 / (n as f64 * m as f64 * p * p))
    });
    rule.unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rules_are_the_known_ones() {
        let gauss3 = Scheme::new(3, Quadrature::Gauss);
        let root = 0.5 * 0.6_f64.sqrt();
        for (value, expected) in gauss3.points.iter().zip([0.5 - root, 0.5, 0.5 + root]) {
            assert!((value - expected).abs() < 1e-16, "{value}");
        }
        let lobatto4 = Scheme::new(3, Quadrature::Lobatto);
        let root = 0.5 * 0.2_f64.sqrt();
        for (value, expected) in lobatto4.points.iter().zip([0.0, 0.5 - root, 0.5 + root, 1.0]) {
            assert!((value - expected).abs() < 1e-16, "{value}");
        }
        for (value, expected) in lobatto4.weights.iter().zip([1.0 / 12.0, 5.0 / 12.0]) {
            assert!((value - expected).abs() < 1e-16, "{value}");
        }
    }

    /// A polynomial of this degree that vanishes at 0 equals its interpolant at any point.
    #[test]
    fn the_basis_reproduces_polynomials_and_their_slopes() {
        for degree in DEGREES {
            for quadrature in [Quadrature::Gauss, Quadrature::Lobatto] {
                let scheme = Scheme::new(degree, quadrature);
                let sum = |row: &[f64]| -> f64 {
                    row.iter().zip(&scheme.times).map(|(l, d)| l * d.powi(degree as i32)).sum()
                };
                let power = degree as i32;
                for (i, c) in scheme.points.iter().enumerate() {
                    assert!((sum(&scheme.values[i]) - c.powi(power)).abs() < 1e-14);
                    let slope = f64::from(power) * c.powi(power - 1);
                    assert!((sum(&scheme.slopes[i]) - slope).abs() < 1e-13);
                }
                for (row, d) in scheme.ahead.iter().zip(&scheme.times) {
                    let expected = (1.0 + d).powi(power);
                    assert!((sum(row) - expected).abs() < 1e-12 * expected);
                }
            }
        }
    }
}
