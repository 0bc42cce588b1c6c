//! Reading of `[expect]`, the required result of a plan or a simulation, which the tests of the
//! collection of problems check.

use super::attitude::{self, Use};
use super::{Section, cut};
use slewkit::maneuver::Sense;
use slewkit::{Matrix3, Vector3};

/// A required number and its tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toleranced {
    /// Required value.
    pub value: f64,
    /// Largest accepted absolute difference from the required value.
    pub tolerance: f64,
}

/// Required result of the plan of a maneuver or a sequence, from `[expect]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Expect {
    /// Source of the required numbers, such as a publication.
    pub source: Option<String>,
    /// Required status of the plan; the default is `solved`.
    pub status: String,
    /// Required cost of the plan.
    pub cost: Option<Toleranced>,
    /// Published cost in the unit of `cost`, with its rounding as the tolerance. The plan must not
    /// have a higher cost.
    pub published: Option<Toleranced>,
    /// Upper bound on the terminal error, which is the larger of the attitude error \[rad\] and the
    /// relative momentum error.
    pub terminal_error: Option<f64>,
    /// Upper bound on the number of Newton iterations from the initial guess that led to the plan,
    /// in all strategies of its fallback sequence.
    pub newton_iterations_at_most: Option<usize>,
    /// Required number of conjugate points of the plan.
    pub conjugate_points: Option<usize>,
    /// Required cost of the extremal in continuous time, for minimum time and minimum fuel.
    pub continuous_cost: Option<Toleranced>,
    /// Required number of switches of the inputs, for minimum time and minimum fuel.
    pub switches: Option<usize>,
    /// Upper bound on the optimality gap, for minimum time and minimum fuel.
    pub gap_at_most: Option<f64>,
    /// Required direction of rotation of the plan: the short or the long way.
    pub sense: Option<Sense>,
    /// Costs of other extremals that must be found.
    pub rivals: Vec<Toleranced>,
    /// Lower bound on the smallest scaled margin to any limit or constraint.
    pub margin_at_least: Option<f64>,
    /// Names of the limits and constraints that must be active; no others may be active.
    pub active: Option<Vec<String>>,
    /// Required order of the visit, as the names of the stops.
    pub order: Option<Vec<String>>,
    /// Text that the reason must contain for which the terminal conditions cannot be met.
    pub because: Option<String>,
}

/// Required result of a simulation, from `[expect]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulationExpect {
    /// Source of the required numbers, such as a publication.
    pub source: Option<String>,
    /// Required energy at the start \[J\].
    pub energy: Option<Toleranced>,
    /// Upper bound on the energy error as a fraction of the energy at the start.
    pub energy_error_at_most: Option<f64>,
    /// Upper bound on the change of the angular momentum as a fraction of its norm at the start.
    pub angular_momentum_error_at_most: Option<f64>,
    /// Upper bound on the change of the linear momentum, as a fraction of the sum of the momentum
    /// norms of all bodies at the start.
    pub linear_momentum_error_at_most: Option<f64>,
    /// Upper bound on the orthogonality error `‖I − RᵀR‖` of the attitude of every body.
    pub orthogonality_at_most: Option<f64>,
    /// Required states of bodies at the end.
    pub end: Vec<EndExpect>,
    /// Required mean rate of a body axis about a direction.
    pub precession: Option<Precession>,
    /// Required mean period of an oscillating body axis.
    pub oscillation: Option<Oscillation>,
}

/// Required state of one body at the end, in SI units and radians. Each quantity is given with the
/// largest accepted distance from it.
#[derive(Clone, Debug, PartialEq)]
pub struct EndExpect {
    /// Index of the body, counted from 0.
    pub body: usize,
    /// Required rotation matrix from body to reference components, and the largest accepted angle
    /// from it \[rad\].
    pub attitude: Option<(Matrix3, f64)>,
    /// Required angular velocity in body axes, and the largest accepted difference \[rad/s\].
    pub angular_velocity: Option<(Vector3, f64)>,
    /// Required position in the reference frame, and the largest accepted difference \[m\].
    pub position: Option<(Vector3, f64)>,
    /// Required velocity in the reference frame, and the largest accepted difference \[m/s\].
    pub velocity: Option<(Vector3, f64)>,
}

/// Required mean rate of a body axis about a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precession {
    /// Index of the body, counted from 0.
    pub body: usize,
    /// The rotating axis, as a vector of any length in body axes.
    pub axis: Vector3,
    /// Direction about which the axis rotates, as a vector of any length in the reference frame.
    pub about: Vector3,
    /// Required mean rate of the axis about the direction \[rad/s\].
    pub rate: Toleranced,
}

/// Required mean period of an oscillating body axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Index of the body, counted from 0.
    pub body: usize,
    /// The oscillating axis, as a vector of any length in body axes.
    pub axis: Vector3,
    /// Direction along which the component of the axis is observed, as a vector of any length in
    /// the reference frame.
    pub direction: Vector3,
    /// Required mean time between upward zero crossings of this component \[s\].
    pub period: Toleranced,
}

