//! The chain as a program, compared with the matrices of the chain's model and rows, and with
//! central differences.

use super::chain::ChainProgram;
use super::chain::family::Family;
use super::method::InteriorPoint;
use super::program::{Derivatives, Duals, Increment, Point, Program, Shape, Values};
use super::tuning::Tuning;
use crate::maneuver::aim::Aim;
use crate::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use crate::maneuver::duration::Duration;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Problem, State};
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits};
use crate::mechanics::body::{Body, Inertia};
use crate::mechanics::environment::Pose;
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::model::goal::with_goal;
use crate::optimize::chain::model::{Goal, Model, Pull, step};
use crate::optimize::chain::rows::{LimitRows, What};
use crate::optimize::chain::tests::reference;
use crate::optimize::chain::tests::reference::newton::newton;
use crate::optimize::chain::tests::reference::rows::{Place, RowValue};
use crate::optimize::chain::tests::{chains, random_inputs, reference_slew, shot, straight, stretch};
use crate::optimize::chain::{Chain, iterate, multipliers, path, with_iterate};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Dynamics;
use crate::optimize::methods::method::{Attempt, Budget, Method, Watch};
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::method::ConvexIteration;
use crate::testing::Random;
use crate::{Matrix3, Vector3, lie};

/// Step of the central differences.
const STEP: f64 = 1e-5;
/// Tolerance of the truncation and round-off errors of central differences.
const CLOSE: f64 = 3e-8;
/// Tolerance of the truncation and round-off errors of second differences.
const CLOSE_TO_SECOND: f64 = 1e-6;

/// Returns a trajectory under random positive inputs, which one-sided inputs allow.
fn trajectory(random: &mut Random, model: &Model) -> Iterate {
    let mut inputs: Vec<Vec<f64>> = (0..=model.steps).map(|_| random_inputs(random, model.m)).collect();
    inputs.iter_mut().flatten().for_each(|u| *u = 0.2 + 0.3 * u.abs());
    if model.first_input() > 0 {
        inputs[0].fill(0.0);
    }
    let mut states = vec![step::opening(model, stretch(model), &inputs[0])];
    for stage in 0..model.steps {
        let end = step::step(model, stage, &states[stage], &inputs[stage + 1]).unwrap();
        states.push(end);
    }
    Iterate { states, inputs }
}

/// Adds cones about moving directions and about a disc to a maneuver, for the stated duration and
/// for a free one.
fn past_moving(problem: Problem) -> [(Problem, Model); 2] {
    let (vector, rate) = (Vector3::new(0.6, -0.64, 0.48), Vector3::new(0.2, 0.3, -0.1));
    let moving = Direction::turning(vector, rate, 10.0 * problem.seconds()).unwrap();
    let Direction::Moving(centre) = moving.clone() else { panic!("it moves") };
    let disc = Direction::Disc { centre, radius: 0.2 };
    let cone = |side, direction| {
        let pointing = Pointing::new(side, vec![Vector3::x(), Vector3::z()], vec![direction], 0.5);
        Constraint { name: "moving".into(), rule: Rule::Pointing(pointing) }
    };
    let problem =
        problem.with_constraint(cone(Side::KeepOut, moving)).with_constraint(cone(Side::KeepIn, disc));
    let goal = Goal { objective: Objective::Time };
    let models = [
        Model::new(&problem, problem.steps),
        with_goal(&problem, Dynamics::new(&problem, problem.steps), &goal),
    ];
    // One of the inputs has a quadratic penalty.
    models.map(|mut model| {
        model.pulls.push(Pull { stage: 2, input: 1, at: 0.4, weight: 0.7 });
        (problem.clone(), model)
    })
}

