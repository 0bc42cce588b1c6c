//! Spec files: their meaning, refusals and their words, and the proof that no input breaks the
//! reader.

mod bad_inputs;
mod combinations;
mod differences;
mod exchange;
mod export;
mod made;
mod meaning;
mod mutations;
mod others;
mod outputs;
#[cfg(feature = "parquet")]
mod parquet;
mod random;
mod reading;
mod schema;
mod simulation;
mod sky;
mod tampered;
mod writer;

use slewkit_files::spec::{self, Diagnostics, Format, Loaded, Override, Spec};
use std::path::Path;

/// A turn under the momentum of a pitch wheel.
pub const BIASED: &str = "format = 1
[body]
inertia_kg_m2 = [120, 100, 80]
[[actuators.wheel]]
axis_body = [1, 0, 0]
torque_limit_n_m = 0.2
momentum_limit_n_m_s = 25
[[actuators.wheel]]
axis_body = [0, 1, 0]
torque_limit_n_m = 0.2
momentum_limit_n_m_s = 25
momentum_n_m_s = -20
[[actuators.wheel]]
axis_body = [0, 0, 1]
torque_limit_n_m = 0.2
momentum_limit_n_m_s = 25
[start]
attitude = { quaternion_wxyz = [1, 0, 0, 0] }
[end]
attitude = { axis = [0, 0, 1], angle_deg = 60 }
[maneuver]
duration_s = 200
";

/// A complete spec, to change in the tests.
pub const BASE: &str = r#"
format = 1
name = "base"
[body]
inertia_kg_m2 = [[2, 0.1, 0], [0.1, 3, 0], [0, 0, 4]]
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
angular_velocity_deg_s = [0, 0, 0]
[end]
attitude = { euler_zyx_deg = [80, -25, 40] }
angular_velocity_deg_s = [0, 0, 0]
[maneuver]
duration_s = 60
steps = 200
"#;

/// A complete spec that moves the body too.
pub const ORBIT: &str = r#"
format = 1
[body]
inertia_kg_m2 = [2, 3, 4]
mass_kg = 2
[start]
attitude = { quaternion_wxyz = [1, 0, 0, 0] }
position_m = [100, 0, 0]
velocity_m_s = [0, 0.1, 0]
[end]
rotation_from_start = { rotation_vector_rad = [0, 0, 7] }
angular_velocity_rad_s = [0, 0, 0.01]
position_m = [0, 100, 0]
velocity_m_s = [-0.1, 0, 0]
[environment]
kind = "central_gravity"
gravitational_parameter_m3_s2 = 1.0
body = "points"
points = [ { mass_kg = 1, position_m = [0.15, 0, 0] }, { mass_kg = 1, position_m = [-0.15, 0, 0] } ]
[actuators]
torque_axes_reference = [[1, 0, 0], [0, 2, 0]]
effort_weight = [[2, 0.5], [0.5, 1]]
force_axes_body = [[0, 0, 1]]
force_effort_weight = [3]
[maneuver]
duration_s = 60
step_s = 0.5
[solver]
method = "shooting"
search = "thorough"
scheme = "lie_euler"
tolerance = 1e-10
continuous_tolerance_deg = 0.5
time_limit_s = 2.5
max_iterations = 30
second_order = "skipped"
[expect]
source = "nowhere"
status = "solved"
cost = { value = 1.5, tolerance = 0.01 }
terminal_error = 1e-12
newton_iterations_at_most = 20
conjugate_points = 0
sense = "long"
rivals = [ { value = 71.4, tolerance = 0.1 } ]
"#;

