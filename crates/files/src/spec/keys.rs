//! Tables of all keys of a spec. The reader, the messages and the JSON Schema are all driven by
//! these tables.

use super::quantity::{self as q, Quantity};
use Kind::*;
use slewkit::maneuver::Problem;
use slewkit::mechanics::ActuatorSet;

/// Kind of the value of a key.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// Version of the format, which is 1.
    Format,
    /// A text on one line, of at most this many characters.
    Text(usize),
    /// A word of the first list; words of the second list are known but not supported.
    Choice(&'static [&'static str], &'static [&'static str]),
    /// A number.
    Number(Quantity),
    /// A common nonnegative number for all items, or a list with one for each item.
    Spread(Quantity),
    /// A square matrix, given as rows or by its diagonal.
    Square(Quantity),
    /// A number of steps.
    Steps(StepsOf),
    /// An integer between these two bounds, both included.
    Count(i64, i64),
    /// A vector, given as three numbers (x, y, z).
    Vector(Quantity),
    /// A quaternion, given as four numbers.
    Quaternion,
    /// A 3 × 3 matrix, given as three rows.
    Matrix,
    /// An inertia, given as three rows of three numbers or by its diagonal.
    Inertia,
    /// A list of axes, each given as three numbers.
    Axes,
    /// A weight matrix of the inputs, given as rows or by its diagonal.
    Weight,
    /// A table.
    Table(&'static Table),
    /// A list of tables, of at most this many elements.
    List(&'static Table, usize),
    /// A positive number; without the key no limit applies.
    Limit(Quantity),
    /// A common limit for all inputs, or a list of limits. The list has one element for each input,
    /// or as many as stated.
    Limits(Quantity, Option<usize>),
    /// A vector, or a list of vectors.
    Vectors(Quantity),
    /// A direction in inertial space, or a list of directions.
    Directions,
    /// A target: a word, a table, or a list of words and tables.
    Targets,
    /// A celestial body in place of a direction, which is reported as an error.
    HeavenlyBody,
    /// A list of texts, of at most this many elements.
    Texts(usize),
    /// A list of vertices, each given as three numbers.
    Vertices(Quantity),
    /// A list of triangles, each given as three vertex numbers, counted from 1.
    Faces,
    /// A list of time intervals \[s\] in increasing order.
    Intervals,
    /// A time interval \[s\].
    Interval,
    /// A boolean.
    Flag,
}

/// The kind of run to which a number of steps belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StepsOf {
    /// A plan, whose nodes are held in memory.
    Plan,
    /// A simulation, whose rows are written as a stream.
    Simulation,
}

impl StepsOf {
    /// Returns the smallest number of steps that is allowed.
    pub fn least(self) -> u64 {
        match self {
            Self::Plan => Problem::MIN_STEPS as u64,
            Self::Simulation => 1,
        }
    }

    /// Returns the largest number of steps that is allowed.
    pub fn most(self) -> u64 {
        match self {
            Self::Plan => Problem::MAX_STEPS as u64,
            Self::Simulation => MAX_STEPS as u64,
        }
    }
}

impl Kind {
    /// Returns the table of the keys, if the value is a table or a list of tables.
    pub fn table(self) -> Option<&'static Table> {
        match self {
            Self::Table(table) | Self::List(table, _) => Some(table),
            Self::Directions => Some(&DIRECTION),
            Self::Targets => Some(&TARGET),
            _ => None,
        }
    }
}

/// A key of a spec: its name, kind and description.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    pub name: &'static str,
    pub kind: Kind,
    /// Description of the key in one line.
    pub doc: &'static str,
    /// Sample value for messages if the key is required; `None` if it is optional.
    pub sample: Option<&'static str>,
    /// Words of the table's selector with which the key has an effect; empty if it always has an
    /// effect.
    pub only: &'static [&'static str],
}

/// Keys of a table of the spec, with the rules on their combinations.
#[derive(Debug)]
pub(crate) struct Table {
    pub keys: &'static [Key],
    /// Name of the key whose word decides which other keys have an effect.
    pub selector: Option<&'static str>,
    /// Groups of keys that exclude each other.
    pub exclusive: &'static [&'static [&'static str]],
    /// Groups of keys of which at least one is required, with a sample for messages.
    pub one_of: &'static [(&'static [&'static str], &'static str)],
}

impl Table {
    const EMPTY: Self = Self { keys: &[], selector: None, exclusive: &[], one_of: &[] };

    /// Returns the key with this name; `None` if the table does not have it.
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }
}

/// Builds a key from its description, name and [`Kind`]. `only` lists the words of the selector
/// with which the key has an effect; `needed` makes the key required and gives its sample.
macro_rules! key {
    ([] $shared:ident) => { $shared };
    ([$($doc:literal)*] $name:expr; $kind:expr $(, only $only:expr)? $(, needed $sample:expr)?) => {
        Key {
            name: $name,
            kind: $kind,
            doc: concat!($($doc),*).trim_ascii_start(),
            $(sample: Some($sample),)?
            $(only: $only,)?
            ..Key { name: "", kind: Kind::Format, doc: "", sample: None, only: &[] }
        }
    };
}

