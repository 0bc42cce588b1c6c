//! Galerkin Lie group variational integrators in the natural chart: order 2s for curves of degree s
//! (section 2.2).
//!
//! ```text
//! R(τ) = R_0 exp S(Σ ξ_ν l_ν(τ)) ,   x(τ) = x_0 + Σ y_ν l_ν(τ) ,   τ ∈ [0, 1] ,   ν = 1…s
//! L_d  = ext Σ_i h b_i L(R(c_i), Ω(c_i), x(c_i), ẋ(c_i)) ,   Ω = J_r(ξ) ξ'/h ,   ẋ = y'/h
//! ```
//! Stationarity with respect to the interior control points, and the discrete Legendre transforms
//! at the ends, give 3s equations per attitude (see `attitude.rs`) and as many per position:
//! ```text
//! g_ν = h Σ b_i [ l'_ν(c_i) m y'(c_i)/h² + l_ν(c_i) f_i ]
//! 0 = g_ν (ν < s) ,   γ_0 + h Σ b_i f_i = g_s          then γ_1 = γ_0 + h Σ b_i f_i
//! ```
//! The chart is centred at the start of the step, and the curve is not a polynomial in the chart at
//! the end of the step. For s ≥ 2 the methods are symplectic and conserve momenta, but are not
//! symmetric in time.
//!
//! Inputs act like forces of the potential (discrete Lagrange–d'Alembert principle). Newton's
//! method solves all equations together. If the gradient of the potential is available, or loads do
//! not depend on the poses, the Jacobian is exact and 2–4 iterations suffice. If the gradient is
//! not available, or the bodies are too many, the contribution of the gradient to the Jacobian is
//! omitted and every body is solved separately. Each iteration then reduces the error by a factor
//! of about h²‖U''‖.

mod attitude;
mod convergence;
mod euler_poincare;
mod kinetic;
mod linear;
mod scheme;

pub use euler_poincare::{EulerPoincare, ReducedStep};
pub use scheme::{DEGREES, Quadrature};

use super::course::{Course, Method};
use super::state::carried;
use super::{Facts, Input, StepError, System, SystemState};
use crate::mechanics::body::Body;
use crate::mechanics::environment::{Blocks, Pose, Wrench};
use crate::{Vector3, lie};
use attitude::{Arc, Start, combine};
use convergence::{Convergence, MAX_ITERATIONS, Next, relative};
use linear::Dense;
use nalgebra::DMatrix;
use scheme::Scheme;

/// Largest number of unknowns in one dense system. With more unknowns each body is solved
/// separately.
const MOST_COUPLED: usize = 144;

/// Square of the turn in a step up to which its Cayley vector, which is infinite at π, is used.
const LARGE_TURN: f64 = 2.0;

/// Returns the factor `tan(t/2)/t` between rotation vector and Cayley vector.
fn half_tangent(t: f64) -> f64 {
    if t > f64::EPSILON { (0.5 * t).tan() / t } else { 0.5 }
}

/// A Galerkin integrator of all bodies.
#[derive(Clone, Debug)]
pub(crate) struct Galerkin {
    scheme: Scheme,
    course: Course,
    curves: Vec<Curve>,
    /// Wrenches at the quadrature points, one row of bodies per point.
    wrenches: Vec<Wrench>,
    poses: Vec<Pose>,
    /// The n×n blocks of the potential's gradient at one point, and the matrix of all unknowns;
    /// `None` if the gradient is not used.
    coupled: Option<(Vec<Blocks>, Dense)>,
    /// The matrix of one attitude, for bodies that are solved separately.
    single: Dense,
    right: Vec<f64>,
    stiffness: Stiffness,
    /// Whether the loads on the bodies depend on their poses.
    posed: bool,
    /// Whether curves of the last step exist, from which new curves are extrapolated.
    warm: bool,
}

/// The curve of one body over a step.
#[derive(Clone, Debug)]
struct Curve {
    arc: Arc,
    /// Control values `y_1 … y_s` of the position; empty for a body that only rotates.
    shifts: Vec<Vector3>,
    /// Index of the curve's first unknown in the vector of all unknowns.
    offset: usize,
}

