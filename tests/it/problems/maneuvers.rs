//! Every shipped problem is planned as by a user, and compared with numbers that were not computed
//! with this crate.

use super::told::{picture_faults, summary_faults};
use slewkit::maneuver::problem::Problem;
use slewkit::maneuver::settings::{Method, Settings, Target};
use slewkit::plan::{Plan, PlanError, Silent, Status, plan};
use slewkit_files::spec::{self, Expect, Format, Loaded, Spec};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Returns the maneuvers among the files of `problems/` and `problems/published/`, in order of
/// their names; `simulations.rs` runs the others.
pub(super) fn files() -> Vec<PathBuf> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems");
    let mut files: Vec<PathBuf> = [folder.to_string(), format!("{folder}/published")]
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{folder}: {error}")))
        .map(|entry| entry.expect("an entry of the folder").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .filter(|path| !matches!(spec::load(path, Format::Toml, &[]), Ok(Spec::Simulation(_))))
        .collect();
    files.sort();
    files
}

/// Returns the shipped problem of this name.
fn problem(name: &str) -> Loaded {
    let path = PathBuf::from(format!("{}/../../problems/{name}.toml", env!("CARGO_MANIFEST_DIR")));
    spec::read(&path, &[]).unwrap_or_else(|errors| panic!("{errors}"))
}

/// A constraint acts at many nodes of a fine grid and on arcs that nearly repeat each other. Still
/// the plan has the cost and the kind of the coarse grid's plan: the cheapest.
#[test]
fn fine_grids_have_the_plans_of_coarse_ones() {
    for name in ["keep_out_small", "limited_rate", "limited_rate_axes", "wheels_one_failed", "wheels_pyramid"]
    {
        let Loaded { problem, settings, .. } = problem(name);
        // The costs of discrete optima are compared: a coarse plan that lands within its limits
        // costs more.
        let settings = Settings { target: Target::Discrete, ..settings };
        let coarse = solve(&problem, &settings).solution;
        let fine = solve(&problem.clone().with_steps(1000), &settings);
        assert_eq!(fine.status, Status::Solved, "{name}: {:?}", fine.solution.shortfall);
        // Lie–Verlet is of order two: of the grid's square there is hardly anything left.
        let apart = (fine.solution.cost / coarse.cost - 1.0).abs();
        assert!(
            apart < 1e-3,
            "{name}: {} on 1000 steps, {} on {}",
            fine.solution.cost,
            coarse.cost,
            problem.steps
        );
    }
}

/// Torques change as fast as they may for a third of the maneuver.
#[test]
fn plans_within_limits_of_how_fast_torques_change_go_to_fine_grids() {
    let Loaded { problem, settings, .. } = problem("limited_torque_rate");
    let coarse = solve(&problem, &settings);
    for steps in [625, 1563] {
        let fine = solve(&problem.clone().with_steps(steps), &settings);
        assert_eq!(fine.status, Status::Solved, "{steps} steps: {:?}", fine.solution.shortfall);
        let apart = (fine.solution.cost / coarse.solution.cost - 1.0).abs();
        assert!(apart < 1e-3, "{steps} steps: {}, {} on a hundred", fine.solution.cost, coarse.solution.cost);
    }
}

#[test]
fn a_time_limit_ends_the_convex_road_on_a_fine_grid() {
    let Loaded { problem, settings, .. } = problem("keep_out_small");
    let settings = Settings { time_limit: Some(Duration::from_millis(300)), ..settings };
    let began = Instant::now();
    let plan = solve(&problem.clone().with_steps(40_000), &settings);
    assert_eq!(plan.status, Status::LimitReached);
    assert!(began.elapsed() < Duration::from_secs(10), "{:?}", began.elapsed());
    let most = slewkit::optimize::search::MAX_CONVEX_STEPS;
    let error = plan_error(&problem.with_steps(most + 1), &settings);
    assert_eq!(error, PlanError::TooManySteps { steps: most + 1 });
}

