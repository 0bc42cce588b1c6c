//! Plans and trajectories of every kind, with many numbers that a careless writer does not
//! preserve.

use slewkit::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use slewkit::maneuver::problem::{Motion, Problem, Scheme, State};
use slewkit::maneuver::settings::Method;
use slewkit::maneuver::solution::{
    ActiveConstraint, ConvexWork, Outcome, Rival, Rung, RungReport, Sense, Solution, Trajectory,
};
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::plan::{Plan, Status};
use slewkit::verify::{Check, Verification};
use slewkit::{Matrix3, Vector3};

/// Numbers that a careless writer does not preserve: signed zero, subnormals, 17 digits, the ends
/// of the range.
const AWKWARD: [f64; 9] = [
    -0.0,
    5e-324,
    f64::MIN_POSITIVE - 5e-324,
    0.1 + 0.2,
    -1.0 / 3.0,
    9007199254740993.0,
    f64::MAX,
    -f64::MIN_POSITIVE,
    1e23,
];

/// An endless supply of awkward numbers.
struct Numbers(usize);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 += 1;
        AWKWARD[self.0 % AWKWARD.len()]
    }
    fn row<const M: usize>(&mut self) -> [f64; M] {
        std::array::from_fn(|_| self.next())
    }
    fn vectors(&mut self, rows: usize) -> Vec<Vector3> {
        (0..rows).map(|_| self.row::<3>().into()).collect()
    }
}

pub fn problem(motion: Motion, scheme: Scheme) -> Problem {
    let inertia = Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5)).unwrap();
    let start = State::at_rest(Matrix3::identity());
    let end = State::at_rest(Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0));
    let body = Body { inertia, mass: (motion == Motion::RigidBody).then_some(3.0) };
    let problem = match motion {
        Motion::Attitude => Problem::attitude(body, start, end, 0.3),
        Motion::RigidBody => Problem::rigid_body(body, start, end, 0.3),
    };
    problem.with_steps(4).with_scheme(scheme)
}

/// Adds four wheels in a pyramid, one of them without a limit of its momentum.
pub fn with_wheels(problem: Problem) -> Problem {
    let axes = [(0.8, 0.0), (0.0, 0.8), (-0.8, 0.0), (0.0, -0.8)].map(|(x, y)| Vector3::new(x, y, 0.6));
    let torque = ActuatorSet::new(axes.to_vec(), AxisFrame::Body).unwrap();
    let size = Some(vec![0.1, 0.2, 0.3, 0.4]);
    let torque = torque.with_limits(Limits { size, ..Limits::default() }).unwrap();
    let momentum_limit = vec![1.0, 2.0, f64::INFINITY, 4.0];
    let wheels = Wheels { momentum: vec![0.1, 0.0, -0.5, 4.0], momentum_limit };
    problem.with_actuation(Actuation { wheels: Some(wheels), ..Actuation::torques(torque) })
}

pub fn wheel_count(problem: &Problem) -> usize {
    problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len())
}

/// Adds every kind of constraint; the ends satisfy all of them.
pub fn with_constraints(problem: Problem) -> Problem {
    let direction = |vector, turns_with_frame| {
        if turns_with_frame { Direction::InFrame(vector) } else { Direction::Fixed(vector) }
    };
    let pointing = |side, sign: f64, half_angle| {
        Rule::Pointing(Pointing {
            side,
            boresights: vec![Vector3::z(), Vector3::x()],
            directions: vec![
                direction(sign * Vector3::new(0.36, 0.48, 0.8), false),
                direction(sign * Vector3::z(), true),
            ],
            half_angle,
            margin: 0.1 + 0.2,
            during: Default::default(),
        })
    };
    let constraint = |name: &str, rule| Constraint { name: name.into(), rule };
    problem
        .with_constraint(constraint("Sun", pointing(Side::KeepOut, -1.0, 0.5)))
        .with_constraint(constraint("Earth", pointing(Side::KeepIn, 1.0, 2.5)))
        .with_constraint(constraint("rate", Rule::RateNorm(1.0 / 3.0)))
        .with_constraint(constraint("rates", Rule::RateAxes(Vector3::new(0.1, 0.2, 0.3))))
}

