//! Contradictions between the properties of a maneuver.

use thiserror::Error;

/// A contradiction of the objective with the actuators, the limits or the end of the maneuver.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unsuited {
    /// The duration is given although time has a price.
    #[error("time has a price, and the duration is given: use a free duration")]
    GivenDuration,
    /// The duration is free, but neither a price of time nor a bound selects it.
    #[error("the duration is free: give a price of time or a bound")]
    SoughtDuration,
    /// A minimum-time maneuver has a bound on its duration.
    #[error("the duration is the objective, so it cannot have a bound: remove the bound")]
    LongestDuration,
    /// A minimum-effort maneuver of free duration uses a scheme other than Lie–Verlet.
    #[error("a free duration needs Lie–Verlet")]
    SchemeOfSoughtDuration,
    /// Minimum effort is requested for one-sided thrusters.
    #[error("thrusters act in one direction only: they need minimum time or minimum fuel")]
    ThrustersOfEffort,
    /// Thrusters that produce both force and torque have prices of torques.
    #[error("thrusters that push and turn need prices of forces, but have prices of torques")]
    TorquePricesOfThrusters,
    /// Several prices are given, although fuel is counted by the norm of the torque.
    #[error("with a norm limit on the torque, `fuel_price` must be one number")]
    TorquePricesUnderNorm,
    /// Several prices are given, although fuel is counted by the norm of the force.
    #[error("with a norm limit on the force, `force_fuel_price` must be one number")]
    ForcePricesUnderNorm,
    /// Minimum time or fuel is requested for torques about axes of the reference frame.
    #[error("minimum time and minimum fuel need torques along body axes")]
    ReferenceTorques,
    /// Minimum time or fuel is requested for torques without limits.
    #[error(
        "minimum time and minimum fuel need a limit on every torque: the optimum is otherwise an impulse"
    )]
    UnlimitedTorque,
    /// Minimum time or fuel is requested for forces without limits.
    #[error("minimum time and minimum fuel need a limit on every force: the optimum is otherwise an impulse")]
    UnlimitedForce,
    /// Minimum time or fuel is requested for torques that do not reach every direction.
    #[error("minimum time and minimum fuel need torques in every direction")]
    TorqueDirections,
    /// Minimum time or fuel is requested for thrusters that do not push and turn in every
    /// direction.
    #[error("minimum time and minimum fuel need thrusters that together push and turn in every direction")]
    ThrusterDirections,
    /// Minimum time or fuel is requested with a scheme other than Lie–Verlet.
    #[error("minimum time and minimum fuel need Lie–Verlet")]
    SchemeOfSwitching,
    /// A homotopy class is requested for a free end attitude.
    #[error("a free end attitude has no homotopy class: remove the choice of the path")]
    WayToAnyAttitude,
    /// A homotopy class is requested for an end on a target, which has several end attitudes.
    #[error("a target has several end attitudes, and all paths are compared: remove the choice of the path")]
    WayToTarget,
    /// Minimum fuel to a moving target is requested in a free duration.
    #[error("minimum fuel to a moving target needs a given duration")]
    FuelToMovingTarget,
    /// Minimum effort to a moving target is requested in a free duration, with more limits than
    /// torque limits.
    #[error(
        "minimum effort to a moving target needs a given duration if other limits than torque \
        limits apply"
    )]
    LimitsToMovingTarget,
    /// A minimum pulse width is given, and the end attitude is free.
    #[error("pulses need a given end attitude")]
    PulsesToAnyAttitude,
    /// A minimum pulse width is given for forces, or for a maneuver of position and attitude.
    #[error("pulses need torque inputs and a maneuver of the attitude only")]
    PulsesOfMotion,
    /// A minimum pulse width is given, and the body is not free: a force field acts on it.
    #[error("pulses need a free body")]
    PulsesInField,
    /// A minimum pulse width is given, and the objective is not fuel.
    #[error("pulses need minimum fuel")]
    PulsesWithoutFuel,
    /// A minimum pulse width is given for wheels.
    #[error("wheels give any torque within their limits: they have no pulses")]
    PulsesOfWheels,
    /// A minimum pulse width is given for inputs that do not each have a limit.
    #[error("pulses need a limit for each input: they cannot be combined with a norm limit")]
    PulsesUnderNorm,
    /// A minimum pulse width is given together with limits of the torque rates.
    #[error("pulses switch instantaneously: they cannot be combined with a limit on the rate of change")]
    PulsesOfLimitedRate,
    /// A minimum pulse width is given together with cones or rate limits.
    #[error("pulses cannot be combined with cones or rate limits")]
    PulsesUnderConstraints,
    /// A minimum pulse width is given together with a method on a uniform grid.
    #[error(
        "pulses begin and end inside the equal steps of the grid: method = \"scp\" does not support \
        them"
    )]
    PulsesOnEqualSteps,
    /// Thrusters that produce both force and torque have limits other than one limit for each
    /// thruster.
    #[error("thrusters that push and turn support only one limit for each thruster: remove other limits")]
    ThrusterLimits,
    /// Thrusters that push the body are given for a maneuver of the attitude alone.
    #[error("thrusters with a force need a body that translates")]
    ThrustersOfAttitude,
    /// Thrusters that produce both force and torque are combined with wheels.
    #[error("thrusters that push and turn cannot be combined with wheels")]
    ThrustersWithWheels,
    /// The force axes and torque axes of the thrusters do not match.
    #[error("the axes and limits of thrusters that push and turn disagree")]
    ThrusterAxes,
}
