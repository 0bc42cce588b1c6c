//! Invariance of plans under units, order of work, threads, the direction of time, and the
//! reference frame.

use super::support::{assert_close, full_body, full_inertia, rest_to_rest, solved, weighted};
use evidence::Random;
use nalgebra::{DMatrix, DVector};
use slewkit::maneuver::objective::Weights;
use slewkit::maneuver::problem::{Path, Problem, Scheme, State};
use slewkit::maneuver::settings::Settings;
use slewkit::maneuver::solution::Solution;
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::{CentralGravity, PointMass, UniformGravity};
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::PI;

/// Sizes of the units of mass, length, time and cost.
#[derive(Clone, Copy, Debug)]
struct Units {
    mass: f64,
    length: f64,
    time: f64,
    cost: f64,
}

impl Units {
    fn inertia(&self) -> f64 {
        self.mass * self.length * self.length
    }

    /// Returns the units of the weights `W` of torques and of forces.
    fn weights(&self) -> (f64, f64) {
        let torque = self.inertia() / self.time / self.time;
        let force = torque / self.length;
        (self.cost / torque / torque / self.time, self.cost / force / force / self.time)
    }
}

const ONE: Units = Units { mass: 1.0, length: 1.0, time: 1.0, cost: 1.0 };

/// Returns a pendulum between moving ends, its numbers converted to `units`.
fn pendulum(units: Units) -> Problem {
    let inertia = Inertia::new(full_inertia().j() * units.inertia()).unwrap();
    let rate = |x, y, z| Vector3::new(x, y, z) / units.time;
    let start = State::attitude(lie::exp(&Vector3::new(0.3, -0.1, 0.2)), rate(0.1, 0.2, -0.3));
    let end = State::attitude(lie::exp(&Vector3::new(-0.5, 0.9, 0.4)), rate(0.2, -0.1, 0.1));
    let weight = DMatrix::from_diagonal(&DVector::from_row_slice(&[1.0, 2.0, 0.5])) * units.weights().0;
    let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    let torque = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
    let gravity = 1.7 * units.length / units.time / units.time;
    let arm = Vector3::new(0.1, -0.2, 0.9) * units.length;
    Problem::attitude(Body { inertia, mass: None }, start, end, 2.0 * units.time)
        .with_actuation(Actuation::torques(torque))
        .with_objective(Weights::of_torques(weight))
        .with_environment(UniformGravity::new(units.mass, gravity, Vector3::z(), arm).unwrap())
        .with_path(Path::Shortest)
}

/// Returns a dumbbell near an attracting center, its numbers converted to `units`.
fn dumbbell(units: Units) -> Problem {
    let (length, speed) = (units.length, units.length / units.time);
    let inertia = Inertia::diagonal(Vector3::new(0.05, 0.11, 0.11) * units.inertia()).unwrap();
    let body = Body { inertia, mass: Some(units.mass) };
    let start = State {
        position: Vector3::x() * length,
        velocity: Vector3::y() * speed,
        attitude: Matrix3::identity(),
        angular_velocity: Vector3::z() / units.time,
    };
    let end = State {
        position: Vector3::new(-0.2, 0.9, 0.1) * length,
        velocity: Vector3::new(-0.9, -0.3, 0.3) * speed,
        attitude: lie::exp(&Vector3::new(0.2, 0.3, 1.5)),
        angular_velocity: Vector3::new(0.1, 0.4, 0.5) / units.time,
    };
    let (torque, force) = units.weights();
    let weight = |weight: f64| Some(DMatrix::identity(3, 3) * weight);
    let parameter = 0.5 * units.mass * length * speed * speed;
    let points = [0.1, -0.1].map(|x| PointMass { parameter, position: Vector3::new(x * length, 0.0, 0.0) });
    Problem::rigid_body(body, start, end, 1.8 * units.time)
        .with_objective(Weights { torque: weight(torque), force: weight(force), time_price: None })
        .with_environment(CentralGravity::new(points.to_vec()).unwrap())
        .with_path(Path::Shortest)
}

