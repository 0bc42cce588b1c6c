//! The chain's derivatives compared with finite differences.

use self::reference::rows::{Place, RowValue};
use self::reference::step;
use super::first_iterate;
use super::iterate::Iterate;
use super::model::{ChainState as Node, Goal, Model, goal, state};
use super::rows::{LimitRow, LimitRows, What};
use crate::maneuver::constraint::{Constraint, Direction, During, Pointing, Rule, Side};
use crate::maneuver::objective::{Fuel, Objective, Weights};
use crate::maneuver::problem::{Problem, Scheme, State};
use crate::maneuver::solution::Outcome;
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use crate::mechanics::body::Body;
use crate::mechanics::direction::{Track, TrackError};
use crate::mechanics::environment::{GravityGradient, Pose, SecondOrderGravity, UniformGravity};
use crate::optimize::discrete::step::Dynamics;
use crate::optimize::methods::method::Watch;
use crate::testing::{Random, attitude_only, full_inertia, graded, moving_ends};
use crate::{Matrix3, Vector3, lie};
use nalgebra::{DMatrix, DVector};

pub(crate) mod reference;

/// Step of the central differences, and tolerance of their truncation and round-off errors.
const STEP: f64 = 1e-5;
const CLOSE: f64 = 1e-8;

pub(crate) fn wheeled(random: &mut Random) -> Problem {
    let mut problem = attitude_only(moving_ends(random, AxisFrame::Body));
    let axes = [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0]];
    let axes: Vec<Vector3> = axes.map(|axis| Vector3::from(axis).normalize()).to_vec();
    let channel = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
    problem.actuation.torque = channel;
    problem.objective = Objective::default();
    problem.actuation.wheels = Some(Wheels {
        momentum: vec![0.3, -0.2, 0.5, 0.1],
        momentum_limit: vec![3.0, 4.0, f64::INFINITY, 5.0],
    });
    problem
}

/// Returns a maneuver by thrusters, one of which acts through the mass centre.
fn pushed(random: &mut Random, limits: Limits) -> Problem {
    let mut problem = moving_ends(random, AxisFrame::Body);
    let mut draw = || Vector3::from_fn(|_, _| random.uniform());
    let directions: Vec<Vector3> = (0..8).map(|_| draw().normalize()).collect();
    let mut positions: Vec<Vector3> = (0..8).map(|_| draw()).collect();
    positions[3] = 0.4 * directions[3];
    problem.actuation = Actuation::of_thrusters(positions, directions, limits).unwrap();
    problem.objective = Objective::default();
    problem
}

fn limited_channel(channel: &ActuatorSet) -> ActuatorSet {
    let count = channel.count();
    let limits = Limits {
        size: Some(vec![1.1; count]),
        norm: Some(1.3),
        rate: Some(vec![2.0; count]),
        ..Limits::default()
    };
    channel.clone().with_limits(limits).unwrap()
}

/// Returns a receding disc whose direction turns at a constant rate about a perpendicular axis.
fn receding(from: Vector3) -> Direction {
    let turn = from.cross(&Vector3::x()) * 0.02;
    let centre = Track::fitted(-1.0, 60.0, 4.0, 16, |time| {
        Ok::<_, TrackError>(crate::lie::exp(&(turn * time)) * from * (2.0 + 0.1 * time))
    });
    Direction::Disc { centre: centre.unwrap(), radius: 0.5 }
}

