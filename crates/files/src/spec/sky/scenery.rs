//! The surroundings of the spacecraft. They are read from `[scenery]` in a plan file, or computed
//! from the orbit.

use super::super::Section;
use super::{Named, Reading, track};
use crate::scenery::{Scenery, TargetShown};
use slewkit::{Direction, Matrix3};
use slewkit_sky::Target;

impl Reading {
    /// Returns the surroundings of the spacecraft, read from a plan file or, if the spec has a
    /// named target, computed from the orbit. Returns `None` in all other cases.
    pub fn scenery(&self, root: &Section) -> Option<Scenery> {
        if let Some(section) = root.section("scenery") {
            return told_scenery(section);
        }
        let sky = self.sky.as_ref().filter(|_| !self.targets.is_empty())?;
        let way = |target: &Target| sky.way(target, 0.0, self.ahead).ok();
        Some(Scenery {
            spacecraft: sky.orbit().and_then(|_| way(&Target::Zenith)),
            sun: way(&Target::Sun)?,
            moon: way(&Target::Moon)?,
            earth: sky.earth_axes(0.0),
            target: self.goal.clone(),
        })
    }

    /// Returns the description of the target of the end for pictures and summaries. The target must
    /// be the last one that was read.
    pub(super) fn shown(&self, at: &Direction) -> Option<TargetShown> {
        let Named { name, target, .. } = self.targets.last()?;
        let Direction::Moving(track) = at else { return None };
        let station = match target {
            Target::Ground { latitude_deg, longitude_deg, height_m } => {
                Some([*latitude_deg, *longitude_deg, *height_m])
            }
            _ => None,
        };
        let range = self.sky.as_ref().filter(|_| target.is_place())?.range(target, 0.0).ok();
        let unit_m = range.map(|range| range / track.at(0.0)[0].norm());
        Some(TargetShown { name: name.clone(), station, unit_m })
    }
}

/// Reads the surroundings in the notation of plan files.
fn told_scenery(section: &Section) -> Option<Scenery> {
    let way = |name: &str| match track(section.section(name)?)? {
        Direction::Moving(track) => Some(track),
        _ => None,
    };
    let number = |name: &str| if section.has(name) { section.number(name) } else { None };
    let station = [number("latitude_deg"), number("longitude_deg"), number("height_m")];
    let target = section.word("target").map(|name| TargetShown {
        name: name.into(),
        station: match station {
            [Some(latitude), Some(longitude), height] => Some([latitude, longitude, height.unwrap_or(0.0)]),
            _ => None,
        },
        unit_m: number("target_unit_m"),
    });
    let spacecraft = if section.has("spacecraft") { Some(way("spacecraft")?) } else { None };
    let earth = section.matrix("earth_axes")?;
    if (earth.transpose() * earth - Matrix3::identity()).amax() > 1e-6 || earth.determinant() < 0.0 {
        let reason = "`earth_axes` is not a rotation: its rows are not the axes of a right-handed frame";
        return section.refuse("E0055", "earth_axes", reason, "give orthogonal rows of length 1");
    }
    Some(Scenery { spacecraft, sun: way("sun")?, moon: way("moon")?, earth, target })
}