/// Calls `of` with the program of each `every`-th chain, and with a point and multipliers of it;
/// returns the number of programs.
fn programs(
    every: usize,
    mut of: impl FnMut(&ChainProgram, &Model, &LimitRows, &Iterate, &Point, &Duals),
) -> usize {
    let mut random = Random(17);
    let mut seen = 0;
    for (problem, model) in chains()
        .step_by(every)
        .chain(chains().step_by(20).take(3).flat_map(|(problem, _)| past_moving(problem)))
    {
        let limits = LimitRows::of(&problem, &model);
        let iterate = trajectory(&mut random, &model);
        let program = ChainProgram::of(&model, &limits, None, &iterate, &Tuning::default());
        let shape = program.shape();
        let mut point = Point::of(shape);
        program.point(&iterate, &mut point);
        program.at_barrier(0.03);
        // Both signs of an input that burns fuel are used.
        point.inputs.iter_mut().for_each(|w| *w += 0.01);
        program.follow(&mut point);
        let mut duals = Duals::of(shape);
        let all = [&mut duals.costates, &mut duals.terminal, &mut duals.rows];
        all.into_iter().flatten().for_each(|value| *value = random.uniform());
        of(&program, &model, &limits, &iterate, &point, &duals);
        seen += 1;
    }
    seen
}

/// The states of a program are those of the chain's steps, and it has the chain's rows and cost.
#[test]
fn a_program_has_the_values_of_the_chain() {
    let seen = programs(1, |program, model, limits, iterate, _, _| {
        let shape = program.shape();
        let (mut point, mut values) = (Point::of(shape), Values::of(shape));
        program.point(iterate, &mut point);
        program.burn_no_more(&mut point);
        assert!(program.values(&point, &mut values));
        let defect = values.defects.iter().fold(0.0f64, |worst, value| worst.max(value.abs()));
        assert!(defect < 1e-13, "{defect:.1e}");
        let pull =
            |pull: &Pull| 0.5 * pull.weight * (iterate.inputs[pull.stage][pull.input] - pull.at).powi(2);
        let cost = iterate.cost(model) + model.pulls.iter().map(pull).sum::<f64>();
        assert!((values.cost / program.scale() - cost).abs() < 1e-12 * cost, "{} {cost}", values.cost);
        let mut met = 0;
        for (index, row) in program.of_rows() {
            let row = &limits.rows[row];
            if matches!(row.what, What::Burn { .. }) {
                continue;
            }
            let state = &iterate.states[row.stage];
            let inputs = &iterate.inputs[row.stage];
            let next = iterate.inputs.get(row.stage + 1).unwrap_or(inputs);
            let none = vec![0.0; model.m];
            let arc = (row.stage < model.steps)
                .then(|| reference::step::step(model, row.stage, state, &none).unwrap().arc);
            let place = Place { state, inputs, next, arc: arc.as_ref() };
            if let RowValue::Half { c, .. } = row.what.at(model, row.stage, &place).smooth() {
                assert!((c - values.rows[index]).abs() < 1e-12 * c.abs().max(1.0), "{:?} {c}", row.what);
                met += 1;
            }
        }
        assert!(met > 0);
        let (there, multipliers) = program.found(&point, &Duals::of(shape), &values.rows);
        assert_eq!(multipliers.rows.len(), limits.rows.len());
        for (known, found) in iterate.states.iter().zip(&there.states) {
            assert!((known.attitude - found.attitude).amax() < 1e-13);
            assert!((known.momentum - found.momentum).amax() < 1e-12 * (1.0 + known.momentum.amax()));
        }
    });
    assert!(seen > 60, "{seen}");
}

/// Returns the point with one unknown of one stage changed.
fn moved(program: &ChainProgram, at: &Point, stage: usize, place: usize, by: f64) -> Point {
    let shape = program.shape();
    let mut increment = Increment::of(shape);
    match place.checked_sub(shape.m) {
        Some(state) => increment.states[stage * shape.n + state] = by,
        None => increment.inputs[stage * shape.m + place] = by,
    }
    let mut out = Point::of(shape);
    program.moved(at, &increment, 1.0, &mut out);
    out
}