pub fn trajectory(problem: &Problem) -> Trajectory {
    let mut numbers = Numbers(0);
    let (nodes, rows) = (problem.steps + 1, problem.scheme.input_rows(problem.steps));
    let moving = problem.motion == Motion::RigidBody;
    let mut made = Trajectory::default();
    made.time = (0..nodes).map(|k| k as f64 * problem.step()).collect();
    made.quaternion = (0..nodes).map(|_| numbers.row()).collect();
    made.angular_velocity = numbers.vectors(nodes);
    made.position = numbers.vectors(if moving { nodes } else { 0 });
    made.velocity = numbers.vectors(if moving { nodes } else { 0 });
    made.input = (0..rows * problem.actuation.count()).map(|_| numbers.next()).collect();
    made.input_count = problem.actuation.count();
    made.torque = numbers.vectors(rows);
    made.wheel_momentum = (0..nodes * wheel_count(problem)).map(|_| numbers.next()).collect();
    made.force = numbers.vectors(if moving { rows } else { 0 });
    made.costates = (0..rows * problem.dimension()).map(|_| numbers.next()).collect();
    made
}

pub fn plan(problem: &Problem) -> Plan {
    let mut verification = Verification::default();
    verification.order = Some(1.9999);
    verification.checks = vec![Check { name: "order".into(), value: 1.99, limit: 0.3, passed: true }];
    let residuals = vec![0.1 + 0.2, 1e-3, 5e-324];
    let mut solution = Solution::unknown();
    solution.outcome = Outcome::Converged;
    solution.scheme = problem.scheme;
    solution.steps = problem.steps;
    solution.step = problem.step();
    solution.cost = 0.1 + 0.7;
    solution.trajectory = trajectory(problem);
    solution.terminal.attitude_rad = 4e-13;
    solution.terminal.momentum_relative = 2e-14;
    solution.optimality.stationarity = 6e-13;
    solution.optimality.conjugate_points = Some(0);
    solution.optimality.rank = 6;
    solution.optimality.condition = 38.0;
    solution.sense = Sense::Short;
    solution.start = "short".into();
    solution.turned_deg = 150.0;
    solution.iterations = 2;
    solution.ladder = vec![RungReport::new(Rung::Newton, "short", 4, Outcome::Converged, residuals)];
    solution.shortest = Some(41.25);
    solution.longer = Some(41.5);
    solution.convex = problem.is_constrained().then(|| {
        let mut convex = ConvexWork::default();
        convex.subproblems = 3;
        convex.all_subproblems = 7;
        convex.cone_iterations = 50;
        convex.cone_seconds = 0.01;
        convex
    });
    solution.active =
        vec![ActiveConstraint::new("torque limit", vec![0.1 + 0.2, 5e-324], vec![1.0 / 3.0, 0.0])];
    solution.method = if problem.is_constrained() { Method::Scp } else { Method::Shooting };
    solution.rivals = vec![Rival::new("long", Sense::Long, 1.0 / 3.0, 210.0)];
    solution.tolerance = 1e-12;
    solution.solve_time = 0.0024;
    Plan::new(solution, Some(verification), Status::Solved)
}

/// Returns the kinds of trajectory: two motions, and wheels under constraints, in two schemes.
pub fn kinds() -> Vec<Problem> {
    let mut kinds = Vec::new();
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        kinds.push(problem(Motion::Attitude, scheme));
        kinds.push(problem(Motion::RigidBody, scheme));
        kinds.push(with_constraints(with_wheels(problem(Motion::Attitude, scheme))));
    }
    kinds
}
