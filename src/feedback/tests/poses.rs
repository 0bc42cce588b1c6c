//! Tests of gains for bodies that translate, and for actuator axes that rotate relative to the
//! coordinates.

use super::*;
use crate::mechanics::actuators::AxisFrame;
use crate::mechanics::environment::{CentralGravity, PointMass, Wrench};
use crate::optimize::discrete::linear_plan::{PosedPlan, Stages};
use crate::testing::{attitude_only, moving_ends};
use nalgebra::SVector;

/// A motion of the discrete equations under held inputs: its states, and its record with its own
/// costates.
struct Recorded<const N: usize> {
    dynamics: Dynamics,
    states: Vec<Point>,
    plan: Trajectory,
}

impl<const N: usize> Recorded<N> {
    fn new(problem: &Problem, random: &mut Random) -> Self {
        let dynamics = Dynamics::on(problem, Grid::uniform(problem.scheme, 1.0, problem.steps));
        let m = problem.actuation.count();
        let constant: Vec<f64> = (0..m).map(|_| 0.3 * random.uniform()).collect();
        let mut states = vec![dynamics.point(&problem.start)];
        for k in 0..problem.steps {
            states.push(step::<N>(problem, &dynamics, k, &states[k], &constant));
        }
        let (rows, units) = (problem.steps + 1, &dynamics.units);
        let mut plan = Trajectory {
            input_count: m,
            time: (0..rows).map(|k| k as f64 * problem.step()).collect(),
            position: states.iter().map(|point| point.position.value * units.length).collect(),
            velocity: states
                .iter()
                .map(|point| point.linear_momentum.value * (units.length / units.time))
                .collect(),
            quaternion: states
                .iter()
                .map(|point| lie::quaternion_from_rotation(&point.attitude.value))
                .collect(),
            angular_velocity: states
                .iter()
                .map(|point| dynamics.j_inverse * point.momentum.value / units.time)
                .collect(),
            input: (0..rows).flat_map(|_| constant.clone()).collect(),
            torque: vec![Vector3::zeros(); rows],
            ..Trajectory::default()
        };
        let linear = PosedPlan::new(problem, &plan).unwrap();
        let mut costates = vec![SVector::<f64, N>::from_fn(|_, _| random.uniform())];
        for k in (0..problem.steps).rev() {
            let next = a::<N>(&linear, k).tr_mul(costates.last().unwrap());
            costates.push(next);
        }
        costates.reverse();
        let unit = units.costate::<N>();
        plan.costates =
            costates.iter().flat_map(|row| row.component_mul(&unit).as_slice().to_vec()).collect();
        Self { dynamics, states, plan }
    }

    /// Returns the terminal error of the corrected motion.
    fn miss(&self, problem: &Problem, linear: &PosedPlan, gains: &Gains, z: &SVector<f64, N>) -> f64 {
        let mut point = moved(&self.states[0], z);
        let mut corrections = Vec::new();
        for k in 0..problem.steps {
            if k % gains.every == 0 {
                let z = point.minus(&self.states[k]).to_vector::<N>();
                let z: Vec<f64> = (0..N).map(|row| z[row] * linear.unit(row)).collect();
                corrections = gains.correction(k, &z).collect();
            }
            let inputs: Vec<f64> =
                self.plan.inputs(k).iter().zip(&corrections).map(|(input, less)| input - less).collect();
            point = step::<N>(problem, &self.dynamics, k, &point, &inputs);
        }
        point.minus(self.states.last().unwrap()).to_vector::<N>().norm()
    }
}

/// Returns the scaled matrix `A_k` of a step.
fn a<const N: usize>(linear: &PosedPlan, step: usize) -> SMatrix<f64, N, N> {
    let si = linear.a(step);
    SMatrix::from_fn(|row, column| si[(row, column)] / linear.unit(row) * linear.unit(column))
}

fn moved<const N: usize>(point: &Point, z: &SVector<f64, N>) -> Point {
    let z = crate::optimize::discrete::step::Costate::from_vector(z);
    Point {
        position: Sum::new(point.position.value + z.x),
        linear_momentum: Sum::new(point.linear_momentum.value + z.gamma),
        attitude: Sum::new(point.attitude.value * lie::exp(&z.zeta)),
        momentum: Sum::new(point.momentum.value + z.pi),
    }
}

/// Advances by one step: half a kick, a drift, half a kick.
fn step<const N: usize>(
    problem: &Problem,
    dynamics: &Dynamics,
    k: usize,
    from: &Point,
    inputs: &[f64],
) -> Point {
    let (mut point, half, units) = (*from, 0.5 * dynamics.grid.step(k), &dynamics.units);
    let (force, torque) = problem.actuation.split(inputs);
    let kick = |point: &mut Point| {
        let r = point.attitude.value;
        let set = &problem.actuation.torque;
        let moment = set.frame().to_body(&r, &(set.output(torque) / units.torque()));
        let force = problem.actuation.force.as_ref().map_or_else(Vector3::zeros, |set| {
            set.frame().to_reference(&r, &(set.output(force) / units.force()))
        });
        dynamics.bare_kick::<N>(point, half, &Wrench { force, moment });
    };
    kick(&mut point);
    dynamics.drift::<N>(k, &mut point).unwrap();
    kick(&mut point);
    point
}

