//! Reading of `[uncertainty]`: standard deviations and covariances.

use crate::spec::{Limits, Section, short, show};
use nalgebra::{DMatrix, SMatrix};
use slewkit::maneuver::Problem;
use slewkit::optimize::discrete::linear_plan::{Matrix6, Parameter};
use slewkit::uncertainty::Uncertainty;
use slewkit::{Matrix3, Vector3};

/// Reads the standard deviations of `count` items, from a common number or a list; zeros if the key
/// is absent. `all` describes the items in messages.
fn several(section: Option<&Section>, key: &str, unit: f64, count: usize, all: &str) -> Vec<f64> {
    let Some((section, limits)) = section.and_then(|section| Some((section, section.limits(key)?))) else {
        return vec![0.0; count];
    };
    match limits {
        Limits::All(value) => vec![value * unit; count],
        Limits::Each(values) if values.len() == count => values.iter().map(|value| value * unit).collect(),
        Limits::Each(values) => {
            let told = if count == 3 { "three".into() } else { count.to_string() };
            let reason = format!("`{key}` has {} numbers, but needs one for {all}, or {told}", values.len());
            section.error("E0026", key, reason, format!("write one number, or {told}"));
            vec![0.0; count]
        }
    }
}

/// Reads the standard deviations of the three components in body axes.
fn three(section: Option<&Section>, key: &str, unit: f64) -> Vector3 {
    Vector3::from_column_slice(&several(section, key, unit, 3, "all axes"))
}

/// Largest relative asymmetry, and largest negative eigenvalue relative to the variances, for which
/// a covariance is accepted. It allows for rounding to six digits.
const ROUNDING: f64 = 1e-6;

/// Reads a covariance matrix, which must be symmetric and positive semidefinite. Returns `None` if
/// the key is absent or an error was reported.
fn covariance<const N: usize>(section: &Section, key: &str) -> Option<SMatrix<f64, N, N>> {
    let rows = if section.has(key) { section.square(key)? } else { return None };
    if rows.len() != N {
        let reason = format!("`{key}` has {} rows, but needs {N}", rows.len());
        return section.refuse(
            "E0175",
            key,
            reason,
            format!("write {N} rows of {N} numbers, or {N} variances"),
        );
    }
    let given = DMatrix::from_fn(N, N, |row, column| rows[row][column]);
    if let Some(row) = (0..N).find(|row| given[(*row, *row)] < 0.0) {
        let reason = format!(
            "the variance in row {} is {}: it must not be negative",
            row + 1,
            show(given[(row, row)])
        );
        return section.refuse("E0175", key, reason, "give the square of the standard deviation");
    }
    // The covariance is scaled to unit variances, because radians and rates differ in magnitude.
    let sigma = |row: usize| if given[(row, row)] > 0.0 { given[(row, row)].sqrt() } else { 1.0 };
    let scaled = DMatrix::from_fn(N, N, |row, column| given[(row, column)] / (sigma(row) * sigma(column)));
    let pairs = || (0..N).flat_map(|row| (0..row).map(move |column| (row, column)));
    let apart = |(row, column): &(usize, usize)| (scaled[(*row, *column)] - scaled[(*column, *row)]).abs();
    if let Some((row, column)) = pairs().find(|pair| apart(pair) > ROUNDING) {
        let reason = format!(
            "the covariance is not symmetric: row {}, column {} is {}, and row {}, column {} is {}",
            row + 1,
            column + 1,
            show(given[(row, column)]),
            column + 1,
            row + 1,
            show(given[(column, row)])
        );
        return section.refuse("E0175", key, reason, "write the same number on both sides of the diagonal");
    }
    if let Some((row, column)) = pairs().find(|(row, column)| scaled[(*row, *column)].abs() > 1.0 + ROUNDING)
    {
        let reason = format!(
            "row {}, column {} is {}, which exceeds the product of both standard deviations, {}",
            row + 1,
            column + 1,
            show(given[(row, column)]),
            short(sigma(row) * sigma(column))
        );
        return section.refuse(
            "E0175",
            key,
            reason,
            "write a smaller number: a correlation is between -1 and 1",
        );
    }
    let symmetric = 0.5 * (&scaled + scaled.transpose());
    let least = symmetric.symmetric_eigenvalues().min();
    if least < -ROUNDING * N as f64 {
        let reason = format!(
            "the covariance is not positive semidefinite: scaled to variances of 1, its smallest \
            eigenvalue is {}",
            short(least)
        );
        return section.refuse("E0175", key, reason, "reduce the correlations");
    }
    Some(SMatrix::from_fn(|row, column| 0.5 * (given[(row, column)] + given[(column, row)])))
}

