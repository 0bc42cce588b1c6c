//! A path, its cost by inverse dynamics, and the gradient of the cost with respect to its nodes.
//!
//! With `F_k = R_kᵀR_{k+1}` (without the rotation of the reference frame), weights `h_k` of the
//! kicks, and `Ŵ = (B W⁻¹Bᵀ)⁻¹` at the pose of its node,
//!
//! ```text
//! Π_k = (1/h) vee(F_k J_d − J_d F_kᵀ) ,   γ_k = (x_{k+1} − x_k)/h ,   Π'_k = F_kᵀΠ_k
//! τ_k = (Π_k − Π'_{k−1})/h_k − M(R_k) ,   Π'_{−1} := Π_start ,  Π_N := Π_target
//! J   = Σ (h_k/2) τ_kᵀ Ŵ τ_k
//! ```
//!
//! The costates follow too: `p_k = −Ŵ τ_k` is `λ^Π_{k−1}`, and the momentum rows of
//! `λ_{k−1} = A_kᵀλ_k` give
//!
//! ```text
//! μ'_k = B_k^{−T}(p_k − F_k p_{k+1}) − p_{k+1} × Π'_k ,   B_k⁻¹ = E F_k/h ,   λ^R_k = μ'_k − h K_R(node k+1)
//! g_k  = ∂J/∂ζ_k = F_k μ'_k − λ^R_{k−1}
//! ```
//!
//! Lie–Euler has no kick at node 0: its first step is given, and node 1 is used in place of node 0.

use super::{Block, Half, half, moved, point, stored};
use crate::lie::vee;
use crate::mechanics::environment::{Blocks, Pose, Wrench};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::drift::Drift;
use crate::optimize::discrete::step::inputs::InputMatrices;
use crate::optimize::discrete::step::{Costate, Dynamics, Point, StepError};
use crate::{Matrix3, Vector3};

/// Smallest trace of a step's rotation. It limits the rotation to a right angle, so that the
/// implicit equation is on its physical branch.
const SMALLEST_TRACE: f64 = 1.0;

/// Data that all paths of a maneuver share.
pub(super) struct Setting<'a, const N: usize, const D: usize> {
    pub dynamics: &'a Dynamics,
    /// Physical state at the start, before any kick.
    start: Point,
    /// State before the first kick, at node `first`.
    opening: Point,
    pub first: usize,
    target: Point,
    pub inverse: InputMatrices,
}

impl<'a, const N: usize, const D: usize> Setting<'a, N, D> {
    pub fn new(dynamics: &'a Dynamics, start: &Point, target: &Point) -> Result<Self, StepError> {
        let first = dynamics.grid.first_input();
        let mut opening = *start;
        for step in 0..first {
            dynamics.drift::<N>(step, &mut opening)?;
        }
        let inverse = dynamics.inverse_authority();
        Ok(Self { dynamics, start: *start, opening, first, target: *target, inverse })
    }

    /// Returns the indices of the nodes that may move.
    #[cfg(test)]
    pub fn inner(&self) -> std::ops::Range<usize> {
        self.first + 1..self.dynamics.grid.steps()
    }
}

/// Displacements of all nodes of a path.
#[derive(Clone, Debug)]
pub(super) struct Direction<const D: usize> {
    pub zeta: Vec<Half<D>>,
}

impl<const D: usize> Direction<D> {
    pub fn new(steps: usize) -> Self {
        Self { zeta: vec![Half::zeros(); steps + 1] }
    }

    /// Returns the norm of the largest displacement, at least the smallest positive number.
    pub fn largest(&self) -> f64 {
        self.zeta.iter().map(|zeta| zeta.norm()).fold(f64::MIN_POSITIVE, f64::max)
    }
}

/// A path, with its cost, costates and gradient by inverse dynamics.
#[derive(Clone, Debug)]
pub(super) struct Path<const D: usize> {
    /// Poses of all nodes.
    pub poses: Vec<Pose>,
    /// Cost of the path, scaled.
    pub cost: f64,
    /// Drift from each node to the next one; meaningless before node `first` of the setting.
    pub drifts: Vec<Drift>,
    /// Linear momentum after the kick at each node.
    linear_momenta: Vec<Vector3>,
    /// Momentum costates `p_k` at all nodes.
    duals: Vec<Half<D>>,
    /// Costate between drift k and the kick at node k+1.
    pub between: Vec<Costate>,
    /// Gradient `g_k` of the cost; zero at nodes that cannot move.
    pub gradient: Vec<Half<D>>,
    /// Configuration costates `(λ^x, λ^R)` after the kick at each node.
    slopes: Vec<Half<D>>,
}

