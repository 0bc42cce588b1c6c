//! The meaning of specs: the problem and the settings that they define.

use super::{BASE, BIASED, CONSTRAINED, ORBIT, WHEELS, bad, good};
use slewkit::maneuver::constraint::{Direction, Rule, Side};
use slewkit::maneuver::problem::{Motion, Path, Scheme};
use slewkit::maneuver::settings::Method;
use slewkit::maneuver::solution::Sense;
use slewkit::mechanics::actuators::{AxisFrame, Limits};
use slewkit::{Matrix3, Vector3, lie};
use slewkit_files::spec::{self, Format, Toleranced};
use std::f64::consts::{FRAC_PI_2, PI};

/// Returns the end attitude of `BASE` with another notation.
fn attitude(notation: &str) -> Matrix3 {
    good(BASE, &[&format!("end.attitude={{ {notation} }}")]).problem.end.attitude
}

fn assert_near(a: &Matrix3, b: &Matrix3, what: &str) {
    assert!((a - b).amax() < 4e-16, "{what}: {a} {b}");
}

/// Returns the codes of the warnings about a good spec.
fn warnings(text: &str, set: &[&str]) -> Vec<&'static str> {
    good(text, set).warnings.iter().map(|warning| warning.code).collect()
}

#[test]
fn template_loads_without_a_word() {
    let loaded = good(spec::template(), &[]);
    assert!(loaded.warnings.is_empty());
    assert_eq!(loaded.problem.steps, 100);
    // The commented keys of the template are valid too, except for reaction wheels and thrusters,
    // which replace torque axes.
    let shown = |wheels: bool| {
        let mut table = "";
        let mut text = String::new();
        for line in spec::template().lines() {
            let bare = line.strip_prefix("# ").unwrap_or(line);
            table = if bare.starts_with('[') { bare.split_once(']').unwrap().0 } else { table };
            let key = bare.split(" = ").next().unwrap();
            let is_key =
                key.starts_with('[') || (key.len() > 3 && !key.contains(' ') && bare.contains(" = "));
            let wanted = match table {
                "[[actuators.wheel" => wheels,
                "[[actuators.thruster" => false,
                "[actuators" => !wheels,
                _ => true,
            };
            let kept = is_key && wanted && key != "rotation_from_start";
            text.push_str(if kept { bare } else { "" });
            text.push('\n');
        }
        good(&text, &[]).problem
    };
    let problem = shown(false);
    assert_eq!((problem.steps, problem.actuation.torque.count()), (200, 2));
    assert_eq!(problem.environment.frame_rate(), Vector3::new(0.0, 0.00116, 0.0));
    let limits = problem.actuation.torque.limits();
    assert_eq!((limits.size.as_deref(), limits.rate.as_deref()), (Some(&[0.5; 2][..]), Some(&[0.1; 2][..])));
    assert_eq!(problem.constraints.len(), 2);
    let error = std::panic::catch_unwind(|| shown(true)).unwrap_err();
    let text = error.downcast_ref::<String>().unwrap();
    assert!(text.contains("rank 1: torque only about (1, 0, 0)"), "{text}");
}

#[test]
fn euler_angles_are_intrinsic_in_all_twelve_sequences() {
    let turn = |letter: char, angle: f64| {
        let (s, c) = angle.sin_cos();
        match letter {
            'x' => Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c),
            'y' => Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c),
            _ => Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0),
        }
    };
    let angles = [0.3, -0.7, 1.9];
    for sequence in ["xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"] {
        let expected = sequence
            .chars()
            .zip(angles)
            .fold(Matrix3::identity(), |product, (letter, angle)| product * turn(letter, angle));
        let read = attitude(&format!("euler_{sequence}_rad = [0.3, -0.7, 1.9]"));
        assert_near(&read, &expected, sequence);
        let degrees = angles.map(f64::to_degrees);
        let read = attitude(&format!("euler_{sequence}_deg = {degrees:?}"));
        assert!((read - expected).amax() < 1e-15, "{sequence}");
    }
}

