//! Least effort with a sought duration, within cones, rate limits and wheels, and where limits
//! allow no shorter duration.

use super::minimum_time::{CUBE, at, body, solved, torques};
use super::shortest::{cone, rate, turn, wheeled};
use slewkit::Matrix3;
use slewkit::maneuver::{Duration, Objective, Problem, Rule, Side, State, Weights};

fn priced(problem: Problem, price: f64) -> Problem {
    problem.with_objective(Weights { time_price: Some(price), ..Weights::default() })
}

/// Returns a slew from rest at the identity, with torques of at most 1 N·m about each principal
/// axis, on 50 steps.
fn slew(moments: [f64; 3], axis: [f64; 3], degrees: f64) -> Problem {
    let start = State::at_rest(Matrix3::identity());
    Problem::attitude(body(moments), start, turn(axis, degrees), Duration::SOUGHT)
        .with_actuation(torques(&CUBE, &[1.0; 3]))
        .with_steps(50)
}

fn sun(problem: Problem) -> Problem {
    cone(problem, Side::KeepOut, [1.0, 0.0, 0.0], [0.5, 0.75f64.sqrt(), 0.1], 20.0)
}

fn duration(problem: &Problem) -> f64 {
    *solved(problem).solution.trajectory.time.last().expect("a duration")
}

/// Costs by another program on the same grid: Lie–Verlet steps in quaternions, states, Cayley
/// vectors, inputs and the duration in one sparse program, cones at 25 places of each arc; CasADi
/// 3.8.2 and IPOPT without relaxed bounds, to 1e-10, around the cone the lowest of eight starts.
#[test]
fn costs_are_those_of_another_program_on_the_same_grid() {
    let oblique = || slew([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], 120.0);
    let cases = [
        ("rate", priced(rate(oblique(), Rule::RateNorm(0.3)), 0.3), 2.868656875),
        ("keep out", priced(sun(slew([1.0, 2.0, 2.9], [0.0, 0.0, 1.0], 120.0)), 0.2), 2.038268502),
        ("wheels", priced(wheeled(oblique(), [0.3, -0.2, 0.1], [0.8, 0.9, 1.2]), 0.5), 3.595694040),
    ];
    for (name, problem, reference) in cases {
        let off = solved(&problem).solution.cost / reference - 1.0;
        assert!(off.abs() < 1e-6, "{name}: {off:.1e}");
    }
}

/// A constraint that is never active does not change the result. The search without constraints is
/// another method: it uses the mean of the Hamiltonians.
#[test]
fn a_limit_that_never_acts_changes_nothing() {
    let free = priced(slew([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], 120.0), 0.05);
    let bare = solved(&free);
    let loose = solved(&rate(free, Rule::RateNorm(10.0)));
    let apart = |a: f64, b: f64| (a / b - 1.0).abs();
    assert!(apart(loose.solution.cost, bare.solution.cost) < 1e-10, "{}", loose.solution.cost);
    let [a, b] = [&loose, &bare].map(|plan| plan.solution.trajectory.time[50]);
    assert!(apart(a, b) < 1e-9, "{a} {b}");
}

/// A maneuver from rest to rest uses all of the time, and less if a second costs more than it
/// saves.
#[test]
fn up_to_a_longest_duration() {
    let problem = sun(slew([1.0, 2.0, 2.9], [0.0, 0.0, 1.0], 120.0));
    let given = solved(&problem.clone().with_duration(9.0));
    let bounded = solved(&problem.clone().with_duration_at_most(9.0));
    assert_eq!(given.solution.cost, bounded.solution.cost);
    let free = priced(problem, 0.2);
    let chosen = duration(&free);
    assert!((duration(&free.clone().with_duration_at_most(2.0 * chosen)) / chosen - 1.0).abs() < 1e-9);
    let short = 0.8 * chosen;
    assert!((duration(&free.with_duration_at_most(short)) / short - 1.0).abs() < 1e-12);
}

/// At a very high price only time matters: the plan takes hardly longer than the shortest, which is
/// `2 √(φ J/u)` about one axis of a sphere by the bound of the norm.
#[test]
fn a_price_too_high_is_paid_at_the_shortest() {
    let limits = slewkit::mechanics::Limits { norm: Some(1.0), ..Default::default() };
    let ends = [at([0.0; 3], [0.0; 3]), at([0.0, 0.0, 1.2], [0.0; 3])];
    let sphere = Problem::attitude(body([1.0; 3]), ends[0], ends[1], Duration::SOUGHT).with_steps(60);
    let limited = super::shortest::limited(sphere, limits);
    let quickest = solved(&limited.clone().with_objective(Objective::Time).with_steps(60));
    let plan = solved(&priced(limited, 1e5));
    let [found, shortest] = [plan.solution.trajectory.time[60], 2.0 * 1.2f64.sqrt()];
    assert!(found > shortest * (1.0 - 2e-3) && found < 1.001 * shortest, "{found} {shortest}");
    let time = quickest.solution.trajectory.time.last().unwrap();
    assert!(found > time * (1.0 - 1e-3), "{found} {time}");
    let effort = plan.solution.cost - 1e5 * found;
    // The torque of the shortest duration is full all the time: ½ u² T.
    assert!((effort / (0.5 * found) - 1.0).abs() < 0.1, "{effort}");
}
