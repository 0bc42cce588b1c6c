//! Maneuvers to a rate in any attitude: detumbling.
//!
//! A free body obeys `d|Π|/dt ≥ −|τ|`, with equality if the torque brakes along the momentum. So
//! under equal weights the least effort to rest is `|Π|²/2T`, the least time under a limit `U` of
//! the torque's norm `|Π|/U`, the least fuel of the norm `|Π|`, and with a price w of time the best
//! duration `|Π|/√(2w)`, whatever the inertia. In other cases the fixed-attitude planner is the
//! judge: the cost to neighbouring attitudes is no lower, and level to first order.

use super::support::{rest_to_rest, solved};
use evidence::Random;
use slewkit::maneuver::problem::{Path, Problem, Scheme, State};
use slewkit::maneuver::{
    Constraint, Direction, Duration, Fuel, Objective, Pointing, Rule, Settings, Side, Target, Weights,
};
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use slewkit::mechanics::body::Body;
use slewkit::mechanics::environment::UniformGravity;
use slewkit::optimize::search::solve;
use slewkit::plan::{PlanError, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};

/// Returns a random body that spins at `rate` rad/s and is to come to rest in `duration` s.
fn spinning(random: &mut Random, rate: f64, duration: f64) -> (Problem, f64) {
    let body = Body { inertia: random.inertia(5.0), mass: None };
    let rate = random.normal_direction() * rate;
    let momentum = (body.inertia.j() * rate).norm();
    let start = State::attitude(random.uniform_rotation(), rate);
    let rest = State::at_rest(Matrix3::identity());
    (Problem::attitude(body, start, rest, duration).with_any_attitude_at_end(), momentum)
}

fn of_norm(limit: f64) -> Actuation {
    let limits = Limits { norm: Some(limit), ..Limits::default() };
    Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap())
}

#[test]
fn the_torque_brakes_along_the_momentum() {
    let mut random = Random::new(38);
    for case in 0..12 {
        let (problem, momentum) = spinning(&mut random, 1.0, 4.0);
        let scheme = if case % 3 == 2 { Scheme::LieEuler } else { Scheme::LieVerlet };
        let least = momentum * momentum / 8.0;
        // The drift of the discrete motion keeps |Π| too: the closed form holds on every grid, to
        // round-off.
        for steps in [20, 50, 100] {
            let problem = problem.clone().with_scheme(scheme).with_steps(steps);
            let found = solve(&problem, &Settings::discrete(), None, &mut Silent).unwrap();
            assert!(found.terminal.largest() < 1e-12, "{case}: {:?}", found.terminal);
            let off = found.cost / least - 1.0;
            assert!(off.abs() < 1e-11, "case {case}, {steps} steps: {off:e}");
        }
        let landed = plan(&problem, &Settings::default(), None, &mut Silent).unwrap();
        assert_eq!(landed.status, Status::Solved, "case {case}");
        let above = landed.solution.cost / least - 1.0;
        // No torque that brings the true motion to rest takes less.
        assert!((-1e-9..1e-3).contains(&above), "case {case}: {above}");
        let found = landed.verification.unwrap();
        assert!(found.continuous_rate_rad_s < 1e-9, "case {case}: {}", found.continuous_rate_rad_s);
        assert_eq!(landed.solution.optimality.conjugate_points, Some(0), "case {case}");
    }
}

