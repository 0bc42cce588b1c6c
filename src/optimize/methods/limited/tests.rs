//! Arcs within constraints against closed forms, differences, and themselves on other grids.

use super::linear_programs::descended;
use super::motion::{Law, Level, Maneuver};
use super::newton::Arcs;
use super::state::State as Scaled;
use super::structure::{self, Between};
use crate::flight::{Flight, Held};
use crate::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use crate::maneuver::objective::{Fuel, Objective};
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::{Settings, Target, Thoroughness};
use crate::maneuver::switching::Structure;
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use crate::mechanics::body::{Body, Inertia};
use crate::mechanics::environment::{CentralGravity, GravityGradient, PointMass};
use crate::optimize::search::Silent;
use crate::testing::{Random, attitude_only, moving_ends};
use crate::{Vector3, lie};

/// Torques of 1 N·m about the axes of a body of the moments 1, 2, 2.9, from rest to rest about an axis.
fn turn(angle_deg: f64, axis: Vector3, rule: Rule) -> Problem {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 2.9)).unwrap(), mass: None };
    let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let end = lie::exp(&(axis.normalize() * angle_deg.to_radians()));
    let problem = Problem::attitude(
        body,
        State::at_rest(crate::Matrix3::identity()),
        State::at_rest(end),
        crate::maneuver::duration::Duration::SOUGHT,
    );
    let problem = problem.with_actuation(Actuation::torques(torques)).with_objective(Objective::Time);
    problem.with_constraint(Constraint { name: "limit".into(), rule })
}

fn cone() -> Rule {
    let direction = Direction::Fixed(Vector3::new(0.5, 3.0_f64.sqrt() / 2.0, 0.1).normalize());
    Rule::Pointing(Pointing::new(Side::KeepOut, vec![Vector3::x()], vec![direction], 20.0_f64.to_radians()))
}

/// The same turn by wheels that hold so much momentum.
fn by_wheels(angle_deg: f64, axis: Vector3, momentum_limit: f64) -> Problem {
    let wheels = Wheels { momentum: vec![0.0; 3], momentum_limit: vec![momentum_limit; 3] };
    let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    let wheels = Actuation::of_wheels(axes, vec![1.0; 3], wheels).unwrap();
    let mut problem = turn(angle_deg, axis, cone()).with_actuation(wheels);
    problem.constraints.clear();
    problem
}

/// Torques, and forces, in either axes, within limits of each.
fn with_limits(problem: Problem) -> Problem {
    fn limited(set: &ActuatorSet) -> ActuatorSet {
        let size = (0..set.count()).map(|input| 0.7 + 0.2 * input as f64).collect();
        set.clone().with_limits(Limits { size: Some(size), ..Limits::default() }).unwrap()
    }
    let mut actuation = problem.actuation.clone();
    actuation.torque = limited(&actuation.torque);
    actuation.force = actuation.force.as_ref().map(limited);
    problem.with_actuation(actuation).with_objective(Objective::Time)
}

/// Bodies in fields, in frames that turn, pushed and turned in either axes, and with wheels that store.
fn shaped(random: &mut Random) -> Vec<Problem> {
    let mut all = vec![by_wheels(100.0, Vector3::new(1.0, 2.0, 3.0), 0.4)];
    all[0].start.angular_velocity = random.vector3();
    for frame in [AxisFrame::Body, AxisFrame::Reference] {
        let moving = with_limits(moving_ends(random, frame));
        let turning = attitude_only(moving.clone());
        let gradient = GravityGradient::new(0.4, &turning.body.inertia).unwrap();
        let point = PointMass { parameter: 1.3, position: Vector3::zeros() };
        let falling = moving.clone().with_environment(CentralGravity::new(vec![point]).unwrap());
        all.extend([turning.with_environment(gradient), moving, falling]);
    }
    all
}

fn law(levels: [Level; 3], holds: &[usize]) -> Law {
    Law { levels: levels.to_vec(), holds: holds.to_vec() }
}

fn arcs(laws: Vec<Law>, lengths: &[f64]) -> Arcs {
    let contacts = vec![Vec::new(); laws.len() - 1];
    Arcs { laws, lengths: lengths.to_vec(), contacts, first: Vec::new() }
}

