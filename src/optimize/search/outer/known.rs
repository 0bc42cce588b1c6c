//! A plan within limits near a motion that is almost the plan, such as the plan of a finished
//! search on another grid or to a nearby end.

use crate::maneuver::problem::{Formulation, Motion, Problem, Stepping};
use crate::maneuver::settings::Method;
use crate::maneuver::solution::{Outcome, Solution, Trajectory};
use crate::optimize::discrete::control_law;
use crate::optimize::search::context::Context;
use crate::optimize::search::given_duration::{search_of, searched};
use crate::optimize::search::ladder::Ask;
use crate::optimize::search::outer::free_end::stated;
use crate::optimize::search::record::goal::cheapest;

/// Solves a maneuver by the interior-point method from one motion alone; `None` if that finds no
/// plan or another method should be used.
pub fn along(problem: &Problem, context: &Context, motion: &Trajectory) -> Option<Solution> {
    // If torque limits alone may determine the plan, shooting computes its arcs or its extremal
    // more accurately.
    let arcs = problem.stepping == Stepping::Formulated && problem.clone().planned_on_arcs().switches();
    let by_chain = match Formulation::of(problem) {
        Formulation::Chain => !arcs && problem.duration.at_most().is_none(),
        Formulation::Extremal => {
            let alone = problem.stepping == Stepping::Equal || problem.actuation.wheels.is_some();
            alone && control_law::obstacle(problem).is_some()
        }
        Formulation::Switching => false,
    };
    let lasting = *motion.time.last()?;
    if !by_chain || !matches!(context.settings.method, Method::Auto | Method::InteriorPoint) {
        return None;
    }
    let (stated, goal) = stated(problem);
    let stated = stated.lasting(problem.duration.known().unwrap_or(lasting));
    let lands = context.lands() || stated.met().is_some();
    let ask = Ask { along: Some(motion), lands, ..Ask::of_goal(goal, context.settings) };
    let found = match (&ask.goal, stated.motion) {
        (None, _) => searched(&stated, context, ask),
        (Some(_), Motion::Attitude) => of_goal::<6>(&stated, context, ask)?,
        (Some(_), Motion::RigidBody) => of_goal::<12>(&stated, context, ask)?,
    };
    let ends_it = matches!(found.outcome, Outcome::Converged | Outcome::Interrupted | Outcome::TimeLimit);
    let (ladder, solve_time) = (context.ladder.take(), context.began.elapsed().as_secs_f64());
    ends_it.then_some(Solution { ladder, solve_time, ..found })
}

/// Solves a maneuver with an objective other than effort, or with a free duration.
fn of_goal<const N: usize>(stated: &Problem, context: &Context, ask: Ask) -> Option<Solution> {
    let search = search_of::<N>(stated, context, ask);
    let (found, cheapest) = cheapest(&search);
    Some(cheapest?.written(&search, &found))
}
