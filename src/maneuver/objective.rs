//! The objective of a plan.
//!
//! The effort of the inputs is
//!
//! ```text
//! ∫ ½ uᵀWu dt ,    on the grid  Σ κ_k ½ u_kᵀWu_k
//! ```
//!
//! with the weights κ of the kicks ([`Grid::kick`](super::grid::Grid::kick)) and one block of `W`
//! for each set of actuators. `optimize/discrete/control_law` derives the optimal inputs.
//! - **Minimum time** has the duration `T` as its cost.
//! - **Fuel** is `∫ Σ c_j |u_j| dt` of torques and forces. If only the norm of the torque is
//!   limited, it is `c ∫ |τ| dt`; forces are treated likewise.
//!
//! Effort and fuel may include a price of time, the cost per second of a free duration (a time
//! weight).
//!
//! If only the torques are limited, inputs are held over steps whose lengths are part of the plan
//! (`optimize/methods/switching`). Otherwise inputs are given at the nodes of a uniform grid, and
//! the fuel is `Σ κ_k Σ c_j |u_j,k|`.
//!
//! # Where is the objective stored?
//!
//! `Problem` has the objective: effort, time or fuel. The actuators have the properties of the
//! body: axes, frame, limits. The price of time is here and not in
//! [`Duration`](super::duration::Duration), because the cost of a plan includes it even after the
//! duration is found. A weight has a meaning only for its set of inputs: `Weighted` combines both
//! with the gain and the authority. These matrices are computed where they are used. They are not
//! stored next to axes that may change.

use crate::Matrix3;
use crate::mechanics::actuators::{Actuation, ActuatorSet};
use nalgebra::{DMatrix, DVector};
use thiserror::Error;

/// The objective of a plan.
#[derive(Clone, Debug, PartialEq)]
pub enum Objective {
    /// The effort `∫ ½ uᵀWu dt` of the inputs, and the price of time if the duration is free.
    Effort(Weights),
    /// The duration: minimum time.
    Time,
    /// The fuel `∫ Σ c_j |u_j| dt` of the inputs. It is `c ∫ |τ| dt` if only the norm of the
    /// torque is limited, and `c ∫ |f| dt` if the norm of the force is limited.
    Fuel(Fuel),
}

/// The prices of the fuel objective: a price for each input, and the price of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fuel {
    /// Prices `c_j` of the torque inputs, one each, positive, in 1/(N·m·s) up to the user's unit of
    /// cost; `None` means 1 each. The prices must be equal if fuel is counted by the norm of the
    /// torque. Thrusters that produce both force and torque have prices of forces instead.
    pub prices: Option<Vec<f64>>,
    /// Prices of the force inputs, one each, positive, in 1/(N·s) up to the user's unit of cost;
    /// `None` means 1 each.
    pub force_prices: Option<Vec<f64>>,
    /// The price of time: the cost per second of a free duration, in 1/s up to the user's unit of
    /// cost. `None` if time has no price, as for a given duration.
    pub time_price: Option<f64>,
}

impl Fuel {
    /// Returns the price of the torque input with index `input`.
    pub fn price(&self, input: usize) -> f64 {
        price_of(self.prices.as_ref(), input)
    }

    /// Returns the price of the force input with index `input`.
    pub fn force_price(&self, input: usize) -> f64 {
        price_of(self.force_prices.as_ref(), input)
    }

    /// Returns the cost per second: the fuel rate of a row of inputs, forces first, plus the price
    /// of time.
    pub fn rate(&self, actuation: &Actuation, inputs: &[f64]) -> f64 {
        let (forces, torques) = actuation.split_costs(inputs);
        let of_set = |set: &ActuatorSet, inputs: &[f64], price: &dyn Fn(usize) -> f64| -> f64 {
            if Self::is_of_norm(set) {
                return price(0) * set.output(inputs).norm();
            }
            inputs.iter().enumerate().map(|(input, u)| price(input) * u.abs()).sum()
        };
        let of_torques = of_set(&actuation.torque, torques, &|input| self.price(input));
        let force = actuation.force.as_ref().filter(|_| !forces.is_empty());
        let of_forces = force.map_or(0.0, |set| of_set(set, forces, &|input| self.force_price(input)));
        of_torques + of_forces + self.time_price.unwrap_or(0.0)
    }

    /// Returns whether fuel is counted by the norm of the torque or force. This is the case if the
    /// norm is the only limit, as for a single motor that can point in any direction.
    pub fn is_of_norm(set: &ActuatorSet) -> bool {
        set.limits().size.is_none() && set.limits().norm.is_some()
    }
}

/// Weights of 1 for every input, without a price of time.
static ONES: Weights = Weights { torque: None, force: None, time_price: None };

/// Returns the price of an input, or 1 if no prices are given.
fn price_of(prices: Option<&Vec<f64>>, input: usize) -> f64 {
    prices.map_or(1.0, |prices| prices.get(input).copied().unwrap_or(f64::NAN))
}

