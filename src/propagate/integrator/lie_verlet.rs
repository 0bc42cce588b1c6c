//! Lie velocity Verlet in Hamiltonian form: second order, symplectic, one evaluation a step
//! (2.4, 3.22–3.26).
//!
//! ```text
//! L_d = (1/h) tr[(I−F) J_d] + (m/2h)|x⁺−x|² − (h/2)(U + U⁺)
//!
//! p = Π + (h/2)(M + Bu) ,   q = γ + (h/2)(f + B_f u)
//! h S(p) = F J_d − J_d Fᵀ                       implicit, one body at a time
//! R⁺ = R F ,   x⁺ = x + (h/m) q                                                          (3.26, 3.22)
//! Π⁺ = Fᵀp + (h/2)(M⁺ + Bu⁺) ,   γ⁺ = q + (h/2)(f⁺ + B_f u⁺)                             (3.25, 3.23)
//! ```
//! The potential at the end of a step is that of the next one's start, and is kept.

use super::drift::{Rotor, carried};
use super::system::{Loads, add_inputs};
use super::{Facts, Input, Integrator, StepError, System, SystemState, Work};
use crate::Vector3;
use crate::mechanics::environment::Wrench;

/// Lie–Verlet in positions and momenta.
#[derive(Clone, Debug)]
pub(super) struct LieVerlet {
    loads: Loads,
    rotors: Vec<Rotor>,
    state: SystemState,
    /// The potential's wrenches at the node reached, and those with the inputs of one end of a step.
    field: Vec<Wrench>,
    wrenches: Vec<Wrench>,
    /// Cayley vector of each body's step.
    turns: Vec<Vector3>,
    work: Work,
}

impl LieVerlet {
    pub fn new(system: &System, state: &SystemState, step: f64) -> Self {
        let n = system.bodies().len();
        let mut loads = Loads::new(system, step);
        let mut field = vec![Wrench::zero(); n];
        loads.field(state.poses(), &mut field);
        Self {
            loads,
            rotors: Rotor::of(system.bodies(), step),
            state: state.clone(),
            wrenches: field.clone(),
            field,
            turns: vec![Vector3::zeros(); n],
            work: Work::default(),
        }
    }

    pub fn facts() -> Facts {
        Facts {
            order: 2,
            explicit: true,
            symplectic: true,
            preserves_momentum: true,
            preserves_group: true,
            force_evaluations: Some(1),
        }
    }

    /// The step without potential and inputs: the drift alone, free of the arithmetic of kicks.
    fn free_step(&mut self) -> Result<(), StepError> {
        for (body, rotor) in self.rotors.iter_mut().enumerate() {
            let momentum = self.state.momenta()[body].angular;
            self.turns[body] = rotor.turn(body, &momentum, &mut self.work.iterations)?;
        }
        for (body, about) in self.loads.system.bodies().iter().enumerate() {
            let momentum = self.state.momenta()[body];
            let change = carried(&self.turns[body], &momentum.angular);
            self.state.add_angular(body, &change);
            self.state.turn_attitude(body, &self.turns[body]);
            if let Some(mass) = about.mass {
                self.state.add_position(body, &(momentum.linear * (self.loads.step / mass)));
            }
        }
        if let Some(turn) = self.loads.frame_turn() {
            self.state.turn_frame(self.loads.system.bodies(), &turn);
        }
        self.work.steps += 1;
        Ok(())
    }
}

impl Integrator for LieVerlet {
    fn step(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        let h = self.loads.step;
        if self.loads.is_free(inputs) {
            return self.free_step();
        }
        self.wrenches.copy_from_slice(&self.field);
        add_inputs(inputs, 0.0, &mut self.wrenches);
        // All turns before any change: a step that fails leaves the state as it was.
        for (body, rotor) in self.rotors.iter_mut().enumerate() {
            let momentum = self.state.momenta()[body].angular + 0.5 * h * self.wrenches[body].moment;
            self.turns[body] = rotor.turn(body, &momentum, &mut self.work.iterations)?;
        }
        for (body, about) in self.loads.system.bodies().iter().enumerate() {
            let (impulse, momentum) = (self.wrenches[body], self.state.momenta()[body]);
            let kicked = momentum.angular + 0.5 * h * impulse.moment;
            let change = carried(&self.turns[body], &kicked);
            self.state.add_angular(body, &(change + 0.5 * h * impulse.moment));
            self.state.turn_attitude(body, &self.turns[body]);
            if let Some(mass) = about.mass {
                let kicked = momentum.linear + 0.5 * h * impulse.force;
                self.state.add_position(body, &(kicked * (h / mass)));
                self.state.add_linear(body, &(0.5 * h * impulse.force));
            }
        }
        if let Some(turn) = self.loads.frame_turn() {
            self.state.turn_frame(self.loads.system.bodies(), &turn);
        }
        self.work.steps += 1;
        self.loads.field(self.state.poses(), &mut self.field);
        self.wrenches.copy_from_slice(&self.field);
        add_inputs(inputs, 1.0, &mut self.wrenches);
        self.state.kick(self.loads.system.bodies(), 0.5 * h, &self.wrenches)
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
