//! A plan as one JSON document, streamed both ways.

use super::checksum::{Seal, Sealed};
use super::nulls::null_is_nan;
use super::{ExportError, TrajectoryDocument, TrajectoryError, check_trajectory};
use crate::flown::{FeedbackRecord, MarginsRecord, UncertaintyRecord};
use crate::identity::Identity;
use crate::spec::{ClosedLoop, SpecDocument};
use serde::{Deserialize, Serialize};
use serde_json::ser::{CompactFormatter, Formatter};
use slewkit::Vector3;
use slewkit::assured::{Beside, Margins};
use slewkit::feedback::Gains;
use slewkit::maneuver::Shortfall;
use slewkit::maneuver::{
    ActiveConstraint, ChosenSteps, ConvexWork, InteriorWork, Landing, Method, Optimality, Outcome, Problem,
    Proved, Rival, RungReport, Scheme, SecondOrder, Sense, Settings, Switching, TerminalError,
};
use slewkit::numerics::encoding;
use slewkit::plan::{Guess, Plan, Status};
use slewkit::verify::{Accuracy, Verification};
use std::borrow::Cow;
use std::io::{self, BufRead, BufReader, BufWriter, Read, Write};

/// A plan and the record of its search, with the keys of the file in their order.
///
/// Equal inputs give equal files but for `solve_time_s`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanFile<'a> {
    /// Version of the file format: 2.
    pub format: u32,
    /// The program that wrote it.
    pub generator: String,
    /// The status of the plan.
    pub status: Status,
    /// The exit code of the status.
    pub exit_code: u8,
    /// Name of the maneuver.
    pub name: String,
    /// The solver: "shooting", "scp" for sequential convex programming, or "interior_point".
    pub method: String,
    /// The scheme: "lie_verlet" or "lie_euler".
    pub scheme: String,
    /// Number of steps.
    pub steps: usize,
    /// The step in seconds: the mean where the steps are not equal.
    #[serde(deserialize_with = "null_is_nan")]
    pub step_s: f64,
    /// Cost.
    #[serde(deserialize_with = "null_is_nan")]
    pub cost: f64,
    /// Duration, seconds.
    #[serde(deserialize_with = "null_is_nan")]
    pub duration_s: f64,
    /// Newton iterations of the winning start.
    pub iterations: usize,
    /// Wall time of the solve alone, seconds: the only key that differs between two runs.
    pub solve_time_s: f64,
    /// The outcome of the solve.
    pub outcome: Outcome,
    /// The start that led to the plan.
    pub start: String,
    /// Rotation sense of the path.
    pub sense: Sense,
    /// Total angle turned, degrees.
    #[serde(deserialize_with = "null_is_nan")]
    pub turned_deg: f64,
    /// Tolerance of the scaled terminal error.
    pub tolerance: f64,
    /// Discrete terminal error.
    #[serde(deserialize_with = "null_is_nan")]
    pub terminal: TerminalError,
    /// The corrections of landing, if landing was tried; the trajectory has the discrete target.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub landing: Option<Landing>,
    /// The choice of the number of steps, if none was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chosen: Option<ChosenSteps>,
    /// Optimality of the extremal.
    #[serde(deserialize_with = "null_is_nan")]
    pub optimality: Optimality,
    /// The degree to which the plan is proved to be an optimum; absent without a plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proof: Option<Proved>,
    /// The result of its count of conjugate points.
    pub second_order: SecondOrder,
    /// The results of the witnesses; `null` without a trajectory.
    #[serde(deserialize_with = "null_is_nan")]
    pub verified: Option<Verification>,
    /// The miss of the motion under the recorded torques, and the number of steps that would
    /// suffice.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "null_is_nan")]
    pub accuracy: Option<Accuracy>,
    /// Everything tried, in order.
    #[serde(deserialize_with = "null_is_nan")]
    pub ladder: Vec<RungReport>,
    /// The work of the convex iteration, if it ran.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub convex: Option<ConvexRecord>,
    /// The work of the interior point, if it found the plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interior_point: Option<InteriorWork>,
    /// The active limits and constraints, with their times and multipliers.
    #[serde(default, deserialize_with = "null_is_nan")]
    pub active: Vec<ActiveConstraint>,
    /// Arcs, switching times and certificate, where time or fuel is minimised.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "null_is_nan")]
    pub switching: Option<Switching>,
    /// Other extremals found.
    #[serde(deserialize_with = "null_is_nan")]
    pub rivals: Vec<Rival>,
    /// The gains along the plan, if `[feedback]` requests them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feedback: Option<FeedbackRecord>,
    /// The covariances along the plan, if the spec states an uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyRecord>,
    /// The proof that no input can meet the terminal conditions, if one was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstruction: Option<String>,
    /// A duration below which no plan exists, seconds, as proved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest_duration_s: Option<f64>,
    /// The remaining violations of the nearest iterate, and possible remedies, if no plan was
    /// found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortfall: Option<String>,
    /// The shortest duration that was found, a local minimum, seconds, if no plan was found for
    /// the requested one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest_found_s: Option<f64>,
    /// A longer duration that has a plan, seconds: a plan was found for it, or it suffices for a
    /// turn about a fixed axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longer_s: Option<f64>,
    /// The maneuver, on the grid of the plan, and the settings; `null` if a spec has no notation
    /// for it.
    #[serde(default)]
    pub spec: Option<SpecDocument>,
    /// The unknown of the shooting, SI; a guess for another plan.
    pub costates_0: Vec<f64>,
    /// The trajectory.
    pub trajectory: TrajectoryDocument<'a>,
    /// Whether the contents are unchanged since the file was written; the file has a checksum as
    /// its last key.
    #[serde(default, rename = "checksum", skip_serializing)]
    pub seal: Seal,
}

