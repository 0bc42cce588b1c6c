//! The motion under pulses, and how its end and its Hamiltonians answer to their times.
//!
//! Between the times are arcs under held torques, from the start on one after the other
//! (`sequence`): with the lengths `d = D t` the conditions of least fuel in the times are those in
//! the lengths, tied by `D`. The Lagrangian of the fuel and of the terminal conditions has the
//! derivative `∓2 s_j(t_j)` with respect to a time on or off, the step that the Hamiltonian makes
//! there, and with respect to a duration that is sought the Hamiltonian at the end.

use super::super::arcs::{Arcs, Switch};
use super::super::extremal::Extremal;
use super::super::flow::Node;
use super::super::grid_step::Torque;
use super::super::sequence::{Sequence, Step};
use super::schedule::Schedule;
use crate::optimize::nlp::kkt::KktSystem;
use nalgebra::{DMatrix, Vector6};

/// The motion under pulses.
pub(crate) struct Motion {
    /// Between the times.
    pub arcs: Arcs,
    /// In costates and times: symmetric second derivatives where the end does not move.
    pub kkt: KktSystem,
}

impl Motion {
    /// From the start to the end, with the costates `(M, e_0)`, in steps of at most this part of
    /// the duration; `None` where a number is not finite.
    pub fn of(
        extremal: &Extremal,
        schedule: &Schedule,
        costates: &Vector6<f64>,
        longest: f64,
    ) -> Option<Self> {
        let [m, e] = [0, 3].map(|row| costates.fixed_rows::<3>(row).into_owned());
        let first = Node::at_start(extremal, e);
        let times = schedule.times();
        let mut order: Vec<usize> = (0..2 * schedule.pulses.len()).collect();
        order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
        // All levels off.
        let mut levels = vec![-1.0; extremal.switching_count()];
        let (mut lengths, mut steps, mut now) = (Vec::new(), Vec::new(), 0.0);
        let mut of_times = DMatrix::zeros(order.len() + 1, times.len());
        for arc in 0..=order.len() {
            let time = order.get(arc).copied();
            let end = time.map_or(schedule.duration, |time| times[time]);
            // Pulses that touch leave nothing between them.
            lengths.push((end - now).max(0.0));
            steps.push(Step { arc, part: 1.0, torque: Torque::Arc(extremal.on_arc(&levels)) });
            now = end;
            if let Some(time) = time.or(schedule.end()) {
                of_times[(arc, time)] = 1.0;
            }
            if let Some(time) = time {
                of_times[(arc + 1, time)] = -1.0;
                levels[schedule.pulses[time / 2].level] += if turns_on(time) { 2.0 } else { -2.0 };
            }
        }
        let (beside, longest) = (Sequence::AT_THE_NODE, Some(longest));
        let sequence = Sequence { m: &m, lengths: &lengths, steps: &steps, nodes: &[first], beside, longest };
        let swept = sequence.swept(extremal)?;
        let mut signs = vec![-1.0; levels.len()];
        let mut switches = Vec::new();
        for (time, node) in order.into_iter().zip(&swept.nodes[1..]) {
            let (input, at) = (schedule.pulses[time / 2].level, times[time]);
            if at > 0.0 && at < schedule.duration {
                switches.push(Switch { input, time: at, node: *node });
            } else if at <= 0.0 {
                // What goes off there again is not on.
                signs[input] = if turns_on(time) { 1.0 } else { -1.0 };
            }
        }
        let arcs = Arcs { m, duration: schedule.duration, first, signs, switches };
        Some(Self { arcs, kkt: swept.kkt.tied(&of_times) })
    }
}

/// Whether a pulse begins at a time, and does not end.
fn turns_on(time: usize) -> bool {
    time.is_multiple_of(2)
}
