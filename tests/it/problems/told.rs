//! The summary of a plan fits a screen and is correct, and the pictures end at the values of the
//! witnesses.

use slewkit::Vector3;
use slewkit::lie;
use slewkit::maneuver::{Outcome, Rule};
use slewkit::numerics::figures::significant;
use slewkit::plan::{Plan, Status};
use slewkit_files::spec::Loaded;
use slewkit_report::draw::{Chart, Picture};
use slewkit_report::{Subject, pictures, summary};

/// Lines of a summary, and columns.
const LINES: usize = 12;
const COLUMNS: usize = 80;

/// Words of the program's own.
const PRIVATE: [&str; 12] = [
    "stage",
    "seed",
    "road",
    "rung",
    "ladder",
    "witness",
    "costate",
    "residual",
    "stationarity",
    "newton",
    "scp",
    "symplectic",
];

/// Returns the faults of the summary of a plan.
pub fn summary_faults(loaded: &Loaded, plan: &Plan) -> Vec<String> {
    let mut faults = Vec::new();
    let mut claim = |holds: bool, what: String| {
        if !holds {
            faults.push(what);
        }
    };
    let (problem, solution) = (plan.solution.on_grid(&loaded.problem), &plan.solution);
    let text = summary::plan(false, &loaded.problem, &loaded.settings, plan, &loaded.identity).join("\n");
    let lines: Vec<&str> = text.lines().collect();
    // One more line names the next command.
    claim(lines.len() < LINES, format!("{} lines:\n{text}", lines.len()));
    for line in &lines {
        claim(line.chars().count() <= COLUMNS, format!("{} columns: {line}", line.chars().count()));
    }
    let below = lines[1..].join(" ").to_lowercase();
    for word in PRIVATE {
        let said = below.split(|c: char| !c.is_alphanumeric()).any(|said| said == word);
        claim(!said, format!("\"{word}\" is said:\n{text}"));
    }
    let has = |what: String| (text.contains(&what), format!("no \"{what}\" in:\n{text}"));
    if plan.status == Status::Infeasible {
        let reason = solution.infeasible.as_ref().map_or("", |proof| &proof.reason);
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        claim(words.contains(reason), format!("the reason is not told whole:\n{text}"));
        return faults;
    }
    let found = plan.verification.as_ref().expect("verified");
    let mut wanted = vec![
        has(format!("{:.1} deg", solution.turned_deg)),
        has(format!("{} deg/s", significant(found.continuous_rate_rad_s.to_degrees(), 2))),
        has(format!("{} deg/s at most", significant(found.peak_rate_rad_s.to_degrees(), 3))),
        has(significant(solution.cost, 6)),
    ];
    if !problem.ends_in_any_attitude() {
        wanted.push(has(format!("{} deg", significant(found.continuous_attitude_rad.to_degrees(), 2))));
    }
    // Each input by itself, from the rows of the plan.
    let count = solution.trajectory.input_count;
    if count <= 6 && loaded.identity.nozzles.is_empty() {
        for input in 0..count {
            let rows = solution.trajectory.input.iter().skip(input).step_by(count);
            wanted.push(has(format!(
                " {}",
                significant(rows.fold(0.0, |peak, value| value.abs().max(peak)), 3)
            )));
        }
    }
    let cones = problem.constraints.iter().filter(|rule| matches!(rule.rule, Rule::Pointing(_)));
    let named: Vec<_> = cones.map(|cone| has(format!("{}: ", cone.name))).collect();
    // Where there is no room for all of them, the nearest are named and the others counted; where
    // there is room for one line, it names the nearest.
    let clearances = lines.iter().skip_while(|line| !line.starts_with("  clearance"));
    let alone = clearances.skip(1).take(1).any(|line| !line.starts_with("      "));
    if text.contains("more with more clearance") || alone {
        let some = named.iter().any(|(named, _)| *named);
        wanted.push((some, format!("the nearest cone in:\n{text}")));
    } else {
        wanted.extend(named);
    }
    // If no field acts on the body, only thrusters that push change its momentum.
    if let (Some(pushed), Some(mass)) = (text.split("push (").nth(1), problem.body.mass)
        && problem.actuation.thrusters.is_some()
        && problem.environment.is_free()
    {
        let told: Vec<f64> =
            pushed.split(')').next().unwrap_or("").split(", ").filter_map(|part| part.parse().ok()).collect();
        let all: f64 = pushed
            .split("net of ")
            .nth(1)
            .and_then(|rest| rest.split(' ').next()?.parse().ok())
            .unwrap_or(0.0);
        let gained = (problem.end.velocity - problem.start.velocity) * mass;
        let off =
            told.iter().zip(gained.iter()).map(|(told, gained)| (told - gained).powi(2)).sum::<f64>().sqrt();
        // The body turns within a step, which the sum takes half at either end.
        let holds = told.len() == 3 && off < 0.01 * all;
        wanted.push((holds, format!("a push of {gained:?} in:\n{text}")));
    }
    for (holds, what) in wanted {
        claim(holds, what);
    }
    faults
}

