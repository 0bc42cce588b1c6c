//! The momentum of the wheels, which follows from the inputs alone: `ḣ_i = −u_i`.
//!
//! ```text
//! Lie–Euler   h_i⁺ = h_i − h u_i⁺           Lie–Verlet   h_i⁺ = h_i − (h/2)(u_i + u_i⁺)
//! ```

use super::compensated::Compensated;
use super::motion::Inputs;
use nalgebra::SMatrix;

/// The momenta of the wheels, propagated from node to node.
pub(super) struct Wheels {
    sums: Vec<Compensated<1, 1>>,
    momenta: Vec<f64>,
}

impl Wheels {
    /// Builds the momenta at the start; the list is empty for a body without wheels.
    pub(super) fn new(inputs: &Inputs) -> Self {
        let wheels = inputs.problem.actuation.wheels.as_ref();
        let momenta = wheels.map_or_else(Vec::new, |wheels| wheels.momentum.clone());
        let sums = momenta.iter().map(|h| Compensated::new(SMatrix::from([[*h]]))).collect();
        Self { sums, momenta }
    }

    /// Advances the momenta over step k.
    pub(super) fn advance(&mut self, inputs: &Inputs, k: usize) {
        let step = inputs.problem.step();
        let (from, to) = inputs.held_rows(k);
        let held = inputs.numbers(from).iter().zip(inputs.numbers(to)).map(|(a, b)| 0.5 * (a + b));
        for ((sum, momentum), held) in self.sums.iter_mut().zip(&mut self.momenta).zip(held) {
            sum.add(&SMatrix::from([[-step * held]]));
            *momentum = sum.value()[0];
        }
    }

    /// Returns the momentum of each wheel at the present node [N·m·s].
    pub(super) fn momenta(&self) -> &[f64] {
        &self.momenta
    }
}
