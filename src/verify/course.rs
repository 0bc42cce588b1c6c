//! What the witnesses see on the way, for pictures: how far the continuous motion is from the discrete one at each
//! node, and how far both stay from every cone on each step.

use super::continuous::Continuous;
use super::discrete::Discrete;
use super::held::PIECES;
use super::motion::{Inputs, Phase, judgeable};
use super::rows;
use super::verification::WitnessError;
use crate::lie;
use crate::maneuver::constraint::{Arc, Pointing, Rule};
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::Trajectory;

/// The way of the witnesses under the inputs of a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    /// Angle between the attitudes of the discrete and the continuous motion, the latter under the torque held over
    /// each step \[rad\]; `N + 1` values.
    pub apart: Vec<f64>,
    /// One for each constraint on pointing, in their order.
    pub clearances: Vec<Clearance>,
}

/// How far a motion stays from the cones of one constraint \[rad\]: on each step the smallest distance, of all pairs of
/// boresight and direction, to the cone with its margin; negative: violated. `N` values each.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// Name of the constraint.
    pub name: String,
    /// Of the discrete motion, at the nodes and on the arcs between them.
    pub discrete: Vec<f64>,
    /// Of the continuous motion under the held torque.
    pub continuous: Vec<f64>,
}

/// Follows both motions through the plan of `problem`; what [`super::verify`] keeps the extremes of, step by step.
///
/// # Errors
/// A [`WitnessError`] where the rows do not fit, or a motion cannot be followed to its end.
pub fn course(problem: &Problem, trajectory: &Trajectory) -> Result<Course, WitnessError> {
    problem.check_numbers()?;
    rows::fit(problem, trajectory)?;
    let plant = judgeable(problem)?;
    let inputs = Inputs::checked(problem, &trajectory.input)?;
    let start = Phase::of(problem, &problem.start);
    let cones: Vec<(&str, &Pointing)> = problem
        .constraints
        .iter()
        .filter_map(|constraint| match &constraint.rule {
            Rule::Pointing(pointing) => Some((constraint.name.as_str(), pointing)),
            Rule::RateNorm(_) | Rule::RateAxes(_) => None,
        })
        .collect();
    let empty = |name: &str| Clearance { name: name.into(), discrete: vec![], continuous: vec![] };
    let mut course =
        Course { apart: vec![0.0], clearances: cones.iter().map(|(name, _)| empty(name)).collect() };
    let pieces = if cones.is_empty() { 1 } else { PIECES };
    let (step, piece) = (problem.step(), problem.step() / pieces as f64);
    let frame_rate = problem.environment.frame_rate();
    let mut discrete = Discrete::new(&plant, &start, problem.scheme, step);
    let mut continuous = Continuous::new(&plant, &start);
    for k in 0..problem.steps {
        let (from, to) = inputs.ends(k);
        discrete.advance(&from, &to)?;
        let held = inputs.held(k);
        let mut arcs = Vec::with_capacity(pieces);
        for index in pieces * k..pieces * (k + 1) {
            let (time, before) = (index as f64 * piece, continuous.inertial_attitude());
            continuous.advance(time, piece, &held, &held)?;
            arcs.push((
                time,
                Arc { start: before, turn: lie::minus(&continuous.inertial_attitude(), &before) },
            ));
        }
        for ((_, cone), clearance) in cones.iter().zip(&mut course.clearances) {
            let on = |time: f64, length: f64, arc: &Arc| {
                cone.pairs().fold(f64::INFINITY, |least, (boresight, direction)| {
                    let target = direction.on_arc(time, length, &frame_rate);
                    let angle = arc.extreme(boresight, &target, cone.side).angle;
                    smaller(least, cone.room(angle))
                })
            };
            clearance.discrete.push(discrete.arc().map_or(f64::NAN, |arc| on(k as f64 * step, step, arc)));
            let pieces = arcs.iter().map(|(time, arc)| on(*time, piece, arc));
            clearance.continuous.push(pieces.fold(f64::INFINITY, smaller));
        }
        let time = (k + 1) as f64 * step;
        let (there, here) = (continuous.phase(time).attitude, discrete.phase().attitude);
        course.apart.push(lie::minus(&there, &here).norm());
    }
    Ok(course)
}

/// The smaller of the two; NaN if either is, unlike `f64::min`.
fn smaller(a: f64, b: f64) -> f64 {
    if b < a || b.is_nan() { b } else { a }
}
