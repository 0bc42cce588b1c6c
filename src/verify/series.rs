//! The motion of a free body over a stretch of time as a Taylor series.
//!
//! ```text
//! Π̇ = (Π + μ) × Ω + τ ,   μ̇ = −τ (wheels) ,   Ω = J⁻¹Π ,   q̇ = ½ q ∘ (0, Ω) ,   τ = τ₀ + s τ₁ ,   t = sh
//! ```
//! Right sides that are products have coefficients that are sums of products (Leibniz), so each
//! power of `s` follows from those below it:
//!
//! ```text
//! (k+1) Π_{k+1} = h Σ (Π + μ)_i × Ω_{k−i} + h τ_k ,   (k+1) q_{k+1} = (h/2) Σ q_i ∘ (0, Ω_{k−i})
//! ```
//! Powers are added until they no longer change the sum: three for the steps of a plan of a million
//! steps, twenty for half a radian. The series needs no tableau, no implicit equation, and no code
//! of the planner.
//!
//! # Why is the continuous witness a Taylor series?
//!
//! If nothing depends on the pose, the equations of motion are products, and a few lines compute
//! the coefficients of their series (`verify/series.rs`). A step of the plan is one series to
//! round-off, with three powers for short steps and twenty for half a radian. An adaptive step
//! has sixteen stages, and more code to trust. Fields, axes fixed in the reference frame and
//! thrusters fixed in the body use Verner's 9(8) from the crate `differential-equations`. A unit
//! test compares the two.

use super::motion::angular_velocity;
use crate::{Matrix3, Vector3};

/// The largest number of powers; a stretch that needs more is divided.
const MOST: usize = 24;

/// The part of the whole change below which a term is negligible compared with the rounding of
/// the others.
const NEGLIGIBLE: f64 = f64::EPSILON / 16.0;

/// The start of a stretch and the torque that acts on it, scaled.
pub(super) struct Stretch {
    /// Length h of the stretch.
    pub(super) length: f64,
    /// `Π`.
    pub(super) momentum: Vector3,
    /// `μ`, if the body has wheels, which then produce the torque.
    pub(super) stored: Option<Vector3>,
    /// `τ₀` and `τ₁`: the torque at the start, and how much it changes.
    pub(super) torque: [Vector3; 2],
    /// Sizes of `q̇` and `Π̇`, which rounding is relative to.
    pub(super) speeds: [f64; 2],
}

/// Returns `q − 1` (scalar first) and the change of `Π` over a stretch from `q = 1`; `None` where
/// the powers do not suffice.
pub(super) fn change(j: &Matrix3, j_inverse: &Matrix3, stretch: &Stretch) -> Option<([f64; 4], Vector3)> {
    let Stretch { length: h, momentum, stored, torque, speeds } = stretch;
    let zero = Vector3::zeros();
    // Powers of Π + μ, of Ω, and of the scalar and the vector part of q.
    let (mut total, mut rate) = ([zero; MOST], [zero; MOST]);
    let (mut w, mut v) = ([0.0; MOST], [zero; MOST]);
    let mut momenta = [zero; MOST];
    total[0] = momentum + stored.unwrap_or(zero);
    rate[0] = angular_velocity(j, j_inverse, momentum);
    w[0] = 1.0;
    let enough = speeds.map(|speed| NEGLIGIBLE * h * speed);
    let mut negligible = false;
    for k in 0..MOST - 1 {
        let (mut moment, mut scalar, mut vector) = (zero, 0.0, zero);
        let back = rate[..=k].iter().rev();
        for (((total, w), v), omega) in total[..=k].iter().zip(&w[..=k]).zip(&v[..=k]).zip(back) {
            moment += total.cross(omega);
            scalar -= v.dot(omega);
            vector += *w * omega + v.cross(omega);
        }
        let part = h / (k + 1) as f64;
        let push = torque.get(k).copied().unwrap_or(zero);
        momenta[k + 1] = part * (moment + push);
        w[k + 1] = 0.5 * part * scalar;
        v[k + 1] = 0.5 * part * vector;
        let small = w[k + 1].abs().max(v[k + 1].amax()) <= enough[0] && momenta[k + 1].amax() <= enough[1];
        // Two in a row: one may vanish by symmetry.
        if small && negligible {
            let sum = |powers: &[Vector3]| powers.iter().rev().sum::<Vector3>();
            let (turn, scalar) = (sum(&v[1..k + 2]), w[1..k + 2].iter().rev().sum());
            return Some(([scalar, turn.x, turn.y, turn.z], sum(&momenta[1..k + 2])));
        }
        negligible = small;
        total[k + 1] = momenta[k + 1] - if stored.is_some() { part * push } else { zero };
        rate[k + 1] = angular_velocity(j, j_inverse, &momenta[k + 1]);
    }
    None
}

