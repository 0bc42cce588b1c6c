//! Linearisation of a recorded plan: the matrices of its steps.

use super::authority::Law;
use super::{
    Applied, HalfKick, LinearPlan, LinearStep, Matrix6, Matrix6x3, Matrix9, Parts, Stage, Timing,
    Unlinearised, Vector6, blocks, kick,
};
use crate::maneuver::duration::Duration;
use crate::maneuver::grid::{Grid, Scheme};
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::Trajectory;
use crate::mechanics::environment::Pose;
use crate::numerics::compensated::Sum;
use crate::optimize::discrete::step::drift::Drift;
use crate::optimize::discrete::step::{Costate, Dynamics, Point, Units};
use crate::{Matrix3, Vector3, lie};
use nalgebra::{Matrix3xX, SMatrix};

/// A plan of a maneuver to be linearised.
pub(super) struct Beside<'a> {
    pub problem: &'a Problem,
    pub plan: &'a Trajectory,
    pub timing: Timing,
    pub count: usize,
    /// Whether torques are held but the recorded costates are those after full kicks, half a kick
    /// beyond the nodes.
    pub beyond: bool,
}

impl Beside<'_> {
    pub fn linearise(&self) -> Result<LinearPlan, Unlinearised> {
        let (problem, plan, count) = (self.problem, self.plan, self.count);
        let scheme = if problem.switches() { Scheme::LieVerlet } else { problem.scheme };
        let duration = *plan.time.last().unwrap_or(&f64::NAN);
        // If the duration was free, the duration of the plan is used.
        let problem = &Problem { duration: Duration::Given(duration), ..problem.clone() };
        let units = Units::of(problem);
        let grid = if problem.switches() {
            let lengths: Vec<f64> = plan.time.windows(2).map(|ends| ends[1] - ends[0]).collect();
            Grid::of_lengths(scheme, &lengths)
                .map_err(|_| Unlinearised::Step)?
                .with_duration(duration / units.time)
        } else {
            Grid::uniform(scheme, duration / units.time, count)
        };
        let dynamics = Dynamics::on(problem, grid.clone());
        let nodes: Vec<(Matrix3, Vector3)> = plan
            .quaternion
            .iter()
            .zip(&plan.angular_velocity)
            .map(|(quaternion, rate)| (lie::rotation_from_quaternion(quaternion), *rate))
            .collect();
        let m = problem.actuation.torque.count();
        let forces = plan.input_count - m;
        let row = |index: usize| plan.inputs(index)[forces..].to_vec();
        let first_row = scheme.first_input();
        let applied = |inputs: Vec<f64>| Applied {
            torque: problem.actuation.torque.output(&inputs) / units.torque(),
            inputs,
        };
        let given = |k: usize| match self.timing {
            Timing::AtNodes => row(k + 1 - first_row),
            Timing::Held if first_row == 0 && !problem.switches() => {
                let mean = |(a, b): (&f64, &f64)| 0.5 * (a + b);
                row(k).iter().zip(&row(k + 1)).map(mean).collect()
            }
            Timing::Held => row(k),
        };
        let none = || applied(vec![0.0; m]);
        let before = if self.timing == Timing::AtNodes && first_row == 0 { applied(row(0)) } else { none() };
        let law = Law::of(problem, &units);
        let mut steps: Vec<LinearStep> = Vec::with_capacity(count);
        for k in 0..count {
            let applied = applied(given(k));
            let torque = match (self.timing, k) {
                (Timing::Held, _) => applied.torque,
                (Timing::AtNodes, 0) => before.torque,
                (Timing::AtNodes, _) => steps[k - 1].applied.torque,
            };
            let (authority, to_inputs) = law.at(&applied.inputs);
            let given = LinearStep { to_inputs, ..LinearStep::of(applied) };
            steps.push(self.step(&dynamics, &nodes, k, &torque, &authority, given)?);
        }
        let half = |node: usize, applied: Applied| {
            let outer = self.timing == Timing::AtNodes && scheme == Scheme::LieVerlet;
            let weight = if outer { 0.5 * grid.full_kick(node) } else { 0.0 };
            let gradient = dynamics.field(&self.pose(&units, &nodes[node].0)).1.rr;
            HalfKick { weight, applied, gradient }
        };
        let last = steps[count - 1].applied.clone();
        let axes = problem.actuation.torque.axes();
        Ok(LinearPlan {
            timing: self.timing,
            j: dynamics.j,
            outer: [half(0, before), half(count, last)],
            steps,
            times: plan.time.clone(),
            nodes,
            axes: Matrix3xX::from_fn(m, |row, column| axes[column][row]),
            stored: (0..=count).filter_map(|node| self.stored(&units, node)).collect(),
            stops: Vec::new(),
            units,
        })
    }

    /// Returns the wheel momentum at a node, body axes, scaled; `None` without wheels.
    fn stored(&self, units: &Units, node: usize) -> Option<Vector3> {
        self.problem.actuation.wheels.as_ref()?;
        let set = &self.problem.actuation.torque;
        let m = set.count();
        // The momentum of each wheel is about its axis.
        Some(set.output(&self.plan.wheel_momentum[node * m..(node + 1) * m]) / units.momentum())
    }

    fn pose(&self, units: &Units, attitude: &Matrix3) -> Pose {
        Pose { position: self.problem.start.position / units.length, attitude: *attitude }
    }

    /// Returns the costate `λ_k` of step k, scaled; zero if the plan records none.
    fn costate(&self, units: &Units, step: usize) -> Costate {
        let row =
            if self.problem.switches() { step + 1 } else { step + 1 - self.problem.scheme.first_input() };
        let unit = units.costate::<6>();
        let recorded = self.plan.costates.get(6 * row..6 * row + 6);
        let vector =
            recorded.map_or_else(Vector6::zeros, |row| Vector6::from_column_slice(row).component_div(&unit));
        Costate::from_vector(&vector)
    }

    /// Linearises step k. `torque` is the torque of the plan at its beginning.
    fn step(
        &self,
        dynamics: &Dynamics,
        nodes: &[(Matrix3, Vector3)],
        k: usize,
        torque: &Vector3,
        authority: &Matrix3,
        given: LinearStep,
    ) -> Result<LinearStep, Unlinearised> {
        let units = &dynamics.units;
        let length = dynamics.grid.step(k);
        let (kicks, ahead, acts) = match self.timing {
            Timing::Held => ([0.5 * length; 2], 0.5 * length, length),
            Timing::AtNodes => {
                let full = dynamics.grid.full_kick(k + 1);
                ([0.0, full], dynamics.grid.ahead(k), full)
            }
        };
        let (attitude, rate) = &nodes[k];
        let begin = self.pose(units, attitude);
        let field = dynamics.environment_wrench(&begin).moment;
        let momentum = dynamics.j * rate * units.time + ahead * (field + torque);
        let recorded = self.costate(units, k);
        let (gradient, bent) = dynamics.field_derivatives(&self.pose(units, &nodes[k + 1].0), &recorded.pi);
        let beyond = if self.beyond { 0.5 * dynamics.grid.full_kick(k + 1) } else { 0.0 };
        let costate = Costate { zeta: recorded.zeta + beyond * gradient.tr_mul(&recorded.pi), ..recorded };
        let between = Costate { zeta: costate.zeta + kicks[1] * gradient.tr_mul(&costate.pi), ..costate };
        let zero = Matrix3::zeros();
        let mut free = Matrix6::zeros();
        let mut wheels = Matrix6x3::zeros();
        let mut of_wheels = None;
        let (drift, drift_b, d) = if let Some(stored) = self.stored(units, k) {
            let stored = stored - kicks[0] * torque;
            let turned = dynamics.gyrostat_drift(k, &(momentum + stored), &stored)?;
            let (f_t, after) = (turned.f.transpose(), turned.momentum_after);
            let drift = Drift { h: length, f: turned.f, momentum: momentum + stored, momentum_after: after };
            let by_both = turned.by_momentum + turned.by_wheels;
            let of_momentum = f_t - Matrix3::identity() + lie::hat(&after) * by_both;
            wheels.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_both);
            wheels.fixed_view_mut::<3, 3>(3, 0).copy_from(&of_momentum);
            let c = f_t + lie::hat(&after) * turned.by_momentum;
            let total = momentum + stored;
            of_wheels = Some(dynamics.gyrostat_curvature(k, &turned, [&total, &stored], &between));
            (drift, turned.by_momentum, blocks([[&f_t, &turned.by_momentum], [&zero, &c]]))
        } else {
            let mut point = Point {
                position: Sum::new(begin.position),
                linear_momentum: Sum::new(Vector3::zeros()),
                attitude: Sum::new(*attitude),
                momentum: Sum::new(momentum),
            };
            let drift = dynamics.drift::<6>(k, &mut point)?;
            let linear = dynamics.linear_drift(&drift, &dynamics.drift_matrix(&drift), &between);
            free = blocks([[&zero, &linear.h12], [&zero, &linear.h22]]);
            (drift, linear.b, blocks([[&linear.f_t, &linear.b], [&zero, &linear.c]]))
        };
        let mut first = (zero, zero);
        if kicks[0] > 0.0 {
            let costate = Costate::from_vector(&d.tr_mul(&between.to_vector::<6>()));
            first = dynamics.field_derivatives(&begin, &costate.pi);
        }
        let gradients = [kicks[0] * first.0, kicks[1] * gradient];
        let bends = [kicks[0] * first.1, kicks[1] * bent];
        let of_attitudes = |block: &Matrix3| blocks([[block, &zero], [&zero; 2]]);
        let momenta = |weight: f64| {
            let mut out = Matrix6x3::zeros();
            out.fixed_view_mut::<3, 3>(3, 0).fill_diagonal(weight);
            out
        };
        let parts = Parts {
            kicks: gradients.map(|gradient| kick(&gradient)),
            drift: d,
            curvature: free,
            inputs: kicks.map(momenta),
            bends: bends.map(|bend| of_attitudes(&bend)),
            mixed: [Matrix6x3::zeros(); 2],
        };
        let after = parts.kicks[1] * d;
        let moved_by_wheels = parts.kicks[1] * wheels;
        let with_wheels = of_wheels.map(|of_total| {
            let parts = beside_wheels(&parts, &wheels, &of_total, kicks);
            Box::new(Stage::of(&parts, *authority, acts))
        });
        let mut stage = Stage::of(&parts, *authority, acts);
        if let Some(with_wheels) = &with_wheels {
            stage.given_by_wheels(with_wheels);
        }
        Ok(LinearStep {
            stage,
            kicks,
            drift,
            drift_b,
            after,
            wheels: moved_by_wheels,
            with_wheels,
            gradient,
            ..given
        })
    }
}

