//! Families of random maneuvers with duration 1.

use crate::random::Random;
use nalgebra::{DMatrix, DVector};
use slewkit::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use slewkit::maneuver::objective::Weights;
use slewkit::maneuver::problem::{Problem, State};
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::{CentralGravity, GravityGradient, PointMass, UniformGravity};
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::{PI, TAU};

/// Returns the stream of random numbers for a case of a family. Each case has its own stream.
pub fn case(seed: u64, family: usize, index: usize) -> Random {
    Random::of_case(seed ^ ((family as u64 + 77) << 48), index)
}

/// A family of maneuvers: its name, and the function that draws its cases.
pub struct Family {
    pub name: &'static str,
    pub draw: fn(&mut Random) -> Problem,
}

pub const FAMILIES: [Family; 13] = [
    Family { name: "F1 full torque, rates to 5 rad/T", draw: full_torque },
    Family { name: "F2 rest to rest, boxes among them", draw: rest_to_rest },
    Family { name: "F3 two torques", draw: two_torques },
    Family { name: "F4 long detumbling", draw: detumbling },
    Family { name: "F5 pendulum", draw: pendulum },
    Family { name: "F6 gravity gradient", draw: gravity_gradient },
    Family { name: "F7 dumbbell in central gravity", draw: dumbbell },
    Family { name: "F8 body-fixed thrust", draw: body_fixed_thrust },
    Family { name: "F9 weights of ratio 1000", draw: stiff_weights },
    Family { name: "F10 box limits", draw: box_limits },
    Family { name: "F11 cones", draw: cones },
    Family { name: "F12 wheels", draw: wheels },
    Family { name: "F13 any attitude at the end", draw: any_attitude },
];

fn body(inertia: Inertia) -> Body {
    Body { inertia, mass: None }
}

/// Returns torque inputs about the three axes of a frame.
fn about(frame: AxisFrame) -> ActuatorSet {
    ActuatorSet::new(vec![Vector3::x(), Vector3::y(), Vector3::z()], frame).expect("three axes")
}

fn full_torque(random: &mut Random) -> Problem {
    let inertia = random.inertia(8.0);
    let start = State::attitude(Matrix3::identity(), random.within_cube(5.0));
    let end = State::attitude(random.uniform_rotation(), random.within_cube(5.0));
    Problem::attitude(body(inertia), start, end, 1.0)
}

/// Draws a rest-to-rest slew. In half of the cases, a body with principal body axes turns about one
/// of them by 90°, 180° or any other angle.
fn rest_to_rest(random: &mut Random) -> Problem {
    let at = |r: Matrix3| State::at_rest(r);
    if random.coin() {
        let inertia = random.inertia(8.0);
        let end = at(random.uniform_rotation());
        return Problem::attitude(body(inertia), at(Matrix3::identity()), end, 1.0);
    }
    let moments = random.mean_moments(8.0);
    let inertia = Inertia::new(Matrix3::from_diagonal(&moments)).expect("a box");
    let axis = (random.unit() * 3.0) as usize % 3;
    let any = random.within(0.0, PI);
    let angle = [0.5 * PI, PI, any][(random.unit() * 3.0) as usize % 3];
    let end = at(lie::exp(&Vector3::ith(axis, angle)));
    Problem::attitude(body(inertia), at(Matrix3::identity()), end, 1.0)
}

fn two_torques(random: &mut Random) -> Problem {
    let inertia = random.inertia(8.0);
    let axes = vec![random.normal_direction(), random.normal_direction()];
    let set = ActuatorSet::new(axes, AxisFrame::Body).expect("two torques");
    let half = if random.coin() { 2.0 } else { 0.0 };
    let start = State::attitude(Matrix3::identity(), random.within_cube(half));
    let end = State::attitude(random.uniform_rotation(), random.within_cube(half));
    Problem::attitude(body(inertia), start, end, 1.0).with_actuation(Actuation::torques(set))
}

fn detumbling(random: &mut Random) -> Problem {
    let inertia = random.inertia(5.0);
    let rate = |random: &mut Random| random.normal_direction() * random.within(10.0, 30.0);
    let start = State::attitude(Matrix3::identity(), rate(random));
    let stop = random.coin();
    let end = State::attitude(random.uniform_rotation(), if stop { Vector3::zeros() } else { rate(random) });
    Problem::attitude(body(inertia), start, end, 1.0)
}