#[test]
fn all_notations_say_the_same_quarter_turn() {
    let expected = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let half = 0.5_f64.sqrt();
    for notation in [
        "axis = [0, 0, 1], angle_deg = 90".to_string(),
        "axis = [0, 0, -1e-20], angle_deg = -90".into(),
        format!("axis = [0, 0, 3e25], angle_rad = {FRAC_PI_2}"),
        format!("rotation_vector_rad = [0, 0, {FRAC_PI_2}]"),
        "rotation_vector_deg = [0, 0, 90]".into(),
        "matrix = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]".into(),
        "matrix = [[1e-9, -1, 0], [1, 0, 0], [0, 0, 1]]".into(),
        format!("quaternion_wxyz = [{half}, 0, 0, {half}]"),
        format!("quaternion_xyzw = [0, 0, -{half}, -{half}]"),
        "euler_zyx_deg = [90, 0, 0]".into(),
    ] {
        assert!((attitude(&notation) - expected).amax() < 1e-9, "{notation}");
    }
}

#[test]
fn rotation_from_start_turns_about_body_axes_of_the_start() {
    let start = "start.attitude={ axis = [1, 0, 0], angle_deg = 90 }";
    let text = BASE.replace(
        "attitude = { euler_zyx_deg = [80, -25, 40] }",
        "rotation_from_start = { axis = [0, 0, 2], angle_deg = 480 }",
    );
    let problem = good(&text, &[start]).problem;
    let written = Vector3::new(0.0, 0.0, 480_f64.to_radians());
    assert_eq!(problem.path, Path::AsGiven(written));
    let expected = lie::exp(&Vector3::new(FRAC_PI_2, 0.0, 0.0)) * lie::exp(&written);
    assert_near(&problem.end.attitude, &expected, "end");
    for (path, expected) in [("best", Path::Best), ("shortest", Path::Shortest), ("long", Path::Long)] {
        assert_eq!(good(&text, &[start, &format!("maneuver.path={path}")]).problem.path, expected);
    }
}

#[test]
fn one_euler_angle_turns_as_far_as_written_and_a_quaternion_the_short_way() {
    let text = BASE.replace(
        "attitude = { euler_zyx_deg = [80, -25, 40] }",
        "rotation_from_start = { euler_zyx_deg = [0, -400, 0] }",
    );
    let turned = |notation: &str| match good(&text, &[&format!("end.rotation_from_start={{ {notation} }}")])
        .problem
        .path
    {
        Path::AsGiven(vector) => vector,
        path => panic!("{path:?}"),
    };
    assert_eq!(turned("euler_zyx_deg = [0, -400, 0]"), Vector3::new(0.0, (-400_f64).to_radians(), 0.0));
    let half = 0.5_f64.sqrt();
    let vector = turned(&format!("quaternion_wxyz = [-{half}, {half}, 0, 0]"));
    assert!((vector - Vector3::new(-FRAC_PI_2, 0.0, 0.0)).amax() < 1e-15, "{vector}");
    assert_eq!(turned("matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"), Vector3::zeros());
}

