//! The discrete witness: forward propagation of the difference equations of the plan.
//!
//! ```text
//! h S(Π̃) = F J_d − J_d Fᵀ ,   R⁺ = exp(−h S(n)) R F ,   Π⁺ = FᵀΠ̃ + b (M⁺ + τ⁺)
//! x⁺ = x + (h/m) γ̃ ,           γ⁺ = γ̃ + b (f⁺ + f_u⁺)
//! Lie–Euler   Π̃ = Π,                   γ̃ = γ,                     b = h
//! Lie–Verlet  Π̃ = Π + (h/2)(M + τ),    γ̃ = γ + (h/2)(f + f_u),    b = h/2
//! ```
//! Wheels store `μ = Σ a_i h_i`. Let `H = Π + μ`, and let `u` be the torque of the wheels on the
//! body:
//!
//! ```text
//! h S(H̃ − (I + S(c) + c cᵀ) μ̃) = F J_d − J_d Fᵀ ,  F = cay(c) ,   H⁺ = FᵀH̃ + b M⁺ ,   μ⁺ = μ̃ − b τ⁺
//! Lie–Verlet  H̃ = H + (h/2) M ,  μ̃ = μ − (h/2) τ
//! ```
//! (2.4, 3.22–3.26, 4.5–4.7.) The equation for F is solved in its exponential form. Every update
//! adds a small increment to a compensated sum, so the end is accurate to 1e-13 after a million
//! steps.

use super::compensated::Compensated;
use super::implicit::{Implicit, exp_minus_identity};
use super::motion::Phase;
use super::verification::WitnessError;
use crate::Vector3;
use crate::maneuver::constraint::Arc;
use crate::maneuver::problem::Scheme;
use crate::mechanics::environment::{Pose, Wrench};
use crate::propagate::plant::{Output, Plant};

/// The discrete motion of a body, advanced step by step.
#[derive(Clone, Debug)]
pub(crate) struct Discrete<'a> {
    plant: &'a Plant<'a>,
    implicit: Implicit,
    scheme: Scheme,
    step: f64,
    per_mass: f64,
    /// Time since which the step length is unchanged \[s\].
    began: f64,
    /// Number of steps made since that time.
    steps: u64,
    position: Compensated<3, 1>,
    linear_momentum: Compensated<3, 1>,
    /// Attitude, from body to inertial axes.
    attitude: Compensated<3, 3>,
    momentum: Compensated<3, 1>,
    /// The momentum stored in the wheels; `None` if the body has no wheels.
    stored: Option<Compensated<3, 1>>,
    /// The rotation of the last step; `None` before the first.
    arc: Option<Arc>,
    /// Pose at the present node, in the reference frame.
    pose: Pose,
    /// Wrench of the force field at the present node.
    field: Wrench,
}

impl<'a> Discrete<'a> {
    /// Builds the witness with the step length `step` \[s\]. It starts at `t = 0`, when the
    /// reference and the inertial frame coincide.
    pub(crate) fn new(plant: &'a Plant<'a>, start: &Phase, scheme: Scheme, step: f64) -> Self {
        Self::at(plant, start, scheme, step, 0.0)
    }

    /// Builds the witness for a motion that starts at the time `began` \[s\].
    pub(super) fn at(plant: &'a Plant<'a>, start: &Phase, scheme: Scheme, step: f64, began: f64) -> Self {
        let pose = Pose { position: start.position, attitude: start.attitude };
        Self {
            plant,
            implicit: Implicit::new(&plant.problem.body.inertia),
            scheme,
            step,
            per_mass: plant.problem.body.mass.map_or(0.0, f64::recip),
            began,
            steps: 0,
            position: Compensated::new(start.position),
            linear_momentum: Compensated::new(start.linear_momentum),
            attitude: Compensated::new(match plant.to_reference(began) {
                Some(frame) if began > 0.0 => frame.tr_mul(&start.attitude),
                _ => start.attitude,
            }),
            momentum: Compensated::new(start.momentum),
            stored: plant.problem.actuation.wheels.is_some().then(|| Compensated::new(start.stored)),
            arc: None,
            pose,
            field: plant.field(&pose),
        }
    }

    /// Returns the time of the present node \[s\].
    pub(crate) fn time(&self) -> f64 {
        self.began + self.steps as f64 * self.step
    }

    /// Sets the length of the following steps \[s\].
    pub(super) fn set_step(&mut self, step: f64) {
        // Compares bits, because the time is counted from the first of several equal steps.
        if step.to_bits() != self.step.to_bits() {
            (self.began, self.steps, self.step) = (self.time(), 0, step);
        }
    }

    /// Advances by one step, with the actuator outputs at its two ends. Lie–Euler uses only the
    /// output at the end.
    pub(crate) fn advance(&mut self, start: &Output, end: &Output) -> Result<(), WitnessError> {
        match self.scheme {
            Scheme::LieEuler => {
                self.drift()?;
                self.kick(self.step, end);
            }
            Scheme::LieVerlet => {
                self.kick(0.5 * self.step, start);
                self.drift()?;
                self.kick(0.5 * self.step, end);
            }
        }
        Ok(())
    }

    fn kick(&mut self, duration: f64, output: &Output) {
        let actuators = self.plant.actuators(&self.pose.attitude, output);
        self.momentum.add(&(duration * (self.field.moment + actuators.moment)));
        if let Some(stored) = &mut self.stored {
            stored.add(&(-duration * actuators.moment));
        }
        if self.plant.moves {
            self.linear_momentum.add(&(duration * (self.field.force + actuators.force)));
        }
    }

    fn drift(&mut self) -> Result<(), WitnessError> {
        let momentum = *self.momentum.value();
        if !momentum.iter().all(|value| value.is_finite()) {
            return Err(WitnessError::NotFinite { time: self.time() });
        }
        let stored = self.stored();
        let f = self
            .implicit
            .solve(&(self.step * momentum), &(self.step * stored))
            .ok_or(WitnessError::StepTooLong { time: self.time(), step: self.step })?;
        let turn = exp_minus_identity(&f);
        self.momentum.add(&turn.tr_mul(&(momentum + stored)));
        self.arc = Some(Arc { start: *self.attitude.value(), turn: f });
        self.attitude.add(&(self.attitude.value() * turn));
        if self.plant.moves {
            self.position.add(&(self.step * self.per_mass * self.linear_momentum.value()));
        }
        self.steps += 1;
        self.pose = Pose { position: *self.position.value(), attitude: *self.attitude.value() };
        if let Some(frame) = self.plant.to_reference(self.time()) {
            self.pose.attitude = frame * self.pose.attitude;
        }
        self.field = self.plant.field(&self.pose);
        Ok(())
    }

    /// Returns the momentum stored in the wheels, body axes.
    fn stored(&self) -> Vector3 {
        self.stored.as_ref().map_or_else(Vector3::zeros, |stored| *stored.value())
    }

    /// Returns the rotation of the last step in inertial axes; `None` before the first step.
    pub(crate) fn arc(&self) -> Option<&Arc> {
        self.arc.as_ref()
    }

    /// Returns the state at the present node.
    pub(crate) fn phase(&self) -> Phase {
        Phase {
            position: self.pose.position,
            linear_momentum: *self.linear_momentum.value(),
            attitude: self.pose.attitude,
            momentum: *self.momentum.value(),
            stored: self.stored(),
        }
    }
}
