//! The result of a solver: its outcome, the trajectory, the costates, and the attempts.

use crate::maneuver::constraint::{Shift, Turns};
use crate::maneuver::duration::Duration;
use crate::maneuver::infeasible::Proof;
use crate::maneuver::problem::{EndCondition, Problem, Scheme, State};
use crate::maneuver::settings::Method;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::switching::Switching;
use crate::{Vector3, lie};
use serde::{Deserialize, Serialize};
use std::fmt;

/// The outcome of a solve. The [`Solution`] has the best iterate, whatever the outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The terminal conditions hold within the tolerance.
    Converged,
    /// The iteration limit was reached.
    IterationLimit,
    /// No step reduces the terminal error any more.
    Stalled,
    /// The implicit equation of a step has no solution for the iterate: the steps are too long.
    StepTooLong,
    /// A number became NaN or infinite.
    NotFinite,
    /// The sensitivity matrix is singular beyond the symmetries of the problem.
    Singular,
    /// No plan exists, and [`Solution::infeasible`] has the proof.
    Infeasible,
    /// The time limit was reached.
    TimeLimit,
    /// The caller stopped the solve.
    Interrupted,
}

/// The discrete trajectory, SI units, frames as in the crate's conventions.
///
/// Poses, rates and times have `N + 1` rows. Inputs, torques, forces and costates have `N` rows for
/// Lie–Euler (`u_1 … u_N`, `λ_0 … λ_{N−1}`) and `N + 1` for Lie–Verlet (`u_0 … u_N`,
/// `λ_{−1} … λ_{N−1}`). If inputs switch (minimum time and fuel), inputs and torques have `N` rows
/// and costates `N + 1`: row k is held over the step from node k to node k + 1, and steps may be
/// unequal. The vectors of positions, velocities and forces are empty on SO(3).
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Trajectory {
    /// Times of the nodes \[s\].
    pub time: Vec<f64>,
    /// Attitude quaternions `[w, x, y, z]`, continuous along the trajectory.
    pub quaternion: Vec<[f64; 4]>,
    /// Angular velocity, body axes [rad/s].
    pub angular_velocity: Vec<Vector3>,
    /// Position, reference frame \[m\].
    pub position: Vec<Vector3>,
    /// Velocity, reference frame [m/s].
    pub velocity: Vec<Vector3>,
    /// Inputs, row after row; a row has `input_count` inputs, forces before torques.
    pub input: Vec<f64>,
    /// Number of inputs in a row.
    pub input_count: usize,
    /// Actuator torque, body axes [N·m].
    pub torque: Vec<Vector3>,
    /// Actuator force, reference frame \[N\].
    pub force: Vec<Vector3>,
    /// Momenta of the reaction wheels [N·m·s], row after row, one number per wheel, `N + 1` rows;
    /// empty without wheels.
    pub wheel_momentum: Vec<f64>,
    /// Costates, row after row, with 6 or 12 numbers in each row, in the order of the crate's
    /// conventions.
    pub costates: Vec<f64>,
    /// The end state of the discrete motion, if it differs from the end of the maneuver. It is
    /// shifted so that the true motion under the held inputs reaches the end of the maneuver.
    pub target: Option<State>,
}

impl Trajectory {
    /// Returns the inputs of row `index`, forces before torques, length `input_count`.
    ///
    /// # Panics
    /// Panics if the row does not exist.
    pub fn inputs(&self, index: usize) -> &[f64] {
        &self.input[index * self.input_count..(index + 1) * self.input_count]
    }

    /// Returns the index of the second row of inputs that belongs to step `k`: the row at the end
    /// of the step for Lie–Verlet. For Lie–Euler and for inputs that switch a step has one row,
    /// `k`.
    fn later_row(&self, k: usize) -> usize {
        if self.torque.len() < self.time.len() { k } else { k + 1 }
    }

    /// Returns the torque that the plan holds over step `k`, body axes [N·m]: the mean of the rows
    /// at both ends of the step for Lie–Verlet, the row at its end for Lie–Euler, or the row of the
    /// step if inputs switch.
    ///
    /// # Panics
    /// Panics if the step does not exist.
    pub fn held_torque(&self, k: usize) -> Vector3 {
        let later = self.later_row(k);
        if later == k { self.torque[k] } else { 0.5 * (self.torque[k] + self.torque[later]) }
    }

