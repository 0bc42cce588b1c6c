//! Random maneuvers of every kind, as specs in TOML.
//!
//! A spec depends only on its index. The kinds alternate, so that any 26 consecutive specs contain
//! each kind once. Notations of attitudes, units, schemes, paths and grids are drawn anew for each
//! spec. All specs are valid and of moderate size. A few of them deliberately have no solution.

mod draft;
mod kinds;
mod turns;

use draft::Draft;
use kinds::*;

/// A random spec of a maneuver.
pub struct RandomSpec {
    /// The kind of the spec, in a form that can be a file name.
    pub kind: &'static str,
    /// The spec in TOML.
    pub text: String,
}

/// A kind of maneuver: its name, and the function that writes a spec.
type Kind = (&'static str, fn(&mut Draft));

/// The kinds of maneuvers, in the order in which they alternate.
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

/// The kinds of minimum-time and minimum-fuel maneuvers, in the order in which they alternate.
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

/// Returns the spec of the minimum-time or minimum-fuel maneuver with this index. It has its own
/// stream of random numbers, so that the specs of [`random_spec`] do not change.
pub fn random_switching_spec(index: u64) -> RandomSpec {
    let (kind, build) = SWITCHING_KINDS[(index % SWITCHING_KINDS.len() as u64) as usize];
    let mut draft = Draft::new(index ^ 0x0051_71c4);
    build(&mut draft);
    RandomSpec { kind, text: draft.text(kind, index) }
}
