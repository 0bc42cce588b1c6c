//! The filter line search.

use super::super::program::{Program, RowKind, Shape, Values};
use super::super::riccati::dot;
use super::super::tuning::Tuning;
use super::{Solver, State};
use crate::optimize::methods::method::Watch;

impl Solver {
    /// Returns the infeasibility and the barrier cost of `values`, with the slacks and violations
    /// after `part` of the step.
    fn measure(
        &self,
        shape: &Shape,
        tuning: &Tuning,
        barrier: f64,
        values: &Values,
        part: f64,
    ) -> (f64, f64) {
        let mut infeasible: f64 = values.defects.iter().map(|value| value.abs()).sum();
        let mut cost = values.cost;
        let mut logs = 0.0;
        // The logarithm of a product of many factors, so that few logarithms are computed.
        let mut factor = 1.0f64;
        let mut log = |value: f64| {
            // Each value is tested alone, because two negative slacks have a positive product.
            factor *= if value > 0.0 { value } else { f64::NAN };
            if !(1e-100..1e100).contains(&factor) {
                logs += factor.ln();
                factor = 1.0;
            }
        };
        for (row, kind) in shape.kinds.iter().enumerate() {
            let c = values.rows[row];
            if *kind == RowKind::Equation {
                infeasible += c.abs();
                continue;
            }
            let s = self.slacks[row] + part * self.step.slacks[row];
            let mut lacking = c + s;
            log(s);
            if *kind == RowKind::Elastic {
                let t = self.violations[row] + part * self.step.violations[row];
                lacking -= t;
                cost += tuning.price * t;
                log(t);
            }
            infeasible += lacking.abs();
        }
        for (index, (e, price)) in values.terminal.iter().zip(&self.prices).enumerate() {
            let [above, below] =
                [0, 1].map(|side| self.misses[side][index] + part * self.step.misses[side][index]);
            infeasible += (e - above + below).abs();
            cost += price * (above + below);
            log(above);
            log(below);
        }
        logs += factor.ln();
        (infeasible, cost - barrier * logs)
    }

    /// Returns the directional derivative of the barrier cost along the step.
    fn slope(&self, shape: &Shape, tuning: &Tuning, barrier: f64) -> f64 {
        let (m, z, n) = (shape.m, shape.z(), shape.n);
        let mut slope = 0.0;
        for stage in 0..shape.stages {
            let gradient = &self.at.gradients[stage * z..][..z];
            slope += dot(&gradient[..m], &self.step.point.inputs[stage * m..][..m]);
            slope += dot(&gradient[m..], &self.step.point.states[stage * n..][..n]);
        }
        slope += dot(&self.at.last_gradient, &self.step.point.states[shape.stages * n..]);
        for (row, kind) in shape.kinds.iter().enumerate() {
            if *kind != RowKind::Equation {
                slope -= barrier * self.step.slacks[row] / self.slacks[row];
            }
            if *kind == RowKind::Elastic {
                let (t, dt) = (self.violations[row], self.step.violations[row]);
                slope += (tuning.price - barrier / t) * dt;
            }
        }
        for (index, price) in self.prices.iter().enumerate() {
            for side in 0..2 {
                slope += (price - barrier / self.misses[side][index]) * self.step.misses[side][index];
            }
        }
        slope
    }

    /// Returns whether the filter accepts a point with this infeasibility and barrier cost:
    /// compared with every entry, at least one of the two numbers is not larger.
    fn lets(&self, infeasible: f64, cost: f64) -> bool {
        self.filter.iter().all(|(known, known_cost)| infeasible <= *known || cost <= *known_cost)
    }

    /// Takes the largest of the tried fractions of the step that the filter accepts. Returns
    /// `false` if the filter accepts none or the watch ends the run.
    pub(super) fn search(
        &mut self,
        program: &impl Program,
        tuning: &Tuning,
        state: &mut State,
        watch: &Watch,
    ) -> bool {
        let shape = program.shape();
        let barrier = state.barrier;
        let part = tuning.to_boundary.max(1.0 - barrier);
        let (mut primal, mut dual) = self.to_boundary(shape, tuning, part);
        primal = primal.min(program.longest(&self.point, &self.step.point));
        if !(primal > 0.0 && dual > 0.0) {
            return false;
        }
        let (infeasible, cost) = {
            let values = std::mem::take(&mut self.at.values);
            let measured = self.measure(shape, tuning, barrier, &values, 0.0);
            self.at.values = values;
            measured
        };
        let slope = self.slope(shape, tuning, barrier);
        if !slope.is_finite() {
            return false;
        }
        let round_off = 10.0 * f64::EPSILON * cost.abs().max(1.0);
        let small = tuning.judged_by_cost * infeasible.max(1.0);
        let mut longest = primal;
        for halving in 0..=tuning.halvings {
            if watch.stopped() {
                return false;
            }
            let mut corrections = if halving == 0 { tuning.second_order } else { 0 };
            loop {
                program.moved(&self.point, &self.step.point, primal, &mut self.trial);
                let known =
                    program.values(&self.trial, &mut self.trial_values) && self.trial_values.are_finite();
                let (next, next_cost) = if known {
                    self.measure(shape, tuning, barrier, &self.trial_values, primal)
                } else {
                    (f64::INFINITY, f64::INFINITY)
                };
                let usable = next <= tuning.more_infeasible * infeasible.max(1.0) && next_cost.is_finite();
                let descends = slope < 0.0
                    && primal * (-slope).powf(tuning.switch.0) > infeasible.powf(tuning.switch.1)
                    && infeasible <= small;
                let sufficient = if descends {
                    next_cost - cost - round_off <= tuning.armijo * primal * slope
                } else {
                    next <= (1.0 - tuning.less_infeasible) * infeasible.max(1e-14)
                        || next_cost - round_off <= cost - tuning.less_costly * infeasible
                };
                // Near the solution a Newton step is more reliable than a difference of costs at
                // round-off.
                let floor = state.tail
                    && next <= tuning.feasible
                    && next_cost - cost <= tuning.level * cost.abs().max(1.0);
                if usable && (floor || sufficient && self.lets(next, next_cost - round_off)) {
                    if !descends && !floor {
                        if self.filter.len() == tuning.filter {
                            self.filter.remove(0);
                        }
                        self.filter.push((
                            (1.0 - tuning.less_infeasible) * infeasible,
                            cost - tuning.less_costly * infeasible,
                        ));
                    }
                    self.take(shape, tuning, barrier, primal, dual);
                    return true;
                }
                if corrections == 0 || !known || next < infeasible {
                    break;
                }
                // Second-order correction.
                if corrections == tuning.second_order {
                    std::mem::swap(&mut self.other, &mut self.step);
                    self.step.clone_from_step(&self.other);
                }
                corrections -= 1;
                self.add_lacking(shape, primal);
                self.direction(shape, barrier);
                let corrected = self.to_boundary(shape, tuning, part);
                primal = corrected.0.min(program.longest(&self.point, &self.step.point));
                dual = corrected.1;
                if primal.is_nan() || primal <= 0.0 {
                    break;
                }
            }
            if halving == 0 && corrections < tuning.second_order {
                // Return to the uncorrected step.
                std::mem::swap(&mut self.other, &mut self.step);
                self.lack(shape);
                let bounds = self.to_boundary(shape, tuning, part);
                dual = bounds.1;
            }
            longest *= 0.5;
            primal = longest;
        }
        false
    }
}
