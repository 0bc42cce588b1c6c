//! Data from which files for other programs are written, whatever their format.

use super::frames::{Meaning, meaning};
use crate::epoch::Epoch;
use crate::export::{ExportError, Names};
use crate::flown::{ArcRecord, FeedbackRecord};
use crate::identity::Identity;
use slewkit::maneuver::{Problem, Trajectory};
use slewkit::{Matrix3, Vector3, lie};
use std::borrow::Cow;
use std::ops::RangeInclusive;

/// Options for the contents of tables.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tables {
    /// Time between the rows of tables with uniform spacing \[s\]; `None` to use the step of the
    /// plan.
    pub tick: Option<f64>,
    /// True if CSV and Parquet tables contain the margins to limits and constraints at each node,
    /// and the angles between boresights and directions.
    pub margins: bool,
}

/// A trajectory with its maneuver, its names and its epoch.
#[derive(Clone, Debug)]
pub struct Record<'a> {
    /// Maneuver to which the trajectory belongs.
    pub problem: &'a Problem,
    /// Names and epoch of the maneuver.
    pub identity: Cow<'a, Identity>,
    /// Attitudes, rates and inputs at the nodes.
    pub trajectory: &'a Trajectory,
    /// Indices of the interior nodes at which inputs switch, in increasing order. The motion is not
    /// smooth at these nodes.
    pub switches: Vec<usize>,
    /// Creation date of the file.
    pub created: Epoch,
    /// Options for the contents of tables.
    pub tables: Tables,
    /// Comments, each of which is written as one line of the file.
    pub notes: Vec<String>,
    /// Feedback gains along the plan; `None` if the plan file has no gains.
    pub gains: Option<Cow<'a, FeedbackRecord>>,
}

