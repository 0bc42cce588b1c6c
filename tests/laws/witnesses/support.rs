//! Problems, plans and fields for the tests of the witnesses.

pub use crate::evidence::{Random, list, matrix3, number, numbers, reference, vector};
pub use slewkit::Matrix3;
pub use slewkit::Vector3;
pub use slewkit::lie;
pub use slewkit::maneuver::problem::{Problem, Scheme, State};
pub use slewkit::maneuver::solution::Trajectory;
pub use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame};
pub use slewkit::mechanics::body::{Body, Inertia};
pub use slewkit::mechanics::environment::{Blocks, Environment, Pose, Wrench};
pub use slewkit::propagate::simulate::SimulationRow;
pub use slewkit::verify::propagation::{Propagation, Propagator, propagate};
pub use slewkit::verify::{Verification, WitnessError, replay, verify, verify_until};
pub use std::f64::consts::PI;
pub use std::ops::ControlFlow;

pub const SCHEMES: [Scheme; 2] = [Scheme::LieEuler, Scheme::LieVerlet];
pub const PROPAGATORS: [Propagator; 3] =
    [Propagator::LieVerlet, Propagator::Verner98, Propagator::Continuous];
/// The propagators without an error except rounding.
pub const EXACT: [Propagator; 2] = [Propagator::Verner98, Propagator::Continuous];

/// `U = −p·(Rᵀd)` (pendulum), `U = (n²·3/2) G·JG`, `G = Rᵀo` (gravity gradient along a fixed
/// direction), `U = −μm/|x|` (a point), all in a frame turning at `rate`. Written anew: the
/// witnesses use only potential, force and moment, and should not be tested with the environments
/// that they will judge.
#[derive(Clone, Debug)]
pub struct Field {
    pub pendulum: (Vector3, Vector3),
    pub gradient: (f64, Vector3, Matrix3),
    pub point: f64,
    pub rate: Vector3,
}

impl Field {
    pub fn none() -> Self {
        Self {
            pendulum: (Vector3::zeros(), Vector3::z()),
            gradient: (0.0, Vector3::z(), Matrix3::zeros()),
            point: 0.0,
            rate: Vector3::zeros(),
        }
    }

    pub fn pendulum(moment: Vector3) -> Self {
        Self { pendulum: (moment, Vector3::z()), ..Self::none() }
    }
}

impl Environment for Field {
    fn potential(&self, pose: &Pose) -> f64 {
        let (p, d) = &self.pendulum;
        let (n2, o, j) = &self.gradient;
        let g = pose.attitude.transpose() * o;
        let point = if self.point > 0.0 { -self.point / pose.position.norm() } else { 0.0 };
        1.5 * n2 * g.dot(&(j * g)) - p.dot(&(pose.attitude.transpose() * d)) + point
    }
    fn wrench(&self, pose: &Pose) -> Wrench {
        let (p, d) = &self.pendulum;
        let (n2, o, j) = &self.gradient;
        let g = pose.attitude.transpose() * o;
        let moment = p.cross(&(pose.attitude.transpose() * d)) + 3.0 * n2 * g.cross(&(j * g));
        let point = -self.point * pose.position / pose.position.norm().powi(3);
        Wrench { force: if self.point > 0.0 { point } else { Vector3::zeros() }, moment }
    }
    fn gradient(&self, _: &Pose) -> Blocks {
        unreachable!("the witnesses use no derivative")
    }
    fn curvature(&self, _: &Pose, _: &Wrench) -> Blocks {
        unreachable!("the witnesses use no derivative")
    }
    fn frame_rate(&self) -> Vector3 {
        self.rate
    }
}

pub fn full_inertia() -> Matrix3 {
    Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)
}

pub fn body(j: Matrix3) -> Body {
    Body { inertia: Inertia::new(j).unwrap(), mass: None }
}

pub fn torques(b: Matrix3, frame: AxisFrame) -> Actuation {
    let axes = b.column_iter().map(Into::into).collect();
    Actuation::torques(ActuatorSet::new(axes, frame).unwrap())
}

/// Returns a problem with a moving start, for tests of the propagation alone: no plan aims at its
/// end.
pub fn ballistic(j: Matrix3, rate: Vector3, duration: f64) -> Problem {
    let start = State::attitude(lie::exp(&Vector3::new(0.4, -0.3, 0.5)), rate);
    Problem::attitude(body(j), start, State::at_rest(Matrix3::identity()), duration)
}

pub fn final_row(
    problem: &Problem,
    propagator: Propagator,
    steps: u64,
    inputs: Option<&[f64]>,
) -> SimulationRow {
    let mut last = None;
    let settings = Propagation { propagator, steps, stride: u64::MAX, inputs };
    propagate(problem, &settings, &mut |row: &SimulationRow| {
        last = Some(row.clone());
        ControlFlow::Continue(())
    })
    .unwrap();
    last.unwrap()
}

pub fn attitude_error(row: &SimulationRow, expected: &Matrix3) -> f64 {
    lie::log(&(expected.transpose() * lie::rotation_from_quaternion(&row.bodies[0].quaternion))).norm()
}

/// Returns smooth inputs of a few units.
pub fn smooth_inputs(problem: &Problem) -> Vec<f64> {
    let rows = problem.scheme.input_rows(problem.steps);
    let count = problem.actuation.count();
    let mut inputs = vec![];
    for row in 0..rows {
        let t = (row + problem.steps + 1 - rows) as f64 / problem.steps as f64;
        inputs.extend((0..count).map(|i| (1.0 + i as f64 + 3.0 * t).sin() * (2.0 - i as f64 * t)));
    }
    inputs
}

/// Returns the same maneuver aimed at where its inputs lead, and the plan that leads there.
pub fn aimed(mut problem: Problem, inputs: &[f64]) -> (Problem, Trajectory) {
    let plan = replay(&problem, inputs).unwrap();
    problem.end = State {
        position: plan.position.last().copied().unwrap_or_default(),
        velocity: plan.velocity.last().copied().unwrap_or_default(),
        attitude: lie::rotation_from_quaternion(plan.quaternion.last().unwrap()),
        angular_velocity: *plan.angular_velocity.last().unwrap(),
    };
    (problem, plan)
}

pub fn check(found: &Verification, name: &str) -> bool {
    let check = found.checks.iter().find(|check| check.name == name);
    check.unwrap_or_else(|| panic!("no check {name}: {found:#?}")).passed
}
