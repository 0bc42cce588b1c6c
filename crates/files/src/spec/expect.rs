//! `[expect]`: the required result of a plan or a motion; the tests of a collection of problems
//! read it.

use super::attitude::{self, Use};
use super::{Section, cut};
use slewkit::maneuver::Sense;
use slewkit::{Matrix3, Vector3};

/// A required number and its tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toleranced {
    /// The number.
    pub value: f64,
    /// Largest accepted difference.
    pub tolerance: f64,
}

/// `[expect]`: the required result of the plan of a shipped problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Expect {
    /// The source of the numbers.
    pub source: Option<String>,
    /// The status of the plan; `solved` by default.
    pub status: String,
    /// Cost.
    pub cost: Option<Toleranced>,
    /// The published cost, in the unit of ours, and its rounding: the plan must not cost more.
    pub published: Option<Toleranced>,
    /// Bound on the larger of attitude error in rad and relative momentum error at the end.
    pub terminal_error: Option<f64>,
    /// Bound on the Newton iterations of the winning start, over its whole fallback sequence.
    pub newton_iterations_at_most: Option<usize>,
    /// Conjugate points of the plan.
    pub conjugate_points: Option<usize>,
    /// Cost of the continuous extremal, where time or fuel is minimised.
    pub continuous_cost: Option<Toleranced>,
    /// Number of switches, where time or fuel is minimised.
    pub switches: Option<usize>,
    /// Bound on the gap, where time or fuel is minimised.
    pub gap_at_most: Option<f64>,
    /// Rotation sense of the plan.
    pub sense: Option<Sense>,
    /// Costs of other extremals that must be found.
    pub rivals: Vec<Toleranced>,
    /// Bound on the smallest scaled margin of all limits and constraints.
    pub margin_at_least: Option<f64>,
    /// The names of all active limits and constraints.
    pub active: Option<Vec<String>>,
    /// The names of the stops in the order in which they are visited.
    pub order: Option<Vec<String>>,
    /// Part of the reason why nothing can meet the terminal conditions.
    pub because: Option<String>,
}

/// `[expect]` of a simulation: the required result of the motion of a shipped problem.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulationExpect {
    /// The source of the numbers.
    pub source: Option<String>,
    /// Energy at the start \[J\].
    pub energy: Option<Toleranced>,
    /// Bound on the error of the energy, relative to the energy at the start.
    pub energy_error_at_most: Option<f64>,
    /// Bound on the change of the angular momentum, relative to the one at the start.
    pub angular_momentum_error_at_most: Option<f64>,
    /// Bound on the change of the linear momentum, relative to the sum of the sizes of all at the
    /// start.
    pub linear_momentum_error_at_most: Option<f64>,
    /// Bound on `‖I − RᵀR‖` of every body.
    pub orthogonality_at_most: Option<f64>,
    /// States at the end.
    pub end: Vec<EndExpect>,
    /// Mean rate of a body axis about a direction.
    pub precession: Option<Precession>,
    /// Mean period of a body axis that swings.
    pub oscillation: Option<Oscillation>,
}

/// State of one body at the end, each with the largest accepted distance from it (SI units,
/// radians).
#[derive(Clone, Debug, PartialEq)]
pub struct EndExpect {
    /// The index of the body, from 0.
    pub body: usize,
    /// Attitude, body → reference.
    pub attitude: Option<(Matrix3, f64)>,
    /// Angular velocity, body axes [rad/s].
    pub angular_velocity: Option<(Vector3, f64)>,
    /// Position, reference frame \[m\].
    pub position: Option<(Vector3, f64)>,
    /// Velocity, reference frame [m/s].
    pub velocity: Option<(Vector3, f64)>,
}

/// The mean rate of a body axis about a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precession {
    /// The index of the body, from 0.
    pub body: usize,
    /// The axis, body axes, any length.
    pub axis: Vector3,
    /// The axis of its rotation, reference frame, any length.
    pub about: Vector3,
    /// Mean rate [rad/s].
    pub rate: Toleranced,
}

/// The mean period of a body axis that swings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// The index of the body, from 0.
    pub body: usize,
    /// The axis, body axes, any length.
    pub axis: Vector3,
    /// The direction along which its component is observed, reference frame, any length.
    pub direction: Vector3,
    /// Mean time between upward passages of that component through zero \[s\].
    pub period: Toleranced,
}

impl Toleranced {
    /// Builds a table of a value and its tolerance.
    fn read(section: &Section) -> Option<Self> {
        Some(Self { value: section.number("value")?, tolerance: section.number("tolerance")? })
    }
}

impl Section {
    /// Returns the number under `name`, and its tolerance.
    pub fn toleranced(&self, name: &str) -> Option<Toleranced> {
        self.section(name).and_then(Toleranced::read)
    }
}

/// Reads `[expect]` and checks it alone: it does not affect the plan.
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

/// The keys of `[[expect.end]]`, and their tolerances.
const TOLERATED: [(&str, &str); 4] = [
    ("attitude", "attitude_tolerance_rad"),
    ("angular_velocity_rad_s", "angular_velocity_tolerance_rad_s"),
    ("position_m", "position_tolerance_m"),
    ("velocity_m_s", "velocity_tolerance_m_s"),
];

/// Reads `[expect]` of a simulation of bodies with these names; `None` if it names an unknown
/// body.
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
