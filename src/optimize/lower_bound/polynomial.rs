//! Polynomials in the components of several unit quaternions, in normal form.
//!
//! Each rotation is represented by its quaternion `(w, s x, s y, s z)`, with a scale `s` that makes
//! `|x|, |y|, |z| ≤ 1`: for a rotation through at most `θ`, `s = sin(θ/2)`. The sphere
//! `w² + s²(x² + y² + z²) = 1` is eliminated: every power of `w` above the first is replaced by it.
//! So two polynomials are equal on the rotations exactly when their coefficients are equal, and the
//! quadratic identities of the rotation group (`FᵀF = I`, `FFᵀ = I`, `c₁ × c₂ = c₃` of columns and
//! rows) need not be stated: in normal form all of them read `0 = 0`.
//!
//! A rotation matrix is quadratic in its quaternion,
//!
//! ```text
//! F = I − 2s²(|v|² I − v vᵀ) + 2 s w S(v),     v = (x, y, z)
//! ```
//!
//! so a quadratic polynomial of matrices has degree 4 here, and the moments of order 1 in `F` are
//! the moments of degree 4.

use crate::Matrix3;
use std::collections::BTreeMap;

/// Monomial: the exponents of `(w, x, y, z)` for each rotation that occurs, sorted by rotation. The
/// empty list is the constant 1.
pub(crate) type Monomial = Vec<(usize, [u8; 4])>;

/// Polynomial in normal form: no `w` has a power above the first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Polynomial {
    pub terms: BTreeMap<Monomial, f64>,
}

/// 3×3 matrix of polynomials, stored by rows.
pub(crate) type PolynomialMatrix = [[Polynomial; 3]; 3];

/// The rotations whose components are the variables of the polynomials.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ring {
    /// The scale `s` of each rotation, in (0, 1].
    pub scale: Vec<f64>,
    /// Indices of the variables among x, y, z: all three, or z alone for rotations about one axis.
    pub axes: &'static [usize],
}

impl Ring {
    /// Multiplies two polynomials.
    pub fn product(&self, a: &Polynomial, b: &Polynomial) -> Polynomial {
        let mut out = Polynomial::default();
        for (left, x) in &a.terms {
            for (right, y) in &b.terms {
                self.add_reduced(&mut out, multiply(left, right), x * y);
            }
        }
        out.drop_zeros()
    }

    /// Adds `value` times a monomial with any power of `w`, reduced to normal form.
    fn add_reduced(&self, out: &mut Polynomial, monomial: Monomial, value: f64) {
        let Some(place) = monomial.iter().position(|(_, exponents)| exponents[0] >= 2) else {
            *out.terms.entry(monomial).or_insert(0.0) += value;
            return;
        };
        // w² = 1 − s² Σ v_i²
        let mut rest = monomial;
        rest[place].1[0] -= 2;
        let factor = self.scale[rest[place].0] * self.scale[rest[place].0];
        for &axis in self.axes {
            let mut term = rest.clone();
            term[place].1[axis] += 2;
            self.add_reduced(out, term, -factor * value);
        }
        if rest[place].1 == [0; 4] {
            rest.remove(place);
        }
        self.add_reduced(out, rest, value);
    }

    /// Returns the matrix of rotation `id`.
    pub fn rotation(&self, id: usize) -> PolynomialMatrix {
        let s = self.scale[id];
        let monomial = |i: usize, j: usize| {
            let there = |axis: usize| axis == 0 || self.axes.contains(&axis);
            if !(there(i) && there(j)) {
                return Polynomial::default();
            }
            let mut exponents = [0; 4];
            exponents[i] += 1;
            exponents[j] += 1;
            Polynomial::monomial(vec![(id, exponents)], 1.0)
        };
        matrix(|i, j| {
            if i == j {
                let others = (0..3).filter(|&other| other != i);
                return others.fold(Polynomial::constant(1.0), |entry, other| {
                    entry.plus(&monomial(other + 1, other + 1), -2.0 * s * s)
                });
            }
            // S(v)_ij is −v_k if (i, j, k) is a cyclic order, and +v_k otherwise.
            let sign = if (i + 1) % 3 == j { -1.0 } else { 1.0 };
            let symmetric = Polynomial::default().plus(&monomial(i + 1, j + 1), 2.0 * s * s);
            symmetric.plus(&monomial(0, 3 - i - j + 1), sign * 2.0 * s)
        })
    }