    /// Returns the inputs that the plan holds over step `k`, as [`Trajectory::held_torque`] does
    /// for the torque.
    ///
    /// # Panics
    /// Panics if the step does not exist.
    pub fn held_inputs(&self, k: usize) -> Vec<f64> {
        let ends = self.inputs(k).iter().zip(self.inputs(self.later_row(k)));
        ends.map(|(first, last)| 0.5 * (first + last)).collect()
    }

    /// Returns the maneuver with its free values replaced by the values of this plan: the duration
    /// if inputs do not switch (so that the plan is on the grid of the maneuver), the attitude at a
    /// free end, and the roll of an end on a target.
    pub fn completed(&self, problem: &Problem) -> Problem {
        let found = self.time.last().filter(|_| problem.seeks_duration() && !problem.switches());
        let mut end = problem.end;
        let last =
            self.quaternion.last().map(|last| lie::project_to_rotation(&lie::rotation_from_quaternion(last)));
        match (&problem.end_condition, last) {
            (EndCondition::AnyAttitude, Some(last)) => end.attitude = last,
            (EndCondition::Aim(aim), Some(last)) => {
                let ends = self.time.last().and_then(|time| problem.ends_on(aim, *time).ok());
                if let Some(ends) = ends {
                    (end.attitude, end.angular_velocity) = ends.at(ends.nearest(&last));
                }
            }
            _ => {}
        }
        let duration = found.map_or(problem.duration, |found| problem.duration.lasting(*found));
        Problem { duration, end, ..problem.clone() }
    }
}

/// The record of landing: the discrete target was shifted by the terminal error of the true motion,
/// and the plan was solved again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Landing {
    /// The number of corrections.
    pub corrections: usize,
    /// The terminal error of the true motion before each correction and after the last one: the
    /// largest part of a [`TerminalError`], scaled. The integrator of the planner computes it; the
    /// witnesses use other integrators.
    pub misses: Vec<f64>,
    /// The cost of the plan before the corrections, whose discrete motion meets the end. Published
    /// plans state this cost, and the costs of [`Solution::rivals`] are compared with it.
    /// [`Solution::cost`] is the cost of the landed plan.
    pub cost_before: f64,
    /// Constraints that were tightened because the true motion exceeded them. Each has its name and
    /// the amount: an angle \[rad\] for a cone, a fraction of the limit for a rate.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drawn_in: Vec<(String, f64)>,
}

/// The choice of the number of steps, if the problem does not fix the number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ChosenSteps {
    /// The number of steps with which the choice began.
    pub began: usize,
    /// Whether the true motion lands on the chosen steps, according to the integrator of the
    /// planner.
    pub lands: bool,
    /// The estimated relative excess of the cost over the optimum in continuous time; `None` if no
    /// estimate exists, such as for a plan of zero cost.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost_error: Option<f64>,
}

/// Distance of the discrete trajectory's end from the terminal conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TerminalError {
    /// Attitude error `|log(R_dᵀ R_N)|` \[rad\].
    pub attitude_rad: f64,
    /// Error of the angular momentum, `|Π_N − Π_d| T / J_mean`.
    pub momentum_relative: f64,
    /// Position error `|x_N − x_d|` over the problem's unit of length; SE(3) only.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub position_relative: Option<f64>,
    /// Error of the linear momentum, `|γ_N − γ_d|` over mass · length / `T`; SE(3) only.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub linear_momentum_relative: Option<f64>,
}

impl TerminalError {
    /// Returns the largest of the errors, in scaled units; NaN if one of them is NaN.
    pub fn largest(&self) -> f64 {
        let parts = [
            self.attitude_rad,
            self.momentum_relative,
            self.position_relative.unwrap_or(0.0),
            self.linear_momentum_relative.unwrap_or(0.0),
        ];
        parts.into_iter().fold(
            0.0,
            |largest, part| {
                if part > largest || part.is_nan() { part } else { largest }
            },
        )
    }
}

/// First- and second-order optimality of the extremal, in scaled units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Optimality {
    /// Whether the second-order conditions were tested. If [`Settings::test_second_order`] is off,
    /// conjugate points are not counted, and the other results of the shooting are unknown: NaN,
    /// and 0 for the rank.
    ///
    /// [`Settings::test_second_order`]: crate::maneuver::Settings::test_second_order
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub tested: bool,
    /// Largest residual of the discrete stationarity conditions; with constraints, of all KKT
    /// conditions.
    pub stationarity: f64,
    /// The number of conjugate points inside the maneuver; 0 for a local minimum. SCP counts the
    /// independent directions, within limits and constraints, in which the cost decreases; 0 for a
    /// strict local minimum. Both counts are equal. `None` means not tested, or undecided: the cost
    /// decreases in no direction, and is constant in some direction.
    pub conjugate_points: Option<usize>,
    /// Numerical rank of the sensitivity matrix Ψ₁₂.
    pub rank: usize,
    /// Ratio of the largest to the smallest singular value of Ψ₁₂ within its rank.
    pub condition: f64,
}

