//! Keys of a simulation: bodies, shapes, their gravity, the integrator.

use super::*;
use slewkit::propagate::integrator;

/// Largest number of bodies; the forces between all pairs are summed directly.
pub(crate) const MAX_BODIES: usize = 1_000;
/// Largest number of points, vertices or faces of a body that the spec lists itself.
pub(crate) const MAX_LISTED: usize = 20_000;
/// Largest number of steps of a simulation, whose rows are written as a stream.
pub(crate) const MAX_STEPS: i64 = 1_000_000_000;

tables! {
    /// A spec of a simulation.
    pub(crate) static SIMULATION_ROOT {
        /// Address of the JSON Schema, for editors; ignored.
        "$schema": Text(2000);
        /// Version of this format: 1.
        "format": Format, needed "format = 1";
        /// The name of the simulation, for people. Default: the file name.
        "name": Text(200);
        /// Notes for people; ignored.
        "description": Text(10_000);
        /// The integrator and the duration.
        "simulation": Table(&SIMULATION),
            needed "[simulation]\nintegrator = \"lie_verlet\"\nduration_s = 60\nstep_s = 0.01";
        /// The rigid bodies, each with its state at the start.
        "bodies": List(&BODIES, MAX_BODIES),
            needed "[[bodies]]\ninertia_kg_m2 = [1, 2, 2.5]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\n\
                    angular_velocity_rad_s = [0.01, 1, 0]";
        /// The mutual gravity of the bodies. Default: none.
        "gravity": Table(&GRAVITY);
        /// The forces and moments on a single body. Default: none.
        "environment": Table(&ENVIRONMENT);
        /// The required result of the motion; the tests of a collection of problems read it.
        "expect": Table(&EXPECT);
    }

    static SIMULATION[
        exclusive: &[&["steps", "step_s"]],
        one_of: &[(&["step_s", "steps"], "step_s = 0.01, or steps = 6000")],
    ] {
        /// The integrator. Default: lie_verlet.
        "integrator": Choice(&integrator::Kind::NAMES, &[]);
        /// Duration.
        "duration_s": Number(q::DURATION), needed "duration_s = 60";
        /// Number of steps, up to 1e9.
        "steps": Steps(StepsOf::Simulation);
        /// Step, instead of steps.
        "step_s": Number(q::DURATION);
        /// Number of steps from one row of the output to the next; start and end always have a row.
        /// Default: 1.
        "output_stride": Count(1, MAX_STEPS);
        /// The error that an integrator with error control accepts in each step, relative to the
        /// size of each quantity; at least 1e-14, the limit of round-off. Default: 1e-13.
        "tolerance": Number(q::STEP_TOLERANCE);
    }
}

const RATES: &[&str] = &["angular_velocity_deg_s", "angular_velocity_rad_s", "angular_momentum_body_n_m_s"];

tables! {
    static BODIES[
        exclusive: &[RATES, &["velocity_m_s", "linear_momentum_n_s"]],
        one_of: &[(&["attitude"], ATTITUDE_SAMPLE)],
    ] {
        /// The name of the body in reports. Default: body and its number.
        "name": Text(100);
        /// Mass; required if the body moves, unless its shape gives it.
        "mass_kg": Number(q::MASS);
        /// Inertia about the mass center (about the pivot under uniform_gravity), body axes, with
        /// Jxy = -∫xy dm: three rows, or a diagonal of three. Default: the inertia of the shape.
        "inertia_kg_m2": Inertia;
        /// Shape: it gives the inertia and the gravity of the body. The attraction of a body
        /// without a shape is computed to second order in its size.
        "shape": Table(&SHAPE);
        ATTITUDE_KEY;
        RATE_DEG_KEY;
        RATE_RAD_KEY;
        /// Angular momentum about the mass center, body axes; instead of angular velocity.
        "angular_momentum_body_n_m_s": Vector(q::MOMENTUM);
        /// Position of the mass center, reference frame. Required under [gravity]; a single body
        /// without a position only turns.
        "position_m": Vector(q::POSITION);
        /// Velocity of the mass center, reference frame. Default: at rest.
        "velocity_m_s": Vector(q::VELOCITY);
        /// Linear momentum, reference frame; instead of velocity.
        "linear_momentum_n_s": Vector(q::MOMENTUM);
    }
}

const SPHERE: &[&str] = &["sphere"];
const DUMBBELL: &[&str] = &["dumbbell"];
const POINTS: &[&str] = &["points"];
const CUBOID: &[&str] = &["cuboid"];
const OCTAHEDRON: &[&str] = &["octahedron"];
const POLYHEDRON: &[&str] = &["polyhedron"];
const SOLIDS: &[&str] = &["cuboid", "octahedron", "polyhedron"];

