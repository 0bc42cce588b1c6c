//! The kind of discrete problem as which a maneuver is planned.

use super::Problem;

/// The steps that a plan of minimum time or fuel is to have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stepping {
    /// The steps of its formulation.
    #[default]
    Formulated,
    /// Equal ones, also where inputs could switch between them.
    Equal,
    /// The steps of its arcs: no constraint is active.
    Arcs,
    /// The steps of a recorded motion, of any lengths, over which its inputs are held. No plan has
    /// them: such a maneuver is flown, and gains are designed along it.
    Recorded,
}

/// The discrete problem that a maneuver is planned as.
///
/// ```text
///                      what the shooting takes        more: cones, rates, wheels; equal steps
/// effort, T given      Extremal                       Extremal
/// effort, T sought     Chain                          Chain
/// time, fuel           Switching                      Chain
/// ```
///
/// Time and fuel that are planned as a chain have the plan of [`Formulation::Switching`] where that
/// meets every constraint: a constraint that does not act does not choose the formulation
/// ([`Solution::on_grid`]).
///
/// [`Solution::on_grid`]: crate::maneuver::Solution::on_grid
///
/// Only plans that are [`Formulation::Switching`] have steps of unequal lengths, with inputs that
/// are held over them; all others have their inputs at the nodes of equal steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formulation {
    /// Least effort in a duration that is known: an extremal of the discrete action, by shooting,
    /// or within limits by the interior point.
    Extremal,
    /// Minimum time or fuel of a body that nothing acts on, under limits of the torques alone:
    /// arcs, and steps that end where inputs switch.
    Switching,
    /// Minimum time or fuel, or least effort in a free duration, on the chain of equal steps, with
    /// the duration as a state.
    Chain,
}

impl Formulation {
    /// Returns the formulation of a maneuver.
    pub fn of(problem: &Problem) -> Self {
        let given_end = !problem.ends_in_any_attitude();
        // The shooting differentiates by the duration what only turns, and knows arcs of a body
        // that nothing acts on.
        let jumping = match problem.stepping {
            Stepping::Formulated => !problem.has_shaping_limits(),
            Stepping::Equal => false,
            Stepping::Recorded => true,
            Stepping::Arcs => !problem.has_shaping_inputs(),
        };
        let taken = given_end && jumping;
        // Arcs are placed by conditions on all six states, which in a plane leave four of them
        // undetermined.
        let whole = || problem.actuation.torque.rank().0 == 3;
        match (problem.objective.switches(), problem.duration.known()) {
            (true, _) if taken && problem.is_free_turn() && whole() => Self::Switching,
            (true, _) | (false, None) => Self::Chain,
            (false, Some(_)) => Self::Extremal,
        }
    }
}