/// Returns stages at both ends and between them.
fn stages(shape: &Shape) -> [usize; 4] {
    [0, shape.stages / 2, shape.stages - 2, shape.stages - 1]
}

#[test]
fn the_slopes_of_a_program_are_its_derivatives() {
    programs(1, |program, model, _, _, point, duals| {
        let shape = program.shape();
        let mut at = Derivatives::of(shape);
        assert!(program.derivatives(point, duals, &mut at));
        let (n, z) = (shape.n, shape.z());
        let [mut plus, mut minus] = [Values::of(shape), Values::of(shape)];
        for stage in stages(shape) {
            for place in 0..z {
                if stage == 0 && place >= shape.m {
                    continue;
                }
                let values = |by: f64, out: &mut Values| {
                    assert!(program.values(&moved(program, point, stage, place, by), out));
                };
                values(STEP, &mut plus);
                values(-STEP, &mut minus);
                let slope = |plus: f64, minus: f64| (plus - minus) / (2.0 * STEP);
                for i in 0..n {
                    let found = slope(plus.defects[stage * n + i], minus.defects[stage * n + i]);
                    let known = at.steps[(stage * z + place) * n + i];
                    assert!((found - known).abs() < CLOSE, "step {stage} {place} {i}: {found} {known}");
                }
                let found = slope(plus.cost, minus.cost);
                let known = at.gradients[stage * z + place];
                assert!((found - known).abs() < CLOSE * (1.0 + known.abs()), "cost {place}: {found} {known}");
                for row in shape.rows_of(stage) {
                    let slopes = shape.slopes_of(row);
                    let known = shape.unknowns[slopes.clone()]
                        .iter()
                        .zip(&at.slopes[slopes])
                        .find(|(known, _)| usize::from(**known) == place)
                        .map_or(0.0, |(_, value)| *value);
                    let found = slope(plus.rows[row], minus.rows[row]);
                    assert!(
                        (found - known).abs() < CLOSE * (1.0 + known.abs()),
                        "{:?} {place}: {found} {known}",
                        program.what(row)
                    );
                }
            }
        }
        // The last state, and the derivative of the start with respect to the duration.
        for i in 0..n {
            let values = |by: f64, out: &mut Values| {
                assert!(program.values(&moved(program, point, shape.stages, shape.m + i, by), out));
            };
            values(STEP, &mut plus);
            values(-STEP, &mut minus);
            for (c, (plus, minus)) in plus.terminal.iter().zip(&minus.terminal).enumerate() {
                // The derivative of the terminal error's logarithm with respect to the attitude is
                // omitted (`model.terminal`).
                if (model.zeta()..model.zeta() + 3).contains(&i) {
                    continue;
                }
                let found = (plus - minus) / (2.0 * STEP);
                let known = at.terminal_slopes[c * n + i];
                assert!((found - known).abs() < CLOSE, "end {c} {i}: {found} {known}");
            }
            let found = (plus.cost - minus.cost) / (2.0 * STEP);
            assert!((found - at.last_gradient[i]).abs() < CLOSE * (1.0 + found.abs()));
        }
        if let Some(duration) = model.duration {
            let values = |by: f64, out: &mut Values| {
                assert!(program.values(&moved(program, point, 0, shape.m + duration, by), out));
            };
            values(STEP, &mut plus);
            values(-STEP, &mut minus);
            for i in 0..n {
                let found = (plus.defects[i] - minus.defects[i]) / (2.0 * STEP);
                let column = |place: usize| at.steps[(shape.m + place) * n + i];
                let known: f64 = (0..n).map(|place| column(place) * at.start_slopes[place]).sum();
                assert!((found - known).abs() < CLOSE, "start {i}: {found} {known}");
            }
        }
    });
}

/// Step of second differences.
const WIDE: f64 = 3e-4;