/// Draws a maneuver to rest or to another rate at a free attitude. Limits, weights and two torques
/// alternate.
fn any_attitude(random: &mut Random) -> Problem {
    let inertia = random.inertia(8.0);
    let rate = |random: &mut Random| random.normal_direction() * random.within(1.0, 15.0);
    let start = State::attitude(Matrix3::identity(), rate(random));
    let end =
        State::attitude(Matrix3::identity(), if random.coin() { Vector3::zeros() } else { rate(random) });
    let j = inertia.j();
    let change = (j * (end.angular_velocity - start.angular_velocity)).amax();
    let problem = Problem::attitude(body(inertia), start, end, 1.0).with_any_attitude_at_end();
    match (random.unit() * 3.0) as usize {
        0 => problem,
        1 => {
            let weight =
                DMatrix::from_diagonal(&DVector::from_fn(3, |_, _| random.within(0.0, 30f64.ln()).exp()));
            problem.with_objective(Weights::of_torques(weight))
        }
        _ => {
            let limits =
                Limits { size: Some(vec![random.within(1.5, 3.0) * change; 3]), ..Limits::default() };
            let set = about(AxisFrame::Body).with_limits(limits).expect("limits");
            problem.with_actuation(Actuation::torques(set))
        }
    }
}

fn pendulum(random: &mut Random) -> Problem {
    let inertia = random.inertia(8.0);
    let omega = random.within(2.0, 10.0);
    // ω² = m g |ρ| / J with J = 1.
    let rho = random.normal_direction() * 0.3;
    let field = UniformGravity::new(1.0, omega * omega / 0.3, Vector3::z(), rho).expect("a pendulum");
    let start = State::attitude(random.uniform_rotation(), random.within_cube(1.0));
    let end = State::attitude(random.uniform_rotation(), random.within_cube(1.0));
    Problem::attitude(body(inertia), start, end, 1.0).with_environment(field)
}

fn gravity_gradient(random: &mut Random) -> Problem {
    let inertia = random.inertia(8.0);
    let rate = random.within(1.0, TAU);
    let field = GravityGradient::new(rate, &inertia).expect("a gravity gradient");
    let start = State::attitude(random.uniform_rotation(), random.within_cube(1.0));
    let end = State::attitude(random.uniform_rotation(), random.within_cube(1.0));
    Problem::attitude(body(inertia), start, end, 1.0).with_environment(field)
}

fn dumbbell(random: &mut Random) -> Problem {
    let rate = random.within(0.6, 3.6);
    // A circular orbit of radius 1.
    let mu = rate * rate;
    let (half, mass) = (random.within(0.05, 0.2), 1.0);
    let axis = random.normal_direction();
    let sphere = |position: Vector3| PointMass { parameter: 0.5 * mu * mass, position };
    let spheres = vec![sphere(axis * half), sphere(axis * -half)];
    let radius = 0.6 * half;
    let ball = 0.4 * mass * radius * radius;
    let j = Matrix3::from_diagonal_element(ball)
        + (Matrix3::identity() - axis * axis.transpose()) * (mass * half * half);
    let inertia = Inertia::new(0.5 * (j + j.transpose())).expect("a dumbbell");
    let field = CentralGravity::new(spheres).expect("a field");
    let state = |angle: f64, random: &mut Random, attitude: Matrix3| State {
        position: Vector3::new(angle.cos(), angle.sin(), 0.0) + random.within_cube(0.05),
        velocity: Vector3::new(-angle.sin(), angle.cos(), 0.0) * rate,
        attitude,
        angular_velocity: random.within_cube(1.0),
    };
    let (a, b) = (random.uniform_rotation(), random.uniform_rotation());
    let start = state(0.0, random, a);
    let end = state(rate, random, b);
    // The weights make a turn by one radian cost as much as a displacement by one radius of the
    // orbit.
    let price = DMatrix::identity(3, 3) / (inertia.mean() * inertia.mean());
    let actuation = Actuation::torques_and_forces(about(AxisFrame::Body), about(AxisFrame::Reference));
    let problem = Problem::rigid_body(Body { inertia, mass: Some(mass) }, start, end, 1.0);
    problem.with_environment(field).with_actuation(actuation).with_objective(Weights::of_torques(price))
}

