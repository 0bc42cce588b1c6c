//! Checks that the types cannot express: number ranges, rotation matrices, and boundary states
//! against steps and constraints.

mod inputs;

use super::{Motion, Path, Problem, ProblemError, State, Stepping, Unsuited};
use crate::Matrix3;
use crate::Vector3;
use crate::maneuver::constraint::{AlternativesError, Constraint, ConstraintError, Rule, conflict};
use crate::maneuver::duration::Duration;
use crate::maneuver::objective::Objective;
use std::collections::HashSet;

impl Problem {
    /// Checks the properties that the types cannot express: those of [`Problem::check_numbers`],
    /// and that the start and the end satisfy the constraints.
    ///
    /// A boundary value exactly on a limit is accepted.
    ///
    /// # Errors
    /// Returns the first [`ProblemError`].
    pub fn check(&self) -> Result<(), ProblemError> {
        self.check_numbers()?;
        self.violations().next().map_or(Ok(()), Err)
    }

    /// Checks everything that propagation and the computation of margins need: number ranges,
    /// rotation matrices, the step against the boundary rates, the constraints themselves, and
    /// wheels and weights against their inputs.
    ///
    /// # Errors
    /// Returns the first [`ProblemError`], but never [`ProblemError::Violated`].
    pub fn check_numbers(&self) -> Result<(), ProblemError> {
        self.check_duration()?;
        if self.steps < Self::MIN_STEPS || self.steps > Self::MAX_STEPS {
            return Err(out_of_range("steps", self.steps as f64, "must be from 2 to 1000000"));
        }
        if self.motion == Motion::RigidBody {
            let Some(mass) = self.body.mass else {
                return Err(ProblemError::Missing("a maneuver that moves the body needs its mass"));
            };
            if !(mass > 0.0 && mass.is_finite()) {
                return Err(out_of_range("mass", mass, "must be positive and finite"));
            }
        }
        self.check_wheels()?;
        self.check_thrusters()?;
        let weights = self.objective.weights();
        weights.check(&self.actuation).map_err(|(inputs, error)| ProblemError::Weight { inputs, error })?;
        self.check_constraints()?;
        self.check_prices()?;
        if self.objective.switches() {
            self.check_switching()?;
        }
        self.check_pulses()?;
        self.check_any_attitude()?;
        self.check_aim()?;
        self.ends().try_for_each(|(end, state, _)| self.check_state(end, &state))
    }

    /// Returns every constraint that the start or the end violates, so that no plan can satisfy it.
    ///
    /// Two constraints that exclude every attitude are ignored, because another start or end would
    /// not help; the planner proves this case. The boundary states and the constraints themselves
    /// must be valid.
    #[doc(hidden)]
    pub fn violations(&self) -> impl Iterator<Item = ProblemError> {
        let frame_rate = self.environment.frame_rate();
        // If the duration is free, only the start is known.
        let turned = if frame_rate == Vector3::zeros() { 0.0 } else { self.duration.known().unwrap_or(0.0) };
        let turned = frame_rate * turned;
        let required: Vec<Constraint> = self.required().cloned().collect();
        let contradicting = conflict(&required, &turned).map(|found| found.names.map(String::from));
        let considered = move |constraint: &&Constraint| {
            contradicting.as_ref().is_none_or(|names| !names.contains(&constraint.name))
        };
        let required: Vec<&Constraint> = self.required().filter(considered).collect();
        self.ends().flat_map(move |(end, state, time)| {
            // A free end attitude is not checked against cones here.
            let open = end == "end" && self.ends_in_any_attitude();
            let judged =
                move |constraint: &&Constraint| !(open && matches!(constraint.rule, Rule::Pointing(_)));
            let violation = move |constraint: &Constraint| {
                constraint.violation(&state.attitude, &state.angular_velocity, time, &frame_rate)
            };
            let violated = required.clone().into_iter().filter(judged).filter_map(move |constraint| {
                let found = violation(constraint)?;
                Some(ProblemError::Violated { end, name: constraint.name.clone(), found })
            });
            let none_holds = self.alternatives.iter().filter(move |_| !open).filter_map(move |of| {
                let member = |name: &String| self.constraints.iter().find(|one| one.name == *name);
                let of_set = |set: &Vec<String>| set.iter().filter_map(member).find_map(violation);
                let found: Option<Vec<String>> = of.sets.iter().map(of_set).collect();
                Some(ProblemError::Violated { end, name: of.name.clone(), found: found?.join(", and ") })
            });
            violated.chain(none_holds)
        })
    }

