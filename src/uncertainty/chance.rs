//! The chance that a limit is exceeded at an instant of a plan, to first order: a boresight
//! enters a cone or leaves one, the body turns too fast, a command exceeds the limit of an input,
//! or changes too fast.
//!
//! ```text
//! cone      θ_k = angle(R_k b, w) − α ,   σ² = gᵀ P_ζζ g ,   g = (1/sin θ) wᵀ R_k S(b)          chance Φ(−room/σ)
//! rate      Ω̄ − |Ω*_k| ,                  σ² = gᵀ P_ΩΩ g ,   g = Ω*/|Ω*| ;  of a component its own
//! torque    ū_i − |u*_ik| ,               σ² = [K P Kᵀ]_ii ;  of the norm ū − |B u*| ,  g = B u*/|B u*|
//! its rate  r_i − |u*_ik+1 − u*_ik|/h ,   σ of the change of the correction, over h
//! ```
//!
//! `P` of torques is the covariance of the measured state. Errors of neighbouring instants are
//! correlated, so the chance of the worst instant is near the chance of the whole plan, and the
//! sum of the chances is not.

use super::Covariance;
use crate::lie::hat;
use crate::maneuver::Problem;
use crate::maneuver::constraint::{Constraint, Pointing, Rule, Side};
use crate::mechanics::actuators::LimitKind;
use crate::optimize::discrete::linear_plan::LinearPlan;
use crate::{Matrix3, Vector3};
use statrs::distribution::{ContinuousCDF, Normal};

/// The limited quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The angle of a boresight from a cone \[rad\].
    Angle,
    /// The angular velocity [rad/s].
    Rate,
    /// The torque of an input, or the norm of all [N·m].
    Torque,
    /// The rate of the torque of an input [N·m/s].
    TorqueRate,
}

/// A limit at the instant of its largest chance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Worst {
    /// The node; for inputs, the step that begins at the node.
    pub node: usize,
    /// The chance of exceeding it then.
    pub chance: f64,
    /// The standard deviation of the limited quantity at that time, in the unit of its
    /// [`Quantity`].
    pub sigma: f64,
    /// The distance of the plan from the limit at that time, without margin.
    pub room: f64,
}

/// The chance of violating a constraint, or of exceeding a limit of the inputs.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Chance {
    /// The name of the constraint or limit.
    pub name: String,
    /// The limited quantity.
    pub quantity: Quantity,
    /// Chance at each node, or in each step: the largest of its parts.
    pub nodes: Vec<f64>,
    /// The worst chance of each part of the limit: a cone and a norm have one part, components and
    /// inputs have one part each.
    pub parts: Vec<Worst>,
}

/// Returns `Φ(x)` of the standard normal distribution.
pub fn normal_cdf(x: f64) -> f64 {
    Normal::standard().cdf(x)
}

/// Returns `Φ⁻¹(p)`.
pub fn normal_quantile(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

/// The relative excess by which a plan at a limit may exceed it, due to round-off.
const AT_LIMIT: f64 = 1e-9;

/// Room and deviation of each part at an instant.
type Instant = Vec<(f64, f64)>;

impl Chance {
    /// Returns the chances of every constraint of a maneuver, for the limits of the craft and
    /// without margins. Cones on which boresights are held are excluded, because a boresight
    /// leaves them with certainty.
    pub fn of_constraints(problem: &Problem, plan: &LinearPlan, covariance: &Covariance) -> Vec<Self> {
        let craft = problem.of_craft();
        let held = |rule: &Rule| matches!(rule, Rule::Pointing(Pointing { side: Side::On { .. }, .. }));
        let judged = craft.constraints.iter().filter(|constraint| !held(&constraint.rule));
        judged.map(|constraint| Self::of(constraint, &craft, plan, covariance)).collect()
    }

    /// Returns the chances of every limit of the torques with gains, for the limits of the craft;
    /// empty in open loop, where no correction is made.
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

    /// Returns the chance of one constraint.
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

    /// Returns the part with the largest chance, and the node of that chance.
    pub fn worst(&self) -> Worst {
        let none = Worst { node: 0, chance: 0.0, sigma: 0.0, room: f64::INFINITY };
        self.parts.iter().fold(none, |worst, part| if part.is_worse_than(&worst) { *part } else { worst })
    }

    /// Returns the largest of all instants.
    pub fn largest(&self) -> f64 {
        self.worst().chance
    }
}

impl Worst {
    fn is_worse_than(&self, other: &Self) -> bool {
        // Among instants at a limit, which have equal chances, selects the one with the largest
        // deviation.
        let key = |worst: &Self| (worst.chance, -worst.room, worst.sigma);
        key(self) > key(other)
    }
}

/// Returns the chance of being more than `room` off.
fn beyond(room: f64, sigma: f64) -> f64 {
    if sigma > 0.0 { normal_cdf(-room / sigma) } else { f64::from(u8::from(room < 0.0)) }
}

/// Returns the length and direction of a vector; no direction of none.
fn size_of(vector: &Vector3) -> (f64, Vector3) {
    let size = vector.norm();
    (size, if size > 0.0 { vector / size } else { Vector3::zeros() })
}

/// Returns `√(gᵀPg)`.
fn deviation(covariance: &Matrix3, gradient: &Vector3) -> f64 {
    gradient.dot(&(covariance * gradient)).max(0.0).sqrt()
}

/// Returns the room and the deviation for the pair of a boresight and a direction with the
/// largest chance, to a cone without its margin.
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
        // The sign of the gradient, which the side of the cone decides, makes no difference to σ.
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

/// Returns the angle of a boresight from a direction, and its gradient by `ζ`:
/// `(1/sin θ) wᵀ R S(b)`.
fn angle_from(attitude: &Matrix3, boresight: &Vector3, direction: &Vector3) -> (f64, Vector3) {
    let seen = attitude.tr_mul(direction);
    let cross = boresight.cross(&seen);
    let (sin, cos) = (cross.norm(), boresight.dot(&seen));
    let angle = sin.atan2(cos);
    let gradient = if sin > 0.0 { hat(boresight).tr_mul(&seen) / sin } else { Vector3::zeros() };
    (angle, gradient)
}
