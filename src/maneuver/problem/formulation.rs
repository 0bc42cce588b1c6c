//! The discrete problem with which a maneuver is planned.

use super::Problem;

/// The kind of steps of a minimum-time or minimum-fuel plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stepping {
    /// The steps of the formulation that suits the problem.
    #[default]
    Formulated,
    /// Equal steps, even if inputs could switch between nodes.
    Equal,
    /// The steps of switching arcs: no constraint is active.
    Arcs,
    /// The steps of a recorded motion, of any lengths, over which its inputs are held. Such a
    /// maneuver is not planned: it is flown, and gains are designed along it.
    Recorded,
}

/// The discrete problem with which a maneuver is planned.
///
/// ```text
///                      what the shooting takes        more: cones, rates, wheels; equal steps
/// effort, T given      Extremal                       Extremal
/// effort, T sought     Chain                          Chain
/// time, fuel           Switching                      Chain
/// ```
///
/// A minimum-time or minimum-fuel problem with constraints is planned as a chain. If its plan by
/// [`Formulation::Switching`] meets every constraint, it has that plan: inactive constraints do not
/// change the formulation ([`Solution::on_grid`]).
///
/// [`Solution::on_grid`]: crate::maneuver::Solution::on_grid
///
/// Only plans of [`Formulation::Switching`] have steps of unequal lengths, over which inputs are
/// held. All other plans have their inputs at the nodes of a uniform grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formulation {
    /// Minimum effort in a known duration: an extremal of the discrete action, found by the
    /// shooting, or by the interior point if limits require it.
    Extremal,
    /// Minimum time or fuel of a free body under torque limits alone: arcs, and steps that end
    /// where inputs switch.
    Switching,
    /// Minimum time or fuel, or minimum effort in a free duration, on a uniform grid. The duration
    /// is a state of the chain of steps.
    Chain,
}

impl Formulation {
    /// Returns the formulation of a maneuver.
    pub fn of(problem: &Problem) -> Self {
        let given_end = !problem.ends_in_any_attitude();
        // The shooting differentiates with respect to the duration only for rotations, and its arcs
        // are for a body on which nothing else acts.
        let jumping = match problem.stepping {
            Stepping::Formulated => !problem.has_shaping_limits(),
            Stepping::Equal => false,
            Stepping::Recorded => true,
            Stepping::Arcs => !problem.has_shaping_inputs(),
        };
        let taken = given_end && jumping;
        // The conditions that place arcs use all six states. A maneuver in a plane leaves four
        // states undetermined.
        let whole = || problem.actuation.torque.rank().0 == 3;
        match (problem.objective.switches(), problem.duration.known()) {
            (true, _) if taken && problem.is_free_turn() && whole() => Self::Switching,
            (true, _) | (false, None) => Self::Chain,
            (false, Some(_)) => Self::Extremal,
        }
    }
}
