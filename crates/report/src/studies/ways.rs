//! Comparison of three methods for minimum-time and minimum-fuel plans: the smoothed control law,
//! Newton's method on switching times, and the interior-point method.
//!
//! - **smoothed**: the control law with the smallest smoothing ε that converges, on a uniform grid,
//!   without switching times;
//! - **switching times**: the default method: arcs at the limits, with steps that end at the
//!   switching times;
//! - **interior_point**: the interior-point method on a uniform grid, with inputs at the nodes, and
//!   with the duration as an unknown if it is free. Maneuvers with constraints use this method, and
//!   so does `method = "scp"`.
//!
//! Each result is a local minimum that the method found. The three methods discretise differently,
//! so the durations that they find for the same extremal differ by `O(h²)`.

use serde::Serialize;
use slewkit::maneuver::Shortfall;
use slewkit::maneuver::{Method, Problem, Settings, Target};
use slewkit::optimize::search::{self, Misfit, Observer, PlanError};
use slewkit::plan::{self, Plan, Status};
use std::time::Instant;

/// Result of one method. If no plan was found, the numbers are `None`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WayRun {
    /// The name of the method: `smoothed`, `switching_times` or `interior_point`.
    pub way: &'static str,
    /// The status of the plan; `None` if the method does not apply.
    pub status: Option<Status>,
    /// Reason why the method does not apply, or description of what the plan lacks.
    pub reason: Option<String>,
    /// Duration of the plan \[s\].
    pub duration_s: Option<f64>,
    /// Cost of the plan: the duration \[s\], or the fuel plus the time weight times the duration,
    /// if the maneuver has a time weight.
    pub cost: Option<f64>,
    /// Upper bound, to first order, on the saving of a plan near the extremal in continuous time.
    pub gap: Option<f64>,
    /// Number of switches of the inputs in the plan.
    pub switches: Option<usize>,
    /// Scaled smoothing parameter ε of the control law on the grid.
    pub smoothing: Option<f64>,
    /// Terminal attitude error of the continuous motion under the held torques \[deg\].
    pub continuous_miss_deg: Option<f64>,
    /// The elapsed time of the solve, without verification \[s\]. It differs from run to run.
    pub solve_time_s: f64,
}

/// Plans a minimum-time or minimum-fuel maneuver with each of the three methods.
///
/// A time limit applies to each solve. If the observer requests a stop, all solves end.
///
/// # Errors
/// Returns [`PlanError`] if the problem or the settings cannot be used, or if the inputs are not
/// bang-bang. A method that does not apply is not an error.
pub fn compare(
    problem: &Problem,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Vec<WayRun>, PlanError> {
    if !problem.switches() {
        return Err(PlanError::Unsuited(Misfit::Ways));
    }
    let began = Instant::now();
    // The methods are compared on the discrete problem, without landing.
    let settings = &Settings { target: Target::Discrete, ..settings.clone() };
    let smoothed = if problem.shortest_pulse().is_some() {
        Err("a smoothed law has no pulses".to_string())
    } else {
        let smoothed = search::solve_smoothed(problem, settings, observer)?;
        Ok(plan::judged(problem, settings, smoothed, began, observer))
    };
    let arcs = plan::plan(problem, settings, None, observer)?;
    let on_equal_steps = Settings { method: Method::InteriorPoint, ..settings.clone() };
    let interior = plan::plan(problem, &on_equal_steps, None, observer).map_err(|error| error.to_string());
    Ok(vec![
        WayRun::of("smoothed", smoothed),
        WayRun::of("switching_times", Ok(arcs)),
        WayRun::of("interior_point", interior),
    ])
}

impl WayRun {
    fn of(way: &'static str, run: Result<Plan, String>) -> Self {
        let mut row = Self {
            way,
            status: None,
            reason: None,
            duration_s: None,
            cost: None,
            gap: None,
            switches: None,
            smoothing: None,
            continuous_miss_deg: None,
            solve_time_s: 0.0,
        };
        let plan = match run {
            Ok(plan) => plan,
            Err(reason) => return Self { reason: Some(reason), ..row },
        };
        let solution = &plan.solution;
        (row.status, row.solve_time_s) = (Some(plan.status), solution.solve_time);
        row.reason = solution.shortfall.as_ref().map(Shortfall::to_string);
        if plan.status != Status::Solved {
            return row;
        }
        row.duration_s = solution.trajectory.time.last().copied();
        row.cost = Some(solution.cost);
        if let Some(switching) = &solution.switching {
            row.gap = Some(switching.gap);
            row.switches = Some(switching.switches);
            row.smoothing = switching.smoothing;
        }
        let found = plan.verification.as_ref();
        row.continuous_miss_deg = found.map(|found| found.continuous_attitude_rad.to_degrees());
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slewkit::maneuver::{Objective, State};
    use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
    use slewkit::plan::Silent;
    use slewkit::{Vector3, lie};

    fn problem(steps: usize) -> Problem {
        let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 1.4, 1.9)).unwrap(), mass: None };
        let limits = Limits { size: Some(vec![1.0, 0.8, 1.2]), ..Limits::default() };
        let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
        let [start, end] =
            [Vector3::zeros(), Vector3::new(1.2, -0.7, 0.9)].map(|turn| State::at_rest(lie::exp(&turn)));
        Problem::minimum_time(body, start, end).with_actuation(Actuation::torques(torques)).with_steps(steps)
    }

    /// The durations of the three methods agree up to `O(h²)`, and the smoothed control law takes
    /// longer.
    #[test]
    fn the_ways_meet_as_the_grid_is_refined() {
        let spread = |steps: usize| {
            let runs = compare(&problem(steps), &Settings::discrete(), &mut Silent).unwrap();
            assert_eq!(
                runs.iter().map(|run| run.way).collect::<Vec<_>>(),
                ["smoothed", "switching_times", "interior_point"]
            );
            let durations: Vec<f64> = runs.iter().map(|run| run.duration_s.expect("a plan")).collect();
            assert!(runs[0].smoothing.is_some() && runs[1].smoothing.is_none(), "{runs:?}");
            assert!(runs[1].gap.is_some() && runs[2].gap.is_none(), "{runs:?}");
            [durations[0] / durations[1] - 1.0, durations[2] / durations[1] - 1.0]
        };
        let [coarse, fine] = [40, 80].map(spread);
        assert!(fine[0] > 0.0 && fine[0] < 0.02, "{coarse:?} {fine:?}");
        assert!(fine[1].abs() < 2e-3 && fine[1].abs() < 0.6 * coarse[1].abs(), "{coarse:?} {fine:?}");
    }

    #[test]
    fn fuel_has_the_same_ways_and_what_does_not_switch_has_none() {
        let fuel = problem(60).with_objective(Objective::Fuel(Default::default())).with_duration(6.0);
        let runs = compare(&fuel, &Settings::discrete(), &mut Silent).unwrap();
        let costs: Vec<f64> = runs.iter().map(|run| run.cost.expect("a plan")).collect();
        // The smoothed law needs more fuel. The fuel of the other two methods differs by `O(h²)`.
        assert!(costs[0] > costs[1], "{runs:?}");
        assert!((costs[2] / costs[1] - 1.0).abs() < 2e-3, "{runs:?}");
        let effort = problem(60).with_objective(Objective::default()).with_duration(6.0);
        assert!(compare(&effort, &Settings::discrete(), &mut Silent).is_err());
    }
}