/// Returns `λ·step + z·c` plus the cost of a stage, with one unknown changed. The equation that
/// keeps the duration constant is omitted.
fn lagrangian(
    program: &ChainProgram,
    point: &Point,
    duals: &Duals,
    stage: usize,
    place: usize,
    by: f64,
) -> f64 {
    let shape = program.shape();
    let mut values = Values::of(shape);
    assert!(program.values(&moved(program, point, stage, place, by), &mut values));
    let steps = (0..shape.n).filter(|i| i + shape.m != place).map(|i| stage * shape.n + i);
    let steps: f64 = steps.map(|i| duals.costates[i + shape.n] * values.defects[i]).sum();
    let rows: f64 = shape.rows_of(stage).map(|row| duals.rows[row] * values.rows[row]).sum();
    steps + rows + values.cost
}

/// The curvature is the symmetric part of the change of `[B A]ᵀλ + Cᵀz` and of the cost's gradient
/// along the group.
#[test]
fn the_curvature_of_a_program_is_the_derivative_of_its_gradient() {
    let mut worst = 0.0f64;
    // Every third chain: this covers all maneuvers and all four kinds of a chain.
    programs(3, |program, model, _, _, point, duals| {
        let shape = program.shape();
        let mut at = Derivatives::of(shape);
        assert!(program.derivatives(point, duals, &mut at));
        let (n, z) = (shape.n, shape.z());
        let mut there = Derivatives::of(shape);
        for stage in stages(shape) {
            let first = if stage == 0 { 0..shape.m } else { 0..z };
            let size = first.len();
            let mut bend = vec![0.0; size * size];
            for place in first.clone() {
                for (by, sign) in [(STEP, 1.0), (-STEP, -1.0)] {
                    assert!(program.derivatives(&moved(program, point, stage, place, by), duals, &mut there));
                    for i in first.clone() {
                        let step = &there.steps[(stage * z + i) * n..][..n];
                        let next = &duals.costates[(stage + 1) * n..][..n];
                        let mut slope: f64 = step.iter().zip(next).map(|(a, b)| a * b).sum();
                        slope += there.gradients[stage * z + i];
                        for row in shape.rows_of(stage) {
                            let slopes = shape.slopes_of(row);
                            let values = shape.unknowns[slopes.clone()].iter().zip(&there.slopes[slopes]);
                            let own = values.filter(|(known, _)| usize::from(**known) == i);
                            slope += own.map(|(_, value)| value * duals.rows[row]).sum::<f64>();
                        }
                        bend[place * size + i] += sign * slope / (2.0 * STEP);
                    }
                }
            }
            if let Some(duration) = model.duration.filter(|_| stage > 0) {
                // Along the increment of the duration, which differs from the change of its
                // logarithm.
                let place = shape.m + duration;
                let [before, after] =
                    [-WIDE, WIDE].map(|by| lagrangian(program, point, duals, stage, place, by));
                let middle = lagrangian(program, point, duals, stage, place, 0.0);
                bend[place * size + place] = (before - 2.0 * middle + after) / (WIDE * WIDE);
            }
            let blocks = [&at.hessians, &at.curvatures].map(|all| &all[stage * z * z..][..z * z]);
            for i in first.clone() {
                for j in first.clone() {
                    let found = 0.5 * (bend[i * size + j] + bend[j * size + i]);
                    let known = blocks[0][i * z + j] + blocks[1][i * z + j];
                    if stage == 0 && model.first_input() > 0 {
                        continue;
                    }
                    // Second differences have fewer digits.
                    let wide = model.duration.is_some_and(|d| i == j && i == shape.m + d);
                    let off = (found - known).abs() / (1.0 + known.abs()) * if wide { 0.1 } else { 1.0 };
                    worst = worst.max(off);
                    assert!(off < CLOSE_TO_SECOND, "{stage} {i} {j}: {found} {known}, m {}", shape.m);
                }
            }
        }
    });
    assert!(worst > 0.0);
}

