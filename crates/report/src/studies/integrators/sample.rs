//! Errors of one state relative to the initial state.

use slewkit::Vector3;
use slewkit::mechanics::full_body::invariants;
use slewkit::propagate::integrator::{Invariants, System, SystemState};

/// Reference values by which errors are divided.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    pub start: Invariants,
    /// Reference value of energy errors, `T₀ + |U₀|` \[J\].
    pub energy: f64,
    linear: f64,
    angular: f64,
}

/// Errors of one state relative to the initial state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub energy: f64,
    pub energy_error: f64,
    pub orthogonality: f64,
    pub linear: f64,
    pub angular: f64,
}

impl Scales {
    pub fn of(system: &System, start: &SystemState) -> Self {
        let (poses, momenta) = (start.poses(), start.momenta());
        let each = || poses.iter().zip(momenta);
        let linear: f64 = momenta.iter().map(|momentum| momentum.linear.norm()).sum();
        let angular: f64 =
            each().map(|(pose, p)| (pose.position.cross(&p.linear) + pose.attitude * p.angular).norm()).sum();
        let potential = system.potential().map_or(0.0, |potential| potential.energy(poses));
        let energy = invariants::kinetic_energy(system.bodies(), momenta) + potential.abs();
        // If a reference value is zero, errors are not divided by it.
        let scale = |size: f64| if size > 0.0 { size } else { 1.0 };
        Self {
            start: system.invariants(start),
            energy: scale(energy),
            linear: scale(linear),
            angular: scale(angular),
        }
    }

    pub fn sample(&self, now: &Invariants) -> Sample {
        let change = |now: &Vector3, before: &Vector3| (now - before).norm();
        let energy = (now.energy - self.start.energy) / self.energy;
        Sample {
            energy,
            energy_error: energy.abs(),
            orthogonality: now.orthogonality,
            linear: change(&now.linear_momentum, &self.start.linear_momentum) / self.linear,
            angular: change(&now.angular_momentum, &self.start.angular_momentum) / self.angular,
        }
    }
}
