//! First-order gap in continuous time of a minimum-time or minimum-fuel plan on a uniform grid.
//!
//! A discrete optimum is the best of all inputs with one value at each node, but inputs may switch
//! between the nodes. Let λ solve the adjoint equations along the motion, and let `dμ ≥ 0` be the
//! multipliers of the limits `g ≤ 0` of the state. A neighbouring plan u' then costs, to first
//! order,
//!
//! ```text
//! J(u') − J(u) ≥ ∫ (H(u') − H(u)) dt − ∫ |g| dμ ≥ −∫ (H(u) − min_v H(v)) dt − ∫ |g| dμ
//! H(v) = Σ_j c_j |v_j| + s_j v_j
//! ```
//!
//! with the prices c of fuel (zero for time) and the switching functions s. The right side is the
//! negative gap: the gap of Frank and Wolfe, *An algorithm for quadratic programming*, 1956, for
//! the maneuver linearised about the plan. The minimum is over inputs within their limits. If the
//! rate of an input is limited, the rate is the control, and the costate of the input is its
//! switching function.
//!
//! # How do limits of the state enter?
//!
//! Their multipliers are a measure: a density along an arc on which a limit is active, an atom
//! where a limit is touched. A neighbouring plan satisfies the limit, so that the measure enters by
//! λ and by the slack `|g|` of the plan. The discrete costates contain the multipliers of the rows.
//! The multiplier of a row on an arc has a density over its step. The multiplier of a row at a node
//! has a density over both adjacent steps, half on each. With these densities the switching
//! functions are linear on a step. The true motion has slack in rate limits and wheel momenta where
//! an arc along the limit begins or ends. The slack of the rows themselves is due to the barrier
//! parameter, which has a gap of its own (`InteriorWork::gap`).
//!
//! # How do inputs and costates vary between the nodes?
//!
//! Inputs are held over a step at the mean of both ends, as in flight (`flight`). Inputs with rate
//! limits are linear, and the first-order cost of holding them is added. Switching functions, rates
//! and wheel momenta are linear between nodes, to `O(h²)`, the accuracy of the discrete costates.
//! The integrals over a step are exact. An input that switches within a step has a gap of `O(h²)`,
//! so that the gap of a plan of arcs decreases with the square of the step. The gap of a held plan
//! about one axis is between one and two times its excess over the continuous optimum.
//!
//! # When is an optimum not unique?
//!
//! Count the inputs that are within their limits, at all nodes, and the duration if it is sought.
//! If the optimum of the linearised maneuver is unique, this number is at most the number of
//! equations at the end and of active rows of the state. A larger number means that a family of
//! inputs has the same cost to first order. Its members differ in the inputs within their limits
//! that can change while the active rows at their node keep their values. Terms of second order may
//! still prefer one member.

#[cfg(test)]
mod tests;

use crate::Vector3;
use crate::maneuver::problem::{Problem, Scheme};
use crate::maneuver::settings::Method as Road;
use crate::maneuver::solution::{ContinuousGap, Landing, Undetermined};
use crate::mechanics::actuators::ActuatorSet;
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::model::step;
use crate::optimize::chain::rows::{LimitRow, What};
use crate::optimize::chain::{Chain, Multipliers, iterate, multipliers};
use crate::optimize::methods::interior_point::chain::conditions::Conditions;
use crate::optimize::methods::method::{Attempt, Watch};
use crate::optimize::search::ladder::Search;
use nalgebra::{DVector, Matrix3xX};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Smallest number of consecutive nodes at which an input counts as undetermined. A switch has only
/// one or two nodes between the limits.
const STRETCH: usize = 3;

/// Relative size below which the derivative of a row counts as round-off.
const NOTHING: f64 = 1e-8;

/// Returns the first-order gap of a minimum-time or minimum-fuel plan of the interior-point method,
/// before landing. `landing` describes the landing corrections, if there were any.
pub fn gap<const N: usize>(
    search: &Search<N>,
    plan: &Attempt,
    landing: Option<&Landing>,
) -> Option<ContinuousGap> {
    let goal = search.ask.goal.as_ref().filter(|goal| goal.objective.switches())?;
    let of_interior_point = plan.candidate.provenance.method == Road::InteriorPoint;
    // The terminal conditions of a family of terminal states are not among those of the chain.
    if !of_interior_point || !plan.converged() || search.ask.family.is_some() {
        return None;
    }
    let chain = Chain::with_goal(search.problem, plan.candidate.steps(), goal);
    let barrier = plan.barrier.map_or(0.0, |[barrier, ..]| barrier);
    let (iterate, multipliers) = (iterate(&plan.candidate), multipliers(&plan.candidate));
    search.context.within(|budget| {
        let at = Optimum { chain: &chain, problem: search.problem, iterate, multipliers, barrier };
        let drawn_in = landing.map_or(0.0, |landing| at.drawn_in(landing));
        Some(ContinuousGap { drawn_in, ..at.gap(&budget.watch)? })
    })
}

