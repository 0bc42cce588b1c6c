//! Conjugate points compared with the negative eigenvalues of the reduced Hessian, assembled
//! densely.

use super::*;
use crate::lie;
use crate::maneuver::grid::{Grid, Scheme};
use crate::maneuver::objective::{Objective, Weights};
use crate::maneuver::problem::{Problem, State};
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame};
use crate::mechanics::body::Body;
use crate::mechanics::environment::UniformGravity;
use crate::optimize::discrete::step::{Costate, Linearization, Sensitivity};
use crate::optimize::discrete::sweep::Node;
use crate::testing::{
    Random, attitude_only, full_inertia, graded, limited, moving_ends, random_vector, reference, vector,
};
use crate::{Matrix3, Vector3};
use nalgebra::DMatrix;

/// Returns a root `G` of a block of the inputs' authority, `Q = G Gᵀ`.
fn root<const N: usize>(q: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let eigen = DMatrix::from_fn(N, N, |row, column| q[(row, column)]).symmetric_eigen();
    let values = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    let root = &eigen.eigenvectors * DMatrix::from_diagonal(&values);
    SMatrix::from_fn(|row, column| root[(row, column)])
}

/// One stage of the accessory problem: `z⁺ = A z + G v` with the cost `½ |v|² + ½ zᵀ H z`.
struct Stage<const N: usize> {
    a: SMatrix<f64, N, N>,
    g: SMatrix<f64, N, N>,
    h: SMatrix<f64, N, N>,
}

/// Returns the accessory problem of an extremal; its first stage is the opening half kick alone.
fn stages<const N: usize>(bvp: &BoundaryValueProblem<N>, costate: &SVector<f64, N>) -> Vec<Stage<N>> {
    let dynamics = &bvp.dynamics;
    let grid = &dynamics.grid;
    let verlet = grid.has_half_kicks();
    let mut nodes: Vec<Node> = Vec::new();
    bvp.sweep_observed(costate, |node| nodes.push(node)).unwrap();
    let identity = SMatrix::<f64, N, N>::identity();
    let kick = |node: &Node, costate: &Costate| dynamics.linear_kick::<N>(&node.point.pose(), costate);
    let opening = kick(&nodes[0], &nodes[0].costate).authority() * grid.kick(0);
    let mut stages = vec![Stage { a: identity, g: root(&opening), h: SMatrix::zeros() }];
    for pair in nodes.windows(2) {
        let costate = pair[1].costate.to_vector::<N>();
        let Linearization { mut a, h: mut curvature, mut q } =
            dynamics.transition::<N>(pair[0].index, &pair[0].point, &costate).unwrap().linear;
        if verlet && pair[1].index == grid.steps() {
            // Halve the last kick: its gradient, curvature and authority.
            let last = kick(&pair[1], &pair[1].costate);
            let half = grid.kick(grid.steps());
            let drift = (identity - last.gradient() * grid.full_kick(grid.steps())) * a;
            curvature -=
                drift.transpose() * last.curvature(&Sensitivity::of_state()).costate() * drift * half;
            a = (identity + last.gradient() * half) * drift;
            q *= 0.5;
        }
        stages.push(Stage { a, g: root(&q), h: curvature });
    }
    stages
}

/// Counts the negative eigenvalues of the second variation on the variations that keep the end
/// fixed.
fn negative_directions<const N: usize>(bvp: &BoundaryValueProblem<N>, costate: &SVector<f64, N>) -> usize {
    let stages = stages(bvp, costate);
    let count = N * stages.len();
    let mut z = DMatrix::<f64>::zeros(N, count);
    let mut form = DMatrix::<f64>::identity(count, count);
    for (index, stage) in stages.iter().enumerate() {
        let dense = |m: &SMatrix<f64, N, N>| DMatrix::from_fn(N, N, |row, column| m[(row, column)]);
        let h = dense(&((stage.h + stage.h.transpose()) * 0.5));
        form += z.transpose() * h * &z;
        z = dense(&stage.a) * z;
        z.view_mut((0, N * index), (N, N)).copy_from(&dense(&stage.g));
    }
    // Projection onto the kernel of z_N, whatever its rank.
    let gram = (&z * z.transpose()).symmetric_eigen();
    let largest = gram.eigenvalues.amax();
    let mut projector = DMatrix::<f64>::identity(count, count);
    for (value, vector) in gram.eigenvalues.iter().zip(gram.eigenvectors.column_iter()) {
        if *value > 1e-14 * largest {
            let row = z.transpose() * vector / value.sqrt();
            projector -= &row * row.transpose();
        }
    }
    let reduced = &projector * form * &projector;
    let eigenvalues = reduced.symmetric_eigen().eigenvalues;
    eigenvalues.iter().filter(|value| **value < -1e-9).count()
}

