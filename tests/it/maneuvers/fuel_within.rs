//! Minimum fuel within cones, rate limits, limits of how fast torques change, and wheels: another
//! program on the same grid, closed forms and laws.

use super::minimum_fuel::{ball, thrusters};
use super::minimum_time::{CUBE, at, body, solved, torques};
use super::shortest::{GAP, cone, limited, rate, takes_no_guess_and_no_shooting, turn, wheeled};
use slewkit::maneuver::{Duration, Fuel, Method, Objective, Problem, Rule, Settings, Side};
use slewkit::mechanics::Limits;
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Matrix3, Vector3};

const MOMENTS: [f64; 3] = [1.0, 2.0, 3.0];

/// Returns a burn from rest at the identity, with torques of at most 1 N·m about each principal
/// axis, on 50 steps.
fn burn(moments: [f64; 3], axis: [f64; 3], degrees: f64, duration: f64) -> Problem {
    let start = slewkit::maneuver::State::at_rest(Matrix3::identity());
    Problem::minimum_fuel(body(moments), start, turn(axis, degrees), duration)
        .with_actuation(torques(&CUBE, &[1.0; 3]))
        .with_steps(50)
}

fn sun(problem: Problem) -> Problem {
    cone(problem, Side::KeepOut, [1.0, 0.0, 0.0], [0.5, 0.75f64.sqrt(), 0.1], 20.0)
}

fn priced(problem: Problem, price: f64) -> Problem {
    let fuel = Fuel { time_price: Some(price), ..Fuel::default() };
    problem.with_objective(Objective::Fuel(fuel)).with_duration(Duration::SOUGHT)
}

fn changing_slowly(limit: f64) -> Limits {
    Limits { size: Some(vec![1.0; 3]), rate: Some(vec![limit; 3]), ..Limits::default() }
}

/// Cases, and their fuel by another program on the same grid: Lie–Verlet steps in quaternions,
/// states, Cayley vectors and inputs in one sparse program, fuel by inputs split in two, cones at
/// 9 to 33 places of each arc; CasADi 3.8.2 and IPOPT without relaxed bounds, to 1e-10, the lowest
/// of its starts.
fn cases() -> Vec<(&'static str, Problem, f64)> {
    let oblique = |duration| burn(MOMENTS, [1.0, 2.0, 3.0], 120.0, duration);
    let both = Limits { size: Some(vec![1.0; 3]), norm: Some(1.3), ..Limits::default() };
    let about_z = |moments, duration| burn(moments, [0.0, 0.0, 1.0], 120.0, duration);
    let shaken = sun(limited(about_z(MOMENTS, 7.0), changing_slowly(2.0)));
    let tilted = burn(MOMENTS, [0.0, 1.0, 0.0], 100.0, 6.0).with_actuation(ball(1.0));
    let kept = burn(MOMENTS, [1.0, 2.0, -1.0], 90.0, 5.0);
    let mut moving = burn(MOMENTS, [1.0, 2.0, 3.0], 80.0, 8.0);
    moving.start = at([0.0; 3], [0.03, -0.02, 0.04]);
    moving.end.angular_velocity = Vector3::new(-0.02, 0.05, 0.01);
    let canted = [[0.8, 0.6, 0.5], [0.8, 0.6, -0.5], [0.8, -0.6, 0.5], [0.8, -0.6, -0.5]];
    let canted = canted.map(|axis| Vector3::from(axis).normalize().into());
    let jets = burn([2.2, 1.6, 1.1], [1.0, 0.5, -0.7], 130.0, 7.0).with_actuation(thrusters(&canted, 0.6));
    vec![
        ("torque rate", limited(oblique(5.0), changing_slowly(1.0)), 3.824741955),
        ("keep out", sun(about_z([1.0, 2.0, 2.9], 8.0)), 2.138923497),
        ("keep in", cone(kept, Side::KeepIn, [0.0, 0.0, 1.0], [0.3, -0.3, 1.0], 60.0), 2.157775527),
        ("size and norm", limited(oblique(5.0), both), 3.743734068),
        ("wheels", wheeled(oblique(7.0), [0.0; 3], [0.6, 0.8, 1.0]), 2.454926763),
        ("wheels that turn", wheeled(oblique(7.0), [0.3, -0.2, 0.1], [0.8, 0.9, 1.2]), 2.290339348),
        (
            "norm and cone",
            cone(tilted, Side::KeepOut, [0.0, 0.0, 1.0], [0.75, 0.15, 0.64], 15.0),
            1.405963232,
        ),
        ("moving ends and rate", rate(moving, Rule::RateNorm(0.25)), 1.078480831),
        (
            "thrusters and cone",
            cone(jets, Side::KeepOut, [1.0, 0.0, 0.0], [0.2, 0.3, 0.9], 20.0),
            1.506011072,
        ),
        ("cone, rate and torque rate", rate(shaken, Rule::RateNorm(0.6)), 2.613718911),
        ("price of time and rate", priced(rate(oblique(7.0), Rule::RateNorm(0.5)), 0.3), 4.393185042),
        ("price of time and cone", priced(sun(about_z([1.0, 2.0, 2.9], 8.0)), 0.2), 3.648443601),
    ]
}

