//! Preparation of simulated flights: the plan of a maneuver, or the plan of a sequence as one
//! motion.

use crate::export::{ExportError, Own, PlanFile, SequenceFile};
use crate::spec::{Loaded, LoadedSequence};
use slewkit::assured::{Beside, NotKnown};
use slewkit::maneuver::Problem;
use slewkit::optimize::discrete::linear_plan::Unlinearised;
use slewkit::sequence::WholeMotion;
use slewkit::sequence::flown::{LegMotion, Motion};
use thiserror::Error;

/// An instant at which the spacecraft must have reached a stop.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Name of the stop.
    pub stop: String,
    /// Event at this instant: "hold begins", "hold ends" or "passed".
    pub event: &'static str,
    /// Time of the event since the start of the sequence \[s\].
    pub time: f64,
    /// Index of the node of the motion at this instant.
    pub node: usize,
}

/// A motion that is to be flown, with the gains and covariances along it.
#[derive(Clone, Debug)]
pub struct WholeFlight {
    /// Maneuver to which the motion belongs; for a sequence, the joined maneuver.
    pub problem: Problem,
    /// Feedback gains and covariances along the motion.
    pub beside: Beside,
    /// Instants at which the spacecraft must have reached a stop; empty for a single maneuver.
    pub marks: Vec<Mark>,
}

/// Reason why the flights of a plan cannot be simulated.
#[derive(Debug, Error)]
pub enum NotFlown {
    /// A leg or hold does not fit its spec, or its file has no spec.
    #[error(transparent)]
    File(#[from] ExportError),
    /// The motion cannot be linearised, or has too many steps.
    #[error(transparent)]
    Motion(#[from] Unlinearised),
    /// The gains or covariances cannot be computed.
    #[error(transparent)]
    Near(#[from] NotKnown),
}

impl NotFlown {
    /// Returns the remedy for the error.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::File(_) => "write the plan again with slew plan",
            Self::Motion(_) => "plan it with shorter holds, or legs with fewer steps",
            Self::Near(_) => "give [feedback] kind = \"tvlqr\", or remove [feedback]",
        }
    }
}

impl WholeFlight {
    /// Computes the gains and covariances along the plan of a maneuver.
    ///
    /// # Errors
    /// Returns an error if the trajectory does not fit the maneuver, or if gains or covariances
    /// cannot be computed.
    pub fn of_maneuver(file: &PlanFile<'_>, loaded: &Loaded) -> Result<Self, NotFlown> {
        let problem = file.on_grid(&loaded.problem)?;
        let closed_loop = &loaded.closed_loop;
        let uncertainty = closed_loop.uncertainty.as_ref();
        let beside = Beside::along(&problem, &file.trajectory.0, closed_loop.feedback, uncertainty)?;
        Ok(Self { problem, beside, marks: Vec::new() })
    }

    /// Joins the legs and holds of a sequence to one motion, and computes the gains and covariances
    /// along it.
    ///
    /// # Errors
    /// Returns an error if a leg or hold has no spec or does not fit it, or if gains or covariances
    /// cannot be computed.
    pub fn of(file: &SequenceFile<'_>, loaded: &LoadedSequence) -> Result<Self, NotFlown> {
        let on_grid = |part: &PlanFile<'_>| part.on_grid(&Own::of(part)?.problem);
        let legs = file.legs.iter().map(on_grid).collect::<Result<Vec<_>, _>>()?;
        let holds = file.holds.iter().map(|hold| hold.as_ref().map(on_grid).transpose());
        let holds = holds.collect::<Result<Vec<_>, _>>()?;
        let motions: Vec<LegMotion<'_>> = file
            .legs
            .iter()
            .zip(&file.holds)
            .zip(&file.record.stops)
            .zip(legs.iter().zip(&holds))
            .map(|(((leg, hold), stop), (problem, of_hold))| LegMotion {
                leg: Motion { problem, path: &leg.trajectory.0 },
                hold: hold
                    .as_ref()
                    .zip(of_hold.as_ref())
                    .map(|(hold, problem)| Motion { problem, path: &hold.trajectory.0 }),
                begins: stop.leg_begins_s,
                holds: [stop.hold_begins_s, stop.leaves_s],
            })
            .collect();
        let whole = WholeMotion::of(&loaded.sequence, &motions)?;
        let passes =
            |name: &str| loaded.sequence.stops.iter().any(|stop| stop.name == name && stop.passing.is_some());
        let marks = whole.instants.iter().map(|instant| {
            let stop = file.record.stops[instant.leg].name.clone();
            let event = match instant.ends {
                true => "hold ends",
                false if passes(&stop) => "passed",
                false => "hold begins",
            };
            Mark { stop, event, time: whole.path.time[instant.node], node: instant.node }
        });
        let marks = marks.collect();
        let closed_loop = &loaded.closed_loop;
        let feedback = closed_loop.feedback.map(|feedback| feedback.with_default_weights(whole.weights()));
        let uncertainty = closed_loop.uncertainty.as_ref();
        let beside = Beside::along_motion(&whole.problem, &whole.path, whole.stops(), feedback, uncertainty)?;
        Ok(Self { problem: whole.problem, beside, marks })
    }
}