#[test]
fn the_published_extremals_have_0_2_2_3_conjugate_points() {
    let file = reference("windings.json");
    let body = Body { inertia: full_inertia(), mass: None };
    for case in file["cases"].as_array().unwrap() {
        let end = State::at_rest(lie::exp(&vector::<3>(&case["phi"])));
        let problem = Problem::attitude(body.clone(), State::at_rest(Matrix3::identity()), end, 2.0)
            .with_steps(50)
            .with_scheme(Scheme::LieEuler);
        let bvp = BoundaryValueProblem::<6>::new(&problem, 50);
        let lambda_0 = vector::<6>(&case["lambda0"]).component_div(&bvp.dynamics.units.costate());
        let first = bvp.dynamics.transition::<6>(0, &bvp.start, &lambda_0).unwrap();
        let swept = bvp.sweep(&first.costate_before).unwrap();
        assert!(swept.error.amax() < 1e-12);
        let expected = case["negative_eigenvalues"].as_u64().unwrap() as usize;
        assert_eq!(conjugate_points(&bvp, &first.costate_before), Some(expected));
        assert_eq!(negative_directions(&bvp, &first.costate_before), expected);
    }
}

/// Compares the two counts for a random extremal: any costate defines one, for the end that it
/// reaches.
fn compare<const N: usize>(problem: &Problem, size: f64, random: &mut Random) -> Option<usize> {
    let uniform = Grid::uniform(problem.scheme, 1.0, problem.steps);
    let own = graded(problem.scheme, problem.steps);
    compare_within::<N>(problem, &own, None, size, &mut Random(random.0));
    compare_within::<N>(problem, &uniform, None, size, random)
}

/// Compares the two counts under limits on each input, or on the norm of the output.
fn compare_within<const N: usize>(
    problem: &Problem,
    grid: &Grid,
    norm: Option<bool>,
    size: f64,
    random: &mut Random,
) -> Option<usize> {
    let mut bvp = BoundaryValueProblem::<N>::on(problem, grid.clone());
    // A rest-to-rest turn by about `size` has λ^R = −12 φ, λ^Π = −6 φ.
    let phi = random.vector3().normalize() * size;
    let mut costate = random_vector::<N>(random);
    let mut rotation = costate.fixed_rows_mut::<6>(N - 6);
    rotation *= 0.5 * size;
    rotation -= SVector::<f64, 6>::from_fn(|row, _| if row < 3 { 12.0 } else { 6.0 } * phi[row % 3]);
    bvp.sweep(&costate).ok()?;
    if let Some(norm) = norm {
        let part = 0.65 + 0.3 * random.uniform();
        bvp = BoundaryValueProblem::on(&limited(problem, &costate, norm, part), grid.clone());
        bvp.sweep(&costate).ok()?;
    }
    let (counted, dense) = (conjugate_points(&bvp, &costate), negative_directions(&bvp, &costate));
    let (scheme, actuation) = (problem.scheme, &problem.actuation.torque);
    assert_eq!(counted, Some(dense), "{scheme:?} {actuation:?} {:?} {costate}", problem.environment);
    // The elimination also gives the correct count without limits, by another algorithm.
    assert_eq!(accessory::conjugate_points(&bvp, &costate), Some(dense));
    counted
}

