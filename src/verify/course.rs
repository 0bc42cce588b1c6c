//! The results of the witnesses along the motion, for charts: the angle between the continuous and
//! the discrete motion at each node, and the clearance of both motions from every cone in each
//! step.

use super::continuous::Continuous;
use super::discrete::Discrete;
use super::held::PIECES;
use super::motion::{Inputs, Phase, judgeable};
use super::rows;
use super::verification::WitnessError;
use crate::maneuver::constraint::{Arc, Pointing, Rule, on_arc};
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::Trajectory;
use crate::{Matrix3, lie};

/// The errors and clearances of both motions of a plan over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    /// Angle \[rad\] between the attitudes of the discrete and the continuous motion at each of the
    /// `N + 1` nodes. The continuous motion has the torque held over each step.
    pub apart: Vec<f64>,
    /// Angle \[rad\] between the discrete motion and the terminal attitude at each node; `N + 1`
    /// values.
    pub discrete_left: Vec<f64>,
    /// Angle \[rad\] between the continuous motion and the terminal attitude at each node; `N + 1`
    /// values. The last value is the terminal error in the verification.
    pub continuous_left: Vec<f64>,
    /// The clearances of each pointing constraint, in the order of the constraints.
    pub clearances: Vec<Clearance>,
}

/// The clearance of a motion from the cones of one constraint \[rad\], one value for each of the
/// `N` steps. It is the smallest angle to the edge of the cone with its margin, over all pairs of
/// boresight and direction. A negative value is a violation; an infinite value means that the
/// constraint is not active in this step.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// Name of the constraint.
    pub name: String,
    /// Clearance of the discrete motion, at the nodes and on the arcs between them.
    pub discrete: Vec<f64>,
    /// Clearance of the continuous motion under the held torque.
    pub continuous: Vec<f64>,
}

/// Propagates both motions along the plan of `problem`. Returns, step by step, the values of which
/// [`super::verify`] reports the extremes.
///
/// # Errors
/// A [`WitnessError`] if the rows do not fit the problem, or a motion cannot be propagated to its
/// end.
pub fn course(problem: &Problem, trajectory: &Trajectory) -> Result<Course, WitnessError> {
    problem.check_numbers()?;
    rows::fit(problem, trajectory)?;
    if problem.seeks_duration() && trajectory.time.len() == 1 {
        // In a maneuver of zero duration the body does not move.
        let left = vec![lie::minus(&problem.start.attitude, &problem.end.attitude).norm()];
        return Ok(Course {
            apart: vec![0.0],
            discrete_left: left.clone(),
            continuous_left: left,
            clearances: vec![],
        });
    }
    // The steps of minimum-time and minimum-fuel plans have different lengths.
    let grid = rows::grid(problem, trajectory)?;
    let flown = problem.clone().with_duration(grid.duration());
    let problem = &flown;
    let plant = judgeable(problem)?;
    let inputs = Inputs::on(problem, grid, &trajectory.input);
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
    let left = |attitude: &Matrix3| lie::minus(attitude, &problem.end.attitude).norm();
    let begun = vec![left(&problem.start.attitude)];
    let mut course = Course {
        apart: vec![0.0],
        discrete_left: begun.clone(),
        continuous_left: begun,
        clearances: cones.iter().map(|(name, _)| empty(name)).collect(),
    };
    let pieces = if cones.is_empty() { 1 } else { PIECES };
    let frame_rate = problem.environment.frame_rate();
    let mut discrete = Discrete::new(&plant, &start, problem.scheme, inputs.grid.step(0));
    let mut continuous = Continuous::new(&plant, &start);
    for k in 0..problem.steps {
        let (began, step) = (inputs.grid.after(k), inputs.grid.step(k));
        let piece = step / pieces as f64;
        let (from, to) = inputs.ends(k);
        discrete.set_step(step);
        discrete.advance(&from, &to)?;
        let held = inputs.held(k);
        let mut arcs = Vec::with_capacity(pieces);
        for index in 0..pieces {
            let (time, before) = (began + index as f64 * piece, continuous.inertial_attitude());
            continuous.advance(time, piece, &held, &held)?;
            arcs.push((
                time,
                Arc { start: before, turn: lie::minus(&continuous.inertial_attitude(), &before) },
            ));
        }
        for ((_, cone), clearance) in cones.iter().zip(&mut course.clearances) {
            let on = |time: f64, length: f64, arc: &Arc| {
                cone.pairs().fold(f64::INFINITY, |least, (boresight, direction)| {
                    let target = on_arc(direction, time, length, &frame_rate);
                    let found = cone.least_room(arc, boresight, &target, [time, length]);
                    found.map_or(least, |(_, room)| smaller(least, room))
                })
            };
            clearance.discrete.push(discrete.arc().map_or(f64::NAN, |arc| on(began, step, arc)));
            let pieces = arcs.iter().map(|(time, arc)| on(*time, piece, arc));
            clearance.continuous.push(pieces.fold(f64::INFINITY, smaller));
        }
        let time = inputs.grid.after(k + 1);
        let (there, here) = (continuous.phase(time).attitude, discrete.phase().attitude);
        course.apart.push(lie::minus(&there, &here).norm());
        course.discrete_left.push(left(&here));
        course.continuous_left.push(left(&there));
    }
    Ok(course)
}

/// Returns the smaller number; unlike `f64::min`, NaN if either number is NaN.
fn smaller(a: f64, b: f64) -> f64 {
    if b < a || b.is_nan() { b } else { a }
}
