//! An independent implementation of one step for any number type: fields, drift and kick.
//!
//! It uses nothing of the code under test except its scaled constants. The implicit equation is
//! solved by Newton's method in the number type itself, so that dual numbers carry exact
//! derivatives through it.

use crate::optimize::discrete::step::Dynamics;
use crate::{Matrix3, Vector3};
use nalgebra as na;
use num_dual::{Dual, Dual64, DualNum};

/// Number type that may carry derivatives.
pub trait Number: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

pub type V<D> = na::Vector3<D>;
pub type M<D> = na::Matrix3<D>;

pub fn vector<D: Number>(v: &Vector3) -> V<D> {
    v.map(D::from)
}

pub fn matrix<D: Number>(m: &Matrix3) -> M<D> {
    m.map(D::from)
}

pub fn hat<D: Number>(a: &V<D>) -> M<D> {
    let o = D::from(0.0);
    M::new(o, -a.z, a.y, a.z, o, -a.x, -a.y, a.x, o)
}

fn vee<D: Number>(m: &M<D>) -> V<D> {
    V::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]) * D::from(0.5)
}

/// Force field, in SI units.
#[derive(Clone, Debug)]
pub enum Field {
    Free,
    /// Pendulum: `m g ρ`, and the direction of gravity.
    Pendulum(Vector3, Vector3),
    /// Gravity gradient: `3n²J`, and the outward direction.
    GravityGradient(Matrix3, Vector3),
    /// Cloud of mass points: `μ m` and position of each point.
    Cloud(Vec<(f64, Vector3)>),
    /// Second-order gravity field: `μ`, `m`, `J`.
    SecondOrder(f64, f64, Matrix3),
}

impl Field {
    /// Returns force and moment at a pose.
    fn wrench<D: Number>(&self, x: &V<D>, r: &M<D>) -> (V<D>, V<D>) {
        let zero = V::from_element(D::from(0.0));
        match self {
            Self::Free => (zero, zero),
            Self::Pendulum(arm, fall) => (zero, vector(arm).cross(&(r.transpose() * vector(fall)))),
            Self::GravityGradient(stiffness, outward) => {
                let g = r.transpose() * vector(outward);
                (zero, g.cross(&(matrix(stiffness) * g)))
            }
            Self::Cloud(points) => points.iter().fold((zero, zero), |(force, moment), (k, rho)| {
                let rho = vector(rho);
                let y = x + r * rho;
                let distance = y.dot(&y).sqrt();
                let f = y * (D::from(-*k) / (distance * distance * distance));
                (force + f, moment + rho.cross(&(r.transpose() * f)))
            }),
            Self::SecondOrder(mu, mass, j) => {
                let (mu, mass, j) = (D::from(*mu), D::from(*mass), matrix::<D>(j));
                let r2 = x.dot(x);
                let distance = r2.sqrt();
                let e = r.transpose() * x / distance;
                let je = j * e;
                let spread = j.trace() - e.dot(&je) * 5.0;
                let tidal = r * e * spread + r * je * D::from(2.0);
                let force = -(x * (mu * mass / (r2 * distance))) - tidal * (mu * 1.5 / (r2 * r2));
                (force, e.cross(&je) * (mu * 3.0 / (r2 * distance)))
            }
        }
    }
}

/// State of this implementation, in scaled units.
#[derive(Clone, Copy, Debug)]
pub struct State<D: Number> {
    pub x: V<D>,
    pub gamma: V<D>,
    pub r: M<D>,
    pub pi: V<D>,
}

impl<D: Number> State<D> {
    pub fn of(point: &crate::optimize::discrete::step::Point) -> Self {
        Self {
            x: vector(&point.position.value),
            gamma: vector(&point.linear_momentum.value),
            r: matrix(&point.attitude.value),
            pi: vector(&point.momentum.value),
        }
    }

    /// Returns the state after a displacement `step` along the tangent direction `index` of `N`;
    /// exact for infinitesimal displacements.
    pub fn moved<const N: usize>(mut self, index: usize, step: D) -> Self {
        let block = if N == 6 { index / 3 + 2 } else { index / 3 };
        let mut e = V::from_element(D::from(0.0));
        e[index % 3] = step;
        match block {
            0 => self.x += e,
            1 => self.gamma += e,
            2 => self.r += self.r * hat(&e),
            _ => self.pi += e,
        }
        self
    }
}