/// Returns families of ends on moving targets: with a free roll, near a second direction with and
/// without matched rates, and for a fixed duration.
fn families(problem: &Problem) -> Vec<Family> {
    let seconds = problem.seconds();
    let moving = |vector: Vector3, rate: f64| {
        let rate = Vector3::new(0.2, 0.5, -0.4) * (rate / seconds);
        Direction::turning(vector, rate, 10.0 * seconds).unwrap()
    };
    let first = || moving(Vector3::new(0.6, -0.64, 0.48), 1.0);
    let aim = || Aim::new(Vector3::new(0.0, 0.6, 0.8), first()).spinning(0.3 / seconds);
    let second = moving(Vector3::new(0.0, 0.6, 0.8), -0.7);
    let banded = Aim::new(Vector3::x(), first()).with_roll_towards(Vector3::z(), second, 1.0);
    let from = lie::exp(&Vector3::new(0.3, -0.2, 0.4));
    let sought = problem.clone().with_duration(Duration::SOUGHT);
    let of = |problem: &Problem, aim: Aim| Family::of(problem, &aim, &from).unwrap();
    vec![
        of(&sought, aim()),
        of(&sought, aim().at_rest()),
        of(&sought, banded.clone()),
        of(&sought, banded.at_rest()),
        of(problem, aim()),
    ]
}

/// First and second derivatives of the terminal equations of families, at one of their ends, agree
/// with central differences.
#[test]
fn ends_of_families_have_the_derivatives_of_their_equations() {
    let mut random = Random(5);
    let mut seen = 0;
    for (problem, model) in chains().filter(|(_, model)| model.given().len() >= 6).step_by(3) {
        for family in families(&problem) {
            let limits = LimitRows::of(&problem, &model);
            let mut iterate = trajectory(&mut random, &model);
            let mut tuning = Tuning::default();
            tuning.program.difference = 1e-4;
            let of = |iterate: &Iterate| {
                let program = ChainProgram::of(&model, &limits, Some(&family), iterate, &tuning);
                let mut point = Point::of(program.shape());
                program.point(iterate, &mut point);
                (program, point)
            };
            // The end nearest to the path.
            let (program, point) = of(&iterate);
            iterate.states[model.steps].attitude = program.end_at(&point);
            let (program, point) = of(&iterate);
            let shape = program.shape();
            let mut duals = Duals::of(shape);
            duals.terminal.iter_mut().for_each(|value| *value = random.uniform());
            let mut at = Derivatives::of(shape);
            assert!(program.derivatives(&point, &duals, &mut at));
            let n = shape.n;
            let values = |moves: [(usize, f64); 2]| {
                let mut by = Increment::of(shape);
                moves.iter().for_each(|(i, by_i)| by.states[shape.stages * n + i] += by_i);
                let (mut there, mut values) = (Point::of(shape), Values::of(shape));
                program.moved(&point, &by, 1.0, &mut there);
                assert!(program.values(&there, &mut values));
                values.terminal
            };
            let weighed = |moves| -> f64 {
                values(moves).iter().zip(&duals.terminal).map(|(error, nu)| error * nu).sum()
            };
            for i in 0..n {
                let [plus, minus] = [STEP, -STEP].map(|by| values([(i, by), (i, 0.0)]));
                for (c, (plus, minus)) in plus.iter().zip(&minus).enumerate() {
                    let (found, known) = ((plus - minus) / (2.0 * STEP), at.terminal_slopes[c * n + i]);
                    assert!((found - known).abs() < CLOSE, "end {c} {i}: {found} {known}");
                }
                for j in 0..=i {
                    let corner = |x: f64, y: f64| weighed([(i, x * WIDE), (j, y * WIDE)]);
                    let sum = corner(1.0, 1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0) + corner(-1.0, -1.0);
                    let (found, known) = (sum / (4.0 * WIDE * WIDE), at.last_curvature[i * n + j]);
                    assert!(
                        (found - known).abs() < 30.0 * CLOSE_TO_SECOND * (1.0 + known.abs()),
                        "{i} {j}: {found} {known}"
                    );
                }
            }
            seen += 1;
        }
    }
    assert!(seen > 40, "{seen}");
}

