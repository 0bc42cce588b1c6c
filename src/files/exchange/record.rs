//! What all formats are written from.

use crate::files::epoch::Epoch;
use crate::files::export::ExportError;
use crate::files::identity::Identity;
use crate::maneuver::{Problem, Trajectory};
use crate::{Vector3, lie};
use std::borrow::Cow;

/// A trajectory with its maneuver, its names and its epoch.
#[derive(Clone, Debug)]
pub struct Record<'a> {
    /// The maneuver.
    pub problem: &'a Problem,
    /// Names and epoch.
    pub identity: Cow<'a, Identity>,
    /// Attitudes, rates and inputs.
    pub trajectory: &'a Trajectory,
    /// When the file is written.
    pub created: Epoch,
    /// Tick of tables with equal ticks \[s\]; the step of the plan where there is none.
    pub tick: Option<f64>,
    /// What to know about it, a line each, for comments.
    pub notes: Vec<String>,
}

impl Record<'_> {
    /// Whether the reference frame turns.
    pub(super) fn turns(&self) -> bool {
        self.problem.environment.frame_rate().amax() > 0.0
    }

    /// The name of the object; of the maneuver where it has none.
    pub(super) fn object(&self) -> String {
        ascii(self.identity.object.as_deref().unwrap_or(&self.problem.name))
    }

    /// The name of the maneuver, in ASCII.
    pub(super) fn name(&self) -> String {
        ascii(&self.problem.name)
    }

    /// The moment of time zero; what needs one has been checked for it.
    pub(super) fn epoch(&self) -> Result<Epoch, super::Lacking> {
        self.identity.epoch.ok_or(super::Lacking::Epoch)
    }

    /// Angular velocity of the body against the reference frame at node `k`, body axes [rad/s].
    pub(super) fn rate(&self, k: usize) -> Vector3 {
        let inertial = self.trajectory.angular_velocity[k];
        if !self.turns() {
            return inertial;
        }
        let attitude = lie::rotation_from_quaternion(&self.trajectory.quaternion[k]);
        inertial - attitude.tr_mul(&self.problem.environment.frame_rate())
    }

    /// The other row of step `k`: that of its end for Lie–Verlet; the same for Lie–Euler, and where a row is a step's.
    fn later_row(&self, k: usize) -> usize {
        if self.problem.switches() { k } else { k + 1 - self.problem.scheme.first_input() }
    }

    /// The torque that the plan holds over step `k`, body axes [N·m]: the mean of the two rows at its ends for
    /// Lie–Verlet, the row at its end for Lie–Euler, that of the step where inputs switch.
    pub(super) fn held_torque(&self, k: usize) -> Vector3 {
        let torque = &self.trajectory.torque;
        let later = self.later_row(k);
        if later == k { torque[k] } else { 0.5 * (torque[k] + torque[later]) }
    }

    /// The inputs that the plan holds over step `k`, in the same way.
    pub(super) fn held_inputs(&self, k: usize) -> Vec<f64> {
        let later = self.later_row(k);
        let ends = self.trajectory.inputs(k).iter().zip(self.trajectory.inputs(later));
        ends.map(|(first, last)| 0.5 * (first + last)).collect()
    }

    /// Number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.trajectory.time.len()
    }

    /// Refuses what no format can hold.
    pub(super) fn check_finite(&self) -> Result<(), ExportError> {
        crate::files::export::check_finite(self.trajectory)?;
        if self.nodes() < 2 { Err(super::empty()) } else { Ok(()) }
    }

    /// What the inputs are called: names of the spec, else numbers.
    pub(super) fn input_names(&self) -> Vec<String> {
        let count = self.trajectory.input_count;
        if self.identity.inputs.len() == count {
            return self.identity.inputs.iter().map(|name| ascii(name)).collect();
        }
        (1..=count).map(|number| number.to_string()).collect()
    }
}

/// Printable ASCII alone.
fn ascii(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
}
