//! Flights of the plans of sequences against their linear model.

use slewkit::assured::{Beside, Feedback};
use slewkit::closed_loop::{Campaign, Plant, quantile};
use slewkit::feedback::Kind;
use slewkit::maneuver::{Aim, Direction, Problem, Settings, State};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits, Wheels};
use slewkit::optimize::discrete::linear_plan::{Matrix6, Parameter};
use slewkit::plan::Silent;
use slewkit::sequence::{Ordering, Place, Sequence, Stop, WholeMotion};
use slewkit::uncertainty::Uncertainty;
use slewkit::{Matrix3, Vector3, lie};

/// A body on four wheels, two of which spin at the start.
fn craft() -> Problem {
    let inertia = Matrix3::new(2.2, -0.3, 0.2, -0.3, 1.6, -0.25, 0.2, -0.25, 1.1);
    let body = Body { inertia: Inertia::new(inertia).unwrap(), mass: None };
    let axes = [[0.8, 0.0, 0.6], [0.0, 0.8, 0.6], [-0.8, 0.0, 0.6], [0.0, -0.8, 0.6]];
    let set = ActuatorSet::new(axes.map(Vector3::from).to_vec(), AxisFrame::Body).unwrap();
    let set = set.with_limits(Limits { size: Some(vec![0.4; 4]), ..Limits::default() }).unwrap();
    let wheels = Wheels { momentum: vec![0.3, -0.1, 0.0, 0.0], momentum_limit: vec![2.0; 4] };
    let rest = State::at_rest(Matrix3::identity());
    let mut craft = Problem::minimum_time(body, rest, rest).with_steps(60);
    craft.actuation = Actuation { torque: set, wheels: Some(wheels), ..craft.actuation };
    craft
}

/// An attitude that is held, a moving target that is followed, and an attitude.
fn whole() -> WholeMotion {
    let target = Direction::along(0.0, 300.0, 20.0, 8, |time| {
        lie::exp(&Vector3::new(0.0, 0.02 * time, 0.0)) * Vector3::new(0.6, 0.0, 0.8)
    });
    let stops = vec![
        Stop::at("A", Place::Attitude(lie::exp(&Vector3::new(0.5, 0.2, 0.1)))).held(5.0),
        Stop::at("pass", Place::Aim(Aim::new(Vector3::z(), target.unwrap()))).held(8.0),
        Stop::at("C", Place::Attitude(lie::exp(&Vector3::new(-0.3, 0.6, 0.2)))),
    ];
    let sequence = Sequence { craft: craft(), stops, order: Ordering::Given };
    let plan = sequence.plan(&Settings::default(), &mut Silent).unwrap();
    WholeMotion::of_plan(&sequence, &plan).unwrap()
}

fn beside(whole: &WholeMotion, uncertainty: &Uncertainty) -> Beside {
    let feedback = Feedback::from(Kind::Tvlqr(None)).with_default_weights(whole.weights());
    let stops = whole.stops();
    Beside::along_motion(&whole.problem, &whole.path, stops, Some(feedback), Some(uncertainty)).unwrap()
}

/// Room for corrections above the limits of the plan.
const PLANT: Plant = Plant { lag: 0.0, delay: 0.0, quantum: 0.0, tick: 0.0, leads: false, authority: 2.0 };

/// Without errors the craft flies the plan of the whole: it meets every stop and the end. The motions
/// of legs and holds join to their own accuracy, and gains take up the rest.
#[test]
fn without_errors_every_stop_is_met() {
    let whole = whole();
    let nothing = Uncertainty::default();
    let beside = beside(&whole, &nothing);
    assert_eq!(whole.instants.len(), 5);
    let campaign = Campaign::new(&whole.problem, &beside.linear, beside.gains.as_ref(), &nothing, PLANT, 1);
    let flown = campaign.fly(0).unwrap();
    assert_eq!(flown.stops.len(), 4);
    for error in flown.stops.iter().chain([&flown.end]) {
        assert!(error.amax() < 1e-5, "{error}");
    }
}

/// An error of the start and of the inertia is corrected by the gains: at the stops and at the end it
/// is far smaller than without gains, and as large as linear theory predicts.
#[test]
fn gains_bring_the_craft_to_its_stops() {
    let whole = whole();
    let mut start = Matrix6::zeros();
    start.fill_diagonal(1e-6);
    let heavier = Parameter::Inertia(Matrix3::from_diagonal(&Vector3::new(2.2, 1.6, 1.1)));
    let uncertainty =
        Uncertainty { start, parameters: vec![("inertia".into(), heavier, 0.01)], ..Uncertainty::default() };
    let beside = beside(&whole, &uncertainty);
    let flown = |gains| {
        let campaign = Campaign::new(&whole.problem, &beside.linear, gains, &uncertainty, PLANT, 7);
        campaign.fly_all(0, 200).into_iter().map(Result::unwrap).collect::<Vec<_>>()
    };
    let (closed, open) = (flown(beside.gains.as_ref()), flown(None));
    let covariance = beside.closed.as_ref().unwrap();
    for (index, node) in beside.linear.stops().iter().enumerate() {
        let turn = |cases: &[slewkit::closed_loop::Flown]| {
            let mut turns: Vec<f64> =
                cases.iter().map(|flown| flown.stops[index].fixed_rows::<3>(0).norm()).collect();
            turns.sort_by(f64::total_cmp);
            (quantile(&turns, 0.5), turns.iter().map(|turn| turn * turn).sum::<f64>() / 200.0)
        };
        let ((median, squared), (without, _)) = (turn(&closed), turn(&open));
        assert!(median < 0.2 * without, "{index}: {median:e} {without:e}");
        let predicted = covariance.states[*node].fixed_view::<3, 3>(0, 0).trace();
        let ratio = squared / predicted;
        assert!((0.6..1.6).contains(&ratio), "{index}: {squared:e} {predicted:e}");
    }
}
