//! A rotating reference frame without a force field.

use slewkit::Vector3;
use slewkit::mechanics::environment::{Blocks, Environment, Pose, Wrench};

/// An environment without forces whose reference frame rotates at this rate, in its own axes
/// [rad/s].
#[derive(Debug)]
pub struct Turning(pub Vector3);

impl Environment for Turning {
    fn potential(&self, _: &Pose) -> f64 {
        0.0
    }
    fn wrench(&self, _: &Pose) -> Wrench {
        Wrench::zero()
    }
    fn gradient(&self, _: &Pose) -> Blocks {
        Blocks::zero()
    }
    fn curvature(&self, _: &Pose, _: &Wrench) -> Blocks {
        Blocks::zero()
    }
    fn frame_rate(&self) -> Vector3 {
        self.0
    }
}