impl<const D: usize> Path<D> {
    /// Creates the path through `poses`, one for each node; `None` if the rotation of a step is too
    /// large.
    pub fn of<const N: usize>(setting: &Setting<N, D>, mut poses: Vec<Pose>) -> Option<Self> {
        let nodes = setting.dynamics.grid.steps() + 1;
        if poses.len() != nodes {
            return None;
        }
        for (node, state) in
            [(0, &setting.start), (setting.first, &setting.opening), (nodes - 1, &setting.target)]
        {
            poses[node] = state.pose();
        }
        let zero = Vector3::zeros();
        let still = Drift { h: 0.0, f: Matrix3::identity(), momentum: zero, momentum_after: zero };
        let nothing = Costate { x: zero, gamma: zero, zeta: zero, pi: zero };
        let mut path = Self {
            poses,
            cost: f64::INFINITY,
            drifts: vec![still; nodes],
            linear_momenta: vec![zero; nodes],
            duals: vec![Half::zeros(); nodes],
            between: vec![nothing; nodes],
            gradient: vec![Half::zeros(); nodes],
            slopes: vec![Half::zeros(); nodes],
        };
        path.evaluate(setting).then_some(path)
    }

    /// Sets the poses to those of `from`, displaced along a direction. The path must then be
    /// evaluated.
    pub fn moved(&mut self, from: &Self, direction: &Direction<D>, fraction: f64) {
        for ((pose, from), along) in self.poses.iter_mut().zip(&from.poses).zip(&direction.zeta) {
            *pose = moved(from, along, fraction);
        }
    }

    /// Computes inputs and cost by inverse dynamics; returns false if the rotation of a step is too
    /// large or the cost is not finite.
    pub fn evaluate<const N: usize>(&mut self, setting: &Setting<N, D>) -> bool {
        let Setting { dynamics, opening, first, target, inverse, .. } = setting;
        let grid = &dynamics.grid;
        let steps = grid.steps();
        self.cost = 0.0;
        let mut before = (opening.linear_momentum.value, opening.momentum.value);
        for node in *first..=steps {
            let pose = &self.poses[node];
            let (linear_momentum, momentum, drifted) = if node == steps {
                (target.linear_momentum.value, target.momentum.value, before)
            } else {
                let next = &self.poses[node + 1];
                let h = grid.step(node);
                let f = pose.attitude.tr_mul(&dynamics.unturned(node, &next.attitude));
                if f.trace() <= SMALLEST_TRACE {
                    return false;
                }
                let f_j_d = f * dynamics.j_d;
                let momentum = vee(&(f_j_d - f_j_d.transpose())) / h;
                let momentum_after = f.tr_mul(&momentum);
                let linear_momentum =
                    if D == 6 { (next.position - pose.position) / h } else { Vector3::zeros() };
                self.drifts[node] = Drift { h, f, momentum, momentum_after };
                (linear_momentum, momentum, (linear_momentum, momentum_after))
            };
            self.linear_momenta[node] = linear_momentum;
            let weight = grid.kick(node);
            let acting = dynamics.environment_wrench(pose);
            let needed = Wrench {
                force: if D == 6 {
                    (linear_momentum - before.0) / weight - acting.force
                } else {
                    Vector3::zeros()
                },
                moment: (momentum - before.1) / weight - acting.moment,
            };
            let (gamma, pi) = inverse.dual(&pose.attitude, &needed);
            self.duals[node] = half(&gamma, &pi);
            self.cost -= 0.5 * weight * (gamma.dot(&needed.force) + pi.dot(&needed.moment));
            before = drifted;
        }
        self.cost.is_finite()
    }

