//! The reduced equations of the full two-body problem: two bodies in the axes of the second body.
//!
//! The potential depends on `X = R₂ᵀ(x₁ − x₂)` and `R = R₂ᵀR₁` alone. With `m = m₁m₂/(m₁ + m₂)` and
//! everything in the axes of body 2,
//! ```text
//! Γ = m R₂ᵀ(ẋ₁ − ẋ₂)     Π = R Π₁     Π₂        Ω = R J₁⁻¹ Rᵀ Π     Ω₂ = J₂⁻¹ Π₂
//! Ẋ = Γ/m + X × Ω₂            Γ̇ = Γ × Ω₂ + f         f = −∂U/∂X
//! Ṙ = S(Ω − Ω₂) R             Π̇ = Π × Ω₂ + M         M the moment on body 1
//!                             Π̇₂ = Π₂ × Ω₂ − M − X × f
//! ```
//! (Maciejewski 1995; Lee, Leok and McClamroch 2007.) These equations have nine momenta and six
//! coordinates instead of twelve and twelve. The other unknowns are the mass centre, which moves
//! uniformly, and the attitude of body 2, `Ṙ₂ = R₂ S(Ω₂)`. In the frame of the mass centre
//! ```text
//! E = |Γ|²/2m + ½ Ω·Π + ½ Ω₂·Π₂ + U(X, R)         R₂ (X × Γ + Π + Π₂) = L
//! ```
//! are conserved.

use super::Potential;
use super::error::{Checked, FullBodyError};
use super::invariants::Momentum;
use crate::mechanics::body::Body;
use crate::mechanics::environment::{Pose, Wrench};
use crate::mechanics::number::positive;
use crate::{Matrix3, Vector3};

/// Returns the pose of `body` in the axes of `observer`: `R_oᵀ(x_b − x_o)` and `R_oᵀR_b`.
pub(super) fn seen_from(observer: &Pose, body: &Pose) -> Pose {
    Pose {
        position: observer.attitude.tr_mul(&(body.position - observer.position)),
        attitude: observer.attitude.tr_mul(&body.attitude),
    }
}

/// The relative state of two bodies, in the axes of the second body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relative {
    /// The position `X` of the mass centre of body 1 relative to the mass centre of body 2 \[m\].
    pub position: Vector3,
    /// Attitude `R`, axes of body 1 → axes of body 2.
    pub attitude: Matrix3,
    /// Reduced mass times relative velocity, `Γ` [kg·m/s].
    pub momentum: Vector3,
    /// Angular momentum `Π = RΠ₁` of body 1 about its mass centre [kg·m²/s].
    pub first: Vector3,
    /// Angular momentum `Π₂` of body 2 about its mass centre [kg·m²/s].
    pub second: Vector3,
}

/// The part of the state of two bodies that [`Relative`] does not contain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Attitude `R₂` of body 2, body → reference.
    pub attitude: Matrix3,
    /// The common mass centre of both bodies, reference frame \[m\].
    pub mass_center: Vector3,
    /// The total linear momentum of both bodies, reference frame [kg·m/s].
    pub momentum: Vector3,
}

/// Time derivative of a [`Relative`] state, and the angular velocity of the axes of body 2, in
/// which it is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeRate {
    /// Rate of the position, `Ẋ` [m/s].
    pub position: Vector3,
    /// Relative angular velocity `Ω − Ω₂` [rad/s], with `Ṙ = S(Ω − Ω₂) R`.
    pub attitude: Vector3,
    /// Rate of the linear momentum, `Γ̇` \[N\].
    pub momentum: Vector3,
    /// Rate of the angular momentum of body 1, `Π̇` [N·m].
    pub first: Vector3,
    /// Rate of the angular momentum of body 2, `Π̇₂` [N·m].
    pub second: Vector3,
    /// Angular velocity `Ω₂` of body 2 [rad/s], with `Ṙ₂ = R₂ S(Ω₂)`.
    pub axes: Vector3,
}

/// Two bodies and their mutual potential, in relative coordinates.
#[derive(Clone, Debug)]
pub struct TwoBodies<P> {
    bodies: [Body; 2],
    masses: [f64; 2],
    potential: P,
}

impl<P: Potential> TwoBodies<P> {
    /// Builds the system of two bodies under `potential`, which must be a potential of two bodies.
    ///
    /// # Errors
    /// Returns a [`FullBodyError`] if the mass of a body is absent or not a positive number.
    pub fn new(bodies: [Body; 2], potential: P) -> Checked<Self> {
        let mass = |body: &Body| -> Checked<f64> {
            let mass = body.mass.ok_or(FullBodyError::NoMass)?;
            Ok(positive("mass of a body", mass)?)
        };
        let masses = [mass(&bodies[0])?, mass(&bodies[1])?];
        Ok(Self { bodies, masses, potential })
    }

