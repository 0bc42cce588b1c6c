//! What a solver returns: how it ended, the trajectory, the costates, and how it got there.

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

/// How a solve ended. The best iterate is always in the [`Solution`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The terminal conditions are met to the tolerance.
    Converged,
    /// The iteration limit was reached.
    IterationLimit,
    /// No step reduces the terminal error any more.
    Stalled,
    /// The implicit equation of a step has no solution along the iterate: steps too long.
    StepTooLong,
    /// A number became NaN or infinite.
    NotFinite,
    /// The sensitivity matrix is singular beyond the symmetries of the problem.
    Singular,
    /// No plan exists, and [`Solution::infeasible`] says why.
    Infeasible,
    /// The time limit was reached.
    TimeLimit,
    /// The caller asked to stop.
    Interrupted,
}

/// The discrete trajectory, SI units, frames as in the crate's conventions.
///
/// Poses, rates and times have `N + 1` rows. Inputs, torques, forces and costates have `N` rows for Lie–Euler (`u_1 …
/// u_N`, `λ_0 … λ_{N−1}`) and `N + 1` for Lie–Verlet (`u_0 … u_N`, `λ_{−1} … λ_{N−1}`). Where time or fuel is
/// minimised inputs and torques are held over steps that need not be equal: row k, of N, belongs to the step from
/// node k to node k + 1, and costates have `N + 1` rows. On SO(3) the vectors of positions, velocities and forces are
/// empty.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Trajectory {
    /// Times \[s\].
    pub time: Vec<f64>,
    /// Attitude quaternions `[w, x, y, z]`, continuous along the trajectory.
    pub quaternion: Vec<[f64; 4]>,
    /// Angular velocity, body axes [rad/s].
    pub angular_velocity: Vec<Vector3>,
    /// Position, reference frame \[m\].
    pub position: Vec<Vector3>,
    /// Velocity, reference frame [m/s].
    pub velocity: Vec<Vector3>,
    /// Inputs, row after row, forces before torques; `input_count` numbers a row.
    pub input: Vec<f64>,
    /// Number of inputs in a row.
    pub input_count: usize,
    /// Actuator torque, body axes [N·m].
    pub torque: Vec<Vector3>,
    /// Actuator force, reference frame \[N\].
    pub force: Vec<Vector3>,
    /// Momenta of the reaction wheels [N·m·s], row after row, one number per wheel, `N + 1` rows; empty
    /// without wheels.
    pub wheel_momentum: Vec<f64>,
    /// Costates, row after row, 6 or 12 numbers a row, ordered as the crate's conventions say.
    pub costates: Vec<f64>,
    /// Where the discrete motion ends, if that is not the end of the maneuver: so shifted that the true motion under the
    /// inputs, held over the steps, ends there.
    pub target: Option<State>,
}

impl Trajectory {
    /// Inputs of row `index`, forces before torques, length `input_count`.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn inputs(&self, index: usize) -> &[f64] {
        &self.input[index * self.input_count..(index + 1) * self.input_count]
    }

    /// A maneuver with what this plan of it has found: the duration where that was sought and inputs do not switch, so that
    /// the grid of the plan is the maneuver's own, the attitude at the end where any will do, and the roll of an end on a target.
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

/// How a plan was made to land: its discrete target was shifted by what the true motion missed, and it was solved again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Landing {
    /// How often.
    pub corrections: usize,
    /// What the true motion missed before each correction, and after the last: the largest of the four parts of a
    /// [`TerminalError`], scaled. By the planner's own flow; the witnesses have theirs.
    pub misses: Vec<f64>,
    /// Cost of the plan whose discrete motion meets the end, from which the corrections began: what published plans state, and
    /// what [`Solution::rivals`] compare with. Of the landed plan it is [`Solution::cost`].
    pub cost_before: f64,
    /// Constraints that were drawn in because the true motion exceeded them: by how much \[rad\], or of rates which part of the
    /// limit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drawn_in: Vec<(String, f64)>,
}