/// Adds every kind of limit row to a problem; its motion need not satisfy the limits.
fn limited(mut problem: Problem) -> Problem {
    problem.actuation.torque = limited_channel(&problem.actuation.torque);
    problem.actuation.force = problem.actuation.force.as_ref().map(limited_channel);
    let step = problem.step();
    let acting = |side, kind: fn(Vector3) -> Direction, during: During| Constraint {
        name: "cone".into(),
        rule: Rule::Pointing(Pointing {
            side,
            boresights: vec![Vector3::new(0.6, 0.0, 0.8), Vector3::y()],
            directions: vec![kind(Vector3::new(0.0, 0.8, -0.6))],
            half_angle: 0.7,
            margin: 0.02,
            during,
        }),
    };
    let cone = |side, kind| acting(side, kind, During::default());
    // Intervals whose ends lie inside arcs, so that the cone becomes active or inactive on an arc.
    let intervals: Vec<[f64; 2]> = (0..3 * problem.steps)
        .map(|k| 0.93 * step * k as f64)
        .map(|from| [from, from + 0.6 * step])
        .collect();
    let at_times = |side, kind| acting(side, kind, During::intervals(intervals.clone()));
    let rate = |rule| Constraint { name: "rate".into(), rule };
    problem
        .with_constraint(cone(Side::KeepOut, Direction::Fixed))
        .with_constraint(cone(Side::KeepIn, Direction::InFrame))
        .with_constraint(cone(Side::On { within: 0.1 }, Direction::Fixed))
        .with_constraint(cone(Side::KeepOut, receding))
        .with_constraint(at_times(Side::KeepIn, receding))
        .with_constraint(at_times(Side::KeepOut, Direction::InFrame))
        .with_constraint(at_times(Side::KeepIn, Direction::Fixed))
        .with_constraint(rate(Rule::RateNorm(1.5)))
        .with_constraint(rate(Rule::RateAxes(Vector3::new(1.0, 1.2, 1.4))))
}

fn problems() -> Vec<Problem> {
    let mut random = Random(11);
    let gradient = GravityGradient::new(0.7, &full_inertia()).unwrap();
    let pendulum = UniformGravity::new(1.3, 2.0, Vector3::z(), Vector3::new(0.1, -0.2, 0.3)).unwrap();
    let field = SecondOrderGravity::new(1.0, 1.3, &full_inertia()).unwrap();
    let mut all = vec![
        attitude_only(moving_ends(&mut random, AxisFrame::Body)),
        attitude_only(moving_ends(&mut random, AxisFrame::Reference)).with_environment(pendulum),
        attitude_only(moving_ends(&mut random, AxisFrame::Body)).with_environment(gradient.clone()),
        moving_ends(&mut random, AxisFrame::Body).with_environment(field),
        moving_ends(&mut random, AxisFrame::Reference),
        wheeled(&mut random),
        wheeled(&mut random).with_environment(gradient),
        pushed(&mut random, Limits::default()),
    ];
    let euler: Vec<Problem> =
        all.iter().map(|problem| problem.clone().with_scheme(Scheme::LieEuler)).collect();
    all.extend(euler);
    all.into_iter().map(limited).collect()
}

/// Returns the chains of these problems on a uniform grid, on a grid whose longest step is five
/// times the shortest, and with a free duration.
pub(crate) fn chains() -> impl Iterator<Item = (Problem, Model)> {
    problems().into_iter().flat_map(|problem| {
        let grid = graded(problem.scheme, problem.steps);
        let models = [Model::new(&problem, problem.steps), Model::of(&problem, Dynamics::on(&problem, grid))];
        let fuel = Fuel { time_price: Some(0.1), ..Fuel::default() };
        let goals = [Objective::Time, Objective::Fuel(fuel)].map(|objective| Goal { objective });
        let seeking =
            goals.map(|goal| goal::with_goal(&problem, Dynamics::new(&problem, problem.steps), &goal));
        models.into_iter().chain(seeking).map(move |model| (problem.clone(), model))
    })
}

/// Returns chains whose bodies have one-sided thrusters.
fn pushing() -> impl Iterator<Item = (Problem, Model)> {
    let limits = Limits { size: Some(vec![1.1; 8]), one_sided: true, ..Limits::default() };
    let problem = pushed(&mut Random(12), limits);
    [Scheme::LieVerlet, Scheme::LieEuler].into_iter().map(move |scheme| {
        let problem = problem.clone().with_scheme(scheme);
        let model = Model::new(&problem, problem.steps);
        (problem, model)
    })
}

pub(crate) fn random_inputs(random: &mut Random, count: usize) -> Vec<f64> {
    (0..count).map(|_| random.uniform()).collect()
}

fn unit(size: usize, index: usize, value: f64) -> DVector<f64> {
    let mut vector = DVector::zeros(size);
    vector[index] = value;
    vector
}

fn shifted(inputs: &[f64], index: usize, by: f64) -> Vec<f64> {
    let mut inputs = inputs.to_vec();
    inputs[index] += by;
    inputs
}

/// Returns a state of the chain a few steps from the start, under random inputs.
fn somewhere(random: &mut Random, model: &Model) -> Node {
    let mut state = step::opening(model, stretch(model), &random_inputs(random, model.m)).end;
    for stage in 0..3 {
        state = step::step(model, stage, &state, &random_inputs(random, model.m)).unwrap().end;
    }
    state
}

