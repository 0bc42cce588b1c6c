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
//! [`Bounded`] is the set-valued version, of errors that stay within bounds and have no distribution: an ellipsoid that holds every
//! motion beside the plan, to first order. Sets add up as `⊕`, of which the ellipsoid of least trace about it is
//!
//! ```text
//! {A_1} ⊕ … ⊕ {A_n} ⊂ {P} ,     P = (Σ √tr A_i) Σ A_i/√tr A_i
//! ```
//!
//! Where covariances of independent noise grow like √k, sets grow like k: nothing averages out.

pub mod chance;
mod pointing;

pub use pointing::Radius;

use crate::feedback::Gains;
use crate::optimize::linear_plan::{LinearPlan, Matrix6, Parameter, Vector6};
use crate::{Matrix3, Vector3};
use nalgebra::{Const, Dyn, OMatrix, SMatrix, SVector};

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
        if plan.has_wheels() {
            Flow::<9> { plan, gains, uncertainty }.carry()
        } else {
            Flow::<6> { plan, gains, uncertainty }.carry()
        }
    }

    /// Standard deviations of attitude \[rad\] and rate [rad/s] at the end.
    pub fn end_sigma(&self) -> Vector6 {
        // `max` would make a zero of NaN.
        self.end.diagonal().map(|variance| if variance < 0.0 { 0.0 } else { variance.sqrt() })
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

/// Ellipsoids `{z : zᵀP⁻¹z ≤ 1}` along a plan that hold every motion beside it, to first order, where each source of error is
/// anywhere within one deviation of what [`Uncertainty`] says: start and noise within their ellipsoids (noise of the torque as its
/// mean over a step), each parameter in its interval.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Bounded {
    /// P of `[ζ; δΠ]`, rad and N·m·s, at each node.
    pub states: Vec<Matrix6>,
    /// P of the physical `[ζ; δΩ]` at the end, rad and rad/s.
    pub end: Matrix6,
}

impl Bounded {
    /// Carries the sets along a plan whose torques are held; `gains` where the loop is closed.
    pub fn along(plan: &LinearPlan, gains: Option<&Gains>, uncertainty: &Uncertainty) -> Self {
        if plan.has_wheels() {
            Flow::<9> { plan, gains, uncertainty }.bound()
        } else {
            Flow::<6> { plan, gains, uncertainty }.bound()
        }
    }
}

/// The ellipsoid of least trace about the sum of ellipsoids; a point where all are points.
fn minkowski<const N: usize>(sets: &[Square<N>]) -> Square<N> {
    let roots: Vec<f64> = sets.iter().map(|set| set.trace().max(0.0).sqrt()).collect();
    let all: f64 = roots.iter().sum();
    let parts = sets.iter().zip(&roots).filter(|(_, root)| **root > 0.0);
    parts.fold(Square::<N>::zeros(), |sum, (set, root)| sum + set * (all / root))
}

/// A pass along a plan, with `N` states: 6, or 9 with the momentum of wheels.
struct Flow<'a, const N: usize> {
    plan: &'a LinearPlan,
    gains: Option<&'a Gains>,
    uncertainty: &'a Uncertainty,
}

type Square<const N: usize> = SMatrix<f64, N, N>;
type Columns<const N: usize> = OMatrix<f64, Const<N>, Dyn>;

