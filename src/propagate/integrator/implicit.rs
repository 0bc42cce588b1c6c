//! The implicit attitude equation `h S(Π) = F J_d − J_d Fᵀ` on its own, with three solution
//! methods.
//!
//! ```text
//! exponential  F = exp S(f)   A Jf + B f×(Jf) = g                     A = sin t/t, B = (1 − cos t)/t²   (2.3)
//! Cayley       F = cay(c)     g + g×c + (g·c) c − 2Jc = 0             g = hΠ, t = |f|                   (2.6)
//! ```
//! The integrators use [`AttitudeEquation::solve`]. The other two methods are from the survey by
//! Leok, for comparison.

use crate::lie::hat;
use crate::mechanics::body::Inertia;
use crate::mechanics::drift_equation::{newton, solve_counting, solve3};
use crate::{Matrix3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// The implicit attitude equation of one body for one step length.
///
/// ```
/// use slewkit::{Inertia, Vector3, lie};
/// use slewkit::propagate::integrator::AttitudeEquation;
///
/// let inertia = Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5))?;
/// let equation = AttitudeEquation::new(&inertia, 0.1);
/// let momentum = Vector3::new(0.3, 2.0, -1.0);
/// let (c, _) = equation.solve(&momentum).unwrap();
/// let (f, iterations) = equation.exponential(&momentum).unwrap();
/// assert!((lie::cayley(&c) - lie::exp(&f)).amax() < 1e-15);
/// assert!(iterations <= 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct AttitudeEquation {
    /// The inertia in units of the mean principal moment.
    pub(super) j: Matrix3,
    pub(super) j_inverse: Matrix3,
    /// The step `h` divided by the mean principal moment.
    pub(super) scale: f64,
}

impl AttitudeEquation {
    /// Largest number of Newton iterations; 2 to 4 suffice below 0.6 rad.
    const MAX_ITERATIONS: u32 = 40;

    /// Builds the equation for steps of `step` \[s\].
    pub fn new(inertia: &Inertia, step: f64) -> Self {
        let mean = inertia.mean();
        Self { j: inertia.j() / mean, j_inverse: inertia.j_inverse() * mean, scale: step / mean }
    }

    /// Returns the Cayley vector `c` of the step's rotation `F = cay(c)`, and the number of
    /// iterations. The first is a fixed-point iteration, followed by Newton's method with
    /// Chebyshev's correction. `None` if no step below 90° has the momentum `Π` [N·m·s].
    #[inline]
    pub fn solve(&self, momentum: &Vector3) -> Option<(Vector3, u32)> {
        solve_counting(&self.j, &self.j_inverse, &(self.scale * momentum))
    }

    /// Solves the Cayley form (2.6) of the equation by Newton's method from `½J⁻¹hΠ`. Returns the
    /// Cayley vector and the number of iterations; `None` if the iteration does not converge to a
    /// rotation below 90°.
    #[inline]
    pub fn newton(&self, momentum: &Vector3) -> Option<(Vector3, u32)> {
        let g = self.scale * momentum;
        newton(&self.j, &g, 0.5 * (self.j_inverse * g))
    }

    /// Solves the exponential form (2.3, 2.4) of the equation by Newton's method from `J⁻¹hΠ`.
    /// Returns the rotation vector `f` of `F = exp S(f)` and the number of iterations; `None` if
    /// the iteration does not converge to a rotation below 90°.
    pub fn exponential(&self, momentum: &Vector3) -> Option<(Vector3, u32)> {
        let g = self.scale * momentum;
        let mut f = self.j_inverse * g;
        for iteration in 1..=Self::MAX_ITERATIONS {
            let t2 = f.norm_squared();
            let t = t2.sqrt();
            let (sin, cos) = t.sin_cos();
            // Below a milliradian the closed forms of the derivatives consist of rounding errors.
            let (a, b, a_prime, b_prime) = if t < 1e-3 {
                (1.0 - t2 / 6.0, 0.5 - t2 / 24.0, t2 / 30.0 - 1.0 / 3.0, t2 / 180.0 - 1.0 / 12.0)
            } else {
                let half = (0.5 * t).sin() / t;
                let b = 2.0 * half * half;
                (sin / t, b, (cos - sin / t) / t2, (sin / t - 2.0 * b) / t2)
            };
            let jf = self.j * f;
            let fjf = f.cross(&jf);
            let residual = g - (a * jf + b * fjf);
            let slope = a * self.j
                + (a_prime * jf + b_prime * fjf) * f.transpose()
                + b * (hat(&f) * self.j - hat(&jf));
            let correction = solve3(&slope, &residual);
            f += correction;
            if correction.amax() <= 2e-9 {
                return (f.norm() < FRAC_PI_2).then_some((f, iteration));
            }
        }
        None
    }
}
