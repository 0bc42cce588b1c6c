//! Reading of chance constraints, and of the margins and reserves that a plan file contains.

use crate::spec::{Limits, Section, escape};
use slewkit::assured::{self, Over};
use slewkit::maneuver::{Problem, Rule};
use slewkit::mechanics::LimitKind;

/// A chance constraint: the allowed probability of violating a limit, or any of several limits.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Chance {
    /// Names of the constraints or torque limits concerned, as in reports.
    pub limits: Vec<String>,
    /// Largest allowed probability of a violation.
    pub at_most: f64,
    /// True for the probability over the whole motion, false for the probability at the worst
    /// instant.
    pub of_motion: bool,
    /// True for the joint probability of violating any of several limits, which `[uncertainty]`
    /// states.
    pub is_joint: bool,
    /// Key of the chance in `[actuators]`, if it belongs to a torque limit.
    pub(crate) key: Option<&'static str>,
}

/// Kinds of torque limits, each with its keys in `[actuators]` for the chance and for the reserve.
pub(crate) const LIMITS: [(LimitKind, &str, &str); 3] = [
    (LimitKind::Size, "torque_limit_chance", "torque_limit_reserve_n_m"),
    (LimitKind::Norm, "torque_norm_limit_chance", "torque_norm_limit_reserve_n_m"),
    (LimitKind::Rate, "torque_rate_limit_chance", "torque_rate_limit_reserve_n_m_per_s"),
];

/// Returns whether the torque inputs have a limit of this kind.
fn has(problem: &Problem, kind: LimitKind) -> bool {
    problem.actuation.limits().any(|limit| !limit.of_force && limit.kind == kind)
}

/// Checks that the key `key` can be used: the actuators must have a limit of the kind `kind`, and
/// the problem must allow a reserve for it.
fn fits(section: &Section, key: &str, kind: LimitKind, problem: &Problem) -> bool {
    let name = problem.actuation.limit_name(kind, false);
    let (reason, remedy) = if problem.actuation.torque.limits().one_sided {
        (
            "chances need actuators that act both ways: a thruster that is off cannot correct".into(),
            "remove the key; plant.authority reserves torque above the limit for corrections",
        )
    } else if !has(problem, kind) {
        (format!("no {name} exists for this chance"), "add the limit, or remove the chance")
    } else {
        return true;
    };
    section.error("E0172", key, reason, remedy);
    false
}

/// Reads the chance constraints. `uncertain` is true if the spec has `[uncertainty]`, which every
/// chance requires.
pub(super) fn chances(root: &Section, problem: &Problem, uncertain: bool) -> Vec<Chance> {
    let mut chances = Vec::new();
    for (section, constraint) in root.list("constraint").iter().zip(&problem.constraints) {
        let at_most = own(section, "chance", &[&constraint.name], uncertain);
        if !section.has("chance") && section.has("chance_over") {
            let reason = "`chance_over` has no effect: the constraint has no chance";
            section.error("E0172", "chance_over", reason, "add chance = 0.001, or remove the key");
        }
        let margins = ["margin_deg", "margin_rad", "margin_deg_s", "margin_rad_s"];
        // A spec in a plan file contains both the chance and the margin that it requires.
        if section.has("chance") && !section.keeps_rounding && margins.iter().any(|key| section.has(key)) {
            let reason = "a chance and a margin are given: the larger of the two is active";
            section.warn("W0170", "chance", reason, "remove the margin, unless it has another purpose");
        }
        let Some((at_most, of_motion)) = at_most else { continue };
        chances.push(Chance {
            limits: vec![constraint.name.clone()],
            at_most,
            of_motion,
            is_joint: false,
            key: None,
        });
    }
    if let Some(section) = root.section("actuators") {
        for (kind, key, _) in LIMITS.iter().filter(|(_, key, _)| section.has(key)) {
            let name = problem.actuation.limit_name(*kind, false);
            if !fits(section, key, *kind, problem) {
                continue;
            }
            if root.section("feedback").is_none() {
                let reason =
                    "the chance has no effect: without gains, nothing is added to the torques of the plan";
                section.error("E0172", key, reason, "add [feedback], or remove the key");
            }
            let Some((at_most, of_motion)) = own(section, key, &[name], uncertain) else { continue };
            chances.push(Chance {
                limits: vec![name.into()],
                at_most,
                of_motion,
                is_joint: false,
                key: Some(*key),
            });
        }
        if section.has("chance_over") && !LIMITS.iter().any(|(_, key, _)| section.has(key)) {
            let reason = "`chance_over` has no effect: no limit has a chance";
            section.error(
                "E0172",
                "chance_over",
                reason,
                "add torque_limit_chance = 0.001, or remove the key",
            );
        }
    }
    if let Some(section) = root.section("uncertainty") {
        let joint = joint(section, problem, &chances);
        chances.extend(joint);
    }
    chances
}

