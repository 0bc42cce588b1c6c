//! The motion under pulses, and the derivatives of its end and its Hamiltonians with respect to the
//! pulse times.
//!
//! The arcs between the times are integrated under held torques, one after the other from the start
//! (`sequence`). With the arc lengths `d = D t`, the minimum-fuel conditions in the times `t` are
//! those in the lengths, projected by `D`. The Lagrangian of the fuel and the terminal conditions
//! has the derivative `∓2 s_j(t_j)` with respect to an on or off time: the jump of the Hamiltonian
//! at this time. Its derivative with respect to a free duration is the Hamiltonian at the end.

use super::super::arcs::{Arcs, Switch};
use super::super::extremal::Extremal;
use super::super::flow::Node;
use super::super::grid_step::Torque;
use super::super::sequence::{Sequence, Step};
use super::schedule::Schedule;
use crate::optimize::nlp::kkt::KktSystem;
use nalgebra::{DMatrix, Vector6};

/// Motion under pulses: its arcs and its KKT system.
pub(crate) struct Motion {
    /// Arcs between successive switching times.
    pub arcs: Arcs,
    /// KKT system in costates and times. Its second derivatives are symmetric along changes that
    /// keep the end.
    pub kkt: KktSystem,
}

impl Motion {
    /// Integrates from the start to the end with the costates `(M, e_0)`. `longest` is the longest
    /// integration step, as a fraction of the duration. Returns `None` if a number is not finite.
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
        // All levels are off at first.
        let mut levels = vec![-1.0; extremal.switching_count()];
        let (mut lengths, mut steps, mut now) = (Vec::new(), Vec::new(), 0.0);
        let mut of_times = DMatrix::zeros(order.len() + 1, times.len());
        for arc in 0..=order.len() {
            let time = order.get(arc).copied();
            let end = time.map_or(schedule.duration, |time| times[time]);
            // Pulses that touch have a pause of zero length.
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
                // A pulse that ends at the start of the maneuver is never on.
                signs[input] = if turns_on(time) { 1.0 } else { -1.0 };
            }
        }
        let arcs = Arcs { m, duration: schedule.duration, first, signs, switches };
        Some(Self { arcs, kkt: swept.kkt.tied(&of_times) })
    }
}

/// Returns whether the time with this index is the start of a pulse (true) or the end of one
/// (false).
fn turns_on(time: usize) -> bool {
    time.is_multiple_of(2)
}
