//! Every key of a spec, once: the reader, the messages and the JSON Schema all work from these tables.

mod simulation;

pub(crate) use simulation::{MAX_LISTED, MAX_STEPS, SIMULATION_ROOT};

use super::quantity::{self as q, Quantity};

/// What a key holds.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// The version of the format, 1.
    Format,
    /// Text on one line, at most this many characters.
    Text(usize),
    /// One of the first words; the second are known, but this version cannot do them.
    Choice(&'static [&'static str], &'static [&'static str]),
    /// A number.
    Number(Quantity),
    /// The number of steps of a plan.
    Steps,
    /// The number of steps of a simulation.
    LongSteps,
    /// A count, from … to ….
    Count(i64, i64),
    /// Three numbers (x, y, z).
    Vector(Quantity),
    /// Four numbers.
    Quaternion,
    /// Three rows of three numbers.
    Matrix,
    /// Three rows of three numbers, or a diagonal of three.
    Inertia,
    /// A list of axes, each three numbers.
    Axes,
    /// One number per input, or as many rows of as many numbers.
    Weight,
    /// A table.
    Table(&'static Table),
    /// A list of tables, at most this many.
    List(&'static Table, usize),
    /// A positive number; without the key there is no limit.
    Limit(Quantity),
    /// One limit for all, or a list: as many as there are inputs, or this many.
    Limits(Quantity, Option<usize>),
    /// Three numbers, or a list of such vectors.
    Vectors(Quantity),
    /// A direction in space, or a list of them.
    Directions,
    /// A heavenly body, whose direction this version cannot know.
    HeavenlyBody,
    /// A list of texts, at most this many.
    Texts(usize),
    /// A list of points, each three numbers.
    Vertices(Quantity),
    /// A list of triangles, each three whole numbers from 1.
    Faces,
    /// Known, but this version cannot do it; the text says what it will be.
    Later(&'static str),
}

impl Kind {
    /// The keys of the table, or of each table of the list, that it holds.
    pub fn table(self) -> Option<&'static Table> {
        match self {
            Self::Table(table) | Self::List(table, _) => Some(table),
            Self::Directions => Some(&DIRECTION),
            _ => None,
        }
    }
}

/// One key.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    pub name: &'static str,
    pub kind: Kind,
    /// What it means, in one line.
    pub doc: &'static str,
    /// Required; the text is what a spec might say.
    pub sample: Option<&'static str>,
    /// Only for these values of the table's selector; empty: always.
    pub only: &'static [&'static str],
}

/// The keys of one table.
#[derive(Debug)]
pub(crate) struct Table {
    pub keys: &'static [Key],
    /// The key whose value decides which others apply.
    pub selector: Option<&'static str>,
    /// Groups of keys of which at most one may be given.
    pub exclusive: &'static [&'static [&'static str]],
    /// Groups of keys of which one must be given, with a sample.
    pub one_of: &'static [(&'static [&'static str], &'static str)],
}

impl Table {
    const fn new(keys: &'static [Key]) -> Self {
        Self { keys, selector: None, exclusive: &[], one_of: &[] }
    }

    /// The key of this name.
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }
}

const fn key(name: &'static str, kind: Kind, doc: &'static str) -> Key {
    Key { name, kind, doc, sample: None, only: &[] }
}

impl Key {
    const fn needed(mut self, sample: &'static str) -> Self {
        self.sample = Some(sample);
        self
    }

    const fn only(mut self, kinds: &'static [&'static str]) -> Self {
        self.only = kinds;
        self
    }
}

pub(crate) const MAX_POINTS: usize = 100;
pub(crate) const MAX_WHEELS: usize = crate::mechanics::actuators::ActuatorSet::MAX_INPUTS;
const POINTING: &[&str] = &["keep_out", "keep_in"];
const RATE_LIMIT: &[&str] = &["rate_limit"];
const UNIFORM: &[&str] = &["uniform_gravity"];
const GRADIENT: &[&str] = &["gravity_gradient"];
const CENTRAL: &[&str] = &["central_gravity"];

