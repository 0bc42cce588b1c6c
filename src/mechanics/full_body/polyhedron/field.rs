//! The exact field of a homogeneous polyhedron for G = 1 and density 1, by Werner and Scheeres
//! (1996).
//!
//! With vectors `r_e`, `r_f` from the field point to any point of an edge or face,
//! ```text
//! U   = ∫ dV/|r| = ½ Σ_e (r_e·E_e r_e) L_e − ½ Σ_f (r_f·F_f r_f) ω_f
//! ∇U  = −Σ_e E_e r_e L_e + Σ_f F_f r_f ω_f              ∇²U = −Σ_f ω_f
//! E_e = n_A n_eAᵀ + n_B n_eBᵀ     F_f = n_f n_fᵀ        (n_eA: in the plane of A, outward from the edge)
//! L_e = ln[(a + b + e)/(a + b − e)]                     a, b distances to the ends, e length
//! tan(ω_f/2) = r₁·(r₂×r₃) / [r₁r₂r₃ + r₁(r₂·r₃) + r₂(r₃·r₁) + r₃(r₁·r₂)]
//! ```
//! `U` and `∇U` are exact and continuous everywhere: inside, outside and on the surface. A face of
//! zero area contributes nothing.
//!
//! Each term has a floating-point error of a few ulps, because `L_e` is an odd series in
//! `e/(a + b)` instead of the logarithm of a number near one, and the numerator of `ω_f` is
//! `2A n·r`. The terms cancel far from the body. At the distance r from a body of size l and volume
//! V, `U` and `∇U` have errors of about `r² l/V` ulps.
//!
//! Four field points are evaluated at a time.

use super::Polyhedron;
use super::surface::half_edges;
use crate::Vector3;
use crate::mechanics::full_body::lanes::{LANES, Lanes};

/// The exact gravity of a homogeneous polyhedron on points in the axes of the polyhedron, divided
/// by `G` and density.
#[derive(Clone, Debug, PartialEq)]
pub struct PolyhedronField {
    edges: Vec<Edge>,
    faces: Vec<Face>,
}

#[derive(Clone, Debug, PartialEq)]
struct Edge {
    ends: [Vector3; 2],
    length: f64,
    /// The matrix `E_e`, by rows.
    dyad: [[f64; 3]; 3],
}

#[derive(Clone, Debug, PartialEq)]
struct Face {
    corners: [Vector3; 3],
    normal: Vector3,
    double_area: f64,
}

/// Potential `U`, gradient `∇U` and solid angle `Σ ω` at four points.
pub(in crate::mechanics::full_body) struct Attraction {
    pub potential: Lanes,
    pub gradient: [Lanes; 3],
    pub solid_angle: Lanes,
}

impl PolyhedronField {
    /// Builds the field of a solid.
    pub fn new(shape: &Polyhedron) -> Self {
        let faces: Vec<_> = shape.triangles().map(Face::new).collect();
        let vertex = |index: u32| shape.vertices[index as usize];
        let edges = half_edges(&shape.faces);
        let edges = edges.chunks_exact(2).map(|sides| {
            let (from, to) = (vertex(sides[0].from), vertex(sides[0].to));
            let length = (to - from).norm();
            let along = (to - from) / length;
            let [a, b] = [&faces[sides[0].face].normal, &faces[sides[1].face].normal];
            let dyad = a * along.cross(a).transpose() - b * along.cross(b).transpose();
            let dyad = [0, 1, 2].map(|row| [0, 1, 2].map(|column| dyad[(row, column)]));
            Edge { ends: [from, to], length, dyad }
        });
        let edges = edges.filter(|edge| edge.length > 0.0).collect();
        Self { edges, faces }
    }

    /// Returns `∫ dV/|r|` \[m²\]. The potential per unit of mass is this integral times `−G` and
    /// the density.
    pub fn potential(&self, point: &Vector3) -> f64 {
        self.at(&side_by_side(&[*point; LANES])).potential.0[0]
    }

    /// Returns `∇ ∫ dV/|r|` \[m\]. The acceleration of a mass at the field point is this vector
    /// times `G` and the density.
    pub fn attraction(&self, point: &Vector3) -> Vector3 {
        Vector3::from(self.at(&side_by_side(&[*point; LANES])).gradient.map(|lanes| lanes.0[0]))
    }

    /// Returns `∇² ∫ dV/|r|`: −4π inside, zero outside. It jumps at the surface, where the result
    /// may be any value in between.
    pub fn laplacian(&self, point: &Vector3) -> f64 {
        -self.at(&side_by_side(&[*point; LANES])).solid_angle.0[0]
    }

