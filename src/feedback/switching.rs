//! Gains of bang-bang plans: the lengths of the arcs from a neighbouring start.
//!
//! ```text
//! d = d* + K z ,     z = [log(R*_0ᵀ R_0); Π_0 − Π*_0]
//! ```
//!
//! A neighbouring bang-bang plan has the arcs of the plan with other lengths
//! (`optimize::methods::switching::moved` has the equations). The motion from the corrected start
//! misses the end by an error of order `|z|²`, and its duration equals the duration of the
//! neighbouring optimum. After the first switches too few arc lengths remain to correct six errors.
//! A plan is therefore corrected once, at its start, and a regulator with reserved torque follows
//! the corrected motion.
//!
//! If an error would make the length of an arc negative, the neighbouring optimal plan has other
//! arcs, which derivatives cannot give. The result is then [`Reversed`], and the maneuver must be
//! planned again.

use super::NoGains;
use crate::flight::Flight;
use crate::lie;
use crate::maneuver::duration::Duration;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{EndCondition, Motion, Problem, State};
use crate::maneuver::solution::Trajectory;
use crate::mechanics::actuators::AxisFrame;
use crate::optimize::discrete::linear_plan::Vector6;
use crate::optimize::methods::switching::moved::{HeldArc, lengths_by_start};
use crate::optimize::methods::switching::scaled::scaled;
use thiserror::Error;

/// Relative tolerance within which an input counts as at its limit or as off. It covers the
/// round-off of impulses in recorded times.
const AT_LIMIT: f64 = 1e-6;

/// Relative tolerance within which a duration counts as equal to the longest allowed one.
const ALL_OF_IT: f64 = 1e-9;

/// An arc of a bang-bang plan: a time interval over which the inputs are constant.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Arc {
    /// Index of the first step of the arc.
    pub first_step: usize,
    /// Number of steps of the plan in the arc.
    pub steps: usize,
    /// Length of the arc \[s\].
    pub length: f64,
    /// The constant inputs on the arc, SI.
    pub inputs: Vec<f64>,
}

/// Derivatives of the arc lengths of a plan with respect to the initial state.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SwitchingGains {
    /// The arcs of the plan, in the order of time.
    pub arcs: Vec<Arc>,
    /// The matrix `K`, one row of six per arc: \[s\] per rad and per N·m·s, body axes.
    pub rows: Vec<f64>,
}

/// An error of the start would make the length of an arc zero or negative.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error(
    "arc {} would have the length {length:.3} s from this start: the optimal plan from there has \
    other arcs, so search again",
    arc + 1
)]
pub struct Reversed {
    /// Index of the arc in [`SwitchingGains::arcs`].
    pub arc: usize,
    /// The length that the arc would have \[s\].
    pub length: f64,
}

/// The reason why a plan cannot be corrected for another start.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NotCorrected {
    /// The neighbouring optimal plan has other arcs.
    #[error(transparent)]
    Reversed(#[from] Reversed),
    /// The gains were computed for another plan, or the motion of the plan cannot be propagated.
    #[error("the gains were computed for another plan, or the motion of this plan cannot be propagated")]
    Trajectory,
}

