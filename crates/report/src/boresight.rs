//! The body-fixed directions that a picture shows, and the cones that constrain them.

use super::Subject;
use slewkit::Vector3;
use slewkit::maneuver::{Pointing, Problem, Rule};
use slewkit::numerics::figures::rounded;
use slewkit::verify::Margin;
use slewkit_files::identity::Identity;

/// A body-fixed direction and its name in pictures.
pub(super) struct Boresight {
    pub name: String,
    pub vector: Vector3,
}

/// Returns the boresights that the maneuver constrains: those that point at a target at the end,
/// and those of all constraints, without repetition. If it has none, the three body axes are
/// returned.
pub(super) fn boresights(subject: &Subject) -> Vec<Boresight> {
    let mut found: Vec<Boresight> = Vec::new();
    let aim = subject.problem.aim().map(|aim| aim.boresight);
    let of_cones = cones(subject).flat_map(|(_, pointing)| pointing.boresights.iter().copied());
    for vector in aim.into_iter().chain(subject.aims.iter().copied()).chain(of_cones) {
        if !found.iter().any(|other| (other.vector - vector).norm() < 1e-9) {
            found.push(Boresight { name: name(subject.identity, &vector), vector });
        }
    }
    if found.is_empty() {
        found.extend(body_axes());
    }
    found
}

/// Returns the name of a boresight in the spec or, if it has no name, its direction in body axes.
pub(crate) fn name(identity: &Identity, boresight: &Vector3) -> String {
    identity.boresight(boresight).unwrap_or_else(|| format!("boresight {}", direction(boresight)))
}

/// Returns the name of the boresight to which a margin belongs; `None` if it has no name in the
/// spec.
pub(crate) fn of_margin(problem: &Problem, identity: &Identity, margin: &Margin) -> Option<String> {
    let constraint = problem.constraints.iter().find(|constraint| constraint.name == margin.name)?;
    let Rule::Pointing(pointing) = &constraint.rule else { return None };
    // If the constraint has several boresights, the margin states the number of the boresight.
    let number = margin.at.strip_prefix("boresight ").and_then(|at| at.split(',').next()?.parse().ok());
    identity.boresight(pointing.boresights.get(number.unwrap_or(1_usize) - 1)?)
}

/// Returns a direction in body axes: "+x" along an axis, or its components.
fn direction(vector: &Vector3) -> String {
    let along = (0..3).find(|axis| (vector[*axis].abs() - 1.0).abs() < 1e-9);
    if let Some(axis) = along {
        let sign = if vector[axis] > 0.0 { '+' } else { '−' };
        return format!("{sign}{}", ["x", "y", "z"][axis]);
    }
    let parts: Vec<String> = vector.iter().map(|part| rounded(*part, 3)).collect();
    format!("({})", parts.join(", "))
}

/// Returns the three body axes, which are shown for a maneuver without boresights.
pub(super) fn body_axes() -> [Boresight; 3] {
    let axes = [("body x", Vector3::x()), ("body y", Vector3::y()), ("body z", Vector3::z())];
    axes.map(|(name, vector)| Boresight { name: name.into(), vector })
}

/// Returns the pointing constraints (cones) of the maneuver with their names.
pub(super) fn cones<'a>(subject: &Subject<'a>) -> impl Iterator<Item = (&'a str, &'a Pointing)> {
    subject.problem.constraints.iter().filter_map(|constraint| match &constraint.rule {
        Rule::Pointing(pointing) => Some((constraint.name.as_str(), pointing)),
        Rule::RateNorm(_) | Rule::RateAxes(_) => None,
    })
}
