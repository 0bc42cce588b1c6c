//! Comparison of methods on one discrete problem.
//!
//! Three methods solve the same discrete conditions independently:
//!
//! - **shooting**: Newton's method on the costates, with forward and backward sweeps of the
//!   extremal;
//! - **scp**: sequential convex programming until it converges on the requested grid. The duals of
//!   its last subproblem serve as costates. Newton's method is not used;
//! - **scp + polish**: SCP as a plan uses it, with a final solve by the interior-point method.
//!
//! The duals are costates: the multipliers of the linearised dynamics converge to the costates `λ`.
//! Shooting can therefore start from `λ_0` of SCP. [`Agreement`] measures the difference between
//! duals and costates.
//!
//! A maneuver has several extremals, and the methods search differently. If they find different
//! extremals, the methods with a costlier extremal, or without one, start again from the cheapest
//! extremal, so that all results belong to the same extremal. [`MethodRun::by_itself`] has the
//! result that a method found by itself.
//!
//! # What does `slew compare` compare?
//!
//! One discrete problem is solved by shooting, by the convex iteration alone until its own
//! convergence, and by the convex iteration with the final interior-point solve. The comparison has
//! costs, terminal errors and residuals; duals and costates; the active nodes; and the number of
//! Newton steps that shooting needs from the duals. If one method finds a cheaper plan, the others
//! start from its path, so that one extremal is compared (`studies/methods`).
//!
//! `--objectives` compares the minimum-time, minimum-fuel and minimum-effort plans of one maneuver,
//! each evaluated by all three objectives (`studies/objectives`). The same comparison runs without
//! the option if methods cannot be compared, because the inputs are bang-bang or the duration is
//! free. For bang-bang inputs, a comparison of three methods comes first (`studies/ways`): the
//! smoothed control law on the grid, switching times, and the interior-point method.

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

/// A method of solution that the comparison includes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Contender {
    /// Newton shooting on the costates. Input limits enter through the saturated control law.
    Shooting,
    /// Sequential convex programming until it converges, without a final interior-point solve.
    Scp,
    /// Sequential convex programming with a final interior-point solve.
    ScpPolish,
}

/// Outcome of the run of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// SCP converged according to its own criterion; its terminal error has not been checked.
    Converged,
    /// The method does not support problems of this kind.
    DoesNotApply,
    /// The method ended with this status: of a plan that the witnesses judged, or of a search
    /// without a plan.
    #[serde(untagged)]
    Ended(Status),
}

/// Times of the nodes at which a limit or constraint is active.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ActiveNodes {
    /// The name of the limit or constraint.
    pub name: String,
    /// The times at which the limit or constraint is active, without repetition \[s\].
    pub time_s: Vec<f64>,
}

/// Result of a method before it was started again from the plan of another method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ByItself {
    /// Outcome of the method in its independent run.
    pub status: Standing,
    /// Cost of this result; `None` if its motion does not reach the target.
    pub cost: Option<f64>,
}

/// Result of one method, or the reason why it has none. If the method has no trajectory, the
/// numbers are `None`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodRun {
    /// Method to which the result belongs.
    pub method: Contender,
    /// Outcome of the run.
    pub status: Standing,
    /// Result that the method found independently; `None` unless the other fields belong to a
    /// second run, which started from the path of a cheaper plan.
    pub by_itself: Option<ByItself>,
    /// The reason why the method does not apply, or why no input can meet the terminal conditions.
    pub reason: Option<String>,
    /// The cost of the discrete problem.
    pub cost: Option<f64>,
    /// Terminal error of the discrete motion that results from the inputs.
    pub terminal: Option<TerminalError>,
    /// Largest scaled residual of the KKT conditions.
    pub stationarity: Option<f64>,
    /// Number of conjugate points; `None` if they were not counted.
    pub conjugate_points: Option<usize>,
    /// Direction of rotation to the end attitude: the short or the long way.
    pub sense: Option<Sense>,
    /// The total angle along the path \[deg\].
    pub turned_deg: Option<f64>,
    /// Number of convex subproblems, on all grids, from the initial guess that led to the result.
    pub subproblems: Option<usize>,
    /// Number of Newton iterations, on all grids, from the initial guess that led to the result.
    pub newton_iterations: usize,
    /// Limits and constraints that are active, with the times of their nodes.
    pub active: Vec<ActiveNodes>,
    /// Costates at the start in SI units: `λ_0` for Lie–Euler and `λ_{−1}` for Lie–Verlet. They can
    /// serve as an initial guess for a plan.
    pub costates_0: Vec<f64>,
    /// The elapsed time of the solve, without verification \[s\]. It differs from run to run.
    pub solve_time_s: f64,
    /// Motion of the result; `None` if it does not reach the target. Files do not contain it.
    #[serde(skip)]
    pub trajectory: Option<Trajectory>,
}

/// The results of all methods on one problem.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The results of the methods, in the order of [`Contender`].
    pub methods: Vec<MethodRun>,
    /// Agreement between the results of the methods.
    pub agreement: Agreement,
}

/// Solves `problem` with every method that applies, and compares the results.
///
/// The comparison ignores the method in `settings`. The time limit applies to each solve
/// separately. If the observer requests a stop, all solves end.
///
/// # Errors
/// Returns [`PlanError`] if `problem` or `settings` cannot be used. A method that does not apply,
/// or does not converge, is not an error.
pub fn compare(
    problem: &Problem,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Comparison, PlanError> {
    if problem.objective.switches() || problem.seeks_duration() {
        return Err(PlanError::Unsuited(Misfit::Methods));
    }
    // The methods are compared on the discrete problem, which all of them solve.
    let settings = &Settings { target: Target::Discrete, ..settings.clone() };
    // If the body must point at a target at the end, all methods use the end state of one plan.
    let aimed = match problem.aim() {
        None => None,
        Some(_) => {
            let found = search::solve(problem, settings, None, observer)?;
            let completed = found.trajectory.completed(problem);
            Some(Problem { end_condition: EndCondition::State, ..completed })
        }
    };
    let problem = aimed.as_ref().unwrap_or(problem);
    // If sets of constraints are alternatives, all methods use the sets and times that one plan has
    // selected.
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

    // All methods are compared on the same extremal: the cheapest extremal that was found.
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

/// Result of a method, and its independent result if it was started again from the plan of another
/// method.
struct Answer {
    plan: Plan,
    by_itself: Option<Plan>,
}

/// Creates a plan from a solution, without verification by the witnesses.
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

    /// Replaces the result by the result of a second run, if the second run converged to the
    /// extremal `shown`.
    fn again(&mut self, problem: &Problem, plan: Plan, shown: &Solution) {
        let second = Self::first(plan);
        if second.is(problem, shown) {
            self.by_itself = Some(std::mem::replace(&mut self.plan, second.plan));
        }
    }
}

impl Comparison {
    /// Returns the status of the comparison. It is `Solved` if at least one method solved the
    /// problem and all methods that solved it agree, and `VerificationFailed` if they disagree.
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

    /// Returns the result of the method `method`; `None` if it was not run.
    pub fn run(&self, method: Contender) -> Option<&MethodRun> {
        self.methods.iter().find(|run| run.method == method)
    }
}

/// Returns the outcome of a solve whose result the witnesses do not judge.
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
        // A convex run that fails has subproblems, but no Newton iterations.
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
