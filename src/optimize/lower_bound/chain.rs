//! The maneuver of a free body as a chain of rotations with a quadratic cost.
//!
//! With `g_k = hΠ_k` the implicit equation reads `g_k = p(F_k) = vee(F_k J_d − J_d F_kᵀ)`, and
//! after the drift the momentum is `F_kᵀ g_k = m(F_k) = vee(J_d F_k − F_kᵀ J_d)`: both linear in
//! `F_k`. So is the torque `τ = B u`,
//!
//! ```text
//! h² τ_k = p(F_k) − m(F_{k−1})
//! ```
//!
//! and the minimum effort of a torque is `½ τᵀ G τ`, `G = (B W⁻¹ Bᵀ)⁻¹`. The free steps `F_1 … F_M`
//! of the chain and its boundary terms are
//!
//! ```text
//! Lie–Euler    M = N − 1   F_0 is fixed by Π_0;  a = m(F_0),  b = hΠ_d,  end factors 1
//! Lie–Verlet   M = N       half kicks h²τ/2;     a = hΠ_0,    b = hΠ_d,  end factors ½·2² = 2
//!
//! cost = (1/2h³) [ e |p(F_1) − a|² + Σ |p(F_{k+1}) − m(F_k)|² + e |b − m(F_M)|² ]_G ,    F_1 F_2 ⋯ F_M = Q
//! ```
//!
//! The rotations that remain variables: for two steps only `F_1`, with `F_2 = F_1ᵀ Q`. For more
//! steps all `F_k`, and the attitudes `R_k = F_1 ⋯ F_{k−1}` between them; `R_2 = F_1` and
//! `R_M = Q F_Mᵀ` need no variables of their own. Cost and group relations couple at most the three
//! rotations `R_k, F_k, F_{k+1}`: these are the cliques.

use super::polynomial::{
    Polynomial, PolynomialMatrix, Ring, constant_matrix, left_multiplied, transposed, vee_of_skew_part,
};
use crate::{Matrix3, Vector3};

/// Data of a chain, with momenta and inertia divided by the mean moment of inertia.
#[derive(Clone, Debug)]
pub(crate) struct ChainData {
    /// Nonstandard inertia `J_d` of the integrator.
    pub j_d: Matrix3,
    /// Weight `G` of the torque, in any unit.
    pub weight: Matrix3,
    /// Factor of the cost, 1/(2h³) in the header.
    pub factor: f64,
    /// Momentum times `h` before the first free step in the absence of torque, `a` in the header.
    pub before: Vector3,
    /// Momentum times `h` at the end, `b` in the header.
    pub after: Vector3,
    /// Factor of the first and the last term of the cost.
    pub end_factor: f64,
    /// Product `Q` of the free steps.
    pub whole: Matrix3,
    /// Largest angle of each free step \[rad\], at most π. Its length is the number M of free
    /// steps.
    pub angles: Vec<f64>,
    /// Whether all rotations are about the z axis.
    pub planar: bool,
}

/// A polynomial that is nonnegative within the angle range of a step.
#[derive(Clone, Debug)]
pub(crate) struct Limit {
    /// The normalised polynomial `(tr F − tr F_max)/(3 − tr F_max)`, between 0 and 1.
    pub polynomial: Polynomial,
    /// Index of the rotation in the polynomial.
    pub rotation: usize,
}

/// The chain as a polynomial optimisation problem.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chain {
    pub ring: Ring,
    /// Sets of rotations that occur together in a term.
    pub cliques: Vec<Vec<usize>>,
    pub cost: Polynomial,
    /// Upper bound of the sum of the magnitudes of all terms that were added to obtain `cost`.
    pub cost_magnitude: f64,
    /// Equality constraints, as polynomials that vanish: `R_k F_k = R_{k+1}`.
    pub relations: Vec<Polynomial>,
    /// Angle range of each step. Steps whose range is the whole rotation group are left out.
    pub limits: Vec<Limit>,
}

const ALL_AXES: &[usize] = &[1, 2, 3];
const Z_AXIS: &[usize] = &[3];

impl Chain {
    pub fn new(data: &ChainData) -> Self {
        let count = data.angles.len();
        let axes = if data.planar { Z_AXIS } else { ALL_AXES };
        let sine = |angle: f64| (0.5 * angle).sin().abs();
        // Variables: none for one step and F_1 alone for two; else F_1 … F_M and R_3 … R_{M−1}.
        let mut scale: Vec<f64> = match count {
            0 | 1 => Vec::new(),
            2 => vec![sine(data.angles[0])],
            _ => data.angles.iter().map(|angle| sine(*angle)).collect(),
        };
        let attitudes = count.saturating_sub(3);
        scale.resize(scale.len() + attitudes, 1.0);
        let ring = Ring { scale, axes };

        let steps: Vec<PolynomialMatrix> = match count {
            0 => Vec::new(),
            1 => vec![constant_matrix(&data.whole)],
            2 => {
                let first = ring.rotation(0);
                // F_2 = F_1ᵀ Q = (Qᵀ F_1)ᵀ
                let second = transposed(&left_multiplied(&data.whole.transpose(), &first));
                vec![first, second]
            }
            _ => (0..count).map(|id| ring.rotation(id)).collect(),
        };
        let mut chain = Self { ring, ..Self::default() };
        chain.add_costs(data, &steps);
        chain.add_limits(data, &steps);
        chain.add_relations(data, &steps);
        chain
    }

