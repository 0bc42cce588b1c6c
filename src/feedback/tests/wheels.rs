//! Tests of neighbouring gains with reaction wheels.

use super::*;
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Wheels};
use crate::mechanics::environment::{Pose, Wrench};

type Vector9 = SMatrix<f64, 9, 1>;

/// Returns a problem with four wheels that store momentum, with or without a force field.
fn problem(random: &mut Random, field: bool) -> Problem {
    let problem = maneuver(random, if field { 3 } else { 0 }).with_steps(40);
    let axes: Vec<Vector3> = [[1.0, 0.1, 0.6], [-1.0, 0.2, 0.6], [0.1, 1.0, 0.6], [0.2, -1.0, 0.6]]
        .map(|axis| Vector3::from(axis).normalize())
        .into();
    let set = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
    let momentum = (0..4).map(|_| 0.4 * random.uniform()).collect();
    let wheels = Wheels { momentum, momentum_limit: vec![f64::INFINITY; 4] };
    problem.with_actuation(Actuation { wheels: Some(wheels), ..Actuation::torques(set) })
}

/// State of the discrete motion under held torques, scaled: attitude, momentum of the body, and
/// momentum of the wheels.
#[derive(Clone, Copy)]
struct State9 {
    attitude: Matrix3,
    momentum: Vector3,
    stored: Vector3,
}

impl State9 {
    fn minus(&self, other: &Self) -> Vector9 {
        let blocks = [
            lie::minus(&self.attitude, &other.attitude),
            self.momentum - other.momentum,
            self.stored - other.stored,
        ];
        Vector9::from_fn(|row, _| blocks[row / 3][row % 3])
    }

    fn step(&self, dynamics: &Dynamics, k: usize, torque: &Vector3) -> Self {
        let half = 0.5 * dynamics.grid.step(k);
        let moment = |attitude: &Matrix3| {
            let pose = Pose { position: Vector3::zeros(), attitude: *attitude };
            let Wrench { moment, .. } = dynamics.environment_wrench(&pose);
            moment
        };
        let momentum = self.momentum + half * (moment(&self.attitude) + torque);
        let stored = self.stored - half * torque;
        let drift = dynamics.gyrostat_drift(k, &(momentum + stored), &stored).unwrap();
        let attitude = self.attitude * drift.f;
        let momentum = drift.momentum_after - stored + half * (moment(&attitude) + torque);
        Self { attitude, momentum, stored: stored - half * torque }
    }
}

/// A motion under given inputs: its states and its record.
struct Recorded {
    dynamics: Dynamics,
    states: Vec<State9>,
    plan: Trajectory,
}

fn torque(problem: &Problem, dynamics: &Dynamics, inputs: &[f64]) -> Vector3 {
    problem.actuation.torque.output(inputs) / dynamics.units.torque()
}

impl Recorded {
    fn new(problem: &Problem, random: &mut Random) -> Self {
        let dynamics = Dynamics::on(problem, Grid::uniform(problem.scheme, 1.0, problem.steps));
        let start = dynamics.point(&problem.start);
        let stored = problem.actuation.stored_momentum() / dynamics.units.momentum();
        let mut states =
            vec![State9 { attitude: start.attitude.value, momentum: start.momentum.value, stored }];
        let m = 4;
        let (from, to) = ([0; 4].map(|_| random.uniform()), [0; 4].map(|_| random.uniform()));
        // Both rows of a step equal the held torque, so their mean does too. The torques are
        // therefore constant.
        let inputs: Vec<f64> = (0..m).map(|input| 0.3 * (from[input] + to[input])).collect();
        for k in 0..problem.steps {
            let last = states[k];
            states.push(last.step(&dynamics, k, &torque(problem, &dynamics, &inputs)));
        }
        let axes = problem.actuation.torque.axes();
        let per_wheel = |stored: &Vector3| {
            // Some wheel momenta with this sum.
            let b = nalgebra::Matrix3xX::from_fn(m, |row, column| axes[column][row]);
            let all = b.transpose() * (&b * b.transpose()).try_inverse().unwrap() * stored;
            all.iter().map(|momentum| momentum * dynamics.units.momentum()).collect::<Vec<_>>()
        };
        let rows = problem.steps + 1;
        let mut plan = Trajectory {
            input_count: m,
            time: (0..rows).map(|k| k as f64 * problem.step()).collect(),
            quaternion: states.iter().map(|state| lie::quaternion_from_rotation(&state.attitude)).collect(),
            angular_velocity: states
                .iter()
                .map(|state| dynamics.j_inverse * state.momentum / dynamics.units.time)
                .collect(),
            wheel_momentum: states.iter().flat_map(|state| per_wheel(&state.stored)).collect(),
            input: (0..rows).flat_map(|_| inputs.clone()).collect(),
            torque: vec![problem.actuation.torque.output(&inputs); rows],
            ..Trajectory::default()
        };
        // The costates of this motion: λ_{k−1} = A_kᵀ λ_k.
        let linear = LinearPlan::new(problem, &plan, Timing::Held).unwrap();
        let unit = dynamics.units.costate::<6>();
        let mut costate = Vector6::from_fn(|_, _| random.uniform());
        let mut costates = vec![costate];
        for step in linear.steps().iter().rev() {
            costate = step.stage.a.transpose() * costate;
            costates.push(costate);
        }
        costates.reverse();
        plan.costates =
            costates.iter().flat_map(|costate| costate.component_mul(&unit).as_slice().to_vec()).collect();
        Self { dynamics, states, plan }
    }

