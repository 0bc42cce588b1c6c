//! Homotopy class of a path, determined on the double cover of the rotations.
//!
//! # What are senses and windings?
//!
//! Two attitudes are joined by the short way, the long way, and by each with additional turns:
//! these are different extremals. `path = "best"` compares all that its search finds; the others
//! are reported as rivals in the solution, with cost and conjugate points. The classes are counted
//! from the end of the uncontrolled motion, not from the start, because with nonzero boundary rates
//! the apparently shorter way may cost more. The class of a result is determined from the
//! continuous quaternion of its path.

use crate::lie::{self, continued};
use crate::maneuver::solution::Sense;
use crate::optimize::discrete::step::StepError;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::discrete::terminal::TerminalCondition;
use crate::{Matrix3, Vector3};
use nalgebra::SVector;

/// Largest rotation between two samples for which the sign of the quaternion is certain \[rad\].
const SMALL_TURN: f64 = 0.2;

/// Homotopy class and rotation of a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Homotopy class: short or long.
    pub sense: Sense,
    /// Angle turned, `∫|Ω|dt` \[deg\].
    pub turned_deg: f64,
    /// Integral `∫Ω dt`, body axes \[rad\]: the rotation vector if the axis is fixed.
    pub rotation: Vector3,
}

/// Follows a path node by node: tracks the continuous quaternion and the rotation so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Follower {
    quaternion: Option<[f64; 4]>,
    end: Matrix3,
    rate: Option<Vector3>,
    turned: f64,
    rotation: Vector3,
}

impl Follower {
    /// Creates a follower before the first node.
    pub fn new() -> Self {
        let (end, rotation) = (Matrix3::identity(), Vector3::zeros());
        Self { quaternion: None, end, rate: None, turned: 0.0, rotation }
    }

    /// Adds the next node: its attitude and its angular velocity (body axes, scaled), at the time
    /// `h` after the previous one.
    pub fn node(&mut self, attitude: &Matrix3, rate: Vector3, h: f64) {
        self.attitude(attitude);
        if let Some(before) = self.rate {
            let half = 0.5 * h;
            self.turned += half * (rate.norm() + before.norm());
            self.rotation += (rate + before) * half;
        }
        self.rate = Some(rate);
    }

    /// Creates a follower whose first node is the initial attitude of a path.
    pub fn begun(attitude: &Matrix3) -> Self {
        let mut path = Self::new();
        path.attitude(attitude);
        path
    }

    /// Adds the attitude of the next node, without its rate.
    pub fn attitude(&mut self, attitude: &Matrix3) {
        self.quaternion = Some(continued(self.quaternion.as_ref(), lie::quaternion_from_rotation(attitude)));
        self.end = *attitude;
    }

    /// Returns the homotopy class of the path so far. The path is short if it ends on the sheet of
    /// the double cover that the motion without inputs reaches when it is continued by the shortest
    /// rotation to the target; both start on the same sheet. At exactly half a turn, round-off
    /// decides which rotation is the shortest. The decision is the same for all paths, whatever the
    /// round-off of their own ends.
    pub fn way<const N: usize>(&self, bvp: &BoundaryValueProblem<N>) -> Result<Way, StepError> {
        let ballistic = Self::ballistic(bvp)?;
        let from = &ballistic.end;
        let target = match &bvp.terminal {
            TerminalCondition::State(target) => &target.attitude.value,
            // A path to a free terminal attitude is its own target.
            TerminalCondition::AttitudeFree(_) => &self.end,
        };
        let rest = lie::minus(target, from);
        // The shortest rotation continues the uncontrolled motion to the end of the path.
        let same = ballistic.turned_by(&rest).is_on_the_sheet_of(self);
        let sense = if same { Sense::Short } else { Sense::Long };
        Ok(Way { sense, turned_deg: self.turned_deg(), rotation: self.rotation })
    }

    /// Returns the path continued by a rotation vector in body axes. It is added in steps far below
    /// half a turn, so that the sheet is certain.
    pub fn turned_by(mut self, rotation: &Vector3) -> Self {
        let (from, steps) = (self.end, (rotation.norm() / SMALL_TURN).ceil());
        for step in 1..=steps as usize {
            self.attitude(&(from * lie::exp(&(rotation * (step as f64 / steps)))));
        }
        self
    }

    /// Returns whether two paths with equal ends are on the same sheet of the double cover.
    pub fn is_on_the_sheet_of(&self, other: &Self) -> bool {
        self.lifted().iter().zip(&other.lifted()).map(|(x, y)| x * y).sum::<f64>() >= 0.0
    }

    /// Returns the angle turned so far, `∫|Ω|dt` \[deg\].
    pub fn turned_deg(&self) -> f64 {
        self.turned.to_degrees()
    }

    /// Returns the homotopy class of the path so far; short if the motion without inputs cannot be
    /// computed to its end.
    pub fn way_or_short<const N: usize>(&self, bvp: &BoundaryValueProblem<N>) -> Way {
        let (turned_deg, rotation) = (self.turned_deg(), self.rotation);
        self.way(bvp).unwrap_or(Way { sense: Sense::Short, turned_deg, rotation })
    }

    /// Follows the motion without inputs to its end and returns its follower.
    fn ballistic<const N: usize>(bvp: &BoundaryValueProblem<N>) -> Result<Self, StepError> {
        let mut follower = Self::new();
        bvp.coast(|attitude| follower.attitude(attitude))?;
        Ok(follower)
    }

    /// Follows the extremal whose first costate is `costate`.
    pub fn of<const N: usize>(
        bvp: &BoundaryValueProblem<N>,
        costate: &SVector<f64, N>,
    ) -> Result<Self, StepError> {
        let dynamics = &bvp.dynamics;
        let mut follower = Self::new();
        bvp.sweep_observed(costate, |node| {
            let point = node.physical();
            let rate = dynamics.j_inverse * point.momentum.value;
            follower.node(&point.attitude.value, rate, dynamics.grid.step(node.index.saturating_sub(1)));
        })?;
        Ok(follower)
    }

    /// Returns the attitude error at the end of the path \[rad\].
    pub fn miss<const N: usize>(&self, bvp: &BoundaryValueProblem<N>) -> f64 {
        lie::minus(&bvp.terminal.target().attitude.value, &self.end).norm()
    }

    /// Returns the quaternion of the last node, continuous along the path.
    pub fn lifted(&self) -> [f64; 4] {
        self.quaternion.unwrap_or([1.0, 0.0, 0.0, 0.0])
    }
}
