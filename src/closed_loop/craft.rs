//! The differences between the true craft and its model, and the response of its actuators to a
//! command: limits first, then the delay.

use crate::mechanics::actuators::ActuatorSet;
use crate::optimize::discrete::linear_plan::Parameter;
use crate::{Matrix3, Vector3, lie};
use std::collections::VecDeque;

/// The constant errors of one case: scale errors of the inputs, misalignment of the actuators,
/// constant torque, misalignment of the attitude sensor, scale error and bias of the rate sensor.
pub(super) struct Errors {
    scale: Vec<f64>,
    turn: Matrix3,
    pub constant: Vector3,
    pub sensor_turn: Matrix3,
    pub rate_scale: Vector3,
    pub rate_bias: Vector3,
}

impl Errors {
    pub fn of(parameters: &[(String, Parameter, f64)], values: &[f64], inputs: usize) -> Self {
        let zero = Vector3::zeros();
        let (mut turn, mut sensor) = (zero, zero);
        let mut scale = vec![1.0; inputs];
        let (mut constant, mut rate_scale, mut rate_bias) = (zero, Vector3::repeat(1.0), zero);
        for ((_, parameter, _), value) in parameters.iter().zip(values) {
            match parameter {
                Parameter::Inertia(_) => {}
                Parameter::InputScale(input) => scale[*input] += value,
                Parameter::ActuatorTurn(axis) => turn += axis * *value,
                Parameter::ConstantTorque(torque) => constant += torque * *value,
                Parameter::SensorTurn(axis) => sensor += axis * *value,
                Parameter::RateScale(axis) => rate_scale[*axis] += value,
                Parameter::RateBias(bias) => rate_bias += bias * *value,
            }
        }
        Self { scale, turn: lie::exp(&turn), constant, sensor_turn: lie::exp(&sensor), rate_scale, rate_bias }
    }

    /// Returns the true torque `exp S(α) B (1 + s) u` in body axes: `α` is the misalignment of the
    /// actuators, and `s` holds the scale errors of the inputs.
    pub fn torque(&self, set: &ActuatorSet, inputs: &[f64]) -> Vector3 {
        let axes = set.axes().iter().zip(inputs).zip(&self.scale);
        let torque: Vector3 = axes.map(|((axis, input), scale)| axis * (input * scale)).sum();
        self.turn * torque
    }
}

/// Commands that have been given, in the order in which the actuators receive them.
pub(super) struct DelayLine {
    /// The commands that do not act yet, each with the time from which it acts. The inputs are zero
    /// before the first command acts.
    waiting: VecDeque<(f64, Vec<f64>)>,
    acting: Vec<f64>,
}

impl DelayLine {
    pub fn new(inputs: usize) -> Self {
        Self { waiting: VecDeque::new(), acting: vec![0.0; inputs] }
    }

    pub fn command(&mut self, from: f64, inputs: Vec<f64>) {
        self.waiting.push_back((from, inputs));
    }

    /// Returns the command that acts at `time`, and the time at which the next command replaces it
    /// (infinity if no command waits).
    pub fn at(&mut self, time: f64) -> (&[f64], f64) {
        while self.waiting.front().is_some_and(|(from, _)| *from <= time) {
            if let Some((_, inputs)) = self.waiting.pop_front() {
                self.acting = inputs;
            }
        }
        (&self.acting, self.waiting.front().map_or(f64::INFINITY, |(from, _)| *from))
    }
}

/// The limits of the inputs, and the smallest distance that the commands have kept from each of
/// them.
///
/// Commands are cut to the limits of size and norm. The rate of change of a command is recorded but
/// not limited, because a held command jumps.
pub(super) struct Limited<'a> {
    set: &'a ActuatorSet,
    /// The capacity of the actuators, as a multiple of the limits of the plan.
    authority: f64,
    /// The previous command; `None` before the first.
    before: Option<Vec<f64>>,
    /// The smallest distance so far from each limit that exists, SI: from the size limit of each
    /// input, the norm limit, and the rate limit of each input, in this order.
    pub room: Vec<f64>,
}

impl<'a> Limited<'a> {
    /// The relative excess over a limit that still counts as round-off.
    const ROUNDING: f64 = 1e-9;

    pub fn new(set: &'a ActuatorSet, authority: f64) -> Self {
        let limits = set.limits();
        let each = |bounds: &Option<Vec<f64>>| bounds.as_ref().map_or(0, Vec::len);
        let count = each(&limits.size) + usize::from(limits.norm.is_some()) + each(&limits.rate);
        Self { set, authority, before: None, room: vec![f64::INFINITY; count] }
    }

    /// Cuts a command to the limits of size and norm. Returns whether the command exceeded a limit.
    pub fn cut(&self, inputs: &mut [f64]) -> bool {
        let limits = self.set.limits();
        let mut cut = false;
        if let Some(sizes) = &limits.size {
            for (input, size) in inputs.iter_mut().zip(sizes) {
                let size = size * self.authority;
                let least = if limits.one_sided { 0.0 } else { -size };
                // An input that exceeds its limit by round-off does not count as saturated.
                cut |= *input > size * (1.0 + Self::ROUNDING) || *input < least - size * Self::ROUNDING;
                // The code avoids `clamp`, which panics on invalid bounds.
                *input = if *input > size {
                    size
                } else if *input < least {
                    least
                } else {
                    *input
                };
            }
        }
        if let Some(norm) = limits.norm.map(|norm| norm * self.authority) {
            let size = self.set.output(inputs).norm();
            if size > norm {
                cut |= size > norm * (1.0 + Self::ROUNDING);
                inputs.iter_mut().for_each(|input| *input *= norm / size);
            }
        }
        cut
    }

    /// Records the distance of a command from each limit, before the command is cut. The command
    /// lasts `step` \[s\].
    pub fn meet(&mut self, step: f64, inputs: &[f64]) {
        let limits = self.set.limits();
        // The lower limit of a one-sided input is zero.
        let size = |input: f64| if limits.one_sided { input } else { input.abs() };
        let sizes = limits.size.iter().flatten().zip(inputs);
        let sizes = sizes.map(|(limit, input)| limit * self.authority - size(*input));
        let norm = limits.norm.map(|norm| norm * self.authority - self.set.output(inputs).norm());
        let before = self.before.as_deref().unwrap_or(inputs);
        let rates = limits.rate.iter().flatten().zip(inputs.iter().zip(before));
        let rates = rates.map(|(rate, (input, before))| rate - (input - before).abs() / step);
        for (room, left) in self.room.iter_mut().zip(sizes.chain(norm).chain(rates)) {
            *room = room.min(left);
        }
        self.before = Some(inputs.to_vec());
    }
}