pub(crate) static ROOT: Table = Table::new(&[
    key("$schema", Kind::Text(2000), "Address of the JSON Schema, for editors; ignored."),
    key("format", Kind::Format, "Version of this format: 1.").needed("format = 1"),
    key("name", Kind::Text(200), "What is planned, for people. Default: the file name."),
    key("description", Kind::Text(10_000), "Notes for people; ignored."),
    key("body", Kind::Table(&BODY), "The rigid body.")
        .needed("[body]\ninertia_kg_m2 = [2, 3, 4]   # or three rows: the whole matrix"),
    key(
        "actuators",
        Kind::Table(&ACTUATORS),
        "Input axes and effort weights. Default: three torques along the body axes; three forces along the reference axes too when positions are given.",
    ),
    key("start", Kind::Table(&START), "State at the beginning.").needed(
        "[start]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\nangular_velocity_deg_s = [0, 0, 0]",
    ),
    key("end", Kind::Table(&END), "State at the end.")
        .needed("[end]\nattitude = { euler_zyx_deg = [90, 0, 0] }\nangular_velocity_deg_s = [0, 0, 0]"),
    key("maneuver", Kind::Table(&MANEUVER), "What is minimised, in what time, on which grid.")
        .needed("[maneuver]\nduration_s = 60"),
    key("solver", Kind::Table(&SOLVER), "How it is solved. Default: automatic."),
    key("environment", Kind::Table(&ENVIRONMENT), "What acts on the body. Default: nothing."),
    key(
        "expect",
        Kind::Table(&EXPECT),
        "What the plan must come to; read by the tests of a collection of problems.",
    ),
    key(
        "constraint",
        Kind::List(&CONSTRAINT, crate::maneuver::problem::Problem::MAX_CONSTRAINTS),
        "Where the body may point and how fast it may turn, all the way. Default: anywhere, any rate.",
    ),
    key(
        "rounding",
        Kind::Choice(&["remove", "keep"], &[]),
        "What becomes of the rounded last digits of matrices and unit vectors. remove: they become rotations, and of length 1. keep: each number is taken to its last bit, as in a spec that slew wrote. Default: remove.",
    ),
]);

static BODY: Table = Table::new(&[
    key("inertia_kg_m2", Kind::Inertia, "Inertia about the mass center (about the pivot under uniform_gravity), body axes, tensor signs: three rows, or a diagonal of three.")
        .needed("inertia_kg_m2 = [2, 3, 4]"),
    key("mass_kg", Kind::Number(q::MASS), "Mass; needed when positions are given, and nowhere else."),
]);

static ACTUATORS: Table = Table {
    keys: &[
        key(
            "torque_axes_body",
            Kind::Axes,
            "Torque axes fixed in the body, a list of axes, the columns of B. Two: underactuated; four: redundant. Default: three unit axes.",
        ),
        key(
            "torque_axes_reference",
            Kind::Axes,
            "Torque axes fixed in the reference frame: the torque is Rᵀ B u.",
        ),
        key(
            "effort_weight",
            Kind::Weight,
            "Weight W of the torque inputs in ½uᵀWu: one number per axis, or a full symmetric positive definite matrix. Default: 1 each.",
        ),
        key(
            "force_axes_reference",
            Kind::Axes,
            "Force axes fixed in the reference frame; an empty list: no forces. Default: three unit axes when positions are given.",
        ),
        key("force_axes_body", Kind::Axes, "Force axes fixed in the body: the force is R B u."),
        key(
            "force_effort_weight",
            Kind::Weight,
            "Weight of the force inputs, like effort_weight. Default: 1 each.",
        ),
        key(
            "torque_limit_n_m",
            Kind::Limits(q::TORQUE, None),
            "Limit of the size of each torque input: one for all, or one per axis. Default: none.",
        ),
        key(
            "torque_norm_limit_n_m",
            Kind::Limit(q::TORQUE_NORM),
            "Limit of the norm of the whole torque. Default: none.",
        ),
        key(
            "torque_rate_limit_n_m_per_s",
            Kind::Limits(q::TORQUE_RATE, None),
            "Limit of how fast each torque input changes: one for all, or one per axis. Default: none.",
        ),
        key(
            "force_limit_n",
            Kind::Limits(q::FORCE, None),
            "Limit of the size of each force input: one for all, or one per axis. Default: none.",
        ),
        key(
            "force_norm_limit_n",
            Kind::Limit(q::FORCE_NORM),
            "Limit of the norm of the whole force. Default: none.",
        ),
        key(
            "force_rate_limit_n_per_s",
            Kind::Limits(q::FORCE_RATE, None),
            "Limit of how fast each force input changes: one for all, or one per axis. Default: none.",
        ),
        key(
            "wheel",
            Kind::List(&WHEEL, MAX_WHEELS),
            "Reaction wheels, instead of torque axes; each input is the torque of one wheel on the body.",
        ),
    ],
    exclusive: &[
        &["torque_axes_body", "torque_axes_reference"],
        &["force_axes_reference", "force_axes_body"],
    ],
    ..Table::new(&[])
};

