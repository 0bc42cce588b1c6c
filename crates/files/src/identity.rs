//! The identity of a maneuver: the names and the epoch that files for other programs carry.

use super::epoch::Epoch;
use super::scenery::Scenery;
use slewkit::Vector3;

/// Names and epoch. Nothing in it changes a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identity {
    /// The moment of time zero.
    pub epoch: Option<Epoch>,
    /// The object that turns.
    pub object: Option<String>,
    /// International designator of the spacecraft, or another identifier.
    pub object_id: Option<String>,
    /// The central body: a planet.
    pub center: Option<String>,
    /// The reference frame, to which attitudes map.
    pub reference_frame: Option<String>,
    /// The body frame, from which attitudes map.
    pub body_frame: Option<String>,
    /// The issuer of the files.
    pub originator: Option<String>,
    /// The NAIF number of the object, negative for spacecraft.
    pub spice_id: Option<i32>,
    /// The names of the inputs, in their order; empty for numbers.
    pub inputs: Vec<String>,
    /// The thrusters of an attitude maneuver that the spec states by position and force, in their
    /// order; empty if one is stated by its torque. The inputs of the plan are their torques.
    pub nozzles: Vec<Nozzle>,
    /// The boresights that the spec names.
    pub boresights: Vec<Boresights>,
    /// The surroundings of the spacecraft, if the spec aims at a named target.
    pub scenery: Option<Scenery>,
}

/// Boresights with one name.
#[derive(Clone, Debug, PartialEq)]
pub struct Boresights {
    /// The name.
    pub name: String,
    /// One boresight or several, unit vectors in body axes.
    pub vectors: Vec<Vector3>,
}

/// Boresights whose components differ by less count as equal.
const SAME_BORESIGHT: f64 = 1e-9;

/// A thruster as in the spec.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nozzle {
    /// The position from the mass center, body axes \[m\].
    pub position: Vector3,
    /// The direction of the force on the body, of length 1.
    pub direction: Vector3,
    /// Largest force of the thruster \[N\].
    pub force_limit: f64,
    /// Price of the impulse of the thruster [1/(N·s)].
    pub price: f64,
}

impl Nozzle {
    /// Returns the lever about the mass center \[m\]: torque over force.
    pub fn lever(&self) -> f64 {
        self.position.cross(&self.direction).norm()
    }
}

impl Identity {
    /// The default body frame: the first frame of a spacecraft.
    pub const BODY_FRAME: &'static str = "SC_BODY_1";
    /// The default reference frame.
    pub const REFERENCE_FRAME: &'static str = "ICRF";

    /// Returns the body frame.
    pub fn body_frame(&self) -> &str {
        self.body_frame.as_deref().unwrap_or(Self::BODY_FRAME)
    }

    /// Returns the frames from which and to which attitudes map, if the spec names one of them.
    pub fn frames(&self) -> Option<String> {
        let named = self.body_frame.is_some() || self.reference_frame.is_some();
        let of = |frame: &Option<String>, other: &str| frame.clone().unwrap_or(other.into());
        let (from, to) =
            (of(&self.body_frame, "body axes"), of(&self.reference_frame, "the reference frame"));
        named.then(|| format!("from {from} to {to}"))
    }

    /// Returns the name of the input with this number, forces first, if it has a name.
    pub fn input(&self, index: usize) -> Option<&str> {
        self.inputs.get(index).map(String::as_str)
    }

    /// Returns the name of a boresight, a unit vector in body axes, if it has a name. Boresights
    /// that share a name are numbered from 1.
    pub fn boresight(&self, boresight: &Vector3) -> Option<String> {
        self.boresights.iter().find_map(|Boresights { name, vectors }| {
            let at = vectors.iter().position(|vector| (vector - boresight).amax() < SAME_BORESIGHT)?;
            Some(if vectors.len() > 1 { format!("{name} {}", at + 1) } else { name.clone() })
        })
    }

    /// Returns the common name of several boresights, if they have one.
    pub(crate) fn boresights(&self, wanted: &[Vector3]) -> Option<&str> {
        let same = |(a, b): (&Vector3, &Vector3)| (a - b).amax() < SAME_BORESIGHT;
        let named = self.boresights.iter().find(|Boresights { vectors, .. }| {
            vectors.len() == wanted.len() && vectors.iter().zip(wanted).all(same)
        });
        named.map(|named| named.name.as_str())
    }

    /// Returns the reference frame.
    pub fn reference_frame(&self) -> &str {
        self.reference_frame.as_deref().unwrap_or(Self::REFERENCE_FRAME)
    }
}
