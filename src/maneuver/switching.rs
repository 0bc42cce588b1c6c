//! The structure of a plan of minimum time or fuel: its arcs, its certificate, and costs for
//! comparison.

use serde::{Deserialize, Serialize};

/// The structure of a plan of minimum time or fuel.
///
/// It has two kinds of costs. The cost of the plan is the discrete optimum on its own grid, which
/// meets the terminal conditions to round-off. `continuous_cost` belongs to the extremal of the
/// equations of motion from which the grid was made, with the exact switching times of `arcs`.
/// The two differ by the square of the step. For minimum time the cost is the duration, and
/// `eigenaxis_s` is the duration of a turn about the fixed axis.
///
/// If limits other than torque limits shape a plan, it has equal steps and is a discrete optimum of
/// its own. The arcs then belong to the corresponding continuous extremal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Switching {
    /// The structure of the inputs.
    pub structure: Structure,
    /// Duration of the continuous extremal, seconds.
    pub continuous_duration_s: f64,
    /// Cost of the continuous extremal.
    pub continuous_cost: f64,
    /// The gap to neighbouring plans: the possible gain in cost, to first order, is
    /// `∫ Σ_j (|s_j| + s_j v_j) dt` with the switching functions s and the inputs v of the
    /// continuous extremal. It is no bound on the cost of plans on other paths. For fuel counted by
    /// inputs the costates minimise the gap. It is 0 if every input is always at the limit that its
    /// switching function selects. For pulses it is their cost above the best plan found without a
    /// shortest pulse, which bounds the gain of better pulses.
    pub gap: f64,
    /// The duration of a turn about the fixed axis under the given limits, from rest to rest,
    /// seconds; for minimum time.
    pub eigenaxis_s: Option<f64>,
    /// Number of switches; two inputs that switch together count twice.
    pub switches: usize,
    /// The indices, from 0, of inputs that are within their limits on an arc, or that chatter
    /// instead.
    pub singular_inputs: Vec<usize>,
    /// ε of the smoothed law on the grid, scaled, if the plan uses a smoothed law.
    pub smoothing: Option<f64>,
    /// Whether the plan meets the end on the arcs nearest to the continuous ones without being a
    /// discrete optimum, because none was found. The stationarity of the plan is the remaining
    /// residual.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub beside_optimum: bool,
    /// Arcs of the continuous extremal; empty if the inputs are smoothed.
    pub arcs: Vec<SwitchingArc>,
    /// The result of the search for pulses, if the spec has a shortest pulse.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub pulses: Option<Pulses>,
}

/// The pulses of a plan, and the cost of their shortest length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Pulses {
    /// The number of pulses of all inputs.
    pub count: usize,
    /// The length of the shortest pulse on the grid of the plan, seconds.
    pub shortest_s: f64,
    /// The continuous cost of the best plan found without a shortest pulse, with the price of
    /// time.
    pub cost_without: f64,
}

/// The structure of the inputs of a plan of minimum time or fuel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// Every input is at the limit that the maximum principle selects: an extremal.
    BangBang,
    /// Every input, or the norm of the torque, is at a limit or off, as the maximum principle
    /// selects: an extremal of fuel.
    BangOffBang,
    /// Every input at a limit or off, with a gap, since some sign is not right: as a rule an arc
    /// that is singular, cut into arcs at the limits, or off.
    TruncatedChattering,
    /// Some input stays within its limits, on a singular arc: a smoothed law, or arcs that have its
    /// mean.
    Singular,
    /// Every input is at a limit, off, or keeps a constraint active, as the maximum principle
    /// selects: an extremal along cones, or along limits of rates or wheels. If the rates of
    /// torques are limited, the rates or the torques are at a limit.
    AlongLimits,
    /// The norm of the torque is limited and its direction turns smoothly.
    Norm,
    /// Every input off or at a limit, in pulses of a shortest length: a local minimum of fuel under
    /// that condition.
    Pulses,
    /// The body is already where it should be.
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
    /// The start, seconds.
    pub start_s: f64,
    /// The end, seconds.
    pub end_s: f64,
    /// The inputs, which are constant along the arc. If inputs change at a constant rate, these are
    /// the inputs at the start of the arc; for inputs within their limits, these are means. Empty
    /// if the torque has its full norm and turns, or if some input holds a constraint.
    pub input: Vec<f64>,
    /// The constant rate of the inputs along it [N·m/s or N/s]; empty if no limit bounds it.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub change: Vec<f64>,
    /// Names of the constraints that the inputs hold along the arc.
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

    /// One input ramps and then holds, the next jumps, the last one stays.
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
