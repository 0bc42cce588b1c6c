//! The hold at a stop: at rest, or on a moving target.
//!
//! A hold has no free choice. The target determines the attitudes at all nodes, and a free roll
//! evolves by the shortest rotation from node to node, so that the body never turns about its
//! boresight. The difference equations then give the torques (inverse dynamics):
//!
//! ```text
//! Π̃_k = vee(F_k J_d − J_d F_kᵀ)/h ,    F_k = R_kᵀ R_{k+1} ,    h τ_k = Π̃_k − F_{k−1}ᵀ Π̃_{k−1}
//! (h/2) τ_0 = Π̃_0 − J Ω_0 ,            (h/2) τ_N = J Ω_N − F_{N−1}ᵀ Π̃_{N−1}
//! ```
//!
//! Wheels share the total momentum `H`, and store μ̃ over a step, with `F = cay(c)`:
//!
//! ```text
//! (I + S(c) + c cᵀ) μ̃_k = R_kᵀ H − Π̃_k ,    h τ_k = μ̃_{k−1} − μ̃_k ,    μ = Rᵀ H − J Ω at the ends
//! ```
//!
//! Among all inputs with these torques, those with the least sum of squares within their limits are
//! used. The witnesses check a hold, including its limits and cones, like any other motion.

use super::carried::{carry, momentum};
use super::{Place, Sequence, Stop};
use crate::lie::{self, cayley_inverse, hat, vee};
use crate::maneuver::aim::{Aim, AimError, Roll};
use crate::maneuver::constraint::{Alternatives, Shift, Turns};
use crate::maneuver::duration::Duration;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{EndCondition, Path, Problem, Scheme, State, Stepping};
use crate::maneuver::settings::Settings;
use crate::maneuver::solution::{Optimality, Outcome, Solution, Trajectory};
use crate::mechanics::actuators::ActuatorSet;
use crate::optimize::search::Observer;
use crate::plan::{Plan, judged};
use crate::verify::{self, Accuracy};
use crate::{Matrix3, Vector3};
use std::time::Instant;

/// A hold at a stop, with the results of the witnesses.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Hold {
    /// The motion of the hold as a maneuver, from the arrival to the end of the hold.
    pub problem: Problem,
    /// The trajectory of the hold. It has neither cost nor costates.
    pub plan: Plan,
}

impl Hold {
    /// Returns the state at the end of the hold.
    pub fn end(&self) -> State {
        self.problem.end
    }
}

/// Returns whether the target of a stop moves.
pub fn moves(stop: &Stop) -> bool {
    matches!(&stop.place, Place::Aim(aim) if aim.moves(&Vector3::zeros()))
}

/// Returns the maneuver of a hold that begins at the time `arrival` \[s\] in the state `start`,
/// with the limits and cones at that time. The state at the end is set later.
pub fn holding(sequence: &Sequence, stop: &Stop, (arrival, start): (f64, State), lasting: f64) -> Problem {
    let craft = &sequence.craft;
    Problem {
        name: format!("{}, hold at {}", craft.name, stop.name),
        objective: Objective::default(),
        scheme: Scheme::LieVerlet,
        stepping: Stepping::Formulated,
        path: Path::Best,
        end_condition: EndCondition::State,
        duration: Duration::Given(lasting),
        chooses_steps: false,
        start,
        end: start,
        ..craft.later(arrival).known_for(lasting)
    }
}

/// Returns the largest angle \[rad\] between a motion that begins at the time `arrival` \[s\] and
/// the target of the stop. For a stop that does not move it is the angle from the first attitude.
pub fn off_target(stop: &Stop, arrival: f64, path: &Trajectory) -> f64 {
    let attitudes = path.quaternion.iter().map(lie::rotation_from_quaternion);
    let first = attitudes.clone().next().unwrap_or_default();
    let off = |(attitude, time): (Matrix3, &f64)| match &stop.place {
        Place::Aim(aim) if moves(stop) => {
            let ends = aim.ends(arrival + time, &attitude, &Vector3::zeros());
            ends.map_or(f64::NAN, |ends| lie::minus(&attitude, &ends.at(ends.nearest(&attitude)).0).norm())
        }
        _ => lie::minus(&attitude, &first).norm(),
    };
    attitudes
        .zip(&path.time)
        .map(off)
        .fold(0.0, |most: f64, off| if most.is_nan() || off <= most { most } else { off })
}

