//! The motion under pulses, and how its end and its costates answer to their times.
//!
//! With `Ψ` the linearised flow of attitude, momentum and costates from the start, a time `t_k` that is moved later by `δt` leaves the
//! torque before it on for so long: at `t_k` the momentum is disturbed by `β_k δt`, `β_k = τ(t_k−) − τ(t_k+)`, which is the disturbance
//! `ξ_k = Ψ(t_k)⁻¹ (0, β_k, 0, 0)` at the start. So
//!
//! ```text
//! ∂(end)/∂t_k = Ψ(T) ξ_k ,      ∂s_j/∂t_k = a_j · (e rows of Ψ(t_j)) ξ_k  for t_k < t_j ,      ∂s_j/∂t_j = a_j · e'(t_j)
//! ```
//!
//! Costates are linear in `ℓ = (M, e_0)` where the torque is held. The Lagrangian of the fuel and of the terminal conditions has
//! the derivative `∓2 s_j(t_j)` with respect to a time on or off. With respect to a duration that is sought it is the Hamiltonian at the end,
//! which differs from that before the first pulse by the steps it makes where inputs switch:
//!
//! ```text
//! ∂L/∂T = H(T) = H(0) − Σ_k ∂L/∂t_k ,      H(0) = p + M·Ω_0 + e_0·(Π_0×Ω_0 + τ_0)
//! ```
//!
//! as moving all of the times later is to wait at the start.

use super::super::arcs::{Arcs, Switch, over_arc};
use super::super::extremal::Extremal;
use super::super::flow::{Lanes, Node};
use super::super::tuning::COARSER;
use super::super::tuning::pulses::FINE;
use super::schedule::Schedule;
use crate::{Matrix3, Vector3, lie};
use nalgebra::{DMatrix, DVector, RowVector6, SMatrix, SVector, Vector6};

/// Lanes: `δM`, `δe` at the start, and `η`, `δΠ` there.
const LANES: usize = 12;

/// A pulse begins or ends.
#[derive(Clone, Copy, Debug)]
struct Event {
    /// Which of the times of the schedule.
    time: usize,
    at: f64,
    node: Node,
    flow: Lanes<LANES>,
}

/// The motion under pulses.
pub(crate) struct Motion<'a> {
    extremal: &'a Extremal,
    schedule: &'a Schedule,
    m: Vector3,
    first: Node,
    /// In the order of time.
    events: Vec<Event>,
    end: Node,
    end_flow: Lanes<LANES>,
    /// At the end.
    torque: Vector3,
}

/// The end of the motion against the terminal conditions.
#[derive(Clone, Debug)]
pub(crate) struct Miss {
    /// Attitude and momentum.
    pub residual: Vector6<f64>,
    /// With respect to the times, 6×n.
    pub jacobian: DMatrix<f64>,
}

/// How the switching functions answer.
#[derive(Clone, Debug)]
pub(crate) struct Curvature {
    /// Derivative of the terminal conditions, in the measure of `ℓ`: `∂L/∂t = g + S ℓ`, n×6.
    pub of_costates: DMatrix<f64>,
    /// Second derivative of the Lagrangian at given `ℓ`, n×n: symmetric where the end does not move.
    pub hessian: DMatrix<f64>,
}

impl<'a> Motion<'a> {
    /// From the start to the end, with the costates `ℓ`.
    pub fn of(extremal: &'a Extremal, schedule: &'a Schedule, costates: &[f64; 6]) -> Self {
        Self::in_steps(COARSER * FINE, extremal, schedule, costates)
    }

    /// The same in steps so short that their error is round-off.
    pub fn fine(extremal: &'a Extremal, schedule: &'a Schedule, costates: &[f64; 6]) -> Self {
        Self::in_steps(FINE, extremal, schedule, costates)
    }