/// How the number of steps was chosen, where none was given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ChosenSteps {
    /// The number that the choice began with.
    pub began: usize,
    /// Whether the true motion lands on those that were chosen, by the planner's own flow.
    pub lands: bool,
    /// What the plan costs above the optimum in continuous time, relative, by estimate; `None` where there is none, as where it
    /// costs nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost_error: Option<f64>,
}

/// Distance of the discrete trajectory's end from the terminal conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TerminalError {
    /// `|log(R_dᵀ R_N)|` \[rad\].
    pub attitude_rad: f64,
    /// `|Π_N − Π_d| T / J_mean`.
    pub momentum_relative: f64,
    /// `|x_N − x_d|` over the problem's unit of length; SE(3) only.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub position_relative: Option<f64>,
    /// `|γ_N − γ_d|` over mass · length / `T`; SE(3) only.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub linear_momentum_relative: Option<f64>,
}

impl TerminalError {
    /// The largest of the four, all in scaled units. NaN if any is NaN.
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
    /// Whether it was tested. Where that was not asked for ([`Settings::test_second_order`]), conjugate points are not counted,
    /// and of the shooting the other numbers are unknown too: NaN, and 0 for the rank.
    ///
    /// [`Settings::test_second_order`]: crate::maneuver::Settings::test_second_order
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub tested: bool,
    /// Largest residual of the discrete stationarity conditions; with constraints, of all the conditions
    /// of Karush, Kuhn and Tucker.
    pub stationarity: f64,
    /// Number of conjugate points inside the maneuver; 0: a local minimum. From SCP the number
    /// of independent directions, among those that limits and constraints leave, in which the cost
    /// decreases; 0: a strict local minimum. The two are one number. `None`: not decided, as where it decreases in none and is level
    /// in some.
    pub conjugate_points: Option<usize>,
    /// Numerical rank of the sensitivity matrix Ψ₁₂.
    pub rank: usize,
    /// Ratio of its largest to its smallest singular value within that rank.
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
    /// Of what was not tested.
    #[doc(hidden)]
    pub const UNTESTED: Self =
        Self { tested: false, stationarity: f64::NAN, conjugate_points: None, rank: 0, condition: f64::NAN };

    /// What the count says of the extremal.
    pub fn second_order(&self) -> SecondOrder {
        match self.conjugate_points {
            Some(0) => SecondOrder::Minimum,
            Some(_) => SecondOrder::Saddle,
            None if self.tested => SecondOrder::Undecided,
            None => SecondOrder::NotTested,
        }
    }
}

/// What the second order says of an extremal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SecondOrder {
    /// A local minimum.
    Minimum,
    /// The cost decreases in some direction, and nothing cheaper was found by going there, or the rotation was given.
    Saddle,
    /// Not decided.
    Undecided,
    /// Not tested, because it was not asked for.
    NotTested,
}

/// What SCP took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ConvexWork {
    /// Subproblems of the seed that won, on all its grids.
    pub subproblems: usize,
    /// Subproblems of all seeds.
    pub all_subproblems: usize,
    /// Interior-point iterations of all.
    pub cone_iterations: u32,
    /// Wall time inside the cone solver, all seeds \[s\].
    pub cone_seconds: f64,
    /// Share of the effort that stands in the cost beside time or fuel, and for which the plan is stationary; 0 otherwise.
    pub effort_share: f64,
}

/// Where a constraint is active, and how hard.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ActiveConstraint {
    /// Name of the constraint, or of the limit: "torque limit", "torque rate limit", …
    pub name: String,
    /// Times at which it is active \[s\].
    pub time_s: Vec<f64>,
    /// Its multipliers there, scaled units, not negative. Of a limit of the inputs, as the shooting finds
    /// it: how fast the running cost falls as the limit grows, `−∂(cost rate)/∂ ln ū`.
    pub multiplier: Vec<f64>,
}

impl ActiveConstraint {
    #[doc(hidden)]
    pub fn new(name: &str, time_s: Vec<f64>, multiplier: Vec<f64>) -> Self {
        Self { name: name.into(), time_s, multiplier }
    }
}

