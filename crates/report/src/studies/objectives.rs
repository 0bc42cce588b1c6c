//! Comparison of the minimum-effort, minimum-fuel and minimum-time plans of one maneuver.
//!
//! Every plan is evaluated by all three measures,
//!
//! ```text
//! effort  ∫ ½ uᵀWu dt ,    fuel  ∫ Σ c_j |u_j| dt ,    time  T
//! ```
//!
//! so that the comparison shows the value of each objective for each plan. With a norm limit on the
//! torque, fuel is `c ∫ |τ| dt`. The weights W and the prices c are those of the objective of the
//! maneuver; if it has none, they are 1. The minimum-effort and minimum-fuel plans have the
//! duration of the maneuver or, if it has a time weight (`time_price_per_s`), their optimal
//! duration. If the maneuver minimises time, their duration is [`STRETCH`] times the minimum time.

use serde::Serialize;
use slewkit::maneuver::Shortfall;
use slewkit::maneuver::objective::{Fuel, Objective, effort};
use slewkit::maneuver::{Duration, Problem, Settings, Trajectory, Weights};
use slewkit::numerics::figures::rounded_up;
use slewkit::optimize::search::{Observer, PlanError};
use slewkit::plan::{self, Plan, Status};

/// Ratio of the duration of the minimum-effort and minimum-fuel plans to the minimum time, if the
/// maneuver minimises time.
pub const STRETCH: f64 = 1.5;

/// Result for one objective. If no plan was found, the numbers are `None`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectiveRun {
    /// Objective of the plan: `time`, `fuel` or `effort`.
    pub minimises: &'static str,
    /// The status of the plan; `None` if the problem cannot be planned with this objective.
    pub status: Option<Status>,
    /// Reason why no plan exists, or description of what the plan lacks.
    pub reason: Option<String>,
    /// Duration of the plan \[s\].
    pub duration_s: Option<f64>,
    /// The effort `∫ ½ uᵀWu dt` of the inputs u \[N²·m²·s, times the unit of the weights W\].
    pub effort: Option<f64>,
    /// The fuel `∫ Σ c_j |u_j| dt` of the inputs or, under a norm limit, `c ∫ |τ| dt` \[N·m·s,
    /// times the unit of the prices c\].
    pub fuel: Option<f64>,
    /// The number of input switches of a bang-bang plan.
    pub switches: Option<usize>,
    /// Upper bound, to first order, on the saving of a plan near this bang-bang plan, in seconds or
    /// in units of fuel.
    pub gap: Option<f64>,
    /// The elapsed time of the solve, without verification \[s\]. It differs from run to run.
    pub solve_time_s: f64,
    /// Motion of the plan; `None` if no plan was found. Files do not contain it.
    #[serde(skip)]
    pub trajectory: Option<Trajectory>,
}

/// Plans `problem` for minimum time, minimum fuel and minimum effort.
///
/// The comparison uses the weights and prices of the problem's objective. A time limit applies to
/// each of the three solves. If the observer requests a stop, all solves end.
///
/// # Errors
/// Returns [`PlanError`] if `problem` cannot be planned with any of the three objectives. If only
/// some of them fail, their results state the reason.
pub fn compare(
    problem: &Problem,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Vec<ObjectiveRun>, PlanError> {
    let measures = Measures::of(problem);
    let mut runs = Vec::new();
    let found = |plan: &Plan| plan.solution.trajectory.time.last().copied();
    let mut duration = problem.duration.known();
    if problem.objective != Objective::Time
        && problem.seeks_duration()
        && let Ok(chosen) = plan::plan(problem, settings, None, observer)
        && chosen.status == Status::Solved
    {
        duration = found(&chosen);
    }
    let objectives = [
        Objective::Time,
        Objective::Fuel(measures.fuel.clone()),
        Objective::Effort(measures.weights.clone()),
    ];
    let mut refusal = None;
    for objective in objectives {
        let (sought, name) = (objective == Objective::Time, objective.name());
        let in_time = if sought { Some(Duration::SOUGHT) } else { duration.map(Duration::Given) };
        let run = match in_time {
            None => Err("the spec has no duration, and none was found".to_string()),
            Some(in_time) => {
                let of_this = problem.clone().with_duration(in_time).with_objective(objective);
                plan::plan(&of_this, settings, None, observer).map_err(|error| {
                    let reason = error.to_string();
                    refusal = Some(error);
                    reason
                })
            }
        };
        if let Ok(plan) = &run
            && problem.objective == Objective::Time
            && sought
            && plan.status == Status::Solved
        {
            duration = found(plan).map(|found| rounded_up(STRETCH * found));
        }
        runs.push(measures.row(name, run));
    }
    match refusal {
        Some(refusal) if runs.iter().all(|run| run.status.is_none()) => Err(refusal),
        _ => Ok(runs),
    }
}

/// Weights and prices with which the effort, fuel and time of a plan are evaluated.
struct Measures<'a> {
    problem: &'a Problem,
    weights: Weights,
    fuel: Fuel,
}

