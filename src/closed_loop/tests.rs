//! Compares the simulated loop with its linear model, with closed forms, and with itself.

use super::draws::stream;
use super::*;
use crate::feedback::Gains;
use crate::feedback::Kind;
use crate::maneuver::{Problem, State};
use crate::mechanics::actuators::{Actuation, Wheels};
use crate::mechanics::body::{Body, Inertia};
use crate::numerics::random::Stream;
use crate::optimize::discrete::linear_plan::ticks::of_ticks;
use crate::optimize::discrete::linear_plan::{LinearPlan, Matrix6, Parameter};
use crate::testing::planned;
use crate::uncertainty::Covariance;
use crate::uncertainty::Uncertainty;

fn maneuver(steps: usize) -> Problem {
    let j = Matrix3::new(2.2, -0.3, 0.2, -0.3, 1.6, -0.25, 0.2, -0.25, 1.1);
    let body = Body { inertia: Inertia::new(j).unwrap(), mass: None };
    let state = |turn: Vector3, rate: Vector3| {
        crate::maneuver::State::attitude(crate::lie::Rotation::exp(&turn), rate)
    };
    let start = state(Vector3::zeros(), Vector3::new(0.3, 0.4, -0.5));
    let end = state(Vector3::new(1.2, 0.9, -0.4), Vector3::new(0.1, -0.2, 0.3));
    Problem::attitude(body, start, end, 6.0).with_steps(steps)
}

fn unit(axis: usize) -> Vector3 {
    Vector3::from_fn(|row, _| f64::from(u8::from(row == axis)))
}

/// Returns one uncertain parameter of each kind about each axis.
fn parameters(sigma: f64) -> Vec<(String, Parameter, f64)> {
    let mut all = Vec::new();
    for axis in 0..3 {
        let mut delta = Matrix3::zeros();
        delta[(axis, axis)] = 1.0;
        let mut product = Matrix3::zeros();
        product[(axis, (axis + 1) % 3)] = 1.0;
        product[((axis + 1) % 3, axis)] = 1.0;
        all.extend([
            Parameter::Inertia(delta),
            Parameter::Inertia(product),
            Parameter::InputScale(axis),
            Parameter::ActuatorTurn(unit(axis)),
            Parameter::ConstantTorque(unit(axis)),
            Parameter::SensorTurn(unit(axis)),
            Parameter::RateScale(axis),
            Parameter::RateBias(unit(axis)),
        ]);
    }
    all.into_iter().enumerate().map(|(index, parameter)| (index.to_string(), parameter, sigma)).collect()
}

#[test]
fn without_errors_the_plan_is_flown_to_its_end() {
    let problem = maneuver(60);
    let plan = planned(&problem);
    let linear = LinearPlan::flown(&problem, &plan).unwrap();
    let gains = Gains::along(&linear, Kind::Tvlqr(None), false).unwrap();
    let nothing = Uncertainty::default();
    for gains in [None, Some(&gains)] {
        let campaign = Campaign::new(&problem, &linear, gains, &nothing, Plant::default(), 1);
        let flown = campaign.fly(0).unwrap();
        assert!(flown.end.amax() < 1e-12, "{}", flown.end);
        assert_eq!(flown.saturated, 0.0);
    }
}

/// Returns the inertia of a craft with these parameter values.
fn inertia(problem: &Problem, parameters: &[(String, Parameter, f64)], values: &[f64]) -> Inertia {
    let mut j = *problem.body.inertia.j();
    for (value, (_, parameter, _)) in values.iter().zip(parameters) {
        if let Parameter::Inertia(delta) = parameter {
            j += delta * *value;
        }
    }
    Inertia::new(j).unwrap()
}

/// Returns the terminal error `[ζ; δΩ]` of a craft with these parameter values, without noise,
/// whose start deviates by `beside`.
fn end_of(campaign: &Campaign<'_>, values: &[f64], beside: &Vector6) -> Vector6 {
    let streams = [stream::SENSORS, stream::TORQUE].map(|of| Stream::new(1, 0, of));
    let inertia = inertia(campaign.problem, &campaign.uncertainty.parameters, values);
    campaign.run(values, inertia, beside, streams, |_| ()).unwrap().end
}