/// A rung of the ladder: one way to look for a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rung {
    /// Newton shooting from given costates, on the requested grid.
    Guess,
    /// Newton shooting from a ballistic start, on a coarse grid.
    Newton,
    /// A coarse extremal carried to the requested grid.
    CoarseToFine,
    /// Descent on paths from a path between the boundary states.
    Descent,
    /// Lifted Newton from the nodes of a path, or of an extremal without limits.
    Lifted,
    /// Newton with the saturated law, from an extremal without limits.
    Saturated,
    /// The limits of the inputs drawn in from where they do not act.
    Limits,
    /// Sequential convex programming.
    Scp,
    /// Newton on the active set, from what the convex iteration left.
    Polish,
    /// The interior point.
    InteriorPoint,
    /// Smoothed extremals of minimum time or fuel, from a path between the boundary states.
    Smoothed,
    /// Newton on switching times, from a smoothed extremal.
    Switches,
    /// The best times of pulses of a shortest length.
    Pulses,
    /// The discrete optimum on a grid that is aligned with the arcs.
    Aligned,
    /// No rung, and not in the ladder: the witnesses judge what was found.
    Witnesses,
}

impl Rung {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Guess => "guess",
            Self::Newton => "newton",
            Self::CoarseToFine => "coarse_to_fine",
            Self::Descent => "descent",
            Self::Lifted => "lifted",
            Self::Saturated => "saturated",
            Self::Limits => "limits",
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

/// One run of a rung: what was tried and how it ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RungReport {
    /// Which rung.
    pub rung: Rung,
    /// From which start: "short", "long", "+1 turn", …
    pub start: String,
    /// Steps of the grid it worked on.
    pub steps: usize,
    /// How it ended.
    pub outcome: Outcome,
    /// Newton iterations spent.
    pub iterations: usize,
    /// The scaled terminal error after each iteration, the first before any.
    pub residuals: Vec<f64>,
}

impl RungReport {
    #[doc(hidden)]
    pub fn new(rung: Rung, start: &str, steps: usize, outcome: Outcome, residuals: Vec<f64>) -> Self {
        let iterations = residuals.len().saturating_sub(1);
        Self { rung, start: start.into(), steps, outcome, iterations, residuals }
    }
}

/// Another extremal with the same boundary data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Rival {
    /// From which start it was found.
    pub start: String,
    /// Rotation sense: "short" or "long".
    pub sense: Sense,
    /// Its cost, as [`Solution::cost`].
    pub cost: f64,
    /// Its conjugate points, if counted.
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

/// Rotation sense of a path, up to full double turns: whether it can be deformed, ends fixed, into
/// the ballistic motion followed by the shortest rotation to the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sense {
    /// It can.
    Short,
    /// It differs from that by one full turn.
    Long,
}

