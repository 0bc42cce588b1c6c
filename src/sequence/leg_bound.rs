//! Rigorous lower bounds of the time, effort and fuel of rest-to-rest legs of a free body.
//!
//! The gyroscopic torque does no work. With `v = √(ΩᵀJΩ)` therefore
//!
//! ```text
//! |dv/dt| ≤ a = max |J^{-½}Bu| ,   v ≤ a min(t, T − t) ,   ∫ v dt ≥ d_J(Q)
//! |dΠ/dt| ≤ ū = max |Bu| ,         |Ω| ≤ |Π|/J₁ ≤ (ū/J₁) min(t, T − t) ,   ∫ |Ω| dt ≥ θ
//! ```
//!
//! with the geodesic distance `d_J` in the inertia metric and the angle θ of the turn Q. Rate
//! limits, and wheels with zero total momentum (`JΩ = −Σ a_i h_i`), also bound `|Ω|` and v. A path
//! of length l, at speeds up to s and with accelerations up to a, requires
//!
//! ```text
//! T ≥ 2 √(l/a)   if  l ≤ s²/a ,   T ≥ l/s + s/a   otherwise
//! ∫ ½ uᵀWu dt ≥ 6 l²/(μ T³) ,   μ = λ_max(BW⁻¹Bᵀ) in the metric of the length
//! ∫ Σ c_i|u_i| dt ≥ 2 l/(κ T) ,   κ = max |a_i|/c_i in the metric of the length
//! ```
//!
//! and the larger of the bounds from the two lengths holds.
//!
//! # How is the distance bounded from below?
//!
//! A smaller inertia `J' ≤ J` has smaller distances. The two largest axisymmetric inertias
//! `(a, a, c)` below J are `(J₁, J₁, J₃)` about the third principal axis and `(J₂, J₂, J₁)` about
//! the first. For them a motion to Q consists of two parts. The symmetry axis e follows a path of
//! length ℓ on the unit sphere, which encloses the area A with the shortest arc, and the body spins
//! by `χ − A` about e. So
//!
//! ```text
//! d² = min_A  a ℓ(A)² + c (χ − A)² ,   Q = exp(χ e) after the shortest tilt by ψ
//! ```
//!
//! The shortest path for an area is an arc of a circle (isoperimetry). With its half angle η, as
//! seen from the centre, `ℓ = 2η sin(ψ/2)/sin η`; the area is the area of the sector minus the
//! triangle. Both increase with η, so each interval of η has a lower bound. Bisection of the
//! interval with the smallest bound finds the minimum from below, and cannot miss a root. A grid of
//! roots of the geodesic equation missed a root: it gave 33.7 instead of 26.4, which is above the
//! true value.

use crate::maneuver::constraint::Rule;
use crate::maneuver::infeasible::Outputs;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::ActuatorSet;
use crate::mechanics::body::principal_axes;
use crate::{Matrix3, Vector3, lie};
use std::f64::consts::PI;

/// Relative reduction of every bound, so that round-off cannot lift it above the true value.
const ROUND_OFF: f64 = 1e-9;

/// Relative width of the bracket of a distance at which bisection ends. A smaller width takes more
/// time and improves the bound by less than this.
const WIDTH: f64 = 1e-4;

/// Largest number of bisections for a distance. Near ψ = π the area changes fast and the bracket
/// stays wider; the bound remains valid.
const MAX_BISECTIONS: usize = 400;

/// The bounds on motions along one of the two lengths: largest acceleration and speed, and the
/// constants of effort and fuel.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Means {
    /// Largest second derivative of the length.
    acceleration: f64,
    /// Largest rate of change of the length; infinite without a limit.
    speed: f64,
    /// Largest squared acceleration per unit of `uᵀWu`; infinite if unknown.
    authority: f64,
    /// Largest acceleration per unit of the fuel rate; infinite if unknown.
    per_fuel: f64,
}

