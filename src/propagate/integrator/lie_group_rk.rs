//! Explicit Runge–Kutta methods on the group: Crouch–Grossman (LGM) and Runge–Kutta–Munthe-Kaas.
//!
//! ```text
//! Crouch–Grossman   R_i = R exp S(h a_i1 Ω_1) exp S(h a_i2 Ω_2) …      R⁺ = R exp S(h b_1 Ω_1) …
//! Munthe-Kaas       R_i = R exp S(σ_i) ,  σ_i = h Σ a_ij σ'_j ,  σ'_j = J_r⁻¹(σ_j) Ω_j
//!                   R⁺ = R exp S(h Σ b_j σ'_j)
//! ```
//! Momenta and positions follow the Runge–Kutta method of the same tableau. Attitudes stay
//! rotations; energy and momenta drift.

use super::course::{Course, Method};
use super::tableau::Tableau;
use super::{Input, Momentum, StepError};
use crate::mechanics::environment::{Pose, Wrench};
use crate::{Matrix3, Vector3, lie};

/// The way in which the rotations of the stages are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Composition {
    CrouchGrossman,
    MuntheKaas,
}

/// Rates of change of one body at one stage: turn, angular momentum, position and linear momentum.
#[derive(Clone, Copy, Debug)]
struct Rates {
    /// Angular velocity `Ω`, or its image `σ'` in the chart.
    turn: Vector3,
    angular: Vector3,
    velocity: Vector3,
    linear: Vector3,
}

/// A Runge–Kutta method on the group.
#[derive(Clone, Debug)]
pub(super) struct LieGroupRk {
    course: Course,
    tableau: Tableau,
    composition: Composition,
    /// Rates of change, one row of bodies per stage.
    rates: Vec<Vec<Rates>>,
    poses: Vec<Pose>,
    momenta: Vec<Momentum>,
    /// Rotation vector σ of each body at a stage.
    sigmas: Vec<Vector3>,
    wrenches: Vec<Wrench>,
}

impl LieGroupRk {
    pub fn new(course: Course, tableau: Tableau, composition: Composition) -> Self {
        let n = course.count();
        let zero = Vector3::zeros();
        let rates = Rates { turn: zero, angular: zero, velocity: zero, linear: zero };
        Self {
            tableau: tableau.checked(),
            composition,
            rates: vec![vec![rates; n]; tableau.c.len()],
            poses: course.state.poses().to_vec(),
            momenta: course.state.momenta().to_vec(),
            sigmas: vec![zero; n],
            wrenches: vec![Wrench::zero(); n],
            course,
        }
    }

    /// Returns the change of a body that the stages give with `weights`: `F − I`, the rotation
    /// vector σ, and the weighted sums of the rates.
    fn change(&self, body: usize, weights: &[f64]) -> (Matrix3, Vector3, Rates) {
        let h = self.course.loads.step;
        let (mut turn, mut sigma) = (Matrix3::zeros(), Vector3::zeros());
        let (mut angular, mut velocity, mut linear) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        for (weight, rates) in weights.iter().zip(&self.rates) {
            let (weight, rates) = (h * weight, &rates[body]);
            angular += weight * rates.angular;
            velocity += weight * rates.velocity;
            linear += weight * rates.linear;
            match self.composition {
                Composition::MuntheKaas => sigma += weight * rates.turn,
                Composition::CrouchGrossman if weight.abs() > 0.0 => {
                    // (I + T)(I + E) = I + T + E + TE
                    let factor = lie::exp_minus_identity(&(weight * rates.turn));
                    turn += factor + turn * factor;
                }
                Composition::CrouchGrossman => {}
            }
        }
        if self.composition == Composition::MuntheKaas {
            turn = lie::exp_minus_identity(&sigma);
        }
        (turn, sigma, Rates { turn: sigma, angular, velocity, linear })
    }
}

impl Method for LieGroupRk {
    fn advance(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        let n = self.poses.len();
        let free = self.course.loads.is_free(inputs);
        for stage in 0..self.rates.len() {
            for body in 0..n {
                let (turn, sigma, change) = self.change(body, self.tableau.a[stage]);
                let (pose, momentum) = (self.course.state.poses()[body], self.course.state.momenta()[body]);
                self.sigmas[body] = sigma;
                self.poses[body] = Pose {
                    position: pose.position + change.velocity,
                    attitude: pose.attitude + pose.attitude * turn,
                };
                self.momenta[body] = Momentum {
                    linear: momentum.linear + change.linear,
                    angular: momentum.angular + change.angular,
                };
            }
            if !free {
                self.course.loads.total(self.tableau.c[stage], &self.poses, inputs, &mut self.wrenches);
            }
            for (index, body) in self.course.loads.system.bodies().iter().enumerate() {
                let (momentum, wrench) = (self.momenta[index], self.wrenches[index]);
                let rate = body.inertia.j_inverse() * momentum.angular;
                let turn = match self.composition {
                    Composition::CrouchGrossman => rate,
                    Composition::MuntheKaas => lie::right_jacobian_inverse(&self.sigmas[index]) * rate,
                };
                let zero = Vector3::zeros();
                self.rates[stage][index] = Rates {
                    turn,
                    angular: momentum.angular.cross(&rate) + wrench.moment,
                    velocity: body.mass.map_or(zero, |mass| momentum.linear / mass),
                    linear: if body.mass.is_some() { wrench.force } else { zero },
                };
            }
        }
        for body in 0..n {
            let (turn, _, change) = self.change(body, self.tableau.b);
            self.course.state.add_attitude(body, &(self.course.state.poses()[body].attitude * turn));
            self.course.state.add_angular(body, &change.angular);
            self.course.state.add_position(body, &change.velocity);
            self.course.state.add_linear(body, &change.linear);
        }
        self.course.turn_frame();
        self.course.finish()
    }

    fn course(&self) -> &Course {
        &self.course
    }
}
