//! Pointing files: timelines of observations, as ESA's PTR and as pointing request messages of
//! CCSDS (PRM, 509.0-B-1).
//!
//! An observation points a body axis `b`, the boresight, at a direction `d`. Its roll is free, or a
//! second body axis `a` is turned from an inertial axis `i` by an angle φ about `d`, both projected
//! onto the plane normal to `d`. If φ = 0, the body axis is as near to the inertial axis as the
//! boresight allows. The vectors `s` are built from `b, a` like `t` from `d, i`. The attitude is
//!
//! ```text
//! R = exp(φ d^) [t₁ t₂ t₃][s₁ s₂ s₃]ᵀ ,   t₁ = d ,   t₂ = d × i / |d × i| ,   t₃ = t₁ × t₂ ,
//! ```
//!
//! from body to reference components. ESA's engine (OSVE with AGM) has its transpose.
//!
//! Between two observations the spacecraft slews. A file may have separate blocks for the slews.
//! They contain no data, so they are checked when a file is read, and written between the
//! observations.
//!
//! # Which subset is read?
//!
//! Inertial targets, and of PRM the Sun (templates 4.2 and 4.3). Every other construct is refused
//! with its element and its line, because a timeline that is read in part is another timeline. A
//! PTR must be one that OSVE 2.9.0 accepts; `tests/exchange/pointing.py` runs OSVE.

mod prm;
mod ptr;
mod stops;
#[cfg(test)]
mod tests;
mod tree;

pub use stops::Timeline;

use crate::epoch::Epoch;
use crate::exchange::frames::{Meaning, meaning};
use crate::exchange::{Lacking, Piece, Wrong, elements, whole_text};
use crate::export::ExportError;
use crate::spec::{Diagnostics, Source};
use slewkit::{Matrix3, Vector3, lie};
use std::io::Read;

/// The observations of a spacecraft, in the order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointingFile {
    /// The name of the spacecraft.
    pub object: Option<String>,
    /// The international designator of the spacecraft, or another identifier.
    pub object_id: Option<String>,
    /// The inertial frame of targets and inertial axes.
    pub reference_frame: String,
    /// The frame of boresights and body axes.
    pub body_frame: String,
    /// The file with the orbit of the spacecraft, from which the Sun is seen (PRM).
    pub orbit: Option<String>,
    /// The observations.
    pub observations: Vec<Observation>,
    /// The statements of the file that are not used, and the choices that its reader made, a
    /// sentence each without its point.
    pub not_taken: Vec<String>,
}

/// A boresight points at a target, from one moment to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The name, for readers of the file.
    pub name: Option<String>,
    /// The start of the observation: the spacecraft is at rest.
    pub begin: Epoch,
    /// The end of the observation.
    pub end: Epoch,
    /// The boresight, a unit vector in body axes.
    pub boresight: Vector3,
    /// The target.
    pub target: Target,
    /// The roll about the boresight.
    pub roll: Roll,
}

/// A target of an observation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// A direction, a unit vector in axes of the reference frame.
    Inertial(Vector3),
    /// The Sun.
    Sun,
}

/// The roll of an observation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roll {
    /// Any.
    Free,
    /// A body axis is turned from an inertial axis by an angle about the target.
    Referred {
        /// The body axis, a unit vector in body axes.
        body_axis: Vector3,
        /// The inertial axis, a unit vector in axes of the reference frame.
        inertial_axis: Vector3,
        /// The angle about the target \[rad\], in the plane normal to it, from the inertial axis to
        /// the body axis.
        angle: f64,
    },
}

/// The sine of the least angle between a boresight and the body axis of its roll, and between a
/// target and the inertial axis: the roll that two nearer axes define has fewer than ten digits.
const LEAST_APART: f64 = 1e-6;

impl Observation {
    /// Returns the attitude, from body to reference components, with the target in the direction
    /// `target`; `None` if the roll is free, or if the axes that define it are parallel.
    pub fn attitude(&self, target: &Vector3) -> Option<Matrix3> {
        let Roll::Referred { body_axis, inertial_axis, angle } = self.roll else { return None };
        let body = triad(&self.boresight, &body_axis)?;
        let inertial = triad(target, &inertial_axis)?;
        Some(lie::exp(&(angle * target)) * inertial * body.transpose())
    }

    /// Returns the observation in a given attitude, from body to reference components: the target
    /// is where the boresight points, and the roll is referred to a body axis.
    pub fn in_attitude(&self, attitude: &Matrix3) -> Self {
        let body_axis = Matrix3::identity().column(self.boresight.iamin()).into_owned();
        Self {
            target: Target::Inertial(unit(attitude * self.boresight).unwrap_or(self.boresight)),
            roll: Roll::Referred {
                body_axis,
                inertial_axis: unit(attitude * body_axis).unwrap_or(body_axis),
                angle: 0.0,
            },
            ..self.clone()
        }
    }