/// Other programs' costs of least time and fuel within limits are met by the interior point as
/// well, on the same grids.
#[test]
fn the_interior_point_has_the_costs_of_other_programs() {
    let names = [
        "shortest_keep_out",
        "shortest_rate",
        "shortest_torque_rate",
        "shortest_wheels",
        "minimum_fuel_wheels",
        "minimum_fuel_keep_out",
    ];
    for name in names {
        let Loaded { problem, settings, expect, .. } = problem(name);
        let settings = Settings { method: Method::InteriorPoint, ..settings };
        let plan = solve(&problem, &settings);
        let mut expect = expect.unwrap_or_else(|| panic!("{name} expects something"));
        // Arcs are another method's.
        (expect.continuous_cost, expect.switches, expect.gap_at_most) = (None, None, None);
        assert_eq!(unmet(&expect, &plan), Vec::<String>::new(), "{name}: {:?}", plan.solution.shortfall);
        assert_eq!(plan.solution.method, Method::InteriorPoint);
    }
}

fn plan_error(problem: &Problem, settings: &Settings) -> PlanError {
    plan(problem, settings, None, &mut Silent).expect_err("no plan is begun")
}

fn solve(problem: &Problem, settings: &Settings) -> Plan {
    plan(problem, settings, None, &mut Silent).unwrap_or_else(|error| panic!("{}: {error}", problem.name))
}

/// Returns the cost of the discrete problem, with which expectations are compared. For a plan that
/// lands this is the cost before its target was shifted.
fn discrete_cost(plan: &Plan) -> f64 {
    let Plan { solution, .. } = plan;
    solution.landing.as_ref().map_or(solution.cost, |landing| landing.cost_before)
}

/// Returns the expectations of `[expect]` that the plan does not meet, in words.
fn unmet(expect: &Expect, plan: &Plan) -> Vec<String> {
    let solution = &plan.solution;
    let mut unmet = Vec::new();
    let mut claim = |holds: bool, what: String| {
        if !holds {
            unmet.push(what);
        }
    };
    let status = plan.status.name();
    claim(status == expect.status, format!("status {status}, not {}", expect.status));
    if status == "verification_failed" {
        let checks = plan.verification.iter().flat_map(|verification| &verification.checks);
        for check in checks.filter(|check| !check.passed) {
            claim(false, format!("{} {:.3e}, limit {:.3e}", check.name, check.value, check.limit));
        }
    }
    if let Some(cost) = expect.cost {
        let found = discrete_cost(plan);
        let met = (found - cost.value).abs() <= cost.tolerance;
        claim(met, format!("cost {found}, not {} ± {:e}", cost.value, cost.tolerance));
    }
    if let Some(published) = expect.published {
        let found =
            solution.switching.as_ref().map_or_else(|| discrete_cost(plan), |told| told.continuous_cost);
        let met = found <= published.value + published.tolerance;
        claim(met, format!("cost {found}, dearer than the published {}", published.value));
    }
    if let Some(limit) = expect.terminal_error {
        let error = solution.terminal.largest();
        claim(error <= limit, format!("terminal error {error:.2e} above {limit:e}"));
    }
    if let Some(limit) = expect.newton_iterations_at_most {
        let count = solution.iterations;
        claim(count <= limit, format!("{count} iterations, not {limit}"));
    }
    if let Some(count) = expect.conjugate_points {
        let found = solution.optimality.conjugate_points;
        claim(found == Some(count), format!("conjugate points {found:?}, not {count}"));
    }
    let switching = solution.switching.as_ref();
    if let Some(cost) = expect.continuous_cost {
        let found = switching.map_or(f64::NAN, |switching| switching.continuous_cost);
        let met = (found - cost.value).abs() <= cost.tolerance;
        claim(met, format!("continuous cost {found}, not {} ± {:e}", cost.value, cost.tolerance));
    }
    if let Some(count) = expect.switches {
        let found = switching.map(|switching| switching.switches);
        claim(found == Some(count), format!("{found:?} switches, not {count}"));
    }
    if let Some(limit) = expect.gap_at_most {
        let found = switching.map_or(f64::NAN, |switching| switching.gap);
        claim(found <= limit, format!("gap {found:.2e}, above {limit:e}"));
    }
    if let Some(sense) = expect.sense {
        claim(solution.sense == sense, format!("sense {:?}, not {sense:?}", solution.sense));
    }
    for rival in &expect.rivals {
        let found = solution.rivals.iter().any(|other| (other.cost - rival.value).abs() <= rival.tolerance);
        claim(found, format!("no rival of cost {}", rival.value));
    }
    if let Some(least) = expect.margin_at_least {
        let margins = plan.verification.iter().flat_map(|verification| &verification.margins);
        let margins: Vec<_> = margins.collect();
        claim(!margins.is_empty(), "no margin is told".into());
        for margin in margins {
            let (name, scaled, time) = (&margin.name, margin.scaled, margin.time_s);
            claim(scaled >= least, format!("margin of \"{name}\" {scaled:.3e} at {time} s, below {least:e}"));
        }
    }
    if let Some(names) = &expect.active {
        let mut found: Vec<&str> = solution.active.iter().map(|active| active.name.as_str()).collect();
        let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
        found.sort_unstable();
        names.sort_unstable();
        claim(found == names, format!("active: {found:?}, not {names:?}"));
    }
    if let Some(reason) = &expect.because {
        let told = solution.infeasible.as_ref().map_or("nothing", |proof| &proof.reason);
        claim(told.contains(reason.as_str()), format!("because {told:?}, which does not say {reason:?}"));
    }
    unmet
}

