//! What a solve will hold in memory, told before it begins.
//!
//! A plan holds the states, costates and inputs of all its nodes at once, and the witnesses as much again. Where
//! limits or constraints act, Newton on the active set also holds its band matrix, and the convex iteration its cone
//! program with the factors: so much for each unknown and for each row of a stage. The coefficients are measured
//! (`cargo run --release -p evidence -- memory`), chosen so that no plan there takes more.
//!
//! # How does a plan know what memory it takes?
//!
//! By a measured rule (`optimize/search/memory.rs`): so many bytes a step, for each unknown and each row of a limit where the convex
//! road may be taken. `slew check` tells two figures, because Newton on the active set takes a fraction of what the convex
//! iteration takes, and which of them finds the way on a fine grid is known afterwards only. A plan of which even the smaller
//! does not fit into what the system gives (free memory, its group, `ulimit -v`) is refused with 6 and the steps that would
//! fit; one of which the larger does not is warned of. `cargo run --release -p evidence -- memory` holds both against what
//! plans take. An allocation that fails all the same ends with 6 as well: the standard library aborts, and the handler of
//! that signal ends with our code. That the words are the library's ("memory allocation of … bytes failed") is the price of
//! having no unsafe code; where a system promises more than it has, its killer comes first, which is what the estimate is
//! for.

use crate::maneuver::objective::Fuel;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::{Method, Settings};
use crate::maneuver::{Motion, Rule};
use crate::mechanics::actuators::{ActuatorSet, LimitKind};
use crate::optimize::discrete::control_law;
use crate::optimize::methods::scp::subproblem::BALL;

/// The program itself, its threads and small grids \[bytes\].
const BASE: f64 = 12e6;
/// Of each step, by what moves.
const NODE: f64 = 200.0;
const NODE_WITH_POSITION: f64 = 650.0;
/// Of each step in Newton's matrix and the derivatives: for each unknown of a stage, and for each row of a limit.
const NEWTON: [f64; 2] = [1300.0, 900.0];
/// The same in the cone program and its factors.
const CONVEX: [f64; 2] = [5000.0, 3000.0];

/// Peak memory of a plan \[bytes\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakMemory {
    /// What it takes as a rule.
    pub likely: f64,
    /// What it may take, where the convex iteration has to find the way on the requested grid, and not Newton.
    pub most: f64,
}

impl PeakMemory {
    /// Of a plan with its verification.
    pub fn of(problem: &Problem, settings: &Settings) -> Self {
        let steps = problem.steps as f64;
        let moves = problem.motion == Motion::RigidBody;
        let plain = BASE + steps * if moves { NODE_WITH_POSITION } else { NODE };
        let shooting = !settings.method.is_on_equal_steps() && control_law::obstacle(problem).is_none();
        let convex = settings.method == Method::Auto && problem.is_constrained() || !shooting;
        if problem.clone().planned_by(settings.method).switches() || !convex {
            return Self { likely: plain, most: plain };
        }
        let wheels = problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len());
        let unknowns = if moves { 12 } else { 6 + wheels } + problem.actuation.count();
        let of = |[by_unknown, by_row]: [f64; 2]| {
            plain + steps * (by_unknown * unknowns as f64 + by_row * rows(problem) as f64)
        };
        Self { likely: if shooting { plain } else { of(NEWTON) }, most: of(CONVEX) }
    }

    /// Steps of a maneuver that likely fit into `room` \[bytes\], in two digits; `None` where not even a few do.
    pub fn steps_within(problem: &Problem, settings: &Settings, room: f64) -> Option<usize> {
        let per_step = (Self::of(problem, settings).likely - BASE) / problem.steps as f64;
        let steps = ((room - BASE) / per_step).floor();
        if steps < Problem::MIN_STEPS as f64 {
            return None;
        }
        let unit = 10_usize.pow((steps.log10() as u32).saturating_sub(1));
        Some(steps as usize / unit * unit)
    }
}

/// Rows of all limits of one step.
fn rows(problem: &Problem) -> usize {
    let of_limits = problem.actuation.limits().map(|limit| match limit.kind {
        LimitKind::Norm => BALL,
        _ => 2 * limit.bounds.iter().filter(|bound| bound.is_finite()).count(),
    });
    // Each at the node and on the arc.
    let of_constraints = problem.constraints.iter().map(|constraint| match &constraint.rule {
        Rule::RateNorm(_) => 2 * BALL,
        Rule::RateAxes(_) => 12,
        Rule::Pointing(pointing) => 2 * pointing.pairs().count(),
    });
    // What has a kink in the cost, once for each side of it.
    let of_kinks = |set: &ActuatorSet| if Fuel::is_of_norm(set) { BALL } else { 2 * set.count() };
    let torque = Some(&problem.actuation.torque).filter(|_| problem.actuation.thrusters.is_none());
    let burning = [torque, problem.actuation.force.as_ref()];
    let burning = burning.into_iter().flatten().filter(|_| problem.objective.fuel().is_some());
    of_limits.chain(of_constraints).chain(burning.map(of_kinks)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::actuators::AxisFrame;
    use crate::testing::{Random, attitude_only, moving_ends};

    #[test]
    fn the_steps_that_are_said_to_fit_do_and_not_many_more_would() {
        let problem = attitude_only(moving_ends(&mut Random(1), AxisFrame::Body));
        let settings = Settings::default();
        let of = |steps: f64| PeakMemory::of(&problem.clone().with_steps(steps as usize), &settings).likely;
        for room in [2e7, 1e8, 4.5e9] {
            let steps = PeakMemory::steps_within(&problem, &settings, room).unwrap() as f64;
            assert!(of(steps) <= room && of(1.11 * steps) > room, "{steps} steps in {room} bytes");
        }
        assert_eq!(PeakMemory::steps_within(&problem, &settings, BASE), None);
    }
}