#[test]
fn least_time_fuel_and_a_price_of_time_are_those_of_closed_forms() {
    let mut random = Random::new(39);
    for case in 0..3 {
        let (problem, momentum) = spinning(&mut random, 0.8, 5.0);
        let limited = problem.clone().with_actuation(of_norm(0.7)).with_steps(60);
        let time = solved(&limited.clone().with_objective(Objective::Time).with_duration(Duration::SOUGHT));
        let fuel = solved(&limited.with_objective(Objective::Fuel(Fuel::default())));
        let weights = Weights { time_price: Some(0.05), ..Weights::default() };
        let priced = solved(&problem.with_steps(60).with_objective(weights).with_duration(Duration::SOUGHT));
        let duration = priced.trajectory.time.last().unwrap();
        let off = [
            time.cost / (momentum / 0.7) - 1.0,
            fuel.cost / momentum - 1.0,
            duration / (momentum / 0.1f64.sqrt()) - 1.0,
            priced.cost / (momentum * 0.1f64.sqrt()) - 1.0,
        ];
        assert!(off.iter().all(|off| off.abs() < 1e-10), "case {case}: {off:?}");
    }
}

/// No closed form is known with weights, a field and a rate at the end: the planner of given
/// attitudes finds no cheaper plan nearby, and an equal one there.
#[test]
fn no_attitude_nearby_is_cheaper() {
    let mut random = Random::new(40);
    let weight = nalgebra::DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![1.0, 4.0, 0.3]));
    for case in 0..4 {
        let (problem, _) = spinning(&mut random, 0.7, 4.0);
        let mut problem = problem.with_steps(60).with_objective(Weights::of_torques(weight.clone()));
        problem.end.angular_velocity = 0.3 * random.normal_direction();
        if case % 2 == 1 {
            let pendulum = UniformGravity::new(0.2, 1.0, Vector3::z(), 0.5 * random.normal_direction());
            problem = problem.with_environment(pendulum.unwrap());
        }
        let open = solved(&problem);
        assert_eq!(open.optimality.conjugate_points, Some(0), "case {case}");
        let mut given = open.on_grid(&problem);
        given.end_condition = Default::default();
        let there = given.end.attitude;
        let mut cost = |turn: Vector3| {
            given.end.attitude = lie::project_to_rotation(&(there * lie::exp(&turn)));
            solved(&given).cost
        };
        assert!((cost(Vector3::zeros()) / open.cost - 1.0).abs() < 1e-9, "case {case}");
        for axis in 0..3 {
            let by = 1e-3;
            let [back, ahead] = [-by, by].map(|by| cost(Vector3::ith(axis, by)));
            let (slope, bend) = ((ahead - back) / (2.0 * by), (ahead - 2.0 * open.cost + back) / (by * by));
            println!(
                "case {case}, axis {axis}: slope {slope:.1e}, curvature {bend:.1e}, cost {:.3}",
                open.cost
            );
            assert!(slope.abs() < 1e-5 * open.cost && bend > 0.0, "case {case}, axis {axis}: {slope} {bend}");
        }
    }
}

#[test]
fn cones_limits_and_wheels_are_kept_on_the_way_to_any_attitude() {
    let mut random = Random::new(41);
    let (problem, momentum) = spinning(&mut random, 0.15, 60.0);
    let sun = problem.start.attitude * lie::exp(&Vector3::new(0.9, 0.4, 0.0)) * Vector3::z();
    let cone = Pointing::new(Side::KeepOut, vec![Vector3::z()], vec![Direction::Fixed(sun)], 0.6);
    let coned =
        problem.clone().with_constraint(Constraint { name: "sun".into(), rule: Rule::Pointing(cone) });
    let axes = [
        Vector3::new(1.0, 0.0, 0.6),
        Vector3::new(0.0, 1.0, 0.6),
        Vector3::new(-1.0, 0.0, 0.6),
        Vector3::new(0.0, -1.0, 0.6),
    ];
    let axes: Vec<Vector3> = axes.iter().map(|axis| axis.normalize()).collect();
    let limits = Limits { size: Some(vec![0.2; 4]), ..Limits::default() };
    let set = ActuatorSet::new(axes, AxisFrame::Body).unwrap().with_limits(limits).unwrap();
    let wheels = Wheels { momentum: vec![0.0; 4], momentum_limit: vec![momentum; 4] };
    let wheeled = problem.with_actuation(Actuation { wheels: Some(wheels), ..Actuation::torques(set) });
    for (name, problem) in [("cone", coned), ("wheels", wheeled)] {
        let found = plan(&problem, &Settings::default(), None, &mut Silent).unwrap();
        assert_eq!(found.status, Status::Solved, "{name}: {:?}", found.solution.shortfall);
        let judged = found.verification.unwrap();
        let missed = judged.continuous_rate_rad_s * 60.0;
        println!("{name}: {missed:.1e} off, in the unit of a radian in the duration");
        assert!(missed < 1e-6, "{name}: {missed:e}");
        assert!(judged.margins.iter().all(|margin| margin.margin > -1e-9), "{name}: {:?}", judged.margins);
    }
}

