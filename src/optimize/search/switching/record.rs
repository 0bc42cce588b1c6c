//! Record of a plan on its grid: the motion from the start under the inputs of its steps, in SI
//! units.

use super::Scaled;
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::{Optimality, Sense, Solution, TerminalError, Trajectory};
use crate::maneuver::switching::{Structure, Switching};
use crate::mechanics::drift_equation;
use crate::numerics::compensated::Sum;
use crate::optimize::methods::switching::extremal::Extremal;
use crate::optimize::methods::switching::flow::Node;
use crate::optimize::methods::switching::grid_step::Torque;
use crate::optimize::methods::switching::on_grid::OnGrid;
use crate::optimize::methods::switching::scaled::{input_of, inputs, shared};
use crate::optimize::methods::switching::tuning::NO_LENGTH;
use crate::optimize::search::way::Follower;
use crate::{Matrix3, Vector3, lie};
use nalgebra::{Vector1, Vector6};

/// Fraction of its limit below which an input of a smoothed plan counts as between its limits.
const WITHIN: f64 = 0.9;
/// Fraction of the steps on which an input must be between its limits to count as singular.
const FOR: f64 = 1.0 / 12.0;

/// Number of steps with which the motion without inputs is computed.
const COAST_STEPS: usize = 256;

/// A plan on its grid, with its recorded solution.
pub(super) struct Planned {
    /// The solution, without rivals and without the record of the strategies' runs.
    pub solution: Solution,
    pub switching: Switching,
    /// Rotation and momentum error at the end, scaled.
    pub miss: Vector6<f64>,
    pub path: Follower,
    pub grid: OnGrid,
}

impl Planned {
    /// Returns the largest component of the terminal error.
    pub fn error(&self) -> f64 {
        self.solution.terminal.largest()
    }
}

/// Terminal error above which a plan is corrected for round-off: half of the default tolerance.
const OF_ROUND_OFF: f64 = 5e-13;