/// The work of the convex iteration, without its time, which differs between two runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConvexRecord {
    /// Subproblems of the winning seed, on all its grids.
    pub subproblems: usize,
    /// Subproblems of all seeds.
    pub all_subproblems: usize,
    /// Interior-point iterations of all.
    pub cone_iterations: u32,
}

impl From<&ConvexWork> for ConvexRecord {
    fn from(work: &ConvexWork) -> Self {
        let ConvexWork { subproblems, all_subproblems, cone_iterations, .. } = *work;
        Self { subproblems, all_subproblems, cone_iterations }
    }
}

impl<'a> PlanFile<'a> {
    /// The version written and read.
    pub const FORMAT: u32 = 2;
    /// The name and the version of this program.
    pub const GENERATOR: &'static str = concat!("slewkit ", env!("CARGO_PKG_VERSION"));

    /// Builds the document of a plan; the trajectory is borrowed.
    pub fn new(problem: &Problem, settings: &Settings, plan: &'a Plan) -> Self {
        let solution = &plan.solution;
        let problem = &solution.on_grid(problem);
        Self {
            format: Self::FORMAT,
            generator: Self::GENERATOR.into(),
            status: plan.status,
            exit_code: plan.status.exit_code(),
            name: problem.name.clone(),
            method: solution.method.name().into(),
            scheme: solution.scheme.name().into(),
            steps: solution.steps,
            step_s: solution.step,
            cost: solution.cost,
            duration_s: solution.duration(problem),
            iterations: solution.iterations,
            solve_time_s: solution.solve_time,
            outcome: solution.outcome,
            start: solution.start.clone(),
            sense: solution.sense,
            turned_deg: solution.turned_deg,
            tolerance: solution.tolerance,
            terminal: solution.terminal,
            landing: solution.landing.clone(),
            chosen: solution.chosen,
            optimality: solution.optimality,
            proof: solution.proved(problem),
            second_order: solution.optimality.second_order(),
            verified: plan.verification.clone(),
            accuracy: plan
                .verification
                .as_ref()
                .map(|found| Accuracy::of(found, problem, settings.continuous_limit())),
            ladder: solution.ladder.clone(),
            convex: solution.convex.as_ref().map(Into::into),
            interior_point: solution.interior.clone(),
            active: solution.active.clone(),
            switching: solution.switching.clone(),
            rivals: solution.rivals.clone(),
            feedback: None,
            uncertainty: None,
            obstruction: solution.infeasible.as_ref().map(|proof| proof.reason.clone()),
            shortest_duration_s: solution.infeasible.as_ref().and_then(|proof| proof.duration_lower_bound),
            shortfall: solution.shortfall.as_ref().map(Shortfall::to_string),
            shortest_found_s: solution.shortest,
            longer_s: solution.longer,
            spec: SpecDocument::new(problem, settings).ok(),
            costates_0: solution.costates_0(problem).to_vec(),
            trajectory: TrajectoryDocument(Cow::Borrowed(&solution.trajectory)),
            seal: Seal::Made,
        }
    }

    /// Adds the identity of the maneuver: its names and its epoch.
    pub fn with_identity(mut self, identity: &Identity) -> Self {
        self.spec = self.spec.map(|spec| spec.with_identity(identity));
        self
    }

    /// Adds the quantities near the plan, and the sections of the spec that request them.
    pub fn with_beside(
        mut self,
        problem: &Problem,
        beside: Option<&Beside>,
        closed_loop: &ClosedLoop,
        margins: Option<&Margins>,
    ) -> Self {
        self.spec = self.spec.map(|spec| spec.with_closed_loop(closed_loop));
        if let Some(beside) = beside {
            self.feedback = FeedbackRecord::new(problem, beside);
            self.uncertainty = UncertaintyRecord::new(problem, beside, closed_loop.uncertainty.as_ref());
            if let Some(uncertainty) = &mut self.uncertainty {
                uncertainty.margins = margins.map(|margins| MarginsRecord::new(closed_loop, margins));
            }
        }
        self
    }