fn body_fixed_thrust(random: &mut Random) -> Problem {
    let inertia = random.inertia(4.0);
    let price = 10f64.powf(random.within(-1.0, 3.0));
    let weights = Weights {
        torque: Some(DMatrix::identity(3, 3) * price),
        force: Some(DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 4.0, 4.0]))),
        time_price: None,
    };
    let state = |random: &mut Random, position: Vector3| State {
        position,
        velocity: Vector3::zeros(),
        attitude: random.uniform_rotation(),
        angular_velocity: Vector3::zeros(),
    };
    let start = state(random, Vector3::zeros());
    let to = random.normal_direction() * random.within(1.0, 3.0);
    let end = state(random, to);
    let body = Body { inertia, mass: Some(1.0) };
    let actuation = Actuation::torques_and_forces(about(AxisFrame::Body), about(AxisFrame::Body));
    Problem::rigid_body(body, start, end, 1.0).with_actuation(actuation).with_objective(weights)
}

fn stiff_weights(random: &mut Random) -> Problem {
    let inertia = random.inertia(8.0);
    let axes = random.uniform_rotation();
    let middle = 1000f64.powf(random.unit());
    let w = axes * Matrix3::from_diagonal(&Vector3::new(1.0, middle, 1000.0)) * axes.transpose();
    let w = 0.5 * (w + w.transpose());
    let weight = DMatrix::from_fn(3, 3, |row, column| w[(row, column)]);
    let start = State::attitude(Matrix3::identity(), random.within_cube(3.0));
    let end = State::attitude(random.uniform_rotation(), random.within_cube(3.0));
    Problem::attitude(body(inertia), start, end, 1.0).with_objective(Weights::of_torques(weight))
}

/// Draws a rest-to-rest slew, and returns its angle the short way \[rad\] too.
fn slew(random: &mut Random) -> (Problem, f64) {
    let inertia = random.inertia(8.0);
    let angle = random.within(0.5, 3.0);
    let end = State::at_rest(lie::exp(&(random.normal_direction() * angle)));
    (Problem::attitude(body(inertia), State::at_rest(Matrix3::identity()), end, 1.0), angle)
}

/// Draws a slew with torque limits of 70–120 % of the peak torque of a fixed-axis turn of the mean
/// inertia. In most cases a plan without limits exceeds these limits, and few cases have no plan.
fn box_limits(random: &mut Random) -> Problem {
    let (problem, angle) = slew(random);
    let limits = Limits { size: Some(vec![random.within(0.7, 1.2) * 6.0 * angle; 3]), ..Limits::default() };
    let set = about(AxisFrame::Body).with_limits(limits).expect("limits of three torques");
    problem.with_actuation(Actuation::torques(set))
}

/// Draws a slew with one or two cones that a boresight would cross on the turn about the fixed
/// axis.
fn cones(random: &mut Random) -> Problem {
    let (mut problem, angle) = slew(random);
    let axis = lie::log(&problem.end.attitude) / angle;
    let count = if random.coin() { 1 } else { 2 };
    while problem.constraints.len() < count {
        let boresight = random.normal_direction();
        let half_angle = random.within(5.0, 25.0).to_radians();
        let passed = lie::exp(&(axis * (angle * random.within(0.25, 0.75)))) * boresight;
        let aside = random.normal_direction() * (half_angle * random.unit());
        let direction = lie::exp(&aside) * passed;
        let clear = |r: &Matrix3| (r * boresight).angle(&direction) > half_angle + 0.02;
        if clear(&problem.start.attitude) && clear(&problem.end.attitude) {
            let pointing =
                Pointing::new(Side::KeepOut, vec![boresight], vec![Direction::Fixed(direction)], half_angle);
            let name = format!("cone {}", problem.constraints.len() + 1);
            problem = problem.with_constraint(Constraint { name, rule: Rule::Pointing(pointing) });
        }
    }
    problem
}

/// Draws a maneuver with three wheels that spin at the start and can store twice the momentum that
/// a turn of the mean inertia needs.
fn wheels(random: &mut Random) -> Problem {
    let (problem, angle) = slew(random);
    let most = 3.0 * angle;
    let momentum = random.within_cube(0.3 * most).iter().copied().collect();
    let wheels = Wheels { momentum, momentum_limit: vec![most; 3] };
    let torque = about(AxisFrame::Body);
    problem.with_actuation(Actuation { wheels: Some(wheels), ..Actuation::torques(torque) })
}
