//! Inputs that are optimal for given costates within their own limits: of their size, and of how fast they change.
//!
//! With the costates held each input is alone with its limits, a convex problem along the stages:
//!
//! ```text
//! minimise  Σ f_k(u_k) ,  f_k(u) = κ_k (½ w u² + g_k u) ,      |u_k| ≤ U ,   |u_{k+1} − u_k| ≤ r_k
//! ```
//!
//! The least cost of the stages up to `k` is a function of `u_k`, `V_k(u) = f_k(u) + min V_{k−1}(v)` over `|v − u| ≤ r_{k−1}`.
//! Its slope is piecewise linear and grows. The minimum over `v` moves what lies below the zero `m` of the slope by `r` to the
//! left, and what lies above by `r` to the right; so its corners are kept in two lists that are moved as a whole.
//! Backwards the inputs are `u_k = m_k`, held within `u_{k+1} ± r_k`.
//!
//! # How does a plan with limits of how fast torques change come to a fine grid?
//!
//! By what its costates ask for. With them held, each input within its size and its rate is a small convex problem of its
//! own, whose exact solution takes one way forth and one back (`scp/within`): it gives the inputs, the rows that act and
//! their multipliers without contradiction, from costates of a coarser grid that are wrong by `O(h²)`. Multipliers carried
//! from row to row do not: between ramps and limits of the size a row too many fixes an input twice, and Newton's next step
//! goes anywhere; on 40,000 steps nothing came of that, nor of a cone program of such a size. Two things are left to Newton.
//! A ramp that ends at a limit of the size is fixed there by a force of no more than one node, and a maneuver of ramps alone
//! then has no input left to steer by: so where Newton does not settle one step is taken with the ends of such ramps free,
//! and the inputs are asked for anew from its costates. And a round that repeats itself leaves the way to the grids between.
//! `slew plan problems/limited_torque_rate.toml --set maneuver.steps=40000` needs one cone program, of 24 steps.

use super::curvature::Multipliers;
use super::iterate::Iterate;
use super::model::Model;
use super::rows::{LimitRow, LimitRows, What};
use crate::optimize::methods::method::Watch;
use crate::optimize::methods::scp::tuning::ROUND_OFF;
use nalgebra::DMatrix;
use std::collections::VecDeque;

/// An iterate with the inputs that are optimal for its costates within these limits, and their multipliers; `None` where inputs
/// of a stage are tied together, by the weight or by a limit of their norm, where the duration is sought, and where fuel or a change counts.
pub(super) fn optimal_inputs(
    model: &Model,
    rows: &LimitRows,
    start: &Iterate,
    multipliers: &Multipliers,
    watch: &Watch,
) -> Option<(Iterate, Multipliers)> {
    let diagonal = DMatrix::from_diagonal(&model.weight.diagonal()) == model.weight;
    let together = |row: &LimitRow| matches!(row.what, What::InputNorm { .. });
    if !diagonal
        || model.about.is_some()
        || model.duration.is_some()
        || !rows.kinks.is_empty()
        || rows.rows.iter().any(together)
    {
        return None;
    }
    let (mut start, mut multipliers) = (start.clone(), multipliers.clone());
    let evaluated = start.evaluate(model, rows, *watch).ok()?;
    let (first, stages) = (model.first_input(), model.first_input()..=model.steps);
    let mut courses: Vec<Input> = (0..model.m)
        .map(|input| Input {
            weight: stages
                .clone()
                .map(|stage| model.kick_weight(stage) * model.weight[(input, input)])
                .collect(),
            slope: Vec::with_capacity(model.steps + 1),
            size: f64::INFINITY,
            changes: vec![f64::INFINITY; model.steps - first],
        })
        .collect();
    for stage in stages {
        let pull = evaluated.input_slope(stage).tr_mul(&multipliers.costates[stage]);
        courses.iter_mut().zip(pull.iter()).for_each(|(course, pull)| course.slope.push(*pull));
    }
    if courses.iter().flat_map(|course| &course.slope).any(|slope| !slope.is_finite()) {
        return None;
    }
    for row in &rows.rows {
        match row.what {
            What::InputSize { input, limit, .. } => courses[input].size = limit,
            What::InputRate { input, limit, .. } => courses[input].changes[row.stage - first] = limit,
            _ => {}
        }
    }
    let optima: Vec<Optimum> = courses.iter().map(Input::optimum).collect();
    for (input, optimum) in optima.iter().enumerate() {
        let inputs = start.inputs[first..].iter_mut();
        inputs.zip(&optimum.inputs).for_each(|(inputs, u)| inputs[input] = *u);
    }
    for (row, multiplier) in rows.rows.iter().zip(&mut multipliers.rows) {
        let (force, sign, limit) = match row.what {
            What::InputSize { input, sign, limit } => (optima[input].size[row.stage - first], sign, limit),
            What::InputRate { input, sign, limit } => (optima[input].change[row.stage - first], sign, limit),
            _ => continue,
        };
        *multiplier = (sign * force).max(0.0) * limit;
    }
    Some((start, multipliers))
}

