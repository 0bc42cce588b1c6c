//! The Newton direction of a path and the inertia of its Hessian, by one backward and one forward
//! sweep.
//!
//! Stage k maps `z_k = (ζ_k, δΠ_k)` to `z_{k+1} = A_k z_k + h_{k+1} E δτ_{k+1}` at the cost `½ z_kᵀ
//! Ĥ_k z_k + (h/2) δτᵀŴδτ + g_kᵀζ_k`, where `Ĥ` is the symmetric part of `H_k`, shifted by `δ h
//! diag(m, 0)` with the metric `m` of the inertia. The last two stages are eliminated with the end
//! fixed, the others by the Riccati recursion:
//!
//! ```text
//! k = N−1:   L = −A12⁻¹A11 ,  K = −(A21 + A22 L)/h_N ,   P̂ = [I;L]ᵀĤ[I;L] + h_N KᵀŴ_N K ,   ĝ = g_{N−1}
//! k = N−2:   T = [A11 A12] ,  K = (L T − [A21 A22])/h ,  P = Ĥ + TᵀP̂T + h KᵀŴ_{N−1}K ,    q = [g;0] + Tᵀĝ
//! k < N−2:   U = Ŵ_{k+1} + h EᵀPE ,   Y = PE U⁻¹ ,   κ = −U⁻¹Eᵀq ,   δτ = κ − Yᵀ A z ,
//!            S = P − h Y EᵀP ,   P ← Ĥ + AᵀSA ,   q ← [g_k;0] + Aᵀ(q − h Y Eᵀq)
//! node 0:    U = Ŵ_0 + h_0 EᵀPE ,   δτ_0 = −U⁻¹Eᵀq
//! ```
//!
//! S is the Schur complement of P after the input of the kick is eliminated. Its momentum rows are
//! `YŴ`, which needs no subtraction.
//!
//! The Hessian with respect to the inner nodes is congruent to the blocks `h U`: it is positive
//! definite if and only if every U is. Without a shift, at a stationary path, this is the
//! second-order test.

use super::path::{Direction, Path, Setting, block};
use super::{Block, Half};
use crate::numerics::widest::widest;
use crate::optimize::discrete::step::{Costate, Dynamics};
use nalgebra::SymmetricEigen;

/// A pivot below this fraction of its weight is a flat direction, which is due to a symmetry and
/// does not indicate a saddle.
const FLAT: f64 = 1e-9;

/// Shift of the Hessian, in units of the inertia's metric.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shift(pub f64);

/// One linearised stage, in blocks of configurations and momenta.
#[derive(Clone, Copy, Debug)]
struct Stage<const D: usize> {
    a11: Block<D>,
    a12: Block<D>,
    /// Contribution of the kick's gradient; `None` if no field depends on the pose.
    a21: Option<Block<D>>,
    a22: Block<D>,
    /// Hessian block of the configurations, without the shift.
    h11: Block<D>,
    h12: Block<D>,
    h22: Block<D>,
    /// Duration of the step, scaled.
    length: f64,
}

/// Symmetric matrix in blocks of configurations and momenta.
#[derive(Clone, Copy, Debug)]
struct Symmetric<const D: usize> {
    p11: Block<D>,
    p12: Block<D>,
    p22: Block<D>,
}

/// Gain in `δτ = κ − Yᵀ z`, with the state z before the kick, and the weight of the kick.
#[derive(Clone, Copy, Debug)]
struct Gain<const D: usize> {
    of_configuration: Block<D>,
    of_momentum: Block<D>,
    offset: Half<D>,
    /// Weight `h` of the kick: its time, scaled.
    h: f64,
}

/// The backward sweep, up to the stage that it reached.
pub(super) struct Backward<const D: usize> {
    /// Stages of the path, as far as they were needed; they do not depend on the shift.
    stages: Vec<Option<Stage<D>>>,
    gains: Vec<Option<Gain<D>>>,
    /// Input `δτ` at the first kick.
    opening: Half<D>,
    /// Pivot at which the last sweep failed, because it is not positive definite.
    failed: Block<D>,
}

impl<const D: usize> Backward<D> {
    pub fn new(steps: usize) -> Self {
        Self {
            stages: vec![None; steps],
            gains: vec![None; steps],
            opening: Half::zeros(),
            failed: Block::zeros(),
        }
    }

    /// Prepares for a sweep along another path.
    pub fn renew(&mut self) {
        self.stages.fill(None);
    }