impl Objective {
    /// Returns the weights that distribute a torque among redundant inputs: the weights of the
    /// effort, or 1 for every input if time or fuel is minimised.
    pub fn weights(&self) -> &Weights {
        match self {
            Self::Effort(weights) => weights,
            Self::Time | Self::Fuel(_) => &ONES,
        }
    }

    /// Returns whether the objective is minimum time or fuel, whose optimal inputs switch between
    /// limits (bang-bang inputs).
    pub fn switches(&self) -> bool {
        matches!(self, Self::Time | Self::Fuel(_))
    }

    /// Returns whether the cost of a plan is its duration.
    pub(crate) fn is_duration(&self) -> bool {
        *self == Self::Time
    }

    /// Returns whether the cost includes the duration, which must then be free.
    pub(crate) fn counts_time(&self) -> bool {
        match self {
            Self::Effort(weights) => weights.time_price.is_some(),
            Self::Time => true,
            Self::Fuel(fuel) => fuel.time_price.is_some(),
        }
    }

    /// Returns the prices of fuel; `None` if the objective is not fuel.
    pub fn fuel(&self) -> Option<&Fuel> {
        if let Self::Fuel(fuel) = self { Some(fuel) } else { None }
    }

    /// Returns the price of time that is part of effort or fuel; `None` without such a price.
    pub fn given_time_price(&self) -> Option<f64> {
        match self {
            Self::Effort(weights) => weights.time_price,
            Self::Time => None,
            Self::Fuel(fuel) => fuel.time_price,
        }
    }

    /// Replaces the price of time of the effort or the fuel; `None` removes it.
    pub(crate) fn with_time_price(&self, time_price: Option<f64>) -> Self {
        match self {
            Self::Effort(weights) => Self::Effort(Weights { time_price, ..weights.clone() }),
            Self::Time => Self::Time,
            Self::Fuel(fuel) => Self::Fuel(Fuel { time_price, ..fuel.clone() }),
        }
    }

    /// Returns the cost per second of duration: 1 if time is the objective, 0 without a price of
    /// time.
    pub fn time_price(&self) -> f64 {
        if *self == Self::Time { 1.0 } else { self.given_time_price().unwrap_or(0.0) }
    }

    /// Returns the name of the objective in files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Effort(_) => "effort",
            Self::Time => "time",
            Self::Fuel(_) => "fuel",
        }
    }
}

impl Default for Objective {
    /// Returns the effort with weight 1 for every input.
    fn default() -> Self {
        Self::Effort(Weights::default())
    }
}

impl From<Weights> for Objective {
    fn from(weights: Weights) -> Self {
        Self::Effort(weights)
    }
}

/// The weights of the effort: the blocks of the weight matrix `W`, and the price of time.
///
/// A block is m×m for a set of m inputs, symmetric positive definite, in [1/(N·m)²] for torques and
/// [1/N²] for forces, up to the user's unit of cost. The block of a set that the maneuver does not
/// have is ignored.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weights {
    /// Block of the torque inputs; `None` means the identity.
    pub torque: Option<DMatrix<f64>>,
    /// Block of the force inputs; `None` means the identity.
    pub force: Option<DMatrix<f64>>,
    /// The price of time: the cost per second of a free duration, in 1/s up to the user's unit of
    /// cost. `None` if time has no price, as for a given duration.
    pub time_price: Option<f64>,
}

impl Weights {
    /// Builds effort weights with a block for the torque inputs only.
    pub fn of_torques(weight: DMatrix<f64>) -> Self {
        Self { torque: Some(weight), ..Self::default() }
    }

    /// Returns these weights with `None` for every block that is the identity.
    pub fn simplified(self) -> Self {
        // The comparison is exact: a weight that differs by an ulp is another weight.
        let differs = |weight: &DMatrix<f64>| *weight != DMatrix::identity(weight.nrows(), weight.ncols());
        Self { torque: self.torque.filter(differs), force: self.force.filter(differs), ..self }
    }

    /// Returns the torque inputs combined with their weight. If [`Weights::check`] rejects the
    /// weight, all numbers in the result are NaN.
    pub fn torque<'a>(&self, actuation: &'a Actuation) -> Weighted<'a> {
        Weighted::or_nan(&actuation.torque, self.torque.as_ref())
    }

    /// Returns the force inputs combined with their weight; `None` if the body has no force inputs.
    pub fn force<'a>(&self, actuation: &'a Actuation) -> Option<Weighted<'a>> {
        actuation.force.as_ref().map(|force| Weighted::or_nan(force, self.force.as_ref()))
    }

    /// Checks that each block fits its set of inputs and is symmetric positive definite.
    ///
    /// # Errors
    /// Returns "torque" or "force", and the [`WeightError`] of that block.
    pub fn check(&self, actuation: &Actuation) -> Result<(), (&'static str, WeightError)> {
        let sets = [
            ("torque", Some(&actuation.torque), &self.torque),
            ("force", actuation.force.as_ref(), &self.force),
        ];
        for (inputs, set, weight) in sets {
            if let Some(set) = set {
                Weighted::new(set, weight.as_ref()).map_err(|error| (inputs, error))?;
            }
        }
        Ok(())
    }
}

