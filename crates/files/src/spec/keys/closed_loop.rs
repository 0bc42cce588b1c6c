//! The keys of what a plan is flown with: gains, what is uncertain, and how actuators follow.

use super::*;

/// Deviations, a block of a covariance, or the whole of it.
const STATE_COVARIANCES: &[&[&str]] = &[
    &["attitude_deg", "attitude_covariance_deg2", "covariance_deg_deg_s"],
    &["angular_velocity_deg_s", "angular_velocity_covariance_deg2_s2", "covariance_deg_deg_s"],
];

tables! {
    /// Gains along the plan.
    pub(crate) static FEEDBACK[selector: Some("kind")] {
        /// neighbouring: of all corrections that bring the craft to the end those of least cost. tvlqr: the regulator of the weights
        /// below, also where inputs switch. switching: of plans of arcs how long each lasts from another start, to correct once,
        /// and then that regulator. Default: neighbouring; tvlqr where time or fuel is minimised, and of wheels.
        "kind": Choice(&["neighbouring", "tvlqr", "switching"], &[]);
        /// Part of the steps at the end over which neighbouring gains are held, at least four steps; 0: none. Default: 0.15.
        "freeze": Number(q::PART);
        /// Time between two measurements, a whole number of steps; a correction is held over it, and gains are designed for that.
        /// Default: the step.
        "every_s": Number(q::DURATION);
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
        /// The chance that any of several limits is exceeded at any time of the motion, counted in flights; from 1e-4 on.
        "chance": Number(q::CHANCE);
        /// Which those are: names of constraints, and of limits as reports call them, "torque limit". Default: all constraints
        /// that have no chance of their own.
        "chance_of": Texts(100);
    }

    static UNCERTAIN_STATE[exclusive: STATE_COVARIANCES] {
        /// Attitude, about the body axes.
        "attitude_deg": Spread(q::SPREAD);
        /// Angular velocity.
        "angular_velocity_deg_s": Spread(q::SPREAD);
        /// Covariance of the attitude instead: three rows of three, deg².
        "attitude_covariance_deg2": Square(q::COVARIANCE);
        /// Covariance of the angular velocity instead, (deg/s)².
        "angular_velocity_covariance_deg2_s2": Square(q::COVARIANCE);
        /// Covariance of both instead: six rows of six, attitude in deg, then angular velocity in deg/s.
        "covariance_deg_deg_s": Square(q::COVARIANCE);
    }

    static UNCERTAIN_INERTIA[exclusive: &[&["relative", "covariance_kg2_m4"], &["products_kg_m2", "covariance_kg2_m4"]]] {
        /// Each moment about a body axis, as a part of itself.
        "relative": Spread(q::SPREAD);
        /// Each product of inertia.
        "products_kg_m2": Number(q::SPREAD);
        /// Covariance of the six numbers instead: rows and columns in the order xx, yy, zz, xy, xz, yz.
        "covariance_kg2_m4": Square(q::COVARIANCE);
    }

    static UNCERTAIN_ALIGNMENT {
        /// All actuators together, about the body axes.
        "actuators_deg": Spread(q::SPREAD);
        /// The attitude sensor, about the body axes.
        "sensor_deg": Spread(q::SPREAD);
    }

    static UNCERTAIN_ACTUATORS[exclusive: &[&["noise_n_m_sqrt_s", "noise_intensity_n2_m2_s"]]] {
        /// Scale of each input, as a part: one number for all, or one for each.
        "scale": Spread(q::SPREAD);
        /// A constant torque from outside, body axes.
        "constant_n_m": Spread(q::SPREAD);
        /// Noise of the torque: the square root of its intensity. Over a step of h seconds it changes the momentum by this times √h.
        "noise_n_m_sqrt_s": Spread(q::SPREAD);
        /// Intensity of that noise instead, three rows of three: its covariance over a step of h seconds is this over h.
        "noise_intensity_n2_m2_s": Square(q::COVARIANCE);
    }

    static UNCERTAIN_SENSOR[exclusive: STATE_COVARIANCES] {
        /// Noise of the attitude, fresh at each step.
        "attitude_deg": Spread(q::SPREAD);
        /// Noise of the angular velocity, fresh at each step.
        "angular_velocity_deg_s": Spread(q::SPREAD);
        /// Covariance of the attitude instead: three rows of three, deg².
        "attitude_covariance_deg2": Square(q::COVARIANCE);
        /// Covariance of the angular velocity instead, (deg/s)².
        "angular_velocity_covariance_deg2_s2": Square(q::COVARIANCE);
        /// Covariance of both instead: six rows of six, attitude in deg, then angular velocity in deg/s.
        "covariance_deg_deg_s": Square(q::COVARIANCE);
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
