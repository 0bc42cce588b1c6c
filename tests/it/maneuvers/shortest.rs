//! Minimum time within cones, rate limits, limits of torque rates, and wheels: another program,
//! closed forms and laws. The duration on a grid without nodes at the switches has an error of
//! `O(h²)`, and jumps a little from grid to grid.

use super::minimum_time::{CUBE, at, body, solved, torques};
use slewkit::maneuver::problem::{Problem, State};
use slewkit::maneuver::{Constraint, Direction, Method, Objective, Pointing, Rule, Settings, Side};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use slewkit::plan::{Guess, Plan, PlanError, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};

/// The largest gap of arcs with the right signs, as a part of their cost: the error of differences
/// of the flow and of the integral.
pub(super) const GAP: f64 = 1e-9;

pub(super) fn turn(axis: [f64; 3], degrees: f64) -> State {
    State::at_rest(lie::exp(&(Vector3::from(axis).normalize() * degrees.to_radians())))
}

/// Returns a slew from rest at the identity, with torques of at most 1 N·m about each principal
/// axis.
fn slew(moments: [f64; 3], end: State) -> Problem {
    Problem::minimum_time(body(moments), State::at_rest(Matrix3::identity()), end)
        .with_actuation(torques(&CUBE, &[1.0; 3]))
}

/// Checks that a maneuver which SCP plans from its own seeds refuses the shooting, and costates as
/// a guess.
pub(super) fn takes_no_guess_and_no_shooting(problem: &Problem) {
    let shooting = Settings { method: Method::Shooting, ..Settings::discrete() };
    let refused = plan(problem, &shooting, None, &mut Silent).unwrap_err();
    assert!(matches!(refused, PlanError::NotForShooting { .. }), "{refused}");
    let guess = Guess::costates(&[0.0; 6]);
    let refused = plan(problem, &Settings::discrete(), Some(&guess), &mut Silent).unwrap_err();
    assert!(matches!(refused, PlanError::Unsuited(_)), "{refused}");
}

pub(super) fn limited(problem: Problem, limits: Limits) -> Problem {
    let torque = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    problem.with_actuation(Actuation::torques(torque))
}

pub(super) fn cone(
    problem: Problem,
    side: Side,
    boresight: [f64; 3],
    direction: [f64; 3],
    degrees: f64,
) -> Problem {
    let direction = Direction::Fixed(Vector3::from(direction).normalize());
    let (boresights, half_angle) = (vec![boresight.into()], degrees.to_radians());
    let rule = Rule::Pointing(Pointing::new(side, boresights, vec![direction], half_angle));
    let name = format!("cone {}", problem.constraints.len() + 1);
    problem.with_constraint(Constraint { name, rule })
}

pub(super) fn rate(problem: Problem, rule: Rule) -> Problem {
    problem.with_constraint(Constraint { name: "rate".into(), rule })
}

pub(super) fn wheeled(mut problem: Problem, momentum: [f64; 3], momentum_limit: [f64; 3]) -> Problem {
    let (momentum, momentum_limit) = (momentum.to_vec(), momentum_limit.to_vec());
    problem.actuation.wheels = Some(Wheels { momentum, momentum_limit });
    problem
}

fn duration(problem: &Problem, steps: usize) -> f64 {
    let plan = solved(&problem.clone().with_steps(steps));
    let duration = plan.solution.duration(problem);
    assert_eq!(plan.solution.cost, duration);
    // The extremal that the plan stands for is reported if every sign is right.
    assert!(plan.solution.switching.is_none_or(|told| told.gap <= GAP * told.continuous_cost));
    duration
}