/// Defines keys that several tables share.
macro_rules! shared_keys {
    ($($(#[doc = $doc:literal])* $key:ident = $name:literal: $kind:expr;)*) => {
        $(const $key: Key = key!([$($doc)*] $name; $kind);)*
    };
}

/// Defines tables, each with its properties in brackets. A key is written as a name with its
/// [`Kind`], or as a shared key. The comment of a key becomes its description in the schema.
macro_rules! tables {
    ($(
        $(#[doc = $about:literal])*
        $visibility:vis static $table:ident $([$($field:ident: $value:expr),* $(,)?])? {
            $(
                $(#[doc = $doc:literal])*
                $($shared:ident)?
                $($name:literal $(+ $part:literal)*: $kind:expr $(, only $only:expr)? $(, needed $sample:expr)?)?;
            )*
        }
    )*) => {
        $(
            $(#[doc = $about])*
            #[allow(clippy::needless_update)]
            $visibility static $table: Table = Table {
                keys: &[$(
                    key!(
                        [$($doc)*] $($shared)?
                        $(concat!($name $(, $part)*); $kind $(, only $only)? $(, needed $sample)?)?
                    ),
                )*],
                $($($field: $value,)*)?
                ..Table::EMPTY
            };
        )*
    };
}

mod closed_loop;
mod dispersion;
mod simulation;

use closed_loop::{FEEDBACK, PLANT, UNCERTAINTY};
pub(crate) use dispersion::{DISPERSION, MOST_CASES, SPREADS};
pub(crate) use simulation::{MAX_LISTED, MAX_STEPS, SIMULATION_ROOT};

pub(crate) const MAX_POINTS: usize = 100;
/// Largest number of stops; if their order is free, all pairs of stops are planned.
pub(crate) const MAX_STOPS: usize = 200;
pub(crate) const MAX_WHEELS: usize = ActuatorSet::MAX_INPUTS;
const POINTING: &[&str] = &["keep_out", "keep_in", "on_cone"];
const BESIDE_CONE: &[&str] = &["keep_out", "keep_in"];
const WITH_CHANCE: &[&str] = &["keep_out", "keep_in", "rate_limit"];
const ON_CONE: &[&str] = &["on_cone"];
const RATE_LIMIT: &[&str] = &["rate_limit"];
const UNIFORM: &[&str] = &["uniform_gravity"];
const GRADIENT: &[&str] = &["gravity_gradient"];
const CENTRAL: &[&str] = &["central_gravity"];

tables! {
    pub(crate) static ROOT[
        one_of: &[(
            &["end", "stop"],
            "[end]\nattitude = { euler_zyx_deg = [90, 0, 0] }\nangular_velocity_deg_s = [0, 0, 0]",
        )],
    ] {
        /// Address of the JSON Schema, for editors; ignored.
        "$schema": Text(2000);
        /// Version of this format: 1.
        "format": Format, needed "format = 1";
        /// The name of the maneuver or simulation, for people. Default: the file name.
        "name": Text(200);
        /// Notes for people; ignored.
        "description": Text(10_000);
        /// The moment of time zero, with its time scale (UTC, TAI, TT, TDB, GPS), as in
        /// "2026-11-21T07:00:00 UTC". Files for other programs need it; plans do not depend on it.
        "epoch": Text(100);
        /// Light-time correction. one_way: stations, the Moon and satellites are seen where they
        /// were when their light left them. Default: none.
        "light_time": Choice(&["none", "one_way"], &[]);
        /// Stellar aberration. satellite: targets that give light, including stars given by ra_deg,
        /// are seen as from the moving satellite. Default: none.
        "aberration": Choice(&["none", "satellite"], &[]);
        /// The names of the object, its frames and its inputs in files for other programs.
        "names": Table(&NAMES);
        /// The rigid body.
        "body": Table(&BODY), needed "[body]\ninertia_kg_m2 = [2, 3, 4]   # or three rows: the whole matrix";
        /// Input axes and effort weights. Default: three torques along the body axes; three forces
        /// along the reference axes too when positions are given.
        "actuators": Table(&ACTUATORS);
        /// State at the beginning.
        "start": Table(&START),
            needed "[start]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\nangular_velocity_deg_s = [0, 0, 0]";
        /// State at the end; with stops the last of them, which stays last.
        "end": Table(&END);
        /// The stops of a sequence, which one plan visits in this order, or in the best order with
        /// maneuver.order = "free".
        "stop": List(&STOP, MAX_STOPS);
        /// The objective, the duration and the grid.
        "maneuver": Table(&MANEUVER), needed "[maneuver]\nduration_s = 60";
        /// The settings of the solver. Default: automatic.
        "solver": Table(&SOLVER);
        /// The forces and moments on the body that its actuators do not produce. Default: none.
        "environment": Table(&ENVIRONMENT);
        /// The required result of the plan; the tests of a collection of problems read it.
        "expect": Table(&EXPECT);
        /// Pointing constraints and limits on the rate, for the whole maneuver. Default: none.
        "constraint": List(&CONSTRAINT, Problem::MAX_CONSTRAINTS);
        /// Alternative sets of cones: at every time, all cones of at least one set are satisfied.
        "any_of": List(&ANY_OF, 10);
        /// The orbit, if ends or cones aim at targets that depend on it. The axes of the reference
        /// frame are then the axes of the GCRS (ICRF).
        "orbit": Table(&ORBIT);
        /// The surroundings of the spacecraft, for pictures and summaries: plan files write it if
        /// the spec has [orbit] and targets.
        "scenery": Table(&SCENERY);
        /// The uncertain numbers, for `slew monte-carlo`; other commands use the nominal values.
        "dispersion": Table(&DISPERSION);
        /// Gains that keep the craft on the plan.
        "feedback": Table(&FEEDBACK);
        /// The uncertainty of the craft that flies the plan, for covariances along it and for
        /// `slew fly`.
        "uncertainty": Table(&UNCERTAINTY);
        /// The response of the actuators when the plan is flown, for `slew fly`.
        "plant": Table(&PLANT);
        /// The treatment of the rounded last digits of matrices and unit vectors. remove: matrices
        /// become exact rotations, and unit vectors get exactly unit length. keep: each number is
        /// used to its last bit, as in a spec that slew wrote. Default: remove.
        "rounding": Choice(&["remove", "keep"], &[]);
    }

    static NAMES {
        /// The object that turns. Default: the name of the spec.
        "object": Text(64);
        /// Its international designator, as in "1995-074A". Default: UNKNOWN.
        "object_id": Text(64);
        /// The central body, as in "EARTH". Default: none.
        "center": Text(64);
        /// The reference frame, to which attitudes map. Default: ICRF; required if the frame
        /// turns.
        "reference_frame": Text(64);
        /// The body frame, from which attitudes map. Default: SC_BODY_1.
        "body_frame": Text(64);
        /// The issuer of the files. Default: UNKNOWN.
        "originator": Text(64);
        /// NAIF ID of the spacecraft, negative, for SPICE kernels.
        "spice_id": Number(q::SPICE_ID);
        /// The names of the inputs in headings of tables, one for each. Default: the names of the
        /// wheels, else numbers.
        "inputs": Texts(100);
    }

    static BODY {
        /// Inertia about the mass center (about the pivot under uniform_gravity), body axes, with
        /// Jxy = -∫xy dm: three rows, or a diagonal of three. It includes the mass of wheels, and
        /// excludes their moments about their own axes.
        "inertia_kg_m2": Inertia, needed "inertia_kg_m2 = [2, 3, 4]";
        /// Mass; required with positions, and only then.
        "mass_kg": Number(q::MASS);
    }

    static ACTUATORS[
        exclusive: &[&["torque_axes_body", "torque_axes_reference"], &["force_axes_reference", "force_axes_body"]],
    ] {
        /// Torque axes fixed in the body, a list of axes, the columns of B. Two: underactuated;
        /// four: redundant. Default: three unit axes.
        "torque_axes_body": Axes;
        /// Torque axes fixed in the reference frame: the torque is Rᵀ B u.
        "torque_axes_reference": Axes;
        /// Weight W of the torque inputs in ½uᵀWu: one number for each axis, or a full symmetric
        /// positive definite matrix. Default: 1 each.
        "effort_weight": Weight;
        /// Force axes fixed in the reference frame; an empty list: no forces. Default: three unit
        /// axes when positions are given.
        "force_axes_reference": Axes;
        /// Force axes fixed in the body: the force is R B u.
        "force_axes_body": Axes;
        /// Weight of the force inputs, like effort_weight. Default: 1 each.
        "force_effort_weight": Weight;
        /// Limit on the size of each torque input: one number for all, or one for each axis.
        /// Default: none.
        "torque_limit_n_m": Limits(q::TORQUE, None);
        /// The accepted probability, for each input, that its command with the corrections of
        /// [feedback] exceeds its limit at the worst instant. The plan keeps the necessary reserve.
        /// For wheels it applies to their torque limits. Below 0.5.
        "torque_limit_chance": Number(q::CHANCE);
        /// Margin kept below the limit for corrections: one number for all, or one for each input.
        /// If the chance requires a larger margin, that margin applies. Default: 0.
        "torque_limit_reserve_n_m": Spread(q::SPREAD);
        /// Limit on the norm of the total torque. Default: none.
        "torque_norm_limit_n_m": Limit(q::TORQUE_NORM);
        /// The accepted probability that the norm of the torque exceeds its limit at the worst
        /// instant.
        "torque_norm_limit_chance": Number(q::CHANCE);
        /// Margin kept below the limit on the norm. Default: 0.
        "torque_norm_limit_reserve_n_m": Spread(q::SPREAD);
        /// Limit on the rate of change of each torque input, also of the torques of wheels: one
        /// number for all, or one for each axis. Default: none.
        "torque_rate_limit_n_m_per_s": Limits(q::TORQUE_RATE, None);
        /// The accepted probability that the change of a held command from one step to the next
        /// exceeds the limit for one step.
        "torque_rate_limit_chance": Number(q::CHANCE);
        /// Margin kept below the rate limit: one number for all, or one for each input. Default: 0.
        "torque_rate_limit_reserve_n_m_per_s": Spread(q::SPREAD);
        /// The time to which the chances of limits refer, as for constraints: the worst instant, or
        /// the whole motion. Default: instant.
        "chance_over": Choice(&["instant", "motion"], &[]);
        /// Limit on the size of each force input: one number for all, or one for each axis.
        /// Default: none.
        "force_limit_n": Limits(q::FORCE, None);
        /// Limit on the norm of the total force. Default: none.
        "force_norm_limit_n": Limit(q::FORCE_NORM);
        /// Limit on the rate of change of each force input: one number for all, or one for each
        /// axis. Default: none.
        "force_rate_limit_n_per_s": Limits(q::FORCE_RATE, None);
        /// Shortest pulse: each torque input is off or at its limit, and each pulse has at least
        /// this length. For minimum fuel with a given duration. Default: inputs take any value
        /// within their limits.
        "shortest_pulse_s": Number(q::DURATION);
        /// The cost per second of a N·m of each torque input, if fuel is the objective: one number
        /// for all, or one for each axis; with torque_norm_limit_n_m the cost of a N·m of the total
        /// torque. Default: 1.
        "fuel_price": Limits(q::PRICE, None);
        /// The cost per second of a newton of each force input, if fuel is the objective: one
        /// number for all, or one for each axis; with force_norm_limit_n the cost of a newton of
        /// the total force. Default: 1.
        "force_fuel_price": Limits(q::PRICE, None);
        /// Reaction wheels, instead of torque axes; each input is the torque of one wheel on the
        /// body.
        "wheel": List(&WHEEL, MAX_WHEELS);
        /// Thrusters, instead of torque axes; each input is the torque of one thruster, never
        /// negative, or, where [start] and [end] have positions, its force, which pushes and turns
        /// the body. For minimum time and fuel.
        "thruster": List(&THRUSTER, MAX_WHEELS);
    }

    static THRUSTER {
        /// The name of the thruster in messages. Default: its number.
        "name": Text(100);
        /// Its position from the mass center, body axes.
        "position_m": Vector(q::LENGTH);
        /// The direction of its force on the body, body axes, any length.
        "force_direction_body": Vector(q::COMPONENT);
        /// Its largest force.
        "force_limit_n": Limit(q::FORCE);
        /// Instead of position, direction and force, if the body does not translate: the axis of
        /// its torque, body axes, any length.
        "torque_axis_body": Vector(q::COMPONENT);
        /// Its largest torque.
        "torque_limit_n_m": Limit(q::TORQUE);
        /// The cost per second of a newton of its force, or of a N·m if the torque is given.
        /// Default: 1.
        "fuel_price": Number(q::PRICE);
    }

    static WHEEL {
        /// The name of the wheel in messages. Default: its number.
        "name": Text(100);
        /// Spin axis, body axes, of length 1.
        "axis_body": Vector(q::COMPONENT), needed "axis_body = [1, 0, 0]";
        /// Limit on the size of its torque; for every wheel or for no wheel. Default: none.
        "torque_limit_n_m": Limit(q::TORQUE);
        /// Limit on the size of its momentum about its axis. Default: none.
        "momentum_limit_n_m_s": Limit(q::WHEEL_LIMIT);
        /// Its inertial momentum about its axis at the start: axial moment times (speed in the
        /// body plus axis · angular velocity); free at the end. Default: 0.
        "momentum_n_m_s": Number(q::WHEEL_MOMENTUM);
        /// Weight of its torque in ½uᵀWu. Default: 1.
        "effort_weight": Number(q::WHEEL_WEIGHT);
    }

    static ANY_OF {
        /// The name in reports. Default: its number.
        "name": Text(100);
        /// The sets, at least two.
        "set": List(&SET, 10), needed "set = [{ constraints = [\"A\"] }, { constraints = [\"B\"] }]";
    }

    static SET {
        /// Names of the cones of this set, which are satisfied together. A cone belongs to one set
        /// only.
        "constraints": Texts(1000), needed "constraints = [\"tracker A off the Sun\"]";
    }

    static CONSTRAINT[
        selector: Some("kind"),
        exclusive: &[
            RATE_LIMITS,
            HALF_ANGLES,
            &["margin_deg", "margin_rad"],
            &["margin_deg_s", "margin_rad_s"],
            &["within_deg", "within_rad"],
            &["while", "during_s"],
        ],
        one_of: &[
            (HALF_ANGLES, "half_angle_deg = 35"),
            (DIRECTIONS, "direction_inertial = { ra_deg = 231.0, dec_deg = -18.3 }"),
            (RATE_LIMITS, "angular_velocity_limit_deg_s = 4"),
        ],
    ] {
        /// The kind of condition: boresights outside or inside of cones, or held on them, or a
        /// limit on the angular velocity.
        "kind": Choice(&["keep_out", "keep_in", "on_cone", "rate_limit"], &[]), needed "kind = \"keep_out\"";
        /// The name in reports. Default: its kind.
        "name": Text(100);
        /// One boresight or several, body axes, any length.
        "boresight_body": Vectors(q::COMPONENT), only POINTING, needed "boresight_body = [0, 0, 1]";
        /// The name of the boresight in reports and pictures; several are numbered. Default: its
        /// direction.
        "boresight_name": Text(100), only POINTING;
        /// The axis of the cone, fixed in inertial space: one direction or several, in the axes
        /// of the reference frame at the start.
        "direction_inertial": Directions, only POINTING;
        /// The axis of the cone, fixed in a reference frame that turns: one direction or several.
        "direction_reference": Directions, only POINTING;
        /// The axis of the cone as a named target, which may move: "sun", { at = "ground",
        /// latitude_deg = 48.1, longitude_deg = 11.6 }; one or several.
        "direction": Targets, only POINTING;
        /// Instead of a direction: the disc of the Earth as seen; half angles are then measured
        /// from its limb.
        "limb_of": Choice(&["earth"], &[]), only POINTING;
        /// Angle beyond the limb, instead of the half angle.
        "beyond_limb_deg": Number(q::MARGIN_DEG), only POINTING;
        /// Half angle of the cone, between 0 and 180.
        "half_angle_deg": Number(q::ANGLE_DEG), only POINTING;
        /// Half angle of the cone in rad, between 0 and π.
        "half_angle_rad": Number(q::ANGLE_RAD), only POINTING;
        /// Margin: it enlarges a keep-out cone and reduces a keep-in cone. Default: 0.
        "margin_deg": Number(q::MARGIN_DEG), only BESIDE_CONE;
        /// Margin of the cone in rad.
        "margin_rad": Number(q::MARGIN_RAD), only BESIDE_CONE;
        /// The largest deviation of a boresight from its cone at the ends and between the nodes;
        /// it is zero at the nodes. Default: 0.1.
        "within_deg": Number(q::TOLERANCE_DEG), only ON_CONE;
        /// The largest deviation of a boresight from its cone, in rad.
        "within_rad": Number(q::TOLERANCE_RAD), only ON_CONE;
        /// When the constraint is active: while a part of the Sun is visible, while the Earth hides
        /// a part of the Sun, or while the Earth does not hide the target of the cone. Needs
        /// [orbit]. Default: always.
        "while": Choice(&["always", "sunlit", "eclipse", "target_visible"], &[]), only POINTING;
        /// The intervals in which the constraint is active, in seconds from the start: [[0, 40],
        /// [60, 90]].
        "during_s": Intervals, only POINTING;
        /// The accepted probability of a violation at the worst instant, under [uncertainty], with
        /// the gains of [feedback]: the plan keeps the necessary margin. Below 0.5.
        "chance": Number(q::CHANCE), only WITH_CHANCE;
        /// The time to which the chance refers. instant: the worst one, to first order. motion: any
        /// time of the motion, estimated from simulated flights with [plant]; at least 1e-4.
        /// Default: instant.
        "chance_over": Choice(&["instant", "motion"], &[]), only WITH_CHANCE;
        /// Limit on the inertial angular velocity: one number for its norm, or three for its
        /// components in body axes.
        "angular_velocity_limit_deg_s": Limits(q::RATE_LIMIT_DEG, Some(3)), only RATE_LIMIT;
        /// Limit on the inertial angular velocity, in rad/s.
        "angular_velocity_limit_rad_s": Limits(q::RATE_LIMIT_RAD, Some(3)), only RATE_LIMIT;
        /// Margin kept below the limit: one number, or three for a limit on each axis. If `chance`
        /// requires a larger margin, that margin applies. Default: 0.
        "margin_deg_s": Spread(q::SPREAD), only RATE_LIMIT;
        /// Margin kept below the limit, in rad/s.
        "margin_rad_s": Spread(q::SPREAD), only RATE_LIMIT;
    }
}
const HALF_ANGLES: &[&str] = &["half_angle_deg", "half_angle_rad", "beyond_limb_deg"];
const RATE_LIMITS: &[&str] = &["angular_velocity_limit_deg_s", "angular_velocity_limit_rad_s"];
const DIRECTIONS: &[&str] = &["direction_inertial", "direction_reference", "direction", "limb_of"];
const PLACES: &[&str] = &[
    "sun",
    "moon",
    "nadir",
    "earth",
    "zenith",
    "geodetic_nadir",
    "velocity",
    "anti_velocity",
    "along_track",
    "orbit_normal",
    "anti_orbit_normal",
    "anti_sun",
    "ground",
    "limb",
    "satellite",
    "orbit_vector",
    "turning",
    "track",
];

shared_keys! {
    /// The target: sun, anti_sun, moon, nadir (or earth), zenith, geodetic_nadir, velocity,
    /// anti_velocity, along_track, orbit_normal, anti_orbit_normal, ground, limb, satellite (with
    /// the keys of its orbit), orbit_vector; turning; or a track, as in plan files. All except
    /// Sun, Moon and turning need [orbit], and all except turning need an epoch. For a fixed
    /// direction give ra_deg and dec_deg, or a vector, instead.
    AT_KEY = "at": Choice(PLACES, &[]);
    /// Right ascension, with dec_deg.
    RA_KEY = "ra_deg": Number(q::ANGLE_DEG);
    /// Declination, with ra_deg.
    DEC_KEY = "dec_deg": Number(q::ANGLE_DEG);
    /// A vector of any length.
    VECTOR_KEY = "vector": Vector(q::COMPONENT);
    /// Geodetic latitude of a station.
    LATITUDE_KEY = "latitude_deg": Number(q::ANGLE_DEG);
    /// East longitude of a station.
    LONGITUDE_KEY = "longitude_deg": Number(q::ANGLE_DEG);
    /// For limb: the azimuth about nadir, right-handed, from along the track.
    AZIMUTH_KEY = "azimuth_deg": Number(q::ANGLE_DEG);
    /// Height of a station above the ellipsoid of WGS 84, or of a limb above the sphere of its
    /// equatorial radius. Default: 0.
    HEIGHT_KEY = "height_m": Number(q::POSITION);
    /// Two-line elements, propagated by SGP4: both lines, with or without the name line above them.
    TLE_KEY = "tle": Texts(3);
    /// An orbit mean-elements message of CCSDS (OMM, keywords and values, XML or JSON), relative to
    /// the folder of the spec, propagated by SGP4.
    OMM_KEY = "omm": Text(1000);
    /// For tle and omm: the largest age of the elements. Default: 30.
    OLDEST_KEY = "oldest_days": Number(q::DAYS);
    /// An orbit ephemeris message of CCSDS (OEM, keywords and values), relative to the folder of
    /// the spec: centre Earth, in ICRF, GCRF, EME2000, TOD, TEME or ITRF.
    OEM_KEY = "oem": Text(1000);
    /// Keplerian elements, osculating, GCRS: semi-major axis.
    AXIS_KEY = "semi_major_axis_m": Number(q::POSITION);
    /// Eccentricity, below 1. Default: 0.
    ECCENTRICITY_KEY = "eccentricity": Number(q::COMPONENT);
    /// Inclination. Default: 0.
    INCLINATION_KEY = "inclination_deg": Number(q::ANGLE_DEG);
    /// Right ascension of the ascending node. Default: 0.
    NODE_KEY = "raan_deg": Number(q::ANGLE_DEG);
    /// Argument of the perigee. Default: 0.
    PERIGEE_KEY = "argument_of_perigee_deg": Number(q::ANGLE_DEG);
    /// True anomaly. Default: 0.
    ANOMALY_KEY = "true_anomaly_deg": Number(q::ANGLE_DEG);
    /// Instead of elements: position, GCRS; with velocity_m_s.
    PLACE_KEY = "position_m": Vector(q::POSITION);
    /// Velocity, GCRS.
    MOTION_KEY = "velocity_m_s": Vector(q::VELOCITY);
    /// The moment of elements or state. Default: the epoch of the maneuver.
    MOMENT_KEY = "epoch": Text(100);
    /// The propagation of elements or a state: about a point mass, or about the flattened Earth.
    /// Default: j2.
    MODEL_KEY = "model": Choice(&["j2", "two_body"], &[]);
    /// For orbit_vector: the components along the track, along the orbit normal, and outward.
    ORBIT_VECTOR_KEY = "orbit_vector": Vector(q::COMPONENT);
    /// For turning: the direction at time zero.
    TURNING_KEY = "turning_vector": Vector(q::COMPONENT);
    /// For turning: the angular velocity of the turning object, reference axes.
    TURNING_RATE_KEY = "turning_rate_deg_s": Vector(q::RATE_DEG);
    /// For track: the time at which it starts. Default: 0.
    FROM_KEY = "from_s": Number(q::ELAPSED);
    /// For track: the duration of a piece.
    PIECE_KEY = "piece_s": Number(q::DURATION);
    /// For track: the number of coefficients of a piece. Default: all.
    TERMS_KEY = "terms": Count(1, 10_000);
    /// For track: Chebyshev coefficients of a vector in reference axes at time zero, piece after
    /// piece.
    COEFFICIENTS_KEY = "coefficients": Vertices(q::COMPONENT);
    /// For track: the radius of the target, from whose limb cones are measured.
    DISC_KEY = "disc_radius": Number(q::COMPONENT);
    /// A body axis that points at a target, instead of an attitude: the body then turns with the
    /// target.
    POINT_KEY = "point": Table(&POINT_AT);
    /// With point: a second body axis, as near as possible to a second target. Default: the roll
    /// is free.
    SECOND_KEY = "second": Table(&SECOND);
    /// With point: whether the body turns with the target or is at rest. Default: matched.
    AIM_RATE_KEY = "rate": Choice(&["matched", "zero"], &[]);
    /// With point: an additional rate about the boresight. The body keeps this spin; its phase is
    /// free if the roll is free. An angular velocity along boresight_body has the same effect if
    /// the target does not move. Default: 0.
    ROLL_RATE_KEY = "roll_rate_deg_s": Number(q::RATE_DEG);
}

macro_rules! targets {
    ($(
        $(#[doc = $about:literal])*
        $visibility:vis static $table:ident {
            $($(#[doc = $doc:literal])* $name:literal: $kind:expr $(, needed $sample:expr)?;)*
        }
    )*) => {
        tables! {
            $(
                $(#[doc = $about])*
                $visibility static $table {
                    $($(#[doc = $doc])* $name: $kind $(, needed $sample)?;)*
                    AT_KEY; RA_KEY; DEC_KEY; VECTOR_KEY; LATITUDE_KEY; LONGITUDE_KEY; HEIGHT_KEY; AZIMUTH_KEY;
                    ORBIT_VECTOR_KEY; TURNING_KEY; TURNING_RATE_KEY;
                    TLE_KEY; OMM_KEY; OEM_KEY; OLDEST_KEY; AXIS_KEY; ECCENTRICITY_KEY; INCLINATION_KEY;
                    NODE_KEY; PERIGEE_KEY; ANOMALY_KEY; PLACE_KEY; MOTION_KEY; MOMENT_KEY; MODEL_KEY;
                    FROM_KEY; PIECE_KEY; TERMS_KEY; COEFFICIENTS_KEY; DISC_KEY;
                }
            )*
        }
    };
}

targets! {
    /// A target.
    pub(crate) static TARGET {}

    /// The pointing axis and its target.
    static POINT_AT {
        /// The pointing axis, body axes, any length.
        "boresight_body": Vector(q::COMPONENT), needed "boresight_body = [0, 0, 1]";
        /// The name of the axis in reports and pictures. Default: its direction.
        "boresight_name": Text(100);
    }

    /// The axis that fixes the roll, and its target.
    static SECOND {
        /// The axis, body axes, any length.
        "axis_body": Vector(q::COMPONENT), needed "axis_body = [1, 0, 0]";
        /// The largest deviation of the roll to either side. Default: 0.
        "roll_within_deg": Number(q::MARGIN_DEG);
    }
}

tables! {
    static ORBIT[
        exclusive: &[&["tle", "omm", "oem", "semi_major_axis_m", "position_m"]],
        one_of: &[(
            &["tle", "omm", "oem", "semi_major_axis_m", "position_m"],
            "tle = [\"1 …\", \"2 …\"]",
        )]
    ] {
        TLE_KEY; OMM_KEY; OEM_KEY; OLDEST_KEY; AXIS_KEY; ECCENTRICITY_KEY; INCLINATION_KEY; NODE_KEY; PERIGEE_KEY;
        ANOMALY_KEY; PLACE_KEY; MOTION_KEY; MOMENT_KEY; MODEL_KEY;
        /// UT1 − UTC, from IERS bulletins; its effect on the ground is at most 120 m. Default: 0.
        "ut1_minus_utc_s": Number(q::ELAPSED);
        /// Coordinate x of the pole; its effect on the ground is at most 15 m. Default: 0.
        "polar_motion_x_arcsec": Number(q::COMPONENT);
        /// Coordinate y of the pole. Default: 0.
        "polar_motion_y_arcsec": Number(q::COMPONENT);
    }
}

tables! {
    static SCENERY {
        /// The vector from the centre of the Earth to the spacecraft, m.
        "spacecraft": Table(&WAY);
        /// The vector from the spacecraft to the Sun, m.
        "sun": Table(&WAY), needed "sun = { piece_s = 60, coefficients = [[1.5e11, 0, 0]] }";
        /// The vector from the spacecraft to the Moon, m.
        "moon": Table(&WAY), needed "moon = { piece_s = 60, coefficients = [[3.8e8, 0, 0]] }";
        /// The rotation from reference axes to axes that turn with the Earth, at time zero.
        "earth_axes": Matrix, needed "earth_axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]";
        /// The target of the end, for people.
        "target": Text(200);
        /// Metres in the unit of the vector that the end points along; absent for a direction
        /// without a distance.
        "target_unit_m": Number(q::SIZE);
        LATITUDE_KEY; LONGITUDE_KEY; HEIGHT_KEY;
    }

    /// A vector as a function of time.
    static WAY {
        FROM_KEY; PIECE_KEY; TERMS_KEY; COEFFICIENTS_KEY;
    }
}

tables! {
    /// A direction: right ascension and declination, or a vector.
    pub(crate) static DIRECTION {
        /// Right ascension: from the x axis towards y; with dec_deg.
        "ra_deg": Number(q::ANGLE_DEG);
        /// Declination: from the x-y plane towards z; with ra_deg.
        "dec_deg": Number(q::ANGLE_DEG);
        /// A vector of any length.
        "vector": Vector(q::COMPONENT);
        "body": HeavenlyBody;
    }
}

shared_keys! {
    /// Attitude R, body vectors to reference vectors, in one of the notations.
    ATTITUDE_KEY = "attitude": Table(&ATTITUDE);
    /// Inertial angular velocity in body axes. Default: at rest (required under
    /// gravity_gradient).
    RATE_DEG_KEY = "angular_velocity_deg_s": Vector(q::RATE_DEG);
    /// Inertial angular velocity in body axes. Default: at rest (required under
    /// gravity_gradient).
    RATE_RAD_KEY = "angular_velocity_rad_s": Vector(q::RATE_RAD);
    /// Position of the mass center, reference frame. With positions in [start] and [end] the
    /// maneuver also moves the body.
    POSITION_KEY = "position_m": Vector(q::POSITION);
    /// Velocity of the mass center, reference frame.
    VELOCITY_KEY = "velocity_m_s": Vector(q::VELOCITY);
}
const RATES: &[&str] = &["angular_velocity_deg_s", "angular_velocity_rad_s", "angular_velocity"];
/// Keys of the rate about the boresight.
const SPINS: &[&str] = &["roll_rate_deg_s", "angular_velocity_deg_s", "angular_velocity_rad_s"];
/// Key with the value "at rest in LVLH".
pub(super) const REST_IN_ORBIT: &str = "angular_velocity";
const END_ATTITUDES: &[&str] = &["attitude", "rotation_from_start", "point"];
const ENDS: &[&str] =
    &["attitude", "rotation_from_start", "point", "angular_velocity_deg_s", "angular_velocity_rad_s"];
const ATTITUDE_SAMPLE: &str = "attitude = { axis = [0, 0, 1], angle_deg = 90 }";

tables! {
    static START[
        exclusive: &[&["attitude", "point"], RATES, SPINS],
        one_of: &[(&["attitude", "point"], ATTITUDE_SAMPLE)],
    ] {
        ATTITUDE_KEY;
        RATE_DEG_KEY;
        RATE_RAD_KEY;
        /// Instead of a numerical angular velocity: at rest relative to the orbit frame, under kind
        /// = "gravity_gradient".
        "angular_velocity": Choice(&["at rest in LVLH"], &[]);
        POINT_KEY;
        SECOND_KEY;
        AIM_RATE_KEY;
        ROLL_RATE_KEY;
        POSITION_KEY;
        VELOCITY_KEY;
    }

    static END[
        exclusive: &[
            END_ATTITUDES,
            SPINS,
            &["rotation_from_start", "rotation_from_start_rad"],
            RATES,
        ],
        one_of: &[(ENDS, ATTITUDE_SAMPLE)],
    ] {
        /// Attitude R, body vectors to reference vectors, in one of the notations. With an
        /// angular velocity and no attitude the body ends in any attitude: detumbling.
        "attitude": Table(&ATTITUDE);
        /// Instead of attitude: the rotation from the start, in its body axes, any angle; end =
        /// start · rotation. It is used as written unless `path` changes that.
        "rotation_from_start": Table(&ATTITUDE);
        /// In addition to attitude: the rotation from the start that leads there, a rotation
        /// vector in its body axes, any angle. It is used as written unless `path` changes that.
        "rotation_from_start_rad": Vector(q::ANGLE_RAD);
        RATE_DEG_KEY;
        RATE_RAD_KEY;
        /// Instead of a numerical angular velocity: at rest relative to the orbit frame, under kind
        /// = "gravity_gradient".
        "angular_velocity": Choice(&["at rest in LVLH"], &[]);
        POINT_KEY;
        SECOND_KEY;
        AIM_RATE_KEY;
        ROLL_RATE_KEY;
        POSITION_KEY;
        VELOCITY_KEY;
    }

    static STOP[
        exclusive: &[
            &["attitude", "point"],
            &["window_s", "start_s", "window", "start"],
            &["passing", "hold_s"],
            &["passing", "settling_s"],
            &["angular_velocity_limit_deg_s", "angular_velocity_limit_rad_s"],
        ],
        one_of: &[(&["attitude", "point"], ATTITUDE_SAMPLE)],
    ] {
        /// The name of the stop, for people and for maneuver.last. Default: its number.
        "name": Text(200);
        ATTITUDE_KEY;
        POINT_KEY;
        SECOND_KEY;
        /// The time at rest before the hold, for vibrations to decay. Default: 0.
        "settling_s": Number(q::NOT_NEGATIVE_TIME);
        /// The duration of the hold, for which the body stays at the stop. Default: 0.
        "hold_s": Number(q::NOT_NEGATIVE_TIME);
        /// The interval in which the hold begins and ends: [from, until]. The body waits until the
        /// window opens. Default: any time.
        "window_s": Interval;
        /// The time at which the hold begins.
        "start_s": Number(q::NOT_NEGATIVE_TIME);
        /// As window_s, but given as two dates with their time scales: ["2026-11-21T07:05:00 UTC",
        /// "2026-11-21T07:15:00 UTC"].
        "window": Texts(2);
        /// As start_s, but given as a date with its time scale.
        "start": Text(100);
        /// Whether the body passes without stopping, at the rate with the lowest cost. Default:
        /// false.
        "passing": Flag;
        /// Bound on the rate at which the body passes. Default: none.
        "angular_velocity_limit_deg_s": Limit(q::RATE_LIMIT_DEG);
        /// Bound on the rate at which the body passes. Default: none.
        "angular_velocity_limit_rad_s": Limit(q::RATE_LIMIT_RAD);
    }

    static MANEUVER[exclusive: &[&["steps", "step_s"]]] {
        /// The objective: effort, the integral of ½uᵀWu. With limits on the inputs also time: the
        /// duration, which is then not given; or fuel: the integral of Σ price·|u|, or
        /// price·|torque| with torque_norm_limit_n_m. Default: effort.
        "minimize": Choice(&["effort", "time", "fuel"], &[]);
        /// The duration of a minimum-effort or minimum-fuel maneuver, unless time has a price. With
        /// stops: the total duration, including the holds, which the plan divides among the legs.
        "duration_s": Number(q::DURATION);
        /// The longest allowed duration of a minimum-effort or minimum-fuel maneuver, instead of
        /// duration_s: the plan finds the best duration up to it.
        "duration_at_most_s": Number(q::DURATION);
        /// The price of a second in addition to effort or fuel, instead of duration_s: the plan
        /// then finds the duration.
        "time_price_per_s": Number(q::PRICE);
        /// Number of steps; with stops, of each leg. Default: 100, or as many as keep each step
        /// within 0.3 rad, including the nutation due to the momentum of wheels; more if a plan
        /// needs them to land, or to cost at most about 0.1 % above its optimum in continuous time.
        "steps": Steps(StepsOf::Plan);
        /// Step, instead of steps.
        "step_s": Number(q::DURATION);
        /// The homotopy class of the rotation. Default: best; as_given with rotation_from_start.
        "path": Choice(&["best", "shortest", "long", "as_given"], &[]);
        /// The order of the stops: given, or free for the best one. Default: given.
        "order": Choice(&["given", "free"], &[]);
        /// The name of the stop that stays last, with order = "free".
        "last": Text(200);
    }

    static SOLVER[exclusive: &[&["continuous_tolerance_deg", "continuous_tolerance_rad"]]] {
        /// The solver: shooting on the costates, an interior point within all limits, or, for
        /// minimum effort with a given duration, sequential convex programming (scp). Default:
        /// auto, which uses shooting where possible and the interior point otherwise.
        "method": Choice(&["auto", "shooting", "scp", "interior_point"], &[]);
        /// The number of attempts before an answer counts as the best: quick, default, or
        /// thorough with two hundred starts.
        "search": Choice(&["quick", "default", "thorough"], &[]);
        /// Discretisation: lie_verlet (second order) or lie_euler (first order). Default:
        /// lie_verlet.
        "scheme": Choice(&["lie_verlet", "lie_euler"], &[]);
        /// Tolerance of the scaled discrete terminal error. Default: 1e-12.
        "tolerance": Number(q::TOLERANCE);
        /// The motion that meets the end. motion: the true motion under the torques, which are held
        /// over each step (the plan lands). discrete: the motion of the discrete equations, as in
        /// published plans; the true motion then has a terminal error. Default: motion.
        "target": Choice(&["motion", "discrete"], &[]);
        /// Limit on the continuous terminal attitude error. Default: 1e-4 degrees; with the target
        /// discrete a quarter of the angle turned, from 5 to 45 degrees.
        "continuous_tolerance_deg": Number(q::TOLERANCE_DEG);
        /// Limit on the continuous terminal attitude error in rad.
        "continuous_tolerance_rad": Number(q::TOLERANCE_RAD);
        /// Limit on the wall-clock time of the plan. Default: none.
        "time_limit_s": Number(q::DURATION);
        /// Iteration limit of one Newton run, and of the subproblems of one run of scp; the
        /// interior point may take four times as many. Default: 60.
        "max_iterations": Count(1, 1_000_000);
        /// Whether the extremal and its rivals are tested to second order. With skipped the
        /// result may be a saddle, and the plan reports that it was not tested. Default: tested.
        "second_order": Choice(&["tested", "skipped"], &[]);
    }

    static ENVIRONMENT[selector: Some("kind")] {
        /// The kind of environment.
        "kind": Choice(&["uniform_gravity", "gravity_gradient", "central_gravity"], &[]),
            needed "kind = \"gravity_gradient\"";
        /// Mass of the body on its pivot.
        "mass_kg": Number(q::MASS), only UNIFORM, needed "mass_kg = 1";
        /// Acceleration of gravity.
        "gravity_m_s2": Number(q::GRAVITY), only UNIFORM, needed "gravity_m_s2 = 9.81";
        /// Direction of gravity, reference frame; any length.
        "direction": Vector(q::COMPONENT), only UNIFORM, needed "direction = [0, 0, 1]";
        /// The vector from the pivot to the mass center, body axes.
        "pivot_to_mass_center_m": Vector(q::LENGTH), only UNIFORM,
            needed "pivot_to_mass_center_m = [0, 0, 0.3]";
        /// Orbital rate. Attitudes are then relative to LVLH: e1 along the velocity, e2 the orbit
        /// normal, e3 radially outward. `lvlh_axes` chooses others.
        "orbital_rate_rad_s": Number(q::ORBITAL_RATE), only GRADIENT, needed "orbital_rate_rad_s = 0.00116";
        /// Axes of attitudes and directions in this spec: velocity_normal_outward as above, or
        /// velocity_antinormal_nadir, x along the velocity, y opposite to the orbit normal, z to
        /// nadir. The plan file uses the first. Default: velocity_normal_outward.
        "lvlh_axes": Choice(&["velocity_normal_outward", "velocity_antinormal_nadir"], &[]), only GRADIENT;
        /// Gravitational parameter of the point mass at the origin.
        "gravitational_parameter_m3_s2": Number(q::GRAVITATIONAL_PARAMETER), only CENTRAL,
            needed "gravitational_parameter_m3_s2 = 3.986e14";
        /// The attraction of the body: as mass points, or to second order in its size.
        "body": Choice(&["points", "second_order"], &[]), only CENTRAL, needed "body = \"second_order\"";
        /// The mass points, if body = "points". Their masses sum to body.mass_kg.
        "points": List(&POINT, MAX_POINTS), only CENTRAL;
    }

    static POINT {
        /// Mass of the point.
        "mass_kg": Number(q::MASS), needed "mass_kg = 0.5";
        /// Place of the point, body axes, from the mass center.
        "position_m": Vector(q::LENGTH), needed "position_m = [0.15, 0, 0]";
    }

    static EXPECT {
        /// The source of the numbers.
        "source": Text(2000);
        /// Status of the plan. Default: solved.
        "status": Choice(&["solved", "infeasible", "not_converged", "limit_reached", "verification_failed"], &[]);
        /// The cost.
        "cost": Table(&TOLERANCED);
        /// The published cost, in the unit of the plan's cost, and its rounding: the plan must not
        /// cost more.
        "published": Table(&TOLERANCED);
        /// Bound on the larger of terminal.attitude_rad and terminal.momentum_relative.
        "terminal_error": Number(q::COST);
        /// Bound on the iterations of the winning start, over its whole fallback sequence.
        "newton_iterations_at_most": Count(1, 1_000_000);
        /// Conjugate points of the plan.
        "conjugate_points": Count(0, 1_000_000);
        /// Cost of the continuous extremal, where time or fuel is minimised: its duration in
        /// seconds, or its fuel.
        "continuous_cost": Table(&TOLERANCED);
        /// Number of switches, where time or fuel is minimised.
        "switches": Count(0, 1000);
        /// Bound on the possible reduction of the cost, to first order, where time or fuel is
        /// minimised.
        "gap_at_most": Number(q::COST);
        /// Homotopy class of the rotation: the short way or the long way.
        "sense": Choice(&["short", "long"], &[]);
        /// Bound on the smallest margin of all limits and constraints, relative to the limit or in
        /// rad.
        "margin_at_least": Number(q::MARGIN);
        /// Names of all active limits and constraints.
        "active": Texts(100);
        /// The names of the stops in the order in which they are visited.
        "order": Texts(MAX_STOPS);
        /// Part of the reported reason why no plan can meet the terminal conditions.
        "because": Text(200);
        /// Costs of other extremals that must be found.
        "rivals": List(&TOLERANCED, 100);
    }

    static TOLERANCED {
        /// Expected value.
        "value": Number(q::COST), needed "value = 23.35";
        /// Largest accepted difference.
        "tolerance": Number(q::COST), needed "tolerance = 0.005";
    }
}

macro_rules! attitude_keys {
    ($($sequence:literal)*) => {
        tables! {
            /// The notations of an attitude. Exactly one is given; `axis` needs one of the two
            /// angles.
            pub(crate) static ATTITUDE {
                /// Axis of rotation, any length; with angle_deg or angle_rad.
                "axis": Vector(q::COMPONENT);
                /// Angle about axis.
                "angle_deg": Number(q::ANGLE_DEG);
                /// Angle about axis.
                "angle_rad": Number(q::ANGLE_RAD);
                /// Axis times angle.
                "rotation_vector_rad": Vector(q::ANGLE_RAD);
                /// Axis times angle.
                "rotation_vector_deg": Vector(q::ANGLE_DEG);
                /// Rotation matrix, three rows.
                "matrix": Matrix;
                /// For [start] and [end]: a file with attitudes (AEM, APM, STK .a, C-kernel,
                /// table), relative to the folder of the spec. The attitude is taken at the epoch,
                /// or at the end of a given duration.
                "file": Text(1000);
                /// Unit quaternion, scalar first, Hamilton, body to reference.
                "quaternion_wxyz": Quaternion;
                /// Unit quaternion, scalar last, Hamilton, body to reference.
                "quaternion_xyzw": Quaternion;
                /// Modified Rodrigues parameters, axis times tan(angle/4); parameters longer than 1
                /// denote the same attitude as their shadow set.
                "mrp": Vector(q::COMPONENT);
                /// Rodrigues parameters (Gibbs vector), axis times tan(angle/2).
                "rodrigues": Vector(q::COMPONENT);
                /// Right ascension of the body's x axis, from the x axis of the reference frame
                /// towards y; with dec_deg and roll_deg.
                "ra_deg": Number(q::ANGLE_DEG);
                /// Declination of the body's x axis, towards z of the reference frame.
                "dec_deg": Number(q::ANGLE_DEG);
                /// Roll about the body's x axis, R = Rz(ra) Ry(-dec) Rx(roll): at 0 the body's y
                /// axis lies in the xy plane and z is to the north.
                "roll_deg": Number(q::ANGLE_DEG);
                $(
                    #[doc = "Intrinsic Euler angles about "] #[doc = $sequence] #[doc = ", in that order."]
                    "euler_" + $sequence + "_deg": Vector(q::ANGLE_DEG);
                    #[doc = "Intrinsic Euler angles about "] #[doc = $sequence] #[doc = ", in that order."]
                    "euler_" + $sequence + "_rad": Vector(q::ANGLE_RAD);
                )*
            }
        }
    };
}

// The axes of a sequence are named by letters or, as spacecraft engineers write them, by numbers:
// 321 is zyx.
attitude_keys! {
    "xyz" "xzy" "yxz" "yzx" "zxy" "zyx" "xyx" "xzx" "yxy" "yzy" "zxz" "zyz"
    "123" "132" "213" "231" "312" "321" "121" "131" "212" "232" "313" "323"
}
