//! The count of descent directions compared with the shooting's conjugate points, and with costs
//! along feasible curves.

use super::Conditions;
use crate::lie;
use crate::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Path, Problem, Scheme};
use crate::maneuver::settings::{Method, Settings};
use crate::maneuver::solution::{Outcome, Solution};
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use crate::mechanics::environment::UniformGravity;
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::model::Model;
use crate::optimize::chain::model::step;
use crate::optimize::chain::rows::LimitRows;
use crate::optimize::chain::tests::reference::newton::{Polished, newton};
use crate::optimize::chain::tests::reference::rows::RowValue;
use crate::optimize::chain::{Chain, Multipliers, first_iterate};
use crate::optimize::methods::method::Watch;
use crate::optimize::search::{Silent, solve};
use crate::testing::{Random, attitude_only, moving_ends};
use crate::{Vector3, mechanics::environment::Pose};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Returns paths between the ends of a slew: the short one, and others that are usually not minima.
fn paths(problem: &Problem) -> Vec<Path> {
    let short = lie::log(&problem.start.attitude.tr_mul(&problem.end.attitude));
    let wound = |turns: f64| Path::AsGiven(short * (1.0 + turns * TAU / short.norm()));
    vec![Path::Shortest, wound(-1.0), wound(1.0), wound(-2.0)]
}

/// Returns a random slew with a diagonal weight, so that its inputs may have limits.
fn slew(random: &mut Random, frame: AxisFrame, steps: usize) -> Problem {
    let mut problem = attitude_only(moving_ends(random, frame)).with_steps(steps);
    problem.start.angular_velocity *= 0.1;
    problem.end.angular_velocity *= 0.1;
    let Objective::Effort(weights) = &mut problem.objective else { unreachable!("effort") };
    weights.torque = weights.torque.as_ref().map(|weight| DMatrix::from_diagonal(&weight.diagonal()));
    problem
}

fn shot(problem: &Problem) -> Option<Solution> {
    let settings = Settings { method: Method::Shooting, ..Settings::discrete() };
    let found = solve(problem, &settings, None, &mut Silent).unwrap();
    (found.outcome == Outcome::Converged).then_some(found)
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// Limits the torques to the fraction `part` of their peak in the plan `free`: their norm if
/// `norm`, otherwise each torque.
fn within(problem: &Problem, free: &Solution, norm: bool, part: f64) -> Problem {
    let channel = &problem.actuation.torque;
    let trajectory = &free.trajectory;
    let limits = if norm {
        let peak = largest(trajectory.torque.iter().map(|torque| torque.norm()));
        Limits { norm: Some(part * peak), ..Limits::default() }
    } else {
        let peak = largest(trajectory.input.iter().map(|input| input.abs()));
        Limits { size: Some(vec![part * peak; channel.count()]), ..Limits::default() }
    };
    let channel = channel.clone().with_limits(limits).unwrap();
    problem.clone().with_actuation(Actuation::torques(channel))
}

/// Applies Newton's method on the active set to the path of a plan; the result may be a saddle.
fn along(problem: &Problem, plan: &Solution) -> Option<(Chain, Polished)> {
    let chain = Chain::new(problem, problem.steps);
    let (model, rows) = (&chain.model, &chain.rows);
    let start = first_iterate::along(model, rows, &poses(plan), 1.0, &Watch::NONE);
    let none = Multipliers {
        costates: vec![DVector::zeros(model.n); model.steps + 1],
        terminal: DVector::zeros(model.terminal_count()),
        rows: vec![0.0; rows.rows.len()],
    };
    let found = newton(model, rows, &start, &none)?;
    Some((chain, found))
}

fn descents(chain: &Chain, at: &Polished) -> Option<usize> {
    Conditions::of(chain, &at.iterate, &at.multipliers, &Watch::NONE)?.descents()
}

/// Claim: the number of descent directions equals the number of conjugate points that shooting
/// finds. The two counts share only the derivatives of the model.
#[test]
fn descents_are_the_conjugate_points_of_the_shooting() {
    let mut random = Random(59);
    let mut seen = [0usize; 6];
    for index in 0..12 {
        let frame = if index % 3 == 0 { AxisFrame::Reference } else { AxisFrame::Body };
        let scheme = if index % 2 == 0 { Scheme::LieVerlet } else { Scheme::LieEuler };
        let mut free = slew(&mut random, frame, 40).with_scheme(scheme);
        if index % 4 == 3 {
            let field = UniformGravity::new(1.0, 1.7, Vector3::z(), Vector3::new(0.1, -0.2, 0.9)).unwrap();
            free = free.with_environment(field);
        }
        for path in paths(&free) {
            let free = free.clone().with_path(path);
            let Some(found) = shot(&free) else { continue };
            let limited = [false, true].map(|norm| within(&free, &found, norm, 0.85));
            for problem in [free].iter().chain(&limited) {
                let Some(shot) = shot(problem) else { continue };
                let Some((chain, found)) = along(problem, &shot) else { continue };
                let cost = found.cost * chain.model.dynamics.units.cost;
                if (cost / shot.cost - 1.0).abs() < 1e-9 {
                    let points = shot.optimality.conjugate_points;
                    let torque = &problem.actuation.torque;
                    assert_eq!(descents(&chain, &found), points, "{index} {path:?} {torque:?}");
                    seen[points.unwrap().min(5)] += 1;
                }
            }
        }
    }
    assert!(seen[0] >= 10 && seen[1..].iter().sum::<usize>() >= 10, "{seen:?}");
}

/// Cost and conditions as functions of the inputs alone.
struct Reduced<'a> {
    model: &'a Model,
    rows: &'a LimitRows,
    acting: Vec<bool>,
    /// Pseudo-inverse of the Jacobian of the conditions.
    inverse: DMatrix<f64>,
}

