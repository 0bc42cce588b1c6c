//! Conversion of a pointing file to a sequence of stops, and of the plan of the sequence to a
//! pointing file.
//!
//! Observations become stops that begin and end at the times of the file; slews become the legs
//! between them. Time zero of the sequence is the epoch of the spec, at which the spacecraft is in
//! the start state of the spec. If the spec has no epoch, time zero is the end of the first
//! observation, at which the spacecraft is in the attitude of that observation.

use super::{Observation, PointingFile, Roll, Target};
use crate::epoch::Epoch;
use crate::exchange::frames::{Meaning, meaning};
use crate::exchange::{into_our_frame, of_our_body};
use crate::identity::Identity;
use crate::spec::{Diagnostic, Diagnostics};
use slewkit::maneuver::{Aim, Objective, Problem, State};
use slewkit::numerics::figures::short;
use slewkit::sequence::order::Visit;
use slewkit::sequence::{Ordering, Place, Sequence, SequencePlan, Stop};
use slewkit::{Direction, Matrix3, Vector3, lie};
use slewkit_sky::{EarthRotation, Sky};

/// A sequence of stops that corresponds to a pointing file.
#[derive(Clone, Debug)]
pub struct Timeline {
    /// The sequence. It has a stop for each observation from index [`Self::first`] on.
    pub sequence: Sequence,
    /// Epoch of time zero of the sequence.
    pub zero: Epoch,
    /// Index of the observation that is the first stop. It is 1 if the sequence starts at the end
    /// of the first observation, otherwise 0.
    pub first: usize,
    /// Assumptions that could not be verified, one sentence each, without the final period.
    pub open: Vec<String>,
    /// Rotation from components in the reference frame of the spec to components in the frame of
    /// the file.
    to_file: Matrix3,
}

impl Timeline {
    /// Creates the sequence that corresponds to a pointing file. `craft` supplies the spacecraft
    /// and its start; `identity` supplies the names of the frames and the epoch of the start.
    /// `name` is the name of the file in messages. The direction of the Sun is computed as seen
    /// from the centre of the Earth in the middle of an observation, and is constant during the
    /// observation.
    ///
    /// # Errors
    /// Returns a diagnostic if the rotation between the frames is unknown, if no time is left for a
    /// slew, if the first observation cannot be the start, or if the axes of a roll are parallel.
    pub fn new(
        file: &PointingFile,
        name: &str,
        craft: &Problem,
        identity: &Identity,
    ) -> Result<Self, Diagnostics> {
        let told = |code, reason: String, remedy: &str| {
            Diagnostics(vec![Diagnostic::about_file(code, name, reason, remedy)])
        };
        let mut open = file.not_taken.clone();
        let apart = |(reason, remedy): (String, String)| told("E0152", reason, &remedy);
        let turns = craft.environment.frame_rate().amax() > 0.0;
        let theirs = Some(file.reference_frame.as_str());
        let to_ours = into_our_frame(theirs, identity.reference_frame.as_deref(), turns, &mut open)
            .map_err(apart)?
            .unwrap_or_else(Matrix3::identity);
        of_our_body(Some(&file.body_frame), identity.body_frame.as_deref(), &mut open).map_err(apart)?;
        if file.observations.iter().any(|observation| observation.target == Target::Sun) {
            open.push("the Sun is seen from the centre of the Earth, not from the orbit of the file".into());
        }
        let named = |index: usize| match &file.observations[index].name {
            Some(name) => name.clone(),
            None => format!("observation {}", index + 1),
        };

        let place = |index: usize| -> Result<Place, Diagnostics> {
            let observation = &file.observations[index];
            let target = match observation.target {
                Target::Inertial(direction) => Some(direction),
                Target::Sun => sun_in(&file.reference_frame, observation),
            };
            let Some(target) = target else {
                let reason = format!("the direction to the Sun in {} is not known", named(index));
                return Err(told("E0155", reason, "give its direction as an inertial target"));
            };
            if observation.roll == Roll::Free {
                let at = Direction::Fixed((to_ours * target).normalize());
                return Ok(Place::Aim(Aim::new(observation.boresight, at).at_rest()));
            }
            let attitude = observation.attitude(&target).ok_or_else(|| {
                let reason = format!("the axes of {} define no roll: two are parallel", named(index));
                told("E0155", reason, "define its phase angle by other axes")
            })?;
            Ok(Place::Attitude(lie::project_to_rotation(&(to_ours * attitude))))
        };

        let mut craft = craft.clone();
        let (zero, first) = match (identity.epoch, file.observations.first()) {
            (Some(epoch), _) => (epoch, 0),
            (None, Some(observation)) => {
                let Place::Attitude(attitude) = place(0)? else {
                    let reason = format!("the sequence starts in {}, whose roll is free", named(0));
                    return Err(told(
                        "E0155",
                        reason,
                        "add an epoch to the spec, so that [start] is the start",
                    ));
                };
                craft.start = State::attitude(attitude, Vector3::zeros());
                (observation.end, 1)
            }
            (None, None) => return Err(told("E0155", "the file has no observation".into(), "give one")),
        };
        let mut stops = Vec::with_capacity(file.observations.len());
        let mut free_from = 0.0;
        for (index, observation) in file.observations.iter().enumerate().skip(first) {
            let window = [&observation.begin, &observation.end].map(|moment| moment.since(&zero));
            if window[0] <= free_from {
                let (before, late) = match index {
                    0 => ("the start of the maneuver".into(), window[0]),
                    _ => (named(index - 1), window[0] - free_from),
                };
                let reason = format!(
                    "the slew from {before} to {} has only {} s: it needs a positive duration",
                    named(index),
                    short(late)
                );
                return Err(told("E0155", reason, "move the observation, or the epoch of the spec"));
            }
            let visit = Visit { settling: 0.0, hold: observation.lasting(), window, pinned: true };
            stops.push(Stop { name: named(index), place: place(index)?, visit, passing: None });
            free_from = window[1];
        }
        // The durations of minimum-time legs are results; all other legs use the time that the file
        // leaves for them.
        if !matches!(craft.objective, Objective::Time) {
            craft.duration = free_from.into();
        }
        let sequence = Sequence { craft, stops, order: Ordering::Given };
        Ok(Self { sequence, zero, first, open, to_file: to_ours.transpose() })
    }

