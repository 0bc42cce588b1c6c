//! The proof scale: the degree to which a plan is proved to be an optimum.
//!
//! Methods prove different things: the shooting counts conjugate points, the interior point tests
//! the curvature, arcs come with a gap to the maximum principle. One scale orders all of these, so
//! that plans of any objective can be compared and counted.

use super::problem::Problem;
use super::solution::{Outcome, SecondOrder, Solution};
use super::switching::Structure;
use serde::{Deserialize, Serialize};

/// The degree to which a plan is proved to be an optimum, from the weakest to the strongest. All
/// degrees except the last compare with neighbouring plans: a plan on another path may cost less.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Proved {
    /// The plan meets its end within its limits. No optimum on its grid was found near it.
    Feasible,
    /// The first-order conditions hold, and the cost decreases in some direction.
    Saddle,
    /// The first-order conditions hold. Whether the plan is a minimum was not tested, or is
    /// undecided.
    Extremal,
    /// No neighbouring plan costs less to first order, except for the gap of
    /// [`Solution::gap_part`].
    FirstOrder,
    /// No neighbouring plan costs less, to second order.
    Minimum,
    /// No plan costs less, because the body is already in the requested end state.
    Global,
}

impl Proved {
    /// Returns the name of the degree in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Feasible => "feasible",
            Self::Saddle => "saddle",
            Self::Extremal => "extremal",
            Self::FirstOrder => "first_order",
            Self::Minimum => "minimum",
            Self::Global => "global",
        }
    }

    /// Returns the name in sentences, as in "a local minimum".
    pub fn words(self) -> &'static str {
        match self {
            Self::Feasible => "feasible, no optimum",
            Self::Saddle => "a saddle, no minimum",
            Self::Extremal => "an extremal, not known to be a minimum",
            Self::FirstOrder => "a local minimum to first order",
            Self::Minimum => "a local minimum",
            Self::Global => "the global minimum",
        }
    }

    /// All degrees, the strongest proof first.
    pub const ALL: [Self; 6] =
        [Self::Global, Self::Minimum, Self::FirstOrder, Self::Extremal, Self::Saddle, Self::Feasible];
}

impl Solution {
    /// Returns the degree of proof of the plan; `None` without a plan.
    pub fn proved(&self, problem: &Problem) -> Option<Proved> {
        if self.outcome != Outcome::Converged {
            return None;
        }
        Some(match &self.switching {
            Some(switching) if switching.structure == Structure::Rest => Proved::Global,
            Some(switching) if switching.beside_optimum => Proved::Feasible,
            Some(_) => Proved::FirstOrder,
            // Minimum-time and minimum-fuel plans on a uniform grid have no second-order test.
            None if self.on_grid(problem).is_shaped() => Proved::FirstOrder,
            None => match self.optimality.second_order() {
                SecondOrder::Minimum => Proved::Minimum,
                SecondOrder::Saddle => Proved::Saddle,
                // A motion that follows a target has no costates.
                _ if self.cost > 0.0 && self.trajectory.costates.iter().all(|part| *part == 0.0) => {
                    Proved::Feasible
                }
                SecondOrder::Undecided | SecondOrder::NotTested => Proved::Extremal,
            },
        })
    }

    /// Returns the gap relative to the cost: the largest part of the cost that neighbouring plans
    /// can save, to first order. It is 0 for a plan without a gap.
    pub fn gap_part(&self) -> f64 {
        let part = self.switching.as_ref().map(|switching| switching.gap / switching.continuous_cost);
        part.filter(|part| part.is_finite()).unwrap_or(0.0)
    }
}
