//! Shifts of the time of a maneuver: moving cones, and the times at which cones are active.

use super::{EndCondition, Problem};
use crate::maneuver::aim::Aim;
use crate::maneuver::constraint::{Direction, Pointing, Rule};

impl Problem {
    /// Builds the maneuver of a free body that begins `by` \[s\] later: directions have moved on,
    /// and the times at which constraints are active come earlier by this time.
    #[must_use]
    pub fn later(&self, by: f64) -> Self {
        let mut later = self.with_directions(|direction| direction.later(by));
        later.cones_mut().for_each(|cone| cone.during = cone.during.later(by));
        later
    }

    /// Builds the maneuver with directions that are known only for its first `lasting` \[s\].
    #[must_use]
    pub fn known_for(&self, lasting: f64) -> Self {
        self.with_directions(|direction| direction.within([0.0, lasting]))
    }

    /// Returns whether a constraint depends on the start time of the maneuver of a free body.
    pub fn is_timed(&self) -> bool {
        self.cones().any(|cone| {
            let moves = |direction: &Direction| direction.constant().is_none();
            cone.during.given().is_some() || cone.directions.iter().any(moves)
        })
    }

    /// Returns the time \[s\] up to which the directions of all constraints are known.
    pub(crate) fn known_until(&self) -> f64 {
        self.cones()
            .flat_map(|cone| &cone.directions)
            .map(Direction::known_until)
            .fold(f64::INFINITY, f64::min)
    }

    fn cones(&self) -> impl Iterator<Item = &Pointing> {
        self.constraints.iter().filter_map(|constraint| match &constraint.rule {
            Rule::Pointing(cone) => Some(cone),
            Rule::RateNorm(_) | Rule::RateAxes(_) => None,
        })
    }

    fn cones_mut(&mut self) -> impl Iterator<Item = &mut Pointing> {
        self.constraints.iter_mut().filter_map(|constraint| match &mut constraint.rule {
            Rule::Pointing(cone) => Some(cone),
            Rule::RateNorm(_) | Rule::RateAxes(_) => None,
        })
    }

    fn with_directions(&self, change: impl Fn(&Direction) -> Direction) -> Self {
        let mut changed = self.clone();
        for cone in changed.cones_mut() {
            cone.directions.iter_mut().for_each(|direction| *direction = change(direction));
        }
        if let EndCondition::Aim(aim) = &self.end_condition {
            let aim: Aim = aim.with_directions(change);
            changed.end_condition = EndCondition::Aim(aim);
        }
        changed
    }
}
