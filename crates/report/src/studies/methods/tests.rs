//! The comparison over shipped problems, reference costs and random maneuvers.

use super::*;
use evidence::Random;
use evidence::motions::full_inertia;
use nalgebra::{DMatrix, DVector};
use slewkit::maneuver::{Scheme, State, Weights};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
use slewkit::plan::Silent;
use slewkit::{Matrix3, Vector3, lie};
use slewkit_files::spec;

/// The allowed relative differences between the methods: of costs, of duals of the convex
/// iteration, and of multipliers after the final interior-point solve.
const COST: f64 = 1e-9;
const DUALS: f64 = 1e-6;
const POLISHED: f64 = 1e-9;
/// The allowed residuals after the final interior-point solve: of the terminal conditions, and of
/// all KKT conditions.
const TERMINAL: f64 = 1e-12;
const KKT: f64 = 1e-9;

fn compared(problem: &Problem) -> Comparison {
    let found = compare(problem, &Settings::discrete(), &mut Silent).unwrap();
    for run in &found.methods {
        println!(
            "{:12} {:10?} {:?} by itself {:?} cost {:?} terminal {:.1e} kkt {:.1e} subproblems {:?} newton {}",
            problem.name,
            run.method,
            run.status,
            run.by_itself,
            run.cost,
            run.terminal.map_or(f64::NAN, |terminal| terminal.largest()),
            run.stationarity.unwrap_or(f64::NAN),
            run.subproblems,
            run.newton_iterations,
        );
    }
    println!("             {:?}", found.agreement);
    found
}

/// Describes the violated requirements. The convex iteration alone finds only minima; `minimum`
/// states whether it must converge.
fn unmet(found: &Comparison, minimum: bool) -> Vec<String> {
    let mut unmet = Vec::new();
    let mut claim = |holds: bool, what: String| {
        if !holds {
            unmet.push(what);
        }
    };
    let agreement = &found.agreement;
    let run = |method| found.run(method).unwrap();
    let (shooting, scp, polished) =
        (run(Contender::Shooting), run(Contender::Scp), run(Contender::ScpPolish));
    claim(found.status() == Status::Solved, format!("{:?}", found.status()));
    claim(agreement.verdict == Verdict::Agree, format!("{:?}", agreement.verdict));
    claim(agreement.cost.is_some_and(|cost| cost <= COST), format!("costs {:?}", agreement.cost));
    claim(polished.status == Standing::Ended(Status::Solved), format!("polish {:?}", polished.status));
    let terminal = polished.terminal.map_or(f64::NAN, |terminal| terminal.largest());
    claim(terminal <= TERMINAL, format!("terminal {terminal:e}"));
    claim(polished.stationarity.is_some_and(|kkt| kkt <= KKT), format!("KKT {:?}", polished.stationarity));
    claim(!minimum || scp.status == Standing::Converged, format!("scp {:?}", scp.status));
    if shooting.status == Standing::Ended(Status::Solved) && agreement.costates_unique == Some(true) {
        let after = agreement.duals_after_polish;
        claim(after.is_some_and(|value| value <= POLISHED), format!("multipliers {after:?}"));
        let before = agreement.duals_before_polish;
        claim(!minimum || before.is_some_and(|value| value <= DUALS), format!("duals {before:?}"));
    } else if shooting.status == Standing::DoesNotApply {
        let change = agreement.polish_change;
        claim(change.is_some_and(|value| value <= DUALS), format!("polish changes duals by {change:?}"));
    }
    if let Some(started) = &agreement.from_duals {
        claim(started.newton_steps.is_some_and(|steps| steps <= 3), format!("{started:?}"));
    }
    claim(agreement.active_nodes_that_differ.is_none_or(|count| count == 0), "active sets differ".into());
    unmet
}

