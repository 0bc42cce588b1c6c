//! The gravity of a pair of bodies: one body is the field, and the other a set of probes in the
//! field.
//!
//! With φ the potential of the field per unit of mass and `y_q = X + Q ρ_q` the probes `(m_q, ρ_q)`
//! in the axes of the field,
//! ```text
//! U = Σ_q m_q φ(y_q)        g_q = −m_q ∇φ(y_q)
//! f = Σ_q g_q on the probes, −f on the field
//! M_probes = Σ_q Qρ_q × g_q      M_field = −Σ_q y_q × g_q      so that M_field + M_probes + X × f = 0
//! ```
//! Force and moments derive from the one energy `U(X, Q)`. For any approximation of it, total force
//! and total moment therefore vanish to round-off, and an integrator that conserves momenta and
//! energy for a potential also conserves them here. Everything in this module is for `G = 1`.

use super::lanes::{LANES, Lanes};
use super::polyhedron::side_by_side;
use super::relative::seen_from;
use super::second_order::{self, Exchange, Moments};
use super::{Attractor, HomogeneousPolyhedron, MassPoint, PointCloud};
use crate::Vector3;
use crate::mechanics::environment::Pose;
use std::ops::Range;

/// A part of the computation of one pair: a range of probes in the field.
#[derive(Clone, Debug)]
pub(super) struct Task {
    /// The index of the body whose field acts.
    pub field: usize,
    /// The index of the body with the probes.
    pub probe: usize,
    /// The range of the probes; empty for a pair of second order.
    range: Range<usize>,
}

/// Point-to-point interactions in one task, about 50 µs. This is long compared with the handover to
/// a thread, and short compared with an evaluation for which threads save time.
pub(super) const TASK: usize = 1 << 14;
/// The cost of a face that acts on a point, in point-to-point interactions.
const FACE: usize = 8;
/// The cost of the rotation of a probe into the axes of the field, in point-to-point interactions.
const TURN: usize = 4;
/// The cost of a pair of second order, in point-to-point interactions.
const SECOND_ORDER: usize = 8;

/// Returns the points of a body on which the field of another body acts; empty for a body of second
/// order.
fn probes(body: &Attractor) -> &[MassPoint] {
    match body {
        Attractor::Cloud(cloud) => cloud.points(),
        Attractor::Polyhedron(solid) => solid.cubature().points(),
        Attractor::SecondOrder { .. } => &[],
    }
}

/// Returns the indices of the field body and of the probe body of a pair, and the cost of the field
/// on one probe; `None` for a pair of second order.
fn roles(bodies: &[Attractor], first: usize, second: usize) -> Option<(usize, usize, usize)> {
    use Attractor::{Cloud, Polyhedron, SecondOrder};
    let first_is_field = match (&bodies[first], &bodies[second]) {
        (SecondOrder { .. }, _) | (_, SecondOrder { .. }) => return None,
        // The inner loop runs over the cloud with more points.
        (Cloud(a), Cloud(b)) => a.points().len() >= b.points().len(),
        // The exact field of the polyhedron acts on the points.
        (Polyhedron(_), Cloud(_)) => true,
        (Cloud(_), Polyhedron(_)) => false,
        // The Gauss points are in the smaller body, which has the smaller tetrahedra.
        (Polyhedron(a), Polyhedron(b)) => a.shape().radius() >= b.shape().radius(),
    };
    let (field, probe) = if first_is_field { (first, second) } else { (second, first) };
    let cost = match &bodies[field] {
        Polyhedron(solid) => FACE * solid.shape().faces().len(),
        body => probes(body).len(),
    };
    Some((field, probe, cost + TURN))
}

impl Task {
    /// Returns the cost of a pair, in point-to-point interactions.
    pub fn cost(bodies: &[Attractor], first: usize, second: usize) -> f64 {
        match roles(bodies, first, second) {
            Some((_, probe, cost)) => cost as f64 * probes(&bodies[probe]).len() as f64,
            None => SECOND_ORDER as f64,
        }
    }

    /// Splits a pair into tasks.
    pub fn split(bodies: &[Attractor], first: usize, second: usize, tasks: &mut Vec<Self>) {
        let Some((field, probe, cost)) = roles(bodies, first, second) else {
            return tasks.push(Self { field: first, probe: second, range: 0..0 });
        };
        let count = probes(&bodies[probe]).len();
        let step = (TASK / cost).next_multiple_of(LANES).max(LANES);
        let starts = (0..count).step_by(step);
        tasks.extend(starts.map(|start| Self { field, probe, range: start..(start + step).min(count) }));
    }

