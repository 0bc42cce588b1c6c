//! The moment relaxation: a semidefinite program whose minimum is a lower bound on the cost of
//! every maneuver.
//!
//! A maneuver assigns every monomial a value, its moment `y`. The cost is linear in `y`, and so are
//! these conditions, which every maneuver and every mixture of maneuvers satisfies:
//!
//! ```text
//! Σ y[v vᵀ] ⪰ 0                   v: 1 and the entries of the rotations of a clique          (Shor, order 1)
//! y[R_k F_k − R_{k+1}] = 0
//! y[g_k] ≥ 0                      g_k = tr F_k − tr F_max                                    (angle range)
//! y[g_k q qᵀ] ⪰ 0, y[g_k g_l] ≥ 0   q: the quaternion of each rotation of the clique         (localised)
//! y[(q⊗r)(q⊗r)ᵀ] ⪰ 0              pairs of quaternions                                       (localised)
//! ```
//!
//! Order 2 uses all products of two entries for `v`, and the products of a quaternion and an entry
//! for `q`; it is built only if one rotation is free.

use super::Relaxation;
use super::chain::Chain;
use super::polynomial::{Monomial, Polynomial};
use crate::optimize::convex::cone::{Cone, Program};
use crate::optimize::convex::sparse::{Sparse, SparseParts};
use std::collections::{BTreeMap, BTreeSet};

/// The program `minimise offset + qᵀ y`, and the bounds that the certificate needs.
#[derive(Clone, Debug)]
pub(crate) struct MomentProgram {
    pub program: Program,
    /// Constant term of the cost.
    pub offset: f64,
    /// Upper bound of the magnitudes of the cost's terms, added before cancellation.
    pub cost_magnitude: f64,
    /// Largest trace that a maneuver gives to each semidefinite cone.
    pub traces: Vec<f64>,
    /// Number of semidefinite cones that are moment matrices of a clique. They are stored first.
    pub moment_matrices: usize,
}

/// Collector of rows `entry of the cone = constant + Σ coefficient · moment`.
#[derive(Default)]
struct MomentRows {
    moments: BTreeMap<Monomial, usize>,
    entries: Vec<(usize, usize, f64)>,
    bound: Vec<f64>,
}

impl MomentRows {
    fn moment(&mut self, monomial: &Monomial) -> usize {
        let next = self.moments.len();
        *self.moments.entry(monomial.clone()).or_insert(next)
    }

    /// Appends the row `s = factor · polynomial`, that is `−factor · Σ c y + s = factor · c_0`.
    fn push(&mut self, polynomial: &Polynomial, factor: f64) {
        let row = self.bound.len();
        for (monomial, value) in &polynomial.terms {
            if !monomial.is_empty() {
                let column = self.moment(monomial);
                self.entries.push((row, column, -factor * value));
            }
        }
        self.bound.push(factor * polynomial.constant_term());
    }

    fn push_all(&mut self, polynomials: &[Polynomial]) {
        polynomials.iter().for_each(|polynomial| self.push(polynomial, 1.0));
    }
}

/// Builds the relaxation; `None` if the chain has no free rotation.
pub(crate) fn build(chain: &Chain, relaxation: Relaxation) -> Option<MomentProgram> {
    if chain.cliques.is_empty() {
        return None;
    }
    let ring = &chain.ring;
    let mut rows = MomentRows::default();
    let mut cones = Vec::new();

    rows.push_all(&chain.relations);
    if !chain.relations.is_empty() {
        cones.push(Cone::Zero(chain.relations.len()));
    }

    let localized = matches!(relaxation, Relaxation::Localized | Relaxation::SecondOrder);
    let limits: &[_] = if relaxation == Relaxation::Shor { &[] } else { &chain.limits };
    let mut scalars: Vec<Polynomial> = Vec::new();
    if localized {
        for (index, limit) in limits.iter().enumerate() {
            for other in &limits[index + 1..] {
                let together = |clique: &&Vec<usize>| {
                    clique.contains(&limit.rotation) && clique.contains(&other.rotation)
                };
                if chain.cliques.iter().any(|clique| together(&clique)) {
                    scalars.push(ring.product(&limit.polynomial, &other.polynomial));
                }
            }
        }
    } else {
        scalars.extend(limits.iter().map(|limit| limit.polynomial.clone()));
    }
    rows.push_all(&scalars);
    if !scalars.is_empty() {
        cones.push(Cone::Nonnegative(scalars.len()));
    }

    // Semidefinite blocks, each from a multiplier and a basis.
    let one = Polynomial::constant(1.0);
    let (order, half) = if relaxation == Relaxation::SecondOrder { (4, 3) } else { (2, 1) };
    let mut blocks: Vec<(Polynomial, Vec<Polynomial>)> = Vec::new();
    for clique in &chain.cliques {
        let mut basis = vec![one.clone()];
        for &id in clique {
            basis.extend(ring.monomials(id, order));
        }
        blocks.push((one.clone(), basis));
    }
    let moment_matrices = blocks.len();
    if localized {
        for limit in limits {
            let around = chain.cliques.iter().filter(|clique| clique.contains(&limit.rotation));
            let partners: BTreeSet<usize> = around.flatten().copied().collect();
            blocks
                .extend(partners.into_iter().map(|id| (limit.polynomial.clone(), ring.monomials(id, half))));
        }
        let of_clique = |clique: &Vec<usize>| -> Vec<(usize, usize)> {
            let after = |index: usize| {
                clique[index + 1..].iter().map(move |&b| (clique[index].min(b), clique[index].max(b)))
            };
            (0..clique.len()).flat_map(after).collect()
        };
        let pairs: BTreeSet<(usize, usize)> = chain.cliques.iter().flat_map(of_clique).collect();
        for (a, b) in pairs {
            let right = ring.monomials(b, 1);
            let mut basis = Vec::new();
            for left in ring.monomials(a, 1) {
                basis.extend(right.iter().map(|right| ring.product(&left, right)));
            }
            blocks.push((one.clone(), basis));
        }
    }
    let mut traces = Vec::new();
    for (multiplier, basis) in &blocks {
        for column in 0..basis.len() {
            for row in 0..=column {
                let product = ring.product(&basis[row], &basis[column]);
                let factor = if row == column { 1.0 } else { std::f64::consts::SQRT_2 };
                rows.push(&ring.product(multiplier, &product), factor);
            }
        }
        cones.push(Cone::Semidefinite(basis.len()));
        // Monomials and multipliers have magnitudes of at most 1.
        traces.push(basis.len() as f64);
    }

    let mut cost: Vec<(usize, f64)> = Vec::new();
    for (monomial, value) in chain.cost.terms.iter().filter(|(monomial, _)| !monomial.is_empty()) {
        cost.push((rows.moment(monomial), *value));
    }
    let count = rows.moments.len();
    let mut linear = vec![0.0; count];
    cost.into_iter().for_each(|(index, value)| linear[index] += value);
    Some(MomentProgram {
        program: Program {
            quadratic: Sparse::zeros((count, count)),
            linear,
            matrix: Sparse::of_entries(rows.bound.len(), count, &rows.entries),
            bound: rows.bound,
            cones,
        },
        offset: chain.cost.constant_term(),
        cost_magnitude: chain.cost_magnitude,
        traces,
        moment_matrices,
    })
}
