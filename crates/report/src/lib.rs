//! Reports: a plan as pictures, and as one self-contained page.
//!
//! [`pictures`] returns the charts of a plan in a fixed order, and [`crate::draw`] writes them as
//! SVG. [`plan_page`] returns one HTML file that loads no other file. It contains the verdict,
//! tables, these charts and an animated body, which a script in the file draws. The data come from
//! a [`Problem`] and a [`Plan`]; a plan file contains both. The witnesses supply values between the
//! nodes ([`slewkit::verify::course()`]).
//!
//! Curves have at most [`MOST_POINTS`] points. Thinning keeps every peak. Data files have all rows.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod arcs;
mod attitude;
mod body;
mod boresight;
mod cases_told;
mod charts;
mod comparison;
mod convergence;
mod document;
pub mod draw;
mod flight;
mod hamiltonian;
mod moving;
mod page;
mod results;
mod sequence;
mod simulation;
mod sphere;
pub mod studies;
pub mod summary;
mod switching;
mod tiles;
mod words;

pub use cases_told::told_of_cases;
pub use comparison::{ComparisonFile, Motion, comparison_page, comparison_pictures};
pub use page::plan_page;
pub use results::{Cases, MOST_PICTURED, results_page};
pub use sequence::{sequence_page, sequence_pictures};
pub use simulation::{simulation_page, simulation_pictures};

use crate::draw::{Curve, Picture, Shape, thinned};
use crate::studies::integrators::figures::FIGURES;
use slewkit::Vector3;
use slewkit::assured::{Beside, NotKnown};
use slewkit::maneuver::{Outcome, Problem, Trajectory};
use slewkit::optimize::discrete::linear_plan::PosedPlan;
use slewkit::plan::Plan;
use slewkit::verify::{Course, WitnessError, course};
use slewkit_files::identity::Identity;
use slewkit_files::spec::ClosedLoop;

/// The names of all pictures that a plan may have, in their order.
pub const KEYS: [&str; 25] = [
    "sky",
    "around",
    "ground",
    "inputs",
    "forces",
    "firings",
    "switching",
    "rates",
    "wheel_momentum",
    "position",
    "velocity",
    "clearance",
    "pointing",
    "corrections",
    "flown_pointing",
    "flown_commands",
    "euler",
    "quaternion",
    "error",
    "costates_attitude",
    "costates_momentum",
    "costates_position",
    "costates_linear",
    "hamiltonian",
    "convergence",
];

/// The names of all pictures that only a sequence has.
pub const SEQUENCE_KEYS: [&str; 1] = ["timeline"];

/// Names of all pictures that a simulation may have, in their order.
pub const SIMULATION_KEYS: [&str; 8] =
    ["sky", "rates", "position", "euler", "quaternion", "energy", "angular_momentum", "orthogonality"];

/// Names of the pictures of inputs, one for each of the compared plans.
const INPUT_KEYS: [&str; 3] = ["inputs_1", "inputs_2", "inputs_3"];

/// The names of all pictures that a comparison of motions may have, in their order.
pub const COMPARISON_KEYS: [&str; 5] = [INPUT_KEYS[0], INPUT_KEYS[1], INPUT_KEYS[2], "turning", "difference"];

/// Names of all pictures that a comparison of integrators may have. These are all its figures
/// except for the trajectories.
pub const INTEGRATOR_KEYS: &[&str] = FIGURES.as_slice().split_at(1).1;

/// Names of all pictures that the results of a batch may have.
pub const CASE_KEYS: [&str; 4] = ["cost", "map", "distribution", "miss"];

/// Largest number of points with which a curve is drawn.
pub const MOST_POINTS: usize = 2000;

/// A plan with all data that its pictures and tables need.
pub struct Subject<'a> {
    /// The maneuver on the grid of the plan.
    pub problem: &'a Problem,
    /// Plan that is shown.
    pub plan: &'a Plan,
    /// Names of inputs and frames, and the epoch of the maneuver.
    pub identity: &'a Identity,
    /// The sequence of the Euler angles in charts, one of
    /// [`slewkit_files::export::EULER_SEQUENCES`].
    pub sequence: &'a str,
    /// Boresights that point at the stops of a sequence, as unit vectors in body axes; empty for a
    /// single maneuver.
    aims: Vec<Vector3>,
    course: Option<Result<Course, WitnessError>>,
    /// Feedback gains and uncertainties of the plan, with the covariances along it or the reason
    /// why they cannot be computed; `None` if the spec has neither gains nor uncertainties.
    flight: Option<(&'a ClosedLoop, Result<Beside, NotKnown>)>,
}

/// A picture with its name in files, and a remark.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Name of the picture in file names and on the command line, such as "sky", "inputs" or
    /// "rates".
    pub key: &'static str,
    /// Picture that can be drawn as SVG.
    pub picture: Picture,
    /// Sentence that explains the picture; empty if its title suffices.
    pub remark: String,
}

impl<'a> Subject<'a> {
    /// Creates the subject of a report. The witnesses propagate the plan once. If this fails, the
    /// results of the witnesses are not shown, and the page states the reason.
    pub fn new(problem: &'a Problem, plan: &'a Plan, identity: &'a Identity, sequence: &'a str) -> Self {
        let trajectory = &plan.solution.trajectory;
        let course = (!trajectory.time.is_empty()).then(|| course(problem, trajectory));
        Self { problem, plan, identity, sequence, aims: Vec::new(), course, flight: None }
    }

