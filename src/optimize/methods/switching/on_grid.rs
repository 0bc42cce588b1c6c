//! The discrete optimum of minimum time or fuel: arcs whose steps end where the inputs switch.
//!
//! Arc a has `N_a` equal steps of its own length `d_a/N_a`, so that inputs are held at their limits over every step.
//! Unknown are the costates before the first step and the lengths `d_a`; the equations are the six terminal
//! conditions and, for every arc, that the mean of its discrete Hamiltonians vanishes: the discrete action is
//! stationary in the length of the arc. Where the duration is given, these means are equal and the lengths have it
//! for their sum. Under a smoothed law all steps share one length. Every step starts from its own node, as in the
//! smoothed problem, and the nodes go with the 6 + arcs unknowns.

#![expect(
    clippy::needless_range_loop,
    reason = "iterators are calls of their own, and narrow in widened code"
)]

use super::arcs::newton_step;
use super::condensed::Condensed;
use super::extremal::Extremal;
use super::flow::{Lanes, Node};
use super::grid_step::{GridStep, Torque};
use super::tuning::grid::*;
use super::tuning::smooth::{DECREASE, MOST_TRIALS, SHORTENED};
use crate::Vector3;
use crate::numerics::three::{apply, apply_transposed, cross, product};
use crate::numerics::widest::widest;
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
    /// Of pulses whose times are at bounds: how the lengths of the arcs go with the times that are free.
    pub of_free_times: Option<DMatrix<f64>>,
}

/// A step of the grid: a part of an arc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub arc: usize,
    /// Its length over that of the arc.
    pub part: f64,
    pub torque: Torque,
}

/// What one sweep over the grid finds: terminal conditions, and the mean Hamiltonians of the arcs.
pub(super) struct Sweep {
    pub equations: Condensed,
    pub torques: Vec<Vector3>,
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

    /// Sweeps over the grid; `None` where a step has no solution, or somebody asks to stop.
    fn sweep<const L: usize>(&self, extremal: &Extremal) -> Option<Sweep> {
        let arcs = self.lengths.len();
        let mut equations = Condensed::new(6 + arcs);
        let mut lanes = Lanes::<L>::of_costate();
        let mut torques = Vec::with_capacity(self.steps.len());
        equations.keep(&lanes);
        for (k, step) in self.steps.iter().enumerate() {
            if extremal.halt.is_raised_at(k) {
                return None;
            }
            let node = &self.nodes[k];
            let m = apply_transposed(&node.r, &self.m);
            let done = extremal.grid_step(
                &m,
                &node.pi,
                [&node.e, &self.nodes[k + 1].e],
                self.step_length(step),
                step.torque,
            )?;
            let slope = widest(
                #[inline(always)]
                || carried(&done, &self.m, node, step, &mut lanes),
            );
            let row = 6 + step.arc;
            equations.residual[row] += step.part * done.hamiltonian;
            for lane in 0..equations.jacobian.ncols() {
                equations.jacobian[(row, lane)] += step.part * slope[lane];
            }
            let reached = Node { r: product(&node.r, &done.f), pi: done.pi, e: done.e };
            equations.gap(&reached, &self.nodes[k + 1], &mut lanes);
            equations.keep(&lanes);
            torques.push(done.torque);
        }
        equations.end(extremal, self.nodes.last()?, &lanes);
        if let Some(given) = extremal.given_duration {
            let Condensed { residual, jacobian, .. } = &mut equations;
            for row in 7..6 + arcs {
                residual[row] -= residual[6];
                for lane in 0..jacobian.ncols() {
                    jacobian[(row, lane)] -= jacobian[(6, lane)];
                }
            }
            residual[6] = self.duration() - given;
            jacobian.row_mut(6).fill(0.0);
            jacobian.view_mut((6, 6), (1, arcs)).fill(1.0);
        }
        Some(Sweep { equations: equations.closed()?, torques })
    }

    /// One sweep with lanes enough; `None` for more arcs than there are lanes.
    pub(super) fn swept(&self, extremal: &Extremal) -> Option<Sweep> {
        match 7 + self.lengths.len() {
            ..=8 => self.sweep::<8>(extremal),
            9..=16 => self.sweep::<16>(extremal),
            17..=32 => self.sweep::<32>(extremal),
            33..=64 => self.sweep::<64>(extremal),
            _ => None,
        }
    }

    /// Newton to round-off; `None` where it does not get there. An arc may come out with no length, or a negative one.
    ///
    /// Whole steps are quickest, and go over what shortened ones stay behind; where they lead nowhere, shortened ones may not.
    pub fn solve(self, extremal: &Extremal) -> Option<Self> {
        self.clone().solve_to(0.0, MOST_ITERATIONS, extremal).or_else(|| self.descended(extremal))
    }

    /// Newton until the residual is below `enough`, or to round-off, in `most` iterations.
    pub fn solve_to(mut self, enough: f64, most: usize, extremal: &Extremal) -> Option<Self> {
        let mut last = f64::INFINITY;
        for iteration in 0..most {
            let Sweep { equations, torques } = self.swept(extremal)?;
            if equations.merit < enough || self.is_solved(equations.merit, last) {
                (self.torques, self.residual, self.iterations) = (torques, equations.merit, iteration);
                return Some(self);
            }
            last = equations.merit;
            let (step, factor) = self.newton_step(&equations)?;
            self.take(&step, &equations, factor);
        }
        None
    }

