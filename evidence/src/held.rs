//! Propagates the held inputs of a plan by independent equations of motion: Euler's equations for a
//! quaternion and momenta, integrated by the classical Runge–Kutta method with ever smaller steps.
//! The only code of the library that it uses are the force field of the maneuver and the map from
//! inputs to forces and torques.

use slewkit::maneuver::{Direction, Motion, Problem, Rule, Scheme, Side, Trajectory};
use slewkit::mechanics::environment::Pose;
use slewkit::{Matrix3, Vector3, lie};

/// The number of integration steps in each step of the plan, at first and at most.
const PARTS: (usize, usize) = (16, 1 << 14);
/// The difference below which the attitudes of two refinements count as equal \[rad\].
const SAME: f64 = 1e-8;

/// The terminal errors of a motion, and its largest violation of a limit.
#[derive(Clone, Copy, Debug)]
pub struct Flown {
    /// The attitude error at the end \[rad\].
    pub attitude: f64,
    /// The rate error at the end, relative to one radian per duration.
    pub rate: f64,
    /// The position error of a translating body at the end, relative to the distance between start
    /// and end, or to one meter.
    pub position: f64,
    /// The largest violation at the nodes of the integration: of a cone \[rad\], or of a rate limit
    /// relative to the limit. At most 0 if all constraints hold.
    pub exceeded: f64,
}

/// Returns the attitude error at the end \[rad\]; `None` if the refinement of the steps does not
/// converge.
pub fn missed(problem: &Problem, trajectory: &Trajectory) -> Option<f64> {
    flown(problem, trajectory).map(|flown| flown.attitude)
}

/// Propagates a plan; `None` if the refinement of the steps does not converge.
pub fn flown(problem: &Problem, trajectory: &Trajectory) -> Option<Flown> {
    let (mut parts, mut before) = (PARTS.0, end(problem, trajectory, PARTS.0));
    while parts < PARTS.1 {
        parts *= 4;
        let after = end(problem, trajectory, parts);
        let attitude = attitude(&after.0);
        if lie::minus(&attitude, &self::attitude(&before.0)).norm() < SAME {
            let (y, exceeded) = after;
            let vector = |index: usize| Vector3::from_column_slice(&y[4 + 3 * index..7 + 3 * index]);
            let rate = problem.body.inertia.j().lu().solve(&vector(0))?;
            let duration = trajectory.time.last()?;
            let way = (problem.end.position - problem.start.position).norm();
            let moves = problem.motion == Motion::RigidBody;
            return Some(Flown {
                attitude: lie::minus(&attitude, &problem.end.attitude).norm(),
                rate: (rate - problem.end.angular_velocity).norm() * duration,
                position: if moves { (vector(2) - problem.end.position).norm() / way.max(1.0) } else { 0.0 },
                exceeded,
            });
        }
        before = after;
    }
    None
}

/// The state: quaternion, angular momentum, wheel momentum, position and linear momentum, in this
/// order.
type Numbers = [f64; 16];

/// Returns the final state and the largest violation. Each step of the plan is divided into `parts`
/// integration steps.
fn end(problem: &Problem, trajectory: &Trajectory, parts: usize) -> (Numbers, f64) {
    let start = &problem.start;
    let mass = problem.body.mass.unwrap_or(1.0);
    let momentum = problem.body.inertia.j() * start.angular_velocity;
    let of_wheels = problem.actuation.wheels.as_ref().map_or_else(Vector3::zeros, |wheels| {
        problem.actuation.torque.axes().iter().zip(&wheels.momentum).map(|(axis, h)| axis * *h).sum()
    });
    let mut y = [0.0; 16];
    y[..4].copy_from_slice(&lie::quaternion_from_rotation(&start.attitude));
    for (index, vector) in
        [momentum, of_wheels, start.position, start.velocity * mass].into_iter().enumerate()
    {
        y[4 + 3 * index..7 + 3 * index].copy_from_slice(vector.as_slice());
    }
    let mut worst = f64::NEG_INFINITY;
    for step in 0..trajectory.time.len() - 1 {
        // Bang-bang inputs are held over their own steps. Lie–Euler kicks at the end of a step, and
        // its first row belongs to the end of the first step. Lie–Verlet kicks by half at either
        // end of a step.
        let inputs: Vec<f64> = if problem.switches() || problem.scheme == Scheme::LieEuler {
            trajectory.inputs(step).to_vec()
        } else {
            let (from, to) = (trajectory.inputs(step), trajectory.inputs(step + 1));
            from.iter().zip(to).map(|(a, b)| 0.5 * (a + b)).collect()
        };
        let (from, to) = (trajectory.time[step], trajectory.time[step + 1]);
        let h = (to - from) / parts as f64;
        for part in 0..parts {
            let moved =
                |by: f64, slope: &Numbers| -> Numbers { std::array::from_fn(|i| y[i] + by * slope[i]) };
            let a = slope(problem, &inputs, &y);
            let b = slope(problem, &inputs, &moved(0.5 * h, &a));
            let c = slope(problem, &inputs, &moved(0.5 * h, &b));
            let d = slope(problem, &inputs, &moved(h, &c));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
            let norm = y[..4].iter().map(|q| q * q).sum::<f64>().sqrt();
            y[..4].iter_mut().for_each(|q| *q /= norm);
            if !problem.constraints.is_empty() {
                worst = worst.max(exceeded(problem, from + (part + 1) as f64 * h, &y));
            }
        }
    }
    (y, worst)
}