    /// Returns the constraints that hold at all times.
    fn required(&self) -> impl Iterator<Item = &Constraint> {
        let in_turns =
            |name: &str| self.alternatives.iter().any(|of| of.members().any(|member| member == name));
        self.constraints.iter().filter(move |constraint| !in_turns(&constraint.name))
    }

    /// Returns the name ("start" or "end"), state and time \[s\] of both ends; the time of the end
    /// is `None` while the duration is free.
    fn ends(&self) -> impl Iterator<Item = (&'static str, State, Option<f64>)> {
        let time = self.duration.known();
        let end = match self.aim() {
            None => Some(self.end),
            // An end on a target is checked roll by roll and, if the target moves, time by time.
            Some(aim) => time.filter(|_| !aim.has_roll()).and_then(|time| {
                let (attitude, angular_velocity) = self.ends_on(aim, time).ok()?.at(0.0);
                Some(State { attitude, angular_velocity, ..self.end })
            }),
        };
        [Some(("start", self.start, Some(0.0))), end.map(|end| ("end", end, time))].into_iter().flatten()
    }

    /// Checks the duration. It must be in range, free if the cost includes time, and given if
    /// neither a price nor a bound selects it.
    fn check_duration(&self) -> Result<(), ProblemError> {
        let usable = |duration: f64| duration > 0.0 && duration.is_finite();
        let in_range = "must be positive and finite";
        match self.duration {
            Duration::Given(duration) | Duration::Found { duration, .. } if !usable(duration) => {
                Err(out_of_range("duration", duration, in_range))
            }
            Duration::Given(_) if self.objective.counts_time() => Err(Unsuited::GivenDuration.into()),
            Duration::Sought { at_most: None } if !self.objective.counts_time() => {
                Err(Unsuited::SoughtDuration.into())
            }
            _ => Ok(()),
        }
    }

    fn check_state(&self, end: &'static str, state: &State) -> Result<(), ProblemError> {
        let vectors = [&state.position, &state.velocity, &state.angular_velocity];
        for value in vectors.into_iter().flatten().chain(state.attitude.iter()) {
            if !value.is_finite() {
                return Err(out_of_range("boundary state", *value, "must be finite"));
            }
        }
        let residual = (state.attitude.transpose() * state.attitude - Matrix3::identity()).amax();
        if residual > 1e-12 {
            return Err(ProblemError::NotRotation { end, residual });
        }
        if state.attitude.determinant() < 0.0 {
            return Err(ProblemError::NotRotation { end, residual: 2.0 });
        }
        let limit = if self.body.inertia.is_degenerate() { 0.5 } else { 1.0 };
        let rate = state.angular_velocity.norm();
        let Some(duration) = self.duration.known() else { return Ok(()) };
        let angle = rate * self.step();
        if angle >= limit {
            let steps = ((rate * duration / limit).floor() as usize).saturating_add(1);
            return Err(ProblemError::StepTooLong { end, angle, limit, steps });
        }
        Ok(())
    }

    /// Checks the requirements of a free end attitude.
    fn check_any_attitude(&self) -> Result<(), ProblemError> {
        let free = self.ends_in_any_attitude();
        first_met([
            (free && self.path != Path::Best, Unsuited::WayToAnyAttitude),
            (free && self.shortest_pulse().is_some(), Unsuited::PulsesToAnyAttitude),
        ])
    }

    /// Checks the requirements of an end on a target.
    fn check_aim(&self) -> Result<(), ProblemError> {
        let Some(aim) = self.aim() else { return Ok(()) };
        aim.check()?;
        let sought = self.duration.known().is_none() && aim.moves(&self.environment.frame_rate());
        let on_equal_steps = self.stepping == Stepping::Equal;
        let effort_beyond_shooting =
            self.has_shaping_limits() || self.motion == Motion::RigidBody || on_equal_steps;
        first_met([
            (self.path != Path::Best, Unsuited::WayToTarget),
            (sought && self.objective.fuel().is_some(), Unsuited::FuelToMovingTarget),
            (
                sought && self.objective != Objective::Time && effort_beyond_shooting,
                Unsuited::LimitsToMovingTarget,
            ),
        ])?;
        if let Some(time) = self.duration.known() {
            self.ends_on(aim, time)?;
        }
        Ok(())
    }