impl Scaled<'_> {
    /// Replays a plan from the start and records every node.
    ///
    /// Compensated sums reveal the round-off in the products of ten thousand rotations on the grid;
    /// costates and lengths are corrected for it. For a long duration a burn is so short that the
    /// last digits of the recorded times are a noticeable part of it. Then the recorded inputs give
    /// the impulses of the plan in the recorded times, and are below their limits by these digits.
    pub(super) fn record(&self, grid: &OnGrid) -> Option<Planned> {
        let mut best = self.replayed(grid, false)?;
        for impulses in [false, true] {
            let next = match impulses {
                _ if best.error() <= OF_ROUND_OFF => None,
                false => grid.clone().nearer(&self.extremal, &best.miss),
                // Pulses are exactly off or at a limit.
                true => self.problem.shortest_pulse().is_none().then(|| grid.clone()),
            };
            let next = next.and_then(|grid| self.replayed(&grid, impulses));
            best = next.filter(|next| next.error() < best.error()).unwrap_or(best);
        }
        Some(best)
    }

    /// Replays a plan from the start with its inputs, or with inputs that give its impulses in the
    /// recorded times.
    fn replayed(&self, grid: &OnGrid, impulses: bool) -> Option<Planned> {
        let Self { problem, extremal, units } = self;
        let least = NO_LENGTH * grid.duration();
        let kept: Vec<usize> =
            (0..grid.steps.len()).filter(|k| grid.step_length(&grid.steps[*k]) > least).collect();
        let count = problem.actuation.count();
        let mut trajectory = Trajectory { input_count: count, ..Trajectory::default() };
        // Plain sums of ten thousand terms would have an error of some parts in 1e12 of the rates
        // at the end.
        let (mut r, mut pi) = (Sum::new(Matrix3::identity()), Sum::new(extremal.j * extremal.start_rate));
        let mut m_e = (grid.m, grid.nodes[0].e);
        let (mut path, mut clock, mut before) = (Follower::new(), Sum::new(Vector1::zeros()), 0.0);
        let mut time = 0.0_f64;
        let (mut within, mut cost) = (vec![0_usize; count], 0.0);
        let rate =
            |row: &[f64]| problem.objective.fuel().map_or(1.0, |fuel| fuel.rate(&problem.actuation, row));
        let turning = extremal.axes().is_empty();
        for index in 0..=kept.len() {
            if extremal.halt.is_raised_at(index) {
                return None;
            }
            let velocity = extremal.j_inverse * pi.value / units.time;
            path.node(&(problem.start.attitude * r.value), velocity, time - before);
            before = time;
            trajectory.time.push(time);
            trajectory.quaternion.push(path.lifted());
            trajectory.angular_velocity.push(velocity);
            let (zeta, e) = m_e;
            trajectory.costates.extend((zeta * units.cost()).iter());
            trajectory.costates.extend((e * (units.cost() / units.momentum())).iter());
            let Some(k) = kept.get(index).copied() else { break };
            let step = &grid.steps[k];
            let row = match (grid.signs.get(step.arc), step.torque) {
                (Some(signs), _) if !turning => inputs(problem, signs),
                (None, Torque::Smooth(epsilon)) if !turning => {
                    let mean = 0.5 * (grid.nodes[k].e + grid.nodes[k + 1].e);
                    let levels = extremal.inputs(&mean, epsilon);
                    for (level, value) in levels.iter().enumerate() {
                        within[input_of(problem, level)] += usize::from(value.abs() < WITHIN);
                    }
                    inputs(problem, &levels)
                }
                _ => shared(problem, units, &grid.torques[k])?,
            };
            let length = grid.step_length(step);
            // The step as the witnesses compute it, with the length from the recorded times.
            clock.add(&Vector1::new(length));
            let mut reached = clock.value.x * units.time;
            // An input must not exceed its limit because of a last digit.
            let needed = length * units.time;
            if impulses && reached - time < needed && row.iter().any(|input| *input != 0.0) {
                // Earlier burns advance the clock by a last digit each.
                reached = reached.max((time + needed).next_down());
                while reached - time < needed {
                    reached = reached.next_up();
                }
            }
            let h = (reached - time) / units.time;
            time = reached;
            let row: Vec<f64> =
                if impulses { row.iter().map(|input| input * (length / h)).collect() } else { row };
            cost += if impulses { h } else { length } * units.time * rate(&row);
            let torque = problem.actuation.torque.output(&row);
            trajectory.input.extend(&row);
            trajectory.torque.push(torque);
            let torque = torque / units.torque;
            pi.add(&(0.5 * h * torque));
            let turn = drifted(extremal, &(h * pi.value))?;
            r.add(&(r.value * turn));
            pi.add(&turn.tr_mul(&pi.value));
            pi.add(&(0.5 * h * torque));
            let node = &grid.nodes[k + 1];
            m_e = (node.r.tr_mul(&grid.m), node.e);
        }
        let scaled_duration = grid.duration();
        let momentum = (pi.value - extremal.j * extremal.end_rate).norm() * scaled_duration;
        let steps = kept.len() as f64;
        let singular_inputs = (0..count).filter(|input| within[*input] as f64 > FOR * steps).collect();
        let beside_optimum = grid.beside_optimum;
        let solution = Solution {
            steps: kept.len(),
            step: if kept.is_empty() { 0.0 } else { before / steps },
            // The time of the last node is the duration in all records.
            cost: if problem.objective.is_duration() { before } else { cost },
            iterations: grid.iterations,
            terminal: TerminalError {
                attitude_rad: lie::log(&extremal.end_attitude.tr_mul(&r.value)).norm(),
                momentum_relative: momentum / (extremal.j.trace() / 3.0),
                ..TerminalError::default()
            },
            optimality: Optimality {
                tested: true,
                stationarity: grid.residual,
                rank: 6,
                ..Optimality::UNTESTED
            },
            sense: sense(problem, extremal, scaled_duration, &path),
            turned_deg: path.turned_deg(),
            trajectory,
            ..Solution::unsolved(problem, f64::NAN)
        };
        Some(Planned {
            solution,
            switching: Switching { singular_inputs, beside_optimum, ..untold(Structure::BangBang) },
            miss: extremal.miss(&Node { r: r.value, pi: pi.value, e: m_e.1 }),
            path,
            grid: grid.clone(),
        })
    }
}

/// Returns the record of a switching structure with all other fields unknown.
pub(super) fn untold(structure: Structure) -> Switching {
    Switching {
        structure,
        continuous_duration_s: f64::NAN,
        continuous_cost: f64::NAN,
        gap: f64::NAN,
        eigenaxis_s: None,
        switches: 0,
        singular_inputs: Vec::new(),
        smoothing: None,
        beside_optimum: false,
        arcs: Vec::new(),
        pulses: None,
    }
}

/// Returns the rotation on a step minus the identity, from the product of momentum and step length.
fn drifted(extremal: &Extremal, momentum: &Vector3) -> Option<Matrix3> {
    drift_equation::solve(&extremal.j, &extremal.j_inverse, momentum).map(|c| lie::cayley_minus_identity(&c))
}

/// Returns the homotopy class of a path. It is short if the path ends on the sheet that the motion
/// without inputs, continued by the shortest rotation to the end, reaches.
fn sense(problem: &Problem, extremal: &Extremal, duration: f64, path: &Follower) -> Sense {
    let start = &problem.start.attitude;
    let h = duration / COAST_STEPS as f64;
    let (mut r, mut pi) = (Matrix3::identity(), extremal.j * extremal.start_rate);
    let mut coast = Follower::begun(start);
    for _ in 0..COAST_STEPS {
        let Some(turn) = drifted(extremal, &(h * pi)) else { break };
        (r, pi) = (r + r * turn, pi + turn.tr_mul(&pi));
        coast.attitude(&(start * r));
    }
    let rest = lie::log(&r.tr_mul(&extremal.end_attitude));
    if coast.turned_by(&rest).is_on_the_sheet_of(path) { Sense::Short } else { Sense::Long }
}
