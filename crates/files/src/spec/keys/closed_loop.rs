//! Keys for flights of a plan: feedback gains, uncertainty, and the response of actuators.

use super::*;

/// Groups of keys for the covariance of a state. Each row lists alternatives for the same part.
const STATE_COVARIANCES: &[&[&str]] = &[
    &["attitude_deg", "attitude_covariance_deg2", "covariance_deg_deg_s"],
    &["angular_velocity_deg_s", "angular_velocity_covariance_deg2_s2", "covariance_deg_deg_s"],
];

tables! {
    /// Gains along the plan.
    pub(crate) static FEEDBACK[selector: Some("kind")] {
        /// neighbouring: the corrections of least cost that still reach the end. tvlqr: the
        /// regulator with the weights below, also for switching inputs. switching: for plans of
        /// arcs, the lengths of the arcs from another start, corrected once, and then that
        /// regulator. Default: neighbouring; tvlqr if time or fuel is the objective, and for
        /// wheels.
        "kind": Choice(&["neighbouring", "tvlqr", "switching"], &[]);
        /// Part of the steps at the end over which neighbouring gains are held, at least four
        /// steps; 0: none. Default: 0.15.
        "freeze": Number(q::PART);
        /// Time between two measurements, a whole number of steps; a correction is held over it,
        /// and gains are designed for this. Default: the step.
        "every_s": Number(q::DURATION);
        /// Weight of the attitude error per second, in the unit of the cost per rad². Default: an
        /// error of one radian costs as much as the torque that turns the body by one radian in
        /// the duration.
        "attitude_weight": Number(q::WHEEL_WEIGHT);
        /// Weight of the rate error per second, per (rad/s)². Default: the attitude weight at the
        /// scale of the duration.
        "rate_weight": Number(q::WHEEL_WEIGHT);
        /// Weight of the end, relative to the weight of the whole duration. Default: 1000.
        "end_weight": Number(q::WHEEL_WEIGHT);
    }

    /// The uncertainty of the craft: one standard deviation each, independent; one number for all
    /// three axes, or three.
    pub(crate) static UNCERTAINTY {
        /// Uncertainty of the state at the start.
        "start": Table(&UNCERTAIN_STATE);
        /// Uncertainty of the inertia.
        "inertia": Table(&UNCERTAIN_INERTIA);
        /// Misalignment of actuators and sensors relative to the body.
        "alignment": Table(&UNCERTAIN_ALIGNMENT);
        /// Errors of the actuators.
        "actuators": Table(&UNCERTAIN_ACTUATORS);
        /// Errors of the measurements.
        "sensor": Table(&UNCERTAIN_SENSOR);
        /// The joint chance that any of several limits is exceeded at any time of the motion,
        /// counted in flights; at least 1e-4.
        "chance": Number(q::CHANCE);
        /// The limits of the joint chance: names of constraints, and of limits as in reports,
        /// "torque limit". Default: all constraints that have no chance of their own.
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
        /// Covariance of both instead: six rows of six, attitude in deg, then angular velocity in
        /// deg/s.
        "covariance_deg_deg_s": Square(q::COVARIANCE);
    }

    static UNCERTAIN_INERTIA[exclusive: &[&["relative", "covariance_kg2_m4"], &["products_kg_m2", "covariance\
        _kg2_m4"]]] {
        /// Each moment about a body axis, relative to itself.
        "relative": Spread(q::SPREAD);
        /// Each product of inertia.
        "products_kg_m2": Number(q::SPREAD);
        /// Covariance of the six numbers instead: rows and columns in the order xx, yy, zz, xy, xz,
        /// yz.
        "covariance_kg2_m4": Square(q::COVARIANCE);
    }

    static UNCERTAIN_ALIGNMENT {
        /// All actuators together, about the body axes.
        "actuators_deg": Spread(q::SPREAD);
        /// The attitude sensor, about the body axes.
        "sensor_deg": Spread(q::SPREAD);
    }

    static UNCERTAIN_ACTUATORS[exclusive: &[&["noise_n_m_sqrt_s", "noise_intensity_n2_m2_s"]]] {
        /// Scale of each input, relative: one number for all, or one for each.
        "scale": Spread(q::SPREAD);
        /// A constant external torque, body axes.
        "constant_n_m": Spread(q::SPREAD);
        /// Noise of the torque: the square root of its intensity. Over a step of h seconds it
        /// changes the momentum by this times √h.
        "noise_n_m_sqrt_s": Spread(q::SPREAD);
        /// Intensity of that noise instead, three rows of three: its covariance over a step of h
        /// seconds is this over h.
        "noise_intensity_n2_m2_s": Square(q::COVARIANCE);
    }

    static UNCERTAIN_SENSOR[exclusive: STATE_COVARIANCES] {
        /// Noise of the attitude, independent at each step.
        "attitude_deg": Spread(q::SPREAD);
        /// Noise of the angular velocity, independent at each step.
        "angular_velocity_deg_s": Spread(q::SPREAD);
        /// Covariance of the attitude instead: three rows of three, deg².
        "attitude_covariance_deg2": Square(q::COVARIANCE);
        /// Covariance of the angular velocity instead, (deg/s)².
        "angular_velocity_covariance_deg2_s2": Square(q::COVARIANCE);
        /// Covariance of both instead: six rows of six, attitude in deg, then angular velocity in
        /// deg/s.
        "covariance_deg_deg_s": Square(q::COVARIANCE);
        /// Scale of the measured angular velocity about each axis, relative.
        "scale": Number(q::SPREAD);
        /// A constant error of the measured angular velocity.
        "bias_deg_s": Spread(q::SPREAD);
    }

    /// The response of the actuators to commands when a plan is flown. Default: immediate.
    pub(crate) static PLANT {
        /// Time constant of a lag of first order.
        "actuator_lag_s": Number(q::NOT_NEGATIVE_TIME);
        /// Time from a command to its effect.
        "delay_s": Number(q::NOT_NEGATIVE_TIME);
        /// The quantum of commands, in the unit of an input.
        "torque_quantum_n_m": Number(q::SPREAD);
        /// Time between two changes of the torque; the step must be a multiple of it. Default:
        /// the step.
        "tick_s": Number(q::DURATION);
        /// The capacity of the actuators, as a multiple of the limits that the plan keeps, at
        /// least 1. The part above 1 is reserved for the gains, which have no other room along
        /// plans of least time and fuel. Default: 1.
        "authority": Number(q::AUTHORITY);
        /// Whether the commands of the plan compensate lag and delay, which are known. Default:
        /// yes.
        "feedforward": Choice(&["leads", "as_planned"], &[]);
    }
}
