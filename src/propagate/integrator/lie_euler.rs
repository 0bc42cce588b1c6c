//! Lie–Euler, both variants: first order, symplectic, adjoint to each other (4.5–4.7).
//!
//! ```text
//! L_d = (1/h) tr[(I−F) J_d] + (m/2h)|x⁺−x|² − h U(x⁺, R⁺)         − h U(x, R) for the adjoint
//!
//! drift, then kick                            kick, then drift (adjoint)
//! h S(Π) = F J_d − J_d Fᵀ                     h S(Π + hM) = F J_d − J_d Fᵀ
//! R⁺ = R F ,  x⁺ = x + (h/m) γ                R⁺ = R F ,  x⁺ = x + (h/m)(γ + hf)
//! Π⁺ = FᵀΠ + h (M⁺ + Bu⁺)                     Π⁺ = Fᵀ(Π + h (M + Bu))
//! γ⁺ = γ + h (f⁺ + B_f u⁺)                    γ⁺ = γ + h (f + B_f u)
//! ```
//! Inputs act at the end of the step, for the adjoint at its start. With `Π̃ = Π + (h/2) M` either one is
//! Lie–Verlet in other variables: their error is the missing half kick at the ends, and does not grow.

use super::drift::{Rotor, carried};
use super::system::{Loads, add_inputs};
use super::{Facts, Input, Integrator, StepError, System, SystemState, Work};
use crate::Vector3;
use crate::mechanics::environment::Wrench;

/// Lie–Euler, drift then kick, or its adjoint.
#[derive(Clone, Debug)]
pub(super) struct LieEuler {
    loads: Loads,
    rotors: Vec<Rotor>,
    state: SystemState,
    wrenches: Vec<Wrench>,
    /// Cayley vector of each body's step.
    turns: Vec<Vector3>,
    kick_first: bool,
    work: Work,
}

impl LieEuler {
    pub fn new(system: &System, state: &SystemState, step: f64, kick_first: bool) -> Self {
        let n = system.bodies().len();
        Self {
            loads: Loads::new(system, step),
            rotors: Rotor::of(system.bodies(), step),
            state: state.clone(),
            wrenches: vec![Wrench::zero(); n],
            turns: vec![Vector3::zeros(); n],
            kick_first,
            work: Work::default(),
        }
    }

    pub fn facts() -> Facts {
        Facts {
            order: 1,
            explicit: true,
            symplectic: true,
            preserves_momentum: true,
            preserves_group: true,
            force_evaluations: Some(1),
        }
    }
}

impl Integrator for LieEuler {
    fn step(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        let h = self.loads.step;
        if self.kick_first {
            self.loads.total(0.0, self.state.poses(), inputs, &mut self.wrenches);
        } else {
            self.wrenches.fill(Wrench::zero());
        }
        // All turns before any change: a step that fails leaves the state as it was.
        for (body, rotor) in self.rotors.iter_mut().enumerate() {
            let momentum = self.state.momenta()[body].angular + h * self.wrenches[body].moment;
            self.turns[body] = rotor.turn(body, &momentum, &mut self.work.iterations)?;
        }
        for (body, about) in self.loads.system.bodies().iter().enumerate() {
            let (impulse, momentum) = (self.wrenches[body], self.state.momenta()[body]);
            let change = carried(&self.turns[body], &(momentum.angular + h * impulse.moment));
            self.state.add_angular(body, &(change + h * impulse.moment));
            self.state.turn_attitude(body, &self.turns[body]);
            if let Some(mass) = about.mass {
                self.state.add_position(body, &((momentum.linear + h * impulse.force) * (h / mass)));
                self.state.add_linear(body, &(h * impulse.force));
            }
        }
        if let Some(turn) = self.loads.frame_turn() {
            self.state.turn_frame(self.loads.system.bodies(), &turn);
        }
        if !self.kick_first && !self.loads.is_free(inputs) {
            self.loads.field(self.state.poses(), &mut self.wrenches);
            add_inputs(inputs, 1.0, &mut self.wrenches);
            self.state.kick(self.loads.system.bodies(), h, &self.wrenches)?;
        }
        self.work.steps += 1;
        Ok(())
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
