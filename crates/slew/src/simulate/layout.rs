//! The layout of the rows and the report of a simulation.

use slewkit::mechanics::Symmetry;

/// The common properties of all rows of a simulation.
pub struct Layout {
    pub name: String,
    pub integrator: &'static str,
    pub bodies: Vec<String>,
    /// Whether each body has position and velocity.
    pub moves: Vec<bool>,
    pub duration: f64,
    pub steps: u64,
    pub stride: u64,
    /// The symmetry that determines the conserved momenta.
    pub symmetry: Symmetry,
    /// Whether the energy is: no inputs work.
    pub keeps_energy: bool,
    /// Momentum of each reaction wheel at the start, and its rate of change under the held inputs.
    pub wheels: Vec<(f64, f64)>,
}

impl Layout {
    /// Returns whether any body has position and velocity.
    pub fn anything_moves(&self) -> bool {
        self.moves.contains(&true)
    }

    /// Returns the momentum of each wheel [N·m·s].
    pub fn wheel_momenta(&self, time: f64) -> Vec<f64> {
        self.wheels.iter().map(|(start, rate)| start + time * rate).collect()
    }
}
