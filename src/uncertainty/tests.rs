//! Compares covariances with reference values and with simulated motions near the plan.

use super::chance::Chance;
use super::*;
use crate::Vector3;
use crate::feedback::Kind;
use crate::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use crate::maneuver::problem::Problem;
use crate::optimize::discrete::linear_plan::Timing;
use crate::testing::{matrix, planned_reference, reference, vector};
use nalgebra::SMatrix;
use serde_json::Value;

fn near<const R: usize, const C: usize>(
    found: &SMatrix<f64, R, C>,
    expected: &SMatrix<f64, R, C>,
    part: f64,
    what: &str,
) {
    let apart = (found - expected).amax() / expected.amax().max(f64::MIN_POSITIVE);
    assert!(apart <= part, "{what}: {apart:e}\n{found}\n{expected}");
}

/// Returns gains of the kind that `key` names; `None` for open loop.
fn gains(linear: &LinearPlan, key: &str) -> Option<Gains> {
    let kind = match key {
        "open" | "open_loop" => return None,
        "neighbouring_extremal_frozen" => Kind::Neighbouring { freeze: Kind::FREEZE },
        _ => Kind::Tvlqr(None),
    };
    Some(Gains::along(linear, kind, false).unwrap())
}

/// Returns the 24 uncertain parameters of the reference files, in the order of the files.
pub(crate) fn parameters(sigma: &Value) -> Vec<(String, Parameter, f64)> {
    let unit = |axis: usize| Vector3::from_fn(|row, _| f64::from(u8::from(row == axis)));
    let inertia = |index: usize| {
        let (row, column) = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)][index];
        let mut delta = Matrix3::zeros();
        delta[(row, column)] = 1.0;
        delta[(column, row)] = 1.0;
        Parameter::Inertia(delta)
    };
    let of = |index: usize| match (index, index % 3) {
        (0..6, _) => inertia(index),
        (6..9, axis) => Parameter::InputScale(axis),
        (9..12, axis) => Parameter::ActuatorTurn(unit(axis)),
        (12..15, axis) => Parameter::SensorTurn(unit(axis)),
        (15..18, axis) => Parameter::RateScale(axis),
        (18..21, axis) => Parameter::RateBias(unit(axis)),
        (_, axis) => Parameter::ConstantTorque(unit(axis)),
    };
    (0..24).map(|index| (index.to_string(), of(index), sigma[index].as_f64().unwrap())).collect()
}

/// Converts a covariance of `[ζ; δΠ]` to `[ζ; δΩ]`, for the start and the sensors of the reference
/// files whose names begin with u.
fn as_rates(problem: &Problem, covariance: &Matrix6) -> Matrix6 {
    let mut map = Matrix6::identity();
    map.fixed_view_mut::<3, 3>(3, 3).copy_from(problem.body.inertia.j_inverse());
    map * covariance * map.transpose()
}

