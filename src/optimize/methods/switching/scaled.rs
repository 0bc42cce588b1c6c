//! From a maneuver to an extremal in scaled units, and back.

use super::extremal::{Extremal, Law};
use crate::maneuver::problem::Problem;
use crate::{Matrix3, Vector3};

/// Units of a maneuver of minimum time: `det J = 1` and `det B Bᵀ = 1`, so that durations are of the order of the
/// square root of the angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeUnits {
    pub time: f64,
    pub torque: f64,
}

impl TimeUnits {
    /// Unit of momentum [N·m·s].
    pub fn momentum(&self) -> f64 {
        self.torque * self.time
    }
}

/// The scaled maneuver; `None` where the torques do not span the space or a number is out of range.
pub(crate) fn scaled(problem: &Problem) -> Option<(Extremal, TimeUnits)> {
    let j = *problem.body.inertia.j();
    let inertia = j.determinant().cbrt();
    let set = &problem.actuation.torque;
    let (law, torque) = match (&set.limits().size, set.limits().norm) {
        (Some(size), _) => {
            let axes: Vec<Vector3> = set.axes().iter().zip(size).map(|(axis, size)| *size * axis).collect();
            let gram: Matrix3 = axes.iter().map(|axis| axis * axis.transpose()).sum();
            let unit = gram.determinant().powf(1.0 / 6.0);
            (Law::Inputs(axes.iter().map(|axis| axis / unit).collect()), unit)
        }
        (None, Some(norm)) => (Law::Norm(1.0), norm),
        (None, None) => return None,
    };
    let time = (inertia / torque).sqrt();
    let extremal = Extremal {
        j: j / inertia,
        j_inverse: (j / inertia).try_inverse()?,
        law,
        middle: Vector3::zeros(),
        start_rate: time * problem.start.angular_velocity,
        end_rate: time * problem.end.angular_velocity,
        end_attitude: problem.start.attitude.tr_mul(&problem.end.attitude),
    };
    let usable = torque > 0.0 && time.is_finite() && time > 0.0;
    usable.then_some((extremal, TimeUnits { time, torque }))
}

/// The inputs that give a scaled torque: at their limits by their signs, otherwise of least effort.
pub(crate) fn inputs(problem: &Problem, units: &TimeUnits, torque: &Vector3) -> Option<Vec<f64>> {
    let weighted = problem.objective.weights().torque(&problem.actuation);
    let shared = weighted.authority.try_inverse()? * (units.torque * torque);
    Some((&weighted.gain * shared).iter().copied().collect())
}
