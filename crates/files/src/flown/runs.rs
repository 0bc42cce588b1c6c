//! Repeated simulated flights of a plan, in closed and in open loop.

use super::{Flight, Mark};
use crate::spec::ClosedLoop;
use slewkit::assured::Beside;
use slewkit::closed_loop::Campaign;
use slewkit::maneuver::Problem;
use slewkit::uncertainty::Uncertainty;

/// Data that determine the simulated flights of a plan.
#[derive(Clone, Copy, Debug)]
pub struct Runs<'a> {
    /// Maneuver on the grid of the plan.
    pub problem: &'a Problem,
    /// Feedback settings and model of the plant.
    pub closed_loop: &'a ClosedLoop,
    /// Uncertain quantities and their distributions.
    pub uncertainty: &'a Uncertainty,
    /// Gains and covariances along the plan.
    pub beside: &'a Beside,
    /// Instants at which the spacecraft must have reached a stop; empty for a single maneuver.
    pub marks: &'a [Mark],
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of threads, which does not affect the results; `None` to use all available threads.
    pub threads: Option<usize>,
}

impl<'a> Runs<'a> {
    /// Returns the name of the closed or open loop.
    pub fn name(closed: bool) -> &'static str {
        if closed { "closed loop" } else { "open loop" }
    }

    /// Returns the simulated flights in closed loop if `closed` is true, otherwise in open loop.
    pub fn campaign(&self, closed: bool) -> Campaign<'a> {
        let gains = self.beside.gains.as_ref().filter(|_| closed);
        let Self { problem, closed_loop, uncertainty, beside, seed, threads, .. } = *self;
        Campaign::new(problem, &beside.linear, gains, uncertainty, closed_loop.plant, seed)
            .with_threads(threads)
    }

    /// Returns the linear prediction for the closed or open loop, with an empty list of cases;
    /// `None` if the prediction does not exist.
    pub fn flight(&self, closed: bool) -> Option<Flight<'a>> {
        let covariance = if closed { &self.beside.closed } else { &self.beside.open };
        let covariance = covariance.as_ref()?;
        Some(Flight { name: Self::name(closed), covariance, cases: Vec::new() })
    }
}
