//! Replanning from the present state of the craft: the plan's own extremal, moved to a
//! neighbouring start and solved.
//!
//! ```text
//! guess     λ_{k−1} = λ*_{k−1} + D_k z ,        z = [log(R*_kᵀ R); Π − Π*_k] ,
//!           D_k = (I + G_k Q/2)⁻¹ G_k K₊ ,      G_k = A_kᵀ P_k + H_k
//! solve     λ ← λ − Ψ₁₂⁻¹ e(λ) ,     on the N − k steps that are left
//! ```
//!
//! `D_k` is the neighbouring extremal's ([`Gains`]): from it the end is missed by the square of
//! `z`, so that Newton, whose own error is squared by every step, needs two or three. Another end
//! enters with the first of them: `−Ψ₁₂⁻¹ e` is its linear prediction. All that the plan alone
//! decides is computed once.
//!
//! Between nodes, at `t`, the plan is interpolated, and the remaining time is divided into equal
//! steps whose length is nearest to the length of the plan's steps. The end keeps its time, and
//! each of n steps differs from the plan's by at most 1/2n of it.
//!
//! A plan that lands has a discrete target near its end. Here each moment has its own target,
//! which the plan's inputs reach from the true motion at that time. A start on the plan has the
//! inputs of the plan again, and a moved start lands up to `O(h²)` of `z`.
//!
//! The result is the neighbour of the plan. It does not show whether another homotopy class has
//! become cheaper.

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

/// The number of Newton steps after which a start counts as outside the basin of the plan: inside
/// it three suffice.
const MOST_STEPS: usize = 8;
/// The largest ratio of the errors after and before a step: within the basin a step leaves the
/// square of the error.
const PROGRESS: f64 = 0.5;
/// The error from which a step with the previous derivatives meets any tolerance: these
/// derivatives are accurate to 1e-3.
const NEARLY: f64 = 1e-9;
/// The scaled terminal error up to which recorded costates belong to their plan.
const OWN: f64 = 1e-6;
/// The largest relative excess of the cost of a neighbour over the cost to go of the plan, which
/// is of second order.
const DEARER: f64 = 0.5;
/// The part of a step within which a time counts as the time of a node: the round-off of times in
/// files.
const AT_NODE: f64 = 1e-9;
/// The relative difference of numbers of one body: the round-off of notations.
const SAME: f64 = 1e-9;

/// The reason for which replanning from a plan is impossible.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NotReplanned {
    /// The plan has positions in addition to attitudes.
    #[error("the body translates: replanning supports attitudes alone")]
    Translation,
    /// The inputs of the plan switch, or its duration was free.
    #[error(
        "replanning needs a plan of least effort in a given duration: a plan with switching inputs \
        or a free duration has no neighbour on its grid"
    )]
    Form,
    /// The maneuver has a limit that the method `shooting` cannot hold.
    #[error("its limits have no continuous costates: {0}")]
    Limited(Obstacle),
    /// The maneuver leaves its end attitude to the plan.
    #[error("its end attitude is free: replanning needs a given attitude and rate at the end")]
    End,
    /// The plan has no trajectory with costates, or one that does not lead to the end of the
    /// maneuver.
    #[error("its costates do not lead to its end: it did not converge, or belongs to another maneuver")]
    Trajectory,
    /// The plan belongs to another maneuver.
    #[error("it belongs to a maneuver with {0}")]
    Other(&'static str),
    /// A time before the plan or within its last two steps.
    #[error(
        "at {at} s replanning is impossible, because it needs at least two remaining steps: choose a \
        time from 0 to {latest} s"
    )]
    Time {
        /// The requested time \[s\].
        at: f64,
        /// The latest time \[s\].
        latest: f64,
    },
}

/// The reason for which no neighbour of the plan was found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Left {
    /// Newton did not converge in a few steps.
    NotConverged {
        /// The outcome.
        outcome: Outcome,
        /// The steps that Newton took.
        steps: usize,
        /// The terminal error that it left, scaled; NaN if no sweep reached its end.
        residual: f64,
    },
    /// Newton converged to an extremal that costs more than a neighbour can.
    Dearer {
        /// Cost of the extremal.
        cost: f64,
        /// The expected cost of a neighbour, to second order.
        expected: f64,
    },
    /// The extremal is not a minimum, or has another homotopy class than requested.
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

/// A time of a plan at which replanning starts: a node, or between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time \[s\].
    pub time: f64,
    /// The number of remaining steps, at least two.
    pub steps: usize,
    /// The rest of the duration \[s\].
    pub duration: f64,
    /// The node at or before it.
    node: usize,
    /// The part of the step that has passed since then.
    share: f64,
}

/// A plan's neighbour from another start, or to another end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Replanned {
    /// Newton steps.
    pub newton_steps: usize,
    /// Scaled terminal error of the guess.
    pub guess_error: f64,
    /// The remaining scaled terminal error.
    pub residual: f64,
    /// Cost from that moment to the end, in the unit of the plan's.
    pub cost: f64,
    /// `λ_{−1}`, `[λ^R, λ^Π]`, SI units, for both schemes: `u = −W⁻¹Bᵀλ^Π` is the input at its
    /// start.
    pub costates: [f64; 6],
}