/// One input along the stages.
struct Input {
    /// `κ_k w`.
    weight: Vec<f64>,
    /// `κ_k g_k`.
    slope: Vec<f64>,
    /// `U`, infinite where the size is free.
    size: f64,
    /// `r_k`, one fewer than there are stages.
    changes: Vec<f64>,
}

/// The optimum, with the multipliers of the limits as forces on the inputs: stationarity reads
/// `κ_k (w u_k + g_k) + size_k + change_{k−1} − change_k = 0`.
struct Optimum {
    inputs: Vec<f64>,
    /// Positive where the input is held from above.
    size: Vec<f64>,
    /// Positive where the input grows as fast as it may.
    change: Vec<f64>,
}

/// Corners of the slope on one side of its zero, the nearest last: `x = stored x + shift`, `y = stored y + tilt·(stored x) + lift`.
#[derive(Default)]
struct Corners {
    stored: VecDeque<(f64, f64)>,
    shift: f64,
    tilt: f64,
    lift: f64,
}

impl Corners {
    fn shown(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (x + self.shift, y + self.tilt * x + self.lift)
    }

    /// The corner nearest to the zero.
    fn nearest(&self) -> Option<(f64, f64)> {
        self.stored.back().map(|corner| self.shown(*corner))
    }

    fn push(&mut self, (x, y): (f64, f64)) {
        self.stored.push_back(self.hidden((x, y)));
    }

    fn hidden(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let x = x - self.shift;
        (x, y - self.tilt * x - self.lift)
    }

    /// Adds `weight·x + slope` to all values.
    fn add(&mut self, weight: f64, slope: f64) {
        self.tilt += weight;
        self.lift += weight * self.shift + slope;
    }

    /// Ends the list at the bound `end`, towards which `side` points.
    fn cut(&mut self, end: f64, side: f64) {
        let mut last = None;
        while let Some(corner) = self.stored.front().map(|corner| self.shown(*corner))
            && side * (corner.0 - end) > 0.0
        {
            last = self.stored.pop_front().map(|_| corner);
        }
        let Some((x, y)) = last else { return };
        // Within the last piece the value is linear; without one the slope is flat up to the bound.
        let (inner, value) = self.stored.front().map_or((end, y), |corner| self.shown(*corner));
        let share = if (x - inner).abs() > 0.0 { (end - inner) / (x - inner) } else { 0.0 };
        let corner = self.hidden((end, value + share * (y - value)));
        self.stored.push_front(corner);
    }
}

impl Input {
    /// The optimal course of the input.
    fn optimum(&self) -> Optimum {
        let inputs = self.course();
        let (size, change) = self.forces(&inputs);
        Optimum { inputs, size, change }
    }

    fn course(&self) -> Vec<f64> {
        // No stage asks for more, and none gives more because of its neighbours.
        let asked = self.slope.iter().zip(&self.weight).map(|(slope, weight)| (slope / weight).abs());
        let bound = self.size.min(asked.fold(0.0, f64::max));
        let ends =
            || [-bound, bound].map(|end| Corners { stored: [(end, 0.0)].into(), ..Corners::default() });
        let [mut below, mut above] = ends();
        let mut zeros: Vec<f64> = Vec::with_capacity(self.weight.len());
        for (stage, (weight, slope)) in self.weight.iter().zip(&self.slope).enumerate() {
            if let (Some(zero), Some(change)) = (zeros.last(), self.changes.get(stage.wrapping_sub(1))) {
                if *change < 2.0 * bound {
                    for (corners, side) in [(&mut below, -1.0), (&mut above, 1.0)] {
                        corners.push((*zero, 0.0));
                        corners.shift += side * change;
                        corners.cut(side * bound, side);
                    }
                } else {
                    // What was before does not matter.
                    [below, above] = ends();
                }
            }
            below.add(*weight, *slope);
            above.add(*weight, *slope);
            while let Some(corner) = below.nearest().filter(|(_, y)| *y > 0.0) {
                below.stored.pop_back();
                above.push(corner);
            }
            while let Some(corner) = above.nearest().filter(|(_, y)| *y < 0.0) {
                above.stored.pop_back();
                below.push(corner);
            }
            zeros.push(match (below.nearest(), above.nearest()) {
                (Some((left, low)), Some((right, high))) if high > low => {
                    left + (right - left) * (-low / (high - low))
                }
                (Some((x, _)), _) | (None, Some((x, _))) => x,
                (None, None) => 0.0,
            });
        }
        let mut inputs = zeros;
        for stage in (0..self.changes.len()).rev() {
            let (next, change) = (inputs[stage + 1], self.changes[stage]);
            inputs[stage] = inputs[stage].clamp(next - change, next + change);
        }
        inputs
    }
}

