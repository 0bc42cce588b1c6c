//! Every key of a spec, once: the reader, the messages and the JSON Schema all work from these tables.

use super::quantity::{self as q, Quantity};
use Kind::*;
use slewkit::maneuver::Problem;
use slewkit::mechanics::ActuatorSet;

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
    /// One number that is not negative for all, or one for each.
    Spread(Quantity),
    /// A square matrix as rows, or its diagonal.
    Square(Quantity),
    /// A number of steps.
    Steps(StepsOf),
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
    /// What is aimed at: a word, a table, or a list of these.
    Targets,
    /// A heavenly body, whose direction this version cannot know.
    HeavenlyBody,
    /// A list of texts, at most this many.
    Texts(usize),
    /// A list of points, each three numbers.
    Vertices(Quantity),
    /// A list of triangles, each three whole numbers from 1.
    Faces,
    /// A list of intervals of time \[s\], one after another.
    Intervals,
}

/// What has steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StepsOf {
    /// A plan, which holds its nodes in memory.
    Plan,
    /// A simulation, which streams.
    Simulation,
}

impl StepsOf {
    /// The fewest that it may have.
    pub fn least(self) -> u64 {
        match self {
            Self::Plan => Problem::MIN_STEPS as u64,
            Self::Simulation => 1,
        }
    }

    /// The most.
    pub fn most(self) -> u64 {
        match self {
            Self::Plan => Problem::MAX_STEPS as u64,
            Self::Simulation => MAX_STEPS as u64,
        }
    }
}

impl Kind {
    /// The keys of the table, or of each table of the list, that it holds.
    pub fn table(self) -> Option<&'static Table> {
        match self {
            Self::Table(table) | Self::List(table, _) => Some(table),
            Self::Directions => Some(&DIRECTION),
            Self::Targets => Some(&TARGET),
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
    const EMPTY: Self = Self { keys: &[], selector: None, exclusive: &[], one_of: &[] };

    /// The key of this name.
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }
}

/// One key: its description, its name, its [`Kind`]; then `only` and the values of the selector under which it means
/// something, `needed` and a sample.
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

