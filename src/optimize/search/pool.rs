//! Extremals of the coarse grid, and what was lost on the way from there.

use crate::numerics::factor::effective;
use crate::optimize::methods::method::Attempt;
use nalgebra::SVector;

/// Two extremals whose costates differ by less, relative, are one.
pub(super) const SAME: f64 = 1e-6;

/// What the rungs without limits know of the coarse grid.
#[derive(Default)]
pub(super) struct Pool<const N: usize> {
    /// Extremals that wait for the requested grid.
    waiting: Vec<Attempt>,
    /// Costates of all that were met.
    met: Vec<SVector<f64, N>>,
    /// Starts that have led to an extremal, new or known.
    arrived: Vec<String>,
    /// Minima, or extremals as paths, that no extremal of the requested grid was found near.
    lost: Vec<Attempt>,
    /// Extremals that are too dear for the requested grid.
    pub rivals: Vec<Attempt>,
    /// Whether descents have been tried.
    pub descended: bool,
}

impl<const N: usize> Pool<N> {
    /// Adds an extremal, once.
    pub fn add(&mut self, extremal: Attempt) {
        let coarse = &extremal.candidate;
        self.arrived.push(coarse.provenance.start.clone());
        let costate = coarse.costate::<N>();
        // Under a symmetry costates of one extremal differ by what has no effect: leave that out.
        let effective = coarse.sensitivity().map_or(costate, |psi| effective(&psi, &costate));
        let scale = effective.amax().max(1.0);
        if !self.met.iter().any(|met| (met - effective).amax() < SAME * scale) {
            self.met.push(effective);
            self.waiting.push(extremal);
        }
    }

    /// Adds a path that no extremal of the requested grid was found near.
    pub fn lose(&mut self, path: Attempt) {
        self.lost.push(path);
    }

    /// Extremals that wait for the requested grid.
    pub fn waiting(&self) -> &[Attempt] {
        &self.waiting
    }

    /// Whether a start has led to an extremal.
    pub fn has_arrived(&self, start: &str) -> bool {
        self.arrived.iter().any(|arrived| arrived == start)
    }

    /// Hands over what waits for the requested grid.
    pub fn take_waiting(&mut self) -> Vec<Attempt> {
        std::mem::take(&mut self.waiting)
    }

    /// Hands over what was lost.
    pub fn take_lost(&mut self) -> Vec<Attempt> {
        std::mem::take(&mut self.lost)
    }
}
