//! Propagation of covariances, parameter sensitivities and sets along a plan.

use super::{Bounded, Covariance, Uncertainty};
use crate::feedback::Gains;
use crate::optimize::discrete::linear_plan::{LinearPlan, Matrix6, Parameter, Vector6};
use crate::{Matrix3, Vector3};
use nalgebra::{Const, Dyn, OMatrix, RowSVector, SMatrix};

type Matrix6x3 = SMatrix<f64, 6, 3>;

/// Returns the ellipsoid of least trace that contains the Minkowski sum of ellipsoids centred at
/// zero. It is a point if all of them are points.
fn minkowski<const N: usize>(sets: &[Square<N>]) -> Square<N> {
    let roots: Vec<f64> = sets.iter().map(|set| set.trace().max(0.0).sqrt()).collect();
    let all: f64 = roots.iter().sum();
    let parts = sets.iter().zip(&roots).filter(|(_, root)| **root > 0.0);
    parts.fold(Square::<N>::zeros(), |sum, (set, root)| sum + set * (all / root))
}

/// The propagation along a plan with `N` states: 6, or 9 with the momentum of wheels.
pub(super) struct Flow<'a, const N: usize> {
    plan: &'a LinearPlan,
    gains: Option<&'a Gains>,
    uncertainty: &'a Uncertainty,
}

type Square<const N: usize> = SMatrix<f64, N, N>;
type Columns<const N: usize> = OMatrix<f64, Const<N>, Dyn>;

impl<'a, const N: usize> Flow<'a, N> {
    pub fn new(plan: &'a LinearPlan, gains: Option<&'a Gains>, uncertainty: &'a Uncertainty) -> Self {
        Self { plan, gains, uncertainty }
    }

