//! The closed-form laws under limits on each input, or on the norm of the output `Bu`.
//!
//! ```text
//! |u_i| ≤ ū_i , W diagonal:   u_i = clip(−b_i·q/w_i, ±ū_i)          S = Σ over the free i of b_i b_iᵀ/w_i
//! |B u| ≤ ū :                 B u = −D q ,  D = V diag(a_i/(1 + ν a_i)) Vᵀ
//!                             ν = 0, or ν > 0 such that |B u| = ū    S = D − D τ τᵀD/(τᵀDτ) , τ = B u
//! ```
//!
//! with `A = B W⁻¹Bᵀ = V diag(a) Vᵀ`. If `A = a I`, the norm bound gives `B u = −ū q/max(ū/a,
//! |q|)`; in general ν is the root of one scalar equation, which Newton's method solves to
//! round-off.

use super::effort::{Effort, unlimited};
use super::{Hamiltonian, Response};
use crate::maneuver::objective::Weighted;
use crate::maneuver::problem::Problem;
use crate::{Matrix3, Vector3};
use thiserror::Error;

/// Law of an actuator set whose inputs are clipped individually.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Clipped(Vec<Input>);

/// One input, scaled by the square root of its weight: `v = √w u`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Input {
    /// Axis of the scaled input, `b/√w`.
    axis: Vector3,
    /// Limit of the scaled input, `√w ū`.
    limit: f64,
}

/// Law whose output is limited to the ball `|B u| ≤ ū`. The authority is `A = V diag(a) Vᵀ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    axes: Matrix3,
    authority: Vector3,
    limit: f64,
}

/// Property of a maneuver that excludes the shooting method.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Obstacle {
    /// Cones, or limits on the angular rate.
    #[error("it has constraints on pointing or angular rate")]
    Constraints,
    /// A free terminal attitude.
    #[error("it leaves the attitude at the end open")]
    OpenEnd,
    /// Reaction wheels, which have a momentum of their own.
    #[error("it has reaction wheels")]
    Wheels,
    /// A limit on the rate of change of an input.
    #[error("it limits how fast an input changes")]
    InputRate,
    /// Limits on each input and also on the norm of their output.
    #[error("it limits both the single inputs and the norm of what they give")]
    TwoLimits,
    /// Individual limits on inputs that are coupled in the effort, because its weight is not
    /// diagonal.
    #[error("it limits single inputs under an effort weight that is not diagonal")]
    CoupledWeight,
    /// A minimum-time or minimum-fuel objective on a uniform grid, which the interior-point method
    /// minimises.
    #[error("it minimises time or fuel on equal steps")]
    EqualSteps,
}

/// Returns why the saturated shooting cannot solve a problem; `None` if it can, with or without
/// limits.
pub fn obstacle(problem: &Problem) -> Option<Obstacle> {
    if !problem.constraints.is_empty() {
        return Some(Obstacle::Constraints);
    }
    if problem.ends_in_any_attitude() {
        return Some(Obstacle::OpenEnd);
    }
    let actuation = &problem.actuation;
    if actuation.wheels.is_some() {
        return Some(Obstacle::Wheels);
    }
    let weights = problem.objective.weights();
    let sets = weights.force(actuation).into_iter().chain([weights.torque(actuation)]);
    sets.into_iter().find_map(|inputs| obstacle_of(&inputs))
}

/// Returns why the limits of an actuator set have no closed-form law; `None` if they have one.
pub(super) fn obstacle_of(inputs: &Weighted) -> Option<Obstacle> {
    let (limits, weight) = (inputs.set.limits(), &inputs.weight);
    if limits.rate.is_some() {
        return Some(Obstacle::InputRate);
    }
    let size = weight.diagonal().amax();
    let coupled = |row: usize, column: usize| row != column && weight[(row, column)].abs() > 1e-14 * size;
    match (&limits.size, limits.norm) {
        (Some(_), Some(_)) => Some(Obstacle::TwoLimits),
        (Some(_), None) if (0..weight.nrows()).any(|i| (0..weight.nrows()).any(|j| coupled(i, j))) => {
            Some(Obstacle::CoupledWeight)
        }
        _ => None,
    }
}

