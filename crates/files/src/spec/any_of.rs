//! Reading of `[[any_of]]`: alternative sets of cones, one of which must be satisfied at each time.

use super::suggest::nearest;
use super::{Section, constraint, escape};
use slewkit::maneuver::{Alternatives, AlternativesError, Constraint};

/// Reads all alternative sets of cones; `None` if one of them has an error.
pub(super) fn alternatives(root: &Section, constraints: &[Constraint]) -> Option<Vec<Alternatives>> {
    let sections = root.tables("any_of")?;
    let mut all: Vec<Alternatives> = Vec::new();
    for (index, section) in sections.iter().enumerate() {
        let name = section.word("name").map_or_else(|| format!("any of {}", index + 1), String::from);
        let constraint = constraints.iter().any(|one| one.name == name);
        if constraint || constraint::is_taken(&name) || all.iter().any(|other| other.name == name) {
            let reason = format!("the name \"{}\" is already used", escape(&name));
            let remedy = "give it another name: reports identify constraints by their names";
            return section.refuse("E0011", "name", reason, remedy);
        }
        let sets: Option<Vec<Vec<String>>> =
            section.tables("set")?.iter().map(|set| set.texts("constraints")).collect();
        let of = Alternatives { name, sets: sets? };
        let before = all.iter().flat_map(Alternatives::members);
        let twice = before.into_iter().find(|name| of.members().any(|member| member == *name));
        let twice = twice.map(|name| AlternativesError::Twice(name.into()));
        if let Some(error) = twice.or_else(|| of.check(constraints).err()) {
            let remedy = match &error {
                AlternativesError::Few => {
                    "write set = [{ constraints = [\"A\"] }, { constraints = [\"B\"] }], names of [[constraint]]"
                }
                AlternativesError::Unknown(name) => &unknown(name, constraints),
                AlternativesError::Twice(_) => "remove it from one set, or write another [[constraint]]",
                AlternativesError::NoCone(_) => "remove it: a limit of rates holds at all times",
            };
            return section.refuse("E0080", "set", escape(&error.to_string()), remedy);
        }
        all.push(of);
    }
    Some(all)
}

/// Returns the remedy for an unknown constraint name, which proposes the most similar name,
/// ignoring case.
fn unknown(name: &str, constraints: &[Constraint]) -> String {
    let lower: Vec<String> = constraints.iter().map(|one| one.name.to_ascii_lowercase()).collect();
    let near = nearest(name, lower.iter().map(String::as_str));
    let meant = near.and_then(|near| lower.iter().position(|one| one == near));
    match meant {
        Some(index) => format!("did you mean \"{}\"?", escape(&constraints[index].name)),
        None => "write the `name` of a [[constraint]]".into(),
    }
}
