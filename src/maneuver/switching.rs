//! The structure of a minimum-time or minimum-fuel plan: its arcs, its certificate, and costs for
//! comparison.

use serde::{Deserialize, Serialize};

/// The structure of a minimum-time or minimum-fuel plan.
///
/// It has two kinds of costs. The cost of the plan is the discrete optimum on its own grid, which
/// meets the terminal conditions to round-off. `continuous_cost` belongs to the extremal of the
/// equations of motion from which the grid was made, with the exact switching times of `arcs`.
/// The two differ by the square of the step. For minimum time the cost is the duration, and
/// `eigenaxis_s` is the duration of a turn about the fixed axis.
///
/// If limits other than torque limits are active along a plan, the plan is a discrete optimum on a
/// uniform grid. The arcs then belong to the corresponding continuous extremal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Switching {
    /// The structure of the inputs.
    pub structure: Structure,
    /// Duration of the continuous extremal, seconds.
    pub continuous_duration_s: f64,
    /// Cost of the continuous extremal.
    pub continuous_cost: f64,
    /// The gap to neighbouring plans: they cost less by at most `∫ Σ_j (|s_j| + s_j v_j) dt`, to
    /// first order, with the switching functions s and the inputs v of the continuous extremal. The
    /// gap is not a bound for plans on other paths. It is 0 if every input is always at the limit
    /// that its switching function selects. If fuel is counted by inputs, the costates are chosen
    /// to minimise the gap. For pulses the gap is their cost above the best plan found without a
    /// minimum pulse width, which bounds the gain of better pulses.
    pub gap: f64,
    /// Duration in seconds of a rest-to-rest turn about the fixed axis (eigenaxis) under the given
    /// limits; only for minimum time.
    pub eigenaxis_s: Option<f64>,
    /// Number of switches; two inputs that switch together count twice.
    pub switches: usize,
    /// Indices, from 0, of the inputs that stay between their limits on an arc, or that chatter
    /// there instead.
    pub singular_inputs: Vec<usize>,
    /// The smoothing parameter ε of the control law on the grid, scaled; `None` if the plan does
    /// not use a smoothed law.
    pub smoothing: Option<f64>,
    /// Whether no discrete optimum was found, so that the plan only meets the end, on the arcs that
    /// are nearest to the continuous ones. The stationarity of the plan is the remaining residual.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub beside_optimum: bool,
    /// Arcs of the continuous extremal; empty if the inputs are smoothed.
    pub arcs: Vec<SwitchingArc>,
    /// The result of the search for pulses, if the spec has a minimum pulse width.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub pulses: Option<Pulses>,
}

/// The pulses of a plan with a minimum pulse width, and the cost without this width.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Pulses {
    /// The total number of pulses of all inputs.
    pub count: usize,
    /// The duration of the shortest pulse on the grid of the plan, in seconds.
    pub shortest_s: f64,
    /// The continuous cost of the best plan found without a minimum pulse width, including the
    /// price of time.
    pub cost_without: f64,
}

/// The structure of the inputs of a minimum-time or minimum-fuel plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// Every input is at the limit that the maximum principle selects: an extremal.
    BangBang,
    /// Every input, or the norm of the torque, is at a limit or off, as the maximum principle
    /// selects: an extremal of minimum fuel.
    BangOffBang,
    /// Every input is at a limit or off, but not always as the maximum principle selects, so that
    /// the gap is positive. Usually arcs at the limits or off approximate a singular arc.
    TruncatedChattering,
    /// Some input stays between its limits on a singular arc. The plan has a smoothed control law,
    /// or arcs whose inputs have the mean of the singular input.
    Singular,
    /// Every input is at a limit or off, or keeps a constraint active, as the maximum principle
    /// selects: an extremal along cones, or along limits of rates or wheels. If the rates of
    /// torques are limited, either the torque or its rate is at a limit.
    AlongLimits,
    /// Only the norm of the torque is limited, and the direction of the torque turns smoothly.
    Norm,
    /// Every input is off or at a limit, in pulses of a minimum width: a local minimum of fuel
    /// under this condition.
    Pulses,
    /// No motion: the body is already in the requested end state.
    Rest,
}

impl Structure {
    /// Returns the name of the structure in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::BangBang => "bang_bang",
            Self::BangOffBang => "bang_off_bang",
            Self::TruncatedChattering => "truncated_chattering",
            Self::Singular => "singular",
            Self::AlongLimits => "along_limits",
            Self::Norm => "norm",
            Self::Pulses => "pulses",
            Self::Rest => "rest",
        }
    }
}

/// An arc between two switches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SwitchingArc {
    /// Start of the arc, in seconds.
    pub start_s: f64,
    /// End of the arc, in seconds.
    pub end_s: f64,
    /// The inputs, which are constant along the arc. They are the inputs at the start of the arc if
    /// inputs change at a constant rate, and means for inputs between their limits. Empty if the
    /// torque has its full norm and turns, or if some input keeps a constraint active.
    pub input: Vec<f64>,
    /// The constant rate of change of the inputs along the arc [N·m/s or N/s]; empty if the rates
    /// of the inputs are not limited.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub change: Vec<f64>,
    /// Names of the constraints that the inputs keep active along the arc.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub holds: Vec<String>,
    /// Names of the constraints that the motion touches at the end of the arc.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub touches: Vec<String>,
}

impl SwitchingArc {
    /// Returns the inputs at a time \[s\] along the arc.
    pub fn input_at(&self, time: f64) -> Vec<f64> {
        let mut inputs = self.input.clone();
        for (input, change) in inputs.iter_mut().zip(&self.change) {
            *input += change * (time - self.start_s);
        }
        inputs
    }

    /// Returns the number of inputs that switch from this arc to the next: their rate, or their
    /// constant value, changes.
    pub fn switches_to(&self, next: &Self) -> usize {
        let change = |arc: &Self, input: usize| arc.change.get(input).copied().unwrap_or(0.0);
        let switched = |input: &usize| {
            let [before, after] = [self, next].map(|arc| change(arc, *input));
            before != after || before == 0.0 && self.input[*input] != next.input[*input]
        };
        (0..self.input.len().min(next.input.len())).filter(switched).count()
    }
}

#[cfg(test)]
mod tests {
    use super::SwitchingArc;

    fn arc(input: &[f64], change: &[f64]) -> SwitchingArc {
        let (input, change) = (input.to_vec(), change.to_vec());
        SwitchingArc { start_s: 1.0, end_s: 2.0, input, change, holds: Vec::new(), touches: Vec::new() }
    }

    /// The first input ramps and then holds, the second jumps, the third stays constant.
    #[test]
    fn inputs_switch_where_they_jump_and_where_their_change_does() {
        let ramping = arc(&[-1.0, 0.5, 0.3], &[2.0, 0.0, 0.0]);
        let held = arc(&[1.0, -0.5, 0.3], &[0.0, 0.0, 0.0]);
        assert_eq!(ramping.switches_to(&held), 2);
        assert_eq!(held.switches_to(&held), 0);
        assert_eq!(arc(&[1.0, 2.0], &[]).switches_to(&arc(&[1.0, -2.0], &[])), 1);
        assert_eq!(ramping.input_at(1.5), [0.0, 0.5, 0.3]);
    }
}
