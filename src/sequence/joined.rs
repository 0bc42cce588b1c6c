//! The motion over a whole sequence: the legs, and the holds and rests between them.

use crate::Vector3;
use crate::maneuver::solution::Trajectory;

/// A leg with its times in the sequence.
#[derive(Clone, Copy, Debug)]
pub struct Flown<'a> {
    /// The trajectory of the leg; its time begins at zero.
    pub path: &'a Trajectory,
    /// Start time of the leg in the sequence \[s\].
    pub begins: f64,
    /// The trajectory of the hold after the leg; its time begins at zero. `None` if the body rests.
    pub hold: Option<&'a Trajectory>,
    /// Start time of the next leg \[s\]; for the last leg, the time at which its hold ends.
    pub until: f64,
}

/// A part of the motion of a sequence: a leg, or the hold or rest after a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Index of the leg in the order of time.
    pub leg: usize,
    /// `true` for the hold or rest after the leg, `false` for the leg.
    pub rests: bool,
    /// Indices of the first and the last node of the part.
    pub nodes: [usize; 2],
}

/// The motion over a whole sequence, at the nodes of its legs and holds. The inputs are constant
/// over each step, and zero while the body rests. The trajectory has no costates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Joined {
    /// The trajectory, with one row of inputs for each step.
    pub path: Trajectory,
    /// The legs, holds and rests in the order of time.
    pub parts: Vec<Part>,
}

impl Joined {
    /// Joins legs to one motion. Adjacent parts share a node, with the state at which the later
    /// part begins.
    pub fn of<'a>(legs: impl IntoIterator<Item = Flown<'a>>) -> Self {
        let mut whole = Self::default();
        for (leg, flown) in legs.into_iter().enumerate() {
            whole.add(leg, flown);
        }
        whole
    }

    fn add(&mut self, leg: usize, Flown { path, begins, hold, until }: Flown) {
        let Some(duration) = path.time.last() else { return };
        self.follow(path, begins, Part { leg, rests: false, nodes: [0; 2] });
        let arrival = begins + duration;
        match hold {
            Some(hold) => self.follow(hold, arrival, Part { leg, rests: true, nodes: [0; 2] }),
            None if until > arrival => self.rest(leg, until),
            None => {}
        }
    }

    /// Appends the motion `path`, which begins at the time `begins` \[s\], and records its nodes in
    /// `part`.
    fn follow(&mut self, path: &Trajectory, begins: f64, part: Part) {
        let first = self.path.time.len().saturating_sub(1);
        if !self.path.time.is_empty() {
            self.drop_node();
        }
        self.path.input_count = path.input_count;
        // A quaternion and its negative represent one attitude. The sign keeps the rows continuous.
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
            self.parts.push(Part { nodes: [first, last], ..part });
        }
    }

    /// Appends a rest after the leg `leg`, until the time `until` \[s\].
    fn rest(&mut self, leg: usize, until: f64) {
        let last = self.path.time.len() - 1;
        let wheels = self.path.wheel_momentum.len() / self.path.time.len();
        self.path.time.push(until);
        self.path.quaternion.extend(self.path.quaternion.last().copied());
        self.path.angular_velocity.push(Vector3::zeros());
        let held = self.path.wheel_momentum.len() - wheels;
        self.path.wheel_momentum.extend_from_within(held..);
        self.path.input.extend(std::iter::repeat_n(0.0, self.path.input_count));
        self.path.torque.push(Vector3::zeros());
        self.parts.push(Part { leg, rests: true, nodes: [last, last + 1] });
    }

    /// Removes the last node; the first node of the next part replaces it.
    fn drop_node(&mut self) {
        let wheels = self.path.wheel_momentum.len() / self.path.time.len();
        self.path.time.pop();
        self.path.quaternion.pop();
        self.path.angular_velocity.pop();
        self.path.wheel_momentum.truncate(self.path.wheel_momentum.len() - wheels);
    }
}