#[test]
fn every_shipped_problem_is_solved_alike_by_all_methods() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems");
    let only = std::env::var("SLEW_PROBLEM").unwrap_or_default();
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let mut failures = Vec::new();
    let wanted = |path: &std::path::PathBuf| {
        path.extension().is_some_and(|is| is == "toml") && path.to_string_lossy().contains(&only)
    };
    for path in files.into_iter().filter(wanted) {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        // Specs of simulations have no plan.
        let spec::Spec::Maneuver(loaded) = spec::load(&path, spec::Format::Toml, &[]).unwrap() else {
            continue;
        };
        if loaded.expect.as_ref().is_some_and(|expect| expect.status == "infeasible") {
            continue;
        }
        let problem = loaded.problem;
        // Methods are compared on maneuvers of given duration.
        if problem.objective.switches() || problem.seeks_duration() {
            continue;
        }
        // A hundred nodes show as much as several hundred, and every subproblem takes time.
        let steps = problem.steps.min(200);
        let mut problem = problem.with_steps(steps);
        problem.name = name.clone();
        let found = compared(&problem);
        let points = found.run(Contender::Shooting).and_then(|run| run.conjugate_points);
        let unmet = unmet(&found, points == Some(0));
        if !unmet.is_empty() {
            failures.push(format!("{name}: {}", unmet.join("; ")));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Returns the slew of tests/reference/min_energy_so3.json, each torque limited to a share of the
/// largest.
fn reference_slew(share: Option<f64>) -> Problem {
    let weight = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 2.0, 0.5]));
    let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    let channel = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
    let end = lie::exp(&(Vector3::new(1.0, 2.0, -0.5).normalize() * 120f64.to_radians()));
    let body = Body { inertia: full_inertia(), mass: None };
    let free = Problem::attitude(body, State::at_rest(Matrix3::identity()), State::at_rest(end), 2.0)
        .with_actuation(Actuation::torques(channel))
        .with_objective(Weights::of_torques(weight))
        .with_scheme(Scheme::LieEuler)
        .with_steps(50);
    share.map_or(free.clone(), |share| limited(&free, share))
}

/// Limits every input to a fraction of its peak in the plan without limits.
fn limited(free: &Problem, share: f64) -> Problem {
    let plan = plan::plan(free, &Settings::discrete(), None, &mut Silent).unwrap();
    let peak = plan.solution.trajectory.input.iter().fold(0.0f64, |peak, input| peak.max(input.abs()));
    let count = free.actuation.torque.count();
    let limits = Limits { size: Some(vec![share * peak; count]), ..Limits::default() };
    let channel = free.actuation.torque.clone().with_limits(limits).unwrap();
    free.clone().with_actuation(Actuation::torques(channel))
}

/// The reference costs come from another program.
#[test]
fn the_reference_costs_come_from_every_method() {
    for (share, cost, digits) in [
        (None, 16.389987441935, 1e-12),
        (Some(0.75), 16.718658565135, 1e-12),
        (Some(0.65), 18.0852435685, 1e-10),
    ] {
        let found = compared(&reference_slew(share));
        assert_eq!(unmet(&found, true), Vec::<String>::new(), "{share:?}");
        for run in found.methods.iter().filter(|run| run.status != Standing::DoesNotApply) {
            let off = run.cost.unwrap() / cost - 1.0;
            // The tolerance of the iteration applies if no Newton iteration follows.
            let allowed = if run.method == Contender::Scp { COST } else { digits + 2e-13 };
            assert!(off.abs() < allowed, "{:?} {share:?}: off by {off:e}", run.method);
        }
        // Duals of the convex iteration, before any polish, are costates: two steps of Newton
        // remain.
        let started = found.agreement.from_duals.as_ref().unwrap();
        assert!(started.newton_steps.is_some_and(|steps| steps <= 2), "{started:?}");
        let acts =
            found.run(Contender::ScpPolish).unwrap().active.iter().any(|one| one.name == "torque limit");
        assert_eq!(acts, share.is_some());
    }
}

