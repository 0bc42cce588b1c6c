//! Stationarity of the sweep's inputs, tested by dual numbers through the plain dynamics alone.
//!
//! For any costate, solved or not, the inputs that the sweep generates satisfy
//! `w_j h W u_j + (∂y_N/∂u_j)ᵀ ν = 0`, with `w_j` the weight of `u_j` in the cost and `ν` the
//! costate at the end. This tests signs, indices and end weights of every scheme and input frame.
//! Under limits the residual points out of the active limit, and is zero for inactive limits.

use super::second_order::zoo;
use super::twin::{Field, State, Twin, V, tangent};
use crate::Vector3;
use crate::maneuver::objective::Weighted;
use crate::maneuver::problem::{Motion, Problem, Scheme};
use crate::mechanics::actuators::ActuatorSet;
use crate::optimize::discrete::control_law::ControlLaw;
use crate::optimize::discrete::sweep::{BoundaryValueProblem, Node};
use crate::testing::{Random, graded, limited, random_vector};
use nalgebra::{DVector, SVector};
use num_dual::{Dual, Dual64};

/// Returns the inputs at a node in SI units, forces first, then torques.
fn inputs<const N: usize>(problem: &Problem, node: &Node, units: &SVector<f64, N>) -> [DVector<f64>; 2] {
    use crate::mechanics::actuators::AxisFrame::{Body, Reference};
    let r = node.point.attitude.value;
    let costate = node.costate.to_vector::<N>().component_mul(units);
    let part = |row: usize| Vector3::new(costate[row], costate[row + 1], costate[row + 2]);
    let weights = problem.objective.weights();
    let torque = weights.torque(&problem.actuation);
    let pi = if torque.set.frame() == Reference { r * part(N - 3) } else { part(N - 3) };
    let force = weights.force(&problem.actuation).map_or_else(
        || DVector::zeros(0),
        |force| {
            let gamma = if force.set.frame() == Body { r.tr_mul(&part(3)) } else { part(3) };
            optimal(&force, &gamma)
        },
    );
    [force, optimal(&torque, &pi)]
}

fn optimal(inputs: &Weighted, costate: &Vector3) -> DVector<f64> {
    let mut row = Vec::new();
    ControlLaw::of(inputs).push_inputs(inputs, costate, &mut row);
    DVector::from_vec(row)
}

/// Returns the part of a gradient that the active limits of the actuator set do not balance.
fn unbalanced(channel: &ActuatorSet, inputs: &DVector<f64>, gradient: &DVector<f64>) -> DVector<f64> {
    let mut rest = gradient.clone();
    if let Some(limits) = &channel.limits().size {
        for (row, limit) in limits.iter().enumerate() {
            // The gradient pushes an input at its limit outward.
            let outward = -gradient[row] * inputs[row].signum();
            if inputs[row].abs() >= *limit && outward >= 0.0 {
                rest[row] = 0.0;
            }
        }
    }
    if let Some(limit) = channel.limits().norm {
        let output = channel.output(inputs.as_slice());
        let b_t = channel.axes().iter().map(|axis| axis.dot(&output));
        let normal = DVector::from_iterator(channel.count(), b_t);
        let outward = -gradient.dot(&normal) / normal.norm_squared();
        if output.norm() >= limit * (1.0 - 1e-12) && outward >= 0.0 {
            rest += normal * outward;
        }
    }
    rest
}

fn check<const N: usize>(problem: &Problem, field: &Field, random: &mut Random) -> f64 {
    let uniform = BoundaryValueProblem::<N>::new(problem, problem.steps);
    let own = BoundaryValueProblem::<N>::on(problem, graded(problem.scheme, problem.steps));
    check_on(problem, &uniform, field, random).max(check_on(problem, &own, field, random))
}

