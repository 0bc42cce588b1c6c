//! The output of a propagation, row after row.

use crate::Vector3;
use crate::propagate::integrator::Invariants;
use std::ops::ControlFlow;

/// One body at one moment, SI units, frames as in the crate's conventions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyState {
    /// Attitude quaternion `[w, x, y, z]`, continuous along the motion.
    pub quaternion: [f64; 4],
    /// Angular velocity, body axes [rad/s].
    pub angular_velocity: Vector3,
    /// Position, reference frame \[m\].
    pub position: Vector3,
    /// Velocity, reference frame [m/s]; zero for a body that only turns.
    pub velocity: Vector3,
    /// Momentum that its wheels store, body axes [N·m·s]; zero without wheels.
    pub stored_momentum: Vector3,
}

/// One moment of the motion.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SimulationRow {
    /// Time \[s\].
    pub time: f64,
    /// The bodies, in the order of the system.
    pub bodies: Vec<BodyState>,
    /// Energy, momenta and orthogonality; the momenta in inertial axes, also where the reference
    /// frame turns.
    pub invariants: Invariants,
}

impl SimulationRow {
    /// Returns whether all its numbers are finite. Energy and momenta of huge finite states
    /// overflow.
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

/// The receiver of a simulation. A closure that accepts rows is an observer.
pub trait Observer {
    /// Receives a row. `Break` ends the simulation.
    fn on_row(&mut self, row: &SimulationRow) -> ControlFlow<()>;

    /// Receives the number of steps after each step, and must be fast. `Break` ends the
    /// simulation, with a last row of the state reached.
    fn on_step(&mut self, _steps: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl<F: FnMut(&SimulationRow) -> ControlFlow<()>> Observer for F {
    fn on_row(&mut self, row: &SimulationRow) -> ControlFlow<()> {
        self(row)
    }
}