#[test]
fn a_turn_about_one_axis_under_a_rate_limit_is_bang_coast_bang() {
    use Level::{At, Free};
    let (angle, limit): (f64, f64) = (2.0, 0.6);
    let problem = turn(angle.to_degrees(), Vector3::x(), Rule::RateAxes(Vector3::repeat(limit)));
    let maneuver = Maneuver::of(&problem).unwrap();
    let laws = vec![
        law([At(1.0), At(0.0), At(0.0)], &[]),
        law([Free, At(0.0), At(0.0)], &[0]),
        law([At(-1.0), At(0.0), At(0.0)], &[]),
    ];
    let unit = maneuver.units.time;
    let first = arcs(laws, &[0.5 / unit, 2.0 / unit, 0.5 / unit]);
    let found = first.solve(&maneuver, &mut 40).unwrap();
    let lengths: Vec<f64> = found.arcs.lengths.iter().map(|length| length * unit).collect();
    // J = 1, u = 1: up to the limit in ω/u, along it for the rest.
    let along = angle / limit - limit;
    for (length, expected) in lengths.iter().zip([limit, along, limit]) {
        assert!((length - expected).abs() < 1e-11, "{lengths:?}");
    }
}

/// A maneuver past the cone by arcs that touch it and by arcs that go along it, near ones of its own.
fn past_a_cone() -> (Maneuver, Arcs) {
    use Level::At;
    let maneuver = Maneuver::of(&turn(120.0, Vector3::z(), cone())).unwrap();
    let laws = [[-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0]];
    let laws: Vec<Law> = laws.iter().map(|levels| law(levels.map(At), &[])).collect();
    let mut touching = arcs(laws, &[0.49, 0.47, 0.48, 0.27, 0.53]);
    touching.contacts[1].push(0);
    (maneuver, touching)
}

#[test]
fn derivatives_by_lengths_are_those_of_differences() {
    use Level::{At, Free};
    let (maneuver, touching) = past_a_cone();
    let mut along = touching.clone();
    along.laws[2] = law([At(1.0), Free, At(1.0)], &[0]);
    along.contacts[1].clear();
    for arcs in [touching, along] {
        let followed = arcs.followed(&maneuver).unwrap();
        assert_eq!(followed.contacts.len(), 2, "value and slope");
        for column in 0..arcs.laws.len() {
            let at = |size: f64| {
                let mut disturbed = arcs.clone();
                disturbed.lengths[column] += size;
                disturbed.followed(&maneuver).unwrap()
            };
            let size = 1e-5;
            let (ahead, behind) = (at(size), at(-size));
            let of_cost = (ahead.cost - behind.cost) / (2.0 * size);
            assert!((of_cost - followed.gradient[column]).abs() < 1e-7);
            let of_equations = (ahead.equations - behind.equations) / (2.0 * size);
            let off = (of_equations - followed.jacobian.column(column)).amax();
            let slope = followed.jacobian.column(column).amax();
            assert!(off < 1e-7 * (1.0 + slope), "arc {column}: {off:e} of {slope:e}");
        }
    }
}

#[test]
fn an_arc_along_a_cone_keeps_its_distance() {
    use Level::{At, Free};
    let (maneuver, arcs) = past_a_cone();
    let driven = maneuver.driven(&arcs.laws[0]).unwrap();
    let state = driven.flow(&maneuver.start, 0.8, 8);
    let along = law([At(1.0), Free, At(1.0)], &[0]);
    let along = maneuver.driven(&along).unwrap();
    let (value, slope) = (maneuver.limits[0].value(&state), maneuver.limits[0].slope(&state));
    // c̈ = 0: the cone is left at the rate at which it is left at first.
    for time in [0.1, 0.3] {
        let there = along.flow(&state, time, 8);
        assert!((maneuver.limits[0].value(&there) - value - slope * time).abs() < 1e-11);
        assert!((maneuver.limits[0].slope(&there) - slope).abs() < 1e-11);
    }
}

#[test]
fn an_arc_along_a_cone_that_moves_keeps_its_distance() {
    use Level::{At, Free};
    let turned = turn(120.0, Vector3::z(), cone());
    let gradient = GravityGradient::new(0.3, &turned.body.inertia).unwrap();
    let fixed = Vector3::new(0.5, 0.8, 0.1).normalize();
    let moving = Direction::turning(fixed, Vector3::new(0.2, -0.4, 0.3), 10.0).unwrap();
    for direction in [moving, Direction::Fixed(fixed), Direction::InFrame(fixed)] {
        let rule =
            Rule::Pointing(Pointing::new(Side::KeepOut, vec![Vector3::x()], vec![direction.clone()], 0.4));
        let problem = turn(120.0, Vector3::z(), rule).with_environment(gradient.clone());
        let maneuver = Maneuver::of(&problem).unwrap();
        let limit = &maneuver.limits[0];
        assert_eq!(limit.moves(), !matches!(direction, Direction::InFrame(_)));
        let first = law([At(1.0), At(-0.3), At(0.4)], &[]);
        let driven = maneuver.driven(&first).unwrap();
        let state = driven.flow(&maneuver.start, 0.8, 10);
        // The slope is that of differences along the motion.
        let [ahead, behind] = [1e-5, -1e-5].map(|time| limit.value(&driven.flow(&state, time, 1)));
        assert!(((ahead - behind) / 2e-5 - limit.slope(&state)).abs() < 1e-9, "{direction:?}");
        let along = law([At(1.0), Free, At(1.0)], &[0]);
        let along = maneuver.driven(&along).unwrap();
        let (value, slope) = (limit.value(&state), limit.slope(&state));
        for time in [0.1, 0.3] {
            let there = along.flow(&state, time, 12);
            assert!((limit.value(&there) - value - slope * time).abs() < 1e-10, "{direction:?}");
            assert!((limit.slope(&there) - slope).abs() < 1e-10, "{direction:?}");
        }
    }
}

