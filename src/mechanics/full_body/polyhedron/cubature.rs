//! Gauss points of a polyhedron: conical product rules on the tetrahedra from the mass centre to
//! the faces.
//!
//! A tetrahedron with apex 0 and base a, b, c is the image of the cube,
//! `ρ = u (a + v ((b − a) + w (c − b)))` with `dV = 6V u² v du dv dw`. Gauss–Jacobi points for the
//! weights `u²`, `v` and 1, n of each, integrate every polynomial of degree 2n − 1 exactly (Stroud
//! 1971). For a field that is smooth over the solid, points and solid therefore differ by
//! O((l/d)^{2n}), with l the size of a tetrahedron and d its distance from the attracting body. For
//! n ≥ 2 mass, mass centre and inertia equal the values of the solid.
//!
//! A face whose outer side points towards the mass centre has a tetrahedron of negative volume,
//! which subtracts the excess of other tetrahedra. The sum is still exact for polynomials, but has
//! points outside of the solid.

use super::Polyhedron;
use crate::Vector3;
use crate::mechanics::full_body::MassPoint;

impl Polyhedron {
    /// Largest number of points along each direction of a tetrahedron in
    /// [`cubature`](Self::cubature).
    pub const ORDER: usize = 16;

    /// Returns `order³` weighted points for each face that represent a solid of density 1. The rule
    /// is exact for polynomials of degree `2 order − 1`. Positions are relative to the origin of
    /// the axes of the solid. Weights \[m³\] may be negative if the solid is not
    /// [star-shaped](Self::is_star_shaped). `order` is clamped to 1 … [`Self::ORDER`].
    pub fn cubature(&self, order: usize) -> Vec<MassPoint> {
        let order = order.clamp(1, Self::ORDER);
        let [us, vs, ws] = [2, 1, 0].map(|power| gauss_jacobi(order, power));
        let apex = self.center();
        let mut points = Vec::with_capacity(self.faces().len() * order.pow(3));
        for corners in self.triangles() {
            let [a, b, c] = corners.map(|corner| corner - apex);
            let jacobian = a.dot(&b.cross(&c));
            for (u, u_weight) in &us {
                for (v, v_weight) in &vs {
                    for (w, w_weight) in &ws {
                        let arm: Vector3 = *u * (a + *v * ((b - a) + *w * (c - b)));
                        let mass = jacobian * u_weight * v_weight * w_weight;
                        points.push(MassPoint { mass, position: apex + arm });
                    }
                }
            }
        }
        points
    }
}

/// Returns the nodes and weights of the n-point Gauss rule for `∫₀¹ x^β f(x) dx`. With
/// `t = 2x − 1`, the nodes are the roots of the Jacobi polynomial `P_n^{(0,β)}(t)`, and the weights
/// `1/((1 − t²) P'(t)²)`.
fn gauss_jacobi(n: usize, beta: usize) -> Vec<(f64, f64)> {
    let mut roots: Vec<f64> = Vec::with_capacity(n);
    for index in 0..n {
        let mut t = -((2 * index + 1) as f64 * std::f64::consts::PI / (2 * n + beta) as f64).cos();
        // Newton's method with the known roots divided out (deflation) converges to a new root from
        // any start.
        for _ in 0..100 {
            let (value, slope) = jacobi(n, beta, t);
            let found: f64 = roots.iter().map(|root| 1.0 / (t - root)).sum();
            let step = value / (slope - value * found);
            t -= step;
            if step.abs() <= 1e-16 {
                break;
            }
        }
        roots.push(t);
    }
    roots.sort_by(f64::total_cmp);
    let node = |t: f64| {
        let (_, slope) = jacobi(n, beta, t);
        (0.5 * (1.0 + t), 1.0 / ((1.0 - t * t) * slope * slope))
    };
    roots.into_iter().map(node).collect()
}

/// Returns the Jacobi polynomial `P_n^{(0,β)}(t)` and its derivative, by the three-term recurrence
/// (Abramowitz and Stegun 22.7.1, 22.8.1).
fn jacobi(n: usize, beta: usize, t: f64) -> (f64, f64) {
    let b = beta as f64;
    let (mut before, mut value) = (0.0, 1.0);
    for k in 0..n {
        let next = if k == 0 {
            0.5 * ((b + 2.0) * t - b)
        } else {
            let k = k as f64;
            let c = 2.0 * k + b;
            ((c + 1.0) * ((c + 2.0) * c * t - b * b) * value - 2.0 * k * (k + b) * (c + 2.0) * before)
                / (2.0 * (k + 1.0) * (k + 1.0 + b) * c)
        };
        (before, value) = (value, next);
    }
    let k = n as f64;
    let c = 2.0 * k + b;
    let slope = (k * (-b - c * t) * value + 2.0 * k * (k + b) * before) / (c * (1.0 - t * t));
    (value, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_rules_integrate_their_degree_and_no_more() {
        for beta in 0..3 {
            for n in 1..=Polyhedron::ORDER {
                let rule = gauss_jacobi(n, beta);
                let error = |degree: i32| {
                    let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
                    (sum * f64::from(degree + beta as i32 + 1) - 1.0).abs()
                };
                for degree in 0..2 * n as i32 {
                    assert!(error(degree) < 1e-13, "{n} {beta} {degree}: {:e}", error(degree));
                }
                assert!(n > 8 || error(2 * n as i32) > 1e-10, "{n} {beta}");
            }
        }
    }
}
