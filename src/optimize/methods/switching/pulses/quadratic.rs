//! Small dense quadratic programs, by the predictor and corrector of Mehrotra.
//!
//! ```text
//! min ½ pᵀHp + gᵀp    with  Jp = c ,   p_b − p_a ≥ ℓ  for every bound (a, b, ℓ)
//! ```
//!
//! A bound is of a difference or, where `a` or `b` is absent, of one unknown. `H` is positive definite, so that every step solves by
//! two Cholesky factors: of `K = H + Gᵀ diag(z/s) G`, and of `J K⁻¹ Jᵀ`.
//!
//! Mehrotra, *On the implementation of a primal-dual interior point method*, 1992.

use super::super::tuning::pulses::*;
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
}

impl Quadratic<'_> {
    /// `None` where the bounds and the equations leave nothing, or a number is not finite.
    pub fn solve(&self) -> Option<Optimum> {
        let (n, m) = (self.gradient.len(), self.bounds.len());
        let none = DMatrix::zeros(0, n);
        let nothing = DVector::zeros(0);
        let (j, c) = self.equations.unwrap_or((&none, &nothing));
        let size = 1.0 + self.gradient.amax();
        let mut p = DVector::<f64>::zeros(n);
        let mut y = DVector::<f64>::zeros(c.len());
        let mut s: Vec<f64> = self.bounds.iter().map(|bound| (-bound.least).max(1e-2)).collect();
        let mut z = vec![1e-1 * size; m];
        let mut best: Option<(f64, Optimum)> = None;
        for _ in 0..MOST_ITERATIONS {
            let mut dual = self.hessian * &p + self.gradient - j.tr_mul(&y);
            for (bound, z) in self.bounds.iter().zip(&z) {
                bound.add_to(&mut dual, -z);
            }
            let equal = j * &p - c;
            let apart: Vec<f64> =
                self.bounds.iter().zip(&s).map(|(bound, s)| bound.of(&p) - s - bound.least).collect();
            let gap = s.iter().zip(&z).map(|(s, z)| s * z).sum::<f64>() / m.max(1) as f64;
            let farthest = apart.iter().fold(equal.amax(), |most, part| most.max(part.abs()));
            let left = (dual.amax() / size).max(gap / size).max(farthest);
            // The largest of numbers passes over NaN.
            if !dual.iter().chain(&equal).chain(&apart).chain([&gap]).all(|value| value.is_finite()) {
                break;
            }
            if best.as_ref().is_none_or(|(known, _)| left < *known) {
                best = Some((left, Optimum { p: p.clone(), multipliers: z.clone() }));
            }
            if left < SOLVED {
                break;
            }
            let mut k = self.hessian.clone();
            for ((bound, s), z) in self.bounds.iter().zip(&s).zip(&z) {
                let weight = z / s;
                for one in [bound.a, bound.b].into_iter().flatten() {
                    k[(one, one)] += weight;
                }
                if let (Some(a), Some(b)) = (bound.a, bound.b) {
                    k[(a, b)] -= weight;
                    k[(b, a)] -= weight;
                }
            }
            let Some(factor) = k.cholesky() else { break };
            let carried = factor.solve(&j.transpose());
            let schur = if c.is_empty() { None } else { Some(j * &carried) };
            let schur = match schur.map(nalgebra::DMatrix::cholesky) {
                Some(None) => break,
                Some(factor) => factor,
                None => None,
            };
            // The step for given products s z.
            let step = |products: &[f64]| {
                let mut q = -&dual;
                for (index, bound) in self.bounds.iter().enumerate() {
                    bound.add_to(&mut q, -(products[index] + z[index] * apart[index]) / s[index]);
                }
                let free = factor.solve(&q);
                let dy = schur
                    .as_ref()
                    .map_or_else(|| DVector::zeros(0), |schur| schur.solve(&(-&equal - j * &free)));
                let dp = free + &carried * &dy;
                let ds: Vec<f64> =
                    self.bounds.iter().zip(&apart).map(|(bound, apart)| bound.of(&dp) + apart).collect();
                let dz: Vec<f64> =
                    (0..m).map(|index| -(products[index] + z[index] * ds[index]) / s[index]).collect();
                (dp, dy, ds, dz)
            };
            let products: Vec<f64> = s.iter().zip(&z).map(|(s, z)| s * z).collect();
            let (_, _, ds, dz) = step(&products);
            let (of_s, of_z) = (longest(&s, &ds).min(1.0), longest(&z, &dz).min(1.0));
            let after = |index: usize| (s[index] + of_s * ds[index]) * (z[index] + of_z * dz[index]);
            let predicted = (0..m).map(after).sum::<f64>() / m.max(1) as f64;
            let center = if gap > 0.0 { (predicted / gap).clamp(0.0, 1.0).powi(3) * gap } else { 0.0 };
            let corrected: Vec<f64> =
                (0..m).map(|index| products[index] + ds[index] * dz[index] - center).collect();
            let (dp, dy, ds, dz) = step(&corrected);
            let length = (TO_BOUNDS * longest(&s, &ds).min(longest(&z, &dz))).min(1.0);
            p += length * dp;
            y += length * dy;
            for index in 0..m {
                s[index] += length * ds[index];
                z[index] += length * dz[index];
            }
        }
        let (_, near) = best.filter(|(left, _)| *left < NEARLY)?;
        let acting: Vec<bool> = self
            .bounds
            .iter()
            .zip(&near.multipliers)
            .map(|(bound, z)| *z > bound.of(&near.p) - bound.least)
            .collect();
        Some(self.at_bounds(&acting).unwrap_or(near))
    }

    /// The optimum with these bounds met and no others, exact to round-off where an interior point is not; `None` where they are not those
    /// of the optimum.
    fn at_bounds(&self, acting: &[bool]) -> Option<Optimum> {
        let n = self.gradient.len();
        let met: Vec<usize> = (0..acting.len()).filter(|index| acting[*index]).collect();
        let equal = self.equations.map_or(0, |(_, c)| c.len());
        let count = n + equal + met.len();
        if count == 0 {
            return None;
        }
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
        let kept = self.bounds.iter().all(|bound| bound.of(&p) - bound.least >= -EXACT);
        let mut multipliers = vec![0.0; acting.len()];
        for (row, index) in met.iter().enumerate() {
            multipliers[*index] = solved[n + equal + row];
        }
        let pressing = multipliers.iter().all(|multiplier| *multiplier >= -NEARLY * size);
        (exact && kept && pressing).then_some(Optimum { p, multipliers })
    }
}

/// The multiple of a step at which the first number vanishes.
fn longest(values: &[f64], step: &[f64]) -> f64 {
    let pairs = values.iter().zip(step).filter(|(_, step)| **step < 0.0);
    pairs.map(|(value, step)| -value / step).fold(f64::INFINITY, f64::min)
}