#[test]
fn random_slews_are_solved_alike_with_and_without_torque_limits() {
    let mut random = Random::new(20_270_101);
    for index in 0..16 {
        let mut j_d = Matrix3::identity() * 0.05;
        for _ in 0..4 {
            let point = random.vector();
            j_d += point * point.transpose();
        }
        let j = (Matrix3::identity() * j_d.trace() - j_d) * 10f64.powf(3.0 * random.uniform());
        let body = Body { inertia: Inertia::new(j).unwrap(), mass: None };
        let duration = 20.0 * 10f64.powf(random.uniform());
        let angle = 1.5 + random.uniform();
        let end = lie::exp(&(random.vector().normalize() * angle));
        let start = random.rotation();
        let end = lie::project_to_rotation(&(start * end));
        let scheme = if index % 2 == 0 { Scheme::LieVerlet } else { Scheme::LieEuler };
        let mut free = Problem::attitude(body, State::at_rest(start), State::at_rest(end), duration)
            .with_scheme(scheme)
            .with_steps(60);
        free.name = format!("random {index}");
        let share = 0.8 + 0.15 * random.uniform();
        for problem in [limited(&free, share), free] {
            let unmet = unmet(&compared(&problem), true);
            assert!(unmet.is_empty(), "{}, {share}: {}", problem.name, unmet.join("; "));
        }
    }
}

#[test]
fn a_second_run_counts_only_on_the_path_that_was_shown_and_the_first_is_kept() {
    let problem = reference_slew(None);
    let settings = Settings::discrete();
    let solved = |problem: &Problem| plan::plan(problem, &settings, None, &mut Silent).unwrap();
    let short = solved(&problem);
    let long = solved(&problem.clone().with_path(slewkit::maneuver::problem::Path::Long));
    let mut answer = Answer::first(long.clone());
    assert!(answer.is(&problem, &long.solution) && !answer.is(&problem, &short.solution));
    assert!(agreement::cheaper(&problem, &short.solution, &long.solution));
    answer.again(&problem, long.clone(), &short.solution);
    assert!(answer.by_itself.is_none());
    answer.again(&problem, short.clone(), &short.solution);
    let run = MethodRun::of(Contender::ScpPolish, &problem, &answer, Standing::Ended(Status::Solved));
    assert_eq!(run.cost, Some(short.solution.cost));
    assert_eq!(
        run.by_itself,
        Some(ByItself { status: Standing::Ended(Status::Solved), cost: Some(long.solution.cost) })
    );
    // Started along the long way, SCP keeps this path, and its result is recognised as different.
    let along = Some(&long.solution.trajectory);
    let kept = search::solve_convex(&problem, &settings, true, along, &mut Silent).unwrap();
    assert!(agreement::same_extremal(&problem, &kept, &long.solution));
}

#[test]
fn what_does_not_apply_or_does_not_solve_is_told_as_such() {
    // No control law of shooting supports limited rates.
    let rule = slewkit::maneuver::constraint::Rule::RateNorm(1.7);
    let constraint = slewkit::maneuver::constraint::Constraint { name: "rate".into(), rule };
    let found = compared(&reference_slew(None).with_constraint(constraint.clone()));
    let shooting = found.run(Contender::Shooting).unwrap();
    assert_eq!(shooting.status, Standing::DoesNotApply);
    assert!(shooting.reason.is_some() && shooting.cost.is_none());
    assert_eq!(unmet(&found, true), Vec::<String>::new());
    assert!(found.agreement.from_duals.is_none());
    // No plan can be found far below the mean rate.
    let rule = slewkit::maneuver::constraint::Rule::RateNorm(0.5);
    let slow = reference_slew(None)
        .with_constraint(slewkit::maneuver::constraint::Constraint { rule, ..constraint });
    let found = compared(&slow);
    assert_ne!(found.status(), Status::Solved);
    assert_eq!(found.agreement.verdict, Verdict::NothingToCompare);
}

