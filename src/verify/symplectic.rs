//! The symplectic witness: the held torque through a variational integrator of order 6, 8 or 12, window by window.
//!
//! ```text
//! curves of degree s in the natural chart, action at s Gauss points, steps of at most 0.2 rad
//! ```
//! It integrates Hamilton's principle where the continuous witness integrates the equations of motion, in a
//! rotation vector where that has a quaternion, and solves for what that evaluates. Of the planner's code it
//! uses none, and of the field force and moment alone.

use super::WitnessError;
use super::motion::{Inputs, Phase};
use super::watch::Watch;
use super::window::Window;
use crate::mechanics::body::Body;
use crate::mechanics::environment::Pose;
use crate::propagate::integrator::{
    Galerkin, Integrator, Momentum, Quadrature, StepError, System, SystemState,
};
use crate::propagate::plant::{HeldLoad, Output, Plant};
use std::sync::Arc;

/// Largest turn of a step [rad]. Steps of the plan are divided until it holds.
const LARGEST_TURN: f64 = 0.2;

/// Most parts of a step of the plan, and most steps in all: a few seconds.
const MOST_PARTS: f64 = 1e4;
const MOST_STEPS: f64 = 4e6;

/// The degree whose error over a maneuver of steps of this turn is round-off.
fn degree(turn: f64) -> usize {
    match turn {
        ..=3e-3 => 3,
        ..=2e-2 => 4,
        _ => 6,
    }
}

/// Why it does not judge.
pub(super) const WHEELS: &str = "does not judge reaction wheels";
const TOO_LONG: &str = "would take too many steps";
pub(super) const NO_CONVERGENCE: &str = "its equations do not converge";

/// Where it ends in each window, and its order; or why it cannot judge: wheels, steps too many, or a field so stiff
/// that its iteration does not converge.
pub(super) type Ends = Result<(Vec<Phase>, usize), &'static str>;

/// How many times finer its own steps may be taken where it misses the continuous witness: a field or a torque that
/// changes the rate within a long step of the plan makes its first steps too long.
pub(super) const FINER: [usize; 3] = [1, 4, 16];

/// Ends of the held plan over `windows`, each from where the continuous witness begins it, with steps `finer` times as
/// short as the turn asks for.
pub(super) fn ends(
    plant: &Plant,
    inputs: &Inputs,
    windows: &[Window],
    finer: usize,
    watch: &Watch,
) -> Result<Ends, WitnessError> {
    let problem = plant.problem;
    let peak_rate = windows.iter().fold(0.0, |peak: f64, window| peak.max(window.peak_rate));
    let grid = &inputs.grid;
    let longest = if grid.is_uniform() {
        grid.step(0)
    } else {
        (0..grid.steps()).map(|k| grid.step(k)).fold(0.0, f64::max)
    };
    let turn = longest * peak_rate;
    let parts = (turn / LARGEST_TURN).ceil().max(1.0) * finer as f64;
    let steps: usize = windows.iter().map(|window| window.steps.len()).sum();
    if problem.actuation.wheels.is_some() {
        return Ok(Err(WHEELS));
    }
    // Written so that a NaN ends here.
    let bearable = parts <= MOST_PARTS && parts * steps as f64 <= MOST_STEPS;
    if !bearable {
        return Ok(Err(TOO_LONG));
    }
    let mass = problem.body.mass.filter(|_| plant.moves);
    let body = Body { inertia: problem.body.inertia.clone(), mass };
    let load = Arc::new(HeldLoad::new(problem, Output::none()));
    let unusable = |_| WitnessError::NotFinite { time: 0.0 };
    let system = System::new(vec![body], Some(load.clone())).map_err(unusable)?;
    let system = system.with_frame_rate(plant.frame_rate());
    // Shorter steps of the same method.
    let degree = degree(turn * finer as f64 / parts);
    let mut ends = Vec::with_capacity(windows.len());
    let mut method: Option<Galerkin> = None;
    for window in windows {
        let mut state = state(&window.start);
        system.check(&state).map_err(unusable)?;
        let mut fresh = true;
        for k in window.steps.clone() {
            load.hold(inputs.held(k));
            let time = grid.after(k);
            let made = |state: &SystemState| {
                Galerkin::new(&system, state, grid.step(k) / parts, degree, Quadrature::Gauss)
            };
            // Equal steps share a method; it is made anew for a step of another length.
            let method = match &mut method {
                Some(method) if grid.is_uniform() => {
                    if fresh {
                        method.restart(&state);
                    }
                    method
                }
                other => other.insert(made(&state)),
            };
            fresh = false;
            for part in 0..parts as usize {
                watch.step(part)?;
                match method.step(&[]) {
                    Ok(()) => {}
                    Err(StepError::NotFinite) => return Err(WitnessError::NotFinite { time }),
                    // Steps too long for its iteration, which are not too long for the plan.
                    Err(_) => return Ok(Err(NO_CONVERGENCE)),
                }
            }
            if !grid.is_uniform() || k + 1 == window.steps.end {
                state = method.state().clone();
            }
        }
        let (pose, momentum) = (state.poses()[0], state.momenta()[0]);
        ends.push(Phase {
            position: pose.position,
            linear_momentum: momentum.linear,
            attitude: pose.attitude,
            momentum: momentum.angular,
            stored: window.start.stored,
        });
    }
    Ok(Ok((ends, 2 * degree)))
}

fn state(phase: &Phase) -> SystemState {
    let pose = Pose { position: phase.position, attitude: phase.attitude };
    let momentum = Momentum { linear: phase.linear_momentum, angular: phase.momentum };
    SystemState::new(vec![pose], vec![momentum])
}
