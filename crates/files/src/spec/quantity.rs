//! Physical quantities, with the ranges of values that a spec may contain.
//!
//! The ranges are wide. They detect wrong exponents, and ensure that products in the solvers stay
//! within the range of double precision.

pub(crate) use slewkit::numerics::figures::{exact as show, short};

/// Signs that a quantity may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sign {
    /// Any sign; zero is allowed.
    Any,
    /// Zero or positive.
    NotNegative,
    /// Positive; zero is not allowed.
    Positive,
}

/// A physical quantity with its unit and its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quantity {
    /// Name of the quantity with its article, for messages.
    pub name: &'static str,
    /// Unit in files; empty for a dimensionless number.
    pub unit: &'static str,
    /// Smallest absolute value, except for zero.
    pub smallest: f64,
    /// Largest allowed absolute value.
    pub largest: f64,
    /// Signs that are allowed.
    pub sign: Sign,
}

const fn quantity(
    name: &'static str,
    unit: &'static str,
    smallest: f64,
    largest: f64,
    sign: Sign,
) -> Quantity {
    Quantity { name, unit, smallest, largest, sign }
}

// Elements of matrices and vectors may be tiny, because an element of 1e-17 next to 1 is a rounded
// zero, but the squares of the elements must not underflow.
const TINY: f64 = 1e-150;

pub(crate) const INERTIA: Quantity = quantity("an inertia", "kg·m²", 1e-60, 1e30, Sign::Any);
pub(crate) const SPICE_ID: Quantity = quantity("a NAIF number", "", 1.0, 2e6, Sign::Any);
pub(crate) const MASS: Quantity = quantity("a mass", "kg", 1e-30, 1e30, Sign::Positive);
pub(crate) const DURATION: Quantity = quantity("a time", "s", 1e-9, 1e12, Sign::Positive);
pub(crate) const DAYS: Quantity = quantity("a number of days", "d", 1e-9, 1e5, Sign::Positive);
pub(crate) const ELAPSED: Quantity = quantity("a time", "s", TINY, 1e12, Sign::Any);
pub(crate) const COMPONENT: Quantity = quantity("a vector component", "", TINY, 1e30, Sign::Any);
pub(crate) const ENTRY: Quantity = quantity("a matrix entry", "", TINY, 1e30, Sign::Any);
pub(crate) const WEIGHT: Quantity = quantity("a weight", "", TINY, 1e30, Sign::Any);
pub(crate) const ANGLE_RAD: Quantity = quantity("an angle", "rad", TINY, 1e6, Sign::Any);
pub(crate) const ANGLE_DEG: Quantity = quantity("an angle", "deg", TINY, 5e7, Sign::Any);
pub(crate) const RATE_RAD: Quantity = quantity("an angular velocity", "rad/s", TINY, 1e9, Sign::Any);
pub(crate) const RATE_DEG: Quantity = quantity("an angular velocity", "deg/s", TINY, 5e10, Sign::Any);
pub(crate) const ORBITAL_RATE: Quantity = quantity("an orbital rate", "rad/s", 1e-30, 1e9, Sign::Positive);
pub(crate) const POSITION: Quantity = quantity("a position", "m", TINY, 1e20, Sign::Any);
pub(crate) const LENGTH: Quantity = quantity("a length", "m", TINY, 1e20, Sign::Any);
pub(crate) const VELOCITY: Quantity = quantity("a velocity", "m/s", TINY, 1e12, Sign::Any);
pub(crate) const GRAVITY: Quantity = quantity("a gravity", "m/s²", TINY, 1e12, Sign::NotNegative);
pub(crate) const GRAVITATIONAL_PARAMETER: Quantity =
    quantity("a gravitational parameter", "m³/s²", 1e-30, 1e30, Sign::Positive);
