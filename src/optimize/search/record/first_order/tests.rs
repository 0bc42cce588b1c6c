//! Tests of gaps against closed forms for turns about one axis.

use super::above_zero;
use crate::maneuver::constraint::{Constraint, Rule};
use crate::maneuver::duration::Duration;
use crate::maneuver::objective::{Fuel, Objective};
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

/// Returns a turn of a sphere with unit moment of inertia about z, by three torques.
fn turn(angle: f64, rule: Rule, limits: Limits) -> Problem {
    let body = Body { inertia: Inertia::diagonal(Vector3::repeat(1.0)).unwrap(), mass: None };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let end = State::at_rest(lie::exp(&(Vector3::z() * angle)));
    let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, Duration::SOUGHT);
    let problem = problem.with_actuation(Actuation::torques(torques)).with_objective(Objective::Time);
    problem.with_constraint(Constraint { name: "rate".into(), rule })
}

/// Returns limits on the angular rate: `fastest` about z, and very small limits about the other
/// axes.
fn about_z(fastest: f64) -> Rule {
    Rule::RateAxes(Vector3::new(1e-3, 1e-3, fastest))
}

fn each(size: f64) -> Limits {
    Limits { size: Some(vec![size; 3]), ..Limits::default() }
}

/// Returns the cost and the gap of the plan of a problem, after landing.
fn planned(problem: &Problem, steps: usize) -> (f64, ContinuousGap) {
    let settings = Settings { method: Method::InteriorPoint, ..Settings::default() };
    let found = solve(&problem.clone().with_steps(steps), &settings, None, &mut Silent).unwrap();
    assert_eq!(found.outcome, Outcome::Converged);
    (found.cost, found.interior.unwrap().continuous_gap.expect("a gap"))
}

/// Claim: the gap is the cost of holding the torque over steps. On the two steps about the switch
/// the torque is half of its limit; with an odd number of steps it is zero on the middle one. The
/// remaining motion lacks a rotation by h²/2 or h²/4, at dT/dθ = 2/T.
#[test]
fn the_gap_is_what_torques_that_are_held_over_steps_cost() {
    let angle = 20f64.to_radians();
    let truth = 2.0 * angle.sqrt();
    for steps in [20_u32, 21, 40, 41, 80] {
        let (cost, found) = planned(&turn(angle, about_z(10.0), each(1.0)), steps as usize);
        let h = truth / f64::from(steps);
        let excess = h * h / truth / f64::from(1 + steps % 2);
        let apart = 4.0 / f64::from(steps).powi(2);
        assert!((found.gap / excess - 1.0).abs() < apart, "{steps}: {} {excess}", found.gap);
        assert!(((cost - truth) / excess - 1.0).abs() < apart, "{steps}: {} {excess}", cost - truth);
    }
}

/// Claim: with full torque until the rate limit is reached, within a step at the fraction v, the
/// gap is `h²/(4 Ω)` at either end for any v, and the excess is `(1/8 + v (1 − v)/2) h²/Ω`.
#[test]
fn the_gap_of_a_plan_along_a_limit_of_the_rate_is_the_closed_form_and_above_its_excess() {
    let (angle, fastest) = (20f64.to_radians(), 0.2);
    let truth = angle / fastest + fastest;
    let ball = Limits { norm: Some(1.0), ..Limits::default() };
    let each = turn(angle, about_z(fastest), each(1.0));
    for problem in [turn(angle, Rule::RateNorm(fastest), ball), each] {
        for steps in [30_u32, 37, 45, 60] {
            let (cost, found) = planned(&problem, steps as usize);
            let h = truth / f64::from(steps);
            let (closed, v) = (h * h / (2.0 * fastest), (fastest / h + 0.5).fract());
            let excess = (0.5 + 2.0 * v * (1.0 - v)) * closed;
            assert!((found.gap / closed - 1.0).abs() < 0.03, "{steps}: {} {closed}", found.gap);
            assert!(((cost - truth) / excess - 1.0).abs() < 0.03, "{steps}: {} {excess}", cost - truth);
            // The error terms of the next order are smaller by a factor of about h.
            assert!(
                cost - truth < (1.0 + 1.0 / f64::from(steps)) * found.gap,
                "{steps}: {} {}",
                cost - truth,
                found.gap
            );
            let inputs: Vec<usize> = found.undetermined.iter().map(|stretch| stretch.input).collect();
            assert_eq!(inputs, [0, 1], "the torque about z keeps the rate, the others have no need");
        }
    }
}

/// Claim: with zero torque after the rate Ω = θ/(T − Ω) is reached, the gap is `h²/4` at either
/// end, times the rate of the switching function dF/dθ = 2/(T − 2Ω).
#[test]
fn the_gap_of_least_fuel_is_the_closed_form_and_above_its_excess() {
    let (angle, duration) = (20f64.to_radians(), 2.0);
    let coast = 0.5 * (duration - (duration * duration - 4.0 * angle).sqrt());
    let problem = turn(angle, about_z(10.0), each(1.0)).with_objective(Objective::Fuel(Fuel::default()));
    for steps in [30_u32, 37, 45, 60] {
        let (cost, found) = planned(&problem.clone().with_duration(duration), steps as usize);
        let h = duration / f64::from(steps);
        let closed = h * h / (duration - 2.0 * coast);
        assert!((found.gap / closed - 1.0).abs() < 0.05, "{steps}: {} {closed}", found.gap);
        let excess = cost - 2.0 * coast;
        assert!(excess > 0.45 * closed && excess < 1.02 * found.gap, "{steps}: {excess} {}", found.gap);
    }
}

/// The torque is full, then changes from +U to −U at the rate limit j in the time 2U/j, then is
/// full again (`tests/it/maneuvers/shortest.rs`).
#[test]
fn the_gap_of_ramps_is_about_what_they_cost_to_be_held() {
    let angle = 120f64.to_radians();
    let ramps = Limits { rate: Some(vec![1.0; 3]), ..each(1.0) };
    let truth = 2.0 * (angle + 1.0 / 3.0).sqrt();
    for steps in [30_u32, 37, 60, 100] {
        let (cost, found) = planned(&turn(angle, about_z(10.0), ramps.clone()), steps as usize);
        let squared = (truth / f64::from(steps)).powi(2);
        let [excess, gap] = [cost - truth, found.gap].map(|above| above / squared);
        assert!(excess < 1.15 * gap && gap < 0.3, "{steps}: {excess} {gap}");
    }
}

/// Forces that are not saturated, because the displacement takes less time than the turn.
#[test]
fn inputs_that_have_more_than_they_need_are_told() {
    let alone = turn(1.0, about_z(10.0), each(1.0));
    let body = Body { mass: Some(1.0), ..alone.body.clone() };
    let force = ActuatorSet::three_axes(AxisFrame::Body).with_limits(each(1.0)).unwrap();
    let end = State { position: Vector3::new(0.2, 0.1, 0.1), ..alone.end };
    let flight = Problem::rigid_body(body, alone.start, end, Duration::SOUGHT);
    let torque = turn(1.0, about_z(10.0), each(1.0)).actuation.torque;
    let flight = flight.with_actuation(Actuation::torques_and_forces(torque, force));
    let (_, found) = planned(&flight.with_objective(Objective::Time), 40);
    for force in 0..3 {
        let own = found.undetermined.iter().filter(|stretch| stretch.input == force);
        let free: f64 = own.map(|stretch| stretch.end_s - stretch.start_s).sum();
        assert!(free > 1.0, "force {force}: {found:?}");
    }
}