/// Returns the largest relative difference between the simulated loop and the linear model in the
/// derivatives by the parameters.
fn derivatives_apart(problem: &Problem, closed: bool) -> f64 {
    let linear = LinearPlan::flown(problem, &planned(problem)).unwrap();
    let gains = Gains::along(&linear, Kind::Tvlqr(None), false).unwrap();
    let gains = closed.then_some(&gains);
    let uncertainty = Uncertainty { parameters: parameters(1.0), ..Uncertainty::default() };
    let expected = Covariance::along(&linear, gains, &uncertainty).end_by_parameter;
    let campaign = Campaign::new(problem, &linear, gains, &uncertainty, Plant::default(), 1);
    let end = |index: usize, size: f64| {
        let mut values = vec![0.0; expected.len()];
        values[index] = size;
        end_of(&campaign, &values, &Vector6::zeros())
    };
    let size = 1e-5;
    let largest = expected.iter().map(|column| column.amax()).fold(0.0, f64::max);
    let apart = |index: usize| {
        let found = (end(index, size) - end(index, -size)) / (2.0 * size);
        (found - expected[index]).amax() / largest
    };
    (0..expected.len()).map(apart).fold(0.0, f64::max)
}

fn falls_fourfold_with_half_the_step(problem: impl Fn(usize) -> Problem) {
    for closed in [false, true] {
        let (coarse, fine) =
            (derivatives_apart(&problem(60), closed), derivatives_apart(&problem(120), closed));
        let order = (coarse / fine).log2();
        assert!((1.6..2.6).contains(&order) && fine < 2e-3, "{closed}: {coarse:e} {fine:e}");
    }
}

/// The simulated loop and the linear model have equal derivatives by every parameter, to the order
/// of the scheme.
#[test]
fn the_loop_has_the_derivatives_of_the_linear_model() {
    falls_fourfold_with_half_the_step(maneuver);
}

/// Tests the loop with wheels, whose momenta are states as large as the momentum of the body.
#[test]
fn the_loop_of_wheels_has_the_derivatives_of_the_linear_model() {
    falls_fourfold_with_half_the_step(|steps| {
        let axes = [(0.8, 0.0), (0.0, 0.8), (-0.8, 0.0), (0.0, -0.8)];
        let axes = axes.map(|(x, y)| Vector3::new(x, y, 0.6)).to_vec();
        with_wheels(maneuver(steps), axes)
    });
}

/// Returns the maneuver with wheels about these axes, some of which store momentum.
fn with_wheels(problem: Problem, axes: Vec<Vector3>) -> Problem {
    let count = axes.len();
    let momentum = [0.3, -0.2, 0.4, 0.1][..count].to_vec();
    let wheels = Wheels { momentum, momentum_limit: vec![100.0; count] };
    problem.with_actuation(Actuation::of_wheels(axes, vec![10.0; count], wheels).unwrap())
}

fn everything() -> Uncertainty {
    let diagonal = |attitude: f64, rate: f64| {
        Matrix6::from_diagonal(
            &Vector6::new(attitude, attitude, attitude, rate, rate, rate).map(|sigma| sigma * sigma),
        )
    };
    Uncertainty {
        start: diagonal(1e-2, 1e-3),
        parameters: parameters(3e-3),
        torque_noise: Matrix3::identity() * 1e-7,
        sensor_noise: diagonal(1e-4, 5e-5),
    }
}

/// Every standard deviation of 4,000 cases is within five standard errors (1.1 %) of the linear
/// one.
#[test]
fn sampled_covariances_are_the_linear_ones() {
    let problem = maneuver(100);
    let plan = planned(&problem);
    let linear = LinearPlan::flown(&problem, &plan).unwrap();
    let regulator = Gains::along(&linear, Kind::Tvlqr(None), false).unwrap();
    let neighbouring = Gains::along(&linear, Kind::Neighbouring { freeze: Kind::FREEZE }, false).unwrap();
    let uncertainty = everything();
    for gains in [None, Some(&regulator), Some(&neighbouring)] {
        let covariance = Covariance::along(&linear, gains, &uncertainty);
        let campaign = Campaign::new(&problem, &linear, gains, &uncertainty, Plant::default(), 5);
        let ends: Vec<Vector6> =
            campaign.fly_all(0, 4000).into_iter().map(|flown| flown.unwrap().end).collect();
        let sampled = Sampled::of(&ends, &covariance.end);
        let ratios = sampled.sigma().component_div(&covariance.end_sigma());
        assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.056), "{ratios}");
        let [least, largest] = sampled.eigenvalues.unwrap();
        assert!(least > 0.85 && largest < 1.2, "{least} {largest}");
        assert!(sampled.inside.part() > 0.99, "{:?}", sampled.inside);
    }
}

