//! The layout of the rows and the report of a simulation.

use slewkit::mechanics::Symmetry;

/// The properties that all rows of a simulation share.
pub struct Layout {
    pub name: String,
    pub integrator: &'static str,
    pub bodies: Vec<String>,
    /// For each body, true if it has position and velocity.
    pub moves: Vec<bool>,
    pub duration: f64,
    pub steps: u64,
    pub stride: u64,
    /// The symmetry that determines the conserved momenta.
    pub symmetry: Symmetry,
    /// True if the energy is conserved, because no inputs do work.
    pub keeps_energy: bool,
    /// For each reaction wheel, its momentum at the start [N·m·s], and the constant rate of change
    /// under the held inputs [N·m].
    pub wheels: Vec<(f64, f64)>,
}

impl Layout {
    /// Returns whether any body has position and velocity.
    pub fn anything_moves(&self) -> bool {
        self.moves.contains(&true)
    }

    /// Returns the momentum of each wheel at `time` [N·m·s].
    pub fn wheel_momenta(&self, time: f64) -> Vec<f64> {
        self.wheels.iter().map(|(start, rate)| start + time * rate).collect()
    }
}
