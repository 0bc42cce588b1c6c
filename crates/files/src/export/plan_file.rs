//! A plan as one JSON document, written and read as a stream.

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

/// A plan and the record of its search, with the keys in the order of the file.
///
/// Equal inputs give equal files, except for `solve_time_s`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanFile<'a> {
    /// Version of the file format, which is 2.
    pub format: u32,
    /// Name and version of the program that wrote the file.
    pub generator: String,
    /// Status of the plan.
    pub status: Status,
    /// Exit code of the program for this status.
    pub exit_code: u8,
    /// Name of the maneuver.
    pub name: String,
    /// Solution method: "shooting", "scp" (sequential convex programming) or "interior_point".
    pub method: String,
    /// Integration scheme: "lie_verlet" or "lie_euler".
    pub scheme: String,
    /// Number of steps.
    pub steps: usize,
    /// Duration of a step \[s\]; the mean if the steps differ.
    #[serde(deserialize_with = "null_is_nan")]
    pub step_s: f64,
    /// Cost of the plan: the value of the objective, plus the time weight times the duration if the
    /// spec has `time_price_per_s`.
    #[serde(deserialize_with = "null_is_nan")]
    pub cost: f64,
    /// Duration of the maneuver \[s\].
    #[serde(deserialize_with = "null_is_nan")]
    pub duration_s: f64,
    /// Number of Newton iterations from the initial guess that led to the plan.
    pub iterations: usize,
    /// Wall time of the solver without verification \[s\]. No other key differs between two runs.
    pub solve_time_s: f64,
    /// Outcome of the solver.
    pub outcome: Outcome,
    /// Name of the initial guess that led to the plan.
    pub start: String,
    /// Direction of rotation to the end attitude: the short or the long way.
    pub sense: Sense,
    /// Total angle turned \[deg\].
    #[serde(deserialize_with = "null_is_nan")]
    pub turned_deg: f64,
    /// Tolerance on the terminal error, in the scaled units of the solver.
    pub tolerance: f64,
    /// Error of the discrete motion at the end, relative to the target.
    #[serde(deserialize_with = "null_is_nan")]
    pub terminal: TerminalError,
    /// Corrections that landing made so that the continuous motion meets the target; absent if
    /// landing was not tried. The trajectory has the shifted target of the discrete motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub landing: Option<Landing>,
    /// Details of the choice of the number of steps; absent if the spec states this number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chosen: Option<ChosenSteps>,
    /// Optimality conditions that the plan satisfies, with their residuals.
    #[serde(deserialize_with = "null_is_nan")]
    pub optimality: Optimality,
    /// Degree to which the plan is proved to be an optimum; absent without a plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proof: Option<Proved>,
    /// Result of the second-order test, which counts conjugate points.
    pub second_order: SecondOrder,
    /// Results of the witnesses; `null` if the file has no trajectory.
    #[serde(deserialize_with = "null_is_nan")]
    pub verified: Option<Verification>,
    /// Terminal error of the continuous motion under the recorded torques, and the number of steps
    /// with which this error would meet the tolerance.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "null_is_nan")]
    pub accuracy: Option<Accuracy>,
    /// Reports on all solution strategies that were tried, in order.
    #[serde(deserialize_with = "null_is_nan")]
    pub ladder: Vec<RungReport>,
    /// Amount of work of the sequential convex programming; absent if it did not run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub convex: Option<ConvexRecord>,
    /// Amount of work of the interior-point method; absent if another method found the plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interior_point: Option<InteriorWork>,
    /// Limits and constraints that are active along the plan, with their times and multipliers.
    #[serde(default, deserialize_with = "null_is_nan")]
    pub active: Vec<ActiveConstraint>,
    /// Arcs, switching times and optimality certificate, if time or fuel is minimised.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "null_is_nan")]
    pub switching: Option<Switching>,
    /// Other extremals that the search found.
    #[serde(deserialize_with = "null_is_nan")]
    pub rivals: Vec<Rival>,
    /// Feedback gains along the plan, if `[feedback]` requests them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feedback: Option<FeedbackRecord>,
    /// Covariances along the plan; absent if the spec has no `[uncertainty]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyRecord>,
    /// Statement that proves that no input can meet the terminal conditions, if the program found
    /// such a proof.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstruction: Option<String>,
    /// Proved lower bound on the duration \[s\]: no plan is shorter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest_duration_s: Option<f64>,
    /// Constraint violations of the best iterate, and possible remedies; present if no plan was
    /// found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortfall: Option<String>,
    /// Shortest duration for which a plan was found \[s\], a local minimum; present if no plan was
    /// found for the requested duration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest_found_s: Option<f64>,
    /// A duration longer than the requested one for which a plan exists \[s\]: a plan was found for
    /// it, or it suffices for a turn about a fixed axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longer_s: Option<f64>,
    /// Spec of the maneuver on the grid of the plan, with the settings of the solver; `null` if a
    /// spec cannot express the maneuver.
    #[serde(default)]
    pub spec: Option<SpecDocument>,
    /// Costates at the start, in SI units. They are the unknowns of the shooting method, and serve
    /// as an initial guess for other plans.
    pub costates_0: Vec<f64>,
    /// Trajectory of the plan.
    pub trajectory: TrajectoryDocument<'a>,
    /// Result of comparing the contents with the checksum, which is the last key of the file.
    #[serde(default, rename = "checksum", skip_serializing)]
    pub seal: Seal,
}