fn cone(given: &Value, boresight: Vector3) -> Constraint {
    let cone = Pointing::new(
        Side::KeepOut,
        vec![boresight],
        vec![Direction::Fixed(vector(&given["w"]))],
        given["half_angle"].as_f64().unwrap(),
    );
    Constraint { name: "cone".into(), rule: Rule::Pointing(cone) }
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

#[test]
fn covariances_without_parameters_are_those_of_the_references() {
    for (name, plan_name) in [
        ("u01_diag123", "g01_diag123_100"),
        ("u02_full_nonrest", "g02_full_nonrest"),
        ("u03_xte_si", "g03_xte_si"),
    ] {
        let file = reference(&format!("closed_loop/{name}.json"));
        let (_, problem, plan) = planned_reference(plan_name);
        let linear = LinearPlan::new(&problem, &plan, Timing::AtNodes).unwrap();
        let given = &file["problem"];
        let uncertainty = Uncertainty {
            start: as_rates(&problem, &matrix(&given["P0"])),
            parameters: Vec::new(),
            torque_noise: matrix(&given["Sw"]),
            sensor_noise: as_rates(&problem, &matrix(&given["Rs"])),
        };
        for key in ["open", "closed"] {
            let gains = gains(&linear, key);
            let found = Covariance::along(&linear, gains.as_ref(), &uncertainty);
            let expected = &file["result"][key];
            let end = as_rates(&problem, &matrix(&expected["P_N"]));
            near(&found.end, &end, 1e-9, &format!("{name} {key} end"));
            for (node, state) in expected["P_tilde"].as_object().unwrap() {
                let node: usize = node.parse().unwrap();
                near(&found.states[node], &matrix(state), 1e-9, &format!("{name} {key} {node}"));
            }
            let boresight: Vector3 = vector(&given["boresight"]);
            let of_attitude = found.end.fixed_view::<3, 3>(0, 0).into_owned();
            let radius = Radius::of(&boresight, &of_attitude);
            let sigma: SMatrix<f64, 2, 1> = vector(&expected["boresight_sigma12"]);
            near(&SMatrix::from(radius.sigma), &sigma, 1e-9, "ellipse");
            let sampled = expected["mc_boresight_quantile_9973"].as_f64().unwrap();
            assert!((radius.within / sampled - 1.0).abs() < 0.02, "{} for {sampled}", radius.within);
            let chances = Chance::of(&cone(&given["cone"], boresight), &problem, &linear, &found);
            for (found, expected) in chances.nodes.iter().zip(numbers(&expected["cone_probability_linear"])) {
                assert!((found - expected).abs() < 1e-9, "{name} {key}: {found} for {expected}");
            }
            if let Some(most) = expected["torque_sigma_max"].as_array() {
                let largest = found
                    .torque
                    .iter()
                    .fold(Vector3::zeros(), |most, torque| most.sup(&torque.diagonal().map(f64::sqrt)));
                near(&largest, &vector(&Value::Array(most.clone())), 1e-9, "torque");
            }
        }
    }
}

#[test]
fn covariances_with_parameters_are_those_of_the_references() {
    for (name, plan_name) in
        [("cl01_parameters_g01", "g01_diag123_100"), ("cl02_everything_g02", "g02_full_nonrest")]
    {
        let file = reference(&format!("closed_loop/{name}.json"));
        let (_, problem, plan) = planned_reference(plan_name);
        let linear = LinearPlan::new(&problem, &plan, Timing::AtNodes).unwrap();
        let given = &file["problem"];
        let sensors = &given["Rs"];
        let uncertainty = Uncertainty {
            start: matrix(&given["P0"]),
            parameters: parameters(&given["sigma_p"]),
            torque_noise: matrix(&given["Sw"]),
            sensor_noise: if sensors.is_null() {
                Matrix6::zeros()
            } else {
                as_rates(&problem, &matrix(sensors))
            },
        };
        for key in ["open_loop", "tvlqr", "neighbouring_extremal_frozen"] {
            let gains = gains(&linear, key);
            let found = Covariance::along(&linear, gains.as_ref(), &uncertainty);
            let expected = &file["result"][key];
            let what = format!("{name} {key}");
            for (index, column) in found.end_by_parameter.iter().enumerate() {
                let dy = Vector6::from_fn(|row, _| expected["dy_dp"][row][index].as_f64().unwrap());
                let size = matrix::<6, 24>(&expected["dy_dp"]).amax();
                assert!(
                    (column - dy).amax() / size < 1e-9,
                    "{what} parameter {index}: {column}{dy} {size:e} {:e}",
                    (column - dy).amax() / size
                );
            }
            near(&found.end_of_parameters, &matrix(&expected["P_end_parameters"]), 1e-9, &what);
            near(&found.end_sigma(), &vector(&expected["sigma_end"]), 1e-9, &what);
            let sampled: Vector6 = vector(&expected["mc"]["sigma"]);
            let apart = found.end_sigma().component_div(&sampled).map(|ratio| (ratio - 1.0).abs()).amax();
            assert!(apart < 0.015, "{what}: sampled {sampled}");
            let boresight: Vector3 = vector(&given["boresight"]);
            let radius = Radius::of(&boresight, &found.end.fixed_view::<3, 3>(0, 0).into_owned());
            let linear_radius = expected["boresight_9973_linear"].as_f64().unwrap();
            assert!(
                (radius.within / linear_radius - 1.0).abs() < 5e-3,
                "{what} {}: {linear_radius}",
                radius.within
            );
            if !given["cone"].is_null() {
                let chances = Chance::of(&cone(&given["cone"], boresight), &problem, &linear, &found);
                for (found, expected) in
                    chances.nodes.iter().zip(numbers(&expected["cone"]["chance_per_step_linear"]))
                {
                    assert!((found - expected).abs() < 1e-8, "{what}: {found} for {expected}");
                }
            }
            let shares = found.shares(&uncertainty);
            assert_eq!(shares.len(), 24);
        }
    }
}
