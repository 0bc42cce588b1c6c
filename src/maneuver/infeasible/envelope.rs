//! A bound on the rate of the body on every arc of a maneuver, for any inputs within their
//! limits.
//!
//! The arc of step k is `F = exp S(f)`, `φ = |f| < 90°`, `e = f/φ`. Let `Π` be the momentum that
//! drives it, `v² = Π·J⁻¹Π`, and μ the momentum in the wheels, if any. Each step of either scheme
//! then has
//!
//! ```text
//! drift   h Π = A Jf + B f×Jf (+ K f×hμ + K² f (f·hμ))           K = tan(φ/2)/φ
//!         sin φ (e·Je) = h e·Π (− h tan²(φ/2) e·μ)                                     (dot with e)
//!         |RΠ| and v are conserved; with wheels |R(Π + μ)| is, and v² changes by at most
//!         4 tan²(φ/2) |μ| κ [(1 − cos φ)(J₃ − J₁)/2h + tan(φ/2) |μ|] ,   κ = ½ (1/J₁ − 1/J₃)
//! kick    of weight w: |Δ(RΠ)| ≤ w ū ,  |Δv| ≤ w ū/√J₁ ,  |Δμ| ≤ w ū
//! ```
//!
//! so momentum and speed grow no faster than the torque allows, counted from the start and, because
//! the scheme is reversible, from the end. Hence `sin φ ≤ h |Π|/J₁` and `sin φ ≤ h v/√J₁`. These
//! inequalities also hold for the continuous motion, as `h → 0`. The sums over the midpoints of the
//! steps are never below the integrals of the continuous motion, because the integrands are
//! concave.
//!
//! A limit r̄ of the rate of the torque bounds the momentum too. A drift changes Π in body axes by
//! no more than `h g`, `g = 2κP²/(1 + cos φ)`. Let a, b be the sums of the weights of the kicks
//! before and after. Then
//!
//! ```text
//! |Π − (b Π_0 + a Π_N)/(a + b)| ≤ r̄ (ab/2 + h²/8) + 2 (g + m̄) ab/(a + b) + h g/2
//! ```

use crate::maneuver::problem::Scheme;
use std::f64::consts::FRAC_PI_2;

/// The largest number of passes in the iteration for the angle of an arc with wheels. The iteration
/// finds the angle if the wheels store less than about `J₁/h`. If the wheels store much more, the
/// bound stays at 90° and proves nothing.
const WHEEL_PASSES: usize = 30;

/// Bounds on the torques, forces and rates of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Means {
    /// Largest actuator torque [N·m].
    pub torque: f64,
    /// Largest moment of the field [N·m].
    pub field: f64,
    /// Largest rate of change of a torque fixed to the body [N·m/s].
    pub slope: f64,
    /// Largest angular velocity [rad/s].
    pub rate: f64,
    /// Factor by which all limits of the angular velocity are multiplied.
    pub rate_growth: f64,
    /// Largest momentum in the wheels at a node [N·m·s].
    pub storage: f64,
}

impl Means {
    /// Returns whether the change of the momentum of the body has no limit.
    pub fn torque_is_unlimited(&self) -> bool {
        [self.torque + self.field, self.slope, self.storage].iter().all(|limit| *limit == f64::INFINITY)
    }
}

/// Moments of inertia of the body, and its momentum and speed at both ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    /// Smallest and largest principal moment `J₁`, `J₃` [kg·m²].
    pub moments: [f64; 2],
    /// Momentum `|Π|` at start and end [N·m·s].
    pub momentum: [f64; 2],
    /// Speed `v = √(Π·J⁻¹Π)` at start and end.
    pub speed: [f64; 2],
    /// The wheels, if the body has any.
    pub wheels: Option<Stored>,
}

/// Bounds on the momenta of the wheels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    /// Total momentum; infinite if it is not conserved [N·m·s].
    pub total: f64,
    /// Momentum `|μ|` of the wheels at start and end; infinite if it is not known [N·m·s].
    pub stored: [f64; 2],
}

/// Upper bounds on the motion on one arc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    /// Bound on the momentum `|Π|` [N·m·s].
    pub momentum: f64,
    /// Bound on the speed `v = √(Π·J⁻¹Π)`.
    pub speed: f64,
    /// Bound on the momentum `|μ|` of the wheels [N·m·s].
    pub stored: f64,
    /// Bound on the angle turned \[rad\], without rate limits.
    pub turn: f64,
    /// Bound on `tan²(φ/2) |μ|`, the contribution of the wheels to the momentum that turns the body
    /// [N·m·s].
    pub share: f64,
}