    fn check_constraints(&self) -> Result<(), ProblemError> {
        let count = self.constraints.len();
        if count > Self::MAX_CONSTRAINTS {
            return Err(out_of_range("number of constraints", count as f64, "must be at most 1000"));
        }
        let mut names = HashSet::new();
        for constraint in &self.constraints {
            let Constraint { name, .. } = constraint;
            let wrong = |error| ProblemError::Constraint { name: name.clone(), error };
            constraint.check().map_err(wrong)?;
            if !names.insert(name) {
                return Err(wrong(ConstraintError::SameName));
            }
        }
        let mut taken: Vec<&str> = Vec::new();
        for of in &self.alternatives {
            let wrong = |error| ProblemError::Alternatives { name: of.name.clone(), error };
            of.check(&self.constraints).map_err(wrong)?;
            if let Some(twice) = of.members().find(|member| taken.contains(member)) {
                return Err(wrong(AlternativesError::Twice(twice.into())));
            }
            taken.extend(of.members());
        }
        Ok(())
    }
}

/// Returns the error of the first obstacle that applies.
fn first_met<const N: usize>(obstacles: [(bool, Unsuited); N]) -> Result<(), ProblemError> {
    let met = obstacles.into_iter().find(|(met, _)| *met);
    met.map_or(Ok(()), |(_, cause)| Err(cause.into()))
}

