//! The saturated control law: the optimal inputs of a channel under limits, where they have a closed form.
//!
//! For a costate `q` in the axes of the channel the optimal inputs minimise a Hamiltonian,
//!
//! ```text
//! u(q) = argmin ½ uᵀWu + q·Bu  over the allowed u ,     K(q) = its value
//! K_q = B u(q) ,     S = −K_qq ≥ 0
//! ```
//!
//! so that state and costates still move by the gradients of one `K`, and the linearisation is its
//! generalised Hessian: Newton on it is semismooth. Without limits `B u = −A q` and `S = A`, with
//! `A = B W⁻¹Bᵀ = V diag(a) Vᵀ`. Two kinds of limits have a law:
//!
//! ```text
//! |u_i| ≤ ū_i , W diagonal:   u_i = clip(−b_i·q/w_i, ±ū_i)          S = Σ over the free i of b_i b_iᵀ/w_i
//! |B u| ≤ ū :                 B u = −D q ,  D = V diag(a_i/(1 + ν a_i)) Vᵀ
//!                             ν = 0, or ν > 0 such that |B u| = ū    S = D − D τ τᵀD/(τᵀDτ) , τ = B u
//! ```
//!
//! Where `A = a I` the norm bound is `B u = −ū q/max(ū/a, |q|)`; in general ν is the root of one scalar
//! equation, which Newton finds to round-off.

use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::ActuatorSet;
use crate::{Matrix3, Vector3};
use nalgebra::DVector;

/// The law of one channel under limits.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ControlLaw {
    /// `|u_i| ≤ ū_i` under a diagonal weight.
    Size(Vec<Input>),
    /// `|B u| ≤ ū`.
    Norm(Ball),
}

/// One input, weighed: `v = √w u`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Input {
    /// `b/√w`.
    axis: Vector3,
    /// `√w ū`.
    limit: f64,
}

/// The ball `|B u| ≤ ū`, and `A = V diag(a) Vᵀ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    axes: Matrix3,
    authority: Vector3,
    limit: f64,
}

/// `B u` and `½ uᵀWu` at the optimal inputs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response {
    pub output: Vector3,
    pub effort: f64,
}

/// Why the saturated shooting cannot take a problem; `None` where it can, limited or not.
pub(crate) fn obstacle(problem: &Problem) -> Option<&'static str> {
    if !problem.constraints.is_empty() {
        return Some("it has constraints on pointing or angular rate");
    }
    let actuation = &problem.actuation;
    if actuation.wheels.is_some() {
        return Some("it has reaction wheels");
    }
    actuation.force.iter().chain([&actuation.torque]).find_map(obstacle_of)
}

/// Why the limits of a channel have no law in closed form.
fn obstacle_of(channel: &ActuatorSet) -> Option<&'static str> {
    let limits = channel.limits();
    if limits.rate.is_some() {
        return Some("it limits how fast an input changes");
    }
    let weight = channel.weight();
    let size = weight.diagonal().amax();
    let coupled = |row: usize, column: usize| row != column && weight[(row, column)].abs() > 1e-14 * size;
    match (&limits.size, limits.norm) {
        (Some(_), Some(_)) => Some("it limits both the single inputs and the norm of what they give"),
        (Some(_), None) if (0..channel.count()).any(|i| (0..channel.count()).any(|j| coupled(i, j))) => {
            Some("it limits single inputs under an effort weight that is not diagonal")
        }
        _ => None,
    }
}

impl ControlLaw {
    /// The law of a channel, in SI units; `None` where it has no limits, or none with a law.
    pub fn of(channel: &ActuatorSet) -> Option<Self> {
        if obstacle_of(channel).is_some() {
            return None;
        }
        let limits = channel.limits();
        if let Some(sizes) = &limits.size {
            let input = |(index, limit): (usize, &f64)| {
                let root = channel.weight()[(index, index)].sqrt();
                Input { axis: channel.axes()[index] / root, limit: root * limit }
            };
            return Some(Self::Size(sizes.iter().enumerate().map(input).collect()));
        }
        limits.norm.map(|limit| {
            let (axes, authority) = eigen(channel.authority());
            Self::Norm(Ball { axes, authority, limit })
        })
    }