/// The reason why a matrix is not a valid effort weight for a set of actuators.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum WeightError {
    /// The weight is not m×m.
    #[error("the weight is {rows}x{columns} for {count} inputs")]
    Shape {
        /// Number of rows of the weight.
        rows: usize,
        /// Number of columns of the weight.
        columns: usize,
        /// Number of inputs.
        count: usize,
    },
    /// The weight is not symmetric positive definite, or is too small or too large for the
    /// computation.
    #[error("the effort weight is not symmetric positive definite")]
    Indefinite,
}

/// A set of m actuators with its effort weight `W` and the matrices that its optimal inputs need;
/// SI units. The columns of `B` are the axes of the actuators.
#[derive(Clone, Debug, PartialEq)]
pub struct Weighted<'a> {
    /// The actuators.
    pub set: &'a ActuatorSet,
    /// The effort weight `W`, m×m.
    pub weight: DMatrix<f64>,
    /// The gain `W⁻¹ Bᵀ`, m×3.
    pub gain: DMatrix<f64>,
    /// The authority `B W⁻¹ Bᵀ`, 3×3, in the axes of [`ActuatorSet::frame`].
    pub authority: Matrix3,
}

impl<'a> Weighted<'a> {
    /// Combines the actuators with `weight`, m×m; `None` means the identity.
    ///
    /// # Errors
    /// A [`WeightError`] if the weight has another shape or is not symmetric positive definite.
    pub fn new(set: &'a ActuatorSet, weight: Option<&DMatrix<f64>>) -> Result<Self, WeightError> {
        let count = set.count();
        let weight = weight.cloned().unwrap_or_else(|| DMatrix::identity(count, count));
        let (rows, columns) = weight.shape();
        if (rows, columns) != (count, count) {
            return Err(WeightError::Shape { rows, columns, count });
        }
        let size = weight.amax();
        let finite = weight.iter().all(|value| value.is_finite());
        if !finite || (&weight - weight.transpose()).amax() > 1e-12 * size {
            return Err(WeightError::Indefinite);
        }
        let factor = (&weight / size).cholesky().ok_or(WeightError::Indefinite)?;
        let b = DMatrix::from_fn(3, count, |row, column| set.axes()[column][row]);
        let gain = factor.solve(&b.transpose()) / size;
        let authority = Matrix3::from_iterator((&b * &gain).iter().copied());
        let authority = 0.5 * (authority + authority.transpose());
        if !authority.iter().chain(gain.iter()).all(|value| value.is_finite()) {
            return Err(WeightError::Indefinite);
        }
        Ok(Self { set, weight, gain, authority })
    }

    /// Builds the weighted set. All its numbers are NaN if the weight is invalid.
    fn or_nan(set: &'a ActuatorSet, weight: Option<&DMatrix<f64>>) -> Self {
        let nan = |rows, columns| DMatrix::from_element(rows, columns, f64::NAN);
        let count = set.count();
        Self::new(set, weight).unwrap_or_else(|_| Self {
            set,
            weight: nan(count, count),
            gain: nan(count, 3),
            authority: Matrix3::repeat(f64::NAN),
        })
    }
}

/// Returns the running cost `½ uᵀWu` of inputs under the weight `W`, m×m, in the unit of the
/// weight, or scaled. It is 0 without inputs.
pub fn effort(weight: &DMatrix<f64>, inputs: &[f64]) -> f64 {
    if inputs.is_empty() {
        return 0.0;
    }
    let u = DVector::from_column_slice(inputs);
    0.5 * u.dot(&(weight * &u))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector3;
    use crate::mechanics::actuators::AxisFrame;

    #[test]
    fn a_weight_that_cannot_be_used_is_refused_and_never_passes_for_one() {
        let axes = vec![Vector3::x(), Vector3::y()];
        let actuation = Actuation::torques(ActuatorSet::new(axes, AxisFrame::Body).unwrap());
        let refused = |weight: DMatrix<f64>| {
            let weights = Weights::of_torques(weight);
            assert!(weights.torque(&actuation).authority.iter().all(|value| value.is_nan()));
            weights.check(&actuation).unwrap_err()
        };
        let shape = WeightError::Shape { rows: 3, columns: 3, count: 2 };
        assert_eq!(refused(DMatrix::identity(3, 3)), ("torque", shape));
        for [a, b, c, d] in [[1.0, 2.0, 2.0, 1.0], [1.0, 0.5, 0.4, 1.0], [1.0, 0.0, 0.0, f64::NAN], [0.0; 4]]
        {
            let weight = DMatrix::from_row_slice(2, 2, &[a, b, c, d]);
            assert_eq!(refused(weight), ("torque", WeightError::Indefinite));
        }
        assert_eq!(Weights::default().check(&actuation), Ok(()));
        assert_eq!(
            Weights { force: Some(DMatrix::zeros(1, 1)), ..Weights::default() }.check(&actuation),
            Ok(())
        );
    }
}
