//! What is not known of a craft, carried along a plan: covariances of attitude and rate, open loop and under gains.
//!
//! The linearised Lie group flow carries an ellipsoid `{R* exp S(ζ), Π* + δΠ : zᵀP⁻¹z ≤ 1}` (Lee, Sanyal, Leok, McClamroch,
//! *Deterministic global attitude estimation*, 2006), and covariances by the same matrices. With the gains `G = B K`, noise of the
//! torque of intensity `S_w`, noise of the sensors of covariance `R_s` fresh at each step, and parameters `p` that are the same at
//! every step:
//!
//! ```text
//! z_{k+1} = A_k z_k − B_k G_k (z_k + C_k p + ν_k) + E_k p + B_k η_k ,      cov η = S_w/h
//! P = P_noise + S_k Σ_p S_kᵀ ,      S_{k+1} = (A − B G) S_k + E_k − B G C_k
//! ```
//!
//! A constant error of a parameter acts at every step with the same sign: as noise of each step it would come out several times too
//! small. `E_k` and `C_k` are those of `optimize::linear_plan`.
//!
//! [`Covariance::bounded`] is the set-valued version: an ellipsoid that holds every motion of bounded errors, to first order.

pub mod chance;
mod pointing;

pub use pointing::Radius;

use crate::feedback::Gains;
use crate::optimize::linear_plan::{LinearPlan, Matrix6, Parameter, Vector6};
use crate::{Matrix3, Vector3};
use nalgebra::{Matrix6xX, SMatrix};

type Matrix3x6 = SMatrix<f64, 3, 6>;
type Matrix6x3 = SMatrix<f64, 6, 3>;

/// What is not known of a craft: one standard deviation each, SI units, body axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uncertainty {
    /// Covariance of the start, `[ζ; δΩ]`, rad and rad/s: true minus planned.
    pub start: Matrix6,
    /// Parameters that are the same along the plan, independent of each other: what each is, by name, and its deviation.
    pub parameters: Vec<(String, Parameter, f64)>,
    /// Intensity of the noise of the torque, (N·m)²·s.
    pub torque_noise: Matrix3,
    /// Covariance of the noise of what is measured, `[ζ; δΩ]`, fresh at each step.
    pub sensor_noise: Matrix6,
}

/// Covariance along a plan.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Covariance {
    /// Of `[ζ; δΠ]`, rad and N·m·s, at each node; beside torques at nodes of the momenta after a full kick.
    pub states: Vec<Matrix6>,
    /// Of the physical `[ζ; δΩ]` at the end, rad and rad/s: true minus planned.
    pub end: Matrix6,
    /// The part of it that the parameters make.
    pub end_of_parameters: Matrix6,
    /// `∂[ζ; δΩ]/∂p` at the end, 6 numbers a parameter.
    pub end_by_parameter: Vec<Vector6>,
    /// Standard deviation of the correction of each torque, body axes [N·m], for each step.
    pub torque: Vec<Vector3>,
    /// Standard deviation of the correction of each input, SI, for each step; empty open loop.
    pub inputs: Vec<Vec<f64>>,
}

impl Covariance {
    /// Carries what is uncertain along a plan; `gains` where the loop is closed.
    pub fn along(plan: &LinearPlan, gains: Option<&Gains>, uncertainty: &Uncertainty) -> Self {
        Flow { plan, gains, uncertainty }.carry()
    }

    /// Standard deviations of attitude \[rad\] and rate [rad/s] at the end.
    pub fn end_sigma(&self) -> Vector6 {
        self.end.diagonal().map(|variance| variance.max(0.0).sqrt())
    }

    /// Which part of the variance of each number at the end a parameter makes.
    pub fn shares(&self, uncertainty: &Uncertainty) -> Vec<(String, Vector6)> {
        let share = |(column, (name, _, sigma)): (&Vector6, &(String, Parameter, f64))| {
            let part = Vector6::from_fn(|row, _| {
                let all = self.end[(row, row)];
                if all > 0.0 { (column[row] * sigma).powi(2) / all } else { 0.0 }
            });
            (name.clone(), part)
        };
        self.end_by_parameter.iter().zip(&uncertainty.parameters).map(share).collect()
    }
}

/// A pass along a plan.
struct Flow<'a> {
    plan: &'a LinearPlan,
    gains: Option<&'a Gains>,
    uncertainty: &'a Uncertainty,
}