#[cfg(test)]
mod tests {
    use crate::maneuver::problem::{Problem, State};
    use crate::mechanics::actuators::Wheels;
    use crate::mechanics::body::{Body, Inertia};
    use crate::propagate::plant::{Output, Plant};
    use crate::testing::{Random, full_inertia};
    use crate::verify::continuous::Continuous;
    use crate::verify::motion::{Phase, Scale};
    use crate::{Vector3, lie};

    /// The series agrees with Verner's pair on stretches of full and thin inertias, with changing
    /// torques and forces, with wheels and without, from a thousandth of a radian to steps that are
    /// divided.
    #[test]
    fn the_series_is_the_motion_that_the_adaptive_integrator_finds() {
        let mut random = Random(71);
        let thin = Inertia::diagonal(Vector3::new(1e-3, 1.0, 1.0005)).unwrap();
        for (inertia, lengths) in
            [(full_inertia(), &[(1e-3, 50), (0.1, 20), (1.0, 5), (9.0, 2)][..]), (thin, &[(1e-3, 50)])]
        {
            for &(length, steps) in lengths {
                // Verner's pair gives up on wheels that turn the body by many radians in a step.
                for stores in if length > 1.0 { vec![false] } else { vec![false, true] } {
                    let mut state = State::attitude(lie::exp(&random.vector3()), random.vector3());
                    // Slowly about the thin axis, about which a torque would make it spin beyond
                    // all measure.
                    state.angular_velocity.x *= 0.1;
                    state.velocity = random.vector3();
                    let body = Body { inertia: inertia.clone(), mass: Some(1.3) };
                    let duration = length * f64::from(steps);
                    let mut problem = Problem::rigid_body(body, state, state, duration);
                    let wheels = Wheels {
                        momentum: random.vector3().as_slice().to_vec(),
                        momentum_limit: vec![f64::INFINITY; 3],
                    };
                    problem.actuation.wheels = stores.then_some(wheels);
                    let phase = Phase::of(&problem, &state);
                    let plant = Plant::new(&problem);
                    let mut output = || Output {
                        force: random.vector3() / length,
                        torque: Vector3::new(1e-3, 1.0, 1.0).component_mul(&random.vector3()) / length,
                    };
                    let (mut series, mut pair) =
                        (Continuous::new(&plant, &phase), Continuous::adaptive(&plant, &phase));
                    assert_eq!((series.method(), pair.method()), ("Taylor series", "Verner 9(8)"));
                    for step in 0..steps {
                        let (from, to, time) = (output(), output(), f64::from(step) * length);
                        for body in [&mut series, &mut pair] {
                            let advanced = body.advance(time, length, &from, &to);
                            assert_eq!(advanced, Ok(()), "{} {length} {stores}", body.method());
                        }
                    }
                    let ends = [series.phase(duration), pair.phase(duration)];
                    let error = Scale::of(&problem).distance(&ends[0], &ends[1], problem.motion).largest();
                    let size = 1.0 + ends[0].momentum.norm() * duration / problem.body.inertia.mean();
                    assert!(error < 3e-14 * size, "{inertia:?} {length} {stores}: {error:e} {size}");
                    assert!((ends[0].stored - ends[1].stored).norm() < 1e-14 * size);
                }
            }
        }
    }
}
