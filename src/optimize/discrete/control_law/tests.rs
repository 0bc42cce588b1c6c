//! The control laws compared with their definition as a minimum, and their derivatives with finite
//! differences.

use super::saturated::{Obstacle, obstacle_of};
use super::*;
use crate::maneuver::objective::effort;
use crate::mechanics::actuators::{ActuatorSet, AxisFrame, Limits};
use crate::testing::Random;
use nalgebra::{DMatrix, DVector};

/// Returns an actuator set with one to six inputs, so that its authority has every rank, and a
/// weight.
fn random_channel(random: &mut Random, norm: bool) -> (ActuatorSet, DMatrix<f64>) {
    let count = 1 + ((random.uniform() + 1.0) * 3.0) as usize;
    let axes = (0..count).map(|_| random.vector3()).collect();
    let mut weight = DMatrix::from_fn(count, count, |_, _| random.uniform());
    weight = &weight * weight.transpose() + DMatrix::identity(count, count) * 0.1;
    let mut limits = Limits::default();
    if norm {
        limits.norm = Some(0.5 + 0.4 * random.uniform());
    } else {
        weight = DMatrix::from_diagonal(&weight.diagonal());
        limits.size = Some((0..count).map(|_| 0.5 + 0.4 * random.uniform()).collect());
    }
    (ActuatorSet::new(axes, AxisFrame::Body).unwrap().with_limits(limits).unwrap(), weight)
}

/// Returns the Hamiltonian `½ uᵀWu + q·Bu` of any inputs u.
fn hamiltonian(weighted: &Weighted, costate: &Vector3, inputs: &DVector<f64>) -> f64 {
    let inputs = inputs.as_slice();
    effort(&weighted.weight, inputs) + costate.dot(&weighted.set.output(inputs))
}

fn is_allowed(channel: &ActuatorSet, inputs: &DVector<f64>, slack: f64) -> bool {
    let Limits { size, norm, .. } = channel.limits();
    let each = size.as_ref().is_none_or(|size| inputs.iter().zip(size).all(|(u, limit)| u.abs() <= *limit));
    each && norm.is_none_or(|norm| channel.output(inputs.as_slice()).norm() <= norm * (1.0 + slack))
}

#[test]
fn inputs_are_allowed_and_no_allowed_ones_are_better() {
    let mut random = Random(3);
    let (mut limited, mut free) = (0, 0);
    for index in 0..400 {
        let (channel, weight) = random_channel(&mut random, index % 2 == 0);
        let weighted = Weighted::new(&channel, Some(&weight)).unwrap();
        let law = ControlLaw::of(&weighted);
        let costate = random.vector3() * 3.0f64.powf(random.uniform() * 3.0);
        let mut inputs = Vec::new();
        law.push_inputs(&weighted, &costate, &mut inputs);
        let inputs = DVector::from_vec(inputs);
        // Nearly parallel axes cost the norm limit some digits, by the condition number of their
        // authority.
        assert!(is_allowed(&channel, &inputs, 1e-12), "{channel:?}");
        let best = hamiltonian(&weighted, &costate, &inputs);
        *(if law.demand(&costate) > 1.0 { &mut limited } else { &mut free }) += 1;
        let mut tried = 0;
        while tried < 50 {
            let size = 10.0f64.powf(-2.0 * random.uniform() - 2.0);
            let other = inputs.map(|u| u + size * random.uniform());
            if is_allowed(&channel, &other, 0.0) {
                let value = hamiltonian(&weighted, &costate, &other);
                assert!(
                    value >= best - 1e-13 * best.abs().max(1.0),
                    "{channel:?} {costate} {}",
                    value - best
                );
            }
            tried += 1;
        }
        // The sweep uses the same quantities in other variables.
        let response = law.response(&costate);
        let output = channel.output(inputs.as_slice());
        let size = output.amax().max(1.0);
        assert!((response.output - output).amax() < 1e-12 * size, "{channel:?} {} {output}", response.output);
        let effort = effort(&weight, inputs.as_slice());
        assert!((response.cost - effort).abs() < 1e-12 * effort.max(1.0));
    }
    assert!(limited > 100 && free > 50, "{limited} {free}");
}

/// Only one input vector satisfies the KKT conditions, because `K` is convex in `u`.
#[test]
fn multipliers_balance_the_gradient_at_the_limits_and_vanish_elsewhere() {
    let mut random = Random(5);
    for index in 0..400 {
        let (channel, weight) = random_channel(&mut random, index % 2 == 0);
        let weighted = Weighted::new(&channel, Some(&weight)).unwrap();
        let law = ControlLaw::of(&weighted);
        let costate = random.vector3() * 3.0f64.powf(random.uniform() * 3.0);
        let mut inputs = Vec::new();
        law.push_inputs(&weighted, &costate, &mut inputs);
        let inputs = DVector::from_vec(inputs);
        let b_t_q = DVector::from_iterator(channel.count(), channel.axes().iter().map(|b| b.dot(&costate)));
        let gradient = &weight * &inputs + b_t_q;
        let multipliers = law.multipliers(&costate);
        assert!(multipliers.iter().all(|value| *value >= 0.0));
        let push = match (&channel.limits().size, channel.limits().norm) {
            // −∂K/∂ū_i = multiplier/ū_i, along the sign of u_i.
            (Some(limits), _) => DVector::from_fn(channel.count(), |row, _| {
                multipliers[row] / limits[row] * inputs[row].signum()
            }),
            (_, Some(limit)) => {
                let output = channel.output(inputs.as_slice());
                let b_t = channel.axes().iter().map(|b| b.dot(&output));
                DVector::from_iterator(channel.count(), b_t) * (multipliers[0] / (limit * limit))
            }
            _ => unreachable!(),
        };
        let error = (&gradient + push).amax();
        assert!(error < 1e-11 * gradient.amax().max(1.0), "{channel:?} {costate} {error:e}");
    }
}

