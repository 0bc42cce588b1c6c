//! Full-space (lifted, multiple-shooting) Newton method: every state and costate is an unknown.
//!
//! The residuals are the defects of the steps, the defects of the costate recursion, and the
//! terminal error:
//!
//! ```text
//! d_k = [log(R_{k+1}ᵀ R_k F_k); step − Π_{k+1}] ,   c_k = λ_{k−1} − A_kᵀ λ_k ,   e
//! ```
//!
//! The linear system is solved in O(N) by a forward Riccati sweep in inverse (Gramian) form. With
//! `G_k = blockdiag(exp S(d_k^R), I)` and `V_k = (I − X_k H_k)⁻¹`,
//!
//! ```text
//! z_k = X_k δλ_{k−1} + x_k ,      X_0 = −Q/2 (Lie–Verlet) or 0 (Lie–Euler),  x_0 = 0
//! X_{k+1} = G_k (A_k V_k X_k A_kᵀ − Q) ,   x_{k+1} = G_k A_k V_k (x_k − X_k c_k) + d_k
//! ```
//!
//! The sweep never forms Ψ₁₂, the sensitivity of the terminal state to the initial costate. It
//! stays well conditioned for unstable dynamics, where single shooting fails.

use crate::lie;
use crate::maneuver::solution::Outcome;
use crate::numerics::compensated::Sum;
use crate::numerics::factor::Factor;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::{Costate, Dynamics, Linearization, Point, StepError};
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::ARMIJO;
use crate::optimize::methods::driver::{Iteration, run};
use crate::optimize::methods::method::{Attempt, Budget, Method};
use crate::optimize::methods::shooting::newton::outcome_of;
use crate::{Matrix3, Vector3};
use nalgebra::{DVector, SMatrix, SVector};

const SHORTEST: f64 = 1.0 / 1024.0;

/// All nodes of an extremal: states `y_0 … y_N`, costates `λ_{−1} … λ_{N−1}`.
#[derive(Clone, Debug)]
pub(crate) struct Nodes<const N: usize> {
    pub points: Vec<Point>,
    pub costates: Vec<SVector<f64, N>>,
}

impl<const N: usize> Nodes<N> {
    /// Returns the nodes of a candidate.
    pub fn of(candidate: &Candidate) -> Self {
        let costates =
            candidate.costates.iter().map(|costate| SVector::from_column_slice(costate.as_slice()));
        Self { points: candidate.states.clone(), costates: costates.collect() }
    }

    /// Returns `candidate` with its states and costates replaced by those of the nodes.
    pub fn into_candidate(self, candidate: Candidate) -> Candidate {
        let costates = self.costates.iter().map(|costate| DVector::from_column_slice(costate.as_slice()));
        Candidate { states: self.points, costates: costates.collect(), ..candidate }
    }
}

/// Lifted Newton on all states and costates of a candidate.
pub(crate) struct LiftedNewton<'a, const N: usize> {
    pub bvp: &'a BoundaryValueProblem<'a, N>,
    pub tolerance: f64,
    /// Factor on the number of iterations that the settings allow.
    pub patience: usize,
}

impl<const N: usize> Method for LiftedNewton<'_, N> {
    fn improve(&self, candidate: Candidate, budget: &Budget) -> Attempt {
        let nodes = self.bvp.dynamics.grid.steps() + 1;
        if candidate.states.len() != nodes || candidate.costates.len() != nodes {
            return Attempt::failed(candidate, Outcome::Stalled);
        }
        let lifted = match Lifted::new(self.bvp, self.tolerance, Nodes::of(&candidate)) {
            Ok(lifted) => lifted,
            Err(error) => return Attempt::failed(candidate, outcome_of(error)),
        };
        let (lifted, report) = run(lifted, self.patience * budget.iterations, budget.watch.interrupt);
        Attempt::of(lifted.nodes.into_candidate(candidate), report)
    }
}

/// State of the lifted Newton iteration.
#[derive(Clone, Debug)]
pub(crate) struct Lifted<'a, const N: usize> {
    bvp: &'a BoundaryValueProblem<'a, N>,
    tolerance: f64,
    /// States and costates of the current iterate.
    pub nodes: Nodes<N>,
    residuals: Residuals<N>,
}