/// Lower bounds of the rest-to-rest legs of one spacecraft.
#[derive(Clone, Debug, PartialEq)]
pub struct LegBound {
    /// Principal moments of inertia in ascending order [kg·m²].
    moments: Vector3,
    /// Principal axes as columns, in body axes.
    axes: Matrix3,
    /// Bounds on motions by the angle of the turn \[rad\].
    angle: Means,
    /// Bounds on motions by the length in the inertia metric [√(kg·m²)].
    metric: Means,
}

impl Means {
    /// Returns the least time \[s\] from rest to rest over `length`.
    fn time(&self, length: f64) -> f64 {
        let Self { acceleration, speed, .. } = *self;
        if acceleration == f64::INFINITY {
            length / speed
        } else if length <= speed * speed / acceleration {
            2.0 * (length / acceleration).sqrt()
        } else {
            length / speed + speed / acceleration
        }
    }
}

impl LegBound {
    /// The number of values in [`LegBound::numbers`].
    pub const NUMBERS: usize = 20;

    /// Builds the bounds for the craft of a problem. Start, end, force fields, cones and duration
    /// of the problem are ignored. Cones only lengthen a leg, so the bounds stay valid; they are
    /// not valid in a force field, or if wheels store momentum.
    pub fn new(problem: &Problem) -> Self {
        let inertia = problem.body.inertia.j();
        let (moments, axes) = principal_axes(inertia);
        let metric =
            axes * Matrix3::from_diagonal(&moments.map(|moment| 1.0 / moment.sqrt())) * axes.transpose();
        let set = &problem.actuation.torque;
        let weights = problem.objective.weights().torque(&problem.actuation);
        let prices = match &problem.objective {
            Objective::Fuel(fuel) => fuel.prices.clone(),
            _ => None,
        };
        let prices = prices.unwrap_or_else(|| vec![1.0; set.count()]);
        let (mut rate, mut wheels) = (f64::INFINITY, [f64::INFINITY; 2]);
        for constraint in &problem.constraints {
            match &constraint.rule {
                Rule::RateNorm(limit) => rate = rate.min(*limit),
                Rule::RateAxes(limits) => rate = rate.min(limits.norm()),
                Rule::Pointing(_) => {}
            }
        }
        if let Some(held) = &problem.actuation.wheels {
            // The rates and speeds that saturated wheels produce: Ω = J⁻¹ Σ a h.
            let inverse = problem.body.inertia.j_inverse();
            for (bound, map) in wheels.iter_mut().zip([*inverse, metric]) {
                let turned: Vec<Vector3> = set.axes().iter().map(|axis| map * axis).collect();
                *bound = Outputs::new(&turned, held.momentum_limit.iter().copied()).largest();
            }
        }
        let means = |map: &Matrix3, speed: f64| {
            let turned: Vec<Vector3> = set.axes().iter().map(|axis| map * axis).collect();
            let per_fuel = turned.iter().zip(&prices).map(|(axis, price)| axis.norm() / price);
            Means {
                acceleration: strongest(&turned, set, map) * (1.0 + ROUND_OFF),
                speed,
                authority: principal_axes(&(map * weights.authority * map.transpose())).0[2]
                    * (1.0 + ROUND_OFF),
                per_fuel: per_fuel.fold(0.0, f64::max),
            }
        };
        let [slowest, heaviest] = [moments[0], moments[2]];
        // The rate of change of the angle is |Ω|, with |Ω| ≤ |Π|/J₁ and |Ω| ≤ v/√J₁.
        let of_momentum = means(&(Matrix3::identity() / slowest), rate.min(wheels[0]));
        let of_energy = means(&(metric / slowest.sqrt()), rate.min(wheels[0]));
        let angle = Means {
            acceleration: of_momentum.acceleration.min(of_energy.acceleration),
            speed: rate.min(wheels[0]),
            authority: of_momentum.authority.min(of_energy.authority),
            per_fuel: of_momentum.per_fuel.min(of_energy.per_fuel),
        };
        Self { moments, axes, angle, metric: means(&metric, wheels[1].min(rate * heaviest.sqrt())) }
    }