#[test]
fn every_key_of_an_orbit_spec_arrives() {
    let loaded = good(ORBIT, &[]);
    let (problem, settings, expect) = (&loaded.problem, &loaded.settings, loaded.expect.unwrap());
    assert_eq!(problem.name, "test");
    assert_eq!(problem.motion, Motion::RigidBody);
    assert_eq!(problem.body.mass, Some(2.0));
    assert_eq!(*problem.body.inertia.j(), Matrix3::from_diagonal(&Vector3::new(2.0, 3.0, 4.0)));
    assert_eq!((problem.start.position, problem.end.position), (Vector3::x() * 100.0, Vector3::y() * 100.0));
    assert_eq!((problem.start.velocity, problem.end.velocity), (Vector3::y() * 0.1, Vector3::x() * -0.1));
    assert_eq!(problem.start.angular_velocity, Vector3::zeros());
    assert_eq!(problem.end.angular_velocity, Vector3::z() * 0.01);
    assert_eq!((problem.seconds(), problem.steps, problem.scheme), (60.0, 120, Scheme::LieEuler));
    assert_eq!(problem.path, Path::AsGiven(Vector3::z() * 7.0));
    let torque = &problem.actuation.torque;
    assert_eq!(
        (torque.frame(), torque.axes()),
        (AxisFrame::Reference, &[Vector3::x(), Vector3::y() * 2.0][..])
    );
    let weights = problem.objective.weights();
    assert_eq!(weights.torque.as_ref().unwrap().as_slice(), [2.0, 0.5, 0.5, 1.0]);
    let force = problem.actuation.force.as_ref().unwrap();
    assert_eq!(
        (force.frame(), force.axes(), weights.force.as_ref().unwrap()[(0, 0)]),
        (AxisFrame::Body, &[Vector3::z()][..], 3.0)
    );
    assert!(!problem.environment.is_free());
    assert_eq!((settings.method, settings.tolerance, settings.max_iterations), (Method::Shooting, 1e-10, 30));
    assert_eq!(settings.search, slewkit::maneuver::Thoroughness::Thorough);
    assert!(!settings.test_second_order);
    assert_eq!(settings.continuous_tolerance, Some(0.5_f64.to_radians()));
    assert_eq!(settings.time_limit.unwrap().as_secs_f64(), 2.5);
    assert_eq!((expect.source.as_deref(), expect.status.as_str()), (Some("nowhere"), "solved"));
    assert_eq!(expect.cost, Some(Toleranced { value: 1.5, tolerance: 0.01 }));
    assert_eq!((expect.terminal_error, expect.newton_iterations_at_most), (Some(1e-12), Some(20)));
    assert_eq!((expect.conjugate_points, expect.sense), (Some(0), Some(Sense::Long)));
    assert_eq!(expect.rivals, [Toleranced { value: 71.4, tolerance: 0.1 }]);
}

#[test]
fn every_limit_and_constraint_arrives_in_si_units() {
    let loaded = good(CONSTRAINED, &[]);
    let problem = &loaded.problem;
    assert_eq!(loaded.settings.method, Method::Scp);
    let (size, rate) = (Some(vec![0.5, 0.25]), Some(vec![0.1, 0.1]));
    assert_eq!(
        *problem.actuation.torque.limits(),
        Limits { size, norm: Some(0.6), rate, ..Limits::default() }
    );
    let names: Vec<&str> = problem.constraints.iter().map(|constraint| constraint.name.as_str()).collect();
    assert_eq!(names, ["star tracker away from the Sun", "keep-in cone", "rate limit", "rate limit 2"]);

    let Rule::Pointing(out) = &problem.constraints[0].rule else { panic!() };
    assert_eq!((out.side, &out.boresights[..]), (Side::KeepOut, &[Vector3::z()][..]));
    assert_eq!((out.half_angle, out.margin), (35_f64.to_radians(), 0.5_f64.to_radians()));
    let (ra, dec) = (231_f64.to_radians(), -(18.3_f64.to_radians()));
    let sun = Vector3::new(dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin());
    assert!(matches!(out.directions[0], Direction::Fixed(vector) if (vector - sun).amax() < 1e-15));

    let Rule::Pointing(within) = &problem.constraints[1].rule else { panic!() };
    assert_eq!((within.side, within.margin), (Side::KeepIn, 0.0));
    assert_eq!((within.boresights.len(), within.boresights[0]), (2, Vector3::z()));
    assert!((within.boresights[1] - Vector3::new(0.6, 0.0, 0.8)).amax() < 1e-15);
    let (half, s, c) = (0.5_f64.sqrt(), 60_f64.to_radians().sin(), 60_f64.to_radians().cos());
    let expected =
        [(Vector3::z(), false), (Vector3::new(0.0, -c, s), false), (Vector3::new(half, 0.0, half), true)];
    assert_eq!(within.directions.len(), 3);
    for (direction, (wanted, turning)) in within.directions.iter().zip(expected) {
        let vector = direction.constant().unwrap();
        let turns = matches!(direction, Direction::InFrame(_));
        assert!((vector - wanted).amax() < 1e-15 && turns == turning, "{vector} {wanted}");
    }
    assert_eq!(problem.constraints[2].rule, Rule::RateNorm(4_f64.to_radians()));
    assert_eq!(problem.constraints[3].rule, Rule::RateAxes(Vector3::new(0.1, 0.2, 0.3)));

    let expect = loaded.expect.unwrap();
    assert_eq!((expect.margin_at_least, expect.because.as_deref()), (Some(-1e-9), Some("shortest")));
    assert_eq!(expect.active.unwrap(), ["torque limit", "rate limit 2"]);
}

