//! What the wheels carry from leg to leg.
//!
//! Without an outside torque the angular momentum `H` of the whole craft is one inertial vector. A
//! body with attitude R and rate Ω leaves `RᵀH − JΩ` of it to its wheels:
//!
//! ```text
//! Σ a_i h_i = RᵀH − JΩ
//! ```
//!
//! More than three wheels may share that in many ways. Before the legs have plans, the nearest
//! momenta to those at the start count; a leg that is planned after another begins with those that
//! the other leaves.

use crate::Vector3;
use crate::maneuver::problem::Problem;
use nalgebra::{DMatrix, DVector};

/// Returns the angular momentum of a craft at the start of a maneuver, inertial axes [N·m·s]; zero
/// without wheels, since thrusters and torques from outside change it.
pub fn momentum(craft: &Problem) -> Vector3 {
    if craft.actuation.wheels.is_none() {
        return Vector3::zeros();
    }
    let start = &craft.start;
    start.attitude * (craft.body.inertia.j() * start.angular_velocity + craft.actuation.stored_momentum())
}

/// Gives the wheels of a leg the momenta nearest to `held`, or to those they have, with which the
/// craft has the angular momentum `whole` at the start of the leg.
pub fn carry(leg: &mut Problem, whole: &Vector3, held: Option<&[f64]>) {
    let start = leg.start;
    let own = start.attitude.tr_mul(whole) - leg.body.inertia.j() * start.angular_velocity;
    let axes = leg.actuation.torque.axes();
    let map = DMatrix::from_fn(3, axes.len(), |row, column| axes[column][row]);
    let Some(wheels) = &mut leg.actuation.wheels else { return };
    let before = held.filter(|held| held.len() == wheels.momentum.len()).unwrap_or(&wheels.momentum);
    let before = DVector::from_column_slice(before);
    let missing = DVector::from_column_slice(own.as_slice()) - &map * &before;
    // Wheels that cannot hold it all leave a part that the planner refuses.
    let added = map.svd(true, true).solve(&missing, f64::EPSILON);
    if let Ok(added) = added {
        wheels.momentum = (before + added).as_slice().to_vec();
    }
}