/// Returns the cases, and their durations [s] by another program: direct multiple shooting with
/// CasADi 3.8.2 and IPOPT. It uses quaternions, the Runge–Kutta method of order 4, and inputs that
/// are constant (or linear, under a limit of their slope) on each interval. The duration is the
/// lowest of ten starts, extrapolated from the two finest grids (160 and 320 intervals, or 192 and
/// 384).
fn cases() -> Vec<(&'static str, Problem, f64)> {
    const MOMENTS: [f64; 3] = [1.0, 2.0, 3.0];
    let free = || slew(MOMENTS, turn([1.0, 2.0, 3.0], 120.0));
    let about_z = |moments| slew(moments, turn([0.0, 0.0, 1.0], 120.0));
    let sun = |problem| cone(problem, Side::KeepOut, [1.0, 0.0, 0.0], [0.5, 0.75f64.sqrt(), 0.1], 20.0);
    let jerk =
        |limit: f64| Limits { size: Some(vec![1.0; 3]), rate: Some(vec![limit; 3]), ..Limits::default() };
    let (start, end) = (at([0.2, 0.1, -0.3], [0.03, -0.02, 0.04]), at([0.9, -0.4, 0.6], [-0.02, 0.05, 0.01]));
    let uneven = |problem: Problem| problem.with_actuation(torques(&CUBE, &[1.0, 1.2, 0.8]));
    let moving = uneven(Problem::minimum_time(body(MOMENTS), start, end));
    let both = Limits { size: Some(vec![1.0; 3]), norm: Some(1.3), ..Limits::default() };
    let norm = Limits { norm: Some(1.0), ..Limits::default() };
    let shaken = rate(sun(limited(about_z(MOMENTS), jerk(2.0))), Rule::RateNorm(0.6));
    let tilted = limited(slew(MOMENTS, turn([0.0, 1.0, 0.0], 100.0)), norm);
    let kept = uneven(slew(MOMENTS, turn([1.0, 2.0, -1.0], 90.0)));
    vec![
        ("rate", rate(free(), Rule::RateNorm(0.5)), 4.977390),
        ("rates about axes", rate(free(), Rule::RateAxes(Vector3::new(0.3, 0.4, 0.5))), 4.399033),
        ("torque rate", limited(free(), jerk(1.0)), 3.827295),
        ("keep out", sun(about_z(MOMENTS)), 4.033261),
        ("keep in", cone(kept, Side::KeepIn, [0.0, 0.0, 1.0], [0.3, -0.3, 1.0], 60.0), 2.933867),
        ("size and norm", limited(free(), both), 3.890717),
        ("wheels", wheeled(free(), [0.0; 3], [0.6, 0.8, 1.0]), 4.764304),
        ("wheels that turn", wheeled(free(), [0.3, -0.2, 0.1], [0.8, 0.9, 1.2]), 4.422228),
        ("moving ends and rate", rate(moving, Rule::RateNorm(0.25)), 5.234943),
        (
            "two cones",
            cone(sun(about_z([1.0; 3])), Side::KeepOut, [0.0, 0.0, 1.0], [0.2, 0.4, 0.9], 15.0),
            2.752362,
        ),
        ("norm and cone", cone(tilted, Side::KeepOut, [0.0, 0.0, 1.0], [0.75, 0.15, 0.64], 15.0), 3.748324),
        ("cone, rate and torque rate", shaken, 5.061953),
    ]
}

#[test]
fn durations_on_a_coarse_grid_are_those_of_another_program() {
    for (name, problem, reference) in cases() {
        let off = duration(&problem, 50) / reference - 1.0;
        assert!(off.abs() < 1.6e-3, "{name}: {off:.1e}");
    }
}

#[test]
fn arcs_past_cones_last_as_long_as_another_program_says_whatever_the_grid() {
    for (name, problem, reference) in
        cases().into_iter().filter(|case| ["keep out", "keep in"].contains(&case.0))
    {
        let [coarse, fine] = [80, 120].map(|steps| {
            let told = solved(&problem.clone().with_steps(steps)).solution.switching;
            told.unwrap_or_else(|| panic!("{name}: no arcs on {steps} steps")).continuous_duration_s
        });
        assert!((coarse / fine - 1.0).abs() < 1e-9, "{name}: {coarse} and {fine}");
        let off = fine / reference - 1.0;
        assert!(off.abs() < 2e-5, "{name}: {off:.1e}");
    }
}

