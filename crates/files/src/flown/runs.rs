//! A plan that is flown many times, with its gains and without.

use super::{Flight, Mark};
use crate::spec::ClosedLoop;
use slewkit::assured::Beside;
use slewkit::closed_loop::Campaign;
use slewkit::maneuver::Problem;
use slewkit::uncertainty::Uncertainty;

/// The data that determine every case.
#[derive(Clone, Copy, Debug)]
pub struct Runs<'a> {
    /// The maneuver, on the grid of the plan.
    pub problem: &'a Problem,
    /// The gains and the plant.
    pub closed_loop: &'a ClosedLoop,
    /// The uncertainty of the craft.
    pub uncertainty: &'a Uncertainty,
    /// Gains and covariances along the plan.
    pub beside: &'a Beside,
    /// The instants at which the craft has to be at a stop, of a sequence.
    pub marks: &'a [Mark],
    /// Seed of the random numbers.
    pub seed: u64,
    /// The number of threads; `None` for all available threads. They change no result.
    pub threads: Option<usize>,
}

impl<'a> Runs<'a> {
    /// Returns the name of a loop.
    pub fn name(closed: bool) -> &'static str {
        if closed { "closed loop" } else { "open loop" }
    }

    /// Returns the flights of a loop.
    pub fn campaign(&self, closed: bool) -> Campaign<'a> {
        let gains = self.beside.gains.as_ref().filter(|_| closed);
        let Self { problem, closed_loop, uncertainty, beside, seed, threads, .. } = *self;
        Campaign::new(problem, &beside.linear, gains, uncertainty, closed_loop.plant, seed)
            .with_threads(threads)
    }

    /// Builds a loop without cases, with its linear prediction; `None` without gains.
    pub fn flight(&self, closed: bool) -> Option<Flight<'a>> {
        let covariance = if closed { &self.beside.closed } else { &self.beside.open };
        let covariance = covariance.as_ref()?;
        Some(Flight { name: Self::name(closed), covariance, cases: Vec::new() })
    }
}