    /// Returns `U`, `∇U` and `Σ ω` at four points, given as lanes.
    pub(in crate::mechanics::full_body) fn at(&self, y: &[Lanes; 3]) -> Attraction {
        let (mut potential, mut gradient) = (Lanes::ZERO, [Lanes::ZERO; 3]);
        for edge in &self.edges {
            let r = from_point(y, &edge.ends[0]);
            let distances = norm(&r) + norm(&from_point(y, &edge.ends[1]));
            let l = edge_logarithm(distances, edge.length);
            let er = edge.dyad.map(|row| dot(&row.map(Lanes::splat), &r));
            potential += dot(&r, &er) * l;
            for (sum, er) in gradient.iter_mut().zip(er) {
                *sum += -(er * l);
            }
        }
        let mut solid_angle = Lanes::ZERO;
        for face in &self.faces {
            let corners = [0, 1, 2].map(|k| from_point(y, &face.corners[k]));
            let normal = [0, 1, 2].map(|axis| Lanes::splat(face.normal[axis]));
            let height = dot(&normal, &corners[0]);
            let omega = face_angle(&corners, height * Lanes::splat(face.double_area));
            let share = height * omega;
            potential += -(height * share);
            for (sum, normal) in gradient.iter_mut().zip(normal) {
                *sum += normal * share;
            }
            solid_angle += omega;
        }
        Attraction { potential: Lanes::splat(0.5) * potential, gradient, solid_angle }
    }
}

impl Face {
    fn new(corners: [Vector3; 3]) -> Self {
        let [a, b, c] = corners;
        let area = (b - a).cross(&(c - a));
        let double_area = area.norm();
        // The normal of a thin triangle is dominated by round-off. This is harmless if the normal
        // is perpendicular to the sides, because the terms of the three sides then cancel. The
        // normal is made perpendicular to the longest side, to which the other sides are nearly
        // parallel.
        let sides = [b - a, c - b, a - c];
        let longer = |a: Vector3, b: Vector3| if b.norm_squared() > a.norm_squared() { b } else { a };
        let longest = longer(longer(sides[0], sides[1]), sides[2]);
        let noisy = area / double_area;
        let normal = noisy - noisy.dot(&longest) / longest.norm_squared() * longest;
        // If the normal is round-off only, or the area is zero (NaN), the terms of the face vanish.
        let normal = if normal.norm() > 0.5 { normal.normalize() } else { Vector3::zeros() };
        Self { corners, normal, double_area }
    }
}

#[inline(always)]
fn from_point(y: &[Lanes; 3], vertex: &Vector3) -> [Lanes; 3] {
    [0, 1, 2].map(|axis| Lanes::splat(vertex[axis]) - y[axis])
}

