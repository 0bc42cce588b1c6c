//! What a plan of minimum time or fuel is made of: its arcs, its certificate, and what it is compared with.

use serde::{Deserialize, Serialize};

/// What a plan of minimum time or fuel is made of.
///
/// Its costs are of two kinds. That of the plan is the discrete optimum on its own grid, which meets the terminal
/// conditions to round-off. `continuous_cost` belongs to the extremal of the equations of motion from which the grid
/// was made, with the exact switching times of `arcs`; the two differ by the square of the step. Where only time counts
/// the cost is the duration, and `eigenaxis_s` is what a turn about the fixed axis would take.
///
/// Where more than limits of the torques shapes a plan it has equal steps and is a discrete optimum of its own; the arcs are those of the
/// continuous extremal that it stands for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Switching {
    /// How the inputs go.
    pub structure: Structure,
    /// Duration of the continuous extremal, seconds.
    pub continuous_duration_s: f64,
    /// Cost of the continuous extremal.
    pub continuous_cost: f64,
    /// Cost still to be gained, to first order: `∫ Σ_j (|s_j| + s_j v_j) dt` with the switching functions s and the inputs
    /// v of the continuous extremal; of fuel counted by inputs by the costates that make it least. 0 where every input is on
    /// the right side all the time. Of pulses what they cost above
    /// the best plan found without a shortest pulse: that bounds what better pulses could gain.
    pub gap: f64,
    /// Of a turn about the fixed axis under the same limits, from rest to rest, seconds; where time is minimised.
    pub eigenaxis_s: Option<f64>,
    /// Number of switches; two inputs that switch together count twice.
    pub switches: usize,
    /// Inputs that are within their limits on an arc, or chatter where they would be, from 0.
    pub singular_inputs: Vec<usize>,
    /// ε of the smoothed law on the grid, scaled, where the plan has one.
    pub smoothing: Option<f64>,
    /// Whether the arcs meet the end of the grid next to those of continuous time without being its discrete optimum, because
    /// none was found: the stationarity of the plan is what is left.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub beside_optimum: bool,
    /// Arcs of the continuous extremal, none where the inputs are smoothed.
    pub arcs: Vec<SwitchingArc>,
    /// What a shortest pulse took, where there is one.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub pulses: Option<Pulses>,
}

/// Pulses, and what their shortest length costs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Pulses {
    /// How many there are, of all inputs.
    pub count: usize,
    /// The shortest of them on the grid of the plan, seconds.
    pub shortest_s: f64,
    /// Continuous cost of the best plan found without a shortest pulse, that of time included where it has a price.
    pub cost_without: f64,
}

/// How the inputs of a plan of minimum time or fuel go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// Every input at one of its limits, on the side that the maximum principle asks for: an extremal.
    BangBang,
    /// Every input, or the norm of the torque, at a limit or off, as the maximum principle asks for: an extremal of fuel.
    BangOffBang,
    /// Every input at a limit or off, with a gap, since some sign is not right: as a rule an arc that is singular, cut into arcs at the
    /// limits, or off.
    TruncatedChattering,
    /// A smoothed law: some input stays within its limits, on a singular arc.
    Singular,
    /// Every input at a limit or off, or such that a constraint is held, as the maximum principle asks for: an extremal along cones, or
    /// limits of rates or of wheels. Of torques whose rates are limited it is these that are at a limit, or the torques themselves.
    AlongLimits,
    /// The norm of the torque is limited and its direction turns smoothly.
    Norm,
    /// Every input off or at a limit, in pulses of a shortest length: a local minimum of fuel under that condition.
    Pulses,
    /// The body is where it should be.
    Rest,
}

impl Structure {
    /// Its name in files.
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
    /// When it starts, seconds.
    pub start_s: f64,
    /// When it ends, seconds.
    pub end_s: f64,
    /// The inputs, constant along it; none where the torque has its full norm and turns, and where some input holds a constraint.
    /// Those that it begins with where they change.
    pub input: Vec<f64>,
    /// How fast the inputs change along it [N·m/s or N/s], constant; none where nothing limits that.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub change: Vec<f64>,
    /// Names of the constraints that inputs hold along it.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub holds: Vec<String>,
    /// Names of the constraints that the motion touches where it ends.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub touches: Vec<String>,
}

impl SwitchingArc {
    /// The inputs at a time \[s\] along it.
    pub fn input_at(&self, time: f64) -> Vec<f64> {
        let mut inputs = self.input.clone();
        for (input, change) in inputs.iter_mut().zip(&self.change) {
            *input += change * (time - self.start_s);
        }
        inputs
    }

    /// How many inputs switch from this arc to the next: they change at another rate, or stay at another value.
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
