//! The symplectic witness: propagation of the held torque over each window by a variational
//! integrator of order 6 to 12.
//!
//! ```text
//! curves of degree s in the natural chart, action at s Gauss points, steps of at most 0.2 rad
//! ```
//! This witness discretises Hamilton's principle, while the continuous witness integrates the
//! equations of motion. It uses a rotation vector instead of a quaternion, and solves implicitly
//! for quantities that the continuous witness evaluates. It uses no code of the planner; from the
//! force field it uses only force and moment.

use super::motion::{Inputs, Phase};
use super::verification::WitnessError;
use super::watch::Watch;
use super::window::Window;
use crate::mechanics::body::Body;
use crate::mechanics::environment::Pose;
use crate::propagate::integrator::{
    Galerkin, Integrator, Momentum, Quadrature, StepError, System, SystemState,
};
use crate::propagate::plant::{HeldLoad, Output, Plant};
use std::sync::Arc;

/// Largest turn in a step [rad]. Steps of the plan are divided until this bound holds.
const LARGEST_TURN: f64 = 0.2;

/// Maximum number of parts of one step of the plan.
const MOST_PARTS: f64 = 1e4;
/// Maximum total number of steps, which take a few seconds.
const MOST_STEPS: f64 = 4e6;

/// Each polynomial degree with the largest turn of a step for which the error over a radian is
/// round-off, for free bodies from a needle to a disc.
const DEGREES: [(usize, f64); 4] = [(3, 5e-3), (4, 4e-2), (5, 0.1), (6, LARGEST_TURN)];

/// Returns the lowest degree that suffices for steps with this turn \[rad\].
fn degree(turn: f64) -> usize {
    let does = |(_, most): &&(usize, f64)| turn <= *most;
    DEGREES.iter().find(does).map_or(6, |(degree, _)| *degree)
}

/// The reason for not checking a plan with reaction wheels.
pub(super) const WHEELS: &str = "does not judge reaction wheels";
/// The reason for not checking a plan that would need too many steps.
const TOO_LONG: &str = "would need too many steps";
/// The reason for not checking a plan on which the implicit iteration does not converge.
pub(super) const NO_CONVERGENCE: &str = "its equations do not converge";

/// The state of the symplectic witness at the end of each window, and the order of its method. If
/// it cannot check the plan, the reason: wheels, too many steps, or a field so stiff that its
/// iteration does not converge.
pub(super) type Ends = Result<(Vec<Phase>, usize), &'static str>;

/// Factors by which the witness shortens its steps if it disagrees with the continuous witness. The
/// first steps are too long if a field or a torque changes the rate within a long step of the plan.
pub(super) const FINER: [usize; 3] = [1, 4, 16];

/// Propagates the held torque over each of `windows`, from the state of the continuous witness at
/// its start. The steps are `finer` times shorter than the turn requires. Returns the state at each
/// end.
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
    // The comparison rejects NaN.
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
    // Shorter steps than the turn requires keep the degree of that turn.
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
            // Steps of equal length share a method; another length needs a new one.
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
                    // The step is too long for the iteration of this witness, although not for the
                    // plan.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::body::Inertia;
    use crate::propagate::integrator::EulerPoincare;
    use crate::testing::Random;
    use crate::{Matrix3, Vector3};

    /// Returns momentum and attitude after a rotation by `turn` \[rad\] in `steps` steps, from the
    /// angular velocity `rate` of norm 1.
    fn end(inertia: &Inertia, degree: usize, rate: &Vector3, turn: f64, steps: usize) -> (Vector3, Matrix3) {
        let step = turn / steps as f64;
        let mut body = EulerPoincare::new(inertia, degree, Quadrature::Gauss, step).unwrap();
        let (mut momentum, mut attitude) = (inertia.j() * rate, Matrix3::identity());
        for _ in 0..steps {
            let step = body.step(&momentum).unwrap();
            (momentum, attitude) = (step.momentum, attitude + attitude * step.turn);
        }
        (momentum, attitude)
    }

    /// The error is indistinguishable from round-off at the largest turn of each degree. A turn
    /// four times as large, or twice for the largest one, shows the error, and the order 2s
    /// predicts the error at the smaller turn.
    #[test]
    fn the_error_of_each_degree_is_round_off_where_it_is_taken() {
        let mut random = Random(19);
        let bodies = [
            [1.0, 2.0, 3.0],
            [1.0, 2.0, 2.5],
            [1e-3, 1.0, 1.0009],
            [1.0, 10.0, 10.9],
            [1.0, 1.0, 1.999],
            [1.0, 1.0, 1e-2],
        ];
        for (degree, most) in DEGREES {
            let turn = 4.0 * most.min(0.1);
            let mut worst: f64 = 0.0;
            for moments in bodies {
                let inertia = Inertia::diagonal(moments.into()).unwrap();
                for _ in 0..30 {
                    let rate = random.vector3().normalize();
                    let ends = [end(&inertia, degree, &rate, turn, 1), end(&inertia, 6, &rate, turn, 8)];
                    let momentum = (ends[0].0 - ends[1].0).norm() / ends[1].0.norm();
                    let attitude = (ends[0].1 - ends[1].1).norm();
                    worst = worst.max(momentum.max(attitude) / turn);
                }
            }
            let there = worst * (most / turn).powi(2 * degree as i32);
            assert!(there < 1e-15, "degree {degree}: {worst:e}, {there:e} at {most}");
        }
    }
}
