//! Identity of a maneuver: its names and its epoch, which files for other programs contain.

use super::epoch::Epoch;
use super::scenery::Scenery;
use slewkit::Vector3;

/// Names, epoch and surroundings of a maneuver, none of which affects the plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identity {
    /// Date and time of time zero.
    pub epoch: Option<Epoch>,
    /// Name of the spacecraft or other object that rotates.
    pub object: Option<String>,
    /// International designator of the spacecraft, or another identifier.
    pub object_id: Option<String>,
    /// Name of the central body, such as a planet.
    pub center: Option<String>,
    /// Name of the reference frame; attitudes map from the body frame to this frame.
    pub reference_frame: Option<String>,
    /// Name of the body frame; attitudes map from this frame to the reference frame.
    pub body_frame: Option<String>,
    /// Name of the issuer of the files.
    pub originator: Option<String>,
    /// NAIF number of the object, which is negative for a spacecraft.
    pub spice_id: Option<i32>,
    /// Names of the inputs, in the order of the inputs; empty if the spec does not name them.
    pub inputs: Vec<String>,
    /// Thrusters of an attitude maneuver, in the order of the spec, if the spec defines them by
    /// position and force. The inputs of the plan are the torques of these thrusters. The list is
    /// empty if a thruster is defined by its torque.
    pub nozzles: Vec<Nozzle>,
    /// Boresights that have a name in the spec.
    pub boresights: Vec<Boresights>,
    /// Surroundings of the spacecraft, if the spec has a named target.
    pub scenery: Option<Scenery>,
}

/// One or several boresights with a common name.
#[derive(Clone, Debug, PartialEq)]
pub struct Boresights {
    /// Common name of the boresights.
    pub name: String,
    /// Unit vectors along the boresights, in body axes.
    pub vectors: Vec<Vector3>,
}

/// Largest difference of a component between two boresights that count as equal.
const SAME_BORESIGHT: f64 = 1e-9;

/// A thruster that the spec defines by position and force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nozzle {
    /// Position of the thruster relative to the center of mass, in body axes \[m\].
    pub position: Vector3,
    /// Direction of the force on the body, as a unit vector in body axes.
    pub direction: Vector3,
    /// Largest force of the thruster \[N\].
    pub force_limit: f64,
    /// Price of the thruster's impulse in the fuel cost \[1/(N·s)\].
    pub price: f64,
}

impl Nozzle {
    /// Returns the lever arm of the force about the center of mass \[m\], which is the ratio of
    /// torque to force.
    pub fn lever(&self) -> f64 {
        self.position.cross(&self.direction).norm()
    }
}

impl Identity {
    /// Default name of the body frame, which is the name of the first body frame of a spacecraft.
    pub const BODY_FRAME: &'static str = "SC_BODY_1";
    /// Default name of the reference frame.
    pub const REFERENCE_FRAME: &'static str = "ICRF";

    /// Returns the name of the body frame, or its default.
    pub fn body_frame(&self) -> &str {
        self.body_frame.as_deref().unwrap_or(Self::BODY_FRAME)
    }

    /// Returns a text with the names of the body frame and the reference frame, for messages;
    /// `None` if the spec names neither frame.
    pub fn frames(&self) -> Option<String> {
        let named = self.body_frame.is_some() || self.reference_frame.is_some();
        let of = |frame: &Option<String>, other: &str| frame.clone().unwrap_or(other.into());
        let (from, to) =
            (of(&self.body_frame, "body axes"), of(&self.reference_frame, "the reference frame"));
        named.then(|| format!("from {from} to {to}"))
    }

    /// Returns the name of input `index`, counting forces before torques; `None` if it has no name.
    pub fn input(&self, index: usize) -> Option<&str> {
        self.inputs.get(index).map(String::as_str)
    }

    /// Returns the name of `boresight`, a unit vector in body axes; `None` if it has no name. If
    /// several boresights share a name, a number counted from 1 is appended.
    pub fn boresight(&self, boresight: &Vector3) -> Option<String> {
        self.boresights.iter().find_map(|Boresights { name, vectors }| {
            let at = vectors.iter().position(|vector| (vector - boresight).amax() < SAME_BORESIGHT)?;
            Some(if vectors.len() > 1 { format!("{name} {}", at + 1) } else { name.clone() })
        })
    }

    /// Returns the common name of the boresights `wanted`; `None` unless a name denotes exactly
    /// these boresights.
    pub(crate) fn boresights(&self, wanted: &[Vector3]) -> Option<&str> {
        let same = |(a, b): (&Vector3, &Vector3)| (a - b).amax() < SAME_BORESIGHT;
        let named = self.boresights.iter().find(|Boresights { vectors, .. }| {
            vectors.len() == wanted.len() && vectors.iter().zip(wanted).all(same)
        });
        named.map(|named| named.name.as_str())
    }

    /// Returns the name of the reference frame, or its default.
    pub fn reference_frame(&self) -> &str {
        self.reference_frame.as_deref().unwrap_or(Self::REFERENCE_FRAME)
    }
}