    /// The law in units in which `A` is `authority` times as large and an output of `output` is 1.
    pub fn scaled(&self, authority: f64, output: f64) -> Self {
        let root = authority.sqrt();
        match self {
            Self::Size(inputs) => {
                let scaled =
                    |input: &Input| Input { axis: input.axis * root, limit: input.limit / (root * output) };
                Self::Size(inputs.iter().map(scaled).collect())
            }
            Self::Norm(ball) => Self::Norm(Ball {
                authority: ball.authority * authority,
                limit: ball.limit / output,
                ..*ball
            }),
        }
    }

    /// The same law with every limit `factor` times as large.
    pub fn relaxed(&self, factor: f64) -> Self {
        match self {
            Self::Size(inputs) => {
                let relaxed = |input: &Input| Input { limit: input.limit * factor, ..*input };
                Self::Size(inputs.iter().map(relaxed).collect())
            }
            Self::Norm(ball) => Self::Norm(Ball { limit: ball.limit * factor, ..*ball }),
        }
    }

    /// `B u` and the effort for a costate in the axes of the channel.
    pub fn response(&self, costate: &Vector3) -> Response {
        match self {
            Self::Size(inputs) => {
                let mut response = Response { output: Vector3::zeros(), effort: 0.0 };
                for input in inputs {
                    let v = input.value(costate);
                    response.output += input.axis * v;
                    response.effort += 0.5 * v * v;
                }
                response
            }
            Self::Norm(ball) => {
                let at = ball.at(costate);
                let effort = at.coordinates.zip_map(&ball.authority, share);
                Response { output: ball.axes * at.coordinates, effort: 0.5 * effort.dot(&at.coordinates) }
            }
        }
    }

    /// `S`, the generalised derivative of `−B u` with respect to the costate.
    pub fn slope(&self, costate: &Vector3) -> Matrix3 {
        match self {
            Self::Size(inputs) => {
                let free = inputs.iter().filter(|input| input.demand(costate) < 1.0);
                free.fold(Matrix3::zeros(), |slope, input| slope + input.axis * input.axis.transpose())
            }
            Self::Norm(ball) => {
                let at = ball.at(costate);
                let mut slope = Matrix3::from_diagonal(&at.damped);
                if at.multiplier > 0.0 {
                    let pushed = at.damped.component_mul(&at.coordinates);
                    slope -= pushed * pushed.transpose() / pushed.dot(&at.coordinates);
                }
                ball.axes * slope * ball.axes.transpose()
            }
        }
    }

    /// How many times its limit the largest input would be without it.
    pub fn demand(&self, costate: &Vector3) -> f64 {
        match self {
            Self::Size(inputs) => inputs.iter().map(|input| input.demand(costate)).fold(0.0, f64::max),
            Self::Norm(ball) => {
                let free = ball.axes.tr_mul(costate).component_mul(&ball.authority);
                free.norm() / ball.limit
            }
        }
    }

    /// The multipliers of the limits, one per input or one for the norm: how fast `K` falls when the limit
    /// grows, `−∂K/∂ ln ū`.
    pub fn multipliers(&self, costate: &Vector3) -> Vec<f64> {
        match self {
            Self::Size(inputs) => inputs
                .iter()
                .map(|input| (input.axis.dot(costate).abs() - input.limit).max(0.0) * input.limit)
                .collect(),
            Self::Norm(ball) => vec![ball.at(costate).multiplier * ball.limit * ball.limit],
        }
    }

