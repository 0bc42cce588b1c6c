//! Minimum fuel by pulses of a shortest length, through the public interface: closed forms, laws of
//! every plan, and honesty.

use super::minimum_fuel::thrusters;
use super::minimum_time::{CUBE, at, body, moving, solved, torques};
use evidence::Random;
use slewkit::maneuver::solution::Trajectory;
use slewkit::maneuver::{Duration, Fuel, Objective, Outcome, Problem, Settings, State, Structure, Switching};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
use slewkit::plan::{Silent, Status, plan};
use slewkit::verify::verify;
use slewkit::{Matrix3, Vector3, lie};
use slewkit_files::spec::{self, Format, SpecDocument};
use std::f64::consts::{FRAC_PI_2, PI};

/// Returns the maneuver with a shortest pulse.
fn pulsed(problem: &Problem, shortest: f64) -> Problem {
    let torque = problem.actuation.torque.clone();
    let limits = Limits { shortest_pulse: Some(shortest), ..torque.limits().clone() };
    problem.clone().with_actuation(Actuation::torques(torque.with_limits(limits).unwrap()))
}

/// Returns a quarter turn about a principal axis of moment 3 by a torque of 0.8.
fn quarter_turn(duration: f64) -> Problem {
    let end = at([0.0, 0.0, FRAC_PI_2], [0.0; 3]);
    Problem::minimum_fuel(body([2.0, 2.5, 3.0]), at([0.0; 3], [0.0; 3]), end, duration)
        .with_actuation(torques(&CUBE, &[1.0, 1.0, 0.8]))
}

/// Returns a maneuver of an asymmetric body between moving states.
fn moving_slowly() -> Problem {
    moving().with_objective(Objective::Fuel(Fuel::default())).with_duration(5.0)
}

/// Returns the times for which each input is on without a change, from the arcs.
fn lengths(switching: &Switching) -> Vec<f64> {
    let mut lengths = Vec::new();
    for input in 0..switching.arcs[0].input.len() {
        for run in switching.arcs.chunk_by(|a, b| a.input[input] == b.input[input]) {
            if run[0].input[input] != 0.0 {
                lengths.push(run[run.len() - 1].end_s - run[0].start_s);
            }
        }
    }
    lengths
}

/// Two burns of length `½ (T − √(T² − T_min²))` with `T_min = 2 √(jθ/U)` where that is no shorter
/// than a pulse may be, and of the shortest length d otherwise, which `jθ/(U d)` apart turn as far.
#[test]
fn a_turn_about_a_principal_axis_burns_as_the_closed_form_says() {
    let (limit, duration) = (0.8, 7.0);
    let shortest = 2.0 * (3.0 * FRAC_PI_2 / limit).sqrt();
    let natural = 0.5 * (duration - (duration * duration - shortest * shortest).sqrt());
    for (pulse, burn) in [(0.5, natural), (1.3, 1.3)] {
        let plan = solved(&pulsed(&quarter_turn(duration), pulse));
        let switching = plan.solution.switching.unwrap();
        assert_eq!(switching.structure, Structure::Pulses);
        let told = switching.pulses.unwrap();
        assert_eq!(told.count, 2);
        let closed = 2.0 * limit * burn;
        assert!((switching.continuous_cost / closed - 1.0).abs() < 1e-12, "{switching:?} {closed}");
        assert!((told.cost_without / (2.0 * limit * natural) - 1.0).abs() < 1e-9, "{told:?}");
        for length in lengths(&switching) {
            assert!((length / burn - 1.0).abs() < 1e-12, "{length} {burn}");
        }
        // Steps about one axis turn by 2 atan(hω/2): an error of second order in the step.
        assert!((plan.solution.cost / closed - 1.0).abs() < 1e-4, "{} {closed}", plan.solution.cost);
        assert!(told.shortest_s >= pulse * (1.0 - 1e-12), "{told:?}");
    }
}