    /// Sweeps backward, with the widest vector registers of the processor. The error is the index
    /// of the node whose pivot is not positive definite.
    pub fn sweep<const N: usize>(
        &mut self,
        setting: &Setting<N, D>,
        path: &Path<D>,
        shift: Shift,
    ) -> Result<(), usize> {
        widest(
            #[inline(always)]
            || self.sweep_in(setting, path, shift),
        )
    }

    #[inline(always)]
    fn sweep_in<const N: usize>(
        &mut self,
        setting: &Setting<N, D>,
        path: &Path<D>,
        shift: Shift,
    ) -> Result<(), usize> {
        let Setting { dynamics, first, inverse, .. } = setting;
        let Self { stages, gains, opening, failed } = self;
        let grid = &dynamics.grid;
        let steps = grid.steps();
        let metric = metric::<D>(dynamics, &inverse.traces()) * shift.0;
        let weight = |node: usize| inverse.weight::<D>(&path.poses[node].attitude);
        let shifted = |stage: &Stage<D>| stage.h11 + metric * stage.length;
        // Stage N−1.
        let last = Stage::at(stages, setting, path, steps - 1);
        let h = grid.kick(steps);
        let l = -(last.a12.try_inverse().ok_or(steps - 1)? * last.a11);
        let k = -(last.a21.unwrap_or_else(Block::zeros) + last.a22 * l) / h;
        let cross = last.h12 * l;
        let end = shifted(last)
            + cross
            + cross.transpose()
            + l.tr_mul(&(last.h22 * l))
            + k.tr_mul(&(weight(steps) * k)) * h;
        // Stage N−2.
        let stage = Stage::at(stages, setting, path, steps - 2);
        let Stage { a11, a12, a21, a22, h12, h22, .. } = stage;
        let h = grid.kick(steps - 1);
        let k1 = (l * a11 - a21.unwrap_or_else(Block::zeros)) / h;
        let k2 = (l * a12 - a22) / h;
        let w = weight(steps - 1) * h;
        let (end1, end2, wk2) = (end * a11, end * a12, w * k2);
        let mut p = Symmetric {
            p11: shifted(stage) + a11.tr_mul(&end1) + k1.tr_mul(&(w * k1)),
            p12: h12 + a11.tr_mul(&end2) + k1.tr_mul(&wk2),
            p22: h22 + a12.tr_mul(&end2) + k2.tr_mul(&wk2),
        };
        let g = &path.gradient[steps - 1];
        let mut q = (path.gradient[steps - 2] + a11.tr_mul(g), a12.tr_mul(g));
        // δτ = (L ζ − δΠ)/h of the state before the kick.
        gains[steps - 2] = Some(Gain {
            of_configuration: -l.transpose() / h,
            of_momentum: Block::identity() / h,
            offset: Half::zeros(),
            h,
        });
        for index in (*first..steps - 2).rev() {
            let h = grid.kick(index + 1);
            let weight = weight(index + 1);
            let inverse = pivot(&weight, &(p.p22 * h)).map_err(|u| {
                *failed = u;
                index + 1
            })?;
            let stage = Stage::at(stages, setting, path, index);
            let (y1, y2) = (product(&p.p12, &inverse), product(&p.p22, &inverse));
            let left = Symmetric {
                p11: p.p11 - product(&(y1 * h), &p.p12.transpose()),
                p12: product(&y1, &weight),
                p22: product(&y2, &weight),
            };
            let offset = -(inverse * q.1);
            let moved = (q.0 - y1 * q.1 * h, q.1 - y2 * q.1 * h);
            (p, q) = stage.before(&left, &shifted(stage), &moved);
            q.0 += path.gradient[index];
            gains[index] = Some(Gain { of_configuration: y1, of_momentum: y2, offset, h });
        }
        let h = grid.kick(*first);
        let inverse = pivot(&weight(*first), &(p.p22 * h)).map_err(|u| {
            *failed = u;
            *first
        })?;
        *opening = -(inverse * q.1) * h;
        Ok(())
    }

    /// Computes the Newton direction from the backward sweep.
    pub fn forward<const N: usize>(&self, setting: &Setting<N, D>, direction: &mut Direction<D>) {
        self.follow(setting.first, Half::zeros(), self.opening, 1.0, direction);
    }