    /// Adds gains without a covariance, and the sections of the spec that request them.
    pub fn with_gains(mut self, problem: &Problem, gains: &Gains, closed_loop: &ClosedLoop) -> Self {
        self.spec = self.spec.map(|spec| spec.with_closed_loop(closed_loop));
        self.feedback = Some(FeedbackRecord::of_gains(problem, gains));
        self
    }

    /// Adds the records of another file of the plan, and the sections of the spec that request
    /// them.
    pub fn with_records(
        mut self,
        feedback: Option<FeedbackRecord>,
        uncertainty: Option<UncertaintyRecord>,
        closed_loop: &ClosedLoop,
    ) -> Self {
        self.spec = self.spec.map(|spec| spec.with_closed_loop(closed_loop));
        Self { feedback, uncertainty, ..self }
    }

    /// Writes the document with its checksum, one key a line, and a last newline.
    ///
    /// # Errors
    /// A trajectory that is not finite, or the stream.
    pub fn write(&self, output: impl Write) -> Result<(), ExportError> {
        super::columns::check_finite(&self.trajectory.0)?;
        write_document(&Sealed::new(self)?, output)
    }

    /// Reads a document, compares it with its checksum, and refuses a trajectory whose length
    /// differs from `steps`.
    ///
    /// # Errors
    /// Returns an error of the stream, of a text that is not a plan, or of arrays that do not fit
    /// together.
    pub fn read(input: impl Read) -> Result<PlanFile<'static>, ExportError> {
        let mut input = without_mark(input)?;
        if is_of_sequence(input.fill_buf()?) {
            return Err(ExportError::Sequence);
        }
        PlanFile::checked(serde_json::from_reader(input)?)
    }

    /// Compares a file that was read with its checksum.
    pub(super) fn checked(mut file: PlanFile<'static>) -> Result<PlanFile<'static>, ExportError> {
        if file.format != Self::FORMAT {
            return Err(ExportError::Format { found: file.format });
        }
        // Only a spec that is given judges a file without its own, whose checksum covered it.
        let own = file.generator == Self::GENERATOR && file.spec.is_some();
        file.seal = file.seal.compared(&file, own);
        Ok(file)
    }

    /// Returns whether a text with these first bytes is a plan file, and not a message or a table
    /// of attitudes. An empty text, or one that is not text, counts as a plan file, so that its
    /// reader reports the error.
    pub fn begins(text: &[u8]) -> bool {
        // The reader of attitudes reports a file that is not text.
        if encoding::is_utf16(text) || encoding::binary(text).is_some() {
            return false;
        }
        let text = text.strip_prefix(encoding::MARK).unwrap_or(text);
        let first = text.iter().find(|byte| !byte.is_ascii_whitespace()).copied();
        first.is_none_or(|first| matches!(first, b'{' | b'[') || !(first.is_ascii_graphic() || first >= 0x80))
    }

    /// Returns the scheme of the plan; `None` when its name is not known.
    pub fn scheme(&self) -> Option<Scheme> {
        [Scheme::LieEuler, Scheme::LieVerlet].into_iter().find(|scheme| scheme.name() == self.scheme)
    }

    /// Returns `problem` on the grid of this plan, if the trajectory fits it.
    ///
    /// # Errors
    /// The arrays that do not fit, or [`ExportError::NoMotion`].
    pub fn on_grid(&self, problem: &Problem) -> Result<Problem, ExportError> {
        let scheme = self.scheme().ok_or_else(|| ExportError::Scheme(self.scheme.clone()))?;
        let steps = self.steps;
        // A plan of least time has no step if the body is already where it should be.
        let none = steps == 0 && problem.seeks_duration() && self.trajectory.0.time.len() <= 1;
        if self.outcome != Outcome::Converged && self.trajectory.0.time.is_empty() {
            return Err(ExportError::NoMotion);
        }
        if !none && !(Problem::MIN_STEPS..=Problem::MAX_STEPS).contains(&steps) {
            let (found, needed) = (steps, Problem::MAX_STEPS);
            return Err(TrajectoryError::Shape { key: "steps", of: "steps", found, needed }.into());
        }
        if none {
            return Ok(problem.clone());
        }
        let mut of_chain = [Method::Scp, Method::InteriorPoint].into_iter();
        let own = of_chain.find(|method| method.name() == self.method);
        let arcs = self.method == Method::Shooting.name() && self.switching.is_some();
        let planned = match problem.clone() {
            problem if arcs => problem.planned_on_arcs(),
            problem => problem.planned_by(own.unwrap_or(Method::Auto)),
        };
        let problem = self.trajectory.0.completed(&planned).with_steps(steps).with_scheme(scheme);
        check_trajectory(&self.trajectory.0, &problem)?;
        Ok(problem)
    }
}

