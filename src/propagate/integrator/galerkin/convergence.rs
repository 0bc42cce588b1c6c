//! The stopping criterion of an iteration on the stage equations.

/// Relative accuracy that counts as exact.
const ROUND_OFF: f64 = 2e-16;

/// Relative size below which a correction that no longer shrinks is round-off.
const NOISE: f64 = 1e-11;

/// Largest number of iterations. Newton's method needs 2–4; iterations without the gradient of the
/// potential need up to a dozen.
pub(super) const MAX_ITERATIONS: u32 = 40;

/// Monitors the corrections of an iteration, each relative to the size of its quantity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Convergence {
    /// Whether the Jacobian is exact, so that convergence is quadratic.
    exact: bool,
    last: f64,
}

/// The action that the iteration takes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    Iterate,
    Done,
    GiveUp,
}

impl Convergence {
    pub fn new(exact: bool) -> Self {
        Self { exact, last: f64::INFINITY }
    }

    /// Returns the next action after a correction of this relative size.
    pub fn after(&mut self, correction: f64) -> Next {
        if !correction.is_finite() {
            return Next::GiveUp;
        }
        let ratio = correction / self.last;
        // The remaining error is Δθ² for quadratic convergence (corrections Δ, CΔ², C³Δ⁴, …), and
        // Δθ/(1 − θ) for linear convergence with the factor θ.
        let left = match (ratio < 0.5, self.exact) {
            (true, true) => correction * ratio * ratio,
            (true, false) => correction * ratio / (1.0 - ratio),
            (false, _) => correction,
        };
        let noise = correction <= NOISE && ratio >= 0.5 && self.last <= NOISE;
        // The first correction cannot be compared with an earlier one.
        let left = if self.last.is_finite() { left } else { correction };
        self.last = correction;
        if left <= ROUND_OFF || noise { Next::Done } else { Next::Iterate }
    }
}

/// Returns the size of a correction relative to the size of the corrected quantity.
pub(super) fn relative(correction: f64, size: f64) -> f64 {
    // The size of the curve of a body at rest is zero; it needs no correction.
    if correction == 0.0 { 0.0 } else { correction / size }
}