/// Returns the curves of a plan whose last value, or whose smallest clearance, differs from the
/// number that a witness has found.
pub fn picture_faults(loaded: &Loaded, plan: &Plan) -> Vec<String> {
    let Some(found) = plan.verification.as_ref().filter(|_| plan.solution.outcome == Outcome::Converged)
    else {
        return Vec::new();
    };
    let problem = &plan.solution.on_grid(&loaded.problem);
    let trajectory = &plan.solution.trajectory;
    let shown = pictures(&Subject::new(problem, plan, &loaded.identity, "zyx"));
    let chart = |key: &str| -> Option<&Chart> {
        shown.iter().find(|shown| shown.key == key).and_then(|shown| match &shown.picture {
            Picture::Chart(chart) => Some(chart),
            _ => None,
        })
    };
    let last = |key: &str, name: &str| -> f64 {
        let curve = chart(key).and_then(|chart| chart.curves.iter().find(|curve| curve.name == name));
        curve.and_then(|curve| curve.shape.points().last().copied()).map_or(f64::NAN, |point| point.1)
    };
    let mut faults = Vec::new();
    let mut same = |what: &str, shown: f64, wanted: f64, tolerance: f64| {
        let apart = (shown - wanted).abs();
        // NaN differs from everything.
        if apart.is_nan() || apart > tolerance {
            faults.push(format!("{what}: {shown:e} shown, {wanted:e} found"));
        }
    };
    let degrees = |angle: f64| angle.to_degrees();
    // Round-off of attitudes.
    let close = 1e-11;
    same("true motion", last("error", "true motion"), degrees(found.continuous_attitude_rad), close);
    let aimed = trajectory
        .target
        .as_ref()
        .map_or(0.0, |target| lie::minus(&target.attitude, &problem.end.attitude).norm());
    let off = degrees(found.discrete_attitude_rad);
    same("discrete motion", last("error", "discrete motion"), degrees(aimed), off + close);
    // The recorded motion is the true one if the plan lands, and otherwise the discrete one.
    let lands = trajectory.target.is_some();
    let rate = Vector3::from([last("rates", "Ω x"), last("rates", "Ω y"), last("rates", "Ω z")])
        .map(f64::to_radians);
    let missed = (rate - problem.end.angular_velocity).norm();
    let duration = trajectory.time.last().copied().unwrap_or(f64::NAN).max(f64::MIN_POSITIVE);
    let scale = problem.body.inertia.mean() / problem.body.inertia.principal().min() / duration;
    let wanted = if lands { found.continuous_rate_rad_s } else { 0.0 };
    // The recorded motion is the planner's, which the witnesses' own may differ from by so much
    // ("recorded motion", scaled).
    let flown = 1e-6;
    same("rate", missed, wanted, (found.discrete_momentum_relative + flown) * scale);
    let quaternion = ["w", "x", "y", "z"].map(|name| last("quaternion", name));
    let left = lie::minus(&lie::rotation_from_quaternion(&quaternion), &problem.end.attitude).norm();
    let wanted = if lands { found.continuous_attitude_rad } else { found.discrete_attitude_rad };
    same("quaternion", degrees(left), degrees(wanted), degrees(flown));
    if let Some(wanted) = found.continuous_position_m.filter(|_| lands) {
        let position = Vector3::from(["x", "y", "z"].map(|axis| last("position", axis)));
        same(
            "position",
            (position - problem.end.position).norm(),
            wanted,
            flown * (1.0 + problem.end.position.norm()),
        );
    }
    for margin in &found.margins {
        for (name, wanted) in [("discrete", Some(margin.margin)), ("true", margin.continuous_margin)] {
            let name = format!("{name} motion\n{}", margin.name);
            let curve =
                chart("clearance").and_then(|chart| chart.curves.iter().find(|curve| curve.name == name));
            let (Some(curve), Some(wanted)) = (curve, wanted) else { continue };
            let least = curve.shape.points().iter().fold(f64::INFINITY, |least, point| least.min(point.1));
            same(&name, least, wanted, 1e-9);
        }
    }
    faults
}
