//! The conserved quantities of bodies under mutual gravity.
//!
//! ```text
//! E = Σ |γ_i|²/2m_i + ½ Π_i·J_i⁻¹Π_i + U      P = Σ γ_i      L = Σ x_i × γ_i + R_i Π_i
//! ```
//! Every potential that depends only on relative positions and attitudes conserves `P` and `L`; the
//! Lie group variational integrators conserve them to round-off. The true motion conserves `E`.

use super::Potential;
use crate::Vector3;
use crate::mechanics::body::Body;
use crate::mechanics::environment::Pose;

/// Linear and angular momentum of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momentum {
    /// Linear momentum `γ = m ẋ`, reference frame [kg·m/s].
    pub linear: Vector3,
    /// Angular momentum `Π = JΩ` about the mass centre, body axes [kg·m²/s].
    pub angular: Vector3,
}

/// Returns the kinetic energy `Σ |γ|²/2m + ½ Π·J⁻¹Π` \[J\]; only the rotational energy for a body
/// without mass.
pub fn kinetic_energy(bodies: &[Body], momenta: &[Momentum]) -> f64 {
    let of = |(body, momentum): (&Body, &Momentum)| {
        let translation = body.mass.map_or(0.0, |mass| momentum.linear.norm_squared() / mass);
        0.5 * (translation + momentum.angular.dot(&(body.inertia.j_inverse() * momentum.angular)))
    };
    bodies.iter().zip(momenta).map(of).sum()
}

/// Returns the total energy `E` \[J\].
pub fn energy(bodies: &[Body], potential: &dyn Potential, poses: &[Pose], momenta: &[Momentum]) -> f64 {
    kinetic_energy(bodies, momenta) + potential.energy(poses)
}

/// Returns the total linear momentum `P`, reference frame [kg·m/s].
pub fn linear_momentum(momenta: &[Momentum]) -> Vector3 {
    momenta.iter().map(|momentum| momentum.linear).sum()
}

/// Returns the total angular momentum `L` about the origin, reference frame [kg·m²/s].
pub fn angular_momentum(poses: &[Pose], momenta: &[Momentum]) -> Vector3 {
    let of = |(pose, momentum): (&Pose, &Momentum)| {
        pose.position.cross(&momentum.linear) + pose.attitude * momentum.angular
    };
    poses.iter().zip(momenta).map(of).sum()
}

/// Returns the mass centre `Σ m x / Σ m`, reference frame \[m\]. A body without mass does not
/// contribute.
pub fn mass_center(bodies: &[Body], poses: &[Pose]) -> Vector3 {
    let mass = |body: &Body| body.mass.unwrap_or(0.0);
    let total: f64 = bodies.iter().map(mass).sum();
    bodies.iter().zip(poses).map(|(body, pose)| mass(body) / total * pose.position).sum()
}