/// Claim: arcs move as landing has it, which shares nothing with them but the fields and the axes: forces and torques in either axes,
/// fields, frames that turn, wheels.
#[test]
fn the_motion_is_that_of_the_flight() {
    let mut random = Random(43);
    for problem in shaped(&mut random) {
        let maneuver = Maneuver::of(&problem).unwrap();
        let levels: Vec<f64> = maneuver.inputs.iter().map(|_| random.uniform()).collect();
        let arc = Law { levels: levels.iter().map(|level| Level::At(*level)).collect(), holds: Vec::new() };
        let driven = maneuver.driven(&arc).unwrap();
        let length = 1.1 / maneuver.units.time;
        let found = driven.flow(&maneuver.start, length, 2 * driven.steps(&maneuver.start, length));
        let inputs: Vec<f64> =
            levels.iter().zip(&maneuver.inputs).map(|(level, input)| level * input.size).collect();
        let (force, torque) = problem.actuation.split(&inputs);
        let pushed = problem.actuation.force.as_ref().map_or(Vector3::zeros(), |set| set.output(force));
        let torque = problem.actuation.torque.output(torque);
        let held = Held { force: pushed, torque, outside: Vector3::zeros() };
        let steps = vec![(held, 1.1 / 40.0); 40];
        let mut flight = Flight::new(&problem);
        flight.settle(&steps);
        let flown = flight.fly(&steps, None).unwrap();
        let flown: Scaled = maneuver.scaled(&flown, &[], 1.1);
        let apart = found.minus(&flown);
        let apart = apart.rows(0, maneuver.ends()).amax();
        assert!(apart < 1e-9, "{apart:.1e} {:?} {:?}", problem.motion, problem.environment);
        if problem.actuation.wheels.is_some() {
            // What turns in all stays where it is in space.
            let total = |attitude: &crate::Matrix3, rate: &Vector3, stored: Vector3| {
                attitude * (problem.body.inertia.j() * rate + stored)
            };
            let stored = Vector3::from_fn(|wheel, _| -1.1 * inputs[wheel]);
            let own = Vector3::from_fn(|wheel, _| found.stored(wheel)) * maneuver.units.momentum();
            assert!((own - stored).amax() < 1e-12);
            let start = &problem.start;
            let before = total(&start.attitude, &start.angular_velocity, Vector3::zeros());
            let after = total(&found.attitude(), &(found.rate() / maneuver.units.time), own);
            assert!((before - after).amax() < 1e-10);
        }
    }
}

#[test]
fn derivatives_of_the_flow_are_those_of_the_motion_along_lengths() {
    let mut random = Random(47);
    for problem in shaped(&mut random) {
        let maneuver = Maneuver::of(&problem).unwrap();
        let laws = (0..3).map(|_| {
            let level = |_: &_| Level::At(if random.uniform() > 0.0 { 1.0 } else { -1.0 });
            Law { levels: maneuver.inputs.iter().map(level).collect(), holds: Vec::new() }
        });
        let arcs = arcs(laws.collect(), &[0.4, 0.3, 0.5]);
        let followed = arcs.followed(&maneuver).unwrap();
        for column in 0..3 {
            let [ahead, behind] = [1e-5, -1e-5].map(|size| {
                let mut disturbed = arcs.clone();
                disturbed.lengths[column] += size;
                disturbed.followed(&maneuver).unwrap().equations
            });
            let off = ((ahead - behind) / 2e-5 - followed.jacobian.column(column)).amax();
            let slope = followed.jacobian.column(column).amax();
            assert!(
                off < 1e-6 * (1.0 + slope),
                "arc {column}: {off:e} of {slope:e}, {:?}",
                problem.environment
            );
        }
    }
}

