//! The test that the discrete and the continuous witness describe the same motion.
//!
//! The discrete witness propagates the held torque at h, h/2, h/4 over a few windows, from the
//! state of the continuous witness at the start of each window. Its ends must converge to the ends
//! of the continuous witness at the order of the scheme. Steps h/8 and h/16 are added if the steps
//! are too long for the asymptotic regime, or if leading error terms happen to cancel.
//!
//! # Why do the order test and the symplectic witness run over windows?
//!
//! A fault of the scheme acts in every step. Both the error due to the fault and the discretisation
//! error over a window are proportional to the length of the window. The order test uses their
//! ratio, which is equal over a window and over the plan. Round-off has less time to grow in a
//! window, so the floor below which the witnesses agree is fifty times lower. The continuous
//! witness passes the whole plan and records its state at both ends of eight windows. The windows
//! are spread from the first step to the last. Together they cover 1/32 of the steps, and each has
//! at least two steps. A plan of 16 steps or fewer is a single window. Each finer run starts from
//! these states. `verify/order.rs` plants faults in the scheme (the gyroscopic term with the wrong
//! sign, a missing half kick, a reduced order, a torque one part in a million too large). The test
//! finds each fault as soon as the steps are so short that its effect exceeds the discretisation
//! error. Windows also show faults that whole plans hide: Lie–Euler from rest to rest has a
//! terminal error of second order, so a whole plan showed order 2, although the method has order 1
//! along the motion. A fault at a single place may lie outside the windows. The replay, the
//! continuous witness and the margins find it, because they pass every step. The plan file and the
//! summary state over how many steps each witness ran.

use super::discrete::Discrete;
use super::motion::{Inputs, Phase, Scale};
use super::verification::WitnessError;
use super::watch::Watch;
use super::window::Window;
use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::TerminalError;
use crate::propagate::plant::Plant;

/// Refinement factors of the plan's step.
const LEVELS: [usize; 5] = [1, 2, 4, 8, 16];

/// Largest number of steps of a refinement beyond h/4; it takes about two seconds.
const MAX_STEPS: usize = 4_000_000;

/// Tolerated shortfall of the observed order from the order of the scheme.
pub(super) const SLACK: f64 = 0.5;

/// Difference over a window, scaled and relative to the size of the motion, that counts as
/// round-off.
const ROUND_OFF: f64 = 2e-14;

/// Largest difference that amplified round-off can explain.
const AMPLIFIED: f64 = 1e-6;

/// Round-off of the propagations over a window, before the dynamics amplify it.
const START_ROUND_OFF: f64 = 4e-15;

/// The result of comparing the discrete with the continuous witness.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Comparison {
    /// Scaled distance of the ends at h, h/2, h/4, …, over all windows; NaN if a step was too long.
    pub(super) errors: Vec<f64>,
    /// Observed order between the finest two levels; `None` if the difference is round-off.
    pub(super) order: Option<f64>,
    /// Distance up to which the ends count as equal to round-off.
    pub(super) floor: f64,
    pub(super) passed: bool,
}

/// The data for comparing the continuous witness with another witness over the windows.
pub(super) struct Stage<'a> {
    pub(super) plant: &'a Plant<'a>,
    pub(super) inputs: &'a Inputs<'a>,
    pub(super) windows: &'a [Window],
    pub(super) watch: Watch<'a>,
}

/// Returns the Euclidean norm of the four parts of a terminal error.
fn norm(error: &TerminalError) -> f64 {
    let parts = [
        error.attitude_rad,
        error.momentum_relative,
        error.position_relative.unwrap_or(0.0),
        error.linear_momentum_relative.unwrap_or(0.0),
    ];
    parts.iter().map(|part| part * part).sum::<f64>().sqrt()
}

