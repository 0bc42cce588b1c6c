//! The rotation group SO(3): exponential, logarithm, their Jacobians, Cayley map and quaternions,
//! and the type [`Rotation`].
//!
//! With `t = |f|` every map of a rotation vector in this module is `I + a S(f) + b S(f)²`:
//!
//! | map | a | b |
//! |---|---|---|
//! | `exp S(f)` | `sin t/t` | `(1 − cos t)/t²` |
//! | `J_r(f)` | `−(1 − cos t)/t²` | `(t − sin t)/t³` |
//! | `J_r⁻¹(f)` | `½` | `(1 − (t/2) cot(t/2))/t²` |
//! | `cay(f)` | `2/(1 + t²)` | `2/(1 + t²)` |
//!
//! `J_l(f) = J_r(−f) = J_r(f)ᵀ`. SE(3) needs no further maps: positions are varied in the reference
//! frame.
//!
//! All maps are accurate to a few ulps, relative to the largest element that is not constant, for
//! `|f|` from the smallest normal numbers to π. Arguments that are not finite, or whose square
//! overflows, give NaN.

mod cayley;
#[doc(hidden)]
pub mod interpolation;
mod kernels;
mod quaternion;
mod rotation;
mod skew;
mod so3;

pub use rotation::minus;
pub use skew::hat;
pub use so3::{exp, log};

#[doc(hidden)]
pub use cayley::{cayley, cayley_inverse, cayley_minus_identity};
pub(crate) use kernels::Second;
pub(crate) use quaternion::continued;
#[doc(hidden)]
pub use quaternion::{project_to_rotation, quaternion_from_rotation, rotation_from_quaternion};
pub(crate) use rotation::orthogonality;
#[doc(hidden)]
pub use rotation::{NotARotation, Rotation};
pub(crate) use skew::skew_polynomial;
#[doc(hidden)]
pub use skew::vee;
#[doc(hidden)]
pub use so3::{
    exp_minus_identity, left_jacobian, left_jacobian_inverse, left_jacobian_inverse_directional,
    right_jacobian, right_jacobian_directional, right_jacobian_inverse,
};
