//! The keys of a simulation spec: bodies, shapes, what acts between them, the integrator.

use super::{
    ATTITUDE, ATTITUDE_KEY, ATTITUDE_SAMPLE, ENVIRONMENT, Kind, POINT, RATE_DEG_KEY, RATE_RAD_KEY, Table,
    key, q,
};

/// Most bodies; their pairs are summed one by one.
pub(crate) const MAX_BODIES: usize = 1_000;
/// Most points, vertices or faces of one body that stand in the spec itself.
pub(crate) const MAX_LISTED: usize = 20_000;
/// Most steps; a simulation streams.
pub(crate) const MAX_STEPS: i64 = 1_000_000_000;

/// The names of [`crate::propagate::integrator::Kind`], in its order.
pub(crate) const INTEGRATORS: &[&str] = &[
    "lie_euler",
    "lie_euler_adjoint",
    "lie_verlet",
    "lie_verlet_lagrangian",
    "galerkin_gauss_1",
    "galerkin_gauss_2",
    "galerkin_gauss_3",
    "galerkin_gauss_4",
    "galerkin_gauss_5",
    "galerkin_gauss_6",
    "galerkin_lobatto_1",
    "galerkin_lobatto_2",
    "galerkin_lobatto_3",
    "galerkin_lobatto_4",
    "galerkin_lobatto_5",
    "galerkin_lobatto_6",
    "explicit_midpoint",
    "implicit_midpoint",
    "crouch_grossman_2",
    "crouch_grossman_3",
    "rkmk4",
    "rkf78",
    "rkf78_adaptive",
    "dop853",
    "verner98",
];

/// A spec that is simulated, not planned.
pub(crate) static SIMULATION_ROOT: Table = Table::new(&[
    key("$schema", Kind::Text(2000), "Address of the JSON Schema, for editors; ignored."),
    key("format", Kind::Format, "Version of this format: 1.").needed("format = 1"),
    key("name", Kind::Text(200), "What is simulated, for people. Default: the file name."),
    key("description", Kind::Text(10_000), "Notes for people; ignored."),
    key("simulation", Kind::Table(&SIMULATION), "How the motion is propagated, and for how long.")
        .needed("[simulation]\nintegrator = \"lie_verlet\"\nduration_s = 60\nstep_s = 0.01"),
    key("bodies", Kind::List(&BODIES, MAX_BODIES), "The rigid bodies, each with its state at the start.")
        .needed(
            "[[bodies]]\ninertia_kg_m2 = [1, 2, 2.5]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\n\
         angular_velocity_rad_s = [0.01, 1, 0]",
        ),
    key(
        "gravity",
        Kind::Table(&GRAVITY),
        "The mutual gravity of the bodies. Default: they do not act on one another.",
    ),
    key("environment", Kind::Table(&ENVIRONMENT), "What acts on a single body. Default: nothing."),
    key(
        "expect",
        Kind::Table(&EXPECT),
        "What the motion must come to; read by the tests of a collection of problems.",
    ),
]);

static SIMULATION: Table = Table {
    keys: &[
        key("integrator", Kind::Choice(INTEGRATORS, &[]), "Which method. Default: lie_verlet."),
        key("duration_s", Kind::Number(q::DURATION), "Duration.").needed("duration_s = 60"),
        key("steps", Kind::LongSteps, "Number of steps, up to 1e9."),
        key("step_s", Kind::Number(q::DURATION), "Step, instead of steps."),
        key(
            "output_stride",
            Kind::Count(1, MAX_STEPS),
            "A row every so many steps; start and end always have one. Default: 1.",
        ),
        key(
            "tolerance",
            Kind::Number(q::STEP_TOLERANCE),
            "Error that an error control allows per step, relative to the size of each quantity; below 1e-14 there is only round-off. Default: 1e-13.",
        ),
    ],
    exclusive: &[&["steps", "step_s"]],
    one_of: &[(&["step_s", "steps"], "step_s = 0.01, or steps = 6000")],
    ..Table::new(&[])
};

const RATES: &[&str] = &["angular_velocity_deg_s", "angular_velocity_rad_s", "angular_momentum_body_n_m_s"];

