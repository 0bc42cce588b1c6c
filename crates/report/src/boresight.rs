//! The directions fixed in the body that a picture shows, and the cones about them.

use super::Subject;
use slewkit::Vector3;
use slewkit::maneuver::{Pointing, Rule};

/// A direction fixed in the body, with the names of its constraints.
pub(super) struct Boresight {
    pub name: String,
    pub vector: Vector3,
}

/// Returns the boresight that ends on a target, and the boresights of all constraints, each once;
/// the body axes for a maneuver without boresights.
pub(super) fn boresights(subject: &Subject) -> Vec<Boresight> {
    let mut found: Vec<Boresight> = Vec::new();
    found.extend(
        subject
            .problem
            .aim()
            .map(|aim| Boresight { name: "boresight on the target".into(), vector: aim.boresight }),
    );
    for (name, pointing) in cones(subject) {
        for (index, vector) in pointing.boresights.iter().enumerate() {
            if found.iter().any(|other| (other.vector - vector).norm() < 1e-9) {
                continue;
            }
            let several = pointing.boresights.len() > 1;
            let number = if several { format!(" {}", index + 1) } else { String::new() };
            found.push(Boresight { name: format!("boresight{number}: {name}"), vector: *vector });
        }
    }
    if found.is_empty() {
        found.extend(body_axes());
    }
    found
}

/// Returns the axes of the body, where nothing else is to be followed.
pub(super) fn body_axes() -> [Boresight; 3] {
    let axes = [("body x", Vector3::x()), ("body y", Vector3::y()), ("body z", Vector3::z())];
    axes.map(|(name, vector)| Boresight { name: name.into(), vector })
}

/// Returns the constraints on pointing.
pub(super) fn cones<'a>(subject: &Subject<'a>) -> impl Iterator<Item = (&'a str, &'a Pointing)> {
    subject.problem.constraints.iter().filter_map(|constraint| match &constraint.rule {
        Rule::Pointing(pointing) => Some((constraint.name.as_str(), pointing)),
        Rule::RateNorm(_) | Rule::RateAxes(_) => None,
    })
}