/// Returns the largest violation of a constraint.
fn exceeded(problem: &Problem, time: f64, y: &Numbers) -> f64 {
    let r = attitude(y);
    let momentum = Vector3::from_column_slice(&y[4..7]);
    let rate = problem.body.inertia.j().lu().solve(&momentum).unwrap_or(momentum);
    // The rotation from the inertial frame to the reference frame.
    let frame = lie::exp(&(-time * problem.environment.frame_rate()));
    let of = |rule: &Rule| match rule {
        Rule::RateNorm(limit) => rate.norm() / limit - 1.0,
        Rule::RateAxes(limits) => rate.component_div(limits).amax() - 1.0,
        Rule::Pointing(pointing) => {
            if !pointing.during.contains(time) {
                return f64::NEG_INFINITY;
            }
            let of_pair = |(boresight, direction): (&Vector3, &Direction)| {
                let target = match direction {
                    Direction::InFrame(vector) => *vector,
                    _ => frame * direction.in_space(time, &problem.environment.frame_rate()).direction,
                };
                let angle = (r * boresight).cross(&target).norm().atan2((r * boresight).dot(&target));
                match pointing.side {
                    Side::KeepOut => pointing.half_angle + pointing.margin - angle,
                    Side::KeepIn => angle - (pointing.half_angle - pointing.margin),
                    Side::On { within } => (angle - pointing.half_angle).abs() - within,
                }
            };
            let pairs = pointing.boresights.iter().flat_map(|boresight| {
                pointing.directions.iter().map(move |direction| (boresight, direction))
            });
            pairs.map(of_pair).fold(f64::NEG_INFINITY, f64::max)
        }
    };
    problem.constraints.iter().map(|constraint| of(&constraint.rule)).fold(f64::NEG_INFINITY, f64::max)
}

/// Returns the time derivative of the state: `q̇ = ½(qΩ − nq)`, `Π̇ = (Π + μ) × Ω + M`, `μ̇ = −B u`
/// for wheels, `ẋ = γ/m`, `γ̇ = F`.
fn slope(problem: &Problem, inputs: &[f64], y: &Numbers) -> Numbers {
    let vector = |index: usize| Vector3::from_column_slice(&y[4 + 3 * index..7 + 3 * index]);
    let (momentum, of_wheels, position, linear) = (vector(0), vector(1), vector(2), vector(3));
    let r = attitude(y);
    let (of_forces, of_torques) = problem.actuation.split(inputs);
    let torques = &problem.actuation.torque;
    let torque = torques.frame().to_body(&r, &torques.output(of_torques));
    let field = problem.environment.wrench(&Pose { position, attitude: r });
    let rate = problem.body.inertia.j().lu().solve(&momentum).unwrap_or(momentum);
    let turning = problem.environment.frame_rate();
    let q = [y[0], y[1], y[2], y[3]];
    let (right, left) = (product(&q, &pure(&rate)), product(&pure(&turning), &q));
    let mut out = [0.0; 16];
    (0..4).for_each(|i| out[i] = 0.5 * (right[i] - left[i]));
    let slopes = [
        (momentum + of_wheels).cross(&rate) + torque + field.moment,
        if problem.actuation.wheels.is_some() { -torque } else { Vector3::zeros() },
        linear / problem.body.mass.unwrap_or(1.0),
        field.force
            + problem
                .actuation
                .force
                .as_ref()
                .map_or_else(Vector3::zeros, |set| set.frame().to_reference(&r, &set.output(of_forces))),
    ];
    let moves = if problem.motion == Motion::RigidBody { 4 } else { 2 };
    for (index, slope) in slopes.iter().take(moves).enumerate() {
        out[4 + 3 * index..7 + 3 * index].copy_from_slice(slope.as_slice());
    }
    out
}

fn attitude(y: &Numbers) -> Matrix3 {
    lie::rotation_from_quaternion(&[y[0], y[1], y[2], y[3]])
}

fn pure(v: &Vector3) -> [f64; 4] {
    [0.0, v.x, v.y, v.z]
}

fn product(a: &[f64; 4], b: &[f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}