impl Stage<'_> {
    fn problem(&self) -> &Problem {
        self.plant.problem
    }

    /// Returns the number of steps of the plan in the windows.
    pub(super) fn steps(&self) -> usize {
        self.windows.iter().map(|window| window.steps.len()).sum()
    }

    /// Returns the size of the motion, scaled, to which rounding errors are relative.
    fn size(&self) -> f64 {
        let scale = Scale::of(self.problem());
        let size = |phase: &Phase| phase.momentum.norm() + phase.stored.norm();
        let ends = self.windows.iter().map(|window| size(&window.start).max(size(&window.end)));
        1.0 + ends.fold(0.0, f64::max) * scale.time / scale.inertia
    }

    /// Returns the scaled distance, over all windows, between the ends that `run` computes and the
    /// ends of the continuous witness.
    fn distance(&self, run: impl Fn(&Window) -> Result<Phase, WitnessError>) -> Result<f64, WitnessError> {
        let (problem, mut sum) = (self.problem(), 0.0);
        let scale = Scale::of(problem);
        for window in self.windows {
            sum += norm(&scale.distance(&run(window)?, &window.end, problem.motion)).powi(2);
        }
        Ok(sum.sqrt())
    }

    /// Returns the end of a window under the held torque, computed by the discrete witness with
    /// steps `h/refinement`.
    fn held_end(&self, window: &Window, start: &Phase, refinement: usize) -> Result<Phase, WitnessError> {
        let grid = &self.inputs.grid;
        let part = |k: usize| grid.step(k) / refinement as f64;
        let began = grid.after(window.steps.start);
        let mut body = Discrete::at(self.plant, start, grid.scheme(), part(window.steps.start), began);
        for k in window.steps.clone() {
            let held = self.inputs.held(k);
            self.watch.step(k)?;
            body.set_step(part(k));
            for _ in 0..refinement {
                body.advance(&held, &held)?;
            }
        }
        Ok(body.phase())
    }

    /// Compares the discrete with the continuous witness over the windows.
    pub(super) fn compare(&self) -> Result<Comparison, WitnessError> {
        self.compare_with(|window, refinement| self.held_end(window, &window.start, refinement))
    }

    /// Compares any propagation with steps `h/refinement` with the continuous witness over the
    /// windows.
    fn compare_with(
        &self,
        run: impl Fn(&Window, usize) -> Result<Phase, WitnessError>,
    ) -> Result<Comparison, WitnessError> {
        let (scheme, steps, size) = (self.problem().scheme, self.steps(), self.size());
        let mut found = Comparison { errors: vec![], order: None, floor: ROUND_OFF * size, passed: false };
        for refinement in LEVELS {
            if refinement > 4 && steps * refinement > MAX_STEPS {
                break;
            }
            let error = match self.distance(|window| run(window, refinement)) {
                Err(WitnessError::Stopped) => return Err(WitnessError::Stopped),
                error => error.unwrap_or(f64::NAN),
            };
            found.errors.push(error);
            if error <= found.floor {
                found.order = None;
                found.passed = true;
                return Ok(found);
            }
            let orders: Vec<f64> = found.errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
            found.order = orders.last().copied().filter(|order| order.is_finite());
            let enough = f64::from(scheme.order()) - SLACK;
            if orders.len() >= 2 && orders[orders.len() - 2..].iter().all(|order| *order >= enough) {
                found.passed = true;
                return Ok(found);
            }
        }
        // Of the last two orders, at least one of which is too low, the lower one is reported.
        let blamed = found.errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).rev().take(2);
        found.order = blamed.fold(found.order, |worst, order| worst.map(|worst| worst.min(order)));
        // Dynamics that amplify a disturbance of the start amplify round-off by the same factor.
        let finest = found.errors.last().copied().unwrap_or(f64::NAN);
        if finest < AMPLIFIED {
            found.floor = found.floor.max(START_ROUND_OFF * size * self.amplification()?);
            if finest <= found.floor {
                found.order = None;
                found.passed = true;
            }
        }
        Ok(found)
    }

    /// Returns the largest scaled distance over the windows between the ends of another accurate
    /// witness and the ends of the continuous witness, and the limit of this distance.
    pub(super) fn agreement(&self, ends: &[Phase]) -> Result<(f64, f64), WitnessError> {
        let (problem, size) = (self.problem(), self.size());
        let scale = Scale::of(problem);
        let pairs = self.windows.iter().zip(ends);
        let apart = pairs.map(|(window, end)| norm(&scale.distance(end, &window.end, problem.motion)));
        let apart = apart.fold(0.0, |worst: f64, apart| if apart <= worst { worst } else { apart });
        let share = self.steps() as f64 / problem.steps as f64;
        let limit = EXACT * share * size;
        if apart <= limit {
            return Ok((apart, limit));
        }
        let amplified = START_ROUND_OFF * size * self.amplification()?;
        // The comparison leaves the limit unchanged if the amplification is NaN.
        Ok((apart, if amplified > limit { amplified.min(AMPLIFIED * size) } else { limit }))
    }

    /// Returns the largest factor by which a small disturbance grows from the start of a window to
    /// its end.
    fn amplification(&self) -> Result<f64, WitnessError> {
        const DISTURBANCE: f64 = 1e-7;
        let problem = self.problem();
        let scale = Scale::of(problem);
        // This direction is not near a coordinate axis, so the fastest growing motion has a
        // component along it.
        let direction = Vector3::new(0.48, -0.60, 0.64);
        let change = DISTURBANCE * direction;
        let mut largest: f64 = 0.0;
        for window in self.windows {
            let start = &window.start;
            let disturbed = Phase {
                position: start.position + scale.length * change,
                linear_momentum: start.linear_momentum - scale.mass * scale.length / scale.time * change,
                attitude: start.attitude * lie::exp(&change),
                momentum: start.momentum + scale.inertia / scale.time * change,
                stored: start.stored,
            };
            match [start, &disturbed].map(|phase| self.held_end(window, phase, 1)) {
                [Ok(a), Ok(b)] => {
                    let grown = norm(&scale.distance(&a, &b, problem.motion)) / DISTURBANCE;
                    largest = largest.max(grown);
                }
                [Err(WitnessError::Stopped), _] | [_, Err(WitnessError::Stopped)] => {
                    return Err(WitnessError::Stopped);
                }
                _ => {}
            }
        }
        Ok(largest)
    }
}