    /// Returns the force and the moments of the task, divided by `G`.
    pub fn exchange(&self, bodies: &[Attractor], moments: &[Moments], poses: &[Pose]) -> Exchange {
        let seen = seen_from(&poses[self.field], &poses[self.probe]);
        let probes = || &probes(&bodies[self.probe])[self.range.clone()];
        match &bodies[self.field] {
            _ if self.is_second_order() => {
                second_order::exchange(&moments[self.field], &moments[self.probe], &seen)
            }
            Attractor::Cloud(cloud) => cloud_exchange(cloud, probes(), &seen),
            Attractor::Polyhedron(solid) => solid_exchange(solid, probes(), &seen),
            Attractor::SecondOrder { .. } => Exchange::ZERO,
        }
    }

    /// Returns the energy of the task, divided by `G`.
    pub fn energy(&self, bodies: &[Attractor], moments: &[Moments], poses: &[Pose]) -> f64 {
        let seen = seen_from(&poses[self.field], &poses[self.probe]);
        let probes = || &probes(&bodies[self.probe])[self.range.clone()];
        match &bodies[self.field] {
            _ if self.is_second_order() => {
                second_order::energy(&moments[self.field], &moments[self.probe], &seen)
            }
            Attractor::Cloud(cloud) => cloud_energy(cloud, probes(), &seen),
            Attractor::Polyhedron(solid) => solid_energy(solid, probes(), &seen),
            Attractor::SecondOrder { .. } => 0.0,
        }
    }

    /// Returns whether the pair is of second order. It has no probes: the mass and inertia of each
    /// body act on the mass and inertia of the other.
    fn is_second_order(&self) -> bool {
        self.range.is_empty()
    }
}

fn cloud_energy(field: &PointCloud, probes: &[MassPoint], seen: &Pose) -> f64 {
    let of = |probe: &MassPoint| {
        probe.mass * field.inverse_distances(&(seen.position + seen.attitude * probe.position))
    };
    -probes.iter().map(of).sum::<f64>()
}

fn cloud_exchange(field: &PointCloud, probes: &[MassPoint], seen: &Pose) -> Exchange {
    let mut sum = Exchange::ZERO;
    for probe in probes {
        let arm = seen.attitude * probe.position;
        let y = seen.position + arm;
        let (s, v) = field.pull(&y);
        let g = probe.mass * (v - s * y);
        sum.force += g;
        sum.field_moment += probe.mass * v.cross(&y);
        sum.probe_moment += arm.cross(&g);
    }
    sum
}

/// Returns the masses of up to four probes, and their arms and positions in the axes of the field.
fn four(probes: &[MassPoint], seen: &Pose) -> (Lanes, [Lanes; 3], [Lanes; 3]) {
    let mass = Lanes::from_fn(|lane| probes.get(lane).map_or(0.0, |probe| probe.mass));
    // Lanes without a probe have no mass and the position of the first probe.
    let of = |lane: usize| seen.attitude * probes.get(lane).unwrap_or(&probes[0]).position;
    let arms = side_by_side(&std::array::from_fn(of));
    let y = [0, 1, 2].map(|axis| arms[axis] + Lanes::splat(seen.position[axis]));
    (mass, arms, y)
}

fn solid_energy(field: &HomogeneousPolyhedron, probes: &[MassPoint], seen: &Pose) -> f64 {
    let mut sum = Lanes::ZERO;
    for probes in probes.chunks(LANES) {
        let (mass, _, y) = four(probes, seen);
        sum += mass * field.field().at(&y).potential;
    }
    -field.density() * sum.sum()
}

fn solid_exchange(field: &HomogeneousPolyhedron, probes: &[MassPoint], seen: &Pose) -> Exchange {
    let (mut force, mut field_moment, mut probe_moment) =
        ([Lanes::ZERO; 3], [Lanes::ZERO; 3], [Lanes::ZERO; 3]);
    for probes in probes.chunks(LANES) {
        let (mass, arms, y) = four(probes, seen);
        let g = field.field().at(&y).gradient.map(|gradient| mass * gradient);
        add(&mut force, &g);
        add(&mut field_moment, &cross(&g, &y));
        add(&mut probe_moment, &cross(&arms, &g));
    }
    let total = |lanes: [Lanes; 3]| field.density() * Vector3::from(lanes.map(Lanes::sum));
    Exchange { force: total(force), field_moment: total(field_moment), probe_moment: total(probe_moment) }
}

fn add(sum: &mut [Lanes; 3], term: &[Lanes; 3]) {
    for (sum, term) in sum.iter_mut().zip(term) {
        *sum += *term;
    }
}

fn cross(a: &[Lanes; 3], b: &[Lanes; 3]) -> [Lanes; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