/// Returns a problem with torques fixed in the body and forces in the reference frame, or vice
/// versa; free, or in the field of two masses.
fn problem(random: &mut Random, case: usize) -> Problem {
    let frame = if case.is_multiple_of(2) { AxisFrame::Body } else { AxisFrame::Reference };
    let problem = moving_ends(random, frame).with_steps(30).with_scheme(Scheme::LieVerlet);
    if case % 4 < 2 {
        return problem;
    }
    let masses = [(0.6, Vector3::new(0.3, 0.1, 0.02)), (0.9, Vector3::new(-0.2, -0.2 / 3.0, -0.04 / 3.0))];
    let masses = masses.map(|(parameter, position)| PointMass { parameter, position }).to_vec();
    problem.with_environment(CentralGravity::new(masses).unwrap())
}

/// Returns the orders with which the terminal error falls with the initial deviation: for
/// neighbouring gains, for these gains with the wrong sign, and for the regulator. Each correction
/// is held over `every` steps.
fn slopes<const N: usize>(problem: &Problem, random: &mut Random, every: usize) -> [f64; 3] {
    let recorded = Recorded::<N>::new(problem, random);
    let linear = PosedPlan::new(problem, &recorded.plan).unwrap();
    assert_eq!((linear.states(), linear.count()), (N, problem.steps));
    let [gains, regulated] = [WHOLE, Kind::Tvlqr(None)].map(|kind| {
        let gains = Gains::along_pose(&of_posed_ticks(&linear, every), kind, false).unwrap();
        gains.held_over(every, problem.steps)
    });
    assert_eq!((gains.states, gains.inputs), (N, problem.actuation.count()));
    let mut turned = gains.clone();
    turned.rows.iter_mut().skip(N - 3).step_by(N).for_each(|gain| *gain = -*gain);
    let direction = SVector::<f64, N>::from_fn(|_, _| random.uniform()).normalize();
    let miss = |gains: &Gains, size: f64| recorded.miss(problem, &linear, gains, &(direction * size));
    assert!(miss(&regulated, 1e-3) < 0.2e-3, "{:e}", miss(&regulated, 1e-3));
    [(&gains, 1e-3), (&turned, 1e-4), (&regulated, 1e-4)]
        .map(|(gains, size)| (miss(gains, size) / miss(gains, 0.1 * size)).log10())
}

#[test]
fn gains_of_poses_land_to_second_order_and_a_wrong_sign_to_first() {
    let mut random = Random(31);
    for case in 0..20 {
        let problem = problem(&mut random, case);
        let [right, wrong, regulated] = slopes::<12>(&problem, &mut random, 1 + case % 3);
        assert!((right - 2.0).abs() < 0.1, "{case}: {right}");
        assert!((wrong - 1.0).abs() < 0.1, "{case}: {wrong}");
        assert!((regulated - 1.0).abs() < 0.1, "{case}: {regulated}");
    }
}

#[test]
fn gains_of_torques_fixed_in_the_reference_frame_land_to_second_order() {
    let mut random = Random(33);
    for case in 0..20 {
        let problem = attitude_only(problem(&mut random, 2 * (case % 2) + 1));
        let [right, wrong, _] = slopes::<6>(&problem, &mut random, 1 + case % 3);
        assert!((right - 2.0).abs() < 0.1, "{case}: {right}");
        assert!((wrong - 1.0).abs() < 0.1, "{case}: {wrong}");
    }
}

/// Claim: `G_kᵀ − G_k = −S(λ^R_{k−1})` in the attitude block. A step therefore has all second
/// derivatives with the right signs.
#[test]
fn the_cost_to_go_of_poses_has_a_symmetric_hessian() {
    let mut random = Random(37);
    for case in 0..8 {
        let every = [1, 3][case / 4];
        let problem = problem(&mut random, case);
        let recorded = Recorded::<12>::new(&problem, &mut random);
        let linear = of_posed_ticks(&PosedPlan::new(&problem, &recorded.plan).unwrap(), every);
        let Stages::Pose(stages) = &linear.stages else { panic!("a pose") };
        let end = (SMatrix::zeros(), SMatrix::identity());
        let swept = neighbouring(stages.len(), |k| &stages[k], end, 0.0).unwrap();
        let unit = recorded.dynamics.units.costate::<12>();
        for (k, stage) in stages.iter().enumerate().take(linear.count() - 2) {
            let step = stage.eliminated();
            let g = step.back * swept.to_go[k] + step.curvature;
            let row = &recorded.plan.costates[12 * every * k..12 * every * k + 12];
            let costate = SVector::<f64, 12>::from_column_slice(row).component_div(&unit);
            let mut expected = SMatrix::<f64, 12, 12>::zeros();
            let turn = -lie::hat(&costate.fixed_rows::<3>(6).into_owned());
            expected.fixed_view_mut::<3, 3>(6, 6).copy_from(&turn);
            let apart = (g.transpose() - g - expected).amax() / g.amax();
            assert!(apart < 1e-10, "{case} {k}: {apart:e}");
        }
    }
}