fn yes() -> bool {
    true
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn is_yes(tested: &bool) -> bool {
    *tested
}

impl Optimality {
    /// The record of an extremal that was not tested.
    #[doc(hidden)]
    pub const UNTESTED: Self =
        Self { tested: false, stationarity: f64::NAN, conjugate_points: None, rank: 0, condition: f64::NAN };

    /// Returns the result of the second-order test.
    pub fn second_order(&self) -> SecondOrder {
        match self.conjugate_points {
            Some(0) => SecondOrder::Minimum,
            Some(_) => SecondOrder::Saddle,
            None if self.tested => SecondOrder::Undecided,
            None => SecondOrder::NotTested,
        }
    }
}

/// The result of the second-order test of an extremal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SecondOrder {
    /// A local minimum.
    Minimum,
    /// The cost decreases in some direction. Either descent in this direction found no cheaper
    /// plan, or the spec prescribes the rotation.
    Saddle,
    /// The test does not distinguish a minimum from a saddle within round-off.
    Undecided,
    /// Not tested, because the settings do not request it.
    NotTested,
}

/// Counts and run time of sequential convex programming (SCP).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ConvexWork {
    /// Number of subproblems of the winning seed, on all its grids.
    pub subproblems: usize,
    /// Number of subproblems of all seeds.
    pub all_subproblems: usize,
    /// Interior-point iterations of all subproblems.
    pub cone_iterations: u32,
    /// Wall time inside the cone solver, all seeds \[s\].
    pub cone_seconds: f64,
}

/// Counts of the interior-point method, and bounds on the distance of its plan from the optimum.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct InteriorWork {
    /// Iterations of the winning start, on all its grids.
    pub iterations: usize,
    /// Number of solves: all starts on all grids.
    pub starts: usize,
    /// The last barrier parameter μ, scaled: the product of slack and multiplier of each row.
    pub mu: f64,
    /// The relative complementarity gap: the barrier parameter summed over all rows, divided by the
    /// cost. A neighbouring plan may save this part of the cost by complementarity.
    pub gap: f64,
    /// The estimated cost of the plan in continuous time; `None` without an estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous: Option<ContinuousCost>,
    /// The first-order gap of a minimum-time or minimum-fuel plan in continuous time: the cost that
    /// switches between the nodes could save.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous_gap: Option<ContinuousGap>,
}

/// The estimated cost of a plan in continuous time, from its grid and a grid of half as many steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ContinuousCost {
    /// The estimated cost, in the unit of [`Solution::cost`].
    pub cost: f64,
    /// The possible error of the estimate, in the same unit: the difference of the costs on both
    /// grids, and the cost of landing.
    pub error: f64,
}

impl ContinuousCost {
    pub(crate) fn new(cost: f64, error: f64) -> Self {
        Self { cost, error }
    }
}

/// The cost that a minimum-time or minimum-fuel plan could save, to first order, by switches
/// between the nodes, and the inputs that the first-order conditions do not determine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ContinuousGap {
    /// The integral `∫ (H(u) − min H) dt` along the plan before it lands, in the unit of
    /// [`Solution::cost`]. Here u are the inputs that are held over a step, and the minimum is over
    /// the limits of the inputs. The costates are those of the discrete optimum, interpolated
    /// linearly between nodes. The gap compares with neighbouring plans to first order; it is not a
    /// bound for plans on other paths.
    pub gap: f64,
    /// The first-order cost increase of a landed plan by tightened constraints, in the same unit as
    /// the gap. The plan may cost this much more.
    #[serde(default)]
    pub drawn_in: f64,
    /// Inputs on which the cost does not depend to first order, so that the optimum may not be
    /// unique.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub undetermined: Vec<Undetermined>,
}

/// A time interval of a plan in which an input is not at a limit, and can change to first order
/// while the active limits of the state keep their values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Undetermined {
    /// Index of the input, from 0; forces come before torques.
    pub input: usize,
    /// Time of the first node of the interval \[s\].
    pub start_s: f64,
    /// Time of the last node of the interval \[s\].
    pub end_s: f64,
}