static WHEEL: Table = Table::new(&[
    key("name", Kind::Text(100), "What messages call the wheel. Default: its number."),
    key("axis_body", Kind::Vector(q::COMPONENT), "Spin axis, body axes, of length 1.")
        .needed("axis_body = [1, 0, 0]"),
    key(
        "torque_limit_n_m",
        Kind::Limit(q::TORQUE),
        "Limit of the size of its torque; for every wheel or for none. Default: none.",
    ),
    key(
        "momentum_limit_n_m_s",
        Kind::Limit(q::WHEEL_LIMIT),
        "Limit of the size of its momentum about its axis. Default: none.",
    ),
    key(
        "momentum_n_m_s",
        Kind::Number(q::WHEEL_MOMENTUM),
        "Its momentum about its axis at the start; free at the end. Default: 0.",
    ),
    key("effort_weight", Kind::Number(q::WHEEL_WEIGHT), "Weight of its torque in ½uᵀWu. Default: 1."),
]);

static CONSTRAINT: Table = Table {
    keys: &[
        key("kind", Kind::Choice(&["keep_out", "keep_in", "rate_limit"], &[]), "What it asks: boresights outside or inside of cones, or a limit of the angular velocity.")
            .needed("kind = \"keep_out\""),
        key("name", Kind::Text(100), "What reports call it. Default: its kind."),
        key("boresight_body", Kind::Vectors(q::COMPONENT), "One boresight or several, body axes, any length.")
            .needed("boresight_body = [0, 0, 1]")
            .only(POINTING),
        key("direction_inertial", Kind::Directions, "What the cone is about, fixed in inertial space: one direction or several, in the axes of the reference frame at the start.")
            .only(POINTING),
        key("direction_reference", Kind::Directions, "The same, fixed to a reference frame that turns.")
            .only(POINTING),
        key("half_angle_deg", Kind::Number(q::ANGLE_DEG), "Half angle of the cone, between 0 and 180.")
            .only(POINTING),
        key("half_angle_rad", Kind::Number(q::ANGLE_RAD), "The same in rad, between 0 and π.").only(POINTING),
        key("margin_deg", Kind::Number(q::MARGIN_DEG), "Margin: added to the half angle of a keep-out cone, taken from that of a keep-in cone. Default: 0.")
            .only(POINTING),
        key("margin_rad", Kind::Number(q::MARGIN_RAD), "The same in rad.").only(POINTING),
        key("angular_velocity_limit_deg_s", Kind::Limits(q::RATE_LIMIT_DEG, Some(3)), "Limit of the inertial angular velocity: one number for its norm, or three for its components in body axes.")
            .only(RATE_LIMIT),
        key("angular_velocity_limit_rad_s", Kind::Limits(q::RATE_LIMIT_RAD, Some(3)), "The same in rad/s.")
            .only(RATE_LIMIT),
    ],
    selector: Some("kind"),
    exclusive: &[RATE_LIMITS, HALF_ANGLES, &["margin_deg", "margin_rad"]],
    one_of: &[
        (HALF_ANGLES, "half_angle_deg = 35"),
        (&["direction_inertial", "direction_reference"], "direction_inertial = { ra_deg = 231.0, dec_deg = -18.3 }"),
        (RATE_LIMITS, "angular_velocity_limit_deg_s = 4"),
    ],
};
const HALF_ANGLES: &[&str] = &["half_angle_deg", "half_angle_rad"];
const RATE_LIMITS: &[&str] = &["angular_velocity_limit_deg_s", "angular_velocity_limit_rad_s"];

