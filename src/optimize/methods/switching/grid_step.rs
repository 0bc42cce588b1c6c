//! One step of Lie–Verlet under a torque that is held over the step: the motion, its costates and
//! the discrete Hamiltonian.
//!
//! ```text
//! Π̃ = Π + (h/2) τ ,   h S(Π̃) = F J_d − J_d Fᵀ ,   R⁺ = R F ,   Π⁺ = FᵀΠ̃ + (h/2) τ
//! m⁺ = Fᵀm ,   e⁺ = Fᵀ(e + h E⁻¹(Π̃×e − m)) ,   E = tr(F J_d) I − F J_d
//! 𝓗  = p + ℓ + m⁺·ξ' + e⁺·[(FᵀΠ̃)×ξ' + ½Fᵀτ + ½τ] ,   ξ' = FᵀE⁻¹(Π̃ + (h/2) τ)
//! ```
//!
//! `𝓗` is the derivative of the discrete action with respect to the length of the step, `p` the
//! price of time, and `ℓ` the cost of the inputs and of smoothing. The smoothed law is evaluated at
//! the mean of the costates at both ends, so that the step is implicit in the torque.
//!
//! Over the drift, which is shared with all other methods (`step/drift`), the discrete Hamiltonian
//! is `D = m⁺·ξ + e⁺·(Π'×ξ)` with `Π' = FᵀΠ̃` and `ξ = FᵀE⁻¹Π̃`, and `𝓗 = p + ℓ + D + ½(e + e⁺)·τ`.
//! The drift is symplectic; therefore a change has the effect
//!
//! ```text
//! δD = ξ·δm⁺ + (Π'×ξ)·δe⁺ − ∂e⁺/∂h·δΠ'
//! ```
//!
//! and the derivative with respect to `h` follows from scaling: if `h` is multiplied by `s`, and
//! `m` and `Π̃` are divided by `s`, then `F` and `e⁺` do not change and `D` is divided by `s²`.

use super::extremal::{ArcLaw, Extremal, LawResponse};
use super::tuning::SAME;
use super::tuning::grid::MOST_ITERATIONS;
use crate::mechanics::drift_equation;
use crate::numerics::widest::widest;
use crate::optimize::discrete::step::Costate;
use crate::optimize::discrete::step::drift::{Drift, LinearDrift};
use crate::{Matrix3, Vector3, lie};
use nalgebra::SMatrix;

/// Number of parameters of a step: `m`, `Π`, `e`, `h`.
const PARAMETERS: usize = 10;
/// Number of parameters of a step with the torque included: `m`, `Π`, `e`, `h`, `τ`.
const WITH_TORQUE: usize = PARAMETERS + 3;

/// Length that replaces a zero step length, because some terms are divided by the length.
const NO_STEP: f64 = 1e-150;

/// The rule that determines the torque of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Torque {
    /// The law of an arc: a held torque, or one of full norm that turns with the costate.
    Arc(ArcLaw),
    /// The smoothed law with this ε.
    Smooth(f64),
}

/// The map of one step, and its derivative with respect to `m`, `Π`, `e`, `h`.
#[derive(Clone, Debug)]
pub(crate) struct StepMap {
    pub f: Matrix3,
    pub pi: Vector3,
    pub e: Vector3,
    pub hamiltonian: f64,
    pub torque: Vector3,
    /// Rows: the rotation `F⁻ᵀδFᵀ` before the step's rotation, `δΠ⁺`, `δe⁺`, `δ𝓗`.
    pub jacobian: [[f64; PARAMETERS]; 10],
}

/// A drift from a kicked momentum, with its costates and linearisation.
struct CostateDrift {
    drift: Drift,
    linear: LinearDrift,
    after: Costate,
    /// Derivative `∂e⁺/∂Π̃` of the costate after the drift with respect to the momentum before it.
    e_of_momentum: Matrix3,
}

/// The map of a step under a held torque, with derivatives that include the torque.
struct HeldStep {
    f: Matrix3,
    pi: Vector3,
    e: Vector3,
    /// Discrete Hamiltonian without the cost of the inputs.
    hamiltonian: f64,
    /// Derivatives of the rotation, `Π⁺`, `e⁺` and `𝓗`.
    jacobian: SMatrix<f64, 10, WITH_TORQUE>,
}

