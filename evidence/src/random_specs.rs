//! Random maneuvers of every kind, as specs in TOML.
//!
//! A spec depends on its index alone. The kinds take turns, so any 26 in a row hold each once;
//! notations of attitudes, units, schemes, paths and grids are drawn anew for each. All are valid
//! specs of moderate size; a few have no solution, on purpose.

mod draft;
mod kinds;
mod turns;

use draft::Draft;
use kinds::*;

/// A maneuver as the planner reads it.
pub struct RandomSpec {
    /// The kind of the spec, as a file name.
    pub kind: &'static str,
    /// The spec in TOML.
    pub text: String,
}

/// A kind of maneuver, and the function that writes one.
type Kind = (&'static str, fn(&mut Draft));

/// The kinds, in turn.
const KINDS: [Kind; 26] = [
    ("rest_to_rest", |draft| draft.slew()),
    ("moving_ends", moving_ends),
    ("principal_axis", principal_axis),
    ("winding", winding),
    ("pendulum", pendulum),
    ("pendulum_reference_torques", pendulum_reference_torques),
    ("gravity_gradient", gravity_gradient),
    ("free_flyer", free_flyer),
    ("body_thrusters", body_thrusters),
    ("central_points", |draft| central_gravity(draft, true)),
    ("central_second_order", |draft| central_gravity(draft, false)),
    ("two_torques", two_torques),
    ("redundant_axes", redundant_axes),
    ("reference_torques", reference_torques),
    ("torque_limit", torque_limit),
    ("torque_norm_limit", torque_norm_limit),
    ("torque_rate_limit", torque_rate_limit),
    ("force_limits", force_limits),
    ("rate_limit", rate_limit),
    ("keep_out", keep_out),
    ("keep_in", keep_in),
    ("cones_in_orbit", cones_in_orbit),
    ("wheels", wheels),
    ("limited_pendulum", limited_pendulum),
    ("everything", everything),
    ("infeasible", infeasible),
];

/// Returns the spec of this index.
pub fn random_spec(index: u64) -> RandomSpec {
    let (kind, build) = KINDS[(index % KINDS.len() as u64) as usize];
    let mut draft = Draft::new(index);
    build(&mut draft);
    draft.solver();
    RandomSpec { kind, text: draft.text(kind, index) }
}

/// The kinds of maneuvers whose inputs switch, in turn.
const SWITCHING_KINDS: [Kind; 8] = [
    ("minimum_time", |draft| switching(draft, "time", Inputs::Axes)),
    ("minimum_time_redundant_axes", |draft| switching(draft, "time", Inputs::RedundantAxes)),
    ("minimum_time_norm", |draft| switching(draft, "time", Inputs::Norm)),
    ("minimum_fuel", |draft| switching(draft, "fuel", Inputs::Axes)),
    ("minimum_fuel_thrusters", |draft| switching(draft, "fuel", Inputs::Thrusters)),
    ("minimum_fuel_norm", |draft| switching(draft, "fuel", Inputs::Norm)),
    ("minimum_fuel_price_of_time", |draft| switching(draft, "fuel and time", Inputs::Axes)),
    ("minimum_time_thrusters", |draft| switching(draft, "time", Inputs::Thrusters)),
];

/// Returns the spec of minimum time or fuel with this index. It has its own stream, so that the
/// other stream does not change.
pub fn random_switching_spec(index: u64) -> RandomSpec {
    let (kind, build) = SWITCHING_KINDS[(index % SWITCHING_KINDS.len() as u64) as usize];
    let mut draft = Draft::new(index ^ 0x0051_71c4);
    build(&mut draft);
    RandomSpec { kind, text: draft.text(kind, index) }
}