/// The kinetic matrix of positions per unit mass, `K_νμ = (1/h) Σ b_i l'_ν l'_μ`, and its inverse.
#[derive(Clone, Debug)]
struct Stiffness {
    matrix: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl Stiffness {
    fn of(scheme: &Scheme, h: f64) -> Self {
        let element = |nu: usize, mu: usize| -> f64 {
            let terms = scheme.weights.iter().zip(&scheme.slopes).map(|(b, l)| b * l[nu] * l[mu]);
            terms.sum::<f64>()
        };
        let matrix = DMatrix::from_fn(scheme.degree, scheme.degree, element);
        // The matrix is positive definite: a curve of degree s whose velocity is zero at s points
        // is constant.
        let inverse = matrix.clone().try_inverse().expect("the slopes of the basis are independent");
        Self { matrix: matrix / h, inverse: inverse * h }
    }
}

impl Galerkin {
    pub fn new(
        system: &System,
        state: &SystemState,
        step: f64,
        degree: usize,
        quadrature: Quadrature,
    ) -> Self {
        let scheme = Scheme::new(degree, quadrature);
        let (n, points) = (system.bodies().len(), scheme.points.len());
        let mut unknowns = 0;
        let mut curve = |body: &Body| {
            let offset = unknowns;
            let shifts = vec![Vector3::zeros(); if body.mass.is_some() { degree } else { 0 }];
            unknowns += 3 * (degree + shifts.len());
            Curve { arc: Arc::new(&scheme), shifts, offset }
        };
        let curves: Vec<Curve> = system.bodies().iter().map(&mut curve).collect();
        let mut blocks = vec![Blocks::zero(); n * n];
        let coupled = unknowns <= MOST_COUPLED
            && system.potential().is_some_and(|potential| potential.gradient(state.poses(), &mut blocks));
        Self {
            course: Course::new(system, state, step, Self::facts(degree)),
            curves,
            wrenches: vec![Wrench::zero(); n * points],
            poses: state.poses().to_vec(),
            coupled: coupled.then(|| (blocks, Dense::new(unknowns))),
            single: Dense::new(3 * degree),
            right: vec![0.0; unknowns],
            stiffness: Stiffness::of(&scheme, step),
            posed: system.potential().is_some_and(|potential| potential.depends_on_poses()),
            scheme,
            warm: false,
        }
    }

    /// Continues from another state, without curves of a preceding step.
    pub fn restart(&mut self, state: &SystemState) {
        self.course.state = state.clone();
        self.warm = false;
    }

    pub fn facts(degree: usize) -> Facts {
        let order = 2 * degree as u32;
        Facts { order, explicit: false, force_evaluations: None, ..Facts::VARIATIONAL }
    }

    /// Computes initial curves. They continue the curves of the last step, or follow from the rates
    /// and velocities of each body and its angular acceleration, which is known at the start.
    fn predict(&mut self, warm: bool) {
        let h = self.course.loads.step;
        for (index, curve) in self.curves.iter_mut().enumerate() {
            let body = &self.course.loads.system.bodies()[index];
            let momentum = self.course.state.momenta()[index];
            let s = self.scheme.degree;
            if warm {
                curve.arc.extrapolate(&self.scheme);
                let Some(&end) = curve.shifts.last() else { continue };
                // Each combination needs all old values, so the new values are first written to a
                // buffer.
                let right = &mut self.right[curve.offset..];
                for (row, out) in self.scheme.ahead.iter().zip(right.chunks_exact_mut(3)) {
                    out.copy_from_slice((combine(row, &curve.shifts) - end).as_slice());
                }
                for (shift, value) in curve.shifts.iter_mut().zip(right.chunks_exact(3)) {
                    *shift = Vector3::from_column_slice(value);
                }
            } else {
                let rate = body.inertia.j_inverse() * momentum.angular;
                let moment = if self.posed { Vector3::zeros() } else { self.wrenches[index].moment };
                let acceleration = body.inertia.j_inverse() * (momentum.angular.cross(&rate) + moment);
                curve.arc.constant_acceleration(&self.scheme, h, &rate, &acceleration);
                let velocity = body.mass.map_or_else(Vector3::zeros, |mass| momentum.linear / mass);
                for (shift, d) in curve.shifts.iter_mut().zip(&self.scheme.times[..s]) {
                    *shift = velocity * (h * d);
                }
            }
        }
    }

    /// Places all bodies at the quadrature points, and evaluates the loads there if they depend on
    /// the poses.
    fn look(&mut self, inputs: &[Input]) {
        for curve in &mut self.curves {
            curve.arc.place(&self.scheme);
        }
        if self.posed {
            self.evaluate(inputs);
        }
    }

    /// Evaluates the loads on the bodies at the quadrature points.
    fn evaluate(&mut self, inputs: &[Input]) {
        let n = self.curves.len();
        if self.course.loads.is_free(inputs) {
            self.wrenches.fill(Wrench::zero());
            return;
        }
        for (i, wrenches) in self.wrenches.chunks_exact_mut(n).enumerate() {
            place(&self.curves, &self.scheme, &self.course.state, i, &mut self.poses);
            self.course.loads.total(self.scheme.points[i], &self.poses, inputs, wrenches);
        }
    }

