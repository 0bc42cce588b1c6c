//! A maneuver of minimum time or fuel in scaled units, and the inputs that minimise its
//! Hamiltonian.
//!
//! Every input has the range `v ∈ [−1, 1]` about the middle of its limits, along an axis that has
//! its half range for length; what it costs is `c_j v_j` beside a constant, which belongs to the
//! price of time. The Hamiltonian is least at `v_j = −sign(s_j)` with the switching function
//! `s_j = a_j·e + c_j`; smoothed,
//!
//! ```text
//! min over v of  s v + ε (1 − √(1 − v²))  =  ε − √(s² + ε²) ,      v = −s/√(s² + ε²)
//! ```
//!
//! and under a limit U of the norm of the torque `τ = −U e/√(|e|² + ε²)`. Where the norm costs
//! `c|τ|`, its size is one more such input, `τ = −½U(1 + v) e/ρ` with `ρ = √(|e|² + ε²)` and
//! `s = ½U(c − ρ)`: the torque is off where `|e| < c`, and on otherwise it turns with the costate.
//! What is added to a cost of inputs is not negative, so a smooth extremal is a feasible maneuver,
//! and dearer than the optimum by no more than `∫ Σ ε (1 − √(1 − v²)) dt`, to first order; of the
//! norm up to terms of ε².
//!
//! # What if no list of arcs is exact?
//!
//! What smoothing costs is the ε times the length of the singular arcs, and an ε that is small is
//! worth nothing on intervals that do not see it: inputs jump within them. So the last extremal
//! stands on intervals that are halved until no input changes by more than a third of its range on
//! one, and is carried to ε = 2e-5 with a residual of 1e-8 (`switching/smooth`, `settle`). Where
//! the branch ends before, as one does where two extremals meet, biases tip it to those that go on
//! (`tipped`). Of the 1500 public cases the gap of singular ones went from 1e-4 to 1e-6 of a unit
//! of time by it, and those that were longer than published from 15 to 1. The last one went with
//! larger biases for bodies far from a sphere.

use super::tuning::arcs::DETERMINED;
use super::tuning::branches::ASIDE;
use super::work::StopRequest;
use crate::numerics::eight::Number;
use crate::numerics::three::{Matrix, Vector, dot, scaled, splat, sum, written};
use crate::{Matrix3, Vector3};

/// What limits the torque.
#[derive(Clone, Debug)]
pub(crate) enum TorqueLimit {
    /// Inputs in `[−1, 1]` along these axes.
    Inputs(Vec<Vector3>),
    /// The norm of the torque.
    Norm(f64),
}

/// The least Hamiltonian over the torque.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LawResponse<T: Number = f64> {
    /// The torque that makes it least.
    pub torque: Vector<T>,
    /// `G = −∂τ/∂e`.
    pub stiffness: Matrix<T>,
    /// `e·τ + Σ c_j v_j` and what smoothing adds.
    pub minimum: T,
    /// `Σ c_j v_j`, or `c|τ|`.
    pub running: T,
}

/// The law on an arc between two switches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArcLaw {
    /// Held torque and running cost; its `minimum` is not known.
    held: LawResponse,
    /// Limit and price of the norm, where the torque has its full norm and turns with the costate.
    turning: Option<(f64, f64)>,
}

impl ArcLaw {
    /// At the costate `e`.
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

    /// Where the torque does not answer to the costate: what it is.
    pub fn held(&self) -> Option<&LawResponse> {
        self.turning.is_none().then_some(&self.held)
    }

    /// `Σ c_j v_j`, or `c|τ|`.
    pub fn running(&self) -> f64 {
        self.held.running
    }
}

/// A maneuver of minimum time or fuel, scaled: from the identity.
#[derive(Clone, Debug)]
pub(crate) struct Extremal {
    pub j: Matrix3,
    pub j_inverse: Matrix3,
    pub law: TorqueLimit,
    /// `c_j`, one for each axis of [`TorqueLimit::Inputs`]: 0 where only time counts. Of
    /// [`TorqueLimit::Norm`] the price of the norm, where it has one.
    pub costs: Vec<f64>,
    /// What a unit of time costs beside the inputs about the middle of their limits.
    pub time_price: f64,
    /// The duration where it is given: the Hamiltonian is then constant, and need not vanish.
    pub given_duration: Option<f64>,
    /// Torque of all inputs in the middle of their limits.
    pub middle: Vector3,
    pub start_rate: Vector3,
    pub end_rate: Vector3,
    pub end_attitude: Matrix3,
    /// Ends the sweeps over fine grids.
    pub halt: StopRequest,
}

/// What is added to the switching functions, in units of ε, to tip a path from one branch to
/// another: a constant and a linear part for each component of the costate.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bias {
    pub constant: Vector3,
    pub linear: Vector3,
}

impl Bias {
    /// Whether it is one.
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
    /// The same maneuver for another inertia.
    pub fn with_inertia(&self, j: Matrix3, rate_factor: f64) -> Option<Self> {
        Some(Self {
            j,
            j_inverse: j.try_inverse()?,
            start_rate: rate_factor * self.start_rate,
            end_rate: rate_factor * self.end_rate,
            ..self.clone()
        })
    }

    /// The same maneuver in another duration, or in one that is sought.
    pub fn lasting(&self, given_duration: Option<f64>) -> Self {
        Self { given_duration, ..self.clone() }
    }

    /// The maneuver backwards in time: from its end to its start with rates of the other sign,
    /// under the same torques.
    ///
    /// With `(R, Π)(t)` and the costates `(M, e)` an extremal, `(R_eᵀ R, −Π)(T − t)` and
    /// `(−R_eᵀ M, e)` are one of this maneuver ([`Path::reversed`](super::smooth::Path::reversed)):
    /// the Hamiltonian is even in momentum and `M` together.
    pub fn reversed(&self) -> Self {
        Self {
            start_rate: -self.end_rate,
            end_rate: -self.start_rate,
            end_attitude: self.end_attitude.transpose(),
            ..self.clone()
        }
    }

