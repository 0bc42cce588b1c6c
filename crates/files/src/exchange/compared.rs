//! Verification of the attitudes in a file of another program against a maneuver. Frames, epoch and
//! body frame of the file must agree with the spec, or are converted; otherwise the verification is
//! reported as impossible. [`slewkit::verify::judge_attitudes`] performs the other checks.

use super::frames::{Meaning, meaning};
use super::{Attitudes, Refined};
use crate::identity::Identity;
use crate::spec::{Diagnostic, Diagnostics};
use slewkit::maneuver::{Constraint, Problem, Rule};
use slewkit::verify::{AttitudeReport, AttitudeRows, Check, Rounding, judge_attitudes};
use slewkit::{Matrix3, lie};

/// Results of the verification of an attitude file.
#[derive(Clone, Debug)]
pub struct FileReport {
    /// Results of the checks of the rows of the file.
    pub attitudes: AttitudeReport,
    /// Properties that could not be verified, one sentence each, without the final period.
    pub not_judged: Vec<String>,
}

impl FileReport {
    /// Returns true if every check of the file passed.
    pub fn passed(&self) -> bool {
        self.attitudes.passed()
    }
}

/// Repeats the checks of cones and rates on rows inserted between the rows of the file. These rows
/// follow the interpolation that the file declares, not a rotation at a constant rate.
fn between_rows(
    attitudes: &mut AttitudeReport,
    problem: &Problem,
    refined: &Refined,
    to_ours: Option<&Matrix3>,
    rounding: &Rounding,
    tolerance: f64,
) {
    let turn = |q: &[f64; 4]| match to_ours {
        None => *q,
        Some(rotation) => lie::quaternion_from_rotation(&(rotation * lie::rotation_from_quaternion(q))),
    };
    let quaternion: Vec<[f64; 4]> = refined.quaternion.iter().map(turn).collect();
    let told: Vec<bool> =
        (0..refined.row.len()).map(|k| k == 0 || refined.row[k] != refined.row[k - 1]).collect();
    let rows = AttitudeRows {
        time: &refined.time,
        quaternion: &quaternion,
        rate: &[],
        breaks: &refined.breaks,
        told: &told,
        rounding: *rounding,
    };
    let fine = judge_attitudes(problem, &rows, tolerance);
    let of_cone = |text: &str| {
        problem.constraints.iter().any(|constraint| {
            matches!(constraint.rule, Rule::Pointing(_))
                && text.starts_with(&format!("{}: ", constraint.name))
        })
    };
    // The refined rows include all rows of the file, so violations at rows of the file are found
    // again.
    let old = std::mem::take(&mut attitudes.violations);
    let at = std::mem::take(&mut attitudes.violated_at);
    for (text, row) in old.into_iter().zip(at).filter(|(text, _)| !of_cone(text)) {
        attitudes.violations.push(text);
        attitudes.violated_at.push(row);
    }
    for (text, row) in fine.violations.into_iter().zip(fine.violated_at) {
        let named = problem.constraints.iter().find(|one| text.starts_with(&format!("{}: ", one.name)));
        let known = |one: &Constraint| {
            attitudes.violations.iter().any(|text| text.starts_with(&format!("{}: ", one.name)))
        };
        if named.is_some_and(|one| !known(one)) {
            attitudes.violations.push(text);
            attitudes.violated_at.push(refined.row[row]);
        }
    }
    attitudes.open.retain(|text| !text.contains("the rows are too far apart to tell"));
}

/// Name of the check that the time of the first row is the start of the maneuver.
const MOMENT: &str = "moment of the start";
/// Tolerance on the start time as a fraction of the duration, in addition to the resolution of the
/// printed times. It equals the relative tolerance on the duration.
const MOMENT_SHARE: f64 = 1e-6;

/// Verifies the attitudes `found`, read from the file `name`, against a maneuver and the frames
/// and epoch in its spec. `tolerance` is the tolerance on attitudes \[rad\].
///
/// # Errors
/// Returns a diagnostic if the rotation between the frames of the file and of the spec is unknown,
/// so that the attitudes cannot be compared.
pub fn judge_file(
    found: &Attitudes,
    name: &str,
    problem: &Problem,
    identity: &Identity,
    tolerance: f64,
) -> Result<FileReport, Diagnostics> {
    let mut not_judged = found.not_taken.clone();
    let apart = |(reason, remedy): Apart| {
        let mut found_at = Diagnostic::about_file("E0152", name, reason, &remedy);
        found_at.line = found.frames_line.unwrap_or(1);
        Diagnostics(vec![found_at])
    };
    let (theirs, own) = (found.reference_frame.as_deref(), identity.reference_frame.as_deref());
    let turns = problem.environment.frame_rate().amax() > 0.0;
    let to_ours = into_our_frame(theirs, own, turns, &mut not_judged).map_err(apart)?;
    of_our_body(found.body_frame.as_deref(), identity.body_frame.as_deref(), &mut not_judged)
        .map_err(apart)?;
    let turned: Vec<[f64; 4]>;
    let quaternion = match to_ours {
        None => &found.quaternion,
        Some(rotation) => {
            let turn = |q| lie::quaternion_from_rotation(&(rotation * lie::rotation_from_quaternion(q)));
            turned = found.quaternion.iter().map(turn).collect();
            &turned
        }
    };
    let rows = AttitudeRows {
        time: &found.time,
        quaternion,
        rate: &found.rate,
        breaks: &found.breaks,
        told: &[],
        rounding: found.rounding,
    };
    let mut attitudes = judge_attitudes(problem, &rows, tolerance);
    if let Some(refined) = found.refined(tolerance) {
        between_rows(&mut attitudes, problem, &refined, to_ours.as_ref(), &found.rounding, tolerance);
    }
    let lasting = problem.duration.known().or_else(|| Some(found.time.last()? - found.time.first()?));
    let moment = moment(found, lasting.unwrap_or(0.0), identity, &mut not_judged);
    attitudes.checks.extend(moment);
    not_judged.append(&mut attitudes.open.clone());
    if found.rate.is_empty() && !not_judged.iter().any(|text| text.starts_with("rates of the file")) {
        not_judged.push("rates: the file does not have them".into());
    }
    not_judged.push("inputs, their limits, cost and optimality: the file does not have them".into());
    Ok(FileReport { attitudes, not_judged })
}