    /// Computes the right-hand sides, solves for the corrections and applies them. Returns the
    /// relative size of the corrections.
    fn correct(&mut self) -> f64 {
        let (h, n, s) = (self.course.loads.step, self.curves.len(), self.scheme.degree);
        if let Some((blocks, matrix)) = &mut self.coupled {
            matrix.clear();
            for i in 0..self.scheme.points.len() {
                place(&self.curves, &self.scheme, &self.course.state, i, &mut self.poses);
                self.course.loads.gradient(self.scheme.points[i], &self.poses, blocks);
                couple(&self.curves, &self.scheme, h, i, blocks, matrix);
            }
        }
        for (index, curve) in self.curves.iter_mut().enumerate() {
            let body = &self.course.loads.system.bodies()[index];
            let momentum = self.course.state.momenta()[index];
            let (wrenches, offset) = (&self.wrenches, curve.offset);
            let (angular, linear) = self.right[offset..].split_at_mut(3 * s);
            let jacobian = match &mut self.coupled {
                Some((_, matrix)) => (matrix, offset),
                None => {
                    self.single.clear();
                    (&mut self.single, 0)
                }
            };
            let moment = |i: usize| wrenches[i * n + index].moment;
            let start = Start { j: *body.inertia.j(), h, momentum: momentum.angular };
            curve.arc.residual(&self.scheme, &start, moment, angular, Some(jacobian));
            if self.coupled.is_none() {
                self.single.solve(angular);
            }
            let Some(mass) = body.mass else { continue };
            let force = |i: usize| wrenches[i * n + index].force;
            let linear = &mut linear[..3 * s];
            for (nu, out) in linear.chunks_exact_mut(3).enumerate() {
                let last = if nu == s - 1 { 1.0 } else { 0.0 };
                // The last row has γ_0 + h Σ b f; every row has g_ν subtracted.
                let mut sum = momentum.linear * last;
                for (mu, shift) in curve.shifts.iter().enumerate() {
                    sum -= shift * (mass * self.stiffness.matrix[(nu, mu)]);
                }
                for (i, weight) in self.scheme.weights.iter().enumerate() {
                    sum += force(i) * (h * weight * (last - self.scheme.values[i][nu]));
                }
                out.copy_from_slice(sum.as_slice());
            }
            match &mut self.coupled {
                Some((_, matrix)) => {
                    let corner = offset + 3 * s;
                    for (nu, mu) in (0..s).flat_map(|nu| (0..s).map(move |mu| (nu, mu))) {
                        let element = mass * self.stiffness.matrix[(nu, mu)];
                        let block = crate::Matrix3::from_diagonal_element(element);
                        matrix.add(corner + 3 * nu, corner + 3 * mu, &block);
                    }
                }
                None => solve_linear(&self.stiffness, mass, linear),
            }
        }
        if let Some((_, matrix)) = &mut self.coupled {
            matrix.solve(&mut self.right);
        }
        let mut worst = 0.0;
        for curve in &mut self.curves {
            let (angular, linear) = self.right[curve.offset..].split_at(3 * s);
            let (mut change, mut size) = (0.0, 0.0);
            for (shift, delta) in curve.shifts.iter_mut().zip(linear.chunks_exact(3)) {
                let delta = Vector3::from_column_slice(delta);
                *shift += delta;
                change += delta.norm_squared();
                size += shift.norm_squared();
            }
            for part in [curve.arc.correct(angular), relative(change.sqrt(), size.sqrt())] {
                // A NaN value stays in this comparison.
                worst = if part <= worst { worst } else { part };
            }
        }
        worst
    }

    fn solve(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        let free = self.course.loads.is_free(inputs);
        let exact = self.coupled.is_some() || !self.posed;
        let mut convergence = Convergence::new(exact);
        for iterations in 1..=MAX_ITERATIONS {
            self.look(inputs);
            self.course.work.iterations += 1;
            match convergence.after(self.correct()) {
                Next::Iterate => {}
                Next::Done => {
                    if !free {
                        // The stored impulses belong to the curves before the last correction, so
                        // they are computed again.
                        self.look(inputs);
                    }
                    return Ok(());
                }
                Next::GiveUp => {
                    return Err(StepError::NotConverged { step: self.course.loads.step, iterations });
                }
            }
        }
        Err(StepError::NotConverged { step: self.course.loads.step, iterations: MAX_ITERATIONS })
    }