impl SwitchingGains {
    /// Computes the gains for the arcs of `plan`, a trajectory of `problem` on its own grid. The
    /// arcs are the flown ones: their switching times differ from the switching times of the
    /// continuous extremal by `O(h²)`, with the step h.
    ///
    /// # Errors
    /// [`NoGains::Arcs`] in these cases: inputs are neither at limits nor off, another constraint
    /// limits them, or the arcs are too few or too similar to correct six errors.
    pub fn along(problem: &Problem, plan: &Trajectory) -> Result<Self, NoGains> {
        Self::suits(problem)?;
        let arcs = arcs(problem, plan)?;
        let unscaled = NoGains::Arcs("its inputs do not reach all axes");
        let (extremal, units) = scaled(problem).ok_or(unscaled)?;
        let torque = &problem.actuation.torque;
        let price = |inputs: &[f64]| match &problem.objective {
            Objective::Fuel(fuel) => problem.objective.time_price() + fuel.rate(&problem.actuation, inputs),
            _ => 1.0,
        };
        let held: Vec<HeldArc> = arcs
            .iter()
            .map(|arc| HeldArc {
                length: arc.length / units.time,
                torque: torque.output(&arc.inputs) / units.torque,
                price: price(&arc.inputs),
            })
            .collect();
        let last = plan.time.last().copied().unwrap_or(f64::NAN);
        let all = |longest: f64| (longest - last).abs() <= ALL_OF_IT * longest;
        let given =
            matches!(problem.duration, Duration::Given(_)) || problem.duration.at_most().is_some_and(all);
        let given = given && problem.objective.fuel().is_some();
        let gains = lengths_by_start(&extremal, &held, given).ok_or(NoGains::Arcs(
            "its arcs are too few, or too similar, to correct six errors at the end by their lengths",
        ))?;
        let unit = |column: usize| if column < 3 { units.time } else { units.time / units.momentum() };
        let rows = (0..6 * arcs.len()).map(|index| gains[(index / 6, index % 6)] * unit(index % 6)).collect();
        Ok(Self { arcs, rows })
    }

    /// Checks that the arcs of a plan of `problem` determine its whole motion, and that the
    /// maneuver ends in a given state.
    ///
    /// # Errors
    /// Returns [`NoGains::Arcs`] with the obstacle, in words.
    pub fn suits(problem: &Problem) -> Result<(), NoGains> {
        suited(problem)
    }

    /// Returns the gain row of an arc: derivatives of its length by the six components of `z`.
    pub fn row(&self, arc: usize) -> &[f64] {
        &self.rows[6 * arc..6 * arc + 6]
    }

    /// Returns the change of the length of an arc \[s\] for a start that deviates from the plan by
    /// `z`, in rad and N·m·s.
    pub fn change(&self, arc: usize, z: &Vector6) -> f64 {
        self.row(arc).iter().zip(z.iter()).map(|(gain, z)| gain * z).sum()
    }

    /// Returns the lengths of all arcs \[s\] for a start that deviates from the plan by `z`.
    ///
    /// # Errors
    /// [`Reversed`] if the length of an arc would be zero or negative.
    pub fn lengths(&self, z: &Vector6) -> Result<Vec<f64>, Reversed> {
        let length = |(index, arc): (usize, &Arc)| {
            let length = arc.length + self.change(index, z);
            // This form also rejects NaN.
            if length > 0.0 { Ok(length) } else { Err(Reversed { arc: index, length }) }
        };
        self.arcs.iter().enumerate().map(length).collect()
    }

    /// Returns, for each component of `z`, the smallest error \[rad or N·m·s\] that reduces an arc
    /// to length zero if all other components are zero, and the index of this arc.
    pub fn reach(&self) -> [(f64, usize); 6] {
        std::array::from_fn(|column| {
            let least = |(index, arc): (usize, &Arc)| (arc.length / self.row(index)[column].abs(), index);
            let all = self.arcs.iter().enumerate().map(least);
            all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
        })
    }

    /// Returns the deviation `z = [log(R*_0ᵀ R_0); Π_0 − Π*_0]` of a start from the first node of
    /// the plan, in rad and N·m·s; `None` if the plan has no nodes.
    pub fn beside(problem: &Problem, plan: &Trajectory, start: &State) -> Option<Vector6> {
        let planned = lie::rotation_from_quaternion(plan.quaternion.first()?);
        let turn = lie::minus(&start.attitude, &planned);
        let momentum =
            problem.body.inertia.j() * (start.angular_velocity - plan.angular_velocity.first().copied()?);
        Some(Vector6::new(turn.x, turn.y, turn.z, momentum.x, momentum.y, momentum.z))
    }

