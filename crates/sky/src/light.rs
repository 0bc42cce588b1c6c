//! The effects of light on a direction: light needs time, and a moving observer sees it from
//! further ahead.
//!
//! For objects of the Earth (stations, the limb, the Moon, other satellites) both effects are
//! computed in the frame that moves with the Earth, for Sun and stars in the frame of the Sun,
//! which hardly moves:
//!
//! ```text
//! ρ = x(t − τ) − r(t) ,  cτ = |ρ| ;        d' ∥ d + v/c        (d/γ + (1 + γ/(γ+1) d·v/c) v/c, by the witness)
//! ```
//!
//! with v the velocity of the spacecraft in that frame. The neglected terms of a planetary theory
//! are then `(v/c)²`, 2 mas.

use slewkit::Vector3;

/// Speed of light \[m/s\].
pub(crate) const C: f64 = 299_792_458.0;

/// The effects of light that directions include; none for geometric directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Light {
    /// Things are seen where they were when their light left them.
    pub takes_time: bool,
    /// Whether directions include the aberration that the moving spacecraft sees.
    pub aberrates: bool,
}

impl Light {
    /// Both effects.
    pub const APPARENT: Self = Self { takes_time: true, aberrates: true };
}

/// Returns the vector, with its length unchanged, in the direction from which light comes, to first
/// order in v/c.
pub(crate) fn aberrated(vector: &Vector3, velocity: &Vector3) -> Vector3 {
    let length = vector.norm();
    (vector / length + velocity / C).normalize() * length
}

/// Returns the apparent direction by the theory of relativity.
pub(crate) fn aberrated_fully(vector: &Vector3, velocity: &Vector3) -> Vector3 {
    let (length, beta) = (vector.norm(), velocity / C);
    let (direction, inverse) = (vector / length, (1.0 - beta.norm_squared()).sqrt());
    let along = direction.dot(&beta);
    let seen = direction * inverse + beta * (1.0 + along / (1.0 + inverse));
    seen.normalize() * length
}

/// Returns the light time from an object, by a difference of positions: the root of
/// `|x(t − τ) − r| = cτ` by secants.
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

    /// Compares with the routine `ab` of SOFA.
    #[test]
    fn aberration_is_that_of_sofa() {
        let velocity = Vector3::new(-2.1e4, 1.7e4, 9.0e3);
        for direction in [Vector3::new(0.36, -0.48, 0.8), Vector3::new(-1.0, 2.0, 0.3).normalize()] {
            let beta = velocity / C;
            let natural = [direction.x, direction.y, direction.z];
            let wanted = sofars::astro::ab(
                &natural,
                &[beta.x, beta.y, beta.z],
                // No deflection by the Sun: far from it.
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
        // A thing that flies straight away: |x − vτ| = cτ.
        let (x, v) = (3.0e8, 1.0e4);
        let found = delay(|delay| Ok::<_, ()>(x - v * delay)).unwrap();
        assert!((found - x / (C + v)).abs() < 1e-15, "{found}");
    }
}
