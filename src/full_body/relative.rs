//! Two bodies in the axes of one of them.

use crate::environment::Pose;

/// The pose of `body` in the axes of `observer`: `Rᵀ(x_b − x_o)` and `R_oᵀ R_b`.
pub(super) fn seen_from(observer: &Pose, body: &Pose) -> Pose {
    Pose {
        position: observer.attitude.tr_mul(&(body.position - observer.position)),
        attitude: observer.attitude.tr_mul(&body.attitude),
    }
}