    /// How far the inputs are from their own projection after a step against the gradient: zero where the
    /// conditions of Karush, Kuhn and Tucker hold.
    pub fn projection_residual(&self, costate: &Vector3) -> f64 {
        match self {
            Self::Size(inputs) => {
                let residual = |input: &Input| {
                    let v = input.value(costate);
                    let gradient = v + input.axis.dot(costate);
                    (v - (v - gradient).clamp(-input.limit, input.limit)).abs()
                };
                inputs.iter().map(residual).fold(0.0, larger)
            }
            Self::Norm(ball) => {
                let at = ball.at(costate).coordinates;
                let gradient = at.zip_map(&ball.authority, share) + ball.axes.tr_mul(costate);
                // A step as long as the strongest axis allows; none along an axis without authority.
                let step = ball.authority.map(|a| if a > 0.0 { ball.authority.amax() } else { 0.0 });
                let stepped = at - gradient.component_mul(&step);
                (at - stepped * (ball.limit / stepped.norm()).min(1.0)).amax()
            }
        }
    }

    /// The inputs themselves; `channel` is that of the law, and law and costate are in SI units.
    pub fn inputs(&self, channel: &ActuatorSet, costate: &Vector3) -> DVector<f64> {
        match (self, &channel.limits().size) {
            (Self::Size(_), Some(limits)) => {
                let free = channel.optimal_inputs(costate);
                DVector::from_fn(free.len(), |row, _| free[row].clamp(-limits[row], limits[row]))
            }
            (Self::Norm(ball), _) => {
                // B u = −A q' for the costate q' = (I + νA)⁻¹ q, and u = −W⁻¹Bᵀ q' is the cheapest such u.
                let at = ball.at(costate);
                let damping =
                    ball.authority.map(|a| if a > 0.0 { 1.0 / (1.0 + at.multiplier * a) } else { 0.0 });
                let effective = ball.axes * ball.axes.tr_mul(costate).component_mul(&damping);
                channel.optimal_inputs(&effective)
            }
            (Self::Size(_), None) => channel.optimal_inputs(costate),
        }
    }
}

impl Input {
    /// `v` at the optimum.
    fn value(&self, costate: &Vector3) -> f64 {
        let free = -self.axis.dot(costate);
        // Not `clamp`: a costate that is not finite must not end in a panic, nor become finite.
        if free > self.limit {
            self.limit
        } else if free < -self.limit {
            -self.limit
        } else {
            free
        }
    }

    /// `|v|/limit` without the limit.
    fn demand(&self, costate: &Vector3) -> f64 {
        self.axis.dot(costate).abs() / self.limit
    }
}

/// The optimum in a ball, in the coordinates of its axes.
struct InBall {
    /// `Vᵀ B u`.
    coordinates: Vector3,
    /// The diagonal of `Vᵀ D V`.
    damped: Vector3,
    /// ν.
    multiplier: f64,
}

impl Ball {
    /// Newton on `1/|τ(ν)| = 1/ū`, which is concave in ν: from ν = 0 it rises to the root and never passes
    /// it but for round-off. For equal `a` the first step is exact.
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
            // Written so that NaN ends the loop, and stays in the output.
            let outside = excess > 4.0 * f64::EPSILON;
            if !outside {
                break;
            }
            let bending = now.coordinates.component_mul(&now.damped).dot(&now.coordinates);
            now = at(now.multiplier + size * size / bending * excess);
        }
        now
    }

    /// Enough for a demand of 1e15 over authorities that differ by 1e12.
    const ITERATIONS: usize = 100;
}

/// The larger of two numbers, and NaN of any with NaN.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// `τ_i/a_i`, zero along an axis without authority.
fn share(coordinate: f64, authority: f64) -> f64 {
    if authority > 0.0 { coordinate / authority } else { 0.0 }
}

/// Axes and eigenvalues of a symmetric positive semidefinite matrix.
fn eigen(matrix: &Matrix3) -> (Matrix3, Vector3) {
    // The singular value decomposition is bounded in iterations and cannot give a negative value.
    let svd = matrix.svd(true, false);
    let threshold = 1e-14 * svd.singular_values.amax();
    let values = svd.singular_values.map(|value| if value > threshold { value } else { 0.0 });
    (svd.u.unwrap_or_else(Matrix3::identity), values)
}

#[cfg(test)]
mod tests;
