//! Every file that the library writes is read back, bit for bit, or is not there at all.

use slewkit::files::export::{
    ExportError, FileError, PlanFile, Target, TrajectoryDocument, read_guess, write_csv, write_jsonl,
};
use slewkit::files::identity::Identity;
use slewkit::files::spec::SpecDocument;
use slewkit::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use slewkit::maneuver::problem::{Motion, Problem, Scheme, State};
use slewkit::maneuver::settings::{Method, Settings};
use slewkit::maneuver::solution::{
    ActiveConstraint, ConvexWork, Optimality, Outcome, Rival, Rung, RungReport, Sense, Solution,
    TerminalError, Trajectory,
};
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::plan::{Guess, Plan, Status};
use slewkit::verify::{Check, Verification};
use slewkit::{Matrix3, Vector3};
use std::borrow::Cow;
use std::fs;
use std::path::Path;

/// Numbers that a careless writer loses: signed zero, subnormals, 17 digits, the ends of the range.
const AWKWARD: [f64; 9] = [
    -0.0,
    5e-324,
    f64::MIN_POSITIVE - 5e-324,
    0.1 + 0.2,
    -1.0 / 3.0,
    9007199254740993.0,
    f64::MAX,
    -f64::MIN_POSITIVE,
    1e23,
];

/// An endless supply of awkward numbers.
struct Numbers(usize);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 += 1;
        AWKWARD[self.0 % AWKWARD.len()]
    }
    fn row<const M: usize>(&mut self) -> [f64; M] {
        std::array::from_fn(|_| self.next())
    }
    fn vectors(&mut self, rows: usize) -> Vec<Vector3> {
        (0..rows).map(|_| self.row::<3>().into()).collect()
    }
}

fn problem(motion: Motion, scheme: Scheme) -> Problem {
    let inertia = Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5)).unwrap();
    let start = State::at_rest(Matrix3::identity());
    let end = State::at_rest(Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0));
    let body = Body { inertia, mass: (motion == Motion::RigidBody).then_some(3.0) };
    let problem = match motion {
        Motion::Attitude => Problem::attitude(body, start, end, 0.3),
        Motion::RigidBody => Problem::rigid_body(body, start, end, 0.3),
    };
    problem.with_steps(4).with_scheme(scheme)
}

/// Four wheels in a pyramid, one of them without a limit of its momentum.
fn with_wheels(problem: Problem) -> Problem {
    let axes = [(0.8, 0.0), (0.0, 0.8), (-0.8, 0.0), (0.0, -0.8)].map(|(x, y)| Vector3::new(x, y, 0.6));
    let torque = ActuatorSet::new(axes.to_vec(), AxisFrame::Body).unwrap();
    let size = Some(vec![0.1, 0.2, 0.3, 0.4]);
    let torque = torque.with_limits(Limits { size, ..Limits::default() }).unwrap();
    let momentum_limit = vec![1.0, 2.0, f64::INFINITY, 4.0];
    let wheels = Wheels { momentum: vec![0.1, 0.0, -0.5, 4.0], momentum_limit };
    problem.with_actuation(Actuation { wheels: Some(wheels), ..Actuation::torques(torque) })
}

fn wheel_count(problem: &Problem) -> usize {
    problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len())
}

/// Every kind of constraint, all held by the ends.
fn with_constraints(problem: Problem) -> Problem {
    let direction = |vector, turns_with_frame| Direction { vector, turns_with_frame };
    let pointing = |side, sign: f64, half_angle| {
        Rule::Pointing(Pointing {
            side,
            boresights: vec![Vector3::z(), Vector3::x()],
            directions: vec![
                direction(sign * Vector3::new(0.36, 0.48, 0.8), false),
                direction(sign * Vector3::z(), true),
            ],
            half_angle,
            margin: 0.1 + 0.2,
        })
    };
    let constraint = |name: &str, rule| Constraint { name: name.into(), rule };
    problem
        .with_constraint(constraint("Sun", pointing(Side::KeepOut, -1.0, 0.5)))
        .with_constraint(constraint("Earth", pointing(Side::KeepIn, 1.0, 2.5)))
        .with_constraint(constraint("rate", Rule::RateNorm(1.0 / 3.0)))
        .with_constraint(constraint("rates", Rule::RateAxes(Vector3::new(0.1, 0.2, 0.3))))
}