    /// Returns a lower bound of the time \[s\] of a turn from rest to rest; zero for the identity.
    pub fn time(&self, turn: &Matrix3) -> f64 {
        let angle = lie::log(turn).norm();
        self.angle.time(angle).max(self.metric.time(self.distance(turn))) * (1.0 - ROUND_OFF)
    }

    /// Returns a lower bound of the time \[s\] of every turn by at least `angle` \[rad\].
    pub fn time_of_angle(&self, angle: f64) -> f64 {
        (1.0 - ROUND_OFF) * self.angle.time(angle)
    }

    /// Returns a lower bound of the effort `∫ ½ uᵀWu dt` of a turn from rest to rest in `duration`
    /// \[s\].
    pub fn effort(&self, turn: &Matrix3, duration: f64) -> f64 {
        let of = |length: f64, means: &Means| 6.0 * length * length / (means.authority * duration.powi(3));
        let angle = of(lie::log(turn).norm(), &self.angle);
        angle.max(of(self.distance(turn), &self.metric)) * (1.0 - ROUND_OFF)
    }

    /// Returns a lower bound of the fuel `∫ Σ c_i |u_i| dt` of a turn from rest to rest in
    /// `duration` \[s\].
    pub fn fuel(&self, turn: &Matrix3, duration: f64) -> f64 {
        let of = |length: f64, means: &Means| 2.0 * length / (means.per_fuel * duration);
        let angle = of(lie::log(turn).norm(), &self.angle);
        angle.max(of(self.distance(turn), &self.metric)) * (1.0 - ROUND_OFF)
    }

    /// Returns a lower bound of the geodesic distance `min ∫ √(ΩᵀJΩ) dt` between the identity and a
    /// turn [√(kg·m²)]. It is at least `√J₁ θ`.
    pub fn distance(&self, turn: &Matrix3) -> f64 {
        let [q0, x, y, z] = lie::quaternion_from_rotation(turn);
        let vector = self.axes.tr_mul(&Vector3::new(x, y, z));
        let [first, second, third] = [self.moments[0], self.moments[1], self.moments[2]];
        let about = |axis: usize, across: f64, along: f64| {
            let spin = vector[axis];
            let tilt = (vector.norm_squared() - spin * spin).max(0.0).sqrt();
            axisymmetric_distance(tilt.atan2(q0.hypot(spin)), spin.atan2(q0), across, along)
        };
        let least = first.sqrt() * lie::log(turn).norm();
        least.max(about(2, first, third)).max(about(0, second, first))
    }

    /// Returns the numbers that define the bounds, in a fixed order, for files.
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let mut numbers = [0.0; Self::NUMBERS];
        numbers[..3].copy_from_slice(self.moments.as_slice());
        numbers[3..12].copy_from_slice(self.axes.as_slice());
        for (part, means) in numbers[12..].chunks_mut(4).zip([&self.angle, &self.metric]) {
            part.copy_from_slice(&[means.acceleration, means.speed, means.authority, means.per_fuel]);
        }
        numbers
    }

    /// Builds the bounds from [`LegBound::numbers`]; `None` if the numbers cannot belong to a body.
    pub fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let numbers: &[f64; Self::NUMBERS] = numbers.try_into().ok()?;
        let means = |part: &[f64]| Means {
            acceleration: part[0],
            speed: part[1],
            authority: part[2],
            per_fuel: part[3],
        };
        let found = Self {
            moments: Vector3::from_column_slice(&numbers[..3]),
            axes: Matrix3::from_column_slice(&numbers[3..12]),
            angle: means(&numbers[12..16]),
            metric: means(&numbers[16..]),
        };
        let positive = numbers[..3].iter().chain(&numbers[12..]).all(|value| *value > 0.0);
        (positive && lie::orthogonality(&found.axes) < 1e-9).then_some(found)
    }
}

