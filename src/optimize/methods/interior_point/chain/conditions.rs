//! First- and second-order optimality conditions at a point of a chain.
//!
//! # Is a constrained plan a minimum?
//!
//! A point that satisfies the first-order conditions is a strict local minimum if the Hessian of
//! the Lagrangian is positive definite on all directions that dynamics, terminal equations and
//! active rows allow. The KKT matrix then has as many negative eigenvalues as there are such
//! equations. Each further negative eigenvalue is an independent direction in which the cost
//! decreases. The diagonal term `−ε` keeps this count valid if the equations are linearly
//! dependent.
//!
//! The states are eliminated by the dynamics, from the last stage to the first. `M` is the second
//! derivative of the cost-to-go with respect to the state x, the multipliers η of the terminal
//! equations, and the multipliers σ of rows that depend on the state alone. With the multipliers ν
//! of rows that depend on the inputs u, a stage leaves
//!
//! ```text
//! K = second derivative by (u, σ⁺, ν) ,   L = that by (u, σ⁺, ν) and (x, η, σ)
//! M ← M' − Lᵀ K⁻¹ L
//! ```
//!
//! The negative eigenvalues of all `K`, and of the matrix left at the start, add up (Haynsworth
//! 1968).
//!
//! Curvature is measured relative to the effort. The test is repeated with the effort slightly
//! decreased and increased, so that neither a symmetry nor round-off decides. A row is active if
//! its multiplier exceeds its slack. A row at its bound with zero multiplier is weakly active: for
//! a minimum the test must succeed without it, and a decrease must be possible with it.

use super::super::iteration::nan_max;
use super::super::program::{Derivatives, Duals, Point, Program, RowKind, Shape};
use super::super::riccati::{add, dot};
use super::super::tuning::Tuning;
use super::ChainProgram;
use crate::numerics::matrix_inertia::MatrixInertia;
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::rows::What;
use crate::optimize::chain::tuning::{CURVATURE, MET, MOST_WORK, PROXIMAL};
use crate::optimize::chain::{Chain, Multipliers};
use crate::optimize::methods::method::Watch;
use nalgebra::DMatrix;

/// KKT conditions at a point: the program with its multipliers and derivatives.
pub(crate) struct Conditions<'a> {
    program: ChainProgram<'a>,
    duals: Duals,
    at: Derivatives,
    watch: &'a Watch<'a>,
}

impl<'a> Conditions<'a> {
    /// Evaluates the conditions at an iterate with the given multipliers of terminal equations and
    /// rows. The costates are computed from the multipliers. Returns `None` if the program cannot
    /// be evaluated.
    pub fn of(
        chain: &'a Chain,
        iterate: &Iterate,
        multipliers: &Multipliers,
        watch: &'a Watch<'a>,
    ) -> Option<Self> {
        let program = ChainProgram::of(&chain.model, &chain.rows, None, iterate, &Tuning::default());
        let shape = program.shape();
        let (mut point, mut duals) = (Point::of(shape), Duals::of(shape));
        program.point(iterate, &mut point);
        let mut at = Derivatives::of(shape);
        if !program.derivatives(&point, &duals, &mut at) {
            return None;
        }
        program.write_multipliers(multipliers, &at.values.rows, &mut duals);
        write_costates(shape, &at, &mut duals);
        program.derivatives(&point, &duals, &mut at).then_some(Self { program, duals, at, watch })
    }

