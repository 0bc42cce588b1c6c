//! Helpers that the unit tests share: reference files and random numbers.

use crate::maneuver::grid::{Grid, Scheme};
use crate::maneuver::objective::{Objective, Weights};
use crate::maneuver::problem::{Problem, State};
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits};
use crate::mechanics::body::{Body, Inertia};
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, SMatrix, SVector};
use serde_json::Value;

/// Returns the contents of a JSON file in tests/reference.
pub fn reference(name: &str) -> Value {
    let path = format!("{}/tests/reference/{name}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Returns a JSON list of numbers as a vector.
pub fn vector<const N: usize>(value: &Value) -> SVector<f64, N> {
    SVector::from_fn(|row, _| value[row].as_f64().unwrap())
}

/// Returns a JSON list of rows as a matrix.
pub fn matrix<const R: usize, const C: usize>(value: &Value) -> SMatrix<f64, R, C> {
    SMatrix::from_fn(|row, column| value[row][column].as_f64().unwrap())
}

/// The splitmix64 random number generator, whose stream never changes.
pub struct Random(pub u64);

impl Random {
    /// Returns a number uniformly distributed in [−1, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 * 2.0f64.powi(-52) - 1.0
    }

    /// Returns a vector whose components are uniformly distributed in [−1, 1).
    pub fn vector3(&mut self) -> Vector3 {
        Vector3::from_fn(|_, _| self.uniform())
    }

    /// Returns a random rotation, which is not uniformly distributed on SO(3).
    pub fn rotation(&mut self) -> Matrix3 {
        crate::lie::exp(&(self.vector3() * 2.0))
    }
}

/// Returns the inertia of the reference files, whose principal axes are not the body axes.
pub fn full_inertia() -> Inertia {
    Inertia::new(Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)).unwrap()
}

/// Returns a set of actuators whose axes are the columns of `axes`.
pub fn channel(axes: &Matrix3, frame: AxisFrame) -> ActuatorSet {
    ActuatorSet::new(axes.column_iter().map(|column| column.into_owned()).collect(), frame).unwrap()
}

/// Returns a 3×3 matrix as a block of the effort weight.
pub fn weight(matrix: &Matrix3) -> DMatrix<f64> {
    DMatrix::from_column_slice(3, 3, matrix.as_slice())
}

/// Returns the maneuver with torque inputs only, along the columns of `axes` in body axes, and with
/// a full weight matrix.
pub fn with_torques(problem: Problem, axes: &Matrix3, matrix: &Matrix3) -> Problem {
    let torque = channel(axes, AxisFrame::Body);
    problem.with_actuation(Actuation::torques(torque)).with_objective(Weights::of_torques(weight(matrix)))
}

/// Returns the most general actuators: full `B`, full `W`, and four force inputs for three
/// components of the force.
fn full_actuation(frame: AxisFrame) -> (Actuation, Weights) {
    let b = Matrix3::new(1.0, 0.1, 0.0, 0.0, 0.9, -0.2, 0.1, 0.0, 1.1);
    let w = Matrix3::new(1.0, 0.2, 0.0, 0.2, 2.0, 0.1, 0.0, 0.1, 0.5);
    let other = if frame == AxisFrame::Body { AxisFrame::Reference } else { AxisFrame::Body };
    let mut axes: Vec<Vector3> = b.column_iter().map(|column| column.into_owned()).collect();
    axes.push(Vector3::new(0.5, 0.5, -0.7));
    let of_forces = DMatrix::from_fn(4, 4, |i, j| if i == j { 1.0 + 0.3 * i as f64 } else { 0.1 });
    let force = ActuatorSet::new(axes, other).unwrap();
    let weights = Weights { torque: Some(weight(&w)), force: Some(of_forces), time_price: None };
    (Actuation::torques_and_forces(channel(&b, frame), force), weights)
}

/// Returns a maneuver of a body with [`full_inertia`] and mass 1.3 between random states that are
/// not at rest.
pub fn moving_ends(random: &mut Random, frame: AxisFrame) -> Problem {
    let mut state = || State {
        position: Vector3::new(1.0, 0.2, -0.1) + 0.1 * random.vector3(),
        // Nearly the speed of a circular orbit in the fields of the tests, which prevents close
        // encounters.
        velocity: Vector3::new(0.0, 1.0, 0.0) + 0.2 * random.vector3(),
        attitude: random.rotation(),
        angular_velocity: random.vector3(),
    };
    let (start, end) = (state(), state());
    let body = Body { inertia: full_inertia(), mass: Some(1.3) };
    let (actuation, weights) = full_actuation(frame);
    let problem = Problem::rigid_body(body, start, end, 1.7).with_steps(12);
    problem.with_actuation(actuation).with_objective(weights)
}