#[test]
fn slope_is_the_derivative_of_the_output_in_any_units() {
    let mut random = Random(7);
    let step = 1e-5;
    let mut compared = 0;
    for index in 0..400 {
        let (channel, weight) = random_channel(&mut random, index % 2 == 0);
        let weighted = Weighted::new(&channel, Some(&weight)).unwrap();
        let law = ControlLaw::of(&weighted).scaled(2.5, 0.3);
        let costate = random.vector3() * 3.0f64.powf(random.uniform() * 3.0);
        let slope = law.slope(&costate);
        assert!((slope - slope.transpose()).amax() < 1e-14 * slope.amax().max(1.0));
        let at = |along: usize, step: f64| {
            let moved = costate + Vector3::ith(along, step);
            (law.response(&moved).output, law.slope(&moved))
        };
        for column in 0..3 {
            let (ahead, slope_ahead) = at(column, step);
            let (behind, slope_behind) = at(column, -step);
            // A large difference of the two derivatives means a kink between them.
            if (slope_ahead - slope_behind).amax() > 1e-3 * slope.amax() {
                continue;
            }
            let difference = (ahead - behind) / (2.0 * step);
            let error = (difference + slope.column(column)).amax();
            assert!(error < 1e-8 * slope.amax().max(1.0), "{channel:?} {costate} {error:e}");
            compared += 1;
        }
    }
    assert!(compared > 1000, "{compared}");
}

#[test]
fn the_norm_bound_of_equal_authorities_is_the_closed_form() {
    let mut random = Random(9);
    for _ in 0..100 {
        let weight = 1.5 + random.uniform();
        let limit = 0.5 + 0.4 * random.uniform();
        let axes: Vec<Vector3> = random.rotation().column_iter().map(|axis| axis.into_owned()).collect();
        let channel = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
        let limits = Limits { norm: Some(limit), ..Limits::default() };
        let (channel, matrix) = (channel.with_limits(limits).unwrap(), DMatrix::identity(3, 3) * weight);
        let law = ControlLaw::of(&Weighted::new(&channel, Some(&matrix)).unwrap());
        let costate = random.vector3() * 10.0f64.powf(4.0 * random.uniform());
        let expected = costate * (-limit / (limit * weight).max(costate.norm()));
        assert!((law.response(&costate).output - expected).amax() < 1e-15 * limit.max(expected.amax()) * 4.0);
    }
}

#[test]
fn what_is_not_finite_stays_so() {
    let mut random = Random(11);
    for norm in [false, true] {
        let (channel, weight) = random_channel(&mut random, norm);
        let law = ControlLaw::of(&Weighted::new(&channel, Some(&weight)).unwrap());
        let response = law.response(&Vector3::new(f64::NAN, 0.0, 1.0));
        assert!(response.output.iter().any(|value| value.is_nan()) && response.cost.is_nan());
    }
}

#[test]
fn limits_without_a_law_are_named() {
    let mut random = Random(13);
    let (channel, weight) = random_channel(&mut random, true);
    let count = channel.count();
    let obstacle = |channel: ActuatorSet, limits: Limits, weight: &DMatrix<f64>| {
        obstacle_of(&Weighted::new(&channel.with_limits(limits).unwrap(), Some(weight)).unwrap())
    };
    let with = |limits: Limits| obstacle(channel.clone(), limits, &weight);
    let (size, rate) = (Some(vec![1.0; count]), Some(vec![1.0; count]));
    let two = ActuatorSet::new(vec![Vector3::x(), Vector3::y()], AxisFrame::Body).unwrap();
    let coupled = DMatrix::from_row_slice(2, 2, &[1.0, 0.1, 0.1, 1.0]);
    let of_size = Limits { size: Some(vec![1.0; 2]), ..Limits::default() };
    assert!(with(Limits { rate, ..Limits::default() }) == Some(Obstacle::InputRate));
    assert!(with(Limits { size, norm: Some(1.0), ..Limits::default() }) == Some(Obstacle::TwoLimits));
    assert!(obstacle(two, of_size, &coupled) == Some(Obstacle::CoupledWeight));
    assert_eq!(with(Limits { norm: Some(1.0), ..Limits::default() }), None);
    assert_eq!(with(Limits::default()), None);
}