/// A complete spec of bodies that are simulated.
pub const SIMULATION: &str = r#"
format = 1
[simulation]
integrator = "galerkin_gauss_2"
duration_s = 30
step_s = 0.05
output_stride = 4
tolerance = 1e-12
[gravity]
gravitational_constant_m3_kg_s2 = 1
potential = "shapes"
[[bodies]]
name = "dumbbell"
mass_kg = 2
shape = { kind = "dumbbell", length_m = 0.5, sphere_radius_m = 0.1 }
attitude = { axis = [0, 0, 1], angle_deg = 30 }
angular_velocity_rad_s = [0.1, -0.2, 0.3]
position_m = [2, 0, 0]
velocity_m_s = [0, 0.5, 0]
[[bodies]]
name = "tetrahedron"
attitude = { quaternion_wxyz = [1, 0, 0, 0] }
angular_momentum_body_n_m_s = [0, 0, 0.1]
position_m = [-1, 0, 0]
linear_momentum_n_s = [0, -1, 0]
[bodies.shape]
kind = "polyhedron"
density_kg_m3 = 3
vertices_m = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
faces = [[1, 2, 3], [1, 3, 4], [1, 4, 2], [2, 4, 3]]
gauss_order = 2
[expect]
source = "nowhere"
energy_error_at_most = 1e-3
orthogonality_at_most = 1e-12
[[expect.end]]
body = "dumbbell"
position_m = [0, 0, 0]
position_tolerance_m = 10
"#;

/// A complete spec under every kind of limit and constraint, in a frame that turns.
pub const CONSTRAINED: &str = r#"
format = 1
[body]
inertia_kg_m2 = [2, 3, 4]
[actuators]
torque_axes_body = [[1, 0, 0], [0, 0.8, 0.6]]
torque_limit_n_m = [0.5, 0.25]
torque_norm_limit_n_m = 0.6
torque_rate_limit_n_m_per_s = 0.1
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
angular_velocity_deg_s = [0, 0.3, 0]
[end]
attitude = { euler_zyx_deg = [80, -25, 40] }
angular_velocity_deg_s = [0, 0, 0]
[environment]
kind = "gravity_gradient"
orbital_rate_rad_s = 0.001
[maneuver]
duration_s = 60
steps = 200
[solver]
method = "scp"
[[constraint]]
kind = "keep_out"
name = "star tracker away from the Sun"
boresight_body = [0, 0, 3]
direction_inertial = { ra_deg = 231.0, dec_deg = -18.3 }
half_angle_deg = 35
margin_deg = 0.5
[[constraint]]
kind = "keep_in"
boresight_body = [[0, 0, 1], [0.6, 0, 0.8]]
direction_inertial = [ { vector = [0, 0, 2] }, { ra_deg = -90, dec_deg = 60 } ]
direction_reference = { vector = [1, 0, 1] }
half_angle_deg = 100
[[constraint]]
kind = "rate_limit"
angular_velocity_limit_deg_s = 4
[[constraint]]
kind = "rate_limit"
angular_velocity_limit_rad_s = [0.1, 0.2, 0.3]
[expect]
margin_at_least = -1e-9
active = ["torque limit", "rate limit 2"]
because = "shortest"
"#;

/// A complete spec with four reaction wheels.
pub const WHEELS: &str = r#"
format = 1
[body]
inertia_kg_m2 = [120, 100, 80]
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { euler_zyx_deg = [80, -25, 40] }
[maneuver]
duration_s = 60
[[actuators.wheel]]
name = "+x"
axis_body = [0.8, 0, 0.6]
torque_limit_n_m = 0.2
momentum_limit_n_m_s = 20
momentum_n_m_s = 20
[[actuators.wheel]]
axis_body = [0, 0.8, 0.6]
torque_limit_n_m = 0.3
effort_weight = 2
[[actuators.wheel]]
axis_body = [-0.8, 0, 0.6]
torque_limit_n_m = 0.2
momentum_n_m_s = -1.5
[[actuators.wheel]]
axis_body = [0, -0.8, 0.6]
torque_limit_n_m = 0.2
momentum_limit_n_m_s = 10
"#;

/// Reads TOML with overrides.
pub fn load_with(text: &str, set: &[&str]) -> Result<Loaded, Diagnostics> {
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).unwrap()).collect();
    spec::from_str(text, "test.toml", Format::Toml, &set)
}

/// Reads TOML of either kind with overrides.
pub fn load_any(text: &str, set: &[&str]) -> Result<Spec, Diagnostics> {
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).unwrap()).collect();
    spec::load_from_str(text, "test.toml", Path::new(""), Format::Toml, &set)
}

/// Reads TOML with overrides that must be good.
pub fn good(text: &str, set: &[&str]) -> Loaded {
    load_with(text, set).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Reads TOML with overrides that must be bad.
pub fn bad(text: &str, set: &[&str]) -> Diagnostics {
    load_with(text, set).expect_err("accepted")
}