impl<const N: usize> Flow<'_, N> {
    /// `[ζ; δΩ]` in SI as a scaled `z` of momenta.
    fn of_rates(&self) -> Matrix6 {
        let mut map = Matrix6::identity();
        map.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.plan.momentum_of_rate());
        map
    }

    /// Columns of the state, one for each parameter.
    fn columns(&self, of: impl Fn(&Parameter) -> Vector6) -> Columns<N> {
        let parameters = &self.uncertainty.parameters;
        let mut columns = Columns::<N>::zeros(parameters.len());
        for (index, (_, parameter, _)) in parameters.iter().enumerate() {
            columns.fixed_view_mut::<6, 1>(0, index).copy_from(&of(parameter));
        }
        columns
    }

    /// `S Σ_p Sᵀ`.
    fn of_parameters(&self, columns: &Columns<N>) -> Square<N> {
        let mut sum = Square::<N>::zeros();
        for (column, (_, _, sigma)) in columns.column_iter().zip(&self.uncertainty.parameters) {
            sum += column * column.transpose() * (sigma * sigma);
        }
        sum
    }

    /// A matrix of `z` as one of the whole state: nothing else.
    fn whole(of: &Matrix6) -> Square<N> {
        let mut out = Square::<N>::zeros();
        out.fixed_view_mut::<6, 6>(0, 0).copy_from(of);
        out
    }

    /// The part of `z`.
    fn part(of: &Square<N>) -> Matrix6 {
        of.fixed_view::<6, 6>(0, 0).into_owned()
    }

    /// `A` and `B` of a step for the whole state.
    fn step(&self, index: usize) -> (Square<N>, SMatrix<f64, N, 3>) {
        let step = &self.plan.steps()[index];
        let mut a = Self::whole(&step.stage.a);
        let mut b = SMatrix::<f64, N, 3>::zeros();
        b.fixed_view_mut::<6, 3>(0, 0).copy_from(&step.stage.b);
        for row in 6..N {
            a[(row, row)] = 1.0;
            b[(row, row - 6)] = -step.stage.length;
            a.fixed_view_mut::<6, 1>(0, row).copy_from(&step.wheels.column(row - 6));
        }
        (a, b)
    }

    /// `E_k` for the whole state.
    fn disturbed(&self, step: usize) -> Columns<N> {
        let mut columns = self.columns(|parameter| self.plan.disturbance(step, parameter));
        for (index, (_, parameter, _)) in self.uncertainty.parameters.iter().enumerate() {
            let stored = self.plan.stored(step, parameter);
            for row in 6..N {
                columns[(row, index)] = -stored[row - 6];
            }
        }
        columns
    }

    /// A covariance of the state as that of `[ζ; δΠ]`, rad and N·m·s.
    fn si(&self, state: &Square<N>) -> Matrix6 {
        let unit = |row: usize| self.plan.unit(row);
        Matrix6::from_fn(|row, column| state[(row, column)] * unit(row) * unit(column))
    }

    /// Intensity of the noise of the torque, scaled.
    fn noise_of_torque(&self) -> Matrix3 {
        let units = self.plan.units();
        self.uncertainty.torque_noise / (units.torque() * units.torque() * units.time)
    }

    /// Covariance of what is measured, scaled.
    fn sensors(&self) -> Square<N> {
        let of_rates = self.of_rates();
        Self::whole(&(of_rates * self.uncertainty.sensor_noise * of_rates.transpose()))
    }

    /// `δJ Ω*` of each parameter at a node: what a rate that is known has of momentum in the true body.
    fn of_known_rate(&self, node: usize) -> Columns<N> {
        let rate = *self.plan.node(node).1;
        self.columns(|parameter| match parameter {
            Parameter::Inertia(delta) => momenta(&(self.plan.scaled_inertia(delta) * rate)),
            _ => Vector6::zeros(),
        })
    }

    /// `B K` of a step for the whole state; zero open loop.
    fn gain(&self, step: usize) -> SMatrix<f64, 3, N> {
        self.gains.map_or_else(SMatrix::zeros, |gains| gains.torque(self.plan, step))
    }

    fn carry(&self) -> Covariance {
        let (plan, count) = (self.plan, self.plan.count());
        let of_rates = self.of_rates();
        let torque_unit = plan.units().torque();
        let (noise_of_torque, sensors) = (self.noise_of_torque(), self.sensors());
        let first = plan.first();
        let start = first * of_rates;
        let mut p = Self::whole(&(start * self.uncertainty.start * start.transpose()));
        let mut s = Self::whole(&first) * self.of_known_rate(0)
            + self.columns(|parameter| plan.outer_disturbance(0, parameter));
        let mut states = Vec::with_capacity(count + 1);
        let mut torque = Vec::with_capacity(count);
        let mut inputs = Vec::new();
        states.push(self.si(&(p + self.of_parameters(&s))));
        let mut last: Option<(Matrix6, Columns<N>)> = None;
        for k in 0..count {
            let (a, b) = self.step(k);
            let noise = b * (noise_of_torque / plan.steps()[k].stage.length) * b.transpose();
            let disturbed = self.disturbed(k);
            let Some(gains) = self.gains else {
                p = a * p * a.transpose() + noise;
                s = a * &s + disturbed;
                torque.push(Vector3::zeros());
                states.push(self.si(&(p + self.of_parameters(&s))));
                continue;
            };
            let gain = self.gain(k);
            let measured = self.columns(|parameter| plan.measured(k, parameter));
            let seen = p + sensors + self.of_parameters(&(&s + &measured));
            torque.push(deviations(&gain, &seen).map(|sigma| sigma * torque_unit));
            inputs.push(self.input_deviations(gains, k, &seen));
            if k + 1 == count && plan.half_kick(1) > 0.0 {
                // The last correction is still in part to come at the end, and belongs to what was seen before it.
                let back = Self::whole(&plan.last());
                let mut half = SMatrix::<f64, N, 3>::zeros();
                half.fixed_view_mut::<6, 3>(0, 0).copy_from(&(momentum_rows() * plan.half_kick(1)));
                let through = back * b - half;
                let closed = back * a - through * gain;
                let answered = through * gain;
                let end = closed * p * closed.transpose()
                    + answered * sensors * answered.transpose()
                    + back * noise * back.transpose();
                let moved = closed * &s + back * &disturbed - answered * &measured;
                last = Some((Self::part(&end), moved));
            }
            let answered = b * gain;
            let closed = a - answered;
            p = closed * p * closed.transpose() + answered * sensors * answered.transpose() + noise;
            s = closed * &s + disturbed - answered * measured;
            states.push(self.si(&(p + self.of_parameters(&s))));
        }
        let (end, moved) = last.unwrap_or_else(|| {
            let back = Self::whole(&plan.last());
            (Self::part(&(back * p * back.transpose())), back * &s)
        });
        let moved = moved - self.columns(|parameter| plan.outer_disturbance(1, parameter));
        self.ended(states, torque, inputs, &end, &moved)
    }

    /// The set of motions beside the plan: start and noise carried as one, parameters as segments beside it.
    fn bound(&self) -> Bounded {
        let (plan, count) = (self.plan, self.plan.count());
        let of_rates = self.of_rates();
        let (noise_of_torque, sensors) = (self.noise_of_torque(), self.sensors());
        let mut p = Self::whole(&(of_rates * self.uncertainty.start * of_rates.transpose()));
        let mut s = self.of_known_rate(0);
        let with = |p: &Square<N>, s: &Columns<N>| {
            let segments = s.column_iter().zip(&self.uncertainty.parameters);
            let segments =
                segments.map(|(column, (_, _, sigma))| column * column.transpose() * (sigma * sigma));
            minkowski(&std::iter::once(*p).chain(segments).collect::<Vec<_>>())
        };
        let mut states = vec![self.si(&with(&p, &s))];
        for k in 0..count {
            let (a, b) = self.step(k);
            let answered = b * self.gain(k);
            let closed = a - answered;
            let noise = b * (noise_of_torque / plan.steps()[k].stage.length) * b.transpose();
            p = minkowski(&[
                closed * p * closed.transpose(),
                answered * sensors * answered.transpose(),
                noise,
            ]);
            s = closed * &s + self.disturbed(k)
                - answered * self.columns(|parameter| plan.measured(k, parameter));
            states.push(self.si(&with(&p, &s)));
        }
        let to_rates = of_rates.try_inverse().unwrap_or_else(|| Matrix6::repeat(f64::NAN));
        let end = to_rates * Self::part(&with(&p, &(s - self.of_known_rate(count)))) * to_rates.transpose();
        Bounded { states, end }
    }

    /// What is told of the end: rates in place of momenta.
    fn ended(
        &self,
        states: Vec<Matrix6>,
        torque: Vec<Vector3>,
        inputs: Vec<Vec<f64>>,
        end: &Matrix6,
        moved: &Columns<N>,
    ) -> Covariance {
        let to_rates = self.of_rates().try_inverse().unwrap_or_else(|| Matrix6::repeat(f64::NAN));
        // δΩ = J₀⁻¹ (δΠ − δJ Ω*).
        let columns = Self::whole(&to_rates) * (moved - self.of_known_rate(self.plan.count()));
        let end_of_parameters = Self::part(&self.of_parameters(&columns));
        Covariance {
            states,
            end: to_rates * end * to_rates.transpose() + end_of_parameters,
            end_of_parameters,
            end_by_parameter: columns
                .column_iter()
                .map(|column| column.fixed_rows::<6>(0).into_owned())
                .collect(),
            torque,
            inputs,
        }
    }

    fn input_deviations(&self, gains: &Gains, step: usize, seen: &Square<N>) -> Vec<f64> {
        let plan = self.plan;
        let sigma = |row: &[f64]| {
            let gain = |column: usize| row.get(column).map_or(0.0, |gain| gain * plan.unit(column));
            let row = SVector::<f64, N>::from_fn(|column, _| gain(column));
            row.dot(&(seen * row)).max(0.0).sqrt()
        };
        gains.row(step).chunks_exact(gains.states).map(sigma).collect()
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
fn deviations<const N: usize>(gain: &SMatrix<f64, 3, N>, covariance: &Square<N>) -> Vector3 {
    (gain * covariance * gain.transpose()).diagonal().map(|variance| variance.max(0.0).sqrt())
}

#[cfg(test)]
pub(crate) mod tests;
