//! A written maneuver reads back as an equal maneuver, bit for bit.

use super::{BASE, CONSTRAINED, ORBIT, WHEELS, bad, good};
use evidence::random_specs::random_spec;
use slewkit::Vector3;
use slewkit::maneuver::constraint::Rule;
use slewkit::maneuver::problem::Path;
use slewkit::mechanics::actuators::Limits;
use slewkit::mechanics::environment::{CentralGravity, GravityGradient, PointMass};
use slewkit_files::spec::{self, Format, Loaded, Spec, SpecDocument};

/// Spec → maneuver → spec → maneuver: the debug form shows every number of the maneuver to its last
/// bit.
fn comes_back(loaded: &Loaded, name: &str) -> SpecDocument {
    let document = SpecDocument::new(&loaded.problem, &loaded.settings).unwrap();
    let text = document.to_string();
    let again = spec::from_str(&text, "again.json", Format::Json, &[])
        .unwrap_or_else(|errors| panic!("{name}: {errors}\n{text}"));
    assert_eq!(format!("{:#?}", again.problem), format!("{:#?}", loaded.problem), "{name}");
    assert_eq!(again.settings, loaded.settings, "{name}");
    let second = SpecDocument::new(&again.problem, &again.settings).unwrap();
    assert_eq!(second.to_string(), text, "{name}");
    assert_eq!(document.differences(&second), [], "{name}");
    document
}

#[test]
fn every_maneuver_of_the_collection_comes_back_bit_for_bit() {
    let mut count = 0;
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        if let Ok(Spec::Maneuver(loaded)) = spec::load(&path, Format::Toml, &[]) {
            comes_back(&loaded, &path.display().to_string());
            count += 1;
        }
    }
    assert!(count > 40, "{count}");
}

#[test]
fn random_maneuvers_of_every_kind_come_back_bit_for_bit() {
    for index in 0..1040 {
        let random = random_spec(index);
        comes_back(&good(&random.text, &[]), &format!("{} {index}", random.kind));
    }
}

#[test]
fn random_maneuvers_of_minimum_time_come_back_bit_for_bit() {
    let mut count = 0;
    for index in 0..1040 {
        let text = random_spec(index).text;
        let given = |line: &&str| {
            let given = ["duration_s", "step_s", "minimize", "method", "scheme", "effort_weight"];
            !given.iter().any(|key| line.starts_with(key))
        };
        let lines: Vec<&str> = text.lines().filter(given).collect();
        let text = lines.join("\n").replace("[maneuver]", "[maneuver]\nminimize = \"time\"");
        // Most have something that minimum time does not take.
        if let Ok(loaded) = spec::from_str(&text, "random.toml", Format::Toml, &[]) {
            assert!(loaded.problem.seeks_duration() && loaded.problem.duration.known().is_none());
            comes_back(&loaded, &format!("minimum time {index}"));
            count += 1;
        }
    }
    assert!(count > 30, "{count}");
}

#[test]
fn random_maneuvers_of_least_fuel_come_back_bit_for_bit() {
    let mut count = 0;
    for index in 0..1040 {
        let text = random_spec(index).text;
        let given = |line: &&str| {
            !["minimize", "method", "scheme", "effort_weight"].iter().any(|key| line.starts_with(key))
        };
        let lines: Vec<&str> = text.lines().filter(given).collect();
        let text = lines.join("\n").replace("[maneuver]", "[maneuver]\nminimize = \"fuel\"");
        let text = text.replace("[actuators]", "[actuators]\nfuel_price = 0.7");
        if let Ok(loaded) = spec::from_str(&text, "random.toml", Format::Toml, &[]) {
            assert!(loaded.problem.objective.fuel().is_some());
            comes_back(&loaded, &format!("fuel {index}"));
            count += 1;
        }
    }
    assert!(count > 30, "{count}");
}