/// A uniform grid. It gives the total weight of the kicks before and after each arc.
#[derive(Clone, Copy, Debug)]
struct Grid {
    steps: usize,
    step: f64,
    /// Weight of the kick before the first arc, as a fraction of the step.
    first: f64,
}

impl Grid {
    fn before(&self, arc: usize) -> f64 {
        self.step * (arc as f64 + self.first)
    }

    fn after(&self, arc: usize) -> f64 {
        self.step * ((self.steps - arc) as f64 - self.first)
    }
}

/// Returns the bounds on every arc of a maneuver of `duration` \[s\].
pub(super) fn envelope(
    motion: &Motion,
    means: &Means,
    scheme: Scheme,
    steps: usize,
    duration: f64,
) -> Vec<Arc> {
    let first = if scheme == Scheme::LieEuler { 0.0 } else { 0.5 };
    let grid = Grid { steps, step: duration / steps as f64, first };
    let mut arcs: Vec<Arc> = (0..steps).map(|arc| motion.at_most(means, &grid, arc)).collect();
    if motion.wheels.is_none() && means.slope.is_finite() {
        motion.limit_by_slope(means, &grid, &mut arcs);
    }
    motion.limit_by_speed(means, &grid, &mut arcs);
    for arc in &mut arcs {
        (arc.turn, arc.share) = motion.turn(grid.step, arc);
    }
    arcs
}

impl Motion {
    /// Returns the bounds on an arc that follow from the torque limit and the boundary states.
    fn at_most(&self, means: &Means, grid: &Grid, arc: usize) -> Arc {
        let (before, after) = (grid.before(arc), grid.after(arc));
        let torque = means.torque + means.field;
        let grown = |ends: &[f64; 2], rate: f64| product(rate, before) + ends[0];
        let from = |ends: &[f64; 2], rate: f64| grown(ends, rate).min(product(rate, after) + ends[1]);
        let stored = self.wheels.map_or(0.0, |wheels| {
            from(&wheels.stored, means.torque).min(means.storage + product(means.torque, 0.5 * grid.step))
        });
        let momentum = match &self.wheels {
            Some(wheels) => wheels.total + stored,
            None => from(&self.momentum, torque),
        };
        Arc { momentum, speed: f64::INFINITY, stored, turn: FRAC_PI_2, share: stored }
    }

    /// Limits the momenta by the rate of change of the torque.
    fn limit_by_slope(&self, means: &Means, grid: &Grid, arcs: &mut [Arc]) {
        let duration = grid.step * grid.steps as f64;
        // The largest value of a concave function is at most this factor times its largest value at
        // the midpoints of the steps.
        let between = grid.steps as f64 / (grid.steps as f64 - 1.0);
        // Every pass starts from valid bounds and produces valid bounds.
        for _ in 0..8 {
            let peak = between * arcs.iter().map(|arc| arc.momentum).fold(0.0, f64::max);
            let peak = peak.min(means.rate * means.rate_growth * self.moments[1]);
            let gyroscopic = self.gyroscopic(grid.step, peak);
            for (index, arc) in arcs.iter_mut().enumerate() {
                let (a, b) = (grid.before(index), grid.after(index));
                let bound = (b * self.momentum[0] + a * self.momentum[1]) / duration
                    + means.slope * (0.5 * a * b + 0.125 * grid.step * grid.step)
                    + 2.0 * (gyroscopic + means.field) * a * b / duration
                    + 0.5 * grid.step * gyroscopic;
                arc.momentum = arc.momentum.min(bound);
            }
        }
    }

    /// Returns `½ (1/J₁ − 1/J₃)`: the largest `|Π × J⁻¹Π|` for `|Π| = 1`.
    fn kappa(&self) -> f64 {
        0.5 * (1.0 / self.moments[0] - 1.0 / self.moments[1])
    }

    /// Returns the bound g [N·m] on the rate of change of Π, the body-frame momentum, during one
    /// drift of length `step` \[s\]. The body has no wheels, and `momentum` is a bound on |Π|
    /// [N·m·s].
    fn gyroscopic(&self, step: f64, momentum: f64) -> f64 {
        let angle = sine_angle(step * momentum / self.moments[0]);
        product(2.0 * self.kappa() / (1.0 + angle.cos()), momentum * momentum)
    }