/// Returns the largest norm of the torque of an actuator set after the linear map `map`; `turned`
/// holds the mapped axes.
fn strongest(turned: &[Vector3], set: &ActuatorSet, map: &Matrix3) -> f64 {
    let limits = set.limits();
    let of_norm = limits.norm.map_or(f64::INFINITY, |norm| norm * principal_axes(map).0[2]);
    let of_sizes = limits.size.as_ref().map_or(f64::INFINITY, |sizes| {
        if !limits.one_sided {
            return Outputs::new(turned, sizes.iter().copied()).largest();
        }
        // Inputs from 0 to L equal L/2 ± L/2, so the largest |centre + output| equals the largest
        // ±centre + output|.
        let center: Vector3 = turned.iter().zip(sizes).map(|(axis, size)| axis * (0.5 * size)).sum();
        let axes: Vec<Vector3> = turned.iter().copied().chain([center]).collect();
        let halves = sizes.iter().map(|size| 0.5 * size).chain([1.0]);
        let whole = center.norm() > 1e-12 * sizes.iter().copied().fold(0.0, f64::max) * map.norm();
        let count = axes.len() - usize::from(!whole);
        Outputs::new(&axes[..count], halves.take(count)).largest() + if whole { 0.0 } else { center.norm() }
    });
    of_norm.min(of_sizes)
}

/// Returns a lower bound of the distance for the principal moments (a, a, c). The symmetry axis
/// tilts by `2 half_tilt`, and the body spins by `2 half_spin` about it.
fn axisymmetric_distance(half_tilt: f64, half_spin: f64, across: f64, along: f64) -> f64 {
    // The spin is reduced modulo a full turn.
    let mut spin = (2.0 * half_spin).rem_euclid(2.0 * PI);
    spin = spin.min(2.0 * PI - spin);
    let chord = half_tilt.sin();
    if chord < 1e-9 {
        // Ignoring the tilt changes the distance by at most the length of the tilt.
        return (pure_spin(spin, across, along) - 2.0 * half_tilt * across.sqrt()).max(0.0);
    }
    // Length and enclosed area of the arc with half angle eta.
    let length = |eta: f64| 2.0 * eta * chord / eta.sin();
    let area = |eta: f64| {
        let sine = (chord / eta.sin()).min(1.0);
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        let square = (1.0 - cosine) / (1.0 + cosine);
        let excess = 2.0 * (square * (2.0 * eta).sin()).atan2(1.0 + square * (2.0 * eta).cos());
        2.0 * eta * (1.0 - cosine) - excess
    };
    let square = |length: f64, left: f64| across * length * length + along * left * left;
    let interval =
        |from: f64, to: f64| Interval { from, to, least: square(length(from), (spin - area(to)).max(0.0)) };
    let first = half_tilt.min(0.5 * PI);
    let last = PI - first;
    let mut most = square(length(first), spin);
    let mut intervals = vec![interval(first, last)];
    for _ in 0..MAX_BISECTIONS {
        let (index, least) = smallest(&intervals);
        if least >= most * (1.0 - WIDTH) {
            break;
        }
        let Interval { from, to, .. } = intervals.swap_remove(index);
        let middle = 0.5 * (from + to);
        most = most.min(square(length(middle), (spin - area(middle)).abs()));
        intervals.extend([interval(from, middle), interval(middle, to)]);
        intervals.retain(|interval| interval.least <= most);
    }
    let least = smallest(&intervals).1.min(most);
    // The tilt alone is a lower bound for any spin.
    least.sqrt().max(2.0 * half_tilt * across.sqrt())
}

/// Returns the distance of a pure spin; a closed circle that encloses the area A has
/// `ℓ² = A(4π − A)`.
fn pure_spin(spin: f64, across: f64, along: f64) -> f64 {
    // d² = a A(4π − A) + c (χ − A)² is quadratic in A. Its minimum on 0 ≤ A ≤ χ is at an end or
    // inside.
    let of = |area: f64| across * area * (4.0 * PI - area) + along * (spin - area).powi(2);
    let mut least = of(0.0).min(of(spin));
    let curvature = along - across;
    if curvature > 0.0 {
        let area = (along * spin - 2.0 * PI * across) / curvature;
        if area > 0.0 && area < spin {
            least = least.min(of(area));
        }
    }
    least.sqrt()
}