    /// Returns the duration \[s\].
    pub fn lasting(&self) -> f64 {
        self.end.since(&self.begin)
    }
}

impl PointingFile {
    /// Returns the file with its inertial directions in another frame; `None` if the rotation
    /// between the two frames is unknown.
    pub fn in_frame(&self, name: &str) -> Option<Self> {
        if self.reference_frame.eq_ignore_ascii_case(name) {
            return Some(self.clone());
        }
        let (Meaning::Inertial(from), Meaning::Inertial(to)) =
            (meaning(&self.reference_frame), meaning(name))
        else {
            return None;
        };
        let rotation = to.transpose() * from;
        let turned = |vector: &Vector3| if from == to { *vector } else { rotation * vector };
        let mut found = Self { reference_frame: name.into(), ..self.clone() };
        for observation in &mut found.observations {
            if let Target::Inertial(direction) = &mut observation.target {
                *direction = turned(direction);
            }
            if let Roll::Referred { inertial_axis, .. } = &mut observation.roll {
                *inertial_axis = turned(inertial_axis);
            }
        }
        Some(found)
    }

    /// Refuses observations that no file may contain: directions that are not unit vectors, rolls
    /// that are not defined, or times that do not increase.
    fn check(&self) -> Result<(), ExportError> {
        let unit = |vector: &Vector3| (vector.norm() - 1.0).abs() < crate::rounding::ROTATION;
        let sound = |observation: &Observation| {
            let target = match observation.target {
                Target::Inertial(direction) => unit(&direction),
                Target::Sun => true,
            };
            let roll = match &observation.roll {
                Roll::Free => true,
                Roll::Referred { body_axis, inertial_axis, angle } => {
                    let apart = |axis: &Vector3| observation.boresight.cross(axis).norm() > LEAST_APART;
                    unit(body_axis) && unit(inertial_axis) && angle.is_finite() && apart(body_axis)
                }
            };
            unit(&observation.boresight) && target && roll && observation.lasting() > 0.0
        };
        let follow = self.observations.windows(2).all(|pair| pair[1].begin.since(&pair[0].end) >= 0.0);
        let sound = self.observations.iter().all(sound) && follow && !self.observations.is_empty();
        if sound { Ok(()) } else { Err(Lacking::Observations.into()) }
    }
}

/// Reads a pointing file, a PTR or a PRM; `name` is the name of the file in messages.
///
/// # Errors
/// Returns the first fault with its line: invalid XML, a construct outside of the subset, or
/// observations that overlap.
pub fn read_pointing(input: impl Read, name: &str) -> Result<PointingFile, Diagnostics> {
    let text = whole_text(input, name, "a PTR or a pointing request message (PRM)")?;
    let read = |text: &str| {
        let document = elements::document(text)?;
        let root = document.root_element();
        let told = elements::name(root);
        if told.text != "prm" {
            return told.wrong(
                format!("the file is <{}>: a pointing file is <prm>", crate::spec::cut(told.text, 30)),
                "give a PTR or a pointing request message (PRM)",
            );
        }
        if elements::attribute(root, "id").is_some() { prm::read(root) } else { ptr::read(root) }
    };
    read(&text)
        .map_err(|wrong| Diagnostics(vec![wrong.coded("E0154").resolve(&[Source::new(name, text.as_str())])]))
}

/// Checks that an observation follows the one before; `at` is its begin, for messages.
fn check_order(before: Option<&Observation>, next: &Observation, at: Piece<'_>) -> Result<(), Wrong> {
    if next.lasting() <= 0.0 {
        return at.wrong("the block ends when it begins, or before", "give it an end that is later");
    }
    let Some(before) = before else { return Ok(()) };
    let gap = next.begin.since(&before.end);
    if gap < 0.0 {
        let reason = format!(
            "the block begins {} s before the block above ends",
            slewkit::numerics::figures::short(-gap)
        );
        return at.wrong(reason, "put blocks in the order of time, without overlap");
    }
    Ok(())
}

/// Returns the unit vector along a vector; `None` along a zero vector.
fn unit(vector: Vector3) -> Option<Vector3> {
    let largest = vector.amax();
    if largest == 0.0 || !largest.is_finite() {
        return None;
    }
    // A unit vector keeps its bits, so that a written vector is read back unchanged.
    let length = vector.norm();
    if (length - 1.0).abs() <= 2.0 * f64::EPSILON {
        return Some(vector);
    }
    // Squares of the components neither overflow nor vanish.
    Some((vector / largest).normalize())
}

/// Returns the columns of `t₁ t₂ t₃` of two directions; `None` if they are parallel.
fn triad(first: &Vector3, second: &Vector3) -> Option<Matrix3> {
    let normal = first.cross(second);
    let length = normal.norm();
    (length > LEAST_APART).then(|| {
        let normal = normal / length;
        Matrix3::from_columns(&[*first, normal, first.cross(&normal)])
    })
}
