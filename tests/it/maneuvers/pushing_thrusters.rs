//! Minimum fuel and time by thrusters that push and turn a body at once: closed forms, separate
//! torques and forces with an equal effect, refused specs.

use super::fuel_of_forces::{FEW, MASS, each, flight, near, pushes};
use super::minimum_time::solved;
use slewkit::maneuver::{Duration, Fuel, Objective, Problem, ProblemError};
use slewkit::mechanics::{Actuation, ActuatorSet, ActuatorSetError, AxisFrame, Limits};
use slewkit::{Vector3, lie};

/// Half the distance of the two thrusters that push along one axis the same way \[m\].
const ARM: f64 = 0.5;

/// Returns twelve thrusters of `limit` \[N\]: for each axis two that push along it and two that
/// push against it, next to each other along the next axis. Couples turn the body about the third
/// axis, in addition to any push.
fn twelve(limit: f64) -> Actuation {
    let (mut positions, mut directions) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [1.0, -1.0] {
            for beside in [ARM, -ARM] {
                let direction = Vector3::ith(axis, side);
                positions.push(Vector3::ith((axis + 1) % 3, beside) - 0.6 * direction);
                directions.push(direction);
            }
        }
    }
    Actuation::of_thrusters(positions, directions, one_sided(limit, 12)).unwrap()
}

fn one_sided(limit: f64, count: usize) -> Limits {
    Limits { size: Some(vec![limit; count]), one_sided: true, ..Limits::default() }
}

/// Returns a flight from rest to rest in 3 s.
fn by_thrusters(turn: [f64; 3], shift: [f64; 3], limit: f64) -> Problem {
    flight(turn, shift, each(1.0), AxisFrame::Body).with_actuation(twelve(limit))
}

#[test]
fn a_shift_costs_what_one_force_along_each_axis_does() {
    let shift = [0.9, -0.4, 0.2];
    // Two thrusters push each way.
    let each_axis: f64 = shift.iter().map(|along| pushes(*along, 3.0, 2.5)).sum();
    near(solved(&by_thrusters([0.0; 3], shift, 1.25)).solution.cost, each_axis, 1e-8);
    // Pushes along two axes at once are stronger: a body that turns on its way is there sooner.
    let fastest =
        by_thrusters([0.0; 3], shift, 1.25).with_objective(Objective::Time).with_duration(Duration::SOUGHT);
    let fastest = fastest.with_steps(FEW);
    assert!(solved(&fastest).solution.cost < 2.0 * (MASS * 0.9 / 2.5_f64).sqrt());
}

#[test]
fn a_turn_costs_what_torques_of_their_own_do() {
    // A couple of two thrusters of 2 N gives 2 N·m, and each of the two half of that for half of
    // the price.
    let turn = [0.5, -0.7, 0.3];
    let mut alone = flight(turn, [0.0; 3], each(1.0), AxisFrame::Body);
    let prices = Some(vec![1.0 / ARM; 3]);
    alone.objective = Objective::Fuel(Fuel { prices, ..Fuel::default() });
    let wanted = solved(&alone).solution.cost;
    near(solved(&by_thrusters(turn, [0.0; 3], 2.0)).solution.cost, wanted, 1e-6);
}

#[test]
fn a_thruster_through_the_mass_center_pushes_only() {
    let shift = [0.9, 0.0, 0.0];
    let twelve = twelve(1.25);
    let force = twelve.force.as_ref().unwrap();
    let mut positions = twelve.thrusters.as_ref().unwrap().positions.clone();
    let mut directions = force.axes().to_vec();
    // One for each way of the shift, so that a push each way is at most 4.5 N.
    for side in [1.0, -1.0] {
        positions.push(Vector3::x() * (-0.6 * side));
        directions.push(Vector3::x() * side);
    }
    let mut limits = one_sided(1.25, 14);
    limits.size.as_mut().unwrap()[12..].fill(2.0);
    let with_engines = Actuation::of_thrusters(positions, directions, limits).unwrap();
    let found = solved(&by_thrusters([0.0; 3], shift, 1.25).with_actuation(with_engines));
    near(found.solution.cost, pushes(0.9, 3.0, 4.5), 1e-8);
}

#[test]
fn a_push_while_the_body_turns_goes_where_it_points() {
    let problem = by_thrusters([0.9, 1.2, -0.4], [0.7, -0.4, 0.5], 2.0);
    let trajectory = solved(&problem).solution.trajectory;
    let actuation = &problem.actuation;
    let force = actuation.force.as_ref().unwrap();
    let positions = &actuation.thrusters.as_ref().unwrap().positions;
    for row in 0..trajectory.torque.len() {
        let attitude = lie::rotation_from_quaternion(&trajectory.quaternion[row]);
        let pushed = trajectory.inputs(row).iter().zip(force.axes()).map(|(input, axis)| axis * *input);
        let pushed: Vec<Vector3> = pushed.collect();
        let whole: Vector3 = pushed.iter().sum();
        let moment: Vector3 =
            positions.iter().zip(&pushed).map(|(position, push)| position.cross(push)).sum();
        assert!((attitude * whole - trajectory.force[row]).norm() < 1e-13, "{row}");
        assert!((moment - trajectory.torque[row]).norm() < 1e-13, "{row}");
    }
}

