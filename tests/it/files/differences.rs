//! The keys in which two specs differ.

use super::made::{problem, with_constraints, with_wheels};
use slewkit::Direction;
use slewkit::maneuver::constraint::{Pointing, Rule, Side};
use slewkit::maneuver::problem::{Motion, Problem, Scheme};
use slewkit::maneuver::settings::Settings;
use slewkit::mechanics::actuators::{Actuation, Limits, Wheels};
use slewkit_files::spec::SpecDocument;

fn differences(one: &Problem, other: &Problem) -> Vec<String> {
    let document = |problem| SpecDocument::new(problem, &Settings::discrete()).unwrap();
    document(one).differences(&document(other)).into_iter().map(|difference| difference.key).collect()
}

#[test]
fn two_specs_tell_the_keys_in_which_they_differ() {
    let one = problem(Motion::Attitude, Scheme::LieVerlet);
    let mut other = one.clone();
    assert_eq!(differences(&one, &other), [""; 0]);
    // Round-off, the name and the grid do not make it another maneuver.
    other.end.attitude[(0, 0)] = 1e-17;
    other.name = "other".into();
    other = other.with_steps(40).with_scheme(Scheme::LieEuler);
    assert_eq!(differences(&one, &other), [""; 0]);
    other.duration = slewkit::Duration::Given(0.4);
    other.end.angular_velocity.x = 1e-9;
    assert_eq!(differences(&one, &other), ["end.angular_velocity_rad_s", "maneuver.duration_s"]);
    let document = |settings| SpecDocument::new(&one, settings).unwrap();
    let looser = Settings { tolerance: 1e-9, ..Settings::discrete() };
    let found = document(&Settings::discrete()).differences(&document(&looser));
    let [found] = &found[..] else { panic!("{found:?}") };
    assert_eq!([&found.key[..], &found.first, &found.second], ["solver.tolerance", "1e-12", "1e-9"]);
}

/// Every limit makes another maneuver, and the record names the key that differs.
#[test]
fn maneuvers_under_other_limits_never_look_the_same() {
    let one = with_constraints(with_wheels(problem(Motion::Attitude, Scheme::LieVerlet)));
    let keys = |change: &dyn Fn(&mut Problem)| {
        let mut other = one.clone();
        change(&mut other);
        differences(&one, &other)
    };
    let limited = |limits: Limits| {
        move |problem: &mut Problem| {
            problem.actuation.torque = problem.actuation.torque.clone().with_limits(limits.clone()).unwrap();
        }
    };
    let size = Some(vec![0.1, 0.2, 0.3, 0.5]);
    let limit_of = |wheel: usize| format!("actuators.wheel.{wheel}.torque_limit_n_m");
    assert_eq!(keys(&limited(Limits { size: size.clone(), ..Limits::default() })), [limit_of(3)]);
    assert_eq!(keys(&limited(Limits::default())), [0, 1, 2, 3].map(limit_of));
    let all = ["torque_limit_n_m", "torque_norm_limit_n_m", "torque_rate_limit_n_m_per_s"];
    let (norm, rate) = (Some(1.0), Some(vec![1.0; 4]));
    let without_wheels = Problem {
        actuation: Actuation::torques(one.actuation.torque.clone().with_limits(Limits::default()).unwrap()),
        ..one.clone()
    };
    let mut other = without_wheels.clone();
    limited(Limits { size, norm, rate, ..Limits::default() })(&mut other);
    assert_eq!(differences(&without_wheels, &other), all.map(|key| format!("actuators.{key}")));
    let wheels = |change: fn(&mut Wheels)| {
        move |problem: &mut Problem| change(problem.actuation.wheels.as_mut().unwrap())
    };
    assert_eq!(keys(&wheels(|wheels| wheels.momentum[1] = 0.1)), ["actuators.wheel.1.momentum_n_m_s"]);
    assert_eq!(
        keys(&wheels(|wheels| wheels.momentum_limit[2] = 9.0)),
        ["actuators.wheel.2.momentum_limit_n_m_s"]
    );
    let axes = ["wheel", "effort_weight", "torque_axes_body", "torque_limit_n_m"];
    assert_eq!(keys(&|problem| problem.actuation.wheels = None), axes.map(|key| format!("actuators.{key}")));
    assert_eq!(keys(&|problem| drop(problem.constraints.pop())), ["constraint"]);
    assert_eq!(keys(&|problem| problem.constraints[2].name = "other".into()), ["constraint.2.name"]);
    let rule = Rule::RateNorm(0.25);
    let limit = "constraint.2.angular_velocity_limit_rad_s";
    assert_eq!(keys(&|problem| problem.constraints[2].rule = rule.clone()), [limit]);
    let cone = |change: fn(&mut Pointing)| {
        move |problem: &mut Problem| match &mut problem.constraints[0].rule {
            Rule::Pointing(pointing) => change(pointing),
            _ => unreachable!(),
        }
    };
    let key = |name: &str| vec![format!("constraint.0.{name}")];
    assert_eq!(keys(&cone(|cone| cone.half_angle += 1e-9)), key("half_angle_rad"));
    assert_eq!(keys(&cone(|cone| cone.half_angle += 1e-15)), Vec::<String>::new());
    assert_eq!(keys(&cone(|cone| cone.margin = 0.0)), key("margin_rad"));
    assert_eq!(keys(&cone(|cone| cone.side = Side::KeepIn)), key("kind"));
    assert_eq!(keys(&cone(|cone| cone.boresights.swap(0, 1))), key("boresight_body"));
    let turning = [key("direction_inertial"), key("direction_reference")].concat();
    assert_eq!(
        keys(&cone(|cone| cone.directions[0] = Direction::InFrame(*cone.directions[0].constant().unwrap()))),
        turning
    );
}
