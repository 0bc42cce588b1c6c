//! Identities that hold at every state and in every force field, so that no reference values are
//! needed.

use super::second_order::zoo;
use crate::lie::hat;
use crate::maneuver::problem::{Motion, Problem, State};
use crate::mechanics::actuators::AxisFrame;
use crate::optimize::discrete::step::{Dynamics, Linearization, Point};
use crate::testing::{Random, random_vector};
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, SMatrix, SVector};

/// Random step of a problem: start, costate, end, costate before the step, and matrices.
struct Sample<const N: usize> {
    dynamics: Dynamics,
    start: Point,
    costate: SVector<f64, N>,
    end: Point,
    before: SVector<f64, N>,
    linear: Linearization<N>,
}

impl<const N: usize> Sample<N> {
    fn new(problem: &Problem, random: &mut Random) -> Self {
        let dynamics = Dynamics::new(problem, problem.steps);
        let start = dynamics.point(&State {
            position: Vector3::new(1.0, 0.2, -0.1) + 0.2 * random.vector3(),
            velocity: random.vector3(),
            attitude: random.rotation(),
            angular_velocity: random.vector3(),
        });
        let costate = random_vector(random);
        let step = dynamics.transition::<N>(0, &start, &costate).unwrap();
        Self { dynamics, start, costate, end: step.end, before: step.costate_before, linear: step.linear }
    }
}

/// Returns `Ŝ(a)`, the torsion of the left-trivialised frame: `S(a)` in the attitude block.
fn torsion<const N: usize>(a: Vector3) -> SMatrix<f64, N, N> {
    let mut out = SMatrix::<f64, N, N>::zeros();
    out.view_mut((N - 6, N - 6), (3, 3)).copy_from(&hat(&a));
    out
}

/// Returns the symplectic form on states at body momentum `a`, in units of the rotation's action;
/// `ratio` is the translation's action divided by it.
fn form<const N: usize>(a: Vector3, ratio: f64) -> SMatrix<f64, N, N> {
    let mut out = -torsion::<N>(a);
    for pair in 0..N / 6 {
        let one = Matrix3::from_diagonal_element(if pair + 1 < N / 6 { ratio } else { 1.0 });
        out.view_mut((6 * pair, 6 * pair + 3), (3, 3)).copy_from(&one);
        out.view_mut((6 * pair + 3, 6 * pair), (3, 3)).copy_from(&-one);
    }
    out
}

fn attitude_costate<const N: usize>(costate: &SVector<f64, N>) -> Vector3 {
    costate.fixed_rows::<3>(N - 6).into_owned()
}

fn small<const R: usize, const C: usize>(
    name: &str,
    problem: &Problem,
    found: SMatrix<f64, R, C>,
    scale: f64,
) {
    let error = found.amax() / scale.max(1.0);
    let (field, frame) = (&problem.environment, problem.actuation.torque.frame());
    assert!(error <= 2e-14, "{name}, {field:?}, {frame:?}: {error:e}");
}

fn check<const N: usize>(problem: &Problem, random: &mut Random) {
    let Sample { dynamics, start, costate, end, before, linear } = Sample::<N>::new(problem, random);
    let Linearization { a, h, q } = &linear;
    let identity = SMatrix::<f64, N, N>::identity();
    let body_inputs = [
        &problem.actuation.torque.frame(),
        &problem.actuation.force.as_ref().map_or(AxisFrame::Reference, |c| c.frame()),
    ] == [&AxisFrame::Body, &AxisFrame::Reference];

    // Inputs whose axes rotate relative to the coordinates depend on the attitude: volume is
    // preserved only for state and costate together.
    if body_inputs {
        let dense = DMatrix::from_fn(N, N, |row, column| a[(row, column)]);
        small("det A = 1", problem, SMatrix::<f64, 1, 1>::new(dense.determinant() - 1.0), 1.0);
        let p = costate.fixed_rows::<3>(N - 3);
        let impulse = -dynamics.grid.step(0) * (dynamics.torque.matrix * p);
        let units = &dynamics.units;
        let ratio = units.mass * units.length * units.length / units.inertia;
        let after = form::<N>(end.momentum.value - impulse, ratio);
        let twisted = a.tr_mul(&(after * a)) - form::<N>(start.momentum.value, ratio);
        small("A is symplectic, twisted", problem, twisted, a.amax() * a.amax());
        inverse(problem, &dynamics, &start, &end, &costate, a);
    }

    let asymmetry = h.transpose() - h;
    let twist =
        a.tr_mul(&(torsion::<N>(attitude_costate(&costate)) * a)) - torsion::<N>(attitude_costate(&before));
    small("torsion of H", problem, asymmetry - twist, h.amax());

    let back = a.try_inverse().unwrap().transpose();
    let blocks = [[a + q * back * h, -(q * back)], [-(back * h), back]];
    let place = |blocks: &[[SMatrix<f64, N, N>; 2]; 2]| {
        DMatrix::from_fn(2 * N, 2 * N, |row, column| blocks[row / N][column / N][(row % N, column % N)])
    };
    let omega = |costate: &SVector<f64, N>| {
        place(&[[-torsion::<N>(attitude_costate(costate)), identity], [-identity, SMatrix::zeros()]])
    };
    let t = place(&blocks);
    let defect = (t.transpose() * omega(&costate) * &t - omega(&before)).amax();
    small("T is symplectic", problem, SMatrix::<f64, 1, 1>::new(defect), t.amax() * t.amax());
}

/// Computes `A⁻¹ = A0⁻¹ K(−h)` with `A0⁻¹ = [[F, −Bᵀ], [0, F − S(Π) Bᵀ]]`, without a factorisation.
fn inverse<const N: usize>(
    problem: &Problem,
    dynamics: &Dynamics,
    start: &Point,
    end: &Point,
    costate: &SVector<f64, N>,
    a: &SMatrix<f64, N, N>,
) {
    let mut drifted = *start;
    let drift = dynamics.drift::<N>(0, &mut drifted).unwrap();
    let costate = crate::optimize::discrete::step::Costate::from_vector(costate);
    let kick = dynamics.linear_kick::<N>(&end.pose(), &costate);
    let b: Matrix3 = a.fixed_view::<3, 3>(N - 6, N - 3).into_owned();
    let mut free = SMatrix::<f64, N, N>::identity();
    free.view_mut((N - 6, N - 6), (3, 3)).copy_from(&drift.f);
    free.view_mut((N - 6, N - 3), (3, 3)).copy_from(&-b.transpose());
    let back = drift.f - hat(&start.momentum.value) * b.transpose();
    free.view_mut((N - 3, N - 3), (3, 3)).copy_from(&back);
    if N == 12 {
        free.view_mut((0, 3), (3, 3)).copy_from(&-Matrix3::from_diagonal_element(dynamics.grid.step(0)));
    }
    let unkicked = SMatrix::<f64, N, N>::identity() - kick.gradient::<N>() * dynamics.grid.step(0);
    let left = free * unkicked * a - SMatrix::<f64, N, N>::identity();
    small("A⁻¹ in closed form", problem, left, a.amax() * a.amax());
}

#[test]
fn determinant_inverse_symplecticity_and_torsion_hold_everywhere() {
    let mut random = Random(37);
    for (problem, _) in zoo() {
        for _ in 0..20 {
            match problem.motion {
                Motion::Attitude => check::<6>(&problem, &mut random),
                Motion::RigidBody => check::<12>(&problem, &mut random),
            }
        }
    }
}