/// Returns the same maneuver where a second has a price, in the best duration.
fn priced(problem: &Problem, price: f64) -> Problem {
    let fuel = Fuel { time_price: Some(price), ..Fuel::default() };
    problem.clone().with_duration(Duration::SOUGHT).with_objective(Objective::Fuel(fuel))
}

/// Two burns of length b that turn by `jθ = U b (T − b)` cost `2 U b + p T`: least at
/// `b² = p jθ/U / (2 U + p)`, or at the shortest length where that is longer.
#[test]
fn the_best_duration_of_pulses_is_that_of_the_closed_form() {
    let (limit, price, way) = (0.8, 0.3, 3.0 * FRAC_PI_2);
    let natural = (price * way / limit / (2.0 * limit + price)).sqrt();
    let cost = |burn: f64| 2.0 * limit * burn + price * (way / (limit * burn) + burn);
    for (pulse, burn) in [(0.5, natural), (1.3, 1.3)] {
        let plan = solved(&pulsed(&priced(&quarter_turn(7.0), price), pulse));
        assert!(plan.solution.optimality.stationarity < 1e-12);
        let switching = plan.solution.switching.unwrap();
        assert_eq!(switching.structure, Structure::Pulses);
        let told = switching.pulses.unwrap();
        assert!((switching.continuous_cost / cost(burn) - 1.0).abs() < 1e-11, "{switching:?} {}", cost(burn));
        assert!((told.cost_without / cost(natural) - 1.0).abs() < 1e-9, "{told:?}");
        let duration = way / (limit * burn) + burn;
        // Where no bound holds a burn the cost is flat in it: half of the digits.
        let digits = if burn > pulse { 1e-6 } else { 1e-11 };
        assert!(
            (switching.continuous_duration_s / duration - 1.0).abs() < digits,
            "{switching:?} {duration}"
        );
        for length in lengths(&switching) {
            assert!((length / burn - 1.0).abs() < digits, "{length} {burn}");
        }
        assert!((plan.solution.cost / cost(burn) - 1.0).abs() < 1e-4, "{}", plan.solution.cost);
    }
}

/// No given duration near the found one costs less, its price included. The duration of the grid
/// converges to it as the cost does.
#[test]
fn the_best_duration_of_pulses_is_the_best_of_those_given() {
    let (price, given) = (0.05, pulsed(&moving_slowly(), 0.3));
    let sought = priced(&given, price);
    let solution = |steps: usize| solved(&sought.clone().with_steps(steps)).solution;
    let [coarse, middle, fine] = [100, 400, 1600].map(solution);
    let found = fine.switching.as_ref().unwrap();
    for part in [0.97, 1.03] {
        let duration = part * found.continuous_duration_s;
        let other = solved(&given.clone().with_duration(duration)).solution.switching.unwrap();
        let cost = other.continuous_cost + price * duration;
        assert!(cost > found.continuous_cost, "{part}: {cost} {}", found.continuous_cost);
    }
    let duration = |solution: &slewkit::maneuver::Solution| *solution.trajectory.time.last().unwrap();
    // How steps are shared among arcs is not the same on every grid, and the duration feels that
    // first: so grids lie far apart.
    for (one, next) in [(&coarse, &middle), (&middle, &fine)] {
        let order = ((one.cost - found.continuous_cost) / (next.cost - found.continuous_cost)).log(4.0);
        assert!((order - 2.0).abs() < 0.2, "{order}: {} {}", one.cost, next.cost);
        let apart = [one, next].map(|solution| duration(solution) - found.continuous_duration_s);
        assert!(((apart[0] / apart[1]).log(4.0) - 2.0).abs() < 0.3, "{apart:?}");
    }
    assert!(fine.optimality.stationarity < 1e-12, "{}", fine.optimality.stationarity);
}