    /// Advances the state to the end of the curves.
    fn advance(&mut self) {
        let (h, n, s) = (self.course.loads.step, self.curves.len(), self.scheme.degree);
        for (index, curve) in self.curves.iter().enumerate() {
            let (mut moment, mut force) = (Vector3::zeros(), Vector3::zeros());
            for (i, chart) in curve.arc.charts.iter().enumerate() {
                let (wrench, weight) = (self.wrenches[i * n + index], h * self.scheme.weights[i]);
                moment += weight * (wrench.moment + chart.turn() * wrench.moment);
                force += weight * wrench.force;
            }
            let xi = &curve.arc.xi[s - 1];
            let momentum = self.course.state.momenta()[index].angular + moment;
            if xi.norm_squared() < LARGE_TURN {
                // The Cayley vector is used because its update preserves steady rotations.
                let turn = xi * half_tangent(xi.norm());
                self.course.state.add_angular(index, &(carried(&turn, &momentum) + moment));
                self.course.state.turn_attitude(index, &turn);
            } else {
                let turn = lie::exp_minus_identity(xi);
                self.course.state.add_angular(index, &(turn.tr_mul(&momentum) + moment));
                self.course.state.add_attitude(index, &(self.course.state.poses()[index].attitude * turn));
            }
            if let Some(shift) = curve.shifts.last() {
                self.course.state.add_position(index, shift);
                self.course.state.add_linear(index, &force);
            }
        }
        if let Some(turn) = self.course.loads.frame_turn() {
            self.course.state.turn_frame(self.course.loads.system.bodies(), &turn);
            let frame = lie::exp(&turn);
            for shift in self.curves.iter_mut().flat_map(|curve| &mut curve.shifts) {
                *shift = frame * *shift;
            }
        }
    }
}

/// Computes the poses of all bodies at quadrature point `i`.
fn place(curves: &[Curve], scheme: &Scheme, state: &SystemState, i: usize, poses: &mut [Pose]) {
    for ((curve, start), pose) in curves.iter().zip(state.poses()).zip(poses) {
        pose.attitude = start.attitude + start.attitude * curve.arc.charts[i].turn();
        pose.position = start.position + combine(&scheme.values[i], &curve.shifts);
    }
}

/// Applies `(mK)⁻¹` in place to the right-hand side of the position of one body.
fn solve_linear(stiffness: &Stiffness, mass: f64, right: &mut [f64]) {
    let mut solution = [Vector3::zeros(); *DEGREES.end()];
    for (nu, solution) in solution.iter_mut().enumerate().take(right.len() / 3) {
        for (mu, row) in right.chunks_exact(3).enumerate() {
            *solution += Vector3::from_column_slice(row) * (stiffness.inverse[(nu, mu)] / mass);
        }
    }
    for (out, solution) in right.chunks_exact_mut(3).zip(&solution) {
        out.copy_from_slice(solution.as_slice());
    }
}

/// Adds the contribution of the potential's gradient at quadrature point `i` to the matrix.
///
/// `δM = rx δy + rr J_r δξ` and `δf = xx δy + xr J_r δξ` enter row ν with
/// `h b (l_ν J_rᵀ − [ν = s] J_r(ξ_s) exp S(ξ))` and `h b (l_ν − [ν = s])`.
fn couple(curves: &[Curve], scheme: &Scheme, h: f64, i: usize, blocks: &[Blocks], matrix: &mut Dense) {
    let (n, s) = (curves.len(), scheme.degree);
    let (values, weight) = (&scheme.values[i], h * scheme.weights[i]);
    for (a, row) in curves.iter().enumerate() {
        let chart = &row.arc.charts[i];
        let j_r_t = chart.j_r.transpose();
        let end_j_r = lie::right_jacobian(&row.arc.xi[s - 1]);
        let end = end_j_r + end_j_r * chart.turn();
        for (b, column) in curves.iter().enumerate() {
            let block = &blocks[a * n + b];
            let j_r = column.arc.charts[i].j_r;
            let (m_xi, f_xi) = (block.rr * j_r, block.xr * j_r);
            for nu in 0..s {
                let last = if nu == s - 1 { 1.0 } else { 0.0 };
                let w_rotation = (j_r_t * values[nu] - end * last) * weight;
                let w_translation = weight * (values[nu] - last);
                for (mu, value) in values.iter().enumerate() {
                    let (angular, linear) = (row.offset + 3 * nu, row.offset + 3 * (s + nu));
                    let (xi, y) = (column.offset + 3 * mu, column.offset + 3 * (s + mu));
                    matrix.add(angular, xi, &(w_rotation * m_xi * *value));
                    if !column.shifts.is_empty() {
                        matrix.add(angular, y, &(w_rotation * block.rx * *value));
                    }
                    if row.shifts.is_empty() {
                        continue;
                    }
                    matrix.add(linear, xi, &(f_xi * (w_translation * value)));
                    if !column.shifts.is_empty() {
                        matrix.add(linear, y, &(block.xx * (w_translation * value)));
                    }
                }
            }
        }
    }
}

impl Method for Galerkin {
    fn advance(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        if !self.posed {
            self.evaluate(inputs);
        }
        self.predict(self.warm);
        if let Err(error) = self.solve(inputs) {
            if !self.warm {
                return Err(error);
            }
            self.predict(false);
            self.solve(inputs)?;
        }
        self.warm = true;
        self.advance();
        self.course.finish()
    }

    fn course(&self) -> &Course {
        &self.course
    }
}
