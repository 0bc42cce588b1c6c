//! Effects of light on a direction: light time, and aberration due to the motion of the observer.
//!
//! For ground stations, the limb, the Moon and other satellites, both effects are computed in the
//! frame that moves with the Earth. For the Sun and stars, the series theory uses the frame of the
//! Sun, which hardly moves, and the witness uses the barycentric frame:
//!
//! ```text
//! ρ = x(t − τ) − r(t) ,  cτ = |ρ| ;        d' ∥ d + v/c        (d/γ + (1 + γ/(γ+1) d·v/c) v/c, by the witness)
//! ```
//!
//! x is the position of the object, r of the spacecraft, τ the light time and d the unit vector
//! along ρ. d' is the apparent direction, v the velocity of the spacecraft in the chosen frame, and
//! γ = 1/√(1 − v²/c²). The neglected terms of a full relativistic theory are of the order `(v/c)²`,
//! 2 mas. The expression in parentheses is exact in v/c; the witness uses it.

use slewkit::Vector3;

/// Speed of light \[m/s\].
pub(crate) const C: f64 = 299_792_458.0;

/// Effects of light that directions include. By default none is included, so that directions are
/// geometric.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Light {
    /// True if a target is seen at the position that it had when it emitted the light.
    pub takes_time: bool,
    /// True if directions include the aberration due to the velocity of the spacecraft.
    pub aberrates: bool,
}

impl Light {
    /// Setting for apparent directions, which include light time and aberration.
    pub const APPARENT: Self = Self { takes_time: true, aberrates: true };
}

/// Rotates a vector by the aberration to first order in v/c for an observer with the velocity
/// `velocity` \[m/s\]. The length of the vector is not changed.
pub(crate) fn aberrated(vector: &Vector3, velocity: &Vector3) -> Vector3 {
    let length = vector.norm();
    (vector / length + velocity / C).normalize() * length
}

/// Rotates a vector by the aberration according to special relativity for an observer with the
/// velocity `velocity` \[m/s\]. The length of the vector is not changed.
pub(crate) fn aberrated_fully(vector: &Vector3, velocity: &Vector3) -> Vector3 {
    let (length, beta) = (vector.norm(), velocity / C);
    let (direction, inverse) = (vector / length, (1.0 - beta.norm_squared()).sqrt());
    let along = direction.dot(&beta);
    let seen = direction * inverse + beta * (1.0 + along / (1.0 + inverse));
    seen.normalize() * length
}

/// Returns the light time τ from an object \[s\]: the solution of `|x(t − τ) − r| = cτ` by the
/// secant method. `range_at` returns the distance `|x(t − τ) − r|` \[m\] for a light time τ.
pub(crate) fn delay<E>(mut range_at: impl FnMut(f64) -> Result<f64, E>) -> Result<f64, E> {
    let mut before = (0.0, range_at(0.0)? / C);
    let mut delay = before.1;
    for _ in 0..20 {
        let off = range_at(delay)? / C - delay;
        let slope = (off - before.1) / (delay - before.0);
        let next = delay - off / slope;
        let settled = (next - delay).abs() <= 1e-15 * delay.abs() || !next.is_finite();
        if settled {
            break;
        }
        before = (delay, off);
        delay = next;
    }
    Ok(delay)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares both aberration formulas with the routine `ab` of SOFA.
    #[test]
    fn aberration_is_that_of_sofa() {
        let velocity = Vector3::new(-2.1e4, 1.7e4, 9.0e3);
        for direction in [Vector3::new(0.36, -0.48, 0.8), Vector3::new(-1.0, 2.0, 0.3).normalize()] {
            let beta = velocity / C;
            let natural = [direction.x, direction.y, direction.z];
            let wanted = sofars::astro::ab(
                &natural,
                &[beta.x, beta.y, beta.z],
                // Distance from the Sun, chosen so large that gravity does not deflect the light.
                1e30,
                (1.0 - beta.norm_squared()).sqrt(),
            );
            let wanted = Vector3::from(wanted);
            let full = aberrated_fully(&(direction * 7.0), &velocity);
            assert!((full / 7.0 - wanted).norm() < 1e-15, "{}", (full / 7.0 - wanted).norm());
            let first = aberrated(&(direction * 7.0), &velocity) / 7.0;
            let off = (first - wanted).norm();
            assert!(off < 0.3 * beta.norm_squared() && off > 1e-12, "{off:e}");
        }
    }

    #[test]
    fn light_arrives_when_it_has_come_all_the_way() {
        // An object moves away from the observer in the line of sight: |x − vτ| = cτ.
        let (x, v) = (3.0e8, 1.0e4);
        let found = delay(|delay| Ok::<_, ()>(x - v * delay)).unwrap();
        assert!((found - x / (C + v)).abs() < 1e-15, "{found}");
    }
}