/// A bound that is too long for a body that moves: the best duration is shorter. One that is short
/// is used up.
#[test]
fn pulses_take_no_longer_than_a_bound() {
    let short = solved(&pulsed(&moving_slowly().with_duration_at_most(5.0), 0.3)).solution;
    let end = short.trajectory.time.last().unwrap();
    assert!(*end <= 5.0, "{end}");
    let given = solved(&pulsed(&moving_slowly(), 0.3)).solution;
    assert!(short.cost <= given.cost * (1.0 + 1e-12), "{} {}", short.cost, given.cost);
    let still = pulsed(&quarter_turn(7.0), 0.5);
    let [given, bounded] = [still.clone(), still.with_duration_at_most(7.0)].map(|p| solved(&p).solution);
    assert!((given.cost / bounded.cost - 1.0).abs() < 1e-12, "{} {}", given.cost, bounded.cost);
}

/// Returns the end of the arcs by Kutta's method, which the solver does not use.
fn replayed(problem: &Problem, switching: &Switching) -> (Matrix3, Vector3) {
    let j = *problem.body.inertia.j();
    let inverse = j.try_inverse().unwrap();
    let (mut r, mut w) = (problem.start.attitude, problem.start.angular_velocity);
    for arc in &switching.arcs {
        let torque = problem.actuation.torque.output(&arc.input);
        let rate = |r: &Matrix3, w: &Vector3| (r * lie::hat(w), inverse * ((j * w).cross(w) + torque));
        let steps = ((arc.end_s - arc.start_s) / switching.continuous_duration_s * 4000.0).ceil().max(1.0);
        let h = (arc.end_s - arc.start_s) / steps;
        for _ in 0..steps as usize {
            let a = rate(&r, &w);
            let b = rate(&(r + 0.5 * h * a.0), &(w + 0.5 * h * a.1));
            let c = rate(&(r + 0.5 * h * b.0), &(w + 0.5 * h * b.1));
            let d = rate(&(r + h * c.0), &(w + h * c.1));
            r += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
            w += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
        }
    }
    (r, w)
}

fn direction(random: &mut Random) -> Vector3 {
    // Uniform in the ball.
    loop {
        let vector = Vector3::from_fn(|_, _| random.uniform());
        if (0.01..1.0).contains(&vector.norm()) {
            return vector.normalize();
        }
    }
}

/// Returns a maneuver of a random body about a random axis, by three torques or by eight canted
/// thrusters.
fn case(random: &mut Random, canted: bool, moves: bool) -> Problem {
    let frame = lie::exp(&(direction(random) * random.within(0.0, PI)));
    let (a, b) = (random.within(1.0, 5.0), random.within(1.0, 5.0));
    let c = random.within((a - b).abs().max(1.0) + 0.1, (a + b).min(5.0));
    let inertia = frame * Matrix3::from_diagonal(&Vector3::new(a, b, c)) * frame.transpose();
    let body = Body { inertia: Inertia::new(0.5 * (inertia + inertia.transpose())).unwrap(), mass: None };
    let turn: f64 = random.within(0.3, 3.0);
    let mut rate = || if moves { direction(random) * 0.1 } else { Vector3::zeros() };
    let rates = [rate(), rate()];
    let end = State::attitude(lie::exp(&(direction(random) * turn)), rates[1]);
    let axes: Vec<Vector3> = if canted {
        let sign = |set: bool| if set { 1.0 } else { -1.0 };
        let corner = |k: u32| Vector3::new(sign(k & 1 > 0), sign(k & 2 > 0), sign(k & 4 > 0));
        let cant = |k: u32, random: &mut Random| {
            corner(k).component_mul(&Vector3::from_fn(|_, _| random.within(0.4, 1.0))).normalize()
        };
        (0..8).map(|k| cant(k, random)).collect()
    } else {
        CUBE.map(Vector3::from).to_vec()
    };
    let size = Some(axes.iter().map(|_| random.within(1.0, 2.0)).collect());
    let limits = Limits { size, one_sided: canted, ..Limits::default() };
    let torques = ActuatorSet::new(axes, AxisFrame::Body).unwrap().with_limits(limits).unwrap();
    // Somewhat more than the duration that the smallest torque about any axis needs.
    let duration = random.within(1.3, 2.5) * 2.0 * (5.0 * turn).sqrt();
    Problem::minimum_fuel(body, State::attitude(Matrix3::identity(), rates[0]), end, duration)
        .with_actuation(Actuation::torques(torques))
}