    /// Computes the direction of negative curvature at the node whose pivot failed: zero before
    /// this node, and by the gains after it.
    pub fn downward<const N: usize>(
        &self,
        setting: &Setting<N, D>,
        node: usize,
        direction: &mut Direction<D>,
    ) {
        let eigen = SymmetricEigen::new(nalgebra::DMatrix::from_fn(D, D, |row, column| {
            0.5 * (self.failed[(row, column)] + self.failed[(column, row)])
        }));
        let lowest = eigen.eigenvalues.imin();
        let vector = Half::from_fn(|row, _| eigen.eigenvectors[(row, lowest)]);
        let kick = setting.dynamics.grid.kick(node);
        self.follow(node, Half::zeros(), vector * kick, 0.0, direction);
    }

    /// Propagates a displacement from node `from` to the end with the gains, and writes it to
    /// `direction`. The offsets of the gains are multiplied by `offsets`.
    fn follow(
        &self,
        from: usize,
        configuration: Half<D>,
        momentum: Half<D>,
        offsets: f64,
        direction: &mut Direction<D>,
    ) {
        direction.zeta.iter_mut().for_each(|zeta| *zeta = Half::zeros());
        let (mut configuration, mut momentum) = (configuration, momentum);
        for (index, gain) in self.gains.iter().enumerate().skip(from) {
            direction.zeta[index] = configuration;
            let Some((gain, stage)) = gain.as_ref().zip(self.stages[index].as_ref()) else { break };
            let Gain { of_configuration, of_momentum, offset, h } = gain;
            let drifted = stage.a22 * momentum;
            let drifted = stage.a21.map_or(drifted, |a21| a21 * configuration + drifted);
            configuration = stage.a11 * configuration + stage.a12 * momentum;
            let answer = of_configuration.tr_mul(&configuration) + of_momentum.tr_mul(&drifted);
            momentum = drifted + (offset * offsets - answer) * *h;
        }
    }
}

impl<const D: usize> Stage<D> {
    /// Returns stage `index` of a path, and keeps it for later sweeps.
    #[inline(always)]
    fn at<'s, const N: usize>(
        stages: &'s mut [Option<Self>],
        setting: &Setting<N, D>,
        path: &Path<D>,
        index: usize,
    ) -> &'s Self {
        match &mut stages[index] {
            Some(stage) => stage,
            // `get_or_insert_with` would be a separate call, in narrow registers.
            none => none.insert(Self::of(setting, path, index)),
        }
    }

    /// Returns `Ĥ + AᵀSA` and `Aᵀq`: curvature and slope with respect to the state before the
    /// stage.
    #[inline(always)]
    fn before(
        &self,
        s: &Symmetric<D>,
        shifted: &Block<D>,
        q: &(Half<D>, Half<D>),
    ) -> (Symmetric<D>, (Half<D>, Half<D>)) {
        let Self { a11, a12, a21, a22, h12, h22, .. } = self;
        let (a11_t, a12_t, a22_t) = (a11.transpose(), a12.transpose(), a22.transpose());
        let s21 = s.p12.transpose();
        // SA, by rows of configurations and of momenta.
        let mut sa11 = product(&s.p11, a11);
        let sa12 = product(&s.p11, a12) + product(&s.p12, a22);
        let sa22 = product(&s21, a12) + product(&s.p22, a22);
        if let Some(a21) = a21 {
            sa11 += product(&s.p12, a21);
        }
        let mut p11 = shifted + product(&a11_t, &sa11);
        let mut p12 = h12 + product(&a11_t, &sa12);
        let p22 = h22 + product(&a12_t, &sa12) + product(&a22_t, &sa22);
        let mut slope = (a11_t * q.0, a12_t * q.0 + a22_t * q.1);
        if let Some(a21) = a21 {
            let a21_t = a21.transpose();
            p11 += product(&a21_t, &(product(&s21, a11) + product(&s.p22, a21)));
            p12 += product(&a21_t, &sa22);
            slope.0 += a21_t * q.1;
        }
        (Symmetric { p11: symmetric(&p11), p12, p22: symmetric(&p22) }, slope)
    }

    /// Computes stage `index` of a path.
    #[inline(always)]
    fn of<const N: usize>(setting: &Setting<N, D>, path: &Path<D>, index: usize) -> Self {
        let dynamics = setting.dynamics;
        let weight = dynamics.grid.kick(index + 1);
        let (drift, after) = (&path.drifts[index], &path.between[index]);
        let linear = dynamics.linear_drift(drift, &dynamics.drift_matrix(drift), after);
        let identity = nalgebra::Matrix3::identity();
        let a11 = diagonal::<D>(&identity, &linear.f_t);
        let a12 = diagonal::<D>(&(identity * drift.h), &linear.b);
        let a22 = diagonal::<D>(&identity, &linear.c);
        let zero = nalgebra::Matrix3::zeros();
        let h12 = diagonal::<D>(&zero, &linear.h12) * 0.5;
        let h22 = symmetric(&diagonal::<D>(&zero, &linear.h22));
        let (a21, h11, length) = (None, Block::zeros(), drift.h);
        let mut stage = Self { a11, a12, a21, a22, h11, h12, h22, length };
        let node = index + 1;
        let dual: Costate = path.dual(node);
        let kick = dynamics.linear_kick::<N>(&path.poses[node], &dual);
        if let Some((pq, qq)) = &kick.field {
            let pq = block::<D>(pq) * weight;
            stage.a21 = Some(pq * a11);
            stage.a22 += pq * a12;
            let qq = symmetric(&block::<D>(qq)) * weight;
            let (qq1, qq2) = (qq * a11, qq * a12);
            stage.h11 += a11.tr_mul(&qq1);
            stage.h12 += a11.tr_mul(&qq2);
            stage.h22 += a12.tr_mul(&qq2);
        }
        stage
    }
}

