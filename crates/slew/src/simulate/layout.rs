//! Properties of a simulation that its rows and its report depend on.

use slewkit::mechanics::Symmetry;

/// The properties that all rows of a simulation share.
pub struct Layout {
    pub name: String,
    pub integrator: &'static str,
    pub bodies: Vec<String>,
    /// For each body, true if it has a position and a velocity.
    pub moves: Vec<bool>,
    pub duration: f64,
    pub steps: u64,
    pub stride: u64,
    /// Symmetry of the environment, which determines the momenta that are conserved.
    pub symmetry: Symmetry,
    /// True if the energy is conserved, because no inputs do work.
    pub keeps_energy: bool,
    /// Initial momentum of each reaction wheel \[N·m·s\], and its constant rate of change under the
    /// held inputs \[N·m\].
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