fn trajectory(problem: &Problem) -> Trajectory {
    let mut numbers = Numbers(0);
    let (nodes, rows) = (problem.steps + 1, problem.scheme.input_rows(problem.steps));
    let moving = problem.motion == Motion::RigidBody;
    Trajectory {
        time: (0..nodes).map(|k| k as f64 * problem.step()).collect(),
        quaternion: (0..nodes).map(|_| numbers.row()).collect(),
        angular_velocity: numbers.vectors(nodes),
        position: numbers.vectors(if moving { nodes } else { 0 }),
        velocity: numbers.vectors(if moving { nodes } else { 0 }),
        input: (0..rows * problem.actuation.count()).map(|_| numbers.next()).collect(),
        input_count: problem.actuation.count(),
        torque: numbers.vectors(rows),
        wheel_momentum: (0..nodes * wheel_count(problem)).map(|_| numbers.next()).collect(),
        force: numbers.vectors(if moving { rows } else { 0 }),
        costates: (0..rows * problem.dimension()).map(|_| numbers.next()).collect(),
    }
}

fn plan(problem: &Problem) -> Plan {
    let check = Check { name: "order".into(), value: 1.99, limit: 0.3, passed: true };
    let verification = Verification { order: Some(1.9999), checks: vec![check], ..Verification::default() };
    let rung = RungReport {
        rung: Rung::Newton,
        start: "short".into(),
        steps: 4,
        outcome: Outcome::Converged,
        iterations: 2,
        residuals: vec![0.1 + 0.2, 1e-3, 5e-324],
    };
    let rival = Rival {
        start: "long".into(),
        sense: Sense::Long,
        cost: 1.0 / 3.0,
        conjugate_points: None,
        turned_deg: 210.0,
    };
    let solution = Solution {
        outcome: Outcome::Converged,
        scheme: problem.scheme,
        steps: problem.steps,
        step: problem.step(),
        cost: 0.1 + 0.7,
        trajectory: trajectory(problem),
        terminal: TerminalError { attitude_rad: 4e-13, momentum_relative: 2e-14, ..Default::default() },
        optimality: Optimality {
            tested: true,
            stationarity: 6e-13,
            conjugate_points: Some(0),
            rank: 6,
            condition: 38.0,
        },
        sense: Sense::Short,
        start: "short".into(),
        turned_deg: 150.0,
        iterations: 2,
        ladder: vec![rung],
        shortest: Some(41.25),
        longer: Some(41.5),
        shortfall: None,
        convex: problem.is_constrained().then_some(ConvexWork {
            subproblems: 3,
            all_subproblems: 7,
            cone_iterations: 50,
            cone_seconds: 0.01,
            effort_share: 1.0 / 3.0,
        }),
        active: vec![ActiveConstraint {
            name: "torque limit".into(),
            time_s: vec![0.1 + 0.2, 5e-324],
            multiplier: vec![1.0 / 3.0, 0.0],
        }],
        method: if problem.is_constrained() { Method::Scp } else { Method::Shooting },
        switching: None,
        rivals: vec![rival],
        infeasible: None,
        tolerance: 1e-12,
        solve_time: 0.0024,
    };
    Plan { solution, verification: Some(verification), status: Status::Solved }
}

/// The kinds of trajectory: two motions, and wheels under constraints, in two schemes.
fn kinds() -> Vec<Problem> {
    let mut kinds = Vec::new();
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        kinds.push(problem(Motion::Attitude, scheme));
        kinds.push(problem(Motion::RigidBody, scheme));
        kinds.push(with_constraints(with_wheels(problem(Motion::Attitude, scheme))));
    }
    kinds
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Equality of floats takes −0 for 0: compare bits.
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
            back.convex.as_ref().map(|work| (work.cone_iterations, work.effort_share)),
            problem.is_constrained().then_some((50, 1.0 / 3.0))
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
    let told = "the plan file has format 1, this program reads 2: older plan files do not hold the spec that they answer";
    assert_eq!(older.to_string(), told);
    assert_eq!(older.remedy(), "plan again: `slew plan SPEC -o FILE`");
    let cut = &text[..text.len() / 2];
    let error = PlanFile::read(cut).unwrap_err();
    assert!(error.code() == "E0102" && error.to_string().contains("line"), "{error}");
}

fn differences(one: &Problem, other: &Problem) -> Vec<String> {
    let document = |problem| SpecDocument::new(problem, &Settings::default()).unwrap();
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
    other.duration = 0.4;
    other.end.angular_velocity.x = 1e-9;
    assert_eq!(differences(&one, &other), ["end.angular_velocity_rad_s", "maneuver.duration_s"]);
    let document = |settings| SpecDocument::new(&one, settings).unwrap();
    let looser = Settings { tolerance: 1e-9, ..Settings::default() };
    let found = document(&Settings::default()).differences(&document(&looser));
    let [found] = &found[..] else { panic!("{found:?}") };
    assert_eq!([&found.key[..], &found.first, &found.second], ["solver.tolerance", "1e-12", "1e-9"]);
}

