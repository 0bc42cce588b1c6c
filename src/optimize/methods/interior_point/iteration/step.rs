//! The Newton step for a barrier parameter, and the fraction to the boundary.

use super::super::program::{Duals, Increment, RowKind, Shape};
use super::super::riccati::add;
use super::super::tuning::Tuning;
use super::Solver;

/// Step of all unknowns: point, multipliers, slacks and violations.
#[derive(Clone, Debug, Default)]
pub(super) struct Step {
    pub point: Increment,
    pub duals: Duals,
    pub slacks: Vec<f64>,
    pub violations: Vec<f64>,
    pub misses: [Vec<f64>; 2],
}

impl Step {
    pub(super) fn of(shape: &Shape) -> Self {
        let (rows, ends) = (shape.rows(), shape.terminal);
        Self {
            point: Increment::of(shape),
            duals: Duals::of(shape),
            slacks: vec![0.0; rows],
            violations: vec![0.0; rows],
            misses: [vec![0.0; ends], vec![0.0; ends]],
        }
    }

    /// Copies another step without allocating.
    pub(super) fn clone_from_step(&mut self, other: &Self) {
        self.point.states.copy_from_slice(&other.point.states);
        self.point.inputs.copy_from_slice(&other.point.inputs);
        self.duals.costates.copy_from_slice(&other.duals.costates);
        self.duals.terminal.copy_from_slice(&other.duals.terminal);
        self.duals.rows.copy_from_slice(&other.duals.rows);
        self.slacks.copy_from_slice(&other.slacks);
        self.violations.copy_from_slice(&other.violations);
        self.misses[0].copy_from_slice(&other.misses[0]);
        self.misses[1].copy_from_slice(&other.misses[1]);
    }
}

impl Solver {
    /// Computes the weights `Σ` of the rows and the elasticities `D` of the terminal equations.
    pub(super) fn weigh(&mut self, shape: &Shape, tuning: &Tuning) {
        for (row, kind) in shape.kinds.iter().enumerate() {
            let (s, z, t) = (self.slacks[row], self.duals.rows[row], self.violations[row]);
            let [of_slack, of_violation] = [1.0 / z, 1.0 / (tuning.price - z)];
            (self.inverses[0][row], self.inverses[1][row]) = (of_slack, of_violation);
            self.sigma[row] = match kind {
                RowKind::Equation => 1.0 / tuning.proximal,
                RowKind::Hard => z / s,
                RowKind::Elastic => 1.0 / (s * of_slack + t * of_violation),
            };
        }
        for (index, (given, price)) in self.yields.iter_mut().zip(&self.prices).enumerate() {
            let nu = self.duals.terminal[index];
            given.by = self.misses[0][index] / (price - nu) + self.misses[1][index] / (price + nu);
            given.rho = tuning.rho.min(0.5 / given.by);
        }
    }

    /// Computes the residuals of equations and rows at the current point.
    pub(super) fn lack(&mut self, shape: &Shape) {
        self.lacking.defects.copy_from_slice(&self.at.values.defects);
        for (row, kind) in shape.kinds.iter().enumerate() {
            self.lacking.rows[row] = self.row_lacks(*kind, row, self.at.values.rows[row]);
        }
        for (index, e) in self.at.values.terminal.iter().enumerate() {
            self.lacking.terminal[index] = e - self.misses[0][index] + self.misses[1][index];
        }
    }

