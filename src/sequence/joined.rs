//! The motion over a whole sequence: its legs, and the rests between them.

use crate::Vector3;
use crate::maneuver::solution::Trajectory;

/// A leg with its times in the sequence.
#[derive(Clone, Copy, Debug)]
pub struct Flown<'a> {
    /// The trajectory of the leg, from time zero.
    pub path: &'a Trajectory,
    /// When it begins \[s\].
    pub begins: f64,
    /// When the next leg begins, or the last hold ends \[s\].
    pub until: f64,
}

/// A leg, or the rest after one, in the motion over the whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The leg, from 0.
    pub leg: usize,
    /// Whether it is the rest at the end of the leg.
    pub rests: bool,
    /// Its first and its last node.
    pub nodes: [usize; 2],
}

/// The motion over the whole, on the nodes of the legs. Inputs are held over steps and zero in the
/// rests; there are no costates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Joined {
    /// The trajectory, with one row of inputs for each step.
    pub path: Trajectory,
    /// Legs and rests, in the order of time.
    pub parts: Vec<Part>,
}

impl Joined {
    /// Joins legs. The first node of a leg is the last one of what was before it, and has the state
    /// of the stop.
    pub fn of<'a>(legs: impl IntoIterator<Item = Flown<'a>>) -> Self {
        let mut whole = Self::default();
        for (leg, flown) in legs.into_iter().enumerate() {
            whole.add(leg, flown);
        }
        whole
    }

    fn add(&mut self, leg: usize, Flown { path, begins, until }: Flown) {
        let Some(duration) = path.time.last() else { return };
        let first = self.path.time.len().saturating_sub(1);
        if !self.path.time.is_empty() {
            self.drop_node();
        }
        let wheels = path.wheel_momentum.len() / path.time.len();
        self.path.input_count = path.input_count;
        // A quaternion and its negative are one attitude: the row stays continuous.
        let sign = match (self.path.quaternion.last(), path.quaternion.first()) {
            (Some(last), Some(first)) if last.iter().zip(first).map(|(a, b)| a * b).sum::<f64>() < 0.0 => {
                -1.0
            }
            _ => 1.0,
        };
        self.path.time.extend(path.time.iter().map(|time| begins + time));
        self.path.quaternion.extend(path.quaternion.iter().map(|row| row.map(|part| sign * part)));
        self.path.angular_velocity.extend(&path.angular_velocity);
        self.path.wheel_momentum.extend(&path.wheel_momentum);
        for step in 0..path.time.len() - 1 {
            self.path.input.extend(path.held_inputs(step));
            self.path.torque.push(path.held_torque(step));
        }
        let last = self.path.time.len() - 1;
        if last > first {
            self.parts.push(Part { leg, rests: false, nodes: [first, last] });
        }
        if until > begins + duration {
            self.path.time.push(until);
            self.path.quaternion.extend(self.path.quaternion.last().copied());
            self.path.angular_velocity.push(Vector3::zeros());
            let held = self.path.wheel_momentum.len() - wheels;
            self.path.wheel_momentum.extend_from_within(held..);
            self.path.input.extend(std::iter::repeat_n(0.0, path.input_count));
            self.path.torque.push(Vector3::zeros());
            self.parts.push(Part { leg, rests: true, nodes: [last, last + 1] });
        }
    }

    /// Removes the last node, which the first one of the next leg replaces.
    fn drop_node(&mut self) {
        let wheels = self.path.wheel_momentum.len() / self.path.time.len();
        self.path.time.pop();
        self.path.quaternion.pop();
        self.path.angular_velocity.pop();
        self.path.wheel_momentum.truncate(self.path.wheel_momentum.len() - wheels);
    }
}
