//! The plan of a sequence as one JSON document: its stops, its order, and a plan file for each leg.

use super::checksum::{Seal, Sealed, checksum};
use super::nulls::null_is_nan;
use super::plan_file::{is_of_sequence, without_mark, write_document};
use super::{ExportError, PlanFile};
use crate::identity::Identity;
use crate::spec::{LoadedSequence, SpecDocument};
use serde::{Deserialize, Serialize};
use slewkit::plan::Status;
use slewkit::sequence::joined::{Flown, Joined};
use slewkit::sequence::order::Proof;
use slewkit::sequence::{Hold, SequencePlan};
use std::io::{Read, Write};

/// What is known of the order of the stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OrderProof {
    /// The spec gives the order.
    Given,
    /// No order of these legs is better.
    AllOrders,
    /// The best order that was found, with a proved lower bound.
    LowerBound,
    /// The best of the orders that were tried: legs depend on when they begin.
    None,
}

impl OrderProof {
    /// Returns the name of the proof in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::AllOrders => "all_orders",
            Self::LowerBound => "lower_bound",
            Self::None => "none",
        }
    }
}

/// The times of a stop, in the time of the sequence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StopRecord {
    /// The name.
    pub name: String,
    /// The begin of the leg that leads there \[s\].
    pub leg_begins_s: f64,
    /// The end of that leg \[s\].
    pub arrives_s: f64,
    /// The begin of the hold \[s\].
    pub hold_begins_s: f64,
    /// The end of the hold, at which the next leg begins \[s\].
    pub leaves_s: f64,
    /// By how much the hold is late \[s\].
    pub late_s: f64,
}

/// What a file states of a sequence beside its legs, with the keys of the file in their order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SequenceRecord {
    /// Version of the file format: 1.
    pub sequence_format: u32,
    /// The program that wrote it.
    pub generator: String,
    /// The status of the plan: that of its first leg that is not solved.
    pub status: Status,
    /// The exit code of the status.
    pub exit_code: u8,
    /// Name of the sequence.
    pub name: String,
    /// The objective: "effort", "time" or "fuel".
    pub minimize: String,
    /// Cost of all legs.
    #[serde(deserialize_with = "null_is_nan")]
    pub cost: f64,
    /// The end of the last hold, seconds.
    pub duration_s: f64,
    /// By how much windows are missed, in all, seconds.
    pub late_s: f64,
    /// What is known of the order.
    pub proof: OrderProof,
    /// By how much the best order may be better than this one, relative; absent where the order is
    /// given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order_gap: Option<f64>,
    /// The stops in the order in which they are visited.
    pub stops: Vec<StopRecord>,
    /// The sequence and the settings; `null` if a spec has no notation for it.
    #[serde(default)]
    pub spec: Option<SpecDocument>,
}

/// The plan of a sequence.
///
/// Equal inputs give equal files but for `solve_time_s` of the legs.
#[derive(Clone, Debug, PartialEq)]
pub struct SequenceFile<'a> {
    /// What it states beside its legs.
    pub record: SequenceRecord,
    /// The plan of each leg, in the order of the stops.
    pub legs: Vec<PlanFile<'a>>,
    /// The motion of each hold where targets or cones move, in the same order; `None` where the body
    /// rests.
    pub holds: Vec<Option<PlanFile<'a>>>,
    /// Whether the record is the one that was written, with these legs.
    pub seal: Seal,
}

impl<'a> SequenceFile<'a> {
    /// The version written and read.
    pub const FORMAT: u32 = 1;

    /// Builds the document of a plan; the trajectories are borrowed.
    pub fn new(loaded: &LoadedSequence, plan: &'a SequencePlan) -> Self {
        let LoadedSequence { sequence, settings, identity, closed_loop, .. } = loaded;
        let legs = plan.legs.iter().map(|leg| {
            let identity = leg_identity(identity, leg.begins);
            PlanFile::new(&leg.problem, settings, &leg.plan).with_identity(&identity)
        });
        let holds = plan.legs.iter().map(|leg| {
            let Hold { problem, plan, .. } = leg.hold.as_ref()?;
            let lasting = leg.plan.solution.trajectory.time.last().copied().unwrap_or(0.0);
            let identity = leg_identity(identity, leg.begins + lasting);
            Some(PlanFile::new(problem, settings, plan).with_identity(&identity))
        });
        let holds = holds.collect();
        let stops = plan.legs.iter().map(|leg| {
            let stop = &sequence.stops[leg.stop];
            let lasting = leg.plan.solution.trajectory.time.last().copied().unwrap_or(0.0);
            StopRecord {
                name: stop.name.clone(),
                leg_begins_s: leg.begins,
                arrives_s: leg.begins + lasting,
                hold_begins_s: leg.holds[0],
                leaves_s: leg.holds[1],
                late_s: stop.visit.after(leg.begins + lasting).1,
            }
        });
        let status = plan.status();
        let record = SequenceRecord {
            sequence_format: Self::FORMAT,
            generator: PlanFile::GENERATOR.into(),
            status,
            exit_code: status.exit_code(),
            name: sequence.craft.name.clone(),
            minimize: sequence.craft.objective.name().into(),
            cost: plan.cost,
            duration_s: plan.end,
            late_s: plan.late,
            proof: match plan.order.as_ref().map(|order| order.proof) {
                None => OrderProof::Given,
                Some(Proof::AllOrders) => OrderProof::AllOrders,
                Some(Proof::LowerBound) => OrderProof::LowerBound,
                Some(Proof::None) => OrderProof::None,
            },
            order_gap: plan
                .order
                .as_ref()
                .filter(|order| order.proof != Proof::None)
                .map(|order| order.gap()),
            stops: stops.collect(),
            spec: SpecDocument::of_sequence(sequence, settings)
                .ok()
                .map(|spec| spec.with_identity(identity).with_closed_loop(closed_loop)),
        };
        Self { record, legs: legs.collect(), holds, seal: Seal::Made }
    }