/// A body that moves: its turn and its translation are two problems, each with a closed form. The
/// cost of a translation with `d = Δx − T(v_0 + v_N)/2` is `m² (|Δv|²/2T + 6|d|²/T³)`, to which the
/// grid adds its error of second order.
#[test]
fn a_body_that_moves_is_brought_to_a_place_in_any_attitude() {
    let mut random = Random::new(43);
    let (turn, momentum) = spinning(&mut random, 0.8, 4.0);
    let (mass, duration) = (2.0, 4.0);
    let body = Body { mass: Some(mass), ..turn.body.clone() };
    let (mut start, mut end) = (turn.start, turn.end);
    (start.velocity, end.velocity) = (random.vector(), random.vector());
    end.position = 2.0 * random.vector();
    let way = end.position - 0.5 * duration * (start.velocity + end.velocity);
    let speed = (end.velocity - start.velocity).norm_squared();
    let least = momentum * momentum / (2.0 * duration)
        + mass * mass * (speed / (2.0 * duration) + 6.0 * way.norm_squared() / duration.powi(3));
    let problem = Problem::rigid_body(body, start, end, duration).with_any_attitude_at_end();
    let off = [25, 50].map(|steps| solved(&problem.clone().with_steps(steps)).cost / least - 1.0);
    let order = (off[0] / off[1]).abs().log2();
    assert!(off[1].abs() < 1e-2 && (order - 2.0).abs() < 0.1, "{off:?}, order {order}");
    let landed = plan(&problem, &Settings::default(), None, &mut Silent).unwrap();
    assert_eq!(landed.status, Status::Solved);
    let judged = landed.verification.unwrap();
    let missed = [judged.continuous_position_m.unwrap(), judged.continuous_velocity_m_s.unwrap()];
    assert!(missed.iter().all(|missed| *missed < 1e-6), "{missed:?}");
}

#[test]
fn what_cannot_be_is_refused_or_proved() {
    let mut random = Random::new(42);
    let (problem, momentum) = spinning(&mut random, 0.8, 5.0);
    let weak = problem.clone().with_actuation(of_norm(0.9 * momentum / 5.0));
    let plan_of = |problem: &Problem| plan(problem, &Settings::default(), None, &mut Silent);
    let proved = plan_of(&weak).unwrap();
    assert_eq!(proved.status, Status::Infeasible);
    let shortest = proved.solution.infeasible.unwrap().duration_lower_bound.unwrap();
    assert!((shortest / (5.0 / 0.9) - 1.0).abs() < 1e-6, "{shortest}");
    let long = plan_of(&problem.clone().with_path(Path::Long)).unwrap_err();
    assert!(long.to_string().contains("free end attitude"), "{long}");
    let shooting = Settings { method: slewkit::maneuver::Method::Shooting, ..Settings::default() };
    let refused = plan(&problem, &shooting, None, &mut Silent).unwrap_err();
    assert!(matches!(refused, PlanError::NotForShooting { .. }), "{refused}");
    // A given attitude is not affected.
    assert_eq!(rest_to_rest(90.0).end_condition, Default::default());
    assert_eq!(Settings::discrete().target, Target::Discrete);
}