#[test]
fn the_matrices_of_a_step_are_its_derivatives() {
    let mut random = Random(3);
    for (problem, model) in chains() {
        let state = somewhere(&mut random, &model);
        let inputs = random_inputs(&mut random, model.m);
        for stage in [3, model.steps - 1] {
            let step = step::step(&model, stage, &state, &inputs).unwrap();
            let slope = |plus: step::Step, minus: step::Step| {
                let ends = state::difference(&model, &plus.end, &step.end)
                    - state::difference(&model, &minus.end, &step.end);
                (ends / (2.0 * STEP), (plus.arc.turn - minus.arc.turn) / (2.0 * STEP))
            };
            for column in (0..model.n).filter(|column| model.duration != Some(*column)) {
                let at = |by: f64| {
                    step::step(
                        &model,
                        stage,
                        &step::moved(&model, &state, &unit(model.n, column, by)),
                        &inputs,
                    )
                };
                let (end, arc) = slope(at(STEP).unwrap(), at(-STEP).unwrap());
                assert!((end - step.a.column(column)).amax() < CLOSE, "{:?} A {column}", problem.environment);
                assert!((arc - step.arc.slope.column(column)).amax() < CLOSE, "arc {column}");
            }
            for column in 0..model.m {
                let at = |by: f64| step::step(&model, stage, &state, &shifted(&inputs, column, by)).unwrap();
                let (end, _) = slope(at(STEP), at(-STEP));
                assert!((end - step.b.column(column)).amax() < CLOSE, "B {column}");
            }
        }
    }
}

/// Returns the duration as a multiple of the problem's duration: different from 1 if the duration
/// is free.
pub(crate) fn stretch(model: &Model) -> f64 {
    if model.duration.is_some() { 1.3 } else { 1.0 }
}

#[test]
fn the_derivative_of_the_opening_kick_is_that_of_the_state_after_it() {
    let mut random = Random(4);
    for (problem, model) in chains() {
        let inputs = random_inputs(&mut random, model.m);
        let opening = step::opening(&model, stretch(&model), &inputs);
        let slope = |at: &dyn Fn(f64) -> Node| {
            let change = |by: f64| state::difference(&model, &at(by), &opening.end);
            (change(STEP) - change(-STEP)) / (2.0 * STEP)
        };
        for column in 0..model.m {
            let by_input =
                slope(&|by| step::opening(&model, stretch(&model), &shifted(&inputs, column, by)).end);
            let wrong = (by_input - opening.by_inputs.column(column)).amax();
            assert!(wrong < CLOSE, "{:?} input {column}: {wrong:.1e}", problem.environment);
        }
    }
}

#[test]
fn the_derivatives_of_every_row_are_those_of_its_value() {
    let mut random = Random(5);
    let mut met = [0; 3];
    for (problem, model) in chains().chain(pushing()) {
        let rows = LimitRows::of(&problem, &model);
        let state = somewhere(&mut random, &model);
        let (inputs, next) = (random_inputs(&mut random, model.m), random_inputs(&mut random, model.m));
        let value = |row: &LimitRow, z: &DVector<f64>, inputs: &[f64], next: &[f64]| {
            let moved = step::moved(&model, &state, z);
            let step = step::step(&model, row.stage, &moved, next).unwrap();
            let place = Place { state: &moved, inputs, next, arc: Some(&step.arc) };
            row.what.at(&model, row.stage, &place).smooth()
        };
        let size = |value: &RowValue| match value {
            RowValue::Half { c, .. } => *c,
            RowValue::Ball { .. } | RowValue::Idle => f64::NAN,
        };
        let zero = DVector::zeros(model.n);
        for row in rows.rows.iter().filter(|row| row.stage == 4) {
            let there = value(row, &zero, &inputs, &next);
            if matches!(there, RowValue::Idle) {
                continue;
            }
            let [by_state, by_inputs, by_next] = there.slopes().map(|slope| slope.cloned());
            let kind = match row.what {
                What::Cone(_) if row.what.is_of_arc() => 1,
                What::Push { .. } => 2,
                _ => 0,
            };
            met[kind] += 1;
            let compare = |slope: Option<DVector<f64>>, at: &dyn Fn(usize, f64) -> RowValue, count: usize| {
                let slope = slope.unwrap_or_else(|| DVector::zeros(count));
                for column in (0..count).filter(|column| count < model.n || model.duration != Some(*column)) {
                    let difference = (size(&at(column, STEP)) - size(&at(column, -STEP))) / (2.0 * STEP);
                    assert!((difference - slope[column]).abs() < CLOSE, "{:?} column {column}", row.what);
                }
            };
            compare(by_state, &|column, by| value(row, &unit(model.n, column, by), &inputs, &next), model.n);
            compare(
                by_inputs,
                &|column, by| value(row, &zero, &shifted(&inputs, column, by), &next),
                model.m,
            );
            if matches!(row.what, What::InputRate { .. }) {
                compare(
                    by_next,
                    &|column, by| value(row, &zero, &inputs, &shifted(&next, column, by)),
                    model.m,
                );
            }
        }
    }
    // Rows of arcs with an extremum inside must be among those tested.
    assert!(met[0] > 200 && met[1] > 3 && met[2] > 10, "{met:?}");
}