/// Returns the left-trivialised derivative of a state with respect to the outermost dual part.
pub fn tangent<const N: usize, D: Number>(state: &State<Dual<D>>) -> na::SVector<D, N>
where
    Dual<D>: Number,
{
    let r = state.r.map(|value| value.re);
    let zeta = vee(&(r.transpose() * state.r.map(|value| value.eps)));
    na::SVector::from_fn(|row, _| {
        let block = if N == 6 { row / 3 + 2 } else { row / 3 };
        match block {
            0 => state.x[row % 3].eps,
            1 => state.gamma[row % 3].eps,
            2 => zeta[row % 3],
            _ => state.pi[row % 3].eps,
        }
    })
}

/// Second implementation of a [`Dynamics`] in its scaled units, with its field implemented again in
/// SI.
#[derive(Clone, Debug)]
pub struct Twin<'a> {
    pub dynamics: &'a Dynamics,
    pub field: Field,
    /// Index of the step of the grid that is differentiated.
    pub step: usize,
}

impl Twin<'_> {
    /// Computes `F` of `h S(Π) = F J_d − J_d Fᵀ`, by Newton's method on `F = exp S(f)` in Cayley
    /// coordinates.
    fn relative<D: Number>(&self, step: usize, pi: &V<D>) -> M<D> {
        let (g, j) = (pi * D::from(self.dynamics.grid.step(step)), matrix::<D>(&self.dynamics.j));
        let mut c = matrix::<D>(&self.dynamics.j_inverse) * g * D::from(0.5);
        // Each iteration doubles the correct digits of the value; each order of derivative lags by
        // one iteration.
        for _ in 0..12 {
            let gc = g.dot(&c);
            let residual = g + g.cross(&c) + c * gc - j * c * D::from(2.0);
            let slope = hat(&g) + M::from_diagonal_element(gc) + c * g.transpose() - j * D::from(2.0);
            c -= inverse(&slope) * residual;
        }
        let (s, one) = (hat(&c), M::from_diagonal_element(D::from(1.0)));
        one + (s + s * s) * (D::from(2.0) / (c.dot(&c) + 1.0))
    }

    /// Computes the drift on step `step` of the grid.
    pub fn drift<D: Number>(&self, step: usize, state: &State<D>) -> State<D> {
        let f = self.relative(step, &state.pi);
        let mut r = state.r * f;
        if let Some(turn) = self.dynamics.frame_turn(step) {
            r = (matrix::<D>(turn) + M::from_diagonal_element(D::from(1.0))) * r;
        }
        State {
            x: state.x + state.gamma * D::from(self.dynamics.grid.step(step)),
            r,
            pi: f.transpose() * state.pi,
            ..*state
        }
    }

    /// Returns force and moment of the field, scaled.
    fn field<D: Number>(&self, state: &State<D>) -> (V<D>, V<D>) {
        let units = &self.dynamics.units;
        let (force, moment) = self.field.wrench(&(state.x * D::from(units.length)), &state.r);
        (force / D::from(units.force()), moment / D::from(units.torque()))
    }

    /// Adds the impulses of the field and of given actuator force and torque, each in its own axes.
    pub fn kick<D: Number>(&self, state: &mut State<D>, weight: f64, force: &V<D>, torque: &V<D>) {
        use crate::mechanics::actuators::AxisFrame::{Body, Reference};
        let (field_force, field_moment) = self.field(state);
        let torque = match self.dynamics.torque.frame {
            Body => *torque,
            Reference => state.r.transpose() * torque,
        };
        let force = match self.dynamics.force.frame {
            Body => state.r * force,
            Reference => *force,
        };
        state.gamma += (field_force + force) * D::from(weight);
        state.pi += (field_moment + torque) * D::from(weight);
    }

    /// Returns the optimal force and torque for the costates `(λ^γ, λ^Π)`, each in its own axes.
    pub fn optimal<D: Number>(&self, state: &State<D>, gamma: &V<D>, pi: &V<D>) -> (V<D>, V<D>) {
        use crate::mechanics::actuators::AxisFrame::{Body, Reference};
        let gamma = if self.dynamics.force.frame == Body { state.r.transpose() * gamma } else { *gamma };
        let pi = if self.dynamics.torque.frame == Reference { state.r * pi } else { *pi };
        (-(matrix(&self.dynamics.force.matrix) * gamma), -(matrix(&self.dynamics.torque.matrix) * pi))
    }

    /// Computes one step under the optimal inputs of the fixed costate `λ = (.., λ^γ, .., λ^Π)`.
    pub fn step<const N: usize, D: Number>(
        &self,
        state: &State<D>,
        costate: &na::SVector<f64, N>,
    ) -> State<D> {
        let mut after = self.drift(self.step, state);
        let (gamma, pi) = duals::<N, D>(costate);
        let (force, torque) = self.optimal(&after, &gamma, &pi);
        self.kick(&mut after, self.dynamics.grid.full_kick(self.step + 1), &force, &torque);
        after
    }

    /// Returns `λ · (step)` plus the effort of the optimal inputs; its gradient is the costate
    /// before the step.
    ///
    /// The configuration part of the product is linear only in variations: the caller adds it.
    fn hamiltonian<const N: usize, D: Number>(&self, drifted: &State<D>, costate: &na::SVector<f64, N>) -> D {
        let (gamma, pi) = duals::<N, D>(costate);
        let (force, torque) = self.optimal(drifted, &gamma, &pi);
        let mut kicked = *drifted;
        let weight = self.dynamics.grid.full_kick(self.step + 1);
        self.kick(&mut kicked, weight, &(force * D::from(0.5)), &(torque * D::from(0.5)));
        let linear = if N == 12 { kicked.gamma.dot(&gamma) } else { D::from(0.0) };
        kicked.pi.dot(&pi) + linear
    }

    /// Returns `A`, the derivative of [`Twin::step`] with respect to the state.
    pub fn a<const N: usize>(
        &self,
        point: &crate::optimize::discrete::step::Point,
        costate: &na::SVector<f64, N>,
    ) -> na::SMatrix<f64, N, N> {
        let mut a = na::SMatrix::<f64, N, N>::zeros();
        for column in 0..N {
            let state = State::<Dual64>::of(point).moved::<N>(column, Dual::new(0.0, 1.0));
            a.set_column(column, &tangent::<N, f64>(&self.step(&state, costate)));
        }
        a
    }

    /// Returns `λ_{k−1}` for `λ_k`, as a function of the state: the gradient of `λ · step`, by an
    /// outer dual part.
    fn costate_before<const N: usize, D: Number>(
        &self,
        state: &State<D>,
        costate: &na::SVector<f64, N>,
    ) -> na::SVector<D, N>
    where
        Dual<D>: Number,
    {
        na::SVector::from_fn(|row, _| {
            let lift = |value: D| Dual::new(value, D::from(0.0));
            let state = State::<Dual<D>> {
                x: state.x.map(lift),
                gamma: state.gamma.map(lift),
                r: state.r.map(lift),
                pi: state.pi.map(lift),
            };
            let step = Dual::new(D::from(0.0), D::from(1.0));
            let drifted = self.drift(self.step, &state.moved::<N>(row, step));
            let z = tangent::<N, D>(&drifted);
            let mut sum = self.hamiltonian(&drifted, costate).eps;
            for index in (0..N).filter(|index| index % 6 < 3) {
                sum += z[index] * costate[index];
            }
            sum
        })
    }

    /// Returns the costate `λ_{k−1}` before the step, and the curvature `H`.
    pub fn h<const N: usize>(
        &self,
        point: &crate::optimize::discrete::step::Point,
        costate: &na::SVector<f64, N>,
    ) -> (na::SVector<f64, N>, na::SMatrix<f64, N, N>) {
        let mut h = na::SMatrix::<f64, N, N>::zeros();
        for column in 0..N {
            let state = State::<Dual64>::of(point).moved::<N>(column, Dual::new(0.0, 1.0));
            let before = self.costate_before(&state, costate);
            h.set_column(column, &before.map(|value| value.eps));
        }
        (self.costate_before(&State::<f64>::of(point), costate), h)
    }
}

fn duals<const N: usize, D: Number>(costate: &na::SVector<f64, N>) -> (V<D>, V<D>) {
    let part = |row: usize| V::from_fn(|i, _| D::from(costate[row + i]));
    (if N == 12 { part(3) } else { V::from_element(D::from(0.0)) }, part(N - 3))
}

fn inverse<D: Number>(m: &M<D>) -> M<D> {
    let (a, b, c) = (m.column(0).into_owned(), m.column(1).into_owned(), m.column(2).into_owned());
    let rows = [b.cross(&c).transpose(), c.cross(&a).transpose(), a.cross(&b).transpose()];
    M::from_rows(&rows) / a.dot(&b.cross(&c))
}