/// A discrete optimum with its multipliers.
struct Optimum<'a> {
    chain: &'a Chain,
    problem: &'a Problem,
    iterate: Iterate,
    multipliers: Multipliers,
    /// Last barrier parameter of the interior-point method.
    barrier: f64,
}

impl Optimum<'_> {
    fn gap(&self, watch: &Watch) -> Option<ContinuousGap> {
        let model = &self.chain.model;
        let conditions = Conditions::of(self.chain, &self.iterate, &self.multipliers, watch)?;
        let first = model.first_input();
        let mut slopes: Vec<Vec<f64>> = (first..=model.steps)
            .map(|node| {
                let weight = model.kick_weight(node);
                conditions.by_inputs(node).iter().map(|slope| slope / weight).collect()
            })
            .collect();
        if first > 0 {
            slopes.insert(0, slopes[0].clone());
        }
        let mut gap = 0.0;
        let sets =
            [(true, self.problem.actuation.force.as_ref()), (false, Some(&self.problem.actuation.torque))];
        for (forces, set) in sets {
            let inputs = self.inputs(forces);
            let Some(limits) = set.map(ActuatorSet::limits).filter(|_| !inputs.is_empty()) else { continue };
            gap += match (&limits.rate, limits.norm, &limits.size) {
                (Some(_), None, _) => inputs.map(|input| self.of_rate(&slopes, input)).sum(),
                // The minimum over the intersection of a ball and a box has no closed form.
                (Some(_), Some(_), _) | (None, Some(_), Some(_)) => return None,
                (None, Some(norm), None) => self.of_norm(&slopes, forces, norm),
                (None, None, _) => self.of_inputs(&slopes, inputs, limits.one_sided),
            };
        }
        let gap = (gap + self.slack()) / model.cost_scale;
        let undetermined = || self.undetermined();
        gap.is_finite().then(|| ContinuousGap { gap, drawn_in: 0.0, undetermined: undetermined() })
    }

    /// Returns the first-order cost of the constraints that landing tightens.
    fn drawn_in(&self, landing: &Landing) -> f64 {
        let (Chain { model, rows }, s) = (self.chain, self.iterate.stretch());
        let of = |(row, multiplier): (&LimitRow, &f64)| {
            let name = &rows.groups[row.group].name;
            let by: f64 = landing.drawn_in.iter().filter(|(own, _)| own == name).map(|(_, by)| by).sum();
            let grown = if row.what.is_ball() { 1.0 } else { s.powi(row.what.growth()) };
            by * grown * multiplier
        };
        rows.rows.iter().zip(&self.multipliers.rows).map(of).fold(0.0, |sum, of| sum + of) / model.cost_scale
    }

    /// Returns the index and the length of each step.
    fn steps(&self) -> impl Iterator<Item = (usize, f64)> {
        (0..self.chain.model.steps).map(|step| (step, self.chain.model.dynamics.grid.step(step)))
    }

    /// Returns the value of an input that is held over a step: for Lie–Verlet the mean of its values
    /// at both nodes, for Lie–Euler its value at the second node.
    fn held(&self, step: usize, input: usize) -> f64 {
        let [before, after] = [step, step + 1].map(|node| self.iterate.inputs[node][input]);
        match self.problem.scheme {
            Scheme::LieVerlet => 0.5 * (before + after),
            Scheme::LieEuler => after,
        }
    }

    /// Returns the fuel price of an input per unit of the input and of time.
    fn price(&self, input: usize) -> f64 {
        let price = self.chain.model.fuel.as_ref().map_or(0.0, |fuel| fuel.inputs[input]);
        price / self.iterate.stretch()
    }

    /// Returns the limits of the inputs, in the units of the duration found.
    fn bounds(&self) -> Vec<f64> {
        let grown = self.iterate.stretch().powi(2);
        self.chain.model.input_bounds(self.problem).iter().map(|bound| bound * grown).collect()
    }

    /// Returns the gap due to inputs that have their own limits.
    fn of_inputs(&self, slopes: &[Vec<f64>], inputs: Range<usize>, one_sided: bool) -> f64 {
        let bounds = self.bounds();
        let mut gap = 0.0;
        for input in inputs {
            let (bound, price) = (bounds[input], self.price(input));
            for (step, h) in self.steps() {
                let [a, b] = [step, step + 1].map(|node| slopes[node][input]);
                let held = self.held(step, input);
                gap += h * (price * held.abs() + 0.5 * (a + b) * held);
                gap += times(bound, above_zero([-a - price, -b - price], h));
                if !one_sided {
                    gap += times(bound, above_zero([a - price, b - price], h));
                }
            }
        }
        gap
    }

    /// Returns an upper bound on the gap due to the forces or torques under a norm limit. The norm
    /// of the switching functions is convex, and is replaced by linear functions on both sides of
    /// its minimum.
    fn of_norm(&self, slopes: &[Vec<f64>], forces: bool, norm: f64) -> f64 {
        let (model, inputs) = (&self.chain.model, self.inputs(forces));
        let (axes, _) = model.channel(forces);
        let axes = Matrix3xX::from_columns(axes);
        let Ok(inverse) = axes.transpose().pseudo_inverse(f64::EPSILON.sqrt()) else { return f64::NAN };
        let limit = norm / model.input_unit[inputs.start] * self.iterate.stretch().powi(2);
        let of_norm = model.fuel.as_ref().is_some_and(|fuel| fuel.is_of_norm(forces));
        let price = if of_norm { self.price(inputs.start) } else { 0.0 };
        let slope = |node: usize| -> Vector3 {
            let own = DVector::from_column_slice(&slopes[node][inputs.clone()]);
            let q = &inverse * own;
            Vector3::new(q[0], q[1], q[2])
        };
        let mut gap = 0.0;
        for (step, h) in self.steps() {
            let [a, b] = [slope(step), slope(step + 1)];
            let held =
                DVector::from_iterator(inputs.len(), inputs.clone().map(|input| self.held(step, input)));
            let held = &axes * held;
            gap += h * (price * held.norm() + (a + b).dot(&held) * 0.5);
            let by = b - a;
            let lowest = (-a.dot(&by) / by.norm_squared()).clamp(0.0, 1.0);
            let lowest = if lowest.is_nan() { 0.5 } else { lowest };
            let norms = [a.norm(), (a + by * lowest).norm(), b.norm()].map(|norm| norm - price);
            gap += times(limit, above_zero([norms[0], norms[1]], h * lowest));
            gap += times(limit, above_zero([norms[1], norms[2]], h * (1.0 - lowest)));
        }
        gap
    }

    /// Returns the gap due to an input with a rate limit. The costate of the input in the middle of
    /// a step is the multiplier of the rate limit there. The gap includes the slack in the input's
    /// own limit, and the first-order cost of holding the input over steps.
    fn of_rate(&self, slopes: &[Vec<f64>], input: usize) -> f64 {
        let (model, rows) = (&self.chain.model, &self.chain.rows);
        let (s, grown) = (self.iterate.stretch(), self.iterate.stretch().powi(3));
        let value = |node: usize| self.iterate.inputs[node][input];
        let (mut middles, mut costates, mut rates) = (Vec::new(), Vec::new(), Vec::new());
        let mut begins = 0.0;
        for (step, h) in self.steps() {
            let (mut costate, mut most) = (0.0, f64::INFINITY);
            for row in rows.range(step) {
                let What::InputRate { input: own, sign, limit } = rows.rows[row].what else { continue };
                if own == input {
                    costate -= sign * self.multipliers.rows[row] * grown;
                    most = limit * grown;
                }
            }
            middles.push(begins + 0.5 * h);
            begins += h;
            costates.push(costate / h);
            let change = value(step + 1) - value(step);
            rates.push(if step < model.first_input() { 0.0 } else { change / most });
        }
        let at = |time: f64| {
            let after = middles.partition_point(|middle| *middle <= time).clamp(1, middles.len() - 1);
            let [a, b] = [after - 1, after];
            costates[a] + (costates[b] - costates[a]) * (time - middles[a]) / (middles[b] - middles[a])
        };
        let mut gap = 0.0;
        for (step, h) in self.steps().skip(model.first_input()) {
            for half in [[-0.5, 0.0], [0.0, 0.5]] {
                let [from, to] = half.map(|part| middles[step] + part * h);
                let [a, b] = [at(from), at(to)];
                gap += 0.25 * h * (a + b) * rates[step];
                gap += above_zero([a, b], 0.5 * h) + above_zero([-a, -b], 0.5 * h);
            }
            let by = slopes[step + 1][input] - slopes[step][input];
            gap -= by * (value(step + 1) - value(step)) * h / 12.0;
        }
        for node in model.first_input()..=model.steps {
            let [before, after] = [node.max(model.first_input() + 1) - 1, (node + 1).min(model.steps)];
            let mean = (value(before) + 6.0 * value(node) + value(after)) / 8.0;
            for row in rows.range(node) {
                let What::InputSize { input: own, sign, limit } = rows.rows[row].what else { continue };
                if own == input {
                    gap += self.multipliers.rows[row] * (s * s - sign * mean / limit);
                }
            }
        }
        gap
    }

    /// Returns the slack of the true motion in the angular-rate and wheel-momentum limits,
    /// multiplied by their multipliers.
    fn slack(&self) -> f64 {
        let (model, rows) = (&self.chain.model, &self.chain.rows.rows);
        let (last, s) = (model.steps, self.iterate.stretch());
        let physical =
            |node: usize| step::physical(model, node, &self.iterate.states[node], &self.iterate.inputs[node]);
        let rate = |node: usize| {
            let state = physical(node);
            model.dynamics.j_inverse * (state.momentum - model.wheel_momentum(&state.wheels))
        };
        // Mean over a step of a quantity that is linear between its nodes.
        let mean = |what: &What, step: usize| {
            let half = |left: &dyn Fn(usize) -> f64| 0.5 * (left(step) + left(step + 1));
            match what {
                What::RateNorm { limit, .. } => {
                    let [a, b] = [step, step + 1].map(rate);
                    let squared = (a.norm_squared() + a.dot(&b) + b.norm_squared()) / 3.0;
                    0.5 * (1.0 - squared / (limit * s).powi(2))
                }
                What::RateAxis { axis, sign, limit, .. } => {
                    half(&|node| s - sign * rate(node)[*axis] / limit)
                }
                What::Wheel { wheel, sign, limit } => {
                    half(&|node| s - sign * physical(node).wheels[*wheel] / limit)
                }
                _ => 0.0,
            }
        };
        let of = |(row, multiplier): (&LimitRow, &f64)| {
            let (what, node) = (&row.what, row.stage);
            let of_arc = matches!(what, What::RateNorm { arc: true, .. } | What::RateAxis { arc: true, .. });
            let slack = match node {
                _ if of_arc => mean(what, node),
                0 => mean(what, 0),
                node if node == last => mean(what, last - 1),
                _ => 0.5 * (mean(what, node - 1) + mean(what, node)),
            };
            multiplier * slack
        };
        rows.iter().zip(&self.multipliers.rows).filter(|(_, multiplier)| **multiplier > 0.0).map(of).sum()
    }

    /// Returns the inputs that the first-order conditions do not determine, with their time
    /// intervals.
    fn undetermined(&self) -> Vec<Undetermined> {
        let (model, rows) = (&self.chain.model, &self.chain.rows.rows);
        let (bounds, nodes, off) = (self.bounds(), model.steps + 1, self.barrier.sqrt());
        let changes: BTreeSet<usize> = rows
            .iter()
            .filter_map(|row| if let What::InputRate { input, .. } = row.what { Some(input) } else { None })
            .collect();
        let is_off = |node: usize, input: usize| {
            let small = self.iterate.inputs[node][input].abs() <= off * bounds[input];
            model.fuel.is_some() && !changes.contains(&input) && small
        };
        let free = |node: usize| {
            (0..model.m).map(|input| node >= model.first_input() && !is_off(node, input)).collect()
        };
        // True for an input that is between its limits at a node, and whose rate of change is not
        // at a limit.
        let mut within: Vec<Vec<bool>> = (0..nodes).map(free).collect();
        // Derivatives of the active state constraints with respect to the inputs of the node. A
        // limit that is active at a node and on the arc after it counts once.
        let mut acting = vec![BTreeMap::new(); nodes];
        for (row, multiplier) in rows.iter().zip(&self.multipliers.rows) {
            let (what, node) = (&row.what, row.stage);
            if *multiplier <= 0.0 && !what.is_equation() {
                continue;
            }
            let index = match what {
                What::InputSize { input, .. } | What::Push { input, .. } => {
                    within[node][*input] = false;
                    continue;
                }
                What::InputNorm { forces, .. } => {
                    within[node][self.inputs(*forces)].fill(false);
                    continue;
                }
                What::InputRate { input, .. } => {
                    within[node][*input] = false;
                    within[node + 1][*input] = false;
                    continue;
                }
                What::RateAxis { axis: index, .. } | What::Wheel { wheel: index, .. } => *index,
                _ => 0,
            };
            acting[node].insert((row.group, index), self.by_inputs(what, node));
        }
        let unknown = within.iter().flatten().filter(|within| **within).count();
        let conditions = acting.iter().map(BTreeMap::len).sum::<usize>() + model.terminal_count();
        if unknown + model.duration.map_or(0, |_| 1) <= conditions {
            return Vec::new();
        }
        let open: Vec<Vec<bool>> =
            within.iter().zip(&acting).map(|(own, rows)| left_open(own, rows.values())).collect();
        let seconds = self.problem.seconds() * self.iterate.stretch();
        let time = |node: usize| model.dynamics.grid.time(node) / model.dynamics.grid.duration() * seconds;
        let mut found = Vec::new();
        for input in 0..model.m {
            let mut begin = 0;
            for node in 0..=nodes {
                if open.get(node).is_some_and(|open| open[input]) {
                    continue;
                }
                if node >= begin + STRETCH {
                    found.push(Undetermined { input, start_s: time(begin), end_s: time(node - 1) });
                }
                begin = node + 1;
            }
        }
        found
    }

    /// Returns the derivatives of the quantity that a row bounds with respect to the inputs of a
    /// node, up to a common factor.
    fn by_inputs(&self, what: &What, node: usize) -> DVector<f64> {
        let model = &self.chain.model;
        let state = step::physical(model, node, &self.iterate.states[node], &self.iterate.inputs[node]);
        let mut slopes = DVector::zeros(model.m);
        let direction = match what {
            What::RateAxis { axis, .. } => Vector3::ith(*axis, 1.0),
            What::RateNorm { .. } => {
                let carried = model.wheel_momentum(&state.wheels);
                model.dynamics.j_inverse * (state.momentum - carried)
            }
            What::Cone(cone) => {
                let met = cone.met(model, node, (&state.attitude, state.stretch), None, true);
                met.map_or_else(Vector3::zeros, |met| met.by_attitude)
            }
            What::Wheel { wheel, .. } => {
                slopes[model.forces + wheel] = 1.0;
                return slopes;
            }
            _ => return slopes,
        };
        let turns = model.turning(false).is_some();
        let (axes, first) = model.channel(false);
        for (slope, axis) in slopes.rows_mut(first, axes.len()).iter_mut().zip(axes) {
            let axis = if turns { state.attitude.tr_mul(axis) } else { *axis };
            *slope = direction.dot(&(model.dynamics.j_inverse * axis));
        }
        slopes
    }

    /// Returns the range of indices of the forces, or of the torques, among the inputs.
    fn inputs(&self, forces: bool) -> Range<usize> {
        let forces_end = self.chain.model.forces;
        if forces { 0..forces_end } else { forces_end..self.chain.model.m }
    }
}

