//! What a propagation hands out, row after row.

use crate::Vector3;
use crate::propagate::integrator::Invariants;
use std::ops::ControlFlow;

/// One body at one moment, SI units, frames as in the crate's conventions.
#[derive(Clone, Copy, Debug, PartialEq)]
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
pub struct SimulationRow {
    /// Time \[s\].
    pub time: f64,
    /// The bodies, in the order of the system.
    pub bodies: Vec<BodyState>,
    /// Energy, momenta and orthogonality; the momenta in inertial axes, also where the reference frame turns.
    pub invariants: Invariants,
}

/// Who follows a simulation. A closure that takes rows is one.
pub trait Observer {
    /// A row. `Break` ends the simulation.
    fn on_row(&mut self, row: &SimulationRow) -> ControlFlow<()>;

    /// So many steps have been made; called after each, so be quick. `Break` ends the simulation, with a last row of
    /// the state reached.
    fn on_step(&mut self, _steps: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl<F: FnMut(&SimulationRow) -> ControlFlow<()>> Observer for F {
    fn on_row(&mut self, row: &SimulationRow) -> ControlFlow<()> {
        self(row)
    }
}