/// Claim: from one start the method reaches the costs that another program found on the same grid.
/// Without limits the costates are those of the shooting. With limits the active rows and the
/// costates are those of Newton's method on the active set.
#[test]
fn the_reference_costs_are_met_and_multipliers_are_costates() {
    let references = [(None, 16.389987441935), (Some(0.75), 16.718658565135), (Some(0.65), 18.0852435685)];
    for (share, cost) in references {
        let problem = reference_slew(share);
        let chain = Chain::new(&problem, problem.steps);
        let unit = chain.model.dynamics.units.cost;
        let found = improved(&chain);
        let above = found.cost * unit / cost - 1.0;
        assert!(found.converged() && above.abs() < 1e-10, "{share:?} {above:.1e}");
        assert!(found.stationarity < 1e-11, "{share:?} {:.1e}", found.stationarity);
        // Start from the path of SCP, which uses none of the interior-point method's second
        // derivatives.
        let scp = ConvexIteration { chain: &chain, options: &ScpOptions::unpolished() };
        let scp = scp.improve(short(&chain), &BUDGET).candidate;
        let newton = newton(&chain.model, &chain.rows, &iterate(&scp), &multipliers(&scp)).unwrap();
        let newton = with_iterate(scp, newton.iterate, newton.multipliers);
        let scale = newton.costates.iter().map(|costate| costate.amax()).fold(0.0, f64::max);
        let pairs = found.candidate.costates.iter().zip(&newton.costates);
        let off = pairs.map(|(a, b)| (a - b).amax()).fold(0.0, f64::max) / scale;
        assert!(off < 1e-8, "{share:?} costates are off by {off:.1e}");
        let [ours, theirs] = [&found.candidate, &newton].map(|candidate| {
            candidate.multipliers.1.iter().map(|multiplier| *multiplier > 0.0).collect::<Vec<_>>()
        });
        assert_eq!(ours, theirs, "{share:?}");
        assert_eq!(ours.iter().any(|acts| *acts), share.is_some());
        if share.is_none() {
            let solution = shot(&problem);
            let units = chain.model.dynamics.units.costate::<6>();
            for (row, dual) in found.candidate.costates[1..].iter().enumerate() {
                let shot = &solution.trajectory.costates[6 * row..][..6];
                let off = (0..6).map(|i| (shot[i] / units[i] - dual[i]).abs()).fold(0.0, f64::max);
                assert!(off < 1e-11 * scale, "row {row}: {off:.1e} of {scale}");
            }
        }
    }
}

const BUDGET: Budget = Budget { iterations: 250, watch: Watch::NONE };

/// Returns the fixed-axis path.
fn short(chain: &Chain) -> Candidate {
    path("short", &chain.model.dynamics.grid, straight(&chain.model).into_iter())
}

/// Returns the result of the interior-point method from the fixed-axis path.
fn improved(chain: &Chain) -> Attempt {
    InteriorPoint::of(chain, &Tuning::default()).improve(short(chain), &BUDGET)
}

/// A run from a bent path that converges to a known optimum ends there before it has converged.
#[test]
fn a_run_ends_at_an_optimum_that_is_known() {
    let problem = reference_slew(Some(0.65));
    let chain = Chain::with_goal(&problem, problem.steps, &Goal { objective: Objective::Time });
    let found = improved(&chain);
    let bent = straight(&chain.model).into_iter().enumerate().map(|(node, pose)| {
        let side = (std::f64::consts::PI * node as f64 / problem.steps as f64).sin().powi(2);
        Pose { attitude: pose.attitude * lie::exp(&Vector3::new(0.0, 0.1 * side, 0.0)), ..pose }
    });
    let bent = path("bent", &chain.model.dynamics.grid, bent);
    let ended = |known: &[Attempt]| {
        let tuning = Tuning { known_from: 1e-5, ..Tuning::default() };
        InteriorPoint { known, ..InteriorPoint::of(&chain, &tuning) }.improve(bent.clone(), &BUDGET)
    };
    let known = [found];
    let (alone, beside) = (ended(&[]), ended(&known));
    let count = |attempt: &Attempt| attempt.runs[0].report.iterations;
    assert!((alone.cost / known[0].cost - 1.0).abs() < 1e-8, "{} {}", alone.cost, known[0].cost);
    assert!(count(&beside) < count(&alone), "{} {}", count(&beside), count(&alone));
    assert_eq!(beside.cost, known[0].cost);
}

