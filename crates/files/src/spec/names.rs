//! Reading of `epoch` and `[names]`, the identity of a maneuver in files for other programs.

use super::{Section, cut, show};
use crate::epoch::{Epoch, EpochError};
use crate::identity::{Boresights, Identity, Nozzle};
use slewkit::mechanics::Actuation;

/// Reads the names and the epoch; `actuation` has the actuators of the maneuver, or is `None` if
/// they are invalid.
pub(crate) fn identity(root: &Section, actuation: Option<&Actuation>) -> Identity {
    let inputs = actuation.map(Actuation::count);
    let mut identity = Identity { epoch: epoch(root), ..Identity::default() };
    if let Some(names) = root.section("names") {
        identity.object = name(names, "object");
        identity.object_id = name(names, "object_id");
        identity.center = name(names, "center");
        identity.reference_frame = name(names, "reference_frame");
        identity.body_frame = name(names, "body_frame");
        identity.originator = name(names, "originator");
        identity.spice_id = spice_id(names);
        identity.inputs = names.texts("inputs").unwrap_or_default();
        if let Some(inputs) = inputs.filter(|count| names.has("inputs") && *count != identity.inputs.len()) {
            let reason =
                format!("`inputs` has {} names, but the maneuver has {inputs} inputs", identity.inputs.len());
            names.error("E0026", "inputs", reason, "name each input once, forces before torques");
        }
    }
    if identity.inputs.is_empty() {
        identity.inputs = ["wheel", "thruster"].into_iter().flat_map(|key| names_of(root, key)).collect();
    }
    if actuation.is_some_and(|actuation| actuation.thrusters.is_none()) {
        identity.nozzles = nozzles(root).unwrap_or_default();
    }
    identity.boresights = boresights(root);
    identity
}

/// Returns the boresights that have a name, first those of the constraints, then those of the end
/// and of the stops.
fn boresights(root: &Section) -> Vec<Boresights> {
    let ends = root.section("end").into_iter().chain(root.list("stop"));
    let points = ends.filter_map(|end| end.section("point"));
    let named = root.list("constraint").iter().chain(points).filter_map(|section| {
        let name = section.word("boresight_name")?.trim();
        if name.is_empty() {
            let remedy = "write a name, or remove the key";
            return section.refuse("E0131", "boresight_name", "`boresight_name` is empty", remedy);
        }
        let vectors = match section.has("kind") {
            true => section.vectors("boresight_body")?,
            false => vec![section.vector("boresight_body")?],
        };
        let vectors = vectors.into_iter().map(|vector| section.unit(vector)).collect();
        Some(Boresights { name: name.into(), vectors })
    });
    named.collect()
}

/// Returns the thrusters if all of them are defined by position and force, otherwise `None`. The
/// problem has been built from the same tables.
fn nozzles(root: &Section) -> Option<Vec<Nozzle>> {
    let nozzle = |thruster: &Section| {
        Some(Nozzle {
            position: thruster.vector("position_m")?,
            direction: thruster.unit(thruster.vector("force_direction_body")?),
            force_limit: thruster.number("force_limit_n")?,
            price: if thruster.has("fuel_price") { thruster.number("fuel_price")? } else { 1.0 },
        })
    };
    root.section("actuators")?.list("thruster").iter().map(nozzle).collect()
}

/// Reads the epoch of a table. Returns `None` if the key is absent or its value is invalid.
pub(super) fn epoch(section: &Section) -> Option<Epoch> {
    let date = date("epoch", section.word("epoch")?);
    date.map_err(|(reason, remedy)| section.error("E0130", "epoch", reason, remedy)).ok()
}

/// Parses a date and time. If the text is invalid, returns the reason and the remedy.
pub(super) fn date(key: &str, text: &str) -> Result<Epoch, (String, String)> {
    Epoch::parse(text).map_err(|error| {
        let how = match error {
            EpochError::NoScale | EpochError::Scale(_) => {
                "name the time scale: UTC, TAI, TT, TDB or GPS, as in "
            }
            EpochError::Offset(_) => "write the time in UTC, as in ",
            EpochError::Form | EpochError::Calendar => "write ",
        };
        let sample = match key {
            "window" => "[\"2026-11-21T07:05:00 UTC\", \"2026-11-21T07:15:00 UTC\"]",
            _ => "\"2026-11-21T07:00:00 UTC\"",
        };
        (format!("`{key}`: {error}"), format!("{how}{key} = {sample}"))
    })
}

/// Reads a name that must be valid in every file format.
fn name(names: &Section, key: &str) -> Option<String> {
    let text = names.word(key)?.trim();
    let wrong = |c: &char| !(c.is_ascii_graphic() || *c == ' ');
    if text.is_empty() {
        return names.refuse("E0131", key, format!("`{key}` is empty"), "write a name, or remove the key");
    }
    if let Some(sign) = text.chars().find(wrong) {
        let reason = format!("`{key}`: exchange files do not allow {}", cut(&sign.to_string(), 1));
        return names.refuse("E0131", key, reason, "use printable ASCII");
    }
    Some(text.into())
}

fn spice_id(names: &Section) -> Option<i32> {
    let value = names.number("spice_id")?;
    if value >= 0.0 || value.fract() != 0.0 {
        let reason = format!(
            "`spice_id`: {} is not the NAIF ID of a spacecraft, which is a negative whole number",
            show(value)
        );
        return names.refuse("E0131", "spice_id", reason, "write the NAIF ID, as in spice_id = -125544");
    }
    Some(value as i32)
}

/// Returns the names of the wheels or thrusters. A wheel or thruster without a name is named by its
/// number. If none of them has a name, the list is empty.
fn names_of(root: &Section, key: &str) -> Vec<String> {
    let all = root.section("actuators").map_or(&[][..], |actuators| actuators.list(key));
    if !all.iter().any(|one| one.has("name")) {
        return Vec::new();
    }
    let named = |(index, one): (usize, &Section)| {
        one.word("name").map_or_else(|| format!("{key} {}", index + 1), str::to_string)
    };
    all.iter().enumerate().map(named).collect()
}