    /// Returns the largest derivative of the Lagrangian with respect to an input, over all stages
    /// and scaled to the whole maneuver, relative to the largest costate.
    pub fn stationarity(&self) -> f64 {
        let shape = self.program.shape();
        let inputs = |stage: usize| gradient(shape, &self.at, &self.duals, stage)[..shape.m].to_vec();
        let largest = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0, |a, b| nan_max(a, b.abs()));
        let slope = largest(&mut (0..shape.stages).flat_map(inputs));
        slope * shape.stages as f64 / largest(&mut self.duals.costates.iter().copied()).max(1.0)
    }

    /// Returns the derivatives of the Lagrangian with respect to the inputs of a stage, without the
    /// terms of the cost of the inputs and of the limits of the inputs.
    pub fn by_inputs(&self, stage: usize) -> Vec<f64> {
        let (program, shape) = (&self.program, self.program.shape());
        let Shape { n, .. } = *shape;
        let (columns, next) =
            (&self.at.steps[stage * n * shape.z()..], &self.duals.costates[(stage + 1) * n..][..n]);
        let by_lane = |place: usize, factor: f64| {
            let mut slope = dot(&columns[place * n..][..n], next);
            for row in shape.rows_of(stage) {
                if !program.what_of(&program.rows[row]).is_some_and(What::is_of_state) {
                    continue;
                }
                let own = shape.slopes_of(row).filter(|slope| usize::from(shape.unknowns[*slope]) == place);
                slope += self.duals.rows[row] * own.map(|slope| self.at.slopes[slope]).sum::<f64>();
            }
            slope / (factor * program.scale)
        };
        let lane = |input: usize| program.lanes.iter().position(|lane| lane.input == input);
        let of = |input: usize| lane(input).map_or(0.0, |place| by_lane(place, program.lanes[place].factor));
        (0..program.model.m).map(of).collect()
    }

    /// Counts the independent directions in which the cost decreases; 0 means a strict local
    /// minimum. Returns `None` if the second derivatives do not decide, the problem is too large,
    /// or a stop was requested.
    pub fn descents(&self) -> Option<usize> {
        let (shape, c) = (self.program.shape(), &self.at.values.rows);
        let most = (0..shape.stages).map(|stage| shape.rows_of(stage).len()).max().unwrap_or(0);
        let largest_block = (shape.z() + shape.terminal + most) as f64;
        if largest_block.powi(3) * shape.stages as f64 > MOST_WORK {
            return None;
        }
        let acts = |row: usize| shape.kinds[row] == RowKind::Equation || self.duals.rows[row] > -c[row];
        let acting: Vec<bool> = (0..shape.rows()).map(acts).collect();
        let met: Vec<bool> = acting.iter().zip(c).map(|(acts, c)| *acts || *c >= -MET).collect();
        if self.count(&acting, -CURVATURE)? == 0 {
            return Some(0);
        }
        self.count(&met, CURVATURE).filter(|decreasing| *decreasing > 0)
    }

    /// Counts the independent directions in which the cost decreases, with the rows whose flag in
    /// `acting` is true held active and `shift` times the effort added to the Hessian.
    fn count(&self, acting: &[bool], shift: f64) -> Option<usize> {
        let (shape, at) = (self.program.shape(), &self.at);
        let Shape { n, m, terminal, stages, starts, .. } = *shape;
        let (z, own) = (shape.z(), n + terminal);
        let mut to_go = DMatrix::zeros(own, own);
        for column in 0..n {
            for row in 0..n {
                to_go[(row, column)] =
                    at.last_hessian[column * n + row] + at.last_curvature[column * n + row];
            }
        }
        for (index, slope) in at.terminal_slopes.chunks_exact(n).enumerate() {
            for (row, value) in slope.iter().enumerate() {
                to_go[(row, n + index)] = *value;
                to_go[(n + index, row)] = *value;
            }
            to_go[(n + index, n + index)] = -PROXIMAL;
        }
        let (mut negative, mut carried) = (0, 0);
        for stage in (0..stages).rev() {
            if self.watch.stopped_at(stage) {
                return None;
            }
            let moved =
                |row: &usize| shape.slopes_of(*row).any(|slope| usize::from(shape.unknowns[slope]) < m);
            let (moved, still): (Vec<usize>, Vec<usize>) =
                shape.rows_of(stage).filter(|row| acting[*row]).partition(moved);
            let inner = m + carried + moved.len();
            let size = inner + own + still.len();
            // Positions of u and x, and dependence of the next state, η and σ⁺ on all unknowns.
            let place = |unknown: usize| if unknown < m { unknown } else { inner + unknown - m };
            let mut next = DMatrix::zeros(own + carried, size);
            for (unknown, column) in at.steps[stage * n * z..][..n * z].chunks_exact(n).enumerate() {
                next.view_mut((0, place(unknown)), (n, 1)).copy_from_slice(column);
            }
            (0..terminal).for_each(|index| next[(n + index, inner + n + index)] = 1.0);
            (0..carried).for_each(|index| next[(own + index, m + index)] = 1.0);
            let mut whole = next.tr_mul(&(&to_go * &next));
            for column in 0..z {
                for row in 0..z {
                    let index = (stage * z + column) * z + row;
                    whole[(place(row), place(column))] +=
                        (1.0 + shift) * at.hessians[index] + at.curvatures[index];
                }
            }
            let places = (m + carried..inner).chain(inner + own..size);
            for (row, multiplier) in moved.iter().chain(&still).zip(places) {
                for slope in shape.slopes_of(*row) {
                    let unknown = place(usize::from(shape.unknowns[slope]));
                    whole[(multiplier, unknown)] += at.slopes[slope];
                    whole[(unknown, multiplier)] += at.slopes[slope];
                }
                whole[(multiplier, multiplier)] -= PROXIMAL;
            }
            let head = whole.view((0, 0), (inner, inner)).into_owned();
            let beside = whole.view((0, inner), (inner, size - inner)).into_owned();
            negative += MatrixInertia::of(head.clone(), 0.0).negative;
            let eliminated = beside.tr_mul(&head.lu().solve(&beside)?);
            let left = whole.view((inner, inner), (size - inner, size - inner)) - eliminated;
            to_go = 0.5 * (&left + left.transpose());
            if !to_go.iter().all(|value| value.is_finite()) {
                return None;
            }
            carried = still.len();
        }
        let mut start = DMatrix::zeros(own + carried, starts + terminal + carried);
        for (index, slope) in at.start_slopes.chunks_exact(n).enumerate() {
            start.view_mut((0, index), (n, 1)).copy_from_slice(slope);
        }
        (0..terminal + carried).for_each(|index| start[(n + index, starts + index)] = 1.0);
        negative += MatrixInertia::of(start.tr_mul(&(to_go * &start)), 0.0).negative;
        negative.checked_sub(acting.iter().filter(|acts| **acts).count() + terminal)
    }
}

