//! Gaps against closed forms of turns about one axis.

use super::above_zero;
use crate::maneuver::constraint::{Constraint, Rule};
use crate::maneuver::duration::Duration;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::{Method, Settings};
use crate::maneuver::solution::{ContinuousGap, Outcome};
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits};
use crate::mechanics::body::{Body, Inertia};
use crate::optimize::search::{Silent, solve};
use crate::{Matrix3, Vector3, lie};

#[test]
fn the_positive_part_of_a_line_is_integrated_exactly() {
    let summed = |[a, b]: [f64; 2], h: f64| -> f64 {
        let n = 20_000;
        let at = |k: usize| a + (b - a) * (k as f64 + 0.5) / n as f64;
        (0..n).map(|k| at(k).max(0.0) * h / n as f64).sum()
    };
    for ends in [[1.0, 3.0], [-1.0, 2.0], [0.7, -0.2], [-1.0, -2.0], [0.0, 1.0], [-1.0, 0.0]] {
        let exact = above_zero(ends, 0.3);
        assert!((exact - summed(ends, 0.3)).abs() < 1e-8, "{ends:?} {exact}");
    }
    assert!(above_zero([f64::NAN, -1.0], 1.0).is_nan());
}

/// A turn of a sphere of unit moment about z in least time, by torques of 1 N·m.
fn turn(angle: f64, rates: Option<f64>, limits: Limits) -> Problem {
    let body = Body { inertia: Inertia::diagonal(Vector3::repeat(1.0)).unwrap(), mass: None };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let end = State::at_rest(lie::exp(&(Vector3::z() * angle)));
    let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, Duration::SOUGHT);
    let problem = problem.with_actuation(Actuation::torques(torques)).with_objective(Objective::Time);
    match rates {
        Some(rate) => {
            let rule = Rule::RateAxes(Vector3::new(1e-3, 1e-3, rate));
            problem.with_constraint(Constraint { name: "rate".into(), rule })
        }
        None => problem,
    }
}

/// The duration of a plan that lands, and its gap.
fn planned(problem: &Problem, steps: usize) -> (f64, ContinuousGap) {
    let settings = Settings { method: Method::InteriorPoint, ..Settings::default() };
    let found = solve(&problem.clone().with_steps(steps), &settings, None, &mut Silent).unwrap();
    assert_eq!(found.outcome, Outcome::Converged);
    (found.cost, found.interior.unwrap().continuous_gap.expect("a gap"))
}

fn each(size: f64) -> Limits {
    Limits { size: Some(vec![size; 3]), ..Limits::default() }
}

#[test]
fn print_gaps() {
    let angle = 120f64.to_radians();
    for steps in [20, 21, 40, 41, 80] {
        let (cost, gap) = planned(&turn(angle, None, each(1.0)), steps);
        let truth = 2.0 * angle.sqrt();
        let h = truth / steps as f64;
        println!(
            "bang {steps}: excess {:.4e} gap {:.4e} h2/2T {:.4e} {:?}",
            cost - truth,
            gap.gap,
            h * h / (2.0 * truth),
            gap.undetermined
        );
    }
    for steps in [30, 37, 45, 60, 100, 151] {
        let (cost, gap) = planned(&turn(angle, Some(0.5), each(1.0)), steps);
        let truth = angle / 0.5 + 0.5;
        let h = truth / steps as f64;
        println!(
            "rate {steps}: excess {:.4e} gap {:.4e} h2/2Omega {:.4e} {:?}",
            cost - truth,
            gap.gap,
            h * h,
            gap.undetermined
        );
    }
    let limits = Limits { rate: Some(vec![1.0; 3]), ..each(1.0) };
    for steps in [30, 37, 60, 61, 100] {
        let (cost, gap) = planned(&turn(angle, Some(10.0), limits.clone()), steps);
        let full = (angle + 1.0 / 3.0).sqrt() - 1.0;
        let truth = 2.0 * full + 2.0;
        let h = truth / steps as f64;
        println!(
            "ramp {steps}: excess {:.4e} gap {:.4e} h2 {:.4e} {:?}",
            cost - truth,
            gap.gap,
            h * h,
            gap.undetermined
        );
    }
}
