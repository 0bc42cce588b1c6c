//! The authority that the inputs of a plan still have: an input at its limit cannot make
//! corrections.

use crate::maneuver::objective::Weighted;
use crate::maneuver::problem::Problem;
use crate::optimize::discrete::step::Units;
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, Matrix3xX};

/// Control law of the inputs that are not at their limits: `B W⁻¹Bᵀ` and `W⁻¹Bᵀ`.
pub(super) struct Law {
    axes: Matrix3xX<f64>,
    weight: DMatrix<f64>,
    sizes: Option<Vec<f64>>,
    one_sided: bool,
    norm: Option<f64>,
    switches: bool,
    /// Unit factors: the scaled authority per SI authority, and the SI unit of a scaled dual
    /// torque.
    authority: f64,
    dual: f64,
}

/// Relative distance from a limit within which an input counts as being at the limit: the round-off
/// of a mean of two values.
const AT_LIMIT: f64 = 1e-9;

impl Law {
    /// Builds the law of the torque inputs of a maneuver.
    pub fn of(problem: &Problem, units: &Units) -> Self {
        let weighted = problem.objective.weights().torque(&problem.actuation);
        Self::of_set(&weighted, problem.switches(), units.cost, [units.momentum(), units.torque()])
    }

    /// Builds the law of a set of inputs, which are bang-bang if `switches`. `cost`, `impulse` and
    /// `unit` are the units of the cost, of the output integrated over time, and of the output.
    pub fn of_set(weighted: &Weighted, switches: bool, cost: f64, [impulse, unit]: [f64; 2]) -> Self {
        let (axes, limits) = (weighted.set.axes(), weighted.set.limits());
        Self {
            axes: Matrix3xX::from_fn(axes.len(), |row, column| axes[column][row]),
            weight: weighted.weight.clone(),
            sizes: limits.size.clone(),
            one_sided: limits.one_sided,
            norm: limits.norm,
            switches,
            authority: cost / impulse / unit,
            dual: cost / impulse,
        }
    }

    /// Returns `B W⁻¹Bᵀ` (scaled) and `W⁻¹Bᵀ` of the free inputs when the plan applies `inputs`.
    pub fn at(&self, inputs: &[f64]) -> (Matrix3, DMatrix<f64>) {
        let m = inputs.len();
        // Bang-bang inputs are always at a limit; a reserve of authority serves for their
        // corrections.
        let free = |index: &usize| {
            self.switches
                || self.sizes.as_ref().is_none_or(|sizes| {
                    let at = (1.0 - AT_LIMIT) * sizes[*index];
                    inputs[*index].abs() < at && !(self.one_sided && inputs[*index] <= 0.0)
                })
        };
        let free: Vec<usize> = (0..m).filter(free).collect();
        let mut gain = DMatrix::zeros(m, 3);
        if free.is_empty() {
            return (Matrix3::zeros(), gain);
        }
        let b = self.axes.select_columns(&free);
        let weight = self.weight.select_rows(&free).select_columns(&free);
        if let Some(factor) = weight.cholesky() {
            let of_free = factor.solve(&b.transpose());
            for (row, index) in free.iter().enumerate() {
                gain.row_mut(*index).copy_from(&of_free.row(row));
            }
        }
        let output: Vector3 = inputs.iter().zip(self.axes.column_iter()).map(|(u, axis)| axis * *u).sum();
        let at_norm = self.norm.filter(|norm| !self.switches && output.norm() >= (1.0 - AT_LIMIT) * norm);
        let mut authority = Matrix3::from_iterator((&self.axes * &gain).iter().copied());
        if at_norm.is_some() {
            // At the norm limit the output can change only along the sphere: `P S P`, by the inputs
            // of minimum effort.
            let out = output.normalize();
            let along = Matrix3::identity() - out * out.transpose();
            let inverse =
                authority.pseudo_inverse(1e-12 * authority.amax()).unwrap_or_else(|_| Matrix3::zeros());
            let change = inverse * (along * authority * along);
            gain *= DMatrix::from_column_slice(3, 3, change.as_slice());
            authority = along * authority * along;
        }
        (0.5 * (authority + authority.transpose()) * self.authority, gain * self.dual)
    }
}
