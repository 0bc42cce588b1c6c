//! A plan that is flown: the plan of a maneuver, or that of a sequence as one motion.

use crate::export::{ExportError, Own, PlanFile, SequenceFile};
use crate::spec::{Loaded, LoadedSequence};
use slewkit::assured::{Beside, NotKnown};
use slewkit::maneuver::Problem;
use slewkit::optimize::discrete::linear_plan::Unlinearised;
use slewkit::sequence::WholeMotion;
use slewkit::sequence::flown::{LegMotion, Motion};
use thiserror::Error;

/// An instant at which the craft has to be at a stop.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// The name of the stop.
    pub stop: String,
    /// What happens then: "hold begins", "hold ends", or "passed".
    pub event: &'static str,
    /// Time from the start of the sequence \[s\].
    pub time: f64,
    /// The node of the motion.
    pub node: usize,
}

/// The motion that is flown, with the quantities near it.
#[derive(Clone, Debug)]
pub struct WholeFlight {
    /// The maneuver of which it is the motion.
    pub problem: Problem,
    /// Gains and covariances along it.
    pub beside: Beside,
    /// The instants at which the craft has to be at a stop; none for a single maneuver.
    pub marks: Vec<Mark>,
}

/// The reason for which a plan cannot be flown.
#[derive(Debug, Error)]
pub enum NotFlown {
    /// A leg does not fit its spec, or has none.
    #[error(transparent)]
    File(#[from] ExportError),
    /// The motion cannot be followed, or has too many steps.
    #[error(transparent)]
    Motion(#[from] Unlinearised),
    /// The gains or covariances do not exist.
    #[error(transparent)]
    Near(#[from] NotKnown),
}

impl NotFlown {
    /// Returns the remedy, for a message.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::File(_) => "write the plan again with slew plan",
            Self::Motion(_) => "plan it with shorter holds, or legs with fewer steps",
            Self::Near(_) => "give [feedback] kind = \"tvlqr\", or remove [feedback]",
        }
    }
}

impl WholeFlight {
    /// Computes the quantities near the plan of a maneuver.
    ///
    /// # Errors
    /// [`NotFlown`].
    pub fn of_maneuver(file: &PlanFile<'_>, loaded: &Loaded) -> Result<Self, NotFlown> {
        let problem = file.on_grid(&loaded.problem)?;
        let closed_loop = &loaded.closed_loop;
        let uncertainty = closed_loop.uncertainty.as_ref();
        let beside = Beside::along(&problem, &file.trajectory.0, closed_loop.feedback, uncertainty)?;
        Ok(Self { problem, beside, marks: Vec::new() })
    }

    /// Joins the legs and holds of a file, and computes the quantities near their motion.
    ///
    /// # Errors
    /// [`NotFlown`].
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