    /// Returns the reduced mass `m₁m₂/(m₁ + m₂)` \[kg\].
    pub fn reduced_mass(&self) -> f64 {
        let [first, second] = self.masses;
        first / (first + second) * second
    }

    /// Returns the relative state of two bodies, and the data that the inverse conversion needs.
    pub fn reduce(&self, poses: &[Pose; 2], momenta: &[Momentum; 2]) -> (Relative, Anchor) {
        let [m1, m2] = self.masses;
        let turn = poses[1].attitude;
        let seen = seen_from(&poses[1], &poses[0]);
        let velocity = momenta[0].linear / m1 - momenta[1].linear / m2;
        let relative = Relative {
            position: seen.position,
            attitude: seen.attitude,
            momentum: self.reduced_mass() * turn.tr_mul(&velocity),
            first: seen.attitude * momenta[0].angular,
            second: momenta[1].angular,
        };
        let share = m1 / (m1 + m2);
        let anchor = Anchor {
            attitude: turn,
            mass_center: share * poses[0].position + (1.0 - share) * poses[1].position,
            momentum: momenta[0].linear + momenta[1].linear,
        };
        (relative, anchor)
    }

    /// Returns the poses and momenta of both bodies, the inverse of [`TwoBodies::reduce`].
    pub fn restore(&self, relative: &Relative, anchor: &Anchor) -> ([Pose; 2], [Momentum; 2]) {
        let [m1, m2] = self.masses;
        let (first, second) = (m1 / (m1 + m2), m2 / (m1 + m2));
        let turn = &anchor.attitude;
        let (offset, momentum) = (turn * relative.position, turn * relative.momentum);
        let poses = [
            Pose { position: anchor.mass_center + second * offset, attitude: turn * relative.attitude },
            Pose { position: anchor.mass_center - first * offset, attitude: *turn },
        ];
        let momenta = [
            Momentum {
                linear: first * anchor.momentum + momentum,
                angular: relative.attitude.tr_mul(&relative.first),
            },
            Momentum { linear: second * anchor.momentum - momentum, angular: relative.second },
        ];
        (poses, momenta)
    }

    /// Returns the reduced potential `U(X, R)` \[J\].
    pub fn potential(&self, position: &Vector3, attitude: &Matrix3) -> f64 {
        self.potential.energy(&placed(position, attitude))
    }

    /// Returns the force `f = −∂U/∂X` \[N\] and moment `M` [N·m] on body 1, both in the axes of
    /// body 2.
    pub fn wrench(&self, position: &Vector3, attitude: &Matrix3) -> Wrench {
        let mut wrenches = [Wrench::zero(); 2];
        self.potential.wrenches(&placed(position, attitude), &mut wrenches);
        Wrench { force: wrenches[0].force, moment: attitude * wrenches[0].moment }
    }

    /// Returns the right-hand side of the reduced equations.
    pub fn rate(&self, state: &Relative) -> RelativeRate {
        let Wrench { force, moment } = self.wrench(&state.position, &state.attitude);
        let [omega, axes] = self.angular_velocities(state);
        RelativeRate {
            position: state.momentum / self.reduced_mass() + state.position.cross(&axes),
            attitude: omega - axes,
            momentum: state.momentum.cross(&axes) + force,
            first: state.first.cross(&axes) + moment,
            second: state.second.cross(&axes) - moment - state.position.cross(&force),
            axes,
        }
    }

    /// Returns the energy in the frame of the mass centre \[J\].
    pub fn energy(&self, state: &Relative) -> f64 {
        let [omega, axes] = self.angular_velocities(state);
        let kinetic = state.momentum.norm_squared() / self.reduced_mass()
            + omega.dot(&state.first)
            + axes.dot(&state.second);
        0.5 * kinetic + self.potential(&state.position, &state.attitude)
    }

    /// Returns the total angular momentum about the mass centre, in the axes of body 2 [kg·m²/s].
    /// Its direction is constant only in the reference frame; its length is constant in both.
    pub fn angular_momentum(&self, state: &Relative) -> Vector3 {
        state.position.cross(&state.momentum) + state.first + state.second
    }

    /// Returns the angular velocities `Ω` and `Ω₂`, in the axes of body 2.
    fn angular_velocities(&self, state: &Relative) -> [Vector3; 2] {
        let first = self.bodies[0].inertia.j_inverse() * state.attitude.tr_mul(&state.first);
        [state.attitude * first, self.bodies[1].inertia.j_inverse() * state.second]
    }
}

/// Returns poses with body 2 at the origin, and its axes along the reference frame.
fn placed(position: &Vector3, attitude: &Matrix3) -> [Pose; 2] {
    [
        Pose { position: *position, attitude: *attitude },
        Pose { position: Vector3::zeros(), attitude: Matrix3::identity() },
    ]
}
