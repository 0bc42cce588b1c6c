//! The plan of a sequence as one JSON document: its stops, their order, and a plan file for each
//! leg.

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

/// Degree to which the order of the stops is proved to be the best order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OrderProof {
    /// The spec prescribes the order.
    Given,
    /// All orders of the planned legs were compared; no other order is better.
    AllOrders,
    /// The order is the best order found, and a lower bound on the cost of any order is proved.
    LowerBound,
    /// The order is the best of those tried. Its optimality is not proved, because the legs depend
    /// on the times at which they begin.
    None,
}

impl OrderProof {
    /// Returns the name of this degree of proof in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::AllOrders => "all_orders",
            Self::LowerBound => "lower_bound",
            Self::None => "none",
        }
    }
}

/// Times of a stop, counted from the start of the sequence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StopRecord {
    /// Name of the stop.
    pub name: String,
    /// Time at which the leg to the stop begins \[s\].
    pub leg_begins_s: f64,
    /// Time at which the leg to the stop ends \[s\].
    pub arrives_s: f64,
    /// Time at which the hold begins \[s\].
    pub hold_begins_s: f64,
    /// Time at which the hold ends and the next leg begins \[s\].
    pub leaves_s: f64,
    /// Delay of the hold past the end of the window of the stop \[s\].
    pub late_s: f64,
}

/// Contents of the plan file of a sequence except its legs, with the keys in the order of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SequenceRecord {
    /// Version of the file format, which is 1.
    pub sequence_format: u32,
    /// Name and version of the program that wrote the file.
    pub generator: String,
    /// Status of the plan. If some legs are not solved, it is the status of the first of them.
    pub status: Status,
    /// Exit code of the program for this status.
    pub exit_code: u8,
    /// Name of the sequence.
    pub name: String,
    /// Objective of the plan: "effort", "time" or "fuel".
    pub minimize: String,
    /// Total cost of the legs.
    #[serde(deserialize_with = "null_is_nan")]
    pub cost: f64,
    /// Time at which the last hold ends \[s\].
    pub duration_s: f64,
    /// Total delay of the stops past the ends of their windows \[s\].
    pub late_s: f64,
    /// Degree to which the order of the stops is proved to be the best order.
    pub proof: OrderProof,
    /// Upper bound on the relative cost reduction by any other order; absent if the spec prescribes
    /// the order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order_gap: Option<f64>,
    /// Stops, in the order of the visit.
    pub stops: Vec<StopRecord>,
    /// Spec of the sequence with the settings of the solver; `null` if a spec cannot express the
    /// sequence.
    #[serde(default)]
    pub spec: Option<SpecDocument>,
}

/// The plan of a sequence, as a file contains it.
///
/// Equal inputs give equal files, except for `solve_time_s` of the legs.
#[derive(Clone, Debug, PartialEq)]
pub struct SequenceFile<'a> {
    /// Contents of the file except the legs.
    pub record: SequenceRecord,
    /// Plan of each leg, in the order of the stops.
    pub legs: Vec<PlanFile<'a>>,
    /// Motion during each hold, in the order of the stops; `None` if the body rests. It exists for
    /// holds on moving targets and for holds during which cones move.
    pub holds: Vec<Option<PlanFile<'a>>>,
    /// Result of comparing the contents with the checksum of the file.
    pub seal: Seal,
}

impl<'a> SequenceFile<'a> {
    /// Version of the file format that this program writes and reads.
    pub const FORMAT: u32 = 1;

    /// Creates the document of a plan; it borrows the trajectories.
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

    /// Writes the document with its checksums and a final newline.
    ///
    /// # Errors
    /// Returns an error if a trajectory has a number that is not finite, or if the stream fails.
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

    /// Reads a document and compares it and its legs with their checksums.
    ///
    /// # Errors
    /// Returns an error if the stream fails, or if the text is not the plan of a sequence.
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

    /// Returns whether a text that begins with these bytes is the plan file of a sequence.
    pub fn begins(text: &[u8]) -> bool {
        is_of_sequence(text)
    }

    /// Returns the motion over all legs and the holds between them as one trajectory.
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

/// Returns the names of the sequence, and the epoch of a leg that begins `begins` \[s\] after the
/// start of the sequence.
fn leg_identity(identity: &Identity, begins: f64) -> Identity {
    let epoch = identity.epoch.map(|epoch| epoch.after(begins));
    Identity { epoch, scenery: None, ..identity.clone() }
}