/// A planned maneuver, converged or the best iterate. Where there is no iterate numbers are NaN and lists empty.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// How the solve ended.
    pub outcome: Outcome,
    /// Which method led here: shooting, or sequential convex programming with polish.
    pub method: Method,
    /// The discretisation.
    pub scheme: Scheme,
    /// Number of steps.
    pub steps: usize,
    /// Step \[s\].
    pub step: f64,
    /// Cost `Σ (h/2) uᵀWu`, trapezoidal for Lie–Verlet: [N²·m²·s] on SO(3) with unit weights.
    pub cost: f64,
    /// The trajectory, its inputs and costates.
    pub trajectory: Trajectory,
    /// Discrete terminal error, scaled, against [`Trajectory::target`] where there is one; its `largest()` is what the tolerance holds.
    pub terminal: TerminalError,
    /// How it was made to land, where that was tried: `corrections` of the discrete target, and what each left to be missed.
    pub landing: Option<Landing>,
    /// How its steps were chosen, where they were not given.
    pub chosen: Option<ChosenSteps>,
    /// Optimality of the extremal.
    pub optimality: Optimality,
    /// Rotation sense of the path.
    pub sense: Sense,
    /// The start that led here.
    pub start: String,
    /// Total angle turned, `∫|Ω|dt` \[deg\].
    pub turned_deg: f64,
    /// Newton iterations of the winning start, all its rungs.
    pub iterations: usize,
    /// Everything tried, in order: [`Rung`], start, steps, outcome, iterations and scaled residuals of each.
    pub ladder: Vec<RungReport>,
    /// What SCP took, where it was run: subproblems, iterations and time of the cone solver.
    pub convex: Option<ConvexWork>,
    /// Which limits and constraints are active: name, times \[s\] and multipliers of each.
    pub active: Vec<ActiveConstraint>,
    /// Arcs and certificate, where time or fuel is minimised: the structure, the arcs of the continuous extremal, its duration, cost
    /// and gap.
    pub switching: Option<Switching>,
    /// Which set of each of the alternatives holds when, in their order.
    pub turns: Vec<Turns>,
    /// Other extremals found, cheapest first: start, sense, cost, conjugate points and angle turned of each.
    pub rivals: Vec<Rival>,
    /// The proof that there is no plan, where there is one: its `reason` in words, and a `duration_lower_bound` \[s\] where one is
    /// known.
    pub infeasible: Option<Proof>,
    /// What stays violated where the search came nearest, and what would help; where no plan was found.
    pub shortfall: Option<Shortfall>,
    /// The shortest duration \[s\] that was found, a local minimum, where no plan was for the one asked for. Of a plan whose
    /// duration was sought: less time would cost less, but no plan that takes less was found.
    pub shortest: Option<f64>,
    /// A longer duration \[s\] for which a plan was found, where none was for the one asked for.
    pub longer: Option<f64>,
    /// Tolerance asked for, scaled.
    pub tolerance: f64,
    /// Wall time of the solve alone \[s\], without second-order test and verification.
    pub solve_time: f64,
}

impl Solution {
    /// Adds what the time of a plan costs to all that is told of its cost: of a duration that was sought, planned as a given one.
    pub(crate) fn pay_for_time(&mut self, price: f64) {
        self.cost += price;
        for rival in &mut self.rivals {
            rival.cost += price;
        }
        if let Some(landing) = &mut self.landing {
            landing.cost_before += price;
        }
        if let Some(switching) = &mut self.switching {
            switching.continuous_cost += price;
            if let Some(pulses) = &mut switching.pulses {
                pulses.cost_without += price;
            }
        }
    }

    /// A solution of which nothing is known, not even the maneuver.
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

    /// A solution of which nothing is known yet.
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

    /// Duration of the plan \[s\]: that of the maneuver, or the one found where it is sought; NaN where none is.
    pub fn duration(&self, problem: &Problem) -> f64 {
        match problem.duration {
            Duration::Given(duration) => duration,
            Duration::Sought { .. } | Duration::Found { .. } => {
                self.trajectory.time.last().copied().unwrap_or(f64::NAN)
            }
        }
    }

    /// The maneuver as it is planned, on the grid of its plan: with its alternatives in their shifts, the number of steps that the plan
    /// has, which may have been chosen, or be one more than was asked for, with the duration that was found where it was sought, the
    /// attitude at the end where any will do, and on equal steps where SCP has planned it, or on those of arcs where no constraint acts.
    pub fn on_grid(&self, problem: &Problem) -> Problem {
        let steps = if self.steps > 0 { self.steps } else { problem.steps };
        let problem = if self.turns.is_empty() { problem } else { &problem.in_turns(&self.turns_flown()) };
        let arcs = self.method == Method::Shooting && self.switching.is_some();
        let problem = problem.clone();
        let problem = if arcs { problem.planned_on_arcs() } else { problem.planned_by(self.method) };
        self.trajectory.completed(&problem).with_steps(steps)
    }

    /// The shifts until the plan ends.
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

    /// The costates that the shooting solves for: `λ_0` for Lie–Euler, `λ_{−1}` for Lie–Verlet, SI.
    pub fn costates_0(&self, problem: &Problem) -> &[f64] {
        &self.trajectory.costates[..problem.dimension().min(self.trajectory.costates.len())]
    }
}
