//! Conversion of a maneuver to an extremal problem in scaled units, and of its inputs back.

use super::extremal::{Extremal, TorqueLimit};
use super::work::StopRequest;
use crate::maneuver::duration::Duration;
use crate::maneuver::problem::Problem;
use crate::{Matrix3, Vector3};

/// Units of a scaled minimum-time or minimum-fuel maneuver. They make `det J = 1` and
/// `det B Bᵀ = 1`, so that durations are of the order of the square root of the angle. The unit of
/// cost per time is half of the cost of the most expensive input at its limit, the full cost under
/// a norm limit, or 1 if only time counts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExtremalUnits {
    pub time: f64,
    pub torque: f64,
    /// Unit of the price of time: cost per unit of time.
    pub rate: f64,
}

impl ExtremalUnits {
    /// Returns the unit of momentum [N·m·s].
    pub fn momentum(&self) -> f64 {
        self.torque * self.time
    }

    /// Returns the unit of cost.
    pub fn cost(&self) -> f64 {
        self.rate * self.time
    }
}

/// Rule by which the inputs of the maneuver are represented by inputs of the extremal, which lie in
/// `[−1, 1]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sides {
    /// One extremal input for each input from −limit to limit: only time counts.
    Both,
    /// One extremal input for each input from 0 to the limit: a thruster.
    One,
    /// Two extremal inputs of opposite directions for each input, from 0 to the limit: both signs
    /// cost fuel.
    Pair,
}

impl Sides {
    fn of(problem: &Problem) -> Self {
        match (problem.actuation.torque.limits().one_sided, problem.objective.fuel()) {
            (true, _) => Self::One,
            (false, Some(_)) => Self::Pair,
            (false, None) => Self::Both,
        }
    }
}

/// Converts a maneuver to scaled units; `None` if the torques do not span the space or a number is
/// out of range.
pub(crate) fn scaled(problem: &Problem) -> Option<(Extremal, ExtremalUnits)> {
    let j = *problem.body.inertia.j();
    let inertia = j.determinant().cbrt();
    let set = &problem.actuation.torque;
    let (mut middle, mut costs) = (Vector3::zeros(), Vec::new());
    let (law, torque) = match (&set.limits().size, set.limits().norm) {
        (Some(size), _) => {
            let full: Vec<Vector3> = set.axes().iter().zip(size).map(|(axis, size)| *size * axis).collect();
            let gram: Matrix3 = full.iter().map(|axis| axis * axis.transpose()).sum();
            let unit = gram.determinant().powf(1.0 / 6.0);
            let half: Vec<Vector3> = full.iter().map(|axis| 0.5 / unit * axis).collect();
            let price = |input: usize| problem.objective.fuel().map_or(0.0, |fuel| fuel.price(input));
            let half_costs = size.iter().enumerate().map(|(input, size)| 0.5 * price(input) * size);
            let axes = match Sides::of(problem) {
                Sides::Both => {
                    costs.resize(full.len(), 0.0);
                    full.iter().map(|axis| axis / unit).collect()
                }
                Sides::One => {
                    middle = half.iter().sum();
                    costs.extend(half_costs);
                    half
                }
                Sides::Pair => {
                    costs.extend(half_costs.flat_map(|cost| [cost, cost]));
                    half.iter().flat_map(|axis| [*axis, -axis]).collect()
                }
            };
            (TorqueLimit::Inputs(axes), unit)
        }
        (None, Some(norm)) => {
            costs.extend(problem.objective.fuel().map(|fuel| fuel.price(0) * norm));
            (TorqueLimit::Norm(1.0), norm)
        }
        (None, None) => return None,
    };
    let dearest = costs.iter().copied().fold(0.0, f64::max);
    let rate = if dearest > 0.0 { dearest } else { 1.0 };
    for cost in &mut costs {
        *cost /= rate;
    }
    // Cost of the inputs in the middle of their limits; the norm of the torque has no middle.
    let idle = if matches!(law, TorqueLimit::Inputs(_)) { costs.iter().sum() } else { 0.0 };
    let time = (inertia / torque).sqrt();
    let extremal = Extremal {
        j: j / inertia,
        j_inverse: (j / inertia).try_inverse()?,
        law,
        time_price: problem.objective.time_price() / rate + idle,
        given_duration: match problem.duration {
            Duration::Given(duration) => Some(duration / time),
            Duration::Sought { .. } | Duration::Found { .. } => None,
        },
        costs,
        middle,
        start_rate: time * problem.start.angular_velocity,
        end_rate: time * problem.end.angular_velocity,
        end_attitude: problem.start.attitude.tr_mul(&problem.end.attitude),
        halt: StopRequest::default(),
    };
    let usable = torque > 0.0 && time.is_finite() && time > 0.0 && rate.is_finite();
    usable.then_some((extremal, ExtremalUnits { time, torque, rate }))
}

/// Converts the inputs of the extremal, `levels` in `[−1, 1]`, to the inputs of the maneuver.
pub(crate) fn inputs(problem: &Problem, levels: &[f64]) -> Vec<f64> {
    let sizes = problem.actuation.torque.limits().size.iter().flatten().enumerate();
    match Sides::of(problem) {
        Sides::Both => sizes.map(|(input, size)| size * levels[input]).collect(),
        Sides::One => sizes.map(|(input, size)| size * (0.5 + 0.5 * levels[input])).collect(),
        Sides::Pair => sizes
            .map(|(input, size)| size * (0.5 * levels[2 * input] - 0.5 * levels[2 * input + 1]))
            .collect(),
    }
}

/// Returns the index of the maneuver's input to which the extremal input `level` belongs.
pub(crate) fn input_of(problem: &Problem, level: usize) -> usize {
    if Sides::of(problem) == Sides::Pair { level / 2 } else { level }
}

/// Returns the minimum-effort inputs of the maneuver that produce a scaled torque, for a limit on
/// the norm of the torque; `None` if the inputs do not span the space.
pub(crate) fn shared(problem: &Problem, units: &ExtremalUnits, torque: &Vector3) -> Option<Vec<f64>> {
    let weighted = problem.objective.weights().torque(&problem.actuation);
    let shared = weighted.authority.try_inverse()? * (units.torque * torque);
    Some((&weighted.gain * shared).iter().copied().collect())
}
