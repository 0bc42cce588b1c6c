//! One linearised step of a plan in the form needed by a backward sweep, with `N` states and `C`
//! forces and torques.
//!
//! A step is a kick, a drift and a kick. The correction `v` of the inputs acts in both kicks. With
//! `s` the state before the drift and `t` the state after it:
//!
//! ```text
//! s = K₀ z + Γ₀ v ,   t = D s ,   z⁺ = K₁ t + Γ₁ v                    δλ_t = K₁ᵀ δλ + w₁ (K_qq t + M₁ v)
//! δλ_s = Dᵀ δλ_t + H_free s                                          δλ_z = K₀ᵀ δλ_s + w₀ (K_qq z + M₀ v)
//! 0 = h S⁻¹ v + Γ₀ᵀ δλ_s + w₀ M₀ᵀ z + Γ₁ᵀ δλ + w₁ M₁ᵀ t
//! ```
//!
//! with `M = ∂(λ·E)/∂q` if the axes `E` of inputs rotate relative to the coordinates, and `S` the
//! authority of the inputs. Written in `z`, `v` and the costate `δλ` after the step, with
//! `Ĥ = H_free + Dᵀ w₁K_qq D` and `N̂ = Dᵀ w₁M₁`:
//!
//! ```text
//! z⁺   = A z + B v                 A = K₁ D K₀ ,   B = K₁ D Γ₀ + Γ₁
//! δλ_z = Aᵀ δλ + H z + N v         H = K₀ᵀ Ĥ K₀ + w₀K_qq ,   N = K₀ᵀ (Ĥ Γ₀ + N̂) + w₀M₀
//! 0    = (h S⁻¹ + U) v + V z + Bᵀ δλ        V = (Γ₀ᵀ Ĥ + N̂ᵀ) K₀ + w₀M₀ᵀ ,   U = Γ₀ᵀ (Ĥ Γ₀ + N̂) + N̂ᵀ Γ₀
//! ```
//!
//! `V` is not `Nᵀ`, because the costates belong to attitudes that rotate.

use nalgebra::SMatrix;

/// Parts of a step: kicks, drift and their second derivatives.
pub(crate) struct Parts<const N: usize, const C: usize> {
    /// Matrices of the kicks, `K₀` and `K₁`.
    pub kicks: [SMatrix<f64, N, N>; 2],
    /// Matrix of the drift, `D`.
    pub drift: SMatrix<f64, N, N>,
    /// Curvature of the drift, `H_free`.
    pub curvature: SMatrix<f64, N, N>,
    /// Derivatives of the kicks with respect to the inputs, `Γ₀` and `Γ₁`.
    pub inputs: [SMatrix<f64, N, C>; 2],
    /// Curvatures `w K_qq` of the two kicks.
    pub bends: [SMatrix<f64, N, N>; 2],
    /// Mixed derivatives `w M` of the two kicks.
    pub mixed: [SMatrix<f64, N, C>; 2],
}

/// Matrices of one linearised step, in the solver's units; the module header defines them.
#[derive(Clone, Debug)]
pub(crate) struct Stage<const N: usize, const C: usize> {
    /// Derivative `A_k` of the next state with respect to the state.
    pub a: SMatrix<f64, N, N>,
    /// Derivative `B_k` of the next state with respect to the input correction.
    pub b: SMatrix<f64, N, C>,
    /// Curvature `H_k`: derivative of the costate before the step with respect to the state.
    pub h: SMatrix<f64, N, N>,
    /// `N_k`: derivative of the costate before the step with respect to the input correction.
    pub on_costate: SMatrix<f64, N, C>,
    /// `V_k`: coefficient of the state in the stationarity condition of the input correction.
    pub by_state: SMatrix<f64, C, N>,
    /// `U_k`: second derivative with respect to the input correction, in addition to `h S⁻¹`.
    pub bend: SMatrix<f64, C, C>,
    /// Authority `S` of the inputs.
    pub authority: SMatrix<f64, C, C>,
    /// Time `h` for which a correction acts.
    pub length: f64,
}