/// The nodes at which a constraint is active, and its multipliers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ActiveConstraint {
    /// Name of the constraint, or of the limit: "torque limit", "torque rate limit", …
    pub name: String,
    /// Times at which the constraint is active \[s\].
    pub time_s: Vec<f64>,
    /// The multipliers of the constraint at these times, in scaled units, nonnegative. For a limit
    /// of the inputs found by the shooting, the multiplier is the decrease of the running cost per
    /// relative growth of the limit, `−∂(cost rate)/∂ ln ū`.
    pub multiplier: Vec<f64>,
}

impl ActiveConstraint {
    #[doc(hidden)]
    pub fn new(name: &str, time_s: Vec<f64>, multiplier: Vec<f64>) -> Self {
        Self { name: name.into(), time_s, multiplier }
    }
}

/// A strategy of the search: one method to find a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rung {
    /// Newton shooting from given costates, on the requested grid.
    Guess,
    /// Newton shooting from a ballistic start, on a coarse grid.
    Newton,
    /// Refinement of a coarse extremal on the requested grid.
    CoarseToFine,
    /// Descent over paths, from a path between the boundary states.
    Descent,
    /// Lifted Newton iteration, from the nodes of a path or of an extremal without limits.
    Lifted,
    /// Newton shooting with the saturated control law, from an extremal without limits or from the
    /// result of the interior point.
    Saturated,
    /// Sequential convex programming.
    Scp,
    /// The interior-point method, from the result of SCP.
    Polish,
    /// The interior-point method.
    InteriorPoint,
    /// Smoothed extremals of minimum time or fuel, from a path between the boundary states.
    Smoothed,
    /// Newton iteration on the switching times, from a smoothed extremal.
    Switches,
    /// Optimisation of the times of pulses with a minimum width.
    Pulses,
    /// The discrete optimum on a grid that is aligned with the arcs.
    Aligned,
    /// The witnesses, which verify the result. They are not a strategy and not in the fallback
    /// sequence.
    Witnesses,
}

impl Rung {
    /// Returns the name of the strategy in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Guess => "guess",
            Self::Newton => "newton",
            Self::CoarseToFine => "coarse_to_fine",
            Self::Descent => "descent",
            Self::Lifted => "lifted",
            Self::Saturated => "saturated",
            Self::Scp => "scp",
            Self::Polish => "polish",
            Self::InteriorPoint => "interior_point",
            Self::Smoothed => "smoothed",
            Self::Switches => "switches",
            Self::Pulses => "pulses",
            Self::Aligned => "aligned",
            Self::Witnesses => "witnesses",
        }
    }
}

impl fmt::Display for Rung {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(self.name())
    }
}

/// One run of a strategy: its input and its outcome.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RungReport {
    /// The strategy.
    pub rung: Rung,
    /// The name of the start: "short", "long", "+1 turn", …
    pub start: String,
    /// Number of steps of the grid on which the strategy worked.
    pub steps: usize,
    /// The outcome of the run.
    pub outcome: Outcome,
    /// Number of Newton iterations.
    pub iterations: usize,
    /// The scaled terminal errors: before the first iteration, and after each iteration.
    pub residuals: Vec<f64>,
}

impl RungReport {
    #[doc(hidden)]
    pub fn new(rung: Rung, start: &str, steps: usize, outcome: Outcome, residuals: Vec<f64>) -> Self {
        let iterations = residuals.len().saturating_sub(1);
        Self { rung, start: start.into(), steps, outcome, iterations, residuals }
    }
}

/// Another extremal between the same boundary states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Rival {
    /// The start from which the extremal was found.
    pub start: String,
    /// Homotopy class of the rotation: short or long way.
    pub sense: Sense,
    /// Cost of the extremal, defined as [`Solution::cost`] is.
    pub cost: f64,
    /// Number of conjugate points of the extremal; `None` if they were not counted.
    pub conjugate_points: Option<usize>,
    /// Total angle turned, `∫|Ω|dt` \[deg\].
    pub turned_deg: f64,
}

impl Rival {
    #[doc(hidden)]
    pub fn new(start: &str, sense: Sense, cost: f64, turned_deg: f64) -> Self {
        Self { start: start.into(), sense, cost, conjugate_points: None, turned_deg }
    }
}