/// Returns, for each input between its limits, whether it can change while the given rows keep
/// their values to first order.
fn left_open<'a>(within: &[bool], rows: impl Iterator<Item = &'a DVector<f64>>) -> Vec<bool> {
    let of_free = |row: &DVector<f64>| {
        DVector::from_fn(row.len(), |input, _| if within[input] { row[input] } else { 0.0 })
    };
    // Orthonormal basis of the row space.
    let mut taken: Vec<DVector<f64>> = Vec::new();
    for row in rows {
        let own = of_free(row);
        let rest = taken.iter().fold(own.clone(), |rest, taken| &rest - taken * taken.dot(&rest));
        if rest.norm() > NOTHING * row.norm() {
            taken.push(rest.normalize());
        }
    }
    let left = |input: usize| 1.0 - taken.iter().map(|taken| taken[input] * taken[input]).sum::<f64>();
    within.iter().enumerate().map(|(input, within)| *within && left(input) > NOTHING).collect()
}

/// Returns the product of a bound, which may be infinite, and a size. The product is 0 if the size
/// is 0.
fn times(bound: f64, size: f64) -> f64 {
    if size == 0.0 { 0.0 } else { bound * size }
}

/// Returns the integral of the positive part of a linear function over a step, given its values at
/// both ends.
fn above_zero([a, b]: [f64; 2], h: f64) -> f64 {
    if a <= 0.0 && b <= 0.0 {
        return 0.0;
    }
    if a >= 0.0 && b >= 0.0 {
        return 0.5 * h * (a + b);
    }
    let (above, below) = if a > b { (a, b) } else { (b, a) };
    0.5 * h * above * above / (above - below)
}
