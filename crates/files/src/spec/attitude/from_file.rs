//! Reading of start and end attitudes from files.

use super::super::shape::open;
use super::super::{Section, cut};
use super::Rotation;
use crate::epoch::Epoch;
use crate::exchange::{AttitudeTold, into_our_frame, of_our_body, read_attitudes_at};
use crate::rounding::ROTATION;
use slewkit::Matrix3;
use slewkit::lie::{log, minus, rotation_from_quaternion};
use slewkit::numerics::figures::significant;
use std::path::Path;

/// Time at which an attitude is read from a file, and frames that the attitude must refer to.
pub(in super::super) struct Moment<'a> {
    /// Epoch of the maneuver; `None` if the spec has none or it is invalid.
    epoch: Option<Epoch>,
    /// True if the spec has an epoch that is invalid; the error has been reported.
    epoch_is_wrong: bool,
    /// Time of the attitude after the epoch \[s\]; `None` if this time is a result of the plan.
    seconds: Option<f64>,
    reference_frame: Option<&'a str>,
    body_frame: Option<&'a str>,
    /// True if the reference frame of the spec turns.
    turns: bool,
    folder: &'a Path,
}

impl<'a> Moment<'a> {
    /// Creates the data for an attitude `seconds` after the epoch of a spec. Relative paths refer
    /// to the folder `folder`.
    pub fn of(root: &'a Section, seconds: Option<f64>, folder: &'a Path) -> Self {
        let names = root.section("names");
        let turns =
            root.section("environment").is_some_and(|environment| environment.has("orbital_rate_rad_s"));
        let epoch = root.word("epoch").and_then(|text| Epoch::parse(text).ok());
        Self {
            epoch,
            // An invalid epoch is reported where the names in the spec are read.
            epoch_is_wrong: epoch.is_none() && root.has("epoch"),
            seconds,
            reference_frame: names.and_then(|names| names.word("reference_frame")),
            body_frame: names.and_then(|names| names.word("body_frame")),
            turns,
            folder,
        }
    }
}

/// Reads the attitude from the file that the table `section` names.
pub(in super::super) fn rotation(section: &Section, moment: &Moment<'_>) -> Option<Rotation> {
    const KEY: &str = "file";
    if let Some(other) = section.given.iter().find(|given| given.name != KEY && section.knows(&given.name)) {
        let reason = format!("the rotation is given twice, by `file` and by `{}`", other.name);
        return section.refuse("E0028", &other.name, reason, "give one notation");
    }
    let Some(seconds) = moment.seconds else {
        let reason = "the duration is free, so the time of the end attitude is not known before the plan";
        return section.refuse("E0029", KEY, reason, "give duration_s, or the numbers of the attitude");
    };
    if moment.epoch_is_wrong {
        return None;
    }
    let (path, file) = match open(section.word(KEY)?, moment.folder, "a file with attitudes") {
        Ok(opened) => opened,
        Err((code, reason, remedy)) => return section.refuse(code, KEY, reason, remedy),
    };
    let shown = cut(&path.to_string_lossy(), 200);
    let told = match read_attitudes_at(file, &shown, moment.epoch, seconds) {
        Ok(told) => told,
        Err(errors) => {
            let (line, reason, remedy) = errors.0.into_iter().next().map_or_else(
                || (1, "it cannot be read".into(), "check it".into()),
                |error| (error.line, error.reason, error.remedy),
            );
            return section.refuse("E0092", KEY, format!("{shown}: line {line}: {reason}"), remedy);
        }
    };
    let mut refused = None;
    let mut found = Vec::new();
    for told in &told {
        let (mut open, theirs) = (Vec::new(), told.reference_frame.as_deref());
        let turned = into_our_frame(theirs, moment.reference_frame, moment.turns, &mut open);
        let ours = of_our_body(told.body_frame.as_deref(), moment.body_frame, &mut open);
        match turned.and_then(|turned| ours.map(|()| turned)) {
            Err(apart) => refused = refused.or(Some(apart)),
            Ok(turned) => {
                let attitude = rotation_from_quaternion(&told.quaternion);
                found.push((turned.unwrap_or_else(Matrix3::identity) * attitude, open, told));
            }
        }
    }
    // Attitudes in the frames of the spec are preferred to attitudes in frames that may be others.
    if found.iter().any(|(_, open, _)| open.is_empty()) {
        found.retain(|(_, open, _)| open.is_empty());
    }
    let Some((matrix, open, told)) = found.first() else {
        let (reason, remedy) = refused.unwrap_or_else(|| ("it has no attitude".into(), "check it".into()));
        return section.refuse("E0092", KEY, format!("{shown}: {reason}"), remedy);
    };
    for (other, _, of) in &found[1..] {
        let angle = minus(matrix, other).norm();
        if angle > ROTATION {
            let name = |told: &AttitudeTold| cut(told.body_frame.as_deref().unwrap_or_default(), 40);
            let (one, other) = (name(told), name(of));
            let of = if one.eq_ignore_ascii_case(&other) {
                format!("two attitudes of {one}")
            } else {
                format!("the attitudes of {one} and {other}")
            };
            let reason = format!("{shown}: {of} differ by {} deg", significant(angle.to_degrees(), 3));
            let remedy = "keep only the intended one in the file, or name its frame in [names] body_frame";
            return section.refuse("E0092", KEY, reason, remedy);
        }
    }
    for (texts, remedy) in [
        (open, "name the frames in [names] reference_frame and body_frame"),
        (&told.not_taken, "check that the file has the intended attitude"),
    ] {
        for text in texts {
            section.warn("W0092", KEY, format!("{shown}: not checked: {text}"), remedy);
        }
    }
    Some(Rotation { matrix: *matrix, vector: log(matrix), spot: section.here(), maybe_identity: None })
}