/// Residuals and matrices at an iterate.
#[derive(Clone, Debug)]
struct Residuals<const N: usize> {
    d: Vec<SVector<f64, N>>,
    c: Vec<SVector<f64, N>>,
    e: SVector<f64, N>,
    linear: Vec<Linearization<N>>,
    /// Matrix `Q` at node 0: the weight of the kick times the control authority.
    q_start: SMatrix<f64, N, N>,
    /// Matrix `Q` at node N: the weight of the kick times the control authority.
    q_end: SMatrix<f64, N, N>,
    /// Matrix `K_pq`, the gradient of the kick with respect to the configuration, at node N.
    gradient_end: SMatrix<f64, N, N>,
    norm: f64,
    largest: f64,
}

impl<'a, const N: usize> Lifted<'a, N> {
    /// Starts the iteration at `nodes`. Returns an error if the integrator fails to step from one
    /// of them.
    pub fn new(
        bvp: &'a BoundaryValueProblem<'a, N>,
        tolerance: f64,
        nodes: Nodes<N>,
    ) -> Result<Self, StepError> {
        let residuals = Residuals::at(bvp, &nodes)?;
        Ok(Self { bvp, tolerance, nodes, residuals })
    }

    /// Returns the Newton direction `(z_k, δλ_k)` for all nodes; `None` if a block is singular or a
    /// number is not finite.
    fn direction(&self) -> Option<NewtonDirection<N>> {
        let Residuals { d, c, e, linear, q_start, q_end, gradient_end, .. } = &self.residuals;
        let steps = linear.len();
        let grid = &self.bvp.dynamics.grid;
        let verlet = grid.has_half_kicks();
        let identity = SMatrix::<f64, N, N>::identity();
        let mut gramian = if verlet { q_start * -0.5 } else { SMatrix::zeros() };
        let mut offset = SVector::<f64, N>::zeros();
        let (mut gramians, mut offsets, mut factors) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..steps {
            let Linearization { a, h, q } = &linear[k];
            let factor = Factor::new(&(identity - gramian * h));
            if factor.is_singular() {
                return None;
            }
            let turn = lie::exp(&d[k].fixed_rows::<3>(N - 6).into_owned());
            let next = a * factor.solve_matrix(&gramian) * a.transpose() - q;
            let next_offset = a * factor.solve(&(offset - gramian * c[k]));
            gramians.push(gramian);
            offsets.push(offset);
            factors.push(factor);
            gramian = turned(&turn, &next);
            offset = turned_vector(&turn, &next_offset) + d[k];
        }
        // Lie–Verlet ends half a kick before the last node: K₋ = I − (h/2) K_pq.
        let (k_minus, half_q) = if verlet {
            (identity - gradient_end * grid.kick(steps), q_end * 0.5)
        } else {
            (identity, SMatrix::zeros())
        };
        let terminal = Factor::new(&(k_minus * gramian + half_q));
        let mut delta = terminal.solve(&(-e - k_minus * offset));
        let mut states = vec![SVector::zeros(); steps + 1];
        let mut costates = vec![SVector::zeros(); steps + 1];
        states[steps] = gramian * delta + offset;
        costates[steps] = delta;
        for k in (0..steps).rev() {
            let Linearization { a, h, .. } = &linear[k];
            let back = a.tr_mul(&delta);
            let z = factors[k].solve(&(gramians[k] * (back - c[k]) + offsets[k]));
            delta = back + h * z - c[k];
            states[k] = z;
            costates[k] = delta;
        }
        let finite = states.iter().chain(&costates).all(|v| v.iter().all(|value| value.is_finite()));
        finite.then_some(NewtonDirection { states, costates })
    }

    fn moved(&self, direction: &NewtonDirection<N>, fraction: f64) -> Nodes<N> {
        let mut nodes = self.nodes.clone();
        for (point, z) in nodes.points.iter_mut().zip(&direction.states) {
            let z = Costate::from_vector(&(z * fraction));
            *point = Point {
                position: Sum::new(point.position.value + z.x),
                linear_momentum: Sum::new(point.linear_momentum.value + z.gamma),
                attitude: Sum::new(lie::project_to_rotation(&(point.attitude.value * lie::exp(&z.zeta)))),
                momentum: Sum::new(point.momentum.value + z.pi),
            };
        }
        for (costate, delta) in nodes.costates.iter_mut().zip(&direction.costates) {
            *costate += delta * fraction;
        }
        nodes
    }
}

/// Newton direction for the states and costates of all nodes.
struct NewtonDirection<const N: usize> {
    states: Vec<SVector<f64, N>>,
    costates: Vec<SVector<f64, N>>,
}

