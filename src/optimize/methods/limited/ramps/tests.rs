//! Inputs that change at limited rates against closed forms, differences, other equations of motion and another program.

use super::{Course, courses};
use crate::flight::{Flight, Held};
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::{Settings, Target};
use crate::maneuver::switching::Switching;
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use crate::mechanics::body::{Body, Inertia};
use crate::optimize::methods::limited::certificate::Certificate;
use crate::optimize::methods::limited::motion::{Law, Level, Maneuver};
use crate::optimize::methods::limited::newton::Arcs;
use crate::optimize::search::Silent;
use crate::{Matrix3, Vector3, lie};

/// A turn from rest to rest in least time, by torques within these limits that change at this rate.
fn turn(moments: Vector3, angle_deg: f64, axis: Vector3, size: [f64; 3], rate: f64) -> Problem {
    let body = Body { inertia: Inertia::diagonal(moments).unwrap(), mass: None };
    let limits = Limits { size: Some(size.to_vec()), rate: Some(vec![rate; 3]), ..Limits::default() };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let end = State::at_rest(lie::exp(&(axis.normalize() * angle_deg.to_radians())));
    let problem = Problem::minimum_time(body, State::at_rest(Matrix3::identity()), end);
    problem.with_actuation(Actuation::torques(torques))
}

/// The maneuver that another program has solved.
fn asymmetric() -> Problem {
    let moments = Vector3::new(1.22, 1.96, 2.76);
    turn(moments, 122.0, Vector3::new(0.663, -0.642, -0.384), [0.5, 0.89, 0.89], 2.32)
}

/// The same by wheels that store nothing at first, each with its torque.
fn by_wheels(problem: &Problem) -> Problem {
    let limits = problem.actuation.torque.limits().clone();
    let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    let wheels = Wheels { momentum: vec![0.0; 3], momentum_limit: vec![f64::INFINITY; 3] };
    let mut wheels = Actuation::of_wheels(axes, limits.size.clone().unwrap(), wheels).unwrap();
    wheels.torque = wheels.torque.with_limits(limits).unwrap();
    problem.clone().with_actuation(wheels)
}

fn planned(problem: &Problem, steps: usize) -> Switching {
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let problem = problem.clone().with_steps(steps);
    let found = crate::optimize::search::solve(&problem, &settings, None, &mut Silent).unwrap();
    let told = found.switching.unwrap_or_else(|| panic!("no arcs on {steps} steps"));
    assert!(told.gap < 1e-9 * told.continuous_cost, "{:e}", told.gap);
    told
}

fn law(levels: [Level; 3], holds: &[usize]) -> Law {
    Law { levels: levels.to_vec(), holds: holds.to_vec() }
}

/// From one limit to the other at once, between nodes.
#[test]
fn a_ramp_is_where_its_impulse_is() {
    let (step, rate) = (0.1, 4.0);
    let exact = |time: f64| (1.0 - rate * (time - 0.93)).clamp(-1.0, 1.0);
    let values: Vec<f64> = (0..=20).map(|node| exact(f64::from(node) * step)).collect();
    let found = courses(&values, step, rate);
    let expected = [(0.0, Course::Hold(1.0)), (0.93, Course::Ramp(-1.0)), (1.43, Course::Hold(-1.0))];
    assert_eq!(found.len(), 3, "{found:?}");
    for ((time, course), (when, what)) in found.iter().zip(expected) {
        assert_eq!(*course, what);
        // Nodes round the corners off.
        assert!((time - when).abs() < 0.1 * step, "{found:?}");
    }
}

/// Begins within its limits, turns back before it comes to the other one, and ends on the way up.
#[test]
fn a_ramp_may_turn_back_and_be_cut_off() {
    let (step, rate) = (0.1, 1.0);
    let exact = |time: f64| if time < 1.0 { 0.4 - time } else { time - 1.6 };
    let values: Vec<f64> = (0..=20).map(|node| exact(f64::from(node) * step)).collect();
    let found = courses(&values, step, rate);
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!(found[0], (0.0, Course::Ramp(-1.0)));
    assert_eq!(found[1].1, Course::Ramp(1.0));
    assert!((found[1].0 - 1.0).abs() < 1e-9, "{found:?}");
}

/// With `a` half of the duration and `b = u/r` half of the ramp, `θ J = u (a² − b²/3)`.
#[test]
fn a_turn_about_one_axis_ramps_in_its_middle() {
    use Level::{At, Free};
    let (angle, rate): (f64, f64) = (2.0, 1.6);
    let problem = turn(Vector3::new(1.0, 2.0, 2.9), angle.to_degrees(), Vector3::x(), [1.0; 3], rate);
    let maneuver = Maneuver::of(&problem).unwrap();
    let laws = vec![
        law([Free, At(0.0), At(0.0)], &[0]),
        law([At(-1.0), At(0.0), At(0.0)], &[]),
        law([Free, At(0.0), At(0.0)], &[1]),
    ];
    let unit = maneuver.units.time;
    let first = Arcs {
        laws,
        lengths: [1.0, 1.0, 1.0].map(|length| length / unit).to_vec(),
        contacts: vec![Vec::new(); 2],
        first: vec![0.7, 0.1, -0.1],
    };
    let found = first.solve(&maneuver, &mut 40).unwrap().arcs;
    let half = (angle + 1.0 / (3.0 * rate * rate)).sqrt();
    let held = half - 1.0 / rate;
    for (length, expected) in found.lengths.iter().zip([held, 2.0 / rate, held]) {
        assert!((length * unit - expected).abs() < 1e-11, "{length} {expected}");
    }
    for (level, expected) in found.first.iter().zip([1.0, 0.0, 0.0]) {
        assert!((level - expected).abs() < 1e-11, "{:?}", found.first);
    }
}

