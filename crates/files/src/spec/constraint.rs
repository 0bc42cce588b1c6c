//! Reading of `[[constraint]]`: limits on boresight directions and angular rates.

use super::{Angle, Limits, Section, escape, short, sky};
use slewkit::Vector3;
use slewkit::maneuver::{Constraint, Direction, Pointing, Problem, Rule, Side};
use slewkit::optimize::shooting_obstacle;

/// Largest total number of pairs of a boresight and a direction in all constraints.
const MAX_PAIRS: usize = 10_000;

/// Names of actuator limits in reports. Constraints must not have these names.
const TAKEN: [&str; 9] = [
    "torque limit",
    "torque norm limit",
    "torque rate limit",
    "force limit",
    "force norm limit",
    "force rate limit",
    "wheel torque limit",
    "wheel torque rate limit",
    "wheel momentum limit",
];

/// Returns whether `name` is the name of an actuator limit in reports.
pub(super) fn is_taken(name: &str) -> bool {
    TAKEN.contains(&name)
}

/// Reads all constraints; `None` if one of them has an error.
pub(crate) fn constraints(root: &Section, sky: &mut sky::Reading) -> Option<Vec<Constraint>> {
    let sections = root.tables("constraint")?;
    let names = names(sections);
    let names = names?;
    let rules: Vec<_> = sections.iter().zip(&names).map(|(section, name)| rule(section, sky, name)).collect();
    let mut pairs = 0;
    let mut constraints = Vec::new();
    for ((rule, name), section) in rules.into_iter().zip(names).zip(sections) {
        let rule = rule?;
        if let Rule::Pointing(pointing) = &rule {
            pairs += pointing.boresights.len() * pointing.directions.len();
            if pairs > MAX_PAIRS {
                let reason = format!(
                    "up to this constraint, all constraints have {pairs} pairs of a boresight and a direction"
                );
                let remedy = format!("use fewer: at most {MAX_PAIRS} pairs are possible");
                return section.refuse_here("E0034", reason, remedy);
            }
        }
        constraints.push(Constraint { name, rule });
    }
    Some(constraints)
}

/// Returns the names of the constraints, all of which are different. A constraint without a name is
/// named after its kind.
fn names(sections: &[Section]) -> Option<Vec<String>> {
    let mut names: Vec<Option<String>> = vec![None; sections.len()];
    let mut good = true;
    for (index, section) in sections.iter().enumerate() {
        if !section.has("name") {
            continue;
        }
        let Some(name) = section.word("name").map(str::trim) else {
            good = false;
            continue;
        };
        let first = names.iter().position(|other| other.as_deref() == Some(name));
        let reason = match first {
            _ if name.is_empty() => Some("the name is empty".to_string()),
            Some(first) => Some(format!("constraint {} has the name of constraint {}", index + 1, first + 1)),
            None if is_taken(name) => {
                Some(format!("\"{name}\" is the name of a limit of [actuators] in reports"))
            }
            None => None,
        };
        if let Some(reason) = reason {
            let remedy = "give it another name: reports identify constraints by their names";
            section.error("E0011", "name", reason, remedy);
            good = false;
        }
        names[index] = Some(name.into());
    }
    for index in 0..sections.len() {
        if names[index].is_some() {
            continue;
        }
        let word = match sections[index].word("kind")? {
            "keep_out" => "keep-out cone",
            "keep_in" => "keep-in cone",
            "on_cone" => "cone",
            _ => "rate limit",
        };
        let numbered = (2..).map(|number| format!("{word} {number}"));
        let free = |name: &String| !names.iter().flatten().any(|other| other == name);
        names[index] = std::iter::once(word.to_string()).chain(numbered).find(free);
    }
    good.then_some(names.into_iter().flatten().collect())
}

