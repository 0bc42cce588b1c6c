//! A step beside a plan as a backward sweep takes it, of `N` states under `C` forces and torques.
//!
//! A step is a kick, a drift and a kick. What the inputs add, `v`, acts in both kicks: with `s` the
//! state before the drift and `t` that after it
//!
//! ```text
//! s = K₀ z + Γ₀ v ,   t = D s ,   z⁺ = K₁ t + Γ₁ v                    δλ_t = K₁ᵀ δλ + w₁ (K_qq t + M₁ v)
//! δλ_s = Dᵀ δλ_t + H_free s                                          δλ_z = K₀ᵀ δλ_s + w₀ (K_qq z + M₀ v)
//! 0 = h S⁻¹ v + Γ₀ᵀ δλ_s + w₀ M₀ᵀ z + Γ₁ᵀ δλ + w₁ M₁ᵀ t
//! ```
//!
//! with `M = ∂(λ·E)/∂q` where the axes `E` of inputs turn against the coordinates, and their
//! authority `S`. Written out in `z`, `v` and the costate `δλ` after the step, with
//! `Ĥ = H_free + Dᵀ w₁K_qq D` and `N̂ = Dᵀ w₁M₁`:
//!
//! ```text
//! z⁺   = A z + B v                 A = K₁ D K₀ ,   B = K₁ D Γ₀ + Γ₁
//! δλ_z = Aᵀ δλ + H z + N v         H = K₀ᵀ Ĥ K₀ + w₀K_qq ,   N = K₀ᵀ (Ĥ Γ₀ + N̂) + w₀M₀
//! 0    = (h S⁻¹ + U) v + V z + Bᵀ δλ        V = (Γ₀ᵀ Ĥ + N̂ᵀ) K₀ + w₀M₀ᵀ ,   U = Γ₀ᵀ (Ĥ Γ₀ + N̂) + N̂ᵀ Γ₀
//! ```
//!
//! `V` is not `Nᵀ`: costates are those of attitudes that turn.

use nalgebra::SMatrix;

/// What a step is made of.
pub(crate) struct Parts<const N: usize, const C: usize> {
    /// `K₀`, `K₁`.
    pub kicks: [SMatrix<f64, N, N>; 2],
    /// `D`.
    pub drift: SMatrix<f64, N, N>,
    /// `H_free`.
    pub curvature: SMatrix<f64, N, N>,
    /// `Γ₀`, `Γ₁`.
    pub inputs: [SMatrix<f64, N, C>; 2],
    /// `w K_qq` of both kicks.
    pub bends: [SMatrix<f64, N, N>; 2],
    /// `w M` of both.
    pub mixed: [SMatrix<f64, N, C>; 2],
}

/// One step, in the solver's units.
#[derive(Clone, Debug)]
pub(crate) struct Stage<const N: usize, const C: usize> {
    /// `A_k`.
    pub a: SMatrix<f64, N, N>,
    /// `B_k`.
    pub b: SMatrix<f64, N, C>,
    /// `H_k`.
    pub h: SMatrix<f64, N, N>,
    /// `N_k`.
    pub on_costate: SMatrix<f64, N, C>,
    /// `V_k`.
    pub by_state: SMatrix<f64, C, N>,
    /// `U_k`.
    pub bend: SMatrix<f64, C, C>,
    /// `S`.
    pub authority: SMatrix<f64, C, C>,
    /// `h`, the time for which a correction acts.
    pub length: f64,
}

/// A step with `v` at its optimum, `v = −S (h + U S)⁻¹ (V z + Bᵀ δλ)`.
pub(crate) struct Eliminated<const N: usize, const C: usize> {
    /// `z⁺ = forward z − quadratic δλ`.
    pub forward: SMatrix<f64, N, N>,
    pub quadratic: SMatrix<f64, N, N>,
    /// `δλ_z = back δλ + curvature z`.
    pub back: SMatrix<f64, N, N>,
    pub curvature: SMatrix<f64, N, N>,
    /// `(h + U S)⁻¹`.
    pub per_time: SMatrix<f64, C, C>,
}

impl<const N: usize, const C: usize> Stage<N, C> {
    /// Of its parts.
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

    /// No step: the state stays.
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

    /// This step and the one after it under one `v` (`linear_plan::ticks`), with the authority of
    /// this one.
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

    /// With `v` at its optimum; NaN where that is none.
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
    /// What torques of wheels do to the body: what a kick gives it, they lose before the drift.
    pub fn given_by_wheels(&mut self, with_wheels: &Stage<9, 3>) {
        self.b.copy_from(&with_wheels.b.fixed_view::<6, 3>(0, 0));
        self.h.copy_from(&with_wheels.h.fixed_view::<6, 6>(0, 0));
    }
}