/// Every third of 12 random maneuvers has a sought duration. Their arcs lead to the end by another
/// integrator too, and no plan burns less than without a shortest pulse.
#[test]
fn random_maneuvers_have_pulses_that_lead_to_the_end() {
    let mut random = Random::new(7);
    let mut found = 0;
    for index in 0..12 {
        let problem = case(&mut random, index % 2 == 1, index % 4 > 1);
        let shortest = random.within(0.01, 0.08) * problem.seconds();
        let problem = pulsed(&problem, shortest);
        let problem = if index % 3 == 2 { priced(&problem, 0.3) } else { problem };
        let plan = plan(&problem, &Settings::discrete(), None, &mut Silent).unwrap();
        if plan.status != Status::Solved {
            println!("case {index}: {:?} {:?}", plan.status, plan.solution.shortfall);
            continue;
        }
        found += 1;
        let switching = plan.solution.switching.unwrap();
        let (r, w) = replayed(&problem, &switching);
        let off = lie::minus(&problem.end.attitude, &r).norm();
        assert!(off < 1e-9, "case {index}: {off:e}");
        let off = (w - problem.end.angular_velocity).norm();
        assert!(off < 1e-9, "case {index}: {off:e}");
        let least = lengths(&switching).into_iter().fold(f64::INFINITY, f64::min);
        assert!(least >= shortest * (1.0 - 1e-12), "case {index}: {least} {shortest}");
        let told = switching.pulses.unwrap();
        assert!(told.shortest_s >= shortest * (1.0 - 1e-12), "case {index}: {told:?}");
        assert_eq!(lengths(&switching).len(), told.count, "case {index}");
        // An extremal with a gap is no lower bound.
        assert!(switching.continuous_cost >= told.cost_without * (1.0 - 1e-3), "case {index}: {told:?}");
    }
    assert!(found >= 11, "{found} of 12");
}

#[test]
fn costs_on_grids_of_pulses_converge_with_the_square_of_the_step() {
    let problem = pulsed(&moving_slowly(), 0.3);
    let cost = |steps: usize| solved(&problem.clone().with_steps(steps)).solution;
    let [coarse, middle, fine] = [100, 200, 400].map(cost);
    let exact = fine.switching.as_ref().unwrap().continuous_cost;
    for (one, next) in [(&coarse, &middle), (&middle, &fine)] {
        let order = ((one.cost - exact) / (next.cost - exact)).log2();
        assert!((order - 2.0).abs() < 0.2, "{order}: {} {} {exact}", one.cost, next.cost);
    }
    // Stationary in every time that no bound holds.
    assert!(fine.optimality.stationarity < 1e-12, "{}", fine.optimality.stationarity);
}

#[test]
fn opposite_thrusters_pulse_as_a_torque_of_both_signs() {
    let one_each = pulsed(&moving_slowly().with_actuation(torques(&CUBE, &[1.0; 3])), 0.3);
    let pairs = pulsed(&moving_slowly().with_actuation(thrusters(&CUBE, 1.0)), 0.3);
    let [one_each, pairs] =
        [one_each, pairs].map(|problem| solved(&problem).solution.switching.unwrap().continuous_cost);
    // Two opposite thrusters may fire together, which one torque of both signs cannot.
    assert!(pairs <= one_each * (1.0 + 1e-9), "{pairs} {one_each}");
}