/// A step with the optimal correction `v = −S (h + U S)⁻¹ (V z + Bᵀ δλ)` inserted.
pub(crate) struct Eliminated<const N: usize, const C: usize> {
    /// Matrices of the state after the step, `z⁺ = forward z − quadratic δλ`.
    pub forward: SMatrix<f64, N, N>,
    pub quadratic: SMatrix<f64, N, N>,
    /// Matrices of the costate before the step, `δλ_z = back δλ + curvature z`.
    pub back: SMatrix<f64, N, N>,
    pub curvature: SMatrix<f64, N, N>,
    /// Factor `(h + U S)⁻¹` of the optimal correction.
    pub per_time: SMatrix<f64, C, C>,
}

impl<const N: usize, const C: usize> Stage<N, C> {
    /// Assembles a step from its parts.
    pub fn of(parts: &Parts<N, C>, authority: SMatrix<f64, C, C>, length: f64) -> Self {
        let Parts { kicks: [opened, closed], drift, curvature, inputs: [first, last], bends, mixed } = parts;
        let bent = curvature + drift.transpose() * bends[1] * drift;
        let leaning = drift.transpose() * mixed[1];
        let through = closed * drift;
        let moved = bent * first + leaning;
        Self {
            a: through * opened,
            b: through * first + last,
            h: opened.transpose() * bent * opened + bends[0],
            on_costate: opened.transpose() * moved + mixed[0],
            by_state: (first.transpose() * bent + leaning.transpose()) * opened + mixed[0].transpose(),
            bend: first.transpose() * moved + leaning.transpose() * first,
            authority,
            length,
        }
    }

    /// Returns the identity step, over which the state stays constant.
    pub fn none() -> Self {
        Self {
            a: SMatrix::identity(),
            b: SMatrix::zeros(),
            h: SMatrix::zeros(),
            on_costate: SMatrix::zeros(),
            by_state: SMatrix::zeros(),
            bend: SMatrix::zeros(),
            authority: SMatrix::zeros(),
            length: 0.0,
        }
    }

    /// Composes this step and the following step `after` under one common correction `v`
    /// (`linear_plan::ticks`). The authority is that of this step.
    pub fn then(&self, after: &Self) -> Self {
        let bent = after.h * self.b + after.on_costate;
        let through = after.h * self.a;
        Self {
            a: after.a * self.a,
            b: after.a * self.b + after.b,
            h: self.h + self.a.transpose() * through,
            on_costate: self.on_costate + self.a.transpose() * bent,
            by_state: self.by_state + after.by_state * self.a + self.b.transpose() * through,
            bend: self.bend + after.bend + after.by_state * self.b + self.b.transpose() * bent,
            authority: self.authority,
            length: self.length + after.length,
        }
    }

    /// Inserts the optimal correction `v`; the result is NaN if no optimum exists.
    pub fn eliminated(&self) -> Eliminated<N, C> {
        let inner = SMatrix::<f64, C, C>::from_diagonal_element(self.length) + self.bend * self.authority;
        let per_time = inner.try_inverse().unwrap_or_else(|| SMatrix::repeat(f64::NAN));
        let answer = self.authority * per_time;
        Eliminated {
            forward: self.a - self.b * (answer * self.by_state),
            quadratic: self.b * answer * self.b.transpose(),
            back: self.a.transpose() - self.on_costate * answer * self.b.transpose(),
            curvature: self.h - self.on_costate * (answer * self.by_state),
            per_time,
        }
    }
}

impl Stage<6, 3> {
    /// Replaces the matrices of the body by the matrices for wheel torques. In a kick before the
    /// drift, the wheels lose the momentum that the body gains.
    pub fn given_by_wheels(&mut self, with_wheels: &Stage<9, 3>) {
        self.b.copy_from(&with_wheels.b.fixed_view::<6, 3>(0, 0));
        self.h.copy_from(&with_wheels.h.fixed_view::<6, 6>(0, 0));
    }
}
