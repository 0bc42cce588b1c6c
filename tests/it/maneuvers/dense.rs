//! The optimum by another method: every input is an unknown, and only the dynamics and the limits
//! are shared.
//!
//! Sequential quadratic programs in the inputs of a free body with three body torques. The steps
//! solve the implicit equation in the rotation vector, the Jacobian comes from finite differences,
//! each program is solved by a primal-dual interior-point method. No costates, no variations, no
//! law.

use slewkit::maneuver::problem::{Problem, Scheme, State};
use slewkit::{Matrix3, Vector3, lie};

use nalgebra::{DMatrix, DVector, SVector};

/// The discrete problem: state after all steps as a function of all inputs.
pub struct Dense<'a> {
    problem: &'a Problem,
    h: f64,
    weight: Vector3,
    limit: Vector3,
}

impl<'a> Dense<'a> {
    pub fn new(problem: &'a Problem) -> Self {
        let torque = &problem.actuation.torque;
        let weights = problem.objective.weights();
        let weight = weights.torque(&problem.actuation).weight;
        let weight = Vector3::from_iterator(weight.diagonal().iter().copied());
        let limit = Vector3::from_row_slice(torque.limits().size.as_ref().unwrap());
        Self { problem, h: problem.step(), weight, limit }
    }

    fn rows(&self) -> usize {
        self.problem.scheme.input_rows(self.problem.steps)
    }

    /// Returns part of the step for which a row of inputs counts in cost and impulse.
    fn share(&self, row: usize) -> f64 {
        let end = row == 0 || row + 1 == self.rows();
        if self.problem.scheme == Scheme::LieVerlet && end { 0.5 } else { 1.0 }
    }

    /// Returns `f` of `h Π = A(f) Jf + B(f) f×Jf`, `F = exp S(f)`, by Newton with a
    /// finite-difference slope.
    fn rotation(&self, momentum: &Vector3) -> Vector3 {
        let j = self.problem.body.inertia.j();
        let g = momentum * self.h;
        let residual = |f: &Vector3| {
            let angle = f.norm();
            let (a, b) = if angle < 1e-6 {
                (1.0, 0.5)
            } else {
                (angle.sin() / angle, 0.5 * ((0.5 * angle).sin() / (0.5 * angle)).powi(2))
            };
            j * f * a + f.cross(&(j * f)) * b - g
        };
        let mut f = self.problem.body.inertia.j_inverse() * g;
        for _ in 0..20 {
            let mut slope = Matrix3::zeros();
            for column in 0..3 {
                let step = Vector3::ith(column, 1e-6);
                slope.set_column(column, &((residual(&(f + step)) - residual(&(f - step))) / 2e-6));
            }
            f -= slope.lu().solve(&residual(&f)).unwrap();
        }
        assert!(residual(&f).amax() < 1e-13 * g.amax().max(1e-3));
        f
    }

    /// Returns the terminal error of attitude and momentum.
    fn error(&self, inputs: &DVector<f64>) -> SVector<f64, 6> {
        let State { attitude, angular_velocity, .. } = self.problem.start;
        let j = self.problem.body.inertia.j();
        let (mut attitude, mut momentum) = (attitude, j * angular_velocity);
        let impulse = |row: usize| {
            Vector3::new(inputs[3 * row], inputs[3 * row + 1], inputs[3 * row + 2])
                * (self.h * self.share(row))
        };
        let verlet = self.problem.scheme == Scheme::LieVerlet;
        if verlet {
            momentum += impulse(0);
        }
        for step in 0..self.problem.steps {
            let f = lie::exp(&self.rotation(&momentum));
            attitude *= f;
            momentum = f.transpose() * momentum + impulse(step + usize::from(verlet));
        }
        let end = &self.problem.end;
        let turn = lie::log(&(end.attitude.transpose() * attitude));
        let left = momentum - j * end.angular_velocity;
        SVector::from_iterator(turn.iter().chain(left.iter()).copied())
    }