#[test]
fn on_twice_the_steps_they_are_off_by_a_quarter() {
    let converging = ["torque rate", "keep out", "size and norm", "norm and cone", "moving ends and rate"];
    for (name, problem, reference) in cases().into_iter().filter(|case| converging.contains(&case.0)) {
        let off = duration(&problem, 100) / reference - 1.0;
        assert!(off.abs() < 3e-4, "{name}: {off:.1e}");
    }
}

/// The scheme's error falls to a sixteenth on four times the steps, more or less by where switches
/// are between nodes. The plan of the fine grid is the plan of the arcs, and not a costlier one
/// near it.
#[test]
fn plans_of_fine_grids_are_those_of_their_arcs() {
    let slowly = Limits {
        size: Some(vec![1.49, 1.21, 1.18]),
        rate: Some(vec![2.48, 2.01, 1.97]),
        ..Limits::default()
    };
    let slow = limited(slew([3.49, 4.54, 3.33], turn([-0.64, -0.16, 0.75], 60.0)), slowly);
    let cones = cases().into_iter().filter(|case| ["keep out", "keep in"].contains(&case.0));
    for (name, problem) in cones.map(|(name, problem, _)| (name, problem)).chain([("slow torques", slow)]) {
        let [coarse, fine] = [100, 400].map(|steps| {
            let Plan { solution, .. } = solved(&problem.clone().with_steps(steps));
            let told = solution.switching.unwrap_or_else(|| panic!("{name}: no arcs on {steps} steps"));
            (solution.cost / told.continuous_cost - 1.0).abs()
        });
        assert!(coarse < 2e-3 && fine < coarse / 8.0, "{name}: off by {coarse:.1e} and {fine:.1e}");
    }
}

/// About one axis: to full rate, on, and to rest. With a ball of torques and a sphere as body, no
/// turn away from the axis is quicker.
#[test]
fn a_sphere_speeds_up_coasts_and_brakes() {
    let (angle, fastest) = (120f64.to_radians(), 0.5);
    let ball = Limits { norm: Some(1.0), ..Limits::default() };
    let sphere = limited(slew([1.0; 3], turn([1.0, 2.0, 3.0], 120.0)), ball);
    let off = duration(&rate(sphere, Rule::RateNorm(fastest)), 60) / (angle / fastest + fastest) - 1.0;
    assert!(off.abs() < 1e-3, "{off:.1e}");
}

/// The duration of this slew in continuous time is the closed form. The estimate from two grids is
/// as near to it as its error states, and far nearer than the duration on the grid.
#[test]
fn the_duration_in_continuous_time_is_estimated_from_two_grids() {
    let (angle, fastest) = (120f64.to_radians(), 0.5);
    let ball = Limits { norm: Some(1.0), ..Limits::default() };
    let sphere = limited(slew([1.0; 3], turn([1.0, 2.0, 3.0], 120.0)), ball);
    let problem = rate(sphere, Rule::RateNorm(fastest));
    let truth = angle / fastest + fastest;
    for steps in [30_u32, 45, 60, 100, 151] {
        let found =
            plan(&problem.clone().with_steps(steps as usize), &Settings::default(), None, &mut Silent);
        let found = found.expect("a plan").solution;
        let estimate = found.interior.as_ref().and_then(|work| work.continuous).expect("an estimate");
        let off = (estimate.cost - truth).abs();
        let second_order = 20.0 / f64::from(steps).powi(2) * truth;
        assert!(off <= estimate.error && estimate.error < second_order, "{steps}: {off:.1e} {estimate:?}");
    }
}

