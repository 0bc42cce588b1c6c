//! Arcs within constraints against closed forms, differences, and themselves on other grids.

use super::motion::{Law, Level, Maneuver};
use super::newton::Arcs;
use crate::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use crate::maneuver::objective::{Fuel, Objective};
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::{Settings, Target};
use crate::maneuver::switching::Structure;
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits};
use crate::mechanics::body::{Body, Inertia};
use crate::optimize::search::Silent;
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

fn law(levels: [Level; 3], holds: &[usize]) -> Law {
    Law { levels: levels.to_vec(), holds: holds.to_vec() }
}

fn arcs(laws: Vec<Law>, lengths: &[f64]) -> Arcs {
    let contacts = vec![Vec::new(); laws.len() - 1];
    Arcs { laws, lengths: lengths.to_vec(), contacts }
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

#[test]
fn fuel_under_a_rate_limit_goes_along_it() {
    let rule = Rule::RateAxes(Vector3::repeat(0.35));
    let problem = turn(120.0, Vector3::new(1.0, 2.0, 3.0), rule);
    let problem = problem.with_objective(Objective::Fuel(Fuel::default())).with_duration(8.0);
    let [coarse, fine] = [50, 100].map(|steps| planned(&problem, steps).0);
    assert!((coarse / fine - 1.0).abs() < 1e-9, "{coarse} {fine}");
}