impl<'a> Measures<'a> {
    fn of(problem: &'a Problem) -> Self {
        let weights = Weights { time_price: None, ..problem.objective.weights().clone() };
        let fuel = problem.objective.fuel().cloned().unwrap_or_default();
        Self { problem, weights, fuel: Fuel { time_price: None, ..fuel } }
    }

    fn row(&self, minimises: &'static str, run: Result<Plan, String>) -> ObjectiveRun {
        let mut row = ObjectiveRun {
            minimises,
            status: None,
            reason: None,
            duration_s: None,
            effort: None,
            fuel: None,
            switches: None,
            gap: None,
            solve_time_s: 0.0,
            trajectory: None,
        };
        let plan = match run {
            Ok(plan) => plan,
            Err(reason) => return ObjectiveRun { reason: Some(reason), ..row },
        };
        let solution = &plan.solution;
        (row.status, row.solve_time_s) = (Some(plan.status), solution.solve_time);
        row.reason = solution.shortfall.as_ref().map(Shortfall::to_string);
        if plan.status != Status::Solved {
            return row;
        }
        let trajectory = &solution.trajectory;
        row.duration_s = trajectory.time.last().copied();
        row.effort = Some(match minimises {
            "effort" => solution.cost,
            _ => integral(trajectory, |inputs| self.effort(inputs)),
        });
        row.fuel = Some(integral(trajectory, |inputs| self.fuel.rate(&self.problem.actuation, inputs)));
        row.switches = solution.switching.as_ref().map(|switching| switching.switches);
        row.gap = solution.switching.as_ref().map(|switching| switching.gap);
        row.trajectory = Some(trajectory.clone());
        row
    }

    /// Returns the effort rate `½ uᵀWu` for a row of inputs, forces before torques.
    fn effort(&self, inputs: &[f64]) -> f64 {
        let actuation = &self.problem.actuation;
        let torque = self.weights.torque(actuation);
        let (forces, torques) = actuation.split_costs(inputs);
        let force = self.weights.force(actuation).filter(|_| !forces.is_empty());
        effort(&torque.weight, torques) + force.map_or(0.0, |force| effort(&force.weight, forces))
    }
}

