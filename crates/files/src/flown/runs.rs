//! A plan that is flown many times, with its gains and without.

use super::Flight;
use crate::spec::ClosedLoop;
use slewkit::assured::Beside;
use slewkit::closed_loop::Campaign;
use slewkit::maneuver::Problem;
use slewkit::uncertainty::Uncertainty;

/// What decides every case.
#[derive(Clone, Copy, Debug)]
pub struct Runs<'a> {
    /// The maneuver, on the grid of the plan.
    pub problem: &'a Problem,
    /// What it is flown with.
    pub closed_loop: &'a ClosedLoop,
    /// What the craft differs by.
    pub uncertainty: &'a Uncertainty,
    /// Gains and covariances along the plan.
    pub beside: &'a Beside,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Threads; those there are where none are given. They change no result.
    pub threads: Option<usize>,
}

impl<'a> Runs<'a> {
    /// What a loop is called.
    pub fn name(closed: bool) -> &'static str {
        if closed { "closed loop" } else { "open loop" }
    }

    /// The flights of a loop.
    pub fn campaign(&self, closed: bool) -> Campaign<'a> {
        let gains = self.beside.gains.as_ref().filter(|_| closed);
        let Self { problem, closed_loop, uncertainty, beside, seed, threads } = *self;
        Campaign::new(problem, &beside.linear, gains, uncertainty, closed_loop.plant, seed)
            .with_threads(threads)
    }

    /// A loop without cases, beside its linear prediction; `None` where there is none.
    pub fn flight(&self, closed: bool) -> Option<Flight<'a>> {
        let covariance = if closed { &self.beside.closed } else { &self.beside.open };
        let covariance = covariance.as_ref()?;
        Some(Flight { name: Self::name(closed), covariance, cases: Vec::new() })
    }
}
