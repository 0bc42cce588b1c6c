//! The limits that the held inputs of a maneuver exceed.

use slewkit::maneuver::Problem;
use slewkit::mechanics::{InputLimit, LimitKind};
use slewkit::numerics::figures::significant;

/// Returns the momentum of each reaction wheel at the start, and its rate of change, which is
/// opposite to the rate of change of the body's momentum.
pub fn wheel_momenta(problem: &Problem, inputs: Option<&[f64]>) -> Vec<(f64, f64)> {
    let Some(wheels) = &problem.actuation.wheels else { return Vec::new() };
    let torque = |wheel: usize| inputs.map_or(0.0, |inputs| inputs.get(wheel).copied().unwrap_or(0.0));
    wheels.momentum.iter().enumerate().map(|(wheel, momentum)| (*momentum, -torque(wheel))).collect()
}

/// Returns the limits that `inputs` exceed, in words. The number of inputs may be wrong.
pub fn exceeded(problem: &Problem, inputs: Option<&[f64]>) -> Vec<String> {
    let given = inputs.filter(|inputs| inputs.len() == problem.actuation.count());
    let momenta = wheel_momenta(problem, inputs);
    let shown = |value: f64| significant(value, 4);
    let mut found = Vec::new();
    for limit in problem.actuation.limits() {
        let InputLimit { kind, name, set, first, bounds, .. } = limit;
        let (unit, own) = (limit.unit(), given.map_or(&[][..], |inputs| &inputs[first..first + set.count()]));
        match kind {
            LimitKind::Size => {
                for (index, (input, bound)) in own.iter().zip(bounds).enumerate() {
                    if set.limits().one_sided && *input < 0.0 {
                        let (number, input) = (index + 1, shown(*input));
                        found.push(format!(
                            "input {number} is {input} {unit}, and a thruster cannot be negative"
                        ));
                    }
                    if input.abs() > *bound {
                        let (number, input, bound) = (index + 1, shown(*input), shown(*bound));
                        found.push(format!(
                            "input {number} is {input} {unit}, above its {name} of {bound} {unit}"
                        ));
                    }
                }
            }
            LimitKind::Norm => {
                let norm = set.output(own).norm();
                if let Some(bound) = bounds.first().filter(|bound| norm > **bound) {
                    let (norm, bound) = (shown(norm), shown(*bound));
                    found.push(format!(
                        "the inputs have the norm {norm} {unit}, above the {name} of {bound} {unit}"
                    ));
                }
            }
            // The inputs are held.
            LimitKind::Rate => {}
            LimitKind::WheelMomentum => {
                for (index, ((start, rate), bound)) in momenta.iter().zip(bounds).enumerate() {
                    // Linear in time: outside from when it crosses one of ±bound.
                    let crossing = (bound - start * rate.signum()) / rate.abs();
                    if rate.abs() > 0.0 && problem.duration.known().is_none_or(|duration| crossing < duration)
                    {
                        let (wheel, time, bound) = (index + 1, shown(crossing.max(0.0)), shown(*bound));
                        found.push(format!(
                            "wheel {wheel} exceeds its momentum limit of {bound} {unit} from t = {time} s on"
                        ));
                    }
                }
            }
        }
    }
    found
}
