//! Margins by iteration against the reference.

use super::*;
use crate::maneuver::{Constraint, Direction, Pointing, Rule, Side, State};
use crate::mechanics::{Body, Inertia};
use crate::plan::Silent;
use crate::testing::{matrix, reference, vector};
use crate::uncertainty::tests::parameters;
use crate::{Matrix3, Rotation, Vector3};

fn maneuver() -> (serde_json::Value, Problem, Uncertainty) {
    let file = reference("closed_loop/cl04_chance_backoff.json");
    let given = &file["problem"];
    let body = Body { inertia: Inertia::new(matrix(&given["inertia"])).unwrap(), mass: None };
    let end = State::at_rest(Rotation::new(matrix(&given["end"]["attitude"]["matrix"])).unwrap());
    let unit = |value: &serde_json::Value| vector::<3>(value).normalize();
    let cone = Pointing {
        side: Side::KeepOut,
        boresights: vec![unit(&given["cone"]["boresight"])],
        directions: vec![Direction::Fixed(unit(&given["cone"]["direction"]))],
        half_angle: given["cone"]["half_angle"].as_f64().unwrap(),
        margin: 0.0,
        during: Default::default(),
    };
    let start = State::at_rest(Matrix3::identity());
    let problem = Problem::attitude(body, start, end, 60.0)
        .with_steps(100)
        .with_constraint(Constraint { name: "Sun".into(), rule: Rule::Pointing(cone) });
    let uncertainty = Uncertainty {
        start: matrix(&given["P0"]),
        parameters: parameters(&given["sigma_p"]),
        torque_noise: matrix(&given["Sw"]),
        sensor_noise: {
            let mut map = crate::optimize::linear_plan::Matrix6::identity();
            map.fixed_view_mut::<3, 3>(3, 3).copy_from(problem.body.inertia.j_inverse());
            map * matrix::<6, 6>(&given["Rs"]) * map.transpose()
        },
    };
    (file, problem, uncertainty)
}

/// The iteration of cl04, with torques at nodes as it has them: margin, chance and deviation of each plan.
#[test]
fn margins_of_torques_at_nodes_are_those_of_the_reference() {
    use crate::optimize::linear_plan::Timing;
    let (file, mut problem, uncertainty) = maneuver();
    let craft = problem.clone();
    for expected in file["iterations"].as_array().unwrap() {
        let number = |key: &str| expected[key].as_f64().unwrap();
        Limit::named(&problem, "Sun").unwrap().hold(&mut problem, &craft, &[number("margin")]);
        let plan = plan::plan(&problem, &Settings::discrete(), None, &mut Silent).unwrap();
        assert!((plan.solution.cost - number("cost")).abs() < 1e-7, "{}", plan.solution.cost);
        let linear = LinearPlan::new(&problem, &plan.solution.trajectory, Timing::AtNodes).unwrap();
        let gains = Gains::along(&linear, Kind::Tvlqr(None), false).unwrap();
        let covariance = Covariance::along(&linear, Some(&gains), &uncertainty);
        let chance = &Chance::of_constraints(&problem, &linear, &covariance)[0];
        assert_eq!(chance.worst().node as f64, number("node"));
        assert!((chance.largest() / number("chance_linear") - 1.0).abs() < 1e-5, "{}", chance.largest());
    }
}