fn check_on<const N: usize>(
    problem: &Problem,
    bvp: &BoundaryValueProblem<N>,
    field: &Field,
    random: &mut Random,
) -> f64 {
    let dynamics = &bvp.dynamics;
    let (units, grid) = (dynamics.units, &dynamics.grid);
    let verlet = grid.has_half_kicks();
    let twin = Twin { dynamics, field: field.clone(), step: 0 };
    let mut nodes = Vec::new();
    // Any costate is suitable that does not rotate the body too fast for its steps.
    let mut costate = random_vector::<N>(random);
    while bvp.sweep_observed(&costate, |node| nodes.push(node)).is_err() {
        costate *= 0.5;
        nodes.clear();
    }
    let last = nodes[problem.steps];
    let mut nu = last.costate;
    if verlet {
        // Half of the last kick belongs to the step back to the physical end.
        let kick = dynamics.kick::<N>(&last.point.pose(), &nu);
        nu.zeta += grid.kick(problem.steps) * kick.slope_r;
        nu.x += grid.kick(problem.steps) * kick.slope_x;
    }
    let nu = nu.to_vector::<N>();
    let rows: Vec<_> = nodes.iter().map(|node| inputs::<N>(problem, node, &units.costate::<N>())).collect();
    let channels = [problem.actuation.force.as_ref(), Some(&problem.actuation.torque)];
    let weights = problem.objective.weights();
    let weighted = [weights.force(&problem.actuation), Some(weights.torque(&problem.actuation))];
    let mut worst = 0.0f64;
    for j in grid.first_input()..=problem.steps {
        for (kind, channel) in channels.into_iter().enumerate() {
            let (Some(channel), Some(weighted)) = (channel, &weighted[kind]) else { continue };
            let (mut gradients, mut largest) = (DVector::zeros(channel.count()), 0.0f64);
            let effort = &weighted.weight * &rows[j][kind] * (grid.kick(j) * problem.seconds());
            for component in 0..channel.count() {
                let varied = |row: usize, which: usize| -> V<Dual64> {
                    let unit = if which == 0 { units.force() } else { units.torque() };
                    let Some(channel) = channels[which] else { return V::from_element(Dual::new(0.0, 0.0)) };
                    let value = channel.output(rows[row][which].as_slice()) / unit;
                    let hit = row == j && which == kind;
                    let slope = if hit { channel.axes()[component] / unit } else { Vector3::zeros() };
                    V::from_fn(|i, _| Dual::new(value[i], slope[i]))
                };
                let mut state = State::<Dual64>::of(&bvp.start);
                let kick = |state: &mut State<Dual64>, row: usize, weight: f64| {
                    twin.kick(state, weight, &varied(row, 0), &varied(row, 1));
                };
                if verlet {
                    kick(&mut state, 0, grid.kick(0));
                }
                for row in 1..=problem.steps {
                    state = twin.drift(row - 1, &state);
                    kick(&mut state, row, grid.full_kick(row));
                }
                if verlet {
                    kick(&mut state, problem.steps, -grid.kick(problem.steps));
                }
                let terms = tangent::<N, f64>(&state).component_mul(&nu) * units.cost;
                let gradient = terms.sum();
                let scale = effort.amax().max(terms.abs().sum()).max(units.cost * grid.mean_step());
                gradients[component] = effort[component] + gradient;
                largest = largest.max(scale);
            }
            worst = worst.max(unbalanced(channel, &rows[j][kind], &gradients).amax() / largest);
        }
    }
    worst
}

#[test]
fn any_costate_generates_stationary_controls() {
    let mut random = Random(29);
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        for (problem, field) in zoo() {
            let problem = problem.with_scheme(scheme);
            let worst = match problem.motion {
                Motion::Attitude => check::<6>(&problem, &field, &mut random),
                Motion::RigidBody => check::<12>(&problem, &field, &mut random),
            };
            let frame = problem.actuation.torque.frame();
            assert!(worst < 3e-14, "{scheme:?} {field:?} {frame:?}: {worst:e}");
        }
    }
}

fn check_within<const N: usize>(problem: &Problem, norm: bool, field: &Field, random: &mut Random) -> f64 {
    let bvp = BoundaryValueProblem::<N>::new(problem, problem.steps);
    let mut costate = random_vector::<N>(random);
    while bvp.sweep(&costate).is_err() {
        costate *= 0.5;
    }
    let part = 0.5 + 0.3 * random.uniform();
    check::<N>(&limited(problem, &costate, norm, part), field, random)
}

#[test]
fn within_limits_any_costate_generates_controls_that_only_the_limits_hold_back() {
    let mut random = Random(31);
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        for (problem, field) in zoo() {
            for norm in [false, true] {
                let problem = problem.clone().with_scheme(scheme);
                let worst = match problem.motion {
                    Motion::Attitude => check_within::<6>(&problem, norm, &field, &mut random),
                    Motion::RigidBody => check_within::<12>(&problem, norm, &field, &mut random),
                };
                let frame = problem.actuation.torque.frame();
                assert!(worst < 3e-14, "{scheme:?} {field:?} {frame:?}: {worst:e}");
            }
        }
    }
}
