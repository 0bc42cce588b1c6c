//! Explicit Runge–Kutta methods on the group: Crouch–Grossman (LGM) and Runge–Kutta–Munthe-Kaas.
//!
//! ```text
//! Crouch–Grossman   R_i = R exp S(h a_i1 Ω_1) exp S(h a_i2 Ω_2) …      R⁺ = R exp S(h b_1 Ω_1) …
//! Munthe-Kaas       R_i = R exp S(σ_i) ,  σ_i = h Σ a_ij σ'_j ,  σ'_j = J_r⁻¹(σ_j) Ω_j
//!                   R⁺ = R exp S(h Σ b_j σ'_j)
//! ```
//! Momenta and positions as in the Runge–Kutta method of the same tableau. Attitudes stay rotations; energy
//! and momenta drift.

use super::system::Loads;
use super::tableau::Tableau;
use super::{Facts, Input, Integrator, Momentum, StepError, System, SystemState, Work};
use crate::mechanics::environment::{Pose, Wrench};
use crate::{Matrix3, Vector3, lie};

/// How stages are put together on the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Composition {
    CrouchGrossman,
    MuntheKaas,
}

/// Rates of change of one body at one stage.
#[derive(Clone, Copy, Debug)]
struct Rates {
    /// `Ω`, or `σ'` in the chart.
    turn: Vector3,
    angular: Vector3,
    velocity: Vector3,
    linear: Vector3,
}

/// A Runge–Kutta method on the group.
#[derive(Clone, Debug)]
pub(super) struct LieGroupRk {
    loads: Loads,
    state: SystemState,
    tableau: Tableau,
    composition: Composition,
    /// One row of bodies per stage.
    rates: Vec<Vec<Rates>>,
    poses: Vec<Pose>,
    momenta: Vec<Momentum>,
    /// Rotation vector σ of each body at a stage.
    sigmas: Vec<Vector3>,
    wrenches: Vec<Wrench>,
    work: Work,
}

impl LieGroupRk {
    pub fn new(
        system: &System,
        state: &SystemState,
        step: f64,
        tableau: Tableau,
        composition: Composition,
    ) -> Self {
        let n = system.bodies().len();
        let zero = Vector3::zeros();
        let rates = Rates { turn: zero, angular: zero, velocity: zero, linear: zero };
        Self {
            loads: Loads::new(system, step),
            state: state.clone(),
            tableau: tableau.checked(),
            composition,
            rates: vec![vec![rates; n]; tableau.c.len()],
            poses: state.poses().to_vec(),
            momenta: state.momenta().to_vec(),
            sigmas: vec![zero; n],
            wrenches: vec![Wrench::zero(); n],
            work: Work::default(),
        }
    }

    pub fn facts(tableau: &Tableau) -> Facts {
        Facts {
            order: tableau.order,
            explicit: true,
            symplectic: false,
            preserves_momentum: false,
            preserves_group: true,
            force_evaluations: Some(tableau.c.len() as u32),
        }
    }

    /// What a body has changed by with these weights: `F − I`, σ, and the sums of the rates.
    fn change(&self, body: usize, weights: &[f64]) -> (Matrix3, Vector3, Rates) {
        let h = self.loads.step;
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

impl Integrator for LieGroupRk {
    fn step(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        let n = self.poses.len();
        let free = self.loads.is_free(inputs);
        for stage in 0..self.rates.len() {
            for body in 0..n {
                let (turn, sigma, change) = self.change(body, self.tableau.a[stage]);
                let (pose, momentum) = (self.state.poses()[body], self.state.momenta()[body]);
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
                self.loads.total(self.tableau.c[stage], &self.poses, inputs, &mut self.wrenches);
            }
            for (index, body) in self.loads.system.bodies().iter().enumerate() {
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
            self.state.add_attitude(body, &(self.state.poses()[body].attitude * turn));
            self.state.add_angular(body, &change.angular);
            self.state.add_position(body, &change.velocity);
            self.state.add_linear(body, &change.linear);
        }
        if let Some(turn) = self.loads.frame_turn() {
            self.state.turn_frame(self.loads.system.bodies(), &turn);
        }
        self.work.steps += 1;
        if self.state.is_finite() { Ok(()) } else { Err(StepError::NotFinite) }
    }

    fn state(&self) -> &SystemState {
        &self.state
    }

    fn facts(&self) -> Facts {
        Self::facts(&self.tableau)
    }

    fn work(&self) -> Work {
        Work { force_evaluations: self.loads.evaluations, ..self.work }
    }
}
