//! The methods for a plan that switches, side by side: the smoothed law, Newton on switching
//! times, and the interior point.
//!
//! - **smoothed**: the law with the smallest ε that is found, on equal steps, without switching
//!   times;
//! - **switching times**: the method of a plan: arcs at the limits on steps that end where inputs
//!   switch;
//! - **interior_point**: the interior point on equal steps with inputs at the nodes, and with the
//!   duration as an unknown if it is free. It is the method for maneuvers with constraints, and the
//!   method of `method = "scp"`.
//!
//! Each result is a local minimum of its own search. The three methods discretise differently, so
//! durations of one extremal differ by the square of the step.

use serde::Serialize;
use slewkit::maneuver::Shortfall;
use slewkit::maneuver::{Method, Problem, Settings, Target};
use slewkit::optimize::search::{self, Misfit, Observer, PlanError};
use slewkit::plan::{self, Plan, Status};
use std::time::Instant;

/// A plan by one of the methods. Numbers are absent without a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WayRun {
    /// `smoothed`, `switching_times` or `interior_point`.
    pub way: &'static str,
    /// The status; absent if the method does not apply.
    pub status: Option<Status>,
    /// The reason for which it does not apply, or the shortfall.
    pub reason: Option<String>,
    /// Duration \[s\].
    pub duration_s: Option<f64>,
    /// The cost: the duration \[s\], or fuel with the price of time.
    pub cost: Option<f64>,
    /// The possible gain, to first order, of the continuous extremal of the plan.
    pub gap: Option<f64>,
    /// The number of switches of an input.
    pub switches: Option<usize>,
    /// ε of the smoothed law on the grid, scaled.
    pub smoothing: Option<f64>,
    /// The attitude error of the continuous motion under the held torque \[deg\].
    pub continuous_miss_deg: Option<f64>,
    /// Wall time of the solve, without verification \[s\]: differs between two runs.
    pub solve_time_s: f64,
}

/// Plans a maneuver whose inputs switch by each of the methods.
///
/// A time limit applies to each solve. A stop by the observer ends them all.
///
/// # Errors
/// Returns [`PlanError`] if problem or settings cannot be used, or inputs do not switch. A method
/// that does not apply is not an error.
pub fn compare(
    problem: &Problem,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Vec<WayRun>, PlanError> {
    if !problem.switches() {
        return Err(PlanError::Unsuited(Misfit::Ways));
    }
    let began = Instant::now();
    // Ways are compared by the discrete problem.
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

    /// The three methods give one duration up to the square of the step, and a smoothed law takes
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
        // The smoothed law burns more fuel. The fuel of the two others differs by the square of the
        // step.
        assert!(costs[0] > costs[1], "{runs:?}");
        assert!((costs[2] / costs[1] - 1.0).abs() < 2e-3, "{runs:?}");
        let effort = problem(60).with_objective(Objective::default()).with_duration(6.0);
        assert!(compare(&effort, &Settings::discrete(), &mut Silent).is_err());
    }
}