    fn effort(&self) -> DVector<f64> {
        DVector::from_fn(3 * self.rows(), |row, _| self.h * self.share(row / 3) * self.weight[row % 3])
    }

    /// Returns the cheapest inputs near `inputs`, and their cost.
    pub fn solve(&self, mut inputs: DVector<f64>) -> (DVector<f64>, f64) {
        let (effort, count) = (self.effort(), inputs.len());
        let limit = DVector::from_fn(count, |row, _| self.limit[row % 3]);
        let step = 1e-5;
        let mut last = f64::INFINITY;
        for _ in 0..80 {
            let error = self.error(&inputs);
            let mut jacobian = DMatrix::zeros(6, count);
            for column in 0..count {
                let at = |sign: f64| {
                    let mut moved = inputs.clone();
                    moved[column] += sign * step;
                    self.error(&moved)
                };
                jacobian.set_column(column, &((at(1.0) - at(-1.0)) / (2.0 * step)));
            }
            let goal = &jacobian * &inputs - DVector::from_column_slice(error.as_slice());
            let next = program(&effort, &jacobian, &goal, &limit);
            let moved = (&next - &inputs).amax();
            // Halved while the first-order model is far off, and near the end whole.
            inputs = if moved > 0.5 * limit.amax() { (&inputs + next) * 0.5 } else { next };
            if moved < 1e-9 * limit.amax() && moved >= 0.5 * last {
                break;
            }
            last = moved;
        }
        assert!(last < 1e-7 * limit.amax(), "the programs do not converge: {last:e}");
        assert!(self.error(&inputs).amax() < 1e-9);
        let cost = inputs.iter().zip(effort.iter()).map(|(u, w)| 0.5 * w * u * u).sum();
        (inputs, cost)
    }
}

/// Minimises `½ vᵀ diag(d) v` subject to `A v = b`, `|v_i| ≤ limit_i`, by a primal-dual interior
/// point.
fn program(d: &DVector<f64>, a: &DMatrix<f64>, b: &DVector<f64>, limit: &DVector<f64>) -> DVector<f64> {
    let n = d.len();
    let scale = d.component_mul(limit).amax();
    let mut v = DVector::zeros(n);
    let mut y = DVector::zeros(a.nrows());
    let (mut upper, mut lower) = (DVector::repeat(n, scale), DVector::repeat(n, scale));
    for _ in 0..60 {
        let (above, below) = (limit - &v, limit + &v);
        let gap = (above.dot(&upper) + below.dot(&lower)) / (2 * n) as f64;
        let mu = 0.1 * gap;
        let target = |slack: &DVector<f64>| slack.map(|slack| mu / slack);
        let (up, down) = (target(&above), target(&below));
        let diagonal = d + upper.component_div(&above) + lower.component_div(&below);
        let residual = -(d.component_mul(&v) + a.transpose() * &y) - &up + &down;
        let weighed = DMatrix::from_fn(a.nrows(), n, |row, column| a[(row, column)] / diagonal[column]);
        let schur = &weighed * a.transpose();
        let right = &weighed * &residual - (b - a * &v);
        let dy = schur.full_piv_lu().solve(&right).unwrap();
        let dv = (residual - a.transpose() * &dy).component_div(&diagonal);
        let d_upper = &up - &upper + upper.component_mul(&dv).component_div(&above);
        let d_lower = &down - &lower - lower.component_mul(&dv).component_div(&below);
        let longest = |values: &DVector<f64>, changes: &DVector<f64>| {
            let stops = values.iter().zip(changes.iter()).filter(|(_, change)| **change < 0.0);
            stops.map(|(value, change)| -value / change).fold(f64::INFINITY, f64::min)
        };
        let whole = longest(&above, &-&dv)
            .min(longest(&below, &dv))
            .min(longest(&upper, &d_upper))
            .min(longest(&lower, &d_lower));
        let step = (0.99 * whole).min(1.0);
        v += dv * step;
        y += dy * step;
        upper += d_upper * step;
        lower += d_lower * step;
        if gap < 1e-15 * scale * limit.amax() {
            break;
        }
    }
    v
}