/// A direction: right ascension and declination, or a vector.
pub(crate) static DIRECTION: Table = Table::new(&[
    key("ra_deg", Kind::Number(q::ANGLE_DEG), "Right ascension: from the x axis towards y; with dec_deg."),
    key("dec_deg", Kind::Number(q::ANGLE_DEG), "Declination: from the x-y plane towards z; with ra_deg."),
    key("vector", Kind::Vector(q::COMPONENT), "A vector of any length."),
    key("body", Kind::HeavenlyBody, ""),
]);

const ATTITUDE_KEY: Key = key(
    "attitude",
    Kind::Table(&ATTITUDE),
    "Attitude R, body vectors to reference-frame vectors, in one of the notations.",
);
const RATE_DEG_KEY: Key = key(
    "angular_velocity_deg_s",
    Kind::Vector(q::RATE_DEG),
    "Inertial angular velocity in body axes. Default: at rest (needed under gravity_gradient).",
);
const RATE_RAD_KEY: Key = key(
    "angular_velocity_rad_s",
    Kind::Vector(q::RATE_RAD),
    "Inertial angular velocity in body axes. Default: at rest (needed under gravity_gradient).",
);
const POSITION_KEY: Key = key(
    "position_m",
    Kind::Vector(q::POSITION),
    "Position of the mass center, reference frame. Given in [start] and [end], the maneuver moves the body too.",
);
const VELOCITY_KEY: Key =
    key("velocity_m_s", Kind::Vector(q::VELOCITY), "Velocity of the mass center, reference frame.");
const LATER_FILE: Key = key("attitude_file", Kind::Later("attitudes read from files"), "");
const RATES: &[&str] = &["angular_velocity_deg_s", "angular_velocity_rad_s"];
const ATTITUDE_SAMPLE: &str = "attitude = { axis = [0, 0, 1], angle_deg = 90 }";

static START: Table = Table {
    keys: &[ATTITUDE_KEY, RATE_DEG_KEY, RATE_RAD_KEY, POSITION_KEY, VELOCITY_KEY, LATER_FILE],
    exclusive: &[&["attitude", "attitude_file"], RATES],
    one_of: &[(&["attitude", "attitude_file"], ATTITUDE_SAMPLE)],
    ..Table::new(&[])
};

static END: Table = Table {
    keys: &[
        ATTITUDE_KEY,
        key(
            "rotation_from_start",
            Kind::Table(&ATTITUDE),
            "Instead of attitude: the rotation from the start, in its body axes, any angle; end = start · rotation. Taken as written unless `path` says otherwise.",
        ),
        key(
            "rotation_from_start_rad",
            Kind::Vector(q::ANGLE_RAD),
            "Beside attitude: which rotation from the start leads there, a rotation vector in its body axes, any angle. Taken as written unless `path` says otherwise.",
        ),
        RATE_DEG_KEY,
        RATE_RAD_KEY,
        POSITION_KEY,
        VELOCITY_KEY,
        LATER_FILE,
    ],
    exclusive: &[
        &["attitude", "rotation_from_start", "attitude_file"],
        &["rotation_from_start", "rotation_from_start_rad"],
        RATES,
    ],
    one_of: &[(&["attitude", "rotation_from_start", "attitude_file"], ATTITUDE_SAMPLE)],
    ..Table::new(&[])
};