/// An interval of half angles with a lower bound of the squared distance on it.
struct Interval {
    from: f64,
    to: f64,
    least: f64,
}

/// Returns the index of the interval with the smallest bound, and this bound.
fn smallest(intervals: &[Interval]) -> (usize, f64) {
    let each = intervals.iter().map(|interval| interval.least).enumerate();
    each.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// Returns the distance along the geodesics `exp(u) exp((a/c − 1)(u·e) e)`: the length of the
    /// shortest one, on a fine grid, that ends at the turn.
    fn by_geodesics(moments: [f64; 2], half_tilt: f64, half_spin: f64) -> f64 {
        let [across, along] = moments;
        let mut least = f64::INFINITY;
        const POINTS: usize = 400_000;
        // For each angle the tilt determines the component z along the axis. The spin is then a
        // function of the angle, and its roots lie between its changes of sign.
        for sign in [-1.0, 1.0] {
            let state = |angle: f64| {
                let sine = (0.5 * angle).sin();
                let z = sign * (1.0 - (half_tilt.sin() / sine).powi(2)).max(0.0).sqrt();
                let half = (sine * z).atan2((0.5 * angle).cos()) + 0.5 * (across / along - 1.0) * angle * z;
                let miss = (half - half_spin + 0.5 * PI).rem_euclid(PI) - 0.5 * PI;
                let length = angle * (across * (1.0 - z * z) + across * across / along * z * z).sqrt();
                (miss, length)
            };
            let (from, to) = (2.0 * half_tilt, 2.0 * PI - 2.0 * half_tilt);
            let mut last = state(from);
            for point in 1..=POINTS {
                let next = state(from + (to - from) * point as f64 / POINTS as f64);
                if last.0 * next.0 <= 0.0 && (last.0 - next.0).abs() < 1.0 {
                    least = least.min(last.1.max(next.1));
                }
                last = next;
            }
        }
        least
    }

    #[test]
    fn axisymmetric_distance_is_that_of_the_shortest_geodesic() {
        let mut random = Random(71);
        for _ in 0..40 {
            let (across, along) = (1.0 + 0.9 * random.uniform(), 1.0 + 0.9 * random.uniform());
            let half_tilt = 0.25 * PI * (1.0 + 0.95 * random.uniform());
            let half_spin = 0.5 * PI * random.uniform();
            let found = axisymmetric_distance(half_tilt, half_spin, across, along);
            let expected = by_geodesics([across, along], half_tilt, half_spin);
            assert!(found <= expected * (1.0 + 1e-4), "{found} {expected}");
            assert!(
                found >= expected * (1.0 - 1e-3),
                "{found} {expected}: {across} {along} {half_tilt} {half_spin}"
            );
        }
    }

    #[test]
    fn equal_moments_have_the_distance_of_the_angle() {
        let mut random = Random(72);
        for _ in 0..200 {
            let turn = random.rotation();
            let [q0, x, y, z] = lie::quaternion_from_rotation(&turn);
            let found = axisymmetric_distance(x.hypot(y).atan2(q0.hypot(z)), z.atan2(q0), 2.0, 2.0);
            let expected = 2.0_f64.sqrt() * lie::log(&turn).norm();
            assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
        }
    }

    #[test]
    fn bounds_survive_their_numbers() {
        let problem = crate::Problem::attitude(
            crate::Body { inertia: crate::testing::full_inertia(), mass: None },
            crate::State::at_rest(Matrix3::identity()),
            crate::State::at_rest(Matrix3::identity()),
            1.0,
        );
        let bound = LegBound::new(&problem);
        assert_eq!(LegBound::from_numbers(&bound.numbers()), Some(bound.clone()));
        let mut numbers = bound.numbers();
        numbers[0] = f64::NAN;
        assert_eq!(LegBound::from_numbers(&numbers), None);
        assert_eq!(LegBound::from_numbers(&numbers[1..]), None);
        // Without limits every time is feasible, so the bound is zero.
        assert_eq!(bound.time(&lie::exp(&Vector3::x())), 0.0);
    }
}