#[test]
fn wheels_become_torque_inputs_with_momenta() {
    let problem = good(WHEELS, &[]).problem;
    let (actuation, weights) = (problem.actuation, problem.objective.weights().clone());
    let torque = &actuation.torque;
    assert_eq!((torque.frame(), torque.count()), (AxisFrame::Body, 4));
    assert!((torque.axes()[2] - Vector3::new(-0.8, 0.0, 0.6)).amax() < 1e-15);
    assert_eq!(torque.limits().size.as_deref(), Some(&[0.2, 0.3, 0.2, 0.2][..]));
    assert_eq!(weights.torque.unwrap().diagonal().as_slice(), [1.0, 2.0, 1.0, 1.0]);
    let wheels = actuation.wheels.unwrap();
    assert_eq!(wheels.momentum, [20.0, 0.0, -1.5, 0.0]);
    assert_eq!(wheels.momentum_limit, [20.0, f64::INFINITY, f64::INFINITY, 10.0]);
    // Three of them, without torque limits.
    let bare = good(
        WHEELS,
        &[
            "actuators.wheel=[{ axis_body = [1, 0, 0] }, { axis_body = [0, 1, 0] }, { axis_body = [0, 0, 1] }]",
        ],
    );
    assert!(bare.warnings.is_empty() && bare.problem.actuation.torque.limits().is_none());
    // Axes rounded to four digits are as meant; with three, torque and momentum are not to four
    // digits those meant.
    for (part, expected) in [("0.5774", 0), ("0.7071", 3), ("0.577", 3)] {
        let axes = ["1, 1", "1, -1", "-1, 1"].map(|signs| {
            let signs: Vec<_> = signs.split(", ").map(|sign| sign.replace('1', part)).collect();
            format!("{{ axis_body = [{part}, {}, {}] }}", signs[0], signs[1])
        });
        let set = format!("actuators.wheel=[{}]", axes.join(", "));
        let found = warnings(WHEELS, &[&set]);
        assert_eq!(found.iter().filter(|code| **code == "W0062").count(), expected, "{set}: {found:?}");
    }
}

#[test]
fn limits_of_forces_arrive_and_boundary_values_on_a_limit_are_accepted() {
    let set = [
        "solver.method=scp",
        "actuators.force_limit_n=3",
        "actuators.force_norm_limit_n=2.5",
        "actuators.force_rate_limit_n_per_s=[0.5]",
    ];
    let problem = good(ORBIT, &set).problem;
    let expected =
        Limits { size: Some(vec![3.0]), norm: Some(2.5), rate: Some(vec![0.5]), ..Limits::default() };
    assert_eq!(*problem.actuation.force.unwrap().limits(), expected);
    assert!(problem.actuation.torque.limits().is_none());
    let rate = "constraint=[{ kind = \"rate_limit\", angular_velocity_limit_deg_s = 2 }]";
    good(BASE, &[rate, "start.angular_velocity_deg_s=[0, 1.2, -1.6]"]);
    let cone = "constraint=[{ kind = \"keep_out\", boresight_body = [1, 0, 0], direction_inertial = { vector \
        = [0, 0, 1] }, half_angle_deg = 90 }]";
    // The end is 65° from z: inside.
    assert_eq!(bad(BASE, &[cone]).0.len(), 1);
    good(BASE, &[cone, "end.attitude={ axis = [0, 0, 1], angle_deg = 90 }"]);
}