static MANEUVER: Table = Table {
    keys: &[
        key(
            "minimize",
            Kind::Choice(&["effort"], &["time", "fuel"]),
            "What is minimised: effort, the integral of ½uᵀWu. Default: effort.",
        ),
        key("duration_s", Kind::Number(q::DURATION), "Duration.").needed("duration_s = 60"),
        key(
            "steps",
            Kind::Steps,
            "Number of steps. Default: the smallest from 100 on with at most 0.3 rad a step.",
        ),
        key("step_s", Kind::Number(q::DURATION), "Step, instead of steps."),
        key(
            "path",
            Kind::Choice(&["best", "shortest", "long", "as_given"], &[]),
            "Which way round. Default: best; as_given with rotation_from_start.",
        ),
        key("duration_max_s", Kind::Later("minimum time"), ""),
    ],
    exclusive: &[&["steps", "step_s"]],
    ..Table::new(&[])
};

static SOLVER: Table = Table {
    keys: &[
        key(
            "method",
            Kind::Choice(&["auto", "shooting", "scp"], &[]),
            "Which solver: shooting on the costates, or sequential convex programming. Default: auto, which takes the second where something is constrained.",
        ),
        key(
            "scheme",
            Kind::Choice(&["lie_verlet", "lie_euler"], &[]),
            "Discretisation: lie_verlet (second order) or lie_euler (first order). Default: lie_verlet.",
        ),
        key(
            "tolerance",
            Kind::Number(q::TOLERANCE),
            "Tolerance of the scaled discrete terminal error. Default: 1e-12.",
        ),
        key(
            "continuous_tolerance_deg",
            Kind::Number(q::TOLERANCE_DEG),
            "Limit on the continuous terminal attitude error. Default: none.",
        ),
        key("continuous_tolerance_rad", Kind::Number(q::TOLERANCE_RAD), "The same in rad."),
        key(
            "time_limit_s",
            Kind::Number(q::DURATION),
            "Limit on the wall-clock time of the plan. Default: none.",
        ),
        key(
            "max_iterations",
            Kind::Count(1, 1_000_000),
            "Iteration limit of one Newton run, and of the subproblems of one convex run. Default: 60.",
        ),
    ],
    exclusive: &[&["continuous_tolerance_deg", "continuous_tolerance_rad"]],
    ..Table::new(&[])
};

static ENVIRONMENT: Table = Table {
    keys: &[
        key("kind", Kind::Choice(&["uniform_gravity", "gravity_gradient", "central_gravity"], &[]), "Which environment.")
            .needed("kind = \"gravity_gradient\""),
        key("mass_kg", Kind::Number(q::MASS), "Mass of the body on its pivot.").needed("mass_kg = 1").only(UNIFORM),
        key("gravity_m_s2", Kind::Number(q::GRAVITY), "Acceleration of gravity.")
            .needed("gravity_m_s2 = 9.81")
            .only(UNIFORM),
        key("direction", Kind::Vector(q::COMPONENT), "Direction of gravity, reference frame; any length.")
            .needed("direction = [0, 0, 1]")
            .only(UNIFORM),
        key("pivot_to_mass_center_m", Kind::Vector(q::LENGTH), "From the pivot to the mass center, body axes.")
            .needed("pivot_to_mass_center_m = [0, 0, 0.3]")
            .only(UNIFORM),
        key("orbital_rate_rad_s", Kind::Number(q::ORBITAL_RATE), "Orbital rate. Attitudes are then relative to LVLH: e1 along the velocity, e2 the orbit normal, e3 radially outward.")
            .needed("orbital_rate_rad_s = 0.00116")
            .only(GRADIENT),
        key("gravitational_parameter_m3_s2", Kind::Number(q::GRAVITATIONAL_PARAMETER), "Gravitational parameter of the point mass at the origin.")
            .needed("gravitational_parameter_m3_s2 = 3.986e14")
            .only(CENTRAL),
        key("body", Kind::Choice(&["points", "second_order"], &[]), "How the body is attracted: as mass points, or to second order in its size.")
            .needed("body = \"second_order\"")
            .only(CENTRAL),
        key("points", Kind::List(&POINT, MAX_POINTS), "The mass points, if body = \"points\". Their masses sum to body.mass_kg.").only(CENTRAL),
    ],
    selector: Some("kind"),
    ..Table::new(&[])
};

