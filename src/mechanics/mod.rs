//! Bodies, the force fields that act on them, and their actuators.

pub mod actuators;
pub mod body;
pub mod direction;
pub(crate) mod drift_equation;
pub mod environment;
pub mod full_body;
pub mod number;

pub use actuators::{
    Actuation, ActuatorSet, ActuatorSetError, AxisFrame, InputLimit, LimitKind, Limits, Thrusters, Wheels,
};
pub use body::{Body, Inertia, InertiaError};
pub use environment::{
    CentralGravity, Description, Environment, EnvironmentError, Free, GravityGradient, PointMass,
    SecondOrderGravity, Symmetry, UniformGravity,
};