/// Returns the fuel on equal steps, also if no constraint is active.
fn fuel(problem: &Problem) -> f64 {
    let plan = solved(&problem.clone().planned_by(Method::InteriorPoint));
    // The extremal that the plan stands for is reported if every sign is right.
    assert!(plan.solution.switching.is_none_or(|told| told.gap <= GAP * told.continuous_cost));
    let work = plan.solution.interior.expect("planned by the interior point");
    assert!(work.starts > 0 && work.iterations > 0 && work.gap < 1e-8, "{work:?}");
    plan.solution.cost
}

#[test]
fn fuel_is_that_of_another_program_on_the_same_grid() {
    for (name, problem, reference) in cases() {
        let off = fuel(&problem) / reference - 1.0;
        assert!(off.abs() < 1e-6, "{name}: {off:.1e}");
    }
}

/// The rates about axes are at their limits for most of the way.
#[test]
fn fuel_along_limits_of_the_rates_is_that_of_another_program() {
    let problem = burn(MOMENTS, [1.0, 2.0, 3.0], 120.0, 7.0);
    let along = fuel(&rate(problem, Rule::RateAxes(Vector3::new(0.12, 0.2, 0.4)))) / 2.639200269 - 1.0;
    assert!(along.abs() < 1e-6, "{along:.1e}");
}

/// About one axis the wheel, or the body, has at most the momentum `L`. It is given and taken
/// again, so the fuel is `2 L` in any duration.
#[test]
fn a_full_wheel_is_filled_and_emptied_once() {
    let sphere = burn([1.0; 3], [0.0, 0.0, 1.0], 120.0, 6.0);
    // 120° in 6 s at 1 N·m: a trapezoid of the rate, ω (6 − ω) = 2π/3.
    let angle = 120f64.to_radians();
    let fastest = 3.0 - (9.0 - angle).sqrt();
    let used = fuel(&wheeled(sphere.clone(), [0.0; 3], [1e-3, 1e-3, 2.0]));
    assert!((used / (2.0 * fastest) - 1.0).abs() < 1e-3, "{used} {fastest}");
    // A rate limit that just suffices costs no more fuel.
    let limited = fuel(&rate(sphere, Rule::RateNorm(1.01 * fastest)));
    assert!((limited / used - 1.0).abs() < 1e-3, "{limited} {used}");
}

#[test]
fn what_limits_more_burns_more_and_what_does_not_act_as_much() {
    let free = burn(MOMENTS, [0.0, 0.0, 1.0], 120.0, 6.0);
    let bare = solved(&free).solution.switching.expect("arcs").continuous_cost;
    let loose = fuel(&rate(free.clone(), Rule::RateNorm(10.0)));
    assert!((loose / bare - 1.0).abs() < 2e-3, "{loose} {bare}");
    let around = fuel(&sun(rate(free.clone(), Rule::RateNorm(10.0))));
    let slower = fuel(&limited(sun(free), changing_slowly(1.0)));
    assert!(loose < around && around < slower, "{loose} {around} {slower}");
}

#[test]
fn a_price_goes_through_to_the_cost() {
    let (_, problem, reference) = cases().swap_remove(4);
    let dear = Fuel { prices: Some(vec![3.0; 3]), ..Fuel::default() };
    let cost = fuel(&problem.with_objective(Objective::Fuel(dear)));
    assert!((cost / (3.0 * reference) - 1.0).abs() < 1e-6, "{cost}");
}

/// More time from rest to rest burns less, so all of it is used. It is not, if the price exceeds
/// the gain.
#[test]
fn up_to_a_longest_duration_all_of_it_or_what_is_worth_its_price() {
    let (_, problem, reference) = cases().swap_remove(6);
    let all = solved(&problem.clone().with_duration_at_most(6.0));
    assert!((all.solution.cost / reference - 1.0).abs() < 1e-6, "{}", all.solution.cost);
    assert_eq!(all.solution.duration(&problem), 6.0);
    let (_, sought, reference) = cases().pop().expect("cases");
    let bounded = sought.with_duration_at_most(20.0);
    let chosen = solved(&bounded);
    assert!((chosen.solution.cost / reference - 1.0).abs() < 1e-6, "{}", chosen.solution.cost);
}

#[test]
fn too_short_a_duration_is_answered_by_the_shortest_found() {
    let hasty = sun(burn(MOMENTS, [0.0, 0.0, 1.0], 120.0, 3.9));
    let missed = plan(&hasty, &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!(missed.status, Status::NotConverged);
    // The shortest of the same maneuver by another program is 4.033261 s (`shortest`).
    let found = missed.solution.shortest.expect("a duration");
    assert!((found / 4.033261 - 1.0).abs() < 1.6e-3, "{found}");
    let longer = missed.solution.longer.expect("a longer one");
    assert!(longer >= found);
    solved(&hasty.with_duration(longer));
}

#[test]
fn it_is_planned_on_equal_steps_from_its_own_seeds() {
    let (_, problem, _) = cases().swap_remove(0);
    takes_no_guess_and_no_shooting(&problem);
    let resting = Problem { end: problem.start, ..problem };
    assert_eq!(solved(&resting).solution.cost, 0.0);
}
