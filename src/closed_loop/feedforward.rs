//! The commands of a plan: its inputs unchanged, or corrected for a known actuator lag and delay.
//!
//! A corrected command is given one delay early. It is the mean of the plan's inputs over the time
//! for which it acts, and compensates the lag. Let `v` be the output of the actuators before the
//! step, and `m` the mean of `e^{−t/τ}` over the ticks. The mean output is `c + (v − c) m`, so the
//! command is `c = (u* − m v)/(1 − m)`.

use super::Plant;
use crate::optimize::discrete::linear_plan::LinearPlan;

/// Fraction of a tick within which two times count as equal.
pub(super) const SAME_TIME: f64 = 1e-6;

/// The commands of a plan for a plant.
pub(super) struct Feedforward<'a> {
    pub plan: &'a LinearPlan,
    pub plant: &'a Plant,
}

impl Feedforward<'_> {
    /// Returns the commands, each with the time \[s\] from which it acts: first the commands that
    /// are given before the start, then one command per step.
    pub fn commands(&self) -> Vec<(f64, Vec<f64>)> {
        let times = self.plan.times();
        let count = self.plan.count();
        let m = self.plan.axes().ncols();
        if !self.plant.leads {
            return (0..count).map(|k| (times[k] + self.plant.delay, self.plan.inputs(k).to_vec())).collect();
        }
        let delay = self.plant.delay;
        let step = times[1] - times[0];
        // There are at most as many early commands as steps, however long the delay.
        let early = ((delay / step - SAME_TIME).ceil().max(0.0) as usize).min(count);
        let before = (1..=early).rev().map(|j| (delay - j as f64 * step).max(0.0));
        let starts: Vec<f64> = before.chain(times.iter().map(|time| time + delay)).collect();
        let (mut reached, mut commands) = (vec![0.0; m], Vec::with_capacity(starts.len()));
        for ends in starts.windows(2) {
            let mut command = self.planned(ends[0], ends[1]);
            if self.plant.lag > 0.0 {
                let ticks = self.plant.ticks(ends[1] - ends[0]);
                let kept = ((ends[0] - ends[1]) / (ticks as f64 * self.plant.lag)).exp();
                let (mean, whole) = (mean_kept(kept, ticks), kept.powf(ticks as f64));
                for (command, reached) in command.iter_mut().zip(&mut reached) {
                    *command = (*command - mean * *reached) / (1.0 - mean);
                    *reached = *command + whole * (*reached - *command);
                }
            }
            commands.push((ends[0], command));
        }
        commands
    }

    /// Returns the mean of the plan's inputs between two times \[s\]. After the end of the plan the
    /// inputs of its last step apply.
    fn planned(&self, from: f64, to: f64) -> Vec<f64> {
        let times = self.plan.times();
        let last = self.plan.count() - 1;
        let mut mean = vec![0.0; self.plan.axes().ncols()];
        let first = times.partition_point(|time| *time <= from).saturating_sub(1).min(last);
        for k in first..=last {
            let end = if k == last { f64::INFINITY } else { times[k + 1] };
            let part = (to.min(end) - from.max(times[k])) / (to - from);
            if part <= 0.0 && k > first {
                break;
            }
            mean.iter_mut().zip(self.plan.inputs(k)).for_each(|(mean, input)| *mean += part.max(0.0) * input);
        }
        mean
    }
}

/// Returns the mean of `q, q², … qⁿ` over the n ticks of a step. `q = kept` is the factor by which
/// the actuator lag reduces the difference between output and command in one tick.
fn mean_kept(kept: f64, ticks: usize) -> f64 {
    (1..=ticks).map(|tick| kept.powf(tick as f64)).sum::<f64>() / ticks as f64
}