/// Homotopy class of a path, modulo double turns: whether the path can be deformed, with fixed
/// ends, into the ballistic motion followed by the shortest rotation to the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sense {
    /// The short way: the path can be deformed into the ballistic motion followed by the shortest
    /// rotation.
    Short,
    /// The long way: the path differs from the short way by one full turn.
    Long,
}

/// The result of a solve: a converged plan, or the best iterate. Numbers are NaN and lists are
/// empty if no iterate exists.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// The outcome of the solve.
    pub outcome: Outcome,
    /// The method that produced the result: shooting, interior point, or sequential convex
    /// programming.
    pub method: Method,
    /// The integration scheme.
    pub scheme: Scheme,
    /// Number of steps.
    pub steps: usize,
    /// Step `T/N` \[s\].
    pub step: f64,
    /// Cost of the plan: effort, fuel or duration, plus the price of time. The effort is
    /// `Σ (h/2) uᵀWu`, trapezoidal for Lie–Verlet, in [N²·m²·s] on SO(3) with unit weights.
    pub cost: f64,
    /// The trajectory, its inputs and costates.
    pub trajectory: Trajectory,
    /// The scaled terminal error of the discrete motion, relative to [`Trajectory::target`] if that
    /// exists. The tolerance is a limit on [`TerminalError::largest`].
    pub terminal: TerminalError,
    /// The record of landing, if landing was tried: the corrections of the discrete target, and the
    /// terminal errors of the true motion.
    pub landing: Option<Landing>,
    /// The choice of the number of steps, if the problem does not fix the number.
    pub chosen: Option<ChosenSteps>,
    /// The results of the optimality tests.
    pub optimality: Optimality,
    /// Homotopy class of the path.
    pub sense: Sense,
    /// Name of the start from which the plan was found.
    pub start: String,
    /// Total angle turned, `∫|Ω|dt` \[deg\].
    pub turned_deg: f64,
    /// Newton iterations of the winning start, over its whole fallback sequence.
    pub iterations: usize,
    /// All runs of strategies, in order: [`Rung`], start, steps, outcome, iterations and scaled
    /// residuals of each.
    pub ladder: Vec<RungReport>,
    /// Counts of SCP, if it ran: subproblems, iterations and run time of the cone solver.
    pub convex: Option<ConvexWork>,
    /// Counts of the interior point and bounds on the distance from the optimum, if the interior
    /// point found the plan.
    pub interior: Option<InteriorWork>,
    /// The active limits and constraints: name, times \[s\] and multipliers of each.
    pub active: Vec<ActiveConstraint>,
    /// Arcs and certificate of a minimum-time or minimum-fuel plan: the structure, and the arcs,
    /// duration, cost and gap of the continuous extremal.
    pub switching: Option<Switching>,
    /// The alternative sets of constraints and the times at which each holds, in order.
    pub turns: Vec<Turns>,
    /// Other extremals that were found, cheapest first: start, homotopy class, cost, conjugate
    /// points and angle turned of each.
    pub rivals: Vec<Rival>,
    /// The proof that no plan exists, if one was found: its `reason` in words, and a
    /// `duration_lower_bound` \[s\] if one is known.
    pub infeasible: Option<Proof>,
    /// The reason why no plan was found, such as the remaining violations of the nearest iterate;
    /// `None` if a plan was found.
    pub shortfall: Option<Shortfall>,
    /// The shortest duration \[s\] that was found, a local minimum, if no plan was found for the
    /// requested duration.
    pub shortest: Option<f64>,
    /// A longer duration \[s\] that has a plan, if no plan was found for the requested duration.
    /// Either a plan was found for it, or it suffices for a turn about a fixed axis within the
    /// limits. `None` if no such duration is known.
    pub longer: Option<f64>,
    /// The requested tolerance, scaled.
    pub tolerance: f64,
    /// Wall time of the solve \[s\], without second-order test and verification.
    pub solve_time: f64,
}

impl Solution {
    /// Adds the cost of landing to the error of the estimated cost in continuous time. A landed
    /// plan is a motion in continuous time, so the optimum in continuous time costs no more.
    pub(crate) fn widen_by_landing(&mut self) {
        let landed = self.landing.as_ref().map_or(0.0, |landing| (self.cost - landing.cost_before).abs());
        if let Some(continuous) = self.interior.as_mut().and_then(|work| work.continuous.as_mut()) {
            continuous.error += landed;
        }
    }

