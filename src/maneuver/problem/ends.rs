//! The end of a maneuver: the part of it that is given, and ends on a target, which may move.

use super::{Problem, State};
use crate::Matrix3;
use crate::maneuver::aim::{Aim, AimError, Ends, Meeting};

/// The given part of the end state. The plan chooses the rest, by transversality.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum EndCondition {
    /// Attitude and angular velocity, and of a body that moves position and velocity.
    #[default]
    State,
    /// All but the attitude: the body comes to rest, or to a rate in body axes, in any attitude
    /// (detumbling).
    AnyAttitude,
    /// A body axis points at a target, which may move; the roll about it may be free.
    Aim(Aim),
    /// The state [`Problem::end`], moved to the position of a target at the arrival time. The
    /// search for ends on targets uses it.
    #[doc(hidden)]
    Met(Meeting),
}

impl Problem {
    /// Leaves the attitude at the end to the plan: detumbling.
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

    /// Ends the maneuver with a body axis on a target, in place of the attitude and the rate of
    /// [`Problem::end`].
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

    /// Returns the target on which the maneuver ends, if it ends on one.
    pub fn aim(&self) -> Option<&Aim> {
        match &self.end_condition {
            EndCondition::Aim(aim) => Some(aim),
            EndCondition::State | EndCondition::AnyAttitude | EndCondition::Met(_) => None,
        }
    }

    /// Returns the meeting with a target, if the end state moves with the duration.
    pub(crate) fn met(&self) -> Option<&Meeting> {
        match &self.end_condition {
            EndCondition::Met(meeting) => Some(meeting),
            EndCondition::State | EndCondition::AnyAttitude | EndCondition::Aim(_) => None,
        }
    }

    /// The same to one of the ends on a target: that at a roll \[rad\].
    pub(crate) fn facing(&self, ends: &Ends, roll: f64) -> Self {
        let (attitude, angular_velocity) = ends.at(roll);
        let end = State { attitude, angular_velocity, ..self.end };
        Self { end, end_condition: EndCondition::State, ..self.clone() }
    }

    /// Builds the problem with the end on a target as it is at `time` \[s\], at the roll nearest
    /// to the roll of an attitude. A plan that lands moves its end to the position of the target
    /// at its arrival. `slope` is the derivative of the delay of plans by the time.
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

    /// Returns the ends on `aim` that the maneuver may have at `time` \[s\].
    pub(crate) fn ends_on(&self, aim: &Aim, time: f64) -> Result<Ends, AimError> {
        aim.ends(time, &self.start.attitude, &self.environment.frame_rate())
    }

    /// Returns the end of a plan that takes `duration` \[s\]: where the target is then, of one that
    /// it meets.
    pub(crate) fn end_after(&self, duration: f64) -> State {
        let ends = self.met().and_then(|meeting| {
            let ends = self.ends_on(&meeting.aim, duration).ok()?;
            // The roll is kept in space: that against the shortest way there turns fast where the
            // target is almost behind.
            Some(ends.at(ends.nearest(&self.end.attitude)))
        });
        let Some((attitude, angular_velocity)) = ends else { return self.end };
        State { attitude, angular_velocity, ..self.end }
    }

    /// Returns whether the attitude at the end is the plan's to choose.
    pub fn ends_in_any_attitude(&self) -> bool {
        self.end_condition == EndCondition::AnyAttitude
    }
}