impl Extremal {
    #[inline(always)]
    fn lifted(&self, m: &Vector3, kicked: &Vector3, e: &Vector3, h: f64) -> Option<CostateDrift> {
        let j_d = Matrix3::from_diagonal_element(0.5 * self.j.trace()) - self.j;
        let c = drift_equation::solve(&self.j, &self.j_inverse, &(h * kicked))?;
        let f = lie::cayley(&c);
        let drift = Drift { h, f, momentum: *kicked, momentum_after: f.tr_mul(kicked) };
        let matrix = drift.matrix(&j_d);
        let none = Vector3::zeros();
        let after = drift.costate::<6>(&matrix, &Costate { x: none, gamma: none, zeta: *m, pi: *e });
        let linear = drift.linear(&j_d, &matrix, &after);
        let e_of_momentum = linear.b * linear.h12 - linear.c_inverse_t * linear.h22;
        Some(CostateDrift { drift, linear, after, e_of_momentum })
    }

    #[inline(always)]
    fn held(&self, m: &Vector3, pi: &Vector3, e: &Vector3, h: f64, torque: &Vector3) -> Option<HeldStep> {
        let h = if h.abs() < NO_STEP { NO_STEP } else { h };
        let (half, kicked) = (0.5 * torque, pi + 0.5 * h * torque);
        let CostateDrift { drift, linear, after, e_of_momentum } = self.lifted(m, &kicked, e, h)?;
        let LinearDrift { b, c, c_inverse_t, .. } = &linear;
        // Derivatives with respect to the length of the drift.
        let xi = b * kicked / h;
        let pi_rate = drift.momentum_after.cross(&xi);
        let e_rate = (e_of_momentum * kicked - b * m) / h;
        let value = after.zeta.dot(&xi) + after.pi.dot(&pi_rate);
        let by_m = drift.f * xi - b.tr_mul(&pi_rate);
        let by_pi = b.tr_mul(&xi.cross(&after.zeta)) + e_of_momentum.tr_mul(&pi_rate) - c.tr_mul(&e_rate);
        // The scheme is symmetric, so for so short a step this derivative is below its round-off.
        let by_h =
            if h * h > f64::EPSILON { (kicked.dot(&by_pi) + m.dot(&by_m) - 2.0 * value) / h } else { 0.0 };
        let mut jacobian = SMatrix::<f64, 10, WITH_TORQUE>::zeros();
        let mut block = |row: usize, column: usize, block: &Matrix3| {
            jacobian.fixed_view_mut::<3, 3>(row, column).copy_from(block);
        };
        let turn = drift.f * b;
        block(0, 3, &turn);
        block(0, 10, &(0.5 * h * turn));
        block(3, 3, c);
        block(3, 10, &(0.5 * h * (c + Matrix3::identity())));
        block(6, 0, &-b);
        block(6, 3, &e_of_momentum);
        block(6, 6, c_inverse_t);
        block(6, 10, &(0.5 * h * e_of_momentum));
        jacobian.fixed_view_mut::<3, 1>(0, 9).copy_from(&(drift.f * xi + turn * half));
        jacobian.fixed_view_mut::<3, 1>(3, 9).copy_from(&(pi_rate + c * half + half));
        jacobian.fixed_view_mut::<3, 1>(6, 9).copy_from(&(e_rate + e_of_momentum * half));
        let mut slope = jacobian.fixed_rows::<3>(6).tr_mul(&half);
        let by_e = c_inverse_t.tr_mul(&pi_rate) + half;
        for (row, by) in [(0, by_m), (3, by_pi), (6, by_e), (10, 0.5 * (h * by_pi + e + after.pi))] {
            let mut rows = slope.fixed_rows_mut::<3>(row);
            rows += by;
        }
        slope[9] += by_h + by_pi.dot(&half);
        jacobian.row_mut(9).tr_copy_from(&slope);
        let hamiltonian = self.time_price + value + half.dot(&(e + after.pi));
        Some(HeldStep { f: drift.f, pi: drift.momentum_after + h * half, e: after.pi, hamiltonian, jacobian })
    }

