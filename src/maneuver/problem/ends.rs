//! The end of a maneuver: the given part of the end state, and ends on a target that may move.

use super::{Problem, State};
use crate::Matrix3;
use crate::maneuver::aim::{Aim, AimError, Ends, Meeting};

/// The given part of the end state. The plan chooses the rest, by the transversality conditions.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum EndCondition {
    /// Attitude and angular velocity; for a maneuver of position and attitude also position and
    /// velocity.
    #[default]
    State,
    /// Everything except the attitude (detumbling): the body comes to rest, or to a given rate in
    /// body axes, in any attitude.
    AnyAttitude,
    /// A body axis points at a target, which may move. The roll about the axis may be free.
    Aim(Aim),
    /// The state [`Problem::end`], moved to the position of a target at the arrival time. The
    /// search for ends on targets uses this condition.
    #[doc(hidden)]
    Met(Meeting),
}

impl Problem {
    /// Leaves the end attitude free: detumbling.
    ///
    /// ```
    /// use slewkit::{Body, Inertia, Matrix3, Problem, Settings, Silent, State, Vector3, plan};
    ///
    /// let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 3.0))?, mass: None };
    /// let start = State::attitude(Matrix3::identity(), Vector3::new(0.3, -0.2, 0.1));
    /// let rest = State::at_rest(Matrix3::identity());
    /// let detumbling = Problem::attitude(body, start, rest, 20.0).with_any_attitude_at_end();
    /// let plan = plan(&detumbling, &Settings::default(), None, &mut Silent)?;
    /// // With equal weights the torque brakes along the momentum: the effort is |Π|²/2T, whatever the inertia.
    /// let momentum = Vector3::new(0.3, -0.4, 0.3);
    /// assert!((plan.solution.cost / (momentum.norm_squared() / 40.0) - 1.0).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_any_attitude_at_end(self) -> Self {
        Self { end_condition: EndCondition::AnyAttitude, ..self }
    }

    /// Sets an end at which a body axis points at a target. It replaces the attitude and the rate
    /// of [`Problem::end`].
    ///
    /// ```
    /// use slewkit::{Aim, Body, Direction, Inertia, Matrix3, Problem, Settings, Silent, State, Vector3, plan};
    ///
    /// let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 3.0))?, mass: None };
    /// let start = State::at_rest(Matrix3::identity());
    /// let star = Direction::Fixed(Vector3::new(1.0, 2.0, -1.0).normalize());
    /// let aim = Aim::new(Vector3::z(), star).at_rest();
    /// let problem = Problem::attitude(body, start, start, 4.0).with_aim_at_end(aim);
    /// let plan = plan(&problem, &Settings::discrete(), None, &mut Silent)?;
    /// // The best of all rolls about the boresight, on 100 steps.
    /// assert!((plan.solution.cost - 0.47766).abs() < 5e-4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_aim_at_end(self, aim: Aim) -> Self {
        Self { end_condition: EndCondition::Aim(aim), ..self }
    }

    /// Returns the target on which the maneuver ends; `None` if it does not end on a target.
    pub fn aim(&self) -> Option<&Aim> {
        match &self.end_condition {
            EndCondition::Aim(aim) => Some(aim),
            EndCondition::State | EndCondition::AnyAttitude | EndCondition::Met(_) => None,
        }
    }

    /// Returns the meeting with a moving target; `None` if the end state does not depend on the
    /// duration.
    pub(crate) fn met(&self) -> Option<&Meeting> {
        match &self.end_condition {
            EndCondition::Met(meeting) => Some(meeting),
            EndCondition::State | EndCondition::AnyAttitude | EndCondition::Aim(_) => None,
        }
    }

    /// Builds the problem with a fixed end state: the end on a target at the roll `roll` \[rad\].
    pub(crate) fn facing(&self, ends: &Ends, roll: f64) -> Self {
        let (attitude, angular_velocity) = ends.at(roll);
        let end = State { attitude, angular_velocity, ..self.end };
        Self { end, end_condition: EndCondition::State, ..self.clone() }
    }

    /// Builds the problem whose end is the end on a target at `time` \[s\], at the roll nearest to
    /// an attitude. A plan that lands moves its end to the position of the target at its arrival.
    /// `slope` is the derivative of the delay of plans with respect to the time.
    pub(crate) fn meeting(
        &self,
        aim: &Aim,
        attitude: &Matrix3,
        time: f64,
        slope: f64,
    ) -> Result<Self, AimError> {
        let ends = self.ends_on(aim, time)?;
        let facing = self.facing(&ends, ends.nearest(attitude));
        let meeting = Meeting { aim: aim.clone(), time, slope };
        Ok(Self { end_condition: EndCondition::Met(meeting), ..facing })
    }

    /// Returns the end states on `aim` at `time` \[s\].
    pub(crate) fn ends_on(&self, aim: &Aim, time: f64) -> Result<Ends, AimError> {
        aim.ends(time, &self.start.attitude, &self.environment.frame_rate())
    }

    /// Returns the end state of a plan that takes `duration` \[s\]. If the plan meets a moving
    /// target, the end is at the position of the target at that time.
    pub(crate) fn end_after(&self, duration: f64) -> State {
        let ends = self.met().and_then(|meeting| {
            let ends = self.ends_on(&meeting.aim, duration).ok()?;
            // The attitude is kept nearest to the previous one in space. The roll relative to the
            // shortest way changes quickly if the target is almost opposite.
            Some(ends.at(ends.nearest(&self.end.attitude)))
        });
        let Some((attitude, angular_velocity)) = ends else { return self.end };
        State { attitude, angular_velocity, ..self.end }
    }

    /// Returns whether the plan chooses the end attitude.
    pub fn ends_in_any_attitude(&self) -> bool {
        self.end_condition == EndCondition::AnyAttitude
    }
}