/// Whatever limits a maneuver makes it another one, and the record says which key.
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
    assert_eq!(keys(&cone(|cone| cone.directions[0].turns_with_frame = true)), turning);
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into()).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_there_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    let target = Target::new(&path, false).unwrap();
    let failed = target.write(|output| {
        output.write_all(b"half")?;
        Err(std::io::Error::other("disk full").into())
    });
    assert_eq!(failed.unwrap_err().code(), "E0097");
    assert_eq!(names(folder.path()), [""; 0], "nothing may be left behind");

    target.write(|output| Ok(output.write_all(b"whole")?)).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"whole");
    assert_eq!(names(folder.path()), ["plan.json"]);

    let forced = Target::new(&path, true).unwrap();
    assert!(forced.write(|_| Err(std::io::Error::other("disk full").into())).is_err());
    assert_eq!(fs::read(&path).unwrap(), b"whole", "the old file survives a failed write");
    forced.write(|output| Ok(output.write_all(b"newer")?)).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"newer");
    assert_eq!(names(folder.path()), ["plan.json"]);
}

#[test]
fn an_existing_file_is_never_replaced_without_force() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    let early = Target::new(&path, false).unwrap();
    fs::write(&path, "mine").unwrap();
    assert!(matches!(Target::new(&path, false), Err(FileError::Exists { .. })));
    // Also when it appears between the check and the end of the solve.
    let error = early.write(|output| Ok(output.write_all(b"other")?)).unwrap_err();
    assert_eq!(error.code(), "E0098");
    assert_eq!(fs::read(&path).unwrap(), b"mine");
    assert_eq!(names(folder.path()), ["plan.json"]);
}

#[test]
fn names_that_cannot_be_files_are_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let code = |name: &str| match Target::new(folder.path().join(name), true) {
        Ok(_) => "accepted",
        Err(error) => error.code(),
    };
    assert_eq!(code("missing/plan.json"), "E0095");
    for name in ["a\nb", "\u{1b}[31mred", "CON", "con.json", "Lpt1.txt", "folder/", "."] {
        assert_eq!(code(name), "E0099", "{name:?}");
    }
    assert_eq!(code(&"n".repeat(256)), "E0099");
    for name in ["CONE.json", "com0.json", "lpt10", "plan", ".hidden", "größe.json"] {
        assert_eq!(code(name), "accepted", "{name:?}");
    }
    fs::create_dir(folder.path().join("taken")).unwrap();
    assert_eq!(code("taken"), "E0099");
    let shown = Target::new(folder.path().join("\u{1b}[31m"), true).unwrap_err().to_string();
    assert!(shown.contains("\\u{1b}") && !shown.contains('\u{1b}'), "{shown}");
}

#[test]
fn an_output_that_is_an_input_is_refused_even_with_force() {
    let folder = tempfile::tempdir().unwrap();
    let spec = folder.path().join("spec.toml");
    fs::write(&spec, "spec").unwrap();
    let target = Target::new(folder.path().join("./spec.toml"), true).unwrap();
    assert_eq!(target.distinct_from(&spec).unwrap_err().code(), "E0100");
    Target::new(folder.path().join("plan.json"), true).unwrap().distinct_from(&spec).unwrap();
}

#[cfg(unix)]
#[test]
fn devices_and_rights_are_respected() {
    use std::os::unix::fs::PermissionsExt;
    // Streams too, whatever they lead to: with force, the file behind one would be another program's.
    for name in ["/dev/null", "/dev/stderr", "/dev/fd/2", "/proc/self/fd/2"] {
        for force in [false, true] {
            assert_eq!(Target::new(name, force).unwrap_err().code(), "E0099", "{name}");
        }
    }
    // Here nobody can make a file, whoever asks.
    #[cfg(target_os = "linux")]
    assert_eq!(Target::new("/sys/plan.json", false).unwrap_err().code(), "E0096");
    let folder = tempfile::tempdir().unwrap();
    let mode = |name: &str| fs::metadata(folder.path().join(name)).unwrap().permissions().mode();
    fs::write(folder.path().join("ordinary"), "").unwrap();
    let path = folder.path().join("ours");
    Target::new(&path, false).unwrap().write(|output| Ok(output.write_all(b"x")?)).unwrap();
    assert_eq!(mode("ours"), mode("ordinary"), "readable as any new file");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
    Target::new(&path, true).unwrap().write(|output| Ok(output.write_all(b"x")?)).unwrap();
    assert_eq!(mode("ours") & 0o777, 0o640, "a replaced file keeps its rights");
    std::os::unix::fs::symlink(folder.path().join("nowhere"), folder.path().join("dangling")).unwrap();
    // A name that is taken, and that nothing can be written to, by force or without.
    for force in [false, true] {
        assert_eq!(Target::new(folder.path().join("dangling"), force).unwrap_err().code(), "E0099");
    }
}
