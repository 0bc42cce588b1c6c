//! Limited inputs through the saturated law: published costs, another optimiser, the witnesses.

use super::dense::Dense;
use super::support::{assert_close, full_body, rest_to_rest, weighted};
use evidence::Random;
use nalgebra::{DMatrix, DVector};
use slewkit::maneuver::constraint::{Constraint, Rule};
use slewkit::maneuver::objective::Weights;
use slewkit::maneuver::problem::{Path, Problem, Scheme, State};
use slewkit::maneuver::settings::{Method, Settings};
use slewkit::maneuver::solution::{Outcome, Rung, RungReport, Solution};
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::UniformGravity;
use slewkit::optimize::search::{polish, solve};
use slewkit::plan::{Guess, Plan, PlanError, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};

fn settings() -> Settings {
    Settings { method: Method::Shooting, ..Settings::discrete() }
}

fn shot(problem: &Problem) -> Solution {
    let solution = solve(problem, &settings(), None, &mut Silent).unwrap();
    assert_eq!(solution.outcome, Outcome::Converged, "{:?}", solution.ladder);
    assert!(solution.terminal.largest() <= 1e-12);
    solution
}

/// Returns a plan that must be solved, verified and within its limits.
fn planned(problem: &Problem) -> Solution {
    let Plan { solution, verification, status, .. } = plan(problem, &settings(), None, &mut Silent).unwrap();
    assert_eq!(status, Status::Solved, "{:?} {verification:?}", solution.ladder);
    assert!(solution.terminal.largest() <= 1e-12);
    assert!(solution.optimality.stationarity < 1e-12, "{:?}", solution.optimality);
    for margin in &verification.unwrap().margins {
        assert!(margin.margin >= -1e-12 * margin.margin.abs().max(1.0), "{margin:?}");
    }
    solution
}

fn largest_input(solution: &Solution) -> f64 {
    solution.trajectory.input.iter().fold(0.0f64, |largest, input| largest.max(input.abs()))
}

fn with_size(channel: &ActuatorSet, limit: f64) -> ActuatorSet {
    let limits = Limits { size: Some(vec![limit; channel.count()]), ..Limits::default() };
    channel.clone().with_limits(limits).unwrap()
}

fn with_norm(channel: &ActuatorSet, limit: f64) -> ActuatorSet {
    channel.clone().with_limits(Limits { norm: Some(limit), ..Limits::default() }).unwrap()
}

/// Limits every torque to a part of its largest value without limits.
fn within(problem: &Problem, part: f64) -> Problem {
    let limit = part * largest_input(&shot(problem));
    let torque = with_size(&problem.actuation.torque, limit);
    problem.clone().with_actuation(Actuation { torque, ..problem.actuation.clone() })
}

/// Costs from a separate program; iterations of the semismooth Newton from the costates without
/// limits.
#[test]
fn the_published_limits_are_met_in_as_many_iterations_as_published() {
    let free = rest_to_rest(120.0)
        .with_scheme(Scheme::LieEuler)
        .with_objective(weighted([1.0, 2.0, 0.5]))
        .with_path(Path::Shortest);
    assert_close("cost", &[shot(&free).cost], &[16.389987441935], 1e-13);
    for (part, cost, iterations) in [(0.75, 16.718658565135, 5), (0.65, 18.0852435685, 7)] {
        let limited = within(&free, part);
        let solution = planned(&limited);
        assert_close("cost", &[solution.cost], &[cost], 3e-12);
        let rung = solution.ladder.iter().find(|rung| rung.rung == Rung::Saturated).unwrap();
        assert_eq!((rung.outcome, rung.iterations), (Outcome::Converged, iterations));
        assert_eq!(solution.optimality.conjugate_points, Some(0));
        let limit = limited.actuation.torque.limits().size.as_ref().unwrap()[0];
        assert_eq!(largest_input(&solution).to_bits(), limit.to_bits());
        // The limit acts exactly where an input is at it.
        let [active] = solution.active.as_slice() else { panic!("{:?}", solution.active) };
        assert_eq!(active.name, "torque limit");
        let rows = solution.trajectory.input.chunks(3).zip(&solution.trajectory.time[1..]);
        let at_limit: Vec<f64> = rows
            .filter(|(row, _)| row.iter().any(|input| input.abs() >= limit))
            .map(|(_, time)| *time)
            .collect();
        assert_eq!(active.time_s, at_limit);
        assert!(active.multiplier.iter().all(|multiplier| *multiplier > 0.0));
    }
}

