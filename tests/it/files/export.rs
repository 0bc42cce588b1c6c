//! Every plan and trajectory that the library writes is read back, bit for bit.

use super::made::*;
use slewkit::maneuver::problem::{Motion, Scheme};
use slewkit::maneuver::settings::Settings;
use slewkit::maneuver::solution::Trajectory;
use slewkit::plan::Guess;
use slewkit_files::export::{ExportError, PlanFile, TrajectoryDocument, read_guess, write_csv, write_jsonl};
use slewkit_files::identity::Identity;
use std::borrow::Cow;

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Compares the bits, because floats treat −0 and 0 as equal.
fn assert_same_bits(a: &Trajectory, b: &Trajectory) {
    assert_eq!(a, b);
    let momenta = (&a.wheel_momentum, &b.wheel_momentum);
    for (a, b) in [(&a.time, &b.time), (&a.input, &b.input), (&a.costates, &b.costates), momenta] {
        assert_eq!(bits(a), bits(b));
    }
    assert_eq!(bits(a.quaternion.as_flattened()), bits(b.quaternion.as_flattened()));
    for (a, b) in [
        (&a.angular_velocity, &b.angular_velocity),
        (&a.torque, &b.torque),
        (&a.position, &b.position),
        (&a.velocity, &b.velocity),
        (&a.force, &b.force),
    ] {
        for (a, b) in a.iter().zip(b) {
            assert_eq!(bits(a.as_slice()), bits(b.as_slice()));
        }
    }
}

#[test]
fn plan_file_reads_back_bit_for_bit() {
    for problem in kinds() {
        let plan = plan(&problem);
        let file = PlanFile::new(&problem, &Settings::default(), &plan);
        let mut first = Vec::new();
        file.write(&mut first).unwrap();
        let back = PlanFile::read(first.as_slice()).unwrap();
        assert_eq!(file, back);
        assert_same_bits(&back.trajectory.0, &plan.solution.trajectory);
        let mut second = Vec::new();
        back.write(&mut second).unwrap();
        assert_eq!(String::from_utf8(first).unwrap(), String::from_utf8(second).unwrap());
        assert_eq!(back.method, if problem.is_constrained() { "scp" } else { "shooting" });
        assert_eq!(back.active, plan.solution.active);
        assert_eq!(
            back.convex.as_ref().map(|work| work.cone_iterations),
            problem.is_constrained().then_some(50)
        );
        back.on_grid(&problem).unwrap().check().unwrap();
        let held = back.spec.unwrap().read("plan.json", &[]).unwrap();
        assert_eq!(format!("{:?}", held.problem), format!("{problem:?}"));
        assert_eq!(held.settings, Settings::default());
    }
}