    /// Computes costates and gradient of an evaluated path.
    pub fn differentiate<const N: usize>(&mut self, setting: &Setting<N, D>) {
        let dynamics = setting.dynamics;
        let steps = dynamics.grid.steps();
        for node in setting.first..steps {
            let (drift, p, next) = (&self.drifts[node], self.costate(node), self.costate(node + 1));
            let f = &drift.f;
            let e = dynamics.drift_matrix(drift);
            let lever = f.tr_mul(&e.tr_mul(&(p.pi - f * next.pi))) / drift.h;
            let zeta = lever - next.pi.cross(&drift.momentum_after);
            let x = if D == 6 { (p.gamma - next.gamma) / drift.h } else { Vector3::zeros() };
            self.between[node] = Costate { x, zeta, ..next };
            if node > setting.first {
                self.gradient[node] = half::<D>(&x, &(f * zeta)) - self.slopes[node];
            }
            let kick = dynamics.kick::<N>(&self.poses[node + 1], &next);
            let weight = dynamics.grid.kick(node + 1);
            self.slopes[node + 1] = half(&(x - kick.slope_x * weight), &(zeta - kick.slope_r * weight));
        }
    }

    /// Returns the momentum costate `p_k` of a node as a full costate whose configuration rows are
    /// zero.
    fn costate(&self, node: usize) -> Costate {
        let (gamma, pi) = super::parts(&self.duals[node]);
        let zero = Vector3::zeros();
        Costate { x: zero, gamma, zeta: zero, pi }
    }

    /// Returns the momentum costate at a node, for the linearised kick.
    pub fn dual(&self, node: usize) -> Costate {
        self.costate(node)
    }

    /// Returns the directional derivative `gᵀζ` of the cost.
    pub fn slope(&self, direction: &Direction<D>) -> f64 {
        self.gradient.iter().zip(&direction.zeta).map(|(g, zeta)| g.dot(zeta)).sum()
    }

    /// Returns the candidate with states and costates of all nodes, in the form of the lifted
    /// Newton method; the first costate is λ₋₁ of the sweep.
    pub fn into_candidate<const N: usize>(
        mut self,
        setting: &Setting<N, D>,
        candidate: Candidate,
    ) -> Candidate {
        self.differentiate(setting);
        let Setting { dynamics, start, first, .. } = setting;
        let grid = &dynamics.grid;
        let steps = grid.steps();
        let mut states = Vec::with_capacity(steps + 1);
        let mut costates = Vec::with_capacity(steps + 1);
        for node in 0..=steps {
            let pose = &self.poses[node];
            if node < *first {
                states.push(*start);
                continue;
            }
            let dual = self.costate(node);
            // The last state of the integrator is half a kick after the physical one.
            let (linear_momentum, momentum) = if node < steps {
                (self.linear_momenta[node], self.drifts[node].momentum)
            } else {
                let kick = dynamics.kick::<N>(pose, &dual);
                let ahead = grid.ahead(node);
                (
                    setting.target.linear_momentum.value + kick.force * ahead,
                    setting.target.momentum.value + kick.moment * ahead,
                )
            };
            states.push(point(pose, linear_momentum, momentum));
            let (x, zeta) = if node < steps {
                let between = &self.between[node];
                (between.x, self.drifts[node].f * between.zeta)
            } else {
                // The costate passes the whole last kick, of which the path includes half.
                let kick = dynamics.kick::<N>(pose, &dual);
                let between = &self.between[steps - 1];
                let weight = grid.full_kick(steps);
                (between.x - kick.slope_x * weight, between.zeta - kick.slope_r * weight)
            };
            costates.push(Costate { x, zeta, ..dual });
        }
        // Carries the costate back over the kick and the drift that a Lie–Euler path does not
        // include.
        for step in (0..*first).rev() {
            let mut after = costates[0];
            let pose = states[step + 1].pose();
            let kick = dynamics.kick::<N>(&pose, &after);
            let weight = grid.full_kick(step + 1);
            after.x += kick.slope_x * weight;
            after.zeta += kick.slope_r * weight;
            let mut end = states[step];
            if let Ok(drift) = dynamics.drift::<N>(step, &mut end) {
                costates.insert(0, dynamics.drift_costate_back::<N>(&drift, &after));
            }
        }
        let costates = costates.into_iter().map(stored::<N>).collect();
        Candidate { states, costates, ..candidate }
    }
}

/// Returns the derivative of a field with respect to (x, R), reduced to rotation if the body does
/// not translate.
pub(super) fn block<const D: usize>(blocks: &Blocks) -> Block<D> {
    Block::from_fn(|row, column| {
        let (in_x, of_x) = (row + 3 < D, column + 3 < D);
        let part = match (in_x, of_x) {
            (true, true) => &blocks.xx,
            (true, false) => &blocks.xr,
            (false, true) => &blocks.rx,
            (false, false) => &blocks.rr,
        };
        part[(row % 3, column % 3)]
    })
}
