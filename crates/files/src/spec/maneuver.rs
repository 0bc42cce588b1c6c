//! Reading of `[maneuver]` and `[solver]`.

use super::keys::StepsOf;
use super::{Angle, Section, grid, short, show};
use slewkit::maneuver::{Duration, Method, Problem, Scheme, Settings, Target, Thoroughness};
use std::time;

/// Largest rotation per step with the default number of steps \[rad\]. With it, Newton's method
/// needs two or three iterations per step.
const ANGLE_PER_STEP: f64 = 0.3;
/// Lower bound on the default number of steps.
const DEFAULT_STEPS: f64 = 100.0;

/// Returns the default number of steps: the smallest `N ≥ 100` with which the cubic initial guess
/// rotates by at most 0.3 rad in each step.
///
/// `N = max(100, ⌈(1.5 φ + ω T)/0.3⌉)`, because the rate of the cubic is at most `1.5 φ/T`. The
/// parameter `angle` = φ is the largest rotation that is tried \[rad\], and `duration` = T \[s\].
/// The parameter `rate` = ω \[rad/s\] is the sum of the largest boundary rate, the rate of the
/// reference frame, and the nutation rate due to the momentum of the wheels.
pub fn default_steps(angle: f64, rate: f64, duration: f64) -> f64 {
    ((1.5 * angle + rate * duration) / ANGLE_PER_STEP).ceil().max(DEFAULT_STEPS)
}

/// Reads the duration, which is required for minimum effort and minimum fuel without a time weight
/// or an upper bound on the duration. In all other cases the duration is a result of the plan.
pub(crate) fn duration(section: &Section) -> Option<Duration> {
    let minimize = section.word("minimize");
    let (priced, bounded) = (section.has("time_price_per_s"), section.has("duration_at_most_s"));
    if minimize == Some("time") {
        let reason = "time is the objective, so it cannot have a price";
        let remedy = "remove time_price_per_s; or write minimize = \"effort\" or \"fuel\"";
        if priced {
            return section.refuse("E0029", "time_price_per_s", reason, remedy);
        }
        let reason = "the duration is the objective, so it cannot have a bound";
        let remedy = "remove duration_at_most_s; or write minimize = \"effort\" or \"fuel\"";
        if bounded {
            return section.refuse("E0029", "duration_at_most_s", reason, remedy);
        }
    } else if !priced && !bounded {
        if !section.has("duration_s") {
            // An unknown key or objective has already been reported. It may be a misspelt key that
            // would determine the duration.
            let misspelt = section.given.iter().any(|given| !section.knows(&given.name));
            if misspelt || (section.has("minimize") && minimize.is_none()) {
                return None;
            }
            let reason = "[maneuver] needs `duration_s`";
            return section.refuse(
                "E0021",
                "duration_s",
                reason,
                "add duration_s = 60, or duration_at_most_s = 60, or time_price_per_s = 1",
            );
        }
        return section.number("duration_s").map(Duration::Given);
    }
    if section.has("duration_s") {
        let (reason, remedy) = if priced {
            ("the plan finds the duration if time has a price", "remove one of the two")
        } else if bounded {
            ("the plan finds the duration if it has a bound", "remove one of the two")
        } else {
            let reason = "the plan finds the duration if `minimize = \"time\"`";
            (reason, "remove duration_s; or write minimize = \"effort\" for a plan in that time")
        };
        return section.refuse("E0029", "duration_s", reason, remedy);
    }
    // An invalid number has already been reported, so the duration is not reported as missing.
    for (given, key) in [(bounded, "duration_at_most_s"), (priced, "time_price_per_s")] {
        if given {
            section.number(key)?;
        }
    }
    if section.has("step_s") {
        let reason = "steps of a given length need a given duration, and the duration is free";
        return section.refuse("E0029", "step_s", reason, "give steps = 100 instead, or remove the key");
    }
    Some(Duration::Sought { at_most: section.number("duration_at_most_s") })
}

/// Returns the number of steps of a maneuver with a free duration: the number in the spec or, if it
/// is absent, a default for the rotation `angle` \[rad\].
pub(crate) fn steps_of_sought_duration(section: &Section, angle: f64) -> Option<usize> {
    if section.has("steps") {
        section.whole("steps")?.try_into().ok()
    } else {
        steps(section, 0.0, angle, 0.0)
    }
}

/// Reports an error if the spec selects a scheme that does not support bang-bang inputs or a free
/// duration.
pub(crate) fn refuse_scheme(section: &Section) {
    if section.word("scheme") == Some("lie_euler") {
        let reason = "free durations and bang-bang inputs both need the second-order scheme";
        section.error("E0029", "scheme", reason, "write scheme = \"lie_verlet\", or remove the key");
    }
}

/// Returns the number of steps: the number in the spec or, if it is absent, [`default_steps`] of
/// `angle` \[rad\], `rate` \[rad/s\] and `duration` \[s\].
pub(crate) fn steps(section: &Section, duration: f64, angle: f64, rate: f64) -> Option<usize> {
    if section.has("steps") || section.has("step_s") {
        return grid::given(StepsOf::Plan, section, duration)?.try_into().ok();
    }
    let steps = default_steps(angle, rate, duration);
    if steps > Problem::MAX_STEPS as f64 {
        let reason = format!(
            "a maneuver of {} rad with rates of {} rad/s needs {} steps, but the limit is {}",
            short(angle),
            short(rate),
            show(steps),
            Problem::MAX_STEPS
        );
        let remedy = "check the angles, the rates and `duration_s`; or shorten the maneuver";
        return section.refuse("E0034", "duration_s", reason, remedy);
    }
    Some(steps as usize)
}

/// Reads `[solver]`: the integration scheme and the settings of the solver.
pub(crate) fn solver(section: Option<&Section>) -> (Scheme, Settings) {
    let mut settings = Settings::default();
    let Some(section) = section else { return (Scheme::LieVerlet, settings) };
    settings.method = match section.word("method") {
        Some("shooting") => Method::Shooting,
        Some("scp") => Method::Scp,
        Some("interior_point") => Method::InteriorPoint,
        _ => Method::Auto,
    };
    settings.search = match section.word("search") {
        Some("quick") => Thoroughness::Quick,
        Some("thorough") => Thoroughness::Thorough,
        _ => Thoroughness::Default,
    };
    if let Some(tolerance) = section.number("tolerance") {
        let least = Settings::MIN_TOLERANCE;
        let wrong = match tolerance {
            _ if tolerance < least => format!("is below {least:e}, the limit of double precision here"),
            _ if tolerance >= 1.0 => "would accept any result; it must be below 1".into(),
            _ => String::new(),
        };
        if wrong.is_empty() {
            settings.tolerance = tolerance;
        } else {
            let reason = format!("a tolerance of {} {wrong}", show(tolerance));
            section.error("E0036", "tolerance", reason, "write 1e-12, or remove the key");
        }
    }
    if section.word("target") == Some("discrete") {
        settings.target = Target::Discrete;
    }
    let continuous = section.angle("continuous_tolerance_deg", "continuous_tolerance_rad");
    settings.continuous_tolerance = continuous.map(Angle::radians);
    settings.time_limit = section.number("time_limit_s").map(time::Duration::from_secs_f64);
    if let Some(count) = section.count("max_iterations") {
        settings.max_iterations = count;
    }
    settings.test_second_order = section.word("second_order") != Some("skipped");
    let scheme =
        if section.word("scheme") == Some("lie_euler") { Scheme::LieEuler } else { Scheme::LieVerlet };
    (scheme, settings)
}