impl ChainProgram<'_> {
    /// Writes the multipliers of the chain's terminal equations and rows to the program, as the
    /// inverse of [`ChainProgram::found`]; `values` are the values of the program's rows. The
    /// multiplier of a cone at a node is given to the adjacent arc whose row has the larger value.
    fn write_multipliers(&self, known: &Multipliers, values: &[f64], out: &mut Duals) {
        let scaled = |value: &f64| self.scale * value;
        out.terminal.iter_mut().zip(known.terminal.iter()).for_each(|(to, value)| *to = scaled(value));
        for (row, to) in self.rows.iter().zip(&mut out.rows) {
            *to = known.rows.get(row.row).map_or(0.0, scaled);
        }
        for (limit, multiplier) in self.limits.rows.iter().zip(&known.rows) {
            let What::Cone(node) = &limit.what else { continue };
            if node.is_of_arc() || limit.what.is_equation() || *multiplier == 0.0 {
                continue;
            }
            let beside = limit.stage.saturating_sub(1)..=limit.stage.min(self.shape.stages - 1);
            let arcs = beside.flat_map(|stage| self.shape.rows_of(stage)).filter(
                |row| matches!(self.what_of(&self.rows[*row]), Some(What::Cone(arc)) if node.is_node_of(arc)),
            );
            if let Some(row) = arcs.max_by(|a, b| values[*a].total_cmp(&values[*b])) {
                out.rows[row] += scaled(multiplier);
            }
        }
    }
}

/// Computes the costates that correspond to the multipliers of rows and terminal equations.
fn write_costates(shape: &Shape, at: &Derivatives, duals: &mut Duals) {
    let (n, m) = (shape.n, shape.m);
    let mut last = at.last_gradient.clone();
    for (slope, nu) in at.terminal_slopes.chunks_exact(n).zip(&duals.terminal) {
        add(&mut last, *nu, slope);
    }
    duals.costates[shape.stages * n..].copy_from_slice(&last);
    for stage in (0..shape.stages).rev() {
        let costate = gradient(shape, at, duals, stage);
        duals.costates[stage * n..][..n].copy_from_slice(&costate[m..]);
    }
}

/// Returns the gradient of the Lagrangian with respect to the inputs and the state of a stage,
/// without the costate of that state.
fn gradient(shape: &Shape, at: &Derivatives, duals: &Duals, stage: usize) -> Vec<f64> {
    let (n, z) = (shape.n, shape.z());
    let mut gradient = at.gradients[stage * z..][..z].to_vec();
    let next = &duals.costates[(stage + 1) * n..][..n];
    for (to, column) in gradient.iter_mut().zip(at.steps[stage * n * z..].chunks_exact(n)) {
        *to += dot(column, next);
    }
    for row in shape.rows_of(stage) {
        for slope in shape.slopes_of(row) {
            gradient[usize::from(shape.unknowns[slope])] += duals.rows[row] * at.slopes[slope];
        }
    }
    gradient
}

#[cfg(test)]
mod tests;