/// A nearly bang-bang plan. Newton fails from the costates without limits, and converges from the
/// costates of the interior point.
#[test]
fn tight_limits_are_reached_from_the_interior_point() {
    let free = rest_to_rest(120.0)
        .with_scheme(Scheme::LieEuler)
        .with_objective(weighted([1.0, 2.0, 0.5]))
        .with_path(Path::Shortest);
    let tight = within(&free, 0.6);
    let solution = planned(&tight);
    assert_eq!(solution.method, Method::Shooting);
    assert!(solution.ladder.iter().any(|rung| rung.rung == Rung::InteriorPoint));
    // The convex iteration does not use the control law, and needs no costates to start from.
    let settings = Settings { method: Method::Scp, ..Settings::discrete() };
    let convex = solve(&tight, &settings, None, &mut Silent).unwrap();
    assert_close("cost", &[solution.cost], &[convex.cost], 1e-10);
    assert_close("inputs", &solution.trajectory.input, &convex.trajectory.input, 1e-7);
    // The convex iteration takes over there by default, and the shooting confirms its result.
    let Plan { solution: found, status, .. } =
        plan(&tight, &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!(
        (status, found.method, found.optimality.conjugate_points),
        (Status::Solved, Method::InteriorPoint, Some(0))
    );
    assert_close("cost", &[found.cost], &[solution.cost], 1e-10);
    let confirmed =
        found.ladder.iter().find(|rung| rung.rung == Rung::Guess && rung.start == "duals").unwrap();
    assert!(confirmed.outcome == Outcome::Converged && confirmed.iterations <= 2, "{confirmed:?}");
}

#[test]
fn the_interior_point_stops_at_the_limit_of_iterations_and_says_so() {
    let limited = within(&rest_to_rest(120.0), 0.7);
    let slow = Constraint { name: "slow".into(), rule: Rule::RateNorm(1.55) };
    let problem = limited.with_constraint(slow);
    let at = |max_iterations: usize| {
        plan(&problem, &Settings { max_iterations, ..Settings::discrete() }, None, &mut Silent).unwrap()
    };
    let whole = at(60);
    assert_eq!(whole.status, Status::Solved);
    let needed = whole.solution.ladder.iter().map(|rung| rung.iterations).max().unwrap();
    assert!(needed > 3, "{:?}", whole.solution.ladder);
    let cut = at(1);
    assert_eq!((cut.status, cut.solution.outcome), (Status::NotConverged, Outcome::IterationLimit));
    // Four iterations of the interior point for one of Newton's.
    let interior = |rung: &&RungReport| rung.rung == Rung::InteriorPoint;
    let interior: Vec<&RungReport> = cut.solution.ladder.iter().filter(interior).collect();
    assert!(interior.iter().all(|rung| rung.iterations <= 4), "{interior:?}");
    assert!(interior.iter().any(|rung| rung.outcome == Outcome::IterationLimit), "{interior:?}");
    let shortfall = cut.solution.shortfall.unwrap().to_string();
    assert!(shortfall.contains("the iteration limit ended the search, after 4 iterations"), "{shortfall}");
    // No advice on the duration from a search that was cut short.
    assert!(!shortfall.contains("was found"), "{shortfall}");
}

/// The shooting is quicker if only the inputs are limited, counts conjugate points, and comes
/// first.
#[test]
fn limits_of_inputs_alone_take_the_shooting_by_default() {
    let limited = within(&rest_to_rest(120.0), 0.8);
    let found = plan(&limited, &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!((found.status, found.solution.method), (Status::Solved, Method::Shooting));
    assert_eq!(found.solution.optimality.conjugate_points, Some(0));
    let slow = Constraint { name: "slow".into(), rule: Rule::RateNorm(50.0) };
    let found = plan(&limited.with_constraint(slow), &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!((found.status, found.solution.method), (Status::Solved, Method::InteriorPoint));
}

#[test]
fn the_costs_are_those_of_a_dense_optimiser() {
    let mut random = Random::new(71);
    for index in 0..10 {
        let moments = Vector3::repeat(0.6) + 0.4 * random.vector().abs();
        let turn = lie::exp(&random.vector());
        let j = turn * Matrix3::from_diagonal(&moments) * turn.transpose();
        let body = Body { inertia: Inertia::new(0.5 * (j + j.transpose())).unwrap(), mass: None };
        let turn = random.vector().normalize() * (0.6 + random.unit());
        let rates = if index % 2 == 0 {
            [Vector3::zeros(); 2]
        } else {
            [random.vector() * 0.3, random.vector() * 0.3]
        };
        let start = State::attitude(lie::exp(&random.vector()), rates[0]);
        let end = State::attitude(start.attitude * lie::exp(&turn), rates[1]);
        let weight = [1.0, 1.0 + random.unit(), 0.5 + random.unit()];
        for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
            let free = Problem::attitude(body.clone(), start, end, 2.0)
                .with_steps(20)
                .with_scheme(scheme)
                .with_path(Path::Shortest)
                .with_objective(weighted(weight));
            let limited = within(&free, 0.72 + 0.23 * random.unit());
            let solution = planned(&limited);
            // The first guess has the clipped inputs of the maneuver without limits.
            let limit = limited.actuation.torque.limits().size.as_ref().unwrap()[0];
            let inputs = shot(&free).trajectory.input;
            let clipped = inputs.iter().map(|input| input.clamp(-limit, limit));
            let (inputs, cost) = Dense::new(&limited).solve(DVector::from_iterator(inputs.len(), clipped));
            assert_close("cost", &[solution.cost], &[cost], 1e-8);
            assert_close("inputs", &solution.trajectory.input, inputs.as_slice(), 1e-6);
            assert!(!solution.active.is_empty());
        }
    }
}

/// Torques fixed to the reference frame, forces fixed to the body, more inputs than axes, a field.
#[test]
fn every_frame_scheme_and_kind_of_limit_plans_and_verifies() {
    let body = Body { mass: Some(1.3), ..full_body() };
    let start = State { position: Vector3::new(0.1, 0.0, 0.2), ..State::at_rest(Matrix3::identity()) };
    let attitude = lie::exp(&Vector3::new(0.7, -0.4, 0.9));
    let end = State { position: Vector3::new(1.0, -0.5, 0.4), ..State::at_rest(attitude) };
    let axes = vec![Vector3::x(), Vector3::y(), Vector3::z(), Vector3::new(0.5, 0.5, -0.7)];
    let weight = DMatrix::from_diagonal(&DVector::from_row_slice(&[1.0, 1.5, 0.8, 1.2]));
    let field = UniformGravity::new(1.3, 0.4, Vector3::z(), Vector3::new(0.1, -0.2, 0.3)).unwrap();
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        for (frame, other) in
            [(AxisFrame::Body, AxisFrame::Reference), (AxisFrame::Reference, AxisFrame::Body)]
        {
            for norm in [false, true] {
                let torque = ActuatorSet::new(axes.clone(), frame).unwrap();
                let force = ActuatorSet::new(axes.clone(), other).unwrap();
                let actuation = Actuation::torques_and_forces(torque, force);
                let free = Problem::rigid_body(body.clone(), start, end, 2.0)
                    .with_actuation(actuation)
                    .with_objective(Weights {
                        torque: Some(weight.clone()),
                        force: Some(weight.clone()),
                        time_price: None,
                    })
                    .with_environment(field.clone())
                    .with_steps(40)
                    .with_scheme(scheme)
                    .with_path(Path::Shortest);
                let without = shot(&free);
                let largest =
                    |values: &[Vector3]| values.iter().map(|value| value.norm()).fold(0.0, f64::max);
                let rows = without.trajectory.input.chunks(8);
                let peak = |from: usize| {
                    let inputs = rows.clone().flat_map(|row| &row[from..from + 4]);
                    inputs.fold(0.0f64, |peak, input| peak.max(input.abs()))
                };
                let mut limited = free.clone();
                let Actuation { torque, force, .. } = &mut limited.actuation;
                let channel = force.as_ref().unwrap();
                if norm {
                    *force = Some(with_norm(channel, 0.8 * largest(&without.trajectory.force)));
                    *torque = with_norm(torque, 0.8 * largest(&without.trajectory.torque));
                } else {
                    *force = Some(with_size(channel, 0.8 * peak(0)));
                    *torque = with_size(torque, 0.8 * peak(4));
                }
                let solution = planned(&limited);
                assert!(solution.cost > without.cost);
                let names: Vec<&str> = solution.active.iter().map(|active| active.name.as_str()).collect();
                let expected = if norm {
                    ["force norm limit", "torque norm limit"]
                } else {
                    ["force limit", "torque limit"]
                };
                assert_eq!(names, expected);
            }
        }
    }
}

/// A norm limit under equal weights has no preferred axes: the plan is the same in all axes.
#[test]
fn a_norm_limit_is_the_same_in_turned_axes() {
    let turn = lie::exp(&Vector3::new(0.4, -1.1, 0.3));
    let axes: Vec<Vector3> = turn.column_iter().map(|axis| axis.into_owned()).collect();
    let turned = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
    let straight = ActuatorSet::three_axes(AxisFrame::Body);
    let free = rest_to_rest(90.0).with_path(Path::Shortest);
    let peak = shot(&free).trajectory.torque.iter().map(|torque| torque.norm()).fold(0.0, f64::max);
    let [a, b] = [straight, turned].map(|channel| {
        let limited = free.clone().with_actuation(Actuation::torques(with_norm(&channel, 0.75 * peak)));
        planned(&limited)
    });
    assert_close("costates", &a.trajectory.costates, &b.trajectory.costates, 1e-10);
    assert_close("cost", &[a.cost], &[b.cost], 1e-12);
}

/// `dJ/dū` is minus the sum of the multipliers over time: they are how fast the cost falls,
/// relative to ū.
#[test]
fn multipliers_tell_what_a_larger_limit_is_worth() {
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        let free = rest_to_rest(100.0).with_path(Path::Shortest).with_scheme(scheme);
        let limit = 0.8 * largest_input(&shot(&free));
        let at = |factor: f64| {
            let torque = with_size(&free.actuation.torque, factor * limit);
            planned(&free.clone().with_actuation(Actuation::torques(torque)))
        };
        let solution = at(1.0);
        let step = 1e-5;
        let slope = (at(1.0 + step).cost - at(1.0 - step).cost) / (2.0 * step);
        let active = &solution.active[0];
        let unit = cost_unit(&free);
        let ends = |time: f64| scheme == Scheme::LieVerlet && (time == 0.0 || time >= free.seconds());
        let shares = active.time_s.iter().map(|time| if ends(*time) { 0.5 } else { 1.0 });
        let sum: f64 = shares.zip(&active.multiplier).map(|(share, multiplier)| share * multiplier).sum();
        let expected = -sum * unit / free.steps as f64;
        assert_close("slope", &[slope], &[expected], 1e-6);
    }
}