    /// Returns the torque of the rule `torque` at the costate `e`, with its cost and its
    /// derivative.
    #[inline(always)]
    fn answer(&self, torque: &Torque, e: &Vector3) -> LawResponse {
        match torque {
            Torque::Arc(law) => law.at(e),
            Torque::Smooth(epsilon) => self.smooth(e, *epsilon, &Vector3::zeros()),
        }
    }

    /// Solves `τ = law(½(e + e⁺(τ)))` for the torque by Newton; also returns
    /// `(1 + ½ G ∂e⁺/∂τ)⁻¹ G`. The initial guess uses the costate expected after the step, or the
    /// costate before it if that fails.
    #[inline(always)]
    fn implicit_torque(
        &self,
        m: &Vector3,
        pi: &Vector3,
        [e, expected]: [&Vector3; 2],
        h: f64,
        by: &Torque,
    ) -> Option<(Vector3, Matrix3)> {
        [expected, e].into_iter().find_map(|after| {
            let mut torque = self.answer(by, &(0.5 * (e + after))).torque;
            for _ in 0..MOST_ITERATIONS {
                let out = self.lifted(m, &(pi + 0.5 * h * torque), e, h)?;
                let law = self.answer(by, &(0.5 * (e + out.after.pi)));
                let answer = 0.25 * h * law.stiffness * out.e_of_momentum;
                let inverse = drift_equation::inverse3(&(Matrix3::identity() + answer));
                let change = inverse * (law.torque - torque);
                torque += change;
                if change.norm() < SAME * (1.0 + torque.norm()) {
                    return Some((torque, inverse * law.stiffness));
                }
            }
            None
        })
    }

    /// Computes one step of length `h`; `None` if the step is too long for its implicit equation.
    /// For an implicit law the expected costate after the step is the initial guess.
    pub fn grid_step(
        &self,
        m: &Vector3,
        pi: &Vector3,
        [e, expected]: [&Vector3; 2],
        h: f64,
        torque: Torque,
    ) -> Option<StepMap> {
        widest(
            #[inline(always)]
            || {
                if let Torque::Arc(law) = &torque
                    && let Some(LawResponse { torque, running, .. }) = law.held()
                {
                    let held = self.held(m, pi, e, h, torque)?;
                    let slopes = held.jacobian.fixed_columns::<PARAMETERS>(0).into_owned();
                    return Some(held.step(torque, *running, &slopes));
                }
                let (value, gain) = self.implicit_torque(m, pi, [e, expected], h, &torque)?;
                let mut held = self.held(m, pi, e, h, &value)?;
                let mean = 0.5 * (e + held.e);
                let law = self.answer(&torque, &mean);
                // ℓ = min(e·τ + ε…) − e·τ, and ∂ℓ = −e·∂τ because the law minimises the sum.
                let running = law.minimum - mean.dot(&law.torque);
                for axis in 0..3 {
                    held.jacobian[(9, PARAMETERS + axis)] -= mean[axis];
                }
                let mut of_mean = 0.5 * held.jacobian.fixed_view::<3, PARAMETERS>(6, 0);
                for axis in 0..3 {
                    of_mean[(axis, 6 + axis)] += 0.5;
                }
                let slopes = held.jacobian.fixed_columns::<PARAMETERS>(0)
                    - held.jacobian.fixed_columns::<3>(PARAMETERS) * (gain * of_mean);
                Some(held.step(&value, running, &slopes))
            },
        )
    }
}

impl HeldStep {
    /// Returns the map of the step with the derivatives `slopes` with respect to `m`, `Π`, `e` and
    /// `h`. The cost `running` of the inputs per unit of time is added to the Hamiltonian.
    fn step(&self, torque: &Vector3, running: f64, slopes: &SMatrix<f64, 10, PARAMETERS>) -> StepMap {
        StepMap {
            f: self.f,
            pi: self.pi,
            e: self.e,
            hamiltonian: self.hamiltonian + running,
            torque: *torque,
            jacobian: std::array::from_fn(|row| std::array::from_fn(|column| slopes[(row, column)])),
        }
    }
}