/// A wheel that holds little is loaded, coasts, and is unloaded: `T = θ/ω + ω J/u` with `ω = L/J`.
#[test]
fn a_turn_by_a_wheel_that_fills_is_bang_coast_bang() {
    use Level::{At, Free};
    let (angle, most): (f64, f64) = (2.0, 0.6);
    let maneuver = Maneuver::of(&by_wheels(angle.to_degrees(), Vector3::x(), most)).unwrap();
    let laws = vec![
        law([At(1.0), At(0.0), At(0.0)], &[]),
        law([Free, At(0.0), At(0.0)], &[1]),
        law([At(-1.0), At(0.0), At(0.0)], &[]),
    ];
    let unit = maneuver.units.time;
    let found = arcs(laws, &[0.5 / unit, 2.0 / unit, 0.5 / unit]).solve(&maneuver, &mut 40).unwrap();
    let lengths: Vec<f64> = found.arcs.lengths.iter().map(|length| length * unit).collect();
    for (length, expected) in lengths.iter().zip([most, angle / most - most, most]) {
        assert!((length - expected).abs() < 1e-11, "{lengths:?}");
    }
}

#[test]
fn steps_of_the_flow_are_so_short_that_halves_end_where_they_do() {
    let (maneuver, arcs) = past_a_cone();
    let mut state = maneuver.start;
    for (law, length) in arcs.laws.iter().zip(&arcs.lengths) {
        let driven = maneuver.driven(law).unwrap();
        let steps = driven.steps(&state, *length);
        let [whole, halves] = [1, 2].map(|factor| driven.flow(&state, *length, factor * steps));
        assert!(whole.minus(&halves).amax() < 1e-13, "{:e}", whole.minus(&halves).amax());
        state = whole;
    }
}

/// Continuous cost and structure of a plan on so many steps.
fn planned(problem: &Problem, steps: usize) -> (f64, Structure, Vec<String>) {
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let problem = problem.clone().with_steps(steps);
    let found = crate::optimize::search::solve(&problem, &settings, None, &mut Silent).unwrap();
    let told = found.switching.unwrap_or_else(|| panic!("no arcs on {steps} steps, {:?}", problem.objective));
    assert!(told.gap < 1e-9 * told.continuous_cost && (told.continuous_cost / found.cost - 1.0).abs() < 1e-2);
    let met = told.arcs.iter().flat_map(|arc| arc.holds.iter().chain(&arc.touches).cloned()).collect();
    (told.continuous_cost, told.structure, met)
}

#[test]
fn least_time_and_fuel_past_a_cone_do_not_depend_on_the_grid() {
    let fuel =
        turn(120.0, Vector3::z(), cone()).with_objective(Objective::Fuel(Fuel::default())).with_duration(8.0);
    let time = turn(120.0, Vector3::z(), cone());
    for problem in [fuel, time] {
        let (coarse, structure, met) = planned(&problem, 80);
        let (fine, other, _) = planned(&problem, 120);
        assert!((coarse / fine - 1.0).abs() < 1e-9, "{coarse} {fine}");
        assert_eq!(structure, other);
        assert!(!met.is_empty() || problem.objective == Objective::Time);
    }
}

/// A flight by thrust that is fixed to the body, and wheels that fill: the continuous cost is the same on other grids.
#[test]
fn least_fuel_of_flights_and_wheels_does_not_depend_on_the_grid() {
    let wheels = by_wheels(120.0, Vector3::new(1.0, 2.0, 3.0), 0.9);
    let wheels = wheels.with_objective(Objective::Fuel(Fuel::default())).with_duration(7.0);
    let body = Body { mass: Some(4.0), ..wheels.body.clone() };
    let limited = |size: f64| Limits { size: Some(vec![size; 3]), ..Limits::default() };
    let [torque, force] =
        [5.0, 4.0].map(|size| ActuatorSet::three_axes(AxisFrame::Body).with_limits(limited(size)).unwrap());
    let end = State { position: Vector3::new(0.3, -0.2, 0.5), ..wheels.end };
    let flight = Problem::rigid_body(body, wheels.start, end, 2.6);
    let flight = flight.with_actuation(Actuation::torques_and_forces(torque, force));
    let flight = flight.with_objective(Objective::Fuel(Fuel::default()));
    for problem in [wheels, flight] {
        let [coarse, fine] = [60, 100].map(|steps| planned(&problem, steps).0);
        assert!((coarse / fine - 1.0).abs() < 1e-9, "{coarse} {fine}");
    }
}