fn out_of_range(what: &'static str, value: f64, reason: &'static str) -> ProblemError {
    ProblemError::Value { what, value, reason }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector3;
    use crate::lie;
    use crate::maneuver::constraint::{Direction, Pointing, Rule, Side};
    use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Wheels};
    use crate::mechanics::body::{Body, Inertia};

    /// Returns the maneuver of a quarter turn about z.
    fn slew() -> Problem {
        let inertia = Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5)).unwrap();
        let end = State::at_rest(lie::exp(&(Vector3::z() * std::f64::consts::FRAC_PI_2)));
        Problem::attitude(Body { inertia, mass: None }, State::at_rest(Matrix3::identity()), end, 10.0)
    }

    fn cone(side: Side, direction: Vector3, half_angle_deg: f64) -> Constraint {
        let directions = vec![Direction::Fixed(direction)];
        let (boresights, half_angle) = (vec![Vector3::x()], half_angle_deg.to_radians());
        let rule = Rule::Pointing(Pointing::new(side, boresights, directions, half_angle));
        Constraint { name: "cone".into(), rule }
    }

    /// Checks the problem of a slew with wheels along `axes`, modified by `change`.
    fn wheeled(axes: &[[f64; 3]], change: impl FnOnce(&mut Wheels)) -> Result<(), ProblemError> {
        let count = axes.len();
        let axes = axes.iter().copied().map(Vector3::from).collect();
        let torque = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
        let mut wheels = Wheels { momentum: vec![0.0; count], momentum_limit: vec![2.0; count] };
        change(&mut wheels);
        slew().with_actuation(Actuation { wheels: Some(wheels), ..Actuation::torques(torque) }).check()
    }

    #[track_caller]
    fn refused(result: Result<(), ProblemError>, wanted: &str) {
        let told = result.expect_err("accepted").to_string();
        assert_eq!(told, wanted);
    }

    #[test]
    fn ends_inside_cones_and_above_rates_are_refused_and_on_them_accepted() {
        let with = |constraint| slew().with_constraint(constraint).check();
        let told = "the start violates \"cone\": the boresight is 0 deg from the axis, the cone is 5 deg";
        refused(with(cone(Side::KeepOut, Vector3::x(), 5.0)), told);
        let told = "the end violates \"cone\": the boresight is 0 deg from the axis, the cone is 5 deg";
        refused(with(cone(Side::KeepOut, Vector3::y(), 5.0)), told);
        let told = "the end violates \"cone\": the boresight is 90 deg from the axis, the cone is 80 deg";
        refused(with(cone(Side::KeepIn, Vector3::x(), 80.0)), told);
        with(cone(Side::KeepIn, Vector3::x(), 90.0)).unwrap();
        with(cone(Side::KeepOut, Vector3::z(), 90.0)).unwrap();
        let mut fast = slew();
        fast.end.angular_velocity.y = 0.2;
        let limit = |limit| Constraint { name: "rate".into(), rule: Rule::RateNorm(limit) };
        fast.clone().with_constraint(limit(0.2)).check().unwrap();
        // Such a motion is propagated and its margins are computed.
        fast.clone().with_constraint(limit(0.1)).check_numbers().unwrap();
        let told = "the end violates \"rate\": the rate is 11.4592 deg/s, the limit is 5.7296 deg/s";
        refused(fast.with_constraint(limit(0.1)).check(), told);
    }

    #[test]
    fn constraints_must_be_in_order_and_have_names_of_their_own() {
        let rate = |limit| Constraint { name: "rate".into(), rule: Rule::RateNorm(limit) };
        let told = "constraint \"rate\": a rate limit is NaN rad/s: it must be positive and finite";
        refused(slew().with_constraint(rate(f64::NAN)).check(), told);
        let twice = slew().with_constraint(rate(1.0)).with_constraint(rate(2.0));
        refused(twice.check(), "constraint \"rate\": another constraint has this name");
        let mut many = slew();
        many.constraints =
            (0..1001).map(|index| Constraint { name: index.to_string(), ..rate(1.0) }).collect();
        refused(many.check(), "number of constraints is 1001: must be at most 1000");
        for half_angle in [0.0, 180.0, 200.0, f64::NAN] {
            let result = slew().with_constraint(cone(Side::KeepOut, Vector3::z(), half_angle)).check();
            assert!(matches!(result, Err(ProblemError::Constraint { .. })), "{half_angle}: {result:?}");
        }
    }

    #[test]
    fn wheels_must_fit_the_inputs_that_they_drive() {
        const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        wheeled(&AXES, |wheels| wheels.momentum[1] = -2.0).unwrap();
        wheeled(&AXES, |wheels| wheels.momentum_limit[2] = f64::INFINITY).unwrap();
        // Two wheels are accepted: fewer than three wheels are intended.
        wheeled(&AXES[..2], |_| {}).unwrap();
        let told = "the wheel axes have rank 2: no torque about (0, 0, 1)";
        refused(wheeled(&[AXES[0], AXES[1], [0.6, 0.8, 0.0]], |_| {}), told);
        let told = "the wheel axes have rank 1: torque only about (0, 1, 0)";
        refused(wheeled(&[AXES[1], [0.0, -1.0, 0.0]], |_| {}), told);
        let told = "the axis of wheel 3 has length 2: it must be 1";
        refused(wheeled(&[AXES[0], AXES[1], [0.0, 0.0, 2.0]], |_| {}), told);
        let told = "3 torque axes need as many wheels: 2 momenta and 3 momentum limits are given";
        refused(wheeled(&AXES, |wheels| wheels.momentum.truncate(2)), told);
        let told = "wheel 1 starts with 2.5 N·m·s, and its limit is 2 N·m·s";
        refused(wheeled(&AXES, |wheels| wheels.momentum[0] = 2.5), told);
        let told = "the momentum limit of wheel 1 is NaN: it must be positive";
        refused(wheeled(&AXES, |wheels| wheels.momentum_limit[0] = f64::NAN), told);
        let told = "the momentum of wheel 2 is inf: it must be finite";
        refused(wheeled(&AXES, |wheels| wheels.momentum[1] = f64::INFINITY), told);
        let wheels = Some(Wheels { momentum: vec![0.0; 3], momentum_limit: vec![1.0; 3] });
        let torque = ActuatorSet::three_axes(AxisFrame::Reference);
        let problem = slew().with_actuation(Actuation { wheels, ..Actuation::torques(torque) });
        refused(
            problem.check(),
            "the axes of reaction wheels are fixed in the body, not in the reference frame",
        );
    }
}
