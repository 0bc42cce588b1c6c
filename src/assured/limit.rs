//! A limit with a chance of being exceeded: a constraint or a torque limit, identified by its name,
//! and the reserve of this limit that a plan leaves unused.

use super::{Held, NotKept};
use crate::Vector3;
use crate::closed_loop::Flown;
use crate::maneuver::reserve::split;
use crate::maneuver::{Constraint, Problem, Rule};
use crate::mechanics::actuators::{ActuatorSet, InputLimit, LimitKind};
use crate::numerics::figures::significant;
use crate::uncertainty::chance::Quantity;

/// A constraint or a torque limit of a maneuver.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Limit {
    pub name: String,
    which: Which,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Which {
    /// Index of the constraint in the maneuver.
    Constraint(usize),
    /// A kind of torque limit, and the index of its first bound in the list of size, norm and rate
    /// bounds.
    Inputs(LimitKind, usize),
}

/// Returns the torque limits, in the order in which flights record the distances from them.
fn of_torques(problem: &Problem) -> impl Iterator<Item = InputLimit<'_>> {
    let counts = [LimitKind::Size, LimitKind::Norm, LimitKind::Rate];
    problem.actuation.limits().filter(move |limit| !limit.of_force && counts.contains(&limit.kind))
}

impl Limit {
    /// Returns the limit that reports call `name`; `None` if no limit has this name.
    pub fn named(problem: &Problem, name: &str) -> Option<Self> {
        let named = |which| Self { name: name.into(), which };
        if let Some(index) = problem.constraints.iter().position(|constraint| constraint.name == name) {
            return Some(named(Which::Constraint(index)));
        }
        let mut first = 0;
        for limit in of_torques(problem) {
            if limit.name == name {
                return Some(named(Which::Inputs(limit.kind, first)));
            }
            first += limit.bounds.len();
        }
        None
    }

    pub fn quantity(&self, problem: &Problem) -> Quantity {
        match self.which {
            Which::Constraint(index) => match problem.constraints[index].rule {
                Rule::Pointing(_) => Quantity::Angle,
                Rule::RateNorm(_) | Rule::RateAxes(_) => Quantity::Rate,
            },
            Which::Inputs(LimitKind::Rate, _) => Quantity::TorqueRate,
            Which::Inputs(..) => Quantity::Torque,
        }
    }

    /// Returns the bound of each component or input of the limit, as the maneuver states it. A cone
    /// has the bound infinity, because no margin can exceed it.
    pub fn bounds(&self, problem: &Problem) -> Vec<f64> {
        match self.which {
            Which::Constraint(index) => match &problem.constraints[index].rule {
                Rule::Pointing(_) => vec![f64::INFINITY],
                Rule::RateNorm(limit) => vec![*limit],
                Rule::RateAxes(limits) => limits.iter().copied().collect(),
            },
            Which::Inputs(kind, _) => {
                let limit = of_torques(problem).find(|limit| limit.kind == kind);
                limit.map_or_else(Vec::new, |limit| limit.bounds.to_vec())
            }
        }
    }

    /// Returns the reserve of each component or input of the limit: the margin of a cone, or the
    /// amount of a bound that the plan must not use.
    pub fn held(&self, problem: &Problem) -> Vec<f64> {
        let reserve = &problem.reserve;
        let mut held = match self.which {
            Which::Constraint(index) => match &problem.constraints[index].rule {
                Rule::Pointing(pointing) => vec![pointing.margin],
                _ => reserve.rate(&self.name).to_vec(),
            },
            Which::Inputs(LimitKind::Size, _) => reserve.torque.clone(),
            Which::Inputs(LimitKind::Rate, _) => reserve.torque_rate.clone(),
            Which::Inputs(..) => vec![reserve.torque_norm],
        };
        held.resize(self.bounds(problem).len(), 0.0);
        held
    }

