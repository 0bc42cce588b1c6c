//! Where the inputs of a plan lead, held over each step, by plain equations of motion: Euler's in a quaternion and momenta, by the
//! classical Runge–Kutta method on ever finer steps. Of the library it uses the field of the maneuver and what its inputs exert.

use slewkit::maneuver::{Motion, Problem, Scheme, Trajectory};
use slewkit::mechanics::environment::Pose;
use slewkit::{Matrix3, Vector3, lie};

/// Parts of a step of the plan, at first and at most.
const PARTS: (usize, usize) = (16, 1 << 14);
/// Attitudes of two refinements that differ by less are the same \[rad\].
const SAME: f64 = 1e-7;

/// How far the end of the motion is from the attitude asked for \[rad\]; `None` where finer steps do not settle it.
pub fn missed(problem: &Problem, trajectory: &Trajectory) -> Option<f64> {
    let (mut parts, mut before) = (PARTS.0, end(problem, trajectory, PARTS.0));
    while parts < PARTS.1 {
        parts *= 4;
        let attitude = end(problem, trajectory, parts);
        if lie::minus(&attitude, &before).norm() < SAME {
            return Some(lie::minus(&attitude, &problem.end.attitude).norm());
        }
        before = attitude;
    }
    None
}

/// Quaternion, momentum, momentum of the wheels, position and linear momentum, in this order.
type Numbers = [f64; 16];

/// The attitude at the end, by so many parts of each step.
fn end(problem: &Problem, trajectory: &Trajectory, parts: usize) -> Matrix3 {
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
    for step in 0..problem.steps {
        // Lie–Euler kicks at the end of a step, and has no row before that; Lie–Verlet half at either end.
        let inputs: Vec<f64> = match problem.scheme {
            Scheme::LieEuler => trajectory.inputs(step).to_vec(),
            Scheme::LieVerlet => {
                let (from, to) = (trajectory.inputs(step), trajectory.inputs(step + 1));
                from.iter().zip(to).map(|(a, b)| 0.5 * (a + b)).collect()
            }
        };
        let h = problem.step() / parts as f64;
        for _ in 0..parts {
            let moved =
                |by: f64, slope: &Numbers| -> Numbers { std::array::from_fn(|i| y[i] + by * slope[i]) };
            let a = slope(problem, &inputs, &y);
            let b = slope(problem, &inputs, &moved(0.5 * h, &a));
            let c = slope(problem, &inputs, &moved(0.5 * h, &b));
            let d = slope(problem, &inputs, &moved(h, &c));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
            let norm = y[..4].iter().map(|q| q * q).sum::<f64>().sqrt();
            y[..4].iter_mut().for_each(|q| *q /= norm);
        }
    }
    attitude(&y)
}

/// `q̇ = ½(qΩ − nq)`, `Π̇ = (Π + μ) × Ω + M`, `μ̇ = −B u` of wheels, `ẋ = γ/m`, `γ̇ = F`.
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