tables! {
    static SHAPE[
        selector: Some("kind"),
        exclusive: &[&["vertices_m", "obj"], &["faces", "obj"]],
        one_of: &[(&["obj", "vertices_m"], "obj = \"shape.obj\"; or vertices_m and faces")],
    ] {
        /// The kind of shape.
        "kind": Choice(&["sphere", "dumbbell", "points", "cuboid", "octahedron", "polyhedron"], &[]),
            needed "kind = \"dumbbell\"";
        /// Radius.
        "radius_m": Number(q::SIZE), only SPHERE, needed "radius_m = 0.1";
        /// Distance of the centers of two equal spheres on the first body axis.
        "length_m": Number(q::SIZE), only DUMBBELL, needed "length_m = 0.5";
        /// Radius of each of the two spheres; it affects only the inertia.
        "sphere_radius_m": Number(q::SIZE), only DUMBBELL, needed "sphere_radius_m = 0.1";
        /// Point masses, body axes; the origin moves to their mass center.
        "points": List(&POINT, MAX_LISTED), only POINTS,
            needed "points = [ { mass_kg = 0.5, position_m = [0.15, 0, 0] }, \
                    { mass_kg = 0.5, position_m = [-0.15, 0, 0] } ]";
        /// Edges along the body axes.
        "edges_m": Vector(q::SIZE), only CUBOID, needed "edges_m = [1, 2, 3]";
        /// Distances of the corners from the center, along the body axes.
        "semi_axes_m": Vector(q::SIZE), only OCTAHEDRON, needed "semi_axes_m = [1, 2, 3]";
        /// Vertices; the origin moves to the mass center.
        "vertices_m": Vertices(q::POSITION), only POLYHEDRON;
        /// Triangles of three vertices, counted from 1, counterclockwise seen from outside; with
        /// vertices_m.
        "faces": Faces, only POLYHEDRON;
        /// A Wavefront OBJ file, relative to the folder of the spec; instead of vertices_m and
        /// faces.
        "obj": Text(1000), only POLYHEDRON;
        /// Length of one unit of the OBJ file. Default: 1.
        "obj_unit_m": Number(q::SIZE), only POLYHEDRON;
        /// Density; instead of mass_kg of the body.
        "density_kg_m3": Number(q::DENSITY), only &["sphere", "cuboid", "octahedron", "polyhedron"];
        /// Between two solids: order³ Gauss points for each face of the smaller one. Default: 3.
        "gauss_order": Count(1, 8), only SOLIDS;
    }

    static GRAVITY {
        /// Constant of gravitation. Default: 6.6743e-11, CODATA.
        "gravitational_constant_m3_kg_s2": Number(q::GRAVITATIONAL_CONSTANT);
        /// The kind of attraction: by the shapes, or to second order in the size of all bodies.
        /// Default: shapes.
        "potential": Choice(&["shapes", "second_order"], &[]);
    }

    static EXPECT {
        /// The source of the numbers.
        "source": Text(2000);
        /// Energy at the start.
        "energy_j": Table(&TOLERANCED);
        /// Bound on the error of the energy, relative to the energy at the start.
        "energy_error_at_most": Number(q::COST);
        /// Bound on the change of the total angular momentum, relative to its initial value.
        "angular_momentum_error_at_most": Number(q::COST);
        /// Bound on the change of the total linear momentum, relative to the sum of the magnitudes
        /// of the momenta of all bodies at the start.
        "linear_momentum_error_at_most": Number(q::COST);
        /// Bound on ‖I − RᵀR‖ of every body.
        "orthogonality_at_most": Number(q::COST);
        /// State of bodies at the end.
        "end": List(&EXPECT_END, MAX_BODIES);
        /// Mean rate of a body axis about a direction.
        "precession": Table(&PRECESSION);
        /// Mean period of a body axis that swings.
        "oscillation": Table(&OSCILLATION);
    }

    static TOLERANCED {
        /// Expected value.
        "value": Number(q::SIGNED), needed "value = -1.5";
        /// Largest accepted difference.
        "tolerance": Number(q::COST), needed "tolerance = 0.005";
    }
}

shared_keys! {
    /// Name of the body; required for several bodies.
    BODY_NAME = "body": Text(100);
}

tables! {
    static EXPECT_END {
        BODY_NAME;
        /// Attitude, in one of the notations.
        "attitude": Table(&ATTITUDE);
        /// Largest accepted angle from this attitude.
        "attitude_tolerance_rad": Number(q::COST);
        /// Angular velocity, body axes.
        "angular_velocity_rad_s": Vector(q::RATE_RAD);
        /// Largest accepted distance from it.
        "angular_velocity_tolerance_rad_s": Number(q::COST);
        /// Position, reference frame.
        "position_m": Vector(q::POSITION);
        /// Largest accepted distance from it.
        "position_tolerance_m": Number(q::COST);
        /// Velocity, reference frame.
        "velocity_m_s": Vector(q::VELOCITY);
        /// Largest accepted distance from it.
        "velocity_tolerance_m_s": Number(q::COST);
    }

    static PRECESSION {
        BODY_NAME;
        /// The axis, body axes.
        "axis_body": Vector(q::COMPONENT), needed "axis_body = [0, 0, 1]";
        /// The axis of its rotation, reference frame.
        "about_reference": Vector(q::COMPONENT), needed "about_reference = [0, 0, 1]";
        /// Mean rate over the whole motion.
        "rate_rad_s": Table(&TOLERANCED), needed "rate_rad_s = { value = 0.5, tolerance = 1e-3 }";
    }

    static OSCILLATION {
        BODY_NAME;
        /// The axis, body axes.
        "axis_body": Vector(q::COMPONENT), needed "axis_body = [1, 0, 0]";
        /// The direction whose component along the axis is observed, reference frame; the period is
        /// the time between upward passages through zero.
        "direction_reference": Vector(q::COMPONENT), needed "direction_reference = [0, 0, 1]";
        /// Mean period over the whole motion.
        "period_s": Table(&TOLERANCED), needed "period_s = { value = 60, tolerance = 1e-3 }";
    }
}