    /// The smoothed law at the costate `e`, moved by `ε` times `bias`.
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
                    // One division instead of two: they and the root take longest here.
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

    /// The law on an arc, on which every input keeps its sign.
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

    /// The law under a torque that is held whatever the costate, and what its inputs cost.
    pub fn holding(torque: &Vector3, running: f64) -> ArcLaw {
        let held = LawResponse { torque: *torque, stiffness: Matrix3::zeros(), minimum: f64::NAN, running };
        ArcLaw { held, turning: None }
    }

    /// The inputs of the smoothed law, each in `[−1, 1]`; one where the norm costs, none where it
    /// is limited alone.
    pub fn inputs(&self, e: &Vector3, epsilon: f64) -> Vec<f64> {
        (0..self.switching_count()).map(|input| self.level(input, e, epsilon)).collect()
    }

    /// One of them.
    pub fn level(&self, input: usize, e: &Vector3, epsilon: f64) -> f64 {
        let s = self.switching(input, e);
        -s / (s * s + epsilon * epsilon).sqrt()
    }

    /// Fewest switches of arcs at the limits: those of three axes, or where fuel counts those of
    /// one burn.
    pub fn fewest_switches(&self) -> usize {
        if self.counts_fuel() { 1 } else { DETERMINED }
    }

    /// Whether inputs cost something, and not time alone.
    pub fn counts_fuel(&self) -> bool {
        self.costs.iter().any(|cost| *cost != 0.0)
    }

    /// Whether fuel is counted by inputs that are on for some of the time.
    pub fn times_pulses(&self) -> bool {
        self.counts_fuel() && matches!(self.law, TorqueLimit::Inputs(_))
    }

    /// What a unit of time costs beside the inputs that are on for it.
    pub fn price_of_time(&self) -> f64 {
        self.time_price - self.price_of_idling()
    }

    /// The same maneuver with another price of time.
    pub fn priced(&self, price: f64) -> Self {
        Self { time_price: price + self.price_of_idling(), ..self.clone() }
    }

    /// What inputs cost in the middle of their limits; the norm of the torque has no middle.
    fn price_of_idling(&self) -> f64 {
        if matches!(self.law, TorqueLimit::Inputs(_)) { self.costs.iter().sum() } else { 0.0 }
    }

    /// About what a unit of impulse costs: the mean over the inputs.
    pub fn price_of_impulse(&self) -> f64 {
        match &self.law {
            TorqueLimit::Norm(limit) => self.costs.iter().sum::<f64>() / limit,
            TorqueLimit::Inputs(axes) => {
                let each = axes.iter().zip(&self.costs).map(|(axis, cost)| cost / axis.norm());
                each.sum::<f64>() / axes.len() as f64
            }
        }
    }

    /// Whether the shortest time is sought under a limit of each input.
    pub fn seeks_time(&self) -> bool {
        !self.counts_fuel() && self.given_duration.is_none() && matches!(self.law, TorqueLimit::Inputs(_))
    }

    /// Number of switching functions.
    pub fn switching_count(&self) -> usize {
        self.costs.len()
    }

    /// The switching function of an input at the costate `e`.
    pub fn switching(&self, input: usize, e: &Vector3) -> f64 {
        match &self.law {
            TorqueLimit::Inputs(axes) => axes[input].dot(e) + self.costs[input],
            TorqueLimit::Norm(limit) => 0.5 * limit * (self.costs[input] - e.norm()),
        }
    }

    /// Its derivative with respect to the costate.
    pub fn switching_slope(&self, input: usize, e: &Vector3) -> Vector3 {
        match &self.law {
            TorqueLimit::Inputs(axes) => axes[input],
            TorqueLimit::Norm(limit) => -0.5 * limit / e.norm() * e,
        }
    }

    /// `A⁻ᵀ` of the first three axes that span the space, of determinant 1: what is of one size in
    /// these coordinates switches each of these inputs alike, in whatever axes the body is
    /// described.
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

    /// How much more the inputs give along one axis than along another: 1 where all are alike.
    pub fn unlikeness(&self) -> f64 {
        let values = self.authority().symmetric_eigenvalues();
        (values.max() / values.min()).sqrt()
    }

    /// The largest principal moment over the smallest: 1 of a sphere.
    pub fn roundness(&self) -> f64 {
        let values = self.j.symmetric_eigenvalues();
        values.max() / values.min()
    }

    /// `Σ a aᵀ` of the axes: all are alike under a limit of the norm.
    pub fn authority(&self) -> Matrix3 {
        match &self.law {
            TorqueLimit::Inputs(axes) => axes.iter().map(|axis| axis * axis.transpose()).sum(),
            TorqueLimit::Norm(_) => Matrix3::identity(),
        }
    }

    /// The axes of the inputs; none under a limit of the norm.
    pub fn axes(&self) -> &[Vector3] {
        match &self.law {
            TorqueLimit::Inputs(axes) => axes,
            TorqueLimit::Norm(_) => &[],
        }
    }

    /// The least `e·τ + Σ c_j v_j` that the limits allow.
    pub fn least(&self, e: &Vector3) -> f64 {
        let least = match &self.law {
            TorqueLimit::Inputs(axes) => (0..axes.len()).map(|input| self.switching(input, e).abs()).sum(),
            TorqueLimit::Norm(limit) => limit * (e.norm() - self.costs.first().unwrap_or(&0.0)).max(0.0),
        };
        e.dot(&self.middle) - least
    }
}
