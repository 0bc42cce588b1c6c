//! The methods side by side on one discrete problem.
//!
//! Three methods solve the same discrete conditions independently:
//!
//! - **shooting**: Newton on the costates, forward and backward sweeps of the extremal;
//! - **scp**: sequential convex programming, to its own convergence on the requested grid. The
//!   duals of its last subproblem serve as costates; its result does not use Newton's method;
//! - **scp + polish**: SCP as a plan uses it, with a final solve by the interior point.
//!
//! Duals are costates: the multipliers of the linearised dynamics converge to `λ`, so `λ_0` of
//! the second method starts the first. [`Agreement`] measures the difference.
//!
//! A maneuver has several extremals, and the methods search differently. If they find different
//! extremals, the methods with a costlier extremal, or without one, start again from the cheapest,
//! so that one extremal is compared; [`MethodRun::by_itself`] has their own results.
//!
//! # What does `slew compare` compare?
//!
//! One discrete problem is solved by the shooting, by the convex iteration alone to its own
//! convergence, and by the convex iteration with the polish. The comparison has costs, terminal
//! errors and residuals; duals and costates; the active nodes; and the number of Newton steps
//! that the shooting needs from the duals. If one method finds a cheaper answer, the others start
//! from its path, so that one extremal is compared (`studies/methods`).
//!
//! `--objectives` compares the plans of least time, fuel and effort of one maneuver, each
//! measured by all three (`studies/objectives`). So does a maneuver for which methods cannot be
//! compared, because inputs switch or the duration is free. If inputs switch, three methods for
//! the plan come first (`studies/ways`): the smoothed law on the grid, switching times, and the
//! convex iteration.

mod agreement;
#[cfg(feature = "sdp")]
mod global;
#[cfg(test)]
mod tests;

pub use agreement::{Agreement, FromDuals, Verdict};
#[cfg(feature = "sdp")]
pub use global::{BOUND_STEPS, Global, GlobalError, global};

use serde::Serialize;
use slewkit::maneuver::Shortfall;
use slewkit::maneuver::{
    EndCondition, Method, Outcome, Problem, Proof, Sense, Settings, Solution, Target, TerminalError,
    Trajectory,
};
use slewkit::optimize::search::{self, Guess, Misfit, Observer, PlanError};
use slewkit::plan::{self, Plan, Status};
use std::time::Instant;

/// A method of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Contender {
    /// Newton shooting on the costates; limits of the inputs through the saturated control law.
    Shooting,
    /// Sequential convex programming to its own convergence, without polish.
    Scp,
    /// Sequential convex programming, ended by the interior point.
    ScpPolish,
}

/// The end of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// The convex iteration converged by its own criterion; its terminal error is not checked.
    Converged,
    /// The method cannot take such a problem.
    DoesNotApply,
    /// The end of a plan, judged by the witnesses, or of a search without an answer.
    #[serde(untagged)]
    Ended(Status),
}

/// The nodes at which a limit or constraint is active.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ActiveNodes {
    /// The name of the limit or constraint.
    pub name: String,
    /// Times at which it is active, each once \[s\].
    pub time_s: Vec<f64>,
}

/// The result of a method before it started from another's answer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ByItself {
    /// The outcome of the method.
    pub status: Standing,
    /// Cost of the result, where it reached the end.
    pub cost: Option<f64>,
}

/// The answer of one method, or the reason for its absence. Numbers are absent without a
/// trajectory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodRun {
    /// The method.
    pub method: Contender,
    /// The outcome.
    pub status: Standing,
    /// The method's own result, if the rest belongs to a second run along the path of a cheaper
    /// answer.
    pub by_itself: Option<ByItself>,
    /// The reason for which it does not apply, or for which no input can meet the terminal
    /// conditions.
    pub reason: Option<String>,
    /// Discrete cost.
    pub cost: Option<f64>,
    /// Discrete terminal error of the inputs, replayed from the start.
    pub terminal: Option<TerminalError>,
    /// Largest residual of the conditions of Karush, Kuhn and Tucker, scaled.
    pub stationarity: Option<f64>,
    /// The number of conjugate points, if they are counted.
    pub conjugate_points: Option<usize>,
    /// Rotation sense of the path.
    pub sense: Option<Sense>,
    /// Total angle turned \[deg\].
    pub turned_deg: Option<f64>,
    /// Convex subproblems of the winning start, on all its grids.
    pub subproblems: Option<usize>,
    /// Newton iterations of the winning start, on all its grids.
    pub newton_iterations: usize,
    /// The active limits and constraints, and their nodes.
    pub active: Vec<ActiveNodes>,
    /// `λ_0` for Lie–Euler, `λ_{−1}` for Lie–Verlet, SI; a guess for a plan.
    pub costates_0: Vec<f64>,
    /// Wall time of the solve, without verification \[s\]: differs between two runs.
    pub solve_time_s: f64,
    /// The motion, if the method reached the end; it is not written to files.
    #[serde(skip)]
    pub trajectory: Option<Trajectory>,
}

