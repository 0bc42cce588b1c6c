//! Replanning from the present state of the craft: the extremal of the plan is moved to a
//! neighbouring start, and then solved by Newton's method.
//!
//! ```text
//! guess     λ_{k−1} = λ*_{k−1} + D_k z ,        z = [log(R*_kᵀ R); Π − Π*_k] ,
//!           D_k = (I + G_k Q/2)⁻¹ G_k K₊ ,      G_k = A_kᵀ P_k + H_k
//! solve     λ ← λ − Ψ₁₂⁻¹ e(λ) ,     on the N − k steps that are left
//! ```
//!
//! `D_k` is the derivative of the neighbouring extremal ([`Gains`]). The guess misses the end by an
//! error of order `|z|²`, and each Newton step squares the error, so Newton's method needs two or
//! three steps. A change of the requested end enters with the first Newton step: `−Ψ₁₂⁻¹ e` is its
//! linear prediction. All quantities that depend on the plan alone are computed once.
//!
//! If the time `t` lies between two nodes, the plan is interpolated, and the remaining time is
//! divided into equal steps whose length is nearest to the length of the plan's steps. The end
//! keeps its time, and each of n steps differs in length from a step of the plan by at most the
//! fraction 1/2n.
//!
//! A landed plan has a discrete target near its end. Each moment here has its own discrete target,
//! the state that the plan's inputs reach from the true motion at that time. A start on the plan
//! therefore reproduces the inputs of the plan. A start that deviates by `z` misses the end of the
//! true motion by `O(h²)` times `z`.
//!
//! The result is the plan's own neighbour. It does not show whether another homotopy class now has
//! a lower cost.

use super::{Gains, Kind, first_costate};
use crate::lie;
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::{EndCondition, Formulation, Motion, Path, Problem, State};
use crate::maneuver::settings::Settings;
use crate::maneuver::solution::{Outcome, Solution};
use crate::numerics::compensated::Sum;
use crate::numerics::factor::Factor;
use crate::optimize::discrete::linear_plan::{LinearPlan, Matrix6, Timing, Vector6, kick};
use crate::optimize::discrete::step::Point;
use crate::optimize::discrete::sweep::{BoundaryValueProblem, Node};
use crate::optimize::discrete::terminal::TerminalCondition;
use crate::optimize::methods::shooting::newton::outcome_of;
use crate::optimize::search::{self, Observer, PlanError};
use crate::optimize::{Obstacle, shooting_obstacle};
use std::fmt;
use thiserror::Error;

/// Number of Newton steps after which a start counts as outside the plan's basin of convergence;
/// inside it three steps suffice.
const MOST_STEPS: usize = 8;
/// Largest accepted ratio of the errors after and before a Newton step. Inside the basin of
/// convergence a step squares the error.
const PROGRESS: f64 = 0.5;
/// Scaled error below which one more Newton step with the previous derivatives meets any tolerance,
/// because these derivatives are accurate to 1e-3.
const NEARLY: f64 = 1e-9;
/// Largest scaled terminal error with which recorded costates count as the costates of their plan.
const OWN: f64 = 1e-6;
/// Largest accepted excess of the cost of a neighbour over the plan's cost to go, as a fraction of
/// it. The excess is of second order in the deviation.
const DEARER: f64 = 0.5;
/// Fraction of a step within which a time counts as the time of a node. It covers the round-off of
/// times in files.
const AT_NODE: f64 = 1e-9;
/// Relative tolerance within which the inertias of two maneuvers count as equal. It covers the
/// round-off of numbers in files.
const SAME: f64 = 1e-9;

