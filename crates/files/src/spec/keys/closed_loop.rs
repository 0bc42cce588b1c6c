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
        /// neighbouring: the corrections with the lowest cost that still reach the end. tvlqr: a
        /// time-varying linear-quadratic regulator with the weights below, also for inputs that
        /// switch. switching: for plans that consist of arcs, one correction of the durations of
        /// the arcs for the actual start, and then the regulator. Default: neighbouring; tvlqr for
        /// wheels, and if time or fuel is the objective.
        "kind": Choice(&["neighbouring", "tvlqr", "switching"], &[]);
        /// Fraction of the steps, at the end of the plan, over which neighbouring gains are held
        /// constant, at least four steps; 0: none. Default: 0.15.
        "freeze": Number(q::PART);
        /// Time between two measurements, a whole number of steps. A correction is held over this
        /// time, and the gains are designed for it. Default: the step.
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
        /// The accepted probability that any of several limits is exceeded at any time of the
        /// motion, estimated from simulated flights; at least 1e-4.
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
        /// Instead of attitude_deg: the covariance of the attitude, three rows of three, deg².
        "attitude_covariance_deg2": Square(q::COVARIANCE);
        /// Instead of angular_velocity_deg_s: the covariance of the angular velocity, (deg/s)².
        "angular_velocity_covariance_deg2_s2": Square(q::COVARIANCE);
        /// Instead of both: their joint covariance, six rows of six, attitude in deg, then angular
        /// velocity in deg/s.
        "covariance_deg_deg_s": Square(q::COVARIANCE);
    }

    static UNCERTAIN_INERTIA[exclusive: &[&["relative", "covariance_kg2_m4"], &["products_kg_m2", "covariance\
        _kg2_m4"]]] {
        /// Each moment of inertia about a body axis, relative to its value.
        "relative": Spread(q::SPREAD);
        /// Each product of inertia.
        "products_kg_m2": Number(q::SPREAD);
        /// Instead of both: the covariance of the six numbers of the inertia, rows and columns in
        /// the order xx, yy, zz, xy, xz, yz.
        "covariance_kg2_m4": Square(q::COVARIANCE);
    }

    static UNCERTAIN_ALIGNMENT {
        /// Misalignment of all actuators together, about the body axes.
        "actuators_deg": Spread(q::SPREAD);
        /// Misalignment of the attitude sensor, about the body axes.
        "sensor_deg": Spread(q::SPREAD);
    }

    static UNCERTAIN_ACTUATORS[exclusive: &[&["noise_n_m_sqrt_s", "noise_intensity_n2_m2_s"]]] {
        /// Scale of each input, relative: one number for all, or one for each.
        "scale": Spread(q::SPREAD);
        /// A constant external torque, body axes.
        "constant_n_m": Spread(q::SPREAD);
        /// Noise of the torque: the square root of its intensity. Over a step of h seconds it
        /// changes the momentum by this number times √h.
        "noise_n_m_sqrt_s": Spread(q::SPREAD);
        /// Intensity of that noise instead, three rows of three: its covariance over a step of h
        /// seconds is this matrix divided by h.
        "noise_intensity_n2_m2_s": Square(q::COVARIANCE);
    }

    static UNCERTAIN_SENSOR[exclusive: STATE_COVARIANCES] {
        /// Noise of the attitude, independent at each step.
        "attitude_deg": Spread(q::SPREAD);
        /// Noise of the angular velocity, independent at each step.
        "angular_velocity_deg_s": Spread(q::SPREAD);
        /// Instead of attitude_deg: the covariance of the attitude, three rows of three, deg².
        "attitude_covariance_deg2": Square(q::COVARIANCE);
        /// Instead of angular_velocity_deg_s: the covariance of the angular velocity, (deg/s)².
        "angular_velocity_covariance_deg2_s2": Square(q::COVARIANCE);
        /// Instead of both: their joint covariance, six rows of six, attitude in deg, then angular
        /// velocity in deg/s.
        "covariance_deg_deg_s": Square(q::COVARIANCE);
        /// Scale of the measured angular velocity about each axis, relative.
        "scale": Number(q::SPREAD);
        /// A constant error of the measured angular velocity.
        "bias_deg_s": Spread(q::SPREAD);
    }

    /// The response of the actuators to commands when a plan is flown. Default: immediate.
    pub(crate) static PLANT {
        /// Time constant of a first-order lag.
        "actuator_lag_s": Number(q::NOT_NEGATIVE_TIME);
        /// Time from a command to its effect.
        "delay_s": Number(q::NOT_NEGATIVE_TIME);
        /// The quantum of commands, in the unit of an input.
        "torque_quantum_n_m": Number(q::SPREAD);
        /// Time between two changes of the torque; the step must be a multiple of it. Default:
        /// the step.
        "tick_s": Number(q::DURATION);
        /// The capacity of the actuators, as a multiple of the limits that the plan keeps, at least
        /// 1. The part above 1 is reserved for feedback corrections, which have no other reserve
        /// along minimum-time and minimum-fuel plans. Default: 1.
        "authority": Number(q::AUTHORITY);
        /// leads: the commands of the plan compensate the known lag and delay. as_planned: they do
        /// not. Default: leads.
        "feedforward": Choice(&["leads", "as_planned"], &[]);
    }
}