/// No motion leaves the ellipsoids if every error is at its bound and small enough to be linear. A
/// single error source reaches the boundary of its own ellipsoid.
#[test]
fn bounded_errors_stay_within_their_ellipsoid() {
    use crate::uncertainty::Bounded;
    let problem = maneuver(60);
    let plan = planned(&problem);
    let linear = LinearPlan::flown(&problem, &plan).unwrap();
    let gains = Gains::along(&linear, Kind::Tvlqr(None), false).unwrap();
    let small = 1e-5;
    let start = Matrix6::identity() * (small * small);
    let uncertainty = Uncertainty { start, parameters: parameters(small), ..Uncertainty::default() };
    let alone = Uncertainty { start, ..Uncertainty::default() };
    for gains in [None, Some(&gains)] {
        let bounded = Bounded::along(&linear, gains, &uncertainty);
        let inverse = bounded.end.try_inverse().unwrap();
        let campaign = Campaign::new(&problem, &linear, gains, &uncertainty, Plant::default(), 1);
        let mut random = crate::testing::Random(11);
        let mut largest: f64 = 0.0;
        for _ in 0..300 {
            let values: Vec<f64> =
                uncertainty.parameters.iter().map(|_| small * random.uniform().signum()).collect();
            let beside = Vector6::from_fn(|_, _| random.uniform()).normalize() * small;
            let end = end_of(&campaign, &values, &beside);
            largest = largest.max(end.dot(&(inverse * end)));
        }
        assert!(largest <= 1.0 && largest > 0.02, "{largest}");
        let one = Bounded::along(&linear, gains, &alone);
        let covariance = Covariance::along(&linear, gains, &alone);
        assert!((one.end - covariance.end).amax() <= 1e-12 * covariance.end.amax());
    }
}

#[test]
fn a_case_is_the_same_alone_and_among_others() {
    let problem = maneuver(40);
    let plan = planned(&problem);
    let linear = LinearPlan::flown(&problem, &plan).unwrap();
    let gains = Gains::along(&linear, Kind::Tvlqr(None), false).unwrap();
    let uncertainty = everything();
    let plant = Plant { lag: 0.1, delay: 0.2, quantum: 1e-4, tick: 0.05, leads: true, authority: 1.0 };
    let campaign = Campaign::new(&problem, &linear, Some(&gains), &uncertainty, plant, 9);
    let all = campaign.fly_all(10, 40);
    let alone = campaign.fly(27).unwrap();
    assert_eq!(all[17].as_ref().unwrap(), &alone);
    let (flown, moments) = campaign.traced(27).unwrap();
    assert_eq!(flown, alone);
    assert_eq!(moments.len(), 41);
    assert_eq!(moments[40].beside, alone.end);
    let others = Campaign::new(&problem, &linear, Some(&gains), &uncertainty, plant, 10).fly(27).unwrap();
    assert_ne!(others, alone);
}

