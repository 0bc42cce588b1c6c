//! MacCullagh's formula for two extended bodies: mutual gravity to second order in size over
//! distance.
//!
//! In the axes of body A, with B at `X = r e`, inertias `J_A`, `J_B` and `K = m_B J_A + m_A J_B`:
//! ```text
//! U = −G m_A m_B/r − (G/2r³) (tr K − 3 e·Ke)
//! f_B = −G m_A m_B e/r² − (3G/2r⁴) [(tr K − 5 e·Ke) e + 2 Ke]      f_A = −f_B
//! M_A = (3G m_B/r³) e × J_A e      M_B = (3G m_A/r³) e × J_B e
//! ```
//! These satisfy `M_A + M_B + X × f_B = 0`. The approximation omits the third moments, which vanish
//! for bodies symmetric under `ρ → −ρ`, and the product of the two second moments. The relative
//! error is O((l/r)³) in the force and O(l/r) in the moment; for such symmetric bodies it is one
//! order smaller.

use crate::mechanics::environment::Pose;
use crate::{Matrix3, Vector3};

/// The force on the second body of a pair and the moments on both bodies, in the axes of the first
/// body, divided by `G`. Unless the pair is of second order, the first body has the field, and the
/// second the probes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exchange {
    pub force: Vector3,
    pub field_moment: Vector3,
    pub probe_moment: Vector3,
}

impl Exchange {
    pub const ZERO: Self = Self {
        force: Vector3::new(0.0, 0.0, 0.0),
        field_moment: Vector3::new(0.0, 0.0, 0.0),
        probe_moment: Vector3::new(0.0, 0.0, 0.0),
    };
}

/// The mass and the inertia of a body, which determine its gravity to second order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moments {
    /// Mass \[kg\].
    pub mass: f64,
    /// Inertia about the mass centre [kg·m²], body axes.
    pub inertia: Matrix3,
}

/// The quantities of a pair of bodies, in the axes of the first body.
struct Pair {
    r: f64,
    e: Vector3,
    masses: (f64, f64),
    /// The vectors `J_A e` and `J_B e`.
    je: (Vector3, Vector3),
    /// The trace `tr K`.
    trace: f64,
}

impl Pair {
    /// Builds the terms of a pair; `seen` is the pose of the second body relative to the first.
    fn new(first: &Moments, second: &Moments, seen: &Pose) -> Self {
        let r = seen.position.norm();
        let e = seen.position / r;
        let q = &seen.attitude;
        let trace = second.mass * first.inertia.trace() + first.mass * second.inertia.trace();
        let je = (first.inertia * e, q * (second.inertia * q.tr_mul(&e)));
        Self { r, e, masses: (first.mass, second.mass), je, trace }
    }

    /// Returns the vector `Ke`.
    fn ke(&self) -> Vector3 {
        self.masses.1 * self.je.0 + self.masses.0 * self.je.1
    }
}

/// Returns the potential energy divided by the gravitational constant, `U/G`.
pub(super) fn energy(first: &Moments, second: &Moments, seen: &Pose) -> f64 {
    let pair = Pair::new(first, second, seen);
    let eke = pair.e.dot(&pair.ke());
    -first.mass * second.mass / pair.r - (pair.trace - 3.0 * eke) / (2.0 * pair.r.powi(3))
}

/// Returns the force and the moments, divided by `G`.
pub(super) fn exchange(first: &Moments, second: &Moments, seen: &Pose) -> Exchange {
    let pair = Pair::new(first, second, seen);
    let Pair { r, ref e, ref je, .. } = pair;
    let ke = pair.ke();
    let quadrupole = 1.5 / r.powi(4) * ((pair.trace - 5.0 * e.dot(&ke)) * e + 2.0 * ke);
    Exchange {
        force: -first.mass * second.mass / (r * r) * e - quadrupole,
        field_moment: 3.0 * second.mass / r.powi(3) * e.cross(&je.0),
        probe_moment: 3.0 * first.mass / r.powi(3) * e.cross(&je.1),
    }
}
