//! Check that the held inputs of a simulated maneuver do not exceed its limits.

use slewkit::maneuver::Problem;
use slewkit::mechanics::{InputLimit, LimitKind};
use slewkit::numerics::figures::significant;

/// Returns the initial momentum of each reaction wheel \[N·m·s\], and its rate of change \[N·m\],
/// which is the negative of the torque on the body.
pub fn wheel_momenta(problem: &Problem, inputs: Option<&[f64]>) -> Vec<(f64, f64)> {
    let Some(wheels) = &problem.actuation.wheels else { return Vec::new() };
    let torque = |wheel: usize| inputs.map_or(0.0, |inputs| inputs.get(wheel).copied().unwrap_or(0.0));
    wheels.momentum.iter().enumerate().map(|(wheel, momentum)| (*momentum, -torque(wheel))).collect()
}

/// Describes the limits that `inputs` exceed. The number of inputs may be wrong, which is reported
/// elsewhere.
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
            // Held inputs are constant, so a limit on their rate of change is never exceeded.
            LimitKind::Rate => {}
            LimitKind::WheelMomentum => {
                for (index, ((start, rate), bound)) in momenta.iter().zip(bounds).enumerate() {
                    // The momentum is linear in time. It exceeds its limit after the time at which
                    // it crosses +bound or −bound.
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
