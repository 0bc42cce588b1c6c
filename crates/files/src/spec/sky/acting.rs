//! Reading of the times at which a cone is active: `while` and `during_s`.

use super::super::Section;
use super::{ADD_EPOCH, Reading};
use slewkit::maneuver::During;
use slewkit_sky::Condition;

/// Default of the largest angle between a boresight and its keep-on cone between nodes \[deg\].
const WITHIN_DEG: f64 = 0.1;

/// Reads the largest angle between a boresight and its keep-on cone between nodes \[rad\].
pub(in crate::spec) fn within(section: &Section) -> Option<f64> {
    if section.has("within_deg") || section.has("within_rad") {
        section.angle("within_deg", "within_rad").map(|angle| angle.radians())
    } else {
        Some(WITHIN_DEG.to_radians())
    }
}

impl Reading {
    /// Reads the times at which a constraint is active. The directions of the constraint have been
    /// read before; `known` is the number of targets that had been read before them.
    pub fn during(&self, section: &Section, known: usize) -> Option<During> {
        if section.has("during_s") {
            let pairs = section.square("during_s")?;
            return Some(During::intervals(pairs.iter().map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()));
        }
        if !section.has("while") {
            return Some(During::default());
        }
        let word = section.word("while")?;
        let condition = match word {
            "always" => return Some(During::default()),
            "sunlit" => Condition::Sunlit,
            "eclipse" => Condition::Eclipsed,
            _ => match &self.targets[known..] {
                [one] if section.tables("direction").is_some_and(|all| all.len() == 1) => {
                    Condition::Visible(one.target.clone())
                }
                _ => {
                    let reason = "`while = \"target_visible\"` needs one named `direction`";
                    let remedy = "write direction = \"moon\", one constraint for each target";
                    return section.refuse("E0021", "while", reason, remedy);
                }
            },
        };
        let remedy = format!("{ADD_EPOCH}, and [orbit]");
        self.around(section, "while", || format!("\"{word}\""), &remedy)?;
        let sky = self.sky.as_ref()?;
        self.known_ahead(section, "while")?;
        let windows = condition.windows(sky, 0.0, self.ahead).map_err(|error| {
            let remedy = "add [orbit] with tle, omm, oem, or the keys of a Keplerian orbit";
            section.error("E0076", "while", format!("\"{word}\": {error}"), remedy);
        });
        let intervals: Vec<[f64; 2]> = windows.ok()?.iter().map(|window| [window.from, window.to]).collect();
        Some(During::intervals(intervals))
    }

    /// Returns the number of targets that have been read.
    pub fn targets_read(&self) -> usize {
        self.targets.len()
    }
}
