//! Checks of the inputs against the objective: prices, limits, pulses, thrusters and wheels.

use super::{first_met, out_of_range};
use crate::maneuver::constraint::BOUNDARY_ROUNDING;
use crate::maneuver::grid::Scheme;
use crate::maneuver::objective::{Fuel, Objective};
use crate::maneuver::problem::{Motion, Problem, ProblemError, Stepping, Unsuited};
use crate::mechanics::actuators::{ActuatorSet, AxisFrame, Thrusters, Wheels};

impl Problem {
    /// Checks the prices of fuel and time, and that thrusters are used for minimum time or fuel
    /// only.
    pub(super) fn check_prices(&self) -> Result<(), ProblemError> {
        if let Some(price) =
            self.objective.given_time_price().filter(|price| !(*price > 0.0 && price.is_finite()))
        {
            return Err(out_of_range("price of time", price, "must be positive and finite"));
        }
        if let Some(longest) = self.duration.at_most() {
            if !(longest > 0.0 && longest.is_finite()) {
                return Err(out_of_range("longest duration", longest, "must be positive and finite"));
            }
            if self.objective == Objective::Time {
                return Err(Unsuited::LongestDuration.into());
            }
        }
        if self.seeks_duration() && !self.objective.switches() {
            self.check_free_duration()?;
        }
        if let Some(fuel) = self.objective.fuel() {
            self.check_fuel_prices(fuel)?;
        }
        let sets = [Some(&self.actuation.torque), self.actuation.force.as_ref()];
        let thrusters = self.actuation.thrusters.is_some();
        if !self.objective.switches()
            && (thrusters || sets.into_iter().flatten().any(|set| set.limits().one_sided))
        {
            return Err(Unsuited::ThrustersOfEffort.into());
        }
        Ok(())
    }

    /// Checks that each input has one price, and that all prices are equal if fuel is counted by
    /// the norm.
    fn check_fuel_prices(&self, fuel: &Fuel) -> Result<(), ProblemError> {
        let (torque, force) = (&self.actuation.torque, self.actuation.force.as_ref());
        if fuel.prices.is_some() && self.actuation.thrusters.is_some() {
            return Err(Unsuited::TorquePricesOfThrusters.into());
        }
        let sets = [
            (Some(torque), &fuel.prices, "number of torque inputs", Unsuited::TorquePricesUnderNorm),
            (force, &fuel.force_prices, "number of force inputs", Unsuited::ForcePricesUnderNorm),
        ];
        for (set, prices, number, several) in sets {
            let Some(prices) = prices else { continue };
            let count = set.map_or(0, ActuatorSet::count);
            if prices.len() != count {
                return Err(out_of_range(number, count as f64, "must equal the number of fuel prices"));
            }
            if let Some(price) = prices.iter().copied().find(|price| !(*price > 0.0 && price.is_finite())) {
                return Err(out_of_range("price", price, "must be positive and finite"));
            }
            let differ = prices.iter().any(|price| *price != prices[0]);
            if differ && set.is_some_and(Fuel::is_of_norm) {
                return Err(several.into());
            }
        }
        Ok(())
    }

    /// Checks the requirements of minimum effort in a free duration.
    fn check_free_duration(&self) -> Result<(), ProblemError> {
        if self.scheme == Scheme::LieVerlet { Ok(()) } else { Err(Unsuited::SchemeOfSoughtDuration.into()) }
    }

    /// Checks the requirements of minimum time and fuel: torques along body axes that together
    /// reach every direction, or every direction of the plane of the maneuver, and a limit on every
    /// input.
    pub(super) fn check_switching(&self) -> Result<(), ProblemError> {
        let torque = &self.actuation.torque;
        let moves = self.motion == Motion::RigidBody;
        let force = self.actuation.force.as_ref().filter(|_| moves);
        let unlimited = |set: &ActuatorSet| {
            let limits = set.limits();
            let infinite = |size: &Vec<f64>| size.iter().any(|size| !size.is_finite());
            limits.size.as_ref().map_or(limits.norm.is_none(), infinite)
        };
        let directions = match &self.actuation.thrusters {
            None => Unsuited::TorqueDirections,
            Some(_) => Unsuited::ThrusterDirections,
        };
        let reached = self.actuation.reaches_every_direction(moves)
            || self.actuation.reaches_both_senses(moves) && self.stays_in_plane().is_some();
        first_met([
            (torque.frame() != AxisFrame::Body, Unsuited::ReferenceTorques),
            (unlimited(torque), Unsuited::UnlimitedTorque),
            (force.is_some_and(unlimited), Unsuited::UnlimitedForce),
            (!reached, directions),
            (self.scheme != Scheme::LieVerlet, Unsuited::SchemeOfSwitching),
        ])
    }

