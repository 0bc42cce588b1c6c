//! The mutual gravity of n bodies of any model, summed over their pairs.
//!
//! Pairs are split into tasks of fixed size, and the results of the tasks are added in a fixed
//! order. The result is therefore bit-identical for any number of threads.

use super::error::{Checked, count};
use super::pair::{TASK, Task};
use super::second_order::{Exchange, Moments};
use super::{Attractor, Potential};
use crate::mechanics::environment::{Pose, Symmetry, Wrench};
use crate::mechanics::number::{finite, positive};
use crate::numerics::parallel;
use std::sync::Mutex;

/// Newtonian constant of gravitation, CODATA 2018 and 2022 [m³/(kg·s²)].
pub const GRAVITATIONAL_CONSTANT: f64 = 6.674_30e-11;

/// The use of threads in an evaluation. The choice does not change a bit of the result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Threads {
    /// Uses threads if an evaluation is long enough. Default.
    #[default]
    Auto,
    /// Evaluates on the calling thread, without allocation.
    One,
    /// Evaluates on the threads of rayon, even if this takes longer. Without the feature `threads`,
    /// it evaluates on the calling thread.
    Many,
}

/// The mutual gravity of n bodies.
///
/// Values are not finite if points of two bodies coincide.
#[derive(Debug)]
pub struct MutualGravity {
    gravitational_constant: f64,
    bodies: Vec<Attractor>,
    moments: Vec<Moments>,
    tasks: Vec<Task>,
    threads: Threads,
    /// Cost of one evaluation, in point-to-point interactions.
    cost: f64,
    /// The buffer for the results of tasks, so that an evaluation does not allocate.
    results: Mutex<Vec<Exchange>>,
}

impl MutualGravity {
    /// The largest number of bodies. Their pairs are summed one by one.
    pub const BODIES: usize = 2_000;
    /// The largest number of point-to-point interactions in one evaluation, which take about half a
    /// minute.
    pub const INTERACTIONS: usize = 10_000_000_000;
    /// The smallest number of point-to-point interactions for which threads save time.
    const PAYS: f64 = 4.0 * TASK as f64;

    /// Builds the mutual gravity of `bodies`, with the gravitational constant `G` [m³/(kg·s²)].
    ///
    /// # Errors
    /// Returns a [`FullBodyError`](super::FullBodyError) if the number of bodies is zero or too
    /// large, if an evaluation would need more than [`Self::INTERACTIONS`], if the constant or a
    /// mass is not a positive number, or if their product overflows.
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
        let pairs = || (0..bodies.len()).flat_map(|first| (first + 1..bodies.len()).map(move |i| (first, i)));
        let cost: f64 = pairs().map(|(first, second)| Task::cost(&bodies, first, second)).sum();
        count("interactions in one evaluation", 1 + cost as usize, Self::INTERACTIONS)?;
        let mut tasks = Vec::new();
        pairs().for_each(|(first, second)| Task::split(&bodies, first, second, &mut tasks));
        let results = Mutex::new(vec![Exchange::ZERO; tasks.len()]);
        Ok(Self { gravitational_constant, bodies, moments, tasks, threads: Threads::Auto, cost, results })
    }

    /// Sets how an evaluation uses threads.
    #[must_use]
    pub fn with_threads(self, threads: Threads) -> Self {
        Self { threads, ..self }
    }

    /// Returns the bodies, in the order of the poses.
    pub fn bodies(&self) -> &[Attractor] {
        &self.bodies
    }

    /// Returns the cost of one evaluation, in point-to-point interactions.
    pub fn interactions(&self) -> f64 {
        self.cost
    }

    /// Returns whether an evaluation uses several threads.
    fn is_shared(&self) -> bool {
        match self.threads {
            Threads::One => false,
            Threads::Many => true,
            Threads::Auto => self.cost >= Self::PAYS && parallel::threads() > 1,
        }
    }

    /// Returns the smallest number of tasks in a batch for a thread. The overhead of smaller
    /// batches exceeds their gain.
    fn batch(&self) -> usize {
        (TASK as f64 * self.tasks.len() as f64 / self.cost).ceil() as usize
    }

    /// Adds the result of a task to both bodies.
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
    /// Returns full symmetry, because the energy depends only on relative poses.
    fn symmetry(&self) -> Symmetry {
        Symmetry::All
    }

    /// Returns the sum of the energies of all pairs.
    ///
    /// # Panics
    /// Panics if the numbers of poses and bodies differ.
    fn energy(&self, poses: &[Pose]) -> f64 {
        assert_eq!(poses.len(), self.bodies.len(), "one pose per body");
        let of = |task: &Task| task.energy(&self.bodies, &self.moments, poses);
        let sum: f64 = if self.is_shared() {
            // Energies are summed in the order of the tasks. They are printed and not used in
            // steps, so that this may allocate.
            let mut energies = vec![0.0; self.tasks.len()];
            parallel::fill(&self.tasks, &mut energies, self.batch(), of);
            energies.iter().sum()
        } else {
            self.tasks.iter().map(of).sum()
        };
        self.gravitational_constant * sum
    }

    /// Writes the sums of the wrenches of all pairs to `wrenches`.
    ///
    /// # Panics
    /// Panics if the numbers of poses, rows and bodies differ.
    fn wrenches(&self, poses: &[Pose], wrenches: &mut [Wrench]) {
        assert_eq!(poses.len(), self.bodies.len(), "one pose per body");
        assert_eq!(wrenches.len(), self.bodies.len(), "one row per body");
        wrenches.fill(Wrench::zero());
        let of = |task: &Task| task.exchange(&self.bodies, &self.moments, poses);
        // If another thread that evaluates this potential holds the buffer, this thread evaluates
        // alone.
        let shared = if self.is_shared() { self.results.try_lock().ok() } else { None };
        if let Some(mut results) = shared {
            parallel::fill(&self.tasks, &mut results, self.batch(), of);
            for (task, result) in self.tasks.iter().zip(results.iter()) {
                self.add(task, result, poses, wrenches);
            }
        } else {
            for task in &self.tasks {
                self.add(task, &of(task), poses, wrenches);
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