/// Compensating a known lag and delay reduces their effect to a fraction, also in open loop.
#[test]
fn commands_that_lead_a_lag_and_a_delay_keep_the_end() {
    let problem = maneuver(60);
    let plan = planned(&problem);
    let linear = LinearPlan::flown(&problem, &plan).unwrap();
    let gains = Gains::along(&linear, Kind::Tvlqr(None), false).unwrap();
    let nothing = Uncertainty::default();
    let missed = |plant: Plant, closed: bool| {
        let gains = closed.then_some(&gains);
        Campaign::new(&problem, &linear, gains, &nothing, plant, 1).fly(0).unwrap().end.amax()
    };
    for (plant, part) in [
        (Plant { lag: 0.2, ..Plant::default() }, 1e-3),
        (Plant { lag: 0.02, tick: 0.01, ..Plant::default() }, 0.05),
        (Plant { lag: 0.2, tick: 0.01, ..Plant::default() }, 0.05),
        (Plant { delay: 0.1, ..Plant::default() }, 1e-3),
        (Plant { delay: 0.03, ..Plant::default() }, 0.05),
        (Plant { delay: 0.25, tick: 0.05, ..Plant::default() }, 0.05),
        // The first command acts for a part of a step, and so has fewer ticks than a step.
        (Plant { lag: 0.02, delay: 0.03, tick: 0.01, ..Plant::default() }, 0.5),
    ] {
        let (late, led) = (missed(plant, false), missed(Plant { leads: true, ..plant }, false));
        assert!(led < part * late, "{plant:?}: {late:e}, led {led:e}");
        let (late, led) = (missed(plant, true), missed(Plant { leads: true, ..plant }, true));
        assert!(led < 2.0 * part * late + 1e-4, "{plant:?}: {late:e}, led {led:e}");
    }
    // The feedback corrects a quantum of a thousandth of the torque to less than its effect in open
    // loop.
    assert!(missed(Plant { quantum: 1e-3, ..Plant::default() }, true) < 1e-3);
}

#[test]
fn a_plate_whose_inertias_are_drawn_again_says_how_often() {
    let mut problem = maneuver(20);
    problem.body.inertia = Inertia::diagonal(Vector3::new(1.0, 2.0, 3.0)).unwrap();
    let plan = planned(&problem);
    let linear = LinearPlan::flown(&problem, &plan).unwrap();
    let moments = (0..3).map(|axis| {
        let mut delta = Matrix3::zeros();
        delta[(axis, axis)] = 1.0;
        (format!("J{axis}"), Parameter::Inertia(delta), 0.02)
    });
    let uncertainty = Uncertainty { parameters: moments.collect(), ..Uncertainty::default() };
    let campaign = Campaign::new(&problem, &linear, None, &uncertainty, Plant::default(), 3);
    let rejected: u32 = campaign.fly_all(0, 500).into_iter().map(|flown| flown.unwrap().rejected).sum();
    // Half of the draws are impossible, so each case needs one more draw on average.
    assert!((400..620).contains(&rejected), "{rejected}");
}

/// If a plan uses all of its limits, gains have no effect within them. If it keeps a tenth in
/// reserve, the gains bring the body to the end.
#[test]
fn authority_held_back_flies_a_plan_of_least_time() {
    use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits};
    let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 1.2, 0.8)).unwrap(), mass: None };
    let end = State::at_rest(crate::lie::Rotation::exp(&Vector3::new(0.4, -0.8, 1.2)));
    let limits = Limits { size: Some(vec![0.1; 3]), ..Limits::default() };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let problem = Problem::minimum_time(body, State::at_rest(Matrix3::identity()), end)
        .with_actuation(Actuation::torques(torques));
    let plan = planned(&problem);
    let problem = problem.with_steps(plan.time.len() - 1);
    let linear = LinearPlan::flown(&problem, &plan).unwrap();
    let gains = Gains::along(&linear, Kind::Tvlqr(None), true).unwrap();
    let start = Matrix6::identity() * 1e-6;
    let uncertainty = Uncertainty { start, ..Uncertainty::default() };
    let missed = |gains: Option<&Gains>, authority: f64| {
        let plant = Plant { authority, ..Plant::default() };
        let campaign = Campaign::new(&problem, &linear, gains, &uncertainty, plant, 1);
        let ends = campaign.fly_all(0, 50);
        ends.into_iter().map(|flown| flown.unwrap().end.norm()).sum::<f64>() / 50.0
    };
    let (open, cut, held) = (missed(None, 1.0), missed(Some(&gains), 1.0), missed(Some(&gains), 1.15));
    assert!(held < 0.02 * open && held < 0.2 * cut, "{open:e} {cut:e} {held:e}");
}

