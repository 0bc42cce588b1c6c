//! A minimum-time or minimum-fuel maneuver in scaled units, and the inputs that minimise its
//! Hamiltonian.
//!
//! Every input has the range `v ∈ [−1, 1]` about the middle of its limits. Its axis has half the
//! range for its length. Its cost is `c_j v_j` plus a constant, which is included in the price of
//! time. The minimum of the Hamiltonian is at `v_j = −sign(s_j)` with the switching function
//! `s_j = a_j·e + c_j`. With smoothing it is
//!
//! ```text
//! min over v of  s v + ε (1 − √(1 − v²))  =  ε − √(s² + ε²) ,      v = −s/√(s² + ε²)
//! ```
//!
//! Under a limit U on the norm of the torque, the smoothed law is `τ = −U e/√(|e|² + ε²)`. If the
//! norm costs `c|τ|`, it is one more such input, `τ = −½U(1 + v) e/ρ` with `ρ = √(|e|² + ε²)` and
//! `s = ½U(c − ρ)`: the torque is off where `|e| < c`, and elsewhere it turns with the costate. The
//! smoothing term is not negative, so a smoothed extremal is a feasible maneuver. To first order it
//! costs at most `∫ Σ ε (1 − √(1 − v²)) dt` more than the optimum; under a cost of the norm, up to
//! terms of ε².
//!
//! # What if no switching structure is exact?
//!
//! The cost of smoothing is ε times the length of the singular arcs. A small ε is of no use on
//! intervals that do not resolve it, because inputs then jump within an interval. The last extremal
//! is therefore computed on intervals that are bisected until no input changes by more than a
//! fifth of its range on one, and is continued to ε = 2e-5 with a residual of 1e-9
//! (`switching/smooth`, `settle`). If the branch ends earlier, for example where two extremals
//! meet, perturbations lead to the branches that continue (`tipped`). In the 1500 public cases this
//! reduced the gap of singular ones from 1e-4 to 1e-6 of a unit of time, and the number of cases
//! longer than published from 15 to 1. Larger perturbations for bodies far from a sphere resolved
//! the last one.

use super::tuning::arcs::DETERMINED;
use super::tuning::branches::ASIDE;
use super::work::StopRequest;
use crate::numerics::eight::Number;
use crate::numerics::three::{Matrix, Vector, dot, scaled, splat, sum, written};
use crate::{Matrix3, Vector3};

/// Limit on the torque: a limit on each input, or a limit on the norm of the torque.
#[derive(Clone, Debug)]
pub(crate) enum TorqueLimit {
    /// Inputs in `[−1, 1]`. Each axis is the torque of one input at level 1, relative to its torque
    /// at level 0.
    Inputs(Vec<Vector3>),
    /// Largest norm of the torque.
    Norm(f64),
}

/// The minimum of the Hamiltonian over the torque, at one costate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LawResponse<T: Number = f64> {
    /// Torque that minimises the Hamiltonian.
    pub torque: Vector<T>,
    /// Stiffness `G = −∂τ/∂e` of the control law.
    pub stiffness: Matrix<T>,
    /// Minimum of `e·τ + Σ c_j v_j`, including the smoothing term.
    pub minimum: T,
    /// Cost of the inputs per unit of time: `Σ c_j v_j`, or `c|τ|`.
    pub running: T,
}

/// The control law on an arc between two switches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArcLaw {
    /// Held torque and its running cost; `minimum` is not a number.
    held: LawResponse,
    /// Limit and price of the norm of the torque, if the norm is at its limit and the direction
    /// follows the costate; `None` if the torque is held.
    turning: Option<(f64, f64)>,
}

impl ArcLaw {
    /// Returns the response of the control law at the costate `e`.
    #[inline(always)]
    pub fn at(&self, e: &Vector3) -> LawResponse {
        let Some((limit, cost)) = self.turning else { return self.held };
        let size = e.norm();
        let along = e / size;
        LawResponse {
            torque: -limit * along,
            stiffness: (limit / size) * (Matrix3::identity() - along * along.transpose()),
            minimum: limit * (cost - size),
            running: self.held.running,
        }
    }

    /// Returns the held torque; `None` if the torque depends on the costate.
    pub fn held(&self) -> Option<&LawResponse> {
        self.turning.is_none().then_some(&self.held)
    }

    /// Returns the running cost `Σ c_j v_j`, or `c|τ|`.
    pub fn running(&self) -> f64 {
        self.held.running
    }
}

