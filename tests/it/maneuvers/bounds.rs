//! The planner at its bounds: it stops if requested, refuses nonsense, and never reports a false
//! result.

use super::minimum_time::moving;
use super::support::{rest_to_rest, solved, weighted};
use evidence::Random;
use slewkit::maneuver::problem::{Path, Problem, Scheme, State};
use slewkit::maneuver::settings::Settings;
use slewkit::maneuver::solution::{Outcome, Rung};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::UniformGravity;
use slewkit::optimize::search::solve;
use slewkit::plan::{Control, Guess, Observer, PlanError, Progress, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

struct StopAfter(usize);

impl Observer for StopAfter {
    fn on_progress(&mut self, progress: &Progress) -> Control {
        assert!(progress.elapsed >= 0.0);
        self.0 = self.0.saturating_sub(1);
        if self.0 == 0 { Control::Stop } else { Control::Continue }
    }
}

#[test]
fn an_observer_stops_the_solve() {
    let problem = rest_to_rest(150.0);
    let interrupted = plan(&problem, &Settings::discrete(), None, &mut StopAfter(2)).unwrap();
    assert_eq!(interrupted.status, Status::Interrupted);
    assert_eq!(interrupted.solution.outcome, Outcome::Interrupted);
    assert!(interrupted.verification.is_none());
    let patient = plan(&problem, &Settings::discrete(), None, &mut StopAfter(usize::MAX)).unwrap();
    assert_eq!(patient.status, Status::Solved);
}

#[test]
fn a_time_limit_is_kept_and_leaves_a_best_iterate() {
    // A guess is swept before the clock is looked at: there is an iterate to keep.
    let problem = rest_to_rest(150.0).with_steps(20_000);
    let settings = Settings { time_limit: Some(Duration::from_nanos(1)), ..Settings::discrete() };
    let guess = Guess::costates(solved(&rest_to_rest(140.0)).costates_0(&problem));
    let limited = plan(&problem, &settings, Some(&guess), &mut Silent).unwrap();
    assert_eq!(limited.status, Status::LimitReached);
    assert_eq!(limited.solution.outcome, Outcome::TimeLimit);
    assert!(limited.verification.is_none());
    assert_eq!(limited.solution.trajectory.time.len(), problem.steps + 1);
    assert!(limited.solution.terminal.largest() > 1e-12);
    let began = Instant::now();
    let cold = plan(&problem, &settings, None, &mut Silent).unwrap();
    assert_eq!(cold.status, Status::LimitReached);
    assert!(began.elapsed() < Duration::from_secs(20));
}

#[test]
fn a_guess_is_used() {
    let problem = rest_to_rest(-240.0)
        .with_path(Path::AsGiven(Vector3::new(1.0, 2.0, -0.5).normalize() * (-240f64).to_radians()));
    let long = solved(&problem);
    let settings = Settings::discrete();
    let guess = Guess::of(&long, &problem);
    // The best path is the short one if no guess is given; with the guess the solve stays on the
    // long way.
    let best = problem.clone().with_path(Path::Best);
    let warm = solve(&best, &settings, Some(&guess), &mut Silent).unwrap();
    assert!((warm.cost - long.cost).abs() < 1e-9 * long.cost);
    assert_eq!((warm.start.as_str(), warm.iterations), ("guess", 0));
    assert!(solved(&best).cost < 0.5 * long.cost);

    let wrong = [[0.0; 5].to_vec(), [f64::NAN; 6].to_vec()];
    for costates in wrong {
        assert!(matches!(
            solve(&best, &settings, Some(&Guess::costates(&costates)), &mut Silent),
            Err(PlanError::Guess { needed: 6, .. })
        ));
    }
    let no_unit = Guess { quaternion: vec![[1.0, 0.0, 0.0, f64::NAN]; 3], ..guess };
    assert_eq!(solve(&best, &settings, Some(&no_unit), &mut Silent).unwrap_err(), PlanError::GuessPath);
}

#[test]
fn the_tightest_tolerance_is_met_or_the_outcome_says_no() {
    for degrees in [30.0, 90.0, 150.0] {
        let settings = Settings { tolerance: 2e-14, ..Settings::discrete() };
        let solution = solve(&rest_to_rest(degrees), &settings, None, &mut Silent).unwrap();
        let met = solution.terminal.largest() <= 2e-14;
        assert_eq!(met, solution.outcome == Outcome::Converged, "{degrees}: {:?}", solution.terminal);
    }
}

/// Returns an arbitrary number.
fn any(random: &mut Random) -> f64 {
    let size = 10f64.powf(40.0 * random.unit() - 20.0);
    random.pick(&[0.0, -0.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE, f64::MAX, size, -size, 1.0])
}

#[test]
fn problems_with_absurd_numbers_are_errors() {
    let mut random = Random::new(71);
    let mut refused = 0;
    for _ in 0..2000 {
        let mut problem = rest_to_rest(60.0).with_steps(random.pick(&[0, 1, 2, 3, 20, usize::MAX]));
        for _ in 0..1 + (random.unit() * 2.0) as usize {
            let value = any(&mut random);
            let row = (random.unit() * 3.0) as usize;
            match (random.unit() * 5.0) as usize {
                0 => problem.duration = slewkit::Duration::Given(value),
                1 => problem.start.angular_velocity[row] = value,
                2 => problem.end.angular_velocity[row] = value,
                3 => problem.start.attitude[(row, 1)] = value,
                _ => problem.end.attitude[(1, row)] = value,
            }
        }
        let settings =
            Settings { time_limit: Some(Duration::from_secs(2)), max_iterations: 15, ..Settings::discrete() };
        match plan(&problem, &settings, None, &mut Silent) {
            Err(_) => refused += 1,
            Ok(plan) if plan.status == Status::Solved => {
                assert!(plan.solution.terminal.largest() <= 1e-12 && plan.solution.cost.is_finite());
            }
            Ok(_) => {}
        }
    }
    assert!(refused > 1000, "{refused}");
}

/// Returns a maneuver from the corners of the allowed range.
fn corner(random: &mut Random) -> Option<Problem> {
    let thin = random.pick(&[1.0, 1.0, 0.1, 1e-3, 1e-6, 0.0]);
    let thinner = random.pick(&[1.0, 1.0, thin]);
    let spread = Vector3::new(1.0, thinner * (0.2 + random.unit()), thin * (0.2 + random.unit()));
    let axes = lie::exp(&(2.0 * random.vector()));
    let j_d = axes * Matrix3::from_diagonal(&spread) * axes.transpose();
    let size = random.pick(&[1.0, 1.0, 1e-9, 1e12]);
    let j = (Matrix3::from_diagonal_element(j_d.trace()) - j_d) * size;
    let inertia = Inertia::new(j).ok()?;
    let duration = random.pick(&[1.0, 1.0, 1e-3, 1e6]);
    let fast = random.pick(&[0.0, 0.0, 1.0, 10.0, 100.0]) / duration;
    let turn = random.pick(&[0.0, 1e-9, 1e-3, 1.0, 1.0, std::f64::consts::PI, 6.0]);
    let mut state =
        |turn: f64| State::attitude(lie::exp(&(random.vector().normalize() * turn)), random.vector() * fast);
    let (start, end) = (state(2.0), state(turn));
    let steps = random.pick(&[2, 3, 5, 17, 60]);
    let scheme = random.pick(&[Scheme::LieEuler, Scheme::LieVerlet]);
    let path = random.pick(&[Path::Best, Path::Shortest, Path::Long]);
    let mut problem = Problem::attitude(Body { inertia, mass: None }, start, end, duration)
        .with_steps(steps)
        .with_scheme(scheme)
        .with_path(path);
    if random.unit() < 0.3 {
        problem = problem.with_objective(weighted([1.0, 1e6, 1e-6]));
    }
    if random.unit() < 0.3 {
        let weight = size / duration / duration * random.pick(&[0.1, 3.0, 50.0]);
        problem =
            problem.with_environment(UniformGravity::new(1.0, weight, Vector3::z(), Vector3::x()).ok()?);
    }
    Some(problem)
}

/// Stops a search after so many steps: as many on any machine.
struct StopsAfter(usize);

impl Observer for StopsAfter {
    fn on_progress(&mut self, _: &Progress) -> Control {
        self.0 = self.0.saturating_sub(1);
        if self.0 == 0 { Control::Stop } else { Control::Continue }
    }
}

/// `RANDOM_MANEUVERS` sets their number.
#[test]
fn random_maneuvers_never_panic_hang_or_pass_for_solved_when_they_are_not() {
    let mut random = Random::new(73);
    let settings =
        Settings { time_limit: Some(Duration::from_secs(2)), max_iterations: 25, ..Settings::discrete() };
    let (mut solved, mut open, mut refused, mut disputed) = (0, 0, 0, 0);
    let count = std::env::var("RANDOM_MANEUVERS").map_or(400, |count| count.parse().unwrap());
    for case in 0..count {
        let Some(problem) = corner(&mut random) else { continue };
        let began = Instant::now();
        let planned = plan(&problem, &settings, None, &mut StopsAfter(1000));
        assert!(began.elapsed() < Duration::from_secs(20), "case {case} took {:?}", began.elapsed());
        match planned {
            Err(_) => refused += 1,
            Ok(plan) => match plan.status {
                Status::Solved => {
                    solved += 1;
                    assert!(plan.solution.terminal.largest() <= 1e-12, "case {case}");
                    assert!(plan.solution.cost.is_finite() && plan.solution.cost >= 0.0, "case {case}");
                    let verification = plan.verification.unwrap();
                    assert!(verification.discrete_attitude_rad <= 1e-11, "case {case}");
                }
                Status::VerificationFailed => disputed += 1,
                _ => open += 1,
            },
        }
    }
    assert!(
        5 * solved > count,
        "of {count} solved {solved}, open {open}, refused {refused}, disputed {disputed}"
    );
}

/// Raises its flag as soon as the search begins, and stops it from the grid of the plan on.
struct StopsOnTheGrid(Arc<AtomicBool>);

impl Observer for StopsOnTheGrid {
    fn on_progress(&mut self, progress: &Progress) -> Control {
        self.0.store(true, Ordering::Relaxed);
        if progress.rung == Rung::Aligned { Control::Stop } else { Control::Continue }
    }

    fn stop_flag(&self) -> Option<Arc<AtomicBool>> {
        Some(self.0.clone())
    }
}

/// The sweeps over the grid of a plan of least time poll the flag: on a million steps they need
/// many seconds.
#[test]
fn a_stop_is_heard_on_the_grid_of_a_plan_that_switches() {
    let problem = moving().with_steps(20_000);
    let mut observer = StopsOnTheGrid(Arc::default());
    let found = solve(&problem, &Settings::discrete(), None, &mut observer).unwrap();
    assert_eq!(found.outcome, Outcome::Interrupted);
    assert!(found.trajectory.time.len() <= 1, "{} nodes", found.trajectory.time.len());
}