/// Plans the hold at a stop, from the arrival in a given state to the start of the next leg at
/// `until` \[s\]. `held` contains the wheel momenta at the arrival.
///
/// # Errors
/// [`AimError`] if the target leaves the roll undetermined.
pub fn hold(
    sequence: &Sequence,
    stop: &Stop,
    (arrival, state): (f64, State),
    until: f64,
    held: Option<&[f64]>,
    (settings, observer): (&Settings, &mut dyn Observer),
) -> Result<Hold, AimError> {
    let began = Instant::now();
    let mut craft = holding(sequence, stop, (arrival, state), until - arrival);
    carry(&mut craft, &momentum(&sequence.craft), held);
    let aim = match &stop.place {
        Place::Aim(aim) if moves(stop) => Some(aim.with_directions(|direction| direction.later(arrival))),
        _ => None,
    };
    loop {
        let attitudes = attitudes(&craft, aim.as_ref())?;
        craft.end = attitudes.end;
        let solution = followed(&craft, &attitudes.all, settings);
        let plan = judged(&craft, settings, solution, began, observer);
        let wanted = settings.continuous_limit();
        let more = plan.verification.as_ref().and_then(|found| Accuracy::of(found, &craft, wanted).steps);
        // A hold uses as many steps as it needs, independently of the legs.
        match more.filter(|more| wanted.is_some() && *more > craft.steps && *more <= MOST_STEPS) {
            Some(more) => craft.steps = more,
            None => return Ok(Hold { problem: craft, plan }),
        }
    }
}

/// Largest number of steps of a hold. If a hold needs more, its torques cannot keep the body on the
/// target.
const MOST_STEPS: usize = 100_000;

/// The attitudes of a hold at its nodes, and its final state.
struct Attitudes {
    all: Vec<Matrix3>,
    end: State,
}

/// Returns the attitudes of a hold from its start on: on the target `aim`, or at rest if it is
/// `None`.
fn attitudes(craft: &Problem, aim: Option<&Aim>) -> Result<Attitudes, AimError> {
    let (start, steps, zero) = (craft.start, craft.steps, Vector3::zeros());
    let Some(aim) = aim else {
        return Ok(Attitudes { all: vec![start.attitude; steps + 1], end: start });
    };
    let roll = match aim.roll {
        Roll::Free => 0.0,
        Roll::Towards { .. } => aim.ends(0.0, &start.attitude, &zero)?.nearest(&start.attitude),
    };
    let mut all = vec![start.attitude];
    let (mut at, mut rate) = (start.attitude, start.angular_velocity);
    for node in 1..=steps {
        let time = craft.seconds() * node as f64 / steps as f64;
        (at, rate) = aim.ends(time, &at, &zero)?.at(roll);
        all.push(at);
    }
    Ok(Attitudes { all, end: State::attitude(at, rate) })
}

/// Returns the motion through given attitudes, with the torques that it requires.
fn followed(craft: &Problem, attitudes: &[Matrix3], settings: &Settings) -> Solution {
    let mut solution = Solution { optimality: Optimality::UNTESTED, ..Solution::unknown() };
    let set = &craft.actuation.torque;
    let torques = torques(craft, attitudes);
    let inputs: Vec<f64> = torques
        .iter()
        .zip(attitudes)
        .flat_map(|(torque, attitude)| shared(set, &set.frame().of_body(attitude, torque)))
        .collect();
    solution.scheme = craft.scheme;
    (solution.steps, solution.step, solution.tolerance) = (craft.steps, craft.step(), settings.tolerance);
    if let Ok(trajectory) = verify::replay(craft, &inputs) {
        let last = trajectory.quaternion.last().map(lie::rotation_from_quaternion);
        solution.turned_deg = verify::swept(&trajectory).to_degrees();
        solution.terminal.attitude_rad =
            last.map_or(f64::NAN, |last| lie::minus(&last, &craft.end.attitude).norm());
        solution.terminal.momentum_relative = 0.0;
        solution.cost = verify::effort(craft, &inputs);
        solution.outcome = Outcome::Converged;
        solution.turns = craft.alternatives.iter().map(|of| clearest(craft, of, &inputs)).collect();
        solution.trajectory = trajectory;
        solution.trajectory.costates = vec![0.0; (craft.steps + 1) * craft.dimension()];
    }
    solution
}

/// Returns the set of alternatives that leaves a hold the largest margin. One set applies
/// throughout the hold.
fn clearest(craft: &Problem, of: &Alternatives, inputs: &[f64]) -> Turns {
    let lasting = craft.seconds();
    let turns = |set: usize| Turns { of: of.clone(), shifts: vec![Shift { set, from: 0.0, to: lasting }] };
    let room = |set: usize| {
        let margins = verify::margins(&craft.in_turns(&[turns(set)]), inputs).unwrap_or_default();
        let own = margins.iter().filter(|margin| of.sets[set].contains(&margin.name));
        own.map(|margin| margin.scaled).fold(f64::INFINITY, f64::min)
    };
    let best = (0..of.sets.len()).max_by(|a, b| room(*a).total_cmp(&room(*b)));
    turns(best.unwrap_or_default())
}

