//! What a maneuver is of, and when: the names and the epoch that files for other programs carry.

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
    /// Its international designator, or another identifier.
    pub object_id: Option<String>,
    /// What it is about: a planet.
    pub center: Option<String>,
    /// The reference frame, to which attitudes lead.
    pub reference_frame: Option<String>,
    /// The body frame, from which they come.
    pub body_frame: Option<String>,
    /// Who issues the files.
    pub originator: Option<String>,
    /// Number of the object at NAIF, negative as those of spacecraft are.
    pub spice_id: Option<i32>,
    /// What the inputs are called, in their order; empty: by their numbers.
    pub inputs: Vec<String>,
    /// The thrusters of an attitude maneuver that the spec tells by place and force, in their order; empty where one is told by its
    /// torque. The inputs of the plan are their torques.
    pub nozzles: Vec<Nozzle>,
    /// What stands around the spacecraft, where the spec aims at something by name.
    pub scenery: Option<Scenery>,
}

/// A thruster as the spec tells it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nozzle {
    /// Where it sits, from the mass center, body axes \[m\].
    pub position: Vector3,
    /// The way in which it pushes the body, of length 1.
    pub direction: Vector3,
    /// Its largest force \[N\].
    pub force_limit: f64,
    /// The price of its impulse [1/(N·s)].
    pub price: f64,
}

impl Nozzle {
    /// Its lever about the mass center \[m\]: torque over force.
    pub fn lever(&self) -> f64 {
        self.position.cross(&self.direction).norm()
    }
}

impl Identity {
    /// The body frame where none is named: the first of a spacecraft.
    pub const BODY_FRAME: &'static str = "SC_BODY_1";
    /// The reference frame where none is named.
    pub const REFERENCE_FRAME: &'static str = "ICRF";

    /// The body frame.
    pub fn body_frame(&self) -> &str {
        self.body_frame.as_deref().unwrap_or(Self::BODY_FRAME)
    }

    /// From which frame to which attitudes lead, where the spec names one of them.
    pub fn frames(&self) -> Option<String> {
        let named = self.body_frame.is_some() || self.reference_frame.is_some();
        let of = |frame: &Option<String>, other: &str| frame.clone().unwrap_or(other.into());
        let (from, to) =
            (of(&self.body_frame, "body axes"), of(&self.reference_frame, "the reference frame"));
        named.then(|| format!("from {from} to {to}"))
    }

    /// What the input of this number, forces first, is called, where it has a name.
    pub fn input(&self, index: usize) -> Option<&str> {
        self.inputs.get(index).map(String::as_str)
    }

    /// The reference frame.
    pub fn reference_frame(&self) -> &str {
        self.reference_frame.as_deref().unwrap_or(Self::REFERENCE_FRAME)
    }
}
