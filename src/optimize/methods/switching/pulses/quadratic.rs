//! Small dense quadratic programs: by exchange of the bounds that act, and by the cone solver where that does not come to an end.
//!
//! ```text
//! min ½ pᵀHp + gᵀp    with  Jp = c ,   p_b − p_a ≥ ℓ  for every bound (a, b, ℓ)
//! ```
//!
//! A bound is of a difference or, where `a` or `b` is absent, of one unknown. `H` is positive definite.
//!
//! Hintermüller, Ito, Kunisch, *The primal-dual active set strategy as a semismooth Newton method*, 2002.

use super::super::tuning::NEAR_ITERATIONS;
use super::super::tuning::pulses::EXACT;
use crate::optimize::convex::cone::{Cone, ConeSettings, ConeSolver, Program};
use crate::optimize::convex::sparse::{Sparse, SparseParts};
use nalgebra::{DMatrix, DVector};

/// `p_b − p_a ≥ least`; an absent unknown counts as 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    pub a: Option<usize>,
    pub b: Option<usize>,
    pub least: f64,
}

impl Bound {
    fn of(&self, p: &DVector<f64>) -> f64 {
        self.b.map_or(0.0, |b| p[b]) - self.a.map_or(0.0, |a| p[a])
    }

    /// Adds `Gᵀ` times a multiplier.
    pub fn add_to(&self, sum: &mut DVector<f64>, factor: f64) {
        if let Some(b) = self.b {
            sum[b] += factor;
        }
        if let Some(a) = self.a {
            sum[a] -= factor;
        }
    }
}

/// A program.
pub(super) struct Quadratic<'a> {
    /// `H`, n×n, positive definite.
    pub hessian: &'a DMatrix<f64>,
    /// `g`, n.
    pub gradient: &'a DVector<f64>,
    /// `J`, of full rank, and `c`.
    pub equations: Option<(&'a DMatrix<f64>, &'a DVector<f64>)>,
    pub bounds: &'a [Bound],
}

/// Its solution.
#[derive(Clone, Debug)]
pub(super) struct Optimum {
    pub p: DVector<f64>,
    /// Multipliers of the bounds, not negative.
    pub multipliers: Vec<f64>,
    /// Which bounds are met by it and press.
    pub acting: Vec<bool>,
}

impl Quadratic<'_> {
    /// Begun from a guess of the bounds that act, as of the program before it. `None` where the bounds and the equations leave nothing, or a
    /// number is not finite.
    pub fn solve(&self, guess: &[bool]) -> Option<Optimum> {
        self.exchanged(guess).or_else(|| {
            let mut solver = ConeSolver::new(self.program(), &ConeSettings::default()).ok()?;
            let answer = solver.solve();
            let found = answer.step()?;
            let equal = self.equations.map_or(0, |(_, c)| c.len());
            let multipliers = &found.z[equal..];
            // The larger of a bound's slack and multiplier is the one that does not vanish.
            let pairs = multipliers.iter().zip(&found.s[equal..]);
            let acting: Vec<bool> = pairs.map(|(multiplier, slack)| multiplier > slack).collect();
            self.exchanged(&acting).or_else(|| {
                let p = DVector::from_column_slice(&found.x);
                Some(Optimum { p, multipliers: multipliers.to_vec(), acting })
            })
        })
    }

    /// Bounds are exchanged, those that pull for those that are violated, until none are; `None` where that does not come to an end.
    fn exchanged(&self, guess: &[bool]) -> Option<Optimum> {
        let mut acting = guess.to_vec();
        for _ in 0..NEAR_ITERATIONS {
            let (p, multipliers) = self.at_bounds(&acting)?;
            let pulled = EXACT * (1.0 + multipliers.iter().fold(0.0_f64, |most, one| most.max(one.abs())));
            let each = self.bounds.iter().zip(&multipliers).zip(&acting);
            let next: Vec<bool> = each
                .map(
                    |((bound, multiplier), acts)| {
                        if *acts { *multiplier >= -pulled } else { bound.of(&p) - bound.least < -EXACT }
                    },
                )
                .collect();
            if next == acting {
                return Some(Optimum { p, multipliers, acting });
            }
            acting = next;
        }
        None
    }

    /// In the form of the cone solver: the equations first, then `s = p_b − p_a − ℓ ≥ 0`.
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
        for Bound { a, b, least } in self.bounds {
            let row = bound.len();
            entries.extend(b.map(|b| (row, b, -1.0)));
            entries.extend(a.map(|a| (row, a, 1.0)));
            bound.push(-least);
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

    /// The optimum with these bounds met and no others, and its multipliers; `None` where round-off leaves none.
    fn at_bounds(&self, acting: &[bool]) -> Option<(DVector<f64>, Vec<f64>)> {
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
            for (time, sign) in [(bound.b, 1.0), (bound.a, -1.0)] {
                if let Some(time) = time {
                    matrix[(row, time)] += sign;
                    matrix[(time, row)] -= sign;
                }
            }
            right[row] = bound.least;
        }
        let solved = matrix.clone().lu().solve(&right)?;
        let size = 1.0 + right.amax();
        let finite = solved.iter().all(|value| value.is_finite());
        let exact = finite && (&matrix * &solved - &right).amax() < EXACT * size;
        let p = solved.rows(0, n).into_owned();
        let mut multipliers = vec![0.0; acting.len()];
        for (row, index) in met.iter().enumerate() {
            multipliers[*index] = solved[n + equal + row];
        }
        exact.then_some((p, multipliers))
    }
}
