//! The hold of a stop: at rest, or on a target that moves.
//!
//! Nothing is left to choose there. The target gives the attitudes at all nodes, and a free roll
//! keeps what it has: from node to node the body turns the shortest way, so that it never turns
//! about its boresight. The difference equations then give the torques (inverse dynamics):
//!
//! ```text
//! Π̃_k = vee(F_k J_d − J_d F_kᵀ)/h ,    F_k = R_kᵀ R_{k+1} ,    h τ_k = Π̃_k − F_{k−1}ᵀ Π̃_{k−1}
//! (h/2) τ_0 = Π̃_0 − J Ω_0 ,            (h/2) τ_N = J Ω_N − F_{N−1}ᵀ Π̃_{N−1}
//! ```
//!
//! Wheels share the momentum `H` of the whole, and store μ̃ over a step, with `F = cay(c)`:
//!
//! ```text
//! (I + S(c) + c cᵀ) μ̃_k = R_kᵀ H − Π̃_k ,    h τ_k = μ̃_{k−1} − μ̃_k ,    μ = Rᵀ H − J Ω at the ends
//! ```
//!
//! Of all inputs with these torques those of the least squares within their limits count. The
//! witnesses judge a hold as they judge any other motion, limits and cones among it.

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

/// A hold, with the results of the witnesses.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Hold {
    /// Its motion as a maneuver, from the arrival to the end of the hold.
    pub problem: Problem,
    /// Its trajectory. No cost and no costates belong to it.
    pub plan: Plan,
}

impl Hold {
    /// Returns the state at its end.
    pub fn end(&self) -> State {
        self.problem.end
    }
}

/// Returns whether a stop is on a target that moves.
pub fn moves(stop: &Stop) -> bool {
    matches!(&stop.place, Place::Aim(aim) if aim.moves(&Vector3::zeros()))
}

/// Returns the maneuver of a hold at a stop that begins at a time \[s\] in a state: its limits and
/// cones as they are then. Its end is not known yet.
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

/// Returns by how much a motion from a time \[s\] on leaves the target of a stop at most \[rad\], or
/// the attitude in which it begins, of a stop that does not move.
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

/// Returns the hold at a stop, from the arrival at a time in a state until the next leg begins;
/// `held` are the momenta that the wheels have then.
///
/// # Errors
/// [`AimError`] where the target leaves the roll undetermined.
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
        // A hold takes the steps that it needs, whatever the legs take.
        match more.filter(|more| wanted.is_some() && *more > craft.steps && *more <= MOST_STEPS) {
            Some(more) => craft.steps = more,
            None => return Ok(Hold { problem: craft, plan }),
        }
    }
}

/// The most steps of a hold: more of them say that its torques do not hold the body on the target.
const MOST_STEPS: usize = 100_000;

/// The attitudes of a hold at its nodes, and the state at its end.
struct Attitudes {
    all: Vec<Matrix3>,
    end: State,
}

/// Returns the attitudes from the start of a hold on, on a target or at rest.
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

/// Returns the motion through attitudes, with the torques that it takes.
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

/// Returns the set of alternatives that leaves a hold the most room; one set holds throughout.
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

/// Returns the torques at the nodes, body axes [N·m], by the difference equations.
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
            // Its determinant is (1 + c²)².
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

/// Newton steps on the three multipliers: a piecewise linear equation of few pieces.
const MOST_NEWTON: usize = 50;

/// Returns the inputs of least squares within their limits whose output is a torque, in the axes of
/// the set; where none has it, those that the last step came to.
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
    // The dual function ½|u|² − y·(B u − τ) is concave, and its slope is what is missing.
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

/// The curvature, as a part of the largest, below which no free input acts in a direction.
const SINGULAR: f64 = 1e-12;

#[cfg(test)]
mod tests;