    /// Writes the document with its checksums, and a last newline.
    ///
    /// # Errors
    /// A trajectory that is not finite, or the stream.
    pub fn write(&self, output: impl Write) -> Result<(), ExportError> {
        #[derive(Serialize)]
        struct Written<'a, 'b> {
            #[serde(flatten)]
            record: &'a SequenceRecord,
            legs: Vec<Sealed<'a, PlanFile<'b>>>,
            #[serde(skip_serializing_if = "Vec::is_empty")]
            holds: Vec<Option<Sealed<'a, PlanFile<'b>>>>,
            checksum: String,
        }
        for part in self.parts() {
            super::check_finite(&part.trajectory.0)?;
        }
        let legs: Vec<_> = self.legs.iter().map(Sealed::new).collect::<Result<_, _>>()?;
        let mut holds: Vec<_> = self
            .holds
            .iter()
            .map(|hold| hold.as_ref().map(Sealed::new).transpose())
            .collect::<Result<_, _>>()?;
        let sums: Vec<_> = legs.iter().chain(holds.iter().flatten()).map(Sealed::checksum).collect();
        let checksum = checksum(&(&self.record, sums))?;
        if holds.iter().all(Option::is_none) {
            holds.clear();
        }
        write_document(&Written { record: &self.record, legs, holds, checksum }, output)
    }

    /// Reads a document, and compares it and its legs with their checksums.
    ///
    /// # Errors
    /// Returns an error of the stream, or of a text that is not the plan of a sequence.
    pub fn read(input: impl Read) -> Result<SequenceFile<'static>, ExportError> {
        #[derive(Deserialize)]
        struct Document {
            #[serde(flatten)]
            record: SequenceRecord,
            legs: Vec<PlanFile<'static>>,
            #[serde(default)]
            holds: Vec<Option<PlanFile<'static>>>,
            #[serde(default)]
            checksum: Seal,
        }
        let Document { record, legs, mut holds, checksum } = serde_json::from_reader(without_mark(input)?)?;
        if record.sequence_format != Self::FORMAT {
            return Err(ExportError::Format { found: record.sequence_format });
        }
        let told: Vec<&str> =
            legs.iter().chain(holds.iter().flatten()).map(|part| part.seal.text()).collect();
        let own = record.generator == PlanFile::GENERATOR && record.spec.is_some();
        let seal = checksum.compared(&(&record, told), own);
        let legs: Vec<_> = legs.into_iter().map(PlanFile::checked).collect::<Result<_, _>>()?;
        holds.resize_with(legs.len(), || None);
        let checked = |hold: Option<PlanFile<'static>>| hold.map(PlanFile::checked).transpose();
        let holds = holds.into_iter().map(checked).collect::<Result<_, _>>()?;
        Ok(SequenceFile { record, legs, holds, seal })
    }

    /// Returns the plans of all legs and holds.
    pub(super) fn parts(&self) -> impl Iterator<Item = &PlanFile<'a>> {
        self.legs.iter().chain(self.holds.iter().flatten())
    }

    /// Returns whether a text with these first bytes is the plan of a sequence.
    pub fn begins(text: &[u8]) -> bool {
        is_of_sequence(text)
    }

    /// Returns the motion over all legs and the rests between them.
    pub fn joined(&self) -> Joined {
        let legs = self.legs.iter().zip(&self.record.stops).zip(&self.holds);
        Joined::of(legs.map(|((leg, stop), hold)| Flown {
            path: &leg.trajectory.0,
            begins: stop.leg_begins_s,
            hold: hold.as_ref().map(|hold| &*hold.trajectory.0),
            until: stop.leaves_s,
        }))
    }
}

/// Returns the names of a sequence for a leg that begins at a time \[s\].
fn leg_identity(identity: &Identity, begins: f64) -> Identity {
    let epoch = identity.epoch.map(|epoch| epoch.after(begins));
    Identity { epoch, scenery: None, ..identity.clone() }
}