/// Returns the maneuver without its translation, on SO(3).
pub fn attitude_only(mut problem: Problem) -> Problem {
    problem.motion = crate::maneuver::problem::Motion::Attitude;
    problem.actuation.force = None;
    problem
}

/// Returns a vector whose components are uniformly distributed in [−1, 1).
pub fn random_vector<const N: usize>(random: &mut Random) -> SVector<f64, N> {
    SVector::from_fn(|_, _| random.uniform())
}

/// Returns a grid of duration 1 whose step lengths change smoothly. The longest step is five times
/// the shortest.
pub fn graded(scheme: Scheme, steps: usize) -> Grid {
    let middle = |step: usize| (step as f64 + 0.5) / steps as f64;
    let length = |step: usize| 1.2 + (5.0 * middle(step)).sin() * 0.8;
    let lengths: Vec<f64> = (0..steps).map(length).collect();
    Grid::of_lengths(scheme, &lengths).unwrap().with_duration(1.0)
}

/// Returns the maneuver with limits that are the fraction `part` of the largest inputs of the
/// extremal from `costate`. Either the norm of the torque and each force input are limited, or each
/// torque input and the norm of the force. Sets with a limit for each input get the diagonal of
/// their weight.
pub fn limited<const N: usize>(
    problem: &Problem,
    costate: &SVector<f64, N>,
    norm: bool,
    part: f64,
) -> Problem {
    let within = |channel: &ActuatorSet, norm: bool, limit: f64| {
        let mut limits = Limits::default();
        if norm {
            limits.norm = Some(limit);
        } else {
            limits.size = Some(vec![limit; channel.count()]);
        }
        channel.clone().with_limits(limits).unwrap()
    };
    let mut problem = problem.clone();
    let Objective::Effort(weights) = &mut problem.objective else { unreachable!("effort") };
    let one_by_one = if norm { &mut weights.force } else { &mut weights.torque };
    *one_by_one = one_by_one.as_ref().map(|weight| DMatrix::from_diagonal(&weight.diagonal()));
    let demand =
        |problem: &Problem| BoundaryValueProblem::<N>::new(problem, problem.steps).demand(costate).unwrap();
    // A limit of 1e9 is never active.
    let torque = problem.actuation.torque.clone();
    problem.actuation.torque = within(&torque, norm, 1e9);
    let limit = part * 1e9 * demand(&problem);
    if let Some(force) = problem.actuation.force.clone() {
        problem.actuation.torque = torque.clone();
        problem.actuation.force = Some(within(&force, !norm, 1e9));
        let limit = part * 1e9 * demand(&problem);
        problem.actuation.force = Some(within(&force, !norm, limit));
    }
    problem.actuation.torque = within(&torque, norm, limit);
    assert_eq!(crate::optimize::discrete::control_law::obstacle(&problem), None);
    problem
}

/// Returns a reference file of `tests/reference/closed_loop`, its problem, and the plan: the
/// discrete optimum with constant unit weights.
pub fn planned_reference(name: &str) -> (Value, Problem, crate::maneuver::solution::Trajectory) {
    use crate::lie;
    let file = reference(&format!("closed_loop/{name}.json"));
    let given = &file["problem"];
    let state = |attitude: &Value, rate: &Value| State {
        attitude: lie::rotation_from_quaternion(&std::array::from_fn(|index| {
            attitude[index].as_f64().unwrap()
        })),
        angular_velocity: vector(rate),
        ..State::at_rest(Matrix3::identity())
    };
    let body = Body { inertia: Inertia::new(matrix(&given["inertia"])).unwrap(), mass: None };
    let (start, end) = (state(&given["q0"], &given["w0"]), state(&given["qf"], &given["wf"]));
    let steps = given["N"].as_u64().unwrap() as usize;
    let problem = Problem::attitude(body, start, end, given["T"].as_f64().unwrap()).with_steps(steps);
    let plan = planned(&problem);
    (file, problem, plan)
}

/// Returns the trajectory of the discrete optimum of a maneuver.
pub fn planned(problem: &Problem) -> crate::maneuver::solution::Trajectory {
    use crate::optimize::search;
    let settings = crate::maneuver::settings::Settings::discrete();
    let solution = search::solve(problem, &settings, None, &mut search::Silent).unwrap();
    assert_eq!(solution.outcome, crate::maneuver::solution::Outcome::Converged, "{}", problem.name);
    solution.trajectory
}