/// A short way takes less time than the turn: forces have more than they need, and the flight lasts as long as the turn alone, which has
/// arcs of its own.
#[test]
fn a_flight_by_forces_that_have_time_to_spare_lasts_as_long_as_its_turn() {
    let mut alone = turn(120.0, Vector3::new(1.0, 2.0, 3.0), cone()).with_steps(60);
    alone.constraints.clear();
    // How long the search for arcs may take is no part of what is shown here.
    let search = Thoroughness::Thorough;
    let settings = Settings { target: Target::Discrete, search, ..Settings::default() };
    let lasts = |problem: &Problem| {
        let found = crate::optimize::search::solve(problem, &settings, None, &mut Silent).unwrap();
        found.switching.unwrap()
    };
    let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
    let force = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let body = Body { mass: Some(1.0), ..alone.body.clone() };
    let end = State { position: Vector3::new(0.2, 0.1, 0.1), ..alone.end };
    let flight = Problem::rigid_body(body, alone.start, end, crate::maneuver::duration::Duration::SOUGHT);
    let flight = flight.with_actuation(Actuation::torques_and_forces(alone.actuation.torque.clone(), force));
    let flight = flight.with_objective(Objective::Time).with_steps(60);
    let (alone, flight) = (lasts(&alone), lasts(&flight));
    assert!((flight.continuous_duration_s / alone.continuous_duration_s - 1.0).abs() < 1e-9);
    assert!(flight.gap < 1e-8, "{:e}", flight.gap);
    assert_eq!(flight.singular_inputs, [0, 1, 2], "forces are within their limits");
}

#[test]
fn fuel_under_a_rate_limit_goes_along_it() {
    let rule = Rule::RateAxes(Vector3::repeat(0.35));
    let problem = turn(120.0, Vector3::new(1.0, 2.0, 3.0), rule);
    let problem = problem.with_objective(Objective::Fuel(Fuel::default())).with_duration(8.0);
    let [coarse, fine] = [50, 100].map(|steps| planned(&problem, steps).0);
    assert!((coarse / fine - 1.0).abs() < 1e-9, "{coarse} {fine}");
}

/// From lengths far off, and with an arc too many: the arc vanishes, and the rate limit that no arc holds is touched where the turn begins to coast.
#[test]
fn linear_programs_end_at_a_vertex_within_limits() {
    use Level::At;
    let (angle, limit): (f64, f64) = (2.0, 0.6);
    let problem = turn(angle.to_degrees(), Vector3::x(), Rule::RateAxes(Vector3::repeat(limit)));
    let maneuver = Maneuver::of(&problem).unwrap();
    let laws = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
    let laws = laws.iter().map(|levels| law(levels.map(At), &[])).collect();
    let unit = maneuver.units.time;
    let first = arcs(laws, &[1.0, 0.2, 2.0, 0.3].map(|length| length / unit));
    let [vertex, _] = descended(&first, &maneuver, &|| false).unwrap();
    assert_eq!(vertex.laws.len(), 3);
    for (length, expected) in vertex.lengths.iter().zip([limit, angle / limit - limit, limit]) {
        assert!((length * unit - expected).abs() < 1e-6, "{:?}", vertex.lengths);
    }
    assert_eq!(vertex.contacts, [vec![0], vec![0]], "at both ends of the coast");
    assert!(descended(&first, &maneuver, &|| true).is_none(), "it stops where it is asked to");
}

/// Two rates are at their limits at once, by one constraint: arcs that a plan tells hold both.
#[test]
fn limits_of_one_name_are_held_at_once() {
    let limits = Vector3::new(0.12, 0.16, 1.0);
    let problem = turn(120.0, Vector3::new(1.0, 1.4, 1.0), Rule::RateAxes(limits));
    let maneuver = Maneuver::of(&problem).unwrap();
    let given = problem.with_objective(Objective::default()).with_duration(12.0).with_steps(60);
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let plan = crate::optimize::search::solve(&given, &settings, None, &mut Silent).unwrap();
    let read = structure::arcs(&maneuver, &plan, Between::Means).unwrap();
    let both: f64 = read
        .laws
        .iter()
        .zip(&read.lengths)
        .filter(|(law, _)| law.holds.len() == 2)
        .map(|(_, length)| length)
        .sum();
    let at_both = |rate: &&Vector3| rate.x > 0.999 * limits.x && rate.y > 0.999 * limits.y;
    let nodes = plan.trajectory.angular_velocity.iter().filter(at_both).count();
    let share = both / read.duration();
    assert!(nodes > 10 && (share - nodes as f64 / 60.0).abs() < 0.1, "{share} of it, at {nodes} nodes of 60");
}