fn rule(section: &Section, sky: &mut sky::Reading, name: &str) -> Option<Rule> {
    let side = match section.word("kind")? {
        "keep_out" => Side::KeepOut,
        "keep_in" => Side::KeepIn,
        "on_cone" => Side::On { within: sky::within(section)? },
        _ => return rate_limit(section),
    };
    let boresights = section
        .vectors("boresight_body")
        .map(|vectors| vectors.into_iter().map(|vector| section.unit(vector)).collect());
    let known = sky.targets_read();
    let directions = directions(section, sky, name);
    let during = sky.during(section, known);
    let (half_angle, margin) = cone(section, side)?;
    let widest =
        directions.iter().flatten().map(|direction| direction.angular_radius(0.0)).fold(0.0, f64::max);
    let whole = (half_angle + margin + widest).to_degrees();
    if widest > 0.0 && whole >= 180.0 {
        let seen = short((widest.to_degrees() * 10.0).round() / 10.0);
        let reason = format!(
            "the angular radius of the Earth is {seen} deg: the requested angle beyond \
            its limb leaves no direction"
        );
        return section.refuse("E0070", "beyond_limb_deg", reason, "write a smaller angle");
    }
    Some(Rule::Pointing(Pointing {
        side,
        boresights: boresights?,
        directions: directions?,
        half_angle,
        margin,
        during: during?,
    }))
}

fn rate_limit(section: &Section) -> Option<Rule> {
    let (name, scale) = if section.has("angular_velocity_limit_deg_s") {
        ("angular_velocity_limit_deg_s", 1_f64.to_radians())
    } else {
        ("angular_velocity_limit_rad_s", 1.0)
    };
    Some(match section.limits(name)? {
        Limits::All(limit) => Rule::RateNorm(limit * scale),
        Limits::Each(limits) => Rule::RateAxes(Vector3::from_column_slice(&limits) * scale),
    })
}

/// Reads the half angle and the margin of a cone, in this order \[rad\].
fn cone(section: &Section, side: Side) -> Option<(f64, f64)> {
    let half_angle = if section.has("beyond_limb_deg") {
        section.number("beyond_limb_deg").map(|value| Angle { key: "beyond_limb_deg", value })
    } else {
        section.angle("half_angle_deg", "half_angle_rad")
    };
    // A keep-on cone has no margin; the first pass has reported a margin as an error.
    let has_margin = !matches!(side, Side::On { .. });
    let margin_given = has_margin && (section.has("margin_deg") || section.has("margin_rad"));
    let margin = if margin_given { section.angle("margin_deg", "margin_rad") } else { None };
    let half_angle = half_angle?;
    if half_angle.degrees() <= 0.0 || half_angle.degrees() >= 180.0 {
        let reason = format!(
            "`{}`: {half_angle} is not a half angle of a cone: it must be above 0 and below {}",
            half_angle.key,
            half_angle.half_turn()
        );
        let remedy = "the half angle is measured from the axis of the cone to its surface";
        return section.refuse("E0070", half_angle.key, reason, remedy);
    }
    let margin = if margin_given { margin? } else { Angle { key: "margin_deg", value: 0.0 } };
    let (half, extra) = (half_angle.degrees(), margin.degrees());
    let reason = match side {
        Side::KeepOut if half + extra >= 180.0 => format!(
            "a cone of {half_angle} with a margin of {margin} leaves no direction: their sum must be \
            below {}",
            half_angle.half_turn()
        ),
        Side::KeepIn if half - extra <= 0.0 => {
            format!("a margin of {margin} must be smaller than the half angle of the cone, {half_angle}")
        }
        _ => return Some((half_angle.radians(), margin.radians())),
    };
    section.refuse("E0070", margin.key, reason, "write a smaller margin")
}

