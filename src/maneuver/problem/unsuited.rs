//! The properties of a maneuver that contradict each other.

use thiserror::Error;

/// The objective contradicts the actuators, the limits or the end of the maneuver.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unsuited {
    /// A duration is given where time has a cost.
    #[error("time has a price, and the duration is given: use a free duration")]
    GivenDuration,
    /// The duration is free, and neither a price nor a bound selects it.
    #[error("the duration is free: give a price of time or a bound")]
    SoughtDuration,
    /// Minimum time has a longest duration.
    #[error("the duration is the objective and has a bound: remove the bound")]
    LongestDuration,
    /// A free duration of least effort with another scheme than Lie–Verlet.
    #[error("a free duration needs Lie–Verlet")]
    SchemeOfSoughtDuration,
    /// Inputs push to one side only where effort is minimised.
    #[error("thrusters push to one side only: they need minimum time or fuel")]
    ThrustersOfEffort,
    /// Thrusters that push and turn have prices of torques.
    #[error("thrusters that push and turn have prices of torques: give prices of forces")]
    TorquePricesOfThrusters,
    /// Several prices where the norm of the torque counts.
    #[error("fuel by the norm of the torque needs a limit of the norm and one price")]
    TorquePricesUnderNorm,
    /// Several prices where the norm of the force counts.
    #[error("fuel by the norm of the force needs a limit of the norm and one price")]
    ForcePricesUnderNorm,
    /// Minimum time or fuel of torques about axes of the reference frame.
    #[error("minimum time and fuel need torques along body axes")]
    ReferenceTorques,
    /// Minimum time or fuel of torques without a limit.
    #[error("minimum time and fuel need a limit of every torque: without one the best plan is an impulse")]
    UnlimitedTorque,
    /// Minimum time or fuel of forces without a limit.
    #[error("minimum time and fuel need a limit of every force: without one the best plan is an impulse")]
    UnlimitedForce,
    /// Minimum time or fuel of torques that leave a direction out.
    #[error("minimum time and fuel need torques in every direction")]
    TorqueDirections,
    /// Minimum time or fuel of thrusters that leave a push or a turn out.
    #[error("minimum time and fuel need thrusters that together push and turn in every direction")]
    ThrusterDirections,
    /// Minimum time or fuel by another scheme than Lie–Verlet.
    #[error("minimum time and fuel need Lie–Verlet")]
    SchemeOfSwitching,
    /// A homotopy class is requested for a free end attitude.
    #[error("a free end attitude has no homotopy class: remove the choice of the path")]
    WayToAnyAttitude,
    /// A homotopy class is requested for a free roll about the boresight.
    #[error("a target has several end attitudes, and all paths are compared: remove the choice of the path")]
    WayToTarget,
    /// Least fuel in a free duration to a moving target.
    #[error("least fuel to a moving target needs a given duration")]
    FuelToMovingTarget,
    /// Least effort in a free duration to a moving target, with more limits than those of the
    /// torques.
    #[error("least effort to a moving target needs a given duration if more than the torques is limited")]
    LimitsToMovingTarget,
    /// A shortest pulse where any attitude will do.
    #[error("pulses need a given end attitude")]
    PulsesToAnyAttitude,
    /// A shortest pulse of forces, or of a body that moves.
    #[error("pulses need torques and a maneuver of the attitude alone")]
    PulsesOfMotion,
    /// A shortest pulse where something else acts.
    #[error("pulses need a free body")]
    PulsesInField,
    /// A shortest pulse where fuel is not minimised.
    #[error("pulses need minimum fuel")]
    PulsesWithoutFuel,
    /// A shortest pulse of wheels.
    #[error("wheels give any torque within their limits: they have no pulses")]
    PulsesOfWheels,
    /// A shortest pulse of inputs without limits of their own.
    #[error("pulses need a limit for each input: they cannot be combined with a norm limit")]
    PulsesUnderNorm,
    /// A shortest pulse where it is limited how fast inputs change.
    #[error("pulses jump: they cannot be combined with a limit of the rate of change")]
    PulsesOfLimitedRate,
    /// A shortest pulse with cones or limits of the rates.
    #[error("pulses cannot be combined with cones or rate limits")]
    PulsesUnderConstraints,
    /// A shortest pulse together with SCP.
    #[error("pulses begin and end between equal steps: method = \"scp\" does not support them")]
    PulsesOnEqualSteps,
    /// Thrusters that push and turn, with limits of another kind than one for each.
    #[error("thrusters that push and turn have a limit each and push to one side only: remove other limits")]
    ThrusterLimits,
    /// Thrusters that push the body in a maneuver of the attitude alone.
    #[error("thrusters with a force need a body that moves")]
    ThrustersOfAttitude,
    /// Thrusters that push and turn together with wheels.
    #[error("thrusters that push and turn cannot be combined with wheels")]
    ThrustersWithWheels,
    /// Thrusters that push along other axes than they turn about.
    #[error("the axes and limits of thrusters that push and turn disagree")]
    ThrusterAxes,
}