    /// Returns the terminal error of the corrected motion in attitude and body momentum, for the
    /// initial deviation `z`.
    fn miss(&self, problem: &Problem, linear: &LinearPlan, gains: &Gains, z: &Vector9) -> f64 {
        let mut state = self.states[0];
        state.attitude *= lie::exp(&z.fixed_rows::<3>(0).into_owned());
        state.momentum += z.fixed_rows::<3>(3);
        state.stored += z.fixed_rows::<3>(6);
        let mut corrections = Vec::new();
        for k in 0..problem.steps {
            if k % gains.every == 0 {
                let z = state.minus(&self.states[k]);
                let z: Vec<f64> = (0..9).map(|row| z[row] * linear.unit(row)).collect();
                corrections = gains.correction(k, &z).collect();
            }
            let inputs: Vec<f64> =
                self.plan.inputs(k).iter().zip(&corrections).map(|(input, less)| input - less).collect();
            state = state.step(&self.dynamics, k, &torque(problem, &self.dynamics, &inputs));
        }
        state.minus(self.states.last().unwrap()).fixed_rows::<6>(0).norm()
    }
}

/// The motion meets the terminal attitude and rate to second order, for any initial momentum of the
/// wheels. Conservation determines their terminal momentum. This also holds if a correction is held
/// over three steps. A wrong sign of the response to the wheels gives slope 1.
#[test]
fn neighbouring_gains_of_wheels_land_to_second_order() {
    let mut random = Random(9);
    for case in 0..20 {
        let problem = problem(&mut random, case % 2 == 1);
        let recorded = Recorded::new(&problem, &mut random);
        let linear = LinearPlan::new(&problem, &recorded.plan, Timing::Held).unwrap();
        let every = [1, 3][case % 4 / 2];
        let gains = Gains::along(&of_ticks(&linear, every), WHOLE, false).unwrap();
        let gains = gains.held_over(every, problem.steps);
        assert_eq!((gains.states, gains.every), (9, every));
        let direction = Vector9::from_fn(|_, _| random.uniform()).normalize();
        let slope = |gains: &Gains| {
            let miss = |size: f64| recorded.miss(&problem, &linear, gains, &(direction * size));
            (miss(1e-2) / miss(1e-3)).log10()
        };
        let right = slope(&gains);
        assert!((right - 2.0).abs() < 0.1, "{case}: {right}");
        let mut turned = gains.clone();
        turned.rows.chunks_exact_mut(9).for_each(|row| row[6..].iter_mut().for_each(|gain| *gain = -*gain));
        let wrong = slope(&turned);
        assert!((wrong - 1.0).abs() < 0.1, "{case}: {wrong}");
    }
}

/// Claim: `G_kᵀ − G_k = −S(λ^R_{k−1})` in the attitude block, also with wheel momenta.
#[test]
fn the_cost_to_go_of_wheels_has_a_symmetric_hessian() {
    let mut random = Random(19);
    for (field, every) in [(false, 1), (true, 1), (true, 3)] {
        let problem = problem(&mut random, field);
        let recorded = Recorded::new(&problem, &mut random);
        let linear = of_ticks(&LinearPlan::new(&problem, &recorded.plan, Timing::Held).unwrap(), every);
        let mut end = (Matrix9::zeros(), Matrix9::identity());
        end.0.fixed_view_mut::<3, 3>(6, 6).fill_with_identity();
        end.1.fixed_view_mut::<3, 3>(6, 6).fill(0.0);
        let swept =
            neighbouring(linear.count(), |k| linear.steps()[k].with_wheels.as_deref().unwrap(), end, 0.0)
                .unwrap();
        let unit = linear.units().costate::<6>();
        for k in 0..linear.count() - 2 {
            let stage = linear.steps()[k].with_wheels.as_deref().unwrap();
            let step = stage.eliminated();
            let g = step.back * swept.to_go[k] + step.curvature;
            let row = 6 * k * every;
            let costate =
                Vector6::from_column_slice(&recorded.plan.costates[row..row + 6]).component_div(&unit);
            let mut expected = Matrix9::zeros();
            let turn = -lie::hat(&costate.fixed_rows::<3>(0).into_owned());
            expected.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
            let apart = (g.transpose() - g - expected).amax() / g.amax();
            assert!(apart < 1e-11, "{field} {every} {k}: {apart:e}");
        }
    }
}