/// Returns whether a plan fails these checks.
fn fails(problem: &Problem, trajectory: &Trajectory, names: &[&str]) -> bool {
    let judged = verify(problem, trajectory, 1e-12, None);
    assert!(!judged.passed());
    let failed = |name: &&str| judged.checks.iter().any(|check| check.name == **name && !check.passed);
    names.iter().all(failed)
}

#[test]
fn an_input_that_is_half_open_and_a_pulse_that_is_too_short_are_noticed() {
    let problem = pulsed(&moving_slowly(), 0.3);
    let trajectory = solved(&problem).solution.trajectory;
    assert!(verify(&problem, &trajectory, 1e-12, None).passed());
    let count = trajectory.input_count;
    let on = trajectory.input.iter().position(|input| *input != 0.0).unwrap();
    // The last step of that pulse.
    let (input, value) = (on % count, trajectory.input[on]);
    let mut last = on / count;
    while trajectory.input.get((last + 1) * count + input) == Some(&value) {
        last += 1;
    }
    let changed = |value: f64| {
        let mut changed = trajectory.clone();
        changed.input[last * count + input] = value;
        changed
    };
    assert!(fails(&problem, &changed(0.5 * value), &["inputs off or at a limit"]));
    assert!(fails(&problem, &changed(value * (1.0 + 1e-9)), &["inputs off or at a limit"]));
    assert!(fails(&problem, &changed(f64::NAN), &["inputs off or at a limit"]));
    // After an interruption both parts of the pulse are too short.
    let mut interrupted = trajectory.clone();
    interrupted.input[(last - 1) * count + input] = 0.0;
    assert!(fails(&problem, &interrupted, &["shortest pulse"]));
    // The plan fails if pulses must be longer.
    assert!(fails(&pulsed(&problem, 0.3 * (1.0 + 1e-6)), &trajectory, &["shortest pulse"]));
}

#[test]
fn a_shortest_pulse_reads_back_as_written() {
    for actuation in [torques(&CUBE, &[1.0, 1.2, 0.8]), thrusters(&CUBE, 1.0)] {
        let problem = pulsed(&moving_slowly().with_actuation(actuation), 0.123_456_789);
        let text = SpecDocument::new(&problem, &Settings::discrete()).unwrap().to_string();
        let again = spec::from_str(&text, "again.json", Format::Json, &[]).unwrap();
        assert_eq!(again.problem.shortest_pulse(), Some(0.123_456_789));
        assert_eq!(again.problem.actuation, problem.actuation);
    }
}

#[test]
fn what_does_not_go_with_pulses_is_refused() {
    let refused = |problem: &Problem| {
        plan(problem, &Settings::discrete(), None, &mut Silent).expect_err("refused").to_string()
    };
    let given = moving_slowly();
    for shortest in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refused(&pulsed(&given, shortest)).contains("shortest pulse"), "{shortest}");
    }
    assert!(refused(&pulsed(&given, 5.1)).contains("not be longer"));
    assert!(refused(&pulsed(&moving(), 0.3)).contains("pulses need minimum fuel"));
    let effort = given.clone().with_objective(Objective::default());
    assert!(refused(&pulsed(&effort, 0.3)).contains("pulses need minimum fuel"));
    assert!(refused(&pulsed(&given.clone().with_duration_at_most(5.0), 5.1)).contains("not be longer"));
    let norm = given.with_actuation(super::minimum_fuel::ball(1.0));
    assert!(refused(&pulsed(&norm, 0.3)).contains("norm"));
}

/// Pulses are so long that hardly any fit: a plan exists, or the planner reports that it found no
/// plan.
#[test]
fn pulses_without_room_are_not_called_a_plan() {
    let plan = plan(&pulsed(&moving_slowly(), 4.9), &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!((plan.status, plan.solution.outcome), (Status::NotConverged, Outcome::Stalled));
    assert!(plan.solution.shortfall.unwrap().to_string().contains("4.9 s"));
}