/// The reason why no replanning from this plan is possible.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NotReplanned {
    /// The body translates, and replanning supports attitude maneuvers only.
    #[error("the body translates: replanning supports only attitudes")]
    Translation,
    /// The plan is bang-bang, or its duration was free.
    #[error(
        "replanning needs a minimum-effort plan of a given duration: a plan with switching inputs \
        or a free duration has no neighbour on its grid"
    )]
    Form,
    /// The maneuver has a limit that the method `shooting` cannot enforce.
    #[error("its limits have no continuous costates: {0}")]
    Limited(Obstacle),
    /// The terminal attitude of the maneuver is free.
    #[error("its end attitude is free: replanning needs a given attitude and rate at the end")]
    End,
    /// The plan has no trajectory with costates, or its costates do not lead to the end of the
    /// maneuver.
    #[error("its costates do not lead to its end: it did not converge, or belongs to another maneuver")]
    Trajectory,
    /// The plan belongs to another maneuver; the text names the quantity that differs.
    #[error("it belongs to a maneuver with {0}")]
    Other(&'static str),
    /// The requested time is before the plan begins, or within its last two steps.
    #[error(
        "at {at} s replanning is impossible, because it needs at least two remaining steps: choose a \
        time from 0 to {latest} s"
    )]
    Time {
        /// The requested time \[s\].
        at: f64,
        /// The latest time at which replanning can start \[s\].
        latest: f64,
    },
}

/// The reason why no neighbour of the plan was found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Left {
    /// Newton's method did not converge within a few steps.
    NotConverged {
        /// The outcome of Newton's method.
        outcome: Outcome,
        /// The number of Newton steps taken.
        steps: usize,
        /// The remaining terminal error, scaled; NaN if no sweep reached its end.
        residual: f64,
    },
    /// Newton's method converged to an extremal that costs more than a neighbour of the plan can.
    Dearer {
        /// Cost of the extremal that was found.
        cost: f64,
        /// Cost that a neighbour of the plan should have, to second order in the deviation.
        expected: f64,
    },
    /// The extremal is not a minimum, or it lies in another homotopy class than the requested one.
    NoMinimum,
}

impl fmt::Display for Left {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotConverged { steps, residual, .. } if residual.is_finite() => {
                write!(f, "after {steps} Newton steps the motion still missed the end by {residual:.1e}")
            }
            Self::NotConverged { .. } => f.write_str("the plan's costates do not converge from this start"),
            Self::Dearer { cost, expected } => {
                write!(f, "the extremal costs {cost:.4}, and a neighbour of the plan costs {expected:.4}")
            }
            Self::NoMinimum => f.write_str("the extremal is not a minimum, or has another homotopy class"),
        }
    }
}

/// A time of a plan at which replanning starts. It is the time of a node, or lies between two
/// nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time since the start of the plan \[s\].
    pub time: f64,
    /// Number of steps from this time to the end, at least two.
    pub steps: usize,
    /// Time from this moment to the end of the plan \[s\].
    pub duration: f64,
    /// Index of the last node at or before this time.
    node: usize,
    /// Fraction of the step after that node that has passed at this time, from 0 to 1.
    share: f64,
}

/// The neighbouring extremal of a plan, for another start or another end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Replanned {
    /// Number of Newton steps taken.
    pub newton_steps: usize,
    /// Terminal error of the initial guess, scaled.
    pub guess_error: f64,
    /// Terminal error after the last Newton step, scaled.
    pub residual: f64,
    /// Cost from the start of replanning to the end, in the unit of the plan's cost.
    pub cost: f64,
    /// The first costates `λ_{−1} = [λ^R, λ^Π]`, SI units, for both schemes. `u = −W⁻¹Bᵀλ^Π` is the
    /// input at the start of the new plan.
    pub costates: [f64; 6],
}

/// A plan prepared for replanning from any of its times.
#[derive(Clone, Debug)]
pub struct Replanner {
    problem: Problem,
    bvp: BoundaryValueProblem<'static, 6>,
    nodes: Vec<Beginning>,
    tolerance: f64,
    /// Whether gains correct the costates. They do not if inputs stay at their limits too long for
    /// gains to exist.
    corrects: bool,
    /// Whether the true motion reaches the end, instead of the discrete motion (a landed plan).
    lands: bool,
}

