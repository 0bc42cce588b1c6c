//! The start and the end of a maneuver, and the start of a body of a simulation, as the spec
//! defines them.

use super::attitude::from_file::{self, Moment};
use super::attitude::{self, Rotation, Use};
use super::keys::REST_IN_ORBIT;
use super::{Section, Spot, sky};
use slewkit::maneuver::State;
use slewkit::{Matrix3, Vector3};

/// The table `[start]` or `[end]` as written.
#[derive(Clone)]
pub(crate) struct Boundary<'a> {
    pub section: &'a Section,
    /// Key under which the rotation is given: `attitude` or `rotation_from_start`.
    pub key: &'static str,
    pub rotation: Option<Rotation>,
    /// Rotation vector from the start attitude to the end attitude, in body axes at the start
    /// \[rad\]; `None` if the spec does not give it in addition to the attitude.
    pub turn: Option<Vector3>,
    /// Inertial angular velocity in body axes \[rad/s\]; `None` if its value is invalid.
    pub rate: Option<Vector3>,
    pub position: Option<Vector3>,
    pub velocity: Option<Vector3>,
}

pub(super) const TURN: &str = "rotation_from_start_rad";

impl<'a> Boundary<'a> {
    /// Reads the table. In the spec of a maneuver, `moment` is the time at which the attitude is
    /// needed; if it is `None`, the attitude cannot be read from a file.
    pub fn read(section: &'a Section, key: &'static str, moment: Option<&Moment<'_>>) -> Self {
        let purpose = if key == "attitude" { Use::Attitude } else { Use::Turn };
        let rotation = section.section(key).and_then(|rotation| match moment {
            Some(moment) if key == "attitude" && rotation.has("file") => {
                from_file::rotation(rotation, moment)
            }
            _ => attitude::rotation(rotation, purpose),
        });
        let rate = section.rate();
        let (position, velocity) = (section.vector("position_m"), section.vector("velocity_m_s"));
        let turn = if section.knows(TURN) { section.vector(TURN) } else { None };
        Self { section, key, rotation, turn, rate, position, velocity }
    }

    /// Sets the state of a body that must point at a target at the start of the maneuver.
    pub fn aimed(&mut self, sky: &mut sky::Reading) {
        if !self.section.has("point") {
            return;
        }
        if !self.section.has("second") {
            let reason = "a start on a target needs `second`: the roll about the boresight is undetermined \
             without it";
            self.section.error(
                "E0078",
                "point",
                reason,
                "add second = { axis_body = [1, 0, 0], at = \"velocity\" }",
            );
            return;
        }
        let Some(aim) = sky.aim(self.section, Some(0.0)) else { return };
        let ends = aim.check().and_then(|()| aim.ends(0.0, &Matrix3::identity(), &Vector3::zeros()));
        match ends {
            Err(error) => {
                self.section.error("E0078", "point", error.to_string(), "check the axes and the directions");
            }
            Ok(ends) => {
                let (matrix, rate) = ends.at(0.0);
                let vector = slewkit::lie::log(&matrix);
                let spot = self.section.spot("point");
                self.rotation = Some(Rotation { matrix, vector, spot, maybe_identity: None });
                self.rate = Some(rate);
            }
        }
    }

    pub fn relative(&self) -> bool {
        self.key == "rotation_from_start"
    }

    /// Returns true if the attitude is free: the table has an angular velocity but no attitude.
    pub fn is_open(&self) -> bool {
        let attitudes = ["attitude", "rotation_from_start", "point"];
        self.section.rate_key().is_some() && !attitudes.into_iter().any(|key| self.section.has(key))
    }

    /// Returns true if the body is at rest relative to the orbital frame, and so turns with the
    /// orbit.
    pub fn rests_in_orbit(&self) -> bool {
        self.section.knows(REST_IN_ORBIT) && self.section.has(REST_IN_ORBIT)
    }

    pub fn moves(&self) -> bool {
        self.section.has("position_m") || self.section.has("velocity_m_s")
    }

    /// Returns the position of the angular velocity in the spec, or the position of the table if
    /// the key is absent.
    pub fn rate_spot(&self) -> Spot {
        self.section.spot(self.section.rate_key().unwrap_or("angular_velocity_deg_s"))
    }

    pub fn state(&self, attitude: Matrix3) -> Option<State> {
        let vector = |value: Option<Vector3>, name| match value {
            None if self.section.has(name) => None,
            other => Some(other.unwrap_or_default()),
        };
        Some(State {
            position: vector(self.position, "position_m")?,
            velocity: vector(self.velocity, "velocity_m_s")?,
            attitude,
            angular_velocity: self.rate?,
        })
    }
}

impl Section {
    /// Returns the key under which the table has an angular velocity; `None` if it has none.
    pub fn rate_key(&self) -> Option<&'static str> {
        ["angular_velocity_deg_s", "angular_velocity_rad_s"].into_iter().find(|name| self.has(name))
    }

    /// Returns the angular velocity \[rad/s\]: zero if the key is absent, and `None` if its value
    /// is invalid.
    pub fn rate(&self) -> Option<Vector3> {
        let Some(name) = self.rate_key() else { return Some(Vector3::zeros()) };
        let scale = if name.ends_with("deg_s") { 1_f64.to_radians() } else { 1.0 };
        self.vector(name).map(|rate| rate * scale)
    }
}