/// Reads the directions of a constraint, given as vectors or as named targets.
fn directions(section: &Section, sky: &mut sky::Reading, used_by: &str) -> Option<Vec<Direction>> {
    let mut directions = Vec::new();
    for (name, turns) in [("direction_inertial", false), ("direction_reference", true)] {
        let kind = if turns { Direction::InFrame } else { Direction::Fixed };
        let sections = section.tables(name)?;
        let read: Vec<_> = sections.iter().map(sky::star).collect();
        for vector in read {
            directions.push(kind(vector?));
        }
    }
    let named: Vec<_> =
        section.tables("direction")?.iter().map(|target| sky.direction(target, used_by)).collect();
    for direction in named {
        directions.push(direction?);
    }
    if section.has("limb_of") {
        section.word("limb_of")?;
        directions.push(sky.limb(section, used_by)?);
    }
    if section.has("beyond_limb_deg") != section.has("limb_of") {
        let reason = "`limb_of` and `beyond_limb_deg` must be given together";
        let key = if section.has("limb_of") { "limb_of" } else { "beyond_limb_deg" };
        return section.refuse("E0021", key, reason, "write limb_of = \"earth\", beyond_limb_deg = 20");
    }
    (!directions.is_empty()).then_some(directions)
}

/// Returns the rule of the constraint with the name `name`; `None` if no constraint has this name.
fn rule_of<'a>(problem: &'a Problem, name: &str) -> Option<&'a Rule> {
    problem.constraints.iter().find(|constraint| constraint.name == name).map(|constraint| &constraint.rule)
}

/// Returns the code and the remedy for the error that the state at `end` violates the constraint
/// `name`.
pub(crate) fn violated(problem: &Problem, name: &str, end: &str) -> (&'static str, String) {
    match rule_of(problem, name) {
        Some(Rule::RateNorm(limit)) => (
            "E0060",
            format!(
                "reduce the rate at the {end}, or raise the limit from {} deg/s",
                short(limit.to_degrees())
            ),
        ),
        Some(Rule::RateAxes(_)) => ("E0060", format!("reduce the rate at the {end}, or raise the limit")),
        Some(Rule::Pointing(Pointing { side: Side::On { within }, .. })) => (
            "E0071",
            format!("turn the {end} onto the cone, or widen within_deg from {}", short(within.to_degrees())),
        ),
        Some(Rule::Pointing(Pointing { side: Side::KeepIn, .. })) => {
            ("E0071", format!("turn the {end} into the cone, or make the cone wider"))
        }
        _ => ("E0071", format!("turn the {end} out of the cone, or make the cone narrower")),
    }
}

/// Reports an error if the spec selects the method `shooting` and the maneuver has constraints
/// other than input limits, which this method does not support.
pub(crate) fn refuse_shooting(problem: &Problem, solver: &Section) {
    let limits = |channel: &slewkit::mechanics::actuators::ActuatorSet| channel.limits().rate.is_some();
    let actuation = &problem.actuation;
    let what = if let Some(constraint) = problem.constraints.first() {
        format!("\"{}\"", escape(&constraint.name))
    } else if actuation.wheels.is_some() {
        "reaction wheels".into()
    } else if limits(&actuation.torque) || actuation.force.as_ref().is_some_and(limits) {
        "a limit on the rate of the inputs".into()
    } else if let Some(obstacle) = shooting_obstacle(problem) {
        let reason = format!("method = \"shooting\" is not possible here: {obstacle}");
        solver.error("E0066", "method", reason, "write method = \"auto\" or \"interior_point\"");
        return;
    } else {
        return;
    };
    let reason = format!("method = \"shooting\" supports only limits on the inputs, not {what}");
    solver.error("E0066", "method", reason, "write method = \"auto\" or \"interior_point\"");
}

/// Reports an error if the spec selects the method `scp` for a maneuver that this method does not
/// support.
pub(crate) fn refuse_scp(problem: &Problem, solver: &Section) {
    if problem.objective.switches() || problem.duration.known().is_none() {
        let reason = "method = \"scp\" supports only minimum effort with a given duration";
        solver.error("E0066", "method", reason, "write method = \"auto\" or \"interior_point\"");
    }
}
