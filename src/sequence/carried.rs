//! The wheel momentum that a leg passes on to the next one.
//!
//! Without an external torque the angular momentum `H` of the whole craft is a constant inertial
//! vector. If the body has the attitude R and the rate Ω, the wheels hold the momentum `RᵀH − JΩ`:
//!
//! ```text
//! Σ a_i h_i = RᵀH − JΩ
//! ```
//!
//! More than three wheels can divide this momentum in many ways. Before the legs have plans, each
//! leg begins with the wheel momenta nearest to the initial momenta of the sequence. A leg that is
//! planned after another one begins with the final wheel momenta of that leg.

use crate::Vector3;
use crate::maneuver::problem::Problem;
use nalgebra::{DMatrix, DVector};

/// Returns the angular momentum of a craft at the start of a maneuver, inertial axes [N·m·s]. It is
/// zero for a craft without wheels, because thrusters and external torques change the momentum.
pub fn momentum(craft: &Problem) -> Vector3 {
    if craft.actuation.wheels.is_none() {
        return Vector3::zeros();
    }
    let start = &craft.start;
    start.attitude * (craft.body.inertia.j() * start.angular_velocity + craft.actuation.stored_momentum())
}

/// Sets the wheel momenta at the start of a leg so that the craft has the angular momentum `whole`.
/// They are the momenta nearest to `held`, or to the present ones if `held` is `None`.
pub fn carry(leg: &mut Problem, whole: &Vector3, held: Option<&[f64]>) {
    let start = leg.start;
    let own = start.attitude.tr_mul(whole) - leg.body.inertia.j() * start.angular_velocity;
    let axes = leg.actuation.torque.axes();
    let map = DMatrix::from_fn(3, axes.len(), |row, column| axes[column][row]);
    let Some(wheels) = &mut leg.actuation.wheels else { return };
    let before = held.filter(|held| held.len() == wheels.momentum.len()).unwrap_or(&wheels.momentum);
    let before = DVector::from_column_slice(before);
    let missing = DVector::from_column_slice(own.as_slice()) - &map * &before;
    // If the wheels cannot hold all of the momentum, the planner rejects the rest.
    let added = map.svd(true, true).solve(&missing, f64::EPSILON);
    if let Ok(added) = added {
        wheels.momentum = (before + added).as_slice().to_vec();
    }
}
