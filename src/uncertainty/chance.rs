//! The chance that a limit is exceeded at an instant of a plan, to first order. A boresight enters
//! a keep-out cone or leaves a keep-in cone, the body turns too fast, or a command exceeds the
//! limit of an input or changes too fast.
//!
//! ```text
//! cone      θ_k = angle(R_k b, w) − α ,   σ² = gᵀ P_ζζ g ,   g = (1/sin θ) wᵀ R_k S(b)          chance Φ(−room/σ)
//! rate      Ω̄ − |Ω*_k| ,                  σ² = gᵀ P_ΩΩ g ,   g = Ω*/|Ω*| ;  of a component its own
//! torque    ū_i − |u*_ik| ,               σ² = [K P Kᵀ]_ii ;  of the norm ū − |B u*| ,  g = B u*/|B u*|
//! its rate  r_i − |u*_ik+1 − u*_ik|/h ,   σ of the change of the correction, over h
//! ```
//!
//! For torques, `P` is the covariance of the measured state. Errors of neighbouring instants are
//! correlated. The chance at the worst instant is therefore near the chance over the whole plan,
//! whereas the sum of the chances over all instants is far above it.

use super::Covariance;
use crate::lie::hat;
use crate::maneuver::Problem;
use crate::maneuver::constraint::{Constraint, Pointing, Rule, Side};
use crate::mechanics::actuators::LimitKind;
use crate::optimize::discrete::linear_plan::LinearPlan;
use crate::{Matrix3, Vector3};
use statrs::distribution::{ContinuousCDF, Normal};

/// The physical quantity that a limit bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Angle between a boresight and the edge of a cone \[rad\].
    Angle,
    /// Angular velocity [rad/s].
    Rate,
    /// Torque of one input, or norm of the total torque [N·m].
    Torque,
    /// Rate of change of the torque of an input [N·m/s].
    TorqueRate,
}

/// The state of a limit at the instant with the largest chance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Worst {
    /// Index of the node; for inputs, index of the step that begins at this node.
    pub node: usize,
    /// Chance of exceeding the limit at this instant.
    pub chance: f64,
    /// Standard deviation of the limited quantity at this instant, in the unit of its [`Quantity`].
    pub sigma: f64,
    /// Distance of the plan from the limit at this instant, without margin.
    pub room: f64,
}

/// The chance of violating a constraint or exceeding an input limit, along a plan.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Chance {
    /// Name of the constraint or of the input limit.
    pub name: String,
    /// The physical quantity that is limited.
    pub quantity: Quantity,
    /// Chance at each node, or in each step for inputs: the largest over the parts of the limit.
    pub nodes: Vec<f64>,
    /// The worst instant of each part of the limit. A cone and a norm have one part; other limits
    /// have one part per component or input.
    pub parts: Vec<Worst>,
}

/// Returns the distribution function `Φ(x)` of the standard normal distribution.
pub fn normal_cdf(x: f64) -> f64 {
    Normal::standard().cdf(x)
}