/// Returns the unit of each costate of a row.
fn costate_units(units: Units, dimension: usize) -> Vec<f64> {
    let momentum = units.inertia() / units.time;
    let linear = momentum / units.length;
    let all = [units.cost / units.length, units.cost / linear, units.cost, units.cost / momentum];
    (0..dimension).map(|row| all[(row + 12 - dimension) / 3]).collect()
}

fn check_units(build: fn(Units) -> Problem, choices: &[Units]) {
    let plain = solved(&build(ONE));
    for &units in choices {
        let problem = build(units);
        let solution = solved(&problem);
        let dimension = problem.dimension();
        let conversion = costate_units(units, dimension);
        let costates: Vec<f64> = solution
            .trajectory
            .costates
            .iter()
            .enumerate()
            .map(|(index, value)| value / conversion[index % dimension])
            .collect();
        assert_close(&format!("costates in {units:?}"), &costates, &plain.trajectory.costates, 1e-12);
        assert_close("cost", &[solution.cost / units.cost], &[plain.cost], 1e-12);
    }
}

#[test]
fn units_do_not_matter() {
    let of = |mass, length, time, cost| Units { mass, length, time, cost };
    let choices = [
        of(3.0, 0.7, 11.0, 0.3),
        of(1e-9, 1.0, 1.0, 1.0),
        of(1e12, 1.0, 1.0, 1e-6),
        of(1.0, 1.0, 1e-3, 1e9),
        of(1.0, 1.0, 1e6, 1.0),
        of(1e3, 1e5, 1e4, 1e-12),
        of(1e-5, 1e-2, 1e-3, 1e7),
    ];
    check_units(pendulum, &choices);
    check_units(dumbbell, &choices);
}

fn bits(solution: &Solution) -> Vec<u64> {
    let trajectory = &solution.trajectory;
    let quaternions = trajectory.quaternion.iter().flatten();
    let all = trajectory.costates.iter().chain(&trajectory.input).chain(quaternions);
    all.chain([&solution.cost, &solution.turned_deg]).map(|value| value.to_bits()).collect()
}