/// Returns the torques at the nodes from the difference equations, body axes [N·m].
fn torques(craft: &Problem, attitudes: &[Matrix3]) -> Vec<Vector3> {
    let (j, j_d, h) = (craft.body.inertia.j(), craft.body.inertia.j_d(), craft.step());
    let [first, last] = [craft.start, craft.end].map(|state| j * state.angular_velocity);
    let turns: Vec<Matrix3> = attitudes.windows(2).map(|pair| pair[0].tr_mul(&pair[1])).collect();
    let momenta = turns.iter().map(|f| vee(&(f * j_d - j_d * f.transpose())) / h);
    let kicks: Vec<[Vector3; 2]> = if craft.actuation.wheels.is_some() {
        let whole = momentum(craft);
        let stored = momenta.zip(&turns).zip(attitudes).map(|((momentum, f), attitude)| {
            let c = cayley_inverse(f);
            let seen = Matrix3::identity() + hat(&c) + c * c.transpose();
            // The determinant of this matrix is (1 + c²)².
            let stored = seen.try_inverse().unwrap_or_default() * (attitude.tr_mul(&whole) - momentum);
            [-stored, -stored]
        });
        stored.collect()
    } else {
        momenta.zip(&turns).map(|(momentum, f)| [momentum, f.tr_mul(&momentum)]).collect()
    };
    let at_ends = if craft.actuation.wheels.is_some() {
        let whole = momentum(craft);
        [craft.start, craft.end].map(|state| j * state.angular_velocity - state.attitude.tr_mul(&whole))
    } else {
        [first, last]
    };
    let mut torques = Vec::with_capacity(attitudes.len());
    let mut before = at_ends[0];
    for (node, [from, to]) in kicks.iter().enumerate() {
        torques.push((from - before) / if node == 0 { 0.5 * h } else { h });
        before = *to;
    }
    torques.push((at_ends[1] - before) / (0.5 * h));
    torques
}

/// Largest number of Newton steps for the three multipliers. The equation is piecewise linear with
/// few pieces.
const MOST_NEWTON: usize = 50;

/// Returns the inputs within their limits that produce `torque` (in the axes of the actuator set)
/// with the least sum of squares. If no inputs produce it, returns the inputs of the last Newton
/// step.
///
/// ```text
/// min ½ |u|²  where  B u = τ ,  lower ≤ u ≤ upper :     u = clamp(Bᵀ y) ,  B clamp(Bᵀ y) = τ
/// ```
fn shared(set: &ActuatorSet, torque: &Vector3) -> Vec<f64> {
    let limits = set.limits();
    let bounds = |index: usize| {
        let most = limits.size.as_ref().map_or(f64::INFINITY, |size| size[index]);
        [if limits.one_sided { 0.0 } else { -most }, most]
    };
    let axes = set.axes();
    let inputs = |y: &Vector3| -> Vec<f64> {
        let all = axes.iter().enumerate();
        all.map(|(index, axis)| {
            let [lower, upper] = bounds(index);
            axis.dot(y).clamp(lower, upper)
        })
        .collect()
    };
    // The dual function ½|u|² − y·(B u − τ) is concave; its gradient is the missing torque.
    let missing = |y: &Vector3| torque - set.output(&inputs(y));
    let mut y = Vector3::zeros();
    let mut lacks = missing(&y);
    for _ in 0..MOST_NEWTON {
        if lacks.norm() <= f64::EPSILON * torque.norm() {
            break;
        }
        let mut curvature = Matrix3::zeros();
        for (index, axis) in axes.iter().enumerate() {
            let ([lower, upper], value) = (bounds(index), axis.dot(&y));
            let is_pushed = value == lower && axis.dot(&lacks) > 0.0;
            if (value > lower && value < upper) || is_pushed {
                curvature += axis * axis.transpose();
            }
        }
        let Ok(inverse) = curvature.pseudo_inverse(SINGULAR * curvature.norm()) else { break };
        let step = inverse * lacks;
        let step = if step.dot(&lacks) > 0.0 { step } else { lacks };
        let mut part = 1.0;
        let next = loop {
            let next = missing(&(y + part * step));
            if next.norm() < lacks.norm() {
                break Some(next);
            }
            part *= 0.5;
            if part < f64::EPSILON {
                break None;
            }
        };
        let Some(next) = next else { break };
        (y, lacks) = (y + part * step, next);
    }
    inputs(&y)
}

/// Threshold on the curvature, relative to the largest one: in directions below it no free input
/// acts.
const SINGULAR: f64 = 1e-12;

#[cfg(test)]
mod tests;
