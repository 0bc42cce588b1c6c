//! Discrete minimum-time and minimum-fuel extremals: every switch is at the end of a step.
//!
//! Arc a, of duration `d_a`, has `N_a` equal steps of length `d_a/N_a`, so that inputs are held at
//! their limits over every step. The unknowns are the costates before the first step and the
//! durations `d_a`. There are six terminal conditions. In addition, the mean discrete Hamiltonians
//! of all arcs must be equal, and zero if the duration is free; the discrete action is then
//! stationary in every `d_a`. Under a smoothed law all steps have one common length. As in the
//! smoothed problem, every step starts from its own node, and a Newton step updates the nodes
//! together with the unknowns (`sequence`).

use super::extremal::Extremal;
use super::flow::Node;
use super::sequence::{Sequence, Step, SweptArcs, free_lengths};
use super::tuning::arcs::DETERMINED;
use super::tuning::grid::*;
use super::tuning::pulses::NEARBY_ON_GRID;
use super::tuning::smooth::{DECREASE, MOST_TRIALS, SHORTENED};
use super::tuning::{NO_LENGTH, UNDETERMINED};
use crate::Vector3;
use crate::optimize::nlp::kkt::{KktSystem, NewtonSteps, untied};
use nalgebra::{DMatrix, DVector, Vector6};

/// A maneuver on a grid of arcs.
#[derive(Clone, Debug)]
pub(crate) struct OnGrid {
    pub m: Vector3,
    /// Duration of each arc.
    pub lengths: Vec<f64>,
    pub steps: Vec<Step>,
    /// Signs of the inputs on each arc; empty under a smoothed law.
    pub signs: Vec<Vec<f64>>,
    /// Nodes at the ends of the steps: one more than steps.
    pub nodes: Vec<Node>,
    /// Torque held over each step.
    pub torques: Vec<Vector3>,
    /// Residual of the terminal conditions and of stationarity in the last sweep.
    pub residual: f64,
    pub iterations: usize,
    /// True if the grid meets the terminal conditions but is not stationary, so that it is no
    /// discrete optimum.
    pub beside_optimum: bool,
    /// Derivatives of the arc lengths with respect to the free times, for pulses whose other times
    /// are at bounds; `None` if all lengths are free.
    pub of_free_times: Option<DMatrix<f64>>,
}

impl OnGrid {
    /// Creates a grid for arcs with the given steps, from nodes of a continuous extremal.
    pub fn new(
        m: Vector3,
        lengths: Vec<f64>,
        steps: Vec<Step>,
        signs: Vec<Vec<f64>>,
        nodes: Vec<Node>,
    ) -> Self {
        Self {
            m,
            lengths,
            steps,
            signs,
            nodes,
            torques: Vec::new(),
            residual: f64::NAN,
            iterations: 0,
            beside_optimum: false,
            of_free_times: None,
        }
    }

    pub fn duration(&self) -> f64 {
        self.lengths.iter().sum()
    }

    /// Returns the duration of a step, scaled.
    pub fn step_length(&self, step: &Step) -> f64 {
        self.lengths[step.arc] * step.part
    }

    /// Returns the derivatives of the arc lengths with respect to the free lengths or times.
    fn free(&self, extremal: &Extremal) -> DMatrix<f64> {
        let all = || free_lengths(self.lengths.len(), extremal.given_duration.is_some());
        self.of_free_times.clone().unwrap_or_else(all)
    }

    /// Sweeps over the grid once. Returns the result of the sweep, and the KKT system in costates
    /// and free lengths.
    fn swept(&self, extremal: &Extremal) -> Option<(SweptArcs, KktSystem)> {
        let Self { m, lengths, steps, nodes, .. } = self;
        let beside = Sequence::AT_THE_NODE;
        let sequence = Sequence { m, lengths, steps, nodes, beside, longest: None };
        let swept = sequence.swept(extremal)?;
        let kkt = swept.kkt.tied(&self.free(extremal));
        Some((swept, kkt))
    }

    /// Returns the kind of Newton step, depending on whether the costates are determined: by a
    /// smoothed law, or by enough switches.
    fn steps_of_newton(&self) -> NewtonSteps {
        match &self.of_free_times {
            Some(_) if self.beside_optimum => NewtonSteps::Feasible,
            None if self.signs.is_empty() || self.lengths.len() > DETERMINED => NewtonSteps::Determined,
            _ => NewtonSteps::Shortest,
        }
    }