/// The first guess of the duration does not follow the weakest thruster.
#[test]
fn a_weak_thruster_among_strong_ones_does_not_lead_the_search_astray() {
    let strong = by_thrusters([0.3, 0.2, -0.1], [0.5, -0.3, 0.4], 2.0);
    let strong = strong.with_objective(Objective::Time).with_duration(Duration::SOUGHT).with_steps(FEW);
    let twelve = &strong.actuation;
    let (positions, directions) = (
        twelve.thrusters.as_ref().unwrap().positions.clone(),
        twelve.force.as_ref().unwrap().axes().to_vec(),
    );
    let mut limits = one_sided(2.0, 12);
    limits.size.as_mut().unwrap()[0] = 0.02;
    let weak = strong.clone().with_actuation(Actuation::of_thrusters(positions, directions, limits).unwrap());
    let [strong, weak] = [strong, weak].map(|problem| solved(&problem).solution.cost);
    assert!(strong < weak && weak < 2.0 * strong, "{strong} s, {weak} s");
}

#[test]
fn what_cannot_push_and_turn_every_way_is_refused() {
    let refused = |problem: Problem, words: &str| {
        let error = problem.check().expect_err("accepted");
        assert!(matches!(error, ProblemError::Unsuited(_)) && error.to_string().contains(words), "{error}");
    };
    let problem = by_thrusters([0.3, 0.2, 0.1], [0.5, 0.4, -0.2], 2.0);
    problem.check().unwrap();
    let twelve = &problem.actuation;
    let (positions, directions) =
        (&twelve.thrusters.as_ref().unwrap().positions, twelve.force.as_ref().unwrap().axes());
    let kept = |keep: &dyn Fn(usize) -> bool| {
        let of = |all: &[Vector3]| {
            (0..12).filter(|index| keep(*index)).map(|index| all[index]).collect::<Vec<_>>()
        };
        let (positions, directions) = (of(positions), of(directions));
        let limits = one_sided(2.0, positions.len());
        problem.clone().with_actuation(Actuation::of_thrusters(positions, directions, limits).unwrap())
    };
    let words = "thrusters that together push and turn in every direction";
    // If one of a pair is missing, the other cannot push one way and turn the other way at once.
    refused(kept(&|index| index != 0 && index != 1), words);
    refused(kept(&|index| index % 4 < 2), words);
    refused(kept(&|index| index < 6), words);
    refused(problem.clone().with_objective(Objective::default()), "minimum time or minimum fuel");
    let prices = Fuel { prices: Some(vec![1.0; 12]), ..Fuel::default() };
    let error = problem.clone().with_objective(Objective::Fuel(prices)).check().expect_err("accepted");
    assert!(error.to_string().contains("prices of forces"), "{error}");
    for limits in [
        Limits { one_sided: false, ..one_sided(2.0, 12) },
        Limits { norm: Some(2.0), ..one_sided(2.0, 12) },
        Limits { rate: Some(vec![1.0; 12]), ..one_sided(2.0, 12) },
        Limits { norm: Some(2.0), ..Limits::default() },
    ] {
        let actuation = Actuation::of_thrusters(positions.clone(), directions.to_vec(), limits).unwrap();
        refused(problem.clone().with_actuation(actuation), "remove other limits");
    }
    let mut torn = problem.clone();
    torn.actuation.thrusters.as_mut().unwrap().positions[3].z += 1e-3;
    refused(torn, "disagree");
    let mut still = problem.clone();
    (still.motion, still.body.mass) = (slewkit::maneuver::Motion::Attitude, None);
    refused(still, "a body that translates");
    let short = Actuation::of_thrusters(positions[1..].to_vec(), directions.to_vec(), one_sided(2.0, 12));
    assert_eq!(short, Err(ActuatorSetError::Position { count: 11 }));
    let mut nowhere = positions.clone();
    nowhere[5].z = f64::NAN;
    let nowhere = Actuation::of_thrusters(nowhere, directions.to_vec(), one_sided(2.0, 12));
    assert_eq!(nowhere, Err(ActuatorSetError::Position { count: 12 }));
    // The attitude alone is limited: four thrusters in a half space turn it one way only.
    let half = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, -1.0, 0.0]].map(Vector3::from);
    let half = ActuatorSet::new(half.to_vec(), AxisFrame::Body).unwrap();
    assert!(!half.with_limits(one_sided(1.0, 4)).unwrap().reaches_every_direction());
}
