//! Pointing files, which describe a timeline of observations: pointing timeline requests of ESA
//! (PTR), and pointing request messages of CCSDS (PRM, 509.0-B-1).
//!
//! An observation points a body axis `b`, the boresight, in a direction `d`. The roll about `d` is
//! either free or defined by a second body axis `a`, an inertial axis `i` and a phase angle φ. Both
//! axes are projected onto the plane normal to `d`. The phase angle is the angle about `d` from the
//! projection of `i` to the projection of `a`. If φ = 0, the body axis is as close to the inertial
//! axis as the boresight allows. The triad `s` is built from `b, a`, and the triad `t` from `d, i`.
//! The attitude is
//!
//! ```text
//! R = exp(φ d^) [t₁ t₂ t₃][s₁ s₂ s₃]ᵀ ,   t₁ = d ,   t₂ = d × i / |d × i| ,   t₃ = t₁ × t₂ ,
//! ```
//!
//! which maps body components to reference components. ESA's engine (OSVE with AGM) uses the
//! transpose.
//!
//! The spacecraft slews between two observations. A file may have blocks for the slews, which
//! contain no data. The reader checks them, and the writer adds one between any two observations.
//!
//! # Which subset of the formats is read?
//!
//! The reader supports inertial targets and, in a PRM, also the Sun (templates 4.2 and 4.3). Every
//! other construct is rejected with its element and its line, because ignoring a part of the file
//! would change the timeline. A PTR must be acceptable to OSVE 2.9.0; `tests/exchange/pointing.py`
//! runs OSVE.

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

/// Observations of a spacecraft in chronological order, with the names of the spacecraft and of the
/// frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointingFile {
    /// Name of the spacecraft.
    pub object: Option<String>,
    /// International designator of the spacecraft, or another identifier.
    pub object_id: Option<String>,
    /// Name of the inertial frame in which targets and inertial axes are given.
    pub reference_frame: String,
    /// Name of the body frame in which boresights and body axes are given.
    pub body_frame: String,
    /// Name of the orbit file of the spacecraft, which determines the direction to the Sun (PRM
    /// only).
    pub orbit: Option<String>,
    /// Observations in chronological order.
    pub observations: Vec<Observation>,
    /// Statements of the file that were ignored, and assumptions of the reader, one sentence each,
    /// without the final period.
    pub not_taken: Vec<String>,
}

/// An observation: a time interval in which a boresight points at a target.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Name of the observation, which has no effect; `None` if the file does not name it.
    pub name: Option<String>,
    /// Start of the observation, at which the slew has ended and the spacecraft is at rest.
    pub begin: Epoch,
    /// End of the observation.
    pub end: Epoch,
    /// Boresight, as a unit vector in body axes.
    pub boresight: Vector3,
    /// Target at which the boresight points.
    pub target: Target,
    /// Roll about the boresight.
    pub roll: Roll,
}

/// Target of an observation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// A direction, as a unit vector in the axes of the reference frame.
    Inertial(Vector3),
    /// The Sun, whose direction is computed from the time.
    Sun,
}

/// Roll of the spacecraft during an observation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roll {
    /// The roll is free.
    Free,
    /// The phase angle between a body axis and an inertial axis defines the roll.
    Referred {
        /// Body axis, as a unit vector in body axes.
        body_axis: Vector3,
        /// Inertial axis, as a unit vector in the axes of the reference frame.
        inertial_axis: Vector3,
        /// Phase angle about the direction of the target, from the projection of the inertial axis
        /// to the projection of the body axis \[rad\].
        angle: f64,
    },
}

/// Smallest sine of the angle between a boresight and the body axis that defines the roll, and
/// between the target direction and the inertial axis. At smaller angles, the roll has fewer than
/// ten significant digits.
const LEAST_APART: f64 = 1e-6;

impl Observation {
    /// Returns the rotation from body to reference components if the direction of the target is
    /// `target`. Returns `None` if the roll is free, or if the axes that define it are parallel.
    pub fn attitude(&self, target: &Vector3) -> Option<Matrix3> {
        let Roll::Referred { body_axis, inertial_axis, angle } = self.roll else { return None };
        let body = triad(&self.boresight, &body_axis)?;
        let inertial = triad(target, &inertial_axis)?;
        Some(lie::exp(&(angle * target)) * inertial * body.transpose())
    }

    /// Returns the observation with a fixed attitude, the rotation from body to reference
    /// components. The direction of the boresight in this attitude becomes the target, and a body
    /// axis defines the roll.
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

    /// Returns the duration of the observation \[s\].
    pub fn lasting(&self) -> f64 {
        self.end.since(&self.begin)
    }
}

impl PointingFile {
    /// Returns the file with its inertial directions expressed in the frame `name`; `None` if the
    /// rotation between the two frames is unknown.
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

    /// Checks that the observations can be written: directions must be unit vectors, rolls must be
    /// defined, and times must increase.
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

/// Reads a pointing file, which is a PTR or a PRM. `name` is the name of the file in messages.
///
/// # Errors
/// Returns the first error with its line: invalid XML, a construct that is not supported, or
/// overlapping observations.
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

/// Checks that the observation `next` begins after the end of the previous one; `at` is the text of
/// its start time, for messages.
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

/// Returns the unit vector along a vector; `None` for a zero vector.
fn unit(vector: Vector3) -> Option<Vector3> {
    let largest = vector.amax();
    if largest == 0.0 || !largest.is_finite() {
        return None;
    }
    // A vector of unit length is not changed, so that a written vector reads back to the same bits.
    let length = vector.norm();
    if (length - 1.0).abs() <= 2.0 * f64::EPSILON {
        return Some(vector);
    }
    // The vector is scaled first, so that the squares of its components neither overflow nor
    // underflow.
    Some((vector / largest).normalize())
}

/// Returns the triad of the module header as the columns `t₁ t₂ t₃` of a matrix, with t₁ along
/// `first` and t₂ along `first × second`. Returns `None` if the two directions are parallel.
fn triad(first: &Vector3, second: &Vector3) -> Option<Matrix3> {
    let normal = first.cross(second);
    let length = normal.norm();
    (length > LEAST_APART).then(|| {
        let normal = normal / length;
        Matrix3::from_columns(&[*first, normal, first.cross(&normal)])
    })
}