static BODIES: Table = Table {
    keys: &[
        key("name", Kind::Text(100), "What reports call the body. Default: body and its number."),
        key(
            "mass_kg",
            Kind::Number(q::MASS),
            "Mass; needed where the body moves, unless its shape gives it.",
        ),
        key(
            "inertia_kg_m2",
            Kind::Inertia,
            "Inertia about the mass center (about the pivot under uniform_gravity), body axes, tensor signs: three rows, or a diagonal of three. Default: that of the shape.",
        ),
        key(
            "shape",
            Kind::Table(&SHAPE),
            "Shape: gives inertia, and how the body attracts. Without one it attracts to second order in its size.",
        ),
        ATTITUDE_KEY,
        RATE_DEG_KEY,
        RATE_RAD_KEY,
        key(
            "angular_momentum_body_n_m_s",
            Kind::Vector(q::MOMENTUM),
            "Angular momentum about the mass center, body axes; instead of angular velocity.",
        ),
        key(
            "position_m",
            Kind::Vector(q::POSITION),
            "Position of the mass center, reference frame. Needed under [gravity]; a single body that has none only turns.",
        ),
        key(
            "velocity_m_s",
            Kind::Vector(q::VELOCITY),
            "Velocity of the mass center, reference frame. Default: at rest.",
        ),
        key(
            "linear_momentum_n_s",
            Kind::Vector(q::MOMENTUM),
            "Linear momentum, reference frame; instead of velocity.",
        ),
    ],
    exclusive: &[RATES, &["velocity_m_s", "linear_momentum_n_s"]],
    one_of: &[(&["attitude"], ATTITUDE_SAMPLE)],
    ..Table::new(&[])
};

const SPHERE: &[&str] = &["sphere"];
const DUMBBELL: &[&str] = &["dumbbell"];
const POINTS: &[&str] = &["points"];
const CUBOID: &[&str] = &["cuboid"];
const OCTAHEDRON: &[&str] = &["octahedron"];
const POLYHEDRON: &[&str] = &["polyhedron"];
const SOLIDS: &[&str] = &["cuboid", "octahedron", "polyhedron"];

static SHAPE: Table = Table {
    keys: &[
        key("kind", Kind::Choice(&["sphere", "dumbbell", "points", "cuboid", "octahedron", "polyhedron"], &[]), "Which shape.")
            .needed("kind = \"dumbbell\""),
        key("radius_m", Kind::Number(q::SIZE), "Radius.").needed("radius_m = 0.1").only(SPHERE),
        key("length_m", Kind::Number(q::SIZE), "Distance of the centers of two equal spheres on the first body axis.")
            .needed("length_m = 0.5")
            .only(DUMBBELL),
        key("sphere_radius_m", Kind::Number(q::SIZE), "Radius of each of the two spheres; counts for the inertia alone.")
            .needed("sphere_radius_m = 0.1")
            .only(DUMBBELL),
        key("points", Kind::List(&POINT, MAX_LISTED), "Point masses, body axes; the origin moves to their mass center.")
            .needed("points = [ { mass_kg = 0.5, position_m = [0.15, 0, 0] }, { mass_kg = 0.5, position_m = [-0.15, 0, 0] } ]")
            .only(POINTS),
        key("edges_m", Kind::Vector(q::SIZE), "Edges along the body axes.").needed("edges_m = [1, 2, 3]").only(CUBOID),
        key("semi_axes_m", Kind::Vector(q::SIZE), "Distances of the corners from the center, along the body axes.")
            .needed("semi_axes_m = [1, 2, 3]")
            .only(OCTAHEDRON),
        key("vertices_m", Kind::Vertices(q::POSITION), "Vertices; the origin moves to the mass center.").only(POLYHEDRON),
        key("faces", Kind::Faces, "Triangles of three vertices, counted from 1, counterclockwise seen from outside; with vertices_m.")
            .only(POLYHEDRON),
        key("obj", Kind::Text(1000), "A Wavefront OBJ file, relative to the folder of the spec; instead of vertices_m and faces.")
            .only(POLYHEDRON),
        key("obj_unit_m", Kind::Number(q::SIZE), "Length of one unit of the OBJ file. Default: 1.").only(POLYHEDRON),
        key("density_kg_m3", Kind::Number(q::DENSITY), "Density; instead of mass_kg of the body.")
            .only(&["sphere", "cuboid", "octahedron", "polyhedron"]),
        key("gauss_order", Kind::Count(1, 8), "Between two solids: order³ Gauss points for each face of the smaller one. Default: 3.")
            .only(SOLIDS),
    ],
    selector: Some("kind"),
    exclusive: &[&["vertices_m", "obj"], &["faces", "obj"]],
    one_of: &[(&["obj", "vertices_m"], "obj = \"shape.obj\"; or vertices_m and faces")],
};