    /// Checks the requirements of a minimum pulse width: an attitude maneuver of a free body
    /// without wheels, minimum fuel as the objective, and a limit on each input as the only kind of
    /// limit.
    pub(super) fn check_pulses(&self) -> Result<(), ProblemError> {
        let limits = self.actuation.torque.limits();
        let of_forces = self.actuation.force.as_ref().and_then(|force| force.limits().shortest_pulse);
        let Some(shortest) = limits.shortest_pulse.or(of_forces) else { return Ok(()) };
        if !(shortest > 0.0 && shortest.is_finite()) {
            return Err(out_of_range("shortest pulse", shortest, "must be positive and finite"));
        }
        let of_motion = of_forces.is_some() || self.motion != Motion::Attitude;
        first_met([
            (of_motion, Unsuited::PulsesOfMotion),
            (!self.is_free_turn(), Unsuited::PulsesInField),
            (self.objective.fuel().is_none(), Unsuited::PulsesWithoutFuel),
            (self.actuation.wheels.is_some(), Unsuited::PulsesOfWheels),
            (limits.size.is_none() || limits.norm.is_some(), Unsuited::PulsesUnderNorm),
            (limits.rate.is_some(), Unsuited::PulsesOfLimitedRate),
            (!self.constraints.is_empty(), Unsuited::PulsesUnderConstraints),
            (self.stepping == Stepping::Equal, Unsuited::PulsesOnEqualSteps),
        ])?;
        if self.duration.at_most().or(self.duration.known()).is_some_and(|longest| shortest > longest) {
            return Err(out_of_range("shortest pulse", shortest, "must not be longer than the maneuver"));
        }
        Ok(())
    }

    /// Checks thrusters that produce both force and torque: a maneuver of position and attitude,
    /// with actuator sets as [`Actuation::of_thrusters`](crate::mechanics::Actuation::of_thrusters)
    /// builds them.
    pub(super) fn check_thrusters(&self) -> Result<(), ProblemError> {
        let Some(Thrusters { positions }) = &self.actuation.thrusters else { return Ok(()) };
        let torque = &self.actuation.torque;
        let alike = self.actuation.force.as_ref().is_some_and(|force| {
            let arms = positions.iter().zip(force.axes()).map(|(position, axis)| position.cross(axis));
            let frames = [force.frame(), torque.frame()];
            force.limits() == torque.limits()
                && frames == [AxisFrame::Body; 2]
                && [force.count(), torque.count()] == [positions.len(); 2]
                && arms.zip(torque.axes()).all(|(arm, axis)| arm == *axis)
        });
        let limits = torque.limits();
        let each =
            limits.one_sided && limits.size.is_some() && limits.norm.is_none() && limits.rate.is_none();
        first_met([
            (!each, Unsuited::ThrusterLimits),
            (self.motion == Motion::Attitude, Unsuited::ThrustersOfAttitude),
            (self.actuation.wheels.is_some(), Unsuited::ThrustersWithWheels),
            (!alike, Unsuited::ThrusterAxes),
        ])
    }

    pub(super) fn check_wheels(&self) -> Result<(), ProblemError> {
        let Some(Wheels { momentum, momentum_limit }) = &self.actuation.wheels else { return Ok(()) };
        let torque = &self.actuation.torque;
        let refuse = |reason: String| Err(ProblemError::Wheels(reason));
        if self.motion == Motion::RigidBody || self.actuation.force.is_some() {
            return refuse("reaction wheels need a maneuver of the attitude only".into());
        }
        if torque.frame() == AxisFrame::Reference {
            return refuse(
                "the axes of reaction wheels are fixed in the body, not in the reference frame".into(),
            );
        }
        let count = torque.count();
        if momentum.len() != count || momentum_limit.len() != count {
            return refuse(format!(
                "{count} torque axes need as many wheels: {} momenta and {} momentum limits are given",
                momentum.len(),
                momentum_limit.len()
            ));
        }
        for (index, axis) in torque.axes().iter().enumerate() {
            let (wheel, length) = (index + 1, axis.norm());
            if (length - 1.0).abs() > BOUNDARY_ROUNDING {
                return refuse(format!("the axis of wheel {wheel} has length {length}: it must be 1"));
            }
            let (stored, limit) = (momentum[index], momentum_limit[index]);
            if !stored.is_finite() {
                return refuse(format!("the momentum of wheel {wheel} is {stored}: it must be finite"));
            }
            let positive = limit > 0.0;
            if !positive {
                return refuse(format!(
                    "the momentum limit of wheel {wheel} is {limit}: it must be positive"
                ));
            }
            if stored.abs() > limit * (1.0 + BOUNDARY_ROUNDING) {
                return refuse(format!(
                    "wheel {wheel} starts with {stored} N·m·s, and its limit is {limit} N·m·s"
                ));
            }
        }
        // One or two wheels are intended; three wheels in a plane are a mistake.
        match torque.rank() {
            (rank, Some(axis)) if rank < count.min(3) => {
                let what = if rank == 2 { "no torque about" } else { "torque only about" };
                let [x, y, z] = [axis.x, axis.y, axis.z].map(|part| (part * 1e3).round() / 1e3 + 0.0);
                refuse(format!("the wheel axes have rank {rank}: {what} ({x}, {y}, {z})"))
            }
            _ => Ok(()),
        }
    }
}