    /// Computes the matrix product `A B`.
    pub fn matrix_product(&self, a: &PolynomialMatrix, b: &PolynomialMatrix) -> PolynomialMatrix {
        matrix(|i, j| sum(|k| (self.product(&a[i][k], &b[k][j]), 1.0)))
    }

    /// Returns the monomials of degree `from` and of all lower degrees of the same parity, except
    /// the constant, in the quaternion of rotation `id` and in normal form. On the unit sphere they
    /// span the forms of degree `from`, together with the constant if `from` is even.
    pub fn monomials(&self, id: usize, from: u8) -> Vec<Polynomial> {
        let mut out = Vec::new();
        let mut degree = if from.is_multiple_of(2) { 2 } else { 1 };
        let most = |axis: usize, left: u8| if self.axes.contains(&axis) { left } else { 0 };
        while degree <= from {
            for w in 0..=1u8.min(degree) {
                for x in 0..=most(1, degree - w) {
                    for y in 0..=most(2, degree - w - x) {
                        let z = degree - w - x - y;
                        if z <= most(3, z) {
                            out.push(Polynomial::monomial(vec![(id, [w, x, y, z])], 1.0));
                        }
                    }
                }
            }
            degree += 2;
        }
        out
    }
}

impl Polynomial {
    /// Returns a constant polynomial.
    pub fn constant(value: f64) -> Self {
        Self::monomial(Vec::new(), value)
    }

    /// Returns a polynomial with one term.
    pub fn monomial(monomial: Monomial, value: f64) -> Self {
        Self { terms: BTreeMap::from([(monomial, value)]) }
    }

    /// Adds a multiple: `self += factor · other`.
    pub fn add(&mut self, other: &Self, factor: f64) {
        for (monomial, value) in &other.terms {
            *self.terms.entry(monomial.clone()).or_insert(0.0) += factor * value;
        }
    }

    /// Returns the polynomial `self + factor · other`.
    pub fn plus(mut self, other: &Self, factor: f64) -> Self {
        self.add(other, factor);
        self
    }

    /// Returns the constant term.
    pub fn constant_term(&self) -> f64 {
        self.terms.get(&Vec::new()).copied().unwrap_or(0.0)
    }

    /// Returns `Σ |coefficient|`, an upper bound on the polynomial's magnitude because every
    /// variable has a magnitude of at most 1.
    pub fn magnitude(&self) -> f64 {
        self.terms.values().map(|value| value.abs()).sum()
    }

    fn drop_zeros(mut self) -> Self {
        // Only exact cancellations are removed; a coefficient left by round-off is kept, because it
        // is correct to round-off.
        self.terms.retain(|_, value| value.abs() > 0.0);
        self
    }

    /// Evaluates the polynomial at quaternions `(w, v)` of the rotations, with `v` not scaled.
    #[cfg(test)]
    pub fn value(&self, ring: &Ring, quaternions: &[[f64; 4]]) -> f64 {
        let mut sum = 0.0;
        for (monomial, value) in &self.terms {
            let mut term = *value;
            for (id, exponents) in monomial {
                for (axis, (part, exponent)) in quaternions[*id].iter().zip(exponents).enumerate() {
                    let scale = if axis == 0 { 1.0 } else { ring.scale[*id] };
                    term *= (part / scale).powi((*exponent).into());
                }
            }
            sum += term;
        }
        sum
    }
}

fn multiply(a: &Monomial, b: &Monomial) -> Monomial {
    let mut out = a.clone();
    for (id, exponents) in b {
        match out.binary_search_by_key(id, |(id, _)| *id) {
            Ok(place) => {
                for (sum, exponent) in out[place].1.iter_mut().zip(exponents) {
                    *sum += exponent;
                }
            }
            Err(place) => out.insert(place, (*id, *exponents)),
        }
    }
    out
}