    /// Returns the matrix that maps `[ζ; δΩ]` in SI units to the scaled state `z`, which has
    /// momenta.
    fn of_rates(&self) -> Matrix6 {
        let mut map = Matrix6::identity();
        map.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.plan.momentum_of_rate());
        map
    }

    /// Returns a matrix with one column for each parameter: the result of `of` as a vector of the
    /// whole state.
    fn columns(&self, of: impl Fn(&Parameter) -> Vector6) -> Columns<N> {
        let parameters = &self.uncertainty.parameters;
        let mut columns = Columns::<N>::zeros(parameters.len());
        for (index, (_, parameter, _)) in parameters.iter().enumerate() {
            columns.fixed_view_mut::<6, 1>(0, index).copy_from(&of(parameter));
        }
        columns
    }

    /// Returns the covariance `S Σ_p Sᵀ` that the parameters cause, for the sensitivities `S`.
    fn of_parameters(&self, columns: &Columns<N>) -> Square<N> {
        let mut sum = Square::<N>::zeros();
        for (column, (_, _, sigma)) in columns.column_iter().zip(&self.uncertainty.parameters) {
            sum += column * column.transpose() * (sigma * sigma);
        }
        sum
    }

    /// Embeds a 6×6 matrix of `z` in a matrix of the whole state, with zeros elsewhere.
    fn whole(of: &Matrix6) -> Square<N> {
        let mut out = Square::<N>::zeros();
        out.fixed_view_mut::<6, 6>(0, 0).copy_from(of);
        out
    }

    /// Returns the 6×6 block that belongs to `z`.
    fn part(of: &Square<N>) -> Matrix6 {
        of.fixed_view::<6, 6>(0, 0).into_owned()
    }

    /// Returns the matrices `A` and `B` of a step for the whole state.
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

    /// Returns the disturbances `E_k` of a step for the whole state, one column for each parameter.
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

    /// Converts a scaled covariance of the state to the covariance of `[ζ; δΠ]` in rad and N·m·s.
    fn si(&self, state: &Square<N>) -> Matrix6 {
        let unit = |row: usize| self.plan.unit(row);
        Matrix6::from_fn(|row, column| state[(row, column)] * unit(row) * unit(column))
    }

    /// Returns the intensity of the torque noise, scaled.
    fn noise_of_torque(&self) -> Matrix3 {
        let units = self.plan.units();
        self.uncertainty.torque_noise / (units.torque() * units.torque() * units.time)
    }

    /// Returns the covariance of the measurement noise, scaled.
    fn sensors(&self) -> Square<N> {
        let of_rates = self.of_rates();
        Self::whole(&(of_rates * self.uncertainty.sensor_noise * of_rates.transpose()))
    }

    /// Returns one column `[0; δJ Ω*]` for each parameter at a node: the change of the momentum at
    /// the planned rate `Ω*`, per unit of the parameter. It is zero unless the parameter is an
    /// inertia.
    fn of_known_rate(&self, node: usize) -> Columns<N> {
        let rate = *self.plan.node(node).1;
        self.columns(|parameter| match parameter {
            Parameter::Inertia(delta) => momenta(&(self.plan.scaled_inertia(delta) * rate)),
            _ => Vector6::zeros(),
        })
    }

    /// Returns the gain `B K` of a step for the whole state; zero in open loop.
    fn gain(&self, step: usize) -> SMatrix<f64, 3, N> {
        self.gains.map_or_else(SMatrix::zeros, |gains| gains.torque(self.plan, step))
    }

    /// Begins a tick at a node, with covariance and sensitivities of the state at this node.
    fn tick(&self, node: usize, p: &Square<N>, s: &Columns<N>) -> Tick<N> {
        let measured = self.columns(|parameter| self.plan.measured(node, parameter));
        Tick {
            gain: self.gain(node),
            p: *p,
            seen: s + &measured,
            measured,
            state: Square::<N>::identity(),
            sensors: Square::<N>::zeros(),
            noise: Square::<N>::zeros(),
        }
    }

    pub fn carry(&self) -> Covariance {
        let (plan, count) = (self.plan, self.plan.count());
        let every = self.gains.map_or(1, |gains| gains.every);
        let of_rates = self.of_rates();
        let (noise_of_torque, sensors) = (self.noise_of_torque(), self.sensors());
        let first = plan.first();
        let start = first * of_rates;
        let mut p = Self::whole(&(start * self.uncertainty.start * start.transpose()));
        let mut s = Self::whole(&first) * self.of_known_rate(0)
            + self.columns(|parameter| plan.outer_disturbance(0, parameter));
        let mut along = Covariance::default();
        self.tell(&mut along, &p, &s);
        let mut last: Option<(Matrix6, Columns<N>)> = None;
        let mut tick = self.tick(0, &p, &s);
        for k in 0..count {
            let (a, b) = self.step(k);
            let noise = b * (noise_of_torque / plan.steps()[k].stage.length) * b.transpose();
            let disturbed = self.disturbed(k);
            if k % every == 0 {
                let next = self.tick(k, &p, &s);
                if let (Some(gains), true) = (self.gains, k > 0) {
                    along.input_changes.push(self.changes(gains, k, &tick, &next, &sensors));
                }
                tick = next;
            } else if let Some(gains) = self.gains {
                along.input_changes.push(vec![0.0; gains.inputs]);
            }
            let gain = tick.gain;
            let seen = tick.p + sensors + self.of_parameters(&tick.seen);
            let corrected = gain * seen * gain.transpose();
            along.torque.push(corrected * plan.units().torque().powi(2));
            along.inputs.extend(self.gains.map(|gains| self.input_deviations(gains, k, &seen)));
            if self.gains.is_some() && k + 1 == count && plan.half_kick(1) > 0.0 {
                // A part of the last correction still acts at the end; it is based on the
                // measurement before it.
                let back = Self::whole(&plan.last());
                let mut half = SMatrix::<f64, N, 3>::zeros();
                half.fixed_view_mut::<6, 3>(0, 0).copy_from(&(momentum_rows() * plan.half_kick(1)));
                let through = back * b - half;
                let closed = back * a - through * gain;
                let answered = through * gain;
                let end = closed * p * closed.transpose()
                    + answered * sensors * answered.transpose()
                    + back * noise * back.transpose();
                let moved = closed * &s + back * &disturbed - answered * &tick.measured;
                last = Some((Self::part(&end), moved));
            }
            tick.go(&a, &b, &noise);
            p = tick.covariance(&sensors);
            s = a * &s + disturbed - b * gain * &tick.seen;
            self.tell(&mut along, &p, &s);
        }
        let (end, moved) = last.unwrap_or_else(|| {
            let back = Self::whole(&plan.last());
            (Self::part(&(back * p * back.transpose())), back * &s)
        });
        let moved = moved - self.columns(|parameter| plan.outer_disturbance(1, parameter));
        self.ended(along, &end, &moved)
    }

    /// Computes the sets of motions near the plan. Start and noise are propagated as one ellipsoid,
    /// and each parameter as a segment.
    pub fn bound(&self) -> Bounded {
        let (plan, count) = (self.plan, self.plan.count());
        let every = self.gains.map_or(1, |gains| gains.every);
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
        let mut tick = self.tick(0, &p, &s);
        for k in 0..count {
            let (a, b) = self.step(k);
            let noise = b * (noise_of_torque / plan.steps()[k].stage.length) * b.transpose();
            if k % every == 0 {
                tick = self.tick(k, &p, &s);
            }
            let before = a * tick.noise * a.transpose();
            tick.go(&a, &b, &noise);
            tick.noise = minkowski(&[before, noise]);
            p = minkowski(&tick.parts(&sensors));
            s = a * &s + self.disturbed(k) - b * tick.gain * &tick.seen;
            states.push(self.si(&with(&p, &s)));
        }
        let to_rates = of_rates.try_inverse().unwrap_or_else(|| Matrix6::repeat(f64::NAN));
        let end = to_rates * Self::part(&with(&p, &(s - self.of_known_rate(count)))) * to_rates.transpose();
        Bounded { states, end }
    }

    /// Appends the covariances of state and rate at the next node.
    fn tell(&self, along: &mut Covariance, p: &Square<N>, s: &Columns<N>) {
        let node = along.states.len();
        along.states.push(self.si(&(p + self.of_parameters(s))));
        // δΩ = J₀⁻¹ (δΠ − δJ Ω*), with the momentum of the true body.
        let momenta = Self::part(&(p + self.of_parameters(&(s - self.of_known_rate(node)))));
        let to_rates =
            self.plan.momentum_of_rate().try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN));
        along.rates.push(to_rates * momenta.fixed_view::<3, 3>(3, 3) * to_rates.transpose());
    }

    /// Completes the result with the terminal covariance, converted from momenta to rates.
    fn ended(&self, along: Covariance, end: &Matrix6, moved: &Columns<N>) -> Covariance {
        let to_rates = self.of_rates().try_inverse().unwrap_or_else(|| Matrix6::repeat(f64::NAN));
        let columns = Self::whole(&to_rates) * (moved - self.of_known_rate(self.plan.count()));
        let end_of_parameters = Self::part(&self.of_parameters(&columns));
        Covariance {
            end: to_rates * end * to_rates.transpose() + end_of_parameters,
            end_of_parameters,
            end_by_parameter: columns
                .column_iter()
                .map(|column| column.fixed_rows::<6>(0).into_owned())
                .collect(),
            ..along
        }
    }

    /// Returns the gain rows of a step, from the scaled state to SI inputs.
    fn rows_of(&self, gains: &Gains, step: usize) -> Vec<RowSVector<f64, N>> {
        let entry = |row: &[f64], column: usize| row.get(column).map_or(0.0, |k| k * self.plan.unit(column));
        let row = |row: &[f64]| RowSVector::from_fn(|_, column| entry(row, column));
        gains.row(step).chunks_exact(gains.states).map(row).collect()
    }

    fn input_deviations(&self, gains: &Gains, step: usize, seen: &Square<N>) -> Vec<f64> {
        let deviation = |row: &RowSVector<f64, N>| (row * seen * row.transpose())[0].max(0.0).sqrt();
        self.rows_of(gains, step).iter().map(deviation).collect()
    }

    /// Returns the standard deviations of the change of the corrections, from the tick before node
    /// `k` to the tick that begins at this node:
    ///
    /// ```text
    /// K (z_0 + ν + C p) − K' (z_j + ν' + C' p) = (K − K'Φ) z_0 + (K + K'Ψ) ν − K'(w + ν') + …
    /// ```
    fn changes(
        &self,
        gains: &Gains,
        k: usize,
        before: &Tick<N>,
        after: &Tick<N>,
        sensors: &Square<N>,
    ) -> Vec<f64> {
        let rows = self.rows_of(gains, k - 1).into_iter().zip(self.rows_of(gains, k));
        let deviation = |(old, new): (RowSVector<f64, N>, RowSVector<f64, N>)| {
            let of_state = old - new * before.state;
            let of_sensors = old + new * before.sensors;
            let of_parameters = old * &before.seen - new * &after.seen;
            let parameters = of_parameters.iter().zip(&self.uncertainty.parameters);
            let variance = (of_state * before.p * of_state.transpose())[0]
                + (of_sensors * sensors * of_sensors.transpose())[0]
                + (new * (before.noise + sensors) * new.transpose())[0]
                + parameters.map(|(by, (_, _, sigma))| (by * sigma).powi(2)).sum::<f64>();
            variance.max(0.0).sqrt()
        };
        rows.map(deviation).collect()
    }
}