/// Compares the standard deviations of rates, commands and changes of commands between steps with
/// the linear ones at some nodes. The statistical error of 4,000 cases is 1.1 %. Wheels are
/// included; their gains use the stored momentum.
#[test]
fn sampled_rates_and_commands_have_the_linear_deviations() {
    let uncertainty = everything();
    let neighbouring = Kind::Neighbouring { freeze: Kind::FREEZE };
    let of_wheels = with_wheels(maneuver(100), (0..3).map(unit).collect());
    for (problem, kind, every) in [
        (maneuver(100), Kind::Tvlqr(None), 1),
        (maneuver(100), Kind::Tvlqr(None), 4),
        (of_wheels.clone(), neighbouring, 1),
        (of_wheels, neighbouring, 4),
    ] {
        let plan = planned(&problem);
        let linear = LinearPlan::flown(&problem, &plan).unwrap();
        let gains = Gains::along(&of_ticks(&linear, every), kind, false).unwrap();
        assert_eq!(gains.states, if linear.has_wheels() { 9 } else { 6 });
        let gains = gains.held_over(every, linear.count());
        let covariance = Covariance::along(&linear, Some(&gains), &uncertainty);
        let campaign = Campaign::new(&problem, &linear, Some(&gains), &uncertainty, Plant::default(), 7);
        let nodes = [1, 10, 46, 47, 51, 95, 99];
        let told = |_: Flown, moments: Vec<Moment>| {
            nodes.map(|k| {
                let [now, before] = [k, k - 1].map(|k| moments[k].commanded.clone());
                let less =
                    |k: usize, command: &[f64]| Vector3::from_fn(|i, _| command[i] - linear.inputs(k)[i]);
                let (now, before) = (less(k, &now), less(k - 1, &before));
                [moments[k].beside.fixed_rows::<3>(3).into_owned(), now, now - before]
            })
        };
        let cases: Vec<_> = campaign.trace_all(0, 4000, told).into_iter().map(Result::unwrap).collect();
        let sampled = |node: usize, what: usize| {
            let values = || cases.iter().map(|case| case[node][what]);
            let mean = values().sum::<Vector3>() / 4000.0;
            let squares = values().map(|value| (value - mean).component_mul(&(value - mean)));
            (squares.sum::<Vector3>() / 3999.0).map(f64::sqrt)
        };
        for (node, k) in nodes.into_iter().enumerate() {
            let rates = covariance.rates[k].diagonal().map(f64::sqrt);
            let [inputs, changes] = [&covariance.inputs[k], &covariance.input_changes[k - 1]]
                .map(|sigmas| Vector3::from_column_slice(sigmas));
            let torque = covariance.torque[k].diagonal().map(f64::sqrt);
            assert!((torque - inputs).amax() < 1e-12 * inputs.amax(), "{torque} {inputs}");
            for (what, linear) in [rates, inputs, changes].into_iter().enumerate() {
                let found = sampled(node, what);
                if k % every != 0 && what == 2 {
                    assert!(linear.amax() == 0.0 && found.amax() < 1e-12, "held {found}");
                    continue;
                }
                let ratios = found.component_div(&linear);
                assert!(
                    ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.06),
                    "{every} {k} {what}: {ratios}"
                );
            }
        }
        let ends: Vec<Vector6> =
            campaign.fly_all(0, 4000).into_iter().map(|flown| flown.unwrap().end).collect();
        let ratios = Sampled::of(&ends, &covariance.end).sigma().component_div(&covariance.end_sigma());
        assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.06), "{every}: {ratios}");
    }
}

/// A loop that measures every fourth step and holds its correction has the derivatives of the
/// linear model.
#[test]
fn the_loop_of_a_slower_controller_has_the_derivatives_of_the_linear_model() {
    let neighbouring = Kind::Neighbouring { freeze: Kind::FREEZE };
    let apart = |steps: usize, of_wheels: bool| {
        let (problem, kind) = if of_wheels {
            (with_wheels(maneuver(steps), (0..3).map(unit).collect()), neighbouring)
        } else {
            (maneuver(steps), Kind::Tvlqr(None))
        };
        let linear = LinearPlan::flown(&problem, &planned(&problem)).unwrap();
        let gains = Gains::along(&of_ticks(&linear, steps / 15), kind, false).unwrap();
        let gains = gains.held_over(steps / 15, steps);
        let uncertainty = Uncertainty { parameters: parameters(1.0), ..Uncertainty::default() };
        let expected = Covariance::along(&linear, Some(&gains), &uncertainty).end_by_parameter;
        let campaign = Campaign::new(&problem, &linear, Some(&gains), &uncertainty, Plant::default(), 1);
        let end = |index: usize, size: f64| {
            let mut values = vec![0.0; expected.len()];
            values[index] = size;
            end_of(&campaign, &values, &Vector6::zeros())
        };
        let largest = expected.iter().map(|column| column.amax()).fold(0.0, f64::max);
        let of = |index: usize| {
            let found = (end(index, 1e-5) - end(index, -1e-5)) / 2e-5;
            (found - expected[index]).amax() / largest
        };
        (0..expected.len()).map(of).fold(0.0, f64::max)
    };
    for of_wheels in [false, true] {
        let (coarse, fine) = (apart(60, of_wheels), apart(120, of_wheels));
        assert!((1.6..2.6).contains(&(coarse / fine).log2()) && fine < 2e-3, "{coarse:e} {fine:e}");
    }
}