/// The momentum of the wheel is the rate of the body. The other wheels can store hardly any
/// momentum.
#[test]
fn a_wheel_fills_stays_full_and_is_emptied() {
    let (angle, most) = (120f64.to_radians(), 0.5);
    let sphere = slew([1.0; 3], turn([0.0, 0.0, 1.0], 120.0));
    let off = duration(&wheeled(sphere, [0.0; 3], [1e-3, 1e-3, most]), 60) / (angle / most + most) - 1.0;
    assert!(off.abs() < 1.5e-3, "{off:.1e}");
}

/// Full torque for t, the change from +U to −U at the slope j in r = 2U/j, and full torque for t: θ
/// = U t² + U t r + ⅔ U³/j². The other axes may have hardly any rate.
#[test]
fn a_torque_turns_round_as_fast_as_it_may() {
    let angle = 120f64.to_radians();
    let limits = Limits { size: Some(vec![1.0; 3]), rate: Some(vec![1.0; 3]), ..Limits::default() };
    let problem = limited(slew([1.0; 3], turn([0.0, 0.0, 1.0], 120.0)), limits);
    let full = (angle + 1.0 / 3.0).sqrt() - 1.0;
    let alone = Rule::RateAxes(Vector3::new(1e-3, 1e-3, 10.0));
    let off = duration(&rate(problem, alone), 60) / (2.0 * full + 2.0) - 1.0;
    assert!(off.abs() < 5e-4, "{off:.1e}");
}

#[test]
fn what_limits_more_takes_longer_and_what_does_not_act_as_long() {
    let free = || slew([1.0, 2.0, 3.0], turn([0.0, 0.0, 1.0], 120.0));
    let loose = duration(&rate(free(), Rule::RateNorm(10.0)), 60);
    let unlimited = solved(&free()).solution.switching.expect("arcs").continuous_duration_s;
    assert!((loose / unlimited - 1.0).abs() < 5e-4, "{loose} {unlimited}");
    let tight = rate(free(), Rule::RateNorm(0.6));
    let around = cone(tight.clone(), Side::KeepOut, [1.0, 0.0, 0.0], [0.5, 0.75f64.sqrt(), 0.1], 20.0);
    // A cone that does not touch the way changes the cost only by round-off.
    let durations = [loose, duration(&tight, 60), duration(&around, 60)];
    assert!(durations.windows(2).all(|pair| pair[1] > pair[0] * (1.0 - 1e-9)), "{durations:?}");
}

/// Returns the largest rate at the nodes of a plan [rad/s].
fn peak(plan: &Plan) -> f64 {
    plan.solution.trajectory.angular_velocity.iter().map(Vector3::norm).fold(0.0, f64::max)
}

#[test]
fn a_limit_that_does_not_act_leaves_the_arcs_of_the_turn_without_it() {
    for (end, duration) in [(turn([1.0, 2.0, 3.0], 120.0), None), (turn([3.0, -1.0, 2.0], 75.0), Some(6.0))] {
        let free = slew([1.0, 2.0, 3.0], end);
        let free = match duration {
            None => free,
            Some(duration) => Problem::minimum_fuel(free.body, free.start, free.end, duration)
                .with_actuation(free.actuation),
        };
        let alone = solved(&free);
        let within = |share: f64| solved(&rate(free.clone(), Rule::RateNorm(share * peak(&alone))));
        let loose = within(1.001);
        assert_eq!(loose.solution.trajectory, alone.solution.trajectory);
        assert_eq!(loose.solution.switching, alone.solution.switching);
        if duration.is_some() {
            continue;
        }
        let tight = within(0.9);
        assert!(tight.solution.cost > alone.solution.cost * (1.0 + 1e-4), "{}", tight.solution.cost);
        // The plan is on equal steps, and never beyond the limit.
        assert!(
            tight.solution.method == Method::InteriorPoint
                && peak(&tight) <= 0.9 * peak(&alone) * (1.0 + 1e-9)
        );
    }
}

