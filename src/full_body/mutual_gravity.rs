//! The mutual gravity of n bodies of any kind, summed over their pairs.
//!
//! Of every pair one body is the *field*, and the other is a set of *probes*: point masses `(m_q, ρ_q)` in
//! that field. With φ the potential of the field per unit of mass and `y_q = X + Q ρ_q` the probes in the
//! axes of the field,
//! ```text
//! U = Σ_q m_q φ(y_q)        g_q = −m_q ∇φ(y_q)
//! f = Σ_q g_q on the probes, −f on the field
//! M_probes = Σ_q Qρ_q × g_q      M_field = −Σ_q y_q × g_q      so that M_field + M_probes + X × f = 0
//! ```
//! Force and moments derive from this one `U(X, Q)`: whatever it approximates, total force and total moment
//! vanish to round-off, and an integrator that conserves momenta and energy for a potential does so here.
//!
//! Pairs are cut into tasks of fixed size, and the results of the tasks are added in a fixed order: the
//! result has the same bits whether one thread evaluates the tasks or many.

use super::error::{Checked, count, finite, positive};
use super::relative::seen_from;
use super::second_order::{self, Moments};
use super::{MassPoint, PointCloud, Potential};
use crate::body::{Body, Inertia, InertiaError};
use crate::environment::{Pose, Wrench};
use crate::{Matrix3, Vector3};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Mutex;

/// Newtonian constant of gravitation, CODATA 2018 and 2022 [m³/(kg·s²)].
pub const GRAVITATIONAL_CONSTANT: f64 = 6.674_30e-11;

/// How a body attracts.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Attractor {
    /// Point masses: exact among clouds, all pairs of points.
    Cloud(PointCloud),
    /// Mass and inertia alone, MacCullagh's formula: second order in size over distance in all its pairs.
    SecondOrder {
        /// Mass \[kg\].
        mass: f64,
        /// Inertia about the mass center, body axes.
        inertia: Inertia,
    },
}

impl Attractor {
    /// A sphere, or a point mass \[kg\].
    ///
    /// # Errors
    /// A [`FullBodyError`](super::FullBodyError) if the mass is not a positive number.
    pub fn point(mass: f64) -> Checked<Self> {
        Ok(Self::Cloud(PointCloud::new(vec![MassPoint { mass, position: Vector3::zeros() }])?))
    }

    /// Mass \[kg\].
    pub fn mass(&self) -> f64 {
        match self {
            Self::Cloud(cloud) => cloud.mass(),
            Self::SecondOrder { mass, .. } => *mass,
        }
    }

    /// Inertia about the mass center [kg·m²], 3×3, body axes. Singular for points on a line.
    pub fn inertia(&self) -> Matrix3 {
        match self {
            Self::Cloud(cloud) => cloud.inertia(),
            Self::SecondOrder { inertia, .. } => *inertia.j(),
        }
    }

    /// The rigid body for the integrators.
    ///
    /// # Errors
    /// An [`InertiaError`] if the inertia is singular: points on a line, or a single one.
    pub fn body(&self) -> Result<Body, InertiaError> {
        Ok(Body { inertia: Inertia::new(self.inertia())?, mass: Some(self.mass()) })
    }

    /// Whether its pairs are of second order.
    fn is_second_order(&self) -> bool {
        matches!(self, Self::SecondOrder { .. })
    }
}

/// Whether to share the tasks among threads. The result is the same to the last bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Threads {
    /// Where one evaluation is long enough to pay for it. Default.
    #[default]
    Auto,
    /// On the calling thread; allocates nothing.
    One,
    /// On the threads of rayon, also where it does not pay.
    Many,
}

/// The gravity of n bodies on one another.
///
/// Not finite where points of two bodies meet.
#[derive(Debug)]
pub struct MutualGravity {
    gravitational_constant: f64,
    bodies: Vec<Attractor>,
    moments: Vec<Moments>,
    tasks: Vec<Task>,
    threads: Threads,
    /// Cost of one evaluation, and of a task in the mean, in interactions of point with point.
    cost: f64,
    /// Where threads leave the results of their tasks, so that an evaluation allocates nothing.
    results: Mutex<Vec<Exchange>>,
}