/// Returns the metric by which a shift of the Hessian is scaled: `(tr Ŵ/3) J²` for rotations, `tr
/// Ŵ/3` for translations.
fn metric<const D: usize>(dynamics: &Dynamics, traces: &(f64, f64)) -> Block<D> {
    let identity = nalgebra::Matrix3::identity();
    diagonal(&(identity * (traces.0 / 3.0)), &(dynamics.j * dynamics.j * (traces.1 / 3.0)))
}

/// Returns the block-diagonal matrix of a translation and a rotation.
#[inline(always)]
pub(super) fn diagonal<const D: usize>(
    translation: &nalgebra::Matrix3<f64>,
    rotation: &nalgebra::Matrix3<f64>,
) -> Block<D> {
    Block::from_fn(|row, column| match (row + 3 < D, column + 3 < D) {
        (true, true) => translation[(row, column)],
        (false, false) => rotation[(row + 3 - D, column + 3 - D)],
        _ => 0.0,
    })
}

#[inline(always)]
fn symmetric<const D: usize>(matrix: &Block<D>) -> Block<D> {
    (matrix + matrix.transpose()) * 0.5
}

/// Returns the inverse of `U = Ŵ + h EᵀPE` if that is positive definite; otherwise the error is U.
#[inline(always)]
fn pivot<const D: usize>(weight: &Block<D>, curvature: &Block<D>) -> Result<Block<D>, Block<D>> {
    let u = weight + curvature;
    inverse_of_positive(&u, FLAT * weight.trace()).ok_or(u)
}

/// Computes `A B` inline; the product of nalgebra is a call.
#[inline(always)]
fn product<const D: usize>(a: &Block<D>, b: &Block<D>) -> Block<D> {
    let mut product = Block::zeros();
    for (out, factors) in product.data.0.iter_mut().zip(&b.data.0) {
        for (column, factor) in a.data.0.iter().zip(factors) {
            for (out, value) in out.iter_mut().zip(column) {
                *out += value * factor;
            }
        }
    }
    product
}

/// Returns the inverse of a symmetric matrix; `None` if a pivot is below `-flat`. A pivot within
/// `flat` of zero counts as `flat`.
#[inline(always)]
fn inverse_of_positive<const D: usize>(matrix: &Block<D>, flat: f64) -> Option<Block<D>> {
    let mut lower = Block::<D>::zeros();
    for column in 0..D {
        let mut pivot = matrix[(column, column)];
        for inner in 0..column {
            pivot -= lower[(column, inner)] * lower[(column, inner)];
        }
        // NaN counts as not positive.
        if pivot.is_nan() || pivot <= -flat {
            return None;
        }
        let root = pivot.max(flat).sqrt();
        lower[(column, column)] = root;
        for row in column + 1..D {
            let mut value = 0.5 * (matrix[(row, column)] + matrix[(column, row)]);
            for inner in 0..column {
                value -= lower[(row, inner)] * lower[(column, inner)];
            }
            lower[(row, column)] = value / root;
        }
    }
    let mut inverse = Block::<D>::identity();
    for column in 0..D {
        for row in column..D {
            let mut value = inverse[(row, column)];
            for inner in column..row {
                value -= lower[(row, inner)] * inverse[(inner, column)];
            }
            inverse[(row, column)] = value / lower[(row, row)];
        }
    }
    Some(inverse.tr_mul(&inverse))
}