/// Arcs of a plan, so disturbed that nothing is met, by lengths and by what inputs begin with.
#[test]
fn derivatives_by_lengths_and_first_levels_are_those_of_differences() {
    use Level::{At, Free};
    for problem in [asymmetric(), by_wheels(&asymmetric())] {
        let maneuver = Maneuver::of(&problem).unwrap();
        let laws = vec![
            law([Free, At(-1.0), Free], &[0, 5]),
            law([At(-1.0), Free, At(1.0)], &[3]),
            law([At(-1.0), At(1.0), Free], &[4]),
        ];
        let lengths = vec![0.5, 0.4, 0.6];
        let arcs = Arcs { laws, lengths, contacts: vec![Vec::new(); 2], first: vec![0.9, 0.2, -0.8] };
        let followed = arcs.followed(&maneuver).unwrap();
        assert_eq!(followed.contacts.len(), 4, "{:?}", followed.contacts);
        let disturbed = |column: usize, size: f64| {
            let mut disturbed = arcs.clone();
            match column.checked_sub(3) {
                None => disturbed.first[column] += size,
                Some(arc) => disturbed.lengths[arc] += size,
            }
            disturbed.followed(&maneuver).unwrap().equations
        };
        for column in 0..6 {
            let [ahead, behind] = [1e-5, -1e-5].map(|size| disturbed(column, size));
            let off = ((ahead - behind) / 2e-5 - followed.jacobian.column(column)).amax();
            let slope = followed.jacobian.column(column).amax();
            assert!(off < 1e-7 * (1.0 + slope), "{column}: {off:e} of {slope:e}");
        }
    }
}

/// The arcs that are told, flown in small steps by the equations of landing, which share nothing with them, come to the end.
#[test]
fn the_arcs_that_are_told_lead_to_the_end() {
    for problem in [asymmetric(), by_wheels(&asymmetric())] {
        let told = planned(&problem, 60);
        let missed = [2000, 4000].map(|count| {
            let steps: Vec<(Held, f64)> = told
                .arcs
                .iter()
                .flat_map(|arc| {
                    let length = arc.end_s - arc.start_s;
                    let steps = (f64::from(count) * length / told.continuous_duration_s).ceil();
                    let middle = move |step: u32| arc.start_s + (f64::from(step) + 0.5) * length / steps;
                    let held = |torque: Vec<f64>| Held {
                        force: Vector3::zeros(),
                        torque: problem.actuation.torque.output(&torque),
                        outside: Vector3::zeros(),
                    };
                    (0..steps as u32).map(move |step| (held(arc.input_at(middle(step))), length / steps))
                })
                .collect();
            let mut flight = Flight::new(&problem);
            flight.settle(&steps);
            let end = flight.fly(&steps, None).unwrap();
            let turn = lie::minus(&end.attitude, &problem.end.attitude).amax();
            turn.max(end.angular_velocity.amax())
        });
        // Torques held over each step are off by its square.
        assert!(missed[1] < 1e-6 && (missed[0] / missed[1] - 4.0).abs() < 0.5, "{missed:?}");
    }
}

/// Direct multiple shooting with quaternions and torques as states (Runge–Kutta of order 4), CasADi 3.8.2 and IPOPT, the lowest of six
/// starts, on 320 and 640 intervals extrapolated.
#[test]
fn least_time_by_ramps_is_that_of_another_program() {
    let expected = 3.663695;
    let [coarse, fine] = [60, 100].map(|steps| planned(&asymmetric(), steps).continuous_duration_s);
    assert!((coarse / fine - 1.0).abs() < 1e-11, "{coarse} {fine}");
    assert!((fine - expected).abs() < 1e-6, "{fine}");
}

/// Wheels from rest to rest whose torques are those of a turn about one axis all change about half of the duration: with `a` half of it
/// and `b` half of the ramp, `θ J·n = u (a² − b²/3)`. Ramps that begin and end together say the same twice, and are told apart.
#[test]
fn wheels_that_change_at_once_have_multipliers_of_their_own() {
    use Level::{At, Free};
    let (angle, rate) = (100.0_f64.to_radians(), 1.5);
    let (moments, axis) = (Vector3::new(1.0, 2.0, 2.9), Vector3::new(1.0, 2.0, 2.2).normalize());
    let size: [f64; 3] = moments.component_mul(&axis).into();
    let mut problem = turn(moments, angle.to_degrees(), axis, size, 1.0);
    let rates = size.iter().map(|size| rate * size).collect();
    let limits = Limits { rate: Some(rates), ..problem.actuation.torque.limits().clone() };
    problem.actuation.torque = problem.actuation.torque.with_limits(limits).unwrap();
    let maneuver = Maneuver::of(&by_wheels(&problem)).unwrap();
    let laws = vec![law([Free; 3], &[0, 2, 4]), law([At(-1.0); 3], &[]), law([Free; 3], &[1, 3, 5])];
    let unit = maneuver.units.time;
    let lengths = [0.6, 1.0, 0.7].map(|length| length / unit).to_vec();
    let first = Arcs { laws, lengths, contacts: vec![Vec::new(); 2], first: vec![1.0; 3] };
    let found = first.solve(&maneuver, &mut 40).unwrap();
    let half = (angle + 1.0 / (3.0 * rate * rate)).sqrt();
    assert!((found.arcs.duration() * unit - 2.0 * half).abs() < 1e-11);
    assert_eq!(found.arcs.laws.len(), 7, "two arcs of no length at either end of the ramps");
    let Certificate { wrong, gap } = Certificate::of(&maneuver, &found).unwrap();
    assert!(wrong.is_empty() && gap < 1e-9, "{gap:e} {wrong:?}");
}