    /// Adds `price`, the price of the duration, to every reported cost. It serves for a free
    /// duration that was planned as a given one.
    pub(crate) fn pay_for_time(&mut self, price: f64) {
        self.cost += price;
        for rival in &mut self.rivals {
            rival.cost += price;
        }
        if let Some(landing) = &mut self.landing {
            landing.cost_before += price;
        }
        if let Some(continuous) = self.interior.as_mut().and_then(|work| work.continuous.as_mut()) {
            continuous.cost += price;
        }
        if let Some(switching) = &mut self.switching {
            switching.continuous_cost += price;
            if let Some(pulses) = &mut switching.pulses {
                pulses.cost_without += price;
            }
        }
    }

    /// Returns an empty solution, without the data of a maneuver.
    #[doc(hidden)]
    pub fn unknown() -> Self {
        let nan = f64::NAN;
        Self {
            outcome: Outcome::Stalled,
            method: Method::Shooting,
            scheme: Scheme::LieVerlet,
            steps: 0,
            step: nan,
            cost: nan,
            trajectory: Trajectory::default(),
            terminal: TerminalError { attitude_rad: nan, momentum_relative: nan, ..TerminalError::default() },
            landing: None,
            chosen: None,
            optimality: Optimality { tested: true, ..Optimality::UNTESTED },
            sense: Sense::Short,
            start: String::new(),
            turned_deg: nan,
            iterations: 0,
            ladder: Vec::new(),
            convex: None,
            interior: None,
            active: Vec::new(),
            switching: None,
            turns: Vec::new(),
            rivals: Vec::new(),
            infeasible: None,
            shortfall: None,
            shortest: None,
            longer: None,
            tolerance: nan,
            solve_time: 0.0,
        }
    }

    /// Returns a solution of `problem` without results.
    pub(crate) fn unsolved(problem: &Problem, tolerance: f64) -> Self {
        let unknown = Self::unknown();
        let translation = (problem.dimension() == 12).then_some(f64::NAN);
        Self {
            scheme: problem.scheme,
            steps: problem.steps,
            step: problem.duration.known().map_or(f64::NAN, |duration| duration / problem.steps as f64),
            terminal: TerminalError {
                position_relative: translation,
                linear_momentum_relative: translation,
                ..unknown.terminal
            },
            tolerance,
            ..unknown
        }
    }

    /// Returns the duration of the plan \[s\], given or found; NaN if the duration is free and not
    /// found.
    pub fn duration(&self, problem: &Problem) -> f64 {
        match problem.duration {
            Duration::Given(duration) => duration,
            Duration::Sought { .. } | Duration::Found { .. } => {
                self.trajectory.time.last().copied().unwrap_or(f64::NAN)
            }
        }
    }

    /// Returns `problem` on the grid of this plan. The result has:
    /// - the shifts of its alternatives
    /// - the number of steps of the plan, which may have been chosen, or may be one more than
    ///   requested
    /// - the duration that was found, if it was free
    /// - the attitude at the end, if it was free
    /// - a uniform grid if the interior point has planned it, or the steps of arcs if no constraint
    ///   is active
    pub fn on_grid(&self, problem: &Problem) -> Problem {
        let steps = if self.steps > 0 { self.steps } else { problem.steps };
        let problem = if self.turns.is_empty() { problem } else { &problem.in_turns(&self.turns_flown()) };
        let arcs = self.method == Method::Shooting && self.switching.is_some();
        let problem = problem.clone();
        let problem = if arcs { problem.planned_on_arcs() } else { problem.planned_by(self.method) };
        self.trajectory.completed(&problem).with_steps(steps)
    }

    /// Returns the shifts of the alternatives that are flown, cut at the end of the plan.
    fn turns_flown(&self) -> Vec<Turns> {
        let end = self.trajectory.time.last().copied().unwrap_or(f64::INFINITY);
        let begun = |shift: &&Shift| shift.from < end;
        let cut = |shift: &Shift| Shift { to: shift.to.min(end), ..*shift };
        let flown = |turns: &Turns| Turns {
            shifts: turns.shifts.iter().filter(begun).map(cut).collect(),
            ..turns.clone()
        };
        self.turns.iter().map(flown).collect()
    }

    /// Returns the costates that the shooting solves for: `λ_0` for Lie–Euler, `λ_{−1}` for
    /// Lie–Verlet, SI.
    pub fn costates_0(&self, problem: &Problem) -> &[f64] {
        &self.trajectory.costates[..problem.dimension().min(self.trajectory.costates.len())]
    }
}