/// Amount of work of the sequential convex programming. The wall time is not included, because it
/// differs between two runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConvexRecord {
    /// Number of convex subproblems, on all grids, from the initial guess that led to the plan.
    pub subproblems: usize,
    /// Number of convex subproblems from all initial guesses.
    pub all_subproblems: usize,
    /// Number of interior-point iterations of the cone solver in all subproblems.
    pub cone_iterations: u32,
}

impl From<&ConvexWork> for ConvexRecord {
    fn from(work: &ConvexWork) -> Self {
        let ConvexWork { subproblems, all_subproblems, cone_iterations, .. } = *work;
        Self { subproblems, all_subproblems, cone_iterations }
    }
}

impl<'a> PlanFile<'a> {
    /// Version of the plan file format that this program writes.
    pub const FORMAT: u32 = 2;
    /// Name and version of this program.
    pub const GENERATOR: &'static str = concat!("slewkit ", env!("CARGO_PKG_VERSION"));

    /// Creates the document of a plan; it borrows the trajectory.
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

    /// Adds the names and the epoch of the maneuver to the spec in the file.
    pub fn with_identity(mut self, identity: &Identity) -> Self {
        self.spec = self.spec.map(|spec| spec.with_identity(identity));
        self
    }

    /// Adds the gains, covariances and margins along the plan, and the tables of the spec that
    /// request them.
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

    /// Adds gains along the plan, without a covariance, and the tables of the spec that request
    /// them.
    pub fn with_gains(mut self, problem: &Problem, gains: &Gains, closed_loop: &ClosedLoop) -> Self {
        self.spec = self.spec.map(|spec| spec.with_closed_loop(closed_loop));
        self.feedback = Some(FeedbackRecord::of_gains(problem, gains));
        self
    }

    /// Adds the gains and covariances from another file of the same plan, and the tables of the
    /// spec that request them.
    pub fn with_records(
        mut self,
        feedback: Option<FeedbackRecord>,
        uncertainty: Option<UncertaintyRecord>,
        closed_loop: &ClosedLoop,
    ) -> Self {
        self.spec = self.spec.map(|spec| spec.with_closed_loop(closed_loop));
        Self { feedback, uncertainty, ..self }
    }

    /// Writes the document with its checksum and a final newline; each key is on its own line.
    ///
    /// # Errors
    /// Returns an error if the trajectory has a number that is not finite, or if the stream fails.
    pub fn write(&self, output: impl Write) -> Result<(), ExportError> {
        super::columns::check_finite(&self.trajectory.0)?;
        write_document(&Sealed::new(self)?, output)
    }