/// Returns the unit of cost of a free body with three unit torques: the cost of a turn by one
/// radian.
fn cost_unit(problem: &Problem) -> f64 {
    let (inertia, time) = (problem.body.inertia.mean(), problem.seconds());
    inertia * inertia / time.powi(3)
}

#[test]
fn limits_that_do_not_act_change_nothing() {
    let free = rest_to_rest(100.0).with_path(Path::Shortest);
    let without = shot(&free);
    let wide =
        free.with_actuation(Actuation::torques(with_size(&ActuatorSet::three_axes(AxisFrame::Body), 1e6)));
    let within = planned(&wide);
    assert_close("costates", &within.trajectory.costates, &without.trajectory.costates, 1e-10);
    assert!(within.active.is_empty());
}

#[test]
fn a_guess_near_the_costates_is_polished_in_two_steps() {
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        let limited = within(&rest_to_rest(120.0).with_scheme(scheme).with_path(Path::Shortest), 0.75);
        let solution = planned(&limited);
        // The guess has the error of duals of a convex program that has converged to six digits.
        let guess: Vec<f64> = solution
            .costates_0(&limited)
            .iter()
            .enumerate()
            .map(|(i, x)| x * (1.0 + 1e-6 * (i as f64 - 2.5)))
            .collect();
        let polished = polish(&limited, &settings(), &guess, &mut Silent).unwrap();
        assert_eq!(polished.outcome, Outcome::Converged);
        assert!(polished.iterations <= 2, "{:?}", polished.ladder);
        assert!(polished.terminal.largest() <= 1e-12);
        assert_close("costates", &polished.trajectory.costates, &solution.trajectory.costates, 1e-10);
    }
}