    fn add_costs(&mut self, data: &ChainData, steps: &[PolynomialMatrix]) {
        let constant = |vector: &Vector3| -> [Polynomial; 3] {
            std::array::from_fn(|i| Polynomial::constant(vector[i]))
        };
        let mut before = constant(&data.before);
        let mut factor = data.end_factor;
        for f in steps {
            let p = vee_of_skew_part(&transposed(&left_multiplied(&data.j_d, &transposed(f))));
            self.add_cost(&p, &before, factor * data.factor, &data.weight);
            before = vee_of_skew_part(&left_multiplied(&data.j_d, f));
            factor = 1.0;
        }
        self.add_cost(&constant(&data.after), &before, data.end_factor * data.factor, &data.weight);
    }

    /// Adds the term `factor · (a − b)ᵀ G (a − b)` to the cost.
    fn add_cost(&mut self, a: &[Polynomial; 3], b: &[Polynomial; 3], factor: f64, weight: &Matrix3) {
        let difference: [Polynomial; 3] = std::array::from_fn(|i| a[i].clone().plus(&b[i], -1.0));
        for i in 0..3 {
            for j in 0..3 {
                let product = self.ring.product(&difference[i], &difference[j]);
                self.cost.add(&product, factor * weight[(i, j)]);
                // Reduction multiplies the terms of degree four by at most (1 + 3)²; terms that
                // cancel in a − b are included.
                let size = |k: usize| a[k].magnitude() + b[k].magnitude();
                self.cost_magnitude += 16.0 * (factor * weight[(i, j)]).abs() * size(i) * size(j);
            }
        }
    }

    fn add_limits(&mut self, data: &ChainData, steps: &[PolynomialMatrix]) {
        for (index, (angle, f)) in data.angles.iter().zip(steps).enumerate() {
            let s = (0.5 * angle).sin();
            if *angle >= std::f64::consts::PI {
                continue;
            }
            // tr F = 3 − 4 sin²(θ/2)
            let mut polynomial = Polynomial::constant(4.0 * s * s - 3.0);
            for (k, row) in f.iter().enumerate() {
                polynomial.add(&row[k], 1.0);
            }
            let polynomial = Polynomial::default().plus(&polynomial, 1.0 / (4.0 * s * s));
            let rotation = if steps.len() <= 2 { 0 } else { index };
            self.limits.push(Limit { polynomial, rotation });
        }
    }

    fn add_relations(&mut self, data: &ChainData, steps: &[PolynomialMatrix]) {
        let count = steps.len();
        if count == 2 {
            self.cliques.push(vec![0]);
        }
        // The header counts the steps from 1, the code from 0.
        let attitude_id = |k: usize| if k == 2 { 0 } else { count + k - 3 };
        for k in 2..count {
            let (f, next) = (&steps[k - 1], &steps[k]);
            let attitude = self.ring.rotation(attitude_id(k));
            self.cliques.push(vec![attitude_id(k), k - 1, k]);
            let last = k + 1 == count;
            let after = if last {
                left_multiplied(&data.whole, &transposed(next))
            } else {
                self.ring.rotation(attitude_id(k + 1))
            };
            self.add_relation(&self.ring.matrix_product(&attitude, f), &after);
            if last {
                // Two equivalent forms of R F G = Q: F G = Rᵀ Q and G Qᵀ R = Fᵀ.
                let right = transposed(&left_multiplied(&data.whole.transpose(), &attitude));
                self.add_relation(&self.ring.matrix_product(f, next), &right);
                let turned = left_multiplied(&data.whole.transpose(), &attitude);
                self.add_relation(&self.ring.matrix_product(next, &turned), &transposed(f));
            }
        }
        self.relations = independent(std::mem::take(&mut self.relations));
    }

    fn add_relation(&mut self, a: &PolynomialMatrix, b: &PolynomialMatrix) {
        let pairs = a.iter().flatten().zip(b.iter().flatten());
        self.relations.extend(pairs.map(|(a, b)| a.clone().plus(b, -1.0)));
    }
}

/// Removes relations that depend linearly on earlier ones: dependent rows make the cone solver
/// fail.
fn independent(relations: Vec<Polynomial>) -> Vec<Polynomial> {
    let mut pivots: Vec<(super::polynomial::Monomial, Polynomial)> = Vec::new();
    let mut kept = Vec::new();
    for relation in relations {
        let size = relation.magnitude();
        let mut rest = relation.clone();
        for (monomial, row) in &pivots {
            let value = rest.terms.get(monomial).copied().unwrap_or(0.0);
            if value.abs() > 0.0 {
                rest.add(row, -value);
                rest.terms.remove(monomial);
            }
        }
        let largest = rest.terms.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let Some((monomial, value)) = largest.map(|(monomial, value)| (monomial.clone(), *value)) else {
            continue;
        };
        if value.abs() <= 1e-10 * size {
            continue;
        }
        pivots.push((monomial, Polynomial::default().plus(&rest, 1.0 / value)));
        kept.push(relation);
    }
    kept
}
