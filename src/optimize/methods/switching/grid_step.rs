//! One step of Lie–Verlet under a torque that is held over it, of its costates, and its discrete Hamiltonian.
//!
//! ```text
//! Π̃ = Π + (h/2) τ ,   h S(Π̃) = F J_d − J_d Fᵀ ,   R⁺ = R F ,   Π⁺ = FᵀΠ̃ + (h/2) τ
//! m⁺ = Fᵀm ,   e⁺ = Fᵀ(e + h E⁻¹(Π̃×e − m)) ,   E = tr(F J_d) I − F J_d
//! 𝓗  = p + ℓ + m⁺·ξ' + e⁺·[(FᵀΠ̃)×ξ' + ½Fᵀτ + ½τ] ,   ξ' = FᵀE⁻¹(Π̃ + (h/2) τ)
//! ```
//!
//! `𝓗` is the derivative of the discrete action with respect to the length of the step, `p` the price of time, and
//! `ℓ` what the inputs and smoothing cost. The smoothed law takes the mean of the costates at both ends, which makes
//! the step implicit in the torque.

#![expect(
    clippy::needless_range_loop,
    reason = "iterators are calls of their own, and narrow in widened code"
)]

use super::dual::{Dual, Dual3};
use super::extremal::{ArcLaw, Extremal, Response};
use super::tuning::grid::{LAST_CHANGE, MOST_OF_TORQUE};
use crate::mechanics::drift_equation;
use crate::numerics::three::apply;
use crate::numerics::widest::widest;
use crate::{Matrix3, Vector3, lie};

/// Parameters of a step: `m`, `Π`, `e`, `h`.
const PARAMETERS: usize = 10;
/// The same and the torque, where it answers to them.
const WITH_TORQUE: usize = PARAMETERS + 3;

/// How the torque of a step comes about.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Torque {
    /// Held, and given, with what the inputs cost.
    Given { torque: Vector3, running: f64 },
    /// Of full norm, turning with the costate.
    Turning(ArcLaw),
    /// By the smoothed law at this ε.
    Smooth(f64),
}

/// What one step does, and its derivative with respect to `m`, `Π`, `e`, `h`.
#[derive(Clone, Debug)]
pub(crate) struct GridStep {
    pub f: Matrix3,
    pub pi: Vector3,
    pub e: Vector3,
    pub hamiltonian: f64,
    pub torque: Vector3,
    /// Rows: the turn `F⁻ᵀδFᵀ` before the step's rotation, `δΠ⁺`, `δe⁺`, `δ𝓗`.
    pub jacobian: [[f64; PARAMETERS]; 10],
}

struct Out<const L: usize> {
    c: Dual3<L>,
    pi: Dual3<L>,
    e: Dual3<L>,
    hamiltonian: Dual<L>,
}

struct In<const L: usize> {
    m: Dual3<L>,
    pi: Dual3<L>,
    e: Dual3<L>,
    h: Dual<L>,
    torque: Dual3<L>,
    running: Dual<L>,
}

/// `cay(c) v`, or its transpose for a negative sign.
#[inline(always)]
fn turned<const L: usize>(c: &Dual3<L>, weight: &Dual<L>, v: &Dual3<L>, sign: f64) -> Dual3<L> {
    let once = c.cross(v);
    *v + (once.scale(sign) + c.cross(&once)).times(weight)
}

/// What the drift of a step turns and solves by: its rotation `F` and its matrix `E`.
struct Drift<const L: usize> {
    c: Dual3<L>,
    /// `2/(1 + |c|²)`.
    weight: Dual<L>,
    /// `tr(F J_d)`.
    trace: Dual<L>,
    j_d: Matrix3,
    /// `E⁻¹`, without derivatives.
    inverse: Matrix3,
}

impl<const L: usize> Drift<L> {
    /// `Fᵀv`.
    #[inline(always)]
    fn back(&self, v: &Dual3<L>) -> Dual3<L> {
        turned(&self.c, &self.weight, v, -1.0)
    }

    /// `E⁻¹x`.
    #[inline(always)]
    fn solve(&self, x: &Dual3<L>) -> Dual3<L> {
        let y = apply(&self.inverse, &x.value());
        let fixed = Dual3::constant(&y);
        let applied = fixed.times(&self.trace) - turned(&self.c, &self.weight, &fixed.under(&self.j_d), 1.0);
        (*x - applied).under(&self.inverse).with_value(&y)
    }
}

