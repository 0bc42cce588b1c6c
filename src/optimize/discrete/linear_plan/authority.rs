//! What the inputs of a plan can still give: those that are at their limits answer nothing.

use crate::maneuver::objective::Weighted;
use crate::maneuver::problem::Problem;
use crate::optimize::discrete::step::Units;
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, Matrix3xX};

/// What the inputs can still give: `B W⁻¹Bᵀ` and `W⁻¹Bᵀ` of those that are not at their limits.
pub(super) struct Law {
    axes: Matrix3xX<f64>,
    weight: DMatrix<f64>,
    sizes: Option<Vec<f64>>,
    one_sided: bool,
    norm: Option<f64>,
    switches: bool,
    /// The scaled authority per SI one, and a scaled dual torque in SI.
    authority: f64,
    dual: f64,
}

/// Part of a limit within which an input counts as being at it: round-off of a mean of two.
const AT_LIMIT: f64 = 1e-9;

impl Law {
    /// Of the torques of a maneuver.
    pub fn of(problem: &Problem, units: &Units) -> Self {
        let weighted = problem.objective.weights().torque(&problem.actuation);
        Self::of_set(&weighted, problem.switches(), units.cost, [units.momentum(), units.torque()])
    }

    /// Of a set of inputs that `switches` or not, with the units of the cost, of what a second of
    /// them gives, and of what they give.
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

    /// Those two where `inputs` are given.
    pub fn at(&self, inputs: &[f64]) -> (Matrix3, DMatrix<f64>) {
        let m = inputs.len();
        // Inputs that switch are at their limits always: what corrects them has an authority held
        // back for it.
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
            // Along the sphere of the norm only: `P S P`, given by the inputs of least effort.
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