/// The first key of the plan of a sequence.
const SEQUENCE: &[u8] = b"\"sequence_format\":";

/// Returns whether a text with these first bytes is the plan of a sequence.
pub(super) fn is_of_sequence(text: &[u8]) -> bool {
    text.windows(SEQUENCE.len()).any(|part| part == SEQUENCE)
}

/// Reads the guess for another plan from a plan file: its costates, and the poses of its
/// trajectory.
///
/// # Errors
/// Returns an error of the stream, of a text that is not a plan, or of another version of the
/// format.
pub fn read_guess(input: impl Read) -> Result<Guess, ExportError> {
    #[derive(Deserialize)]
    struct Document {
        format: u32,
        costates_0: Vec<f64>,
        #[serde(default)]
        trajectory: Path,
    }
    #[derive(Default, Deserialize)]
    struct Path {
        #[serde(default)]
        quaternion_wxyz: Vec<[f64; 4]>,
        #[serde(default)]
        position_m: Vec<[f64; 3]>,
    }
    let Document { format, costates_0, trajectory } = serde_json::from_reader(without_mark(input)?)?;
    // Older plans have the same trajectory.
    if !(1..=PlanFile::FORMAT).contains(&format) {
        return Err(ExportError::Format { found: format });
    }
    let Path { quaternion_wxyz: quaternion, position_m } = trajectory;
    let position = position_m.into_iter().map(Vector3::from).collect();
    Ok(Guess { costates: costates_0, quaternion, position, ..Guess::default() })
}

/// The largest size of a plan file, several times the size of a plan with a million steps and every
/// input that a spec allows.
const MOST_BYTES: u64 = 4 << 30;

/// An input that fails if it is longer than any plan: a pipe need not end.
pub(super) struct Bounded<R> {
    input: R,
    left: u64,
}

/// Returns the input behind its byte order mark.
pub(super) fn without_mark<R: Read>(input: R) -> io::Result<BufReader<Bounded<R>>> {
    let mut input = BufReader::new(Bounded::new(input));
    if input.fill_buf()?.starts_with(encoding::MARK) {
        input.consume(encoding::MARK.len());
    }
    Ok(input)
}

impl<R> Bounded<R> {
    fn new(input: R) -> Self {
        Self { input, left: MOST_BYTES }
    }
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        self.left = self.left.checked_sub(read as u64).ok_or_else(|| {
            io::Error::other(format!(
                "the input is longer than {} GiB: no plan has this size",
                MOST_BYTES >> 30
            ))
        })?;
        Ok(read)
    }
}

/// Writes a document. Each key of the two outer levels has its own line, so that two files can be
/// compared line by line. Arrays have no line breaks.
///
/// # Errors
/// Returns the errors of the stream.
pub fn write_document(document: &impl Serialize, output: impl Write) -> Result<(), ExportError> {
    let mut output = BufWriter::new(output);
    let formatter = KeyLines { depth: 0 };
    document.serialize(&mut serde_json::Serializer::with_formatter(&mut output, formatter))?;
    output.write_all(b"\n")?;
    Ok(output.flush()?)
}

struct KeyLines {
    depth: usize,
}

impl KeyLines {
    const DEEPEST: usize = 2;

    fn line<W: Write + ?Sized>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b"\n")?;
        (0..self.depth).try_for_each(|_| writer.write_all(b"  "))
    }
}

impl Formatter for KeyLines {
    fn begin_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        CompactFormatter.begin_object(writer)
    }

    fn end_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        if self.depth < Self::DEEPEST {
            self.line(writer)?;
        }
        CompactFormatter.end_object(writer)
    }

    fn begin_object_key<W: Write + ?Sized>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        CompactFormatter.begin_object_key(writer, first)?;
        if self.depth <= Self::DEEPEST { self.line(writer) } else { Ok(()) }
    }

    fn begin_object_value<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn begin_array<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        CompactFormatter.begin_array(writer)
    }

    fn end_array<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        CompactFormatter.end_array(writer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_without_end_is_given_up() {
        let endless = Bounded { input: io::repeat(b' '), left: 1000 };
        let error = serde_json::from_reader::<_, PlanFile>(endless).unwrap_err();
        assert!(error.is_io() && error.to_string().contains("no plan has this size"), "{error}");
        let exact = Bounded { input: &[b' '; 1000][..], left: 1000 };
        assert!(serde_json::from_reader::<_, PlanFile>(exact).unwrap_err().is_eof());
    }
}