/// A share of one pair: some probes in a field.
#[derive(Clone, Debug)]
struct Task {
    kind: Kind,
    field: usize,
    probe: usize,
    /// Which of the probes.
    range: Range<usize>,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Clouds,
    SecondOrder,
}

/// Force and moments between a field and probes over `G`, in the axes of the field; the force is on the probes.
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

impl MutualGravity {
    /// Most bodies; their pairs are summed one by one.
    pub const BODIES: usize = 2_000;
    /// Interactions in one task, about 50 µs: long against handing it to a thread, short against a force
    /// evaluation that pays for threads.
    const TASK: usize = 1 << 14;
    /// Interactions from which threads pay.
    const PAYS: f64 = 4.0 * Self::TASK as f64;

    /// The gravity of `bodies` on one another, with the constant `G` [m³/(kg·s²)].
    ///
    /// # Errors
    /// A [`FullBodyError`](super::FullBodyError) if there are no bodies or too many, the constant or a
    /// mass is not a positive number, or their product overflows.
    pub fn new(gravitational_constant: f64, bodies: Vec<Attractor>) -> Checked<Self> {
        positive("gravitational constant", gravitational_constant)?;
        count("bodies", bodies.len(), Self::BODIES)?;
        bodies.iter().try_for_each(|body| positive("mass of a body", body.mass()).map(drop))?;
        let mass: f64 = bodies.iter().map(Attractor::mass).sum();
        finite(
            "gravitational constant times the square of the masses",
            gravitational_constant * mass * mass,
        )?;
        let moments: Vec<_> =
            bodies.iter().map(|body| Moments { mass: body.mass(), inertia: body.inertia() }).collect();
        let (mut tasks, mut cost) = (Vec::new(), 0.0);
        for first in 0..bodies.len() {
            for second in first + 1..bodies.len() {
                cost += share(&bodies, first, second, &mut tasks);
            }
        }
        let results = Mutex::new(vec![Exchange::ZERO; tasks.len()]);
        Ok(Self { gravitational_constant, bodies, moments, tasks, threads: Threads::Auto, cost, results })
    }

    /// The same, with this choice of threads.
    #[must_use]
    pub fn with_threads(self, threads: Threads) -> Self {
        Self { threads, ..self }
    }

    /// The bodies, in the order of the poses.
    pub fn bodies(&self) -> &[Attractor] {
        &self.bodies
    }

    /// Whether an evaluation goes to several threads.
    fn is_shared(&self) -> bool {
        match self.threads {
            Threads::One => false,
            Threads::Many => true,
            Threads::Auto => self.cost >= Self::PAYS && rayon::current_num_threads() > 1,
        }
    }

    /// Tasks that a thread takes at once, at least: small ones are not worth a hand-over each.
    fn batch(&self) -> usize {
        (Self::TASK as f64 * self.tasks.len() as f64 / self.cost).ceil() as usize
    }

    fn exchange(&self, task: &Task, poses: &[Pose]) -> Exchange {
        let seen = seen_from(&poses[task.field], &poses[task.probe]);
        match (task.kind, &self.bodies[task.field], &self.bodies[task.probe]) {
            (Kind::Clouds, Attractor::Cloud(field), Attractor::Cloud(probes)) => {
                cloud_exchange(field, &probes.points()[task.range.clone()], &seen)
            }
            _ => second_order::exchange(&self.moments[task.field], &self.moments[task.probe], &seen),
        }
    }

    /// `U/G` of a task.
    fn task_energy(&self, task: &Task, poses: &[Pose]) -> f64 {
        let seen = seen_from(&poses[task.field], &poses[task.probe]);
        match (task.kind, &self.bodies[task.field], &self.bodies[task.probe]) {
            (Kind::Clouds, Attractor::Cloud(field), Attractor::Cloud(probes)) => {
                let of = |point: &MassPoint| {
                    point.mass * field.inverse_distances(&(seen.position + seen.attitude * point.position))
                };
                -probes.points()[task.range.clone()].iter().map(of).sum::<f64>()
            }
            _ => second_order::energy(&self.moments[task.field], &self.moments[task.probe], &seen),
        }
    }