/// The norm limit is below the need of a bang-bang turn about a fixed axis, four sixths of the peak
/// without limits, but not far enough for a proof. No plan is found, and no result claims one.
#[test]
fn the_path_of_a_guess_begins_the_convex_road() {
    let problem = within(&rest_to_rest(120.0), 0.75);
    let settings = Settings { method: Method::Scp, ..settings() };
    let cold = solve(&problem, &settings, None, &mut Silent).unwrap();
    assert_eq!((cold.outcome, cold.start.as_str()), (Outcome::Converged, "short"));
    // A neighbour's path: other ends, another grid.
    let neighbour = within(&rest_to_rest(115.0), 0.8).with_steps(37);
    let guess = Guess::of(&solve(&neighbour, &settings, None, &mut Silent).unwrap(), &neighbour);
    let warm = solve(&problem, &settings, Some(&guess), &mut Silent).unwrap();
    assert_eq!((warm.outcome, warm.start.as_str()), (Outcome::Converged, "guess"));
    assert!((warm.cost - cold.cost).abs() < 1e-9 * cold.cost);
    // The long way is no guess for the short one.
    let long = within(&rest_to_rest(120.0).with_path(Path::Long), 0.9);
    let away = Guess::of(&solve(&long, &settings, None, &mut Silent).unwrap(), &long);
    let short = problem.clone().with_path(Path::Shortest);
    assert_eq!(solve(&short, &settings, Some(&away), &mut Silent).unwrap().start, "short");
}