#[test]
fn every_notation_comes_back_bit_for_bit() {
    for text in [BASE, ORBIT, CONSTRAINED, WHEELS] {
        comes_back(&good(text, &[]), text);
    }
    comes_back(&good(WHEELS, &["actuators.torque_rate_limit_n_m_per_s=0.7"]), "wheels");
    let turns = [
        "{ axis = [0.3, -2, 1], angle_deg = 480.1 }",
        "{ quaternion_xyzw = [0.1, -0.2, 0.3, 0.927361849549570] }",
        "{ euler_zxz_deg = [200, 31, -77] }",
        "{ euler_zyx_deg = [0, -400, 0] }",
        "{ rotation_vector_deg = [1e-9, 0, 700] }",
        "{ matrix = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]] }",
    ];
    let relative = BASE.replace("attitude = { euler_zyx_deg = [80, -25, 40] }", "rotation_from_start = {}");
    for path in ["best", "shortest", "long", "as_given"] {
        for turn in turns {
            let set = ["maneuver.path=", "start.attitude=", "end.rotation_from_start="];
            let set = [0, 1, 2].map(|index| format!("{}{}", set[index], [path, turn, turn][index]));
            comes_back(&good(&relative, &set.each_ref().map(String::as_str)), &format!("{path} {turn}"));
        }
    }
    let others = [
        "solver.continuous_tolerance_deg=0.013",
        "solver.time_limit_s=0.1",
        "end.angular_velocity_deg_s=[1.1, -0.0, 1e-20]",
        "environment={ kind = \"uniform_gravity\", mass_kg = 1.3, gravity_m_s2 = 9.81, direction = [0.1, 2, \
            -0.7], pivot_to_mass_center_m = [0, 0.1, 0.3] }",
        "environment={ kind = \"gravity_gradient\", orbital_rate_rad_s = 0.00116 }",
    ];
    for other in others {
        comes_back(&good(BASE, &[other]), other);
    }
    let orbit =
        ORBIT.replace("force_axes_body = [[0, 0, 1]]\nforce_effort_weight = [3]", "force_axes_body = []");
    comes_back(&good(&orbit, &[]), "no forces");
}

#[test]
fn an_attitude_may_say_which_rotation_leads_there() {
    let set = |turn: &str| {
        [
            format!("end.rotation_from_start_rad={turn}"),
            "end.attitude={ axis = [0, 0, 1], angle_deg = 90 }".into(),
        ]
    };
    let load = |turn: &str| good(BASE, &set(turn).each_ref().map(String::as_str)).problem;
    let turn = Vector3::new(0.0, 0.0, 2.5 * std::f64::consts::PI);
    assert_eq!(load("[0, 0, 7.853981633974483]").path, Path::AsGiven(turn));
    let errors = bad(BASE, &set("[0, 0, 7.85]").each_ref().map(String::as_str));
    assert_eq!(errors.0[0].code, "E0058");
    assert!(errors.to_string().contains("leads 0.003982 rad past the attitude"), "{errors}");
    let both = [
        "end.rotation_from_start_rad=[0, 0, 1]",
        "end.rotation_from_start={ axis = [0, 0, 1], angle_rad = 1 }",
    ];
    assert_eq!(
        bad(&BASE.replace("attitude = { euler_zyx_deg = [80, -25, 40] }", ""), &both).0[0].code,
        "E0028"
    );
}

#[test]
fn angles_are_read_in_radians_too() {
    let limit = |text: &str| good(text, &[]).problem.constraints[0].rule.clone();
    let radians = CONSTRAINED
        .replace("half_angle_deg = 35\nmargin_deg = 0.5", "half_angle_rad = 0.6\nmargin_rad = 0.01");
    let Rule::Pointing(pointing) = limit(&radians) else { panic!() };
    assert_eq!((pointing.half_angle, pointing.margin), (0.6, 0.01));
    let wide = radians.replace("margin_rad = 0.01", "margin_rad = 2.6");
    let told =
        "a cone of 0.6 rad with a margin of 2.6 rad leaves no direction: their sum must be below π rad";
    assert_eq!(bad(&wide, &[]).0[0].reason, told);
    let degrees = good(BASE, &["solver.continuous_tolerance_rad=0.001"]).settings.continuous_tolerance;
    assert_eq!(degrees, Some(0.001));
}

/// A problem that a caller of the library can plan and no spec can express is refused, not written
/// otherwise.
#[test]
fn what_has_no_notation_is_not_written() {
    let told = |loaded: Loaded| SpecDocument::new(&loaded.problem, &loaded.settings).unwrap_err().to_string();
    let orbit = || good(ORBIT, &[]);
    let mut loaded = orbit();
    let point = PointMass { parameter: 1.0, position: Vector3::zeros() };
    loaded.problem = loaded.problem.with_environment(CentralGravity::new(vec![point]).unwrap());
    assert_eq!(told(loaded), "a spec has no notation for a custom environment");
    let mut loaded = orbit();
    let gradient = GravityGradient::new(0.001, &loaded.problem.body.inertia).unwrap();
    loaded.problem = loaded.problem.with_environment(gradient);
    assert!(told(loaded).ends_with("an environment that does not fit the motion of the body"));
    let mut loaded = good(BASE, &[]);
    let other = good(WHEELS, &[]).problem.body.inertia;
    loaded.problem = loaded.problem.with_environment(GravityGradient::new(0.001, &other).unwrap());
    assert!(told(loaded).contains("for another inertia"));
    let mut loaded = good(WHEELS, &[]);
    let torque = &mut loaded.problem.actuation.torque;
    *torque = torque.clone().with_limits(Limits { norm: Some(1.0), ..Limits::default() }).unwrap();
    assert!(told(loaded).contains("wheels"));
}
