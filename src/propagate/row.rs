//! The output rows of a propagation and their receiver.

use crate::Vector3;
use crate::propagate::integrator::Invariants;
use std::ops::ControlFlow;

/// The state of one body at one time, SI units, in the frames of the crate's conventions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyState {
    /// Attitude quaternion `[w, x, y, z]` from body to reference, with signs continuous along the
    /// motion.
    pub quaternion: [f64; 4],
    /// Angular velocity, body axes [rad/s].
    pub angular_velocity: Vector3,
    /// Position, reference frame \[m\].
    pub position: Vector3,
    /// Velocity, reference frame [m/s]; zero for a body that only turns.
    pub velocity: Vector3,
    /// Angular momentum stored in the wheels, body axes [N·m·s]; zero without wheels.
    pub stored_momentum: Vector3,
}

/// The states of all bodies at one time.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SimulationRow {
    /// Time since the start \[s\].
    pub time: f64,
    /// The states of the bodies, in the order of the system.
    pub bodies: Vec<BodyState>,
    /// Energy, momenta and orthogonality. The momenta are in inertial axes, even if the reference
    /// frame rotates.
    pub invariants: Invariants,
}

impl SimulationRow {
    /// Returns whether all numbers of the row are finite. Energy and momenta of very large finite
    /// states overflow.
    pub fn is_finite(&self) -> bool {
        let Invariants { energy, linear_momentum, angular_momentum, orthogonality } = &self.invariants;
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        finite(&[self.time, *energy, *orthogonality])
            && finite(linear_momentum.as_slice())
            && finite(angular_momentum.as_slice())
            && self.bodies.iter().all(|body| {
                let vectors = [body.angular_velocity, body.position, body.velocity, body.stored_momentum];
                finite(&body.quaternion) && vectors.iter().all(|vector| finite(vector.as_slice()))
            })
    }
}

/// The receiver of the rows of a simulation. A closure that accepts rows is an observer.
pub trait Observer {
    /// Receives a row. `Break` ends the simulation.
    fn on_row(&mut self, row: &SimulationRow) -> ControlFlow<()>;

    /// Receives the number of steps made so far, after each step; it must be fast. `Break` ends the
    /// simulation, with a last row for the present state.
    fn on_step(&mut self, _steps: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl<F: FnMut(&SimulationRow) -> ControlFlow<()>> Observer for F {
    fn on_row(&mut self, row: &SimulationRow) -> ControlFlow<()> {
        self(row)
    }
}