/// The methods side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Every method, in the order of [`Contender`].
    pub methods: Vec<MethodRun>,
    /// The agreement of the answers.
    pub agreement: Agreement,
}

/// Solves `problem` by every method that applies and sets the answers side by side.
///
/// The comparison ignores the method in `settings`, and applies the time limit to each solve. A
/// stop by the observer ends them all.
///
/// # Errors
/// Returns [`PlanError`] if problem or settings cannot be used. A method that does not apply, or
/// stops, is not an error.
pub fn compare(
    problem: &Problem,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Comparison, PlanError> {
    if problem.objective.switches() || problem.seeks_duration() {
        return Err(PlanError::Unsuited(Misfit::Methods));
    }
    // Methods are compared by what both of them solve: the discrete problem.
    let settings = &Settings { target: Target::Discrete, ..settings.clone() };
    // All methods use the end on a target that one plan has found.
    let aimed = match problem.aim() {
        None => None,
        Some(_) => {
            let found = search::solve(problem, settings, None, observer)?;
            let completed = found.trajectory.completed(problem);
            Some(Problem { end_condition: EndCondition::State, ..completed })
        }
    };
    let problem = aimed.as_ref().unwrap_or(problem);
    // All methods use the shifts of one plan for sets that alternate.
    let in_turns = if problem.alternatives.is_empty() {
        None
    } else {
        Some(search::solve(problem, settings, None, observer)?.on_grid(problem))
    };
    let problem = in_turns.as_ref().unwrap_or(problem);
    let shooting_settings = Settings { method: Method::Shooting, ..settings.clone() };
    let mut shooting = match plan::plan(problem, &shooting_settings, None, observer) {
        Err(PlanError::NotForShooting { reason }) => Err(reason),
        found => Ok(Answer::first(found?)),
    };
    let convex = |polish: bool, along: Option<&Trajectory>, observer: &mut dyn Observer| {
        let began = Instant::now();
        let solution = search::solve_convex(problem, settings, polish, along, observer)?;
        Ok::<Plan, PlanError>(if polish {
            plan::judged(problem, settings, solution, began, observer)
        } else {
            bare(solution)
        })
    };
    let mut polished = Answer::first(convex(true, None, observer)?);
    let mut unpolished = Answer::first(convex(false, None, observer)?);

    // One extremal for all: the cheapest that a plan would return.
    if let Ok(shot) = &mut shooting
        && polished.converged()
        && (!shot.converged() || agreement::cheaper(problem, polished.solution(), shot.solution()))
    {
        let guess = Guess::costates(polished.solution().costates_0(problem));
        let again = plan::plan(problem, &shooting_settings, Some(&guess), observer)?;
        shot.again(problem, again, polished.solution());
    }
    let best = match &shooting {
        Ok(shot) if shot.converged() => shot.solution().clone(),
        _ => polished.solution().clone(),
    };
    if best.outcome == Outcome::Converged {
        for (polish, answer) in [(true, &mut polished), (false, &mut unpolished)] {
            if !answer.is(problem, &best) {
                let again = convex(polish, Some(&best.trajectory), observer)?;
                answer.again(problem, again, &best);
            }
        }
    }

    let agreement = agreement::of(
        problem,
        &shooting_settings,
        shooting.as_ref().ok().map(Answer::solution),
        unpolished.solution(),
        polished.solution(),
        observer,
    )?;
    let shot = match &shooting {
        Ok(answer) => {
            MethodRun::of(Contender::Shooting, problem, answer, Standing::Ended(answer.plan.status))
        }
        Err(reason) => MethodRun::refused(Contender::Shooting, &reason.to_string()),
    };
    let methods = vec![
        shot,
        MethodRun::of(Contender::Scp, problem, &unpolished, unjudged(unpolished.solution())),
        MethodRun::of(Contender::ScpPolish, problem, &polished, Standing::Ended(polished.plan.status)),
    ];
    Ok(Comparison { methods, agreement })
}

/// The result of a method, and its own result before it started from another's answer.
struct Answer {
    plan: Plan,
    by_itself: Option<Plan>,
}

/// Returns a solution that no witness has judged.
fn bare(solution: Solution) -> Plan {
    Plan::new(solution, None, Status::NotConverged)
}

impl Answer {
    fn first(plan: Plan) -> Self {
        Self { plan, by_itself: None }
    }

    fn solution(&self) -> &Solution {
        &self.plan.solution
    }

    fn converged(&self) -> bool {
        self.solution().outcome == Outcome::Converged
    }

    fn is(&self, problem: &Problem, other: &Solution) -> bool {
        self.converged() && agreement::same_extremal(problem, self.solution(), other)
    }

    /// Replaces the run by a second run, if this converged to the given extremal.
    fn again(&mut self, problem: &Problem, plan: Plan, shown: &Solution) {
        let second = Self::first(plan);
        if second.is(problem, shown) {
            self.by_itself = Some(std::mem::replace(&mut self.plan, second.plan));
        }
    }
}

impl Comparison {
    /// Returns the result of the comparison as a status: `Solved` if a method solved and those
    /// that did agree; `VerificationFailed` if they do not agree.
    pub fn status(&self) -> Status {
        let ended = |status: &Status| {
            let disagree = self.agreement.verdict == Verdict::Disagree;
            self.methods.iter().any(|run| run.status == Standing::Ended(*status))
                || (*status == Status::VerificationFailed && disagree)
        };
        let order = [
            Status::Interrupted,
            Status::VerificationFailed,
            Status::Solved,
            Status::Infeasible,
            Status::LimitReached,
        ];
        order.into_iter().find(ended).unwrap_or(Status::NotConverged)
    }

    /// Returns the run of a method.
    pub fn run(&self, method: Contender) -> Option<&MethodRun> {
        self.methods.iter().find(|run| run.method == method)
    }
}

/// Returns the outcome of a solve that no witness judges.
fn unjudged(solution: &Solution) -> Standing {
    match solution.outcome {
        Outcome::Converged => Standing::Converged,
        Outcome::Infeasible => Standing::Ended(Status::Infeasible),
        Outcome::TimeLimit => Standing::Ended(Status::LimitReached),
        Outcome::Interrupted => Standing::Ended(Status::Interrupted),
        _ => Standing::Ended(Status::NotConverged),
    }
}

impl MethodRun {
    fn refused(method: Contender, reason: &str) -> Self {
        Self {
            method,
            status: Standing::DoesNotApply,
            by_itself: None,
            reason: Some(reason.into()),
            cost: None,
            terminal: None,
            stationarity: None,
            conjugate_points: None,
            sense: None,
            turned_deg: None,
            subproblems: None,
            newton_iterations: 0,
            active: Vec::new(),
            costates_0: Vec::new(),
            solve_time_s: 0.0,
            trajectory: None,
        }
    }

    fn of(method: Contender, problem: &Problem, answer: &Answer, status: Standing) -> Self {
        let solution = answer.solution();
        let by_itself = answer.by_itself.as_ref().map(|plan| ByItself {
            status: match method {
                Contender::Scp => unjudged(&plan.solution),
                _ => Standing::Ended(plan.status),
            },
            cost: plan.solution.cost.is_finite().then_some(plan.solution.cost),
        });
        let reached = solution.cost.is_finite();
        // A convex run that fails has only subproblems to count.
        let subproblems = match solution.method {
            Method::Scp | Method::InteriorPoint => {
                Some(solution.convex.map_or(solution.iterations, |work| work.subproblems))
            }
            Method::Auto | Method::Shooting => None,
        };
        let converged = solution.outcome == Outcome::Converged;
        let active = solution.active.iter().map(|active| {
            let mut time_s = active.time_s.clone();
            time_s.dedup();
            ActiveNodes { name: active.name.clone(), time_s }
        });
        Self {
            method,
            status,
            by_itself,
            reason: (solution.infeasible.as_ref().map(Proof::to_string))
                .or_else(|| solution.shortfall.as_ref().map(Shortfall::to_string)),
            cost: reached.then_some(solution.cost),
            terminal: reached.then_some(solution.terminal),
            stationarity: converged.then_some(solution.optimality.stationarity),
            conjugate_points: solution.optimality.conjugate_points,
            sense: reached.then_some(solution.sense),
            turned_deg: reached.then_some(solution.turned_deg),
            subproblems,
            newton_iterations: solution.iterations - subproblems.unwrap_or(0),
            active: active.collect(),
            costates_0: solution.costates_0(problem).to_vec(),
            solve_time_s: solution.solve_time,
            trajectory: reached.then(|| solution.trajectory.clone()),
        }
    }
}
