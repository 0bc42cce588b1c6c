//! Extremals on the coarse grid, and paths that were lost on the transfer to the requested grid.

use crate::numerics::factor::effective;
use crate::optimize::methods::method::Attempt;
use nalgebra::SVector;

/// Relative difference of costates below which two extremals are the same.
pub(super) const SAME: f64 = 1e-6;

/// Coarse-grid results of the strategies without limits.
#[derive(Default)]
pub(super) struct Pool<const N: usize> {
    /// Extremals to be transferred to the requested grid.
    waiting: Vec<Attempt>,
    /// Costates of all extremals found.
    met: Vec<SVector<f64, N>>,
    /// Starts that led to an extremal, new or known.
    arrived: Vec<String>,
    /// Paths of minima or extremals for which the requested grid has no extremal nearby.
    lost: Vec<Attempt>,
    /// Extremals that cost too much to be transferred to the requested grid.
    pub rivals: Vec<Attempt>,
    /// True if descents have been tried.
    pub descended: bool,
}

impl<const N: usize> Pool<N> {
    /// Adds an extremal, unless it is a duplicate.
    pub fn add(&mut self, extremal: Attempt) {
        let coarse = &extremal.candidate;
        self.arrived.push(coarse.provenance.start.clone());
        let costate = coarse.costate::<N>();
        // With a symmetry, the costates of one extremal may differ by a part that has no effect; it
        // is omitted.
        let effective = coarse.sensitivity().map_or(costate, |psi| effective(&psi, &costate));
        let scale = effective.amax().max(1.0);
        if !self.met.iter().any(|met| (met - effective).amax() < SAME * scale) {
            self.met.push(effective);
            self.waiting.push(extremal);
        }
    }

    /// Adds a path near which no extremal of the requested grid was found.
    pub fn lose(&mut self, path: Attempt) {
        self.lost.push(path);
    }

    /// Returns the extremals to be transferred to the requested grid.
    pub fn waiting(&self) -> &[Attempt] {
        &self.waiting
    }

    /// Returns whether a start led to an extremal.
    pub fn has_arrived(&self, start: &str) -> bool {
        self.arrived.iter().any(|arrived| arrived == start)
    }

    /// Removes and returns the extremals to be transferred to the requested grid.
    pub fn take_waiting(&mut self) -> Vec<Attempt> {
        std::mem::take(&mut self.waiting)
    }

    /// Removes and returns the lost paths.
    pub fn take_lost(&mut self) -> Vec<Attempt> {
        std::mem::take(&mut self.lost)
    }
}
