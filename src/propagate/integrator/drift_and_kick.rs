//! The Lie group variational integrators in Hamiltonian form: kick, drift, kick (2.4, 3.22–3.26,
//! 4.5–4.7).
//!
//! ```text
//! L_d = (1/h) tr[(I−F) J_d] + (m/2h)|x⁺−x|² − a U − b U⁺ ,   a + b = h
//!
//! p = Π + a (M + Bu) ,   q = γ + a (f + B_f u)
//! h S(p) = F J_d − J_d Fᵀ                       implicit, one body at a time
//! R⁺ = R F ,   x⁺ = x + (h/m) q                                                          (3.26, 3.22)
//! Π⁺ = Fᵀp + b (M⁺ + Bu⁺) ,   γ⁺ = q + b (f⁺ + B_f u⁺)                                   (3.25, 3.23)
//!
//! Lie–Euler  a = 0, b = h      its adjoint  a = h, b = 0      Lie velocity Verlet  a = b = h/2
//! ```
//! All three methods are symplectic and evaluate the potential once per step. If both kicks act,
//! the potential at the end of a step is kept, because it is also the potential at the start of the
//! next step. Lie–Verlet is of second order. Both Lie–Euler methods equal Lie–Verlet in the
//! variable `Π̃ = Π + (h/2) M`: their error is the missing half kick at the ends, and does not
//! grow.

use super::course::{Course, Method};
use super::drift::Rotor;
use super::state::carried;
use super::system::add_inputs;
use super::{Input, StepError};
use crate::Vector3;
use crate::mechanics::environment::Wrench;

/// The method kick, drift, kick, with buffers for one step.
#[derive(Clone, Debug)]
pub(super) struct DriftAndKick {
    course: Course,
    rotors: Vec<Rotor>,
    /// Weight `a` of the kick before the drift \[s\].
    before: f64,
    /// Weight `b` of the kick after the drift \[s\].
    after: f64,
    /// The wrenches of the potential on the bodies at the present node.
    field: Vec<Wrench>,
    /// The wrenches of potential and inputs on the bodies at one end of a step.
    wrenches: Vec<Wrench>,
    /// Cayley vector of each body's rotation in the step.
    turns: Vec<Vector3>,
}

impl DriftAndKick {
    /// Builds the method; `before` is the fraction of a step's kick that acts before the drift.
    pub fn new(mut course: Course, before: f64) -> Self {
        let (n, h) = (course.count(), course.loads.step);
        let mut field = vec![Wrench::zero(); n];
        if before > 0.0 && before < 1.0 {
            course.loads.field(course.state.poses(), &mut field);
        }
        Self {
            rotors: Rotor::of(course.loads.system.bodies(), h),
            before: before * h,
            after: (1.0 - before) * h,
            wrenches: field.clone(),
            field,
            turns: vec![Vector3::zeros(); n],
            course,
        }
    }

    /// Applies the first kick and the drift. Without the kick (`KICKED` false) its arithmetic is
    /// omitted.
    fn drift<const KICKED: bool>(&mut self) -> Result<(), StepError> {
        let Self { course, rotors, before, wrenches, turns, .. } = self;
        // All turns are computed before the state changes, so a step that fails leaves the state
        // unchanged.
        for (body, rotor) in rotors.iter_mut().enumerate() {
            let mut momentum = course.state.momenta()[body].angular;
            if KICKED {
                momentum += *before * wrenches[body].moment;
            }
            turns[body] = rotor.turn(body, &momentum, &mut course.work.iterations)?;
        }
        for (body, about) in course.loads.system.bodies().iter().enumerate() {
            let mut momentum = course.state.momenta()[body];
            let (moment, force) = (*before * wrenches[body].moment, *before * wrenches[body].force);
            if KICKED {
                momentum.angular += moment;
                momentum.linear += force;
            }
            let change = carried(&turns[body], &momentum.angular);
            course.state.add_angular(body, &if KICKED { change + moment } else { change });
            course.state.turn_attitude(body, &turns[body]);
            if let Some(mass) = about.mass {
                course.state.add_position(body, &(momentum.linear * (course.loads.step / mass)));
                if KICKED {
                    course.state.add_linear(body, &force);
                }
            }
        }
        course.turn_frame();
        course.work.steps += 1;
        Ok(())
    }

    /// Evaluates potential and inputs at one end of the step. The potential is evaluated only if
    /// `anew` is true, otherwise the last value is used.
    fn look(&mut self, anew: bool, end: f64, inputs: &[Input]) {
        if anew {
            self.course.loads.field(self.course.state.poses(), &mut self.field);
        }
        self.wrenches.copy_from_slice(&self.field);
        add_inputs(inputs, end, &mut self.wrenches);
    }
}

impl Method for DriftAndKick {
    fn advance(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        let free = self.course.loads.is_free(inputs);
        if free || self.before == 0.0 {
            self.drift::<false>()?;
        } else {
            self.look(self.after == 0.0, 0.0, inputs);
            self.drift::<true>()?;
        }
        if free || self.after == 0.0 {
            return Ok(());
        }
        self.look(true, 1.0, inputs);
        let Course { loads, state, .. } = &mut self.course;
        state.kick(loads.system.bodies(), self.after, &self.wrenches)
    }

    fn course(&self) -> &Course {
        &self.course
    }
}