/// Integrates a function of the inputs over the motion, with weights that depend on how the inputs
/// act. An input that is held over a step has the duration of the step as its weight. A kick at a
/// node has the mean duration of both neighbouring steps, and half a step at both ends of the
/// motion.
fn integral(trajectory: &Trajectory, rate: impl Fn(&[f64]) -> f64) -> f64 {
    let time = &trajectory.time;
    let steps = time.len().saturating_sub(1);
    let rows = trajectory.torque.len();
    let length = |step: usize| time[step + 1] - time[step];
    let weight = |row: usize| match row {
        row if rows == steps => length(row),
        0 => 0.5 * length(0),
        row if row == steps => 0.5 * length(steps - 1),
        row => 0.5 * (length(row - 1) + length(row)),
    };
    // The sum of an empty iterator is −0; adding 0 turns it into 0.
    0.0 + (0..rows).map(|row| weight(row) * rate(trajectory.inputs(row))).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slewkit::maneuver::{Scheme, State};
    use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
    use slewkit::plan::Silent;
    use slewkit::{Matrix3, Vector3, lie};

    fn slew(duration: impl Into<Duration>) -> Problem {
        let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 3.0)).unwrap(), mass: None };
        let end = State::at_rest(lie::exp(&Vector3::new(0.9, -0.4, 0.6)));
        let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
        let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
        Problem::attitude(body, State::at_rest(Matrix3::identity()), end, duration)
            .with_actuation(Actuation::torques(torques))
            .with_steps(100)
    }

    #[test]
    fn each_plan_is_the_best_by_its_own_measure() {
        let runs = compare(&slew(5.0), &Settings::discrete(), &mut Silent).unwrap();
        let [time, fuel, effort] = runs.as_slice() else { panic!("{runs:?}") };
        assert_eq!([time, fuel, effort].map(|run| run.minimises), ["time", "fuel", "effort"]);
        assert!(runs.iter().all(|run| run.status == Some(Status::Solved)), "{runs:?}");
        assert!(time.duration_s < fuel.duration_s, "{runs:?}");
        assert!([fuel, effort].iter().all(|run| (run.duration_s.unwrap() - 5.0).abs() < 1e-13), "{runs:?}");
        assert!(fuel.fuel < effort.fuel && fuel.fuel < time.fuel, "{runs:?}");
        assert!(effort.effort < fuel.effort && effort.effort < time.effort, "{runs:?}");
        assert!(fuel.gap.unwrap() < 1e-4 * fuel.fuel.unwrap() && effort.switches.is_none());
    }

    #[test]
    fn the_measures_are_the_costs_of_the_plans() {
        for scheme in [Scheme::LieVerlet, Scheme::LieEuler] {
            let problem = slew(5.0).with_scheme(scheme);
            let plan = plan::plan(&problem, &Settings::discrete(), None, &mut Silent).unwrap();
            let weight = problem.objective.weights().torque(&problem.actuation).weight;
            let sum = integral(&plan.solution.trajectory, |inputs| effort(&weight, inputs));
            assert!((sum / plan.solution.cost - 1.0).abs() < 1e-13, "{scheme:?} {sum}");
        }
        let objective = Objective::Fuel(Fuel { prices: Some(vec![1.0, 2.0, 0.5]), ..Fuel::default() });
        let problem = slew(5.0).with_objective(objective);
        let plan = plan::plan(&problem, &Settings::discrete(), None, &mut Silent).unwrap();
        let runs = compare(&problem, &Settings::discrete(), &mut Silent).unwrap();
        assert!((runs[1].fuel.unwrap() / plan.solution.cost - 1.0).abs() < 1e-12, "{runs:?}");
    }

    #[test]
    fn a_price_of_time_chooses_the_duration_of_all() {
        let objective = Objective::Effort(Weights { time_price: Some(0.1), ..Weights::default() });
        let priced = slew(Duration::SOUGHT).with_objective(objective);
        let chosen = plan::plan(&priced, &Settings::discrete(), None, &mut Silent).unwrap().solution;
        let runs = compare(&priced, &Settings::discrete(), &mut Silent).unwrap();
        let duration = *chosen.trajectory.time.last().unwrap();
        for run in &runs[1..] {
            assert!((run.duration_s.unwrap() / duration - 1.0).abs() < 1e-13, "{run:?} {duration}");
        }
        let effort = chosen.cost - 0.1 * duration;
        assert!((runs[2].effort.unwrap() / effort - 1.0).abs() < 1e-9, "{runs:?} {effort}");
    }

    #[test]
    fn without_a_duration_the_others_have_more_than_the_shortest() {
        let problem = slew(Duration::SOUGHT).with_objective(Objective::Time);
        let runs = compare(&problem, &Settings::discrete(), &mut Silent).unwrap();
        let [shortest, given] = [0, 2].map(|row: usize| runs[row].duration_s.unwrap());
        assert!(given >= STRETCH * shortest && given < 1.05 * STRETCH * shortest, "{runs:?}");
        // Without torque limits, only minimum effort can be planned.
        let unlimited =
            slew(5.0).with_actuation(Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body)));
        let runs = compare(&unlimited, &Settings::discrete(), &mut Silent).unwrap();
        assert_eq!(runs.iter().filter(|run| run.status.is_none() && run.reason.is_some()).count(), 2);
        assert_eq!(runs[2].status, Some(Status::Solved));
        let wrong = Settings { tolerance: f64::NAN, ..Settings::discrete() };
        assert!(compare(&slew(5.0), &wrong, &mut Silent).is_err());
    }
}