/// The plan from one of its nodes on, in scaled units.
#[derive(Clone, Copy, Debug)]
struct Beginning {
    /// The physical state at the node.
    point: Point,
    /// The costate `λ_{k−1}` at the node.
    costate: Vector6,
    /// The matrix `D_k`, which maps the deviation `z` to the correction of the costate.
    correction: Matrix6,
    /// The cost to go from the node.
    cost: f64,
    /// The first derivative of the cost to go with respect to the physical state.
    slope: Vector6,
    /// The second derivative of the cost to go with respect to the physical state, without the
    /// curvature of a force field.
    curvature: Matrix6,
}

impl Replanner {
    /// Prepares a plan of `problem` for replanning.
    ///
    /// # Errors
    /// [`NotReplanned`] unless the plan is a minimum-effort plan in a given duration, from an
    /// attitude to an attitude and a rate, without limits or with torque limits only.
    pub fn new(problem: &Problem, plan: &Solution) -> Result<Self, NotReplanned> {
        if problem.motion == Motion::RigidBody {
            return Err(NotReplanned::Translation);
        }
        if problem.end_condition != EndCondition::State {
            return Err(NotReplanned::End);
        }
        if Formulation::of(problem) != Formulation::Extremal || problem.seeks_duration() {
            return Err(NotReplanned::Form);
        }
        if let Some(obstacle) = shooting_obstacle(problem) {
            return Err(NotReplanned::Limited(obstacle));
        }
        let problem = plan.on_grid(problem);
        problem.check().map_err(|_| NotReplanned::Trajectory)?;
        let trajectory = &plan.trajectory;
        let rows = problem.steps + 1;
        let complete =
            [trajectory.quaternion.len(), trajectory.angular_velocity.len(), trajectory.time.len()];
        let costates = plan.costates_0(&problem);
        if plan.outcome != Outcome::Converged || complete != [rows; 3] || costates.len() != 6 {
            return Err(NotReplanned::Trajectory);
        }
        let end = trajectory.target.unwrap_or(problem.end);
        let bvp = BoundaryValueProblem::<6>::new(&problem, problem.steps).aimed(&end);
        let mut nodes = Vec::with_capacity(rows);
        let swept = search::first_costate(&problem, &bvp, costates)
            .and_then(|costate| bvp.sweep_into(&costate, &mut nodes).map_err(outcome_of));
        // This form also rejects NaN.
        if !swept.is_ok_and(|end| end.residual() <= OWN) {
            return Err(NotReplanned::Trajectory);
        }
        let linear = LinearPlan::new(&problem, trajectory, Timing::AtNodes).ok();
        let gains = linear.and_then(|linear| {
            let gains = Gains::along(&linear, Kind::Neighbouring { freeze: 0.0 }, false).ok()?;
            Some((linear, gains))
        });
        let tolerance = Settings::default().tolerance;
        let (corrects, lands) = (gains.is_some(), trajectory.target.is_some());
        let mut new = Self { problem, bvp, nodes: Vec::new(), tolerance, corrects, lands };
        let costs = new.costs_to_go(&nodes);
        // Replanning cannot start in the last two steps, because no gains bring the motion to the
        // end.
        for (node, swept) in nodes.iter().enumerate().take(new.problem.steps - Problem::MIN_STEPS + 1) {
            let point = match trajectory.target {
                Some(_) => new.bvp.dynamics.point(&State::attitude(
                    lie::project_to_rotation(&lie::rotation_from_quaternion(&trajectory.quaternion[node])),
                    trajectory.angular_velocity[node],
                )),
                None => swept.physical(),
            };
            let costate = swept.costate.to_vector::<6>();
            let (correction, opened) = match &gains {
                Some((linear, gains)) => (
                    first_costate(linear, &gains.to_go[node], node),
                    kick(&(linear.half_kick(0) * linear.field_gradient(node))),
                ),
                None => (Matrix6::zeros(), Matrix6::identity()),
            };
            let usable = correction.iter().all(|value| value.is_finite());
            let correction = if usable { correction } else { Matrix6::zeros() };
            new.nodes.push(Beginning {
                point,
                costate,
                correction,
                cost: costs[node],
                slope: opened.transpose() * costate,
                curvature: opened.transpose() * correction,
            });
        }
        Ok(new)
    }