#[test]
fn plan_file_has_the_keys_of_the_contract() {
    let problem = problem(Motion::RigidBody, Scheme::LieVerlet);
    let plan = plan(&problem);
    let mut text = Vec::new();
    PlanFile::new(&problem, &Settings::default(), &plan).write(&mut text).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
    for key in [
        "/status",
        "/exit_code",
        "/name",
        "/method",
        "/scheme",
        "/steps",
        "/step_s",
        "/cost",
        "/duration_s",
        "/iterations",
        "/solve_time_s",
        "/terminal/attitude_rad",
        "/terminal/momentum_relative",
        "/optimality/stationarity",
        "/optimality/conjugate_points",
        "/optimality/rank",
        "/optimality/condition",
        "/verified/discrete_attitude_rad",
        "/verified/continuous_attitude_rad",
        "/verified/continuous_rate_rad_s",
        "/verified/order",
        "/verified/checks/0/passed",
        "/ladder/0/rung",
        "/ladder/0/outcome",
        "/ladder/0/iterations",
        "/rivals/0/sense",
        "/rivals/0/cost",
        "/costates_0/11",
        "/spec/body/inertia_kg_m2/2",
        "/spec/end/attitude/matrix/1/0",
        "/spec/solver/tolerance",
        "/trajectory/time_s/4",
        "/trajectory/quaternion_wxyz/4/3",
        "/trajectory/angular_velocity_rad_s/4/2",
        "/trajectory/input/4/5",
        "/trajectory/torque_n_m/4/2",
        "/trajectory/costates/4/11",
        "/trajectory/position_m/4/2",
        "/trajectory/velocity_m_s/4/2",
        "/trajectory/force_n/4/2",
    ] {
        assert!(json.pointer(key).is_some(), "{key} is missing");
    }
    assert_eq!(json["status"], "solved");
    assert_eq!(json["exit_code"], 0);
    assert_eq!(json["rivals"][0]["sense"], "long");
    // Not transposed: R maps body x to reference y.
    assert_eq!(
        json["spec"]["end"]["attitude"]["matrix"],
        serde_json::json!([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    );
}

#[test]
fn a_file_has_its_outer_keys_on_lines_of_their_own() {
    let problem = problem(Motion::Attitude, Scheme::LieVerlet);
    let plan = plan(&problem);
    let mut text = Vec::new();
    PlanFile::new(&problem, &Settings::default(), &plan).write(&mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.starts_with("{\n  \"format\": 2,\n"), "{}", &text[..60]);
    assert!(text.contains("\n    \"time_s\": [0.0,"));
    assert_eq!(text.lines().filter(|line| line.contains("solve_time_s")).count(), 1);
    assert!(text.ends_with("}\n"));
}

#[test]
fn guess_is_read_from_a_plan_file() {
    let problem = problem(Motion::Attitude, Scheme::LieVerlet);
    let plan = plan(&problem);
    let mut text = Vec::new();
    PlanFile::new(&problem, &Settings::default(), &plan).write(&mut text).unwrap();
    let guess = read_guess(text.as_slice()).unwrap();
    assert_eq!(bits(&guess.costates), bits(&plan.solution.trajectory.costates[..6]));
    assert_eq!(guess, Guess::of(&plan.solution, &problem));
    let alone = read_guess(&b"{\"format\": 1, \"costates_0\": [1.5]}"[..]).unwrap();
    assert_eq!(alone, Guess::costates(&[1.5]));
    assert!(matches!(read_guess(&b"{\"cost\": 1}"[..]), Err(ExportError::Json(_))));
    let read = |text: &str| read_guess(text.as_bytes());
    assert!(matches!(read("{\"format\": 1, \"costates_0\": [1e999]}"), Err(ExportError::Json(_))));
    assert!(matches!(read("{\"format\": 3, \"costates_0\": []}"), Err(ExportError::Format { found: 3 })));
}

#[test]
fn numbers_that_are_not_finite_read_back_as_nan_outside_the_trajectory() {
    let problem = problem(Motion::Attitude, Scheme::LieVerlet);
    let mut plan = plan(&problem);
    plan.solution.cost = f64::NAN;
    plan.solution.turned_deg = f64::NAN;
    plan.solution.optimality.condition = f64::INFINITY;
    plan.solution.ladder[0].residuals[1] = f64::NAN;
    plan.solution.terminal.attitude_rad = f64::NAN;
    plan.solution.optimality.conjugate_points = None;
    if let Some(verification) = &mut plan.verification {
        verification.continuous_rate_rad_s = f64::NAN;
        verification.order = None;
    }
    let mut text = Vec::new();
    PlanFile::new(&problem, &Settings::default(), &plan).write(&mut text).unwrap();
    let back = PlanFile::read(text.as_slice()).unwrap();
    assert!(back.cost.is_nan() && back.turned_deg.is_nan());
    assert!(back.optimality.condition.is_nan());
    assert_eq!(back.optimality.conjugate_points, None);
    assert!(back.ladder[0].residuals[1].is_nan());
    assert_eq!(back.ladder[0].residuals[0], 0.1 + 0.2);
    assert!(back.terminal.attitude_rad.is_nan());
    assert_eq!(back.terminal.position_relative, None);
    let verified = back.verified.unwrap();
    assert!(verified.continuous_rate_rad_s.is_nan());
    assert_eq!(verified.order, None);
}

#[test]
fn trajectory_that_is_not_finite_is_refused_in_every_format() {
    for spoil in 0..4 {
        let problem = problem(Motion::RigidBody, Scheme::LieVerlet);
        let mut plan = plan(&problem);
        let trajectory = &mut plan.solution.trajectory;
        let (key, row) = match spoil {
            0 => {
                trajectory.quaternion[3][1] = f64::NAN;
                ("quaternion_wxyz", 3)
            }
            1 => {
                trajectory.force[2][0] = f64::INFINITY;
                ("force_n", 2)
            }
            2 => {
                trajectory.input[7] = f64::NAN;
                ("input", 1)
            }
            _ => {
                *trajectory.costates.last_mut().unwrap() = f64::NEG_INFINITY;
                ("costates", 4)
            }
        };
        let wanted = format!("{key} of the trajectory is not finite in row {row}");
        let trajectory = plan.solution.trajectory.clone();
        let file = PlanFile::new(&problem, &Settings::default(), &plan);
        for result in [
            file.write(std::io::sink()),
            write_csv(&trajectory, &problem, &Identity::default(), false, std::io::sink()),
            write_jsonl(&trajectory, std::io::sink()),
        ] {
            let error = result.unwrap_err();
            assert_eq!(error.to_string(), wanted);
            assert_eq!(error.code(), "E0104");
        }
        let document = TrajectoryDocument(Cow::Owned(trajectory));
        assert!(serde_json::to_string(&document).unwrap_err().to_string().contains(&wanted));
    }
}

#[test]
fn csv_reads_back_bit_for_bit_with_inputs_where_they_exist() {
    for problem in kinds() {
        let trajectory = trajectory(&problem);
        let mut text = Vec::new();
        write_csv(&trajectory, &problem, &Identity::default(), false, &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let header = lines.next().unwrap();
        let rows: Vec<_> = lines.collect();
        assert_eq!(rows.len(), problem.steps + 1);
        assert!(rows.iter().all(|row| row.len() == header.len()));
        let column = |name: &str| {
            let index = header.iter().position(|column| *column == name).unwrap_or_else(|| panic!("{name}"));
            rows.iter().map(|row| row[index].parse().ok()).collect::<Vec<Option<f64>>>()
        };
        let late = problem.steps + 1 - trajectory.torque.len();
        let same = |name: &str, late: usize, wanted: Vec<f64>| {
            let found = column(name);
            assert!(found[..late].iter().all(Option::is_none), "{name}");
            let found: Vec<f64> = found[late..].iter().map(|value| value.unwrap()).collect();
            assert_eq!(bits(&found), bits(&wanted), "{name}");
        };
        same("time_s", 0, trajectory.time.clone());
        same("quaternion_z", 0, trajectory.quaternion.iter().map(|q| q[3]).collect());
        same("angular_velocity_y_rad_s", 0, trajectory.angular_velocity.iter().map(|v| v.y).collect());
        same("torque_x_n_m", late, trajectory.torque.iter().map(|v| v.x).collect());
        let nth = |flat: &[f64], width: usize, at: usize| flat.chunks(width).map(|row| row[at]).collect();
        let unit = if problem.motion == Motion::RigidBody { "n" } else { "n_m" };
        same(&format!("input_2_{unit}"), late, nth(&trajectory.input, trajectory.input_count, 1));
        let sixth = if problem.motion == Motion::RigidBody {
            "linear_momentum_z_cost_per_n_s"
        } else {
            "momentum_z_cost_per_n_m_s"
        };
        same(&format!("costate_{sixth}"), late, nth(&trajectory.costates, problem.dimension(), 5));
        let wheels = wheel_count(&problem);
        if wheels > 0 {
            same("wheel_momentum_3_n_m_s", 0, nth(&trajectory.wheel_momentum, wheels, 2));
        } else {
            assert!(!text.contains("wheel"));
        }
        if problem.motion == Motion::RigidBody {
            same("position_z_m", 0, trajectory.position.iter().map(|v| v.z).collect());
            same("velocity_x_m_s", 0, trajectory.velocity.iter().map(|v| v.x).collect());
            same("force_y_n", late, trajectory.force.iter().map(|v| v.y).collect());
        } else {
            assert!(!text.contains("force") && !text.contains("position"));
        }
    }
}

#[test]
fn json_lines_hold_one_node_each() {
    for problem in kinds() {
        let trajectory = trajectory(&problem);
        let mut text = Vec::new();
        write_jsonl(&trajectory, &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let rows: Vec<serde_json::Value> =
            text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(rows.len(), problem.steps + 1);
        assert_eq!(rows[0].get("input").is_none(), problem.scheme == Scheme::LieEuler);
        let last = &rows[problem.steps];
        let costates: Vec<f64> = serde_json::from_value(last["costates"].clone()).unwrap();
        let n = trajectory.costates.len();
        assert_eq!(bits(&costates), bits(&trajectory.costates[n - problem.dimension()..]));
        assert_eq!(rows[0].get("wheel_momentum_n_m_s").is_some(), wheel_count(&problem) > 0);
        if wheel_count(&problem) > 0 {
            let momenta: Vec<f64> = serde_json::from_value(rows[2]["wheel_momentum_n_m_s"].clone()).unwrap();
            assert_eq!(bits(&momenta), bits(&trajectory.wheel_momentum[8..12]));
        }
        assert_eq!(last["quaternion_wxyz"][2].as_f64(), Some(trajectory.quaternion[4][2]));
    }
}

#[test]
fn table_of_a_simulation_has_no_columns_of_inputs() {
    let problem = problem(Motion::Attitude, Scheme::LieVerlet);
    let mut trajectory = trajectory(&problem);
    trajectory.torque.clear();
    trajectory.input.clear();
    trajectory.input_count = 0;
    trajectory.costates.clear();
    let mut text = Vec::new();
    write_csv(&trajectory, &problem, &Identity::default(), false, &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert_eq!(text.lines().count(), 6);
    assert!(text.lines().all(|line| line.split(',').count() == 8), "{text}");
    write_jsonl(&trajectory, std::io::sink()).unwrap();
}

#[test]
fn arrays_that_do_not_fit_the_maneuver_are_refused() {
    let problem = with_wheels(problem(Motion::Attitude, Scheme::LieVerlet));
    let plan = plan(&problem);
    let mut text = Vec::new();
    PlanFile::new(&problem, &Settings::default(), &plan).write(&mut text).unwrap();
    let whole: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let refused = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut json = whole.clone();
        change(&mut json);
        let text = json.to_string();
        match PlanFile::read(text.as_bytes()) {
            Err(error) => error,
            Ok(file) => file.on_grid(&problem).unwrap_err(),
        }
    };
    for key in [
        "time_s",
        "quaternion_wxyz",
        "angular_velocity_rad_s",
        "input",
        "torque_n_m",
        "costates",
        "wheel_momentum_n_m_s",
    ] {
        let error = refused(&|json| {
            json["trajectory"][key].as_array_mut().unwrap().pop();
        });
        assert!(["E0102", "E0103"].contains(&error.code()), "{key}");
        assert!(error.to_string().contains(key), "{error}");
    }
    // Transposed, without momenta, and with momenta of a fifth wheel.
    let momenta = "wheel_momentum_n_m_s";
    let transposed = serde_json::json!(vec![[0.0, 1.0, 2.0, 3.0, 4.0]; 4]);
    assert_eq!(refused(&|json| json["trajectory"][momenta] = transposed.clone()).code(), "E0102");
    assert_eq!(refused(&|json| json["trajectory"][momenta] = serde_json::json!([])).code(), "E0103");
    let fifth = serde_json::json!(vec![[0.0, 1.0, 2.0, 3.0, 4.0]; 5]);
    assert_eq!(refused(&|json| json["trajectory"][momenta] = fifth.clone()).code(), "E0103");
    assert_eq!(refused(&|json| json["steps"] = 5.into()).code(), "E0103");
    assert_eq!(refused(&|json| json["steps"] = u64::MAX.into()).code(), "E0103");
    assert_eq!(refused(&|json| json["scheme"] = "rk4".into()).code(), "E0102");
    assert_eq!(refused(&|json| json["format"] = 3.into()).code(), "E0102");
    assert_eq!(refused(&|json| json["trajectory"]["input"][2] = serde_json::json!([1.0])).code(), "E0102");
    assert_eq!(refused(&|json| json["trajectory"]["time_s"][2] = serde_json::Value::Null).code(), "E0102");
    // A plan of before, which does not hold its spec.
    let older = refused(&|json| {
        json["format"] = 1.into();
        json.as_object_mut().unwrap().remove("spec");
    });
    assert_eq!(older.code(), "E0102");
    let told = "the plan file has format 1, this program reads 2: older plan files do not hold their spec";
    assert_eq!(older.to_string(), told);
    assert_eq!(older.remedy(), "plan again: `slew plan SPEC -o FILE`");
    let cut = &text[..text.len() / 2];
    let error = PlanFile::read(cut).unwrap_err();
    assert!(error.code() == "E0102" && error.to_string().contains("line"), "{error}");
}