/// Margin and cost of cl04: there torques act at nodes, half a step later than ours that are held, whose loop is a little tighter.
#[test]
fn a_chance_takes_the_margin_of_the_reference() {
    let (file, problem, uncertainty) = maneuver();
    let kept = [Kept { limits: vec!["Sun"], at_most: 0.01, over: Over::Instant }];
    let settings = Settings::discrete();
    let (with, plan, margins) =
        super::plan(&problem, &settings, Some(Kind::Tvlqr(None).into()), &uncertainty, &kept, &mut Silent)
            .unwrap();
    assert!(margins.agreed && plan.status == Status::Solved, "{margins:?}");
    let last = file["iterations"].as_array().unwrap().last().unwrap();
    let (margin, cost) = (last["margin"].as_f64().unwrap(), last["cost"].as_f64().unwrap());
    assert!(
        (margins.held[0].parts[0] / margin - 1.0).abs() < 0.05,
        "{} for {margin}",
        margins.held[0].parts[0]
    );
    assert!((plan.solution.cost / cost - 1.0).abs() < 2e-3, "{} for {cost}", plan.solution.cost);
    assert!((margins.cost_without - 1.155_823_235_548_22).abs() < 1e-7);
    let beside =
        Beside::along(&with, &plan.solution.trajectory, Some(Kind::Tvlqr(None).into()), Some(&uncertainty))
            .unwrap();
    let chance = beside.chances[0].largest();
    assert!(chance <= 0.0101 && chance > 0.005, "{chance}");
}

/// The chance of a motion is met by flights of other cases, takes more than that of an instant, and less than the sum over the nodes.
#[test]
fn the_chance_of_a_motion_is_that_of_other_flights() {
    let (_, problem, uncertainty) = maneuver();
    let asked = 0.02;
    let kind = Some(Kind::Tvlqr(None).into());
    let planned = |over: Over| {
        let kept = [Kept { limits: vec!["Sun"], at_most: asked, over }];
        let found = super::plan(&problem, &Settings::default(), kind, &uncertainty, &kept, &mut Silent);
        let (with, plan, margins) = found.unwrap();
        assert!(margins.agreed && plan.status == Status::Solved, "{margins:?}");
        (plan.solution.on_grid(&with), plan, margins)
    };
    let (with, plan, margins) = planned(Over::Motion(Plant::default()));
    let (_, _, of_instant) = planned(Over::Instant);
    assert!(
        of_instant.counted == [None] && margins.held[0].parts[0] > of_instant.held[0].parts[0],
        "{margins:?}"
    );
    let beside = Beside::along(&with, &plan.solution.trajectory, kind, Some(&uncertainty)).unwrap();
    assert!(beside.chances[0].nodes.iter().sum::<f64>() > asked);
    let counted = margins.counted[0].unwrap();
    assert!(counted.of >= 5000 && counted.low < asked && asked < counted.high, "{counted:?}");
    let gains = beside.gains.as_ref();
    let campaign = Campaign::new(&with, &beside.linear, gains, &uncertainty, Plant::default(), 1);
    let flown = campaign.fly_all(0, 20_000);
    let violated = flown.iter().filter(|flown| flown.as_ref().is_ok_and(|flown| flown.room[0] < 0.0));
    let found = Proportion::new(violated.count() as u64, 20_000);
    // Both counts err: by a tenth, and by a twentieth.
    assert!(found.part() > 0.75 * asked && found.part() < 1.33 * asked, "{found:?}");
}

#[test]
fn an_end_too_near_to_its_cone_is_refused() {
    let (_, mut problem, uncertainty) = maneuver();
    let boresight = problem.end.attitude * Vector3::x();
    for constraint in &mut problem.constraints {
        let Rule::Pointing(cone) = &mut constraint.rule else { unreachable!("a cone") };
        cone.directions = vec![Direction::Fixed(boresight)];
        cone.half_angle = 1e-3;
        cone.boresights = vec![Rotation::exp(&Vector3::new(0.0, 0.0, 1.1e-3)).matrix() * Vector3::x()];
    }
    let kept = [Kept { limits: vec!["Sun"], at_most: 1e-3, over: Over::Instant }];
    let kind = Some(Kind::Tvlqr(None).into());
    let found = super::plan(&problem, &Settings::default(), kind, &uncertainty, &kept, &mut Silent);
    assert!(matches!(found, Err(NotKept::Plan(PlanError::Problem(_)))), "{:?}", found.map(|found| found.2));
}
