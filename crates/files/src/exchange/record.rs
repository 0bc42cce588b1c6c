//! The data from which all formats for other programs are written.

use super::frames::{Meaning, meaning};
use crate::epoch::Epoch;
use crate::export::{ExportError, Names};
use crate::flown::{ArcRecord, FeedbackRecord};
use crate::identity::Identity;
use slewkit::maneuver::{Problem, Trajectory};
use slewkit::{Matrix3, Vector3, lie};
use std::borrow::Cow;
use std::ops::RangeInclusive;

/// Optional contents of tables.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tables {
    /// Time between the rows of tables with equal ticks \[s\]; `None` for the step of the plan.
    pub tick: Option<f64>,
    /// True if CSV and Parquet tables contain the margins to limits and constraints at each node,
    /// and the angles between boresights and directions.
    pub margins: bool,
}

/// A trajectory with its maneuver, its names and its epoch.
#[derive(Clone, Debug)]
pub struct Record<'a> {
    /// The maneuver.
    pub problem: &'a Problem,
    /// Names and epoch of the maneuver.
    pub identity: Cow<'a, Identity>,
    /// Attitudes, rates and inputs at the nodes.
    pub trajectory: &'a Trajectory,
    /// Indices of the interior nodes at which inputs switch, in increasing order; the motion is not
    /// smooth there.
    pub switches: Vec<usize>,
    /// Creation date of the file.
    pub created: Epoch,
    /// Optional contents of tables.
    pub tables: Tables,
    /// Comments, each of which is one line of the file.
    pub notes: Vec<String>,
    /// Feedback gains along the plan, if the plan file has them.
    pub gains: Option<Cow<'a, FeedbackRecord>>,
}

impl Record<'_> {
    /// Returns the length of a row of gains and the gains, one row for each step, ordered by input;
    /// `None` without gains.
    pub(super) fn gain_rows(&self) -> Option<(usize, Vec<f64>)> {
        let gains = &self.gains.as_ref()?.gains;
        let width = gains.first().map_or(0, |step| step.iter().map(Vec::len).sum());
        Some((width, gains.iter().flatten().flatten().copied().collect()))
    }

    /// Returns the names of the states that the gains in a row multiply.
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

    /// Returns a row of seven numbers for each arc: its duration, and the six derivatives of this
    /// duration with respect to the initial state. Returns `None` without gains for arcs.
    pub(super) fn arc_rows(&self) -> Option<Vec<f64>> {
        let arcs = &self.gains.as_ref()?.arcs;
        let row = |arc: &ArcRecord| std::iter::once(arc.length_s).chain(arc.gain).collect::<Vec<_>>();
        (!arcs.is_empty()).then(|| arcs.iter().flat_map(row).collect())
    }

    /// Returns whether the reference frame turns.
    pub(super) fn turns(&self) -> bool {
        self.problem.environment.frame_rate().amax() > 0.0
    }

    /// Returns the name of the object or, without one, the name of the maneuver.
    pub(super) fn object(&self) -> String {
        ascii(self.identity.object.as_deref().unwrap_or(&self.problem.name))
    }

    /// Returns the name of the maneuver in printable ASCII.
    pub(super) fn name(&self) -> String {
        ascii(&self.problem.name)
    }

    /// Returns the date of time zero; an earlier check has rejected formats that need a missing
    /// epoch.
    pub(super) fn epoch(&self) -> Result<Epoch, super::Lacking> {
        self.identity.epoch.ok_or(super::Lacking::Epoch)
    }

    /// Returns the rotation from components in the axes of the maneuver to components in the
    /// orbital frame that the spec names. Returns `None` if the reference frame does not turn, or
    /// if the spec does not name an orbital frame.
    pub(super) fn axes(&self) -> Option<Matrix3> {
        match meaning(self.identity.reference_frame.as_deref()?) {
            Meaning::Orbit(axes) if self.turns() => Some(axes),
            _ => None,
        }
    }

    /// Returns the quaternion at node `k` of the rotation from body axes to the frame that the spec
    /// names.
    pub(super) fn named_quaternion(&self, k: usize) -> [f64; 4] {
        let own = self.trajectory.quaternion[k];
        let Some(axes) = self.axes().filter(|axes| *axes != Matrix3::identity()) else { return own };
        product(lie::quaternion_from_rotation(&axes), own)
    }

    /// Returns the inertial attitude and angular velocity at node `k`: the quaternion from body
    /// axes to the reference frame at time zero, and the rate in body axes \[rad/s\].
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

    /// Returns the ranges of nodes of the smooth pieces of the motion; adjacent pieces share a
    /// node.
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

    /// Returns the factors that convert the inputs of the plan to the units of their headings.
    pub(super) fn input_units(&self) -> Vec<f64> {
        let names = Names::new(self.problem, &self.identity);
        (0..self.trajectory.input_count).map(|input| names.in_its_unit(input, 1.0)).collect()
    }

    /// Returns the headings of the columns of inputs, with their units.
    pub(super) fn input_heads(&self) -> Vec<String> {
        let names = Names::new(self.problem, &self.identity);
        (0..self.trajectory.input_count)
            .map(|input| ascii(&format!("input_{}", names.input(input))))
            .collect()
    }
}

/// Returns the product of two quaternions, scalar first. Unlike a conversion through rotation
/// matrices, it keeps the sign continuous from row to row.
fn product([a, b, c, d]: [f64; 4], [w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
}

/// Replaces all characters other than printable ASCII by question marks.
fn ascii(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
}