/// A minimum-time or minimum-fuel maneuver in scaled units. The initial attitude is the identity.
#[derive(Clone, Debug)]
pub(crate) struct Extremal {
    pub j: Matrix3,
    pub j_inverse: Matrix3,
    pub law: TorqueLimit,
    /// Prices `c_j` of the inputs, one for each axis of [`TorqueLimit::Inputs`]; all 0 if only time
    /// counts. For [`TorqueLimit::Norm`] the price of the norm, or empty if the norm costs nothing.
    pub costs: Vec<f64>,
    /// Cost of a unit of time when all inputs are in the middle of their limits.
    pub time_price: f64,
    /// The duration if it is given; the Hamiltonian is then constant and need not vanish. `None` if
    /// the duration is free.
    pub given_duration: Option<f64>,
    /// Torque when all inputs are in the middle of their limits.
    pub middle: Vector3,
    pub start_rate: Vector3,
    pub end_rate: Vector3,
    pub end_attitude: Matrix3,
    /// Request to stop that the sweeps over fine grids poll.
    pub halt: StopRequest,
}

/// Symmetry-breaking perturbation of the costate in the switching functions, in units of ε: a
/// constant and a part that is linear in time.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bias {
    pub constant: Vector3,
    pub linear: Vector3,
}

impl Bias {
    /// Returns whether the perturbation is nonzero.
    pub fn tips(&self) -> bool {
        self.constant != Vector3::zeros() || self.linear != Vector3::zeros()
    }

    #[inline(always)]
    pub fn at<T: Number>(&self, fraction: T) -> Vector<T> {
        let along = T::of(2.0) * fraction - T::of(1.0);
        sum(&splat(&self.constant), &scaled(along, &splat(&self.linear)))
    }
}

impl Extremal {
    /// Returns the maneuver with another inertia and with boundary rates multiplied by
    /// `rate_factor`.
    pub fn with_inertia(&self, j: Matrix3, rate_factor: f64) -> Option<Self> {
        Some(Self {
            j,
            j_inverse: j.try_inverse()?,
            start_rate: rate_factor * self.start_rate,
            end_rate: rate_factor * self.end_rate,
            ..self.clone()
        })
    }

    /// Returns the maneuver with another given duration, or with a free duration for `None`.
    pub fn lasting(&self, given_duration: Option<f64>) -> Self {
        Self { given_duration, ..self.clone() }
    }

    /// Returns the time-reversed maneuver: from the terminal to the initial attitude, with rates of
    /// opposite sign, under the same torques.
    ///
    /// If `(R, Π)(t)` with the costates `(M, e)` is an extremal, then `(R_eᵀ R, −Π)(T − t)` with
    /// `(−R_eᵀ M, e)` is an extremal of this maneuver
    /// ([`Path::reversed`](super::smooth::Path::reversed)), because the Hamiltonian is even in
    /// momentum and `M` together.
    pub fn reversed(&self) -> Self {
        Self {
            start_rate: -self.end_rate,
            end_rate: -self.start_rate,
            end_attitude: self.end_attitude.transpose(),
            ..self.clone()
        }
    }