/// The steps over which one correction is held.
struct Tick<const N: usize> {
    /// The gain `B K` of the tick.
    gain: SMatrix<f64, 3, N>,
    /// Covariance of the state at the start of the tick, without the parameters.
    p: Square<N>,
    /// The sensitivities `C` of the measurement to the parameters at the start of the tick.
    measured: Columns<N>,
    /// The sum `S + C` of the sensitivities of state and measurement at the start of the tick.
    seen: Columns<N>,
    /// The matrix `Φ` from the state at the start of the tick to the present state.
    state: Square<N>,
    /// The matrix `Ψ`, the negative response of the present state to the error of the measurement.
    sensors: Square<N>,
    /// The covariance of the present state due to torque noise since the start of the tick.
    noise: Square<N>,
}

impl<const N: usize> Tick<N> {
    /// Advances the tick by one step.
    fn go(&mut self, a: &Square<N>, b: &SMatrix<f64, N, 3>, noise: &Square<N>) {
        let answered = b * self.gain;
        self.state = a * self.state - answered;
        self.sensors = a * self.sensors + answered;
        self.noise = a * self.noise * a.transpose() + noise;
    }

    /// Returns the contributions of initial covariance, sensor noise and torque noise to the
    /// present covariance of the state.
    fn parts(&self, sensors: &Square<N>) -> [Square<N>; 3] {
        [
            self.state * self.p * self.state.transpose(),
            self.sensors * sensors * self.sensors.transpose(),
            self.noise,
        ]
    }

    fn covariance(&self, sensors: &Square<N>) -> Square<N> {
        let [state, sensors, noise] = self.parts(sensors);
        state + sensors + noise
    }
}

/// Returns the 6×3 matrix `[0; I]`, which selects the momenta.
fn momentum_rows() -> Matrix6x3 {
    Matrix6::identity().fixed_view::<6, 3>(0, 3).into_owned()
}

/// Returns the state `[0; vector]`, whose momentum is `vector`.
fn momenta(vector: &Vector3) -> Vector6 {
    Vector6::new(0.0, 0.0, 0.0, vector.x, vector.y, vector.z)
}