impl Reduced<'_> {
    fn iterate(&self, inputs: &DVector<f64>) -> Iterate {
        let (m, first) = (self.model.m, self.model.first_input());
        let mut all = vec![vec![0.0; m]; first];
        all.extend(inputs.as_slice().chunks(m).map(<[f64]>::to_vec));
        let first = step::opening(self.model, 1.0, &all[0]);
        Iterate { states: vec![first], inputs: all }.replayed(self.model).unwrap()
    }

    /// Returns the values of the terminal conditions and of the active rows.
    fn conditions(&self, inputs: &DVector<f64>) -> DVector<f64> {
        let evaluated = self.iterate(inputs).evaluate(self.model, self.rows, Watch::NONE).unwrap();
        let mut values: Vec<f64> = evaluated.terminal.iter().copied().collect();
        for (value, _) in evaluated.rows.iter().zip(&self.acting).filter(|(_, acting)| **acting) {
            let RowValue::Half { c, .. } = value.smooth() else { panic!("an idle row acts") };
            values.push(c);
        }
        DVector::from_vec(values)
    }

    fn jacobian(&self, inputs: &DVector<f64>) -> DMatrix<f64> {
        let step = 1e-5;
        let columns: Vec<DVector<f64>> = (0..inputs.len())
            .map(|column| {
                let mut by = DVector::zeros(inputs.len());
                by[column] = step;
                (self.conditions(&(inputs + &by)) - self.conditions(&(inputs - &by))) / (2.0 * step)
            })
            .collect();
        DMatrix::from_columns(&columns)
    }

    /// Returns the cost of the nearest inputs that satisfy all conditions.
    fn cost(&self, mut inputs: DVector<f64>) -> f64 {
        let mut left = self.conditions(&inputs);
        for _ in 0..12 {
            if left.amax() < 1e-13 {
                break;
            }
            inputs -= &self.inverse * left;
            left = self.conditions(&inputs);
        }
        assert!(left.amax() < 1e-11);
        self.iterate(&inputs).cost(self.model)
    }
}

/// Counts the directions with negative curvature of the cost along curves on which all conditions
/// hold, without multipliers and second derivatives. Returns `None` if a curvature is too small to
/// decide.
fn descents_along_curves(
    model: &Model,
    rows: &LimitRows,
    iterate: &Iterate,
    acting: Vec<bool>,
) -> Option<usize> {
    let first = model.first_input();
    let inputs = DVector::from_vec(iterate.inputs[first..].concat());
    let mut reduced = Reduced { model, rows, acting, inverse: DMatrix::zeros(0, 0) };
    let jacobian = reduced.jacobian(&inputs);
    let count = inputs.len();
    let gram = jacobian.tr_mul(&jacobian).symmetric_eigen();
    let flat = 1e-9 * gram.eigenvalues.amax();
    let free: Vec<DVector<f64>> = (0..count)
        .filter(|index| gram.eigenvalues[*index] < flat)
        .map(|index| gram.eigenvectors.column(index).into_owned())
        .collect();
    reduced.inverse = jacobian.pseudo_inverse(1e-6).unwrap();
    let t = 2e-3;
    let here = reduced.cost(inputs.clone());
    let curvature = |direction: &DVector<f64>| {
        (reduced.cost(&inputs + direction * t) + reduced.cost(&inputs - direction * t) - 2.0 * here) / (t * t)
    };
    let own: Vec<f64> = free.iter().map(curvature).collect();
    let hessian = DMatrix::from_fn(free.len(), free.len(), |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Equal => own[i],
        // The polarisation identity; each pair is computed once.
        std::cmp::Ordering::Less => 0.5 * (curvature(&(&free[i] + &free[j])) - own[i] - own[j]),
        std::cmp::Ordering::Greater => 0.0,
    });
    let hessian = &hessian + hessian.transpose() - DMatrix::from_diagonal(&hessian.diagonal());
    let values = hessian.symmetric_eigen().eigenvalues;
    let clear = values.iter().all(|value| value.abs() > 1e-4 * values.amax());
    clear.then(|| values.iter().filter(|value| **value < 0.0).count())
}