#[test]
fn wheels_keep_the_total_momentum_in_space() {
    let mut random = Random(8);
    let problem = wheeled(&mut random);
    let model = Model::new(&problem, 200);
    let mut state = step::opening(&model, 1.0, &random_inputs(&mut random, 4)).end;
    let before = state.attitude * state.momentum;
    for stage in 0..200 {
        state = step::step(&model, stage, &state, &random_inputs(&mut random, 4)).unwrap().end;
    }
    assert!((state.attitude * state.momentum - before).amax() < 1e-13 * before.norm());
}

/// Returns the reference slew: rest to rest by 120°, with a full inertia matrix and W = diag(1, 2,
/// 0.5).
pub(crate) fn reference_slew(share_of_peak: Option<f64>) -> Problem {
    let weight = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 2.0, 0.5]));
    let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    let channel = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
    let body = Body { inertia: full_inertia(), mass: None };
    let end = lie::exp(&(Vector3::new(1.0, 2.0, -0.5).normalize() * 120f64.to_radians()));
    let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), State::at_rest(end), 2.0)
        .with_actuation(Actuation::torques(channel.clone()))
        .with_objective(Weights::of_torques(weight))
        .with_scheme(Scheme::LieEuler)
        .with_steps(50);
    let Some(share) = share_of_peak else { return problem };
    let free = shot(&problem);
    let peak = free.trajectory.input.iter().fold(0.0f64, |peak, input| peak.max(input.abs()));
    let limits = Limits { size: Some(vec![share * peak; 3]), ..Limits::default() };
    problem.with_actuation(Actuation::torques(channel.with_limits(limits).unwrap()))
}

pub(crate) fn shot(problem: &Problem) -> crate::maneuver::solution::Solution {
    let settings = crate::maneuver::settings::Settings::discrete();
    crate::optimize::search::solve(problem, &settings, None, &mut crate::optimize::search::Silent).unwrap()
}

pub(crate) fn straight(model: &Model) -> Vec<Pose> {
    let relative = lie::log(&model.start.attitude.tr_mul(&model.target.attitude));
    let pose = |stage: usize| {
        let t = model.dynamics.grid.time(stage);
        let along = 3.0 * t * t - 2.0 * t * t * t;
        Pose { position: Vector3::zeros(), attitude: model.start.attitude * lie::exp(&(relative * along)) }
    };
    (0..=model.steps).map(pose).collect()
}

/// After a stop request the initial iterate keeps its states, and its inputs are not computed.
#[test]
fn a_stop_leaves_a_first_iterate_without_inputs() {
    let problem = reference_slew(None);
    let model = Model::new(&problem, problem.steps);
    let stop = Watch { interrupt: &|| Some(Outcome::Interrupted), ..Watch::NONE };
    let [stopped, whole] = [stop, Watch::NONE]
        .map(|watch| first_iterate::along(&model, &LimitRows::default(), &straight(&model), 1.0, &watch));
    let momenta = |iterate: &Iterate| iterate.states.iter().map(|state| state.momentum).collect::<Vec<_>>();
    assert_eq!(momenta(&stopped), momenta(&whole));
    assert!(stopped.inputs.iter().flatten().all(|input| *input == 0.0));
    assert!(whole.inputs.iter().flatten().any(|input| *input != 0.0));
}