impl Extremal {
    #[inline(always)]
    fn drifted<const L: usize>(&self, given: &In<L>) -> Option<Out<L>> {
        let In { m, pi, e, h, torque, running } = given;
        let half = torque.times(&h.scale(0.5));
        let kicked = *pi + half;
        let g = kicked.times(h);
        // The implicit equation g + g×c + (g·c)c = 2Jc: solved in values, then once in derivatives.
        let (g0, c0) = (g.value(), drift_equation::solve(&self.j, &self.j_inverse, &g.value())?);
        let c_fixed = Dual3::constant(&c0);
        let residual = g + g.cross(&c_fixed) + c_fixed.times(&g.dot(&c_fixed));
        let slope = 2.0 * self.j - lie::hat(&g0) - Matrix3::identity() * g0.dot(&c0) - c0 * g0.transpose();
        let inverse = drift_equation::inverse3(&slope);
        let c = residual.under(&inverse).with_value(&c0);
        let square = c.dot(&c);
        let weight = (Dual::constant(1.0) + square).recip().scale(2.0);
        let j_d = 0.5 * self.j.trace() * Matrix3::identity() - self.j;
        let trace =
            Dual::constant(j_d.trace()) + (c.dot(&c.under(&j_d)) - square.scale(j_d.trace())) * weight;
        let c0 = c.value();
        let f = lie::cayley(&c0);
        let matrix = Matrix3::identity() * trace.value - f * j_d;
        let drift = Drift { c, weight, trace, j_d, inverse: drift_equation::inverse3(&matrix) };
        let drifted = drift.back(&kicked);
        let m_after = drift.back(m);
        let e_after = drift.back(&(*e + drift.solve(&(kicked.cross(e) - *m)).times(h)));
        let xi = drift.back(&drift.solve(&(kicked + half)));
        let pull = drifted.cross(&xi) + (drift.back(torque) + *torque).scale(0.5);
        let hamiltonian = Dual::constant(self.time_price) + *running + m_after.dot(&xi) + e_after.dot(&pull);
        Some(Out { c, pi: drifted + half, e: e_after, hamiltonian })
    }

    /// A law that answers to the costate; none for a torque that is given.
    #[inline(always)]
    fn answer(&self, torque: &Torque, e: &Vector3) -> Option<Response> {
        match torque {
            Torque::Given { .. } => None,
            Torque::Turning(law) => Some(law.at(e)),
            Torque::Smooth(epsilon) => Some(self.smooth(e, *epsilon, &Vector3::zeros())),
        }
    }

    /// The torque of a step by a law, by Newton on `τ = law(½(e + e⁺(τ)))`, and `(1 + ½ G ∂e⁺/∂τ)⁻¹ G`; from the costate after
    /// the step as it is expected, or else from that before.
    #[inline(always)]
    fn implicit_torque(
        &self,
        m: &Vector3,
        pi: &Vector3,
        [e, expected]: [&Vector3; 2],
        h: f64,
        by: &Torque,
    ) -> Option<(Vector3, Matrix3)> {
        let first = self.answer(by, &(0.5 * (e + expected)))?.torque;
        self.torque_from(first, m, pi, e, h, by)
            .or_else(|| self.torque_from(self.answer(by, e)?.torque, m, pi, e, h, by))
    }

    #[inline(always)]
    fn torque_from(
        &self,
        mut torque: Vector3,
        m: &Vector3,
        pi: &Vector3,
        e: &Vector3,
        h: f64,
        by: &Torque,
    ) -> Option<(Vector3, Matrix3)> {
        for _ in 0..MOST_OF_TORQUE {
            let out = self.drifted::<3>(&In {
                m: Dual3::constant(m),
                pi: Dual3::constant(pi),
                e: Dual3::constant(e),
                h: Dual::constant(h),
                torque: Dual3::parameters(&torque, 0),
                running: Dual::constant(0.0),
            })?;
            let law = self.answer(by, &(0.5 * (e + out.e.value())))?;
            let answer = Matrix3::from_columns(&[out.e.column(0), out.e.column(1), out.e.column(2)]);
            let inverse = drift_equation::inverse3(&(Matrix3::identity() + 0.5 * law.stiffness * answer));
            let change = inverse * (law.torque - torque);
            torque += change;
            if change.norm() < LAST_CHANGE * (1.0 + torque.norm()) {
                return Some((torque, inverse * law.stiffness));
            }
        }
        None
    }