#[test]
fn what_is_left_out_has_defaults() {
    let text = BASE.replace("angular_velocity_deg_s = [0, 0, 0]\n", "").replace("steps = 200", "");
    let loaded = good(&text, &[]);
    let problem = &loaded.problem;
    assert_eq!(
        (problem.start.angular_velocity, problem.end.angular_velocity),
        (Vector3::zeros(), Vector3::zeros())
    );
    assert_eq!((problem.steps, problem.scheme, problem.path), (100, Scheme::LieVerlet, Path::Best));
    assert!(problem.environment.is_free() && loaded.expect.is_none());
    assert_eq!((problem.actuation.torque.count(), problem.actuation.force.is_none()), (3, true));
    assert!(!problem.is_constrained());
    let orbit = ORBIT.replace("force_axes_body = [[0, 0, 1]]\nforce_effort_weight = [3]", "");
    let force = good(&orbit, &[]).problem.actuation.force.unwrap();
    assert_eq!((force.frame(), force.count()), (AxisFrame::Reference, 3));
    assert!(good(&orbit, &["actuators.force_axes_body=[]"]).problem.actuation.force.is_none());
}

#[test]
fn environments_are_built_from_their_keys() {
    let pendulum = "environment={ kind = \"uniform_gravity\", mass_kg = 2, gravity_m_s2 = 9, \
        direction = [0, 0, 5], pivot_to_mass_center_m = [0.5, 0, 0] }";
    let environment = good(BASE, &[pendulum]).problem.environment;
    let pose =
        slewkit::mechanics::environment::Pose { position: Vector3::zeros(), attitude: Matrix3::identity() };
    // m g ρ × e₃ = 18 · (0.5, 0, 0) × (0, 0, 1)
    assert_eq!(environment.wrench(&pose).moment, Vector3::new(0.0, -9.0, 0.0));
    let orbit = r#"environment={ kind = "gravity_gradient", orbital_rate_rad_s = 0.5 }"#;
    assert_eq!(good(BASE, &[orbit]).problem.environment.frame_rate(), Vector3::y() * 0.5);
    let moon = good(
        ORBIT,
        &[
            "environment={ kind = \"central_gravity\", gravitational_parameter_m3_s2 = 5, body = \"second_order\" }",
        ],
    );
    let pose = slewkit::mechanics::environment::Pose {
        position: Vector3::x() * 10.0,
        attitude: Matrix3::identity(),
    };
    let force = moon.problem.environment.wrench(&pose).force;
    assert!((force.x + 0.1).abs() < 0.01 && force.y.abs() < 1e-15, "{force}");
}

#[test]
fn default_steps_follow_the_formula() {
    assert_eq!(spec::default_steps(PI, 0.0, 60.0), 100.0);
    assert_eq!(spec::default_steps(30.0, 0.0, 60.0), 150.0);
    assert_eq!(spec::default_steps(0.0, 1.0, 60.0), 200.0);
    let fast = good(&BASE.replace("steps = 200", ""), &["start.angular_velocity_deg_s=[0, 0, 180]"]).problem;
    assert!(fast.steps > 600 && fast.step() * PI < 0.3, "{}", fast.steps);
    // 20 N·m·s about y: h/√(120 kg·m² 80 kg·m²).
    let biased = spec::from_str(BIASED, "biased", Format::Toml, &[]).unwrap().problem;
    let nutation = 20.0 / 9600.0_f64.sqrt();
    let turned = 1.5 * (2.0 * PI - PI / 3.0);
    assert_eq!(biased.steps as f64, ((turned + 200.0 * nutation) / 0.3).ceil());
    let errors = bad(&BASE.replace("steps = 200", ""), &["start.angular_velocity_deg_s=[0, 0, 1e9]"]);
    assert_eq!(errors.0[0].code, "E0034");
}

#[test]
fn step_that_divides_is_silent_and_a_whole_float_is_a_count() {
    let text = BASE.replace("steps = 200", "step_s = 0.1");
    assert!(warnings(&text, &[]).is_empty());
    assert_eq!(good(&text, &[]).problem.steps, 600);
    assert_eq!(good(BASE, &["maneuver.steps=1e3"]).problem.steps, 1000);
    assert_eq!(good(BASE, &["maneuver.steps=0x10"]).problem.steps, 16);
}

#[test]
fn overrides_replace_add_and_reach_into_lists() {
    let set = [
        "maneuver.steps=50",
        "solver.scheme=lie_euler",
        "name=another name",
        "end.attitude.euler_zyx_deg.0=10",
    ];
    let problem = good(BASE, &set).problem;
    assert_eq!(
        (problem.steps, problem.scheme, problem.name.as_str()),
        (50, Scheme::LieEuler, "another name")
    );
    assert_near(&problem.end.attitude, &attitude("euler_zyx_deg = [10, -25, 40]"), "element");
    assert!(spec::Override::parse("steps").is_err());
    assert!(spec::Override::parse("a..b=1").is_err());
    assert!(spec::Override::parse("=1").is_err());
}