/// Claim: only the active rows of a minimum-time plan have a nonzero multiplier.
#[test]
fn a_plan_of_least_time_tells_the_rows_that_act() {
    let problem = reference_slew(Some(0.65));
    let chain = Chain::with_goal(&problem, problem.steps, &Goal { objective: Objective::Time });
    let found = improved(&chain);
    assert!(found.converged());
    let at = chain.iterate(&found.candidate, &Watch::NONE);
    let at = at.evaluate(&chain.model, &chain.rows, Watch::NONE).unwrap();
    let mut acting = 0;
    for (value, multiplier) in at.rows.iter().zip(&found.candidate.multipliers.1) {
        let slack = -value.violation();
        assert!(*multiplier == 0.0 || slack < 1e-5, "a row with a slack of {slack:.1e} acts");
        acting += usize::from(*multiplier > 0.0);
    }
    // On every step at least one torque is at a limit, and never at both limits.
    assert!((problem.steps..=3 * problem.steps).contains(&acting), "{acting}");
}

/// Cost of fuel charged by the norm of the torque, on 50 steps, compared with another program on
/// the same grid (CasADi and IPOPT).
#[test]
fn fuel_by_the_norm_is_that_of_other_programs() {
    let about = |axis: [f64; 3], degrees: f64| {
        lie::exp(&(Vector3::from(axis).normalize() * f64::to_radians(degrees)))
    };
    let inertia = Inertia::diagonal(Vector3::new(1.0, 2.0, 3.0)).unwrap();
    let maneuver = |end: Matrix3, duration: f64, limits: Limits| {
        let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
        let (body, start) =
            (Body { inertia: inertia.clone(), mass: None }, State::at_rest(Matrix3::identity()));
        Problem::minimum_fuel(body, start, State::at_rest(end), duration)
            .with_actuation(Actuation::torques(torques))
            .with_steps(50)
    };
    let ball = |size: Option<f64>, norm: f64| Limits {
        size: size.map(|size| vec![size; 3]),
        norm: Some(norm),
        ..Limits::default()
    };
    let cone = Pointing::new(
        Side::KeepOut,
        vec![Vector3::z()],
        vec![Direction::Fixed(Vector3::new(0.75, 0.15, 0.64).normalize())],
        15f64.to_radians(),
    );
    let cone = Constraint { name: "cone".into(), rule: Rule::Pointing(cone) };
    let cases = [
        (maneuver(about([1.0, 2.0, 3.0], 120.0), 5.0, ball(Some(1.0), 1.3)), SIZE_AND_NORM),
        (maneuver(about([0.0, 1.0, 0.0], 100.0), 6.0, ball(None, 1.0)).with_constraint(cone), NORM_AND_CONE),
    ];
    for (problem, expected) in cases {
        let goal = Goal { objective: problem.objective.clone() };
        let alone = Chain::with_goal(&problem, problem.steps, &goal);
        let found = improved(&alone);
        assert!(found.converged(), "{:?} {:.1e} {:.1e}", found.outcome, found.residual, found.stationarity);
        let price = alone.price(&found.candidate);
        assert!((price / expected - 1.0).abs() < 1e-5, "{price} {expected}");
    }
}

/// Reference costs from `tests/it/maneuvers/fuel_within.rs`.
const SIZE_AND_NORM: f64 = 3.743734068;
const NORM_AND_CONE: f64 = 1.405963232;
