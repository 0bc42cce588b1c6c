//! The time grid of a discrete maneuver: its nodes, the length of each step, and the weights of its
//! kicks.
//!
//! ```text
//! t_0 = 0 ,   t_{k+1} = t_k + h_k ,   t_N = T ,      h_k = T f_k ,   Σ f_k = 1
//! ```
//!
//! A step drifts over `h_k`; at each node the momenta are kicked, and a kick has a weight:
//!
//! ```text
//! Lie–Euler    κ_0 = 0 ,      κ_k = h_{k−1}
//! Lie–Verlet   κ_0 = h_0/2 ,  κ_k = (h_{k−1} + h_k)/2 ,  κ_N = h_{N−1}/2
//! ```
//!
//! The effort on the grid is a sum over the kicks, `Σ κ_k ½ u_kᵀWu_k`. Lie–Verlet is a chain of
//! symmetric steps, each of half a kick, a drift and half a kick, so it is of second order for any
//! step lengths.
//!
//! # Why does the grid hold the step lengths and the duration?
//!
//! Minimum time makes the duration an unknown and aligns steps with arcs. `Grid` therefore holds
//! the steps (equal, or each with its own length), the node times, the kick weights, and the
//! duration in the solvers' unit of time. For effort this duration is 1, because the unit is the
//! duration of the problem. The witnesses of a minimum-time plan build their grid from the times of
//! the plan. Lie–Verlet keeps its order on nonuniform grids, because it is a chain of symmetric
//! steps; a test shows it. The step matrices and rows of SCP are tested on nonuniform grids too,
//! the SCP iteration only on uniform grids. No spec requests unequal steps yet. Equal steps are
//! stored as one number, so that a uniform grid costs nothing.

use std::sync::Arc;
use thiserror::Error;

/// The discretisation: a variational integrator on SO(3) or SE(3). The plan satisfies its
/// discrete necessary conditions.
///
/// Over a step the body turns by `F = exp S(f)`, which solves the implicit equation
/// `h S(Π) = F J_d − J_d Fᵀ` with the momentum `Π` after the last kick; a kick adds the impulse of
/// inputs and environment. Lee, Leok and McClamroch 2006.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Lie–Euler (4.5–4.7), first order, input `u_{k+1}` at the end of step k: `N` rows of inputs.
    LieEuler,
    /// Lie–Verlet, the conjugate of Lie–Euler by half kicks at both ends, trapezoidal cost: second
    /// order, `N + 1` rows of inputs.
    LieVerlet,
}

impl Scheme {
    /// Returns the order of convergence.
    pub fn order(self) -> u32 {
        match self {
            Self::LieEuler => 1,
            Self::LieVerlet => 2,
        }
    }

    /// Returns the name of the scheme in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::LieEuler => "lie_euler",
            Self::LieVerlet => "lie_verlet",
        }
    }

    /// Returns the number of rows of inputs and costates that `steps` steps have.
    pub fn input_rows(self, steps: usize) -> usize {
        steps + 1 - self.first_input()
    }

    /// Returns the index of the first node that has inputs.
    pub fn first_input(self) -> usize {
        match self {
            Self::LieEuler => 1,
            Self::LieVerlet => 0,
        }
    }
}

/// The time grid of a maneuver, in seconds or in the solvers' unit of time.
///
/// The duration is stored as a number and is not the unit of time: a step lasts
/// `duration × fraction`.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    scheme: Scheme,
    duration: f64,
    steps: usize,
    lengths: Lengths,
}

#[derive(Clone, Debug, PartialEq)]
enum Lengths {
    /// All steps have this length.
    Equal(f64),
    /// Each step has its own length.
    Own(Arc<Fractions>),
}

/// Steps and nodes as fractions of the duration.
#[derive(Debug, PartialEq)]
struct Fractions {
    /// Length of each step, as a fraction of the duration: `f_k`, N numbers.
    steps: Vec<f64>,
    /// Time of each node, as a fraction of the duration: `t_k/T`, N+1 numbers.
    nodes: Vec<f64>,
}

/// The reason why step lengths do not form a grid.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum GridError {
    /// The grid has no step.
    #[error("a grid needs at least one step")]
    Empty,
    /// The length of a step is not positive and finite.
    #[error("step {index} of the grid has the length {length}: it must be positive and finite")]
    Length {
        /// Index of the step, from 0.
        index: usize,
        /// Length of the step \[s\].
        length: f64,
    },
}