    /// Sets the reserves of this limit in `problem`: one value for each component or input, each
    /// less than its bound in `craft`.
    pub fn hold(&self, problem: &mut Problem, craft: &Problem, held: &[f64]) {
        let parts = self.bounds(craft).into_iter().zip(held);
        let (kept, left): (Vec<f64>, Vec<f64>) = parts.map(|(bound, held)| split(bound, *held)).unzip();
        let kind = match self.which {
            Which::Constraint(index) => {
                match &mut problem.constraints[index].rule {
                    Rule::Pointing(pointing) => {
                        pointing.margin = held[0];
                        return;
                    }
                    Rule::RateNorm(limit) => *limit = kept[0],
                    Rule::RateAxes(limits) => {
                        limits.iter_mut().zip(&kept).for_each(|(limit, kept)| *limit = *kept)
                    }
                }
                problem.reserve.rates.retain(|(name, _)| *name != self.name);
                problem.reserve.rates.push((self.name.clone(), left));
                return;
            }
            Which::Inputs(kind, _) => kind,
        };
        let set = &problem.actuation.torque;
        let mut limits = set.limits().clone();
        match kind {
            LimitKind::Size => (limits.size, problem.reserve.torque) = (Some(kept), left),
            LimitKind::Rate => (limits.rate, problem.reserve.torque_rate) = (Some(kept), left),
            _ => (limits.norm, problem.reserve.torque_norm) = (kept.first().copied(), left[0]),
        }
        if let Ok(set) = ActuatorSet::clone(set).with_limits(limits) {
            problem.actuation.torque = set;
        }
    }

    /// Checks that every reserve is less than the limit of the craft.
    pub fn check(&self, craft: &Problem, held: &[f64]) -> Result<(), NotKept> {
        let bounds = self.bounds(craft);
        let Some(part) = bounds.iter().zip(held).position(|(bound, held)| held >= bound) else {
            return Ok(());
        };
        let scale = if self.quantity(craft) == Quantity::Rate { 1_f64.to_radians() } else { 1.0 };
        let number = |of: f64| significant(of / scale, 3);
        Err(NotKept::Reserve {
            name: self.name.clone(),
            part: if bounds.len() > 1 { format!(" (number {})", part + 1) } else { String::new() },
            bound: number(bounds[part]),
            needed: number(held[part]),
            unit: match self.quantity(craft) {
                Quantity::Angle => "rad",
                Quantity::Rate => "deg/s",
                Quantity::Torque => "N·m",
                Quantity::TorqueRate => "N·m/s",
            },
        })
    }

    /// Returns the reserve that plans of `problem` leave unused, together with the limits of the
    /// craft.
    pub fn told(&self, problem: &Problem, craft: &Problem) -> Held {
        Held {
            name: self.name.clone(),
            quantity: self.quantity(craft),
            parts: self.held(problem),
            bounds: self.bounds(craft),
        }
    }

    /// Returns the constraints that flights must watch to record the distance of each part. The
    /// list is empty for torque limits, which flights always record.
    pub fn watched(&self, craft: &Problem) -> Vec<Constraint> {
        let Which::Constraint(index) = self.which else { return Vec::new() };
        let constraint = &craft.constraints[index];
        let Rule::RateAxes(limits) = &constraint.rule else { return vec![constraint.clone()] };
        let alone = |axis: usize| {
            let limits = Vector3::from_fn(|row, _| if row == axis { limits[row] } else { f64::INFINITY });
            Constraint { name: self.name.clone(), rule: Rule::RateAxes(limits) }
        };
        (0..3).map(alone).collect()
    }

    /// Returns the distance of a flight from each part of the limit, SI. `first` is the index of
    /// the limit's first constraint in the record of the flight.
    pub fn room(&self, craft: &Problem, flown: &Flown, first: usize) -> Vec<f64> {
        let bounds = self.bounds(craft);
        match self.which {
            Which::Inputs(_, first) => flown.input_room[first..first + bounds.len()].to_vec(),
            Which::Constraint(_) => {
                // Flights record the distance from a rate limit as a fraction of the limit.
                let unit = |bound: &f64| if bound.is_finite() { *bound } else { 1.0 };
                flown.room[first..].iter().zip(&bounds).map(|(room, bound)| room * unit(bound)).collect()
            }
        }
    }
}