impl Record<'_> {
    /// Returns the number of gains of a step, and the gains of all steps in one list: step by step,
    /// and input by input within a step. Returns `None` if the plan has no gains.
    pub(super) fn gain_rows(&self) -> Option<(usize, Vec<f64>)> {
        let gains = &self.gains.as_ref()?.gains;
        let width = gains.first().map_or(0, |step| step.iter().map(Vec::len).sum());
        Some((width, gains.iter().flatten().flatten().copied().collect()))
    }

    /// Returns the names of the state components that the gains of an input multiply, in their
    /// order.
    pub(super) fn gain_states(&self) -> Vec<String> {
        let rows = self.gains.iter().flat_map(|gains| gains.gains.first()?.first());
        let states: &[&str] = match rows.map(Vec::len).next() {
            Some(12) => &["position", "velocity", "attitude", "rate"],
            Some(9) => &["attitude", "rate", "stored"],
            Some(_) => &["attitude", "rate"],
            None => &[],
        };
        states.iter().flat_map(|state| ["x", "y", "z"].map(|axis| format!("{state}_{axis}"))).collect()
    }

    /// Returns a row of seven numbers for each arc: its duration, and the derivatives of this
    /// duration with respect to the six components of the initial state. Returns `None` if the plan
    /// has no gains for its switching times.
    pub(super) fn arc_rows(&self) -> Option<Vec<f64>> {
        let arcs = &self.gains.as_ref()?.arcs;
        let row = |arc: &ArcRecord| std::iter::once(arc.length_s).chain(arc.gain).collect::<Vec<_>>();
        (!arcs.is_empty()).then(|| arcs.iter().flat_map(row).collect())
    }

    /// Returns whether the reference frame of the maneuver turns.
    pub(super) fn turns(&self) -> bool {
        self.problem.environment.frame_rate().amax() > 0.0
    }

    /// Returns the name of the object or, if it has no name, the name of the maneuver.
    pub(super) fn object(&self) -> String {
        ascii(self.identity.object.as_deref().unwrap_or(&self.problem.name))
    }

    /// Returns the name of the maneuver, restricted to printable ASCII characters.
    pub(super) fn name(&self) -> String {
        ascii(&self.problem.name)
    }

    /// Returns the epoch of time zero. An earlier check ensures that the epoch exists if the format
    /// needs it.
    pub(super) fn epoch(&self) -> Result<Epoch, super::Lacking> {
        self.identity.epoch.ok_or(super::Lacking::Epoch)
    }

    /// Returns the rotation from components in the reference axes of the maneuver to components in
    /// the orbital frame that the spec names. Returns `None` if the reference frame does not turn,
    /// or if the spec names no orbital frame.
    pub(super) fn axes(&self) -> Option<Matrix3> {
        match meaning(self.identity.reference_frame.as_deref()?) {
            Meaning::Orbit(axes) if self.turns() => Some(axes),
            _ => None,
        }
    }

    /// Returns the attitude quaternion at node `k`, from body axes to the axes of the frame that
    /// the spec names.
    pub(super) fn named_quaternion(&self, k: usize) -> [f64; 4] {
        let own = self.trajectory.quaternion[k];
        let Some(axes) = self.axes().filter(|axes| *axes != Matrix3::identity()) else { return own };
        product(lie::quaternion_from_rotation(&axes), own)
    }

    /// Returns the inertial motion at node `k`: the quaternion from body axes to the axes that the
    /// reference frame has at time zero, and the inertial rate in body axes \[rad/s\].
    pub(super) fn inertial(&self, k: usize) -> ([f64; 4], Vector3) {
        let (quaternion, rate) = (self.trajectory.quaternion[k], self.trajectory.angular_velocity[k]);
        if !self.turns() {
            return (quaternion, rate);
        }
        let half = 0.5 * self.trajectory.time[k] * self.problem.environment.frame_rate();
        let (angle, axis) = (half.norm(), half.try_normalize(0.0).unwrap_or_default());
        let vector = angle.sin() * axis;
        (product([angle.cos(), vector.x, vector.y, vector.z], quaternion), rate)
    }

    /// Returns the name of the reference frame for the header of a table.
    pub(super) fn reference(&self) -> &str {
        if self.turns() {
            "orbit (e1 velocity, e2 orbit normal, e3 outward)"
        } else {
            self.identity.reference_frame()
        }
    }

    /// Returns the angular velocity of the body relative to the reference frame at node `k`, in
    /// body axes \[rad/s\].
    pub(super) fn rate(&self, k: usize) -> Vector3 {
        let inertial = self.trajectory.angular_velocity[k];
        if !self.turns() {
            return inertial;
        }
        let attitude = lie::rotation_from_quaternion(&self.trajectory.quaternion[k]);
        inertial - attitude.tr_mul(&self.problem.environment.frame_rate())
    }

    /// Returns the ranges of node indices of the smooth pieces of the motion. Two adjacent pieces
    /// share the node between them.
    pub(super) fn pieces(&self) -> impl Iterator<Item = RangeInclusive<usize>> {
        let ends = self.switches.iter().copied().chain([self.nodes() - 1]);
        let starts = [0].into_iter().chain(self.switches.iter().copied());
        starts.zip(ends).map(|(start, end)| start..=end)
    }

    /// Returns the number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.trajectory.time.len()
    }

    /// Checks that all numbers are finite and that the motion has at least two nodes.
    pub(super) fn check_finite(&self) -> Result<(), ExportError> {
        crate::export::check_finite(self.trajectory)?;
        if self.nodes() < 2 { Err(super::Lacking::Duration.into()) } else { Ok(()) }
    }

    /// Returns the factors by which the inputs of the plan are multiplied to obtain the units of
    /// their column headings.
    pub(super) fn input_units(&self) -> Vec<f64> {
        let names = Names::new(self.problem, &self.identity);
        (0..self.trajectory.input_count).map(|input| names.in_its_unit(input, 1.0)).collect()
    }

    /// Returns the column headings of the inputs, with units.
    pub(super) fn input_heads(&self) -> Vec<String> {
        let names = Names::new(self.problem, &self.identity);
        (0..self.trajectory.input_count)
            .map(|input| ascii(&format!("input_{}", names.input(input))))
            .collect()
    }
}

/// Returns the product of two quaternions, scalar first. Unlike a product of rotation matrices, it
/// keeps the sign of the quaternion, which therefore remains continuous from row to row.
fn product([a, b, c, d]: [f64; 4], [w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
}

/// Replaces every character that is not printable ASCII by a question mark.
fn ascii(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
}
