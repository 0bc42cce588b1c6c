//! What held inputs of a maneuver do to its limits.

use slewkit::maneuver::Problem;
use slewkit::mechanics::{ActuatorSet, LimitKind};
use slewkit::numerics::figures::significant;

/// Momentum of each reaction wheel at the start, and its rate of change: what the body gains the wheel loses.
pub fn wheel_momenta(problem: &Problem, inputs: Option<&[f64]>) -> Vec<(f64, f64)> {
    let Some(wheels) = &problem.actuation.wheels else { return Vec::new() };
    let torque = |wheel: usize| inputs.map_or(0.0, |inputs| inputs.get(wheel).copied().unwrap_or(0.0));
    wheels.momentum.iter().enumerate().map(|(wheel, momentum)| (*momentum, -torque(wheel))).collect()
}

/// The limits that `inputs` exceed, in words. The number of inputs may be wrong.
pub fn exceeded(problem: &Problem, inputs: Option<&[f64]>) -> Vec<String> {
    let actuation = &problem.actuation;
    let mut found = Vec::new();
    if let Some(inputs) = inputs.filter(|inputs| inputs.len() == actuation.count()) {
        let (forces, torques) = inputs.split_at(actuation.force.as_ref().map_or(0, ActuatorSet::count));
        let channels = [(actuation.force.as_ref(), forces, true), (Some(&actuation.torque), torques, false)];
        for (channel, inputs, of_force) in channels {
            let Some(channel) = channel else { continue };
            let unit = if of_force { "N" } else { "N·m" };
            let shown = |value: f64| significant(value, 4);
            for (index, (input, limit)) in
                inputs.iter().zip(channel.limits().size.iter().flatten()).enumerate()
            {
                if input.abs() > *limit {
                    let name = actuation.limit_name(LimitKind::Size, of_force);
                    let (number, input, limit) = (index + 1, shown(*input), shown(*limit));
                    found.push(format!(
                        "input {number} is {input} {unit}, above its {name} of {limit} {unit}"
                    ));
                }
            }
            let norm = channel.output(inputs).norm();
            if let Some(limit) = channel.limits().norm.filter(|limit| norm > *limit) {
                let name = actuation.limit_name(LimitKind::Norm, of_force);
                found.push(format!(
                    "the inputs add up to {} {unit}, above the {name} of {} {unit}",
                    shown(norm),
                    shown(limit)
                ));
            }
        }
    }
    let limits = actuation.wheels.iter().flat_map(|wheels| &wheels.momentum_limit);
    for (index, ((start, rate), limit)) in wheel_momenta(problem, inputs).into_iter().zip(limits).enumerate()
    {
        // Linear in time: outside from when it crosses one of ±limit.
        let crossing = (limit - start * rate.signum()) / rate.abs();
        if rate.abs() > 0.0 && crossing < problem.duration {
            let (time, limit) = (significant(crossing.max(0.0), 4), significant(*limit, 4));
            let wheel = index + 1;
            found.push(format!(
                "wheel {wheel} exceeds its momentum limit of {limit} N·m·s from t = {time} s on"
            ));
        }
    }
    found
}