    /// Returns the maneuver of the plan, with the plan's grid.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Returns the moment at which a node of the plan is reached.
    ///
    /// # Errors
    /// [`NotReplanned::Time`] if fewer than two steps follow the node.
    pub fn node(&self, node: usize) -> Result<Moment, NotReplanned> {
        let steps = self.problem.steps;
        if node + Problem::MIN_STEPS > steps {
            return Err(self.outside(node as f64 * self.problem.step()));
        }
        let (left, step) = (steps - node, self.problem.step());
        let duration = if node == 0 { self.problem.seconds() } else { left as f64 * step };
        Ok(Moment { time: node as f64 * step, steps: left, duration, node, share: 0.0 })
    }

    /// Returns the moment for a time \[s\]. It is the moment of a node if the time equals the
    /// node's time within round-off.
    ///
    /// # Errors
    /// [`NotReplanned::Time`] if the time is before the plan, or if fewer than two steps follow it.
    pub fn at(&self, time: f64) -> Result<Moment, NotReplanned> {
        let (step, steps) = (self.problem.step(), self.problem.steps);
        let along = time / step;
        let nearest = along.round();
        if (along - nearest).abs() <= AT_NODE && nearest >= 0.0 {
            return self.node(nearest as usize);
        }
        let duration = self.problem.seconds() - time;
        if !(along > 0.0 && along < (steps - Problem::MIN_STEPS) as f64) {
            return Err(self.outside(time));
        }
        let node = along.floor();
        let steps = ((duration / step).round() as usize).max(Problem::MIN_STEPS);
        Ok(Moment { time, steps, duration, node: node as usize, share: along - node })
    }

    fn outside(&self, at: f64) -> NotReplanned {
        let latest = (self.problem.steps - Problem::MIN_STEPS) as f64 * self.problem.step();
        NotReplanned::Time { at, latest }
    }

    /// Returns the planned state at a moment, interpolated between nodes. For a landed plan it is
    /// the state of the true motion.
    pub fn planned(&self, moment: &Moment) -> State {
        let point = self.beginning(moment).point;
        let rate = self.bvp.dynamics.j_inverse * point.momentum.value / self.bvp.dynamics.units.time;
        State::attitude(lie::project_to_rotation(&point.attitude.value), rate)
    }

    /// Returns whether gains correct the costates. No gains exist if inputs stay at their limits
    /// too long; the plan's own costates are then the initial guess.
    pub fn corrects(&self) -> bool {
        self.corrects
    }

    /// Replans from `start` at `moment`, to `end` or, if it is `None`, to the end of the plan. The
    /// second-order conditions are not tested. For a landed plan the target is the state that its
    /// own inputs reach; only [`Replanner::solution`] lands exactly. Each Newton step allocates a
    /// factor of 300 bytes; the memory does not grow with the plan.
    ///
    /// # Errors
    /// [`Left`] if the neighbour of the plan is not found; the maneuver must then be planned anew.
    pub fn replan(&self, start: &State, moment: &Moment, end: Option<&State>) -> Result<Replanned, Left> {
        let dynamics = &self.bvp.dynamics;
        let from = self.beginning(moment);
        let point = dynamics.point(start);
        let z = point.minus(&from.point).to_vector::<6>();
        let own = self.target(moment, &from)?;
        let target = end.map_or(own, |end| self.moved(&own, end));
        let bvp = self.rest(moment, point, TerminalCondition::State(target));
        let guess = from.costate + from.correction * z;
        let Solved { costate, cost, guess_error, residual, newton_steps } =
            solved(&bvp, guess, self.tolerance)?;
        let unit = dynamics.units.cost;
        let cost = cost * unit;
        if end.is_none() && self.corrects {
            let expected = unit * (from.cost + from.slope.dot(&z) + 0.5 * z.dot(&(from.curvature * z)));
            let most = expected + DEARER * expected.abs().max(unit * from.cost);
            if cost.is_nan() || most.is_nan() || cost > most {
                return Err(Left::Dearer { cost, expected });
            }
        }
        let costates = costate.component_mul(&dynamics.units.costate::<6>());
        Ok(Replanned { newton_steps, guess_error, residual, cost, costates: costates.into() })
    }

