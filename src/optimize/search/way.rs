//! Which way round a path goes, told on the double cover of the rotations.
//!
//! # What are senses and windings?
//!
//! The same two attitudes are joined by the short way, the long way, and each with more turns:
//! different extremals. `path = "best"` compares what its search finds; the others stay in the
//! solution as rivals, with cost and conjugate points. They are counted from the end of the
//! uncontrolled motion, not from the start, because with boundary rates the way that looks shorter
//! need not be the one that costs less. The sense of a result is read off the continuous quaternion
//! of its path.

use crate::lie::{self, continued};
use crate::maneuver::solution::Sense;
use crate::optimize::discrete::step::StepError;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::discrete::terminal::TerminalCondition;
use crate::{Matrix3, Vector3};
use nalgebra::SVector;

/// A turn over which the quaternion is told from its opposite \[rad\].
const SMALL_TURN: f64 = 0.2;

/// How a path goes round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Its sense.
    pub sense: Sense,
    /// `∫|Ω|dt` \[deg\].
    pub turned_deg: f64,
    /// `∫Ω dt`, body axes \[rad\]: the rotation vector, where the axis is fixed.
    pub rotation: Vector3,
}

/// A path followed node after node: its continuous quaternion, and how far it has turned.
#[derive(Clone, Copy, Debug)]
pub(super) struct Follower {
    quaternion: Option<[f64; 4]>,
    end: Matrix3,
    rate: Option<Vector3>,
    turned: f64,
    rotation: Vector3,
}

impl Follower {
    /// Before the first node.
    pub fn new() -> Self {
        let (end, rotation) = (Matrix3::identity(), Vector3::zeros());
        Self { quaternion: None, end, rate: None, turned: 0.0, rotation }
    }

    /// The next node: its attitude and its angular velocity (body axes, scaled), `h` after the one
    /// before.
    pub fn node(&mut self, attitude: &Matrix3, rate: Vector3, h: f64) {
        self.attitude(attitude);
        if let Some(before) = self.rate {
            let half = 0.5 * h;
            self.turned += half * (rate.norm() + before.norm());
            self.rotation += (rate + before) * half;
        }
        self.rate = Some(rate);
    }

    /// Where a path begins.
    pub fn begun(attitude: &Matrix3) -> Self {
        let mut path = Self::new();
        path.attitude(attitude);
        path
    }

    /// The attitude of the next node alone.
    pub fn attitude(&mut self, attitude: &Matrix3) {
        self.quaternion = Some(continued(self.quaternion.as_ref(), lie::quaternion_from_rotation(attitude)));
        self.end = *attitude;
    }

    /// The way so far. The path is short if it ends on the sheet that the motion without inputs
    /// reaches by the shortest rotation to the target; both start equal. Half a turn away rounding
    /// chooses which rotation that is: it is the same for all paths, whatever the last bits of
    /// their own ends.
    pub fn way<const N: usize>(&self, bvp: &BoundaryValueProblem<N>) -> Result<Way, StepError> {
        let ballistic = Self::ballistic(bvp)?;
        let from = &ballistic.end;
        let target = match &bvp.terminal {
            TerminalCondition::State(target) => &target.attitude.value,
            // Any attitude is the end of the path that leads there.
            TerminalCondition::AttitudeFree(_) => &self.end,
        };
        let rest = lie::minus(target, from);
        // The shortest rotation carries the ballistic sheet to the end of the path.
        let same = ballistic.turned_by(&rest).is_on_the_sheet_of(self);
        let sense = if same { Sense::Short } else { Sense::Long };
        Ok(Way { sense, turned_deg: self.turned_deg(), rotation: self.rotation })
    }

    /// The same path, turned on by a rotation vector in body axes: in steps far below half a turn,
    /// which leave no doubt of the sheet.
    pub fn turned_by(mut self, rotation: &Vector3) -> Self {
        let (from, steps) = (self.end, (rotation.norm() / SMALL_TURN).ceil());
        for step in 1..=steps as usize {
            self.attitude(&(from * lie::exp(&(rotation * (step as f64 / steps)))));
        }
        self
    }

    /// Whether both paths, begun alike and ended alike, end on one sheet.
    pub fn is_on_the_sheet_of(&self, other: &Self) -> bool {
        self.lifted().iter().zip(&other.lifted()).map(|(x, y)| x * y).sum::<f64>() >= 0.0
    }

    /// `∫|Ω|dt` so far \[deg\].
    pub fn turned_deg(&self) -> f64 {
        self.turned.to_degrees()
    }

    /// The same; short where the motion without inputs cannot be followed to its end and tells
    /// nothing.
    pub fn way_or_short<const N: usize>(&self, bvp: &BoundaryValueProblem<N>) -> Way {
        let (turned_deg, rotation) = (self.turned_deg(), self.rotation);
        self.way(bvp).unwrap_or(Way { sense: Sense::Short, turned_deg, rotation })
    }

    /// The sheet that the motion without inputs ends on.
    fn ballistic<const N: usize>(bvp: &BoundaryValueProblem<N>) -> Result<Self, StepError> {
        let mut follower = Self::new();
        bvp.coast(|attitude| follower.attitude(attitude))?;
        Ok(follower)
    }

    /// The path of the extremal from `costate`.
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

    /// How far from its target the path ends \[rad\].
    pub fn miss<const N: usize>(&self, bvp: &BoundaryValueProblem<N>) -> f64 {
        lie::minus(&bvp.terminal.target().attitude.value, &self.end).norm()
    }

    /// The quaternion of the last node, continuous along the path.
    pub fn lifted(&self) -> [f64; 4] {
        self.quaternion.unwrap_or([1.0, 0.0, 0.0, 0.0])
    }
}
