//! Recovery of a run that cannot continue: the best point of its final phase, with its equations
//! satisfied to round-off.

use super::{End, Run, Solver, nan_max};
use crate::optimize::methods::interior_point::program::{Duals, Point, Program, Shape};
use crate::optimize::methods::interior_point::riccati::Taken;
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::Watch;

/// Saved point with its multipliers, slacks and violations.
pub(super) struct Saved {
    point: Point,
    duals: Duals,
    slacks: Vec<f64>,
    violations: Vec<f64>,
    misses: [Vec<f64>; 2],
}

impl Saved {
    pub(super) fn of(shape: &Shape) -> Self {
        let zeros = |size: usize| vec![0.0; size];
        Self {
            point: Point::of(shape),
            duals: Duals::of(shape),
            slacks: zeros(shape.rows()),
            violations: zeros(shape.rows()),
            misses: [zeros(shape.terminal), zeros(shape.terminal)],
        }
    }

    /// Copies a point into the saved one without allocating.
    pub(super) fn copy(
        &mut self,
        point: &Point,
        duals: &Duals,
        [slacks, violations]: [&Vec<f64>; 2],
        misses: &[Vec<f64>; 2],
    ) {
        self.point.states.copy_from_slice(&point.states);
        self.point.inputs.copy_from_slice(&point.inputs);
        self.duals.costates.copy_from_slice(&duals.costates);
        self.duals.terminal.copy_from_slice(&duals.terminal);
        self.duals.rows.copy_from_slice(&duals.rows);
        self.slacks.copy_from_slice(slacks);
        self.violations.copy_from_slice(violations);
        self.misses[0].copy_from_slice(&misses[0]);
        self.misses[1].copy_from_slice(&misses[1]);
    }

    /// Restores the saved point without allocating.
    pub(super) fn restore(
        &self,
        point: &mut Point,
        duals: &mut Duals,
        [slacks, violations]: [&mut Vec<f64>; 2],
        misses: &mut [Vec<f64>; 2],
    ) {
        point.states.copy_from_slice(&self.point.states);
        point.inputs.copy_from_slice(&self.point.inputs);
        duals.costates.copy_from_slice(&self.duals.costates);
        duals.terminal.copy_from_slice(&self.duals.terminal);
        duals.rows.copy_from_slice(&self.duals.rows);
        slacks.copy_from_slice(&self.slacks);
        violations.copy_from_slice(&self.violations);
        misses[0].copy_from_slice(&self.misses[0]);
        misses[1].copy_from_slice(&self.misses[1]);
    }
}

impl Solver {
    /// Returns to the best point of a run that cannot continue, as along the valley of a saddle,
    /// and reduces its equation residuals to round-off. The point is a solution if its other
    /// residuals remain small.
    pub(super) fn settle(
        &mut self,
        program: &impl Program,
        tuning: &Tuning,
        barrier: f64,
        run: &mut Run,
        watch: &Watch,
    ) {
        std::mem::swap(&mut self.point, &mut self.saved.point);
        std::mem::swap(&mut self.duals, &mut self.saved.duals);
        std::mem::swap(&mut self.slacks, &mut self.saved.slacks);
        std::mem::swap(&mut self.violations, &mut self.saved.violations);
        std::mem::swap(&mut self.misses, &mut self.saved.misses);
        self.correct(program, tuning, barrier, run, watch);
    }

    /// Reduces the equation residuals of the current point to round-off, by Newton steps with a
    /// positive definite Hessian.
    pub(in super::super) fn correct(
        &mut self,
        program: &impl Program,
        tuning: &Tuning,
        barrier: f64,
        run: &mut Run,
        watch: &Watch,
    ) {
        let shape = program.shape();
        program.at_barrier(barrier);
        for step in 0..=tuning.settling {
            if watch.stopped() || !program.derivatives(&self.point, &self.duals, &mut self.at) {
                return;
            }
            self.gradients(shape);
            let residuals = self.residuals(shape, tuning, barrier);
            (run.dual, run.primal) = (residuals.dual, residuals.primal);
            (run.complementarity, run.barrier, run.exact) =
                (residuals.complementarity, residuals.mean, false);
            let miss = self.at.values.terminal.iter().fold(0.0, |worst, value| nan_max(worst, value.abs()));
            if residuals.largest() <= tuning.acceptable && nan_max(run.primal, miss) <= tuning.round_off {
                run.end = End::Converged;
                return;
            }
            self.weigh(shape, tuning);
            let taken = Taken { curved: false, shift: 1.0 };
            if step == tuning.settling
                || !self.riccati.factor(shape, &self.at, &self.sigma, &self.yields, taken)
            {
                return;
            }
            self.products.iter_mut().for_each(|products| products.fill(0.0));
            self.lack(shape);
            self.direction(shape, barrier);
            let (primal, dual) = self.to_boundary(shape, tuning, tuning.to_boundary);
            program.moved(&self.point, &self.step.point, primal, &mut self.trial);
            self.take(shape, tuning, barrier, primal, dual);
        }
    }
}