    /// Returns `problem` restricted to the time from `moment` on: the remaining duration and number
    /// of steps, with the start and the end of `problem`. At time 0 the requested homotopy class is
    /// kept. Later it is left free, because the neighbour keeps the class of the plan.
    pub fn remaining(&self, problem: &Problem, moment: &Moment) -> Problem {
        let path = if moment.time > 0.0 { Path::Best } else { problem.path };
        Problem { path, ..problem.clone().with_duration(moment.duration).with_steps(moment.steps) }
    }

    /// Returns the result as a complete plan: recorded, tested to second order, and landed if
    /// `settings` request it.
    ///
    /// # Errors
    /// [`PlanError`] if start, end or settings are invalid.
    pub fn solution(
        &self,
        remaining: &Problem,
        replanned: &Replanned,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Solution, PlanError> {
        search::warm(remaining, settings, &replanned.costates, MOST_STEPS, observer)
    }

    /// Checks that `problem` equals the maneuver of the plan except for start, end, duration and
    /// number of steps.
    ///
    /// # Errors
    /// [`NotReplanned::Other`], which names the quantity that differs.
    pub fn fits(&self, problem: &Problem) -> Result<(), NotReplanned> {
        let own = &self.problem;
        let (j, other) = (own.body.inertia.j(), problem.body.inertia.j());
        let near = (j - other).amax() <= SAME * j.amax();
        let same = [
            (own.motion == problem.motion, "another kind of motion"),
            (near, "another body"),
            (own.environment.describe() == problem.environment.describe(), "another environment"),
            (own.actuation == problem.actuation, "other actuators or limits"),
            (own.objective == problem.objective, "another objective"),
            (own.scheme == problem.scheme, "another scheme"),
            (problem.end_condition == EndCondition::State, "a given end"),
            (problem.constraints.is_empty(), "no constraints"),
        ];
        same.iter().find(|(same, _)| !same).map_or(Ok(()), |(_, what)| Err(NotReplanned::Other(what)))
    }

    /// Returns the boundary value problem for the rest of the plan from a moment on, in the plan's
    /// units.
    fn rest(
        &self,
        moment: &Moment,
        start: Point,
        terminal: TerminalCondition,
    ) -> BoundaryValueProblem<'static, 6> {
        let duration = moment.duration / self.problem.seconds();
        let grid = Grid::uniform(self.problem.scheme, duration, moment.steps);
        BoundaryValueProblem::of_parts(&self.bvp.dynamics.on_grid(grid), start, terminal)
    }

    /// Returns the target of the discrete motion: the end of the maneuver, or for a landed plan the
    /// state that the inputs of the plan reach.
    fn target(&self, moment: &Moment, from: &Beginning) -> Result<Point, Left> {
        let dynamics = &self.bvp.dynamics;
        if !self.lands {
            return Ok(dynamics.point(&self.problem.end));
        }
        let rest = self.rest(moment, from.point, TerminalCondition::State(from.point));
        let mut reached = from.point;
        let swept = rest.sweep_observed(&from.costate, |node| {
            if node.index == moment.steps {
                reached = node.physical();
            }
        });
        let failed = |error| Left::NotConverged { outcome: outcome_of(error), steps: 0, residual: f64::NAN };
        swept.map(|_| reached).map_err(failed)
    }

    /// Returns the effort to go `Σ κ_j ½ u_jᵀWu_j` from each node, scaled. In each sum the first
    /// node has the weight of the opening kick.
    fn costs_to_go(&self, nodes: &[Node]) -> Vec<f64> {
        let (dynamics, grid) = (&self.bvp.dynamics, &self.bvp.dynamics.grid);
        let begins = grid.kick(0);
        let (mut behind, mut costs) = (0.0, vec![0.0; nodes.len()]);
        for (cost, node) in costs.iter_mut().zip(nodes).rev() {
            let effort = dynamics.kick::<6>(&node.point.pose(), &node.costate).effort;
            *cost = behind + begins * effort;
            behind += grid.kick(node.index) * effort;
        }
        costs
    }

