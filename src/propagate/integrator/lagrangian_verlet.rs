//! Lie–Verlet in Lagrangian form: the discrete Lagrangian map `(x⁻, R⁻; x, R) → (x, R; x⁺, R⁺)`
//! (3.18–3.20, 4.3).
//!
//! ```text
//! F J_d − J_d Fᵀ = J_d F⁻ − F⁻ᵀ J_d + h² S(M + Bu) ,   R⁺ = R F                          (3.19, 3.20)
//! x⁺ = x + Δ ,   Δ = Δ⁻ + (h²/m)(f + B_f u)                                              (3.18)
//! ```
//! The method has no momenta. The state obtains its momenta from the discrete Legendre transform
//! `hΠ = vee(J_d F⁻ − F⁻ᵀ J_d) + (h²/2) M`, `γ = (m/h) Δ⁻ + (h/2) f`. The first step has no
//! preceding step and uses the Hamiltonian form. If inputs jump at a node, the mean of both sides
//! acts.
//!
//! The Hamiltonian form has an identical map. Computing `vee(J_d F⁻ − F⁻ᵀ J_d)` from `F⁻` in every
//! step would accumulate rounding errors in a steady rotation. This term equals `h F⁻ᵀΠ̃⁻`, so it
//! is computed as a compensated sum of its changes.

use super::course::{Course, Method};
use super::drift::Rotor;
use super::state::carried;
use super::system::add_inputs;
use super::{Input, Momentum, StepError};
use crate::mechanics::environment::Wrench;
use crate::numerics::compensated::Sum3;
use crate::{Vector3, lie};

/// The Lagrangian form of Lie–Verlet, with its last step and buffers.
#[derive(Clone, Debug)]
pub(super) struct LagrangianVerlet {
    course: Course,
    rotors: Vec<Rotor>,
    /// The last step of each body.
    last: Vec<Last>,
    /// The wrenches of the potential at the present node.
    field: Vec<Wrench>,
    /// The wrenches at the present node, including the inputs at the end of the last step.
    before: Vec<Wrench>,
    /// The wrenches at the present node, including the inputs at the start of the next step.
    after: Vec<Wrench>,
    turns: Vec<Vector3>,
}

/// The motion of a body in the last step.
#[derive(Clone, Debug)]
struct Last {
    /// Angular momentum `FᵀΠ̃ = vee(J_d F − FᵀJ_d)/h` at the end of the step.
    carried: Sum3,
    /// Change of position `Δ` in the step.
    shift: Sum3,
}

impl LagrangianVerlet {
    pub fn new(mut course: Course) -> Self {
        let n = course.count();
        let mut field = vec![Wrench::zero(); n];
        course.loads.field(course.state.poses(), &mut field);
        Self {
            rotors: Rotor::of(course.loads.system.bodies(), course.loads.step),
            last: course
                .state
                .momenta()
                .iter()
                .map(|momentum| Last {
                    carried: Sum3::new(momentum.angular),
                    shift: Sum3::new(Vector3::zeros()),
                })
                .collect(),
            before: field.clone(),
            after: field.clone(),
            field,
            turns: vec![Vector3::zeros(); n],
            course,
        }
    }

    /// Returns the momentum `Π̃` of a body for the next step: the momentum carried from the last
    /// step, plus both half kicks at the node. The first step has the opening half kick only.
    fn kicked(&self, body: usize) -> Sum3 {
        let mut momentum = self.last[body].carried;
        let opening = self.course.work.steps == 0;
        let before = if opening { Vector3::zeros() } else { self.before[body].moment };
        momentum.add(&(0.5 * self.course.loads.step * (before + self.after[body].moment)));
        momentum
    }
}

impl Method for LagrangianVerlet {
    fn advance(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        let h = self.course.loads.step;
        self.after.copy_from_slice(&self.field);
        add_inputs(inputs, 0.0, &mut self.after);
        for body in 0..self.rotors.len() {
            let momentum = self.kicked(body).value;
            self.turns[body] = self.rotors[body].turn(body, &momentum, &mut self.course.work.iterations)?;
        }
        for body in 0..self.turns.len() {
            let mut momentum = self.kicked(body);
            momentum.add(&carried(&self.turns[body], &momentum.value));
            self.last[body].carried = momentum;
        }
        for (body, about) in self.course.loads.system.bodies().iter().enumerate() {
            let last = &mut self.last[body];
            self.course.state.turn_attitude(body, &self.turns[body]);
            let Some(mass) = about.mass else { continue };
            if self.course.work.steps == 0 {
                let kicked = self.course.state.momenta()[body].linear + 0.5 * h * self.after[body].force;
                last.shift = Sum3::new(kicked * (h / mass));
            } else {
                let force = self.before[body].force + self.after[body].force;
                last.shift.add(&(force * (0.5 * h * h / mass)));
            }
            self.course.state.add_position(body, &last.shift.value);
        }
        if let Some(turn) = self.course.loads.frame_turn() {
            self.course.state.turn_frame(self.course.loads.system.bodies(), &turn);
            let turn = lie::exp_minus_identity(&turn);
            self.last.iter_mut().for_each(|last| last.shift.add(&(turn * last.shift.value)));
        }
        self.course.loads.field(self.course.state.poses(), &mut self.field);
        self.before.copy_from_slice(&self.field);
        add_inputs(inputs, 1.0, &mut self.before);
        for body in 0..self.rotors.len() {
            let mass = self.course.loads.system.bodies()[body].mass.unwrap_or(0.0);
            let (shift, kick) = (self.last[body].shift.value, self.before[body]);
            let linear = if mass > 0.0 { shift * (mass / h) + 0.5 * h * kick.force } else { shift };
            let angular = self.last[body].carried.value + 0.5 * h * kick.moment;
            self.course.state.set_momentum(body, Momentum { linear, angular });
        }
        self.course.finish()
    }

    fn course(&self) -> &Course {
        &self.course
    }
}