#[inline(always)]
fn dot(a: &[Lanes; 3], b: &[Lanes; 3]) -> Lanes {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn norm(a: &[Lanes; 3]) -> Lanes {
    dot(a, a).sqrt()
}

/// Returns the solid angle `ω = 2 atan2(r₁·(r₂×r₃), …)` of a face, from the numerator and the
/// corners.
#[inline(always)]
fn face_angle(corners: &[[Lanes; 3]; 3], numerator: Lanes) -> Lanes {
    let [r1, r2, r3] = corners;
    let (a, b, c) = (norm(r1), norm(r2), norm(r3));
    let denominator = a * b * c + a * dot(r2, r3) + b * dot(r3, r1) + c * dot(r1, r2);
    Lanes::splat(2.0) * arc_tangent(numerator, denominator)
}

/// Returns `ln[(s + e)/(s − e)]` for `s = a + b ≥ e`. On the edge itself the logarithm is infinite,
/// and the function returns a large number.
///
/// With `2^k` the power of two nearest to the ratio, `ln = k ln 2 + 2 atanh z`, `|z| ≤ 0.1716`,
/// `z = ((s + e) − 2^k (s − e))/((s + e) + 2^k (s − e))`. For `k = 0`, away from the edge,
/// `z = e/s` needs no subtraction. The coefficients of the odd series are from fdlibm `e_log.c`;
/// the error is below 2⁻⁵⁸.
#[inline(always)]
fn edge_logarithm(s: Lanes, e: f64) -> Lanes {
    // The digits are as published.
    #[allow(clippy::excessive_precision)]
    const ODD: [f64; 7] = [
        6.666666666666735130e-01,
        3.999999999940941908e-01,
        2.857142874366239149e-01,
        2.222219843214978396e-01,
        1.818357216161805012e-01,
        1.531383769920937332e-01,
        1.479819860511658591e-01,
    ];
    /// The bits of the floating-point number √½.
    const HALF_ROOT: u64 = 0x3fe6_a09e_667f_3bcd;
    const ONE: u64 = 1023 << 52;
    let e = Lanes::splat(e);
    // Round-off may put s below e.
    let gap = at_least(s - e, 1e-16 * e.0[0]);
    let ratio = (s + e) / gap;
    // 2^k ≤ √2 ratio < 2^(k+1): the exponent of the ratio over √½.
    let power = ratio.map(|ratio| {
        let exponent = (ratio.to_bits().wrapping_sub(HALF_ROOT)) & 0xfff0_0000_0000_0000;
        f64::from_bits(exponent.wrapping_add(ONE))
    });
    // The biased exponent is read as the low bits of a large number, which avoids a conversion from
    // integers.
    let k = power.map(|power| {
        f64::from_bits((power.to_bits() >> 52) | (1075 << 52)) - (4_503_599_627_370_496.0 + 1023.0)
    });
    let (sum, rest) = (s + e, power * gap);
    let difference = sum - rest;
    let difference =
        Lanes::from_fn(|lane| if power.0[lane] > 1.0 { difference.0[lane] } else { 2.0 * e.0[lane] });
    let z = difference / (sum + rest);
    let w = z * z;
    let odd = ODD.iter().rev().fold(Lanes::ZERO, |sum, &c| sum * w + Lanes::splat(c));
    k * Lanes::splat(std::f64::consts::LN_2) + (z + z) + z * w * odd
}

/// Raises every lane below `bound` to `bound`; NaN stays NaN.
#[inline(always)]
fn at_least(value: Lanes, bound: f64) -> Lanes {
    value.map(|value| if value < bound { bound } else { value })
}

/// Returns `atan2(y, x)` to about two ulps of π; zero at `(0, 0)`.
///
/// The argument is reduced to `|t| ≤ tan(π/8)`, where the coefficients of the series are from
/// fdlibm `s_atan.c`.
#[inline(always)]
fn arc_tangent(y: Lanes, x: Lanes) -> Lanes {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    // The digits are as published.
    #[allow(clippy::excessive_precision)]
    const SERIES: [f64; 11] = [
        3.33333333333329318027e-01,
        -1.99999999998764832476e-01,
        1.42857142725034663711e-01,
        -1.11111104054623557880e-01,
        9.09088713343650656196e-02,
        -7.69187620504482999495e-02,
        6.66107313738753120669e-02,
        -5.83357013379057348645e-02,
        4.97687799461593236017e-02,
        -3.65315727442169155270e-02,
        1.62858201153657823623e-02,
    ];
    /// The value of tan(π/8).
    const TURN: f64 = 0.414_213_562_373_095_03;
    let (ax, ay) = (x.map(f64::abs), y.map(f64::abs));
    let select = |condition: fn(f64, f64) -> bool, a: Lanes, b: Lanes, then: Lanes, other: Lanes| {
        Lanes::from_fn(|lane| if condition(a.0[lane], b.0[lane]) { then.0[lane] } else { other.0[lane] })
    };
    let greater: fn(f64, f64) -> bool = |a, b| a > b;
    let small = select(greater, ay, ax, ax, ay);
    let large = at_least(select(greater, ay, ax, ay, ax), f64::MIN_POSITIVE);
    let steep = Lanes::splat(TURN) * large;
    let top = select(greater, small, steep, small - large, small);
    let bottom = select(greater, small, steep, small + large, large);
    let t = top / bottom;
    let w = t * t;
    let series = SERIES.iter().rev().fold(Lanes::ZERO, |sum, &c| sum * w + Lanes::splat(c));
    let near = t - t * w * series;
    let angle = near + select(greater, small, steep, Lanes::splat(FRAC_PI_4), Lanes::ZERO);
    let angle = select(greater, ay, ax, Lanes::splat(FRAC_PI_2) - angle, angle);
    let angle = select(greater, Lanes::ZERO, x, Lanes::splat(PI) - angle, angle);
    Lanes::from_fn(|lane| angle.0[lane].copysign(y.0[lane]))
}

/// Returns the coordinates of four points: for each coordinate axis, lanes with one point each.
pub(in crate::mechanics::full_body) fn side_by_side(points: &[Vector3; LANES]) -> [Lanes; 3] {
    [0, 1, 2].map(|axis| Lanes::from_fn(|lane| points[lane][axis]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn logarithm_and_angle_agree_with_the_standard_library() {
        let mut random = Random(5);
        for _ in 0..100_000 {
            let e = 10f64.powf(3.0 * random.uniform());
            let s = e * (1.0 + 10f64.powf(8.0 * random.uniform() - 6.0));
            let expected = (2.0 * e / (s - e)).ln_1p();
            let found = edge_logarithm(Lanes::splat(s), e).0[0];
            assert!((found / expected - 1.0).abs() < 1e-15, "{s} {e}: {found} {expected}");
            let (y, x) = (random.uniform(), random.uniform());
            let scale = 10f64.powf(20.0 * random.uniform());
            let found = arc_tangent(Lanes::splat(scale * y), Lanes::splat(x)).0[0];
            let expected = (scale * y).atan2(x);
            assert!((found / expected - 1.0).abs() < 1e-15, "{y} {x}: {found} {expected}");
        }
        assert!(edge_logarithm(Lanes::splat(1.0), 1.0).0[0].is_finite());
        for (y, x) in [(0.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (-1.0, -1.0), (1.0, 1.0)]
        {
            assert!((arc_tangent(Lanes::splat(y), Lanes::splat(x)).0[0] - f64::atan2(y, x)).abs() < 5e-16);
        }
        for (y, x) in [(f64::NAN, 1.0), (1.0, f64::NAN)] {
            assert!(arc_tangent(Lanes::splat(y), Lanes::splat(x)).0[0].is_nan());
        }
        assert!(edge_logarithm(Lanes::splat(f64::NAN), 1.0).0[0].is_nan());
    }
}