#[test]
fn every_shipped_problem_comes_to_what_it_expects_and_is_told_and_drawn_so() {
    let only = std::env::var("SLEW_PROBLEM").ok();
    let mut failures = Vec::new();
    println!(
        "{:32} {:>22} {:>14} {:>9} {:>5} {:>5} {:>4} {:>7} {:>7} {:>8}  rivals",
        "problem", "cost", "off by", "terminal", "iter", "conj", "rank", "steps", "solve s", "all s"
    );
    for path in files() {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if only.as_ref().is_some_and(|only| !name.contains(only)) {
            continue;
        }
        let loaded = match spec::read(&path, &[]) {
            Ok(loaded) => loaded,
            Err(errors) => {
                failures.push(format!("{name}: {errors}"));
                continue;
            }
        };
        let Some(expect) = &loaded.expect else {
            failures.push(format!("{name}: no [expect]"));
            continue;
        };
        let began = Instant::now();
        let plan = solve(&loaded.problem, &loaded.settings);
        let all = began.elapsed().as_secs_f64();
        let solution = &plan.solution;
        let off = expect.cost.map_or(f64::NAN, |cost| discrete_cost(&plan) - cost.value);
        let conjugate = solution.optimality.conjugate_points;
        let rivals: Vec<String> = solution
            .rivals
            .iter()
            .map(|rival| {
                let count = rival.conjugate_points.map_or("?".into(), |count| count.to_string());
                format!("{:.4} ({count})", rival.cost)
            })
            .collect();
        println!(
            "{name:32} {:>22} {off:>14.3e} {:>9.1e} {:>5} {:>5} {:>4} {:>7} {:>7.3} {all:>8.3}  {} {:?} {:?} {}",
            solution.cost,
            solution.terminal.largest(),
            solution.iterations,
            conjugate.map_or("?".into(), |count| count.to_string()),
            solution.optimality.rank,
            solution.steps,
            solution.solve_time,
            plan.status.name(),
            solution.start,
            solution.sense,
            rivals.join(" ")
        );
        failures.extend(unmet(expect, &plan).into_iter().map(|what| format!("{name}: {what}")));
        // The summary and the pictures are tested here because the plan is made here.
        let seen = [summary_faults(&loaded, &plan), picture_faults(&loaded, &plan)].concat();
        failures.extend(seen.into_iter().map(|what| format!("{name}: {what}")));
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

#[test]
fn every_shipped_problem_says_what_it_is_for_and_where_its_cost_comes_from() {
    for path in files() {
        let name = path.display();
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        let comment = text.lines().take_while(|line| line.starts_with("# ")).count();
        assert!(comment >= 2, "{name}: no opening comment");
        let loaded = spec::read(&path, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        let expect = loaded.expect.unwrap_or_else(|| panic!("{name}: no [expect]"));
        let source = expect.source.unwrap_or_else(|| panic!("{name}: no source"));
        assert!(source.len() > 20, "{name}: {source:?} is no source");
        if expect.status == "infeasible" {
            assert!(expect.because.is_some(), "{name}: no reason");
            continue;
        }
        let cost = expect.cost.or(expect.continuous_cost);
        let cost = cost.unwrap_or_else(|| panic!("{name}: no cost"));
        let relative = cost.tolerance / cost.value;
        assert!(cost.value > 0.0 && relative <= 2.5e-4, "{name}: cost known to {relative:.1e} only");
    }
}

/// Warnings that a shipped problem means to have.
const INTENDED: [(&str, &str); 8] = [
    // Their unit of time makes the rate of the orbit 1, as published.
    ("orbit_flip", "W0072"),
    ("orbit_turn", "W0072"),
    // Quaternions as published, with four digits.
    ("telescope_four_cones", "W0051"),
    ("telescope_four_cones", "W0051"),
    ("flat_plate", "W0042"),
    ("minimum_fuel_120", "W0042"),
    ("minimum_fuel_norm", "W0042"),
    ("minimum_time_norm", "W0042"),
];

#[test]
fn shipped_problems_warn_of_nothing_but_what_they_mean() {
    for path in files() {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let loaded = spec::read(&path, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        let found: Vec<_> = loaded.warnings.iter().map(|warning| (name.as_str(), warning.code)).collect();
        let intended: Vec<_> = INTENDED.into_iter().filter(|(file, _)| *file == name).collect();
        assert_eq!(found, intended);
    }
}

/// Table 2, cases (iii) and (iv), of Lee, Leok and McClamroch 2006: the printed digits, and
/// terminal errors below the bound that the printed ones (2.90e-15 to 1.48e-14) leave for another
/// order of rounding.
#[test]
fn orbit_maneuvers_come_to_the_printed_digits() {
    for (name, printed, rival) in [("orbit_flip", "23.35", None), ("orbit_turn", "70.74", Some("76.31"))] {
        let loaded = problem(name);
        let plan = solve(&loaded.problem, &loaded.settings);
        let solution = &plan.solution;
        assert_eq!(plan.status, Status::Solved, "{name}");
        assert_eq!(format!("{:.2}", solution.cost), printed, "{name}");
        assert!(solution.terminal.attitude_rad <= 1e-13, "{name}: {:?}", solution.terminal);
        assert!(solution.terminal.momentum_relative <= 1e-13, "{name}: {:?}", solution.terminal);
        assert!(solution.iterations <= 20, "{name}: {} iterations", solution.iterations);
        if let Some(rival) = rival {
            let costs: Vec<String> =
                solution.rivals.iter().map(|other| format!("{:.2}", other.cost)).collect();
            assert!(costs.iter().any(|cost| cost == rival), "{name}: rivals {costs:?}");
        }
    }
}

/// A free body whose thrust acts along fixed axes turns and moves as if each were alone: the costs
/// add up.
#[test]
fn free_turn_and_shift_cost_what_each_costs_alone() {
    let both = problem("free_flyer");
    let turn = problem("rest_120");
    let both = solve(&both.problem, &both.settings).solution.cost;
    let turn = solve(&turn.problem, &turn.settings).solution.cost;
    let (mass, step, steps) = (4.0, 0.04_f64, 50.0);
    let shift: f64 = [(1.0, 0.3_f64), (2.0, -0.2), (0.5, 0.5)]
        .into_iter()
        .map(|(weight, distance)| {
            6.0 * weight * (mass * distance).powi(2) / (step.powi(3) * steps * (steps * steps - 1.0))
        })
        .sum();
    assert!((both - turn - shift).abs() < 1e-10, "{both} against {turn} + {shift}");
}