#[test]
fn conjugate_points_are_the_negative_directions_of_the_reduced_hessian() {
    let mut random = Random(43);
    let pendulum = UniformGravity::new(1.0, 1.7, Vector3::z(), Vector3::new(0.1, -0.2, 0.9)).unwrap();
    let axes = |count: usize| {
        let all = [Vector3::x(), Vector3::new(0.2, 1.0, 0.0), Vector3::z(), Vector3::new(0.5, 0.5, -0.7)];
        ActuatorSet::new(all[..count].to_vec(), AxisFrame::Body).unwrap()
    };
    let mut seen = [0usize; 8];
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        for frame in [AxisFrame::Body, AxisFrame::Reference] {
            for count in [2, 3, 4] {
                for size in [1.0, 5.0, 9.0] {
                    let moving = moving_ends(&mut random, frame).with_scheme(scheme).with_steps(60);
                    let mut attitude = attitude_only(moving.clone());
                    if frame == AxisFrame::Body {
                        attitude.actuation = Actuation::torques(axes(count));
                        attitude.objective = Objective::default();
                    }
                    let hanging = attitude.clone().with_environment(pendulum.clone());
                    let mut counts = vec![
                        compare::<6>(&attitude, size, &mut random),
                        compare::<6>(&hanging, size, &mut random),
                    ];
                    if count == 3 {
                        counts.push(compare::<12>(&moving.clone().with_steps(24), size, &mut random));
                    }
                    for found in counts.into_iter().flatten() {
                        seen[found.min(7)] += 1;
                    }
                }
            }
        }
    }
    // The comparison is meaningful only if some extremals have conjugate points.
    assert!(seen[0] >= 10 && seen[1..].iter().sum::<usize>() >= 10, "{seen:?}");
}

fn within<const N: usize>(problem: &Problem, norm: bool, size: f64, random: &mut Random) -> Option<usize> {
    let uniform = Grid::uniform(problem.scheme, 1.0, problem.steps);
    compare_within::<N>(problem, &uniform, Some(norm), size, random)
}

#[test]
fn conjugate_points_within_limits_are_those_of_the_free_inputs() {
    let mut random = Random(47);
    let pendulum = UniformGravity::new(1.0, 1.7, Vector3::z(), Vector3::new(0.1, -0.2, 0.9)).unwrap();
    let axes = |frame: AxisFrame, count: usize| {
        let all = [Vector3::x(), Vector3::new(0.2, 1.0, 0.0), Vector3::z(), Vector3::new(0.5, 0.5, -0.7)];
        ActuatorSet::new(all[..count].to_vec(), frame).unwrap()
    };
    let weights = |torques: usize, forces: usize| {
        let block = |count: usize| {
            DMatrix::from_fn(count, count, |i, j| if i == j { 1.0 + 0.4 * i as f64 } else { 0.0 })
        };
        Objective::from(Weights {
            torque: Some(block(torques)),
            force: Some(block(forces)),
            time_price: None,
        })
    };
    let mut seen = [0usize; 8];
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        for frame in [AxisFrame::Body, AxisFrame::Reference] {
            for norm in [false, true] {
                for size in [1.0, 5.0, 9.0] {
                    let other = if frame == AxisFrame::Body { AxisFrame::Reference } else { AxisFrame::Body };
                    let mut moving = moving_ends(&mut random, frame).with_scheme(scheme).with_steps(30);
                    moving.actuation.torque = axes(frame, 3);
                    moving.actuation.force = Some(axes(other, 4));
                    moving.objective = weights(3, 4);
                    let mut attitude = attitude_only(moving.clone()).with_steps(60);
                    let mut counts = Vec::new();
                    for count in [2, 3, 4] {
                        attitude.actuation = Actuation::torques(axes(frame, count));
                        attitude.objective = weights(count, 4);
                        counts.push(within::<6>(&attitude, norm, size, &mut random));
                    }
                    let hanging = attitude.with_environment(pendulum.clone());
                    counts.push(within::<6>(&hanging, norm, size, &mut random));
                    counts.push(within::<12>(&moving, norm, size, &mut random));
                    for found in counts.into_iter().flatten() {
                        seen[found.min(7)] += 1;
                    }
                }
            }
        }
    }
    assert!(seen[0] >= 10 && seen[1..].iter().sum::<usize>() >= 10, "{seen:?}");
}