/// Reads the chance under `key`. The second value is true if it refers to the whole motion.
fn own(section: &Section, key: &str, names: &[&str], uncertain: bool) -> Option<(f64, bool)> {
    let of_motion = section.has("chance_over") && section.word("chance_over") == Some("motion");
    let at_most = if section.has(key) { section.number(key)? } else { return None };
    if !uncertain {
        let name = escape(&names.join(", "));
        let reason = format!("\"{name}\" has a chance, but the spec has no [uncertainty]");
        section.error("E0172", key, reason, "add [uncertainty], or give a margin instead");
    }
    if of_motion {
        can_be_counted(section, key, at_most);
    }
    Some((at_most, of_motion))
}

fn can_be_counted(section: &Section, key: &str, at_most: f64) {
    if at_most < Over::LEAST {
        let reason = format!(
            "a chance over the motion is estimated from simulated flights, and {at_most} would need too \
             many"
        );
        let remedy = format!("give {} or more, or use the chance at the worst instant", Over::LEAST);
        section.error("E0172", key, reason, remedy);
    }
}

/// Reads the joint probability of violating any of several limits at any time. The key `chance_of`
/// names the limits; the default is all constraints without an individual chance.
fn joint(section: &Section, problem: &Problem, own: &[Chance]) -> Option<Chance> {
    if !section.has("chance") {
        if section.has("chance_of") {
            let reason = "`chance_of` has no effect: the spec has no joint chance";
            section.error("E0172", "chance_of", reason, "add chance = 0.001, or remove the key");
        }
        return None;
    }
    let at_most = section.number("chance")?;
    can_be_counted(section, "chance", at_most);
    let has_own = |name: &str| own.iter().any(|chance| chance.limits.iter().any(|limit| limit == name));
    let constraints = problem.constraints.iter().map(|constraint| constraint.name.as_str());
    if !section.has("chance_of") {
        let limits: Vec<String> = constraints.filter(|name| !has_own(name)).map(String::from).collect();
        if limits.is_empty() {
            let reason = "every constraint has its own chance, so the joint chance covers no constraint";
            return section.refuse("E0172", "chance", reason, "name a limit: chance_of = [\"torque limit\"]");
        }
        return Some(Chance { limits, at_most, of_motion: true, is_joint: true, key: None });
    }
    let limits = section.texts("chance_of")?;
    let kinds = LIMITS.iter().map(|(kind, ..)| *kind).filter(|kind| has(problem, *kind));
    let known: Vec<&str> =
        constraints.chain(kinds.map(|kind| problem.actuation.limit_name(kind, false))).collect();
    for (index, name) in limits.iter().enumerate() {
        let (reason, remedy) = if !known.contains(&name.as_str()) {
            let known =
                known.iter().map(|name| format!("\"{}\"", escape(name))).collect::<Vec<_>>().join(", ");
            let known = if known.is_empty() {
                "no constraint exists".into()
            } else {
                format!("the constraints are {known}")
            };
            ("is neither a constraint nor a torque limit", known)
        } else if limits[..index].contains(name) {
            ("is named twice", "name it once".into())
        } else if has_own(name) {
            ("has its own chance", "remove one of the two".into())
        } else {
            continue;
        };
        return section.refuse("E0172", "chance_of", format!("\"{}\" {reason}", escape(name)), remedy);
    }
    if limits.is_empty() {
        let reason = "`chance_of` is empty";
        return section.refuse("E0172", "chance_of", reason, "remove the key to include all constraints");
    }
    Some(Chance { limits, at_most, of_motion: true, is_joint: true, key: None })
}

/// Adds the reserves of the rate and torque limits in the spec to the maneuver.
pub(super) fn hold(root: &Section, problem: &mut Problem) {
    let rates: Vec<(String, usize)> = problem
        .constraints
        .iter()
        .map(|constraint| {
            let parts = match constraint.rule {
                Rule::Pointing(_) => 0,
                Rule::RateNorm(_) => 1,
                Rule::RateAxes(_) => 3,
            };
            (constraint.name.clone(), parts)
        })
        .collect();
    for (section, (name, parts)) in root.list("constraint").iter().zip(rates) {
        for (key, unit) in [("margin_deg_s", 1_f64.to_radians()), ("margin_rad_s", 1.0)] {
            if parts > 0 && section.has(key) {
                held(section, key, unit, &name, parts, problem);
            }
        }
    }
    let Some(section) = root.section("actuators") else { return };
    let count = problem.actuation.torque.count();
    for (kind, _, key) in LIMITS.iter().filter(|(_, _, key)| section.has(key)) {
        if fits(section, key, *kind, problem) {
            let parts = if *kind == LimitKind::Norm { 1 } else { count };
            held(section, key, 1.0, problem.actuation.limit_name(*kind, false), parts, problem);
        }
    }
}

fn held(section: &Section, key: &str, unit: f64, name: &str, parts: usize, problem: &mut Problem) {
    let held = match section.limits(key) {
        None => return,
        Some(Limits::All(value)) => vec![value * unit; parts],
        Some(Limits::Each(values)) if values.len() == parts => {
            values.iter().map(|value| value * unit).collect()
        }
        Some(Limits::Each(values)) => {
            let reason = format!("`{key}` has {} numbers, but the limit has {parts}", values.len());
            return section.error("E0026", key, reason, "write one number, or one for each");
        }
    };
    if let Err(error) = assured::hold(problem, name, &held) {
        section.error("E0061", key, error.to_string(), "reduce the reserve, or raise the limit");
    }
}