/// About a principal axis the motion near a slew is a double integrator. The deviations of
/// attitude, rate and torque follow a recursion of two numbers. It includes the initial error, a
/// constant torque, sensor noise, and a correction that is held over a tick.
#[test]
fn deviations_about_a_principal_axis_are_those_of_a_double_integrator() {
    use nalgebra::{Matrix2, RowVector2, Vector2};
    let (j, steps, duration) = (2.0, 120, 60.0);
    let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 1.5, j)).unwrap(), mass: None };
    let end = State::at_rest(crate::lie::Rotation::exp(&Vector3::new(0.0, 0.0, 1.0)));
    let problem =
        Problem::attitude(body, State::at_rest(Matrix3::identity()), end, duration).with_steps(steps);
    let linear = LinearPlan::flown(&problem, &planned(&problem)).unwrap();
    let (start, sensor, torque) = ([1e-2, 3e-4], [2e-4, 1e-5], 1e-4);
    let diagonal = |of: [f64; 2]| {
        let [attitude, rate] = of.map(|sigma| sigma * sigma);
        Matrix6::from_diagonal(&Vector6::new(0.0, 0.0, attitude, 0.0, 0.0, rate))
    };
    let uncertainty = Uncertainty {
        start: diagonal(start),
        parameters: vec![("torque".into(), Parameter::ConstantTorque(unit(2)), torque)],
        sensor_noise: diagonal(sensor),
        ..Uncertainty::default()
    };
    for every in [1, 5] {
        let gains = Gains::along(&of_ticks(&linear, every), Kind::Tvlqr(None), false).unwrap();
        let gains = gains.held_over(every, steps);
        let found = Covariance::along(&linear, Some(&gains), &uncertainty);
        let h = duration / steps as f64;
        let a = Matrix2::new(1.0, h, 0.0, 1.0);
        let b = Vector2::new(h * h / 2.0, h) / j;
        let square = |of: [f64; 2]| Matrix2::new(of[0] * of[0], 0.0, 0.0, of[1] * of[1]);
        // The state and the held correction form one vector. These variables are its joint
        // covariance and its response to a constant torque.
        let (mut p, mut s) = (square(start), Vector2::zeros());
        let (mut held, mut with_held, mut s_held) = (0.0, Vector2::zeros(), 0.0);
        for k in 0..steps {
            let row = &gains.row(k)[12..18];
            let gain = RowVector2::new(row[2], row[5] * j);
            if k % every == 0 {
                held = (gain * (p + square(sensor)) * gain.transpose())[0];
                with_held = p * gain.transpose();
                s_held = (gain * s)[0];
            }
            let sigma = (held + (s_held * torque).powi(2)).sqrt();
            assert!((found.inputs[k][2] / sigma - 1.0).abs() < 1e-3, "{every} {k}: {sigma:e}");
            p = a * p * a.transpose()
                - a * with_held * b.transpose()
                - b * with_held.transpose() * a.transpose()
                + b * held * b.transpose();
            with_held = a * with_held - b * held;
            s = a * s - b * s_held + b;
            let rate = (p[(1, 1)] + (s[1] * torque).powi(2)).sqrt();
            assert!((found.rates[k + 1][(2, 2)].sqrt() / rate - 1.0).abs() < 1e-3, "{every} {k}: {rate:e}");
            let angle = (p[(0, 0)] + (s[0] * torque).powi(2)).sqrt();
            assert!(
                (found.states[k + 1][(2, 2)].sqrt() / angle - 1.0).abs() < 1e-3,
                "{every} {k}: {angle:e}"
            );
        }
    }
}
