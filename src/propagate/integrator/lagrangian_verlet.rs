//! Lie–Verlet in Lagrangian form: the discrete Lagrangian map `(x⁻, R⁻; x, R) → (x, R; x⁺, R⁺)`
//! (3.18–3.20, 4.3).
//!
//! ```text
//! F J_d − J_d Fᵀ = J_d F⁻ − F⁻ᵀ J_d + h² S(M + Bu) ,   R⁺ = R F                          (3.19, 3.20)
//! x⁺ = x + Δ ,   Δ = Δ⁻ + (h²/m)(f + B_f u)                                              (3.18)
//! ```
//! Momenta are no part of it; those of the state come from the discrete Legendre transform
//! `hΠ = vee(J_d F⁻ − F⁻ᵀ J_d) + (h²/2) M`, `γ = (m/h) Δ⁻ + (h/2) f`. The first step, which has no step
//! before it, is one of the Hamiltonian form. Where inputs jump at a node, the mean of both sides acts.
//!
//! It is the same map as the Hamiltonian form. What differs is rounding: no sum carries the momentum from
//! step to step, so its rounding is not compensated and in a steady rotation adds up.

use super::drift::Rotor;
use super::system::{Loads, add_inputs};
use super::{Facts, Input, Integrator, Momentum, StepError, System, SystemState, Work};
use crate::mechanics::environment::Wrench;
use crate::numerics::compensated::Sum3;
use crate::{Matrix3, Vector3, lie};

/// Lie–Verlet in pairs of configurations.
#[derive(Clone, Debug)]
pub(super) struct LagrangianVerlet {
    loads: Loads,
    rotors: Vec<Rotor>,
    state: SystemState,
    /// The last step of each body.
    last: Vec<Last>,
    /// The potential's wrenches at the node reached.
    field: Vec<Wrench>,
    /// The same with the inputs on the side of the last step, and of the next one.
    before: Vec<Wrench>,
    after: Vec<Wrench>,
    turns: Vec<Vector3>,
    work: Work,
}

/// How a body got from the node before to the last one.
#[derive(Clone, Debug)]
struct Last {
    /// `F − I`.
    turn: Matrix3,
    /// `Δ`.
    shift: Sum3,
}

impl LagrangianVerlet {
    pub fn new(system: &System, state: &SystemState, step: f64) -> Self {
        let n = system.bodies().len();
        let mut loads = Loads::new(system, step);
        let mut field = vec![Wrench::zero(); n];
        loads.field(state.poses(), &mut field);
        Self {
            loads,
            rotors: Rotor::of(system.bodies(), step),
            state: state.clone(),
            last: vec![Last { turn: Matrix3::zeros(), shift: Sum3::new(Vector3::zeros()) }; n],
            before: field.clone(),
            after: field.clone(),
            field,
            turns: vec![Vector3::zeros(); n],
            work: Work::default(),
        }
    }

    pub fn facts() -> Facts {
        super::lie_verlet::LieVerlet::facts()
    }

    /// `hFᵀΠ̃ = vee(J_d F − FᵀJ_d)` of the last step of a body.
    fn carried(&self, body: usize) -> Vector3 {
        let product = self.loads.system.bodies()[body].inertia.j_d() * self.last[body].turn;
        2.0 * lie::vee(&product)
    }
}

impl Integrator for LagrangianVerlet {
    fn step(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        let h = self.loads.step;
        self.after.copy_from_slice(&self.field);
        add_inputs(inputs, 0.0, &mut self.after);
        for body in 0..self.rotors.len() {
            let momentum = if self.work.steps == 0 {
                self.state.momenta()[body].angular + 0.5 * h * self.after[body].moment
            } else {
                self.carried(body) / h + 0.5 * h * (self.before[body].moment + self.after[body].moment)
            };
            self.turns[body] = self.rotors[body].turn(body, &momentum, &mut self.work.iterations)?;
        }
        for (body, about) in self.loads.system.bodies().iter().enumerate() {
            let last = &mut self.last[body];
            last.turn = lie::cayley_minus_identity(&self.turns[body]);
            self.state.turn_attitude(body, &self.turns[body]);
            let Some(mass) = about.mass else { continue };
            if self.work.steps == 0 {
                let kicked = self.state.momenta()[body].linear + 0.5 * h * self.after[body].force;
                last.shift = Sum3::new(kicked * (h / mass));
            } else {
                let force = self.before[body].force + self.after[body].force;
                last.shift.add(&(force * (0.5 * h * h / mass)));
            }
            self.state.add_position(body, &last.shift.value);
        }
        if let Some(turn) = self.loads.frame_turn() {
            self.state.turn_frame(self.loads.system.bodies(), &turn);
            let turn = lie::exp_minus_identity(&turn);
            self.last.iter_mut().for_each(|last| last.shift.add(&(turn * last.shift.value)));
        }
        self.loads.field(self.state.poses(), &mut self.field);
        self.before.copy_from_slice(&self.field);
        add_inputs(inputs, 1.0, &mut self.before);
        for body in 0..self.rotors.len() {
            let mass = self.loads.system.bodies()[body].mass.unwrap_or(0.0);
            let (shift, kick) = (self.last[body].shift.value, self.before[body]);
            let linear = if mass > 0.0 { shift * (mass / h) + 0.5 * h * kick.force } else { shift };
            let angular = self.carried(body) / h + 0.5 * h * kick.moment;
            self.state.set_momentum(body, Momentum { linear, angular });
        }
        self.work.steps += 1;
        if self.state.is_finite() { Ok(()) } else { Err(StepError::NotFinite) }
    }

    fn state(&self) -> &SystemState {
        &self.state
    }

    fn facts(&self) -> Facts {
        Self::facts()
    }

    fn work(&self) -> Work {
        Work { force_evaluations: self.loads.evaluations, ..self.work }
    }
}