/// Keys that several tables have.
macro_rules! shared_keys {
    ($($(#[doc = $doc:literal])* $key:ident = $name:literal: $kind:expr;)*) => {
        $(const $key: Key = key!([$($doc)*] $name; $kind);)*
    };
}

/// Tables, each with what it says beside its keys in brackets. A key is a name with its [`Kind`], or one that is
/// shared; the comment of a key is its description in the schema.
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
    pub(crate) static ROOT {
        /// Address of the JSON Schema, for editors; ignored.
        "$schema": Text(2000);
        /// Version of this format: 1.
        "format": Format, needed "format = 1";
        /// What is planned, for people. Default: the file name.
        "name": Text(200);
        /// Notes for people; ignored.
        "description": Text(10_000);
        /// The moment of time zero, with its time scale (UTC, TAI, TT, TDB, GPS), as in "2026-11-21T07:00:00 UTC".
        /// Files for other programs need it; plans do not depend on it.
        "epoch": Text(100);
        /// Whether what is aimed at by name is seen where it was when its light left it: of stations, Moon and satellites. Default: none.
        "light_time": Choice(&["none", "one_way"], &[]);
        /// Whether what is aimed at by name is seen as from a satellite that moves: of all that gives light, stars by ra_deg among it.
        /// Default: none.
        "aberration": Choice(&["none", "satellite"], &[]);
        /// What files for other programs call the object, its frames and its inputs.
        "names": Table(&NAMES);
        /// The rigid body.
        "body": Table(&BODY), needed "[body]\ninertia_kg_m2 = [2, 3, 4]   # or three rows: the whole matrix";
        /// Input axes and effort weights. Default: three torques along the body axes; three forces along the
        /// reference axes too when positions are given.
        "actuators": Table(&ACTUATORS);
        /// State at the beginning.
        "start": Table(&START),
            needed "[start]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\nangular_velocity_deg_s = [0, 0, 0]";
        /// State at the end.
        "end": Table(&END),
            needed "[end]\nattitude = { euler_zyx_deg = [90, 0, 0] }\nangular_velocity_deg_s = [0, 0, 0]";
        /// What is minimised, in what time, on which grid.
        "maneuver": Table(&MANEUVER), needed "[maneuver]\nduration_s = 60";
        /// How it is solved. Default: automatic.
        "solver": Table(&SOLVER);
        /// What acts on the body. Default: nothing.
        "environment": Table(&ENVIRONMENT);
        /// What the plan must come to; read by the tests of a collection of problems.
        "expect": Table(&EXPECT);
        /// Where the body may point and how fast it may turn, all the way. Default: anywhere, any rate.
        "constraint": List(&CONSTRAINT, Problem::MAX_CONSTRAINTS);
        /// Sets of cones that hold in turns: at every time one of the sets holds as a whole.
        "any_of": List(&ANY_OF, 10);
        /// The orbit, where ends or cones aim at what depends on it. Axes of the reference frame are then those of the GCRS (ICRF).
        "orbit": Table(&ORBIT);
        /// What stands around the spacecraft, for pictures and summaries: plan files write it where [orbit] and targets are told.
        "scenery": Table(&SCENERY);
        /// What is uncertain, for `slew monte-carlo`; any other command plans the values as they stand.
        "dispersion": Table(&DISPERSION);
        /// Gains that keep the craft on the plan.
        "feedback": Table(&FEEDBACK);
        /// What the craft that flies the plan differs by while the plan stays, for covariances along it and for `slew fly`.
        "uncertainty": Table(&UNCERTAINTY);
        /// How the actuators follow when the plan is flown, for `slew fly`.
        "plant": Table(&PLANT);
        /// What becomes of the rounded last digits of matrices and unit vectors. remove: they become
        /// rotations, and of length 1. keep: each number is taken to its last bit, as in a spec that slew
        /// wrote. Default: remove.
        "rounding": Choice(&["remove", "keep"], &[]);
    }

    static NAMES {
        /// The object that turns. Default: the name of the spec.
        "object": Text(64);
        /// Its international designator, as in "1995-074A". Default: UNKNOWN.
        "object_id": Text(64);
        /// What the object is about, as in "EARTH". Default: not said.
        "center": Text(64);
        /// The reference frame, to which attitudes lead. Default: ICRF; needed where the frame turns.
        "reference_frame": Text(64);
        /// The body frame, from which they come. Default: SC_BODY_1.
        "body_frame": Text(64);
        /// Who issues the files. Default: UNKNOWN.
        "originator": Text(64);
        /// Number of the object at NAIF, negative, for SPICE kernels.
        "spice_id": Number(q::SPICE_ID);
        /// What the inputs are called in heads of tables, one for each. Default: the names of the wheels, else
        /// numbers.
        "inputs": Texts(100);
    }

    static BODY {
        /// Inertia about the mass center (about the pivot under uniform_gravity), body axes, tensor signs:
        /// three rows, or a diagonal of three. The mass of wheels is in it, their moments about their own axes are not.
        "inertia_kg_m2": Inertia, needed "inertia_kg_m2 = [2, 3, 4]";
        /// Mass; needed when positions are given, and nowhere else.
        "mass_kg": Number(q::MASS);
    }

    static ACTUATORS[
        exclusive: &[&["torque_axes_body", "torque_axes_reference"], &["force_axes_reference", "force_axes_body"]],
    ] {
        /// Torque axes fixed in the body, a list of axes, the columns of B. Two: underactuated; four:
        /// redundant. Default: three unit axes.
        "torque_axes_body": Axes;
        /// Torque axes fixed in the reference frame: the torque is Rᵀ B u.
        "torque_axes_reference": Axes;
        /// Weight W of the torque inputs in ½uᵀWu: one number per axis, or a full symmetric positive definite
        /// matrix. Default: 1 each.
        "effort_weight": Weight;
        /// Force axes fixed in the reference frame; an empty list: no forces. Default: three unit axes when
        /// positions are given.
        "force_axes_reference": Axes;
        /// Force axes fixed in the body: the force is R B u.
        "force_axes_body": Axes;
        /// Weight of the force inputs, like effort_weight. Default: 1 each.
        "force_effort_weight": Weight;
        /// Limit of the size of each torque input: one for all, or one per axis. Default: none.
        "torque_limit_n_m": Limits(q::TORQUE, None);
        /// The chance that corrections under [feedback] ask for more of an input than its limit at the worst instant, of each input: the
        /// plan leaves a reserve for them. Of wheels that of their torque limits. Below 0.5.
        "torque_limit_chance": Number(q::CHANCE);
        /// What the plan leaves of the limit to corrections: one number for all, or one per input. With a chance the larger acts.
        /// Default: 0.
        "torque_limit_reserve_n_m": Spread(q::SPREAD);
        /// Limit of the norm of the whole torque. Default: none.
        "torque_norm_limit_n_m": Limit(q::TORQUE_NORM);
        /// The same chance of the limit of the norm.
        "torque_norm_limit_chance": Number(q::CHANCE);
        /// What the plan leaves of the limit of the norm. Default: 0.
        "torque_norm_limit_reserve_n_m": Spread(q::SPREAD);
        /// Limit of how fast each torque input changes: one for all, or one per axis. Default: none.
        "torque_rate_limit_n_m_per_s": Limits(q::TORQUE_RATE, None);
        /// The chance that a held command changes more from a step to the next than the limit allows in a step.
        "torque_rate_limit_chance": Number(q::CHANCE);
        /// What the plan leaves of that limit: one number for all, or one per input. Default: 0.
        "torque_rate_limit_reserve_n_m_per_s": Spread(q::SPREAD);
        /// When limits may be exceeded with their chances, as of constraints: instant or motion. Default: instant.
        "chance_over": Choice(&["instant", "motion"], &[]);
        /// Limit of the size of each force input: one for all, or one per axis. Default: none.
        "force_limit_n": Limits(q::FORCE, None);
        /// Limit of the norm of the whole force. Default: none.
        "force_norm_limit_n": Limit(q::FORCE_NORM);
        /// Limit of how fast each force input changes: one for all, or one per axis. Default: none.
        "force_rate_limit_n_per_s": Limits(q::FORCE_RATE, None);
        /// Shortest pulse: each torque input is off or at its limit, and on for at least so long each time. For minimum fuel in a
        /// given duration. Default: inputs take any value within their limits.
        "shortest_pulse_s": Number(q::DURATION);
        /// What a N·m of each torque input costs in a second, where fuel is minimised: one for all, or one per axis; under
        /// torque_norm_limit_n_m what a N·m of the whole torque costs. Default: 1.
        "fuel_price": Limits(q::PRICE, None);
        /// What a newton of each force input costs in a second, where fuel is minimised: one for all, or one per axis; under
        /// force_norm_limit_n what a newton of the whole force costs. Default: 1.
        "force_fuel_price": Limits(q::PRICE, None);
        /// Reaction wheels, instead of torque axes; each input is the torque of one wheel on the body.
        "wheel": List(&WHEEL, MAX_WHEELS);
        /// Thrusters, instead of torque axes; each input is the torque of one thruster, never negative, or, where [start] and [end]
        /// have positions, its force, which pushes and turns the body. For minimum time and fuel.
        "thruster": List(&THRUSTER, MAX_WHEELS);
    }

    static THRUSTER {
        /// What messages call the thruster. Default: its number.
        "name": Text(100);
        /// Where it sits, from the mass center, body axes.
        "position_m": Vector(q::LENGTH);
        /// The way in which it pushes the body, body axes, any length.
        "force_direction_body": Vector(q::COMPONENT);
        /// Its largest force.
        "force_limit_n": Limit(q::FORCE);
        /// Instead of position, direction and force, where the body does not move: the axis of its torque, body axes, any length.
        "torque_axis_body": Vector(q::COMPONENT);
        /// Its largest torque.
        "torque_limit_n_m": Limit(q::TORQUE);
        /// What a newton of its force, or a N·m where the torque is given, costs in a second. Default: 1.
        "fuel_price": Number(q::PRICE);
    }

    static WHEEL {
        /// What messages call the wheel. Default: its number.
        "name": Text(100);
        /// Spin axis, body axes, of length 1.
        "axis_body": Vector(q::COMPONENT), needed "axis_body = [1, 0, 0]";
        /// Limit of the size of its torque; for every wheel or for none. Default: none.
        "torque_limit_n_m": Limit(q::TORQUE);
        /// Limit of the size of its momentum about its axis. Default: none.
        "momentum_limit_n_m_s": Limit(q::WHEEL_LIMIT);
        /// Its momentum about its axis at the start, against inertial space, not against the body: axial moment times (speed in the body
        /// plus axis · angular velocity); free at the end. Default: 0.
        "momentum_n_m_s": Number(q::WHEEL_MOMENTUM);
        /// Weight of its torque in ½uᵀWu. Default: 1.
        "effort_weight": Number(q::WHEEL_WEIGHT);
    }

    static ANY_OF {
        /// What reports call it. Default: its number.
        "name": Text(100);
        /// The sets, two at least.
        "set": List(&SET, 10), needed "set = [{ constraints = [\"A\"] }, { constraints = [\"B\"] }]";
    }

    static SET {
        /// Names of cones, each in this set alone, which hold together.
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
        /// What it asks: boresights outside or inside of cones, or held on them, or a limit of the angular velocity.
        "kind": Choice(&["keep_out", "keep_in", "on_cone", "rate_limit"], &[]), needed "kind = \"keep_out\"";
        /// What reports call it. Default: its kind.
        "name": Text(100);
        /// One boresight or several, body axes, any length.
        "boresight_body": Vectors(q::COMPONENT), only POINTING, needed "boresight_body = [0, 0, 1]";
        /// What the cone is about, fixed in inertial space: one direction or several, in the axes of the
        /// reference frame at the start.
        "direction_inertial": Directions, only POINTING;
        /// The same, fixed to a reference frame that turns.
        "direction_reference": Directions, only POINTING;
        /// What the cone is about by name, as it moves: "sun", { at = "ground", latitude_deg = 48.1, longitude_deg = 11.6 }; one or several.
        "direction": Targets, only POINTING;
        /// Instead of a direction: the disc of the Earth as it is seen; half angles are then counted from its limb.
        "limb_of": Choice(&["earth"], &[]), only POINTING;
        /// Angle beyond the limb, instead of the half angle.
        "beyond_limb_deg": Number(q::MARGIN_DEG), only POINTING;
        /// Half angle of the cone, between 0 and 180.
        "half_angle_deg": Number(q::ANGLE_DEG), only POINTING;
        /// The same in rad, between 0 and π.
        "half_angle_rad": Number(q::ANGLE_RAD), only POINTING;
        /// Margin: added to the half angle of a keep-out cone, taken from that of a keep-in cone. Default: 0.
        "margin_deg": Number(q::MARGIN_DEG), only BESIDE_CONE;
        /// The same in rad.
        "margin_rad": Number(q::MARGIN_RAD), only BESIDE_CONE;
        /// What a boresight that is held on a cone may be off by at the ends and between the nodes, on which it is held exactly. Default: 0.1.
        "within_deg": Number(q::TOLERANCE_DEG), only ON_CONE;
        /// The same in rad.
        "within_rad": Number(q::TOLERANCE_RAD), only ON_CONE;
        /// When it acts: while a part of the Sun is seen, while a part of it is hidden by the Earth, or while what the cone is about is
        /// not hidden by the Earth. Needs [orbit]. Default: always.
        "while": Choice(&["always", "sunlit", "eclipse", "target_visible"], &[]), only POINTING;
        /// The same as intervals of time from the start on: [[0, 40], [60, 90]].
        "during_s": Intervals, only POINTING;
        /// The chance of violating it at its worst instant, under [uncertainty], with the gains of [feedback]: the plan keeps as much
        /// margin as that takes. Below 0.5.
        "chance": Number(q::CHANCE), only WITH_CHANCE;
        /// When it may be violated with the chance. instant: at the worst one, to first order. motion: at any time, counted in flights
        /// by [plant]; from 1e-4 on. Default: instant.
        "chance_over": Choice(&["instant", "motion"], &[]), only WITH_CHANCE;
        /// Limit of the inertial angular velocity: one number for its norm, or three for its components in
        /// body axes.
        "angular_velocity_limit_deg_s": Limits(q::RATE_LIMIT_DEG, Some(3)), only RATE_LIMIT;
        /// The same in rad/s.
        "angular_velocity_limit_rad_s": Limits(q::RATE_LIMIT_RAD, Some(3)), only RATE_LIMIT;
        /// What the plan leaves of the limit: one number, or three beside three limits. With a chance the larger acts. Default: 0.
        "margin_deg_s": Spread(q::SPREAD), only RATE_LIMIT;
        /// The same in rad/s.
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
    /// What is aimed at: sun, anti_sun, moon, nadir (or earth), zenith, geodetic_nadir, velocity, anti_velocity, along_track,
    /// orbit_normal, anti_orbit_normal, ground, limb, satellite (with the keys of its orbit), orbit_vector; turning; or a track, as plan files write it. All but Sun, Moon and what turns need
    /// [orbit], and all but that an epoch. Instead: ra_deg and dec_deg, or a vector, which stand still.
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
    /// For limb: about nadir, right-handed, from along the track.
    AZIMUTH_KEY = "azimuth_deg": Number(q::ANGLE_DEG);
    /// Height of a station above the ellipsoid of WGS 84, or of a limb above the sphere of its equatorial radius. Default: 0.
    HEIGHT_KEY = "height_m": Number(q::POSITION);
    /// Two-line elements, both lines, by SGP4; a line above them is their name.
    TLE_KEY = "tle": Texts(3);
    /// An orbit mean-elements message of CCSDS (OMM, keywords and values, XML or JSON), relative to the folder of the spec, by SGP4.
    OMM_KEY = "omm": Text(1000);
    /// For tle and omm: the oldest elements that are taken. Default: 30.
    OLDEST_KEY = "oldest_days": Number(q::DAYS);
    /// An orbit ephemeris message of CCSDS (OEM, keywords and values), relative to the folder of the spec: centre Earth, in ICRF, GCRF,
    /// EME2000, TOD, TEME or ITRF.
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
    /// How elements or a state go on: about a point mass, or about the flattened Earth. Default: j2.
    MODEL_KEY = "model": Choice(&["j2", "two_body"], &[]);
    /// For orbit_vector: along the track, the orbit normal, outward.
    ORBIT_VECTOR_KEY = "orbit_vector": Vector(q::COMPONENT);
    /// For turning: the direction at time zero.
    TURNING_KEY = "turning_vector": Vector(q::COMPONENT);
    /// For turning: the angular velocity of what it is fixed in, reference axes.
    TURNING_RATE_KEY = "turning_rate_deg_s": Vector(q::RATE_DEG);
    /// For track: when it begins. Default: 0.
    FROM_KEY = "from_s": Number(q::ELAPSED);
    /// For track: the length of a piece.
    PIECE_KEY = "piece_s": Number(q::DURATION);
    /// For track: how many coefficients a piece has. Default: all.
    TERMS_KEY = "terms": Count(1, 10_000);
    /// For track: Chebyshev coefficients of a vector in reference axes at time zero, piece after piece.
    COEFFICIENTS_KEY = "coefficients": Vertices(q::COMPONENT);
    /// For track: radius of what it leads to, whose limb cones begin at.
    DISC_KEY = "disc_radius": Number(q::COMPONENT);
    /// A body axis that points at a target, in place of an attitude: the body then turns with it.
    POINT_KEY = "point": Table(&POINT_AT);
    /// With point: a second body axis towards a second target, as well as it can. Default: the roll is free.
    SECOND_KEY = "second": Table(&SECOND);
    /// With point: whether the body moves on with the target or stands. Default: matched.
    AIM_RATE_KEY = "rate": Choice(&["matched", "zero"], &[]);
    /// With point: the rate about the axis that points, besides: a spin that is kept, of any phase where the roll is free. Default: 0.
    ROLL_RATE_KEY = "roll_rate_deg_s": Number(q::RATE_DEG);
}

macro_rules! targets {
    ($($(#[doc = $about:literal])* $visibility:vis static $table:ident { $($(#[doc = $doc:literal])* $name:literal: $kind:expr $(, needed $sample:expr)?;)* })*) => {
        tables! {
            $(
                $(#[doc = $about])*
                $visibility static $table {
                    $($(#[doc = $doc])* $name: $kind $(, needed $sample)?;)*
                    AT_KEY; RA_KEY; DEC_KEY; VECTOR_KEY; LATITUDE_KEY; LONGITUDE_KEY; HEIGHT_KEY; AZIMUTH_KEY; ORBIT_VECTOR_KEY;
                    TURNING_KEY; TURNING_RATE_KEY;
                    TLE_KEY; OMM_KEY; OEM_KEY; OLDEST_KEY; AXIS_KEY; ECCENTRICITY_KEY; INCLINATION_KEY; NODE_KEY; PERIGEE_KEY; ANOMALY_KEY;
                    PLACE_KEY; MOTION_KEY; MOMENT_KEY; MODEL_KEY;
                    FROM_KEY; PIECE_KEY; TERMS_KEY; COEFFICIENTS_KEY; DISC_KEY;
                }
            )*
        }
    };
}

targets! {
    /// What is aimed at.
    pub(crate) static TARGET {}

    /// The axis that points, and what at.
    static POINT_AT {
        /// The axis that points, body axes, any length.
        "boresight_body": Vector(q::COMPONENT), needed "boresight_body = [0, 0, 1]";
    }

    /// The axis that keeps the roll, and what towards.
    static SECOND {
        /// The axis, body axes, any length.
        "axis_body": Vector(q::COMPONENT), needed "axis_body = [1, 0, 0]";
        /// How far the roll may be from there to either side. Default: 0.
        "roll_within_deg": Number(q::MARGIN_DEG);
    }
}

tables! {
    static ORBIT[exclusive: &[&["tle", "omm", "oem", "semi_major_axis_m", "position_m"]], one_of: &[(&["tle", "omm", "oem", "semi_major_axis_m", "position_m"], "tle = [\"1 …\", \"2 …\"]")]] {
        TLE_KEY; OMM_KEY; OEM_KEY; OLDEST_KEY; AXIS_KEY; ECCENTRICITY_KEY; INCLINATION_KEY; NODE_KEY; PERIGEE_KEY; ANOMALY_KEY;
        PLACE_KEY; MOTION_KEY; MOMENT_KEY; MODEL_KEY;
        /// UT1 − UTC, of bulletins: 120 m on the ground at most. Default: 0.
        "ut1_minus_utc_s": Number(q::ELAPSED);
        /// Coordinate x of the pole: 15 m on the ground at most. Default: 0.
        "polar_motion_x_arcsec": Number(q::COMPONENT);
        /// Coordinate y of the pole. Default: 0.
        "polar_motion_y_arcsec": Number(q::COMPONENT);
    }
}

tables! {
    static SCENERY {
        /// From the centre of the Earth to the spacecraft, m.
        "spacecraft": Table(&WAY);
        /// From the spacecraft to the Sun, m.
        "sun": Table(&WAY), needed "sun = { piece_s = 60, coefficients = [[1.5e11, 0, 0]] }";
        /// From the spacecraft to the Moon, m.
        "moon": Table(&WAY), needed "moon = { piece_s = 60, coefficients = [[3.8e8, 0, 0]] }";
        /// From reference axes to those that turn with the Earth, at time zero.
        "earth_axes": Matrix, needed "earth_axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]";
        /// What the end points at, for people.
        "target": Text(200);
        /// Metres in the unit of the vector that the end points along; without it that is no place.
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
    /// Attitude R, body vectors to reference-frame vectors, in one of the notations.
    ATTITUDE_KEY = "attitude": Table(&ATTITUDE);
    /// Inertial angular velocity in body axes. Default: at rest (needed under gravity_gradient).
    RATE_DEG_KEY = "angular_velocity_deg_s": Vector(q::RATE_DEG);
    /// Inertial angular velocity in body axes. Default: at rest (needed under gravity_gradient).
    RATE_RAD_KEY = "angular_velocity_rad_s": Vector(q::RATE_RAD);
    /// Position of the mass center, reference frame. Given in [start] and [end], the maneuver moves the body too.
    POSITION_KEY = "position_m": Vector(q::POSITION);
    /// Velocity of the mass center, reference frame.
    VELOCITY_KEY = "velocity_m_s": Vector(q::VELOCITY);
}
const RATES: &[&str] = &["angular_velocity_deg_s", "angular_velocity_rad_s", "angular_velocity"];
/// The key that says "at rest in LVLH".
pub(super) const REST_IN_ORBIT: &str = "angular_velocity";
const END_ATTITUDES: &[&str] = &["attitude", "rotation_from_start", "point"];
const ENDS: &[&str] =
    &["attitude", "rotation_from_start", "point", "angular_velocity_deg_s", "angular_velocity_rad_s"];
const ATTITUDE_SAMPLE: &str = "attitude = { axis = [0, 0, 1], angle_deg = 90 }";

tables! {
    static START[
        exclusive: &[&["attitude", "point"], RATES, &["point", "angular_velocity_deg_s", "angular_velocity_rad_s"]],
        one_of: &[(&["attitude", "point"], ATTITUDE_SAMPLE)],
    ] {
        ATTITUDE_KEY;
        RATE_DEG_KEY;
        RATE_RAD_KEY;
        /// Instead of numbers: at rest against the frame of the orbit, under kind = "gravity_gradient".
        "angular_velocity": Choice(&["at rest in LVLH"], &[]);
        POINT_KEY;
        SECOND_KEY;
        AIM_RATE_KEY;
        ROLL_RATE_KEY;
        POSITION_KEY;
        VELOCITY_KEY;
    }

    static END[
        exclusive: &[END_ATTITUDES, &["point", "angular_velocity_deg_s", "angular_velocity_rad_s"], &["rotation_from_start", "rotation_from_start_rad"], RATES],
        one_of: &[(ENDS, ATTITUDE_SAMPLE)],
    ] {
        /// Attitude R, body vectors to reference-frame vectors, in one of the notations. Without one, and with an angular velocity,
        /// the body ends in any attitude: detumbling.
        "attitude": Table(&ATTITUDE);
        /// Instead of attitude: the rotation from the start, in its body axes, any angle; end = start ·
        /// rotation. Taken as written unless `path` says otherwise.
        "rotation_from_start": Table(&ATTITUDE);
        /// Beside attitude: which rotation from the start leads there, a rotation vector in its body axes,
        /// any angle. Taken as written unless `path` says otherwise.
        "rotation_from_start_rad": Vector(q::ANGLE_RAD);
        RATE_DEG_KEY;
        RATE_RAD_KEY;
        /// Instead of numbers: at rest against the frame of the orbit, under kind = "gravity_gradient".
        "angular_velocity": Choice(&["at rest in LVLH"], &[]);
        POINT_KEY;
        SECOND_KEY;
        AIM_RATE_KEY;
        ROLL_RATE_KEY;
        POSITION_KEY;
        VELOCITY_KEY;
    }

    static MANEUVER[exclusive: &[&["steps", "step_s"]]] {
        /// What is minimised: effort, the integral of ½uᵀWu; or under limits of the inputs time, the duration, which is then
        /// not given, or fuel, the integral of Σ price·|u|, or price·|torque| under torque_norm_limit_n_m. Default: effort.
        "minimize": Choice(&["effort", "time", "fuel"], &[]);
        /// Duration; of a maneuver of least effort or fuel, unless time has a price.
        "duration_s": Number(q::DURATION);
        /// The longest duration of a maneuver of least effort or fuel, instead of duration_s: the best one up to it is sought.
        "duration_at_most_s": Number(q::DURATION);
        /// What a second costs beside effort or fuel, instead of duration_s: the duration is then sought.
        "time_price_per_s": Number(q::PRICE);
        /// Number of steps. Default: the smallest from 100 on with at most 0.3 rad a step; more where a plan needs them to land, or
        /// to cost at most about 0.1 % above its optimum in continuous time.
        "steps": Steps(StepsOf::Plan);
        /// Step, instead of steps.
        "step_s": Number(q::DURATION);
        /// Which way round. Default: best; as_given with rotation_from_start.
        "path": Choice(&["best", "shortest", "long", "as_given"], &[]);
    }

    static SOLVER[exclusive: &[&["continuous_tolerance_deg", "continuous_tolerance_rad"]]] {
        /// Which solver: shooting on the costates, or sequential convex programming. Default: auto, which
        /// takes the second where something is constrained.
        "method": Choice(&["auto", "shooting", "scp"], &[]);
        /// How much is tried before an answer counts as the best: quick, default, or thorough with two hundred starts.
        "search": Choice(&["quick", "default", "thorough"], &[]);
        /// Discretisation: lie_verlet (second order) or lie_euler (first order). Default: lie_verlet.
        "scheme": Choice(&["lie_verlet", "lie_euler"], &[]);
        /// Tolerance of the scaled discrete terminal error. Default: 1e-12.
        "tolerance": Number(q::TOLERANCE);
        /// What meets the end: the true motion under the torques, held over the steps (the plan lands), or the discrete one, as in
        /// what is published: the true one then ends beside it. Default: motion.
        "target": Choice(&["motion", "discrete"], &[]);
        /// Limit on the continuous terminal attitude error. Default: 1e-4 degrees; with the target discrete a quarter of the angle
        /// turned, from 5 to 45 degrees.
        "continuous_tolerance_deg": Number(q::TOLERANCE_DEG);
        /// The same in rad.
        "continuous_tolerance_rad": Number(q::TOLERANCE_RAD);
        /// Limit on the wall-clock time of the plan. Default: none.
        "time_limit_s": Number(q::DURATION);
        /// Iteration limit of one Newton run, and of the subproblems of one convex run. Default: 60.
        "max_iterations": Count(1, 1_000_000);
        /// Whether the extremal and its rivals are tested to second order; skipped: what is found may be a saddle, and
        /// the plan says that it was not tested. Default: tested.
        "second_order": Choice(&["tested", "skipped"], &[]);
    }

    static ENVIRONMENT[selector: Some("kind")] {
        /// Which environment.
        "kind": Choice(&["uniform_gravity", "gravity_gradient", "central_gravity"], &[]),
            needed "kind = \"gravity_gradient\"";
        /// Mass of the body on its pivot.
        "mass_kg": Number(q::MASS), only UNIFORM, needed "mass_kg = 1";
        /// Acceleration of gravity.
        "gravity_m_s2": Number(q::GRAVITY), only UNIFORM, needed "gravity_m_s2 = 9.81";
        /// Direction of gravity, reference frame; any length.
        "direction": Vector(q::COMPONENT), only UNIFORM, needed "direction = [0, 0, 1]";
        /// From the pivot to the mass center, body axes.
        "pivot_to_mass_center_m": Vector(q::LENGTH), only UNIFORM,
            needed "pivot_to_mass_center_m = [0, 0, 0.3]";
        /// Orbital rate. Attitudes are then relative to LVLH: e1 along the velocity, e2 the orbit normal, e3
        /// radially outward. `lvlh_axes` chooses others.
        "orbital_rate_rad_s": Number(q::ORBITAL_RATE), only GRADIENT, needed "orbital_rate_rad_s = 0.00116";
        /// Axes in which this spec tells attitudes and directions: velocity_normal_outward as above, or
        /// velocity_antinormal_nadir, x along the velocity, y against the orbit normal, z to nadir. The plan file tells
        /// them in the first. Default: velocity_normal_outward.
        "lvlh_axes": Choice(&["velocity_normal_outward", "velocity_antinormal_nadir"], &[]), only GRADIENT;
        /// Gravitational parameter of the point mass at the origin.
        "gravitational_parameter_m3_s2": Number(q::GRAVITATIONAL_PARAMETER), only CENTRAL,
            needed "gravitational_parameter_m3_s2 = 3.986e14";
        /// How the body is attracted: as mass points, or to second order in its size.
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
        /// Where the numbers come from.
        "source": Text(2000);
        /// Status of the plan. Default: solved.
        "status": Choice(&["solved", "infeasible", "not_converged", "limit_reached", "verification_failed"], &[]);
        /// The cost.
        "cost": Table(&TOLERANCED);
        /// The cost that was published, in the unit of ours, and its rounding: the plan is not dearer.
        "published": Table(&TOLERANCED);
        /// Bound on the larger of terminal.attitude_rad and terminal.momentum_relative.
        "terminal_error": Number(q::COST);
        /// Bound on the iterations of the winning start, all its rungs.
        "newton_iterations_at_most": Count(1, 1_000_000);
        /// Conjugate points of the plan.
        "conjugate_points": Count(0, 1_000_000);
        /// Cost of the continuous extremal, where time or fuel is minimised: its duration in seconds, or its fuel.
        "continuous_cost": Table(&TOLERANCED);
        /// Number of switches, where time or fuel is minimised.
        "switches": Count(0, 1000);
        /// Bound on the cost still to be gained, to first order, where time or fuel is minimised.
        "gap_at_most": Number(q::COST);
        /// Rotation sense of the plan.
        "sense": Choice(&["short", "long"], &[]);
        /// Bound on the smallest margin of all limits and constraints, relative to the limit or in rad.
        "margin_at_least": Number(q::MARGIN);
        /// Names of exactly those limits and constraints that act.
        "active": Texts(100);
        /// Part of the reason why nothing can meet the terminal conditions.
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
            /// The notations of an attitude. Exactly one is given; `axis` goes with one of the two angles.
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
                /// Of [start] and [end]: a file with attitudes (AEM, APM, STK .a, C-kernel, table), relative to the folder of the spec;
                /// taken at the epoch, or at the end of a given duration.
                "file": Text(1000);
                /// Unit quaternion, scalar first, Hamilton, body to reference.
                "quaternion_wxyz": Quaternion;
                /// Unit quaternion, scalar last, Hamilton, body to reference.
                "quaternion_xyzw": Quaternion;
                /// Modified Rodrigues parameters, axis times tan(angle/4); those longer than 1 are their shadow, one attitude.
                "mrp": Vector(q::COMPONENT);
                /// Rodrigues parameters (Gibbs vector), axis times tan(angle/2).
                "rodrigues": Vector(q::COMPONENT);
                /// Right ascension of the body's x axis, from the x axis of the reference frame towards y; with dec_deg and roll_deg.
                "ra_deg": Number(q::ANGLE_DEG);
                /// Declination of the body's x axis, towards z of the reference frame.
                "dec_deg": Number(q::ANGLE_DEG);
                /// Roll about the body's x axis, R = Rz(ra) Ry(-dec) Rx(roll): at 0 the body's y axis lies in the xy plane and z is to the north.
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

// Axes by letters, and by numbers, as spacecraft engineers write them: 321 is zyx.
attitude_keys! {
    "xyz" "xzy" "yxz" "yzx" "zxy" "zyx" "xyx" "xzx" "yxy" "yzy" "zxz" "zyz"
    "123" "132" "213" "231" "312" "321" "121" "131" "212" "232" "313" "323"
}