/// Reason and remedy of the error that attitudes cannot be compared.
pub(crate) type Apart = (String, String);

/// Returns the rotation from components in the frame `theirs` of the file to components in the
/// frame `own` of the spec; `None` if no rotation is needed. `turns` is true if the reference frame
/// of the spec turns. Assumptions that could not be verified are appended to `open`.
pub(crate) fn into_our_frame(
    theirs: Option<&str>,
    own: Option<&str>,
    turns: bool,
    open: &mut Vec<String>,
) -> Result<Option<Matrix3>, Apart> {
    let Some(theirs) = theirs else {
        open.push("the frames: the file does not name them".into());
        return Ok(None);
    };
    let same = own.is_some_and(|own| own.eq_ignore_ascii_case(theirs));
    let apart = |what: &str| {
        let reason = format!(
            "the attitudes of the file map to {theirs}, {what}: the rotation between the two is unknown"
        );
        Err((
            reason,
            "convert the attitudes to the frame of the spec, or name their frame in its [names] \
         reference_frame"
                .into(),
        ))
    };
    let rotation = match (meaning(theirs), own.map(meaning)) {
        (Meaning::Orbit(axes), _) if turns => axes.transpose(),
        (_, _) if turns && !(same && meaning(theirs) == Meaning::Unknown) => {
            return apart("the attitudes of the spec to the frame of the orbit");
        }
        (Meaning::Inertial(theirs), Some(Meaning::Inertial(own))) => own.transpose() * theirs,
        (Meaning::Orbit(theirs), Some(Meaning::Orbit(own))) => own * theirs.transpose(),
        _ if same => return Ok(None),
        (Meaning::Inertial(_) | Meaning::Unknown, None) => {
            open.push(format!("whether {theirs} is the reference frame of the spec, which names no frame"));
            return Ok(None);
        }
        (_, Some(_)) => return apart(&format!("the attitudes of the spec to {}", own.unwrap_or_default())),
        (_, None) => return apart("which turns, the attitudes of the spec to a frame that does not turn"),
    };
    Ok((rotation != Matrix3::identity()).then_some(rotation))
}

/// Checks that the body frame `theirs` of the file is the body frame `own` of the spec. Assumptions
/// that could not be verified are appended to `open`.
pub(crate) fn of_our_body(
    theirs: Option<&str>,
    own: Option<&str>,
    open: &mut Vec<String>,
) -> Result<(), Apart> {
    let Some(theirs) = theirs else { return Ok(()) };
    match own {
        Some(own) if own.eq_ignore_ascii_case(theirs) => Ok(()),
        Some(own) => Err((
            format!(
                "the body frame of the file is {theirs}, and of the spec {own}: the rotation between \
             the two is unknown"
            ),
            "convert the attitudes to the body frame of the spec, or name the frame of the file in \
            its [names] body_frame"
                .into(),
        )),
        None if theirs.eq_ignore_ascii_case(Identity::BODY_FRAME) => Ok(()),
        None => {
            open.push(format!("whether {theirs} is the body frame of the spec, which names no frame"));
            Ok(())
        }
    }
}

/// Checks that the time of the first row is the start of the maneuver, whose duration is `duration`
/// \[s\]. Returns `None` and appends the reason to `open` if the times cannot be compared.
fn moment(found: &Attitudes, duration: f64, identity: &Identity, open: &mut Vec<String>) -> Option<Check> {
    if let Some(begins) = found.begins {
        if begins.abs() > found.printed_time {
            open.push(format!("the start: times of the file begin at {begins} s"));
        }
        return None;
    }
    match (found.epoch, identity.epoch) {
        (Some(theirs), Some(own)) => {
            let value = theirs.since(&own).abs();
            let limit = found.printed_time + MOMENT_SHARE * duration;
            Some(Check { name: MOMENT.into(), value, limit, passed: value <= limit })
        }
        (Some(_), None) => {
            open.push("the start: the spec has no epoch".into());
            None
        }
        (None, _) => {
            open.push("the start: the file has no epoch".into());
            None
        }
    }
}