static GRAVITY: Table = Table::new(&[
    key(
        "gravitational_constant_m3_kg_s2",
        Kind::Number(q::GRAVITATIONAL_CONSTANT),
        "Constant of gravitation. Default: 6.6743e-11, CODATA.",
    ),
    key(
        "potential",
        Kind::Choice(&["shapes", "second_order"], &[]),
        "How the bodies attract: as their shapes do, or all to second order in their size. Default: shapes.",
    ),
]);

static EXPECT: Table = Table::new(&[
    key("source", Kind::Text(2000), "Where the numbers come from."),
    key("energy_j", Kind::Table(&TOLERANCED), "Energy at the start."),
    key(
        "energy_error_at_most",
        Kind::Number(q::COST),
        "Bound on the error of the energy, relative to the energy at the start.",
    ),
    key(
        "angular_momentum_error_at_most",
        Kind::Number(q::COST),
        "Bound on the change of the total angular momentum, relative to the one at the start.",
    ),
    key(
        "linear_momentum_error_at_most",
        Kind::Number(q::COST),
        "Bound on the change of the total linear momentum, relative to the sum of the sizes of all at the start.",
    ),
    key("orthogonality_at_most", Kind::Number(q::COST), "Bound on ‖I − RᵀR‖ of every body."),
    key("end", Kind::List(&EXPECT_END, MAX_BODIES), "State of bodies at the end."),
    key("precession", Kind::Table(&PRECESSION), "Mean rate of a body axis about a direction."),
    key("oscillation", Kind::Table(&OSCILLATION), "Mean period of a body axis that swings."),
]);

static TOLERANCED: Table = Table::new(&[
    key("value", Kind::Number(q::SIGNED), "Expected value.").needed("value = -1.5"),
    key("tolerance", Kind::Number(q::COST), "Largest accepted difference.").needed("tolerance = 0.005"),
]);

const BODY_NAME: super::Key =
    key("body", Kind::Text(100), "Name of the body; needed where there are several.");

static EXPECT_END: Table = Table {
    keys: &[
        BODY_NAME,
        key("attitude", Kind::Table(&ATTITUDE), "Attitude, in one of the notations."),
        key("attitude_tolerance_rad", Kind::Number(q::COST), "Largest accepted angle from it."),
        key("angular_velocity_rad_s", Kind::Vector(q::RATE_RAD), "Angular velocity, body axes."),
        key("angular_velocity_tolerance_rad_s", Kind::Number(q::COST), "Largest accepted distance from it."),
        key("position_m", Kind::Vector(q::POSITION), "Position, reference frame."),
        key("position_tolerance_m", Kind::Number(q::COST), "Largest accepted distance from it."),
        key("velocity_m_s", Kind::Vector(q::VELOCITY), "Velocity, reference frame."),
        key("velocity_tolerance_m_s", Kind::Number(q::COST), "Largest accepted distance from it."),
    ],
    ..Table::new(&[])
};

static PRECESSION: Table = Table::new(&[
    BODY_NAME,
    key("axis_body", Kind::Vector(q::COMPONENT), "The axis, body axes.").needed("axis_body = [0, 0, 1]"),
    key("about_reference", Kind::Vector(q::COMPONENT), "What it turns about, reference frame.")
        .needed("about_reference = [0, 0, 1]"),
    key("rate_rad_s", Kind::Table(&TOLERANCED), "Mean rate over the whole motion.")
        .needed("rate_rad_s = { value = 0.5, tolerance = 1e-3 }"),
]);

static OSCILLATION: Table = Table::new(&[
    BODY_NAME,
    key("axis_body", Kind::Vector(q::COMPONENT), "The axis, body axes.").needed("axis_body = [1, 0, 0]"),
    key(
        "direction_reference",
        Kind::Vector(q::COMPONENT),
        "What its component along is observed of, reference frame; the period is that of the upward passages through zero.",
    )
    .needed("direction_reference = [0, 0, 1]"),
    key("period_s", Kind::Table(&TOLERANCED), "Mean period over the whole motion.")
        .needed("period_s = { value = 60, tolerance = 1e-3 }"),
]);

#[cfg(test)]
mod tests {
    #[test]
    fn every_integrator_can_be_named() {
        let names: Vec<_> =
            crate::propagate::integrator::Kind::all().map(crate::propagate::integrator::Kind::name).collect();
        assert_eq!(super::INTEGRATORS, names);
    }
}