    /// Adds what a task gave to both bodies.
    fn add(&self, task: &Task, exchange: &Exchange, poses: &[Pose], wrenches: &mut [Wrench]) {
        let (field, probe) = (&poses[task.field].attitude, &poses[task.probe].attitude);
        let g = self.gravitational_constant;
        let force = field * (g * exchange.force);
        wrenches[task.field].force -= force;
        wrenches[task.field].moment += g * exchange.field_moment;
        wrenches[task.probe].force += force;
        wrenches[task.probe].moment += probe.tr_mul(&(field * (g * exchange.probe_moment)));
    }
}

impl Potential for MutualGravity {
    /// # Panics
    /// If there is not one pose per body.
    fn energy(&self, poses: &[Pose]) -> f64 {
        assert_eq!(poses.len(), self.bodies.len(), "one pose per body");
        let of = |task: &Task| self.task_energy(task, poses);
        let sum: f64 = if self.is_shared() {
            // Collected in the order of the tasks; energies are printed, not stepped with, and may allocate.
            self.tasks.par_iter().with_min_len(self.batch()).map(of).collect::<Vec<_>>().iter().sum()
        } else {
            self.tasks.iter().map(of).sum()
        };
        self.gravitational_constant * sum
    }

    /// # Panics
    /// If there is not one pose and one row per body.
    fn wrenches(&self, poses: &[Pose], wrenches: &mut [Wrench]) {
        assert_eq!(poses.len(), self.bodies.len(), "one pose per body");
        assert_eq!(wrenches.len(), self.bodies.len(), "one row per body");
        wrenches.fill(Wrench::zero());
        // Another thread that evaluates the same potential has the buffer: then on this thread alone.
        let shared = if self.is_shared() { self.results.try_lock().ok() } else { None };
        if let Some(mut results) = shared {
            let pairs = self.tasks.par_iter().zip(results.par_iter_mut());
            pairs.with_min_len(self.batch()).for_each(|(task, result)| *result = self.exchange(task, poses));
            for (task, result) in self.tasks.iter().zip(results.iter()) {
                self.add(task, result, poses, wrenches);
            }
        } else {
            for task in &self.tasks {
                self.add(task, &self.exchange(task, poses), poses, wrenches);
            }
        }
    }
}

impl Clone for MutualGravity {
    fn clone(&self) -> Self {
        Self {
            gravitational_constant: self.gravitational_constant,
            bodies: self.bodies.clone(),
            moments: self.moments.clone(),
            tasks: self.tasks.clone(),
            threads: self.threads,
            cost: self.cost,
            results: Mutex::new(vec![Exchange::ZERO; self.tasks.len()]),
        }
    }
}

/// The tasks of a pair, and its cost in interactions.
fn share(bodies: &[Attractor], first: usize, second: usize, tasks: &mut Vec<Task>) -> f64 {
    /// A second-order pair costs about as much as so many interactions.
    const SECOND_ORDER: f64 = 8.0;
    match (&bodies[first], &bodies[second]) {
        (a, b) if a.is_second_order() || b.is_second_order() => {
            tasks.push(Task { kind: Kind::SecondOrder, field: first, probe: second, range: 0..0 });
            SECOND_ORDER
        }
        (Attractor::Cloud(a), Attractor::Cloud(b)) => {
            // The inner loop runs over the field: the longer one.
            let (field, probe) =
                if b.points().len() > a.points().len() { (second, first) } else { (first, second) };
            let long = a.points().len().max(b.points().len());
            let short = a.points().len().min(b.points().len());
            let step = (MutualGravity::TASK / long).max(1);
            tasks.extend((0..short).step_by(step).map(|start| Task {
                kind: Kind::Clouds,
                field,
                probe,
                range: start..(start + step).min(short),
            }));
            // Cutting a pair into lanes and turning its points costs about as much as four more of them.
            (long as f64 + 4.0) * short as f64
        }
        _ => unreachable!("a pair is of second order or of two clouds"),
    }
}

/// Force and moments between a cloud and probes, which `seen` brings to the axes of the cloud.
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