    /// Limits the speeds by the torque, counted from the start and from the end.
    fn limit_by_speed(&self, means: &Means, grid: &Grid, arcs: &mut [Arc]) {
        let gain = (means.torque + means.field) / self.moments[0].sqrt();
        let count = arcs.len();
        for (end, weight) in [(0, grid.before(0)), (1, grid.after(count - 1))] {
            let mut speed = self.speed[end] + product(gain, weight);
            for index in 0..count {
                let arc = &mut arcs[if end == 0 { index } else { count - 1 - index }];
                arc.speed = arc.speed.min(speed);
                if self.wheels.is_some() {
                    speed = self.after_drift(grid.step, speed, arc);
                }
                speed += gain * grid.step;
            }
        }
    }

    /// Returns a bound on the speed `v = √(Π·J⁻¹Π)` after a drift with wheels, for the bound
    /// `speed` before the drift.
    fn after_drift(&self, step: f64, speed: f64, arc: &Arc) -> f64 {
        let (angle, share) = self.turn(step, &Arc { speed, ..*arc });
        let [smallest, largest] = self.moments;
        let tangent = (0.5 * angle).tan();
        let gyroscopic =
            0.5 * (largest - smallest) * (1.0 - angle.cos()) / step + product(tangent, arc.stored);
        (speed * speed + product(4.0 * share, self.kappa() * gyroscopic)).sqrt()
    }

    /// Returns bounds on the angle of an arc \[rad\] and on the contribution of the wheels [N·m·s].
    fn turn(&self, step: f64, arc: &Arc) -> (f64, f64) {
        let smallest = self.moments[0];
        let (mut angle, mut share) = (FRAC_PI_2, arc.stored);
        // With wheels, each pass is valid for the angle of the pass before. Without wheels, the
        // first pass is final.
        for _ in 0..if arc.stored > 0.0 { WHEEL_PASSES } else { 1 } {
            let sine = step
                * ((arc.momentum + share) / smallest)
                    .min((arc.speed + share / smallest.sqrt()) / smallest.sqrt());
            let last = angle;
            angle = sine_angle(sine);
            if last - angle < 1e-12 {
                break;
            }
            share = product((0.5 * angle).tan().powi(2), arc.stored);
        }
        (angle, share)
    }
}

/// Returns the angle with this sine, or 90° if the sine is 1 or more.
pub(super) fn sine_angle(sine: f64) -> f64 {
    if sine < 1.0 { sine.asin() } else { FRAC_PI_2 }
}