#[test]
fn answers_that_differ_are_not_called_one() {
    let problem = reference_slew(None);
    let settings = Settings::discrete();
    let solution = search::solve(&problem, &settings, None, &mut Silent).unwrap();
    let mut other = solution.clone();
    other.cost *= 1.0 + 1e-8;
    let set =
        |a: &Solution, b: &Solution| agreement::of(&problem, &settings, Some(a), b, b, &mut Silent).unwrap();
    assert_eq!(set(&solution, &solution).verdict, Verdict::Agree);
    let apart = set(&solution, &other);
    assert_eq!((apart.verdict, apart.duals_after_polish), (Verdict::Disagree, None));
    assert!((apart.cost.unwrap() / 1e-8 - 1.0).abs() < 1e-6);
    // The mirrored solution has the same cost on another path, so costates are not compared.
    let mut mirrored = solution.clone();
    mirrored.trajectory.quaternion[25] = [0.0, 1.0, 0.0, 0.0];
    assert_eq!(set(&solution, &mirrored).duals_after_polish, None);
    // Costates are compared in scaled units, relative to the largest.
    let mut moved = solution.clone();
    let largest = solution.trajectory.costates.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
    moved.trajectory.costates[7] += 1e-3 * largest;
    let off = set(&solution, &moved).duals_after_polish.unwrap();
    assert!((1e-4..1e-2).contains(&off), "{off}");
}

#[test]
fn a_stop_ends_every_method() {
    struct Stop;
    impl Observer for Stop {
        fn on_progress(&mut self, _: &search::Progress) -> search::Control {
            search::Control::Stop
        }
    }
    let found = compare(&reference_slew(Some(0.75)), &Settings::discrete(), &mut Stop).unwrap();
    assert_eq!(found.status(), Status::Interrupted);
}

#[cfg(feature = "sdp")]
mod bounded {
    use super::*;

    fn shipped(name: &str) -> Problem {
        let path = format!("{}/../../problems/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        spec::read(std::path::Path::new(&path), &[]).unwrap().problem
    }

    #[test]
    fn the_gap_is_of_one_discrete_problem_and_nothing_when_the_plan_is_optimal() {
        let found = global(&shipped("rest_120"), &Settings::discrete(), Some(4), &mut Silent).unwrap();
        assert!(!found.same_grid && found.steps == 4 && found.tight);
        assert!(found.lower_bound <= found.cost && found.gap < 1e-6);
        // On the grid of the maneuver, the discrete problem has a different cost: 10.69, not 9.54.
        assert!((found.cost - 9.543).abs() < 1e-3);
        let same =
            global(&shipped("rest_120").with_steps(4), &Settings::discrete(), None, &mut Silent).unwrap();
        assert!(same.same_grid && (same.cost - found.cost).abs() < 1e-12);
    }

    #[test]
    fn a_loose_bound_says_so_and_limits_have_their_share_of_the_gap() {
        let loose =
            global(&shipped("rest_120_weighted"), &Settings::discrete(), Some(6), &mut Silent).unwrap();
        assert!(!loose.tight && loose.gap > 0.1 && loose.gap < 0.9, "{loose:?}");
        let free = shipped("rest_120").with_steps(4);
        let found = global(&limited(&free, 0.9), &Settings::discrete(), None, &mut Silent).unwrap();
        let without = found.cost_without_limits.unwrap();
        assert!(found.cost > without * 1.001 && found.tight, "{found:?}");
        assert!((found.gap - (found.cost - found.lower_bound) / found.cost).abs() < 1e-15);
        assert!(found.gap > 1e-3 && found.gap_without_limits < 1e-6);
    }

    #[test]
    fn what_no_bound_covers_is_refused_before_anything_is_solved() {
        let refused = global(&shipped("pendulum_inversion"), &Settings::discrete(), None, &mut Silent);
        assert!(matches!(refused, Err(GlobalError::Bound(_))), "{refused:?}");
        let long = global(&shipped("rest_120"), &Settings::discrete(), Some(61), &mut Silent);
        assert!(matches!(long, Err(GlobalError::Bound(_))), "{long:?}");
    }
}