/// Returns the quantile `Φ⁻¹(p)` of the standard normal distribution.
pub fn normal_quantile(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

/// Relative tolerance by which a plan may exceed a limit due to round-off.
const AT_LIMIT: f64 = 1e-9;

/// Distance from the limit and standard deviation, for each part of a limit at one instant.
type Instant = Vec<(f64, f64)>;

impl Chance {
    /// Returns the chance of violating each constraint of a maneuver, for the limits of the craft
    /// and without margins. Cones on whose surface a boresight is held are excluded, because any
    /// error leaves the surface.
    pub fn of_constraints(problem: &Problem, plan: &LinearPlan, covariance: &Covariance) -> Vec<Self> {
        let craft = problem.of_craft();
        let held = |rule: &Rule| matches!(rule, Rule::Pointing(Pointing { side: Side::On { .. }, .. }));
        let judged = craft.constraints.iter().filter(|constraint| !held(&constraint.rule));
        judged.map(|constraint| Self::of(constraint, &craft, plan, covariance)).collect()
    }

    /// Returns the chance of exceeding each torque limit in closed loop, for the limits of the
    /// craft. Empty in open loop, where no corrections are made.
    pub fn of_limits(problem: &Problem, plan: &LinearPlan, covariance: &Covariance) -> Vec<Self> {
        let craft = problem.of_craft();
        let count = covariance.inputs.len();
        let step = |k: usize| plan.times()[k + 1] - plan.times()[k];
        let mut all = Vec::new();
        for limit in craft.actuation.limits().filter(|limit| !limit.of_force && count > 0) {
            let bounds = limit.bounds;
            let rounded = |room: f64, bound: f64| if room.abs() <= AT_LIMIT * bound { 0.0 } else { room };
            let (quantity, instants): (Quantity, Vec<Instant>) = match limit.kind {
                LimitKind::Size => {
                    let part = |k: usize, i: usize| {
                        let room = bounds[i] - plan.inputs(k)[i].abs();
                        (rounded(room, bounds[i]), covariance.inputs[k][i])
                    };
                    let at = |k: usize| (0..bounds.len()).map(|i| part(k, i)).collect();
                    (Quantity::Torque, (0..count).map(at).collect())
                }
                LimitKind::Norm => {
                    let at = |k: usize| {
                        let torque = limit.set.output(plan.inputs(k));
                        let (size, along) = size_of(&torque);
                        let room = rounded(bounds[0] - size, bounds[0]);
                        vec![(room, deviation(&covariance.torque[k], &along))]
                    };
                    (Quantity::Torque, (0..count).map(at).collect())
                }
                LimitKind::Rate => {
                    let part = |k: usize, i: usize| {
                        let change = (plan.inputs(k + 1)[i] - plan.inputs(k)[i]).abs() / step(k);
                        let sigma = covariance.input_changes[k][i] / step(k);
                        (rounded(bounds[i] - change, bounds[i]), sigma)
                    };
                    let at = |k: usize| (0..bounds.len()).map(|i| part(k, i)).collect();
                    (Quantity::TorqueRate, (0..covariance.input_changes.len()).map(at).collect())
                }
                LimitKind::WheelMomentum => continue,
            };
            all.push(Self::along(limit.name, quantity, &instants));
        }
        all
    }

    /// Returns the chance of violating one constraint along a plan.
    pub fn of(
        constraint: &Constraint,
        problem: &Problem,
        plan: &LinearPlan,
        covariance: &Covariance,
    ) -> Self {
        let frame_rate = problem.environment.frame_rate();
        let at = |node: usize| -> Instant {
            let (attitude, rate) = plan.node(node);
            match &constraint.rule {
                Rule::Pointing(cone) if !cone.during.contains(plan.times()[node]) => {
                    vec![(f64::INFINITY, 0.0)]
                }
                Rule::Pointing(cone) => {
                    let of_attitude = covariance.states[node].fixed_view::<3, 3>(0, 0).into_owned();
                    vec![beside_cone(cone, attitude, plan.times()[node], &frame_rate, &of_attitude)]
                }
                Rule::RateNorm(limit) => {
                    let (size, along) = size_of(rate);
                    vec![(limit - size, deviation(&covariance.rates[node], &along))]
                }
                Rule::RateAxes(limits) => {
                    let sigma = |axis: usize| covariance.rates[node][(axis, axis)].max(0.0).sqrt();
                    (0..3).map(|axis| (limits[axis] - rate[axis].abs(), sigma(axis))).collect()
                }
            }
        };
        let quantity = match &constraint.rule {
            Rule::Pointing(_) => Quantity::Angle,
            Rule::RateNorm(_) | Rule::RateAxes(_) => Quantity::Rate,
        };
        let instants: Vec<Instant> = (0..covariance.states.len()).map(at).collect();
        Self::along(&constraint.name, quantity, &instants)
    }

    fn along(name: &str, quantity: Quantity, instants: &[Instant]) -> Self {
        let mut out = Self { name: name.into(), quantity, nodes: Vec::new(), parts: Vec::new() };
        for (node, parts) in instants.iter().enumerate() {
            let mut largest: f64 = 0.0;
            for (part, (room, sigma)) in parts.iter().enumerate() {
                let found = Worst { node, chance: beyond(*room, *sigma), sigma: *sigma, room: *room };
                // NaN counts as the worst value.
                largest =
                    if found.chance > largest || found.chance.is_nan() { found.chance } else { largest };
                match out.parts.get_mut(part) {
                    None => out.parts.push(found),
                    Some(worst) if found.is_worse_than(worst) => *worst = found,
                    Some(_) => {}
                }
            }
            out.nodes.push(largest);
        }
        out
    }

    /// Returns the worst instant of the part that has the largest chance.
    pub fn worst(&self) -> Worst {
        let none = Worst { node: 0, chance: 0.0, sigma: 0.0, room: f64::INFINITY };
        self.parts.iter().fold(none, |worst, part| if part.is_worse_than(&worst) { *part } else { worst })
    }

    /// Returns the largest chance over all parts and instants.
    pub fn largest(&self) -> f64 {
        self.worst().chance
    }
}

impl Worst {
    fn is_worse_than(&self, other: &Self) -> bool {
        // At instants exactly on a limit the chances are equal; then the largest deviation decides.
        let key = |worst: &Self| (worst.chance, -worst.room, worst.sigma);
        key(self) > key(other)
    }
}

/// Returns the chance that a normal error of standard deviation `sigma` exceeds `room`.
fn beyond(room: f64, sigma: f64) -> f64 {
    if sigma > 0.0 { normal_cdf(-room / sigma) } else { f64::from(u8::from(room < 0.0)) }
}

/// Returns the length and the unit direction of a vector; the direction is zero for the zero
/// vector.
fn size_of(vector: &Vector3) -> (f64, Vector3) {
    let size = vector.norm();
    (size, if size > 0.0 { vector / size } else { Vector3::zeros() })
}

/// Returns the standard deviation `√(gᵀPg)` of a quantity with gradient `g`, for the covariance
/// `P`.
fn deviation(covariance: &Matrix3, gradient: &Vector3) -> f64 {
    gradient.dot(&(covariance * gradient)).max(0.0).sqrt()
}

/// Returns the distance from the cone without its margin, and the standard deviation of this
/// distance, for the pair of boresight and direction with the largest chance.
fn beside_cone(
    cone: &Pointing,
    attitude: &Matrix3,
    time: f64,
    frame_rate: &Vector3,
    of_attitude: &Matrix3,
) -> (f64, f64) {
    let without = Pointing { margin: 0.0, ..cone.clone() };
    let mut worst: Option<(f64, f64, f64)> = None;
    for (boresight, direction) in cone.pairs() {
        let (angle, gradient) = angle_from(attitude, boresight, &direction.at(time, frame_rate));
        let room = without.room_beside(angle, direction.angular_radius(time));
        // The sign of the gradient depends on the side of the cone; it has no effect on σ.
        let sigma = deviation(of_attitude, &gradient);
        let chance = beyond(room, sigma);
        let worse = |(before, least, _): (f64, f64, f64)| {
            chance > before || chance == before && room < least || chance.is_nan()
        };
        if worst.is_none_or(worse) {
            worst = Some((chance, room, sigma));
        }
    }
    worst.map_or((f64::INFINITY, 0.0), |(_, room, sigma)| (room, sigma))
}

/// Returns the angle between a boresight and a direction, and the gradient of this angle by `ζ`:
/// `(1/sin θ) wᵀ R S(b)`.
fn angle_from(attitude: &Matrix3, boresight: &Vector3, direction: &Vector3) -> (f64, Vector3) {
    let seen = attitude.tr_mul(direction);
    let cross = boresight.cross(&seen);
    let (sin, cos) = (cross.norm(), boresight.dot(&seen));
    let angle = sin.atan2(cos);
    let gradient = if sin > 0.0 { hat(boresight).tr_mul(&seen) / sin } else { Vector3::zeros() };
    (angle, gradient)
}