    /// Reads a document and compares it with its checksum. A trajectory whose length does not agree
    /// with `steps` is an error.
    ///
    /// # Errors
    /// Returns an error if the stream fails, if the text is not a plan, or if the lengths of the
    /// arrays are inconsistent.
    pub fn read(input: impl Read) -> Result<PlanFile<'static>, ExportError> {
        let mut input = without_mark(input)?;
        if is_of_sequence(input.fill_buf()?) {
            return Err(ExportError::Sequence);
        }
        PlanFile::checked(serde_json::from_reader(input)?)
    }

    /// Checks the contents of a file against its checksum.
    pub(super) fn checked(mut file: PlanFile<'static>) -> Result<PlanFile<'static>, ExportError> {
        if file.format != Self::FORMAT {
            return Err(ExportError::Format { found: file.format });
        }
        // The checksum also covers the spec. If the spec was removed, the checksum cannot be
        // checked.
        let own = file.generator == Self::GENERATOR && file.spec.is_some();
        file.seal = file.seal.compared(&file, own);
        Ok(file)
    }

    /// Returns true if a text that begins with these bytes is a plan file, and false if it is a
    /// message or table with attitudes. Returns true also for an empty text or binary data, so that
    /// the reader of plan files reports the error.
    pub fn begins(text: &[u8]) -> bool {
        // The reader of attitudes reports the error for a file that is not text.
        if encoding::is_utf16(text) || encoding::binary(text).is_some() {
            return false;
        }
        let text = text.strip_prefix(encoding::MARK).unwrap_or(text);
        let first = text.iter().find(|byte| !byte.is_ascii_whitespace()).copied();
        first.is_none_or(|first| matches!(first, b'{' | b'[') || !(first.is_ascii_graphic() || first >= 0x80))
    }

    /// Returns the integration scheme of the plan; `None` if its name is unknown.
    pub fn scheme(&self) -> Option<Scheme> {
        [Scheme::LieEuler, Scheme::LieVerlet].into_iter().find(|scheme| scheme.name() == self.scheme)
    }

    /// Returns `problem` on the grid of this plan. The trajectory must fit the problem.
    ///
    /// # Errors
    /// Returns an error that names an array of wrong length, or [`ExportError::NoMotion`] if the
    /// file has no trajectory.
    pub fn on_grid(&self, problem: &Problem) -> Result<Problem, ExportError> {
        let scheme = self.scheme().ok_or_else(|| ExportError::Scheme(self.scheme.clone()))?;
        let steps = self.steps;
        // A minimum-time plan has no steps if the body is already in the requested terminal state.
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

/// First key of the plan file of a sequence.
const SEQUENCE: &[u8] = b"\"sequence_format\":";

/// Returns whether a text that begins with these bytes is the plan file of a sequence.
pub(super) fn is_of_sequence(text: &[u8]) -> bool {
    text.windows(SEQUENCE.len()).any(|part| part == SEQUENCE)
}

/// Reads an initial guess from a plan file: its costates at the start, and the poses along its
/// trajectory.
///
/// # Errors
/// Returns an error if the stream fails, if the text is not a plan, or if the file has an unknown
/// version of the format.
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
    // In files of older versions, the trajectory has the same structure.
    if !(1..=PlanFile::FORMAT).contains(&format) {
        return Err(ExportError::Format { found: format });
    }
    let Path { quaternion_wxyz: quaternion, position_m } = trajectory;
    let position = position_m.into_iter().map(Vector3::from).collect();
    Ok(Guess { costates: costates_0, quaternion, position, ..Guess::default() })
}

/// Largest size of a plan file that is read \[bytes\]. A plan with a million steps and all inputs
/// that a spec allows is several times smaller.
const MOST_BYTES: u64 = 4 << 30;

/// A reader that returns an error beyond the largest size of a plan file, because a pipe may be
/// endless.
pub(super) struct Bounded<R> {
    input: R,
    left: u64,
}

/// Returns a reader of the input that skips the byte order mark.
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

/// Writes a JSON document. Each key of the two outermost levels has its own line, so that two files
/// can be compared line by line. Arrays have no line breaks.
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