    /// Returns the time available for each leg \[s\], from the end of the previous hold to the
    /// start of the hold after the leg.
    pub fn available(&self) -> Vec<f64> {
        let mut free_from = 0.0;
        let gap = |stop: &Stop| {
            let available = stop.visit.window[0] - stop.visit.settling - free_from;
            free_from = stop.visit.window[1];
            available
        };
        self.sequence.stops.iter().map(gap).collect()
    }

    /// Returns the pointing file with the times and attitudes of a plan of the sequence. Free rolls
    /// are replaced by the rolls of the plan, and every target becomes an inertial direction.
    pub fn resolved(&self, file: &PointingFile, plan: &SequencePlan) -> PointingFile {
        let mut found = file.clone();
        for leg in &plan.legs {
            let Some(observation) = found.observations.get_mut(self.first + leg.stop) else { continue };
            let [begin, end] = leg.holds.map(|time| self.zero.after(time));
            let asked = observation.roll == Roll::Free || observation.target == Target::Sun;
            let attitude = leg.plan.solution.trajectory.quaternion.last().filter(|_| asked);
            let attitude = attitude.map(|last| self.to_file * lie::rotation_from_quaternion(last));
            let flown = match attitude {
                Some(attitude) => observation.in_attitude(&attitude),
                None => observation.clone(),
            };
            *observation = Observation { begin, end, ..flown };
        }
        found
    }
}

/// Returns the unit vector from the centre of the Earth to the Sun in the middle of an observation,
/// in the axes of the frame `frame`; `None` if the frame is not known to be inertial.
fn sun_in(frame: &str, observation: &Observation) -> Option<Vector3> {
    let Meaning::Inertial(to_icrf) = meaning(frame) else { return None };
    let middle = observation.begin.after(0.5 * observation.lasting());
    let sky = Sky::new(middle.clock(), None, EarthRotation::default());
    let sun = sky.way(&slewkit_sky::Target::Sun, 0.0, 1.0).ok()?.at(0.0)[0];
    super::unit(to_icrf.transpose() * sun)
}