impl Flow<'_> {
    /// `[ζ; δΩ]` in SI as a scaled `z` of momenta.
    fn of_rates(&self) -> Matrix6 {
        let mut map = Matrix6::identity();
        map.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.plan.momentum_of_rate());
        map
    }

    fn columns(&self, of: impl Fn(&Parameter) -> Vector6) -> Matrix6xX<f64> {
        let columns: Vec<Vector6> =
            self.uncertainty.parameters.iter().map(|(_, parameter, _)| of(parameter)).collect();
        if columns.is_empty() { Matrix6xX::zeros(0) } else { Matrix6xX::from_columns(&columns) }
    }

    /// `S Σ_p Sᵀ`.
    fn of_parameters(&self, columns: &Matrix6xX<f64>) -> Matrix6 {
        let mut sum = Matrix6::zeros();
        for (column, (_, _, sigma)) in columns.column_iter().zip(&self.uncertainty.parameters) {
            sum += column * column.transpose() * (sigma * sigma);
        }
        sum
    }

    fn carry(&self) -> Covariance {
        let (plan, count) = (self.plan, self.plan.count());
        let of_rates = self.of_rates();
        let si = |scaled: &Matrix6| {
            Matrix6::from_fn(|row, column| scaled[(row, column)] * plan.unit(row) * plan.unit(column))
        };
        let torque_unit = plan.units().torque();
        let noise_of_torque = self.uncertainty.torque_noise / (torque_unit * torque_unit * plan.units().time);
        let sensors = of_rates * self.uncertainty.sensor_noise * of_rates.transpose();
        let first = plan.first();
        let start = first * of_rates;
        let mut p = start * self.uncertainty.start * start.transpose();
        // A start whose rate is known has the momentum of the true body.
        let rate = *plan.node(0).1;
        let mut s = self.columns(|parameter| {
            let known = match parameter {
                Parameter::Inertia(delta) => first * momenta(&(plan.scaled_inertia(delta) * rate)),
                _ => Vector6::zeros(),
            };
            known + plan.outer_disturbance(0, parameter)
        });
        let mut states = Vec::with_capacity(count + 1);
        let mut torque = Vec::with_capacity(count);
        let mut inputs = Vec::new();
        states.push(si(&(p + self.of_parameters(&s))));
        let mut last: Option<(Matrix6, Matrix6xX<f64>)> = None;
        for (k, step) in plan.steps().iter().enumerate() {
            let noise = step.b * (noise_of_torque / step.length) * step.b.transpose();
            let disturbed = self.columns(|parameter| plan.disturbance(k, parameter));
            let Some(gains) = self.gains else {
                p = step.a * p * step.a.transpose() + noise;
                s = step.a * &s + disturbed;
                torque.push(Vector3::zeros());
                states.push(si(&(p + self.of_parameters(&s))));
                continue;
            };
            let gain = gains.torque(plan, k);
            let measured = self.columns(|parameter| plan.measured(k, parameter));
            let seen = &s + &measured;
            let covariance_seen = p + sensors + self.of_parameters(&seen);
            torque.push(deviations(&gain, &covariance_seen).map(|sigma| sigma * torque_unit));
            inputs.push(self.input_deviations(gains, k, &covariance_seen));
            if k + 1 == count && plan.half_kick(1) > 0.0 {
                // The last correction is still in part to come at the end, and belongs to what was seen before it.
                let half: Matrix6x3 = momentum_rows() * plan.half_kick(1);
                let back = plan.last();
                let through = back * step.b - half;
                let closed = back * step.a - through * gain;
                let answered = through * gain;
                let end = closed * p * closed.transpose()
                    + answered * sensors * answered.transpose()
                    + back * noise * back.transpose();
                let moved = closed * &s + back * &disturbed - answered * &measured;
                last = Some((end, moved));
            }
            let answered = step.b * gain;
            let closed = step.a - answered;
            p = closed * p * closed.transpose() + answered * sensors * answered.transpose() + noise;
            s = closed * &s + disturbed - answered * measured;
            states.push(si(&(p + self.of_parameters(&s))));
        }
        let (end, moved) = last.unwrap_or_else(|| {
            let back = plan.last();
            (back * p * back.transpose(), back * &s)
        });
        let moved = moved - self.columns(|parameter| plan.outer_disturbance(1, parameter));
        self.ended(states, torque, inputs, &end, &moved)
    }

    /// What is told of the end: rates in place of momenta.
    fn ended(
        &self,
        states: Vec<Matrix6>,
        torque: Vec<Vector3>,
        inputs: Vec<Vec<f64>>,
        end: &Matrix6,
        moved: &Matrix6xX<f64>,
    ) -> Covariance {
        let plan = self.plan;
        let to_rates = self.of_rates().try_inverse().unwrap_or_else(|| Matrix6::repeat(f64::NAN));
        let rate = *plan.node(plan.count()).1;
        // δΩ = J₀⁻¹ (δΠ − δJ Ω*).
        let known = self.columns(|parameter| match parameter {
            Parameter::Inertia(delta) => momenta(&(plan.scaled_inertia(delta) * rate)),
            _ => Vector6::zeros(),
        });
        let columns = to_rates * (moved - known);
        let end_of_parameters = self.of_parameters(&columns);
        Covariance {
            states,
            end: to_rates * end * to_rates.transpose() + end_of_parameters,
            end_of_parameters,
            end_by_parameter: columns.column_iter().map(|column| column.into_owned()).collect(),
            torque,
            inputs,
        }
    }

    fn input_deviations(&self, gains: &Gains, step: usize, seen: &Matrix6) -> Vec<f64> {
        let plan = self.plan;
        let sigma = |row: &[f64]| {
            let row = Vector6::from_fn(|column, _| row[column] * plan.unit(column));
            row.dot(&(seen * row)).max(0.0).sqrt()
        };
        gains.row(step).chunks_exact(6).map(sigma).collect()
    }
}

/// `[0; I]`.
fn momentum_rows() -> Matrix6x3 {
    Matrix6::identity().fixed_view::<6, 3>(0, 3).into_owned()
}

/// `[0; vector]`.
fn momenta(vector: &Vector3) -> Vector6 {
    Vector6::new(0.0, 0.0, 0.0, vector.x, vector.y, vector.z)
}

/// Standard deviations of `gain z`.
fn deviations(gain: &Matrix3x6, covariance: &Matrix6) -> Vector3 {
    (gain * covariance * gain.transpose()).diagonal().map(|variance| variance.max(0.0).sqrt())
}

#[cfg(test)]
pub(crate) mod tests;