#[test]
fn equal_inputs_give_equal_bits_in_any_order_and_on_any_thread() {
    let problems: Vec<Problem> = vec![
        rest_to_rest(120.0),
        pendulum(ONE).with_path(Path::Best),
        dumbbell(ONE),
        rest_to_rest(75.0).with_scheme(Scheme::LieEuler).with_steps(1000),
    ];
    let first: Vec<_> = problems.iter().map(|problem| bits(&solved(problem))).collect();
    let mut again: Vec<_> = problems.iter().rev().map(|problem| bits(&solved(problem))).collect();
    again.reverse();
    assert!(first == again, "in reverse order");
    let from_threads: Vec<Vec<u64>> = std::thread::scope(|scope| {
        let threads: Vec<_> = problems.iter().map(|problem| scope.spawn(|| bits(&solved(problem)))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(first == from_threads, "on threads of their own");
}

#[test]
fn the_reversed_maneuver_costs_the_same() {
    // Time reversal: the ends change places and the rates their sign.
    let mut random = Random::new(3);
    for _ in 0..6 {
        let mut state = || State::attitude(lie::exp(&random.vector()), 0.5 * random.vector());
        let (start, end) = (state(), state());
        let back = |state: &State| State { angular_velocity: -state.angular_velocity, ..*state };
        let field = UniformGravity::new(1.0, 1.7, Vector3::z(), Vector3::new(0.1, -0.2, 0.9)).unwrap();
        let forward = Problem::attitude(full_body(), start, end, 2.0)
            .with_objective(weighted([1.0, 2.0, 0.5]))
            .with_environment(field);
        let mut reversed = forward.clone();
        (reversed.start, reversed.end) = (back(&end), back(&start));
        // Lie–Verlet is symmetric in time: equal to round-off, not to its order.
        assert_close("cost", &[solved(&reversed).cost], &[solved(&forward).cost], 1e-11);
    }
}

#[test]
fn the_reference_frame_does_not_matter() {
    let turn = lie::exp(&Vector3::new(0.7, -1.1, 0.4));
    let fall = Vector3::new(0.0, 0.0, 1.0);
    let field = |fall| UniformGravity::new(1.0, 1.7, fall, Vector3::new(0.1, -0.2, 0.9)).unwrap();
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        let problem = pendulum(ONE).with_scheme(scheme);
        let mut turned = problem.clone().with_environment(field(turn * fall));
        for state in [&mut turned.start, &mut turned.end] {
            state.attitude = lie::project_to_rotation(&(turn * state.attitude));
        }
        let (plain, turned) = (solved(&problem), solved(&turned));
        assert_close("cost", &[turned.cost], &[plain.cost], 1e-11);
        // Inputs and costates are in body axes.
        assert_close("inputs", &turned.trajectory.input, &plain.trajectory.input, 1e-10);
        assert_close("costates", &turned.trajectory.costates, &plain.trajectory.costates, 1e-10);
    }
}

/// Half a turn to one side and to the other end at one attitude, up to the last bits: rounding must
/// not choose.
#[test]
fn half_a_turn_goes_round_as_it_is_given() {
    let mut random = Random::new(964);
    for case in 0..24 {
        let start = State::at_rest(random.rotation());
        let mut turn = Vector3::zeros();
        turn[case % 3] = if case % 2 == 0 { PI } else { -PI };
        let end = State::at_rest(lie::project_to_rotation(&(start.attitude * lie::exp(&turn))));
        let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 1.1, 0.95)).unwrap(), mass: None };
        let problem = Problem::attitude(body, start, end, 3.0).with_steps(40).with_path(Path::AsGiven(turn));
        let plan = plan(&problem, &Settings::discrete(), None, &mut Silent).unwrap();
        assert_eq!(plan.status, Status::Solved, "{case}: {:?}", plan.verification);
    }
}

/// The long way from rest to rest often begins at a saddle. The minimum below it must be found
/// within limits too, and no rival may be cheaper.
#[test]
fn limits_that_do_not_act_change_nothing_on_the_long_way() {
    let inertia = Matrix3::new(2.644, -0.312, 0.0802, -0.312, 2.799, 0.793, 0.0802, 0.793, 2.046);
    let start = lie::exp(&(Vector3::new(-0.471, 0.332, -1.702).normalize() * 2.637));
    let y = |angle: f64| lie::exp(&Vector3::new(0.0, angle, 0.0));
    let end = y(-0.2619) * lie::exp(&Vector3::new(-1.695, 0.0, 0.0)) * y(-2.3453);
    let mut random = Random::new(2522);
    let drawn = (0..7).map(|_| (random.rotation(), random.rotation()));
    for (case, (start, end)) in std::iter::once((start, end)).chain(drawn).enumerate() {
        let body = Body { inertia: Inertia::new(inertia).unwrap(), mass: None };
        let [start, end] = [start, end].map(State::at_rest);
        let free = Problem::attitude(body, start, end, 5.0).with_steps(108).with_path(Path::Long);
        let known = solved(&free);
        let peak = known.trajectory.input.iter().fold(0.0, |peak: f64, input| peak.max(input.abs()));
        let limits = Limits { size: Some(vec![1.5 * peak; 3]), ..Limits::default() };
        let torque = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
        let limited = solved(&free.clone().with_actuation(Actuation::torques(torque)));
        assert!((limited.cost / known.cost - 1.0).abs() < 1e-9, "{case}: {} {}", limited.cost, known.cost);
        for rival in known.rivals.iter().filter(|rival| rival.sense == known.sense) {
            assert!(rival.cost > known.cost, "{case}: {rival:?} {}", known.cost);
        }
    }
}
