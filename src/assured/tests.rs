//! Tests of the iterated margins against reference values.

use super::*;
use crate::closed_loop::{Campaign, Flown};
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
    let cone = Pointing::new(
        Side::KeepOut,
        vec![unit(&given["cone"]["boresight"])],
        vec![Direction::Fixed(unit(&given["cone"]["direction"]))],
        given["cone"]["half_angle"].as_f64().unwrap(),
    );
    let start = State::at_rest(Matrix3::identity());
    let problem = Problem::attitude(body, start, end, 60.0)
        .with_steps(100)
        .with_constraint(Constraint { name: "Sun".into(), rule: Rule::Pointing(cone) });
    let uncertainty = Uncertainty {
        start: matrix(&given["P0"]),
        parameters: parameters(&given["sigma_p"]),
        torque_noise: matrix(&given["Sw"]),
        sensor_noise: {
            let mut map = crate::optimize::discrete::linear_plan::Matrix6::identity();
            map.fixed_view_mut::<3, 3>(3, 3).copy_from(problem.body.inertia.j_inverse());
            map * matrix::<6, 6>(&given["Rs"]) * map.transpose()
        },
    };
    (file, problem, uncertainty)
}

/// Compares margin, chance and deviation of each plan with the iteration of the reference file
/// cl04, which has torques at nodes.
#[test]
fn margins_of_torques_at_nodes_are_those_of_the_reference() {
    use crate::optimize::discrete::linear_plan::Timing;
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

/// Compares margin and cost with the reference file cl04. Its torques act at nodes, half a step
/// later than the held torques here, so the loop here is slightly tighter.
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

/// Simulated flights of other cases confirm the chance over the motion. It needs a larger margin
/// than an equal chance at an instant. The sum of the chances at all nodes is larger than it.
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
    // The two counts have relative errors of about a tenth and a twentieth.
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

/// Returns the slew of the reference without its cone, with active limits of torques and rates.
fn limited() -> (Problem, Uncertainty) {
    use crate::mechanics::{Actuation, ActuatorSet, AxisFrame, Limits};
    let (_, mut problem, mut uncertainty) = maneuver();
    // Deviations are reduced to a third, because limits of both kinds leave little reserve.
    uncertainty.start /= 9.0;
    uncertainty.parameters.iter_mut().for_each(|(_, _, sigma)| *sigma /= 3.0);
    problem.constraints.clear();
    let free = plan::plan(&problem, &Settings::default(), None, &mut Silent).unwrap().solution.trajectory;
    let most = |of: &dyn Fn(usize) -> f64| (0..=100).map(of).fold(0.0, f64::max);
    let sizes: Vec<f64> = (0..3).map(|i| most(&|k| free.inputs(k)[i].abs())).collect();
    let rates = Vector3::from_fn(|i, _| 0.97 * most(&|k| free.angular_velocity[k][i].abs()));
    let limits = Limits { size: Some(sizes), ..Limits::default() };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let problem = problem
        .with_actuation(Actuation::torques(torques))
        .with_constraint(Constraint { name: "rates".into(), rule: Rule::RateAxes(rates) });
    (problem, uncertainty)
}

/// At the worst instant every active part of a limit keeps the requested chance, and flights
/// confirm it.
#[test]
fn limits_of_torques_and_rates_keep_their_chances_at_the_worst_instant() {
    let (problem, uncertainty) = limited();
    let asked = 0.02;
    let kind = Some(Kind::Tvlqr(None).into());
    let kept = [Kept { limits: vec!["torque limit", "rates"], at_most: asked, over: Over::Instant }];
    let (with, plan, margins) =
        super::plan(&problem, &Settings::default(), kind, &uncertainty, &kept, &mut Silent).unwrap();
    assert!(margins.agreed && plan.status == Status::Solved, "{margins:?}");
    assert!(plan.solution.cost > margins.cost_without);
    // Adding the reserve to the limits that the plan keeps gives the limits of the problem.
    assert_eq!(with.of_craft().actuation, problem.actuation);
    assert_eq!(with.of_craft().constraints, problem.constraints);
    let on_grid = plan.solution.on_grid(&with);
    let beside = Beside::along(&on_grid, &plan.solution.trajectory, kind, Some(&uncertainty)).unwrap();
    // The large authority prevents clipping, so that commands show the requested torque.
    let plant = Plant { authority: 1e3, ..Plant::default() };
    let gains = beside.gains.as_ref();
    let campaign = Campaign::new(&on_grid, &beside.linear, gains, &uncertainty, plant, 1);
    let flown = campaign.trace_all(0, 20_000, |_, moments| {
        let beyond = |chance: &Chance| -> Vec<bool> {
            let part = |(part, worst): (usize, &crate::uncertainty::chance::Worst)| {
                let limit = Limit::named(&problem, &chance.name).unwrap().bounds(&problem)[part];
                let moment = &moments[worst.node];
                match chance.quantity {
                    Quantity::Rate => moment.angular_velocity[part].abs() > limit,
                    _ => moment.commanded[part].abs() > limit,
                }
            };
            chance.parts.iter().enumerate().map(part).collect()
        };
        beside.chances.iter().map(beyond).collect::<Vec<_>>()
    });
    let mut active = 0;
    for (index, chance) in beside.chances.iter().enumerate() {
        for (part, worst) in chance.parts.iter().enumerate() {
            assert!(worst.chance < 1.02 * asked, "{} {part}: {worst:?}", chance.name);
            active += usize::from(worst.chance > 0.98 * asked);
            let beyond = flown.iter().filter(|case| case.as_ref().unwrap()[index][part]).count();
            let found = Proportion::new(beyond as u64, 20_000);
            // The tolerance covers the 95 % interval and the nonlinear part.
            assert!(
                found.low < 1.25 * worst.chance && found.high > worst.chance / 1.25,
                "{} {part}: {found:?} for {worst:?}",
                chance.name
            );
        }
    }
    assert!(active >= 3, "{active} of 6: {:?}", beside.chances.iter().map(|c| &c.parts).collect::<Vec<_>>());
}

/// A joint chance of several limits over the motion: other flights exceed any of them with the
/// requested frequency.
#[test]
fn a_chance_that_limits_share_is_that_of_other_flights() {
    let (problem, uncertainty) = limited();
    let asked = 0.05;
    let kind = Some(Kind::Tvlqr(None).into());
    let kept = [Kept {
        limits: vec!["torque limit", "rates"],
        at_most: asked,
        over: Over::Motion(Plant::default()),
    }];
    let (with, plan, margins) =
        super::plan(&problem, &Settings::default(), kind, &uncertainty, &kept, &mut Silent).unwrap();
    assert!(margins.agreed && plan.status == Status::Solved, "{margins:?}");
    let counted = margins.counted[0].unwrap();
    assert!(counted.low < asked && asked < counted.high, "{counted:?}");
    let on_grid = plan.solution.on_grid(&with);
    let beside = Beside::along(&on_grid, &plan.solution.trajectory, kind, Some(&uncertainty)).unwrap();
    let gains = beside.gains.as_ref();
    let campaign = Campaign::new(&on_grid, &beside.linear, gains, &uncertainty, Plant::default(), 1);
    let flown = campaign.fly_all(0, 20_000);
    let least =
        |flown: &Flown| flown.room.iter().chain(&flown.input_room).copied().fold(f64::INFINITY, f64::min);
    let any = flown.iter().filter(|flown| flown.as_ref().is_ok_and(|flown| least(flown) < 0.0)).count();
    let found = Proportion::new(any as u64, 20_000);
    // The two counts have relative errors of about 5 % and 3 %.
    assert!(found.part() > 0.8 * asked && found.part() < 1.25 * asked, "{found:?}");
    // The two limits share the chance: each of them alone is exceeded less often.
    for limits in [&|flown: &Flown| flown.room[0], &|flown: &Flown| {
        flown.input_room.iter().copied().fold(f64::INFINITY, f64::min)
    }] as [&dyn Fn(&Flown) -> f64; 2]
    {
        let alone =
            flown.iter().filter(|flown| flown.as_ref().is_ok_and(|flown| limits(flown) < 0.0)).count();
        assert!(alone > 0 && alone < any, "{alone} of {any}");
    }
}

#[test]
fn a_reserve_beyond_the_limit_is_refused_with_its_figure() {
    let (problem, uncertainty) = limited();
    let weights = crate::feedback::RegulatorWeights { attitude: 1e8, rate: 1e8, end: 1.0 };
    let kind = Some(Kind::Tvlqr(Some(weights)).into());
    let kept = [Kept { limits: vec!["torque limit"], at_most: 1e-3, over: Over::Instant }];
    let found = super::plan(&problem, &Settings::default(), kind, &uncertainty, &kept, &mut Silent);
    let told = found.map(|found| found.2).unwrap_err().to_string();
    assert!(told.contains("\"torque limit\" is ") && told.contains("corrections need"), "{told}");
    let kept = [Kept { limits: vec!["nothing"], at_most: 1e-3, over: Over::Instant }];
    let found = super::plan(&problem, &Settings::default(), kind, &uncertainty, &kept, &mut Silent);
    assert!(matches!(found, Err(NotKept::Unknown(_))), "{:?}", found.map(|found| found.2));
}
