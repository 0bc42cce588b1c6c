//! What does not go together in a maneuver.

use thiserror::Error;

/// What is minimised does not go with what the maneuver has, or lacks.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unsuited {
    /// A duration is given where time has a cost.
    #[error("time has a cost: the duration is sought, not given")]
    GivenDuration,
    /// A duration is sought, and nothing says how to choose it.
    #[error("a duration is sought at a price of time or up to a bound: neither is given")]
    SoughtDuration,
    /// Minimum time has a longest duration.
    #[error("the duration is what is minimised: it takes no bound")]
    LongestDuration,
    /// A duration of least effort is sought by another scheme than Lie–Verlet.
    #[error("the duration is sought by Lie–Verlet")]
    SchemeOfSoughtDuration,
    /// Inputs push to one side only where effort is minimised.
    #[error("thrusters push to one side only: they are planned for minimum time and fuel")]
    ThrustersOfEffort,
    /// Torques have prices that are those of thrusters which push as well.
    #[error("the prices of thrusters that push and turn are those of forces")]
    TorquePricesOfThrusters,
    /// Several prices where the norm of the torque counts.
    #[error("fuel is counted by the norm of the torque under a limit of that: it has one price")]
    TorquePricesUnderNorm,
    /// Several prices where the norm of the force counts.
    #[error("fuel is counted by the norm of the force under a limit of that: it has one price")]
    ForcePricesUnderNorm,
    /// Minimum time or fuel of torques about axes of the reference frame.
    #[error("minimum time and fuel are planned for torques along body axes")]
    ReferenceTorques,
    /// Minimum time or fuel of torques without a limit.
    #[error("minimum time and fuel need a limit of every torque: without one the best plan is an impulse")]
    UnlimitedTorque,
    /// Minimum time or fuel of forces without a limit.
    #[error("minimum time and fuel need a limit of every force: without one the best plan is an impulse")]
    UnlimitedForce,
    /// Minimum time or fuel of torques that leave a direction out.
    #[error("minimum time and fuel are planned for torques that reach every direction")]
    TorqueDirections,
    /// Minimum time or fuel of thrusters that leave a push or a turn out.
    #[error("minimum time and fuel are planned for thrusters that together push and turn in every direction")]
    ThrusterDirections,
    /// Minimum time or fuel by another scheme than Lie–Verlet.
    #[error("minimum time and fuel are planned by Lie–Verlet")]
    SchemeOfSwitching,
    /// One way round is asked for where any attitude will do.
    #[error("where any attitude will do there is no way round to choose")]
    WayToAnyAttitude,
    /// One way round is asked for where the roll about the boresight is free.
    #[error("an end on a target has no way round to choose: all are compared")]
    WayToTarget,
    /// Least fuel in a duration that is sought, to a target that moves.
    #[error("least fuel to a target that moves is planned in a given duration")]
    FuelToMovingTarget,
    /// Least effort in a duration that is sought, to a target that moves, within more than limits of the torques.
    #[error(
        "within limits of more than the torques, least effort to a target that moves is planned in a given duration"
    )]
    LimitsToMovingTarget,
    /// A shortest pulse where any attitude will do.
    #[error("pulses are planned to an attitude that is given")]
    PulsesToAnyAttitude,
    /// A shortest pulse of forces, or of a body that moves.
    #[error("pulses are planned for torques and the attitude alone")]
    PulsesOfMotion,
    /// A shortest pulse where something else acts.
    #[error("pulses are planned for a body that nothing acts on but its torques")]
    PulsesInField,
    /// A shortest pulse where fuel is not minimised.
    #[error("pulses are planned for minimum fuel alone")]
    PulsesWithoutFuel,
    /// A shortest pulse of wheels.
    #[error("wheels do not pulse: they give any torque within their limits")]
    PulsesOfWheels,
    /// A shortest pulse of inputs without limits of their own.
    #[error("pulses are of inputs with limits of their own, not under a limit of the norm")]
    PulsesUnderNorm,
    /// A shortest pulse where it is limited how fast inputs change.
    #[error("pulses jump: they go with no limit of how fast inputs change")]
    PulsesOfLimitedRate,
    /// A shortest pulse with cones or limits of the rates.
    #[error("pulses are planned without cones and limits of the rates")]
    PulsesUnderConstraints,
    /// A shortest pulse where SCP is asked for.
    #[error("pulses begin and end between equal steps: method = \"scp\" does not plan them")]
    PulsesOnEqualSteps,
    /// Thrusters that push and turn, with limits of another kind than one for each.
    #[error(
        "thrusters that push and turn push to one side only, up to a limit each, and have no other limits"
    )]
    ThrusterLimits,
    /// Thrusters that push a body of which the attitude alone is planned.
    #[error("thrusters that push as well are for a body that moves")]
    ThrustersOfAttitude,
    /// Thrusters that push and turn beside wheels.
    #[error("thrusters that push and turn do not go with wheels")]
    ThrustersWithWheels,
    /// Thrusters that push along other axes than they turn about.
    #[error("the axes and limits of thrusters that push and turn do not agree")]
    ThrusterAxes,
}