impl<const N: usize> Residuals<N> {
    fn at(bvp: &BoundaryValueProblem<N>, nodes: &Nodes<N>) -> Result<Self, StepError> {
        let dynamics = &bvp.dynamics;
        let grid = &dynamics.grid;
        let steps = grid.steps();
        let (mut d, mut c, mut linear) = (Vec::new(), Vec::new(), Vec::new());
        let start = opening_point(bvp, &nodes.costates[0]);
        let start_costate = Costate::from_vector(&nodes.costates[0]);
        let q_start =
            dynamics.linear_kick::<N>(&start.pose(), &start_costate).authority::<N>() * grid.full_kick(0);
        for k in 0..steps {
            let from = if k == 0 { &start } else { &nodes.points[k] };
            let step = dynamics.transition::<N>(k, from, &nodes.costates[k + 1])?;
            d.push(step.end.minus(&nodes.points[k + 1]).to_vector());
            c.push(nodes.costates[k] - step.costate_before);
            linear.push(step.linear);
        }
        let last = &nodes.points[steps];
        let costate = Costate::from_vector(&nodes.costates[steps]);
        let kick = dynamics.linear_kick::<N>(&last.pose(), &costate);
        let (q_end, gradient_end) = (kick.authority::<N>() * grid.full_kick(steps), kick.gradient::<N>());
        let (end, costate) = closing_point::<N>(dynamics, last, &costate);
        let e = bvp.terminal.value(&end, &costate);
        let all = || d.iter().chain(&c).chain(std::iter::once(&e));
        let norm = all().map(|residual| residual.norm_squared()).sum::<f64>().sqrt();
        let largest = all().map(|residual| residual.amax()).fold(0.0, f64::max);
        if !norm.is_finite() {
            return Err(StepError::NotFinite);
        }
        Ok(Self { d, c, e, linear, q_start, q_end, gradient_end, norm, largest })
    }
}

/// Returns the first state of the integrator: for Lie–Verlet, half a kick after the boundary state.
fn opening_point<const N: usize>(bvp: &BoundaryValueProblem<N>, costate: &SVector<f64, N>) -> Point {
    let mut point = bvp.start;
    if bvp.dynamics.grid.has_half_kicks() {
        let mut costate = Costate::from_vector(costate);
        let kick = bvp.dynamics.kick::<N>(&point.pose(), &costate);
        kick.apply::<N>(&mut point, &mut costate, bvp.dynamics.grid.kick(0), 0.0);
    }
    point
}

/// Returns the physical last state and its costate: for Lie–Verlet, half a kick before the
/// integrator's last state.
fn closing_point<const N: usize>(dynamics: &Dynamics, last: &Point, costate: &Costate) -> (Point, Costate) {
    let (mut point, mut costate) = (*last, *costate);
    if dynamics.grid.has_half_kicks() {
        let kick = dynamics.kick::<N>(&point.pose(), &costate);
        let weight = -dynamics.grid.kick(dynamics.grid.steps());
        kick.apply::<N>(&mut point, &mut costate, weight, weight);
    }
    (point, costate)
}

fn turned<const N: usize>(turn: &Matrix3, matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let mut out = *matrix;
    let rows = turn * matrix.fixed_rows::<3>(N - 6);
    out.fixed_rows_mut::<3>(N - 6).copy_from(&rows);
    out
}

fn turned_vector<const N: usize>(turn: &Matrix3, vector: &SVector<f64, N>) -> SVector<f64, N> {
    let mut out = *vector;
    let rows: Vector3 = turn * vector.fixed_rows::<3>(N - 6);
    out.fixed_rows_mut::<3>(N - 6).copy_from(&rows);
    out
}

impl<const N: usize> Iteration for Lifted<'_, N> {
    fn residual(&self) -> f64 {
        self.residuals.largest
    }

    fn converged(&self) -> bool {
        self.residual() <= self.tolerance
    }

    fn advance(&mut self) -> Option<Outcome> {
        let Some(direction) = self.direction() else { return Some(Outcome::Singular) };
        let norm = self.residuals.norm;
        let mut fraction = 1.0;
        let mut failure = Outcome::Stalled;
        while fraction >= SHORTEST {
            let nodes = self.moved(&direction, fraction);
            match Residuals::at(self.bvp, &nodes) {
                Ok(residuals) if residuals.norm <= (1.0 - 2.0 * ARMIJO * fraction) * norm => {
                    (self.nodes, self.residuals) = (nodes, residuals);
                    return self.converged().then_some(Outcome::Converged);
                }
                Ok(_) => {}
                Err(error) => failure = outcome_of(error),
            }
            fraction *= 0.5;
        }
        // At the level of round-off no step reduces the norm further.
        Some(if self.converged() { Outcome::Converged } else { failure })
    }
}

#[cfg(test)]
mod tests;