impl Toleranced {
    /// Reads a table with a value and its tolerance.
    fn read(section: &Section) -> Option<Self> {
        Some(Self { value: section.number("value")?, tolerance: section.number("tolerance")? })
    }
}

impl Section {
    /// Returns the number and the tolerance in the table `name`; `None` if the table is absent.
    pub fn toleranced(&self, name: &str) -> Option<Toleranced> {
        self.section(name).and_then(Toleranced::read)
    }
}

/// Reads `[expect]` of a maneuver or a sequence, which does not affect the plan.
pub(crate) fn of_maneuver(section: &Section) -> Expect {
    Expect {
        source: section.word("source").map(str::to_string),
        status: section.word("status").unwrap_or("solved").to_string(),
        cost: section.toleranced("cost"),
        published: section.toleranced("published"),
        terminal_error: section.number("terminal_error"),
        newton_iterations_at_most: section.count("newton_iterations_at_most"),
        conjugate_points: section.count("conjugate_points"),
        continuous_cost: section.toleranced("continuous_cost"),
        switches: section.count("switches"),
        gap_at_most: section.number("gap_at_most"),
        sense: section.word("sense").map(|word| if word == "long" { Sense::Long } else { Sense::Short }),
        rivals: section.list("rivals").iter().filter_map(Toleranced::read).collect(),
        margin_at_least: section.number("margin_at_least"),
        active: section.texts("active"),
        order: section.texts("order"),
        because: section.word("because").map(str::to_string),
    }
}

/// Keys of the required quantities in `[[expect.end]]`, each with the key of its tolerance.
const TOLERATED: [(&str, &str); 4] = [
    ("attitude", "attitude_tolerance_rad"),
    ("angular_velocity_rad_s", "angular_velocity_tolerance_rad_s"),
    ("position_m", "position_tolerance_m"),
    ("velocity_m_s", "velocity_tolerance_m_s"),
];

/// Reads `[expect]` of a simulation whose bodies have the names `names`. Returns `None` if it
/// refers to an unknown body.
pub(crate) fn of_simulation(section: &Section, names: &[&str]) -> Option<SimulationExpect> {
    let body = |section: &Section| {
        let named = section.word("body");
        let found = match named {
            Some(name) => names.iter().position(|other| *other == name),
            None => (names.len() == 1 && !section.has("body")).then_some(0),
        };
        found.or_else(|| {
            let names: Vec<_> = names.iter().take(6).map(|name| cut(name, 40)).collect();
            let reason = match named {
                Some(name) => format!("no body is called \"{}\"", cut(name, 40)),
                None => format!("[{}] does not name a body", section.path),
            };
            section.refuse("E0021", "body", reason, format!("give body = one of {}", names.join(", ")))
        })
    };
    let mut bodies = Vec::new();
    for end in section.list("end") {
        for (name, tolerance) in TOLERATED {
            if end.has(name) != end.has(tolerance) {
                let (given, missing) = if end.has(name) { (name, tolerance) } else { (tolerance, name) };
                let reason = format!("`{given}` needs `{missing}`");
                end.error("E0021", given, reason, "give both, or remove it");
            }
        }
        bodies.push(body(end)?);
    }
    let precession = match section.section("precession") {
        Some(inner) => Some(Precession {
            body: body(inner)?,
            axis: inner.vector("axis_body")?,
            about: inner.vector("about_reference")?,
            rate: inner.toleranced("rate_rad_s")?,
        }),
        None => None,
    };
    let oscillation = match section.section("oscillation") {
        Some(inner) => Some(Oscillation {
            body: body(inner)?,
            axis: inner.vector("axis_body")?,
            direction: inner.vector("direction_reference")?,
            period: inner.toleranced("period_s")?,
        }),
        None => None,
    };
    let [attitude, angular_velocity, position, velocity] = TOLERATED;
    let end = |(body, end): (usize, &Section)| {
        let tolerated = |(name, tolerance)| end.vector(name).zip(end.number(tolerance));
        let rotation = end.section(attitude.0).and_then(|it| attitude::rotation(it, Use::Attitude));
        EndExpect {
            body,
            attitude: rotation.map(|rotation| rotation.matrix).zip(end.number(attitude.1)),
            angular_velocity: tolerated(angular_velocity),
            position: tolerated(position),
            velocity: tolerated(velocity),
        }
    };
    Some(SimulationExpect {
        source: section.word("source").map(str::to_string),
        energy: section.toleranced("energy_j"),
        energy_error_at_most: section.number("energy_error_at_most"),
        angular_momentum_error_at_most: section.number("angular_momentum_error_at_most"),
        linear_momentum_error_at_most: section.number("linear_momentum_error_at_most"),
        orthogonality_at_most: section.number("orthogonality_at_most"),
        end: bodies.into_iter().zip(section.list("end")).map(end).collect(),
        precession,
        oscillation,
    })
}
