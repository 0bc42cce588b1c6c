//! Reading of the time grid of a plan or a simulation, which is given by the number of steps or by
//! the duration of a step.

use super::keys::StepsOf;
use super::{Section, short, show};
use slewkit::maneuver::Problem;

/// Code, reason and remedy of an error message.
type Words = (&'static str, String, &'static str);

/// Returns the error message for too small a number of steps of a plan or a simulation.
pub(super) fn too_few(of: StepsOf, steps: i64) -> Words {
    let (what, remedy) = match of {
        StepsOf::Plan => ("a plan", "write 100, or remove the key for an automatic choice"),
        StepsOf::Simulation => ("a simulation", "write a number, or give step_s instead"),
    };
    let least = of.least();
    let plural = if least == 1 { "" } else { "s" };
    ("E0033", format!("{steps} is too few: {what} needs at least {least} step{plural}"), remedy)
}

/// Returns the error message for too large a number of steps of a plan or a simulation.
pub(super) fn too_many(of: StepsOf, steps: f64) -> Words {
    let (why, remedy) = match of {
        StepsOf::Plan => {
            // A node needs about 1 kB for rotations alone: the state, the inputs, the costates, and
            // the transition matrix of the backward sweep.
            let gigabytes = short(steps * 1e3 / 1e9);
            let why =
                format!("they would need about {gigabytes} GB, and the limit of a plan is {}", of.most());
            (why, "use fewer steps; a thousand suffice for most maneuvers")
        }
        StepsOf::Simulation => {
            let most = show(of.most() as f64);
            let why = format!("the limit of a simulation is {most}, a minute or more even for a free body");
            (why, "use longer steps, a method of higher order, or a shorter duration")
        }
    };
    ("E0034", format!("{} steps are too many: {why}", show(steps)), remedy)
}

/// Returns the number of steps, which is given by `steps`, or computed from `step_s` and `duration`
/// \[s\].
pub(super) fn given(of: StepsOf, section: &Section, duration: f64) -> Option<u64> {
    if section.has("steps") {
        return section.whole("steps");
    }
    let step = section.number("step_s")?;
    let wanted = duration / step;
    let steps = wanted.round();
    if steps < of.least() as f64 {
        let (step, whole) = (show(step), show(duration));
        let (reason, longest) = match of {
            StepsOf::Plan => (
                format!(
                    "a step of {step} s is too long for a maneuver of {whole} s; a plan needs at \
                    least {} steps",
                    Problem::MIN_STEPS
                ),
                short(duration / 100.0),
            ),
            StepsOf::Simulation => {
                (format!("a step of {step} s is longer than the simulation of {whole} s"), whole)
            }
        };
        return section.refuse("E0033", "step_s", reason, format!("write a step of at most {longest} s"));
    }
    if steps > of.most() as f64 {
        let (code, reason, remedy) = too_many(of, steps);
        return section.refuse(code, "step_s", reason, remedy);
    }
    if (wanted - steps).abs() > 1e-9 * steps {
        let (whole, step, used) = (show(duration), show(step), short(duration / steps));
        let reason = format!(
            "{whole} s is not a whole number of steps of {step} s; {steps} steps of {used} s are used"
        );
        section.warn("W0033", "step_s", reason, format!("write steps = {steps}"));
    }
    Some(steps as u64)
}