    /// Returns the response of the smoothed law at the costate `e` with a perturbation of `ε` times
    /// `bias`.
    #[inline(always)]
    pub fn smooth<T: Number>(&self, e: &Vector<T>, epsilon: f64, bias: &Vector<T>) -> LawResponse<T> {
        let epsilon = T::of(epsilon);
        let e2 = epsilon * epsilon;
        let (none, one) = (T::of(0.0), T::of(1.0));
        let mut torque = splat(&self.middle);
        let mut stiffness = written(|_, _| none);
        let (mut minimum, mut running) = (dot(e, &torque), none);
        match &self.law {
            TorqueLimit::Inputs(axes) => {
                for (axis, cost) in axes.iter().zip(&self.costs) {
                    let (axis, cost) = (splat(axis), T::of(*cost));
                    let s = dot(&axis, e) + cost + epsilon * dot(&axis, bias);
                    let root = (s * s + e2).sqrt();
                    // One division instead of two: divisions and the square root dominate the time.
                    let inverse = one / root;
                    let v = -s * inverse;
                    torque = sum(&torque, &scaled(v, &axis));
                    running = running + cost * v;
                    minimum = minimum + (epsilon - root);
                    let weighted = scaled(e2 * inverse * inverse * inverse, &axis);
                    stiffness =
                        written(|row, column| stiffness[(row, column)] + weighted[row] * axis[column]);
                }
            }
            TorqueLimit::Norm(limit) => {
                let limit = T::of(*limit);
                let e = sum(e, &scaled(epsilon, bias));
                let rho2 = dot(&e, &e) + e2;
                let rho = rho2.sqrt();
                let along = written(|row, column| e[row] * e[column] / rho2);
                let across =
                    written(|row, column| (if row == column { one } else { none }) - along[(row, column)]);
                match self.costs.first() {
                    None => {
                        let size = limit / rho;
                        torque = sum(&torque, &scaled(-size, &e));
                        minimum = minimum + limit * (epsilon - rho);
                        stiffness = written(|row, column| size * across[(row, column)]);
                    }
                    Some(cost) => {
                        let cost = T::of(*cost);
                        let half = T::of(0.5) * limit;
                        let s = half * (cost - rho);
                        let root = (s * s + e2).sqrt();
                        let size = half * (one - s / root);
                        torque = sum(&torque, &scaled(-(size / rho), &e));
                        running = running + cost * dot(&torque, &torque).sqrt();
                        minimum = minimum + (s + epsilon - root);
                        let growth = half * half * e2 / (root * root * root);
                        stiffness = written(|row, column| {
                            growth * along[(row, column)] + size / rho * across[(row, column)]
                        });
                    }
                }
            }
        }
        LawResponse { torque, stiffness, minimum, running }
    }

    /// Returns the control law on an arc on which the inputs have these signs.
    pub fn on_arc(&self, signs: &[f64]) -> ArcLaw {
        let turning = match self.law {
            TorqueLimit::Norm(limit) if signs.iter().all(|sign| *sign > 0.0) => {
                Some((limit, self.costs.first().copied().unwrap_or(0.0)))
            }
            _ => None,
        };
        let pairs = self.axes().iter().zip(signs);
        let torque = pairs.fold(self.middle, |sum, (axis, sign)| sum + *sign * axis);
        let running = match turning {
            Some((limit, cost)) => limit * cost,
            None if self.axes().is_empty() => 0.0,
            None => self.costs.iter().zip(signs).map(|(cost, sign)| cost * sign).sum(),
        };
        ArcLaw { turning, ..Self::holding(&torque, running) }
    }

    /// Returns the control law of a torque that does not depend on the costate; `running` is the
    /// cost of its inputs per unit of time.
    pub fn holding(torque: &Vector3, running: f64) -> ArcLaw {
        let held = LawResponse { torque: *torque, stiffness: Matrix3::zeros(), minimum: f64::NAN, running };
        ArcLaw { held, turning: None }
    }

    /// Returns the inputs of the smoothed law, each in `[−1, 1]`. There is one input if the norm of
    /// the torque has a price, and none if the norm is only limited.
    pub fn inputs(&self, e: &Vector3, epsilon: f64) -> Vec<f64> {
        (0..self.switching_count()).map(|input| self.level(input, e, epsilon)).collect()
    }

    /// Returns one input of the smoothed law, in `[−1, 1]`.
    pub fn level(&self, input: usize, e: &Vector3, epsilon: f64) -> f64 {
        let s = self.switching(input, e);
        -s / (s * s + epsilon * epsilon).sqrt()
    }

    /// Returns the smallest number of switches of a plan of arcs: five, which determine the
    /// costates, or one (a single burn) if fuel counts.
    pub fn fewest_switches(&self) -> usize {
        if self.counts_fuel() { 1 } else { DETERMINED }
    }

    /// Returns whether any input has a price; if not, only time counts.
    pub fn counts_fuel(&self) -> bool {
        self.costs.iter().any(|cost| *cost != 0.0)
    }

    /// Returns whether fuel is a sum over separate inputs of price times on-time; false if only
    /// time counts or the norm of the torque is limited.
    pub fn times_pulses(&self) -> bool {
        self.counts_fuel() && matches!(self.law, TorqueLimit::Inputs(_))
    }

    /// Returns the cost of a unit of time with all inputs off.
    pub fn price_of_time(&self) -> f64 {
        self.time_price - self.price_of_idling()
    }

    /// Returns the maneuver with another price of time.
    pub fn priced(&self, price: f64) -> Self {
        Self { time_price: price + self.price_of_idling(), ..self.clone() }
    }