    fn in_steps(longest: f64, extremal: &'a Extremal, schedule: &'a Schedule, costates: &[f64; 6]) -> Self {
        let [m0, m1, m2, e0, e1, e2] = *costates;
        let (m, e) = (Vector3::new(m0, m1, m2), Vector3::new(e0, e1, e2));
        let first = Node { r: Matrix3::identity(), pi: extremal.j * extremal.start_rate, e };
        let times = schedule.times();
        let mut order: Vec<usize> = (0..2 * schedule.pulses.len()).collect();
        order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
        let mut flow = Lanes::<LANES>::of_costate();
        for row in 0..6 {
            flow.0[row][6 + row] = 1.0;
        }
        // All levels off.
        let mut torque = idle(extremal);
        let (mut node, mut now) = (first, 0.0);
        let mut events = Vec::with_capacity(order.len());
        // Pulses that touch leave nothing between them.
        let over = |from: &Node, torque: &Vector3, length: f64, flow: &mut Lanes<LANES>| {
            if length <= 0.0 {
                return *from;
            }
            over_arc(
                extremal,
                &m,
                from,
                &Extremal::holding(torque),
                (length, schedule.duration),
                longest,
                flow,
            )
        };
        for time in order {
            let at = times[time];
            node = over(&node, &torque, at - now, &mut flow);
            now = at;
            events.push(Event { time, at, node, flow });
            torque += jump(extremal, schedule, time);
        }
        let end = over(&node, &torque, schedule.duration - now, &mut flow);
        Self { extremal, schedule, m, first, events, end, end_flow: flow, torque }
    }

    /// Disturbances of the state at the start that stand for times moved, one for each event; of the costate too, which are then
    /// as they were at the event.
    fn disturbances(&self) -> Option<Vec<SVector<f64, 6>>> {
        let of = |event: &Event| {
            let state = SMatrix::<f64, 6, 6>::from_fn(|row, lane| event.flow.0[row][6 + lane]);
            let jump = -jump(self.extremal, self.schedule, event.time);
            let pushed = Vector6::new(0.0, 0.0, 0.0, jump.x, jump.y, jump.z);
            state.lu().solve(&pushed)
        };
        self.events.iter().map(of).collect()
    }

    /// The end against the terminal conditions; `None` where a number is not finite.
    pub fn miss(&self) -> Option<Miss> {
        let (extremal, end, flow) = (self.extremal, &self.end, &self.end_flow);
        let residual = extremal.miss(end);
        let of_log = lie::left_jacobian_inverse(&residual.fixed_rows::<3>(0).into_owned());
        let mut to_end = SMatrix::<f64, 6, 6>::from_fn(|row, lane| flow.0[row][6 + lane]);
        let turned = of_log * to_end.fixed_rows::<3>(0);
        to_end.fixed_rows_mut::<3>(0).copy_from(&turned);
        let mut jacobian = DMatrix::zeros(6, self.count());
        for (event, disturbance) in self.events.iter().zip(self.disturbances()?) {
            jacobian.column_mut(event.time).copy_from(&(to_end * disturbance));
        }
        if let Some(last) = self.schedule.end() {
            let [turning, momentum, _] = extremal.rate(&self.m, end, &self.torque);
            jacobian.view_mut((0, last), (3, 1)).copy_from(&(of_log * turning));
            jacobian.view_mut((3, last), (3, 1)).copy_from(&momentum);
        }
        let finite = residual.iter().chain(jacobian.iter()).all(|value| value.is_finite());
        finite.then_some(Miss { residual, jacobian })
    }