pub(crate) const TOLERANCE: Quantity = quantity("a tolerance", "", TINY, 1e30, Sign::Any);
pub(crate) const TOLERANCE_DEG: Quantity = quantity("a tolerance", "deg", 1e-15, 360.0, Sign::Positive);
pub(crate) const COST: Quantity = quantity("a cost", "", TINY, 1e200, Sign::NotNegative);
pub(crate) const TORQUE: Quantity = quantity("a torque limit", "N·m", 1e-30, 1e30, Sign::Positive);
pub(crate) const TORQUE_RATE: Quantity =
    quantity("a limit of the torque rate", "N·m/s", 1e-30, 1e30, Sign::Positive);
pub(crate) const TORQUE_NORM: Quantity =
    quantity("a limit of the torque norm", "N·m", 1e-30, 1e30, Sign::Positive);
pub(crate) const FORCE_NORM: Quantity =
    quantity("a limit of the force norm", "N", 1e-30, 1e30, Sign::Positive);
pub(crate) const FORCE: Quantity = quantity("a force limit", "N", 1e-30, 1e30, Sign::Positive);
pub(crate) const FORCE_RATE: Quantity =
    quantity("a limit of the force rate", "N/s", 1e-30, 1e30, Sign::Positive);
pub(crate) const WHEEL_LIMIT: Quantity = quantity("a momentum limit", "N·m·s", 1e-30, 1e30, Sign::Positive);
pub(crate) const WHEEL_MOMENTUM: Quantity = quantity("a wheel momentum", "N·m·s", TINY, 1e30, Sign::Any);
pub(crate) const PRICE: Quantity = quantity("a price", "", 1e-30, 1e30, Sign::Positive);
pub(crate) const WHEEL_WEIGHT: Quantity = quantity("a weight", "", 1e-30, 1e30, Sign::Positive);
pub(crate) const RATE_LIMIT_RAD: Quantity = quantity("a rate limit", "rad/s", 1e-30, 1e9, Sign::Positive);
pub(crate) const RATE_LIMIT_DEG: Quantity = quantity("a rate limit", "deg/s", 1e-30, 5e10, Sign::Positive);
pub(crate) const SIZE: Quantity = quantity("a length", "m", 1e-30, 1e20, Sign::Positive);
pub(crate) const DENSITY: Quantity = quantity("a density", "kg/m³", 1e-30, 1e30, Sign::Positive);
pub(crate) const GRAVITATIONAL_CONSTANT: Quantity =
    quantity("a constant of gravitation", "m³/(kg·s²)", 1e-30, 1e30, Sign::Positive);
pub(crate) const MOMENTUM: Quantity = quantity("a momentum", "", TINY, 1e60, Sign::Any);
pub(crate) const STEP_TOLERANCE: Quantity =
    quantity("a tolerance of steps (below 1e-14 there is only round-off)", "", 1e-14, 0.1, Sign::Positive);
pub(crate) const SIGNED: Quantity = quantity("a value", "", TINY, 1e200, Sign::Any);
pub(crate) const MARGIN_DEG: Quantity = quantity("a margin", "deg", TINY, 360.0, Sign::NotNegative);
pub(crate) const MARGIN_RAD: Quantity = quantity("a margin", "rad", TINY, 6.3, Sign::NotNegative);
pub(crate) const TOLERANCE_RAD: Quantity = quantity("a tolerance", "rad", 1e-18, 6.3, Sign::Positive);
pub(crate) const MARGIN: Quantity = quantity("a margin", "", TINY, 1e200, Sign::Any);
pub(crate) const SPREAD: Quantity = quantity("a spread", "", TINY, 1e30, Sign::NotNegative);
pub(crate) const PART: Quantity = quantity("a part", "", TINY, 1.0, Sign::NotNegative);
pub(crate) const AUTHORITY: Quantity = quantity("a multiple of limits", "", 1.0, 1e6, Sign::Positive);
pub(crate) const CHANCE: Quantity = quantity("a chance", "", 1e-12, 0.499, Sign::Positive);
pub(crate) const NOT_NEGATIVE_TIME: Quantity = quantity("a time", "s", TINY, 1e12, Sign::NotNegative);
pub(crate) const COVARIANCE: Quantity = quantity("a covariance", "", TINY, 1e60, Sign::Any);
pub(crate) const SEMI_AXIS: Quantity = quantity("a semi-axis", "", TINY, 1e30, Sign::Any);