/// Allowed distance between the ends of two accurate witnesses over a whole maneuver, scaled and
/// relative to the size of the motion. Over a part of the maneuver it is proportionally smaller.
const EXACT: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Matrix3;
    use crate::maneuver::problem::{Scheme, State};
    use crate::mechanics::body::{Body, Inertia};
    use crate::testing::full_inertia;
    use crate::verify::continuous::Continuous;
    use crate::verify::window::Marks;
    use std::sync::atomic::AtomicBool;

    /// A function that computes one step of length h from a phase under a torque, correctly or with
    /// a planted fault.
    type Step = fn(&Plant, &Phase, f64, &Vector3) -> Phase;

    /// Applies the correct step: half kick, drift, half kick.
    fn verlet(plant: &Plant, phase: &Phase, h: f64, torque: &Vector3) -> Phase {
        step(plant, phase, h, [0.5, 0.5], torque, |turn, momentum| turn.tr_mul(momentum))
    }

    fn step(
        plant: &Plant,
        phase: &Phase,
        h: f64,
        kicks: [f64; 2],
        torque: &Vector3,
        carried: fn(&Matrix3, &Vector3) -> Vector3,
    ) -> Phase {
        let momentum = phase.momentum + kicks[0] * h * torque;
        let implicit = super::super::implicit::Implicit::new(&plant.problem.body.inertia);
        let f = implicit.solve(&(h * momentum), &Vector3::zeros()).unwrap();
        let turn = lie::exp(&f);
        let momentum = carried(&turn, &momentum) + kicks[1] * h * torque;
        Phase { attitude: phase.attitude * turn, momentum, ..*phase }
    }

    /// Possible faults of the scheme, from coarse to nearly invisible, each with the number of
    /// steps from which its effect exceeds the discretisation error.
    const FAULTS: [(&str, usize, Step); 7] = [
        ("gyroscopic term of the wrong sign", 0, |plant, phase, h, torque| {
            step(plant, phase, h, [0.5, 0.5], torque, |turn, momentum| turn * momentum)
        }),
        ("no gyroscopic term", 0, |plant, phase, h, torque| {
            step(plant, phase, h, [0.5, 0.5], torque, |_, momentum| *momentum)
        }),
        ("first half kick left out", 0, |plant, phase, h, torque| {
            step(plant, phase, h, [0.0, 0.5], torque, |turn, momentum| turn.tr_mul(momentum))
        }),
        ("last half kick left out", 0, |plant, phase, h, torque| {
            step(plant, phase, h, [0.5, 0.0], torque, |turn, momentum| turn.tr_mul(momentum))
        }),
        ("order reduced: the whole kick at the end", 0, |plant, phase, h, torque| {
            step(plant, phase, h, [0.0, 1.0], torque, |turn, momentum| turn.tr_mul(momentum))
        }),
        ("order reduced: half kicks of unequal size", 1000, |plant, phase, h, torque| {
            step(plant, phase, h, [0.51, 0.49], torque, |turn, momentum| turn.tr_mul(momentum))
        }),
        ("a torque of one in a million too much", 10_000, |plant, phase, h, torque| {
            step(plant, phase, h, [0.5, 0.5], &(1.000_001 * torque), |turn, momentum| turn.tr_mul(momentum))
        }),
    ];

    fn judged(problem: &Problem, rows: &[f64], step: Step) -> Comparison {
        let plant = Plant::new(problem);
        let inputs = Inputs::new(problem, rows);
        let start = Phase::of(problem, &problem.start);
        let (mut body, mut marks) =
            (Continuous::new(&plant, &start), Marks::new(problem, &inputs.grid, &start));
        marks.pass(0, &body);
        for k in 0..problem.steps {
            let held = inputs.held(k);
            body.advance(k as f64 * problem.step(), problem.step(), &held, &held).unwrap();
            marks.pass(k + 1, &body);
        }
        let (windows, stopped) = (marks.windows(), AtomicBool::new(false));
        let stage = Stage {
            plant: &plant,
            inputs: &inputs,
            windows: &windows,
            watch: Watch::new(&stopped, &|| false),
        };
        let run = |window: &Window, refinement: usize| {
            let mut phase = window.start;
            let h = problem.step() / refinement as f64;
            for k in window.steps.clone() {
                for _ in 0..refinement {
                    phase = step(&plant, &phase, h, &inputs.held(k).torque);
                }
            }
            Ok(phase)
        };
        stage.compare_with(run).unwrap()
    }

    /// A few windows suffice to find a fault that a scheme has in every step, on any grid, from
    /// rest to rest and from a moving start.
    #[test]
    fn a_fault_planted_in_the_scheme_is_found_on_the_windows() {
        let moments = Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5)).unwrap();
        for inertia in [full_inertia(), moments] {
            for rate in [Vector3::zeros(), Vector3::new(0.3, -0.4, 0.6)] {
                for steps in [12, 100, 1000, 10_000] {
                    let start = State::attitude(lie::exp(&Vector3::new(0.4, -0.3, 0.5)), rate);
                    let body = Body { inertia: inertia.clone(), mass: None };
                    let problem = Problem::attitude(body, start, start, 2.0)
                        .with_steps(steps)
                        .with_scheme(Scheme::LieVerlet);
                    let torque = |row: usize, axis: usize| {
                        let t = row as f64 / steps as f64;
                        (1.0 + axis as f64 + 3.0 * t).sin() * (2.0 - axis as f64 * t)
                    };
                    let rows: Vec<f64> =
                        (0..=steps).flat_map(|row| (0..3).map(move |axis| torque(row, axis))).collect();
                    let right = judged(&problem, &rows, verlet);
                    assert!(right.passed, "{rate} {steps}: {right:?}");
                    for (fault, visible, step) in FAULTS {
                        let found = judged(&problem, &rows, step);
                        assert!(!found.passed || steps < visible, "{fault}, {rate} {steps}: {found:?}");
                    }
                }
            }
        }
    }
}