impl Grid {
    /// Builds a uniform grid of `steps` steps, at least one, over `duration`.
    pub fn uniform(scheme: Scheme, duration: f64, steps: usize) -> Self {
        Self { scheme, duration, steps, lengths: Lengths::Equal(duration / steps as f64) }
    }

    /// Builds a grid of steps with the given lengths, whose sum is the duration.
    ///
    /// # Errors
    /// Returns a [`GridError`] for an empty list, or a length that is not positive and finite.
    pub fn of_lengths(scheme: Scheme, lengths: &[f64]) -> Result<Self, GridError> {
        if lengths.is_empty() {
            return Err(GridError::Empty);
        }
        let usable = |length: f64| length > 0.0 && length.is_finite();
        if let Some((index, length)) = lengths.iter().enumerate().find(|(_, length)| !usable(**length)) {
            return Err(GridError::Length { index, length: *length });
        }
        let duration: f64 = lengths.iter().sum();
        let steps: Vec<f64> = lengths.iter().map(|length| length / duration).collect();
        let mut nodes = Vec::with_capacity(steps.len() + 1);
        let mut node = 0.0;
        for fraction in &steps {
            nodes.push(node);
            node += fraction;
        }
        nodes.push(1.0);
        let count = steps.len();
        let lengths = Lengths::Own(Arc::new(Fractions { steps, nodes }));
        Ok(Self { scheme, duration, steps: count, lengths })
    }

    /// Returns the grid scaled to another duration, with equal fractions.
    pub fn with_duration(&self, duration: f64) -> Self {
        let lengths = match &self.lengths {
            Lengths::Equal(_) => Lengths::Equal(duration / self.steps as f64),
            Lengths::Own(fractions) => Lengths::Own(fractions.clone()),
        };
        Self { duration, lengths, ..*self }
    }

    /// Returns the integration scheme.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// Returns whether the maneuver begins and ends with half kicks, as Lie–Verlet does.
    pub fn has_half_kicks(&self) -> bool {
        self.scheme == Scheme::LieVerlet
    }

    /// Returns the duration `T`.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Returns the number of steps `N`.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Returns whether all steps have the same length.
    pub fn is_uniform(&self) -> bool {
        matches!(self.lengths, Lengths::Equal(_))
    }

    /// Returns the number of step lengths to distinguish: 1 on a uniform grid, else the number of
    /// steps.
    pub(crate) fn different_steps(&self) -> usize {
        match &self.lengths {
            Lengths::Equal(_) => 1,
            Lengths::Own(_) => self.steps,
        }
    }

    /// Returns the length `h_k` of step k, from node k to node k+1.
    #[inline(always)]
    pub fn step(&self, step: usize) -> f64 {
        match &self.lengths {
            Lengths::Equal(length) => *length,
            Lengths::Own(fractions) => self.duration * fractions.steps[step],
        }
    }

    /// Returns the time of node k, from 0 to exactly the duration.
    pub fn time(&self, node: usize) -> f64 {
        if node == self.steps { self.duration } else { self.after(node) }
    }

    /// Returns the time after `steps` steps as a sum, which may miss the duration by an ulp after
    /// the last step.
    pub fn after(&self, steps: usize) -> f64 {
        self.between(0, steps)
    }

    /// Returns the time from one node to a later one.
    pub fn between(&self, from: usize, to: usize) -> f64 {
        match &self.lengths {
            Lengths::Equal(length) => (to - from) as f64 * length,
            Lengths::Own(fractions) => self.duration * (fractions.nodes[to] - fractions.nodes[from]),
        }
    }

    /// Returns the number of rows of inputs and costates.
    pub fn input_rows(&self) -> usize {
        self.scheme.input_rows(self.steps)
    }

    /// Returns the index of the first node that has inputs: 1 for Lie–Euler, 0 for Lie–Verlet.
    pub fn first_input(&self) -> usize {
        self.scheme.first_input()
    }