/// Returns a product that is zero if one factor is zero, even if the other factor is infinite.
fn product(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maneuver::problem::{Problem, State};
    use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Wheels};
    use crate::mechanics::body::{Body, Inertia};
    use crate::testing::Random;
    use crate::verify::replay;
    use crate::{Matrix3, Vector3, lie};

    /// Returns Π before and after one drift of the witness, and its rotation vector.
    fn drift(moments: &Vector3, rate: &Vector3, stored: &Vector3, step: f64) -> Option<[Vector3; 3]> {
        let body = Body { inertia: Inertia::diagonal(*moments).ok()?, mass: None };
        let start = State::attitude(Matrix3::identity(), *rate);
        let wheels = Wheels { momentum: stored.as_slice().to_vec(), momentum_limit: vec![f64::INFINITY; 3] };
        let torque = ActuatorSet::three_axes(AxisFrame::Body);
        let mut problem = Problem::attitude(body, start, start, 2.0 * step).with_steps(2);
        problem.scheme = Scheme::LieEuler;
        if *stored != Vector3::zeros() {
            problem.actuation = Actuation { wheels: Some(wheels), ..Actuation::torques(torque) };
        }
        let plan = replay(&problem, &[0.0; 6]).ok()?;
        let momentum = |node: usize| moments.component_mul(&plan.angular_velocity[node]);
        let turn = lie::log(&lie::rotation_from_quaternion(&plan.quaternion[1]));
        Some([momentum(0), momentum(1), turn])
    }

    fn moments(random: &mut Random) -> Vector3 {
        let spread = Vector3::from_fn(|_, _| 10.0_f64.powf(random.uniform()));
        let mut moments = [spread.y + spread.z, spread.z + spread.x, spread.x + spread.y];
        moments.sort_by(f64::total_cmp);
        Vector3::from(moments)
    }

    fn motion(moments: &Vector3) -> Motion {
        Motion { moments: [moments.x, moments.z], momentum: [0.0; 2], speed: [0.0; 2], wheels: None }
    }

    fn speed(moments: &Vector3, momentum: &Vector3) -> f64 {
        momentum.dot(&momentum.component_div(moments)).sqrt()
    }

    fn exactly(moments: &Vector3, momentum: &Vector3, stored: &Vector3) -> Arc {
        let (stored, share) = (stored.norm(), stored.norm());
        Arc { momentum: momentum.norm(), speed: speed(moments, momentum), stored, turn: FRAC_PI_2, share }
    }

    /// Checks drifts without wheels. They conserve `|Π|` and `Π·J⁻¹Π`, and obey
    /// `h²|Π|² = sin²φ (e·Je)² + 4 sin²(φ/2)|e×Je|²`. They turn, and change Π in body axes, by no
    /// more than the bounds, and attain both bounds.
    #[test]
    fn drifts_without_wheels_obey_their_bounds() {
        let mut random = Random(21);
        let (mut turned, mut changed) = (0.0_f64, 0.0_f64);
        for case in 0..3000 {
            let moments = moments(&mut random);
            let size = 10.0_f64.powf(1.5 * random.uniform() - 1.5);
            let mut rate = size * random.vector3();
            match case % 3 {
                0 => rate = size * Vector3::x(),
                // Selects the direction with the largest |Π × J⁻¹Π|.
                1 => rate = size * Vector3::new(1.0 / moments.x, 0.0, 1.0 / moments.z).normalize(),
                _ => {}
            }
            let Some([before, after, turn]) = drift(&moments, &rate, &Vector3::zeros(), 1.0) else {
                continue;
            };
            let arc = exactly(&moments, &before, &Vector3::zeros());
            assert!((before.norm() - after.norm()).abs() < 1e-13 * before.norm());
            let (v, v_after) = (speed(&moments, &before), speed(&moments, &after));
            assert!((v - v_after).abs() < 1e-13 * v);
            let (angle, e) = (turn.norm(), turn.normalize());
            let je = moments.component_mul(&e);
            let square = (angle.sin() * e.dot(&je)).powi(2)
                + 4.0 * (0.5 * angle).sin().powi(2) * e.cross(&je).norm_squared();
            assert!((square - before.norm_squared()).abs() < 1e-12 * square, "{case}");
            let bound = motion(&moments).turn(1.0, &arc).0;
            assert!(angle <= bound * (1.0 + 1e-13), "{case}: {angle} {bound}");
            turned = turned.max(angle / bound);
            let (change, bound) = ((after - before).norm(), motion(&moments).gyroscopic(1.0, before.norm()));
            assert!(change <= bound * (1.0 + 1e-9) + 1e-15, "{case}: {change} {bound}");
            changed = changed.max(change / bound);
        }
        assert!(turned > 1.0 - 1e-12 && changed > 0.99, "{turned} {changed}");
    }

    /// Checks drifts with wheels of any momentum and direction: the angle and the speed after the
    /// drift. The angle is attained if the wheels turn against the body about its axis of the
    /// smallest moment.
    #[test]
    fn drifts_with_wheels_obey_their_bounds() {
        let mut random = Random(22);
        let (mut turned, mut gained, mut tried) = (0.0_f64, 0.0_f64, 0);
        for case in 0..6000 {
            let moments = moments(&mut random);
            let size = 10.0_f64.powf(1.5 * random.uniform() - 1.5);
            let mut rate = size * random.vector3();
            let mut stored = moments.x * 10.0_f64.powf(2.0 * random.uniform() - 1.0) * random.vector3();
            if case % 4 == 0 {
                rate = size * Vector3::x();
                stored = -stored.norm() * Vector3::x();
            }
            let Some([before, after, turn]) = drift(&moments, &rate, &stored, 1.0) else { continue };
            tried += 1;
            let arc = exactly(&moments, &before, &stored);
            let motion = motion(&moments);
            let (angle, (bound, share)) = (turn.norm(), motion.turn(1.0, &arc));
            assert!(angle <= bound * (1.0 + 1e-13), "{case}: {angle} {bound}");
            assert!((0.5 * angle).tan().powi(2) * stored.norm() <= share * (1.0 + 1e-13));
            turned = turned.max(angle / bound);
            let v = speed(&moments, &before);
            let (v_after, bound) = (speed(&moments, &after), motion.after_drift(1.0, v, &arc));
            assert!(v_after <= bound * (1.0 + 1e-13), "{case}: {v_after} {bound}");
            // The scheme is reversible, so the motion backwards from the end is a drift too.
            assert!(
                v <= motion.after_drift(1.0, v_after, &exactly(&moments, &after, &stored)) * (1.0 + 1e-13)
            );
            gained = gained.max((v_after - v) / (bound - v));
        }
        assert!(tried > 3000, "{tried}");
        assert!(turned > 1.0 - 1e-3 && gained > 0.2, "{turned} {gained}");
    }
}