#[test]
fn limits_too_tight_for_any_maneuver_end_unsolved() {
    let free = rest_to_rest(90.0).with_path(Path::Shortest);
    let peak = shot(&free).trajectory.torque.iter().map(|torque| torque.norm()).fold(0.0, f64::max);
    let torque = with_norm(&free.actuation.torque, 0.64 * peak);
    let tight = free.clone().with_actuation(Actuation::torques(torque));
    let planned = plan(&tight, &settings(), None, &mut Silent).unwrap();
    assert_eq!(planned.status, Status::NotConverged);
    let shortfall = planned.solution.shortfall.unwrap().to_string();
    assert!(shortfall.contains("torque"), "{shortfall}");
    // Half of that is proved to be too little.
    let proved = plan(&within(&free, 0.3), &settings(), None, &mut Silent).unwrap();
    assert_eq!(proved.status, Status::Infeasible);
}

#[test]
fn what_the_shooting_cannot_take_is_refused_with_the_way_out() {
    let free = rest_to_rest(90.0);
    let channel = &free.actuation.torque;
    let limits = |limits: Limits| {
        let torque = channel.clone().with_limits(limits).unwrap();
        free.clone().with_actuation(Actuation::torques(torque))
    };
    let both = Limits { size: Some(vec![3.0; 3]), norm: Some(3.0), ..Limits::default() };
    let rate = Limits { rate: Some(vec![3.0; 3]), ..Limits::default() };
    let mut wheels = free.clone();
    wheels.actuation.wheels = Some(Wheels { momentum: vec![0.0; 3], momentum_limit: vec![9.0; 3] });
    let fast = Constraint { name: "not too fast".into(), rule: Rule::RateNorm(5.0) };
    let refused = [
        (limits(both), "both"),
        (limits(rate), "how fast"),
        (wheels, "wheels"),
        (free.clone().with_constraint(fast), "constraints"),
    ];
    for (problem, word) in refused {
        let guess = vec![0.1; 6];
        for error in [
            solve(&problem, &settings(), None, &mut Silent).unwrap_err(),
            polish(&problem, &settings(), &guess, &mut Silent).unwrap_err(),
        ] {
            assert!(matches!(error, PlanError::NotForShooting { .. }));
            let message = error.to_string();
            assert!(
                message.contains(word) && message.contains("method = \"interior_point\" or \"auto\""),
                "{message}"
            );
        }
    }
}