    /// Returns the data of the plan at a moment, interpolated between nodes.
    fn beginning(&self, moment: &Moment) -> Beginning {
        let (a, share) = (&self.nodes[moment.node], moment.share);
        let Some(b) = self.nodes.get(moment.node + 1).filter(|_| share > 0.0) else { return *a };
        let cost = a.cost + share * (b.cost - a.cost);
        Beginning {
            point: between(&a.point, &b.point, share),
            costate: a.costate.lerp(&b.costate, share),
            correction: a.correction + share * (b.correction - a.correction),
            cost,
            slope: a.slope.lerp(&b.slope, share),
            curvature: a.curvature + share * (b.curvature - a.curvature),
        }
    }

    /// Returns the target shifted by the difference between the requested end `end` and the planned
    /// end.
    fn moved(&self, target: &Point, end: &State) -> Point {
        let planned = &self.problem.end;
        let dynamics = &self.bvp.dynamics;
        let turn = target.attitude.value * planned.attitude.transpose() * end.attitude;
        let rate = (end.angular_velocity - planned.angular_velocity) * dynamics.units.time;
        Point {
            attitude: Sum::new(turn),
            momentum: Sum::new(target.momentum.value + dynamics.j * rate),
            ..*target
        }
    }
}

/// A converged extremal, in scaled units.
struct Solved {
    costate: Vector6,
    cost: f64,
    guess_error: f64,
    residual: f64,
    newton_steps: usize,
}

/// Runs Newton's method from a guess inside the basin of convergence. Every step is a full step,
/// and must at least halve the error.
///
/// After the errors `e₀, e₁` the next error is about `e₁ (e₁/e₀)²`. If this nearly meets the
/// tolerance, the next sweep omits the derivatives, which take longer than the sweep itself: the
/// present factorisation suffices for the last step.
fn solved(bvp: &BoundaryValueProblem<6>, guess: Vector6, tolerance: f64) -> Result<Solved, Left> {
    let failed = |outcome, steps, residual| Left::NotConverged { outcome, steps, residual };
    let (mut end, psi) =
        bvp.sweep_linearized(&guess).map_err(|error| failed(outcome_of(error), 0, f64::NAN))?;
    let guess_error = end.residual();
    let (mut costate, mut factor, mut residual, mut next) =
        (guess, Factor::new(&psi), guess_error, f64::INFINITY);
    for newton_steps in 0..=MOST_STEPS {
        if residual <= tolerance {
            return Ok(Solved { costate, cost: end.cost, guess_error, residual, newton_steps });
        }
        if newton_steps == MOST_STEPS {
            break;
        }
        costate -= factor.solve(&end.error);
        let swept = if next <= NEARLY {
            bvp.sweep(&costate)
        } else {
            bvp.sweep_linearized(&costate).map(|(end, psi)| {
                factor = Factor::new(&psi);
                end
            })
        };
        end = swept.map_err(|error| failed(outcome_of(error), newton_steps + 1, f64::NAN))?;
        let ratio = end.residual() / residual;
        residual = end.residual();
        next = residual * ratio * ratio;
        // A NaN ratio counts as no progress in this comparison.
        if !(ratio <= PROGRESS || residual <= tolerance) {
            return Err(failed(Outcome::Stalled, newton_steps + 1, residual));
        }
    }
    Err(failed(Outcome::IterationLimit, MOST_STEPS, residual))
}

/// Interpolates between two states, along the shortest rotation: `a` at `share` = 0, `b` at 1.
fn between(a: &Point, b: &Point, share: f64) -> Point {
    let turn = lie::minus(&b.attitude.value, &a.attitude.value) * share;
    Point {
        attitude: Sum::new(a.attitude.value * lie::exp(&turn)),
        momentum: Sum::new(a.momentum.value.lerp(&b.momentum.value, share)),
        ..*a
    }
}

#[cfg(test)]
mod tests;