static POINT: Table = Table::new(&[
    key("mass_kg", Kind::Number(q::MASS), "Mass of the point.").needed("mass_kg = 0.5"),
    key("position_m", Kind::Vector(q::LENGTH), "Place of the point, body axes, from the mass center.")
        .needed("position_m = [0.15, 0, 0]"),
]);

static EXPECT: Table = Table::new(&[
    key("source", Kind::Text(2000), "Where the numbers come from."),
    key(
        "status",
        Kind::Choice(&["solved", "infeasible", "not_converged", "limit_reached", "verification_failed"], &[]),
        "Status of the plan. Default: solved.",
    ),
    key("cost", Kind::Table(&TOLERANCED), "The cost."),
    key(
        "terminal_error",
        Kind::Number(q::COST),
        "Bound on the larger of terminal.attitude_rad and terminal.momentum_relative.",
    ),
    key(
        "newton_iterations_at_most",
        Kind::Count(1, 1_000_000),
        "Bound on the iterations of the winning start, all its rungs.",
    ),
    key("conjugate_points", Kind::Count(0, 1_000_000), "Conjugate points of the plan."),
    key("sense", Kind::Choice(&["short", "long"], &[]), "Rotation sense of the plan."),
    key(
        "margin_at_least",
        Kind::Number(q::MARGIN),
        "Bound on the smallest margin of all limits and constraints, relative to the limit or in rad.",
    ),
    key("active", Kind::Texts(100), "Names of exactly those limits and constraints that act."),
    key("because", Kind::Text(200), "Part of the reason why nothing can meet the terminal conditions."),
    key("rivals", Kind::List(&TOLERANCED, 100), "Costs of other extremals that must be found."),
]);

static TOLERANCED: Table = Table::new(&[
    key("value", Kind::Number(q::COST), "Expected value.").needed("value = 23.35"),
    key("tolerance", Kind::Number(q::COST), "Largest accepted difference.").needed("tolerance = 0.005"),
]);

const TURN_DEG: Kind = Kind::Vector(q::ANGLE_DEG);
const TURN_RAD: Kind = Kind::Vector(q::ANGLE_RAD);

macro_rules! attitude_keys {
    ($($sequence:literal)*) => {
        &[
            key("axis", Kind::Vector(q::COMPONENT), "Axis of rotation, any length; with angle_deg or angle_rad."),
            key("angle_deg", Kind::Number(q::ANGLE_DEG), "Angle about axis."),
            key("angle_rad", Kind::Number(q::ANGLE_RAD), "Angle about axis."),
            key("rotation_vector_rad", TURN_RAD, "Axis times angle."),
            key("rotation_vector_deg", TURN_DEG, "Axis times angle."),
            key("matrix", Kind::Matrix, "Rotation matrix, three rows."),
            key("quaternion_wxyz", Kind::Quaternion, "Unit quaternion, scalar first, Hamilton, body to reference."),
            key("quaternion_xyzw", Kind::Quaternion, "Unit quaternion, scalar last, Hamilton, body to reference."),
            $(
                key(concat!("euler_", $sequence, "_deg"), TURN_DEG, concat!("Intrinsic Euler angles about ", $sequence, ", in that order.")),
                key(concat!("euler_", $sequence, "_rad"), TURN_RAD, concat!("Intrinsic Euler angles about ", $sequence, ", in that order.")),
            )*
        ]
    };
}

/// The notations of an attitude. Exactly one is given; `axis` goes with one of the two angles.
pub(crate) static ATTITUDE: Table =
    Table::new(attitude_keys!("xyz" "xzy" "yxz" "yzx" "zxy" "zyx" "xyx" "xzx" "yxy" "yzy" "zxz" "zyz"));