    /// Newton to round-off by steps that make the residual smaller.
    fn descended(mut self, extremal: &Extremal) -> Option<Self> {
        let mut sweep = self.swept(extremal)?;
        let mut last = f64::INFINITY;
        for iteration in 0..MOST_ITERATIONS {
            let Sweep { equations, torques } = sweep;
            if self.is_solved(equations.merit, last) {
                (self.torques, self.residual, self.iterations) = (torques, equations.merit, iteration);
                return Some(self);
            }
            last = equations.merit;
            let (step, mut factor) = self.newton_step(&equations)?;
            (self, sweep) = (0..MOST_TRIALS).find_map(|_| {
                let mut trial = self.clone();
                trial.take(&step, &equations, factor);
                let least = (1.0 - DECREASE * factor) * last;
                factor *= SHORTENED;
                let swept = trial.swept(extremal)?;
                let merit = swept.equations.merit;
                // Round-off falls no further.
                (merit < least || trial.is_solved(merit, last)).then_some((trial, swept))
            })?;
        }
        None
    }

    /// A step of Newton, and how much of it costates can take.
    fn newton_step(&self, equations: &Condensed) -> Option<(DVector<f64>, f64)> {
        let step = newton_step(equations, self.switches())?;
        let costate = (self.m.norm_squared() + self.nodes[0].e.norm_squared()).sqrt();
        let factor = (costate / step.rows(0, 6).norm()).min(1.0);
        Some((step, factor))
    }

    /// Whether a residual after the last one is that of a solution: what a sweep rounds off at every step adds up.
    fn is_solved(&self, residual: f64, last: f64) -> bool {
        is_round_off(residual, last, CONVERGED.max(f64::EPSILON * self.steps.len() as f64))
    }

    /// How many switches determine costates: a smoothed law determines all.
    fn switches(&self) -> usize {
        if self.signs.is_empty() { usize::MAX } else { self.lengths.len() - 1 }
    }

    /// With costates and lengths by which the end is no longer missed by so much: the miss is known better than a sweep, whose products
    /// of rotations are rounded, tells it. `None` where lengths are not free.
    pub fn nearer(mut self, extremal: &Extremal, miss: &Vector6<f64>) -> Option<Self> {
        if self.of_free_times.is_some() {
            return None;
        }
        let Sweep { mut equations, .. } = self.swept(extremal)?;
        equations.residual.fill(0.0);
        equations.residual.rows_mut(0, 6).copy_from(miss);
        let step = newton_step(&equations, self.switches())?;
        self.take(&step, &equations, 1.0);
        let Sweep { equations, torques } = self.swept(extremal)?;
        (self.torques, self.residual) = (torques, equations.merit);
        Some(self)
    }

    /// A part of a step of costates and lengths, and the nodes with it.
    pub(super) fn take(&mut self, step: &DVector<f64>, equations: &Condensed, factor: f64) {
        self.m += factor * step.fixed_rows::<3>(0);
        for (arc, length) in self.lengths.iter_mut().enumerate() {
            *length += factor * step[6 + arc];
        }
        for (node, moved) in self.nodes.iter_mut().zip(equations.disturbances(step)) {
            *node = node.plus(&moved, factor);
        }
    }

    /// Whether no arc has less than no length.
    pub(super) fn shorter_than_nothing(&self) -> Option<usize> {
        let least = -NO_LENGTH * self.duration();
        self.lengths.iter().position(|length| *length < least)
    }
}

/// Whether a residual that is below `enough` falls no further, after the last one.
pub(super) fn is_round_off(residual: f64, last: f64, enough: f64) -> bool {
    residual < enough && residual >= FALLING * last
}

/// Carries the lanes over a step and gives those of its Hamiltonian.
#[inline(always)]
fn carried<const L: usize>(
    done: &GridStep,
    m: &Vector3,
    node: &Node,
    step: &Step,
    lanes: &mut Lanes<L>,
) -> [f64; L] {
    // Parameters of the step: δm = Rᵀ(δM + M×η), δΠ, δe, δh.
    let mut given = [[0.0; L]; 10];
    for lane in 0..L {
        let unit = if lane < 3 { Vector3::ith(lane, 1.0) } else { Vector3::zeros() };
        let moved = apply_transposed(&node.r, &(unit + cross(m, &lanes.block(0, lane))));
        for axis in 0..3 {
            given[axis][lane] = moved[axis];
        }
    }
    given[3..9].copy_from_slice(&lanes.0[3..9]);
    given[9][6 + step.arc] = step.part;
    let mut out = [[0.0; L]; 10];
    for row in 0..10 {
        for column in 0..10 {
            let slope = done.jacobian[row][column];
            for lane in 0..L {
                out[row][lane] += slope * given[column][lane];
            }
        }
    }
    for lane in 0..L {
        let turn = apply(&node.r, &Vector3::new(out[0][lane], out[1][lane], out[2][lane]));
        for axis in 0..3 {
            lanes.0[axis][lane] += turn[axis];
        }
    }
    lanes.0[3..9].copy_from_slice(&out[3..9]);
    out[9]
}
