//! The discrete optimum of minimum time or fuel: arcs whose steps end where the inputs switch.
//!
//! Arc a has `N_a` equal steps of its own length `d_a/N_a`, so that inputs are held at their limits
//! over every step. Unknown are the costates before the first step and the lengths `d_a`; the
//! equations are the six terminal conditions and that the means of the discrete Hamiltonians of all
//! arcs are one, and vanish where the duration is sought: the discrete action is stationary in the
//! length of every arc. Under a smoothed law all steps share one length. Every step starts from its
//! own node, as in the smoothed problem, and the nodes go with the unknowns (`sequence`).

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
    /// Duration of every arc.
    pub lengths: Vec<f64>,
    pub steps: Vec<Step>,
    /// Signs of the inputs of every arc; none under a smoothed law.
    pub signs: Vec<Vec<f64>>,
    /// One more than steps.
    pub nodes: Vec<Node>,
    /// Torques held over the steps.
    pub torques: Vec<Vector3>,
    /// Of the last sweep: terminal conditions and stationarity.
    pub residual: f64,
    pub iterations: usize,
    /// Whether the terminal conditions alone are met.
    pub beside_optimum: bool,
    /// Of pulses whose times are at bounds: how the lengths of the arcs go with the times that are
    /// free.
    pub of_free_times: Option<DMatrix<f64>>,
}

impl OnGrid {
    /// Steps of given counts for arcs, from nodes of a continuous extremal.
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

    /// Length of a step.
    pub fn step_length(&self, step: &Step) -> f64 {
        self.lengths[step.arc] * step.part
    }

    /// How lengths go with those that are free, or with the times that are.
    fn free(&self, extremal: &Extremal) -> DMatrix<f64> {
        let all = || free_lengths(self.lengths.len(), extremal.given_duration.is_some());
        self.of_free_times.clone().unwrap_or_else(all)
    }

    /// One sweep, and its conditions in costates and free lengths.
    fn swept(&self, extremal: &Extremal) -> Option<(SweptArcs, KktSystem)> {
        let Self { m, lengths, steps, nodes, .. } = self;
        let beside = Sequence::AT_THE_NODE;
        let sequence = Sequence { m, lengths, steps, nodes, beside, longest: None };
        let swept = sequence.swept(extremal)?;
        let kkt = swept.kkt.tied(&self.free(extremal));
        Some((swept, kkt))
    }

    /// How Newton steps: a smoothed law determines all costates, and so do enough switches.
    fn steps_of_newton(&self) -> NewtonSteps {
        match &self.of_free_times {
            Some(_) if self.beside_optimum => NewtonSteps::Feasible,
            None if self.signs.is_empty() || self.lengths.len() > DETERMINED => NewtonSteps::Determined,
            _ => NewtonSteps::Shortest,
        }
    }

    /// Newton to round-off; `None` where it does not get there. An arc may come out with no length,
    /// or a negative one.
    ///
    /// Whole steps are quickest, and go over what shortened ones stay behind; where they lead
    /// nowhere, shortened ones may not. Of pulses whose times are at bounds the solution has to be
    /// near.
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

    /// The same grid for a maneuver that ends a little elsewhere, warm; `None` where Newton does
    /// not get there, or an arc would have less than no length.
    pub fn again(&self, extremal: &Extremal) -> Option<Self> {
        self.clone().solve(extremal).filter(|found| found.shorter_than_nothing().is_none())
    }

    /// Newton until the residual is below `enough`, or to round-off, in `most` steps: whole ones
    /// or, where there are several trials of each, such as make the residual smaller.
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
                // Round-off falls no further.
                let good = trials == 1 || merit(&next) < least || trial.is_solved(merit(&next), last);
                good.then_some((trial, next))
            })?;
        }
        None
    }

    /// Whether a residual after the last one is that of a solution: it falls no further, and what a
    /// sweep rounds off at every step adds up.
    fn is_solved(&self, residual: f64, last: f64) -> bool {
        let enough = CONVERGED.max(f64::EPSILON * self.steps.len() as f64);
        residual < enough && residual >= FALLING * last
    }

    /// With costates and lengths by which the end is no longer missed by so much: the miss is known
    /// better than a sweep, whose products of rotations are rounded, tells it.
    pub fn nearer(self, extremal: &Extremal, miss: &Vector6<f64>) -> Option<Self> {
        let (swept, mut kkt) = self.swept(extremal)?;
        kkt.carried.fill(0.0);
        kkt.carried.rows_mut(0, 6).copy_from(miss);
        let step = kkt.newton_step(self.steps_of_newton(), UNDETERMINED)?;
        let moved = self.moved(&step, &swept, 1.0, extremal);
        let (SweptArcs { torques, gaps, .. }, kkt) = moved.swept(extremal)?;
        Some(Self { torques, residual: kkt.residual.norm().hypot(gaps.sqrt()), ..moved })
    }

    /// After a part of a step of costates and free lengths, and the nodes with it.
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

    /// Whether no arc has less than no length.
    pub(super) fn shorter_than_nothing(&self) -> Option<usize> {
        let least = -NO_LENGTH * self.duration();
        self.lengths.iter().position(|length| *length < least)
    }
}