    /// Solves by Newton to round-off; `None` if it does not converge. An arc may have zero or
    /// negative length in the solution.
    ///
    /// Full steps need the fewest iterations and cross regions where damped steps stall. If full
    /// steps fail, damped steps may converge. For pulses whose times are at bounds, the solution
    /// must be near the initial guess.
    pub fn solve(self, extremal: &Extremal) -> Option<Self> {
        let whole = self.clone().newton(1, 0.0, MOST_ITERATIONS, extremal);
        if self.of_free_times.is_some() {
            let near = |found: &Self| {
                let mut pairs = found.lengths.iter().zip(&self.lengths);
                pairs.all(|(length, first)| (length - first).abs() < NEARBY_ON_GRID * found.duration())
            };
            return whole.filter(near);
        }
        whole.or_else(|| self.newton(MOST_TRIALS, 0.0, MOST_ITERATIONS, extremal))
    }

    /// Solves the grid for a maneuver with a slightly different terminal state, from a warm start;
    /// `None` if Newton does not converge or an arc would have negative length.
    pub fn again(&self, extremal: &Extremal) -> Option<Self> {
        self.clone().solve(extremal).filter(|found| found.shorter_than_nothing().is_none())
    }

    /// Iterates Newton until the residual is below `enough` or at round-off, in at most `most`
    /// steps. With one trial per step, all steps are full; with several, a line search reduces the
    /// residual.
    pub(super) fn newton(
        mut self,
        trials: usize,
        enough: f64,
        most: usize,
        extremal: &Extremal,
    ) -> Option<Self> {
        if let (Some(given), None) = (extremal.given_duration, &self.of_free_times) {
            let factor = given / self.duration();
            self.lengths.iter_mut().for_each(|length| *length *= factor);
        }
        let steps = self.steps_of_newton();
        let merit = |(swept, kkt): &(SweptArcs, KktSystem)| kkt.merit(steps).hypot(swept.gaps.sqrt());
        let mut at = self.swept(extremal)?;
        let mut last = f64::INFINITY;
        for iteration in 0..most {
            let size = merit(&at);
            if size < enough || self.is_solved(size, last) {
                self.residual = at.1.residual.norm().hypot(at.0.gaps.sqrt());
                (self.torques, self.iterations) = (at.0.torques, iteration);
                return Some(self);
            }
            last = size;
            let step = at.1.newton_step(steps, UNDETERMINED)?;
            let mut factor = match self.of_free_times {
                Some(_) => 1.0,
                None => {
                    let costate = (self.m.norm_squared() + self.nodes[0].e.norm_squared()).sqrt();
                    (costate / step.rows(0, 6).norm()).min(1.0)
                }
            };
            (self, at) = (0..trials).find_map(|_| {
                let trial = self.moved(&step, &at.0, factor, extremal);
                let least = (1.0 - DECREASE * factor) * last;
                factor *= SHORTENED;
                let next = trial.swept(extremal)?;
                // At round-off the residual does not decrease further.
                let good = trials == 1 || merit(&next) < least || trial.is_solved(merit(&next), last);
                good.then_some((trial, next))
            })?;
        }
        None
    }

    /// Returns whether a residual is at round-off: small, with rounding errors of every step added,
    /// and not much below the previous one.
    fn is_solved(&self, residual: f64, last: f64) -> bool {
        let enough = CONVERGED.max(f64::EPSILON * self.steps.len() as f64);
        residual < enough && residual >= FALLING * last
    }

    /// Corrects costates and lengths so that the terminal error `miss` vanishes. The caller
    /// computes `miss` more accurately than a sweep, which rounds its products of rotations.
    pub fn nearer(self, extremal: &Extremal, miss: &Vector6<f64>) -> Option<Self> {
        let (swept, mut kkt) = self.swept(extremal)?;
        kkt.carried.fill(0.0);
        kkt.carried.rows_mut(0, 6).copy_from(miss);
        let step = kkt.newton_step(self.steps_of_newton(), UNDETERMINED)?;
        let moved = self.moved(&step, &swept, 1.0, extremal);
        let (SweptArcs { torques, gaps, .. }, kkt) = moved.swept(extremal)?;
        Some(Self { torques, residual: kkt.residual.norm().hypot(gaps.sqrt()), ..moved })
    }

    /// Returns the grid after the fraction `factor` of a Newton step of costates and free lengths,
    /// with the nodes updated.
    fn moved(&self, step: &DVector<f64>, swept: &SweptArcs, factor: f64, extremal: &Extremal) -> Self {
        let step = untied(&self.free(extremal), step);
        let lengths = self.lengths.iter().zip(step.iter().skip(6));
        let nodes = self.nodes.iter().zip(swept.disturbances(&step));
        Self {
            m: self.m + factor * step.fixed_rows::<3>(0),
            lengths: lengths.map(|(length, change)| length + factor * change).collect(),
            nodes: nodes.map(|(node, moved)| node.plus(&moved, factor)).collect(),
            ..self.clone()
        }
    }

    /// Returns the index of an arc with negative length; `None` if all lengths are at least zero.
    pub(super) fn shorter_than_nothing(&self) -> Option<usize> {
        let least = -NO_LENGTH * self.duration();
        self.lengths.iter().position(|length| *length < least)
    }
}
