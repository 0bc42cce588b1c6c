//! Small dense quadratic programs, solved by a primal-dual active set method, and by the cone
//! solver if that does not converge.
//!
//! ```text
//! min ½ pᵀHp + gᵀp    with  Jp = c ,   p_b − p_a ≥ ℓ  for every bound (a, b, ℓ)
//! ```
//!
//! A bound applies to a difference of two unknowns or, if `a` or `b` is absent, to one unknown. `H`
//! is positive definite.
//!
//! Hintermüller, Ito, Kunisch, *The primal-dual active set strategy as a semismooth Newton method*,
//! 2002.

use super::bounds::Bound;
use crate::optimize::convex::cone::{Cone, ConeSettings, ConeSolver, Program};
use crate::optimize::convex::sparse::{Sparse, SparseParts};
use nalgebra::{DMatrix, DVector};

/// Largest number of active set iterations before the cone solver is used: longer iterations
/// usually cycle.
const EXCHANGES: usize = 12;

/// Relative tolerance of the equations at the active bounds, and of the violation of inactive
/// bounds. With a smaller tolerance round-off would change the active set; with a larger one times
/// would differ from their bounds.
const EXACT: f64 = 1e-11;

/// Data of a quadratic program.
pub(crate) struct Quadratic<'a> {
    /// Hessian `H`, n×n, positive definite.
    pub hessian: &'a DMatrix<f64>,
    /// Gradient `g`, length n.
    pub gradient: &'a DVector<f64>,
    /// Matrix `J` of full rank and right-hand side `c` of the equations; `None` without equations.
    pub equations: Option<(&'a DMatrix<f64>, &'a DVector<f64>)>,
    pub bounds: &'a [Bound],
}

/// Solution of a quadratic program.
#[derive(Clone, Debug)]
pub(crate) struct QuadraticOptimum {
    pub p: DVector<f64>,
    /// `Jᵀ` times the multipliers of the equations: `Hp + g` without the contribution of the active
    /// bounds.
    pub pull: DVector<f64>,
    /// For each bound, true if it is active.
    pub acting: Vec<bool>,
}

impl Quadratic<'_> {
    /// Solves the program from a guess of the active bounds, such as those of the previous program.
    /// Returns `None` if bounds and equations leave no feasible point, or a number is not finite.
    pub fn solve(&self, guess: &[bool]) -> Option<QuadraticOptimum> {
        self.exchanged(guess).or_else(|| {
            let mut solver = ConeSolver::new(self.program(), &ConeSettings::default()).ok()?;
            let answer = solver.solve();
            let found = answer.step()?;
            let equal = self.equations.map_or(0, |(_, c)| c.len());
            let multipliers = &found.z[equal..];
            // Of a bound's slack and multiplier, the smaller one is zero up to round-off.
            let pairs = multipliers.iter().zip(&found.s[equal..]);
            let acting: Vec<bool> = pairs.map(|(multiplier, slack)| multiplier > slack).collect();
            self.exchanged(&acting).or_else(|| {
                let p = DVector::from_column_slice(&found.x);
                let mut pull = self.hessian * &p + self.gradient;
                for (bound, multiplier) in self.bounds.iter().zip(multipliers) {
                    bound.write(-multiplier, |unknown, part| pull[unknown] += part);
                }
                Some(QuadraticOptimum { p, pull, acting })
            })
        })
    }

    /// Solves by the active set method: bounds with a negative multiplier are dropped and violated
    /// bounds are added, until neither occurs. Returns `None` if the iteration does not converge.
    fn exchanged(&self, guess: &[bool]) -> Option<QuadraticOptimum> {
        let mut acting = guess.to_vec();
        for _ in 0..EXCHANGES {
            let (p, pull, multipliers) = self.at_bounds(&acting)?;
            let pulled = EXACT * (1.0 + multipliers.iter().fold(0.0_f64, |most, one| most.max(one.abs())));
            let each = self.bounds.iter().zip(&multipliers).zip(&acting);
            let next: Vec<bool> = each
                .map(
                    |((bound, multiplier), acts)| {
                        if *acts { *multiplier >= -pulled } else { bound.slack(&p) < -EXACT }
                    },
                )
                .collect();
            if next == acting {
                return Some(QuadraticOptimum { p, pull, acting });
            }
            acting = next;
        }
        None
    }

    /// Converts the program to the form of the cone solver: the equations first, then
    /// `s = p_b − p_a − ℓ ≥ 0`.
    fn program(&self) -> Program {
        let n = self.gradient.len();
        let upper = (0..n).flat_map(|column| (0..=column).map(move |row| (row, column)));
        let quadratic: Vec<_> =
            upper.map(|(row, column)| (row, column, self.hessian[(row, column)])).collect();
        let (mut entries, mut bound) = (Vec::new(), Vec::new());
        if let Some((j, c)) = self.equations {
            let all = (0..n).flat_map(|column| (0..c.len()).map(move |row| (row, column)));
            entries.extend(all.map(|(row, column)| (row, column, j[(row, column)])));
            bound.extend(c.iter());
        }
        let equal = bound.len();
        for constraint in self.bounds {
            constraint.write(-1.0, |unknown, sign| entries.push((bound.len(), unknown, sign)));
            bound.push(-constraint.least);
        }
        let cones = [Cone::Zero(equal), Cone::Nonnegative(self.bounds.len())];
        Program {
            quadratic: Sparse::of_entries(n, n, &quadratic),
            linear: self.gradient.iter().copied().collect(),
            matrix: Sparse::of_entries(bound.len(), n, &entries),
            bound,
            cones: cones.into_iter().filter(|cone| cone.rows() > 0).collect(),
        }
    }

    /// Solves the program with exactly the bounds in `acting` active. Returns the optimum, its
    /// `pull` and the multipliers of the bounds; `None` if the linear system cannot be solved to
    /// the tolerance.
    fn at_bounds(&self, acting: &[bool]) -> Option<(DVector<f64>, DVector<f64>, Vec<f64>)> {
        let n = self.gradient.len();
        let met: Vec<usize> = (0..acting.len()).filter(|index| acting[*index]).collect();
        let equal = self.equations.map_or(0, |(_, c)| c.len());
        let count = n + equal + met.len();
        let (mut matrix, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
        matrix.view_mut((0, 0), (n, n)).copy_from(self.hessian);
        right.rows_mut(0, n).copy_from(&-self.gradient);
        if let Some((j, c)) = self.equations {
            matrix.view_mut((n, 0), (equal, n)).copy_from(j);
            matrix.view_mut((0, n), (n, equal)).copy_from(&-j.transpose());
            right.rows_mut(n, equal).copy_from(c);
        }
        for (row, index) in met.iter().enumerate() {
            let (row, bound) = (n + equal + row, &self.bounds[*index]);
            bound.write(1.0, |unknown, sign| {
                matrix[(row, unknown)] += sign;
                matrix[(unknown, row)] -= sign;
            });
            right[row] = bound.least;
        }
        let solved = matrix.clone().lu().solve(&right)?;
        let size = 1.0 + right.amax();
        let finite = solved.iter().all(|value| value.is_finite());
        let exact = finite && (&matrix * &solved - &right).amax() < EXACT * size;
        let pull = -matrix.view((0, n), (n, equal)) * solved.rows(n, equal);
        let mut multipliers = vec![0.0; acting.len()];
        for (row, index) in met.iter().enumerate() {
            multipliers[*index] = solved[n + equal + row];
        }
        exact.then(|| (solved.rows(0, n).into_owned(), pull, multipliers))
    }
}