/// Extends the parts of a step by the wheel momentum as additional states; `of_total` is the
/// curvature with respect to attitude, total momentum and wheel momentum.
fn beside_wheels(
    parts: &Parts<6, 3>,
    wheels: &Matrix6x3,
    of_total: &Matrix9,
    weights: [f64; 2],
) -> Parts<9, 3> {
    let whole = |of: &Matrix6, rest: f64| {
        let mut out = Matrix9::from_diagonal_element(rest);
        out.fixed_view_mut::<6, 6>(0, 0).copy_from(of);
        out
    };
    let mut drift = whole(&parts.drift, 1.0);
    drift.fixed_view_mut::<6, 3>(0, 6).copy_from(wheels);
    // H = Π + μ.
    let mut total = Matrix9::identity();
    total.fixed_view_mut::<3, 3>(3, 6).fill_with_identity();
    let stores = |weight: f64| {
        let mut out = SMatrix::<f64, 9, 3>::zeros();
        out.fixed_view_mut::<3, 3>(3, 0).fill_diagonal(weight);
        out.fixed_view_mut::<3, 3>(6, 0).fill_diagonal(-weight);
        out
    };
    Parts {
        kicks: parts.kicks.map(|kick| whole(&kick, 1.0)),
        drift,
        curvature: total.transpose() * of_total * total,
        inputs: weights.map(stores),
        bends: parts.bends.map(|bend| whole(&bend, 0.0)),
        mixed: [SMatrix::zeros(); 2],
    }
}