    /// Returns the cost of the inputs in the middle of their limits; 0 under a norm limit, which
    /// has no middle.
    fn price_of_idling(&self) -> f64 {
        if matches!(self.law, TorqueLimit::Inputs(_)) { self.costs.iter().sum() } else { 0.0 }
    }

    /// Returns the approximate cost of a unit of angular impulse: the mean over the inputs.
    pub fn price_of_impulse(&self) -> f64 {
        match &self.law {
            TorqueLimit::Norm(limit) => self.costs.iter().sum::<f64>() / limit,
            TorqueLimit::Inputs(axes) => {
                let each = axes.iter().zip(&self.costs).map(|(axis, cost)| cost / axis.norm());
                each.sum::<f64>() / axes.len() as f64
            }
        }
    }

    /// Returns whether this is a minimum-time problem with a limit on each input.
    pub fn seeks_time(&self) -> bool {
        !self.counts_fuel() && self.given_duration.is_none() && matches!(self.law, TorqueLimit::Inputs(_))
    }

    /// Returns the number of switching functions.
    pub fn switching_count(&self) -> usize {
        self.costs.len()
    }

    /// Returns the switching function of an input at the costate `e`.
    pub fn switching(&self, input: usize, e: &Vector3) -> f64 {
        match &self.law {
            TorqueLimit::Inputs(axes) => axes[input].dot(e) + self.costs[input],
            TorqueLimit::Norm(limit) => 0.5 * limit * (self.costs[input] - e.norm()),
        }
    }

    /// Returns the derivative of the switching function of an input with respect to the costate.
    pub fn switching_slope(&self, input: usize, e: &Vector3) -> Vector3 {
        match &self.law {
            TorqueLimit::Inputs(axes) => axes[input],
            TorqueLimit::Norm(limit) => -0.5 * limit / e.norm() * e,
        }
    }

    /// Returns `A⁻ᵀ`, scaled to determinant 1, where the columns of `A` are the first three input
    /// axes that span the space. A perturbation of a given size in these coordinates acts equally
    /// on each of these inputs, whatever the choice of the body axes.
    pub fn alike(&self) -> Matrix3 {
        let mut columns: Vec<Vector3> = Vec::with_capacity(3);
        let mut across: Vec<Vector3> = Vec::with_capacity(3);
        for axis in self.axes() {
            let rest = across.iter().fold(*axis, |rest, unit| rest - unit * unit.dot(axis));
            if columns.len() < 3 && rest.norm() > ASIDE * axis.norm() {
                across.push(rest.normalize());
                columns.push(*axis);
            }
        }
        let [first, second, third] = columns[..] else { return Matrix3::identity() };
        let axes = Matrix3::from_columns(&[first, second, third]);
        let size = axes.determinant().abs().cbrt();
        (axes / size).transpose().try_inverse().unwrap_or_else(Matrix3::identity)
    }

    /// Returns the ratio of the largest to the smallest control authority over all directions: 1 if
    /// all directions are equal.
    pub fn unlikeness(&self) -> f64 {
        let values = self.authority().symmetric_eigenvalues();
        (values.max() / values.min()).sqrt()
    }

    /// Returns the ratio of the largest to the smallest principal moment of inertia: 1 for a
    /// sphere.
    pub fn roundness(&self) -> f64 {
        let values = self.j.symmetric_eigenvalues();
        values.max() / values.min()
    }

    /// Returns the control authority `Σ a aᵀ` over the input axes; the identity under a norm limit.
    pub fn authority(&self) -> Matrix3 {
        match &self.law {
            TorqueLimit::Inputs(axes) => axes.iter().map(|axis| axis * axis.transpose()).sum(),
            TorqueLimit::Norm(_) => Matrix3::identity(),
        }
    }

    /// Returns the axes of the inputs; an empty slice under a norm limit.
    pub fn axes(&self) -> &[Vector3] {
        match &self.law {
            TorqueLimit::Inputs(axes) => axes,
            TorqueLimit::Norm(_) => &[],
        }
    }

    /// Returns the minimum of `e·τ + Σ c_j v_j` over the inputs within their limits.
    pub fn least(&self, e: &Vector3) -> f64 {
        let least = match &self.law {
            TorqueLimit::Inputs(axes) => (0..axes.len()).map(|input| self.switching(input, e).abs()).sum(),
            TorqueLimit::Norm(limit) => limit * (e.norm() - self.costs.first().unwrap_or(&0.0)).max(0.0),
        };
        e.dot(&self.middle) - least
    }
}
