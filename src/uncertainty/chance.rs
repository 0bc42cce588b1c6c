//! The chance that a boresight enters a cone, or leaves one, at a node of a plan.
//!
//! ```text
//! θ_k = angle(R_k b, w) − α ,    σ_k² = gᵀ P_ζζ g ,    g = (1/sin θ) wᵀ R_k S(b) ,    chance Φ(−θ_k/σ_k)
//! ```
//!
//! Errors of neighbouring nodes are one error, so the chance of the worst node is near that of the whole plan; their sum is
//! not.

use super::Covariance;
use crate::lie::hat;
use crate::maneuver::Problem;
use crate::maneuver::constraint::{Pointing, Rule, Side};
use crate::optimize::linear_plan::LinearPlan;
use crate::{Matrix3, Vector3};
use statrs::distribution::{ContinuousCDF, Normal};

/// The chance of violating a constraint.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Chance {
    /// Name of the constraint.
    pub name: String,
    /// Chance at each node.
    pub nodes: Vec<f64>,
    /// The node of the largest.
    pub worst: usize,
    /// Standard deviation of the angle from the cone there \[rad\].
    pub sigma: f64,
    /// How far the plan is from the cone there \[rad\].
    pub room: f64,
}

/// `Φ(x)` of the standard normal distribution.
pub fn normal_cdf(x: f64) -> f64 {
    Normal::standard().cdf(x)
}

/// `Φ⁻¹(p)`.
pub fn normal_quantile(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

impl Chance {
    /// Of every cone of a maneuver, beside the cone without its margin.
    pub fn of_cones(problem: &Problem, plan: &LinearPlan, covariance: &Covariance) -> Vec<Self> {
        let cone = |constraint: &crate::maneuver::constraint::Constraint| match &constraint.rule {
            // A boresight that is held on a cone is off it with certainty.
            Rule::Pointing(Pointing { side: Side::On { .. }, .. }) => None,
            Rule::Pointing(pointing) => Some(Self::of(&constraint.name, pointing, problem, plan, covariance)),
            Rule::RateNorm(_) | Rule::RateAxes(_) => None,
        };
        problem.constraints.iter().filter_map(cone).collect()
    }

    /// Of one cone.
    pub fn of(
        name: &str,
        cone: &Pointing,
        problem: &Problem,
        plan: &LinearPlan,
        covariance: &Covariance,
    ) -> Self {
        let frame_rate = problem.environment.frame_rate();
        let mut out =
            Self { name: name.into(), nodes: Vec::new(), worst: 0, sigma: 0.0, room: f64::INFINITY };
        for (node, state) in covariance.states.iter().enumerate() {
            let attitude = plan.node(node).0;
            let time = plan.times()[node];
            let of_attitude: Matrix3 = state.fixed_view::<3, 3>(0, 0).into_owned();
            let mut worst = (-1.0, 0.0, f64::INFINITY);
            if !cone.during.contains(time) {
                out.nodes.push(0.0);
                continue;
            }
            for (boresight, direction) in cone.pairs() {
                let seen = direction.at(time, &frame_rate);
                let (angle, gradient) = angle_from(attitude, boresight, &seen);
                let without = Pointing { margin: 0.0, ..cone.clone() };
                let room = without.room_beside(angle, direction.angular_radius(time));
                let gradient = if cone.side == Side::KeepOut { gradient } else { -gradient };
                let sigma = gradient.dot(&(of_attitude * gradient)).max(0.0).sqrt();
                let chance =
                    if sigma > 0.0 { normal_cdf(-room / sigma) } else { f64::from(u8::from(room < 0.0)) };
                if chance > worst.0 || chance == worst.0 && room < worst.2 || chance.is_nan() {
                    worst = (chance, sigma, room);
                }
            }
            let (chance, sigma, room) = worst;
            let before = out.nodes.get(out.worst).copied();
            if before.is_none_or(|before| chance > before || chance == before && room < out.room) {
                (out.worst, out.sigma, out.room) = (node, sigma, room);
            }
            out.nodes.push(chance);
        }
        out
    }

    /// The largest of the nodes.
    pub fn largest(&self) -> f64 {
        self.nodes.get(self.worst).copied().unwrap_or(0.0)
    }
}

/// Angle of a boresight from a direction, and its gradient by `ζ`: `(1/sin θ) wᵀ R S(b)`.
fn angle_from(attitude: &Matrix3, boresight: &Vector3, direction: &Vector3) -> (f64, Vector3) {
    let seen = attitude.tr_mul(direction);
    let cross = boresight.cross(&seen);
    let (sin, cos) = (cross.norm(), boresight.dot(&seen));
    let angle = sin.atan2(cos);
    let gradient = if sin > 0.0 { hat(boresight).tr_mul(&seen) / sin } else { Vector3::zeros() };
    (angle, gradient)
}