/// Reads the covariance of the attitude error ζ and the rate error δΩ, as a matrix of `[ζ; δΩ]`.
/// The spec gives the whole matrix or, for each of the two errors, standard deviations or a
/// covariance.
fn variances(section: Option<&Section>) -> Matrix6 {
    let degree = 1_f64.to_radians();
    let Some(of) = section else { return Matrix6::zeros() };
    if let Some(whole) = covariance::<6>(of, "covariance_deg_deg_s") {
        return whole * (degree * degree);
    }
    let block = |key: &str, block: &str| {
        let sigma = three(section, key, degree);
        covariance::<3>(of, block).map_or_else(
            || Matrix3::from_diagonal(&sigma.component_mul(&sigma)),
            |block| block * (degree * degree),
        )
    };
    let mut both = Matrix6::zeros();
    both.fixed_view_mut::<3, 3>(0, 0).copy_from(&block("attitude_deg", "attitude_covariance_deg2"));
    let rates = block("angular_velocity_deg_s", "angular_velocity_covariance_deg2_s2");
    both.fixed_view_mut::<3, 3>(3, 3).copy_from(&rates);
    both
}

/// Returns independent errors of the inertia, each with its standard deviation. They are the
/// principal components of the covariance of the elements xx, yy, zz, xy, xz, yz.
fn inertias(section: Option<&Section>) -> Vec<(Matrix3, f64)> {
    let Some(covariance) = section.and_then(|section| covariance::<6>(section, "covariance_kg2_m4")) else {
        return Vec::new();
    };
    let eigen = covariance.symmetric_eigen();
    let mut order = [0, 1, 2, 3, 4, 5];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let delta = |index: usize| {
        let [xx, yy, zz, xy, xz, yz] = eigen.eigenvectors.column(index).into_owned().into();
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    };
    let largest = eigen.eigenvalues.max();
    let sigma = |index: usize| eigen.eigenvalues[index].max(0.0).sqrt();
    let counts = |index: &usize| eigen.eigenvalues[*index] > ROUNDING * ROUNDING * largest;
    order.into_iter().filter(counts).map(|index| (delta(index), sigma(index))).collect()
}

pub(super) fn uncertainty(section: &Section, problem: &Problem) -> Uncertainty {
    let degree = 1_f64.to_radians();
    let [start, inertia, alignment, actuators, sensor] =
        ["start", "inertia", "alignment", "actuators", "sensor"].map(|name| section.section(name));
    let axes = ["x", "y", "z"];
    let unit = |axis: usize| Vector3::from_fn(|row, _| f64::from(u8::from(row == axis)));
    let mut parameters: Vec<(String, Parameter, f64)> = Vec::new();
    let mut add = |name: String, parameter: Parameter, sigma: f64| {
        if sigma > 0.0 {
            parameters.push((name, parameter, sigma));
        }
    };
    for (number, (delta, sigma)) in inertias(inertia).into_iter().enumerate() {
        add(format!("inertia, error {}", number + 1), Parameter::Inertia(delta), sigma);
    }
    let moments = three(inertia, "relative", 1.0);
    for axis in 0..3 {
        let mut delta = Matrix3::zeros();
        delta[(axis, axis)] = 1.0;
        let sigma = moments[axis] * problem.body.inertia.j()[(axis, axis)];
        add(format!("inertia {0}{0}", axes[axis]), Parameter::Inertia(delta), sigma);
    }
    let products = inertia.and_then(|section| section.number("products_kg_m2")).unwrap_or(0.0);
    for (row, column) in [(0, 1), (0, 2), (1, 2)] {
        let mut delta = Matrix3::zeros();
        delta[(row, column)] = 1.0;
        delta[(column, row)] = 1.0;
        add(format!("inertia {}{}", axes[row], axes[column]), Parameter::Inertia(delta), products);
    }
    let inputs = problem.actuation.torque.count();
    for (input, scale) in several(actuators, "scale", 1.0, inputs, "all inputs").into_iter().enumerate() {
        add(format!("scale of input {}", input + 1), Parameter::InputScale(input), scale);
    }
    let rate_scale = sensor.and_then(|section| section.number("scale")).unwrap_or(0.0);
    let turned = three(alignment, "actuators_deg", degree);
    let constant = three(actuators, "constant_n_m", 1.0);
    let seen = three(alignment, "sensor_deg", degree);
    let bias = three(sensor, "bias_deg_s", degree);
    for axis in 0..3 {
        let about = axes[axis];
        add(format!("actuators about {about}"), Parameter::ActuatorTurn(unit(axis)), turned[axis]);
        add(format!("torque {about}"), Parameter::ConstantTorque(unit(axis)), constant[axis]);
        add(format!("attitude sensor about {about}"), Parameter::SensorTurn(unit(axis)), seen[axis]);
        add(format!("scale of rate {about}"), Parameter::RateScale(axis), rate_scale);
        add(format!("bias of rate {about}"), Parameter::RateBias(unit(axis)), bias[axis]);
    }
    let noise = three(actuators, "noise_n_m_sqrt_s", 1.0);
    let intensity = actuators.and_then(|section| covariance::<3>(section, "noise_intensity_n2_m2_s"));
    Uncertainty {
        start: variances(start),
        parameters,
        torque_noise: intensity.unwrap_or_else(|| Matrix3::from_diagonal(&noise.component_mul(&noise))),
        sensor_noise: variances(sensor),
    }
}