    /// Returns the plan corrected for the start of `problem`. Its arcs have new lengths and keep
    /// their numbers of steps; its nodes record the true motion from that start.
    ///
    /// # Errors
    /// [`NotCorrected`] if the plan cannot be corrected for this start.
    pub fn corrected(&self, problem: &Problem, plan: &Trajectory) -> Result<Trajectory, NotCorrected> {
        let steps: usize = self.arcs.iter().map(|arc| arc.steps).sum();
        let z = Self::beside(problem, plan, &problem.start).filter(|_| plan.time.len() == steps + 1);
        let lengths = self.lengths(&z.ok_or(NotCorrected::Trajectory)?)?;
        let mut moved = plan.clone();
        let mut clock = plan.time[0];
        for (arc, length) in self.arcs.iter().zip(&lengths) {
            let (first, stretch) = (arc.first_step, length / arc.length);
            let begin = plan.time[first];
            for step in first..first + arc.steps {
                moved.time[step + 1] = clock + stretch * (plan.time[step + 1] - begin);
            }
            clock = moved.time[first + arc.steps];
        }
        moved.quaternion[0] = lie::quaternion_from_rotation(&problem.start.attitude);
        moved.angular_velocity[0] = problem.start.angular_velocity;
        let moved_problem = Problem { duration: Duration::Given(clock), ..problem.clone() };
        Flight::recorded(&moved_problem, &moved).ok_or(NotCorrected::Trajectory)
    }
}

/// Checks that the arcs of a plan determine its whole motion, and that the maneuver ends in a given
/// state.
fn suited(problem: &Problem) -> Result<(), NoGains> {
    let limits = problem.actuation.torque.limits();
    let refused = [
        (problem.motion == Motion::RigidBody, "the body translates"),
        (!problem.switches(), "its inputs do not switch"),
        (
            problem.actuation.torque.frame() == AxisFrame::Reference,
            "its torques are fixed in the reference frame",
        ),
        (problem.actuation.wheels.is_some(), "wheels store the momentum of its inputs"),
        (!problem.environment.is_free(), "a field acts on the body"),
        (!problem.constraints.is_empty(), "constraints have arcs on which no input is at its limit"),
        (limits.size.is_none(), "the norm of its torque is limited, so the direction of the torque varies"),
        (problem.shortest_pulse().is_some(), "its pulses have a minimum width"),
        (problem.end_condition != EndCondition::State, "its end attitude is free"),
    ];
    refused.iter().find(|(refused, _)| *refused).map_or(Ok(()), |(_, why)| Err(NoGains::Arcs(why)))
}

/// Returns the arcs of a plan: maximal runs of steps with constant inputs.
fn arcs(problem: &Problem, plan: &Trajectory) -> Result<Vec<Arc>, NoGains> {
    let (steps, limits) = (plan.time.len().saturating_sub(1), problem.actuation.torque.limits());
    let sizes = limits.size.as_deref().unwrap_or_default();
    let m = plan.input_count;
    if steps == 0 || m != sizes.len() || plan.input.len() < steps * m || plan.quaternion.is_empty() {
        return Err(NoGains::Arcs("the plan has no trajectory of arcs"));
    }
    let fuel = problem.objective.fuel().is_some();
    let mut arcs: Vec<Arc> = Vec::new();
    for step in 0..steps {
        let (inputs, length) = (plan.inputs(step), plan.time[step + 1] - plan.time[step]);
        let at = |(input, size): (&f64, &f64)| {
            let part = (input / size).abs();
            (part - 1.0).abs() <= AT_LIMIT || (fuel || limits.one_sided) && part <= AT_LIMIT
        };
        if !inputs.iter().zip(sizes).all(at) {
            return Err(NoGains::Arcs("an input is within its limits, as on a singular arc"));
        }
        let same = |arc: &&mut Arc| {
            let apart = arc.inputs.iter().zip(inputs).zip(sizes);
            apart.into_iter().all(|((a, b), size)| (a - b).abs() <= 2.0 * AT_LIMIT * size)
        };
        match arcs.last_mut().filter(same) {
            Some(arc) => {
                arc.steps += 1;
                arc.length += length;
            }
            None => arcs.push(Arc { first_step: step, steps: 1, length, inputs: inputs.to_vec() }),
        }
    }
    Ok(arcs)
}

#[cfg(test)]
mod tests;
