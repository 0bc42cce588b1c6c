//! Largest angle of a step in a maneuver that costs no more than a known maneuver.
//!
//! Let `t` be the time of torque before a step, `T − t` the time after it, `π` the spatial momentum
//! at the step and `π_0`, `π_d` the spatial momenta at the ends. Impulses add up in the spatial
//! frame, and an impulse `a` in time `t` costs at least `½ g a²/t`, `g` the smallest eigenvalue of
//! the torque weight `G` (Cauchy–Schwarz). So a cost up to `U` requires
//!
//! ```text
//! |π − π_0|²/t + |π_d − π|²/(T − t) ≤ 2U/g
//! ⇔  |π − c|² ≤ (t (T − t)/T) (2U/g − |π_d − π_0|²/T) ,     c = π_0 + (t/T)(π_d − π_0)
//! ```
//!
//! and a step through `θ ≤ 90°` about the axis `e` has
//! `|hΠ|² = sin²θ |Je|² + (1 − cos θ)² |e × Je|² ≥ (J_min sin θ)²`. `t` counts the first half kick
//! of Lie–Verlet as half a step, because its weight in the cost is half too.

use crate::Vector3;

/// Boundary data of the angle bound, with momenta and inertia divided by the mean moment of
/// inertia.
pub(super) struct Ends {
    /// Spatial angular momenta at the start and at the end.
    pub momenta: [Vector3; 2],
    /// Duration of the maneuver.
    pub duration: f64,
    /// Upper bound `2U/g` on the sum of squared impulses, each divided by its time. U is the known
    /// cost and g the smallest eigenvalue of the torque weight.
    pub budget: f64,
}

impl Ends {
    /// Returns the largest possible magnitude of the momentum after the time `t` under torque.
    fn momentum(&self, t: f64) -> f64 {
        let [start, end] = &self.momenta;
        let total = self.duration;
        let center = start + (end - start) * (t / total);
        let left = (self.budget - (end - start).norm_squared() / total).max(0.0);
        // A relative reserve of 1e-9 covers round-off: the range may be too large but never too
        // small.
        (center.norm() + (t * (total - t) / total * left).max(0.0).sqrt()) * (1.0 + 1e-9)
    }

    /// Returns the largest possible angle of a step of length `h` after the time `t` under torque
    /// \[rad\], at most 90°.
    pub fn angle(&self, t: f64, h: f64, smallest_moment: f64) -> f64 {
        let sine = h * self.momentum(t) / smallest_moment;
        if sine < 1.0 { sine.asin() } else { std::f64::consts::FRAC_PI_2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn the_cheapest_way_through_a_momentum_just_reaches_it() {
        let mut random = Random(17);
        let (steps, h) = (9usize, 0.2);
        for round in 0..50 {
            let resting = round % 2 == 0;
            let mut end = || if resting { Vector3::zeros() } else { 0.5 * random.vector3() };
            let momenta = [end(), end()];
            let between = random.vector3();
            for k in 1..steps {
                // Constant torque before the step and constant torque after it: cost of Lie–Euler
                // for a unit sphere.
                let (before, after) = (k as f64 * h, (steps - k) as f64 * h);
                let [a, b] = [between - momenta[0], momenta[1] - between];
                let cost = 0.5 * (a.norm_squared() / before + b.norm_squared() / after);
                let ends = Ends { momenta, duration: steps as f64 * h, budget: 2.0 * cost };
                let reached = (h * between.norm()).min(1.0).asin();
                let angle = ends.angle(before, h, 1.0);
                assert!(angle >= reached, "step {k}: {angle} below {reached}");
                if resting {
                    assert!(angle < reached * (1.0 + 1e-6), "step {k}: {angle} is not {reached}");
                }
            }
        }
    }

    #[test]
    fn too_much_momentum_for_the_implicit_equation_is_all_of_the_branch() {
        let ends = Ends { momenta: [Vector3::zeros(); 2], duration: 1.0, budget: 1e4 };
        assert!((ends.angle(0.5, 0.1, 0.3) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    }
}