/// A plan, ready to be begun from.
#[derive(Clone, Debug)]
pub struct Replanner {
    problem: Problem,
    bvp: BoundaryValueProblem<'static, 6>,
    nodes: Vec<Beginning>,
    tolerance: f64,
    /// Whether costates are corrected: not where inputs are at their limits too long for gains.
    corrects: bool,
    /// Whether the true motion, and not the discrete one, reaches the end.
    lands: bool,
}

/// The rest of the plan from a node on, scaled.
#[derive(Clone, Copy, Debug)]
struct Beginning {
    /// The physical state.
    point: Point,
    /// `λ_{k−1}`.
    costate: Vector6,
    /// The matrix `D_k`, by which the error `z` corrects the costate.
    correction: Matrix6,
    /// Cost to go, and its derivatives by the physical state but for the curvature of a field.
    cost: f64,
    slope: Vector6,
    curvature: Matrix6,
}

impl Replanner {
    /// Prepares a plan of `problem` to be begun from.
    ///
    /// # Errors
    /// Returns [`NotReplanned`] unless the plan has least effort in a given duration, from an
    /// attitude to an attitude and a rate, with no limits or limits of torques.
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
        // No replanning starts in the last two steps: no gains lead to the end.
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

    /// Returns the maneuver of the plan, on its grid.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Returns the moment of a node.
    ///
    /// # Errors
    /// [`NotReplanned::Time`] where fewer than two steps are left.
    pub fn node(&self, node: usize) -> Result<Moment, NotReplanned> {
        let steps = self.problem.steps;
        if node + Problem::MIN_STEPS > steps {
            return Err(self.outside(node as f64 * self.problem.step()));
        }
        let (left, step) = (steps - node, self.problem.step());
        let duration = if node == 0 { self.problem.seconds() } else { left as f64 * step };
        Ok(Moment { time: node as f64 * step, steps: left, duration, node, share: 0.0 })
    }

    /// Returns the moment of a time \[s\]: a node, if the time equals the time of the node to
    /// round-off.
    ///
    /// # Errors
    /// [`NotReplanned::Time`] before the plan begins, or where fewer than two steps are left.
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

    /// Returns the state of the plan at a moment: of one that lands, of its true motion; between
    /// nodes interpolated.
    pub fn planned(&self, moment: &Moment) -> State {
        let point = self.beginning(moment).point;
        let rate = self.bvp.dynamics.j_inverse * point.momentum.value / self.bvp.dynamics.units.time;
        State::attitude(lie::project_to_rotation(&point.attitude.value), rate)
    }

    /// Returns whether gains correct the costates. If inputs are at their limits for too long, no
    /// gains exist; then the plan's own costates are the guess.
    pub fn corrects(&self) -> bool {
        self.corrects
    }

    /// Replans from `start` at `moment`, to `end` or to the end of the plan. The second order is
    /// not tested. For a plan that lands, the target is reached by its own inputs
    /// ([`Replanner::solution`] lands exactly). A step allocates a factor of 300 bytes; its memory
    /// does not grow with the plan.
    ///
    /// # Errors
    /// [`Left`] if the neighbour of the plan is not found; the maneuver then needs a search.
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

    /// Returns the rest of `problem` at a moment, with its start and its end, in the remaining
    /// time and on the remaining steps. The homotopy class is the plan's; at its start it is the
    /// requested one.
    pub fn remaining(&self, problem: &Problem, moment: &Moment) -> Problem {
        let path = if moment.time > 0.0 { Path::Best } else { problem.path };
        Problem { path, ..problem.clone().with_duration(moment.duration).with_steps(moment.steps) }
    }

    /// Returns the result as a plan like any other: recorded, tested to second order, and landed
    /// if `settings` request it.
    ///
    /// # Errors
    /// [`PlanError`] when start, end or settings cannot be used.
    pub fn solution(
        &self,
        remaining: &Problem,
        replanned: &Replanned,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Solution, PlanError> {
        search::warm(remaining, settings, &replanned.costates, MOST_STEPS, observer)
    }

    /// Checks that `problem` is the maneuver of the plan except for its ends, its duration and its
    /// steps.
    ///
    /// # Errors
    /// [`NotReplanned::Other`] with the quantity that differs.
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

    /// Returns the boundary value problem from a moment on, in the plan's units.
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

    /// Returns the target of the discrete motion: the end, or for a plan that lands the state to
    /// which the inputs of the plan lead.
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

    /// Returns `Σ κ_j ½ u_jᵀWu_j` from each node on, scaled. The first node of each sum has the
    /// weight of a start.
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

    /// Returns the rest of the plan from a moment on.
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

    /// Returns a target moved as the end is.
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

/// An extremal, scaled.
struct Solved {
    costate: Vector6,
    cost: f64,
    guess_error: f64,
    residual: f64,
    newton_steps: usize,
}

/// Runs Newton from a guess in its basin: every step is a full step, and must at least halve the
/// error.
///
/// The next error after `e₀, e₁` is about `e₁ (e₁/e₀)²`. If that nearly meets the tolerance, its
/// sweep omits the derivatives, which take longer: the present factor suffices for the rest.
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
        // The comparison counts NaN as no progress.
        if !(ratio <= PROGRESS || residual <= tolerance) {
            return Err(failed(Outcome::Stalled, newton_steps + 1, residual));
        }
    }
    Err(failed(Outcome::IterationLimit, MOST_STEPS, residual))
}

/// Interpolates between two states, on the shortest rotation.
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