    /// Adds the feedback gains and the uncertainties, and the covariances that follow from them.
    /// Has no effect if `closed_loop` contains neither, or if the plan has no trajectory.
    pub fn flown_with(mut self, closed_loop: &'a ClosedLoop) -> Self {
        if closed_loop.is_asked()
            && !PosedPlan::is_of(self.problem)
            && self.plan.solution.outcome == Outcome::Converged
        {
            let uncertainty = closed_loop.uncertainty.as_ref();
            let beside = Beside::along(self.problem, self.trajectory(), closed_loop.feedback, uncertainty);
            self.flight = Some((closed_loop, beside));
        }
        self
    }

    /// Returns the gains and covariances along the plan; `None` if they were not computed.
    fn beside(&self) -> Option<&Beside> {
        self.flight.as_ref()?.1.as_ref().ok()
    }

    /// Returns the feedback gains and uncertainties in the spec; `None` if it has neither.
    fn closed_loop(&self) -> Option<&'a ClosedLoop> {
        self.flight.as_ref().map(|(closed_loop, _)| *closed_loop)
    }

    /// Returns the motions that the witnesses computed; `None` if they could not propagate the
    /// plan.
    fn course(&self) -> Option<&Course> {
        self.course.as_ref()?.as_ref().ok()
    }

    fn trajectory(&self) -> &'a Trajectory {
        &self.plan.solution.trajectory
    }

    /// Returns the name of input `index`, counting forces before torques. It is the name in the
    /// spec or, if the spec gives no name, the kind and number of the input.
    fn input_name(&self, index: usize) -> String {
        if let Some(name) = self.identity.input(index) {
            return name.into();
        }
        let actuation = &self.problem.actuation;
        let forces = actuation.first_torque();
        let (kind, number, several) = match index.checked_sub(forces) {
            None => ("force", index, forces > 1),
            Some(number) => {
                let kind = match (&actuation.wheels, actuation.torque.limits().one_sided) {
                    (Some(_), _) => "wheel",
                    (None, true) => "thruster",
                    (None, false) => "torque",
                };
                (kind, number, actuation.torque.count() > 1)
            }
        };
        if several { format!("{kind} {}", number + 1) } else { kind.into() }
    }

    /// Returns a phrase for the reference frame, such as "reference frame J2000".
    fn reference_frame(&self) -> String {
        let name = self.identity.reference_frame.as_ref();
        name.map_or("reference frame".into(), |name| format!("reference frame {name}"))
    }

    /// Returns the times of the rows of inputs. With Lie–Euler there is no row at the first node,
    /// so the times begin with the second node.
    fn input_times(&self) -> &'a [f64] {
        let time = &self.trajectory().time;
        &time[self.problem.scheme.first_input().min(time.len())..]
    }

    /// Returns the curve of an input from its values, one for each row of inputs. For minimum-time
    /// and minimum-fuel plans it is a step function, because the inputs are held over steps. If
    /// such a plan has a uniform grid, the curve shows the means of neighbouring rows: only these
    /// means act on the body, and the rows may alternate about them.
    fn input_line(&self, name: impl Into<String>, style: usize, mut values: Vec<f64>) -> Curve {
        // The motion of a sequence has no costates, and its inputs are held over the steps.
        if !self.problem.objective.switches() && !self.trajectory().costates.is_empty() {
            return line(name, style, self.input_times(), values.into_iter());
        }
        if values.len() == self.trajectory().time.len() {
            values = values.windows(2).map(|ends| 0.5 * (ends[0] + ends[1])).collect();
        }
        let time: Vec<f64> = self.trajectory().time.windows(2).flatten().copied().collect();
        line(name, style, &time, values.into_iter().flat_map(|value| [value, value]))
    }
}

/// Returns the pictures of a plan, in the order of a report. If the plan has no trajectory, only
/// the convergence is shown.
pub fn pictures(subject: &Subject) -> Vec<Shown> {
    let mut shown = Vec::new();
    if !subject.trajectory().time.is_empty() {
        shown.push(sphere::sky(subject));
        shown.extend(sphere::around(subject));
        shown.extend(moving::ground(subject));
        shown.extend(charts::inputs(subject));
        shown.extend(charts::on_and_off(subject));
        shown.extend(switching::chart(subject));
        shown.extend(charts::of_motion(subject));
        shown.extend(flight::charts(subject));
        shown.extend(attitude::charts(subject));
        shown.extend(charts::costates(subject));
        shown.extend(hamiltonian::chart(subject));
    }
    shown.extend(convergence::chart(subject));
    shown
}

/// Returns the curve `name` of values over time, reduced to at most [`MOST_POINTS`] points.
fn line(name: impl Into<String>, style: usize, time: &[f64], values: impl Iterator<Item = f64>) -> Curve {
    let points: Vec<(f64, f64)> = time.iter().copied().zip(values).collect();
    Curve { name: name.into(), style, shape: Shape::Line(thinned(&points, MOST_POINTS)) }
}
