//! Identity of a maneuver: the names and the epoch that files for other programs carry.

use super::epoch::Epoch;
use super::scenery::Scenery;
use slewkit::Vector3;

/// Names, epoch and surroundings of a maneuver; none of them changes a plan.
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
    /// NAIF number of the spacecraft, which is negative, or of another object.
    pub spice_id: Option<i32>,
    /// Names of the inputs, in the order of the inputs; empty if they have numbers only.
    pub inputs: Vec<String>,
    /// Thrusters of an attitude maneuver that the spec defines by position and force, in their
    /// order; empty if a thruster is defined by its torque. The inputs of the plan are the torques
    /// of these thrusters.
    pub nozzles: Vec<Nozzle>,
    /// Named boresights of the spec.
    pub boresights: Vec<Boresights>,
    /// Surroundings of the spacecraft, if the spec has a named target.
    pub scenery: Option<Scenery>,
}

/// One or several boresights that share a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Boresights {
    /// Name of the boresights.
    pub name: String,
    /// Unit vectors along the boresights, in body axes.
    pub vectors: Vec<Vector3>,
}

/// Tolerance per component within which two boresights count as equal.
const SAME_BORESIGHT: f64 = 1e-9;

/// A thruster, as defined in the spec.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nozzle {
    /// Position relative to the center of mass, in body axes \[m\].
    pub position: Vector3,
    /// Direction of the force on the body, as a unit vector in body axes.
    pub direction: Vector3,
    /// Largest force of the thruster \[N\].
    pub force_limit: f64,
    /// Price of the impulse of the thruster in the fuel cost \[1/(N·s)\].
    pub price: f64,
}

impl Nozzle {
    /// Returns the lever arm about the center of mass \[m\], the ratio of torque to force.
    pub fn lever(&self) -> f64 {
        self.position.cross(&self.direction).norm()
    }
}

impl Identity {
    /// Default name of the body frame: the first frame of a spacecraft.
    pub const BODY_FRAME: &'static str = "SC_BODY_1";
    /// Default name of the reference frame.
    pub const REFERENCE_FRAME: &'static str = "ICRF";

    /// Returns the name of the body frame, or its default.
    pub fn body_frame(&self) -> &str {
        self.body_frame.as_deref().unwrap_or(Self::BODY_FRAME)
    }

    /// Returns the names of the body frame and the reference frame as a text for messages, if the
    /// spec names at least one of them.
    pub fn frames(&self) -> Option<String> {
        let named = self.body_frame.is_some() || self.reference_frame.is_some();
        let of = |frame: &Option<String>, other: &str| frame.clone().unwrap_or(other.into());
        let (from, to) =
            (of(&self.body_frame, "body axes"), of(&self.reference_frame, "the reference frame"));
        named.then(|| format!("from {from} to {to}"))
    }

    /// Returns the name of the input `index`, if it has a name; forces precede torques.
    pub fn input(&self, index: usize) -> Option<&str> {
        self.inputs.get(index).map(String::as_str)
    }

    /// Returns the name of a boresight, given as a unit vector in body axes, if it has a name.
    /// Boresights that share a name are numbered from 1.
    pub fn boresight(&self, boresight: &Vector3) -> Option<String> {
        self.boresights.iter().find_map(|Boresights { name, vectors }| {
            let at = vectors.iter().position(|vector| (vector - boresight).amax() < SAME_BORESIGHT)?;
            Some(if vectors.len() > 1 { format!("{name} {}", at + 1) } else { name.clone() })
        })
    }

    /// Returns the name that the boresights `wanted` share, if a name denotes exactly these
    /// boresights.
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