    /// Computes the step for a barrier parameter from the residuals and the second-order products.
    pub(super) fn direction(&mut self, shape: &Shape, barrier: f64) {
        let (z_size, n) = (shape.z(), shape.n);
        self.right.gradients.copy_from_slice(&self.plain.gradients);
        self.right.last.copy_from_slice(&self.plain.last);
        self.right.start.copy_from_slice(&self.plain.start);
        // The term `ẑ − z` of the right-hand side.
        for stage in 0..shape.stages {
            let gradient = &mut self.right.gradients[stage * z_size..][..z_size];
            for row in shape.rows_of(stage) {
                let (s, t, lacking) = (self.slacks[row], self.violations[row], self.lacking.rows[row]);
                let [of_slack, of_violation] =
                    [0, 1].map(|of| (barrier - self.products[of][row]) * self.inverses[of][row]);
                let asked = self.sigma[row]
                    * match shape.kinds[row] {
                        RowKind::Equation => lacking,
                        RowKind::Hard => lacking - s + of_slack,
                        RowKind::Elastic => lacking + t - s + of_slack - of_violation,
                    };
                self.step.duals.rows[row] = asked;
                let slopes = shape.slopes_of(row);
                for (place, value) in shape.unknowns[slopes.clone()].iter().zip(&self.at.slopes[slopes]) {
                    gradient[usize::from(*place)] += asked * value;
                }
            }
        }
        self.right.defects.copy_from_slice(&self.lacking.defects);
        for (index, price) in self.prices.iter().enumerate() {
            let nu = self.duals.terminal[index];
            self.right.terminal[index] = self.lacking.terminal[index] + self.misses[0][index]
                - self.misses[1][index]
                - barrier / (price - nu)
                + barrier / (price + nu);
        }
        let step = &mut self.step;
        self.riccati.solve(
            &self.at,
            &self.right,
            &mut step.point,
            &mut step.duals.costates,
            &mut step.duals.terminal,
        );
        for stage in 0..shape.stages {
            let (du, dx) =
                (&step.point.inputs[stage * shape.m..][..shape.m], &step.point.states[stage * n..][..n]);
            for row in shape.rows_of(stage) {
                let slopes = shape.slopes_of(row);
                let mut change = 0.0;
                for (place, value) in shape.unknowns[slopes.clone()].iter().zip(&self.at.slopes[slopes]) {
                    let place = usize::from(*place);
                    change += value * if place < shape.m { du[place] } else { dx[place - shape.m] };
                }
                let (s, t) = (self.slacks[row], self.violations[row]);
                let dz = step.duals.rows[row] + self.sigma[row] * change;
                step.duals.rows[row] = dz;
                if shape.kinds[row] != RowKind::Equation {
                    let product = barrier - self.products[0][row] - s * dz;
                    step.slacks[row] = product * self.inverses[0][row] - s;
                }
                if shape.kinds[row] == RowKind::Elastic {
                    let product = barrier - self.products[1][row] + t * dz;
                    step.violations[row] = product * self.inverses[1][row] - t;
                }
            }
        }
        for (index, price) in self.prices.iter().enumerate() {
            let (nu, dnu) = (self.duals.terminal[index], step.duals.terminal[index]);
            let [above, below] = [self.misses[0][index], self.misses[1][index]];
            step.misses[0][index] = (barrier + above * dnu) / (price - nu) - above;
            step.misses[1][index] = (barrier - below * dnu) / (price + nu) - below;
        }
    }

    /// Returns the largest primal and dual step lengths, at most 1, that keep `1 − part` of every
    /// distance to a bound (fraction to the boundary).
    pub(super) fn to_boundary(&self, shape: &Shape, tuning: &Tuning, part: f64) -> (f64, f64) {
        let (mut primal, mut dual) = (1.0f64, 1.0f64);
        let limit = |least: &mut f64, value: f64, change: f64| {
            if change < 0.0 {
                *least = least.min(-part * value / change);
            }
        };
        for (row, kind) in shape.kinds.iter().enumerate() {
            if *kind == RowKind::Equation {
                continue;
            }
            let (z, dz) = (self.duals.rows[row], self.step.duals.rows[row]);
            limit(&mut primal, self.slacks[row], self.step.slacks[row]);
            limit(&mut dual, z, dz);
            if *kind == RowKind::Elastic {
                limit(&mut primal, self.violations[row], self.step.violations[row]);
                limit(&mut dual, tuning.price - z, -dz);
            }
        }
        for (index, price) in self.prices.iter().enumerate() {
            let (nu, dnu) = (self.duals.terminal[index], self.step.duals.terminal[index]);
            limit(&mut primal, self.misses[0][index], self.step.misses[0][index]);
            limit(&mut primal, self.misses[1][index], self.step.misses[1][index]);
            limit(&mut primal, price - nu, -dnu);
            limit(&mut primal, price + nu, dnu);
        }
        (primal, dual)
    }