    /// Derivatives of the Lagrangian; `None` where a number is not finite.
    pub fn curvature(&self) -> Option<Curvature> {
        let count = self.count();
        let mut of_costates = DMatrix::zeros(count, 6);
        let mut hessian = DMatrix::zeros(count, count);
        // The disturbance of the costate at the start that leaves it as it was at the event.
        let mut moved: Vec<(usize, f64, Vector6<f64>, Vector3)> = Vec::with_capacity(count);
        for (event, state) in self.events.iter().zip(self.disturbances()?) {
            let row = |row: usize, lane: usize| event.flow.0[6 + row][lane];
            let of_momentum = Matrix3::from_fn(|r, lane| row(r, 3 + lane));
            let of_state = SMatrix::<f64, 3, 6>::from_fn(|r, lane| row(r, 6 + lane));
            let costate = of_momentum.lu().solve(&(-(of_state * state)))?;
            let (axis, weight) = self.switch(event.time);
            for lane in 0..6 {
                let column = Vector3::from_fn(|r, _| row(r, lane));
                of_costates[(event.time, lane)] = weight * axis.dot(&column);
            }
            for (time, at, state, costate) in &moved {
                if *at < event.at {
                    let change = of_state * state + of_momentum * costate;
                    hessian[(event.time, *time)] = weight * axis.dot(&change);
                }
            }
            let rate = self.extremal.rate(&self.m, &event.node, &Vector3::zeros())[2];
            hessian[(event.time, event.time)] = weight * axis.dot(&rate);
            moved.push((event.time, event.at, state, costate));
        }
        if let Some(last) = self.schedule.end() {
            let (rate, momentum) = (self.extremal.start_rate, self.first.pi);
            let push = momentum.cross(&rate) + idle(self.extremal);
            let before = RowVector6::new(rate.x, rate.y, rate.z, push.x, push.y, push.z);
            let (costates, all) = (before - of_costates.row_sum(), -hessian.row_sum());
            of_costates.row_mut(last).copy_from(&costates);
            hessian.row_mut(last).copy_from(&all);
        }
        let finite = of_costates.iter().chain(hessian.iter()).all(|value| value.is_finite());
        finite.then_some(Curvature { of_costates, hessian })
    }

    /// Of the times.
    fn count(&self) -> usize {
        self.events.len() + usize::from(self.schedule.sought)
    }

    /// The arcs between the times.
    pub fn arcs(&self) -> Arcs {
        let schedule = self.schedule;
        let mut signs = vec![-1.0; self.extremal.switching_count()];
        let mut switches = Vec::new();
        for event in &self.events {
            let level = schedule.pulses[event.time / 2].level;
            if event.at > 0.0 && event.at < schedule.duration {
                switches.push(Switch { input: level, time: event.at, node: event.node });
            } else if event.at <= 0.0 {
                // What goes off there again is not on.
                signs[level] = if event.time.is_multiple_of(2) { 1.0 } else { -1.0 };
            }
        }
        Arcs { m: self.m, duration: schedule.duration, first: self.first, signs, switches }
    }

    /// The axis of the level that switches at a time, and how its switching function enters the Lagrangian.
    fn switch(&self, time: usize) -> (Vector3, f64) {
        let axis = self.extremal.axes()[self.schedule.pulses[time / 2].level];
        (axis, if time.is_multiple_of(2) { -2.0 } else { 2.0 })
    }
}

/// `g`: what the times cost, to first order.
pub(super) fn gradient(extremal: &Extremal, schedule: &Schedule) -> DVector<f64> {
    let of = |time: usize| {
        if schedule.end() == Some(time) {
            return extremal.price_of_time();
        }
        let cost = 2.0 * extremal.costs[schedule.pulses[time / 2].level];
        if time.is_multiple_of(2) { -cost } else { cost }
    };
    DVector::from_fn(schedule.times().len(), |time, _| of(time))
}

/// The torque while all levels are off.
fn idle(extremal: &Extremal) -> Vector3 {
    extremal.axes().iter().fold(extremal.middle, |sum, axis| sum - axis)
}

/// By how much the torque changes at a time.
fn jump(extremal: &Extremal, schedule: &Schedule, time: usize) -> Vector3 {
    let full = 2.0 * extremal.axes()[schedule.pulses[time / 2].level];
    if time.is_multiple_of(2) { full } else { -full }
}