/// Builds a matrix from its entries.
fn matrix(entry: impl Fn(usize, usize) -> Polynomial) -> PolynomialMatrix {
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// Computes `Σ_k factor_k · polynomial_k` for k = 0, 1, 2.
fn sum(term: impl Fn(usize) -> (Polynomial, f64)) -> Polynomial {
    (0..3).map(term).fold(Polynomial::default(), |sum, (polynomial, factor)| sum.plus(&polynomial, factor))
}

/// Converts a constant matrix to a matrix of polynomials.
pub(crate) fn constant_matrix(constant: &Matrix3) -> PolynomialMatrix {
    matrix(|i, j| Polynomial::constant(constant[(i, j)]))
}

/// Returns the transpose `Aᵀ`.
pub(crate) fn transposed(a: &PolynomialMatrix) -> PolynomialMatrix {
    matrix(|i, j| a[j][i].clone())
}

/// Computes `C A` for a constant `C`; the result is linear if `A` is.
pub(crate) fn left_multiplied(c: &Matrix3, a: &PolynomialMatrix) -> PolynomialMatrix {
    matrix(|i, j| sum(|k| (a[k][j].clone(), c[(i, k)])))
}

/// Computes `vee(A − Aᵀ)`.
pub(crate) fn vee_of_skew_part(a: &PolynomialMatrix) -> [Polynomial; 3] {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 2) % 3, (k + 1) % 3);
        a[i][j].clone().plus(&a[j][i], -1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector3;
    use crate::lie;
    use crate::testing::Random;

    const ALL: &[usize] = &[1, 2, 3];

    fn quaternion(random: &mut Random) -> [f64; 4] {
        lie::quaternion_from_rotation(&random.rotation())
    }

    #[test]
    fn a_rotation_matrix_has_the_values_of_its_quaternion() {
        let mut random = Random(3);
        let ring = Ring { scale: vec![0.4, 1.0], axes: ALL };
        for _ in 0..20 {
            let quaternions = [quaternion(&mut random), quaternion(&mut random)];
            let r: Vec<Matrix3> = quaternions.iter().map(lie::rotation_from_quaternion).collect();
            let entries = ring.matrix_product(&ring.rotation(0), &ring.rotation(1));
            let product = r[0] * r[1];
            for i in 0..3 {
                for j in 0..3 {
                    let value = entries[i][j].value(&ring, &quaternions);
                    assert!((value - product[(i, j)]).abs() < 1e-14, "{value}");
                }
            }
        }
    }

    #[test]
    fn the_identities_of_the_group_are_zero_in_normal_form() {
        let ring = Ring { scale: vec![0.3], axes: ALL };
        let f = ring.rotation(0);
        let transpose = transposed(&f);
        for (left, right) in [(&f, &transpose), (&transpose, &f)] {
            let mut product = ring.matrix_product(left, right);
            for (i, row) in product.iter_mut().enumerate() {
                row[i].add(&Polynomial::constant(1.0), -1.0);
                assert!(row.iter().all(|entry| entry.magnitude() < 1e-15));
            }
        }
        for matrix in [&f, &transpose] {
            // First row × second row = third row.
            for k in 0..3 {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let mut cross = ring.product(&matrix[0][i], &matrix[1][j]);
                cross.add(&ring.product(&matrix[0][j], &matrix[1][i]), -1.0);
                cross.add(&matrix[2][k], -1.0);
                assert!(cross.magnitude() < 1e-15);
            }
        }
    }

    #[test]
    fn nine_entries_have_fifty_five_products_and_thirty_five_moments() {
        // The 55 products of (1, F) and the 20 identities between them leave 35 moments: all
        // identities are accounted for.
        let ring = Ring { scale: vec![1.0], axes: ALL };
        assert_eq!(1 + ring.monomials(0, 2).len(), 10);
        assert_eq!(1 + ring.monomials(0, 4).len(), 35);
        assert_eq!(1 + ring.monomials(0, 8).len(), 165);
        assert_eq!(ring.monomials(0, 1).len(), 4);
        assert_eq!(ring.monomials(0, 3).len(), 20);
        let planar = Ring { scale: vec![1.0], axes: &[3] };
        assert_eq!(1 + planar.monomials(0, 2).len(), 3);
    }

    #[test]
    fn the_vee_of_the_skew_part_is_that_of_the_matrix() {
        let m = Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 9.0, 8.0);
        let entries = vee_of_skew_part(&constant_matrix(&m));
        let expected = Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]);
        for k in 0..3 {
            assert!((entries[k].constant_term() - expected[k]).abs() < 1e-15);
        }
    }
}