    /// Returns the mean complementarity after a step with the lengths `primal` and `dual`.
    pub(super) fn mean_after(&self, shape: &Shape, tuning: &Tuning, primal: f64, dual: f64) -> f64 {
        let (mut total, mut pairs) = (0.0, 0usize);
        for (row, kind) in shape.kinds.iter().enumerate() {
            let z = self.duals.rows[row] + dual * self.step.duals.rows[row];
            if *kind != RowKind::Equation {
                total += (self.slacks[row] + primal * self.step.slacks[row]) * z;
                pairs += 1;
            }
            if *kind == RowKind::Elastic {
                let t = self.violations[row] + primal * self.step.violations[row];
                total += t * (tuning.price - z);
                pairs += 1;
            }
        }
        for (index, price) in self.prices.iter().enumerate() {
            let nu = self.duals.terminal[index] + primal * self.step.duals.terminal[index];
            total += (self.misses[0][index] + primal * self.step.misses[0][index]) * (price - nu);
            total += (self.misses[1][index] + primal * self.step.misses[1][index]) * (price + nu);
            pairs += 2;
        }
        total / pairs.max(1) as f64
    }

    /// Computes the second-order products of the affine step, clipped to magnitude `most`.
    pub(super) fn second_order_products(&mut self, shape: &Shape, most: f64) {
        for (row, kind) in shape.kinds.iter().enumerate() {
            let dz = self.step.duals.rows[row];
            if *kind != RowKind::Equation {
                self.products[0][row] = (self.step.slacks[row] * dz).clamp(-most, most);
            }
            if *kind == RowKind::Elastic {
                self.products[1][row] = (-self.step.violations[row] * dz).clamp(-most, most);
            }
        }
    }

    /// Adds the residuals of the trial point to `part` times the current residuals, for a
    /// second-order correction.
    pub(super) fn add_lacking(&mut self, shape: &Shape, part: f64) {
        for (lacking, value) in self.lacking.defects.iter_mut().zip(&self.trial_values.defects) {
            *lacking = part * *lacking + value;
        }
        for (row, kind) in shape.kinds.iter().enumerate() {
            let value = self.trial_values.rows[row];
            let slack = self.slacks[row] + part * self.step.slacks[row];
            let violation = self.violations[row] + part * self.step.violations[row];
            let at_trial = match kind {
                RowKind::Equation => value,
                RowKind::Hard => value + slack,
                RowKind::Elastic => value - violation + slack,
            };
            self.lacking.rows[row] = part * self.lacking.rows[row] + at_trial;
        }
        for (index, e) in self.trial_values.terminal.iter().enumerate() {
            let [above, below] =
                [0, 1].map(|side| self.misses[side][index] + part * self.step.misses[side][index]);
            self.lacking.terminal[index] = part * self.lacking.terminal[index] + e - above + below;
        }
    }

    /// Moves to the trial point and updates slacks, violations and multipliers.
    pub(super) fn take(&mut self, shape: &Shape, tuning: &Tuning, barrier: f64, primal: f64, dual: f64) {
        std::mem::swap(&mut self.point, &mut self.trial);
        add(&mut self.slacks, primal, &self.step.slacks);
        add(&mut self.violations, primal, &self.step.violations);
        add(&mut self.misses[0], primal, &self.step.misses[0]);
        add(&mut self.misses[1], primal, &self.step.misses[1]);
        add(&mut self.duals.costates, primal, &self.step.duals.costates);
        add(&mut self.duals.terminal, primal, &self.step.duals.terminal);
        for (row, kind) in shape.kinds.iter().enumerate() {
            let change = self.step.duals.rows[row];
            let z = &mut self.duals.rows[row];
            if *kind == RowKind::Equation {
                *z += primal * change;
                continue;
            }
            *z += dual * change;
            let asked = barrier / self.slacks[row];
            *z = z.max(asked / tuning.kept).min(asked * tuning.kept);
            if *kind == RowKind::Elastic {
                *z = z.min(tuning.price * (1.0 - 1e-15));
            }
        }
    }
}
