//! The keys of what a plan is flown with: gains, what is uncertain, and how actuators follow.

use super::*;

tables! {
    /// Gains along the plan.
    pub(crate) static FEEDBACK[selector: Some("kind")] {
        /// neighbouring: of all corrections that bring the craft to the end those of least cost. tvlqr: the regulator of the weights
        /// below, also where inputs switch. switching: of plans of arcs how long each lasts from another start, to correct once,
        /// and then that regulator. Default: neighbouring; tvlqr where time or fuel is minimised, and of wheels.
        "kind": Choice(&["neighbouring", "tvlqr", "switching"], &[]);
        /// Part of the steps at the end over which neighbouring gains are held, at least four steps; 0: none. Default: 0.15.
        "freeze": Number(q::PART);
        /// Weight of the attitude error in a second, in the unit of the cost for each rad². Default: by which a radian costs what the
        /// torque costs that turns the body by a radian in the duration.
        "attitude_weight": Number(q::WHEEL_WEIGHT);
        /// Weight of the error of the rate in a second, for each (rad/s)². Default: the same at the scale of the duration.
        "rate_weight": Number(q::WHEEL_WEIGHT);
        /// How many times what the whole duration weighs the end does. Default: 1000.
        "end_weight": Number(q::WHEEL_WEIGHT);
    }

    /// What is uncertain of the craft: one standard deviation each, independent; one number for all three axes, or three.
    pub(crate) static UNCERTAINTY {
        /// Of the state at the start.
        "start": Table(&UNCERTAIN_STATE);
        /// Of the inertia.
        "inertia": Table(&UNCERTAIN_INERTIA);
        /// How actuators and sensors are turned against the body.
        "alignment": Table(&UNCERTAIN_ALIGNMENT);
        /// What the actuators give.
        "actuators": Table(&UNCERTAIN_ACTUATORS);
        /// What is measured.
        "sensor": Table(&UNCERTAIN_SENSOR);
    }

    static UNCERTAIN_STATE {
        /// Attitude, about the body axes.
        "attitude_deg": Spread(q::SPREAD);
        /// Angular velocity.
        "angular_velocity_deg_s": Spread(q::SPREAD);
    }

    static UNCERTAIN_INERTIA {
        /// Each moment about a body axis, as a part of itself.
        "relative": Spread(q::SPREAD);
        /// Each product of inertia.
        "products_kg_m2": Number(q::SPREAD);
    }

    static UNCERTAIN_ALIGNMENT {
        /// All actuators together, about the body axes.
        "actuators_deg": Spread(q::SPREAD);
        /// The attitude sensor, about the body axes.
        "sensor_deg": Spread(q::SPREAD);
    }

    static UNCERTAIN_ACTUATORS {
        /// Scale of each input, as a part.
        "scale": Number(q::SPREAD);
        /// A constant torque from outside, body axes.
        "constant_n_m": Spread(q::SPREAD);
        /// Noise of the torque: the square root of its intensity. Over a step of h seconds it changes the momentum by this times √h.
        "noise_n_m_sqrt_s": Spread(q::SPREAD);
    }

    static UNCERTAIN_SENSOR {
        /// Noise of the attitude, fresh at each step.
        "attitude_deg": Spread(q::SPREAD);
        /// Noise of the angular velocity, fresh at each step.
        "angular_velocity_deg_s": Spread(q::SPREAD);
        /// Scale of the measured angular velocity about each axis, as a part.
        "scale": Number(q::SPREAD);
        /// A constant error of the measured angular velocity.
        "bias_deg_s": Spread(q::SPREAD);
    }

    /// How the actuators follow their commands when a plan is flown. Default: at once.
    pub(crate) static PLANT {
        /// Time constant of a lag of first order.
        "actuator_lag_s": Number(q::NOT_NEGATIVE_TIME);
        /// Time from a command to its effect.
        "delay_s": Number(q::NOT_NEGATIVE_TIME);
        /// What a command is a multiple of, in the unit of an input.
        "torque_quantum_n_m": Number(q::SPREAD);
        /// Time between two changes of the torque; a whole part of a step. Default: the step.
        "tick_s": Number(q::DURATION);
        /// What the actuators can give, as a multiple of the limits that the plan keeps, from 1 on: what is above is held back for
        /// the gains, which along plans of least time and fuel have nothing else. Default: 1.
        "authority": Number(q::AUTHORITY);
        /// Whether the commands of the plan lead lag and delay, which are known. Default: yes.
        "feedforward": Choice(&["leads", "as_planned"], &[]);
    }
}