impl Input {
    /// What holds a course within its limits. Forwards each force of a change is as free as the stages before it leave it: what holds
    /// a size may be any that pushes inwards. Backwards it is the one that leaves least to hold the size with.
    fn forces(&self, inputs: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let last = self.changes.len();
        let (mut size, mut change) = (vec![0.0; last + 1], vec![0.0; last]);
        let pull = |stage: usize| self.weight[stage] * inputs[stage] + self.slope[stage];
        let held = |stage: usize| inputs[stage].abs() >= self.size * (1.0 - ROUND_OFF);
        let mut free = Vec::with_capacity(last);
        let (mut low, mut high) = (0.0, 0.0);
        for stage in 0..last {
            (low, high) = (low + pull(stage), high + pull(stage));
            match held(stage) {
                true if inputs[stage] > 0.0 => high = f64::INFINITY,
                true => low = f64::NEG_INFINITY,
                false => {}
            }
            let step = inputs[stage + 1] - inputs[stage];
            let (least, most) = match step.abs() >= self.changes[stage] * (1.0 - ROUND_OFF) {
                true if step > 0.0 => (0.0, f64::INFINITY),
                true => (f64::NEG_INFINITY, 0.0),
                false => (0.0, 0.0),
            };
            (low, high) = (low.max(least).min(most), high.max(least).min(most));
            free.push((low, high));
        }
        let mut after = 0.0;
        for stage in (0..=last).rev() {
            let mut before = 0.0;
            if stage > 0 {
                let (low, high) = free[stage - 1];
                before = (after - pull(stage)).max(low).min(high);
                change[stage - 1] = before;
            }
            if held(stage) {
                size[stage] = after - before - pull(stage);
            }
            after = before;
        }
        (size, change)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// Every condition of the optimum of a convex problem: that is what makes it the optimum.
    fn check(input: &Input, what: &str) {
        let Optimum { inputs, size, change } = input.optimum();
        let scale = input.slope.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
        let near = 1e-10 * scale * inputs.len() as f64;
        for (stage, u) in inputs.iter().enumerate() {
            let before = if stage > 0 { change[stage - 1] } else { 0.0 };
            let after = change.get(stage).copied().unwrap_or(0.0);
            let lacking = input.weight[stage] * u + input.slope[stage] + size[stage] + before - after;
            assert!(lacking.abs() <= near, "{what}, stage {stage}: {lacking:e}");
            assert!(u.abs() <= input.size * (1.0 + 1e-12), "{what}, stage {stage}: {u}");
            // A force pushes inwards, and only where a limit acts.
            assert!(size[stage] * u.signum() >= -near, "{what}, stage {stage}");
            assert!(size[stage] == 0.0 || u.abs() >= input.size * (1.0 - 1e-8), "{what}, stage {stage}");
        }
        for (stage, most) in input.changes.iter().enumerate() {
            let step = inputs[stage + 1] - inputs[stage];
            assert!(step.abs() <= most * (1.0 + 1e-8), "{what}, stage {stage}: {step}, at most {most}");
            assert!(change[stage] * step.signum() >= -near, "{what}, stage {stage}");
            assert!(change[stage] == 0.0 || step.abs() >= most * (1.0 - 1e-8), "{what}, stage {stage}");
        }
    }

    #[test]
    fn a_course_meets_all_conditions_of_its_optimum() {
        let mut random = Random(5);
        for case in 0..200 {
            let count = 2 + case;
            let waves: Vec<f64> = (0..5).map(|_| random.uniform()).collect();
            let weight: Vec<f64> = (0..count).map(|_| (1.5 + random.uniform()) / count as f64).collect();
            let rough = if case % 2 == 0 { 0.0 } else { 1.0 };
            let asked: Vec<f64> = (0..count)
                .map(|stage| {
                    let angle = 6.0 * stage as f64 / count as f64;
                    let smooth: f64 =
                        waves.iter().zip(1..).map(|(w, m)| w * (angle * f64::from(m)).sin()).sum();
                    3.0 * smooth + rough * random.uniform()
                })
                .collect();
            let slope = weight.iter().zip(&asked).map(|(weight, asked)| weight * asked).collect();
            let size = if case % 3 == 0 { f64::INFINITY } else { 0.7 };
            // From one limit of the size to the other in a whole number of stages, or in none.
            let whole = 2.0 * size / (1 + case % 8) as f64;
            let changes = (1..count).map(|_| match case % 3 {
                1 => whole,
                _ => (1.0 + 0.3 * random.uniform()) * 8.0 / count as f64,
            });
            let changes = changes.collect();
            check(&Input { weight, slope, size, changes }, &format!("case {case}"));
        }
    }

    #[test]
    fn limits_that_do_not_act_leave_what_the_costates_ask_for() {
        let slope = vec![0.1, -0.4, 0.2, 0.6];
        let free =
            Input { weight: vec![0.5, 1.0, 1.0, 0.5], slope, size: f64::INFINITY, changes: vec![5.0; 3] };
        let Optimum { inputs, size, change } = free.optimum();
        let asked = [-0.2, 0.4, -0.2, -1.2];
        assert!(
            inputs.iter().zip(asked).all(|(u, asked): (&f64, f64)| (u - asked).abs() < 1e-15),
            "{inputs:?}"
        );
        assert!(size.iter().chain(&change).all(|force| *force == 0.0));
    }
}