impl Clipped {
    /// Builds the law of an actuator set with a diagonal weight. `sizes[i]` is the limit on input
    /// i.
    pub fn new(inputs: &Weighted, sizes: &[f64]) -> Self {
        let input = |(index, limit): (usize, &f64)| {
            let root = inputs.weight[(index, index)].sqrt();
            Input { axis: inputs.set.axes()[index] / root, limit: root * limit }
        };
        Self(sizes.iter().enumerate().map(input).collect())
    }

    /// Scales the law as [`super::ControlLaw::scaled`] does.
    pub fn scaled(&self, authority: f64, output: f64) -> Self {
        let root = authority.sqrt();
        let scaled = |input: &Input| Input { axis: input.axis * root, limit: input.limit / (root * output) };
        Self(self.0.iter().map(scaled).collect())
    }

    /// Returns the law with every limit multiplied by `factor`.
    pub fn relaxed(&self, factor: f64) -> Self {
        Self(self.0.iter().map(|input| Input { limit: input.limit * factor, ..*input }).collect())
    }
}

impl Hamiltonian for Clipped {
    fn response(&self, costate: &Vector3) -> Response {
        let mut response = Response { output: Vector3::zeros(), cost: 0.0 };
        for input in &self.0 {
            let v = input.value(costate);
            response.output += input.axis * v;
            response.cost += 0.5 * v * v;
        }
        response
    }

    fn slope(&self, costate: &Vector3) -> Matrix3 {
        let free = self.0.iter().filter(|input| input.demand(costate) < 1.0);
        free.fold(Matrix3::zeros(), |slope, input| slope + input.axis * input.axis.transpose())
    }

    fn demand(&self, costate: &Vector3) -> f64 {
        self.0.iter().map(|input| input.demand(costate)).fold(0.0, f64::max)
    }

    fn multipliers(&self, costate: &Vector3) -> Vec<f64> {
        let of = |input: &Input| (input.axis.dot(costate).abs() - input.limit).max(0.0) * input.limit;
        self.0.iter().map(of).collect()
    }

    fn projection_residual(&self, costate: &Vector3) -> f64 {
        let residual = |input: &Input| {
            let v = input.value(costate);
            let gradient = v + input.axis.dot(costate);
            (v - (v - gradient).clamp(-input.limit, input.limit)).abs()
        };
        self.0.iter().map(residual).fold(0.0, larger)
    }

    fn push_inputs(&self, inputs: &Weighted, costate: &Vector3, row: &mut Vec<f64>) {
        let limits = inputs.set.limits().size.iter().flatten();
        row.extend(unlimited(inputs, costate).zip(limits).map(|(input, limit)| input.clamp(-limit, *limit)));
    }
}

impl Input {
    /// Returns the optimal scaled input `v`.
    fn value(&self, costate: &Vector3) -> f64 {
        let free = -self.axis.dot(costate);
        // Not `clamp`: a costate that is not finite must neither cause a panic nor become finite.
        if free > self.limit {
            self.limit
        } else if free < -self.limit {
            -self.limit
        } else {
            free
        }
    }

    /// Returns the ratio of the unlimited optimal input to its limit.
    fn demand(&self, costate: &Vector3) -> f64 {
        self.axis.dot(costate).abs() / self.limit
    }
}

/// Optimum in the ball, in the coordinates of the eigenvectors `V`.
struct InBall {
    /// Output in the coordinates of the eigenvectors, `Vᵀ B u`.
    coordinates: Vector3,
    /// Diagonal of `Vᵀ D V`: the authorities, reduced by the multiplier of the norm limit.
    damped: Vector3,
    /// Multiplier ν of the norm limit.
    multiplier: f64,
}

impl Ball {
    /// Builds the law with the limit `limit` on the norm of the output. `free` is the law without
    /// limits.
    pub fn new(free: &Effort, limit: f64) -> Self {
        let (axes, authority) = eigen(&free.0);
        Self { axes, authority, limit }
    }

    /// Scales the law as [`super::ControlLaw::scaled`] does.
    pub fn scaled(&self, authority: f64, output: f64) -> Self {
        Self { authority: self.authority * authority, limit: self.limit / output, ..*self }
    }

    /// Returns the law with the limit multiplied by `factor`.
    pub fn relaxed(&self, factor: f64) -> Self {
        Self { limit: self.limit * factor, ..*self }
    }

