//! Margins and cone angles at every node of a recorded trajectory, for tables.

use super::Meter;
use crate::maneuver::constraint::{Pointing, Rule, angle_between};
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::Trajectory;
use crate::{Matrix3, Vector3, lie};

/// The margins of a trajectory to one limit or constraint at all nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeMargins {
    /// Name of the limit or constraint, as in [`super::Margin`].
    pub name: String,
    /// Unit of the margins, as in [`super::Margin`].
    pub unit: &'static str,
    /// Margin at each of the `N + 1` nodes, negative for a violation. NaN if the node has no input
    /// or input rate, or if the constraint is not active there.
    pub values: Vec<f64>,
}

/// The angle between a boresight and a direction of a constraint, at all nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct ConeAngle {
    /// Name of the constraint.
    pub name: String,
    /// Number of the boresight in the constraint, from 1.
    pub boresight: usize,
    /// Number of the direction in the constraint, from 1.
    pub direction: usize,
    /// Whether this is the only pair of the constraint.
    pub only: bool,
    /// Angle at each of the `N + 1` nodes \[deg\].
    pub degrees: Vec<f64>,
}

impl Meter<'_> {
    /// Measures an attitude, from body to reference, at `time` \[s\].
    fn attitude(&mut self, time: f64, attitude: &Matrix3) {
        let frame_rate = self.frame_rate;
        for entry in &mut self.entries {
            let super::What::Rule(Rule::Pointing(pointing)) = entry.what else { continue };
            if !pointing.during.contains(time) {
                continue;
            }
            for (index, (angle, radius)) in angles(pointing, time, attitude, &frame_rate).enumerate() {
                let scaled = pointing.room_beside(angle, radius);
                entry.smallest.meet(super::Smallest { margin: scaled, scaled, time, index });
            }
        }
    }
}

/// Returns the angle of every pair of boresight and direction, and the angular radius of the target
/// \[rad\].
fn angles(
    pointing: &Pointing,
    time: f64,
    attitude: &Matrix3,
    frame_rate: &Vector3,
) -> impl Iterator<Item = (f64, f64)> {
    pointing.pairs().map(move |(boresight, to)| {
        (angle_between(&(attitude * boresight), &to.at(time, frame_rate)), to.angular_radius(time))
    })
}

/// Returns the margins to every limit and constraint of `problem` at the nodes of `trajectory`, in
/// the units of [`NodeMargins::unit`]. `inputs` maps the index of a node to the index of its input
/// row, or to `None` if the node has no inputs. Unlike [`super::Margin`], these margins do not
/// cover the motion between nodes.
pub fn margins_at_nodes(
    problem: &Problem,
    trajectory: &Trajectory,
    inputs: impl Fn(usize) -> Option<usize>,
) -> Vec<NodeMargins> {
    let empty = Meter::new(problem);
    let mut found: Vec<NodeMargins> = (empty.entries.iter())
        .map(|entry| NodeMargins { name: entry.name.clone(), unit: entry.unit, values: Vec::new() })
        .collect();
    let wheels = problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len());
    let row = |node: usize| inputs(node).map(|row| trajectory.inputs(row));
    for (node, time) in trajectory.time.iter().copied().enumerate() {
        let before = node.checked_sub(1);
        let step = before.map_or(f64::NAN, |before| time - trajectory.time[before]);
        let mut meter = Meter::new(problem);
        if let Some(now) = row(node) {
            meter.inputs(time, now, step, before.and_then(row));
        }
        if let Some(momenta) = trajectory.wheel_momentum.get(node * wheels..(node + 1) * wheels) {
            meter.wheels(time, momenta);
        }
        meter.rate(time, &trajectory.angular_velocity[node]);
        meter.attitude(time, &lie::rotation_from_quaternion(&trajectory.quaternion[node]));
        for (column, entry) in found.iter_mut().zip(&meter.entries) {
            column.values.push(entry.margin().margin);
        }
    }
    found
}

/// Returns the angle between every boresight and every direction of each constraint of `problem`,
/// at the nodes of `trajectory`.
pub fn cone_angles(problem: &Problem, trajectory: &Trajectory) -> Vec<ConeAngle> {
    let frame_rate = problem.environment.frame_rate();
    let mut found = Vec::new();
    for constraint in &problem.constraints {
        let Rule::Pointing(pointing) = &constraint.rule else { continue };
        let first = found.len();
        let (boresights, directions) = (pointing.boresights.len(), pointing.directions.len());
        found.extend((0..boresights * directions).map(|index| ConeAngle {
            name: constraint.name.clone(),
            boresight: index / directions + 1,
            direction: index % directions + 1,
            only: boresights * directions == 1,
            degrees: Vec::with_capacity(trajectory.time.len()),
        }));
        for (time, quaternion) in trajectory.time.iter().zip(&trajectory.quaternion) {
            let attitude = lie::rotation_from_quaternion(quaternion);
            for (cone, (angle, _)) in
                found[first..].iter_mut().zip(angles(pointing, *time, &attitude, &frame_rate))
            {
                cone.degrees.push(angle.to_degrees());
            }
        }
    }
    found
}