/// Gains need steps of one length, so plans with gains have equal steps.
#[test]
fn what_is_asked_for_on_equal_steps_stays_on_them_though_its_limit_does_not_act() {
    let free = slew([1.0, 2.0, 3.0], turn([1.0, 2.0, 3.0], 120.0));
    let alone = solved(&free);
    let loose = rate(free, Rule::RateNorm(1.001 * peak(&alone))).planned_by(Method::InteriorPoint);
    let equal = solved(&loose);
    assert_eq!(equal.solution.method, Method::InteriorPoint);
    let time = &equal.solution.trajectory.time;
    let step = time[time.len() - 1] / (time.len() - 1) as f64;
    assert!(time.windows(2).all(|pair| ((pair[1] - pair[0]) / step - 1.0).abs() < 1e-9));
    // Inputs on steps that hold a switch lie between their limits: of the second order in the step.
    let (found, least) = (equal.solution.cost, alone.solution.cost);
    assert!((found / least - 1.0).abs() < 2e-3, "{found} {least}");
}

#[test]
fn of_mirror_images_that_last_as_long_the_one_beside_the_cone_is_the_answer() {
    // A sphere turns about an axis of its torques faster on a path near this axis, on either side.
    let free = slew([1.0; 3], turn([0.0, 0.0, 1.0], 135.0));
    let alone = solved(&free);
    let middle = |plan: &Plan| {
        let nodes = &plan.solution.trajectory.quaternion;
        lie::rotation_from_quaternion(&nodes[nodes.len() / 2]) * Vector3::z()
    };
    let bent = middle(&alone);
    assert!(bent.z < 0.99, "{bent}");
    let around = cone(free, Side::KeepOut, [0.0, 0.0, 1.0], bent.into(), 5.0);
    let beside = solved(&around);
    assert!((beside.solution.cost / alone.solution.cost - 1.0).abs() < 1e-9, "{}", beside.solution.cost);
    assert!(middle(&beside).angle(&bent) > 5.0_f64.to_radians());
    assert_eq!(beside.solution.method, Method::Shooting);
}

#[test]
fn a_limited_maneuver_takes_as_long_backwards() {
    let (_, forward, _) = cases().swap_remove(8);
    let reversed = |state: &State| State { angular_velocity: -state.angular_velocity, ..*state };
    let backward =
        Problem { start: reversed(&forward.end), end: reversed(&forward.start), ..forward.clone() };
    let (there, back) = (duration(&forward, 60), duration(&backward, 60));
    assert!((there / back - 1.0).abs() < 1e-9, "{there} {back}");
}

#[test]
fn too_short_a_duration_is_answered_by_the_shortest_found() {
    let (_, problem, shortest) = cases().swap_remove(3);
    let hasty = Problem { objective: Objective::default(), duration: 3.9.into(), ..problem.with_steps(60) };
    let missed = plan(&hasty, &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!(missed.status, Status::NotConverged);
    let found = missed.solution.shortest.expect("a duration");
    assert!((found / shortest - 1.0).abs() < 5e-4, "{found}");
    let told = missed.solution.shortfall.expect("a cause").to_string();
    assert!(told.contains("no plan of 3.9 s was found, the shortest duration found is 4.03"), "{told}");
    let longer = missed.solution.longer.expect("a longer one");
    assert!(longer >= found);
    solved(&hasty.with_duration(longer));
}

#[test]
fn the_shortest_is_sought_on_equal_steps_from_its_own_seeds() {
    let (_, problem, _) = cases().swap_remove(0);
    takes_no_guess_and_no_shooting(&problem);
    let limit = Settings { time_limit: Some(std::time::Duration::from_millis(1)), ..Settings::discrete() };
    let stopped = plan(&problem, &limit, None, &mut Silent).unwrap();
    assert_eq!(stopped.status, Status::LimitReached);
    let settled = Problem { end: problem.start, ..problem };
    assert_eq!(solved(&settled).solution.duration(&settled), 0.0);
}