#[test]
fn json_says_the_same_as_toml() {
    let text = r#"{ "format": 1, "name": "base",
        "body": { "inertia_kg_m2": [[2, 0.1, 0], [0.1, 3, 0], [0, 0, 4]] },
        "start": { "attitude": { "axis": [0, 0, 1], "angle_deg": 0 } },
        "end": { "attitude": { "euler_zyx_deg": [80, -25, 40] } },
        "maneuver": { "duration_s": 6e1, "steps": 200 } }"#;
    let json = spec::from_str(text, "x.json", Format::Json, &[]).unwrap().problem;
    assert_eq!(format!("{json:?}"), format!("{:?}", good(BASE, &[]).problem));
}

#[test]
fn ordinary_specs_give_no_warnings() {
    assert!(warnings(BASE, &[]).is_empty());
    assert!(warnings(ORBIT, &["environment.gravitational_parameter_m3_s2=1"]).is_empty());
    for angle in [1.0, 5.0, 30.0, 57.3, 90.0, 180.0, 0.1] {
        let set = format!("end.attitude={{ axis = [0, 1, 0], angle_deg = {angle} }}");
        assert!(warnings(BASE, &[&set]).is_empty(), "{angle}");
    }
}

#[test]
fn largest_and_smallest_numbers_make_a_finite_problem() {
    for (inertia, weight, axis, duration) in [
        ("1e30", "1e30", "1e30", "1e12"),
        ("1e-30", "1e-30", "1e-30", "1e-9"),
        ("1e-30", "1e30", "1e-30", "1e12"),
    ] {
        let set = [
            format!("body.inertia_kg_m2=[{inertia}, {inertia}, {inertia}]"),
            format!("actuators.effort_weight=[{weight}, {weight}, {weight}]"),
            format!("actuators.torque_axes_body=[[{axis}, 0, 0], [0, {axis}, 0], [0, 0, {axis}]]"),
            format!("maneuver.duration_s={duration}"),
        ];
        let problem = good(BASE, &set.each_ref().map(String::as_str)).problem;
        let weights = problem.objective.weights();
        let authority = weights.torque(&problem.actuation).authority;
        let cost = problem.body.inertia.j() * authority.try_inverse().unwrap() * problem.body.inertia.j();
        let cost = cost / problem.seconds().powi(3);
        assert!(cost.iter().all(|value| value.is_finite()) && cost.amax() > 0.0, "{cost}");
    }
}

#[test]
fn an_end_with_a_rate_alone_leaves_the_attitude_open() {
    let text = "format = 1\nbody.inertia_kg_m2 = [1, 2, 2.5]\nstart.attitude = { axis = [0, 0, 1], angle_deg = 30 }\n\
                start.angular_velocity_deg_s = [3, 2, 1]\nend.angular_velocity_deg_s = [0, 0, 1]\n\
                maneuver.duration_s = 20\n";
    let problem = good(text, &[]).problem;
    assert!(problem.ends_in_any_attitude());
    assert!((problem.end.angular_velocity - Vector3::new(0.0, 0.0, 1f64.to_radians())).amax() < 1e-16);
    for (set, why) in [
        ("maneuver.path=\"long\"", "has no homotopy class"),
        ("end.rotation_from_start_rad=[1, 0, 0]", "needs an attitude, and [end] has none"),
        ("solver.method=\"shooting\"", "leaves the attitude at the end open"),
    ] {
        let told = bad(text, &[set]).to_string();
        assert!(told.contains(why), "{set}: {told}");
    }
    // An empty end is still a mistake.
    let nothing = text.replace("end.angular_velocity_deg_s = [0, 0, 1]\n", "end = {}\n");
    let told = bad(&nothing, &[]).to_string();
    assert!(told.contains("E0021") && told.contains("[end] needs"), "{told}");
}