    /// Returns the weight `κ_k` of the kick at node k.
    pub fn kick(&self, node: usize) -> f64 {
        if node > 0 && node < self.steps {
            return self.full_kick(node);
        }
        match self.scheme {
            Scheme::LieEuler if node == 0 => 0.0,
            Scheme::LieEuler => self.full_kick(node),
            Scheme::LieVerlet => 0.5 * self.full_kick(node),
        }
    }

    /// Returns the weight that the kick at node k would have if the grid continued beyond its ends
    /// with its outermost steps.
    #[inline(always)]
    pub fn full_kick(&self, node: usize) -> f64 {
        match &self.lengths {
            Lengths::Equal(length) => *length,
            Lengths::Own(_) => self.own_full_kick(node),
        }
    }

    /// Returns the full weight of the kick at node k divided by the mean step: 1 on a uniform grid.
    #[inline(always)]
    pub fn share(&self, node: usize) -> f64 {
        match &self.lengths {
            Lengths::Equal(_) => 1.0,
            Lengths::Own(_) => self.own_full_kick(node) / self.mean_step(),
        }
    }

    /// Returns the mean step `T/N`.
    pub fn mean_step(&self) -> f64 {
        self.duration / self.steps as f64
    }

    #[inline(never)]
    fn own_full_kick(&self, node: usize) -> f64 {
        let before = self.step(node.saturating_sub(1));
        match self.scheme {
            Scheme::LieEuler => before,
            Scheme::LieVerlet => 0.5 * (before + self.step(node.min(self.steps - 1))),
        }
    }

    /// Returns the weight of the second half of the kick at node k: the momenta after a full kick
    /// are ahead of the physical momenta by this half. It is 0 for Lie–Euler.
    #[inline(always)]
    pub fn ahead(&self, node: usize) -> f64 {
        match self.scheme {
            Scheme::LieEuler => 0.0,
            Scheme::LieVerlet => 0.5 * self.step(node.min(self.steps - 1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENGTHS: [f64; 4] = [0.5, 1.0, 0.25, 0.75];

    #[test]
    fn kicks_share_the_duration_among_the_nodes() {
        for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
            let own = Grid::of_lengths(scheme, &LENGTHS).unwrap();
            for grid in [own.with_duration(3.0), Grid::uniform(scheme, 3.0, 7)] {
                let sum: f64 = (0..=grid.steps()).map(|node| grid.kick(node)).sum();
                assert!((sum - 3.0).abs() < 1e-15 * 3.0, "{grid:?}");
                assert_eq!(grid.time(grid.steps()), 3.0);
                let rows = (0..=grid.steps()).filter(|node| grid.kick(*node) > 0.0).count();
                assert_eq!(rows, grid.input_rows());
                assert!(grid.kick(grid.first_input()) > 0.0);
            }
        }
    }

    #[test]
    fn weights_are_those_of_the_theory() {
        let euler = Grid::of_lengths(Scheme::LieEuler, &LENGTHS).unwrap();
        let verlet = Grid::of_lengths(Scheme::LieVerlet, &LENGTHS).unwrap();
        let weights = |grid: &Grid| (0..=4).map(|node| grid.kick(node)).collect::<Vec<_>>();
        assert_eq!(weights(&euler), [0.0, 0.5, 1.0, 0.25, 0.75]);
        assert_eq!(weights(&verlet), [0.25, 0.75, 0.625, 0.5, 0.375]);
        for (node, time) in [0.0, 0.5, 1.5, 1.75, 2.5].into_iter().enumerate() {
            assert!((verlet.time(node) - time).abs() < 1e-15 * 2.5);
        }
        // The momenta between two kicks are physical after the first half of each.
        for node in 1..4 {
            let before = verlet.full_kick(node) - verlet.ahead(node);
            assert!((before - 0.5 * verlet.step(node - 1)).abs() < 1e-15);
        }
    }

    #[test]
    fn lengths_that_make_no_grid_are_refused() {
        let refused = |lengths: &[f64]| Grid::of_lengths(Scheme::LieVerlet, lengths).unwrap_err();
        assert_eq!(refused(&[]), GridError::Empty);
        assert_eq!(refused(&[1.0, 0.0]), GridError::Length { index: 1, length: 0.0 });
        assert!(matches!(refused(&[f64::NAN]), GridError::Length { index: 0, .. }));
        assert!(matches!(refused(&[1.0, f64::INFINITY]), GridError::Length { index: 1, .. }));
    }
}
