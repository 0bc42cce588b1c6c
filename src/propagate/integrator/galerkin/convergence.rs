//! The stopping criterion of an iteration on the stage equations.

/// The relative accuracy that counts as exact.
const ROUND_OFF: f64 = 2e-16;

/// Below this, relative, a correction that no longer shrinks is noise.
const NOISE: f64 = 1e-11;

/// The largest number of iterations. Newton needs 2–4, iterations without the potential's gradient
/// up to a dozen.
pub(super) const MAX_ITERATIONS: u32 = 40;

/// Watches the corrections, each relative to the size of its quantity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Convergence {
    /// Whether the Jacobian is exact, so that convergence is quadratic.
    exact: bool,
    last: f64,
}

/// The next action of the iteration.
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

    /// Returns the next action after a correction.
    pub fn after(&mut self, correction: f64) -> Next {
        if !correction.is_finite() {
            return Next::GiveUp;
        }
        let ratio = correction / self.last;
        // The remaining error is Δθ² if corrections shrink like Δ, CΔ², C³Δ⁴, …, and Δθ/(1 − θ) if
        // they shrink by a factor.
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

/// Returns `|Δ|` over the size of the corrected quantity.
pub(super) fn relative(correction: f64, size: f64) -> f64 {
    // A body at rest has the size zero and needs no correction.
    if correction == 0.0 { 0.0 } else { correction / size }
}