fn poses(solution: &Solution) -> Vec<Pose> {
    let attitude = |q| lie::project_to_rotation(&lie::rotation_from_quaternion(q));
    let pose = |q| Pose { position: Vector3::zeros(), attitude: attitude(q) };
    solution.trajectory.quaternion.iter().map(pose).collect()
}

/// Adds a rate limit below the peak, or a cone that intersects the path of a boresight, or both.
fn fenced(problem: &Problem, free: &Solution, depth: f64, random: &mut Random) -> Problem {
    let peak = largest(free.trajectory.angular_velocity.iter().map(|rate| rate.norm()));
    let rate = Constraint { name: "rate".into(), rule: Rule::RateNorm((1.0 - 0.02 * depth) * peak) };
    let boresight = random.vector3().normalize();
    let middle = &free.trajectory.quaternion[problem.steps / 2];
    let seen = lie::rotation_from_quaternion(middle) * boresight;
    let aside = lie::exp(&(random.vector3().normalize() * (0.1 - 0.01 * depth)));
    let cone = Pointing::new(
        Side::KeepOut,
        vec![boresight],
        vec![Direction::Fixed((aside * seen).normalize())],
        0.1,
    );
    let cone = Constraint { name: "cone".into(), rule: Rule::Pointing(cone) };
    let problem = problem.clone();
    match (3.0 * (random.uniform() + 1.0)) as usize {
        0 | 1 => problem.with_constraint(rate),
        2 | 3 => problem.with_constraint(cone),
        _ => problem.with_constraint(rate).with_constraint(cone),
    }
}

/// Returns the problem with a pyramid of reaction wheels as actuators.
fn on_wheels(problem: &Problem) -> Problem {
    let axes = [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0]];
    let axes = axes.map(|axis| Vector3::from(axis).normalize()).to_vec();
    let channel = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
    let mut problem = problem.clone().with_actuation(Actuation::torques(channel));
    problem.objective = Objective::default();
    let wheels = Wheels { momentum: vec![0.1, -0.1, 0.2, 0.0], momentum_limit: vec![f64::INFINITY; 4] };
    problem.actuation.wheels = Some(wheels);
    problem
}

#[test]
fn descents_are_those_of_the_cost_along_curves_that_keep_what_acts() {
    let mut random = Random(61);
    let (mut minima, mut saddles) = (0, 0);
    // Cases with an active rate limit or cone.
    let (mut minima_at_states, mut saddles_at_states) = (0, 0);
    for index in 0..40 {
        let scheme = if index % 2 == 0 { Scheme::LieVerlet } else { Scheme::LieEuler };
        let frame = if index % 5 == 4 { AxisFrame::Reference } else { AxisFrame::Body };
        let free = slew(&mut random, frame, 18).with_scheme(scheme);
        for path in paths(&free) {
            let free = free.clone().with_path(path);
            let Some(found) = shot(&free) else { continue };
            // Enough minima have been tested.
            if minima >= 12 && found.optimality.conjugate_points == Some(0) {
                continue;
            }
            let mut fence = |depth: f64| {
                let limited = within(&free, &found, index % 3 == 1, 1.0 - 0.03 * depth);
                fenced(&limited, &found, depth, &mut random)
            };
            let reached = if index % 5 == 2 {
                let problem = on_wheels(&fence(1.0));
                along(&problem, &found)
            } else {
                along(&free, &found).and_then(|(_, unlimited)| {
                    [1.0, 0.3, 0.1, 0.03].into_iter().find_map(|depth| {
                        let problem = fence(depth);
                        let chain = Chain::new(&problem, problem.steps);
                        let mut multipliers = unlimited.multipliers.clone();
                        multipliers.rows = vec![0.0; chain.rows.rows.len()];
                        let found = newton(&chain.model, &chain.rows, &unlimited.iterate, &multipliers)?;
                        Some((chain, found))
                    })
                })
            };
            let Some((chain, polished)) = reached else { continue };
            let (model, rows) = (&chain.model, &chain.rows);
            let multipliers = &polished.multipliers;
            let acting: Vec<bool> = multipliers.rows.iter().map(|multiplier| *multiplier > 0.0).collect();
            let states = rows.rows.iter().zip(&acting).filter(|(row, acts)| **acts && row.group > 0);
            let at_states = states.count() > 0;
            let iterate = polished.iterate.replayed(model).unwrap();
            let Some(expected) = descents_along_curves(model, rows, &iterate, acting) else { continue };
            let counted = descents(&chain, &polished);
            assert_eq!(counted, Some(expected), "{index} {path:?}");
            *(if expected == 0 { &mut minima } else { &mut saddles }) += 1;
            *(if expected == 0 { &mut minima_at_states } else { &mut saddles_at_states }) +=
                usize::from(at_states);
        }
    }
    let seen = [minima, minima_at_states, saddles, saddles_at_states];
    assert!(seen.iter().zip([10, 6, 4, 2]).all(|(seen, least)| *seen >= least), "{seen:?}");
}