    /// One step of length `h`; `None` where it is too long. A law is solved for from the costate that is expected after it.
    pub fn grid_step(
        &self,
        m: &Vector3,
        pi: &Vector3,
        [e, expected]: [&Vector3; 2],
        h: f64,
        torque: Torque,
    ) -> Option<GridStep> {
        widest(
            #[inline(always)]
            || self.taken(m, pi, [e, expected], h, torque),
        )
    }

    /// [`grid_step`](Self::grid_step) in registers of one width.
    #[inline(always)]
    fn taken(
        &self,
        m: &Vector3,
        pi: &Vector3,
        [e, expected]: [&Vector3; 2],
        h: f64,
        torque: Torque,
    ) -> Option<GridStep> {
        match torque {
            Torque::Given { torque, running } => {
                let mut given = In::<PARAMETERS>::at(m, pi, e, h);
                given.torque = Dual3::constant(&torque);
                given.running.value = running;
                Some(self.drifted(&given)?.step(&torque, |row| row.gradient))
            }
            Torque::Turning(_) | Torque::Smooth(_) => {
                let (value, gain) = self.implicit_torque(m, pi, [e, expected], h, &torque)?;
                let mut given = In::<WITH_TORQUE>::at(m, pi, e, h);
                given.torque = Dual3::parameters(&value, PARAMETERS);
                let mut out = self.drifted(&given)?;
                let mean = (given.e + out.e).scale(0.5);
                let law = self.answer(&torque, &mean.value())?;
                // ℓ = min(e·τ + ε…) − e·τ, and ∂ℓ = −e·∂τ because the law makes the sum least.
                out.hamiltonian.value += law.minimum - mean.value().dot(&law.torque);
                for axis in 0..3 {
                    out.hamiltonian.gradient[PARAMETERS + axis] -= mean.0[axis].value;
                }
                let answer = mean.under(&-gain);
                let chained = |row: &Dual<WITH_TORQUE>| {
                    let mut sum = [0.0; PARAMETERS];
                    for p in 0..PARAMETERS {
                        sum[p] = row.gradient[p];
                        for axis in 0..3 {
                            sum[p] += row.gradient[PARAMETERS + axis] * answer.0[axis].gradient[p];
                        }
                    }
                    sum
                };
                Some(out.step(&value, chained))
            }
        }
    }
}

impl<const L: usize> In<L> {
    /// At these parameters; no torque yet.
    #[inline(always)]
    fn at(m: &Vector3, pi: &Vector3, e: &Vector3, h: f64) -> Self {
        let mut given = Self {
            m: Dual3::parameters(m, 0),
            pi: Dual3::parameters(pi, 3),
            e: Dual3::parameters(e, 6),
            h: Dual::constant(h),
            torque: Dual3::constant(&Vector3::zeros()),
            running: Dual::constant(0.0),
        };
        given.h.gradient[9] = 1.0;
        given
    }
}

impl<const L: usize> Out<L> {
    /// The step, under the torque `torque`; `slopes` gives the derivatives of a row with respect to the parameters.
    #[inline(always)]
    fn step(&self, torque: &Vector3, slopes: impl Fn(&Dual<L>) -> [f64; PARAMETERS]) -> GridStep {
        let c = self.c.value();
        let weight = 2.0 / (1.0 + c.norm_squared());
        let turn = (self.c + Dual3::constant(&c).cross(&self.c)).scale(weight);
        let rows = turn.0.iter().chain(&self.pi.0).chain(&self.e.0).chain([&self.hamiltonian]);
        let mut jacobian = [[0.0; PARAMETERS]; 10];
        for (row, dual) in jacobian.iter_mut().zip(rows) {
            *row = slopes(dual);
        }
        GridStep {
            f: lie::cayley(&c),
            pi: self.pi.value(),
            e: self.e.value(),
            hamiltonian: self.hamiltonian.value,
            torque: *torque,
            jacobian,
        }
    }
}