    /// Computes the optimum by Newton's method on `1/|τ(ν)| = 1/ū`, which is concave in ν: from
    /// `ν = 0` the iterates rise to the root and do not pass it except by round-off. For equal `a`
    /// the first step is exact.
    fn at(&self, costate: &Vector3) -> InBall {
        let q = self.axes.tr_mul(costate);
        let at = |multiplier: f64| {
            let damped = self.authority.map(|a| a / (1.0 + multiplier * a));
            InBall { coordinates: -damped.component_mul(&q), damped, multiplier }
        };
        let mut now = at(0.0);
        for _ in 0..Self::ITERATIONS {
            let size = now.coordinates.norm();
            let excess = (size - self.limit) / self.limit;
            // Written so that NaN ends the loop and stays in the output.
            let outside = excess > 4.0 * f64::EPSILON;
            if !outside {
                break;
            }
            let bending = now.coordinates.component_mul(&now.damped).dot(&now.coordinates);
            now = at(now.multiplier + size * size / bending * excess);
        }
        now
    }

    /// Largest number of Newton iterations. It suffices for an unlimited output 1e15 times the
    /// limit, with authorities that differ by a factor of 1e12.
    const ITERATIONS: usize = 100;
}

impl Hamiltonian for Ball {
    fn response(&self, costate: &Vector3) -> Response {
        let at = self.at(costate);
        let price = at.coordinates.zip_map(&self.authority, share);
        Response { output: self.axes * at.coordinates, cost: 0.5 * price.dot(&at.coordinates) }
    }

    fn slope(&self, costate: &Vector3) -> Matrix3 {
        let at = self.at(costate);
        let mut slope = Matrix3::from_diagonal(&at.damped);
        if at.multiplier > 0.0 {
            let pushed = at.damped.component_mul(&at.coordinates);
            slope -= pushed * pushed.transpose() / pushed.dot(&at.coordinates);
        }
        self.axes * slope * self.axes.transpose()
    }

    fn demand(&self, costate: &Vector3) -> f64 {
        let free = self.axes.tr_mul(costate).component_mul(&self.authority);
        free.norm() / self.limit
    }

    fn multipliers(&self, costate: &Vector3) -> Vec<f64> {
        vec![self.at(costate).multiplier * self.limit * self.limit]
    }

    fn projection_residual(&self, costate: &Vector3) -> f64 {
        let at = self.at(costate).coordinates;
        let gradient = at.zip_map(&self.authority, share) + self.axes.tr_mul(costate);
        // The step length is that of the strongest axis; an axis without authority has no step.
        let step = self.authority.map(|a| if a > 0.0 { self.authority.amax() } else { 0.0 });
        let stepped = at - gradient.component_mul(&step);
        (at - stepped * (self.limit / stepped.norm()).min(1.0)).amax()
    }

    fn push_inputs(&self, inputs: &Weighted, costate: &Vector3, row: &mut Vec<f64>) {
        // B u = −A q' for the costate q' = (I + νA)⁻¹ q, and u = −W⁻¹Bᵀ q' has the least effort of
        // all such u.
        let at = self.at(costate);
        let damping = self.authority.map(|a| if a > 0.0 { 1.0 / (1.0 + at.multiplier * a) } else { 0.0 });
        let damped = self.axes * self.axes.tr_mul(costate).component_mul(&damping);
        row.extend(unlimited(inputs, &damped));
    }
}

/// Returns the larger of two numbers, and NaN if either is NaN.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Returns `τ_i/a_i`, the output along an axis divided by its authority; zero if the authority is
/// zero.
fn share(coordinate: f64, authority: f64) -> f64 {
    if authority > 0.0 { coordinate / authority } else { 0.0 }
}

/// Returns the eigenvectors and eigenvalues of a symmetric positive semidefinite matrix.
fn eigen(matrix: &Matrix3) -> (Matrix3, Vector3) {
    // The singular value decomposition has bounded iterations and cannot return a negative value.
    let svd = matrix.svd(true, false);
    let threshold = 1e-14 * svd.singular_values.amax();
    let values = svd.singular_values.map(|value| if value > threshold { value } else { 0.0 });
    (svd.u.unwrap_or_else(Matrix3::identity), values)
}
